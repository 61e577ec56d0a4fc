"""Filters that part bodies by balls and boxes: numbers that are none prove nothing."""

import numpy as np

from firstcontact.contact.compound.windows import overlapping
from firstcontact.contact.runs.near import _may_meet

NAN = float("nan")


def balls(*places):
    return np.array(places, float)[:, None], np.ones((len(places), 1))


def test_balls_of_unknown_places_may_meet():
    there = balls((0, 0, 0), (0, 0, 0), (0, 0, 0))
    assert _may_meet(balls((9, 0, 0), (1, 0, 0), (NAN, 0, 0)), there).tolist() == [False, True, True]


def test_boxes_of_unknown_corners_may_meet():
    lo = np.array([[(0, 0, 0), (5, 0, 0), (NAN, 0, 0), (NAN, 9, 0)]], float)
    one = np.zeros((1, 1, 3)), np.ones((1, 1, 3))
    assert overlapping((lo, lo + 1.0), one).tolist() == [[0, 0], [2, 0]]
