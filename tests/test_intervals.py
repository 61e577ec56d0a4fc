"""All contact intervals against the slow truth: every event time, one static test in every gap."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

import firstcontact as fc
import generators as g
import naive
from agreement import library_span, question, reference, reference_motion, width_scale
from amount import amount
from generators import Scene, lattice_scene
from vectors import Body

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])


def assert_same_intervals(scene: Scene, exact: bool = False) -> int:
    """Same intervals, ends correctly rounded and enclosed; returns how many there are."""
    motion, end_of_span = reference_motion(scene), float(library_span(scene)[1])
    truth = reference(naive.contact_intervals, scene)
    found = fc.contact_intervals(*question(scene), exact=exact)
    rounded = [tuple(end_of_span if t is None else motion.nearest(t) for t in pair) for pair in truth]
    assert [(i.start, i.end) for i in found] == rounded, f"reference {rounded}: {scene}"
    for interval, pair in zip(found, truth, strict=True):
        for enclosure, t in zip((interval.start_interval, interval.end_interval), pair, strict=True):
            assert_encloses(enclosure, t, scene)
    expected = naive.FREE if not truth else naive.CONTACT
    if truth and rounded[0][0] == 0:
        expected = naive.INITIAL
    assert found.status.name == expected, scene
    return len(truth)


def assert_encloses(enclosure, t, scene: Scene) -> None:
    lo, hi = enclosure
    end = float(library_span(scene)[1])
    if t is None:
        assert lo <= end <= hi
        return
    motion = reference_motion(scene)
    assert motion.enclosed(t, lo, hi), scene
    assert hi - lo <= 1e-12 * width_scale(scene, motion.nearest(t)), scene


def bounded(seed: int, rotating: bool) -> Scene:
    """A lattice scene over at most one turn, solid where both bodies are closed."""
    s = lattice_scene(seed, rotating)
    solid = seed % 2 == 0 and g.is_closed(s.a) and g.is_closed(s.b)
    if rotating:
        assert s.rotation is not None
        angle = {"radians": 3} if s.rotation.get("radians") == 7 else {}
        return Scene(s.a, s.b, rotation={**s.rotation, **angle}, solid=solid)
    return Scene(s.a, s.b, s.translation, until=3 if s.until is None else s.until, solid=solid)


@pytest.mark.share(3)
@MOTIONS
@pytest.mark.parametrize("first", range(0, amount(600), 50))
def test_lattice_scenes(first, rotating):
    counts = [assert_same_intervals(bounded(seed, rotating)) for seed in range(first, first + 50)]
    assert max(counts) > 0


@pytest.mark.share(2)
@MOTIONS
def test_lattice_scenes_exactly(rotating):
    for seed in range(5000, 5000 + amount(80, 4)):
        assert_same_intervals(bounded(seed, rotating), exact=True)


def test_sliding_through_a_ring_of_boxes_makes_one_interval_per_box():
    row = [g.box((1, 1, 1), (3 * k, 0, 0)) for k in range(3)]
    b = Body(
        [p for x in row for p in x.v], [], [[i + 8 * k for i in f] for k, x in enumerate(row) for f in x.f]
    )
    scene = Scene(g.box((1, 1, 1), (-2, 0, 0)), b, translation=(1, 0, 0), until=12, solid=True)
    assert assert_same_intervals(scene) == 3
    found = fc.contact_intervals(*question(scene))
    assert [(i.start, i.end) for i in found] == [(1, 3), (4, 6), (7, 9)]


def test_a_solid_inside_a_solid_stays_in_contact():
    scene = Scene(g.box((1, 1, 1), (-3, 1, 1)), g.box((4, 4, 4)), translation=(1, 0, 0), until=20)
    surfaces = [(i.start, i.end) for i in fc.contact_intervals(*question(scene))]
    assert surfaces == [(2, 3), (6, 7)]
    solid = Scene(scene.a, scene.b, scene.translation, until=20, solid=True)
    assert [(i.start, i.end) for i in fc.contact_intervals(*question(solid))] == [(2, 7)]


def test_touching_at_one_time_is_an_interval_of_one_point():
    scene = Scene(g.box((1, 1, 1), (-3, 1, 1)), g.box((1, 1, 1)), translation=(1, 0, 0), until=20)
    assert assert_same_intervals(scene) == 1  # edge slides along edge
    corner = Scene(
        Body([[-3, 0, 0]], [], []),
        Body([[0, -1, 0], [0, 1, 0]], [[0, 1]], []),
        translation=(2, 0, 0),
        until=4,
    )
    found = fc.contact_intervals(*question(corner))
    assert [(i.start, i.end) for i in found] == [(1.5, 1.5)]


def test_a_full_turn_comes_back_to_its_start():
    post = Body([[2, 0, -1], [2, 0, 1]], [[0, 1]], [])
    arm = Body([[1, 0, 0], [3, 0, 0]], [[0, 1]], [])
    scene = Scene(arm, post, rotation={"axis": (0, 0, 1), "point": (0, 0, 0), "turns": 1})
    found = fc.contact_intervals(*question(scene))
    assert [(i.start, i.end) for i in found] == [(0, 0), (1, 1)]
    assert assert_same_intervals(scene) == 2


def test_several_turns_repeat_the_contacts():
    post = Body([[0, 2, -1], [0, 2, 1]], [[0, 1]], [])
    arm = Body([[1, 0, 0], [3, 0, 0]], [[0, 1]], [])
    scene = Scene(arm, post, rotation={"axis": (0, 0, 1), "turns": Fraction(5, 2)})
    times = [(i.start, i.end) for i in fc.contact_intervals(*question(scene))]
    assert times == [(t, t) for t in (0.1, 0.5, 0.9)]


def test_contact_that_never_ends():
    scene = Scene(
        Body([[-3, 0, 0]], [], []), Body([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [], [[0, 1, 2]]), (1, 0, 0)
    )
    found = fc.contact_intervals(*question(scene))
    assert [(i.start, i.end) for i in found] == [(3, 4)]
    resting = Scene(scene.a, Body([[-3, 0, 0]], [], []), translation=(0, 0, 0))
    assert [(i.start, i.end) for i in fc.contact_intervals(*question(resting))] == [(0, math.inf)]
