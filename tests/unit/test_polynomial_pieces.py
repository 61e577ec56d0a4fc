"""Polynomial pieces of motions: poses, times, ends, and the relative motion of two bodies."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq, fmpq_poly, fmpz_poly
from scipy.spatial.transform import Rotation as Turn

import firstcontact as fc
from firstcontact.exact.numbers import precision, to_double
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.clocks import _is_part_of_half_turn
from firstcontact.motion.relative.polynomial import relative, relative_pieces, step_pieces, steps_within

CUBE = fc.examples.box((1, 1, 1)).named("cube")
ZERO, ONE = fmpq(0), fmpq(1)


def polynomial_pieces(body, first, last):
    """The pieces of a motion or body over [first, last], in time order."""
    for step, begin, end, of in steps_within(body, first, last):
        yield from step_pieces(step, begin, end, of)


class Root:
    """The root of an irreducible polynomial near a double, to any precision; all that clocks ask of a root."""

    def __init__(self, coefficients, near=None):
        self.polynomial = fmpz_poly(coefficients)
        self.near = near
        self.rational = fmpq(-self.polynomial[0], self.polynomial[1]) if self.polynomial.degree() == 1 else None

    def enclosure(self, bits):
        with precision(bits + 20):
            if self.rational is not None:
                return arb(self.rational)
            found = [z.real for z, _ in self.polynomial.complex_roots() if z.imag == 0]
            (ball,) = [x for x in found if abs(float(x) - self.near) < 1e-6]
            return ball

    def sign_of(self, p):
        if (fmpq_poly(p) % fmpq_poly(self.polynomial)).is_zero():
            return 0
        with precision(400):
            value = p(self.enclosure(400))
            assert value > 0 or value < 0
            return 1 if value > 0 else -1

    def number(self):
        return Fraction(int(self.rational.p), int(self.rational.q)) if self.rational is not None else self


def at(u):
    """The root of a rational number."""
    u = fmpq(u)
    return Root([-u.p, u.q])


def random_pose(rng):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Turn.random(rng=rng).as_matrix(), rng.uniform(-5, 5, 3)
    return pose


def floats(rows):
    return np.array([[to_double(x) for x in row] for row in rows])


def check_pieces(motion, first, last, pieces, tolerance=1e-13):
    """The pieces tile [first, last] and give the poses of the motion at the times of their clock."""
    assert pieces[0].start == first and pieces[-1].end == last
    for p, q in itertools.pairwise(pieces):
        assert p.end == q.start
    for p in pieces:
        assert p.start < p.end and p.u_lo < p.u_hi
        ends = []
        for k in range(9):
            u = p.u_lo + (p.u_hi - p.u_lo) * k / 8
            assert p.pose[3][3](u) > 0
            with precision(128):
                time = float(p.time_of(u))
            ends.append(time)
            inside = min(max(time, to_double(first)), to_double(last))
            assert np.allclose(floats(projective.value(p.pose, u)), motion(inside), atol=tolerance, rtol=0)
        assert ends == sorted(ends)
        assert ends[0] == pytest.approx(to_double(p.start), abs=1e-15)
        assert ends[-1] == pytest.approx(to_double(p.end), abs=1e-15)


def rational_pieces(motion, first, last):
    first, last = fmpq(first), fmpq(last)
    pieces = list(polynomial_pieces(motion, first, last))
    check_pieces(motion, first, last, pieces)
    return pieces


# ------------------------------------------------------------------------------------------- straight and rational


def test_a_translation_is_linear_in_the_time():
    (piece,) = rational_pieces(fc.Translation(("1/3", 0, -2)), -1, 5)
    assert [[x.coeffs() for x in row] for row in piece.pose] == [
        [[3], [], [], [0, 1]], [[], [3], [], []], [[], [], [3], [0, -6]], [[], [], [], [3]]
    ]  # fmt: skip
    assert piece.exact and piece.exact_time(at(fmpq(1, 7))) == Fraction(1, 7)
    assert piece.contains(at(-1)) and piece.contains(at(5)) and not piece.contains(at(fmpq(51, 10)))
    (endless,) = polynomial_pieces(fc.Translation((1, 0, 0)), fmpq(3), None)
    assert (endless.start, endless.end, endless.u_lo, endless.u_hi) == (3, None, 3, None)
    assert endless.contains(at(10**9)) and not endless.contains(at(2))


def test_bodies_at_rest_and_motions_that_rest():
    for body in (CUBE, CUBE.moving(fc.Translation((0, 0, 0))), CUBE.moving(fc.Rotation((1, 2, 3), turns=0))):
        (piece,) = polynomial_pieces(body, ZERO, fmpq(2))
        assert piece.is_constant and floats(projective.value(piece.pose, ZERO)).tolist() == np.eye(4).tolist()


def test_a_rational_motion_is_its_own_piece():
    rng = np.random.default_rng(31)
    motion = fc.RationalMotion.between(random_pose(rng), random_pose(rng))
    (piece,) = rational_pieces(motion, fmpq(1, 4), fmpq(3, 4))
    assert piece.pose == motion.pose and (piece.u_lo, piece.u_hi) == (fmpq(1, 4), fmpq(3, 4))
    with pytest.raises(fc.InputError, match="RationalMotion of 'cube' has no poses outside"):
        list(polynomial_pieces(CUBE.moving(motion), ZERO, fmpq(2)))


# --------------------------------------------------------------------------------------------------- rotations


@pytest.mark.parametrize(
    ("motion", "first", "last", "count"),
    [
        (fc.Rotation((0, 0, 1), degrees=90), 0, 1, 1),
        (fc.Rotation((0, 0, -3), point=(1, 2, 3), degrees=120), 0, 1, 2),
        (fc.Rotation((3, 0, 4), point=(1, 2, 3), turns=-1), 0, 1, 3),
        (fc.Rotation((1, 1, 1), point=(5, 0, 0), turns="5/3"), 0, 1, 4),
        (fc.Rotation((1, "1/2", 0.1), degrees="10.1"), 0, 1, 1),
        (fc.Rotation((1, 2, 3), point=(5, 0, 1), radians=5), 0, 1, 3),
        (fc.Rotation((1, 2, 2), radians=-40), -1, 2, 39),
        (fc.Rotation((1, 1, 0), turns=1), fmpq(1, 4), fmpq(3, 4), 1),
        (fc.Rotation((1, 1, 0), turns=1), fmpq(-7, 3), fmpq(-2, 7), 5),
        (fc.Rotation((1, 1, 0), turns=10**6), 1, 1 + fmpq(1, 10**6), 3),
    ],
    ids=str,
)
def test_rotations_are_cut_at_odd_quarter_turns(motion, first, last, count):
    pieces = list(polynomial_pieces(motion, fmpq(first), fmpq(last)))
    slow = abs(motion.radians) < 1e5
    check_pieces(motion, fmpq(first), fmpq(last), pieces, 1e-12 if slow else 1e-8)
    assert len(pieces) == count
    for p in pieces:
        assert projective.degree(p.pose) <= 2 and p.exact
        reach = to_double(p.clock.square) ** 0.5
        assert abs(to_double(p.u_lo)) * reach <= 1 + 1e-15 and abs(to_double(p.u_hi)) * reach <= 1 + 1e-15


def test_the_parameter_is_the_tangent_of_half_the_angle():
    (piece,) = polynomial_pieces(fc.Rotation((0, 0, 5), degrees=90), ZERO, ONE)
    assert (piece.u_lo, piece.u_hi) == (0, 1)
    assert [[x.coeffs() for x in row] for row in piece.pose] == [
        [[1, 0, -1], [0, -2], [], []], [[0, 2], [1, 0, -1], [], []], [[], [], [1, 0, 1], []], [[], [], [], [1, 0, 1]]
    ]  # fmt: skip
    (back,) = polynomial_pieces(fc.Rotation((0, 0, 5), degrees=-90), ZERO, ONE)
    assert back.u_hi == 1 and back.pose[1][0].coeffs() == [0, -2]


def test_a_rotation_of_no_end_goes_on_in_half_turns():
    pieces = itertools.islice(polynomial_pieces(fc.Rotation((0, 0, 1), turns=1), ZERO, None), 4)
    assert [(p.start, p.end) for p in pieces] == [(k and fmpq(2 * k - 1, 4), fmpq(2 * k + 1, 4)) for k in range(4)]


def test_times_of_rotations():
    """60 degrees about (1, 1, 1): tan(30 deg) / sqrt 3 = 1/3, a rational u within the bounds only by comparison."""
    (piece,) = polynomial_pieces(fc.Rotation((1, 1, 1), degrees=60), ZERO, ONE)
    end = at(fmpq(1, 3))
    assert piece.u_hi > fmpq(1, 3) and piece.u_hi - fmpq(1, 3) < fmpq(1, 2**100)
    assert piece.clock.compare(end, ONE) == 0 and piece.contains(end) and piece.exact_time(end) == 1
    beyond = at(fmpq(1, 3) + fmpq(1, 10**60))
    assert piece.clock.compare(beyond, ONE) == 1 and not piece.contains(beyond)
    before = at(fmpq(1, 3) - fmpq(1, 10**60))
    assert piece.contains(before) and isinstance(piece.exact_time(before), fc.ExactAngle)


@pytest.mark.parametrize(
    ("degrees", "axis", "root"),
    [
        (45, (0, 0, 1), Root([-1, 2, 1], 0.41421356)),  # tan 22.5 = sqrt 2 - 1
        (60, (0, 0, 7), Root([-1, 0, 3], 0.57735026)),
        (30, (0, 0, 1), Root([1, -4, 1], 0.26794919)),
        (36, (0, 0, 1), Root([1, 0, -10, 0, 5], 0.32491969)),  # tan 18
        (90, (1, 1, 0), Root([-1, 0, 2], 0.70710678)),
        (72, (0, 0, 1), Root([5, 0, -10, 0, 1], 0.72654252)),
    ],
)
def test_equal_angles_are_recognised(degrees, axis, root):
    (piece,) = polynomial_pieces(fc.Rotation(axis, degrees=degrees), ZERO, ONE)
    assert piece.clock.compare(root, ONE) == 0 and piece.contains(root) and piece.exact_time(root) == 1
    assert piece.clock.compare(root, ONE - fmpq(1, 10**40)) == 1
    (short,) = polynomial_pieces(fc.Rotation(axis, degrees=degrees), ZERO, ONE - fmpq(1, 10**40))
    assert not short.contains(root)
    # an angle that is near, and has a denominator too large to be equal
    odd, *_ = polynomial_pieces(fc.Rotation(axis, degrees=float(degrees) + 2**-40), ZERO, ONE)
    assert odd.clock.compare(root, ONE) == -1


def test_a_fraction_of_the_same_degree_is_not_taken_for_equal():
    """tan(18 deg) and tan(54 deg) are conjugate: the field cannot tell them apart, the balls do."""
    (piece,) = polynomial_pieces(fc.Rotation((0, 0, 1), degrees=36), ZERO, fmpq(2))
    far = Root([1, 0, -10, 0, 5], 1.37638192)
    assert piece.clock.compare(far, ONE) == 1 and piece.clock.compare(far, fmpq(3)) == 0


def test_radians_equal_no_algebraic_tangent():
    (piece,) = polynomial_pieces(fc.Rotation((0, 0, 1), radians=1), ZERO, ONE)
    assert piece.clock.compare(at(0), ZERO) == 0 and piece.exact_time(at(0)) == 0
    near = fmpq(*math.tan(0.5).as_integer_ratio())
    assert piece.clock.compare(at(near), ONE) in (-1, 1)
    assert piece.clock.compare(at(0), fmpq(1, 10**300)) == -1
    later = list(polynomial_pieces(fc.Rotation((0, 0, 1), radians=10), ZERO, ONE))[1]
    angle = later.exact_time(at(0))  # half a turn
    assert (angle.cosine, angle.sine) == (-1, 0) and float(angle) == math.pi / 10


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 1, 1), (1, 2, 0)])
@pytest.mark.parametrize("turns", [1, -2, Fraction(1, 2)])
def test_exact_angles(axis, turns):
    pieces = list(polynomial_pieces(fc.Rotation(axis, turns=turns), ZERO, ONE))
    for p in pieces:
        middle = (p.u_lo + p.u_hi) / 2 + fmpq(1, 1000)
        for root in (at(middle), Root([-2, 0, 0, 25], 0.430887), Root([1, 1, 0, -25], 0.380832)):
            if not p.contains(root):
                continue
            result = p.exact_time(root)
            with precision(128):
                time = float(p.time_of(root.enclosure(128)))
            assert float(result) == time
            angle = 2 * math.pi * abs(turns) * time
            assert float(result.cosine) == pytest.approx(math.cos(angle), abs=1e-14)
            assert float(result.sine) == pytest.approx(math.sin(angle), abs=1e-14)
    quarter = [p.exact_time(at(0)) for p in pieces if p.contains(at(0))]
    assert quarter == [Fraction(k, 2) / abs(turns) for k in range(int(2 * abs(turns)) + 1)]


def test_quarter_turns_have_rational_times():
    pieces = list(polynomial_pieces(fc.Rotation((1, 1, 0), turns="1/2"), ZERO, ONE))
    up, down = Root([-1, 0, 2], 0.70710678), Root([-1, 0, 2], -0.70710678)
    assert [p.exact_time(r) for p, r in zip(pieces, (up, down), strict=True)] == [Fraction(1, 2)] * 2
    assert pieces[0].contains(up) and not pieces[0].contains(down) and pieces[1].contains(down)


# ------------------------------------------------------------------------------------- sequences and trajectories


def test_sequences_of_exact_poses():
    lift = fc.RationalMotion.between(np.eye(4), [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]])
    motion = fc.Sequence(
        [fc.Translation((2, 0, 0)), fc.Rotation((3, 0, 4), turns="3/4"), lift, fc.Screw((1, 1, 0), degrees=30),
         fc.Screw((3, 0, 4), turns=0, advance=5)], durations=[1, 2, "1/3", 1, 2],
    )  # fmt: skip
    pieces = rational_pieces(motion, 0, fmpq(19, 3))
    assert [to_double(p.end) for p in pieces] == pytest.approx([1, 1 + 2 / 3, 3, 10 / 3, 13 / 3, 19 / 3])
    assert [p.exact for p in pieces] == [True] * 5 + [False]
    assert [p.of for p in pieces][3:5] == ["RationalMotion of a body", "Rotation of a body"]
    part = rational_pieces(motion, fmpq(1, 2), fmpq(5, 4))
    assert [(p.start, p.end) for p in part] == [(fmpq(1, 2), 1), (1, fmpq(5, 4))]


@pytest.mark.parametrize("angle", [{"degrees": 30}, {"radians": 1}])
def test_steps_after_irrational_poses_are_within_2_to_the_minus_60(angle):
    motion = fc.Sequence([fc.Rotation((1, 2, 3), point=(1, 0, 0), **angle), fc.Translation((1, 2, 3))])
    turn, straight = rational_pieces(motion, 0, 1)
    assert turn.exact and not straight.exact
    assert projective.is_rigid(straight.pose)
    pose = projective.value(straight.pose, fmpq(1, 2))
    with precision(200):
        u = turn.clock._half_angle(fmpq(1, 2)).tan() / arb(turn.clock.square).sqrt()
        truth = projective.value(turn.pose, u)
        pairs = zip(itertools.chain(*pose), itertools.chain(*truth), strict=True)
        gap = max(float(abs(arb(x) - y).upper()) for x, y in pairs)
    assert 0 < gap < 2.0**-60


def test_an_instant_has_one_piece():
    motion = fc.Sequence([fc.Translation((1, 0, 0)), fc.Translation((0, 1, 0))])
    for t in (fmpq(0), fmpq(1, 2), fmpq(1)):
        (piece,) = polynomial_pieces(motion, t, t)
        assert piece.start == piece.end == t
        assert np.allclose(floats(projective.value(piece.pose, t)), motion(to_double(t)))
    for t in (fmpq(0), fmpq(1, 4), fmpq(5, 7)):
        (piece,) = polynomial_pieces(fc.Rotation((1, 1, 0), turns=1), t, t)
        assert piece.start == piece.end == t and piece.u_lo <= piece.u_hi


def test_trajectories():
    rng = np.random.default_rng(33)
    poses = [random_pose(rng) for _ in range(4)]
    line, screw = (fc.Trajectory([1, 2, 4, "9/2"], poses, kind) for kind in ("linear-quaternion", "screw"))
    assert [p.end for p in rational_pieces(line, 1, fmpq(9, 2))] == [2, 4, fmpq(9, 2)]
    assert [p.start for p in rational_pieces(line, 3, fmpq(17, 4))] == [3, 4]
    with pytest.raises(fc.UnsupportedPair, match="Screw of 'cube': Screw.* has no rational pose"):
        list(polynomial_pieces(CUBE.moving(screw), fmpq(1), fmpq(2)))
    shift = [np.eye(4), np.eye(4) + np.outer([1, 2, 3, 0], [0, 0, 0, 1])]
    (piece,) = rational_pieces(fc.Trajectory([1, 3], shift, "screw"), 1, 3)
    assert projective.degree(piece.pose) == 1


def test_screws_that_are_simple_motions():
    assert len(rational_pieces(fc.Screw((1, 2, 3), point=(1, 0, 0), turns=1), 0, 1)) == 3
    (piece,) = rational_pieces(fc.Screw((3, 0, 4), turns=0, advance=2), 0, 7)
    assert projective.degree(piece.pose) == 1
    for motion in (fc.Screw((0, 0, 1), turns=1, advance=1), fc.Screw((1, 1, 0), turns=0, advance=1)):
        with pytest.raises(fc.UnsupportedPair, match="no exact contact equations") as caught:
            list(polynomial_pieces(CUBE.moving(motion), ZERO, ONE))
        assert "\n" not in str(caught.value)


# ---------------------------------------------------------------------------------------------- relative motion


def check_relative(a, b, first, last):
    pieces = list(relative_pieces(CUBE.moving(a) if a else CUBE, CUBE.moving(b) if b else CUBE, first, last))
    assert pieces[0].start == first and pieces[-1].end == last
    for p, q in itertools.pairwise(pieces):
        assert p.end == q.start
    for p in pieces:
        for k in range(5):
            u = p.u_lo + (p.u_hi - p.u_lo) * k / 4
            with precision(128):
                t = min(max(float(p.time_of(u)), to_double(first)), to_double(last))
            pose_a, pose_b = (m(t) if m else np.eye(4) for m in (a, b))
            assert np.allclose(floats(projective.value(p.pose, u)), np.linalg.inv(pose_b) @ pose_a, atol=1e-11)
            assert p.pose[3][3](u) > 0
            if p.frame is not None:
                assert np.allclose(floats(projective.value(p.frame, u)), pose_b, atol=1e-12) and p.frame[3][3](u) > 0
        common = fmpz_poly([0])
        for row in p.pose:
            for x in row:
                common = common.gcd(x)
        assert common.degree() == 0 and abs(common[0]) == 1
    return pieces


RNG = np.random.default_rng(34)
BETWEEN = [fc.RationalMotion.between(random_pose(RNG), random_pose(RNG)) for _ in range(2)]
AFFINE = fc.RationalMotion([np.eye(4), np.vstack([RNG.uniform(-0.3, 0.3, (3, 4)), np.zeros((1, 4))])])
MIRROR = fc.RationalMotion([np.diag([-1, 2, 1, 1]), [[0, 0, 0, 1], [0] * 4, [0] * 4, [0] * 4]])
TURN = fc.Rotation((1, 2, 3), point=(1, 0, 0), turns="3/4")


@pytest.mark.parametrize(
    ("a", "b", "degree"),
    [
        (fc.Translation((1, 2, 3)), fc.Translation((3, 0, "1/3")), 1), (fc.Translation((1, 2, 3)), None, 1),
        (None, fc.Translation((1, 2, 3)), 1), (BETWEEN[0], None, 3), (None, BETWEEN[0], 3),
        (BETWEEN[0], BETWEEN[1], 5), (BETWEEN[0], BETWEEN[0], 0), (fc.Translation((1, 2, 3)), BETWEEN[0], 3),
        (AFFINE, None, 1), (None, AFFINE, 3), (AFFINE, BETWEEN[0], 3), (MIRROR, fc.Translation((0, 1, 0)), 1),
        (fc.Translation((0, 1, 0)), MIRROR, 1), (TURN, None, 2), (None, TURN, 2), (TURN, TURN, 0),
        (TURN, fc.Rotation((3, 2, 1), point=(0, 0, 7), turns="3/4"), 4),
        (TURN, fc.Rotation((3, 2, 1), point=(0, 0, 7), turns="-3/4"), 4),
        (TURN, fc.Rotation((2, 4, 6), point=(0, 0, 7), turns="3/4"), 2),
        (fc.Rotation((0, 0, 5), radians=3), fc.Rotation((3, 4, 0), radians=3), 4),
        (fc.Rotation((1, 0, 1), turns=1), fc.Rotation((1, 1, 0), turns=-1), 4),
        (fc.Rotation((0, 0, 1), turns=1), fc.Rotation((0, 3, 4), turns=1), 4),
        (fc.Rotation((1, 1, 1), turns=1), fc.Rotation((1, 5, 1), turns=1), 4),
    ],
)  # fmt: skip
def test_relative_motion(a, b, degree):
    pieces = check_relative(a, b, ZERO, ONE)
    assert max(projective.degree(p.pose) for p in pieces) == degree


COAXIAL = [
    (TURN, fc.Rotation((2, 4, 6), point=(2, 2, 3), turns="1/4")),
    (TURN, fc.Rotation((-1, -2, -3), point=(1, 0, 0), turns=1)),
    (TURN, fc.Rotation((-1, -2, -3), point=(1, 0, 0), turns="3/4")),
    (fc.Rotation((1, 1, 0), radians=7), fc.Rotation((1, 1, 0), radians=3)),
    (fc.Rotation((0, 0, 1), turns=2),
     fc.Sequence([fc.Translation((0, 5, 0)), fc.Rotation((0, 0, -2), turns="1/5")], ["1/3", "2/3"])),
]  # fmt: skip


@pytest.mark.parametrize(("a", "b"), COAXIAL)
def test_two_rotations_about_one_line_are_one(a, b):
    first = fmpq(1, 3) if isinstance(b, fc.Sequence) else ZERO  # before, b translates
    for x, y in ((a, b), (b, a)):
        pieces = check_relative(x, y, first, ONE)
        assert all(p.frame is None and projective.degree(p.pose) == 2 for p in pieces)


@pytest.mark.parametrize(("slow", "fast"), [("1/3", 1), ("2/5", "-3/5"), (0.75, "15/4")])
def test_rotations_at_speeds_like_whole_numbers(slow, fast):
    a, b = fc.Rotation((2, 1, 2), (1, 0, 0), turns=slow), fc.Rotation((-1, 2, 2), (0, 3, 1), turns=fast)
    check_relative(a, b, ZERO, ONE)
    check_relative(b, a, fmpq(1, 7), fmpq(9, 2))


def test_relative_motion_of_steps():
    lifts = [fc.RationalMotion.between(np.eye(4), m(1.0)) for m in BETWEEN]
    steps = [fc.Translation((1, 0, 0)), TURN, fc.Rotation((0, 0, 1), turns="1/2"), lifts[0]]
    a = fc.Sequence(steps, durations=[1, 1, 2, 1])
    b = fc.Sequence([fc.Translation((0, 1, 0)), fc.Translation((0, 0, 0)), lifts[1]], durations=[1, 3, 1])
    pieces = check_relative(a, b, ZERO, fmpq(5))
    assert [to_double(p.start) for p in pieces] == pytest.approx([0, 1, 4 / 3, 2, 3, 4])
    assert [p.exact for p in pieces] == [True, True, True, False, False, False]
    check_relative(b, a, fmpq(1, 2), fmpq(9, 2))


def test_relative_motion_at_an_instant():
    third, other = fmpq(1, 3), fc.Rotation((1, 2, 3), turns="3/4")
    (piece,) = relative_pieces(CUBE.moving(TURN), CUBE.moving(other), third, third)
    assert piece.start == piece.end == third


SPIN = fc.Rotation((0, 0, 1), radians=9)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (fc.Translation((1, 0, 0)), TURN), (BETWEEN[0], TURN), (TURN, fc.Rotation((1, 2, 3), turns="1/40")),
        (TURN, fc.Rotation((3, 2, 1), radians="3/4")), (TURN, fc.Rotation((1, 0, 0), turns="3/4")),
        (SPIN, fc.Sequence([fc.Translation((1, 0, 0)), SPIN])),
    ],
)  # fmt: skip
def test_unsupported_pairs_are_named(a, b):
    lid, box = CUBE.named("lid").moving(a), CUBE.named("box").moving(b)
    for x, y in ((lid, box), (box, lid)):
        with pytest.raises(fc.UnsupportedPair, match="no rational function of one parameter") as caught:
            list(relative_pieces(x, y, ZERO, ONE))
        assert "of 'lid'" in str(caught.value) and "of 'box'" in str(caught.value) and "\n" not in str(caught.value)


def test_a_phase_of_whole_half_turns_is_shared():
    """The second body starts its turn half a turn later: the same parameter, other poses."""
    late = fc.Sequence([fc.Translation((0, 0, 0)), fc.Rotation((3, 0, 4), point=(1, 0, 0), turns=1)], [1, 2])
    pieces = check_relative(fc.Rotation((0, 0, 1), turns="1/2"), late, ZERO, fmpq(3))
    assert max(projective.degree(p.pose) for p in pieces) == 4


def test_pieces_meet_in_time():
    a, b = (next(polynomial_pieces(fc.Translation(v), ZERO, ONE)) for v in ((1, 0, 0), (0, 1, 0)))
    piece = relative(a, b)
    assert piece.of == "Translation of a body as seen from Translation of a body" and piece.frame == b.pose


@pytest.mark.parametrize("square", [fmpq(1), fmpq(3), fmpq(2, 5)])
def test_tangents_of_parts_of_a_half_turn(square):
    """All tan(pi a / b) / sqrt(square), b < 40, by their minimal polynomials: no degree bound drops one of them."""
    for b in range(1, 40):
        odd = [math.comb(b, j) * (-square) ** (j // 2) if j % 2 else 0 for j in range(b + 1)]
        part = fmpq_poly(odd)  # the imaginary part of (1 + i sqrt(square) u)^b, over sqrt(square)
        for factor, _ in part.factor()[1]:
            p = (factor * factor.denom()).numer()
            root = next(float(z.real) for z, _ in p.complex_roots() if z.imag == 0)
            share = math.atan(root * to_double(square) ** 0.5) / math.pi
            lowest = next(n for n in range(1, b + 1) if abs(share * n - round(share * n)) < 1e-9)
            for n in (lowest, 2 * lowest, lowest + 1, 5 * lowest - 1):
                assert _is_part_of_half_turn(p, square, n) is (n % lowest == 0), (b, p, n)
