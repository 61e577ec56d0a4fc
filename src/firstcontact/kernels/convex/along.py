"""A touch along something flat: from any place of it, as its end, to one where no other surface is near.

A cylinder that lies on a plane touches along a ruling, an edge along a face, a face on a face.  Newton's method ends at
some point of that, often at its border, where bodies that go on share no inner point close by.  Nothing is proved here.
"""

from __future__ import annotations

import math

from firstcontact.kernels.convex.advancement import BY_FORMS, directed, size_of, way_between
from firstcontact.kernels.convex.candidate import choose_parts, contact_normal, guess_by_forms
from firstcontact.kernels.convex.shared_point import deepen
from firstcontact.kernels.convex.support import FORMS
from firstcontact.kernels.convex.touch_system import local_point, moving_form, place_frames
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import (
    ACTIVE,
    BEGAN,
    COUNT,
    FORM,
    INVERSE_A,
    MODE,
    NEWTON,
    NORMAL,
    PART,
    POINT,
    RESULTS,
    SIDE_B,
    TIME,
    UNKNOWN,
)

# Multipliers, of sum 1, below which a form takes no part in the touch: the point is at its surface by chance.
IDLE = 1e-6
# Squares of sines, and bends in units of the body's size, below which directions count as flat.
FLATNESS = 1e-12
# Part of the size within which surfaces count as near, and by which a solution may be beyond one.
NEAR = 1e-8


@uncounted
def _is_idle(w, c, side, form):
    """Whether a form takes no part: neither active, nor with a multiplier that counts."""
    first = ACTIVE + side * c[COUNT]
    for k in range(c[COUNT + side]):
        if c[first + k] == form:
            return w[UNKNOWN, 4 + first - ACTIVE + k] < IDLE
    return True


@uncounted
def _bend(p, k, w, side, d0, d1, d2):
    """Half the second derivative of form k along a direction of the world."""
    inverse = INVERSE_A + side
    u = w[inverse, 0] * d0 + w[inverse, 1] * d1 + w[inverse, 2] * d2
    v = w[inverse, 3] * d0 + w[inverse, 4] * d1 + w[inverse, 5] * d2
    s = w[inverse, 6] * d0 + w[inverse, 7] * d1 + w[inverse, 8] * d2
    return p[k, 0] * u * u + p[k, 1] * v * v + p[k, 2] * s * s + p[k, 3] * u * v + p[k, 4] * u * s + p[k, 5] * v * s


@uncounted
def _tangents(n0, n1, n2):
    """Two unit directions across a unit one, and each other."""
    if abs(n0) <= abs(n1) and abs(n0) <= abs(n2):
        length = math.sqrt(n1 * n1 + n2 * n2)
        d0, d1, d2 = 0.0, n2 / length, -n1 / length
    elif abs(n1) <= abs(n2):
        length = math.sqrt(n0 * n0 + n2 * n2)
        d0, d1, d2 = -n2 / length, 0.0, n0 / length
    else:
        length = math.sqrt(n0 * n0 + n1 * n1)
        d0, d1, d2 = n1 / length, -n0 / length, 0.0
    return d0, d1, d2, n1 * d2 - n2 * d1, n2 * d0 - n0 * d2, n0 * d1 - n1 * d0


