"""Exact signs of kernels against fractions: determinants that vanish or nearly do, of points of one or two doubles."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import numpy as np
import pytest

from firstcontact.kernels.signs import UNSURE, are_in_range, cross_sign, det_sign, order, work_room

AXES = range(3)


def points_of(r, kind):
    """(high, low) of seven points: of a lattice, spread over many sizes, in one plane but for the last bits."""
    if kind == "lattice":
        high = [[r.randint(-3, 3) * 1.0 for _ in AXES] for _ in range(7)]
    elif kind == "sizes":
        high = [[r.choice((-1, 1)) * r.random() * 2.0 ** r.randint(-60, 60) for _ in AXES] for _ in range(7)]
    else:
        n = [r.uniform(-1, 1) for _ in AXES]
        high = []
        for _ in range(7):
            x, y = r.uniform(-9, 9), r.uniform(-9, 9)
            high.append([x, y, (n[0] * x + n[1] * y) + r.randint(-1, 1) * 2.0**-52])
    low = [[x * r.choice((0, 0, 1, -1, 0.4)) * 2.0**-54 for x in row] for row in high]
    return np.array(high), np.array(low)


def sign(x):
    return (x > 0) - (x < 0)


@pytest.mark.share(3)
@pytest.mark.parametrize("kind", ["lattice", "sizes", "plane"])
@pytest.mark.parametrize("parts", [1, 2])
def test_signs_are_those_of_fractions(kind, parts):
    r = Random(7)
    for _ in range(300):
        high, low = points_of(r, kind)
        low *= parts - 1
        assert are_in_range(np.stack([high, low]))
        exact = [[F(x) + F(y) for x, y in zip(*rows, strict=True)] for rows in zip(high, low, strict=True)]
        ends = [r.randrange(7) for _ in range(6)]
        x, y, z = ([exact[p][k] - exact[q][k] for k in AXES] for p, q in zip(ends[::2], ends[1::2], strict=True))
        normal = [y[(k + 1) % 3] * z[(k + 2) % 3] - y[(k + 2) % 3] * z[(k + 1) % 3] for k in AXES]
        det = sum(a * b for a, b in zip(x, normal, strict=True))
        err = float(np.abs(low).max())
        told = det_sign(high, low, err, work_room(True), *ends)
        assert told == sign(det)
        assert det_sign(high, low[:0], err, work_room(False), *ends) in (told, UNSURE)
        for k in AXES:
            assert cross_sign(high, low, err, work_room(True), k, *ends[2:]) == sign(normal[k])
            assert cross_sign(high, low[:0], err, work_room(False), k, *ends[2:]) in (sign(normal[k]), UNSURE)
            assert order(high, low, err, work_room(True), k, *ends[:2]) == sign(x[k])


def test_doubts_are_said():
    high = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, 1e-12]])
    ends = 1, 0, 2, 0, 3, 0
    assert det_sign(high, high[:0], 0.0, work_room(False), *ends) == 1
    assert det_sign(high, high[:0], 1e-11, work_room(False), *ends) == UNSURE


def test_the_range():
    assert are_in_range(np.array([0.0, -1e60, 1e-75]))
    assert not are_in_range(np.array([1e-80])) and not are_in_range(np.array([1e61]))
