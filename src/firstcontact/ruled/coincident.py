"""Surfaces whose rulings all meet, and surfaces that share rulings along a curve of pairs (u, v).

All rulings meet (Delta = 0) when they pass through one point, lie in one plane, or are the two reguli of a quadric.  In
the last two cases the pair (u, v) has a point of its own in general, so the pieces share an area exactly where an open
set of pairs satisfies all bounds: one rational pair in every cell of the arrangement of the bounds decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np
from flint import arb, fmpq, fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.errors import UnsupportedPair
from firstcontact.exact import bivariate
from firstcontact.exact.bivariate import in_u, in_v
from firstcontact.exact.numbers import precision
from firstcontact.exact.plane_curves import topology
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.pairs.ruled_ruled import all_real_roots, divides, rulings_at_infinity
from firstcontact.ruled.answer import Found, Pair
from firstcontact.ruled.branches import Joints, add_branches, add_curves
from firstcontact.ruled.clipping import Condition, overlap
from firstcontact.ruled.common_lines import ALONG, changes, inner_roots, parameter_of, samples, shared
from firstcontact.ruled.pieces import Piece
from firstcontact.ruled.spots import Spot
from firstcontact.ruled.tracing import Powers, rows

Range = tuple[fmpq, fmpq] | None


def all_meet(found: Found) -> None:
    """What the pieces share besides common rulings, given that all their rulings meet."""
    p, q = found.p.rulings, found.q.rulings
    if p.apex is not None and p.apex == q.apex:
        _apex(found, p.apex)
        return
    k = next(k for k in range(4) if any(not row[k].is_zero() for row in found.clip.points))
    conditions = found.clip.conditions(k)
    found.two_dimensional = _has_area(conditions, found.p.u, found.q.u)
    if not found.two_dimensional:
        points = found.clip.points
        borders = [f for f in _borders(conditions, found.p.u, found.q.u)
                   if found.clip.columns(f) and not all(divides(f, x) for x in points[3])]  # fmt: skip
        if borders:  # on others rulings are one line, or meet at infinity
            add_curves(found, [(f, 1) for f in borders])


def _apex(found: Found, apex: Sequence[fmpz]) -> None:
    """The common apex, where it is finite and on both pieces."""
    if apex[3] == 0:
        return
    u, v = (_parameter_of(piece, apex) for piece in (found.p, found.q))
    if u is not None and v is not None:
        if found.box is None or all(
            fmpq(low) <= fmpq(x, apex[3]) <= fmpq(high) for x, low, high in zip(apex, *found.box, strict=False)
        ):
            found.add_isolated(np.array([float(fmpq(x, apex[3])) for x in apex[:3]]), Pair(u, v))


def _parameter_of(piece: Piece, apex: Sequence[fmpz]) -> AlgebraicRoot | None:
    """A parameter whose ruling holds the apex inside the piece."""
    if piece.trim:
        return parameter_of(piece, [fmpq(x, apex[3]) for x in apex[:3]])
    first, second = piece.rulings.first, piece.rulings.second
    between = []
    if piece.bounded:
        for j in range(3):
            before, after = apex[j] * first[3] - first[j] * apex[3], second[j] * apex[3] - apex[j] * second[3]
            between.append(before * after)
    roots = inner_roots([r for g in between if g != 0 for r in all_real_roots(g)], piece.u)
    for u in [*roots, *(AlgebraicRoot.of(x) for x in (*samples(roots, piece.u), *(piece.u or ())))]:
        if all(u.sign_of(g) >= 0 for g in between):
            return u
    return None


def _has_area(conditions: Sequence[Condition], u: Range, v: Range) -> bool:
    """Whether an open set of (u, v) satisfies the conditions."""
    borders = _irreducible(x for c in conditions for x, _, _ in c.polynomials)
    critical = [bivariate.discriminant(b) if b.degrees()[1] else bivariate.univariate(b, "u") for b in borders]
    critical += [bivariate.resultant(a, b) for a, b in combinations(borders, 2)]
    critical += [bivariate.restrict(b, "v", end) for b in borders for end in v or ()]
    roots = inner_roots([r for f in critical if f != 0 for r in all_real_roots(f)], u)
    for x in samples(roots, u):
        over = [f for f in (bivariate.restrict(b, "u", x) for b in borders) if f != 0]
        for y in samples(inner_roots([r for f in over for r in all_real_roots(f)], v), v):
            if all(_sign(c, x, y) > 0 for c in conditions):
                return True
    return False


def _sign(c: Condition, x: fmpq, y: fmpq) -> int:
    found = c.sign
    for f, _, _ in c.polynomials:
        value = bivariate.restrict(f, "u", x)(y) if not f.is_zero() else 0
        found *= (value > 0) - (value < 0)
    return found


def _borders(conditions: Sequence[Condition], u: Range, v: Range) -> list[fmpz_mpoly]:
    """The irreducible curves on which a bound holds with equality, ends of the ranges included."""
    borders = _irreducible(x for c in conditions for x, _, _ in c.polynomials)
    for ends, along in ((u, in_u), (v, in_v)):
        borders += [along(fmpz_poly([-x.p, x.q])) for x in ends or ()]
    return [f for i, f in enumerate(borders) if f not in borders[:i]]


def _irreducible(polynomials: Iterable[fmpz_mpoly]) -> list[fmpz_mpoly]:
    found: list[fmpz_mpoly] = []
    for f in polynomials:
        if f.is_zero() or f.is_constant():
            continue
        parts = bivariate.factors(f)
        own = [g for g, _ in parts.curves] + [in_u(g) for g, _ in parts.in_u] + [in_v(g) for g, _ in parts.in_v]
        found += [g for g in own if g not in found]
    return found


# -- common rulings along a curve ---------------------------------------------------------------------------


def along_correspondence(found: Found, correspondence: fmpz_mpoly) -> None:
    """Whether rulings that are one line share segments along the correspondence: then the pieces share an area."""
    p, q = found.p, found.q
    if p.trim or q.trim or found.box is not None:
        _cut_along(found, correspondence)
        return
    factors = _irreducible([correspondence])
    ends = _comparisons(p, q) if p.bounded and q.bounded else []
    extras = [in_u(rulings_at_infinity(p.rulings)), *(f for row in ends for f in row)]
    graph = topology(factors, u=p.u, v=q.u, extras=[f for f in extras if not f.is_constant()])
    touching = []
    for edge in graph.edges:
        u, v = (x if isinstance(x, AlgebraicRoot) else AlgebraicRoot.of(x) for x in edge.sample)
        part = overlap(p, q, u, v)
        if part is None:
            continue
        if not (p.bounded and q.bounded) or (part[0] != part[1]).any():
            found.two_dimensional = True
            return
        touching.append((edge, _shared_end(ends, factors[edge.curve])))
    for end in dict.fromkeys(end for _, end in touching):
        joints = Joints(found, graph, _EndCurve(found, *end))
        add_branches(found, joints, [e for e, other in touching if other == end], [(f, 1) for f in factors])
    used = {k for edge, _ in touching for k in (edge.start, edge.end)}
    for node in graph.nodes:
        part = None if node.index in used else overlap(p, q, node.u, node.v)
        if part is not None:
            found.add_common(part, node)


def _cut_along(found: Found, correspondence: fmpz_mpoly) -> None:
    """The same where trimming or a box cuts the rulings."""
    p, q, box = found.p, found.q, found.box
    j = next(j for j, k in enumerate(ALONG) if p.rulings.line[k] != 0)
    extras = [in_u(rulings_at_infinity(p.rulings)), *changes(p, q, box, j)]
    graph = topology(_irreducible([correspondence]), u=p.u, v=q.u, extras=[f for f in extras if not f.is_constant()])
    parts = [shared(p, q, box, *(AlgebraicRoot.of(x) if isinstance(x, fmpq) else x for x in edge.sample))
             for edge in graph.edges]  # fmt: skip
    if any((part[0] != part[1]).any() for row in parts for part in row):
        found.two_dimensional = True
        return
    if any(parts):
        raise UnsupportedPair("equal rulings along a curve, which trimming or a box cuts to single points")
    for node in graph.nodes:
        for part in shared(p, q, box, node.u, node.v):
            found.add_common(part, node)


def _shared_end(ends: list[list[fmpz_mpoly]], factor: fmpz_mpoly) -> tuple[int, int]:
    """Which end of the rulings of p is which end of those of q, all along a factor."""
    k = next(k for k, row in enumerate(ends) if all(divides(factor, f) for f in row))
    return divmod(k, 2)


class _EndCurve:
    """Where a pair (u, v) of rulings that are one line is in space: an end that their segments share."""

    def __init__(self, found: Found, end_p: int, end_q: int) -> None:
        self.piece, self.ends = found.p, (end_p, end_q)

    def spot(self, chart: tuple[bool, bool], x: arb, y: arb, bits: int) -> Spot:
        rulings = self.piece.reversed_rulings(chart[0])
        with precision(bits):
            point = tuple(c(x) for c in (rulings.first, rulings.second)[self.ends[0]])
            s, t = ((arb(end), arb(1)) for end in self.ends)
        return Spot(x, y, chart, point, s, t, 0, bits)

    def surfaces(self) -> _EndCurve:
        r = self.piece.rulings
        self.curve = rows((r.first, r.second)[self.ends[0]])
        return self

    def points(self, u: Powers, v: Powers) -> tuple[np.ndarray, np.ndarray]:
        """As those of tracing.Surfaces."""
        point = self.curve @ u.table(self.curve.shape[1] - 1)
        return (point[:3] / point[3]).T, np.tile(np.array(self.ends, float), (len(u.x), 1))

    def size(self) -> float:
        return float(np.abs(self.curve).max())


def _comparisons(p: Piece, q: Piece) -> list[list[fmpz_mpoly]]:
    """Polynomials that vanish where an end of a ruling of p and one of q have a coordinate in common."""
    rows = []
    for a in (p.rulings.first, p.rulings.second):
        for b in (q.rulings.first, q.rulings.second):
            rows.append([in_u(a[j]) * in_v(b[3]) - in_u(a[3]) * in_v(b[j]) for j in range(3)])
    return rows
