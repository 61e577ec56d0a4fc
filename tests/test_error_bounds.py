"""Error bounds attacked: answers that hang on 2^-30 .. 2^-60, where plain doubles say anything.

Each scene has an answer known by hand.  It is asked as it stands, and again after a common rational motion of
the whole scene that fills every coordinate with digits.
"""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

import firstcontact as fc
import naive
from agreement import assert_same_first_contact, question
from generators import Scene
from vectors import Body

BITS = pytest.mark.parametrize("bits", [30, 36, 42, 48, 52, 56, 60])
SIDES = pytest.mark.parametrize("side", [-1, 0, 1], ids=["below", "tie", "above"])
POSES = pytest.mark.parametrize("posed", [False, True], ids=["as is", "turned"])

# (1, 2, 2) / 3 and its fellows are orthonormal and rational: a rotation, then a shift.
ROWS = ((1, 2, 2), (2, 1, -2), (-2, 2, -1))
SHIFT = (Fraction(7, 5), Fraction(-11, 3), Fraction(1, 7))


def turned(v):
    return [sum(Fraction(m, 3) * Fraction(x) for m, x in zip(row, v, strict=True)) for row in ROWS]


def posed_body(body: Body) -> Body:
    return Body([[x + d for x, d in zip(turned(p), SHIFT, strict=True)] for p in body.v], body.e, body.f)


def pose_scene(scene: Scene) -> Scene:
    a, b = posed_body(scene.a), posed_body(scene.b)
    if scene.translation is not None:
        return Scene(a, b, translation=tuple(turned(scene.translation)), until=scene.until)
    assert scene.rotation is not None
    point = [x + d for x, d in zip(turned(scene.rotation["point"]), SHIFT, strict=True)]
    return Scene(
        a,
        b,
        rotation={**scene.rotation, "axis": turned(scene.rotation["axis"]), "point": point},
        until=scene.until,
    )


def assert_status(scene: Scene, hits: bool, posed: bool) -> None:
    if posed:
        scene = pose_scene(scene)
    assert (assert_same_first_contact(scene) == naive.CONTACT) == hits


def hair(bits: int, side: int) -> Fraction:
    return Fraction(side, 2**bits)


TRIANGLE = Body([[-1, 0, 2], [1, 0, 2], [0, 3, 3]], [], [[0, 1, 2]])
UP = (0, 0, 1)
ABOUT_Z = {"axis": (0, 0, 1), "point": (0, 0, 0), "turns": 1}


def test_the_pose_is_a_rotation():
    assert [sum(x * y for x, y in zip(r, s, strict=True)) for r in ROWS for s in ROWS] == [
        9,
        0,
        0,
        0,
        9,
        0,
        0,
        0,
        9,
    ]
    p, q, r = ROWS
    cross = (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])
    assert sum(x * y for x, y in zip(cross, r, strict=True)) == 27


@POSES
@SIDES
@BITS
def test_vertex_beside_the_side_of_a_face(bits, side, posed):
    vertex = Body([[Fraction(1, 3), hair(bits, side), 0]], [], [])
    assert_status(Scene(vertex, TRIANGLE, translation=UP), side >= 0, posed)


@POSES
@SIDES
@BITS
def test_edge_beside_the_end_of_an_edge(bits, side, posed):
    moving = Body([[-1, 0, 0], [1, 0, 0]], [[0, 1]], [])
    resting = Body([[Fraction(1, 3), -hair(bits, side), 2], [Fraction(1, 3), 5, 4]], [[0, 1]], [])
    assert_status(Scene(moving, resting, translation=UP), side >= 0, posed)


@POSES
@SIDES
@BITS
def test_end_of_the_span_beside_the_contact(bits, side, posed):
    vertex = Body([[0, Fraction(1, 2), 0]], [], [])
    time = 2 + Fraction(1, 6)
    scene = Scene(vertex, TRIANGLE, translation=UP, until=time + hair(bits, side))
    assert_status(scene, side >= 0, posed)


@POSES
@SIDES
@BITS
def test_which_of_two_contacts_is_first(bits, side, posed):
    """Two vertices below one face: vertex 1 is a hair higher or lower than vertex 0."""
    plate = Body([[-9, -9, 1], [9, -9, 1], [0, 9, 1]], [], [[0, 1, 2]])
    pair = Body([[-1, 0, 0], [1, 0, hair(bits, side)]], [], [])
    scene = Scene(pair, plate, translation=UP)
    if posed:
        scene = pose_scene(scene)
    assert_same_first_contact(scene)
    hit = fc.first_contact(*question(scene))
    assert hit.element_a.index == (1 if side > 0 else 0)
    assert hit.multiplicity == (2 if side == 0 else 1)
    assert len(hit.others) == (1 if side == 0 else 0)


