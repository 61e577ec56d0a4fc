"""First contact of composite quadric models against known answers, and against its own mirror images."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.result import AlgebraicNumber
from quadric_vectors import RATIONAL

BY_NAME = {v.name: v for v in RATIONAL}
EACH = pytest.mark.parametrize("vector", RATIONAL, ids=lambda v: v.name)


METHODS = pytest.mark.parametrize("method", ["auto", "algebraic"])


def agrees(hit, vector, method="auto") -> None:
    if not vector.contact:
        assert hit.status is fc.Status.FREE
        return
    start = vector.time == 0
    assert hit.status is (fc.Status.INITIAL_CONTACT if start else fc.Status.CONTACT)
    assert abs(hit.time - float(vector.time)) <= (1e-15 if method == "auto" else 2.3e-16)
    lo, hi = hit.time_interval
    rounded = Fraction(1, 10**24)  # the answers are given to 25 digits
    assert Fraction(lo) - rounded <= vector.time <= Fraction(hi) + rounded
    assert hi - lo <= (1e-12 if method == "auto" else 1e-15)


@pytest.mark.share(10)
@EACH
@METHODS
def test_known_answers(vector, method):
    hit = fc.first_contact(*vector.bodies, method=method)
    agrees(hit, vector, method)
    if vector.contact:
        points = np.array(vector.points)
        distance = np.abs(points - hit.point).max(axis=1).min()
        if hit.contact_set == "segment":
            assert all(on_segment(p, *hit.contact_set.points) for p in points)
        else:
            assert distance <= 1e-9


def on_segment(p, start, end) -> bool:
    s = np.dot(p - start, end - start) / np.dot(end - start, end - start)
    return -1e-9 <= s <= 1 + 1e-9 and np.abs(start + s * (end - start) - p).max() <= 1e-9


@pytest.mark.share(5)
@EACH
def test_swapping_the_bodies_turns_the_normal(vector):
    a, b = vector.bodies
    hit, back = fc.first_contact(a, b), fc.first_contact(b, a)
    assert hit.status is back.status
    if hit.time is not None:
        assert hit.time == pytest.approx(back.time, abs=1e-15)
    if hit.multiplicity == back.multiplicity == 1:
        assert (hit.element_a, hit.element_b) == (back.element_b, back.element_a)
        if hit.normal is not None and back.normal is not None:
            assert np.allclose(hit.normal, -back.normal, atol=1e-9)


@pytest.mark.share(5)
@EACH
def test_both_paths_agree(vector):
    """Certified floats and exact algebra share no code beyond the model."""
    certified, exact = (fc.first_contact(*vector.bodies, method=m) for m in ("auto", "algebraic"))
    assert certified.status is exact.status and certified.contact_set == exact.contact_set
    if certified.status is fc.Status.CONTACT:
        assert certified.time == pytest.approx(exact.time, abs=1e-15)
        assert certified.time_interval[0] <= exact.time_interval[1]
        assert exact.time_interval[0] <= certified.time_interval[1]
        names = [(p.element_a, p.element_b) for p in exact.others] + [(exact.element_a, exact.element_b)]
        assert (certified.element_a, certified.element_b) in names
        if certified.contact_set == "point":
            assert np.allclose(certified.point, exact.point, atol=1e-9)
        if certified.normal is not None and exact.normal is not None:
            assert np.allclose(certified.normal, exact.normal, atol=1e-7)


@pytest.mark.parametrize("name", ["paper_example7", "ball_hits_hole_rim", "ellipsoid_box_edge", "sphere_sphere_graze"])
def test_splitting_the_span(name):
    vector = BY_NAME[name]
    time = float(vector.time)
    before, after = time - 0.01, min(1.0, time + 0.1)
    assert fc.first_contact(*vector.bodies, span=(0, before)).status is fc.Status.FREE
    agrees(fc.first_contact(*vector.bodies, span=(before, after)), vector)


@pytest.mark.parametrize("name", ["paper_example7", "cone_rim_sphere", "sphere_sphere_graze", "rim_vs_box_edge"])
def test_exact_times(name):
    hit = fc.first_contact(*BY_NAME[name].bodies, exact=True)
    assert isinstance(hit.time_exact, Fraction | AlgebraicNumber)
    assert float(hit.time_exact) == hit.time


@pytest.mark.thorough
def test_normals_point_from_b_to_a():
    """A step along the normal of about 1e-6 leads out of b, a step back leads out of a."""
    checked = 0
    for vector in RATIONAL:
        if not vector.contact or vector.time == 0:
            continue
        hit = fc.first_contact(*vector.bodies)
        if hit.normal is None or hit.contact_set != "point":
            continue
        a, b = (body.at(hit.time) for body in vector.bodies)
        assert not b.contains(hit.point + 1e-5 * hit.normal), vector.name
        assert not a.contains(hit.point - 1e-5 * hit.normal), vector.name
        checked += 1
    assert checked > 25


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("parallel_cylinders_on_table", "segment"),
        ("cylinder_falls_flat_on_plane", "segment"),
        ("box_side_cylinder_on_table", "segment"),
        ("ball_in_tube", "point"),
    ],
)
def test_contact_sets(name, kind):
    assert fc.first_contact(*BY_NAME[name].bodies).contact_set == kind


def test_a_ball_that_settles_into_a_conical_seat_touches_in_a_circle():
    hollow = fc.cone(1, 1).rotated((1, 0, 0), degrees=180).translated((0, 0, 2))
    seat = fc.box((4, 4, 2)).translated((0, 0, 1)) - hollow
    ball = fc.sphere("1/2").translated((0, 0, 4))
    hit = fc.first_contact(ball.moving(fc.Translation((0, 0, -4))), seat)
    # the cone z = 1 + r under a ball of radius 1/2: its centre comes down to z = 1 + sqrt(2)/2
    assert hit.time == pytest.approx((3 - 2**0.5 / 2) / 4, abs=1e-15)
    assert hit.contact_set == "conic arc"
    radius = np.hypot(*hit.contact_set.points[:, :2].T)
    assert radius == pytest.approx(2**0.5 / 4, abs=1e-9)


def test_boxes_that_meet_flat_touch_in_a_patch():
    large, small = fc.box((2, 2, 2)), fc.box((1, 1, 1)).translated((0, 0, -3))
    hit = fc.first_contact(large.moving(fc.Translation((0, 0, -4))), small)
    assert (hit.time, hit.contact_set) == (0.375, "patch") and "CONTACT at time 0.375 in a patch at (" in str(hit)
    assert hit.contact_set.points[:, 2] == pytest.approx(-2.5)


# -- Algorithm 1 made visible -------------------------------------------------------------------------------------

RIM = 0.63411687034328004228
FIRST, LAST = 0.8 - 11**0.5 / 20, 0.8 + 11**0.5 / 20
# times and multiplicities of Example 7 (Choi et al. 2014), re-derived; rows by features of a and b
EXAMPLE_7 = {
    ("side", "side"): [(0.5, 4), (0.625, 1), (0.875, 2)],
    **{pair: [(0, 2), (RIM, 1), (1, 4)] for pair in (
        ("side", "rim.bottom"), ("side", "rim.top"), ("rim.bottom", "side"), ("rim.top", "side"))},
    **{pair: [(0, 1), (0.5, 2), (1, 1)] for pair in (
        ("bottom", "rim.bottom"), ("top", "rim.top"), ("rim.bottom", "bottom"), ("rim.top", "top"))},
    **{pair: [(0, 1), (1, 1)] for pair in (
        ("bottom", "rim.top"), ("top", "rim.bottom"), ("rim.top", "bottom"), ("rim.bottom", "top"))},
    **{pair: [(0.5, 12), (FIRST, 1), (0.875, 2), (LAST, 1)] for pair in (
        ("rim.bottom", "rim.bottom"), ("rim.top", "rim.top"))},
    **{pair: [(0.5, 10), (0.875, 2)] for pair in (("rim.bottom", "rim.top"), ("rim.top", "rim.bottom"))},
}  # fmt: skip


def test_the_subproblems_of_example_7():
    hit = fc.first_contact(*BY_NAME["paper_example7"].bodies, method="algebraic")
    found = {
        (s.element_a.label.removeprefix("a."), s.element_b.label.removeprefix("b.")): s for s in hit.subproblems
    }
    assert len(hit.subproblems) == len(found) == 17 and set(found) == set(EXAMPLE_7)
    for pair, expected in EXAMPLE_7.items():
        rows = found[pair].candidates
        assert [c.multiplicity for c in rows] == [m for _, m in expected], pair
        assert [c.time for c in rows] == pytest.approx([t for t, _ in expected], abs=1e-15), pair
    verdicts = {c.time: (c.verdict, c.reason) for c in found["side", "side"].candidates}
    assert verdicts[0.625] == ("contact", "")
    assert verdicts[0.5][0] == verdicts[0.875][0] == "no contact" and verdicts[0.875][1] == "crossing tangency"
    assert np.allclose(found["side", "side"].candidates[1].point, (-7.5, 10, 0), atol=1e-12)
    assert found["side", "side"].case == "I" and "case VII" in str(found["rim.top", "rim.top"])


# -- contact intervals --------------------------------------------------------------------------------------------


def test_a_ball_passes_through_another():
    ball = fc.sphere(1)
    found = fc.contact_intervals(ball.moving(fc.Translation((8, 0, 0))), ball.translated((4, 0, 0)), exact=True)
    assert [(i.start_exact, i.end_exact) for i in found] == [(Fraction(1, 4), Fraction(3, 4))]


def test_a_ball_through_a_hoop_touches_twice():
    """A ball of radius 1 crosses a plate with a hole of radius 2, off centre by more than 1: in, out of the hole."""
    plate = fc.box((8, 8, 1)) - fc.cylinder(2, 2)
    path = fc.Translation((0, 0, -8))
    touching = fc.contact_intervals(fc.sphere(1).translated((1.5, 0, 4)).moving(path), plate)
    passing = fc.contact_intervals(fc.sphere(1).translated((0.5, 0, 4)).moving(path), plate)
    assert len(touching) == 1 and passing.status is fc.Status.FREE
    (interval,) = touching
    assert interval.start + interval.end == pytest.approx(1.0, abs=1e-14)
    # rim at distance 1/2 from the centre line: centre at height 1/2 + sqrt(3)/2
    assert interval.start == pytest.approx((4 - 0.5 - 0.75**0.5) / 8, abs=1e-15)


def test_a_graze_is_an_interval_of_one_instant():
    ball = fc.sphere(1)
    found = fc.contact_intervals(ball.translated((-4, 2, 0)).moving(fc.Translation((8, 0, 0))), ball)
    assert [(i.start, i.end) for i in found] == [(0.5, 0.5)]


def test_what_overlaps_from_the_start():
    ball = fc.sphere(1)
    inner = fc.sphere("1/4")
    out = fc.Translation((4, 0, 0))
    assert fc.first_contact(ball.translated((1, 0, 0)).moving(out), ball).initial == "overlapping"
    assert fc.first_contact(inner.moving(out), ball).initial == "containment"
    assert fc.first_contact(ball.translated((2, 0, 0)).moving(out), ball).initial == "touching"
    found = fc.contact_intervals(inner.moving(out), ball)
    assert found.status is fc.Status.INITIAL_CONTACT
    assert [(i.start, i.end) for i in found] == [(0.0, 1.25 / 4)]


def test_rotations_at_constant_speed():
    """A peg on a disc turns by 270 degrees into a post a quarter turn ahead; the time is that of the angle."""
    peg = fc.cylinder(1, 4).translated((4, 0, 0))
    post = fc.cylinder(1, 4).translated((0, 4, 0))
    hit = fc.first_contact(peg.moving(fc.Rotation((0, 0, 1), degrees=270)), post, exact=True)
    # centres at distance 4 from the axis touch where they are 2 apart
    angle = np.pi / 2 - 2 * np.arcsin(1 / 4)
    assert hit.time == pytest.approx(angle / (1.5 * np.pi), abs=2e-16)
    assert hit.contact_set == "patch" or hit.contact_set == "segment"
    assert isinstance(hit.time_exact, fc.result.ExactAngle)


def test_scaling_by_powers_of_two():
    vector = BY_NAME["cone_rim_cone_face"]
    for k in (-20, 15):
        s = fmpq(2) ** k
        grow = [[s, 0, 0, 0], [0, s, 0, 0], [0, 0, s, 0], [0, 0, 0, 1]]
        scaled = []
        for body, motion in ((vector.a, vector.motion_a), (vector.b, vector.motion_b)):
            coefficients = [
                [[x * (s if j == 3 and i < 3 else 1) for j, x in enumerate(row)] for i, row in enumerate(matrix)]
                for matrix in motion.coefficients
            ]
            scaled.append(body.transformed(grow).moving(fc.RationalMotion(coefficients)))
        assert fc.first_contact(*scaled).time == pytest.approx(float(vector.time), abs=1e-15)


# -- what is refused ----------------------------------------------------------------------------------------------


def test_what_is_refused():
    ball, floor = fc.sphere(1), fc.half_space((0, 0, 1), 0)
    falling = ball.translated((0, 0, 3)).moving(fc.Translation((0, 0, -4)))
    assert fc.first_contact(falling, floor).time == pytest.approx(0.5, abs=1e-15)
    with pytest.raises(fc.UnsupportedPair, match="both unbounded"):
        fc.first_contact(floor.moving(fc.Translation((0, 0, 1))), fc.half_space((0, 0, -1), -5))
    with pytest.raises(fc.UnsupportedPair, match="engine"):
        fc.first_contact(falling, floor, engine="boxes")
    with pytest.raises(fc.UnsupportedPair, match="contact_pairs"):
        fc.contact_pairs(falling, floor)
    with pytest.raises(fc.UnsupportedPair, match="no body"):
        fc.first_contact(falling, "floor")
    screw = fc.Screw((0, 0, 1), degrees=90, advance=-4)
    with pytest.raises(fc.UnsupportedPair, match="rational pose"):
        slope = fc.half_space((1, 0, 4), 0)
        fc.first_contact(fc.box((1, 1, 1)).translated((0, 0, 3)).moving(screw), slope, exact=True)


def test_a_screw_on_the_certified_path():
    """A box turns a quarter and sinks by 4: its lower face, 2.5 up, comes down flat however it is turned."""
    screw = fc.Screw((0, 0, 1), degrees=90, advance=-4)
    hit = fc.first_contact(fc.box((1, 1, 1)).translated((0, 0, 3)).moving(screw), fc.half_space((0, 0, 1), 0))
    assert hit.status is fc.Status.CONTACT and abs(hit.time - 0.625) < 1e-12
    lo, hi = hit.time_interval
    assert lo <= 0.625 <= hi and hi - lo <= 1e-12
    slanted = fc.Screw((0, 1, 5), degrees=200, advance=-4)
    drum = fc.cylinder(1, 2).translated((0.5, 0, 3)).moving(slanted)
    hit = fc.first_contact(drum, fc.sphere(1))
    assert hit.status is fc.Status.CONTACT
    assert np.linalg.norm(hit.point) == pytest.approx(1.0, abs=1e-9)
    assert not drum.at(hit.time - 1e-6).contains(hit.point)
    assert drum.at(hit.time + 1e-6).contains(hit.point)


def test_screws_that_start_in_contact():
    screw = fc.Screw((0, 0, 1), degrees=90, advance=-4)
    cube, ball = fc.box((1, 1, 1)), fc.sphere(1)
    kinds = {
        "containment": cube,
        "touching": cube.translated((1.5, 0, 0)),
        "overlapping": cube.translated((1, 0, 0)),
    }
    for kind, body in kinds.items():
        hit = fc.first_contact(body.moving(screw), ball)
        assert (hit.status, hit.initial, hit.time) == (fc.Status.INITIAL_CONTACT, kind, 0.0)


def test_coordinates_beyond_all_doubles():
    """Upright drums pushed together in directions of 53 bits: contact along a line whose exact points are enormous."""
    rng = np.random.default_rng(2014)
    drum = fc.cylinder("3/4", 2)
    for _ in range(4):
        direction, place = rng.normal(size=3), rng.normal(size=3) + [4.0, 0.0, 0.0]
        moving = drum.moving(fc.Translation(place + 0.3 * direction))
        hit = fc.first_contact(moving, drum.translated(place))
        assert hit.status is fc.Status.CONTACT and hit.contact_set == "segment"
        gap = place[:2] - hit.time * (place + 0.3 * direction)[:2]
        assert np.hypot(*gap) == pytest.approx(1.5, abs=1e-12)


def test_copies_of_a_body_keep_nothing_of_its_queries():
    """Found when a raised floor answered with the time of the floor it was made from."""
    ball = fc.sphere(1).translated((0, 0, 9)).moving(fc.Translation((0, 0, -12)))
    floor = fc.half_space((0, 0, 1), 0).named("floor")
    assert fc.first_contact(ball, floor).time == pytest.approx(2 / 3, abs=1e-15)
    assert fc.first_contact(ball, floor.translated((0, 0, 5))).time == pytest.approx(1 / 4, abs=1e-15)
    assert fc.first_contact(ball, floor.named("ground")).element_b.label == "ground.plane"
    drum = fc.cylinder(1, 2)
    assert fc.first_contact(ball, drum).time == pytest.approx(7 / 12, abs=1e-15)
    assert fc.first_contact(ball, drum.translated((0, 0, 3))).time == pytest.approx(1 / 3, abs=1e-15)
    cube = fc.examples.box((2, 2, 2))
    assert fc.first_contact(ball, cube).element_b.label == "box"
    assert fc.first_contact(ball, cube.named("crate")).element_b.label == "crate"
    assert fc.first_contact(ball, cube.translated((0, 0, 3))).time == pytest.approx(1 / 3, abs=1e-15)
