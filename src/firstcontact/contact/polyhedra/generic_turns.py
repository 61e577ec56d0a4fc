"""Poses at a rational time, exact but for the angles of their turns: what holds whatever these are.

A turn without rational cosine and sine stands as the generic one about its axis, a polynomial in a power of one
variable u.  A condition is a polynomial in the pose; where it vanishes at the generic one it vanishes at the true one.
"""

from __future__ import annotations

from typing import Any

from flint import fmpq, fmpq_poly

from firstcontact.exact.rigid import IDENTITY, Matrix, inverse_map, rational_sqrt, shift
from firstcontact.exact.vectors import Vector, dot, scaled
from firstcontact.motion.placement import Placement, Turn, Twist

Rows = list[list[Any]]

# Conditions have degree 6 at most in the variable of each turn: powers this far apart are not confused.
APART = 8
MOST_TURNS = 3


def generic_turn(axis: Vector, u: fmpq_poly) -> tuple[Rows, fmpq_poly]:
    """(linear part, weight): the turn about the axis by 2 atan(|axis| u), times 1 + |axis|^2 u^2."""
    x, y, z = axis
    across = [[fmpq(0), -z, y], [z, fmpq(0), -x], [-y, x, fmpq(0)]]
    square = dot(axis, axis)
    turn = [
        [int(i == j) + 2 * across[i][j] * u + (2 * axis[i] * axis[j] - (square if i == j else 0)) * u**2
         for j in range(3)]
        for i in range(3)
    ]  # fmt: skip
    return turn, 1 + square * u**2


def relative_pose(place_a: Placement, place_b: Placement) -> tuple[Rows, Rows, bool] | None:
    """(the pose of a seen from b, its inverse, whether both are exact): (4, 4) polynomials up to a positive factor.

    None where a length is irrational, or turns are too many.
    """
    factors = [(f, False) for f in place_a.factors] + [(f, True) for f in reversed(place_b.factors)]
    turns = 0
    pose, back = _identity(), _identity()
    for factor, inverted in factors:
        turns += isinstance(factor, Turn | Twist)
        steps = None if turns > MOST_TURNS else _steps(factor, turns - 1)
        if steps is None:
            return None
        for there, home in ((home, there) for there, home in reversed(steps)) if inverted else steps:
            pose, back = _product(there, pose), _product(back, home)
    return pose, back, turns == 0


def _steps(factor: Matrix | Turn | Twist, index: int) -> list[tuple[Rows, Rows]] | None:
    """A factor of a placement as maps to apply one after the other, each with its inverse."""
    if not isinstance(factor, Turn | Twist):
        return [_fixed(factor)]
    turn = factor.turn if isinstance(factor, Twist) else factor
    home = scaled(-1, turn.point)
    steps = [_fixed(shift(home)), _turning(turn.axis, index), _fixed(shift(turn.point))]
    if isinstance(factor, Twist) and factor.advance:
        length = rational_sqrt(dot(turn.axis, turn.axis))
        if length is None:
            return None
        steps.append(_fixed(shift(scaled(factor.advance / length, turn.axis))))
    return steps


def _turning(axis: Vector, index: int) -> tuple[Rows, Rows]:
    turn, weight = generic_turn(axis, fmpq_poly([0, 1]) ** APART**index)
    nil = fmpq_poly([0])
    last = [nil, nil, nil, weight]
    rows = [[*row, nil] for row in turn]
    return [*rows, last], [*([turn[j][i] for j in range(3)] + [nil] for i in range(3)), last]


def _fixed(matrix: Matrix) -> tuple[Rows, Rows]:
    return _rows(matrix), _rows(inverse_map(matrix))


def _rows(matrix: Matrix) -> Rows:
    return [[fmpq_poly([x]) for x in row] for row in (*matrix, (0, 0, 0, 1))]


def _identity() -> Rows:
    return _rows(IDENTITY)


def _product(m: Rows, n: Rows) -> Rows:
    return [[sum((m[i][k] * n[k][j] for k in range(4)), fmpq_poly([0])) for j in range(4)] for i in range(4)]
