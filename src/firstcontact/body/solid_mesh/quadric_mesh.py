"""Triangle meshes of composite quadric models, closed wherever the model is.

Every edge is sampled once (`mesh_curves`); on each surface the chords become sides of a triangulation of its chart
(`mesh_charts`, `mesh_net`), so faces meet along the same chords.  The parts between chords that bound the solid are
kept and refined inside, in the chart: a side p q is |F((p + q)/2)| = |(p - q)^T A (p - q)| / 4 off the quadric F, a
triangle at most 4/3 of its worst side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.polyhedron.topology import component_of_vertices
from firstcontact.body.solid.csg import inside
from firstcontact.body.solid_mesh.mesh_charts import MeshChart, charts
from firstcontact.body.solid_mesh.mesh_curves import Samples
from firstcontact.body.solid_mesh.mesh_net import Crossing, SphereNet
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.rigid import Vector, to_origin

if TYPE_CHECKING:
    from firstcontact.body.solid.composite_quadric import CompositeQuadric

MOST_TRIANGLES = 2_000_000
# Sizes of a body from the origin beyond which it is meshed there.
FAR = 2.0**10
# How far away the nearest part of a body without end is looked for, as a multiple of the coordinates.
FARTHEST = 1e6
# Of the tolerance, what sides and chords of edges may be off: with 4/3 of it triangles keep within.
SHARE = 0.7
# Sides along which the surface turns by more than 70 degrees are halved at any tolerance.
TURN = math.cos(math.radians(70))
# How often edges are sampled more finely where chords cross on a surface that its curves do not.
RESAMPLED = 12
# How many rounds of halving are followed by flips, and how many rounds of flips come first: as many as help.
FLIPPED, FLIPS = 10, 10**6
# The whole size of a face counts in flips as much as this share of the bound on distances.
LENGTH_SHARE = 1e-3
# Halving ends then: beside coarse chords some side may stay off by more than the bound however short others get.
ROUNDS = 40


# Finest tolerance, of the body's size: the number of triangles grows with the inverse of it.
FINEST = 1e-6


def mesh(body: CompositeQuadric, tolerance: float) -> Polyhedron:
    """The faces as triangles, oriented outwards; see `CompositeQuadric.to_mesh`."""
    if not (isinstance(tolerance, int | float) and 0 < tolerance < math.inf):
        raise InputError(f"to_mesh tolerance is {tolerance!r}; give a positive length")
    if not body.bounded:
        raise UnsupportedPair(f"{body.name or 'solid'}: no bound is known; intersect it with a box to mesh it")
    lo, hi = body.bounds()
    if not tolerance > (finest := FINEST * float(np.max(hi - lo))):
        raise InputError(f"to_mesh tolerance is {tolerance!r}; give more than {finest:.2g}, a millionth of the size")
    by = _to_origin(body)
    if by is not None:  # exactly: far away doubles tell no triangles apart
        return mesh(body.translated(by), tolerance).translated([-c for c in by])
    vertices, triangles, _ = _meshed(body, tolerance)
    return Polyhedron(vertices, triangles.astype(np.int32), name=body.name)


def _to_origin(body: CompositeQuadric) -> Vector | None:
    """The shift to the origin of a body that is small for where it lies."""
    lo, hi = body.bounds()
    size, middle = float((hi - lo).max()), 0.5 * (lo + hi)
    return to_origin(middle.tolist(), size) if float(np.abs(middle).max()) > FAR * size > 0.0 else None


def face_triangles(
    body: CompositeQuadric, tolerance: float, lo: np.ndarray, hi: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The faces as triangles (n, 3, 3) that look outwards, and the number (n,) of each one's face.

    lo, hi: (3,) corners of a box; of bodies without end the part is covered that is near it.
    """
    whole = body
    if not body.bounded:
        body = _part_near(body, lo, hi)
    vertices, triangles, sides = _meshed(body, tolerance)
    numbers = {(f.surfaces[0], f.orientation): f.index for f in whole.faces}
    owners = np.array([numbers.get(side, -1) for side in map(tuple, sides.tolist())], int)
    return vertices[triangles[owners >= 0]], owners[owners >= 0]


