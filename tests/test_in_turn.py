"""Doubles and elimination in turn: who answers, that the order of the bodies changes nothing, and that no one hangs."""

import time as clock

import numpy as np
import pytest
import trimesh
from flint import fmpq

import firstcontact as fc
from amount import THOROUGH
from firstcontact.contact.in_turn import ROUNDS, first_in_turn, intervals_in_turn
from firstcontact.contact.ruled import first
from firstcontact.contact.signs.sheets import TooLarge
from firstcontact.work import Query

BLADE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", name="blade")
PLATE = fc.RuledSurface("(0, -3, 2*u-1)", "(0, 3, 2*u-1)", name="plate")
UP = fc.RationalMotion.between((0, 0, 0), (0, 0, 9), quat_wxyz=((1, 0, 0, 0), (1, 0, 0, 1)))
SCREW = fc.Screw((1, 2, 2), point=(1, -3, 2), degrees=180, advance=1)
SCREWED = (
    fc.RuledSurface("((6*u**2+4*u+9)/2,(-6*u**2-2*u-1)/2,(4*u**2-3)/2)", "(7/2,-3/2,-1/2)").moving(SCREW),
    fc.RuledSurface("((3*u-2)/(u+3),1,1/(u+3))", "(-3,-2*u-3,u+3)"),
)
"""A cone, and a piece that its border next to the apex passes."""


def names(found):
    return [asked.way for asked in found.stats.ways]


def test_a_free_turn_is_proved_by_doubles_alone():
    turn = BLADE.translated((2, 0, 0)).moving(fc.Rotation((0, 0, 1), degrees=60))
    found = fc.first_contact(turn, PLATE)
    assert found.status is fc.Status.FREE and names(found) == ["in doubles"]
    assert names(fc.first_contact(turn, PLATE, exact=True)) == ["exactly"]


def test_elimination_tells_what_touches_at_the_time_that_doubles_proved():
    """The front x = -9 + 20 t of the blade comes to x = 0 at 9/20; three things meet there."""
    moving = BLADE.translated((-10, 0, 0)).moving(fc.Translation((20, 0, 0)))
    auto, sure, exact = (fc.first_contact(moving, PLATE, method=m) for m in ("auto", "certified", "algebraic"))
    assert names(auto) == ["in doubles"] == names(sure) and names(exact) == ["exactly"]
    for found in (auto, sure, exact):
        assert found.time_interval[0] <= 0.45 <= found.time_interval[1]
    assert (auto.multiplicity, auto.element_a) == (exact.multiplicity, exact.element_a) and sure.multiplicity == 1


def test_doubles_go_on_alone_where_elimination_takes_no_such_motion():
    """They began anew after a second refusal: all contacts of a piece that slides in a cone took twice the time."""
    limits = []

    def in_doubles(query, work):
        limits.append(work.budget)
        told = (fc.Status.FREE, None) if work.budget is None else (fc.Status.UNDECIDED, "budget")
        return fc.ContactIntervals((), told[0], len(limits) / 8, told[1])

    def of(refusal):
        def exactly(query, work, reach):
            raise refusal("no")

        limits.clear()
        query = Query(BLADE, PLATE, fmpq(0), fmpq(1))
        found = intervals_in_turn(query, lambda own: fc.FirstContact(fc.Status.CONTACT), in_doubles, exactly)
        return found.status, limits

    assert of(fc.UnsupportedPair) == (fc.Status.FREE, [ROUNDS[0].boxes, None])
    # what is too large may be less so in the next round
    assert of(TooLarge) == (fc.Status.FREE, [own.boxes for own in ROUNDS])


