"""Polynomials in u and v with integer coefficients: univariate views, restrictions, elimination, factors, exact signs.

Two forms.  `fmpz_mpoly` in CONTEXT for elimination and factors; and *rows* [a_0(u), a_1(u), ...], f = sum a_j v^j, for
everything that happens over one u: rows of a chart with u -> 1/u or v -> 1/v are reversals.
"""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from flint import fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly, fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from firstcontact.exact.fields.field_towers import TowerElement
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import FIRST_BITS, AlgebraicRoot, reversed_polynomial
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials import by_values

if TYPE_CHECKING:
    from firstcontact.exact.ring import E, N

CONTEXT = fmpz_mpoly_ctx.get(("u", "v"), "lex")
U, V = CONTEXT.gens()

Rows = list[fmpz_poly]


def polynomial(coefficients: Mapping[tuple[int, int], fmpz | int]) -> fmpz_mpoly:
    """The polynomial with the coefficient c of u^i v^j for (i, j): c."""
    return CONTEXT.from_dict(dict(coefficients))  # type: ignore[arg-type]  # pairs are tuples of any length


def in_u(p: fmpz_poly) -> fmpz_mpoly:
    return CONTEXT.from_dict({(i, 0): c for i, c in enumerate(p.coeffs()) if c})


def in_v(p: fmpz_poly) -> fmpz_mpoly:
    return CONTEXT.from_dict({(0, j): c for j, c in enumerate(p.coeffs()) if c})


def univariate(f: fmpz_mpoly, variable: str) -> fmpz_poly:
    """f as a polynomial of its only variable."""
    index, degree = _index(variable), f.degrees()[_index(variable)]
    coefficients = [fmpz(0)] * (degree + 1)
    for exponents, c in zip(f.monoms(), f.coeffs(), strict=True):
        coefficients[int(exponents[index])] = c
    return fmpz_poly(coefficients)


def rows(f: fmpz_mpoly, variable: str = "v") -> Rows:
    """The coefficients of the powers of `variable`, ascending: polynomials in the other one."""
    degrees, index = f.degrees(), _index(variable)
    table = [[fmpz(0)] * (degrees[1 - index] + 1) for _ in range(degrees[index] + 1)]
    for exponents, c in zip(f.monoms(), f.coeffs(), strict=True):
        table[int(exponents[index])][int(exponents[1 - index])] = c
    return [fmpz_poly(row) for row in table]


def _index(variable: str) -> int:
    return ("u", "v").index(variable)


def restrict(f: fmpz_mpoly, variable: str, x: fmpq) -> fmpz_poly:
    """A positive multiple of f on the line variable = x."""
    return over(rows(f, "v" if variable == "u" else "u"), x)


def from_rows(a: Rows) -> fmpz_mpoly:
    return CONTEXT.from_dict({(i, j): c for j, p in enumerate(a) for i, c in enumerate(p.coeffs()) if c})


def over(a: Rows, x: fmpq) -> fmpz_poly:
    """A positive multiple of f(x, v)."""
    return fmpq_poly([c(x) for c in a]).numer()


def level(a: Rows, y: fmpq) -> fmpz_poly:
    """A positive multiple of f(u, y)."""
    if not a:
        return fmpz_poly([])
    total, p, q, power = a[-1], y.p, y.q, fmpz(1)
    for c in reversed(a[:-1]):
        power *= q
        total = total * p + c * power
    return total


def chart(a: Rows, reversed_u: bool, reversed_v: bool, degree: int) -> Rows:
    """Rows of u^n f(1/u, v), v^m f(u, 1/v) or both; n = `degree`, m that of the rows."""
    if reversed_u:
        a = [reversed_polynomial(c, degree) for c in a]
    return a[::-1] if reversed_v else list(a)


def slope(a: Sequence[N]) -> list[N]:
    """Rows of df/dv."""
    return [j * a[j] for j in range(1, len(a))]


def resultant(f: fmpz_mpoly, g: fmpz_mpoly, variable: str = "v") -> fmpz_poly:
    """The polynomial in the other variable that vanishes where f and g share a zero, at infinity included."""
    if f.is_zero() or g.is_zero():
        return fmpz_poly([0])
    m, n = f.degrees()[_index(variable)], g.degrees()[_index(variable)]
    other = "u" if variable == "v" else "v"
    if by_values.is_quicker(m, n):
        return by_values.resultant(rows(f, variable), rows(g, variable))
    if m and n:
        return univariate(f.resultant(g, variable), other)
    return univariate(f, other) ** n if m == 0 else univariate(g, other) ** m


def discriminant(f: fmpz_mpoly, variable: str = "v") -> fmpz_poly:
    """That of f as a form in `variable`: zero where two of its zeros meet, at infinity included."""
    other, n = "u" if variable == "v" else "v", f.degrees()[_index(variable)]
    if n < 2:
        return fmpz_poly([1])
    if by_values.is_quicker(n, n - 1):
        return by_values.discriminant(rows(f, variable))
    return univariate(f.discriminant(variable), other)


