"""Bodies as cells: rows of numbers, each of which stands for the convex hull of few points.

Cells cover a body's surface, those of a torus all of it where that is wanted, in the body's own frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.torus.torus import Torus
from firstcontact.search.trees.frame import tree_of

SAMPLES = 16
"""Points along either circle of a torus."""
HALVINGS = 64
"""Of a side of a triangle; each rounds its middle."""
TURN = 2.0 * math.pi
PARTS = 8
"""Of either circle of a torus at first."""


class Cells:
    flat = False
    """Whether a cell lies in the plane of its first three points."""
    pose = np.eye(4)
    """From the frame in which points are told to the body's."""
    off = 0.0
    """Error of points."""
    reach: float | None = None
    """How far from the origin of its frame the body is at most; None where `support` is not known."""

    def support(self, across: np.ndarray) -> np.ndarray:
        """(n,) the most that x . n is for any point x of the body, for n of across (n, 3)."""
        raise NotImplementedError

    def all(self) -> np.ndarray:
        """(n, m) the cells that cover the body."""
        raise NotImplementedError

    def points(self, cells: np.ndarray) -> np.ndarray:
        """(n, k, 3) points whose hulls hold the cells."""
        raise NotImplementedError

    def away(self, cells: np.ndarray) -> np.ndarray:
        """(n,) about how far points of the hulls are from the cells."""
        return np.zeros(len(cells))

    def halves(self, cells: np.ndarray) -> np.ndarray:
        """(2 n, m) both halves of each, across its longest direction."""
        raise NotImplementedError

    def samples(self) -> np.ndarray:
        """(n, 3) points of the surface."""
        raise NotImplementedError

    def seeds(self, cells: np.ndarray, pose: np.ndarray) -> list[np.ndarray]:
        """A point near each of the cells as contact is followed at it; pose: from their frame to the world."""
        return list(self.points(cells).mean(axis=1) @ pose[:3, :3].T + pose[:3, 3])


class Triangles(Cells):
    """Those of a polyhedron, and its bare edges and points as triangles without area."""

    flat = True

    def __init__(self, mesh: Polyhedron) -> None:
        self.mesh = mesh
        self.off = mesh.error + HALVINGS * 2.0**-53 * float(np.abs(mesh.vertices).max())

    def samples(self) -> np.ndarray:
        return self.all().reshape(-1, 3)

    def all(self) -> np.ndarray:
        corners: np.ndarray = self.mesh.vertices[tree_of(self.mesh).corners].reshape(-1, 9)
        return corners

    def points(self, cells: np.ndarray) -> np.ndarray:
        return cells.reshape(-1, 3, 3)

    def halves(self, cells: np.ndarray) -> np.ndarray:
        x, rows = self.points(cells), np.arange(len(cells))
        sides = ((x - np.roll(x, -1, axis=1)) ** 2).sum(axis=2)
        i = sides.argmax(axis=1)
        j = (i + 1) % 3
        middle = 0.5 * (x[rows, i] + x[rows, j])
        one, other = x.copy(), x.copy()
        one[rows, j], other[rows, i] = middle, middle
        return np.concatenate([one, other]).reshape(-1, 9)