def test_doubles_that_get_no_farther_wait_for_elimination():
    """Of a contact on a border they left the same time open in 100,000 boxes and in twice as many; it took 9 s more."""
    asked = []

    def in_doubles(query, work):
        asked.append(("in doubles", work.budget))
        return fc.ContactIntervals((), fc.Status.UNDECIDED, 0.25, "precision" if work.budget is None else "budget")

    def exactly(query, work, reach):
        asked.append(("exactly", work.budget))
        raise TooLarge("no")

    body = BLADE.moving(UP)
    query = Query(body, PLATE, fmpq(0), fmpq(1), begin=clock.perf_counter())
    found = intervals_in_turn(query, lambda own: None, in_doubles, exactly)
    assert found.status is fc.Status.UNDECIDED
    assert [way for way, _ in asked] == ["in doubles", "exactly", "in doubles", *["exactly"] * 3, "in doubles"]
    assert asked[-2:] == [("exactly", None), ("in doubles", None)]


@pytest.mark.parametrize("says", [fc.Status.CONTACT, fc.Status.FREE, fc.Status.INITIAL_CONTACT])
def test_elimination_looks_soon_where_doubles_have_stopped(says):
    """Once for each time at which they stop, but not after the first, short search."""
    asked = []

    def in_doubles(query):
        return fc.FirstContact(fc.Status.UNDECIDED, free_until=0.25, reason="budget", span=query.span)

    def exactly(query, reach):
        asked.append((query.first, query.end))
        if query.end == 1:
            raise TooLarge("no")
        times = {"time": 0.25, "time_interval": (0.25, 0.25)} if says is not fc.Status.FREE else {}
        return fc.FirstContact(says, free_until=0.25, span=query.span, **times)

    found = first_in_turn(Query(BLADE, PLATE, fmpq(0), fmpq(1)), in_doubles, exactly, lambda proved: False)
    soon = fmpq(1, 4), fmpq(1, 4) + fmpq(1, 2**30)
    assert asked[:2] == [(0, 1), soon] and asked.count(soon) == 1
    assert (found.status is fc.Status.CONTACT) == (says is fc.Status.CONTACT) and found.span == (0, 1)


def test_a_box_that_slides_in_the_plane_of_a_disc_takes_little_more_than_elimination():
    """Found outside: its side meets the rim at 2/7, where doubles stop; 9.3 s, by elimination alone 2.5 s."""
    disc = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s - 1)**2 <= 1"])
    box = fc.box((2, 4, 2)).translated((-1, 9, -1)).moving(fc.Translation((0, -21, 0)))
    for a, b in ((box, disc), (disc, box)):
        found = fc.first_contact(a, b)
        assert found.time_interval[0] <= 2 / 7 <= found.time_interval[1] and names(found)[-1] == "exactly, soon"
        assert found.point == pytest.approx((0, 1, 0), abs=1e-9) and found.span == (0, 1)


@pytest.mark.parametrize("verb", [first_in_turn, intervals_in_turn])
def test_elimination_is_asked_once_without_a_limit_where_doubles_are_at_their_end(verb):
    """It need not wait for what they told already; and what it does not take then, it does not take in later rounds."""
    asked = []

    def of(kind):
        def in_doubles(query, *work):
            asked.append("doubles")
            told = (fc.Status.UNDECIDED, "precision")
            return fc.ContactIntervals((), told[0], 0.0, told[1]) if kind else fc.FirstContact(told[0], reason=told[1])

        return in_doubles

    def exactly(query, *work_and_reach):
        budget = work_and_reach[0].budget if len(work_and_reach) > 1 else query.budget
        asked.append((budget, work_and_reach[-1]))
        raise TooLarge("no")

    query = Query(BLADE, PLATE, fmpq(0), fmpq(1))
    if verb is first_in_turn:
        verb(query, of(False), exactly, lambda proved: False)
    else:
        verb(query, of(False), of(True), exactly)
    assert asked == ["doubles", (None, ROUNDS[-1].reach)]


