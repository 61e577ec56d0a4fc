"""Running error analysis: numbers as (value, bound on their error).

Each operation adds its own rounding, u = 2^-53, with second-order terms absorbed by the last factor.
"""

from __future__ import annotations

import math

from firstcontact.kernels.jit import uncounted

U = 2.0**-53
_TINY = 2.0**-1020


@uncounted
def add(x, ex, y, ey):
    r = x + y
    return r, (ex + ey + U * abs(r)) * (1.0 + 4.0 * U)


@uncounted
def sub(x, ex, y, ey):
    r = x - y
    return r, (ex + ey + U * abs(r)) * (1.0 + 4.0 * U)


@uncounted
def mul(x, ex, y, ey):
    r = x * y
    return r, (abs(x) * ey + abs(y) * ex + ex * ey + U * abs(r)) * (1.0 + 8.0 * U) + _TINY


@uncounted
def div(x, ex, y, ey):
    """x / y for |y| > ey."""
    r = x / y
    return r, ((ex + abs(r) * ey) / (abs(y) - ey) + U * abs(r)) * (1.0 + 16.0 * U) + _TINY


@uncounted
def root(x, ex):
    """sqrt of the true number, taken as zero where it may be negative."""
    hi = math.sqrt(x + ex) if x + ex > 0.0 else 0.0
    lo = math.sqrt(x - ex) if x - ex > 0.0 else 0.0
    r = 0.5 * (lo + hi)
    return r, (0.5 * (hi - lo) + 3.0 * U * hi) * (1.0 + 8.0 * U)


@uncounted
def dot2(x0, x1, ex, y0, y1, ey):
    """x0 y0 + x1 y1, one error bound for both coordinates of each vector."""
    r = x0 * y0 + x1 * y1
    size = abs(x0) * abs(y0) + abs(x1) * abs(y1)
    n, m = abs(x0) + abs(x1), abs(y0) + abs(y1)
    return r, (n * ey + m * ex + 2.0 * ex * ey + 2.0 * U * size) * (1.0 + 16.0 * U) + _TINY


@uncounted
def cross2(x0, x1, ex, y0, y1, ey):
    """x0 y1 - x1 y0, one error bound for both coordinates of each vector."""
    return dot2(x0, x1, ex, y1, -y0, ey)
