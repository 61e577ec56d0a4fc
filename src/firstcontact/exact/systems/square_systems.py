"""Contacts that no single polynomial describes: simple zeros (x, y, z, u) of four equations, proved and refined.

The equations are quadratic forms of X = (x, y, z, 1) with polynomials in u as coefficients; three forms come with the
determinant of their gradients, which vanishes where the curve of two of them touches the third (for the curve of
degree 4 of two quadrics: re-derived).  Krawczyk's test in ball arithmetic proves that a box holds exactly one zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import arb, arb_mat, fmpq, fmpz_poly

from firstcontact.exact.fields.number_field import ExactNumber
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import Undecidable, dyadic, nearest_double, precision
from firstcontact.exact.polynomials.polynomial_matrix import Matrix
from firstcontact.exact.vectors import det

MOST_BITS = 512
"""Roots closer than this count as one; signs that do not show by then stay open."""


class Equations:
    """As many equations as unknowns, by balls: what Newton's method and Krawczyk's test need of them."""

    def values(self, x: Sequence[arb]) -> list[arb]:
        """The left sides at the balls x."""
        raise NotImplementedError

    def jacobian(self, x: Sequence[arb]) -> list[list[arb]]:
        """Their derivatives, row by row."""
        raise NotImplementedError

    def newton(self, x: Sequence[arb], bits: int) -> list[arb] | None:
        """The zero that Newton's method finds from the midpoints of x, as midpoints; None if it finds none."""
        point = [arb(c.mid()) for c in x]
        for _ in range(12 + bits.bit_length()):
            try:
                step = arb_mat(self.jacobian(point)).solve(arb_mat([[v] for v in self.values(point)]))
            except ZeroDivisionError:
                return None
            point = [arb((c - d).mid()) for c, (d,) in zip(point, step.tolist(), strict=True)]
            if not all(c.is_finite() for c in point):
                return None
            least = arb(2) ** -bits
            if all(abs(d.mid()) <= least * (1 + abs(c)) for c, (d,) in zip(point, step.tolist(), strict=True)):
                return point
        return None

    def krawczyk(self, centre: Sequence[arb], radii: Sequence[arb]) -> list[arb] | None:
        """An enclosure of the only zero in the box centre +- radii; None where this is not proved.

        It lies inside Krawczyk's image of the box when that is inside the box (Krawczyk 1969).
        """
        offset = [arb(0, r) for r in radii]
        slopes = arb_mat(self.jacobian([c + d for c, d in zip(centre, offset, strict=True)]))
        moved = krawczyk_image(self.values(centre), slopes, offset)
        if moved is None or not all(d.contains_interior(i) for d, i in zip(offset, moved, strict=True)):
            return None
        return [c + i for c, i in zip(centre, moved, strict=True)]

    def narrowed(self, box: Sequence[arb]) -> list[arb] | None:
        """What Krawczyk's image leaves of a box with a zero, quadratically small; None where there is no image."""
        centre, offset = [arb(c.mid()) for c in box], [arb(0, c.rad()) for c in box]
        moved = krawczyk_image(self.values(centre), arb_mat(self.jacobian(box)), offset)
        if moved is None or not all(d.is_finite() for d in moved):
            return None
        return [c + i.intersection(d) for c, i, d in zip(centre, moved, offset, strict=True)]


def krawczyk_image(
    values: Sequence[arb], slopes: arb_mat, offset: Sequence[arb], y: arb_mat | None = None
) -> list[arb] | None:
    """Krawczyk's image -Y f(c) + (1 - Y J) offset of a box, less its centre c; None where Y does not exist.

    values: f(c); slopes: J over the box; Y is any matrix, where none is given the inverse of the middle of J.  All
    zeros of the box are in its image.
    """
    if y is None:
        try:
            y = slopes.mid().inv().mid()
        except ZeroDivisionError:
            return None
    n = len(offset)
    one = arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
    moved = (one - y * slopes) * arb_mat(n, 1, offset) - y * arb_mat(n, 1, values)
    return moved.entries()  # type: ignore[no-any-return]


