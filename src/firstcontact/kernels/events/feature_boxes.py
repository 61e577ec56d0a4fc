"""Parts of features over short times: ranges and linear models of forms on them, membership, narrowing.

A feature's chart is X(u, v) = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2, homogeneous points with weight > 0, or, of
ruled surfaces, of any degree in u and linear in v.  A box is a range of u, v and s (the time within a slab).  Over it a
form q = X^T Q(s) X is
    value + slopes.(a, b, s) + [-rest, rest],  -1 <= a, b, s <= 1,
and so are half its derivatives by a and b, which vanish where a feature touches a surface (Choi et al. 2014, table 1;
the equations in parameters are re-derived).

Charts of surfaces that deform have polynomials in time for coefficients.  With X at the middle time, at time s there is
X + s V + R, its drift V to first order and a rest R: X^T Q X gains 2 s V^T Q X, and all that is of higher order joins
the rest of its model.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import rows

U = 2.0**-53
# Of a form on a box, per unit of the largest coordinates and the sum of its coefficients: points are off by eight
# roundings, a sum of sixteen products adds as many.
NOISE = 64.0 * U
MORE = 1.0 + 1e-12
# Columns of a chart: six coefficients of four coordinates, error of the points.  Of charts that are not quadratic the
# degree n in u (else 0), and for each power of u the coefficients of 1 and of v.  Those that deform have the degree m
# in (time - middle) per half, and m more such blocks for its powers, each as wide as the first (in WIDE); rounding
# errors of points and of their two derivatives; bounds of second derivatives by that time, of points and of these.
ERROR, DEGREE, TIMES, WIDE, MIDDLE_TIME, PER_HALF, OFF, OFF_U, OFF_V = 24, 25, 26, 27, 28, 29, 30, 31, 32
BEND, BEND_U, BEND_V, POWERS = 33, 37, 41, 45
MOST_DEGREE = 60
# Rows of the workspace z.  Models of the equations of a pair, in this order; spare ones.
ZEROTH, FIRST_ROW, SPARE = rows(0, 1, 3)
# The points of a box: X and its derivatives at the middle times half-widths; bounds of first and second order parts, of
# all, and of the derivatives; in the last row: sizes of X and of its two derivatives for rounding errors.
MID, BY_U, BY_V, UU, UV, VV, FIRST, SECOND, ALL, ALL_U, ALL_V, SIZES = rows(*range(6, 18))
# Images of points under a form: Q X and of its derivatives, h Q' X; bounds h |Q'| (E + D), rest |X|.
IMAGE, IMAGE_U, IMAGE_V, IMAGE_UU, IMAGE_UV, IMAGE_VV, MOVED, DRIFT, LOOSE = rows(*range(18, 27))
# What time, a and b have in the uncertainty; the slab; ranges of a, b and s that hold all zeros; from the last two on
# three models for each form whose sign is open, of the other body and of the own one.
SHARES, SLAB, RANGES, THERE, HERE = rows(27, 28, 29, 32, 32 + 3 * 64)
# Of charts that are not quadratic: bounds of what is beyond second order, of it and of its two derivatives, and whether
# there is anything; scratch: powers of u, alone and times v.
BEYOND, BEYOND_U, BEYOND_V, BENT, ALONE, TIMES_V = rows(416, 417, 418, 419, 420, 421 + MOST_DEGREE)
# Of charts that deform: how far X and its derivatives at the middle of the box come by the end of its time to first
# order, and bounds of how much farther any of the box comes.
DRIFTS, DRIFTS_U, DRIFTS_V, STRAYS, STRAYS_U, STRAYS_V = rows(*range(422 + 2 * MOST_DEGREE, 428 + 2 * MOST_DEGREE))
ROWS, WIDTH = 428 + 2 * MOST_DEGREE, 12
# Columns of a model: value, slopes by a, b, s, rest; shares of the uncertainty by time, a, b; size of its terms.
VALUE, SLOPE_U, SLOPE_V, SLOPE_T, REST, SHARE_T, SHARE_U, SHARE_V, TERMS = rows(*range(9))
# Part of the size of its terms below which what is open of a model counts as rounding errors.
ROUNDED = 1e-12
INSIDE, OUTSIDE = rows(1, 2)
# No derivatives, all.
PLAIN, DEEPEST = rows(0, 2)
# Parts of a row of the table of forms: value and slope in time, bound of the rest; then the sum of all sizes,
# whether it is a quadric, and whether it is of another chart, so that its models are made with the box.
ABOUT = 3
SUM_OF_SIZES, CURVED, GIVEN = rows(0, 1, 2)
# Slots of the stack: bits of the forms known to be negative on the box, known to be positive, and found open.
NEGATIVE, POSITIVE, OPEN = rows(317, 318, 319)
STACK = 320
# Steps of a compiled tree.
LEAF, NOT, AND, OR, UNLESS_IN, UNLESS_OUT = rows(*range(6))


@uncounted
def place_box(charts, k, u, hu, v, hv, t, ht, z):
    """The points of the box at times t +- ht; False where their weight may vanish."""
    is_bent = charts.shape[1] > POWERS and charts[k, DEGREE] > 0.0
    deforms = is_bent and charts[k, TIMES] > 0.0
    if is_bent:
        s0, s1, s2 = _place_ruled(charts, k, u, hu, v, hv, (t - charts[k, MIDDLE_TIME]) * charts[k, PER_HALF], z)
    else:
        s0, s1, s2 = _place_quadratic(charts, k, u, hu, v, hv, z)
    z[BENT, 0], z[BENT, 1] = 1.0 if is_bent else 0.0, 1.0 if deforms else 0.0
    if deforms:
        _place_drift(charts, k, u, hu, v, hv, t, ht, z)
    if z[MID, 3] < 0.0:
        for r in range(MID, VV + 1):
            for i in range(4):
                z[r, i] = -z[r, i]
        if deforms:
            for r in range(DRIFTS, DRIFTS_V + 1):
                for i in range(4):
                    z[r, i] = -z[r, i]
    for i in range(4):
        z[FIRST, i] = abs(z[BY_U, i]) + abs(z[BY_V, i])
        z[SECOND, i] = abs(z[UU, i]) + abs(z[UV, i]) + abs(z[VV, i])
        z[ALL_U, i] = abs(z[BY_U, i]) + 2.0 * abs(z[UU, i]) + abs(z[UV, i])
        z[ALL_V, i] = abs(z[BY_V, i]) + 2.0 * abs(z[VV, i]) + abs(z[UV, i])
        if is_bent:
            # the derivatives of what is beyond are within twice its bound here, like those of squares
            z[SECOND, i] += max(z[BEYOND, i], 0.5 * z[BEYOND_U, i], 0.5 * z[BEYOND_V, i])
            z[ALL_U, i] += z[BEYOND_U, i]
            z[ALL_V, i] += z[BEYOND_V, i]
        if deforms:
            far, far_u, far_v = _drifted(z, DRIFTS, i), _drifted(z, DRIFTS_U, i), _drifted(z, DRIFTS_V, i)
            z[SECOND, i] += max(far, 0.5 * far_u, 0.5 * far_v)
            z[ALL_U, i] += far_u
            z[ALL_V, i] += far_v
        z[ALL, i] = abs(z[MID, i]) + z[FIRST, i] + z[SECOND, i]
    z[SIZES, 0], z[SIZES, 1], z[SIZES, 2] = s0, s1, s2
    z[SIZES, 3] = charts[k, ERROR]
    return z[MID, 3] > z[FIRST, 3] + z[SECOND, 3] + NOISE * s0


@uncounted
def _place_quadratic(charts, k, u, hu, v, hv, z):
    """Rows of X and its derivatives; sizes as in the row SIZES."""
    s0, s1, s2 = 0.0, 0.0, 0.0
    mu, mv = abs(u) + hu, abs(v) + hv
    for i in range(4):
        c0, c1, c2, c3, c4, c5 = (
            charts[k, i], charts[k, 4 + i], charts[k, 8 + i], charts[k, 12 + i], charts[k, 16 + i], charts[k, 20 + i],
        )  # fmt: skip
        z[MID, i] = c0 + u * (c1 + c3 * u + c4 * v) + v * (c2 + c5 * v)
        z[BY_U, i] = hu * (c1 + 2.0 * c3 * u + c4 * v)
        z[BY_V, i] = hv * (c2 + 2.0 * c5 * v + c4 * u)
        z[UU, i], z[UV, i], z[VV, i] = hu * hu * c3, hu * hv * c4, hv * hv * c5
        b1, b2, b3, b4, b5 = abs(c1), abs(c2), abs(c3), abs(c4), abs(c5)
        s0 = max(s0, abs(c0) + mu * (b1 + b3 * mu + b4 * mv) + mv * (b2 + b5 * mv))
        s1 = max(s1, hu * (b1 + 2.0 * b3 * mu + b4 * mv))
        s2 = max(s2, hv * (b2 + 2.0 * b5 * mv + b4 * mu))
    return s0, s1, s2


@uncounted
def _drifted(z, row, i):
    """Bound of how far a box's points, or their derivatives, come in its time."""
    return abs(z[row, i]) + z[row + STRAYS - DRIFTS, i]


