"""Boxes of (u, s, v, t, T) against linear models: what of a box can hold a zero, and whether it must hold one.

Every row is an equation c + g.e + [-r, r] = 0 for the place e in the box.  Rows, their sums along a direction and rows
after elimination cut the ranges of e (Hansen and Sengupta's step, with remainders in place of interval slopes).
"""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.rulings.linear_models import MORE, REST, ROUND, slope_size
from firstcontact.kernels.rulings.models import AXIS, GAP, WORK

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
INSIDE = 1.0 - 1e-12
"""Of half widths, which are rounded upward: what is below lies inside the box."""
LEAST_ROOM = 1e-40
"""Added to ranges that are narrowed: products of half widths and their roundings stay clear of underflow."""
LEAST_SIZE = 1e-280
"""An equation of smaller numbers tells nothing: its roundings underflow."""
LEAST_PIVOT = 1e-7
"""Of the sum of slopes of its equation; smaller ones are no help."""


@uncounted
def cut(w, row, e):
    """Narrow the ranges e by one equation; False proves that nothing is left."""
    low, high = w[row, 0] - w[row, REST], w[row, 0] + w[row, REST]
    size = abs(w[row, 0]) + w[row, REST]
    for k in range(5):
        g = w[row, 1 + k]
        a, b = g * e[k, 0], g * e[k, 1]
        low += min(a, b)
        high += max(a, b)
        size += abs(g)
    if size < LEAST_SIZE:
        return True
    slack = 8.0 * ROUND * size
    if low > slack or high < -slack:
        return False
    for k in range(5):
        g = w[row, 1 + k]
        if abs(g) <= 1e-3 * size:
            continue
        a, b = g * e[k, 0], g * e[k, 1]
        # g e_k lies in -[low - min(a, b), high - max(a, b)]
        a, b = (max(a, b) - high - slack) / g, (min(a, b) - low + slack) / g
        if g < 0.0:
            a, b = b, a
        a -= ROUND * abs(a)
        b += ROUND * abs(b)
        if a > e[k, 0]:
            e[k, 0] = a
        if b < e[k, 1]:
            e[k, 1] = b
        if e[k, 0] > e[k, 1]:
            return False
    return True


@uncounted
def _along(w, n0, n1, n2):
    """The equation n.(P - Q) = 0 in row AXIS."""
    size = 0.0
    for k in range(6):
        a, b, c = n0 * w[GAP, k], n1 * w[GAP + 1, k], n2 * w[GAP + 2, k]
        w[AXIS, k] = a + b + c
        size += abs(a) + abs(b) + abs(c)
    rest = abs(n0) * w[GAP, REST] + abs(n1) * w[GAP + 1, REST] + abs(n2) * w[GAP + 2, REST]
    w[AXIS, REST] = rest * MORE + 2.0 * ROUND * size


@uncounted
def cut_by_directions(w, e, normal):
    """Narrow e by P = Q along the axes and across every two directions of motion in the box; False: nothing is left.

    These are the normals of the faces of the set of linear parts, so nothing better is known to first order.  The
    direction in which most is known, of unit length, goes to `normal`.
    """
    best = -1.0
    for i in range(5):
        for j in range(i, 5):
            if i == j and i >= 3:
                continue
            if i == j:
                n0, n1, n2 = AXES[i]
            else:
                a0, a1, a2 = w[GAP, 1 + i], w[GAP + 1, 1 + i], w[GAP + 2, 1 + i]
                b0, b1, b2 = w[GAP, 1 + j], w[GAP + 1, 1 + j], w[GAP + 2, 1 + j]
                n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
            length = abs(n0) + abs(n1) + abs(n2)
            if not length > 1e-200:
                continue
            _along(w, n0, n1, n2)
            if not cut(w, AXIS, e):
                return False
            known = abs(w[AXIS, 0]) / (slope_size(w, AXIS) + w[AXIS, REST] + 1e-300)
            if known > best:
                best = known
                normal[0], normal[1], normal[2] = n0 / length, n1 / length, n2 / length
    return True


