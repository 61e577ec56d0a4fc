"""Conics that touch: pairs of points on a line (binary quadratic forms), and conics of one plane.

Two conics in space whose planes meet in a line L meet on L only: their forms there are binary, and the pencil of
these two forms tells how the two pairs of points lie (re-derived; the table is complete, see the tests).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

from firstcontact.exact.fields.number_field import is_zero, sign
from firstcontact.exact.pencils.pencils import (
    IDENTICALLY_DEGENERATE,
    Vector,
    binary_zeros,
    characteristic,
    combination,
    discriminant,
    member,
    multiple_roots,
    singular_point,
)
from firstcontact.exact.polynomials.inertia import Rows, inertia, null_space, times
from firstcontact.exact.polynomials.polynomial_matrix import congruent

if TYPE_CHECKING:
    from firstcontact.exact.ring import D, Divisible, MatrixOf, N, Number

# ------------------------------------------------------------------------------------ two pairs on a line


class PointPairs(Enum):
    """How the zeros of two binary quadratic forms lie on the projective line: twelve configurations.

    f(l) = det(l A - B) has a double root exactly in the first five of them; the four contacts need a realness test
    besides, which two equal imaginary pairs fail.
    """

    ONE_SHARED = "two real pairs with one point in common"
    SAME_PAIR = "the same real pair"
    POINT_OF_PAIR = "a double point that belongs to a real pair"
    SAME_POINT = "the same double point"
    SAME_IMAGINARY = "the same imaginary pair"
    SEPARATING = "two real pairs that separate each other"
    DISJOINT = "two real pairs that do not separate each other"
    POINT_AND_PAIR = "a double point and a real pair without it"
    TWO_POINTS = "two different double points"
    REAL_AND_IMAGINARY = "a real pair and an imaginary pair"
    POINT_AND_IMAGINARY = "a double point and an imaginary pair"
    TWO_IMAGINARY = "two different imaginary pairs"

    @property
    def is_contact(self) -> bool:
        """Whether the pairs have a real point in common."""
        return self in _SHARED


_SHARED = frozenset({
    PointPairs.ONE_SHARED, PointPairs.SAME_PAIR, PointPairs.POINT_OF_PAIR, PointPairs.SAME_POINT,
})  # fmt: skip


def line_resultant(a: MatrixOf[N], b: MatrixOf[N]) -> N:
    """The discriminant of det(l A - B), 2x2: it vanishes where the two pairs share a point, real or not.

    Entries of any ring; for integer polynomials in u this is the contact equation of two conics in space.
    """
    return discriminant(characteristic(a, b))


def point_pairs(a: Rows, b: Rows) -> PointPairs:
    """The configuration of two nonzero symmetric 2x2 matrices over a field."""
    f = characteristic(a, b)
    kind_a, kind_b = sign(f[2]), sign(f[0])  # of det: -1 a real pair, 0 a double point, 1 an imaginary pair
    apart = sign(discriminant(f))
    kinds = min(kind_a, kind_b), max(kind_a, kind_b)
    if kinds == (-1, -1):
        if apart:
            return PointPairs.SEPARATING if apart < 0 else PointPairs.DISJOINT
        return PointPairs.SAME_PAIR if proportional(a, b) else PointPairs.ONE_SHARED
    if kinds == (1, 1):
        return PointPairs.TWO_IMAGINARY if apart else PointPairs.SAME_IMAGINARY
    return {
        (-1, 0): PointPairs.POINT_AND_PAIR if apart else PointPairs.POINT_OF_PAIR,
        (0, 0): PointPairs.TWO_POINTS if apart else PointPairs.SAME_POINT,
        (-1, 1): PointPairs.REAL_AND_IMAGINARY,
        (0, 1): PointPairs.POINT_AND_IMAGINARY,
    }[kinds]


def proportional(a: Rows, b: Rows) -> bool:
    """Whether two symmetric 2x2 matrices are multiples of each other."""
    (p, q), (_, r) = a
    (x, y), (_, z) = b
    return is_zero(p * y - q * x) and is_zero(p * z - r * x) and is_zero(q * z - r * y)


def shared_points(a: MatrixOf[D], b: MatrixOf[D]) -> list[tuple[D, D]]:
    """The real points (s, t) that both pairs contain, for forms (p, q; q, r): p s^2 + 2 q s t + r t^2, one of them not
    zero.  A form that is zero contains all points."""
    if proportional(a, b):
        return binary_zeros(b if all(is_zero(x) for row in a for x in row) else a)
    (p, q), (_, r) = a
    (x, y), (_, z) = b
    # both forms vanish at (s^2, 2 s t, t^2), which is then this cross product
    first, second, third = 2 * (q * z - r * y), r * x - p * z, 2 * (p * y - q * x)
    if not is_zero(first * third - second * second):
        return []
    return [(second, third) if is_zero(first) else (first, second)]


# ----------------------------------------------------------------------------------- two conics of one plane


class ConicMeeting(Enum):
    """How two conics of one plane meet at a singular member of their pencil."""

    TANGENT = "tangent in one point, without crossing"
    OSCULATING = "tangent of order three: they cross there"
    HYPEROSCULATING = "tangent of order four, without crossing"
    TWO_TANGENT = "tangent in two points"
    IMAGINARY = "tangent in two imaginary points"
    VERTEX = "the double point of one conic lies on the other"
    COMMON_LINE = "both contain the same line"
    SAME = "the same conic"

    @property
    def is_contact(self) -> bool:
        """Whether there is a real point of contact."""
        return self is not ConicMeeting.IMAGINARY


@dataclass(frozen=True, slots=True)
class ConicTangency:
    """The member alpha A - beta B, a multiple root of det, and the real points of contact (3-vectors)."""

    meeting: ConicMeeting
    alpha: Any
    beta: Any
    multiplicity: int
    rank: int
    points: tuple[Vector, ...] = ()


@dataclass(frozen=True, slots=True)
class ConicContacts:
    """All tangencies of two conics of a plane; `reason` instead where every member of the pencil is degenerate."""

    tangencies: tuple[ConicTangency, ...]
    reason: str | None = None

    @property
    def contacts(self) -> tuple[ConicTangency, ...]:
        return tuple(t for t in self.tangencies if t.meeting.is_contact)


def conic_contacts(a: Rows, b: Rows, coefficients: Sequence[Divisible] | None = None) -> ConicContacts:
    """Where the conics A and B (symmetric 3x3, over one field, in one plane) touch: proved complete.

    The cubic det(l A - B) has one multiple root at most, rational over the field, and only its member can touch.
    """
    c = characteristic(a, b) if coefficients is None else coefficients
    if all(is_zero(x) for x in c):
        return ConicContacts((), IDENTICALLY_DEGENERATE)
    return ConicContacts(tuple(_tangency(a, b, *root) for root in multiple_roots(c)))


def _tangency(a: Rows, b: Rows, alpha: Number, beta: Number, multiplicity: int) -> ConicTangency:
    g = member(a, b, alpha, beta)
    other = b if is_zero(beta) else a
    vertex = singular_point(g)
    null = null_space(g) if vertex is None else [vertex]
    rank = 3 - len(null)

    def found(meeting: ConicMeeting, points: tuple[Vector, ...] = ()) -> ConicTangency:
        return ConicTangency(meeting, alpha, beta, multiplicity, rank, points)

    if rank == 2:
        if is_zero(alpha) or is_zero(beta) or all(is_zero(y) for y in times(other, null[0])):
            return found(ConicMeeting.VERTEX, (null[0],))
        return found(ConicMeeting.OSCULATING if multiplicity == 3 else ConicMeeting.TANGENT, (null[0],))
    if rank == 0:
        return found(ConicMeeting.SAME)
    # a double line: contact wherever the other conic meets it
    form = congruent(tuple(zip(*null, strict=True)), other)
    positive, negative, zero = inertia(form)
    if zero == 2:
        return found(ConicMeeting.COMMON_LINE, (null[0], null[1]))
    points = tuple(combination(null, y) for y in binary_zeros(form))
    if zero == 1:
        return found(ConicMeeting.HYPEROSCULATING, points)
    return found(ConicMeeting.TWO_TANGENT if positive and negative else ConicMeeting.IMAGINARY, points)
