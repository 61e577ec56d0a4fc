"""Tips of cones meet a torus: whoever moves, whichever comes first, by the quartic along the tip's path."""

from __future__ import annotations

import math
import random
from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

PLACES = {"outer": (1, 0), "inner": (-1, 0), "top": (0, 1), "generic": None}
MOTIONS = ["translation", "rotation", "screw"]


def in_all_orders(cone, torus, motion, counter):
    """The same meeting, by the motion of either body and in either order; which of the two is the cone."""
    yield cone.moving(motion), torus, 0
    yield torus, cone.moving(motion), 1
    yield torus.moving(counter), cone, 1
    yield cone, torus.moving(counter), 0


def check(cone, torus, motion, counter, truth, room=0.0):
    for a, b, own in in_all_orders(cone, torus, motion, counter):
        hit = fc.first_contact(a, b)
        lo, hi = hit.time_interval
        assert hit.status is fc.Status.CONTACT and lo - room <= truth <= hi + room and hi - lo <= 1e-12
        assert (hit.element_a, hit.element_b)[own].kind == "apex"
        yield a, b


# -- scenes -------------------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("radius, height", [(1.5, 2), (1, 2), ("1/100000", 2), (0.5, 2)])
def test_a_tip_head_on_at_the_top(radius, height):
    """UNDECIDED in both orders for (1.5, 2): next to its tip doubles tell nothing of a cone."""
    cone = fc.cone(radius, height).rotated((1, 0, 0), degrees=180).translated((2, 0, 2 + height))
    down, up = fc.Translation((0, 0, -14)), fc.Translation((0, 0, 14))
    assert len(list(check(cone, fc.torus(2, 0.25), down, up, F(1, 8)))) == 4


@pytest.mark.thorough
@pytest.mark.parametrize("minor, speed", [(0.5, 6.5), (0.75, 13)])
def test_a_tip_off_the_axis_in_all_orders(minor, speed):
    cone = fc.cone(0.5, 2).rotated((1, 0, 0), degrees=180).translated((3, 0, 4))
    down, up = fc.Translation((0, 0, -speed)), fc.Translation((0, 0, speed))
    assert len(list(check(cone, fc.torus(3, minor), down, up, (2 - F(minor)) / F(speed)))) == 4


@pytest.mark.thorough
def test_a_flank_next_to_its_tip():
    """A needle goes down along the outer equator: its flank of slope 1/8 touches before its tip could."""
    needle = fc.cone(0.25, 2).rotated((1, 0, 0), degrees=180).translated((4.5, 0, 5))
    down, up = fc.Translation((0, 0, -7.5)), fc.Translation((0, 0, 7.5))
    # in the half-plane y = 0 the line of the flank through the tip (9/2, z) is 1/2 from (4, 0)
    truth = (3 - (0.5 * math.hypot(1, 8) - 4)) / 7.5
    for a, b, own in in_all_orders(needle, fc.torus(4, 0.5), down, up):
        hit = fc.first_contact(a, b)
        assert hit.time == pytest.approx(truth, abs=1e-12) and hit.time_interval[0] <= truth + 1e-15
        assert (hit.element_a, hit.element_b)[own].kind == "face"
    (meeting,) = fc.contact_intervals(needle.moving(down), fc.torus(4, 0.5))
    assert meeting.start == pytest.approx(truth, abs=1e-12)


def test_a_tip_through_the_hole_is_free():
    """The cone's radius is 1 at most where it passes the ring, the hole's is 7/4."""
    cone = fc.cone(1, 2).rotated((1, 0, 0), degrees=180).translated(("1/2", 0, 4))
    for a, b, _ in in_all_orders(cone, fc.torus(2, 0.25), fc.Translation((0, 0, -9)), fc.Translation((0, 0, 9))):
        assert fc.first_contact(a, b).status is fc.Status.FREE
        assert len(fc.contact_intervals(a, b)) == 0


# -- one instant --------------------------------------------------------------------------------------------

