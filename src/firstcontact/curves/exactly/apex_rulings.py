"""Rulings through the apex of the other surface: along them Delta is zero, but all meeting points are the apex."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.chains import Chain
from firstcontact.curves.exactly.answer import FoundCurve, apexes
from firstcontact.curves.exactly.branches import add_apex
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.polynomials.bivariate import in_u, in_v
from firstcontact.kernels.curves import points as columns
from firstcontact.pairs.ruled_ruled import all_real_roots, rulings_through

if TYPE_CHECKING:
    from firstcontact.curves.fields import CurveFields

# In parameters of parts: how near an arc is to such a ruling where it is the ruling, and how near rounding may put it
# beyond the cell.
NEAR, ROUNDING = 1e-9, 1e-15
# Arcs that are shorter are not looked at; their ends are one point, in parts of the size, as good as doubles tell next
# to a common ruling.
SHORT, ONE_POINT = 1e-6, 1e-3


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

    def points(self, tolerance: float) -> Iterator[CurveFields]:
        """The fields of the apexes that the arcs found are, where both pieces hold them."""
        for side, i, j in sorted(self.met):
            pieces = [RulingPiece.of(chain.pieces[k]) for chain, k in zip(self.chains, (i, j), strict=True)]
            found = FoundCurve(pieces[0], pieces[1], tolerance, None)
            (point,) = apexes(pieces[1 - side])
            for root in self._rulings(side, i, j):
                add_apex(found, (in_u, in_v)[side](root.polynomial), point, side, root)
            yield found.collected()

    def _constant(self, arcs: np.ndarray, places: np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
        """Arcs along which one parameter does not change: its side, the arc, and it at both ends, on the arc's part."""
        along = places[:, columns.X : columns.Y + 1] + places[:, columns.PART_U : columns.PART_V + 1]
        starts, ends = along[arcs[:, columns.START].astype(int)], along[arcs[:, columns.END].astype(int)]
        moved = np.abs(ends - starts)
        parts = [len(chain.points) for chain in self.chains]
        for own, chain in enumerate(self.chains):
            if chain.closed:
                moved[:, own] = np.minimum(moved[:, own], np.abs(parts[own] - moved[:, own]))
        still = moved <= NEAR
        size = max(float(np.ptp(chain.box, axis=0).max()) for chain in self.chains)
        for k in np.flatnonzero(still[:, 0] != still[:, 1]) if still.any() else ():
            own = 0 if arcs[k, columns.OVER] == 1 else 1
            seen = still[k, own] and moved[k, 1 - own] > SHORT and arcs[k, columns.START] >= 0
            if seen and _is_near(arcs[k], places, size):
                on_part = np.array([starts[k, own], ends[k, own]]) - arcs[k, (columns.ARC_U, columns.ARC_V)[own]]
                yield own, int(k), (on_part + 0.5) % parts[own] - 0.5 if self.chains[own].closed else on_part

    def _pair(self, arc: np.ndarray) -> tuple[int, int]:
        p, q = self.chains
        return int(p.piece_of[int(arc[columns.ARC_U])]), int(q.piece_of[int(arc[columns.ARC_V])])

    def _rulings(self, side: int, i: int, j: int) -> list[AlgebraicRoot]:
        """Finite parameters of rulings through the apex of the other piece, where that has one and not all pass it."""
        key = side, i, j
        if key not in self._known:
            self._known[key] = []
            if not self.chains[1 - side].is_regular((i, j)[1 - side]):
                own, other = (RulingPiece.of(self.chains[k].pieces[(i, j)[k]]).rulings for k in (side, 1 - side))
                if other.apex is not None and other.apex[3] != 0:
                    self._known[key] = all_real_roots(rulings_through(own, other.apex))
        return self._known[key]


def _is_near(arc: np.ndarray, places: np.ndarray, size: float) -> bool:
    """Whether both ends of an arc may be one point: not where it comes back to a line between parts."""
    first, last = (places[int(arc[k]), columns.POINT : columns.POINT + 3] for k in (columns.START, columns.END))
    return bool(np.abs(last - first).max() <= ONE_POINT * size)


def _on_part(ends: np.ndarray, u: float) -> float:
    """Where a parameter is on a part; ends: (2, 2) its U, V at both of them."""
    (a, b), (c, d) = ends
    return float((u * b - a) / ((c - a) - u * (d - b)))
