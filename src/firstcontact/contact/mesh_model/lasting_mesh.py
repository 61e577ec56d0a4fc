"""Points of a polyhedron of any shape that a curved model is proved to hold, at a time or over a stretch of it."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from flint import arb

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.mesh_model.tip_ways import Pierced, TipWays
from firstcontact.exact.numbers import Undecidable, exact_value, precision
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.trees.containment import contains
from firstcontact.search.trees.frame import tree_of
from firstcontact.timeline.lasting import BITS, Lasting, LastingSolid, linear

U = 2.0**-53
DEEP = 64
"""Points deep inside the model that are asked whether the polyhedron holds them."""
TRIANGLES = 16
"""On which a deep point is sought."""
DIRECTIONS, ROUNDS = 24, 24
SCALES = 0.5 ** np.arange(0.0, 54.0, 2.0)
NEARBY = np.array([2.0, 1.0, 0.5, 0.25, 0.125, 0.03, 0.01, 0.003])
"""Sizes of steps within a triangle: of the first one, and of the next ones as parts of the one before."""


class MeshPoint(NamedTuple):
    """A point of the polyhedron, in its frame, each coordinate within `off`."""

    local: np.ndarray
    off: float


class LastingOfMesh(Lasting["MeshPoint | Pierced"]):
    """tips: tells of triangles that tips of the model have passed, if it is there."""

    def __init__(self, mesh: Polyhedron, solid: LastingSolid, mesh_is_a: bool, tips: TipWays | None = None) -> None:
        super().__init__()
        self.mesh, self.solid, self.mesh_is_a, self.tips = mesh, solid, mesh_is_a, tips
        self.tree = tree_of(mesh)
        self.corners = mesh.vertices[self.tree.corners]
        self.off = mesh.error + 32.0 * U * float(np.abs(mesh.vertices).max())
        samples = self.solid.samples()
        heights = self.solid.height(self.solid.own, np.zeros(3), samples)
        best = np.argsort(heights)[:DEEP]
        self.deep = samples[best[heights[best] < 0.0]]
        mixes = np.random.default_rng(0).normal(size=(DIRECTIONS, 3))
        sides = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [1.0, 0.0, -1.0]])
        self.mixes = np.concatenate([mixes - mixes.mean(axis=1, keepdims=True), sides, -sides])  # of weights

    def on(self, triangles: Sequence[int]) -> LastingOfMesh:
        """The same, which looks for points on these triangles alone."""
        other = copy.copy(self)
        other.corners, other.deep = self.corners[list(triangles)], self.deep[:0]
        return other

    def is_held_near(self, window: Window, t: float, seed: np.ndarray, part: float) -> bool:
        """Whether a point that near a seed is proved to be in the model at t; part: of the size of a triangle."""
        own, other = self._motions(window)
        p, q = self.pose(own, t), self.pose(other, t)
        back = np.linalg.inv(linear(p))
        there = self.solid.placed(back @ linear(q), back @ (q[9:12] - p[9:12]))
        foot, x = back @ (seed - p[9:12]), self.corners
        weights = _feet(x, foot)[:, 0]
        sizes = np.ptp(x, axis=1).max(axis=1)
        sizes = np.where(sizes > 0.0, sizes, np.abs(x).max(axis=(1, 2)))  # of a point how far out it is
        away = np.abs(np.einsum("nc,ncd->nd", weights, x) - foot).max(axis=1)
        for k in np.flatnonzero(away <= part * sizes):
            point, height = self._descended(there, x[k], weights[k], SCALES[SCALES <= part])
            close = np.abs(point - foot).max() <= 4.0 * part * sizes[k]
            if height < 0.0 and close and self._stays(window, t, t, MeshPoint(point, self.off)):
                return True
        return False

    # -- the proof ------------------------------------------------------------------------------------------

    def follow(self, window: Window, t: float, end: float, point: MeshPoint | Pierced) -> np.ndarray | None:
        if not self._stays(window, t, end, point):
            return None
        return self.place(window, end, point)

    def place(self, window: Window, t: float, point: MeshPoint | Pierced) -> np.ndarray:
        own, other = self._motions(window)
        if isinstance(point, Pierced):
            assert self.tips is not None
            p, local = self.pose(other, t), self.tips.place(point, self._from_model(window, t))
        else:
            p, local = self.pose(own, t), point.local
        place: np.ndarray = linear(p) @ local + p[9:12]
        return place

    def _from_model(self, window: Window, t: float) -> np.ndarray:
        """The pose (3, 4) of the polyhedron seen from the model, rounded."""
        p, q = (self.pose(m, t) for m in self._motions(window))
        return np.linalg.solve(linear(q), np.column_stack([linear(p), p[9:12] - q[9:12]]))

    def _motions(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        """Of the polyhedron, of the model."""
        return (window.a, window.b) if self.mesh_is_a else (window.b, window.a)

    def _stays(self, window: Window, t: float, end: float, point: MeshPoint | Pierced) -> bool:
        """Whether the model is proved to hold the point over [t, end]."""
        if isinstance(point, Pierced):
            return self.tips is not None and self.tips.stays(window, t, end, point)
        own, other = self._motions(window)
        q = self.pose(other, t)
        y = np.linalg.solve(linear(q), self.place(window, t, point) - q[9:12])
        with precision(BITS):
            x = [arb(c, point.off) for c in point.local.tolist()]
            return self.solid.holds([arb(c) for c in y.tolist()], self.drift(own, other, t, end, x, y))

    # -- points ---------------------------------------------------------------------------------------------

    def anywhere(self, window: Window, t: float) -> np.ndarray | None:
        return self.deepest(window, t, [])

    def held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> MeshPoint | Pierced | None:
        return next(self.each_held(window, t, seeds), None)

    def each_held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> Iterator[MeshPoint | Pierced]:
        if self.tips is not None:
            yield from self.tips.found(window, t, self._from_model(window, t))
        deep = self._deep(window, t, seeds)
        if deep is not None:
            yield deep

    def _deep(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> MeshPoint | None:
        own, other = self._motions(window)
        p, q = self.pose(own, t), self.pose(other, t)
        back = np.linalg.inv(linear(p))
        turn, shift = back @ linear(q), back @ (q[9:12] - p[9:12])
        there = self.solid.placed(turn, shift)
        deep = self.deep @ turn.T + shift
        inner = self._inside(deep)
        outer, height = self._on_surface(there, [*(back @ (seed - p[9:12]) for seed in seeds), *deep[:4]])
        candidates = [] if height >= 0.0 else [(height, outer)]
        if inner is not None:
            candidates.append((float(self.solid.height(there, inner.local, np.zeros((1, 3)))[0]), inner))
        for _, point in sorted(candidates, key=lambda x: x[0]):
            if self._stays(window, t, t, point):
                return point
        return None

    def _inside(self, deep: np.ndarray) -> MeshPoint | None:
        """The first of the points (n, 3) that the solid polyhedron holds."""
        if not self.mesh.solid:
            return None
        box = self.tree.boxes[0]
        for x in deep[np.all((deep > box[:3]) & (deep < box[3:]), axis=1)]:
            a, b, c = (exact_value(v) for v in x.tolist())
            try:
                if contains(self.mesh, self.tree, (a, b, c)):
                    return MeshPoint(x, 0.0)
            except Undecidable:
                continue
        return None

    def _on_surface(self, there: np.ndarray, seeds: list[np.ndarray]) -> tuple[MeshPoint, float]:
        """(about the deepest point of the surface, its height): the best corners, middles and feet of seeds, moved."""
        x = self.corners
        weights = np.concatenate([np.eye(3), np.full((1, 3), 1.0 / 3.0)])
        starts = np.concatenate([np.broadcast_to(weights, (len(x), 4, 3)), *(_feet(x, seed) for seed in seeds)], axis=1)
        at = np.einsum("nkc,ncd->nkd", starts, x)
        heights = self.solid.height(there, np.zeros(3), at.reshape(-1, 3)).reshape(at.shape[:2])
        best = np.argsort(heights.min(axis=1))[:TRIANGLES]
        chosen = starts[best, heights[best].argmin(axis=1)]
        found = [self._descended(there, x[k], w) for k, w in zip(best, chosen, strict=True)]
        (point, height) = min(found, key=lambda f: f[1])
        return MeshPoint(point, self.off), height

    def _descended(
        self, there: np.ndarray, corners: np.ndarray, weight: np.ndarray, scales: np.ndarray = SCALES
    ) -> tuple[np.ndarray, float]:
        """The point of the triangle with these weights moved downhill within it, by tries of these sizes around it."""
        height = float(self.solid.height(there, weight @ corners, np.zeros((1, 3)))[0])
        for _ in range(ROUNDS):
            tries = np.maximum(weight + (scales[:, None, None] * self.mixes).reshape(-1, 3), 0.0)
            tries /= tries.sum(axis=1, keepdims=True)
            heights = self.solid.height(there, weight @ corners, (tries - weight) @ corners)
            best = int(np.argmin(heights))
            if heights[best] >= height:
                break
            gain, moved = height - float(heights[best]), np.abs(tries[best] - weight).max()
            weight, height = tries[best], float(heights[best])
            if gain < 1e-3 * abs(height):
                break
            scales = moved * NEARBY
        return weight @ corners, height


def _feet(x: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(n, 1, 3) weights of the feet of a point on the planes of triangles (n, 3, 3), moved into the triangles; on the
    lines of those without area."""
    u, v, w = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], point - x[:, 0]
    uu, uv, vv = (np.einsum("nd,nd->n", *pair) for pair in ((u, u), (u, v), (v, v)))
    uw, vw = np.einsum("nd,nd->n", u, w), np.einsum("nd,nd->n", v, w)
    det = uu * vv - uv * uv
    flat, det = det <= 1e-24 * uu * vv, np.maximum(det, 1e-300)
    along_u, along_v = uw / np.maximum(uu, 1e-300), vw / np.maximum(vv, 1e-300)
    s = np.where(flat, np.where(uu >= vv, along_u, 0.0), (vv * uw - uv * vw) / det)
    t = np.where(flat, np.where(uu >= vv, 0.0, along_v), (uu * vw - uv * uw) / det)
    weights = np.clip(np.column_stack([1.0 - s - t, s, t]), 0.0, None)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total > 0.0, weights / np.maximum(total, 1e-300), 1.0 / 3.0)[:, None, :]
