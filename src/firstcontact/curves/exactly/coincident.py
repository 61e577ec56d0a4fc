"""Surfaces whose rulings all meet.

All rulings meet (Delta = 0) when they pass through one point, lie in one plane, or are the two reguli of a quadric.  In
the last two cases the pair (u, v) has a point of its own in general, so the pieces share an area exactly where an open
set of pairs satisfies all bounds: one rational pair in every cell of the arrangement of the bounds decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from flint import fmpq, fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.contact.signs.pieces import RulingPiece, at_place
from firstcontact.contact.signs.sheets import samples
from firstcontact.curves.exactly.answer import FoundCurve, RulingPair
from firstcontact.curves.exactly.branches import add_apex, add_curves
from firstcontact.curves.exactly.clipping import Condition, in_range
from firstcontact.curves.exactly.shared_rulings import holds
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.polynomials import bivariate
from firstcontact.exact.polynomials.bivariate import in_u, in_v, irreducible
from firstcontact.pairs.ruled_ruled import all_real_roots, divides, rulings_through

Range = tuple[fmpq, fmpq] | None


def all_meet(found: FoundCurve) -> None:
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
        # on others rulings are one line, or meet at infinity
        curves = [f for f in borders if not _add_apex_of_other(found, f)]
        if curves:
            add_curves(found, [(f, 1) for f in curves])


def _add_apex_of_other(found: FoundCurve, border: fmpz_mpoly) -> bool:
    """Whether a border is of rulings through the apex of the other piece: they share that point, and no curve."""
    side = 0 if border.degrees()[1] == 0 else 1
    own, apex = found.pieces[side], found.pieces[1 - side].rulings.apex
    line = (in_u, in_v)[side]
    if border.degrees()[1 - side] or apex is None or not divides(border, line(rulings_through(own.rulings, apex))):
        return False
    point = np.array([float(fmpq(x, apex[3])) for x in apex[:3]])
    for parameter in all_real_roots(bivariate.univariate(border, "uv"[side])):
        if in_range(own, parameter):
            add_apex(found, line(parameter.polynomial), point, side, parameter)
    return True


def _apex(found: FoundCurve, apex: Sequence[fmpz]) -> None:
    """The common apex, where it is finite and on both pieces."""
    if apex[3] == 0:
        return
    u, v = (_parameter_of(piece, apex) for piece in (found.p, found.q))
    if u is not None and v is not None:
        if found.box is None or all(
            fmpq(low) <= fmpq(x, apex[3]) <= fmpq(high) for x, low, high in zip(apex, *found.box, strict=False)
        ):
            found.add_isolated(np.array([float(fmpq(x, apex[3])) for x in apex[:3]]), RulingPair(u, v))


def _parameter_of(piece: RulingPiece, apex: Sequence[fmpz]) -> AlgebraicRoot | None:
    """A parameter whose ruling holds the apex inside the piece."""
    roots = _in_range([r for g in _changes(piece, apex) if g != 0 for r in all_real_roots(g)], piece.u)
    ends = [AlgebraicRoot.of(x) for x in piece.u or ()]
    for u in [*ends, *roots, *(AlgebraicRoot.of(x) for x in samples(roots, piece.u))]:
        if holds(piece, u, apex):
            return u
    return None


def _changes(piece: RulingPiece, apex: Sequence[fmpz]) -> list[fmpz_poly]:
    """Polynomials in u without whose zeros the apex stays inside or outside the part of the ruling."""
    first, second = piece.rulings.first, piece.rulings.second
    found: list[fmpz_poly] = []
    for j in range(3):
        # the apex is at s = n / d, by its coordinate j
        n = (apex[j] * first[3] - first[j] * apex[3]) * second[3]
        d = (second[j] * first[3] - first[j] * second[3]) * apex[3]
        if d != 0:
            found.append(d)
            if piece.bounded:
                found += [n, d - n]
            found += [at_place(g, fmpz_poly([0, 1]), n, d) for g in piece.trim]
    return found


def _has_area(conditions: Sequence[Condition], u: Range, v: Range) -> bool:
    """Whether an open set of (u, v) satisfies the conditions."""
    borders = irreducible(x for c in conditions for x, _, _ in c.polynomials)
    critical = [bivariate.discriminant(b) if b.degrees()[1] else bivariate.univariate(b, "u") for b in borders]
    critical += [bivariate.resultant(a, b) for a, b in combinations(borders, 2)]
    critical += [bivariate.restrict(b, "v", end) for b in borders for end in v or ()]
    roots = _in_range([r for f in critical if f != 0 for r in all_real_roots(f)], u)
    for x in samples(roots, u):
        over = [f for f in (bivariate.restrict(b, "u", x) for b in borders) if f != 0]
        for y in samples(_in_range([r for f in over for r in all_real_roots(f)], v), v):
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
    borders = irreducible(x for c in conditions for x, _, _ in c.polynomials)
    for ends, along in ((u, in_u), (v, in_v)):
        borders += [along(fmpz_poly([-x.p, x.q])) for x in ends or ()]
    return [f for i, f in enumerate(borders) if f not in borders[:i]]


def _in_range(roots: list[AlgebraicRoot], bounds: Range) -> list[AlgebraicRoot]:
    """The different ones among them inside the bounds, ascending."""
    found: list[AlgebraicRoot] = []
    for root in roots:
        if bounds is None or (root.compare(bounds[0]) > 0 and root.compare(bounds[1]) < 0):
            place = next((i for i, other in enumerate(found) if root.compare(other) <= 0), len(found))
            if place == len(found) or root.compare(found[place]) != 0:
                found.insert(place, root)
    return found
