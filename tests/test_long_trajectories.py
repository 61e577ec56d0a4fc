"""Trajectories of many poses: as their steps one by one tell it, and with only those steps made that are looked at."""

from __future__ import annotations

import pickle
from itertools import pairwise

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Status
from firstcontact.contact.runs import along
from firstcontact.errors import InputError
from firstcontact.motion import trajectory
from firstcontact.motion.relative import chords

SEED = 41
KINDS = ["linear-quaternion", "screw"]
TOOL = fc.examples.box((1, 1, 4))
PARTS = {
    "box": fc.examples.box((3, 3, 3)), "torus of triangles": fc.examples.torus(300), "cone": fc.cone(2, 3),
    "saddle": fc.RuledSurface("(4*u-2, -2, 2-4*u)", "(4*u-2, 2, 4*u-2)"),
}  # fmt: skip


def wandering(rng, count):
    """Poses along a bent way past the origin: vectors and quaternions."""
    s = np.linspace(0, 1, count)
    a, b, c = rng.uniform(-2, 2, 3)
    places = np.stack([16 * s - 8, a + 3 * np.sin(5 * s + b), c + 4 * np.cos(4 * s)], axis=1)
    quaternions = np.concatenate([np.ones((count, 1)), 0.5 * np.sin(np.outer(s, rng.uniform(1, 6, 3)))], axis=1)
    return np.round(places, 4).tolist(), np.round(quaternions, 4).tolist()


def by_steps(shape, other, times, places, quaternions, kind):
    """The first contact of each step as a motion of its own, in turn: its time, None without contact."""
    for k, (start, end) in enumerate(pairwise(times)):
        step = fc.Trajectory([start, end], places[k : k + 2], kind, quat_wxyz=quaternions[k : k + 2])
        found = fc.first_contact(shape.moving(step), other)
        assert found.status is not Status.UNDECIDED
        if found.status is not Status.FREE:
            return found.time
    return None


@pytest.mark.share(3)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("seed", range(3))
def test_first_contacts_are_those_of_the_steps(part, kind, seed):
    rng = np.random.default_rng([SEED, seed])
    count = 3 * along.LONG + seed
    times = np.cumsum(rng.uniform(0.1, 1.0, count)).round(3).tolist()
    places, quaternions = wandering(rng, count)
    path = fc.Trajectory(times, places, kind, quat_wxyz=quaternions)
    for a, b in ((TOOL.moving(path), PARTS[part]), (PARTS[part], TOOL.moving(path))):
        found = fc.first_contact(a, b)
        expected = by_steps(TOOL, PARTS[part], times, places, quaternions, kind)
        assert (found.status is Status.FREE) == (expected is None)
        if expected is not None:
            assert found.time == pytest.approx(expected, abs=1e-9)
            assert found.element_a is not None


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", KINDS)
def test_intervals_hold_sampled_contacts_and_no_sampled_gap(kind):
    """A ball passes a ball: their distance tells all."""
    rng = np.random.default_rng(SEED)
    count = 5 * along.LONG
    s = np.linspace(0, 12, count)
    places = np.stack([3 * np.sin(s), 3 * np.cos(1.7 * s), 0.3 * s - 2], axis=1).round(4)
    quaternions = rng.normal(size=4) + 0.1 * np.cumsum(rng.normal(size=(count, 4)), axis=0)
    path = fc.Trajectory(s.tolist(), places.tolist(), kind, quat_wxyz=quaternions.round(3).tolist())
    ball, other = fc.sphere(1), fc.sphere("3/2")
    found = fc.contact_intervals(ball.moving(path), other)
    assert found.status is not Status.UNDECIDED and len(found) > 3
    for t in np.linspace(0, 12, 4001):
        beyond = np.linalg.norm(path(t)[:3, 3]) - 2.5
        if abs(beyond) > 1e-6:
            assert any(x.start <= t <= x.end for x in found) == (beyond < 0), t


