"""Which cells of the parameters (u, v) hold arcs of Delta = 0 that belong to both pieces, and how they join; certified.

A cell is dropped where Delta has one sign or where a bracket pair proves that rulings meet beyond their ends.  Where a
partial derivative of Delta has one sign the curve in the cell is a graph: no loop, no branching, and its crossings with
the border, in order, tell its arcs.  Crossings are found once for every line between cells, so neighbours agree.

At corners of cells a value within its error counts as positive, which moves the curve by less than rounding and keeps
all cells in agreement.  What is not decided, on lines between cells and where cells become too small, is recorded.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curves.nets import (
    BOX_HI,
    BOX_LO,
    DEPTH,
    FACTS,
    FIRST,
    HI,
    LO,
    ROUND,
    SECOND,
    degree,
    delta_at,
    delta_error,
    delta_net,
    delta_size,
    extent,
    halves,
    part_of,
    planes_net,
    side_net,
    slopes,
)
from firstcontact.kernels.curves.points import (
    ARC_U,
    ARC_V,
    END,
    HIGH,
    KIND,
    LOW,
    OVER,
    PART_U,
    PART_V,
    RISING,
    S_BOUND,
    START,
    T_BOUND,
    VIEW,
    WEAK,
    X,
    Y,
)
from firstcontact.kernels.jit import uncounted

# Typed, since Numba compiles a function anew for every Python integer written into a call.
NO, YES, INNER = np.int64(0), np.int64(1), np.int64(0)
# What a cell is: nothing of the curve, a graph over u, one over v, to be cut along u or v, or Delta within its error.
NOTHING, OVER_U, OVER_V, CUT_U, CUT_V, FLAT = 0, 1, 2, 3, 4, 5
# Columns of `cells`: nodes, signs at corners (lower left and right, upper left and right), then start and count of
# the crossings on the left, right, lower and upper side.
NODE_U, NODE_V, CORNERS, SIDES, CELL_COLUMNS = 0, 1, 2, 6, 14
# Numbers in `counts`: places, arcs, open boxes (parts, then ranges of x and y), cells looked at; whether room ran out.
PLACES, ARCS, OPENED, SEEN, SHORT, COUNTS = 0, 1, 2, 3, 4, 5
OPEN_COLUMNS = 6
# Layers of the scratch array `w`: a net; rows of polynomials on a line; their spans and signs at the ends; planes, four
# rows for each side; the ranges of s and t with the direction of view.
NET, LINE, SPANS, PLANES, RANGES, LAYERS = 0, 1, 2, 3, 4, 5
LAYER_ROWS = 64
# Row s or t of the layer RANGES: slopes of the bracket that may vanish, along u (low, high), along v (low, high), their
# error, and its number, 0 or 1, or -1 for none.
ERROR, WHICH = 4, 5
SIGHT = 2
# Halvings of one parameter after which a cell is left open: 2^-24 is near the square root of the rounding of Delta,
# below which a double root is not told from none or two.
DEEPEST = 24
# Sine of the angle between rulings, about, below which they may be parallel.
PARALLEL = 0.05
# Halvings of a line between cells.
LINE_DEPTH = 45
# Crossings of a border this near its end are that end, in parts.
SAME_END = 1e-9


# -- one cell -----------------------------------------------------------------------------------------------


@uncounted
def _along(side, k, out):
    """Twice a middle direction of the rulings of a node."""
    n = degree(side)
    for c in range(3):
        out[c] = side[k, SECOND + c, 0] / side[k, 7, 0] - side[k, c, 0] / side[k, 3, 0]
        out[c] += side[k, SECOND + c, n] / side[k, 7, n] - side[k, c, n] / side[k, 3, n]


@uncounted
def _midst(side, k, out):
    """Add up four points of the rulings of a node."""
    n = degree(side)
    for c in range(3):
        out[c] = side[k, c, 0] / side[k, 3, 0] + side[k, SECOND + c, 0] / side[k, 7, 0]
        out[c] += side[k, c, n] / side[k, 3, n] + side[k, SECOND + c, n] / side[k, 7, n]


@uncounted
def _cross(a, b, d):
    """Set d to the direction across two others; the size of their product."""
    d[0], d[1], d[2] = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    size = abs(d[0]) + abs(d[1]) + abs(d[2])
    if size > 0.0:
        for c in range(3):
            d[c] /= size
    else:
        d[2] = 1.0
    return size


@uncounted
def _look_along(p, i, q, j, w):
    """Set the direction across the rulings of the cell: along it they are seen to cross."""
    _along(p, i, w[PLANES, 0])
    _along(q, j, w[PLANES, 1])
    _cross(w[PLANES, 0], w[PLANES, 1], w[RANGES, SIGHT])


@uncounted
def _side_by_side(p, i, q, j, w):
    """1: rulings as good as parallel are apart, seen across their plane; 2: that is not proved; 0: they may cross."""
    a, b, d = w[PLANES, 0], w[PLANES, 1], w[RANGES, SIGHT]
    _along(p, i, a)
    _along(q, j, b)
    lengths = (abs(a[0]) + abs(a[1]) + abs(a[2])) * (abs(b[0]) + abs(b[1]) + abs(b[2]))
    if _cross(a, b, d) > PARALLEL * lengths:
        return 0
    _midst(p, i, b)
    _midst(q, j, w[PLANES, 2])
    for c in range(3):
        b[c] -= w[PLANES, 2, c]
    _cross(a, b, d)
    return 1 if _brackets(p, i, q, j, NO, w) == 1 or _brackets(q, j, p, i, YES, w) == 1 else 2


@uncounted
def _sign(lo, hi, error):
    return 1 if lo > error else -1 if hi < -error else 0


@uncounted
def _brackets(side, k, other, other_k, which, w):
    """1: both brackets of the side's ends have one sign, no contact; 2: neither has a sign; else 0, its row is set."""
    planes, row, net = w[PLANES, 4 * which : 4 * which + 4], w[RANGES, which], w[NET]
    sizes = planes_net(other, other_k, w[RANGES, SIGHT], planes)
    n, m = degree(side), 2 * degree(other)
    signs = 0
    product = 1
    row[WHICH] = -1.0
    for end in range(2):
        error = side_net(side, k, FIRST if end == 0 else SECOND, other, other_k, planes, sizes, net)
        lo, hi = extent(net, n, m)
        sign = _sign(lo, hi, error)
        product *= sign
        if sign != 0:
            signs += 1
            continue
        low_a, high_a, low_b, high_b, _, _ = slopes(net, n, m)
        if which == 0:
            row[0], row[1], row[2], row[3] = low_a, high_a, low_b, high_b
        else:
            row[0], row[1], row[2], row[3] = low_b, high_b, low_a, high_a
        row[ERROR], row[WHICH] = 2.0 * max(n, m) * error, end
    if product > 0:
        return 1
    return 2 if signs == 0 else 0


