"""Branch and prune for the first event of two moving models: boxes of (feature of one body) x (slab of time).

A box that holds no point of the other closed model is dropped, and so is one in which none of the equations of its
pair of features can hold.  Slabs are taken in order of time: where no box survives a slab nothing begins to touch in
it; else the slab is cut to the times of its survivors, or halved.
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.events.feature_boxes import (
    ABOUT,
    BY_U,
    BY_V,
    DEEPEST,
    FIRST_ROW,
    GIVEN,
    HERE,
    INSIDE,
    MID,
    NEGATIVE,
    OPEN,
    OUTSIDE,
    PLAIN,
    POSITIVE,
    RANGES,
    SHARES,
    SLAB,
    SPARE,
    TERMS,
    THERE,
    UU,
    VALUE,
    VV,
    ZEROTH,
    add_shares,
    membership,
    model,
    narrow,
    parallel,
    place_box,
    reach,
    sign,
)
from firstcontact.kernels.events.feature_boxes import FIRST as FIRST_ORDER
from firstcontact.kernels.events.feature_boxes import SECOND as SECOND_ORDER
from firstcontact.kernels.events.moving_forms import FIRST, MAP, SECOND, pose_models, pull_back, relative_map
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import rows

U = 2.0**-53
FREE, STOPPED, SPENT, SLICE_SPENT = rows(*range(4))
# Rows of the result from the fifth on: where the search goes on after SLICE_SPENT, which GOING tells.
GOING, DEPTH, START, KEPT, TODO, SOONEST, LATEST = rows(*range(4, 11))
RESULTS = 11
# Columns of a box: chart, pair (or one of the two below), middle and half-width of u and v, first and last time.
CHART, PAIR, AT_U, HALF_U, AT_V, HALF_V, BEGIN, END = rows(*range(8))
ALL_PAIRS, STILL = -1, -2
# Columns of a chart's integers: body, number of parameters, bits of the forms that hold it, range of its pairs, number
# of inequalities that cut it: the charts after it, in the same parameters, are those of the body's first forms.
BODY, PARAMS, ON, FIRST_PAIR, END_PAIR, CUTS = rows(*range(6))
# Columns of a pair: number of equations, derivatives among them, forms of the other body (the second or -1), form
# of the own body (of an edge of degree 4, which lies in a chart of another one; or -1).  From SECOND_CUT on the second
# form counts the body's own ones.
EQUATIONS, DEEP, FORM, OTHER_FORM, OWN_FORM = rows(*range(5))
SECOND_CUT = 64
# Columns of a body's layout: rows of its own forms and of the other's in its frame, their compiled trees, first row
# and number of its forms as given.
OWN, OTHER, OWN_BEGIN, OWN_END, OTHER_BEGIN, OTHER_END, RAW, COUNT = rows(*range(8))
# Bits kept with a box: forms of the other body that are negative there, and positive; whether no form of its own body
# leaves open that it belongs to it.  They hold for all parts of the box and of its time.
NEGATIVE_THERE, POSITIVE_THERE, IN_OWN = rows(0, 1, 2)
KNOWN = 3
# Slots of the row of the slab: middle, half, and for either body how far a point goes and how lengths change.
MIDDLE, HALF, TRAVEL, STRETCH = 0, 1, 2, 4
# What becomes of a box: dropped, kept for shorter times, cut across u or v, replaced by one for each pair.
DEAD, LATER, CUT_U, CUT_V, EACH_PAIR = rows(*range(5))
# Pairs that may touch in a box of all pairs for it to be replaced.
FEW = 3
# Part of the body's size from which on a box is replaced in any case.
SMALL = 0.01
# Part of it below which a box whose equations leave nothing open is not cut to tell whether it belongs to the bodies.
FINE = 2.0**-24
# Rows of the arrays of boxes that one visit may need.
ROOM = 256
# Part of the slab below which a box's time is short.
BRIEF = 0.1
# Half-widths of parameters below which boxes are not cut any more.
NARROW = 1e-12
STILL_NARROW = 1e-9
VISITS, TESTS, SLABS = rows(0, 1, 2)


@uncounted
def place_slab(t0, t1, ma, mb, raw, kinds, units, layout, w, models, table, z):
    """All forms of either body in the frame of the other over [t0, t1]; False where a pose is singular."""
    middle = 0.5 * (t0 + t1)
    half = max(t1 - middle, middle - t0) * (1.0 + 1e-15) + 8.0 * U * max(abs(t0), abs(t1)) + 1e-300
    z[SLAB, MIDDLE], z[SLAB, HALF] = middle, half
    pose_models(ma, middle, half, w, models, FIRST)
    pose_models(mb, middle, half, w, models, SECOND)
    for x in range(2):
        y = 1 - x
        own = FIRST if x == 0 else SECOND
        if not relative_map(models, own, SECOND if x == 0 else FIRST, units, x, y):
            return False
        travel, stretch = 0.0, 0.0
        for r in range(3):
            way = 0.0
            for c in range(4):
                way += abs(models[1, MAP + 4 * r + c])
                if c < 3:
                    stretch = max(stretch, abs(models[0, MAP + 4 * r + c]))
            travel = max(travel, way)
        z[SLAB, TRAVEL + x], z[SLAB, STRETCH + x] = travel, stretch
        pull_back(raw, kinds, layout[y, RAW], layout[y, COUNT], models, table, layout[x, OTHER])
    return True


@uncounted
def _own_model(table, own, form, s, hs, z, deep, row):
    """As `model`, of a form of the own body; of a cut what was made with the box."""
    if table[own + form, ABOUT, GIVEN] == 0.0:
        model(table, own + form, s, hs, z, deep, row)
        return
    for k in range(deep + 1):
        for c in range(TERMS + 1):
            z[row + k, c] = z[HERE + 3 * form + k, c]


@uncounted
def _equations(pair, own, base, table, s, hs, z):
    """Rows ZEROTH.. of z: the equations of a pair; False where one cannot hold.

    own, base: first rows of the forms of either body.  An edge of degree 4 touches a surface where both forms vanish
    and their derivatives along the chart are parallel.
    """
    row = ZEROTH
    if pair[OWN_FORM] >= 0:
        _own_model(table, own, pair[OWN_FORM], s, hs, z, pair[DEEP], ZEROTH)
        if abs(z[ZEROTH, VALUE]) > reach(z, ZEROTH):
            return False
        row = SPARE if pair[DEEP] > 0 else FIRST_ROW
    model(table, base + pair[FORM], s, hs, z, pair[DEEP], row)
    if abs(z[row, VALUE]) > reach(z, row):
        return False
    if row == SPARE:
        parallel(z)
    if pair[OTHER_FORM] >= SECOND_CUT:
        _own_model(table, own, pair[OTHER_FORM] - SECOND_CUT, s, hs, z, PLAIN, ZEROTH + pair[EQUATIONS] - 1)
    elif pair[OTHER_FORM] >= 0:
        model(table, base + pair[OTHER_FORM], s, hs, z, PLAIN, ZEROTH + pair[EQUATIONS] - 1)
    for k in range(ZEROTH + 1, ZEROTH + pair[EQUATIONS]):
        if abs(z[k, VALUE]) > reach(z, k):
            return False
    return True


@uncounted
def _members(chart, pair, known, side, s, hs, layout, program, table, z, stack):
    """False where the box has no point in the other closed model, or none in its own.

    pair: bits of the other's forms that vanish; known: the box's bits, which are added to.  The stack keeps the signs
    of the other's forms.
    """
    found = membership(
        program, layout[side, OTHER_BEGIN], layout[side, OTHER_END], pair, known[NEGATIVE_THERE], known[POSITIVE_THERE],
        layout[side, OTHER], table, s, hs, z, THERE, stack,
    )  # fmt: skip
    if not found & INSIDE:
        return False
    known[NEGATIVE_THERE], known[POSITIVE_THERE], open_there = stack[NEGATIVE], stack[POSITIVE], stack[OPEN]
    if known[IN_OWN]:
        return True
    found = membership(
        program, layout[side, OWN_BEGIN], layout[side, OWN_END], chart[ON], PLAIN, PLAIN, layout[side, OWN], table, s,
        hs, z, HERE, stack,
    )  # fmt: skip
    known[IN_OWN] = stack[OPEN] == 0
    stack[NEGATIVE], stack[POSITIVE], stack[OPEN] = known[NEGATIVE_THERE], known[POSITIVE_THERE], open_there
    return found & INSIDE > 0


@uncounted
def _may_hold(pairs, p, own, base, table, s, hs, z, stack):
    """Whether all equations of a pair may hold, from the models of open forms that membership in the other left."""
    form = pairs[p, FORM]
    if sign(table, base, form, s, hs, z, THERE, stack) != INSIDE | OUTSIDE:
        return False
    if pairs[p, OWN_FORM] >= 0:
        return _equations(pairs[p], own, base, table, s, hs, z)
    row = THERE + 3 * form
    for k in range(1, pairs[p, DEEP] + 1):
        if abs(z[row + k, VALUE]) > reach(z, row + k):
            return False
    other = pairs[p, OTHER_FORM]
    return other < 0 or sign(table, base, other, s, hs, z, THERE, stack) == INSIDE | OUTSIDE


@uncounted
def _size(z, row, second):
    size = 0.0
    for i in range(4):
        size = max(size, abs(z[row, i]) + abs(z[second, i]))
    return size


@uncounted
def _cut(box, params, side, hs, z):
    """How to go on with a box that stays."""
    weight = z[MID, 3]
    way_u, way_v = _size(z, BY_U, UU) * z[SLAB, STRETCH + side], _size(z, BY_V, VV) * z[SLAB, STRETCH + side]
    way_t = z[SLAB, TRAVEL + side] * hs * weight
    if box[PAIR] == STILL:
        if max(way_u, way_v) < STILL_NARROW * z[SLAB, STRETCH + side] * weight:
            return LATER
        return CUT_U if way_u >= way_v else CUT_V
    largest = max(way_u, way_v, way_t) + 1e-300
    total = z[SHARES, 0] + z[SHARES, 1] + z[SHARES, 2]
    if total == 0.0 or params == 0:  # nothing is open but what rounding errors leave open
        return LATER
    if hs < BRIEF:  # zeros may come in curves: earlier times first
        return LATER
    t = (z[SHARES, 0] / total + 1e-3) * (1.0 + way_t / largest)
    u, v = 0.0, 0.0
    if box[HALF_U] > NARROW * (1.0 + abs(box[AT_U])):
        u = (z[SHARES, 1] / total + 1e-3) * (1.0 + way_u / largest)
    if box[HALF_V] > NARROW * (1.0 + abs(box[AT_V])):
        v = (z[SHARES, 2] / total + 1e-3) * (1.0 + way_v / largest)
    if t >= u and t >= v:
        return LATER
    return CUT_U if u >= v else CUT_V


@uncounted
def _place_box_at(box, chart, own, charts, table, z):
    """(whether the box has finite points only, middle and half-width of its time in the slab); models of its cuts."""
    s = (0.5 * (box[BEGIN] + box[END]) - z[SLAB, MIDDLE]) / z[SLAB, HALF]
    hs = 0.5 * (box[END] - box[BEGIN]) / z[SLAB, HALF] + 4.0 * U * (1.0 + abs(z[SLAB, MIDDLE]) / z[SLAB, HALF])
    t, ht = 0.5 * (box[BEGIN] + box[END]), hs * z[SLAB, HALF]
    for k in range(chart[CUTS]):
        place_box(charts, int(box[CHART]) + 1 + k, box[AT_U], box[HALF_U], box[AT_V], box[HALF_V], t, ht, z)
        model(table, own + k, s, hs, z, DEEPEST, HERE + 3 * k)
    return place_box(charts, int(box[CHART]), box[AT_U], box[HALF_U], box[AT_V], box[HALF_V], t, ht, z), s, hs


@uncounted
def _narrow_box(box, params, s, hs, z, n):
    """The share of its widest narrowing that is left of the box; negative if nothing is."""
    if not narrow(z, n, params):
        return -1.0
    left = 1.0
    for k in range(params):
        left = min(left, 0.5 * (z[RANGES + k, 1] - z[RANGES + k, 0]))
        at = AT_U + 2 * k
        u, h = box[at], box[at + 1]
        box[at] = u + 0.5 * (z[RANGES + k, 0] + z[RANGES + k, 1]) * h
        box[at + 1] = min(h, 0.5 * (z[RANGES + k, 1] - z[RANGES + k, 0]) * h + 4.0 * U * (abs(u) + h))
    pad, before = 4.0 * U * (abs(z[SLAB, MIDDLE]) + z[SLAB, HALF]), box[END] - box[BEGIN]
    box[BEGIN] = max(box[BEGIN], (s + hs * z[RANGES + 2, 0]) * z[SLAB, HALF] + z[SLAB, MIDDLE] - pad)
    box[END] = min(box[END], (s + hs * z[RANGES + 2, 1]) * z[SLAB, HALF] + z[SLAB, MIDDLE] + pad)
    if box[BEGIN] > box[END]:
        return -1.0
    return min(left, (box[END] - box[BEGIN]) / before) if before > 0.0 else left


@uncounted
def _bits(pair):
    """Of the other body's forms that vanish where the pair touches."""
    bits = np.int64(1) << pair[FORM]
    if 0 <= pair[OTHER_FORM] < SECOND_CUT:
        bits |= np.int64(1) << pair[OTHER_FORM]
    return bits