@pytest.mark.parametrize("kind", KINDS)
def test_points_stay_within_half_chords(kind):
    rng = np.random.default_rng(SEED)
    places = rng.normal(size=(40, 3)).round(3).tolist()
    quaternions = rng.normal(size=(40, 4)).round(2).tolist()
    path = fc.Trajectory(range(40), places, kind, quat_wxyz=quaternions)
    points = rng.normal(size=(5, 3)) * [[1], [1], [10], [0.1], [0]]
    middles, far = chords.places(path, points)
    for t in np.linspace(0, 39, 1500)[:-1]:
        k = int(t)
        pose = path(t)
        off = np.linalg.norm(points @ pose[:3, :3].T + pose[:3, 3] - middles[k], axis=1)
        assert (off <= far[k] + 1e-12).all()


@pytest.mark.parametrize("kind", KINDS)
def test_what_lies_on_a_table_all_along_is_one_contact(kind):
    """Across all seams, where one run of steps ends and another begins."""
    count = 4 * along.LONG + 1
    path = fc.Trajectory(
        range(count), [(k % 7, k % 5, 0) for k in range(count)], kind,
        quat_wxyz=[(9, 0, 0, k % 3) for k in range(count)],
    )
    box, table = fc.examples.box((1, 1, 1)), fc.examples.box((60, 60, 2)).translated((0, 0, "-3/2"))
    for a, b in ((box.moving(path), table), (table, box.moving(path))):
        (only,) = fc.contact_intervals(a, b)
        assert (only.start, only.end) == (0, count - 1)
        assert fc.first_contact(a, b).status is Status.INITIAL_CONTACT


def test_contact_that_begins_and_ends_at_a_seam():
    """It lands with the last step of a run, and lifts with the next one."""
    seam = along.LONG
    heights = [1] * seam + [0] + [1] * (3 * seam)
    path = fc.Trajectory(range(len(heights)), [(0, 0, h) for h in heights], quat_wxyz=[(1, 0, 0, 0)] * len(heights))
    box = fc.examples.box((1, 1, 1))
    for part in (fc.examples.box((4, 4, 1)), fc.box((4, 4, 1)) - fc.cylinder("1/4", 3)):
        a, b = box.moving(path), part.translated((0, 0, -1))
        hit = fc.first_contact(a, b)
        assert (hit.status, hit.time) == (Status.CONTACT, seam)
        assert [(x.start, x.end) for x in fc.contact_intervals(a, b)] == [(seam, seam)]
        assert fc.first_contact(a, b, (seam + 1, 3 * seam)).status is Status.FREE
        assert fc.first_contact(a, b, (seam, 3 * seam)).status is Status.INITIAL_CONTACT
        (again,) = fc.contact_intervals(a, b, (seam, 3 * seam))
        assert (again.start, again.end) == (seam, seam)


def test_only_steps_that_are_near_are_made_and_two_such_paths_are_told_apart():
    count = 4000
    s = np.linspace(0, 1, count)
    places = np.stack([100 * s, 0 * s, 0 * s], axis=1).tolist()
    path = fc.Trajectory(s.tolist(), places, quat_wxyz=[(1, 0, 0, 0.1)] * count)
    beside = fc.Trajectory(s.tolist(), [(x, 9, 0) for x, _, _ in places], quat_wxyz=[(1, 0, 0, 0)] * count)
    wall = fc.examples.box((1, 1, 1)).translated((50, 0, 0))
    hit = fc.first_contact(TOOL.moving(path), wall)
    assert hit.status is Status.CONTACT
    assert len(path.steps._made) == 0 and sum(len(x.steps._made) for x in path._parts.values()) < 100
    assert fc.first_contact(TOOL.moving(beside), wall).status is Status.FREE
    assert not beside._parts
    assert fc.first_contact(TOOL.moving(path), TOOL.moving(beside)).status is Status.FREE
    again = pickle.loads(pickle.dumps(path))
    assert again == path != beside and hash(again) == hash(path)


