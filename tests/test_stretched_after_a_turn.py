"""Boxes that turn about z by irrational angles, stretch and shift: all times of contact, against the plane.

Their tops and bottoms stay level and their upright edges upright, so that edges are parallel at all times or come to be
it high above each other; whether the bodies meet is told by their outlines and heights alone.
"""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.exact.vectors import cross
from firstcontact.motion.relative.pieces import curved_pieces

BOX = fc.examples.box((1, 1, 1))
SQUARE = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])


def stretch(x, y, z, shift):
    one = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    more = [[x, 0, 0, shift[0]], [0, y, 0, shift[1]], [0, 0, z, shift[2]], [0, 0, 0, 0]]
    return fc.RationalMotion([one, more])


def gap(first, second):
    """Of two convex outlines; negative where they overlap."""
    best = -math.inf
    for x, y in ((first, second), (second, first)):
        for p, q in zip(x, np.roll(x, -1, axis=0), strict=True):
            normal = np.array([q[1] - p[1], p[0] - q[0]]) / np.linalg.norm(q - p)
            best = max(best, float(((y - p) @ normal).min()))
    return best


def apart(t, degrees, by, shift, place):
    """Negative where the moving box and the one at `place` overlap at the time t >= 1/2."""
    angle, s = math.radians(degrees), 2 * t - 1
    turned = SQUARE @ np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]).T
    scale = 1 + s * np.array(by)
    aside = gap(turned * scale[:2] + s * np.array(shift[:2]), SQUARE + place[:2])
    return max(aside, abs(s * shift[2] - place[2]) - 0.5 - 0.5 * scale[2])


def test_a_box_that_grows_runs_into_a_corner():
    """The plane of a side comes to the corner (5/2, 1/2): cos a (5/2 - 4 s) + sin a / 2 = (1 + s) / 2, s = 2 t - 1."""
    way = fc.Sequence([fc.Rotation((0, 0, 1), degrees=30), stretch(1, 1, 1, (4, 0, 0))])
    c = math.cos(math.radians(30))
    s = (2.5 * c + 0.25 - 0.5) / (4 * c + 0.5)
    for bodies in ((BOX.moving(way), BOX.translated((3, 1, 0))), (BOX.translated((3, 1, 0)), BOX.moving(way))):
        (only,) = fc.contact_intervals(*bodies)
        assert only.start == pytest.approx((1 + s) / 2, abs=1e-15) and only.end == 1.0


@pytest.mark.share(8)
@pytest.mark.parametrize("seed", [0, 1, 2, 5, 6, 7, 8, 9])
def test_boxes_that_turn_and_stretch_against_their_outlines(seed):
    rng = random.Random(seed)
    degrees, *by = (rng.choice(some) for some in ([10, 30, 50, 70], [0, 0.5, 1, 2], [0, 0.5, 1, 2], [0.5, 1, 2]))
    shift = rng.choice([3, 4, 6]), rng.choice([0, 0, 1]), rng.choice([0, 0, 1])
    place = rng.choice([2, 3]), rng.choice([0, 0.5, 1]), rng.choice([0, 0.5, 1.5])
    way = fc.Sequence([fc.Rotation((0, 0, 1), degrees=degrees), stretch(*by, shift)])
    told = fc.contact_intervals(BOX.moving(way), BOX.translated(place), span=(0.5, 1))
    assert told.status is not fc.Status.UNDECIDED
    for t in np.linspace(0.5, 1, 500):
        known = apart(t, degrees, by, shift, place)
        if abs(known) > 1e-9:
            assert any(x.start <= t <= x.end for x in told) == (known < 0), t


