"""Careless and hostile use of the command: one line on stderr, the right exit code, never a traceback."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import firstcontact
from firstcontact.cli import run

SOURCE = Path(firstcontact.__file__).parents[1]
BALL = 'shape = "sphere"\nradius = 1\n'
BALLS = f"[body.a]\n{BALL}[body.b]\n{BALL}at = [0, 0, 5]\n"
SLIDE = '[body.a.motion]\ntype = "translation"\nvector = [0, 0, 6]\n'
STEP = '{ type = "translation", vector = [0, 0, 6] }'
CHECK = '[[check]]\npair = ["a", "b"]\n'
MESH = '[body.a]\nshape = "mesh"\nfile = "%s"\n[body.b]\n' + BALL
DEEP = ".".join(["part.p"] * 2000)


def ball(**keys):
    """The scene with other numbers in its first ball."""
    table = {"shape": '"sphere"', "radius": "1"} | keys
    return "[body.a]\n" + "".join(f"{k} = {v}\n" for k, v in table.items()) + f"[body.b]\n{BALL}"


# Name, text of the scene, and what the line says beside the scene's name.
SCENES = {
    "nothing": ("", "body: missing; add this key"),
    "no table": ("body = 5", "body"),
    "an empty body": ("[body.a]", "body.a: key 'shape' is missing"),
    "parts 2000 deep": (f'[body.a]\nshape = "csg"\nexpression = "p"\n[body.a.{DEEP}]\n{BALL}', "more than 100 deep"),
    "a list 3000 deep": (ball(at="[" * 3000 + "]" * 3000), "more than 100 deep, perhaps in line 4"),
    "a list 200 deep": (ball(at="[" * 200 + "]" * 200), "more than 100 deep, perhaps in line 4"),
    "inline tables 500 deep": (ball(at="{a = " * 500 + "1" + "}" * 500), "more than 100 deep"),
    "an integer of 5000 digits": (ball(radius="7" * 5000), "line 3: a number of more than 4000 digits"),
    "an integer of 4100 digits": (ball(radius="7" * 4100), "body.a.radius"),
    "a string of 5000 digits": (ball(radius=f'"{"7" * 5000}"'), "body.a.radius"),
    "a fraction of 5000 digits": (ball(radius=f'"1/{"7" * 5000}"'), "body.a.radius"),
    "a float of 5000 digits": (ball(radius=f"{'7' * 5000}.5"), "body.a.radius"),
    "a hexadecimal giant": (ball(radius="0x" + "f" * 9000), "body.a.radius"),
    "a radius of 1e-300": (ball(radius="1e-300"), "body.a: sphere radius is 1e-300; give a number of 2^-150 at least"),
    "a quoted radius of 1e-300": (ball(radius='"1e-300"'), "body.a: sphere radius"),
    "a radius of 1e400": (ball(radius='"1e400"'), "body.a.radius: '1e400' is not a finite double"),
    "an endless exponent": (ball(radius='"1e99999999"'), "body.a.radius"),
    "a radius of nan": (ball(radius="nan"), "body.a.radius: nan is not a finite double"),
    "a radius of inf": (ball(radius="inf"), "body.a.radius: inf is not a finite double"),
    "a date as radius": (ball(radius="2026-01-01"), "body.a.radius"),
    "true as radius": (ball(radius="true"), "body.a.radius: True is not a number"),
    "a table as radius": (ball(radius="{ a = 1 }"), "body.a.radius"),
    "a name of 5000 letters as shape": (ball(shape=f'"{"x" * 5000}"'), "body.a: shape"),
    "an unknown key of 5000 letters": (ball(**{"x" * 5000: "1"}), "body.a: unknown key"),
    "a name twice": (BALLS.replace("at =", 'name = "a"\nat ='), "body.b: its name 'a' is that of body.a, too"),
    "a name of two lines": (BALLS.replace("body.b", r'body."x\ny"'), r"no name to tell is 'x\ny'"),
    "no letters as name": (BALLS.replace("body.b", 'body.""'), "no name to tell is ''"),
    "a number as name": (ball(name="5"), "body.a.name"),
    "a turn about nothing": (ball(rotate="{ axis = [0, 0, 0], degrees = 1 }"), "body.a.rotate: rotation axis is zero"),
    "a place of two numbers": (ball(at="[1, 2]"), "body.a.at: [1, 2] is not three numbers"),
    "a place of a million numbers": (ball(at=f"[{'1,' * 10**5}]"), "body.a.at"),
    "a mesh name of 5000 letters": (MESH % ("x" * 5000 + ".stl"), "body.a: "),
    "a mesh name with a null": (MESH % "a\\u0000b.stl", "body.a: "),
    "a mesh that is a STEP file": (MESH % "part.stp", "body.a: "),
    "a mesh without a name": (MESH % "", "body.a: "),
    "a budget of 30 digits": (BALLS + SLIDE + CHECK + "budget = " + "9" * 30, "check[0].budget"),
    "a budget of half": (BALLS + SLIDE + CHECK + "budget = 0.5", "check[0].budget"),
    "no budget": (BALLS + SLIDE + CHECK + "budget = 0", "check[0].budget"),
    "an infinite tolerance": (BALLS + SLIDE + CHECK + "tolerance = inf", "check[0].tolerance"),
    "a tolerance of 1e-400": (BALLS + SLIDE + CHECK + 'tolerance = "1e-400"', "check[0].tolerance"),
    "a span to 1e400": (BALLS + SLIDE + CHECK + 'span = [0, "1e400"]', "check[0].span[1]"),
    "a span to 1e300": (BALLS + SLIDE + CHECK + "span = [0, 1e300]", "check a / b: span end is 1e+300"),
    "a span of nan": (BALLS + SLIDE + CHECK + "span = [0, nan]", "check[0].span[1]"),
    "a span that runs back": (BALLS + SLIDE + CHECK + "span = [1, 0]", "check a / b: span is (1, 0)"),
    "a pair of one": (BALLS + '[[check]]\npair = ["a", "a"]', "check[0].pair"),
    "a pair of strangers": (BALLS + '[[check]]\npair = ["a", "z"]', "check[0].pair: no body 'z'"),
    "checks that are no list": (BALLS + '[check]\npair = ["a", "b"]', "check: [check] is one table of a list"),
    "an expression 5000 deep": ('[body.a]\nshape = "csg"\nexpression = "' + "(" * 5000 + '"', "body.a.expression"),
    "an expression that calls": ('[body.a]\nshape = "csg"\nexpression = "exit()"', "body.a.expression"),
    "a directrix of powers": (
        '[body.a]\nshape = "ruled"\nfirst = "(9**9**9, 0, 0)"\nsecond = "(u, 1, 0)"', "body.a: a: first"
    ),
    "a trim of powers": (
        '[body.a]\nshape = "ruled"\nfirst = "(u, 0, 0)"\nsecond = "(u, 1, 0)"\ntrim = ["u**9**9**9 <= 1"]', "a: trim[0]"
    ),
    "a control point that is no list": ('[body.a]\nshape = "ruled"\npoints = [[5]]', "body.a.points[0][0]"),
    "a face of words": ('[body.a]\nshape = "polyhedron"\nvertices = [[0, 0, 0]]\nfaces = ["a"]', "body.a.faces[0]"),
    "a vertex that is not there": (
        '[body.a]\nshape = "polyhedron"\nvertices = [[0, 0, 0]]\nfaces = [[0, 1, 99999999999999999999]]', "body.a: "
    ),
    "a giant vertex": ('[body.a]\nshape = "polyhedron"\nvertices = [[0, 0, 1e300]]', "body.a: a: vertex 0"),
    "a motion of a motion": (BALLS + '[body.a.motion]\ntype = "fly"', "body.a.motion: type 'fly' is not supported"),
    "a motion by nan": (BALLS + SLIDE.replace("6", "nan"), "body.a.motion.vector[2]"),
    "a motion by 1e300": (BALLS + SLIDE.replace("6", "1e300"), "body.a.motion: Translation vector[2]"),
    "two angles": (
        BALLS + '[body.a.motion]\ntype = "rotation"\naxis = [0, 0, 1]\ndegrees = 1\nturns = 1', "exactly one of"
    ),
    "a sequence of nothing": (BALLS + '[body.a.motion]\ntype = "sequence"\nsteps = []', "body.a.motion: Sequence"),
    "a pose that is flat": (
        BALLS + '[body.a.motion]\ntype = "trajectory"\ntimes = [0, 1]\nposes = [[1, 2], [3]]', "body.a.motion.poses[0]"
    ),
    "broken TOML": ("[body.a\n", "not valid TOML"),
    "a key twice": ("[body.a]\n[body.a]\n", "not valid TOML"),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_a_bad_scene_is_one_line_that_names_the_place(scene, capsys, name):
    text, says = SCENES[name]
    path = scene(text)
    assert run(["check", str(path)]) == 3
    out, err = capsys.readouterr()
    lines = [line for line in err.splitlines() if "kernels" not in line and "nothing that is checked moves" not in line]
    assert out == "" and len(lines) == 1 and lines[0].startswith(f"firstcontact: {path}: ") and says in lines[0]
    assert len(lines[0]) < 2100


def test_windows_writes_a_mark_before_a_scene(tmp_path, capsys):
    """Notepad's UTF-8 begins with U+FEFF and ends lines by two letters."""
    path = tmp_path / "scene.toml"
    path.write_bytes((BALLS + SLIDE).replace("\n", "\r\n").encode("utf-8-sig"))
    assert run(["check", str(path)]) == 1 and "a and b: CONTACT at" in capsys.readouterr().out


