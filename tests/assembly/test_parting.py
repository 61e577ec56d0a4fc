"""Bodies that part at once from what they touch, stand on tips, or share a motion: the first new contact."""

from fractions import Fraction

import pytest

import firstcontact as fc
from firstcontact import Rotation, Screw, Sequence, Status, Translation

PLATE = fc.examples.box((40, 40, 1)).translated((0, 0, "-1/2"))
TIP = fc.Polyhedron(
    [(0, 0, 0), (1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1)],
    [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [1, 2, 3, 4]],
)
KEEL = fc.Polyhedron(
    [(0, -1, 0), (1, -1, 1), (-1, -1, 1), (0, 1, 0), (1, 1, 1), (-1, 1, 1)],
    [[0, 1, 2], [3, 5, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]],
)

STEP = fc.Polyhedron(
    [(x, y, z) for y in (-20, 20) for x, z in [(-9, -1), (9, -1), (9, 6), (5, 6), (5, 0), (-9, 0)]],
    [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *([i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6))],
)
"""A floor at 0 and a wall from x = 5 on, in one."""


def under_a_roof(solid):
    """A plate with its top at 0, and over all of it a roof 7/2 above."""
    make = fc.box if solid else fc.examples.box
    return [make((40, 40, 1)).translated((0, 0, z)) for z in ("-1/2", 4)]


