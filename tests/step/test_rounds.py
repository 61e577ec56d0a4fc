"""Parts with rounds and fillets on tori, against OpenCASCADE and closed formulas."""

import pickle
from fractions import Fraction as F
from math import cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from flint import fmpq

pytest.importorskip("OCP")

from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus  # noqa: E402

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402
from firstcontact.body.compound.compound import as_triangles  # noqa: E402
from firstcontact.body.torus.sector import AngleRange, TorusSector  # noqa: E402


def pin(radius=1):
    """With a round of that radius at the top, z = 5, and of radius 3."""
    return shapes.filleted(shapes.cylinder(3, 5), radius, shapes.circle_at((3, 0, 5)))


def boss():
    """Of radius 2 on a plate, whose top is z = 2, with a fillet of 4/5."""
    made = shapes.fuse(shapes.box((10, 10, 2), (-5, -5, 0)), shapes.cylinder(2, 4, (0, 0, 1)))
    return shapes.filleted(made, 0.8, shapes.circle_at((2, 0, 2)))


def plate():
    """With upright corners of radius 3/2, and 1/2 around the top."""
    made = shapes.filleted(shapes.box((8, 6, 2)), 1.5, shapes.upright)
    return shapes.filleted(made, 0.5, shapes.level_at(2))


def groove():
    """Half a circle deep."""
    return shapes.cut(shapes.cylinder(3, 6), shapes.moved(shapes.torus(3, 0.5), (0, 0, 3)))


def cup():
    """Its bottom's fillet is larger than half its radius."""
    made = shapes.cut(shapes.cylinder(4, 6), shapes.cylinder(2.5, 6, (0, 0, 1.5)))
    return shapes.filleted(made, 1.5, shapes.circle_at((2.5, 0, 1.5)))


def pipe():
    """With a wall of 1, thinner than what is round on the outside and inside together."""
    made = shapes.cut(shapes.cylinder(3, 6), shapes.cylinder(2, 8, (0, 0, -1)))
    for radius, rim in ((0.3, 3), (0.6, 2)):
        made = shapes.filleted(made, radius, shapes.circle_at((rim, 0, 6)))
    return made


def bend(radius=1, angle=pi / 2):
    """A rod around the z axis for a quarter of a turn, and straight on at both ends."""
    made = BRepPrimAPI_MakeTorus(3.0, radius, angle).Shape()
    for at, way in (((3, 0, 0), (0, -1, 0)), ((0, 3, 0), (-1, 0, 0))):
        made = shapes.fuse(made, shapes.cylinder(radius, 4, at, way))
    return made


def halves():
    """Of a ring, with two faces."""
    half = BRepPrimAPI_MakeTorus(3.0, 1.0, pi).Shape()
    return shapes.fuse(half, shapes.moved(half, turn=((0, 0, 1), pi)))


SHAPES = {
    "pin": pin,
    "dome": lambda: pin(2),
    "barely round": lambda: pin(0.02),
    "boss": boss,
    "tilted boss": lambda: shapes.moved(boss(), (1, 2, 3), ((1, 2, 3), 0.7)),
    "plate": plate,
    "groove": groove,
    "bead": lambda: shapes.fuse(shapes.cylinder(3, 6), shapes.moved(shapes.torus(3, 0.5), (0, 0, 3))),
    "cup": cup,
    "pipe": pipe,
    "bent rod": bend,
    "bent pipe": lambda: shapes.cut(bend(), bend(0.7)),
    "half a hollow ring": lambda: shapes.cut(
        BRepPrimAPI_MakeTorus(3.0, 1.0, pi).Shape(), BRepPrimAPI_MakeTorus(3.0, 0.6, pi).Shape()
    ),
    "two halves of a ring": halves,
}
BODIES = {}


def made(name):
    if name not in BODIES:
        BODIES[name] = (shape := SHAPES[name]()), fc.from_shape(shape, name=name)
    return BODIES[name]


def down(body, x, y, height=10):
    """A body comes down along z, from z = height to 0."""
    return body.translated((x, y, height)).moving(fc.Translation((0, 0, -height)))


@pytest.mark.share(16)
@pytest.mark.parametrize("name", SHAPES)
def test_parts_with_rounds_are_exact(name):
    shape, body = made(name)
    kinds = {type(piece.body) for piece in body.pieces}
    assert TorusSector in kinds and kinds <= {fc.CompositeQuadric, TorusSector} and body.deviation < 1e-10
    shapes.same_points(shape, body)


