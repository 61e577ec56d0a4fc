"""Models that are no unions of convex parts, under motions without exact equations: screws above all."""

from __future__ import annotations

import math
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.contact.models.certified import both_bounded
from firstcontact.kernels.convex.support import support
from firstcontact.kernels.events import event_search, feature_boxes, moving_forms
from firstcontact.kernels.workspace import workspace
from firstcontact.motion.relative.stretches import windows
from firstcontact.scene.load import load_scene
from firstcontact.search.convex.convex import covering_pieces
from firstcontact.search.events import events
from firstcontact.search.events.event_tables import tables_of
from firstcontact.search.events.events import first_event
from quadric_vectors import RATIONAL

SCENE = Path(__file__).parent / "data" / "pin_in_plate.toml"
PIN_TOUCHES = 0.67871408997


@pytest.fixture(scope="module")
def bodies():
    return load_scene(SCENE).bodies


def names(hit):
    return hit.element_a.label, hit.element_b.label


def width(hit):
    return hit.time_interval[1] - hit.time_interval[0]


# -- the pin under its screw ---------------------------------------------------------------------------------


def test_the_pin_touches_the_rim_of_the_counterbore(bodies):
    hit = fc.first_contact(bodies["pin"], bodies["plate"])
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(PIN_TOUCHES, abs=1e-11)
    assert names(hit) == ("pin.chamfer.side", "plate.counterbore.rim.top")
    assert hit.contact_set == "point" and 0 < width(hit) <= 1e-12 and hit.free_until == hit.time_interval[0]
    assert np.hypot(*hit.point[:2]) == pytest.approx(12, abs=1e-9) and hit.point[2] == pytest.approx(5, abs=1e-9)
    at = np.linalg.solve(bodies["pin"].motion(hit.time), np.append(hit.point, 1))
    normal = np.linalg.solve(bodies["pin"].motion(hit.time)[:3, :3], hit.normal)
    assert normal @ [at[0], at[1], 0] < 0  # towards the pin


def test_swapped_bodies_and_parts_of_the_span(bodies):
    pin, plate = bodies["pin"], bodies["plate"]
    hit, back = fc.first_contact(pin, plate), fc.first_contact(plate, pin)
    assert names(back) == names(hit)[::-1] and np.allclose(hit.normal, -back.normal, atol=1e-9)
    assert back.time == pytest.approx(hit.time, abs=1e-15)
    assert fc.first_contact(pin, plate, span=(0, hit.free_until - 1e-9)).status is fc.Status.FREE
    late = fc.first_contact(pin, plate, span=(0.5, 0.75))
    assert late.time == pytest.approx(hit.time, abs=1e-15) and width(late) <= 0.25e-12
    inside = fc.first_contact(pin, plate, span=(0.75, 1))
    assert inside.status is fc.Status.INITIAL_CONTACT


def test_a_larger_world_changes_nothing(bodies):
    size = 2.0**20
    pin, plate = (body.transformed(np.diag([size] * 3 + [1])) for body in (bodies["pin"].body, bodies["plate"]))
    motion = fc.Screw((0, "1/50", 1), (size, 0, 0), degrees=180, advance=-30 * size)
    hit = fc.first_contact(pin.moving(motion), plate)
    assert hit.time == pytest.approx(PIN_TOUCHES, abs=1e-11) and width(hit) <= 1e-12


def test_few_boxes_leave_it_undecided(bodies):
    hit = fc.first_contact(bodies["pin"], bodies["plate"], budget=100)
    assert hit.status is fc.Status.UNDECIDED and hit.reason == "budget" and hit.free_until < PIN_TOUCHES


# -- screws against samples ----------------------------------------------------------------------------------


def ring():
    return fc.cylinder(1, 1) - fc.cylinder("1/2", 2)


def drilled_ball():
    return fc.sphere(1) - fc.cylinder("1/3", 3)


def countersunk():
    return fc.box((2, 2, 1)) - fc.cone("3/4", "3/4").translated((0, 0, "-1/2"))


def waist():
    return fc.hyperboloid(["1/2", "1/2", 1], 1, sheets=1)


def bracket():
    return fc.box((2, 1, "1/2")) | fc.box(("1/2", 1, 2)).translated(("-3/4", 0, "3/4"))


