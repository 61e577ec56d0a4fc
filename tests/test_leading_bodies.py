"""Of several pairs at once the lowest one of the body that leads: the same whichever way round bodies are given."""

from fractions import Fraction

import pytest

import firstcontact as fc
from firstcontact import Status, Translation
from firstcontact.contact.leading import leads


@pytest.mark.share(4)
@pytest.mark.parametrize("make", [fc.box, lambda size: fc.box(size) - fc.cylinder("1/4", 9), fc.examples.box])
@pytest.mark.parametrize("shift", [(0, 0, 0), (1, 0, 0), (1, "1/2", 0)])
def test_elements_are_the_same_the_other_way_round(make, shift):
    """Corner on corner, corner on edge, corner on face: the lowest pair of the one that moves."""
    start = [Fraction(x) for x in shift]
    moving = make((2, 2, 2)).translated(start).named("B").moving(Translation((4, 4, 4)))
    rests = make((2, 2, 2)).translated((6, 6, 6)).named("A")
    there, back = fc.first_contact(moving, rests), fc.first_contact(rests, moving)
    assert there.status is Status.CONTACT and (there.element_a, there.element_b) == (back.element_b, back.element_a)
    assert [(x.element_a, x.element_b) for x in there.others] == [(x.element_b, x.element_a) for x in back.others]


HYPAR = fc.RuledSurface("(2*u - 1, -1, 1 - 2*u)", "(2*u - 1, 1, 2*u - 1)").named("hypar")
SQUARE = fc.Polyhedron([(0, 0, -1), (0, -3, -1), (-3, -3, -1), (-3, 0, -1)], [[0, 1, 2], [0, 2, 3]]).named("square")
PLATE = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1)).named("plate")
BOX = fc.box((1, 1, 1)).translated((0, 0, "-3/2")).named("box")
UP, DOWN = Translation((0, 0, 2)), Translation((0, 0, -2))
KINDS = {"vertex": 0, "edge": 1, "directrix": 1, "end_ruling": 2, "face": 3}


@pytest.mark.parametrize("moving, rests", [
    (SQUARE.moving(UP), HYPAR), (HYPAR.moving(DOWN), SQUARE), (BOX.moving(UP), PLATE), (PLATE.moving(DOWN), BOX),
    (fc.examples.box((1, 1, 1)).translated((0, 0, "-3/2")).moving(UP), PLATE),
    (HYPAR.translated((0, 0, 2)).moving(DOWN), PLATE),
])  # fmt: skip
def test_pairs_of_ruled_surfaces_are_the_same_the_other_way_round(moving, rests):
    """Found outside: of a square on a saddle one order told four pairs at one point, the other three at another."""
    there, back = fc.first_contact(moving, rests), fc.first_contact(rests, moving)
    pairs = [(there.element_a, there.element_b), *((x.element_a, x.element_b) for x in there.others)]
    assert pairs == [(back.element_b, back.element_a), *((x.element_b, x.element_a) for x in back.others)]
    assert there.multiplicity == back.multiplicity == len(pairs)
    assert there.point == pytest.approx(back.point)
    assert all(hit.time_interval[0] <= 0.5 <= hit.time_interval[1] for hit in (there, back))
    keys = [(KINDS[x.kind], x.index, KINDS[y.kind], y.index) for x, y in pairs]
    assert keys == sorted(keys)


@pytest.mark.parametrize("other", [
    fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u <= 1/2"]),
    fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, "1/2")),
    fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), s=(0, 2)),
])  # fmt: skip
def test_pieces_of_one_surface_do_not_both_lead(other):
    own = PLATE.named(None)
    assert leads(own, other) != leads(other, own)
    assert leads(own.moving(UP), other.moving(UP)) != leads(other.moving(UP), own.moving(UP))


CORNER = BOX.translated((1, 1, 0))


@pytest.mark.parametrize("moving, rests", [(CORNER.moving(UP), PLATE), (PLATE.moving(DOWN), CORNER)])
def test_pairs_of_a_solid_and_a_piece_are_led_by_the_one_that_moves(moving, rests):
    """Exact arithmetic takes the piece first, whichever moves."""
    there, back = fc.first_contact(moving, rests, exact=True), fc.first_contact(rests, moving, exact=True)
    pairs = [(there.element_a, there.element_b), *((x.element_a, x.element_b) for x in there.others)]
    assert pairs == [(back.element_b, back.element_a), *((x.element_b, x.element_a) for x in back.others)]
    keys = [(KINDS[x.kind], x.index, KINDS[y.kind], y.index) for x, y in pairs]
    assert len(keys) > 2 and keys == sorted(keys)
