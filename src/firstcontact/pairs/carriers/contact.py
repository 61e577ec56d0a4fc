"""What the algebraic pair files share: contact equations, contact sets, and linear algebra at one root.

An *equation* is a polynomial in the motion parameter u whose real roots contain every u at which the two carriers
touch; at one of its roots a pair file gives the *contact set* over the number field of that root, or says why the
root carries none.  Everything is homogeneous and free of divisions, so the functions below run on any exact field
(fmpq, the number field of a root, a quadratic extension of it).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from flint import arb, fmpz_poly

from firstcontact.exact.fields.number_field import NumberField, ball, is_zero
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.inertia import dot
from firstcontact.exact.vectors import cross

if TYPE_CHECKING:
    from firstcontact.exact.ring import MatrixOf, N, Number

Vector = tuple[Any, ...]
Form = tuple[tuple[Any, ...], ...]

ONE = fmpz_poly([1])
ZERO = fmpz_poly([0])

CROSSING = "crossing tangency"
AT_INFINITY = "at infinity"
IMAGINARY = "imaginary"
PARALLEL = "planes parallel"


@dataclass(frozen=True)
class Equation:
    """Contact equation of two carriers: `polynomial`, or None and the `reason` why this pair needs none.

    polynomial  every u at which the carriers touch is a root, but for those of `parallel`
    parallel    its real roots are the u at which the carriers' planes are parallel or equal (cases VII, VIII, IX);
                its multiplicity is the one the paper's representation of the common line gives them
    permanent   something is there for all u and was divided out (a multiple root, a common point): the carriers may
                touch at all times, and no root tells
    """

    polynomial: fmpz_poly | None
    reason: str = ""
    parallel: fmpz_poly = field(default_factory=lambda: ONE)
    permanent: bool = False

    @property
    def candidates(self) -> fmpz_poly | None:
        """The polynomial whose real roots, with multiplicity, are the candidate times of Choi et al. 2014."""
        return None if self.polynomial is None else self.polynomial * self.parallel

    @property
    def may_hold_always(self) -> bool:
        """Whether the carriers may touch at every u: roots do not tell, a look at one u does."""
        return self.polynomial is None or self.permanent


@dataclass(frozen=True)
class Contact:
    """One connected real contact set of two whole carriers, in the frame they were given in.

    kind        "point", "line" or "conic"
    span        homogeneous 4-vectors: the point, two points of the line, three points of the conic's plane
    form        for a conic: symmetric 3x3 C, the points sum(y_i span[i]) with y^T C y = 0; else None
    multiplier  sign of l0 where the contact is a null vector of l0 A - B (cases I, III, VIII); solids that touch from
                outside have -1 in case I, +1 says that one is inside the other; 0 where nothing is defined
    note        "" or what the carriers do there: "crossing tangency", "apex", "inside the surface" ...
    """

    kind: Literal["point", "line", "conic"]
    span: tuple[Vector, ...]
    form: Form | None = None
    multiplier: int = 0
    note: str = ""

    def point(self, bits: int = 128) -> tuple[arb, arb, arb]:
        """Balls of the Cartesian coordinates of the point; `bits` more give as many more digits."""
        if self.kind != "point":
            raise ValueError(f"a {self.kind} is not a point")
        x = [ball(coordinate, bits) for coordinate in self.span[0]]
        with precision(bits):
            return x[0] / x[3], x[1] / x[3], x[2] / x[3]


@dataclass(frozen=True)
class Contacts:
    """Real contact sets at one root, and the reason when there are none (or what the root is besides).

    same  whether the carriers are one surface there: the sets are some of what they share, and none where the surface
          has no centre
    complete  whether that is proved to be all
    """

    found: tuple[Contact, ...]
    reason: str = ""
    same: bool = False
    complete: bool = True


def nothing(reason: str) -> Contacts:
    return Contacts((), reason)


# --- polynomials -------------------------------------------------------------------------------------------------


def common_factor(entries: Iterable[fmpz_poly]) -> fmpz_poly:
    """Greatest common divisor of the polynomials; 0 when all vanish."""
    g = ZERO
    for p in entries:
        g = g.gcd(p)
        if g.is_one():
            break
    return g


def columns(matrix: MatrixOf[N]) -> tuple[tuple[N, ...], ...]:
    return tuple(zip(*matrix, strict=True))


def pull_plane(basis: Form, plane: Vector) -> Vector:
    """P^T N: the plane N as a linear form of the parameters of the carrier P."""
    return tuple(dot(column, plane) for column in columns(basis))


def determinant3(a: Sequence[N], b: Sequence[N], c: Sequence[N]) -> N:
    return dot(cross(a, b), c)


def plane_through(a: Vector, b: Vector, c: Vector) -> Vector:
    """The plane N of three points, N.X = det[a b c X]."""
    minors = []
    for k in range(4):
        rows = [i for i in range(4) if i != k]
        minor = determinant3(*(tuple(v[i] for i in rows) for v in (a, b, c)))
        minors.append(minor if k % 2 else -minor)
    return tuple(minors)


def left_inverse(basis: Form) -> tuple[Form, fmpz_poly]:
    """(S, s) with S P = s I (3x4 times 4x3), s = N.N the square of the plane of P, hence positive."""
    a, b, c = columns(basis)
    plane = plane_through(a, b, c)
    rows = (plane_through(c, b, plane), plane_through(a, c, plane), plane_through(b, a, plane))
    return rows, dot(plane, plane)


# --- at one root -------------------------------------------------------------------------------------------------


def vector_at(field: NumberField, vector: Vector) -> Vector:
    return tuple(field(p) for p in vector)


def zero(vector: Sequence[Number]) -> bool:
    return all(is_zero(x) for x in vector)


def finite(span: tuple[Vector, ...], **fields: Any) -> Contacts:
    """The contact set with that span, or "at infinity" when no point of it is finite."""
    if all(is_zero(x[3]) for x in span):
        return nothing(AT_INFINITY)
    kind: Any = ("point", "line", "conic")[len(span) - 1]
    return Contacts((Contact(kind, span, **fields),))


def gather(sets: list[Contacts], otherwise: str) -> Contacts:
    """All of them in one; the reasons of the empty ones, or `otherwise` when there is no set at all."""
    found = tuple(contact for s in sets for contact in s.found)
    reasons = dict.fromkeys(s.reason for s in sets if s.reason)
    return Contacts(found, "; ".join(reasons) or ("" if found else otherwise), any(s.same for s in sets))
