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
