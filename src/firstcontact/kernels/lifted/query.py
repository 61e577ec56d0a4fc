"""What a moving edge or vertex asks of a cell of edges or facets: may any of its elements be met?

A query is an array (ROWS, 6).  FORMS: linear forms in the lines (edges) or planes (facets) of the elements; an element
all of whose values have one strict sign is not met.  SIDES: the same for a second set of forms, always in the lines.
BOX: where the query begins; SHIFT: how it moves until its end (and the inverse); SIZES: how many forms, and the sizes
that rounding errors scale with; SLAB: the plane that holds an edge's parallelogram, and the rounding of BOX and SHIFT.

With u = 2^-53, L the largest coordinate about the tree's origin, eps = 4 u L + (errors of coordinates) and E, F the
1-norms of two directions, a product of two lines computed from rounded end points is within 1024 eps L (E + F) of the
true one: end points about the origin are off by eps, directions by 4 eps, moments by 8 eps (E + L), and the products
of these and their own roundings add up to less than 700 eps L (E + F).  Sums over the axes of a box mix entries of
different size: 8 u per term, 36 terms twice the size of a vector.  All of that is `line_slack`.  `plane_slack` is the
same for n.p - n.a of normals n with largest entry 1: they are off by 32 eps S / |n|, S the 1-norm of the sides.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.lifted.principal import form_range
from firstcontact.kernels.verdict import LOST

# Slots of a cell: box (6), largest |f|, largest coordinate about the origin, largest S / |n| of its facets, each in
# 1-norms (|n| in the largest entry); then the box of lines and, of facets, the box of planes.
REACH, FAR, NEEDLE, LINES = 6, 7, 8, 9
PLANES = LINES + 2 + 2 * 6 + 36

# Rows of a query.
FORMS, SIDES, BOX, SHIFT, SIZES, SLAB, ROWS = 0, 3, 5, 6, 7, 8, 9
# Slots of the row SIZES: number of forms and of sides, E of each, L.
N_FORMS, N_SIDES, E_FORMS, E_SIDES, L_QUERY, HAS_SLAB = range(6)
_U = 2.0**-53


@uncounted
def line_slack(far, reach, e, scale, err):
    """Bound on the rounding of a form in lines with |f| <= reach, coordinates <= far; e: the query's direction."""
    eps = 4.0 * _U * far + err
    mixed = 1.0 + 2.0 * far / scale
    return 1024.0 * (eps * (far / scale) * (e + reach) + _U * mixed * mixed * e * reach) + LOST


@uncounted
def plane_slack(far, needle, scale, err):
    eps = 4.0 * _U * far + err
    mixed = 1.0 + 3.0 * far / scale
    return 1024.0 * (eps * (far / scale) * needle + _U * mixed * mixed)


@uncounted
def may_meet(row, query, facets, scale, origin, err):
    """False only when the query certainly meets no element of the cell."""
    if not _boxes_meet(row, query, err):
        return False
    sizes = query[SIZES]
    far = max(row[FAR], sizes[L_QUERY])
    if sizes[HAS_SLAB] != 0.0 and _misses_slab(row, query, origin, far, err):
        return False
    if facets:
        slack = plane_slack(far, row[NEEDLE], scale, err)
        if one_sign(row, PLANES, 4, query, FORMS, int(sizes[N_FORMS]), slack):
            return False
    else:
        slack = line_slack(far, row[REACH], sizes[E_FORMS], scale, err)
        if one_sign(row, LINES, 6, query, FORMS, int(sizes[N_FORMS]), slack):
            return False
    slack = line_slack(far, row[REACH], sizes[E_SIDES], scale, err)
    return not one_sign(row, LINES, 6, query, SIDES, int(sizes[N_SIDES]), slack)


@uncounted
def one_sign(row, offset, d, query, first, count, slack):
    """Whether `count` > 0 forms all are positive, or all negative, on the box; false when anything is not a number."""
    sign = 0.0
    for k in range(first, first + count):
        value, reach = form_range(row, offset, query[k], d)
        if value > reach + slack and sign >= 0.0:
            sign = 1.0
        elif -value > reach + slack and sign <= 0.0:
            sign = -1.0
        else:
            return False
    return count > 0


@uncounted
def _boxes_meet(row, query, err):
    """The slab test over one unit of time, each time widened by the roundings it carries (4, relative)."""
    box, shift = query[BOX], query[SHIFT]
    pad = 2.0 * err + query[SLAB, 5]
    lo, hi = 0.0, 1.0
    for k in range(3):
        ahead = row[k] - box[k + 3] - pad
        behind = row[k + 3] - box[k] + pad
        if shift[k] == 0.0:
            if ahead > 0.0 or behind < 0.0:
                return False
            continue
        t0, t1 = ahead * shift[k + 3], behind * shift[k + 3]
        if shift[k] < 0.0:
            t0, t1 = t1, t0
        lo, hi = max(lo, t0 - 1e-15 * abs(t0)), min(hi, t1 + 1e-15 * abs(t1))
    return lo <= hi


