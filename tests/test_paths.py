"""No default query goes far down the longer of its paths: what took many times as long as the quicker one."""

import time as clock
from itertools import product

import numpy as np
import pytest

import firstcontact as fc

CONE = "({}+7*u-3*u**2+u**3+{}*u**4,2-5*u+u**2+4*u**3-u**4,{}-3*u+u**2-2*u**3+5*u**4)"


def seconds(ask):
    """Of the processor, and the answer."""
    begin = clock.process_time()
    found = ask()
    return clock.process_time() - begin, found


@pytest.mark.thorough
def test_what_elimination_foresees_to_be_too_large_is_refused_at_once():
    """Degree 7220: resultants that only tell whether brackets share borders took 8 s, twice."""
    strip = fc.RuledSurface(
        "((1-u**4)/(1+u**4),2*u**2/(1+u**4),u**3)", "(u/(1+u**4),(u**2-u)/(1+u**4),2+u**4/(1+u**4))"
    )
    moving = strip.translated((3, 1, 0)).moving(fc.Translation((-6, -2, 0)))
    with pytest.raises(fc.UnsupportedPair, match="too large for elimination"):
        fc.first_contact(moving, strip, method="algebraic")
    spent, found = seconds(lambda: fc.first_contact(moving, strip))
    assert found.status is fc.Status.CONTACT and spent < 3


def test_elimination_is_asked_before_doubles_go_far():
    """Equations of degree 256 with short coefficients: doubles leave this tip that stays above a saddle open."""
    gap = "(1/64-29*T/80+1041*T**2/400-29*T**3/5+4*T**4)"
    tip = fc.RuledSurface(
        "((-11/64+u/64-5*u**2/64)/(1+u**2),(1/128+7*u/64-5*u**2/128)/(1+u**2),(25/128+u/32-17*u**2/128)/(1+u**2))",
        "(-1/64,-1/64,1/64)", u=(-1, 1),
    )  # fmt: skip
    first, second = (
        f"({x}/128+u/128+21*u**2/128+7*{gap}/128,{y}/256+7*u/128,{z}/256+u/64-3*u**2/128-{gap}/128)"
        for x, y, z in ((-3, -3, 11), (-4, -2, 18))
    )
    saddle = fc.RuledSurface(first, second, u=(-1, 2), s=(-3, 3))
    free, intervals = fc.first_contact(tip, saddle, (0.1, 0.5)), fc.contact_intervals(tip, saddle, (0.1, 0.5))
    assert free.status is intervals.status is fc.Status.FREE
    assert [x.way for x in free.stats.ways] == ["in doubles", "exactly"]
    assert [x.way for x in intervals.stats.ways] == ["in doubles", "exactly"]


@pytest.mark.thorough
def test_two_cones_with_one_apex():
    """Their common rulings are common zeros of two quartics: whether u and v belong together took 17 s."""
    a, b = (fc.RuledSurface("(0,0,0)", CONE.format(*x), u=(-4, 4)) for x in ((1, 2, -3), (-2, 1, 4)))
    spent, exact = seconds(lambda: fc.intersection_curve(a, b))
    assert spent < 10 and exact.common_rulings
    for u, v in exact.common_rulings:
        assert angle(a, float(u), b, float(v)) < 1e-6
    told = {(round(float(u), 6), round(float(v), 6)) for u, v in exact.common_rulings}
    assert {x for x in told if max(map(abs, x)) < 4} == by_newton(a, b)


def angle(a, u, b, v):
    """Sine of that between two rulings."""
    p, q = a.second.points(u), b.second.points(v)
    return np.linalg.norm(np.cross(p, q)) / np.linalg.norm(p) / np.linalg.norm(q)


def by_newton(a, b, step=1e-7):
    """Where rulings of either cone are one line, from a grid of starts."""
    def off(x):
        p, q = a.second.points(x[0]), b.second.points(x[1])
        return np.cross(p / np.linalg.norm(p), q / np.linalg.norm(q))

    found = set()
    for x in product(np.linspace(-4, 4, 17), repeat=2):
        x = np.array(x)
        for _ in range(12):
            value = off(x)
            slopes = np.stack([(off(x + step * e) - value) / step for e in np.eye(2)], axis=1)
            x = x - np.linalg.lstsq(slopes, value, rcond=None)[0]
            if not np.abs(x).max() < 50:
                break
        if np.abs(x).max() < 4 and np.linalg.norm(off(x)) < 1e-9:
            found.add((round(float(x[0]), 6), round(float(x[1]), 6)))
    return found
