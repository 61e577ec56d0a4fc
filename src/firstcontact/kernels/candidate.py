"""A guess of the first contact of two convex pieces from the witnesses of their distance; proved elsewhere."""

from __future__ import annotations

import math

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.poses import pose_at, velocity_at
from firstcontact.kernels.separation import placed
from firstcontact.kernels.support import form_value
from firstcontact.kernels.touch_system import (
    invert,
    local_point,
    moving_form,
    newton_step,
    place_frames,
    solve,
)

# Which system: faces and edges by their forms, a vertex of a against a face of b, a vertex of b against a face of a.
FORMS, VERTEX_A, VERTEX_B = 0, 1, 2
MOST_STEPS = 16
# Changes of the active set before a guess is given up.
MOST_CHANGES = 6


@kernel
def _choose(p, i, x, y, z, slack, chosen, first, most):
    """The forms of largest value at a local point, those within `slack` of the largest; their number, 1 to most."""
    count = 0
    highest = -1e300
    for k in range(p.ranges[i, 6], p.ranges[i, 7]):
        highest = max(highest, form_value(p.leaves, k, x, y, z)[0])
    bound = math.inf
    while count < most:
        best, which = -math.inf, -1
        for k in range(p.ranges[i, 6], p.ranges[i, 7]):
            value = form_value(p.leaves, k, x, y, z)[0]
            taken = False
            for c in range(count):
                taken = taken or chosen[first + c] == k
            if not taken and value > best and value <= bound:
                best, which = value, k
        if which < 0 or (count > 0 and best < highest - slack):
            break
        chosen[first + count] = which
        count += 1
    return count


@kernel
def _first_multipliers(a, b, active, counts, frames, unknown, n0, n1, n2, forms, matrix, right, columns, gradients):
    """Multipliers with sum l grad a = n and sum m grad b = -n as nearly as may be, of sum 1."""
    total = 0.0
    for side in range(2):
        first, count, sign = (0, counts[0], 1.0) if side == 0 else (counts[0], counts[1], -1.0)
        leaves = a.leaves if side == 0 else b.leaves
        for k in range(count):
            x, y, z = unknown[0], unknown[1], unknown[2]
            moving_form(
                leaves, active[first + k], frames[side], frames[2 + side], frames[4 + side], x, y, z, forms
            )
            gradients[k, 0], gradients[k, 1], gradients[k, 2] = forms[1], forms[2], forms[3]
        for k in range(count):
            right[k] = sign * (gradients[k, 0] * n0 + gradients[k, 1] * n1 + gradients[k, 2] * n2)
            for c in range(count):
                matrix[k, c] = 0.0
                for r in range(3):
                    matrix[k, c] += gradients[k, r] * gradients[c, r]
        solve(matrix, right, count, columns)
        for k in range(count):
            unknown[4 + first + k] = right[k]
            total += right[k]
    if total != 0.0:
        for k in range(counts[0] + counts[1]):
            unknown[4 + k] /= total


@kernel
def _drop(active, counts, unknown, k):
    for c in range(k, counts[0] + counts[1] - 1):
        active[c] = active[c + 1]
        unknown[4 + c] = unknown[5 + c]
    counts[0 if k < counts[0] else 1] -= 1


@kernel
def _add(active, counts, unknown, side, form):
    at = counts[0] if side == 0 else counts[0] + counts[1]
    for c in range(counts[0] + counts[1], at, -1):
        active[c] = active[c - 1]
        unknown[4 + c] = unknown[3 + c]
    active[at], unknown[4 + at] = form, 0.0
    counts[side] += 1


@kernel
def _worst_violation(p, i, pose, inverse, x, y, z):
    y0, y1, y2 = local_point(pose, inverse, x, y, z)
    worst, which = -math.inf, -1
    for k in range(p.ranges[i, 6], p.ranges[i, 7]):
        value = form_value(p.leaves, k, y0, y1, y2)[0]
        if value > worst:
            worst, which = value, k
    return worst, which


@kernel
def _revise(a, i, b, j, active, counts, frames, unknown, size):
    """Make the active set fit the solution: 0 it does, 1 changed, -1 cannot."""
    lowest, which = -1e-9, -1
    for k in range(counts[0] + counts[1]):
        if unknown[4 + k] < lowest:
            lowest, which = unknown[4 + k], k
    if which >= 0:
        if counts[0 if which < counts[0] else 1] == 1:
            return -1
        _drop(active, counts, unknown, which)
        return 1
    x, y, z = unknown[0], unknown[1], unknown[2]
    worst_a, form_a = _worst_violation(a, i, frames[0], frames[4], x, y, z)
    worst_b, form_b = _worst_violation(b, j, frames[1], frames[5], x, y, z)
    if max(worst_a, worst_b) <= 1e-9 * size:
        return 0
    if counts[0] + counts[1] == 4:
        return -1
    if worst_a >= worst_b:
        _add(active, counts, unknown, 0, form_a)
    else:
        _add(active, counts, unknown, 1, form_b)
    return 1


