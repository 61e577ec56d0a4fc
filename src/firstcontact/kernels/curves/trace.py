"""Polylines along the arcs of an intersection curve."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.curves.bends import fourth_derivative
from firstcontact.kernels.curves.lanes import ACROSS, LANES, MOVING, PLACES, RUN, SPACE, on_arc_lanes
from firstcontact.kernels.curves.lanes import SLOPES as LANE_SLOPES
from firstcontact.kernels.curves.points import (
    ARC_U,
    ARC_V,
    COLUMNS,
    END,
    OF_P,
    OF_Q,
    OVER,
    POINT,
    SLOPES,
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
from firstcontact.kernels.jit import uncounted

# A chord is kept where the curve is proved to leave it by at most this part of the tolerance, and turns by less
# (radians); the rest is for roundings of the bounds.  Chords are made for AIM; what bounds on the fourth derivative add
# is to be no more than UNSEEN.
KEEP, AIM, UNSEEN, LARGEST_TURN = 0.999, 0.96, 0.08, 0.35
# Steps between points that change by less than this part of them turn by less, for its arcsine is below.
STEADY = 1.0 / 3.0
# A stretch that needs this many chords or fewer is taken in quarters; of more it falls into intervals, as many as lanes
# at most, of about so many chords, each of LEAST at least.
FEW, EACH, LEAST, MOST = 4, 12.0, 3, 2**20
# Parts of an interval on which the fourth derivative is bounded apart: the second is tried where the first do not do.
CUTS = (1, 4, 16)
# How far the bound may be above what the chords allow, which then become more by its fourth root; by the last cuts.
FEW_TIMES, MOST_TIMES = 2.0, 16.0
# Parts into which one stretch falls at once, and the shortest that is cut, in parameters of a part: nothing is proved
# of shorter ones.
MOST_PARTS, LEAST_CHORD = 8, 1e-9
# Of the way by which chords are to be shorter, what is tried: bounds on the rest shrink with it too.
SHORTER = 0.8
STACK = 256
# Of second differences, in coordinates: points are known to a few roundings of these.
ROUNDING = 1e-14
# Five points nearer than this, in coordinates or in parts of the tolerance, are one: the curve stands in an apex.
STILL, STILL_OF_TOLERANCE = 1e-12, 1e-6
# Of the fourth derivative times the square of the way between points, as `trace` explains: 1 + 3 / 12.
BETWEEN = 1.25
# Columns of intervals: chords, start and length in the parameter along the arc; centre, unit and coefficients of the
# polynomial that guesses the other one; bound on the fourth derivative of points; second difference across at the
# middle, and the way between both neighbours.  The last row of a plan is the whole stretch.
CHORDS, BEGIN, LENGTH, CENTRE, UNIT, GUESS, FOURTH, BEND, WAY, PLAN_COLUMNS = 0, 1, 2, 3, 4, 5, 10, 11, 12, 13
# Typed: Numba compiles a function anew for every Python integer written into a call.
NONE = np.int64(0)


@uncounted
def _bends(here, inner, end):
    """Of five points: the largest second difference of a line through neighbours among them.

    The line goes on over the first and the last quarter.
    """
    a = b = c = d = e = 0.0
    for k in range(POINT, POINT + 3):
        x = here[k] - 2.0 * inner[0, k] + inner[1, k]
        y = inner[0, k] - 2.0 * inner[1, k] + inner[2, k]
        z = inner[1, k] - 2.0 * inner[2, k] + end[k]
        a, b, c = a + x * x, b + y * y, c + z * z
        d, e = d + (2.0 * x - y) ** 2, e + (2.0 * z - y) ** 2
    return np.sqrt(max(max(max(a, b), c), max(d, e)))


@uncounted
def _cosine(a, x, b):
    """Of the turn from the chord a x to the chord x b."""
    d0, d1, d2 = x[POINT] - a[POINT], x[POINT + 1] - a[POINT + 1], x[POINT + 2] - a[POINT + 2]
    e0, e1, e2 = b[POINT] - x[POINT], b[POINT + 1] - x[POINT + 1], b[POINT + 2] - x[POINT + 2]
    size = (d0 * d0 + d1 * d1 + d2 * d2) * (e0 * e0 + e1 * e1 + e2 * e2)
    return (d0 * e0 + d1 * e1 + d2 * e2) / np.sqrt(size) if size > 0.0 else 1.0


@uncounted
def _is_still(here, inner, end, tolerance):
    """Whether five points of an arc are one: rulings of one side through the apex of the other, of which nothing bounds
    derivatives."""
    for k in range(POINT, POINT + 3):
        x = here[k]
        away = max(max(abs(inner[0, k] - x), abs(inner[1, k] - x)), max(abs(inner[2, k] - x), abs(end[k] - x)))
        if away > max(STILL * abs(x), STILL_OF_TOLERANCE * tolerance):
            return False
    return True


@uncounted
def _leaves(points, k, count, beyond):
    """How far an arc may leave the chords between rows k and k + count of points, count > 2, equally far along the arc.

    beyond: second differences that the points do not show.  Infinite where chords turn too much.

    Only what is across a chord counts, where steps are steady: then points between its ends are between them along it.
    """
    worst = 0.0
    # second differences at both ends of a chord; beyond the first and the last they go on along a line
    l0 = l1 = l2 = r0 = r1 = r2 = 0.0
    for j in range(count):
        a, b = points[k + j], points[k + j + 1]
        c0, c1, c2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        size = c0 * c0 + c1 * c1 + c2 * c2
        if j == 0:
            c, d = points[k + 2], points[k + 3]
            r0, r1, r2 = a[0] - 2.0 * b[0] + c[0], a[1] - 2.0 * b[1] + c[1], a[2] - 2.0 * b[2] + c[2]
            l0 = 2.0 * r0 - (b[0] - 2.0 * c[0] + d[0])
            l1 = 2.0 * r1 - (b[1] - 2.0 * c[1] + d[1])
            l2 = 2.0 * r2 - (b[2] - 2.0 * c[2] + d[2])
        elif j == count - 1:
            c = points[k + j - 2]
            e = points[k + j - 1]
            d0, d1, d2 = r0, r1, r2
            r0 = 2.0 * d0 - (c[0] - 2.0 * e[0] + a[0])
            r1 = 2.0 * d1 - (c[1] - 2.0 * e[1] + a[1])
            r2 = 2.0 * d2 - (c[2] - 2.0 * e[2] + a[2])
            l0, l1, l2 = d0, d1, d2
        else:
            c = points[k + j + 2]
            l0, l1, l2 = r0, r1, r2
            r0, r1, r2 = a[0] - 2.0 * b[0] + c[0], a[1] - 2.0 * b[1] + c[1], a[2] - 2.0 * b[2] + c[2]
        left, right = l0 * l0 + l1 * l1 + l2 * l2, r0 * r0 + r1 * r1 + r2 * r2
        change = max(left, right)
        if STEADY**2 * size >= change and size >= 4.0 * beyond * beyond:
            x, y = l0 * c0 + l1 * c1 + l2 * c2, r0 * c0 + r1 * c1 + r2 * c2
            inverse = 1.0 / size
            change = max(left - x * x * inverse, right - y * y * inverse)
        elif j < count - 1:
            e0, e1, e2 = c0 + r0, c1 + r1, c2 + r2
            dot, other = c0 * e0 + c1 * e1 + c2 * e2, e0 * e0 + e1 * e1 + e2 * e2
            if not dot >= np.cos(LARGEST_TURN) * np.sqrt(size * other):
                return np.inf
        worst = max(worst, change)
    a = points[k]
    return 0.125 * (np.sqrt(worst) + beyond + ROUNDING * (abs(a[0]) + abs(a[1]) + abs(a[2])))


@uncounted
def _guess_through(row, centre, unit, a, b, c, d, e):
    """Set the polynomial of an interval with these values at centre - 2 unit, ..., centre + 2 unit (Stirling)."""
    odd, even, third, fourth = 0.5 * (d - b), b - 2.0 * c + d, 0.5 * (e - a) - (d - b), a - 4.0 * (b + d) + 6.0 * c + e
    row[CENTRE], row[UNIT] = centre, unit
    row[GUESS], row[GUESS + 1], row[GUESS + 2] = c, odd - third / 6.0, 0.5 * even - fourth / 24.0
    row[GUESS + 3], row[GUESS + 4] = third / 6.0, fourth / 24.0


@uncounted
def _guess(row, x):
    x = (x - row[CENTRE]) / row[UNIT]
    return row[GUESS] + x * (row[GUESS + 1] + x * (row[GUESS + 2] + x * (row[GUESS + 3] + x * row[GUESS + 4])))


@uncounted
def _across(w, i):
    """Of three neighbours in lanes, i the middle one: their second difference across the way between them, that way."""
    a = b = c = 0.0
    for k in range(SPACE, SPACE + 3):
        row = k * LANES + i
        d, e = w[row - 1] - 2.0 * w[row] + w[row + 1], w[row + 1] - w[row - 1]
        a, b, c = a + d * d, b + d * e, c + e * e
    return np.sqrt(max(a - b * b / c, 0.0) if c > 0.0 else a), np.sqrt(c)


@uncounted
def _plan(plan, count, begin, length, tolerance, w):
    """Set `count` intervals, but for bounds.  Their middles are in the first lanes.

    Chords are counted by second differences of the middles, which are as far apart as intervals are long.
    """
    for i in range(count):
        row, m = plan[i], min(max(i, 2), count - 3)
        row[BEGIN], row[LENGTH] = begin + i / count * length, length / count
        y = ACROSS * LANES + m
        _guess_through(row, w[RUN * LANES + m], row[LENGTH], w[y - 2], w[y - 1], w[y], w[y + 1], w[y + 2])
        row[BEND], row[WAY] = _across(w, min(max(i, 1), count - 2))
    last = count - 1
    # at the first and the last middle and beyond, by parabolas
    first, second, third = plan[1, BEND], plan[2, BEND], plan[3, BEND]
    start = max(first, 4.375 * first - 5.25 * second + 1.875 * third)
    plan[0, BEND] = max(3.0 * (first - second) + third, 0.5 * first)
    first, second, third = plan[last - 1, BEND], plan[last - 2, BEND], plan[last - 3, BEND]
    end = max(first, 4.375 * first - 5.25 * second + 1.875 * third)
    plan[last, BEND] = max(3.0 * (first - second) + third, 0.5 * first)
    for i in range(count):
        row = plan[i]
        here = row[BEND]
        before = start if i == 0 else 0.5 * (here + plan[i - 1, BEND])
        after = end if i == last else 0.5 * (here + plan[i + 1, BEND])
        # neighbours on both sides of a cusp may be one point
        turn = here / row[WAY] if here < np.pi * row[WAY] else np.pi
        row[CHORDS] = _chords(max(here, max(before, after)), turn, tolerance)


@uncounted
def _chords(bend, turn, tolerance):
    """Into how many an interval falls whose second derivative times the square of its length is `bend`."""
    parts = max(np.sqrt(bend / (8.0 * AIM * tolerance)), 2.0 * turn / LARGEST_TURN)
    return max(np.ceil(min(parts, MOST)), LEAST)


@uncounted
def _sides(p, q, arc, bends_p, bends_q):
    """Of the side that an arc runs over and of the other: form, part and bounds, and their rows of scratch arrays."""
    u, v = int(arc[ARC_U]), int(arc[ARC_V])
    if arc[OVER] == 1.0:
        return q, v, bends_q[v], OF_Q, p, u, bends_p[u], OF_P
    return p, u, bends_p[u], OF_P, q, v, bends_q[v], OF_Q


@uncounted
def _columns(arc):
    """Of rows of places: the parameter along an arc and the one across, the positions on both rulings in this order."""
    return (Y, X, T, S) if arc[OVER] == 1.0 else (X, Y, S, T)


@uncounted
def _fourth(p, q, arc, bends_p, bends_q, x, y, s, t, reach, r):
    """`fourth_derivative` of an arc about x, whose moving ruling and its derivative are in r."""
    form, part, bends, fixed, other, part_other, bends_other, moving = _sides(p, q, arc, bends_p, bends_q)
    evaluate(form, part, x, fixed, YES, r)
    return fourth_derivative(
        form, part, x, other, part_other, y, fixed, moving, bends, bends_other, reach, s, t, r
    )


@uncounted
def _bound(p, q, arc, row, bends_p, bends_q, tolerance, w, i, known, r):
    """Set the bound on the fourth derivative of an interval with its middle in lane i, and see to it that it will do.

    False where none is found.
    """
    _, across, first, second = _columns(arc)
    moving = OF_P if arc[OVER] == 1.0 else OF_Q
    most = 8.0 * UNSEEN * tolerance * row[CHORDS] ** 4 / (BETWEEN * row[LENGTH] ** 4)
    for cuts in CUTS:
        worst, enough = 0.0, MOST_TIMES if cuts == CUTS[-1] else FEW_TIMES
        for k in range(cuts):
            x = row[BEGIN] + (k + 0.5) / cuts * row[LENGTH]
            if cuts == 1:
                for c in range(8):
                    r[moving, c] = w[(MOVING + c) * LANES + i]
                    r[SLOPES + moving, c] = w[(LANE_SLOPES + c) * LANES + i]
                y, s, t = w[ACROSS * LANES + i], w[PLACES * LANES + i], w[(PLACES + 1) * LANES + i]
            else:
                on_arc(p, q, arc, x, _guess(row, x), r, known)
                y, s, t = known[across], known[first], known[second]
            bound = _fourth(p, q, arc, bends_p, bends_q, x, y, s, t, 0.5 * abs(row[LENGTH]) / cuts, r)
            if not bound <= enough * most:
                worst = np.inf
                break
            worst = max(worst, bound)
        if worst <= enough * most:
            row[FOURTH] = worst
            if worst > most:
                row[CHORDS] = np.ceil(row[CHORDS] * np.sqrt(np.sqrt(worst / most)))
            return True
    return False


# -- points of an arc, in rows of the answer; its parameters are those of parts until the arc is done -------


@uncounted
def _put(row, points, parameters, k):
    points[k, 0], points[k, 1], points[k, 2] = row[POINT], row[POINT + 1], row[POINT + 2]
    parameters[k, 0], parameters[k, 1], parameters[k, 2], parameters[k, 3] = row[X], row[Y], row[S], row[T]


@uncounted
def _put_lanes(arc, count, w, points, parameters, k):
    """The same of the first lanes, from row k on."""
    x, y, s, t = (ACROSS, RUN, PLACES + 1, PLACES) if arc[OVER] == 1.0 else (RUN, ACROSS, PLACES, PLACES + 1)
    for i in range(count):
        for c in range(3):
            points[k + i, c] = w[(SPACE + c) * LANES + i]
        parameters[k + i, 0], parameters[k + i, 1] = w[x * LANES + i], w[y * LANES + i]
        parameters[k + i, 2], parameters[k + i, 3] = w[s * LANES + i], w[t * LANES + i]


@uncounted
def _fill(p, q, arc, plan, count, w, points, parameters, k):
    """Write the points of intervals that follow row k - 1, but for the very last one; how many there are then."""
    total = NONE
    for i in range(count):
        row = plan[i]
        parts = int(row[CHORDS])
        for m in range(1, parts if i == count - 1 else parts + 1):
            x = row[BEGIN] + m / parts * row[LENGTH]
            parameters[k + total, 0], parameters[k + total, 1] = x, _guess(row, x)
            total += 1
    done = NONE
    while done < total:
        some = min(total - done, LANES)
        for i in range(LANES):
            m = k + done + min(i, some - 1)
            w[RUN * LANES + i], w[ACROSS * LANES + i] = parameters[m, 0], parameters[m, 1]
        if not on_arc_lanes(p, q, arc, w):
            break
        _put_lanes(arc, some, w, points, parameters, k + done)
        done += some
    return done


@uncounted
def _move(points, parameters, start, end, by):
    """Rows from start to end by so many further on."""
    for k in range(end - 1, start - 1, -1):
        for c in range(3):
            points[k + by, c] = points[k, c]
        for c in range(4):
            parameters[k + by, c] = parameters[k, c]


@uncounted
def _finish(arc, ranges_p, ranges_q, bounds, centre, points, parameters, start, end):
    """Make rows of an arc what users see: coordinates, and u, v, s, t."""
    r, z = ranges_p[int(arc[ARC_U])], ranges_q[int(arc[ARC_V])]
    for k in range(start, end):
        for c in range(3):
            points[k, c] += centre[c]
        x, y = parameters[k, 0], parameters[k, 1]
        s, t = min(max(parameters[k, 2], 0.0), 1.0), min(max(parameters[k, 3], 0.0), 1.0)
        parameters[k, 0] = ((1.0 - x) * r[0, 0] + x * r[1, 0]) / ((1.0 - x) * r[0, 1] + x * r[1, 1])
        parameters[k, 1] = ((1.0 - y) * z[0, 0] + y * z[1, 0]) / ((1.0 - y) * z[0, 1] + y * z[1, 1])
        parameters[k, 2] = (1.0 - s) * bounds[0, 0] + s * bounds[0, 1]
        parameters[k, 3] = (1.0 - t) * bounds[1, 0] + t * bounds[1, 1]


@uncounted
def _same(points, parameters, k):
    """Whether rows k - 1 and k are one."""
    for c in range(3):
        if points[k - 1, c] != points[k, c]:
            return False
    for c in range(4):
        if parameters[k - 1, c] != parameters[k, c]:
            return False
    return True


# -- stretches of an arc ------------------------------------------------------------------------------------


@uncounted
def _quarters(p, q, arc, here, end, bends_p, bends_q, tolerance, known, split, r):
    """Set three points between two of an arc, and the polynomial that guesses others.

    Returns how many chords are needed there, and how far the curve may leave a single one: by second differences, and
    by what these do not show.
    """
    run, across, first, second = _columns(arc)
    y, z = here[across], end[across]
    begin, length = here[run], end[run] - here[run]
    on_arc(p, q, arc, begin + 0.5 * length, 0.5 * (y + z), r, known[1])
    x = known[1, across]
    fourth = _fourth(
        p, q, arc, bends_p, bends_q, begin + 0.5 * length, x, known[1, first], known[1, second], 0.5 * abs(length), r
    )
    # by the parabola through the middle
    on_arc(p, q, arc, begin + 0.25 * length, 0.75 * x + (0.375 * y - 0.125 * z), r, known[0])
    on_arc(p, q, arc, begin + 0.75 * length, 0.75 * x + (0.375 * z - 0.125 * y), r, known[2])
    _guess_through(split, begin + 0.5 * length, 0.25 * length, y, known[0, across], x, known[2, across], z)
    split[BEGIN], split[LENGTH], split[FOURTH] = begin, length, fourth
    far = abs(known[1, POINT]) + abs(known[1, POINT + 1]) + abs(known[1, POINT + 2])
    seen = 2.0 * (_bends(here, known, end) + ROUNDING * far)
    turn = np.arccos(min(max(_cosine(here, known[1], end), -1.0), 1.0))
    split[CHORDS] = max(np.ceil(min(max(np.sqrt(seen / (AIM * tolerance)), turn / LARGEST_TURN), MOST)), 1.0)
    return seen, 0.125 * BETWEEN * length**4 * fourth


@uncounted
def _intervals(p, q, arc, bends_p, bends_q, tolerance, unseen, known, plan, middles, r):
    """Cut a stretch into intervals: how many, and of how many of the first ones the fourth derivative is bounded."""
    split = plan[LANES]
    need = split[CHORDS]
    if need <= LANES and unseen <= UNSEEN * tolerance * need**4:
        for n in range(PLAN_COLUMNS):
            plan[0, n] = split[n]
        return 1, 1
    count, found = int(min(max(need / EACH, 5.0), LANES)), 0
    for i in range(LANES):
        middle = split[BEGIN] + (min(i, count - 1) + 0.5) / count * split[LENGTH]
        middles[RUN * LANES + i], middles[ACROSS * LANES + i] = middle, _guess(split, middle)
    if on_arc_lanes(p, q, arc, middles):
        _plan(plan, count, split[BEGIN], split[LENGTH], tolerance, middles)
        while found < count and _bound(
            p, q, arc, plan[found], bends_p, bends_q, tolerance, middles, found, known[1], r
        ):
            found += 1
    return count, found


@uncounted
def _write(p, q, arc, plan, found, last, tolerance, w, points, parameters, used):
    """Write the points of intervals, `last` the very last one; how many intervals are good, and rows used then.

    -1 for the former where there are too few rows.
    """
    total = NONE
    for i in range(found):
        total += int(plan[i, CHORDS])
    if used + total > points.shape[0]:
        return -1, used
    done = _fill(p, q, arc, plan, found, w, points, parameters, used)
    _put(last, points, parameters, used + total - 1)
    at, good, again = used - 1, 0, -1
    while good < found:
        parts = int(plan[good, CHORDS])
        if at + parts - used >= done and not (done == total - 1 and good == found - 1):
            break
        off = _leaves(points, at, parts, BETWEEN * (plan[good, LENGTH] / parts) ** 4 * plan[good, FOURTH])
        if off <= KEEP * tolerance:
            at += parts
            good += 1
            continue
        if again == good:
            break
        # shorter chords for this one; the points behind it move on
        more = int(np.ceil(parts * np.sqrt(min(off / (AIM * tolerance), 16.0))))
        if used + total + more - parts > points.shape[0]:
            return -1, used
        _move(points, parameters, at + parts, used + total, more - parts)
        plan[good, CHORDS] = more
        total, done, again = total + more - parts, done + more - parts, good
        if _fill(p, q, arc, plan[good : good + 1], 1, w, points, parameters, at + 1) < more - 1:
            break
    return good, at + 1


@uncounted
def trace(
    p, q, arcs, order, places, tolerance, ranges_p, ranges_q, bounds, centre, bends_p, bends_q, stack, known, plan, r,
    middles, w, points, parameters, rows,
):  # fmt: skip
    """Points (x, y, z) and parameters (u, v, s, t) of arcs, both ends included: rows[k, 0] to rows[k, 1] of arc k.

    order: (n, 3) arcs, whether they are passed from end to start, and whether they begin where the one before ends:
    its last point is their first one then, if the parameters are the same.
    p, q: the forms of `evaluate`; ranges: (parts, 2, 2) projective parameters at both ends of every part; bounds: the
    ranges of s and t; centre: to which coordinates are relative so far; bends: of `derivative_bounds`.
    Returns False where `points` is too short.

    Of points that are g apart along the arc, second differences over g^2 are second derivatives, off by at most
    g^2 / 12 of the fourth derivative; between them, and out to the ends, a line through two of them is off by g^2 more.
    So a chord of length h is off the curve by at most h^2 / 8 times the largest on these lines and BETWEEN g^2 of the
    fourth derivative.  Few chords are looked at in quarters of a stretch, others in the intervals of a longer one.
    """
    used = NONE
    split = plan[LANES]
    for number in range(order.shape[0]):
        k, turned = order[number, 0], order[number, 1] == 1
        arc = arcs[k]
        # stack: ends of stretches, the nearest on top; `here`: where that one begins
        here = known[3]
        enter(arc, places[int(arc[END if turned else START])], here)
        enter(arc, places[int(arc[START if turned else END])], stack[0])
        if used + 1 > points.shape[0]:
            return False
        _put(here, points, parameters, used)
        _finish(arc, ranges_p, ranges_q, bounds, centre, points, parameters, used, used + 1)
        # the parameters of one ruling may differ where a chain is closed
        if order[number, 2] == 0 or not _same(points, parameters, used):
            used += 1
        rows[k, 0] = used - 1
        _put(here, points, parameters, used - 1)
        top = 0
        while top >= 0:
            end = stack[top]
            seen, unseen = _quarters(p, q, arc, here, end, bends_p, bends_q, tolerance, known, split, r)
            room = stack.shape[0] - top
            kept = split[CHORDS] <= FEW
            if kept:
                parts = 1 if split[CHORDS] == 1.0 else 2 if split[CHORDS] == 2.0 else FEW
                while parts < FEW and (seen + unseen / 16.0) / parts**2 > KEEP * tolerance:
                    parts *= 2
                kept = (seen + unseen / 16.0) / parts**2 <= KEEP * tolerance
            if not kept and (room == 1 or abs(split[LENGTH]) < LEAST_CHORD or _is_still(here, known, end, tolerance)):
                parts, kept = 1, True
            if kept:
                if used + parts > points.shape[0]:
                    return False
                for m in range(1, parts):
                    _put(known[FEW * m // parts - 1], points, parameters, used + m - 1)
                used += parts
                _put(end, points, parameters, used - 1)
            elif split[CHORDS] > FEW:
                count, found = _intervals(p, q, arc, bends_p, bends_q, tolerance, unseen, known, plan, middles, r)
                good = NONE
                if found > 0:
                    last = end
                    if found < count:
                        last, x = known[1], plan[found, BEGIN]
                        on_arc(p, q, arc, x, _guess(plan[found], x), r, last)
                    good, used = _write(p, q, arc, plan, found, last, tolerance, w, points, parameters, used)
                    if good < 0:
                        return False
                if 0 < good < count:
                    x = plan[good, BEGIN]
                    on_arc(p, q, arc, x, _guess(plan[good], x), r, here)
                    continue
                kept = good == count
            if kept:
                for n in range(COLUMNS):
                    here[n] = end[n]
                top -= 1
                continue
            # for the fourth derivative, chords are to be shorter by the root of its share; it shrinks with them
            shorter = 4.0
            if split[CHORDS] <= FEW and unseen < 1e300:
                shorter = SHORTER * np.sqrt(np.sqrt(unseen / (UNSEEN * tolerance))) / split[CHORDS]
            parts = int(min(max(np.ceil(shorter), 2.0), min(MOST_PARTS, room)))
            for m in range(1, parts):
                # the first one last, on top
                x = split[BEGIN] + m / parts * split[LENGTH]
                on_arc(p, q, arc, x, _guess(split, x), r, stack[top + parts - m])
            top += parts - 1
        rows[k, 1] = used
        _finish(arc, ranges_p, ranges_q, bounds, centre, points, parameters, rows[k, 0], used)
    return True