@uncounted
def _times(a, b, c, d):
    """The range of products of [a, b] and [c, d]."""
    return min(min(a * c, a * d), min(b * c, b * d)), max(max(a * c, a * d), max(b * c, b * d))


@uncounted
def apart(p, i, q, j):
    """Whether the boxes of two nodes share no point."""
    for c in range(3):
        if p[i, FACTS, BOX_HI + c] < q[j, FACTS, BOX_LO + c] or q[j, FACTS, BOX_HI + c] < p[i, FACTS, BOX_LO + c]:
            return True
    return False


@uncounted
def _examine(p, i, q, j, crossings, w):
    """What a cell is; for a graph also the sign of the slope across, with RANGES telling which bounds may cut it.

    Such a bound is monotone along the curve: the Jacobian of Delta and its bracket has one sign.
    """
    if apart(p, i, q, j):
        return NOTHING, 0
    n, m = 2 * degree(p), 2 * degree(q)
    error = delta_error(p, i, q, j)
    delta_net(p, i, q, j, w[NET])
    lo, hi = extent(w[NET], n, m)
    if lo > error or hi < -error:
        return NOTHING, 0
    parallel = _side_by_side(p, i, q, j, w)
    if parallel == 1:
        return NOTHING, 0
    if parallel == 2:
        delta_net(p, i, q, j, w[NET])
    if max(-lo, hi) <= error:
        return FLAT, 0
    low_u, high_u, low_v, high_v, along_u, along_v = slopes(w[NET], n, m)
    error *= 2.0 * max(n, m)
    sign_u, sign_v = _sign(low_u, high_u, error), _sign(low_v, high_v, error)
    graph = sign_u != 0 or sign_v != 0
    if graph and crossings == 0:
        return NOTHING, 0
    cut = CUT_U if along_u > along_v else CUT_V
    _look_along(p, i, q, j, w)
    for which in range(2):
        state = _brackets(p, i, q, j, NO, w) if which == 0 else _brackets(q, j, p, i, YES, w)
        if state == 1:
            return NOTHING, 0
        if state == 2:
            graph = False
        row = w[RANGES, which]
        if graph and row[WHICH] >= 0.0:
            a, b = _times(low_u - error, high_u + error, row[2] - row[ERROR], row[3] + row[ERROR])
            c, d = _times(low_v - error, high_v + error, row[0] - row[ERROR], row[1] + row[ERROR])
            size = max(max(-a, b), max(-c, d)) * 8.0 * ROUND
            graph = a - d > size or b - c < -size
    if not graph:
        return cut, 0
    if sign_v != 0 and (sign_u == 0 or min(abs(low_v), abs(high_v)) >= min(abs(low_u), abs(high_u))):
        return OVER_U, sign_v
    return OVER_V, sign_u


