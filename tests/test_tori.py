"""Tori against balls, half-spaces, boxes, meshes, tori and ruled surfaces: closed forms, sampled distances, laws."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction as F
from functools import cache

import numpy as np
import pytest
from flint import fmpq, fmpq_poly

import firstcontact as fc
from firstcontact.body.torus.torus import torus as made
from firstcontact.cli import run
from firstcontact.contact.torus import free
from firstcontact.contact.torus.nets import Nets
from firstcontact.errors import InputError
from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.numbers import exact_value
from firstcontact.view.drawing import drawings
from firstcontact.view.pair import pairs_of

RING = fc.torus(2, F(1, 2), name="ring")
DOWN = fc.Translation((0, 0, -10))
SADDLE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
WIDE = fc.RuledSurface("(u, -3, 0)", "(u, 3, u/4)", u=(-3, 3))
ANGLES = np.linspace(0.0, 2.0 * math.pi, 4000, endpoint=False)


def gap(points, major, minor):
    """From a torus about z; sampled without the library."""
    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - major, points[:, 2]) - minor


def circle(radius):
    return np.column_stack([radius * np.cos(ANGLES), radius * np.sin(ANGLES), 0 * ANGLES])


def gap_to_box(points, half):
    beyond = np.abs(points) - half
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(beyond.max(axis=1), 0.0)


def check(hit, truth):
    assert hit.status is fc.Status.CONTACT
    lo, hi = hit.time_interval
    assert lo <= truth * (1 + 1e-15) and truth * (1 - 1e-15) <= hi and hi - lo <= 1e-12
    assert hit.free_until <= truth


# -- closed forms -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("y, z", [(0.0, 0.0), (-1.25, 0.5), (2.25, -0.125)])
@pytest.mark.share(3)
def test_a_ball_flies_at_a_ring(y, z):
    """Its centre, (8 - 8 t, y, z), comes as near as 3/4 to the circle: rho = 2 + sqrt(9/16 - z^2)."""
    ball = fc.sphere("1/4").translated((8, y, z)).moving(fc.Translation((-8, 0, 0)))
    rho = 2 + math.sqrt(0.5625 - z * z)
    hit = fc.first_contact(ball, RING)
    check(hit, 1 - math.sqrt(rho * rho - y * y) / 8)
    x = np.array([8 - 8 * hit.time, y, z])
    foot = 2 * x * [1, 1, 0] / np.hypot(x[0], y)
    out = (x - foot) / np.linalg.norm(x - foot)
    assert hit.normal == pytest.approx(out, abs=1e-9)
    assert hit.point == pytest.approx(x - out / 4, abs=1e-9)
    assert (hit.element_a.kind, hit.element_b.kind, hit.element_b.label) == ("face", "face", "ring.surface")


def test_a_ball_swings_into_a_ring():
    """About the axis x = 5, parallel to z, at radius 3: rho^2 = 25 + 9 - 30 cos a = 2.75^2, a from -x."""
    ball = fc.sphere("1/4").translated((5, 3, 0)).moving(fc.Rotation((0, 0, 1), (5, 0, 0), degrees=90))
    truth = 1 - math.acos((34 - 2.75**2) / 30) / (math.pi / 2)
    check(fc.first_contact(ball, RING), truth)


@pytest.mark.thorough
@pytest.mark.parametrize("degrees", [0, 30, 90])
def test_a_ring_falls_on_half_spaces_boxes_and_meshes(degrees):
    """It reaches 2 |sin a| + 1/2 below its centre; flat it touches along a circle."""
    fallen = RING.rotated((1, 0, 0), degrees=degrees).translated((0, 0, 6)).moving(DOWN)
    truth = (6 - 2 * abs(math.sin(math.radians(degrees))) - 0.5) / 10
    floors = [fc.box((8, 8, 2)).translated((0, 0, -1)), fc.examples.box((8, 8, 2)).translated((0, 0, -1))]
    if degrees:
        floors[0] = fc.half_space((0, 0, 1), 0)
    for floor in floors:
        hit = fc.first_contact(fallen, floor)
        check(hit, truth)
        assert hit.normal == pytest.approx([0, 0, 1], abs=1e-9) and hit.point[2] == pytest.approx(0, abs=1e-9)
        assert hit.element_b.kind == "face"


def test_rings_fall_on_each_other():
    """One circle above another, radii 2 and 9/4, tubes of 1/2: the centres of the tubes are 1 apart."""
    fallen = fc.torus("9/4", "1/2").translated((0, 0, 5)).moving(DOWN)
    check(fc.first_contact(fallen, RING), (5 - math.sqrt(1 - 1 / 16)) / 10)
    check(fc.first_contact(RING.translated((0, 0, 5)).moving(DOWN), RING), 0.4)
    spun = RING.translated((0, 0, 5)).moving(fc.Screw((0, 0, -1), degrees=77, advance=10))
    check(fc.first_contact(spun, RING), 0.4)


@pytest.mark.thorough
def test_a_ring_falls_on_a_cone_and_a_corner():
    """Cone of slope 1 about the axis: the tube's centre comes as near as 1/2 to the line rho + z = 3."""
    fallen = RING.translated((0, 0, 5)).moving(DOWN)
    check(fc.first_contact(fallen, fc.cone(3, 3)), (5 - (1 + math.sqrt(0.5))) / 10)
    spike = fc.Polyhedron([[2, 0, 1], [2, 1, 0], [2, -1, 0], [3, 0, 0]], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    hit = fc.first_contact(fallen, spike)
    check(hit, 0.35)
    assert hit.element_b.kind == "vertex" and hit.point == pytest.approx([2, 0, 1])
    edged = fc.box((1, 6, 1)).rotated((0, 1, 0), degrees=45).rotated((0, 0, 1), degrees=30).translated((2, 0, 0))
    assert fc.first_contact(fallen, edged).element_b.kind == "edge"


# -- holes, tubes, links ------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_a_tip_flies_into_a_ring():
    """UNDECIDED: the form of a cone is next to nothing about its apex, where coordinates about another place cancel."""
    start, way, centre = (-5, 2, 3), (14, -4, 6), (2, -2, 5)
    tip = fc.cone(2, 3).translated((-5, 2, 0)).moving(fc.Translation(way))
    ring = fc.torus(4, "1/2").translated(centre)
    x, y, z = (fmpq_poly([p - c, v]) for p, v, c in zip(start, way, centre, strict=True))
    form = (x * x + y * y + z * z + fmpq(63, 4)) ** 2 - 64 * (x * x + y * y)
    first = real_roots(form.numer(), fmpq(0), fmpq(1))[0]
    hit = fc.first_contact(tip, ring)
    lo, hi = hit.time_interval
    assert first.compare(exact_value(lo)) >= 0 >= first.compare(exact_value(hi)) and hi - lo < 1e-12
    assert (hit.element_a.kind, hit.element_b.kind) == ("apex", "face")
    assert hit.point == pytest.approx(np.array(start) + float(first) * np.array(way), abs=1e-9)
    (x,) = fc.contact_intervals(ring, tip, span=(F(1, 4), F(3, 10)))
    assert x.start == pytest.approx(float(first), abs=1e-12) and x.end == 0.3


def test_a_ball_passes_through_the_hole():
    through = fc.sphere("5/4").translated(("1/8", "1/8", 5)).moving(DOWN)
    assert fc.first_contact(through, RING).status is fc.Status.FREE  # 1.5 - 1.25 - 0.177 apart
    wide = fc.sphere("11/8").translated(("1/8", "1/8", 5)).moving(DOWN)
    assert fc.first_contact(wide, RING).status is fc.Status.CONTACT


SMALL = SADDLE.transformed(np.diag([0.2, 0.2, 0.2, 1]))


@pytest.mark.share(2)
@pytest.mark.parametrize("inner", [
    fc.sphere("1/4"), fc.box(("1/4",) * 3), fc.examples.box((0.25,) * 3), fc.torus("1/5", "1/10"), SMALL,
])  # fmt: skip
def test_what_is_inside_the_tube_is_in_contact(inner):
    hit = fc.first_contact(inner.translated((2, 0, 0)), RING)
    assert (hit.status, hit.initial, hit.time) == (fc.Status.INITIAL_CONTACT, "containment", 0.0)
    assert fc.first_contact(inner, RING).status is fc.Status.FREE  # in the hole


@pytest.mark.parametrize("room", [fc.sphere(4), fc.examples.box((6, 6, 6)), fc.box((6, 6, 6)) | fc.cylinder(1, 9)])
def test_a_ring_inside_a_body(room):
    hit = fc.first_contact(RING.rotated((1, 2, 3), degrees=40), room)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "containment")