LONG = "x" * 5000
USAGE = {
    "a scene with a long name": (["check", LONG], "xxx: file name too long; give the path of a scene"),
    "a mesh with a long name": (["info", LONG + ".stl"], "file name too long"),
    "a command with a long name": ([LONG], "No such command"),
    "an option with a long name": (["check", "SCENE", "--" + LONG], "No such option"),
    "a page with a long name": (["check", "SCENE", "--html", LONG], "cannot be written"),
    "JSON with a long name": (["check", "SCENE", "--json", LONG], "xxx: cannot be written"),
    "a picture with a long folder": (["check", "SCENE", "--png", LONG + "/x.png"], "cannot be written"),
    "JSON on a full disk": (["check", "SCENE", "--json", "/dev/full"], "/dev/full: no space left on device"),
    "a page on a full disk": (["check", "SCENE", "--html", "/dev/full"], "/dev/full: no space left on device"),
    "a span of 5000 digits": (["check", "SCENE", "--span", "0", "7" * 5000], "--span: "),
    "a span to 1e400": (["check", "SCENE", "--span", "0", "1e400"], "--span: '1e400' is not a finite double"),
    "a span to 1e300": (["intervals", "SCENE", "--span", "0", "1e300"], "span end is"),
    "a span of words": (["intervals", "SCENE", "--span", "now", "then"], "--span: 'now' is not a number"),
    "a span from for ever": (["check", "SCENE", "--span", "-inf", "0"], "span start is -inf"),
    "a tolerance of inf": (["curve", "SCENE", "--tolerance", "inf"], "--tolerance: 'inf' is not a number"),
    "a tolerance of 1e-400": (["curve", "SCENE", "--at", "0", "--tolerance", "1e-400"], "--tolerance is 1/1000"),
    "a box of 1e400": (["curve", "SCENE", "--box", *"000111"[:5], "1e400"], "--box: '1e400'"),
    "a time of words": (["curve", "SCENE", "--at", "noon"], "--at: 'noon' is not a number"),
    "curves of solids": (["curve", "SCENE", "--at", "0"], "curve a / b"),
    "one mesh": (["check", "lid.stl"], "lid.stl: is one mesh: name another one, too, or a scene"),
    "a part": (["intervals", "as1.STEP"], 'as1.STEP: is one STEP file: name another one, too, or a scene'),
    "a span that leaves the motion's": (["check", "SEQUENCE", "--span", "0", "2"], "span (0, 2) leaves the span"),
    "info of nothing": (["info", ""], "unknown mesh format ''"),
    "info of a device": (["info", "/dev/null"], "/dev/null: unknown mesh format ''"),
    "a scene of nulls": (["check", "/dev/null"], "/dev/null: body: missing"),
}


