"""Bodies, motions and spans of any size: units of length and time, from the least doubles to the largest allowed.

A scene on a lattice is decided by the slow reference once; the same scene in other units has the same answer.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
import naive
from agreement import question, reference
from amount import amount
from firstcontact.exact.numbers import fraction
from generators import Scene, lattice_scene
from vectors import Body

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
SIZES = (-1060, -800, -540, -480, -400, -340, -300, -280, -250, -170, 147)


def in_units(scene: Scene, units) -> Scene:
    """The scene with coordinates multiplied by units, one per axis; of a rotation only its bodies and its point."""

    def scaled(v):
        return [F(float(x)) * u for x, u in zip(v, units, strict=True)]

    a, b = (Body([scaled(p) for p in body.v], body.e, body.f) for body in (scene.a, scene.b))
    if scene.rotation is not None:
        return replace(scene, a=a, b=b, rotation={**scene.rotation, "point": scaled(scene.rotation["point"])})
    return replace(scene, a=a, b=b, translation=tuple(scaled(scene.translation)))


@pytest.mark.share(2)
@MOTIONS
def test_one_unit_of_length(rotating):
    seen = Counter()
    for seed in range(70_000, 70_000 + amount(45, 3)):
        scene = lattice_scene(seed, rotating)
        status, _, nearest = reference(naive.first_contact, scene)
        seen[status] += 1
        for k in SIZES[seed % 3 :: 3]:
            engine = ("auto", "boxes", "lifted", "sweep")[(seed + k) % 4]
            hit = fc.first_contact(*question(in_units(scene, [F(2) ** k] * 3)), engine=engine)
            assert hit.status.name == status, (k, engine, scene)
            assert hit.time == (None if status == naive.FREE else nearest), (k, engine, scene)
    assert len(seen) >= 2


@MOTIONS
def test_composed_at_the_smallest_sizes(rotating):
    for seed in range(71_000, 71_003):
        scene = lattice_scene(seed, rotating)
        for k in (-1000, -300):
            assert_same_first_contact_in(scene, k, "composed")


def assert_same_first_contact_in(scene: Scene, k: int, engine: str) -> None:
    status, _, nearest = reference(naive.first_contact, scene)
    hit = fc.first_contact(*question(in_units(scene, [F(2) ** k] * 3)), engine=engine)
    assert (hit.status.name, hit.time) == (status, None if status == naive.FREE else nearest), (k, engine, scene)


@pytest.mark.share(2)
@MOTIONS
def test_every_axis_in_its_own_unit(rotating):
    """Needles and flakes: sizes beside distances as unlike as doubles allow."""

    def scene(seed):
        units = [F(2) ** int(k) for k in np.random.default_rng(seed).choice([-300, -270, -100, 0, 100], 3)]
        return in_units(lattice_scene(seed, rotating), units)

    seen = Counter()
    for seed in range(72_000, 72_000 + amount(45, 3)):
        s = scene(seed)
        status, _, nearest = reference(naive.first_contact, s)
        hit = fc.first_contact(*question(s))
        assert (hit.status.name, hit.time) == (status, None if status == naive.FREE else nearest), s
        seen[status] += 1
    assert len(seen) == 3


@pytest.mark.parametrize("k", [-1100, -1040, -700, -200, 140])
def test_speeds(k):
    """As many times as quick, and as many times sooner; from 2^-1040 on spans end beyond the largest double."""
    met = 0
    for seed in range(73_000, 73_000 + amount(30, 3)):
        scene = lattice_scene(seed, False)
        until = F(4) if scene.until is None else F(scene.until)
        status, time, _ = reference(naive.first_contact, replace(scene, until=until))
        quick = tuple(F(float(x)) * F(2) ** k for x in scene.translation)
        a, b, _ = question(scene)
        hit = fc.first_contact(a.body.moving(fc.Translation(quick)), b, (0, until / F(2) ** k), exact=True)
        assert hit.status.name == status, (k, scene)
        if status == naive.CONTACT:
            met += 1
            assert hit.time_exact == F(int(time.numer()), int(time.denom())) / F(2) ** k, (k, scene)
    assert met


def test_a_component_of_a_velocity_below_all_doubles():
    """It decides only after a time as long; the rod of 2^-1100 a second needs 2^1100 seconds."""
    point = fc.Polyhedron([(0, 0, 0)], [])
    bar = fc.Polyhedron([(F(2) ** 149, -1, 1), (F(2) ** 149, 3, 1)], [], edges=[(0, 1)])
    speed = fc.Translation((F(2) ** 149 / F(2) ** 1100, 0, F(1, 2**1100)))
    hit = fc.first_contact(point.moving(speed), bar, (0, F(2) ** 1101), exact=True)
    assert hit.time_exact == F(2) ** 1100


@pytest.mark.parametrize("k", [-1000, -500, -400, -300, -280, 140])
def test_a_post_that_turns_into_a_wall(k):
    """By hand: after a quarter turn, in every engine."""
    u = F(2) ** k
    post = fc.Polyhedron([(u, 0, 0), (u, 0, u)], [], edges=[(0, 1)])
    wall = fc.Polyhedron([(0, -4 * u, -4 * u), (0, 4 * u, -4 * u), (0, 0, 8 * u)], [(0, 1, 2)])
    for engine in ("auto", "boxes", "lifted", "composed", "sweep"):
        hit = fc.first_contact(post.moving(fc.Rotation((0, 0, 1), turns=1)), wall, engine=engine, exact=True)
        assert hit.time_exact == F(1, 4), engine


def test_coordinates_below_all_doubles_are_no_zeros():
    """A gap of 2^-1200 between a plate and what passes over it."""
    e = F(1, 2**1200)
    plate = fc.Polyhedron([(0, 0, 0), (e, 0, 0), (0, e, 0)], [(0, 1, 2)])
    over = fc.Polyhedron([(-e, e / 8, e / 4), (-2 * e, e / 8, e / 4)], [], edges=[(0, 1)])
    assert fc.first_contact(over.moving(fc.Translation((8 * e, 0, 0))), plate).status is fc.Status.FREE
    hit = fc.first_contact(over.moving(fc.Translation((8 * e, 0, -2 * e))), plate, exact=True)
    assert hit.status is fc.Status.CONTACT and hit.time_exact == F(1, 8)


def test_a_map_that_leaves_the_range_of_doubles_is_not_exact():
    """Scaled by 2^-1000, doubles of 2^-100 are none any more; scaled back they are."""
    body = fc.Polyhedron([(1, 0, 0), (0, 1, 0), (0, 0, F(1, 2**100))], [(0, 1, 2)])
    small = [[F(1, 2**1000) if i == j < 3 else int(i == j) for j in range(4)] for i in range(4)]
    large = [[F(2**1000) if i == j < 3 else int(i == j) for j in range(4)] for i in range(4)]
    there = body.transformed(small)
    assert there.error > 0.0 and fraction(there.exact_vertex(2)[2]) == F(1, 2**1100)
    assert fraction(there.transformed(large).exact_vertex(2)[2]) == F(1, 2**100)
