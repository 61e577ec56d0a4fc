"""Polylines along the arcs of an intersection curve."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curve_points import ARC_U, ARC_V, END, GAP, OVER, POINT, START, S, T, X, Y, enter, on_arc
from firstcontact.kernels.jit import kernel

# A chord is kept where the curve leaves it by at most this part of the tolerance, and turns by less (radians).
KEEP, LARGEST_TURN = 0.7, 0.35
# A chord along which the second derivative stays below so many times its mean falls into equal parts, unseen where it
# needs no more than SHORT of them.
MOST_UNSTEADY, SHORT = 2.0, 12.0
# Parts into which one chord falls at once, and the shortest that is cut, in parameters of a part.
MOST_PARTS, LEAST_CHORD = 16, 1e-9
STACK = 256
# Typed: Numba compiles a function anew for every Python integer written into a call.
NONE = np.int64(0)


@kernel
def _off(a, b, x):
    """Distance of the point x from the chord of a and b."""
    d0, d1, d2 = b[POINT] - a[POINT], b[POINT + 1] - a[POINT + 1], b[POINT + 2] - a[POINT + 2]
    e0, e1, e2 = x[POINT] - a[POINT], x[POINT + 1] - a[POINT + 1], x[POINT + 2] - a[POINT + 2]
    length = d0 * d0 + d1 * d1 + d2 * d2
    t = min(max((e0 * d0 + e1 * d1 + e2 * d2) / length, 0.0), 1.0) if length > 0.0 else 0.0
    e0, e1, e2 = e0 - t * d0, e1 - t * d1, e2 - t * d2
    return np.sqrt(e0 * e0 + e1 * e1 + e2 * e2)


@kernel
def _cosine(a, x, b):
    """Of the turn from the chord a x to the chord x b."""
    d0, d1, d2 = x[POINT] - a[POINT], x[POINT + 1] - a[POINT + 1], x[POINT + 2] - a[POINT + 2]
    e0, e1, e2 = b[POINT] - x[POINT], b[POINT + 1] - x[POINT + 1], b[POINT + 2] - x[POINT + 2]
    size = (d0 * d0 + d1 * d1 + d2 * d2) * (e0 * e0 + e1 * e1 + e2 * e2)
    return (d0 * e0 + d1 * e1 + d2 * e2) / np.sqrt(size) if size > 0.0 else 1.0


@kernel
def _through(a, b, c, d, e, x):
    """The value at x of the polynomial with these values at 0, 1/4, 1/2, 3/4 and 1 (Newton's differences)."""
    x *= 4.0
    b1, c1, d1, e1 = b - a, c - b, d - c, e - d
    b2, c2, d2 = 0.5 * (c1 - b1), 0.5 * (d1 - c1), 0.5 * (e1 - d1)
    b3, c3 = (c2 - b2) / 3.0, (d2 - c2) / 3.0
    return a + x * (b1 + (x - 1.0) * (b2 + (x - 2.0) * (b3 + (x - 3.0) * 0.25 * (c3 - b3))))


@kernel
def _put(arc, row, ranges_p, ranges_q, bounds, centre, points, parameters, k):
    """Write a point of an arc as users see it: its coordinates, and u, v, s, t."""
    u, v, x, y = int(arc[ARC_U]), int(arc[ARC_V]), row[X], row[Y]
    for c in range(3):
        points[k, c] = centre[c] + row[POINT + c]
    r, z = ranges_p[u], ranges_q[v]
    parameters[k, 0] = ((1.0 - x) * r[0, 0] + x * r[1, 0]) / ((1.0 - x) * r[0, 1] + x * r[1, 1])
    parameters[k, 1] = ((1.0 - y) * z[0, 0] + y * z[1, 0]) / ((1.0 - y) * z[0, 1] + y * z[1, 1])
    s, t = min(max(row[S], 0.0), 1.0), min(max(row[T], 0.0), 1.0)
    parameters[k, 2] = (1.0 - s) * bounds[0, 0] + s * bounds[0, 1]
    parameters[k, 3] = (1.0 - t) * bounds[1, 0] + t * bounds[1, 1]


@kernel
def trace(
    p, q, arcs, places, tolerance, ranges_p, ranges_q, bounds, centre, stack, known, r, points, parameters, starts
):
    """Points (x, y, z) and parameters (u, v, s, t) of every arc with both its ends: rows starts[k] to starts[k + 1].

    p, q: the forms of `evaluate`; ranges: (parts, 2, 2) projective parameters at both ends of every part; bounds: the
    ranges of s and t; centre: to which coordinates are relative so far.
    Chords are looked at in their quarters; where the curve bends evenly, these settle into how many equal parts a short
    chord falls, longer ones are cut and looked at again.  Returns False where `points` is too short.
    """
    used = NONE
    starts[0] = 0
    for k in range(arcs.shape[0]):
        arc = arcs[k]
        starts[k + 1] = used
        if arc[START] < 0.0:
            continue
        run, other = (Y, X) if arc[OVER] == 1.0 else (X, Y)
        # stack: ends of chords, the nearest on top; `here`: where that one begins
        here = known[3]
        enter(arc, places[int(arc[START])], here)
        enter(arc, places[int(arc[END])], stack[0])
        if used + 1 > points.shape[0]:
            return False
        _put(arc, here, ranges_p, ranges_q, bounds, centre, points, parameters, used)
        used += 1
        top = 0
        while top >= 0:
            end = stack[top]
            y, z = here[other], end[other]
            begin, length = here[run], end[run] - here[run]
            x = 0.5 * (y + z)
            for m in range(3):
                # the middle first, then by the parabola through it
                n = 1 if m == 0 else 0 if m == 1 else 2
                guess = x if m == 0 else 0.75 * x + (0.375 * y - 0.125 * z if m == 1 else 0.375 * z - 0.125 * y)
                on_arc(p, q, arc, begin + 0.25 * (n + 1) * length, guess, r, known[n])
                x = known[1, other]
            a, b, c = _off(here, end, known[0]), _off(here, end, known[1]), _off(here, end, known[2])
            off = max(a, max(b, c))
            # the second derivative at its largest, in units of what bends the whole chord, if it is a parabola itself:
            # a - c tells its slope, a + c against 3/2 b its bend
            unsteady = 1.0 + 6.0 * abs(a - c) / (a + c) + 20.0 * abs((a + c) / (1.5 * b) - 1.0) if off > 0.0 else 1.0
            even = unsteady <= MOST_UNSTEADY
            turn = np.arccos(min(max(_cosine(here, known[1], end), -1.0), 1.0))
            need = max(np.sqrt(off * min(unsteady, MOST_UNSTEADY) / (KEEP * tolerance)), turn / LARGEST_TURN)
            if abs(end[run] - here[run]) < LEAST_CHORD:
                need = 1.0
            room = stack.shape[0] - top
            again = room > 1 and (need > SHORT or (need > 1.0 and not even))
            if again:
                parts = int(min(np.ceil(need / SHORT), min(MOST_PARTS, room))) if even else 2
            else:
                parts = 4 if 2.0 < need <= 4.0 else int(np.ceil(need)) if need > 1.0 else 1
            if used + parts > points.shape[0]:
                return False
            for m in range(1, parts):
                # parts that are looked at again go on top, the first one last
                row = stack[top + parts - m] if again else known[4]
                if not again and 4 * m % parts == 0:
                    row = known[4 * m // parts - 1]
                else:
                    guess = _through(y, known[0, other], x, known[2, other], z, m / parts)
                    on_arc(p, q, arc, begin + m / parts * length, guess, r, row)
                if not again:
                    _put(arc, row, ranges_p, ranges_q, bounds, centre, points, parameters, used)
                    used += 1
            if again:
                top += parts - 1
                continue
            _put(arc, end, ranges_p, ranges_q, bounds, centre, points, parameters, used)
            used += 1
            for n in range(GAP + 1):
                here[n] = end[n]
            top -= 1
        starts[k + 1] = used
    return True