@POSES
@SIDES
@BITS
def test_plane_parallel_to_the_motion(bits, side, posed):
    vertex = Body([[-5, Fraction(1, 3), hair(bits, side)]], [], [])
    flat = Body([[0, -1, 0], [0, 1, 0], [2, 0, 0]], [], [[0, 1, 2]])
    assert_status(Scene(vertex, flat, translation=(1, 0, 0)), side == 0, posed)


@POSES
@SIDES
@BITS
def test_circle_that_grazes_a_plane(bits, side, posed):
    """Tangential: the discriminant is 0, or 2^-bits."""
    vertex = Body([[1, 0, Fraction(1, 5)]], [], [])
    wall_at = 1 - hair(bits, side)
    wall = Body([[-1, wall_at, -1], [1, wall_at, -1], [0, wall_at, 2]], [], [[0, 1, 2]])
    assert_status(Scene(vertex, wall, rotation=ABOUT_Z), side >= 0, posed)


@POSES
@SIDES
@BITS
def test_edge_that_grazes_an_edge_in_a_turn(bits, side, posed):
    post = Body([[1, 0, -1], [1, 0, 1]], [[0, 1]], [])
    wall_at = 1 - hair(bits, side)
    bar = Body([[-2, wall_at, 0], [2, wall_at, Fraction(1, 3)]], [[0, 1]], [])
    assert_status(Scene(post, bar, rotation=ABOUT_Z), side >= 0, posed)


@POSES
@SIDES
@BITS
def test_heights_that_just_meet_in_a_turn(bits, side, posed):
    post = Body([[5, 0, 0], [5, 0, 2]], [[0, 1]], [])
    other = Body([[3, 4, 2 - hair(bits, side)], [3, 4, 7]], [[0, 1]], [])
    assert_status(Scene(post, other, rotation=ABOUT_Z), side >= 0, posed)


@POSES
@SIDES
@BITS
def test_quarter_turn_beside_the_contact(bits, side, posed):
    """Contact after exactly a quarter turn, or a hair earlier or later than the motion ends."""
    vertex = Body([[2, 0, 0]], [], [])
    wall = Body(
        [[hair(bits, -side), 1, -1], [hair(bits, -side), 1, 1], [hair(bits, -side), 4, 0]], [], [[0, 1, 2]]
    )
    quarter = {**ABOUT_Z, "turns": Fraction(1, 4)}
    # The wall at x > 0 is met before the quarter turn, the one at x < 0 after it.
    assert_status(Scene(vertex, wall, rotation=quarter), side <= 0, posed)


@BITS
def test_start_a_hair_in_front_of_and_behind_a_face(bits):
    below, behind = (Body([[0, 1, Fraction(7, 3) - hair(bits, side)]], [], []) for side in (1, -1))
    hit = fc.first_contact(*question(Scene(below, TRIANGLE, translation=UP)))
    assert hit.status is fc.Status.CONTACT and hit.time == 2.0**-bits
    assert fc.first_contact(*question(Scene(behind, TRIANGLE, translation=UP))).status is fc.Status.FREE


@BITS
def test_start_a_hair_behind_is_a_whole_turn_away(bits):
    post = Body([[1, 0, -1], [1, 0, 1]], [[0, 1]], [])
    y = hair(bits, -1)
    bar = Body([[Fraction(1, 2), y, -1], [2, y, 1]], [[0, 1]], [])
    scene = Scene(post, bar, rotation=ABOUT_Z)
    assert assert_same_first_contact(scene) == naive.CONTACT
    hit = fc.first_contact(*question(scene))
    assert math.isclose(hit.time, 1 - math.asin(2.0**-bits) / (2 * math.pi), rel_tol=1e-15)


@pytest.mark.parametrize("bits", [30, 45, 60])
def test_needles(bits):
    """Triangles thinner than the rounding of their corners' differences."""
    thin = hair(bits, 1)
    needle = Body(
        [[0, 0, 0], [1, thin, 0], [1, 0, thin], [1, 0, 0]], [], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    )
    plate = Body([[5, -1, -1], [5, 2, -1], [5, -1, 2]], [], [[0, 1, 2]])
    scene = Scene(needle, plate, translation=(1, Fraction(1, 9), 0))
    for s in (scene, pose_scene(scene)):
        assert assert_same_first_contact(s) == naive.CONTACT