@uncounted
def visit(box, known, charts, info, pairs, layout, program, table, z, stack, c):
    """What becomes of a box in the slab; it may be narrowed.  The pairs of EACH_PAIR are left in the stack, after
    their number."""
    chart = info[int(box[CHART])]
    side, base = chart[BODY], layout[chart[BODY], OTHER]
    z[SHARES, 0] = z[SHARES, 1] = z[SHARES, 2] = 0.0
    finite, s, hs = _place_box_at(box, chart, layout[side, OWN], charts, table, z)
    if not finite:
        return CUT_U if box[HALF_U] >= box[HALF_V] else CUT_V
    c[VISITS] += 1
    on = PLAIN
    if box[PAIR] >= 0:
        on = _bits(pairs[int(box[PAIR])])
    if box[PAIR] < 0 and not _members(
        chart, on, known, side, s, hs, layout, program, table, z, stack
    ):
        return DEAD
    if box[PAIR] == STILL:
        return _cut(box, chart[PARAMS], side, hs, z)
    first, end, number = chart[FIRST_PAIR], chart[END_PAIR], 0
    most = FEW
    if chart[PARAMS] == 0 or _size(z, FIRST_ORDER, SECOND_ORDER) < SMALL * z[MID, 3]:
        most = ROOM - 8
    if box[PAIR] >= 0:
        first = int(box[PAIR])
        end = first + 1
    p = first
    if on & (known[NEGATIVE_THERE] | known[POSITIVE_THERE]):
        return DEAD
    while p < end:
        c[TESTS] += 1
        if box[PAIR] == ALL_PAIRS:
            if _may_hold(pairs, p, layout[side, OWN], base, table, s, hs, z, stack):
                stack[number + 1] = p
                number += 1
                if number > most:
                    break
            p += 1
            continue
        left = -1.0
        if _equations(pairs[p], layout[side, OWN], base, table, s, hs, z):
            left = _narrow_box(box, chart[PARAMS], s, hs, z, pairs[p, EQUATIONS])
        if left < 0.0:
            return DEAD
        if left < 1.0:
            finite, s, hs = _place_box_at(box, chart, layout[side, OWN], charts, table, z)
        number += 1
        if left > 0.5 or number > 3:
            break
    if box[PAIR] >= 0:
        for row in range(pairs[first, EQUATIONS]):
            add_shares(z, ZEROTH + row)
        is_sharp = z[SHARES, 0] + z[SHARES, 1] + z[SHARES, 2] == 0.0
        if not _members(chart, on, known, side, s, hs, layout, program, table, z, stack):
            return DEAD
        # zeros in curves that cross the border of a feature askew: all along it boxes would be cut for ever
        if is_sharp and max(_size(z, BY_U, UU), _size(z, BY_V, VV)) < FINE * z[MID, 3]:
            return LATER
    else:
        if number == 0:
            return DEAD
        if number <= most:
            stack[0] = number
            return EACH_PAIR
    return _cut(box, chart[PARAMS], side, hs, z)


