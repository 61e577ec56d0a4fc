"""Budgets and progress of exact searches: what is proved when the work ends early."""

import pytest

import firstcontact as fc
from firstcontact.body.solid import primitives
from firstcontact.contact.models.algorithm import CandidateSearch
from firstcontact.contact.models.at_rest import _solid

# Both steps pass over the hole of the plate without touching it, in turn; the second ends in contact.
PLATE = primitives.box((60, 60, 10)) - primitives.cylinder(8, 20)
PIN = primitives.cylinder(7, 20).translated((3, 0, 30))
DOWN = fc.Sequence([fc.Translation((0, 0, -5)), fc.Translation((0, 0, -35))])


def test_a_budget_ends_in_undecided_with_the_steps_before_it_proved():
    pin = PIN.moving(DOWN)
    whole = fc.first_contact(pin, PLATE, exact=True)
    assert whole.status is fc.Status.CONTACT
    seen = []
    fc.first_contact(pin, PLATE, exact=True, progress=lambda until, work: seen.append((until, work)))
    assert [work for _, work in seen] == list(range(1, len(seen) + 1))
    assert {until for until, _ in seen} == {0.0, 0.5}
    for budget in (0, 1, len(seen) - 1):
        cut = fc.first_contact(pin, PLATE, exact=True, budget=budget)
        assert (cut.status, cut.reason) == (fc.Status.UNDECIDED, "budget")
        assert cut.free_until == (seen[budget][0] if budget else 0.0) <= whole.time
    assert fc.first_contact(pin, PLATE, exact=True, budget=len(seen)).time == whole.time


def test_intervals_stop_at_a_budget_too():
    pin = PIN.moving(DOWN)
    whole = fc.contact_intervals(pin, PLATE)
    cut = fc.contact_intervals(pin, PLATE, budget=3)
    assert (cut.status, cut.reason, cut.free_until, len(cut)) == (fc.Status.UNDECIDED, "budget", 0.0, 0)
    assert fc.contact_intervals(pin, PLATE, budget=10_000)[0].start == whole[0].start


def test_an_exact_search_can_be_interrupted():
    def stop(until, work):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fc.first_contact(PIN.moving(DOWN), PLATE, exact=True, progress=stop)


def test_a_search_that_missed_an_event_is_not_called_free(monkeypatch):
    """Without any contact found, models that overlap at the end leave the answer open."""
    monkeypatch.setattr(CandidateSearch, "first", lambda self: [])
    monkeypatch.setattr(CandidateSearch, "stop", lambda self: None)
    blind = fc.first_contact(PIN.moving(DOWN), PLATE, exact=True)
    assert (blind.status, blind.reason, blind.free_until) == (fc.Status.UNDECIDED, "precision", 0.0)


def test_only_an_empty_combination_counts_as_none():
    """Any other bad input is an error, not "no overlap"."""
    cube = primitives.box((2, 2, 2))
    assert _solid(lambda: cube & cube.translated((1, 0, 0))) is not None
    assert _solid(lambda: cube & cube.translated((3, 0, 0))) is None
    with pytest.raises(fc.InputError, match="give a number below"):
        _solid(lambda: cube & cube.translated((2**151, 0, 0)))
