"""Ruled surfaces that share points with another body at the start: the place told, thin overlaps and gaps, ends.

Places are checked in plain numpy.  Scenes are made with a common point by construction, or in a frame in which the
surface has the origin as its lowest point, on or near the top of the other body.
"""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

import firstcontact as fc
from amount import amount
from contact_places import assert_on_both
from firstcontact.contact.signs import exactly
from firstcontact.motion.moving import Moving

INITIAL = fc.Status.INITIAL_CONTACT


@pytest.mark.thorough
def test_the_point_of_a_start_is_on_both_pieces():
    """It was 2.6e-5 off the second one, as far as the box that held it was wide."""
    along = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    a = fc.RuledSurface(
        "(-931/1300 - 14/5*u, -287/80 + 14/5*u, -22533/5200 + 14/5*u)",
        "(-2751/1300 - 14/5*u + 21/5*u**2, -63/80 - 14*u + 77/5*u**2, -7973/5200 - 42/5*u + 14/5*u**2)",
    ).moving(fc.RationalMotion([along, [[0, 0, 0, "-7/5"], [0, 0, 0, "14/5"], [0, 0, 0, "-14/5"], [0, 0, 0, 0]]]))
    b = fc.RuledSurface("(0, -28/5 + 14/5*u, -14/5)", "(-7 - 7/5*u, -28/5*u, -21/5)").moving(fc.RationalMotion([
        along,
        [[0, 0, -1, "7/5"], [0, 0, 0, "49/5"], [1, 0, 0, 0], [0, 0, 0, 0]],
        [[-0.25, 0, 0, "-63/10"], [0, 0.25, 0, -7], [0, 0, -0.25, "21/5"], [0, 0, 0, 0.25]],
        [[0, 0, 0, "7/20"], [0, 0, 0, "49/20"], [0, 0, 0, -1.75], [0, 0, 0, 0]],
        [[0, 0, 0, "-7/10"], [0, 0, 0, -1.75], [0, 0, 0, "21/20"], [0, 0, 0, 0]],
    ]))  # fmt: skip
    hit = fc.first_contact(a, b, (0.4375, 1))
    assert (hit.status, hit.initial) == (INITIAL, "touching")
    assert_on_both(hit, a, b)


@pytest.mark.share(3)
@pytest.mark.parametrize("other, far", (
    (fc.sphere(2), 0), (fc.examples.box((2, 2, 2)), 2**40), (fc.RuledSurface("(0, u, -1)", "(0, u, 1)"), 0),
))  # fmt: skip
def test_what_a_start_touches_is_asked_exactly_when_it_is_read(monkeypatch, other, far):
    """Ninety milliseconds of elimination went before each answer, whose proof had taken eight."""
    asked = []
    monkeypatch.setattr(exactly, "first", lambda *given, ask=exactly.first: asked.append(1) or ask(*given))
    a, b = (body.translated((far, 0, 0)) for body in (fc.RuledSurface("(-u, 0, 0)", "(3, 3, u)"), other))
    a = a.moving(fc.Rotation((0, 0, 1), point=(far, 0, 0), degrees=90))
    hit = fc.first_contact(a, b)
    assert (hit.status, hit.time, asked) == (INITIAL, 0.0, [])
    assert hit.initial == ("touching" if isinstance(other, fc.RuledSurface) else "overlapping")
    exact = fc.first_contact(a, b, method="algebraic")
    assert (hit.initial, hit.multiplicity, hit.contact_set) == (exact.initial, exact.multiplicity, exact.contact_set)
    assert (hit.element_a, exact.time_exact) == (exact.element_a, None)
    assert hit.point.tolist() == exact.point.tolist()
    assert asked == [1, 1]


def test_exact_starts_are_asked_of_bodies_at_rest(monkeypatch):
    """All times of contact of twelve triangles in a triple turn were told first, in 16 s."""
    turn = [fc.Rotation((2, -3, -6), (1, 2, 1), degrees=x) for x in (1110, 30)]
    a = fc.RuledSurface("((3*u**2 - 2)/(1 + u**2), (4 - 6*u + 3*u**2)/(1 + u**2), (2 - 4*u)/(1 + u**2))",
                        "(4*u**2 - 5*u - 1, 1 - 2*u + 4*u**2, 5 - 5*u + 3*u**2)").moving(turn[0])  # fmt: skip
    b = fc.examples.box((2, 2, 2)).rotated((2, 1, 2), degrees=90).translated((0, 1, 1)).moving(turn[1])
    asked = []
    monkeypatch.setattr(exactly, "first", lambda *given, ask=exactly.first: asked.append(given[0]) or ask(*given))
    hit = fc.first_contact(a, b, exact=True)
    assert (hit.status, hit.initial, hit.time_exact, hit.multiplicity) == (INITIAL, "overlapping", 0, 3)
    assert (hit.a, hit.b, hit.span) == (a, b, (0, 1))
    assert [x for query in asked for x in query.bodies if isinstance(x, Moving)] == []


