"""Certified advancement: the first contact of two moving convex pieces, every interval left behind proved free.

Let a direction n(t) run straight from n0 at t0 to n1 at t1.  For points x of a, y of b the function n(t).(y - x) has
a second derivative of at most K, so it stays above its chord less K s (1 - s) (t1 - t0)^2 / 2, 0 <= s <= 1; and its
values at t0 and t1 are at least the gaps g0, g1 = min n.(y - x) there.  So g0, g1 > 0 and
    sqrt(g0) + sqrt(g1) > sqrt(K / 2) (t1 - t0)
prove the bodies apart on all of [t0, t1]: two support values and a bound of accelerations (re-derived; for a
translation and n0 = n1 it is K = 0).  With the normal of the contact itself for n1 the last interval reaches down to
rounding errors at once, since K times its length falls faster than the gap.
"""

from __future__ import annotations

import math

from firstcontact.kernels.convex.candidate import (
    choose_parts,
    guess_by_forms,
    guess_by_vertex,
    normal_at,
    vertex_normal_at,
    witness,
    worst_form,
)
from firstcontact.kernels.convex.flat import face_along, is_flat, made_point, make_point
from firstcontact.kernels.convex.pierced import pierces
from firstcontact.kernels.convex.separation import bending, gap, separating_direction
from firstcontact.kernels.convex.shared_point import deepen, proves_shared
from firstcontact.kernels.convex.support import BOX
from firstcontact.kernels.convex.touch_system import moving_form, place_frames
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.poses import pose_at
from firstcontact.kernels.workspace import (
    BEGAN,
    FORM,
    FREE_UNTIL,
    GAP,
    GAPS,
    HERE_A,
    HERE_B,
    HI,
    LO,
    MODE,
    NEWTON,
    NO_VERTEX,
    NORMAL,
    PART,
    POINT,
    RESULTS,
    SIDE_A,
    STEPS,
    TIME,
    UNKNOWN,
    VERTEX,
)

# Outcomes: proved free to the end, contact enclosed, shared point at the start; undecided at the start, below the
# resolution of doubles, work spent.
FREE, CONTACT, INITIAL, AT_START, PRECISION, SPENT = range(6)
# How a contact was guessed: by active forms, by a vertex of a, by a vertex of b.
BY_FORMS, BY_VERTEX_A, BY_VERTEX_B = range(3)
# Steps towards a point inside both bodies at the start before they count as possibly touching only.
INWARD_STEPS = 100
# Part of the size by which a guessed point may be beside the flat piece that it is told of.
BESIDE = 1e-11


@uncounted
def _gap_at(a, i, ma, b, j, mb, t, n0, n1, n2, w, c):
    pose_at(ma, t, w, HERE_A)
    pose_at(mb, t, w, HERE_B)
    c[GAPS] += 1
    return gap(a, i, b, j, n0, n1, n2, w)


@uncounted
def _provable(a, i, ma, b, j, mb, t0, t1, g0, g1, n0, n1, n2, e0, e1, e2, w):
    """The length that the gaps g0 along n at t0, g1 along e at t1 prove free: all of [t0, t1] where it is longer."""
    bend = bending(a, i, ma, b, j, mb, t0, t1, n0, n1, n2, e0, e1, e2, w)
    roots = (math.sqrt(g0) + math.sqrt(g1)) * (1.0 - 1e-12)
    return roots / math.sqrt(0.5 * bend) if bend > 0.0 else math.inf


@uncounted
def _crossing(a, i, ma, b, j, mb, t, g, end, g_end, n0, n1, n2, w, c):
    """(s, gap at s > 0): near the time in [t, end] where the gap along n falls to 0, on the near side."""
    # Invariant: the gap is positive at lo and not at hi.
    lo, hi, g_lo, g_hi, found, side = t, end, g, g_end, g, 0
    for _ in range(30):
        s = lo + (hi - lo) * min(max(0.97 * g_lo / (g_lo - g_hi), 0.01), 0.99)
        if not lo < s < hi:
            break
        gs = _gap_at(a, i, ma, b, j, mb, s, n0, n1, n2, w, c)
        if gs > 0.0:
            g_hi *= 0.5 if side == 1 else 1.0
            lo, g_lo, found, side = s, gs, gs, 1
            if gs <= 0.1 * g:
                break
        else:
            g_lo *= 0.5 if side == 2 else 1.0
            hi, g_hi, side = s, gs, 2
    return lo, found


