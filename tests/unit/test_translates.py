"""Features of translates of models beside those that are worked out anew."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.solid.carriers import AlgebraicPoint, EnclosedPoint, Point, QuarticCurve
from firstcontact.contact.reduce import as_model


def saddle_cut():
    """Vertices in a quadratic field, and edges of degree 4."""
    return fc.sphere(2) & fc.paraboloid(1, 3).translated((0, 0, "-3/2")) & fc.half_space((1, 2, 0), "1/2")


SOLIDS = {
    "box": lambda: fc.box((1, 2, "3/2"), name="block"),
    "drilled": lambda: (fc.box((4, 4, 1)) - fc.cylinder(1, 2).named("hole")).named("plate"),
    "countersunk": lambda: fc.box((6, 6, 2)) - fc.cylinder(1, 4) - fc.cone(2, 2).rotated((1, 0, 0), degrees=180),
    "crossing cylinders": lambda: fc.cylinder(1, 6) | fc.cylinder("3/4", 6).rotated((1, 0, 0), degrees=90),
    "three of them": lambda: fc.cylinder(1, 6) & fc.cylinder("3/4", 6).rotated((1, 0, 0), degrees=90)
    & fc.cylinder("4/5", 6).rotated((0, 1, 0), degrees=90).translated((0, "1/10", 0)),
    "cone": lambda: fc.cone("3/4", 2),
    "capsule": lambda: fc.cylinder("1/2", 1) | fc.sphere("1/2").translated((0, 0, "1/2")),
    "saddle": saddle_cut,
    "half-space and ball": lambda: fc.half_space((0, 0, 1), 0) | fc.sphere(1),
    "hyperboloid": lambda: fc.hyperboloid((1, 1, 1), 3) & fc.half_space((0, 0, 1), 2) & fc.half_space((0, 1, -1), 2),
}
WAYS = [(1, -2, 3), (Fraction(1, 3), 1e-9, 0), (300, Fraction(2, 7), -5)]


@pytest.mark.share(16)
@pytest.mark.parametrize("way", WAYS, ids=str)
@pytest.mark.parametrize("name", SOLIDS)
def test_features_are_those_worked_out_anew(name, way):
    moved = SOLIDS[name]().translated(way)
    assert moved.translate_of is not None
    told, anew = moved._of_origin(), moved._derived()
    assert told is not None
    assert [(f.name, f.surfaces, f.orientation, f.carrier) for f in told.faces] == [
        (f.name, f.surfaces, f.orientation, f.carrier) for f in anew.faces]  # fmt: skip
    for mine, other in zip((told.edges, told.seams), (anew.edges, anew.seams), strict=True):
        assert [said(e) for e in mine] == [said(e) for e in other]
        for edge in mine:
            check_points(moved, edge)
    assert [(v.name, v.surfaces, v.is_apex, type(v.carrier)) for v in told.vertices] == [
        (v.name, v.surfaces, v.is_apex, type(v.carrier)) for v in anew.vertices]  # fmt: skip
    left = list(anew.vertices)  # of several on the same surfaces, which is first depends on the place
    for mine in told.vertices:
        other = min(left, key=lambda v: np.abs(np.subtract(mine.position, v.position)).max())
        left.remove(other)
        assert mine.surfaces == other.surfaces
        exact = not isinstance(mine.carrier, EnclosedPoint)
        far = np.abs(np.subtract(mine.position, other.position)).max()
        assert far <= (mine.error + other.error if exact else 1e-14 * max(1.0, *map(abs, mine.position)))
        if isinstance(mine.carrier, Point):
            assert mine.carrier == other.carrier


def said(edge):
    return edge.name, edge.surfaces, edge.convexity, edge.faces, type(edge.carrier), len(edge.pieces)


def check_points(moved, edge):
    """They lie on the surfaces that meet there, and pieces end in their vertices."""
    for piece in edge.pieces:
        lo, hi = max(piece.lo, -50.0), min(piece.hi, 50.0)
        points = edge.points(np.linspace(lo, hi, 7))
        size = np.abs(points).max() + 1.0
        for k in edge.surfaces:
            x = np.column_stack([points, np.ones(len(points))])
            values, slopes = np.einsum("ni,ij,nj->n", x, moved.forms[k], x), 2.0 * x @ moved.forms[k][:, :3]
            off = np.abs(values) / np.maximum(np.linalg.norm(slopes, axis=1), 1e-3 * np.abs(moved.forms[k]).max())
            assert off.max() < 1e-12 * size, (edge.name, k)
        for number, at in ((piece.start, piece.lo), (piece.end, piece.hi)):
            if number is not None:
                there = edge.points([at])[0] - moved.vertices[number].position
                assert np.abs(there).max() < 1e-9 * size


@pytest.mark.thorough
def test_points_of_fields_and_curves_of_degree_4_are_among_them():
    kinds = {type(x.carrier) for make in SOLIDS.values() for x in (*make().vertices, *make().edges)}
    assert {Point, AlgebraicPoint, EnclosedPoint, QuarticCurve} <= kinds


def test_what_came_from_far_away_is_worked_out_anew_and_a_new_name_too():
    far = (fc.box((1, 2, 3)) - fc.cylinder("1/3", 4)).translated((10**9, Fraction(1, 3), 0))
    near = far.translated((-(10**9), Fraction(-1, 3), 0))
    assert near._of_origin() is not None  # the first of them all stands here
    anew = far.named("far")
    assert anew.translate_of is None
    back = anew.translated((-(10**9), Fraction(-1, 3), 0))
    assert back._of_origin() is None
    assert [v.position for v in back.vertices] == [v.position for v in near.vertices]
    assert back.vertices[0].name != near.vertices[0].name


def test_models_of_polyhedra_keep_their_numbers_to_themselves():
    """A translate of one has numbers of its own: with those of the polyhedron, bodies that are apart met at once."""
    model = as_model(fc.examples.box((1, 2, 3)))
    assert max(edge.index for edge in model.edges) > 11  # diagonals count
    assert model.translated((1, 0, 0)).translate_of is None
    assert [edge.index for edge in model.translated((1, 0, 0)).edges] == list(range(12))


def test_turned_and_scaled_copies_are_no_translates():
    body = fc.box((1, 2, 3))
    for other in (body.rotated((0, 0, 1), degrees=90), body.transformed(np.diag([2.0, 2.0, 2.0, 1.0]))):
        assert other.translate_of is None
    assert body.translated((1, 0, 0)).translated((0, 1, 0)).translate_of == (body, (1, 1, 0))