# ------------------------------------------------------------------------------------ starts with a place in common


def numbers(rng, n, below=1):
    return [F(rng.randint(-12, 12), 4 * below) for _ in range(n)]


def directrix(rng, degree):
    return [numbers(rng, 3, 1 + k) for k in range(degree + 1)]


def value(curve, u):
    return [sum(c[k] * u**i for i, c in enumerate(curve)) for k in range(3)]


def piece_through(rng, point, size):
    """A piece that has the point inside, its numbers times the size."""
    first, second = (directrix(rng, rng.randint(1, 3)) for _ in range(2))
    u, s = (F(rng.randint(1, 15), 16) for _ in range(2))
    here = [(1 - s) * x + s * y for x, y in zip(value(first, u), value(second, u), strict=True)]
    curves = []
    for curve in (first, second):
        curve[0] = [c + p - h for c, p, h in zip(curve[0], point, here, strict=True)]
        curves.append(fc.RationalCurve([[size * curve[i][k] for i in range(len(curve))] for k in range(3)], [1]))
    return fc.RuledSurface(*curves)


def triangle_through(rng, point, size):
    corners = [numbers(rng, 3) for _ in range(3)]
    middle = [sum(c[k] for c in corners) / 3 for k in range(3)]
    corners = [[size * (c[k] + point[k] - middle[k]) for k in range(3)] for c in corners]
    return fc.Polyhedron(corners, [[0, 1, 2]])


def some_motion(rng, how, size):
    v = [size * x for x in numbers(rng, 3)]
    axis, at = [1, rng.randint(-2, 2), rng.randint(-2, 2)], [size * x for x in numbers(rng, 3)]
    match how:
        case "translation":
            return fc.Translation(v)
        case "rotation":
            return fc.Rotation(axis, at, degrees=rng.choice((30, -90, 200)))
        case "screw":
            return fc.Screw(axis, at, degrees=rng.choice((25, -120)), advance=size)
        case _:
            rows = [[[int(i == j) for j in range(4)] for i in range(4)], [[0, 0, 0, x] for x in v] + [[0] * 4]]
            return fc.RationalMotion([*rows, [[0, 0, 0, x] for x in v[::-1]] + [[0] * 4]])


MOTIONS = "translation", "rotation", "screw", "rational"


def start_scene(seed):
    rng = Random(seed)
    size = F(2) ** rng.choice((-100, -30, 0, 0, 0, 30, 100))
    point = numbers(rng, 3)
    other = triangle_through if seed % 3 == 0 else piece_through
    a, b = piece_through(rng, point, size), other(rng, point, size)
    how = MOTIONS[seed % 4]
    a = a.moving(some_motion(rng, how, size))
    if how != "screw" and rng.random() < 0.5:
        b = b.moving(some_motion(rng, how if how != "rotation" else "translation", size))
    return (b, a) if rng.random() < 0.5 else (a, b)


@pytest.mark.parametrize("seed", range(amount(8)))
def test_points_of_starts(seed):
    a, b = start_scene(seed)
    hit = fc.first_contact(a, b, (0, F(1, 8)))
    assert hit.status is INITIAL and hit.point is not None, hit
    assert_on_both(hit, a, b)


# ------------------------------------------------------------------------------------------- ends of sequences


def test_an_event_at_the_end_of_a_sequence():
    """A cone's apex comes down on a rim at the last instant; the event's enclosure reaches beyond it."""
    cone = fc.RuledSurface(
        "((24 + 8*u**2)/(1 + u**2), (-168 + 48*u - 168*u**2)/(5 + 5*u**2), (56 + 64*u + 56*u**2)/(5 + 5*u**2))",
        "(16, -104/5, 8/5)", u=None,
    )  # fmt: skip
    down = fc.Translation((0, F(64, 5), F(-48, 5)))
    turn = fc.Rotation((0, F(-32, 5), F(24, 5)), (16, -8, -8), degrees=-30)
    placed = [[F(32, 5), F(24, 5), 0, 16], [F(-72, 25), F(96, 25), F(-32, 5), F(-8, 5)],
              [F(-96, 25), F(128, 25), F(24, 5), F(-64, 5)], [0, 0, 0, 1]]  # fmt: skip
    rod = fc.cylinder(2, 2).transformed(placed)
    hit = fc.first_contact(cone.moving(fc.Sequence([turn, down], [F(1, 2), 2])), rod)
    assert hit.status is fc.Status.CONTACT or hit.reason == "precision"
    assert hit.free_until == pytest.approx(2.5, abs=1e-9)
    # it goes on a little: then there is a contact to prove
    beyond = fc.Sequence([turn, down, fc.Translation((0, F(64, 500), F(-48, 500)))], [F(1, 2), 2, F(1, 50)])
    hit = fc.first_contact(cone.moving(beyond), rod)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(2.5, abs=1e-9)


