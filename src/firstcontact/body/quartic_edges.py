"""Edges of degree 4: common curves of two quadrics that no rational planes hold.

The curves are traced in doubles (seeds from a grid, tangent steps, Newton's method back onto both quadrics); what an
arc is, is decided at one of its points, taken to 400 bits; its ends are proved by Krawczyk's test.  A piece that
starts and ends within one step (a 300th of the box) can be missed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat

from firstcontact.body.carriers import EnclosedPoint, Quadric, QuarticCurve, Surface, cross, doubles
from firstcontact.body.csg import Tree, outcomes
from firstcontact.body.extent import cells_of
from firstcontact.body.features import EDGE_KINDS, Piece
from firstcontact.body.neighbourhood import Profile, around_curve
from firstcontact.body.trimming import BITS
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import dyadic, precision

BoxF = tuple[np.ndarray, np.ndarray]
"""Corners, (3,) float64 each."""

GRID = 24
STEPS = 300


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Consecutive traced points between crossings; start, end: corners, None on closed curves."""

    points: np.ndarray
    profile: Profile
    start: Any
    end: Any


@dataclass(frozen=True, eq=False)
class QuarticEdge:
    """One quartic curve's edges, before vertices are numbered."""

    carrier: QuarticCurve
    surfaces: tuple[int, ...]
    stretches: tuple[_Stretch, ...]

    def finished(self, names: Any, numbers: dict[tuple[int, int], int]) -> list[dict[str, Any]]:
        """Keyword arguments of Edge, one for each convexity that occurs."""
        found = []
        for kind in EDGE_KINDS:
            own = [s for s in self.stretches if s.profile.kind == kind]
            if not own:
                continue
            frame = np.concatenate([s.points for s in own])
            last = np.cumsum([len(s.points) for s in own])
            pieces = tuple(
                Piece(float(end - len(s.points)), float(end - 1), _number(s.start), _number(s.end))
                for s, end in zip(own, last, strict=True)
            )
            sides = sorted({numbers[side] for s in own for side in s.profile.faces})
            name = names.edge_name(self.surfaces, kind)
            found.append(
                dict(
                    name=name,
                    carrier=self.carrier,
                    surfaces=self.surfaces,
                    convexity=kind,
                    pieces=pieces,
                    faces=tuple(sides),
                    frame=frame,
                )
            )
        return found


def _number(corner: Any) -> int | None:
    return None if corner is None or corner.index < 0 else corner.index


def trace_quartics(
    tree: Tree, surfaces: Sequence[Surface], pairs: Sequence[tuple[int, int]], corners: Any, box: BoxF | None
) -> tuple[list[QuarticEdge], set[tuple[int, int]]]:
    """All degree-4 edges inside the box, and the sides of surfaces that they bound."""
    edges: list[QuarticEdge] = []
    sides: set[tuple[int, int]] = set()
    done: set[frozenset[int]] = set()
    for i, j in pairs:
        on = tuple(k for k in range(len(surfaces)) if _in_pencil(surfaces[i], surfaces[j], surfaces[k]))
        if frozenset(on) in done:
            continue
        done.add(frozenset(on))
        if box is None:
            raise UnsupportedPair(
                f"surfaces {i} and {j} meet in a curve of degree 4, and no bound of the solid is known; "
                "intersect it with a box"
            )
        first, second = surfaces[i], surfaces[j]
        assert isinstance(first, Quadric) and isinstance(second, Quadric)
        stretches: list[_Stretch] = []
        for polyline, closed in _polylines(first, second, box):
            stretches += _stretches(tree, surfaces, on, polyline, closed, corners)
        sides |= {side for s in stretches for side in s.profile.faces}
        edges.append(QuarticEdge(QuarticCurve(first, second), on, tuple(stretches)))
    return edges, sides


def _in_pencil(first: Surface, second: Surface, other: Surface) -> bool:
    """Whether the third form is a combination of the first two: then it holds their common curve."""
    if not isinstance(other, Quadric):
        return False
    flat = [[x for row in s.form for x in row] for s in (first, second, other) if isinstance(s, Quadric)]
    return bool(fmpq_mat(flat).rank() == 2)