def test_budgets_and_bad_poses_of_long_paths():
    count = 3 * along.LONG
    places, quaternions = wandering(np.random.default_rng(SEED), count)
    path = fc.Trajectory(range(count), places, quat_wxyz=quaternions)
    few = fc.first_contact(TOOL.moving(path), PARTS["box"], budget=2)
    assert few.status is Status.UNDECIDED and few.reason == "budget"
    hit = fc.first_contact(TOOL.moving(path), PARTS["box"])
    assert few.free_until <= (hit.time if hit.time is not None else count)
    quaternions[70] = [0, 0, 0, 1]
    quaternions[71] = [1, 0, 0, 0]
    with pytest.raises(InputError, match=r"poses\[70\] and poses\[71\] are half a turn apart"):
        fc.Trajectory(range(count), places, quat_wxyz=quaternions)


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_that_are_too_large_are_told_at_once(kind):
    """Not when a step is made: of poses that far apart, and of a turn so slight that its axis is far away."""
    large, turned = 3 * 2**148, [(3, 3, 3, 2), (3, 3, 3, 2), (4, 3, 3, 2)]
    with pytest.raises(InputError, match=r"2\^150"):
        fc.Trajectory([0, 1, 2], [(large, 0, 0), (large, large, 0), (0, 0, 0)], kind, quat_wxyz=turned)
    slight = [(2**200, 0, 0, 0), (2**200, 1, 0, 0)]
    if kind == "screw":
        with pytest.raises(InputError, match=r"2\^150"):
            fc.Trajectory([0, 1], [(0, 0, 0), (0, 1, 0)], kind, quat_wxyz=slight)


def test_a_motion_in_a_shifted_world_is_another_one_than_that_between_its_poses():
    """Its steps are those of before, to their rounding."""
    path = fc.Trajectory([0, 1], [(0, 0, 0), (1, 2, 3)], "screw", quat_wxyz=[(1, 0, 0, 0), (5, 1, 2, 0)])
    moved = path.shifted((1, 1, 0))
    places = [[str(c) for c in pose.vector] for pose in moved.poses]
    again = fc.Trajectory([0, 1], places, "screw", quat_wxyz=[(1, 0, 0, 0), (5, 1, 2, 0)])
    assert moved.poses == again.poses
    assert moved != again and moved == path.shifted((1, 1, 0))


def test_parts_that_are_kept_are_few(monkeypatch):
    monkeypatch.setattr(trajectory, "MOST_PARTS", 3)
    monkeypatch.setattr(trajectory, "MOST_KEPT", 8)
    count = 8 * along.LONG
    path = fc.Trajectory(range(count), [(k % 2, 0, 0) for k in range(count)], quat_wxyz=[(1, 0, 0, 0)] * count)
    post = fc.examples.box((1, 1, 1)).translated((0, "3/2", 0))
    assert fc.first_contact(fc.examples.box((1, 1, 1)).moving(path), post).status is Status.FREE
    assert 0 < len(path._parts) <= 3
    assert all(len(x.steps._made) <= 8 for x in path._parts.values())


@pytest.mark.parametrize("count", [6, along.LONG + 2, along.LONG + 4])
def test_a_span_that_begins_at_a_knot_in_touch(count):
    """A ball stands on another one at a knot, and goes into it: at once, whatever the poses of other knots."""
    knot = count - 4
    heights = [20.0] * count
    heights[knot - 1 : knot + 2] = 7, 3, 2
    turned = [(2, 1, 0, 0) if k % 2 else (2, 0, 0, 1) for k in range(count)]
    turned[knot - 1 : knot + 2] = [(1, 0, 0, 0)] * 3
    path = fc.Trajectory(range(count), [(0, 0, h) for h in heights], "screw", quat_wxyz=turned)
    for pair in ((fc.sphere(1).moving(path), fc.sphere(2)), (fc.sphere(2), fc.sphere(1).moving(path))):
        for end in (1, 2):
            found = fc.contact_intervals(*pair, span=(knot, knot + end))
            assert found.status is Status.INITIAL_CONTACT
            assert found[0].start == knot
            assert fc.first_contact(*pair, span=(knot, knot + end)).initial == "touching"
