"""Surfaces that share rulings along a curve of pairs (u, v): do their pieces share segments of them, an area then?"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

from flint import fmpq, fmpz_mpoly

from firstcontact.contact.signs.pieces import RulingPiece, at_place
from firstcontact.curves.exactly.answer import FoundCurve
from firstcontact.curves.exactly.branches import Joints, add_branches
from firstcontact.curves.exactly.piece_borders import Border, BorderCurve
from firstcontact.curves.exactly.shared_rulings import add_shared, share_a_segment, touching_borders
from firstcontact.curves.exactly.spots import Box
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.curves.plane_curves import topology
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import rational
from firstcontact.exact.polynomials.bivariate import CONTEXT, irreducible, restrict
from firstcontact.exact.polynomials.trivariate import (
    RING,
    FactorSet,
    coefficients,
    degree,
    discriminant,
    embedded,
    resultant,
    terms,
)
from firstcontact.pairs.ruled_ruled import common_rulings, divides

X = 2
"""The place of x among the variables."""
ENDS = 2, 4, 5
"""The components 03, 13, 23 of a Pluecker vector: the direction."""


def along_correspondence(found: FoundCurve, correspondence: fmpz_mpoly) -> None:
    """Whether rulings that are one line share segments along the correspondence: then the pieces share an area."""
    p, q, box = found.p, found.q, found.box
    factors = irreducible([correspondence])
    extras = _critical(p, q, box, factors)
    graph = topology(factors, u=p.u, v=q.u, extras=[f for f in extras if not f.is_constant()])
    touching: dict[Border, list[Any]] = {}
    for edge in graph.edges:
        u, v = (w if isinstance(w, AlgebraicRoot) else AlgebraicRoot.of(w) for w in edge.sample)
        area = share_a_segment(p, q, u, v, box)
        if area:
            found.two_dimensional = True
            return
        if area is not None:
            for border in touching_borders(p, q, u, v, box):
                # a border that is a point is the common apex, which `coincident` tells
                if not border.is_point(found.pieces[border.side].rulings):
                    touching.setdefault(border, []).append(edge)
    for border, edges in touching.items():
        add_branches(found, Joints(found, graph, BorderCurve(p, q, border)), edges, [(f, 1) for f in factors])
    used = {k for edges in touching.values() for edge in edges for k in (edge.start, edge.end)}
    for node in graph.nodes:
        if node.index not in used:
            add_shared(found, node)


def special_at_infinity(p: RulingPiece, q: RulingPiece, box: Box | None, side: int) -> bool:
    """Whether what rulings share may change at the parameter infinity of one side, so that it must be a node."""
    pieces = [p, q]
    if pieces[side].u is not None or not (box is not None or any(x.bounded or x.trim for x in pieces)):
        return False
    pieces[side] = pieces[side].away_from_infinity(0)
    a, b = pieces
    factors = irreducible([common_rulings(a.rulings, b.rulings).correspondence])
    here = [restrict(f, "uv"[side], fmpq(0)) for f in factors]
    if any(x.degree() < f.degrees()[1 - side] for x, f in zip(here, factors, strict=True)):
        return True
    critical = _critical(a, b, box, factors)
    for x, f in zip(here, factors, strict=True):
        for c in critical:
            while not c.is_zero() and divides(f, c):  # where it holds all along, its other zeros count
                c = c // f
            if not c.is_zero() and x.gcd(restrict(c, "uv"[side], fmpq(0))).degree() != 0:
                return True
    return False


def _critical(p: RulingPiece, q: RulingPiece, box: Box | None, factors: list[fmpz_mpoly]) -> list[fmpz_mpoly]:
    """Polynomials in u and v: between their zeros on the correspondence, what rulings share stays as it is.

    Along the line, told by a coordinate x of its points (T in these rings), every bound is a polynomial.  The parts
    change where its leading coefficient or discriminant vanishes, or its resultant with another one.
    """
    bounds = FactorSet()
    for f in (*_bounds(p, q), *(_walls(p, box) if box is not None else ())):
        if not f.is_zero():
            bounds.add(f)
    along = [f for f in bounds if degree(f, X)]
    found = [f for f in bounds if not degree(f, X)] + [coefficients(f, X)[-1] for f in along]
    for f, g in [*((f, f) for f in along if degree(f, X) > 1), *combinations(along, 2)]:
        r = discriminant(f, X) if f is g else resultant(f, g, X)
        if max(degree(f, X), degree(g, X)) > 1 and any(divides(c, _in_u_v(r)) for c in factors):
            raise UnsupportedPair("surfaces share rulings along a curve, and inequalities have the same border there")
        found.append(r)
    return [_in_u_v(f) for f in found]


def _coordinate(p: RulingPiece) -> int:
    """One that tells the points of almost all rulings apart."""
    return next(j for j in range(3) if p.rulings.line[ENDS[j]] != 0)


def _bounds(p: RulingPiece, q: RulingPiece) -> Iterator[fmpz_mpoly]:
    """What vanishes at the ends of rulings and where inequalities hold with equality, and where they are points."""
    x, j = RING.gens()[X], _coordinate(p)
    yield embedded(p.rulings.line[ENDS[j]], 0)
    for k, piece in enumerate((p, q)):
        if piece.bounded or piece.trim:
            a, w, b, y = (embedded(c[i], k) for c in (piece.rulings.first, piece.rulings.second) for i in (j, 3))
            n, d = x * w * y - a * y, b * w - a * y  # s = n / d
            yield from (d, w, y)
            if piece.bounded:
                yield from (n, d - n)
            yield from (at_place(g, RING.gens()[k], n, d) for g in piece.trim)


def _walls(p: RulingPiece, box: Box) -> Iterator[fmpz_mpoly]:
    """What vanishes where the line leaves the box: it meets x_j = x in the point (L_ij - x L_i3) / L_3j."""
    j, x = _coordinate(p), RING.gens()[X]
    line = [embedded(c, 0) for c in p.rulings.line]
    ends = [line[k] for k in ENDS]
    moments = {(0, 1): line[0], (0, 2): line[1], (1, 2): line[3]}
    for i in range(3):
        moment = RING.constant(0) if i == j else moments[i, j] if i < j else -moments[j, i]
        for wall in (rational(box[0][i], "box"), rational(box[1][i], "box")):
            yield wall.q * (moment - x * ends[i]) + wall.p * ends[j]


def _in_u_v(f: fmpz_mpoly) -> fmpz_mpoly:
    """A polynomial without x in the ring of u and v."""
    return CONTEXT.from_dict({(i, j): c for (i, j, _), c in terms(f)})
