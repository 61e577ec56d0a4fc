"""Parts of features over short times: ranges and linear models of forms on them, membership, narrowing.

A feature's chart is X(u, v) = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2, homogeneous points with weight > 0, or, of
ruled surfaces, of any degree in u and linear in v.  A box is a range of u, v and s (the time within a slab).  Over it a
form q = X^T Q(s) X is
    value + slopes.(a, b, s) + [-rest, rest],  -1 <= a, b, s <= 1,
and so are half its derivatives by a and b, which vanish where a feature touches a surface (Choi et al. 2014, table 1;
the equations in parameters are re-derived).
"""

from __future__ import annotations

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.workspace import rows

U = 2.0**-53
# Of a form on a box, per unit of the largest coordinates and the sum of its coefficients: points are off by eight
# roundings, a sum of sixteen products adds as many.
NOISE = 64.0 * U
MORE = 1.0 + 1e-12
# Columns of a chart: six coefficients of four coordinates, error of the points.  Of charts that are not quadratic the
# degree n in u (else 0), and for each power of u the coefficients of 1 and of v.
ERROR, DEGREE, POWERS = 24, 25, 26
MOST_DEGREE = 60
# Rows of the points of a box: X and its derivatives at the middle times half-widths; bounds of first and second order
# parts, of all, and of the derivatives; sizes of X and of its two derivatives for rounding errors; bounds of what is
# beyond second order, of it and of its two derivatives, and whether there is anything; scratch: powers of u, alone and
# times v.
MID, BY_U, BY_V, UU, UV, VV, FIRST, SECOND, ALL, ALL_U, ALL_V, SIZES = rows(*range(12))
BEYOND, BEYOND_U, BEYOND_V, BENT, ALONE, TIMES_V = rows(12, 13, 14, 15, 16, 17 + MOST_DEGREE)
POINTS = 18 + 2 * MOST_DEGREE
# Rows of images of points under a form: Q X and of its derivatives, h Q' X; bounds h |Q'| (E + D), rest |X|.
IMAGE, IMAGE_U, IMAGE_V, IMAGE_UU, IMAGE_UV, IMAGE_VV, MOVED, DRIFT, LOOSE = rows(*range(9))
IMAGES = 9
# Columns of a model: value, slopes by a, b, s, rest; shares of the uncertainty by time, a, b; size of its terms.
VALUE, SLOPE_U, SLOPE_V, SLOPE_T, REST, SHARE_T, SHARE_U, SHARE_V, TERMS = rows(*range(9))
COLUMNS = 9
# Part of the size of its terms below which what is open of a model counts as rounding errors.
ROUNDED = 1e-12
INSIDE, OUTSIDE = rows(1, 2)
# No derivatives; rows of models for equations, and the one for membership.
PLAIN, ZEROTH, FIRST_ROW, SPARE = rows(0, 0, 1, 3)
# Where the stack keeps the signs of forms.
SIGNS = 64
STACK = 320
# Steps of a compiled tree.
LEAF, NOT, AND, OR, UNLESS_IN, UNLESS_OUT = rows(*range(6))


@kernel
def place_box(charts, k, u, hu, v, hv, x):
    """The points of the box; False where their weight may vanish."""
    if charts.shape[1] > POWERS:
        if charts[k, DEGREE] > 0.0:
            sizes = _place_ruled(charts, k, u, hu, v, hv, x)
            return _bound_box(charts[k, ERROR], sizes, x)
        x[BENT, 0] = 0.0
    s0, s1, s2 = 0.0, 0.0, 0.0
    mu, mv = abs(u) + hu, abs(v) + hv
    for i in range(4):
        c0, c1, c2, c3, c4, c5 = (
            charts[k, i], charts[k, 4 + i], charts[k, 8 + i], charts[k, 12 + i], charts[k, 16 + i], charts[k, 20 + i],
        )  # fmt: skip
        x[MID, i] = c0 + u * (c1 + c3 * u + c4 * v) + v * (c2 + c5 * v)
        x[BY_U, i] = hu * (c1 + 2.0 * c3 * u + c4 * v)
        x[BY_V, i] = hv * (c2 + 2.0 * c5 * v + c4 * u)
        x[UU, i], x[UV, i], x[VV, i] = hu * hu * c3, hu * hv * c4, hv * hv * c5
        b1, b2, b3, b4, b5 = abs(c1), abs(c2), abs(c3), abs(c4), abs(c5)
        s0 = max(s0, abs(c0) + mu * (b1 + b3 * mu + b4 * mv) + mv * (b2 + b5 * mv))
        s1 = max(s1, hu * (b1 + 2.0 * b3 * mu + b4 * mv))
        s2 = max(s2, hv * (b2 + 2.0 * b5 * mv + b4 * mu))
    return _bound_box(charts[k, ERROR], (s0, s1, s2), x)


