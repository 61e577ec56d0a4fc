"""Ruled B-spline surfaces, weighted or not: cut at their knots into pieces with rational directrices, exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpq_poly, fmpz

from firstcontact.body.ruled.rational_curve import RationalCurve
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational, to_double
from firstcontact.motion.translation import LARGEST

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given, Nested

# Doubles lose the points of lesser weights beside those of greater ones.
MOST_UNEVEN = 2**100
# Largest degree along the curves: its pieces are cut out in seconds, ten times as many would take hours.
MOST_DEGREE = 100
MOST = to_double(LARGEST)
Point = tuple[fmpq, fmpq, fmpq, fmpq]
"""(w x, w y, w z, w)."""


@dataclass(frozen=True)
class NurbsPatch:
    """The curves between two knots; joined: which of "u0", "u1", "s0", "s1" are no border of the whole surface."""

    first: RationalCurve
    second: RationalCurve
    u: tuple[fmpq, fmpq]
    joined: frozenset[str]


def patches(
    points: Nested, knots: Nested | None, weights: Nested | None, degree: Given | Sequence[Given], who: str
) -> list[NurbsPatch]:
    """The patches of a ruled surface of degree (n, 1) or (1, n): along the curves first, then across them."""
    grid, curve_knots = _read(points, knots, weights, degree, who)
    count = len(grid[0])
    n = len(curve_knots) - count - 1
    spans = [k for k in range(n, count) if curve_knots[k] < curve_knots[k + 1]]
    curves = [[_curve(row, curve_knots, n, k) for k in spans] for row in grid]
    found = []
    for j, (first, second) in enumerate(zip(curves, curves[1:], strict=False)):
        start, end = curve_knots[spans[0]], curve_knots[spans[-1] + 1]
        closed = all(_point(row[0], start) == _point(row[-1], end) for row in (first, second))
        for i, k in enumerate(spans):
            joins = {"u0": i > 0 or closed, "u1": i + 1 < len(spans) or closed, "s0": j > 0, "s1": j + 2 < len(grid)}
            joined = frozenset(end for end, joint in joins.items() if joint)
            found.append(NurbsPatch(first[i], second[i], (curve_knots[k], curve_knots[k + 1]), joined))
    return found


# -- one curve ----------------------------------------------------------------------------------------------


def _curve(controls: Sequence[Point], knots: Sequence[fmpq], n: int, k: int) -> RationalCurve:
    """The curve between knots k and k + 1 in the spline's own parameter: de Boor's steps, on polynomials."""
    points = [[fmpq_poly([x]) for x in p] for p in controls[k - n : k + 1]]
    for step in range(1, n + 1):
        # points[i] belongs to the knots from k - n + step + i on
        ends = [(knots[k - n + step + i], knots[k + 1 + i]) for i in range(n + 1 - step)]
        blends = [fmpq_poly([-left, 1]) / (right - left) for left, right in ends]
        points = [
            [p if p == q else p + a * (q - p) for p, q in zip(before, after, strict=True)]
            for a, before, after in zip(blends, points, points[1:], strict=False)
        ]
    (rows,) = points
    scale = fmpz(1)
    for row in rows:
        scale = scale.lcm(row.denom())
    return RationalCurve.of([(row * scale).numer() for row in rows])


def _point(curve: RationalCurve, u: fmpq) -> list[fmpq]:
    x, y, z, w = (p(u) for p in curve.components)
    return [x / w, y / w, z / w]


# -- arguments ----------------------------------------------------------------------------------------------


def _read(points: Any, knots: Any, weights: Any, degree: Any, who: str) -> tuple[list[list[Point]], list[fmpq]]:
    """(controls of each curve, the curves' knots), all checked."""
    rows = _grid(points, who)
    pair = isinstance(degree, tuple | list) and len(degree) == 2 and all(isinstance(n, int) for n in degree)
    if not (degree is None or isinstance(degree, int) or pair):
        raise InputError(f"{who}: degree is {degree!r}; give the one along the curves, or two whole numbers")
    loads = _weights(weights, rows, who)
    controls: list[list[Point]] = [
        [(*(w * x for x in p), w) for p, w in zip(row, load, strict=True)]  # type: ignore[misc]
        for row, load in zip(rows, loads, strict=True)
    ]
    shape = len(rows), len(rows[0])
    vectors = _knot_vectors(knots, shape, degree, who)
    degrees = [len(v) - n - 1 for v, n in zip(vectors, shape, strict=True)]
    if max(degrees) > MOST_DEGREE:
        raise InputError(f"{who}: knots and points make degree {max(degrees)}; give knots for {MOST_DEGREE} at most")
    if degree is not None and not isinstance(degree, int) and tuple(degree) != tuple(degrees):
        raise InputError(f"{who}: degree is {tuple(degree)}, but knots and points make it {tuple(degrees)}; check both")
    if 1 not in degrees:
        raise InputError(f"{who}: degree {tuple(degrees)} is not ruled; one of the two must be 1")
    along = _along(degrees, shape)
    if isinstance(degree, int) and degree != degrees[along]:
        raise InputError(f"{who}: degree is {degree}, but knots and points make it {degrees[along]}; check both")
    for v, n, count in zip(vectors, degrees, shape, strict=True):
        _check_knots(v, n, count, who)
    across = vectors[1 - along]
    if across[0] != across[1] or across[-2] != across[-1]:
        raise InputError(f"{who}: knots across the rulings are {across}; repeat the first and the last one")
    grid = [list(row) for row in zip(*controls, strict=True)] if along == 0 else controls
    return grid, vectors[along]


def _grid(points: Any, who: str) -> list[list[tuple[fmpq, ...]]]:
    cure = "give an (n, 2, 3) or (2, n, 3) grid of control points"
    if isinstance(points, str) or not np.iterable(points):
        raise InputError(f"{who}: points are {points!r}; {cure}")
    rows = [list(row) if np.iterable(row) and not isinstance(row, str) else [] for row in points]
    if len(rows) < 2 or len(rows[0]) < 2 or any(len(row) != len(rows[0]) for row in rows):
        raise InputError(f"{who}: points have rows of {[len(row) for row in rows]}; {cure}")
    grid = []
    for i, row in enumerate(rows):
        for j, p in enumerate(row):
            if not np.iterable(p) or isinstance(p, str) or len(list(p)) != 3:
                raise InputError(f"{who}: points[{i}][{j}] is {p!r}; give three numbers")
        grid.append([tuple(_number(x, who, "points", i, j, k) for k, x in enumerate(p)) for j, p in enumerate(row)])
    return grid


def _weights(weights: Any, rows: list[list[Any]], who: str) -> list[list[fmpq]]:
    if weights is None:
        return [[fmpq(1)] * len(row) for row in rows]
    try:
        found = [[_number(w, who, "weights", i, j) for j, w in enumerate(x)] for i, x in enumerate(weights)]
    except TypeError as error:
        raise InputError(f"{who}: weights are {weights!r}; give one for each control point") from error
    if [len(row) for row in found] != [len(row) for row in rows]:
        raise InputError(f"{who}: weights have rows of {[len(row) for row in found]}; give one for each control point")
    for i, row in enumerate(found):
        for j, w in enumerate(row):
            if w <= 0:
                raise InputError(f"{who}: weights[{i}][{j}] is {weights[i][j]}; give positive weights")
    every = [w for row in found for w in row]
    if max(every) > MOST_UNEVEN * min(every):
        raise InputError(f"{who}: weights differ by more than a factor of 2^100; give more even ones")
    return found


def _along(degrees: list[int], shape: tuple[int, int]) -> int:
    """The direction of the grid that runs along the curves; two rows lie across them."""
    if degrees[0] == degrees[1] or (shape[0] == 2) != (shape[1] == 2):
        return 0 if shape[1] == 2 else 1
    return 0 if degrees[1] == 1 else 1


def _knot_vectors(knots: Any, shape: tuple[int, int], degree: Any, who: str) -> list[list[fmpq]]:
    """The knots along both directions of the grid; without knots those of one Bezier curve, and of a line."""
    if knots is not None and np.iterable(knots) and all(np.iterable(v) and not isinstance(v, str) for v in knots):
        pair = list(knots)
        if len(pair) != 2:
            raise InputError(f"{who}: knots are {len(pair)} lists; give those along the curves, or two lists")
        return [[_number(x, who, "knots", k, i) for i, x in enumerate(v)] for k, v in enumerate(pair)]
    along = _along([2, 1] if degree is None or isinstance(degree, int) else [*degree], shape)
    if shape[1 - along] != 2:
        raise InputError(f"{who}: {shape[0]} x {shape[1]} points; give two rows of them, or both lists of knots")
    if knots is None:
        given = [fmpq(0)] * shape[along] + [fmpq(1)] * shape[along]
    elif isinstance(knots, str) or not np.iterable(knots):
        raise InputError(f"{who}: knots are {knots!r}; give a list of numbers")
    else:
        given = [_number(x, who, "knots", i) for i, x in enumerate(knots)]
    line = [fmpq(0), fmpq(0), fmpq(1), fmpq(1)]
    return [given, line] if along == 0 else [line, given]


def _check_knots(knots: list[fmpq], n: int, count: int, who: str) -> None:
    if n < 1 or count < n + 1:
        raise InputError(f"{who}: {len(knots)} knots for {count} points; give points + degree + 1 of them")
    for left, right in zip(knots, knots[1:], strict=False):
        if right < left:
            raise InputError(f"{who}: knot {right} comes after {left}; give ascending knots")
    inner = knots[n + 1 : count]
    for knot in inner:
        if inner.count(knot) > n:
            raise InputError(f"{who}: knot {knot} stands {inner.count(knot)} times, where the surface breaks; split it")
    if knots[n] == knots[count]:
        raise InputError(f"{who}: all knots of the curves are {knots[n]}; give at least two different ones")


def _number(x: Given, who: str, name: str, *at: int) -> fmpq:
    if type(x) is float and abs(x) < MOST:  # a text of its place takes as long as the number
        return fmpq(*x.as_integer_ratio())
    what = f"{who}: {name}{''.join(f'[{k}]' for k in at)}"
    value = rational(x, what)
    if abs(value) >= LARGEST:
        raise InputError(f"{what} is {shown(x)}; give a number below 2^150")
    return value
