"""One joint that moves at a changing pace: judged by the distance of a box and a ball, and by its value's own clock."""

import math
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.runs import one_joint
from firstcontact.result import Stats
from firstcontact.work import Query

HALF = np.array([1.0, 0.25, 0.5])
MIDDLE = np.array([1.25, 0, 0])


def hinged(unit="turn"):
    """A leaf, 2 x 1/2 x 1, on a hinge along z."""
    leaf = fc.examples.box((2, F(1, 2), 1)).translated((F(5, 4), 0, 0)).named("leaf")
    post = fc.examples.box((F(1, 8), F(1, 8), 9)).translated((0, 0, 30)).named("post")
    joint = fc.Joint("hinge", "revolute", "post", "leaf", axis=(0, 0, 1), point=(0, 0, 0), unit=unit)
    return fc.Mechanism({"post": post, "leaf": leaf}, [joint])


def leaf_of(times, values, **how):
    course = hinged().course(times, {"hinge": values}, interpolation="cubic", **how)
    return course.bodies["leaf"][0]


def gap(turns, centre, radius):
    """The distance of a ball from the leaf at these turns, by the formula of a box."""
    angle = -2 * math.pi * np.asarray(turns)
    x, y, z = centre
    local = np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y,
                      np.full_like(angle, z)], axis=-1) - MIDDLE  # fmt: skip
    return np.linalg.norm(np.maximum(np.abs(local) - HALF, 0.0), axis=-1) - radius


def hermite(times, values, velocities):
    """The value at any time, by the basis of Hermite."""
    def at(t):
        k = np.clip(np.searchsorted(times, t, "right") - 1, 0, len(times) - 2)
        h = times[k + 1] - times[k]
        s = (t - times[k]) / h
        return ((1 + 2 * s) * (1 - s) ** 2 * values[k] + s * (1 - s) ** 2 * h * velocities[k]
                + s**2 * (3 - 2 * s) * values[k + 1] + s**2 * (s - 1) * h * velocities[k + 1])  # fmt: skip

    return at


def test_times_are_those_of_the_distance():
    rng, met = np.random.default_rng(20261128), 0
    for _ in range(amount(60, 10)):
        times = np.array([0.0, 1.0, 1.5, 3.0])
        values, velocities = rng.integers(-8, 9, 4) / 16, rng.integers(-8, 9, 4) / 8
        centre, radius = np.append(rng.integers(-16, 17, 2) / 8, rng.integers(-6, 7) / 8), rng.integers(1, 5) / 8
        leaf = leaf_of(times.tolist(), values.tolist(), velocities={"hinge": velocities.tolist()})
        ball = fc.sphere(radius).translated(centre.tolist())
        hit, found = fc.first_contact(leaf, ball), fc.contact_intervals(leaf, ball)
        t = np.linspace(0, 3, 3001)
        there = gap(hermite(times, values, velocities)(t), centre, radius)
        told = np.zeros(len(t), bool)
        for x in found:
            told |= (x.start_interval[0] <= t) & (t <= x.end_interval[1])
        assert found.status is not fc.Status.UNDECIDED and hit.status is not fc.Status.UNDECIDED
        assert not np.any(told & (there > 1e-9)) and not np.any(~told & (there < -1e-9)), (values, velocities, centre)
        assert hit.status is found.status
        if len(found):
            met += 1
            assert hit.time_interval[0] <= found[0].start_interval[1]
            assert found[0].start_interval[0] <= hit.time_interval[1]
            width = hit.time_interval[1] - hit.time_interval[0]
            assert width <= 3.1e-12
        for x in found:
            for lo, hi in (x.start_interval, x.end_interval):
                ends = gap(hermite(times, values, velocities)(np.array([lo, hi])), centre, radius)
                assert np.abs(ends).min() < 1e-9 or lo <= 0.0 or hi >= 3.0 or there[0] < 0
    assert met > 2


def test_a_leaf_that_comes_to_rest_flush_touches_at_the_end_alone():
    leaf = leaf_of([0, 1], [F(1, 4), 0], velocities={"hinge": [0, 0]})
    wall = fc.examples.box((4, 1, 4)).translated((2, F(-3, 4), 0))  # its face is the leaf's lower side at the value 0
    hit = fc.first_contact(leaf, wall)
    assert (hit.status, hit.time, hit.time_interval) == (fc.Status.CONTACT, 1.0, (1.0, 1.0))
    (only,) = fc.contact_intervals(leaf, wall)
    assert (only.start, only.end) == (1.0, 1.0)


