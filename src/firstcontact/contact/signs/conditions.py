"""When two rulings share a point: signs of polynomials in u, v and T.

With W > 0, the segments P1(u)P2(u) and Q1(v)Q2(v) share a point exactly when Delta = 0, for each of three auxiliary
points e the ends of either segment are not strictly on one side of the plane of the other line and e, and, where all
these brackets vanish, because the lines are one or a ruling is a point, on no axis are all of Q's ends strictly on one
side of P's.  Whole lines drop the conditions on their own ends.  Trimming inequalities stand with the place on the
ruling, a ratio of brackets, put in.  All inequalities are weak: contact is closed.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from math import comb
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np
from flint import fmpq, fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.body.ruled.rational_curve import RationalCurve, lifted
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.signs.forced import forced_equation
from firstcontact.contact.signs.pieces import at_place, range_of
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.fields.roots import roots_in
from firstcontact.exact.numbers import rational
from firstcontact.exact.polynomials.trivariate import RING, FactorSet, at, degree, irreducible, product, univariate
from firstcontact.motion.moving import shape_of
from firstcontact.pairs.ruled_ruled import DUAL, PAIRS
from firstcontact.search.rulings.directrices import DirectrixPiece

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Range = tuple[fmpq, fmpq] | None
"""Closed range of a parameter; None for the projective line."""
Sides = tuple[RationalCurve, RationalCurve]
Trims = tuple[dict[tuple[int, int], Any], ...]
"""Polynomials in u and s, as whole coefficients of u^i s^j; kept is where none is negative."""
Pair = tuple[fmpz_mpoly, fmpz_mpoly]

_MINUS_ONE = RING.constant(-1)


class SignConditions(Protocol):
    """What tells from signs of polynomials in u, v and T whether a place (u, v) counts at a time.

    delta        zero wherever one does; zero altogether where there is no such equation
    polynomials  all that count, delta first
    walls        those of them that may vanish where places count
    """

    @property
    def delta(self) -> fmpz_mpoly: ...
    @property
    def polynomials(self) -> list[fmpz_mpoly]: ...
    @property
    def walls(self) -> list[fmpz_mpoly]: ...
    @property
    def u(self) -> Range: ...
    @property
    def v(self) -> Range: ...
    @property
    def may_be_thin(self) -> bool: ...
    @property
    def known(self) -> dict[str, Any]: ...
    @property
    def charts(self) -> Mapping[tuple[bool, bool], Self]: ...

    def holds(self, sign: Callable[[fmpz_mpoly], int], on_delta: bool = False) -> bool: ...
    def excludes(self, above: np.ndarray, below: np.ndarray) -> np.ndarray: ...
    def at(self, t: fmpq) -> Self: ...


@dataclass(frozen=True)
class Conditions:
    """Of one piece of the motion; polynomials of the ring of u, v and T.

    delta      zero where the lines meet; where all do, what the ends of rulings force to be zero, if anything
    brackets   rows [P1P2Q1 e], [P1P2Q2 e], [P1Q1Q2 e], [P2Q1Q2 e], columns e = X, Y, Z: t = 0, t = 1, s = 0, s = 1 are
               their zeros on delta = 0
    axes       for x, y, z: the coordinates of P1 and P2 less those of Q1 and Q2, up to positive factors
    u, v       ranges of the parameters
    bounded    whether the rulings of P and of Q are segments
    sides      the curves they come from
    """

    delta: fmpz_mpoly
    brackets: tuple[tuple[fmpz_mpoly, ...], ...]
    axes: tuple[tuple[fmpz_mpoly, ...], ...]
    u: Range
    v: Range
    bounded: tuple[bool, bool]
    sides: tuple[Sides, Sides]
    trims: tuple[Trims, Trims] = ((), ())
    """Of P in u and s, of Q in v and t, with s and t from 0 to 1 on bounded rulings."""
    kept: tuple[tuple[fmpz_mpoly, ...], ...] = ((), (), ())
    """Polynomials that are not negative where the trimming inequalities hold; for each auxiliary point, off the common
    plane of the rulings."""
    trimmed: str = ""
    """What error texts call the trimmed pieces."""
    forced: bool = False
    """Whether delta is such an equation, on which contact may be on curves alone."""
    moment: fmpq | None = None
    """Of conditions at one time, whose curves still move."""
    known: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    """What was worked out of them."""

    @cached_property
    def pairs(self) -> list[Pair]:
        """Two polynomials that are not both positive or both negative where rulings share a point."""
        return [pair for k in range(3) for pair in (*self.ends(k), *self.cuts(k))]

    @cached_property
    def polynomials(self) -> list[fmpz_mpoly]:
        """All whose signs the conditions ask for: delta, both of every pair, then the axes."""
        axes = [x for axis in self.axes for x in axis] if all(self.bounded) else []
        return [self.delta, *(x for pair in self.pairs for x in pair), *axes]

    @property
    def walls(self) -> list[fmpz_mpoly]:
        return self.polynomials

    def excludes(self, above: np.ndarray, below: np.ndarray) -> np.ndarray:
        """(n,): on which of n boxes no rulings meet; (n, k): which polynomials are positive, which negative there."""
        out: np.ndarray = above[:, 0] | below[:, 0]
        last = 1 + 2 * len(self.pairs)
        for signs in (above, below):
            groups = [signs[:, 1:last].reshape(len(out), -1, 2)]
            if all(self.bounded):
                groups.append(signs[:, last:].reshape(len(out), 3, 4))
            for group in groups:
                out |= np.any(np.all(group, axis=2), axis=1)
        return out

    def ends(self, k: int) -> list[Pair]:
        """Of those, the ones of one auxiliary point that are for the ends of rulings."""
        d1, d2, d3, d4 = (row[k] for row in self.brackets)
        return ([(d1, d2)] if self.bounded[1] else []) + ([(d3, d4)] if self.bounded[0] else [])

    def cuts(self, k: int) -> list[Pair]:
        """Of those, the ones of one auxiliary point that are for trimming."""
        return [(f, _MINUS_ONE) for f in self.kept[k]]

    @cached_property
    def may_be_thin(self) -> bool:
        """False proves that no trimming inequality leaves parts of a piece without area, and delta is not forced."""
        if self.forced:
            return True
        ranges = [(ends, own) for ends, own in zip((self.u, self.v), self.bounded, strict=True)]
        return any(some and not bound_once(some, *rest) for some, rest in zip(self.trims, ranges, strict=True))

    def holds(self, sign: Callable[[fmpz_mpoly], int], on_delta: bool = False) -> bool:
        """Whether rulings share a point, from the signs there; on_delta: that of delta is known to be 0."""
        if not on_delta and sign(self.delta) != 0:
            return False
        one_line = True
        for k in range(3):
            for x, y in self.ends(k):
                one, other = sign(x), sign(y)
                if one * other > 0:
                    return False
                one_line = one_line and one == other == 0
            if any(sign(f) < 0 for f in self.kept[k]):
                return False
        if not one_line or not all(self.bounded):
            return True
        shared = all(abs(sum(map(sign, axis))) < 4 for axis in self.axes)
        if shared and any(j for some in self.trims for g in some for _, j in g):
            raise UnsupportedPair(
                f"{self.trimmed}: where rulings of a trimmed piece lie on one line with others, or are a point, "
                "contact is not decided; leave out trim, or move a body a little"
            )
        return shared

    def at(self, t: fmpq) -> Conditions:
        """The conditions at one time."""
        if not all(self.bounded):  # whole rulings lose what their coordinates have in common then
            p, q = ((x.projective_at(t), y.projective_at(t)) for x, y in self.sides)
            now = _conditions(p, q, self.u, self.v, self.bounded, self.trims)
            return replace(now, trimmed=self.trimmed, moment=t)
        return replace(
            self,
            delta=at(self.delta, 2, t),
            brackets=tuple(tuple(at(x, 2, t) for x in row) for row in self.brackets),
            axes=tuple(tuple(at(x, 2, t) for x in row) for row in self.axes),
            kept=tuple(tuple(at(x, 2, t) for x in row) for row in self.kept),
            moment=t,
            known={},
        )

    @cached_property
    def charts(self) -> dict[tuple[bool, bool], Conditions]:
        """Over finite ranges, by whether they are conditions on 1/u, on 1/v: projective parameters have two parts."""
        if self.u is not None and self.v is not None:
            return {(False, False): self}
        p, q = self.sides
        unit = fmpq(-1), fmpq(1)
        found = {(False, False): replace(self, u=self.u or unit, v=self.v or unit, known={})}
        for inverse_u in (False, True) if self.u is None else (False,):
            for inverse_v in (False, True) if self.v is None else (False,):
                if not inverse_u and not inverse_v:
                    continue
                first = (p[0].reversed(), p[1].reversed()) if inverse_u else p
                second = (q[0].reversed(), q[1].reversed()) if inverse_v else q
                own = reversed_trims(self.trims[0]) if inverse_u else self.trims[0]
                other = reversed_trims(self.trims[1]) if inverse_v else self.trims[1]
                chart = _conditions(first, second, self.u or unit, self.v or unit, self.bounded, (own, other))
                chart = replace(chart, trimmed=self.trimmed)
                found[inverse_u, inverse_v] = chart if self.moment is None else chart.at(self.moment)
        return found


def conditions(a: Body, b: Body, piece: DirectrixPiece, span: Range) -> Conditions:
    """The conditions of two ruled pieces over one piece of their relative motion, whose parameter is in `span`.

    None: it may be any number.
    """
    p, q = (_shape(body) for body in (a, b))
    bounded = p.s is not None, q.s is not None
    if not any(bounded):
        raise UnsupportedPair(
            f"{p!r} and {q!r} both have whole rulings: they may meet at infinity only; bound s of one of them"
        )
    for surface, sides in ((p, piece.p), (q, piece.q)):
        if surface.s is not None:
            for side in sides:
                check_weight(surface, side, span)
    found = _conditions(piece.p, piece.q, range_of(p.u), range_of(q.u), bounded, (local_trims(p), local_trims(q)))
    return replace(found, trimmed=" and ".join(repr(x) for x in (p, q) if x.trim))


def local_trims(surface: RuledSurface) -> Trims:
    """The trimming polynomials, with s counted from 0 to 1 where it is bounded, up to positive factors."""
    lo, hi = (fmpq(0), fmpq(1)) if surface.s is None else (rational(x, "s") for x in surface.s)
    found = []
    for trim in surface.trim:
        table: dict[tuple[int, int], fmpq] = {}
        for (i, j), c in _terms2(trim.polynomial).items():
            for m in range(j + 1):
                term = fmpq(int(c) * comb(j, m)) * lo ** (j - m) * (hi - lo) ** m
                table[i, m] = table.get((i, m), fmpq(0)) + term
        below = reduce(fmpz.lcm, (c.q for c in table.values()), fmpz(1))
        found.append({key: (c * below).p for key, c in table.items() if c})
    return tuple(found)


def bound_once(trims: Trims, ends: Range, bounded: bool) -> bool:
    """Whether every factor of the inequalities is simple, and no border of another one or of the ranges."""
    u, s = RING.gen(0), RING.gen(1)
    found = FactorSet()
    for f in [*polynomials(trims), *(end.q * u - end.p for end in ends or ()), *((s, s - 1) if bounded else ())]:
        found.add(f)
    return all(found.count(f) == 1 for f in found)


def polynomials(trims: Trims) -> list[fmpz_mpoly]:
    """In u and, for s, v."""
    return [RING.from_dict({(i, j, 0): int(c) for (i, j), c in g.items()}) for g in trims]


def reversed_trims(trims: Trims) -> Trims:
    """The same in the inverse of the first parameter."""
    found = []
    for g in trims:
        top = _even(max((i for i, _ in g), default=0))
        found.append({(top - i, j): c for (i, j), c in g.items()})
    return tuple(found)


def _even(n: int) -> int:
    return n + n % 2


def _shape(body: Body) -> RuledSurface:
    shape = shape_of(body)
    assert isinstance(shape, RuledSurface)
    return shape


def check_weight(surface: RuledSurface, side: RationalCurve, span: Range) -> None:
    """InputError unless the weight is positive over the range and the span; None: at all times."""
    if not any(key[1] for key in _terms2(side.components[3])):
        return  # surfaces prove it for weights without T
    from firstcontact.exact.polynomials import bernstein

    unit = fmpq(-1), fmpq(1)
    charts = [(side, range_of(surface.u))] if surface.u else [(side, unit), (side.reversed(), unit)]
    for curve, ends in charts:
        table = _terms2(curve.components[3])
        assert ends is not None
        boxes = [(table, ends, span or unit, 0)]
        if span is None:
            boxes.append((_late(table), ends, unit, 0))
        size = max(i for i, _ in table), _even(max(j for _, j in table))
        while boxes:
            table, u, t, depth = boxes.pop()
            if min(c for row in bernstein.grid(table, u, t, size) for c in row) > 0:
                continue
            if depth == 6:
                when, cure = (" of the span", "u or the span") if span else (", and any may be asked for", "u")
                raise InputError(
                    f"{surface!r}: a directrix seems to have a pole at some time{when}; shorten {cure}"
                )
            x, y = (u[0] + u[1]) / 2, (t[0] + t[1]) / 2
            boxes += [(table, a, b, depth + 1) for a in ((u[0], x), (x, u[1])) for b in ((t[0], y), (y, t[1]))]


def _late(table: dict[tuple[int, int], fmpz]) -> dict[tuple[int, int], fmpz]:
    """In 1/T, times an even power of T."""
    top = _even(max(j for _, j in table))
    return {(i, top - j): c for (i, j), c in table.items()}


def _terms2(p: fmpz_mpoly | fmpz_poly) -> dict[tuple[int, int], fmpz]:
    from firstcontact.body.ruled.rational_curve import terms as of_curve

    return of_curve(p)


def _conditions(
    p: Sides, q: Sides, u: Range, v: Range, bounded: tuple[bool, bool], trims: tuple[Trims, Trims]
) -> Conditions:
    p1, p2 = (lifted(curve.components, RING, "u") for curve in p)
    q1, q2 = (lifted(curve.components, RING, "v") for curve in q)
    line_p, line_q = _line(p1, p2, bounded[0]), _line(q1, q2, bounded[1])
    of_p, of_q = _planes(line_p), _planes(line_q)
    delta = _sum(x * line_q[j] * sign for x, (j, sign) in zip(line_p, DUAL, strict=True))
    factors = [] if delta.is_zero() else irreducible(delta)
    weights = [w for curve in (p1, p2, q1, q2) if not curve[3].is_zero() for w in irreducible(curve[3])]
    positive = {str(f): f for f in [*factors, *weights] if is_definite(f)}
    definite = positive.values()
    ends = tuple(
        tuple(_sum(x * row[k] for x, row in zip(end, planes, strict=True)) for k in range(3))
        for end, planes in ((q1, of_p), (q2, of_p), (p1, of_q), (p2, of_q))
    )
    brackets = tuple(tuple(without_factors(f, definite) for f in row) for row in ends)
    kept = tuple(
        tuple(without_factors(f, definite) for f in (
            *_kept(trims[0], "u", ends[2][k] * p2[3], ends[3][k] * p1[3]),
            *_kept(trims[1], "v", ends[0][k] * q2[3], ends[1][k] * q1[3]),
        )) for k in range(3)
    )  # fmt: skip
    axes = tuple(
        tuple(without_factors(x[k] * y[3] - y[k] * x[3], definite) for x in (p1, p2) for y in (q1, q2))
        for k in range(3)
    )
    if factors:
        delta = product(f for f in factors if str(f) not in positive)
    found = Conditions(delta, brackets, axes, u, v, bounded, (p, q), trims, kept)
    if delta.is_zero():
        equation = forced_equation((pair for k in range(3) for pair in found.ends(k)), u, v)
        return replace(found, delta=equation, forced=not equation.is_zero(), known={})
    return found


def _kept(trims: Trims, name: str, first: fmpz_mpoly, second: fmpz_mpoly) -> list[fmpz_mpoly]:
    """Trimming polynomials at the place first / (first - second) of a ruling, times even powers of its denominator."""
    x, gap = RING.gen(RING.names().index(name)), first - second
    return [at_place(g, x, first, gap, _even(max((j for _, j in g), default=0))) for g in trims]


def without_factors(f: fmpz_mpoly, definite: Collection[fmpz_mpoly]) -> fmpz_mpoly:
    """f without those factors, which are positive everywhere: its sign is the same."""
    for g in definite:
        while not f.is_zero() and f.gcd(g) == g:
            f = f // g
    return f


def is_definite(f: fmpz_mpoly) -> bool:
    """Whether an irreducible polynomial in u alone, or v alone, is positive everywhere; its last coefficient is."""
    used = [k for k in range(3) if degree(f, k)]
    if used not in ([0], [1]):
        return False
    p = univariate(f, used[0])
    return bool(p.degree() % 2 == 0 and not roots_in(p, None))


def _line(p: Sequence[fmpz_mpoly], q: Sequence[fmpz_mpoly], bounded: bool) -> list[fmpz_mpoly]:
    """The Pluecker vector; of whole lines without its common factor, which is no part of the surface."""
    line = [p[i] * q[j] - p[j] * q[i] for i, j in PAIRS]
    if bounded:
        return line
    common = reduce(lambda x, y: x.gcd(y), line)
    return line if common.is_zero() else [x // common for x in line]


def _planes(line: list[fmpz_mpoly]) -> tuple[tuple[fmpz_mpoly, ...], ...]:
    """The skew matrix whose columns are planes through the line and a unit point."""
    a, b, c, d, e, f = (line[k] if sign > 0 else -line[k] for k, sign in DUAL)
    o = a - a
    return (o, a, b, c), (-a, o, d, e), (-b, -d, o, f), (-c, -e, -f, o)


def _sum(items: Iterable[fmpz_mpoly]) -> fmpz_mpoly:
    return reduce(lambda x, y: x + y, items)
