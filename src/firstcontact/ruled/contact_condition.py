"""When moving rulings meet, as a condition on u and T without v, and on T alone (`contact_condition`).

The borders of the sheets cut the plane of u and T into cells over cells of T, and the number of rulings of q that meet
the ruling u at the time T is the same throughout a cell: one rational witness tells it.  The signs of the borders tell
most cells apart; where they do not, derivatives by u are added (Thom).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any

from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.body.moving import Moving, shape_of
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import fraction, rational
from firstcontact.exact.roots import AlgebraicRoot, roots_in
from firstcontact.exact.trivariate import (
    FactorSet,
    at,
    coefficients,
    degree,
    exchanged,
    irreducible,
    resultant,
    univariate,
)
from firstcontact.motion.clocks import StraightClock
from firstcontact.motion.directrices import directrix_pieces
from firstcontact.motion.span import common_span
from firstcontact.result import AlgebraicNumber
from firstcontact.ruled.conditions import Conditions, Range, conditions
from firstcontact.ruled.sheets import Sheet, candidates, critical_times, samples, sheets
from firstcontact.ruled.times import Times

ROUNDS = 3
"""How often derivatives are added before cells count as not told apart by signs."""
Time = Fraction | AlgebraicNumber | None
"""None: without end."""


@dataclass(frozen=True)
class Cell:
    """An open cell of the plane of u and T: a point of it, the signs of the borders, how many v meet there."""

    u: Fraction
    T: Fraction
    signs: tuple[int, ...]
    count: float
    holds: bool


class ContactCondition:
    """The condition on u and T under which the ruling u of p meets q at the time T.

    borders     polynomials in u and T, as text; their signs decide, see `str()`
    cells       all open cells
    intervals   closed times (start, end) at which some u satisfies it; None: without end
    count       (least, most) number of v, where asked for
    """

    def __init__(self, c: Conditions, times: Range, count: tuple[int, float] | None) -> None:
        self._conditions, self._span, self.count = c, times, count
        self._borders = _borders(c)
        self.cells: tuple[Cell, ...] = ()
        for _ in range(ROUNDS):
            self.cells = tuple(self._all_cells())
            mixed = self._mixed()
            if not mixed:
                break
            self._borders = _with_derivatives(self._borders)

    @property
    def borders(self) -> tuple[str, ...]:
        return tuple(str(b) for b in self._borders)

    def holds(self, u: Any, T: Any) -> bool:  # noqa: N803
        """Whether it holds at numbers u and T, exactly: borders, and times outside the motion, included."""
        return self._admits(_count(self._conditions, rational(u, "u"), rational(T, "T")))

    def _admits(self, count: float) -> bool:
        if self.count is None:
            return count > 0
        return self.count[0] <= count <= self.count[1]

    def _all_cells(self) -> list[Cell]:
        c = self._conditions
        roots = candidates(critical_times(self._borders, c.u), *_limits(critical_times(self._borders, c.u), self._span))
        found = []
        for t in samples(roots, self._span):
            walls = fmpz_poly([1])
            for b in self._borders:
                walls = walls * univariate(at(b, 2, t), 0)
            for u in samples(roots_in(walls, c.u), c.u):
                signs = tuple(_sign(b, u, t) for b in self._borders)
                count = _count(c, u, t)
                found.append(Cell(fraction(u), fraction(t), signs, count, self._admits(count)))
        return found

    def _mixed(self) -> set[tuple[int, ...]]:
        """Sign vectors of cells that differ in the answer."""
        inside, outside = ({x.signs for x in self.cells if x.holds is value} for value in (True, False))
        return inside & outside

    @cached_property
    def intervals(self) -> tuple[tuple[Time, Time], ...]:
        if self.count is not None:
            raise InputError("intervals are those of contact; ask a condition without count for them")
        c = self._conditions
        span = self._span or _limits([p for sheet in sheets(c) for p in sheet.times], None)
        found: list[tuple[Time, Time]] = []
        for start, end in Times(c, span).windows():
            endless = [self._span is None and x.rational == y for x, y in ((start, span[0]), (end, span[1]))]
            found.append((None if endless[0] else start.number(), None if endless[1] else end.number()))
        return tuple(found)

    def __str__(self) -> str:
        names = [f"R{k + 1}" for k in range(len(self._borders))]
        terms = self._implicants()
        used = sorted({k for term in terms for k in term})
        lines = [" or ".join(
            " and ".join(f"{names[k]} {'>=' if sign > 0 else '<='} 0" for k, sign in sorted(term.items())) or "always"
            for term in terms) or "never"]  # fmt: skip
        if self._mixed():
            lines = ["signs of the borders do not tell all cells apart; see cells"]
        lines += [f"  {names[k]} = {self._borders[k]}" for k in used]
        if self.count is None:
            lines.append("for some u: " + (" or ".join(_time_text(x) for x in self.intervals) or "never"))
        return "\n".join(lines)

    def _implicants(self) -> list[dict[int, int]]:
        """Conjunctions of signs whose union holds exactly the accepted sign vectors among all cells."""
        inside, outside = ({x.signs for x in self.cells if x.holds is value} for value in (True, False))
        keep = list(range(len(self._borders)))
        for k in reversed(range(len(self._borders))):  # the last ones are the least telling
            rest = [i for i in keep if i != k]
            if not {_part(x, rest) for x in inside} & {_part(x, rest) for x in outside}:
                keep = rest
        found: list[dict[int, int]] = []
        for signs in sorted({_part(x, keep) for x in inside}):
            term = dict(zip(keep, signs, strict=True))
            for k in keep[::-1]:
                rest_of = {i: s for i, s in term.items() if i != k}
                if not any(all(x[i] == s for i, s in rest_of.items()) for x in outside):
                    term = rest_of
            if term not in found:
                found.append(term)
        return found

    def __repr__(self) -> str:
        return f"<ContactCondition: {len(self._borders)} borders, {len(self.cells)} cells>"


def contact_condition(p: Any, q: Any, *, count: tuple[int, float] | None = None) -> ContactCondition:
    """The condition on u and T, without v, under which the ruling u of p meets q at the time T.

    p, q: RuledSurface, one of them deforming or moving; their motions must be rational functions of the time in one
    piece.  count: (least, most) number of rulings v of q that the ruling u shall meet, instead of at least one.  T is
    any real number, within the span of the motions where they have one.

    >>> import firstcontact as fc
    >>> rising = fc.RuledSurface("(u, -1, u**2 + T)", "(u, 1, u**2 + T)", u=(-2, 2))
    >>> floor = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1))
    >>> condition = fc.contact_condition(rising, floor)
    >>> condition.holds("1/2", "-1/4"), condition.holds("1/2", 0)
    (True, False)
    """
    _check_count(count)
    moves = any(isinstance(x, Moving) for x in (p, q))
    first, last = common_span(p, q, None) if moves else (fmpq(0), fmpq(1))
    if any(len(shape_of(x).pieces) > 1 for x in (p, q)):
        raise UnsupportedPair("contact_condition is for single ruled pieces; give one of strip.pieces")
    if any(shape_of(x).trim for x in (p, q)):
        raise UnsupportedPair("contact_condition is for pieces bounded by u and s alone; leave trim out")
    pieces = list(directrix_pieces(p, q, first, first + 1 if last is None else last))
    if len(pieces) > 1 or not isinstance(pieces[0].motion.clock, StraightClock):
        raise UnsupportedPair("contact_condition needs one motion that is a rational function of the time")
    span = (first, last) if moves and last is not None else None
    c = conditions(p, q, pieces[0], span or (first, first + 1))
    return ContactCondition(c, span, count)


def _check_count(count: Any) -> None:
    if count is None:
        return
    try:
        least, most = count
        good = 0 <= least <= most
    except (TypeError, ValueError):
        good = False
    if not good:
        raise InputError(f"count is {count!r}; give (least, most) numbers of rulings")


def _borders(c: Conditions) -> list[fmpz_mpoly]:
    """Of all sheets together, those that tell most first: folds and ends of segments, then what goes to infinity."""
    found = FactorSet()
    late = FactorSet()
    own = [s.turned() if s.exchanged and s.f is None else s for s in sheets(c)]
    for sheet in own:
        if sheet.exchanged:
            assert sheet.f is not None
            found.add(exchanged(sheet.f))  # its rulings meet q on a curve of the plane only
            continue
        far = {str(g) for g in _far(sheet)}
        for b in sheet.borders:
            (late if str(b) in far else found).add(b)
    for x, y in combinations([s.f for s in own if s.f is not None and not s.exchanged], 2):
        late.add(resultant(x, y, 1))
    return [*found, *(b for b in late if not found.count(b))]


def _far(sheet: Sheet) -> list[fmpz_mpoly]:
    """Where zeros of f go to infinity."""
    return irreducible(coefficients(sheet.f, 1)[-1]) if sheet.f is not None and sheet.second is None else []


def _with_derivatives(borders: Sequence[fmpz_mpoly]) -> list[fmpz_mpoly]:
    found = FactorSet()
    for b in borders:
        found.add(b)
    for b in borders:
        if degree(b, 0) > 1:
            found.add(b.derivative(0))
    return list(found)


def _count(c: Conditions, u: fmpq, t: fmpq) -> float:
    """How many v meet the ruling u at the time t; infinite for a range of them."""
    if c.u is not None and not c.u[0] <= u <= c.u[1]:
        return 0

    def over(conditions: Conditions, y: AlgebraicRoot) -> bool:
        return conditions.holds(lambda f: y.sign_of(univariate(at(at(f, 2, t), 0, u), 1)))

    found = 0
    if c.v is None:  # v = infinity
        found += over(c.charts[False, True], AlgebraicRoot.of(fmpq(0)))
    f = univariate(at(at(c.delta, 2, t), 0, u), 1)
    if not f.is_zero():
        return found + sum(over(c, y) for y in roots_in(f, c.v))
    walls = fmpz_poly([1])
    for x in [x for pair in c.pairs for x in pair] + [x for axis in c.axes for x in axis]:
        g = univariate(at(at(x, 2, t), 0, u), 1)
        walls = walls if g.is_zero() else walls * g
    critical = roots_in(walls, c.v)
    if any(over(c, AlgebraicRoot.of(y)) for y in samples(critical, c.v)):
        return math.inf
    return found + sum(over(c, y) for y in critical)


def _sign(b: fmpz_mpoly, u: fmpq, t: fmpq) -> int:
    value = univariate(at(b, 2, t), 0)(u)
    return (value > 0) - (value < 0)


def _part(signs: Sequence[int], indices: Sequence[int]) -> tuple[int, ...]:
    return tuple(signs[k] for k in indices)


def _limits(polynomials: Sequence[fmpz_poly], span: Range) -> tuple[fmpq, fmpq]:
    """The span, or one that holds all real roots in its interior."""
    if span is not None:
        return span
    bound = fmpq(1)
    for p in polynomials:
        bound = max(bound, fmpq(2) + max(abs(c) for c in p.coeffs()) // abs(p.leading_coefficient()))
    return -bound, bound


def _time_text(window: tuple[Time, Time]) -> str:
    start, end = window
    if isinstance(start, AlgebraicNumber) and isinstance(end, AlgebraicNumber) and start.polynomial == end.polynomial:
        f = fmpz_poly(list(start.polynomial))
        if len(roots_in(f, None)) == 2:
            sign = "<=" if f.leading_coefficient() > 0 else ">="
            text = str(f).replace("x", "T").replace("+ (-", "- ").replace(")", "")
            return f"{text} {sign} 0"
    shown = ["" if x is None else str(getattr(x, "closed_form", None) or x) for x in window]
    if start is None and end is None:
        return "always"
    return f"{shown[0]}{' <= ' if shown[0] else ''}T{' <= ' if shown[1] else ''}{shown[1]}"