def test_faces_that_slide_across_the_axis():
    """Level with each other all the time: the octahedron's corners slide in the plane of the prism's side."""
    sides = [[5, 3, 1], [5, 0, 3], [4, 1, 3], [4, 3, 0], [2, 0, 5], [2, 5, 1], [2, 4, 0], [2, 1, 4]]
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    still = fc.Polyhedron(corners, sides).translated((2, 3, -2)).named("still")
    outline = (-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)
    walls = ([i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6))
    prism = fc.Polyhedron([(x, y, z) for z in (-1, 1) for x, y in outline],
                          [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *walls]).translated((-3, 2, 2))  # fmt: skip
    joint = fc.Joint("j", "revolute", "still", "prism", axis=(0, 1, 0), point=(-3, -2, -3), unit="turn")
    machine = fc.Mechanism({"still": still, "prism": prism.named("prism")}, [joint])
    course = machine.course([0, 1], {"j": [1, F(-1, 4)]}, interpolation="cubic", velocities={"j": [0, 0]})
    found = fc.contact_intervals(still, course.bodies["prism"][0])
    turn = fc.Rotation((0, 1, 0), (-3, -2, -3), turns=-1)
    (plain,) = fc.contact_intervals(still, prism.moving(turn), (-1, F(1, 4)))

    def time_of(u):  # 1 - 5/4 (3 s^2 - 2 s^3) = -u
        return min(np.roots([2.5, -3.75, 0, 1 + u]), key=lambda s: abs(s.real - 0.5) + abs(s.imag)).real

    assert [(x.start, x.end) for x in found] == [
        (pytest.approx(time_of(plain.start), abs=1e-12), pytest.approx(time_of(plain.end), abs=1e-12))
    ]


def test_a_turning_point_in_contact_and_one_that_is_missed():
    """Values 0, 1/4 with speeds by which the leaf turns back within: the ball is where it is deepest, or beyond."""
    velocities = {"hinge": [F(2), F(-1)]}
    leaf = leaf_of([0, 1], [0, F(1, 4)], velocities=velocities)
    at = hermite(np.array([0.0, 1.0]), np.array([0.0, 0.25]), np.array([2.0, -1.0]))
    t = np.linspace(0, 1, 200001)
    most = float(at(t).max())
    assert 0.3 < most < 0.6
    for ahead, meets in ((-0.02, True), (0.06, False)):
        angle = 2 * math.pi * (most + ahead)
        c, s = math.cos(angle), math.sin(angle)
        centre = [round(1.5 * c - 0.3 * s, 6), round(1.5 * s + 0.3 * c, 6), 0]
        ball = fc.sphere(F(1, 16)).translated(centre)
        truth = gap(at(t), centre, 1 / 16) <= 0
        assert truth.any() == meets
        hit, found = fc.first_contact(leaf, ball), fc.contact_intervals(leaf, ball)
        assert (hit.status is fc.Status.CONTACT) == meets
        if meets:
            inside = t[truth]
            assert hit.time == pytest.approx(inside[0], abs=1e-5)
            assert [(x.start, x.end) for x in found] == [
                (pytest.approx(inside[0], abs=1e-5), pytest.approx(inside[-1], abs=1e-5))
            ]


def test_what_deforms_does_so_by_the_time():
    """A spike that rises by 4 T meets the leaf's lower side at T = 1/8, wherever the hinge is then."""
    leaf = leaf_of([0, 1], [0, F(1, 4)], velocities={"hinge": [0, 0]})
    rim = "(5/4 + (1 - u**2)/(10 + 10*u**2), u/(5 + 5*u**2), 4*T - 2)"
    hit = fc.first_contact(leaf, fc.RuledSurface("(5/4, 0, 4*T - 1)", rim, u=(-1, 1)))
    assert hit.status is fc.Status.CONTACT
    assert hit.time == pytest.approx(0.125, abs=1e-9)


def test_what_is_told_of_a_place_is_told_in_the_world():
    leaf = leaf_of([0, 1], [F(1, 4), 0], velocities={"hinge": [0, 0]})
    hit = fc.first_contact(leaf, fc.sphere(F(1, 4)).translated((F(3, 2), F(1, 2), 0)))
    assert hit.status is fc.Status.CONTACT and hit.a is leaf
    assert hit.element_a.body == "leaf"
    at = np.array([1.5, 0.5, 0.0])
    assert np.linalg.norm(hit.point - at) == pytest.approx(0.25, abs=1e-9)
    assert np.linalg.norm(hit.normal) == pytest.approx(1.0) and abs(np.dot(hit.normal, hit.point - at)) > 0.2499
    (value,) = hit.joints
    assert value.name == "hinge" and value.interval[0] <= value.value <= value.interval[1]
    assert gap(np.array([value.value]), at, 0.25) == pytest.approx(0.0, abs=1e-9)
    assert hit.stats.ways and hit.free_until == hit.time_interval[0]