@kernel
def _place_ruled(charts, k, u, hu, v, hv, x):
    """Rows of X, its derivatives and what is beyond, of a chart linear in v; sizes as in the row SIZES."""
    n = int(charts[k, DEGREE])
    x[BENT, 0] = 1.0
    s0, s1, s2 = 0.0, 0.0, 0.0
    mu, mv = abs(u) + hu, abs(v) + hv
    for i in range(4):
        whole, slope, across = 0.0, 0.0, 0.0
        for j in range(n, -1, -1):
            a, b = charts[k, POWERS + 8 * j + i], charts[k, POWERS + 8 * j + 4 + i]
            x[ALONE + j, i], x[TIMES_V + j, i] = a + v * b, hv * b
            slope = slope * mu + whole
            whole = whole * mu + abs(a) + mv * abs(b)
            across = across * mu + hv * abs(b)
        s0, s1, s2 = max(s0, whole), max(s1, hu * slope), max(s2, across)
        for q in range(n):
            for j in range(n - 1, q - 1, -1):
                x[ALONE + j, i] += u * x[ALONE + j + 1, i]
                x[TIMES_V + j, i] += u * x[TIMES_V + j + 1, i]
        x[MID, i], x[BY_U, i], x[BY_V, i] = x[ALONE, i], hu * x[ALONE + 1, i], x[TIMES_V, i]
        x[UV, i], x[UU, i], x[VV, i] = hu * x[TIMES_V + 1, i], 0.0, 0.0
        rest, rest_u, rest_v, power = 0.0, 0.0, 0.0, hu
        for j in range(2, n + 1):
            power *= hu
            a, b = abs(x[ALONE + j, i]) * power, abs(x[TIMES_V + j, i]) * power
            if j == 2:
                x[UU, i] = x[ALONE + 2, i] * power
                a = 0.0
            rest, rest_u, rest_v = rest + a + b, rest_u + j * (a + b), rest_v + b
        x[BEYOND, i], x[BEYOND_U, i], x[BEYOND_V, i] = rest * MORE, rest_u * MORE, rest_v * MORE
    # points are off by 3 n + 7 roundings, not by eight: twice as much in a form that is a sum of sixteen products
    more = max(1.0, (6.0 * n + 46.0) / 64.0)
    return more * s0, more * s1, more * s2


@kernel
def _bound_box(error, sizes, x):
    """The other rows, from X and its derivatives; False where the weight may vanish."""
    if x[MID, 3] < 0.0:
        for r in range(6):
            for i in range(4):
                x[r, i] = -x[r, i]
    for i in range(4):
        x[FIRST, i] = abs(x[BY_U, i]) + abs(x[BY_V, i])
        x[SECOND, i] = abs(x[UU, i]) + abs(x[UV, i]) + abs(x[VV, i])
        x[ALL_U, i] = abs(x[BY_U, i]) + 2.0 * abs(x[UU, i]) + abs(x[UV, i])
        x[ALL_V, i] = abs(x[BY_V, i]) + 2.0 * abs(x[VV, i]) + abs(x[UV, i])
        if x[BENT, 0] > 0.0:
            # the derivatives of what is beyond are within twice its bound here, like those of squares
            x[SECOND, i] += max(x[BEYOND, i], 0.5 * x[BEYOND_U, i], 0.5 * x[BEYOND_V, i])
            x[ALL_U, i] += x[BEYOND_U, i]
            x[ALL_V, i] += x[BEYOND_V, i]
        x[ALL, i] = abs(x[MID, i]) + x[FIRST, i] + x[SECOND, i]
    x[SIZES, 0], x[SIZES, 1], x[SIZES, 2] = sizes
    x[SIZES, 3] = error
    return x[MID, 3] > x[FIRST, 3] + x[SECOND, 3] + NOISE * sizes[0]


