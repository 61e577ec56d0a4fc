"""Bodies that meet by their heights along the axis of their turns: landings on screws, at seams of steps, and after."""

from __future__ import annotations

import math
import random
from fractions import Fraction as F
from itertools import pairwise

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.heights.meeting import Ascents, ascents_of
from firstcontact.contact.heights.ranges import heights
from firstcontact.work import Query

UP = (0, 0, 1)
CIRCLE = "(1 - u**2)/(1 + u**2), 2*u/(1 + u**2)"
PLATE = fc.box((10, 10, 1)).translated((0, 0, "-1/2"))
SLAB = fc.examples.box((10, 10, 1)).translated((0, 0, "-1/2"))
RISEN = {
    "bolt": fc.cylinder(1, 2).translated((0, 0, 1)),
    "tip": fc.RuledSurface("(0, 0, 0)", f"({CIRCLE}, 1)", u=None),
    "rim": fc.RuledSurface(f"({CIRCLE}, 0)", f"({CIRCLE}, 1)", u=None),
    "sheet": fc.RuledSurface("(u, 0, 0)", "(u, 2, 0)", u=(0, 3)),
    "disc": fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s - 1)**2 <= 1"]),
    "block": fc.examples.box((2, 3, 1)).translated((0, 0, "1/2")),
}
"""Bodies that stand on the height 0."""


def screw(advance, degrees=70):
    return fc.Screw(UP, degrees=degrees, advance=advance)


@pytest.mark.share(2)
@pytest.mark.parametrize("floor", [PLATE, SLAB], ids=["solid", "mesh"])
@pytest.mark.parametrize("name", RISEN)
def test_what_is_set_down_by_a_screw_and_taken_up_again(name, floor):
    """Found outside: UNDECIDED just before the seam, for all but meshes."""
    motion = fc.Sequence([screw(-2, 90), screw(2, -45)])
    moving = RISEN[name].translated((0, 0, 2)).moving(motion)
    for a, b in ((moving, floor), (floor, moving)):
        hit, found = fc.first_contact(a, b), fc.contact_intervals(a, b)
        assert hit.status is fc.Status.CONTACT and hit.time_interval[0] <= 0.5 <= hit.time_interval[1]
        assert hit.point[2] == pytest.approx(0, abs=1e-12) and hit.element_a is not None and hit.element_b is not None
        assert [(x.start, x.end) for x in found] == [(0.5, 0.5)] and found.status is fc.Status.CONTACT


@pytest.mark.parametrize("name", ["tip", "rim"])
def test_what_lands_in_the_last_instant_of_a_screw(name):
    moving = RISEN[name].translated((0, 0, 2)).moving(screw(-2))
    hit, found = fc.first_contact(moving, PLATE), fc.contact_intervals(moving, PLATE)
    assert hit.time == 1.0 and [(x.start, x.end) for x in found] == [(1.0, 1.0)]
    assert hit.stats.ways[-1].way == "by heights" and hit.stats.ways[-1].told == "CONTACT"


def test_what_comes_down_beside_the_floor_is_not_said_to_touch_it():
    """Heights meet at the seam; the outline of the floor is elsewhere."""
    motion = fc.Sequence([screw(-2, 90), screw(2, -45)])
    for name in ("bolt", "rim", "disc"):
        moving = RISEN[name].translated((0, 0, 2)).moving(motion)
        hit = fc.first_contact(moving, PLATE.translated((20, 0, 0)))
        assert hit.status in (fc.Status.FREE, fc.Status.UNDECIDED)
        assert fc.first_contact(moving, PLATE.translated(("13/2", 0, 0))).status is not fc.Status.CONTACT


def test_a_rest_on_the_floor_between_two_screws():
    motion = fc.Sequence([screw(-2, 36), fc.Translation((0, 0, 0)), screw(2, -36)], durations=[1, 2, 1])
    found = fc.contact_intervals(RISEN["bolt"].translated((0, 0, 2)).moving(motion), PLATE)
    assert [(x.start, x.end) for x in found] == [(1.0, 3.0)]


