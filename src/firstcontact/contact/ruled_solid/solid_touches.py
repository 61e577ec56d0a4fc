"""What meets where a ruled piece touches a solid of planes and quadrics, from exact parameters; how it lies there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from flint import fmpq, fmpz_mpoly

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import borders, outcomes
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.ruled_solid.solid_conditions import SolidConditions
from firstcontact.contact.signs.shared_points import FieldPoint, vanishes
from firstcontact.contact.signs.sheets import Sheet, samples, sheets
from firstcontact.contact.signs.times import Times, between_borders, roots_of
from firstcontact.contact.signs.touches import (
    RuledTouch,
    Ruling,
    curve_slopes,
    cut_slopes,
    element_kind,
    end_met,
    in_double,
    shown_parameter,
)
from firstcontact.exact.fields import number_field
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import sign
from firstcontact.exact.polynomials.trivariate import at, exchanged, univariate

NEAR = 1e-9
"""Of the model's size: a vertex that near to a point is that point."""
STEPS = 257
"""Points of an edge of degree 4 of which the nearest one counts."""


def _places(now: SolidConditions, sheet: Sheet, t: fmpq) -> Iterator[tuple[fmpq, fmpq]]:
    """One (u, s) in every cell between the curves on which forms, or the trimming, vanish at the time."""
    for x in between_borders(sheet, t):
        at_x = [univariate(at(exchanged(f) if sheet.exchanged else f, 0, x), 1) for f in now.polynomials]
        for y in samples(roots_of(at_x, sheet.second), sheet.second):
            yield (y, x) if sheet.exchanged else (x, y)


def _value_sign(f: fmpz_mpoly, u: fmpq, s: fmpq, t: fmpq) -> int:
    return sign(univariate(at(at(at(f, 2, t), 1, s), 0, u), 0)[0])


def solid_touch(contact: FieldPoint, joined: frozenset[str]) -> RuledTouch:
    """A shared point in the solid's frame; of the solid's element the feature itself stands in place of its number.

    joined: borders of the piece that are none of the body.
    """
    c = contact.conditions
    assert isinstance(c, SolidConditions)
    ends = contact.ranges[0]
    across = None if ends is None else end_met(contact, [contact.u - end for end in ends], ("u0", "u1"), joined)
    along = end_met(contact, [contact.v, contact.v - 1], ("s0", "s1"), joined)
    own = element_kind(across, along)
    if along is not None and c.sides[along].is_constant:  # a tip
        own = "vertex", along
    cut = next((k for k, f in enumerate(c.kept) if _sign_at(contact, f) == 0), None)
    if cut is not None and own == ("face", 0):
        own = "edge", cut
    ruling = Ruling(c.sides, "u", contact, True)
    point = np.array([in_double(x) for x in ruling.at(contact.v)])
    signs = [_sign_at(contact, f) for f in c.forms]
    feature = feature_at(c.solid, signs, point)
    kind = "" if feature is None else type(feature).__name__.lower()
    tangents = _tangents(contact, c, own, ruling)
    normal = None if feature is None else _normal(c.solid, feature, signs, point, tangents)
    place = shown_parameter(contact.u, contact.inverse[0]), in_double(contact.v), np.nan, None
    return RuledTouch(point, (own, (kind, feature)), place, normal, point[None])  # type: ignore[arg-type]


def _sign_at(contact: FieldPoint, f: fmpz_mpoly) -> int:
    x = contact.value(f)
    return 0 if vanishes(contact, x, sum(abs(int(c)) for c in f.coeffs())) else number_field.sign(x)


def feature_at(solid: CompositeQuadric, signs: Sequence[int], point: np.ndarray) -> Face | Edge | Vertex | None:
    """The lowest feature on surfaces that vanish at the point and near it; None off the boundary."""
    on = {k for k, own in enumerate(signs) if own == 0}
    size = NEAR * _length(solid, point)
    vertices = [v for v in solid.vertices if np.abs(np.subtract(v.position, point)).max() < size + v.error]
    if vertices:
        return vertices[0]
    edges = [e for e in solid.edges if on >= set(e.surfaces)]
    if edges:
        gaps = [_distance(edge, point) for edge in edges]
        if min(gaps) < np.inf:
            return edges[int(np.argmin(gaps))]
    for face in solid.faces:
        if face.surfaces[0] in on and borders(solid.tree, signs, face.surfaces[0], face.orientation):
            return face
    return None