class FormEquations(Equations):
    """Quadratic forms of X = (x, y, z, 1) that depend on u, and determinants of their gradients, which are zero where
    these lie in one plane: of three forms that of all; of two, those with either vector `across`."""

    across: Sequence[Sequence[arb]] = ()

    def at(self, u: arb) -> tuple[list[Rows], list[Rows]]:
        """The forms and their derivatives at u."""
        raise NotImplementedError

    def values(self, x: Sequence[arb]) -> list[arb]:
        """The four left sides at the balls, or rationals, x, y, z, u."""
        point: list[Any] = [*x[:3], 1]
        images = [_image(form, point) for form in self.at(x[3])[0]]
        flat = self._in_plane([image[:3] for image in images], self.across)
        return [_dot(point, image) for image in images] + [det(*rows) for rows in flat]

    def jacobian(self, x: Sequence[arb]) -> list[list[arb]]:
        """Their derivatives by x, y, z, u, row by row."""
        point = [*x[:3], arb(1)]
        forms, slopes = self.at(x[3])
        images, moved = ([_image(form, point) for form in both] for both in (forms, slopes))
        rows = [[*(2 * c for c in g[:3]), _dot(point, m)] for g, m in zip(images, moved, strict=True)]
        still = [[arb(0)] * 3 for _ in self.across]
        columns = [[[form[j][k] for j in range(3)] for form in forms] for k in range(3)] + [[m[:3] for m in moved]]
        changes = [self._in_plane(by, still) for by in columns]
        for n, gradients in enumerate(self._in_plane([image[:3] for image in images], self.across)):
            rows.append([
                sum((det(*(by[n][j] if i == j else g for i, g in enumerate(gradients))) for j in range(3)), arb(0))
                for by in changes
            ])  # fmt: skip
        return rows

    def _in_plane(
        self, gradients: Sequence[Sequence[arb]], across: Sequence[Sequence[arb]]
    ) -> list[Sequence[Sequence[arb]]]:
        """Threes of vectors that are in one plane."""
        return [gradients] if len(gradients) == 3 else [[way, *gradients] for way in across]


class SquareSystem(FormEquations):
    """forms: four symmetric 4x4 matrices over fmpz_poly, or three, which stand with the tangency determinant."""

    def __init__(self, forms: Sequence[Matrix]) -> None:
        self.forms = tuple(forms)
        self.slopes = tuple(tuple(tuple(p.derivative() for p in row) for row in form) for form in forms)
        self.degree = max(1, *(p.degree() for form in forms for row in form for p in row))

    def vanishes_at(self, x: Sequence[fmpq], u: fmpq) -> bool:
        """Whether a rational point is a zero, exactly."""
        exact: Sequence[Any] = (*x, u)
        return all(value == 0 for value in self.values(exact))

    def at(self, u: arb) -> tuple[list[Rows], list[Rows]]:
        forms, slopes = ([[[p(u) for p in row] for row in form] for form in both] for both in (self.forms, self.slopes))
        return forms, slopes


Rows = list[list[arb]]


def _image(form: Rows, x: Sequence[arb]) -> list[arb]:
    return [_dot(row, x) for row in form]


def _dot(x: Sequence[arb], y: Sequence[arb]) -> arb:
    total = x[0] * y[0]
    for a, b in zip(x[1:], y[1:], strict=True):
        total += a * b
    return total


