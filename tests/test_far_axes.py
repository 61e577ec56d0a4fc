"""Turns by little about axes far away, as the "screw" steps of recorded paths are: as if they were the shifts that they
nearly are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from firstcontact.exact.numbers import exact_value
from firstcontact.kernels.poses import KIND, RATIONAL, accelerations, pose_at
from firstcontact.kernels.workspace import HERE_A, MIDDLE, RADIUS, SPEED, SPREAD, workspace
from firstcontact.motion.relative.curved import after, own_series, terms
from firstcontact.motion.relative.stretches import known_steps, step_near, windows
from firstcontact.result import Status


def pose(angle, place):
    """Turned about z."""
    found = np.eye(4)
    found[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    found[:3, 3] = place
    return found


@pytest.mark.parametrize("angle", [1e-15, 1e-9, 1e-6, 1e-3])
def test_head_on(angle):
    """A ball flies centre on centre, one of radius 1/10 into another, along an arc that turns by the angle: UNDECIDED
    for all but an axis nearer than 1000 sizes.  The arc from t = 1/2 is a chord of 2 R sin(angle (1/2 - t) / 2)."""
    begin, end = np.array([0.346, 0.822, 0.33]), np.array([4.234, -1.094, 1.339])
    way, beside = end - begin, math.tan(angle / 4) / 2
    middle = (begin + end) / 2 + beside * np.array([way[1], -way[0], 0])
    path = fc.Trajectory([0, 1], [pose(0, begin), pose(angle, end)], interpolation="screw")
    ball = fc.sphere("1/10")
    hit = fc.first_contact(ball.moving(path), ball.translated(middle.tolist()))
    assert hit.status is Status.CONTACT
    lo, hi, width = 0.0, 0.5, math.hypot(way[0], way[1]) / math.sin(angle / 2)
    for _ in range(60):
        t = 0.5 * (lo + hi)
        far = math.hypot(width * math.sin(angle * (0.5 - t) / 2), way[2] * (0.5 - t)) > 0.2
        lo, hi = (t, hi) if far else (lo, t)
    assert abs(hit.time - lo) < 1e-13


def test_meshes_and_holes():
    """The faces x = 8 t - 9/2 and x = -1, a block with a hole, about an axis 1e15 away.  Such a cube and a ball of 320
    triangles took 17 s, as doubles told nothing of any pair."""
    far = 10**15
    motion = fc.Screw((0, 0, 1), (0, far, 0), radians=fmpq(8, far), advance="1/2")
    moving = fc.examples.box((1, 1, 1)).translated((-5, "1/8", "-1/4")).moving(motion)
    block = fc.box((2, 2, 2)) - fc.box((1, 1, 3))
    for other in (block, block.to_mesh(0.1)):
        hit = fc.first_contact(moving, other)
        assert hit.status is Status.CONTACT and abs(hit.time - 0.4375) < 1e-12
    assert 4 * hit.stats.undecided < hit.stats.pair_tests


def test_doubles_tell_the_way_to_its_own_digits():
    rng, work, slight = np.random.default_rng(4), workspace()[0], 0
    for k in range(40):
        axis, point = rng.normal(size=3).tolist(), (10.0 ** rng.uniform(0, 17) * rng.normal(size=3)).tolist()
        motion = fc.Screw(axis, point, radians=float(10.0 ** rng.uniform(-17, -1.7)), advance=float(rng.normal()))
        if k % 2:
            motion = fc.Sequence([fc.Rotation((0, 1, 2), (1, 2, 3), degrees=33), motion])
        window = windows(fc.sphere(1).moving(motion), fc.sphere(1), fmpq(0), fmpq(1))[-1]
        slight += window.a[0, KIND] == RATIONAL
        for t in rng.uniform(window.first, window.last, 3).tolist():
            step = step_near(known_steps(motion), exact_value(t))
            with terms(3, 600):
                rows = own_series(step.motion, arb(step.share(exact_value(t))), 1 / step.unit)
                rows = after(rows, step.before.matrix())
                truth = [row[j] for row in rows for j in range(3)] + [row[3] for row in rows]
                pose_at(window.a, t, work, HERE_A)
                error = [float(abs(x[0] - arb(float(y)))) for x, y in zip(truth, work[HERE_A], strict=False)]
                speed, bend = (np.array([float(c * x[c]) for x in truth]) for c in (1, 2))
            assert max(error[:9]) <= work[HERE_A, 12] and max(error[9:]) <= work[HERE_A, 13]
            if window.a[0, KIND] == RATIONAL:
                way = np.abs(work[HERE_A, 9:12]).max() + np.abs(speed[9:]).max()
                assert work[HERE_A, 13] < 1e-14 * way
            accelerations(window.a, max(t - 0.1, window.first), min(t + 0.1, window.last), work)
            assert np.all(np.abs(bend - work[MIDDLE, :12]) <= work[RADIUS, :12] * (1 + 1e-9) + 1e-300)
            assert np.all(np.abs(speed - work[SPEED, :12]) <= work[SPREAD, :12] * (1 + 1e-9) + 1e-300)
    assert 30 <= slight < 40
