"""Ends that are known to 1e-12 or less, told to the last digit by what is asked about these times alone."""

import math
from dataclasses import replace

import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.contact.polyhedra.first import _contact_intervals
from firstcontact.contact.polyhedra.sharpened import sharpened
from firstcontact.work import Query

MOVING = fc.examples.box((2, 1, 2)).translated((-4, "1/3", 0)).moving(fc.Translation((9, "1/7", 1)))
REST = fc.examples.box((2, 1, 4))
QUERY = Query(MOVING, REST, fmpq(0), fmpq(1))


def widened(found, by):
    """The same, known less closely, with times off by as much."""
    wide = [
        replace(
            x, start=x.start + by, end=x.end - by, start_interval=(x.start - 2 * by, x.start + by),
            end_interval=(x.end - by, x.end + 2 * by),
        )
        for x in found
    ]  # fmt: skip
    return replace(found, intervals=tuple(wide))


@pytest.mark.parametrize("by", [1e-12, 1e-9])
def test_ends_are_the_nearest_doubles_again(by):
    truth = _contact_intervals(QUERY)
    assert len(truth) == 1 and truth.status is fc.Status.CONTACT
    known = widened(truth, by)
    (x,), (y,) = sharpened(known, QUERY, _contact_intervals), truth
    assert (x.start, x.end) == (y.start, y.end) != (known[0].start, known[0].end)
    starts, ends = (x.start_interval, known[0].start_interval, y.start), (x.end_interval, known[0].end_interval, y.end)
    for close, wide, time in (starts, ends):
        assert wide[0] <= close[0] <= time <= close[1] <= wide[1]
        assert close[1] - close[0] <= 4 * math.ulp(1.0)


def test_what_is_not_told_stays():
    """Nothing open, nothing of other times, and no end where two contacts are near takes the place of what is known."""
    known = widened(_contact_intervals(QUERY), 1e-9)
    empty = replace(known, intervals=())
    elsewhere = replace(known, intervals=(replace(known[0], start_interval=(0.0, 0.1), end_interval=(0.9, 1.0)),))
    for told in (empty, elsewhere, replace(known, intervals=known.intervals * 2), replace(known, reason="precision")):
        assert sharpened(known, QUERY, lambda _, told=told: told) == known