def test_a_head_that_comes_flush_while_the_shank_is_in_the_hole():
    bolt = (fc.cylinder(1, 6) | fc.cylinder(2, 2).translated((0, 0, 4))).translated((0, 0, 8))
    plate = fc.box((10, 10, 2)) - fc.cylinder(F(3, 2), 4)
    motion = fc.Sequence([screw(-10, 77), screw(10, -360)])
    for a, b in ((bolt.moving(motion), plate), (plate, bolt.moving(motion))):
        assert [(x.start, x.end) for x in fc.contact_intervals(a, b)] == [(0.5, 0.5)]


def test_a_door_on_a_screw_grazes_a_stop():
    """Found outside: its edge at radius 5 touches x = 5 at atan2(4, 3); all contacts were told, the first was not."""
    door = fc.box((4, 8, 5)).translated((1, 0, "5/2"))
    stop = fc.box((2, 2, 1)).translated((6, 0, "3/2"))
    then = math.degrees(math.atan2(4, 3)) / 100
    moving = door.moving(fc.Screw(UP, degrees=100, advance=1))
    for a, b, sign in ((moving, stop, -1), (stop, moving, 1)):
        hit = fc.first_contact(a, b)
        assert hit.time_interval[0] <= then <= hit.time_interval[1]
        assert hit.point == pytest.approx((5, 0, 1), abs=1e-9) and hit.normal == pytest.approx((sign, 0, 0), abs=1e-9)


def test_an_axis_of_irrational_length_is_not_taken():
    """Its advance has irrational heights; the answer is what it was."""
    moving = RISEN["tip"].translated((0, 0, 2)).moving(fc.Screw((1, 1, 1), degrees=70, advance=-2))
    assert fc.first_contact(moving, PLATE).stats.ways[-1].way != "by heights"


# -- random ones: all bodies are round about the axis, or hold it, so that they meet exactly when their heights do ----


def _heights(steps, start):
    """Corners (time, height) of a body's way up and down, in fractions."""
    found = [(F(0), F(start))]
    for length, rise in steps:
        time, height = found[-1]
        found.append((time + length, height + rise))
    return found


def _at(corners, time):
    for (t, h), (u, k) in pairwise(corners):
        if t <= time <= u:
            return h + (k - h) * (time - t) / (u - t)
    raise AssertionError(time)


def _contacts(one, two, size_one, size_two):
    """Closed times at which [h, h + size] of both have a height in common: by the corners and crossings."""
    times = sorted({t for t, _ in (*one, *two)})
    marks = set(times)
    for t, u in pairwise(times):
        for shift in (size_two, -size_one):
            x, y = (_at(one, v) - _at(two, v) - shift for v in (t, u))
            if x != y and 0 <= x / (x - y) <= 1:
                marks.add(t + (u - t) * x / (x - y))
    marks = sorted(marks)

    def meet(time):
        return -size_one <= _at(one, time) - _at(two, time) <= size_two

    windows = [[t, t] for t in marks if meet(t)]
    for t, u in pairwise(marks):
        if meet((t + u) / 2):
            windows.append([t, u])
    joined = []
    for t, u in sorted(windows):
        if joined and t <= joined[-1][1]:
            joined[-1][1] = max(joined[-1][1], u)
        else:
            joined.append([t, u])
    return [tuple(x) for x in joined]


def _motion(rng, steps):
    made = []
    for _, rise in steps:
        kind = rng.choice("srt") if rise == 0 else rng.choice("sst")
        angle = rng.choice((0, 30, 90, -77, 400))
        if kind == "s":
            made.append(fc.Screw(UP, degrees=angle, advance=rise) if angle or rise else fc.Translation((0, 0, 0)))
        elif kind == "r":
            made.append(fc.Rotation(UP, degrees=angle or 20))
        else:
            made.append(fc.Translation((0, 0, rise)))
    return fc.Sequence(made, durations=[length for length, _ in steps])