UPSIDE_DOWN = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 2], [0, 0, 0, 1]]
SHARP = {  # each with its lowest point at the origin
    "point": fc.Polyhedron([(0, 0, 0)], []),
    "segment": fc.Polyhedron([(0, 0, 0), (1, 2, 3)], [], edges=[(0, 1)]),
    "mesh": fc.Polyhedron(
        [(0, 0, 0), (1, 0, 2), (-1, 1, 2), (-1, -1, 2)], [(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)],
    ),
    "needle": fc.cone("1/4", 2).transformed(UPSIDE_DOWN),
    "blunt": fc.cone(3, 2).transformed(UPSIDE_DOWN),
    "corner": fc.box((2, 2, 2)).translated((1, 1, 1)).transformed(
        [[1, -1, 0, 0], [1, 1, -1, 0], [1, 1, 2, 0], [0, 0, 0, 1]]
    ),
}  # fmt: skip
RING = fc.torus(2, "1/4")
ALONG, BACK = fc.Translation((4, 0, 0)), fc.Translation((-4, 0, 0))
TURN = [fc.Rotation((0, 0, 1), (2, 3, 0), degrees=degrees) for degrees in (-120, 120)]


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("kind", SHARP)
@pytest.mark.share(12)
def test_a_point_grazes_the_top(kind, order):
    """Contact at 3/4 alone: doubles are not asked how near it is, the path's quartic has a double root there."""
    body = SHARP[kind].translated((-1, 0, "1/4"))
    a, b, own = list(in_all_orders(body, RING, ALONG, BACK))[order]
    hit, found = fc.first_contact(a, b), fc.contact_intervals(a, b)
    assert (hit.status, hit.time, hit.time_interval) == (fc.Status.CONTACT, 0.75, (0.75, 0.75))
    assert (hit.element_a, hit.element_b)[own].kind == ("apex" if kind in ("needle", "blunt") else "vertex")
    assert [(x.start, x.end) for x in found] == [(0.75, 0.75)] and found.status is fc.Status.CONTACT


@pytest.mark.thorough
@pytest.mark.parametrize("kind", ["needle", "mesh"])
def test_a_turn_that_grazes(kind):
    """The point goes along a circle about (2, 3) and passes the top circle at (2, 0) only, after a quarter turn."""
    body = SHARP[kind].translated((5, 3, "1/4"))
    a, b, _ = list(in_all_orders(body, RING, *TURN))[kind == "mesh"]
    hit = fc.first_contact(a, b)
    assert (hit.status, hit.time) == (fc.Status.CONTACT, 0.75) and hit.point == pytest.approx([2, 0, 0.25], abs=1e-9)


@pytest.mark.parametrize("by", [F(1, 10**13), F(-1, 10**13)])
@pytest.mark.parametrize("kind", ["needle", "point"])
@pytest.mark.share(4)
def test_points_that_all_but_graze(kind, by):
    """Above the top by that much: free; below: from 3/4 - x/4 to 3/4 + x/4 for x^2 + (1/4 + by)^2 = 1/16."""
    found = fc.contact_intervals(RING, SHARP[kind].translated((-1, 0, F(1, 4) + by)).moving(ALONG))
    if by > 0:
        assert found.status is fc.Status.FREE
    else:
        x = math.sqrt(-by / 2 - by * by) / 4
        assert [(t.start, t.end) for t in found] == [pytest.approx((0.75 - x, 0.75 + x), abs=1e-12)]


@pytest.mark.thorough
@pytest.mark.parametrize("kind", ["needle", "corner", "mesh", "point"])
def test_points_touch_at_the_start_and_in_the_last_instant(kind):
    """On the outside of the tube at (3/5, 4/5) of its circle, where no coordinate is a double."""
    place = [F(11, 5) - F(1, 20), 0, F(1, 5)]
    body, up = SHARP[kind].translated(place), fc.Translation((0, 0, 3))
    start = fc.first_contact(RING, body.moving(up))
    assert (start.status, start.initial, start.time) == (fc.Status.INITIAL_CONTACT, "touching", 0.0)
    assert [(x.start, x.end) for x in fc.contact_intervals(body.moving(up), RING)] == [(0.0, 0.0)]
    landed = fc.first_contact(body.translated((0, 0, 3)).moving(fc.Translation((0, 0, -3))), RING)
    assert (landed.status, landed.time) == (fc.Status.CONTACT, 1.0)


