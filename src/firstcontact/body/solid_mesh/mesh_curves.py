"""Points along the edges and seams of a model, each curve sampled once for all faces that meet there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.solid.carriers import QuarticCurve
from firstcontact.body.solid.features import Edge, parameter

if TYPE_CHECKING:
    from firstcontact.body.solid.composite_quadric import CompositeQuadric

# Conics begin with so many steps a turn, degree-4 curves with so many traced points a step.
A_TURN, TRACED = 8, 37


@dataclass(eq=False)
class _CurveRun:
    """One piece of an edge: ascending parameters and the numbers of the points there."""

    edge: Edge
    at: list[float]
    on: list[int]


class Samples:
    """points: all samples; runs between them.  Points that several curves share stand once."""

    def __init__(self, body: CompositeQuadric, chord: float) -> None:
        """chord: how far a curve may be from the chords between its samples."""
        self.points: list[np.ndarray] = [np.array(v.position) for v in body.vertices]
        self._runs: list[_CurveRun] = []
        edges = [*body.edges, *body.seams]
        for edge in edges:
            for piece in edge.pieces:
                if math.isfinite(piece.hi - piece.lo):
                    ends = edge.points([piece.lo, piece.hi])
                    on = [
                        self._number(p) if vertex is None else vertex
                        for p, vertex in zip(ends, (piece.start, piece.end), strict=True)
                    ]
                    self._runs.append(_CurveRun(edge, [piece.lo, piece.hi], on))
        for p in _crossings(edges):
            self._number(p)
        for run in self._runs:
            self._visit(run, body)
        for run in self._runs:
            self._sample(run, chord)
        self._part_twins()

    def segments(self, surface: int) -> list[tuple[int, int]]:
        """The chords of all curves on the surface."""
        runs = [run for run in self._runs if surface in run.edge.surfaces]
        return [pair for run in runs for pair in zip(run.on, run.on[1:], strict=False) if pair[0] != pair[1]]

    def halve(self, segment: tuple[int, int]) -> None:
        """A further point between two that follow each other; on lines nothing changes but their number."""
        for run in self._runs:
            for k in reversed(range(len(run.on) - 1)):
                if {run.on[k], run.on[k + 1]} == set(segment):
                    self._insert(run, k, 2)

    def _number(self, p: np.ndarray) -> int:
        for k, q in enumerate(self.points):
            if np.abs(p - q).max() < 1e-9 * (1 + np.abs(p).max()):
                return k
        self.points.append(p)
        return len(self.points) - 1

    def _visit(self, run: _CurveRun, body: CompositeQuadric) -> None:
        """Points known by now that the run passes become its samples: other curves end or cross there."""
        points = np.array(self.points)
        x = np.column_stack([points, np.ones(len(points))])
        forms = body.forms[list(run.edge.surfaces)]
        value = np.abs(np.einsum("ni,sij,nj->sn", x, forms, x))
        size = np.einsum("ni,sij,nj->sn", np.abs(x), np.abs(forms), np.abs(x))
        lo, hi = run.at
        found = []
        for k in np.flatnonzero(np.all(value <= 1e-9 * size, axis=0)).tolist():
            if k in run.on:
                continue
            t = _parameter(run.edge, points[k], lo, hi)
            off = np.abs(run.edge.points([t])[0] - points[k]).max()
            if lo < t < hi and off < 1e-6 * (1 + np.abs(points[k]).max()):
                found.append((t, k))
        for t, k in sorted(found):
            run.at.insert(-1, t)
            run.on.insert(-1, k)

    def _sample(self, run: _CurveRun, chord: float) -> None:
        step = {2: math.inf, 3: 2 * math.pi / A_TURN}.get(run.edge.frame.shape[1], math.inf)
        if isinstance(run.edge.carrier, QuarticCurve):
            step = TRACED
        for k in reversed(range(len(run.on) - 1)):
            self._insert(run, k, max(1, math.ceil((run.at[k + 1] - run.at[k]) / step - 1e-9)))
        while run.edge.frame.shape != (4, 2):
            sagitta = self._sagittas(run)
            parts = np.minimum(np.ceil(np.sqrt(sagitta / chord)), 64).astype(int)
            if parts.max() <= 1:
                break
            for k in np.flatnonzero(parts > 1)[::-1]:
                self._insert(run, k, int(parts[k]))

    def _insert(self, run: _CurveRun, k: int, parts: int) -> None:
        """Cut step k of the run into equal parts."""
        if parts < 2:
            return
        at = np.linspace(run.at[k], run.at[k + 1], parts + 1)[1:-1]
        first = len(self.points)
        self.points += list(run.edge.points(at))
        run.at[k + 1 : k + 1] = at.tolist()
        run.on[k + 1 : k + 1] = range(first, len(self.points))

    def _sagittas(self, run: _CurveRun) -> np.ndarray:
        """How far the curve is from each of its chords, at three places of each."""
        at, ends = np.array(run.at), np.array([self.points[k] for k in run.on])
        chord = ends[1:] - ends[:-1]
        length = np.linalg.norm(chord, axis=1, keepdims=True)
        along = np.divide(chord, length, out=np.zeros_like(chord), where=length > 0)
        worst = np.zeros(len(chord))
        for share in (0.25, 0.5, 0.75):
            off = run.edge.points(at[:-1] + share * np.diff(at)) - ends[:-1]
            off -= np.sum(off * along, axis=1, keepdims=True) * along
            worst = np.maximum(worst, np.linalg.norm(off, axis=1))
        return worst

    def _part_twins(self) -> None:
        """Two curves between the same two points get different chords."""
        while True:
            seen: set[tuple[int, int]] = set()
            twins = []
            for run in self._runs:
                for a, b in zip(run.on, run.on[1:], strict=False):
                    pair = (min(a, b), max(a, b))
                    twins += [pair] if pair in seen else []
                    seen.add(pair)
            if not twins:
                return
            for pair in twins:
                self.halve(pair)


def _parameter(edge: Edge, p: np.ndarray, lo: float, hi: float) -> float:
    """Of the point of the curve nearest to p, nearly; between lo and hi where a full turn makes no difference."""
    if not isinstance(edge.carrier, QuarticCurve):
        t = parameter(np.append(p, 1.0), edge.frame)
        return t if edge.frame.shape[1] == 2 else lo + (t - lo) % (2 * math.pi)
    traced = edge.frame[int(lo) : int(hi) + 1]
    steps = np.diff(traced, axis=0)
    share = np.clip(np.sum((p - traced[:-1]) * steps, axis=1) / np.sum(steps * steps, axis=1), 0, 1)
    k = int(np.linalg.norm(traced[:-1] + share[:, None] * steps - p, axis=1).argmin())
    return lo + k + float(share[k])


def _crossings(edges: list[Edge]) -> list[np.ndarray]:
    """Where two conics of the same two surfaces cross: the line common to their planes meets both."""
    conics = [e for e in edges if e.frame.shape == (4, 3) and not isinstance(e.carrier, QuarticCurve)]
    found = []
    for k, e in enumerate(conics):
        for other in conics[k + 1 :]:
            if len(set(e.surfaces) & set(other.surfaces)) < 2:
                continue
            plane = np.linalg.svd(other.frame.T)[2][3]
            a, b, c = plane @ e.frame  # a + b cos t + c sin t = 0
            if abs(a) < math.hypot(b, c):
                middle, half = math.atan2(c, b), math.acos(-a / math.hypot(b, c))
                found += list(e.points([middle - half, middle + half]))
    return found