# -- lines between cells ------------------------------------------------------------------------------------


@uncounted
def _value(row, count, x, scratch):
    """Of the polynomial with these Bernstein coefficients."""
    for k in range(count):
        scratch[k] = row[k]
    for step in range(1, count):
        for k in range(count - step):
            scratch[k] = (1.0 - x) * scratch[k] + x * scratch[k + 1]
    return scratch[0]


@uncounted
def _flat(row, count, error):
    """Whether no coefficient is told from zero."""
    for k in range(count):
        if abs(row[k]) > error:
            return False
    return True


@uncounted
def _changes(row, count, error, before, after):
    """How often the signs of the coefficients change at most; the first and the last have the given signs."""
    changes, last, unsure = 0, before, 0
    for k in range(1, count):
        value = row[k]
        sign = after if k == count - 1 else 1 if value > error else -1 if value < -error else 0
        if sign == 0:
            unsure += 1
            continue
        if sign != last:
            changes += 1 + 2 * (unsure // 2)
        else:
            changes += 2 * ((unsure + 1) // 2)
        last, unsure = sign, 0
    return changes


@uncounted
def _bracket(row, count, error, before, scratch):
    """(lo, hi) about the one sign change of a polynomial whose value at an end is not told from zero.

    Its values there may have either sign by rounding, so both ends are moved to where signs are clear.
    """
    lo, hi = 0.0, 1.0
    clear_lo, clear_hi = abs(row[0]) > error, abs(row[count - 1]) > error
    for _ in range(3):
        start, length = lo, hi - lo
        for k in range(1, 8):
            x = start + 0.125 * k * length
            value = before * _value(row, count, x, scratch)
            if value > error:
                lo, clear_lo = x, True
            elif value < -error and x < hi:
                hi, clear_hi = x, True
        if clear_lo and clear_hi:
            break
    return lo, hi


@uncounted
def _root(row, count, error, before, after, scratch):
    """The place in [0, 1] where a polynomial with one sign change passes through zero (Illinois)."""
    lo, hi = 0.0, 1.0
    at_lo, at_hi = row[0], row[count - 1]
    if abs(at_lo) <= error or abs(at_hi) <= error:
        lo, hi = _bracket(row, count, error, before, scratch)
        at_lo, at_hi = _value(row, count, lo, scratch), _value(row, count, hi, scratch)
    at_lo, at_hi = before * max(abs(at_lo), 1e-300), after * max(abs(at_hi), 1e-300)
    side = 0
    for k in range(90):
        x = (lo * at_hi - hi * at_lo) / (at_hi - at_lo)
        if k > 12 or not lo < x < hi:
            x = 0.5 * (lo + hi)
        if not lo < x < hi:
            break
        value = _value(row, count, x, scratch)
        if value == 0.0:
            return x
        if (value > 0.0) == (before > 0):
            if abs(x - lo) < 1e-17:
                return x
            lo, at_lo = x, value
            if side == -1:
                at_hi *= 0.5
            side = -1
        else:
            if abs(hi - x) < 1e-17:
                return x
            hi, at_hi = x, value
            if side == 1:
                at_lo *= 0.5
            side = 1
        if hi - lo < 1e-16:
            break
    return 0.5 * (lo + hi)


@uncounted
def _next_row(rows, slot, counts):
    """The number of the next free row, which is taken; -1 where there is none, which is noted."""
    k = counts[slot]
    if k >= rows.shape[0]:
        counts[SHORT] = 1
        return -1
    counts[slot] = k + 1
    return k


@uncounted
def _add_place(part_at, at, part, x, along_v, kind, places, counts):
    k = _next_row(places, PLACES, counts)
    if k < 0:
        return
    row = places[k]
    row[X], row[Y] = (at, x) if along_v else (x, at)
    row[PART_U], row[PART_V] = (part_at, part) if along_v else (part, part_at)
    row[KIND] = kind


@uncounted
def _open(part_p, x0, x1, part_q, y0, y1, opened, counts):
    """Record a box that could not be decided."""
    k = _next_row(opened, OPENED, counts)
    if k < 0:
        return
    row = opened[k]
    row[0], row[1], row[2], row[3], row[4], row[5] = part_p, part_q, x0, x1, y0, y1


@uncounted
def _open_on_line(part_at, at, part, start, end, along_v, opened, counts):
    if along_v:
        _open(part_at, at, at, part, start, end, opened, counts)
    else:
        _open(part, start, end, part_at, at, at, opened, counts)


@uncounted
def _crossings(fixed, i, a, running, j, along_v, before, after, kind, w, places, opened, counts):
    """Find the crossings of the curve with one side of a cell, ascending; how many, they are the last places.

    The line runs along node j of one side, at coefficient a of the lines of node i of the other; along_v: the running
    side is the second one.  before, after: the signs of Delta at its ends.
    """
    rows, spans = w[LINE], w[SPANS]
    count = 2 * degree(running) + 1
    for b in range(count):
        rows[1, b] = delta_at(fixed, i, a, running, j, b)
    lo, length = running[j, FACTS, LO], running[j, FACTS, HI] - running[j, FACTS, LO]
    at = fixed[i, FACTS, LO if a == 0 else HI]
    part_at, part = part_of(fixed, i), part_of(running, j)
    # halvings of the line add roundings
    error = delta_error(fixed, i, running, j) + delta_size(fixed, i, running, j) * count * LINE_DEPTH * ROUND
    spans[1, 0], spans[1, 1], spans[1, 2], spans[1, 3] = 0.0, 1.0, before, after
    top, found = YES, NO
    # Each waiting row is a part of the line, the first one on top; row 0 is scratch.
    while top > 0:
        row, start, end, first, last = rows[top], spans[top, 0], spans[top, 1], spans[top, 2], spans[top, 3]
        changes = _changes(row, count, error, first, last)
        deep = end - start < 2.0**-LINE_DEPTH or top + 2 >= rows.shape[0] or _flat(row, count, error)
        if changes == 0 or deep or (changes == 1 and first != last):
            top -= 1
            if changes > 1:
                _open_on_line(part_at, at, part, lo + start * length, lo + end * length, along_v, opened, counts)
            if first != last:
                x = lo + (start + (end - start) * _root(row, count, error, first, last, rows[0])) * length
                _add_place(part_at, at, part, x, along_v, WEAK if changes > 1 else kind, places, counts)
                found += 1
            elif changes > 1:
                # the curve may go to the other side and come back: what is on this side ends here
                _add_place(part_at, at, part, lo + start * length, along_v, WEAK, places, counts)
                _add_place(part_at, at, part, lo + end * length, along_v, WEAK, places, counts)
                found += 2
            continue
        # the half behind stays in this row, the one before goes on top
        for k in range(count):
            rows[0, k] = row[k]
        rows[top + 1, 0] = row[0]
        for step in range(1, count):
            for k in range(count - step):
                rows[0, k] = 0.5 * (rows[0, k] + rows[0, k + 1])
            rows[top + 1, step] = rows[0, 0]
        for k in range(count):
            row[k] = rows[0, k]
        middle, value = 0.5 * (start + end), rows[0, 0]
        # what is not told from zero keeps its sign: else rounding would add two crossings
        sign = 1.0 if value > error else -1.0 if value < -error else first
        spans[top, 0], spans[top, 2] = middle, sign
        top += 1
        spans[top, 0], spans[top, 1], spans[top, 2], spans[top, 3] = start, middle, first, sign
    if kind > 0 and found > 0 and counts[SHORT] == 0:
        for b in range(count):
            rows[1, b] = delta_at(fixed, i, a, running, j, b)
        for end in range(2):
            k = counts[PLACES] - (found if end == 0 else 1)
            _doubt(part_at, at, part, end, along_v, rows, count, error, places[k], opened, counts)
    return found


@uncounted
def _doubt(part_at, at, part, end, along_v, rows, count, error, crossing, opened, counts):
    """Leave a crossing of a border open whose side of the line's end is only the sign that this was given.

    Nearer ones are the end itself, as far as doubles tell: the curve passes through it.
    """
    x = crossing[Y if along_v else X]
    if abs(rows[1, (count - 1) * end]) > error or abs(x - end) < SAME_END:
        return
    if abs(_value(rows[1], count, 0.5 * (x + end), rows[0])) <= error:
        crossing[KIND] = WEAK
        _open_on_line(part_at, at, part, min(x, end), max(x, end), along_v, opened, counts)


# -- cells --------------------------------------------------------------------------------------------------


@uncounted
def _parted(start, count, column, middle, before, value, error, places):
    """How many of these crossings come before `middle`, and the sign of Delta there, in agreement with each other.

    A value within its error takes the sign that the crossings tell.
    """
    here = np.int64(0)
    while here < count and places[start + here, column] < middle:
        here += 1
    told = before if here % 2 == 0 else -before
    sign = 1 if value > error else -1 if value < -error else told
    if sign != told and count > 0:
        # a crossing that is not told from the middle itself
        back = middle - places[start + here - 1, column] if here > 0 else np.inf
        ahead = places[start + here, column] - middle if here < count else np.inf
        here += 1 if ahead < back else -1
        told = sign
    return here, told


@uncounted
def _cut(p, q, top, along_u, w, cells, places, opened, counts):
    """Replace the cell on top of the stack by its two halves."""
    cell, other = cells[top], cells[top + 1]
    i, j = cell[NODE_U], cell[NODE_V]
    child = halves(p, i) if along_u else halves(q, j)
    if child == 0:
        counts[SHORT] = 1
        return
    for k in range(CELL_COLUMNS):
        other[k] = cell[k]
    n, m = 2 * degree(p), 2 * degree(q)
    error = delta_error(p, i, q, j)
    if along_u:
        middle, column = p[child, FACTS, HI], X
        low, high = delta_at(p, child, n, q, j, NO), delta_at(p, child, n, q, j, m)
        near, far, own = SIDES + 4, SIDES + 6, NODE_U
        before_far = cell[CORNERS + 2]
    else:
        middle, column = q[child, FACTS, HI], Y
        low, high = delta_at(p, i, NO, q, child, m), delta_at(p, i, n, q, child, m)
        near, far, own = SIDES, SIDES + 2, NODE_V
        before_far = cell[CORNERS + 1]
    near_count, low_sign = _parted(cell[near], cell[near + 1], column, middle, cell[CORNERS], low, error, places)
    far_count, high_sign = _parted(cell[far], cell[far + 1], column, middle, before_far, high, error, places)
    start = counts[PLACES]
    fixed, last, running, node = (p, n, q, j) if along_u else (q, m, p, i)
    found = _crossings(
        fixed, child, last, running, node, along_u, low_sign, high_sign, INNER, w, places, opened, counts
    )  # fmt: skip
    cell[own], other[own] = child, child + 1
    for side, count in ((near, near_count), (far, far_count)):
        other[side], other[side + 1] = cell[side] + count, cell[side + 1] - count
        cell[side + 1] = count
    if along_u:
        cell[CORNERS + 1], cell[CORNERS + 3] = low_sign, high_sign
        other[CORNERS], other[CORNERS + 2] = low_sign, high_sign
        cell[SIDES + 2], cell[SIDES + 3], other[SIDES], other[SIDES + 1] = start, found, start, found
    else:
        cell[CORNERS + 2], cell[CORNERS + 3] = low_sign, high_sign
        other[CORNERS], other[CORNERS + 1] = low_sign, high_sign
        cell[SIDES + 6], cell[SIDES + 7], other[SIDES + 4], other[SIDES + 5] = start, found, start, found


@uncounted
def _add_arc(p, q, cell, over_v, rising, first, last, w, arcs, counts):
    k = _next_row(arcs, ARCS, counts)
    if k < 0:
        return
    arc = arcs[k]
    i, j = cell[NODE_U], cell[NODE_V]
    arc[START], arc[END], arc[ARC_U], arc[ARC_V] = first, last, part_of(p, i), part_of(q, j)
    arc[OVER], arc[RISING] = over_v, rising
    arc[S_BOUND], arc[T_BOUND] = w[RANGES, 0, WHICH], w[RANGES, 1, WHICH]
    arc[LOW] = p[i, FACTS, LO] if over_v == 1 else q[j, FACTS, LO]
    arc[HIGH] = p[i, FACTS, HI] if over_v == 1 else q[j, FACTS, HI]
    for c in range(3):
        arc[VIEW + c] = w[RANGES, SIGHT, c]


@uncounted
def _graph(p, q, cell, over_v, rising, w, places, arcs, counts):
    """Join the crossings of a cell in which the curve is a graph; whether that went."""
    first, last = (SIDES + 4, SIDES + 6) if over_v else (SIDES, SIDES + 2)
    near, far = (SIDES, SIDES + 2) if over_v else (SIDES + 4, SIDES + 6)
    total = cell[first + 1] + cell[last + 1] + cell[near + 1] + cell[far + 1]
    if cell[first + 1] > 1 or cell[last + 1] > 1 or total % 2 == 1:
        return False
    run = Y if over_v else X
    a, b, pending = np.int64(0), np.int64(0), np.int64(-1)
    for k in range(total):
        if k < cell[first + 1]:
            here = cell[first]
        elif a < cell[near + 1] and (
            b == cell[far + 1] or places[cell[near] + a, run] <= places[cell[far] + b, run]
        ):
            here = cell[near] + a
            a += 1
        elif b < cell[far + 1]:
            here = cell[far] + b
            b += 1
        else:
            here = cell[last]
        if pending < 0:
            pending = here
        else:
            _add_arc(p, q, cell, over_v, rising, pending, here, w, arcs, counts)
            pending = np.int64(-1)
    return True


# -- all cells ----------------------------------------------------------------------------------------------


@uncounted
def _corner(p, i, q, j, closed_p, closed_q, corners, opened, counts):
    """The sign of Delta at joint i of p and j of q."""
    parts_p, parts_q = corners.shape[0] - 1, corners.shape[1] - 1
    i = 0 if closed_p and i == parts_p else i
    j = 0 if closed_q and j == parts_q else j
    if corners[i, j] == 0:
        a = 0 if i < parts_p else 2 * degree(p)
        b = 0 if j < parts_q else 2 * degree(q)
        k, m = min(i, parts_p - 1), min(j, parts_q - 1)
        value, error = delta_at(p, k, a, q, m, b), delta_error(p, k, q, m)
        corners[i, j] = 1 if value >= -error else -1
        at_border = (not closed_p and (i == 0 or i == parts_p)) or (not closed_q and (j == 0 or j == parts_q))
        if at_border and abs(value) <= error:
            x, y = 0.0 if a == 0 else 1.0, 0.0 if b == 0 else 1.0
            _open(k, x, x, m, y, y, opened, counts)
    return corners[i, j]


@uncounted
def _border(p, i, q, j, along_v, far, closed_p, closed_q, joints, w, places, opened, counts):
    """Start and count of the crossings on one side of the cell of two parts."""
    corners = joints[0]
    closed, parts = (closed_p, corners.shape[0] - 1) if along_v else (closed_q, corners.shape[1] - 1)
    line = (i if along_v else j) + far
    kind = 0
    if closed:
        line = 0 if line == parts else line
    elif line == 0 or line == parts:
        kind = (1 if along_v else 3) + far
    at_u, at_v = (line, j) if along_v else (i, line)
    starts = joints[1 if along_v else 3]
    found = joints[2 if along_v else 4]
    if starts[at_u, at_v] < 0:
        m, n = i + (far if along_v else 0), j + (0 if along_v else far)
        before = _corner(p, m, q, n, closed_p, closed_q, corners, opened, counts)
        m, n = i + (far if along_v else 1), j + (1 if along_v else far)
        after = _corner(p, m, q, n, closed_p, closed_q, corners, opened, counts)
        fixed, own, running, node = (p, i, q, j) if along_v else (q, j, p, i)
        a = 0 if far == 0 else 2 * degree(fixed)
        starts[at_u, at_v] = counts[PLACES]
        found[at_u, at_v] = _crossings(
            fixed, own, a, running, node, along_v, before, after, kind, w, places, opened, counts
        )  # fmt: skip
    return starts[at_u, at_v], found[at_u, at_v]


@uncounted
def search(p, q, closed_p, closed_q, known, budget, joints, w, cells, places, arcs, opened, counts):
    """Find all arcs of two chains; `budget`: cells looked at before the rest is left open.

    known: (parts of p, parts of q) bools: pairs of parts that are not looked at.

    joints: (5, parts of p + 1, parts of q + 1): signs at corners of parts, 0 for unknown, then start (-1: unknown) and
    count of the crossings on lines of constant u, and the same for lines of constant v.
    counts[SHORT] tells that an array was too small: then the answer is incomplete, ask again with larger ones.
    """
    for m in range(joints.shape[1] - 1):
        for n in range(joints.shape[2] - 1):
            if known[m, n] or apart(p, m, q, n):
                continue
            cell = cells[0]
            cell[NODE_U], cell[NODE_V] = m, n
            for k in range(4):
                cell[CORNERS + k] = _corner(
                    p, m + k % 2, q, n + k // 2, closed_p, closed_q, joints[0], opened, counts
                )  # fmt: skip
                start, count = _border(
                    p, m, q, n, YES if k < 2 else NO, k % 2, closed_p, closed_q, joints, w, places, opened, counts
                )
                cell[SIDES + 2 * k], cell[SIDES + 2 * k + 1] = start, count
            # the cell and its parts, depth first
            top = NO
            while top >= 0 and counts[SHORT] == 0:
                cell = cells[top]
                i, j = cell[NODE_U], cell[NODE_V]
                counts[SEEN] += 1
                crossings = cell[SIDES + 1] + cell[SIDES + 3] + cell[SIDES + 5] + cell[SIDES + 7]
                what, rising = _examine(p, i, q, j, crossings, w)
                if what == NOTHING:
                    top -= 1
                    continue
                if what == OVER_U or what == OVER_V:
                    over_v = YES if what == OVER_V else NO
                    if _graph(p, q, cell, over_v, rising, w, places, arcs, counts):
                        top -= 1
                        continue
                    what = CUT_U
                deep_u, deep_v = p[i, FACTS, DEPTH] >= DEEPEST, q[j, FACTS, DEPTH] >= DEEPEST
                if what == FLAT or (deep_u and deep_v) or counts[SEEN] > budget:
                    x0, x1, y0, y1 = p[i, FACTS, LO], p[i, FACTS, HI], q[j, FACTS, LO], q[j, FACTS, HI]
                    _open(part_of(p, i), x0, x1, part_of(q, j), y0, y1, opened, counts)
                    top -= 1
                    continue
                along_u = YES if (what == CUT_U and not deep_u) or deep_v else NO
                _cut(p, q, top, along_u, w, cells, places, opened, counts)
                top += 1
            if counts[SHORT] == 1:
                return
