"""What two pieces share of a ruling that they have in common, where trimming or a box cuts it too; decided exactly.

A point of the line is told by one of its coordinates, c.  Every bound of a piece is then a polynomial in its parameter
and c that is not negative on the piece, so the part that is shared is a union of closed intervals of c, between real
zeros of these polynomials.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from flint import arb, fmpq, fmpz_mpoly

from firstcontact.errors import UnsupportedPair
from firstcontact.exact import bivariate, trivariate
from firstcontact.exact.bivariate import CONTEXT, U, V, in_u
from firstcontact.exact.numbers import dyadic, precision, rational
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.pairs.ruled_ruled import Parameter, all_real_roots, at_infinity
from firstcontact.ruled.clipping import in_range
from firstcontact.ruled.pieces import Piece
from firstcontact.ruled.spots import Box, doubles
from firstcontact.ruled.tracing import Surfaces

# Where unbounded parts are cut, in units of the size of the directrices: as branches are.
REACH, BITS = 100, 192
# Components of a Pluecker vector that tell how far it runs along an axis.
ALONG = (2, 4, 5)
Range = tuple[fmpq, fmpq] | None
Bounds = list[fmpz_mpoly]
"""Polynomials in a parameter (the ring's u) and a coordinate c (its v) that are not negative on a piece."""


def shared(p: Piece, q: Piece, box: Box | None, u: Parameter, v: Parameter) -> list[np.ndarray]:
    """(2, 3) ends of the segments that the pieces share of their common ruling l(u) = m(v); equal ones for points."""
    if not (in_range(p, u) and in_range(q, v)) or at_infinity(p.rulings, u):
        return []
    (p, x), (q, y) = _finite(p, u), _finite(q, v)
    if any(root.sign_of(piece.rulings.common) == 0 for piece, root in ((p, x), (q, y))):
        raise UnsupportedPair("a common ruling that is a point of one surface, with trimming or a box")
    j = next(j for j, k in enumerate(ALONG) if x.sign_of(p.rulings.line[k]) != 0)
    bounds = [(f, root) for piece, root, own in ((p, x, box), (q, y, None)) for f in bounds_on(piece, j, own)]
    ends = inner_roots([c for f, root in bounds for c in _zeros(f, root)], None)
    places = [*zip(samples(ends, None), [*ends, None], strict=True)]  # a cell, then the end above it
    kept = [all(bivariate.sign_at(f, root, c) >= 0 for f, root in bounds)
            for place in places for c in place if c is not None]  # fmt: skip
    far = REACH * Surfaces(p, q).size()
    return [_segment(p, j, x, [ends[k] if 0 <= k < len(ends) else None for k in run], far) for run in _runs(kept)]


def bounds_on(piece: Piece, j: int, box: Box | None) -> Bounds:
    """Those of a piece on rulings that are not across the coordinate axis j, and of the box."""
    first, second = ([in_u(x) for x in end] for end in (piece.rulings.first, piece.rulings.second))
    before, after = V * first[3] - first[j], second[j] - V * second[3]
    width = second[j] * first[3] - first[j] * second[3]
    found = [before * after] if piece.bounded else []
    # s = above / width
    above = before * second[3]
    for g in piece.trim:
        top = max(k for _, k in g)
        top += top % 2
        f = CONTEXT.constant(0)
        for (i, k), c in g.items():
            f = f + U**i * above**k * width ** (top - k) * c
        found.append(f)
    for k, (low, high) in enumerate(zip(*box, strict=True) if box is not None else ()):
        place = first[k] * width + before * (second[k] * first[3] - first[k] * second[3])
        weight = first[3] * width
        for end, sign in ((rational(low, "box"), 1), (rational(high, "box"), -1)):
            found.append((place * end.q - weight * end.p) * weight * sign)
    return [f for f in found if not f.is_zero()]


def changes(p: Piece, q: Piece, box: Box | None, j: int) -> Bounds:
    """Polynomials in u and v: on pairs of one ruling, off their zeros, bounds keep the order of their zeros on it."""
    mine, other = (
        [h for f in bounds_on(piece, j, own) for h in trivariate.irreducible(_three(f, side))]
        for side, (piece, own) in enumerate(((p, box), (q, None)))
    )
    walls = list({str(f): f for f in (*mine, *other)}.values())
    found = trivariate.FactorSet()
    for side, piece in enumerate((p, q)):
        found.add(trivariate.embedded(piece.rulings.line[ALONG[j]], side))
    for f in walls:
        found.add(trivariate.coefficients(f, 2)[-1])
        if trivariate.degree(f, 2):
            found.add(trivariate.discriminant(f, 2))
    for f, g in combinations([f for f in walls if trivariate.degree(f, 2)], 2):
        if not (r := trivariate.resultant(f, g, 2)).is_zero():
            found.add(r)
    return [CONTEXT.from_dict({key[:2]: c for key, c in trivariate.terms(f)}) for f in found]


def parameter_of(piece: Piece, apex: Sequence[fmpq]) -> AlgebraicRoot | None:
    """A parameter whose ruling holds the apex of all rulings inside a trimmed piece."""
    bounds = [[bivariate.restrict(f, "v", apex[j]) for f in bounds_on(piece, j, None)] for j in range(3)]
    widths = [piece.rulings.line[k] for k in ALONG]
    roots = [r for f in (*widths, *(f for row in bounds for f in row)) if f != 0 for r in all_real_roots(f)]
    roots = inner_roots(roots, piece.u)
    for u in [*roots, *(AlgebraicRoot.of(x) for x in (*samples(roots, piece.u), *(piece.u or ())))]:
        j = next((j for j in range(3) if u.sign_of(widths[j]) != 0), None)
        if j is None or not all(u.sign_of(f) >= 0 for f in bounds[j]):
            continue
        if u.sign_of(piece.rulings.common) == 0:
            raise UnsupportedPair("two cones with one apex, at which a ruling is a point, and trimming inequalities")
        return u
    return None




def _finite(piece: Piece, u: Parameter) -> tuple[Piece, AlgebraicRoot]:
    """The piece in a parameter in which u is finite."""
    return (piece.away_from_infinity(0), AlgebraicRoot.of(fmpq(0))) if u is None else (piece, u)


def _three(f: fmpz_mpoly, side: int) -> fmpz_mpoly:
    """A polynomial in a parameter and c as one in u, v and T, which stands for c."""
    return trivariate.RING.from_dict({((i, 0, j), (0, i, j))[side]: c for (i, j), c in f.to_dict().items()})


def _zeros(f: fmpz_mpoly, u: AlgebraicRoot) -> list[AlgebraicRoot]:
    """Numbers among which are all c with f(u, c) = 0, where these are finitely many."""
    if u.rational is not None:
        return all_real_roots(bivariate.restrict(f, "u", u.rational))
    return all_real_roots(bivariate.resultant(f, in_u(u.polynomial), "u"))


def _runs(kept: Sequence[bool]) -> Iterator[tuple[int, int]]:
    """The first and last end, by number, of stretches that are kept; -1 and one too many stand for none.

    kept: of cells and the ends between them, in turn.
    """
    start = None
    for k, keep in enumerate([*kept, False]):
        if keep and start is None:
            start = k
        if not keep and start is not None:
            yield (start - 1) // 2, (k - 1) // 2
            start = None


def _segment(piece: Piece, j: int, u: AlgebraicRoot, ends: list[AlgebraicRoot | None], far: float) -> np.ndarray:
    """The part of a ruling between two values of coordinate j; two points of the line where there are none."""
    with precision(BITS):
        l01, l02, l03, l12, l13, l23 = (c(u.enclosure(BITS)) for c in piece.rulings.line)
        along, moment = (-l03, -l13, -l23), (l12, -l02, l01)
        size = sum((x * x for x in along), arb(0))
        foot = [(along[k - 2] * moment[k - 1] - along[k - 1] * moment[k - 2]) / size for k in range(3)]
        unit = np.array([float((x / size.sqrt()).mid()) for x in along])
        first, last = (_point(foot, along, j, c) for c in ends)
        start = doubles(foot)
    unit *= np.sign(unit[j])
    if first is None and last is None:
        return np.array([start, start + unit])
    if first is None or last is None:
        return np.array([first, first + far * unit] if first is not None else [last - far * unit, last])
    return np.array([first, last])


def _point(foot: Sequence[arb], along: Sequence[arb], j: int, c: AlgebraicRoot | None) -> Any:
    if c is None:
        return None
    way = (c.enclosure(BITS) - foot[j]) / along[j]
    return doubles([x + y * way for x, y in zip(foot, along, strict=True)])


# -- cells of a line ----------------------------------------------------------------------------------------


def inner_roots(roots: Iterable[AlgebraicRoot], bounds: Range) -> list[AlgebraicRoot]:
    """The different ones among them inside the bounds, ascending."""
    found: list[AlgebraicRoot] = []
    for root in roots:
        if bounds is None or (root.compare(bounds[0]) > 0 and root.compare(bounds[1]) < 0):
            place = next((i for i, other in enumerate(found) if root.compare(other) <= 0), len(found))
            if place == len(found) or root.compare(found[place]) != 0:
                found.insert(place, root)
    return found


def samples(roots: Sequence[AlgebraicRoot], bounds: Range) -> list[fmpq]:
    """A rational number in every open interval between neighbours, and before and after all."""
    if not roots:
        return [(bounds[0] + bounds[1]) / 2 if bounds is not None else fmpq(0)]
    cells = _disjoint(roots)
    between = [(a[1] + b[0]) / 2 for a, b in zip(cells, cells[1:], strict=False)]
    first = cells[0][0] - 1 if bounds is None else (bounds[0] + cells[0][0]) / 2
    last = cells[-1][1] + 1 if bounds is None else (cells[-1][1] + bounds[1]) / 2
    return [first, *between, last]


def _disjoint(roots: Sequence[AlgebraicRoot]) -> list[tuple[fmpq, fmpq]]:
    """Disjoint enclosures of different roots."""
    bits = 64
    while True:
        balls = [root.enclosure(bits) for root in roots]
        if all(x < y for x, y in pairwise(balls)):
            with precision(2 * bits):
                return [(dyadic(x.lower()), dyadic(x.upper())) for x in balls]
        bits *= 2
