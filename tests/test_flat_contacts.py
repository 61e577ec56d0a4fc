"""Contacts along lines and planes: both paths give the same set, the same pairs and the same point."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.solid.carriers import Plane
from firstcontact.contact.models import certified
from firstcontact.contact.models import first as verbs
from firstcontact.contact.models.shared import flat_contacts
from firstcontact.contact.models.shared.touched import group, with_neighbours

BOX, DRUM, CONE = fc.box((1, 2, "3/2")), fc.cylinder("3/4", 2), fc.cone("3/4", 2)
LYING = DRUM.rotated((1, 0, 0), degrees=90)
ROOF = fc.box((1, 1, 1)).rotated((1, 0, 0), degrees=45)
GUTTER = DRUM & fc.half_space((1, 0, 0), 0)
FLOOR = fc.half_space((0, 0, 1), -3)
BALL = fc.sphere("1/2")
CAPSULE = fc.cylinder("1/2", "3/2") | BALL.translated((0, 0, "3/4")) | BALL.translated((0, 0, "-3/4"))
BULLET = fc.cylinder("1/2", "3/2") | BALL.translated((0, 0, "3/4"))
LYING_CAPSULE = CAPSULE.rotated((0, 1, 0), degrees=90)
SLOT = fc.box((2, 1, 1)) | fc.cylinder("1/2", 1).translated((1, 0, 0)) | fc.cylinder("1/2", 1).translated((-1, 0, 0))
KEY = SLOT - fc.cylinder("1/4", 2).translated((1, 0, 0))
EDGEWISE = BOX.rotated((0, 0, 1), degrees=45)
DRILLED = fc.box((4, 3, 1)) - fc.cylinder("1/2", 2)
ANGLE = DRILLED | fc.box((1, 3, 3)).translated((2, 0, 1))
CORNER = (fc.box((4, 4, 2)) - fc.box((4, 4, 4)).translated((2, 2, 0))).named("corner")
DRILLED_CORNER = CORNER - fc.cylinder("1/2", 4).translated((-1, -1, 0))
SCENES = {
    "box on box": (BOX, (0.3, 0.4, 6.0), BOX.translated((0.5, 0.1, 4)), "patch"),
    "boxes beside each other": (BOX, (6.0, 0.2, 0.1), BOX.translated((4, 0.3, -0.2)), "patch"),
    "box on the floor": (BOX, (0.5, 0.25, -6.0), FLOOR, "patch"),
    "drum on drum": (DRUM, (0.1, 0.2, 6.0), DRUM.translated((0.2, 0.3, 4)), "patch"),
    "drum on the floor": (DRUM, (0.3, 0.1, -6.0), FLOOR, "patch"),
    "drum on box": (DRUM, (0.1, 0.1, 6.0), BOX.translated((0.3, 0.2, 4)), "patch"),
    "parallel drums": (DRUM, (6.0, 0.5, 0.2), DRUM.translated((4, 0.2, 0.3)), "segment"),
    "lying drum on the floor": (LYING, (0.3, 0.1, -6.0), FLOOR, "segment"),
    "lying drum on box": (LYING, (0.1, 0.2, 6.0), BOX.translated((0.1, 0.3, 4)), "segment"),
    "drum against box": (BOX, (6.0, 0.1, 0.2), DRUM.translated((4, 0.3, 0.4)), "segment"),
    "roof on box": (ROOF, (0.1, 0.2, 6.0), BOX.translated((0.3, 0.4, 4)), "segment"),
    "roof against lying drum": (ROOF.rotated((0, 0, 1), degrees=90), (0.1, 0.2, -6.0),
                                LYING.translated((0.2, 0.3, -4)), "segment"),
    "capsule beside drum": (CAPSULE, (6.0, 0.5, 0.2), DRUM.translated((4, 0.2, 0.3)), "segment"),
    "capsule beside capsule": (CAPSULE, (6.0, 0.5, 0.2), CAPSULE.translated((4, 0.2, 0.3)), "segment"),
    "box against capsule": (BOX, (6.0, 0.1, 0.2), CAPSULE.translated((4, 0.3, 0.9)), "segment"),
    "capsule along an edge": (CAPSULE, (6.0, 0.1, 0.2), EDGEWISE.translated((4, 0.1, 0.9)), "segment"),
    "capsule on the floor": (LYING_CAPSULE, (0.3, 0.1, -6.0), FLOOR, "segment"),
    "capsule across box": (LYING_CAPSULE, (0.1, 0.2, 6.0), BOX.translated((0.6, 0.3, 4)), "segment"),
    "bullet on the floor": (BULLET, (0.3, 0.1, -6.0), FLOOR, "patch"),
    "lying bullet on the floor": (BULLET.rotated((0, 1, 0), degrees=90), (0.3, 0.1, -6.0), FLOOR, "segment"),
    "slot against an edge": (SLOT, (0.1, 6.0, 0.2), EDGEWISE.translated((0.3, 4, 0.4)), "segment"),
    "slot against slot": (SLOT, (6.0, 0.1, 0.2), SLOT.translated((5, 0.2, 0.4)), "segment"),
    "drilled plate beside its hole": (DRILLED, (0.1, 0.2, 6.0), BOX.translated((1.5, 0.3, 4)), "patch"),
    "lying drum beside a hole": (LYING, (0.1, 0.2, 6.0), DRILLED.translated((1, 0, 4)), "segment"),
    "angle on drilled plate": (ANGLE, (0.1, 0.2, -6.0), DRILLED.translated((-2, 1, -4)), "patch"),
    "box on a reentrant corner": (BOX, (0.1, 0.2, 6.0), DRILLED_CORNER.translated((0.3, 0.1, 4)), "patch"),
    "drums that come from afar": (DRUM.translated((-200, -100, 150)), (206.0, 100.5, -152.0),
                                  DRUM.translated((4, 0.2, 0.3)), "segment"),
    "drum along a side with round ends and a hole": (
        fc.cylinder("3/4", 1).rotated((0, 1, 0), degrees=90), (0.1, 6.0, 0.2), KEY.translated((0.1, 4, 0.3)), "segment"
    ),
    "drum along two parts in one plane": (DRUM, (0.1, -6.0, 0.2), ANGLE.translated((-1.6, -4, -0.8)), "segment"),
    "gutter on box": (GUTTER, (6.0, 0.1, 0.2), BOX.translated((4, 0.3, 0.4)), "patch"),
}  # fmt: skip


def pairs(hit) -> set[tuple[str, str]]:
    rest = [(str(p.element_a), str(p.element_b)) for p in hit.others]
    return {*rest, (str(hit.element_a), str(hit.element_b))}


@pytest.mark.share(16)
@pytest.mark.parametrize("name", SCENES)
def test_both_paths_tell_the_same(name, monkeypatch):
    a, vector, b, kind = SCENES[name]
    moving = a.moving(fc.Translation(vector))
    told = fc.first_contact(moving, b)
    assert told.stats.exact_evaluations == 0
    monkeypatch.setattr(certified, "_flat_set", lambda *_: None)
    exact = fc.first_contact(moving, b)
    assert exact.stats.exact_evaluations > 0
    assert told.contact_set == exact.contact_set == kind
    assert (told.element_a, told.element_b) == (exact.element_a, exact.element_b)
    assert told.multiplicity == exact.multiplicity and pairs(told) == pairs(exact)
    assert told.time == pytest.approx(exact.time, abs=1e-15) and np.allclose(told.normal, exact.normal, atol=1e-9)
    # arcs are sampled from elsewhere on, at 720 points of the circle
    is_round = len(told.contact_set.points) > 20
    near = 0.01 if is_round else 1e-9
    away = np.linalg.norm(told.contact_set.points[:, None] - exact.contact_set.points, axis=2)
    assert away.min(axis=0).max() < near and away.min(axis=1).max() < near
    assert is_round or np.allclose(told.point, exact.point, atol=1e-9)


def test_a_plane_through_the_origin_is_seen_to_go_on_a_round_end():
    """Its form has no terms there beside which what rounding leaves of the height would be small."""
    slot = SLOT.translated((0, "1/2", 0))
    number = next(f.index for f in slot.faces if not isinstance(f.carrier, Plane))
    seam = next(s for s in slot.seams if number in s.faces and all(abs(y) < 1e-9 for y in s.points([0.0])[:, 1]))
    x, _, z = seam.points([0.0])[0].tolist()
    met = with_neighbours(group(slot, (("face", number),)), (x, 7e-16, z))
    assert {f.feature.index for f in met[0].flats((x, 7e-16, z), (0.0, 1.0, 0.0))} == set(seam.faces)


@pytest.mark.parametrize("where", [(0, -1), (-1, 0)])
def test_an_edge_ends_at_a_reentrant_corner(where):
    """Its line runs on in the face: what touches that there touches no edge."""
    ball = fc.sphere(1).named("ball").translated((*where, 4)).moving(fc.Translation((0, 0, -4)))
    told, listed = fc.first_contact(ball, CORNER), fc.first_contact(ball, CORNER, method="algebraic")
    assert listed.time == 0.5 and told.time == pytest.approx(0.5, abs=1e-12)
    assert pairs(told) == pairs(listed) == {("ball.surface face 0", "corner.z+ face 5")}
    reasons = [c.reason for s in listed.subproblems for c in s.candidates if c.time == 0.5]
    assert "beyond the feature of corner" in reasons


def test_an_edge_is_touched_up_to_the_corner():
    ball = fc.sphere(1).translated((0, 1, 4)).moving(fc.Translation((0, 0, -4)))
    hit = fc.first_contact(ball, CORNER, method="algebraic")
    assert hit.element_b.kind == "edge" and hit.multiplicity == 2
    hit = fc.first_contact(ball.body.translated((0, -1, 0)).moving(ball.motion), CORNER, method="algebraic")
    assert hit.element_b.kind == "vertex" and hit.multiplicity == 4


@pytest.mark.parametrize("tilt", ["1/1000000000", "1/1000000000000"])
def test_nearly_parallel_is_not_parallel(tilt):
    """Faces a billionth off parallel touch in one edge or corner, and only exact arithmetic may say so."""
    tilted = fc.box((1, 1, 1)).transformed([[1, 0, 0, 0], [0, 1, 0, 0], [tilt, 0, 1, 0], [0, 0, 0, 1]])
    hit = fc.first_contact(tilted.moving(fc.Translation((0.1, 0.2, -6))), FLOOR)
    assert hit.contact_set == "segment" and hit.multiplicity == 2
    assert np.ptp(hit.contact_set.points[:, 0]) < 1e-9 and np.ptp(hit.contact_set.points[:, 1]) == pytest.approx(1)


@pytest.mark.share(3)
@pytest.mark.parametrize("tilt", ["1/1000000000", "-1/1000000000000"])
@pytest.mark.parametrize("name", ["floor", "box"])
def test_a_capsule_nearly_level_touches_in_one_point(name, tilt):
    """So near its seam that doubles do not tell its side from its end."""
    tilted = LYING_CAPSULE.transformed([[1, 0, 0, 0], [0, 1, 0, 0], [tilt, 0, 1, 0], [0, 0, 0, 1]])
    under = FLOOR if name == "floor" else fc.box((6, 6, 2)).translated((0, 0, -4))
    moving = tilted.moving(fc.Translation((0.1, 0.2, -6)))
    told, exact = fc.first_contact(moving, under), fc.first_contact(moving, under, exact=True)
    assert told.contact_set == exact.contact_set == "point" and told.stats.exact_evaluations > 0
    assert told.time == pytest.approx(exact.time, abs=1e-15) and pairs(told) == pairs(exact)
    assert np.allclose(told.point, exact.point, atol=1e-9)


def test_a_ruling_that_only_touches_a_round_cap_shares_a_point():
    moving = DRUM.rotated((0, 1, 0), degrees=90).moving(fc.Translation((0, 0, 6)))
    hit = fc.first_contact(moving, BULLET.translated((Fraction(-2, 7), "1/2", 4)))
    assert hit.contact_set == "point" and hit.time == pytest.approx(2.5 / 6, abs=1e-15)


def test_smooth_ends_beside_each_other_are_left_to_algebra():
    """Both segments end at one height, so more pairs meet there."""
    moving = CAPSULE.moving(fc.Translation((6, 0, 0)))
    hit = fc.first_contact(moving, CAPSULE.translated((4, 0, 0)))
    assert hit.contact_set == "segment" and hit.stats.exact_evaluations > 0
    assert pairs(hit) == pairs(fc.first_contact(moving, CAPSULE.translated((4, 0, 0)), exact=True))


def test_a_slot_lands_on_its_flat_side():
    """Its flat faces end at smooth seams, and half of each rim's circle is inside: algebra tells what is shared."""
    hit = fc.first_contact(SLOT.moving(fc.Translation((0.3, 0.1, -6))), FLOOR)
    assert hit.time == pytest.approx(2.5 / 6, abs=1e-15) and hit.contact_set == "patch" and hit.multiplicity == 6


