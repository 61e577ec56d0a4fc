"""The real zeros of a plane curve over one algebraic number: all, with multiplicities, enclosed as narrowly as asked.

Over alpha the curve is a polynomial f(alpha, v) with coefficients in Q(alpha).  Its zeros are isolated by balls, which
works where all are simple; so the multiple ones are split off exactly first:
- the discriminant has a simple root at alpha: one double zero, the others are simple;
- it vanishes to higher order: a greatest common divisor of f and f_v modulo a prime, at a root of the minimal
  polynomial there, bounds the exact one from above.  Bound 1: again one double zero, real since it is alone, namely
  that of the first subresultant of f and f_v;
- otherwise, and where alpha is rational: the exact squarefree decomposition.
"""

from __future__ import annotations

from flint import acb_poly, arb, arb_mat, arb_poly, fmpq, fmpq_poly, fmpz, nmod_poly

from firstcontact.exact.fields.field_towers import division, gcd, trimmed
from firstcontact.exact.fields.number_field import FieldElement, NumberField, residue
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots, reversed_polynomial
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.polynomials.bivariate import Rows, evaluate, level, over, polynomial, resultant, slope

FIRST = 64
"""Bits of the first enclosures of zeros."""

LAST = 1 << 15
"""Bits at which a search gives up: every question asked here has an answer, this one a very hidden one."""

class PrecisionExhausted(ArithmeticError):
    """Two different numbers agree to LAST bits; nothing is returned rather than something unproved."""


class ZeroCell:
    """A closed interval of v, or of 1/v where `reversed`."""

    __slots__ = ("hi", "lo", "reversed")

    def __init__(self, reversed: bool, lo: fmpq, hi: fmpq) -> None:
        self.reversed, self.lo, self.hi = reversed, lo, hi

    def end(self, side: int) -> fmpq:
        return self.hi if side else self.lo


class FibreZero:
    """A real zero over alpha: `multiplicity`, and where it lies: on the line `side` (0, 1) or inside cells[`cell`].

    cell and side are None for a zero outside of the cells.
    """

    __slots__ = ("cell", "fibre", "index", "multiplicity", "side", "value")

    def __init__(self, fibre: CurveFibre, multiplicity: int, index: int = -1) -> None:
        self.fibre, self.multiplicity, self.index = fibre, multiplicity, index
        self.cell: int | None = None
        self.side: int | None = None
        self.value: AlgebraicRoot | None = None

    def ball(self, bits: int) -> arb:
        """Around the zero, in the coordinate of its cell, to 2^-bits relative to max(1, its size)."""
        if self.value is not None:
            return self.value.enclosure(bits)
        value = self.fibre.values(bits + 4)[self.index]
        if self.cell is None or not self.fibre.cells[self.cell].reversed:
            return value
        with precision(bits + 32):
            return 1 / value

    def exact(self) -> AlgebraicRoot:
        """The zero, in the coordinate of its cell: a root of Res_u(minimal polynomial of alpha, f)."""
        if self.value is None:
            self.value = self._eliminated()
        return self.value

    def _eliminated(self) -> AlgebraicRoot:
        fibre = self.fibre
        derivative, flip = fibre.rows, self.cell is not None and fibre.cells[self.cell].reversed
        if flip:
            derivative = derivative[::-1]
        minimal = polynomial({(i, 0): c for i, c in enumerate(fibre.alpha.polynomial.coeffs())})
        norm = None
        for _ in range(min(2, self.multiplicity)):
            f = polynomial({(i, j): c for j, a in enumerate(derivative) for i, c in enumerate(a.coeffs())})
            step = resultant(minimal, f, "u")
            norm, derivative = step if norm is None else norm.gcd(step), slope(derivative)
        assert norm is not None
        bits = FIRST
        while bits <= LAST:
            x = self.ball(bits)
            with precision(bits + 32):
                lo, hi = dyadic(x.lower()), dyadic(x.upper())
            found = real_roots(norm, lo, hi)
            if len(found) == 1:
                root = found[0]
                return AlgebraicRoot(root.polynomial, root.lo, root.hi)
            bits *= 2
        raise PrecisionExhausted(f"the zeros of {norm} near {x.str(20)}")