SCREWS = [
    (ring, waist, fc.Screw((1, 0.25, 0.5), (0, 1, 0), degrees=250, advance=6)),
    (drilled_ball, bracket, fc.Screw((1, -0.125, 0.25), (0, 0.5, 1), degrees=120, advance=5)),
    (countersunk, drilled_ball, fc.Screw((1, 0.25, 0), (0, 0, 0.25), degrees=300, advance=5)),
    (lambda: fc.cone("1/2", 2), ring, fc.Rotation((0.25, 0, 1), (-1.5, -2, 0), degrees=200)),
    (waist, countersunk, fc.Sequence([fc.Translation((1, 0.25, 0)), fc.Screw((1, 0, 0.25), degrees=77, advance=4)])),
]


def samples(body):
    """Points of the faces and edges."""
    found = [body.to_mesh(0.03).vertices]
    found += [e.points(np.linspace(p.lo, p.hi, 30)) for e in body.edges for p in e.pieces if math.isfinite(p.hi - p.lo)]
    return np.concatenate(found)


def overlap_seen(a, motion, b, points, t):
    m = motion(t)
    there = points[0] @ m[:3, :3].T + m[:3, 3]
    return b.contains(there).any() or a.contains((points[1] - m[:3, 3]) @ np.linalg.inv(m[:3, :3]).T).any()


@pytest.mark.share(8)
@pytest.mark.parametrize(("make_a", "make_b", "motion"), SCREWS)
def test_screws_agree_with_samples(make_a, make_b, motion):
    turned = make_a().rotated((1, 2, 3), degrees=40).translated((-3, 0.125, 0.25))
    b = make_b().rotated((3, -1, 2), degrees=25)
    hit = fc.first_contact(turned.moving(motion), b)
    points = samples(turned), samples(b)
    assert hit.status in (fc.Status.CONTACT, fc.Status.FREE)
    last = hit.free_until if hit.status is fc.Status.FREE else hit.time
    assert not any(overlap_seen(turned, motion, b, points, t * last) for t in np.linspace(0, 1 - 1e-6, 40).tolist())
    if hit.status is fc.Status.CONTACT:
        assert width(hit) <= 1e-12 * motion.span[1]
        assert any(overlap_seen(turned, motion, b, points, hit.time + d) for d in (1e-4, 1e-3, 1e-2, 3e-2))


def test_a_ball_is_screwed_through_a_hole():
    plate = fc.box((4, 4, 1)) - fc.cylinder(1, 2)
    for radius, status in (("99/100", fc.Status.FREE), ("101/100", fc.Status.CONTACT)):
        ball = fc.sphere(radius).translated((0, 0, 3))
        hit = fc.first_contact(ball.moving(fc.Screw((0, 0, 1), degrees=500, advance=-6)), plate)
        assert hit.status is status
    height = math.sqrt(1.01**2 - 1)
    assert hit.time == pytest.approx((3 - 0.5 - height) / 6, abs=1e-12)
    assert hit.contact_set == "conic arc"  # all of the rim: round about the axis, the ball only falls


def test_an_opening_flush_with_a_face_is_no_face():
    """The plane of the lower face also cuts the cone: in the opening nothing is there."""
    needle = fc.box(("1/4", "1/4", 2)).translated(("3/10", "1/100", "-11/5"))
    hit = fc.first_contact(needle.moving(fc.Screw((0, 0, 1), degrees=100, advance=2)), countersunk().named("plate"))
    height = -0.5 + 0.75 - math.hypot(0.425, 0.135)  # of the cone where the outermost corner goes
    assert hit.time == pytest.approx((1.2 + height) / 2, abs=1e-12)
    assert hit.element_a.kind == "vertex" and hit.element_b.label.endswith("side")


# -- convex pieces that cover the models ---------------------------------------------------------------------


@pytest.mark.share(4)
@pytest.mark.parametrize("make", [ring, drilled_ball, countersunk, bracket])
def test_covering_pieces_hold_the_whole_body(make):
    """The support of the pieces is never less than what points of the body reach."""
    body = make().rotated((1, 2, 3), degrees=40)
    pieces, points = covering_pieces(body), samples(body)
    for n in np.random.default_rng(7).normal(size=(40, 3)):
        reach = max(support(pieces.array, i, *n)[0] for i in range(pieces.count))
        assert reach >= (points @ n).max() - 1e-9


@pytest.mark.share(3)
@pytest.mark.parametrize(("make", "radius"), [(ring, 1 / 2), (drilled_ball, 1 / 3)])
def test_a_needle_in_a_hole_that_is_covered(make, radius):
    """The covering pieces overlap from the start on."""
    body, needle = make(), fc.box(("1/8", "1/8", 4)).translated((0, 0, "1/2"))
    turning = fc.Screw((0, 0, 1), degrees=90, advance="1/8")
    assert fc.first_contact(needle.moving(turning), body).status is fc.Status.FREE
    hit = fc.first_contact(needle.moving(fc.Screw((1, 0, 0), degrees=5, advance=2)), body)
    assert hit.status is fc.Status.CONTACT and np.hypot(*hit.point[:2]) == pytest.approx(radius, abs=1e-9)


