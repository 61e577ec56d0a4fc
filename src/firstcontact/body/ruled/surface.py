"""Ruled surfaces: the lines, or pieces of lines, that join corresponding points of two rational curves."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.body import told
from firstcontact.body.placing import Placing
from firstcontact.body.ruled.bounds import Box, curve_box, hull
from firstcontact.body.ruled.joints import proved_joints
from firstcontact.body.ruled.rational_curve import RationalCurve, derivative, in_u, lifted, terms, text_of
from firstcontact.errors import InputError
from firstcontact.exact.expressions import context, read_inequalities
from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.numbers import fraction, rational, to_double
from firstcontact.exact.polynomials import bernstein
from firstcontact.exact.rigid import Matrix
from firstcontact.motion.translation import LARGEST
from firstcontact.motion.value import numbers

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.body.ruled.rational_curve import Component
    from firstcontact.body.ruled.strip import RuledStrip
    from firstcontact.exact.numbers import Given, Nested
    from firstcontact.exact.vectors import Vector
    from firstcontact.result import Table

Interval = tuple[Fraction, Fraction]
PARAMETERS = context(("u", "s"))
"""The ring of trimming polynomials."""
SIDES = "u0", "s1", "u1"
"""Borders of a triangle that is ruled from its first corner: from that to the second one, and so on."""
_ONE = fmpq(1)
_WHOLE = Fraction(0), Fraction(1)
# Stands for infinity where a trimming polynomial is evaluated in floats.
FAR = 1e12


@dataclass(frozen=True)
class Trim:
    """The part of the parameters where polynomial(u, s) >= 0."""

    polynomial: fmpz_mpoly

    def values(self, u: np.ndarray, s: np.ndarray) -> np.ndarray:
        """The polynomial, up to a positive factor, in float64 at arrays of one shape; infinite u count as large."""
        u, table = np.clip(u, -FAR, FAR), terms(self.polynomial)
        scale = max((abs(c) for c in table.values()), default=1)
        return sum((to_double(fmpq(c, scale)) * u**i * s**j for (i, j), c in table.items()), np.zeros(u.shape))

    def __str__(self) -> str:
        return f"{text_of(self.polynomial, ('u', 's'))} >= 0"

    def __reduce__(self) -> tuple[object, ...]:
        return _trim_of, ({key: int(c) for key, c in self.polynomial.to_dict().items()},)


class RuledSurface(Placing):
    """P(u, s) = (1 - s) first(u) + s second(u): a piece of a ruled surface, or all of it; immutable.

    first, second: the directrices, as RationalCurve or as strings in u, such as
        "((1-u**2)/(1+u**2), 2*u/(1+u**2), 0)"; they may hold the time T too: the surface then deforms, T is the
        clock of the query.
    u: the closed range of u, None for the whole projective line (u = infinity included).
    s: the closed range of s, None for whole rulings.
    trim: inequalities in u and s that the piece satisfies besides, such as ["u*s <= 1/2", "s >= u**2"].

    Results name its elements by number: face 0, directrix 0 and 1 (the sides s = s0 and s1), end_ruling 0 and 1 (u = u0
    and u1), vertex 2 i + j (end i of u on side j), edge k (the border of the inequality k of trim).

    The directrices of a bounded piece have no poles in its range; proved here, for denominators that hold T at the time
    that is asked for.  Raises InputError for that, for directrices that are equal or span only one line, and for empty
    ranges.

    >>> cone = RuledSurface("(0, 0, 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", u=None, name="cone")
    >>> cone
    <RuledSurface 'cone': degrees 0 and 2, all u, s in [0, 1]>
    >>> cone.points(1, [0, 1]).tolist()
    [[0.0, 0.0, 0.0], [0.0, 1.0, 1.0]]
    >>> saddle = RuledSurface("(u, 0, T)", "(u, 1, u + T)")
    >>> saddle.at("1/2").bounds()
    (array([0. , 0. , 0.5]), array([1. , 1. , 1.5]))
    """

    kind = "RuledSurface"
    first: RationalCurve
    second: RationalCurve
    u: Interval | None
    s: Interval | None
    trim: tuple[Trim, ...]
    name: str | None
    joined: frozenset[str]
    """Of a piece of a strip: which of the borders "u0", "u1", "s0", "s1" it shares with a neighbour."""
    _search: dict[Any, Any]

    def __init__(
        self,
        first: RationalCurve | str,
        second: RationalCurve | str,
        *,
        u: Sequence[Given] | None = (0, 1),
        s: Sequence[Given] | None = (0, 1),
        trim: Iterable[str] | str = (),
        name: str | None = None,
    ) -> None:
        who = name or "ruled surface"
        self.name = name
        self.first, self.second = _curve(first, f"{who}: first"), _curve(second, f"{who}: second")
        self.u, self.s = _range(u, f"{who}: u"), _range(s, f"{who}: s")
        self.trim = _trims(trim, who)
        self.joined = frozenset()
        self._search = {}
        """What was worked out of this surface: it follows from its geometry, so no changed copy inherits it."""
        self._validate()

    @classmethod
    def from_nurbs(
        cls,
        points: Nested,
        knots: Nested | None = None,
        weights: Nested | None = None,
        *,
        degree: Given | Sequence[Given] = None,
        name: str | None = None,
    ) -> RuledSurface | RuledStrip:
        """The ruled surface of degree (n, 1) or (1, n) of a grid of control points: one piece between every two knots.

        points: (n, 2, 3), or (2, n, 3), of numbers of any kind, taken exactly; more than two rows across make strips
        side by side.  knots: those along the curves, as many as points, degree and 1 together; or two lists, for both
        directions of the grid; None for one Bezier patch.  weights: positive, one for each point.  degree: the one
        along the curves, or both, if you want it checked, or where (2, 2, 3) points leave it open.

        The parameter u of the pieces is that of the spline.  Their s blends the two curves by affine points: it is the
        spline's where both weights of a ruling are equal.  Returns a RuledSurface where there is one piece, otherwise
        a RuledStrip, a body with `pieces`.

        >>> roof = RuledSurface.from_nurbs(
        ...     [[(0, 0, 0), (0, 4, 0)], [(1, 0, 1), (1, 4, 2)], [(2, 0, 1), (2, 4, 2)], [(3, 0, 0), (3, 4, 0)]],
        ...     knots=[0, 0, 0, 1, 2, 2, 2], name="roof")
        >>> roof, roof.pieces[1]
        (<RuledStrip 'roof': 2 pieces of degree 2>, <RuledSurface 'roof': degrees 2 and 2, u in [1, 2], s in [0, 1]>)
        >>> print(roof.pieces[0].first)
        ((-u**2 + 4*u)/2, 0, -u**2 + 2*u)
        """
        from firstcontact.body.ruled.nurbs import patches
        from firstcontact.body.ruled.strip import RuledStrip

        found = patches(points, knots, weights, degree, name or "from_nurbs")
        pieces = []
        for k, patch in enumerate(found):
            try:
                pieces.append(cls(patch.first, patch.second, u=patch.u, name=name)._with(joined=patch.joined))
            except InputError as error:
                raise InputError(f"{error} (piece {k}, u from {patch.u[0]} to {patch.u[1]})") from error
        return pieces[0] if len(pieces) == 1 else RuledStrip(pieces, name=name)

    # -- looking --------------------------------------------------------------------------------------------

    @property
    def pieces(self) -> tuple[RuledSurface, ...]:
        """Itself: a strip of several pieces is a RuledStrip."""
        return (self,)

    @property
    def deforming(self) -> bool:
        """Whether a directrix depends on the time T."""
        return self.first.deforming or self.second.deforming

    @property
    def velocity(self) -> Vector | None:
        """By how much it shifts in a unit of the time T, where it does nothing else; None of others that deform."""
        way = self.first.velocity
        return way if way == self.second.velocity else None

    @property
    def bounded(self) -> bool:
        """Whether the piece has a finite box at any time: its rulings are bounded."""
        return self.s is not None

    @property
    def without_end(self) -> str:
        """Which of the parameters u and s have no ends, in words."""
        return " and ".join(name for name, ends in (("u", self.u), ("s", self.s)) if ends is None)

    @property
    def sides(self) -> tuple[RationalCurve, RationalCurve]:
        """The curves that bound the rulings: those at the ends of s; the directrices themselves of whole rulings.

        The surface is (1 - r) sides[0] + r sides[1] with s = s0 + (s1 - s0) r.
        """
        if self.s is None or self.s == _WHOLE:
            return self.first, self.second
        if "sides" not in self._search:
            found = (_blend(self.first, self.second, rational(s, "s")) for s in self.s)
            if not self.deforming:
                found = (self._positive(curve) for curve in found)
            self._search["sides"] = tuple(found)
        known: tuple[RationalCurve, RationalCurve] = self._search["sides"]
        return known

    @property
    def tracing_index(self) -> int:
        """How many parameters u a ruling has in general: 1 where u is a proper parameter, 2 where only u^2 occurs.

        The degree in u of the common factor of l_i(u) l_j(w) - l_j(u) l_i(w), for the Pluecker vector l; at rest.
        """
        if self.deforming:
            raise InputError(f"{self._who} deforms with the time T; take .at(t)")
        if "tracing index" not in self._search:
            self._search["tracing index"] = _tracing_index(self._lines())
        known: int = self._search["tracing index"]
        return known

    @property
    def is_proper(self) -> bool:
        """Whether all but finitely many rulings belong to one u each."""
        return self.tracing_index == 1

    def at(self, t: Given) -> RuledSurface:
        """The surface at rest at time t, a number of any kind, taken exactly; itself where it does not deform."""
        if not self.deforming:
            return self
        try:
            resting = self._with(first=self.first.at(t), second=self.second.at(t))
        except InputError as error:
            raise InputError(f"{self._who}: {error}") from error
        try:
            resting._validate()
        except InputError as error:
            raise InputError(f"{error} (at T = {t})") from error
        return resting

    def points(self, u: ArrayLike, s: ArrayLike) -> np.ndarray:
        """(..., 3) float64 points at rest for parameters that broadcast; u may be infinite.  Not trimmed."""
        u, s = np.broadcast_arrays(np.asarray(u, float), np.asarray(s, float))
        if np.any(np.isnan(s)):
            raise InputError("s holds NaN; give parameters")
        r = s[..., None]
        found: np.ndarray = (1 - r) * self.first.points(u) + r * self.second.points(u)
        return found

    def keeps(self, u: ArrayLike, s: ArrayLike) -> np.ndarray:
        """Bools of the shape that u and s broadcast to: whether the trimming inequalities hold there, in floats."""
        u, s = np.broadcast_arrays(np.asarray(u, float), np.asarray(s, float))
        kept = np.ones(u.shape, bool)
        for trim in self.trim:
            kept &= trim.values(u, s) >= 0
        return kept

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the piece; certified, not the least one.

        Of a deforming one at all times of the span, by default (0, 1).  Trimming is left out of account.  Infinite for
        whole rulings.
        """
        if self.s is None:
            return np.full(3, -np.inf), np.full(3, np.inf)
        first, last = (0, 1) if span is None or not self.deforming else span
        key = "box", first, last
        if key not in self._search:
            times = rational(first, "span start"), rational(last, "span end")
            try:
                self._search[key] = hull([box for side in self.sides for box in self._side_boxes(side, times)])
            except InputError as error:
                raise InputError(f"{self._who}: {error}") from error
        lo, hi = self._search[key]
        return lo.copy(), hi.copy()

    def to_mesh(self, tolerance: float) -> Polyhedron:
        """A Polyhedron of triangles with vertices on the piece, which is at most `tolerance` away from them, at rest.

        Trimmed borders are cut where the inequalities hold no more, up to the grid of the mesh.  Needs bounded rulings.
        """
        from firstcontact.body.ruled.mesh import mesh

        return mesh(self.pieces, tolerance, self.name)

    def _side_boxes(self, side: RationalCurve, times: tuple[fmpq, fmpq]) -> list[Box]:
        if self.u is not None:
            ends = rational(self.u[0], "u"), rational(self.u[1], "u")
            return [curve_box(side, ends, times)]
        return [curve_box(chart, (-_ONE, _ONE), times) for chart in (side, side.reversed())]

    def told(self) -> list[str]:
        return told.ruled(self)

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        degrees = f"degrees {self.first.degree} and {self.second.degree}"
        u = "all u" if self.u is None else f"u in {_text(self.u)}"
        s = "whole rulings" if self.s is None else f"s in {_text(self.s)}"
        rest = (["trimmed"] if self.trim else []) + (["deforming"] if self.deforming else [])
        return f"<RuledSurface{name}: {', '.join([degrees, u, s, *rest])}>"

    def _facts(self) -> tuple[Hashable, ...]:
        trims = frozenset(frozenset((key, int(c)) for key, c in x.polynomial.to_dict().items()) for x in self.trim)
        return self.first.key(), self.second.key(), self.u, self.s, trims, self.joined

    def _table(self) -> Table:
        return {"shape": "ruled", **self._piece(self.joined & proved_joints([self])[0])}

    def _piece(self, joined: frozenset[str]) -> Table:
        """Directrices and ranges as scene files have them, with the borders that are none of the whole body."""
        trims = [str(x) for x in self.trim]
        return {
            "first": self.first.table(),
            "second": self.second.table(),
            "u": "all" if self.u is None else numbers([rational(x, "u") for x in self.u]),
            "s": "all" if self.s is None else numbers([rational(x, "s") for x in self.s]),
            **({"trim": trims} if trims else {}),
            **({"joined": sorted(joined)} if joined else {}),
        }

    # -- inside ---------------------------------------------------------------------------------------------

    @property
    def _who(self) -> str:
        return self.name or "ruled surface"

    def part(self, u: Interval, s: Interval) -> RuledSurface:
        """The piece over smaller ranges, without its inequalities; borders inside the piece are `joined` ones."""
        inner = {f"u{k}" for k in (0, 1) if self.u is None or u[k] != self.u[k]}
        inner |= {f"s{k}" for k in (0, 1) if self.s is None or s[k] != self.s[k]}
        return self._with(u=u, s=s, trim=(), joined=self.joined | inner)

    def crossed(self) -> RuledSurface | None:
        """The same points ruled the other way, u and s exchanged; None where lines across are not straight.

        Directrices become end rulings, and end rulings directrices.
        """
        curves = self.first, self.second
        if self.u is None or self.s is None or self.deforming:
            return None
        if any(c.degree > 1 or c.components[3].degree() > 0 for c in curves):
            return None
        first, second = (RationalCurve.segment(*(curve.place(u) for curve in curves)) for u in (0, 1))
        trim = tuple(
            Trim(PARAMETERS.from_dict({(j, i): c for (i, j), c in terms(x.polynomial).items()})) for x in self.trim
        )
        joined = frozenset(("s" if x[0] == "u" else "u") + x[1] for x in self.joined)
        return self._with(first=first, second=second, u=self.s, s=self.u, trim=trim, joined=joined)

    def corners(self) -> list[Vector] | None:
        """Of a triangle that is ruled from a corner over the unit square, that one first; None of others."""
        curves = self.first, self.second
        is_whole = all(ends is not None and ends[0] == 0 and ends[1] == 1 for ends in (self.u, self.s))
        if self.trim or self.deforming or not is_whole:
            return None
        if any(c.degree > k or c.components[3].degree() > 0 for k, c in enumerate(curves)):
            return None
        return [self.first.place(0), self.second.place(0), self.second.place(1)]

    def ruled_from(self, k: int) -> RuledSurface:
        """The triangle ruled from another one of its corners."""
        corners = self.corners()
        assert corners is not None
        a, b, c = corners[k:] + corners[:k]
        first, second = RationalCurve.segment(a, a), RationalCurve.segment(b, c)
        inner = frozenset(name for j, name in enumerate(SIDES) if SIDES[(j + k) % 3] in self.joined)
        return self._with(first=first, second=second, joined=inner)

    def _with(self, **changes: object) -> RuledSurface:
        other = object.__new__(RuledSurface)
        other.__dict__.update(self.__dict__)
        other.__dict__.update(_search={})
        other.__dict__.update(changes)
        return other

    def _mapped(self, matrix: Matrix) -> RuledSurface:
        return self._with(first=self.first.mapped(matrix), second=self.second.mapped(matrix))

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_search": {}}

    def _validate(self) -> None:
        lines = self._lines()
        if all(x == 0 for x in lines):
            raise InputError(f"{self._who}: first and second are one curve; give two different ones")
        if all(x * derivative(y) == y * derivative(x) for x, y in combinations(lines, 2)):
            raise InputError(f"{self._who}: all rulings lie on one line; give directrices that span a surface")
        if self.s is not None:
            self.first, self.second = (
                curve if any(j for _, j in terms(curve.components[3])) else self._positive(curve, name)
                for curve, name in ((self.first, "first"), (self.second, "second"))
            )
        for trim in self.trim:
            if self._is_empty(trim):
                raise InputError(f"{self._who}: trim {str(trim)!r} leaves nothing of the piece; check its direction")

    def _lines(self) -> list[Component]:
        """The Pluecker vector of the ruling, 01, 02, 03, 12, 13, 23, with its common factor."""
        p: Sequence[Any] = self.first.components
        q: Sequence[Any] = self.second.components
        if self.deforming:
            p, q = lifted(p), lifted(q)
        return [p[i] * q[j] - p[j] * q[i] for i, j in combinations(range(4), 2)]

    def _positive(self, curve: RationalCurve, which: str = "a side") -> RationalCurve:
        """The curve, whose weight does not depend on T, with one positive in the range of u; InputError for a pole."""
        w = in_u(curve.components[3])
        sample, end = (-_ONE, _ONE) if self.u is None else (rational(x, "u") for x in self.u)
        poles = [float(x) for x in real_roots(w, sample, end)]
        if self.u is None and not poles:
            far = [float(x) for x in real_roots(in_u(curve.reversed().components[3]), -_ONE, _ONE)]
            poles = [1 / x if x else math.inf for x in far]
        if poles:
            where = "infinity" if math.isinf(poles[0]) else f"{poles[0]:.9g}"
            raise InputError(
                f"{self._who}: {which} has a pole at u = {where}; give a range u=(u0, u1) without it, "
                "or s=None for whole rulings"
            )
        return curve if w(sample) > 0 else curve.flipped()

    def _is_empty(self, trim: Trim) -> bool:
        """True proves that no point of a bounded range of parameters satisfies the inequality."""
        if self.u is None or self.s is None:
            return trim.polynomial.is_constant() and terms(trim.polynomial).get((0, 0), 0) < 0
        ends = [(rational(lo, "range"), rational(hi, "range")) for lo, hi in (self.u, self.s)]
        degrees = trim.polynomial.degrees()
        net = bernstein.grid(terms(trim.polynomial), ends[0], ends[1], (max(degrees[0], 0), max(degrees[1], 0)))
        return max(c for row in net for c in row) < 0


