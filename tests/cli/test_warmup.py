"""`firstcontact warmup`: afterwards nothing is left to compile."""

QUERIES = """
import gc
from numba.core.dispatcher import Dispatcher
import firstcontact as fc
from firstcontact.warmup import warm

def compiled():
    kernels = [d for d in gc.get_objects() if isinstance(d, Dispatcher) and "firstcontact" in d.__module__]
    return {(d.__module__, d.__name__, str(s)) for d in kernels for s in d.signatures}

warm()
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
print(len(before) > 10, sorted(compiled() - before))
"""


def test_warmup_tells_its_steps_and_ends(command):
    code, out, err = command("warmup")
    assert code == 0 and out.startswith("ready after ")
    assert "first_contact under rotation" in err


def test_queries_after_warming_up_compile_nothing_more(python):
    done = python(QUERIES)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "True []\n"
