"""Polyhedra under rational motions, screws, trajectories and sequences of them: agreement with the engines for one
translation and one rotation, with sampled poses, and the laws.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from curved import (
    ONE,
    assert_first_by_sampling,
    pose,
    random_body,
    rational_translation,
    rational_turn,
    share_points,
    turned_by,
)

CUBE = fc.examples.box((1, 1, 1))
Status = fc.Status
AXES = [(0, 0, 1), (1, 0, 0), (0, -1, 0), (1, 1, 0), (1, 2, 2)]


def same_contact(x, y) -> None:
    assert x.status is y.status, (x, y)
    assert x.initial == y.initial
    if x.status is not Status.CONTACT:
        return
    assert (x.element_a, x.element_b, x.multiplicity) == (y.element_a, y.element_b, y.multiplicity)
    if x.multiplicity == 1:
        assert x.point == pytest.approx(y.point, abs=1e-9)
        assert (x.normal is None) == (y.normal is None)
        if x.normal is not None:
            assert x.normal == pytest.approx(y.normal, abs=1e-7)


# ---------------------------------------------------------------------------- the engines for one simple motion


@pytest.mark.parametrize("generic", [False, True], ids=["degenerate", "random"])
@pytest.mark.parametrize("block", range(amount(12)))
def test_a_translation_as_a_rational_motion(block, generic):
    for seed in range(8 * block, 8 * block + 8):
        rng = np.random.default_rng([1, seed, generic])
        a, b = random_body(rng, generic), random_body(rng, generic)
        v = rng.integers(-5, 6, 3).tolist()
        x = fc.first_contact(a.moving(rational_translation(v)), b, exact=True)
        y = fc.first_contact(a.moving(fc.Translation(v)), b, (0, 1), exact=True)
        same_contact(x, y)
        assert (x.time, x.time_exact) == (y.time, y.time_exact), seed


@pytest.mark.parametrize("generic", [False, True], ids=["degenerate", "random"])
@pytest.mark.parametrize("block", range(amount(12)))
def test_a_rotation_as_a_rational_motion(block, generic):
    for seed in range(8 * block, 8 * block + 8):
        rng = np.random.default_rng([2, seed, generic])
        a, b = random_body(rng, generic), random_body(rng, generic)
        axis, point = AXES[rng.integers(5)], (rng.integers(-4, 5, 3) / 2).tolist()
        full = turned_by(axis, 1.0)
        x = fc.first_contact(a.moving(rational_turn(axis, point)), b, (0, 0.99), exact=True)
        y = fc.first_contact(a.moving(fc.Rotation(axis, point, radians=full)), b, (0, turned_by(axis, 0.99) / full))
        same_contact(x, y)
        if x.status is Status.CONTACT:
            assert turned_by(axis, x.time) == pytest.approx(y.time * full, abs=1e-11)
            assert float(x.time_exact) == x.time and x.time_interval[0] <= x.time <= x.time_interval[1]


def test_screws_whose_relative_motion_is_simple():
    """A screw seen from a body that turns alike is a translation; from one that advances alike, a rotation."""
    contacts = 0
    for seed in range(amount(100, 4)):
        rng = np.random.default_rng([3, seed])
        a, b = random_body(rng, True), random_body(rng, True)
        axis, length = [((0, 0, 1), 1), ((0, -3, 4), 5), ((1, 2, 2), 3)][rng.integers(3)]
        point, degrees, advance = rng.normal(size=3).tolist(), int(rng.integers(-300, 300)), int(rng.integers(-6, 7))
        v = [Fraction(advance * x, length) for x in axis]
        turn, shift = fc.Rotation(axis, point, degrees=degrees), fc.Translation(v)
        screw = fc.Screw(axis, point, degrees=degrees, advance=advance)
        other, simple = (turn, shift) if seed % 2 else (shift, turn)
        x = fc.first_contact(a.moving(screw), b.moving(other))
        y = fc.first_contact(a.moving(simple), b, (0, 1))
        assert (x.status, x.initial) == (y.status, y.initial)
        if x.status is Status.CONTACT:
            contacts += 1
            assert (x.element_a, x.element_b) == (y.element_a, y.element_b)
            assert x.time == pytest.approx(y.time, abs=1e-14)
    assert contacts >= 5


def test_screws_that_only_turn_or_only_advance():
    b = CUBE.translated((0, 0, 3))
    up = fc.first_contact(CUBE.moving(fc.Screw((0, 0, 2), turns=0, advance=4)), b, exact=True)
    assert up.time_exact == Fraction(1, 2)
    turn = fc.first_contact(CUBE.moving(fc.Screw((1, 0, 0), point=(0, 0, 1.5), turns=0.5)), b, exact=True)
    same = fc.first_contact(CUBE.moving(fc.Rotation((1, 0, 0), point=(0, 0, 1.5), turns=0.5)), b, exact=True)
    assert turn.time == same.time and str(turn.time_exact) == str(same.time_exact)


# -------------------------------------------------------------------------------------------------- sampled poses


@pytest.mark.parametrize("seed", range(amount(10)))
def test_between_two_poses_against_samples(seed):
    rng = np.random.default_rng([4, seed])
    a, b = random_body(rng, True), random_body(rng, True)
    a = a.translated((3, 0, 0))
    motion = fc.RationalMotion.between(pose(), pose(rng.normal(size=3), rng.normal(size=3) * 2 - (3, 0, 0)))
    hit = fc.first_contact(a.moving(motion), b)
    assert_first_by_sampling(a.moving(motion), b, hit)


@pytest.mark.parametrize("seed", range(amount(10)))
def test_screws_against_samples(seed):
    rng = np.random.default_rng([5, seed])
    a, b = random_body(rng, True), random_body(rng, True)
    motion = fc.Screw(rng.normal(size=3), rng.normal(size=3), degrees=500, advance=float(rng.normal()))
    x, y = a.moving(motion), b
    if seed % 2:
        y = b.moving(fc.Screw(rng.normal(size=3), rng.normal(size=3), degrees=90, advance=float(rng.normal())))
    assert_first_by_sampling(x, y, fc.first_contact(x, y))


@pytest.mark.share(2)
@pytest.mark.parametrize("interpolation", ["linear-quaternion", "screw"])
@pytest.mark.parametrize("seed", range(4))
def test_trajectories_against_samples(seed, interpolation):
    rng = np.random.default_rng([6, seed])
    a, b = random_body(rng, True), random_body(rng, True)
    poses = [pose(rng.normal(size=3) / 2, (5 - 2 * k, rng.normal(), rng.normal())) for k in range(6)]
    moving = a.moving(fc.Trajectory([1, 2, 2.5, 4, 5, 7], poses, interpolation))
    hit = fc.first_contact(moving, b)
    assert hit.span == (1.0, 7.0)
    assert_first_by_sampling(moving, b, hit)


def test_an_affine_motion_that_stretches():
    grow = fc.RationalMotion([ONE, np.diag([1.0, 0, 0, 0])])
    hit = fc.first_contact(CUBE.moving(grow), CUBE.translated((1.25, 0, 0)), exact=True)
    assert hit.time_exact == Fraction(1, 2) and hit.normal.tolist() == [-1, 0, 0]
    intervals = fc.contact_intervals(CUBE.moving(grow), CUBE.translated((1.25, 0, 0)), exact=True)
    assert [(i.start_exact, i.end_exact) for i in intervals] == [(Fraction(1, 2), Fraction(1))]


# ----------------------------------------------------------------------------------------------------------- laws


def random_pair(seed: int):
    rng = np.random.default_rng([7, seed])
    a, b = random_body(rng, True).translated((2.5, 0, 0)), random_body(rng, True)
    if seed % 2:
        return a, b, fc.RationalMotion.between(pose(), pose(rng.normal(size=3), (-4, 0.2, 0.1)))
    return a, b, fc.Screw((1, 0.1, 0), rng.normal(size=3), degrees=200, advance=-5)


@pytest.mark.parametrize("seed", range(amount(12)))
def test_swapping_the_bodies(seed):
    a, b, motion = random_pair(seed)
    x, y = fc.first_contact(a.moving(motion), b), fc.first_contact(b, a.moving(motion))
    assert (x.status, x.initial, x.multiplicity) == (y.status, y.initial, y.multiplicity)
    if x.status is Status.CONTACT:
        assert x.time == pytest.approx(y.time, abs=2e-16)
        assert {x.element_a.index, x.element_b.index} == {y.element_a.index, y.element_b.index}
        assert x.point == pytest.approx(y.point, abs=1e-12) and x.normal == pytest.approx(-y.normal, abs=1e-9)


@pytest.mark.parametrize("seed", range(amount(12)))
def test_splitting_the_span(seed):
    a, b, motion = random_pair(seed)
    whole = fc.first_contact(a.moving(motion), b)
    if whole.status is not Status.CONTACT:
        return
    for cut in (whole.time / 2, whole.time * 0.999):
        early, late = (fc.first_contact(a.moving(motion), b, span) for span in ((0, cut), (cut, 1)))
        assert early.status is Status.FREE
        assert late.status is Status.CONTACT and late.time == pytest.approx(whole.time, abs=2e-16)
        assert (late.element_a, late.element_b) == (whole.element_a, whole.element_b)


@pytest.mark.parametrize("seed", range(amount(8)))
def test_time_reversed(seed):
    """The intervals of contact of the motion backward are those forward, mirrored."""
    a, b, motion = random_pair(seed)
    if isinstance(motion, fc.Screw):
        back = fc.Screw(motion.axis, motion.point, degrees=-200, advance=5)
        end = motion(1.0)
        start = fc.RationalMotion.between(end, end)
        moving = a.moving(motion), a.moving(fc.Sequence([start, back], durations=["1/1000000", 1]))
        shift = 1e-6
    else:
        powers = np.array([[[float(x) for x in row] for row in m] for m in _exact_powers(motion)])
        moving, shift = (a.moving(motion), a.moving(fc.RationalMotion(_mirrored(powers)))), 0.0
    forward, backward = fc.contact_intervals(moving[0], b), fc.contact_intervals(moving[1], b)
    assert len(forward) == len(backward)
    for x, y in zip(forward, reversed(backward), strict=True):
        assert y.end - shift == pytest.approx(1 - x.start, abs=1e-7)


def _exact_powers(motion):
    return [[[Fraction(int(x.p), int(x.q)) for x in row] for row in m] for m in motion.coefficients]


def _mirrored(powers: np.ndarray) -> np.ndarray:
    """Coefficients of the motion at 1 - t."""
    out = np.zeros_like(powers)
    for k, m in enumerate(powers):
        for j in range(k + 1):
            out[j] += m * math.comb(k, j) * (-1) ** j
    return out


@pytest.mark.parametrize("seed", range(amount(8)))
def test_two_moving_bodies_and_their_relative_motion(seed):
    """Both bodies under one more motion meet when they did, in a point that this motion carries along."""
    a, b, motion = random_pair(seed)
    rng = np.random.default_rng([8, seed])
    alone = fc.first_contact(a.moving(motion), b)
    poses = [pose(), pose(rng.normal(size=3) / 3, rng.normal(size=3))]
    end = fc.RationalMotion.between(*poses)
    if isinstance(motion, fc.Screw):
        x = fc.first_contact(a.moving(fc.Sequence([motion])), b.moving(fc.Sequence([fc.RationalMotion([ONE])])))
    else:
        product = [np.zeros((4, 4)) for _ in range(end.degree + motion.degree + 1)]
        for i, m in enumerate(_exact_powers(end)):
            for j, n in enumerate(_exact_powers(motion)):
                product[i + j] = product[i + j] + np.array(m, object) @ np.array(n, object)
        x = fc.first_contact(a.moving(fc.RationalMotion(product)), b.moving(end), exact=True)
    assert (x.status, x.initial, x.multiplicity) == (alone.status, alone.initial, alone.multiplicity)
    if alone.status is Status.CONTACT:
        assert x.time == pytest.approx(alone.time, abs=1e-15)
        carried = ONE if isinstance(motion, fc.Screw) else end(alone.time)
        assert x.point == pytest.approx(carried[:3, :3] @ alone.point + carried[:3, 3], abs=1e-9)


# ----------------------------------------------------------------------------------------- sequences, jumps, starts


def test_steps_of_all_kinds_one_after_the_other():
    steps = [
        fc.Translation((0, 0, 1)),
        fc.Screw((0, 0, 1), turns=1, advance=1),
        fc.RationalMotion.between(pose(), pose((0, 0, 1), (0, 0, 1))),
        fc.Rotation((0, 0, 1), turns=1),
        rational_translation((0, 0, 4)),
    ]
    b = CUBE.translated((0, 0, 6))
    moving = CUBE.moving(fc.Sequence(steps))
    hit = fc.first_contact(moving, b)  # 3 up after three steps, then 2 of the last 4
    assert hit.status is Status.CONTACT and hit.time == pytest.approx(0.9, abs=1e-12)
    assert hit.normal == pytest.approx([0, 0, -1], abs=1e-12)
    intervals = fc.contact_intervals(moving, b)
    assert [(i.start, i.end) for i in intervals] == [(pytest.approx(0.9, abs=1e-12), 1.0)]


@pytest.mark.parametrize("shift", [(3.0, 0.2, 0.1), (3.2, 0.1, 0)], ids=["pierced", "inside"])
def test_a_body_that_jumps_into_another(shift):
    """A rational step whose first pose is not the identity."""
    size = 4 if shift[0] == 3.2 else 1
    b = fc.examples.box((size, size, size)).translated((3.2 if size == 4 else 3.5, 0, 0))
    jump = fc.Sequence([fc.Translation((0, 0, 0)), fc.RationalMotion([pose(shift=shift)])])
    moving = fc.examples.box((0.9, 0.9, 0.9)).moving(jump)
    hit = fc.first_contact(moving, b)
    assert hit.status is Status.CONTACT and hit.time == 0.5 and hit.initial is None


def test_starts_in_contact():
    motion = fc.RationalMotion.between(pose(), pose((0, 0, 1), (0, 0, 1)))
    screw = fc.Screw((0, 0, 1), degrees=30, advance=1)
    for m in (motion, screw):
        for at, kind in (((1, 0, 0), "touching"), ((0.5, 0.25, 0), "overlapping")):
            hit = fc.first_contact(CUBE.moving(m), CUBE.translated(at))
            assert (hit.status, hit.initial, hit.time) == (Status.INITIAL_CONTACT, kind, 0.0)
        inside = fc.first_contact(CUBE.moving(m), fc.examples.box((5, 5, 5)))
        assert (inside.status, inside.initial) == (Status.INITIAL_CONTACT, "containment")


def test_a_graze_counts_where_it_is_exact_and_is_undecided_where_it_is_not():
    """A vertex touches a facet at one instant, on a parabola and on a screw line."""
    dip = fc.RationalMotion([pose(shift=(-1, 0, 1)), _shift(2, 0, -4), _shift(0, 0, 4)])
    point, floor = fc.Polyhedron([[0, 0, 0]], []), fc.Polyhedron([[-9, -9, 0], [9, -9, 0], [0, 9, 0]], [[0, 1, 2]])
    hit = fc.first_contact(point.moving(dip), floor, exact=True)
    assert hit.time_exact == Fraction(1, 2) and hit.normal is None
    assert fc.first_contact(point.moving(dip), floor.translated((0, 0, Fraction(-1, 10**30)))).status is Status.FREE
    helix = fc.Screw((1, 0, 0), point=(0, 0, 1), turns=1, advance=1)
    swing = fc.Polyhedron([[0, 1, 1]], []).moving(helix)
    graze = fc.first_contact(swing, floor)
    assert (graze.status, graze.reason) == (Status.UNDECIDED, "precision")
    assert fc.first_contact(swing, floor.translated((0, 0, -1e-9))).status is Status.FREE
    assert fc.first_contact(swing, floor.translated((0, 0, 1e-9))).status is Status.CONTACT


def _shift(x, y, z) -> np.ndarray:
    m = np.zeros((4, 4))
    m[:3, 3] = x, y, z
    return m


# ------------------------------------------------------------------------------------------- intervals and pairs


@pytest.mark.share(2)
@pytest.mark.parametrize("generic", [False, True], ids=["degenerate", "random"])
@pytest.mark.parametrize("block", range(2))
def test_intervals_of_simple_motions(block, generic):
    for seed in range(8 * block, 8 * block + 8):
        rng = np.random.default_rng([9, seed, generic])
        a, b = random_body(rng, generic), random_body(rng, generic)
        if seed % 2:
            v = rng.integers(-5, 6, 3).tolist()
            x = fc.contact_intervals(a.moving(rational_translation(v)), b)
            y = [(i.start, i.end) for i in fc.contact_intervals(a.moving(fc.Translation(v)), b, (0, 1))]
        else:
            axis, point = AXES[rng.integers(5)], (rng.integers(-4, 5, 3) / 2).tolist()
            turn = fc.Rotation(axis, point, radians=turned_by(axis, 1))
            x = fc.contact_intervals(a.moving(rational_turn(axis, point)), b)
            rate = math.tan(turned_by(axis, 1) / 2)
            y = [
                tuple(math.tan(t * turned_by(axis, 1) / 2) / rate for t in (i.start, i.end))
                for i in fc.contact_intervals(a.moving(turn), b)
            ]
        assert [(i.start, i.end) for i in x] == [tuple(pytest.approx(t, abs=1e-10) for t in i) for i in y], seed


@pytest.mark.share(6)
@pytest.mark.parametrize("seed", range(6))
def test_intervals_of_screws_against_samples(seed):
    rng = np.random.default_rng([10, seed])
    a, b = random_body(rng, True), random_body(rng, True)
    moving = a.moving(fc.Screw(rng.normal(size=3), rng.normal(size=3), degrees=400, advance=float(rng.normal())))
    intervals = fc.contact_intervals(moving, b)
    assert intervals.status is not Status.UNDECIDED
    for t in np.linspace(0, 1, 150):
        near = any(min(abs(t - i.start), abs(t - i.end)) < 1e-6 for i in intervals)
        inside = any(i.start <= t <= i.end for i in intervals)
        assert near or inside == share_points(moving, b, float(t)), t


@pytest.mark.share(2)
@pytest.mark.parametrize("generic", [False, True], ids=["degenerate", "random"])
def test_pairs_of_a_translation(generic):
    for seed in range(25):
        rng = np.random.default_rng([11, seed, generic])
        a, b = random_body(rng, generic), random_body(rng, generic)
        v = rng.integers(-5, 6, 3).tolist()
        x = fc.contact_pairs(a.moving(rational_translation(v)), b)
        y = fc.contact_pairs(a.moving(fc.Translation(v)), b, (0, 1))
        assert list(x) == list(y) and x.piercing == y.piercing, seed


# ------------------------------------------------------------------------------------------------------- refusals


def test_exact_times_of_screws_are_refused():
    moving = CUBE.named("bolt").moving(fc.Screw((0, 0, 1), turns=1, advance=2))
    for verb in (fc.first_contact, fc.contact_intervals):
        with pytest.raises(fc.UnsupportedPair, match="Screw of 'bolt'.*no exact form"):
            verb(moving, CUBE.translated((0, 0, 5)), exact=True)


def test_endless_spans_are_refused():
    moving = CUBE.named("bolt").moving(fc.Screw((0, 0, 1), turns=1, advance=2))
    with pytest.raises(fc.InputError, match="'bolt'.*give span"):
        fc.first_contact(moving, CUBE.translated((0, 0, 5)), (0, math.inf))


def test_a_budget_stops_the_search():
    a, b = (fc.examples.noisy_sphere(500, seed=s) for s in (1, 2))
    motion = fc.RationalMotion.between(pose(), pose((0.3, 0.9, 1.0), (2.5, 0.5, 0)))
    stopped = fc.first_contact(a.moving(motion), b.translated((3, 0.3, 0.2)), budget=50)
    whole = fc.first_contact(a.moving(motion), b.translated((3, 0.3, 0.2)))
    assert (stopped.status, stopped.reason) == (Status.UNDECIDED, "budget")
    assert 0 < stopped.free_until <= whole.time
