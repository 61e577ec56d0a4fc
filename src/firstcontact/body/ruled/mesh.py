"""Triangles on ruled surfaces: rulings as dense as the curves and the twist between them ask for.

A mesh parameter x stands for u: x = u on a range; on the whole projective line u = x in [-1, 1] and u = 1 / (2 - x) in
[1, 3], so that -1 and 3 are one ruling.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import InputError

# Parts of the range of u, and steps along rulings, of a trimmed piece: smaller features of the inequalities are lost.
TRIM_PARTS, TRIM_STEPS = 32, 16
# More are a mistake in the tolerance.
MOST_TRIANGLES = 2_000_000
# Halvings that bring a point of a trimmed border to the last digits.
HALVINGS = 50

class Inequality(Protocol):
    """It holds where the value is not negative, as `Trim`."""

    def values(self, u: np.ndarray, s: np.ndarray) -> np.ndarray: ...


Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices (n, 3) float64 and triangles (m, 3) of their numbers."""


def mesh(pieces: Sequence[RuledSurface], tolerance: float, name: str | None) -> Polyhedron:
    """The triangles of all pieces; see `RuledSurface.to_mesh`."""
    who = name or "ruled surface"
    if not (isinstance(tolerance, int | float) and 0 < tolerance < math.inf):
        raise InputError(f"to_mesh tolerance is {tolerance!r}; give a positive length")
    if any(piece.deforming for piece in pieces):
        raise InputError(f"{who} deforms with the time T; take .at(t) for a mesh")
    if any(piece.s is None for piece in pieces):
        raise InputError(f"{who}: whole rulings have no end; give a range s=(s0, s1) for a mesh")
    found = [piece_triangles(piece, tolerance) for piece in pieces]
    corners = np.concatenate([points[triangles] for points, triangles in found])
    if not len(corners):
        raise InputError(f"{who}: trimming leaves nothing that the mesh shows; check the inequalities")
    vertices, triangles = welded(corners)
    return Polyhedron(vertices, triangles, solid=False, name=name)


def piece_triangles(piece: RuledSurface, tolerance: float) -> Mesh:
    """The triangles of one piece at rest with bounded rulings."""
    x, steps = _grid(piece, tolerance)
    assert piece.s is not None
    s = np.linspace(float(piece.s[0]), float(piece.s[1]), steps + 1)
    parameters = np.stack(np.broadcast_arrays(x[:, None], s), axis=-1).reshape(-1, 2)
    triangles = grid_triangles(len(x), steps + 1)
    for trim in piece.trim:
        parameters, triangles = clipped(parameters, triangles, trim, piece)
    return piece.points(parameters_of(piece, parameters[:, 0]), parameters[:, 1]), triangles


