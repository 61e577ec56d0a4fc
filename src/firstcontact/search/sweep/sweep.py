"""The plane sweep for vertices against facets (Schoemer & Thiel 1995, section 6).

Facets are taken in groups of about sqrt(n).  Seen along the motion a group is an arrangement of O(n) pieces, swept by a
line once, which stops at every vertex: what lies over a region of the arrangement is a set of facets in one order, that
of their heights along the motion, and a search tree over them tells in logarithmic time which one a vertex under it
meets first.  Neighbouring regions differ by one facet, so their trees share all but one path (path copying).  In all
O(n^{3/2} log n) for facets that do not cross each other.

Under a translation pieces are facets, their sides straight lines.  Under a rotation what is seen is the height along
the axis and the squared distance from it, sides are parabolas, and a height is an angle (see `sheets`): each order of
angles is cut at the angle zero, and asked once more for what lies beyond it.

Nothing rests on rounded coordinates alone: each facet covers cells that reach beyond it by MARGIN, far more than arcs
(the lower and upper bounds of cells) can be out of order; the order of heights is that of all pairs of facets over all
that their cells share, within a tolerance; and every facet whose height leaves it open is put to the pair test.
Facets that cross another one of their group, or stand so steep or so slender that heights over them say little, are
`loose`: in trees of their own, all of which are tested.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.angle import TWO_PI
from firstcontact.kernels.heap import heap_pop, heap_push
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.swept_cell import turns
from firstcontact.search.lifted.lifted_motion import test_pair
from firstcontact.search.trees.state import BEST, CANDIDATES, DONE, FIRST, FULL, LEAF_ROOM, VISITS
from firstcontact.search.trees.tree import SIDE

# In units of the size of the facets: how far cells reach beyond their facet.
MARGIN = 2.0**-30
# Facets steeper than this (height by length), with sides steeper than this (in the plane of the sweep) or narrower than
# this are loose.
STEEP, STEEP_SIDE, NARROW = 64.0, 128.0, 4.0 * MARGIN
# And those whose heights over their cells may be off by more.
MOST_TOLERANCE = 2.0**-10
# The sweep found its arcs in an order that cannot be (never seen): the group is to be tested facet by facet.
LOST = 16

# Facets in a group, at most: so many arcs that roundings stay far below what `_crossing` allows.
LARGEST_GROUP = 1500
NONE = np.int32(-1)
# NumPy integers, because Numba compiles a function anew for every Python number written into a call.
TAKE, ADD = np.int64(0), np.int64(1)


class Trees(NamedTuple):
    """Search trees that share nodes (q,): cell, left, right; `used` (1,) nodes; older nodes never change."""

    cell: np.ndarray
    left: np.ndarray
    right: np.ndarray
    used: np.ndarray


class GroupCells(NamedTuple):
    """Of a group: sheets (c,), x (c, 2), arcs (2c, 4) lower and upper in turn: middle x, y and slope there, bend.

    A sheet is what has one height over each point of its cells: a facet, or under a rotation what lies over one cell.
    """

    sheets: np.ndarray
    x: np.ndarray
    arcs: np.ndarray


class Order(NamedTuple):
    """Of sheets: heights (f, 4), see `height_at`; loose (f,); precedes (f, f): may i come before j."""

    heights: np.ndarray
    loose: np.ndarray
    precedes: np.ndarray


# --------------------------------------------------------------------------------------------------- cells


@kernel
def cells_of(corners, noise):
    """The cells of facets with corners (f, 3, 3) in the frame of the sweep, their planes, and tolerances (f,) of

    heights; a tolerance of inf makes a facet loose.
    """
    f = corners.shape[0]
    facets, x, arcs = np.empty(2 * f, np.int32), np.empty((2 * f, 2)), np.zeros((4 * f, 4))
    planes, tolerances = np.zeros((f, 4)), np.empty(f)
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


@uncounted
def _height_of_side(p, q, x):
    """y at x of the side from p to q, at its middle where it is upright."""
    if q[0] - p[0] <= 0.0:
        return 0.5 * (p[1] + q[1])
    return p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1])


@uncounted
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


@uncounted
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
    """(loose, precedes): which sheets are loose, and which may come before which over all that their cells share."""
    f = planes.shape[0]
    low, high = np.empty(cells.sheets.shape[0]), np.empty(cells.sheets.shape[0])
    for a in range(cells.sheets.shape[0]):
        low[a], _ = _range_of(cells.arcs[2 * a], cells.x[a, 0], cells.x[a, 1])
        _, high[a] = _range_of(cells.arcs[2 * a + 1], cells.x[a, 0], cells.x[a, 1])
    loose = np.empty(f, np.bool_)
    for i in range(f):
        loose[i] = not tolerances[i] <= MOST_TOLERANCE
    precedes = np.ones((f, f), np.bool_)
    for a in range(cells.sheets.shape[0]):
        for b in range(a):
            i, j = cells.sheets[a], cells.sheets[b]
            if i == j or loose[i] or loose[j]:
                continue
            first, last = max(cells.x[a, 0], cells.x[b, 0]), min(cells.x[a, 1], cells.x[b, 1])
            if first > last or low[a] > high[b] + MARGIN or low[b] > high[a] + MARGIN:
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


@uncounted
def at(arc, x):
    return arc[1] + (x - arc[0]) * (arc[2] + (x - arc[0]) * arc[3])


@uncounted
def _range_of(arc, first, last):
    """Least and largest value of the arc between first and last."""
    y, z = at(arc, first), at(arc, last)
    least, most = min(y, z), max(y, z)
    if arc[3] != 0.0:
        x = arc[0] - 0.5 * arc[2] / arc[3]
        if first < x < last:
            least, most = min(least, at(arc, x)), max(most, at(arc, x))
    return least, most


@uncounted
def height_at(height, x, y):
    """p0 + p1 x + p2 y of a row (p0, p1, p2, 0).  Of (d0, d1, base, way) an angle, see `sheets`: base + way atan(w / d)

    with d = d0 + d1 x and w^2 = y - d^2.
    """
    if height[3] == 0.0:
        return height[0] + height[1] * x + height[2] * y
    d = height[0] + height[1] * x
    return height[2] + height[3] * np.arctan2(np.sqrt(max(y - d * d, 0.0)), d)


@uncounted
def _difference(arcs, a, b, first, last, p, q):
    """Least and largest value of height q less height p over what the cells a and b share between first and last.

    Looked at where that (reached over by a share of MARGIN) begins, ends or two of its arcs cross.  Heights that are
    angles count as lengths along circles.
    """
    least, most = np.inf, -np.inf
    lines = (2 * a, 2 * b, 2 * a + 1, 2 * b + 1)
    for k in range(14):
        x = first if k == 0 else last
        if k > 1:
            m, n = (0, 1, 0, 0, 1, 2)[k // 2 - 1], (1, 2, 2, 3, 3, 3)[k // 2 - 1]
            s, t = arcs[lines[m]], arcs[lines[n]]
            bend = t[3] - s[3]
            if bend == 0.0 and k % 2 == 1:
                continue
            gap = at(t, first) - at(s, first)
            if m < 2 and n > 1:
                gap += 0.25 * MARGIN
            x = first + _root(gap, _slope(t, first) - _slope(s, first), bend, k % 2)
            if not first < x < last:
                continue
        low = max(at(arcs[lines[0]], x), at(arcs[lines[1]], x)) - 0.125 * MARGIN
        high = min(at(arcs[lines[2]], x), at(arcs[lines[3]], x)) + 0.125 * MARGIN
        if low > high + 0.125 * MARGIN:
            continue
        for y in (low, high):
            apart = height_at(q, x, y) - height_at(p, x, y)
            if p[3] != 0.0:
                apart *= np.sqrt(max(y, 0.0))
            least, most = min(least, apart), max(most, apart)
    return least, most


@uncounted
def _slope(arc, x):
    return arc[2] + 2.0 * arc[3] * (x - arc[0])


@uncounted
def _root(c, b, a, which):
    """A root of a x^2 + b x + c, the one (0) or the other (1); inf where there is none."""
    if a == 0.0:
        return -c / b if b != 0.0 else np.inf
    d = b * b - 4.0 * a * c
    if d < 0.0:
        return np.inf
    r = -(b + np.sqrt(d)) if b > 0.0 else -(b - np.sqrt(d))
    if which == 0:
        return 0.5 * r / a
    return 2.0 * c / r if r != 0.0 else np.inf


# --------------------------------------------------------------------------------------------------- trees


@uncounted
def _may_precede(order, facets, x, y):
    """Whether cell x may come before cell y, for neighbours in a tree."""
    i, j = facets[x], facets[y]
    return i == j or order.loose[i] or order.precedes[i, j]


@uncounted
def _before(order, facets, x, y):
    """Whether cell x is placed before cell y."""
    i, j = facets[x], facets[y]
    if i == j or order.loose[i] or (order.precedes[i, j] and order.precedes[j, i]):
        return x < y
    return order.precedes[i, j]


@uncounted
def _weight(cell):
    """Random weights keep the trees balanced: a parent weighs more than its children (Seidel & Aragon 1996)."""
    return (np.uint64(cell) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(20)


@uncounted
def _copy(trees, node):
    new = trees.used[0]
    trees.cell[new], trees.left[new], trees.right[new] = trees.cell[node], trees.left[node], trees.right[node]
    trees.used[0] = new + 1
    return np.int32(new)


@uncounted
def _hang(trees, parent, on_right, node, root):
    """Put the node below the parent, which is new; returns the root, the node itself where there is no parent."""
    if parent == NONE:
        return node
    if on_right:
        trees.right[parent] = node
    else:
        trees.left[parent] = node
    return root


@uncounted
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


@uncounted
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
            top = with_cell(trees, order, facets, top, np.int64(trees.cell[node]))
        node = trees.right[node]
    return top


@kernel
def _with_room(trees, roots, reserve):
    """The trees with room for `reserve` more nodes; if there is none, a copy of the nodes that the roots reach."""
    if trees.used[0] + reserve <= trees.cell.shape[0]:
        return trees
    place = np.full(trees.used[0], -1, np.int32)
    waiting = np.empty(trees.used[0], np.int32)
    live = 0
    for k in range(2):
        for i in range(roots.shape[1]):
            top = 0
            if roots[k, i] != NONE and place[roots[k, i]] < 0:
                waiting[0], top = roots[k, i], 1
                place[roots[k, i]] = live
                live += 1
            while top > 0:
                top -= 1
                node = waiting[top]
                for child in (trees.left[node], trees.right[node]):
                    if child != NONE and place[child] < 0:
                        place[child] = live
                        live += 1
                        waiting[top] = child
                        top += 1
    size = max(trees.cell.shape[0], 4 * (live + reserve))
    new = Trees(np.empty(size, np.int32), np.empty(size, np.int32), np.empty(size, np.int32), np.array([live]))
    for node in range(place.shape[0]):
        if place[node] >= 0:
            left, right = trees.left[node], trees.right[node]
            new.cell[place[node]] = trees.cell[node]
            new.left[place[node]] = NONE if left == NONE else place[left]
            new.right[place[node]] = NONE if right == NONE else place[right]
    for k in range(2):
        for i in range(roots.shape[1]):
            if roots[k, i] != NONE:
                roots[k, i] = place[roots[k, i]]
    return new


# --------------------------------------------------------------------------------------------------- sweep


class SweepLine(NamedTuple):
    """The sweep line: arcs from below (m,), their places (2c,; -1: not on it), trees (2, m + 1) of the cells over

    the regions below each arc and above the last one, ordered and loose; used (1,): number of arcs.
    """

    arcs: np.ndarray
    place: np.ndarray
    roots: np.ndarray
    used: np.ndarray


@uncounted
def _place_of(line, cells, x, y):
    """How many arcs are below y at x, as far as their order is to be trusted."""
    lo, hi = 0, line.used[0]
    while lo < hi:
        middle = (lo + hi) // 2
        if at(cells.arcs[line.arcs[middle]], x) <= y:
            lo = middle + 1
        else:
            hi = middle
    return lo


@kernel
def _toggle(trees, line, order, cells, source, target, cell, adds, waiting):
    """Write the trees of region `source`, with the cell or without it, as those of region `target`.

    Returns the trees: they may have moved.
    """
    roots = line.roots
    trees = _with_room(trees, roots, 32 * (cells.sheets.shape[0] + 32))
    k = 1 if order.loose[cells.sheets[cell]] else 0
    roots[1 - k, target] = roots[1 - k, source]
    if adds == ADD:
        roots[k, target] = with_cell(trees, order, cells.sheets, roots[k, source], cell)
    else:
        roots[k, target] = without_cell(trees, order, cells.sheets, roots[k, source], cell, waiting)
    return trees


@kernel
def _begin_cell(trees, line, order, cells, cell, x, waiting):
    """Put both arcs of a cell on the line.  Returns the trees and their places."""
    arcs, roots, m = line.arcs, line.roots, line.used[0]
    i = _place_of(line, cells, x, at(cells.arcs[2 * cell], x))
    j = max(i, _place_of(line, cells, x, at(cells.arcs[2 * cell + 1], x)))
    for t in range(m, j - 1, -1):
        roots[0, t + 2], roots[1, t + 2] = roots[0, t], roots[1, t]
    for t in range(m - 1, j - 1, -1):
        arcs[t + 2] = arcs[t]
    for t in range(j, i - 1, -1):
        trees = _toggle(trees, line, order, cells, t, t + 1, cell, ADD, waiting)
    for t in range(j - 1, i - 1, -1):
        arcs[t + 1] = arcs[t]
    arcs[i], arcs[j + 1] = 2 * cell, 2 * cell + 1
    line.used[0] = m + 2
    _number(line, i)
    return trees, i, j + 1


@kernel
def _end_cell(trees, line, order, cells, cell, waiting):
    """Take both arcs of a cell off the line.  Returns the trees and the places where they were."""
    arcs, roots, m = line.arcs, line.roots, line.used[0]
    i, j = np.int64(line.place[2 * cell]), np.int64(line.place[2 * cell + 1])
    for t in range(i + 1, j):
        arcs[t - 1] = arcs[t]
        if t > i + 1:
            trees = _toggle(trees, line, order, cells, t, t - 1, cell, TAKE, waiting)
    # the region below the lower arc stays; so does the one above the upper arc
    for t in range(j + 1, m):
        arcs[t - 2] = arcs[t]
    for t in range(j + 1, m + 1):
        roots[0, t - 2], roots[1, t - 2] = roots[0, t], roots[1, t]
    roots[0, m - 1] = roots[1, m - 1] = roots[0, m] = roots[1, m] = NONE
    line.used[0] = m - 2
    line.place[2 * cell] = line.place[2 * cell + 1] = -1
    _number(line, i)
    return trees, i, j


@uncounted
def _number(line, first):
    for t in range(first, line.used[0]):
        line.place[line.arcs[t]] = t


@kernel
def _cross(trees, line, order, cells, i, waiting):
    """Exchange the arcs at places i and i + 1; the region between them is a new one.  Returns the trees."""
    below, above = line.arcs[i], line.arcs[i + 1]
    if above % 2 == 0:
        trees = _toggle(trees, line, order, cells, i, i + 1, np.int64(above // 2), ADD, waiting)
    elif below % 2 == 1:
        trees = _toggle(trees, line, order, cells, i + 2, i + 1, np.int64(below // 2), ADD, waiting)
    else:
        trees = _toggle(trees, line, order, cells, i, i + 1, np.int64(above // 2), TAKE, waiting)
    line.arcs[i], line.arcs[i + 1] = above, below
    line.place[above], line.place[below] = i, i + 1
    return trees


@uncounted
def _crossing(line, cells, i, x):
    """Where the arcs at places i and i + 1 cross from x on; inf if they do not before one of them ends.

    Arcs that roundings have put in the wrong order, by more than an arc can be off, cross at once: so neighbours are
    in order but for 1 / 32 of MARGIN divided by the number of arcs, and all arcs but for that share of MARGIN.
    Arcs that part at x cross beyond it, be it by its last digit: where two arcs touch, both their crossings may round
    to x, and each of them would bring on the other one for ever.
    """
    if i < 0 or i + 1 >= line.used[0]:
        return np.inf
    s, t = line.arcs[i], line.arcs[i + 1]
    below, above = cells.arcs[s], cells.arcs[t]
    gap = at(above, x) - at(below, x)
    if gap < -MARGIN / (128.0 * (line.place.shape[0] + 8.0)):
        return x
    parting = _slope(above, x) - _slope(below, x)
    when = x + _fall(max(0.0, gap), parting, above[3] - below[3])
    if parting > 0.0:
        when = max(when, np.nextafter(x, np.inf))
    return when if when <= min(cells.x[s // 2, 1], cells.x[t // 2, 1]) else np.inf


@uncounted
def _fall(c, b, a):
    """The first x >= 0 from which on a x^2 + b x + c with c >= 0 falls below zero; inf where there is none."""
    if b > 0.0:
        return (b + np.sqrt(b * b - 4.0 * a * c)) / (-2.0 * a) if a < 0.0 else np.inf
    d = b * b - 4.0 * a * c
    if d < 0.0 or (b == 0.0 and a >= 0.0):
        return np.inf
    r = np.sqrt(d) - b
    return 2.0 * c / r if r > 0.0 else 0.0


@kernel
def sweep_group(cells, starts, ends, order, tolerance, points, pace, askers, parts, swapped, motion, xyz_a, xyz_b,
                err_a, err_b, floats, integers, times, candidates):  # fmt: skip
    """Sweep one group past the points (k, 4): x, y, height and the asker's number, in the order of x.

    starts, ends (c,): the cells in the order in which they begin and end; no point is beyond the first and last x.
    tolerance: of the order of heights in the group.  pace: height per unit of time.  askers (n, 2), parts (f, 2): those
    of the vertices and sheets; swapped: the vertices are of b.  Returns DONE, FULL or LOST.
    """
    n = cells.sheets.shape[0]
    line = SweepLine(
        np.empty(2 * n + 2, np.int32), np.full(2 * n, -1, np.int32), np.full((2, 2 * n + 3), -1, np.int32),
        np.zeros(1, np.int64),
    )  # fmt: skip
    trees = Trees(np.empty(0, np.int32), np.empty(0, np.int32), np.empty(0, np.int32), np.zeros(1, np.int64))
    waiting = np.empty(2 * n + 64, np.int32)
    keys, pairs, size = np.empty(1024), np.empty((1024, 2), np.int32), 0
    a = b = crossings = 0
    p, stop = 0, points.shape[0]
    while b < n:
        start = cells.x[starts[a], 0] if a < n else np.inf
        end, cross = cells.x[ends[b], 1], keys[0] if size > 0 else np.inf
        point = points[p, 0] if p < stop else np.inf
        x = min(start, end, cross, point)
        if keys.shape[0] < size + 8:
            more, more_pairs = np.empty(2 * keys.shape[0]), np.empty((2 * keys.shape[0], 2), np.int32)
            for k in range(size):
                more[k], more_pairs[k, 0], more_pairs[k, 1] = keys[k], pairs[k, 0], pairs[k, 1]
            keys, pairs = more, more_pairs
        i = j = -2
        if start == x:
            trees, i, j = _begin_cell(trees, line, order, cells, starts[a], x, waiting)
            a += 1
        elif cross == x:
            s, t = pairs[0, 0], pairs[0, 1]
            size = heap_pop(keys, pairs, size)
            if line.place[s] < 0 or line.place[t] != line.place[s] + 1:
                continue  # no longer neighbours
            crossings += 1
            if s // 2 == t // 2 or crossings > 8 * n * n:  # two arcs cross twice at most: 4 n (2 n - 1) / 2 times
                return LOST
            i = np.int64(line.place[s])
            trees = _cross(trees, line, order, cells, i, waiting)
        elif point == x:
            i = _place_of(line, cells, x, points[p, 1])
            if not _ask(trees, line.roots[:, i], order, cells, tolerance, points[p], pace, askers, parts, swapped,
                        motion, xyz_a, xyz_b, err_a, err_b, waiting, floats, integers, times, candidates):  # fmt: skip
                return FULL
            p += 1
            continue
        else:
            cell = ends[b]
            if line.place[2 * cell] >= line.place[2 * cell + 1]:
                return LOST
            trees, i, j = _end_cell(trees, line, order, cells, cell, waiting)
            i, j, b = i - 1, j - 2, b + 1
        integers[VISITS] += 1
        for k in (i - 1, i, i + 1, j - 1, j):
            when = _crossing(line, cells, k, x)
            if when != np.inf:
                size = heap_push(keys, pairs, size, when, line.arcs[k], line.arcs[k + 1])
    return DONE


@uncounted
def _ask(trees, roots, order, cells, tolerance, point, pace, askers, parts, swapped, motion, xyz_a, xyz_b, err_a, err_b,
         waiting, floats, integers, times, candidates):  # fmt: skip
    """Put the point to the facets over its region that it may meet first; False when there is no room.

    In a tree: a facet certainly passed before the beginning has only such ones before it, one certainly met after the
    best time only such ones behind it.  Angles are asked for once a turn.
    """
    asker = askers[int(point[3])]
    turn = TWO_PI if turns(motion) else 0.0
    for ask in range(4):
        ordered = ask < 3
        ahead = (0.0, turn, -turn, 0.0)[ask] - point[2]
        if ask in (1, 2) and not (
            turn > 0.0
            and ahead + turn + tolerance >= floats[FIRST] - tolerance
            and ahead - tolerance <= floats[BEST] + tolerance
        ):
            continue
        top = 0
        node = roots[0 if ordered else 1]
        while True:
            # to the left first, in the order of heights
            while node != NONE:
                integers[VISITS] += 1
                height = 0.0
                if ordered:
                    height = height_at(order.heights[cells.sheets[trees.cell[node]]], point[0], point[1]) + ahead
                if ordered and height < pace * floats[FIRST] - tolerance:
                    node = trees.right[node]
                elif ordered and height > pace * floats[BEST] * (1.0 + 1e-12) + tolerance:
                    node = trees.left[node]
                else:
                    waiting[top] = node
                    top += 1
                    node = trees.left[node]
            if top == 0:
                break
            if integers[CANDIDATES] + LEAF_ROOM > times.shape[0]:
                return False
            top -= 1
            node = waiting[top]
            facet = parts[cells.sheets[trees.cell[node]]]
            x, y = (facet, asker) if swapped else (asker, facet)
            test_pair(
                motion, x[0], x[1], xyz_a[x[0]], y[0], y[1], xyz_b[y[0]], 1 << SIDE, err_a, err_b,
                floats, integers, times, candidates,
            )  # fmt: skip
            node = trees.right[node]
    return True