@uncounted
def _at_time(charts, k, column, times, wide, t):
    """A coefficient at a time in the chart's own measure."""
    value = charts[k, column + times * wide]
    for q in range(times - 1, -1, -1):
        value = value * t + charts[k, column + q * wide]
    return value


@uncounted
def _rate_at(charts, k, column, times, wide, t):
    """Its derivative."""
    value = 0.0
    for q in range(times, 0, -1):
        value = value * t + q * charts[k, column + q * wide]
    return value


@uncounted
def _place_drift(charts, k, u, hu, v, hv, t, ht, z):
    """Rows of the drift over t +- ht; at the middle of the box, and how much farther all of it may come."""
    n, times, wide = int(charts[k, DEGREE]), int(charts[k, TIMES]), int(charts[k, WIDE])
    per = charts[k, PER_HALF]
    at, h = (t - charts[k, MIDDLE_TIME]) * per, ht * per
    pad = 16.0 * U * ((abs(t) + abs(charts[k, MIDDLE_TIME])) * abs(per) + abs(h))
    mu, mv, far = abs(u) + hu, abs(v) + hv, 0.5 * (abs(h) + pad) ** 2
    for i in range(4):
        p, by_u, by_v, most, most_u, most_v, most_uv, bent = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(n, -1, -1):
            column = POWERS + 8 * j + i
            a = _rate_at(charts, k, column, times, wide, at)
            b = _rate_at(charts, k, column + 4, times, wide, at)
            c, size = a + v * b, abs(a) + mv * abs(b)
            by_u = by_u * u + p
            p = p * u + c
            by_v = by_v * u + b
            bent = bent * mu + 2.0 * most_u
            most_u = most_u * mu + most
            most = most * mu + size
            most_uv = most_uv * mu + most_v
            most_v = most_v * mu + abs(b)
        z[DRIFTS, i], z[DRIFTS_U, i], z[DRIFTS_V, i] = h * p, h * hu * by_u, h * hv * by_v
        stray = abs(h) * (hu * most_u + hv * most_v) + pad * most + far * charts[k, BEND + i] + charts[k, OFF]
        stray_u = abs(h) * (hu * bent + hv * most_uv) + pad * most_u + far * charts[k, BEND_U + i] + charts[k, OFF_U]
        stray_v = abs(h) * hu * most_uv + pad * most_v + far * charts[k, BEND_V + i] + charts[k, OFF_V]
        z[STRAYS, i], z[STRAYS_U, i], z[STRAYS_V, i] = MORE * stray, MORE * hu * stray_u, MORE * hv * stray_v


