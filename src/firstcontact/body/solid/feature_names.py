"""What faces, edges and vertices of composite quadric models are called: "plate.hole.rim"."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os.path import commonprefix
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.solid.carriers import Plane, Quadric, Surface, doubles

if TYPE_CHECKING:
    from firstcontact.body.solid.features import EdgeFields, Face

CURVED = ("side", "surface")
"""Labels of curved faces."""
SINGLE = (*CURVED, "plane")
"""Labels of the faces whose border is called "rim" and nothing more."""


@dataclass(frozen=True, slots=True)
class LabelledPart:
    """How one primitive calls its features.

    path: names of the solids around it, outermost first, joined by dots.
    labels: (surface, side, label), side as `Face.orientation`.
    edges: (label, label, name of the edge between them).
    cuts: how many times it was subtracted, itself or as part of something.
    """

    path: str
    labels: tuple[tuple[int, int, str], ...]
    edges: tuple[tuple[str, str, str], ...] = ()
    cuts: int = 0

    def full(self, label: str) -> str:
        return f"{self.path}.{label}" if self.path else label


@dataclass(frozen=True, slots=True)
class _Owner:
    """The primitive (by its place in the order of operands) and the label that a side of a surface comes from."""

    part: int
    label: str


class Names:
    """Names of features from the labels of the primitives they come from, each used once.

    An edge between two primitives is named after the one that cuts: the one subtracted more often; else the one with
    the curved face; else the later operand.
    """

    def __init__(self, name: str | None, parts: Sequence[LabelledPart], surfaces: Sequence[Surface]) -> None:
        paths = [".".join(x for x in (name, p.path) if x) for p in parts]
        self.parts = [LabelledPart(path, p.labels, p.edges, p.cuts) for path, p in zip(paths, parts, strict=True)]
        self.surfaces = surfaces
        self._owners: dict[tuple[int, int], _Owner] = {}
        for k, part in enumerate(parts):
            for i, side, label in part.labels:
                self._owners.setdefault((i, side), _Owner(k, label))

    def faces(self, sides: Sequence[tuple[int, int]]) -> list[str]:
        """Names for faces given by (surface, orientation)."""
        return unique(self._side_name(side) for side in sides)

    def vertices(self, corners: Sequence[tuple[Sequence[int], bool]]) -> list[str]:
        """Names for vertices given by their surfaces and whether they are tips of cones."""
        return unique(self._vertex_name(surfaces, apex) for surfaces, apex in corners)

    def edges(self, edges: Sequence[EdgeFields], faces: Sequence[Face]) -> list[str]:
        """Names for edges and seams, given as keyword arguments of `Edge`."""
        found = [self._edge(edge, faces) for edge in edges]
        for rims in _grouped(found):
            self._tell_apart(rims)
        return unique(edge.name for edge in found)

    # -- single features --------------------------------------------------------------------------------------

    def _owner(self, surface: int, side: int) -> _Owner | None:
        return self._owners.get((surface, side)) or self._owners.get((surface, -side))

    def _side_name(self, side: tuple[int, int]) -> str:
        owner = self._owner(*side)
        return f"surface {side[0]}" if owner is None else self.parts[owner.part].full(owner.label)

    def _vertex_name(self, surfaces: Sequence[int], apex: bool) -> str:
        if apex:
            cones = (i for i in surfaces if isinstance(s := self.surfaces[i], Quadric) and s.apex is not None)
            for i in cones:
                if (owner := self._owner(i, 1)) is not None:
                    return self.parts[owner.part].full("apex")
        return _shared_prefix(list(dict.fromkeys(self._side_name((i, 1)) for i in surfaces)))

    def _edge(self, edge: EdgeFields, faces: Sequence[Face]) -> _Named:
        sides = [(faces[k].surfaces[0], faces[k].orientation) for k in edge["faces"]]
        owners = [owner for side in sides if (owner := self._owner(*side)) is not None]
        if not owners:
            return _Named(edge, "/".join(f"surface {i}" for i in edge["surfaces"]))
        cutter = max(owners, key=lambda o: (self.parts[o.part].cuts, o.label in CURVED, o.part))
        part = self.parts[cutter.part]
        own = sorted({o.label for o in owners if o.part == cutter.part}, key=[x for *_, x in part.labels].index)
        others = sorted({o.label for o in owners if o.part != cutter.part})
        if others:
            label = "rim" if own[0] in SINGLE else f"rim.{'/'.join(own)}"
            return _Named(edge, part.full(label), cutter.part, others)
        for first, second, name in part.edges:
            if [first, second] == own or [second, first] == own:
                return _Named(edge, part.full(name), cutter.part)
        return _Named(edge, part.full("/".join(own) if len(own) > 1 else f"{own[0]}.edge"))

    # -- several rims of one primitive ------------------------------------------------------------------------

    def _tell_apart(self, rims: list[_Named]) -> None:
        """Say which of the primitive's rims is which: "rim.top", "rim.bottom", or by the other face, "rim.z+"."""
        part = self.parts[rims[0].part]
        heights = self._heights(part, rims)
        taken = {rim.name for rim in rims}
        for rim, height in zip(rims, heights, strict=True):
            if rim.name != part.full("rim"):
                continue
            where = _extreme(height, [h for r, h in zip(rims, heights, strict=True) if r is not rim])
            if where is None or part.full(f"rim.{where}") in taken:
                where = "/".join(rim.others)
            rim.name = part.full(f"rim.{where}")

    def _heights(self, part: LabelledPart, rims: list[_Named]) -> list[float | None]:
        """Mean height of the edges along the primitive's axis, from bottom to top; None where that is unknown."""
        for i, side, label in part.labels:
            surface = self.surfaces[i]
            if label == "top" and isinstance(surface, Plane):
                normal = np.array(doubles((surface.normal,))[0][:3])
                axis = normal * side * (-1) ** part.cuts / np.linalg.norm(normal)
                return [_height(rim.edge, axis) for rim in rims]
        return [None] * len(rims)


