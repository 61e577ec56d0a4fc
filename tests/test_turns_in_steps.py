"""Polyhedra that turn in several steps, in poses of which no rational numbers tell: as in one step, or as seen from
the other body."""

import itertools
from fractions import Fraction

import pytest

import firstcontact as fc
from firstcontact import Rotation, Sequence, Status, Translation

AXIS = (0, 1, 0)
WALL = fc.Polyhedron(
    [(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0), (-1, -1, -3), (0, -1, -3), (0, 1, -3), (-1, 1, -3)],
    [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]],
)


def sheet(top=2.0, side=-1.0):
    """A triangle with an edge on the z axis, which after half a turn lies on the wall's face x = 0."""
    return fc.Polyhedron([(0, 0, top), (0, 0, 1), (side, 0, 1)], [[0, 1, 2]])


def turn(turns):
    return Rotation(AXIS, turns=turns)


@pytest.mark.share(2)
@pytest.mark.parametrize("top", [1.5, 2.0])
@pytest.mark.parametrize("parts", [*itertools.permutations(["1/8", "1/12", "1/3"]), ("1/8", "3/8"), ("1/7", "5/7")])
def test_steps_about_one_axis_are_exact(top, parts):
    """It lands flat after half a turn in all."""
    ends = [Fraction(0), *itertools.accumulate(map(Fraction, parts))]
    k = next(k for k, end in enumerate(ends) if end >= Fraction(1, 2))
    due = k - 1 + (Fraction(1, 2) - ends[k - 1]) / Fraction(parts[k - 1])  # in steps
    moving = sheet(top).moving(Sequence([turn(x) for x in parts]))
    for pair in ((moving, WALL), (WALL, moving)):
        hit = fc.first_contact(*pair, exact=True)
        assert hit.status is Status.CONTACT and hit.time_exact == due / len(parts)
        (only,) = fc.contact_intervals(*pair)
        assert only.start == hit.time


@pytest.mark.parametrize(("there", "back"), [("1/8", "-3/8"), ("5/8", "-1/4"), ("-1/8", "-1")])
def test_a_turn_back(there, back):
    """As one rotation from where it stands after the first step: the second one lies in it as a window."""
    both = sheet().moving(Sequence([turn(there), turn(back)]))
    begun, share = Fraction(there), Fraction(back)
    first = fc.first_contact(sheet().moving(turn(there)), WALL)
    found = fc.first_contact(both, WALL)
    if first.status is Status.CONTACT:
        assert found.time == pytest.approx(first.time / 2, abs=1e-15)
        return
    whole = fc.first_contact(sheet().moving(turn(-1)), WALL, exact=True)  # back from 0: angles 0 to -1 turn
    due = -whole.time_exact  # the angle, in turns, at which it lands
    passed = (due - begun) / share
    expected = Status.CONTACT if passed <= 1 else Status.FREE
    assert found.status is expected
    if expected is Status.CONTACT:
        assert found.time == pytest.approx(float((1 + passed) / 2), abs=1e-15)


STEPS = {
    "turns": [("1/8", "3/4"), ("3/2", "-9/4"), ("-1/8", "-1/2"), ("1/8", "-1/12", "2/3"), ("-1/7", "3/2", "-2")],
    "radians": [("1", "5"), ("9", "-14"), ("-1", "-4"), ("2", "-1/2", "4"), ("-1", "4", "-7")],
}


@pytest.mark.share(3)
@pytest.mark.parametrize("axis", [(0, 1, 0), (0, -3, 0)])
@pytest.mark.parametrize(("unit", "angles"), [(unit, angles) for unit, steps in STEPS.items() for angles in steps])
def test_the_last_turn_goes_on_from_those_before_it(axis, unit, angles):
    """About the same line, given either way along it: as all of it in one turn; a tip meets the wall's top."""
    tip = fc.Polyhedron([(1, 0, 0.25), (2, 0, 0.5), (1.5, 0.5, 0.5)], [[0, 1, 2]])
    way = 1 if axis[1] > 0 else -1
    *before, share = map(Fraction, angles)
    begun, n = sum(before), len(angles)
    about = [(AXIS, 1) if k % 2 == 0 else (axis, way) for k in range(n)]
    steps = [Rotation(line, **{unit: sense * Fraction(x)}) for x, (line, sense) in zip(angles, about, strict=True)]
    from_ = Fraction(n - 1, n)
    found = fc.contact_intervals(tip.moving(Sequence(steps)), WALL, (from_, 1))
    whole = fc.contact_intervals(tip.moving(Rotation(AXIS, **{unit: 1})), WALL, (-15, 15))  # angles are its times
    ends = [sorted(float(from_ + (Fraction(t) - begun) / share / n) for t in (x.start, x.end)) for x in whole]
    ends = sorted([max(lo, float(from_)), min(hi, 1.0)] for lo, hi in ends if hi > from_ and lo < 1)
    assert ends and [[x.start, x.end] for x in found] == [pytest.approx(x, abs=1e-12) for x in ends]


AWAY = Rotation((0, 0, 1), turns="1/8")


@pytest.mark.parametrize("top", [1.5, 2.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("turns", ["1/2", "5/8", "3/8", "1/4"])
def test_in_balls_where_a_turn_of_both_makes_poses_irrational(top, side, turns):
    """Both turn by an eighth first: then it is as it was without, about the axis as that has turned."""
    body = sheet(top) if side < 0 else fc.Polyhedron([(1, 0, top), (1, 0, 1), (0, 0, 1)], [[0, 1, 2]])
    plain = fc.first_contact(body.moving(turn(turns)), WALL)
    # the axis y, turned by an eighth about z, is along (-1, 1, 0)
    moving = body.moving(Sequence([AWAY, Rotation((-1, 1, 0), turns=turns)]))
    hit = fc.first_contact(moving, WALL.moving(Sequence([AWAY, Translation((0, 0, 0))])))
    assert hit.status is plain.status
    if plain.time is not None:
        lo, hi = hit.time_interval
        assert lo <= (1 + plain.time) / 2 <= hi and hi - lo < 1e-12
        assert hit.stats.ways[0].way == "by trees"