@uncounted
def _place_ruled(charts, k, u, hu, v, hv, t, z):
    """Rows of X, its derivatives and what is beyond, of a chart linear in v; sizes as in the row SIZES.

    t: the time in the chart's own measure.
    """
    n, times, wide = int(charts[k, DEGREE]), int(charts[k, TIMES]), int(charts[k, WIDE])
    s0, s1, s2 = 0.0, 0.0, 0.0
    mu, mv = abs(u) + hu, abs(v) + hv
    for i in range(4):
        whole, slope, across = 0.0, 0.0, 0.0
        for j in range(n, -1, -1):
            a, b = charts[k, POWERS + 8 * j + i], charts[k, POWERS + 8 * j + 4 + i]
            if times > 0:
                a = _at_time(charts, k, POWERS + 8 * j + i, times, wide, t)
                b = _at_time(charts, k, POWERS + 8 * j + 4 + i, times, wide, t)
            z[ALONE + j, i], z[TIMES_V + j, i] = a + v * b, hv * b
            slope = slope * mu + whole
            whole = whole * mu + abs(a) + mv * abs(b)
            across = across * mu + hv * abs(b)
        s0, s1, s2 = max(s0, whole), max(s1, hu * slope), max(s2, across)
        for q in range(n):
            for j in range(n - 1, q - 1, -1):
                z[ALONE + j, i] += u * z[ALONE + j + 1, i]
                z[TIMES_V + j, i] += u * z[TIMES_V + j + 1, i]
        z[MID, i], z[BY_U, i], z[BY_V, i] = z[ALONE, i], hu * z[ALONE + 1, i], z[TIMES_V, i]
        z[UV, i], z[UU, i], z[VV, i] = hu * z[TIMES_V + 1, i], 0.0, 0.0
        rest, rest_u, rest_v, power = 0.0, 0.0, 0.0, hu
        for j in range(2, n + 1):
            power *= hu
            a, b = abs(z[ALONE + j, i]) * power, abs(z[TIMES_V + j, i]) * power
            if j == 2:
                z[UU, i] = z[ALONE + 2, i] * power
                a = 0.0
            rest, rest_u, rest_v = rest + a + b, rest_u + j * (a + b), rest_v + b
        z[BEYOND, i], z[BEYOND_U, i], z[BEYOND_V, i] = rest * MORE, rest_u * MORE, rest_v * MORE
    # points are off by 3 n + 7 roundings, not by eight: twice as much in a form that is a sum of sixteen products
    more = max(1.0, (6.0 * n + 46.0) / 64.0)
    return more * s0, more * s1, more * s2


@uncounted
def _dot(z, i, j):
    return z[i, 0] * z[j, 0] + z[i, 1] * z[j, 1] + z[i, 2] * z[j, 2] + z[i, 3] * z[j, 3]


