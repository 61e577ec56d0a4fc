"""What `contact.table` says of each pair of bodies, and with it the docs, is what the verbs do."""

from __future__ import annotations

import doctest
import runpy
from fractions import Fraction as F
from pathlib import Path

import pytest

import firstcontact as fc
from firstcontact.body.compound.compound import Compound, CompoundPiece
from firstcontact.contact import table
from firstcontact.contact.table import CERTIFIED, CONVEX, EXACT, NOT, PAIRS, VERBS, Kind

CORNER = fc.Polyhedron(
    [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))],
    [[5, 4, 3], [5, 3, 0], [0, 3, 2], [0, 2, 1], [9, 10, 11], [9, 11, 6], [6, 8, 9], [6, 7, 8],
     *(f for k in range(6) for j in [(k + 1) % 6] for f in ([k, j, j + 6], [k, j + 6, k + 6]))],
)  # fmt: skip
TILTED = [["2/3", "-1/3", "2/3", 0], ["2/3", "2/3", "-1/3", 0], ["-1/3", "2/3", "2/3", 0], [0, 0, 0, 1]]


class Plain:
    """Elements of a piece by their own names."""

    def of(self, kind, index, body):
        return kind, index, ""


BODIES = {
    Kind.MESH: CORNER.transformed(TILTED),
    Kind.MODEL: fc.cylinder(1, 2),
    Kind.RULED: fc.RuledSurface("(u, 0, 0)", "(u, 1, u)"),
    Kind.TORUS: fc.torus(1, F(1, 3)),
    Kind.PART: Compound([CompoundPiece(fc.cylinder(1, 2), Plain()), CompoundPiece(fc.box((1, 1, 1)), Plain())]),
}
ABOVE = (F(1, 5), F(1, 3), 5)
RATIONAL = fc.Translation((F(1, 7), F(1, 9), -8))
SCREW = fc.Screw((1, 0, -8), degrees=9, advance=7)
TWO_VERBS = VERBS[:2]
CASES = [pytest.param(x, verb, id="-".join((*(k.name for k in x), verb))) for x in PAIRS for verb in TWO_VERBS]


DOCS = Path(__file__).parents[1] / "docs"


def test_the_docs_print_the_table():
    assert table.matrix() in (DOCS / "motions.md").read_text()


def test_the_example_of_ways_in_the_docs():
    found = doctest.testfile(str(DOCS / "how-it-works.md"), module_relative=False)
    assert found.attempted > 0 and found.failed == 0


def test_the_picture_of_the_house_knows_all_rooms():
    drawn = runpy.run_path(str(DOCS / "draw.py"))
    rooms = {room for layer in drawn["layers"]() for room in layer}
    assert rooms == set(drawn["SAYS"]) == {room for floor in drawn["FLOORS"].values() for room in floor}


@pytest.mark.share(16)
@pytest.mark.parametrize(("kinds", "verb"), CASES)
def test_what_is_proved_of_a_pair(kinds, verb):
    a, b = (BODIES[k] for k in kinds)
    told, ask = PAIRS[kinds].proves[VERBS.index(verb)], getattr(fc, verb)
    above = a.translated(ABOVE)
    if told == CERTIFIED:
        with pytest.raises(fc.UnsupportedPair, match="drop exact=True"):
            ask(above.moving(RATIONAL), b, exact=True)
    else:
        hit = ask(above.moving(RATIONAL), b, exact=True)
        assert hit.status is fc.Status.CONTACT
        assert (hit.time_exact if verb == "first_contact" else hit.intervals[0].start_exact) is not None
    with pytest.raises(fc.UnsupportedPair):
        ask(above.moving(SCREW), b, exact=True)
    if told == CONVEX:
        hit = ask(above.moving(SCREW), b)
        assert (hit.status, hit.reason, len(hit)) == (fc.Status.UNDECIDED, "precision", 1)
        first = fc.first_contact(above.moving(SCREW), b).time_interval
        assert first[0] <= hit[0].start_interval[1] and hit[0].start_interval[0] <= first[1]
        above = fc.examples.box((2, 2, 2)).translated(ABOVE)
    hit = ask(above.moving(SCREW), b)
    assert hit.status is fc.Status.CONTACT
    assert hit.stats.ways[-1].told == "CONTACT" and sum(x.seconds for x in hit.stats.ways) <= hit.stats.seconds + 1


@pytest.mark.share(10)
@pytest.mark.parametrize(
    "kinds", [k for k in PAIRS if PAIRS[k].proves[0] != CERTIFIED], ids=lambda kinds: "-".join(k.name for k in kinds)
)
def test_exact_times_whatever_the_method(kinds):
    """exact=True is the stronger wish: "certified" beside it once left a surface and a solid without any way."""
    a, b = (BODIES[k] for k in kinds)
    for method in ("auto", "certified", "algebraic"):
        hit = fc.first_contact(a.translated(ABOVE).moving(RATIONAL), b, exact=True, method=method)
        assert hit.status is fc.Status.CONTACT and hit.time_exact is not None


@pytest.mark.parametrize("kinds", PAIRS, ids=lambda kinds: "-".join(k.name for k in kinds))
@pytest.mark.parametrize("verb", VERBS[2:])
def test_verbs_that_take_some_pairs_only(kinds, verb):
    a, b = (BODIES[k] for k in kinds)
    if PAIRS[kinds].proves[VERBS.index(verb)] == NOT:
        with pytest.raises(fc.UnsupportedPair, match=f"{verb} is for .* not for .*; "):
            getattr(fc, verb)(a, b)
    else:
        getattr(fc, verb)(a, b)


def test_a_way_that_passes_is_told():
    """Doubles leave a graze to exact arithmetic."""
    ball = fc.sphere(1)
    hit = fc.first_contact(ball.translated((2, 0, 5)).moving(fc.Translation((0, 0, -10))), ball)
    assert [x.way for x in hit.stats.ways] == ["in doubles", "soon exactly"]
    assert hit.stats.ways[0].told.startswith("passed") and hit.stats.ways[1].told == "CONTACT"
    assert hit.to_dict()["stats"]["ways"][1]["way"] == "soon exactly"
    assert EXACT == PAIRS[Kind.MODEL, Kind.MODEL].proves[0]


def test_no_budget_but_the_callers_is_named():
    """A bolt turns into a hole of its own size: doubles look at all the boxes they may, which nobody asked them to."""
    bolt, plate = fc.cylinder(1, 6).translated((0, 0, 6)), fc.box((8, 8, 2)) - fc.cylinder(1, 4)
    a, b = bolt.moving(fc.Screw((0, 0, 1), turns=3, advance=-9)), plate.moving(fc.Rotation((0, 0, 1), turns=F(1, 3)))
    for x, y in ((a, b), (b, a)):
        hit = fc.first_contact(x, y)
        assert hit.status is not fc.Status.FREE and hit.reason != "budget" and hit.free_until <= 2 / 9
    assert fc.contact_intervals(a, b).reason != "budget"
    assert fc.first_contact(a, b, budget=1).reason == "budget"
