"""The times at which contact of two ruled pieces may begin or end, by elimination.

For one factor f of Delta, the admissible (u, v, T) on f = 0 project along v to a region of the plane of u and T.  Off
the *borders* (the discriminant of f, and where a zero of f leaves the range of v or meets a zero of a bracket) nothing
changes, so the region is a union of cells of their arrangement.  Off the times at which the borders have an extremum, a
crossing or an end, nothing changes among the cells.  This is the projection of cylindrical algebraic decomposition with
an equational constraint, one factor at a time.  Factors without v take u for the variable that goes first; where Delta
is zero everywhere, all brackets together take the place of f.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, cmp_to_key
from itertools import combinations
from typing import NamedTuple

from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.contact.signs.conditions import Conditions, Range, SignConditions
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots, roots_in
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.polynomials.trivariate import (
    FactorSet,
    at,
    coefficients,
    degree,
    discriminant,
    exchanged,
    irreducible,
    product,
    resultant,
    univariate,
)

Pairs = tuple[tuple[fmpz_mpoly, fmpz_mpoly], ...]


class Reach(NamedTuple):
    """How far elimination may lead: the degree of equations for times, and the bits of all their coefficients together.

    Both as far as they can be foreseen; bits None: any.  per_step: degrees of borders for which deciding a time counts
    as a step, for that takes as long; None: it is one step always.
    """

    degree: int
    bits: int | None = None
    per_step: int | None = None

    def steps(self, own: Sequence[Sheet]) -> int:
        """What the decision of one time counts as."""
        if self.per_step is None:
            return 1
        return max(1, sum(degree(b, 0) for sheet in own for b in sheet.borders) // self.per_step)


QUICK, FARTHER, FARTHEST = Reach(400, 30_000, 8), Reach(400, 300_000, 8), Reach(400)
"""Equations of degree 230 take a third of a second, those of 100,000 bits a tenth of one."""


class TooLarge(UnsupportedPair):
    """Elimination would lead to equations of too high a degree."""


@dataclass(frozen=True)
class Sheet:
    """One factor of Delta, or all brackets where that vanishes.

    f           the factor; None where Delta is zero
    clips       irreducible polynomials at whose zeros on f = 0 (among which, without f) contact may change
    pairs       those of the conditions that decide off the borders; None for all conditions
    exchanged   u and v have changed places in all polynomials here
    first, second   ranges of the parameter that stays (here always u) and of the one that goes (v)
    reach           how far elimination may lead
    may_be_thin     whether trimming inequalities may hold on curves alone
    """

    f: fmpz_mpoly | None
    clips: tuple[fmpz_mpoly, ...]
    pairs: Pairs | None
    exchanged: bool
    first: Range
    second: Range
    reach: Reach = FARTHEST
    may_be_thin: bool = False

    @cached_property
    def borders(self) -> list[fmpz_mpoly]:
        """Irreducible polynomials in u and T."""
        return [b for b in self._border_factors if _may_vanish(b, self.first)]

    @property
    def may_touch(self) -> bool:
        """Whether isolated contacts may last: False proves that beside every contact on a border there are others.

        Where a border is a simple factor of one condition alone, f = 0 folds there, or one end of a segment or of a
        range passes, and contact lies on one side of it.
        """
        return bool(self.doubtful_borders)

    @property
    def doubtful_borders(self) -> list[fmpz_mpoly]:
        """Those on which there may be contact without any on their sides."""
        if self.may_be_thin:
            return self.borders
        return [b for b in self.borders if self._border_factors.count(b) + self._is_end(b) > 1]

    def _is_end(self, b: fmpz_mpoly) -> bool:
        """Whether a border lies at an end of the first range."""
        return self.first is not None and any(at(b, 0, end).is_zero() for end in self.first)

    @cached_property
    def _border_factors(self) -> FactorSet:
        found = FactorSet()
        walls = [self.f] if self.f is not None else list(self.clips)
        for g in walls:
            for h in self._edges(g):
                found.add(h)
        pairs = [(self.f, c) for c in self.clips] if self.f is not None else combinations(self.clips, 2)
        for g, h in pairs:
            r = _eliminated(g, h, 1, self.reach)
            if not r.is_zero():
                found.add(r)
        return found

    def _edges(self, g: fmpz_mpoly) -> Iterable[fmpz_mpoly]:
        if degree(g, 1) == 0:
            yield g
            return
        yield _eliminated(g, None, 1, self.reach)
        if self.second is None:
            yield coefficients(g, 1)[-1]
            return
        for end in self.second:
            value = at(g, 1, end)
            if not value.is_zero():
                yield value

    @property
    def times(self) -> list[fmpz_poly]:
        """Irreducible polynomials in T: outside their roots contact does not change on this sheet.

        Isolated contacts that last lie on borders of both projections; the times of the second one are for them.
        """
        if not self.may_touch or (self.f is not None and degree(self.f, 0) == 0):
            return self._own_times
        return self._own_times + self.turned()._own_times

    def turned(self) -> Sheet:
        """The same with the parameters in the other order."""
        f = None if self.f is None else exchanged(self.f)
        clips = tuple(exchanged(x) for x in self.clips)
        return Sheet(f, clips, None, not self.exchanged, self.second, self.first, self.reach, self.may_be_thin)

    @cached_property
    def _own_times(self) -> list[fmpz_poly]:
        return critical_times(self.borders, self.first, self.reach)


def critical_times(
    borders: Sequence[fmpz_mpoly], ends: Range, reach: Reach = FARTHEST
) -> list[fmpz_poly]:
    """Irreducible polynomials in T; outside their roots the borders' zeros in the range of u keep their order."""
    found = FactorSet()
    curves = [b for b in borders if degree(b, 0)]
    for b in borders:
        if degree(b, 0) == 0:
            found.add(b)
            continue
        found.add(_eliminated(b, None, 0, reach))
        if ends is None:
            found.add(coefficients(b, 0)[-1])
            continue
        for end in ends:
            value = at(b, 0, end)
            if not value.is_zero():
                found.add(value)
    for b, c in combinations(curves, 2):
        found.add(_eliminated(b, c, 0, reach))
    return [univariate(g, 2) for g in found if degree(g, 2)]