@pytest.mark.share(4)
@pytest.mark.parametrize("seed", range(7))
def test_boxes_that_screw_past_each_other_against_their_outlines(seed):
    rng = random.Random(seed)
    x, y, z = rng.choice([0.75, 1, 1.25]), rng.choice([0, 0.25]), rng.choice([1.5, 2, 2.25])
    degrees, advance = rng.choice([50, 100, 170]), rng.choice([-2, -3, -4])
    moving = BOX.translated((x, y, z)).moving(fc.Screw((0, 0, 1), degrees=degrees, advance=advance))
    told = fc.contact_intervals(moving, BOX)
    assert told.status is not fc.Status.UNDECIDED
    for t in np.linspace(0, 1, 500):
        c, s = math.cos(math.radians(degrees) * t), math.sin(math.radians(degrees) * t)
        aside = gap((SQUARE + (x, y)) @ np.array([[c, s], [-s, c]]), SQUARE)
        known = max(aside, abs(z + advance * t) - 1)
        if abs(known) > 1e-9:
            assert any(w.start <= t <= w.end for w in told) == (known < 0), t


def test_a_shift_after_an_irrational_turn():
    """An octahedron through a roof: where poses are rounded balls tell; at rest they meet when they are told to."""
    ends = [(3, 0, 0), (-3, 0, 0), (0, 2, 0), (0, -2, 0), (0, 0, 4), (0, 0, -4)]
    eight = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    turn = fc.Rotation((0, 0, 1), point=(0, -1, 1), degrees=-120)
    moving = fc.Polyhedron(ends, eight).translated((3, -3, 3)).moving(fc.Sequence([turn, fc.Translation((5, 6, -5))]))
    corners = [(-2, -4, 0), (2, -4, 0), (2, 4, 0), (-2, 4, 0), (0, -4, 4), (0, 4, 4)]
    roof = fc.Polyhedron(corners, [(3, 2, 1, 0), (0, 1, 4), (2, 3, 5), (1, 2, 5, 4), (3, 0, 4, 5)])
    roof = roof.rotated((1, 0, 0), degrees=90).translated((-2, -2, 0))
    told = fc.contact_intervals(moving, roof)
    assert told.status is fc.Status.CONTACT and told[0].start == fc.first_contact(moving, roof).time
    for t in np.linspace(0.003, 1, 60):
        meet = fc.first_contact(moving.at(t), roof, span=(0, 0)).status is fc.Status.INITIAL_CONTACT
        assert any(w.start <= t <= w.end for w in told) == meet, t


@pytest.mark.parametrize(("x", "y"), [(0.1, 0.2), (0, 0.25), (-0.3, -0.1)])
def test_a_bare_point_that_a_box_screws_up_to(x, y, recwarn):
    """It is in the top of the box after three quarters, and inside then; it stands for an edge of no length."""
    point, way = fc.Polyhedron([(0, 0, 0)], []), fc.Screw((0, 0, 1), degrees=100, advance=2)
    for bodies in ((BOX.moving(way), point.translated((x, y, 2))), (point.translated((x, y, 2)), BOX.moving(way))):
        (only,) = fc.contact_intervals(*bodies)
        assert (only.start, only.end) == (0.75, 1.0)
    assert not recwarn


@pytest.mark.parametrize(("motion", "stays"), [
    (fc.Screw((0, 0, 2), degrees=50, advance=1), True), (fc.Screw((0, 1, 2), degrees=50, advance=1), False),
    (stretch(1, 2, 3, (0, 0, 1)), True), (fc.Translation((1, 2, 3)), True),
    (fc.RationalMotion([np.eye(4), [[0, 0, 1, 0], [0] * 4, [0] * 4, [0] * 4]]), False),
])  # fmt: skip
@pytest.mark.parametrize(
    "before", [None, fc.Rotation((0, 0, 1), degrees=30), fc.Screw((0, 0, -3), degrees=30, advance=2)]
)
def test_directions_that_motions_keep(motion, stays, before):
    """That of z, told exactly after turns about it by irrational angles too."""
    way = motion if before is None else fc.Sequence([before, motion])
    piece = curved_pieces(BOX.moving(way), BOX, fmpq(0), fmpq(1))[-1]
    found = piece.leg_a.fixed_direction((fmpq(0), fmpq(0), fmpq(1)))
    assert (found is not None and not any(cross(found, (0, 0, 1)))) == stays