@uncounted
def stride(a, i, ma, b, j, mb, t, g, end, n0, n1, n2, w, c):
    """(t1, gap there) with [t, t1] proved free by the direction n, t1 = end where possible, t where nothing is proved.

    g > 0: the gap at t.
    """
    s = end
    gs = _gap_at(a, i, ma, b, j, mb, s, n0, n1, n2, w, c)
    if gs <= 0.0:
        s, gs = _crossing(a, i, ma, b, j, mb, t, g, end, gs, n0, n1, n2, w, c)
    for _ in range(60):
        if s <= t:
            break
        length = 0.5 * (s - t)
        if gs > 0.0:
            length = _provable(a, i, ma, b, j, mb, t, s, g, gs, n0, n1, n2, n0, n1, n2, w)
            if length > s - t:
                return s, gs
            length = max(min(0.9 * length, 0.7 * (s - t)), 0.1 * (s - t))
        s = t + length
        gs = _gap_at(a, i, ma, b, j, mb, s, n0, n1, n2, w, c)
    return t, g


@uncounted
def _aim(a, i, ma, b, j, mb, t, first, last, count, n0, n1, n2, near, width, size, w, c):
    """(time, normal, gap): the latest time before a guessed contact at which its normal proves the bodies apart.

    Leaves the guess, which lies ahead of t, in w[UNKNOWN].  gap 0: no guess has such a time within `width`, or all are
    beyond `last`.
    """
    if not place_frames(ma, mb, t, w):
        return t, 0.0, 0.0, 0.0, 0.0
    choose_parts(a, i, b, j, count, w, c)
    k, m = c[PART], c[PART + 1]
    c[BEGAN] = -1
    for attempt in range(4):
        mode = max(attempt - 1, 0)
        face_along(a, i, n0, n1, n2, w)
        if mode == BY_FORMS:
            slack = 0.05 if attempt == 0 else 0.5
            taken = guess_by_forms(a, k, ma, b, m, mb, t, first, last, count, slack, n0, n1, n2, size, w, c)
        else:
            taken = guess_by_vertex(a, k, ma, b, m, mb, t, first, last, count, mode - BY_VERTEX_A, w, c)
        c[NEWTON] += abs(taken)
        c[MODE] = mode
        t_c = w[UNKNOWN, 3]
        if taken <= 0 or not t < t_c <= last + width:
            continue
        for later in range(2):
            s = min(t_c - (near if later == 0 else 0.45 * width), last)
            if mode == BY_FORMS:
                e0, e1, e2 = normal_at(a, ma, b, mb, s, size, w, c)
            else:
                e0, e1, e2 = vertex_normal_at(a, ma, b, mb, s, w, c)
            g = _gap_at(a, i, ma, b, j, mb, s, e0, e1, e2, w, c)
            if g > 0.0:
                return s, e0, e1, e2, g
    return t, 0.0, 0.0, 0.0, 0.0


