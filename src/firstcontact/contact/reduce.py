"""A convex polyhedron as a model with planes only, so that it meets curved models by the same cases.

Features keep the numbers of the polyhedron: its vertices, its edges between faces that are not coplanar, and for
every plane the lowest of its faces (`face_at` finds the one that holds a point).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import ONE, ZERO, Line, Plane, Point, Surface, Vector, columns, dot, primitive
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import Leaf, conjunction
from firstcontact.body.solid.features import Edge, EdgePiece, Face, Features, Vertex
from firstcontact.contact.ways import Passed, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import cross

MOST_TRIANGLES = 100
"""Of a convex polyhedron that is taken as a model: its features are met pair by pair."""


_MODELS = Kept[dict[str | None, CompositeQuadric]]()
_SMALL_AND_CONVEX = Kept[bool]()
_COPLANAR = Kept[dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]]]()


def as_model(body: Polyhedron) -> CompositeQuadric:
    """The closed convex polyhedron as a model, exact; kept on the body (its copies by other names share what it keeps).

    UnsupportedPair for polyhedra that are open, bare edges or points, in an irrational pose, or not convex.
    """
    known = _MODELS.of(body, dict)
    if body.name not in known:
        known[body.name] = _model(body)
    return known[body.name]


def is_small_and_convex(body: Polyhedron) -> bool:
    """Whether the polyhedron is best taken as a model; others go by their triangles."""
    def decided() -> bool:
        small = body.solid and len(body.triangles) <= MOST_TRIANGLES
        return small and not isinstance(tried(lambda: as_model(body)), Passed)

    return _SMALL_AND_CONVEX.of(body, decided)


def _model(body: Polyhedron) -> CompositeQuadric:
    who = body.name or "polyhedron"
    if not body.solid or body.irrational_pose is not None:
        raise UnsupportedPair(f"{who}: only solid polyhedra in rational poses are asked this of curved models")
    points = [body.exact_vertex(i) for i in range(len(body.vertices))]
    used = sorted(set(body.triangles.ravel().tolist()))
    planes: dict[Plane, list[int]] = defaultdict(list)
    inner = _middle([points[i] for i in used])
    for k, triangle in enumerate(body.triangles.tolist()):
        plane = _plane(points, triangle, inner)
        if plane is not None:
            planes[plane].append(k)
    if not planes or any(dot(plane.normal[:3], inner) + plane.normal[3] >= 0 for plane in planes):
        raise UnsupportedPair(f"{who} has no inner points, or is not convex; other polyhedra go by their triangles")
    _check_convex(body, list(planes), [points[i] for i in used], who)
    surfaces = list(planes)
    box = tuple(tuple(f(points[i][k] for i in used) for k in range(3)) for f in (min, max))
    tree = conjunction([Leaf(i) for i in range(len(surfaces))])
    model = CompositeQuadric(surfaces, tree, box=box, witness=inner, name=body.name)  # type: ignore[arg-type]
    model.source = body
    model.know(_features(body, points, surfaces, list(planes.values()), used, who))
    return model


def _middle(points: list[Vector]) -> Vector:
    n = fmpq(len(points))
    return tuple(sum((p[k] for p in points), ZERO) / n for k in range(3))


def _plane(points: Sequence[Vector], triangle: list[int], inner: Vector) -> Plane | None:
    """The plane of a triangle, negative at the inner point; None for one without area."""
    a, b, c = (points[i] for i in triangle)
    n = cross([y - x for x, y in zip(a, b, strict=True)], [y - x for x, y in zip(a, c, strict=True)])
    if not any(n):
        return None
    normal = primitive((*n, -dot(n, a)))
    return Plane(normal if dot(normal[:3], inner) + normal[3] < 0 else tuple(-x for x in normal))


def _check_convex(body: Polyhedron, planes: list[Plane], points: list[Vector], who: str) -> None:
    """All vertices lie behind all planes; doubles decide where they are sure."""
    x = np.array([[to_double(c) for c in p] for p in points])
    for plane in planes:
        size = max(abs(c) for c in plane.normal[:3])
        n = np.array([to_double(c / size) for c in plane.normal])
        values = x @ n[:3] + n[3]
        sure = 1e-14 * (np.abs(x) @ np.abs(n[:3]) + abs(n[3]))
        for k in np.flatnonzero(values > -sure):
            if dot(plane.normal[:3], points[k]) + plane.normal[3] > 0:
                raise UnsupportedPair(f"{who} is not convex; only convex polyhedra are asked this of curved models")


def _features(
    body: Polyhedron,
    points: Sequence[Vector],
    surfaces: Sequence[Surface],
    triangles: list[list[int]],
    used: list[int],
    who: str,
) -> Features:
    polygon = body.triangle_face
    plane_of = {k: i for i, group in enumerate(triangles) for k in group}
    faces = tuple(
        Face(int(min(polygon[k] for k in group)), f"{who}.{min(polygon[k] for k in group)}", surfaces[i], (i,), 1)
        for i, group in enumerate(triangles)
    )
    around: dict[int, set[int]] = defaultdict(set)
    beside: dict[int, set[int]] = defaultdict(set)
    for k, i in plane_of.items():
        for v in body.triangles[k].tolist():
            around[v].add(i)
        for e in body.side_edge[k].tolist():
            beside[e].add(i)
    edges = []
    for e, sides in sorted(beside.items()):
        if len(sides) > 1:
            i, j = body.segments[e].tolist()
            a, b = points[i], points[j]
            direction = tuple(y - x for x, y in zip(a, b, strict=True))
            line = Line(columns((*direction, ZERO), (*a, ONE)))
            frame = np.array([[to_double(c) for c in row] for row in line.basis])
            pair = tuple(sorted(sides))
            edges.append(Edge(e, f"{who}.{e}", line, pair, "convex", (EdgePiece(0.0, 1.0, i, j),), pair, frame))
    vertices = tuple(
        Vertex(v, f"{who}.{v}", Point(columns((*points[v], ONE))), tuple(sorted(around[v])),
               tuple(to_double(c) for c in points[v]), body.error)  # type: ignore[arg-type]
        for v in used if len(around[v]) > 2
    )  # fmt: skip
    return Features(faces, tuple(edges), (), vertices)


def face_at(body: Polyhedron, lowest: int, point: np.ndarray) -> int:
    """The face, coplanar with the face `lowest`, that holds the point (nearly; in the body's frame)."""
    known = _COPLANAR.of(body, dict)
    if lowest not in known:
        known[lowest] = _coplanar(body, lowest)
    faces, corners, inward = known[lowest]
    if len(faces) == 1:
        return lowest
    depths = np.einsum("ksi,ksi->ks", inward, point - corners).min(axis=1)
    return int(faces[int(depths.argmax())])


def _coplanar(body: Polyhedron, lowest: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The faces, (n, 3, 3) corners and directions into the triangle across its sides, of all triangles in its plane.

    One triangle stands for a plane with one face.
    """
    x = body.vertices[body.triangles]
    normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    first = int(np.flatnonzero(body.triangle_face == lowest)[0])
    size = np.abs(x).max() + 1e-300
    flat = np.flatnonzero(np.abs((x - x[first, 0]) @ normals[first]).max(axis=1) < 1e-9 * size)
    if len(np.unique(body.triangle_face[flat])) == 1:
        flat = flat[:1]
    sides = np.roll(x[flat], -1, axis=1) - x[flat]
    return body.triangle_face[flat], x[flat], np.cross(normals[flat][:, None], sides)