@uncounted
def _misses_slab(row, query, origin, far, err):
    """Whether the box of the cell lies on one side of the plane of the parallelogram."""
    slab = query[SLAB]
    value, reach = -slab[3], 0.0
    for k in range(3):
        value += slab[k] * (0.5 * (row[k] + row[k + 3]) - origin[k])
        reach += abs(slab[k]) * 0.5 * (row[k + 3] - row[k])
    eps = 4.0 * _U * far + err
    return abs(value) > reach * (1.0 + 1e-14) + 1024.0 * eps * far * slab[4] + LOST


@uncounted
def write_form(query, r, x0, x1, x2, e0, e1, e2, scale):
    """The form of the line through x along e: (moment / scale; direction)."""
    row = query[r]
    row[0] = (x1 * e2 - x2 * e1) / scale
    row[1] = (x2 * e0 - x0 * e2) / scale
    row[2] = (x0 * e1 - x1 * e0) / scale
    row[3], row[4], row[5] = e0, e1, e2


@uncounted
def norm1(x, y, z):
    return abs(x) + abs(y) + abs(z)


@uncounted
def largest(x, y, z):
    return max(abs(x), abs(y), abs(z))


@uncounted
def write_swept_edge(query, x, y, start, shift, origin, scale):
    """The edge from x to y (3,), moved by `start` and then along `shift` (3,): a parallelogram.

    An edge is met only when its line passes the two positions on different sides, and the two paths of the ends.
    """
    a0, a1, a2 = x[0] - origin[0] + start[0], x[1] - origin[1] + start[1], x[2] - origin[2] + start[2]
    b0, b1, b2 = y[0] - origin[0] + start[0], y[1] - origin[1] + start[1], y[2] - origin[2] + start[2]
    e0, e1, e2 = y[0] - x[0], y[1] - x[1], y[2] - x[2]
    d0, d1, d2 = shift[0], shift[1], shift[2]
    write_form(query, FORMS, a0, a1, a2, e0, e1, e2, scale)
    write_form(query, FORMS + 1, a0 + d0, a1 + d1, a2 + d2, e0, e1, e2, scale)
    write_form(query, SIDES, a0, a1, a2, d0, d1, d2, scale)
    write_form(query, SIDES + 1, b0, b1, b2, d0, d1, d2, scale)
    far = max(largest(a0, a1, a2), largest(b0, b1, b2))
    far = max(far, largest(a0 + d0, a1 + d1, a2 + d2), largest(b0 + d0, b1 + d1, b2 + d2))
    sizes, slab = query[SIZES], query[SLAB]
    sizes[N_FORMS], sizes[N_SIDES] = 2, 2
    sizes[E_FORMS], sizes[E_SIDES] = norm1(e0, e1, e2), norm1(d0, d1, d2)
    sizes[L_QUERY], sizes[HAS_SLAB] = far, 1.0
    slab[0], slab[1], slab[2] = e1 * d2 - e2 * d1, e2 * d0 - e0 * d2, e0 * d1 - e1 * d0
    slab[3] = slab[0] * a0 + slab[1] * a1 + slab[2] * a2
    slab[4] = sizes[E_FORMS] + sizes[E_SIDES]
    for k in range(3):
        query[BOX, k], query[BOX, k + 3] = min(x[k], y[k]) + start[k], max(x[k], y[k]) + start[k]
    _write_shift(query, d0, d1, d2, far)


@uncounted
def write_segment(query, x, start, shift, origin, scale):
    """The path of the point x (3,), moved by `start` and then along `shift` (3,), as a query for facets."""
    p0, p1, p2 = x[0] - origin[0] + start[0], x[1] - origin[1] + start[1], x[2] - origin[2] + start[2]
    d0, d1, d2 = shift[0], shift[1], shift[2]
    write_plane_form(query, FORMS, p0, p1, p2, 1.0, scale)
    write_plane_form(query, FORMS + 1, p0 + d0, p1 + d1, p2 + d2, 1.0, scale)
    write_form(query, SIDES, p0, p1, p2, d0, d1, d2, scale)
    far = max(largest(p0, p1, p2), largest(p0 + d0, p1 + d1, p2 + d2))
    sizes = query[SIZES]
    sizes[N_FORMS], sizes[N_SIDES], sizes[E_FORMS], sizes[E_SIDES] = 2, 1, 0.0, norm1(d0, d1, d2)
    sizes[L_QUERY], sizes[HAS_SLAB] = far, 0.0
    for k in range(3):
        query[BOX, k] = query[BOX, k + 3] = x[k] + start[k]
    _write_shift(query, d0, d1, d2, far)


@uncounted
def write_plane_form(query, r, p0, p1, p2, weight, scale):
    """The form n.p + weight (-n.a), divided by scale."""
    query[r, 0], query[r, 1], query[r, 2], query[r, 3] = p0 / scale, p1 / scale, p2 / scale, weight


