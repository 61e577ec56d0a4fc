"""Small bodies far from the origin: the answers are those near it, however few digits doubles have there."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc

CONTACT, INITIAL, FREE = fc.Status.CONTACT, fc.Status.INITIAL_CONTACT, fc.Status.FREE
SIZES = (F(1), F(1, 2**30), F(3, 2**40))
AWAY = (F(19), F(-7, 4), F(1000, 3))
LIFT = [[[int(i == j) for j in range(4)] for i in range(4)], [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, -4], [0] * 4]]


def motions(s: F) -> dict[str, object]:
    """By which a body at height 3 s comes down to height 0, or below."""
    turned = fc.Rotation((1, 0, 0), (0, 0, F(3, 2) * s), degrees=180)
    slow, quick = [(0, 0, 0), (0, 0, -4 * s)], [(1, 0, 0, 0), (1, 0, 0, F(1, 9))]
    return {
        "translation": fc.Translation((0, 0, -4 * s)),
        "rotation": turned,
        "screw": fc.Screw((0, 0, 1), degrees=70, advance=-4 * s),
        "rational": fc.RationalMotion([LIFT[0], [[x * s for x in row] for row in LIFT[1]]]),
        "sequence": fc.Sequence([fc.Translation((0, 0, -s)), fc.Translation((0, 0, -3 * s))]),
        "keys": fc.Trajectory([0, 1], slow, quat_wxyz=quick),
        "screwed keys": fc.Trajectory([0, 1], slow, "screw", quat_wxyz=quick),
    }


def bodies(s: F) -> dict[str, tuple[object, object]]:
    """Of size s: one at height 3 s above one at the origin."""
    box, ball = fc.box((s, 2 * s, s)), fc.sphere(s)
    rock = fc.Polyhedron(
        [(s, 0, 0), (-s, 0, 0), (0, s, 0), (0, -s, 0), (0, 0, s), (0, 0, -s)],
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    )
    bent = fc.RuledSurface(f"(u, {-s}, -u**2/{s})".replace("Fraction", ""), f"(u, {s}, u**2/{s})", u=(-s, s))
    up = (0, 0, 3 * s)
    return {
        "ball on a box": (ball.translated(up), box),
        "can on a ball": (fc.cylinder(s, s).translated(up), ball),
        "rock on a ball": (rock.translated(up), ball),
        "sheet on a ball": (bent.translated(up), ball),
    }


def carried(body: object, motion: object) -> object:
    """By AWAY, motion and all."""
    by = tuple(fmpq(x.numerator, x.denominator) for x in AWAY)
    return body.translated(AWAY) if motion is None else body.translated(AWAY).moving(motion.shifted(by))


@pytest.mark.share(15)
@pytest.mark.parametrize("size", SIZES, ids=["1", "2^-30", "3/2^40"])
@pytest.mark.parametrize("motion", list(motions(F(1))))
@pytest.mark.parametrize("pair", list(bodies(F(1))))
def test_the_answer_is_that_near_the_origin(pair, motion, size):
    above, below = bodies(size)[pair]
    way = motions(size)[motion]
    near = fc.first_contact(above.moving(way), below)
    far = fc.first_contact(carried(above, way), carried(below, None))
    assert near.status is far.status is CONTACT
    lo, hi = max(near.time_interval[0], far.time_interval[0]), min(near.time_interval[1], far.time_interval[1])
    assert lo <= hi + 1e-15 and abs(near.time - far.time) <= 1e-11
    assert [str(x) for x in (near.element_a, near.element_b)] == [str(x) for x in (far.element_a, far.element_b)]
    if near.normal is not None:
        assert far.normal == pytest.approx(near.normal, abs=1e-9)
    # to the rounding of a double there
    assert far.point == pytest.approx(near.point + [float(x) for x in AWAY], abs=1e-12 * float(size) + 2e-13)
    found = (fc.contact_intervals(above.moving(way), below),
             fc.contact_intervals(carried(above, way), carried(below, None)))  # fmt: skip
    is_open = any(x.status is fc.Status.UNDECIDED for x in found)
    for one, other in zip(*found, strict=not is_open):
        assert one.start == pytest.approx(other.start, abs=1e-11)
        assert is_open or one.end == pytest.approx(other.end, abs=1e-11)
        (lo, hi), (least, most) = one.end_interval, other.end_interval
        assert lo <= most + 1e-15 and least <= hi + 1e-15


@pytest.mark.parametrize("motion", list(motions(F(1))))
def test_a_motion_in_a_shifted_world(motion):
    by = fmpq(3), fmpq(-5, 2), fmpq(7, 3)
    there, back = np.eye(4), np.eye(4)
    there[:3, 3] = [3, -2.5, 7 / 3]
    back[:3, 3] = -there[:3, 3]
    here = motions(F(1))[motion]
    for t in np.linspace(0, 1, 9):
        assert here.shifted(by)(t) == pytest.approx(there @ here(t) @ back, abs=1e-14)


@pytest.mark.parametrize("method", ["auto", "algebraic"])
def test_equal_cans_overlap_far_away(method):
    can = fc.cylinder(4.0745362639427185e-10, 5.820766091346741e-10)
    turn = [[F(4, 5), 0, F(3, 5), 19], [0, 1, 0, F(7, 4)], [F(-3, 5), 0, F(4, 5), F(4, 3)], [0, 0, 0, 1]]
    hit = fc.first_contact(can.transformed(turn), can.transformed(turn), method=method)
    assert hit.status is INITIAL and hit.initial == "overlapping" and hit.multiplicity == 10
    assert np.abs(hit.point - [19, 1.75, 4 / 3]).max() < 1e-9
    shown = [x.point for part in hit.subproblems for x in part.candidates if x.point is not None]
    assert all(np.abs(p - [19, 1.75, 4 / 3]).max() < 1e-9 for p in shown)


def test_the_normal_of_a_small_ball_is_that_of_the_face_it_meets():
    cone = fc.cone(F(108, 13), F(45, 13)).transformed(
        [[0, F(-4, 5), F(3, 5), -22], [0, F(-3, 5), F(-4, 5), 0], [1, 0, 0, -9], [0, 0, 0, 1]]
    )
    ball = fc.sphere(F(1, 2**15)).translated((-45, 2, 24))
    hit = fc.first_contact(cone.moving(fc.Translation((-36, 0, 44))), ball)
    assert hit.normal == pytest.approx([0.6, -0.8, 0], abs=1e-15)
    assert hit.time_interval[0] <= F(2523131, 3538944) <= hit.time_interval[1]


@pytest.mark.share(3)
@pytest.mark.parametrize("swap", [False, True], ids=["", "swapped"])
@pytest.mark.parametrize("spin", [False, True], ids=["shift", "screw"])
@pytest.mark.parametrize("size", [F(1, 2**40), F(1, 2**30), F(1), F(2**30)], ids=["2^-40", "2^-30", "1", "2^30"])
def test_balls_meet_when_they_do(size, spin, swap):
    """By Pythagoras: 3 sizes aside and two radii of 5/2 leave a height of 4.  The screw turns a ball on the spot."""
    x, y, z = (c * max(size, 1) for c in AWAY)
    down = fc.Screw((0, 0, -1), (x, y, z), degrees=100, advance=8 * size) if spin else fc.Translation((0, 0, -8 * size))
    a = fc.sphere(size * F(5, 2)).translated((x, y, z + 10 * size)).moving(down)
    b = fc.sphere(size * F(5, 2)).translated((x + 3 * size, y, z))
    hit = fc.first_contact(*((b, a) if swap else (a, b)))
    assert hit.status is CONTACT and hit.time_interval[0] <= F(3, 4) <= hit.time_interval[1]
    assert hit.normal == pytest.approx(np.array([-0.6, 0, 0.8]) * (-1 if swap else 1), abs=1e-12)
    where = np.array([float(x + F(3, 2) * size), float(y), float(z + 2 * size)])
    assert hit.point == pytest.approx(where, abs=1e-12 * float(size) + 4e-16 * float(max(abs(x), abs(z))))
