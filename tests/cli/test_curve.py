"""`firstcontact curve`: what it prints, writes and returns."""

import json
import re
import time
from fractions import Fraction
from pathlib import Path

import pytest

from firstcontact import query
from firstcontact.cli import progress
from firstcontact.scene.load import load_scene

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LOW = '[body.low]\nshape = "ruled"\nfirst = "(u, 0, 0)"\nsecond = "(u, 1, u)"\n'
FLAT = '[body.flat]\nshape = "ruled"\nfirst = "(u, 0, 1/2)"\nsecond = "(u, 1, 1/2)"\n'
RISE = '[body.flat.motion]\ntype = "translation"\nvector = [0, 0, 2]\n'


def test_the_curve_of_the_cone_and_the_wave(command):
    code, out, err = command("curve", EXAMPLES / "cone.toml")
    lines = out.splitlines()
    assert code == 0 and err == ""
    assert lines[0] == "cone and wave: 3 branches"
    heads = [line.split(" of ")[0].strip() for line in lines if " branch of " in line]
    assert heads == ["open branch", "open branch", "closed branch"]
    assert sum(line.startswith("    from infinity at (-2.8") for line in lines) == 2
    assert lines[-2].endswith("length 16.9954") and lines[-1].startswith("    through (") and "u = " in lines[-1]


def test_ends_are_exact_in_json(command):
    code, out, _ = command("curve", EXAMPLES / "roller.toml", "--tolerance", "1e-3", "--json", "-")
    document = json.loads(out)
    assert code == 0 and document["schema"] == 1
    (entry,) = document["checks"]
    (branch,) = entry["branches"]
    assert (entry["a"], entry["b"], entry["two_dimensional"], branch["closed"]) == ("roller", "pipe", False, False)
    assert [end["on"] for end in branch["ends"]] == [["t=0"], ["t=0"]]
    assert {end["v"].split(" in ")[0] for end in branch["ends"]} == {"root of 3 x^2 - 1"}
    assert len(branch["points"]) < 100 and branch["length"] == pytest.approx(2.3719, abs=1e-3)


def test_options_win_over_the_scene(command):
    out = command("curve", EXAMPLES / "roller.toml", "--at", "1").out
    assert out == "roller and pipe: no common point; proved\n"
    out = command("curve", EXAMPLES / "cone.toml", *"--box -2 -3 -3 5 3 3 --tolerance 1/100".split()).out
    assert out.splitlines()[0] == "cone and wave: 1 branch in the box from (-2, -3, -3) to (5, 3, 3)"


def test_the_scene_asks(command, scene):
    questions = '[[curve]]\npair = ["low", "flat"]\nat = 0\nbox = [[0, 0, 0], ["3/4", 1, 1]]\n'
    path = scene(LOW + FLAT + RISE + questions + '[[curve]]\npair = ["flat", "low"]\nat = "1/4"\n')
    first, second = load_scene(path).curves
    assert (first.at, first.tolerance, second.at) == (0, 1e-6, Fraction(1, 4))
    lines = command("curve", path).out.splitlines()
    place, parameters = "(0.75, 0.666666667, 0.5)", "u = 0.75, v = 0.75, s = 0.666666667, t = 0.666666667"
    assert lines[3] == f"    to boundary (x=3/4) at {place}, {parameters}"
    assert lines[4:] == ["flat and low: 1 isolated point", "  isolated point (1, 1, 1)"]
    assert load_scene(scene(LOW + FLAT)).curves[0].a == "low"  # without tables: what is checked


def test_the_scene_of_the_docs(command, scene):
    text = (EXAMPLES.parent / "docs" / "ruled-surfaces.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```toml\n(.*?)```", text, flags=re.DOTALL)
    code, out, _ = command("curve", scene(block), "--tolerance", "1e-3")
    assert code == 0 and out.startswith("cone and sheet: 1 branch\n  closed branch of ")


FAULTS = {
    "a moving surface": (RISE, [], "flat moves; say at which time by --at T, or by the key at in [[curve]]"),
    "a deforming surface": (FLAT.replace("flat", "open").replace("1/2", "T"), [], "open deforms; say at which time"),
    "a tolerance of nothing": ("", ["--tolerance", "0"], "tolerance is 0; give a positive length"),
    "a word as tolerance": ("", ["--tolerance", "fine"], "--tolerance: 'fine' is not a number"),
    "half a box": ("", ["--box", "0", "0", "0"], "--box"),
    "a box inside out": ("", "--box 0 0 0 1 -1 1".split(), "the first below the second"),
    "an unknown method": ("", ["--method", "guess"], "method 'guess' is unknown"),
    "two solids": (
        '[body.p]\nshape = "sphere"\nradius = 1\n[body.q]\nshape = "sphere"\nradius = 1\n', [], "curve p / q: "),
    "a pair that is not there": ('[[curve]]\npair = ["low", "hat"]\n', [], "curve[0].pair: no body 'hat'"),
    "an unknown key": ('[[curve]]\npair = ["low", "flat"]\ntolerances = 1\n', [], "unknown key 'tolerances'"),
    "a box of one corner": ('[[curve]]\npair = ["low", "flat"]\nbox = [[0, 0, 0]]\n', [], "curve[0].box"),
    "html into nowhere": ("", ["--html", "/none/x.html"], "x.html: cannot be written"),
}


@pytest.mark.parametrize("case", FAULTS)
def test_bad_input_is_one_line_and_3(command, scene, case):
    more, options, says = FAULTS[case]
    code, out, err = command("curve", scene(LOW + FLAT + more), *options)
    decided = {"a deforming surface": 1, "two solids": 5}.get(case, 0)  # pairs before the one at fault are told
    assert len(re.findall(r"^\w", out, re.MULTILINE)) == decided
    assert code == 3 and err.count("\n") == 1 and says in err


def test_a_page_holds_the_layers(command, scene, tmp_path):
    page = tmp_path / "page.html"
    assert command("curve", scene(LOW + FLAT), "--html", page).code == 0
    text = page.read_text(encoding="utf-8")
    assert "component 1, open" in text and '"status": "CURVE"' in text


def test_an_interrupt_returns_130(command, scene, monkeypatch):
    def interrupted(*arguments, **keywords):
        raise KeyboardInterrupt

    monkeypatch.setattr(query, "intersection_curve", interrupted)
    code, out, err = command("curve", scene(LOW + FLAT))
    assert code == 130 and out == "" and err == "firstcontact: interrupted; 0 of 1 decided; low / flat\n"


def test_progress_appears_on_stderr_after_a_while(command, scene, monkeypatch):
    path = scene(LOW + FLAT)
    assert command("curve", path, "--progress").err == ""
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    answer = query.intersection_curve

    def slow(*arguments, **keywords):
        time.sleep(0.05)
        return answer(*arguments, **keywords)

    monkeypatch.setattr(query, "intersection_curve", slow)
    code, out, err = command("curve", path, "--progress", "--json", "-")
    assert code == 0 and "low / flat" in err
    json.loads(out)
    assert command("curve", path, "--no-progress").err == "" == command("curve", path).err