ROUND = {
    "rod": (lambda h: fc.cylinder(1, h).translated((0, 0, F(h) / 2)), 2),
    "washer": (lambda h: (fc.cylinder(2, h) - fc.cylinder(F(1, 2), 2 * h)).translated((0, 0, F(h) / 2)), 1),
    "block": (lambda h: fc.examples.box((2, 2, h)).translated((0, 0, F(h) / 2)), 2),
}


def _scene(seed):
    """Two bodies, the end of their motion, and the closed times at which they meet."""
    rng = random.Random(f"heights {seed}")
    make, size = ROUND[rng.choice(("rod", "rod", "washer", "block"))]
    n = rng.choice((1, 2, 3))
    steps = [(F(rng.choice((1, 1, 2)), rng.choice((1, 2))), F(rng.choice((-3, -2, -1, 0, 1, 2)))) for _ in range(n)]
    start = F(rng.choice((1, 2, 3, 4)))
    body, other = make(size), fc.box((9, 9, 2)).translated((0, 0, -1))
    one, two = _heights(steps, start), [(F(0), F(-2)), (sum(x for x, _ in steps), F(-2))]
    moving = body.translated((0, 0, start)).moving(_motion(rng, steps))
    pair = (moving, other) if rng.random() < 0.5 else (other, moving)
    return pair, one[-1][0], _contacts(one, two, F(size), F(2))


@pytest.mark.parametrize("seed", [1, 5])
def test_what_stays_flush_next_to_an_end_is_followed(seed):
    """All contacts were UNDECIDED where the bodies part, or meet, at the very end of a time of common heights."""
    pair, end, expected = _scene(seed)
    found = fc.contact_intervals(*pair, (0, end))
    assert found.status is fc.Status.CONTACT and len(found) == len(expected)


def test_what_is_trimmed_away_does_not_land():
    """The square that a disc is cut from reaches y = 1.28 in this pose, the disc 1."""
    motion = fc.Sequence([screw(-2, 70), screw(2, -45)])
    moving = RISEN["disc"].translated((0, 0, 2)).moving(motion)
    floor = PLATE.translated((0, "121/20", 0))
    assert fc.first_contact(moving, floor).status is not fc.Status.CONTACT


def test_heights_after_an_irrational_advance_are_not_told():
    """In the second step nothing advances, but from where the first one led."""
    axis = (1, 1, 0)
    motion = fc.Sequence([fc.Screw(axis, degrees=40, advance=-1), fc.Rotation(axis, degrees=20)])
    body = fc.examples.box((1, 1, 1)).moving(motion)
    floor = fc.examples.box((1, 1, 1)).translated((3, 3, 0))
    assert ascents_of(Query(body, floor, fmpq(1, 2), fmpq(1))) is None
    level = fc.Sequence([fc.Rotation(axis, degrees=40), fc.Rotation(axis, degrees=20)])
    assert ascents_of(Query(fc.examples.box((1, 1, 1)).moving(level), floor, fmpq(1, 2), fmpq(1))) is not None


@pytest.mark.parametrize("seed", range(amount(24)))
def test_bodies_on_one_axis_meet_when_their_heights_do(seed):
    """By closed form."""
    pair, end, expected = _scene(seed)
    found = fc.contact_intervals(*pair, (0, end))
    seen = [(x.start_interval, x.end_interval) for x in found]
    if found.status is fc.Status.UNDECIDED:  # what stays flush while it turns
        assert all(t <= F(y) for (_, y), (t, _) in zip((x[0] for x in seen), expected, strict=False))
        assert not expected or found.free_until <= expected[-1][1]
    else:
        assert len(seen) == len(expected)
        for ((a, b), (c, d)), (t, u) in zip(seen, expected, strict=True):
            assert a <= t <= b and c <= u <= d
    hit = fc.first_contact(*pair, (0, end))
    if hit.status is fc.Status.FREE:
        assert not expected
    elif hit.status is not fc.Status.UNDECIDED:
        assert hit.time_interval[0] <= expected[0][0] <= hit.time_interval[1]
        assert np.isfinite(hit.time)


