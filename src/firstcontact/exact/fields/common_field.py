"""Zeros of polynomials over Q(r), each in one field Q(w) that holds r too.

Mostly the zero s itself generates that field; otherwise s + k r does for some small k.  Then r is the one zero that the
minimal polynomial of r and the given polynomial at s = w - k x share in x, and a quotient of two polynomials in w.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import arb, arb_poly, fmpq, fmpq_poly, fmpz, fmpz_mpoly, fmpz_poly, nmod_poly

from firstcontact.errors import UnsupportedPair
from firstcontact.exact.expressions import context
from firstcontact.exact.fields.field_towers import pseudo_division, trimmed
from firstcontact.exact.fields.number_field import FieldElement, NumberField, sign
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials import by_values

if TYPE_CHECKING:
    from firstcontact.exact.ring import N

MOST_DEGREE, BITS = 64, 192
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
    f = [c.reduced() for c in squarefree(trimmed(list(f)))]
    if len(f) < 2:
        return []
    if len(f) == 2:
        side = sign(f[1])
        if sign(f[0] + f[1] * lo) * side > 0 or sign(f[0] + f[1] * hi) * side < 0:
            return []  # signs are cheap, and inverses dear
        return [Adjoined(field, (-f[0] / f[1]).reduced(), lambda x: x)]
    if field.root.rational is not None:
        p = fmpq_poly([x.value[0] for x in f]).numer()
        return [_simple(root) for root in real_roots(p, lo, hi)]
    if _is_free_of_zeros(f, lo, hi):
        return []
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


def _is_free_of_zeros(f: Polynomial, lo: fmpq, hi: fmpq) -> bool:
    """True proves that f has no zero in [lo, hi]: balls tell that all its Bernstein coefficients there have one sign.

    Elimination takes seconds in a field of degree 24, whether there are zeros or not.
    """
    balls = [c.ball(BITS) for c in f]
    with precision(BITS):
        from_lo = arb_poly(balls)(arb_poly([lo, hi - lo])).coeffs()
        up_from_hi = arb_poly([*[arb(0)] * (len(f) - len(from_lo)), *reversed(from_lo)])
        s = up_from_hi(arb_poly([1, 1])).coeffs()
    return len(s) == len(f) and (all(c > 0 for c in s) or all(c < 0 for c in s))


def _with_multiple(field: NumberField, f: Polynomial, k: int, lo: fmpq, hi: fmpq) -> list[Adjoined] | None:
    """The zeros with w = s + k r; None where some w does not generate both."""
    r = field.root
    g = _shifted(f, k)
    minimal, rows = [fmpz_poly([c]) for c in r.polynomial.coeffs()], _in_w(g)
    if by_values.is_quicker(len(minimal) - 1, len(rows) - 1):
        norm = by_values.resultant(minimal, rows)
    else:
        norm = _in_w(_in_x(r.polynomial).resultant(g, "x"))[0]
    ends = (lo + k * r.lo, hi + k * r.hi)
    found: list[Adjoined] = []
    roots = real_roots(norm, *ends)
    if not roots:
        return found
    line = _shared_line(minimal, rows)
    if line is None:
        return None
    for w in roots:
        own = NumberField(w)
        below, slope = (own(c) for c in line)
        if slope.is_zero():
            return None
        image = (-below / slope).reduced()
        zero = (own.generator() - image * k).reduced()
        if within(image, r.lo, r.hi) and within(zero, lo, hi):
            found.append(Adjoined(own, zero, _carrier(own, image)))
    return found


def _shifted(f: Polynomial, k: int) -> fmpz_mpoly:
    """A multiple of sum f_i(x) (w - k x)^i."""
    w, x = _RING.gens()
    common = fmpz(1)
    for c in f:
        common = common.lcm(c.value.denom())
    total = _RING.constant(0)
    for c in reversed(f):
        total = total * (w - k * x) + _in_x((c.value * fmpq(common)).numer())
    return total


def _in_x(p: fmpz_poly) -> fmpz_mpoly:
    return _RING.from_dict({(0, i): c for i, c in enumerate(p.coeffs()) if c})


def _in_w(f: fmpz_mpoly) -> list[fmpz_poly]:
    """The coefficients of the powers of x, ascending."""
    table: dict[int, dict[int, fmpz]] = {}
    for (i, j), c in f.to_dict().items():
        table.setdefault(int(j), {})[int(i)] = c
    rows = (table.get(j, {0: fmpz(0)}) for j in range(max(table) + 1))
    return [fmpz_poly([row.get(i, fmpz(0)) for i in range(max(row) + 1)]) for row in rows]


def _shared_line(f: list[fmpz_poly], g: list[fmpz_poly]) -> tuple[fmpz_poly, fmpz_poly] | None:
    """(b, a) with a x + b = 0 at every shared zero of two polynomials in x over Z[w]; None where none is found.

    The one of the first degree among their subresultants (Brown 1978), which divide out what would grow.
    """
    if len(f) < len(g):
        f, g = g, f
    lead, height = fmpz_poly([1]), fmpz_poly([1])
    while len(g) > 2:
        drop = len(f) - len(g)
        rest = trimmed(pseudo_division(f, g)[1])
        by = lead * height**drop
        f, g = g, [c // by for c in rest]
        lead = f[-1]
        height = lead**drop // height ** (drop - 1) if drop else height
    return (g[0], g[1]) if len(g) == 2 else None


def _carrier(own: NumberField, image: FieldElement) -> Callable[[FieldElement], FieldElement]:
    # points have long lives: all that is made of unreduced ones would grow with them
    return lambda x: horner([own(c) for c in x.value.coeffs()], image, own(0)).reduced()


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


def horner(f: Sequence[N], x: N, zero: N) -> N:
    total = zero
    for c in reversed(f):
        total = total * x + c
    return total


def within(x: FieldElement, lo: fmpq, hi: fmpq) -> bool:
    return sign(x - lo) >= 0 and sign(x - hi) <= 0


def gcd(f: Sequence[FieldElement], g: Sequence[FieldElement]) -> Polynomial:
    """A greatest common divisor; [] of zeros."""
    common, rest = trimmed(list(f)), trimmed(list(g))
    if _is_coprime_modulo_prime(common, rest):
        return [common[-1].field(1)]
    while rest:
        common, rest = rest, trimmed(_primitive(pseudo_division(common, rest)[1]))
    return common


def _primitive(f: Polynomial) -> Polynomial:
    """A rational multiple with coefficients of small numbers."""
    f = [c.reduced() for c in f]
    below, content = fmpz(1), fmpz(0)
    for c in f:
        below = below.lcm(c.value.denom())
    for c in f:
        content = content.gcd((c.value * fmpq(below)).numer().content())
    return [c * fmpq(below, content) for c in f] if content else f


def _is_coprime_modulo_prime(f: Polynomial, g: Polynomial) -> bool:
    """True proves that the polynomials share no zero (`number_field.residue`)."""
    if not f or not g:
        return False
    p, _ = f[-1].field.residue
    images = [[x for c in h if (x := c.modulo_prime()) is not None] for h in (f, g)]
    if [len(f), len(g)] != [len(x) for x in images] or not any(image[-1] for image in images):
        return False
    return bool(nmod_poly(images[0], p).gcd(nmod_poly(images[1], p)).degree() == 0)


def _quotient(f: Polynomial, g: Polynomial) -> Polynomial:
    """A multiple of f / g, where g divides f."""
    return _primitive(pseudo_division(f, g)[0])


def squarefree(f: Polynomial) -> Polynomial:
    """The same zeros, each once."""
    common = gcd(f, [c * k for k, c in enumerate(f)][1:])
    return _quotient(f, common) if len(common) > 1 else f


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
                parts = (common, _quotient(f, common), _quotient(g, common))
                todo += [part for part in parts if len(part) > 1]
                break
        else:
            basis.append(f)
    return basis