def test_a_whole_torus_is_the_torus():
    part = fc.from_shape(shapes.torus(3, 1), name="ring")
    assert [piece.body for piece in part.pieces] == [fc.torus(3, 1)] and part.deviation == 0.0
    hit = fc.first_contact(down(fc.sphere(1), "5/2", 0), part)
    assert hit.time == pytest.approx((10 - sqrt(4 - 0.25)) / 10, abs=1e-12) and hit.element_b.kind == "face"
    with pytest.raises(fc.UnsupportedPair, match="load the part with surfaces=False"):
        fc.first_contact(down(fc.sphere(1), "5/2", 0), made("pin")[1], exact=True)
    tilted = fc.from_shape(shapes.moved(shapes.torus(3, 1), (1, 2, 3), ((1, 2, 3), 0.7)))
    assert isinstance(tilted.pieces[0].body, fc.Torus) and 0.0 < tilted.deviation < 1e-14


@pytest.mark.share(2)
@pytest.mark.parametrize("x", [2.1, 3.3])
def test_a_ball_comes_down_on_a_round(x):
    """Its middle is 3/2 from the circle of radius 2 at z = 4, whatever is cut off of the torus."""
    _, body = made("pin")
    ball = down(fc.sphere("1/2"), x * cos(0.3), x * sin(0.3))
    hit = fc.first_contact(ball, body)
    height = sqrt(1.5**2 - (x - 2) ** 2)
    assert hit.time == pytest.approx((6 - height) / 10, abs=1e-11)
    out = (x - 2) / 1.5
    assert hit.normal == pytest.approx([out * cos(0.3), out * sin(0.3), height / 1.5], abs=1e-6)
    rho = hypot(hit.point[0], hit.point[1])
    assert hypot(rho - 2, hit.point[2] - 4) == pytest.approx(1, abs=1e-8)
    named = hit.element_b
    assert (named.kind, body.pieces[-1].names.own[0][0]) == ("face", named.index) and named.label.startswith("pin ")
    swapped = fc.first_contact(body, ball)
    assert swapped.time == hit.time and swapped.element_a == hit.element_b


@pytest.mark.thorough
def test_a_common_motion_changes_nothing():
    _, body = made("pin")
    ball, way = fc.sphere("1/2").translated((3, 0, 9)), np.array([0, 0, -6])
    alone = fc.first_contact(ball.moving(fc.Translation(way.tolist())), body)
    both = fc.first_contact(
        ball.moving(fc.Translation((way + [1, -2, 3]).tolist())), body.moving(fc.Translation((1, -2, 3)))
    )
    assert both.time == pytest.approx(alone.time, abs=1e-12) and both.element_b == alone.element_b
    turned = fc.first_contact(
        ball.rotated((1, 0, 0), degrees=90).moving(fc.Translation((0, 6, 0))), body.rotated((1, 0, 0), degrees=90)
    )
    assert turned.time == pytest.approx(alone.time, abs=1e-11)


