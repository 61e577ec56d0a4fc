"""Single points of an intersection curve: where two rulings meet, and the ruling of one side that meets a given one."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted

# Columns of `places`: parameters in their parts, positions on the rulings, the point, the gap between the rulings;
# parts, kind, and whether s and t are in their ranges.
X, Y, S, T, POINT, GAP, PART_U, PART_V, KIND, S_IN, T_IN, COLUMNS = 0, 1, 2, 3, 4, 7, 8, 9, 10, 11, 12, 13
# Kinds of places: 0 within, 1 to 4 on the borders u = u0, u1, v = v0, v1, from CUT on at s = 0, 1, t = 0, 1; at a weak
# one the curve goes on in a box that is left open.
CUT, WEAK = 5, -1
# Columns of `arcs`: places at both ends (-1: nothing is left of the arc, -2: perhaps a point); parts; whether it runs
# over v (else over u); sign of the slope of Delta across; for s and t the end of the range that may cut it (-1: none);
# the range of the parameter across; a direction along which its rulings are seen to cross.
START, END, ARC_U, ARC_V, OVER, RISING, S_BOUND, T_BOUND, LOW, HIGH, VIEW = range(11)
ARC_COLUMNS = 13
# Rows of the scratch array `r`: X, Y, Z, W of both ends of a ruling of p, then of q, their derivatives, Bernstein
# polynomials of the points' degree and of one less.
OF_P, OF_Q, SLOPES, BASIS, LOWER = np.int64(0), np.int64(1), np.int64(2), np.int64(4), np.int64(5)
SCRATCH_ROWS = 6
# Layers of the forms of a side.
VALUES, DERIVATIVES = np.int64(0), np.int64(1)
NO, YES = np.int64(0), np.int64(1)
# A position on a ruling this near its end is not told from it.
AT_END = 1e-11
# One this far beyond may be at the end: places at which Delta hardly changes are not known better.
NEAR_END = 1e-8
MOST_STEPS = 80
# A Newton step after which the next would be shorter than rounding, for it squares them.
LAST_STEP = 3e-8


@uncounted
def _combine(forms, part, which, count, weights, to, r):
    """Row `to` of r: the sum of rows of forms with weights; eight sums apart, for the sake of vector instructions."""
    a0 = a1 = a2 = a3 = b0 = b1 = b2 = b3 = 0.0
    for k in range(count):
        w = r[weights, k]
        a0 += w * forms[part, which, k, 0]
        a1 += w * forms[part, which, k, 1]
        a2 += w * forms[part, which, k, 2]
        a3 += w * forms[part, which, k, 3]
        b0 += w * forms[part, which, k, 4]
        b1 += w * forms[part, which, k, 5]
        b2 += w * forms[part, which, k, 6]
        b3 += w * forms[part, which, k, 7]
    r[to, 0], r[to, 1], r[to, 2], r[to, 3] = a0, a1, a2, a3
    r[to, 4], r[to, 5], r[to, 6], r[to, 7] = b0, b1, b2, b3


@uncounted
def evaluate(forms, part, x, to, sloped, r):
    """Rows `to` and, if asked, SLOPES + `to` of r: both ends of the ruling at x of a part, and their derivatives.

    forms: (parts, 2, n + 1, 8): Bernstein coefficients of the points, and of their derivatives, those of degree n - 1.
    """
    n = forms.shape[2] - 1
    y = 1.0 - x
    # Bernstein polynomials, degree by degree
    r[BASIS, 0] = 1.0
    for m in range(1, n + 1):
        if m == n:
            for k in range(n):
                r[LOWER, k] = r[BASIS, k]
        r[BASIS, m] = x * r[BASIS, m - 1]
        for k in range(m - 1, 0, -1):
            r[BASIS, k] = y * r[BASIS, k] + x * r[BASIS, k - 1]
        r[BASIS, 0] *= y
    _combine(forms, part, VALUES, n + 1, BASIS, to, r)
    if sloped == 1:
        _combine(forms, part, DERIVATIVES, n, LOWER, SLOPES + to, r)


@uncounted
def place(p, part_p, x, q, part_q, y, r, row):
    """Set `row` to the meeting point of ruling x of p and y of q, the middle of their common perpendicular."""
    evaluate(p, part_p, x, OF_P, NO, r)
    evaluate(q, part_q, y, OF_Q, NO, r)
    meet(r, row)
    row[X], row[Y] = x, y


@uncounted
def meet(r, row):
    """Positions, point and gap of the two rulings in r."""
    w0, w1, w2, w3 = 1.0 / r[0, 3], 1.0 / r[0, 7], 1.0 / r[1, 3], 1.0 / r[1, 7]
    a0, a1, a2 = r[0, 0] * w0, r[0, 1] * w0, r[0, 2] * w0
    b0, b1, b2 = r[1, 0] * w2, r[1, 1] * w2, r[1, 2] * w2
    d0, d1, d2 = r[0, 4] * w1 - a0, r[0, 5] * w1 - a1, r[0, 6] * w1 - a2
    e0, e1, e2 = r[1, 4] * w3 - b0, r[1, 5] * w3 - b1, r[1, 6] * w3 - b2
    n0, n1, n2 = d1 * e2 - d2 * e1, d2 * e0 - d0 * e2, d0 * e1 - d1 * e0
    f0, f1, f2 = b0 - a0, b1 - a1, b2 - a2
    size = n0 * n0 + n1 * n1 + n2 * n2
    if size == 0.0:
        row[S] = row[T] = row[GAP] = np.inf
        row[POINT], row[POINT + 1], row[POINT + 2] = a0, a1, a2
        return
    s = (f0 * (e1 * n2 - e2 * n1) + f1 * (e2 * n0 - e0 * n2) + f2 * (e0 * n1 - e1 * n0)) / size
    t = (f0 * (d1 * n2 - d2 * n1) + f1 * (d2 * n0 - d0 * n2) + f2 * (d0 * n1 - d1 * n0)) / size
    row[S], row[T] = s, t
    row[GAP] = abs(f0 * n0 + f1 * n1 + f2 * n2) / np.sqrt(size)
    row[POINT] = 0.5 * (a0 + s * d0 + b0 + t * e0)
    row[POINT + 1] = 0.5 * (a1 + s * d1 + b1 + t * e1)
    row[POINT + 2] = 0.5 * (a2 + s * d2 + b2 + t * e2)


@uncounted
def across(fixed, part, x, moving, other, lo, hi, rising, y, of_fixed, of_moving, r):
    """The y in [lo, hi] at which Delta vanishes over x, where it grows (rising = 1) or falls (-1) with y throughout.

    Newton's steps inside the bracket, halvings where they leave it.  The rows of r hold both rulings then.
    """
    evaluate(fixed, part, x, of_fixed, NO, r)
    f = of_fixed
    l0, l1 = r[f, 0] * r[f, 5] - r[f, 1] * r[f, 4], r[f, 0] * r[f, 6] - r[f, 2] * r[f, 4]
    l2, l3 = r[f, 0] * r[f, 7] - r[f, 3] * r[f, 4], r[f, 1] * r[f, 6] - r[f, 2] * r[f, 5]
    l4, l5 = r[f, 1] * r[f, 7] - r[f, 3] * r[f, 5], r[f, 2] * r[f, 7] - r[f, 3] * r[f, 6]
    m, g = of_moving, SLOPES + of_moving
    y = min(max(y, lo), hi)
    last = np.inf
    for _ in range(MOST_STEPS):
        evaluate(moving, other, y, of_moving, YES, r)
        # the dual skew matrix of the fixed line times both ends
        a0 = l5 * r[m, 5] - l4 * r[m, 6] + l3 * r[m, 7]
        a1 = -l5 * r[m, 4] + l2 * r[m, 6] - l1 * r[m, 7]
        a2 = l4 * r[m, 4] - l2 * r[m, 5] + l0 * r[m, 7]
        a3 = -l3 * r[m, 4] + l1 * r[m, 5] - l0 * r[m, 6]
        b0 = l5 * r[m, 1] - l4 * r[m, 2] + l3 * r[m, 3]
        b1 = -l5 * r[m, 0] + l2 * r[m, 2] - l1 * r[m, 3]
        b2 = l4 * r[m, 0] - l2 * r[m, 1] + l0 * r[m, 3]
        b3 = -l3 * r[m, 0] + l1 * r[m, 1] - l0 * r[m, 2]
        value = r[m, 0] * a0 + r[m, 1] * a1 + r[m, 2] * a2 + r[m, 3] * a3
        change = r[g, 0] * a0 + r[g, 1] * a1 + r[g, 2] * a2 + r[g, 3] * a3
        change -= r[g, 4] * b0 + r[g, 5] * b1 + r[g, 6] * b2 + r[g, 7] * b3
        if value * rising < 0.0:
            lo = y
        else:
            hi = y
        step = -value / change if change != 0.0 else np.inf
        if not lo <= y + step <= hi or abs(step) > 0.5 * last:
            if hi - lo < 4e-16 or abs(step) < 4e-16:
                return y
            step = 0.5 * (lo + hi) - y
            last = abs(step)
            y += step
            continue
        last = abs(step)
        y += step
        if last < LAST_STEP:
            for c in range(8):
                r[m, c] += step * r[g, c]
            return y
    evaluate(moving, other, y, of_moving, YES, r)
    return y


@uncounted
def on_arc(p, q, arc, run, guess, r, row):
    """Set `row` to the point of an arc over `run`: u = run and v near the guess, or the other way round."""
    u, v = int(arc[ARC_U]), int(arc[ARC_V])
    # Delta is symmetric in the two lines
    over_v = arc[OVER] == 1.0
    a, i, b, j = (q, v, p, u) if over_v else (p, u, q, v)
    at_a, at_b = (OF_Q, OF_P) if over_v else (OF_P, OF_Q)
    across_it = across(a, i, run, b, j, arc[LOW], arc[HIGH], arc[RISING], guess, at_a, at_b, r)
    row[X], row[Y] = (across_it, run) if over_v else (run, across_it)
    meet(r, row)


@uncounted
def enter(arc, place, row):
    """Copy a place to `row` in the parts of an arc: one found on a joint may be told in those of a neighbour."""
    for c in range(COLUMNS):
        row[c] = place[c]
    if row[PART_U] != arc[ARC_U]:
        row[X], row[PART_U] = 1.0 - row[X], arc[ARC_U]
    if row[PART_V] != arc[ARC_V]:
        row[Y], row[PART_V] = 1.0 - row[Y], arc[ARC_V]


@uncounted
def inside(position):
    return -AT_END <= position <= 1.0 + AT_END


@uncounted
def may_be_inside(row):
    """Whether a place may belong to both pieces, for all that doubles tell of s and t there."""
    low, high = -NEAR_END, 1.0 + NEAR_END
    return low <= row[S] <= high and low <= row[T] <= high