class CurveFibre:
    """The real zeros of the curve `rows` over `alpha`, a number of the chart of the rows.

    rows: of the affine chart of v.  order: that of alpha as a root of disc_v f.  sides: whether f vanishes at alpha
    on the lines v = cells[0].lo and v = cells[0].hi.
    zeros: every real zero in the cells; also those outside if alpha is irrational.
    """

    def __init__(
        self, rows: Rows, alpha: AlgebraicRoot, order: int, cells: list[ZeroCell], sides: tuple[bool, bool]
    ) -> None:
        self.rows, self.alpha, self.order, self.cells = rows, alpha, order, cells
        self._values: tuple[int, list[arb]] | None = None
        self.affine = truncated(rows, alpha)
        self.at_infinity = len(rows) - len(self.affine)
        self.zeros: list[FibreZero] = []
        if alpha.rational is not None:
            self._rational(alpha.rational)
        else:
            self._parts = self._decomposed()
            self._place(sides)

    def inside(self, cell: int) -> list[FibreZero]:
        """The zeros in the open cell, ascending in its coordinate."""
        found = [z for z in self.zeros if z.cell == cell]
        if self.alpha.rational is None and self.cells[cell].reversed:
            # ascending 1/v: from v = -1 down to -oo, through infinity, from +oo down to 1
            below = [z for z in found if z.index >= 0 and self.values(FIRST)[z.index] < 0]
            above = [z for z in found if z.index >= 0 and z not in below]
            return below[::-1] + [z for z in found if z.index < 0] + above[::-1]
        return found

    def on_side(self, side: int) -> FibreZero | None:
        return next((z for z in self.zeros if z.side == side), None)

    def _rational(self, alpha: fmpq) -> None:
        f = over(self.rows, alpha)
        for k, cell in enumerate(self.cells):
            g = reversed_polynomial(f, len(self.rows) - 1) if cell.reversed else f
            for root in real_roots(g, cell.lo, cell.hi) if g.degree() > 0 else []:
                zero = FibreZero(self, root.multiplicity)
                zero.value = root
                if root.rational == cell.lo or root.rational == cell.hi:
                    if k:
                        continue  # the lines are common to all cells
                    zero.side = int(root.rational == cell.hi)
                else:
                    zero.cell = k
                self.zeros.append(zero)

    def _decomposed(self) -> list[tuple[list[FieldElement] | None, int]]:
        """Squarefree parts with their multiplicities; None stands for the whole, or for its one double zero."""
        if self.order == 0 or (self.order == 1 and self.at_infinity >= 2):
            return [(None, 1)]
        bound = 1 if self.order == 1 else degree_bound(self.alpha, self.affine, slope(self.affine))
        if bound == 0:
            return [(None, 1)]
        if bound == 1 and self.at_infinity < 2:
            return [(None, 1), (None, 2)]
        return list(squarefree_parts(self.field_coefficients(self.affine)))

    def field_coefficients(self, rows: Rows) -> list[FieldElement]:
        field = _Reduced(self.alpha)
        return [field(c) for c in rows]

    def values(self, bits: int) -> list[arb]:
        """Disjoint balls around all real zeros, ascending; alpha is irrational.  More bits keep the order."""
        if self._values is not None and self._values[0] >= bits:
            return self._values[1]
        work = bits + 64
        while work <= 4 * LAST:
            x = self.alpha.enclosure(work)
            with precision(work):
                found = self._isolated(x, bits)
            if found is not None:
                self._values = bits, found
                return found
            work *= 2
        raise PrecisionExhausted(f"the zeros over {self.alpha}")

    def _isolated(self, x: arb, bits: int) -> list[arb] | None:
        whole = [c(x) for c in self.affine]
        found: list[tuple[arb, int]] = []
        if len(self._parts) == 2 and self._parts[1][0] is None:
            double = _double_zero(whole)
            if double is None:
                return None
            found.append((double, 2))
            whole = _deflated(_deflated(whole, double), double)
        for part, multiplicity in self._parts[: 1 if self._parts[0][0] is None else None]:
            zeros = simple_zeros(whole if part is None else [_at(c, x) for c in part], bits + 4)
            if zeros is None:
                return None
            found += [(z, multiplicity) for z in zeros]
        found.sort(key=lambda pair: float(pair[0].mid()))
        balls = [z for z, _ in found]
        if any(not a < b for a, b in zip(balls, balls[1:], strict=False)):
            return None
        # rel_accuracy_bits of the radius against 1 or the size, whichever is larger
        if any(max(z.rel_one_accuracy_bits(), z.rel_accuracy_bits()) < bits for z in balls):
            return None
        self._multiplicities = [m for _, m in found]
        return balls

    def _place(self, sides: tuple[bool, bool]) -> None:
        lines = (self.cells[0].lo, self.cells[0].hi)
        bits = FIRST
        while bits <= LAST:
            values = self.values(bits)
            on = [[k for k, z in enumerate(values) if z.contains(arb(c))] for c in lines]
            if all(len(near) == known for near, known in zip(on, sides, strict=True)):
                break
            bits *= 2
        else:
            raise PrecisionExhausted(f"zeros over {self.alpha} beside {lines}")
        for k, z in enumerate(values):
            zero = FibreZero(self, self._multiplicities[k], k)
            for side in (0, 1):
                if on[side] == [k]:
                    zero.side, zero.value = side, AlgebraicRoot.of(lines[side])
            if zero.side is None:
                if z > lines[0] and z < lines[1]:
                    zero.cell = 0
                elif len(self.cells) > 1:
                    zero.cell = 1
            self.zeros.append(zero)
        if self.at_infinity and len(self.cells) > 1:
            zero = FibreZero(self, self.at_infinity)
            zero.cell, zero.value = 1, AlgebraicRoot.of(fmpq(0))
            self.zeros.append(zero)

    def shared(self, other: Rows, order: int) -> list[FibreZero]:
        """The zeros at which another polynomial vanishes as well; order: that of alpha as a root of Res_v(f, it)."""
        if order == 0:
            return []
        if self.alpha.rational is not None:
            return [z for z in self.zeros if self._vanishes(z, other)]
        affine = truncated(other, self.alpha)
        if not affine:
            return self.zeros
        common_at_infinity = self.at_infinity > 0 and len(affine) < len(other)
        infinite = [z for z in self.zeros if z.index < 0 and common_at_infinity]
        finite = [z for z in self.zeros if z.index >= 0]
        expected = self._number_shared(affine, order, common_at_infinity)
        bits = FIRST
        while bits <= LAST:
            values, x = self.values(bits), self.alpha.enclosure(bits + 32)
            with precision(bits + 32):
                near = [z for z in finite if evaluate(affine, x, values[z.index]).contains(0)]
            if len(near) == expected:
                return near + infinite
            bits *= 2
        raise PrecisionExhausted(f"zeros common to two curves over {self.alpha}")

    def _vanishes(self, zero: FibreZero, other: Rows) -> bool:
        """At a rational alpha."""
        assert zero.value is not None and self.alpha.rational is not None
        if zero.side is not None:
            return self.alpha.sign_of(level(other, self.cells[0].end(zero.side))) == 0
        assert zero.cell is not None
        flipped = other[::-1] if self.cells[zero.cell].reversed else other
        return zero.value.sign_of(over(flipped, self.alpha.rational)) == 0

    def _number_shared(self, other: Rows, order: int, common_at_infinity: bool) -> int:
        """How many real zeros (finite) are common."""
        if order == 1:
            return 0 if common_at_infinity else 1
        bound = degree_bound(self.alpha, self.affine, other)
        if bound == 0:
            return 0
        if bound == 1 and not common_at_infinity:
            return 1
        common = gcd(self.field_coefficients(self.affine), self.field_coefficients(other))
        number, work = 0, 2 * FIRST
        for part, _ in squarefree_parts(common):
            zeros = None
            while zeros is None:
                if work > LAST:
                    raise PrecisionExhausted(f"common zeros over {self.alpha}")
                x = self.alpha.enclosure(work)
                with precision(work):
                    zeros = simple_zeros([_at(c, x) for c in part])
                work *= 2
            number += len(zeros)
        return number


