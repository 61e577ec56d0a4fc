"""Pairs told by one plane to meet at one time, beside the time of each pair by itself."""

from fractions import Fraction as F
from random import Random

import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.contact.polyhedra import earliest
from firstcontact.contact.polyhedra.problems import shared_plane
from firstcontact.contact.polyhedra.problems.problem import problem_of
from firstcontact.motion.relative.pieces import pieces
from firstcontact.pairs.elements.coplanar import translation_equation
from firstcontact.search.trees.elements import EDGE, FACE, VERTEX
from firstcontact.search.trees.state import EDGE_EDGE, FACE_VERTEX, VERTEX_FACE

N = 4
TURN = {"axis": (1, 2, 2), "degrees": 37}
SHIFT = (F(1, 3), F(-2, 7), 5)


def field(random, height, dent, shift=0, exact=False):
    """A square net, of whose vertices one in six is off its plane."""
    places = [
        (i + shift, j - shift, height + dent * (random.random() < 1 / 6)) for i in range(N + 1) for j in range(N + 1)
    ]
    corners = [(N + 1) * i + j for i in range(N) for j in range(N)]
    faces = [x for k in corners for x in ((k, k + N + 1, k + N + 2), (k, k + N + 2, k + 1))]
    return fc.Polyhedron([[F(x) for x in p] if exact else list(map(float, p)) for p in places], faces)


def question(seed, exact=False):
    """Two such nets, turned and shifted alike; the plane of one comes to that of the other at time 1/2."""
    random = Random(seed)
    a, b = field(random, 1.0, 0.25), field(random, 0.0, -0.25, F(1, 3) if exact else 0.375, exact)
    down = fc.Polyhedron([(0, 0, -2)], [])
    if seed % 2:
        a, b, down = a.rotated(**TURN).translated(SHIFT), b.rotated(**TURN).translated(SHIFT), down.rotated(**TURN)
    return a.moving(fc.Translation([F(int(x.p), int(x.q)) for x in down.exact_vertex(0)])), b


@pytest.mark.parametrize("seed", range(4))
def test_pairs_in_the_plane_meet_at_its_time(seed):
    """The truth: the time at which each pair meets by the exact pair tests, where it meets once."""
    a, b = question(seed)
    (piece,) = pieces(a, b, fmpq(0), fmpq(1))
    problem = problem_of(a, b, piece)
    x, y = problem.a, problem.b
    pairs = [
        (int(kind), (of_x, i), (of_y, j))
        for kind, of_x, count_x, of_y, count_y in (
            (VERTEX_FACE, VERTEX, len(x.vertices), FACE, len(y.triangles)),
            (EDGE_EDGE, EDGE, len(x.segments), EDGE, len(y.segments)),
            (FACE_VERTEX, FACE, len(x.triangles), VERTEX, len(y.vertices)),
        )
        for i in range(count_x)
        for j in range(count_y)
    ]
    times = {pair: at.value for pair in pairs if (at := problem.contact(*pair[1:])) is not None}
    first = min(times.values())
    assert first == fmpq(1, 2)
    met = [pair for pair, time in times.items() if time == first]
    told = shared_plane.in_its_plane(x, y, problem.v, met[0], first, list(times))
    assert all(times[pair] == first or speed(problem, pair) == 0 for pair in told)
    assert sum(times[pair] == first for pair in told) > 20
    assert len(times) - len(told) > 10


def speed(problem, pair):
    _, p, q, v = problem._ints.of(*pair[1:])
    return translation_equation(p, q, v)[1]


@pytest.mark.parametrize("exact", [False, True], ids=["doubles", "fractions"])
@pytest.mark.parametrize("seed", range(4))
def test_answers_are_those_without_it(seed, exact, monkeypatch):
    calls = []
    inner = shared_plane.in_its_plane
    monkeypatch.setattr(
        "firstcontact.contact.polyhedra.problems.translation_problem.in_its_plane",
        lambda *given: calls.append(inner(*given)) or calls[-1],
    )
    with_it = answer(*question(seed, exact))
    assert any(calls) is not exact
    monkeypatch.setattr(earliest, "SEVERAL", 10**6)
    assert answer(*question(seed, exact)) == with_it


def answer(a, b):
    hit = fc.first_contact(a, b, exact=True)
    return hit.time_exact, hit.element_a, hit.element_b, hit.others, hit.multiplicity, hit.stats.exact_evaluations
