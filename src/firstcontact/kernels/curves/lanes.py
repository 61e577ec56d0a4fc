"""Several points of one arc at a time: every step runs over LANES of them, for the sake of vector instructions.

`w` is one array of rows of LANES numbers, row k at k * LANES; that all distances and counts are constants lets the
compiler see that steps are independent.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curves.points import ARC_U, ARC_V, DERIVATIVES, HIGH, LAST_STEP, LOW, OVER, VALUES
from firstcontact.kernels.jit import uncounted

LANES = 16
# Rows: parameters along the arc and across it, Newton's step, X, Y, Z, W of both ends of the fixed ruling and of the
# moving one, its derivatives, points as users see them but for their centre, positions on both rulings, Bernstein
# polynomials of the points' degree and of one less.
RUN, ACROSS, STEP, FIXED, MOVING, SLOPES, SPACE, PLACES, BASIS, LOWER, ROWS = 0, 1, 2, 3, 11, 19, 27, 30, 32, 64, 96
MOST_STEPS = 4


@uncounted
def _basis(degree, at, w):
    """Rows BASIS and LOWER at the parameters in row `at`, degree by degree."""
    x = at * LANES
    for i in range(LANES):
        w[BASIS * LANES + i] = 1.0
    for m in range(1, degree + 1):
        if m == degree:
            for i in range(degree * LANES):
                w[LOWER * LANES + i] = w[BASIS * LANES + i]
        top = (BASIS + m) * LANES
        for i in range(LANES):
            w[top + i] = w[x + i] * w[top - LANES + i]
        for k in range(m - 1, 0, -1):
            row = (BASIS + k) * LANES
            for i in range(LANES):
                w[row + i] += w[x + i] * (w[row - LANES + i] - w[row + i])
        for i in range(LANES):
            w[BASIS * LANES + i] *= 1.0 - w[x + i]


@uncounted
def _combine(forms, part, which, count, weights, to, w):
    """Rows `to` to `to` + 7: sums of rows of forms with weights."""
    a, b = to * LANES, weights * LANES
    for c in range(8):
        f = forms[part, which, 0, c]
        for i in range(LANES):
            w[a + c * LANES + i] = f * w[b + i]
    for k in range(1, count):
        b += LANES
        f0, f1, f2, f3 = (forms[part, which, k, 0], forms[part, which, k, 1], forms[part, which, k, 2],
                          forms[part, which, k, 3])  # fmt: skip
        f4, f5, f6, f7 = (forms[part, which, k, 4], forms[part, which, k, 5], forms[part, which, k, 6],
                          forms[part, which, k, 7])  # fmt: skip
        for i in range(LANES):
            x = w[b + i]
            w[a + i] += f0 * x
            w[a + LANES + i] += f1 * x
            w[a + 2 * LANES + i] += f2 * x
            w[a + 3 * LANES + i] += f3 * x
            w[a + 4 * LANES + i] += f4 * x
            w[a + 5 * LANES + i] += f5 * x
            w[a + 6 * LANES + i] += f6 * x
            w[a + 7 * LANES + i] += f7 * x


@uncounted
def _newton(w):
    """Row STEP: Newton's steps across, as in `curve_points.across`."""
    for i in range(LANES):
        p0, p1, p2, p3 = (w[FIXED * LANES + i], w[(FIXED + 1) * LANES + i], w[(FIXED + 2) * LANES + i],
                          w[(FIXED + 3) * LANES + i])  # fmt: skip
        p4, p5, p6, p7 = (w[(FIXED + 4) * LANES + i], w[(FIXED + 5) * LANES + i], w[(FIXED + 6) * LANES + i],
                          w[(FIXED + 7) * LANES + i])  # fmt: skip
        q0, q1, q2, q3 = (w[MOVING * LANES + i], w[(MOVING + 1) * LANES + i], w[(MOVING + 2) * LANES + i],
                          w[(MOVING + 3) * LANES + i])  # fmt: skip
        q4, q5, q6, q7 = (w[(MOVING + 4) * LANES + i], w[(MOVING + 5) * LANES + i], w[(MOVING + 6) * LANES + i],
                          w[(MOVING + 7) * LANES + i])  # fmt: skip
        l0, l1, l2 = p0 * p5 - p1 * p4, p0 * p6 - p2 * p4, p0 * p7 - p3 * p4
        l3, l4, l5 = p1 * p6 - p2 * p5, p1 * p7 - p3 * p5, p2 * p7 - p3 * p6
        a0, a1 = l5 * q5 - l4 * q6 + l3 * q7, -l5 * q4 + l2 * q6 - l1 * q7
        a2, a3 = l4 * q4 - l2 * q5 + l0 * q7, -l3 * q4 + l1 * q5 - l0 * q6
        b0, b1 = l5 * q1 - l4 * q2 + l3 * q3, -l5 * q0 + l2 * q2 - l1 * q3
        b2, b3 = l4 * q0 - l2 * q1 + l0 * q3, -l3 * q0 + l1 * q1 - l0 * q2
        value = q0 * a0 + q1 * a1 + q2 * a2 + q3 * a3
        change = w[SLOPES * LANES + i] * a0 + w[(SLOPES + 1) * LANES + i] * a1
        change += w[(SLOPES + 2) * LANES + i] * a2 + w[(SLOPES + 3) * LANES + i] * a3
        change -= w[(SLOPES + 4) * LANES + i] * b0 + w[(SLOPES + 5) * LANES + i] * b1
        change -= w[(SLOPES + 6) * LANES + i] * b2 + w[(SLOPES + 7) * LANES + i] * b3
        w[STEP * LANES + i] = -value / change


