"""Spans without end: the answer is that of a long span, and what can never change again lasts for ever."""

import math
from dataclasses import replace

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.contact import endless
from firstcontact.motion.span import common_span
from firstcontact.work import Query

ENDLESS = (0, math.inf)
PIN = fc.cylinder(1, 2)
FLOOR = fc.half_space((0, 0, 1), 0)
PARABOLOID = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, "-1/2"], [0, 0, "-1/2", 0]])
PIPE = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, -1]])
SHEET = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
LEVEL = fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
DOWN, UP = fc.Translation((0, 0, -1)), fc.Translation((0, 0, 1))

# a, b, and the intervals of contact as they are known
MEETINGS = {
    "pins pass": (PIN.translated((5, 0, 0)).moving(fc.Translation((-1, 0, 0))), PIN, [(3, 7)]),
    "far away": (PIN.translated((5e6, 0, 0)).moving(fc.Translation((-1, 0, 0))), PIN, [(4999998, 5000002)]),
    "pins miss": (PIN.translated((5, 3, 0)).moving(fc.Translation((-1, 0, 0))), PIN, []),
    "falls on the floor": (PIN.translated((0, 0, 500)).moving(DOWN), FLOOR, [(499, math.inf)]),
    "the floor rises": (PIN.translated((0, 0, 500)), FLOOR.moving(UP), [(499, math.inf)]),
    "leaves the floor": (PIN.translated((0, 0, 500)).moving(UP), FLOOR, []),
    "into a paraboloid": (fc.sphere(1).translated((0, 0, -5)).moving(UP), PARABOLOID, [(4, math.inf)]),
    "along a pipe": (fc.sphere(1).translated((20, 0, -5)).moving(UP), PIPE, []),
    "in a pipe": (fc.sphere(1).translated((0, 0, -5)).moving(UP), PIPE, [(0, math.inf)]),
    "at rest": (PIN, PIN, [(0, math.inf)]),
    "ruled": (SHEET.translated((0, 0, -7)).moving(UP), LEVEL, [(6.5, 7.5)]),
}


@pytest.mark.share(12)
@pytest.mark.parametrize("name", MEETINGS)
def test_known_meetings(name):
    a, b, expected = MEETINGS[name]
    found = fc.contact_intervals(a, b, ENDLESS)
    hit = fc.first_contact(a, b, ENDLESS)
    assert found.span == hit.span == (0.0, math.inf)
    assert len(found) == len(expected)
    for interval, (start, end) in zip(found, expected, strict=True):
        for (lo, hi), truth in ((interval.start_interval, start), (interval.end_interval, end)):
            assert lo <= truth <= hi and (lo == hi or hi - lo <= 1e-12 * max(1, truth))
    if not expected:
        assert hit.status is found.status is fc.Status.FREE and hit.free_until == math.inf
        return
    assert hit.status is found.status
    lo, hi = hit.time_interval
    assert lo <= expected[0][0] <= hi and hi - lo <= 1e-12 * max(1, hi)


@pytest.mark.share(4)
@pytest.mark.parametrize("size", [1, 10, 100])
@pytest.mark.parametrize("shape", [fc.cylinder(1, 2), fc.cylinder(1, 2).to_mesh(0.1)], ids=["solid", "mesh"])
def test_enclosures_are_as_narrow_as_the_time_asks(shape, size):
    """A body that is soon met: it takes many times as long until nothing can change any more."""
    body = shape.transformed(np.diag([size, size, size, 1])).rotated((1, 2, 0), degrees=20)
    reach = size * (math.cos(math.radians(20)) + math.sin(math.radians(20)))
    falling = body.translated((0, 0, reach + 0.5)).moving(DOWN)
    hit, found = fc.first_contact(falling, FLOOR, ENDLESS), fc.contact_intervals(falling, FLOOR, ENDLESS)
    starts = [hit.time_interval, *(interval.start_interval for interval in found)]
    for lo, hi in starts:
        assert hi - lo <= 1e-12 * max(1, hi) and 0 < lo < 2
    assert len(starts) == 2


def test_intervals_whose_enclosures_are_too_wide_are_asked_for_again():
    """A search may use up the tolerance of its span, which is longer than the times it finds."""
    a, b, _ = MEETINGS["pins pass"]
    asked = []

    def ask(query):
        asked.append(query.tolerance)
        found = fc.contact_intervals(a, b, (query.first, query.last))
        room = query.tolerance * query.span[1] / 2
        wide = replace(found[0], start_interval=(found[0].start - room, found[0].start + room))
        return replace(found, intervals=(wide,))

    (interval,) = endless.intervals(ask, Query(a, b, *common_span(a, b, ENDLESS), tolerance=1e-6))
    lo, hi = interval.start_interval
    assert len(asked) == 2 and hi - lo <= 1e-6 * 3


