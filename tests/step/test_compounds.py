"""Bodies of several pieces: what they meet is what one of the pieces meets."""

import pickle

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.compound.compound import Compound, CompoundPiece


class Walls:
    """Names for boxes: faces but for those that look along x."""

    def of(self, kind, index, body):
        return None if kind == "face" and index in (0, 1) else (kind, index, f"#{index}")


def boxes(*places, name="row", **known):
    return Compound([CompoundPiece(fc.box((1, 1, 1)).translated(p), Walls(), f"box{k}") for k, p in enumerate(places)],
                    name=name, **known)  # fmt: skip


@pytest.mark.thorough
def test_the_first_contact_is_the_earliest_of_the_pieces():
    rng = np.random.default_rng(4)
    for _ in range(2):
        places = rng.uniform(-6, 6, (5, 3)) + (9, 0, 0)
        others = rng.uniform(-6, 6, (5, 3)) - (9, 0, 0)
        motion = fc.Translation(rng.uniform(-2, 2, 3) - (22, 0, 0))
        hit = fc.first_contact(boxes(*places).moving(motion), boxes(*others, name="wall"))
        each = [
            fc.first_contact(fc.box((1, 1, 1)).translated(p).moving(motion), fc.box((1, 1, 1)).translated(q))
            for p in places for q in others
        ]  # fmt: skip
        times = [x.time for x in each if x.time is not None]
        if not times:
            assert hit.status is fc.Status.FREE
            continue
        assert hit.status is fc.Status.CONTACT and abs(hit.time - min(times)) < 1e-11
        assert hit.time_interval[0] <= min(times) <= hit.time_interval[1] + 1e-12


def test_intervals_are_the_union_of_the_pieces():
    row = boxes((0, 0, 0), (1, 0, 0), (5, 0, 0))
    ball = fc.sphere("1/2").translated((-5, 0, 0))
    found = fc.contact_intervals(ball.moving(fc.Translation((15, 0, 0))), row)
    assert [(x.start, x.end) for x in found] == [(4 / 15, 7.0 / 15), (9 / 15, 11 / 15)]
    free = fc.contact_intervals(ball.moving(fc.Translation((0, 3, 0))), row)
    assert free.status is fc.Status.FREE


def test_walls_between_pieces_are_not_named():
    row = boxes((0, 0, 0), (1, 0, 0))
    hit = fc.first_contact(fc.sphere(1).translated((0.5, 0, 5)).moving(fc.Translation((0, 0, -5))), row)
    assert hit.time == pytest.approx(0.7, abs=1e-12)
    assert hit.element_b.label in ("box0 #5", "box1 #5") or hit.element_b.kind != "face"
    side = fc.first_contact(fc.sphere(1).translated((5, 0, 0)).moving(fc.Translation((-5, 0, 0))), row)
    assert side.element_b.index == -1 and side.element_b.label == "row"


@pytest.mark.parametrize(
    "place, kind", [((1.5, 1, 0), "touching"), ((1.2, 0.4, 0), "overlapping"), ((0.5, 0, 0), None)]
)
def test_how_they_lie_at_the_start(place, kind):
    small = fc.box(("1/2", "1/2", "1/2")) if kind is None else fc.box((1, 1, 1))
    hit = fc.first_contact(small.translated(place), boxes((0, 0, 0), (1, 0, 0)))
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == kind


def test_budgets_and_turns():
    row = boxes(*[(k, 0, 0) for k in range(4)])
    turning = row.moving(fc.Rotation((0, 0, 1), degrees=90))
    post = fc.cylinder("1/4", 2).translated((0, 2, 0))
    hit = fc.first_contact(turning, post)
    # the side y = 1/2 of the row turns to the post, whose middle is 2 away: sin(angle - 0) over the radius
    assert hit.time == pytest.approx(float(np.degrees(np.arccos(0.75 / 2)) / 90), abs=1e-11)
    spent = fc.first_contact(turning, post, budget=0)
    assert spent.status is fc.Status.UNDECIDED and spent.reason == "budget"


def test_compounds_are_values_that_are_placed_and_pickled():
    row = boxes((0, 0, 0), (2, 0, 0), deviation=0.5, unit="mm")
    turned = row.rotated((0, 0, 1), degrees=30)
    assert turned.deviation == 0.5 and row.transformed(np.diag([2, 2, 2, 1])).deviation == pytest.approx(1.0)
    again = pickle.loads(pickle.dumps(turned))
    assert again == turned and np.array_equal(again.bounds(), turned.bounds())
    with pytest.raises(fc.InputError, match="came from no file"):
        row.to_dict()
    with pytest.raises(fc.InputError, match="no pieces"):
        Compound([])
    with pytest.raises(fc.InputError, match="row: piece 0 is .*; compounds are what load_step"):
        Compound([fc.box((1, 1, 1))], name="row")


def test_pieces_within_others_are_never_free_of_new_contact():
    """Two small meshes that stay inside one of two large ones: nothing touches, all is shared."""

    class Own:
        def of(self, kind, index, body):
            return kind, index, ""

    def meshes(size, *places):
        return Compound([CompoundPiece(fc.examples.box(size).translated(p), Own()) for p in places])

    small, large = meshes((1, 1, 1), (-1, 0, 0), (1, 0, 0)), meshes((8, 8, 8), (0, 0, 0), (0, 0, 20))
    hit = fc.first_new_contact(small.moving(fc.Translation((0, 1, 0))), large)
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.allowed is None


@pytest.mark.parametrize("is_drawn_first", [False, True])
def test_what_pictures_have_of_a_body_is_made_once_and_goes_with_it(is_drawn_first):
    calls = []

    def shown():
        calls.append(1)
        return [CompoundPiece(fc.examples.box((2, 2, 2)), Walls())]

    row = Compound([CompoundPiece(fc.box((2, 2, 2)), Walls())], shown=shown)
    if is_drawn_first:
        assert row.shown[0].body.vertices.max() == 1
    moved = row.translated((5, 0, 0)).translated((1, 0, 0))
    assert pickle.loads(pickle.dumps(moved)).translated((1, 0, 0)).shown[0].body.vertices[:, 0].max() == 8
    assert moved.shown[0].body.vertices[:, 0].max() == 7 and row.shown[0].body.vertices[:, 0].max() == 1
    assert len(calls) == 1


@pytest.mark.thorough
@pytest.mark.parametrize("way", [(1, 0, 0), (0, 0, 1), (0, 0, -1)])
def test_a_compound_that_stands_on_a_mesh(way):
    """It slides along it or leaves it, without a new contact, or goes down into it."""
    plate = fc.examples.box((9, 9, 1)).translated((0, 0, "-1/2"))
    for a in (boxes((0, 0, 0.5), (1, 0, 0.5)), boxes((0, 0, 0.5), (3, 0, 0.5))):
        for x, y in ((a.moving(fc.Translation(way)), plate), (plate, a.moving(fc.Translation(way)))):
            found = fc.first_new_contact(x, y)
            assert found.status in ((fc.Status.CONTACT, fc.Status.UNDECIDED, fc.Status.INITIAL_CONTACT) if way[2] < 0
                                    else (fc.Status.FREE, fc.Status.UNDECIDED))  # fmt: skip
