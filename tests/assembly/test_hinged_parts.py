"""Parts of CAD shapes that share a sharp edge, about which one of them turns: the first new contact is decided."""

import numpy as np
import pytest

pytest.importorskip("OCP")

from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon  # noqa: E402
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism  # noqa: E402
from OCP.gp import gp_Pnt, gp_Vec  # noqa: E402

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402


def prism(corners, lo, hi):
    """Over a polygon in x and z, from y = lo to hi."""
    outline = BRepBuilderAPI_MakePolygon()
    for x, z in corners:
        outline.Add(gp_Pnt(x, lo, z))
    outline.Close()
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(outline.Wire()).Face(), gp_Vec(0, hi - lo, 0)).Shape()


def turned(lid, frame, degrees):
    """Of a lid that turns about y, from z to x."""
    a, b = fc.from_shape(lid, name="lid", unit="mm"), fc.from_shape(frame, name="frame", unit="mm")
    return fc.first_new_contact(a.moving(fc.Rotation((0, 1, 0), degrees=degrees)), b)


FRAME = shapes.box((2, 2, 2), (0, 0, -2))
LID = shapes.box((0.5, 2, 2), (-0.5, 0, 0))


@pytest.mark.thorough
def test_a_box_shuts_on_the_box_that_it_is_hinged_to():
    hit = turned(LID, FRAME, 120)
    assert hit.status is fc.Status.CONTACT and hit.allowed == "touching at the start"
    lo, hi = hit.time_interval
    assert lo <= 0.75 <= hi and {hit.element_a.body, hit.element_b.body} == {"lid", "frame"}
    assert hit.unit == "mm" and hit.model_deviation == 0.0
    assert turned(LID, FRAME, 89).status is fc.Status.FREE


WEDGES = [  # in x and z: the sides of the lid and of the frame, from z to x
    [(-2, 1), (-1, 2), (2, -1), (1, -2)],
    [(-1, 3), (1, 4), (3, 1), (2, -3)],
    [(0, 2), (1, 1), (1, -3), (-1, -2)],
]


@pytest.mark.share(4)
@pytest.mark.parametrize("sides", WEDGES)
def test_wedges_meet_when_their_sides_do(sides):
    """Of wedges with one edge in common, by the angles of their sides."""
    lid, frame = (prism([(0, 0), *pair], 0, 2) for pair in (sides[:2], sides[2:]))
    hit = turned(lid, frame, 200)
    assert hit.status is fc.Status.CONTACT
    end, start = (np.degrees(np.arctan2(*sides[k])) for k in (1, 2))
    assert hit.time * 200 == pytest.approx(start - end, abs=1e-9)


@pytest.mark.thorough
def test_parts_of_two_solids_are_looked_at_piece_by_piece(tmp_path):
    """A lid with a handle that is a solid of its own, which meets a post on the frame before the lid shuts."""
    both = shapes.write(tmp_path / "lid.stp", LID, shapes.box((0.2, 0.2, 0.2), (0, 0.9, 1.5)))
    post = shapes.write(tmp_path / "frame.stp", FRAME, shapes.box((0.2, 0.2, 1), (1.5, 0.9, 0)))
    lid, frame = fc.load_step(both).body, fc.load_step(post).body
    swing = fc.Rotation((0, 1, 0), degrees=120)
    hit = fc.first_new_contact(lid.moving(swing), frame)
    assert len(lid.pieces) == len(frame.pieces) == 2 and hit.status is fc.Status.CONTACT
    each = [
        fc.first_contact(p.body.moving(swing), q.body) for p in lid.pieces for q in frame.pieces
        if fc.first_contact(p.body, q.body).status is fc.Status.FREE
    ]  # fmt: skip
    assert hit.time == min(x.time for x in each if x.time is not None) < 0.75


END, REACH = 0.75, 5.0
"""Of an arm with a round end: its radius, and how far its middle is from the hinge."""


def arm():
    """Along x, about a bore of radius 1 along z, between z = 0 and 1."""
    made = shapes.fuse(shapes.cylinder(2, 1), shapes.box((REACH, 2 * END, 1), (0, -END, 0)))
    made = shapes.fuse(made, shapes.cylinder(END, 1, (REACH, 0, 0)))
    return shapes.cut(made, shapes.cylinder(1, 3, (0, 0, -1)))


def stand(pin, place, post):
    """A plate with a pin in the bore and a post, both along z."""
    made = shapes.fuse(shapes.box((14, 14, 1), (-7, -7, -1.5)), shapes.cylinder(pin, 3, (0, 0, -1)))
    return shapes.fuse(made, shapes.cylinder(post, 3, (*place, -1)))


FAR = 5.6
CURVED = [  # the pin; how far the post is from the hinge; the angle between it and the arm at which the two meet
    (1.0, 3.0, lambda post: np.arcsin((END + post) / 3.0)),  # on the arm's flat side
    (0.9, FAR, lambda post: np.arccos((REACH**2 + FAR**2 - (END + post) ** 2) / (2 * REACH * FAR))),  # its round end
]


@pytest.mark.thorough
@pytest.mark.parametrize(("pin", "far", "between"), CURVED, ids=["side", "end"])
def test_an_arm_with_a_round_end_turns_about_its_pin_onto_a_post(pin, far, between):
    """By the sides of the triangle of hinge, end and post; a pin that fits touches all the way, and is let pass."""
    post, at = 0.5, np.radians(130)
    lid = fc.from_shape(arm(), name="arm", unit="mm")
    frame_shape = stand(pin, (far * np.cos(at), far * np.sin(at)), post)
    frame = fc.from_shape(frame_shape, name="stand", unit="mm")
    assert all(isinstance(p.body, fc.CompositeQuadric) for p in (*lid.pieces, *frame.pieces))
    moving = lid.moving(fc.Rotation((0, 0, 1), degrees=180))
    hit = fc.first_new_contact(moving, frame) if pin == 1.0 else fc.first_contact(moving, frame)
    assert hit.status is fc.Status.CONTACT and hit.allowed == ("touching at the start" if pin == 1.0 else None)
    assert hit.time * np.pi == pytest.approx(at - between(post), abs=1e-11)
    lo, hi = hit.time_interval
    assert lo - 1e-15 <= (at - between(post)) / np.pi <= hi + 1e-15
    assert hit.model_deviation < 1e-12 and {hit.element_a.kind, hit.element_b.kind} <= {"face", "edge"}