@kernel
def _dot(x, i, y, j):
    return x[i, 0] * y[j, 0] + x[i, 1] * y[j, 1] + x[i, 2] * y[j, 2] + x[i, 3] * y[j, 3]


@kernel
def _plane_model(table, f, s, hs, x, deep, e, row):
    g, gu, gv, uu, uv, vv, gt, mixed, rest, mixed_u, rest_u, mixed_v, rest_v = (
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    )  # fmt: skip
    total, beyond, beyond_u, beyond_v = 0.0, 0.0, 0.0, 0.0
    for i in range(4):
        n, d, r = table[f, 0, i] + s * table[f, 1, i], hs * table[f, 1, i], table[f, 2, i]
        g += n * x[MID, i]
        gu += n * x[BY_U, i]
        gv += n * x[BY_V, i]
        uu += n * x[UU, i]
        uv += n * x[UV, i]
        vv += n * x[VV, i]
        gt += d * x[MID, i]
        size = abs(d)
        if x[BENT, 0] > 0.0:
            beyond += abs(n) * x[BEYOND, i]
            beyond_u += abs(n) * x[BEYOND_U, i]
            beyond_v += abs(n) * x[BEYOND_V, i]
        mixed += size * (x[FIRST, i] + x[SECOND, i]) + r * x[ALL, i]
        total += abs(table[f, 0, i]) + abs(table[f, 1, i]) + r
        if deep > 0:
            mixed_u += 2.0 * size * x[SECOND, i] + r * x[ALL_U, i]
            mixed_v += 2.0 * size * x[SECOND, i] + r * x[ALL_V, i]
            rest_u += d * x[BY_U, i]
            rest_v += d * x[BY_V, i]
    noise = total * (NOISE * x[SIZES, 0] + x[SIZES, 3])
    e[row, VALUE] = g + 0.5 * (uu + vv)
    e[row, SLOPE_U], e[row, SLOPE_V], e[row, SLOPE_T] = gu, gv, gt
    rest = 0.5 * (abs(uu) + abs(vv)) + abs(uv) + mixed + beyond
    e[row, REST] = rest * (1.0 + 1e-12) + noise
    e[row, SHARE_T] = abs(gt) + mixed
    e[row, SHARE_U] = abs(gu) + abs(uu) + abs(uv) + beyond
    e[row, SHARE_V] = abs(gv) + abs(vv) + abs(uv)
    e[row, TERMS] = total * x[SIZES, 0]
    # derivatives by a and b of N.X
    if deep > 0:
        e[row + 1, TERMS], e[row + 2, TERMS] = total * x[SIZES, 1], total * x[SIZES, 2]
        e[row + 1, VALUE], e[row + 1, SLOPE_U], e[row + 1, SLOPE_V], e[row + 1, SLOPE_T] = gu, 2.0 * uu, uv, rest_u
        e[row + 1, REST] = (mixed_u + beyond_u) * (1.0 + 1e-12) + total * NOISE * x[SIZES, 1]
        e[row + 1, SHARE_T], e[row + 1, SHARE_U] = abs(rest_u) + mixed_u, 2.0 * abs(uu) + beyond_u
        e[row + 1, SHARE_V] = abs(uv)
    if deep > 1:
        e[row + 2, VALUE], e[row + 2, SLOPE_U], e[row + 2, SLOPE_V], e[row + 2, SLOPE_T] = gv, uv, 2.0 * vv, rest_v
        e[row + 2, REST] = (mixed_v + beyond_v) * (1.0 + 1e-12) + total * NOISE * x[SIZES, 2]
        e[row + 2, SHARE_T], e[row + 2, SHARE_U] = abs(rest_v) + mixed_v, abs(uv) + beyond_v
        e[row + 2, SHARE_V] = 2.0 * abs(vv)