@pytest.mark.thorough
def test_a_ring_in_a_hollow_box_is_free():
    assert fc.first_contact(RING, fc.box((9, 9, 9)) - fc.box((7, 7, 7))).status is fc.Status.FREE
    shaken = RING.moving(fc.Translation((4, 0, 0)))
    check(fc.first_contact(shaken, fc.box((9, 9, 9)) - fc.box((7, 7, 7))), 0.25)


def test_overlapping_rings():
    hit = fc.first_contact(RING.translated((1, 0, 0)), RING)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "overlapping")


@pytest.mark.thorough
def test_links_of_a_chain():
    """Linked rings at right angles: pulled apart along x, tubes 2 - t apart at first, meet when centres are 3 apart."""
    link = RING.rotated((1, 0, 0), degrees=90).translated((2, 0, 0))
    assert fc.first_contact(link, RING).status is fc.Status.FREE
    pulled = fc.first_contact(link.moving(fc.Translation((4, 0, 0))), RING)
    check(pulled, 0.25)
    swung = fc.first_contact(link.moving(fc.Rotation((1, 0, 0), degrees=360)), RING)
    assert swung.status is fc.Status.FREE if _links_apart() else swung.status is fc.Status.CONTACT


def _links_apart() -> bool:
    """Whether the link's circle, turned about x by any angle, keeps 1 away from the ring's, by sampled points."""
    for angle in np.linspace(0, np.pi, 181):
        x, y = 2 + 2 * np.cos(ANGLES), 2 * np.sin(ANGLES)
        turned = np.column_stack([x, y * math.cos(angle), y * math.sin(angle)])
        if gap(turned, 2.0, 1.0).min() < 0:
            return False
    return True