def test_a_lying_drum_rests_on_a_round_plate():
    """Both ends of the segment are on the rim of the plate."""
    plate = fc.cylinder("1/2", 1).translated((0, 0, -4))
    hit = fc.first_contact(LYING.moving(fc.Translation((0.5, 0.25, -5))), plate)
    assert hit.time == pytest.approx((3.5 - 0.75) / 5, abs=1e-15) and hit.contact_set == "segment"
    assert np.hypot(*hit.contact_set.points[:, :2].T) == pytest.approx(0.5)
    assert hit.contact_set.points[:, 0] == pytest.approx(0.5 * hit.time)
    assert {str(hit.element_a), str(hit.element_b)} == {"side face 0", "rim.top edge 0"}


def test_a_proved_contact_overrules_a_later_one(monkeypatch):
    monkeypatch.setattr(certified, "_flat_set", lambda *_: None)
    monkeypatch.setattr(verbs, "contact_then", lambda *_: (None, None))
    late = fc.FirstContact(fc.Status.CONTACT, 0.75, (0.75, 0.75), free_until=0.75)
    monkeypatch.setattr(verbs, "_decided", lambda *_: late)
    hit = fc.first_contact(BOX.moving(fc.Translation((0.3, 0.4, 6.0))), BOX.translated((0.5, 0.1, 4)))
    assert hit.time == pytest.approx(5 / 12, abs=1e-15) and hit.contact_set is None


