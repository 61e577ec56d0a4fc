"""Of several pairs at once the lowest one of the body that leads: the same whichever way round bodies are given."""

from fractions import Fraction

import pytest

import firstcontact as fc
from firstcontact import Status, Translation


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