class _Reduced(NumberField):
    """Q(alpha) with every product reduced: greatest common divisors would let unreduced ones explode."""

    __slots__ = ()

    def reduced(self, q: fmpq_poly) -> fmpq_poly:
        return q % self.modulus


def truncated(rows: Rows, alpha: AlgebraicRoot) -> Rows:
    """Without the leading coefficients that vanish at alpha: as many zeros lie at infinity."""
    n = len(rows)
    while n and alpha.sign_of(rows[n - 1]) == 0:
        n -= 1
    return rows[:n]


def degree_bound(alpha: AlgebraicRoot, f: Rows, g: Rows) -> int | None:
    """An upper bound of the degree of gcd(f(alpha, v), g(alpha, v)); None where a prime divides a leading coefficient.

    f's leading coefficient is not zero at alpha.
    """
    p, zero = residue(alpha.polynomial)
    images = [nmod_poly([int(nmod_poly(c.coeffs(), p)(zero)) for c in h], p) for h in (f, g)]
    return int(images[0].gcd(images[1]).degree()) if images[0].degree() == len(f) - 1 else None


def squarefree_parts(f: list[FieldElement]) -> list[tuple[list[FieldElement], int]]:
    """Pairwise coprime squarefree polynomials over the field with their multiplicities in f; constants left out."""
    f = trimmed(f)
    if len(f) < 2:
        return []
    rest = gcd(f, slope(f))
    distinct = division(f, rest)[0]
    parts, multiplicity = [], 1
    while len(distinct) > 1:
        repeated = gcd(distinct, rest)  # zeros of higher multiplicity
        part = division(distinct, repeated)[0]
        if len(part) > 1:
            parts.append((part, multiplicity))
        distinct, rest, multiplicity = repeated, division(rest, repeated)[0], multiplicity + 1
    return parts


