"""Every proved bound of the fast path against brute force: support functions, poses, accelerations, shared points."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from firstcontact.exact.numbers import precision, rational
from firstcontact.kernels import poses
from firstcontact.kernels.convex import separation
from firstcontact.kernels.convex.support import FORMS, form_value, support
from firstcontact.kernels.workspace import HERE_A, HERE_B, MIDDLE, RADIUS, SPEED, SPREAD, workspace
from firstcontact.motion.relative.stretches import windows
from firstcontact.search.convex.convex import NotConvex, convex_pieces

SOLIDS = {
    "box": fc.box((1, 2, 3)),
    "sphere": fc.sphere(F(3, 2)).translated((1, 2, 3)),
    "ellipsoid": fc.ellipsoid((1, 2, F(1, 2))).rotated((1, 2, 3), degrees=40),
    "cylinder": fc.cylinder((1, 2), 3).rotated((1, 0, 1), degrees=25),
    "cone": fc.cone(1, 2),
    "frustum": fc.frustum(2, 1, F(1, 2)).translated((0, 0, 5)),
    "paraboloid": fc.paraboloid((1, F(1, 2)), 2).rotated((0, 1, 1), degrees=70),
    "cap of a hyperboloid": fc.hyperboloid((1, F(1, 2), 1), 3, sheets=2),
    "cut cylinder": fc.cylinder(1, 4) & fc.half_space((1, 1, 2), 1),
    "cut ellipsoid": fc.ellipsoid((1, 2, 3)) & fc.half_space((1, 1, 1), F(1, 2)) & fc.half_space((-1, 2, 0), 1),
    "cut cone": fc.cone(1, 2) & fc.half_space((0, 1, F(1, 4)), F(1, 4)),
    "lens": fc.sphere(2) & fc.sphere(2).translated((3, 0, 0)),
    "sheared cone": fc.cone(1, 2).transformed([[1, F(1, 2), 0, 0], [0, 2, 0, 0], [F(1, 3), 0, -1, 0], [0, 0, 0, 1]]),
}


def points_of(body, n=4000):
    lo, hi = body.bounds()
    p = np.random.default_rng(3).uniform(lo, hi, (n, 3))
    return p[body.contains(p)]


@pytest.mark.share(5)
@pytest.mark.parametrize("name", SOLIDS)
def test_support_is_above_all_points_and_attained(name):
    body = SOLIDS[name]
    try:
        array = convex_pieces(body).array
    except NotConvex as reason:
        assert name == "cut cone" and "hyperbola" in str(reason)
        return
    inside = np.concatenate([points_of(body), body.to_mesh(1e-3).vertices * (1 - 1e-12)])
    rng = np.random.default_rng(4)
    size = np.ptp(inside, axis=0).max()
    for n in (*rng.normal(size=(200, 3)), *np.eye(3), *-np.eye(3)):
        bound, *point = support(array, 0, *n)
        length = np.linalg.norm(n)
        assert (inside @ n).max() <= bound + 1e-11 * length * size
        assert bound <= (inside @ n).max() + 2e-3 * length  # the mesh is that near
        assert bound - 1e-12 * length * size <= np.dot(point, n) <= bound
        values = [form_value(array, k, *point)[0] for k in range(int(array[0, FORMS]), int(array[0, FORMS + 1]))]
        assert max(values) <= 1e-8 * size


def test_support_of_an_ellipsoid_against_balls():
    """The bound is above the true value and within 50 roundings of it."""
    body = fc.ellipsoid((F(1, 3), F(7, 5), 2)).translated((F(1, 7), 5, F(-1, 9)))
    array = convex_pieces(body).array
    rng = np.random.default_rng(5)
    for n in rng.normal(size=(100, 3)):
        with precision(200):
            m = [arb(rational(float(x), "n")) for x in n]
            radii, centre = (F(1, 3), F(7, 5), F(2)), (F(1, 7), F(5), F(-1, 9))
            h = sum((x * arb(fmpq(c.numerator, c.denominator)) for x, c in zip(m, centre, strict=True)), arb(0))
            square = [(x * arb(fmpq(r.numerator, r.denominator))) ** 2 for x, r in zip(m, radii, strict=True)]
            true = h + (square[0] + square[1] + square[2]).sqrt()
            bound = arb(support(array, 0, *n)[0])
            assert true < bound < true + arb(1e-13)


MOTIONS = {
    "translation": fc.Translation((1, F(1, 3), -2)),
    "rotation": fc.Rotation((1, 2, 3), point=(1, 0, F(1, 3)), degrees=200),
    "turns": fc.Rotation((0, 0, 1), point=(1, 0, 0), turns=7),
    "screw": fc.Screw((1, 1, 0), (0, 1, 2), degrees=100, advance=F(7, 3)),
    "between": fc.RationalMotion.between((0, 1, 0), (4, 0, 1), quat_wxyz=[(1, 0, 0, 0), (1, 1, 2, 1)]),
    "affine": fc.RationalMotion([np.eye(4), [[0, 1, 0, 2], [0, 0, 0, 1], [0.5, 0, 1, 0], [0, 0, 0, 0]]]),
    "sequence": fc.Sequence([fc.Rotation((1, 1, 1), radians=1), fc.Translation((1, 2, 3))]),
    "trajectory": fc.Trajectory(
        [0, F(1, 3), 1], [(0, 0, 0), (1, 2, 0), (1, 1, 4)], "screw",
        quat_wxyz=[(1, 0, 0, 0), (1, 1, 0, 0), (1, 1, 1, 0)],
    ),
}  # fmt: skip


def stretches(motion):
    body = fc.sphere(1)
    return windows(body.moving(motion), body, fmpq(0), fmpq(1))


@pytest.mark.parametrize("name", MOTIONS)
def test_poses_and_their_proved_errors(name):
    motion = MOTIONS[name]
    w, _ = workspace()
    for window in stretches(motion):
        for t in np.linspace(window.first, window.last, 23)[1:-1]:
            t = float(t)
            poses.pose_at(window.a, t, w, HERE_A)
            true = motion(t)
            rounding = 4e-15 * (1 + np.abs(true).max())  # of motion(t) itself
            assert np.abs(w[HERE_A, :9].reshape(3, 3) - true[:3, :3]).max() <= w[HERE_A, 12] + rounding
            assert np.abs(w[HERE_A, 9:12] - true[:3, 3]).max() <= w[HERE_A, 13] + rounding
            assert w[HERE_A, 12] <= 5e-14 and w[HERE_A, 13] <= 2e-13


@pytest.mark.parametrize("name", MOTIONS)
def test_enclosures_of_velocities_and_accelerations(name):
    """Difference quotients of poses at samples lie in the enclosures over the interval."""
    w, _ = workspace()
    h = 1e-4
    for window in stretches(MOTIONS[name]):
        span = window.last - window.first
        for t0, t1 in ((0.1, 0.9), (0.3, 0.4), (0.5, 0.502)):
            t0, t1 = window.first + t0 * span, window.first + t1 * span
            poses.accelerations(window.a, t0, t1, w)
            second, first = w[[MIDDLE, RADIUS], :12].copy(), w[[SPEED, SPREAD], :12].copy()
            for t in np.linspace(t0, t1, 9):
                values = []
                for s in (t - h * span, t, t + h * span):
                    poses.pose_at(window.a, float(s), w, HERE_B)
                    values.append(w[HERE_B, :12].copy())
                speed = (values[2] - values[0]) / (2 * h * span)
                bend = (values[2] - 2 * values[1] + values[0]) / (h * span) ** 2
                size = 1 + np.abs(second[0]).max() + np.abs(second[1]).max()
                assert np.all(np.abs(speed - first[0]) <= first[1] + 1e-4 * size)
                assert np.all(np.abs(bend - second[0]) <= second[1] + 1e-3 * size)
        # and they shrink with the interval
        poses.accelerations(window.a, t0, t0 + 1e-6 * span, w)
        assert np.all(w[RADIUS, :12] <= 1e-3 * (1 + np.abs(w[MIDDLE, :12]).max()) / span**2)


def test_sine_bound():
    """SINE_EPS covers sine and cosine of doubles below 2^10, the ends of the octants included."""
    rng = np.random.default_rng(6)
    points = [*rng.uniform(-1000, 1000, 3000), *rng.uniform(-2, 2, 1000), *(np.pi / 4 * np.arange(-600, 601))]
    worst = 0.0
    with precision(200):
        for x in points:
            s, c = poses.sine_cosine(float(x))
            true = arb(rational(float(x), "x"))
            worst = max(worst, float(abs(arb(s) - true.sin())), float(abs(arb(c) - true.cos())))
    assert worst <= poses.SINE_EPS
    assert worst > poses.SINE_EPS / 20  # else the bound is lax


@pytest.mark.parametrize("name", ["rotation", "screw", "between"])
def test_bending_bounds_the_second_derivative(name):
    """f = n(t).(y - x) of sampled points x, y never bends more than the bound."""
    body = fc.cylinder(1, 3)
    array = convex_pieces(body).array
    window = windows(body.moving(MOTIONS[name]), body.moving(MOTIONS["rotation"]), fmpq(0), fmpq(1))[0]
    x, y = points_of(body, 60), points_of(body, 60)
    m = min(len(x), len(y))
    rng, (w, _) = np.random.default_rng(7), workspace()
    for _ in range(20):
        t0 = rng.uniform(0, 0.9)
        t1 = t0 + rng.uniform(1e-3, 0.1)
        n, e = rng.normal(size=3), rng.normal(size=3)
        bound = separation.bending(array, 0, window.a, array, 0, window.b, t0, t1, *n, *e, w)
        values = []
        s = np.linspace(t0, t1, 9)
        for t in s:
            pair = []
            for row, stretch, p in ((HERE_A, window.a, x[:m]), (HERE_B, window.b, y[:m])):
                poses.pose_at(stretch, float(t), w, row)
                pair.append(p @ w[row, :9].reshape(3, 3).T + w[row, 9:12])
            values.append((pair[1] - pair[0]) @ (n + (e - n) * (t - t0) / (t1 - t0)))
        second = np.diff(values, 2, axis=0) / (s[1] - s[0]) ** 2
        assert second.max() <= bound * (1 + 1e-6) + 1e-6


def test_form_bound():
    """Values of forms are within FORM_EPS of their true values, relative to the sum of their terms."""
    from firstcontact.kernels.convex.shared_point import FORM_EPS

    rng = np.random.default_rng(8)
    for name in ("sphere", "ellipsoid", "cut ellipsoid", "sheared cone"):
        body = SOLIDS[name]
        array = convex_pieces(body).array
        for k in range(int(array[0, FORMS]), int(array[0, FORMS + 1])):
            surface = body.surfaces[int(array[k, 10])]
            exact = surface.matrix()
            # the scale of the row: its largest coefficient against the exact one
            flat = [exact[i][i] for i in range(3)] + [2 * exact[i][j] for i, j in ((0, 1), (0, 2), (1, 2))]
            flat += [2 * exact[i][3] for i in range(3)] + [exact[3][3]]
            top = int(np.argmax(np.abs(array[k, :10])))
            for p in rng.normal(size=(50, 3)):
                value, size = form_value(array, k, *p)
                q = [rational(float(c), "p") for c in p]
                x, y, z = q
                terms = [x * x, y * y, z * z, x * y, x * z, y * z, x, y, z, fmpq(1)]
                true = sum((f * t for f, t in zip(flat, terms, strict=True)), fmpq(0))
                true = true * rational(float(array[k, top]), "c") / flat[top]
                assert abs(rational(float(value), "v") - true) <= rational(float(FORM_EPS * size), "e")
