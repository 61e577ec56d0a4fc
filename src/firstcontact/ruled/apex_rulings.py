"""Rulings through the apex of the other surface: along them Delta is zero, but all meeting points are the apex."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import reduce
from typing import Any

import numpy as np
from flint import fmpq, fmpz_poly

from firstcontact.exact.bivariate import in_u, in_v
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.kernels import curve_points as columns
from firstcontact.pairs.ruled_ruled import all_real_roots, planes_through
from firstcontact.ruled.answer import Found
from firstcontact.ruled.branches import add_apex
from firstcontact.ruled.chains import Chain
from firstcontact.ruled.pieces import Piece

# In parameters of parts: how near an arc is to such a ruling where it is the ruling, and how near rounding may put it
# beyond the cell.
NEAR, ROUNDING = 1e-9, 1e-15


def apexes(surfaces: Iterable[Any]) -> list[np.ndarray]:
    """Those of cones among RuledSurfaces, none at infinity."""
    found = [Piece.of(x).rulings.apex for x in surfaces]
    return [np.array([float(fmpq(c, x[3])) for c in x[:3]]) for x in found if x is not None and x[3] != 0]


class ApexRulings:
    """Those of two chains."""

    def __init__(self, p: Chain, q: Chain) -> None:
        self.chains = p, q
        self._known: dict[tuple[int, int, int], list[AlgebraicRoot]] = {}
        self.met: set[tuple[int, int, int]] = set()
        """(side, piece of p, piece of q) of arcs that were found; side: of the ruling, 0 for one of p."""

    def along(self, arcs: np.ndarray, places: np.ndarray) -> list[int]:
        """Which arcs are such rulings.  In a cell an arc over u has one v for every u: that of the ruling, if any."""
        found = []
        for side, k, y in self._constant(arcs, places):
            part = int(arcs[k, (columns.ARC_U, columns.ARC_V)[side]])
            pair = self._pair(arcs[k])
            low, high = arcs[k, columns.LOW] - ROUNDING, arcs[k, columns.HIGH] + ROUNDING
            for root in self._rulings(side, *pair):
                at = _on_part(self.chains[side].ranges[part], float(root))
                if low <= at <= high and np.abs(y - at).max() <= NEAR:
                    found.append(k)
                    self.met.add((side, *pair))
                    break
        return found

    def points(self, tolerance: float) -> Iterator[dict[str, Any]]:
        """The fields of the apexes that the arcs found are, where both pieces hold them."""
        for side, i, j in sorted(self.met):
            pieces = [Piece.of(chain.pieces[k]) for chain, k in zip(self.chains, (i, j), strict=True)]
            found = Found(pieces[0], pieces[1], tolerance, None)
            (point,) = apexes([self.chains[1 - side].pieces[(i, j)[1 - side]]])
            for root in self._rulings(side, i, j):
                add_apex(found, (in_u, in_v)[side](root.polynomial), point, side, root)
            yield found.collected()

    def _constant(self, arcs: np.ndarray, places: np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
        """Arcs along which one parameter does not change: the side of that, the arc, and it at both ends."""
        for side, over, at, part_of, part in (
            (1, 0, columns.Y, columns.PART_V, columns.ARC_V), (0, 1, columns.X, columns.PART_U, columns.ARC_U)
        ):  # fmt: skip
            own = np.flatnonzero((arcs[:, columns.OVER] == over) & (arcs[:, columns.START] >= 0))
            ends = places[arcs[own][:, [columns.START, columns.END]].astype(int)]
            elsewhere = ends[:, :, part_of] != arcs[own, part][:, None]  # told on the joint with a neighbour
            values = np.where(elsewhere, 1.0 - ends[:, :, at], ends[:, :, at])
            for n in np.flatnonzero(np.abs(values[:, 0] - values[:, 1]) <= NEAR):
                yield side, int(own[n]), values[n]

    def _pair(self, arc: np.ndarray) -> tuple[int, int]:
        p, q = self.chains
        return int(p.piece_of[int(arc[columns.ARC_U])]), int(q.piece_of[int(arc[columns.ARC_V])])

    def _rulings(self, side: int, i: int, j: int) -> list[AlgebraicRoot]:
        """Finite parameters of rulings through the apex of the other piece, where that has one and not all pass it."""
        key = side, i, j
        if key not in self._known:
            own, other = (Piece.of(self.chains[k].pieces[(i, j)[k]]).rulings for k in (side, 1 - side))
            self._known[key] = []
            if other.apex is not None and other.apex[3] != 0:
                offsets = [sum((x * y for x, y in zip(row, other.apex, strict=True)), fmpz_poly([0]))
                           for row in planes_through(own.line)]  # fmt: skip
                common = reduce(fmpz_poly.gcd, offsets)
                self._known[key] = all_real_roots(common)
        return self._known[key]


def _on_part(ends: np.ndarray, u: float) -> float:
    """Where a parameter is on a part; ends: (2, 2) its U, V at both of them."""
    (a, b), (c, d) = ends
    return float((u * b - a) / ((c - a) - u * (d - b)))
