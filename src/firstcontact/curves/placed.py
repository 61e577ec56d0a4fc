"""Scenes far from the origin, or far smaller or larger than 1, brought there for the search, their curve taken back.

That points are one is told in parts of max(1, their coordinates): of 1, so that points next to the origin are told by
the size of the scene.  That a point is at infinity is told by its weight in parts of X, Y and Z.  The factor is a power
of 2, so doubles keep all their bits, and the shift is by few binary digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from flint import fmpq

from firstcontact.curves.exactly.spots import Box
from firstcontact.curves.exactly.tracing import ALL_AROUND, Powers, rows
from firstcontact.exact.numbers import rational, to_double
from firstcontact.exact.rigid import to_origin
from firstcontact.exact.vectors import Vector

if TYPE_CHECKING:
    from firstcontact.body.kinds import Shape
    from firstcontact.curves.fields import CurveFields

SMALL, LARGE = 2.0**-4, 2.0**24
"""Scenes between these sizes are left as they are."""
FAR = 2.0**6
"""Sizes of the smaller body from the origin beyond which a scene is shifted."""
FIFTHS = np.linspace(0.0, 1.0, 5)
Corners = tuple[np.ndarray, np.ndarray]
Search: TypeAlias = "Callable[[Any, Any, float, Box | None], CurveFields]"


@dataclass(frozen=True)
class Rescaling:
    """x -> factor (x + by)."""

    factor: fmpq
    by: Vector

    def body(self, body: Shape) -> Shape:
        k, nil = self.factor, fmpq(0)
        rows = [[k if i == j else nil for j in range(3)] + [k * self.by[i]] for i in range(3)]
        return body.transformed([*rows, [nil, nil, nil, fmpq(1)]])

    def box(self, box: Box) -> Box:
        low, high = (
            [self.factor * (rational(x, "box") + d) for x, d in zip(corner, self.by, strict=True)] for corner in box
        )
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    def back(self, points: np.ndarray) -> np.ndarray:
        return points / to_double(self.factor) - [to_double(d) for d in self.by]


def searched(
    search: Search, p: Shape, q: Shape, tolerance: float, box: Box | None,
    corners_of: Callable[[Any], Corners] | None = None,
) -> CurveFields:  # fmt: skip
    """The fields of IntersectionCurve that `search(p, q, tolerance, box)` finds of the scene in a better place.

    corners_of: where a body is, if the search works that out anyway.
    """
    placing = _placing([(corners_of or corners_of_points)(body) for body in (p, q)])
    if placing is None:
        return search(p, q, tolerance, box)
    own_box = None if box is None else placing.box(box)
    fields = search(placing.body(p), placing.body(q), tolerance * to_double(placing.factor), own_box)
    return restored(fields, placing, box)


def _placing(corners: Sequence[Corners]) -> Rescaling | None:
    """None where the scene stays as it is."""
    by = _shift(corners)
    moved = [to_double(d) for d in by]
    reach = [np.abs(np.array(own) + moved).max() for own in corners if np.isfinite(own).all()]
    size = float(max(reach, default=0.0))
    factor = fmpq(1) if SMALL <= size <= LARGE or size == 0.0 else fmpq(2) ** -math.frexp(size)[1]
    return None if factor == 1 and not any(by) else Rescaling(factor, by)


def _shift(corners: Sequence[Corners]) -> Vector:
    """What brings the smaller body to the origin; nothing where it is near."""
    low, high = min(corners, key=lambda x: float((x[1] - x[0]).max()))
    size, middle = float((high - low).max()), 0.5 * (low + high)
    if not 0.0 < size < math.inf or np.abs(middle).max() <= FAR * size:
        return fmpq(0), fmpq(0), fmpq(0)
    return to_origin(middle.tolist(), size)


def corners_of_points(body: Shape) -> Corners:
    """Of a box around some points of the directrices, none at infinity, or around a solid; infinite where unknown."""
    if not hasattr(body, "pieces"):
        low, high = body.bounds()
        return np.asarray(low, float), np.asarray(high, float)
    points = np.concatenate([_points(piece) for piece in body.pieces], axis=1)
    if not points.size:
        return np.full(3, -math.inf), np.full(3, math.inf)
    return points.min(axis=1), points.max(axis=1)


def _points(piece: Any) -> np.ndarray:
    """(3, n) of the directrices, none at infinity."""
    at = ALL_AROUND
    if piece.u is not None:
        low, high = (float(u) for u in piece.u)
        at = low + (high - low) * FIFTHS, np.zeros(len(FIFTHS), bool)
    curves = rows([component for side in piece.sides for component in side.components])
    sides = (curves @ Powers(*at).table(curves.shape[1] - 1)).reshape(2, 4, -1)
    with np.errstate(all="ignore"):
        points = np.concatenate(list(sides[:, :3] / sides[:, 3:]), axis=1)
    finite: np.ndarray = points[:, np.isfinite(points).all(axis=0)]
    return finite


def restored(fields: CurveFields, placing: Rescaling, box: Box | None) -> CurveFields:
    """The fields of IntersectionCurve for the scene as it was, from those of the placed one; box: as it was."""
    back = placing.back
    names = {} if box is None else {
        f"{axis}={larger}": f"{axis}={end}"
        for ends, others in zip(box, placing.box(box), strict=True)
        for axis, end, larger in zip("xyz", ends, others, strict=True)
    }  # fmt: skip

    def moved(x: Any, **changes: Any) -> Any:
        return replace(x, point=None if x.point is None else back(x.point), **changes)

    graph = fields["graph"]
    given: Any = fields
    found: Any = given | {
        "branches": tuple(
            replace(x, points=back(x.points), ends=tuple(moved(end, on=tuple(names.get(n, n) for n in end.on))
                                                       for end in x.ends))
            for x in fields["branches"]
        ),
        "graph": replace(graph, nodes=tuple(moved(x) for x in graph.nodes)),
    }  # fmt: skip
    for name in ("overlap_lines", "isolated_points"):
        found[name] = back(given[name])
    for name in ("singular_points", "open_places"):
        found[name] = tuple(moved(x) for x in given.get(name, ()))
    if given.get("box") is not None:
        found["box"] = back(given["box"])
    return found
