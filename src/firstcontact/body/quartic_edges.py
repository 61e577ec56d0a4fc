"""Edges of degree 4: common curves of two quadrics that no rational planes hold.

The curves are traced in doubles (seeds from a grid, tangent steps, Newton's method back onto both quadrics); what an
arc is, is decided at one of its points, taken to 400 bits; its ends are proved by Krawczyk's test.

Not proved here: that every branch has a seed (grid cells that may hold the curve are tried at their centres), that no
step jumps to another branch, and that a surface crossed twice within one step (a 300th of the box) is seen.
`composite.traced_edges` proves that no piece farther than two steps from the traced ones is missing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat

from firstcontact.body.carriers import EnclosedPoint, Quadric, QuarticCurve, Surface, doubles
from firstcontact.body.csg import Tree, outcomes
from firstcontact.body.extent import cells_of
from firstcontact.body.features import EDGE_KINDS, Piece
from firstcontact.body.neighbourhood import Profile, around_curve
from firstcontact.body.trimming import BITS
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import dyadic, precision, to_double
from firstcontact.exact.vectors import cross

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

    def finished(self, numbers: dict[tuple[int, int], int]) -> list[dict[str, Any]]:
        """Keyword arguments of Edge but index and name, one for each convexity that occurs."""
        found = []
        for kind in EDGE_KINDS:
            own = _joined([s for s in self.stretches if s.profile.kind == kind])
            if not own:
                continue
            frame = np.concatenate([s.points for s in own])
            last = np.cumsum([len(s.points) for s in own])
            pieces = tuple(
                Piece(float(end - len(s.points)), float(end - 1), _number(s.start), _number(s.end))
                for s, end in zip(own, last, strict=True)
            )
            sides = sorted({numbers[side] for s in own for side in s.profile.faces})
            found.append(
                dict(
                    carrier=self.carrier,
                    surfaces=self.surfaces,
                    convexity=kind,
                    pieces=pieces,
                    faces=tuple(sides),
                    frame=frame,
                )
            )
        return found


def _joined(stretches: list[_Stretch]) -> list[_Stretch]:
    """Stretches that follow each other made one where no vertex parts them."""
    joined: list[_Stretch] = []
    for stretch in stretches:
        last = joined[-1] if joined else None
        if last is not None and _follows(last, stretch):
            points = np.concatenate([last.points, stretch.points[1:]])
            joined[-1] = _Stretch(points, last.profile, last.start, stretch.end)
        else:
            joined.append(stretch)
    return joined


def _follows(first: _Stretch, second: _Stretch) -> bool:
    corner = first.end
    same = corner is not None and corner is second.start and first.profile.faces == second.profile.faces
    return same and not corner.is_vertex


def _number(corner: Any) -> int | None:
    return None if corner is None or corner.index < 0 else corner.index


def trace_quartics(
    tree: Tree, surfaces: Sequence[Surface], pairs: Sequence[tuple[int, int]], corners: Any, box: BoxF | None
) -> tuple[list[QuarticEdge], set[tuple[int, int]]]:
    """All degree-4 edges inside the box, and the sides of surfaces that they bound."""
    edges: list[QuarticEdge] = []
    sides: set[tuple[int, int]] = set()
    walks: dict[tuple[int, ...], list[_Walk]] = {}
    for i, j in pairs:
        on = tuple(k for k in range(len(surfaces)) if _in_pencil(surfaces[i], surfaces[j], surfaces[k]))
        if on in walks:
            continue
        if box is None:
            raise UnsupportedPair(
                f"surfaces {i} and {j} meet in a curve of degree 4, and no bound of the solid is known; "
                "intersect it with a box"
            )
        first, second = surfaces[on[0]], surfaces[on[1]]
        assert isinstance(first, Quadric) and isinstance(second, Quadric)
        pair = PairF(first, second)
        walks[on] = [
            _Walk(on, list(points), [None] * len(points), closed, pair) for points, closed in _polylines(pair, box)
        ]
    if box is not None:
        _cut_walks([w for own in walks.values() for w in own], surfaces, corners, _step(box))
    for on, own in walks.items():
        stretches = [s for walk in own for s in _stretches(tree, surfaces, walk)]
        sides |= {side for s in stretches for side in s.profile.faces}
        first, second = surfaces[on[0]], surfaces[on[1]]
        assert isinstance(first, Quadric) and isinstance(second, Quadric)
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


def _step(box: BoxF) -> float:
    return float(np.linalg.norm(box[1] - box[0])) / STEPS


def _polylines(pair: PairF, box: BoxF) -> list[tuple[np.ndarray, bool]]:
    """(points (n, 3), closed) of every branch inside the box, neighbours at most one step apart."""
    lo, hi = box
    step = _step(box)
    lo, hi = lo - 3 * step, hi + 3 * step
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
    """Points from the seed on; the step is halved where the curve bends by more than a third of it."""
    points, direction, length = [seed], None, step
    travelled = 0.0
    for _ in range(200 * STEPS):
        p = points[-1]
        tangent = _tangent(pair, p, direction, way)
        if tangent is None:
            return points, False
        new = pair.pulled((p + length * tangent)[None], 4)[0]
        if np.linalg.norm(new - p - length * tangent) > length / 3 and length > step / 256:
            length /= 2
            continue
        direction = tangent
        if not np.all((new >= lo) & (new <= hi)) or np.linalg.norm(new - p) > 2 * length:
            return points, False
        if travelled > 2 * step and np.linalg.norm(new - seed) < 0.8 * step and tangent @ (points[1] - seed) > 0:
            return points, True
        travelled += length
        points.append(new)
        length = min(2 * length, step)
    return points, False


def _tangent(pair: PairF, p: np.ndarray, direction: np.ndarray | None, way: float) -> np.ndarray | None:
    """The unit tangent that goes on in `direction`; straight on where branches cross, None if that has no meaning."""
    a, b = pair.gradients(p[None])[0]
    tangent = np.array(cross(a, b))
    length = np.linalg.norm(tangent)
    if length < 1e-6 * np.linalg.norm(a) * np.linalg.norm(b):
        return direction
    sign = way if direction is None else math.copysign(1.0, tangent @ direction)
    return sign * tangent / length


# -- stretches between crossings ----------------------------------------------------------------------------


@dataclass(eq=False)
class _Walk:
    """One polyline on the common curve of the surfaces `on`; corners[k]: what lies at point k, if anything."""

    on: tuple[int, ...]
    points: list[np.ndarray]
    corners: list[Any]
    closed: bool
    pair: PairF

    def insert(self, after: int, point: np.ndarray, corner: Any) -> None:
        self.points.insert(after + 1, point)
        self.corners.insert(after + 1, corner)

    def visit(self, corner: Any, step: float) -> None:
        """Put a corner known from elsewhere where the polyline passes it."""
        p = np.array(corner.position)
        if any(c is corner for c in self.corners):
            return
        points = np.array(self.points)
        k = int(np.linalg.norm(points - p, axis=1).argmin())
        if np.linalg.norm(points[k] - p) > step:
            return
        n = len(points)
        along = points[(k + 1) % n if self.closed else min(k + 1, n - 1)] - points[k - 1 if self.closed or k else 0]
        self.insert(k if (p - points[k]) @ along > 0 else k - 1, p, corner)

    def gaps(self) -> list[tuple[int, int]]:
        """Neighbouring numbers."""
        n = len(self.points)
        return [(k, k + 1) for k in range(n - 1)] + ([(n - 1, 0)] if self.closed else [])

    def fill(self) -> None:
        """A point of the curve between any two corners that follow each other."""
        for k, after in reversed(self.gaps()):
            if self.corners[k] is not None and self.corners[after] is not None:
                middle = self.pair.pulled(((self.points[k] + self.points[after]) / 2)[None])[0]
                self.insert(k, middle, None)


def _cut_walks(walks: list[_Walk], surfaces: Sequence[Surface], corners: Any, step: float) -> None:
    """Corners wherever a surface is crossed; corners of one curve are offered to the others, until nothing is new."""
    known = -1
    while known != len(corners.all()):
        known = len(corners.all())
        for walk in walks:
            for corner in corners.all():
                if set(walk.on) <= corner.surfaces:
                    walk.visit(corner, step)
            walk.fill()
            _cross(walk, surfaces, corners, step)
            walk.fill()


def _cross(walk: _Walk, surfaces: Sequence[Surface], corners: Any, step: float) -> None:
    """Add a corner wherever a surface changes its sign between plain points and no corner between explains it."""
    rest = [k for k in range(len(surfaces)) if k not in walk.on]
    signs = _signs_f(np.array(walk.points), surfaces, rest)
    plain = [k for k, corner in enumerate(walk.corners) if corner is None]
    pairs = list(zip(plain, plain[1:], strict=False))
    if walk.closed and len(plain) > 1:
        pairs.append((plain[-1], plain[0]))
    found = []
    n = len(walk.points)
    for k, after in pairs:
        between = [walk.corners[(k + j) % n] for j in range(1, (after - k) % n)]
        explained = {i for corner in between for i in corner.surfaces}
        for i, changed in zip(rest, signs[:, k] != signs[:, after], strict=True):
            if changed and i not in explained:
                start = (walk.points[k] + walk.points[after]) / 2
                point = enclosed((surfaces[walk.on[0]], surfaces[walk.on[1]], surfaces[i]), start)
                position = np.array([to_double(x) for x in point.centre])
                if np.linalg.norm(position - start) < 2 * step:
                    found.append(corners.merged(_all_on(point, walk.on, rest, surfaces), point))
    for corner in found:
        walk.visit(corner, 3 * step)


def _signs_f(points: np.ndarray, surfaces: Sequence[Surface], rest: list[int]) -> np.ndarray:
    """(len(rest), n) bools: where the forms are positive."""
    x = np.column_stack([points, np.ones(len(points))])
    forms = np.array([doubles(surfaces[k].matrix()) for k in rest]).reshape(-1, 4, 4)
    return np.einsum("ni,sij,nj->sn", x, forms, x) > 0


def _all_on(point: EnclosedPoint, on: tuple[int, ...], rest: list[int], surfaces: Sequence[Surface]) -> frozenset[int]:
    """The surfaces whose forms cannot be told from zero at the point."""
    with precision(BITS):
        x = [arb(c, point.radius) for c in point.centre]
        values = {k: surfaces[k].value([*x, arb(1)]) for k in rest}
        return frozenset(on) | {k for k, value in values.items() if not (value > 0 or value < 0)}


def _stretches(tree: Tree, surfaces: Sequence[Surface], walk: _Walk) -> list[_Stretch]:
    """The parts between corners that bound the solid; tells the corners where edges end."""
    rest = [k for k in range(len(surfaces)) if k not in walk.on]
    cuts = [k for k, corner in enumerate(walk.corners) if corner is not None]
    n = len(walk.points)
    if walk.closed and cuts:
        walk.points = walk.points[cuts[0] :] + walk.points[: cuts[0] + 1]
        walk.corners = walk.corners[cuts[0] :] + walk.corners[: cuts[0] + 1]
        cuts = [k for k, corner in enumerate(walk.corners) if corner is not None]
        bounds = cuts
    elif walk.closed:
        walk.points, walk.corners = [*walk.points, walk.points[0]], [None] * (n + 1)
        bounds = [0, n]
    else:
        bounds = sorted({0, *cuts, n - 1})
    parts = list(zip(bounds[:-1], bounds[1:], strict=True))
    points = np.array(walk.points)
    signs = _signs_f(points, surfaces, rest)
    found = []
    kinds: list[str | None] = []
    for a, b in parts:
        middle = next((m for m in sorted(range(a, b + 1), key=lambda m: abs(2 * m - a - b)) if not walk.corners[m]), a)
        profile = _profile_at(tree, surfaces, walk.on, rest, points[middle], signs[:, middle])
        kinds.append(profile.kind if profile.kind in EDGE_KINDS else None)
        if kinds[-1]:
            found.append(_Stretch(points[a : b + 1], profile, walk.corners[a], walk.corners[b]))
    for k, (a, b) in enumerate(parts):
        before = kinds[k - 1] if walk.closed or k else None
        after = kinds[(k + 1) % len(kinds)] if walk.closed or k + 1 < len(kinds) else None
        for corner, other in ((walk.corners[a], before), (walk.corners[b], after)):
            if corner is not None and kinds[k]:
                corner.ends |= other != kinds[k]
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
