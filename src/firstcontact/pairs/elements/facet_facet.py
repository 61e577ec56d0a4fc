"""Facet against facet under translation: when each straddles the plane of the other.

Facet abc moves by t v, facet def rests.  Two triangles that share a point at t both straddle the plane of either: with
n normal to a plane and p a point of it, the heights n.(q - p) + t n.v of the corners q of the other facet are not all
positive and not all negative.  That tells more of two facets than fifteen tests of their edges and corners do, and
costs less than two of these.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.verdict import DET_EPS, TINY, cross, cross_size, quotient, slack3


@uncounted
def straddle_window(xp, xq, v0, v1, v2, err_p, err_q, first, last):
    """(lo, hi) in [first, last]: outside it facet q, moved by t v, surely lies on one side of the plane of facet p.

    xp, xq: corners (9,), whose coordinates err_p and err_q bound the errors of.  lo > hi: never.
    """
    e0, e1, e2 = xp[3] - xp[0], xp[4] - xp[1], xp[5] - xp[2]
    f0, f1, f2 = xp[6] - xp[0], xp[7] - xp[1], xp[8] - xp[2]
    n0, n1, n2 = cross(e0, e1, e2, f0, f1, f2)
    s0, s1, s2 = cross_size(e0, e1, e2, f0, f1, f2)
    least, most = np.inf, -np.inf
    w0 = w1 = w2 = 0.0
    for k in range(3):
        x0, x1, x2 = xq[3 * k] - xp[0], xq[3 * k + 1] - xp[1], xq[3 * k + 2] - xp[2]
        height = x0 * n0 + x1 * n1 + x2 * n2
        least, most = min(least, height), max(most, height)
        w0, w1, w2 = max(w0, abs(x0)), max(w1, abs(x1)), max(w2, abs(x2))
    speed = v0 * n0 + v1 * n1 + v2 * n2
    height_err = DET_EPS * (w0 * s0 + w1 * s1 + w2 * s2) + TINY
    speed_err = DET_EPS * (abs(v0) * s0 + abs(v1) * s1 + abs(v2) * s2) + TINY
    if err_p + err_q > 0.0:
        e, f = abs(e0) + abs(e1) + abs(e2), abs(f0) + abs(f1) + abs(f2)
        height_err += slack3(w0 + w1 + w2, e, f, 3.0 * (err_p + err_q), 6.0 * err_p, 6.0 * err_p)
        speed_err += slack3(abs(v0) + abs(v1) + abs(v2), e, f, 0.0, 6.0 * err_p, 6.0 * err_p)
    if abs(speed) <= speed_err:
        # a corner in the plane at t has |height| = |t| |speed|
        reach = max(abs(first), abs(last)) * (abs(speed) + speed_err) * (1.0 + 2.0**-50)
        if max(least, -most) - height_err > reach:
            return np.inf, -np.inf
        return first, last
    lo, _ = quotient(-most if speed > 0.0 else -least, height_err, speed, speed_err)
    _, hi = quotient(-least if speed > 0.0 else -most, height_err, speed, speed_err)
    # a bound beyond the range of doubles tells nothing
    return (lo if lo > first else first), (hi if hi < last else last)


@uncounted
def translation_window(xa, xb, v0, v1, v2, err_a, err_b, first, last):
    """(lo, hi) in [first, last]: outside it facet xa + t v and facet xb surely share no point.  lo > hi: never."""
    lo, hi = straddle_window(xb, xa, v0, v1, v2, err_b, err_a, first, last)
    if lo <= hi:
        lo, hi = straddle_window(xa, xb, -v0, -v1, -v2, err_a, err_b, lo, hi)
    return lo, hi
