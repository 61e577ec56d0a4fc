"""Ruled surfaces as chains of parts in Bernstein form: neighbours share a ruling, a chain may close."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise
from math import comb, lcm
from operator import mul
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.ruled.joints import share_ruling
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.curves.certified.regular import irregular_parts
from firstcontact.exact.numbers import rational, to_double
from firstcontact.kernels.curves import nets

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled

Projective = tuple[fmpq, fmpq]
"""A parameter U / V; V = 0 is infinity."""
Part = tuple[list[float], Projective, Projective]
"""Coefficients of both sides as in `Chain`, and the range."""

# Where the projective line is cut: no special rulings of hand-made surfaces, less than a right angle (of atan) apart.
CUTS = tuple((fmpq(n, 101), fmpq(1)) for n in (-219, -39, 53, 187))
# Where an interval is cut on which a weight is not seen to be positive.
UNEVEN = fmpq(5, 11)
MOST_CUTS = 40
# In half turns: far more than the rounding of parameters.
SLIGHT = 1e-6


@dataclass(frozen=True)
class Chain:
    """Parts one after another along u.

    points   (parts, 8, n + 1) float64: Bernstein coefficients of X, Y, Z, W of both sides, weights positive,
             each the double next to the exact one, but for a positive factor of the side
    ranges   (parts, 2, 2) float64: U, V at both ends of every part; u is their blend's ratio
    closed   whether the last ruling is the first one
    u, s     the ranges as users give them; u None for the projective line
    box      (2, 3) corners of a box that holds all rulings, up to rounding
    pieces   those of the surface, and for every part the number of its piece; where a closed surface was cut in
             pieces (`cut_out`), one has a range (u0, u1) with u0 > u1: it passes through infinity
    """

    points: np.ndarray
    ranges: np.ndarray
    closed: bool
    u: tuple[Fraction, Fraction] | None
    s: tuple[Fraction, Fraction]
    box: np.ndarray
    pieces: tuple[RuledSurface, ...]
    piece_of: np.ndarray

    @property
    def has_knots(self) -> bool:
        """Whether a piece goes on in another one, or in itself."""
        return len(self.pieces) > 1 or (self.closed and self.u is not None)

    @cached_property
    def irregular(self) -> np.ndarray:
        """Numbers of the parts that may have singular points."""
        return irregular_parts(self)

    def is_regular(self, k: int) -> bool:
        """Whether doubles show that piece k has a tangent plane everywhere: no apex, no edge of regression."""
        return k not in self.piece_of[self.irregular]

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
        if low > high:
            start, end = np.arctan([low, high]) / np.pi
            # an end may be told with rounding: a little before the start is no whole turn behind it
            return k + ((np.arctan(u) / np.pi - start + SLIGHT) % 1.0 - SLIGHT) / (end - start + 1.0)
        if low == high:  # one double stands for the whole piece
            return np.full_like(u, k + 0.5)
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

    def pieces_at(self, place: tuple[float, float]) -> list[int]:
        """The pieces, none through infinity, that share some u with a range of it."""
        low, high = place
        return [k for k, x in enumerate(self.pieces) if x.u is None or (x.u[0] <= high and low <= x.u[1])]

    def piece_box(self, k: int) -> np.ndarray:
        """As `box`, of piece k."""
        return _hull(self.points[self.piece_of == k])

    def parameter(self, part: np.ndarray, x: np.ndarray) -> np.ndarray:
        """u at x of parts."""
        upper, lower = ((1 - x) * self.ranges[part, 0, k] + x * self.ranges[part, 1, k] for k in (0, 1))
        with np.errstate(divide="ignore"):
            return upper / lower

    def rulings(self, parts: np.ndarray, x: np.ndarray) -> np.ndarray:
        """(n, 2, 3) their ends at x of parts."""
        rows, at = self.points[parts], x[:, None, None]
        while rows.shape[2] > 1:
            rows = (1 - at) * rows[:, :, :-1] + at * rows[:, :, 1:]
        sides = rows.reshape(-1, 2, 4)
        return sides[:, :, :3] / sides[:, :, 3:]  # type: ignore[no-any-return]


_CHAINS = Kept[list[Chain]]()


def chains(surface: Ruled) -> list[Chain]:
    """Those of a RuledSurface or RuledStrip at rest, with bounded rulings and without trimming."""
    return _CHAINS.of(surface, lambda: [_chain(run) for run in _runs(surface.pieces)])


def chain_corners(surface: Ruled) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest ones of the boxes of its chains."""
    boxes = np.array([chain.box for chain in chains(surface)])
    return boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)


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
    return share_ruling(a, 1, b, 0)