def test_what_is_not_asked_for_is_left_open():
    """Of times at which others are known to touch, covers alone tell nothing that a search would have to bear out."""
    plate, tip = fc.box((4, 4, 1)) - fc.cylinder("1/2", 2), fc.cone("1/4", 1).rotated((1, 0, 0), degrees=180)
    moving = tip.translated((0, "1/8", 3)).moving(fc.Translation((0, "1/2", -4)))
    known = first_event(moving, plate, fmpq(0), fmpq(1), 1e-12, 100_000)
    told = first_event(moving, plate, fmpq(0), fmpq(1), 1e-12, 100_000, enough=fmpq(1, 4))
    assert (known.status, told.status, told.reason) == ("contact", "open", "precision")
    assert 0.25 <= told.free_until < known.time


def test_covers_and_events_agree():
    """Where covering pieces touch at a point of the models, the search for events finds the same."""
    plate = fc.box((4, 4, 1)) - fc.cylinder("1/2", 2)
    tilted = bracket().rotated((1, 2, 3), degrees=40).translated((1, 1, 3))
    moving = tilted.moving(fc.Screw((0, 0, 1), degrees=90, advance=-4))
    told = first_event(moving, plate, fmpq(0), fmpq(1), 1e-12, 100_000)
    assert told.complete
    parts = windows(moving, plate, fmpq(0), fmpq(1))
    search = events.EventSearch(moving, plate, tables_of(tilted, plate), parts, 1e-12, 100_000)
    found = search.run(0.0, fmpq(1))
    assert found.status == told.status == "contact" and not found.complete
    assert found.time == pytest.approx(told.time, abs=1e-13) and np.allclose(found.point, told.point, atol=1e-9)
    assert (found.features_a, found.features_b) == (told.features_a, told.features_b)
    assert np.allclose(found.normal, told.normal, atol=1e-9)