def test_a_slide_that_comes_to_rest_at_a_third():
    """No double is its last value, and near it the value hardly changes: the ends are told as that of the span."""
    slide = fc.Joint("slide", "prismatic", "wall", "block", axis=(1, 0, 0))
    block = fc.examples.box((1, 1, 1)).translated((F(-5, 6), 0, 0)).named("block")  # its side is at -1/3
    for wall, met in (((F(1, 2), 0, 0), (1.0, 1.0)), ((F(1, 2) - F(1, 27), 0, 0), (2 / 3, 1.0))):
        still = fc.examples.box((1, 2, 2)).translated(wall).named("wall")
        course = fc.Mechanism({"wall": still, "block": block}, [slide]).course(
            [0, 1], {"slide": [0, F(1, 3)]}, interpolation="cubic", velocities={"slide": [0, 0]})  # fmt: skip
        moved = course.bodies["block"][0]
        hit, (only,) = fc.first_contact(moved, still), fc.contact_intervals(moved, still)
        if met[0] == 1.0:
            assert hit.time_interval == only.start_interval == (1.0, 1.0)
        else:  # (3 s^2 - 2 s^3) / 3 = 8/27 - 1/27 at s = 2/3, so that the wall is 1/27 before the end
            assert hit.time == pytest.approx(_time_of_slide(F(1, 3) - F(1, 27)), abs=1e-11)
        assert only.end_interval == (1.0, 1.0)


def _time_of_slide(value):
    """The time in [0, 1] at which (3 s^2 - 2 s^3) / 3 has it."""
    return min(np.roots([-2 / 3, 1, 0, -float(value)]), key=lambda s: abs(s.real - 0.5) + abs(s.imag)).real


def test_a_touch_within_what_is_cut_out_around_an_irrational_turning_point():
    """The leaf turns back 1e-12 of a turn beyond the touch: times of contact are a few millionths long."""
    speeds = np.array([2.0, -1.0])
    leaf = leaf_of([0, 1], [0, F(1, 4)], velocities={"hinge": speeds.tolist()})
    at = hermite(np.array([0.0, 1.0]), np.array([0.0, 0.25]), speeds)
    # the value is t^3/2 - 9/4 t^2 + 2 t: its slope is 0 at 3/2 - sqrt(11/12), and bends by this
    turn = 1.5 - math.sqrt(11 / 12)
    bend = 4.5 - 3 * turn
    angle = 2 * math.pi * (float(at(np.array([turn]))[0]) - 1e-12)
    c, s = math.cos(angle), math.sin(angle)
    ball = fc.sphere(F(1, 4)).translated([1.5 * c - 0.5 * s, 1.5 * s + 0.5 * c, 0.0])
    half = math.sqrt(2e-12 / bend)
    (only,) = fc.contact_intervals(leaf, ball)
    assert (only.start - turn, only.end - turn) == (pytest.approx(-half, abs=1e-9), pytest.approx(half, abs=1e-9))


def test_an_enclosure_is_as_close_as_asked_where_the_value_hardly_changes():
    """1e-14 before a slide comes to rest: times are a million times as wide as values."""
    slide = fc.Joint("slide", "prismatic", "wall", "ball", axis=(1, 0, 0))
    still, ball = fc.examples.box((1, 2, 2)).named("wall"), fc.sphere(1).translated((F(-11, 6) + F(1, 10**14), 0, 0))
    course = fc.Mechanism({"wall": still, "ball": ball.named("ball")}, [slide]).course(
        [0, 1], {"slide": [0, F(1, 3)]}, interpolation="cubic", velocities={"slide": [0, 0]})  # fmt: skip
    hit = fc.first_contact(course.bodies["ball"][0], still)
    lo, hi = hit.time_interval
    assert lo <= hi <= lo + 1e-11
    assert 1 - hi**2 * (3 - 2 * hi) <= 3e-14 <= 1 - lo**2 * (3 - 2 * lo) + 2e-16


def test_questions_on_the_clock_of_the_value_count_and_tell_progress_on_that_of_time():
    still, leaf = fc.sphere(1).translated((0, 0, 9)), leaf_of([10, 12], [0, F(1, 4)], velocities={"hinge": [0, 0]})
    told, budgets = [], []

    def answer(own):
        budgets.append(own.budget)
        end = own.span[1]
        if not own.exact:
            own.progress(own.span[0], 0.5)
        around = (end, end) if own.exact else (end - 1e-9, end)
        return fc.FirstContact(
            fc.Status.CONTACT, end, around, F(1, 4) if own.exact else None, free_until=around[0],
            stats=Stats(node_visits=5), **own.shared)  # fmt: skip

    query = replace(Query(leaf, still, fmpq(10), fmpq(12)), budget=100, progress=lambda t, done: told.append((t, done)))
    hit = one_joint.first(answer, query)
    assert (hit.status, hit.time_interval, hit.stats.node_visits) == (fc.Status.CONTACT, (12.0, 12.0), 10)
    assert budgets == [100, 95] and told == [(10.0, 0.5)]