# -- arguments ----------------------------------------------------------------------------------------------


def _curve(curve: RationalCurve | str, what: str) -> RationalCurve:
    if isinstance(curve, RationalCurve):
        return curve
    if isinstance(curve, str):
        return RationalCurve.parse(curve, what)
    raise InputError(f"{what} is {curve!r}; give a RationalCurve or a string such as \"(u, u**2, 0)\"")


def _range(ends: Sequence[Given] | None, what: str) -> Interval | None:
    if ends is None:
        return None
    try:
        if isinstance(ends, str | set | frozenset | dict):  # of letters, or of no order
            raise TypeError
        first, last = ends
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} is {ends!r}; give a range (lo, hi), or None for all of it") from error
    lo, hi = rational(first, f"{what}[0]"), rational(last, f"{what}[1]")
    if not lo < hi:
        raise InputError(f"{what} is the empty range ({first}, {last}); give lo < hi")
    if max(abs(lo), abs(hi)) >= LARGEST:
        raise InputError(f"{what} is ({first}, {last}); give numbers below 2^150, or None for all of it")
    return fraction(lo), fraction(hi)


def _trims(trim: Iterable[str] | str, who: str) -> tuple[Trim, ...]:
    if not np.iterable(trim):
        raise InputError(f"{who}: trim is {trim!r}; give inequalities such as [\"u*s <= 1/2\"]")
    texts = [trim] if isinstance(trim, str) else list(trim)
    found = []
    for k, text in enumerate(texts):
        if not isinstance(text, str):
            raise InputError(f"{who}: trim[{k}] is {text!r}; give an inequality such as \"u*s <= 1/2\"")
        found += [Trim(g) for g in read_inequalities(text, ("u", "s"), f"{who}: trim[{k}]")]
    return tuple(found)