def test_a_turn_for_ever_is_one_turn():
    arm = PIN.translated((5, 0, 0)).moving(fc.Rotation((0, 0, 1), degrees=1))
    hit, once = (fc.first_contact(arm, PIN.translated((0, -5, 0)), span) for span in (ENDLESS, (0, 360)))
    assert hit.status is fc.Status.CONTACT and math.isclose(hit.time, once.time, rel_tol=1e-12)
    assert fc.first_contact(arm, PIN.translated((0, -8, 0)), ENDLESS).status is fc.Status.FREE
    with pytest.raises(fc.InputError, match="needs a bounded span for a rotation"):
        fc.contact_intervals(arm, PIN, ENDLESS)


def test_the_same_as_a_long_span():
    rng = np.random.default_rng(20261122)
    for _ in range(amount(40)):
        start, way = rng.uniform(-6, 6, 3), rng.uniform(-1, 1, 3)
        body = fc.frustum(1, 0.5, 1).translated(start).moving(fc.Translation(way))
        target = [PIN, FLOOR, PARABOLOID, PIPE][rng.integers(4)]
        hit, long = (fc.first_contact(body, target, (0, end)) for end in (math.inf, 2000.0))
        assert hit.status is long.status, (start, way, target)
        if hit.status is fc.Status.CONTACT:
            assert math.isclose(hit.time, long.time, rel_tol=1e-8, abs_tol=1e-8)


def test_what_needs_an_end():
    saddle = fc.quadric([[1, 0, "1/2", 0], [0, 0, 0, 1], ["1/2", 0, 0, 0], [0, 1, 0, 0]])  # x^2 + x z + 2 y <= 0
    rising = fc.Translation((0, 0, 1))
    with pytest.raises(fc.UnsupportedPair, match="opens along the motion; give span"):
        fc.first_contact(fc.sphere(1).translated((0, 9, 0)).moving(rising), saddle, ENDLESS)
    with pytest.raises(fc.UnsupportedPair, match="opens along the motion; give span"):  # for some of its points
        fc.first_contact(fc.sphere(1).translated((0.5, 9, 0)).moving(rising), saddle, ENDLESS)
    assert fc.first_contact(fc.sphere(1).translated((9, 9, 0)).moving(rising), saddle, ENDLESS).status is fc.Status.FREE
    with pytest.raises(fc.InputError, match="no end, but Screw of body a needs one; give span"):
        fc.first_contact(PIN.moving(fc.Screw((0, 0, 1), degrees=9, advance=1)), FLOOR, ENDLESS)
    falling = FLOOR.translated((0, 0, 5)).moving(fc.Translation((0, 0, -1)))
    with pytest.raises(fc.InputError, match="no end, but Screw of body a needs one; give span"):
        fc.first_contact(PIN.moving(fc.Screw((0, 0, 1), degrees=9, advance=1)), falling, ENDLESS)
    with pytest.raises(fc.InputError, match="deforms"):
        fc.first_contact(fc.RuledSurface("(u, 0, T)", "(u, 1, u)"), SHEET, ENDLESS)


ABOVE_FLOOR = [
    fc.Polyhedron([(0, 0, -3)], []), fc.Polyhedron([(0, 0, -3), (1, 0, -3), (0, 1, -3)], [[0, 1, 2]]),
    fc.sphere(1).translated((0, 0, -2)),
]  # fmt: skip


@pytest.mark.share(3)
@pytest.mark.parametrize("verb", [fc.first_contact, fc.contact_intervals])
@pytest.mark.parametrize("other", ABOVE_FLOOR)
def test_an_endless_solid_that_moves(verb, other):
    """Found from outside: it was refused before meshes, though it was taken at rest."""
    floor = fc.half_space((0, 0, 1), -5)
    for motion, time in (
        (fc.Translation((0, 0, 4)), 0.5), (fc.Screw((0, 0, 1), degrees=90, advance=4), 0.5),
        # about the line y = 4, z = -4: the point is at (-4, 1) from there when 4 sin + cos = -1
        (fc.Rotation((1, 0, 0), (0, 4, -4), degrees=-60), np.degrees(2 * np.arctan(0.25)) / 60),
    ):  # fmt: skip
        if isinstance(motion, fc.Rotation) and not isinstance(other, fc.Polyhedron):
            continue
        found = verb(floor.moving(motion), other)
        at = found.time_interval if verb is fc.first_contact else found.intervals[0].start_interval
        assert found.status is fc.Status.CONTACT and at[0] - 1e-15 <= time <= at[1] + 1e-15
    assert verb(floor.moving(fc.Rotation((1, 0, 0), (0, 4, -4), degrees=60)), other).status is fc.Status.FREE


def test_what_has_no_end_and_goes_astray_is_told():
    floor, drop = fc.half_space((0, 0, 1), -5, name="floor"), fc.Polyhedron([(0, 0, -3)], [])
    steps = fc.Sequence([fc.Translation((0, 0, 1)), fc.Translation((0, 0, 3))])
    with pytest.raises(fc.UnsupportedPair, match="floor has no end and moves; let it rest"):
        fc.first_contact(floor.moving(steps), drop)
