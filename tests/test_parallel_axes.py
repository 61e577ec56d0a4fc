"""Paraboloids with parallel axes touch at infinity at all times: a permanent double root hides what else they do.

z = h + p (x - d)^2 + q (y - e)^2 comes down on z = -(r x^2 + s y^2): the gap is least where the slopes agree, and is
h + p r / (p + r) d^2 + q s / (q + s) e^2 there.
"""

from __future__ import annotations

from fractions import Fraction as F

import pytest

import firstcontact as fc

CONTACT, INITIAL = fc.Status.CONTACT, fc.Status.INITIAL_CONTACT
TURN = [[F(2, 3), F(-1, 3), F(2, 3), 5], [F(2, 3), F(2, 3), F(-1, 3), -7], [F(-1, 3), F(2, 3), F(2, 3), F(1, 4)],
        [0, 0, 0, 1]]  # fmt: skip
UPSIDE_DOWN = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
BOWLS = [((F(1, 2), F(1, 2)), (F(1, 2), F(1, 2))), ((1, 2), (F(1, 2), F(1, 2))), ((1, 2), (2, 1)), ((3, 1), (1, 3))]
ASIDE = [(0, 0), (F(1, 8), 0), (F(1, 8), F(-1, 3))]


def gap(upper, lower, aside):
    """Beside the height between the tips."""
    (p, q), (r, s) = ([1 / F(c) ** 2 for c in pair] for pair in (upper, lower))
    d, e = aside
    return p * r / (p + r) * F(d) ** 2 + q * s / (q + s) * F(e) ** 2


def bodies(upper, lower, aside, height, way, turned):
    """Tips `height` apart at the start, the upper one shifted by `way` along z."""
    a = fc.paraboloid(upper, 3).translated((*aside, height))
    b = fc.paraboloid(lower, 3).transformed(UPSIDE_DOWN)
    shift = (0, 0, way)
    if turned:
        a, b = a.transformed(TURN), b.transformed(TURN)
        shift = tuple(row[2] * way for row in TURN[:3])
    return a.moving(fc.Translation(shift)), b


@pytest.mark.share(6)
@pytest.mark.parametrize("turned", [False, True], ids=["", "turned"])
@pytest.mark.parametrize("aside", ASIDE)
@pytest.mark.parametrize("upper, lower", BOWLS)
def test_bowls_that_land(upper, lower, aside, turned):
    a, b = bodies(upper, lower, aside, F(1), F(-2), turned)
    when = (1 + gap(upper, lower, aside)) / 2
    for pair in ((a, b), (b, a)):
        hit = fc.first_contact(*pair, exact=True)
        assert hit.status is CONTACT and hit.time_exact == when
        quick = fc.first_contact(*pair)
        assert quick.status is CONTACT and quick.time_interval[0] <= when <= quick.time_interval[1]
    (interval,) = fc.contact_intervals(a, b, exact=True)
    assert interval.start_exact == when and interval.end == 1


@pytest.mark.share(9)
@pytest.mark.parametrize("depth", [F(1, 4), F(1, 2**10), F(1, 2**50)], ids=["1/4", "2^-10", "2^-50"])
@pytest.mark.parametrize("upper, lower", BOWLS)
def test_bowls_that_part(upper, lower, depth):
    """They were told FREE, exactly too."""
    aside = (F(1, 8), 0)
    a, b = bodies(upper, lower, aside, -gap(upper, lower, aside) - depth, F(1, 2), False)
    for exact in (False, True):
        hit = fc.first_contact(a, b, exact=exact)
        assert hit.status is INITIAL and hit.initial == "overlapping"
    (interval,) = fc.contact_intervals(a, b, exact=True)
    assert interval.start == 0 and interval.end_exact == 2 * depth
