"""What a float kernel may say, and how determinants carry their error bound."""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted

NONE, CERTAIN, UNSURE = 0, 1, 2

# |fl(det) - det| <= DET_EPS * perm + TINY for det = x.(y x z) with entries that are doubles, differences of two
# doubles or doubles rounded once, perm the same expression over absolute values, |entries| <= 2^150.
# 9 * 2^-53 is proved (three roundings of the entries, two per product, four of the sums, second order
# included); TINY covers underflow: 2^-1075 * 2^300.  See test_det_bound.
DET_EPS = 9.0 * 2.0**-53 * (1.0 + 2.0**-40)
TINY = 2.0**-700
# More than sums of products of three lengths lose below the range of doubles.
LOST = 2.0**-960


@uncounted
def cross(x0, x1, x2, y0, y1, y2):
    return x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0


@uncounted
def cross_size(x0, x1, x2, y0, y1, y2):
    """The cross product with absolute values and sums: what its rounding errors scale with."""
    return (
        abs(x1 * y2) + abs(x2 * y1),
        abs(x2 * y0) + abs(x0 * y2),
        abs(x0 * y1) + abs(x1 * y0),
    )


@uncounted
def slack3(x, y, z, dx, dy, dz):
    """Bound on the change of x.(y x z) when vectors of 1-norm x, y, z move by at most dx, dy, dz."""
    return 1.000001 * (dx * (y + dy) * (z + dz) + x * dy * (z + dz) + x * y * dz)


@uncounted
def quotient(n, n_err, d, d_err):
    """(lo, hi) around the true n/d; |d| > d_err."""
    t = n / d
    err = (n_err + abs(t) * d_err) / (abs(d) - d_err)
    err = err * (1.0 + 2.0**-45) + abs(t) * 2.0**-51 + 2.0**-1000
    return t - err, t + err