@pytest.mark.parametrize("make", [fc.box, fc.examples.box], ids=["solid", "mesh"])
def test_a_lid_set_down_by_a_turn_of_three_four_five_is_told_at_once(make):
    """Found outside: 7 s, as all edges of the two meet at that instant."""
    lid, base = make((2, 3, 0.25)).translated((1, "3/2", "1/8")), make((2, 3, 1)).translated((1, "3/2", "-1/2"))
    poses = [[[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, z], [0, 0, 0, 1]] for c, s, z in
             ((1, 0, 2), (F(4, 5), F(3, 5), 0), (1, 0, 2))]  # fmt: skip
    moving = lid.moving(fc.Trajectory([0, 1, 2], poses, interpolation="screw"))
    for a, b in ((moving, base), (base, moving)):
        hit, found = fc.first_contact(a, b), fc.contact_intervals(a, b)
        assert [x.way for x in hit.stats.ways] == ["by heights"] == [x.way for x in found.stats.ways]
        assert hit.time == 1.0 and [(x.start, x.end) for x in found] == [(1.0, 1.0)] and hit.element_a is not None
        assert hit.point == pytest.approx((0, 0, 0), abs=1e-12)
    above = base.translated((0, 0, 9))
    assert fc.first_contact(moving, above).status is fc.Status.FREE
    assert fc.contact_intervals(moving, above).status is fc.Status.FREE


def test_a_vertex_that_belongs_to_nothing_lands_on_nothing():
    stray = fc.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -5)],
                          [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])  # fmt: skip
    motion = fc.Sequence([screw(-2, 90), screw(2, -45)])
    for floor in (PLATE, SLAB):
        below = floor.translated((0, 0, -7))
        assert fc.first_contact(stray.moving(motion), below).status is not fc.Status.CONTACT
        assert list(fc.contact_intervals(stray.moving(motion), below)) == []


@pytest.mark.parametrize("name", ["rim", "disc", "bolt"])
def test_one_instant_of_a_landing_in_an_irrational_pose(name):
    """Found outside: a span of one instant, at which the one stands on the other."""
    moving = RISEN[name].translated((0, 0, 2)).moving(screw(-2))
    hit, found = (ask(moving, PLATE, (1, 1)) for ask in (fc.first_contact, fc.contact_intervals))
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "touching")
    assert found.status is fc.Status.INITIAL_CONTACT and [(x.start, x.end) for x in found] == [(1.0, 1.0)]
    later = fc.contact_intervals(moving, PLATE, ("1/2", 1))
    assert later.status is fc.Status.CONTACT and [(x.start, x.end) for x in later] == [(1.0, 1.0)]


def test_a_dome_that_reaches_a_hair_below_a_level_face_is_seen():
    """Heights are not those of level faces then; by 1e-12 it comes first."""
    domed = (fc.box((4, 4, 2)) | fc.sphere(1 + F(1, 10**12))).translated((0, 0, 3))
    assert heights(domed, (fmpq(0), fmpq(0), fmpq(1))) is None
    coned = fc.box((4, 4, 2)) | fc.cone(1, 1).translated((0, 0, -1 - F(1, 10**12)))
    assert heights(coned, (fmpq(0), fmpq(0), fmpq(1)))[0] == -1 - fmpq(1, 10**12)