class Factors(NamedTuple):
    """Irreducible primitive factors with their multiplicities, the ones in a single variable apart."""

    in_u: list[tuple[fmpz_poly, int]]
    in_v: list[tuple[fmpz_poly, int]]
    curves: list[tuple[fmpz_mpoly, int]]


def factors(f: fmpz_mpoly) -> Factors:
    """The factors of f, without its constant; f must not be zero."""
    if f.is_zero():
        raise ValueError("the zero polynomial has no factors")
    found = []
    for variable in ("v", "u"):
        content = fmpz_poly([])
        for c in rows(f, variable):
            content = content.gcd(c)
        if content.degree() > 0:
            f = f // (in_u(content) if variable == "v" else in_v(content))
        found.append(content.factor()[1])
    curves = [] if f.is_constant() else factored(f)
    return Factors(found[0], found[1], curves)


def irreducible(polynomials: Iterable[fmpz_mpoly]) -> list[fmpz_mpoly]:
    """The irreducible factors of all of them, each once; zeros and constants have none."""
    found: list[fmpz_mpoly] = []
    for f in polynomials:
        if f.is_zero() or f.is_constant():
            continue
        parts = factors(f)
        own = [g for g, _ in parts.curves] + [in_u(g) for g, _ in parts.in_u] + [in_v(g) for g, _ in parts.in_v]
        found += [g for g in own if g not in found]
    return found


def factored(f: fmpz_mpoly) -> list[tuple[fmpz_mpoly, int]]:
    """The irreducible factors with multiplicities, without the constant; in any number of variables."""
    ring = f.context()
    try:
        with _signals_wait():
            found = f.factor()[1]
        return [(g, int(e)) for g, e in found]
    except OverflowError:
        # python-flint sorts the factors by keys that large coefficients overflow; over Q it does not
        wider = fmpq_mpoly_ctx.get(ring.names(), "lex").from_dict(f.to_dict())
    with _signals_wait():
        over_q = wider.factor()[1]
    return [(_integral(g, ring), int(e)) for g, e in over_q]


def squarefree_factors(f: fmpz_mpoly) -> list[tuple[fmpz_mpoly, int]]:
    """The squarefree factors with multiplicities, without the constant; in any number of variables."""
    with _signals_wait():
        found = f.factor_squarefree()[1]
    return [(g, int(e)) for g, e in found]


@contextmanager
def _signals_wait() -> Iterator[None]:
    """An interrupt waits for the end of the block: where python-flint sorts factors, it would be lost."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGALRM, signal.SIGTERM))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _integral(g: fmpz_mpoly | fmpq_mpoly, ring: fmpz_mpoly_ctx) -> fmpz_mpoly:
    terms = {tuple(map(int, k)): fmpq(c) for k, c in g.to_dict().items()}
    common = fmpz(1)
    for c in terms.values():
        common = common.lcm(c.q)
    return ring.from_dict({k: (c * common).p for k, c in terms.items()}).primitive()[1]


def sign_at(f: fmpz_mpoly, x: AlgebraicRoot | fmpq, y: AlgebraicRoot | fmpq) -> int:
    """Sign of f(x, y), exactly.

    Zero is decided by Res_v(f, minimal polynomial of y) at x, which is zero if f(x, y') is for one conjugate y' of y,
    and then by a greatest common divisor over the field of x.
    """
    x = x if isinstance(x, AlgebraicRoot) else AlgebraicRoot.of(x)
    y = y if isinstance(y, AlgebraicRoot) else AlgebraicRoot.of(y)
    if x.rational is not None:
        return y.sign_of(restrict(f, "u", x.rational))
    if y.rational is not None:
        return x.sign_of(restrict(f, "v", y.rational))
    a, bits = rows(f), FIRST_BITS
    found, decided = enclosed_sign(a, x, y, bits), False
    while found == 0:
        if not decided:
            if x.sign_of(resultant(f, in_v(y.polynomial))) == 0:
                field = NumberField(x)
                return TowerElement(field, y, [field(c) for c in a]).sign()
            decided = True  # not zero: some precision shows the sign
        bits *= 2
        found = enclosed_sign(a, x, y, bits)
    return found


def enclosed_sign(a: Rows, x: AlgebraicRoot, y: AlgebraicRoot, bits: int) -> int:
    """The sign that balls of so many bits show; 0 where they show none."""
    x_ball, y_ball = x.enclosure(bits), y.enclosure(bits)
    with precision(bits):
        value = evaluate(a, x_ball, y_ball)
    return 1 if value > 0 else -1 if value < 0 else 0


def evaluate(a: Rows, x: E, y: E) -> E:
    """f(x, y) on fmpq or on balls at the present precision."""
    total = x * 0
    for c in reversed(a):
        total = total * y + c(x)
    return total
