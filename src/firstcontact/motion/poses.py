"""Rigid poses as users give them, as an exact quaternion and vector.

A pose is a 4x4 array, or (scipy Rotation, vector); with ``quat_xyzw=`` or ``quat_wxyz=`` it is a vector, and the
quaternions stand beside, one per pose.  A quaternion of any length counts as given: it is the rotation
x -> q x q^-1.  A matrix that is exactly a rotation is taken exactly; one that is a rotation up to rounding (`SNAP`)
becomes the nearest rotation, by a rational quaternion within 2^-60, and the pose tells how far that is.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from flint import fmpq, fmpq_mat, fmpz

from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction, rational, to_double
from firstcontact.exact.rigid import Matrix, quaternion_rotation
from firstcontact.exact.vectors import Vector
from firstcontact.motion.translation import vector3

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given, Nested

Quaternion = tuple[fmpq, fmpq, fmpq, fmpq]
Rows = list[list[fmpq]]

SNAP = 1e-6
# Largest snap: beyond it the nearest rotation is not found by steps towards it, and a matrix may have none.
MOST_SNAP = fmpq(1, 2)
"""Largest |R^T R - 1| of a matrix that counts as a rounded rotation; float32 and seven printed digits stay below it."""
# Bits of a quaternion that stands for a rounded rotation: its angle is then within 2^-60.
BITS = 64
_ONE = fmpq_mat(3, 3, [int(i == j) for i in range(3) for j in range(3)])


@dataclass(frozen=True, slots=True)
class Pose:
    """Rotation by the quaternion (w, x, y, z), coprime integers, followed by a shift by `vector`.

    correction: by how much an entry of the matrix that was given is off this rotation, at most.
    """

    quaternion: Quaternion
    vector: Vector
    correction: float = field(default=0.0, compare=False)

    def matrix(self) -> Matrix:
        """The exact 3x4 matrix."""
        w, x, y, z = self.quaternion
        rows = quaternion_rotation(w, (x, y, z), (fmpq(0), fmpq(0), fmpq(0)))
        return tuple((*row[:3], shift) for row, shift in zip(rows, self.vector, strict=True))  # type: ignore[return-value]

    def __reduce__(self) -> tuple[object, ...]:
        rows = tuple(map(fraction, self.quaternion)), tuple(map(fraction, self.vector))
        return _rebuild, (*rows, self.correction)


def _rebuild(quaternion: Iterable[fmpq], vector: Iterable[fmpq], correction: float = 0.0) -> Pose:
    exact = tuple(rational(x, "quaternion") for x in quaternion)
    return Pose(exact, vector3(vector, "vector"), correction)  # type: ignore[arg-type]


def read_poses(
    poses: Iterable[Any],
    names: Iterable[str],
    quat_xyzw: Nested | None = None,
    quat_wxyz: Nested | None = None,
    snap: Given = SNAP,
) -> list[Pose]:
    """The poses, named in errors by `names`; with quaternions given, `poses` are their vectors (n, 3)."""
    poses, names, most = list(poses), list(names), rational(snap, "snap")
    if not 0 <= most <= MOST_SNAP:
        raise InputError(f"snap is {snap!r}; give a number that is not negative, at most {MOST_SNAP}")
    if quat_xyzw is None and quat_wxyz is None:
        return [read_pose(pose, name, most) for pose, name in zip(poses, names, strict=True)]
    if quat_xyzw is not None and quat_wxyz is not None:
        raise InputError("quat_xyzw= and quat_wxyz= are both given; give one of them")
    key, values = ("quat_xyzw", quat_xyzw) if quat_xyzw is not None else ("quat_wxyz", quat_wxyz)
    try:
        quaternions = list(values)  # type: ignore[arg-type]  # one of them is given
    except TypeError as error:
        raise InputError(f"{key} is {values!r}; give one quaternion for each of the {len(poses)} poses") from error
    if len(quaternions) != len(poses):
        raise InputError(f"{key} has {len(quaternions)} quaternions for {len(poses)} poses; give one for each")
    return [
        Pose(_quaternion(quaternion, f"{key}[{k}]", key == "quat_wxyz"), vector3(pose, name))
        for k, (quaternion, pose, name) in enumerate(zip(quaternions, poses, names, strict=True))
    ]


def read_pose(pose: Any, name: str, snap: fmpq) -> Pose:
    """One pose: a 4x4 array, or (scipy Rotation, vector)."""
    parts = list(pose) if hasattr(pose, "__iter__") else []
    if len(parts) == 2 and hasattr(parts[0], "as_quat"):
        return Pose(_quaternion(parts[0].as_quat(), f"{name}[0]", False), vector3(parts[1], f"{name}[1]"))
    if len(parts) != 4:
        raise InputError(
            f"{name} is {pose!r}; give a 4x4 array, (scipy Rotation, vector), or a vector and quat_xyzw= or quat_wxyz="
        )
    rows = read_rows(parts, name)
    if rows[3] != [0, 0, 0, 1]:
        raise InputError(f"{name}: the last row is not (0, 0, 0, 1); give a rigid pose")
    turn = Pose(_quaternion_of(rows, name, snap), vector3([row[3] for row in rows[:3]], name))
    off = max(abs(x - y) for given, taken in zip(rows, turn.matrix(), strict=False)
              for x, y in zip(given[:3], taken, strict=False))  # fmt: skip
    return turn if off == 0 else replace(turn, correction=math.nextafter(to_double(off), 1.0))


def read_rows(values: Any, name: str) -> Rows:
    """Four rows of four exact numbers."""
    try:
        rows = [list(row) for row in values]
    except TypeError as error:
        raise InputError(f"{name} is {values!r}; give four rows of four numbers") from error
    if len(rows) != 4 or any(len(row) != 4 for row in rows):
        raise InputError(f"{name} is no 4x4 matrix; give four rows of four numbers")
    return [[rational(x, f"{name}[{i}][{j}]") for j, x in enumerate(row)] for i, row in enumerate(rows)]


def _quaternion(values: Any, name: str, scalar_first: bool) -> Quaternion:
    try:
        parts = [rational(x, f"{name}[{k}]") for k, x in enumerate(values)]
    except TypeError as error:
        raise InputError(f"{name} is {values!r}; give four numbers") from error
    if len(parts) != 4 or not any(parts):
        raise InputError(f"{name} is {values!r}; give four numbers, not all zero")
    return _primitive(parts if scalar_first else [parts[3], *parts[:3]])


def _primitive(q: list[fmpq]) -> Quaternion:
    """The coprime integers in the same ratio."""
    below, content = fmpz(1), fmpz(0)
    for x in q:
        below = below.lcm(x.q)
    for x in q:
        content = content.gcd((x * below).p)
    return tuple(x * below / content for x in q)  # type: ignore[return-value]


def _quaternion_of(rows: Rows, name: str, snap: fmpq) -> Quaternion:
    """The quaternion of a rotation matrix, exact where the matrix is."""
    r = fmpq_mat(3, 3, [x for row in rows[:3] for x in row[:3]])
    gram = r.transpose() * r
    defect = _defect(gram)
    if defect > snap:
        raise InputError(
            f"{name}: the linear part is no rotation (it misses one by {to_double(defect):.1g}, more than "
            f"snap = {to_double(snap):.1g}); give more digits, a larger snap=, or RationalMotion(coefficients) for "
            "affine motions"
        )
    if r.det() < 0:
        raise InputError(
            f"{name}: the linear part is no rotation, it mirrors the body (its determinant is negative); "
            "check the order and the signs of its axes"
        )
    while defect != 0 and defect > fmpq(1, 2**80):
        r = r * (3 * _ONE - gram) / 2  # a step towards the nearest rotation: the defect is squared
        gram = r.transpose() * r
        defect = _defect(gram)
    q = _dominant(r.tolist())
    return _primitive(q) if defect == 0 else _rounded(q)


def _defect(gram: fmpq_mat) -> fmpq:
    """The largest entry of |R^T R - 1|."""
    return max(abs(x) for row in (gram - _ONE).tolist() for x in row)


def _dominant(r: Rows) -> list[fmpq]:
    """A multiple of the quaternion: of the four rows of 4 q q^T the one with the largest diagonal entry."""
    (a, b, c), (d, e, f), (g, h, i) = r
    rows = [
        [1 + a + e + i, h - f, c - g, d - b],
        [h - f, 1 + a - e - i, b + d, c + g],
        [c - g, b + d, 1 - a + e - i, f + h],
        [d - b, c + g, f + h, 1 - a - e + i],
    ]
    return max(zip(rows, range(4), strict=True), key=lambda pair: pair[0][pair[1]])[0]


def _rounded(q: list[fmpq]) -> Quaternion:
    """The unit quaternion in the direction of q, each entry to within 2^-64."""
    length = sqrt_near(sum((x * x for x in q), fmpq(0)), 2 * BITS)
    return _primitive([fmpq((x / length * 2**BITS + fmpq(1, 2)).floor()) for x in q])


def sqrt_near(x: fmpq, bits: int) -> fmpq:
    """The square root of x > 0, exact where it is rational, else within a relative 2^-bits."""
    p, q = x.p.isqrt(), x.q.isqrt()
    if p * p == x.p and q * q == x.q:
        return fmpq(p, q)
    shift = max(bits + 2 - (int(x.p).bit_length() - int(x.q).bit_length()) // 2, 0)
    return fmpq(fmpz((int(x.p) << 2 * shift) // int(x.q)).isqrt(), fmpz(1) << shift)