@kernel
def _beyond(table, f, s, x, y):
    """Bounds of what X beyond second order adds to X^T Q X, and to half its derivatives, at the middle time.

    With X = Z + r it is 2 r^T Q Z + r^T Q r; of X_a^T Q X it is r_a^T Q Z + X_a^T Q r.
    """
    value, by_u, by_v = 0.0, 0.0, 0.0
    for i in range(4):
        image = abs(y[IMAGE, i]) + abs(y[IMAGE_U, i]) + abs(y[IMAGE_V, i])
        image += abs(y[IMAGE_UU, i]) + abs(y[IMAGE_UV, i]) + abs(y[IMAGE_VV, i])
        far = 0.0
        for j in range(4):
            far += abs(table[f, 0, 4 * i + j] + s * table[f, 1, 4 * i + j]) * x[BEYOND, j]
        value += x[BEYOND, i] * (2.0 * image + far)
        by_u += x[BEYOND_U, i] * image + x[ALL_U, i] * far
        by_v += x[BEYOND_V, i] * image + x[ALL_V, i] * far
    return value, by_u, by_v


@kernel
def _quadric_model(table, f, s, hs, x, deep, y, e, row):
    total = 0.0
    for i in range(4):
        y0, y1, y2, y3, y4, y5, y6, y7, y8 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(4):
            k = 4 * i + j
            d, r = table[f, 1, k], table[f, 2, k]
            q = table[f, 0, k] + s * d
            total += abs(table[f, 0, k]) + abs(d) + r
            y0 += q * x[MID, j]
            y1 += q * x[BY_U, j]
            y2 += q * x[BY_V, j]
            y3 += d * x[MID, j]
            y4 += q * x[UU, j]
            y7 += q * x[UV, j]
            y8 += q * x[VV, j]
            y5 += abs(d) * (x[FIRST, j] + x[SECOND, j])
            y6 += r * x[ALL, j]
        y[IMAGE, i], y[IMAGE_U, i], y[IMAGE_V, i], y[MOVED, i] = y0, y1, y2, hs * y3
        y[IMAGE_UU, i], y[IMAGE_UV, i], y[IMAGE_VV, i] = y4, y7, y8
        y[DRIFT, i], y[LOOSE, i] = hs * y5, y6
    g, gu, gv, gt = _dot(x, MID, y, IMAGE), _dot(x, BY_U, y, IMAGE), _dot(x, BY_V, y, IMAGE), _dot(x, MID, y, MOVED)
    uu = _dot(x, BY_U, y, IMAGE_U) + 2.0 * _dot(x, UU, y, IMAGE)
    vv = _dot(x, BY_V, y, IMAGE_V) + 2.0 * _dot(x, VV, y, IMAGE)
    uv = _dot(x, BY_U, y, IMAGE_V) + _dot(x, UV, y, IMAGE)
    ut, vt = _dot(x, BY_U, y, MOVED), _dot(x, BY_V, y, MOVED)
    # third order: a^3, a^2 b, a b^2, b^3, halved
    uuu, vvv = _dot(x, UU, y, IMAGE_U), _dot(x, VV, y, IMAGE_V)
    uuv1, uuv2 = _dot(x, UU, y, IMAGE_V), _dot(x, UV, y, IMAGE_U)
    uvv1, uvv2 = _dot(x, UV, y, IMAGE_V), _dot(x, VV, y, IMAGE_U)
    fourth = abs(_dot(x, UU, y, IMAGE_UU)) + 2.0 * abs(_dot(x, UU, y, IMAGE_UV)) + abs(_dot(x, VV, y, IMAGE_VV))
    fourth += abs(_dot(x, UV, y, IMAGE_UV) + 2.0 * _dot(x, UU, y, IMAGE_VV)) + 2.0 * abs(_dot(x, UV, y, IMAGE_VV))
    high_u, high_v = abs(uuu) + abs(uuv1 + uuv2), abs(vvv) + abs(uvv1 + uvv2)
    beyond, beyond_u, beyond_v = 0.0, 0.0, 0.0
    if x[BENT, 0] > 0.0:
        beyond, beyond_u, beyond_v = _beyond(table, f, s, x, y)
    late, still = 0.0, 0.0
    for i in range(4):
        late += 2.0 * x[SECOND, i] * abs(y[MOVED, i]) + x[ALL, i] * y[LOOSE, i]
        late += (x[FIRST, i] + x[SECOND, i]) * y[DRIFT, i]
    mixed = 2.0 * (abs(ut) + abs(vt)) + late
    still = 0.5 * (abs(uu) + abs(vv)) + 2.0 * abs(uv) + 2.0 * (high_u + high_v) + fourth + beyond
    noise = total * x[SIZES, 0] * (NOISE * x[SIZES, 0] + 3.0 * x[SIZES, 3])
    e[row, VALUE] = g + 0.5 * (uu + vv)
    e[row, SLOPE_U], e[row, SLOPE_V], e[row, SLOPE_T] = 2.0 * gu, 2.0 * gv, gt
    e[row, REST] = (still + mixed) * (1.0 + 1e-12) + noise
    e[row, SHARE_T] = abs(gt) + mixed
    e[row, SHARE_U] = 2.0 * (abs(gu) + high_u) + abs(uu) + abs(uv) + fourth + beyond
    e[row, SHARE_V] = 2.0 * (abs(gv) + high_v) + abs(vv) + abs(uv)
    e[row, TERMS] = total * x[SIZES, 0] * x[SIZES, 0]
    if deep > 0:
        e[row + 1, TERMS], e[row + 2, TERMS] = total * x[SIZES, 0] * x[SIZES, 1], total * x[SIZES, 0] * x[SIZES, 2]
        late = 0.0
        for i in range(4):
            late += (x[ALL_U, i] - abs(x[BY_U, i])) * abs(y[MOVED, i]) + x[ALL_U, i] * (y[DRIFT, i] + y[LOOSE, i])
        high = 3.0 * abs(uuu) + 2.0 * abs(uuv1 + uuv2) + abs(uvv1 + uvv2) + 2.0 * fourth + beyond_u
        e[row + 1, VALUE], e[row + 1, SLOPE_U], e[row + 1, SLOPE_V], e[row + 1, SLOPE_T] = gu, uu, uv, ut
        e[row + 1, REST] = (high + late) * (1.0 + 1e-12) + total * NOISE * x[SIZES, 0] * x[SIZES, 1]
        e[row + 1, SHARE_T], e[row + 1, SHARE_U] = abs(ut) + late, abs(uu) + high_u + beyond_u
        e[row + 1, SHARE_V] = abs(uv)
    if deep > 1:
        late = 0.0
        for i in range(4):
            late += (x[ALL_V, i] - abs(x[BY_V, i])) * abs(y[MOVED, i]) + x[ALL_V, i] * (y[DRIFT, i] + y[LOOSE, i])
        high = 3.0 * abs(vvv) + 2.0 * abs(uvv1 + uvv2) + abs(uuv1 + uuv2) + 2.0 * fourth + beyond_v
        e[row + 2, VALUE], e[row + 2, SLOPE_U], e[row + 2, SLOPE_V], e[row + 2, SLOPE_T] = gv, uv, vv, vt
        e[row + 2, REST] = (high + late) * (1.0 + 1e-12) + total * NOISE * x[SIZES, 0] * x[SIZES, 2]
        e[row + 2, SHARE_T], e[row + 2, SHARE_U] = abs(vt) + late, abs(uv) + beyond_v
        e[row + 2, SHARE_V] = abs(vv) + high_v