@uncounted
def _write_shift(query, d0, d1, d2, far):
    shift = query[SHIFT]
    _write_rounding(query, norm1(d0, d1, d2))
    shift[0], shift[1], shift[2] = d0, d1, d2
    for k in range(3):
        # a shift lost in the roundings of the box would give no slab: the box grows by it instead
        if abs(shift[k]) <= 1e-14 * far:
            query[BOX, k] -= abs(shift[k])
            query[BOX, k + 3] += abs(shift[k])
            shift[k] = 0.0
        shift[k + 3] = 1.0 / shift[k] if shift[k] != 0.0 else np.inf


@uncounted
def write_turned_edge(query, a, b, da, db, a_end, b_end, tc, origin, scale):
    """The edge ab turning about an axis along z: its ends (3,) at the beginning and the end of an arc, their

    velocities there (per radian), tc = tan(arc / 2) or a little more.  (1 + tan^2) g, g the product of two lines, is a
    quadratic in tan(angle / 2); its Bernstein coefficients over the arc are these forms (Schoemer & Thiel 1995, 4.2).
    """
    a0, a1, a2 = a[0] - origin[0], a[1] - origin[1], a[2] - origin[2]
    e0, e1, e2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    g0, g1 = db[0] - da[0], db[1] - da[1]
    write_form(query, FORMS, a0, a1, a2, e0, e1, e2, scale)
    row, first = query[FORMS + 1], query[FORMS]
    # derivative of (a x e; e): (da x e + a x de; de)
    row[0] = first[0] + tc * (da[1] * e2 - a2 * g1) / scale
    row[1] = first[1] + tc * (a2 * g0 - da[0] * e2) / scale
    row[2] = first[2] + tc * (da[0] * e1 - da[1] * e0 + a0 * g1 - a1 * g0) / scale
    row[3], row[4], row[5] = e0 + tc * g0, e1 + tc * g1, e2
    c0, c1, c2 = a_end[0] - origin[0], a_end[1] - origin[1], a_end[2] - origin[2]
    h0, h1, h2 = b_end[0] - a_end[0], b_end[1] - a_end[1], b_end[2] - a_end[2]
    write_form(query, FORMS + 2, c0, c1, c2, h0, h1, h2, scale)
    for k in range(6):
        query[FORMS + 2, k] *= 1.0 + tc * tc
    far = max(largest(a0, a1, a2), largest(c0, c1, c2))
    far = max(far, largest(a0 + e0, a1 + e1, a2 + e2), largest(c0 + h0, c1 + h1, c2 + h2))
    sizes = query[SIZES]
    sizes[N_FORMS], sizes[N_SIDES], sizes[HAS_SLAB] = 3, 0, 0.0
    # with tc < 1/4 forms are less than twice as large; positions carry some 11 roundings of the radius in all
    sizes[E_FORMS], sizes[E_SIDES] = 2.0 * max(norm1(e0, e1, e2), norm1(h0, h1, h2)), 0.0
    sizes[L_QUERY] = 4.0 * max(far, largest(da[0], da[1], 0.0), largest(db[0], db[1], 0.0))
    _write_arc_box(query, a, b, a_end, b_end, da, db, tc)


@uncounted
def write_turned_point(query, p, dp, p_end, tc, origin, scale):
    """The same for a point and the planes of facets."""
    p0, p1, p2 = p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]
    q0, q1, q2 = p_end[0] - origin[0], p_end[1] - origin[1], p_end[2] - origin[2]
    w = 1.0 + tc * tc
    write_plane_form(query, FORMS, p0, p1, p2, 1.0, scale)
    write_plane_form(query, FORMS + 1, p0 + tc * dp[0], p1 + tc * dp[1], p2, 1.0, scale)
    write_plane_form(query, FORMS + 2, w * q0, w * q1, w * q2, w, scale)
    sizes = query[SIZES]
    sizes[N_FORMS], sizes[N_SIDES], sizes[E_FORMS], sizes[E_SIDES], sizes[HAS_SLAB] = 3, 0, 0.0, 0.0, 0.0
    sizes[L_QUERY] = 4.0 * max(largest(p0, p1, p2), largest(q0, q1, q2), largest(dp[0], dp[1], 0.0))
    _write_arc_box(query, p, p, p_end, p_end, dp, dp, tc)


@uncounted
def _write_arc_box(query, a, b, a_end, b_end, da, db, tc):
    """Chords of arcs are off by r (1 - cos(arc / 2)) <= r tc^2 / 2 at most."""
    bulge = 0.5 * tc * tc * 1.01 * max(norm1(da[0], da[1], 0.0), norm1(db[0], db[1], 0.0))
    for k in range(3):
        grow = bulge if k < 2 else 0.0
        query[BOX, k] = min(a[k], b[k], a_end[k], b_end[k]) - grow
        query[BOX, k + 3] = max(a[k], b[k], a_end[k], b_end[k]) + grow
        query[SHIFT, k], query[SHIFT, k + 3] = 0.0, np.inf
    _write_rounding(query, 4.0 * max(norm1(da[0], da[1], 0.0), norm1(db[0], db[1], 0.0)))


@uncounted
def _write_rounding(query, size):
    """The box and what is added to it on the way are off by a few roundings of their size."""
    for k in range(6):
        size = max(size, abs(query[BOX, k]))
    query[SLAB, 5] = 16.0 * _U * size
