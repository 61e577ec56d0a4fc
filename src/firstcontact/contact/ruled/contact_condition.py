"""When moving rulings meet, as a condition on u and T without v, and on T alone (`contact_condition`).

The borders of the sheets cut the plane of u and T into cells over cells of T, and the number of rulings of q that meet
the ruling u at the time T is the same throughout a cell: one rational witness tells it.  The signs of the borders tell
most cells apart; where they do not, derivatives by u are added (Thom).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations, pairwise, product
from typing import TYPE_CHECKING

from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.ruled.implicants import Signs, Term, implicants
from firstcontact.contact.signs.conditions import Conditions, Range, conditions
from firstcontact.contact.signs.exclusion import ParameterBox, Span, survivors
from firstcontact.contact.signs.fibres import Moment, RulingFibre, count
from firstcontact.contact.signs.sheets import Sheet, TooLarge, candidates, critical_times, instants, samples, sheets
from firstcontact.contact.signs.times import Times, enclosed, roots_of
from firstcontact.contact.ways import Passed, tried
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots, roots_in
from firstcontact.exact.numbers import fraction, rational, sign, simplest
from firstcontact.exact.polynomials.trivariate import (
    RING,
    FactorSet,
    at,
    coefficients,
    degree,
    embedded,
    exchanged,
    irreducible,
    resultant,
    univariate,
)
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.clocks import StraightClock
from firstcontact.motion.span import common_span
from firstcontact.result import AlgebraicNumber
from firstcontact.search.rulings.directrices import directrix_pieces

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given

ROUNDS, MOST_SLICES, MOST_PAIRS = 3, 400, 1000
"""How often polynomials are added to tell cells apart, and between how many times cells are looked at for it."""
_RELATIONS = {1: ">=", 0: "=", -1: "<="}
_ZERO = AlgebraicRoot.of(fmpq(0))
Place = tuple[AlgebraicRoot, AlgebraicRoot]
"""u and T."""
Time = Fraction | AlgebraicNumber | None
"""None: without end."""


@dataclass(frozen=True)
class OpenCell:
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

    def __init__(self, c: Conditions, times: Range, asked: tuple[int, float] | None) -> None:
        self._conditions, self._span, self.count = c, times, asked
        self._borders = _borders(c)
        own = critical_times(self._borders, c.u)
        own += [p for sheet in sheets(c) if sheet.exchanged and sheet.f is not None for p in sheet.times]
        self._critical = list({str(p): p for p in own}.values())
        self._slices = self._sliced(self._borders, self._critical)
        self._near: dict[Span, list[ParameterBox]] = {}
        """By times, where rulings may meet then."""
        self.cells: tuple[OpenCell, ...] = tuple(cell for cells in self._slices for cell in cells)

    @property
    def borders(self) -> tuple[str, ...]:
        return tuple(str(b) for b in self._borders)

    def holds(self, u: Given, T: Given) -> bool:  # noqa: N803
        """Whether it holds at numbers u and T, exactly: borders, and times outside the motion, included."""
        place, now = (AlgebraicRoot.of(rational(x, name)) for x, name in ((u, "u"), (T, "T")))
        return self._admits(count(self._conditions, place, now))

    def _admits(self, number: float) -> bool:
        if self.count is None:
            return number > 0
        return self.count[0] <= number <= self.count[1]

    def _sliced(self, borders: Sequence[fmpz_mpoly], critical: Sequence[fmpz_poly]) -> list[list[OpenCell]]:
        """The cells that the borders bound at a time between every two critical ones."""
        c, found = self._conditions, []
        for t in samples(candidates(critical, *_limits(critical, self._span)), self._span):
            now, moment, at_t, cells = AlgebraicRoot.of(t), Moment(t), c if all(c.bounded) else c.at(t), []
            walls = [univariate(at(b, 2, t), 0) for b in borders]  # positive multiples of the borders at the time
            for u in samples(roots_of(walls, c.u), c.u):
                number = count(at_t, AlgebraicRoot.of(u), now, moment)
                signs = tuple(sign(wall(u)) for wall in walls)
                cells.append(OpenCell(fraction(u), fraction(t), signs, number, self._admits(number)))
            found.append(cells)
        return found

    @cached_property
    def intervals(self) -> tuple[tuple[Time, Time], ...]:
        if self.count is not None:
            raise InputError("intervals are those of contact; ask a condition without count for them")
        c = self._conditions
        span = self._span or _limits([*(p for sheet in sheets(c) for p in sheet.times), *instants(c)], None)
        found: list[tuple[Time, Time]] = []
        for start, end in Times(c, span).windows():
            endless = [self._span is None and x.rational == y for x, y in ((start, span[0]), (end, span[1]))]
            found.append((None if endless[0] else start.number(), None if endless[1] else end.number()))
        return tuple(found)

    # -- as text --------------------------------------------------------------------------------------------

    def __str__(self) -> str:
        polynomials, terms = self._text
        names = [f"R{k + 1}" for k in range(len(polynomials))]
        if terms is None:
            used, shown = list(range(len(self._borders))), "signs of the borders do not tell all cells apart; see cells"
        else:
            used = sorted({k for term in terms for k in term})
            shown = " or ".join(
                " and ".join(f"{names[k]} {_RELATIONS[sign]} 0" for k, sign in sorted(term.items())) or "always"
                for term in terms
            ) or "never"  # fmt: skip
        lines = [shown, *(f"  {names[k]} = {polynomials[k]}" for k in used)]
        if self.count is None:
            times = tried(lambda: " or ".join(map(_time_text, self.intervals)) or "never")
            lines.append(f"for some u: {times.reason if isinstance(times, Passed) else times}")
        return "\n".join(lines)

    @cached_property
    def _text(self) -> tuple[list[fmpz_mpoly], list[Term] | None]:
        """(polynomials, borders first, the terms of the condition on their signs); None where signs do not tell.

        The terms hold at all places at which the condition holds and at no others, but for single ones; with `count`
        but for those on borders.
        """
        polynomials = [*self._borders, *(embedded(p, 2) for p in self._critical)]
        terms = _told(self._slices, self._critical)
        if terms is None and (found := self._parted()) is not None:
            own, terms = found
            names = {str(b): k for k, b in enumerate(polynomials)}
            for b in own:
                if names.setdefault(str(b), len(polynomials)) == len(polynomials):
                    polynomials.append(b)
            terms = [{names[str(own[k])]: sign for k, sign in term.items()} for term in terms]
        if terms is not None and self.count is None:
            terms = self._with_thin_parts(polynomials, terms)
        return polynomials, terms

    def _parted(self) -> tuple[list[fmpz_mpoly], list[Term]] | None:
        """(polynomials, terms) with derivatives by u (Thom), or lines, where signs of the borders do not tell."""
        c, slices, critical = self._conditions, self._slices, self._critical
        borders = FactorSet()
        for b in self._telling():
            borders.add(b)
        pool = FactorSet()
        for b in borders:
            while degree(b, 0) > 1:
                b = b.derivative(0)
                pool.add(b)
        for _ in range(ROUNDS):
            for b in _parting(_mixed_pairs(slices, critical), list(pool)):
                borders.add(b)
            critical = critical_times(list(borders), c.u)
            if len(candidates(critical, *_limits(critical, self._span))) > MOST_SLICES:
                return None
            slices = self._sliced(list(borders), critical)
            if (terms := _told(slices, critical)) is not None:
                return [*borders, *(embedded(p, 2) for p in critical)], terms
        return None

    def _telling(self) -> list[fmpz_mpoly]:
        """The borders between cells of one time that differ in the answer, and those in T alone."""
        found = [b for b in self._borders if degree(b, 0) == 0]
        for cells in self._slices:
            for x, y in pairwise(cells):
                if x.holds is not y.holds:
                    found += [b for b, one, other in zip(self._borders, x.signs, y.signs, strict=True) if one != other]
        return found

    def _with_thin_parts(self, polynomials: list[fmpz_mpoly], terms: list[Term]) -> list[Term]:
        """The terms, and those of contact on borders without any in the cells beside; polynomials may be added."""
        found = list(terms)
        for k, places in self._doubtful_places(polynomials).items():
            sides: dict[bool, list[Place]] = {True: [], False: []}
            for u, t in places:
                if not any(_satisfied(polynomials, term, u, t) for term in terms):
                    sides[self._may_meet(u, t) and count(self._conditions, u, t) > 0].append((u, t))
            if not sides[True]:
                continue  # no term is wanted; signs at irrational places are dear
            inside, outside = ([_signs(polynomials, *place) for place in sides[own]] for own in (True, False))
            for term in implicants(inside, outside) or ():
                found.append({**term, k: 0})
        return found

    def _may_meet(self, u: AlgebraicRoot, t: AlgebraicRoot) -> bool:
        """False proves, in doubles, that the ruling u meets none of q at the time."""
        (lo, hi), now = enclosed(u), enclosed(t)
        if now not in self._near:
            self._near[now] = survivors(self._conditions, now)
        return any(box.inverse[0] or (box.u[0] <= hi and lo <= box.u[1]) for box in self._near[now])

    def _doubtful_places(self, polynomials: list[fmpz_mpoly]) -> dict[int, list[Place]]:
        """By the number of a border the places on it, one on every part, at which contact may be thin."""
        c = self._conditions
        names = [str(b) for b in polynomials]
        found: dict[int, list[Place]] = {}
        doubtful = FactorSet()
        for sheet in sheets(c):
            if sheet.exchanged and sheet.f is not None:
                doubtful.add(exchanged(sheet.f))
            else:
                for b in (sheet.turned() if sheet.exchanged else sheet).doubtful_borders:
                    doubtful.add(b)
        for b in doubtful:
            if degree(b, 0):
                found[names.index(str(b))] = [
                    (x, AlgebraicRoot.of(rational(cells[0].T, "T")))
                    for cells in self._slices
                    for x in roots_of([univariate(at(b, 2, rational(cells[0].T, "T")), 0)], c.u)
                ]
        for k, b in enumerate(self._borders):
            if degree(b, 0) == 0:
                p = univariate(b, 2)
                times = real_roots(p, *_limits([p], self._span))
                found[k] = [x for t in times for x in self._at_instant(t, polynomials)]
        return found

    def _at_instant(self, t: AlgebraicRoot, polynomials: list[fmpz_mpoly]) -> list[Place]:
        """A place in every cell of the ruling parameter at one critical time."""
        c = self._conditions
        if t.rational is not None:
            own = _borders(c.at(t.rational))
            polynomials += [b for b in own if str(b) not in map(str, polynomials)]
            walls = [univariate(b, 0) for b in own]
        else:
            walls = [
                univariate(r, 0) for b in self._borders
                if not (r := resultant(embedded(t.polynomial, 2), b, 2)).is_zero()
            ]  # fmt: skip
        return [(AlgebraicRoot.of(u), t) for u in samples(roots_of(walls, c.u), c.u)]

    def __repr__(self) -> str:
        return f"<ContactCondition: {len(self._borders)} borders, {len(self.cells)} cells>"


def contact_condition(p: RuledSurface, q: RuledSurface, *, count: tuple[int, float] | None = None) -> ContactCondition:
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
    for body in (p, q):
        shape = shape_of(body)
        if not isinstance(shape, RuledSurface | RuledStrip):
            raise UnsupportedPair(f"contact_condition is for two ruled surfaces, not for {body!r}")
        if len(shape.pieces) > 1:
            raise UnsupportedPair(f"contact_condition is for single ruled pieces; give one of {shape!r}.pieces")
        if shape.pieces[0].trim:
            raise UnsupportedPair(f"contact_condition is for pieces without trim; leave that of {shape!r} out")
    moves = any(isinstance(x, Moving) for x in (p, q))
    first, last = common_span(p, q, None) if moves else (fmpq(0), fmpq(1))
    pieces = list(directrix_pieces(p, q, first, first + 1 if last is None else last))
    if len(pieces) > 1 or not isinstance(pieces[0].motion.clock, StraightClock):
        raise UnsupportedPair(
            "contact_condition needs one motion that is a rational function of the time; give a Translation or a "
            "RationalMotion, or let a directrix hold T"
        )
    span = (first, last) if moves and last is not None else None
    c = conditions(p, q, pieces[0], span)
    try:
        return ContactCondition(c, span, count)
    except TooLarge as error:
        raise TooLarge(f"contact_condition of {p!r} and {q!r}: {error}; lower their degrees") from error


def _check_count(count: tuple[int, float] | None) -> None:
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
    for p in instants(c):
        late.add(embedded(p, 2))
    for x, y in combinations([s.f for s in own if s.f is not None and not s.exchanged], 2):
        late.add(resultant(x, y, 1))
    return [*found, *(b for b in late if not found.count(b))]


def _far(sheet: Sheet) -> list[fmpz_mpoly]:
    """Where zeros of f go to infinity."""
    return irreducible(coefficients(sheet.f, 1)[-1]) if sheet.f is not None and sheet.second is None else []


def _signed(slices: Sequence[Sequence[OpenCell]], behind: Sequence[fmpz_poly]) -> Iterator[tuple[OpenCell, Signs]]:
    """All cells with their signs, and after them those of polynomials in T."""
    for cells in slices:
        t = AlgebraicRoot.of(rational(cells[0].T, "T"))
        own = tuple(t.sign_of(p) for p in behind)
        for x in cells:
            yield x, x.signs + own


def _mixed_pairs(
    slices: Sequence[Sequence[OpenCell]], critical: Sequence[fmpz_poly]
) -> list[tuple[OpenCell, OpenCell]]:
    """Cells of the same signs of which the first one holds and the other one does not."""
    sides: dict[Signs, tuple[list[OpenCell], list[OpenCell]]] = {}
    for x, signs in _signed(slices, critical):
        sides.setdefault(signs, ([], []))[not x.holds].append(x)
    return [pair for some in sides.values() for pair in product(*some)][:MOST_PAIRS]


def _parting(pairs: Sequence[tuple[OpenCell, OpenCell]], pool: Sequence[fmpz_mpoly]) -> list[fmpz_mpoly]:
    """Few polynomials whose signs part each pair at its two places: of the pool, or lines between the places."""
    u, t, found = RING.gen(0), RING.gen(2), []
    left = list(pairs)
    places = {cell: (AlgebraicRoot.of(rational(cell.u, "u")), AlgebraicRoot.of(rational(cell.T, "T")))
              for pair in left for cell in pair}  # fmt: skip
    signs = {cell: _signs(pool, *place) for cell, place in places.items()}
    while left:
        x, y = left[0]
        choices = [(b, [p for p in left if signs[p[0]][k] != signs[p[1]][k]]) for k, b in enumerate(pool)]
        for gen, name in ((u, "u"), (t, "T")):
            if (a := getattr(x, name)) != (b := getattr(y, name)):
                r = fraction(simplest(*sorted((rational((3 * a + b) / 4, name), rational((a + 3 * b) / 4, name)))))
                line = r.denominator * gen - r.numerator
                choices.append((line, [p for p in left if (getattr(p[0], name) < r) != (getattr(p[1], name) < r)]))
        best, parted = max(choices, key=lambda choice: len(choice[1]))
        found.append(best)
        left = [pair for pair in left if pair not in parted]
    return found


def _told(slices: Sequence[Sequence[OpenCell]], critical: Sequence[fmpz_poly]) -> list[Term] | None:
    """Terms in the signs of the cells, and behind them those of the critical times, that tell which cells hold."""
    for behind in ((), critical):
        sides: dict[bool, list[Signs]] = {True: [], False: []}
        for x, signs in _signed(slices, behind):
            sides[x.holds].append(signs)
        if (terms := implicants(sides[True], sides[False])) is not None:
            return terms
    return None


def _signs(polynomials: Sequence[fmpz_mpoly], u: AlgebraicRoot, t: AlgebraicRoot) -> Signs:
    """Of polynomials in u and T."""
    fibre = RulingFibre(u, t)
    return tuple(fibre.sign(b, _ZERO) for b in polynomials)


def _satisfied(polynomials: Sequence[fmpz_mpoly], term: Term, u: AlgebraicRoot, t: AlgebraicRoot) -> bool:
    signs = _signs([polynomials[k] for k in term], u, t)
    return all(s == wanted or (s == 0 and wanted != 0) for s, wanted in zip(signs, term.values(), strict=True))


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
    if start == end:
        return f"T = {shown[0]}"
    return f"{shown[0]}{' <= ' if shown[0] else ''}T{' <= ' if shown[1] else ''}{shown[1]}"
