"""What touches a torus, and where: told in doubles of a contact whose time is proved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.torus.torus import Torus
from firstcontact.contact.mesh_model.patches import bare_primitive, is_sharp_edge, is_sharp_vertex
from firstcontact.contact.models.answer import element as element_of_model
from firstcontact.contact.named import element as element_of_ruled
from firstcontact.contact.ruled_solid.solid_touches import feature_at
from firstcontact.contact.torus.cells import square
from firstcontact.contact.torus.heights import Ring
from firstcontact.result import Element
from firstcontact.search.events.ruled_charts import ChartSheet
from firstcontact.search.trees.frame import tree_of

if TYPE_CHECKING:
    from firstcontact.body.ruled.surface import RuledSurface

NEAR = 1e-5
"""Of sizes: features as near as that to a point near the contact are taken for those that touch."""
FARTHER = 1e-3
"""The same, where there is none as near: cells that are left at a contact in doubles may be as large."""
STEPS = 12
ACROSS = {2: 0, 0: 1, 1: 2}
"""The side of a triangle across from each corner."""

Jet = tuple[float, np.ndarray, np.ndarray]
"""Value, gradient and matrix of second derivatives."""


class Surface(NamedTuple):
    """What vanishes on a surface, at points of the body's frame."""

    jet: Callable[[np.ndarray], Jet]


class TorusContact(NamedTuple):
    """A common point, in the world; normal: unit, from b towards a; the elements of a and b."""

    point: np.ndarray
    normal: np.ndarray
    elements: tuple[Element | None, Element | None]


class Touching(NamedTuple):
    """The element of a body near a point, and the surfaces that meet in it."""

    element: Element | None
    surfaces: list[Surface]


def contact_near(
    shapes: Sequence[Any], poses: Sequence[np.ndarray], place: np.ndarray, theirs: Touching | None = None
) -> TorusContact:
    """The contact of a torus and another body in these poses, near a place in the world; theirs: what is known."""
    k = next(i for i, shape in enumerate(shapes) if isinstance(shape, Torus))
    near = np.linalg.solve(poses[1 - k], [*place, 1.0])[:3]
    grown = np.linalg.det(np.linalg.inv(poses[1 - k])[:3, :3] @ poses[k][:3, :3] @ shapes[k].pose[:, :3])
    size = sum(shapes[k].radii) * abs(float(grown)) ** (1 / 3)  # in the frame of the other
    theirs = theirs or _near(shapes[1 - k], near, size, "ba"[k])
    own = of_torus(shapes[k], np.linalg.solve(poses[k], [*place, 1.0])[:3], "ab"[k])
    ring = seen_from(own.surfaces[0], np.linalg.inv(poses[k]) @ poses[1 - k])
    x = nearest(ring, theirs.surfaces, near, size) if theirs.surfaces else near
    normal = ring.jet(x)[1] @ np.linalg.inv(poses[1 - k][:3, :3])
    normal = (1.0 if k else -1.0) * normal / np.linalg.norm(normal)  # from the torus outwards
    elements = (theirs.element, own.element) if k else (own.element, theirs.element)
    return TorusContact(poses[1 - k][:3, :3] @ x + poses[1 - k][:3, 3], normal, elements)


def _near(shape: Torus | Polyhedron | CompositeQuadric, x: np.ndarray, size: float, which: str) -> Touching:
    if isinstance(shape, Torus):
        return of_torus(shape, x, which)
    return of_mesh(shape, x, which) if isinstance(shape, Polyhedron) else of_model(shape, x, size, which)


def of_torus(torus: Torus, x: np.ndarray, which: str) -> Touching:
    """x: near the contact: where its face is not, a sector touches by its walls."""
    back, ring = np.linalg.inv(square(torus.pose)), Ring(torus)
    near = np.abs(ring.around((back[:3, :3] @ x + back[:3, 3])[None], np.zeros(1)).values[0])
    outer = k = int(torus.shares[1] != 1.0)
    if not torus.is_whole and near[k] > NEAR * sum(torus.radii):
        k = int(near.argmin())
    face = torus.faces[0 if k == outer else k + 1 if k < outer else max(k, 1)]
    own = Surface(lambda x: _height(ring, k, x))
    return Touching(Element("face", torus.name or which, face.index, face.name), [seen_from(own, back)])


