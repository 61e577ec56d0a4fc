"""Polylines along the arcs of an intersection curve."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curve_points import END, GAP, OVER, POINT, START, X, Y, enter, on_arc
from firstcontact.kernels.jit import kernel

# A chord is kept where the curve leaves it by at most this part of the tolerance, and turns by less than this (radians).
KEEP, LARGEST_TURN = 0.9, 0.35
# Parts into which one chord falls at most, and the shortest that is cut, in parameters of a part.
MOST_PARTS, LEAST_CHORD = 256, 1e-9
STACK = 40
NONE, SOME = np.int64(0), np.int64(1)


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
def _between(p, q, arc, run, here, end, part, known, knots, r, row):
    """Set `row` to the point of the arc at a part of the way, guessed through the points known at some parts."""
    other = X + Y - run
    guess = here[other] + part * (end[other] - here[other])
    if knots > 0:
        # through the ends and the points at 1/4, 1/2, 3/4
        guess = 0.0
        for m in range(5):
            weight = 1.0
            for n in range(5):
                if n != m:
                    weight *= (4.0 * part - n) / (m - n)
            guess += weight * (here[other] if m == 0 else end[other] if m == 4 else known[m - 1, other])
    on_arc(p, q, arc, here[run] + part * (end[run] - here[run]), guess, r, row)


@kernel
def trace(p, q, arcs, count, places, tolerance, stack, known, r, points, starts):
    """The inner points of every arc, row by row as in `places`; arc k has rows starts[k] to starts[k + 1].

    Chords are looked at in their quarters; where the curve bends evenly, these settle into how many equal parts a chord
    falls, otherwise it is halved.  Returns False where `points` is too short.
    """
    used = 0
    starts[0] = 0
    fresh = known[3]
    for k in range(count):
        arc = arcs[k]
        starts[k + 1] = used
        if arc[START] < 0:
            continue
        run = Y if arc[OVER] == 1 else X
        # stack: ends of chords, the nearest on top; `here`: where that one begins
        here = known[4]
        enter(p, q, arc, places[arc[START]], here)
        enter(p, q, arc, places[arc[END]], stack[0])
        top = 0
        while top >= 0:
            end = stack[top]
            for m in range(3):
                _between(p, q, arc, run, here, end, 0.25 * (m + 1), known, NONE, r, known[m])
            a, b, c = _off(here, end, known[0]), _off(here, end, known[1]), _off(here, end, known[2])
            off = max(a, max(b, c))
            even = abs(a - 0.75 * off) <= 0.2 * off and abs(c - 0.75 * off) <= 0.2 * off
            turn = np.arccos(min(max(_cosine(here, known[1], end), -1.0), 1.0))
            need = max(np.sqrt(off / (KEEP * tolerance)), turn / LARGEST_TURN)
            if abs(end[run] - here[run]) < LEAST_CHORD:
                need = 1.0
            if need > 1.0 and not even and top + 1 < stack.shape[0]:
                for n in range(GAP + 1):
                    stack[top + 1, n] = known[1, n]
                top += 1
                continue
            parts = int(min(np.ceil(need), MOST_PARTS))
            last = parts if top > 0 else parts - 1
            if used + last > points.shape[0]:
                return False
            for m in range(1, last + 1):
                row = end if m == parts else fresh
                if m < parts:
                    _between(p, q, arc, run, here, end, m / parts, known, SOME, r, fresh)
                for n in range(GAP + 1):
                    points[used, n] = row[n]
                used += 1
            for n in range(GAP + 1):
                here[n] = end[n]
            top -= 1
        starts[k + 1] = used
    return True
