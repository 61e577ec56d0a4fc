"""Elements that shift: a plane between them, which doubles propose and balls bear out."""

from __future__ import annotations

from flint import arb, fmpq

from firstcontact.pairs.elements.separated import are_apart


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
