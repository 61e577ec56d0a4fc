"""Solids as they are drawn: triangles, smooth normals, edges, touched elements."""

import math

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.errors import InputError
from firstcontact.result import Element, FirstContact, Status
from firstcontact.view.drawing import contact_curve, drawings
from firstcontact.view.pair import pairs_of
from view import scenes


def drawn(body, other=None):
    still = FirstContact(Status.FREE, free_until=1.0, a=body, b=scenes.cube("box") if other is None else other)
    (pair,) = pairs_of([still])
    return drawings(pair)[0]


def element(kind, index):
    return Element(kind, "a", index, "label")


def test_normals_are_those_of_the_surfaces():
    ball = drawn(fc.sphere(2).translated((1, 0, 0)))
    assert np.allclose(ball.normals, (ball.vertices - [1, 0, 0]) / 2, atol=1e-12)
    hole = drawn(fc.box((4, 4, 1)) - fc.cylinder(1, 2))
    used = np.unique(hole.triangles[hole.triangle_face == 6])
    p = hole.vertices[used]
    assert np.allclose(np.hypot(p[:, 0], p[:, 1]), 1)
    assert np.allclose(hole.normals[used], -p * [1, 1, 0], atol=1e-12)  # out of the solid, into the hole


def test_triangles_look_the_way_of_their_normals():
    drawing = drawn(scenes.plate())
    a, b, c = (drawing.vertices[drawing.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    large = np.linalg.norm(across, axis=1) > 1e-6
    for k in range(3):
        along = np.sum(across * drawing.normals[drawing.triangles[:, k]], axis=1)
        assert np.all(along[large] > 0)


def test_corners_are_shared_within_a_face_and_split_between_faces():
    pin = drawn(fc.cylinder(1, 2))
    for face in range(3):
        used = pin.triangles[pin.triangle_face == face]
        others = pin.triangles[pin.triangle_face != face]
        assert not set(used.ravel()) & set(others.ravel())
    assert len(np.unique(pin.triangles)) < 1.5 * len(pin.triangles)  # three where none is shared


def test_the_tip_of_a_cone_has_a_normal_for_every_triangle():
    tip = drawn(fc.cone(1, 2))
    at_tip = np.flatnonzero(np.all(np.abs(tip.vertices - [0, 0, 2]) < 1e-9, axis=1))
    assert len(at_tip) > 10
    assert np.allclose(np.linalg.norm(tip.normals[at_tip], axis=1), 1) and np.all(tip.normals[at_tip, 2] < 0.6)


def test_triangles_stay_within_a_four_hundredth():
    body = scenes.plug()
    drawing, (lo, hi) = drawn(body), body.bounds()
    middles = drawing.vertices[drawing.triangles[drawing.triangle_face == 0]].mean(axis=1)
    off = np.abs(np.hypot(middles[:, 0], middles[:, 1]) - 2 / 3 * middles[:, 2])
    assert off.max() < np.linalg.norm(hi - lo) / 400


def test_lines_run_along_the_edges():
    drawing = drawn(scenes.plate())
    ends = drawing.vertices[drawing.lines]
    x, y, z = np.moveaxis(ends.reshape(-1, 3), 1, 0)
    on_hole = np.isclose(np.hypot(x, y), 1) & np.isclose(np.abs(z), 0.5)
    on_box = np.sum([np.isclose(np.abs(x), 2), np.isclose(np.abs(y), 2), np.isclose(np.abs(z), 0.5)], axis=0) >= 2
    assert np.all(on_hole | on_box) and on_hole.sum() > 200
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    assert length == pytest.approx(8 * 4 + 4 * 1 + 2 * 2 * math.pi, rel=1e-3)


def test_edges_of_degree_four_are_drawn():
    drawing = drawn(fc.cylinder(1, 4) - fc.cylinder("1/2", 4).rotated((1, 0, 0), degrees=90))
    index = next(e.index for e in drawing.body.edges if type(e.carrier).__name__ == "QuarticCurve")
    p = drawing.corners(element("edge", index))
    assert len(p) > 100
    assert np.allclose(np.hypot(p[:, 0], p[:, 1]), 1) and np.allclose(np.hypot(p[:, 0], p[:, 2]), 0.5)


def test_elements_of_a_solid():
    plate = scenes.plate()
    drawing = drawn(plate)
    rim = drawing.corners(scenes.element("a", plate, "edge", "plate.hole.rim.top"))
    assert np.allclose(np.hypot(rim[:, 0], rim[:, 1]), 1) and np.allclose(rim[:, 2], 0.5)
    top = scenes.element("a", plate, "face", "plate.slab.z+")
    corners = drawing.corners(top).reshape(-1, 3, 3)
    assert np.all(corners[..., 2] == 0.5)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(16 - math.pi, rel=2e-3)
    outline = drawing.outline(top.index).reshape(-1, 2, 3)
    length = np.linalg.norm(outline[:, 0] - outline[:, 1], axis=1).sum()
    assert length == pytest.approx(16 + 2 * math.pi, rel=1e-3)
    tip = drawn(fc.cone(1, 2))
    assert np.array_equal(tip.corners(element("apex", 0)), [[0, 0, 2]])
    assert np.array_equal(tip.corners(element("vertex", 0)), [[0, 0, 2]])


def test_of_a_body_without_end_the_part_near_the_other_is_drawn():
    far = scenes.plug().translated((50, 0, 0))
    floor = fc.half_space((0, 0, 1), 0)
    for body in (floor, floor.moving(fc.Translation((0, 0, 1)))):
        drawing = drawn(body, far)
        lo, hi = drawing.vertices.min(axis=0), drawing.vertices.max(axis=0)
        assert np.all(drawing.vertices[:, 2] == 0)
        assert drawing.corners(element("face", 0)).shape == drawing.outline(0).shape == (0, 3)
        assert np.all(lo[:2] < [47, -3]) and np.all(hi[:2] > [53, 3]) and np.linalg.norm(hi - lo) < 30
    wedge = drawn(floor & fc.half_space((1, 0, 0), 50), far)
    assert len(wedge.lines) == 1 and np.allclose(wedge.vertices[wedge.lines[0]][:, [0, 2]], [50, 0])
    with pytest.raises(InputError, match="both bodies are unbounded"):
        drawn(floor, fc.half_space((0, 0, -1), -3))


def test_contact_curves():
    (pair,) = pairs_of([scenes.plugged()])
    assert np.array_equal(contact_curve(pair), pair.first.contact_set.points)
    for contact_set, count in ((None, 0), ("point", 0), (scenes.SharedCurve("point", [[0, 0, 0]]), 0),
                               (scenes.SharedCurve("segment", [[0, 0, 0], [1, 0, 0]]), 2),
                               (scenes.SharedCurve("patch", [[0, 0, 0], [1, 0, 0], [0, 1, 0]]), 4)):  # fmt: skip
        (pair,) = pairs_of([FirstContact(Status.CONTACT, contact_set=contact_set, a=pair.a, b=pair.b)])
        assert len(contact_curve(pair)) == count