def test_a_point_that_leaves_and_comes_back_does_not_stay():
    """Its height is the same at both ends of the time, and another one between."""
    zero, one = fmpq(0), fmpq(1)
    dips = [(zero, zero), (one / 2, -one), (one, zero)]
    ascents = Ascents((zero, zero, one), ((zero, one), (-one, zero)), (dips, [(zero, zero), (one, zero)]))
    assert ascents.has_from(0, zero, zero, one / 2) and ascents.has_from(0, zero, zero, one)
    assert ascents.raised(np.array([1.0, 2.0, 9.0]), fmpq(-1, 2**60)).tolist() == [1, 2, 0]  # a time that is rounded
    low = Ascents((zero, zero, one), ((zero, one), (-one / 2, zero)), ascents.rises)
    assert not low.has_from(0, zero, zero, one) and low.has_from(0, zero, zero, one / 4)
    assert low.meetings() == [(zero, one)]


@pytest.mark.parametrize("beside, lands", [(F(1, 10**20), False), (F(-1, 10**20), True)])
def test_a_point_lands_by_its_true_place_not_by_the_double_next_to_it(beside, lands):
    """The edge stands at x = cos 1 after one radian; the double next to that is 5e-17 more, past where plates begin."""
    cosine = sum(F((-1) ** k, math.factorial(2 * k)) for k in range(20))
    begin = cosine + beside
    assert begin < F(math.cos(1))
    edge = fc.Polyhedron([(1, 0, 2), (1, 0, 3)], [], edges=[[0, 1]])
    plate = fc.box((4, 4, 1)).translated((begin + 2, 0, F(-1, 2)))
    hit = fc.first_contact(edge.moving(fc.Screw(UP, radians=1, advance=-2)), plate)
    assert (hit.status is fc.Status.CONTACT) == lands


@pytest.mark.parametrize("floor", [PLATE, SLAB], ids=["solid", "mesh"])
def test_what_stands_on_the_floor_at_the_start_and_goes_up(floor):
    """Heights meet at the start alone."""
    moving = RISEN["bolt"].moving(fc.Sequence([screw(2, 90), screw(1, -45)]))
    hit, found = fc.first_contact(moving, floor), fc.contact_intervals(moving, floor)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "touching")
    assert found.status is fc.Status.INITIAL_CONTACT and [(x.start, x.end) for x in found] == [(0.0, 0.0)]


@pytest.mark.parametrize("floor", [PLATE, SLAB], ids=["solid", "mesh"])
@pytest.mark.parametrize("name", RISEN)
def test_screws_go_on_before_time_zero(name, floor):
    """At times before zero, on a screw that sinks or rises 4 in a unit of time, about an axis through the floor."""
    sinks = RISEN[name].translated((1, 0, -2)).moving(screw(-4))  # at height 2 at time -1, 0 at -1/2
    hit = fc.first_contact(sinks, floor, span=(-1, F(-1, 4)))
    assert hit.status.name == "CONTACT"
    assert hit.time_interval[0] <= -0.5 <= hit.time_interval[1]
    rises = RISEN[name].translated((1, 0, 4)).moving(screw(4))  # at height 0 at time -1
    assert fc.first_contact(rises, floor, span=(-1, 0)).status.name in ("INITIAL_CONTACT", "UNDECIDED")
    told = fc.contact_intervals(rises, floor, span=(-1, 0))
    assert told.status.name == "UNDECIDED" or [(x.start, x.end) for x in told] == [(-1, -1)]
    assert fc.first_contact(rises, floor, span=(F(-3, 4), 0)).status.name == "FREE"


def test_a_frustum_that_lifts_off_a_floor_before_time_zero_was_said_to_be_free():
    start = fc.frustum(1, 2, 2).translated((F(-1, 2), F(-1, 2), 4)).moving(fc.Screw(UP, turns=F(-1, 5), advance=3))
    floor = fc.box((6, 6, 2))
    told = fc.contact_intervals(start, floor, (-1, 0))
    assert (told.status.name, [(x.start, x.end) for x in told]) == ("INITIAL_CONTACT", [(-1, -1)])
    assert fc.contact_intervals(start, floor, (-1, F(-1, 2))).status.name == "INITIAL_CONTACT"
    lifts = fc.frustum(1, 2, 3).translated((F(-1, 2), F(-1, 2), -1)).moving(fc.Screw(UP, turns=F(-1, 12), advance=3))
    for b in (floor, fc.examples.box((6, 6, 2))):
        hit = fc.first_contact(lifts, b, (-1, 0))
        assert hit.status.name == "UNDECIDED" or hit.time == -1  # never later
        assert all(x.start == -1 for x in fc.contact_intervals(lifts, b, (-1, 0)))


