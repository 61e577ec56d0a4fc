"""Ruled surfaces as chains of parts in Bernstein form: neighbours share a ruling, a chain may close."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import comb
from typing import Any

import numpy as np
from flint import fmpq, fmpq_mat, fmpz_mat, fmpz_poly

from firstcontact.body.ruled_surface import RuledSurface
from firstcontact.exact.numbers import rational, to_double

Projective = tuple[fmpq, fmpq]
"""A parameter U / V; V = 0 is infinity."""

# Where the projective line is cut: no special rulings of hand-made surfaces, less than a right angle (of atan) apart.
CUTS = tuple((fmpq(n, 101), fmpq(1)) for n in (-219, -39, 53, 187))
# Where an interval is cut on which a weight is not seen to be positive.
UNEVEN = fmpq(5, 11)
MOST_CUTS = 40


@dataclass(frozen=True)
class Chain:
    """Parts one after another along u.

    points   (parts, 8, n + 1) float64: Bernstein coefficients of X, Y, Z, W of both sides, weights positive,
             each the double next to the exact one
    ranges   (parts, 2, 2) float64: U, V at both ends of every part; u is their blend's ratio
    closed   whether the last ruling is the first one
    u, s     the ranges as users give them; u None for the projective line
    box      (2, 3) corners of a box that holds all rulings, up to rounding
    pieces   those of the surface, and for every part the number of its piece
    """

    points: np.ndarray
    ranges: np.ndarray
    closed: bool
    u: tuple[Fraction, Fraction] | None
    s: tuple[Fraction, Fraction]
    box: np.ndarray
    pieces: tuple[RuledSurface, ...]
    piece_of: np.ndarray

    def knots(self, k: int) -> list[Fraction]:
        """The ends of the range of piece k at which another goes on."""
        u, last = self.pieces[k].u, len(self.pieces) - 1
        if u is None or (last == 0 and not self.closed):
            return []
        goes_on = k > 0 or self.closed, k < last or self.closed
        return [x for x, there in zip(u, goes_on, strict=True) if there]

    def position(self, k: int, u: np.ndarray) -> np.ndarray:
        """Along the chain, a piece taking 1, of parameters of piece k."""
        bounds = self.pieces[k].u
        if bounds is None:
            return np.arctan(u) / np.pi % 1.0
        low, high = float(bounds[0]), float(bounds[1])
        return k + (u - low) / (high - low)

    def along(self, part: int, x: float) -> float:
        """As `position`, of a place on a part."""
        return float(self.position(int(self.piece_of[part]), self.parameter(np.array([part]), np.array([x])))[0])

    def borders(self, names: str, position: float, s: float, near: float) -> list[str]:
        """The bounds of the whole chain next to a place; names: "us" or "vt"."""
        found = []
        if self.u is not None and not self.closed:
            found += [f"{names[0]}={u}" for u, end in zip(self.u, (0, len(self.pieces)), strict=True)
                      if abs(position - end) <= near]  # fmt: skip
        return found + [f"{names[1]}={end}" for end in self.s if abs(s - end) <= near * (self.s[1] - self.s[0])]

    def neighbours(self, part: int, low: bool, high: bool) -> set[int]:
        """The piece of a part, with those next to it at its ends if asked for."""
        own, last = {int(self.piece_of[part])}, len(self.points) - 1
        for there, other in ((low, part - 1), (high, part + 1)):
            if there and (self.closed or 0 <= other <= last):
                own.add(int(self.piece_of[other % (last + 1)]))
        return own

    def piece_box(self, k: int) -> np.ndarray:
        """As `box`, of piece k."""
        return _hull(self.points[self.piece_of == k])

    def parameter(self, part: np.ndarray, x: np.ndarray) -> np.ndarray:
        """u at x of parts."""
        upper, lower = ((1 - x) * self.ranges[part, 0, k] + x * self.ranges[part, 1, k] for k in (0, 1))
        with np.errstate(divide="ignore"):
            return upper / lower

    def ruling(self, part: int, x: float) -> np.ndarray:
        """(2, 3) its ends at x of a part."""
        rows = self.points[part]
        while rows.shape[1] > 1:
            rows = (1 - x) * rows[:, :-1] + x * rows[:, 1:]
        first, second = rows[:4, 0], rows[4:, 0]
        return np.array([first[:3] / first[3], second[:3] / second[3]])


def chains(surface: Any) -> list[Chain]:
    """Those of a RuledSurface or RuledStrip at rest, with bounded rulings and without trimming."""
    if "chains" not in surface._search:
        surface._search["chains"] = [_chain(run) for run in _runs(surface.pieces)]
    return surface._search["chains"]  # type: ignore[no-any-return]


def _runs(pieces: Sequence[RuledSurface]) -> Iterator[list[RuledSurface]]:
    """The pieces, cut where one does not begin on the ruling on which the one before it ends."""
    run: list[RuledSurface] = []
    for piece in pieces:
        if run and not _follows(run[-1], piece):
            yield run
            run = []
        run.append(piece)
    yield run


def _follows(a: RuledSurface, b: RuledSurface) -> bool:
    if a.u is None or b.u is None or "u1" not in a.joined or "u0" not in b.joined or a.u[1] != b.u[0]:
        return False
    return _shared(a, 1, b, 0)


def _shared(a: RuledSurface, end_a: int, b: RuledSurface, end_b: int) -> bool:
    """Whether two rulings have the same ends."""
    assert a.u is not None and b.u is not None
    u, v = rational(a.u[end_a], "u"), rational(b.u[end_b], "u")
    for x, y in zip(a.sides, b.sides, strict=True):
        p, q = [c(u) for c in x.components], [c(v) for c in y.components]
        if any(p[k] * q[3] != q[k] * p[3] for k in range(3)):
            return False
    return True


def _chain(run: list[RuledSurface]) -> Chain:
    parts: list[tuple[list[list[fmpq]], Projective, Projective]] = []
    piece_of: list[int] = []
    for k, piece in enumerate(run):
        for lo, hi in _ranges(piece):
            parts += _positive_parts(piece, lo, hi)
        piece_of += [k] * (len(parts) - len(piece_of))
    first, last = run[0], run[-1]
    closed = first.u is None or (
        "u0" in first.joined and "u1" in last.joined and len(run) > 1 and _shared(last, 1, first, 0)
    )
    degree = max(1, *(len(row) - 1 for rows, _, _ in parts for row in rows))
    points = np.array([[_elevated(row, degree) for row in rows] for rows, _, _ in parts])
    ranges = np.array([[[to_double(x) for x in end] for end in (lo, hi)] for _, lo, hi in parts])
    u = None if first.u is None or last.u is None else (first.u[0], last.u[1])
    assert first.s is not None
    return Chain(points, ranges, closed, u, first.s, _hull(points), tuple(run), np.array(piece_of))


def _hull(points: np.ndarray) -> np.ndarray:
    """(2, 3) corners of a box that holds all rulings of parts, with room for rounding."""
    corners = np.concatenate([points[:, k : k + 3] / points[:, k + 3 : k + 4] for k in (0, 4)], axis=2)
    corners = corners.transpose(0, 2, 1).reshape(-1, 3)
    slack = 1e-12 * np.abs(corners).max()
    return np.array([corners.min(0) - slack, corners.max(0) + slack])


def _ranges(piece: RuledSurface) -> list[tuple[Projective, Projective]]:
    if piece.u is not None:
        return [((rational(piece.u[0], "u"), fmpq(1)), (rational(piece.u[1], "u"), fmpq(1)))]
    ends = [*CUTS, (-CUTS[0][0], -CUTS[0][1])]
    return list(zip(ends, ends[1:], strict=False))


def _positive_parts(
    piece: RuledSurface, lo: Projective, hi: Projective, depth: int = 0
) -> list[tuple[list[list[fmpq]], Projective, Projective]]:
    """Rows X, Y, Z, W of both sides on parts of a range on each of which all weights are positive."""
    p, q = (side.components for side in piece.sides)
    n, m = (max(c.degree() for c in side) for side in (p, q))
    rows = _bernstein((*p, *q), n, lo, hi) if n == m else _bernstein(p, n, lo, hi) + _bernstein(q, m, lo, hi)
    for weights in (3, 7):
        if max(rows[weights]) < 0:  # the signs of U, V turned it round
            rows[weights - 3 : weights + 1] = [[-x for x in row] for row in rows[weights - 3 : weights + 1]]
    if min(min(rows[3]), min(rows[7])) > 0:
        return [(rows, lo, hi)]
    if depth == MOST_CUTS:
        raise ArithmeticError("a weight that is proved positive is not seen to be so")
    middle = tuple((1 - UNEVEN) * x + UNEVEN * y for x, y in zip(lo, hi, strict=True))
    assert len(middle) == 2
    return _positive_parts(piece, lo, middle, depth + 1) + _positive_parts(piece, middle, hi, depth + 1)


def _bernstein(components: Sequence[fmpz_poly], n: int, lo: Projective, hi: Projective) -> list[list[fmpq]]:
    """Coefficients of every sum c_j U^j V^(n - j) on the segment from lo to hi: polar forms."""
    weights = []
    for i in range(n + 1):
        # elementary symmetric sums of the arguments: the coefficients of the product of V + U z
        product = [fmpq(1)]
        for u, v in [lo] * (n - i) + [hi] * i:
            product = [v * a + u * b for a, b in zip([*product, fmpq(0)], [fmpq(0), *product], strict=True)]
        weights.append([x / comb(n, j) for j, x in enumerate(product)])
    rows = fmpq_mat(fmpz_mat([[c[j] for j in range(n + 1)] for c in components])) * fmpq_mat(weights).transpose()
    return rows.tolist()  # type: ignore[no-any-return]


def _elevated(row: list[fmpq], degree: int) -> list[float]:
    """The same polynomial's coefficients of a higher degree, in doubles."""
    while len(row) <= degree:
        n = len(row)
        row = [(fmpq(i, n) * row[i - 1] if i else fmpq(0)) + (fmpq(n - i, n) * row[i] if i < n else fmpq(0))
               for i in range(n + 1)]  # fmt: skip
    return [to_double(x) for x in row]


@lru_cache(maxsize=64)
def product_table(n: int) -> np.ndarray:
    """(n + 1, n + 1, 2 n + 1): coefficient c of the product of two polynomials of degree n from products of theirs."""
    table = np.zeros((n + 1, n + 1, 2 * n + 1))
    for a in range(n + 1):
        for b in range(n + 1):
            table[a, b, a + b] = comb(n, a) * comb(n, b) / comb(2 * n, a + b)
    return table