@uncounted
def _flat_ways(a, b, w, c, size):
    """(how many directions are flat, two of them across each other): along which no surface that takes part leaves."""
    n0, n1, n2 = contact_normal(a, w, c)
    if n0 == 0.0 and n1 == 0.0 and n2 == 0.0:
        return 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    d0, d1, d2, e0, e1, e2 = _tangents(n0, n1, n2)
    # the quadratic form of slopes squared and bends, in the coordinates of the two directions
    xx, xy, yy = 0.0, 0.0, 0.0
    for k in range(c[COUNT] + c[COUNT + 1]):
        m = w[UNKNOWN, 4 + k]
        if m < IDLE:
            continue
        side = 0 if k < c[COUNT] else 1
        p, form = (a if side == 0 else b), c[ACTIVE + k]
        moving_form(p, form, w, side, w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2])
        square = w[FORM, 1] ** 2 + w[FORM, 2] ** 2 + w[FORM, 3] ** 2
        if square == 0.0:
            return 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        along_d = w[FORM, 1] * d0 + w[FORM, 2] * d1 + w[FORM, 3] * d2
        along_e = w[FORM, 1] * e0 + w[FORM, 2] * e1 + w[FORM, 3] * e2
        bend_d, bend_e = _bend(p, form, w, side, d0, d1, d2), _bend(p, form, w, side, e0, e1, e2)
        both = _bend(p, form, w, side, d0 + e0, d1 + e1, d2 + e2)
        xx += along_d * along_d / square + m * size * bend_d
        yy += along_e * along_e / square + m * size * bend_e
        xy += along_d * along_e / square + 0.5 * m * size * (both - bend_d - bend_e)
    root = math.sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    least = 0.5 * (xx + yy) - root
    if least + 2.0 * root <= FLATNESS:
        return 2, d0, d1, d2, e0, e1, e2
    if least > FLATNESS:
        return 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s, t = (xy, least - xx) if xx > yy else (least - yy, xy)  # an eigenvector
    length = math.sqrt(s * s + t * t)
    s, t = s / length, t / length
    return 1, s * d0 + t * e0, s * d1 + t * e1, s * d2 + t * e2, 0.0, 0.0, 0.0


@uncounted
def _to_middle(a, i, b, j, w, c, d0, d1, d2, size):
    """Move the point along a direction to the middle of what all idle forms leave of it; whether it has ends."""
    x, y, z = w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2]
    lo, hi, beyond = -math.inf, math.inf, NEAR * size
    for side in range(2):
        p, piece = (a, i) if side == 0 else (b, j)
        for k in range(int(p[piece, FORMS]), int(p[piece, FORMS + 1])):
            if not _is_idle(w, c, side, k):
                continue
            moving_form(p, k, w, side, x, y, z)
            value = w[FORM, 0] - beyond
            slope = w[FORM, 1] * d0 + w[FORM, 2] * d1 + w[FORM, 3] * d2
            bend = _bend(p, k, w, side, d0, d1, d2)
            square = slope * slope - 4.0 * bend * value
            if abs(bend) * size <= FLATNESS:
                if slope > FLATNESS:
                    hi = min(hi, -value / slope)
                elif slope < -FLATNESS:
                    lo = max(lo, -value / slope)
            elif square > 0.0:
                q = -0.5 * (slope + math.copysign(math.sqrt(square), slope))
                r, s = q / bend, (value / q if q != 0.0 else 0.0)
                r, s = min(r, s), max(r, s)
                if bend > 0.0:  # inside between the two, else beyond them
                    lo, hi = max(lo, r), min(hi, s)
                elif r >= 0.0:
                    hi = min(hi, r)
                elif s <= 0.0:
                    lo = max(lo, s)
    if not (math.isfinite(lo) and math.isfinite(hi) and hi > lo):
        return False
    step = 0.5 * (lo + hi)
    w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2] = x + step * d0, y + step * d1, z + step * d2
    return True


@uncounted
def _inward(a, i, b, j, w, c, d0, d1, d2, e0, e1, e2, size):
    """The flat direction that leads away from the idle surfaces that are near, (0, 0, 0) where none is."""
    u0, u1, u2 = 0.0, 0.0, 0.0
    for side in range(2):
        p, piece = (a, i) if side == 0 else (b, j)
        for k in range(int(p[piece, FORMS]), int(p[piece, FORMS + 1])):
            if not _is_idle(w, c, side, k):
                continue
            moving_form(p, k, w, side, w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2])
            if w[FORM, 0] > -NEAR * size:
                u0, u1, u2 = u0 - w[FORM, 1], u1 - w[FORM, 2], u2 - w[FORM, 3]
    s, t = u0 * d0 + u1 * d1 + u2 * d2, u0 * e0 + u1 * e1 + u2 * e2
    length = math.sqrt(s * s + t * t)
    if not length > NEAR:
        return 0.0, 0.0, 0.0
    s, t = s / length, t / length
    return s * d0 + t * e0, s * d1 + t * e1, s * d2 + t * e2


@uncounted
def _keep_active(w, c):
    """Take the idle ones out of the active forms."""
    kept, at_a = 0, 0
    for k in range(c[COUNT] + c[COUNT + 1]):
        if w[UNKNOWN, 4 + k] >= IDLE:
            c[ACTIVE + kept], w[UNKNOWN, 4 + kept] = c[ACTIVE + k], w[UNKNOWN, 4 + k]
            kept += 1
            at_a += 1 if k < c[COUNT] else 0
    c[COUNT], c[COUNT + 1] = at_a, kept - at_a


