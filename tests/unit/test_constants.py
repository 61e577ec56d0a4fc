"""The error constants of the kernels, recomputed: what `DET_EPS`, `ANGLE_EPS` and `FRAME_EPS` promise."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, arb_poly, fmpq

from amount import amount
from firstcontact.exact.numbers import precision
from firstcontact.kernels import angle, running, verdict
from firstcontact.search.trees.frame import FRAME_EPS, frame_of

# ---------------------------------------------------------------------------------------------- determinants


def kernel_det(x, y, z):
    """det [x, y, z] and its size as the filters compute them."""
    g, s = verdict.cross(*y, *z), verdict.cross_size(*y, *z)
    det = x[0] * g[0] + x[1] * g[1] + x[2] * g[2]
    return det, abs(x[0]) * s[0] + abs(x[1]) * s[1] + abs(x[2]) * s[2]


def exact_det(x, y, z):
    return x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0])


def det_ratio(points, origins) -> float:
    """|computed - true| over the computed bound, for three differences point - origin of doubles."""
    rows = [[p - o for p, o in zip(point, origin, strict=True)] for point, origin in zip(points, origins, strict=True)]
    true = exact_det(*[
        [Fraction(p) - Fraction(o) for p, o in zip(point, origin, strict=True)]
        for point, origin in zip(points, origins, strict=True)
    ])  # fmt: skip
    det, perm = kernel_det(*rows)
    bound = Fraction(verdict.DET_EPS * perm + verdict.TINY)
    return float(abs(Fraction(det) - true) / bound)


def worst_det(draw, count: int) -> float:
    return max(det_ratio(*draw(k)) for k in range(count))


def test_det_bound():
    rng = np.random.default_rng(11)

    def generic(_):
        return rng.uniform(-1, 1, (3, 3)).tolist(), rng.uniform(-1, 1, (3, 3)).tolist()

    def nearly_singular(_):
        p, o = rng.uniform(-1, 1, (3, 3)), rng.uniform(-1, 1, (3, 3))
        d = p - o
        p[2] = o[2] + rng.uniform(-1, 1, 2) @ d[:2]
        return p.tolist(), o.tolist()

    def other_scales(_):
        scale = np.exp2(rng.integers(-100, 100, (3, 1)))
        return (rng.uniform(-1, 1, (3, 3)) * scale).tolist(), (rng.uniform(-1, 1, (3, 3)) * scale).tolist()

    def all_of_one_sign(_):  # all six products add up: the error is largest relative to the determinant
        p = rng.uniform(1, 2, (3, 3)) * np.array([[1, -1, 1], [1, 1, -1], [-1, 1, 1]])
        return p.tolist(), (rng.uniform(-0.5, 0.5, (3, 3)) * 2.0**-20).tolist()

    worst = max(worst_det(draw, amount(2500, 4)) for draw in (generic, nearly_singular, other_scales, all_of_one_sign))
    assert worst < 1
    assert climb(rng) < 1
    assert worst > 0.05  # the test sees errors at all


def climb(rng) -> float:
    """The largest ratio that hill climbing over last digits finds."""
    best = 0.0
    for _ in range(4):
        p, o = rng.uniform(-1, 1, (3, 3)), rng.uniform(-1, 1, (3, 3))
        here = det_ratio(p.tolist(), o.tolist())
        for _ in range(amount(250, 4)):
            p2, o2 = p.copy(), o.copy()
            target = p2 if rng.integers(2) else o2
            i, j = rng.integers(3, size=2)
            target[i, j] *= 1 + rng.integers(-9, 10) * 2.0 ** -rng.integers(20, 53)
            there = det_ratio(p2.tolist(), o2.tolist())
            if there >= here:
                p, o, here = p2, o2, there
        best = max(best, here)
    return best


def test_det_bound_in_the_underflow_range():
    rng = np.random.default_rng(12)
    for exponent in (-400, -360, -340, -300):
        p, o = (rng.uniform(-1, 1, (3, 3)) * 2.0**exponent for _ in range(2))
        assert det_ratio(p.tolist(), o.tolist()) < 1
    mixed = np.array([[1e-300, 1e45, 1e-200], [1e-310, 1e-5, 1e45], [1e45, 1e-320, 1e-300]])
    assert det_ratio(mixed.tolist(), np.zeros((3, 3)).tolist()) < 1


def test_slack_of_moved_vectors():
    """`slack3` bounds the change of a determinant when vectors move by bounded 1-norms."""
    rng = np.random.default_rng(13)
    worst = 0.0
    for _ in range(amount(2000)):
        v = [[Fraction(x) for x in row] for row in rng.uniform(-1, 1, (3, 3)).tolist()]
        size = [float(sum(map(abs, row))) for row in v]
        d = (2.0 ** rng.uniform(-40, 0, 3)).tolist()
        moved = []
        for row, move in zip(v, d, strict=True):
            axis, way = int(rng.integers(3)), int(rng.choice([-1, 1]))
            moved.append([x + (way * Fraction(move) if k == axis else 0) for k, x in enumerate(row)])
        change = abs(exact_det(*moved) - exact_det(*v))
        worst = max(worst, float(change) / verdict.slack3(*size, *d))
    assert 0.2 < worst <= 1


def test_quotient_encloses():
    rng = np.random.default_rng(14)
    for _ in range(amount(4000)):
        n, d = rng.uniform(-1, 1, 2) * np.exp2(rng.uniform(-60, 60, 2))
        d_err = abs(d) * 2.0 ** rng.uniform(-60, -0.1)
        n_err = abs(n) * 2.0 ** rng.uniform(-60, 3)
        lo, hi = verdict.quotient(float(n), n_err, float(d), d_err)
        for sn in (-1, 0, 1):
            for sd in (-1, 0, 1):
                true = (Fraction(n) + sn * Fraction(n_err)) / (Fraction(d) + sd * Fraction(d_err))
                assert Fraction(lo) <= true <= Fraction(hi)


# ---------------------------------------------------------------------------------------------------- angles


def true_angle(x: float, y: float) -> arb:
    a, b = arb(fmpq(*x.as_integer_ratio())), arb(fmpq(*y.as_integer_ratio()))
    phi = arb.atan2(b, a)
    return phi + 2 * arb.pi() if y < 0 else phi


def angle_error(x: float, y: float) -> float:
    with precision(200):
        gap = abs(arb(fmpq(*angle.angle_of(x, y).as_integer_ratio())) - true_angle(x, y))
        return float(gap.upper())


def around(x: float, steps: int = 3) -> list[float]:
    out = [x]
    for way in (-math.inf, math.inf):
        y = x
        for _ in range(steps):
            y = math.nextafter(y, way)
            out.append(y)
    return out


def test_angle_bound():
    rng = np.random.default_rng(21)
    turn = np.linspace(0, 2 * np.pi, 4001)
    size = np.exp2(rng.uniform(-200, 200, turn.size))
    cases = list(zip((size * np.cos(turn)).tolist(), (size * np.sin(turn)).tolist(), strict=True))
    slopes = [s for t in (math.tan(math.pi / 8), 1.0, 1 / math.tan(math.pi / 8), 2.0**-30, 1e-12)
              for s in around(t)]  # fmt: skip
    cases += [(sx * 1.0, sy * s) for s in slopes for sx in (-1, 1) for sy in (-1, 1)]
    cases += [(sx * s, sy * 1.0) for s in slopes for sx in (-1, 1) for sy in (-1, 1)]
    cases += [(x * a, y * b) for a in (1e-290, 1.0, 1e300) for b in (1e-290, 1.0, 1e300)
              for x in (-1.5, 0.7) for y in (-0.9, 1.3)]  # fmt: skip
    cases += [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 2.0**-1000), (1.0, -(2.0**-1000))]
    worst = max(angle_error(x, y) for x, y in cases)
    assert 2e-16 < worst < angle.ANGLE_EPS


def test_angle_of_lies_in_the_full_turn():
    for x, y in ((1.0, -(2.0**-1000)), (1.0, -1e-17), (5.0, 0.0), (1.0, -5e-324)):
        assert 0 <= angle.angle_of(x, y) <= angle.TWO_PI


def atan_coefficients() -> list[Fraction]:
    """The polynomial p of atan(t) ~ t + t^3 p(t^2), read from the kernel's source."""
    import ast
    import inspect
    import textwrap

    (function,) = ast.parse(textwrap.dedent(inspect.getsource(angle._atan.py_func))).body
    found = []
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "p":
            value = node.value.right if isinstance(node.value, ast.BinOp) else node.value
            sign = -1 if isinstance(node.value, ast.BinOp) and isinstance(node.value.op, ast.Sub) else 1
            found.append((node.lineno, sign * Fraction(ast.literal_eval(value))))
    return [c for _, c in sorted(found)]