def _at(c: FieldElement, x: arb) -> arb:
    return c.value.numer()(x) / arb(c.value.denom())


def _double_zero(f: list[arb]) -> arb | None:
    """The one zero common to f and f', from their first subresultant; None where the balls are too wide."""
    g = [j * f[j] for j in range(1, len(f))]
    a, b = len(f) - 1, len(g) - 1
    table = []
    for p, shifts in ((f, b - 1), (g, a - 1)):
        for shift in range(shifts - 1, -1, -1):
            row = [arb(0)] * (a + b - 1)
            row[shift : shift + len(p)] = p
            table.append(row[::-1])
    slope_, value = (arb_mat([row[: a + b - 3] + [row[k]] for row in table]).det() for k in (-2, -1))
    return None if slope_.contains(0) else -value / slope_


def _deflated(f: list[arb], zero: arb) -> list[arb]:
    """f / (v - zero), the remainder left out."""
    quotient = [f[-1]]
    for c in reversed(f[1:-1]):
        quotient.append(c + zero * quotient[-1])
    return quotient[::-1]


def simple_zeros(f: list[arb], bits: int = 8) -> list[arb] | None:
    """Balls around the real zeros of a squarefree polynomial, to 2^-bits; None where the precision does not suffice."""
    if f[-1].contains(0):
        return None
    if len(f) < 2:
        return []
    if len(f) == 2:
        return [-f[0] / f[1]]
    try:
        zeros = acb_poly(arb_poly(f)).roots(tol=arb(2) ** -bits)
    except ValueError:
        return None  # python-flint's way to say that the precision does not suffice
    real = []
    for k, z in enumerate(zeros):
        if not z.imag.contains(0):
            continue
        # the conjugate of a zero is one: the zero is real if only its own ball reaches the conjugate ball
        mirror = z.conjugate()
        if any(mirror.overlaps(w) for j, w in enumerate(zeros) if j != k):
            return None
        real.append(z.real)
    return real


def simple_between(lo: fmpq, hi: fmpq) -> fmpq:
    """A dyadic number in the open interval, with few bits."""
    if lo < 0 < hi:
        return fmpq(0)
    width = hi - lo
    exponent = int(width.p).bit_length() - int(width.q).bit_length() + 3
    step = fmpq(2) ** exponent if exponent >= 0 else 1 / fmpq(2) ** -exponent
    while True:
        x = (fmpz((lo / step).floor()) + 1) * step
        if x < hi:
            return x
        step /= 2