def test_a_proved_start_overrules_a_later_answer(monkeypatch):
    """Exact arithmetic once saw no contact where doubles had proved a common point."""
    decided = verbs._decided

    def blind(query, work):
        free = fc.FirstContact(fc.Status.FREE, free_until=query.span[1], **query.shared)
        return free if query.last != query.first else decided(query, work)

    monkeypatch.setattr(verbs, "_decided", blind)
    bowl = fc.paraboloid(1, 2)
    hit = fc.first_contact(bowl.moving(fc.Translation((0, 0, 5))), bowl.translated((0, 0, "1/2")))
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.time_interval == (0.0, 0.0)


CAP = DRUM.translated((0, 0, -1))
"""Its round cap is in the plane z = 0."""
ASIDE = CAP.translated(("1/4", "1/10", 0))
LEVEL = fc.cone(3, 4).transformed([["-3/5", 0, "4/5", 0], [0, 1, 0, 0], ["-4/5", 0, "-3/5", 0], [0, 0, 0, 1]])
"""The cone's half angle is atan(3/4), and its axis sinks by as much: the lowest ruling is level."""
TILT = [["2/3", "-1/3", "2/3", 0], ["2/3", "2/3", "-1/3", 0], ["-1/3", "2/3", "2/3", 0], [0, 0, 0, 1]]
ACROSS_A_CAP = {
    "through the middle": (LYING, (0, 0, -3), CAP),
    "beside the middle": (LYING, ("1/10", "1/5", -3), ASIDE),
    "oblique": (LYING.rotated((0, 0, 1), degrees=37), (0, "1/5", -3), ASIDE),
    "an oval cap": (LYING, (0, "1/5", -3), fc.cylinder((1, "1/2"), 2).translated(("1/10", 0, -1))),
    "half a cap": (LYING, ("1/10", 0, -3), ASIDE & fc.half_space((1, 1, 0), "1/2")),
    "a ruling of a cone": (LEVEL, ("1/10", "1/5", -3), ASIDE),
    "a cone with its apex on the cap": (LEVEL.translated(("5/2", 0, 0)), ("1/10", "1/5", -3), ASIDE),
}