@uncounted
def _meet(w):
    """Rows SPACE and PLACES: middles of common perpendiculars, and positions on the fixed and the moving ruling."""
    for i in range(LANES):
        w0, w1 = 1.0 / w[(FIXED + 3) * LANES + i], 1.0 / w[(FIXED + 7) * LANES + i]
        w2, w3 = 1.0 / w[(MOVING + 3) * LANES + i], 1.0 / w[(MOVING + 7) * LANES + i]
        a0, a1, a2 = w[FIXED * LANES + i] * w0, w[(FIXED + 1) * LANES + i] * w0, w[(FIXED + 2) * LANES + i] * w0
        b0, b1, b2 = w[MOVING * LANES + i] * w2, w[(MOVING + 1) * LANES + i] * w2, w[(MOVING + 2) * LANES + i] * w2
        d0, d1 = w[(FIXED + 4) * LANES + i] * w1 - a0, w[(FIXED + 5) * LANES + i] * w1 - a1
        d2 = w[(FIXED + 6) * LANES + i] * w1 - a2
        e0, e1 = w[(MOVING + 4) * LANES + i] * w3 - b0, w[(MOVING + 5) * LANES + i] * w3 - b1
        e2 = w[(MOVING + 6) * LANES + i] * w3 - b2
        n0, n1, n2 = d1 * e2 - d2 * e1, d2 * e0 - d0 * e2, d0 * e1 - d1 * e0
        size = 1.0 / (n0 * n0 + n1 * n1 + n2 * n2)
        f0, f1, f2 = b0 - a0, b1 - a1, b2 - a2
        s = (f0 * (e1 * n2 - e2 * n1) + f1 * (e2 * n0 - e0 * n2) + f2 * (e0 * n1 - e1 * n0)) * size
        t = (f0 * (d1 * n2 - d2 * n1) + f1 * (d2 * n0 - d0 * n2) + f2 * (d0 * n1 - d1 * n0)) * size
        w[SPACE * LANES + i] = 0.5 * (a0 + s * d0 + b0 + t * e0)
        w[(SPACE + 1) * LANES + i] = 0.5 * (a1 + s * d1 + b1 + t * e1)
        w[(SPACE + 2) * LANES + i] = 0.5 * (a2 + s * d2 + b2 + t * e2)
        w[PLACES * LANES + i], w[(PLACES + 1) * LANES + i] = s, t


@uncounted
def on_arc_lanes(p, q, arc, w):
    """Set all rows for the points of an arc over row RUN, from guesses in row ACROSS; False where that does not go."""
    over_v = arc[OVER] == 1.0
    u, v = int(arc[ARC_U]), int(arc[ARC_V])
    fixed, i, moving, j = (q, v, p, u) if over_v else (p, u, q, v)
    n, m = fixed.shape[2] - 1, moving.shape[2] - 1
    _basis(n, RUN, w)
    _combine(fixed, i, VALUES, n + 1, BASIS, FIXED, w)
    last = np.inf
    for _ in range(MOST_STEPS):
        _basis(m, ACROSS, w)
        _combine(moving, j, VALUES, m + 1, BASIS, MOVING, w)
        _combine(moving, j, DERIVATIVES, m, LOWER, SLOPES, w)
        _newton(w)
        largest, low, high = 0.0, np.inf, -np.inf
        for k in range(LANES):
            step = w[STEP * LANES + k]
            y = w[ACROSS * LANES + k] + step
            w[ACROSS * LANES + k] = y
            largest, low, high = max(largest, abs(step)), min(low, y), max(high, y)
        if not (low >= arc[LOW] and high <= arc[HIGH] and largest < last):
            return False
        if largest < LAST_STEP:
            for c in range(8):
                for k in range(LANES):
                    w[(MOVING + c) * LANES + k] += w[STEP * LANES + k] * w[(SLOPES + c) * LANES + k]
            _meet(w)
            return True
        last = largest
    return False
