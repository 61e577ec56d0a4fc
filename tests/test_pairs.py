"""All element pairs that meet during a span, against the slow truth."""

from __future__ import annotations

import pytest

import firstcontact as fc
import generators as g
import naive
from agreement import polyhedron, question, reference_motion, small_scenes
from amount import amount
from firstcontact.contact.polyhedra.answers import element_pairs
from firstcontact.contact.polyhedra.earliest import all_pairs
from firstcontact.contact.polyhedra.problems.problem import problems_in_order
from firstcontact.motion.relative.pieces import pieces
from firstcontact.motion.span import common_span
from generators import Scene, lattice_scene
from vectors import Body


def with_edges(body: Body) -> Body:
    """The same body, its edges numbered as the reference numbers them."""
    return Body(
        body.v, [list(e) for e in naive.shape(body.v, body.e, body.f).edges] if body.f else body.e, body.f
    )


def found_pairs(pairs: fc.ContactPairs) -> set[tuple]:
    rows = [(p.element_a, p.element_b) for p in pairs]
    assert len(rows) == pairs.count
    return {(x.kind, x.index, y.kind, y.index) for x, y in rows}


@pytest.mark.share(4)
@pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
@pytest.mark.parametrize("first", [0, 100])
def test_lattice_scenes(first, rotating):
    most = 0
    for seed in range(first, first + amount(100, 2)):
        s = lattice_scene(seed, rotating)
        if not (s.a.f or s.a.e) or not (s.b.f or s.b.e):
            continue  # a point set has no edges to number
        scene = Scene(with_edges(s.a), with_edges(s.b), s.translation, s.rotation, s.until)
        a, b = scene.a, scene.b
        truth = naive.meeting_pairs(a.v, a.e, a.f, b.v, b.e, b.f, reference_motion(scene), scene.until)
        found = found_pairs(fc.contact_pairs(*question(scene)))
        assert found == truth, f"too many {found - truth}, missed {truth - found}: {scene}"
        most = max(most, len(truth))
    assert most > 20


@pytest.mark.share(2)
@pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
def test_reported_pairs_are_those_tested_one_by_one(rotating):
    """By the levels of the linearisation from the first pair on."""
    most = 0
    for scene in small_scenes(5000, amount(120), rotating):
        answers = []
        for engine in ("boxes", "composed"):
            a, b, span = question(scene)
            problems = problems_in_order(a, b, pieces(a, b, *common_span(a, b, span)), engine)
            found = [all_pairs(problem, with_start) for problem, with_start in problems]
            answers.append([(set(x.pairs), set(x.start)) for x in found])
        assert answers[0] == answers[1], scene
        most = max([most, *(len(pairs) for pairs, _ in answers[0])])
    assert most > 15


@pytest.mark.share(4)
@pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
@pytest.mark.parametrize("closed", [False, True], ids=["edges", "solids"])
def test_few_of_many_woven_pairs(closed, turning):
    """A short way through woven rods: few of n^2 pairs meet, and few more are tested."""
    scene = fc.examples.woven_rods(150 if closed else 400, closed=closed, turning=turning, seed=3)
    motion = fc.Rotation((0, 0, 1), radians=2.0**-9) if turning else fc.Translation((0, 0, 2.0**-9))
    moving = scene.a.moving(motion)
    pairs = fc.contact_pairs(moving, scene.b)
    assert pairs.stats.engine == "composed"
    parts = pieces(moving, scene.b, *common_span(moving, scene.b, None))
    ((problem, with_start),) = problems_in_order(moving, scene.b, parts)
    tested = all_pairs(problem, with_start)
    found = [p for p, _ in element_pairs(scene.a, scene.b, tested.pairs)]
    assert list(pairs) == found and len(found) > 20
    assert 5 * pairs.stats.pair_tests < tested.tests


def test_a_cube_meeting_a_cube():
    a, b = polyhedron(g.box()), polyhedron(g.box((1, 1, 1), (3, 0.25, 0.25)))
    pairs = fc.contact_pairs(a.moving(fc.Translation((2, 0, 0))), b)
    assert pairs.count == len(pairs) > 0
    assert not pairs.piercing
    assert fc.contact_pairs(a.moving(fc.Translation((1, 0, 0))), b).count == 0


def test_what_pierces_at_the_start_is_told_apart():
    needle = polyhedron(Body([[0.25, 0.25, -1], [0.25, 0.25, 1]], [[0, 1]], []))
    plate = polyhedron(Body([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [], [[0, 1, 2]]))
    pairs = fc.contact_pairs(needle.moving(fc.Translation((0, 0, 0.5))), plate)
    assert pairs.count == 0
    (pierced,) = pairs.piercing
    assert (pierced.element_a.kind, pierced.element_b.kind) == ("edge", "face")