def test_polynomial_of_atan_is_proved():
    """|1 + u p(u) - atan(t) / t| < 7.5e-17 for u = t^2, t in [0, tan(pi/8)].

    atan(t) / t = sum (-u)^k / (2k + 1) is cut at k = 80, the rest is below u^81.  On each piece the
    difference is expanded about the middle: absolute coefficients times powers of the radius sum to a bound.
    """
    coefficients = [Fraction(1), *reversed(atan_coefficients())]
    assert len(coefficients) == 11
    with precision(200):
        top = fmpq(*(0.41421356237309503).as_integer_ratio()) ** 2
        assert arb(0.41421356237309503) >= (arb.pi() / 8).tan() - arb(2) ** -53
        series = [Fraction((-1) ** k, 2 * k + 1) for k in range(81)]
        gap = [(coefficients[k] if k <= 10 else 0) - series[k] for k in range(81)]
        difference = arb_poly([fmpq(c.numerator, c.denominator) for c in gap])
        pieces, worst = 200, 0.0
        for k in range(pieces):
            middle, radius = top * (2 * k + 1) / (2 * pieces), top / (2 * pieces)
            about = difference(arb_poly([middle, radius]))
            bound = sum((abs(c) for c in about.coeffs()), arb(top) ** 81)
            worst = max(worst, float(bound.upper()))
    assert 1e-17 < worst < 7.5e-17