def sheets(c: SignConditions, reach: Reach = FARTHEST) -> list[Sheet]:
    """All sheets of the conditions; their times, and those of `instants`, are all at which contact may change."""
    if c.delta.is_zero():
        everything = FactorSet()
        for x in c.walls:
            if not x.is_zero():
                everything.add(x)
        own = _real(everything, c)
        return [_lighter(Sheet(None, tuple(own), None, False, c.u, c.v, reach, c.may_be_thin))]
    assert isinstance(c, Conditions)
    all_sheets = []
    for f in _real(irreducible(c.delta), c):
        if degree(f, 0) == degree(f, 1) == 0:
            continue  # an instant
        clips, pairs = _clips(c, f, reach)
        if degree(f, 1):
            all_sheets.append(Sheet(f, tuple(clips), pairs, False, c.u, c.v, reach, c.may_be_thin))
        else:
            turned = tuple(exchanged(x) for x in clips)
            all_sheets.append(Sheet(exchanged(f), turned, None, True, c.v, c.u, reach, c.may_be_thin))
    return all_sheets


def _lighter(sheet: Sheet) -> Sheet:
    """The sheet, or the same with the parameters in the other order, which elimination leads less far."""
    weights: list[tuple[int, Sheet]] = []
    for own in (sheet, sheet.turned()):
        try:
            weights.append((sum(int(b.total_degree()) for b in own.borders), own))
        except TooLarge as reason:
            refusal = reason
    if not weights:
        raise refusal
    return min(weights, key=lambda x: x[0])[1]


def instants(c: SignConditions) -> list[fmpz_poly]:
    """Polynomials in T at whose roots Delta vanishes for all u and v."""
    if c.delta.is_zero():
        return []
    return [univariate(f, 2) for f in irreducible(c.delta) if degree(f, 0) == degree(f, 1) == 0]


def candidates(polynomials: Iterable[fmpz_poly], lo: fmpq, hi: fmpq) -> list[AlgebraicRoot]:
    """All their roots in [lo, hi], each once, ascending."""
    roots: dict[str, list[AlgebraicRoot]] = {}
    for p in polynomials:
        roots.setdefault(str(p), real_roots(p, lo, hi))
    return sorted((x for some in roots.values() for x in some), key=cmp_to_key(AlgebraicRoot.compare))


