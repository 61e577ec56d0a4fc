"""Motions whose pose is a rational function of the time."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpq_poly, fmpz_poly

from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction, rational, to_double
from firstcontact.exact.polynomials import bernstein
from firstcontact.exact.vectors import Vector, dot
from firstcontact.motion.poses import BITS, SNAP, Pose, Quaternion, read_poses, read_rows, sqrt_near
from firstcontact.motion.relative import projective
from firstcontact.motion.translation import LARGEST, SPAN, double_of
from firstcontact.motion.value import Motion, numbers

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given, Nested
    from firstcontact.result import Table

_0, _1 = fmpq(0), fmpq(1)
# How near (in time) an error text names a zero of the weight or of the determinant.
NEAR = fmpq(1, 10**6)
# Square of the cosine of half the angle below which two poses count as half a turn apart: 1e-12 radians.
HALF_TURN = fmpq(1, 10**24)
# Coordinates of poses below which no number of the motion between them reaches LARGEST: four times as much at most.
_LARGE = LARGEST / 16


class RationalMotion(Motion):
    """Motion by M(t) / w(t), M a polynomial with 4x4 matrices as coefficients and w its entry [3, 3].

    coefficients: (d+1, 4, 4) numbers, power basis, ascending; every number is taken exactly.  The last row of each is
    (0, 0, 0, weight).  Proved at construction: on the closed span (0, 1) the weight has no zero and the linear part
    is never singular (an affine motion may stretch or mirror the body).  There are no poses outside the span.

    >>> half = RationalMotion([
    ...     [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    ...     [[0, -2, 0, 4], [2, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]],
    ...     [[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    ... ])
    >>> half(1.0)[:3]  # a quarter turn about z, and a shift by 2
    array([[ 0., -1.,  0.,  2.],
           [ 1.,  0.,  0.,  0.],
           [ 0.,  0.,  1.,  0.]])
    >>> half.rigid, half.degree
    (True, 2)
    """

    __slots__ = ("coefficients", "pose", "rigid", "correction")
    span = SPAN
    extends = False

    coefficients: tuple[tuple[tuple[fmpq, ...], ...], ...]
    pose: projective.Matrix
    """The motion as integer polynomials without common factor, weight positive on the span."""
    rigid: bool
    """Whether the linear part is a rotation times the weight, exactly."""
    correction: float
    """By how much an entry of a matrix given to `between` is off the rotation that it stands for, at most."""

    def __init__(self, coefficients: Iterable[Nested]) -> None:
        self.coefficients = _read(coefficients)
        entries = [
            [fmpq_poly([matrix[i][j] for matrix in self.coefficients]) for j in range(4)] for i in range(4)
        ]
        self.pose = _checked(projective.integral(entries))
        self.rigid = projective.is_rigid(self.pose)
        self.correction = 0.0

    @classmethod
    def _rigid(cls, rows: list[list[fmpq_poly]]) -> RationalMotion:
        """Of what is known to be a rotation times the weight, which has no zero."""
        made = cls.__new__(cls)
        made.coefficients = _by_degree(rows)
        made.pose, made.rigid, made.correction = projective.reduced(projective.integral(rows), _0), True, 0.0
        return made

    @classmethod
    def between(
        cls,
        pose0: Nested,
        pose1: Nested,
        *,
        quat_xyzw: Nested | None = None,
        quat_wxyz: Nested | None = None,
        snap: Given = SNAP,
    ) -> RationalMotion:
        """The motion from pose0 (t = 0) to pose1 (t = 1): straight line of unit quaternions, linear translation.

        pose0, pose1: 4x4 arrays or (scipy Rotation, vector); with ``quat_xyzw=`` or ``quat_wxyz=`` (two quaternions
        of any length) they are the two vectors.  The body turns the short way; poses half a turn apart leave the way
        open and are an InputError.  Rotation of degree 2, motion of degree 3 in t; rotation rate not constant.

        Both end poses are met exactly where they are rational rotations; a 4x4 array that is one only up to rounding
        stands for the nearest rotation, within 2^-60; ``correction`` tells by how much an entry of it is off, at
        most, and more than `snap`, as entries of R^T R - 1 tell, is an InputError.  The lengths of the quaternions,
        which set the speed along the way, are rational within 2^-60.

        >>> turn = RationalMotion.between((0, 0, 0), (4, 0, 0), quat_xyzw=[(0, 0, 0, 1), (0, 0, 1, 1)])
        >>> turn(1.0)[:3].astype(int).tolist()
        [[0, -1, 0, 4], [1, 0, 0, 0], [0, 0, 1, 0]]
        """
        start, end = read_poses((pose0, pose1), ("pose0", "pose1"), quat_xyzw, quat_wxyz, snap)
        return join(start, end, "pose0 and pose1")

    @property
    def degree(self) -> int:
        """Degree in t of the coefficients given."""
        return len(self.coefficients) - 1

    @property
    def exact_span(self) -> tuple[fmpq, fmpq]:
        return _0, _1

    @property
    def is_rigid(self) -> bool:
        return self.rigid

    @property
    def is_rational(self) -> bool:
        return True

    @property
    def starts_here(self) -> bool:
        """Whether its pose at t = 0 is the identity."""
        weight = self.pose[3][3][0]
        return all(x[0] == (weight if i == j else 0) for i, row in enumerate(self.pose) for j, x in enumerate(row))

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t of the span: every entry the double nearest the truth."""
        if not 0 <= double_of(t) <= 1:
            raise InputError(f"time {t} is outside the span {self.span} of the RationalMotion")
        return np.array([[to_double(x) for x in row] for row in self.exact(rational(t, "time"))])

    def exact(self, t: fmpq) -> list[list[fmpq]]:
        """The exact 4x4 pose at time t."""
        return projective.value(self.pose, t)

    def controls(self, t0: fmpq, t1: fmpq, parts: int) -> np.ndarray:
        """(m, 4, 4) float64 poses: a point stays, from t0 to t1, in the hull of what they make of it.

        They are the Bernstein coefficients over each of `parts` equal parts, divided by those of the weight; a part
        is halved where one of these is not positive.  Their rounding is that of one double each.
        """
        waiting = [(t0 + (t1 - t0) * k / parts, t0 + (t1 - t0) * (k + 1) / parts) for k in range(parts)]
        out, n = [], projective.degree(self.pose)
        # The weight is positive on the span: on short parts its coefficients, which tend to its values, are too.
        while waiting:
            lo, hi = waiting.pop()
            weights = bernstein.coefficients(self.pose[3][3], lo, hi, n)
            if min(weights) <= 0:
                waiting += [(lo, (lo + hi) / 2), ((lo + hi) / 2, hi)]
                continue
            entries = [[bernstein.coefficients(x, lo, hi, n) for x in row] for row in self.pose]
            out += [[[to_double(x[i] / w) for x in row] for row in entries] for i, w in enumerate(weights)]
        return np.array(out)

    @property
    def is_one_step(self) -> bool:
        return self.velocity() is None

    def velocity(self) -> Vector | None:
        """That of a body which the motion shifts evenly, in a pose that never turns; None of other motions."""
        weight = self.pose[3][3]
        if weight.degree() or any(x.degree() > (j == 3) for row in self.pose for j, x in enumerate(row)):
            return None
        x, y, z = (fmpq(int(row[3][1]), int(weight[0])) for row in self.pose[:3])
        return x, y, z

    def shifted(self, by: Vector) -> RationalMotion:
        """The same motion in a world shifted by a vector."""
        moved = []
        for matrix in self.coefficients:
            weights, pairs = matrix[3], zip(matrix[:3], by, strict=True)
            rows = [[x + c * w for x, w in zip(row, weights, strict=True)] for row, c in pairs]
            moved.append([[*row[:3], row[3] - dot(row[:3], by)] for row in (*rows, weights)])
        return RationalMotion(moved)

    def magnified(self, factor: fmpq) -> RationalMotion:
        """The same motion in a world whose lengths are so many times as long."""
        return RationalMotion([
            [*([*row[:3], factor * row[3]] for row in m[:3]), [*(x / factor for x in m[3][:3]), m[3][3]]]
            for m in self.coefficients
        ])  # fmt: skip

    def _facts(self) -> tuple[Hashable, ...]:
        return self.coefficients

    def _quick(self) -> Iterable[fmpq]:
        return (x for matrix in self.coefficients for row in matrix for x in row)

    def _table(self) -> Table:
        off = {"correction": self.correction} if self.correction else {}
        return {"type": "rational", "coefficients": numbers(self.coefficients), **off}

    def __repr__(self) -> str:
        return f"<RationalMotion: degree {self.degree}, {'rigid' if self.rigid else 'affine'}>"

    def __reduce__(self) -> tuple[object, ...]:
        rows = tuple(tuple(tuple(map(fraction, row)) for row in matrix) for matrix in self.coefficients)
        return rebuilt, (rows, self.correction)


def rebuilt(coefficients: Iterable[Nested], correction: float) -> RationalMotion:
    """The motion, with what is known of the matrices it was made of."""
    made = RationalMotion(coefficients)
    made.correction = correction
    return made


def join(start: Pose, end: Pose, names: str) -> RationalMotion:
    """The motion between two poses; `names` is how an error text calls them."""
    p, q = start.quaternion, end.quaternion
    cosine, square_p, square_q = _products(p, q)
    refuse_half_turn(cosine, square_p, square_q, names)
    # q is brought to the length of p: then the line is that of unit quaternions, up to a factor (here a power of 2).
    ratio = sqrt_near(square_p / square_q, BITS) * (1 if cosine > 0 else -1)
    unit = fmpq(1, 1 << int(max(abs(x) for x in p).p).bit_length())
    line = [fmpq_poly([unit * x, unit * (ratio * y - x)]) for x, y in zip(p, q, strict=True)]
    vector = [fmpq_poly([x, y - x]) for x, y in zip(start.vector, end.vector, strict=True)]
    rows = projective.of_quaternion(line, vector)
    if max(map(abs, (*start.vector, *end.vector))) >= _LARGE:
        made = RationalMotion(_by_degree(rows))  # may have to be refused
    else:
        made = RationalMotion._rigid(rows)
    made.correction = max(start.correction, end.correction)
    return made


def _by_degree(rows: list[list[fmpq_poly]]) -> tuple[tuple[tuple[fmpq, ...], ...], ...]:
    """The coefficients, ascending, of a matrix of polynomials."""
    degree = max(x.degree() for row in rows for x in row)
    return tuple(tuple(tuple(fmpq(x[k]) for x in row) for row in rows) for k in range(degree + 1))


def refuse_opposite(start: Pose, end: Pose, names: str) -> fmpq:
    """The square of the cosine of half the angle between two poses; InputError where they are half a turn apart, which
    calls them `names`."""
    cosine, square_p, square_q = _products(start.quaternion, end.quaternion)
    refuse_half_turn(cosine, square_p, square_q, names)
    return cosine * cosine / (square_p * square_q)


def _products(p: Quaternion, q: Quaternion) -> tuple[fmpq, fmpq, fmpq]:
    """p.q, p.p, q.q."""
    pq, pp, qq = (sum((x * y for x, y in zip(u, v, strict=True)), _0) for u, v in ((p, q), (p, p), (q, q)))
    return pq, pp, qq


def refuse_half_turn(cosine: fmpq, square_p: fmpq, square_q: fmpq, names: str) -> None:
    """InputError where quaternions with this scalar product and squared lengths are half a turn apart."""
    if cosine * cosine <= HALF_TURN * square_p * square_q:
        raise InputError(
            f"{names} are half a turn apart, so neither way round is the short one; give a pose between them"
        )


def _read(coefficients: Iterable[Nested]) -> tuple[tuple[tuple[fmpq, ...], ...], ...]:
    try:
        matrices = list(coefficients)
    except TypeError as error:
        raise InputError(f"RationalMotion coefficients are {coefficients!r}; give (d+1, 4, 4) numbers") from error
    if not matrices:
        raise InputError("RationalMotion has no coefficients; give (d+1, 4, 4) numbers")
    out = []
    for k, matrix in enumerate(matrices):
        rows = read_rows(matrix, f"coefficients[{k}]")
        if any(rows[3][:3]):
            raise InputError(f"coefficients[{k}]: the last row is not (0, 0, 0, weight); give an affine motion")
        if any(abs(x) >= LARGEST for row in rows for x in row):
            raise InputError(f"coefficients[{k}] has an entry of 2^150 or more; give smaller numbers")
        out.append(tuple(map(tuple, rows)))
    return tuple(out)


def _checked(pose: projective.Matrix) -> projective.Matrix:
    """The reduced pose, proved to be defined and invertible on the closed span."""
    _refuse_zero(pose[3][3], "the weight, entry [3][3], is zero")
    pose = projective.reduced(pose, _0)
    _refuse_zero(projective.linear_determinant(pose), "the linear part is singular")
    return pose


def _refuse_zero(p: fmpz_poly, what: str) -> None:
    if p.is_zero():
        raise InputError(f"RationalMotion: {what} at all times; give an invertible motion")
    zero = bernstein.zero_between(p, _0, _1, NEAR)
    if zero is not None:
        time = to_double((zero[0] + zero[1]) / 2)
        raise InputError(f"RationalMotion: {what} at time {time:.6g} of the span (0, 1); give an invertible motion")
