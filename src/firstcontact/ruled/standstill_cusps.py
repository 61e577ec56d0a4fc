"""Cusps on polylines found in doubles: where a branch passes a ruling at which the family of rulings stands still.

There Delta_u = <l', m> is zero with Delta, so v stands still too, and the branch turns back: at u = 0 and infinity of a
family in u^2, along the border of a strip that lies twice in a plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from flint import fmpq
from numpy.polynomial.polynomial import polyder, polyval

from firstcontact.exact.roots import roots_in
from firstcontact.pairs.ruled_ruled import DUAL
from firstcontact.ruled.cusps import stationary_rulings
from firstcontact.ruled.pieces import Piece
from firstcontact.ruled.tracing import Powers, Surfaces, rows

STANDSTILL = "stationary rulings"
"""The key under which a piece knows their places."""
UNIT = fmpq(-1), fmpq(1)
# Rows this near such a ruling are on it; how many rows from it the polyline turns sharply; Newton's steps.
AT_RULING, AROUND, STEPS = 1e-12, 2, 12
# How far from the polyline the point may be, in chords there.
FARTHEST = 4.0

Passed = tuple[int, int, np.ndarray, np.ndarray]
"""Rows before and after; the point; u, v, s, t.  Rows between are on the ruling too."""


def sharp_turns(points: np.ndarray) -> np.ndarray:
    """Indices of points at which a polyline turns by more than a right angle."""
    chords = np.diff(points, axis=0)
    return np.flatnonzero(np.einsum("ij,ij->i", chords[1:], chords[:-1]) < 0.0) + 1


def turned_back(own: Sequence[Any], others: Sequence[Any], points: np.ndarray, parameters: np.ndarray) -> list[Passed]:
    """Where a polyline, given by its points and u, v, s, t, turns back at a ruling of the first pieces; not at ends."""
    found: dict[int, Passed] = {}
    turns = sharp_turns(points)
    at = parameters[turns, 0]
    for piece in own if len(turns) else ():
        if piece.u is not None and not ((at >= float(piece.u[0])) & (at <= float(piece.u[1]))).any():
            continue
        for reverse, roots in _standstills(piece):
            x = _in_chart(parameters[:, 0], reverse)
            low, high = (-2.0, 2.0) if piece.u is None else (float(u) for u in piece.u)
            inside = (x >= low - AT_RULING) & (x <= high + AT_RULING)
            for root in roots:
                side = np.where(np.abs(x - root) <= AT_RULING, 0.0, np.sign(x - root))
                off = np.flatnonzero(side)
                for n in np.flatnonzero(side[off[1:]] * side[off[:-1]] < 0.0):
                    i, j = int(off[n]), int(off[n + 1])
                    near = ((turns >= i - AROUND) & (turns <= j + AROUND)).any()
                    if near and inside[i] and inside[j]:
                        cusp = _at(piece, others, reverse, root, parameters, i, j)
                        size = np.abs(np.diff(points[max(i - AROUND, 0) : j + AROUND + 1], axis=0)).max()
                        if cusp is not None and np.abs(cusp[2] - points[i]).max() <= FARTHEST * size:
                            found[i] = cusp
    return list(found.values())


def _standstills(piece: Any) -> list[tuple[bool, list[float]]]:
    """Places of such rulings in the chart of u and, of a closed surface, in that of 1/u too; both may have 1 and -1."""
    if STANDSTILL not in piece._search:
        lines = Piece.of(piece)
        charts = [(False, lines.rulings, lines.u or UNIT)]
        if lines.u is None:
            charts.append((True, lines.rulings.reversed(), UNIT))
        piece._search[STANDSTILL] = [
            (reverse, [float(root) for root in roots_in(stationary_rulings(x), ends)]) for reverse, x, ends in charts
        ]
    return piece._search[STANDSTILL]  # type: ignore[no-any-return]


def _in_chart(u: np.ndarray, reverse: bool) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return 1.0 / u if reverse else u


def _at(
    own: Any, others: Sequence[Any], reverse: bool, x: float, parameters: np.ndarray, i: int, j: int
) -> Passed | None:
    """Where the ruling at x meets the other surface, between two rows; Newton."""
    start = parameters[i, 1]
    other = next((p for p in others if p.u is None or float(p.u[0]) <= start <= float(p.u[1])), None)
    if other is None:
        return None
    p, q, far = Piece.of(own), Piece.of(other), bool(abs(start) > 1.0)
    line, lines = polyval(x, rows(p.reversed_rulings(reverse).line).T), rows(q.reversed_rulings(far).line)
    delta = sum(sign * value * lines[j] for value, (j, sign) in zip(line, DUAL, strict=True))
    slope, y = polyder(delta), 1.0 / start if far else start
    for _ in range(STEPS):
        change = polyval(y, slope)
        if change == 0.0:
            return None
        y -= polyval(y, delta) / change
    powers = (Powers(np.array([z]), np.array([turned])) for z, turned in ((x, reverse), (y, far)))
    points, positions = Surfaces(p, q).points(*powers)
    u, v = (1.0 / z if turned and z else np.inf if turned else z for z, turned in ((x, reverse), (y, far)))
    return i, j, points[0], np.array([u, v, p.user_s(positions[0, 0]), q.user_s(positions[0, 1])])