@pytest.mark.thorough
def test_box_and_blade_in_both_orders():
    """The second order took seven gigabytes and did not end."""
    box = fc.examples.box((1, 1, 1)).translated((0, 0, 5))
    moving = BLADE.moving(UP)
    begin = clock.perf_counter()
    one, two = fc.contact_intervals(moving, box), fc.contact_intervals(box, moving)
    assert clock.perf_counter() - begin < 60
    assert one.status is two.status is fc.Status.CONTACT and len(one) == len(two) == 1
    for x, y in zip(one, two, strict=True):
        assert abs(x.start - y.start) < 1e-11 and abs(x.end - y.end) < 1e-11
    # The blade's highest point has z = u s + 9 t: the box begins at z = 4.5 and ends at z = 5.5.
    (x,) = one
    assert (4.5 - 1) / 9 - 1e-12 <= x.start <= 4.5 / 9 + 1e-12 and 5.5 / 9 - 1 / 9 <= x.end <= 5.5 / 9 + 1e-12


def test_a_screw_and_a_body_at_rest_in_both_orders():
    turning, resting = SCREWED
    one, two = fc.first_contact(turning, resting), fc.first_contact(resting, turning)
    assert one.status is two.status is fc.Status.CONTACT
    assert one.time_interval[0] <= two.time_interval[1] and two.time_interval[0] <= one.time_interval[1]
    assert np.allclose(one.point, two.point, atol=1e-9)
    assert one.element_a.kind == two.element_b.kind and one.element_b.kind == two.element_a.kind


def test_all_times_of_a_cone_under_a_screw():
    """Boxes next to the apex were wide for good; contact was followed no farther than 0.459."""
    (found,) = fc.contact_intervals(*SCREWED)
    assert found.start_interval[1] - found.start_interval[0] <= 1e-12 >= found.end_interval[1] - found.end_interval[0]
    inside = np.linspace(found.start + 1e-4, found.end - 1e-4, 9)
    assert all(_ruling_crosses(SCREWED[0].motion(t)) for t in inside)
    outside = [0, 0.2, 0.4, found.start - 1e-4, found.end + 1e-4, 0.5, 0.6, 0.8, 1]
    assert not any(_ruling_crosses(SCREWED[0].motion(t)) for t in outside)


def _ruling_crosses(pose):
    """Whether one of many rulings of the cone meets the other piece; by Delta's zeros, at the pose."""
    apex = np.array([3.5, -1.5, -0.5])
    pose = np.asarray(pose, float)
    apex = pose[:3, :3] @ apex + pose[:3, 3]
    v = np.linspace(0, 1, 2001)
    one, other = np.array([(3 * v - 2) / (v + 3), v**0, 1 / (v + 3)]).T, np.array([-3 * v**0, -2 * v - 3, v + 3]).T
    for u in np.linspace(0, 1, 201):
        base = np.array([(6 * u * u + 4 * u + 9) / 2, (-6 * u * u - 2 * u - 1) / 2, (4 * u * u - 3) / 2])
        base = pose[:3, :3] @ base + pose[:3, 3]
        normal = np.cross(apex - base, other - one)
        delta = ((one - base) * normal).sum(1)
        for k in np.flatnonzero(delta[1:] * delta[:-1] <= 0):
            s, w = np.linalg.lstsq(np.array([apex - base, one[k] - other[k]]).T, one[k] - base, rcond=None)[0]
            if 0 <= s <= 1 and 0 <= w <= 1:
                return True
    return False


@pytest.mark.thorough
def test_the_trimmed_scene_in_both_orders_and_both_verbs():
    """Intervals gave [1/3, 1/2] where first_contact refused."""
    cut = fc.RuledSurface("(u,0,0)", "(1,u**2,u)", trim=["u**2+s**2<=1"])
    moving = cut.translated((-3, 0, 0)).moving(fc.Translation((6, 0, 0)))
    resting = fc.RuledSurface("(0,u,u**2)", "(u,1,1+u)")
    (interval,) = fc.contact_intervals(moving, resting)
    assert interval.start == pytest.approx(1 / 3, abs=1e-12) and interval.end == pytest.approx(1 / 2, abs=1e-12)
    for pair in ((moving, resting), (resting, moving)):
        found = fc.first_contact(*pair)
        assert found.status is fc.Status.CONTACT and found.time_interval[0] <= 1 / 3 <= found.time_interval[1]