@kernel
def guess_by_forms(
    a, i, head_a, coef_a, b, j, head_b, coef_b, t, first, last, rows, weights, count, n0, n1, n2, size,
    active, counts, frames, unknown, forms, matrix, right, columns, gradients,
):  # fmt: skip
    """Newton steps taken (negative: no guess); on success unknown = X, t, multipliers, `frames` are those at t."""
    if not place_frames(head_a, coef_a, head_b, coef_b, t, frames):
        return -1
    x0, x1, x2, z0, z1, z2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        x0 += weights[k] * rows[k, 3]
        x1 += weights[k] * rows[k, 4]
        x2 += weights[k] * rows[k, 5]
        z0 += weights[k] * rows[k, 6]
        z1 += weights[k] * rows[k, 7]
        z2 += weights[k] * rows[k, 8]
    distance = math.sqrt((x0 - z0) ** 2 + (x1 - z1) ** 2 + (x2 - z2) ** 2)
    slack = 0.05 * distance + 1e-9 * size
    y0, y1, y2 = local_point(frames[0], frames[4], x0, x1, x2)
    counts[0] = _choose(a, i, y0, y1, y2, slack, active, 0, 3)
    y0, y1, y2 = local_point(frames[1], frames[5], z0, z1, z2)
    counts[1] = _choose(b, j, y0, y1, y2, slack, active, counts[0], min(3, 4 - counts[0]))
    unknown[0], unknown[1], unknown[2], unknown[3] = 0.5 * (x0 + z0), 0.5 * (x1 + z1), 0.5 * (x2 + z2), t
    _first_multipliers(
        a, b, active, counts, frames, unknown, n0, n1, n2, forms, matrix, right, columns, gradients
    )
    taken, span = 0, last - first
    for _ in range(MOST_CHANGES):
        converged = False
        for _ in range(MOST_STEPS):
            taken += 1
            moved = newton_step(a, b, active, counts, frames, unknown, forms, matrix, right, columns, span)
            if moved < 0.0 or not (first - span <= unknown[3] <= last + span):
                return -taken
            if not place_frames(head_a, coef_a, head_b, coef_b, unknown[3], frames):
                return -taken
            if moved <= 1e-10 * size:
                converged = True
                break
        if not converged:
            return -taken
        change = _revise(a, i, b, j, active, counts, frames, unknown, size)
        if change < 0:
            return -taken
        if change == 0:
            newton_step(a, b, active, counts, frames, unknown, forms, matrix, right, columns, span)
            place_frames(head_a, coef_a, head_b, coef_b, unknown[3], frames)
            return taken + 1
    return -taken


@kernel
def contact_normal(a, active, counts, frames, unknown, forms):
    """Unit normal of a at the solution, from a to b."""
    n0, n1, n2 = 0.0, 0.0, 0.0
    for k in range(counts[0]):
        x, y, z = unknown[0], unknown[1], unknown[2]
        moving_form(a.leaves, active[k], frames[0], frames[2], frames[4], x, y, z, forms)
        n0 += unknown[4 + k] * forms[1]
        n1 += unknown[4 + k] * forms[2]
        n2 += unknown[4 + k] * forms[3]
    length = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return n0 / length, n1 / length, n2 / length


@kernel
def guess_by_vertex(
    p, i, head_p, coef_p, q, j, head_q, coef_q, t, first, last, x0, x1, x2, size, pose, rates, far, far_rates,
    inverse, forms,
):  # fmt: skip
    """(steps, vertex, form, t, n): the vertex of piece i nearest (x0, x1, x2) meets the nearest form of piece j.

    steps negative: no guess.  n: unit gradient of the form there, out of q.
    """
    pose_at(head_p, coef_p, t, pose)
    near, vertex = math.inf, -1
    for k in range(p.ranges[i, 0], p.ranges[i, 1]):
        w0, w1, w2 = placed(pose, p.vertices[k, 0], p.vertices[k, 1], p.vertices[k, 2])
        d = abs(w0 - x0) + abs(w1 - x1) + abs(w2 - x2)
        if d < near:
            near, vertex = d, k
    if vertex < 0:
        return -1, -1, -1, t, 0.0, 0.0, 0.0
    v0, v1, v2 = p.vertices[vertex, 0], p.vertices[vertex, 1], p.vertices[vertex, 2]
    form = -1
    for step in range(MOST_STEPS):
        pose_at(head_p, coef_p, t, pose)
        velocity_at(head_p, coef_p, t, rates)
        pose_at(head_q, coef_q, t, far)
        velocity_at(head_q, coef_q, t, far_rates)
        if not invert(far, inverse):
            return -1, vertex, form, t, 0.0, 0.0, 0.0
        w0, w1, w2 = placed(pose, v0, v1, v2)
        if step == 0:
            _, form = _worst_violation(q, j, far, inverse, w0, w1, w2)
        moving_form(q.leaves, form, far, far_rates, inverse, w0, w1, w2, forms)
        u0, u1, u2 = placed(rates, v0, v1, v2)
        slope = forms[4] + forms[1] * u0 + forms[2] * u1 + forms[3] * u2
        if slope == 0.0:
            return -1, vertex, form, t, 0.0, 0.0, 0.0
        change = -forms[0] / slope
        t += change
        if not (first - (last - first) <= t <= last + (last - first)):
            return -1, vertex, form, t, 0.0, 0.0, 0.0
        if abs(change) <= 4e-16 * (last - first):
            break
    length = math.sqrt(forms[1] * forms[1] + forms[2] * forms[2] + forms[3] * forms[3])
    if length == 0.0:
        return -1, vertex, form, t, 0.0, 0.0, 0.0
    return step + 1, vertex, form, t, forms[1] / length, forms[2] / length, forms[3] / length
