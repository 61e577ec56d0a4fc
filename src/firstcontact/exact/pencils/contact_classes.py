"""Segre symbols and signature sequences of pencils of quadrics, and the twelve classes with a real contact.

The sequences classify the curve of intersection of two quadrics (Tu, Wang, Mourrain, Wang 2009).  They serve
diagnostics and tests; decisions are made by the local criterion of `pencils`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import fmpq

from firstcontact.exact.fields.number_field import ball, is_zero, sign
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.pencils.pencils import (
    characteristic,
    derivative,
    member,
    multiple_roots,
    polynomial_gcd,
    remainder,
)
from firstcontact.exact.polynomials.inertia import Rows, inertia, null_space, rank
from firstcontact.exact.polynomials.polynomial_matrix import adjugate, determinant, product

if TYPE_CHECKING:
    from firstcontact.exact.fields.number_field import FieldElement
    from firstcontact.exact.ring import Number

# Indices (int) between the real roots, and (positive, negative, multiplicity) at each of them.
Signatures = tuple[Any, ...]


class ContactClass(NamedTuple):
    """A class of pencils whose quadrics touch; `number` is that of Tu et al. 2009."""

    number: int
    segre: str
    sequence: str
    contact: str


CLASSES = (
    ContactClass(6, "[211]", "(1,((1,2)),1,(1,2),2,(2,1),3)", "an isolated point and a real oval"),
    ContactClass(7, "[211]", "(1,((0,3)),1,(1,2),2,(2,1),3)", "an isolated point"),
    ContactClass(15, "[(11)11]", "(1,((0,2)),1,(1,2),2,(2,1),3)", "two isolated points"),
    ContactClass(19, "[(111)1]", "(1,(((0,1))),2,(2,1),3)", "a conic, doubled"),
    ContactClass(22, "[(21)1]", "(1,(((0,2))),2,(2,1),3)", "a point, where two imaginary conics are tangent"),
    ContactClass(24, "[2(11)]", "(1,((1,2)),1,((1,1)),3)", "a point and a real conic"),
    ContactClass(25, "[2(11)]", "(1,((0,3)),1,((1,1)),3)", "a point"),
    ContactClass(30, "[(11)(11)]", "(1,((0,2)),1,((1,1)),3)", "two points"),
    ContactClass(32, "[(211)]", "(2,((((1,0)))),2)", "two real lines, doubled"),
    ContactClass(33, "[(211)]", "(1,((((1,0)))),3)", "a point, where two imaginary lines cross"),
    ContactClass(34, "[(22)]", "(2,((((2,0)))),2)", "a real line"),
    ContactClass(35, "[(22)]", "(2,((((1,1)))),2)", "a real line and two lines that cross it"),
)


def parse(text: str) -> Signatures:
    """The sequence written as in the table above."""
    found = re.findall(r"(\(+)(\d),(\d)\)+|(\d)", text[1:-1])
    return tuple(int(index) if index else (int(p), int(n), len(marks)) for marks, p, n, index in found)


def notation(sequence: Signatures) -> str:
    def one(x: int | tuple[int, int, int]) -> str:
        return str(x) if isinstance(x, int) else "(" * x[2] + f"{x[0]},{x[1]}" + ")" * x[2]

    return "(" + ",".join(map(one, sequence)) + ")"


def canonical(sequence: Signatures) -> Signatures:
    """The same for equivalent sequences: those of pencils that differ by a projective change of l or by a sign."""
    variants = []
    for s in (sequence, sequence[::-1]):
        for t in (s, _negated(s)):
            for _ in range(max(1, len(sequence) - 1)):
                variants.append(t)
                if len(t) > 1:  # the first root and the interval behind it pass through infinity
                    t = t[2:] + _negated(t[1:3])
    return min(variants, key=notation)


def _negated(sequence: Signatures) -> Signatures:
    return tuple(4 - x if isinstance(x, int) else (x[1], x[0], x[2]) for x in sequence)


class Pencil(NamedTuple):
    """A pencil with det A != 0, equal to the given one up to a projective change of l."""

    a: Rows
    b: Rows
    coefficients: list[Any]


def regular(a: Rows, b: Rows) -> Pencil | None:
    """The pencil of A + k B and B for the first integer k that makes A + k B regular; None when every member is
    singular.
    """
    for k in (0, 1, -1, 2, -2):  # a quartic in k has four roots at most
        shifted = member(a, b, 1, -k)
        if not is_zero(determinant(shifted)):
            return Pencil(shifted, b, characteristic(shifted, b))
    return None


def segre_symbol(p: Pencil) -> str:
    """Multiplicities of the elementary divisors, grouped by root, such as "[(11)11]"; complex roots included."""
    groups = []
    multiple = multiple_roots(p.coefficients)
    for alpha, beta, m in multiple:
        groups.append(_divisors(p, member(p.a, p.b, alpha, beta), m))
    left = 4 - sum(m for _, _, m in multiple)
    h = polynomial_gcd(p.coefficients, derivative(p.coefficients))
    if len(h) == 3 and not multiple:  # a conjugate pair of double roots
        groups += [(1, 1) if _annihilates(h, p) else (2,)] * 2
    else:
        groups += [(1,)] * left
    groups.sort(key=lambda g: (-sum(g), len(g)))
    return "[" + "".join(str(g[0]) if len(g) == 1 else "(" + "".join(map(str, g)) + ")" for g in groups) + "]"


def _divisors(p: Pencil, g: Rows, m: int) -> tuple[int, ...]:
    d = len(null_space(g))
    if d == 1:
        return (m,)
    if (m, d) != (4, 2):
        return (m - d + 1,) + (1,) * (d - 1)
    nilpotent = product(adjugate(p.a), g)  # A^-1 B - l0, up to a factor
    return (2, 2) if rank(product(nilpotent, nilpotent)) == 0 else (3, 1)


def _annihilates(q: Sequence[Number], p: Pencil) -> bool:
    """Whether q(A^-1 B) = 0 for the quadratic q."""
    det = determinant(p.a)
    m = [[x / det for x in row] for row in product(adjugate(p.a), p.b)]
    square = product(m, m)
    return all(
        is_zero(q[2] * square[i][j] + q[1] * m[i][j] + (q[0] if i == j else 0)) for i in range(4) for j in range(4)
    )


def signature_sequence(p: Pencil) -> Signatures:
    """Positive indices of l A - B between its real roots, and the signatures with multiplicities at the roots."""
    multiple = multiple_roots(p.coefficients)
    cells = separated_roots(p.coefficients)
    samples = [lo for lo, _ in cells] + [hi for _, hi in cells[-1:]] or [fmpq(0)]
    indices = [inertia(member(p.a, p.b, x, 1))[0] for x in samples]
    out: list[Any] = [indices[0]]
    for k, (lo, hi) in enumerate(cells):
        here = [(x / y, m) for x, y, m in multiple if sign(x / y - lo) > 0 and sign(x / y - hi) < 0]
        if here:
            positive, negative, _ = inertia(member(p.a, p.b, here[0][0], 1))
            out.append((positive, negative, here[0][1]))
        else:  # one eigenvalue passes zero
            positive = min(indices[k], indices[k + 1])
            out.append((positive, 3 - positive, 1))
        out.append(indices[k + 1])
    return tuple(out)


def separated_roots(c: Sequence[FieldElement | fmpq]) -> list[tuple[fmpq, fmpq]]:
    """Rational intervals side by side, ascending, each with one distinct real root inside: Sturm's theorem.

    c: coefficients over a field, ascending, leading one not zero.
    """
    chain = [list(c), derivative(c)]
    while chain[-1]:
        chain.append([-x for x in remainder(chain[-2], chain[-1])])
    chain.pop()
    bits = 64
    while True:  # Cauchy's bound
        with precision(bits):
            sizes = [abs(ball(x, bits) / ball(c[-1], bits)) for x in c[:-1]]
            if all(s.is_finite() for s in sizes):
                bound = 1 + max(dyadic(s.upper()) for s in sizes)
                break
        bits *= 2
    found: list[tuple[fmpq, fmpq]] = []
    todo = [(-bound, _changes(chain, -bound), bound, _changes(chain, bound))]
    while todo:
        lo, at_lo, hi, at_hi = todo.pop()
        if at_lo - at_hi == 1:
            if found:  # intervals without a root between two roots are joined to the right one
                lo = found[-1][1]
            found.append((lo, hi))
        elif at_lo - at_hi > 1:
            middle = next(x for x in (lo + (hi - lo) * fmpq(k, 11) for k in (5, 6, 4, 7, 3)) if not is_zero(_at(c, x)))
            at_middle = _changes(chain, middle)
            todo += [(middle, at_middle, hi, at_hi), (lo, at_lo, middle, at_middle)]
    return found


def _at(c: Sequence[FieldElement | fmpq], x: fmpq) -> FieldElement | fmpq:
    total = c[-1]
    for y in c[-2::-1]:
        total = total * x + y
    return total


def _changes(chain: Sequence[Sequence[FieldElement | fmpq]], x: fmpq) -> int:
    signs = [s for f in chain if (s := sign(_at(f, x)))]
    return sum(s != t for s, t in zip(signs, signs[1:], strict=False))


def contact_class(a: Rows, b: Rows) -> ContactClass | None:
    """The class of two quadrics that touch; None when they do not, or when every member of the pencil is singular."""
    p = regular(a, b)
    if p is None:
        return None
    symbol = segre_symbol(p)
    if not any(c.segre == symbol for c in CLASSES):
        return None
    sequence = canonical(signature_sequence(p))
    return next((c for c in CLASSES if c.segre == symbol and canonical(parse(c.sequence)) == sequence), None)