@uncounted
def _plane_model(table, f, s, hs, z, deep, row):
    g, gu, gv, uu, uv, vv, gt, mixed, rest, mixed_u, rest_u, mixed_v, rest_v = (
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    )  # fmt: skip
    total = 0.0
    for i in range(4):
        n, d, r = table[f, 0, i] + s * table[f, 1, i], hs * table[f, 1, i], table[f, 2, i]
        g += n * z[MID, i]
        gu += n * z[BY_U, i]
        gv += n * z[BY_V, i]
        uu += n * z[UU, i]
        uv += n * z[UV, i]
        vv += n * z[VV, i]
        gt += d * z[MID, i]
        size = abs(d)
        mixed += size * (z[FIRST, i] + z[SECOND, i]) + r * z[ALL, i]
        total += abs(table[f, 0, i]) + abs(table[f, 1, i]) + r
        if deep > 0:
            mixed_u += 2.0 * size * z[SECOND, i] + r * z[ALL_U, i]
            mixed_v += 2.0 * size * z[SECOND, i] + r * z[ALL_V, i]
            rest_u += d * z[BY_U, i]
            rest_v += d * z[BY_V, i]
    noise = total * (NOISE * z[SIZES, 0] + z[SIZES, 3])
    z[row, VALUE] = g + 0.5 * (uu + vv)
    z[row, SLOPE_U], z[row, SLOPE_V], z[row, SLOPE_T] = gu, gv, gt
    rest = 0.5 * (abs(uu) + abs(vv)) + abs(uv) + mixed
    z[row, REST] = rest * (1.0 + 1e-12) + noise
    z[row, SHARE_T] = abs(gt) + mixed
    z[row, SHARE_U] = abs(gu) + abs(uu) + abs(uv)
    z[row, SHARE_V] = abs(gv) + abs(vv) + abs(uv)
    z[row, TERMS] = total * z[SIZES, 0]
    # derivatives by a and b of N.X
    if deep > 0:
        z[row + 1, TERMS], z[row + 2, TERMS] = total * z[SIZES, 1], total * z[SIZES, 2]
        z[row + 1, VALUE], z[row + 1, SLOPE_U], z[row + 1, SLOPE_V], z[row + 1, SLOPE_T] = gu, 2.0 * uu, uv, rest_u
        z[row + 1, REST] = mixed_u * (1.0 + 1e-12) + total * NOISE * z[SIZES, 1]
        z[row + 1, SHARE_T], z[row + 1, SHARE_U], z[row + 1, SHARE_V] = abs(rest_u) + mixed_u, 2.0 * abs(uu), abs(uv)
    if deep > 1:
        z[row + 2, VALUE], z[row + 2, SLOPE_U], z[row + 2, SLOPE_V], z[row + 2, SLOPE_T] = gv, uv, 2.0 * vv, rest_v
        z[row + 2, REST] = mixed_v * (1.0 + 1e-12) + total * NOISE * z[SIZES, 2]
        z[row + 2, SHARE_T], z[row + 2, SHARE_U], z[row + 2, SHARE_V] = abs(rest_v) + mixed_v, abs(uv), 2.0 * abs(vv)


@uncounted
def _quadric_model(table, f, s, hs, z, deep, row):
    total = 0.0
    for i in range(4):
        y0, y1, y2, y3, y4, y5, y6, y7, y8 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(4):
            k = 4 * i + j
            d, r = table[f, 1, k], table[f, 2, k]
            q = table[f, 0, k] + s * d
            total += abs(table[f, 0, k]) + abs(d) + r
            y0 += q * z[MID, j]
            y1 += q * z[BY_U, j]
            y2 += q * z[BY_V, j]
            y3 += d * z[MID, j]
            y4 += q * z[UU, j]
            y7 += q * z[UV, j]
            y8 += q * z[VV, j]
            y5 += abs(d) * (z[FIRST, j] + z[SECOND, j])
            y6 += r * z[ALL, j]
        z[IMAGE, i], z[IMAGE_U, i], z[IMAGE_V, i], z[MOVED, i] = y0, y1, y2, hs * y3
        z[IMAGE_UU, i], z[IMAGE_UV, i], z[IMAGE_VV, i] = y4, y7, y8
        z[DRIFT, i], z[LOOSE, i] = hs * y5, y6
    g, gu, gv, gt = _dot(z, MID, IMAGE), _dot(z, BY_U, IMAGE), _dot(z, BY_V, IMAGE), _dot(z, MID, MOVED)
    uu = _dot(z, BY_U, IMAGE_U) + 2.0 * _dot(z, UU, IMAGE)
    vv = _dot(z, BY_V, IMAGE_V) + 2.0 * _dot(z, VV, IMAGE)
    uv = _dot(z, BY_U, IMAGE_V) + _dot(z, UV, IMAGE)
    ut, vt = _dot(z, BY_U, MOVED), _dot(z, BY_V, MOVED)
    # third order: a^3, a^2 b, a b^2, b^3, halved
    uuu, vvv = _dot(z, UU, IMAGE_U), _dot(z, VV, IMAGE_V)
    uuv1, uuv2 = _dot(z, UU, IMAGE_V), _dot(z, UV, IMAGE_U)
    uvv1, uvv2 = _dot(z, UV, IMAGE_V), _dot(z, VV, IMAGE_U)
    fourth = abs(_dot(z, UU, IMAGE_UU)) + 2.0 * abs(_dot(z, UU, IMAGE_UV)) + abs(_dot(z, VV, IMAGE_VV))
    fourth += abs(_dot(z, UV, IMAGE_UV) + 2.0 * _dot(z, UU, IMAGE_VV)) + 2.0 * abs(_dot(z, UV, IMAGE_VV))
    high_u, high_v = abs(uuu) + abs(uuv1 + uuv2), abs(vvv) + abs(uvv1 + uvv2)
    late, still = 0.0, 0.0
    for i in range(4):
        late += 2.0 * z[SECOND, i] * abs(z[MOVED, i]) + z[ALL, i] * z[LOOSE, i]
        late += (z[FIRST, i] + z[SECOND, i]) * z[DRIFT, i]
    mixed = 2.0 * (abs(ut) + abs(vt)) + late
    still = 0.5 * (abs(uu) + abs(vv)) + 2.0 * abs(uv) + 2.0 * (high_u + high_v) + fourth
    noise = total * z[SIZES, 0] * (NOISE * z[SIZES, 0] + 3.0 * z[SIZES, 3])
    z[row, VALUE] = g + 0.5 * (uu + vv)
    z[row, SLOPE_U], z[row, SLOPE_V], z[row, SLOPE_T] = 2.0 * gu, 2.0 * gv, gt
    z[row, REST] = (still + mixed) * (1.0 + 1e-12) + noise
    z[row, SHARE_T] = abs(gt) + mixed
    z[row, SHARE_U] = 2.0 * (abs(gu) + high_u) + abs(uu) + abs(uv) + fourth
    z[row, SHARE_V] = 2.0 * (abs(gv) + high_v) + abs(vv) + abs(uv)
    z[row, TERMS] = total * z[SIZES, 0] * z[SIZES, 0]
    if deep > 0:
        z[row + 1, TERMS], z[row + 2, TERMS] = total * z[SIZES, 0] * z[SIZES, 1], total * z[SIZES, 0] * z[SIZES, 2]
        late = 0.0
        for i in range(4):
            late += (z[ALL_U, i] - abs(z[BY_U, i])) * abs(z[MOVED, i]) + z[ALL_U, i] * (z[DRIFT, i] + z[LOOSE, i])
        high = 3.0 * abs(uuu) + 2.0 * abs(uuv1 + uuv2) + abs(uvv1 + uvv2) + 2.0 * fourth
        z[row + 1, VALUE], z[row + 1, SLOPE_U], z[row + 1, SLOPE_V], z[row + 1, SLOPE_T] = gu, uu, uv, ut
        z[row + 1, REST] = (high + late) * (1.0 + 1e-12) + total * NOISE * z[SIZES, 0] * z[SIZES, 1]
        z[row + 1, SHARE_T], z[row + 1, SHARE_U], z[row + 1, SHARE_V] = abs(ut) + late, abs(uu) + high_u, abs(uv)
    if deep > 1:
        late = 0.0
        for i in range(4):
            late += (z[ALL_V, i] - abs(z[BY_V, i])) * abs(z[MOVED, i]) + z[ALL_V, i] * (z[DRIFT, i] + z[LOOSE, i])
        high = 3.0 * abs(vvv) + 2.0 * abs(uvv1 + uvv2) + abs(uuv1 + uuv2) + 2.0 * fourth
        z[row + 2, VALUE], z[row + 2, SLOPE_U], z[row + 2, SLOPE_V], z[row + 2, SLOPE_T] = gv, uv, vv, vt
        z[row + 2, REST] = (high + late) * (1.0 + 1e-12) + total * NOISE * z[SIZES, 0] * z[SIZES, 2]
        z[row + 2, SHARE_T], z[row + 2, SHARE_U], z[row + 2, SHARE_V] = abs(vt) + late, abs(uv), abs(vv) + high_v