def _trim_of(table: Mapping[tuple[int, ...], int]) -> Trim:
    return Trim(PARAMETERS.from_dict(table))


# -- geometry -----------------------------------------------------------------------------------------------


def _blend(first: RationalCurve, second: RationalCurve, s: fmpq) -> RationalCurve:
    """The curve (1 - s) first + s second."""
    p: Sequence[Any] = first.components
    q: Sequence[Any] = second.components
    if first.deforming or second.deforming:
        p, q = lifted(p), lifted(q)
    a, b = s.q - s.p, s.p
    points = (a * x * q[3] + b * y * p[3] for x, y in zip(p[:3], q[:3], strict=True))
    return RationalCurve.of([*points, s.q * p[3] * q[3]])


def _tracing_index(lines: list[fmpz_poly]) -> int:
    ring = context(("u", "v"))
    common = reduce(fmpz_poly.gcd, lines)
    primitive = [(x // common,) for x in lines]
    at_u, at_v = ([lifted(x, ring, name)[0] for x in primitive] for name in ("u", "v"))
    minors = (at_u[i] * at_v[j] - at_u[j] * at_v[i] for i, j in combinations(range(6), 2))
    return int(reduce(fmpz_mpoly.gcd, minors).degrees()[0])


def _text(ends: Interval) -> str:
    return "[{}, {}]".format(*(str(x) if x.denominator < 1000 else f"{to_double(rational(x, '')):.6g}" for x in ends))