def _distance(edge: Edge, point: np.ndarray) -> float:
    """From a point of the edge's carrier: zero on the edge, infinite beyond its ends; of degree 4 measured roughly."""
    if edge.frame.shape[1] == 3 and len(edge.frame) != 4:
        found = [edge.points(np.linspace(piece.lo, piece.hi, STEPS)) for piece in edge.pieces]
        return float(min(np.linalg.norm(x - point, axis=1).min() for x in found))
    way = np.linalg.lstsq(edge.frame, np.append(point, 1.0), rcond=None)[0]
    if edge.frame.shape[1] == 2:
        t, turn = way[0] / way[1], np.inf
    else:
        t, turn = float(np.arctan2(way[2], way[1])), 2 * np.pi
    for piece in edge.pieces:
        pad = NEAR * (1.0 + abs(t))
        later = t if turn == np.inf else piece.lo - pad + (t - piece.lo + pad) % turn
        if piece.lo - pad <= later <= piece.hi + pad:
            return 0.0
    return float(np.inf)


def _tangents(contact: FieldPoint, c: SolidConditions, own: tuple[str, int], ruling: Ruling) -> list[np.ndarray]:
    """Unit tangents of the piece's element, in the solid's frame."""
    s = in_double(contact.v)
    way = np.array([in_double(w) for w in ruling.way])
    first, second = (curve_slopes(curve, in_double(contact.u), in_double(contact.t))[0] for curve in c.sides)
    along = (1 - s) * first + s * second
    found = {"face": [way, along], "directrix": [along], "end_ruling": [way]}.get(own[0], [])
    if own[0] == "edge":
        by_u, by_s = cut_slopes(c.trims[own[1]], in_double(contact.u), s)
        found = [along * by_s - way * by_u]
    lengths = [float(np.linalg.norm(x)) for x in found]
    return [x / n for x, n in zip(found, lengths, strict=True) if np.isfinite(n) and n > 0]


def _normal(
    solid: CompositeQuadric, feature: Face | Edge | Vertex, signs: Sequence[int], point: np.ndarray,
    tangents: Sequence[np.ndarray],
) -> np.ndarray | None:
    """Unit, out of the solid; None where the elements span no plane."""
    faces = _faces(solid, feature, signs)
    outward = [n for n in (f.orientation * solid.gradient(f.surfaces[0], point) for f in faces) if np.any(n)]
    if not outward:
        return None
    if isinstance(feature, Face):
        return outward[0]
    if len(tangents) == 2:
        n = np.cross(tangents[0], tangents[1])
    elif len(tangents) == 1 and isinstance(feature, Edge) and len(outward) > 1:
        n = np.cross(tangents[0], np.cross(outward[0], outward[1]))
    else:
        return None
    side = float(n @ np.sum(outward, axis=0))
    length = float(np.linalg.norm(n))
    return None if length < NEAR or side == 0 else n * np.sign(side) / length


def _faces(solid: CompositeQuadric, feature: Face | Edge | Vertex, signs: Sequence[int]) -> Iterator[Face]:
    if isinstance(feature, Face):
        yield feature
    elif isinstance(feature, Edge):
        yield from (solid.faces[k] for k in feature.faces)
    else:
        yield from (f for f in solid.faces if signs[f.surfaces[0]] == 0)


def _length(solid: CompositeQuadric, point: np.ndarray) -> float:
    """Of the solid and its place; an unbounded one has no size of its own."""
    largest = float(np.abs(solid.bounds()).max())
    return float(np.abs(point).max()) + (largest if largest < np.inf else 1.0)


# -- at the start ---------------------------------------------------------------------------------------------


def lies(c: SolidConditions, t: fmpq) -> str:
    """How the piece, which shares points with the solid at the time, lies: "touching", "overlapping", "containment"."""
    if not any(outcomes(c.solid.tree, signs) == {True} for signs in _cells(c, t)):
        return "touching"
    crossing = Times(c.only("boundary"), (t, t)).at(AlgebraicRoot.of(t))
    return "overlapping" if crossing else "containment"


def _cells(c: SolidConditions, t: fmpq) -> Iterator[list[int]]:
    """The signs of the forms in all cells of the piece at the time."""
    for chart in c.charts.values():
        now = chart.at(t)
        for sheet in sheets(now):
            for x, y in _places(now, sheet, t):
                if all(_value_sign(f, x, y, t) >= 0 for f in now.kept):
                    yield [_value_sign(f, x, y, t) for f in now.forms]
