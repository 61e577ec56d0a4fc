"""From parts of trees to elements of bodies: which vertex, edge or face a candidate means."""

from __future__ import annotations

from typing import Any

from firstcontact.search.state import EDGE_EDGE, EDGE_FACE, FACE_EDGE, FACE_VERTEX, VERTEX_FACE
from firstcontact.search.tree import Tree

VERTEX, EDGE, FACE = range(3)
KINDS = {
    VERTEX_FACE: (VERTEX, FACE),
    EDGE_EDGE: (EDGE, EDGE),
    FACE_VERTEX: (FACE, VERTEX),
    EDGE_FACE: (EDGE, FACE),
    FACE_EDGE: (FACE, EDGE),
}

# An element inside the search: (kind, index) with index a vertex, a segment or a triangle.
Feature = tuple[int, int]


def feature(tree: Tree, kind: int, part: int, local: int) -> Feature:
    """The element of the body: `local` counts the part's corners or sides."""
    primitive = int(tree.ids[part, 0])
    if kind == VERTEX:
        return VERTEX, int(tree.corners[primitive, local])
    if kind == EDGE:
        return EDGE, int(tree.sides[primitive, local])
    return FACE, primitive


def corners_of(body: Any, element: Feature) -> list[Any]:
    """Exact corners: one of a vertex, two of an edge (both the same for a bare point), three of a triangle."""
    kind, index = element
    if kind == VERTEX:
        return [body.exact_vertex(index)]
    if kind == EDGE:
        if index >= len(body._segments):
            point = body.exact_vertex(index - len(body._segments))
            return [point, point]
        i, j = body._segments[index].tolist()
        return [body.exact_vertex(i), body.exact_vertex(j)]
    return [body.exact_vertex(i) for i in body.triangles[index].tolist()]