def channel():
    """A mesh: a floor at 0 and a roof 7/2 above it, joined by a wall far off."""
    outline = [(-20, -1), (20, -1), (20, 5), (-9, 5), (-9, 3.5), (19, 3.5), (19, 0), (-20, 0)]
    n = len(outline)
    rims = [list(range(n)), list(range(n, 2 * n))[::-1]]
    sides = [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    return fc.Polyhedron([(x, y, z) for y in (-20, 20) for x, z in outline], [*rims, *sides])


def cube(solid=False):
    return (fc.box if solid else fc.examples.box)((2, 2, 2)).translated((0, 0, 1))


@pytest.mark.parametrize("solid", [False, True])
def test_a_block_screws_off_its_plate(solid):
    plate, roof = under_a_roof(solid)
    moving = cube(solid).moving(Screw((0, 0, 1), (3, 1, 0), degrees=80, advance=3))
    assert fc.first_new_contact(moving, plate).status is Status.FREE
    assert fc.first_new_contact(plate, moving).status is Status.FREE
    hit = fc.first_contact(moving, roof)
    assert hit.status is Status.CONTACT and hit.time == 0.5


def test_a_block_screws_up_to_the_roof_of_its_channel():
    moving = cube().moving(Screw((0, 0, -1), (3, 1, 0), degrees=80, advance=-3))
    for pair in ((moving, channel()), (channel(), moving)):
        hit = fc.first_new_contact(*pair)
        assert hit.status is Status.CONTACT and hit.time_interval[0] <= 0.5 <= hit.time_interval[1]


@pytest.mark.share(2)
@pytest.mark.parametrize("solid", [False, True])
def test_a_block_that_is_pressed_in_meets_at_once(solid):
    moving = cube(solid).moving(Translation((1, 0, -1)))
    hit = fc.first_new_contact(moving, under_a_roof(solid)[0])
    assert hit.status is Status.CONTACT and hit.time == 0.0
    away = cube(solid).moving(Sequence([Translation((1, 0, 0)), Translation((0, 0, 3))]))
    assert fc.first_new_contact(away, under_a_roof(solid)[0]).status is Status.FREE


def test_a_block_that_comes_back_is_not_told_free():
    """It rises, and sinks deeper than it stood."""
    moving = cube().moving(Sequence([Translation((0, 0, 1)), Translation((0, 0, -2))]))
    hit = fc.first_new_contact(moving, PLATE)
    assert hit.status is not Status.FREE and hit.free_until <= 1.5


def test_pairs_at_one_instant_of_a_screw_are_those_at_rest():
    screw = Screw((0, 0, 1), degrees=90, advance=3)
    there, moving = (fc.contact_pairs(x, PLATE, (0, 0)) for x in (cube(), cube().moving(screw)))
    assert set(moving.pairs) == set(there.pairs) and set(moving.piercing) == set(there.piercing)
    assert there.pairs and moving.stats.pair_tests < 500
    found = fc.contact_intervals(cube().moving(screw), PLATE, (0, 0))
    assert found.status is Status.INITIAL_CONTACT and [(x.start, x.end) for x in found] == [(0.0, 0.0)]


@pytest.mark.parametrize("body", [TIP, KEEL], ids=["tip", "keel"])
def test_what_stands_on_a_tip_or_a_keel_slides(body):
    for motion in (Translation((3, 1, 0)), Rotation((0, 0, 1), (5, 0, 0), turns="1/4")):
        for pair in ((body.moving(motion), PLATE), (PLATE, body.moving(motion))):
            assert fc.first_new_contact(*pair).status is Status.FREE
    stop = fc.first_new_contact(body.moving(Translation((8, 0, 0))), STEP)
    assert stop.status is Status.CONTACT and stop.time == 0.5


@pytest.mark.share(4)
@pytest.mark.parametrize("common", [(0, 1, 0), (0, 0, 1), (3, -2, -5)])
@pytest.mark.parametrize("solid", [False, True])
def test_a_shift_of_both_changes_nothing(common, solid):
    plate, _ = under_a_roof(solid)
    wall = (fc.box if solid else fc.examples.box)((1, 20, 5)).translated((5, 0, 0))
    small = cube(solid)
    own = tuple(x + y for x, y in zip(common, (8, 0, 0), strict=True))
    assert fc.first_new_contact(plate.moving(Translation(common)), small.moving(Translation(own))).status is Status.FREE
    hit = fc.first_contact(wall.moving(Translation(common)), small.moving(Translation(own)))
    assert hit.time == pytest.approx(0.4375, abs=1e-12)
    if solid:
        hit = fc.first_new_contact((plate | wall).moving(Translation(common)), small.moving(Translation(own)))
        assert hit.status is Status.CONTACT and hit.time == 0.4375


@pytest.mark.share(3)
@pytest.mark.parametrize("solid", [False, True])
@pytest.mark.parametrize("both", ["1/4", "-1/7"])
def test_a_hinge_both_leaves_of_which_turn(solid, both):
    make = fc.box if solid else fc.examples.box
    frame, lid = make((3, 2, 2)).translated(("3/2", 0, -1)), make((1, 2, 2)).translated(("-1/2", 0, 1))
    turns = {"1/4": "7/12", "-1/7": "4/21"}[both]  # a third of a turn more; a quarter of one is free
    hit = fc.first_new_contact(
        frame.moving(Rotation((0, 1, 0), turns=both)), lid.moving(Rotation((0, -2, 0), turns=f"-{turns}"))
    )
    assert hit.status is Status.CONTACT and hit.time_interval[0] <= 0.75 <= hit.time_interval[1]


@pytest.mark.share(3)
@pytest.mark.parametrize("part", ["ball", "cone", "drilled"])
def test_a_solid_screws_off_a_mesh(part):
    """About an axis that is none of its own; the mesh is a channel, not convex: 7/2 are free above the floor."""
    round_ = {
        "ball": fc.sphere(1).translated((0, 0, 1)),
        "cone": fc.cone(1, 2),
        "drilled": fc.box((2, 2, 2)).translated((0, 0, 1)) - fc.cylinder("1/2", 6),
    }[part]
    for advance, time in ((1, None), (3, 0.5)):
        moving = round_.moving(Screw((0, 0, 1), ("1/3", 0, 0), turns="1/3", advance=advance))
        assert fc.first_contact(moving, PLATE, (0, 0)).status is Status.INITIAL_CONTACT
        assert fc.first_new_contact(moving, PLATE).status is Status.FREE
        hit = fc.first_new_contact(moving, channel())
        if part == "drilled":  # that it only touches is not told
            assert hit.status is Status.INITIAL_CONTACT and hit.initial is None
        elif time is None:
            assert hit.status is Status.FREE
        else:
            assert hit.status is Status.CONTACT and hit.time_interval[0] <= time <= hit.time_interval[1]


def test_a_solid_that_slides_on_a_mesh_meets_its_wall():
    ball = fc.sphere(1).translated((0, 0, 1))
    for pair in ((ball.moving(Translation((8, 0, 0))), STEP), (STEP, ball.moving(Translation((8, 0, 0))))):
        hit = fc.first_new_contact(*pair)
        assert hit.status is Status.CONTACT and hit.time_interval[0] <= 0.5 <= hit.time_interval[1]
        assert "face" in str(hit.element_a) + str(hit.element_b)
    assert fc.first_new_contact(ball.moving(Translation((3, 1, 0))), STEP).status is Status.FREE


@pytest.mark.thorough
@pytest.mark.parametrize("motion", [Translation((0, 0, 4)), Rotation((0, 0, 1), turns="1/3")])
def test_a_square_pin_in_a_round_bore(motion):
    """It touches the bore along its edges, as a mesh and as a solid."""
    plate = fc.box((6, 6, 2)) - fc.cylinder(1, 4)
    pin = fc.box(("6/5", "8/5", 4))
    mesh = fc.Polyhedron(
        [(x, y, z) for x in ("-3/5", "3/5") for y in ("-4/5", "4/5") for z in (-2, 2)],
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    )
    for body in (pin, mesh):
        assert fc.first_new_contact(body.moving(motion), plate).status is Status.FREE
    stop = fc.box((1, 1, 1)).translated((0, 0, "7/2"))  # above the pin: met after 1 of 4
    lifted = fc.first_new_contact(mesh.moving(Translation((0, 0, 4))), plate | stop)
    assert lifted.status is Status.CONTACT and lifted.time_interval[0] <= 0.25 <= lifted.time_interval[1]


@pytest.mark.thorough
def test_a_hinge_of_solids_with_a_round_bump_elsewhere():
    frame, lid = fc.box((3, 2, 2)).translated(("3/2", 0, -1)), fc.box((1, 2, 2)).translated(("-1/2", 0, 1))
    bump = fc.sphere("1/4").translated(("1/2", 0, 0))
    hit = fc.first_new_contact(lid.moving(Rotation((0, 1, 0), degrees=90)), frame | bump)
    # the lid's plane is tangent to the ball, 1/4 thick half way out, where the sine of what is left is 1/2
    lo, hi = map(Fraction, hit.time_interval)
    assert hit.status is Status.CONTACT and lo <= Fraction(2, 3) <= hi


def test_a_drilled_box_on_a_mesh_that_is_not_convex():
    """An edge of its hole is in the mesh's plane all round."""
    drilled = fc.box((2, 2, 1)).translated((-3, 0, "1/2")) - fc.cylinder("1/2", 3).translated((-3, 0, 0))
    for pair in ((drilled, channel()), (channel(), drilled)):
        assert fc.first_contact(*pair).status is Status.INITIAL_CONTACT
    above = drilled.translated((0, 0, "1/1000"))
    assert fc.first_contact(above, channel()).status is Status.FREE
    falls = fc.first_contact(above.moving(Translation((0, 0, -1))), channel())
    assert falls.status is Status.CONTACT and falls.time_interval[0] <= 0.001 <= falls.time_interval[1]


def test_the_work_told_is_that_of_all_that_was_asked(monkeypatch):
    """Of the first contact, of every part, and of what was asked twice."""
    done = []
    for name in ("first_contact", "contact_intervals", "contact_pairs"):
        verb = getattr(fc.query, name)
        monkeypatch.setattr(fc.query, name, lambda *a, verb=verb, **k: done.append(found := verb(*a, **k)) or found)
    moving = cube().moving(Screw((0, 0, 1), (3, 1, 0), degrees=80, advance=3))
    hit = fc.first_new_contact(moving, channel())
    work = [(x.stats.node_visits, x.stats.pair_tests, x.stats.exact_evaluations) for x in done]
    told = hit.stats.node_visits, hit.stats.pair_tests, hit.stats.exact_evaluations
    assert len(done) > 3 and told == tuple(map(sum, zip(*work, strict=True)))


@pytest.mark.thorough
@pytest.mark.parametrize("durations", [None, ["3/10", "7/10", 5]])
def test_steps_that_meet_at_no_double(durations):
    """A ball turns in its socket, is lifted out, and goes on, or comes down again on the middle of the socket."""
    ball, socket = fc.sphere(1), fc.box((4, 4, 2)).translated((0, 0, -1)) - fc.sphere(1)
    turn, lift = Rotation((0, 0, 1), degrees=90), Translation((0, 0, 3))
    for last, time in ((Translation((1, 0, 0)), None), (Translation((0, 0, -6)), Fraction(1, 2))):
        motion = Sequence([turn, lift, last], durations=durations) if durations else Sequence([turn, lift, last])
        hit = fc.first_new_contact(ball.moving(motion), socket)
        if time is None:
            assert hit.status is Status.FREE
            continue
        begin, end = (Fraction(2, 3), Fraction(1)) if durations is None else (Fraction(1), Fraction(6))
        lo, hi = map(Fraction, hit.time_interval)
        assert hit.status is Status.CONTACT and lo <= begin + (end - begin) * time <= hi


def of_boxes(*corners):
    """Boxes between two corners each, as one mesh."""
    unit = fc.examples.box((1, 1, 1))
    places = [
        [lo[k] + (hi[k] - lo[k]) * (p[k] + 0.5) for k in range(3)] for lo, hi in corners for p in unit.vertices.tolist()
    ]
    triangles = unit.triangles.tolist()
    return fc.Polyhedron(places, [[8 * k + i for i in face] for k in range(len(corners)) for face in triangles])


def test_bodies_on_both_sides_of_one_plane():
    """One rests on the other's floor left of the middle, and is under its lip right of it, both at height 0."""
    lower = of_boxes(((-4, -1, -2), (-1, 1, 0)), ((1, -1, 0), (4, 1, 1)))
    upper = of_boxes(((-3, -1, 0), (-2, 1, 1)), ((2, -1, -1), (3, 1, 0)))
    for motion in (Translation((0, 1, 0)), Translation((0.5, 3, 0))):
        for pair in ((upper.moving(motion), lower), (lower, upper.moving(motion))):
            assert fc.first_new_contact(*pair).status is Status.FREE
    hit = fc.first_new_contact(upper.moving(Translation((0, 0, 1))), lower)
    assert hit.status is Status.CONTACT and hit.time == 0.0  # the lip holds it down


@pytest.mark.thorough
def test_a_bar_across_a_pin_has_its_corners_outside_the_pin_s_cylinder():
    """The foot of a bracket is beside the pin, which it touches along a line, and its bar comes down on the pin's end.

    All corners of the mesh are outside the cylinder that the motion keeps, but not the bar.
    """
    pin, bracket = fc.cylinder(1, 2), of_boxes(((1, -1, -1), (2, 1, 1)), ((-3, -0.5, 3), (3, 0.5, 4)))
    for pair in ((bracket.moving(Translation((0, 0, -4))), pin), (pin, bracket.moving(Translation((0, 0, -4))))):
        hit = fc.first_new_contact(*pair)
        assert hit.status is Status.CONTACT and hit.time == 0.5
    assert fc.first_new_contact(bracket.moving(Translation((0, 0, -1))), pin).status is Status.FREE