@dataclass(eq=False, slots=True)
class _Named:
    """An edge on its way to a name; part: the primitive it is named after, others: labels of the other faces."""

    edge: EdgeFields
    name: str
    part: int = -1
    others: Sequence[str] = ()


def _grouped(edges: Iterable[_Named]) -> list[list[_Named]]:
    """The rims of each primitive that has several."""
    groups: dict[int, list[_Named]] = {}
    for edge in edges:
        if edge.part >= 0:
            groups.setdefault(edge.part, []).append(edge)
    return [group for group in groups.values() if len(group) > 1]


def _height(edge: EdgeFields, axis: np.ndarray) -> float | None:
    from firstcontact.body.solid.features import Edge

    points = []
    for piece in edge["pieces"]:
        if np.isfinite([piece.lo, piece.hi]).all():
            t = np.linspace(piece.lo, piece.hi, 17)
            points.append(Edge(index=0, name="", **edge).points(t))  # type: ignore[misc]  # it has no name yet
    return float((np.concatenate(points) @ axis).mean()) if points else None


def _extreme(height: float | None, others: Sequence[float | None]) -> str | None:
    """ "top" or "bottom" for a height clearly above or below all the others."""
    known = [h for h in others if h is not None]
    if height is None or len(known) < len(others):
        return None
    slack = 1e-9 * (abs(height) + max(map(abs, known)))
    if height > max(known) + slack:
        return "top"
    return "bottom" if height < min(known) - slack else None


def _shared_prefix(names: list[str]) -> str:
    """ "plate.x+/y+" for "plate.x+" and "plate.y+"."""
    paths = [name.split(".") for name in names]
    shared = commonprefix([path[:-1] for path in paths])
    tail = "/".join(".".join(path[len(shared) :]) for path in paths)
    return ".".join([*shared, tail])


def unique(names: Iterable[str]) -> list[str]:
    """The names, each used once: from the second use on with its number, "side", "side.2", "side.3"."""
    names = list(names)
    given = set(names)
    uses: Counter[str] = Counter()
    found = []
    for name in names:
        uses[name] += 1
        fresh = name
        while uses[name] > 1 and (fresh := f"{name}.{uses[name]}") in given:
            uses[name] += 1
        given.add(fresh)
        found.append(fresh)
    return found
