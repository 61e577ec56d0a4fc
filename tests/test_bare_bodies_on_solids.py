"""Points and edges on their own against solids, where times are known in closed form."""

from __future__ import annotations

from fractions import Fraction

import pytest

import firstcontact as fc

ON_CIRCLE = [
    (Fraction(3, 5), Fraction(4, 5)),
    (Fraction(-5, 13), Fraction(12, 13)),
    (Fraction(8, 17), Fraction(-15, 17)),
]
HEIGHTS = [Fraction(1, 8), Fraction(1, 2), Fraction(5, 8)]
SOLIDS = {
    "ball": (fc.sphere(1).translated((0, 0, 0)), None),
    "ellipsoid": (fc.ellipsoid((1, 2, "3/2")), None),
    "cylinder": (fc.cylinder(1, 2), lambda z: 1),
    "frustum": (fc.frustum(2, 1, 1), lambda z: 2 - z),
    "cone": (fc.cone(1, 1), lambda z: 1 - z),
}
"""With the radius at a height, of those about z."""


def places(name):
    """Points of the surface, and outward directions in which nothing of the solid lies."""
    radius = SOLIDS[name][1]
    for (c, s), z in zip(ON_CIRCLE, HEIGHTS, strict=True):
        if radius is not None:
            yield (c * radius(z), s * radius(z), z), (c, s, 0)
        elif name == "ball":
            w, u = ON_CIRCLE[0]
            yield (c * u, s * u, w), (c * u, s * u, w)
        else:
            w, u = ON_CIRCLE[0]
            yield (c * u, 2 * s * u, Fraction(3, 2) * w), (c * u, s * u, w)


def along(p, d, by):
    return [x + by * y for x, y in zip(p, d, strict=True)]


def bare(p, d, kind):
    """A point at p, or an edge from it that points outwards, head-on."""
    if kind == "point":
        return fc.Polyhedron([p], faces=[])
    return fc.Polyhedron([p, along(p, d, Fraction(1, 2))], faces=[], edges=[(0, 1)])


CASES = [(name, p, d, kind) for name in SOLIDS for p, d in places(name) for kind in ("point", "edge")]


@pytest.mark.parametrize("name, place, outward, kind", CASES)
@pytest.mark.parametrize("way, time", [(4, "1/3"), (3, 1), ("1/1000", "1/3"), ("1/1000000", 1)], ids=str)
def test_a_point_or_an_edge_lands_head_on(name, place, outward, kind, way, time):
    """After the given part of a way that may be long or short, the last instant included."""
    solid, way, time = SOLIDS[name][0], Fraction(way), Fraction(time)
    body = bare(along(place, outward, way * time), outward, kind)
    hit = fc.first_contact(body.moving(fc.Translation(along((0, 0, 0), outward, -way))), solid)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(float(time), abs=1e-12)
    other = fc.first_contact(solid.moving(fc.Translation(along((0, 0, 0), outward, way))), body)
    assert other.status is fc.Status.CONTACT and other.time == pytest.approx(float(time), abs=1e-12)


@pytest.mark.parametrize("direction", ON_CIRCLE)
@pytest.mark.parametrize("solid, height, reach", [
    (fc.sphere(1), 0, 1), (fc.cylinder(1, 2), Fraction(1, 2), 1), (fc.frustum(2, 1, 1), Fraction(1, 4), Fraction(7, 4)),
])  # fmt: skip
@pytest.mark.parametrize("time", ["1/3", 1])
def test_an_edge_comes_sideways(solid, height, reach, direction, time):
    (c, s), time = direction, Fraction(time)
    away = reach + 6 * time
    ends = [(away * c - k * s, away * s + k * c, height) for k in (-1, 1)]
    edge = fc.Polyhedron(ends, faces=[], edges=[(0, 1)])
    hit = fc.first_contact(edge.moving(fc.Translation((-6 * c, -6 * s, 0))), solid)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(float(time), abs=1e-12)


def test_the_named_scenes():
    edge = fc.Polyhedron([(5, 0, 0), (7, 0, 0)], faces=[], edges=[(0, 1)])
    assert fc.first_contact(edge.moving(fc.Translation((-10, 0, 0))), fc.sphere(1)).time == 0.4
    for height in HEIGHTS:
        point = fc.Polyhedron([(5, 0, height)], faces=[]).moving(fc.Translation((-10, 0, 0)))
        assert fc.first_contact(point, fc.frustum(2, 1, 1)).time == pytest.approx(float(3 + height) / 10, abs=1e-12)


QUARTER = fc.Screw((0, 0, 1), degrees=90, advance="1/4")
POINT = fc.Polyhedron([(2, 0, 0)], faces=[])
EDGE = fc.Polyhedron([(1, 0, 0), (3, 0, 0)], faces=[], edges=[(0, 1)])
TRIANGLE = fc.Polyhedron([(2, 0, 0), (3, -1, "1/2"), (3, -1, "-1/2")], [(0, 1, 2)])
CUBE = fc.box((2, 2, 2)).translated((-1, 2, 0))


@pytest.mark.parametrize("body, solid, kind", [
    (POINT, fc.cylinder(1, 2).translated((-1, 2, 0)), "point"),
    (POINT, fc.sphere(1).translated((-1, 2, "1/4")), "point"),
    (POINT, CUBE - fc.cylinder("1/4", 4).translated(("-3/2", 2, 0)), "point"),
    (TRIANGLE, fc.cylinder(1, 2).translated((-1, 2, 0)), "point"),
    (EDGE, CUBE, "segment"),
])  # fmt: skip
def test_a_landing_in_the_last_instant_of_a_screw(body, solid, kind):
    """A quarter turn takes (2, 0, 0) to (0, 2, 1/4), which is on all of these."""
    hit = fc.first_contact(body.moving(QUARTER), solid)
    assert hit.status is fc.Status.CONTACT and hit.time == 1 and hit.contact_set == kind
    assert hit.time_interval[0] > 1 - 1e-12 and hit.point[[0, 2]] == pytest.approx([0, 0.25], abs=1e-9)
    assert fc.first_contact(solid, body.moving(QUARTER)).time == 1
    beside = solid.translated(("-1/1000", 0, 0))
    assert fc.first_contact(body.moving(QUARTER), beside).status is fc.Status.FREE
    with pytest.raises(fc.UnsupportedPair):
        fc.first_contact(body.moving(QUARTER), solid, exact=True)
