"""The walk over two trees for each of many motions, in one call."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import uncounted
from firstcontact.search.trees.state import (
    ALL,
    BEST,
    CANDIDATES,
    CERTAIN_KIND,
    DONE,
    EDGE_FACE,
    FIRST,
    KEY,
    STACK,
    SURE_FIRST,
    SURE_LAST,
    TESTS,
    UNSURE_TOTAL,
    VISITS,
)
from firstcontact.search.trees.timed import is_before, time_of
from firstcontact.search.trees.translate import lay_motion
from firstcontact.search.trees.walk import walk

# What a walk left of a motion: proved free; a first contact that is among the candidates; one candidate that is the
# first contact, with its time; anything else.
FREE, MET, TIMED, OPEN = range(4)


@uncounted
def walk_each(
    boxes_a, links_a, xyz_a, ids_a, boxes_b, links_b, xyz_b, ids_b,
    motion, vectors, frame, lasts, sure_lasts, error, err_a, err_b, most, begin, visits,
    floats, integers, keys, pairs, stack, times, candidates,
    rests_a, rests_b, told, work, found_times, found_rows,
):  # fmt: skip
    """Walks over [0, last] for the motions from number `begin` on; (the first one not done, candidates found).

    motion: as `walk` has it, laid in turn by each of vectors (n, 3) in the frame (3, 3) of the boxes, (0, 3) where that
    is the parts' own; vectors (0, 3): it is that of all.
    lasts, sure_lasts (n,): ends of the windows, and what is certainly not after them.
    error: what coordinates of boxes are off by, together with those of the other body.
    rests_a, rests_b: what coordinates of parts are off by, (m, 9) each as xyz_a and xyz_b; (0, 9): it is not known.
    most: pair tests after which a motion is left open, visits: node visits.
    told (n,): FREE, MET, TIMED or OPEN; work (n,): visits and tests.  Of those that are MET or TIMED, found_times
    (k, 2) and found_rows (k, 6), motion and candidate, tell all contacts that may be first; it ends when these are
    full.  The times are enclosures; of the one contact of a TIMED motion, as `time_of` tells them.
    """
    count = 0
    timed = len(vectors) > 0 and len(rests_a) > 0
    for m in range(begin, len(lasts)):
        pad = 2.0 * error
        if len(vectors) > 0:
            pad += 2.0 * (lay_motion(vectors[m], frame, motion) * lasts[m])
        floats[FIRST], floats[SURE_FIRST], floats[SURE_LAST] = 0.0, 0.0, sure_lasts[m]
        floats[BEST], floats[KEY], floats[ALL] = lasts[m], 0.0, 0.0
        for k in range(len(integers)):
            integers[k] = 0
        integers[STACK] = 1
        stack[0, 0], stack[0, 1] = 0, 0
        reason = walk(
            boxes_a, links_a, xyz_a, ids_a, boxes_b, links_b, xyz_b, ids_b,
            motion, err_a, err_b, pad, True, False, visits,
            floats, integers, keys, pairs, stack, times, candidates,
        )  # fmt: skip
        work[m] = integers[VISITS] + integers[TESTS]
        told[m] = OPEN
        if reason != DONE or integers[TESTS] > most or integers[UNSURE_TOTAL] > 0:
            continue
        n, best = integers[CANDIDATES], floats[BEST]
        if n == 0:
            told[m] = FREE
            continue
        if count + n > len(found_times):
            if n <= len(found_times):
                return m, count
            continue
        certain = True
        kept = count
        for k in range(n):
            certain = certain and CERTAIN_KIND <= candidates[k, 0] < CERTAIN_KIND + EDGE_FACE
            if times[k, 0] <= best:
                found_times[kept, 0], found_times[kept, 1] = times[k, 0], times[k, 1]
                found_rows[kept, 0] = m
                for j in range(5):
                    found_rows[kept, j + 1] = candidates[k, j]
                kept += 1
        if not certain:
            continue
        told[m] = MET
        if timed and _first_alone(
            xyz_a, rests_a, xyz_b, rests_b, vectors, m, found_times, found_rows, count, kept, times
        ):
            told[m] = TIMED
            kept = count + 1
        count = kept
    return len(lasts), count


@uncounted
def _first_alone(xyz_a, rests_a, xyz_b, rests_b, vectors, m, found_times, found_rows, first, end, times):
    """Whether one contact of rows first to end is certainly before all others; then it becomes the first row.

    times: room for as many.
    """
    v0, v1, v2 = vectors[m, 0], vectors[m, 1], vectors[m, 2]
    best, until = first, np.inf
    for k in range(first, end):
        times[k - first, 0] = np.inf
        if found_times[k, 0] > until:
            continue
        until = min(until, found_times[k, 1])
        pa, sa, pb, sb = found_rows[k, 2], found_rows[k, 3], found_rows[k, 4], found_rows[k, 5]
        t, r = time_of(
            found_rows[k, 1] - CERTAIN_KIND, xyz_a[pa], rests_a[pa], sa, xyz_b[pb], rests_b[pb], sb, v0, v1, v2
        )
        if np.isnan(t):
            return False
        times[k - first, 0], times[k - first, 1] = t, r
        if t < times[best - first, 0]:
            best = k
    t, r = times[best - first, 0], times[best - first, 1]
    for k in range(end - first):
        if k != best - first and times[k, 0] < np.inf and not is_before(t, r, times[k, 0], times[k, 1]):
            return False
    found_times[first, 0], found_times[first, 1] = t, r
    for j in range(6):
        found_rows[first, j] = found_rows[best, j]
    return True