def _part_near(body: CompositeQuadric, lo: np.ndarray, hi: np.ndarray) -> CompositeQuadric:
    """What a body without end has in a cube about the corners: the first of growing ones to hold some."""
    from firstcontact.body.solid.composite_quadric import NoSolid
    from firstcontact.body.solid.primitives import box

    size = 2 * float(np.linalg.norm(hi - lo))
    while True:
        try:
            return body & box((size,) * 3).translated(((lo + hi) / 2).tolist())
        except NoSolid:
            if size > FARTHEST * (1 + float(np.abs([lo, hi]).max())):
                raise
            size *= 4


# -- all surfaces -------------------------------------------------------------------------------------------


@dataclass(eq=False)
class _Skin:
    """Triangles of one sheet that bound the solid.

    rays, points: (n, 3) of its vertices; numbers: (n,) of the samples among them, -1 inside faces.
    triangles: (m, 3), turning left in the chart; sides: (m,) +1 where the body is where the form is negative, else -1.
    fixed: sorted keys (`_keys`) of the chords.  outward: +1 where triangles turning left look to positive values.
    """

    surface: int
    form: np.ndarray
    chart: MeshChart
    rays: np.ndarray
    points: np.ndarray
    numbers: np.ndarray
    triangles: np.ndarray
    sides: np.ndarray
    fixed: np.ndarray
    outward: int


def _meshed(body: CompositeQuadric, tolerance: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3), triangles (m, 3) and the (surface, orientation) of each triangle's face, (m, 2)."""
    bound = SHARE * tolerance
    samples = Samples(body, bound)
    skins: list[_Skin] = []
    for attempt in range(RESAMPLED):
        crossing: set[tuple[int, int]] = set()
        skins = []
        for i in sorted({f.surfaces[0] for f in body.faces}):
            skins += _skins(body, i, samples, crossing)
        if not crossing or attempt == RESAMPLED - 1:
            break  # what crosses to the end leaves the mesh open: its `solid` tells
        for segment in crossing:
            samples.halve(segment)
    for skin in skins:
        _refine(skin, bound)
    while _part_twins(skins):
        pass
    return _joined(skins, np.array(samples.points).reshape(-1, 3))