def certified(system: Equations, centre: Sequence[fmpq], radii: Sequence[fmpq], bits: int = 192) -> Zero | None:
    """The only zero near the box, if one box that holds all of it proves to have exactly one."""
    with precision(bits):
        middle = [arb(arb(c).mid()) for c in centre]
        reach = [arb((2 * arb(r)).upper()) for r in radii]
        found = system.krawczyk(middle, reach)
        if found is not None:
            return Zero(system, middle, reach, found)
        start = system.newton(middle, bits // 2)
        if start is None:
            return None
        reach = [2 * (abs(s - arb(c)) + arb(r)) for s, c, r in zip(start, centre, radii, strict=True)]
        reach = [arb(r.upper()) for r in reach]
        found = system.krawczyk(start, reach)
        return None if found is None else Zero(system, start, reach, found)


class Zero:
    """A simple zero of a system, unique in the box centre +- reach."""

    def __init__(self, system: Equations, centre: list[arb], reach: list[arb], balls: list[arb]) -> None:
        self.system, self.centre, self.reach = system, centre, reach
        self._balls, self._bits = balls, 0
        if not self._refined(96):
            self._bits = 1

    def owns(self, centre: Sequence[fmpq], radii: Sequence[fmpq]) -> bool:
        """Whether the box lies inside the one with this zero only."""
        with precision(128):
            return all(
                abs(arb(c) - m) + arb(r) < s
                for c, r, m, s in zip(centre, radii, self.centre, self.reach, strict=True)
            )

    def balls(self, bits: int) -> list[arb]:
        """The unknowns within about 2^-bits; wider where the precision that asks for is beyond reason."""
        if self._bits < bits <= 8 * MOST_BITS:
            self._refined(bits)
        return self._balls

    def _refined(self, bits: int) -> bool:
        with precision(2 * bits + 64):
            balls, least = self._balls, arb(2) ** (-bits - 8)
            while wide := [k for k, c in enumerate(balls) if c.rad() > least * (1 + abs(c))]:
                sharper = self.system.narrowed(balls)
                if sharper is None or not any(2 * sharper[k].rad() < balls[k].rad() for k in wide):
                    return False  # not for what is narrow enough: an unknown that is zero has no narrowest ball
                balls = sharper
            self._balls, self._bits = balls, bits
            return True

    def is_same(self, other: Zero) -> bool:
        """Whether both are one zero: found again where only one is."""
        x = other.balls(128)
        with precision(256):
            return all(arb(m, r).contains(c) for m, r, c in zip(self.centre, self.reach, x, strict=True))


class EnclosedRoot:
    """The u of a zero.  It is compared with others by enclosures: nearer than MOST_BITS bits counts as equal."""

    rational = None
    polynomial = None
    multiplicity = 1

    def __init__(self, zero: Zero) -> None:
        self.zero = zero

    @property
    def lo(self) -> fmpq:
        with precision(160):
            return dyadic(arb(self.enclosure(96).lower()))

    @property
    def hi(self) -> fmpq:
        with precision(160):
            return dyadic(arb(self.enclosure(96).upper()))

    def enclosure(self, bits: int) -> arb:
        return self.zero.balls(bits)[3]

    def sign_of(self, q: Callable[[arb], arb]) -> int:
        """Sign of the polynomial at the root; 0 also where MOST_BITS bits do not tell."""
        bits = 96
        while bits <= MOST_BITS:
            x = self.enclosure(bits)
            with precision(bits):
                value = q(x)
            if value > 0 or value < 0:
                return 1 if value > 0 else -1
            bits *= 2
        return 0

    def compare(self, other: AlgebraicRoot | EnclosedRoot | OpenRoot | fmpq) -> int:
        """-1, 0, 1: below, not told apart, above."""
        if isinstance(other, OpenRoot):
            return -other.compare(self)
        bits = 96
        while bits <= MOST_BITS:
            x = self.enclosure(bits)
            with precision(bits):
                y = arb(other) if isinstance(other, fmpq) else other.enclosure(bits)
                if x < y:
                    return -1
                if x > y:
                    return 1
            bits *= 2
        return 0

    def __float__(self) -> float:
        bits = 96
        while True:
            x = self.enclosure(bits)
            with precision(2 * bits):
                near = nearest_double(x)
            if near is not None or bits > MOST_BITS:
                return float(x.mid()) if near is None else near
            bits *= 2

    def number(self) -> None:
        """No exact form of it is known."""
        return None

    def __repr__(self) -> str:
        return f"EnclosedRoot({float(self)!r})"


class OpenRoot:
    """A stretch lo <= u <= hi in which a contact could neither be found nor excluded; in order of time it is its lo."""

    polynomial = None
    multiplicity = 0

    def __init__(self, lo: fmpq, hi: fmpq, reason: str) -> None:
        self.lo, self.hi, self.reason = lo, hi, reason

    @property
    def rational(self) -> fmpq:
        return self.lo

    def enclosure(self, bits: int) -> arb:
        """That of lo."""
        with precision(bits):
            return arb(self.lo)

    def sign_of(self, q: fmpz_poly) -> int:
        value = q(self.lo)
        return (value > 0) - (value < 0)

    def compare(self, other: AlgebraicRoot | EnclosedRoot | OpenRoot | fmpq) -> int:
        if isinstance(other, OpenRoot):
            return (self.lo > other.lo) - (self.lo < other.lo)
        # before what it may be simultaneous with
        behind = other - self.lo if isinstance(other, fmpq) else other.compare(self.lo)
        return -1 if behind >= 0 else 1

    def __float__(self) -> float:
        with precision(96):
            return float(arb(self.lo).mid())

    def number(self) -> None:
        return None

    def __repr__(self) -> str:
        return f"OpenRoot({float(self)!r}, {self.reason})"


class EnclosedNumber(ExactNumber):
    """A function of a zero, known by balls as small as asked."""

    __slots__ = ("function", "zero")

    def __init__(self, zero: Zero, function: Callable[..., arb]) -> None:
        self.zero, self.function = zero, function

    def ball(self, bits: int) -> arb:
        x = self.zero.balls(bits)
        with precision(bits + 64):
            return self.function(x)

    def sign(self) -> int:
        bits = 96
        while bits <= MOST_BITS:
            x = self.ball(bits)
            if x > 0 or x < 0:
                return 1 if x > 0 else -1
            bits *= 2
        raise Undecidable("a sign at a contact of degree-4 edges")