class Wedges(Cells):
    """Of a torus: rows of two angles along its circle, two around that, and two parts of `minor` from it.

    skin: its surface alone.  half_plane: of one half-plane about its axis alone.
    """

    flat = False

    def __init__(self, torus: Torus, skin: bool, half_plane: bool = False) -> None:
        (self.major, self.minor), self.shares, self.angles = torus.radii, torus.shares, torus.angles
        self.skin, self.half_plane = skin, half_plane
        self.reach, self.pose = self.major + self.shares[1] * self.minor, square(torus.pose)
        self.width = self.major if torus.is_whole else self.reach

    def support(self, across: np.ndarray) -> np.ndarray:
        return support(self.major, self.shares[1] * self.minor, across)

    def samples(self) -> np.ndarray:
        parts = [first + (last - first) * np.arange(SAMPLES) / SAMPLES for first, last in self.angles]
        u, v = (x.ravel() for x in np.meshgrid(*parts))
        rho = self.major + self.minor * np.cos(v)
        return np.column_stack([rho * np.cos(u), rho * np.sin(u), self.minor * np.sin(v)])

    def all(self) -> np.ndarray:
        ranges = [*(_parts(*ends) for ends in self.angles), np.array([self.shares])]
        if self.half_plane:
            ranges[0] = np.zeros((1, 2))
        return np.concatenate([_rows(sides) for sides in (self._skin(ranges) if self.skin else [ranges])])

    def _skin(self, ranges: list[np.ndarray]) -> Iterator[list[np.ndarray]]:
        """Where one of the three goes no farther."""
        yield [*ranges[:2], np.array([[s, s] for s in self.shares if s > 0.0])]
        for k, (first, last) in enumerate(self.angles):
            if last - first < TURN and not (self.half_plane and k == 0):
                yield [*ranges[:k], np.array([[first, first], [last, last]]), *ranges[k + 1 :]]

    def points(self, cells: np.ndarray) -> np.ndarray:
        """An arc lies in the hull of its ends and of where the tangents there meet."""
        u0, u1, v0, v1, near, far = cells.T
        v, b = 0.5 * (v0 + v1), 0.5 * (v1 - v0)
        angles = np.stack([v0, v1, v, v0, v1], axis=1)
        away = self.minor * np.stack([far, far, far / np.cos(b), near, near], axis=1)
        rho, z = self.major + away * np.cos(angles), away * np.sin(angles)
        u, a = 0.5 * (u0 + u1), 0.5 * (u1 - u0)
        turns, out = np.stack([u0, u1, u], axis=1), np.column_stack([0 * a + 1.0, 0 * a + 1.0, 1.0 / np.cos(a)])
        x, y = out * np.cos(turns), out * np.sin(turns)
        if self.half_plane:
            x, y = x[:, :1], y[:, :1]
        found = np.stack(
            [rho[:, :, None] * x[:, None], rho[:, :, None] * y[:, None], np.repeat(z[:, :, None], x.shape[1], axis=2)],
            axis=3,
        )
        return found.reshape(len(cells), -1, 3)

    def away(self, cells: np.ndarray) -> np.ndarray:
        u0, u1, v0, v1, _, far = cells.T
        sags = (1.0 / np.cos(0.5 * (end - start)) - 1.0 for start, end in ((u0, u1), (v0, v1)))
        along, around = sags
        found: np.ndarray = 2.0 * (along * (self.major + self.minor) + around * far * self.minor)
        return found

    def halves(self, cells: np.ndarray) -> np.ndarray:
        u0, u1, v0, v1, near, far = cells.T
        lengths = np.stack([(u1 - u0) * self.width, (v1 - v0) * self.minor * far, (far - near) * self.minor], axis=1)
        k, rows = 2 * lengths.argmax(axis=1), np.arange(len(cells))
        one, other = cells.copy(), cells.copy()
        one[rows, k + 1] = other[rows, k] = 0.5 * (cells[rows, k] + cells[rows, k + 1])
        return np.concatenate([one, other])


def _parts(first: float, last: float) -> np.ndarray:
    """(n, 2) from one angle to another one, no part larger than those of a turn."""
    ends = np.linspace(first, last, max(1, math.ceil(PARTS * (last - first) / TURN - 1e-9)) + 1)
    return np.column_stack([ends[:-1], ends[1:]])


def _rows(ranges: list[np.ndarray]) -> np.ndarray:
    """(n, 2 k) all combinations of ranges (n_i, 2)."""
    return np.array([np.concatenate(x) for x in product(*ranges)])


def square(rows: np.ndarray) -> np.ndarray:
    """(4, 4) of the first three rows."""
    return np.vstack([rows, [0.0, 0.0, 0.0, 1.0]])


def support(major: float, minor: float, across: np.ndarray) -> np.ndarray:
    """(n,) the most that x . n is for any point x of a torus, for n of across (n, 3)."""
    found: np.ndarray = major * np.hypot(across[:, 0], across[:, 1]) + minor * np.linalg.norm(across, axis=1)
    return found