def seen_from(surface: Surface, way: np.ndarray) -> Surface:
    """The surface in the frame from which the (4, 4) map `way` leads to its own."""
    def jet(x: np.ndarray) -> Jet:
        value, gradient, turns = surface.jet(way[:3, :3] @ x + way[:3, 3])
        return value, gradient @ way[:3, :3], way[:3, :3].T @ turns @ way[:3, :3]

    return Surface(jet)


def _height(ring: Ring, k: int, x: np.ndarray) -> Jet:
    """One of its heights, in its own frame."""
    rho = max(float(np.hypot(x[0], x[1])), 1e-300)
    away = max(float(np.hypot(rho - ring.major, x[2])), 1e-300)
    out, along = np.array([x[0] / rho, x[1] / rho, 0.0]), np.array([-x[1] / rho, x[0] / rho, 0.0])
    if k >= len(ring.radii):
        p, *n, rest = ring.walls[k - len(ring.radii)]
        return p * rho + float(np.dot(n, x)) + rest, p * out + n, p / rho * np.outer(along, along)
    c, s = (rho - ring.major) / away, x[2] / away
    sign, gradient, around = (1.0, -1.0)[k], c * out + [0.0, 0.0, s], -s * out + [0.0, 0.0, c]
    bent = np.outer(around, around) / away + c / rho * np.outer(along, along)
    return sign * (away - ring.radii[k]), sign * gradient, sign * bent


def of_model(model: CompositeQuadric, x: np.ndarray, size: float, which: str) -> Touching:
    point = np.append(x, 1.0)
    image = model.forms @ point
    values, lengths = image @ point, 2.0 * np.linalg.norm(image[:, :3], axis=1)
    feature = None
    for part in (NEAR, FARTHER):
        near = np.abs(values) <= part * size * np.maximum(lengths, 1e-300)
        feature = feature or feature_at(model, np.where(near, 0, np.sign(values)).astype(int).tolist(), x)
    if feature is None:
        return Touching(None, [])
    forms = [model.forms[k] for k in feature.surfaces][:3]
    return Touching(element_of_model(model, feature, which), [_form(form) for form in forms])


def _form(form: np.ndarray) -> Surface:
    def jet(x: np.ndarray) -> Jet:
        image = form @ np.append(x, 1.0)
        return float(image[:3] @ x + image[3]), 2.0 * image[:3], 2.0 * form[:3, :3]

    return Surface(jet)


def of_mesh(mesh: Polyhedron, x: np.ndarray, which: str) -> Touching:
    corners, name = mesh.vertices[tree_of(mesh).corners], mesh.name or which
    weights = _feet(corners, x)
    k = int(np.linalg.norm(np.einsum("nc,ncd->nd", weights, corners) - x, axis=1).argmin())
    small = [int(j) for j in np.flatnonzero(weights[k] < NEAR)]
    ends = tree_of(mesh).corners[k]
    if k >= len(mesh.triangles):
        edge, ends = bare_primitive(mesh, k)
        vertex = next((v for v in ends if edge is None or _is_at(mesh, v, x)), None)
    else:
        edge = int(tree_of(mesh).sides[k][ACROSS[small[0]]]) if len(small) == 1 else None
        edge = edge if edge is not None and is_sharp_edge(mesh, edge) else None
        vertex = int(ends[weights[k].argmax()]) if len(small) == 2 else None
        vertex = vertex if vertex is not None and is_sharp_vertex(mesh, vertex) else None
    if vertex is not None:
        return Touching(Element("vertex", name, int(vertex), name), _planes(mesh.vertices[vertex], np.eye(3)))
    if edge is not None:
        p, q = mesh.vertices[mesh.edges[edge]]
        return Touching(Element("edge", name, edge, name), _planes(p, np.linalg.svd((q - p)[None])[2][1:]))
    p, q, r = corners[k]
    return Touching(Element("face", name, int(mesh.triangle_face[k]), name), _planes(p, np.cross(q - p, r - p)[None]))


def _is_at(mesh: Polyhedron, vertex: int, x: np.ndarray) -> bool:
    return bool(np.abs(mesh.vertices[vertex] - x).max() <= NEAR * np.ptp(mesh.vertices, axis=0).max())


