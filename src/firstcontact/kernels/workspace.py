"""Rows and slots of the two scratch arrays that the advancement kernels share: one of doubles, one of integers.

One array each, because every array that a kernel takes costs it compile time; row numbers are NumPy integers, because
Numba compiles a function anew for every Python integer written into a call.
"""

from __future__ import annotations

import numpy as np


def rows(*numbers: int) -> tuple[np.int64, ...]:
    """The numbers in the type that Numba does not specialise for."""
    return tuple(np.int64(n) for n in numbers)


# Row `side` (0 for a, 1 for b) of these pairs: pose, rates of its entries, inverse of its linear part.
POSE_A, POSE_B, RATES_A, RATES_B, INVERSE_A, INVERSE_B = rows(0, 1, 2, 3, 4, 5)
# Poses in which gaps are evaluated; enclosure of accelerations; unknowns X, t, multipliers; value, gradient, rates
# of a form; right side of a linear system; weights of a simplex.
HERE_A, HERE_B, MIDDLE, RADIUS, UNKNOWN, FORM, RIGHT, WEIGHTS = rows(6, 7, 8, 9, 10, 11, 12, 13)
# Four rows of points of a - b, of a and of b; eight of gradients; twelve of a matrix; results; enclosure of velocities.
SIMPLEX, GRADIENTS, MATRIX, RESULTS, SPEED, SPREAD = rows(14, 18, 26, 38, 39, 40)
ROWS, WIDTH = 41, 14

# Slot of the unknowns: the distance, for times at which the bodies are apart.
AWAY = 12
SIDE_A, SIDE_B, NO_VERTEX = rows(0, 1, -1)
# Where the points of a and of b are in the rows of a simplex.
OF_A, OF_B = rows(3, 6)
# Whether Newton steps move in time.
AT_TIME, IN_TIME = rows(0, 1)
# Slots of the row of results: free until, gap there, time, lo, hi, point, normal (from a to b).
FREE_UNTIL, GAP, TIME, LO, HI, POINT, NORMAL = 0, 1, 2, 3, 4, 5, 8
# Slots of the integers: counters that add up; how the contact was found; the vertex; active forms of a, then of b,
# and how many of each; order of the unknowns of a linear system; the pieces of a and of b that a guess is about; what
# stands for the forms it began with.
STEPS, NEWTON, GAPS, MODE, VERTEX, ACTIVE, COUNT, ORDER, PART, BEGAN = 0, 1, 2, 3, 4, 5, 13, 15, 26, 28
INTEGERS = 29


def workspace() -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((ROWS, WIDTH)), np.zeros(INTEGERS, np.int64)