# ------------------------------------------------------------------------------------- thin overlaps and thin gaps

# Surfaces above z = 0 with the origin on them, and solids below it that have the origin on their surface.
ABOVE = {
    "strip": fc.RuledSurface("(-3 + 6*u, -2, 0)", "(-3 + 6*u, 2, 0)"),
    "slanted": fc.RuledSurface("(-3 + 6*u, 0, 0)", "(-3 + 6*u, 2, 3)"),
    "corner": fc.RuledSurface("(u, 0, 2*u)", "(u, 1, 2*u + 1)"),
    "cone": fc.RuledSurface("(0, 0, 0)", "((1 - u**2)/(1 + u**2), 2*u/(1 + u**2), 2)", u=None),
    "trough": fc.RuledSurface("(-2, u, u**2)", "(2, u, u**2)", u=(-1, 1)),
}
LYING = [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
BELOW = {
    "sphere": fc.sphere(1).translated((0, 0, -1)),
    "ellipsoid": fc.ellipsoid((1, 2, 3)).translated((0, 0, -3)),
    "cylinder": fc.cylinder(1, 4).transformed(LYING).translated((0, 0, -1)),
    "top": fc.cylinder(5, 4).translated((0, 0, -2)),
    "box": fc.box((9, 8, 7)).translated((0, 0, F(-7, 2))),
    "tip": fc.cone(1, 2).translated((0, 0, -2)),
    "mesh": fc.examples.box((9, 8, 7)).translated((0, 0, F(-7, 2))),
}


def turned(q, offset):
    """A rotation by a quaternion of whole numbers and a shift, exactly."""
    w, x, y, z = map(F, q)
    n = w * w + x * x + y * y + z * z
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return [[*(c / n for c in row), o] for row, o in zip(rows, offset, strict=True)] + [[0, 0, 0, 1]]


def thin_scene(seed):
    """(a, b, depth, how): the surface lies as deep in the solid, or stays out by as much, and leaves along its z."""
    rng = Random(seed)
    upper, lower = rng.choice(sorted(ABOVE)), rng.choice(sorted(BELOW))
    depth = rng.choice((1, 1, -1, 0)) * F(1, 10 ** rng.choice((3, 7, 10, 12, 14, 15, 16, 17, 18)))
    how = rng.choice(("translation", "screw", "rational"))
    pose = turned([1 + rng.randint(0, 4), *(rng.randint(-5, 5) for _ in range(3))],
                  [F(rng.randint(-20, 20), 3) for _ in range(3)])  # fmt: skip
    up, origin = ([row[k] for row in pose[:3]] for k in (2, 3))
    if how == "translation":
        motion = fc.Translation([4 * c for c in up])
    elif how == "screw":
        motion = fc.Screw(up, origin, degrees=30, advance=3)
    else:
        motion = fc.RationalMotion([np.eye(4).tolist(), [[0, 0, 0, 4 * c] for c in up] + [[0] * 4]])
    a = ABOVE[upper].translated((0, 0, -depth)).transformed(pose).moving(motion)
    b = BELOW[lower].transformed(pose)
    return (*((b, a) if rng.random() < 0.5 else (a, b)), depth, how)


@pytest.mark.parametrize("seed", range(amount(30)))
def test_depths_and_gaps_of_any_size(seed):
    a, b, depth, how = thin_scene(seed)
    hit = fc.first_contact(a, b)
    if depth < 0:  # under a screw doubles do not always tell the times after the start
        assert hit.status is fc.Status.FREE or (how == "screw" and hit.reason == "precision" and hit.free_until == 0)
    else:
        assert (hit.status, hit.time) == (INITIAL, 0)
        assert hit.initial in (("overlapping", "containment") if depth else ("touching",))


SIDE, NEXT = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)"), fc.RuledSurface("(u, 1, 0)", "(u, 2, 0)")


TROUGH = fc.RuledSurface("(u, 1/4, (u - 1/2)**2)", "(u, 1, (u - 1/2)**2)")