@uncounted
def _beyond_plane(table, f, s, z):
    """Bounds of what X beyond second order adds to N.X and to its derivatives, at the middle time."""
    value, by_u, by_v = 0.0, 0.0, 0.0
    for i in range(4):
        n = abs(table[f, 0, i] + s * table[f, 1, i])
        value += n * z[BEYOND, i]
        by_u += n * z[BEYOND_U, i]
        by_v += n * z[BEYOND_V, i]
    return value, by_u, by_v


@uncounted
def _beyond_quadric(table, f, s, z):
    """Bounds of what X beyond second order adds to X^T Q X, and to half its derivatives, at the middle time.

    The images of X are those that its model has left.  With X = Z + r it is 2 r^T Q Z + r^T Q r; of X_a^T Q X it is
    r_a^T Q Z + X_a^T Q r.
    """
    value, by_u, by_v = 0.0, 0.0, 0.0
    for i in range(4):
        image = abs(z[IMAGE, i]) + abs(z[IMAGE_U, i]) + abs(z[IMAGE_V, i])
        image += abs(z[IMAGE_UU, i]) + abs(z[IMAGE_UV, i]) + abs(z[IMAGE_VV, i])
        far = 0.0
        for j in range(4):
            far += abs(table[f, 0, 4 * i + j] + s * table[f, 1, 4 * i + j]) * z[BEYOND, j]
        value += z[BEYOND, i] * (2.0 * image + far)
        by_u += z[BEYOND_U, i] * image + z[ALL_U, i] * far
        by_v += z[BEYOND_V, i] * image + z[ALL_V, i] * far
    return value, by_u, by_v


@uncounted
def _add_beyond(table, f, s, z, deep, row):
    """What is beyond second order at the middle time joins the rests of a model; at other times SECOND has it."""
    if table[f, ABOUT, CURVED] == 0.0:
        value, by_u, by_v = _beyond_plane(table, f, s, z)
    else:
        value, by_u, by_v = _beyond_quadric(table, f, s, z)
    z[row, REST] += value * MORE
    z[row, SHARE_U] += value
    if deep > 0:
        z[row + 1, REST] += by_u * MORE
        z[row + 1, SHARE_U] += by_u
    if deep > 1:
        z[row + 2, REST] += by_v * MORE
        z[row + 2, SHARE_U] += by_v


