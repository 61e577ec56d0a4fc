"""Windows and timelines, from hand-made results."""

import math

from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Status
from firstcontact.view.pair import pairs_of
from view import scenes


def pair_of(*results):
    (pair,) = pairs_of(results)
    return pair


def first(status, **fields):
    a, b = scenes.falling_spike()
    return FirstContact(status, a=a, b=b, **fields)


def intervals(*ends, status=Status.CONTACT, **fields):
    a, b = scenes.falling_spike()
    found = tuple(ContactInterval(s, e, (s, s), (e, e)) for s, e in ends)
    return ContactIntervals(found, status, a=a, b=b, **fields)


def test_timeline_of_every_status():
    assert pair_of(first(Status.FREE, free_until=1.0)).timeline == [(0.0, 1.0, "free")]
    hit = first(Status.CONTACT, time=0.5, free_until=0.5)
    assert pair_of(hit).timeline == [(0.0, 0.5, "free"), (0.5, 1.0, "not asked")]
    start = first(Status.INITIAL_CONTACT, time=0.0, initial="touching")
    assert pair_of(start).timeline == [(0.0, 1.0, "not asked")]
    lost = first(Status.UNDECIDED, free_until=0.25, reason="budget")
    assert pair_of(lost).timeline == [(0.0, 0.25, "free"), (0.25, 1.0, "undecided")]


def test_timeline_of_intervals_covers_the_span():
    pair = pair_of(intervals((0.25, 0.5), (0.75, 0.75)))
    assert pair.timeline == [
        (0.0, 0.25, "free"),
        (0.25, 0.5, "contact"),
        (0.5, 0.75, "free"),
        (0.75, 0.75, "contact"),
        (0.75, 1.0, "free"),
    ]
    assert pair.contact_time == 0.25


def test_timeline_of_undecided_intervals_ends_where_the_proof_ends():
    pair = pair_of(intervals((0.0, 0.25), status=Status.UNDECIDED, free_until=0.5, reason="precision"))
    assert pair.timeline == [(0.0, 0.25, "contact"), (0.25, 0.5, "free"), (0.5, 1.0, "undecided")]


def test_window_of_an_endless_span_is_finite_and_holds_the_contact():
    pair = pair_of(first(Status.CONTACT, time=12.0, free_until=12.0, span=(0.0, math.inf)))
    assert pair.window == (0.0, 18.0)
    both = pair_of(first(Status.FREE, free_until=math.inf, span=(-math.inf, math.inf)))
    assert both.window == (-1.0, 1.0)
