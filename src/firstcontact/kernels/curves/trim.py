"""Arcs of an intersection curve cut where it leaves the ranges of s and t.

On an arc each of these positions passes at most one end of its range: the search has proved it.
"""

from __future__ import annotations

from firstcontact.kernels.curves.points import (
    ARC_U,
    ARC_V,
    CUT,
    END,
    KIND,
    OVER,
    PART_U,
    PART_V,
    S_BOUND,
    S_IN,
    START,
    T_IN,
    VIEW,
    S,
    T,
    X,
    Y,
    enter,
    inside,
    may_be_inside,
    on_arc,
    place,
)
from firstcontact.kernels.jit import uncounted

# Of parameters in their parts: where bounds of both pieces leave less of an arc, it is not told from a point.
LEAST_ARC = 1e-10


@uncounted
def _bracket(which, end, d, r):
    """On which side of the other ruling an end of this one is, seen along d, for the rulings in r.values."""
    x, other, at = (0, 1, 4 * end) if which == 0 else (1, 0, 4 * end)
    u, v, w = 1.0 / r[x, at + 3], 1.0 / r[other, 3], 1.0 / r[other, 7]
    y0, y1, y2 = r[other, 0] * v, r[other, 1] * v, r[other, 2] * v
    a0, a1, a2 = r[x, at] * u - y0, r[x, at + 1] * u - y1, r[x, at + 2] * u - y2
    b0, b1, b2 = r[other, 4] * w - y0, r[other, 5] * w - y1, r[other, 6] * w - y2
    return d[0] * (a1 * b2 - a2 * b1) + d[1] * (a2 * b0 - a0 * b2) + d[2] * (a0 * b1 - a1 * b0)


@uncounted
def _leaves(p, q, arc, good, bad, which, end, r, row):
    """Set `row` to the point of an arc between two of its points at which s (which = 0) or t passes this end.

    The good point itself where it is at the end, as far as rounding tells.
    """
    run, other = (Y, X) if arc[OVER] == 1 else (X, Y)
    part_p, part_q, view = int(arc[ARC_U]), int(arc[ARC_V]), arc[VIEW:]
    place(p, part_p, bad[X], q, part_q, bad[Y], r, row)
    b, at_b = bad[run], _bracket(which, end, view, r)
    place(p, part_p, good[X], q, part_q, good[Y], r, row)
    a, at_a = good[run], _bracket(which, end, view, r)
    if at_a * at_b >= 0.0:
        b = a
    sign = 1.0 if at_a > 0.0 else -1.0
    y = good[other]
    side = 0
    for step in range(90):
        x = (a * at_b - b * at_a) / (at_b - at_a) if at_a * at_b < 0.0 and step < 12 else 0.5 * (a + b)
        if not min(a, b) < x < max(a, b):
            break
        on_arc(p, q, arc, x, y, r, row)
        y = row[other]
        value = _bracket(which, end, view, r)
        if value == 0.0:
            break
        if value * sign > 0.0:
            if abs(x - a) < 1e-17:
                break
            a, at_a = x, value
            if side == 1:
                at_b *= 0.5
            side = 1
        else:
            if abs(x - b) < 1e-17:
                break
            b, at_b = x, value
            if side == -1:
                at_a *= 0.5
            side = -1
    row[PART_U], row[PART_V], row[KIND] = part_p, part_q, CUT + 2 * which + end
    row[S if which == 0 else T] = end
    row[S_IN], row[T_IN] = inside(row[S]), inside(row[T])


@uncounted
def trim(p, q, places, used, arcs, count, known, r):
    """Set what `places` lacks, and cut the arcs; new places follow the `used` ones.  Places in use afterwards.

    p, q: the forms of `evaluate`.
    """
    for k in range(used):
        row = places[k]
        place(p, int(row[PART_U]), row[X], q, int(row[PART_V]), row[Y], r, row)
        row[S_IN], row[T_IN] = inside(row[S]), inside(row[T])
    first, last = known[0], known[1]
    for k in range(count):
        arc = arcs[k]
        run = Y if arc[OVER] == 1 else X
        enter(arc, places[int(arc[START])], first)
        enter(arc, places[int(arc[END])], last)
        from_, to, empty, cut = first[run], last[run], False, False
        point = arc[END] if may_be_inside(last) else arc[START] if may_be_inside(first) else -1.0
        doubtful = False
        for which in range(2):
            end = int(arc[S_BOUND + which])
            first_in, last_in = first[S_IN + which] == 1.0, last[S_IN + which] == 1.0
            if end < 0 or (first_in and last_in):
                continue
            if not first_in and not last_in:
                empty, doubtful = point < 0.0, True
                if empty:
                    break
                continue
            row = places[used]
            _leaves(p, q, arc, first if first_in else last, last if first_in else first, which, end, r, row)
            if first_in and row[run] < to:
                to, arc[END] = row[run], used
            elif last_in and row[run] > from_:
                from_, arc[START] = row[run], used
            used += 1
            cut = True
        if empty or doubtful or (cut and to - from_ < LEAST_ARC):
            if not doubtful:
                point = arc[START] if to - from_ > -LEAST_ARC else -1.0
            arc[START], arc[END] = (-2, point) if not empty and point >= 0.0 else (-1, -1)
    return used