@pytest.mark.share(2)
@pytest.mark.parametrize("tilted", [False, True], ids=["upright", "tilted"])
@pytest.mark.parametrize("name", ACROSS_A_CAP)
def test_algebra_sees_a_ruling_come_to_lie_across_a_round_cap(name, tilted):
    """Only the rim meets the cylinder then, and its plane cuts it in parallel lines at all times."""
    top, vector, cap = ACROSS_A_CAP[name]
    top = top.translated((0, 0, 3))
    if tilted:
        top, cap = top.transformed(TILT), cap.transformed(TILT)
        vector = [sum(Fraction(x) * Fraction(v) for x, v in zip(row, vector, strict=False)) for row in TILT[:3]]
    moving = top.moving(fc.Translation(vector))
    told, exact = fc.first_contact(moving, cap), fc.first_contact(moving, cap, exact=True)
    assert told.stats.exact_evaluations == 0 and told.contact_set == "segment"
    assert exact.contact_set == "segment" and exact.time == pytest.approx(told.time, abs=1e-15)
    away = np.linalg.norm(told.contact_set.points[:, None] - exact.contact_set.points, axis=2)
    assert away.min(axis=0).max() < 1e-9 and away.min(axis=1).max() < 1e-9


HALF = DRUM & fc.half_space((3, 1, 0), "1/10")
"""Its straight edges are no rational lines, and its corners' coordinates lie in quadratic fields."""


