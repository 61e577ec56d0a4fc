"""Certified advancement: the first contact of two moving convex pieces, every interval left behind proved free.

For a fixed direction n the gap g(t) = min n.(y - x) over x in a, y in b is a minimum of functions whose second
derivatives by time are at most K.  Each stays above its chord less K s (1 - s) h^2 / 2, and chords of minima are
below minima of chords, so
    sqrt(g(t0)) + sqrt(g(t1)) > sqrt(K / 2) (t1 - t0),  g(t0), g(t1) > 0
proves g > 0 on all of [t0, t1]: two support values and a bound of accelerations, no bound of speeds (re-derived; for
translations K = 0).  With the normal of the contact itself the last interval reaches down to rounding errors at once.
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.candidate import (
    FORMS,
    VERTEX_A,
    VERTEX_B,
    contact_normal,
    guess_by_forms,
    guess_by_vertex,
)
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.poses import ROOM, pose_at
from firstcontact.kernels.separation import bending, gap, separating_direction
from firstcontact.kernels.shared_point import deepen, proves_shared
from firstcontact.kernels.touch_system import place_frames

# Outcomes: proved free to the end, contact enclosed, shared point at the start; undecided at the start, below the
# resolution of doubles, work spent.
FREE, CONTACT, INITIAL, AT_START, PRECISION, SPENT = range(6)
# Slots of the results: free until, time, lo, hi, point, normal (from a to b), gap at free until.
FREE_UNTIL, TIME, LO, HI, POINT, NORMAL, GAP = 0, 1, 2, 3, 4, 7, 10
# Slots of the counters: steps, Newton steps, gaps evaluated, mode of the contact, vertex, counts of active forms, the forms.
STEPS, NEWTON, GAPS, MODE, VERTEX, COUNT_A, COUNT_B, ACTIVE = 0, 1, 2, 3, 4, 5, 6, 7


@kernel
def _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, t, n0, n1, n2, pose_a, pose_b):
    pose_at(head_a, coef_a, t, pose_a)
    pose_at(head_b, coef_b, t, pose_b)
    return gap(a, i, pose_a, b, j, pose_b, n0, n1, n2)


@kernel
def _longest(a, i, head_a, coef_a, b, j, head_b, coef_b, t0, t1, g0, g1, n0, n1, n2, middle, radius):
    """The length for which g0 and g1 would prove what lies between; that proves [t0, t1] where it exceeds t1 - t0."""
    bend = bending(a, i, head_a, coef_a, b, j, head_b, coef_b, t0, t1, n0, n1, n2, middle, radius)
    roots = (math.sqrt(g0) + math.sqrt(g1)) * (1.0 - 1e-12)
    return roots / math.sqrt(0.5 * bend) if bend > 0.0 else math.inf


@kernel
def stride(
    a, i, head_a, coef_a, b, j, head_b, coef_b, t, g, end, n0, n1, n2, pose_a, pose_b, middle, radius, counters
):
    """(t1, g1) with [t, t1] proved free by the direction n, t1 = end where possible; (t, g) where nothing is proved.

    g > 0: the gap at t.
    """
    s = end
    gs = _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, s, n0, n1, n2, pose_a, pose_b)
    counters[GAPS] += 1
    if gs <= 0.0:
        # Invariant: the gap is positive at lo and not at hi; ends near the crossing, on the positive side.
        lo, hi, g_lo, g_hi, side = t, end, g, gs, 0
        for _ in range(30):
            share = g_lo / (g_lo - g_hi)
            s = lo + (hi - lo) * min(max(share * 0.97, 0.01), 0.99)
            if not lo < s < hi:
                break
            gs = _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, s, n0, n1, n2, pose_a, pose_b)
            counters[GAPS] += 1
            if gs > 0.0:
                lo, g_lo = s, gs
                if gs <= 0.1 * g:
                    break
                if side == 1:
                    g_hi *= 0.5
                side = 1
            else:
                hi, g_hi = s, gs
                if side == 2:
                    g_lo *= 0.5
                side = 2
        s = lo
        if s <= t:
            return t, g
        gs = _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, s, n0, n1, n2, pose_a, pose_b)
    for _ in range(40):
        if gs > 0.0:
            length = _longest(
                a, i, head_a, coef_a, b, j, head_b, coef_b, t, s, g, gs, n0, n1, n2, middle, radius
            )
            if length > s - t:
                return s, gs
            length = min(0.9 * length, 0.7 * (s - t))
        else:
            length = 0.5 * (s - t)
        s = t + length
        if s <= t:
            return t, g
        gs = _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, s, n0, n1, n2, pose_a, pose_b)
        counters[GAPS] += 1
    return t, g


@kernel
def advance_pieces(
    a, i, head_a, coef_a, b, j, head_b, coef_b, first, last, inner, width, budget, results, counters
):
    """One of the outcomes above for the pieces i of a and j of b over [first, last].

    inner <= last: the latest time at which a contact may be claimed; width: of its interval; budget: strides.
    results (11,) float64, counters (16,) int64: slots above; counters add up.
    """
    rows, weights = np.zeros((4, 9)), np.zeros(4)
    frames = np.zeros((6, ROOM))
    pose_a, pose_b, middle, radius = np.zeros(ROOM), np.zeros(ROOM), np.zeros(12), np.zeros(12)
    active, counts, columns = np.zeros(8, np.int64), np.zeros(2, np.int64), np.zeros(12, np.int64)
    unknown, forms, right = np.zeros(12), np.zeros(8), np.zeros(12)
    matrix, gradients = np.zeros((12, 12)), np.zeros((8, 4))
    size = 0.0
    for k in range(3):
        size = max(size, a.boxes[i, 3 + k], b.boxes[j, 3 + k])
    t = first
    pose_at(head_a, coef_a, t, pose_a)
    pose_at(head_b, coef_b, t, pose_b)
    n0 = pose_b[9] - pose_a[9]
    n1, n2 = pose_b[10] - pose_a[10], pose_b[11] - pose_a[11]
    if n0 == 0.0 and n1 == 0.0 and n2 == 0.0:
        n0 = 1.0
    distance, n0, n1, n2, count = separating_direction(a, i, pose_a, b, j, pose_b, n0, n1, n2, rows, weights)
    g = gap(a, i, pose_a, b, j, pose_b, n0, n1, n2)
    results[FREE_UNTIL] = first
    if g <= 0.0:
        return _at_start(a, i, b, j, head_a, coef_a, head_b, coef_b, first, frames, rows, weights, count, results)
    tried = math.inf  # the distance at the last attempt to guess the contact
    has_guess, t_c, c0, c1, c2 = False, 0.0, 0.0, 0.0, 0.0
    mode, vertex = FORMS, -1
    near = max(width / 64.0, 4e-16 * max(abs(first), abs(last)))
    for _ in range(budget):
        # Invariant: [first, t] is proved free, and the gap along n at t is g > 0.
        counters[STEPS] += 1
        results[FREE_UNTIL], results[GAP] = t, g
        if not has_guess and distance < 0.3 * tried and (distance < size or tried < math.inf):
            tried = distance
            for mode in range(3):
                vertex = -1
                if mode == FORMS:
                    taken = guess_by_forms(
                        a, i, head_a, coef_a, b, j, head_b, coef_b, t, first, last, rows, weights, count,
                        n0, n1, n2, size, active, counts, frames, unknown, forms, matrix, right, columns, gradients,
                    )  # fmt: skip
                    counters[NEWTON] += abs(taken)
                    if taken < 0:
                        continue
                    t_c = unknown[3]
                    c0, c1, c2 = contact_normal(a, active, counts, frames, unknown, forms)
                elif mode == VERTEX_A:
                    x, y, z = _witness(rows, weights, count, 3)
                    taken, vertex, form, t_c, c0, c1, c2 = guess_by_vertex(
                        a, i, head_a, coef_a, b, j, head_b, coef_b, t, first, last, x, y, z, size,
                        frames[0], frames[2], frames[1], frames[3], frames[5], forms,
                    )  # fmt: skip
                    c0, c1, c2, active[0] = -c0, -c1, -c2, form
                else:
                    x, y, z = _witness(rows, weights, count, 6)
                    taken, vertex, form, t_c, c0, c1, c2 = guess_by_vertex(
                        b, j, head_b, coef_b, a, i, head_a, coef_a, t, first, last, x, y, z, size,
                        frames[1], frames[3], frames[0], frames[2], frames[4], forms,
                    )  # fmt: skip
                    active[0] = form
                if taken < 0 or not t < t_c <= last + width:
                    continue
                g_c = _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, t, c0, c1, c2, pose_a, pose_b)
                counters[GAPS] += 1
                if g_c <= 0.0:
                    continue
                lo = t_c - 0.45 * width
                if t < lo < last:
                    g_lo = _gap_at(
                        a, i, head_a, coef_a, b, j, head_b, coef_b, lo, c0, c1, c2, pose_a, pose_b
                    )
                    counters[GAPS] += 1
                    if g_lo <= 0.0:
                        continue
                has_guess = True
                n0, n1, n2, g = c0, c1, c2, g_c
                break
        if has_guess:
            done = _close_in(
                a, i, head_a, coef_a, b, j, head_b, coef_b, t, g, t_c, near, width, last, inner, c0, c1, c2,
                mode, vertex, pose_a, pose_b, middle, radius, frames, active, counts, unknown, forms, matrix, right,
                columns, gradients, results, counters,
            )  # fmt: skip
            if done >= 0:
                return done
            s, gs = results[FREE_UNTIL], results[GAP]
            if s <= t:
                has_guess = False
            n0, n1, n2 = c0, c1, c2
        else:
            s, gs = stride(
                a, i, head_a, coef_a, b, j, head_b, coef_b, t, g, last, n0, n1, n2, pose_a, pose_b, middle, radius,
                counters,
            )  # fmt: skip
            results[FREE_UNTIL], results[GAP] = s, gs
            if s >= last:
                return FREE
            if s - t <= 1e-15 * (last - first):
                return PRECISION
        t, g = s, gs
        if has_guess:
            continue
        pose_at(head_a, coef_a, t, pose_a)
        pose_at(head_b, coef_b, t, pose_b)
        distance, m0, m1, m2, count = separating_direction(
            a, i, pose_a, b, j, pose_b, n0, n1, n2, rows, weights
        )
        g_m = gap(a, i, pose_a, b, j, pose_b, m0, m1, m2)
        counters[GAPS] += 1
        if g_m > g:
            n0, n1, n2, g = m0, m1, m2, g_m
    return SPENT


@kernel
def _witness(rows, weights, count, at):
    x, y, z = 0.0, 0.0, 0.0
    for k in range(count):
        x += weights[k] * rows[k, at]
        y += weights[k] * rows[k, at + 1]
        z += weights[k] * rows[k, at + 2]
    return x, y, z


@kernel
def _at_start(a, i, b, j, head_a, coef_a, head_b, coef_b, first, frames, rows, weights, count, results):
    """INITIAL when the middle of the last simplex is proved to be in both pieces."""
    if place_frames(head_a, coef_a, head_b, coef_b, first, frames):
        x0, x1, x2 = _witness(rows, weights, count, 3)
        y0, y1, y2 = _witness(rows, weights, count, 6)
        x0, x1, x2 = 0.5 * (x0 + y0), 0.5 * (x1 + y1), 0.5 * (x2 + y2)
        if proves_shared(a, i, b, j, frames, x0, x1, x2, -1, -1):
            results[POINT], results[POINT + 1], results[POINT + 2] = x0, x1, x2
            results[TIME] = results[LO] = results[HI] = first
            return INITIAL
    return AT_START


@kernel
def _close_in(
    a, i, head_a, coef_a, b, j, head_b, coef_b, t, g, t_c, near, width, last, inner, n0, n1, n2, mode, vertex,
    pose_a, pose_b, middle, radius, frames, active, counts, unknown, forms, matrix, right, columns, gradients,
    results, counters,
):  # fmt: skip
    """An outcome, or -1 with FREE_UNTIL and GAP advanced along n as far as proved.

    The lower end is tried at t_c - near, then further off; the upper one at t_c + near, then as far as width allows.
    """
    results[FREE_UNTIL], results[GAP] = t, g
    lo = t
    for back in (near, 0.45 * width):
        aim = min(t_c - back, last)
        if aim <= t:
            lo = t
            break
        g_aim = _gap_at(a, i, head_a, coef_a, b, j, head_b, coef_b, aim, n0, n1, n2, pose_a, pose_b)
        counters[GAPS] += 1
        if g_aim <= 0.0:
            continue
        s, gs = stride(
            a, i, head_a, coef_a, b, j, head_b, coef_b, t, g, aim, n0, n1, n2, pose_a, pose_b, middle, radius, counters
        )
        results[FREE_UNTIL], results[GAP] = s, gs
        if s >= last:
            return FREE
        if s < aim:
            return -1
        lo = s
        break
    if lo < t_c - width:
        return -1
    for ahead in (near, 0.45 * width):
        hi = min(t_c + ahead, inner)
        if hi < lo or hi - lo > width:
            break
        if not place_frames(head_a, coef_a, head_b, coef_b, hi, frames):
            return PRECISION
        if mode == FORMS:
            x, y, z = deepen(a, b, active, counts, frames, unknown, forms, matrix, right, columns, gradients)
            found = proves_shared(a, i, b, j, frames, x, y, z, -1, -1)
        elif mode == VERTEX_A:
            x, y, z = 0.0, 0.0, 0.0
            found = proves_shared(a, i, b, j, frames, 0.0, 0.0, 0.0, vertex, -1)
        else:
            x, y, z = 0.0, 0.0, 0.0
            found = proves_shared(a, i, b, j, frames, 0.0, 0.0, 0.0, -1, vertex)
        if not found:
            continue
        results[TIME], results[LO], results[HI] = min(max(t_c, lo), hi), lo, hi
        results[NORMAL], results[NORMAL + 1], results[NORMAL + 2] = n0, n1, n2
        if mode == FORMS:
            results[POINT], results[POINT + 1], results[POINT + 2] = unknown[0], unknown[1], unknown[2]
        else:
            _place_vertex(a, head_a, coef_a, b, head_b, coef_b, mode, vertex, t_c, pose_a, results)
        counters[MODE], counters[VERTEX] = mode, vertex
        counters[COUNT_A], counters[COUNT_B] = counts[0], counts[1]
        for k in range(8):
            counters[ACTIVE + k] = active[k]
        return CONTACT
    return PRECISION


@kernel
def _place_vertex(a, head_a, coef_a, b, head_b, coef_b, mode, vertex, t, pose, results):
    if mode == VERTEX_A:
        pose_at(head_a, coef_a, t, pose)
        v0, v1, v2 = a.vertices[vertex, 0], a.vertices[vertex, 1], a.vertices[vertex, 2]
    else:
        pose_at(head_b, coef_b, t, pose)
        v0, v1, v2 = b.vertices[vertex, 0], b.vertices[vertex, 1], b.vertices[vertex, 2]
    for k in range(3):
        results[POINT + k] = pose[3 * k] * v0 + pose[3 * k + 1] * v1 + pose[3 * k + 2] * v2 + pose[9 + k]
