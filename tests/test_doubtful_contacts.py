"""Contacts that no precision names: edges that land on edges, faces in one plane.  The time is certain though."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.polyhedra import intervals
from firstcontact.contact.polyhedra.doubts import Doubt, settled
from firstcontact.contact.polyhedra.intervals import MOST_LOOKS, MOST_WIDE
from firstcontact.contact.polyhedra.problems.problem import problem_of
from firstcontact.exact.numbers import Undecidable
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.motion.relative.pieces import curved_pieces

CUBE = fc.examples.box((1, 1, 1))
AXIS = (0, 0, 1)


def encloses(hit, time):
    lo, hi = hit.time_interval
    return lo <= time * (1 + 1e-15) and time * (1 - 1e-15) <= hi and hi - lo <= 1e-12


@pytest.mark.share(2)
@pytest.mark.parametrize("height", [0.25, 0.3, 0.9, "1/3"])
def test_an_edge_that_lands_on_an_edge(height):
    """By symmetry the inner edge of one cube comes to lie in that of the other."""
    hit = fc.first_contact(
        CUBE.translated((5, 0, 0)).moving(fc.Screw(AXIS, degrees=720, advance=1)), CUBE.translated((0, 5, height))
    )
    assert hit.status is fc.Status.CONTACT
    assert encloses(hit, math.degrees(math.atan2(4.5, 0.5) - math.atan2(0.5, 4.5)) / 720)
    assert np.allclose(hit.point[:2], (0.5, 4.5), atol=1e-9)


@pytest.mark.parametrize("degrees", [720, 700])
def test_faces_that_seat_flat_at_the_last_instant(degrees):
    nut = CUBE.translated((0.125, 0, 5)).moving(fc.Screw(AXIS, degrees=degrees, advance=-4))
    hit = fc.first_contact(nut, CUBE)
    assert hit.status is fc.Status.CONTACT and encloses(hit, 1.0)
    assert abs(hit.point[2] - 0.5) < 1e-9
    short = fc.first_contact(nut, CUBE, (0, "999999/1000000"))
    assert short.status is fc.Status.FREE


def test_bare_edges_that_stay_parallel_are_never_called_free():
    """Without facets nothing but the two edges themselves tells that they meet, half a turn on."""
    rod = fc.Polyhedron([[5, 0, 0], [5, 0, 1]], [], edges=[[0, 1]])
    other = fc.Polyhedron([[-5, 0, 0.25], [-5, 0, 1.25]], [], edges=[[0, 1]])
    hit = fc.first_contact(rod.moving(fc.Screw(AXIS, degrees=360, advance=1)), other)
    assert hit.status is not fc.Status.FREE and hit.free_until <= 0.5


def test_misses_by_a_hair_are_told_from_contacts():
    """Vertical edges pass a wall by 1e-9 on either side."""
    turn = fc.Screw(AXIS, degrees=90, advance=1)
    radius = math.hypot(5.5, 0.5)
    arm = CUBE.translated((5, 0, 0)).moving(turn)
    wall = fc.Polyhedron([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], [[0, 1, 2, 3]])
    near = fc.first_contact(arm, wall.translated((0, radius + 1e-9, 0)))
    assert near.status is fc.Status.FREE
    assert fc.first_contact(arm, wall.translated((0, radius - 1e-9, 0))).status is fc.Status.CONTACT


def test_prisms_meet_when_a_turn_says_so():
    """Prisms that share heights all the time: the screw meets when the turn without advance does, which is exact."""
    rng = np.random.default_rng(20261122)
    met = 0
    for k in range(amount(60)):
        ring, post = ([*rng.integers(1, 5, 2).tolist(), 0] for _ in range(2))
        sizes = [(*rng.integers(1, 4, 2).tolist(), 8) for _ in range(2)]
        arm, stop = (
            fc.examples.box(size).translated([x * sign for x, sign in zip(at, signs, strict=True)])
            for size, at, signs in zip(sizes, (ring, post), ((1, 1, 1), (-1, 1, 1)), strict=True)
        )
        turn, screw = fc.Rotation(AXIS, degrees=180), fc.Screw(AXIS, degrees=180, advance=1)
        expected, hit = (fc.first_contact(arm.moving(m), stop) for m in (turn, screw))
        assert hit.status is expected.status, (k, ring, post, sizes)
        if hit.status is fc.Status.CONTACT:
            met += 1
            assert encloses(hit, expected.time), (k, ring, post, sizes)
    assert met > 3


@pytest.mark.parametrize("other", [fc.Translation((-5, 0, 0)), fc.Rotation(AXIS, degrees=180, point=(3, 0, 0))])
def test_boxes_on_one_table(other):
    """Boxes that slide in one plane meet when one that stands out on both sides is met, which no plane confuses."""
    rng = np.random.default_rng(20261122)
    met = 0
    for k in range(amount(24)):
        (x, y), angle = rng.integers(1, 4, 2).tolist(), int(rng.integers(20, 170))
        turn = fc.Rotation(AXIS, degrees=angle)
        slider = fc.examples.box((x, y, 2)).translated((5, int(rng.integers(-2, 3)), 0)).moving(other)
        level, tall = (fc.examples.box((2, 1, height)).moving(turn) for height in (2, 3))
        expected, hit = (fc.first_contact(slider, b) for b in (tall, level))
        assert hit.status is expected.status is not fc.Status.UNDECIDED, (k, x, y, angle)
        if hit.status is fc.Status.CONTACT:
            met += 1
            assert encloses(hit, expected.time), (k, x, y, angle)
    assert met > 2


def test_flat_sheets_in_one_plane_are_never_called_free():
    """Sheets without thickness have no edges that leave their plane."""
    sheet = fc.Polyhedron([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])
    hit = fc.first_contact(
        sheet.translated((5, 0, 0)).moving(fc.Translation((-6, 0, 0))), sheet.moving(fc.Rotation(AXIS, degrees=40)),
        budget=2000,
    )  # fmt: skip
    assert hit.status in (fc.Status.CONTACT, fc.Status.UNDECIDED)
    assert hit.free_until < 0.75


# -- what is told of intervals where not all is decided: found by an outside tester -------------------------------


def octahedron_under_screw(degrees=-180):
    """It rises by 40 and turns; one corner is at distance 1 from the axis, the others are nearer."""
    corners = [("3/5", "4/5", 0), ("-1/2", 0, 0), (0, "-1/2", 0), (0, 0, "1/2"), (0, 0, "-1/2")]
    faces = [(0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4)]
    return fc.Polyhedron(corners, faces).moving(fc.Screw(AXIS, degrees=degrees, advance=40))


def blocks(*boxes):
    """One polyhedron of boxes (lo, hi)."""
    made = [fc.examples.box(np.subtract(hi, lo).tolist()).translated(np.add(lo, hi) / 2) for lo, hi in boxes]
    corners = np.concatenate([x.vertices for x in made])
    faces = np.concatenate([x.triangles + 8 * k for k, x in enumerate(made)])
    return fc.Polyhedron(corners, faces)


def ends(found):
    return [(x.start_interval, x.end_interval) for x in found]


def is_around(interval, time):
    return interval[0] - 1e-15 <= time <= interval[1] + 1e-15


def test_contact_by_containment_goes_on_where_a_graze_is_left_open():
    """Through a block, by heights alone from 1/16 to 17/80, and inside it for a while; then a corner grazes a wall."""
    wall = blocks(((-3, -3, 3), (3, 3, 8)), ((1, -3, 10), (2, 3, 30)))
    found = fc.contact_intervals(octahedron_under_screw(), wall)
    graze = 0.5 - math.atan2(4, 3) / math.pi + 0.0  # the corner turns from there to the direction of x
    assert found.status is fc.Status.UNDECIDED and found.reason == "precision"
    assert found.free_until == pytest.approx(math.atan2(4, 3) / math.pi, abs=1e-9) != graze
    ((start, end),) = ends(found)
    assert is_around(start, 1 / 16) and is_around(end, 17 / 80) and end[1] - end[0] < 1e-12


def test_what_is_inside_where_a_graze_is_left_open_may_go_on():
    """The graze is from within: nothing is told of the times after it."""
    hall = blocks(((-3, -3, 3), (1, 3, 20)), ((49, 49, 49), (51, 51, 51)))
    found = fc.contact_intervals(octahedron_under_screw(), hall)
    ((start, end),) = ends(found)
    assert found.status is fc.Status.UNDECIDED and is_around(start, 1 / 16)
    assert end[0] <= 0.5125 <= end[1] == 1.0


@pytest.mark.parametrize("degrees", [-180, -100])
def test_a_corner_passes_a_face_between_two_facets(degrees):
    """What touches before and after it does at one time, and the tip lands in the last instant."""
    found = fc.contact_intervals(
        octahedron_under_screw(degrees), blocks(((-3, -3, 3), (3, 3, 8)), ((-3, -3, 40.5), (3, 3, 50)))
    )
    assert found.status is fc.Status.CONTACT
    (start, end), last = ends(found)
    assert is_around(start, 1 / 16) and is_around(end, 17 / 80) and last == ((1.0, 1.0), (1.0, 1.0))


def test_a_coupler_that_is_inside_a_wall_for_a_while():
    """It moves by (2 cos a - 2, 2 sin a, 0), a = 150 t degrees, without turning: contact from sin a = 1/2 to its return
    there at the very end."""
    def box(lo, hi):
        return blocks((lo, hi))

    links = {"base": box((-9, -9, -9), (-8, -8, -8)), "crank": box((0, -0.125, 0), (2, 0.125, 0.25)),
             "coupler": box((2, -0.25, 0.5), (5, 0.25, 1))}  # fmt: skip
    joints = [fc.Joint("a", "revolute", "base", "crank"),
              fc.Joint("b", "revolute", "crank", "coupler", point=(2, 0, 0), mimic=("a", -1, 0))]  # fmt: skip
    coupler = fc.Mechanism(links, joints).course([0, 1], {"a": [0, 150]}).bodies["coupler"][0]
    found = fc.contact_intervals(coupler, box((-3, 1.25, 0), (8, 2, 2)))
    ((start, end),) = ends(found)
    assert found.status is fc.Status.CONTACT and is_around(start, 0.2) and is_around(end, 1.0)
    assert end[1] - end[0] < 1e-12


def test_a_gap_in_which_nothing_tells_whether_one_is_inside_is_open(monkeypatch):
    def untold(*_):
        raise Undecidable

    block = blocks(((-3, -3, 3), (3, 3, 8)), ((49, 49, 49), (51, 51, 51)))
    whole = fc.contact_intervals(octahedron_under_screw(), block)
    assert whole.status is fc.Status.CONTACT and is_around(ends(whole)[0][1], 17 / 80)
    monkeypatch.setattr(intervals, "contained_at", untold)
    found = fc.contact_intervals(octahedron_under_screw(), block)
    assert found.status is fc.Status.UNDECIDED and found.free_until <= 1 / 16 and not len(found)


def test_a_long_doubt_between_two_contacts_leaves_it_open_and_a_short_one_joins_them():
    def times(*pairs):
        return [tuple(RationalInstant(fmpq(x)) for x in pair) for pair in pairs]

    one = fmpq(1)
    two = times((0, fmpq(1, 4)), (fmpq(1, 2), fmpq(3, 4)))
    windows, open_from = settled(two, [Doubt(fmpq(1, 4), fmpq(1, 2), True)], one)
    assert [(x.value, y.value) for x, y in windows] == [(0, fmpq(1, 4))] and open_from == fmpq(1, 4)
    after = fmpq(1, 4) + fmpq(1, 10**15)
    short = times((0, fmpq(1, 4)), (after, fmpq(3, 4)))
    windows, open_from = settled(short, [Doubt(fmpq(1, 4), after, False)], one)
    assert [(x.value, y.value) for x, y in windows] == [(0, fmpq(3, 4))] and open_from is None


@pytest.mark.parametrize("looks, asked", [(0, MOST_WIDE), (MOST_LOOKS + 1, 1)])
def test_primitives_in_doubt_from_one_moment_to_the_next_are_in_doubt_for_long(monkeypatch, looks, asked):
    """Found by the soak: a case that turns flush on a plate; each moment alone was short, and 116 s went by."""
    ball = trimesh.creation.icosphere(2, 1.0)
    a, b = (fc.Polyhedron.from_trimesh(ball) for _ in "ab")
    a = a.moving(fc.Screw((0, 0, 1), (1, 0, 0), turns="1/3", advance=1))
    (piece,) = curved_pieces(a, b, fmpq(0), fmpq(1))
    problem, calls = problem_of(a, b, piece), []

    def in_doubt(problem, part_a, part_b):
        calls.append((part_a, part_b))
        problem.looks = looks
        ends = [fmpq(k, 10**13) for k in range(100)]
        return [], [Doubt(x, y, False) for x, y in pairwise(ends)]

    monkeypatch.setattr(intervals, "_windows_of", in_doubt)
    monkeypatch.setattr(intervals, "_is_within", lambda problem, span, known: False)
    found = intervals.contact_windows(problem, None, None)
    assert found.open == "precision" and len(calls) == asked
