"""What the page shows of a whole assembly: which of its pairs, and every body for the background of each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.result import FirstContact, Status
from firstcontact.view.drawing import Drawing, drawing_alone
from firstcontact.view.pair import at_rest

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.result import ContactIntervals

MOST_PAIRS, MOST_FREE = 400, 40
"""Pairs of a page, and up to how many pairs in all those are on it of which nothing is to be seen."""
MOST_TRIANGLES = 350_000
"""Of all bodies: some 7 MB.  Beyond it those that are in no pair of the page are drawn coarsely."""


@dataclass(frozen=True)
class SceneView:
    """All bodies of a scene by name, and the unit of its lengths."""

    bodies: Mapping[str, Body]
    unit: str = ""


def shown(results: Iterable[Any]) -> list[Any]:
    """The results whose pairs are on the page: contacts, earliest first, what is undecided, then what is free."""
    ordered = sorted(results, key=_order)
    if len(ordered) > MOST_FREE:
        worth = [x for x in ordered if x.status is not Status.FREE or getattr(x, "allowed", None)]
        ordered = worth or ordered[:1]
    return ordered[:MOST_PAIRS]


def _order(result: FirstContact | ContactIntervals) -> tuple[int, float]:
    if isinstance(result, FirstContact):
        time = None if result.allowed and result.status is not Status.CONTACT else result.time
    else:
        time = result[0].start if len(result) else None
    if time is not None:
        return 0, time
    return (1, result.free_until or 0.0) if result.status is Status.UNDECIDED else (2, 0.0)


def drawn(assembly: SceneView, in_pairs: set[int], known: dict[int, Drawing]) -> dict[str, Drawing]:
    """The bodies that can be drawn alone; in_pairs: ids of the bodies at rest that pairs show."""
    found: dict[str, Drawing] = {}
    for name, body in assembly.bodies.items():
        drawing = drawing_alone(at_rest(body), known)
        if drawing is not None:
            found[name] = drawing
    total = sum(len(x.triangles) for x in {id(x): x for x in found.values()}.values())
    if total <= MOST_TRIANGLES:
        return found
    cells = max(4, math.isqrt(MOST_TRIANGLES // (8 * len(found))))
    behind = {name: x for name, x in found.items() if id(at_rest(assembly.bodies[name])) not in in_pairs}
    coarse = {id(x): _coarse(x, cells) for x in behind.values()}
    return {name: coarse[id(x)] if name in behind else x for name, x in found.items()}


def _coarse(drawing: Drawing, cells: int) -> Drawing:
    """With one vertex for each cell of a grid that many wide, where that is less."""
    lo, hi = drawing.vertices.min(axis=0), drawing.vertices.max(axis=0)
    width = float((hi - lo).max()) / cells or 1.0
    place = np.floor((drawing.vertices - lo) / width).astype(np.int64)
    _, first, number = np.unique(place, axis=0, return_index=True, return_inverse=True)
    triangles = number.reshape(-1)[drawing.triangles]
    p, q, r = triangles.T
    triangles = np.unique(triangles[(p != q) & (q != r) & (r != p)], axis=0)
    if len(triangles) >= len(drawing.triangles):
        return drawing
    vertices = drawing.vertices[first]
    return replace(
        drawing, vertices=vertices, triangles=triangles, lines=np.empty((0, 2), int), normals=None,
        triangle_face=np.empty(0, int), curves=(),
    )  # fmt: skip
