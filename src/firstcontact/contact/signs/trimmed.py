"""A point of every component of a trimmed piece: what a solid holds of it, it holds whole components of.

Where every place of the piece can be left into its interior, every component has an area, and so a part between the
critical places of u; one rational point of each part is enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import combinations
from typing import TYPE_CHECKING

from flint import fmpq, fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.body.kept import Kept
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.signs.conditions import bound_once, local_trims, polynomials
from firstcontact.contact.signs.sheets import samples
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import roots_in
from firstcontact.exact.numbers import rational
from firstcontact.exact.polynomials import bernstein
from firstcontact.exact.polynomials.trivariate import (
    RING,
    FactorSet,
    at,
    coefficients,
    degree,
    discriminant,
    resultant,
    terms,
    univariate,
)

if TYPE_CHECKING:
    from firstcontact.exact.fields.roots import AlgebraicRoot

DEPTH = 24
"""Halvings after which borders count as touching each other."""
WAYS = (0, 1), (0, -1), (1, 1), (1, -1)
"""A parameter, and along or against it."""
UNIT = fmpq(0), fmpq(1)
Place = tuple[fmpq, fmpq]
"""u, and s counted from 0 to 1."""
_INNER_PLACES = Kept[list[Place]]()


def inner_places(surface: RuledSurface) -> list[Place]:
    """One place at least in every component; of one without inequalities a corner.  Raises UnsupportedPair."""
    if not surface.trim:
        return [(fmpq(-1) if surface.u is None else rational(surface.u[0], "u"), fmpq(0))]
    return _INNER_PLACES.of(surface, lambda: _inner_places(surface))


def _inner_places(surface: RuledSurface) -> list[Place]:
    if surface.u is None or surface.s is None:
        raise UnsupportedPair(f"{surface!r} is trimmed and has no ends of {surface.without_end}; give a range")
    ends = rational(surface.u[0], "u"), rational(surface.u[1], "u")
    trims = local_trims(surface)
    kept = polynomials(trims)
    if not bound_once(trims, ends, True) or not _have_areas(kept, ends):
        raise UnsupportedPair(
            f"{surface!r}: its trimmed part may have points or arcs without area; where it meets a solid, let the "
            "borders of its inequalities be smooth and cross cleanly"
        )
    found = []
    for u in samples(_critical(kept, ends), ends):
        on_line = [univariate(at(g, 0, u), 1) for g in kept]
        for s in samples(_roots(on_line, UNIT), UNIT):
            if all(g(s) >= 0 for g in on_line):
                found.append((u, s))
    return found


def _critical(borders: Sequence[fmpz_mpoly], ends: tuple[fmpq, fmpq]) -> list[AlgebraicRoot]:
    """The u between which nothing changes."""
    walls = FactorSet()
    for g in borders:
        parts = [discriminant(g, 1), coefficients(g, 1)[-1], at(g, 1, fmpq(0)), at(g, 1, fmpq(1))]
        parts += [resultant(g, h, 1) for h in borders if h is not g]
        for part in parts:
            if not part.is_zero():
                walls.add(part)
    return _roots([univariate(w, 0) for w in walls], ends)


def _roots(polynomials: Sequence[fmpz_poly], ends: tuple[fmpq, fmpq]) -> list[AlgebraicRoot]:
    together = reduce(lambda x, y: x * y, (p for p in polynomials if p.degree() > 0), fmpz_poly([1]))
    return roots_in(together, ends)


def _have_areas(kept: Sequence[fmpz_mpoly], ends: tuple[fmpq, fmpq]) -> bool:
    """True proves that from every place of the piece a way leads into its interior.

    A box in which two borders meet and cross has such ways; so has one where all borders that meet it nowhere decrease
    along one of the parameters, and grow where that way leaves the box.  For no border is a line that another one has,
    or the range: where a polynomial stays zero along a line, it changes its sign across it.
    """
    u, s = RING.gen(0), RING.gen(1)
    lo, hi = ends
    walls = [*kept, lo.q * u - lo.p, hi.p - hi.q * u, s, 1 - s]
    slopes = [(f.derivative(0), f.derivative(1)) for f in walls]
    crossings = {
        (i, j): _table(slopes[i][0] * slopes[j][1] - slopes[i][1] * slopes[j][0])
        for i, j in combinations(range(len(walls)), 2)
    }
    tables, slope_tables = [_table(f) for f in walls], [(_table(x), _table(y)) for x, y in slopes]
    boxes = [(ends, UNIT, 0)]
    while boxes:
        x, y, depth = boxes.pop()
        signs = [_sign(table, x, y) for table in tables]
        if -1 in signs or not any(sign is None for sign in signs):
            continue
        active = [k for k, sign in enumerate(signs) if sign is None]
        if len(active) == 2 and _sign(crossings[active[0], active[1]], x, y):
            continue
        found = [(slope_tables[k], k < len(kept)) for k in active]
        if any(_all_grow([(slopes[i], bent) for slopes, bent in found], i, sign, (x, y)) for i, sign in WAYS):
            continue
        if depth == DEPTH:
            return False
        for part in _halves(x) if depth % 2 == 0 else _halves(y):
            boxes.append((part, y, depth + 1) if depth % 2 == 0 else (x, part, depth + 1))
    return True


def _all_grow(
    slopes: Sequence[tuple[tuple[dict[tuple[int, int], fmpz], tuple[int, int]], bool]],
    index: int,
    sign: int,
    box: tuple[tuple[fmpq, fmpq], tuple[fmpq, fmpq]],
) -> bool:
    """Whether no wall decreases along a parameter (or against it), and bent ones grow at the end; straight may stay.

    slopes: derivatives by that parameter, and whether the wall is bent.
    """
    end = box[index][1 if sign > 0 else 0]
    last = ((end, end), box[1]) if index == 0 else (box[0], (end, end))
    return all(
        _sign(table, *last) == sign == _way(table, *box) if bent else _way(table, *box) in (0, sign)
        for table, bent in slopes
    )


def _halves(ends: tuple[fmpq, fmpq]) -> tuple[tuple[fmpq, fmpq], tuple[fmpq, fmpq]]:
    middle = (ends[0] + ends[1]) / 2
    return (ends[0], middle), (middle, ends[1])


def _table(f: fmpz_mpoly) -> tuple[dict[tuple[int, int], fmpz], tuple[int, int]]:
    return {(key[0], key[1]): c for key, c in terms(f)}, (degree(f, 0), degree(f, 1))


def _way(
    table: tuple[dict[tuple[int, int], fmpz], tuple[int, int]], x: tuple[fmpq, fmpq], y: tuple[fmpq, fmpq]
) -> int | None:
    """1, -1: nowhere negative, nowhere positive, and not zero; 0: zero; None where none of that is proved."""
    net = [c for row in bernstein.grid(table[0], x, y, table[1]) for c in row] if table[0] else [0]
    if min(net) == max(net) == 0:
        return 0
    return 1 if min(net) >= 0 else -1 if max(net) <= 0 else None


def _sign(
    table: tuple[dict[tuple[int, int], fmpz], tuple[int, int]], x: tuple[fmpq, fmpq], y: tuple[fmpq, fmpq]
) -> int | None:
    """Of a polynomial all over the box; None where that is not proved."""
    if not table[0]:
        return 0
    net = [c for row in bernstein.grid(table[0], x, y, table[1]) for c in row]
    return 1 if min(net) > 0 else -1 if max(net) < 0 else None