@uncounted
def _at_start(a, i, ma, b, j, mb, first, count, size, w, c):
    """INITIAL when a common point is found, from the middle of the last simplex on by steps behind violated forms."""
    if not place_frames(ma, mb, first, w):
        return AT_START
    x, y, z = 0.0, 0.0, 0.0
    for side in range(2):
        x0, x1, x2 = witness(w, count, 3 + 3 * side)
        x, y, z = x + 0.5 * x0, y + 0.5 * x1, z + 0.5 * x2
    choose_parts(a, i, b, j, count, w, c)
    i, j = c[PART], c[PART + 1]
    flat = is_flat(a, i)
    for _ in range(10 * INWARD_STEPS if flat else INWARD_STEPS):  # along a triangle the way may be narrow
        vertex = NO_VERTEX
        if flat:
            vertex = make_point(a, w, x, y, z)
            x, y, z = made_point(a, w)
        if proves_shared(a, i, b, j, w, SIDE_A, vertex, x, y, z):
            w[RESULTS, POINT], w[RESULTS, POINT + 1], w[RESULTS, POINT + 2] = x, y, z
            w[RESULTS, TIME] = w[RESULTS, LO] = w[RESULTS, HI] = first
            return INITIAL
        for side in range(1 if flat else 0, 2):
            p = a if side == 0 else b
            value, form = worst_form(p, i if side == 0 else j, w, side, x, y, z)
            moving_form(p, form, w, side, x, y, z)
            square = w[FORM, 1] ** 2 + w[FORM, 2] ** 2 + w[FORM, 3] ** 2
            if value > -1e-9 * size and square > 0.0:
                step = (1.5 * value + 1e-6 * size) / square
                x, y, z = x - step * w[FORM, 1], y - step * w[FORM, 2], z - step * w[FORM, 3]
    return AT_START


@uncounted
def _upper_end(a, ma, b, mb, lo, near, width, inner, size, w, c):
    """CONTACT with a proved common point at a time after lo, as soon as can be within `width`; else -1.

    The point told is that of the guess, at the time of contact; of a flat piece the one made of its corners where the
    guess is beside the piece: points and edges as triangles have too few forms to hold it.
    """
    t_c, i, j = w[UNKNOWN, 3], c[PART], c[PART + 1]
    for attempt in range(2):
        hi = min(t_c + near if attempt == 0 else lo + 0.98 * width, inner)
        if hi < lo or hi - lo > width or not place_frames(ma, mb, hi, w):
            break
        side, vertex = max(c[MODE] - BY_VERTEX_A, 0), NO_VERTEX
        x, y, z = w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2]
        if c[MODE] == BY_FORMS:
            x, y, z = deepen(a, b, w, c)
        else:
            vertex = c[VERTEX]
        flat = c[MODE] != BY_VERTEX_A and is_flat(a, i)
        if flat and c[MODE] == BY_FORMS:
            vertex = make_point(a, w, x, y, z)
        if flat and c[MODE] == BY_VERTEX_B:
            proved = pierces(a, b, j, vertex, w)
        else:
            proved = proves_shared(a, i, b, j, w, side, vertex, x, y, z)
        if proved:
            w[RESULTS, TIME], w[RESULTS, LO], w[RESULTS, HI] = min(max(t_c, lo), hi), lo, hi
            for k in range(3):
                w[RESULTS, POINT + k] = w[UNKNOWN, k]
            if flat and c[MODE] == BY_FORMS:
                x, y, z = made_point(a, w)
                off = max(abs(x - w[UNKNOWN, 0]), abs(y - w[UNKNOWN, 1]), abs(z - w[UNKNOWN, 2]))
                if off > BESIDE * size:
                    w[RESULTS, POINT], w[RESULTS, POINT + 1], w[RESULTS, POINT + 2] = x, y, z
            return CONTACT
    return -1


@uncounted
def size_of(a, i, b, j):
    """The largest extent of the boxes of two pieces."""
    size = 0.0
    for k in range(3, 6):
        size = max(size, a[i, BOX + k], b[j, BOX + k])
    return size


@uncounted
def way_between(ma, mb, t, w):
    """From the origin of a's frame to that of b's at t, x where they are one: where to look for a direction first."""
    pose_at(ma, t, w, HERE_A)
    pose_at(mb, t, w, HERE_B)
    n0, n1, n2 = w[HERE_B, 9] - w[HERE_A, 9], w[HERE_B, 10] - w[HERE_A, 10], w[HERE_B, 11] - w[HERE_A, 11]
    if n0 == 0.0 and n1 == 0.0 and n2 == 0.0:
        n0 = 1.0
    return n0, n1, n2


