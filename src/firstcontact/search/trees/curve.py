"""The walk under a curved motion: boxes and elements over cells of time in which the pose is a polynomial (`cells`).

`motion` (cells + SCRATCH, ROWS, TERMS): level l has 2^l cells, one level behind the other.  A box of a is posed: its
centre moves on a polynomial, its size is bounded over the cell.  In each of the axes of both bodies' frames the gap to
the other box falls no faster than the largest fall of its Bernstein coefficients, so it stays open up to a provable
time (conservative advancement); a cell that does not tell is looked at in its halves.

Elements are tested by functions that are linear in the rows of a cell: the height of a vertex over a plane, the side
product of two lines, each with its Bernstein coefficients and one error bound.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import implements, kernel, uncounted
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.motion.relative.cells import (
    BACK,
    BACK_SHIFT,
    BACK_SPREAD,
    COFACTOR,
    ERRORS,
    LENGTH,
    LEVELS,
    LINEAR,
    MOMENT,
    SCRATCH,
    SHIFT,
    SPREAD,
    TERMS,
)
from firstcontact.search.trees.state import (
    BEST,
    CANDIDATES,
    CERTAIN_KIND,
    EDGE_EDGE,
    FACE_VERTEX,
    FIRST,
    KEY,
    TESTS,
    VERTEX_FACE,
    WHOLE,
)
from firstcontact.search.trees.tree import CORNER, FACET, POINT
from firstcontact.search.trees.walk import (
    area,
    earliest_meeting,
    first_is_larger,
    get_ready,
    is_new,
    record,
    test_events,
)

LAST = TERMS - 1
# Places in row ERRORS.
E_LINEAR, E_SHIFT, E_COFACTOR, E_MOMENT, E_BACK, E_BACK_SHIFT = range(6)
# A time from a cell's number and a share of it: a few roundings of the piece's length.
TIME_EPS = 2e-15
U8 = 8.0 * 2.0**-53
# Shares of a cell at which halving stops: for roots, and where not even the sides of an element are clear.
FINEST, FINE = 2.0**-32, 2.0**-14


# ------------------------------------------------------------------------------------------------------- boxes


@uncounted
def _free_share(motion, cell, row, shift, x0, x1, x2, middle, extent):
    """The share of the cell during which a centre stays further than `extent` from `middle` along one axis; 2: all.

    row: the axis' row of the linear part; shift: that of the shift.
    """
    q = (
        motion[cell, row, 0] * x0 + motion[cell, row + 1, 0] * x1 + motion[cell, row + 2, 0] * x2
        + motion[cell, shift, 0] - middle
    )  # fmt: skip
    first, lo, hi, rise, fall = q, q, q, 0.0, 0.0
    for j in range(1, TERMS):
        p = (
            motion[cell, row, j] * x0 + motion[cell, row + 1, j] * x1 + motion[cell, row + 2, j] * x2
            + motion[cell, shift, j] - middle
        )  # fmt: skip
        lo, hi = min(lo, p), max(hi, p)
        rise, fall = max(rise, p - q), max(fall, q - p)
        q = p
    if first > extent:
        return 2.0 if lo > extent else (first - extent) / (LAST * fall)
    if -first > extent:
        return 2.0 if -hi > extent else (-first - extent) / (LAST * rise)
    return 0.0


@uncounted
def _spread(motion, cell, row, k, h0, h1, h2):
    """Bound of the half size, along axis k, of a box of half sizes h that is posed."""
    i = 3 * k
    a = motion[cell, row + (i >> 3), i & 7]
    b = motion[cell, row + ((i + 1) >> 3), (i + 1) & 7]
    c = motion[cell, row + ((i + 2) >> 3), (i + 2) & 7]
    return a * h0 + b * h1 + c * h2


@uncounted
def boxes_free(motion, cell, boxes_a, a, boxes_b, b, pad):
    """The share of the cell, from its start, during which two boxes are certainly apart; 2: all of it."""
    c0, c1 = 0.5 * (boxes_a[a, 0] + boxes_a[a, 3]), 0.5 * (boxes_a[a, 1] + boxes_a[a, 4])
    c2 = 0.5 * (boxes_a[a, 2] + boxes_a[a, 5])
    h0, h1, h2 = boxes_a[a, 3] - c0, boxes_a[a, 4] - c1, boxes_a[a, 5] - c2
    d0, d1 = 0.5 * (boxes_b[b, 0] + boxes_b[b, 3]), 0.5 * (boxes_b[b, 1] + boxes_b[b, 4])
    d2 = 0.5 * (boxes_b[b, 2] + boxes_b[b, 5])
    g0, g1, g2 = boxes_b[b, 3] - d0, boxes_b[b, 4] - d1, boxes_b[b, 5] - d2
    size_a, size_b = abs(c0) + abs(c1) + abs(c2), abs(d0) + abs(d1) + abs(d2)
    # half sizes and centres round once each, sums a few times: 1e-15 of what they are sums of
    err = motion[cell, ERRORS, E_LINEAR] * (size_a + h0 + h1 + h2) + motion[cell, ERRORS, E_SHIFT]
    err += pad + 1e-15 * (size_b + g0 + g1 + g2)
    free = 0.0
    for k in range(3):
        g, d = (g0, d0) if k == 0 else (g1, d1) if k == 1 else (g2, d2)
        extent = (g + _spread(motion, cell, SPREAD, k, h0, h1, h2)) * (1.0 + 1e-15) + err
        share = _free_share(motion, cell, LINEAR + 3 * k, SHIFT + k, c0, c1, c2, d, extent)
        if share >= 1.0:
            return 2.0
        free = max(free, share)
    err = motion[cell, ERRORS, E_BACK] * (size_b + g0 + g1 + g2) + motion[cell, ERRORS, E_BACK_SHIFT]
    err += pad + 1e-15 * (size_a + h0 + h1 + h2)
    for k in range(3):
        h, c = (h0, c0) if k == 0 else (h1, c1) if k == 1 else (h2, c2)
        extent = (h + _spread(motion, cell, BACK_SPREAD, k, g0, g1, g2)) * (1.0 + 1e-15) + err
        share = _free_share(motion, cell, BACK + 3 * k, BACK_SHIFT + k, d0, d1, d2, c, extent)
        if share >= 1.0:
            return 2.0
        free = max(free, share)
    return free


@uncounted
def _finest_at(levels, length, time):
    """The last finest cell that starts, as `length * i / count`, no later than the time."""
    count = 1 << levels
    i = min(max(int(time / length * count), 0), count - 1) if length > 0.0 else 0
    if i > 0 and length * i / count > time:
        return i - 1
    return i + 1 if i + 1 < count and length * (i + 1) / count <= time else i


@uncounted
def next_meeting(motion, boxes_a, a, boxes_b, b, pad, first, last):
    """(time, cell): a time not before `first` up to which two boxes are apart, in that finest cell; cell -1: apart."""
    levels, length = int(motion[0, ERRORS, LEVELS]), motion[0, ERRORS, LENGTH]
    if first > last:
        return np.inf, -1
    level, i = levels, _finest_at(levels, length, first)
    # Invariant: the boxes are apart from `first` to the start of cell i of the level.
    while True:
        count = 1 << level
        if length * i / count > last * (1.0 + TIME_EPS) + length * TIME_EPS:
            return np.inf, -1
        share = boxes_free(motion, count - 1 + i, boxes_a, a, boxes_b, b, pad)
        if share <= 1.0:
            if level < levels:
                level, i = level + 1, 2 * i + (1 if share > 0.5 else 0)
                continue
            time = max(first, length * ((i + share) / count) - TIME_EPS * length)
            return (time, i) if time <= last else (np.inf, -1)
        i += 1
        if i == count:
            return np.inf, -1
        while level > 0 and i & 1 == 0:
            i >>= 1
            level -= 1


# ---------------------------------------------------------------------------------------------------- elements


@uncounted
def height(motion, slot, f, cell, row, shift, el, es, x0, x1, x2, rx, n0, n1, n2, dn, p0, p1, p2, rp):
    """Coefficients of n.(X(t) - p) into scratch row f, X the posed x; returns their error bound.

    row, shift: the pose (LINEAR, SHIFT) or its inverse.  rx, rp: errors of the coordinates of x and p; dn: bound on the
    error of n, summed over its coordinates.
    """
    a00, a01, a02 = n0 * x0, n0 * x1, n0 * x2
    a10, a11, a12 = n1 * x0, n1 * x1, n1 * x2
    a20, a21, a22 = n2 * x0, n2 * x1, n2 * x2
    c = n0 * p0 + n1 * p1 + n2 * p2
    for j in range(TERMS):
        motion[slot, f, j] = (
            a00 * motion[cell, row, j] + a01 * motion[cell, row + 1, j] + a02 * motion[cell, row + 2, j]
            + a10 * motion[cell, row + 3, j] + a11 * motion[cell, row + 4, j] + a12 * motion[cell, row + 5, j]
            + a20 * motion[cell, row + 6, j] + a21 * motion[cell, row + 7, j] + a22 * motion[cell, row + 8, j]
            + n0 * motion[cell, shift, j] + n1 * motion[cell, shift + 1, j] + n2 * motion[cell, shift + 2, j] - c
        )  # fmt: skip
    n, x, p = abs(n0) + abs(n1) + abs(n2), abs(x0) + abs(x1) + abs(x2), abs(p0) + abs(p1) + abs(p2)
    stretch, far = motion[cell, ERRORS + 1, el], motion[cell, ERRORS + 1, es]
    err = n * (x * motion[cell, ERRORS, el] + motion[cell, ERRORS, es] + 4.0 * U8 * p)
    err += (n + dn) * (3.0 * stretch * rx + rp) + dn * (x * stretch + far + p)
    return err * 1.000001


@uncounted
def side_product(motion, slot, f, cell, a0, a1, a2, e0, e1, e2, m0, m1, m2, ra, f0, f1, f2, df, c0, c1, c2, rc):
    """Coefficients of the side product of the posed line (e; m) through a with the line along f through c.

    Into scratch row f; returns their error bound.  ra, rc: errors of coordinates; df: bound on the error of f, summed.
    side = f.(C m + W e) + (R e).(c x f), C the cofactors of R, W the products of the shift with its columns.
    """
    k0, k1, k2 = c1 * f2 - c2 * f1, c2 * f0 - c0 * f2, c0 * f1 - c1 * f0
    for j in range(TERMS):
        s = 0.0
        for i in range(3):
            g = f0 if i == 0 else f1 if i == 1 else f2
            k = k0 if i == 0 else k1 if i == 1 else k2
            r = 3 * i
            s += g * (
                motion[cell, COFACTOR + r, j] * m0 + motion[cell, COFACTOR + r + 1, j] * m1
                + motion[cell, COFACTOR + r + 2, j] * m2
                + motion[cell, MOMENT + r, j] * e0 + motion[cell, MOMENT + r + 1, j] * e1
                + motion[cell, MOMENT + r + 2, j] * e2
            ) + k * (
                motion[cell, LINEAR + r, j] * e0 + motion[cell, LINEAR + r + 1, j] * e1
                + motion[cell, LINEAR + r + 2, j] * e2
            )  # fmt: skip
        motion[slot, f, j] = s
    a, e, c = abs(a0) + abs(a1) + abs(a2), abs(e0) + abs(e1) + abs(e2), abs(c0) + abs(c1) + abs(c2)
    n = abs(f0) + abs(f1) + abs(f2)
    err = n * e * (
        a * motion[cell, ERRORS, E_COFACTOR] + motion[cell, ERRORS, E_MOMENT] + c * motion[cell, ERRORS, E_LINEAR]
    )  # fmt: skip
    if ra + rc + df > 0.0:  # side = -(c - a).(e x f) in the pose
        stretch, far = 3.0 * motion[cell, ERRORS + 1, E_LINEAR], motion[cell, ERRORS + 1, E_SHIFT]
        w, dw = a * stretch + 3.0 * far + c, 3.0 * (stretch * ra + rc)
        e, de = e * stretch, 6.0 * ra * stretch
        err += dw * (e + de) * (n + df) + w * de * (n + df) + w * e * df
    return err * 1.000001


@uncounted
def _range(motion, slot, f):
    lo = hi = motion[slot, f, 0]
    for j in range(1, TERMS):
        lo, hi = min(lo, motion[slot, f, j]), max(hi, motion[slot, f, j])
    return lo, hi


@uncounted
def sign_of(motion, slot, f, err):
    """1 or -1 where the function certainly has one sign all along, else 0."""
    lo, hi = _range(motion, slot, f)
    return 1 if lo > err else -1 if hi < -err else 0


@uncounted
def _halve(motion, slot, count):
    """De Casteljau: slot becomes the right half, slot + 1 the left half, of the first `count` rows.

    Row 5 of a slot: the interval, then the error bound of each row, which grows by seven roundings.
    """
    for f in range(count):
        most = 0.0
        for step in range(TERMS):
            motion[slot + 1, f, step] = motion[slot, f, 0]
            most = max(most, abs(motion[slot, f, step]))
            for j in range(LAST - step):
                motion[slot, f, j] = 0.5 * (motion[slot, f, j] + motion[slot, f, j + 1])
        motion[slot, 5, 2 + f] += U8 * most
        motion[slot + 1, 5, 2 + f] = motion[slot, 5, 2 + f]
    middle = 0.5 * (motion[slot, 5, 0] + motion[slot, 5, 1])
    motion[slot + 1, 5, 0], motion[slot + 1, 5, 1] = motion[slot, 5, 0], middle
    motion[slot, 5, 0] = middle


@uncounted
def _sides_of(motion, slot, edges):
    """Where the zero lies: -1 certainly outside the elements, 1 certainly inside both, 0 unsure.

    edges: rows 1 and 2 are the ends of one edge beside the other, rows 3 and 4 the other way round; else rows 1 to 3
    are the sides of a facet.
    """
    s1 = sign_of(motion, slot, 1, motion[slot, 5, 3])
    s2 = sign_of(motion, slot, 2, motion[slot, 5, 4])
    s3 = sign_of(motion, slot, 3, motion[slot, 5, 5])
    if edges:
        s4 = sign_of(motion, slot, 4, motion[slot, 5, 6])
        if s1 * s2 > 0 or s3 * s4 > 0:
            return -1
        return 1 if s1 * s2 < 0 and s3 * s4 < 0 else 0
    if s1 < 0 or s2 < 0 or s3 < 0:
        return -1
    return 1 if s1 > 0 and s2 > 0 and s3 > 0 else 0


@uncounted
def _first_zero(motion, top, edges, e0, e1, e2, e3, e4, start, width, first, best):
    """(verdict, lo, hi) of the first contact in a cell; rows 0 to 4 of scratch slot `top` hold its functions.

    A zero of row 0 where the others are in order is a contact.  CERTAIN: there is one in [lo, hi], none before lo.
    UNSURE: none before lo.
    """
    rows = 5 if edges else 4
    slot = top
    motion[slot, 5, 0], motion[slot, 5, 1] = 0.0, 1.0
    motion[slot, 5, 2], motion[slot, 5, 3], motion[slot, 5, 4] = e0, e1, e2
    motion[slot, 5, 5], motion[slot, 5, 6] = e3, e4
    # Slots top .. slot hold intervals in descending order that cover all of the cell in which a contact may be.
    while slot >= top:
        s0, s1, err = motion[slot, 5, 0], motion[slot, 5, 1], motion[slot, 5, 2]
        t0, t1 = start + width * s0, start + width * s1
        if t0 > best:
            return NONE, 0.0, 0.0
        lo, hi = _range(motion, slot, 0)
        if t1 < first or lo > err or hi < -err:
            slot -= 1
            continue
        where = _sides_of(motion, slot, edges)
        if where < 0:
            slot -= 1
            continue
        f0, f1 = motion[slot, 0, 0], motion[slot, 0, LAST]
        changes = where > 0 and ((f0 > err and f1 < -err) or (f0 < -err and f1 > err))
        flat = max(hi, -lo) <= 4.0 * err
        if changes and (flat or s1 - s0 <= FINEST):
            return CERTAIN, t0, t1
        if s1 - s0 <= FINEST or (flat and (where > 0 or s1 - s0 <= FINE)) or slot - top > 56:
            return UNSURE, t0, best
        _halve(motion, slot, rows)
        slot += 1
    return NONE, 0.0, 0.0


@uncounted
def _vertex_facet(motion, top, cell, back, x, i, rx, y, ry, n0, n1, n2, dn, start, width, first, best):
    """First contact in the cell of corner i of x with the facet y; back: y moves and x rests, seen from y."""
    row, shift, el, es = (BACK, BACK_SHIFT, E_BACK, E_BACK_SHIFT) if back else (LINEAR, SHIFT, E_LINEAR, E_SHIFT)
    x0, x1, x2 = x[i], x[i + 1], x[i + 2]
    e0 = height(motion, top, 0, cell, row, shift, el, es, x0, x1, x2, rx, n0, n1, n2, dn, y[0], y[1], y[2], ry)
    if sign_of(motion, top, 0, e0) != 0:
        return NONE, 0.0, 0.0
    e1 = e2 = e3 = 0.0
    for s in range(3):
        k, m = 3 * s, 3 * ((s + 1) % 3)
        f0, f1, f2 = y[m] - y[k], y[m + 1] - y[k + 1], y[m + 2] - y[k + 2]
        g0, g1, g2 = n1 * f2 - n2 * f1, n2 * f0 - n0 * f2, n0 * f1 - n1 * f0
        n, f = abs(n0) + abs(n1) + abs(n2), abs(f0) + abs(f1) + abs(f2)
        dg = 2.0 * (dn * (f + 6.0 * ry) + n * (6.0 * ry + U8 * f))
        err = height(
            motion, top, 1 + s, cell, row, shift, el, es, x0, x1, x2, rx, g0, g1, g2, dg, y[k], y[k + 1], y[k + 2], ry
        )
        if s == 0:
            e1 = err
        elif s == 1:
            e2 = err
        else:
            e3 = err
        if sign_of(motion, top, 1 + s, err) < 0:
            return NONE, 0.0, 0.0
    return _first_zero(motion, top, False, e0, e1, e2, e3, 0.0, start, width, first, best)


@uncounted
def _edge_edge(motion, top, cell, x, i, j, rx, y, k, m, ry, start, width, first, best):
    """First contact in the cell of edge ij of x, posed, with edge km of y."""
    a0, a1, a2 = x[i], x[i + 1], x[i + 2]
    e0, e1, e2 = x[j] - a0, x[j + 1] - a1, x[j + 2] - a2
    # the moment about the origin, of doubles: each product and the difference of the edge round
    m0, m1, m2 = a1 * e2 - a2 * e1, a2 * e0 - a0 * e2, a0 * e1 - a1 * e0
    c0, c1, c2 = y[k], y[k + 1], y[k + 2]
    f0, f1, f2 = y[m] - c0, y[m + 1] - c1, y[m + 2] - c2
    df = 6.0 * ry
    r0 = side_product(motion, top, 0, cell, a0, a1, a2, e0, e1, e2, m0, m1, m2, rx, f0, f1, f2, df, c0, c1, c2, ry)
    if sign_of(motion, top, 0, r0) != 0:
        return NONE, 0.0, 0.0
    # a direction across both edges as they stand in the middle of the cell; any direction proves, this one well
    p0 = p1 = p2 = q0 = q1 = q2 = 0.0
    for t in range(3, 5):
        p0 += 0.5 * (motion[cell, 0, t] * e0 + motion[cell, 1, t] * e1 + motion[cell, 2, t] * e2)
        p1 += 0.5 * (motion[cell, 3, t] * e0 + motion[cell, 4, t] * e1 + motion[cell, 5, t] * e2)
        p2 += 0.5 * (motion[cell, 6, t] * e0 + motion[cell, 7, t] * e1 + motion[cell, 8, t] * e2)
        q0 += 0.5 * (motion[cell, 0, t] * a0 + motion[cell, 1, t] * a1 + motion[cell, 2, t] * a2 + motion[cell, 9, t])
        q1 += 0.5 * (motion[cell, 3, t] * a0 + motion[cell, 4, t] * a1 + motion[cell, 5, t] * a2 + motion[cell, 10, t])
        q2 += 0.5 * (motion[cell, 6, t] * a0 + motion[cell, 7, t] * a1 + motion[cell, 8, t] * a2 + motion[cell, 11, t])
    g0, g1, g2 = p1 * f2 - p2 * f1, p2 * f0 - p0 * f2, p0 * f1 - p1 * f0
    n, e, f = abs(g0) + abs(g1) + abs(g2), abs(p0) + abs(p1) + abs(p2), abs(f0) + abs(f1) + abs(f2)
    if n <= 1e-3 * e * f:  # nearly parallel: apart where one end of each is on the same side, seen along this direction
        w0, w1, w2 = c0 - q0, c1 - q1, c2 - q2
        g0, g1, g2 = f1 * w2 - f2 * w1, f2 * w0 - f0 * w2, f0 * w1 - f1 * w0
        n = abs(g0) + abs(g1) + abs(g2)
    h0, h1, h2 = g1 * f2 - g2 * f1, g2 * f0 - g0 * f2, g0 * f1 - g1 * f0
    dh = 2.0 * n * (df + U8 * f)
    r1 = height(
        motion, top, 1, cell, LINEAR, SHIFT, E_LINEAR, E_SHIFT, a0, a1, a2, rx, h0, h1, h2, dh, c0, c1, c2, ry
    )
    r2 = height(
        motion, top, 2, cell, LINEAR, SHIFT, E_LINEAR, E_SHIFT, x[j], x[j + 1], x[j + 2], rx,
        h0, h1, h2, dh, c0, c1, c2, ry,
    )  # fmt: skip
    if sign_of(motion, top, 1, r1) * sign_of(motion, top, 2, r2) > 0:
        return NONE, 0.0, 0.0
    r3 = side_product(motion, top, 3, cell, a0, a1, a2, e0, e1, e2, m0, m1, m2, rx, g0, g1, g2, 0.0, c0, c1, c2, ry)
    r4 = side_product(
        motion, top, 4, cell, a0, a1, a2, e0, e1, e2, m0, m1, m2, rx, g0, g1, g2, 0.0, y[m], y[m + 1], y[m + 2], ry
    )
    return _first_zero(motion, top, True, r0, r1, r2, r3, r4, start, width, first, best)


@uncounted
def normal_of(y, ry):
    """(n, error summed over coordinates) of the facet y (9,)."""
    e0, e1, e2 = y[3] - y[0], y[4] - y[1], y[5] - y[2]
    f0, f1, f2 = y[6] - y[0], y[7] - y[1], y[8] - y[2]
    e, f = abs(e0) + abs(e1) + abs(e2), abs(f0) + abs(f1) + abs(f2)
    err = U8 * e * f + 12.0 * ry * (e + f + 6.0 * ry)
    return e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0, err


@uncounted
def _beside_plane(motion, top, cell, back, x, count, rx, y, ry, n0, n1, n2, dn):
    """Whether the corners of x stay on one side of the plane of y all through the cell."""
    row, shift, el, es = (BACK, BACK_SHIFT, E_BACK, E_BACK_SHIFT) if back else (LINEAR, SHIFT, E_LINEAR, E_SHIFT)
    before = 0
    for s in range(count):
        err = height(
            motion, top, 0, cell, row, shift, el, es, x[3 * s], x[3 * s + 1], x[3 * s + 2], rx,
            n0, n1, n2, dn, y[0], y[1], y[2], ry,
        )  # fmt: skip
        side = sign_of(motion, top, 0, err)
        if side == 0 or side * before < 0:
            return False
        before = side
    return True


@uncounted
def _note(floats, integers, times, candidates, kind, part_a, side_a, part_b, side_b, verdict, lo, hi):
    """Record a possible contact; whether the pair needs no further look."""
    if verdict == NONE:
        return False
    record(floats, integers, times, candidates, kind, part_a, side_a, part_b, side_b, verdict, lo, hi)
    return True


@uncounted
def boxes_of(x, y, out):
    """The boxes of three corners each (9,) into rows 6 and 7 of `out`."""
    for k in range(3):
        out[6, k], out[6, k + 3] = min(x[k], x[k + 3], x[k + 6]), max(x[k], x[k + 3], x[k + 6])
        out[7, k], out[7, k + 3] = min(y[k], y[k + 3], y[k + 6]), max(y[k], y[k + 3], y[k + 6])


def _events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    top = motion.shape[0] - SCRATCH
    levels, length = int(motion[0, ERRORS, LEVELS]), motion[0, ERRORS, LENGTH]
    count = 1 << levels
    width, slack = length / count, TIME_EPS * length
    facet_a, facet_b = mask_a & FACET != 0, mask_b & FACET != 0
    points_only = (mask_a & POINT and facet_b) or (mask_b & POINT and facet_a)
    boxes = motion[motion.shape[0] - 1]
    boxes_of(xa, xb, boxes)
    pad = 4.0 * (motion[0, ERRORS + 1, E_LINEAR] + 1.0) * (err_a + err_b) if err_a + err_b > 0.0 else 0.0
    n0, n1, n2, dn = normal_of(xb, err_b)
    m0, m1, m2, dm = normal_of(xa, err_a)
    done = 0  # bits of pairs that have their answer
    time = max(floats[KEY], floats[FIRST])
    # All before `time` is settled for the pairs not done.
    while True:
        time, cell = next_meeting(motion, boxes, 6, boxes, 7, pad, time, floats[BEST])
        if cell < 0:
            break
        start, first = length * cell / count, time
        index = count - 1 + cell
        time = max(time, length * (cell + 1) / count)  # the start of the next cell, to the bit
        last_cell = cell + 1 == count
        if not (
            (facet_b and _beside_plane(motion, top, index, False, xa, 3, err_a, xb, err_b, n0, n1, n2, dn))
            or (facet_a and _beside_plane(motion, top, index, True, xb, 3, err_b, xa, err_a, m0, m1, m2, dm))
        ):
            for s in range(3):
                if not mask_a & (sides << s) or points_only:
                    continue
                i, j = 3 * s, 3 * ((s + 1) % 3)
                for r in range(3):
                    bit = 1 << (3 * s + r)
                    if not mask_b & (sides << r) or done & bit:
                        continue
                    integers[TESTS] += 1
                    verdict, lo, hi = _edge_edge(
                        motion, top, index, xa, i, j, err_a, xb, 3 * r, 3 * ((r + 1) % 3), err_b,
                        start, width, first - slack, floats[BEST],
                    )  # fmt: skip
                    if _note(
                        floats, integers, times, candidates, EDGE_EDGE, pa, s, pb, r, verdict, lo - slack, hi + slack
                    ):
                        done |= bit
            for s in range(3):
                bit = 1 << (9 + s)
                if mask_a & (1 << (CORNER + s)) and facet_b and not done & bit:
                    integers[TESTS] += 1
                    verdict, lo, hi = _vertex_facet(
                        motion, top, index, False, xa, 3 * s, err_a, xb, err_b, n0, n1, n2, dn,
                        start, width, first - slack, floats[BEST],
                    )  # fmt: skip
                    if _note(
                        floats, integers, times, candidates, VERTEX_FACE, pa, s, pb, WHOLE,
                        verdict, lo - slack, hi + slack,
                    ):
                        done |= bit
                bit = 1 << (12 + s)
                if mask_b & (1 << (CORNER + s)) and facet_a and not done & bit:
                    integers[TESTS] += 1
                    verdict, lo, hi = _vertex_facet(
                        motion, top, index, True, xb, 3 * s, err_b, xa, err_a, m0, m1, m2, dm,
                        start, width, first - slack, floats[BEST],
                    )  # fmt: skip
                    if _note(
                        floats, integers, times, candidates, FACE_VERTEX, pa, WHOLE, pb, s,
                        verdict, lo - slack, hi + slack,
                    ):
                        done |= bit
        if last_cell:
            break


@implements(earliest_meeting, 3)
def _earliest_meeting(motion, boxes_a, a, boxes_b, b, pad, first, last):
    if motion.ndim == 3:
        return lambda motion, boxes_a, a, boxes_b, b, pad, first, last: next_meeting(
            motion, boxes_a, np.int64(a), boxes_b, np.int64(b), pad, first, last
        )[0]
    return None


@implements(is_new, 3)
def _is_new(motion, side, node):
    return (lambda motion, side, node: False) if motion.ndim == 3 else None


@implements(get_ready, 3)
def _get_ready(motion, side, boxes, links, xyz, ids, node, pad):
    return (lambda motion, side, boxes, links, xyz, ids, node, pad: None) if motion.ndim == 3 else None


@implements(first_is_larger, 3)
def _first_is_larger(motion, boxes_a, a, boxes_b, b):
    if motion.ndim == 3:
        return lambda motion, boxes_a, a, boxes_b, b: area(boxes_a, a) >= area(boxes_b, b)
    return None


@implements(test_events, 3)
def _test_events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    if motion.ndim == 3:
        return _events
    return None


@kernel
def pair_window(motion, kind, xa, xb, err_a, err_b, first, last):
    """(verdict, lo, hi) of the first contact of two elements in [first, last], seen alone.

    xa, xb (9,): corners, the last one repeated.  NONE: they certainly do not meet; CERTAIN: they do in [lo, hi], not
    before lo; UNSURE: not before lo.
    """
    # as in trees, whose walk has the same code
    part, side, corner = np.int32(0), np.int32(1), np.int32(1 << CORNER)
    mask_a = side if kind == EDGE_EDGE else corner if kind == VERTEX_FACE else np.int32(FACET)
    mask_b = side if kind == EDGE_EDGE else corner if kind == FACE_VERTEX else np.int32(FACET)
    floats = np.array([first, -np.inf, np.inf, last, first, 1.0])
    integers = np.zeros(7, np.int64)
    times, candidates = np.empty((32, 2)), np.empty((32, 5), np.int32)
    sides = np.int64(side)
    test_events(motion, part, mask_a, xa, part, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates)
    if integers[CANDIDATES] == 0:
        return NONE, 0.0, 0.0
    return (CERTAIN if candidates[0, 0] >= CERTAIN_KIND else UNSURE), max(first, times[0, 0]), times[0, 1]
