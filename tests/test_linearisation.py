"""The linear conditions of contact against the pair tests, over floats and exactly."""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq

from amount import THOROUGH
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements import line_line, line_line_rotation
from firstcontact.search.levels.linearisation import (
    EdgeSet,
    Translated,
    Turned,
    count_exactly,
    rotation_conjunctions,
    rotation_features,
    translation_conjunctions,
)
from unit.inputs import FAMILIES, exact, points

V = (fmpq(1, 2), fmpq(-1, 4), fmpq(2))
MOTIONS = {
    "translation": Translated(V, fmpq(1)),
    "translation, long": Translated(V, fmpq(50)),
    "turn": Turned(fmpq(3, 8)),
    "turn by nearly a half": Turned(fmpq(9)),
}
# Queries and the edges that each is put to: a million pairs a motion when thorough.
QUERIES, EDGES = (500, 2000) if THOROUGH else (8, 300)


def counted_by_filters(motion, edge, ends) -> list[int]:
    """Contacts by the float pair tests; -1 where they are unsure."""
    found = []
    a, b = edge
    if isinstance(motion, Turned):
        last = 2 * np.arctan(float(motion.tangent.p) / float(motion.tangent.q))
    for c, d in ends.tolist():
        if isinstance(motion, Translated):
            v = [float(x.p) / float(x.q) for x in motion.v]
            verdict, *_ = line_line.translation_filter(
                *a, *b, *c, *d, *v, 0.0, float(motion.last.p) / float(motion.last.q), 0.0, 0.0
            )
            found.append(-1 if verdict == UNSURE else int(verdict == CERTAIN))
            continue
        answer = line_line_rotation.rotation_filter(*a, *b, *c, *d, 0.0, 0.0)
        count = 0
        for verdict, lo, hi in (answer[:3], answer[3:]):
            if verdict == NONE or lo > last + 1e-14:
                continue
            count = -1 if verdict == UNSURE or hi > last - 1e-14 or count < 0 else count + 1
        found.append(count)
    return found


@pytest.mark.parametrize("name", MOTIONS)
def test_many_random_pairs(name):
    motion, rng = MOTIONS[name], np.random.default_rng(7)
    ends = rng.normal(size=(EDGES, 2, 3))
    resting, met, unsure = EdgeSet(ends, motion), 0, 0
    for edge in rng.normal(size=(QUERIES, 2, 3)).tolist():
        counts, filtered = resting.counts(*edge), np.array(counted_by_filters(motion, edge, ends))
        sure = filtered >= 0
        assert np.array_equal(counts[sure], filtered[sure]), (edge, ends[sure & (counts != filtered)])
        met, unsure = met + int((counts > 0).sum()), unsure + int((~sure).sum())
        assert np.array_equal(resting.hit(*edge), np.flatnonzero(counts))
        assert resting.is_free(*edge) == (not counts.any())
    assert met > 0.02 * QUERIES * EDGES and unsure < 0.001 * QUERIES * EDGES


@pytest.mark.share(8)
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("family", FAMILIES)
def test_degenerate_pairs_exactly(family, name):
    """Through floats and exactly, against the exact pair tests: coplanar, parallel, touching, across the axis."""
    motion, rng = MOTIONS[name], np.random.default_rng(8)
    n = 2000 if THOROUGH else 20
    met = 0
    for edges in points(family, rng, n, 4).reshape(n, 2, 2, 3).tolist():
        a, b, c, d = (exact(p) for edge in edges for p in edge)
        truth = motion.contacts(*motion.oriented(a, b), *motion.oriented(c, d))
        assert count_exactly(motion, a, b, c, d) == truth, edges
        assert EdgeSet(np.array(edges[1:]), motion).counts(*edges[0]).tolist() == [truth], edges
        met += truth > 0
    assert met or name in ("turn", "translation") and not THOROUGH  # short motions of few pairs may miss all


def test_how_many_conjuncts():
    a, b = exact([0.0, 1.0, 2.0]), exact([1.0, 0.0, 3.0])
    shifted, turned = translation_conjunctions(a, b, V, 1), rotation_conjunctions(a, b, fmpq(1, 2))
    assert [len(x) for x in shifted] == [7, 7]
    assert len(turned) == 72 and max(map(len, turned)) <= 13


def test_two_rods_that_meet_once():
    """By hand: the x axis, one above it, rises past the y axis: the forms say when."""
    a, b = exact([-1.0, 0.0, 0.0]), exact([1.0, 0.0, 0.0])
    c, d = exact([0.0, -1.0, 3.0]), exact([0.0, 1.0, 3.0])
    up = tuple(map(fmpq, (0, 0, 1)))
    for last, met in ((2, 0), (3, 1), (4, 1)):
        motion = Translated(up, fmpq(last))
        assert count_exactly(motion, a, b, c, d) == met
    way = translation_conjunctions(a, b, up, fmpq(4))[0]
    forms = [x.form.of(Translated.features(c, d)) for x in way]
    assert [abs(x) for x in forms[:3]] == [4, 12, 4]  # D = 2 * 2, u0 = 3 D, u0 - 4 D


def test_edges_that_share_one_height():
    """At z = 0 only: radii 8^(1/2) and 0, neither growing; then radii that agree a quarter turn apart."""
    level = [[-2.0, -2.0, -1.0], [-2.0, -2.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 1.0, 2.0]]
    quarter = [[-1.0, 0.0, 0.0], [-1.0, 0.0, 2.0], [-2.0, 1.0, -1.0], [0.0, -1.0, 0.0]]
    for ends, tangent, met in ((level, 9, 0), (quarter, fmpq(3, 8), 0), (quarter, 9, 1)):
        motion = Turned(fmpq(tangent))
        assert count_exactly(motion, *map(exact, ends)) == met
        assert EdgeSet(np.array([ends[2:]]), motion).counts(*ends[:2]).tolist() == [met]


def test_features_of_a_line_on_a_hyperboloid():
    """x = (1, s, s): squared radius 1 + z^2."""
    w2, w1, w0, ff = rotation_features(exact([1.0, -1.0, -1.0]), exact([1.0, 1.0, 1.0]))["squares"]
    assert (w2 / ff, w1 / ff, w0 / ff) == (1, 0, 1)
