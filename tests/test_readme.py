"""The README's words hold: its example prints what stands under it, its scene loads, its files exist."""

import contextlib
import doctest
import io
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.cli import run
from firstcontact.io.meshes import read_mesh

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language):
    (found,) = re.findall(rf"```{language}\n(.*?)```", TEXT, flags=re.DOTALL)
    return found


def test_the_example_prints_what_the_readme_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block("python"), "README.md", "exec"), {})
    assert printed.getvalue() == block("text")


def test_the_session_on_curved_solids_prints_what_it_says():
    session = doctest.DocTestParser().get_doctest(block("pycon"), {"fc": fc}, "README", "README.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 5


def test_the_session_on_objects_prints_what_it_says():
    session = doctest.DocTestParser().get_doctest(block("python console"), {"fc": fc}, "README", "README.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 2


def test_the_session_on_many_questions_prints_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    session = doctest.DocTestParser().get_doctest(block("python batch"), {"fc": fc}, "README", "README.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 7


def test_the_main_command_gives_the_same_answer(capsys):
    assert run(["check", str(ROOT / "examples" / "lid.toml")]) == 1
    *answer, moved = capsys.readouterr().out.splitlines()
    assert block("text").splitlines()[:2] == answer
    assert moved == "  lid has turned 86.9962 of 100 degrees: time is the share of the motion that is done, from 0 to 1"


def test_the_scene_runs(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(block("toml").replace('file = "', f'file = "{ROOT}/examples/'))
    assert run(["check", str(path)]) == 1
    assert capsys.readouterr().out.startswith("lid and box: CONTACT at time 2.7399243754625")


def test_every_file_it_names_exists():
    for name in re.findall(r"\]\(([^)]+)\)", TEXT) + re.findall(r"examples/[\w.]+\w", TEXT):
        assert (ROOT / name).exists(), name
    for name in re.findall(r"`(\w+\.toml)`", TEXT):
        assert (ROOT / "examples" / name).exists(), name


SCENES = {"lid.toml": 1, "gears.toml": 1, "cubes.toml": 1, "lift.toml": 0, "plunger.toml": 1, "roof.toml": 1,
          "drawer.toml": 1}
COMMANDS = {**{name: ("check", code) for name, code in SCENES.items()},
            "cone.toml": ("curve", 0), "roller.toml": ("intervals", 1), "door.toml": ("sweep", 1)}  # fmt: skip

CELL = "desk.toml"  # of a robot, run in tests/mechanism/test_docs.py
SETUP = "setup.toml"  # of a tool path, run in tests/toolpath/test_docs.py
STEP = "hinge.toml"  # needs the extra "step"


def test_no_example_is_left_out():
    assert {path.name for path in (ROOT / "examples").glob("*.toml")} == {*COMMANDS, CELL, SETUP, STEP}


def test_two_parts_on_a_hinge_jam_where_the_readme_says(tmp_path, monkeypatch, capsys):
    pytest.importorskip("OCP", reason='needs the extra "step"')
    monkeypatch.chdir(ROOT)
    page = tmp_path / "hinge.html"
    assert run(["check", f"examples/{STEP}", "--html", str(page)]) == 1
    told = capsys.readouterr().out.splitlines()
    said = TEXT.split("examples/hinge.toml --html hinge.html\n", 1)[1].splitlines()[: len(told)]
    assert said == [f"    {line}" for line in told] and len(told) == 4
    assert page.stat().st_size > 100_000


@pytest.mark.share(4)
@pytest.mark.parametrize("name", COMMANDS)
def test_examples_end_as_announced(name, capsys):
    command, code = COMMANDS[name]
    assert run([command, str(ROOT / "examples" / name)]) == code
    if name == "roller.toml":
        head, interval, start, end = capsys.readouterr().out.splitlines()
        assert (head, interval) == ("roller and pipe: CONTACT", "  [-sqrt(2)/2, sqrt(2)/2]")
        assert start.split(": ")[1].startswith("root of 2 x^2 - 1 in") and "2 x^2 - 1" in end


def test_the_meshes_are_those_of_make_meshes(tmp_path):
    make = runpy.run_path(str(ROOT / "examples" / "make_meshes.py"))
    make["main"](tmp_path)
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == ["box.stl", "gear12.ply", "gear20.ply", "lid.stl"]
    for name in made:
        vertices, triangles = read_mesh(tmp_path / name)
        committed_vertices, committed_triangles = read_mesh(ROOT / "examples" / name)
        assert np.array_equal(triangles, committed_triangles)
        assert np.allclose(vertices, committed_vertices, rtol=0, atol=1e-6)  # float32, other maths libraries
