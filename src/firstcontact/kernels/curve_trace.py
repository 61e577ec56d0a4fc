"""Polylines along the arcs of an intersection curve."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curve_bends import fourth_derivative
from firstcontact.kernels.curve_lanes import ACROSS, LANES, PLACES, RUN, SPACE, on_arc_lanes
from firstcontact.kernels.curve_points import (
    ARC_U,
    ARC_V,
    COLUMNS,
    END,
    OF_P,
    OF_Q,
    OVER,
    POINT,
    START,
    YES,
    S,
    T,
    X,
    Y,
    enter,
    evaluate,
    on_arc,
)
from firstcontact.kernels.jit import kernel

# A chord is kept where the curve is proved to leave it by at most this part of the tolerance, and turns by less
# (radians); the rest is for roundings of the bounds.  Chords are made for AIM.
KEEP, AIM, LARGEST_TURN = 0.999, 0.9, 0.35
# A chord along which second differences stay below so many times their mean falls into equal parts, unseen where it
# needs no more than SHORT of them.
MOST_UNSTEADY, SHORT = 1.5, LANES + 1.0
# Parts into which one chord falls at once, and the shortest that is cut, in parameters of a part: nothing is proved of
# shorter ones.
MOST_PARTS, LEAST_CHORD = 16, 1e-9
STACK = 256
# Of second differences, in coordinates about the centre: points are known to a few roundings of these.
ROUNDING = 1e-14
# Of the fourth derivative times the square of the way between points, as `trace` explains: 1 + 3 / 12.
BETWEEN = 1.25
# Of the way by which chords are to be shorter, what is tried: bounds on the rest shrink with it too.
SHORTER = .8
# Typed: Numba compiles a function anew for every Python integer written into a call.
NONE = np.int64(0)


@kernel
def _bends(here, inner, end):
    """Of five points: lengths of their second differences, and the largest of a line through neighbours among them.

    The line goes on over the first and the last quarter.
    """
    a = b = c = d = e = 0.0
    for k in range(POINT, POINT + 3):
        x = here[k] - 2.0 * inner[0, k] + inner[1, k]
        y = inner[0, k] - 2.0 * inner[1, k] + inner[2, k]
        z = inner[1, k] - 2.0 * inner[2, k] + end[k]
        a, b, c = a + x * x, b + y * y, c + z * z
        d, e = d + (2.0 * x - y) ** 2, e + (2.0 * z - y) ** 2
    return np.sqrt(a), np.sqrt(b), np.sqrt(c), np.sqrt(max(max(max(a, b), c), max(d, e)))


@kernel
def _most_bent(here, end, count, w):
    """As `_bends`, of `count` points in lanes between two others, more than two."""
    most = 0.0
    for i in range(count):
        left, right = max(i - 1, 0), min(i + 1, count - 1)
        size, ahead = 0.0, 0.0
        for c in range(3):
            row = (SPACE + c) * LANES
            before = here[POINT + c] if i == 0 else w[row + left]
            after = end[POINT + c] if i == count - 1 else w[row + right]
            d = before - 2.0 * w[row + i] + after
            size += d * d
            if i == 0:
                e = w[row] - 2.0 * w[row + 1] + w[row + 2]
                ahead += (2.0 * d - e) ** 2
            elif i == count - 1:
                e = w[row + i] - 2.0 * w[row + i - 1] + w[row + i - 2]
                ahead += (2.0 * d - e) ** 2
        most = max(most, max(size, ahead))
    return np.sqrt(most)


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
def _put_lanes(arc, count, ranges_p, ranges_q, bounds, centre, w, points, parameters, k):
    """The same of the first lanes, from row k on."""
    u, v = int(arc[ARC_U]), int(arc[ARC_V])
    r, z = ranges_p[u], ranges_q[v]
    of_p, of_q, first, second = (ACROSS, RUN, 1, 0) if arc[OVER] == 1.0 else (RUN, ACROSS, 0, 1)
    for i in range(count):
        x, y = w[of_p * LANES + i], w[of_q * LANES + i]
        for c in range(3):
            points[k + i, c] = centre[c] + w[(SPACE + c) * LANES + i]
        parameters[k + i, 0] = ((1.0 - x) * r[0, 0] + x * r[1, 0]) / ((1.0 - x) * r[0, 1] + x * r[1, 1])
        parameters[k + i, 1] = ((1.0 - y) * z[0, 0] + y * z[1, 0]) / ((1.0 - y) * z[0, 1] + y * z[1, 1])
        s, t = w[(PLACES + first) * LANES + i], w[(PLACES + second) * LANES + i]
        s, t = min(max(s, 0.0), 1.0), min(max(t, 0.0), 1.0)
        parameters[k + i, 2] = (1.0 - s) * bounds[0, 0] + s * bounds[0, 1]
        parameters[k + i, 3] = (1.0 - t) * bounds[1, 0] + t * bounds[1, 1]


@kernel
def trace(
    p, q, arcs, places, tolerance, ranges_p, ranges_q, bounds, centre, bends_p, bends_q, stack, known, r, w, points,
    parameters, starts,
):  # fmt: skip
    """Points (x, y, z) and parameters (u, v, s, t) of every arc with both its ends: rows starts[k] to starts[k + 1].

    p, q: the forms of `evaluate`; ranges: (parts, 2, 2) projective parameters at both ends of every part; bounds: the
    ranges of s and t; centre: to which coordinates are relative so far; bends: of `derivative_bounds`.
    Returns False where `points` is too short.

    Of points that are g apart along the arc, second differences over g^2 are second derivatives, off by at most
    g^2 / 12 of the fourth derivative; between them, and out to the ends, a line through two of them is off by g^2 more.
    So a chord of length h is off the curve by at most h^2 / 8 times the largest on these lines and BETWEEN g^2 of the
    fourth derivative.  Chords are looked at in their quarters, then in the parts into which they fall.
    """
    used = NONE
    starts[0] = 0
    for k in range(arcs.shape[0]):
        arc = arcs[k]
        starts[k + 1] = used
        if arc[START] < 0.0:
            continue
        over_v = arc[OVER] == 1.0
        run, other = (Y, X) if over_v else (X, Y)
        fixed, moving, first, second = (OF_Q, OF_P, T, S) if over_v else (OF_P, OF_Q, S, T)
        of_p, of_q = bends_p[int(arc[ARC_U])], bends_q[int(arc[ARC_V])]
        of_fixed, of_moving = (of_q, of_p) if over_v else (of_p, of_q)
        form, part = (q, int(arc[ARC_V])) if over_v else (p, int(arc[ARC_U]))
        form_m, part_m = (p, int(arc[ARC_U])) if over_v else (q, int(arc[ARC_V]))
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
            on_arc(p, q, arc, begin + 0.5 * length, 0.5 * (y + z), r, known[1])
            x = known[1, other]
            evaluate(form, part, begin + 0.5 * length, fixed, YES, r)
            fourth = fourth_derivative(
                form, part, begin + 0.5 * length, form_m, part_m, x, fixed, moving, of_fixed, of_moving,
                0.5 * abs(length), known[1, first], known[1, second], r,
            )  # fmt: skip
            # by the parabola through the middle
            on_arc(p, q, arc, begin + 0.25 * length, 0.75 * x + (0.375 * y - 0.125 * z), r, known[0])
            on_arc(p, q, arc, begin + 0.75 * length, 0.75 * x + (0.375 * z - 0.125 * y), r, known[2])
            a, b, c, most = _bends(here, known, end)
            far = abs(known[1, POINT]) + abs(known[1, POINT + 1]) + abs(known[1, POINT + 2])
            seen, unseen = 2.0 * most + ROUNDING * far, 0.125 * BETWEEN * length**4 * fourth
            even = 3.0 * max(a, max(b, c)) <= MOST_UNSTEADY * (a + b + c)
            turn = np.arccos(min(max(_cosine(here, known[1], end), -1.0), 1.0))
            need = max(np.sqrt(seen / (AIM * tolerance)), turn / LARGEST_TURN)
            parts = 1 if need <= 1.0 else 2 if need <= 2.0 else 4 if need <= 4.0 else int(np.ceil(min(need, 1e6)))
            if parts <= 4:
                while parts < 4 and (seen + unseen / 16.0) / parts**2 > KEEP * tolerance:
                    parts *= 2
                kept = (seen + unseen / 16.0) / parts**2 <= KEEP * tolerance and (parts == 1 or even)
            else:
                kept = even and need <= SHORT and unseen / parts**4 <= (KEEP - AIM) * tolerance
                if kept:
                    for i in range(LANES):
                        m = min(i + 1, parts - 1)
                        w[RUN * LANES + i] = begin + m / parts * length
                        w[ACROSS * LANES + i] = _through(y, known[0, other], x, known[2, other], z, m / parts)
                    kept = on_arc_lanes(p, q, arc, w)
                if kept:
                    bent = 0.125 * (_most_bent(here, end, parts - 1, w) + ROUNDING * far)
                    kept = bent + unseen / parts**4 <= KEEP * tolerance
            if not kept:
                room = stack.shape[0] - top
                if room == 1 or abs(length) < LEAST_CHORD:
                    parts, kept = 1, True
                else:
                    # for the fourth derivative, chords are to be shorter by the root of its share; it shrinks with them
                    shorter = 4.0 / SHORTER
                    if unseen < 1e300:
                        shorter = np.sqrt(np.sqrt(unseen / ((KEEP - AIM) * tolerance))) / max(need, 1.0)
                    if even:
                        shorter = max(shorter, need / SHORT)
                    parts = int(min(max(np.ceil(SHORTER * shorter), 2.0), min(MOST_PARTS, room)))
            if used + parts > points.shape[0]:
                return False
            if not kept:
                for m in range(1, parts):
                    # the first one last, on top
                    guess = _through(y, known[0, other], x, known[2, other], z, m / parts)
                    on_arc(p, q, arc, begin + m / parts * length, guess, r, stack[top + parts - m])
                top += parts - 1
                continue
            if parts <= 4:
                for m in range(1, parts):
                    row = known[4 * m // parts - 1]
                    _put(arc, row, ranges_p, ranges_q, bounds, centre, points, parameters, used + m - 1)
            else:
                _put_lanes(arc, parts - 1, ranges_p, ranges_q, bounds, centre, w, points, parameters, used)
            used += parts - 1
            _put(arc, end, ranges_p, ranges_q, bounds, centre, points, parameters, used)
            used += 1
            for n in range(COLUMNS):
                here[n] = end[n]
            top -= 1
        starts[k + 1] = used
    return True
