"""Laws that hold whatever the scene: what one question answers, another one must confirm, exactly."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
import generators as g
from agreement import polyhedron
from amount import amount
from generators import Scene, lattice_scene
from vectors import Body

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
SEEDS = range(60_000, 60_000 + amount(80, 4))


def scenes(rotating: bool):
    """Lattice scenes and near-miss families; every motion over its span (0, 1)."""
    for seed in SEEDS:
        s = lattice_scene(seed, rotating)
        if rotating:
            yield s
        else:
            yield Scene(s.a, s.b, translation=tuple(3 * Fraction(x) for x in s.translation))
    for name, family in g.FAMILIES.items():
        a, b = family(6, len(name))
        if rotating:
            yield Scene(
                g.to_tangent(a), g.to_tangent(b), rotation={"axis": (0, 0, 1), "point": (0, 0, 0), "turns": 1}
            )
        else:
            yield Scene(a, b, translation=(0, 0, 1))


def motion(scene: Scene, factor=1):
    if scene.translation is not None:
        return fc.Translation([factor * Fraction(x) for x in scene.translation])
    keys = dict(scene.rotation)
    unit = "turns" if "turns" in keys else "radians"
    return fc.Rotation(**{**keys, unit: factor * keys[unit]})


def reversed_motion(scene: Scene):
    return motion(scene, -1)


def bodies(scene: Scene) -> tuple[fc.Polyhedron, fc.Polyhedron]:
    return polyhedron(scene.a, name="a"), polyhedron(scene.b, name="b")


def answer(hit: fc.FirstContact) -> tuple:
    return hit.status, hit.time, hit.time_exact if isinstance(hit.time_exact, Fraction) else None


def ask(a, b, span=None) -> tuple:
    return answer(fc.first_contact(a, b, span, exact=True))


@MOTIONS
def test_the_other_body_moves_backwards(rotating):
    for scene in scenes(rotating):
        a, b = bodies(scene)
        assert ask(a.moving(motion(scene)), b) == ask(a, b.moving(reversed_motion(scene))), scene


@MOTIONS
def test_the_bodies_swap_places(rotating):
    for scene in scenes(rotating):
        a, b = bodies(scene)
        hit, swapped = (
            fc.first_contact(a.moving(motion(scene)), b),
            fc.first_contact(b, a.moving(motion(scene))),
        )
        assert answer(hit) == answer(swapped), scene
        if hit.status is not fc.Status.CONTACT:
            continue
        assert hit.multiplicity == swapped.multiplicity, scene
        if hit.multiplicity == 1:
            assert np.allclose(hit.point, swapped.point, atol=1e-12), scene
            assert (hit.element_a.kind, hit.element_a.index) == (
                swapped.element_b.kind,
                swapped.element_b.index,
            )
            assert (hit.normal is None) == (swapped.normal is None)
            assert hit.normal is None or np.allclose(hit.normal, -swapped.normal, atol=1e-12), scene


def test_time_runs_backwards_along_a_line():
    for scene in scenes(False):
        a, b = bodies(scene)
        there = fc.contact_intervals(a.moving(motion(scene)), b, exact=True)
        back = fc.contact_intervals(
            a.translated(scene.translation).moving(reversed_motion(scene)), b, exact=True
        )
        mirrored = [(1 - i.end_exact, 1 - i.start_exact) for i in reversed(there)]
        assert [(i.start_exact, i.end_exact) for i in back] == mirrored, scene


@pytest.mark.share(4)
@pytest.mark.parametrize("degrees", [90, 180, 270])
def test_time_runs_backwards_in_a_turn(degrees):
    for seed in SEEDS:
        scene = lattice_scene(seed, True)
        a, b = bodies(scene)
        keys = {"axis": (0, 0, 1), "point": scene.rotation["point"]}
        there = fc.contact_intervals(a.moving(fc.Rotation(**keys, degrees=degrees)), b)
        turned = a.rotated(**keys, degrees=degrees)
        back = fc.contact_intervals(turned.moving(fc.Rotation(**keys, degrees=-degrees)), b)
        assert len(there) == len(back), scene
        for i, j in zip(there, reversed(back), strict=True):
            assert abs(i.start - (1 - j.end)) <= 2.0**-51 and abs(i.end - (1 - j.start)) <= 2.0**-51, scene


@pytest.mark.share(2)
@MOTIONS
@pytest.mark.parametrize("cut", [Fraction(1, 2), Fraction(1, 4), Fraction(5, 8)])
def test_a_split_span_gives_the_same_first_contact(cut, rotating):
    for scene in scenes(rotating):
        a, b = bodies(scene)
        if rotating and "radians" in scene.rotation:
            continue  # the pose at the cut is irrational: see the enclosure test below
        moving = a.moving(motion(scene))
        whole = ask(moving, b, (0, 1))
        first = ask(moving, b, (0, cut))
        if whole[0] is fc.Status.CONTACT and whole[1] > cut or whole[0] is fc.Status.FREE:
            assert first[0] is fc.Status.FREE, scene
            assert ask(moving, b, (cut, 1))[:2] == whole[:2], scene
        else:
            assert first == whole, scene


def test_a_span_that_starts_in_an_irrational_pose():
    for scene in scenes(True):
        a, b = bodies(scene)
        moving = a.moving(motion(scene))
        whole = fc.first_contact(moving, b)
        if whole.status is not fc.Status.CONTACT or whole.time < 0.01:
            continue
        cut = whole.time / 3
        late = fc.first_contact(moving, b, (cut, 1))
        assert late.status is fc.Status.CONTACT, scene
        assert abs(late.time - whole.time) <= 1e-12, scene


@pytest.mark.share(2)
@MOTIONS
def test_first_contact_is_the_start_of_the_first_interval(rotating):
    for scene in scenes(rotating):
        a, b = bodies(scene)
        if rotating and scene.rotation.get("radians") == 7:
            continue
        hit, found = (
            fc.first_contact(a.moving(motion(scene)), b),
            fc.contact_intervals(a.moving(motion(scene)), b),
        )
        assert hit.status is found.status, scene
        assert [hit.time] == [i.start for i in found][:1] or (hit.time is None and not found.intervals), scene


# (2, -1, 2) / 3 and its fellows: a rational rotation; then a rational shift.
ROWS = [[Fraction(x, 3) for x in row] for row in ((2, -1, 2), (2, 2, -1), (-1, 2, 2))]
SHIFT = [Fraction(3, 7), Fraction(-5), Fraction(1, 9)]
POSE = [[*row, d] for row, d in zip(ROWS, SHIFT, strict=True)] + [[0, 0, 0, 1]]


def turned(v) -> list[Fraction]:
    return [sum((m * Fraction(x) for m, x in zip(row, v, strict=True)), Fraction(0)) for row in ROWS]


def posed(scene: Scene):
    if scene.translation is not None:
        return fc.Translation(turned(scene.translation))
    point = [x + d for x, d in zip(turned(scene.rotation["point"]), SHIFT, strict=True)]
    return fc.Rotation(**{**scene.rotation, "axis": turned(scene.rotation["axis"]), "point": point})


@MOTIONS
def test_one_rigid_motion_of_everything_changes_no_time(rotating):
    for scene in scenes(rotating):
        a, b = bodies(scene)
        moved = ask(a.transformed(POSE).moving(posed(scene)), b.transformed(POSE))
        assert moved == ask(a.moving(motion(scene)), b), scene


@pytest.mark.share(3)
@MOTIONS
@pytest.mark.parametrize(
    "factor", [Fraction(2) ** -40, Fraction(2) ** 30, Fraction(254, 10), Fraction(1, 1000)], ids=str
)
def test_units_of_length_change_no_time(factor, rotating):
    for scene in scenes(rotating):
        a, b = bodies(scene)
        larger = Scene(_scaled(scene.a, factor), _scaled(scene.b, factor), *_scaled_motion(scene, factor))
        c, d = bodies(larger)
        assert ask(c.moving(motion(larger)), d) == ask(a.moving(motion(scene)), b), scene


def _scaled(body: Body, factor: Fraction) -> Body:
    return Body([[factor * Fraction(x) for x in p] for p in body.v], body.e, body.f)


def _scaled_motion(scene: Scene, factor: Fraction):
    if scene.translation is not None:
        return tuple(factor * Fraction(x) for x in scene.translation), None
    return None, {**scene.rotation, "point": [factor * Fraction(x) for x in scene.rotation["point"]]}


def test_units_of_time():
    for scene in scenes(False):
        a, b = bodies(scene)
        status, _, time = ask(a.moving(motion(scene)), b, (0, 4))
        faster = ask(a.moving(motion(scene, 8)), b, (0, Fraction(1, 2)))
        assert faster[0] is status and faster[2] == (None if time is None else time / 8), scene


def test_turns_degrees_and_a_longer_axis_are_one_motion():
    for scene in scenes(True):
        if "turns" not in scene.rotation:
            continue
        a, b = bodies(scene)
        turns, axis, point = (scene.rotation[k] for k in ("turns", "axis", "point"))
        truth = ask(a.moving(motion(scene)), b)
        assert ask(a.moving(fc.Rotation(axis, point=point, degrees=360 * turns)), b) == truth, scene
        assert ask(a.moving(fc.Rotation([-3 * x for x in axis], point=point, turns=-turns)), b) == truth, (
            scene
        )


@MOTIONS
def test_order_and_direction_of_elements_change_no_time(rotating):
    def shuffled(body: Body, rng) -> Body:
        place = rng.permutation(len(body.v)).tolist()
        points = [None] * len(body.v)
        for i, p in zip(place, body.v, strict=True):
            points[i] = p
        edges, faces = ([[place[i] for i in reversed(x)] for x in part] for part in (body.e, body.f))
        rng.shuffle(edges)
        rng.shuffle(faces)
        return Body(points, edges, faces)

    for k, scene in enumerate(scenes(rotating)):
        rng = np.random.default_rng(k)
        a, b = bodies(scene)
        c, d = bodies(Scene(shuffled(scene.a, rng), shuffled(scene.b, rng)))
        assert ask(c.moving(motion(scene)), d) == ask(a.moving(motion(scene)), b), scene