@uncounted
def directed(a, i, ma, b, j, mb, t, n0, n1, n2, w, c):
    """(distance, n, rows of the simplex, gap): a separating direction at t, searched from n on."""
    pose_at(ma, t, w, HERE_A)
    pose_at(mb, t, w, HERE_B)
    distance, n0, n1, n2, count = separating_direction(a, i, b, j, n0, n1, n2, w)
    c[GAPS] += 1
    return distance, n0, n1, n2, count, gap(a, i, b, j, n0, n1, n2, w)


@uncounted
def toward(a, i, ma, b, j, mb, t, g, aim, n0, n1, n2, e0, e1, e2, w, c):
    """(t1, gap, direction) with [t, t1] proved free; t1 = aim where e at aim allows it, t where nothing is proved."""
    s = aim
    gs = _gap_at(a, i, ma, b, j, mb, s, e0, e1, e2, w, c)
    for _ in range(60):
        length = 0.5 * (s - t)
        if gs > 0.0:
            length = _provable(a, i, ma, b, j, mb, t, s, g, gs, n0, n1, n2, e0, e1, e2, w)
            if length > s - t:
                return s, gs, e0, e1, e2
            length = max(min(0.9 * length, 0.7 * (s - t)), 0.1 * (s - t))
        s = t + length
        if s <= t:
            break
        _, e0, e1, e2, _, gs = directed(a, i, ma, b, j, mb, s, e0, e1, e2, w, c)
    return t, g, n0, n1, n2


@uncounted
def advance_pieces(a, i, ma, b, j, mb, first, last, inner, width, budget, w, c):
    """One of the outcomes above for the pieces i of a and j of b over [first, last].

    a, b: as `kernels.convex.support` tells, piece i may be flat, either may be a union of pieces; ma, mb: as
    `kernels.poses`; inner <= last: the latest time at which a contact may be claimed; width: of its interval; budget:
    strides.  w, c: the workspace; results and counters are left there.
    """
    size = size_of(a, i, b, j)
    near = max(width / 64.0, 4e-16 * max(abs(first), abs(last)))
    t = first
    n0, n1, n2 = way_between(ma, mb, t, w)
    distance, n0, n1, n2, count, g = directed(a, i, ma, b, j, mb, t, n0, n1, n2, w, c)
    w[RESULTS, FREE_UNTIL], w[RESULTS, GAP] = t, max(g, 0.0)
    if g <= 0.0:
        return _at_start(a, i, ma, b, j, mb, first, count, size, w, c)
    tried = math.inf  # the distance at the last attempt to guess the contact
    guessed, aim, e0, e1, e2 = False, last, 0.0, 0.0, 0.0
    for _ in range(budget):
        # Invariant: [first, t] is proved free, and the gap along n at t is g > 0.
        c[STEPS] += 1
        if not guessed and distance < 0.3 * tried:
            tried = distance
            aim, e0, e1, e2, better = _aim(
                a, i, ma, b, j, mb, t, first, last, count, n0, n1, n2, near, width, size, w, c
            )
            guessed = better > 0.0
        before = t
        if guessed:
            if aim > t:
                t, g, n0, n1, n2 = toward(a, i, ma, b, j, mb, t, g, aim, n0, n1, n2, e0, e1, e2, w, c)
                w[RESULTS, FREE_UNTIL], w[RESULTS, GAP] = t, g
            if t >= last:
                return FREE
            if t >= aim:
                if _upper_end(a, ma, b, mb, t, near, width, inner, size, w, c) == CONTACT:
                    w[RESULTS, NORMAL], w[RESULTS, NORMAL + 1], w[RESULTS, NORMAL + 2] = e0, e1, e2
                    return CONTACT
                guessed = False
            guessed = guessed and t > before
        else:
            t, g = stride(a, i, ma, b, j, mb, t, g, last, n0, n1, n2, w, c)
            w[RESULTS, FREE_UNTIL], w[RESULTS, GAP] = t, g
            if t >= last:
                return FREE
            if t - before <= 1e-15 * (last - first):
                return PRECISION
        if not guessed:
            distance, m0, m1, m2, count, better = directed(a, i, ma, b, j, mb, t, n0, n1, n2, w, c)
            if better > g:
                n0, n1, n2, g = m0, m1, m2, better
    return SPENT
