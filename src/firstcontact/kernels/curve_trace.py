"""Polylines along the arcs of an intersection curve."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curve_points import END, GAP, OVER, POINT, START, X, Y, enter, on_arc
from firstcontact.kernels.jit import kernel

# A chord is kept where the curve leaves it by at most this part of the tolerance, and turns by less (radians).
KEEP, LARGEST_TURN = 0.9, 0.35
# Parts into which one chord falls at once, and the shortest that is cut, in parameters of a part.
MOST_PARTS, LEAST_CHORD = 16, 1e-9
STACK = 256


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
def _between(p, q, arc, run, here, end, part, guess, r, row):
    """Set `row` to the point of the arc at a part of the way, with a guess of its other parameter."""
    on_arc(p, q, arc, here[run] + part * (end[run] - here[run]), guess, r, row)


@kernel
def _through(a, b, c, d, e, x):
    """The value at x of the polynomial with these values at 0, 1/4, 1/2, 3/4 and 1 (Newton's differences)."""
    x *= 4.0
    b1, c1, d1, e1 = b - a, c - b, d - c, e - d
    b2, c2, d2 = 0.5 * (c1 - b1), 0.5 * (d1 - c1), 0.5 * (e1 - d1)
    b3, c3 = (c2 - b2) / 3.0, (d2 - c2) / 3.0
    return a + x * (b1 + (x - 1.0) * (b2 + (x - 2.0) * (b3 + (x - 3.0) * 0.25 * (c3 - b3))))


@kernel
def trace(p, q, arcs, count, places, tolerance, stack, known, r, points, starts):
    """The inner points of every arc, row by row as in `places`; arc k has rows starts[k] to starts[k + 1].

    Chords are looked at in their quarters; where the curve bends evenly, these settle into how many equal parts a chord
    falls, otherwise it is halved.  Returns False where `points` is too short.
    """
    used = 0
    starts[0] = 0
    for k in range(count):
        arc = arcs[k]
        starts[k + 1] = used
        if arc[START] < 0:
            continue
        run, other = (Y, X) if arc[OVER] == 1 else (X, Y)
        # stack: ends of chords, the nearest on top; `here`: where that one begins
        here = known[4]
        enter(p, q, arc, places[arc[START]], here)
        enter(p, q, arc, places[arc[END]], stack[0])
        top = 0
        while top >= 0:
            end = stack[top]
            y, z = here[other], end[other]
            _between(p, q, arc, run, here, end, 0.5, 0.5 * (y + z), r, known[1])
            x = known[1, other]
            _between(p, q, arc, run, here, end, 0.25, 0.75 * x + 0.375 * y - 0.125 * z, r, known[0])
            _between(p, q, arc, run, here, end, 0.75, 0.75 * x - 0.125 * y + 0.375 * z, r, known[2])
            a, b, c = _off(here, end, known[0]), _off(here, end, known[1]), _off(here, end, known[2])
            off = max(a, max(b, c))
            even = abs(a - 0.75 * off) <= 0.2 * off and abs(c - 0.75 * off) <= 0.2 * off
            turn = np.arccos(min(max(_cosine(here, known[1], end), -1.0), 1.0))
            need = max(np.sqrt(off / (KEEP * tolerance)), turn / LARGEST_TURN)
            if abs(end[run] - here[run]) < LEAST_CHORD:
                need = 1.0
            room = stack.shape[0] - top - 1
            if room > 0 and (need > 4.0 or (need > 1.0 and not even)):
                # equal parts go on top, the first one last; they are looked at again
                parts = int(min(np.ceil(need / 3.5), min(MOST_PARTS, room + 1))) if even else 2
                for m in range(1, parts):
                    guess = _through(y, known[0, other], x, known[2, other], z, m / parts)
                    _between(p, q, arc, run, here, end, m / parts, guess, r, stack[top + parts - m])
                top += parts - 1
                continue
            parts = 1 if need <= 1.0 else 2 if need <= 2.0 else 4
            if used + parts > points.shape[0]:
                return False
            for m in range(1, parts + 1):
                if m == parts and top == 0:
                    break
                row = end if m == parts else known[4 * m // parts - 1]
                for n in range(GAP + 1):
                    points[used, n] = row[n]
                used += 1
            for n in range(GAP + 1):
                here[n] = end[n]
            top -= 1
        starts[k + 1] = used
    return True