@uncounted
def _add_slope(z, row, slope, rest):
    """What drift adds to a model: a slope in time, and a rest that has its share with time."""
    z[row, SLOPE_T] += slope
    z[row, REST] += rest * MORE
    z[row, SHARE_T] += abs(slope) + rest


@uncounted
def _add_drift_plane(table, f, s, hs, z, deep, row):
    """N.(s V + R), and the same of derivatives."""
    for k in range(deep + 1):
        slope, rest, size = 0.0, 0.0, 0.0
        for i in range(4):
            n, off = table[f, 0, i] + s * table[f, 1, i], hs * abs(table[f, 1, i]) + table[f, 2, i]
            slope += n * z[DRIFTS + k, i]
            rest += abs(n) * z[STRAYS + k, i] + off * _drifted(z, DRIFTS + k, i)
            size += abs(n * z[DRIFTS + k, i])
        _add_slope(z, row + k, slope, rest + NOISE * size)


@uncounted
def _add_drift_quadric(table, f, s, hs, z, deep, row):
    """With W = s V + R: 2 W^T Q X + W^T Q W, and for half derivatives W_a^T Q X + X_a^T Q W + W_a^T Q W.

    The images of X are those that its model has left; what they are off, away from the middle, is of first order.
    """
    for k in range(deep + 1):
        slope, rest, size = 0.0, 0.0, 0.0
        part = BY_U if k == 1 else BY_V
        image_of_part = IMAGE_U if k == 1 else IMAGE_V
        all_of_part = ALL_U if k == 1 else ALL_V
        for i in range(4):
            off, across, off_part = abs(z[MOVED, i]) + z[DRIFT, i] + z[LOOSE, i], 0.0, 0.0
            off += abs(z[IMAGE_U, i]) + abs(z[IMAGE_V, i])
            off += abs(z[IMAGE_UU, i]) + abs(z[IMAGE_UV, i]) + abs(z[IMAGE_VV, i])
            for j in range(4):
                c = 4 * i + j
                q, d = abs(table[f, 0, c] + s * table[f, 1, c]), hs * abs(table[f, 1, c]) + table[f, 2, c]
                off += q * z[BEYOND, j]
                across += (q + d) * _drifted(z, DRIFTS, j)
                if k > 0:
                    off_part += q * (z[all_of_part, j] - abs(z[part, j])) + d * z[all_of_part, j]
            slope += z[DRIFTS + k, i] * z[IMAGE, i]
            size += abs(z[DRIFTS + k, i] * z[IMAGE, i])
            rest += z[STRAYS + k, i] * (abs(z[IMAGE, i]) + off) + abs(z[DRIFTS + k, i]) * off
            if k > 0:
                slope += z[DRIFTS, i] * z[image_of_part, i]
                size += abs(z[DRIFTS, i] * z[image_of_part, i])
                rest += z[STRAYS, i] * abs(z[image_of_part, i]) + _drifted(z, DRIFTS, i) * off_part
                rest += _drifted(z, DRIFTS + k, i) * across
            else:
                rest += 0.5 * _drifted(z, DRIFTS, i) * across
        if k == 0:
            slope, rest, size = 2.0 * slope, 2.0 * rest, 2.0 * size
        _add_slope(z, row + k, slope, rest + NOISE * size)


@uncounted
def _add_drift(table, f, s, hs, z, deep, row):
    if table[f, ABOUT, CURVED] == 0.0:
        _add_drift_plane(table, f, s, hs, z, deep, row)
    else:
        _add_drift_quadric(table, f, s, hs, z, deep, row)


@uncounted
def model(table, f, s, hs, z, deep, row):
    """Form f over the box and the time s +- hs: z[row], and `deep` derivatives in the rows after it."""
    if table[f, ABOUT, CURVED] == 0.0:
        _plane_model(table, f, s, hs, z, deep, row)
    else:
        _quadric_model(table, f, s, hs, z, deep, row)
    if z[BENT, 0] > 0.0:
        _add_beyond(table, f, s, z, deep, row)
        if z[BENT, 1] > 0.0:
            _add_drift(table, f, s, hs, z, deep, row)


@uncounted
def reach(z, row):
    """Bound of what is beyond the value of a model."""
    return (abs(z[row, SLOPE_U]) + abs(z[row, SLOPE_V]) + abs(z[row, SLOPE_T])) * (1.0 + 1e-14) + z[row, REST]


@uncounted
def parallel(z):
    """From models and derivatives of two forms, ZEROTH.. and SPARE..: the second form in FIRST_ROW, then the
    determinant of the derivatives."""
    p, q, r, t = FIRST_ROW, FIRST_ROW + 1, SPARE + 1, SPARE + 2  # by a and b of the first, and of the second one
    a, b, c, d = z[p, VALUE], z[q, VALUE], z[r, VALUE], z[t, VALUE]
    sa, sb = reach(z, p), reach(z, q)
    sc, sd = reach(z, r), reach(z, t)
    rest = sa * sd + sb * sc + 16.0 * U * ((abs(a) + sa) * (abs(d) + sd) + (abs(b) + sb) * (abs(c) + sc))
    rest += abs(a) * z[t, REST] + abs(d) * z[p, REST] + abs(b) * z[r, REST] + abs(c) * z[q, REST]
    for k in range(SLOPE_U, SHARE_V + 1):
        if k < REST:
            z[q, k] = a * z[t, k] + d * z[p, k] - b * z[r, k] - c * z[q, k]
        elif k > REST:
            z[q, k] = abs(a) * z[t, k] + abs(d) * z[p, k] + abs(b) * z[r, k] + abs(c) * z[q, k]
            z[q, k] += sa * z[t, k] + sd * z[p, k] + sb * z[r, k] + sc * z[q, k]
    z[q, TERMS] = z[p, TERMS] * z[t, TERMS] + z[q, TERMS] * z[r, TERMS]
    z[q, VALUE], z[q, REST] = a * d - b * c, rest * (1.0 + 1e-12)
    for k in range(TERMS + 1):
        z[p, k] = z[SPARE, k]


