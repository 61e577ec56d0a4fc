"""The walk over two trees for each of many motions, in one call."""

from __future__ import annotations

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
from firstcontact.search.trees.walk import walk

# What a walk left of a motion: proved free; a first contact that is among the candidates; anything else.
FREE, MET, OPEN = range(3)


@uncounted
def walk_each(
    boxes_a, links_a, xyz_a, ids_a, boxes_b, links_b, xyz_b, ids_b,
    motion, motions, lasts, pads, err_a, err_b, most, begin, visits,
    floats, integers, keys, pairs, stack, times, candidates,
    told, work, found_times, found_rows,
):  # fmt: skip
    """Walks over [0, last] for the motions from number `begin` on; (the first one not done, candidates found).

    motion: as `walk` has it, filled in turn with each of motions (n, 9); (0, 9): it is that of all.
    lasts (n, 2): the end of the window, and what is certainly not after it.  pads (n,): as `walk` has it.
    most: pair tests after which a motion is left open, visits: node visits.
    told (n,): FREE, MET or OPEN; work (n,): visits and tests.  Of those that are MET, found_times (k, 2) and
    found_rows (k, 6), motion and candidate, tell all contacts that may be first; it ends when these are full.
    """
    count = 0
    for m in range(begin, len(lasts)):
        if len(motions) > 0:
            for k in range(len(motion)):
                motion[k] = motions[m, k]
        floats[FIRST], floats[SURE_FIRST], floats[SURE_LAST] = 0.0, 0.0, lasts[m, 1]
        floats[BEST], floats[KEY], floats[ALL] = lasts[m, 0], 0.0, 0.0
        for k in range(len(integers)):
            integers[k] = 0
        integers[STACK] = 1
        stack[0, 0], stack[0, 1] = 0, 0
        reason = walk(
            boxes_a, links_a, xyz_a, ids_a, boxes_b, links_b, xyz_b, ids_b,
            motion, err_a, err_b, pads[m], True, False, visits,
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
        if certain:
            told[m] = MET
            count = kept
    return len(lasts), count