def test_angle_bounds_enclose():
    rng = np.random.default_rng(22)
    narrow = 0
    for k in range(3000):
        phi, size = rng.uniform(0, 2 * np.pi), 2.0 ** rng.uniform(-30, 30)
        if k % 5 == 0:
            phi = rng.choice([0.0, np.pi / 2, np.pi]) + rng.uniform(-1, 1) * 2.0 ** -rng.uniform(1, 50)
        x, y = float(size * np.cos(phi)), float(size * np.sin(phi))
        ex, ey = (size * 2.0 ** rng.uniform(-50, 0, 2)).tolist()
        lo, hi = angle.angle_bounds(x, ex, y, ey)
        narrow += hi - lo < 1
        for sx, sy in ((-1, -1), (-1, 1), (1, -1), (1, 1), (0, 0)):
            tx, ty = Fraction(x) + sx * Fraction(ex), Fraction(y) + sy * Fraction(ey)
            if tx == ty == 0:
                continue
            with precision(200):
                true = arb.atan2(arb(fmpq(ty.numerator, ty.denominator)), arb(fmpq(tx.numerator, tx.denominator)))
                true = true + 2 * arb.pi() if ty < 0 else true
                assert not (true < arb(lo)) and not (true > arb(hi) + arb(5e-16) * (hi == angle.TWO_PI))
    assert narrow > 1000


# ------------------------------------------------------------------------------------ running error analysis


def inside(rng, x: float, ex: float) -> Fraction:
    """A true number within the error, often at its border."""
    share = Fraction(rng.choice([-1.0, 1.0, 0.0, rng.uniform(-1, 1)]))
    return Fraction(x) + share * Fraction(ex)


def draw(rng) -> tuple[float, float]:
    x = float(rng.uniform(-1, 1) * 2.0 ** rng.integers(-40, 40))
    if rng.integers(3) == 0:
        x = float(rng.integers(-3, 4)) + float(rng.integers(-2, 3)) * 2.0**-50
    return x, 0.0 if rng.integers(3) == 0 else abs(x) * 2.0 ** float(rng.uniform(-60, 1))


@pytest.mark.parametrize("name", ["add", "sub", "mul", "div"])
def test_running_operations(name):
    rng = np.random.default_rng(31)
    kernel = getattr(running, name)
    true = {
        "add": lambda x, y: x + y,
        "sub": lambda x, y: x - y,
        "mul": lambda x, y: x * y,
        "div": lambda x, y: x / y,
    }[name]
    worst = 0.0
    for _ in range(amount(4000)):
        (x, ex), (y, ey) = draw(rng), draw(rng)
        if name == "div" and not abs(y) > ey:
            continue
        r, er = kernel(x, ex, y, ey)
        gap = abs(true(inside(rng, x, ex), inside(rng, y, ey)) - Fraction(r))
        assert gap <= Fraction(er), (x, ex, y, ey)
        worst = max(worst, float(gap / Fraction(er)) if er else 0.0)
    assert worst > 0.9


@pytest.mark.parametrize("name", ["dot2", "cross2"])
def test_running_products_of_vectors(name):
    rng = np.random.default_rng(32)
    kernel = getattr(running, name)
    for _ in range(amount(4000)):
        (x0, ex), (x1, _), (y0, ey), (y1, _) = (draw(rng) for _ in range(4))
        r, er = kernel(x0, x1, ex, y0, y1, ey)
        t = [inside(rng, v, e) for v, e in ((x0, ex), (x1, ex), (y0, ey), (y1, ey))]
        true = t[0] * t[2] + t[1] * t[3] if name == "dot2" else t[0] * t[3] - t[1] * t[2]
        assert abs(true - Fraction(r)) <= Fraction(er)