def test_a_segment_between_corners_of_different_fields():
    lying = HALF.rotated((0, 1, 0), degrees=90)
    hit = fc.first_contact(lying.moving(fc.Translation((0, 0, -6))), FLOOR, exact=True)
    assert hit.contact_set == "segment" and hit.multiplicity == 2
    assert np.ptp(hit.contact_set.points[:, 0]) == pytest.approx(2) and np.ptp(hit.contact_set.points[:, 1]) < 1e-9


def test_straight_edges_that_are_no_rational_lines_and_stay_parallel():
    other = HALF.rotated((0, 0, 1), degrees=90).translated((-4, 0, 0))
    moving = HALF.moving(fc.Translation((-6, "1/7", 0)))
    told, exact = fc.first_contact(moving, other), fc.first_contact(moving, other, exact=True)
    assert told.status is exact.status is fc.Status.CONTACT
    assert told.time == pytest.approx(exact.time, abs=1e-15) and told.contact_set == exact.contact_set == "segment"


def test_algebra_sees_a_cylinder_slide_onto_a_round_cap():
    """It rests on the plane of the cap: that is tangent at all times, and the ruling meets the rim in one point."""
    lying = LYING.translated((-3, 0, "3/4"))
    hit = fc.first_contact(lying.moving(fc.Translation((6, 0, 0))), CAP, exact=True)
    assert hit.time == 0.375 and hit.contact_set == "point"
    assert np.allclose(hit.point, (-0.75, 0, 0), atol=1e-15)
    upwards = lying.translated((3, 0, 0)).moving(fc.Translation((0, 0, 1)))
    assert fc.first_contact(upwards, CAP, exact=True).status is fc.Status.INITIAL_CONTACT


# -- bodies that turn, and keep a direction -------------------------------------------------------------------

LANDINGS = (
    "box on box", "boxes beside each other", "box on the floor", "drum on drum", "drum on the floor", "drum on box",
    "lying drum on the floor", "lying drum on box", "roof on box", "capsule on the floor", "capsule across box",
    "lying bullet on the floor",
)  # fmt: skip
ABOUT = (0.3, 0.2, 0.1)


def labels(hit) -> set[tuple[str, str]]:
    """Without numbers: turned models number their features anew."""
    return {(x.rsplit(" ", 1)[0], y.rsplit(" ", 1)[0]) for x, y in pairs(hit)}


@pytest.mark.parametrize("name", LANDINGS)
def test_what_lands_along_the_axis_of_a_screw_shares_what_it_does_turned_so_before(name):
    a, vector, b, kind = SCENES[name]
    axis = np.eye(3, dtype=int)[np.argmax(np.abs(vector))].tolist()
    advance = max(vector, key=abs)
    turned = a.rotated(axis, degrees=25, point=ABOUT)
    plain = fc.first_contact(turned.moving(fc.Translation([advance * x for x in axis])), b)
    screw = fc.Screw(axis, ABOUT, degrees=25 / plain.time, advance=advance)
    told = fc.first_contact(a.moving(screw), b)
    assert told.time == pytest.approx(plain.time, abs=1e-12) and told.contact_set == plain.contact_set == kind
    assert labels(told) == labels(plain) and told.multiplicity == plain.multiplicity
    is_round = len(told.contact_set.points) > 20
    near = 0.01 if is_round else 1e-9
    away = np.linalg.norm(told.contact_set.points[:, None] - plain.contact_set.points, axis=2)
    assert away.min(axis=0).max() < near and away.min(axis=1).max() < near


