"""Bodies of several boxes under translations: when boxes meet is a window of fractions, and theirs is the union."""

from __future__ import annotations

import random
from fractions import Fraction as F

import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.compound.compound import Compound, CompoundPiece
from firstcontact.contact.compound.windows import STEPS, side_of, windows
from firstcontact.work import Query

SEED = 190


class Plain:
    """Elements of pieces are called as the pieces' own."""

    def of(self, kind, index, body):
        return kind, index, ""


def boxes(dice, shift):
    """Lower and upper corners of a few boxes of whole numbers, which may overlap or touch."""
    found = []
    for _ in range(dice.randint(1, 3)):
        lo = [dice.randint(-4, 4) + d for d in shift]
        found.append((lo, [x + dice.randint(1, 3) for x in lo]))
    return found


def body(corners, make):
    pieces = []
    for lo, hi in corners:
        middle = [F(x + y, 2) for x, y in zip(lo, hi, strict=True)]
        pieces.append(CompoundPiece(make([y - x for x, y in zip(lo, hi, strict=True)]).translated(middle), Plain()))
    return Compound(pieces)


def window(first, second, v):
    """The closed times in [0, 1] at which two boxes meet, the first moving by v; None where they never do."""
    begin, end = F(0), F(1)
    for (lo, hi), (other_lo, other_hi), speed in zip(zip(*first), zip(*second), v, strict=True):  # noqa: B905
        ahead, behind = other_lo - hi, other_hi - lo
        if speed == 0 and (ahead > 0 or behind < 0):
            return None
        if speed != 0:
            t0, t1 = sorted((F(ahead, speed), F(behind, speed)))
            begin, end = max(begin, t0), min(end, t1)
    return (begin, end) if begin <= end else None


def union(windows):
    merged = []
    for begin, end in sorted(windows):
        if merged and begin <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(merged[-1][1], end)
        else:
            merged.append((begin, end))
    return merged


@pytest.mark.share(12)
@pytest.mark.parametrize("seed", range(SEED, SEED + 60))
def test_times_of_contact_are_the_union_of_those_of_the_boxes(seed):
    dice = random.Random(seed)
    shift = [dice.randint(-12, 12) for _ in range(3)]
    first, second = boxes(dice, shift), boxes(dice, (0, 0, 0))
    v = [dice.randint(-3, 3) - dice.choice((1, 2)) * d for d in shift]
    makes = [dice.choice((fc.box, fc.examples.box)) for _ in range(2)]
    a, b = body(first, makes[0]).moving(fc.Translation(v)), body(second, makes[1])
    wanted = union(x for p in first for q in second if (x := window(p, q, v)) is not None)
    for x, y in ((a, b), (b, a)):
        hit = fc.first_contact(x, y)
        if not wanted:
            assert hit.status is fc.Status.FREE
        elif wanted[0][0] == 0:
            assert hit.status is fc.Status.INITIAL_CONTACT
        else:
            lo, hi = hit.time_interval
            assert hit.status is fc.Status.CONTACT and lo <= wanted[0][0] <= hi
    told = [(*x.start_interval, *x.end_interval) for x in fc.contact_intervals(a, b)]
    assert len(told) == len(wanted)
    for (lo, hi, end_lo, end_hi), (begin, end) in zip(told, wanted, strict=True):
        assert lo <= begin <= hi and end_lo <= end <= end_hi


@pytest.mark.share(4)
@pytest.mark.parametrize("seed", range(20))
def test_pieces_that_shift_are_asked_about_while_their_boxes_meet(seed):
    """Early ones first, with room on both sides, as far as the span goes."""
    dice = random.Random(SEED + seed)
    first, second, v = boxes(dice, (0, 0, 0)), boxes(dice, (5, 0, 1)), [dice.randint(-9, 9) for _ in range(3)]
    a, b = body(first, fc.box), body(second, fc.box)
    query = Query(a.moving(fc.Translation(v)), b, fmpq(0), fmpq(1))
    found = windows(side_of(query.a), side_of(query.b), query)
    asked = {(w.a, w.b): (F(int(w.first.p), int(w.first.q)), F(int(w.last.p), int(w.last.q))) for w in found}
    assert [w.first for w in found] == sorted(w.first for w in found)  # the first that is too late ends the search
    room = F(1, STEPS)
    for i, x in enumerate(first):
        for j, y in enumerate(second):
            true = window(x, y, v)
            if true is not None:
                begin, end = asked[i, j]
                assert begin <= max(true[0] - room, 0) and end >= min(true[1] + room, 1)
                assert begin >= true[0] - 4 * room and end <= true[1] + 4 * room
