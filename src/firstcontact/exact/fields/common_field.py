"""Zeros of polynomials over Q(r), each in one field Q(w) that holds r too.

Mostly the zero s itself generates that field; otherwise s + k r does for some small k.  Over Q(w) the minimal
polynomial of r and the given polynomial at s = w - k r then share one zero, r itself: their greatest common divisor.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from flint import fmpq, fmpq_poly, fmpz, fmpz_poly

from firstcontact.errors import UnsupportedPair
from firstcontact.exact.expressions import context
from firstcontact.exact.fields import field_towers
from firstcontact.exact.fields.field_towers import division, trimmed
from firstcontact.exact.fields.number_field import FieldElement, NumberField, sign
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots

MOST_DEGREE = 64
_RING = context(("w", "x"))
Polynomial = list[FieldElement]
"""Ascending coefficients, the last not zero; [] is zero."""


@dataclass(frozen=True)
class Adjoined:
    """A zero and a field that holds it and the former field; `carry` maps elements of that one into this one."""

    field: NumberField
    zero: FieldElement
    carry: Callable[[FieldElement], FieldElement]


def adjoined(field: NumberField, f: Sequence[FieldElement], lo: fmpq, hi: fmpq) -> list[Adjoined]:
    """The real zeros of f != 0 in [lo, hi]; UnsupportedPair beyond MOST_DEGREE."""
    f = squarefree(trimmed(list(f)))
    if len(f) < 2:
        return []
    if len(f) == 2:
        zero = (-f[0] / f[1]).reduced()
        return [Adjoined(field, zero, lambda x: x)] if within(zero, lo, hi) else []
    if field.root.rational is not None:
        p = fmpq_poly([x.value[0] for x in f]).numer()
        return [_simple(root) for root in real_roots(p, lo, hi)]
    if field.modulus.degree() * (len(f) - 1) > MOST_DEGREE:
        raise UnsupportedPair(
            f"too large for elimination: a contact of degree {field.modulus.degree() * (len(f) - 1)}; "
            "ask for the intervals alone"
        )
    for k in range(4 * MOST_DEGREE**2):
        found = _with_multiple(field, f, k, lo, hi)
        if found is not None:
            return found
    raise ArithmeticError("no multiple of one number makes a primitive element")


def _simple(root: AlgebraicRoot) -> Adjoined:
    own = NumberField(root)
    return Adjoined(own, own.generator(), lambda x: own(x.value[0]))


def _with_multiple(field: NumberField, f: Polynomial, k: int, lo: fmpq, hi: fmpq) -> list[Adjoined] | None:
    """The zeros with w = s + k r; None where some w does not generate both."""
    r = field.root
    n = _norm(r.polynomial, f, k)
    ends = (lo + k * r.lo, hi + k * r.hi)
    found = []
    for w in real_roots(n, *ends):
        own = NumberField(w)
        at = own.generator()
        # f(w - k x, x) as a polynomial in x over Q(w)
        g = _shifted(own, f, at, k)
        common = gcd([own(c) for c in fmpq_poly(r.polynomial).coeffs()], g)
        if len(common) > 2:
            return None
        if len(common) < 2:
            continue
        image = (-common[0] / common[1]).reduced()
        zero = at - image * k
        if within(image, r.lo, r.hi) and within(zero, lo, hi):
            found.append(Adjoined(own, zero, _carrier(own, image)))
    return found


def _norm(modulus: fmpz_poly, f: Polynomial, k: int) -> fmpz_poly:
    """Res_x(modulus(x), sum f_i(x) (w - k x)^i), a polynomial in w."""
    w, x = _RING.gens()
    common = fmpz(1)
    for c in f:
        common = common.lcm(c.value.denom())
    total = _RING.constant(0)
    for c in reversed(f):
        own = c.value * fmpq(common)
        total = total * (w - k * x) + _in_x(own.numer())
    found = _in_x(modulus).resultant(total, "x")
    table = {int(i): c for (i, _), c in found.to_dict().items()}
    return fmpz_poly([table.get(i, fmpz(0)) for i in range(max(table) + 1)])


def _in_x(p: fmpz_poly) -> Any:
    return _RING.from_dict({(0, i): c for i, c in enumerate(p.coeffs()) if c})


def _carrier(own: NumberField, image: FieldElement) -> Callable[[FieldElement], FieldElement]:
    # points have long lives: all that is made of unreduced ones would grow with them
    return lambda x: horner([own(c) for c in x.value.coeffs()], image, own(0)).reduced()


def _shifted(own: NumberField, f: Polynomial, at: FieldElement, k: int) -> Polynomial:
    """sum f_i(x) (at - k x)^i."""
    return trimmed(composed([[own(a) for a in c.value.coeffs()] for c in f], at, own(-k)))


def composed(f: Sequence[Polynomial], start: FieldElement, slope: FieldElement) -> Polynomial:
    """sum f_i(x) (start + slope x)^i."""
    total: Polynomial = []
    for c in reversed(f):
        shifted = [start * 0, *_times(total, slope)] if total else []
        total = _plus(_plus(_times(total, start), shifted), c)
    return total


def _times(f: Polynomial, x: FieldElement) -> Polynomial:
    return [c * x for c in f]


def _plus(f: Polynomial, g: Polynomial) -> Polynomial:
    longer, shorter = (f, g) if len(f) >= len(g) else (g, f)
    return [c + shorter[i] if i < len(shorter) else c for i, c in enumerate(longer)]


def horner(f: Sequence[Any], x: Any, zero: Any) -> Any:
    total = zero
    for c in reversed(f):
        total = total * x + c
    return total


def within(x: FieldElement, lo: fmpq, hi: fmpq) -> bool:
    return sign(x - lo) >= 0 and sign(x - hi) <= 0


def gcd(f: Sequence[FieldElement], g: Sequence[FieldElement]) -> Polynomial:
    """The greatest common divisor, monic; [] of zeros."""
    common = field_towers.gcd(trimmed(list(f)), list(g))
    return [c / common[-1] for c in common[:-1]] + [common[-1] * 0 + 1] if common else []


def squarefree(f: Polynomial) -> Polynomial:
    """The same zeros, each once."""
    common = gcd(f, [c * k for k, c in enumerate(f)][1:])
    return division(f, common)[0] if len(common) > 1 else f


def refined(polynomials: Sequence[Polynomial]) -> list[Polynomial]:
    """Pairwise coprime polynomials without repeated zeros that have the same zeros: shared ones come apart."""
    basis: list[Polynomial] = []
    todo = [list(f) for f in polynomials if len(f) > 1]
    while todo:
        f = squarefree(todo.pop())
        for i, g in enumerate(basis):
            common = gcd(f, g)
            if len(common) > 1:
                del basis[i]
                parts = (common, division(f, common)[0], division(g, common)[0])
                todo += [part for part in parts if len(part) > 1]
                break
        else:
            basis.append(f)
    return basis
