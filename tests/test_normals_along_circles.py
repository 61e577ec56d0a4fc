"""Contact along a whole circle: the normal told is the one at the point told."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import numpy as np
import pytest

import firstcontact as fc

ANGLES = (F(3, 5), F(4, 5)), (F(4, 5), F(3, 5)), (F(5, 13), F(12, 13)), (F(15, 17), F(8, 17))


def by_quaternion(w: int, x: int, y: int, z: int) -> list[list[F]]:
    n = w * w + x * x + y * y + z * z
    return [
        [F(w * w + x * x - y * y - z * z, n), F(2 * (x * y - w * z), n), F(2 * (x * z + w * y), n)],
        [F(2 * (x * y + w * z), n), F(w * w - x * x + y * y - z * z, n), F(2 * (y * z - w * x), n)],
        [F(2 * (x * z - w * y), n), F(2 * (y * z + w * x), n), F(w * w - x * x - y * y + z * z, n)],
    ]


def check(hit, centre, radius, kind: str = "conic arc") -> None:
    """On a ball there is one normal at each point: from there to the centre."""
    assert hit.status is fc.Status.CONTACT and hit.contact_set == kind
    across = (np.array(centre, float) - hit.point) / float(radius)
    assert np.linalg.norm(across) == pytest.approx(1, abs=1e-9)
    assert hit.normal == pytest.approx(across, abs=1e-9)


@pytest.mark.parametrize("exact", [False, True])
def test_a_ball_on_the_rim_of_a_hole(exact):
    plate = fc.box((16, 16, 5.5)) - fc.cylinder(2, 16.5)
    ball = fc.sphere(4.25).translated((0, 0, 8.5)).moving(fc.Translation((0, 0, -4)))
    check(fc.first_contact(ball, plate, exact=exact), (0, 0, 6.5), 4.25)


@pytest.mark.share(16)
@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_balls_in_holes_and_seats(seed, exact):
    """Turned about a quaternion of whole numbers; a ball on a rim, or in a seat as wide as a cone."""
    rng = Random(seed)
    c, n = rng.choice(ANGLES)
    r, h = F(rng.randint(2, 9), 2), F(rng.randint(1, 6))
    if seed % 2:
        body, radius, rest = fc.box((8 * r, 8 * r, h)) - fc.cylinder(r, 3 * h), r / c, h / 2 + r * n / c
    else:  # the ball touches the seat where it is r + 4 n wide
        funnel = fc.frustum(r, r + 8 * n, 8 * c).translated((0, 0, -4 * c))
        body, radius = fc.box((8 * r + 40, 8 * r + 40, 8 * c)) - funnel, (r + 4 * n) / c
        rest = radius * n
    while not any(q := [rng.randint(-3, 3) for _ in range(4)]):
        pass
    turn = by_quaternion(*q)
    pose = [[*row, 0] for row in turn] + [[0, 0, 0, 1]]
    axis = [row[2] for row in turn]
    fall, when = F(rng.choice((2, 8))), F(rng.randint(1, 7), 8)
    ball = fc.sphere(radius).translated([(rest + fall * when) * x for x in axis])
    falling = ball.moving(fc.Translation([-fall * x for x in axis]))
    hit = fc.first_contact(falling, body.transformed(pose), exact=exact)
    assert hit.time == pytest.approx(float(when), abs=1e-12)
    check(hit, [rest * x for x in axis], radius)
    back = fc.first_contact(body.transformed(pose), falling, exact=exact)
    assert back.normal == pytest.approx((np.array(back.point) - np.array([rest * x for x in axis], float))
                                        / float(radius), abs=1e-9)  # fmt: skip


@pytest.mark.share(7)
@pytest.mark.parametrize(
    ("top", "bore", "depth", "pin", "aside"),
    [
        (F(7, 10), F(7, 20), F(7, 10), F(63, 200), (F(21, 1000), F(28, 1000))),
        (2, 1, F(3, 2), F(1, 2), (F(3, 10), F(2, 5))),
        (2, 1, 1, F(1, 2), (F(1, 2), 0)),
    ],
)
@pytest.mark.parametrize("method", ["auto", "algebraic"])
def test_rims_that_touch_along_each_other(top, bore, depth, pin, aside, method):
    """Found from outside: the cross product of equal tangents is rounding, and was told as a normal.

    A pin comes down beside the axis of a countersunk hole, its rim inside the one between sink and bore, which it
    touches from within.  Normals of the plate there are those between the slope's and the bore's.
    """
    sink = fc.frustum(top, bore, depth).rotated((1, 0, 0), degrees=180).translated((0, 0, 1)) | fc.cylinder(bore, 6)
    plate = fc.box((12, 12, 2)) - sink
    moving = fc.cylinder(pin, 2).translated((*aside, 4)).moving(fc.Translation((0, 0, -4)))
    one, other = fc.first_contact(moving, plate, method=method), fc.first_contact(plate, moving, method=method)
    assert one.normal == pytest.approx(-other.normal, abs=1e-9) and np.linalg.norm(one.normal) == pytest.approx(1)
    inward = -np.array([*map(float, aside)]) / np.hypot(*map(float, aside))
    across, up = float(one.normal[:2] @ inward), float(one.normal[2])
    assert one.normal[:2] == pytest.approx(across * inward, abs=1e-9)
    slope = float((top - bore) / depth)  # of the normal: as far up as the wall goes out per depth
    assert across > 0 and -1e-9 <= up <= slope * across + 1e-9
