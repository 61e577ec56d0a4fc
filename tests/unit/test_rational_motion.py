"""Rational motions: what is read, what is refused, poses, and the line of quaternions between two poses."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpz_poly
from scipy.spatial.transform import Rotation as Turn

import firstcontact as fc
from firstcontact.exact.polynomials import bernstein
from firstcontact.motion.relative import projective

ONE = np.eye(4)


def line(slope, offset=0):
    """The pose offset + slope t, as coefficients; `slope` and `offset` hold (row, column, value)."""
    low, high = np.eye(4).tolist(), np.zeros((4, 4)).tolist()
    for target, entries in ((low, offset or ()), (high, slope)):
        for i, j, value in entries:
            target[i][j] = value
    return [low, high]


def random_pose(rng):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Turn.random(rng=rng).as_matrix(), rng.uniform(-5, 5, 3)
    return pose


# ------------------------------------------------------------------------------------------------- Bernstein form


def test_bernstein_coefficients_are_the_values_of_a_hat():
    p = fmpz_poly([1, -6, 6])  # (1, -2, 1) over [0, 1]
    assert bernstein.coefficients(p, fmpq(0), fmpq(1), 2) == [1, -2, 1]
    raised = bernstein.coefficients(p, fmpq(0), fmpq(1), 3)
    assert raised == [1, -1, -1, 1]
    over = bernstein.coefficients(p, fmpq(1, 4), fmpq(1, 2), 2)
    assert over[0] == p(fmpq(1, 4)) and over[-1] == p(fmpq(1, 2))


@pytest.mark.parametrize(
    ("p", "zero"),
    [
        ([1], None), ([1, 1], None), ([0, 1], 0), ([-1, 1], 1), ([-1, 2], 0.5), ([1, -4, 4], 0.5), ([1, -2, 2], None),
        ([2, -3, 1], 1), ([0, 0, 1], 0), ([-1, 0, 2], 0.5**0.5), ([6, -35, 50], 0.3), ([100001, -400000, 400000], None),
        ([1, -200, 10000 + 1], None), ([-8, 5], None),
    ],
)  # fmt: skip
def test_the_first_zero_in_the_closed_unit_interval(p, zero):
    found = bernstein.zero_between(fmpz_poly(p), fmpq(0), fmpq(1), fmpq(1, 10**9))
    if zero is None:
        assert found is None
    else:
        lo, hi = (float(x.p) / float(x.q) for x in found)
        assert lo - 1e-15 <= zero <= hi + 1e-15 and hi - lo <= 1e-9


def test_random_polynomials_have_the_zeros_that_were_planted():
    rng = np.random.default_rng(3)
    for _ in range(200):
        zeros = sorted(fmpq(int(a), 64) for a in rng.integers(-64, 192, int(rng.integers(1, 6))))
        p = fmpz_poly([1, 0, 3])
        for z in zeros:
            p *= fmpz_poly([-z.p, z.q])
        inside = [z for z in zeros if 0 <= z <= 1]
        found = bernstein.zero_between(p, fmpq(0), fmpq(1), fmpq(1, 1000))
        assert (found is None) == (not inside)
        assert not inside or found[0] <= inside[0] <= found[1]


# ------------------------------------------------------------------------------------------------------- matrices


def test_inverse_and_reduced_matrices():
    rng = np.random.default_rng(4)
    for rigid in (True, False):
        motion = (
            fc.RationalMotion.between(random_pose(rng), random_pose(rng))
            if rigid
            else fc.RationalMotion([ONE, 0.2 * np.vstack([rng.uniform(-1, 1, (3, 4)), np.zeros((1, 4))])])
        )
        back = projective.inverse(motion.pose, fmpq(0))
        both = projective.reduced(projective.product(back, motion.pose), fmpq(0))
        assert [[x.coeffs() for x in row] for row in both] == [
            [[1] if i == j else [] for j in range(4)] for i in range(4)
        ]
        assert back[3][3](fmpq(1, 2)) > 0 and motion.rigid is rigid
        # the common factor of the rigid inverse is gone: R^T over w, R^T v over w
        assert projective.degree(back) == 3


def test_mirrors_have_inverses_of_positive_weight():
    mirror = fc.RationalMotion([np.diag([-1, 1, 1, 1]), [[0, 0, 0, 1], [0] * 4, [0] * 4, [0] * 4]])
    assert not mirror.rigid
    back = projective.inverse(mirror.pose, fmpq(0))
    assert [int(back[i][i][0]) for i in range(4)] == [-1, 1, 1, 1]
    stretched = fc.RationalMotion([np.diag([-2, 1, 1, 1])])
    assert [int(projective.inverse(stretched.pose, fmpq(0))[i][i][0]) for i in range(4)] == [-1, 2, 2, 2]


# ------------------------------------------------------------------------------------------------ construction


def paper_motion():
    """Rotation about y with cos 2t(1-t)/w, sin (1-2t)/w, w = 2t^2-2t+1, and a translation (Choi et al., example 7)."""
    m = np.zeros((4, 4, 4))
    m[:3, 0, 0] = m[:3, 2, 2] = (0, 2, -2)
    m[:3, 1, 1] = m[:3, 3, 3] = (1, -2, 2)
    m[:2, 0, 2], m[:2, 2, 0] = (1, -2), (-1, 2)
    m[:, 0, 3], m[:, 1, 3] = (30, -120, 180, -120), (-50, 180, -260, 160)
    return m


def test_the_poses_of_the_paper():
    motion = fc.RationalMotion(paper_motion())
    assert motion.rigid and motion.degree == 3 and motion.span == (0.0, 1.0)
    assert motion(0.0).tolist() == [[0, 0, 1, 30], [0, 1, 0, -50], [-1, 0, 0, 0], [0, 0, 0, 1]]
    # the translation over the weight is linear: (30 - 60 t, 80 t - 50, 0)
    for t in (0.0, 0.2, 0.625, 1.0):
        pose = motion(t)
        assert np.allclose(pose[:3, 3], [30 - 60 * t, 80 * t - 50, 0], atol=1e-14)
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-15)
    assert projective.degree(motion.pose) == 3


def test_numbers_are_exact_and_negative_weights_turned():
    motion = fc.RationalMotion(line([(0, 3, "1/3")]))
    assert motion.exact(fmpq(1))[0][3] == fmpq(1, 3)
    minus = fc.RationalMotion((-np.array(line([(0, 3, 2)]))).tolist())
    assert minus(0.5)[0, 3] == 1 and minus.pose[3][3](fmpq(0)) == 1
    common = [[[(k == i) * (i < 4 and 2) for i in range(4)] for k in range(4)]]
    assert fc.RationalMotion(common).pose == fc.RationalMotion([ONE]).pose


@pytest.mark.parametrize(
    ("coefficients", "says"),
    [
        (5, r"give \(d\+1, 4, 4\)"), ([], "no coefficients"), ([np.eye(3)], r"coefficients\[0\] is no 4x4"),
        ([5], r"coefficients\[0\] is 5"), ([[[1, 2, 3, "x"]] + [[0] * 4] * 3], r"coefficients\[0\]\[0\]\[3\]"),
        (line([(3, 0, 1)]), r"coefficients\[1\]: the last row"),
        (line([(0, 0, math.nan)]), r"coefficients\[1\]\[0\]\[0\] is nan"),
        (line([(0, 3, 2**150)]), r"coefficients\[1\] has an entry"),
        (line([(3, 3, -4)]), r"weight, entry \[3\]\[3\], is zero at time 0\.25"),
        (line([(3, 3, -1)]), "is zero at time 1 "),
        (line([(3, 3, 1)], [(3, 3, 0)]), "is zero at time 0 "),
        (line([], [(3, 3, 0)]), "weight, entry .* is zero at all times"),
        (line([(2, 2, -2)]), r"the linear part is singular at time 0\.5"),
        (line([], [(2, 2, 0)]), "the linear part is singular at all times"),
        ([np.diag([1, 1, 0.25, 1]), np.diag([0, 0, -1, 0]), np.diag([0, 0, 1, 0])], r"singular at time 0\.5"),
    ],
)  # fmt: skip
def test_bad_coefficients_are_named(coefficients, says):
    with pytest.raises(fc.InputError, match=says):
        fc.RationalMotion(coefficients)


def test_near_misses_are_accepted():
    eps = Fraction(1, 10**30)
    rows = [np.diag([1, 1, 0, 1]).astype(object), np.diag([0, 0, -1, 0]).astype(object), np.diag([0, 0, 1, 0])]
    rows[0][2, 2] = Fraction(1, 4) + eps  # (t - 1/2)^2 + eps
    assert not fc.RationalMotion(rows).rigid
    just = line([(3, 3, -1 + Fraction(1, 10**30))])
    assert fc.RationalMotion(just).exact(fmpq(1))[0][0] == 10**30


def test_times_outside_the_span():
    for t in (-1e-9, 1.0000001, math.nan, math.inf):
        with pytest.raises(fc.InputError, match="outside the span|finite number"):
            fc.RationalMotion([ONE])(t)


def test_controls_hold_the_path():
    rng = np.random.default_rng(6)
    motion = fc.RationalMotion.between(random_pose(rng), random_pose(rng))
    wild = fc.RationalMotion(line([(0, 3, 7), (3, 3, Fraction(-999, 1000))]))
    for m, parts in ((motion, 1), (motion, 8), (wild, 1)):
        p = np.array([1.0, -2, 3, 1])
        corners = m.controls(fmpq(1, 10), fmpq(9, 10), parts) @ p
        path = np.array([m(t) @ p for t in np.linspace(0.1, 0.9, 101)])
        assert np.all(corners.min(axis=0) <= path.min(axis=0) + 1e-12)
        assert np.all(corners.max(axis=0) >= path.max(axis=0) - 1e-12)


# ------------------------------------------------------------------------------------------------------ between


def test_the_ends_are_met():
    rng = np.random.default_rng(7)
    for _ in range(50):
        p, q = random_pose(rng), random_pose(rng)
        motion = fc.RationalMotion.between(p, q)
        assert motion.rigid and motion.degree == 3
        assert np.abs(motion(0.0) - p).max() <= 1e-15 and np.abs(motion(1.0) - q).max() <= 1e-15


def test_the_way_is_the_line_of_unit_quaternions_the_short_way():
    rng = np.random.default_rng(8)
    for _ in range(20):
        p, q = random_pose(rng), random_pose(rng)
        a, b = (Turn.from_matrix(x[:3, :3]).as_quat() for x in (p, q))
        b = b if a @ b > 0 else -b
        for t in (0.25, 0.5, 0.9):
            pose = fc.RationalMotion.between(p, q)(t)
            assert np.allclose(pose[:3, :3], Turn.from_quat((1 - t) * a + t * b).as_matrix(), atol=4e-15)
            assert np.allclose(pose[:3, 3], (1 - t) * p[:3, 3] + t * q[:3, 3], atol=4e-15)


def test_rational_rotations_are_met_exactly():
    quarter = [[0, -1, 0, 4], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    tilted = [["3/5", "-4/5", 0, 0], ["4/5", "3/5", 0, "1/3"], [0, 0, 1, 0], [0, 0, 0, 1]]
    motion = fc.RationalMotion.between(quarter, tilted)
    assert motion.exact(fmpq(0)) == quarter
    assert motion.exact(fmpq(1)) == [[fmpq(3, 5), fmpq(-4, 5), 0, 0], [fmpq(4, 5), fmpq(3, 5), 0, fmpq(1, 3)],
                                     [0, 0, 1, 0], [0, 0, 0, 1]]  # fmt: skip


def test_the_forms_of_a_pose_agree():
    q, v = (0.1, -0.7, 0.3, 0.5), (1, 2, 3)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Turn.from_quat(q).as_matrix(), v
    scipy = fc.RationalMotion.between((Turn.identity(), (0, 0, 0)), (Turn.from_quat(q), v))
    plain = fc.RationalMotion.between(ONE, matrix)
    xyzw = fc.RationalMotion.between((0, 0, 0), v, quat_xyzw=[(0, 0, 0, 2), q])
    wxyz = fc.RationalMotion.between((0, 0, 0), v, quat_wxyz=[(1, 0, 0, 0), (q[3], *q[:3])])
    assert xyzw.pose == wxyz.pose
    for t in (0.0, 0.4, 1.0):
        for m in (scipy, plain, wxyz):
            assert np.allclose(m(t), xyzw(t), atol=1e-15)


def test_equal_rotations_give_a_straight_line():
    q = [(1, 2, 3, 4), (-2, -4, -6, -8)]
    motion = fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=q)
    assert projective.degree(motion.pose) == 1 and motion(0.5)[0, 3] == 0.5


def test_speed_is_that_of_unit_quaternions_to_2_to_the_minus_60():
    """Weight (2 - u) t^2 - (2 - u) t + 1 with u = 2 q0.q1 (Choi et al., degree-2 rotation)."""
    motion = fc.RationalMotion.between((0, 0, 0), (0, 0, 0), quat_wxyz=[(5, 0, 0, 0), (1, 0, 0, 1)])
    w = motion.pose[3][3]
    ratio = [fmpq(w[k]) / fmpq(w[0]) for k in range(3)]
    assert abs(float(ratio[2].p) / float(ratio[2].q) - (2 - math.sqrt(2))) < 1e-15
    gap = abs((2 - ratio[2]) ** 2 - 2)
    assert 0 < gap < fmpq(1, 2**58) and abs(ratio[1] + ratio[2]) < fmpq(1, 2**59)


@pytest.mark.parametrize(
    ("poses", "keys", "says"),
    [
        ((ONE, np.diag([-1, -1, 1, 1])), {}, "half a turn apart"),
        (((0, 0, 0), (1, 0, 0)), {"quat_xyzw": [(0, 0, 0, 1), (1, 0, 0, 0)]}, "half a turn apart"),
        ((ONE, np.diag([2, 1, 1, 1])), {}, "pose1: the linear part is no rotation .it misses one by 3, more "),
        ((np.diag([-1, 1, 1, 1]), ONE), {}, "pose0: the linear part is no rotation, it mirrors the body"),
        ((ONE, ONE), {"snap": -1}, "snap is -1; give a number that is not negative"),
        ((ONE, np.diag([1 + 1e-9, 1, 1, 1])), {"snap": 0}, "pose1: the linear .* misses one by 2e-09"),
        ((ONE, ONE + 1e-6), {}, r"pose1: the last row is not \(0, 0, 0, 1\)"),
        ((ONE, ONE[:3]), {}, "pose1 is"),
        ((ONE, 5), {}, "pose1 is 5"),
        (((0, 0), (1, 0, 0)), {"quat_xyzw": [(0, 0, 0, 1)] * 2}, r"pose0 is \(0, 0\)"),
        (((0, 0, 0), (1, 0, 0)), {"quat_xyzw": [(0, 0, 0, 1)]}, "1 quaternions for 2 poses"),
        (((0, 0, 0), (1, 0, 0)), {"quat_xyzw": [(0, 0, 0, 1), (0, 0, 0, 0)]}, r"quat_xyzw\[1\] is"),
        (((0, 0, 0), (1, 0, 0)), {"quat_wxyz": [(0, 0, 1), (1, 0, 0, 0)]}, r"quat_wxyz\[0\] is"),
        (((0, 0, 0), (1, 0, 0)), {"quat_wxyz": 7}, "quat_wxyz is 7"),
        (((0, 0, 0), (1, 0, 0)), {"quat_wxyz": [7, 8]}, r"quat_wxyz\[0\] is 7"),
        (((0, 0, 0), (1, 0, 0)), {"quat_wxyz": [1, 2], "quat_xyzw": [1, 2]}, "both given"),
    ],
)  # fmt: skip
def test_bad_poses_are_named(poses, keys, says):
    with pytest.raises(fc.InputError, match=says):
        fc.RationalMotion.between(*poses, **keys)


def test_half_a_turn_up_to_rounding_is_refused_and_less_is_not():
    def turned(angle):
        pose = np.eye(4)
        pose[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        return pose

    with pytest.raises(fc.InputError, match="half a turn apart"):
        fc.RationalMotion.between(ONE, turned(math.pi))
    assert np.allclose(fc.RationalMotion.between(ONE, turned(math.pi - 1e-6))(0.5), turned(math.pi / 2), atol=1e-6)


def test_quaternions_of_any_size():
    tiny = fc.RationalMotion.between((0, 0, 0), (0, 0, 1), quat_wxyz=[(1e-300, 0, 0, 0), (1, 1e-300, 0, 0)])
    assert np.allclose(tiny(1.0), [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]])


@pytest.mark.parametrize("make", [
    lambda: fc.RationalMotion(paper_motion()),
    lambda: fc.RationalMotion.between(ONE, [[0, -1, 0, "1/3"], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
])  # fmt: skip
def test_pickling(make):
    motion = make()
    again = pickle.loads(pickle.dumps(motion))
    assert again.coefficients == motion.coefficients and again.pose == motion.pose and repr(again) == repr(motion)
    assert repr(motion) == "<RationalMotion: degree 3, rigid>"
