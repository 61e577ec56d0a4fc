"""The triangles of a tree against convex pieces, both moving: best first by the time to which a box is proved free.

A box of the tree is itself a convex piece, so the strides of `kernels.convex.advancement` prove it apart from a piece
for some time.  The pair whose proof reaches least far is opened next; so the pairs left are all free until its time.
"""

from __future__ import annotations

from firstcontact.kernels.convex.advancement import FREE, advance_pieces, directed, stride, toward
from firstcontact.kernels.convex.flat import MADE, ONLY, middle_of, write_box, write_triangle
from firstcontact.kernels.convex.separation import placed
from firstcontact.kernels.convex.shared_point import proves_shared
from firstcontact.kernels.convex.support import BOX
from firstcontact.kernels.convex.touch_system import local_point, place_frames
from firstcontact.kernels.heap import heap_pop, heap_push
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.poses import pose_at
from firstcontact.kernels.workspace import HERE_A, HERE_B, POSE_B, SIDE_A

# Why a walk stops: nothing is left, a triangle is not proved free, the heap is full, the visits asked for are done.
DONE, TRIANGLE, FULL, SLICE = range(4)
# Slots of the integers of a walk: pairs on the heap, visits so far; of the triangle: its part, the piece, its outcome.
COUNT, VISITS, PART, PIECE, OUTCOME = range(5)
# Strides for one box at most, and the share of all its strides below which one is the last.
STRIDES, WORTH = 6, 0.2


@uncounted
def free_until(p, mp, q, j, mq, t, limit, back, w, c):
    """A time in [t, limit] until which piece 0 of p, a box, is proved apart from piece j of q; t proves nothing.

    Before the limit it is `back` less than what was proved: a search that starts nearer to a contact has directions of
    bad precision.
    """
    pose_at(mp, t, w, HERE_A)
    pose_at(mq, t, w, HERE_B)
    x0, x1, x2 = placed(w, HERE_A, p[0, BOX], p[0, BOX + 1], p[0, BOX + 2])
    y0, y1, y2 = placed(w, HERE_B, q[j, BOX], q[j, BOX + 1], q[j, BOX + 2])
    n0, n1, n2 = y0 - x0, y1 - x1, y2 - x2
    if n0 == 0.0 and n1 == 0.0 and n2 == 0.0:
        n0 = 1.0
    s = t
    for _ in range(STRIDES):
        _, n0, n1, n2, _, g = directed(p, ONLY, mp, q, j, mq, s, n0, n1, n2, w, c)
        if not g > 0.0:
            break
        before = s
        s, g = stride(p, ONLY, mp, q, j, mq, s, g, limit, n0, n1, n2, w, c)
        if s >= limit:
            return limit
        if not s - before > WORTH * (s - t):
            break
    return max(t, s - back)


@uncounted
def _free_by(p, mp, q, j, mq, t, limit, hint, w, c):
    """Whether a triangle is proved apart until the limit, at which the direction of the best contact parts it too."""
    e0, e1, e2 = hint[0], hint[1], hint[2]
    if e0 == 0.0 and e1 == 0.0 and e2 == 0.0:
        return False
    _, n0, n1, n2, _, g = directed(p, ONLY, mp, q, j, mq, t, e0, e1, e2, w, c)
    return g > 0.0 and toward(p, ONLY, mp, q, j, mq, t, g, limit, n0, n1, n2, e0, e1, e2, w, c)[0] >= limit


@uncounted
def walk(
    tree, links, error, xyz, p, mp, q, mq, limit, back, inner, width, budget, visits, hint, keys, pairs, state, w, c
):
    """Go on until one of the reasons above; keys[0] is then a time until which all that is left is proved free.

    tree (n, 6), links (n, 2), error, xyz (m, 9): boxes, children and parts of the tree; p: rows for one piece of it,
    q: the pieces met; mp, mq: their motions; limit: what is free until then is of no interest; back: as for
    `free_until`; inner, width, budget: as for `advance_pieces`; visits: when to stop; hint (3,): the normal of the
    contact at the limit, zero without one; keys, pairs: the heap.
    """
    n = state[COUNT]
    while n > 0 and keys[0] < limit:
        if state[VISITS] >= visits:
            state[COUNT] = n
            return SLICE
        if n + 2 > keys.shape[0]:
            state[COUNT] = n
            return FULL
        t, node, j = keys[0], pairs[0, 0], pairs[0, 1]
        n = heap_pop(keys, pairs, n)
        state[VISITS] += 1
        if links[node, 1] < 0:
            write_triangle(p, xyz[links[node, 0]], error)
            if _free_by(p, mp, q, j, mq, t, limit, hint, w, c):
                continue
            outcome = advance_pieces(p, ONLY, mp, q, j, mq, t, limit, inner, width, budget, w, c)
            if outcome != FREE:
                state[COUNT], state[PART], state[PIECE], state[OUTCOME] = n, links[node, 0], j, outcome
                return TRIANGLE
            continue
        for side in range(2):
            child = links[node, side]
            write_box(p, tree[child], error)
            s = free_until(p, mp, q, j, mq, t, limit, back, w, c)
            if s < limit:
                n = heap_push(keys, pairs, n, s, child, j)
    state[COUNT] = n
    return DONE


@uncounted
def point_inside(p, mp, q, j, mq, t, w):
    """(proved, x, y, z): a point in the frame of the tree's body, proved to lie inside piece j of q at time t."""
    if not place_frames(mp, mq, t, w):
        return False, 0.0, 0.0, 0.0
    x, y, z = middle_of(q, j)
    x, y, z = placed(w, POSE_B, x, y, z)
    p[MADE, 0], p[MADE, 1], p[MADE, 2] = local_point(w, SIDE_A, x, y, z)
    p[MADE, 3] = 0.0
    proved = proves_shared(p, ONLY, q, j, w, SIDE_A, MADE, x, y, z)
    return proved, p[MADE, 0], p[MADE, 1], p[MADE, 2]
