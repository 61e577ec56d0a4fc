"""Elements that shift: a plane between them, which doubles propose and balls bear out."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb, fmpq
from scipy.optimize import linprog

from firstcontact import Rotation
from firstcontact.pairs.elements.separated import apart_in_doubles, are_apart


def points(rows, scale=1):
    return [tuple(scale * fmpq(*float(x).as_integer_ratio()) for x in row) for row in rows]


FACET = points([(0, 0, 0), (1, 0, 0), (0, 1, 0)])


def test_a_vertex_in_the_plane_of_a_facet():
    """It passes beside the facet, or over a corner of it; times end at the last one."""
    (p,) = points([(-1, 2, 0)])
    assert are_apart([p], FACET, tuple(map(fmpq, (3, 0, 0))), fmpq(1))
    assert not are_apart([p], FACET, tuple(map(fmpq, (3, -6, 0))), fmpq(1))
    assert are_apart([p], FACET, tuple(map(fmpq, (3, -6, 0))), fmpq(1, 6))


def test_what_touches_is_not_apart():
    assert not are_apart(points([(0, 2, 0)]), FACET, tuple(map(fmpq, (0, -1, 0))), fmpq(1))
    assert are_apart(points([(0, 2, 0)]), FACET, tuple(map(fmpq, (0, -1, 0))), 1 - fmpq(1, 2**30))


def test_edges_in_one_line():
    edge, other = points([(0, 0, 0), (1, 0, 0)]), points([(1.5, 0, 0), (2, 0, 0)])
    assert not are_apart(edge, other, tuple(map(fmpq, (1, 0, 0))), fmpq(1))
    assert are_apart(edge, points([(1.5, 1, 0), (2, 1, 0)]), tuple(map(fmpq, (1, 0, 0))), fmpq(1))


def test_balls_have_to_bear_it_out():
    """Of a place that is known to a tenth alone nothing is told that holds for its middle only."""
    (p,) = points([(-1, 1.25, 0)])
    v, last = tuple(map(fmpq, (3, 0, 0))), fmpq(1)
    for radius, apart in ((0.1, True), (0.5, False)):
        ball = arb(p[0]), arb(p[1]) + arb(0, radius), arb(p[2])
        assert are_apart([ball], FACET, v, last) is apart


def corners(rng, kind, flat):
    """(3, 3) corners of a point, an edge or a triangle, in the plane z = 0 or anywhere, on a coarse grid."""
    found = rng.integers(-3, 4, (3, 3)).astype(float)
    found[:, 2] *= not flat
    return found[[0, 0, 0] if kind == 0 else [0, 1, 1] if kind == 1 else [0, 1, 2]]


def share_a_point(a, b):
    """Whether the hulls of two sets of points meet, by linear programming."""
    equal = np.vstack([np.hstack([a.T, -b.T]), np.repeat(np.eye(2), [len(a), len(b)], axis=1)])
    return linprog(np.zeros(len(a) + len(b)), A_eq=equal, b_eq=[0, 0, 0, 1, 1]).status == 0


@pytest.mark.share(2)
@pytest.mark.parametrize("flat", [False, True])
def test_what_doubles_tell_of_many_pairs(flat):
    """Never apart where they meet; in one plane all that are apart are told."""
    seed = 8 + flat
    print("seed", seed)
    rng = np.random.default_rng(seed)
    kinds = rng.permutation([(0, 2), (1, 1), (2, 0), (1, 2), (2, 1)] * 40)
    a, b = (np.array([corners(rng, kind, flat) for kind in side]) for side in kinds.T)
    b[::2] += [2, 1, 0]
    ranks = np.array([[np.linalg.matrix_rank(x[1:] - x[0]) for x in side] for side in (a, b)]).T
    is_proper = (ranks == kinds).all(axis=1)  # no triangle is an edge, no edge a point
    for shift in (np.zeros(3), np.array([1.0, -2.0, 0.0]), np.array([1.0, 1.0, 3.0 * (not flat)])):
        told = apart_in_doubles(a, b, shift, 1e-12)
        met = np.array([share_a_point(np.vstack([x, x + shift]), y) for x, y in zip(a, b, strict=True)])
        assert met.any() and told.any() and not (told & met).any()
        if flat and not shift.any():
            assert (told | met)[is_proper].all()
        turned = Rotation((1, 2, 3), radians=1)(1.0)[:3, :3]  # roundings everywhere
        assert not (apart_in_doubles(a @ turned.T, b @ turned.T, turned @ shift, 1e-13) & met).any()


@pytest.mark.parametrize("far", [0, 2**20])
def test_roundings_of_doubles_never_part_what_touches(far):
    """Corners of which no digit is lost: one of each comes upon one of the other, as the shift ends or before."""
    seed = 31
    print("seed", seed)
    rng = np.random.default_rng(seed)
    a, b = (far + rng.integers(-(2**24), 2**24, (4000, 3, 3)) / 2.0**24 for _ in range(2))
    shift = rng.integers(-(2**24), 2**24, 3) / 2.0**24
    part = rng.choice([0.25, 0.5, 1.0], 4000)
    b[:, 0] = a[:, 0] + part[:, None] * shift
    assert not apart_in_doubles(a, b, shift, 0.0).any()
