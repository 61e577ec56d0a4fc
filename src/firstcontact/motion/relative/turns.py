"""A turn about an axis, with an advance along it, as seen from one of its times.

Every entry of the pose is x + y sin(omega s) + z (1 - cos(omega s)) + v s, s the time from there in some unit.  About
an axis far away y and z are as large as its distance, and sine and cosine in doubles tell the way to a few digits of
that.  A slight turn is a polynomial in s all the same, with coefficients as large as the way.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from flint import arb, fmpq

from firstcontact.exact.numbers import precision
from firstcontact.exact.rigid import ball_rotation, compose
from firstcontact.exact.vectors import cross, dot
from firstcontact.motion.placement import Placement
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw

BITS = 192
# A turn of at most SLIGHT radians about an axis FAR times as far away as the origin is better told by a polynomial.  It
# leaves out no more than SHARE of what its coefficients tell.
SLIGHT, FAR, SHARE = 2.0**-6, 16.0, 2.0**-56


class TurningRows(NamedTuple):
    """rows (12, 4): x, y, z, v of the entries of R (by rows) and T, rounded once, as omega.

    rates (12,): y omega + v, rounded once, where `polynomials` tell it better than sine and cosine for |s| <= 1.
    """

    rows: np.ndarray
    rates: np.ndarray | None
    omega: float

    @property
    def is_slight(self) -> bool:
        """Whether polynomials tell it better."""
        return self.rates is not None

    @property
    def degree(self) -> int:
        """Of polynomials that leave out a small share of their terms 2 and 3, and of those in two derivatives.

        What they leave out is (|y| + |z|) |omega|^(n + 1) / (n + 1)! at most for |s| <= 1, (n + 1)^2 times as much in
        these derivatives; terms 2 and 3 have as many powers of s or fewer, and the powers 2 and 3 of omega.
        """
        angle, n = abs(self.omega), 3
        while 6.0 * (n + 1) ** 2 * angle ** (n - 2) > SHARE * math.factorial(n + 1):
            n += 1
        return n

    def polynomials(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        """(12, n + 1) coefficients of s^k, rounded 3 k + 2 times, and (12,) bounds of the next ones."""
        assert self.rates is not None
        k = np.arange(1, n + 2)
        powers = np.cumprod(self.omega / k)
        waves = self.rows[:, 2 - k % 2] * np.where(k % 4 % 3 > 0, powers, -powers)  # y, z, -y, -z and so on
        table = np.column_stack([self.rows[:, 0], self.rates, waves[:, 1:-1]])
        return table, np.abs(self.rows[:, 1:3]).sum(axis=1) * abs(powers[-1]) * (1.0 + 1e-12)


def turning_rows(motion: Rotation | Screw, begin: fmpq, share: fmpq, before: Placement) -> TurningRows:
    """Of the pose `before` and then the motion up to its own time begin + share s, 0 <= s."""
    with precision(BITS + bits_of_distance(motion)):
        length = arb(dot(motion.axis, motion.axis)).sqrt()
        k = [arb(x) / length for x in motion.axis]
        p = [arb(x) for x in motion.point]
        omega = angle_ball(motion.angle * share, motion.unit)
        turned = ball_rotation(motion.axis, motion.point, angle_ball(motion.angle * begin, motion.unit))
        base = compose(turned, tuple(tuple(arb(x) for x in row) for row in before.matrix()))  # type: ignore[arg-type]
        columns = [[base[i][j] for i in range(3)] for j in range(3)]
        shift = [base[i][3] for i in range(3)]
        arm = [s - q for s, q in zip(shift, p, strict=True)]
        once = [cross(k, c) for c in (*columns, arm)]
        twice = [cross(k, c) for c in once]
        zeroth = [*columns, [s + arb(motion.advance * begin) * x for s, x in zip(shift, k, strict=True)]]
        slope = [arb(motion.advance * share) * x for x in k]
        order = [(i, j) for i in range(3) for j in range(3)] + [(i, 3) for i in range(3)]
        rows = [
            [middle(zeroth[j][i]), middle(once[j][i]), middle(twice[j][i]), middle(slope[i]) if j == 3 else 0.0]
            for i, j in order
        ]
        turn, rates = middle(omega), None
        if abs(turn) <= SLIGHT and _is_far(rows[9:]):
            rates = np.array([middle(once[j][i] * omega + (slope[i] if j == 3 else 0)) for i, j in order])
        return TurningRows(np.array(rows), rates, turn)


def _is_far(shift: list[list[float]]) -> bool:
    """Whether the axis is FAR times as far away as the origin, by the rows of T."""
    return max(abs(c) for row in shift for c in row[1:3]) > FAR * max(abs(row[0]) for row in shift)


def bits_of_distance(motion: Rotation | Screw) -> int:
    """Bits, in whole words, that the place of the axis takes before the binary point: of poses near the origin as many
    are lost."""
    return max(0, *(int(x.p).bit_length() - int(x.q).bit_length() for x in motion.point)) // 64 * 64


def middle(x: arb) -> float:
    return float(x.mid())
