"""No edge of degree 4 is missing: extrema of x and crossings of other surfaces lie on traced edges."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.csg import And, Leaf, Not
from firstcontact.composite.algorithm import Search
from firstcontact.composite.moving_pair import Pair
from firstcontact.composite.square_subproblems import _box_of
from firstcontact.composite.traced_edges import _checked, is_sharp, untraced
from firstcontact.motion.polynomial import relative_pieces

NARROW = fc.cylinder("1/2", 6).rotated((1, 0, 0), degrees=90)


def dimple():
    """An oval of degree 4 where an ellipsoid dips 1e-4 into a cylinder."""
    ball = fc.ellipsoid((Fraction(1, 2), Fraction(1, 3), Fraction(1, 4)))
    return fc.cylinder(1, 6) - ball.translated((Fraction(3, 2) - Fraction(1, 10**4), 0, 0))


@pytest.mark.parametrize(
    ("body", "count"),
    [
        (fc.cylinder(1, 6) - NARROW, 4),  # two ovals, two extrema of x each
        (fc.cylinder(1, 6) | NARROW.translated((0, 0, "27/10")), 8),  # two arcs: an extremum or two, and the ends
        (dimple(), 2),
    ],
    ids=["drilled", "tee", "dimple"],
)
def test_all_marked_points_are_on_traced_edges(body, count):
    points = list(_checked(body, _box_of(body)))
    assert len(points) >= count and all(near for _, near in points)
    assert untraced(body, _box_of(body)) == []
    for x, _ in points:
        point = (*(fmpq(*float(c).as_integer_ratio()) for c in x), fmpq(1))
        values = [abs(float(s.value(point))) for s in body.surfaces]
        slopes = [np.linalg.norm([float(c) for c in s.gradient(point)]) for s in body.surfaces]
        assert sum(v < 1e-14 * slope for v, slope in zip(values, slopes, strict=True)) >= 2


def test_a_missing_edge_is_noticed():
    body = dimple()
    (edge,) = [e for e in body.edges if e.frame.shape[1] == 3 and len(e.frame) > 4]
    features = body._features()
    blind = body._with(_search={"features": replace(features, edges=tuple(e for e in body.edges if e is not edge))})
    (first, *_) = untraced(blind, _box_of(body))
    assert np.linalg.norm(edge.frame - first, axis=1).min() < 0.02
    ball = fc.sphere(1).translated((5, 0, 0))
    (piece,) = relative_pieces(blind, ball.moving(fc.Translation((-4, 0, 0))), fmpq(0), fmpq(1))
    with pytest.raises(fc.UnsupportedPair, match="not traced"):
        Search(Pair(blind, ball, piece))


def test_sharp_means_that_both_surfaces_matter():
    both, first, cut = And(Leaf(0), Leaf(1)), Leaf(0), And(And(Leaf(0), Leaf(1)), Not(Leaf(2)))
    assert is_sharp(both, [0, 0], 0, 1) and not is_sharp(first, [0, 0], 0, 1)
    assert is_sharp(cut, [0, 0, 0], 0, 1) and not is_sharp(cut, [0, 0, -1], 0, 1)
