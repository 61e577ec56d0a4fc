"""When do parts share points under a curved motion?  Windows of time from functions of a cell (`curve`), by halving.

Two triangles share a point where an edge of one passes through the other: its ends lie on both sides of the plane and
the side products of its line with the three sides agree.  All these functions are linear in the rows of a cell, so
their Bernstein coefficients prove over a stretch of time that some edge does, or that none does.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import implements, kernel, uncounted
from firstcontact.motion.relative.cells import BACK, BACK_SHIFT, ERRORS, LENGTH, LEVELS, LINEAR, SCRATCH, SHIFT, TERMS
from firstcontact.search.trees.curve import (
    E_BACK,
    E_BACK_SHIFT,
    E_LINEAR,
    E_SHIFT,
    LAST,
    TIME_EPS,
    U8,
    boxes_free,
    boxes_of,
    height,
    next_meeting,
    normal_of,
    side_product,
    sign_of,
)
from firstcontact.search.trees.tree import FACET
from firstcontact.search.trees.windows import PART_ROOM, meeting_window, part_windows

# Rows of a scratch slot: heights of the corners of a over the facet of b, of b over that of a, side products of the
# sides i of a and j of b (at 6 + 3 i + j); the stretch; the error bounds of the fifteen functions; their signs.
_FUNCTIONS, _STRETCH, _BOUNDS, _SIGNS = 15, 15, 16, 18
# Share of a cell at which halving stops: the rest is left to the exact face.
_SHORTEST = 2.0**-14
# Of `_relation`: over all of the stretch.
_WHOLE = np.int64(-1)


@uncounted
def meeting_span(motion, boxes_a, a, boxes_b, b, pad, last):
    """(entry, exit) of the times in [0, last] at which two boxes may overlap; entry inf for none."""
    entry, cell = next_meeting(motion, boxes_a, a, boxes_b, b, pad, 0.0, last)
    if cell < 0:
        return np.inf, np.inf
    levels, length = int(motion[0, ERRORS, LEVELS]), motion[0, ERRORS, LENGTH]
    level, i = 0, 0
    # Invariant: the boxes are apart after cell i of the level.
    while True:
        count = 1 << level
        if boxes_free(motion, count - 1 + i, boxes_a, a, boxes_b, b, pad) <= 1.0:
            if level == levels:
                return entry, max(entry, min(last, length * (i + 1) / count + TIME_EPS * length))
            level, i = level + 1, 2 * i + 1
            continue
        if i == 0:
            return entry, entry
        i -= 1
        while level > 0 and i & 1 == 1:
            i >>= 1
            level -= 1


@uncounted
def _fill(motion, slot, cell, xa, facet_a, err_a, xb, facet_b, err_b):
    """All functions of two parts over the cell, into a slot, with their bounds."""
    if facet_b:
        n0, n1, n2, dn = normal_of(xb, err_b)
        for s in range(3):
            motion[slot, _BOUNDS, s] = height(
                motion, slot, s, cell, LINEAR, SHIFT, E_LINEAR, E_SHIFT, xa[3 * s], xa[3 * s + 1], xa[3 * s + 2], err_a,
                n0, n1, n2, dn, xb[0], xb[1], xb[2], err_b,
            )  # fmt: skip
    if facet_a:
        n0, n1, n2, dn = normal_of(xa, err_a)
        for s in range(3):
            motion[slot, _BOUNDS, 3 + s] = height(
                motion, slot, 3 + s, cell, BACK, BACK_SHIFT, E_BACK, E_BACK_SHIFT,
                xb[3 * s], xb[3 * s + 1], xb[3 * s + 2], err_b, n0, n1, n2, dn, xa[0], xa[1], xa[2], err_a,
            )  # fmt: skip
    for s in range(3 if facet_a else 1):
        i, j = 3 * s, 3 * ((s + 1) % 3)
        a0, a1, a2 = xa[i], xa[i + 1], xa[i + 2]
        e0, e1, e2 = xa[j] - a0, xa[j + 1] - a1, xa[j + 2] - a2
        m0, m1, m2 = a1 * e2 - a2 * e1, a2 * e0 - a0 * e2, a0 * e1 - a1 * e0
        for r in range(3 if facet_b else 1):
            k, m = 3 * r, 3 * ((r + 1) % 3)
            f = 6 + 3 * s + r
            motion[slot, _BOUNDS + (f >> 3), f & 7] = side_product(
                motion, slot, f, cell, a0, a1, a2, e0, e1, e2, m0, m1, m2, err_a,
                xb[m] - xb[k], xb[m + 1] - xb[k + 1], xb[m + 2] - xb[k + 2], 6.0 * err_b, xb[k], xb[k + 1], xb[k + 2],
                err_b,
            )  # fmt: skip


@uncounted
def _halve_all(motion, slot):
    """De Casteljau: slot becomes the right half, slot + 1 the left half."""
    for f in range(_FUNCTIONS):
        most = 0.0
        for step in range(TERMS):
            motion[slot + 1, f, step] = motion[slot, f, 0]
            most = max(most, abs(motion[slot, f, step]))
            for j in range(LAST - step):
                motion[slot, f, j] = 0.5 * (motion[slot, f, j] + motion[slot, f, j + 1])
        motion[slot, _BOUNDS + (f >> 3), f & 7] += U8 * most
        motion[slot + 1, _BOUNDS + (f >> 3), f & 7] = motion[slot, _BOUNDS + (f >> 3), f & 7]
    middle = 0.5 * (motion[slot, _STRETCH, 0] + motion[slot, _STRETCH, 1])
    motion[slot + 1, _STRETCH, 0], motion[slot + 1, _STRETCH, 1] = motion[slot, _STRETCH, 0], middle
    motion[slot, _STRETCH, 0] = middle


@uncounted
def _edge_in_facet(motion, slot, h, k, f, step):
    """Signs in the slot's row: ends h, k over the plane, line against sides f, f + step, f + 2 step.

    1: the edge passes through the facet all the time; -1: it never meets it; 0: unsure.
    """
    row = _SIGNS
    ends = motion[slot, row + (h >> 3), h & 7] * motion[slot, row + (k >> 3), k & 7]
    if ends > 0.0:
        return -1
    lo, hi = 1.0, -1.0
    for s in range(3):
        g = f + s * step
        sign = motion[slot, row + (g >> 3), g & 7]
        lo, hi = min(lo, sign), max(hi, sign)
    if lo < 0.0 and hi > 0.0:
        return -1
    return 1 if ends < 0.0 and (lo > 0.0 or hi < 0.0) else 0


@uncounted
def _relation(motion, slot, facet_a, facet_b, at):
    """1: the parts share a point all through the stretch; -1: never; 0: unsure.

    at: of which Bernstein coefficient alone, those of the ends of the stretch being 0 and LAST; _WHOLE of all of them.
    """
    for f in range(_FUNCTIONS):
        if (f < 3 and not facet_b) or (3 <= f < 6 and not facet_a):
            continue
        if f >= 6 and (((f - 6) // 3 > 0 and not facet_a) or ((f - 6) % 3 > 0 and not facet_b)):
            continue
        err = motion[slot, _BOUNDS + (f >> 3), f & 7]
        if at < 0:
            sign = sign_of(motion, slot, f, err)
        else:
            value = motion[slot, f, at]
            sign = 1 if value > err else -1 if value < -err else 0
        motion[slot, _SIGNS + (f >> 3), f & 7] = sign
    if not (facet_a or facet_b):
        return -1 if motion[slot, _SIGNS, 6] != 0.0 else 0
    apart = True
    if facet_b:
        for i in range(3 if facet_a else 1):
            relation = _edge_in_facet(motion, slot, i, (i + 1) % 3, 6 + 3 * i, 1)
            if relation > 0:
                return 1
            apart = apart and relation < 0
    if facet_a:
        for j in range(3 if facet_b else 1):
            relation = _edge_in_facet(motion, slot, 3 + j, 3 + (j + 1) % 3, 6 + j, 3)
            if relation > 0:
                return 1
            apart = apart and relation < 0
    return -1 if apart else 0


@uncounted
def _stays_open(motion, slot, facet_a, facet_b):
    """Whether the relation is unsure at both ends of the stretch, as that of parts which slide in one plane is."""
    if _relation(motion, slot, facet_a, facet_b, np.int64(LAST)) != 0:
        return False
    return _relation(motion, slot, facet_a, facet_b, np.int64(0)) == 0


@uncounted
def _add_stretch(out, count, state, relation, t0, t1, length):
    """Carry the windows on by a stretch; state: open since, certain since, certain until, or -1 each.

    Returns the number of windows; more than PART_ROOM: no room.
    """
    if relation < 0:
        return _close(out, count, state, length)
    if state[0] < 0.0:
        state[0] = t0
    if relation > 0:
        if state[1] < 0.0:
            state[1] = t0
        elif state[2] < t0:  # certain again after a doubtful stretch: two windows with the doubt in both
            doubt, until = state[2], t0
            state[3] = until
            count = _close(out, count, state, length)
            state[0], state[1] = doubt, t0
        state[2] = t1
    state[3] = t1
    return count


@uncounted
def _close(out, count, state, length):
    """Write the window that is open, if one is.

    Times round by TIME_EPS of the length.  A window that is certain at an end of the piece is written as one that goes
    on beyond it: whoever wants to know more of that end would learn nothing.
    """
    if state[0] >= 0.0:
        if count >= PART_ROOM:
            return PART_ROOM + 1
        slack = TIME_EPS * length
        out[count, 0], out[count, 3] = state[0] - slack, state[3] + slack
        if state[1] >= 0.0:
            out[count, 1], out[count, 2] = state[1] + slack, state[2] - slack
            if state[1] == 0.0:
                out[count, 0] = out[count, 1] = -length
            if state[2] >= length * (1.0 - TIME_EPS):
                out[count, 2] = out[count, 3] = 2.0 * length
        else:
            out[count, 1], out[count, 2] = out[count, 3], out[count, 0]
        count += 1
    state[:] = -1.0
    return count


def _windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    top = motion.shape[0] - SCRATCH
    levels, length = int(motion[0, ERRORS, LEVELS]), motion[0, ERRORS, LENGTH]
    count = 1 << levels
    width = length / count
    facet_a, facet_b = mask_a & FACET != 0, mask_b & FACET != 0
    boxes = motion[motion.shape[0] - 1]
    boxes_of(xa, xb, boxes)
    pad = 4.0 * (motion[0, ERRORS + 1, E_LINEAR] + 1.0) * (err_a + err_b) if err_a + err_b > 0.0 else 0.0
    state = scratch[0:2].ravel()
    state[:] = -1.0
    found, time = np.int64(0), 0.0
    # What is unsure for long is not cut finely: the stretch that need not be halved doubles with each open one.
    shortest = _SHORTEST
    while True:
        before = time
        time, cell = next_meeting(motion, boxes, 6, boxes, 7, pad, time, last)
        if cell < 0:
            break
        if time > before:
            found = _close(out, found, state, length)
        start = length * cell / count
        _fill(motion, top, count - 1 + cell, xa, facet_a, err_a, xb, facet_b, err_b)
        motion[top, _STRETCH, 0], motion[top, _STRETCH, 1] = 0.0, 1.0
        slot = top
        # Slots top .. slot hold stretches in descending order; all before them is in the windows.
        while slot >= top:
            s0, s1 = motion[slot, _STRETCH, 0], motion[slot, _STRETCH, 1]
            relation = _relation(motion, slot, facet_a, facet_b, _WHOLE)
            if (
                relation != 0
                or s1 - s0 <= _SHORTEST
                or (s1 - s0 <= shortest and _stays_open(motion, slot, facet_a, facet_b))
            ):
                shortest = _SHORTEST if relation != 0 else min(1.0, 2.0 * shortest)
                found = _add_stretch(out, found, state, relation, start + width * s0, start + width * s1, length)
                slot -= 1
                if found > PART_ROOM:
                    return -1
            else:
                _halve_all(motion, slot)
                slot += 1
        time = max(time, length * (cell + 1) / count)
        if cell + 1 == count:
            break
    found = _close(out, found, state, length)
    return found if found <= PART_ROOM else -1


@implements(meeting_window, 3)
def _meeting_window(motion, boxes_a, a, boxes_b, b, pad, last):
    if motion.ndim == 3:
        return lambda motion, boxes_a, a, boxes_b, b, pad, last: meeting_span(
            motion, boxes_a, np.int64(a), boxes_b, np.int64(b), pad, last
        )
    return None


@implements(part_windows, 3)
def _part_windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    if motion.ndim == 3:
        return _windows
    return None


@kernel
def windows_of_parts(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, out):
    """`part_windows` of two parts seen alone."""
    scratch = np.empty((PART_ROOM, 2))
    return part_windows(motion, np.int32(mask_a), xa, np.int32(mask_b), xb, err_a, err_b, last, scratch, out)
