"""Contact along rulings and in flats that end on smooth rims alone, which are no edges: neighbours tell the event.

Of capsules and of bars with rounded sides that come down on bodies longer than themselves; truths are heights.
"""

from __future__ import annotations

from fractions import Fraction as F

import pytest

import firstcontact as fc

DOWN = fc.Translation((0, 0, -4))
ACROSS = {"axis": (0, 1, 0), "degrees": 90}


def capsule(radius, length):
    """Along z: no edge."""
    ends = [fc.sphere(radius).translated((0, 0, s * F(length) / 2)) for s in (-1, 1)]
    return fc.cylinder(radius, length) | ends[0] | ends[1]


def bar(length):
    """Along y, 1 high, flat for |x| <= 1 and rounded beside that."""
    bar = fc.box((2, 1, length))
    for x in (-1, 1):
        bar = bar | fc.cylinder(F(1, 2), length).translated((x, 0, 0))
    return bar.transformed([[1, 0, 0, 0], [0, 0, 1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


LYING = capsule(F(1, 2), 2).rotated(**ACROSS)  # along x
ROD = fc.cylinder(F(1, 2), 20).rotated(**ACROSS)
# a square beam along x, turned by 3/5, 4/5: its highest edge is y = -1/5, z = 7/5
BEAM = fc.box((20, 2, 2)).transformed([[1, 0, 0, 0], [0, F(3, 5), F(-4, 5), 0], [0, F(4, 5), F(3, 5), 0], [0, 0, 0, 1]])
SCENES = {  # a body where it lies on another one, that one, and the set that they share
    "capsule on a long edge": (LYING.translated((0, F(-1, 5), F(19, 10))), BEAM, "segment"),
    "capsule on a plate": (LYING.translated((0, 0, F(3, 2))), fc.box((20, 20, 2)), "segment"),
    "capsule across a bar": (LYING.translated((0, 0, 1)), bar(10), "segment"),
    "rod across a bar": (ROD.translated((0, 0, 1)), bar(10), "segment"),
    "bar across a bar": (bar(10).rotated((0, 0, 1), degrees=90).translated((0, 0, 1)), bar(10), "patch"),
    "capsule along a capsule": (LYING.translated((0, 0, 1)), LYING, "segment"),
    "capsule across a capsule": (LYING.rotated((0, 0, 1), degrees=90).translated((0, 0, 1)), LYING, "point"),
}


@pytest.mark.share(6)
@pytest.mark.parametrize("name", SCENES)
def test_the_landing_is_told_by_all_ways(name):
    a, b, shared = SCENES[name]
    moving = a.translated((0, 0, 1)).moving(DOWN)  # 1 above: lands at 1/4
    for pair in ((moving, b), (b, moving)):
        exact = fc.first_contact(*pair, exact=True)
        assert (exact.status, exact.time_exact, exact.contact_set) == (fc.Status.CONTACT, F(1, 4), shared)
        hit = fc.first_contact(*pair)
        assert hit.status is fc.Status.CONTACT
        assert hit.time_interval[0] <= 0.25 <= hit.time_interval[1]
        for way in ({}, {"exact": True}):
            assert fc.contact_intervals(*pair, **way).intervals[0].start == 0.25