def _clips(c: Conditions, f: fmpz_mpoly, reach: Reach) -> tuple[list[fmpz_mpoly], Pairs | None]:
    """The polynomials that decide on f = 0, and the pairs they are of.

    Brackets of one auxiliary point off the common plane of the rulings do.  Where all brackets of all points vanish
    along a border, rulings may be one line: then all of them count, and the coordinates.
    """
    found = FactorSet()
    choices = []
    for k in range(3):
        pair_factors = [[] if x.is_zero() else irreducible(x) for pair in c.ends(k) for x in pair]
        zero = [x.is_zero() for pair in c.ends(k) for x in pair]
        decisive = [some for some, z in zip(pair_factors, zero, strict=True) if not z and all(g != f for g in some)]
        if decisive:
            cost = sum(sum(int(d) for d in g.degrees()) for some in pair_factors for g in some)
            choices.append((cost, k, pair_factors, decisive))
    brackets = [some for choice in sorted(choices, key=lambda choice: choice[:2]) for some in choice[3]]
    if not choices or _share_borders(f, brackets, c, reach):
        for x in [x for pair in c.pairs for x in pair] + [x for axis in c.axes for x in axis]:
            if not x.is_zero():
                found.add(x)
        return [g for g in _real(found, c) if g != f], None
    _, k, pair_factors, _ = min(choices, key=lambda choice: choice[:2])
    for some in pair_factors:
        for g in some:
            found.add(g)
    for g, _ in c.cuts(k):
        if not g.is_zero():
            found.add(g)
    return [g for g in _real(found, c) if g != f], (*c.ends(k), *c.cuts(k))


def _share_borders(f: fmpz_mpoly, brackets: list[list[fmpz_mpoly]], c: Conditions, reach: Reach) -> bool:
    """Whether all brackets, given by their factors, may vanish together along a curve on f = 0."""
    index = 1 if degree(f, 1) else 0
    common: fmpz_mpoly | None = None
    for some in brackets:
        r = product(_eliminated(f, g, index, reach) for g in some)
        common = r if common is None else common.gcd(r)
        if common.is_constant():
            return False
    assert common is not None
    return any(_may_vanish(b if index else exchanged(b), c.u if index else c.v) for b in irreducible(common))


def _real(polynomials: Iterable[fmpz_mpoly], c: SignConditions) -> list[fmpz_mpoly]:
    """Those that may vanish within the ranges."""
    return [f for f in polynomials if _may_vanish(f, c.u) and _may_vanish(exchanged(f), c.v)]


def _may_vanish(b: fmpz_mpoly, ends: Range) -> bool:
    """False proves that a polynomial in u alone has no zero in the range; others may have."""
    if degree(b, 1) or degree(b, 2):
        return True
    p = univariate(b, 0)
    return bool(roots_in(p, ends))


def _longest(f: fmpz_mpoly) -> int:
    """Bits of the largest coefficient."""
    return max((int(c).bit_length() for c in f.coeffs()), default=0)


def _eliminated(g: fmpz_mpoly, h: fmpz_mpoly | None, index: int, reach: Reach) -> fmpz_mpoly:
    """The resultant of g and h, without h the discriminant of g; TooLarge where that leads too far."""
    m, n = degree(g, index), degree(h, index) if h is not None else degree(g, index) - 1
    other = g if h is None else h
    u, t = (m * degree(other, k) + n * degree(g, k) for k in (0, 2))
    # Eliminating u too doubles the product of the degrees.
    expected = t if index == 0 else 2 * u * t
    bits = 0 if reach.bits is None else expected * (m * _longest(other) + n * _longest(g))
    if min(m, n) > 0 and (expected > reach.degree or bits > (reach.bits or 0)):
        raise TooLarge(f"too large for elimination: equations of degree {expected} for the times of contact")
    return discriminant(g, index) if h is None else resultant(g, h, index)


def samples(p: Sequence[AlgebraicRoot], ends: Range) -> list[fmpq]:
    """One rational number in every open cell between consecutive roots, and between them and the ends."""
    if ends is None:
        if not p:
            return [fmpq(0)]
        lo, hi = p[0].lo - 1, p[-1].hi + 1
        return [lo, *(between(x, y) for x, y in zip(p, p[1:], strict=False)), hi]
    a, b = AlgebraicRoot.of(ends[0]), AlgebraicRoot.of(ends[1])
    walls = [a, *(x for x in p if x.compare(a) > 0 and x.compare(b) < 0), b]
    return [between(x, y) for x, y in zip(walls, walls[1:], strict=False)]


def between(x: AlgebraicRoot, y: AlgebraicRoot) -> fmpq:
    """A short rational number strictly between two roots, x < y."""
    bits = 32
    while True:
        with precision(bits):
            lo = x.hi if x.rational is not None else dyadic(x.enclosure(bits).upper())
            hi = y.lo if y.rational is not None else dyadic(y.enclosure(bits).lower())
        if lo < hi:
            return dyadic_between(lo, hi)
        bits *= 2


def dyadic_between(lo: fmpq, hi: fmpq) -> fmpq:
    """The dyadic number of least size strictly between lo < hi."""
    scale = fmpq(1)
    while scale * (hi - lo) <= 2:
        scale *= 2
    n = (scale * (lo + hi) / 2).floor()
    while True:
        x = n / scale
        if lo < x < hi:
            return x
        n = n + 1
