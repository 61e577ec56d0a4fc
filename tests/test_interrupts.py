"""Compiled searches come back in slices, so that they can be interrupted; budgets hold in curved paths."""

from __future__ import annotations

from typing import Any

import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.solid import primitives
from firstcontact.contact.ruled.certified import pieces_of
from firstcontact.search.events import events
from firstcontact.search.rulings import ruled_events
from firstcontact.work import Query

SADDLE = fc.RuledSurface("(u, 0, u**2/2)", "(u, 1, u**3-u)")
WING = fc.RuledSurface("(u, u**2, 0)", "(u**2, 1, u)").translated((0, 0, 3))
LEAF = fc.RuledSurface("(u**4-u, u**3, u**2)", "(u**3, 1+u**4, u)")
PLATE = primitives.box((60, 60, 10)) - primitives.cylinder(8, 20)
PIN = primitives.cylinder(7, 20).translated((0, 0, 30))
RING = primitives.sphere(1) - primitives.cylinder("1/2", 3)


def turning(vector: tuple[float, ...]) -> Any:
    return fc.RationalMotion.between((0, 0, 0), vector, quat_wxyz=((1, 0, 0, 0), (1, 0, 0, 1)))


SCENES = {
    "ruled pieces": (SADDLE.moving(turning((0, 0, 9))), WING),
    "models": (PIN.moving(turning((0, 0, -30))), PLATE),
    "models that land": (PIN.moving(turning((3, 0, -30))), PLATE),
    "surface and solid": (RING.moving(turning((0, 0, 9))), LEAF.translated((0, 0, 4))),
    "surface in a solid": (primitives.sphere(1).moving(turning((0, 0, 9))), LEAF),
    "mesh in a hole": (
        fc.examples.noisy_sphere(200).translated((0, 0, 6)).moving(fc.Translation((0, 0, -12))),
        primitives.cylinder(3, 1) - primitives.cylinder(1, 3),
    ),
}
ASKED = [
    (verb, name)
    for verb in (fc.first_contact, fc.contact_intervals)
    for name in SCENES
    if (verb, name) != (fc.contact_intervals, "mesh in a hole")  # takes long
]


def told(answer: Any) -> tuple[Any, ...]:
    """All of an answer but how long it took."""
    ways = [(x.way, x.told) for x in answer.stats.ways]
    counts = answer.stats.node_visits, answer.stats.pair_tests
    if isinstance(answer, fc.FirstContact):
        return answer.status, answer.reason, answer.time_interval, answer.free_until, counts, ways
    return answer.status, answer.reason, [(x.start, x.end) for x in answer], answer.free_until, counts, ways


@pytest.mark.share(6)
@pytest.mark.parametrize(("verb", "name"), ASKED)
def test_slices_change_no_answer(name, verb, monkeypatch):
    whole = told(verb(*SCENES[name], method="certified"))
    for module in (ruled_events, events):
        monkeypatch.setattr(module, "SLICE", 7)
    assert told(verb(*SCENES[name], method="certified")) == whole


@pytest.mark.share(2)
@pytest.mark.parametrize("module", [ruled_events, events])
def test_no_call_of_a_kernel_outlasts_its_slice(module, monkeypatch):
    """However many boxes may be looked at: between two calls a signal is honoured."""
    calls: list[int] = []
    kernel, at = module.search, module.VISITS
    place = -3 if module is ruled_events else -1

    def counted(*arguments: Any) -> int:
        before = int(arguments[place][at])
        outcome = int(kernel(*arguments))
        calls.append(int(arguments[place][at]) - before)
        return outcome

    monkeypatch.setattr(module, "search", counted)
    monkeypatch.setattr(module, "SLICE", 50)
    name = "ruled pieces" if module is ruled_events else "surface and solid"
    answer = fc.contact_intervals(*SCENES[name], method="certified")
    assert answer.status is fc.Status.CONTACT
    assert max(calls) <= 51 and sum(calls) > 200


def test_an_interrupt_between_slices_ends_the_search(monkeypatch):
    kernel, calls = ruled_events.search, []

    def interrupted(*arguments: Any) -> int:
        calls.append(arguments)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return int(kernel(*arguments))

    monkeypatch.setattr(ruled_events, "search", interrupted)
    monkeypatch.setattr(ruled_events, "SLICE", 5)
    with pytest.raises(KeyboardInterrupt):
        fc.first_contact(*SCENES["ruled pieces"], method="certified")


def test_a_search_goes_on_where_its_slice_ended(monkeypatch):
    """The very same boxes are found, in the same order."""
    pieces = pieces_of(Query(*SCENES["ruled pieces"], fmpq(0), fmpq(1)))
    assert pieces is not None
    found = []
    for size in (10**9, 1, 13):
        monkeypatch.setattr(ruled_events, "SLICE", size)
        search = ruled_events.RulingSearch(pieces.p, pieces.q)
        outcome = search.run(0.0, 1.0, ruled_events.ALL_EVENTS, 1e-9, 3000)
        found.append((outcome, search.visits, search.limit.tolist(), search.found[: search.count].tolist()))
    assert found[0] == found[1] == found[2] and found[0][1] > 150


@pytest.mark.share(8)
@pytest.mark.parametrize(("verb", "name"), ASKED)
@pytest.mark.parametrize("budget", [0, 20, 200])
def test_budgets_hold_within_a_fifth(name, budget, verb):
    """But for the box that tells that no more may be looked at.  Pairs that boxes are tested for count, too."""
    cut = verb(*SCENES[name], method="certified", budget=budget)
    assert cut.stats.node_visits + cut.stats.pair_tests <= 1.2 * budget + 1
    whole = fc.first_contact(*SCENES[name], method="certified")
    if cut.status is fc.Status.UNDECIDED:
        assert cut.reason == "budget"
        is_listed = isinstance(cut, fc.ContactIntervals) and len(cut) > 0  # then all is known before free_until
        proved = cut[0].start_interval[0] if is_listed else cut.free_until
        assert proved <= (whole.free_until if whole.time_interval is None else whole.time_interval[1])