# -- tracing ------------------------------------------------------------------------------------------------


class PairF:
    """Both forms in doubles."""

    def __init__(self, first: Quadric, second: Quadric) -> None:
        forms = [np.array(doubles(s.form)) for s in (first, second)]
        self.forms = np.array([f / np.linalg.norm(f) for f in forms])

    def pulled(self, p: np.ndarray, steps: int = 6) -> np.ndarray:
        """(n, 3) points taken onto the curve by Newton steps of least length."""
        for _ in range(steps):
            value, slope = self.value(p), self.gradients(p)
            gram = np.einsum("nik,njk->nij", slope, slope)
            gram += 1e-14 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(2)
            p = p - np.einsum("nik,ni->nk", slope, np.linalg.solve(gram, value[..., None])[..., 0])
        return p

    def value(self, p: np.ndarray) -> np.ndarray:
        x = np.column_stack([p, np.ones(len(p))])
        return np.einsum("ni,sij,nj->ns", x, self.forms, x)

    def gradients(self, p: np.ndarray) -> np.ndarray:
        """(n, 2, 3)."""
        x = np.column_stack([p, np.ones(len(p))])
        return 2 * np.einsum("sij,nj->nsi", self.forms, x)[..., :3]


def _polylines(first: Quadric, second: Quadric, box: BoxF) -> list[tuple[np.ndarray, bool]]:
    """(points (n, 3), closed) of every branch inside the box, neighbours at most one step apart."""
    lo, hi = box
    pad = 0.01 * (hi - lo).max()
    lo, hi = lo - pad, hi + pad
    step = float(np.linalg.norm(hi - lo)) / STEPS
    pair = PairF(first, second)
    seeds = _seeds(pair, lo, hi)
    found: list[tuple[np.ndarray, bool]] = []
    while len(seeds):
        points, closed = _traced(pair, seeds[0], step, lo, hi)
        found.append((points, closed))
        near = np.zeros(len(seeds), bool)
        for chunk in np.array_split(points, max(1, len(points) // 200)):
            near |= np.linalg.norm(seeds[:, None] - chunk[None], axis=2).min(axis=1) < 0.75 * step
        near[0] = True
        seeds = seeds[~near]
    return [(points, closed) for points, closed in found if len(points) > 2]


def _seeds(pair: PairF, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Points of the curve near the centres of all cells that it may pass through."""
    centre, half = cells_of(lo, hi, GRID)
    x = np.column_stack([centre, np.ones(len(centre))])
    keep = np.ones(len(x), bool)
    h = np.array([*half, 0.0])
    for form in pair.forms:
        image = x @ form
        keep &= np.abs(np.sum(image * x, axis=1)) <= 2 * np.abs(image) @ h + h @ np.abs(form) @ h + 1e-12
    p = pair.pulled(centre[keep], 12)
    good = np.abs(pair.value(p)).max(axis=1, initial=0) < 1e-10 * (1 + np.abs(p).max(axis=1, initial=0) ** 2)
    good &= np.all((p >= lo) & (p <= hi), axis=1)
    good &= np.linalg.norm(p - centre[keep], axis=1) < 4 * np.linalg.norm(half)
    return p[good]


def _traced(pair: PairF, seed: np.ndarray, step: float, lo: np.ndarray, hi: np.ndarray) -> tuple[np.ndarray, bool]:
    """Both ways from the seed, until the box is left or the start is met again."""
    ahead, closed = _one_way(pair, seed, step, lo, hi, 1.0)
    if closed:
        return np.array(ahead), True
    back, _ = _one_way(pair, seed, step, lo, hi, -1.0)
    return np.array(back[:0:-1] + ahead), False


def _one_way(
    pair: PairF, seed: np.ndarray, step: float, lo: np.ndarray, hi: np.ndarray, way: float
) -> tuple[list[np.ndarray], bool]:
    points, direction = [seed], None
    for count in range(40 * STEPS):
        p = points[-1]
        a, b = pair.gradients(p[None])[0]
        tangent = np.array(cross(a, b))
        length = np.linalg.norm(tangent)
        if length < 1e-6 * np.linalg.norm(a) * np.linalg.norm(b):  # a crossing of branches: straight on
            if direction is None:
                return points, False
            tangent = direction
        elif direction is None:
            tangent = way * tangent / length
        else:
            tangent = math.copysign(1.0, tangent @ direction) * tangent / length
        new = pair.pulled((p + step * tangent)[None], 4)[0]
        direction = tangent
        if not np.all((new >= lo) & (new <= hi)) or np.linalg.norm(new - p) > 2 * step:
            return points, False
        if count > 2 and np.linalg.norm(new - seed) < 0.8 * step and tangent @ (points[1] - seed) > 0:
            return points, True
        points.append(new)
    return points, False


# -- stretches between crossings ----------------------------------------------------------------------------


def _stretches(
    tree: Tree, surfaces: Sequence[Surface], on: tuple[int, ...], points: np.ndarray, closed: bool, corners: Any
) -> list[_Stretch]:
    """The polyline cut where other surfaces cross it; only stretches that bound the solid."""
    x = np.column_stack([points, np.ones(len(points))])
    rest = [k for k in range(len(surfaces)) if k not in on]
    values = {k: np.einsum("ni,ij,nj->n", x, np.array(doubles(surfaces[k].matrix())), x) for k in rest}
    positive = np.array([values[k] > 0 for k in rest]).reshape(len(rest), len(points))
    changes = np.any(positive[:, 1:] != positive[:, :-1], axis=0)
    n = len(points)
    cuts = [int(k) + 1 for k in np.flatnonzero(changes)]
    if closed and cuts:
        points, positive = np.roll(points, -cuts[0], axis=0), np.roll(positive, -cuts[0], axis=1)
        cuts = [c - cuts[0] for c in cuts[1:]]
        wraps = bool(np.any(positive[:, 0] != positive[:, -1]))
    else:
        wraps = False
    bounds = [0, *cuts, n]
    parts = list(zip(bounds[:-1], bounds[1:], strict=True))
    middles = [(a + b) // 2 for a, b in parts]
    profiles = [_profile_at(tree, surfaces, on, rest, points[m], positive[:, m]) for m in middles]
    if closed and len(parts) == 1 and not wraps:
        whole = np.concatenate([points, points[:1]])
        return [_Stretch(whole, profiles[0], None, None)] if profiles[0].kind in EDGE_KINDS else []
    ends = _Ends(surfaces, on, rest, points, positive, corners)
    kinds = [p.kind if p.kind in EDGE_KINDS else None for p in profiles]
    found = []
    for k, (a, b) in enumerate(parts):
        if kinds[k] is None:
            continue
        inner = closed or (k > 0)
        start = ends.corner((a - 1) % n, a) if inner else None
        end = ends.corner(b - 1, b % n) if closed or k < len(parts) - 1 else None
        for corner, other in ((start, kinds[k - 1] if inner else None), (end, kinds[(k + 1) % len(kinds)])):
            if corner is not None:
                corner.ends |= other != kinds[k]
        run = [points[a:b]]
        if start is not None:
            run.insert(0, np.array([start.position]))
        if end is not None:
            run.append(np.array([end.position]))
        found.append(_Stretch(np.concatenate(run), profiles[k], start, end))
    return found


def _profile_at(
    tree: Tree, surfaces: Sequence[Surface], on: tuple[int, ...], rest: list[int], p: np.ndarray, positive: np.ndarray
) -> Profile:
    signs = [0] * len(surfaces)
    for k, above in zip(rest, positive, strict=True):
        signs[k] = 1 if above else -1
    values = outcomes(tree, signs)
    if len(values) == 1:
        return Profile("inside" if True in values else "outside", frozenset())
    with precision(BITS):
        first, second = surfaces[on[0]], surfaces[on[1]]
        point = [arb(float(c)) for c in p]
        for _ in range(8):
            point = _newton_least(first, second, point)
        a, b = (s.gradient([*point, arb(1)]) for s in (first, second))
        return around_curve(tree, surfaces, signs, [*point, arb(1)], [*cross(a, b), arb(0)])


def _newton_least(first: Surface, second: Surface, p: list[arb]) -> list[arb]:
    """One Newton step of least length onto both surfaces, midpoints only."""
    a, b = (s.gradient([*p, arb(1)]) for s in (first, second))
    f, g = (s.value([*p, arb(1)]) for s in (first, second))
    aa, ab, bb = (sum(x * y for x, y in zip(u, v, strict=True)) for u, v in ((a, a), (a, b), (b, b)))
    det = aa * bb - ab * ab
    s, t = (bb * f - ab * g) / det, (aa * g - ab * f) / det
    return [arb((x - s * u - t * v).mid()) for x, u, v in zip(p, a, b, strict=True)]


class _Ends:
    """Corners where the polyline passes from one side of a surface to the other."""

    def __init__(
        self,
        surfaces: Sequence[Surface],
        on: tuple[int, ...],
        rest: list[int],
        points: np.ndarray,
        positive: np.ndarray,
        corners: Any,
    ) -> None:
        self.surfaces, self.on, self.rest, self.points = surfaces, on, rest, points
        self.positive, self.corners = positive, corners

    def corner(self, before: int, after: int) -> Any:
        changed = [k for k, row in zip(self.rest, self.positive, strict=True) if row[before] != row[after]]
        start = (self.points[before] + self.points[after]) / 2
        system = (self.surfaces[self.on[0]], self.surfaces[self.on[1]], self.surfaces[changed[0]])
        point = enclosed(system, start)
        here = frozenset(self.on) | {k for k in self.rest if self._vanishes(k, point)}
        return self.corners.merged(here, point)

    def _vanishes(self, k: int, point: EnclosedPoint) -> bool:
        with precision(BITS):
            x = [arb(c, point.radius) for c in point.centre[:3]]
            value = self.surfaces[k].value([*x, arb(1)])
            return not (value > 0 or value < 0)


def enclosed(system: Sequence[Surface], start: np.ndarray) -> EnclosedPoint:
    """The common point of three surfaces near `start`, by Newton's method at 400 bits and Krawczyk's test."""
    with precision(BITS):
        p = [arb(float(c)) for c in start]
        step = [arb(1)] * 3
        for _ in range(60):
            value = arb_mat([[s.value([*p, arb(1)])] for s in system])
            try:
                step = [row[0] for row in _jacobian(system, p).solve(value).tolist()]
            except ZeroDivisionError:
                break
            p = [arb((x - d).mid()) for x, d in zip(p, step, strict=True)]
            if max(float(abs(d).upper()) for d in step) < 2.0 ** (-BITS // 2):
                break
        radius = max(dyadic(arb(abs(d).upper())) for d in step) + fmpq(1, 2 ** (BITS // 2))
        return EnclosedPoint(tuple(dyadic(x) for x in p), radius, _krawczyk(system, p, radius))


def _jacobian(system: Sequence[Surface], p: list[arb]) -> arb_mat:
    return arb_mat([list(s.gradient([*p, arb(1)])) for s in system])


def _krawczyk(system: Sequence[Surface], p: list[arb], radius: fmpq) -> bool:
    """Whether p - Y f(p) + (1 - Y J(X)) (X - p) lies inside X, the box of that half-width about p."""
    try:
        y = _jacobian(system, p).inv()
    except ZeroDivisionError:
        return False
    offset = arb_mat([[arb(0, radius)] for _ in p])
    box = [x + d for (d,), x in zip(offset.tolist(), p, strict=True)]
    value = arb_mat([[s.value([*x, arb(1)])] for s in system for x in (p,)])
    rest = arb_mat(3, 3, [int(i == j) for i in range(3) for j in range(3)]) - y * _jacobian(system, box)
    image = rest * offset - y * value
    return all(arb(0, radius).contains_interior(row[0]) for row in image.tolist())
