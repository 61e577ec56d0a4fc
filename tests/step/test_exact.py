"""Solids of planes, cylinders, cones and spheres as bodies with these very surfaces, against OpenCASCADE."""

import numpy as np
import pytest

pytest.importorskip("OCP")

import sys  # noqa: E402
from pathlib import Path  # noqa: E402

from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere  # noqa: E402
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt  # noqa: E402

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402
from firstcontact.search.convex import advance  # noqa: E402
from firstcontact.step import bodies, cells, rough  # noqa: E402
from firstcontact.step.reader import Shape  # noqa: E402
from firstcontact.step.solids import StepSolid  # noqa: E402

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))
import step_random  # noqa: E402


def plate(nx=2, ny=2):
    """With countersunk holes."""
    made = shapes.box((10 * nx, 10 * ny, 5))
    for i in range(nx):
        for j in range(ny):
            at = (5 + 10 * i, 5 + 10 * j)
            made = shapes.cut(made, shapes.cylinder(1, 9, (*at, -2)))
            made = shapes.cut(made, shapes.cone(0.5, 4.5, 4, (*at, 1.5)))
    return made


def pin():
    """With a tip at the origin, of a radius that no double is half of its height."""
    return shapes.fuse(shapes.cone(0, 0.6, 1.2), shapes.cylinder(0.6, 6, (0, 0, 1.2)))


def rounded():
    """A box with fillets along three edges and a ball where they meet."""
    return shapes.filleted(shapes.box((4, 3, 2)), 0.4, shapes.ends_at((4, 3, 2)))


def drilled():
    """A hole whose end is a cone that all but goes through."""
    made = shapes.cut(shapes.box((6, 5, 4)), shapes.cylinder(1, 9, (3, 2.5, 1)))
    return shapes.moved(shapes.cut(made, shapes.cone(0, 1, 0.95, (3, 2.5, 0.05))), (1, 1, 1), ((1, 2, 3), 0.7))


def slotted():
    """A wall of a thousandth between a slot and the side."""
    made = shapes.cut(shapes.box((4, 3, 2)), shapes.box((3, 1, 3), (0.5, 1.999, -0.5)))
    return shapes.cut(made, shapes.cylinder(0.4, 9, (2, 0.7, -1)))


X, Y, RADIUS = 14.477695689966, 7.517109605062, 2.5


def slot():
    """With ends whose cylinders are tangent to its sides but for rounding."""
    made = shapes.cut(shapes.box((30, 12, 3)), shapes.cylinder(RADIUS, 5, (X, Y, -1)))
    made = shapes.cut(made, shapes.cylinder(RADIUS, 5, (X + 3, Y, -1)))
    return shapes.cut(made, shapes.box((3, 2 * RADIUS, 5), (X, Y - RADIUS, -1)))


def balls():
    """Middles of triangles along the circles in which they meet lie inside the solid."""
    z, x = (-0.07811282644980785, -0.16972752212656494, 0.98239), (0.9964689165590264, -0.04372665253693539, 0.0716776)
    made = BRepPrimAPI_MakeSphere(gp_Ax2(gp_Pnt(1.375, 0.1875, 0.5), gp_Dir(*z), gp_Dir(*x)), 0.625).Shape()
    where = gp_Ax2(gp_Pnt(0.5625, -0.0625, 0.125), gp_Dir(0, 1, 0), gp_Dir(0, 0, 1))
    return shapes.fuse(made, BRepPrimAPI_MakeSphere(where, 1.25).Shape())


SHAPES = {
    "cylinder": lambda: shapes.cylinder(2, 5),
    "tilted cone": lambda: shapes.moved(shapes.cone(2, 1, 3), (1, 2, 3), ((1, 2, 3), 0.7)),
    "bored ball": lambda: shapes.cut(shapes.sphere(2), shapes.cylinder(0.7, 6, (0.3, 0, -3))),
    "crossing pipes": lambda: shapes.fuse(
        shapes.cylinder(1, 6, (0, 0, -3)), shapes.cylinder(0.8, 6, (-3, 0, 0.2), (1, 0, 0))
    ),
    "filleted box": rounded,
    "pin": pin,
    "drilled": drilled,
    "plate": plate,
    "slotted": slotted,
    "hollow": lambda: shapes.cut(shapes.box((3, 3, 3)), shapes.sphere(1, (1.4, 1.5, 1.6))),
    "balls": balls,
}
BODIES = {}


