"""`firstcontact check`: what it prints, writes and returns."""

import json

import pytest

import firstcontact as fc
from firstcontact import query
from firstcontact.cli import progress

CHECK = '[[check]]\npair = ["left", "right"]\n'


def test_contact_is_two_lines_and_returns_1(command, cubes):
    code, out, err = command("check", cubes("1.1"))
    assert code == 1 and err.count("\n") <= 1
    assert len(out.splitlines()) == 3 and out.startswith("left and right: CONTACT at time 0.3333333333333333")


def test_free_returns_0(command, cubes):
    code, out, _ = command("check", cubes("1.5"))
    assert code == 0 and out.startswith("left and right: FREE")


def test_undecided_returns_2_unless_another_pair_touches(command, cubes, scene):
    undecided = CHECK + "budget = 1\n"
    code, out, _ = command("check", cubes("1.1", undecided))
    assert code == 2 and "UNDECIDED (budget)" in out
    code, out, _ = command("check", cubes("1.1", undecided + CHECK))
    assert code == 1 and "UNDECIDED" in out and "CONTACT" in out


def test_contact_at_the_start_returns_1(command, cubes):
    code, out, _ = command("check", cubes("1"))
    assert code == 1 and "INITIAL_CONTACT (touching)" in out


def test_span_shortens_and_lengthens(command, cubes):
    assert command("check", cubes("1.1"), "--span", "0", "0.25").code == 0
    assert command("check", cubes("1.5"), "--span", "-1", "inf").code == 1
    assert command("check", cubes("1.1"), "--span", "0", "1/3").code == 1


def test_exact_gives_the_fraction(command, cubes):
    out = command("check", cubes("1.1"), "--exact", "--json", "-").out
    assert json.loads(out)["checks"][0]["time_exact"] == "1/3"
    out = command("check", cubes("1.1", CHECK + "exact = true\n"), "--json", "-").out
    assert json.loads(out)["checks"][0]["time_exact"] == "1/3"


def test_json_alone_goes_to_stdout(command, cubes):
    code, out, _ = command("check", cubes("1.1"), "--json", "-")
    document = json.loads(out)
    assert code == 1 and document["schema"] == 1 and document["version"] == fc.__version__
    (entry,) = document["checks"]
    assert (entry["a"], entry["b"], entry["status"]) == ("left", "right", "CONTACT")
    lo, hi = entry["time_interval"]
    assert lo <= entry["time"] <= hi and hi - lo <= 1e-12
    expected = {"time_exact", "point", "normal", "element_a", "element_b", "initial", "contact_set", "stats"}
    assert expected <= set(entry)


def test_json_has_no_bare_infinities(command, cubes):
    out = command("check", cubes("0.5"), "--span", "6", "inf", "--json", "-").out
    json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def test_json_and_html_files(command, cubes, tmp_path):
    report, page = tmp_path / "report.json", tmp_path / "page.html"
    code, out, _ = command("check", cubes("1.1"), "--json", report, "--html", page)
    assert code == 1 and "CONTACT" in out
    assert json.loads(report.read_text())["checks"][0]["status"] == "CONTACT"
    assert "<html" in page.read_text(encoding="utf-8")


def test_png_shows_the_first_contact_of_the_scene(command, cubes, tmp_path, monkeypatch):
    from firstcontact.view import png

    drawn = []
    monkeypatch.setattr(png, "write_png", lambda path, result: drawn.append((path, result.status.name)))
    undecided_then_contact = CHECK + "span = [0, 0.1]\n" + CHECK
    command("check", cubes("1.1", undecided_then_contact), "--png", tmp_path / "hit.png")
    assert drawn == [(tmp_path / "hit.png", "CONTACT")]


def test_an_unsupported_pair_names_the_scene_and_the_pair(command, cubes, scene):
    turn = '[body.right.motion]\ntype = "rotation"\naxis = [0, 0, 1]\ndegrees = 90\n'
    code, out, err = command("check", cubes("1.5", turn), "--exact")  # a spiral has no exact times
    assert code == 3 and out == "" and err.count("\n") == 1
    assert "scene.toml: check left / right: " in err


def test_a_span_outside_a_sequence_is_named(command, cubes):
    path = cubes("1.5")
    step = '{type = "translation", vector = [1, 0, 0]}'
    text = path.read_text().replace('type = "translation"', f'type = "sequence"\nsteps = [{step}]')
    path.write_text(text.replace('vector = ["3/10", 0, 0]', ""))
    code, _, err = command("check", path, "--span", "0", "2")
    assert code == 3 and err.count("\n") == 1 and "check left / right: " in err


def test_an_interrupt_returns_130(command, cubes, monkeypatch):
    def interrupted(*arguments, **keywords):
        raise KeyboardInterrupt

    monkeypatch.setattr(query, "first_contact", interrupted)
    code, out, err = command("check", cubes("1.1"))
    assert code == 130 and out == "" and err == "firstcontact: interrupted; 0 of 1 decided; left / right\n"


def test_progress_appears_on_stderr_after_a_while(command, cubes, monkeypatch):
    quick = command("check", cubes("1.1"), "--progress").err
    assert "free until" not in quick
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    answer = query.first_contact

    def slow(*arguments, progress, **keywords):
        progress(0.125, 4321)
        return answer(*arguments, progress=progress, **keywords)

    monkeypatch.setattr(query, "first_contact", slow)
    code, out, err = command("check", cubes("1.1"), "--progress", "--json", "-")
    assert code == 1 and "left / right: free until 0.125, 4,321 steps" in err
    json.loads(out)
    assert "steps" not in command("check", cubes("1.1"), "--no-progress").err
    assert "steps" not in command("check", cubes("1.1")).err  # stderr is no terminal here
