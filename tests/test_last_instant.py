"""Bodies that land at the last instant of the span, in poses without rational numbers."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from firstcontact.contact.models.last_instant import near_pose
from firstcontact.exact.numbers import precision
from firstcontact.exact.rigid import apply
from firstcontact.search.convex.close_up import CloseUp

Z = (0, 0, 1)
PLATE = fc.box((6, 6, 2)).named("plate")
BRICK = fc.box((1, 2, 2)).named("brick")
ON_ITS_CORNER = [["2/3", "-1/3", "2/3", 0], ["2/3", "2/3", "-1/3", 0], ["-1/3", "2/3", "2/3", 0], [0, 0, 0, 1]]
RING = fc.box((5, 5, 2)) - fc.cylinder(1, 4)
LEVER = fc.box((4, 1, 1)).translated((3, 0, 1))
SCENES = {
    "flat": (BRICK.translated((1, 0, 4)), fc.Screw(Z, degrees=77, advance=-2), PLATE, "patch"),
    "radians": (BRICK.translated((1, 0, 4)), fc.Screw(Z, (1, 1, 1), radians=1.25, advance=-2), PLATE, "patch"),
    "on a smaller one": (fc.box((5, 5, 2)).translated((0, 0, 4)), fc.Screw(Z, turns=3, advance=-2),
                         fc.box((1, 1, 2)), "patch"),
    "on a corner": (fc.box((1, 2, 2)).transformed(ON_ITS_CORNER).translated((1, 0, "7/2")),
                    fc.Screw(Z, degrees=77, advance=-1), PLATE, "point"),
    "ring on ring": (RING.translated((0, 0, 4)), fc.Screw(Z, degrees=77, advance=-2),
                     PLATE - fc.cylinder("3/2", 4), "patch"),
    "slanting": (BRICK.translated((0, 0, 1)), fc.Screw((0, 3, -4), degrees=77, advance=1),
                 fc.half_space((0, -3, 4), -8), "segment"),
    "a quarter turn": (LEVER, fc.Screw((0, 1, 0), degrees=90, advance="1/8"),
                       fc.box((1, 6, 6)).translated((0, 0, -8)), "segment"),
}  # fmt: skip


@pytest.mark.share(3)
@pytest.mark.parametrize("name", SCENES)
def test_landing(name):
    body, motion, other, kind = SCENES[name]
    hit, back = fc.first_contact(body.moving(motion), other), fc.first_contact(other, body.moving(motion))
    for found in (hit, back):
        assert found.status is fc.Status.CONTACT and found.time == 1.0 and found.contact_set == kind
        assert found.time_interval[1] == 1.0 and found.time_interval[1] - found.time_interval[0] < 1e-12
    assert labels(hit) == {(b, a) for a, b in labels(back)} and len(labels(hit)) == hit.multiplicity
    assert hit.a.motion is motion


def labels(hit) -> set[tuple[str, str]]:
    first = hit.element_a, hit.element_b
    return {(a.label, b.label) for a, b in (first, *((p.element_a, p.element_b) for p in hit.others))}


def test_a_body_that_turns_beside_one_that_rises():
    hit = fc.first_contact(BRICK.translated((0, 0, 4)).moving(fc.Rotation(Z, degrees=77)), PLATE.moving(
        fc.Translation((0, 0, 2))
    ))  # fmt: skip
    assert hit.status is fc.Status.CONTACT and hit.time == 1.0 and hit.point[2] == pytest.approx(3)


@pytest.mark.share(2)
@pytest.mark.parametrize("sign, status", [(1, fc.Status.CONTACT), (-1, fc.Status.FREE)])
@pytest.mark.parametrize("digits", [20, 100])
def test_what_lands_nearly(sign, status, digits):
    """Also beyond the digits of the balls: as meshes, and where the plate rests, and so is the same from all around."""
    brick = BRICK.translated((0, 0, 4)).moving(fc.Screw(Z, degrees=77, advance=-2 - sign * F(1, 10**digits)))
    hit = fc.first_contact(brick, PLATE.moving(fc.Translation((1, 0, 0))))
    assert hit.status is status and 1 - 1e-12 < hit.free_until
    assert fc.first_contact(brick, PLATE).status is status


ENDING = {
    "trajectory": lambda way: fc.Trajectory(
        [0, 1], [np.eye(4).tolist(), [[*np.eye(4)[i, :3].tolist(), w] for i, w in enumerate((*way, 1))]]
    ),
    "sequence": lambda way: fc.Sequence([fc.Translation(way)]),
    "steps": lambda way: fc.Sequence([fc.Translation([F(c) / 2 for c in way])] * 2),
    "screw": lambda way: fc.Sequence([fc.Screw(way, degrees=360, advance=F(way[0]))]),
}
HOLED = {
    "ball": fc.sphere(1) - fc.cylinder("1/4", 9),
    "block": fc.box((2, 2, 2)) - fc.cylinder("1/4", 9),
    "bowl": fc.sphere(1) - fc.ellipsoid((12, 9, 10)).translated((12, 0, 0)),
}
TIP = fc.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
LANDERS = {"mesh": TIP, "ball": fc.sphere(1), "box": fc.box((2, 1, 1)),
           "open mesh": fc.Polyhedron([(1, 0, 0), (-3, 1, 0), (-3, -1, 1)], [[0, 1, 2]])}  # fmt: skip


@pytest.mark.share(10)
@pytest.mark.parametrize("ending", ENDING)
@pytest.mark.parametrize("lander", LANDERS)
@pytest.mark.parametrize("other", HOLED)
def test_a_motion_ends_in_contact_with_a_solid_with_a_hole(lander, other, ending):
    """All landers reach to x = 1, then to x = -1, where the others begin; there is no pose after that.  A step less
    far misses."""
    body = LANDERS[lander].translated((-20, 0, 0))
    hit = fc.first_contact(body.moving(ENDING[ending]((18, 0, 0))), HOLED[other])
    assert hit.status is fc.Status.CONTACT and hit.time == 1.0 and hit.time_interval[1] == 1.0
    short = fc.first_contact(body.moving(ENDING[ending]((F(18) - F(1, 10**9), 0, 0))), HOLED[other])
    assert short.status is fc.Status.FREE


def test_nothing_is_proved_of_a_last_instant_in_which_bodies_touch(monkeypatch):
    """Balls cut the last 1e-15 of the span into sixty parts, in half a second, before algebra was asked."""
    proofs = []
    holds = CloseUp._holds_at_once
    monkeypatch.setattr(CloseUp, "_holds_at_once", lambda *given: proofs.append(1) or holds(*given))
    box = fc.box((2, 8, 9)).transformed([
        [F(-31, 51), F(-14, 51), F(38, 51), F(63, 34)], [F(-14, 51), F(-206, 255), F(-133, 255), F(227, 17)],
        [F(38, 51), F(-133, 255), F(106, 255), F(-26, 17)], [0, 0, 0, 1],
    ])  # fmt: skip
    bowl = fc.hyperboloid((F(9, 10), F(9, 10), 2), F(35, 8), sheets=2).translated((1, F(33, 40), F(-1, 2)))
    hit = fc.first_contact(box.moving(fc.Translation((F(-5, 2), -6, 3))), bowl)
    assert hit.status is fc.Status.CONTACT and hit.time == 1.0
    assert (hit.element_a.kind, hit.multiplicity) == ("vertex", 1)
    assert len(proofs) < 4


SHEET = fc.Polyhedron([(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], [[0, 1, 2, 3]])
ABOVE = {
    "stud": fc.cylinder("1/2", 1).translated((1, 0, "5/2")), "ball": fc.sphere(1).translated((1, 0, 3)),
    "tip": fc.cone(1, 1).rotated((1, 0, 0), degrees=180).translated((1, 0, 3)),
    "holed": (fc.cylinder(1, 1) - fc.cylinder("1/4", 2)).translated((1, 0, "5/2")),
}  # fmt: skip


@pytest.mark.share(4)
@pytest.mark.parametrize("name", ABOVE)
def test_a_screw_ends_in_contact_with_a_mesh(name):
    """In a pose without rational numbers it was left open; a nearby one tells, as what is round or clear stays so."""
    for advance, status in ((-2, fc.Status.CONTACT), (F(-2) + F(1, 10**9), fc.Status.FREE)):
        moving = ABOVE[name].moving(fc.Screw(Z, degrees=77, advance=advance))
        for hit in (fc.first_contact(moving, SHEET), fc.first_contact(SHEET, moving)):
            assert hit.status is status
            if status is fc.Status.CONTACT:
                assert hit.time == 1.0 == hit.time_interval[1] and abs(hit.point[2]) < 1e-12
        found = fc.contact_intervals(moving, SHEET)
        assert found.status is status and all(x.end_interval == (1.0, 1.0) and x.start > 1 - 1e-12 for x in found)
    assert fc.first_contact(SHEET.moving(fc.Screw(Z, degrees=77, advance=2)), ABOVE[name]).time == 1.0


PIN_POINT = [(1, 0, -2), (2, -1, -3), (2, 1, -3), (0, 0, -4)]
SIDES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
PIN = fc.Polyhedron(PIN_POINT, SIDES)
TWO_PINS = fc.Polyhedron(
    [*PIN_POINT, *((x, y, z - 20) for x, y, z in PIN_POINT)], [*SIDES, *([i + 4 for i in t] for t in SIDES)]
)


@pytest.mark.parametrize("pin", [PIN, TWO_PINS])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_point_that_lands_on_an_edge_only_where_the_pose_is_rounded(pin, sign):
    """A pin's point comes to (cos 77, sin 77, 0) from below, and the edge of a disc stands at the rational place that
    the pose beside that one gives the point: it touches beside the edge or misses by less than 2^-60."""
    turning = pin.moving(fc.Screw(Z, degrees=77, advance=2))
    x, y, z = (F(int(c.p), int(c.q)) for c in apply(near_pose(turning, fmpq(1))[0], [*map(fmpq, PIN_POINT[0])]))
    disc = fc.cylinder(1, 2).translated((x + sign, y, 1))
    with precision(200):
        sine, cosine = arb.sin_cos_pi_fmpq(fmpq(77, 180))
        away = (ball(x + sign) - cosine) ** 2 + (ball(y) - sine) ** 2 - 1
    assert z == 0 and (away > 0 or away < 0) and abs(away) < 2.0**-55
    truth = fc.Status.FREE if away > 0 else fc.Status.CONTACT
    for pair in ((turning, disc), (disc, turning)):
        found = fc.first_contact(*pair)
        assert found.status in (truth, fc.Status.UNDECIDED) and found.free_until > 1 - 1e-12


def ball(x: F) -> arb:
    return arb(fmpq(x.numerator, x.denominator))


TABLE = fc.box((60, 60, 5)).translated((0, 0, "-5/2"))
HOLED_TABLE = TABLE - fc.cylinder(1, 50).translated((20, 20, 0))
STANDING = {
    "tube": ((fc.cylinder(2, 1) - fc.cylinder(1, 3)).translated((0, 0, "1/2")), TABLE),
    "block": (fc.box((2, 2, 1)).translated((0, 0, "1/2")), HOLED_TABLE),
    "pin": (fc.cylinder(1, 1).translated((0, 0, "1/2")), HOLED_TABLE),
    "tip": (fc.paraboloid((1, 1), 1), HOLED_TABLE),
}
"""Bodies with their lowest points in z = 0, and tables whose tops are there."""
DOWN = {
    "screw": (fc.Screw(Z, (1, 1, 0), degrees=123, advance=-1), None),
    "full turn": (fc.Screw(Z, (1, 1, 0), turns=1, advance=-1), None),
    "beside a slide": (fc.Screw(Z, (1, 1, 0), degrees=123, advance=-1), fc.Translation(("3/8", "1/4", 0))),
    "after a turn": (fc.Sequence([fc.Rotation(Z, degrees=33), fc.Translation((0, 0, -1))]), None),
}
"""All of height 1 - t at the end, that of the table."""


@pytest.mark.share(12)
@pytest.mark.parametrize("way", DOWN)
@pytest.mark.parametrize("name", STANDING)
def test_a_landing_in_the_last_instant_is_not_free(name, way):
    """Balls that know the event to be the end itself took it for none before the end."""
    (body, table), (motion, slide) = STANDING[name], DOWN[way]
    a, b = body.translated((0, 0, 1)).moving(motion), table if slide is None else table.moving(slide)
    for pair in ((a, b), (b, a)):
        hit = fc.first_contact(*pair)
        assert hit.status is not fc.Status.FREE
        assert hit.free_until <= 1
        if way != "after a turn":  # its pose before the last step is irrational
            assert (hit.status, hit.time) == (fc.Status.CONTACT, 1)
