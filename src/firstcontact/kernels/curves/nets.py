"""Ruled pieces in Bernstein form on intervals of their parameter, with bounds on the errors of all coefficients.

Interval k of a side is a node of a binary tree: its first nodes are the parts of the chain, children are made when they
are asked for.  A coefficient of a part is wrong by at most its size times a few roundings, and every halving averages
coefficients `degree` times: all bounds below are sizes times counted roundings.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted

ROUND = 2.0**-53
# One side is one array (nodes, ROWS_OF_SIDE, columns), since every array that a kernel takes costs time at each call.
# Rows: X, Y, Z, W of the directrix at s = 0, then of that at s = 1, homogeneous Bernstein coefficients about a common
# centre; Pluecker coordinates 01, 02, 03, 12, 13, 23 of the rulings; facts; what the first 14 rows do not exceed
# before cancellation.
FIRST, SECOND = np.int64(0), np.int64(4)
LINES, FACTS, SIZES, ROWS_OF_SIDE = 8, 14, 15, 16
# Columns of the facts: corners of a box that holds all rulings, rounded outward; the interval within its part, in
# [0, 1]; number of the part; halvings so far; the first of two children or 0; degree of the points; of node 0: nodes in
# use.
BOX_LO, BOX_HI, LO, HI, PART, DEPTH, CHILD, DEGREE, COUNT = 0, 3, 6, 7, 8, 9, 10, 11, 12
LEAST_COLUMNS = 14
# An average (1 - r) a + r b: roundings of 1 - r, of both products and of the sum.
AVERAGE = 4.0
# Where an interval is cut, about the middle; uneven, so that symmetric input meets no border of a cell.
NEAR_MIDDLE, SPREAD, GOLDEN = 0.45, 0.1, 0.6180339887498949


@uncounted
def degree(side):
    return int(side[0, FACTS, DEGREE])


@uncounted
def part_of(side, k):
    return int(side[k, FACTS, PART])


@uncounted
def point_error(side, k):
    """Errors of the points of a node, in units of their sizes."""
    return (8.0 + AVERAGE * side[k, FACTS, DEGREE] * side[k, FACTS, DEPTH]) * ROUND


@uncounted
def line_error(side, k):
    """Errors of the lines of a node, in units of their sizes: products of points, n + 1 of them added, and halvings."""
    n = side[k, FACTS, DEGREE]
    return (2.0 * n + 24.0 + AVERAGE * 2.0 * n * side[k, FACTS, DEPTH]) * ROUND


@uncounted
def bound(side, k):
    """Set the box of a node: the rulings lie in the hull of the control points, whose weights are positive."""
    error = point_error(side, k)
    for c in range(3):
        lo, hi, slack = np.inf, -np.inf, 0.0
        for first in (FIRST, SECOND):
            for a in range(degree(side) + 1):
                w = side[k, first + 3, a]
                x = side[k, first + c, a] / w
                lo, hi = min(lo, x), max(hi, x)
                slack = max(slack, (side[k, SIZES, first + c] + abs(x) * side[k, SIZES, first + 3]) / w)
        slack *= 2.0 * error
        side[k, FACTS, BOX_LO + c], side[k, FACTS, BOX_HI + c] = lo - slack, hi + slack


@uncounted
def begin(points, centre, table, side, forms):
    """Fill in the parts of a side, coordinates about the centre, and the forms that `curve_points.evaluate` takes.

    points: (parts, 8, n + 1) as in `Chain`; table: coefficient c of the product of two polynomials of degree n from
    products of theirs; forms: (parts, 2, n + 1, 8): points of the parts, and their derivatives.
    """
    parts, n = points.shape[0], points.shape[2] - 1
    for part in range(parts):
        node = side[part]
        for c in range(LEAST_COLUMNS):
            node[FACTS, c] = node[SIZES, c] = 0.0
        node[FACTS, HI], node[FACTS, PART], node[FACTS, DEGREE] = 1.0, part, n
        for row in range(LINES):
            shift = centre[row % 4] if row % 4 < 3 else 0.0
            for a in range(n + 1):
                x, w = points[part, row, a], points[part, row - row % 4 + 3, a]
                node[row, a] = x - shift * w
                forms[part, 0, a, row] = node[row, a]
                node[SIZES, row] = max(node[SIZES, row], abs(x) + abs(shift) * abs(w))
            for a in range(n):
                forms[part, 1, a, row] = n * (node[row, a + 1] - node[row, a])
            forms[part, 1, n, row] = 0.0
        row = LINES
        for i in range(3):
            for j in range(i + 1, 4):
                for c in range(2 * n + 1):
                    node[row, c] = 0.0
                for a in range(n + 1):
                    for b in range(n + 1):
                        x = node[i, a] * node[4 + j, b] - node[j, a] * node[4 + i, b]
                        node[row, a + b] += x * table[a, b]
                sizes = node[SIZES]
                node[SIZES, row] = sizes[i] * sizes[4 + j] + sizes[j] * sizes[4 + i]
                row += 1
    side[0, FACTS, COUNT] = parts
    for part in range(parts):
        bound(side, part)


@uncounted
def hull(points, box):
    """Set the (2, 3) corners of a box that holds all rulings of parts as in `begin`, with room for rounding."""
    for c in range(3):
        box[0, c], box[1, c] = np.inf, -np.inf
        for part in range(points.shape[0]):
            for first in (FIRST, SECOND):
                for a in range(points.shape[2]):
                    x = points[part, first + c, a] / points[part, first + 3, a]
                    box[0, c], box[1, c] = min(box[0, c], x), max(box[1, c], x)
    far = 0.0
    for c in range(3):
        far = max(far, max(abs(box[0, c]), abs(box[1, c])))
    for c in range(3):
        box[0, c] -= 1e-12 * far
        box[1, c] += 1e-12 * far


@uncounted
def _halve(side, k, to, row, count, r):
    """De Casteljau's steps at r: nodes `to` and `to + 1` get the coefficients on both parts of interval k."""
    for j in range(count):
        side[to + 1, row, j] = side[k, row, j]
    side[to, row, 0] = side[k, row, 0]
    for step in range(1, count):
        for j in range(count - step):
            side[to + 1, row, j] = (1.0 - r) * side[to + 1, row, j] + r * side[to + 1, row, j + 1]
        side[to, row, step] = side[to + 1, row, 0]