def _chain(run: list[RuledSurface]) -> Chain:
    coefficients = [[[list(map(int, c.coeffs())) or [0] for c in side.components] for side in x.sides] for x in run]
    degree = max(1, max(len(row) - 1 for sides in coefficients for side in sides for row in side))
    parts: list[Part] = []
    piece_of: list[int] = []
    for k, piece in enumerate(run):
        for lo, hi in _ranges(piece):
            parts += _positive_parts(coefficients[k], degree, lo, hi)
        piece_of += [k] * (len(parts) - len(piece_of))
    first, last = run[0], run[-1]
    closed = first.u is None or (
        "u0" in first.joined and "u1" in last.joined and len(run) > 1 and share_ruling(last, 1, first, 0)
    )
    points = np.array([row for row, _, _ in parts]).reshape(len(parts), 8, degree + 1)
    ranges = np.array([[[to_double(x) for x in end] for end in (lo, hi)] for _, lo, hi in parts])
    u = None if first.u is None or last.u is None else (first.u[0], last.u[1])
    assert first.s is not None
    return Chain(points, ranges, closed, u, first.s, _hull(points), tuple(run), np.array(piece_of))


def _hull(points: np.ndarray) -> np.ndarray:
    """(2, 3) corners of a box that holds all rulings of parts, with room for rounding."""
    box = np.empty((2, 3))
    nets.hull(points, box)
    return box


def _ranges(piece: RuledSurface) -> list[tuple[Projective, Projective]]:
    ends = list(CUTS)
    if piece.u is not None:
        low, high = (rational(u, "u") for u in piece.u)
        if low < high:
            return [((low, fmpq(1)), (high, fmpq(1)))]
        ends = [(low, fmpq(1)), *(x for x in CUTS if x[0] > low), *((-u, -w) for u, w in CUTS if u < high)]
        ends.append((-high, fmpq(-1)))
        return list(pairwise(ends))
    return list(pairwise([*ends, (-ends[0][0], -ends[0][1])]))


def _positive_parts(
    sides: Sequence[Sequence[list[int]]], degree: int, lo: Projective, hi: Projective, depth: int = 0
) -> list[Part]:
    """Parts of a range on each of which all weights are positive.  sides: coefficients of X, Y, Z, W."""
    own: list[float] = []
    degrees = [max(map(len, side)) - 1 for side in sides]
    changes = {n: _change(n, degree, lo, hi) for n in set(degrees)}
    for side, n in zip(sides, degrees, strict=True):
        columns, scale = changes[n]
        numbers = [x for row in side for x in _changed(row, columns)]
        weights = numbers[-degree - 1 :]
        if max(weights) < 0:  # the signs of U, V turned it round
            scale, weights = -scale, [-x for x in weights]
        if min(weights) <= 0:
            break
        own += _doubles(numbers, scale)
    else:
        return [(own, lo, hi)]
    if depth == MOST_CUTS:
        raise ArithmeticError("a weight that is proved positive is not seen to be so")
    middle = tuple((1 - UNEVEN) * x + UNEVEN * y for x, y in zip(lo, hi, strict=True))
    assert len(middle) == 2
    return _positive_parts(sides, degree, lo, middle, depth + 1) + _positive_parts(sides, degree, middle, hi, depth + 1)


def _change(n: int, degree: int, lo: Projective, hi: Projective) -> tuple[list[list[int]], int]:
    """What c_j adds to every coefficient of the sum of c_j U^j V^(n - j) from lo to hi, times a number; that number."""
    common = lcm(*(int(x.q) for x in (*lo, *hi)))
    u, v, to_u, to_v = (int(x.p) * (common // int(x.q)) for x in (*lo, *hi))
    # in powers of the parameter, then in Bernstein form
    powers = zip(_powers(u, to_u - u, n), reversed(_powers(v, to_v - v, n)), strict=True)
    products = [_product(x, y) for x, y in powers]
    rows, factor = _from_powers(n, degree)
    return [[sum(map(mul, row, product)) for product in products] for row in rows], factor * common**n


def _changed(row: list[int], columns: list[list[int]]) -> list[int]:
    """The coefficients of the sum, as `_change` has them; constants take no time."""
    if len(row) == 1 and all(column[0] == columns[0][0] for column in columns):
        return [row[0] * columns[0][0]] * len(columns)
    return [sum(map(mul, row, column)) for column in columns]


def _powers(start: int, step: int, n: int) -> list[list[int]]:
    """Coefficients of (start + step x)^j, j = 0, ..., n."""
    if step == 0:
        return [[start**j] for j in range(n + 1)]
    rows = [[1]]
    for _ in range(n):
        last = rows[-1]
        rows.append([start * a + step * b for a, b in zip([*last, 0], [0, *last], strict=True)])
    return rows


def _product(a: list[int], b: list[int]) -> list[int]:
    """Of two polynomials."""
    if len(b) == 1:
        return [x * b[0] for x in a]
    found = [0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            found[i + j] += x * y
    return found


@lru_cache(maxsize=64)
def _from_powers(n: int, degree: int) -> tuple[list[list[int]], int]:
    """(degree + 1, n + 1): Bernstein coefficients from those of powers, times a number, and that number."""
    factor = lcm(*(comb(degree, k) for k in range(n + 1)))
    return [[comb(i, k) * (factor // comb(degree, k)) for k in range(n + 1)] for i in range(degree + 1)], factor


def _doubles(numbers: list[int], scale: int) -> list[float]:
    """The doubles next to these over `scale`, times a power of 2 where they would be too large."""
    try:
        return [x / scale for x in numbers]  # Python's division of integers rounds correctly
    except OverflowError:
        scale <<= max(abs(x) for x in numbers).bit_length() - scale.bit_length()
        return [x / scale for x in numbers]
