"""One equation gives the instants of contacts that are known to be there: those that the exact pair tests find."""

from __future__ import annotations

import itertools
import math
import random

import numpy as np
import pytest
from flint import fmpq, fmpz

from amount import amount
from firstcontact.exact.times.instants import AngleInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.pairs.elements import coplanar, line_line, line_line_rotation, point_plane, point_plane_rotation
from firstcontact.search.trees import state, walk

KINDS = {"vertex and face": (1, 3), "face and vertex": (3, 1), "edges": (2, 2)}
BITS = (30, 36, 42, 48, 54, 60)
WIDTHS = (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3)


def whole(*numbers):
    return tuple(map(fmpz, numbers))


def random_elements(kind, rng, size):
    return [[whole(*(rng.randint(-size, size) for _ in range(3))) for _ in range(n)] for n in KINDS[kind]]


def window(kind, a, b, v):
    if kind == "edges":
        return line_line.translation_window(*a, *b, v)
    if kind == "vertex and face":
        return point_plane.translation_window(a[0], *b, v)
    return point_plane.translation_window(b[0], *a, tuple(-x for x in v))


def contacts(kind, axis, a, b):
    if kind == "edges":
        return line_line_rotation.rotation_contacts(axis, *a, *b)
    if kind == "vertex and face":
        return point_plane_rotation.rotation_contacts(axis, a[0], *b)
    return point_plane_rotation.rotation_contacts(axis.reversed(), b[0], *a)


@pytest.mark.parametrize("kind", KINDS)
def test_instants_of_translations(kind):
    met = 0
    for seed in range(amount(3000)):
        rng = random.Random(seed)
        a, b = random_elements(kind, rng, 4)
        v = whole(*(rng.randint(-4, 4) for _ in range(3)))
        found, instant = window(kind, a, b, v), coplanar.translation_instant(a, b, v)
        if found is not None and found[0] == found[1] and instant is not None:
            assert instant == fmpq(found[0])
            met += 1
        elif found is not None:
            assert instant is None  # it lasts, or another equation holds
    assert met > amount(100)


@pytest.mark.parametrize("kind", KINDS)
def test_instants_of_rotations(kind):
    """Around every contact, in intervals of many widths: the same instant, or none; none where two are in it."""
    given = 0
    for seed in range(amount(450)):
        rng = random.Random(seed)
        axis = Axis(whole(*rng.choice([(0, 0, 1), (1, 2, 2), (rng.randint(1, 9), -3, 7)])))
        a, b = random_elements(kind, rng, rng.choice([3, 50]))
        given += assert_same_instants(axis, a, b, contacts(kind, axis, a, b))
    assert given > amount(100)


def assert_same_instants(axis, a, b, found):
    """Asks around every instant; how often there was an answer."""
    instants = [instant for instant, _ in found]
    given = 0
    for instant, width in itertools.product(instants, WIDTHS):
        lo, hi = instant.bounds()
        lo, hi = lo - 0.7 * width, hi + 0.3 * width
        inside = [i for i in instants if i.bounds()[0] <= hi and lo <= i.bounds()[1]]
        answer = coplanar.rotation_instant(axis, a, b, lo, hi)
        if any(i.compare(instant) for i in inside):
            assert answer is None
        elif answer is not None:
            assert answer.compare(instant) == 0
            assert cosine(answer) == pytest.approx(math.cos(lo), abs=2 * width + 1e-14)
            given += 1
    return given


def cosine(instant: AngleInstant) -> float:
    return float(instant.X.ball() / instant.R.ball())


@pytest.mark.parametrize("bits", BITS)
def test_two_roots_close_together(bits):
    """A circle of radius 1 dips 2^-bits into a wall: an interval with room for both instants has no answer."""
    size = 2**bits
    wall = [whole(size - 1, y * size, z * size) for y, z in ((0, -3), (9, 6), (-9, 6))]
    axis, vertex = Axis(whole(0, 0, 1)), whole(0, -size, 0)
    found = point_plane_rotation.rotation_contacts(axis, vertex, *wall)
    (first, _), (second, _) = found
    gap = abs(first.bounds()[0] - second.bounds()[0])
    assert gap == pytest.approx(2 ** (1.5 - bits / 2), rel=1e-3)
    assert assert_same_instants(axis, [vertex], wall, found) >= 2 * sum(4 * w + 1e-13 < gap for w in WIDTHS)


@pytest.mark.parametrize("bits", BITS)
@pytest.mark.parametrize("side", [-1, 1])
def test_two_pairs_close_together(bits, side):
    """Two vertices a hair apart against one wall: their instants differ the way the vertices do."""
    size = 2**bits
    axis, wall = Axis(whole(1, 0, 2)), [whole(0, 0, -9), whole(0, 9, 9), whole(0, -9, 9)]
    wall = [tuple(size * x for x in p) for p in wall]
    first, second = whole(size, size // 3, 0), whole(size + side, size // 3, 0)
    (x, _), (y, _) = (point_plane_rotation.rotation_contacts(axis, p, *wall)[0] for p in (first, second))
    lo, hi = min(x.bounds()[0], y.bounds()[0]) - 1e-12, max(x.bounds()[1], y.bounds()[1]) + 1e-12
    p, q = (coplanar.rotation_instant(axis, [v], wall, lo, hi) for v in (first, second))
    assert p.compare(x) == 0 and q.compare(y) == 0
    assert p.compare(q) == x.compare(y) == -q.compare(p) != 0


def test_elements_that_stay_in_one_plane_have_no_instant():
    axis = Axis(whole(0, 0, 1))
    flat = [whole(1, 0, 5), whole(3, 0, 5)], [whole(0, 1, 5), whole(0, 3, 5)]
    assert coplanar.rotation_instant(axis, *flat, 1.0, 2.0) is None
    assert coplanar.translation_instant(*flat, whole(0, 3, 0)) is None


def test_an_instant_at_the_start_is_not_bounded_by_an_interval_a_turn_later():
    """Angles are counted from 0 on: of an interval about a full turn nothing is said of the one found."""
    wall = [whole(1, 0, 0), whole(1, 0, 3), whole(3, 0, -9)]
    instant = coplanar.rotation_instant(Axis(whole(0, 0, 1)), [whole(2, 0, 0)], wall, 6.2831, 6.2832)
    assert instant.is_zero() and instant.bounds()[1] < 1e-9


@pytest.mark.parametrize("sure", [True, False])
def test_certain_contacts_keep_their_whole_interval(sure):
    """The proof that one root is meant needs it; of unsure ones it is known that nothing meets before the key."""
    floats, integers = np.array([0.0, 0.0, 9.0, 9.0, 2.0, 0.0]), np.zeros(11, np.int64)
    times, candidates = np.zeros((64, 2)), np.zeros((64, 5), np.int32)
    place = tuple(np.int64(k) for k in (5, 1, 7, 2))
    verdict = walk.CERTAIN if sure else walk.UNSURE
    walk.record(floats, integers, times, candidates, state.EDGE_EDGE, *place, verdict, 1.5, 2.5)
    assert integers[state.CANDIDATES] == 1
    assert times[0].tolist() == [1.5 if sure else 2.0, 2.5]
