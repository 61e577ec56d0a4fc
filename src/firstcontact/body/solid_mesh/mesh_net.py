"""Triangulations of the sphere of rays with given points and segments (Sloan 1993: segments by flips).

Directed sides of triangles point to the third corner; all triangles turn left.  Nothing is smoothed here: triangles
only have to be right, `quadric_mesh` makes them good.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import combinations

import numpy as np

# Turns (determinants of unit vectors) smaller than this are straight: some ten times their rounding.
STRAIGHT = 4e-15

Side = tuple[int, int]


class Crossing(Exception):
    """Segments, pairs of corner numbers, that run through another point or each other."""

    def __init__(self, *segments: Side) -> None:
        super().__init__(segments)
        self.segments = segments


class SphereNet:
    """A triangulation of the whole sphere, first the convex hull of a few rays about the origin."""

    def __init__(self, base: np.ndarray) -> None:
        rays = base / np.linalg.norm(base, axis=1, keepdims=True)
        self.rays: list[tuple[float, float, float]] = [tuple(r) for r in rays.tolist()]
        self.third: dict[Side, int] = {}
        self.around: dict[int, int] = {}
        """A neighbour of every corner."""
        self.fixed: set[Side] = set()
        for a, b, c in combinations(range(len(rays)), 3):
            normal = np.cross(rays[b] - rays[a], rays[c] - rays[a])
            heights = np.delete((rays - rays[a]) @ normal, [a, b, c])
            if np.all(heights < 0):
                self._add(a, b, c)
            elif np.all(heights > 0):
                self._add(a, c, b)

    def turn(self, a: int, b: int, c: int) -> float:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.rays[a], self.rays[b], self.rays[c]
        return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)

    def triangles(self) -> np.ndarray:
        """(n, 3) corners."""
        return np.array([(a, b, c) for (a, b), c in self.third.items() if a < b and a < c])

    def _add(self, a: int, b: int, c: int) -> None:
        self.third[a, b], self.third[b, c], self.third[c, a] = c, a, b
        self.around[a], self.around[b], self.around[c] = b, c, a

    def _drop(self, a: int, b: int, c: int) -> None:
        del self.third[a, b], self.third[b, c], self.third[c, a]

    # -- points ---------------------------------------------------------------------------------------------

    def insert(self, ray: np.ndarray, near: int) -> int:
        """The number of a new corner; near: a corner from where to look for it."""
        p = len(self.rays)
        x, y, z = (ray / np.linalg.norm(ray)).tolist()
        self.rays.append((x, y, z))
        a, b, c = self._triangle_with(p, near)
        for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
            if self.turn(u, v, p) <= STRAIGHT:
                return self._split(u, v, w, p)
        self._drop(a, b, c)
        for u, v in ((a, b), (b, c), (c, a)):
            self._add(u, v, p)
        return p

    def _split(self, a: int, b: int, c: int, p: int) -> int:
        """Corner p on the side a b of triangle a b c."""
        d = self.third[b, a]
        self._drop(a, b, c)
        self._drop(b, a, d)
        for u, v in ((b, c), (c, a), (a, d), (d, b)):
            self._add(u, v, p)
        return p

    def _triangle_with(self, p: int, near: int) -> tuple[int, int, int]:
        """Walk towards p, across the side that p is farthest behind; if that runs in circles, look everywhere."""
        a, b = near, self.around[near]
        for _ in range(2 * len(self.rays) + 100):
            c = self.third[a, b]
            depth, u, v = min((self.turn(u, v, p), u, v) for u, v in ((a, b), (b, c), (c, a)))
            if depth >= -STRAIGHT:
                return a, b, c
            a, b = v, u
        depths = ((min(self.turn(a, b, p), self.turn(b, c, p), self.turn(c, a, p)), (a, b, c))
                  for (a, b), c in self.third.items())  # fmt: skip
        return max(depths)[1]

    # -- segments -------------------------------------------------------------------------------------------

    def fix(self, a: int, b: int) -> None:
        """Make a b a side and keep it; raises Crossing where that cannot be."""
        if (a, b) not in self.third:
            self._free(a, b, self._crossed(a, b))
        self.fixed |= {(a, b), (b, a)}

    def _crossed(self, a: int, b: int) -> list[Side]:
        """The sides that the segment crosses, first corner on its right."""
        x, y = self._leaving(a, b)
        found = []
        while True:
            if (x, y) in self.fixed:
                raise Crossing((a, b), (x, y))
            found.append((x, y))
            w = self.third[y, x]
            if w == b:
                return found
            turn = self.turn(a, b, w)
            if abs(turn) <= STRAIGHT or len(found) > len(self.third):
                raise Crossing((a, b))
            x, y = (x, w) if turn > 0 else (w, y)

    def _leaving(self, a: int, b: int) -> Side:
        """The side, opposite a, through which the segment leaves a."""
        first = x = self.around[a]
        while True:
            y = self.third[a, x]
            if self.turn(a, x, b) > STRAIGHT and self.turn(a, y, b) < -STRAIGHT:
                return x, y
            x = y
            if x == first:
                raise Crossing((a, b))

    def _free(self, a: int, b: int, crossed: list[Side]) -> None:
        """Flip the sides until none crosses the segment."""
        queue = deque(crossed)
        for _ in range(len(crossed) ** 2 + 100):
            if not queue:
                break
            x, y = queue.popleft()
            c, d = self.third[x, y], self.third[y, x]
            if min(self.turn(x, d, c), self.turn(d, y, c)) <= STRAIGHT:
                queue.append((x, y))
                continue
            self._drop(x, y, c)
            self._drop(y, x, d)
            self._add(x, d, c)
            self._add(d, y, c)
            if {c, d} & {a, b}:
                continue
            if math.copysign(1, self.turn(a, b, c)) != math.copysign(1, self.turn(a, b, d)):
                queue.append((c, d))
        if (a, b) not in self.third:
            raise Crossing((a, b))