@pytest.mark.share(2)
@pytest.mark.parametrize("method", ["auto", "certified", "algebraic"])
def test_intervals_take_a_method(method):
    """A ball of radius 1 passes one of radius 2, centres on one line: from |8 t - 4| = 3 on, until it is 3 again."""
    pair = fc.sphere(1).translated((-4, 0, 0)).moving(fc.Translation((8, 0, 0))), fc.sphere(2)
    (found,) = fc.contact_intervals(*pair, method=method)
    assert found.start == pytest.approx(1 / 8, abs=1e-11) and found.end == pytest.approx(7 / 8, abs=1e-11)
    if method == "certified" and not THOROUGH:  # a face that lands flat takes balls ten seconds
        return
    block = fc.box((2, 2, 2)).translated((-4, 0, 0)).moving(fc.Translation((8, 0, 0)))
    assert fc.contact_intervals(block, PLATE, method=method).intervals[0].start == pytest.approx(3 / 8, abs=1e-11)


def test_a_method_that_is_none_is_named():
    with pytest.raises(fc.UnsupportedPair, match="method 'quick' is unknown"):
        fc.contact_intervals(fc.sphere(1), fc.sphere(2), method="quick")


def test_elimination_takes_the_bodies_in_the_order_in_which_equations_are_smaller():
    """A deforming piece beside one on a trajectory: equations of degree 88 one way, of 560 the other."""
    poses = np.array([
        [[-1, 0, 0, 3], [0, 0, 1, 1], [0, 1, 0, -2], [0, 0, 0, 1]],
        [[0, -1, 0, -1], [1, 0, 0, -4], [0, 0, 1, -1], [0, 0, 0, 1]],
        [[1, 0, 0, 4], [0, 1, 0, 1], [0, 0, 1, 2], [0, 0, 0, 1]],
    ], float)  # fmt: skip
    cut = fc.RuledSurface("(u,0,0)", "(1,u**2,u)", trim=["u**2+s**2<=1"]).translated((4, 1, -2))
    moving = cut.moving(fc.Trajectory((0, 0.5, 1), poses))
    deforming = fc.RuledSurface("(u,0,0)", "(u,2,T)").rotated((1, 0, 0), degrees=270).translated((0, 1, 2))
    bodies = moving, deforming.moving(fc.Translation((4, 2, -3)))
    hit, back = (fc.first_contact(*some, method="algebraic") for some in (bodies, bodies[::-1]))
    assert hit.status is back.status is fc.Status.CONTACT and hit.time == back.time
    assert (hit.element_a.kind, hit.element_b.kind) == (back.element_b.kind, back.element_a.kind)
    assert hit.point == pytest.approx(back.point) and (back.a, back.b) == bodies[::-1]
    intervals, other = (fc.contact_intervals(*some, method="algebraic") for some in (bodies, bodies[::-1]))
    assert [(x.start, x.end) for x in intervals] == [(x.start, x.end) for x in other] and other.a is bodies[1]


def test_equations_of_many_triangles_are_work(monkeypatch):
    """A budget ends before those of all triangles are set up; they are most of what such a question takes."""
    made = []
    whole = first.conditions
    monkeypatch.setattr(first, "conditions", lambda *of: made.append(of) or whole(*of))
    ball = fc.Polyhedron.from_trimesh(trimesh.creation.icosphere(1)).translated((0, 0, 3))
    ball = ball.moving(fc.Translation((0, 0, -9)))
    found = fc.first_contact(ball, PLATE, method="algebraic", budget=100)
    assert (found.status, found.reason) == (fc.Status.UNDECIDED, "budget") and 0 < len(made) <= 100 // first.SETUP + 1
    made.clear()
    assert fc.first_contact(ball, PLATE, method="algebraic").status is fc.Status.CONTACT and len(made) > 30
