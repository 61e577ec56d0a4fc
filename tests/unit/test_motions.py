"""Motions: poses, what is refused, pickling, and which pairs are supported."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.exact.numbers import to_double
from firstcontact.motion.relative.pieces import pieces
from firstcontact.motion.span import common_span

CUBE = fc.examples.box((1, 1, 1))


def assert_rigid(pose: np.ndarray) -> None:
    assert pose.shape == (4, 4) and pose.dtype == np.float64
    assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-14)
    assert np.linalg.det(pose[:3, :3]) > 0 and pose[3].tolist() == [0, 0, 0, 1]


def test_translation_poses():
    motion = fc.Translation(("1/2", 2, -4))
    assert motion.span == (0.0, 1.0)
    assert motion(0.25)[:3, 3].tolist() == [0.125, 0.5, -1]
    assert motion(3)[:3, 3].tolist() == [1.5, 6, -12]  # goes on beyond its span
    assert_rigid(motion(-1))


@pytest.mark.parametrize("kind", [{"turns": Fraction(1, 4)}, {"degrees": 90}, {"radians": math.pi / 2}])
def test_rotation_poses_follow_the_right_hand(kind):
    motion = fc.Rotation((0, 0, 3), point=(1, 0, 7), **kind)
    assert np.allclose(motion(1.0) @ [2, 0, 0, 1], [1, 1, 0, 1], atol=1e-15)
    assert np.allclose(motion(0.5) @ [2, 0, 0, 1], [1 + 0.5**0.5, 0.5**0.5, 0, 1], atol=1e-15)
    assert np.allclose(motion(-1.0) @ [2, 0, 0, 1], [1, -1, 0, 1], atol=1e-15)
    assert motion.radians == pytest.approx(math.pi / 2)


def test_rotation_about_a_slanted_axis_keeps_the_axis():
    motion = fc.Rotation((1, -2, 0.5), point=(3, 1, 1), degrees=77)
    for t in (0.0, 0.3, 1.0, 5.0):
        assert_rigid(motion(t))
        assert np.allclose(motion(t) @ [5, -3, 2, 1], [5, -3, 2, 1], atol=1e-13)


def test_sequence_poses():
    motion = fc.Sequence([fc.Translation((1, 0, 0)), fc.Rotation((0, 0, 1), turns="1/4")], durations=[1, 3])
    assert motion.span == (0.0, 4.0)
    assert np.allclose(motion(0.5) @ [0, 0, 0, 1], [0.5, 0, 0, 1])
    assert np.allclose(motion(1.0) @ [0, 0, 0, 1], [1, 0, 0, 1])
    assert np.allclose(motion(4.0) @ [0, 0, 0, 1], [0, 1, 0, 1])  # the axis stays in the world
    equal = fc.Sequence([fc.Translation((1, 0, 0))] * 4)
    assert equal.span == (0.0, 1.0) and equal(0.5)[0, 3] == 2
    for outside in (-0.1, 4.1, math.nan):
        with pytest.raises(fc.InputError, match="outside the span|finite number"):
            motion(outside)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: fc.Translation((1, 2)), "Translation vector is"),
        (lambda: fc.Translation(5), "Translation vector is"),
        (lambda: fc.Translation((1, math.nan, 0)), r"Translation vector\[1\] is nan"),
        (lambda: fc.Translation((1, 0, math.inf)), r"Translation vector\[2\] is inf"),
        (lambda: fc.Translation(("x", 0, 0)), r"Translation vector\[0\] is 'x'"),
        (lambda: fc.Translation(("1/0", 0, 0)), r"Translation vector\[0\]"),
        (lambda: fc.Rotation((0, 0, 0), turns=1), "axis is zero"),
        (lambda: fc.Rotation((0, 0, 1)), "exactly one of"),
        (lambda: fc.Rotation((0, 0, 1), turns=1, degrees=3), "exactly one of"),
        (lambda: fc.Rotation((0, 0, 1), point=(0, 0), turns=1), "Rotation point is"),
        (lambda: fc.Rotation((0, 0, 1), degrees=math.inf), "Rotation degrees is inf"),
        (lambda: fc.Translation((10**400, 0, 0)), "Translation vector"),
        (lambda: fc.Rotation((0, 0, 10**400), turns=1), "Rotation axis"),
        (lambda: fc.Sequence([]), "no steps"),
        (lambda: fc.Sequence([fc.Translation((1, 0, 0)), "turn"]), "step 1 is 'turn'"),
        (lambda: fc.Sequence([fc.Translation((1, 0, 0))], durations=[1, 2]), "1 steps but 2 durations"),
        (lambda: fc.Sequence([fc.Translation((1, 0, 0))], durations=[0]), r"durations\[0\] is 0"),
        (lambda: fc.Sequence([fc.Sequence([fc.Translation((1, 0, 0))])]), "step 0"),
    ],
)
def test_bad_motions_are_named(make, says):
    with pytest.raises(fc.InputError, match=says):
        make()


@pytest.mark.parametrize(
    "motion",
    [
        fc.Translation(("1/3", 0.1, 5)),
        fc.Rotation((1, "2/3", 0), point=("1/7", 0, 0), turns="1/3"),
        fc.Rotation((1, 1, 1), radians=0.1),
        fc.Sequence([fc.Translation(("1/3", 0, 0)), fc.Rotation((0, 0, 1), degrees="10.1")], ["1/3", 2]),
    ],
)
def test_motions_survive_pickling(motion):
    again = pickle.loads(pickle.dumps(motion))
    assert repr(again) == repr(motion) and again.span == motion.span
    assert exact_state(again) == exact_state(motion)
    for t in np.linspace(*motion.span, 7).tolist():
        assert np.array_equal(again(t), motion(t))


def exact_state(motion):
    if isinstance(motion, fc.Sequence):
        return [exact_state(s) for s in motion.steps], motion.ends
    if isinstance(motion, fc.Translation):
        return motion.vector
    return motion.axis, motion.point, motion.angle, motion.unit


# ---------------------------------------------------------------------------------------- pairs of motions

MOVE, SHIFT = fc.Translation((9, 0, 0)), fc.Translation((0, 1, 0))
TURN, SAME_AXIS = fc.Rotation((0, 0, 1), turns=1), fc.Rotation((0, 0, -2), point=(0, 0, 5), degrees=30)
OTHER_AXIS, OTHER_DIRECTION = (
    fc.Rotation((0, 0, 1), point=(1, 0, 0), turns=1),
    fc.Rotation((0, 1, 1), turns=1),
)
STILL = fc.Translation((0, 0, 0))
NO_TURN = fc.Rotation((1, 0, 0), turns=0)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (MOVE, None), (TURN, None), (MOVE, SHIFT), (TURN, SAME_AXIS), (TURN, TURN), (MOVE, MOVE),
        (TURN, STILL), (MOVE, NO_TURN), (STILL, NO_TURN),
        (fc.Sequence([MOVE, TURN]), None),
        (fc.Sequence([MOVE, TURN]), fc.Sequence([SHIFT, SAME_AXIS])),
    ],
)  # fmt: skip
def test_supported_pairs(a, b):
    far = CUBE.translated((50, 0, 0))
    for x, y in (
        (CUBE.moving(a), far if b is None else far.moving(b)),
        (far if b is None else far.moving(b), CUBE.moving(a)),
    ):
        assert fc.first_contact(x, y).status is fc.Status.FREE


@pytest.mark.parametrize(
    ("a", "b"), [(MOVE, TURN), (TURN, OTHER_AXIS), (TURN, OTHER_DIRECTION), (fc.Sequence([MOVE, TURN]), SHIFT)]
)
def test_pairs_that_are_no_single_motion_are_followed_but_have_no_exact_times(a, b):
    lid, box = CUBE.named("lid"), CUBE.translated((50, 0, 0.25)).named("box")
    for x, y in ((lid.moving(a), box.moving(b)), (box.moving(b), lid.moving(a))):
        assert fc.first_contact(x, y, (0, 1)).status is fc.Status.FREE
        with pytest.raises(fc.UnsupportedPair, match="no exact form") as caught:
            fc.first_contact(x, y, exact=True)
        assert "'lid'" in str(caught.value) and "'box'" in str(caught.value)
    if not isinstance(a, fc.Sequence):
        with pytest.raises(fc.InputError, match="'lid'.*give span"):
            fc.first_contact(lid.moving(a), box.moving(b), (0, math.inf))


@pytest.mark.parametrize(
    ("span", "says"),
    [
        ((1, 0), "end lies before"), (5, "give two times"), ((0, 1, 2), "give two times"),
        ((math.nan, 1), "span start is nan"), ((0, -math.inf), "span end"), (("a", 1), "span start"),
    ],
)  # fmt: skip
def test_bad_spans_are_named(span, says):
    with pytest.raises(fc.InputError, match=says):
        fc.first_contact(CUBE.moving(MOVE), CUBE.translated((50, 0, 0)), span)


def test_spans_of_sequences_are_bounded():
    moving = CUBE.moving(fc.Sequence([MOVE, SHIFT]))
    far = CUBE.translated((0, 50, 0))
    for span in ((0, 1.5), (-1, 1), (0, math.inf)):
        with pytest.raises(fc.InputError, match="leaves the span"):
            fc.first_contact(moving, far, span)
    assert fc.first_contact(moving, far, (0.25, 0.75)).status is fc.Status.FREE


def test_pieces_end_where_either_body_changes_its_motion():
    a = CUBE.moving(fc.Sequence([MOVE, SHIFT, MOVE], durations=[1, 1, 2]))
    b = CUBE.moving(fc.Sequence([SHIFT, MOVE], durations=["3/2", "5/2"]))
    first, last = common_span(a, b, None)
    parts = pieces(a, b, first, last)
    times = [(to_double(p.start), to_double(p.end)) for p in parts]
    assert times == [(0, 1), (1, 1.5), (1.5, 2), (2, 4)]
    assert (to_double(first), to_double(last)) == (0, 4)
    assert [to_double(p.start) for p in pieces(a, b, fmpq(1, 2), fmpq(5, 4))] == [0.5, 1]