def _joined(skins: list[_Skin], points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    vertices, triangles, sides, total = [points], [], [], len(points)
    for skin in skins:
        inner = skin.numbers < 0
        numbers = np.where(inner, total + np.cumsum(inner) - 1, skin.numbers)
        vertices.append(skin.points[inner])
        total += int(inner.sum())
        corners = numbers[skin.triangles]
        backwards = skin.sides * skin.outward < 0
        corners[backwards] = corners[backwards][:, ::-1]
        triangles.append(corners)
        sides.append(np.column_stack([np.full(len(corners), skin.surface), skin.sides]))
    every = np.concatenate([np.empty((0, 3), int), *triangles])
    used, numbers = np.unique(every, return_inverse=True)
    owners = np.concatenate([np.empty((0, 2), int), *sides])
    found = np.concatenate(vertices)[used]
    found[np.abs(found) < 1e-15 * np.abs(found).max(initial=0.0)] = 0.0  # what rounding left of zeros
    return found, numbers.reshape(-1, 3), owners


def _part_twins(skins: list[_Skin]) -> bool:
    """Halve inner sides of several faces between the same two samples: flat, those faces would touch there."""
    found = []
    for skin in skins:
        a, b = _sides(skin.triangles)
        numbers = skin.numbers[a], skin.numbers[b]
        outer = (numbers[0] >= 0) & (numbers[1] >= 0)
        found.append((a[outer], b[outer], numbers[0][outer], numbers[1][outer]))
    pairs = np.sort(np.concatenate([np.stack(f[2:], axis=1) for f in found]), axis=1)
    _, where, uses = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    many = uses[where.ravel()] > 2
    start, parted = 0, False
    for skin, (a, b, _, _) in zip(skins, found, strict=True):
        keys = _keys(skin, a, b)[many[start : start + len(a)]]
        start += len(a)
        keys = np.setdiff1d(keys, skin.fixed)
        parted |= len(keys) > 0
        _halve(skin, keys)
    return parted


# -- one surface --------------------------------------------------------------------------------------------


def _skins(body: CompositeQuadric, i: int, samples: Samples, crossing: set[tuple[int, int]]) -> list[_Skin]:
    """The faces on surface i as triangles between the samples; notes segments that cross on it."""
    segments = samples.segments(i)
    tips = {v.index for v in body.vertices if i in v.surfaces}
    on = np.array(sorted(tips | {k for segment in segments for k in segment}), int)
    points = np.array([samples.points[k] for k in on]).reshape(-1, 3)
    found = []
    for chart in charts(body.surfaces[i], points):
        held = chart.holds(points)
        own = {int(k) for k in on[held]}
        chords = [(a, b) for a, b in segments if a in own and b in own]
        if chords or chart.whole:
            skin = _skin(body, i, chart, on[held], points[held], chords, crossing)
            found += [skin] if len(skin.triangles) else []
    return found


def _skin(
    body: CompositeQuadric,
    i: int,
    chart: MeshChart,
    on: np.ndarray,
    points: np.ndarray,
    chords: list[tuple[int, int]],
    crossing: set[tuple[int, int]],
) -> _Skin:
    net = SphereNet(chart.base)
    base = len(chart.base)
    rays = chart.rays(points)
    row = {int(k): r for r, k in enumerate(on)}
    corner: dict[int, int] = {}
    last = 0
    for k in [k for chord in chords for k in chord] + list(row):
        if k not in corner:
            corner[k] = last = net.insert(rays[row[k]], last)
    sample = {c: k for k, c in corner.items()}
    for a, b in chords:
        try:
            net.fix(corner[a], corner[b])
        except Crossing as found:
            crossing |= {(sample[a], sample[b]) for a, b in found.segments}
    triangles = net.triangles()
    order = np.array([row[k] for k in corner], int)
    numbers = np.concatenate([np.full(base, -1), on[order]])
    all_rays = np.concatenate([chart.base, rays[order]])
    all_points = np.concatenate([chart.lifted(chart.base), points[order]])
    fixed = np.array([a * len(all_rays) + b for a, b in net.fixed if a < b], np.int64)
    skin = _Skin(
        i, body.forms[i], chart, all_rays, all_points, numbers, triangles, np.zeros(len(triangles), int),
        np.sort(fixed), 1,
    )  # fmt: skip
    _keep_boundary(body, skin)
    return skin


def _keep_boundary(body: CompositeQuadric, skin: _Skin) -> None:
    """Drop the triangles of parts between chords that do not bound the solid; note the side the body is on."""
    a, b = _sides(skin.triangles)
    keys = _keys(skin, a, b)
    order = np.argsort(keys, kind="stable")
    pairs = np.stack([order[::2], order[1::2]], axis=1) % len(skin.triangles)  # the net is closed: sides come in twos
    free = ~np.isin(keys[order[::2]], skin.fixed)
    label = component_of_vertices(pairs[free].astype(np.int32), len(skin.triangles))
    for part in np.unique(label):
        own = np.flatnonzero(label == part)
        corners = skin.triangles[own]
        if not skin.chart.whole and np.any(corners < len(skin.chart.base)):
            continue
        side, outward = _side(body, skin, corners)
        if side:
            skin.sides[own], skin.outward = side, outward
    kept = skin.sides != 0
    skin.triangles, skin.sides = skin.triangles[kept], skin.sides[kept]


def _side(body: CompositeQuadric, skin: _Skin, corners: np.ndarray) -> tuple[int, int]:
    """(side, outward) of a part of a surface, 0 for no boundary: told at the clearest of its triangles' centres."""
    i = skin.surface
    rays = _unit(skin.rays)[corners]
    middle = rays.mean(axis=1)
    centre = skin.chart.lifted(middle)
    values = [_value(form, centre) for form in body.forms]
    curves = [*body.edges, *body.seams]
    others = sorted({j for e in curves if i in e.surfaces for j in e.surfaces if j != i})
    clear = [np.abs(values[j]) / np.linalg.norm(_slope(body.forms[j], centre), axis=1) for j in others]
    clearance = np.min([np.full(len(centre), np.inf), *clear], axis=0)
    k = int(np.argmax(clearance))
    below, above = (inside(body.tree, [bool(v[k] < 0) if j != i else at for j, v in enumerate(values)])
                    for at in (True, False))  # fmt: skip
    small = skin.chart.lifted(middle[k] + 1e-3 * (rays[k] - middle[k]))
    normal = np.cross(small[1] - small[0], small[2] - small[0])
    outward = 1 if normal @ _slope(body.forms[i], centre[k : k + 1])[0] > 0 else -1
    return int(below) - int(above), outward


def _value(form: np.ndarray, p: np.ndarray) -> np.ndarray:
    x = np.column_stack([p, np.ones(len(p))])
    values: np.ndarray = np.einsum("ni,ij,nj->n", x, form, x)
    return values


def _slope(form: np.ndarray, p: np.ndarray) -> np.ndarray:
    slopes: np.ndarray = 2 * (p @ form[:3, :3] + form[3, :3])
    return slopes


# -- refining -----------------------------------------------------------------------------------------------


def _refine(skin: _Skin, bound: float) -> None:
    """Flip sides to lie closer to the surface, and halve inner sides that are off by more than the bound."""
    for attempt in range(ROUNDS):
        if attempt < FLIPPED:  # from then on sides only get shorter, so that this ends
            _flip(skin, bound, 8 if attempt else FLIPS)
        a, b = _sides(skin.triangles)
        keys, first = np.unique(_keys(skin, a, b), return_index=True)
        a, b = a[first], b[first]
        free = ~np.isin(keys, skin.fixed)
        slope = _slope(skin.form, skin.points)
        steep = np.linalg.norm(slope, axis=1)
        clear = steep > 1e-9 * steep.max()  # tips of cones have no normal
        normals = _unit(slope)
        bent = clear[a] & clear[b] & (np.sum(normals[a] * normals[b], axis=1) < TURN)
        wide = keys[free & ((bent & (attempt < FLIPPED // 2)) | (_off(skin, a, b) > bound))]
        if not len(wide):
            return
        if len(skin.triangles) + 2 * len(wide) > MOST_TRIANGLES:
            raise InputError(f"to_mesh needs more than {MOST_TRIANGLES} triangles; give a larger tolerance")
        _halve(skin, wide)


def _off(skin: _Skin, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How far the middles of the sides a b are off the surface, to second order."""
    along = skin.points[a] - skin.points[b]
    steep = np.linalg.norm(_slope(skin.form, skin.points), axis=1)
    bend = np.abs(np.einsum("ni,ij,nj->n", along, skin.form[:3, :3], along))
    total = steep[a] + steep[b]
    off: np.ndarray = np.divide(bend, 2 * total, out=np.zeros_like(bend), where=total > 0)
    return off


def _halve(skin: _Skin, keys: np.ndarray) -> None:
    """Put a vertex of the surface into the middle of each side with one of these sorted keys."""
    n = len(skin.rays)
    a, b = keys // n, keys % n
    unit = _unit(skin.rays) if skin.chart.sheet is None and skin.chart.whole else skin.rays
    rays = unit[a] + unit[b]
    skin_sides = skin.triangles
    place = np.searchsorted(keys, _keys(skin, *_sides(skin_sides)))
    place = np.minimum(place, len(keys) - 1)
    if not len(keys):
        return
    cut = keys[place] == _keys(skin, *_sides(skin_sides))
    middles = np.where(cut, n + place, -1).reshape(3, -1).T  # (m, 3): on the side from corner s to s + 1
    done = []
    owners = []
    number = (middles >= 0).sum(axis=1)
    for cuts in range(4):
        t, m, side = (x[number == cuts] for x in (skin.triangles, middles, skin.sides))
        # turned so that sides 0 .. cuts - 1 are the cut ones
        first = np.argmax((m >= 0) & (np.roll(m, 1, axis=1) < 0), axis=1) if 0 < cuts < 3 else np.zeros(len(t), int)
        turned = (first[:, None] + np.arange(3)) % 3
        (p, q, r), (u, v, w) = np.take_along_axis(t, turned, 1).T, np.take_along_axis(m, turned, 1).T
        pieces = {
            0: [(p, q, r)],
            1: [(p, u, r), (u, q, r)],
            2: [(u, q, v), (p, u, v), (p, v, r)],
            3: [(p, u, w), (u, q, v), (w, v, r), (u, v, w)],
        }[cuts]
        done += [np.stack(piece, axis=1) for piece in pieces]
        owners += [side] * len(pieces)
    skin.triangles, skin.sides = np.concatenate(done), np.concatenate(owners)
    skin.points = np.concatenate([skin.points, skin.chart.lifted(rays)])
    skin.rays = np.concatenate([skin.rays, skin.chart.rays(skin.points[n:])])
    skin.numbers = np.concatenate([skin.numbers, np.full(len(keys), -1)])
    skin.fixed = (skin.fixed // n) * len(skin.rays) + skin.fixed % n


def _flip(skin: _Skin, bound: float, rounds: int) -> None:
    """Flip inner sides whose other diagonal is closer to the surface, or nearly as close and shorter."""

    def cost(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        length: np.ndarray = np.linalg.norm(skin.points[a] - skin.points[b], axis=1)
        return _off(skin, a, b) + by_length * length

    by_length = LENGTH_SHARE * bound / float(np.ptp(skin.points, axis=0).max())
    rays = _unit(skin.rays)
    for _ in range(rounds):
        m = len(skin.triangles)
        a, b = _sides(skin.triangles)
        keys = _keys(skin, a, b)
        order = np.argsort(keys, kind="stable")
        twin = np.flatnonzero(keys[order][1:] == keys[order][:-1])
        one, two = order[twin], order[twin + 1]
        free = ~np.isin(keys[one], skin.fixed)
        one, two = one[free], two[free]
        first, second = one % m, two % m
        p, q = a[one], b[one]
        r, s = (skin.triangles[side % m, (side // m + 2) % 3] for side in (one, two))
        convex = np.minimum(_turn(rays, p, s, r), _turn(rays, s, q, r)) > 1e-14
        before = cost(p, q)
        gain = before - cost(r, s)
        better = np.flatnonzero(convex & (gain > 1e-9 * before))
        if not len(better):
            return
        rank = np.empty(len(better), int)
        rank[np.argsort(gain[better], kind="stable")] = np.arange(len(better))
        best = np.full(m, -1)
        for t in (first, second):
            np.maximum.at(best, t[better], rank)
        chosen = better[(best[first[better]] == rank) & (best[second[better]] == rank)]
        p, q, r, s = (x[chosen] for x in (p, q, r, s))
        skin.triangles[first[chosen]] = np.stack([p, s, r], axis=1)
        skin.triangles[second[chosen]] = np.stack([s, q, r], axis=1)


def _turn(rays: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    volumes: np.ndarray = np.sum(np.cross(rays[a], rays[b]) * rays[c], axis=1)
    return volumes


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    units: np.ndarray = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return units


def _sides(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3 m,) first and last corners of the directed sides; side k of triangle t is at k m + t."""
    return triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()


def _keys(skin: _Skin, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """One number for each pair of corners, whatever their order."""
    keys: np.ndarray = np.minimum(a, b).astype(np.int64) * len(skin.rays) + np.maximum(a, b)
    return keys
