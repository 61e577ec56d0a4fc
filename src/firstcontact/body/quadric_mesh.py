"""Triangles for drawing composite quadric models.

Each surface is covered with a grid fitted to the tolerance, triangles near its edges are halved, then cut along the
surfaces it has edges with; pieces that bound the solid are kept.  Vertices lie on the surfaces, those at edges on the
edge curves.  Neighbouring faces sample their common edge each in its own way: gaps up to the tolerance remain.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.carriers import Plane, Quadric, Surface, doubles
from firstcontact.body.csg import inside
from firstcontact.body.features import middle
from firstcontact.body.polyhedron import Polyhedron
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import to_double

if TYPE_CHECKING:
    from firstcontact.body.composite_quadric import CompositeQuadric

Triangles = np.ndarray
"""(n, 3, 3) float64 corners."""

MOST_TRIANGLES = 2_000_000


def mesh(body: CompositeQuadric, tolerance: float) -> Polyhedron:
    """The faces as triangles, oriented outwards; see `CompositeQuadric.to_mesh`."""
    if not (isinstance(tolerance, int | float) and 0 < tolerance < math.inf):
        raise InputError(f"to_mesh tolerance is {tolerance!r}; give a positive length")
    if not body.bounded:
        raise UnsupportedPair(f"{body.name or 'solid'}: no bound is known; intersect it with a box to mesh it")
    triangles, _ = face_triangles(body, tolerance, *body.bounds())
    grain = 1e-10 * float(np.abs(triangles).max() + np.ptp(triangles))
    flat = triangles.reshape(-1, 3)
    _, first, number = np.unique(np.round(flat / grain), axis=0, return_index=True, return_inverse=True)
    corners = number.reshape(-1, 3)
    proper = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    return Polyhedron(flat[first], corners[proper].astype(np.int32), solid=False, name=body.name)


def face_triangles(
    body: CompositeQuadric, tolerance: float, lo: np.ndarray, hi: np.ndarray
) -> tuple[Triangles, np.ndarray]:
    """The faces as triangles that look outwards, and the number (n,) of each one's face.

    lo, hi: (3,) corners of a box; of faces without end the part is covered that is near it.
    """
    numbers = {(f.surfaces[0], f.orientation): f.index for f in body.faces}
    found, owners = [], []
    for i in sorted({surface for surface, _ in numbers}):
        triangles, below = _surface_triangles(body, i, tolerance, lo, hi)
        found.append(triangles)
        owners.append(np.where(below, numbers.get((i, 1), -1), numbers.get((i, -1), -1)))
    return np.concatenate(found), np.concatenate(owners)


def _surface_triangles(
    body: CompositeQuadric, i: int, tolerance: float, lo: np.ndarray, hi: np.ndarray
) -> tuple[Triangles, np.ndarray]:
    """The triangles of surface i, and whether the body is where its form is negative, (n,) bools."""
    surface = body.surfaces[i]
    reach = float(np.linalg.norm(hi - lo))
    centre = (lo + hi) / 2
    triangles = _patch(surface, tolerance, centre, reach)
    curves = [*body.edges, *body.seams]
    others = sorted({j for e in curves if i in e.surfaces for j in e.surfaces if j != i})
    sizes = [math.sqrt(8 * tolerance * _smallest_radius(body.surfaces[j], reach)) for j in others]
    for j, size in zip(others, sizes, strict=True):
        if isinstance(body.surfaces[j], Quadric):
            triangles = _refined(body, i, j, triangles, size)
    for k, j in enumerate(others):
        triangles = _cut(body, i, j, others[:k], triangles)
    return _kept(body, i, others, triangles)


# -- covering a surface -------------------------------------------------------------------------------------


def _patch(surface: Surface, tolerance: float, centre: np.ndarray, reach: float) -> Triangles:
    """Triangles that cover the surface within `reach` of the centre, corners on it, `tolerance` from it elsewhere."""
    if isinstance(surface, Plane):
        n = np.array(doubles((surface.normal,))[0])
        foot = centre - n[:3] * (n[:3] @ centre + n[3]) / (n[:3] @ n[:3])
        basis = np.linalg.svd(n[None, :3])[2]
        u = np.linspace(-reach, reach, 9)
        return _grid(lambda a, b: foot + a[..., None] * basis[1] + b[..., None] * basis[2], u, u)
    return _quadric_patch(surface, tolerance, centre, reach)


def _grid(point: object, u: np.ndarray, v: np.ndarray) -> Triangles:
    """Two triangles for every cell of the parameters u x v."""
    p = point(*np.meshgrid(u, v, indexing="ij"))  # type: ignore[operator]
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    halves = [np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]
    return np.concatenate([h.reshape(-1, 3, 3) for h in halves])


def _count(length: float, radius: float, tolerance: float) -> int:
    """How many chords of a curve of that length and radius of curvature stay within half the tolerance."""
    step = math.sqrt(4 * tolerance * radius)
    return int(min(max(math.ceil(length / step), 4), 1000))


def _quadric_patch(quadric: Quadric, tolerance: float, centre: np.ndarray, reach: float) -> Triangles:
    """By normal form: sum of values[k] y_k^2 + 2 slope . y + constant in the frame of the axes."""
    form = np.array(doubles(quadric.form))
    form /= np.abs(form[:3, :3]).max()
    values, axes = np.linalg.eigh(form[:3, :3])
    values[np.abs(values) < 1e-9] = 0.0
    if np.sum(values < 0) > np.sum(values > 0):
        form, values = -form, -values
    order = np.array(sorted(range(3), key=lambda k: (values[k] == 0, -values[k])))  # +, -, 0
    values, axes = values[order], axes[:, order]
    start = np.array([to_double(x) for x in middle(quadric)])
    constant = float(start @ form[:3, :3] @ start + 2 * form[3, :3] @ start + form[3, 3])
    slope = (form[:3, :3] @ start + form[:3, 3]) @ axes
    slope[np.abs(slope) < 1e-9 * np.abs(form).max()] = 0.0
    if abs(constant) < 1e-12 * np.abs(form).max():
        constant = 0.0
    far = reach + float(np.linalg.norm(start - centre))
    parts = _normal_form(values, slope, constant, tolerance, far)
    return np.concatenate([start + part @ axes.T for part in parts])


def _normal_form(values: np.ndarray, slope: np.ndarray, k: float, tolerance: float, far: float) -> list[Triangles]:
    rank = int(np.sum(values != 0))
    if rank == 3:
        return _central(values, k, tolerance, far)
    if rank == 2 and slope[2]:
        return [_graph(values, slope[2], k, tolerance, far)]
    if rank == 2:
        return _cylinder(values, k, tolerance, far)
    across = slope.copy()
    across[0] = 0.0
    steepness = float(np.linalg.norm(across))
    down, ruling = across / steepness, np.cross([1.0, 0, 0], across / steepness)
    u = np.linspace(-far, far, 1 + _count(2 * far, steepness / values[0], tolerance))

    def point(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        height = -(values[0] * a**2 + k) / (2 * steepness)
        return a[..., None] * np.array([1.0, 0, 0]) + height[..., None] * down + b[..., None] * ruling

    return [_grid(point, u, np.array([-far, far]))]


def _central(values: np.ndarray, k: float, tolerance: float, far: float) -> list[Triangles]:
    """Ellipsoids, hyperboloids and cones: rings about the last axis."""
    if values[2] > 0:
        radii = np.sqrt(-k / values)
        n = _count(math.pi * radii.max(), float(radii.max()), tolerance)  # equal steps of the angle: chords shrink
        polar, around = np.linspace(0, math.pi, n + 1), np.linspace(0, 2 * math.pi, 2 * n + 1)
        return [
            _grid(
                lambda u, v: radii * np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1),
                polar,
                around,
            )
        ]
    waist = math.sqrt(abs(k)) if k else 0.0
    top = max(far * math.sqrt(-values[2]), waist * 1.001)

    def point(h: np.ndarray, v: np.ndarray) -> np.ndarray:
        ring = np.sqrt(np.maximum(h**2 - k, 0.0))
        scaled = [ring * np.cos(v) / math.sqrt(values[0]), ring * np.sin(v) / math.sqrt(values[1])]
        return np.stack([*scaled, h / math.sqrt(-values[2])], axis=-1)

    n = _count(2 * math.pi * far, far, tolerance)
    around = np.linspace(0, 2 * math.pi, n + 1)
    if k == 0:
        return [_grid(point, side * np.array([0.0, top]), around) for side in (1.0, -1.0)]
    m = _count(top, waist, tolerance)
    if k < 0:
        return [_grid(point, waist * np.sinh(np.linspace(-1, 1, 2 * m + 1) * math.asinh(top / waist)), around)]
    heights = waist * np.cosh(np.linspace(0, 1, m + 1) * math.acosh(top / waist))
    return [_grid(point, side * heights, around) for side in (1.0, -1.0)]


def _graph(values: np.ndarray, slope: float, k: float, tolerance: float, far: float) -> Triangles:
    """Paraboloids: height over the plane of the first two axes."""
    n = _count(2 * far, float(abs(slope) / np.abs(values).max()), tolerance / 2)
    u = np.linspace(-far, far, n + 1)

    def point(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.stack([a, b, -(values[0] * a**2 + values[1] * b**2 + k) / (2 * slope)], axis=-1)

    return _grid(point, u, u)


def _cylinder(values: np.ndarray, k: float, tolerance: float, far: float) -> list[Triangles]:
    """Elliptic and hyperbolic cylinders: rulings along the last axis."""
    ends = np.array([-far, far])
    if values[1] > 0:
        a, b = np.sqrt(-k / values[:2])
        n = _count(2 * math.pi * max(a, b), max(a, b), tolerance)
        around = np.linspace(0, 2 * math.pi, n + 1)
        return [_grid(lambda u, v: np.stack([a * np.cos(u), b * np.sin(u), v], axis=-1), around, ends)]
    first = 0 if k < 0 else 1  # the axis that the two branches cross
    a, b = math.sqrt(abs(k / values[first])), math.sqrt(abs(k / values[1 - first]))
    n = _count(2 * far, b * b / a, tolerance)
    u = np.arcsinh(far / b) * np.linspace(-1, 1, n + 1)

    def point(t: np.ndarray, v: np.ndarray, side: float) -> np.ndarray:
        x, y = side * a * np.cosh(t), b * np.sinh(t)
        return np.stack([x, y, v] if first == 0 else [y, x, v], axis=-1)

    return [_grid(lambda t, v, s=side: point(t, v, s), u, ends) for side in (1.0, -1.0)]


def _smallest_radius(surface: Surface, reach: float) -> float:
    """A rough smallest radius of curvature."""
    if isinstance(surface, Plane):
        return reach
    form = np.array(doubles(surface.form))
    start = np.array([*(to_double(x) for x in middle(surface)), 1.0])
    bend, value = float(np.abs(np.linalg.eigvalsh(form[:3, :3])).max()), abs(float(start @ form @ start))
    slope = float(np.linalg.norm((form @ start)[:3]))
    return max(min(reach, max(math.sqrt(value / bend), slope / bend)), 0.01 * reach)


# -- cutting at the edges -----------------------------------------------------------------------------------


def _value(body: CompositeQuadric, j: int, p: np.ndarray) -> np.ndarray:
    x = np.concatenate([p, np.ones((*p.shape[:-1], 1))], axis=-1)
    return np.sum((x @ body._forms_f[j]) * x, axis=-1)


def _slope(body: CompositeQuadric, j: int, p: np.ndarray) -> np.ndarray:
    x = np.concatenate([p, np.ones((*p.shape[:-1], 1))], axis=-1)
    return 2 * (x @ body._forms_f[j])[..., :3]


def _onto(body: CompositeQuadric, surfaces: tuple[int, ...], p: np.ndarray) -> np.ndarray:
    """(n, 3) points taken onto all the surfaces (one or two) by Newton steps of least length."""
    for _ in range(5):
        value = np.stack([_value(body, j, p) for j in surfaces], axis=1)
        slope = np.stack([_slope(body, j, p) for j in surfaces], axis=1)
        gram = np.einsum("nik,njk->nij", slope, slope)
        size = np.trace(gram, axis1=1, axis2=2) + 1e-300
        gram += 1e-13 * size[:, None, None] * np.eye(len(surfaces))
        p = p - np.einsum("nik,ni->nk", slope, np.linalg.solve(gram, value[..., None])[..., 0])
    return p


def _refined(body: CompositeQuadric, i: int, j: int, triangles: Triangles, size: float) -> Triangles:
    """Triangles that surface j may cross, halved across their longest sides until those are shorter than `size`."""
    done = []
    bend = float(np.abs(np.linalg.eigvalsh(body._forms_f[j][:3, :3])).max())
    while len(triangles):
        centre = triangles.mean(axis=1)
        radius = np.linalg.norm(triangles - centre[:, None], axis=2).max(axis=1)
        slope = np.linalg.norm(_slope(body, j, centre), axis=1)
        near = np.abs(_value(body, j, centre)) <= slope * radius + bend * radius**2
        sides = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        split = near & (sides.max(axis=1) > size)
        done.append(triangles[~split])
        triangles = triangles[split]
        if sum(map(len, done)) + 2 * len(triangles) > MOST_TRIANGLES:
            raise InputError(f"to_mesh needs more than {MOST_TRIANGLES} triangles; give a larger tolerance")
        longest = sides[split].argmax(axis=1)
        rows = np.arange(len(triangles))
        a, b, c = (triangles[rows, (longest + k) % 3] for k in range(3))
        half = _onto(body, (i,), (a + b) / 2)
        triangles = np.concatenate([np.stack([a, half, c], axis=1), np.stack([half, b, c], axis=1)])
    return np.concatenate(done)


def _cut(body: CompositeQuadric, i: int, j: int, before: list[int], triangles: Triangles) -> Triangles:
    """Every triangle with corners on both sides of surface j cut into three along it; `before`: cut at already."""
    values = _value(body, j, triangles)
    values[np.abs(values) < 1e-11 * (np.abs(values).max() + 1e-300)] = 0.0
    crossed = (values.max(axis=1) > 0) & (values.min(axis=1) < 0)
    whole, triangles, values = triangles[~crossed], triangles[crossed], values[crossed]
    if not len(triangles):
        return whole
    signs = np.sign(values)
    zero = (signs == 0).any(axis=1)
    odd = np.where(signs.sum(axis=1) > 0, signs.argmin(axis=1), signs.argmax(axis=1))  # the corner alone on its side
    first = np.where(zero, (signs == 0).argmax(axis=1), odd)
    rows = np.arange(len(triangles))
    (a, b, c), (fa, fb, fc) = (
        tuple(x[rows, (first + k) % 3] for k in range(3)) for x in (triangles, values)
    )
    bc = _crossing(body, i, j, before, b[zero], c[zero], fb[zero], fc[zero])
    through = [np.stack([a[zero], b[zero], bc], axis=1), np.stack([a[zero], bc, c[zero]], axis=1)]
    one = ~zero
    ab = _crossing(body, i, j, before, a[one], b[one], fa[one], fb[one])
    ac = _crossing(body, i, j, before, a[one], c[one], fa[one], fc[one])
    tip, rest = np.stack([a[one], ab, ac], axis=1), np.stack([ab, b[one], c[one]], axis=1)
    return np.concatenate([whole, *through, tip, rest, np.stack([ab, c[one], ac], axis=1)])


def _crossing(
    body: CompositeQuadric,
    i: int,
    j: int,
    before: list[int],
    p: np.ndarray,
    q: np.ndarray,
    fp: np.ndarray,
    fq: np.ndarray,
) -> np.ndarray:
    """Where the sides p q meet surface j, on both surfaces; and on a third one if the whole side is an edge there."""
    start = (p * fq[:, None] - q * fp[:, None]) / (fq - fp)[:, None]
    points = _onto(body, (i, j), start)
    for k in before:
        along = np.maximum(np.abs(_value(body, k, p)), np.abs(_value(body, k, q))) < 1e-11
        if along.any():
            points[along] = _onto(body, (i, j, k), start[along])
    return np.round(points, 13)


def _kept(body: CompositeQuadric, i: int, others: list[int], triangles: Triangles) -> tuple[Triangles, np.ndarray]:
    """The triangles that bound the solid and the side it is on, turned so that their normals point outwards.

    Triangles are on one side of the surfaces they were cut along: the corner farthest from one tells which.
    """
    centre = _onto(body, (i,), triangles.mean(axis=1))
    negative = [_value(body, j, centre) < 0 for j in range(len(body.surfaces))]
    rows = np.arange(len(triangles))
    for j in others:
        values = _value(body, j, triangles)
        far = values[rows, np.abs(values).argmax(axis=1)]
        clear = np.abs(far) > 1e-10
        negative[j] = np.where(clear, far < 0, negative[j])
    shape = np.zeros(len(centre), bool)
    below = inside(body.tree, [shape | True if j == i else n for j, n in enumerate(negative)]) | shape
    above = inside(body.tree, [shape if j == i else n for j, n in enumerate(negative)]) | shape
    keep = below != above
    triangles, below, centre = triangles[keep], below[keep], centre[keep]
    outward = _slope(body, i, centre) * np.where(below, 1.0, -1.0)[:, None]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    backwards = np.sum(normal * outward, axis=1) < 0
    triangles[backwards] = triangles[backwards][:, ::-1]
    return triangles, below
