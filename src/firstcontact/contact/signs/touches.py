"""What meets at a contact: points and elements of two ruled pieces, from exact parameters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from flint import arb, fmpz

from firstcontact.body.ruled.rational_curve import RationalCurve, lifted, terms
from firstcontact.contact.signs.conditions import Conditions, Trims
from firstcontact.contact.signs.shared_points import FieldPoint, vanishes
from firstcontact.exact.fields.number_field import FieldElement, is_zero, sign
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.trivariate import RING
from firstcontact.exact.vectors import Vector, add, along, cross, dot, sub

BITS = 96
Side = int | None
"""Which end of a range a parameter is at: 0 or 1; None between them."""


@dataclass(frozen=True)
class RuledTouch:
    """A shared point.

    point       (3,) in the frame of q
    elements    (kind, number) on either piece: face 0, directrix j, end_ruling i, vertex 2 i + j, edge k on the border
                of the trimming inequality k
    parameters  u, s, v, t in doubles; s or t None on rulings without end
    normal      (3,) unit, orthogonal to both elements, against the way in which p comes nearer to q; None where they
                span no plane, or p slides along it
    shared      (n, 3): the point, or both ends of the segment that rulings on one line share
    """

    point: np.ndarray
    elements: tuple[tuple[str, int], tuple[str, int]]
    parameters: tuple[float, float | None, float, float | None]
    normal: np.ndarray | None
    shared: np.ndarray


class Ruling:
    """One segment or line, exactly: the points (1 - r) first + r second, a line also base + r way."""

    first: Vector
    second: Vector

    def __init__(
        self, curves: tuple[RationalCurve, RationalCurve], name: str, contact: FieldPoint, bounded: bool
    ) -> None:
        ends = [[contact.value(x) for x in lifted(c.components, RING, name)] for c in curves]
        self.bounded = bounded
        finite = [not is_zero(x[3]) for x in ends]
        if all(finite):
            self.first, self.second = (_affine(x) for x in ends)
        else:  # a whole ruling whose directrix is at infinity
            self.first = next(_affine(x) for x, f in zip(ends, finite, strict=True) if f)
            x, y, z, _ = next(x for x, f in zip(ends, finite, strict=True) if not f)
            self.second = add(self.first, (x, y, z))
        self.way = sub(self.second, self.first)

    def at(self, place: FieldElement) -> Vector:
        """The point with that parameter r."""
        return along(self.first, place, self.way)

    def place(self, point: Vector) -> FieldElement | None:
        """The parameter r of a point on the line; None where the ruling is a point."""
        axes = [k for k, w in enumerate(self.way) if not is_zero(w)]
        if not axes:
            return None
        k = max(axes, key=lambda k: abs(in_double(self.way[k])))  # of a point near the line the best one
        place: FieldElement = (point[k] - self.first[k]) / self.way[k]
        return place


def touch(contact: FieldPoint, joined: tuple[frozenset[str], frozenset[str]]) -> RuledTouch:
    """joined: borders of either piece that are none of the body."""
    c = contact.conditions
    assert isinstance(c, Conditions)
    p, q = (Ruling(curves, name, contact, b) for curves, name, b in zip(c.sides, "uv", c.bounded, strict=True))
    n = cross(p.way, q.way)
    gap = sub(q.first, p.first)
    square = dot(n, n)
    if not is_zero(square):
        points = [p.at(dot(cross(gap, q.way), n) / square)]
    else:
        points = _common_points(p, q)
    point = points[0]
    r, w = p.place(point), q.place(point)
    places = [None if x is None or not b else x for x, b in zip((r, w), c.bounded, strict=True)]
    elements = []
    for value, ends, place, borders in zip((contact.u, contact.v), contact.ranges, places, joined, strict=True):
        across = None if ends is None else end_met(contact, [value - end for end in ends], ("u0", "u1"), borders)
        along = None if place is None else end_met(contact, [place, place - 1], ("s0", "s1"), borders)
        elements.append(element_kind(across, along))
    cuts = [_cut(contact, *some) for some in zip(c.trims, (contact.u, contact.v), places, strict=True)]
    elements = [("edge", cut[0]) if cut and e == ("face", 0) else e for cut, e in zip(cuts, elements, strict=True)]
    shown = np.array([[in_double(x) for x in y] for y in points])
    u, v = (shown_parameter(x, i) for x, i in zip((contact.u, contact.v), contact.inverse, strict=True))
    r_d, w_d = (None if x is None else in_double(x) for x in places)
    kinds = elements[0], elements[1]
    return RuledTouch(shown[0], kinds, (u, r_d, v, w_d), _normal(contact, kinds, (p, q), places, cuts), shown)


Cut = tuple[int, tuple[float, float]]
"""A trimming inequality that is just met, and the derivatives of its polynomial by u and by the place on the ruling."""


def _cut(contact: FieldPoint, trims: Trims, x: FieldElement, place: FieldElement | None) -> Cut | None:
    """The first one."""
    for k, g in enumerate(trims):
        if place is None and any(j for _, j in g):
            continue
        s = x - x if place is None else place
        value = sum((_power(x, i) * _power(s, j) * int(c) for (i, j), c in g.items()), x - x)
        if vanishes(contact, value, sum(abs(int(c)) for c in g.values())):
            return k, cut_slopes(g, in_double(x), in_double(s))
    return None


def cut_slopes(g: dict[tuple[int, int], fmpz], u: float, r: float) -> tuple[float, float]:
    """The derivatives of a trimming polynomial by u and by the place r on the ruling."""
    by_u = sum(float(c) * i * u ** max(i - 1, 0) * r**j for (i, j), c in g.items())
    return by_u, sum(float(c) * j * u**i * r ** max(j - 1, 0) for (i, j), c in g.items())


def _affine(x: Sequence[FieldElement]) -> Vector:
    return x[0] / x[3], x[1] / x[3], x[2] / x[3]


def _power(x: FieldElement, n: int) -> FieldElement:
    return reduce(lambda y, _: y * x, range(n), x - x + 1)


def _common_points(p: Ruling, q: Ruling) -> list[Vector]:
    """Ends of rulings on one line, or that are points, which lie on the other one, each once: one or two."""
    found: list[Vector] = []
    for own, other in ((p, q), (q, p)):
        for point in (own.first, own.second) if own.bounded else ():
            r = other.place(point)
            if r is None:
                inside = all(is_zero(x) for x in sub(point, other.first))
            else:
                on_line = all(is_zero(x) for x in sub(other.at(r), point))
                inside = on_line and (not other.bounded or (sign(r) >= 0 and sign(r - 1) <= 0))
            if inside and not any(all(is_zero(x) for x in sub(point, y)) for y in found):
                found.append(point)
    return found


def end_met(
    contact: FieldPoint, distances: Sequence[FieldElement], names: Sequence[str], joined: frozenset[str]
) -> Side:
    for k, distance in enumerate(distances):
        if names[k] not in joined and vanishes(contact, distance):
            return k
    return None


def element_kind(across: Side, along: Side) -> tuple[str, int]:
    if across is None:
        return ("face", 0) if along is None else ("directrix", along)
    return ("end_ruling", across) if along is None else ("vertex", 2 * across + along)


def _normal(
    contact: FieldPoint,
    kinds: tuple[tuple[str, int], tuple[str, int]],
    rulings: tuple[Ruling, Ruling],
    places: Sequence[FieldElement | None],
    cuts: Sequence[Cut | None],
) -> np.ndarray | None:
    """Of the plane that all tangents of both elements span, in doubles, and where p comes from."""
    c = contact.conditions
    assert isinstance(c, Conditions)
    tangents = []
    speeds = []
    for kind, curves, own, place, x, cut in zip(
        (k for k, _ in kinds), c.sides, rulings, places, (contact.u, contact.v), cuts, strict=True
    ):
        way = np.array([in_double(w) for w in own.way])
        if kind in ("face", "end_ruling"):
            tangents.append(way)
        r = 0.5 if place is None else in_double(place)
        first, second = (curve_slopes(curve, in_double(x), in_double(contact.t)) for curve in curves)
        tangent, speed = (1 - r) * first + r * second
        speeds.append(speed)
        if kind in ("face", "directrix"):
            tangents.append(tangent)
        if kind == "edge" and cut is not None:
            tangents.append(tangent * cut[1][1] - way * cut[1][0])
        elif cut is not None:  # a corner: of no border and a trimmed one
            return None
    rows = np.array([t / np.linalg.norm(t) for t in tangents if np.all(np.isfinite(t)) and np.linalg.norm(t) > 0])
    if len(rows) < 2:
        return None
    _, size, base = np.linalg.svd(rows)
    if len(size) < 2 or size[1] < 1e-6 or (len(size) > 2 and size[2] > 1e-6):
        return None
    approach = float(base[2] @ (speeds[0] - speeds[1]))
    if not abs(approach) > 1e-9 * max(float(np.linalg.norm(speed)) for speed in speeds):
        return None
    normal: np.ndarray = base[2] if approach < 0 else -base[2]
    return normal


def curve_slopes(curve: RationalCurve, u: float, t: float) -> np.ndarray:
    """(2, 3): the derivatives of the affine point by the parameter and by T."""
    x, dx, dt = np.zeros(4), np.zeros(4), np.zeros(4)
    table = [terms(p) for p in curve.components]
    largest = max(abs(int(c)) for row in table for c in row.values())  # may be beyond the range of doubles
    for k, row in enumerate(table):
        for (i, j), integer in row.items():
            c = int(integer) / largest
            x[k] += c * u**i * t**j
            dx[k] += c * i * u ** max(i - 1, 0) * t**j
            dt[k] += c * j * u**i * t ** max(j - 1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.array([(d[:3] * x[3] - x[:3] * d[3]) / x[3] ** 2 for d in (dx, dt)])


def in_double(x: FieldElement) -> float:
    with precision(BITS):
        return float(x.ball(BITS).mid())


def shown_parameter(x: FieldElement, inverse: bool) -> float:
    if not inverse:
        return in_double(x)
    if is_zero(x):
        return float("inf")
    with precision(BITS):
        return float((arb(1) / x.ball(BITS)).mid())


def most_of(found: Iterable[str]) -> str:
    """How a surface lies whose pieces lie so."""
    known = set(found)
    return next((x for x in ("overlapping", "containment") if x in known), "touching")
