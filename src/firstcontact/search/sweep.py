"""The plane sweep for vertices against facets under a translation (Schoemer & Thiel 1995, section 6).

Facets are taken in groups of about sqrt(n).  Seen along the motion a group is an arrangement of O(n) pieces, swept by a
line once, which stops at every vertex: what lies over a region of the arrangement is a set of facets in one order, that
of their heights along the motion, and a search tree over them tells in logarithmic time which one a vertex under it
meets first.  Neighbouring regions differ by one facet, so their trees share all but one path (path copying).  In all
O(n^{3/2} log n) for facets that do not cross each other.

Nothing rests on rounded coordinates alone: each facet covers one or two cells that reach beyond it by MARGIN, far more
than arcs (the upper and lower bounds of cells) can be out of order; the order of heights is that of all pairs of facets
over all that their cells share, within a tolerance; and every facet whose height leaves it open is put to the pair
test.  Facets that cross another one of their group, or stand so steep or so slender that heights over them say little,
are `loose`: in trees of their own, all of which are tested.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.heap import heap_pop, heap_push
from firstcontact.kernels.jit import kernel
from firstcontact.search.state import BEST, CANDIDATES, DONE, FIRST, FULL, LEAF_ROOM, VISITS
from firstcontact.search.tree import SIDE
from firstcontact.search.walk import test_events

# In units of the size of the facets: how far cells reach beyond their facet.
MARGIN = 2.0**-24
# Facets steeper than this (height by length), with sides steeper than this (in the plane of the sweep) or narrower than
# this are loose.
STEEP, STEEP_SIDE, NARROW = 64.0, 256.0, 4.0 * MARGIN
# Roundings of heights and places of normalised coordinates, generously.
ROUNDING = 2.0**-46
# The sweep found its arcs in an order that cannot be (never seen): the group is to be tested facet by facet.
LOST = 16

NONE = np.int32(-1)


class Trees(NamedTuple):
    """Search trees that share nodes (q,): cell, left, right; `used` (1,) nodes; older nodes never change."""

    cell: np.ndarray
    left: np.ndarray
    right: np.ndarray
    used: np.ndarray


class Cells(NamedTuple):
    """Of a group: facets (c,), x (c, 2), arcs (2c, 3) lower and upper in turn: middle x, y there, slope."""

    facets: np.ndarray
    x: np.ndarray
    arcs: np.ndarray


class Order(NamedTuple):
    """Of facets: planes (f, 3) height = p0 + p1 x + p2 y, loose (f,), precedes (f, f): may i come before j."""

    planes: np.ndarray
    loose: np.ndarray
    precedes: np.ndarray


# --------------------------------------------------------------------------------------------------- cells


@kernel
def cells_of(corners, noise):
    """The cells of facets with corners (f, 3, 3) in the frame of the sweep, their planes, and tolerances (f,) of

    heights; a tolerance of inf makes a facet loose.
    """
    f = corners.shape[0]
    facets, x, arcs = np.empty(2 * f, np.int32), np.empty((2 * f, 2)), np.empty((4 * f, 3))
    planes, tolerances = np.zeros((f, 3)), np.empty(f)
    count = 0
    for i in range(f):
        p = corners[i]
        first, last = 0, 0
        for k in range(1, 3):
            if p[k, 0] < p[first, 0]:
                first = k
            if p[k, 0] >= p[last, 0]:
                last = k
        if first == last:
            first, last = 0, 1
        middle = 3 - first - last
        steepest = 0.0
        for half in range(2):
            a, b = (first, middle) if half == 0 else (middle, last)
            facets[count], x[count, 0], x[count, 1] = i, p[a, 0] - MARGIN, p[b, 0] + MARGIN
            beyond = 0.5 * (p[a, 1] + p[b, 1]) >= _height_of_side(p[first], p[last], 0.5 * (p[a, 0] + p[b, 0]))
            long, short = (0, 1) if beyond else (1, 0)
            s = _write_arc(arcs[2 * count + long], p[first], p[last], x[count], -1.0 if beyond else 1.0)
            t = _write_arc(arcs[2 * count + short], p[a], p[b], x[count], 1.0 if beyond else -1.0)
            steepest = max(steepest, s, t)
            count += 1
        tolerances[i] = _write_plane(planes[i], p, steepest, noise)
    return facets, x, arcs, planes, tolerances


@kernel
def _height_of_side(p, q, x):
    """y at x of the side from p to q, at its middle where it is upright."""
    if q[0] - p[0] <= 0.0:
        return 0.5 * (p[1] + q[1])
    return p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1])


@kernel
def _write_arc(arc, p, q, x, way):
    """A straight line on or beyond the side pq, seen in the way -1 or 1, and MARGIN away; returns its slope's size.

    Steep sides get a level line beyond both ends; then the slope is inf unless they are short.
    """
    width, rise = q[0] - p[0], q[1] - p[1]
    slope = rise / width if width > 0.0 else np.inf
    if abs(slope) <= STEEP_SIDE:
        arc[0], arc[1], arc[2] = 0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]) + way * MARGIN * (1.0 + abs(slope)), slope
        return abs(slope)
    arc[0], arc[2] = 0.5 * (x[0] + x[1]), 0.0
    arc[1] = max(p[1], q[1]) + MARGIN if way > 0.0 else min(p[1], q[1]) - MARGIN
    return abs(rise) / MARGIN


@kernel
def _write_plane(plane, p, steepest, noise):
    """Write the plane of the triangle p; returns the tolerance of heights over what its cells cover beyond it."""
    e0, e1, e2 = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    f0, f1, f2 = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    twice = e0 * f1 - e1 * f0
    longest = max(np.hypot(e0, e1), np.hypot(f0, f1), np.hypot(f0 - e0, f1 - e1))
    if not abs(twice) > NARROW * longest:
        return np.inf
    plane[1], plane[2] = (e2 * f1 - e1 * f2) / twice, (e0 * f2 - e2 * f0) / twice
    plane[0] = p[0, 2] - plane[1] * p[0, 0] - plane[2] * p[0, 1]
    slope = abs(plane[1]) + abs(plane[2])
    if not slope <= STEEP:
        return np.inf
    return slope * MARGIN * (4.0 + 4.0 * steepest) + 8.0 * noise * (1.0 + slope) * longest / abs(twice)


# --------------------------------------------------------------------------------------------------- order


@kernel
def order_of(cells, planes, tolerances):
    """Which facets may come before which, over all that their cells share."""
    f = planes.shape[0]
    loose = np.empty(f, np.bool_)
    for i in range(f):
        loose[i] = not tolerances[i] <= MOST_TOLERANCE
    precedes = np.ones((f, f), np.bool_)
    for a in range(cells.facets.shape[0]):
        for b in range(a):
            i, j = cells.facets[a], cells.facets[b]
            if i == j or loose[i] or loose[j]:
                continue
            first, last = max(cells.x[a, 0], cells.x[b, 0]), min(cells.x[a, 1], cells.x[b, 1])
            if first > last:
                continue
            least, most = _difference(cells.arcs, a, b, first, last, planes[i], planes[j])
            if most > tolerances[i] + tolerances[j]:
                precedes[j, i] = False
            if least < -(tolerances[i] + tolerances[j]):
                precedes[i, j] = False
    crosses = np.zeros(f, np.bool_)
    for i in range(f):
        for j in range(i):
            if not (loose[i] or loose[j] or precedes[i, j] or precedes[j, i]):
                crosses[i] = crosses[j] = True
    return loose | crosses, precedes


@kernel
def at(arc, x):
    return arc[1] + arc[2] * (x - arc[0])


@kernel
def _difference(arcs, a, b, first, last, p, q):
    """Least and largest value of height q less height p over what the cells a and b share between first and last.

    A convex polygon (reached over by a share of MARGIN): looked at where it begins, ends or two of its arcs cross.
    """
    least, most = np.inf, -np.inf
    lines = (2 * a, 2 * b, 2 * a + 1, 2 * b + 1)
    for k in range(8):
        x = first if k == 0 else last
        if k > 1:
            m, n = (0, 1, 0, 0, 1, 2)[k - 2], (1, 2, 2, 3, 3, 3)[k - 2]
            s, t = arcs[lines[m]], arcs[lines[n]]
            apart = s[2] - t[2]
            gap = at(t, first) - at(s, first)
            if m < 2 and n > 1:
                gap += 0.25 * MARGIN
            x = first + gap / apart if apart != 0.0 else first
            if not first < x < last:
                continue
        low = max(at(arcs[lines[0]], x), at(arcs[lines[1]], x)) - 0.125 * MARGIN
        high = min(at(arcs[lines[2]], x), at(arcs[lines[3]], x)) + 0.125 * MARGIN
        if low > high + 0.125 * MARGIN:
            continue
        flat = q[0] - p[0] + (q[1] - p[1]) * x
        low, high = flat + (q[2] - p[2]) * low, flat + (q[2] - p[2]) * high
        least, most = min(least, low, high), max(most, low, high)
    return least, most


# --------------------------------------------------------------------------------------------------- trees


@kernel
def _may_precede(order, facets, x, y):
    """Whether cell x may come before cell y, for neighbours in a tree."""
    i, j = facets[x], facets[y]
    return i == j or order.loose[i] or order.precedes[i, j]


@kernel
def _before(order, facets, x, y):
    """Whether cell x is placed before cell y."""
    i, j = facets[x], facets[y]
    if i == j or order.loose[i] or (order.precedes[i, j] and order.precedes[j, i]):
        return x < y
    return order.precedes[i, j]


@kernel
def _weight(cell):
    """Random weights keep the trees balanced: a parent weighs more than its children (Seidel & Aragon 1996)."""
    return (np.uint64(cell) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(20)


@kernel
def _copy(trees, node):
    new = trees.used[0]
    trees.cell[new], trees.left[new], trees.right[new] = trees.cell[node], trees.left[node], trees.right[node]
    trees.used[0] = new + 1
    return np.int32(new)


@kernel
def _hang(trees, parent, on_right, node, root):
    """Put the node below the parent, which is new; returns the root, the node itself where there is no parent."""
    if parent == NONE:
        return node
    if on_right:
        trees.right[parent] = node
    else:
        trees.left[parent] = node
    return root


@kernel
def with_cell(trees, order, facets, root, x):
    """The root of a tree that also holds cell x."""
    top, parent, on_right, node = NONE, NONE, False, root
    while node != NONE and _weight(trees.cell[node]) > _weight(x):
        new = _copy(trees, node)
        top = _hang(trees, parent, on_right, new, top)
        parent, on_right = new, _before(order, facets, trees.cell[node], x)
        node = trees.right[node] if on_right else trees.left[node]
    here = np.int32(trees.used[0])
    trees.used[0] += 1
    trees.cell[here], trees.left[here], trees.right[here] = x, NONE, NONE
    top = _hang(trees, parent, on_right, here, top)
    # what stood there is parted into what comes before x and what comes after
    before, below_before, after, after_below = here, False, here, True
    while node != NONE:
        new = _copy(trees, node)
        if _before(order, facets, trees.cell[node], x):
            _hang(trees, before, below_before, new, top)
            before, below_before, node = new, True, trees.right[node]
        else:
            _hang(trees, after, after_below, new, top)
            after, after_below, node = new, False, trees.left[node]
    _hang(trees, before, below_before, NONE, top)
    _hang(trees, after, after_below, NONE, top)
    return top


@kernel
def without_cell(trees, order, facets, root, x, waiting):
    """The root of a tree that does not hold cell x.

    Neighbours are always in an order they may have.  Where ties make the order no order, so that x is not found on its
    way or its neighbours must not follow each other, all others are put into a new tree.
    """
    top, parent, on_right, node = NONE, NONE, False, root
    last, next = NONE, NONE
    used = trees.used[0]
    while node != NONE and trees.cell[node] != x:
        new = _copy(trees, node)
        top = _hang(trees, parent, on_right, new, top)
        parent, on_right = new, _before(order, facets, trees.cell[node], x)
        if on_right:
            last, node = trees.cell[node], trees.right[node]
        else:
            next, node = trees.cell[node], trees.left[node]
    if node != NONE:
        left, right = trees.left[node], trees.right[node]
        if left != NONE:
            k = left
            while trees.right[k] != NONE:
                k = trees.right[k]
            last = trees.cell[k]
        if right != NONE:
            k = right
            while trees.left[k] != NONE:
                k = trees.left[k]
            next = trees.cell[k]
        if last == NONE or next == NONE or _may_precede(order, facets, last, next):
            while left != NONE and right != NONE:
                if _weight(trees.cell[left]) > _weight(trees.cell[right]):
                    new = _copy(trees, left)
                    top = _hang(trees, parent, on_right, new, top)
                    parent, on_right, left = new, True, trees.right[left]
                else:
                    new = _copy(trees, right)
                    top = _hang(trees, parent, on_right, new, top)
                    parent, on_right, right = new, False, trees.left[right]
            return _hang(trees, parent, on_right, left if left != NONE else right, top)
    trees.used[0] = used
    top, count, node = NONE, 0, root
    while count > 0 or node != NONE:  # in order
        if node != NONE:
            waiting[count] = node
            count += 1
            node = trees.left[node]
            continue
        count -= 1
        node = waiting[count]
        if trees.cell[node] != x:
            top = with_cell(trees, order, facets, top, trees.cell[node])
        node = trees.right[node]
    return top
