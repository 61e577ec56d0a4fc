"""`firstcontact warmup`: afterwards nothing is left to compile."""

import importlib
import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from firstcontact.cli import run

warmup = importlib.import_module("firstcontact.cli.warmup")
QUERIES = """
import gc
from numba.core.dispatcher import Dispatcher
import firstcontact as fc
from firstcontact.warmup import warm

def compiled():
    kernels = [d for d in gc.get_objects() if isinstance(d, Dispatcher) and "firstcontact" in d.__module__]
    return {(d.__module__, d.__name__, str(s)) for d in kernels for s in d.signatures}

left = warm()
before = compiled()
ball = fc.examples.noisy_sphere(80)
gear = fc.examples.spur_gear(96, teeth=4).translated((2.5, 0, 0))
open_ball = fc.Polyhedron(ball.vertices, ball.triangles[:40])
shift, swing = fc.Translation((-3, 0.1, 0)), fc.Rotation((1, 2, 3), point=(4, 0, 0), degrees=400)
upright = fc.Rotation((0, 0, 1), point=(4, 0, 0), turns=1)
screw = fc.Screw((1, 2, 3), point=(4, 0, 0), degrees=100, advance=1)
motions = [shift, swing, upright, screw, fc.Sequence([shift, swing]), fc.Sequence([swing, shift])]
for motion in motions:
    for other in (ball, open_ball, fc.Polyhedron(ball.vertices, []), ball.translated((2.5, 0, 0))):
        for exact in (False, True)[: 1 if motion is screw else 2]:
            fc.first_contact(gear.moving(motion), other, exact=exact)
        fc.contact_intervals(gear.moving(motion), other)
fc.first_contact(ball, ball.rotated((0, 0, 1), degrees=10))
fc.contact_pairs(gear.moving(shift), ball)
fc.contact_pairs(gear.moving(swing), ball)
rows = [[[(k, y, (k * k * (3 + y)) % 5) for y in (-4, 4)] for k in range(-3, 4)] for _ in range(2)]
strips = [fc.RuledSurface.from_nurbs(grid, [0] * 4 + [1, 2, 3] + [4] * 4) for grid in rows]
fc.intersection_curve(strips[0], strips[1].rotated((0, 0, 1), degrees=90).translated((0, 0, "1/3")))
print(left, len(before) > 10, sorted(compiled() - before))
"""


EXAMPLES = """
import os, sys
from pathlib import Path
from firstcontact.cli import run
from firstcontact.kernels.cache import COMPILED, LOADED

before = len(COMPILED)
sys.stdout = open(os.devnull, "w")
root = Path(sys.argv[1])
for verb, name in {COMMANDS}:
    assert run([verb, str(root / "examples" / name)]) in (0, 1), name
os.chdir(root)
text = (root / "README.md").read_text(encoding="utf-8")
exec(text.split("```python\\n")[1].split("```")[0], {})
solids = [line[4:] for line in text.split("```pycon\\n")[1].split("```")[0].splitlines() if line.startswith(">>> ")]
exec("\\n".join(["import firstcontact as fc", *solids]), {})
print(len(COMPILED) - before, len(COMPILED) + len(LOADED) > 50, file=sys.__stdout__)
"""
COMMANDS = [
    *(("check", name) for name in ("lid.toml", "gears.toml", "cubes.toml", "lift.toml", "plunger.toml", "roof.toml")),
    *(("intervals", name) for name in ("lid.toml", "plunger.toml", "roof.toml", "roller.toml")),
    ("info", "lid.toml"),
    *(("curve", name) for name in ("cone.toml", "roller.toml", "roof.toml")),
]


NOTHING = "nothing to do: all kernels are compiled\n"


@pytest.fixture(scope="module")
def warmed():
    """What the command says: once, for it takes a while where all is compiled, too."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = run(["warmup", "--progress"])
    return code, out.getvalue(), err.getvalue()


def test_warmup_tells_its_steps(warmed):
    code, out, err = warmed
    assert code == 0 and (out.startswith("ready after ") or out == NOTHING)
    assert "first_contact under rotation" in err or "━" in err


def test_it_tells_how_many_kernels_were_compiled_and_that_nothing_is_left_to_do(command, monkeypatch):
    for count, told in ((7, "ready after 0.0 s: 7 kernels compiled\n"), (0, NOTHING)):
        monkeypatch.setattr(warmup, "_warm", lambda shows, count=count: count)
        assert command("warmup") == (0, told, "")


@pytest.mark.thorough
def test_queries_and_examples_after_warming_up_compile_nothing_more(warmed, python):
    done = python(QUERIES + EXAMPLES.replace("{COMMANDS}", repr(COMMANDS)), Path(__file__).parents[2])
    assert done.returncode == 0, done.stderr
    assert done.stdout == "0 True []\n0 True\n"