def test_a_bare_edge_leaves_a_torus():
    """UNDECIDED: the foot of a place on an edge was told as if the edge were a triangle.

    The point u of the edge, (2 + u, 2 u, 13/4 + 3 u - 8 t), leaves the tube at its lower side.
    """
    edge = SHARP["segment"].translated((2, 0, "13/4")).moving(fc.Translation((0, 0, -8)))
    (found,) = fc.contact_intervals(edge, RING)
    u = np.linspace(0, 1, 200001)
    lower = 1 / 16 - (np.hypot(2 + u, 2 * u) - 2) ** 2
    last = ((3.25 + 3 * u + np.sqrt(np.maximum(lower, 0))) / 8)[lower >= 0].max()
    assert found.start == pytest.approx(0.375, abs=1e-12) and found.end == pytest.approx(last, abs=1e-9)


def test_a_reflex_corner_is_no_tip():
    """An upright plate with a notch: at the bottom of the notch, (0, 0, 0), its edges go up, the plate goes down."""
    outline = [(0, 0, 0), (0, 1, 1), (0, 1, -1), (0, -1, -1), (0, -1, 1)]
    plate = fc.Polyhedron(outline, [tuple(range(5))]).translated((-1, 0, "1/4"))
    hit = fc.first_contact(plate.moving(ALONG), RING)
    assert hit.time < 0.75 and fc.first_contact(RING, plate.moving(ALONG)).status is not fc.Status.FREE


def test_vertices_that_nothing_uses_are_no_points():
    """The first vertex of the mesh grazes the ring, but no face has it."""
    x, faces = [(0, 0, 0), (0, 0, 9), (1, 0, 9), (0, 1, 9), (0, 0, 8)], [(1, 2, 3), (1, 4, 2), (1, 3, 4), (2, 4, 3)]
    loose = fc.Polyhedron(x, faces).translated((-1, 0, "1/4"))
    assert fc.first_contact(loose.moving(ALONG), RING).status is fc.Status.FREE


# -- seeded families ----------------------------------------------------------------------------------------


