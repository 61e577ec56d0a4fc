"""Polynomials in u, v and T with integer coefficients: elimination, irreducible factors, values at rational numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from flint import fmpq, fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.exact.expressions import context
from firstcontact.exact.polynomials import by_values
from firstcontact.exact.polynomials.bivariate import factored

NAMES = ("u", "v", "T")
RING = context(NAMES)


def terms(f: fmpz_mpoly) -> list[tuple[tuple[int, ...], fmpz]]:
    """((i, j, k), coefficient of u^i v^j T^k)."""
    return [(tuple(map(int, key)), c) for key, c in zip(f.monoms(), f.coeffs(), strict=True)]


def degree(f: fmpz_mpoly, index: int) -> int:
    """In one variable; 0 for constants, zero included."""
    return max(int(f.degrees()[index]), 0)


def univariate(f: fmpz_mpoly, index: int) -> fmpz_poly:
    """f as a polynomial of its only variable."""
    coefficients = [fmpz(0)] * (degree(f, index) + 1)
    for key, c in terms(f):
        coefficients[key[index]] = c
    return fmpz_poly(coefficients)


def embedded(p: fmpz_poly, index: int) -> fmpz_mpoly:
    """p as a polynomial in one of the three variables."""
    return RING.from_dict({tuple(i if k == index else 0 for k in range(3)): c for i, c in enumerate(p.coeffs()) if c})


def coefficients(f: fmpz_mpoly, index: int) -> list[fmpz_mpoly]:
    """Those of the powers of one variable, ascending."""
    parts: list[dict[tuple[int, ...], fmpz]] = [{} for _ in range(degree(f, index) + 1)]
    for key, c in terms(f):
        parts[key[index]][tuple(0 if k == index else e for k, e in enumerate(key))] = c
    return [RING.from_dict(part) for part in parts]


def at(f: fmpz_mpoly, index: int, x: fmpq) -> fmpz_mpoly:
    """A positive multiple of f with one variable replaced by a rational number."""
    n = degree(f, index)
    powers = [x.p**k * x.q ** (n - k) for k in range(n + 1)]
    found: dict[tuple[int, ...], fmpz] = {}
    for key, c in terms(f):
        rest = tuple(0 if k == index else e for k, e in enumerate(key))
        found[rest] = found.get(rest, 0) + c * powers[key[index]]
    return RING.from_dict(found)


def exchanged(f: fmpz_mpoly) -> fmpz_mpoly:
    """f with u and v exchanged."""
    return RING.from_dict({(j, i, k): c for (i, j, k), c in terms(f)})


def resultant(f: fmpz_mpoly, g: fmpz_mpoly, index: int) -> fmpz_mpoly:
    """Zero where f and g share a zero in one variable; of one without it, that one itself."""
    if degree(f, index) == 0 or degree(g, index) == 0:
        return f if degree(f, index) == 0 else g
    left = _only_other(index, f, g)
    if left is not None and by_values.is_quicker(degree(f, index), degree(g, index)):
        return embedded(by_values.resultant(_rows(f, index, left), _rows(g, index, left)), left)
    return f.resultant(g, NAMES[index])


def discriminant(f: fmpz_mpoly, index: int) -> fmpz_mpoly:
    """Zero where zeros of f in one variable meet."""
    n, left = degree(f, index), _only_other(index, f)
    if n < 2:
        return RING.constant(1)
    if left is not None and by_values.is_quicker(n, n - 1):
        return embedded(by_values.discriminant(_rows(f, index, left)), left)
    return f.discriminant(NAMES[index])


def _only_other(index: int, *polynomials: fmpz_mpoly) -> int | None:
    """The one variable beside that one in which they are; None where there are two, or none."""
    used = [k for k in range(3) if k != index and any(degree(f, k) for f in polynomials)]
    return used[0] if len(used) == 1 else None


def _rows(f: fmpz_mpoly, index: int, left: int) -> list[fmpz_poly]:
    """The coefficients of the powers of one variable, ascending, in the only other one."""
    return [univariate(c, left) for c in coefficients(f, index)]


class FactorSet:
    """Irreducible polynomials, each once up to its sign, in the order in which they came."""

    def __init__(self) -> None:
        self._found: dict[str, fmpz_mpoly] = {}
        self._counts: dict[str, int] = {}

    def add(self, f: fmpz_mpoly) -> None:
        """Put in the factors of f, which must not be zero."""
        for g, multiplicity in factors(f):
            key = str(g)
            self._found.setdefault(key, g)
            self._counts[key] = self._counts.get(key, 0) + multiplicity

    def count(self, f: fmpz_mpoly) -> int:
        """How often an irreducible polynomial was a factor, with multiplicities."""
        return self._counts.get(str(f), 0)

    def __iter__(self) -> Iterator[fmpz_mpoly]:
        return iter(list(self._found.values()))

    def __len__(self) -> int:
        return len(self._found)


def irreducible(f: fmpz_mpoly) -> list[fmpz_mpoly]:
    """The irreducible factors of f != 0 without constants and multiplicities, leading coefficients positive."""
    return [g for g, _ in factors(f)]


def factors(f: fmpz_mpoly) -> list[tuple[fmpz_mpoly, int]]:
    """The irreducible factors of f != 0 with multiplicities, without constants, leading coefficients positive."""
    if f.is_zero():
        raise ValueError("the zero polynomial has no factors")
    if f.is_constant():
        return []
    used = [k for k in range(3) if degree(f, k)]
    if len(used) == 1:
        return [(embedded(g, used[0]), int(n)) for g, n in univariate(f, used[0]).factor()[1]]
    return [(-g if g.leading_coefficient() < 0 else g, n) for g, n in factored(f)]


def product(factors: Iterable[fmpz_mpoly]) -> fmpz_mpoly:
    found = RING.constant(1)
    for f in factors:
        found = found * f
    return found