@uncounted
def _cost(box, info):
    """A visit, and as many tests as it may take."""
    if box[PAIR] >= 0:
        return 2
    chart = info[int(box[CHART])]
    return 1 if box[PAIR] == STILL else 1 + chart[END_PAIR] - chart[FIRST_PAIR]


@uncounted
def _copied(source, known, i, target, told, j):
    for k in range(8):
        target[j, k] = source[i, k]
    for k in range(KNOWN):
        told[j, k] = known[i, k]


@uncounted
def search(
    charts, info, pairs, layout, program, raw, kinds, units, ma, mb, w, models, table, z, stack,
    frames, pool, known, work, told, count, first, last, least, stop, result, c,
):  # fmt: skip
    """FREE: nothing begins to touch in [first, last]; STOPPED: result holds a slab of at most `least` whose boxes
    (the number of them is result[2], rows of the pool from result[3] on) survive, all before it is free; SPENT: all
    before result[0] is; SLICE_SPENT: with the next box visits and tests might exceed `stop`: called again with all as
    it was left and a later `stop`, the search goes on as if it had never ended.

    pool, known: `count` boxes to start with, and bits for each; work, told: as large.
    first = last: boxes are only asked whether they hold a common point.
    """
    going, depth = result[GOING] > 0.0, int(result[DEPTH])
    result[GOING] = 0.0
    if not going:
        frames[0, 0], frames[0, 1], frames[0, 2], frames[0, 3] = first, last, 0.0, float(count)
        depth = 1
    while going or depth > 0:
        if going:
            t0, t1, lo, hi = result[0], result[1], result[SOONEST], result[LATEST]
            start, kept, todo = int(result[START]), int(result[KEPT]), int(result[TODO])
            going = False
        else:
            depth -= 1
            t0, t1 = frames[depth, 0], frames[depth, 1]
            start, end = int(frames[depth, 2]), int(frames[depth, 3])
            result[0], result[1] = t0, t1
            c[SLABS] += 1
            todo = end - start
            if todo == 0:
                continue
            kept, lo, hi = start, math.inf, -math.inf
            if place_slab(t0, t1, ma, mb, raw, kinds, units, layout, w, models, table, z):
                for k in range(todo):
                    _copied(pool, known, start + k, work, told, k)
            elif t1 - t0 > least:
                kept, lo, hi, todo = end, t0, t1, 0
            else:
                return SPENT
        while todo > 0:
            if c[VISITS] + c[TESTS] + _cost(work[todo - 1], info) > stop:
                result[GOING], result[DEPTH], result[START], result[KEPT] = 1.0, float(depth), float(start), float(kept)
                result[TODO], result[SOONEST], result[LATEST] = float(todo), lo, hi
                return SLICE_SPENT
            if todo + ROOM > work.shape[0] or kept + ROOM > pool.shape[0]:
                return SPENT
            todo -= 1
            box = work[todo]
            box[BEGIN], box[END] = max(box[BEGIN], t0), min(box[END], t1)
            fate = visit(box, told[todo], charts, info, pairs, layout, program, table, z, stack, c)
            if fate == LATER:
                if first == last:
                    return STOPPED
                lo, hi = min(lo, box[BEGIN]), max(hi, box[END])
                _copied(work, told, todo, pool, known, kept)
                kept += 1
            elif fate == CUT_U or fate == CUT_V:
                at = AT_U if fate == CUT_U else AT_V
                h = 0.5 * box[at + 1]
                _copied(work, told, todo, work, told, todo + 1)
                work[todo, at] -= h
                work[todo + 1, at] += h
                work[todo, at + 1] = work[todo + 1, at + 1] = h * (1.0 + 1e-15) + 2.0 * U * abs(box[at])
                todo += 2
            elif fate == EACH_PAIR:
                number = stack[0]
                for k in range(number - 1, -1, -1):
                    _copied(work, told, todo, work, told, todo + k)
                    work[todo + k, PAIR] = stack[1 + k]
                todo += number
        if kept == start:
            continue
        if hi - lo <= least:
            result[0], result[1], result[2], result[3] = lo, hi, float(kept - start), float(start)
            return STOPPED
        if depth + 3 > frames.shape[0] or 2 * kept - start + ROOM > pool.shape[0]:
            return SPENT
        if hi - lo < 0.6 * (t1 - t0):
            frames[depth, 0], frames[depth, 1], frames[depth, 2], frames[depth, 3] = lo, hi, float(start), float(kept)
            depth += 1
            continue
        middle, number = 0.5 * (lo + hi), kept - start
        for k in range(number):
            _copied(pool, known, start + k, work, told, k)
        top = start
        for half in range(2):
            begin = top
            for k in range(number):
                if work[k, END] >= middle if half == 0 else work[k, BEGIN] <= middle:
                    _copied(work, told, k, pool, known, top)
                    top += 1
            frames[depth, 0], frames[depth, 1] = (middle, hi) if half == 0 else (lo, middle)
            frames[depth, 2], frames[depth, 3] = float(begin), float(top)
            depth += 1
    return FREE


@uncounted
def trim(charts, on, form, program, table, boxes, z, stack, fates):
    """Which boxes (rows u, half, v, half) of a chart may hold boundary points: 0 none, 1 some, 2 infinite ones too,
    3 only such.

    The last form is negative around the body; the tree asks it first.  form: one that vanishes at the points, or -1.
    """
    for k in range(boxes.shape[0]):
        fates[k] = 0
        finite = place_box(charts, PLAIN, boxes[k, 0], boxes[k, 1], boxes[k, 2], boxes[k, 3], 0.0, 0.0, z)
        if form >= 0:
            model(table, form, 0.0, 0.0, z, PLAIN, SPARE)
            if abs(z[SPARE, VALUE]) > reach(z, SPARE):
                continue
        if finite:
            found = membership(
                program, PLAIN, program.shape[0], on, PLAIN, PLAIN, PLAIN, table, 0.0, 0.0, z, HERE, stack
            )
            if found == INSIDE | OUTSIDE:
                fates[k] = 1 if stack[OPEN] else 3
        else:
            model(table, table.shape[0] - 1, 0.0, 0.0, z, PLAIN, SPARE)
            fates[k] = 0 if z[SPARE, VALUE] > reach(z, SPARE) else 2