@pytest.mark.parametrize(("a", "b"), [
    (DRUM, DRUM.translated((0, 4, 0.3))), (BOX, DRUM.translated((0, 4, 0.3))), (BOX, CAPSULE.translated((0, 4, 0.9))),
])  # fmt: skip
def test_rulings_along_the_axis_of_a_turn(a, b):
    moving = a.translated((4, 0, 0)).moving(fc.Rotation((0, 0, 1), degrees=170))
    told, exact = fc.first_contact(moving, b), fc.first_contact(moving, b, exact=True)
    assert told.stats.exact_evaluations == 0 and told.contact_set == exact.contact_set == "segment"
    assert told.time == pytest.approx(exact.time, abs=1e-12) and pairs(told) == pairs(exact)
    assert (told.element_a, told.element_b) == (exact.element_a, exact.element_b)


def test_what_turning_bodies_share_only_by_chance_is_not_told():
    """Edges that are parallel at the instant of contact, as far as doubles tell; planes that two axes turn."""
    turned = ROOF.rotated((0, 0, 1), degrees=25, point=ABOUT).translated((0, 0, -4))
    time = (4 - 2**0.5) / 6
    hit = fc.first_contact(ROOF.moving(fc.Screw((0, 0, 1), ABOUT, degrees=25 / time, advance=-6)), turned)
    assert hit.time == pytest.approx(time, abs=1e-9) and hit.contact_set is None and hit.multiplicity == 1
    still = fc.Screw((1, 0, 0), ABOUT, degrees=1, advance=0.1)
    drop = fc.Screw((0, 0, 1), ABOUT, degrees=25, advance=-6)
    both = fc.first_contact(LYING.moving(drop), BOX.translated((0.3, 0.2, -4)).moving(still))
    assert both.status is fc.Status.CONTACT and both.contact_set != "segment"
    down = fc.Screw((0, 0, 1), (0, 1, 0), degrees=-40, advance=1)
    both = fc.first_contact(BOX.moving(drop), BOX.translated((0.3, 0.2, -4)).moving(down))
    assert both.time == pytest.approx(2.5 / 7, abs=1e-12) and both.contact_set == "patch"


SLOPE = fc.box((4, 4, 1)).transformed([[1, 0, 0, 0], [0, "4/5", "-3/5", 0], [0, "3/5", "4/5", 0], [0, 0, 0, 1]])
ACROSS = DRUM.rotated((0, 1, 0), degrees=90)
NEARLY_FULL = 360 + 1e-5
"""Degrees: doubles take for parallel what was so before."""


@pytest.mark.share(2)
@pytest.mark.parametrize("body", [SLOPE, ACROSS], ids=["face", "ruling"])
def test_what_lay_along_a_slope_does_not_after_nearly_a_full_turn(body):
    drop = [fc.Rotation((0, 0, 1), degrees=NEARLY_FULL), fc.Translation((0, 0, -4))]
    hit = fc.first_contact(body.translated((0, 0, 4)).moving(fc.Sequence(drop)), SLOPE)
    plain = fc.first_contact(body.translated((0, 0, 4)).moving(drop[1]), SLOPE)
    assert plain.contact_set in ("patch", "segment") and hit.time == pytest.approx((1 + plain.time) / 2, abs=1e-7)
    assert hit.contact_set is None and hit.multiplicity == 1


def test_parallel_rulings_are_not_so_after_nearly_a_full_turn():
    moved, other = ACROSS.translated((0, 0, 4)), ACROSS.translated((0.1, 0.3, 0))
    plain = fc.first_contact(moved.moving(fc.Translation((0, 0, -6))), other)
    screw = fc.Screw((0, 0, 1), degrees=NEARLY_FULL / plain.time, advance=-6)
    hit = fc.first_contact(moved.moving(screw), other)
    assert plain.contact_set == "segment" and hit.time == pytest.approx(plain.time, abs=1e-7)
    assert hit.contact_set is None and hit.multiplicity == 1


def test_what_is_nearly_across_the_axis_of_a_turn_is_not_across():
    tilted = LYING.transformed([[1, 0, 0, 0], [0, 1, 0, 0], [0, "1/10000000", 1, 0], [0, 0, 0, 1]])
    drop = tilted.moving(fc.Screw((0, 0, 1), ABOUT, degrees=25, advance=-6))
    table = fc.box((20, 20, 2)).translated((0, 0, -4))
    hit = fc.first_contact(drop, table.moving(fc.Translation((1, 0, 0))))
    assert hit.time == pytest.approx(2.25 / 6, abs=1e-7) and hit.contact_set is None and hit.multiplicity == 1
    for level in (FLOOR, table):  # the same from all around, as far as the drop comes: algebra takes the shift
        shifting = fc.first_contact(drop, level)
        assert shifting.time == pytest.approx(hit.time, abs=1e-12) and shifting.contact_set == "point"


