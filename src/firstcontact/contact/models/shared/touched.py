"""The features of a model at a contact: how users call them, and what is flat around them.

Worked out once per feature and kept on the model, in plain Python numbers: a query asks for one or two features, and
arrays of three numbers cost more than the arithmetic on them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from flint import fmpq, fmpq_mat

from firstcontact.body.kept import Kept
from firstcontact.body.solid.carriers import Line, Plane, Rows, doubles, null_space, times, upright
from firstcontact.body.solid.carriers import Point as RationalPoint
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.answer import element, rank
from firstcontact.contact.models.forms import Form, forms_of, height, value
from firstcontact.exact.vectors import dot
from firstcontact.result import Element
from firstcontact.search.convex.convex import convex_pieces

ACROSS = 1e-6
"""Sine of the angle below which directions count as parallel: what is flat there may be shared in more than a point,
which exact arithmetic then decides."""

BESIDE = 1e-10
"""Of the size of its terms: where a form is smaller than that, its surface counts as touched too."""

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Flat:
    """A plane face, or a line in a body's surface: an edge, or the ruling of a cone or cylinder through the contact.

    direction   of the line, any length, in the body's frame; None of a plane.
    exact       the same, or the normal of a plane, as coprime integers: alike for all that are parallel; None where
                there is no rational one.
    """

    feature: Face | Edge
    direction: Point | None
    exact: tuple[int, ...] | None


Flats = Sequence[tuple[Flat, Point | None]]
"""What is flat around a contact, with its direction in the world, None of a plane."""


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """A face at the feature.

    form   xx, yy, zz, xy, xz, yz, x, y, z of half its gradient.
    flat   of planes and cylinders, what is flat in it at all points.
    apex   of cones, homogeneous.
    inverse  of cones where the feature is the apex: rows of the inverse of their form's quadratic part.
    """

    face: Face
    form: tuple[float, ...]
    flat: Flat | None
    apex: tuple[float, float, float, float] | None
    inverse: tuple[Point, ...] | None = None

    def flat_at(self, x: float, y: float, z: float, n: Point) -> Flat | None:
        """What is flat through the point, where the face is across the normal n there."""
        if self.inverse is not None:  # every ruling is here: the one across n has n for its gradient
            first, second, third = self.inverse
            d = dot(first, n), dot(second, n), dot(third, n)
            return Flat(self.face, d, None) if abs(dot(d, n)) <= ACROSS * _length(d) * _length(n) else None
        xx, yy, zz, xy, xz, yz, x1, y1, z1 = self.form
        g = (
            xx * x + xy * y + xz * z + x1,
            xy * x + yy * y + yz * z + y1,
            xz * x + yz * y + zz * z + z1,
        )
        if not is_parallel(g, n):
            return None
        if self.apex is None:
            return self.flat
        p, q, r, w = self.apex
        return Flat(self.face, (p - w * x, q - w * y, r - w * z), None)


@dataclass(frozen=True, slots=True, eq=False)
class Touched:
    """A feature with what may be flat around it: faces with lines or planes in them, and straight edges."""

    model: CompositeQuadric
    feature: Face | Edge | Vertex
    sides: tuple[_Side, ...]
    lines: tuple[Flat, ...]

    def flats(self, where: Point, n: Point) -> list[Flat]:
        """Lines and planes across the normal in the faces and edges that meet in the feature."""
        found = [f for side in self.sides if (f := side.flat_at(*where, n)) is not None]
        for line in self.lines:
            d = line.direction
            assert d is not None
            if abs(dot(d, n)) <= ACROSS * _length(d) * _length(n):
                found.append(line)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class TouchingGroup:
    """Features of a model that touch as one.

    surfaces: of all of them; smooth: whether all are faces.
    """

    model: CompositeQuadric
    features: list[Touched]
    surfaces: frozenset[int]
    smooth: bool


_GROUPS = Kept[dict[tuple[tuple[str, int], ...], TouchingGroup]]()
_SEAMED = Kept[list[tuple[int, Form, float]]]()
_MET = Kept[dict[frozenset[int], list[Touched]]]()
_ELEMENTS = Kept[dict[tuple[str, Face | Edge | Vertex], tuple[tuple[int, int], Element]]]()
_TOUCHED = Kept[dict[tuple[str, int], Touched]]()


def group(model: CompositeQuadric, features: tuple[tuple[str, int], ...]) -> TouchingGroup:
    """Features as `search.convex.advance` numbers them, kept on the model."""
    groups = _GROUPS.of(model, dict)
    known = groups.get(features)
    if known is None:
        found = [touched(model, kind, index) for kind, index in features]
        surfaces = frozenset(k for x in found for k in x.feature.surfaces)
        smooth = all(isinstance(x.feature, Face) for x in found)
        known = groups[features] = TouchingGroup(found[0].model, found, surfaces, smooth)
    return known


def with_neighbours(known: TouchingGroup, where: Point) -> list[Touched]:
    """The touched features, with the faces and edges that lie at the point too, or nearly.

    Features of a piece tell all but what joins it smoothly in other pieces.
    """
    model = known.model
    seamed = _SEAMED.of(model, lambda: _seamed(model))
    if not seamed:
        return known.features
    own, near = known.features[0].feature.surfaces, []
    far = max(map(abs, where))  # coordinates are rounded by a part of the largest: a plane y = 0 has no terms there
    for k, form, least in seamed:
        if k not in own and (v := abs(height(form, *where))) <= least:
            if v <= BESIDE * value(form, far, far, far)[1]:  # beside a seam it grows with the square of the distance
                near.append(k)
    if not near:
        return known.features
    there = known.surfaces.union(near)
    met = _MET.of(model, dict)
    if there not in met:
        faces = [f for f in model.faces if there.issuperset(f.surfaces)]
        edges = [e for e in model.edges if there.issuperset(e.surfaces)]
        met[there] = [Touched(model, faces[0], _sides(faces, faces[0]), _lines(edges))] if faces else known.features
    return met[there]


def _seamed(model: CompositeQuadric) -> list[tuple[int, Form, float]]:
    """The surfaces with smooth seams: number, form, and a size that it has at no point of the model beside it."""
    joined = sorted({s for seam in model.seams for k in seam.faces for s in model.faces[k].surfaces})
    forms = forms_of(model)
    if not model.bounded:
        return [(k, forms[k], inf) for k in joined]
    far = np.abs(model.bounds()).max(axis=0).tolist()
    return [(k, forms[k], 2.0 * BESIDE * value(forms[k], *far)[1]) for k in joined]


def _lines(edges: Sequence[Edge]) -> tuple[Flat, ...]:
    return tuple(
        Flat(e, tuple(e.frame[:3, 0].tolist()), coprime(row[0] for row in e.carrier.basis[:3]))
        for e in edges if isinstance(e.carrier, Line)
    )  # fmt: skip


def coprime(vector: Iterable[fmpq]) -> tuple[int, ...]:
    """The multiple with coprime integers whose first nonzero one is positive."""
    return tuple(int(x.p) for x in upright(tuple(vector)))


def is_parallel(x: Point, y: Point) -> bool:
    (a, b, c), (p, q, r) = x, y
    u, v, w = b * r - c * q, c * p - a * r, a * q - b * p
    return u * u + v * v + w * w <= ACROSS * ACROSS * (a * a + b * b + c * c) * (p * p + q * q + r * r)


def _length(x: Point) -> float:
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])


def lowest(known: TouchingGroup, which: str, where: Point) -> Element:
    """Vertices before edges before faces."""
    if len(known.features) == 1:
        return ranked(known.model, known.features[0].feature, which, where)[1]
    return min(ranked(known.model, x.feature, which, where) for x in known.features)[1]


def ranked(
    model: CompositeQuadric, feature: Face | Edge | Vertex, which: str, where: Point
) -> tuple[tuple[int, int], Element]:
    """`rank` of a feature and how body `which` calls it; kept on the model, but for one of several coplanar faces."""
    elements = _ELEMENTS.of(model, dict)
    known = elements.get((which, feature))
    if known is None:
        x = element(model, feature, which, np.array(where))
        known = rank(x), x
        if model.source is None or not isinstance(feature, Face):
            elements[which, feature] = known
    return known


def touched(model: CompositeQuadric, kind: str, index: int) -> Touched:
    """A feature as `search.convex.advance` numbers it; of a cut model, that of the whole one on the same surfaces."""
    known = _TOUCHED.of(model, dict)
    found = known.get((kind, index))
    if found is None:
        feature = _feature(model, kind, index)
        whole = model.whole or model
        around = set(feature.surfaces)
        faces = (feature,) if isinstance(feature, Face) else [f for f in whole.faces if around & set(f.surfaces)]
        edges = () if isinstance(feature, Face) else [e for e in whole.edges if set(e.surfaces) <= around]
        sides = _sides(faces, feature)
        found = known[kind, index] = Touched(whole, feature, sides, _lines(edges))
    return found


def _feature(model: CompositeQuadric, kind: str, index: int) -> Face | Edge | Vertex:
    features = _features(model, kind)
    found: Face | Edge | Vertex
    if kind == "corner":  # of a piece: the nearest of the model
        where = convex_pieces(model).array[index, :3]
        found = min(model.vertices, key=lambda v: float(np.abs(np.array(v.position) - where).max()))
    else:
        found = next(f for f in features if f.index == index)
    return found if model.whole is None else model.of_whole(found)


def _features(model: CompositeQuadric, kind: str) -> Sequence[Face | Edge | Vertex]:
    known: dict[str, Sequence[Face | Edge | Vertex]] = {"face": model.faces, "edge": model.edges}
    return known.get(kind, model.vertices)


def _inverse(form: Rows) -> Rows:
    """Of the quadratic part."""
    return tuple(map(tuple, fmpq_mat([list(row[:3]) for row in form[:3]]).inv().tolist()))


def _sides(faces: Sequence[Face], feature: Face | Edge | Vertex) -> tuple[_Side, ...]:
    """Those with anything flat in them."""
    sides = (_side(face, feature) for face in faces)
    return tuple(side for side in sides if side.flat is not None or side.apex is not None)


def _side(face: Face, feature: Face | Edge | Vertex) -> _Side:
    carrier = face.carrier
    m = doubles(carrier.matrix())
    form = m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2], m[0][3], m[1][3], m[2][3]
    if isinstance(carrier, Plane):
        return _Side(face, form, Flat(face, None, coprime(carrier.normal[:3])), None)
    kernel = null_space(carrier.form)
    if len(kernel) == 1 and kernel[0][3] != 0:
        p, q, r, w = doubles((kernel[0],))[0]
        inverse = None
        if isinstance(feature, Vertex) and isinstance(feature.carrier, RationalPoint):
            if not any(row[0] for row in times(carrier.form, feature.carrier.basis)):
                rows = doubles(_inverse(carrier.form))
                inverse = tuple((x, y, z) for x, y, z in rows)
        return _Side(face, form, None, (p, q, r, w), inverse)
    if len(kernel) == 1:
        x, y, z, _ = doubles((kernel[0],))[0]
        return _Side(face, form, Flat(face, (x, y, z), coprime(kernel[0][:3])), None)
    # none: no lines in a convex surface; several: two planes in one form
    return _Side(face, form, Flat(face, None, None) if kernel else None, None)
