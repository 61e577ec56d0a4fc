"""The float filters of rotations against the exact faces of the same files."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from flint import arb, fmpq

from firstcontact.exact.numbers import precision
from firstcontact.exact.times.turning import Axis
from firstcontact.kernels.angle import TWO_PI
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements import line_line_rotation, point_plane_rotation
from unit.inputs import FAMILIES, count, disturbed, errors, exact, points, turned_onto

Z, BACK = (Axis((fmpq(0), fmpq(0), fmpq(s))) for s in (1, -1))


def flat(*corners) -> list[float]:
    return [x for corner in corners for x in corner]


def mirrored(corner):
    """The mirror image y -> -y: turning backward becomes turning forward."""
    x, y, z = corner
    return x, -y, z


def angles(contacts) -> list[arb]:
    with precision(160):
        return [instant.local() for instant, _ in contacts]


def encloses(lo: float, hi: float, phi: arb) -> bool:
    """The double 2 pi, a little below the number, stands for the full turn."""
    with precision(160):
        return not (phi < arb(lo)) and (hi == TWO_PI or not (phi > arb(hi)))


def assert_honest(answer, contacts: list[arb], scene) -> list[int]:
    """Both verdicts of a filter against all exact contact angles in [0, 2 pi)."""
    found = [(answer[k], answer[k + 1], answer[k + 2]) for k in (0, 3)]
    for phi in contacts:
        assert any(v != NONE and encloses(lo, hi, phi) for v, lo, hi in found), (float(phi), answer, scene)
    for v, lo, hi in found:
        if v == CERTAIN:
            assert any(encloses(lo, hi, phi) for phi in contacts), (answer, scene)
            assert 0 <= lo <= hi < TWO_PI
    return [v for v, _, _ in found]


def edge_orders(x, y):
    """The same question with swapped bodies (mirrored, as turns reverse) and reversed edges."""
    (a, b), (c, d) = x, y
    m = mirrored
    return [
        (flat(a, b, c, d), False),
        (flat(m(c), m(d), m(a), m(b)), True),
        (flat(b, a, c, d), False),
        (flat(m(d), m(c), m(b), m(a)), True),
    ]


def facet_orders(x, y):
    (p,), (a, b, c) = x, y
    return [(flat(p, a, b, c), False), (flat(p, b, c, a), False), (flat(p, c, b, a), False)]


EDGES = (line_line_rotation, edge_orders, (2, 2))
FACET = (point_plane_rotation, facet_orders, (1, 3))
KINDS = pytest.mark.parametrize("kind", [EDGES, FACET], ids=["edge edge", "vertex facet"])


def scenes(family, rng, n, kind):
    (m, k) = kind[2]
    a, b = points(family, rng, n, m), points(family, rng, n, k)
    return zip(a.tolist(), turned_onto(family, rng, a, b).tolist(), strict=True)


@pytest.mark.thorough
@KINDS
@pytest.mark.parametrize("family", FAMILIES)
def test_filter_agrees_with_exact_contacts(kind, family):
    pair, orders, _ = kind
    rng = np.random.default_rng(61)
    n = count(family)
    seen: Counter = Counter()
    for row, (x, y) in enumerate(scenes(family, rng, n, kind)):
        options = orders(x, y)
        asked = [args for args, _ in (options[0], options[1 + row % (len(options) - 1)])]
        answers = [pair.rotation_filter(*args, 0.0, 0.0) for args in asked]
        verdicts = [{answer[0], answer[3]} for answer in answers]
        assert not ({NONE} in verdicts and any(CERTAIN in v for v in verdicts)), asked
        seen.update(v for answer in answers for v in (answer[0], answer[3]))
        if row % 4 == 0 or any(UNSURE in v for v in verdicts):  # exact angles are slow
            contacts = angles(pair.rotation_contacts(Z, *map(exact, x), *map(exact, y)))
            for args, answer in zip(asked, answers, strict=True):
                assert_honest(answer, contacts, args)
    if family == "random":  # the filter decides nearly everything that is not degenerate
        assert seen[CERTAIN] > 0.4 * n and seen[UNSURE] < 0.01 * n, seen
    else:
        assert seen[NONE] > 0.2 * n and seen[UNSURE] > 0, seen


@pytest.mark.share(6)
@KINDS
@pytest.mark.parametrize("family", FAMILIES)
def test_filter_with_rounded_coordinates(kind, family):
    pair, orders, _ = kind
    rng = np.random.default_rng(62)
    seen: Counter = Counter()
    for x, y in scenes(family, rng, 1200, kind):
        err_a, err_b = errors(rng), errors(rng)
        true = [disturbed(p, err_a, rng) for p in x] + [disturbed(p, err_b, rng) for p in y]
        contacts = angles(pair.rotation_contacts(Z, *true))
        for args, swapped in orders(x, y):
            bounds = (err_b, err_a) if swapped else (err_a, err_b)
            answer = pair.rotation_filter(*args, *bounds)
            seen.update(assert_honest(answer, contacts, (args, bounds)))
    assert seen[NONE] and seen[UNSURE] and seen[CERTAIN], seen


@pytest.mark.share(6)
@pytest.mark.parametrize("family", FAMILIES)
def test_exact_contacts_do_not_depend_on_the_order_of_the_bodies(family):
    """b seen from a turns backward; angles agree exactly."""
    rng = np.random.default_rng(63)
    met = 0
    for x, y in scenes(family, rng, 800, EDGES):
        a, b = [exact(p) for p in x], [exact(p) for p in y]
        forward = [i for i, _ in line_line_rotation.rotation_contacts(Z, *a, *b)]
        backward = [i for i, _ in line_line_rotation.rotation_contacts(BACK, *b, *a)]
        for mine, its in ((forward, backward), (backward, forward)):
            for instant in mine:
                met += 1
                assert any(instant.compare(other) == 0 for other in its)
    assert met > 50


@pytest.mark.parametrize("family", FAMILIES)
def test_uncompiled_filters_give_the_same_bits(family):
    rng = np.random.default_rng(64)
    compared = 0
    for row in points(family, rng, 80, 4).tolist():
        args = (*flat(*row), 2.0**-50, 0.0)
        for pair in (line_line_rotation, point_plane_rotation):
            compared += 1
            assert pair.rotation_filter.py_func(*args) == pair.rotation_filter(*args)
    assert compared == 160


def test_post_that_turns_into_a_wall():
    """By hand: the post at (1, 0) meets the plane x = 0 after a quarter turn, and again after three."""
    post, wall = [(1.0, 0.0, 0.25)], [(0.0, -2.0, -1.0), (0.0, 2.0, -1.0), (0.0, 0.0, 5.0)]
    answer = point_plane_rotation.rotation_filter(*flat(*post, *wall), 0.0, 0.0)
    assert answer[0] == answer[3] == CERTAIN
    for (lo, hi), quarter in zip(sorted([answer[1:3], answer[4:6]]), (1, 3), strict=True):
        assert lo <= quarter * TWO_PI / 4 <= hi and hi - lo < 1e-13


def test_edges_that_graze_are_left_to_exact_arithmetic():
    post, bar = [(1.0, 0.0, -1.0), (1.0, 0.0, 1.0)], [(-2.0, 1.0, 0.0), (2.0, 1.0, 0.25)]
    answer = line_line_rotation.rotation_filter(*flat(*post, *bar), 0.0, 0.0)
    assert UNSURE in (answer[0], answer[3]) and CERTAIN not in (answer[0], answer[3])
    (contact,) = line_line_rotation.rotation_contacts(Z, *map(exact, post), *map(exact, bar))
    assert contact[0].quarter() == 1