@uncounted
def eliminate(w, minors, fixed, pivots):
    """Gauss-Jordan elimination of copies (rows from WORK on) of P - Q = 0 and of the determinants; the rank.

    pivots[row]: the column solved for, or -1.  The equations of P - Q come first.  Columns with fixed[k] are not
    solved for.  Every step is an exact operation on the equations; its roundings go to the remainders.
    """
    n = 3 + minors
    for i in range(n):
        pivots[i] = -1
        for k in range(7):
            w[WORK + i, k] = w[GAP + i, k]
    rank = 0
    for step in range(n):
        best, p, q = 0.0, -1, -1
        for i in range(n):
            if pivots[i] >= 0 or (i >= 3 and step < 3):
                continue
            norm = slope_size(w, GAP + i)
            for k in range(5):
                if fixed[k] == 0 and abs(w[WORK + i, 1 + k]) > best * norm:
                    best, p, q = abs(w[WORK + i, 1 + k]) / norm, i, k
        if p < 0 or best < LEAST_PIVOT:
            if step < 3:
                continue
            break
        pivots[p] = q
        rank += 1
        for i in range(n):
            if i == p or w[WORK + i, 1 + q] == 0.0:
                continue
            f = w[WORK + i, 1 + q] / w[WORK + p, 1 + q]
            size = 0.0
            for k in range(6):
                a, b = w[WORK + i, k], f * w[WORK + p, k]
                w[WORK + i, k] = a - b
                size += abs(a) + abs(b)
            w[WORK + i, REST] = (w[WORK + i, REST] + abs(f) * w[WORK + p, REST]) * MORE + 2.0 * ROUND * size
        fixed[q] += 2
    for k in range(5):
        if fixed[k] >= 2:
            fixed[k] -= 2
    return rank


@uncounted
def cut_by_elimination(w, minors, fixed, pivots, e):
    """Narrow e by the equations after elimination; False: nothing is left."""
    for i in range(minors):
        if not cut(w, GAP + 3 + i, e):
            return False
    eliminate(w, minors, fixed, pivots)
    for i in range(3 + minors):
        if not cut(w, WORK + i, e):
            return False
    return True


@uncounted
def holds_zero(w, minors, fixed, pivots, image):
    """Whether P = Q has a solution in the box, by Brouwer's theorem; image: T of it lies in e_T of this range.

    Solved columns map the box into itself, those left over stay in the middle; a T that is `fixed` may be anywhere.
    """
    eliminate(w, minors, fixed, pivots)
    image[0], image[1] = -1.0, 1.0
    for i in range(3 + minors):
        k = pivots[i]
        if k < 0:
            if i < 3:
                return False
            continue
        g = abs(w[WORK + i, 1 + k])
        middle = -w[WORK + i, 0] / w[WORK + i, 1 + k]
        rest = w[WORK + i, REST]
        for j in range(3 + minors):
            if j != i and pivots[j] >= 0:
                rest += abs(w[WORK + i, 1 + pivots[j]])
        if fixed[4] == 1:
            rest += abs(w[WORK + i, 5])
        rest = rest / g * MORE + 4.0 * ROUND * (1.0 + abs(middle))
        if not abs(middle) + rest < INSIDE:
            return False
        if k == 4:
            image[0], image[1] = middle - rest, middle + rest
    return True


@uncounted
def shrink(box, e):
    """Move the ranges e of the place in the box into the box; the largest of the ratios of widths, and the least."""
    most, least = 0.0, 1.0
    for k in range(5):
        lo, hi = box[k, 0], box[k, 1]
        if not hi > lo:
            continue
        c = 0.5 * (lo + hi)
        h = max(hi - c, c - lo) * MORE
        slack = ROUND * (abs(c) + h) + LEAST_ROOM
        if e[k, 0] > -1.0:
            box[k, 0] = max(lo, c + h * e[k, 0] - slack)
        if e[k, 1] < 1.0:
            box[k, 1] = min(hi, c + h * e[k, 1] + slack)
        ratio = (box[k, 1] - box[k, 0]) / (hi - lo)
        most, least = max(most, ratio), min(least, ratio)
    return most, least
