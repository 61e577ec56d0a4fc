"""Two moving ruled pieces over a box of (u, s, v, t, T), as linear models.

P(u, s, T) = (1 - s) x1 + s x2 - and Q(v, t, T) alike - with directrices x_i = X_i / W_i whose coefficients are given.
Rows: the difference P - Q, its derivatives by u, s, v, t (up to sign), and determinants of three of these, which vanish
where the contact set may have its first or last instant (Fritz John's condition on each stratum).
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.rulings.linear_models import (
    MORE,
    REST,
    ROUND,
    cross,
    difference,
    inner,
    product,
    quotient,
    slope_size,
    total,
)
from firstcontact.kernels.workspace import rows

# Rows of the workspace.  Of the system: P - Q, determinants; copies of them under elimination start at WORK.
GAP, MINORS, WORK = rows(0, 3, 7)
# Derivatives of P - Q: by u, s, v, t, three rows each, the latter two with the other sign.
BY_U, BY_S, BY_V, BY_T = rows(14, 17, 20, 23)
# Directrices of P, then of Q: points and derivatives; what one of them needs; crossed products; scratch.
POINTS, SLOPES, SURFACE = rows(26, 29, 6)
WEIGHT, SCRATCH, CROSSED, AXIS = rows(50, 52, 54, 60)
OFF = np.int64(61)
"""How far points of the surfaces, and their derivatives by u and s, v and t, may be from the coefficients'."""
ROWS, WIDTH = 62, 7
FREE_U, FREE_S, FREE_V, FREE_T = 1, 2, 4, 8
ALL_STRATA = -1
"""In place of the free parameters of a stratum: a box that stands for all strata it meets."""
FIRST, SECOND = rows(0, 1)
W_COMPONENT = np.int64(3)
U_COLUMN, V_COLUMN = rows(0, 2)
MOST_DEGREE = 31


@uncounted
def _polynomial(c, i_part, i_curve, i_component, column, box, w, table, row):
    """Models of a component X and of its derivative by the parameter in this column, in rows `row` and `row` + 1.

    The Taylor coefficients at the middle of the box are taken in `table`; what they lack is below the second terms.
    """
    n, m = c.shape[3], c.shape[4]
    x, t = 0.5 * (box[column, 0] + box[column, 1]), 0.5 * (box[4, 0] + box[4, 1])
    h = max(box[column, 1] - x, x - box[column, 0]) * MORE
    k = max(box[4, 1] - t, t - box[4, 0]) * MORE
    reach, far = abs(x) + h, abs(t) + k
    size, size_slope = 0.0, 0.0
    for i in range(n - 1, -1, -1):
        line = 0.0
        for j in range(m - 1, -1, -1):
            a = c[i_part, i_curve, i_component, i, j]
            table[i, j] = a
            line = line * far + abs(a)
        size_slope = size_slope * reach + size
        size = size * reach + line
    for i in range(n):
        for q in range(m - 1):
            for j in range(m - 2, q - 1, -1):
                table[i, j] += t * table[i, j + 1]
    for q in range(n - 1):
        for i in range(n - 2, q - 1, -1):
            for j in range(m):
                table[i, j] += x * table[i + 1, j]
    for j in range(7):
        w[row, j] = 0.0
        w[row + 1, j] = 0.0
    rest, rest_slope, power = 0.0, 0.0, 1.0
    for i in range(n):
        # table[i, j] h^i k^j; by the parameter: i table[i, j] h^(i - 1) k^j
        step = power
        for j in range(m):
            a = table[i, j]
            if i + j >= 2:
                rest += abs(a) * step * (h if i > 0 else 1.0)
            if i >= 1 and i - 1 + j >= 2:
                rest_slope += i * abs(a) * step
            step *= k
        if i >= 1:
            power *= h
    w[row, 0], w[row + 1, 0] = table[0, 0], table[1, 0] if n > 1 else 0.0
    if n > 1:
        w[row, 1 + column] = table[1, 0] * h
    if m > 1:
        w[row, 5] = table[0, 1] * k
    # a square runs over [0, 1]: its middle goes to the value
    if n > 2:
        w[row, 0] += 0.5 * table[2, 0] * h * h
        rest -= 0.5 * abs(table[2, 0]) * h * h
        w[row + 1, 1 + column] = 2.0 * table[2, 0] * h
    if m > 2:
        w[row, 0] += 0.5 * table[0, 2] * k * k
        rest -= 0.5 * abs(table[0, 2]) * k * k
    if n > 1 and m > 1:
        w[row + 1, 5] = table[1, 1] * k
    if n > 1 and m > 2:
        w[row + 1, 0] += 0.5 * table[1, 2] * k * k
        rest_slope -= 0.5 * abs(table[1, 2]) * k * k
    rounding = (2.0 * (n + m) + 8.0) * ROUND
    w[row, REST] = max(rest, 0.0) * MORE + rounding * size
    w[row + 1, REST] = max(rest_slope, 0.0) * MORE + rounding * size_slope