@pytest.mark.parametrize("floor", [PLATE, SLAB], ids=["solid", "mesh"])
@pytest.mark.parametrize("name", [*RISEN, "angle"])
def test_what_is_set_down_turned_in_place_and_taken_up(name, floor):
    """Contact lasts while it turns on the floor; of a sheet, whose axis is beside it, too."""
    outline = [(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)]
    corners = [(x, y, z) for z in (0, 1) for x, y in outline]
    sides = [[k, j, j + 6, k + 6] for k in range(6) for j in [(k + 1) % 6]]
    angle = fc.Polyhedron(corners, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides])
    own = {**RISEN, "angle": angle}[name].translated((0, 0, 3))
    motion = fc.Sequence([screw(-3, 150), fc.Rotation(UP, degrees=70), screw(2, 20)])
    hit, found = fc.first_contact(own.moving(motion), floor), fc.contact_intervals(own.moving(motion), floor)
    third = F(1, 3)
    assert hit.status.name == "CONTACT" and F(hit.time_interval[0]) <= third <= F(hit.time_interval[1])
    (x,) = found
    assert F(x.start_interval[0]) <= third <= F(x.start_interval[1])
    assert F(x.end_interval[0]) <= 2 * third <= F(x.end_interval[1])


def test_heights_that_touch_at_the_ends_of_a_time_and_meet_between_are_no_rest():
    """A ring sinks to the plate's top, through its hole and out below, beside the plate all the way."""
    ring = fc.cylinder(1, 1).translated((0, 0, 2))
    plate = fc.box((10, 10, 1)) - fc.cylinder(2, 3)
    moving = ring.moving(fc.Sequence([screw(-1), screw(-2), screw(-1)]))
    assert fc.contact_intervals(moving, plate).status.name == "FREE"
    assert fc.first_contact(moving, plate).status.name == "FREE"


def test_ends_that_no_double_equals_are_enclosed():
    """A cylinder lands at 11/27 on a screw; a start and an end at thirds of the span."""
    lands = fc.cylinder(1, 2).translated((0, 0, 5)).moving(fc.Screw(UP, (1, 0, 0), turns=F(1, 12), advance=F(-81, 11)))
    (x,) = fc.contact_intervals(lands, fc.cylinder(2, 2))
    assert F(x.start_interval[0]) <= F(11, 27) <= F(x.start_interval[1])
    shift = fc.Translation((1, 0, 0))
    for a, b in ((fc.sphere(1), fc.sphere(1)), (fc.examples.box((1, 1, 1)), fc.examples.box((1, 1, 1)))):
        (x,) = fc.contact_intervals(a.moving(shift), b, span=(F(1, 3), F(2, 3)))
        assert F(x.start_interval[0]) <= F(1, 3) <= F(x.start_interval[1])
        assert F(x.end_interval[0]) <= F(2, 3) <= F(x.end_interval[1])
        lo, hi = fc.first_contact(a.moving(shift), b, span=(F(1, 3), F(2, 3))).time_interval
        assert F(lo) <= F(1, 3) <= F(hi)


def test_a_graze_where_two_screws_join_is_one_interval():
    a, b = fc.cylinder(1, 2).translated((0, 2, 0)), fc.cylinder(1, 24).translated((-4, 0, 0))
    there, back = (fc.Screw(UP, turns=F(1, 4), advance=k) for k in (1, -1))
    found = fc.contact_intervals(a.moving(fc.Sequence([there, back], durations=[F(1, 3), F(2, 3)])), b)
    (x,) = found
    assert F(x.start_interval[0]) <= F(1, 3) <= F(x.end_interval[1])