FILLETED = {
    "ball": (lambda: fc.sphere("3/10"), 0.5),
    "ring": (lambda: fc.torus("1/5", "1/10").rotated((1, 0, 0), degrees=90), 0.5),
    "point": (lambda: fc.Polyhedron([(0, 0, 0)], []), 0.8),
    "wedge": (
        lambda: fc.Polyhedron(
            [(0, 0, 0), (1, 0, "1/8"), (1, "1/9", 0), (1, 0, 0)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
        ), 0.8,
    ),
    "strip": (lambda: fc.RuledSurface("(u, 0, 0)", "(u, u/9, -u/9)", u=(0, 1), s=(0, "1/2")), 0.8),
}  # fmt: skip


@pytest.mark.share(6)
@pytest.mark.parametrize("kind", FILLETED)
def test_bodies_of_all_kinds_come_to_a_fillet(kind):
    """Its circle has the radius 14/5 and is at z = 14/5: what is in the corner is 4/5 from there."""
    _, body = made("boss")
    make, off = FILLETED[kind]
    hit = fc.first_contact(make().translated((6, 0, "5/2")).moving(fc.Translation((-6, 0, 0))), body)
    assert hit.time == pytest.approx((6 - (2.8 - sqrt(off**2 - 0.3**2))) / 6, abs=1e-11)
    assert hit.element_b.index == body.pieces[-1].names.own[0][0]


@pytest.mark.thorough
def test_times_of_contact_with_a_round():
    _, body = made("pin")
    across = fc.sphere("1/2").translated(("14/5", -9, "26/5")).moving(fc.Translation((0, 18, 0)))
    (stay,) = fc.contact_intervals(across, body)
    reach = sqrt((2 + sqrt(1.5**2 - 1.2**2)) ** 2 - 2.8**2)
    assert (stay.start, stay.end) == pytest.approx(((9 - reach) / 18, (9 + reach) / 18), abs=1e-10)


@pytest.mark.share(4)
@pytest.mark.parametrize(
    ("side", "name"), [("round", "pin"), ("flat", "pin"), ("flat", "groove"), ("round", "groove")]
)
def test_what_lands_flat_beside_a_round(side, name):
    """A plate on the top of a pin, and a bar along its side, are told though they touch the round's seam as well."""
    _, body = made(name)
    if side == "flat":
        body = body if name == "pin" else body.translated((0, 0, -1))
        hit = fc.first_contact(down(fc.box((9, 9, 1)), 0, 0), body)
        assert hit.time == pytest.approx(0.45, abs=1e-12)
    else:
        bar = fc.from_shape(shapes.cylinder(0.4, 9), name="bar").translated((5, 0, -2))
        hit = fc.first_contact(bar.moving(fc.Translation((-4, 0, 0))), body)
        assert hit.time == pytest.approx(1.6 / 4, abs=1e-11)


def test_a_bar_of_a_file_beside_a_round():
    """Cells next to those that hold a point of the other body were given up, as if they held it themselves."""
    shape = shapes.filleted(shapes.cylinder(2, 6), 0.5, shapes.circle_at((2, 0, 6)))
    body, bar = (fc.from_shape(x) for x in (shape, shapes.cylinder(0.4231184481214936, 0.8462368962429872)))
    start, way = (1.954, -11.174, 12.349), np.array([-3.095341622572489, 11.441984206822683, -9.825014702493771])
    hit = fc.first_contact(bar.translated(start).moving(fc.Translation(way.tolist())), body)
    middle = np.array(start[:2]) + hit.time * way[:2]
    assert hit.status is fc.Status.CONTACT and np.linalg.norm(middle) == pytest.approx(2.4231184481214936, abs=1e-9)


@pytest.mark.thorough
def test_parts_with_rounds_are_values():
    _, body = made("boss")
    assert pickle.loads(pickle.dumps(body)) == body
    placed = body.translated((1, 2, 3))
    assert placed != body and placed.translated((-1, -2, -3)) == body
    shape, _ = made("boss")
    part = fc.from_shape(shapes.moved(shape, (1, 2, 3)), name="boss")
    assert np.allclose(part.bounds(), placed.bounds(), atol=1e-3)


def test_a_ball_comes_through_a_bent_pipe_and_onto_its_end():
    """The end of a hollow half is flat, and its bore is about the same circle: all have their names."""
    _, body = made("half a hollow ring")
    (piece,) = body.pieces
    assert len({piece.names.of("face", k, piece.body)[1] for k in range(4)}) == 4
    ball = fc.sphere("1/4").translated((0, 3, 0)).moving(fc.Translation((0, 0, 2)))
    hit = fc.first_contact(ball, body)
    assert hit.time == pytest.approx(0.35 / 2, abs=1e-11) and hit.element_b.index == piece.names.own[1][0]
    up = fc.sphere("1/4").translated(("19/5", -3, 0)).moving(fc.Translation((0, 4, 0)))
    hit = fc.first_contact(up, body)
    assert hit.time == pytest.approx((3 - 0.25) / 4, abs=1e-11) and hit.element_b.index == piece.names.own[2][0]
    assert hit.normal == pytest.approx([0, -1, 0], abs=1e-9)


@pytest.mark.thorough
def test_slivers_beside_the_ends_of_rounds_are_not_lost():
    """Beyond its end a chord is all but where the next face is: what is between was cut off, to a depth of 2e-6."""
    made = shapes.filleted(shapes.filleted(shapes.box((60, 40, 6)), 6, shapes.upright), 1, shapes.level_at(0))
    body = fc.from_shape(made)
    assert body.deviation < 1e-11 and sum(isinstance(x.body, TorusSector) for x in body.pieces) == 4


def test_what_other_faces_cut_stays_triangles():
    drilled = shapes.cut(pin(), shapes.cylinder(0.3, 9, (2.5, 0, -1)))
    body = fc.from_shape(drilled, deviation=0.05)
    assert all(isinstance(piece.body, fc.Polyhedron) for piece in body.pieces)


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", [0, 1])
def test_sectors_hold_what_their_angles_and_distances_say(seed):
    rng = np.random.default_rng(seed)
    first = rng.uniform(-pi, pi, 2)
    (u0, u1), (v0, v1) = zip(first, first + rng.uniform(0.5, 6, 2), strict=True)
    shares = (fmpq(1, 2), fmpq(1)) if seed else (fmpq(1), fmpq(5, 4))
    body = TorusSector(fmpq(3), fmpq(2), shares, AngleRange.between(v0, v1), AngleRange.between(u0, u1))
    lo, hi = body.bounds()
    points = rng.uniform(lo - 0.1, hi + 0.1, (3000, 3))
    rho = np.hypot(points[:, 0], points[:, 1])
    s = np.hypot(rho - 3, points[:, 2]) / 2
    u, v = np.arctan2(points[:, 1], points[:, 0]), np.arctan2(points[:, 2], rho - 3)
    wanted = (s >= float(shares[0])) & (s <= float(shares[1]))
    wanted &= ((u - u0) % (2 * pi) <= u1 - u0) & ((v - v0) % (2 * pi) <= v1 - v0)
    assert (body.contains(points) == wanted).all() and 50 < wanted.sum() < 2900
    # balls that sampled points are in are in contact, those far from all are not
    near = np.linalg.norm(points[:, None] - points[wanted][:400], axis=2).min(axis=1)
    for touched, some in ((True, wanted | (near < 0.1)), (False, near > 1.0)):
        for p in points[some][:4].tolist():
            ball = fc.sphere("1/10").translated(p).moving(fc.Translation((0, 0, 0)))
            assert (fc.first_contact(ball, body).status is fc.Status.INITIAL_CONTACT) == touched


@pytest.mark.thorough
def test_what_seats_on_a_round_along_a_circle_is_told_by_triangles():
    """The rim of a hole of radius 2.6 comes to a round, a tube of radius 1 about radius 2 and z = 4, at z = 4.8."""
    holed = shapes.cut(shapes.box((10, 10, 1), (-5, -5, 0)), shapes.cylinder(2.6, 2, (0, 0, -0.5)))
    seat, shaft = fc.from_shape(holed, name="seat"), fc.from_shape(pin(), name="shaft")
    moving = seat.translated((0, 0, 6)).moving(fc.Translation((0, 0, -2)))
    found = fc.first_contact(moving, shaft, tolerance=1e-6)
    assert found.status is fc.Status.CONTACT and [x.way for x in found.stats.ways][0] == "by pieces"
    assert 1e-6 < found.model_deviation < 2e-3
    assert abs(6 - 2 * found.time - 4.8) < 2 * found.model_deviation and found.free_until <= found.time


def test_triangles_that_miss_each_other_prove_nothing_of_rounds():
    """A ring comes to rest on the round of a larger one along a whole circle, in the last instant: 3, 4, 5.  The
    triangles of both stay apart."""
    ring, seat = (fc.from_shape(shapes.torus(big, 2.5), deviation=0.1) for big in (10, 13))
    moving = ring.translated((0, 0, 9)).moving(fc.Translation((0, 0, -5)))
    assert fc.first_contact(as_triangles(moving), as_triangles(seat)).status is fc.Status.FREE
    found = fc.first_contact(moving, seat)
    assert found.status is fc.Status.UNDECIDED and found.reason == "precision" and 0.999 < found.free_until <= 1
    further = fc.first_contact(moving, seat, span=(0, 2))
    assert further.status is fc.Status.CONTACT and further.time == pytest.approx(1.0, abs=1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize("depth", ["1e-5", "1e-8"])
def test_a_graze_that_triangles_miss_is_not_told_as_what_comes_later(depth):
    """A ball passes a ring at t = 1/4, that deep in it, goes on, and comes into the ring: CONTACT was told at 0.8."""
    ring = fc.from_shape(shapes.torus(2, 0.5), name="ring")
    far, (c, s), (cp, sp) = F(3, 2) - F(depth), (F(3, 5), F(4, 5)), (F(5, 13), F(12, 13))
    place, way = ((2 + far * cp) * c, (2 + far * cp) * s, far * sp), (-8 * s, 8 * c, 0)
    into = [2 * c - place[0] - way[0], 2 * s - place[1] - way[1], -place[2]]
    path = fc.Sequence([fc.Translation([2 * x for x in way]), fc.Translation(into)])
    ball = fc.sphere(1).translated([x - d for x, d in zip(place, way, strict=True)])
    deep = F(1, 2) - F(depth) / 2
    common = ((2 + deep * cp) * c, (2 + deep * cp) * s, deep * sp)
    assert ring.contains([common])[0] and fc.sphere(1).translated(place).contains([common])[0]
    found = fc.first_contact(ball.moving(path), ring)
    assert found.free_until < 0.25
    assert found.status is fc.Status.UNDECIDED or found.time < 0.25 + 1e-3


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["pin", "groove", "boss"])
@pytest.mark.parametrize("lander", ["plate", "pin"])
def test_all_times_where_parts_land_flat_beside_rounds(lander, name):
    """Flat faces meet from then on; what touches at the seams of rounds, which no search tells, adds no time."""
    _, body = made(name)
    body = body if name != "groove" else body.translated((0, 0, -1))
    plate = fc.box((9, 9, 1))
    upside_down = fc.from_shape(pin(), name="lander").rotated((1, 0, 0), degrees=180).translated((0, 0, 5))
    found = fc.contact_intervals(down(plate if lander == "plate" else upside_down, 0, 0), body)
    (stay,) = found
    assert found.status is fc.Status.CONTACT and stay.end == 1.0
    assert stay.start_interval[0] <= (0.45 if lander == "plate" else 0.5) <= stay.start_interval[1]
    assert stay.start_interval[1] - stay.start_interval[0] <= 1e-12