@uncounted
def add_shares(z, row):
    """Add what time, a and b have in the uncertainty of a model, in parts; rounding errors have no part."""
    total = z[row, SHARE_T] + z[row, SHARE_U] + z[row, SHARE_V]
    if total > ROUNDED * z[row, TERMS]:
        for k in range(3):
            z[SHARES, k] += z[row, SHARE_T + k] / total


@uncounted
def _rough_sign(table, f, s, hs, z):
    """Whether a quadric form is certainly INSIDE (negative) or OUTSIDE on the box, from first orders alone.

    All that is beyond, of any degree, is in the row SECOND.
    """
    value, drift, spread = 0.0, 0.0, 0.0
    for i in range(4):
        image, moved, row, loose = 0.0, 0.0, 0.0, 0.0
        for j in range(4):
            k = 4 * i + j
            d = table[f, 1, k]
            q = table[f, 0, k] + s * d
            d *= hs
            image += q * z[MID, j]
            moved += d * z[MID, j]
            row += (abs(q) + abs(d)) * (z[FIRST, j] + z[SECOND, j])
            loose += table[f, 2, k] * z[ALL, j]
        value += z[MID, i] * image
        drift += z[MID, i] * moved
        spread += (z[FIRST, i] + z[SECOND, i]) * (2.0 * (abs(image) + abs(moved)) + row) + z[ALL, i] * loose
    noise = table[f, ABOUT, SUM_OF_SIZES] * z[SIZES, 0] * (NOISE * z[SIZES, 0] + 3.0 * z[SIZES, 3])
    size = (abs(drift) + spread) * (1.0 + 1e-12) + noise
    if value > size:
        return OUTSIDE
    return INSIDE if value < -size else INSIDE | OUTSIDE


@uncounted
def sign(table, base, form, s, hs, z, first, stack):
    """Bits INSIDE and OUTSIDE of a form over the box, kept in the stack; the model of one that is open stays in
    z, three rows for each form from `first` on."""
    mark = np.int64(1) << form
    if stack[NEGATIVE] & mark:
        return INSIDE
    if stack[POSITIVE] & mark:
        return OUTSIDE
    if stack[OPEN] & mark:
        return INSIDE | OUTSIDE
    found = INSIDE | OUTSIDE
    is_given = table[base + form, ABOUT, GIVEN] != 0.0
    if table[base + form, ABOUT, CURVED] != 0.0 and not is_given:
        found = _rough_sign(table, base + form, s, hs, z)
    if found == INSIDE | OUTSIDE:
        row = first + 3 * form
        if not is_given:
            model(table, base + form, s, hs, z, DEEPEST, row)
        size = reach(z, row)
        if z[row, VALUE] > size:
            found = OUTSIDE
        elif z[row, VALUE] < -size:
            found = INSIDE
        else:
            stack[OPEN] |= mark
            add_shares(z, row)
            return found
    if found == INSIDE:
        stack[NEGATIVE] |= mark
    else:
        stack[POSITIVE] |= mark
    return found


@uncounted
def _outcome(program, begin, end, on, inside, base, table, s, hs, z, first, stack):
    """Bits INSIDE and OUTSIDE of a tree, the forms `on` inside or not as told; signs of others are kept."""
    top, at = 0, begin
    while at < end:
        step, value = program[at, 0], program[at, 1]
        at += 1
        if step == LEAF:
            if (on >> value) & 1:
                stack[top] = INSIDE if (inside >> value) & 1 else OUTSIDE
            elif (stack[NEGATIVE] >> value) & 1:
                stack[top] = INSIDE
            elif (stack[POSITIVE] >> value) & 1:
                stack[top] = OUTSIDE
            else:
                stack[top] = sign(table, base, value, s, hs, z, first, stack)
            top += 1
        elif step == NOT:
            found = stack[top - 1]
            stack[top - 1] = ((found & INSIDE) << 1) | (found >> 1)
        elif step == UNLESS_IN:
            if not stack[top - 1] & INSIDE:
                at = value
        elif step == UNLESS_OUT:
            if not stack[top - 1] & OUTSIDE:
                at = value
        else:
            top -= 1
            p, q = stack[top - 1], stack[top]
            if step == AND:
                stack[top - 1] = (p & q & INSIDE) | ((p | q) & OUTSIDE)
            else:
                stack[top - 1] = ((p | q) & INSIDE) | (p & q & OUTSIDE)
    return stack[0]