@kernel
def model(table, kinds, f, s, hs, x, deep, y, e, row):
    """Form f over the box and the time s +- hs: row e[row], and `deep` derivatives in the rows after it."""
    if kinds[f] == 0:
        _plane_model(table, f, s, hs, x, deep, e, row)
    else:
        _quadric_model(table, f, s, hs, x, deep, y, e, row)


@kernel
def reach(e, row):
    """Bound of what is beyond the value of a model."""
    return (abs(e[row, SLOPE_U]) + abs(e[row, SLOPE_V]) + abs(e[row, SLOPE_T])) * (1.0 + 1e-14) + e[row, REST]


@kernel
def parallel(e):
    """From models and derivatives of two forms, rows 0.. and 3..: the second form in row 1, in row 2 the determinant
    of the derivatives."""
    p, q, r, t = FIRST_ROW, FIRST_ROW + 1, SPARE + 1, SPARE + 2  # by a and b of the first, and of the second one
    a, b, c, d = e[p, VALUE], e[q, VALUE], e[r, VALUE], e[t, VALUE]
    sa, sb = reach(e, p), reach(e, q)
    sc, sd = reach(e, r), reach(e, t)
    rest = sa * sd + sb * sc + 16.0 * U * ((abs(a) + sa) * (abs(d) + sd) + (abs(b) + sb) * (abs(c) + sc))
    rest += abs(a) * e[t, REST] + abs(d) * e[p, REST] + abs(b) * e[r, REST] + abs(c) * e[q, REST]
    for k in range(SLOPE_U, SHARE_V + 1):
        if k < REST:
            e[q, k] = a * e[t, k] + d * e[p, k] - b * e[r, k] - c * e[q, k]
        elif k > REST:
            e[q, k] = abs(a) * e[t, k] + abs(d) * e[p, k] + abs(b) * e[r, k] + abs(c) * e[q, k]
            e[q, k] += sa * e[t, k] + sd * e[p, k] + sb * e[r, k] + sc * e[q, k]
    e[q, TERMS] = e[p, TERMS] * e[t, TERMS] + e[q, TERMS] * e[r, TERMS]
    e[q, VALUE], e[q, REST] = a * d - b * c, rest * (1.0 + 1e-12)
    for k in range(COLUMNS):
        e[p, k] = e[SPARE, k]