def grid_triangles(columns: int, rows: int) -> np.ndarray:
    """(m, 3) vertex numbers of a grid whose vertex (i, j) has the number i * rows + j."""
    corner = (np.arange(columns - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
    beyond = corner + rows
    halves = np.column_stack([corner, beyond, beyond + 1]), np.column_stack([corner, beyond + 1, corner + 1])
    return np.concatenate(halves)


def welded(corners: np.ndarray) -> Mesh:
    """Of (m, 3, 3) corners: equal ones become one vertex, triangles that keep no three are left out."""
    vertices, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    triangles = numbers.reshape(-1, 3)
    proper = np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)  # at an apex rulings share a point
    return vertices, triangles[proper]


def ends_of(piece: RuledSurface) -> tuple[float, float]:
    """The range of the mesh parameter."""
    return (-1.0, 3.0) if piece.u is None else (float(piece.u[0]), float(piece.u[1]))


def parameters_of(piece: RuledSurface, x: np.ndarray) -> np.ndarray:
    """u at mesh parameters; infinity at 2 on the projective line."""
    if piece.u is not None:
        return x
    with np.errstate(divide="ignore"):
        return np.where(x <= 1, x, 1 / (2 - x))


# -- density ------------------------------------------------------------------------------------------------


def _grid(piece: RuledSurface, tolerance: float) -> tuple[np.ndarray, int]:
    """(ascending mesh parameters of the rulings drawn, steps along each).

    Half of the tolerance is for the sides beside their chords, half for the twist: the two triangles of a bilinear
    patch lie off it by up to a quarter of the difference of its opposite chords.
    """
    lo, hi = ends_of(piece)
    parts = np.linspace(lo, hi, (TRIM_PARTS if piece.trim else 4) + 1)
    charts = {False: [side.floats() for side in piece.sides]}
    if piece.u is None:
        charts[True] = [side.reversed().floats() for side in piece.sides]
    waiting = [_Slice(charts, a, b) for a, b in zip(parts.tolist(), parts[1:].tolist(), strict=False)][::-1]
    rough = sum(x.twist() for x in waiting)
    steps = max(TRIM_STEPS if piece.trim else 1, math.ceil(math.sqrt(rough / (2 * tolerance))))
    ends = [lo]
    # The slices done and waiting cover the range; each turn accepts one, or halves it.
    while waiting:
        x = waiting.pop()
        if x.bend() <= tolerance / 2 and x.twist() / (4 * steps) <= tolerance / 2:
            ends.append(x.hi)
            continue
        middle = (x.lo + x.hi) / 2
        if 2 * steps * (len(ends) + len(waiting)) > MOST_TRIANGLES or middle in (x.lo, x.hi):
            raise InputError(f"{piece.name or 'ruled surface'}: no mesh within {tolerance}; give a larger tolerance")
        waiting += [_Slice(charts, middle, x.hi), _Slice(charts, x.lo, middle)]
    return np.array(ends), steps


class _Slice:
    """The sides of a piece between two mesh parameters, as homogeneous polynomials over [0, 1]: (4, n + 1) each."""

    def __init__(self, charts: dict[bool, list[np.ndarray]], lo: float, hi: float) -> None:
        self.lo, self.hi = lo, hi
        inverted = True in charts and lo >= 1
        start, end = (2 - lo, 2 - hi) if inverted else (lo, hi)
        self.sides = [side @ _shifted(side.shape[1] - 1, start, end - start) for side in charts[inverted]]

    def twist(self) -> float:
        """Length of the difference of the chords of the two sides."""
        first, second = (_end(side) - _start(side) for side in self.sides)
        return float(np.linalg.norm(second - first))

    def bend(self) -> float:
        """Bound of how far a side is off its chord at equal parameters; infinite where it proves none."""
        return max(map(_bend, self.sides))


def _bend(side: np.ndarray) -> float:
    """By the Bernstein net of X - W times the chord, over the least of the net of W."""
    n = side.shape[1]
    off = np.zeros((4, n + 1))
    off[:, :n] = side
    off[:3, :n] -= _start(side)[:, None] * side[3]
    off[:3, 1:] -= (_end(side) - _start(side))[:, None] * side[3]
    net = off @ np.array([[math.comb(i, j) / math.comb(n, j) for i in range(n + 1)] for j in range(n + 1)])
    least = net[3].min()
    return float(np.linalg.norm(np.abs(net[:3]).max(axis=1)) / least) if least > 0 else math.inf


def _start(side: np.ndarray) -> np.ndarray:
    point: np.ndarray = side[:3, 0] / side[3, 0]
    return point


def _end(side: np.ndarray) -> np.ndarray:
    x = side.sum(axis=1)
    point: np.ndarray = x[:3] / x[3]
    return point


def _shifted(n: int, start: float, width: float) -> np.ndarray:
    """(n + 1, n + 1): coefficients times it are those of the polynomial at start + width x."""
    powers = [[math.comb(i, j) * start ** (i - j) * width**j if j <= i else 0.0 for j in range(n + 1)]
              for i in range(n + 1)]  # fmt: skip
    return np.array(powers)


# -- trimming -----------------------------------------------------------------------------------------------


def clipped(
    parameters: np.ndarray, triangles: np.ndarray, trim: Inequality, piece: RuledSurface, halvings: int = HALVINGS
) -> Mesh:
    """The triangles of mesh parameters (n, 2) cut down to where the inequality holds."""

    def value(p: np.ndarray) -> np.ndarray:
        return trim.values(parameters_of(piece, p[:, 0]), p[:, 1])

    inside = (value(parameters) >= 0)[triangles]
    count = inside.sum(axis=1)
    vertices, kept = [parameters], [triangles[count == 3]]
    total = len(parameters)
    for number in (1, 2):
        # the corner that differs from the other two comes first
        chosen = triangles[count == number]
        odd = np.argmax(inside[count == number] == (number == 1), axis=1)
        a, b, c = (chosen[np.arange(len(chosen)), (odd + k) % 3] for k in range(3))
        cuts = []
        for other in (b, c):
            ends = (parameters[a], parameters[other])
            cuts.append(total + np.arange(len(chosen)))
            vertices.append(_border(*(ends if number == 1 else ends[::-1]), value, halvings))
            total += len(chosen)
        if number == 1:
            kept.append(np.column_stack([a, *cuts]))
        else:
            kept += [np.column_stack([cuts[0], b, c]), np.column_stack([cuts[0], c, cuts[1]])]
    return np.concatenate(vertices), np.concatenate(kept)


def _border(
    inside: np.ndarray, outside: np.ndarray, value: Callable[[np.ndarray], np.ndarray], halvings: int
) -> np.ndarray:
    """(n, 2) the last points of the segments from `inside` to `outside` with value >= 0."""
    for _ in range(halvings):
        middle = (inside + outside) / 2
        holds = (value(middle) >= 0)[:, None]
        inside, outside = np.where(holds, middle, inside), np.where(holds, outside, middle)
    return inside
