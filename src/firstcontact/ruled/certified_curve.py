"""`intersection_curve` of bounded pieces and strips of any degree, certified in doubles.

The kernels find all arcs of Delta = 0 on which rulings meet between their ends; here they are joined to branches.  What
they could not decide is reported by place: see `OpenPlace`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from firstcontact.curve import Branch, BranchEnd, CurveGraph, ExactParameters, GraphNode, OpenPlace
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.kernels.curve_cells import ARC_COLUMNS, CELL_COLUMNS, COUNTS, CUT, Work, search
from firstcontact.kernels.curve_nets import Side, bound
from firstcontact.kernels.curve_points import COLUMNS, Rulings
from firstcontact.kernels.curve_trace import MOST_HALVINGS, trace
from firstcontact.result import Stats
from firstcontact.ruled.chains import Chain, chains, product_table

# Cells looked at for one pair of chains before the rest is left open.
BUDGET = 400_000
# Room for nodes, places, arcs and points at first; doubled where it does not do.
ROOM = 4096
MOST_ROOM = 2**22
HIGHEST_DEGREE = 40
_LINES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
# Open boxes this near each other, in parts and within them, are one place.
SAME_PLACE = 1e-6


def is_supported(surface: Any) -> bool:
    """Whether the certified path takes this ruled surface at rest: bounded rulings, no trimming."""
    return all(piece.s is not None and not piece.trim for piece in surface.pieces)


def certified_curve(p: Any, q: Any, tolerance: float) -> dict[str, Any]:
    """The fields of IntersectionCurve."""
    for surface in (p, q):
        if not is_supported(surface):
            raise UnsupportedPair(f"{surface!r}: the certified curve takes bounded rulings without trimming")
    found = Found()
    for a in chains(p):
        for b in chains(q):
            _Pair(a, b, tolerance).add_to(found)
    found.join_side_by_side(p, q)
    return found.fields()


class Line(NamedTuple):
    """A branch or a part of one: points (n, 3), parameters (n, 4), and both ends; None for a loop."""

    points: np.ndarray
    parameters: np.ndarray
    ends: tuple[End, End] | None


class End(NamedTuple):
    """kind "boundary" or "open", the bound's name and value, the number of the open place."""

    kind: str
    on: str
    place: int