@kernel
def add_shares(e, row, shares):
    """Add what time, a and b have in the uncertainty of a model, in parts; rounding errors have no part."""
    total = e[row, SHARE_T] + e[row, SHARE_U] + e[row, SHARE_V]
    if total > ROUNDED * e[row, TERMS]:
        for k in range(3):
            shares[k] += e[row, SHARE_T + k] / total


@kernel
def _outcome(program, begin, end, on, inside, base, table, kinds, s, hs, x, y, e, row, shares, stack):
    """Bits INSIDE and OUTSIDE of a tree, the forms `on` inside or not as told; other signs are kept in the stack."""
    top, at = 0, begin
    while at < end:
        step, value = program[at, 0], program[at, 1]
        at += 1
        if step == LEAF:
            if (on >> value) & 1:
                found = INSIDE if (inside >> value) & 1 else OUTSIDE
            elif stack[SIGNS + value] != 0:
                found = stack[SIGNS + value]
            else:
                model(table, kinds, base + value, s, hs, x, PLAIN, y, e, row)
                size = reach(e, row)
                if e[row, VALUE] > size:
                    found = OUTSIDE
                elif e[row, VALUE] < -size:
                    found = INSIDE
                else:
                    found = INSIDE | OUTSIDE
                    add_shares(e, row, shares)
                stack[SIGNS + value] = found
            stack[top] = found
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


@kernel
def membership(program, begin, end, on, base, table, kinds, s, hs, x, y, e, row, shares, stack):
    """Bits INSIDE and OUTSIDE: what is near points of the box, for a compiled tree over forms base...

    on: bits of the forms that vanish there; either side of each is tried, so that one that stands in several places
    (the rim of a hole in a face) counts as one.  Forms that leave the sign open add to the shares.
    """
    for k in range(SIGNS, SIGNS + 64):
        stack[k] = 0
    found, inside = PLAIN, on
    while True:
        found |= _outcome(program, begin, end, on, inside, base, table, kinds, s, hs, x, y, e, row, shares, stack)
        if found == INSIDE | OUTSIDE or inside == 0:
            return found
        inside = (inside - 1) & on  # the next subset