# -- sampled distances --------------------------------------------------------------------------------------

MOTIONS = [
    fc.Translation((3, -2, -9)),
    fc.Rotation((1, 2, 0), (0, 4, 1), degrees=170),
    fc.Screw((1, 0, -3), (1, 0, 0), degrees=200, advance=8),
    fc.RationalMotion.between((0, 0, 0), (1, -1, -9), quat_xyzw=[(0, 0, 0, 1), (0.5, 0.5, 0.5, 0.5)]),
    fc.Sequence([fc.Translation((0, 1, -2)), fc.Rotation((0, 1, 1), degrees=60), fc.Translation((0, 0, -6))]),
]


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda m: type(m).__name__)
@pytest.mark.parametrize("kind", ["model", "mesh", "torus", "ruled"])
@pytest.mark.share(8)
def test_first_contacts_are_those_of_sampled_distances(kind, motion):
    seed = 7 + MOTIONS.index(motion)
    rng = np.random.default_rng(seed)
    rest = {"model": fc.box((3, 2, 1)), "mesh": fc.examples.box((3, 2, 1)), "torus": fc.torus(1, "1/4"),
            "ruled": SADDLE}[kind]  # fmt: skip
    u, s = (x.ravel() for x in np.meshgrid(*[np.linspace(0, 1, 60)] * 2))
    net = np.column_stack([u, s, u * s])

    def apart(pose):
        if kind == "ruled":
            back = np.linalg.inv(pose)
            return gap(net @ back[:3, :3].T + back[:3, 3], 2.0, 0.5).min()
        tube = circle(2.0) @ pose[:3, :3].T + pose[:3, 3]
        return (gap(tube, 1.0, 0.25) if kind == "torus" else gap_to_box(tube, np.array([1.5, 1.0, 0.5]))).min() - 0.5

    place = RING.rotated(rng.integers(1, 4, 3).tolist(), degrees=int(rng.integers(0, 180)))
    place = place.translated([*(rng.integers(-8, 9, 2) / 4).tolist(), 4.5])
    hit = fc.first_contact(place.moving(motion), rest)
    own = np.vstack([place.pose, [0, 0, 0, 1]])
    times = np.linspace(0, 1, 101)
    seen = np.array([apart(motion(float(t)) @ own) for t in times])
    room = 2e-2 if kind == "ruled" else 1e-5  # between samples
    if hit.status is fc.Status.FREE:
        assert seen.min() > -1e-9
    else:
        assert hit.status is fc.Status.CONTACT
        assert seen[times < hit.time].min(initial=1.0) > -1e-9
        assert -1e-9 < apart(motion(hit.time) @ own) + 1e-8 < room
        assert np.linalg.norm(hit.normal) == pytest.approx(1.0)