def made(name):
    if name not in BODIES:
        BODIES[name] = (shape := SHAPES[name]()), fc.from_shape(shape, name=name)
    return BODIES[name]


@pytest.mark.share(12)
@pytest.mark.parametrize("name", SHAPES)
def test_points_are_inside_as_open_cascade_has_it(name):
    shape, body = made(name)
    assert any(isinstance(piece.body, fc.CompositeQuadric) for piece in body.pieces)
    assert body.deviation < 1e-6
    shapes.same_points(shape, body)


@pytest.mark.share(6)
@pytest.mark.parametrize("name", ["bored ball", "filleted box", "pin", "drilled", "plate", "slotted"])
def test_edges_and_vertices_are_the_files(name):
    """Those that are derived of the pieces, but for what lies in walls between them, lie on the file's edges."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS_Compound

    from firstcontact.step.solids import explored

    shape, body = made(name)
    edges, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(edges)
    for edge in explored(shape, TopAbs_ShapeEnum.TopAbs_EDGE):
        builder.Add(edges, edge)
    seen = 0
    for piece in body.pieces:
        points = [
            v.position for k, v in enumerate(piece.body.vertices)
            if not set(v.surfaces) & walls(piece.body) and piece.names.of("vertex", k, piece.body)
        ]  # fmt: skip
        for edge in piece.body.edges:
            if not set(edge.surfaces) & walls(piece.body):
                for part in edge.pieces:
                    points += edge.points(np.linspace(part.lo, part.hi, 3)).tolist()
        for p in points:
            vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex()
            assert BRepExtrema_DistShapeShape(vertex, edges).Value() < max(10 * body.deviation, 1e-6)
            seen += 1
    assert seen > 2


def walls(body):
    return set(range(len(body.surfaces) - 6, len(body.surfaces)))


def test_a_ball_drops_into_a_countersink():
    _, body = made("plate")
    ball = fc.sphere(2).translated((5, 15, 20)).moving(fc.Translation((0, 0, -20)))
    hit = fc.first_contact(ball, body)
    # the cone's tip is at (5, 15, 1), its sides rise by 1: the ball's middle stops sqrt(2) * 2 above the tip
    assert hit.time == pytest.approx((20 - 1 - 2 * 2**0.5) / 20, abs=1e-9)
    assert hit.element_b.kind == "face" and hit.model_deviation == body.deviation
    shape, _ = made("plate")
    through = fc.cylinder("99/100", 30).translated((5, 15, 40)).moving(fc.Translation((0, 0, -60)))
    assert fc.first_contact(through, body).status is fc.Status.FREE
    tight = fc.cylinder("101/100", 30).translated((5, 15, 40)).moving(fc.Translation((0, 0, -60)))
    assert fc.first_contact(tight, body).status is fc.Status.CONTACT


def test_a_pin_along_walls_is_told_without_algebra(monkeypatch):
    """It comes from afar to a side that several pieces have in common: told in doubles, and judged exactly at once."""
    monkeypatch.delattr(advance.PieceSearch, "_close_up")
    made = plate(3, 1)
    part, tip = (fc.from_shape(x, name=name) for x, name in ((made, "plate"), (pin(), "pin")))
    assert len(part.pieces) > 1
    hit = fc.first_contact(tip.translated((90, -80, -70)).moving(fc.Translation((-100, 100, 86))), part)
    assert hit.stats.exact_evaluations == 0 and hit.contact_set == "segment"
    assert hit.time == pytest.approx((80 - 0.6) / 100, abs=1e-15)
    assert hit.time_interval[1] - hit.time_interval[0] <= 1e-12
    assert hit.normal.tolist() == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)


@pytest.mark.share(2)
@pytest.mark.parametrize("turn", [None, ((1, 2, 3), 0.7)])
def test_a_cone_ends_at_its_tip(turn):
    """Its other nappe was part of the pin, up to the wall of the cell."""
    tip = fc.from_shape(shapes.moved(pin(), (0, 0, 0), turn), name="pin")
    assert isinstance(tip.pieces[0].body, fc.CompositeQuadric)
    floor = fc.box((40, 40, 2)).translated((0, 0, -11))  # its top is at z = -10
    back = tip if turn is None else tip.rotated(turn[0], degrees=-np.degrees(turn[1]))
    hit = fc.first_contact(back.moving(fc.Translation((0, 0, -20))), floor)
    assert hit.time == pytest.approx(0.5, abs=1e-8) and hit.element_a.kind == "vertex"


@pytest.mark.share(4)
@pytest.mark.parametrize("name", ["pin", "drilled", "plate", "filleted box"])
def test_pieces_are_in_the_boxes_that_windows_are_made_of(name):
    """What was outside of its box was met within a window for the first time, which was told as a contact at time 0."""
    for piece in made(name)[1].pieces:
        lo, hi = piece.body.bounds()
        assert (lo >= piece.corners.min(axis=0) - 1e-9).all() and (hi <= piece.corners.max(axis=0) + 1e-9).all()


def test_what_points_do_not_see_is_found_by_its_edges(monkeypatch):
    monkeypatch.setattr("firstcontact.step.carriers.Carrier.beyond", lambda *_: False)
    body = fc.from_shape(pin(), name="pin")
    assert all(isinstance(piece.body, fc.Polyhedron) for piece in body.pieces)


@pytest.mark.thorough
def test_a_sliver_of_a_cell_beside_a_tangent_is_not_taken_for_the_solid():
    """A wall between cells leaves a tenth of a slot's side, along which no point was asked; the edge of what was added
    lay in that wall, to within rounding, and was left out."""
    part = fc.from_shape(slot(), name="slot")
    rng = np.random.default_rng(2)
    along = rng.uniform(0.01, 0.3, 200)
    height = (RADIUS - np.sqrt(RADIUS**2 - along**2)) * rng.uniform(0.05, 0.95, 200)
    assert not part.contains(np.array([X + along, Y - RADIUS + height, rng.uniform(0.1, 2.9, 200)]).T).any()
    grain = fc.box((2e-4, 2e-4, 2e-4)).translated((X + 0.09, Y - RADIUS + 8e-4, 1.5))
    assert fc.first_contact(grain.moving(fc.Translation((0, -1e-3, 0))), part).time == pytest.approx(0.7, abs=1e-9)


def test_a_sliver_too_thin_to_be_cut_away_counts_as_deviation(monkeypatch):
    """The same one, where what is as thin as that is left."""
    monkeypatch.setattr(cells, "SURELY", 1e-3)
    part = fc.from_shape(slot(), name="slot")
    depth = RADIUS - np.sqrt(RADIUS**2 - (14.576171875 - X) ** 2)  # at the wall
    assert part.deviation == pytest.approx(depth, rel=1e-6) and part.contains([[14.57, Y - RADIUS + 1e-3, 1.5]]).all()


def test_solids_far_from_the_origin_are_whole():
    shape = shapes.moved(pin(), (5000, 300, -70))
    body = fc.from_shape(shape)
    points = np.random.default_rng(5).uniform((4999, 299, -71), (5001, 301, -62), (700, 3))
    assert isinstance(body.pieces[0].body, fc.CompositeQuadric)
    assert (body.contains(points) == shapes.inside(shape, points)).all()


def test_tangents_that_rounding_hides_are_not_called_exact():
    """Of a tilted box with fillets spheres and cylinders are tangent but for 1e-16: no exact arithmetic takes them."""
    shape = shapes.moved(rounded(), (0, 0, 0), ((1, 2, 3), 0.7))
    body = fc.from_shape(shape, deviation=0.01)
    assert all(isinstance(piece.body, fc.Polyhedron) for piece in body.pieces) and body.deviation > 1e-4
    assert fc.first_contact(fc.sphere(1).translated((0, 0, 9)).moving(fc.Translation((0, 0, -9))), body).time > 0


def test_solids_with_other_faces_are_triangles():
    body = fc.from_shape(shapes.wave(), deviation=0.02)
    assert all(isinstance(piece.body, fc.Polyhedron) for piece in body.pieces) and body.deviation > 1e-6


@pytest.mark.thorough
def test_answers_of_parts_are_named_by_their_faces():
    _, body = made("filleted box")
    hit = fc.first_contact(fc.sphere(1).translated((2, 1.5, 9)).moving(fc.Translation((0, 0, -9))), body)
    assert hit.time == pytest.approx(6 / 9, abs=1e-11) and hit.element_b.kind == "face"
    beside = fc.first_contact(fc.sphere(1).translated((9, 1.6, 1.1)).moving(fc.Translation((-9, 0, 0))), body)
    assert beside.time == pytest.approx(4 / 9, abs=1e-11) and beside.element_b.index != hit.element_b.index
    # down onto the middle of a fillet: the ball's middle is 1.4 from its axis, which is at (., 2.6, 1.6)
    lone = fc.sphere(1).translated((2, 3.2, 9)).moving(fc.Translation((0, 0, -9)))
    hit = fc.first_contact(lone, body)
    assert hit.time == pytest.approx((9 - 1.6 - (1.4**2 - 0.6**2) ** 0.5) / 9, abs=1e-9)
    assert hit.element_b.label.startswith("filleted box ")


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", [16, 20])
def test_random_machined_parts_are_as_open_cascade_has_them(seed):
    """A share of benchmarks/step_random.py."""
    shape = step_random.part(seed)
    body = fc.from_shape(shape)
    assert any(isinstance(piece.body, fc.CompositeQuadric) for piece in body.pieces)
    assert step_random.differing(shape, body, step_random.asked_points(body, seed, 400)) == []


def test_faces_that_do_not_enclose_what_they_bound_are_told(monkeypatch):
    """Without one of its faces the triangles enclose another volume, by more than they are off."""
    whole = rough._all

    def without_one(solid):
        made = whole(solid)
        kept = made.face_of != len(solid.faces) - 1
        return rough.Rough(made.corners[kept], made.face_of[kept], made.deviation)

    shape = shapes.cut(shapes.box((10, 10, 5)), shapes.cylinder(3, 9, (5, 5, -2)))
    found = rough.rough(solid := StepSolid(shape, Shape(shape, "holed")), 0.01)
    bodies._check_volume(solid, found.corners, found.deviation)
    monkeypatch.setattr(rough, "_all", without_one)
    found = rough.rough(solid, 0.01)
    with pytest.raises(fc.InputError, match="do not enclose what they bound"):
        bodies._check_volume(solid, found.corners, found.deviation)


@pytest.mark.thorough
@pytest.mark.parametrize("low", [0.0, 0.75])
@pytest.mark.parametrize("angle", [1.0, 2.5])
def test_a_sector_of_a_turned_cone_meets_a_mesh(low, angle):
    """Its sides pass the tip of its cone within roundings; the mesh has too many triangles to be one convex piece."""
    shape = shapes.sector(2.0, low, 2.5, angle)
    body, mesh = fc.from_shape(shape), fc.examples.box((1, 1, 1), divisions=(6, 6, 6))
    assert body.deviation < 1e-6 and all(isinstance(x.body, fc.CompositeQuadric) for x in body.pieces)
    shapes.same_points(shape, body)
    rough = fc.from_shape(shape, surfaces=False)
    met = 0
    for at in ((1.2, 0.2, 9.0), (0.4, -1.3, 9.0), (-0.4, 0.7, 9.0), (0.9, -0.9, 9.0)):
        moving = mesh.translated(at).moving(fc.Translation((0, 0, -16)))
        hit, near = fc.first_contact(moving, body), fc.first_contact(moving, rough)
        assert hit.status is near.status
        if near.time is not None:
            met += 1
            assert hit.time == pytest.approx(near.time, abs=40 * rough.deviation / 16)
    assert met >= 2
