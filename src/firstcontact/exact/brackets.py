"""Brackets of points, and with them how two lines or two segments in space meet; over any exact ring.

Points are triples of int, fmpz, fmpq, or of numbers with `sign()` (exact.fields.number_field).  The lemmas are those of
[Chen11], repaired: 3-brackets keep their sign and share one projection, 2-brackets one direction, degenerate segments
are points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flint import arb, fmpq, fmpz

from firstcontact.exact.fields.number_field import is_zero, sign
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled, sub

if TYPE_CHECKING:
    from firstcontact.exact.ring import N, Number, Scalar, VectorOf


@dataclass(frozen=True, slots=True)
class LinesRelation:
    """How the line through p1, p2 and the line through q1, q2 meet.

    kind      "point": in exactly one; "overlap": they are one line; "separate": not at all.
    parallel  whether the directions are parallel: always for "overlap", never for "point".
    point     the common point of kind "point", = p1 + s (p2 - p1) = q1 + t (q2 - q1); else these three are None.
    """

    kind: str
    parallel: bool
    point: Vector | None = None
    s: Any = None
    t: Any = None


@dataclass(frozen=True, slots=True)
class SegmentsRelation:
    """How the closed segments p1 p2 and q1 q2 meet.

    kind     "point": in one point, their lines differ (or a segment is a point); "overlap": in a segment;
             "overlap_point": in one point of their common line; "separate": not at all.
    point    the one common point, = p1 + s (p2 - p1) = q1 + t (q2 - q1); the parameter of a segment p1 = p2 is 0.
    segment  the ends of an overlap, in the direction from p1 to p2; s and t are then pairs of numbers, one per end.
    """

    kind: str
    point: Vector | None = None
    segment: tuple[Vector, Vector] | None = None
    s: Any = None
    t: Any = None


def bracket4(a: VectorOf[N], b: VectorOf[N], c: VectorOf[N], d: VectorOf[N]) -> N:
    """[abcd] = det (a b c d; 1 1 1 1) = -det(b - a, c - a, d - a): six times a signed volume."""
    return -dot(sub(b, a), cross(sub(c, a), sub(d, a)))


def bracket3(a: VectorOf[N], b: VectorOf[N], c: VectorOf[N], dropped: int) -> N:
    """Twice the signed area of abc without coordinate `dropped`: [abc] times one factor for all of a plane."""
    j, k = (dropped + 1) % 3, (dropped + 2) % 3
    return (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j])


def bracket2(a: VectorOf[N], b: VectorOf[N], direction: VectorOf[N]) -> N:
    """(a - b) . direction: [ab] times one positive factor for all of a line with this direction."""
    return dot(sub(a, b), direction)


def projection(p1: Vector, p2: Vector, q1: Vector, q2: Vector) -> int | None:
    """The coordinate to drop so that four coplanar points keep their plane; None where they lie on one line."""
    p, q = sub(p2, p1), sub(q2, q1)
    for m in (
        cross(p, sub(q1, p1)),
        cross(p, sub(q2, p1)),
        cross(q, sub(p1, q1)),
        cross(q, sub(p2, q1)),
    ):
        for k in range(3):
            if not is_zero(m[k]):
                return k
    return None


def lines_relation(p1: Vector, p2: Vector, q1: Vector, q2: Vector) -> LinesRelation:
    """The relation of two lines; p1 != p2 and q1 != q2.

    With d = [p1 p2 q1 q2] and b1 = [p1 p2 q1], b2 = [p1 p2 q2], b3 = [p1 q1 q2], b4 = [p2 q1 q2]: one point when
    d = 0 and b1 != b2, one line when b1 = b2 = 0; there t = b1 / (b1 - b2) and s = b3 / (b3 - b4).
    """
    if not is_zero(bracket4(p1, p2, q1, q2)):
        return LinesRelation("separate", False)
    dropped = projection(p1, p2, q1, q2)
    if dropped is None:
        return LinesRelation("overlap", True)
    b1, b2 = bracket3(p1, p2, q1, dropped), bracket3(p1, p2, q2, dropped)
    if is_zero(b1 - b2):
        return LinesRelation("separate", True)
    t = _ratio(b1, b1 - b2)
    b3, b4 = bracket3(p1, q1, q2, dropped), bracket3(p2, q1, q2, dropped)
    return LinesRelation("point", False, _between(q1, q2, t), _ratio(b3, b3 - b4), t)


def segments_relation(p1: Vector, p2: Vector, q1: Vector, q2: Vector) -> SegmentsRelation:
    """The relation of two closed segments; each may be a point.

    Coplanar and not all on one line: separate when b1 b2 > 0 or b3 b4 > 0 (brackets as in `lines_relation`).
    """
    if _equal(p1, p2) or _equal(q1, q2):
        return _with_point(p1, p2, q1, q2)
    if not is_zero(bracket4(p1, p2, q1, q2)):
        return SegmentsRelation("separate")
    dropped = projection(p1, p2, q1, q2)
    if dropped is None:
        return _on_one_line(p1, p2, q1, q2)
    b1, b2 = bracket3(p1, p2, q1, dropped), bracket3(p1, p2, q2, dropped)
    if sign(b1) * sign(b2) > 0:
        return SegmentsRelation("separate")
    b3, b4 = bracket3(p1, q1, q2, dropped), bracket3(p2, q1, q2, dropped)
    if sign(b3) * sign(b4) > 0:
        return SegmentsRelation("separate")
    # b1 = b2 would make both 0: then all four points were on one line
    t = _ratio(b1, b1 - b2)
    return SegmentsRelation("point", _between(q1, q2, t), s=_ratio(b3, b3 - b4), t=t)


def _on_one_line(p1: Vector, p2: Vector, q1: Vector, q2: Vector) -> SegmentsRelation:
    """By the order of the four points along e = p2 - p1: the later start and the earlier end bound the overlap.

    [Chen11] table 1 gives the same set, with the absolute values of its brackets.
    """
    e, f = sub(p2, p1), sub(q2, q1)
    q_lo, q_hi = (q1, q2) if sign(dot(e, f)) > 0 else (q2, q1)
    start = q_lo if sign(bracket2(q_lo, p1, e)) > 0 else p1
    end = q_hi if sign(bracket2(p2, q_hi, e)) > 0 else p2
    gap = sign(bracket2(end, start, e))
    if gap < 0:
        return SegmentsRelation("separate")
    (s0, t0), (s1, t1) = ((_along(p1, e, x), _along(q1, f, x)) for x in (start, end))
    if gap == 0:
        return SegmentsRelation("overlap_point", start, s=s0, t=t0)
    return SegmentsRelation("overlap", None, (start, end), (s0, s1), (t0, t1))


def _with_point(p1: Vector, p2: Vector, q1: Vector, q2: Vector) -> SegmentsRelation:
    """At least one of the segments is a point: brackets of it vanish and decide nothing."""
    if not _equal(p1, p2):
        s = _parameter_of_point(q1, p1, p2)
        return SegmentsRelation("separate") if s is None else SegmentsRelation("point", q1, s=s, t=fmpq(0))
    t = _parameter_of_point(p1, q1, q2)
    return SegmentsRelation("separate") if t is None else SegmentsRelation("point", p1, s=fmpq(0), t=t)


def _parameter_of_point(x: Vector, a: Vector, b: Vector) -> fmpq | arb | None:
    """The parameter of x on the closed segment ab, None where x is not on it; 0 where a = b = x."""
    e = sub(b, a)
    if _equal(a, b):
        return fmpq(0) if _equal(x, a) else None
    if not all(map(is_zero, cross(e, sub(x, a)))):
        return None
    if sign(bracket2(x, a, e)) < 0 or sign(bracket2(b, x, e)) < 0:
        return None
    return _along(a, e, x)


def _along(a: Vector, e: Vector, x: Vector) -> fmpq | arb:
    """The parameter of a point x of the line a + s e."""
    return _ratio(bracket2(x, a, e), dot(e, e))


def _between(a: Vector, b: Vector, t: Number) -> Vector:
    return add(a, scaled(t, sub(b, a)))


def _equal(a: Vector, b: Vector) -> bool:
    return all(is_zero(x - y) for x, y in zip(a, b, strict=True))


def _ratio(x: Scalar, y: Scalar) -> fmpq | arb:
    """x / y, whole numbers included."""
    return fmpq(x, y) if isinstance(x, int | fmpz) and isinstance(y, int | fmpz) else x / y  # type: ignore[return-value]  # both are whole, or none
