"""A curved motion for the kernels: the relative pose as polynomials over cells of time, with proven errors.

Every function is a polynomial of degree 7 in Bernstein form over each cell: that of Taylor at the cell's middle, its
error the next term over the whole cell (Lagrange) and all roundings.  Cells halve the piece again and again, level
under level, until the error is small beside the bodies.  All is one array (`motion` in `curve`), because every further
array argument costs reference counts in inner loops.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, arb_series, fmpq

from firstcontact.exact.numbers import ball, to_double
from firstcontact.kernels.pose_series import ROUNDED, pose_series
from firstcontact.motion.placement import HERE
from firstcontact.motion.relative.curved import CurvedPiece, Leg, Series, cofactors, inverse, terms
from firstcontact.motion.relative.local_poses import local_pose

if TYPE_CHECKING:
    from firstcontact.motion.kinds import AnyMotion

TERMS = 8
# Rows of a cell, each with TERMS coefficients: linear part and shift of the pose of a seen from b; the cofactors of the
# linear part and the cross products of the shift with its columns (side products with fixed lines are linear in these);
# the inverse pose; bounds (row sums of absolute values of the linear parts, entry by entry, see `curve`); errors.
LINEAR, SHIFT, COFACTOR, MOMENT, BACK, BACK_SHIFT = 0, 9, 12, 21, 30, 39
SPREAD, BACK_SPREAD, ERRORS, ROWS = 42, 44, 46, 48
_GROUPS = ((LINEAR, 9), (SHIFT, 3), (COFACTOR, 9), (MOMENT, 9), (BACK, 9), (BACK_SHIFT, 3))
_LINEAR_GROUP, _BACK_GROUP = 0, 4
# Places in row ERRORS: one bound per group (rounding of sums over it included), then the largest of each group in the
# row behind; cell 0 has, behind its six errors, the number of levels below and the length of the piece.
LEVELS, LENGTH = 6, 7
# Cells behind the last one that kernels use as scratch.
SCRATCH = 64
# Error beside the bodies' size that ends the halving, and most levels.
WANTED, MOST_LEVELS = 1e-13, 7
_BITS = 128
Cells = tuple[np.ndarray, np.ndarray]
"""Powers (cells, rows, TERMS) in x from -1 to 1, level after level, and bounds (cells, rows) of what they leave out."""
# Sums of up to 27 products with a coefficient from a row: 32 roundings of 2^-53, relative to the largest entry.
_ROUNDING = 64.0 * 2.0**-53


def _to_bernstein() -> np.ndarray:
    """(8, 8): Bernstein coefficients over [-1, 1] of the powers; entries in [-1, 1]."""
    out = np.zeros((TERMS, TERMS))
    for k in range(TERMS):
        power = np.array([1.0])
        for _ in range(k):  # x = s - (1 - s)
            power = (np.append(0.0, power) * np.arange(len(power) + 1) / len(power)
                     - np.append(power, 0.0) * np.arange(len(power), -1, -1) / len(power))  # fmt: skip
        while len(power) < TERMS:
            n = len(power)
            i = np.arange(n + 1) / n
            power = i * np.append(0.0, power) + (1 - i) * np.append(power, 0.0)
        out[:, k] = power
    return out


_BERNSTEIN = _to_bernstein()


def cells_of(piece: CurvedPiece, size_a: float, size_b: float) -> np.ndarray:
    """The array of the piece for bodies with coordinates up to size_a and size_b: (cells + SCRATCH, ROWS, TERMS)."""
    legs = piece.leg_a, piece.leg_b
    parts = [leg.part(piece.start, piece.end) for leg in legs]
    sizes = _rounded_up(size_a), _rounded_up(size_b)
    if any(leg.before.factors for leg in legs) or not all(part[2] for part in parts):
        cells = _cells(piece, *sizes)
    else:
        cells = _shared(piece.leg_a.motion, parts[0], piece.leg_b.motion, parts[1], *sizes)
    out = np.zeros((len(cells) + SCRATCH, ROWS, TERMS))
    out[: len(cells)] = cells
    levels = (len(cells) + 1).bit_length() - 2
    out[0, ERRORS, LEVELS], out[0, ERRORS, LENGTH] = levels, to_double(piece.end - piece.start)
    return out


def _rounded_up(size: float) -> float:
    """To a power of two: then bodies of much the same size share what is known of a motion."""
    return math.ldexp(1.0, math.frexp(size)[1])


@lru_cache(maxsize=64)
def _shared(
    motion_a: AnyMotion,
    part_a: tuple[int, int, int, int],
    motion_b: AnyMotion,
    part_b: tuple[int, int, int, int],
    *sizes: float,
) -> np.ndarray:
    """The cells of two motions, each for a part of its own time (`Leg.part`): the clock does not matter."""
    legs = []
    for motion, (p, q, m, n) in ((motion_a, part_a), (motion_b, part_b)):
        legs.append(Leg(motion, -fmpq(p, q) * n / m, fmpq(n, m), HERE, ""))
    return _cells(CurvedPiece(fmpq(0), fmpq(1), *legs), *sizes)


def _cells(piece: CurvedPiece, size_a: float, size_b: float) -> np.ndarray:
    found = _in_doubles(piece, size_a, size_b)
    return _bounded(*(_in_balls(piece, size_a, size_b) if found is None else found))


def _in_doubles(piece: CurvedPiece, size_a: float, size_b: float) -> Cells | None:
    """None where rounding alone leaves too much open."""
    a = local_pose(piece.leg_a, piece)
    b = a if piece.leg_b.rests else local_pose(piece.leg_b, piece)
    if not all(np.isfinite(x).all() for pose in (a, b) for x in pose[1:]):
        return None
    count = (2 << MOST_LEVELS) - 1
    powers, rest = np.empty((count, SPREAD, TERMS)), np.empty((count, SPREAD))
    levels = pose_series(
        a, b, piece.leg_b.rests, piece.leg_b.is_rigid, piece.is_rigid, size_a, size_b, WANTED, MOST_LEVELS, powers, rest
    )
    if levels == ROUNDED:
        return None
    count = (2 << levels) - 1
    return powers[:count], rest[:count]


def _in_balls(piece: CurvedPiece, size_a: float, size_b: float) -> Cells:
    length = piece.end - piece.start
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for levels in range(MOST_LEVELS + 1):
        count = 1 << levels
        level = [_cell(piece, piece.start + length * i / count, length / count) for i in range(count)]
        found += level
        bounded = _bounded(*(np.array(x) for x in zip(*level, strict=True)))
        worst = max(_displacement(cell, size_a) for cell in bounded)
        size = size_b + max(_reach(cell, size_a) for cell in bounded)
        if worst <= WANTED * size < np.inf:
            break
    powers, rest = (np.array(x) for x in zip(*found, strict=True))
    return powers, rest


def most_stretch(cells: np.ndarray) -> float:
    """A bound of the entries of the linear parts of the pose and its inverse, at all times.

    Every level covers the whole piece: the tightest tells, as coarse ones may be wide about a divisor that nears zero.
    """
    entries = cells[: len(cells) - SCRATCH, ERRORS + 1][:, [_LINEAR_GROUP, _BACK_GROUP]].max(axis=1)
    levels = int(cells[0, ERRORS, LEVELS])
    return min(float(entries[(1 << level) - 1 : (2 << level) - 1].max()) for level in range(levels + 1))


def _displacement(cell: np.ndarray, size: float) -> float:
    """How far a point of the moving body may be from where the polynomials have it."""
    far: float = 3.0 * size * cell[ERRORS, 0] + cell[ERRORS, 1]
    return far


def _reach(cell: np.ndarray, size: float) -> float:
    reach: float = 3.0 * size * cell[ERRORS + 1, 0] + cell[ERRORS + 1, 1]
    return reach


def _cell(piece: CurvedPiece, start: fmpq, width: fmpq) -> tuple[np.ndarray, np.ndarray]:
    """Powers (rows, TERMS) for the times from start to start + width, and what they leave out (rows,)."""
    half = width / 2
    middle = start + half
    with terms(TERMS + 1, _BITS):
        sharp = _functions(piece, ball(middle))
        # not finite where the cell is so long that a divisor may vanish in it
        blurred = _functions(piece, arb(middle - half).union(arb(middle + half)))
        powers = [ball(half) ** k for k in range(TERMS + 1)]
        out = np.zeros((len(sharp), TERMS))
        rest = np.zeros(len(sharp))
        for row, (f, g) in enumerate(zip(sharp, blurred, strict=True)):
            coefficients = f.coeffs()[:TERMS]
            for k, c in enumerate(coefficients):
                out[row, k] = float(c * powers[k])
            tail = g[TERMS] * powers[TERMS]
            rest[row] = float(abs(tail).upper())
    return out, rest


def _functions(piece: CurvedPiece, t: arb) -> list[arb_series]:
    """The series of the rows of a cell, in their order."""
    pose: Series = piece.series(t)
    linear, shift = [row[:3] for row in pose], [row[3] for row in pose]
    rigid = piece.is_rigid
    back = inverse(pose, rigid)
    normal = linear if rigid else cofactors(pose)
    moment = [
        [shift[(i + 1) % 3] * linear[(i + 2) % 3][j] - shift[(i + 2) % 3] * linear[(i + 1) % 3][j] for j in range(3)]
        for i in range(3)
    ]
    rows = [*(x for row in linear for x in row), *shift, *(x for row in normal for x in row)]
    return [*rows, *(x for row in moment for x in row), *(x for row in back for x in row[:3]), *(r[3] for r in back)]


def _bounded(powers: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """(cells, ROWS, TERMS): powers (cells, rows, TERMS) turned to Bernstein coefficients, and all bounds."""
    out = np.zeros((len(powers), ROWS, TERMS))
    known = np.isfinite(powers).all(axis=(1, 2)) & np.isfinite(rest).all(axis=1)
    out[~known, SPREAD:] = np.inf  # nothing is known: the halves may do better
    out[~known, ERRORS, LEVELS:] = 0.0
    powers, rest = powers[known], rest[known]
    rounding = 32.0 * 2.0**-53 * np.abs(powers).sum(axis=2)  # one double each, and the sum of eight products
    coefficients = powers @ _BERNSTEIN.T
    error = rest + rounding
    largest = np.abs(coefficients).max(axis=2) + error
    cells = np.zeros((len(powers), ROWS, TERMS))
    cells[:, :SPREAD] = coefficients
    for k, (row, count) in enumerate(_GROUPS):
        most = largest[:, row : row + count].max(axis=1)
        cells[:, ERRORS, k] = error[:, row : row + count].max(axis=1) + _ROUNDING * most
        cells[:, ERRORS + 1, k] = most
    cells[:, SPREAD, :], cells[:, SPREAD + 1, 0] = largest[:, :8], largest[:, 8]
    cells[:, BACK_SPREAD, :], cells[:, BACK_SPREAD + 1, 0] = largest[:, BACK : BACK + 8], largest[:, BACK + 8]
    out[known] = cells
    return out
