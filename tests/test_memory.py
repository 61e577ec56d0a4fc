"""Tables that grow with a question end at a limit: with what is proved until then."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import work
from firstcontact.search.lifted.halving import larger, room_for
from firstcontact.search.trees import state
from firstcontact.search.trees.rounds import Finds


def plate(n: int) -> fc.Polyhedron:
    corners = [(x, y, 0) for x in range(n + 1) for y in range(n + 1)]
    squares = [x * (n + 1) + y for x in range(n) for y in range(n)]
    return fc.Polyhedron(corners, [t for q in squares for t in ((q, q + n + 1, q + n + 2), (q, q + n + 2, q + 1))])


PLATE = plate(20)
BELOW = PLATE.translated((0.1, 0.2, -1))
UP, AROUND = fc.Translation((0.2, 0.1, 2)), fc.Screw((0, 0, 1), degrees=20, advance=2)


@pytest.fixture
def little_memory(monkeypatch):
    monkeypatch.setattr(work, "MOST_BYTES", 2**16)
    monkeypatch.setattr(state._local, "state", None, raising=False)


def test_tables_do_not_grow_beyond_the_limit():
    keys = np.empty(work.MOST_BYTES // 24)  # what is not written takes no memory
    assert work.may_grow(keys) and not work.may_grow(keys, keys) and not work.may_grow(keys, by=4)


def test_a_first_contact_is_free_until_what_is_proved(little_memory):
    hit = fc.first_contact(BELOW.moving(UP), PLATE)
    assert (hit.status, hit.reason) == (fc.Status.UNDECIDED, "memory")
    assert 0.49 < hit.free_until <= 0.5


def test_intervals_name_no_budget(little_memory):
    told = fc.contact_intervals(BELOW.moving(AROUND), PLATE, budget=10**9)
    assert (told.status, told.reason, len(told), told.free_until) == (fc.Status.UNDECIDED, "memory", 0, 0.0)


def test_a_list_of_pairs_that_is_too_long_is_refused(little_memory):
    with pytest.raises(fc.UnsupportedPair, match="more than 2 GB; ask about a shorter span"):
        fc.contact_pairs(BELOW.moving(UP), PLATE)


def test_points_that_bodies_share_at_the_start_are_too_many_to_tell_how_they_do(little_memory):
    """INITIAL_CONTACT is proved; "touching" would want a look at every point."""
    tiles = [fc.examples.box((1, 1, 1)).translated((x, y, 0)) for x in range(8) for y in range(8)]
    corners = np.concatenate([tile.vertices for tile in tiles])
    floor = fc.Polyhedron(corners, [[8 * k + i for i in face] for k, t in enumerate(tiles) for face in t.triangles])
    hit = fc.first_contact(floor.translated((0, 0, 1)).moving(UP), floor)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, None)


@pytest.mark.parametrize("engine", ["lifted", "composed"])
def test_engines_that_cut_sets_end_with_what_is_proved(engine, little_memory):
    hit = fc.first_contact(BELOW.moving(UP), PLATE, engine=engine)
    assert (hit.status, hit.reason, hit.free_until) == (fc.Status.UNDECIDED, "memory", 0.0)


def test_what_workers_find_has_a_limit(little_memory):
    whole = state.WalkState()
    finds = Finds(whole)
    with pytest.raises(work.NoMemory):
        while True:
            finds.grow()
    finds.integers[state.CANDIDATES] = len(finds.times)
    with pytest.raises(work.NoMemory):
        while True:
            finds.hand_to(whole)
            finds.integers[state.CANDIDATES] = len(finds.times)
    assert len(whole.times) < 2**12


def test_lists_of_edges_have_a_limit(little_memory):
    with pytest.raises(work.NoMemory):
        larger(room_for(100, 100))


def test_a_curve_of_too_many_points_is_refused(monkeypatch):
    p, q = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)"), fc.RuledSurface("(u, 0, 1/2)", "(u, 1, u**2)")
    assert fc.intersection_curve(p, q, method="certified").branches
    monkeypatch.setattr(work, "MOST_BYTES", 2**20)
    with pytest.raises(fc.InputError, match="needs more than .* points; give a larger one"):
        fc.intersection_curve(p, q, tolerance=1e-12, method="certified")
