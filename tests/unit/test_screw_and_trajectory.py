"""Screws, trajectories, the new steps of sequences, and the boxes of bodies under them."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq
from scipy.spatial.transform import Rotation as Turn

import firstcontact as fc
from firstcontact.exact.numbers import precision
from firstcontact.motion.span import common_span

ONE = np.eye(4)
CUBE = fc.examples.box((1, 1, 1))


def random_pose(rng):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Turn.random(rng=rng).as_matrix(), rng.uniform(-5, 5, 3)
    return pose


# ------------------------------------------------------------------------------------------------------- screws


@pytest.mark.parametrize("kind", [{"turns": Fraction(1, 4)}, {"degrees": 90}, {"radians": math.pi / 2}])
def test_a_screw_turns_and_advances(kind):
    motion = fc.Screw((0, 0, 3), point=(1, 0, 7), advance=2, **kind)
    assert motion.span == (0.0, 1.0)
    assert np.allclose(motion(1.0) @ [2, 0, 0, 1], [1, 1, 2, 1], atol=1e-15)
    assert np.allclose(motion(0.5) @ [2, 0, 0, 1], [1 + 0.5**0.5, 0.5**0.5, 1, 1], atol=1e-15)
    assert np.allclose(motion(-1.0) @ [2, 0, 0, 1], [1, -1, -2, 1], atol=1e-15)
    assert motion.radians == pytest.approx(math.pi / 2)


def test_advance_is_a_length_whatever_the_axis():
    motion = fc.Screw((1, 1, 1), point=(5, 0, 0), degrees=120, advance=3)
    # the turn by 120 degrees about (1, 1, 1) carries x to y to z
    assert np.allclose(motion(1.0) @ [6, 0, 0, 1], np.array([5, 1, 0, 1]) + [*[3**0.5] * 3, 0], atol=1e-14)
    back = fc.Screw((1, 1, 1), point=(5, 0, 0), degrees=-120, advance=-3)
    assert np.allclose(back(1.0) @ motion(1.0), np.eye(4), atol=1e-14)


def test_a_screw_agrees_with_rotation_and_translation():
    turn, screw = (m((1, -2, 3), (4, 1, 0), degrees=77) for m in (fc.Rotation, fc.Screw))
    for t in (0.0, 0.3, 1.0, 7.0):
        assert np.allclose(turn(t), screw(t), atol=1e-14)
    assert isinstance(screw.reduced(), fc.Rotation) and screw.reduced().angle == turn.angle
    straight = fc.Screw((3, 0, 4), turns=0, advance="1/3").reduced()
    assert isinstance(straight, fc.Translation) and straight.vector == (fmpq(1, 5), 0, fmpq(4, 15))
    both, slanted = fc.Screw((3, 0, 4), turns=1, advance=1), fc.Screw((1, 1, 0), turns=0, advance=1)
    assert both.reduced() is both and slanted.reduced() is slanted


def test_poses_keep_their_digits_when_the_axis_is_far():
    far = 2**60
    pose = fc.Screw((0, 0, 1), point=(far, 0, 0), radians=Fraction(1, far), advance=1)(1.0)
    assert np.allclose(pose[:3, 3], [0, -1, 1], atol=1e-15)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: fc.Screw((0, 0, 0), turns=1), "Screw axis is zero"),
        (lambda: fc.Screw((0, 1), turns=1), "Screw axis is"),
        (lambda: fc.Screw((0, 0, 1), point=5, turns=1), "Screw point is 5"),
        (lambda: fc.Screw((0, 0, 1)), "Screw needs exactly one of"),
        (lambda: fc.Screw((0, 0, 1), turns=1, radians=1), "Screw needs exactly one of"),
        (lambda: fc.Screw((0, 0, 1), degrees="x"), "Screw degrees is 'x'"),
        (lambda: fc.Screw((0, 0, 1), turns=1, advance=math.inf), "Screw advance is inf"),
    ],
)
def test_bad_screws_are_named(make, says):
    with pytest.raises(fc.InputError, match=says):
        make()


def test_screws_survive_pickling():
    motion = fc.Screw((1, "2/3", 0), point=("1/7", 0, 0), turns="1/3", advance="0.1")
    again = pickle.loads(pickle.dumps(motion))
    state = [[getattr(m, s) for s in fc.Screw.__slots__] for m in (motion, again)]
    assert state[0] == state[1]
    assert repr(again) == "Screw((1.0, 0.6666666666666666, 0.0), point=(0.14285714285714285, 0.0, 0.0), " \
        "turns=0.3333333333333333, advance=0.1)"  # fmt: skip


# ------------------------------------------------------------------------------------------------- trajectories


@pytest.mark.parametrize("interpolation", ["linear-quaternion", "screw"])
def test_trajectories_pass_their_poses(interpolation):
    rng = np.random.default_rng(21)
    times, poses = np.cumsum(rng.uniform(0.1, 2, 6)), [random_pose(rng) for _ in range(6)]
    motion = fc.Trajectory(times, poses, interpolation)
    assert motion.span == (times[0], times[-1])
    for t, pose in zip(times.tolist(), poses, strict=True):
        assert np.abs(motion(t) - pose).max() < 2e-15
        if t > times[0]:
            assert np.abs(motion(np.nextafter(t, 0)) - pose).max() < 1e-13
    for t in np.linspace(*motion.span, 50).tolist():
        assert np.allclose(motion(t)[:3, :3] @ motion(t)[:3, :3].T, np.eye(3), atol=1e-14)


def test_steps_of_both_kinds():
    rng = np.random.default_rng(22)
    p, q = random_pose(rng), random_pose(rng)
    line, screw = fc.Trajectory([2, 6], [p, q]), fc.Trajectory([2, 6], [p, q], "screw")
    assert np.array_equal(line(3.0), fc.RationalMotion.between(p, q)(0.25))
    # constant speed about one axis: the same step again and again, the rotation the short way
    step = screw(3.0) @ np.linalg.inv(p)
    assert np.allclose(np.linalg.matrix_power(step, 4) @ p, q, atol=1e-13)
    whole = Turn.from_matrix(q[:3, :3] @ p[:3, :3].T).magnitude()
    assert Turn.from_matrix(step[:3, :3]).magnitude() == pytest.approx(whole / 4) and whole < math.pi


def test_screw_steps_join_within_2_to_the_minus_60():
    """Angle and advance of the step against balls of 300 bits."""
    (step,) = fc.Trajectory([0, 1], [(0, 0, 0), (1, 2, 3)], "screw", quat_wxyz=[(1, 0, 0, 0), (5, 1, 2, 2)]).steps
    with precision(300):
        near = arb(2) ** -60
        assert step.unit == "radians" and abs(arb(step.angle) - 2 * arb.atan2(arb(3), arb(5))) < near
        assert abs(arb(step.advance) - arb(fmpq(1 * 1 + 2 * 2 + 2 * 3, 3))) < near


def test_screw_steps_of_pure_kinds():
    quarter = [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    shifted = [[1, 0, 0, 3], [0, 1, 0, 4], [0, 0, 1, 0], [0, 0, 0, 1]]
    turn = fc.Trajectory([0, 1, 2], [shifted, quarter, ONE], "screw")
    straight = fc.Trajectory([0, 1], [ONE, shifted], "screw")
    assert isinstance(straight.steps[0], fc.Translation) and straight(0.5)[:3, 3].tolist() == [1.5, 2, 0]
    assert turn.steps[0].advance == 0 and isinstance(turn.steps[1].reduced(), fc.Rotation)
    assert np.allclose(turn(0.0), shifted) and np.allclose(turn(1.0), quarter) and np.allclose(turn(2.0), ONE)


def test_a_turn_by_rounding_only_stays_near_the_straight_line():
    noisy = np.eye(4)
    noisy[:3, :3] = Turn.from_rotvec([1e-16, 3e-17, 0]).as_matrix() + 1e-17
    noisy[:3, 3] = 5, 0, 1
    motion = fc.Trajectory([0, 1], [ONE, noisy], "screw")
    for t in (0.0, 0.3, 1.0):
        assert np.allclose(motion(t)[:3, 3], [5 * t, 0, t], atol=1e-14)
    lo, hi = CUBE.moving(motion).bounds()
    assert np.allclose(lo, [-0.5, -0.5, -0.5], atol=1e-9) and np.allclose(hi, [5.5, 0.5, 1.5], atol=1e-9)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: fc.Trajectory([0], [ONE]), "give at least two"),
        (lambda: fc.Trajectory(3, [ONE]), "times is 3"),
        (lambda: fc.Trajectory([0, 1], 3), "poses is 3"),
        (lambda: fc.Trajectory([0, 1, 1], [ONE] * 3), r"times\[2\] does not lie after times\[1\]"),
        (lambda: fc.Trajectory([0, math.nan], [ONE] * 2), r"Trajectory times\[1\] is nan"),
        (lambda: fc.Trajectory([0, 1], [ONE] * 3), "2 times but 3 poses"),
        (lambda: fc.Trajectory([0, 1], [ONE] * 2, "cubic"), "interpolation is 'cubic'"),
        (lambda: fc.Trajectory([0, 1], [ONE, 2 * ONE]), r"Trajectory poses\[1\]: the last row"),
        (lambda: fc.Trajectory([0, 1], [ONE, np.diag([-1, -1, 1, 1])]), r"poses\[0\] and poses\[1\] are half a turn"),
        (lambda: fc.Trajectory([0, 1], [ONE, np.diag([-1, -1, 1, 1])], "screw"), "half a turn apart"),
        (lambda: fc.Trajectory([0, 1], [(0, 0, 0)] * 2, quat_xyzw=[(0, 0, 0, 1)]), "1 quaternions for 2 poses"),
    ],
)
def test_bad_trajectories_are_named(make, says):
    with pytest.raises(fc.InputError, match=says):
        make()


def test_times_outside_a_trajectory():
    motion = fc.Trajectory([1, 2], [ONE, ONE])
    for t in (0.999, 2.001, math.nan):
        with pytest.raises(fc.InputError, match="outside the span|finite number"):
            motion(t)


@pytest.mark.parametrize("interpolation", ["linear-quaternion", "screw"])
def test_trajectories_survive_pickling(interpolation):
    rng = np.random.default_rng(23)
    motion = fc.Trajectory(["1/3", 1, 2], [random_pose(rng) for _ in range(3)], interpolation)
    again = pickle.loads(pickle.dumps(motion))
    assert again.times == motion.times and again.poses == motion.poses and repr(again) == repr(motion)
    for t in np.linspace(*motion.span, 7).tolist():
        assert np.array_equal(again(t), motion(t))
    assert repr(motion) == f"<Trajectory: 3 poses from 0.333333 to 2, {interpolation}>"


# ---------------------------------------------------------------------------------------------------- sequences


def test_sequences_apply_a_step_after_the_pose_reached():
    lift = fc.RationalMotion.between(ONE, [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]])
    motion = fc.Sequence([fc.Translation((2, 0, 0)), lift, fc.Screw((0, 0, 1), degrees=90, advance=1)])
    assert np.allclose(motion(2 / 3) @ [0, 0, 0, 1], [0, 2, 5, 1], atol=1e-14)  # the turn is about the world's z
    assert np.allclose(motion(1.0) @ [0, 0, 0, 1], [-2, 0, 6, 1], atol=1e-14)
    assert np.allclose(motion(0.5), lift(0.5) @ fc.Translation((2, 0, 0))(1.0), atol=1e-15)
    again = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(again(0.9), motion(0.9))


def test_a_sequence_takes_no_trajectory():
    with pytest.raises(fc.InputError, match="Screw or RationalMotion"):
        fc.Sequence([fc.Trajectory([0, 1], [ONE, ONE])])


# --------------------------------------------------------------------------------------------------- spans, pairs


def test_the_span_of_a_query():
    late = CUBE.moving(fc.Trajectory([0.5, 3], [ONE, ONE]))
    rational = CUBE.moving(fc.RationalMotion([ONE]))
    screw = CUBE.moving(fc.Screw((0, 0, 1), turns=1))
    for other in (rational, screw):
        with pytest.warns(UserWarning, match="only: give span"):
            assert common_span(late, other, None) == (fmpq(1, 2), 1)
    assert common_span(late, CUBE, None) == (fmpq(1, 2), 3)
    assert common_span(late, screw, (1, "5/2")) == (1, fmpq(5, 2)) and common_span(screw, CUBE, (-3, 7)) == (-3, 7)
    outside = (late, (0, 1), "Trajectory"), (rational, (0, 2), "RationalMotion"), (rational, (0, math.inf), "Rational")
    for a, span, kind in outside:
        with pytest.raises(fc.InputError, match=f"leaves the span .* of the {kind}"):
            common_span(a, CUBE, span)
    with pytest.warns(UserWarning, match=r"spans \(0.5, 3.0\) and \(0.0, 1.0\); the answer is about \(0.5, 1.0\) only"):
        fc.first_contact(late, screw)
    with pytest.raises(fc.InputError, match="share no time"):
        common_span(rational, CUBE.moving(fc.Trajectory([2, 3], [ONE, ONE])), None)


@pytest.mark.share(2)
@pytest.mark.parametrize("motion", [
    fc.RationalMotion([ONE]), fc.Screw((0, 0, 1), turns=1), fc.Trajectory([0, 1], [ONE, ONE]),
    fc.Sequence([fc.Translation((1, 0, 0)), fc.Screw((0, 0, 1), turns=1)]),
    fc.Sequence([fc.RationalMotion([ONE])]),
], ids=repr)  # fmt: skip
def test_polyhedra_take_them(motion):
    lid, far = CUBE.named("lid").moving(motion), CUBE.translated((50, 0, 0))
    for a, b in ((lid, far), (far, lid)):
        assert fc.first_contact(a, b).status is fc.Status.FREE
        assert len(fc.contact_intervals(a, b)) == 0 and len(fc.contact_pairs(a, b)) == 0


def test_other_classes_of_motion_are_refused():
    class Wobble:
        span = (0.0, 1.0)

        def __call__(self, t):
            return ONE

    with pytest.raises(fc.UnsupportedPair, match="'lid': polyhedra take Translation, Rotation, Screw"):
        fc.first_contact(CUBE.named("lid").moving(Wobble()), CUBE)


# ------------------------------------------------------------------------------------------------------- bounds

RNG = np.random.default_rng(24)
POSES = [random_pose(RNG) for _ in range(4)]
MOTIONS = [
    fc.RationalMotion.between(*POSES[:2]),
    fc.RationalMotion([ONE, np.diag([1, -0.5, 2, 3])]),
    fc.RationalMotion([ONE, [[0, 0, 0, 7], [0] * 4, [0] * 4, [0, 0, 0, Fraction(-99, 100)]]]),
    fc.Screw((1, 2, -1), point=(0, 3, 0), degrees=200, advance=4),
    fc.Screw((1, 2, -1), point=(0, 3, 0), degrees=-20, advance=-4),
    fc.Screw((1, 1, 1), turns=64, advance=-30),
    fc.Screw((1, 1, 0), turns=0, advance=-3),
    fc.Trajectory([1, 2, 5, 6], POSES),
    fc.Trajectory([1, 2, 5, 6], POSES, "screw"),
    fc.Sequence([fc.Rotation((0, 1, 0), degrees=90), fc.RationalMotion.between(ONE, POSES[0]),
                 fc.Screw((0, 0, 1), turns=2, advance=5), fc.Translation((1, 2, 3))]),
]  # fmt: skip


@pytest.mark.share(12)
@pytest.mark.parametrize("motion", MOTIONS, ids=repr)
@pytest.mark.parametrize("part", [(0.0, 1.0), (0.3, 0.37), (0.5, 0.5)])
def test_bounds_hold_the_moving_body(motion, part):
    body = CUBE.rotated((1, 2, 3), degrees=20).translated((2, 0, 0))
    begin, end = motion.span
    span = tuple(begin + (end - begin) * p for p in part)
    lo, hi = body.moving(motion).bounds(span)
    seen_lo, seen_hi = np.full(3, np.inf), np.full(3, -np.inf)
    for t in np.linspace(*span, 1501).tolist():
        pose = motion(t)
        points = body.vertices @ pose[:3, :3].T + pose[:3, 3]
        seen_lo, seen_hi = np.minimum(seen_lo, points.min(axis=0)), np.maximum(seen_hi, points.max(axis=0))
    assert np.all(seen_lo >= lo - 1e-15) and np.all(seen_hi <= hi + 1e-15)
    size = np.linalg.norm(seen_hi - seen_lo)
    assert np.all(seen_lo - lo < 0.35 * size) and np.all(hi - seen_hi < 0.35 * size)
    if part[0] == part[1]:
        assert np.allclose(lo, seen_lo, atol=1e-10) and np.allclose(hi, seen_hi, atol=1e-10)


def test_bounds_of_motions_without_end():
    lo, hi = CUBE.moving(fc.Screw((0, 0, 1), point=(2, 0, 0), turns=1, advance=-1)).bounds((0, math.inf))
    reach = math.hypot(2.5, 0.5)
    assert lo[2] == -math.inf and 0.5 <= hi[2] < 0.51
    assert np.allclose(lo[:2], [2 - reach, -reach], atol=0.02) and np.all(lo[:2] <= [2 - reach, -reach])
    lo, hi = CUBE.moving(fc.Translation((1, 0, -2))).bounds((0, math.inf))
    assert lo[0] == pytest.approx(-0.5) and hi[0] == math.inf and lo[2] == -math.inf and hi[1] == pytest.approx(0.5)
    lo, hi = CUBE.moving(fc.Rotation((0, 0, 1), turns=3)).bounds((0, math.inf))
    assert np.all(np.isfinite(lo)) and hi[0] >= 0.5**0.5


def test_bounds_of_turns_hold_all_places_and_little_more():
    rng = np.random.default_rng(11)
    for k in range(40):
        axis, point = rng.normal(size=3), rng.normal(size=3) * 10.0 ** rng.integers(-2, 4)
        motion = fc.Screw(axis, point, degrees=float(rng.uniform(-300, 300)), advance=float(rng.normal()) * (k % 2))
        body = CUBE.translated((rng.normal(size=3) * 10.0 ** rng.integers(-1, 3)).tolist())
        first, last = np.sort(rng.uniform(0, 1 if k % 4 else 50, 2)).tolist()
        lo, hi = body.moving(motion).bounds((first, last))
        poses = np.array([motion(t) for t in np.linspace(first, last, 400).tolist()])
        points = body.vertices @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3]
        seen_lo, seen_hi = points.min(axis=(0, 1)), points.max(axis=(0, 1))
        assert np.all(lo <= seen_lo) and np.all(seen_hi <= hi), k
        assert np.all(seen_lo - lo <= 0.02 * np.linalg.norm(seen_hi - seen_lo)), k
        assert np.all(hi - seen_hi <= 0.02 * np.linalg.norm(seen_hi - seen_lo)), k


def test_bounds_late_in_a_fast_turn():
    """At time 1e9 the angle itself has lost digits in floats; the box is right all the same."""
    motion, body = fc.Rotation((0, 0, 1), turns=Fraction(1, 3)), CUBE.translated((1000, 0, 0))
    lo, hi = body.moving(motion).bounds((10**9 - 1, 10**9 - 1))  # a whole number of turns
    assert np.allclose(lo, [999.5, -0.5, -0.5], atol=1e-8) and np.allclose(hi, [1000.5, 0.5, 0.5], atol=1e-8)


def test_bounds_of_bodies_without_vertices():
    class Ball:
        vertices = ()
        name = None

        def bounds(self, span=None):
            return np.full(3, -1.0), np.array([1.0, 1.0, self.top])

    ball = Ball()
    ball.top = 2.0
    lo, hi = fc.Moving(ball, fc.Translation((0, 5, 0))).bounds()
    assert np.allclose(lo, [-1, -1, -1]) and np.allclose(hi, [1, 6, 2])
    ball.top = math.inf
    lo, hi = fc.Moving(ball, fc.Translation((0, 5, 0))).bounds()
    assert np.all(np.isinf(lo)) and np.all(np.isinf(hi))


def test_bounds_of_an_unknown_motion_are_refused():
    class Odd:
        span = (0.0, 1.0)

        def __call__(self, t):
            return np.eye(4)

    with pytest.raises(fc.InputError, match="are not known"):
        CUBE.moving(Odd()).bounds()


TURNS_AND_SHIFTS = [fc.Translation((1, -2, 3)), fc.Rotation((1, 1, 0), degrees=300)]


@pytest.mark.share(12)
@pytest.mark.parametrize("motion", [*MOTIONS, *TURNS_AND_SHIFTS], ids=repr)
def test_bounds_hold_a_moving_solid(motion):
    solid = fc.cylinder(1, 3) - fc.sphere(1).translated((0, 0, 1))
    solid = solid.rotated((1, 2, 3), degrees=20).translated((2, 0, 0))
    points = solid.to_mesh(0.05).vertices
    begin, end = motion.span
    span = (begin + 0.2 * (end - begin), begin + 0.9 * (end - begin))
    lo, hi = solid.moving(motion).bounds(span)
    poses = [motion(t) for t in np.linspace(*span, 400).tolist()]
    seen = np.concatenate([(points @ m[:3, :3].T + m[:3, 3]) / m[3, 3] for m in poses])
    assert np.all(lo <= seen.min(axis=0)) and np.all(seen.max(axis=0) <= hi)
    assert np.linalg.norm(hi - lo) < 1.6 * np.linalg.norm(np.ptp(seen, axis=0))


def test_bounds_of_an_unbounded_moving_solid_are_infinite():
    lo, hi = fc.half_space((0, 0, 1), 0).moving(fc.Screw((0, 0, 1), degrees=20, advance=1)).bounds()
    assert np.all(np.isinf(lo)) and np.all(np.isinf(hi))
