"""The certified fast path: known answers, a sampled oracle, and that nothing it calls free ever touches."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.motion.relative.stretches import windows
from firstcontact.search.convex.advance import PieceSearch, advance
from firstcontact.search.convex.convex import convex_pieces
from quadric_vectors import VECTORS, quaternion_matrix

# What the fast path leaves to the exact one, and why.
LEFT_OPEN = {
    "sphere_sphere_graze": "precision",
    "sphere_grazes_box_edge": "precision",
    "touching_at_start": "precision",
    "sphere_in_spherical_cavity": "not convex",
    "ball_in_tube": "not convex",
    "ball_passes_hole_centered": "not convex",
    "ball_hits_hole_rim": "not convex",
    "hyperboloid1_sphere_waist": "not convex",
    "degree4_edge_sphere": "an edge of degree 4",
}

# These touch along a segment, of which the known answer gives one point.
ON_A_SEGMENT = {
    "parallel_elliptic_cylinders_spin",
    "L_bracket_cylinder",
    "box_corner_cylinder_on_table",
    "cone_cylinder_common_generator_line",
}


def bodies(vector):
    return [_moved(vector.a, vector.motion_a), _moved(vector.b, vector.motion_b)]


def _moved(body, motion):
    if not isinstance(motion, dict):
        return body.moving(motion)
    rows = quaternion_matrix(motion["base_quat"])
    shift = [F(x) for x in motion["base_trans"]]
    placed = body.transformed([[*row, t] for row, t in zip(rows, shift, strict=True)] + [[0, 0, 0, 1]])
    turns = {"pi": F(1, 2), "2*pi": F(1)}[motion["omega"]]
    axis, point = ([F(x) for x in motion[key]] for key in ("axis", "point"))
    return placed.moving(fc.Screw(axis, point, turns=turns, advance=F(motion["pitch"])))


@pytest.mark.share(6)
@pytest.mark.parametrize("vector", VECTORS, ids=lambda v: v.name)
def test_known_answers(vector):
    for pair in (bodies(vector), bodies(vector)[::-1]):
        found = advance(*pair, 0, 1)
        if vector.name in LEFT_OPEN:
            assert (found.status, found.reason) == ("open", LEFT_OPEN[vector.name])
            assert vector.time is None or found.free_until <= vector.time
        elif not vector.contact:
            assert (found.status, found.free_until) == ("free", 1.0)
        else:
            assert found.status == "contact"
            lo, hi = found.time_interval
            digits = F(1, 10**24)  # the times are given to 25 digits
            assert F(lo) <= vector.time + digits and vector.time - digits <= F(hi)
            assert hi - lo <= 1e-12
            assert lo <= found.time <= hi and abs(found.time - float(vector.time)) <= 1e-15
            for x in pair:
                body = x.body.transformed(np.array(x.motion(found.time)))
                assert body._possible(found.point[None], slack=1e-9)[0]
            if vector.kind != "segment" and vector.name not in ON_A_SEGMENT:
                assert min(np.abs(np.array(p) - found.point).max() for p in vector.points) <= 1e-9


def test_example_7_names_the_two_sides():
    vector = next(v for v in VECTORS if v.name == "paper_example7")
    found = advance(*bodies(vector), 0, 1)
    assert found.features_a == found.features_b == (("face", 0),)
    assert np.abs(found.point - [-7.5, 10, 0]).max() <= 1e-14
    assert abs(np.linalg.norm(found.normal) - 1) <= 1e-15


def test_normal_points_from_b_to_a():
    a, b = fc.sphere(1), fc.sphere(1).translated((4, 0, 0))
    found = advance(a.moving(fc.Translation((4, 0, 0))), b, 0, 1)
    assert np.allclose(found.normal, (-1, 0, 0), atol=1e-15)
    assert found.time == 0.5 and np.allclose(found.point, (3, 0, 0), atol=1e-12)


def test_overlap_at_the_start():
    a, b = fc.box((2, 2, 2)), fc.cylinder(1, 2).translated((1, F("0.5"), 0))
    found = advance(a, b, 0, 1)
    assert (found.status, found.time_interval) == ("initial", (0.0, 0.0))
    assert a.contains(found.point) and b.contains(found.point)


def test_pieces_of_a_difference_of_boxes():
    """A box with a rectangular slot is a union of convex pieces: the peg goes through, a wider one does not."""
    slotted = fc.box((6, 6, 2)) - fc.box((2, 2, 3))
    for width, status in ((F("1.9"), "free"), (F("2.1"), "contact")):
        peg = fc.box((width, width, 1)).translated((0, 0, 4)).moving(fc.Translation((0, 0, -8)))
        found = advance(peg, slotted, 0, 1)
        assert found.status == status
        if status == "contact":
            assert abs(found.time - 2.5 / 8) <= 1e-12


def test_a_gap_of_1e_9_is_passed_and_an_overlap_of_1e_9_found():
    for shift, status in ((F(2) + F(1, 10**9), "free"), (F(2) - F(1, 10**9), "contact")):
        rod = fc.cylinder(1, 4).rotated((1, 0, 0), degrees=90).translated((-3, 0, 0))
        post = fc.box((1, 1, 6)).translated((0, 0, shift + 2))
        found = advance(rod.moving(fc.Translation((6, 0, 0))), post, 0, 1, tolerance=1e-6)
        assert found.status == status or (status == "contact" and found.status == "open"), found


# -- unions that are convex -----------------------------------------------------------------------------------

BALL = fc.sphere("1/2")
CAPSULE = fc.cylinder("1/2", "3/2") | BALL.translated((0, 0, "3/4")) | BALL.translated((0, 0, "-3/4"))


@pytest.mark.share(3)
@pytest.mark.parametrize("body, is_convex", [
    (CAPSULE, True),
    (fc.box((2, 1, 1)) | fc.cylinder("1/2", 1).translated((1, 0, 0)), True),
    (fc.box((1, 1, 1)) | fc.box((1, 1, 1)).translated((1, 0, 0)), True),
    (fc.box((1, 1, 1)) | fc.box((1, 1, 2)).translated((1, 0, 0)), False),
    (BALL | BALL.translated((2, 0, 0)), False),
    (fc.cylinder("1/4", 2) | BALL.translated((0, 0, 1)), False),
    (CAPSULE | BALL.translated(("1/100", 0, "3/4")), False),
    (fc.cylinder(1, 2), False),
])  # fmt: skip
def test_which_pieces_are_one_convex_body(body, is_convex):
    """One piece alone needs no union."""
    assert (convex_pieces(body).union is not None) is is_convex


def test_a_union_advances_as_its_pieces_do():
    rng = np.random.default_rng(7)
    others = [fc.box((1, 2, "3/2")), fc.cylinder("3/4", 2), CAPSULE]
    for k in range(amount(60, 5)):
        other, direction = others[k % 3], rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        motion = fc.Translation(6 * direction)
        if k % 2:
            point, degrees = rng.uniform(-0.3, 0.3, 3), float(rng.uniform(-90, 90))
            motion = fc.Screw(direction, point=point, degrees=degrees, advance=6)
        resting = other.translated((4 * direction + rng.uniform(-0.7, 0.7, 3)).tolist())
        found = advance(CAPSULE.moving(motion), resting, 0, 1)
        pieces = [replace(convex_pieces(body), union=None) for body in (CAPSULE, resting)]
        apart = PieceSearch(*pieces, windows(CAPSULE.moving(motion), resting, fmpq(0), fmpq(1)), 1e-12, 10_000).run()
        assert found.status == apart.status != "open"
        if found.status == "contact":
            (lo, hi), (first, last) = found.time_interval, apart.time_interval
            assert max(lo, first) <= min(hi, last) and found.steps <= apart.steps


# -- random pairs against samples ---------------------------------------------------------------------------


SHAPES = (
    lambda r: fc.box(r(3)),
    lambda r: fc.sphere(r(1)[0]),
    lambda r: fc.ellipsoid(r(3)),
    lambda r: fc.cylinder(r(2), r(1)[0]),
    lambda r: fc.cone(r(1)[0], r(1)[0]),
    lambda r: fc.frustum(r(1)[0], r(1)[0], r(1)[0]),
    lambda r: fc.paraboloid(r(2), r(1)[0]),
    lambda r: fc.hyperboloid((*r(2), F(1, 2)), 1, sheets=2),
)


def random_motion(rng, kind):
    def numbers(n, scale):
        return [F(int(x), 16) for x in rng.integers(-16 * scale, 16 * scale + 1, n)]

    axis = [*numbers(2, 1), F(1)]
    if kind == 0:
        return fc.Translation(numbers(3, 6))
    if kind == 1:
        return fc.Rotation(axis, point=numbers(3, 3), degrees=int(rng.integers(30, 360)))
    if kind == 2:
        return fc.Screw(axis, numbers(3, 3), degrees=int(rng.integers(30, 360)), advance=numbers(1, 4)[0])
    quats = [[1, *map(float, numbers(3, 1))] for _ in range(2)]
    return fc.RationalMotion.between(numbers(3, 1), numbers(3, 5), quat_wxyz=quats)


def random_pair(seed):
    rng = np.random.default_rng(seed)

    def lengths(n):
        return [F(int(x), 16) for x in rng.integers(6, 32, n)]

    made = []
    for side in range(2):
        body = SHAPES[rng.integers(len(SHAPES))](lengths)
        if side:
            body = body.translated([F(int(x), 8) for x in rng.integers(-28, 29, 3)])
        made.append(body.moving(random_motion(rng, (seed + side) % 4)) if side == 0 or seed % 3 else body)
    return made


def apart(a, b, t) -> float:
    """An upper bound of how far apart the pieces are at t: no direction of many parts them by more than it."""
    from firstcontact.kernels.convex.support import support
    from firstcontact.search.convex.convex import convex_pieces

    rng = np.random.default_rng(0)
    n = rng.normal(size=(400, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    best = -np.inf
    placed = [x.at(t) if hasattr(x, "motion") else x for x in (a, b)]
    pa, pb = (convex_pieces(x).array for x in placed)
    for _ in range(12):  # the gap is concave in n up to its length: refine around the best one
        values = [-support(pa, 0, *d)[0] - support(pb, 0, *-d)[0] for d in n]
        k = int(np.argmax(values))
        best, centre, spread = max(best, values[k]), n[k], 0.5 * np.ptp(n, axis=0).max()
        n = centre + rng.normal(size=(60, 3)) * spread * 0.3
        n /= np.linalg.norm(n, axis=1)[:, None]
    return best


@pytest.mark.share(10)
@pytest.mark.parametrize("seed", range(amount(150)))
def test_random_pairs(seed):
    a, b = random_pair(seed)
    found = advance(a, b, 0, 1)
    if found.status == "initial":
        moved = [x.at(0.0) if hasattr(x, "motion") else x for x in (a, b)]
        assert all(x.contains(found.point) for x in moved)
        return
    if found.status == "open":  # too slow an approach for 1e-12, or touching at the start
        assert found.reason == "precision"
        found = advance(a, b, 0, 1, tolerance=1e-10)
        if found.status == "open":
            assert found.free_until == 0 and abs(apart(a, b, 0.0)) < 5e-3
            return
    assert found.status in ("free", "contact"), found
    end = 1.0 if found.status == "free" else found.time
    for t in np.linspace(0, end, 6)[:-1]:
        assert apart(a, b, float(t)) > 0
    if found.status == "contact":
        lo, hi = found.time_interval
        assert 0 < hi - lo <= 1e-10
        assert abs(apart(a, b, hi)) < 5e-3  # the oracle searches at random
        for x in (a, b):  # and the point is in both
            body = x.body.transformed(x.motion(found.time)) if hasattr(x, "motion") else x
            assert body._possible(found.point[None], slack=1e-9)[0]
        back = advance(b, a, 0, 1)
        assert back.status == "contact" and back.time_interval[0] <= hi and lo <= back.time_interval[1]


def test_both_outcomes_occur_among_the_random_pairs():
    status = [advance(*random_pair(seed), 0, 1).status for seed in range(amount(150))]
    assert status.count("open") <= 3
    assert status.count("contact") >= len(status) // 8 and status.count("free") >= len(status) // 15


def test_splitting_the_span_and_windows_of_sequences():
    a, b = fc.cylinder((2, 1), 3), fc.ellipsoid((1, 2, 1)).translated((6, 1, 0))
    steps = [fc.Rotation((0, 0, 1), degrees=50), fc.Translation((6, 0, 0))]
    moving = a.moving(fc.Sequence(steps))
    whole = advance(moving, b, 0, 1)
    assert whole.status == "contact" and whole.time > 0.5
    parts = [advance(moving, b, *span) for span in itertools.pairwise((0, 0.25, whole.time_interval[0], 1))]
    assert [p.status for p in parts[:2]] == ["free", "free"]
    assert parts[2].status in ("contact", "open") and parts[2].free_until <= whole.time


def test_unbounded_and_quartic_models_say_so():
    moving = fc.Translation((0, 0, -1))
    assert advance(fc.sphere(1).moving(moving), fc.half_space((0, 0, 1), -3), 0, 1).reason == "not bounded"
    tubes = fc.cylinder(1, 9) & fc.cylinder(F(4, 5), 9).rotated((1, 0, 0), degrees=90)
    assert advance(fc.sphere(1).moving(moving), tubes, 0, 1).reason == "an edge of degree 4"
