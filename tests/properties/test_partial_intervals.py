"""What is told of intervals where a budget ends the search: nothing that the whole answer denies."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

NOTCHED = [(-3, -2), (3, -2), (3, 2), (2, 2), (2, -1), (-2, -1), (-2, 2), (-3, 2)]


def notched():
    """A prism over a U, z from -1 to 1."""
    n = len(NOTCHED)
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    corners = [(*p, z) for z in (-1, 1) for p in NOTCHED]
    return fc.Polyhedron(corners, [list(range(n))[::-1], list(range(n, 2 * n)), *sides])


BALL, SADDLE = fc.sphere("1/2"), fc.RuledSurface("(u, -1, u)", "(u, 1, -u)", u=(-1, 1))
PATHS = {
    "through": fc.Translation((10, 0, 0)),
    "there and back": fc.Sequence([fc.Translation((10, 0, 0)), fc.Translation((-10, 0, 0))]),
    "around": fc.Rotation((0, 0, 1), (5, 0, 0), turns=2),
    "in a screw": fc.Screw((1, 0, 0), (0, 0, 0), degrees=500, advance=10),
}
PAIRS = {
    "meshes": (fc.examples.box((1, 1, 1)), notched()),
    "mesh and ball": (BALL, notched()),
    "balls": (BALL, fc.sphere(1)),
    "a tube and a ball": (BALL, fc.cylinder(3, 2) - fc.cylinder(2, 3)),
    "ruled and ball": (BALL, SADDLE),
    "ruled and mesh": (fc.examples.box((1, 1, 1)), SADDLE),
    "ring and ball": (BALL, fc.torus(2, "1/4")),
}
BUDGETS = sorted({int(1.2**k) for k in range(52)})
"""Up to ten thousand; each ends at another place."""


def meets(x, y):
    return x[0] <= y[1] and y[0] <= x[1]


def circling_ball():
    ball = fc.sphere(4).translated((9.5, -4.5, 5)).moving(fc.Rotation((0, -1, 0), (1.5, 1.5, 2), turns=F(2, 3)))
    return fc.half_space((F(2, 3), F(1, 3), F(2, 3)), 6), ball, (0.625, 1.25)


def graphs():
    """Two surfaces, one of which goes by two units and comes back, ever faster first."""
    one, none = np.eye(4, dtype=int).tolist(), np.zeros((4, 4), int).tolist()
    up = [[0, 0, 0, 0], [0, 0, 0, 2], [0, 0, 0, 0], [0, 0, 0, 0]]
    steps = [fc.RationalMotion([one, none, up]), *(fc.Translation((0, y, 0)) for y in (-1, 2, -2))]
    still = fc.RuledSurface("(2/3*u - 4/3, 15 - 20/3*u + 4/3*u**2, -3)", "(2/3*u - 4/3, 50/3 - 10*u + 4/3*u**2, 2)",
                            u=(2, 5))  # fmt: skip
    moving = fc.RuledSurface("(1, 2 - 54*u**2, 18*u**2 - 1)", "(1001/1000, 1001/500 - 27009/500*u**2, 18*u**2 - 1)",
                             u=(0, F(1, 3)), s=(-1000, 1000))  # fmt: skip
    return still, moving.moving(fc.Sequence(steps, [2, F(1, 3), 2, F(1, 3)])), None


FOUND = {"a circling ball": circling_ball, "graphs": graphs}
"""Scenes in which what a budget left said that contact ends where the search did."""


@pytest.mark.parametrize("scene", list(FOUND))
def test_what_goes_on_where_a_budget_ends_has_no_end_yet(scene):
    a, b, span = FOUND[scene]()
    assert agreeing_parts(a, b, span, "auto", BUDGETS)


@pytest.mark.share(14)
@pytest.mark.parametrize("method", ["auto", "certified", "algebraic"])
@pytest.mark.parametrize("path", list(PATHS))
@pytest.mark.parametrize("pair", list(PAIRS))
def test_a_budget_ends_in_a_part_of_the_whole(pair, path, method):
    moving, other = PAIRS[pair]
    body = moving.translated((-5, F(1, 16), 0)).moving(PATHS[path])
    agreeing_parts(body, other, None, method, BUDGETS[::4])


def agreeing_parts(a, b, span, method, budgets):
    """How many answers of smaller budgets, none of which the whole one denies, are UNDECIDED."""
    whole = fc.contact_intervals(a, b, span)
    decided_until = whole.span[1] if whole.status is not fc.Status.UNDECIDED else whole.free_until
    for count, budget in enumerate(budgets):
        try:
            part = fc.contact_intervals(a, b, span, budget=budget, method=method)
        except fc.UnsupportedPair:
            return 0
        if part.status is not fc.Status.UNDECIDED:
            return count
        until, last = part.free_until, part.span[1]
        for x in part:
            near = [y for y in whole if meets(x.start_interval, y.start_interval)]
            if near:
                assert meets(x.end_interval, near[0].end_interval), (budget, until, x.end_interval, near[0])
            else:
                assert x.start_interval[1] >= decided_until, (budget, x.start_interval)
            assert x.end_interval[1] < until or x.end_interval[1] == last, (budget, until, x.end_interval)
        before = [y for y in whole if y.start_interval[1] < until - 1e-9]
        assert all(any(meets(x.start_interval, y.start_interval) for x in part) for y in before), (budget, until)
    return len(budgets)


LEGS = np.array([(5, 0, 0), (5, 0, F(1, 4)), (-5, 0, F(1, 4)), (-5, 0, 0), (5, F(1, 4), 0), (5, 0, -1)], float)
"""Of a path that crosses the middle three times, in six equal parts of the time; every second one ends in contact."""


def crossings(gap, begin):
    """[(start, end)] of the times at which `gap` of the middle is not positive along the path from there, by halving
    between samples that tell them apart."""
    corners = begin + np.vstack([np.zeros(3), np.cumsum(LEGS, axis=0)])

    def at(t):
        k = min(int(len(LEGS) * t), len(LEGS) - 1)
        return gap(corners[k] + (len(LEGS) * t - k) * LEGS[k])

    times = np.linspace(0.0, 1.0, 1801)
    signs = [at(t) <= 0.0 for t in times]
    ends = []
    for k in np.flatnonzero(np.diff(signs)):
        lo, hi = times[k], times[k + 1]
        for _ in range(60):
            middle = 0.5 * (lo + hi)
            lo, hi = (middle, hi) if (at(middle) <= 0.0) == signs[k] else (lo, middle)
        ends.append(hi)
    return list(zip(ends[::2], ends[1::2], strict=True))


BOTH = {
    "balls": (BALL, fc.sphere(1), lambda c: np.linalg.norm(c) - 1.5),
    "boxes": (fc.examples.box((1, 1, 1)), fc.examples.box((2, 2, 2)), lambda c: np.abs(c).max() - 1.5),
    "a ball and a box": (BALL, fc.examples.box((2, 2, 2)),
                         lambda c: np.linalg.norm(np.maximum(np.abs(c) - 1.0, 0.0)) - 0.5),
}  # fmt: skip


@pytest.mark.parametrize("method", ["auto", "certified", "algebraic"])
@pytest.mark.parametrize("pair", list(BOTH))
def test_parts_of_an_answer_are_those_of_a_formula(pair, method):
    moving, other, gap = BOTH[pair]
    begin = (-5, F(1, 8), F(1, 16))
    steps = [fc.Translation([F(x) for x in leg]) for leg in LEGS.tolist()]
    body = moving.translated(begin).moving(fc.Sequence(steps, [F(1, len(steps))] * len(steps)))
    truth = crossings(gap, np.array(begin, float))
    assert len(truth) == 3
    undecided = 0
    for budget in [*BUDGETS[:: 9 if method == "certified" else 3], None]:
        part = fc.contact_intervals(body, other, method=method, budget=budget)
        until = part.free_until if part.status is fc.Status.UNDECIDED else part.span[1]
        undecided += part.status is fc.Status.UNDECIDED
        started = [x for x in truth if x[0] < until - 1e-9]
        assert len(started) <= len(part) <= sum(x[0] < until + 1e-9 for x in truth), (budget, until)
        for x, (start, end) in zip(part, truth, strict=False):
            assert x.start_interval[0] - 1e-12 <= start <= x.start_interval[1] + 1e-12, (budget, until)
            assert x.end_interval[0] - 1e-12 <= end <= x.end_interval[1] + 1e-12, (budget, until)
    assert undecided