def test_a_jump_into_the_material_is_not_free():
    here = [[1, 0, 0, "3/4"], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    slow = [[0, 0, 0, "1/100"], [0] * 4, [0] * 4, [0] * 4]
    motion = fc.Sequence([fc.Translation((0, 0, "1/100")), fc.RationalMotion([here, slow])])
    hit = fc.first_contact(fc.sphere("1/8").moving(motion), ring())
    assert hit.status is not fc.Status.FREE and hit.free_until <= 0.5


# -- the known answers, by this path alone -------------------------------------------------------------------

CHOSEN = [
    "paper_example7", "ellipsoid_affine_growth_sphere", "cone_apex_plane", "box_box_edge_edge", "degree4_edge_sphere",
    "box_side_cylinder_on_table", "capsule_capsule", "sphere_sphere_near_miss_1e-9", "parallel_elliptic_cylinders_spin",
]  # fmt: skip


@pytest.mark.share(2)
@pytest.mark.parametrize("vector", [v for v in RATIONAL if v.name in CHOSEN], ids=lambda v: v.name)
def test_known_answers(vector):
    a, b = vector.bodies
    found = first_event(*both_bounded((a, b), (0, 1)), fmpq(0), fmpq(1), 1e-12, 100_000)
    assert found.status == ("contact" if vector.contact else "free")
    if vector.contact:
        lo, hi = found.time_interval
        assert lo <= float(vector.time) <= hi and hi - lo <= 1e-12


# -- models of forms over boxes ------------------------------------------------------------------------------


@pytest.mark.share(2)
@pytest.mark.parametrize("slab", [(0.25, 0.3125), (0.678, 0.679)])
def test_models_hold_the_forms_they_stand_for(bodies, slab):
    """Values and derivatives of moving surfaces at random points of random boxes, against plain NumPy."""
    pin, plate = bodies["pin"], bodies["plate"]
    t = tables_of(pin.body, plate)
    window = windows(pin, plate, fmpq(0), fmpq(1))[0]
    models, table = np.zeros((3, moving_forms.MODELS)), t.table.copy()
    z = np.zeros((feature_boxes.ROWS, feature_boxes.WIDTH))
    assert event_search.place_slab(
        *slab, window.a, window.b, t.raw, t.kinds, t.units, t.layout, workspace()[0], models, table, z
    )
    rng = np.random.default_rng(5)
    e, row = z[feature_boxes.ZEROTH :], z[feature_boxes.SLAB]
    checked = 0
    for box in rng.permutation(t.still)[:60]:
        k = int(box[0])
        side, base = int(t.info[k, 0]), int(t.layout[t.info[k, 0], 1])
        scale = 2.0 ** -rng.integers(0, 8)
        u, hu, v, hv = box[2], box[3] * scale, box[4], box[5] * scale
        s, hs = rng.uniform(-0.5, 0.5), 0.5 * scale
        if not feature_boxes.place_box(t.charts, k, u, hu, v, hv, 0.0, 0.0, z):
            continue
        for f in range(int(t.layout[1 - side, 7])):
            feature_boxes.model(table, base + f, s, hs, z, np.int64(2), feature_boxes.ZEROTH)
            for a, b, c in rng.uniform(-1, 1, size=(4, 3)):
                time = row[0] + row[1] * (s + hs * c)
                true = plain(t, pin, side, f, k, u, hu, v, hv, a, b, time)
                for n in range(3):
                    linear = e[n, 0] + e[n, 1:4] @ [a, b, c]
                    assert abs(true[n] - linear) <= e[n, 4] + 1e-12
                    checked += 1
    assert checked > 3000


def plain(t, pin, side, f, k, u, hu, v, hv, a, b, time):
    """The form, and its halved derivatives (a plane's whole ones), by a and b."""
    p, q = u + hu * a, v + hv * b
    c = t.charts[k, :24].reshape(6, 4)
    point = np.array([1, p, q, p * p, p * q, q * q]) @ c
    by_a = hu * (np.array([0, 1, 0, 2 * p, q, 0]) @ c)
    by_b = hv * (np.array([0, 0, 1, 0, p, 2 * q]) @ c)
    frame = [np.array([[*(r[3] * e), x] for e, x in zip(np.eye(3), r[:3], strict=True)] + [[0, 0, 0, 1]])
             for r in t.units]  # fmt: skip
    pose = pin.motion(time)
    there = np.linalg.inv(frame[1]) @ pose @ frame[0] if side == 0 else np.linalg.inv(pose @ frame[0]) @ frame[1]
    points = [there @ z * np.sign(point[3]) for z in (point, by_a, by_b)]
    form = t.raw[t.layout[1 - side, 6] + f]
    if t.kinds[t.layout[1 - side, 6] + f] == 0:
        return [form[:4] @ z for z in points]
    return [points[0] @ form.reshape(4, 4) @ z for z in points]


def test_a_slab_that_takes_the_middle_out_of_a_bowl_leaves_a_small_tip():
    bowl = fc.paraboloid(1, 11) - fc.cylinder(9, "1/2").translated((F(-5, 6), F(1, 8), F(313, 576)))
    point = fc.Polyhedron([(F(23, 6), F(19, 24), F(1561, 576))], []).moving(fc.Translation((-11, -2, -8)))
    lo, hi = fc.first_contact(point, bowl).time_interval
    for t, outside in ((F(lo), True), (F(hi), False)):  # into the lower side of the slab that was taken out
        x, y, z = F(23, 6) - 11 * t, F(19, 24) - 2 * t, F(1561, 576) - 8 * t
        assert (x * x + y * y > z or z > F(313, 576) - F(1, 4)) == outside


@pytest.mark.share(3)
@pytest.mark.parametrize(("deep", "upside_down"), [(0, False), (1, True), (-1, False), ("1/2", True)])
def test_a_conical_hole_whose_absent_tip_is_level_with_a_face(deep, upside_down):
    """A frustum from radius 1 to 1/2 in a plate of height 2: its cone's tip lies 1 beyond the narrow end.

    The pin goes down and aside; its lower rim meets the wall of the hole, or its end lands on the plate.
    """
    hole = fc.frustum(1, "1/2", 1)
    hole = (hole.rotated((1, 0, 0), degrees=180) if upside_down else hole).translated((0, 0, deep))
    plate = fc.box((8, 8, 2)) - hole
    down = fc.Screw((0, 0, 1), point=(1, 0, 0), degrees=40, advance=-5)
    hit = fc.first_contact(fc.cylinder("1/4", 2).translated((0, 0, 4)).moving(down), plate)
    if deep == 1 and upside_down:
        lo, hi = 0.4, 0.6
        for _ in range(60):
            t = (lo + hi) / 2
            room = (1 + (3 - 5 * t)) / 2 - 0.25  # of the pin's axis at the height of its end
            lo, hi = (t, hi) if 2 * math.sin(math.radians(20 * t)) < room else (lo, t)
        assert hit.time == pytest.approx(lo, abs=1e-11) and hit.element_b.label == "side"
    else:
        assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(0.4, abs=1e-11)