def turned(rng):
    """A rational rotation."""
    w, x, y, z = 1 + rng.randint(0, 4), *(rng.randint(-4, 4) for _ in range(3))
    n = F(w * w + x * x + y * y + z * z)
    return [
        [(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
        [2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n],
        [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n],
    ]


def on_circle(rng):
    t = F(rng.randint(-9, 9), rng.randint(1, 9))
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


class Scene:
    """A cone whose tip stands on a torus at the time `at`, and comes from outside."""

    def __init__(self, seed, place, kind):
        rng = random.Random(f"{seed} {place} {kind}")
        self.major = F(rng.randint(4, 16), rng.choice([1, 2, 4]))
        self.minor = self.major * F(rng.randint(1, 6), 10)
        (c, s), (p, q) = PLACES[place] or on_circle(rng), on_circle(rng)
        out = np.array([c * p, c * q, F(s)])
        self.tip = self.minor * out + self.major * np.array([p, q, F(0)])
        height = F(rng.randint(1, 8), 2) * self.minor
        self.size = height * F(rng.randint(1, 12), 16), height
        slope = float(self.size[0] / self.size[1])
        away = 0.05 + slope / math.hypot(1, slope)
        turns = (turned(rng) for _ in iter(int, 1))
        self.linear = next(m for m in turns if -float(np.dot(out, [row[2] for row in m])) > away)
        self.at, self.kind = F(rng.randint(4, 12), 16), kind
        while True:  # a motion that goes inwards there
            self.axis = [rng.randint(-3, 3) for _ in range(2)] + [rng.choice([-2, -1, 1])]
            self.point = [F(rng.randint(-40, 40), 8) * self.major for _ in range(3)]
            self.turns = rng.choice([-1, 1]) * F(rng.randint(1, 8), 24) if kind != "translation" else F(0)
            self.advance = F(rng.randint(-8, 8), 4) * self.minor if kind != "rotation" else F(0)
            step = np.subtract(self.moved(self.tip[None], float(self.at) + 1e-6), self.tip.astype(float))[0]
            if step @ out.astype(float) < -0.3 * np.linalg.norm(step):
                break

    def motion(self, way):
        if self.kind == "translation":
            return fc.Translation([way * self.advance * x for x in self.axis])
        if self.kind == "rotation":
            return fc.Rotation(self.axis, point=self.point, turns=way * self.turns)
        return fc.Screw(self.axis, point=self.point, degrees=360 * way * self.turns, advance=way * self.advance)

    def cone(self):
        """The cone as it stands at the start: rotations backwards are within 2^-60, shifts rounded."""
        tip = [row[2] * self.size[1] for row in self.linear]
        rows = [[*row, x - y] for row, x, y in zip(self.linear, self.tip, tip, strict=True)]
        cone = fc.cone(*self.size).transformed([*rows, [0, 0, 0, 1]])
        if self.kind != "translation":
            cone = cone.rotated(self.axis, point=self.point, degrees=-360 * self.turns * self.at)
        if self.kind == "rotation":
            return cone
        length = math.hypot(*self.axis) if self.kind == "screw" else 1
        return cone.translated([-F(float(self.at * self.advance * x) / length) for x in self.axis])

    def moved(self, x, t):
        """Points (n, 3) that stand so at `at`, at t."""
        x, axis, point = np.array(x, float), np.array(self.axis, float), np.array(self.point, float)
        if self.kind == "translation":
            return x + (t - float(self.at)) * float(self.advance) * axis
        axis = axis / np.linalg.norm(axis)
        angle, d = 2 * math.pi * float(self.turns) * (t - float(self.at)), x - point
        along = np.outer(d @ axis, axis)
        swung = point + along + (d - along) * math.cos(angle) + np.cross(axis, d) * math.sin(angle)
        return swung + float(self.advance) * (t - float(self.at)) * axis

    def outside(self, x):
        """(n,) distances of points from the torus."""
        return np.hypot(np.hypot(x[:, 0], x[:, 1]) - float(self.major), x[:, 2]) - float(self.minor)

    def truth(self):
        """When the tip is first on the torus; None where other points of the cone come first, by samples."""
        times = np.linspace(0, 1, 801)
        seen = np.array([self.outside(self.moved(self.tip[None], t))[0] for t in times])
        k = int(np.argmax(seen <= 0))
        if k == 0:
            return None
        lo, hi = times[k - 1], times[k]
        for _ in range(60):
            middle = 0.5 * (lo + hi)
            lo, hi = (lo, middle) if self.outside(self.moved(self.tip[None], middle))[0] <= 0 else (middle, hi)
        r, h = map(float, self.size)
        share, turn = (x.ravel() for x in np.meshgrid(np.geomspace(1e-5, 1, 24), np.linspace(0, 2 * math.pi, 33)))
        flank = np.column_stack([r * share * np.cos(turn), r * share * np.sin(turn), h * (1 - share)])
        base = flank * [1, 1, 0]
        x = (np.concatenate([flank, base]) - [0, 0, h]) @ np.array(self.linear, float).T + self.tip.astype(float)
        before = [*np.linspace(0, hi, 60)[:-1], *(hi - np.geomspace(1e-6, 1e-2, 8))]
        clear = all(self.outside(self.moved(x, t)).min() > 0 for t in before if t >= 0)
        return hi if clear else None


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", MOTIONS)
@pytest.mark.parametrize("place", PLACES)
def test_tips_in_all_orders(place, kind, seed):
    """The same time whoever moves and whichever comes first; backwards in time contact ends when it began."""
    scene = Scene(seed, place, kind)
    truth = scene.truth()
    if truth is None:
        return
    cone, torus = scene.cone(), fc.torus(scene.major, scene.minor)
    pairs = list(check(cone, torus, scene.motion(1), scene.motion(-1), truth, room=1e-13))
    a, b = pairs[seed % 4]
    for found in (fc.contact_intervals(a, b), fc.contact_intervals(b, a)):
        assert found.status is fc.Status.CONTACT and found[0].start == pytest.approx(truth, abs=1e-12)