@kernel
def narrow(e, n, params, d):
    """Ranges d[k] = (lo, hi) in [-1, 1] of a, b, s that hold all common zeros of the n models; False if none.

    From each model alone, and from all together: g d = -c - r gives d = y (-c - r) + (1 - y g) d for any matrix y
    (Hansen and Sengupta's step with the remainder in place of an interval Jacobian).
    """
    for k in range(3):
        d[k, 0], d[k, 1] = -1.0, 1.0
    for i in range(n):
        size = reach(e, i)
        if abs(e[i, VALUE]) > size:
            return False
        for k in range(3):
            g = e[i, SLOPE_U + k]
            if abs(g) > 0.01 * size:
                middle, off = -e[i, VALUE] / g, (size * (1.0 + 1e-15) - abs(g)) / abs(g)
                off += 4.0 * U * (abs(middle) + off + 1.0)
                d[k, 0], d[k, 1] = max(d[k, 0], middle - off), min(d[k, 1], middle + off)
    # columns of the unknowns: a where there is one, b where there are two, s
    k0, k1, k2 = SLOPE_U, SLOPE_V, SLOPE_T
    if params < 2:
        k1 = SLOPE_T
    if n == 2:
        a, b, c, f = e[0, k0], e[0, k1], e[1, k0], e[1, k1]
        det = a * f - b * c
        if abs(det) > 1e-8 * (abs(a) + abs(b)) * (abs(c) + abs(f)):
            _apply(e, n, d, k0, f / det, -b / det, 0.0, k0, k1, k2)
            _apply(e, n, d, k1, -c / det, a / det, 0.0, k0, k1, k2)
    elif n == 3:
        sizes = 1.0
        for i in range(3):
            sizes *= abs(e[i, k0]) + abs(e[i, k1]) + abs(e[i, k2])
        m0 = e[1, k1] * e[2, k2] - e[1, k2] * e[2, k1]
        m1 = e[1, k2] * e[2, k0] - e[1, k0] * e[2, k2]
        m2 = e[1, k0] * e[2, k1] - e[1, k1] * e[2, k0]
        det = e[0, k0] * m0 + e[0, k1] * m1 + e[0, k2] * m2
        if abs(det) > 1e-8 * sizes:
            _apply(
                e, n, d, k0, m0 / det, (e[0, k2] * e[2, k1] - e[0, k1] * e[2, k2]) / det,
                (e[0, k1] * e[1, k2] - e[0, k2] * e[1, k1]) / det, k0, k1, k2,
            )  # fmt: skip
            _apply(
                e, n, d, k1, m1 / det, (e[0, k0] * e[2, k2] - e[0, k2] * e[2, k0]) / det,
                (e[0, k2] * e[1, k0] - e[0, k0] * e[1, k2]) / det, k0, k1, k2,
            )  # fmt: skip
            _apply(
                e, n, d, k2, m2 / det, (e[0, k1] * e[2, k0] - e[0, k0] * e[2, k1]) / det,
                (e[0, k0] * e[1, k1] - e[0, k1] * e[1, k0]) / det, k0, k1, k2,
            )  # fmt: skip
    return d[0, 0] <= d[0, 1] and d[1, 0] <= d[1, 1] and d[2, 0] <= d[2, 1]


@kernel
def _apply(e, n, d, k, y0, y1, y2, k0, k1, k2):
    """Cut d by the row (y0, y1, y2) of an approximate inverse, for the unknown of column k."""
    middle = -(y0 * e[0, VALUE] + y1 * e[1, VALUE])
    off = abs(y0) * e[0, REST] + abs(y1) * e[1, REST]
    size = abs(y0 * e[0, VALUE]) + abs(y1 * e[1, VALUE])
    if n == 3:
        middle -= y2 * e[2, VALUE]
        off += abs(y2) * e[2, REST]
        size += abs(y2 * e[2, VALUE])
    for c in (k0, k1, k2):
        if n == 2 and c == k2:
            break
        p0, p1, p2 = y0 * e[0, c], y1 * e[1, c], 0.0
        if n == 3:
            p2 = y2 * e[2, c]
        off += abs((1.0 if c == k else 0.0) - (p0 + p1 + p2))
        size += abs(p0) + abs(p1) + abs(p2) + 1.0
    off = off * (1.0 + 1e-14) + 8.0 * U * size
    row = k - SLOPE_U
    d[row, 0], d[row, 1] = max(d[row, 0], middle - off), min(d[row, 1], middle + off)