@uncounted
def halves(side, k):
    """The first of the two children of a node; 0 where there is no room for them."""
    to = int(side[k, FACTS, CHILD])
    if to > 0:
        return to
    to = int(side[0, FACTS, COUNT])
    if to + 2 > side.shape[0]:
        return 0
    side[0, FACTS, COUNT] = to + 2
    side[k, FACTS, CHILD] = to
    r = NEAR_MIDDLE + SPREAD * ((to * GOLDEN) % 1.0)
    n = degree(side)
    for child in (to, to + 1):
        for c in range(LEAST_COLUMNS):
            side[child, FACTS, c], side[child, SIZES, c] = side[k, FACTS, c], side[k, SIZES, c]
        side[child, FACTS, DEPTH] += 1.0
        side[child, FACTS, CHILD] = 0.0
    middle = side[k, FACTS, LO] + r * (side[k, FACTS, HI] - side[k, FACTS, LO])
    side[to, FACTS, HI] = side[to + 1, FACTS, LO] = middle
    for row in range(FACTS):
        _halve(side, k, to, row, n + 1 if row < LINES else 2 * n + 1, r)
    bound(side, to)
    bound(side, to + 1)
    return to


@uncounted
def delta_at(p, i, a, q, j, b):
    """Coefficient [a, b] of Delta on the cell of node i of p and node j of q; the sides may be exchanged."""
    return (
        p[i, LINES, a] * q[j, LINES + 5, b] - p[i, LINES + 1, a] * q[j, LINES + 4, b]
        + p[i, LINES + 2, a] * q[j, LINES + 3, b] + p[i, LINES + 3, a] * q[j, LINES + 2, b]
        - p[i, LINES + 4, a] * q[j, LINES + 1, b] + p[i, LINES + 5, a] * q[j, LINES, b]
    )  # fmt: skip