@uncounted
def membership(program, begin, end, on, negative, positive, base, table, s, hs, z, first, stack):
    """Bits INSIDE and OUTSIDE: what is near points of the box, for a compiled tree over forms base...

    on: bits of the forms that vanish there; either side of each is tried, so that one that stands in several places
    (the rim of a hole in a face) counts as one.  negative, positive: bits of forms known to be so; those found here
    join them in the stack.  Forms that leave the sign open add to the shares.
    """
    stack[NEGATIVE], stack[POSITIVE], stack[OPEN] = negative, positive, PLAIN
    found, inside = PLAIN, on
    while True:
        found |= _outcome(program, begin, end, on, inside, base, table, s, hs, z, first, stack)
        if found == INSIDE | OUTSIDE or inside == 0:
            return found
        inside = (inside - 1) & on  # the next subset


@uncounted
def narrow(z, n, params):
    """Ranges (lo, hi) in [-1, 1] of a, b, s that hold all common zeros of the first n models; False if none.

    From each model alone, and from all together: g d = -c - r gives d = y (-c - r) + (1 - y g) d for any matrix y
    (Hansen and Sengupta's step with the remainder in place of an interval Jacobian).
    """
    for k in range(3):
        z[RANGES + k, 0], z[RANGES + k, 1] = -1.0, 1.0
    for i in range(n):
        size = reach(z, i)
        if abs(z[i, VALUE]) > size:
            return False
        for k in range(3):
            g = z[i, SLOPE_U + k]
            if abs(g) > 0.01 * size:
                middle, off = -z[i, VALUE] / g, (size * (1.0 + 1e-15) - abs(g)) / abs(g)
                off += 4.0 * U * (abs(middle) + off + 1.0)
                z[RANGES + k, 0] = max(z[RANGES + k, 0], middle - off)
                z[RANGES + k, 1] = min(z[RANGES + k, 1], middle + off)
    # columns of the unknowns: a where there is one, b where there are two, s
    k0, k1, k2 = SLOPE_U, SLOPE_V, SLOPE_T
    if params < 2:
        k1 = SLOPE_T
    if n == 2:
        a, b, c, f = z[0, k0], z[0, k1], z[1, k0], z[1, k1]
        det = a * f - b * c
        if abs(det) > 1e-8 * (abs(a) + abs(b)) * (abs(c) + abs(f)):
            _apply(z, n, k0, f / det, -b / det, 0.0, k0, k1, k2)
            _apply(z, n, k1, -c / det, a / det, 0.0, k0, k1, k2)
    elif n == 3:
        sizes = 1.0
        for i in range(3):
            sizes *= abs(z[i, k0]) + abs(z[i, k1]) + abs(z[i, k2])
        m0 = z[1, k1] * z[2, k2] - z[1, k2] * z[2, k1]
        m1 = z[1, k2] * z[2, k0] - z[1, k0] * z[2, k2]
        m2 = z[1, k0] * z[2, k1] - z[1, k1] * z[2, k0]
        det = z[0, k0] * m0 + z[0, k1] * m1 + z[0, k2] * m2
        if abs(det) > 1e-8 * sizes:
            _apply(
                z, n, k0, m0 / det, (z[0, k2] * z[2, k1] - z[0, k1] * z[2, k2]) / det,
                (z[0, k1] * z[1, k2] - z[0, k2] * z[1, k1]) / det, k0, k1, k2,
            )  # fmt: skip
            _apply(
                z, n, k1, m1 / det, (z[0, k0] * z[2, k2] - z[0, k2] * z[2, k0]) / det,
                (z[0, k2] * z[1, k0] - z[0, k0] * z[1, k2]) / det, k0, k1, k2,
            )  # fmt: skip
            _apply(
                z, n, k2, m2 / det, (z[0, k1] * z[2, k0] - z[0, k0] * z[2, k1]) / det,
                (z[0, k0] * z[1, k1] - z[0, k1] * z[1, k0]) / det, k0, k1, k2,
            )  # fmt: skip
    for k in range(RANGES, RANGES + 3):
        if not z[k, 0] <= z[k, 1]:
            return False
    return True


@uncounted
def _apply(z, n, k, y0, y1, y2, k0, k1, k2):
    """Cut the ranges by the row (y0, y1, y2) of an approximate inverse, for the unknown of column k."""
    middle = -(y0 * z[0, VALUE] + y1 * z[1, VALUE])
    off = abs(y0) * z[0, REST] + abs(y1) * z[1, REST]
    size = abs(y0 * z[0, VALUE]) + abs(y1 * z[1, VALUE])
    if n == 3:
        middle -= y2 * z[2, VALUE]
        off += abs(y2) * z[2, REST]
        size += abs(y2 * z[2, VALUE])
    for c in (k0, k1, k2):
        if n == 2 and c == k2:
            break
        p0, p1, p2 = y0 * z[0, c], y1 * z[1, c], 0.0
        if n == 3:
            p2 = y2 * z[2, c]
        off += abs((1.0 if c == k else 0.0) - (p0 + p1 + p2))
        size += abs(p0) + abs(p1) + abs(p2) + 1.0
    off = off * (1.0 + 1e-14) + 8.0 * U * size
    row = RANGES + k - SLOPE_U
    z[row, 0], z[row, 1] = max(z[row, 0], middle - off), min(z[row, 1], middle + off)
