"""Branch and prune over (u, v, T) for two moving ruled pieces: all instants at which contact can begin or end.

A box stands for all strata it meets until it is small; what P = Q leaves of it is then searched for zeros of the event
system of every stratum (interior, edges, corners of either piece), which are isolated as a rule.  Earliest boxes first:
what ends the search before a certain contact is proved free.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.heap import heap_pop, heap_push
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.rulings.boxes import cut_by_directions, cut_by_elimination, eliminate, holds_zero, shrink
from firstcontact.kernels.rulings.linear_models import MORE, REST
from firstcontact.kernels.rulings.models import (
    ALL_STRATA,
    BY_U,
    BY_V,
    GAP,
    difference_models,
    minor_models,
)

# Modes: until the first certain contact; all events; whether there is a contact at a fixed time.
FIRST_EVENT, ALL_EVENTS, AT_REST = range(3)
# Outcomes: finished; room spent; as many visits made as were allowed, to be gone on with.
DONE, SPENT, SLICE_SPENT = range(3)
# Columns of the integers of a box: parts, free parameters of the stratum; of one found: whether it is a sure contact.
PART_P, PART_Q, STRATUM, SURE = range(4)
# Columns of a part's domain: lowest and highest parameter, whether these are ends of the piece.
LOWEST, HIGHEST, ENDS_LOW, ENDS_HIGH = range(4)
PERHAPS, SURELY = np.int64(0), np.int64(1)
NO_MINORS = np.int64(0)
# Counters.
VISITS, SPLITS, SPAWNED, PROOFS, FOUND, WAITING, USED = range(7)
COUNTERS = 7
MOST_FOUND = 512
LEAST = 1e-11
"""Width, in units of its range, below which a parameter is not split."""
WIDE = 1e-4
"""Half of a range from which on it gets no more room in a proof of contact."""
ROUNDS = 12
TIME_FIRST = 3.0
"""Weight of the time in the choice of the side to split."""
READY = 0.7
"""Remainder, in units of the largest slope, below which a box is looked at for events."""


@uncounted
def _room(dom_p, dom_q, kind, k):
    """Lowest and highest value of a parameter."""
    if k == 0:
        return dom_p[kind[PART_P], LOWEST], dom_p[kind[PART_P], HIGHEST]
    if k == 2:
        return dom_q[kind[PART_Q], LOWEST], dom_q[kind[PART_Q], HIGHEST]
    return 0.0, 1.0


@uncounted
def _sure(p, dom_p, q, dom_q, kind, box, span, times, near, fixed, pivots, image, w, table):
    """Whether a contact in or near the box is certain; times: enclosure of its T.  (near, fixed, ..: scratch.)"""
    i, j, free = kind[PART_P], kind[PART_Q], kind[STRATUM]
    for k in range(5):
        near[k, 0], near[k, 1] = box[k, 0], box[k, 1]
        fixed[k] = int(k < 4 and free >> k & 1 == 0)
        if fixed[k] == 1:
            continue
        m, h = 0.5 * (box[k, 0] + box[k, 1]), 0.5 * (box[k, 1] - box[k, 0])
        if h < WIDE:  # room around the solution
            h = 4.0 * h + 1e-9 * (span if k == 4 else 1.0)
        lo, hi = (m - h, m + h) if k == 4 else _room(dom_p, dom_q, kind, k)
        near[k, 0], near[k, 1] = max(m - h, lo), min(m + h, hi)
    if not difference_models(p, i, q, j, near, w, table):
        return False
    minors = minor_models(free, w)
    if eliminate(w, minors, fixed, pivots) < 3:
        return False
    # what is not solved for stays in its middle
    for k in range(5):
        solved = False
        for row in range(3 + minors):
            solved = solved or pivots[row] == k
        if not solved:
            near[k, 0] = 0.5 * (near[k, 0] + near[k, 1])
            near[k, 1] = near[k, 0]
            fixed[k] = 1
    if not difference_models(p, i, q, j, near, w, table):
        return False
    minors = minor_models(free, w)
    if not holds_zero(w, minors, fixed, pivots, image):
        return False
    c = 0.5 * (near[4, 0] + near[4, 1])
    h = max(near[4, 1] - c, c - near[4, 0]) * MORE
    slack = 1e-15 * (abs(c) + h)
    times[0], times[1] = c + h * image[0] - slack, c + h * image[1] + slack
    return True


@uncounted
def _heaviest(w, normal, box, at_rest, strata, least_time, span):
    """The column to split: what moves P - Q most along the normal, bending included; -1: nothing is wide enough."""
    best, column, bent, size = -1.0, -1, 0.0, 1e-300
    for k in range(6):
        size += abs(w[GAP, k]) + abs(w[GAP + 1, k]) + abs(w[GAP + 2, k])
    for k in (0, 2, 1, 3, 4):
        width = box[k, 1] - box[k, 0]
        heavy = abs(normal[0] * w[GAP, 1 + k] + normal[1] * w[GAP + 1, 1 + k] + normal[2] * w[GAP + 2, 1 + k])
        if k == 0 or k == 2:
            row = BY_U if k == 0 else BY_V
            for i in range(3):
                bend = 0.5 * abs(w[row + i, 1 + k]) + abs(w[row + i, 2 + k]) + abs(w[row + i, 5]) + w[row + i, REST]
                bend *= abs(normal[i]) * 0.5 * width
                bent += bend
                heavy += bend
        elif k != 4:
            heavy *= 0.125 if strata else 0.25
        else:  # the time's share in what is left of the remainder, by squares of relative widths
            rest = abs(normal[0]) * w[GAP, REST] + abs(normal[1]) * w[GAP + 1, REST] + abs(normal[2]) * w[GAP + 2, REST]
            square = (width / span) ** 2
            others = (box[0, 1] - box[0, 0]) ** 2 + (box[2, 1] - box[2, 0]) ** 2
            heavy = TIME_FIRST * (heavy + max(rest - bent, 0.0) * square / (square + 0.25 * others + 1e-300))
        if not width > (least_time if k == 4 else LEAST) or (k == 4 and at_rest):
            continue
        # parameters without any influence come last, the widest first
        heavy += 1e-9 * width * size
        if heavy > best:
            best, column = heavy, k
    return column


@uncounted
def _widest(box, at_rest, least_time, span):
    """The column to split where a weight may vanish: the widest of u, v and T; -1: none is wide enough."""
    best, column = LEAST, -1
    for k in range(0, 5, 2):
        width = box[k, 1] - box[k, 0]
        if k == 4:
            width = 0.0 if at_rest or width <= least_time else width / span
        if width > best:
            best, column = width, k
    return column


@uncounted
def _ready(w):
    """Whether linear parts rule P - Q over the box, so that events are worth a look."""
    slopes, rest = 0.0, 0.0
    for i in range(3):
        for k in (1, 3, 5):
            slopes = max(slopes, abs(w[GAP + i, k]))
        rest = max(rest, w[GAP + i, REST])
    return rest < READY * slopes


@kernel
def search(p, dom_p, q, dom_q, mode, boxes, kinds, keys, heap, slots, n, span, tolerance, stop, found, found_kinds,
           times, limit, counters, w, table):  # fmt: skip
    """Work off the n boxes in the heap; DONE, SPENT, or SLICE_SPENT once `stop` visits are counted.

    After SLICE_SPENT, call it again with counters[WAITING] as n, all else as it was left, and a later `stop`: the
    search goes on as if it had never ended.

    boxes (m, 5, 2), kinds (m, 3): boxes and their parts and strata, the first n to begin with; slots (m,): scratch.
    found (MOST_FOUND, 5, 2), found_kinds (.., 4), times (.., 2): the narrow boxes left, with an enclosure of the time
    of a contact where that is certain.  All zeros lie in the boxes found or, in mode FIRST_EVENT, start after
    limit[1]; limit: the earliest time of a box found, the latest of a first sure contact.  AT_REST: DONE with a sure
    box in front if there is a contact.
    """
    # rows of boxes that are free again are in slots[n : counters[USED]], those from there on were never used
    room = len(slots)
    counters[USED] = max(counters[USED], n)
    box, e, near = np.empty((5, 2)), np.empty((5, 2)), np.empty((5, 2))
    normal, image, moment = np.zeros(3), np.zeros(2), np.zeros(2)
    fixed, pivots, kind = np.zeros(5, np.int64), np.zeros(7, np.int64), np.zeros(3, np.int64)
    while n > 0:
        # what starts as late as a sure contact does not matter; what starts after an open box cannot mend it
        if mode == FIRST_EVENT and (keys[0] >= limit[1] - tolerance or keys[0] > limit[0] + tolerance):
            limit[0] = min(limit[0], keys[0])
            return DONE
        if counters[VISITS] >= stop:
            counters[WAITING] = n
            return SLICE_SPENT
        if n + 80 > room:
            counters[WAITING] = n
            limit[0] = min(limit[0], keys[0])
            return SPENT
        slot = heap[0, 0]
        n = heap_pop(keys, heap, n)
        slots[n] = slot
        counters[VISITS] += 1
        for k in range(5):
            box[k, 0], box[k, 1] = boxes[slot, k, 0], boxes[slot, k, 1]
        for k in range(3):
            kind[k] = kinds[slot, k]
        i, j, free = kind[PART_P], kind[PART_Q], kind[STRATUM]
        empty, told, strata = False, False, free != ALL_STRATA
        for _ in range(ROUNDS):
            if not difference_models(p, i, q, j, box, w, table):
                told = False
                break
            told = True
            for k in range(5):
                e[k, 0], e[k, 1] = -1.0, 1.0
                fixed[k] = 0 if box[k, 1] > box[k, 0] else 1
            if not cut_by_directions(w, e, normal):
                empty = True
                break
            minors = minor_models(free, w) if strata else 0
            if not cut_by_elimination(w, minors, fixed, pivots, e):
                empty = True
                break
            if mode == AT_REST:  # of interest is what holds at all times
                e[4, 0], e[4, 1] = -1.0, 1.0
            most, least = shrink(box, e)
            if not (most < 0.5 or (strata and least < 0.1) or least < 0.3):
                break
        if empty:
            continue
        if mode == AT_REST:
            if _rests(p, dom_p, q, dom_q, kind, box, near, fixed, pivots, image, w, table):
                _record(found, found_kinds, times, limit, counters, box, kind, SURELY, box[4])
                return DONE
            told = difference_models(p, i, q, j, box, w, table)
        if mode != AT_REST and strata and box[4, 1] - box[4, 0] <= tolerance and counters[FOUND] < MOST_FOUND:
            if _sure(p, dom_p, q, dom_q, kind, box, span, moment, near, fixed, pivots, image, w, table):
                counters[PROOFS] += 1
                _record(found, found_kinds, times, limit, counters, box, kind, SURELY, moment)
                continue
            told = difference_models(p, i, q, j, box, w, table)
        if told:
            split = _heaviest(w, normal, box, mode == AT_REST, strata, tolerance, span)
        else:
            split = _widest(box, mode == AT_REST, tolerance, span)
        if split < 0:
            if counters[FOUND] >= MOST_FOUND:
                counters[WAITING] = n + 1
                limit[0] = min(limit[0], box[4, 0])
                return SPENT
            _record(found, found_kinds, times, limit, counters, box, kind, PERHAPS, moment)
            continue
        if told and not strata and mode != AT_REST and _ready(w):
            n = _strata(dom_p, dom_q, kind, box, boxes, kinds, keys, heap, slots, n, counters)
            continue
        counters[SPLITS] += 1
        middle = 0.5 * (box[split, 0] + box[split, 1])
        for half in range(2):
            slot = _free_row(slots, n, counters)
            for k in range(5):
                boxes[slot, k, 0], boxes[slot, k, 1] = box[k, 0], box[k, 1]
            boxes[slot, split, 1 - half] = middle
            for k in range(3):
                kinds[slot, k] = kind[k]
            key = boxes[slot, 4, 0] if mode != AT_REST else box[0, 0] - box[0, 1] + box[2, 0] - box[2, 1]
            n = heap_push(keys, heap, n, key, slot, 0)
    counters[WAITING] = 0
    return DONE


@uncounted
def _rests(p, dom_p, q, dom_q, kind, box, near, fixed, pivots, image, w, table):
    """Whether a contact in the box is certain at all its times."""
    for k in range(5):
        near[k, 0], near[k, 1] = box[k, 0], box[k, 1]
        if k < 4:  # with room around the solution, inside the pieces
            m, h = 0.5 * (box[k, 0] + box[k, 1]), (box[k, 1] - box[k, 0]) + 1e-9
            lo, hi = _room(dom_p, dom_q, kind, k)
            near[k, 0], near[k, 1] = max(m - h, lo), min(m + h, hi)
        fixed[k] = 0
    fixed[4] = 1
    if not difference_models(p, kind[PART_P], q, kind[PART_Q], near, w, table):
        return False
    return holds_zero(w, NO_MINORS, fixed, pivots, image)


@uncounted
def _record(found, found_kinds, times, limit, counters, box, kind, sure, moment):
    row = counters[FOUND]
    counters[FOUND] += 1
    for k in range(5):
        found[row, k, 0], found[row, k, 1] = box[k, 0], box[k, 1]
    for k in range(3):
        found_kinds[row, k] = kind[k]
    found_kinds[row, SURE] = sure
    limit[0] = min(limit[0], box[4, 0])
    if sure == SURELY:
        times[row, 0], times[row, 1] = moment[0], moment[1]
        limit[1] = min(limit[1], moment[1])


@uncounted
def _strata(dom_p, dom_q, kind, box, boxes, kinds, keys, heap, slots, n, counters):
    """Push the box once for every stratum of at least two free parameters that it meets."""
    i, j = kind[PART_P], kind[PART_Q]
    for a in range(81):
        free = 0
        slot = _free_row(slots, n, counters)
        fits = True
        code = a
        for k in range(5):
            boxes[slot, k, 0], boxes[slot, k, 1] = box[k, 0], box[k, 1]
        for k in range(4):
            side = code % 3
            code //= 3
            if side == 0:
                free += 1 << k
                continue
            lo, hi = 0.0, 1.0
            if k == 0 or k == 2:
                dom, part = (dom_p, i) if k == 0 else (dom_q, j)
                lo, hi = dom[part, LOWEST], dom[part, HIGHEST]
                fits = fits and dom[part, ENDS_LOW if side == 1 else ENDS_HIGH] == 1.0
            end = lo if side == 1 else hi
            fits = fits and box[k, 0] <= end <= box[k, 1]
            boxes[slot, k, 0], boxes[slot, k, 1] = end, end
        count = (free & 1) + (free >> 1 & 1) + (free >> 2 & 1) + (free >> 3 & 1)
        if not fits or count < 2:
            continue
        kinds[slot, PART_P], kinds[slot, PART_Q], kinds[slot, STRATUM] = i, j, free
        n = heap_push(keys, heap, n, box[4, 0], slot, 0)
        counters[SPAWNED] += 1
    return n


@uncounted
def _free_row(slots, n, counters):
    """The row that the next box pushed onto n others is to take."""
    if n == counters[USED]:
        slots[n] = n
        counters[USED] += 1
    return slots[n]
