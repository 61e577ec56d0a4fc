"""Scenes far smaller or larger than 1, brought to that size for the search, and their curve taken back.

That points are one is told in parts of max(1, their coordinates): of 1, so that points next to the origin are told by
the size of the scene.  That a point is at infinity is told by its weight in parts of X, Y and Z.  The factor is a power
of 2, so doubles keep all their bits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from firstcontact.curves.exactly.spots import Box
from firstcontact.curves.exactly.tracing import ALL_AROUND, Powers, rows, sizes
from firstcontact.exact.numbers import rational

# Scenes between these sizes are left as they are.
SMALL, LARGE = 2.0**-4, 2.0**24


def size_factor(surfaces: Sequence[Any]) -> Fraction:
    """The power of 2 that brings the largest coordinate of some points of the directrices next to 1, or 1."""
    size = max(_size(piece) for surface in surfaces for piece in surface.pieces)
    return Fraction(1) if SMALL <= size <= LARGE or size == 0.0 else Fraction(2) ** -math.frexp(size)[1]


def _size(piece: Any) -> float:
    """The largest coordinate of some points of the directrices, none at infinity."""
    at = ALL_AROUND
    if piece.u is not None:
        low, high = (float(u) for u in piece.u)
        at = np.linspace(low, high, 5), np.zeros(5, bool)
    return float(sizes([rows(side.components) for side in piece.sides], Powers(*at)).max(initial=0.0))


def resized(surface: Any, factor: Fraction) -> Any:
    return surface.transformed([[factor if i == j < 3 else int(i == j) for j in range(4)] for i in range(4)])


def resized_box(box: Box, factor: Fraction) -> Box:
    low, high = ([rational(x, "box") * rational(factor, "factor") for x in corner] for corner in box)
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def restored(fields: dict[str, Any], factor: Fraction, box: Box | None) -> dict[str, Any]:
    """The fields of IntersectionCurve for the scene as it was, from those of the resized one; box: as it was."""
    k = 1.0 / float(factor)
    names = {} if box is None else {
        f"{axis}={larger}": f"{axis}={end}"
        for ends, others in zip(box, resized_box(box, factor), strict=True)
        for axis, end, larger in zip("xyz", ends, others, strict=True)
    }  # fmt: skip

    def moved(x: Any, **changes: Any) -> Any:
        return replace(x, point=None if x.point is None else k * x.point, **changes)

    graph = fields["graph"]
    found = fields | {
        "branches": tuple(
            replace(x, points=k * x.points, ends=tuple(moved(end, on=tuple(names.get(n, n) for n in end.on))
                                                       for end in x.ends))
            for x in fields["branches"]
        ),
        "graph": replace(graph, nodes=tuple(moved(x) for x in graph.nodes)),
    }  # fmt: skip
    for name in ("overlap_lines", "isolated_points"):
        found[name] = k * fields[name]
    for name in ("singular_points", "open_places"):
        found[name] = tuple(moved(x) for x in fields.get(name, ()))
    if fields.get("box") is not None:
        found["box"] = k * fields["box"]
    return found
