"""The structure of Schoemer & Thiel 1995, section 3: one half-space level for each conjunct of the linearisation.

A set of edges at rest stands as a tree over their vectors zeta of one feature; each inner node holds, for the feature
of the next conjunct, another such tree over its own edges, and so on.  A query goes through a conjunct's tree; a node
all of whose vectors satisfy the conjunct goes on to the next conjunct in the node's own tree, one all of whose vectors
violate it is left, others are opened; in small sets the conjuncts are asked of edge after edge.  Edges for which every
conjunct holds, or may hold, are put to the pair test, which alone decides.  Conjunctions that begin alike share their
levels.

The paper's bound on a query, n^(1 - 1/d) in d dimensions, needs partition trees, in which a hyperplane crosses few
cells whatever the points.  Here a node is cut at the median across the longest axis of its cell, a box along
principal axes: of linear size, simple, and without such a bound.  Trees below the first are made when first asked, so
that storage is what queries need; n log^k n with k changes of the feature is the most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.principal import CENTRE, RANK, box_columns, fit_box, form_range
from firstcontact.kernels.selection import select
from firstcontact.search.trees.state import CANDIDATES, DONE, FULL, LEAF_ROOM, SLICE_SPENT, VISITS
from firstcontact.search.trees.walk import test_events

WIDTH = 6
"""Entries of a vector; shorter ones end in zeros."""
LEAF = 4
FEW = 4
"""Sets of at most so many edges are asked edge by edge and have no trees for further conjuncts."""

# Columns of a step: the form asked, the sign it must have, the feature of its vectors, and the steps that follow it.
FORM, WAY, FEATURE, NEXT, END, STEP = range(6)
# Slots of a place: present query, whether it has begun, height of the stack, and the tree that is missing.
QUERY, BEGUN, TOP, NODE, WANTED, PLACE = range(6)
# Why a query came back, besides the reasons of `state`.
TREE_MISSING, STACK_FULL = 8, 9


class Levels(NamedTuple):
    """Trees of all levels.  ids: edges; nodes (q, 4): first and last of ids, left and right child (-1: leaf);

    boxes (q, columns): see `principal`; below (q, features): root of the tree of the node's edges by another feature,
    -1 as long as there is none; counts (2,): nodes and ids in use.
    """

    ids: np.ndarray
    nodes: np.ndarray
    boxes: np.ndarray
    below: np.ndarray
    counts: np.ndarray


class Plan(NamedTuple):
    """Conjunctions as a tree of steps (s, STEP) int64; the first `roots` ones begin them."""

    steps: np.ndarray
    roots: int


class EdgeQueries(NamedTuple):
    """Moving edges as queries: forms (k, forms, WIDTH), slacks (k, forms) their errors, parts (k, 2)."""

    forms: np.ndarray
    slacks: np.ndarray
    parts: np.ndarray


def empty_levels(nodes: int, ids: int, features: int) -> Levels:
    return Levels(
        np.empty(ids, np.int32), np.empty((nodes, 4), np.int32), np.empty((nodes, box_columns(WIDTH))),
        np.full((nodes, features), -1, np.int32), np.zeros(2, np.int64),
    )  # fmt: skip


def room_for_tree(levels: Levels, count: int) -> Levels:
    """The levels with room for one more tree over so many edges; those given stay as they are."""
    nodes, ids = (int(x) for x in levels.counts)
    nodes, ids = nodes + 4 * (count // LEAF) + 4, ids + count
    if nodes <= len(levels.nodes) and ids <= len(levels.ids):
        return levels
    larger = empty_levels(max(nodes, 2 * len(levels.nodes)), max(ids, 2 * len(levels.ids)), levels.below.shape[1])
    for old, new in zip(levels, larger, strict=True):
        new[: len(old)] = old
    return larger


@kernel
def add_tree(vectors, first, last, levels):
    """Append the tree over the edges ids[first:last] by their vectors (n, WIDTH), which there is room for; its root."""
    ids, nodes, boxes, counts = levels.ids, levels.nodes, levels.boxes, levels.counts
    root, start, count = counts[0], counts[1], last - first
    ids[start : start + count] = ids[first:last]
    counts[1] += count
    _new_node(nodes, counts, start, start + count)
    keys = np.empty(count)
    moments, axes, weights = np.empty((WIDTH, WIDTH)), np.empty((WIDTH, WIDTH)), np.empty((3, WIDTH))
    node = root
    while node < counts[0]:  # children are behind their parents
        lo, hi = np.int64(nodes[node, 0]), np.int64(nodes[node, 1])
        fit_box(vectors, ids, lo, hi, np.int64(1), boxes[node], np.int64(0), moments, axes, weights)
        if hi - lo > LEAF:
            axis = _longest_axis(boxes[node])
            for i in range(lo, hi):
                keys[i - start] = 0.0
                for k in range(WIDTH):
                    keys[i - start] += boxes[node, axis + k] * vectors[ids[i], k]
            middle = (lo + hi) // 2
            select(keys, ids[start : start + count], lo - start, hi - start, middle - start)
            nodes[node, 2], nodes[node, 3] = counts[0], counts[0] + 1
            _new_node(nodes, counts, lo, middle)
            _new_node(nodes, counts, middle, hi)
        node += 1
    return root


@uncounted
def _longest_axis(box):
    """Where in the box the axis begins along which it is longest."""
    half, longest = CENTRE + WIDTH, 0
    for j in range(int(box[RANK])):
        if box[half + j] > box[half + longest]:
            longest = j
    return half + WIDTH + WIDTH * longest


@uncounted
def _new_node(nodes, counts, first, last):
    node = counts[0]
    nodes[node, 0], nodes[node, 1], nodes[node, 2], nodes[node, 3] = first, last, -1, -1
    counts[0] += 1


@kernel
def ask_levels(levels, vectors, plan, tops, questions, parts, motion, xyz_a, xyz_b, err_a, err_b, sides, limit,
               place, stack, asked, floats, integers, times, candidates):  # fmt: skip
    """Put the questions to the levels, from `place` on; returns why it stopped.

    vectors (features, n, WIDTH).  tops (features,): roots over all edges, one for each feature that a conjunction
    begins with.  parts (n, 2) of the edges at rest.  stack (s, 2): nodes and steps that wait.  asked (n,): the last
    question each edge was tested for.
    """
    waiting = np.empty(plan.steps.shape[0], np.int64)
    nodes, boxes, below, steps = levels.nodes, levels.boxes, levels.below, plan.steps
    for q in range(place[QUERY], questions.parts.shape[0]):
        place[QUERY] = q
        if not place[BEGUN]:
            place[BEGUN], place[TOP] = 1, plan.roots
            for s in range(plan.roots):
                stack[s, 0], stack[s, 1] = tops[steps[s, FEATURE]], s
        while place[TOP] > 0:
            if integers[VISITS] >= limit:
                return SLICE_SPENT
            if place[TOP] + steps.shape[0] + 2 > stack.shape[0]:
                return STACK_FULL
            node, s = stack[place[TOP] - 1, 0], stack[place[TOP] - 1, 1]
            integers[VISITS] += 1
            form = steps[s, FORM]
            value, reach = form_range(boxes[node], 0, questions.forms[q, form], WIDTH)
            value *= steps[s, WAY]
            reach += questions.slacks[q, form]
            if value + reach < 0.0:
                place[TOP] -= 1
                continue
            holds = value - reach >= 0.0
            small = nodes[node, 1] - nodes[node, 0] <= FEW
            if small or (holds and steps[s, NEXT] == steps[s, END]) or (not holds and nodes[node, 2] < 0):
                if not _test_all(
                    levels, node, vectors, plan.steps, s, waiting, q, questions, parts, motion, xyz_a, xyz_b,
                    err_a, err_b, sides, asked, floats, integers, times, candidates,
                ):  # fmt: skip
                    integers[VISITS] -= 1  # comes again
                    return FULL
                place[TOP] -= 1
            elif holds:
                for after in range(steps[s, NEXT], steps[s, END]):
                    if steps[after, FEATURE] != steps[s, FEATURE] and below[node, steps[after, FEATURE]] < 0:
                        place[NODE], place[WANTED] = node, steps[after, FEATURE]
                        integers[VISITS] -= 1
                        return TREE_MISSING
                place[TOP] -= 1
                for after in range(steps[s, NEXT], steps[s, END]):
                    same = steps[after, FEATURE] == steps[s, FEATURE]
                    stack[place[TOP], 0] = node if same else below[node, steps[after, FEATURE]]
                    stack[place[TOP], 1] = after
                    place[TOP] += 1
            else:
                stack[place[TOP] - 1, 0] = nodes[node, 2]
                stack[place[TOP], 0], stack[place[TOP], 1] = nodes[node, 3], s
                place[TOP] += 1
        place[BEGUN] = 0
    place[QUERY] = questions.parts.shape[0]
    return DONE


@uncounted
def _test_all(levels, node, vectors, steps, s, waiting, q, questions, parts, motion, xyz_a, xyz_b, err_a, err_b, sides,
              asked, floats, integers, times, candidates):  # fmt: skip
    """The pair test of question q with the edges of the node for which all conjuncts from step s on may hold.

    Each edge once; False when there is no room for more.
    """
    a = questions.parts[q]
    for i in range(levels.nodes[node, 0], levels.nodes[node, 1]):
        edge = levels.ids[i]
        if asked[edge] == q:
            continue
        if integers[CANDIDATES] + LEAF_ROOM > times.shape[0]:
            return False
        integers[VISITS] += 1
        if _is_ruled_out(vectors, steps, s, waiting, questions, q, edge):
            continue
        asked[edge] = q
        test_events(
            motion, a[0], a[1], xyz_a[a[0]], parts[edge, 0], parts[edge, 1], xyz_b[parts[edge, 0]], sides,
            err_a, err_b, floats, integers, times, candidates,
        )  # fmt: skip
    return True


@uncounted
def _is_ruled_out(vectors, steps, s, waiting, questions, q, edge):
    """Whether every conjunction through step s has a conjunct from there on that the edge certainly violates."""
    waiting[0] = s
    top = 1
    while top > 0:
        top -= 1
        step = steps[waiting[top]]
        y, form = vectors[step[FEATURE], edge], questions.forms[q, step[FORM]]
        value = 0.0
        for k in range(WIDTH):
            value += form[k] * y[k]
        if value * step[WAY] < -questions.slacks[q, step[FORM]]:
            continue
        if step[NEXT] == step[END]:
            return False
        for after in range(step[NEXT], step[END]):
            waiting[top] = after
            top += 1
    return True
