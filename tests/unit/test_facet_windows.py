"""When two facets straddle each other's planes, as doubles tell it, against fractions."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from firstcontact.pairs.elements import facet_facet
from unit.inputs import FAMILIES, count, disturbed, errors, points, translations

WINDOWS = [(0.0, 1.0), (0.0, math.inf), (-math.inf, math.inf), (0.25, 0.5), (0.0, 0.0)]


def fractions(p):
    return [Fraction(int(x.p), int(x.q)) if hasattr(x, "p") else Fraction(x) for x in p]


def dot(x, y):
    return sum(a * b for a, b in zip(x, y, strict=True))


def one_side(plane, facet, v):
    """The closed times at which facet + t v has no side of the plane to itself: (lo, hi), None for an open end; or
    None where there are none."""
    p, q, r = plane
    e, f = ([x - y for x, y in zip(s, p, strict=True)] for s in (q, r))
    n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
    heights = [dot(n, [x - y for x, y in zip(c, p, strict=True)]) for c in facet]
    speed = dot(n, v)
    if speed == 0:
        return (None, None) if min(heights) <= 0 <= max(heights) else None
    ends = sorted([-min(heights) / speed, -max(heights) / speed])
    return ends[0], ends[1]


def both(a, b, v, first, last):
    """The times in [first, last] at which both straddle, as (lo, hi); lo > hi or None where there are none."""
    lo, hi = first, last
    for ends in (one_side(b, a, v), one_side(a, b, [-x for x in v])):
        if ends is None:
            return None
        lo = lo if ends[0] is None else max(lo, ends[0])
        hi = hi if ends[1] is None else min(hi, ends[1])
    return lo, hi


@pytest.mark.thorough
@pytest.mark.parametrize("rounded", [False, True])
@pytest.mark.parametrize("family", FAMILIES)
def test_window_holds_all_times_at_which_both_straddle(family, rounded):
    rng = np.random.default_rng(55)
    n = count(family) if not rounded else 1200
    a, b = points(family, rng, n, 3), points(family, rng, n, 3)
    v = translations(family, rng, a, b)
    never = 0
    for row, (xa, xb, vel) in enumerate(zip(a.tolist(), b.tolist(), v.tolist(), strict=True)):
        err_a, err_b = (errors(rng), errors(rng)) if rounded else (0.0, 0.0)
        first, last = WINDOWS[row % len(WINDOWS)]
        true_a, true_b = ([fractions(disturbed(p, err, rng)) if rounded else fractions(p) for p in x]
                          for x, err in ((xa, err_a), (xb, err_b)))  # fmt: skip
        true = both(true_a, true_b, fractions(vel), first, last)
        lo, hi = facet_facet.translation_window(
            np.array(xa).ravel(), np.array(xb).ravel(), *vel, err_a, err_b, first, last
        )
        never += not lo <= hi
        if true is None or true[0] > true[1]:
            continue
        assert lo <= true[0] and hi >= true[1], (xa, xb, vel, err_a, err_b)
        if family == "random" and not rounded and lo < hi:
            assert all(
                math.isinf(x) or abs(x - y) <= 1e-6 * (1 + abs(y)) for x, y in ((lo, true[0]), (hi, true[1]))
            ), (xa, xb, vel)
    assert never > (0.2 * n if not rounded else 0.02 * n)


def test_both_orders_tell_the_same_of_a_scene_by_hand():
    flat, upright = [0, 0, 0, 4, 0, 0, 0, 4, 0], [1, 1, 2, 2, 1, 3, 1, 2, 3]
    falls, rises = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
    x, y = np.array(upright, float), np.array(flat, float)
    assert facet_facet.translation_window(x, y, *falls, 0.0, 0.0, 0.0, 10.0) == pytest.approx((2.0, 3.0))
    assert facet_facet.translation_window(y, x, *rises, 0.0, 0.0, 0.0, 10.0) == pytest.approx((2.0, 3.0))
    lo, hi = facet_facet.translation_window(x, y, *rises, 0.0, 0.0, 0.0, 10.0)
    assert lo > hi