def test_running_root():
    rng = np.random.default_rng(33)
    for k in range(amount(20_000)):
        x, ex = draw(rng)
        x = abs(x)
        if k % 2:  # errors of the size of one rounding, just above a power of two
            x = (1 + int(rng.integers(0, 64)) * 2.0**-52) * 2.0 ** int(rng.integers(-6, 6))
            ex = x * 2.0**-53 * float(rng.uniform(0, 4))
        if rng.integers(5) == 0:
            x = -x
        r, er = running.root(x, ex)
        lo, hi = Fraction(r) - Fraction(er), Fraction(r) + Fraction(er)
        for side in (-1, 0, 1):
            true = max(Fraction(0), Fraction(x) + side * Fraction(ex))
            # lo <= sqrt(true) <= hi
            assert hi >= 0 and hi * hi >= true, (x, ex, side)
            assert lo <= 0 or lo * lo <= true, (x, ex, side)


def test_uncompiled_kernels_give_the_same_bits():
    rng = np.random.default_rng(34)
    for _ in range(50):
        (x, ex), (y, ey) = draw(rng), draw(rng)
        if not abs(y) > ey:
            continue
        for kernel in (running.add, running.sub, running.mul, running.div):
            assert kernel.py_func(x, ex, y, ey) == kernel(x, ex, y, ey)
        assert running.root.py_func(x, ex) == running.root(x, ex)
        assert running.dot2.py_func(x, y, ex, y, x, ey) == running.dot2(x, y, ex, y, x, ey)
        assert angle.angle_of.py_func(x, y) == angle.angle_of(x, y)
        assert angle.angle_bounds.py_func(x, ex, y, ey) == angle.angle_bounds(x, ex, y, ey)
        assert verdict.cross.py_func(x, y, ex, ey, x, y) == verdict.cross(x, y, ex, ey, x, y)


# ---------------------------------------------------------------------------------------------------- frames


def exact_frame(axis, rounded) -> list[list[arb]]:
    """An orthonormal frame with exactly this axis, from the same seed direction as `rounded` has."""
    h = [arb(fmpq(x.numerator, x.denominator)) for x in map(Fraction, axis)]
    length = sum((x * x for x in h), arb(0)).sqrt()
    h = [x / length for x in h]
    # the seed is the coordinate axis to which the first row is orthogonal
    k = min(range(3), key=lambda i: abs(rounded[0][i]))
    seed = [arb(i == k) for i in range(3)]
    u = arb_cross(seed, h)
    size = sum((x * x for x in u), arb(0)).sqrt()
    u = [x / size for x in u]
    return [u, arb_cross(h, u), h]


def arb_cross(x, y):
    return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]


def test_frame_is_orthonormal():
    rng = np.random.default_rng(41)
    axes = [tuple(a) for a in rng.normal(size=(600, 3)).tolist()]
    axes += [tuple(map(float, a)) for a in rng.integers(-3, 4, (200, 3)).tolist() if np.count_nonzero(a) > 1]
    axes += [(1.0, 1e-17, 0.0), (1e-200, 1.0, 1e-200), (1e300, 1e300, 1e299), (3e-310, 4e-310, 1e-312)]
    axes += [(1.0, 1.0, math.nextafter(1.0, 2.0)), (1e-160, 1e-320, 1e-160)]
    rational = [tuple(Fraction(int(p), int(q)) for p, q in rng.integers(1, 99, (3, 2))) for _ in range(100)]
    worst = 0.0
    for axis in [*axes, *rational]:
        frame = frame_of(tuple(map(float, axis)))
        with precision(200):
            exact = exact_frame(axis, frame)
            gap = max(float(abs(arb(f) - e).upper()) for row, other in zip(frame, exact, strict=True)
                      for f, e in zip(row, other, strict=True))  # fmt: skip
            handed = sum((a * b for a, b in zip(arb_cross(exact[0], exact[1]), exact[2], strict=True)), arb(0))
            assert handed > 0
        worst = max(worst, gap)
        assert gap < FRAME_EPS, axis
    assert worst > 1e-17


@pytest.mark.parametrize("axis", [(s * (k == 0), s * (k == 1), s * (k == 2)) for k in range(3) for s in (2.0, -5.0)])
def test_frames_of_coordinate_axes_are_exact(axis):
    frame = np.array(frame_of(axis))
    assert np.array_equal(frame @ frame.T, np.eye(3)) and np.linalg.det(frame) == 1
    assert np.array_equal(frame[2], np.sign(axis))
