"""Angles of directions in [0, 2 pi) with a proven error: libm promises none."""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted

TWO_PI = 6.283185307179586
HALF_PI = 1.5707963267948966
# |angle_of(x, y) - true angle of the doubles (x, y)| <= ANGLE_EPS.  The polynomial is within 7.5e-17 of
# atan(t)/t; the reduction and the Horner sum round a few times numbers below 1, the octant sums a few times
# numbers below 2 pi (8.9e-16 each).  Smaller: contacts could be lost.  See test_angle_bound.
ANGLE_EPS = 4e-15


@uncounted
def _atan(t):
    """atan for 0 <= t <= 1."""
    shift = 0.0
    if t > 0.41421356237309503:  # tan(pi/8): atan(t) = pi/4 + atan((t - 1)/(t + 1))
        shift = 0.7853981633974483
        t = (t - 1.0) / (t + 1.0)
    x = t * t
    p = 0.021133752033748364
    p = p * x - 0.04347919839046537
    p = p * x + 0.0568830340363325
    p = p * x - 0.066402251735395
    p = p * x + 0.07689952488233016
    p = p * x - 0.09090773003240828
    p = p * x + 0.11111106177375227
    p = p * x - 0.14285714180900647
    p = p * x + 0.19999999998854168
    p = p * x - 0.33333333333328435
    return shift + (t + t * x * p)


@uncounted
def angle_of(x, y):
    """The angle of the vector (x, y), not (0, 0), in [0, 2 pi)."""
    ax, ay = abs(x), abs(y)
    angle = _atan(ay / ax) if ay <= ax else HALF_PI - _atan(ax / ay)
    if x < 0.0:
        angle = 3.141592653589793 - angle
    return TWO_PI - angle if y < 0.0 else angle


@uncounted
def angle_bounds(x, ex, y, ey):
    """(lo, hi) around the angle of the true vector; (0, 2 pi) when the errors reach around zero angle.

    |error of (x, y)| / |(x, y)| = r < 1/2 turns the vector by at most asin(r) <= 1.05 r.
    """
    length = max(abs(x), abs(y))
    r = (ex + ey) / length if length > 0.0 else 1.0
    if not r < 0.5:
        return 0.0, TWO_PI
    angle = angle_of(x, y)
    err = 1.06 * r + ANGLE_EPS
    if angle - err < 0.0 or angle + err > TWO_PI - ANGLE_EPS:
        return 0.0, TWO_PI
    return angle - err, angle + err