@uncounted
def delta_size(p, i, q, j):
    """What no coefficient of Delta exceeds, with room for roundings."""
    size = 0.0
    for c in range(6):
        size += p[i, SIZES, LINES + c] * q[j, SIZES, LINES + 5 - c]
    return 1.01 * size


@uncounted
def delta_error(p, i, q, j):
    """Of all coefficients of Delta on a cell: errors of both lines, six products and their sum."""
    return delta_size(p, i, q, j) * (line_error(p, i) + line_error(q, j) + 8.0 * ROUND)


@uncounted
def delta_net(p, i, q, j, net):
    """Coefficients of Delta on the cell of two nodes."""
    for a in range(2 * degree(p) + 1):
        for b in range(2 * degree(q) + 1):
            net[a, b] = delta_at(p, i, a, q, j, b)


@uncounted
def planes_net(side, k, d, planes):
    """Coefficients [c, b] of the planes through the rulings of a node and the direction d, and sizes of the four rows.

    [X, ruling, d] = sum over c of X_c planes[c]: its sign tells on which side of the ruling X is, seen along d.
    """
    for b in range(2 * degree(side) + 1):
        x0, x1, x2 = side[k, LINES, b], side[k, LINES + 1, b], side[k, LINES + 2, b]
        x3, x4, x5 = side[k, LINES + 3, b], side[k, LINES + 4, b], side[k, LINES + 5, b]
        planes[0, b] = d[1] * x5 - d[2] * x4
        planes[1, b] = d[2] * x2 - d[0] * x5
        planes[2, b] = d[0] * x4 - d[1] * x2
        planes[3, b] = d[1] * x1 - d[2] * x0 - d[0] * x3
    d0, d1, d2 = abs(d[0]), abs(d[1]), abs(d[2])
    s0, s1, s2 = side[k, SIZES, LINES], side[k, SIZES, LINES + 1], side[k, SIZES, LINES + 2]
    s3, s4, s5 = side[k, SIZES, LINES + 3], side[k, SIZES, LINES + 4], side[k, SIZES, LINES + 5]
    return d1 * s5 + d2 * s4, d2 * s2 + d0 * s5, d0 * s4 + d1 * s2, d1 * s1 + d2 * s0 + d0 * s3


@uncounted
def side_net(side, k, first, other, other_k, planes, sizes, net):
    """Coefficients [a, b] of [X, ruling of the other, d], X the directrix that begins in row `first`; their error."""
    for a in range(degree(side) + 1):
        x0, x1, x2, x3 = side[k, first, a], side[k, first + 1, a], side[k, first + 2, a], side[k, first + 3, a]
        for b in range(2 * degree(other) + 1):
            net[a, b] = x0 * planes[0, b] + x1 * planes[1, b] + x2 * planes[2, b] + x3 * planes[3, b]
    size = 0.0
    for c in range(4):
        size += side[k, SIZES, first + c] * sizes[c]
    return 1.01 * size * (point_error(side, k) + line_error(other, other_k) + 12.0 * ROUND)


@uncounted
def extent(net, n, m):
    """Least and largest of the coefficients [a, b], a <= n, b <= m."""
    lo = hi = net[0, 0]
    for a in range(n + 1):
        for b in range(m + 1):
            lo, hi = min(lo, net[a, b]), max(hi, net[a, b])
    return lo, hi


@uncounted
def slopes(net, n, m):
    """Ranges of the partial derivatives, by a and by b, and how much the coefficients vary along each in all."""
    low_a = low_b = np.inf
    high_a = high_b = -np.inf
    along_a = along_b = 0.0
    for a in range(n + 1):
        for b in range(m + 1):
            if a < n:
                d = net[a + 1, b] - net[a, b]
                low_a, high_a, along_a = min(low_a, d), max(high_a, d), along_a + abs(d)
            if b < m:
                d = net[a, b + 1] - net[a, b]
                low_b, high_b, along_b = min(low_b, d), max(high_b, d), along_b + abs(d)
    return n * low_a, n * high_a, m * low_b, m * high_b, along_a / n, along_b / m