@pytest.mark.share(2)
@pytest.mark.parametrize(
    "other", [NEXT, NEXT.translated((1, 0, 0)), TROUGH], ids=["along an edge", "in a corner", "tangent"]
)
@pytest.mark.parametrize(
    "motion", [fc.Translation((0, 1, 2)), fc.Rotation((1, 0, 0), degrees=30)], ids=["shift", "turn"]
)
def test_times_of_pieces_that_touch_at_the_start_and_part(other, motion):
    """Doubles tell neither contact nor none at the start, and have no finer arithmetic to ask: they leave it open."""
    alone = fc.contact_intervals(SIDE, other.moving(motion), method="certified")
    assert alone.status is fc.Status.UNDECIDED
    assert alone.free_until == 0.0
    for pair in ((SIDE, other.moving(motion)), (other.moving(motion), SIDE)):
        assert [(x.start, x.end) for x in fc.contact_intervals(*pair)] == [(0.0, 0.0)]


@pytest.mark.parametrize("motion", [(0, 0, 3), (1, 0, 0), (0, 0, -1)])
def test_a_cube_that_stands_on_whole_rulings_at_the_start(motion):
    """As a mesh it was UNDECIDED, and as a solid touching: only of the latter were the rulings cut."""
    floor = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)", u=(-5, 5), s=None)
    for cube in (fc.examples.box((2, 2, 2)), fc.box((2, 2, 2))):
        for x, y in ((cube.translated((0, 0, 1)).moving(fc.Translation(motion)), floor),
                     (floor, cube.translated((0, 0, 1)).moving(fc.Translation(motion)))):  # fmt: skip
            hit = fc.first_contact(x, y)
            assert (hit.status, hit.initial) == (INITIAL, "touching")


def test_a_cube_that_a_whole_cone_touches_from_outside_at_the_start():
    cone = fc.RuledSurface(
        "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", "(2*(1-u**2)/(1+u**2), 4*u/(1+u**2), 2)", u=(-1, 1), s=None
    ).transformed([[0, 1, 0, -3], [0, 0, 1, -4], [1, 0, 0, 1], [0, 0, 0, 1]])
    hit = fc.first_contact(cone.moving(fc.Translation((3, 4, -1))), fc.examples.box((2, 2, 2)))
    assert (hit.status, hit.initial) == (INITIAL, "touching")


H = F(1, 2)
SADDLE = fc.RuledSurface("(-u**2, u, 0)", "(0, 0, 1)").translated((0, H, H))
BESIDE = {
    "a ball": fc.sphere(H).translated((H, H, H)),
    "a can": fc.cylinder(H, 1).translated((H, H, H)),
    "a drilled box": (fc.box((1, 1, 1)) - fc.cylinder(F(1, 4), 2)).translated((H, H, H)),
    "a box": fc.examples.box((1, 1, 1)).translated((H, H, H)),
}


@pytest.mark.parametrize("body", BESIDE)
def test_all_contacts_of_what_touches_at_the_start_and_screws_away_or_on(body):
    """The start is decided at rest; the sweep in doubles had it open, and told nothing. The surface ends at x = 0.

    For the can balls about the time 0 shrank until their bounds as rationals filled the memory.
    """
    away, on = (fc.Screw((1, 1, 0), degrees=50, advance=x) for x in (1, -1))
    (told,) = fc.contact_intervals(BESIDE[body].moving(away), SADDLE)
    assert told.start == 0 and told.end_interval[1] <= 1e-12
    (told,) = fc.contact_intervals(SADDLE, BESIDE[body].moving(on))
    assert told.start == 0 and 0.3 < told.end < 0.6
    rest = fc.contact_intervals(SADDLE, BESIDE[body].moving(on), (told.end_interval[1] + 1e-9, 1))
    assert rest.status is fc.Status.FREE


def test_the_end_of_what_screws_on_from_the_start_is_where_the_ball_leaves_the_surface():
    """The distance of the ball's middle from the surface, by scipy."""
    on = fc.Screw((1, 1, 0), degrees=50, advance=-1)

    def gap(t):
        pose = np.array(on(t))
        middle = pose[:3, :3] @ (0.5, 0.5, 0.5) + pose[:3, 3]

        def away(place):
            u, s = place
            point = (1 - s) * np.array([-(u**2), u, 0]) + s * np.array([0, 0, 1]) + (0, 0.5, 0.5)
            return float(((point - middle) ** 2).sum())

        starts = [(u, s) for u in (0.1, 0.5, 0.9) for s in (0.1, 0.5, 0.9)]
        found = (minimize(away, x, bounds=[(0, 1), (0, 1)], tol=1e-15) for x in starts)
        return min(x.fun for x in found) ** 0.5 - 0.5

    (told,) = fc.contact_intervals(SADDLE, BESIDE["a ball"].moving(on))
    assert told.end == pytest.approx(brentq(gap, 0.2, 0.6, xtol=1e-12), abs=1e-7)
