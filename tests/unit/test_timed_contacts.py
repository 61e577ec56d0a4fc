"""Times of certain contacts in pairs of doubles, against fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from firstcontact.kernels import double_double
from firstcontact.search.trees.state import EDGE_EDGE, FACE_VERTEX, VERTEX_FACE
from firstcontact.search.trees.timed import NEAR, is_before, time_of

U = Fraction(1, 2**53)


def dot(x, y):
    return sum(a * b for a, b in zip(x, y, strict=True))


def minus(x, y):
    return [a - b for a, b in zip(x, y, strict=True)]


def truth(kind, a, i, b, j, v):
    """The time at which two elements span no volume, of corners (3, 3) of fractions; None where there is none."""
    if kind == EDGE_EDGE:
        p, q = a[i], b[j]
        x, y = minus(a[(i + 1) % 3], p), minus(b[(j + 1) % 3], q)
    elif kind == VERTEX_FACE:
        p, q = a[i], b[0]
        x, y = minus(b[1], q), minus(b[2], q)
    else:
        p, q = a[0], b[j]
        x, y = minus(a[1], p), minus(a[2], p)
    n = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
    speed = dot(n, v)
    return dot(n, minus(q, p)) / speed if speed else None


def parts(family, rng):
    """Corners (9,) and a velocity of one scene."""
    if family == "lattice":
        return *rng.integers(-3, 4, (2, 9)).astype(float), rng.integers(-3, 4, 3).astype(float)
    if family == "thin":
        a, b = rng.normal(size=(2, 9))
        a[6:9], b[6:9] = a[3:6] + 1e-7 * rng.normal(size=3), b[3:6] + 1e-6 * rng.normal(size=3)
        return a, b, rng.normal(size=3)
    if family == "far":  # small beside their place: what corners are off by beyond their rests is what counts
        a, b = rng.normal(size=(2, 3, 3)) * 2.0 ** rng.integers(-50, -8)
        place = np.array([1.0, -3.0, 2.0])
        return (a + place).ravel(), (b + place).ravel(), rng.normal(size=3)
    scale = 2.0 ** rng.integers(-60, 60)
    return scale * rng.normal(size=9), scale * (rng.normal(size=9) + 2.0), scale * rng.normal(size=3)


@pytest.mark.share(9)
@pytest.mark.parametrize("kind", [VERTEX_FACE, EDGE_EDGE, FACE_VERTEX])
@pytest.mark.parametrize("family", ["random", "thin", "lattice", "rounded", "far"])
def test_a_told_time_is_the_nearest_double_and_on_the_side_told(family, kind):
    rng = np.random.default_rng(61)
    told = 0
    n = 1500
    for _ in range(n):
        a, b, v = parts(family, rng)
        i, j = rng.integers(0, 3, 2).tolist()
        rests = [np.zeros(9), np.zeros(9)]
        true = [[Fraction(x) for x in side.tolist()] for side in (a, b)]
        if family in ("rounded", "far"):  # corners that are no doubles: 60 digits more, nearly all of them given
            for side, x in enumerate((a, b)):
                shares = [Fraction(int(k), 2**60) for k in rng.integers(-(2**60), 2**60, 9)]
                off = [share * Fraction(y) * U for share, y in zip(shares, x.tolist(), strict=True)]
                rests[side] = np.array([float(y) for y in off])
                true[side] = [y + z for y, z in zip(true[side], off, strict=True)]
        corners = [[x[:3], x[3:6], x[6:]] for x in true]
        time = truth(kind, corners[0], i, corners[1], j, [Fraction(x) for x in v.tolist()])
        t, r = time_of(kind, a, rests[0], i, b, rests[1], j, *v)
        if np.isnan(t):
            continue
        told += 1
        scene = a.tolist(), b.tolist(), v.tolist(), kind, i, j
        assert float(time) == t, scene
        off = time - Fraction(t)
        assert (off > 0) == (r > 0) and off != 0, scene
        assert abs(off - Fraction(r)) <= Fraction(NEAR) * time, scene
    if family != "lattice":  # half of the times are negative
        assert told > (0.02 if family in ("thin", "far") else 0.4) * n


def test_times_that_are_doubles_are_left_to_exact_arithmetic():
    a, b = np.array([0, 0, 5, 1, 0, 6, 0, 1, 6.0]), np.array([-9, -9, 0, 9, -9, 0, 0, 9, 0.0])
    assert np.isnan(time_of(VERTEX_FACE, a, np.zeros(9), 0, b, np.zeros(9), 0, 0.0, 0.0, -1.0)[0])
    assert time_of(VERTEX_FACE, a, np.zeros(9), 0, b, np.zeros(9), 0, 0.0, 0.0, -3.0)[0] == 5.0 / 3.0


def test_order_is_told_only_where_it_is_certain():
    third = 1.0 / 3.0, float(Fraction(1, 3) - Fraction(1.0 / 3.0))
    assert not is_before(*third, *third)
    assert not is_before(*third, third[0], third[1] * (1.0 + 1e-10))
    assert is_before(third[0], third[1] - 1e-20, *third) and not is_before(*third, third[0], third[1] - 1e-20)


def test_sums_products_and_quotients_are_within_their_bounds():
    rng = np.random.default_rng(62)
    bounds = {"add": 3.01 * U**2, "multiply": 7 * U**2, "divide": Fraction(1, 2**100)}
    exact = {"add": lambda x, y: x + y, "multiply": lambda x, y: x * y, "divide": lambda x, y: x / y}
    for _ in range(1500):
        numbers = []
        for _ in range(2):
            x = float(rng.normal()) * 2.0 ** int(rng.integers(-40, 40))
            numbers.append(double_double.two_sum(x, x * 2.0**-53 * float(rng.uniform(-1, 1))))
        if rng.random() < 0.3:  # sums that cancel
            numbers[1] = -numbers[0][0] * (1.0 + 2.0 ** -int(rng.integers(20, 53))), numbers[1][1] * 1e-30
            numbers[1] = double_double.two_sum(*numbers[1])
        x, y = (Fraction(p) + Fraction(q) for p, q in numbers)
        for name, bound in bounds.items():
            h, rest = getattr(double_double, name)(*numbers[0], *numbers[1])
            wanted = exact[name](x, y)
            assert abs(Fraction(h) + Fraction(rest) - wanted) <= bound * abs(wanted), (name, numbers)
