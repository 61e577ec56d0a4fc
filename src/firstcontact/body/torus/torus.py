"""The solid torus: all points at most `minor` from a circle of radius `major`, and its images under affine maps."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.placing import Placing
from firstcontact.body.solid.csg import Leaf, Tree
from firstcontact.body.told import point
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import exact_value, rational, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix, apply, compose, inverse_map
from firstcontact.exact.vectors import cross, dot, sub
from firstcontact.motion.translation import LARGEST
from firstcontact.motion.value import number, numbers

if TYPE_CHECKING:

    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.ring import N, VectorOf
    from firstcontact.result import Table

ROUNDED = 1e-14
"""What bounds of a torus lose by rounding, of the numbers in them."""
FEWEST = 8
"""Sides of either circle of a mesh, at least."""


Wall = tuple[fmpq, fmpq, fmpq, fmpq, fmpq]
"""p, a, b, c, d: p rho + a x + b y + c z + d <= 0 behind it, in the torus's frame, rho the distance from the axis."""


@dataclass(frozen=True, slots=True)
class Face:
    """The face of a torus."""

    index: int
    name: str


class Torus(Placing):
    """The solid torus about z, or its image under an affine map; immutable.  Made by `torus`.

    (x^2 + y^2 + z^2 + R^2 - r^2)^2 <= 4 R^2 (x^2 + y^2) for R = major, r = minor, in its own frame.

    >>> ring = torus(2, "1/2", name="ring")
    >>> ring, ring.contains([(2, 0, 0), (0, 0, 0)]).tolist()
    (<Torus 'ring': major 2, minor 0.5>, [True, False])
    """

    kind = "Torus"
    bounded = True
    edges = seams = vertices = ()
    is_whole = True
    """Whether it is all of the torus; else a sector, see there."""
    exact_shares: tuple[fmpq, fmpq] = (fmpq(0), fmpq(1))
    """Of minor: from where to where it reaches from its circle."""
    angles: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 2.0 * math.pi),) * 2
    """From where to where it reaches about its axis, and about its circle."""
    tree: Tree = Leaf(0)
    """Of its conditions, each told by a sign: here s <= minor alone."""

    walls: Sequence[Wall] = ()
    """Of a sector."""

    def __init__(self, major: fmpq, minor: fmpq, matrix: Matrix = IDENTITY, name: str | None = None) -> None:
        self.major, self.minor, self.matrix, self.name = major, minor, matrix, name
        self._search: dict[Any, Any] = {}
        lo, hi = self.bounds()
        if not np.abs([lo, hi]).max() < 2.0**150:
            raise InputError(f"{name or 'torus'}: coordinates leave the range 2^150; give smaller ones")

    @property
    def faces(self) -> tuple[Face, ...]:
        return (Face(0, f"{self.name}.surface" if self.name else "surface"),)

    @property
    def radii(self) -> tuple[float, float]:
        return to_double(self.major), to_double(self.minor)

    @property
    def shares(self) -> tuple[float, float]:
        near, far = self.exact_shares
        return to_double(near), to_double(far)

    @property
    def middle(self) -> np.ndarray:
        """(3,) a point deep inside."""
        u, v = (0.5 * (first + last) for first, last in self.angles)
        s = 0.5 * sum(self.shares) * self.radii[1]
        rho = self.radii[0] + s * math.cos(v)
        middle: np.ndarray = self.pose @ [rho * math.cos(u), rho * math.sin(u), s * math.sin(v), 1.0]
        return middle

    @property
    def pose(self) -> np.ndarray:
        """(3, 4): from its own frame to the one it stands in, rounded."""
        return np.array([[to_double(x) for x in row] for row in self.matrix])

    @property
    def back(self) -> Matrix:
        """From the frame it stands in to its own."""
        return inverse_map(self.matrix)

    # -- placing --------------------------------------------------------------------------------------------

    def _with(self, **changes: object) -> Torus:
        own: dict[str, Any] = {"major": self.major, "minor": self.minor, "matrix": self.matrix, "name": self.name}
        return Torus(**own | changes)

    def _mapped(self, matrix: Matrix) -> Torus:
        return self._with(matrix=compose(matrix, self.matrix))

    # -- looking --------------------------------------------------------------------------------------------

    def contains(self, points: np.ndarray | Sequence[Sequence[Given]]) -> np.ndarray:
        """(n,) bools: whether each of the (n, 3) points is in the closed solid; one bool for one (3,) point.  Exact."""
        try:
            p = np.asarray(points, float)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"points are {shown(points)}; give an (n, 3) array of numbers") from error
        if p.shape[-1:] != (3,) or p.ndim > 2 or not np.all(np.isfinite(p)):
            raise InputError(f"points have shape {p.shape}; give an (n, 3) array of finite numbers")
        lo, hi = self.bounds()
        near = ((p >= lo) & (p <= hi)).all(axis=-1).reshape(-1)
        rows = zip(near.tolist(), p.reshape(-1, 3).tolist(), strict=True)
        found = [here and self._holds([exact_value(c) for c in row]) for here, row in rows]
        return np.array(found if p.ndim == 2 else found[0])

    def _holds(self, place: list[fmpq]) -> bool:
        x, y, z = apply(self.back, (place[0], place[1], place[2]))
        return bool(quartic(self.major, self.minor, x, y, z) <= 0)

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the body."""
        (major, minor), pose = self.radii, self.pose
        reach = major * np.hypot(pose[:, 0], pose[:, 1]) + minor * np.linalg.norm(pose[:, :3], axis=1)
        reach = reach + ROUNDED * (reach + np.abs(pose[:, 3]))
        return pose[:, 3] - reach, pose[:, 3] + reach

    def is_round(self, axis: VectorOf[fmpq], point: VectorOf[fmpq]) -> bool:
        x, y, z, centre = zip(*self.matrix, strict=True)
        if any(cross(z, axis)) or any(cross(sub(centre, point), axis)):
            return False
        return bool(dot(x, x) == dot(y, y) and dot(x, y) == dot(x, z) == dot(y, z) == 0)

    def skin(self, tolerance: float, lo: np.ndarray, hi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Its face as triangles (n, 3, 3) that look outwards, faces (n,), and normals (n, 3, 3) of corners."""
        points, normals, triangles = self._grid(tolerance)
        return points[triangles], np.zeros(len(triangles), int), normals[triangles]

    def to_mesh(self, tolerance: float) -> Polyhedron:
        """A Polyhedron of triangles with all vertices on the surface, at most `tolerance` from it."""
        from firstcontact.body.polyhedron.polyhedron import Polyhedron
        from firstcontact.exact.numbers import positive_double

        points, _, triangles = self._grid(positive_double(tolerance, "tolerance", "length"))
        return Polyhedron(points, triangles.astype(np.int32), name=self.name)

    def _grid(self, tolerance: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(n, 3) points, (n, 3) unit normals and (m, 3) triangles that look outwards."""
        (major, minor), pose = self.radii, self.pose
        share = 0.5 * tolerance / float(np.linalg.norm(pose[:, :3], 2))
        along, around = _sides(major + minor, share), _sides(minor, share)
        u, v = (x.ravel() for x in np.meshgrid(_turn(along), _turn(around), indexing="ij"))
        ring, outward = np.column_stack([np.cos(u), np.sin(u), 0 * u]), np.column_stack([0 * v, 0 * v, np.sin(v)])
        outward = outward + np.cos(v)[:, None] * ring
        points = (major * ring + minor * outward) @ pose[:, :3].T + pose[:, 3]
        normals = outward @ np.linalg.inv(pose[:, :3])
        i, j = (x.ravel() for x in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
        a, b = i * around + j, (i + 1) % along * around + j
        c, d = (i + 1) % along * around + (j + 1) % around, i * around + (j + 1) % around
        triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        if np.linalg.det(pose[:, :3]) < 0:
            triangles = triangles[:, ::-1]
        return points, normals / np.linalg.norm(normals, axis=1, keepdims=True), triangles

    def told(self) -> list[str]:
        lo, hi = self.bounds()
        return [f"1 face, a torus, {self._radii_told()}", f"from ({point(lo)}) to ({point(hi)})"]

    def _radii_told(self) -> str:
        return f"major {number(self.major)}, minor {number(self.minor)}"

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        return f"<Torus{name}: {self._radii_told()}>"

    def __getstate__(self) -> dict[str, object]:
        return {"table": self._table(), "name": self.name}

    def __setstate__(self, state: dict[str, Any]) -> None:
        table = state["table"]
        rows = table.get("transform")
        matrix: Any = IDENTITY if rows is None else tuple(tuple(rational(x, "matrix") for x in row) for row in rows[:3])
        major, minor = (rational(table[key], key) for key in ("major", "minor"))
        self.__init__(major, minor, matrix, state["name"])  # type: ignore[misc]

    def _facts(self) -> tuple[Hashable, ...]:
        return self.major, self.minor, self.matrix

    def _table(self) -> Table:
        placed = {} if self.matrix == IDENTITY else {"transform": [*numbers(self.matrix), [0, 0, 0, 1]]}
        return {"shape": "torus", "major": number(self.major), "minor": number(self.minor), **placed}


def torus(major: Given, minor: Given, *, name: str | None = None) -> Torus:
    """The solid torus about z, centred: all points at most `minor` from the circle of radius `major`; minor < major.

    Its face is "surface".
    """
    radii = [rational(x, f"torus {what}") for x, what in ((major, "major"), (minor, "minor"))]
    if not 0 < radii[1] < radii[0]:
        raise InputError(f"torus has major {shown(major)} and minor {shown(minor)}; give 0 < minor < major")
    if radii[1] * LARGEST < 1 or radii[0] >= LARGEST:
        raise InputError(f"torus has major {shown(major)} and minor {shown(minor)}; give numbers from 2^-150 to 2^150")
    return Torus(radii[0], radii[1], name=name)


def quartic(major: N, minor: N, x: N, y: N, z: N) -> N:
    """The form of the torus at a point of its own frame, in numbers of any kind: negative inside."""
    around = x * x + y * y
    value = around + z * z + (major * major - minor * minor)
    return value * value - 4 * major * major * around


def _sides(radius: float, share: float) -> int:
    """Of a polygon that is at most `share` from its circle."""
    angle = math.acos(max(1.0 - share / radius, -1.0)) if share < radius else math.pi / 2
    return max(FEWEST, math.ceil(math.pi / max(angle, 1e-4)))


def _turn(count: int) -> np.ndarray:
    return np.arange(count) * (2.0 * math.pi / count)