def of_ruled(ruled: RuledSurface, sheets: list[ChartSheet], place: np.ndarray, which: str) -> Touching:
    """place: number of the sheet, x, s."""
    sheet, x, s = sheets[int(place[0])], float(place[1]), float(place[2])
    low, high = (end and abs(x - at) < NEAR for end, at in zip(sheet.part.ends, (-1.0, 1.0), strict=True))
    end = (1 + sheet.part.side(-1 if low else 1)) // 2 if low or high else None
    side = 0 if s < NEAR else 1 if s > 1.0 - NEAR else None
    kind, index = "face", 0
    if end is not None:
        kind, index = ("end_ruling", end) if side is None else ("vertex", 2 * end + side)
    elif side is not None:
        kind, index = "directrix", side
    return Touching(element_of_ruled(ruled, kind, index, sheet.number, which), [])


def _planes(point: np.ndarray, normals: np.ndarray) -> list[Surface]:
    def plane(n: np.ndarray) -> Surface:
        return Surface(lambda x: (float(n @ (x - point)), n, np.zeros((3, 3))))

    return [plane(n / np.linalg.norm(n)) for n in normals]


def _feet(x: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(n, 3) weights of the nearest points of triangles (n, 3, 3): feet on their planes, or the best on their sides."""
    sides = [(i, (i + 1) % 3) for i in range(3)]
    found = [_foot_on_plane(x, point)]
    for i, j in sides:
        way = x[:, j] - x[:, i]
        s = ((point - x[:, i]) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-300)
        weights = np.zeros((len(x), 3))
        weights[:, j] = np.clip(s, 0.0, 1.0)
        weights[:, i] = 1.0 - weights[:, j]
        found.append(weights)
    choice = np.stack(found)
    away = np.linalg.norm(np.einsum("fnc,ncd->fnd", choice, x) - point, axis=2)
    away[np.any(choice < 0.0, axis=2)] = np.inf
    best: np.ndarray = choice[away.argmin(axis=0), np.arange(len(x))]
    return best


def _foot_on_plane(x: np.ndarray, point: np.ndarray) -> np.ndarray:
    u, v, w = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], point - x[:, 0]
    uu, uv, vv, uw, vw = ((p * q).sum(axis=1) for p, q in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    det = uu * vv - uv * uv
    with np.errstate(all="ignore"):
        s, t = (vv * uw - uv * vw) / det, (uu * vw - uv * uw) / det
    weights = np.column_stack([1.0 - s - t, s, t])
    flat = ~np.isfinite(weights).all(axis=1) | (det <= 1e-24 * uu * vv)
    return np.where(flat[:, None], -1.0, weights)


def nearest(ring: Surface, surfaces: list[Surface], x: np.ndarray, size: float) -> np.ndarray:
    """The point on all surfaces, near x, where the distance from the torus is least; x where none is found.

    Equations are taken in units of the size and of the gradients at x, so that they tell the same at every scale.
    """
    place, count = x.copy(), len(surfaces)
    multipliers: np.ndarray = np.zeros(count)
    lengths: np.ndarray = np.zeros(count)
    for step in range(STEPS):
        _, n, turns = ring.jet(place)
        jets = [s.jet(place) for s in surfaces]
        rows = np.array([j[1] for j in jets]).reshape(count, 3)
        if step == 0:
            lengths = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
        rows = rows / lengths[:, None]
        if step == 0:
            multipliers = -np.linalg.lstsq(rows.T, n, rcond=None)[0]
        bends = (m / d * j[2] for m, d, j in zip(multipliers, lengths, jets, strict=True))
        bent = size * (turns + sum(bends, np.zeros((3, 3))))
        matrix = np.block([[bent, rows.T], [rows, np.zeros((count, count))]])
        values = [j[0] / (d * size) for d, j in zip(lengths, jets, strict=True)]
        right = np.concatenate([n + multipliers @ rows, values])
        if not np.all(np.isfinite(right)):
            return x
        change = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
        place, multipliers = place - size * change[:3], multipliers - change[3:]
    far = np.linalg.norm(place - x) > 1e3 * NEAR * size
    return x if far or not np.all(np.isfinite(place)) else place
