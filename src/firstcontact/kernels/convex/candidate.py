"""A guess of the first contact of two convex pieces from the witnesses of their distance; proved elsewhere."""

from __future__ import annotations

import math

from firstcontact.kernels.convex.separation import placed
from firstcontact.kernels.convex.support import EITHER, FLAT, FORMS, VERTICES, form_value
from firstcontact.kernels.convex.touch_system import local_point, moving_form, newton_step, place_frames, solve
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import (
    ACTIVE,
    AT_TIME,
    AWAY,
    BEGAN,
    COUNT,
    FORM,
    GRADIENTS,
    IN_TIME,
    MATRIX,
    MODE,
    NORMAL,
    OF_A,
    OF_B,
    PART,
    POSE_A,
    RATES_A,
    RATES_B,
    RESULTS,
    RIGHT,
    SIDE_A,
    SIDE_B,
    SIMPLEX,
    UNKNOWN,
    VERTEX,
    WEIGHTS,
)

MOST_STEPS = 16
# Steps after which Newton's method is given up unless the last one was below this part of the size: where it converges
# at all it is near by then, and else a later guess, from nearer, does better.
FIRST_STEPS, NEARBY = 7, 1e-2
# Changes of the active set before a guess is given up.
MOST_CHANGES = 6


@uncounted
def witness(w, count, at):
    """The point of a (at = OF_A) or of b (OF_B) that the simplex found nearest."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(count):
        x += w[WEIGHTS, k] * w[SIMPLEX + k, at]
        y += w[WEIGHTS, k] * w[SIMPLEX + k, at + 1]
        z += w[WEIGHTS, k] * w[SIMPLEX + k, at + 2]
    return x, y, z


@uncounted
def _choose(p, i, x, y, z, slack, c, side, most):
    """Append to the active forms those of largest value at a local point, within `slack` of the largest."""
    count, first = 0, ACTIVE + side * c[COUNT]
    highest = -math.inf
    while count < most:
        best, which = -math.inf, -1
        for k in range(int(p[i, FORMS]), int(p[i, FORMS + 1])):
            value = form_value(p, k, x, y, z)[0]
            for n in range(count):
                if c[first + n] == k:
                    value = -math.inf
            if value > best:
                best, which = value, k
        highest = max(highest, best)
        if which < 0 or best < highest - slack:
            break
        c[first + count] = which
        count += 1
    c[COUNT + side] = count


@uncounted
def _first_multipliers(a, b, w, c, n0, n1, n2):
    """Multipliers with sum l grad a = n and sum m grad b = -n as nearly as may be, of sum 1."""
    total, first = 0.0, 0
    for side in range(2):
        count, sign = c[COUNT + side], 1.0 - 2.0 * side
        for k in range(count):
            form = c[ACTIVE + first + k]
            moving_form(a if side == 0 else b, form, w, side, w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2])
            for r in range(3):
                w[GRADIENTS + k, r] = w[FORM, 1 + r]
        for k in range(count):
            w[RIGHT, k] = 0.0
            for r in range(count):
                w[MATRIX + k, r] = 0.0
            for col in range(3):
                n = n0 if col == 0 else n1 if col == 1 else n2
                w[RIGHT, k] += sign * w[GRADIENTS + k, col] * n
                for r in range(count):
                    w[MATRIX + k, r] += w[GRADIENTS + k, col] * w[GRADIENTS + r, col]
        solve(w, c, count)
        for k in range(count):
            w[UNKNOWN, 4 + first + k] = w[RIGHT, k]
            total += w[RIGHT, k]
        first += count
    if total != 0.0:
        for k in range(first):
            w[UNKNOWN, 4 + k] /= total


@uncounted
def worst_form(p, i, w, side, x, y, z):
    """(value, form): the largest form of a piece at a world point."""
    y0, y1, y2 = local_point(w, side, x, y, z)
    worst, which = -math.inf, -1
    for k in range(int(p[i, FORMS]), int(p[i, FORMS + 1])):
        value = form_value(p, k, y0, y1, y2)[0]
        if value > worst:
            worst, which = value, k
    return worst, which


@uncounted
def _part_near(p, i, w, side, x, y, z):
    """Piece i itself, or, of a union of pieces, the one that a world point is nearest to or deepest in."""
    if p[i, FORMS] < p[i, FORMS + 1]:
        return i
    lowest, which = math.inf, i
    for k in range(i):
        value = worst_form(p, k, w, side, x, y, z)[0]
        if value < lowest:
            lowest, which = value, k
    return which


@uncounted
def choose_parts(a, i, b, j, count, w, c):
    """Into the integers: which pieces of unions the witnesses of the distance lie on (frames: those of its time)."""
    x, y, z = witness(w, count, OF_A)
    c[PART] = _part_near(a, i, w, SIDE_A, x, y, z)
    x, y, z = witness(w, count, OF_B)
    c[PART + 1] = _part_near(b, j, w, SIDE_B, x, y, z)


@uncounted
def _revise(a, i, b, j, w, c, size):
    """Make the active forms fit the solution: 0 they do, 1 changed, -1 cannot."""
    total = c[COUNT] + c[COUNT + 1]
    lowest, which = -1e-9, -1
    for k in range(total):
        if w[UNKNOWN, 4 + k] < lowest and (a if k < c[COUNT] else b)[c[ACTIVE + k], FLAT] != EITHER:
            lowest, which = w[UNKNOWN, 4 + k], k
    if which >= 0:  # a form that would pull: drop it
        side = 0 if which < c[COUNT] else 1
        if c[COUNT + side] == 1:
            return -1
        for k in range(which, total - 1):
            c[ACTIVE + k] = c[ACTIVE + k + 1]
            w[UNKNOWN, 4 + k] = w[UNKNOWN, 5 + k]
        c[COUNT + side] -= 1
        return 1
    worst, form, side = 1e-9 * size, -1, 0
    for s in range(2):
        value, k = worst_form(a if s == 0 else b, i if s == 0 else j, w, s, w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2])
        if value > worst:
            worst, form, side = value, k, s
    if form < 0:
        return 0
    if total == 4:
        return -1
    at = c[COUNT] + side * c[COUNT + 1]  # a form that the point violates: take it in
    for k in range(total, at, -1):
        c[ACTIVE + k] = c[ACTIVE + k - 1]
        w[UNKNOWN, 4 + k] = w[UNKNOWN, 3 + k]
    c[ACTIVE + at], w[UNKNOWN, 4 + at] = form, 0.0
    c[COUNT + side] += 1
    return 1


@uncounted
def guess_by_forms(a, i, ma, b, j, mb, t, first, last, count, slack, n0, n1, n2, size, w, c):
    """Newton steps taken, negative without a guess; else w[UNKNOWN] is X, t, multipliers and the frames are those at t.

    slack: forms are active at first that are this part of the distance from the witnesses.  None (0) where these are
    those that the last guess began with, as c[BEGAN] tells.
    """
    if not place_frames(ma, mb, t, w):
        return -1
    distance = 0.0
    for k in range(3):
        w[UNKNOWN, k] = 0.0
    for side in range(2):
        x, y, z = witness(w, count, OF_A + OF_A * side)
        w[UNKNOWN, 0] += 0.5 * x
        w[UNKNOWN, 1] += 0.5 * y
        w[UNKNOWN, 2] += 0.5 * z
        distance += (x * n0 + y * n1 + z * n2) * (2.0 * side - 1.0)
    w[UNKNOWN, 3] = t
    slack = slack * abs(distance) + 1e-9 * size
    for side in range(2):
        x, y, z = witness(w, count, OF_A + OF_A * side)
        y0, y1, y2 = local_point(w, side, x, y, z)
        most = min(3, 4 - side * c[COUNT])
        _choose(a if side == 0 else b, i if side == 0 else j, y0, y1, y2, slack, c, side, most)
    began = c[COUNT]
    for k in range(c[COUNT] + c[COUNT + 1]):
        began = (began << 12) + c[ACTIVE + k]
    if began == c[BEGAN]:
        return 0
    c[BEGAN] = began
    _first_multipliers(a, b, w, c, n0, n1, n2)
    taken, span = 0, last - first
    for _ in range(MOST_CHANGES):
        moved = math.inf
        for step in range(MOST_STEPS):
            before = moved
            taken += 1
            moved = newton_step(a, b, w, c, span, size, IN_TIME)
            if moved < 0.0 or not (first - span <= w[UNKNOWN, 3] <= last + span):
                return -taken
            if not place_frames(ma, mb, w[UNKNOWN, 3], w):
                return -taken
            if before <= 1e-10 * size:  # one step more than shows convergence costs little
                break
            if step >= FIRST_STEPS and moved > NEARBY * size:
                return -taken
        if not moved <= 1e-10 * size:
            return -taken
        change = _revise(a, i, b, j, w, c, size)
        if change <= 0:
            return taken if change == 0 else -taken
    return -taken


@uncounted
def contact_normal(a, w, c):
    """Unit normal of a at the solution, from a to b."""
    n0, n1, n2 = 0.0, 0.0, 0.0
    for k in range(c[COUNT]):
        moving_form(a, c[ACTIVE + k], w, SIDE_A, w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2])
        n0 += w[UNKNOWN, 4 + k] * w[FORM, 1]
        n1 += w[UNKNOWN, 4 + k] * w[FORM, 2]
        n2 += w[UNKNOWN, 4 + k] * w[FORM, 3]
    length = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return n0 / length, n1 / length, n2 / length


@uncounted
def normal_at(a, ma, b, mb, t, size, w, c):
    """Unit normal from a to b at a time t near that of the guess by forms, where the bodies are a little apart.

    Edges and rulings that touch stay square to it: along the normal of another time their ends would overlap, unless
    both bodies only shift.
    """
    x, y, z = w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2]
    n0, n1, n2 = contact_normal(a, w, c)
    turning = 0.0
    for k in range(9):
        turning += abs(w[RATES_A, k]) + abs(w[RATES_B, k])
    if turning == 0.0:
        return n0, n1, n2
    w[RESULTS, NORMAL], w[RESULTS, NORMAL + 1], w[RESULTS, NORMAL + 2], w[UNKNOWN, AWAY] = n0, n1, n2, 0.0
    if place_frames(ma, mb, t, w):
        for _ in range(3):
            newton_step(a, b, w, c, 1.0, size, AT_TIME)
    n0, n1, n2 = contact_normal(a, w, c)
    w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2] = x, y, z
    return n0, n1, n2


@uncounted
def vertex_normal_at(a, ma, b, mb, t, w, c):
    """As `normal_at`, for the guess by a vertex."""
    side = c[MODE] - 1
    if place_frames(ma, mb, t, w):
        p, far = (a if side == 0 else b), SIDE_B - side
        x, y, z = placed(w, POSE_A + side, p[c[VERTEX], 0], p[c[VERTEX], 1], p[c[VERTEX], 2])
        moving_form(b if side == 0 else a, c[ACTIVE], w, far, x, y, z)
    length = math.sqrt(w[FORM, 1] ** 2 + w[FORM, 2] ** 2 + w[FORM, 3] ** 2)
    sign = (2.0 * side - 1.0) / length if length > 0.0 else 0.0
    return sign * w[FORM, 1], sign * w[FORM, 2], sign * w[FORM, 3]


@uncounted
def guess_by_vertex(a, i, ma, b, j, mb, t, first, last, count, side, w, c):
    """Newton steps taken, negative without a guess: a vertex of a `side` near its witness meets a form of the other.

    Leaves the point and t in w[UNKNOWN], vertex and form in the integers.
    """
    p, q = (a, b) if side == 0 else (b, a)
    i, j = (i, j) if side == 0 else (j, i)
    if not place_frames(ma, mb, t, w):
        return -1
    x, y, z = witness(w, count, OF_A + OF_A * side)
    near, vertex = math.inf, -1
    for k in range(int(p[i, VERTICES]), int(p[i, VERTICES + 1])):
        w0, w1, w2 = placed(w, POSE_A + side, p[k, 0], p[k, 1], p[k, 2])
        d = abs(w0 - x) + abs(w1 - y) + abs(w2 - z)
        if d < near:
            near, vertex = d, k
    if vertex < 0:
        return -1
    far = SIDE_B - side
    x, y, z = placed(w, POSE_A + side, p[vertex, 0], p[vertex, 1], p[vertex, 2])
    _, form = worst_form(q, j, w, far, x, y, z)
    span = last - first
    for step in range(MOST_STEPS):
        moving_form(q, form, w, far, x, y, z)
        u0, u1, u2 = placed(w, RATES_A + side, p[vertex, 0], p[vertex, 1], p[vertex, 2])
        slope = w[FORM, 4] + w[FORM, 1] * u0 + w[FORM, 2] * u1 + w[FORM, 3] * u2
        change = -w[FORM, 0] / slope if slope != 0.0 else math.inf
        t += change
        if not (first - span <= t <= last + span) or not place_frames(ma, mb, t, w):
            return -1 - step
        x, y, z = placed(w, POSE_A + side, p[vertex, 0], p[vertex, 1], p[vertex, 2])
        if abs(change) <= 4e-16 * span:
            break
    w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2], w[UNKNOWN, 3] = x, y, z, t
    c[VERTEX], c[ACTIVE] = vertex, form
    return step + 1