@pytest.mark.share(3)
@pytest.mark.parametrize("where", [(2, 0, 0), (0, -2, 0), ("6/5", "8/5", 0)])
def test_equal_drums_beside_each_other_share_a_segment(where):
    """Their round rims touch in one point, which is no arc, wherever the samples of the rims are."""
    hit = fc.first_contact(fc.cylinder(1, 2), fc.cylinder(1, 2).translated(where))
    middle = [Fraction(x) / 2 for x in where]
    assert hit.initial == "touching" and hit.contact_set == "segment"
    ends = [[*map(float, middle[:2]), z] for z in (-1, 1)]
    assert sorted(hit.contact_set.points.tolist()) == [pytest.approx(end, abs=1e-15) for end in ends]


def test_equal_drums_on_each_other_touch_in_a_point_without_rounding():
    hit = fc.first_contact(fc.cylinder(1, 2), fc.cylinder(1, 2).translated((0, 0, 2)))
    assert hit.contact_set == "patch" and hit.point.tolist() == [0, -1, 1]


def test_what_is_clear_of_a_model_is_told_beside_its_box():
    """A rounding beyond the box is not clear of it; the box stays what it is."""
    plate = fc.box((4, 3, 1)) - fc.cylinder("1/2", 2)
    body = flat_contacts._Body(plate, [*flat_contacts.UPRIGHT, 0.0, 0.0, 0.0], False)
    for _ in range(2):
        assert not body.is_far((2 + 1e-15, 0, 0)) and body.is_far((2.001, 0, 0))
        low, high = plate.bounds()
        assert np.allclose([low, high], [[-2, -1.5, -0.5], [2, 1.5, 0.5]], rtol=0, atol=1e-12)


SEAT = fc.box((6, 6, 2)) - fc.frustum(1, 2, 1)
PLUGS = {
    "fills its seat": (fc.frustum(1, 2, 1), 7),
    "stands out of it": (fc.frustum(1, "5/2", "3/2"), 3),
    "touches the cone alone": (fc.frustum("5/4", "7/4", "1/2").translated((0, 0, "1/4")), 2),
}


@pytest.mark.share(3)
@pytest.mark.parametrize("name", PLUGS)
def test_the_pairs_of_a_plug_and_its_seat_are_the_same_whichever_is_named_first(name):
    """The rim at the seat's bottom lies in a plane through the origin: its height has no size to be measured by."""
    plug, count = PLUGS[name]
    plug, down, up = plug.translated((0, 0, 3)), fc.Translation((0, 0, -3)), fc.Translation((0, 0, 3))
    told = []
    for a, b in ((plug.moving(down), SEAT), (plug, SEAT.moving(up))):
        for hit, back in ((fc.first_contact(a, b), False), (fc.first_contact(b, a), True)):
            assert hit.time == 1 and hit.contact_set == "patch" and hit.multiplicity == count
            pairs = [(hit.element_a, hit.element_b), *((x.element_a, x.element_b) for x in hit.others)]
            told.append({tuple((x.kind, x.index) for x in (pair[::-1] if back else pair)) for pair in pairs})
    assert all(pairs == told[0] and len(pairs) == count for pairs in told)


def test_a_drum_lands_away_from_the_smooth_seam_of_a_face():
    """Seams matter where they are near alone; there algebra tells what is shared."""
    top = SLOT.rotated((1, 0, 0), degrees=90)  # its upper face joins round ends smoothly
    drum = fc.cylinder("1/8", 1).translated((0, 0, 3))
    for x, way in (("1/2", "in doubles"), ("15/16", "exactly, at the contact")):
        moving = drum.translated((x, 0, 0)).moving(fc.Translation((0, 0, -4)))
        hit, told = fc.first_contact(moving, top), fc.first_contact(moving, top, exact=True)
        assert hit.stats.ways[-1].way == way and hit.contact_set == "patch" == told.contact_set
        assert pairs(hit) == pairs(told) and hit.time == told.time