# -- laws ---------------------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("other", [fc.examples.box((3, 2, 1)), fc.torus(1, "1/4"), WIDE])
def test_laws(other):
    """Swapped, scaled, seen from the other body, and under common motions the first contact is the same."""
    ring, way = RING.rotated((1, 2, 3), degrees=33).translated((1, 0.5, 5)), fc.Translation((-1, 0, -9))
    hit = fc.first_contact(ring.moving(way), other)
    swapped = fc.first_contact(other, ring.moving(way))
    assert swapped.status is hit.status is fc.Status.CONTACT
    assert swapped.time == pytest.approx(hit.time, abs=1e-12) and swapped.normal == pytest.approx(-hit.normal, abs=1e-6)
    assert (swapped.element_a.kind, swapped.element_b.kind) == (hit.element_b.kind, hit.element_a.kind)
    scale = np.diag([3, 3, 3, 1])
    large = fc.first_contact(ring.transformed(scale).moving(fc.Translation((-3, 0, -27))), other.transformed(scale))
    assert large.time == pytest.approx(hit.time, abs=2e-12)
    back = fc.first_contact(ring, other.moving(fc.Translation((1, 0, 9))))
    assert back.time == pytest.approx(hit.time, abs=2e-12)
    turn = fc.Rotation((1, 0, 2), (0, 1, 0), degrees=50)
    there = fc.Sequence([way])
    assert fc.first_contact(ring.moving(there), other).time == pytest.approx(hit.time, abs=2e-12)
    assert fc.first_contact(ring.moving(turn), other.translated((0, 0, -9)).moving(turn)).status is fc.Status.FREE


@pytest.mark.thorough
def test_all_times_of_contact():
    """A ball flies through both sides of a ring; a box falls through its tube, which looks the same backwards."""
    rho = [2 + 0.75, 2 - 0.75]
    times = [(5 - rho[0]) / 10, (5 - rho[1]) / 10, (5 + rho[1]) / 10, (5 + rho[0]) / 10]
    found = fc.contact_intervals(fc.sphere("1/4").translated((-5, 0, 0)).moving(fc.Translation((10, 0, 0))), RING)
    assert [t for x in found for t in (x.start, x.end)] == pytest.approx(times, abs=1e-11)
    box = fc.examples.box((0.25, 0.25, 0.25)).translated((2, 0, 3)).moving(fc.Translation((0, 0, -6)))
    (passage,) = fc.contact_intervals(box, RING)
    assert passage.start == pytest.approx((3 - 0.625) / 6, abs=1e-11)  # a point above the circle lies below the box
    assert passage.start + passage.end == pytest.approx(1, abs=1e-11)


@pytest.mark.share(3)
@pytest.mark.parametrize("height", ["3/4", "7/10", "751/1000"])
def test_a_graze_is_never_free(height):
    """A ball passes over the top of a ring: at 3/4 it touches at one instant."""
    ball = fc.sphere("1/4").translated((-3, 0, height)).moving(fc.Translation((2, 0, 0)))
    hit = fc.first_contact(ball, RING)
    if height == "751/1000":
        assert hit.status is fc.Status.FREE
    elif height == "7/10":
        assert hit.status is fc.Status.CONTACT
    else:
        assert hit.status is fc.Status.UNDECIDED and hit.reason == "precision" and 0.4 < hit.free_until <= 0.5


