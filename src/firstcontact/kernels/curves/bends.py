"""How fast an arc of an intersection curve may bend: bounds on the fourth derivative of its points, proved.

Along an arc P(x, s) = Q(y, t) with y, s and t functions of x.  The derivatives solve systems with one matrix,
J = (P_s, -Q_y, -Q_t).  Where the columns of J differ from those in the middle by lengths e_k, and the rows of the
inverse there have lengths r_k with r . e < 1, solutions for a right side of length b are at most r_k b / (1 - r . e):
so much b and the e_k times the solution come to.  The differences are bounded by derivatives of both surfaces on their
whole parts.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curves.points import BASIS, LOWER, SLOPES
from firstcontact.kernels.jit import kernel, uncounted

# Columns of the bounds of a part: lengths of the first four derivatives of both directrices, then of their difference.
ENDS, RULING, BOUNDS = 0, 4, 8
# Beyond roundings of the bounds themselves.
ROOM = 1.001
# Columns of J that differ by so much might make it singular at 1; how derivatives may grow is guessed so many times,
# each time more than what was found.
LARGEST_CHANGE, MOST_TRIES, ALLOWANCE = 0.75, 6, 1.3


@kernel
def derivative_bounds(forms, known):
    """Set the bounds of all parts.  forms: as of `curve_points.evaluate`, weights positive."""
    n = forms.shape[2] - 1
    rows = np.empty((n + 1, 4))
    for part in range(forms.shape[0]):
        bounds = known[part]
        alike = True
        for k in range(n + 1):
            alike = alike and forms[part, 0, k, 3] == forms[part, 0, k, 7]
        for k in range(BOUNDS):
            bounds[k] = 0.0
        for which in range(2):
            for k in range(n + 1):
                for c in range(4):
                    rows[k, c] = forms[part, 0, k, 4 * which + c]
            _curve(rows, n, ENDS, bounds)
        if alike:
            for k in range(n + 1):
                for c in range(3):
                    rows[k, c] = forms[part, 0, k, 4 + c] - forms[part, 0, k, c]
                rows[k, 3] = forms[part, 0, k, 3]
            _curve(rows, n, RULING, bounds)
        else:
            for k in range(4):
                bounds[RULING + k] = 2.0 * bounds[ENDS + k]


@uncounted
def _curve(rows, n, first, bounds):
    """Raise three bounds to those of a rational curve; its rows are changed.

    p = N / w: w p^(k) = N^(k) - sum of binomial(k, j) w^(j) p^(k - j), with N about a point of the curve.
    """
    middle = n // 2
    w = rows[middle, 3]
    x, y, z = rows[middle, 0] / w, rows[middle, 1] / w, rows[middle, 2] / w
    least, far = np.inf, 0.0
    for k in range(n + 1):
        w = rows[k, 3]
        rows[k, 0] -= x * w
        rows[k, 1] -= y * w
        rows[k, 2] -= z * w
        least = min(least, w)
        far = max(far, np.sqrt(rows[k, 0] ** 2 + rows[k, 1] ** 2 + rows[k, 2] ** 2) / w)
    w1 = w2 = w3 = d1 = d2 = d3 = d4 = 0.0
    factor = 1.0
    for order in range(1, min(n, 4) + 1):
        factor *= n - order + 1
        length = weight = 0.0
        for k in range(n + 1 - order):
            for c in range(4):
                rows[k, c] = rows[k + 1, c] - rows[k, c]
            length = max(length, np.sqrt(rows[k, 0] ** 2 + rows[k, 1] ** 2 + rows[k, 2] ** 2))
            weight = max(weight, abs(rows[k, 3]))
        length, weight = factor * length, factor * weight
        if order == 1:
            w1 = weight
            d1 = (length + w1 * far) / least
        elif order == 2:
            w2 = weight
            d2 = (length + 2.0 * w1 * d1 + w2 * far) / least
        elif order == 3:
            w3 = weight
            d3 = (length + 3.0 * (w1 * d2 + w2 * d1) + w3 * far) / least
        else:
            d4 = (length + 4.0 * (w1 * d3 + w3 * d1) + 6.0 * w2 * d2 + weight * far) / least
    if n < 2:
        d2 = 2.0 * w1 * d1 / least
    if n < 3:
        d3 = 3.0 * (w1 * d2 + w2 * d1) / least
    if n < 4:
        d4 = (4.0 * (w1 * d3 + w3 * d1) + 6.0 * w2 * d2) / least
    bounds[first], bounds[first + 1] = max(bounds[first], ROOM * d1), max(bounds[first + 1], ROOM * d2)
    bounds[first + 2], bounds[first + 3] = max(bounds[first + 2], ROOM * d3), max(bounds[first + 3], ROOM * d4)


@uncounted
def _second(forms, part, x, row, r):
    """Row `row` of r: the second derivatives of both ends of the ruling at x, homogeneous; row LOWER is scratch."""
    n = forms.shape[2] - 1
    for c in range(8):
        r[row, c] = 0.0
    if n < 2:
        return
    y = 1.0 - x
    r[LOWER, 0] = n * (n - 1.0)
    for m in range(1, n - 1):
        r[LOWER, m] = x * r[LOWER, m - 1]
        for k in range(m - 1, 0, -1):
            r[LOWER, k] = y * r[LOWER, k] + x * r[LOWER, k - 1]
        r[LOWER, 0] *= y
    for k in range(n - 1):
        w = r[LOWER, k]
        for c in range(8):
            r[row, c] += w * (forms[part, 0, k, c] - 2.0 * forms[part, 0, k + 1, c] + forms[part, 0, k + 2, c])


@uncounted
def _local(f, second, position, r):
    """Lengths at a ruling: of the second derivatives of its ends, and the first two of their difference.

    Row `second` then holds, as vectors, the second derivative at a position on the ruling and the first one of the
    difference.
    """
    g = SLOPES + f
    v, w = 1.0 / r[f, 3], 1.0 / r[f, 7]
    v1, w1, v2, w2 = r[g, 3] * v, r[g, 7] * w, r[second, 3] * v, r[second, 7] * w
    a = b = d = e = 0.0
    for c in range(3):
        p, q = r[f, c] * v, r[f, 4 + c] * w
        p1, q1 = r[g, c] * v - p * v1, r[g, 4 + c] * w - q * w1
        p2 = r[second, c] * v - 2.0 * p1 * v1 - p * v2
        q2 = r[second, 4 + c] * w - 2.0 * q1 * w1 - q * w2
        a, b, d, e = a + p2 * p2, b + q2 * q2, d + (q1 - p1) ** 2, e + (q2 - p2) ** 2
        r[second, c], r[second, 4 + c] = (1.0 - position) * p2 + position * q2, q1 - p1
    return np.sqrt(max(a, b)), np.sqrt(d), np.sqrt(e)


@uncounted
def fourth_derivative(p, part_f, x, q, part_m, y, f, m, of_f, of_m, reach, s, t, r):
    """A bound on the fourth derivative of points by x, within `reach` of a point of an arc; infinite if none is found.

    p, q: forms of the fixed side and of the one that moves; f, m: rows of r with the rulings at x and y, their
    derivatives behind; of_f, of_m: bounds of their parts; s, t: the positions of the point on them.  All on the arc lie
    between the ends of both rulings.
    """
    a, b = 1.0 / r[f, 3], 1.0 / r[f, 7]
    c, d = 1.0 / r[m, 3], 1.0 / r[m, 7]
    g, h = SLOPES + f, SLOPES + m
    a3, b3, c3, d3 = r[g, 3] * a, r[g, 7] * b, r[h, 3] * c, r[h, 7] * d
    # the derivative by x, both rulings, the derivative by y
    p0, p1, p2 = r[f, 0] * a, r[f, 1] * a, r[f, 2] * a
    o0, o1, o2 = r[f, 4] * b, r[f, 5] * b, r[f, 6] * b
    x0 = (1.0 - s) * (r[g, 0] * a - p0 * a3) + s * (r[g, 4] * b - o0 * b3)
    x1 = (1.0 - s) * (r[g, 1] * a - p1 * a3) + s * (r[g, 5] * b - o1 * b3)
    x2 = (1.0 - s) * (r[g, 2] * a - p2 * a3) + s * (r[g, 6] * b - o2 * b3)
    i0, i1, i2 = o0 - p0, o1 - p1, o2 - p2
    p0, p1, p2 = r[m, 0] * c, r[m, 1] * c, r[m, 2] * c
    o0, o1, o2 = r[m, 4] * d, r[m, 5] * d, r[m, 6] * d
    j0 = (1.0 - t) * (r[h, 0] * c - p0 * c3) + t * (r[h, 4] * d - o0 * d3)
    j1 = (1.0 - t) * (r[h, 1] * c - p1 * c3) + t * (r[h, 5] * d - o1 * d3)
    j2 = (1.0 - t) * (r[h, 2] * c - p2 * c3) + t * (r[h, 6] * d - o2 * d3)
    k0, k1, k2 = o0 - p0, o1 - p1, o2 - p2
    # unknowns are measured in lengths, so the columns of J are units
    i, j, k = (np.sqrt(i0 * i0 + i1 * i1 + i2 * i2), np.sqrt(j0 * j0 + j1 * j1 + j2 * j2),
               np.sqrt(k0 * k0 + k1 * k1 + k2 * k2))  # fmt: skip
    i0, i1, i2, j0, j1, j2, k0, k1, k2 = i0 / i, i1 / i, i2 / i, j0 / j, j1 / j, j2 / j, k0 / k, k1 / k, k2 / k
    u0, u1, u2 = j1 * k2 - j2 * k1, j2 * k0 - j0 * k2, j0 * k1 - j1 * k0
    v0, v1, v2 = k1 * i2 - k2 * i1, k2 * i0 - k0 * i2, k0 * i1 - k1 * i0
    w0, w1, w2 = i1 * j2 - i2 * j1, i2 * j0 - i0 * j2, i0 * j1 - i1 * j0
    inverse = 1.0 / (i0 * u0 + i1 * u1 + i2 * u2)
    # what an unknown is at most for a right side of length 1
    of_s, of_y, of_t = (ROOM * abs(inverse) * np.sqrt(u0 * u0 + u1 * u1 + u2 * u2),
                        ROOM * abs(inverse) * np.sqrt(v0 * v0 + v1 * v1 + v2 * v2),
                        ROOM * abs(inverse) * np.sqrt(w0 * w0 + w1 * w1 + w2 * w2))  # fmt: skip
    s1, y1, t1 = (-(x0 * u0 + x1 * u1 + x2 * u2) * inverse, (x0 * v0 + x1 * v1 + x2 * v2) * inverse,
                  (x0 * w0 + x1 * w1 + x2 * w2) * inverse)  # fmt: skip
    ds, dy, dt = abs(s1), abs(y1), abs(t1)
    _second(p, part_f, x, BASIS, r)
    p_xx, p_xs, p_xxs = _local(f, BASIS, s, r)
    s1, y1, t1 = s1 / i, y1 / j, t1 / k
    x0, x1, x2 = (r[BASIS, 0] + 2.0 * s1 * r[BASIS, 4], r[BASIS, 1] + 2.0 * s1 * r[BASIS, 5],
                  r[BASIS, 2] + 2.0 * s1 * r[BASIS, 6])  # fmt: skip
    p_xx, p_xxs = p_xx + reach * of_f[ENDS + 2], p_xxs + reach * of_f[RULING + 2]
    p_xs, p_xxs, p_xxxs = (p_xs + reach * p_xxs) / i, p_xxs / i, of_f[RULING + 2] / i
    _second(q, part_m, y, BASIS, r)
    q_yy, q_yt, q_yyt = _local(m, BASIS, t, r)
    x0 -= y1 * (y1 * r[BASIS, 0] + 2.0 * t1 * r[BASIS, 4])
    x1 -= y1 * (y1 * r[BASIS, 1] + 2.0 * t1 * r[BASIS, 5])
    x2 -= y1 * (y1 * r[BASIS, 2] + 2.0 * t1 * r[BASIS, 6])
    # second derivatives in the middle
    two_s, two_y, two_t = (ROOM * abs((x0 * u0 + x1 * u1 + x2 * u2) * inverse),
                           ROOM * abs((x0 * v0 + x1 * v1 + x2 * v2) * inverse),
                           ROOM * abs((x0 * w0 + x1 * w1 + x2 * w2) * inverse))  # fmt: skip
    q_yyy, q_yyyy, q_yyyt = of_m[ENDS + 2] / j**3, of_m[ENDS + 3] / j**4, of_m[RULING + 2] / (j**3 * k)
    q_yy, q_yt, q_yyt = q_yy / j**2, q_yt / (j * k), q_yyt / (j**2 * k)
    # As long as derivatives of unknowns grow by no more than `growth` times what these are at most, the unknowns change
    # by no more than `far`, columns of J by `e`, and the derivatives by `grown` times the same: that is to be no more.
    growth = 0.0
    for _ in range(MOST_TRIES):
        far_s, far_y, far_t = reach * (ds + of_s * growth), reach * (dy + of_y * growth), reach * (dt + of_t * growth)
        q_yyt_far = q_yyt + far_y * q_yyyt
        q_yt_far, q_yy_far = q_yt + far_y * q_yyt_far, q_yy + far_y * q_yyy
        e0, e1, e2 = p_xs * reach, q_yy_far * far_y + q_yt_far * far_t, q_yt_far * far_y
        change = of_s * e0 + of_y * e1 + of_t * e2
        if not change < LARGEST_CHANGE:
            return np.inf
        more = 1.0 / (1.0 - change)
        grown = more * (p_xx * reach + p_xs * far_s + e0 * ds + e1 * dy + e2 * dt)
        if grown <= growth:
            break
        growth = ALLOWANCE * grown
    if not grown <= growth:
        return np.inf
    q_yy, q_yt, q_yyt = q_yy_far, q_yt_far, q_yyt_far
    of_s, of_y, of_t = more * of_s, more * of_y, more * of_t
    here_s, here_y, here_t = two_s, two_y, two_t
    two_s = two_y = two_t = three_s = three_y = three_t = np.inf
    grown /= more
    more_s, more_y, more_t = ds + of_s * grown, dy + of_y * grown, dt + of_t * grown
    # derivatives known in the middle change by no more than the next ones tell
    for _ in range(3):
        two = p_xx + 2.0 * p_xs * more_s + more_y * (q_yy * more_y + 2.0 * q_yt * more_t)
        two_s, two_y, two_t = min(two_s, of_s * two), min(two_y, of_y * two), min(two_t, of_t * two)
        three = of_f[ENDS + 2] + 3.0 * (p_xxs * more_s + p_xs * two_s)
        three += more_y * more_y * (q_yyy * more_y + 3.0 * q_yyt * more_t)
        three += 3.0 * (two_y * (q_yy * more_y + q_yt * more_t) + two_t * q_yt * more_y)
        three_s, three_y, three_t = of_s * three, of_y * three, of_t * three
        two_s, two_y = min(two_s, here_s + reach * three_s), min(two_y, here_y + reach * three_y)
        two_t = min(two_t, here_t + reach * three_t)
        more_s, more_y = min(more_s, ds + reach * two_s), min(more_y, dy + reach * two_y)
        more_t = min(more_t, dt + reach * two_t)
    own = of_f[ENDS + 3] + 4.0 * p_xxxs * more_s + 6.0 * p_xxs * two_s + 4.0 * p_xs * three_s
    four = own + more_y * more_y * (q_yyyy * more_y * more_y + 6.0 * q_yyy * two_y)
    four += q_yy * (3.0 * two_y * two_y + 4.0 * more_y * three_y)
    four += 4.0 * more_t * (q_yyyt * more_y**3 + 3.0 * q_yyt * more_y * two_y + q_yt * three_y)
    four += 6.0 * two_t * (q_yyt * more_y * more_y + q_yt * two_y) + 4.0 * three_t * q_yt * more_y
    return ROOM * (own + (1.0 + e0) * of_s * four)