@pytest.mark.parametrize("turns", [F(1, 2), F(3, 7), F(1, 7)])
def test_a_tip_that_sinks_into_a_box_is_told_in_either_order(turns):
    tip = fc.cone(1, 2).rotated((1, 0, 0), degrees=180).translated((0, 0, 6))
    moving, box = tip.moving(fc.Screw(UP, (1, 0, 0), turns=turns, advance=-4)), fc.box((6, 6, 2))
    for hit in (fc.first_contact(moving, box), fc.first_contact(box, moving)):
        assert hit.status.name == "CONTACT" and hit.time_interval[0] <= 0.75 <= hit.time_interval[1]


def test_the_head_of_a_bolt_grazes_a_post_on_its_screw():
    """Post and head, of radius 1 both, at the radii 4 and 2: they touch in one direction."""
    shank = fc.cylinder(F(1, 2), 2).translated((2, 0, -1))
    bolt = (shank | fc.cylinder(1, F(1, 2)).translated((2, 0, F(1, 4)))).moving(fc.Screw(UP, turns=F(3, 4), advance=1))
    post = fc.cylinder(1, 20).translated((F(-12, 5), F(-16, 5), 0))
    hit = fc.first_contact(bolt, post)
    assert hit.status.name == "CONTACT"
    then = (math.pi + math.atan2(4, 3)) / (1.5 * math.pi)
    assert hit.time_interval[0] <= then <= hit.time_interval[1]
    assert [x.way for x in hit.stats.ways][-1] == "by all contacts"


def test_an_angle_that_turns_on_another_one_stays_in_contact():
    """Neither is convex, and no corner of the one stays on the other: 35 s, UNDECIDED."""
    outline = [(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)]
    sides = [[k, j, j + 6, k + 6] for k in range(6) for j in [(k + 1) % 6]]
    faces = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides]
    upper = fc.Polyhedron([(x, y, z) for z in (4, 6) for x, y in outline], faces)
    lower = fc.Polyhedron([(x - 1, y - 1, z) for z in (-1, 1) for x, y in outline], faces)
    on = (1, 0, 0)
    motion = fc.Sequence([fc.Screw(UP, on, turns=F(3, 7), advance=-3), fc.Rotation(UP, on, turns=F(1, 5))])
    for a, b in ((upper.moving(motion), lower), (lower, upper.moving(motion))):
        found = fc.contact_intervals(a, b)
        assert [(x.start, x.end) for x in found] == [(0.5, 1.0)]
        assert [x.way for x in found.stats.ways] == ["by heights"]
        assert fc.first_contact(a, b).time == 0.5
    aside = upper.translated((9, 9, 0)).moving(motion)
    assert fc.contact_intervals(aside, lower).status.name == "FREE"


def test_what_turns_off_the_floor_in_place_is_asked_about_in_the_plane():
    """A bar that is set down across the end of a plate, by 1 in 10, and turns away from it about its other end."""
    bar = fc.examples.box((6, 1, 1)).translated((3, 0, F(5, 2)))
    plate = fc.examples.box((2, 4, 2)).translated((6, 0, -1))
    motion = fc.Sequence([screw(-2, 360), fc.Rotation(UP, degrees=90), screw(2, 20)])
    then = math.radians(90)  # the corner (6, 1/2) and the side y = -1/2 leave the plate, whose nearest corner is (5, 2)
    (x,) = fc.contact_intervals(bar.moving(motion), plate)
    assert F(x.start_interval[0]) <= F(1, 3) <= F(x.start_interval[1])
    out = math.atan2(2, 5) + math.asin(0.5 / math.hypot(5, 2))  # its lower side passes the corner
    assert x.end == pytest.approx((1 + out / then) / 3, abs=1e-9)