def test_what_touches_at_the_start_is_not_decided():
    hit = fc.first_contact(RING.translated((0, 0, "1/2")), fc.half_space((0, 0, 1), 0))
    assert (hit.status, hit.free_until) == (fc.Status.UNDECIDED, 0.0)


def test_a_budget_ends_the_search():
    hit = fc.first_contact(RING.translated((0, 0, 5)).rotated((1, 2, 3), degrees=20).moving(DOWN), SADDLE, budget=5)
    assert (hit.status, hit.reason) == (fc.Status.UNDECIDED, "budget") and hit.free_until >= 0.0


def test_spans_without_end():
    hit = fc.first_contact(RING.translated((0, 0, 50)).moving(fc.Translation((0, 0, -1))), WIDE, span=(0, math.inf))
    assert hit.status is fc.Status.CONTACT and 48 < hit.time < 50
    past = RING.translated((9, 0, 50)).moving(fc.Translation((0, 0, -1)))
    assert fc.first_contact(past, fc.sphere(1), span=(0, math.inf)).status is fc.Status.FREE


@pytest.mark.share(2)
@pytest.mark.parametrize("far", [1e6, 1e9])
def test_far_from_the_origin(far):
    ball = fc.sphere("1/4").translated((far + 8, far, far)).moving(fc.Translation((-8, 0, 0)))
    assert fc.first_contact(ball, RING.translated((far, far, far))).time == pytest.approx(1 - 2.75 / 8, abs=1e-12)


# -- the body -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radii", [(1, 1), (1, 2), (0, 0), (1, 0), (1, -1), ("x", 1), (1, float("nan")), (2**200, 1)])
def test_other_radii_are_refused_in_one_line(radii):
    with pytest.raises(InputError) as told:
        fc.torus(*radii)
    assert "\n" not in str(told.value)


