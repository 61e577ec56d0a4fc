"""Points on the edges of a piece, by halving its box: what it has and the file has not is found by its rim.

Cells in which one surface alone may bound the piece have no edge.  Where it is two, the curve common to both is one of
its edges all along; where it is more, cells are halved until they are as small as what is not told apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from firstcontact.body.solid import truth
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import outcomes
from firstcontact.body.solid.quartic_edges import pulled
from firstcontact.body.solid.regions import Regions, halved, parts

FINE, DEEPEST, MOST = 3, 10, 3000
"""How often cells of two surfaces are halved, and of more; and how many there may be."""
STEPS = 14
"""Of Newton from the middle of a cell: next to the tip of a cone each of them halves the distance only."""
ON, ROUNDING = 1e-11, 1e-14
"""Of the largest coordinate: how near to a surface a point counts as on it; and what its form's terms may be off."""


def rims(
    body: CompositeQuadric, lo: np.ndarray, hi: np.ndarray, walls: int
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """(n, 2) surfaces and (n, 3) points where both bound the body.

    walls: so many of the last surfaces are left to themselves.
    """
    count = len(body.surfaces)
    unit = body.forms / np.linalg.norm(body.forms, axis=(1, 2), keepdims=True)
    of = np.array(list(combinations(range(count), 2)))
    of = of[of[:, 0] < count - walls]
    room = ON * max(np.abs(lo).max(), np.abs(hi).max())  # points of walls are on them but for rounding
    for centre, passing in _cells(body, lo, hi):
        cell, which = np.nonzero(passing[:, of[:, 0]] & passing[:, of[:, 1]])
        pairs = of[which]
        points = pulled(unit[pairs], centre[cell], STEPS)
        kept = ((lo - room <= points) & (points <= hi + room)).all(axis=1)  # of the next cell or not: it is the body's
        pairs, points = pairs[kept], points[kept]
        kept = np.concatenate([_bounds(body, points[part], walls) for part in parts(len(points), count)])
        pairs, points = pairs[kept], points[kept]
        if len(points):
            yield pairs, points


def _bounds(body: CompositeQuadric, points: np.ndarray, walls: int) -> np.ndarray:
    """(n,) whether more than the walls bounds the body at points of two surfaces."""
    if not len(points):
        return np.zeros(0, bool)
    x = np.column_stack([points, np.ones(len(points))])
    image = np.tensordot(x, body.forms, (1, 2))  # (n, surfaces, 4)
    values, slopes = np.einsum("nsi,ni->ns", image, x), 2.0 * np.linalg.norm(image[..., :3], axis=2)
    sizes = np.einsum("ni,sij,nj->ns", np.abs(x), np.abs(body.forms), np.abs(x), optimize=True)
    error = slopes * (ON * np.abs(points).max()) + ROUNDING * (sizes)
    signs = (values > error).astype(np.int8) - (values < -error)
    signs[:, len(body.surfaces) - walls :] = -1
    few = (signs == 0).sum(axis=1) <= truth.MOST
    found = np.empty(len(points), bool)
    found[few] = truth.is_open(body.tree, signs[few])
    found[~few] = [len(outcomes(body.tree, row)) == 2 for row in signs[~few].tolist()]
    return found


def _cells(
    body: CompositeQuadric, lo: np.ndarray, hi: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Centres (n, 3) and passing surfaces (n, surfaces) of small cells that hold all edges."""
    regions = Regions(body.surfaces, body._reaches)
    centre, half = (0.5 * (lo + hi))[None], 0.5 * (hi - lo)
    for level in range(DEEPEST + 1):
        passing = regions.passing(body.tree, centre, half)
        count = passing.sum(axis=1)
        again = (count > 2) | ((count == 2) & (level < FINE))
        last = level == DEEPEST or 8 * again.sum() > MOST
        done = (count > 1) if last else (count == 2) & ~again
        if done.any():
            yield centre[done], passing[done]
        if last or not again.any():
            return
        centre, half = halved(centre[again], half)