@uncounted
def _directrix(c, i_part, i_curve, column, box, w, table, points, slopes):
    """Models of x = X / W and of its derivative by the parameter; False where W may vanish."""
    _polynomial(c, i_part, i_curve, W_COMPONENT, column, box, w, table, WEIGHT)
    plain = w[WEIGHT, 0] == 1.0 and c.shape[3] * c.shape[4] > 0
    if plain:
        for k in range(1, 6):
            plain = plain and w[WEIGHT, k] == 0.0
        for i in range(c.shape[3]):
            for j in range(c.shape[4]):
                plain = plain and (i + j == 0 or c[i_part, i_curve, 3, i, j] == 0.0)
    for k in range(3):
        _polynomial(c, i_part, i_curve, k, column, box, w, table, SCRATCH)
        if plain:
            for j in range(7):
                w[points + k, j], w[slopes + k, j] = w[SCRATCH, j], w[SCRATCH + 1, j]
            continue
        if not quotient(w, points + k, SCRATCH, WEIGHT):
            return False
        # x' = (X' - x W') / W
        product(w, slopes + k, points + k, WEIGHT + 1)
        difference(w, slopes + k, SCRATCH + 1, slopes + k)
        if not quotient(w, slopes + k, slopes + k, WEIGHT):
            return False
    return True


@uncounted
def _ruled(c, i_part, column, box, w, table, points, by_u, by_s):
    """Models of a surface in rows `points` to `points` + 2, and of its derivatives; False where a weight may vanish."""
    for j in range(7):
        w[AXIS, j] = 0.0
    s = 0.5 * (box[column + 1, 0] + box[column + 1, 1])
    w[AXIS, 0] = s
    w[AXIS, 2 + column] = max(box[column + 1, 1] - s, s - box[column + 1, 0]) * MORE
    if not _directrix(c, i_part, FIRST, column, box, w, table, points, by_u):
        return False
    if not _directrix(c, i_part, SECOND, column, box, w, table, CROSSED, CROSSED + 3):
        return False
    for k in range(3):
        _mixed(w, points + k, CROSSED + k, by_s + k)
        _mixed(w, by_u + k, CROSSED + 3 + k, SCRATCH + 1)
    return True


@uncounted
def _mixed(w, first, second, way):
    """The model of (1 - s) x1 + s x2 in place of that of x1, s in row AXIS; way: becomes that of x2 - x1.

    The linear parts go by x1 + s (x2 - x1), for what both share cancels; remainders by their weights, so that near the
    end of a ruling what its other end lacks counts little.
    """
    near, far = w[first, REST], w[second, REST]
    w[first, REST], w[second, REST] = 0.0, 0.0
    difference(w, way, second, first)
    product(w, SCRATCH, AXIS, way)
    total(w, first, first, SCRATCH)
    s, h = w[AXIS, 0], slope_size(w, AXIS)
    w[first, REST] += ((abs(1.0 - s) + h) * near + (abs(s) + h) * far) * MORE
    w[way, REST] += (near + far) * MORE


@uncounted
def difference_models(p, i_part, q, j_part, box, w, table):
    """P - Q in the rows from GAP on, derivatives in the rows from BY_U on; False where a weight may vanish."""
    if not _ruled(p, i_part, U_COLUMN, box, w, table, POINTS, BY_U, BY_S):
        return False
    if not _ruled(q, j_part, V_COLUMN, box, w, table, SLOPES, BY_V, BY_T):
        return False
    for k in range(3):
        difference(w, GAP + k, POINTS + k, SLOPES + k)
        w[GAP + k, REST] += w[OFF, 0]
        for row in (BY_U, BY_S, BY_V, BY_T):
            w[row + k, REST] += w[OFF, 1]
    return True


@uncounted
def minor_models(free, w):
    """Determinants of the derivatives by the free parameters, in the rows from MINORS on; their number."""
    if free & FREE_U and free & FREE_S:
        cross(w, CROSSED, BY_U, BY_S, SCRATCH)
    if free & FREE_V and free & FREE_T:
        cross(w, CROSSED + 3, BY_V, BY_T, SCRATCH)
    n = 0
    if free & FREE_U and free & FREE_S:
        if free & FREE_V:
            inner(w, MINORS + n, CROSSED, BY_V, SCRATCH)
            n += 1
        if free & FREE_T:
            inner(w, MINORS + n, CROSSED, BY_T, SCRATCH)
            n += 1
    if free & FREE_V and free & FREE_T:
        if free & FREE_U:
            inner(w, MINORS + n, CROSSED + 3, BY_U, SCRATCH)
            n += 1
        if free & FREE_S:
            inner(w, MINORS + n, CROSSED + 3, BY_S, SCRATCH)
            n += 1
    return n
