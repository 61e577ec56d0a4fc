"""Points that are proved to stay in two moving bodies: checked at sampled times by formulas of the shapes."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from amount import amount
from firstcontact.body.solid import primitives
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import windows
from firstcontact.timeline.lasting import Drift, LastingOfModels, LastingSolid, is_negative

SHAPES = {
    "ball": (primitives.sphere(1), lambda x: np.linalg.norm(x, axis=-1) - 1.0),
    "box": (primitives.box((2, 1, 3)), lambda x: np.max(np.abs(x) - (1.0, 0.5, 1.5), axis=-1)),
    "rod": (primitives.cylinder(1, 2),
            lambda x: np.maximum(np.hypot(x[..., 0], x[..., 1]) - 1.0, np.abs(x[..., 2]) - 1.0)),
}  # fmt: skip


def motions(rng):
    axis, point = rng.integers(-2, 3, 3), (rng.integers(-3, 4, 3) / 2).tolist()
    axis = (axis if axis.any() else np.array([0, 0, 1])).tolist()
    return (
        fc.Translation((rng.integers(-4, 5, 3) / 4).tolist()),
        fc.Rotation(axis, point, radians=float(rng.uniform(0.1, 1))),
        fc.Screw(axis, point, radians=float(rng.uniform(0.1, 1)), advance=1),
    )


def pair(a, b):
    lasting = LastingOfModels(LastingSolid(shape_of(a)), LastingSolid(shape_of(b)))
    (window,) = windows(a, b, fmpq(0), fmpq(1))
    return lasting, window


def test_what_is_proved_to_stay_does():
    rng, proved, missed = np.random.default_rng(281126), 0, 0
    for _ in range(amount(1200, 8)):
        (one, inside_one), (two, inside_two) = (SHAPES[k] for k in rng.choice(list(SHAPES), 2))
        moves = [motions(rng)[rng.integers(3)] for _ in range(2)]
        a, b = (x.moving(m) for x, m in zip((one, two), moves, strict=True))
        lasting, window = pair(a, b)
        t = float(rng.uniform(0, 0.9))
        end = t + float(10.0 ** rng.uniform(-6, -0.5))
        end = min(end, 1.0)
        starts = [m(t) for m in moves]
        x = np.array(starts[0][:3, :3]) @ rng.uniform(-1, 1, 3) + starts[0][:3, 3]
        for side, own in enumerate(moves):
            local = np.linalg.solve(own(t)[:3, :3], x - own(t)[:3, 3])
            times = np.linspace(t, end, 17)
            path = [own(s)[:3, :3] @ local + own(s)[:3, 3] for s in times]
            seen = [np.array([np.linalg.solve(m(s)[:3, :3], p - m(s)[:3, 3]) for s, p in zip(times, path, strict=True)])
                    for m in moves]  # fmt: skip
            heights = np.maximum(inside_one(seen[0]), inside_two(seen[1]))
            if lasting.stays(window, t, end, side, x):
                proved += 1
                assert heights.max() <= 1e-9, (moves, t, end, side, x)
            elif heights.max() < 0.0:
                missed += 1
    print("proved", proved, "missed", missed)
    assert proved > amount(1200, 8) / 5 and missed < 3 * proved


@pytest.mark.parametrize("speed", [(0, 0, -2), (3, 1, -1)])
def test_a_point_that_goes_deeper_stays_however_shallow_it_was(speed):
    """A box has come 2e-9 into a ball: its lowest point stays until the way across bends out of it, no billionths."""
    ball = primitives.sphere(1)
    box = primitives.box((2, 2, 2)).translated((0, 0, 2)).moving(fc.Translation(speed))
    lasting, window = pair(box, ball)
    t = 2e-9 / -speed[2]
    x = np.array([speed[0] * t, speed[1] * t, 1 - 1e-9])
    assert lasting.stays(window, t, t + 1e-6, 0, x)
    assert not lasting.stays(window, t, t + 1.0, 0, x)


def test_a_point_that_slides_leaves_what_is_round():
    """5e-10 deep, at speed 3 across: it is out after 1.05e-5, and the bend of the ball alone tells that."""
    box = primitives.box((2, 2, 2)).translated((0, 0, 2)).translated((0, 0, fmpq(-1, 10**9)))
    lasting, window = pair(box.moving(fc.Translation((3, 0, 0))), primitives.sphere(1))
    x = np.array([0.0, 0.0, 1 - 5e-10])
    assert lasting.stays(window, 0.0, 8e-6, 0, x)
    assert not lasting.stays(window, 0.0, 1.2e-5, 0, x)


def test_quadratics_are_told_negative_over_a_stretch_if_and_only_if_they_are():
    """The truth by Fractions: at the ends, and at the vertex where that is between."""
    rng, told = np.random.default_rng(281128), 0
    for _ in range(amount(20000, 20)):
        c, b, a = (Fraction(int(n), 4) for n in rng.integers(-9, 10, 3))
        length = Fraction(int(rng.integers(1, 13)), 4)
        places = [Fraction(0), length, *([-b / (2 * a)] if a and 0 < -b / (2 * a) < length else [])]
        truth = all(c + b * s + a * s * s < 0 for s in places)
        assert is_negative(*(arb(float(x)) for x in (c, b, a, length))) == truth, (c, b, a, length)
        told += truth
    assert told > 100


def test_quadratics_in_balls_are_negative_for_all_their_members():
    rng, told = np.random.default_rng(281129), 0
    for _ in range(amount(8000, 8)):
        middles, radii = rng.uniform(-3, 3, 3), 10.0 ** rng.uniform(-3, 0, 3)
        if not is_negative(*(arb(m, r) for m, r in zip(middles, radii, strict=True)), arb(2)):
            continue
        told += 1
        s = np.linspace(0, 2, 41)
        for _ in range(20):  # other members at every time
            c, b, a = middles[:, None] + radii[:, None] * rng.uniform(-1, 1, (3, 41))
            assert np.all(c + b * s + a * s * s < 0.0)
    assert told > 10


def test_a_form_along_a_drift_is_its_value_there():
    """By Fractions, of whole numbers: x^T M x at x + offset + s rate."""
    rng = np.random.default_rng(281130)
    for _ in range(50):
        half = rng.integers(-4, 5, (4, 4))
        m, (x, offset, rate) = half + half.T, rng.integers(-5, 6, (3, 3))
        s = int(rng.integers(0, 6))
        there = np.array([*(x + offset + s * rate), 1])
        rows = [[arb(int(c)) for c in row] for row in m]
        drift = Drift(*([arb(int(c)) for c in v] for v in (offset, rate)), arb(6))
        start = np.array([*x, 1])
        image = [arb(int(c)) for c in m @ start]
        constant, first, second = drift.on_form(rows, image, arb(int(start @ m @ start)))
        assert constant + first * s + second * s**2 == int(there @ m @ there)


def test_a_step_goes_as_far_as_the_way_is_nearly_straight():
    """From a depth of 1e-12 on: half way through the ball at once, the square of which is far more than the depth."""
    a, b = fc.sphere(1).translated((-3, 0, 0)).moving(fc.Translation((4, 0, 0))), fc.box((2, 2, 2))
    lasting, window = pair(a, b)
    t = 0.25 + 1e-12
    assert lasting.stays(window, t, 0.5, 1, np.array([-1.0 + 1e-12, 0.0, 0.0]))