@pytest.mark.parametrize("name", USAGE)
def test_bad_usage_is_one_line_that_names_the_argument(scene, capsys, name):
    arguments, says = USAGE[name]
    steps = SLIDE.replace('"translation"', '"sequence"').replace("vector = [0, 0, 6]", f"steps = [{STEP}]")
    path = str(scene(BALLS + (steps if "SEQUENCE" in arguments else SLIDE)))
    assert run([path if argument in ("SCENE", "SEQUENCE") else argument for argument in arguments]) == 3
    err = [line for line in capsys.readouterr().err.splitlines() if "kernels" not in line]
    assert len(err) == 1 and err[0].startswith("firstcontact: ") and says in err[0] and len(err[0]) < 2100


def outcome(command, **environment):
    """Exit code, output and lines of error of a shell command, in which $FC is this command."""
    called = f"{sys.executable} -m firstcontact"
    done = subprocess.run(
        ["sh", "-c", command.replace("$FC", called)], capture_output=True, timeout=60,
        env={**os.environ, "PYTHONPATH": str(SOURCE), **environment},
    )  # fmt: skip
    return done.returncode, done.stdout, [x for x in done.stderr.decode().splitlines() if "kernels" not in x]


OUTPUTS = {
    "closed": ("$FC info {} >&-", 3, ["firstcontact: standard output is closed; give it a place, /dev/null for none"]),
    "on a full disk": (
        "$FC info {} >/dev/full",
        3,
        ["firstcontact: standard output: no space left on device; give it another place"],
    ),
    "a pipe that closes": ("($FC info {}; echo $? >&2) | true", 0, ["141"]),
    "help on a full disk": (
        "$FC --help >/dev/full",
        3,
        ["firstcontact: standard output: no space left on device; give it another place"],
    ),
}


@pytest.mark.parametrize("name", OUTPUTS)
def test_output_that_cannot_be_written(scene, name):
    command, code, lines = OUTPUTS[name]
    path = scene(BALLS + SLIDE)
    assert outcome(command.format(path)) == (code, b"", lines)


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252"])
def test_letters_that_the_output_lacks_are_escaped_and_the_exit_code_stands(scene, encoding):
    path = scene(BALLS.replace("body.b", 'body."\N{GREEK SMALL LETTER ALPHA}"') + SLIDE)
    code, out, lines = outcome(f"$FC info {path}", PYTHONIOENCODING=encoding)
    assert code == 0 and rb"body \u03b1: at rest" in out
    assert len(lines) == 1 and lines[0].startswith("firstcontact: standard output (") and "\\u03b1" in lines[0]
