"""Polyhedra of any shape against models that are no unions of convex parts: drilled plates, hollow balls."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from amount import amount

PLATE = (fc.box((8, 8, 2)) - fc.cylinder(2, 4).named("hole")).named("plate")
WAIST = fc.hyperboloid(["1", "1", "1"], 2, sheets=1).named("waist")
SHELL = (fc.sphere(3) - fc.sphere(2)).named("shell")
FALL = fc.Translation((0, 0, -10))
SCREW = fc.Screw((0, 0, 1), degrees=300, advance=1)
UP = fc.Translation((0, 0, 1))
PARTS = [
    fc.examples.box((3, 1, 1)).translated((1.5, 0.5, 0.5)),
    fc.examples.box((1, 2, 1)).translated((0.5, 2, 0.5)),
]


def ell() -> fc.Polyhedron:
    """The union of PARTS."""
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    return fc.Polyhedron([(*p, z) for z in (0, 1) for p in outline], [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides])


def star(n, outer, inner, low, high) -> fc.Polyhedron:
    """A prism over a star of 2 n corners."""
    m, angle = 2 * n, np.pi * np.arange(2 * n) / n
    radius = np.where(np.arange(m) % 2 == 0, outer, inner)
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    sides = [[k, (k + 1) % m, m + (k + 1) % m, m + k] for k in range(m)]
    faces = [list(range(m))[::-1], list(range(m, 2 * m)), *sides]
    return fc.Polyhedron([(*p, z) for z in (low, high) for p in ring], faces, name="pin")


CAPSULE = fc.cylinder(1, 2) | fc.sphere(1).translated((0, 0, 1)) | fc.sphere(1).translated((0, 0, -1))
PIN = star(8, 1.5, 1.2, -2, 2)


def random_motion(rng, toward):
    kind = rng.integers(3)
    if kind == 0:
        return fc.Translation(toward + rng.normal(size=3) * 0.3)
    if kind == 1:
        return fc.Screw(toward, rng.normal(size=3), degrees=float(rng.uniform(-200, 200)), advance=6.0)
    return fc.Sequence([fc.Translation(toward * 0.4), fc.Rotation((0, 0, 1), degrees=90), fc.Translation(toward)])


def test_an_angle_touches_when_its_first_part_does():
    rng = np.random.default_rng(11)
    seen = {status: 0 for status in fc.Status}
    for k in range(amount(18, 3)):
        place = np.array([*rng.normal(size=2) * 1.5, 4.0]) if k % 3 else rng.normal(size=3) * 2.0
        turn = {"axis": rng.normal(size=3), "degrees": float(rng.uniform(0, 180))}
        motion, model = random_motion(rng, -place), (WAIST, PLATE, PLATE, SHELL)[k % 4]
        placed = [x.rotated(**turn).translated(place).moving(motion) for x in (ell(), *PARTS)]
        found, *parts = (fc.first_contact(x, model) if k % 2 else fc.first_contact(model, x) for x in placed)
        known = [x for x in parts if x.status is not fc.Status.FREE]
        seen[found.status] += 1
        if not known:
            assert found.status is fc.Status.FREE
            continue
        assert all(x.status is not fc.Status.UNDECIDED for x in known)
        first = min(known, key=lambda x: x.time)
        assert found.status is first.status and found.time == pytest.approx(first.time, abs=3e-12)
        if found.status is fc.Status.CONTACT:
            lo, hi = found.time_interval
            assert lo <= found.time <= hi and hi - lo <= 1.0001e-12 * motion.span[1]
            np.testing.assert_allclose(found.point, first.point, atol=1e-6)
            np.testing.assert_allclose(found.normal, first.normal, atol=1e-5)
            side = "element_a" if k % 2 == 0 else "element_b"
            assert getattr(found, side) == getattr(first, side)
    assert seen[fc.Status.CONTACT] >= 3 and seen[fc.Status.INITIAL_CONTACT] >= 1


def test_a_pin_falls_through_the_hole():
    above = PIN.translated((0, 0, 5))
    assert fc.first_contact(above.moving(FALL), PLATE).status is fc.Status.FREE
    assert fc.first_contact(PLATE, above.moving(FALL)).status is fc.Status.FREE
    wide = star(5, 2.1, 1.2, 3, 7)
    hit = fc.first_contact(wide.moving(FALL), PLATE)
    assert hit.time == pytest.approx(0.2, abs=1e-12) and hit.contact_set is None  # all tips, on the face
    np.testing.assert_allclose(hit.normal, (0, 0, 1), atol=1e-12)


def test_a_tilted_pin_meets_the_rim():
    tilted = PIN.rotated((1, 0.25, 0), degrees=20).translated((0, 0, 6))
    hit = fc.first_contact(tilted.moving(FALL), PLATE)
    assert hit.element_a.kind == "edge" and hit.element_b.label == "plate.hole.rim.top"
    assert np.hypot(*hit.point[:2]) == pytest.approx(2, abs=1e-9) and hit.point[2] == pytest.approx(1, abs=1e-9)
    assert hit.normal[2] > 0
    exact = fc.first_contact(PLATE, tilted.moving(FALL), exact=True)
    assert exact.time_exact is not None and exact.time == pytest.approx(hit.time, abs=1e-12)
    assert exact.element_b == hit.element_a and np.allclose(exact.normal, -hit.normal, atol=1e-9)


def test_in_the_hole_from_the_start():
    assert fc.first_contact(PIN.moving(SCREW), PLATE).status is fc.Status.FREE
    aside = PIN.moving(fc.Translation((1, 0.25, 0)))
    hit, back = fc.first_contact(aside, PLATE), fc.first_contact(PLATE, aside)
    tips = PIN.vertices[:16:2, :2]
    p, v = tips @ [1, 0.25], 1 + 0.25**2
    times = (-p + np.sqrt(p**2 + v * (4 - (tips**2).sum(axis=1)))) / v
    assert hit.time == pytest.approx(times.min(), abs=1e-12) and hit.element_b.label == "plate.hole.side"
    assert back.element_a == hit.element_b and np.allclose(back.normal, -hit.normal, atol=1e-9)
    assert np.dot(hit.normal, hit.point * (1, 1, 0)) < 0  # towards the pin
    assert hit.contact_set is None  # all along the wall


@pytest.mark.share(6)
@pytest.mark.parametrize(
    ("body", "model", "kind"),
    [
        (PIN.translated((1, 0, 0)), PLATE, "overlapping"),
        (star(6, 0.25, 0.125, -0.25, 0.25).translated((3, 0, 0)), PLATE, "containment"),
        (star(6, 0.5, 0.3, -1.5, 1.5), CAPSULE, "containment"),  # across its parts
        (fc.Polyhedron([[-3, -0.5, 0], [3, -0.5, 0], [3, 0.5, 0], [-3, 0.5, 0]], [[0, 1, 2, 3]]), PLATE, "overlapping"),
        (star(6, 0.3, 0.15, -0.3, 0.3).translated((0, 0, 2.5)), SHELL, "containment"),
        (star(12, 2.12, 2.1, -2.05, 2.05), SHELL, "overlapping"),  # in the material, around the hollow
        (star(6, 30, 20, -10, 10), PLATE, "containment"),
        (star(6, 30, 20, -10, 10), SHELL, "containment"),
        (star(6, 1.9, 1.2, -0.9, 0.9), PLATE | fc.box((1, 1, 1)), "containment"),  # of what stands in the hole
    ],
)
def test_starts_in_contact(body, model, kind):
    hit = fc.first_contact(body.moving(SCREW), model)
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == kind and hit.time == 0.0


def test_in_the_hollow_of_a_ball():
    body = star(6, 0.3, 0.15, -0.3, 0.3)
    assert fc.first_contact(body.moving(fc.Screw((0, 1, 0), turns=2, advance=1.5)), SHELL).status is fc.Status.FREE
    hit = fc.first_contact(body.moving(fc.Translation((3, 0.1, 0.2))), SHELL)
    assert np.linalg.norm(hit.point) == pytest.approx(2, abs=1e-9)
    assert str(hit.element_a) == "pin vertex 12" and hit.contact_set == "point"


def test_a_jump_into_the_wall():
    aside, up = np.eye(4), np.eye(4)
    aside[0, 3], up[:3, 3] = 1, (1, 0, 1)
    hit = fc.first_contact(PIN.moving(fc.Sequence([UP, fc.RationalMotion.between(aside, up)])), PLATE)
    assert hit.status is fc.Status.CONTACT and hit.time == hit.free_until == 0.5 and hit.normal is None


def test_few_boxes_leave_it_undecided():
    hit = fc.first_contact(PIN.moving(SCREW), PLATE, budget=3000)
    assert hit.status is fc.Status.UNDECIDED and hit.reason == "budget" and hit.free_until == 0.0


def test_the_corner_of_a_sheet_is_a_vertex():
    """Two triangles in one plane meet there, and end."""
    sheet = fc.Polyhedron([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [[0, 1, 2], [0, 2, 3]], name="sheet")
    start = sheet.rotated((0, 1, 0), degrees=90).rotated((1, 0, 0), degrees=45).translated((0, 0, 5))
    hit = fc.first_contact(start.moving(FALL), fc.sphere(1), exact=True)
    assert hit.element_a.kind == "vertex" and hit.time == pytest.approx((4 - np.sqrt(2)) / 10, abs=1e-9)
    assert fc.first_contact(start.translated((3, 0, 0)).moving(FALL), PLATE).element_a.kind == "vertex"


def test_contact_ends_where_the_pin_has_left_the_wall():
    there = fc.Translation((1, 0, 0))
    found = fc.contact_intervals(PIN.moving(there), PLATE)
    assert len(found.intervals) == 1 and found.intervals[0].start == pytest.approx(0.5, abs=1e-11)


@pytest.mark.share(2)
@pytest.mark.parametrize("swap", [False, True], ids=["", "swapped"])
def test_that_one_pair_meets_is_not_told_where_that_is_not_known(swap):
    """A corner lands on the rim of a bite: which of the events there is named depends on rounding."""
    bite = fc.ellipsoid(("63/20", "63/20", "7/4")).transformed([
        ["-5/13", "144/169", "-60/169", "4704/4225"], ["48/65", "9/169", "-568/845", "-14203/16900"],
        ["-36/65", "-88/169", "-549/845", "-8001/4225"], [0, 0, 0, 1],
    ])  # fmt: skip
    can = fc.cylinder("1/2", 2).translated((0, "1/2", "1/4")) - bite
    corners = [("746/105", "-62/7", "361/210"), ("142/21", "-134/7", "-187/42"), ("1/3", -4, "-1/6")]
    leaf = fc.Polyhedron(corners, [[0, 1, 2]]).moving(fc.Translation((-1, 12, "1/2")))
    hit = fc.first_contact(*((leaf, can) if swap else (can, leaf)))
    assert hit.status is fc.Status.CONTACT and hit.time_interval[0] <= 1 / 3 <= hit.time_interval[1]
    assert hit.point == pytest.approx([0, 0, 0], abs=1e-9)
    assert hit.multiplicity > 1 or hit.contact_set is None