@uncounted
def _to_inner_place(a, i, b, j, size, w, c):
    """Where the touch goes on from the guess by forms, w[UNKNOWN] becomes a place away from its ends, and only what
    touches there is active.  Frames: those near the time of contact.
    """
    count, d0, d1, d2, e0, e1, e2 = _flat_ways(a, b, w, c, size)
    if count == 0:
        return
    x, y, z = w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2]
    moved = True
    if count == 2:
        u0, u1, u2 = _inward(a, i, b, j, w, c, d0, d1, d2, e0, e1, e2, size)
        if u0 != 0.0 or u1 != 0.0 or u2 != 0.0:
            moved = _to_middle(a, i, b, j, w, c, u0, u1, u2, size)
        moved = moved and _to_middle(a, i, b, j, w, c, d0, d1, d2, size)
        moved = moved and _to_middle(a, i, b, j, w, c, e0, e1, e2, size)
    if moved and _to_middle(a, i, b, j, w, c, d0, d1, d2, size):
        _keep_active(w, c)
    else:
        w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2] = x, y, z


@uncounted
def _rate(a, b, w, c):
    """Of the sum of active forms times multipliers, by time."""
    rate = 0.0
    for k in range(c[COUNT] + c[COUNT + 1]):
        side = 0 if k < c[COUNT] else 1
        moving_form(a if side == 0 else b, c[ACTIVE + k], w, side, w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2])
        rate += w[UNKNOWN, 4 + k] * w[FORM, 4]
    return rate


@uncounted
def _told(a, i, b, j, size, w, c):
    """The rate at a place in the middle of the touch that a guess by forms found, with what `place_of_touch` tells."""
    _to_inner_place(a, i, b, j, size, w, c)
    n0, n1, n2 = contact_normal(a, w, c)
    w[RESULTS, NORMAL], w[RESULTS, NORMAL + 1], w[RESULTS, NORMAL + 2] = n0, n1, n2
    w[RESULTS, TIME] = w[UNKNOWN, 3]
    for k in range(3):
        w[RESULTS, POINT + k] = w[UNKNOWN, k]
    return _rate(a, b, w, c)


@uncounted
def place_of_touch(a, i, ma, b, j, mb, first, last, t, width, w, c):
    """The rate at which pieces that are apart until t seem to come to touch within `width` after it, 0 if they do not:
    that of the sum of active forms times multipliers.

    Then time, normal and place of the touch are among the results, w[UNKNOWN] and the integers are as after a guess by
    forms, and so are the frames.  The guess starts from earlier times, at which the pieces are so far apart that
    doubles tell their nearest points.
    """
    size = size_of(a, i, b, j)
    back = 1e-3 * (last - first)
    for _ in range(3):
        s = max(t - back, first)
        back *= 1e-3
        n0, n1, n2 = way_between(ma, mb, s, w)
        _, n0, n1, n2, count, gap = directed(a, i, ma, b, j, mb, s, n0, n1, n2, w, c)
        if gap <= 0.0 or not place_frames(ma, mb, s, w):
            continue
        choose_parts(a, i, b, j, count, w, c)
        p, q = c[PART], c[PART + 1]
        c[BEGAN] = -1
        for attempt in range(2):
            slack = 0.05 if attempt == 0 else 0.5
            taken = guess_by_forms(a, p, ma, b, q, mb, s, first, last, count, slack, n0, n1, n2, size, w, c)
            c[NEWTON] += abs(taken)
            if taken <= 0 or not t - width <= w[UNKNOWN, 3] <= t + width:
                continue
            c[MODE] = BY_FORMS
            return _told(a, p, b, q, size, w, c)
    return 0.0


@uncounted
def inner_point(a, ma, b, mb, t, w, c):
    """(whether the poses are regular, point in the frame of b): equally deep behind all active forms at t, to first
    order.  Leaves the frames at t."""
    if not place_frames(ma, mb, t, w):
        return False, 0.0, 0.0, 0.0
    x, y, z = deepen(a, b, w, c)
    x, y, z = local_point(w, SIDE_B, x, y, z)
    return True, x, y, z
