"""When two elements meet that floats have proved to meet within a short time: one equation, no question of insides.

Where a vertex lies on a facet, or two edges cross, the two directions that they span together and the way from one to
the other lie in one plane.  Under a translation that is a linear equation in time, under a rotation
c0 + c1 cos(phi) + sqrt(K) c2 sin(phi) = 0 (Schoemer & Thiel 1995, equation (6)); exact, without divisions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from flint import fmpq, fmpz

from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.times.instants import AngleInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, cross, dot, sub

if TYPE_CHECKING:
    from firstcontact.exact.ring import N, VectorOf

# Rounding of the slope: of two products of doubles below 1 and of the middle of the interval, below 2 pi.
SLOPE_EPS = 1e-14
# Not above the angle of one.
FULL_TURN = 6.28


def translation_instant(a: list[Vector], b: list[Vector], v: Vector) -> fmpq | None:
    """The only time at which the first element, moving by v, may meet the other; None where there may be more.

    a, b: their corners in whole numbers: one and three, three and one, or two and two.
    """
    gap, speed = translation_equation(a, b, v)
    return fmpq(gap, speed) if speed else None


def translation_equation(a: list[VectorOf[N]], b: list[VectorOf[N]], v: VectorOf[N]) -> tuple[N, N]:
    """(gap, speed) of an equation gap = t speed for that time; coordinates may be arrays of whole numbers too."""
    x, y = [sub(p, a[0]) for p in a[1:]] + [sub(p, b[0]) for p in b[1:]]
    n = cross(x, y)
    return dot(n, sub(b[0], a[0])), dot(n, v)


def rotation_instant(axis: Axis, a: list[Vector], b: list[Vector], lo: float, hi: float) -> AngleInstant | None:
    """The angle in [lo, hi] at which the first element, turning about an axis through the origin, meets the other.

    a, b: as above, about the origin.  There must be one.  None where the equation might have two roots so close: it has
    two in all, at which it falls and rises, so the one is known where its slope has one sign all over [lo, hi].
    """
    h = int(axis.h[0]), int(axis.h[1]), int(axis.h[2])
    whole = _equation(h, int(axis.K), a, b)
    # c1 and sqrt(K) c2 as doubles below 1; their slope changes by at most 2 per radian
    x, y = int(whole[1]) << 60, int(whole[2]) * math.isqrt(int(axis.K) << 120)
    extra = max(0, max(x.bit_length(), y.bit_length()) - 60)
    middle = 0.5 * (lo + hi)
    slope = 2.0**-60 * ((y >> extra) * math.cos(middle) - (x >> extra) * math.sin(middle))
    if not abs(slope) > hi - lo + SLOPE_EPS:
        return None
    way = 1 if slope < 0.0 else -1
    K, c0, c1, c2 = axis.K, fmpz(whole[0]), fmpz(whole[1]), fmpz(whole[2])  # noqa: N806
    norm = c1 * c1 + K * (c2 * c2)
    d, Kc = K * (norm - c0 * c0), -K * c0  # noqa: N806
    bounds = (lo, hi) if 0.0 < lo and hi < FULL_TURN else None  # the instant is counted from 0 on
    return AngleInstant(Surd(Kc * c1, -way * K * c2, d), Surd(Kc * c2, way * c1, d), Surd(K * norm), K, bounds)


def _equation(h: VectorOf[N], K: N, a: list[Vector], b: list[Vector]) -> VectorOf[N]:  # noqa: N803
    """K times c0, c1 and c2."""
    if len(a) == len(b):  # (R e x f).(c - R a) = (f x c).R e - f.R(a x e)
        e, f = sub(a[1], a[0]), sub(b[1], b[0])
        (p0, p1, p2), (q0, q1, q2) = _product(h, K, e, cross(f, b[0])), _product(h, K, cross(a[0], e), f)
        return p0 - q0, p1 - q1, p2 - q2
    facet = a if len(a) == 3 else b
    n = cross(sub(facet[1], facet[0]), sub(facet[2], facet[0]))
    c0, c1, c2 = _product(h, K, n, b[0]) if len(a) == 3 else _product(h, K, a[0], n)
    return c0 - K * dot(n, facet[0]), c1, c2


def _product(h: VectorOf[N], K: N, x: Vector, y: Vector) -> VectorOf[N]:  # noqa: N803
    """K times the dot product of x, turned by phi, and y, as coefficients of 1, cos(phi) and sqrt(K) sin(phi)."""
    (h0, h1, h2), (x0, x1, x2), (y0, y1, y2) = h, x, y
    still = (h0 * x0 + h1 * x1 + h2 * x2) * (h0 * y0 + h1 * y1 + h2 * y2)
    turn = h0 * (x1 * y2 - x2 * y1) + h1 * (x2 * y0 - x0 * y2) + h2 * (x0 * y1 - x1 * y0)
    return still, K * (x0 * y0 + x1 * y1 + x2 * y2) - still, turn
