"""When two rulings share a point: signs of polynomials in u, v and T.

With W > 0, the segments P1(u)P2(u) and Q1(v)Q2(v) share a point exactly when Delta = 0, for each of three auxiliary
points e the ends of either segment are not strictly on one side of the plane of the other line and e, and, where all
these brackets vanish, because the lines are one or a ruling is a point, on no axis are all of Q's ends strictly on one
side of P's.  Whole lines drop the conditions on their own ends.  All inequalities are weak: contact is closed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import Any

from flint import fmpq, fmpz_mpoly

from firstcontact.body.moving import shape_of
from firstcontact.body.rational_curve import RationalCurve, lifted
from firstcontact.body.ruled_surface import RuledSurface
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import rational
from firstcontact.exact.roots import roots_in
from firstcontact.exact.trivariate import RING, at, degree, irreducible, product, univariate
from firstcontact.motion.directrices import DirectrixPiece

Range = tuple[fmpq, fmpq] | None
"""Closed range of a parameter; None for the projective line."""
Sides = tuple[RationalCurve, RationalCurve]

_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
_DUAL = ((5, 1), (4, -1), (3, 1), (2, 1), (1, -1), (0, 1))


@dataclass(frozen=True)
class Conditions:
    """Of one piece of the motion; polynomials of the ring of u, v and T.

    delta      zero where the lines meet
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
    moment: fmpq | None = None
    """Of conditions at one time, whose curves still move."""
    known: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    """What was worked out of them."""

    @cached_property
    def pairs(self) -> list[tuple[fmpz_mpoly, fmpz_mpoly]]:
        """Two polynomials that are not both positive or both negative where rulings share a point."""
        d1, d2, d3, d4 = self.brackets
        found = [pair for k in range(3) for pair in self.ends(k)]
        assert len(d1) == len(d2) == len(d3) == len(d4) == 3
        return found

    def ends(self, k: int) -> list[tuple[fmpz_mpoly, fmpz_mpoly]]:
        """Of those, the ones of one auxiliary point."""
        d1, d2, d3, d4 = (row[k] for row in self.brackets)
        return ([(d1, d2)] if self.bounded[1] else []) + ([(d3, d4)] if self.bounded[0] else [])

    def holds(self, sign: Callable[[fmpz_mpoly], int], on_delta: bool = False) -> bool:
        """Whether rulings share a point, from the signs there; on_delta: that of delta is known to be 0."""
        if not on_delta and sign(self.delta) != 0:
            return False
        one_line = True
        for x, y in self.pairs:
            one, other = sign(x), sign(y)
            if one * other > 0:
                return False
            one_line = one_line and one == other == 0
        if not one_line or not all(self.bounded):
            return True
        return all(abs(sum(map(sign, axis))) < 4 for axis in self.axes)

    def at(self, t: fmpq) -> Conditions:
        """The conditions at one time."""
        return replace(
            self,
            delta=at(self.delta, 2, t),
            brackets=tuple(tuple(at(x, 2, t) for x in row) for row in self.brackets),
            axes=tuple(tuple(at(x, 2, t) for x in row) for row in self.axes),
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
        found = {}
        for inverse_u in (False, True) if self.u is None else (False,):
            for inverse_v in (False, True) if self.v is None else (False,):
                first = (p[0].reversed(), p[1].reversed()) if inverse_u else p
                second = (q[0].reversed(), q[1].reversed()) if inverse_v else q
                chart = _conditions(first, second, self.u or unit, self.v or unit, self.bounded)
                found[inverse_u, inverse_v] = chart if self.moment is None else chart.at(self.moment)
        return found


def conditions(a: Any, b: Any, piece: DirectrixPiece, span: tuple[fmpq, fmpq]) -> Conditions:
    """The conditions of two ruled pieces over one piece of their relative motion, whose parameter is in `span`."""
    p, q = (_shape(body) for body in (a, b))
    bounded = p.s is not None, q.s is not None
    if not any(bounded):
        raise UnsupportedPair(
            f"{p!r} and {q!r} both have whole rulings: they may meet at infinity only; bound s of one of them"
        )
    for surface, sides in ((p, piece.p), (q, piece.q)):
        if surface.trim:
            raise UnsupportedPair(f"{surface!r} is trimmed; times of contact are for pieces bounded by u and s alone")
        if surface.s is not None:
            for side in sides:
                _check_weight(surface, side, span)
    return _conditions(piece.p, piece.q, _range(p.u), _range(q.u), bounded)


def _shape(body: Any) -> RuledSurface:
    shape = shape_of(body)
    assert isinstance(shape, RuledSurface)
    return shape


def _range(ends: Any) -> Range:
    return None if ends is None else (rational(ends[0], "u"), rational(ends[1], "u"))


def _check_weight(surface: RuledSurface, side: RationalCurve, span: tuple[fmpq, fmpq]) -> None:
    """InputError unless the weight is positive over the range and the span."""
    if not side.deforming or not any(key[1] for key in _terms2(side.components[3])):
        return
    from firstcontact.exact import bernstein

    charts = [(side, _range(surface.u))] if surface.u else [(side, None), (side.reversed(), None)]
    for curve, ends in charts:
        table = _terms2(curve.components[3])
        size = max(i for i, _ in table), max(j for _, j in table)
        boxes = [(ends or (fmpq(-1), fmpq(1)), span, 0)]
        while boxes:
            u, t, depth = boxes.pop()
            if min(c for row in bernstein.grid(table, u, t, size) for c in row) > 0:
                continue
            if depth == 6:
                raise InputError(
                    f"{surface!r}: a directrix seems to have a pole at some time of the span; shorten u or the span"
                )
            x, y = (u[0] + u[1]) / 2, (t[0] + t[1]) / 2
            boxes += [(a, b, depth + 1) for a in ((u[0], x), (x, u[1])) for b in ((t[0], y), (y, t[1]))]


def _terms2(p: Any) -> dict[tuple[int, int], Any]:
    from firstcontact.body.rational_curve import terms as of_curve

    return of_curve(p)


def _conditions(p: Sides, q: Sides, u: Range, v: Range, bounded: tuple[bool, bool]) -> Conditions:
    p1, p2 = (lifted(curve.components, RING, "u") for curve in p)
    q1, q2 = (lifted(curve.components, RING, "v") for curve in q)
    line_p, line_q = _line(p1, p2, bounded[0]), _line(q1, q2, bounded[1])
    of_p, of_q = _planes(line_p), _planes(line_q)
    delta = _sum(x * line_q[j] * sign for x, (j, sign) in zip(line_p, _DUAL, strict=True))
    factors = [] if delta.is_zero() else irreducible(delta)
    weights = [w for curve in (p1, p2, q1, q2) for w in irreducible(curve[3])]
    definite = {str(f): f for f in [*factors, *weights] if _is_definite(f)}
    brackets = tuple(
        tuple(_reduced(_sum(x * row[k] for x, row in zip(end, planes, strict=True)), definite) for k in range(3))
        for end, planes in ((q1, of_p), (q2, of_p), (p1, of_q), (p2, of_q))
    )
    axes = tuple(
        tuple(_reduced(x[k] * y[3] - y[k] * x[3], definite) for x in (p1, p2) for y in (q1, q2)) for k in range(3)
    )
    if factors:
        delta = product(f for f in factors if str(f) not in definite)
    return Conditions(delta, brackets, axes, u, v, bounded, (p, q))


def _reduced(f: fmpz_mpoly, definite: dict[str, fmpz_mpoly]) -> fmpz_mpoly:
    """f without those factors, which are positive everywhere: its sign is the same."""
    for g in definite.values():
        while not f.is_zero() and f.gcd(g) == g:
            f = f // g
    return f


def _is_definite(f: fmpz_mpoly) -> bool:
    """Whether an irreducible polynomial in u alone, or v alone, is positive everywhere; its last coefficient is."""
    used = [k for k in range(3) if degree(f, k)]
    if used not in ([0], [1]):
        return False
    p = univariate(f, used[0])
    return bool(p.degree() % 2 == 0 and not roots_in(p, None))


def _line(p: Any, q: Any, bounded: bool) -> list[fmpz_mpoly]:
    """The Pluecker vector; of whole lines without its common factor, which is no part of the surface."""
    line = [p[i] * q[j] - p[j] * q[i] for i, j in _PAIRS]
    if bounded:
        return line
    common = reduce(lambda x, y: x.gcd(y), line)
    return [x // common for x in line]


def _planes(line: list[fmpz_mpoly]) -> tuple[tuple[fmpz_mpoly, ...], ...]:
    """The skew matrix whose columns are planes through the line and a unit point."""
    a, b, c, d, e, f = (line[k] if sign > 0 else -line[k] for k, sign in _DUAL)
    o = a - a
    return (o, a, b, c), (-a, o, d, e), (-b, -d, o, f), (-c, -e, -f, o)


def _sum(items: Any) -> Any:
    return reduce(lambda x, y: x + y, items)
