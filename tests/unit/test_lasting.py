"""Points that are proved to stay in two moving bodies: checked at sampled times by formulas of the shapes."""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.body.solid import primitives
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import windows
from firstcontact.timeline.lasting import LastingOfModels, LastingSolid

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
