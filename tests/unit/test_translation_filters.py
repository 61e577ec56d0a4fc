"""The float filters of translations and of rest against the exact faces of the same files."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements import line_line, point_plane, segment_facet
from unit.inputs import FAMILIES, above, below, count, disturbed, errors, exact, points, translations

INF = math.inf
WINDOWS = [(0.0, 1.0), (0.0, INF), (-INF, INF), (0.25, 0.5), (0.5, 0.5), (0.0, 0.0)]


def assert_honest(answer, window, first, last, scene) -> int:
    """One filter answer against the exact closed window (None: no contact at any time)."""
    verdict, lo, hi = answer
    if window is not None:
        w0, w1 = window
        inside = (w1 is None or below(first, w1)) and (w0 is None or above(last, w0))
    else:
        inside = False
    if verdict == NONE:
        assert not inside, scene
    elif verdict == CERTAIN:
        assert window is not None and window[0] is not None, scene
        assert window[0] == window[1] and below(lo, window[0]) and above(hi, window[0]), scene
    elif inside:
        assert verdict == UNSURE
        # what of the contact lies in [first, last] lies in [lo, hi]
        assert lo <= first or (w0 is not None and below(lo, w0)), scene
        assert hi >= last or (w1 is not None and above(hi, w1)), scene
    return verdict


def flat(*corners) -> list[float]:
    return [x for corner in corners for x in corner]


def edge_orders(a, b, c, d, v):
    """The same question in other orders: swapped bodies, reversed edges."""
    back = [-x for x in v]
    return [flat(a, b, c, d, v), flat(c, d, a, b, back), flat(b, a, d, c, v), flat(d, c, a, b, back)]


def facet_orders(p, a, b, c, v):
    return [flat(p, a, b, c, v), flat(p, b, c, a, v), flat(p, c, b, a, v)]


EDGES = (line_line.translation_filter, line_line.translation_window, edge_orders, (2, 2))
FACET = (point_plane.translation_filter, point_plane.translation_window, facet_orders, (1, 3))
KINDS = pytest.mark.parametrize("kind", [EDGES, FACET], ids=["edge edge", "vertex facet"])


@pytest.mark.thorough
@KINDS
@pytest.mark.parametrize("family", FAMILIES)
def test_filter_agrees_with_exact_window(kind, family):
    filter_, window_of, orders, (m, k) = kind
    rng = np.random.default_rng(51)
    n = count(family)
    a, b = points(family, rng, n, m), points(family, rng, n, k)
    v = translations(family, rng, a, b)
    seen: Counter = Counter()
    for row, (xa, xb, vel) in enumerate(zip(a.tolist(), b.tolist(), v.tolist(), strict=True)):
        corners = [*xa, *xb]
        window = window_of(*map(exact, corners), exact(vel))
        first, last = WINDOWS[row % len(WINDOWS)]
        options = orders(*corners, vel)
        for args in (options[0], options[1 + row % (len(options) - 1)]):
            answer = filter_(*args, first, last, 0.0, 0.0)
            seen[assert_honest(answer, window, first, last, args)] += 1
    if family == "random":  # the filter decides nearly everything that is not degenerate
        assert seen[CERTAIN] > 0.2 * n and seen[UNSURE] < 0.01 * n, seen
    else:
        assert seen[NONE] > 0.2 * n and seen[UNSURE] > (0.01 * n if family != "shaken" else 0), seen


@pytest.mark.share(6)
@KINDS
@pytest.mark.parametrize("family", FAMILIES)
def test_filter_with_rounded_coordinates(kind, family):
    """The true coordinates lie within err_a, err_b of the doubles, the true velocity within one rounding."""
    filter_, window_of, orders, (m, k) = kind
    rng = np.random.default_rng(52)
    n = 1200
    a, b = points(family, rng, n, m), points(family, rng, n, k)
    v = translations(family, rng, a, b)
    seen: Counter = Counter()
    for row, (xa, xb, vel) in enumerate(zip(a.tolist(), b.tolist(), v.tolist(), strict=True)):
        err_a, err_b = errors(rng), errors(rng)
        true_v = tuple(x * (1 + exact([int(rng.integers(-1, 2)) * 2.0**-54] * 3)[0]) for x in exact(vel))
        true = [disturbed(p, err_a, rng) for p in xa] + [disturbed(p, err_b, rng) for p in xb]
        window = window_of(*true, true_v)
        first, last = WINDOWS[row % len(WINDOWS)]
        for which, args in enumerate(orders(*xa, *xb, vel)):
            swapped = kind is EDGES and which in (1, 3)
            answer = filter_(*args, first, last, *((err_b, err_a) if swapped else (err_a, err_b)))
            seen[assert_honest(answer, window, first, last, (args, err_a, err_b))] += 1
    assert seen[NONE] and seen[UNSURE] and (seen[CERTAIN] or family != "random"), seen


CROSSING = {segment_facet.APART: (NONE, UNSURE), segment_facet.TOUCHING: (UNSURE,),
            segment_facet.CROSSING: (CERTAIN, UNSURE)}  # fmt: skip


@pytest.mark.share(6)
@pytest.mark.parametrize("family", FAMILIES)
def test_crossing_filter(family):
    rng = np.random.default_rng(53)
    n = count(family)
    corners = points(family, rng, n, 5)
    seen: Counter = Counter()
    for p, q, a, b, c in corners.tolist():
        truth = segment_facet.relation(*map(exact, (p, q, a, b, c)))
        for args in (flat(p, q, a, b, c), flat(q, p, b, a, c)):
            verdict = segment_facet.crossing_filter(*args, 0.0, 0.0)
            assert verdict in CROSSING[truth], args
            seen[truth, verdict] += 1
    assert seen[segment_facet.APART, NONE] > n and seen[segment_facet.CROSSING, CERTAIN] > 100, seen
    if family == "random":
        assert seen[segment_facet.APART, UNSURE] + seen[segment_facet.CROSSING, UNSURE] == 0


@pytest.mark.share(6)
@pytest.mark.parametrize("family", FAMILIES)
def test_crossing_filter_with_rounded_coordinates(family):
    rng = np.random.default_rng(54)
    seen: Counter = Counter()
    for p, q, a, b, c in points(family, rng, 1500, 5).tolist():
        err_e, err_f = errors(rng), errors(rng)
        segment = [disturbed(x, err_e, rng) for x in (p, q)]
        truth = segment_facet.relation(*segment, *(disturbed(x, err_f, rng) for x in (a, b, c)))
        verdict = segment_facet.crossing_filter(*flat(p, q, a, b, c), err_e, err_f)
        assert verdict in CROSSING[truth], (p, q, a, b, c, err_e, err_f)
        seen[verdict] += 1
    assert seen[NONE] and seen[CERTAIN] and seen[UNSURE]


@pytest.mark.parametrize("family", FAMILIES)
def test_uncompiled_filters_give_the_same_bits(family):
    rng = np.random.default_rng(55)
    for row in points(family, rng, 60, 6).tolist():
        v = row[5]
        args = (*flat(*row[:4], v), 0.0, 1.0, 0.0, 2.0**-50)
        for kernel in (line_line.translation_filter, point_plane.translation_filter):
            try:
                plain = kernel.py_func(*args)
            except ZeroDivisionError:  # Python raises where the compiled code would make an infinity
                continue
            assert plain == kernel(*args)
        args = (*flat(*row[:5]), 0.0, 2.0**-50)
        assert segment_facet.crossing_filter.py_func(*args) == segment_facet.crossing_filter(*args)


def test_edges_that_cross_after_half_the_way():
    """By hand: the x axis rises by 2 and meets the y axis at height 1."""
    args = flat((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, -1.0, 1.0), (0.0, 1.0, 1.0), (0.0, 0.0, 2.0))
    verdict, lo, hi = line_line.translation_filter(*args, 0.0, 1.0, 0.0, 0.0)
    assert verdict == CERTAIN and lo <= 0.5 <= hi and hi - lo < 1e-14
    assert line_line.translation_filter(*args, 0.0, 0.49, 0.0, 0.0)[0] == NONE


@pytest.mark.share(3)
@pytest.mark.parametrize("family", FAMILIES)
def test_contact_points_lie_on_both_edges(family):
    rng = np.random.default_rng(56)
    met = 0
    a, b = points(family, rng, 1500, 2), points(family, rng, 1500, 2)
    for x, y, v in zip(a.tolist(), b.tolist(), translations(family, rng, a, b).tolist(), strict=True):
        p, q, c, d, vel = *map(exact, x), *map(exact, y), exact(v)
        window = line_line.translation_window(p, q, c, d, vel)
        if window is None or window[0] is None:
            continue
        met += 1
        for t in window:
            moved = [tuple(u + t * w for u, w in zip(end, vel, strict=True)) for end in (p, q)]
            point = line_line.contact_point(p, q, c, d, vel, t)
            assert line_line.point_line.on_segment(point, *moved)
            assert line_line.point_line.on_segment(point, c, d)
    assert met > 100