def test_what_is_not_taken_is_refused():
    with pytest.raises(fc.UnsupportedPair, match="not exact"):
        fc.first_contact(RING, fc.sphere(1), exact=True)
    with pytest.raises(fc.UnsupportedPair, match="deforms"):
        fc.first_contact(RING, fc.RuledSurface("(u, 0, T)", "(u, 1, u - T)"))
    with pytest.raises(fc.UnsupportedPair, match="whole rulings"):
        fc.first_contact(RING, fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", s=None))
    for verb in (fc.contact_pairs, fc.intersection_curve):
        with pytest.raises(fc.UnsupportedPair, match="Torus"):
            verb(RING, SADDLE)


def test_a_torus_is_a_value():
    moved = RING.translated(("1/3", 0, 0)).rotated((1, 2, 3), degrees=20)
    assert repr(RING) == "<Torus 'ring': major 2, minor 0.5>"
    assert moved == RING.translated((F(1, 3), 0, 0)).rotated((1, 2, 3), degrees=20) and moved != RING
    for same in (pickle.loads(pickle.dumps(moved)), fc.Torus.from_json(moved.to_json()), fc.from_dict(moved.to_dict())):
        assert same == moved and hash(same) == hash(moved) and same.name == "ring"
    moving = RING.moving(DOWN)
    assert fc.from_dict(moving.to_dict()) == moving and moving.at(0.5).bounds()[0][2] == pytest.approx(-5.5)
    assert made(2, "1/2") == fc.torus(2, 0.5)


def test_bounds_and_points():
    turned = RING.rotated((1, 1, 0), degrees=35).translated((1, 2, 3))
    tube = circle(2.0) @ turned.pose[:, :3].T + turned.pose[:, 3]
    lo, hi = turned.bounds()
    assert lo == pytest.approx(tube.min(axis=0) - 0.5, abs=1e-5)
    assert hi == pytest.approx(tube.max(axis=0) + 0.5, abs=1e-5)
    points = [(2.5, 0, 0), (0, 2, 0.5), (2.5000001, 0, 0), (0, 0, 0)]
    assert RING.contains(points).tolist() == [True, True, False, False]
    assert RING.contains((1.5, 0, 0))


@pytest.mark.share(2)
@pytest.mark.parametrize("scale", [1, -2])
def test_the_mesh_and_the_picture(scale):
    body = RING.transformed(np.diag([scale, 2, 2, 1])).translated((3, 0, 0))
    mesh = body.to_mesh(0.001).to_trimesh()
    truth = 2 * math.pi**2 * 2 * 0.25 * 4 * abs(scale)
    assert mesh.is_watertight and mesh.volume == pytest.approx(truth, rel=3e-3)
    hit = fc.first_contact(body.translated((0, 0, 9)).moving(DOWN), fc.sphere(1).named("ball").translated((3, 0, 0)))
    drawing = drawings(pairs_of([hit])[0])[0]
    a, b, c = (drawing.vertices[drawing.triangles[:, k]] for k in range(3))
    assert np.all((np.cross(b - a, c - a) * drawing.normals[drawing.triangles[:, 0]]).sum(axis=1) > 0)
    assert len(drawing.corners(fc.Element("face", "ring", 0, "ring.surface"))) == 3 * len(drawing.triangles)


def test_a_scene(tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[body.ring]\nshape = "torus"\nmajor = 2\nminor = "1/2"\nat = [0, 0, 5]\n'
        '[body.ring.motion]\ntype = "translation"\nvector = [0, 0, -10]\n'
        '[body.floor]\nshape = "half_space"\nnormal = [0, 0, 1]\noffset = 0\n'
    )
    assert run(["info", str(scene)]) == 0 and "1 face, a torus, major 2, minor 0.5" in capsys.readouterr().out
    assert run(["check", str(scene), "--html", str(tmp_path / "page.html")]) == 1
    assert "CONTACT at time 0.45" in capsys.readouterr().out
    scene.write_text(scene.read_text().replace("minor", "miner"))
    assert run(["check", str(scene)]) == 3 and "minor" in capsys.readouterr().err


def test_halved_nets_stay_as_near_their_surface_as_is_said():
    """Against de Casteljau's rule in fractions, of the same doubles; ends of cells are points of the surface."""
    bent = fc.RuledSurface("((u - 3)/(u + 2), 1/3 + u/7, u)", "(u/3, 2*u/(u + 3), 5/7)", u=(0, 1))
    nets = Nets(bent)
    (cell,) = nets.all()
    x = [[[F(c) for c in point] for point in side] for side in nets._homogeneous(cell[None])[0].tolist()]
    cells, exact, rng, worst = cell[None], x, np.random.default_rng(3), 0.0
    for _ in range(12):
        in_x, upper = rng.random() < 0.6, int(rng.random() < 0.5)
        cells = (nets._halves_in_x if in_x else nets._halves_in_s)(cells)[upper : upper + 1]
        if in_x:
            exact = [halved(side, upper) for side in exact]
        else:
            exact = list(zip(*(halved(list(pair), upper) for pair in zip(*exact, strict=True)), strict=True))
        points = nets.points(cells)[0]
        wanted = [[float(c / point[3]) for c in point[:3]] for side in exact for point in side]
        worst = max(worst, float(np.abs(points - wanted).max()))
    assert 0.0 < worst <= nets.off < 1e-12


@cache
def of_scale(s):
    stretch = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    motion = fc.RationalMotion([stretch, [[0, 0, 0, -8 * s], [0, 0, 0, -6 * s], [2, 0, 0, -5 * s], [0, 0, 0, 0]]])
    grown = [[s * (i == j) for j in range(4)] for i in range(3)] + [[0, 0, 0, 1]]
    solid = fc.paraboloid((1, 2), 1) | fc.ellipsoid((3, 3, 3)).translated((5, 2, 0))
    ring = fc.torus(2, 1).rotated((1, 0, 0), degrees=90).transformed(grown)
    return fc.first_contact(solid.translated((6, 2, -3)).transformed(grown).moving(motion), ring)


@pytest.mark.thorough
@pytest.mark.parametrize("scale", [F(1, 2**20), F(1, 1000), F(10**6)])
def test_scaled_bodies_meet_a_scaled_torus_just_then(scale):
    """Heights over the torus were in the unit of its own frame, those over the other solid in the world's."""
    found, plain = of_scale(scale), of_scale(1)
    assert found.status is plain.status is fc.Status.CONTACT
    assert found.time == pytest.approx(plain.time, abs=1e-12)
    assert found.point == pytest.approx(plain.point * float(scale), rel=1e-6)


@pytest.mark.share(6)
@pytest.mark.parametrize(
    "start, way", [((-1, 4, -1), (6, -12, 6)), ((0, 5, 0), (0, -10, 0)), ((0, 5, 2), (0, -10, -2))]
)
@pytest.mark.parametrize("swap", [False, True])
def test_a_trimmed_disc_beside_a_torus(start, way, swap):
    """A level disc meets a level section of the torus, a ring or a full disc; nothing of it was left at some cells."""
    disc = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", trim=["u**2 + (2*s - 1)**2 <= 1"], u=(-1, 1)).translated(start)
    pair = disc.moving(fc.Translation(way)), fc.torus(2, 1)
    found = fc.first_contact(*(pair[::-1] if swap else pair))
    t = np.linspace(0.0, 1.0, 200_001)
    x, y, z = (p + t * v for p, v in zip(start, way, strict=True))
    wide, far = np.sqrt(np.maximum(1.0 - z * z, 0.0)), np.hypot(x, y)
    met = t[(np.abs(z) <= 1.0) & (far - 1.0 <= 2.0 + wide) & (far + 1.0 >= 2.0 - wide)][0]
    assert found.status in (fc.Status.CONTACT, fc.Status.UNDECIDED) and met - 1e-2 < found.free_until <= met
    assert found.status is not fc.Status.CONTACT or met - 1e-5 < found.time <= met + 1e-9


def test_a_trimmed_surface_in_a_torus_at_the_start():
    """Without a corner that its inequalities leave."""
    bent = fc.RuledSurface(
        "(1 - 2*u, 2 + 2*u + u**2, 0)", "(3 + u + 2*u**2, 1 + 3*u - u**2, -1 + u + 2*u**2)",
        u=(-1, 1), trim=["u**2 + s**2 <= 1"],
    )  # fmt: skip
    found = fc.first_contact(bent.moving(fc.Translation((0, -7, 0))), fc.torus(2, 1))
    assert found.status is fc.Status.INITIAL_CONTACT and gap(found.point[None], 2, 1)[0] <= 1e-9


def halved(points, upper):
    """The control points of the lower or upper half."""
    kept = []
    while points:
        kept.append(points[-1] if upper else points[0])
        points = [[(a + b) / 2 for a, b in zip(p, q, strict=True)] for p, q in zip(points, points[1:], strict=False)]
    return kept[::-1] if upper else kept


@pytest.mark.share(2)
@pytest.mark.parametrize("turn", [fc.Translation((0, 0, -10)), fc.Screw((0, 0, 1), degrees=50, advance=-10)])
def test_elements_of_a_wide_enclosure_are_named(turn):
    """What a rough question leaves open at a contact is as large as its tolerance; the face that is met is told."""
    ring = fc.torus(2, "1/2").rotated((1, 0, 0), degrees=90).translated((0, 0, 9))
    for body, met in ((fc.box((2, 3, 4)), "z+"), (fc.cylinder(2, 3), "top"), (fc.sphere(2), "")):
        found = fc.first_contact(ring.moving(turn), body, tolerance=1e-3)
        assert found.status is fc.Status.CONTACT and found.element_a.kind == found.element_b.kind == "face"
        assert met in found.element_b.label


def test_a_ring_that_stays_close_to_a_peg_ends(monkeypatch):
    """It screws down a peg that nearly fills its hole, 1e-12 from it for half of the time: free, but only steps of time
    as small would prove it.  Looks are cut short here; without a limit there were millions."""
    monkeypatch.setattr(free, "MOST_LOOKS", 60)
    large, small, radius, height = F(23, 8), F(115, 64), F(1035, 1024), F(77, 16)
    aside = large - small - radius - F(1, 10**12)
    peg = fc.cylinder(radius, height).translated((aside, 0, height / 2 + small + 1))
    ring = fc.torus(large, small).moving(fc.Screw((0, 0, 1), degrees=180, advance=2 * small + 2))
    hit = fc.first_contact(ring, peg)
    assert (hit.status, hit.reason) == (fc.Status.UNDECIDED, "precision")
    assert 0 < hit.free_until < 1
