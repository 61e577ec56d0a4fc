"""Edges, facets and corners of one body, each once; edges and facets as lines and planes.

The line through c and d is Y = (f; k) with f = d - c, k = c x f; whether another line passes above or below it is the
sign of a form that is linear in Y.  So a cell knows, besides the box of its elements, a box of their vectors Y, and
one look tells that a query passes all of them on one side (Schoemer & Thiel 1995, section 5, with cells fitted to the
elements in place of partition trees).  Lines that look alike lie close together in six dimensions, however long they
are.

A facet gives the lines of its two longer sides, both directed away from the corner between them: a line that passes
both on the same side misses the facet.  It also gives its plane (n; -n.a), normalised.

Moments are about `origin` and divided by `scale`, a power of two near the size of the body, so that all entries are of
one order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.search.trees.tree import BARE, CORNER, FACET, FLAT_SIDE, POINT, SIDE, Tree

# Lines and planes have no direction of their own: the one that points this way is taken.
WAY = np.array([1.0, 0.6180339887498949, 0.4142135623730951])


@dataclass(slots=True)
class Elements:
    """Edges, facets or corners of a body, each once, in random order: parts (m, 2) int32 of the tree's parts and the

    masks that mean the element alone there.
    """

    parts: np.ndarray
    corners: np.ndarray
    """(m, 9): corners of the facet, ends of the edge (b twice), or the corner three times."""


def edges_of(tree: Tree, flat: bool = False) -> Elements:
    """The edges that count for a first contact; or all of them, those on flat sides too."""
    corners = ((0, 1, 1), (1, 2, 2), (2, 0, 0))
    sharp = _elements(tree, SIDE, FACET | BARE | POINT, corners)
    if not flat:
        return sharp
    level = _elements(tree, FLAT_SIDE, FACET, corners)
    return Elements(np.concatenate([sharp.parts, level.parts]), np.concatenate([sharp.corners, level.corners]))


def corners_of_tree(tree: Tree) -> Elements:
    return _elements(tree, CORNER, FACET | BARE | POINT, ((0, 0, 0), (1, 1, 1), (2, 2, 2)))


def facets_of(tree: Tree) -> Elements:
    parts = np.flatnonzero(tree.ids[:, 1] & FACET)
    _, first = np.unique(tree.ids[parts, 0], return_index=True)
    parts = parts[np.random.default_rng(0).permutation(first)]
    chosen = np.stack([parts, np.full(len(parts), FACET)], axis=1).astype(np.int32)
    return Elements(chosen, np.ascontiguousarray(tree.xyz[parts]))


def _elements(tree: Tree, bit: int, kinds: int, corners: tuple[tuple[int, int, int], ...]) -> Elements:
    masks = tree.ids[:, 1]
    keys, parts, bits, places = [], [], [], []
    for s in range(3):
        owned = np.flatnonzero(masks & (1 << (bit + s)))
        keys.append(3 * tree.ids[owned, 0].astype(np.int64) + s)
        parts.append(owned)
        bits.append((masks[owned] & kinds) | (1 << (bit + s)))
        places.append(tree.xyz[owned].reshape(-1, 3, 3)[:, corners[s]].reshape(-1, 9))
    # of a triangle cut into parts, several own the element: one stands for it
    _, first = np.unique(np.concatenate(keys), return_index=True)
    chosen = np.random.default_rng(0).permutation(first)
    rows = np.stack([np.concatenate(parts), np.concatenate(bits)], axis=1)[chosen].astype(np.int32)
    return Elements(rows, np.ascontiguousarray(np.concatenate(places)[chosen]))


def frame_of(tree: Tree) -> tuple[np.ndarray, float]:
    """(origin, scale) of lines and planes: the middle of the body and a power of two near its size."""
    box = tree.boxes[0]
    size = float(np.abs(box[3:] - box[:3]).max())
    return 0.5 * (box[:3] + box[3:]), 2.0 ** math.frexp(size)[1] if 0.0 < size < math.inf else 1.0


@kernel
def lift(corners, facets, origin, scale, way):
    """Per element: lines (m or 2m, 6), boxes (m, 6), sizes (m, 3), planes (m or 0, 4)."""
    m = corners.shape[0]
    group = 2 if facets else 1
    lines, boxes = np.empty((group * m, 6)), np.empty((m, 6))
    sizes, planes = np.zeros((m, 3)), np.zeros((m if facets else 0, 4))
    local = np.empty((3, 3))
    for i in range(m):
        x = corners[i]
        for k in range(3):
            boxes[i, k], boxes[i, k + 3] = min(x[k], x[k + 3], x[k + 6]), max(x[k], x[k + 3], x[k + 6])
            for c in range(3):
                local[c, k] = x[3 * c + k] - origin[k]
                sizes[i, 1] = max(sizes[i, 1], abs(local[c, k]))
        apex = _corner_between_longer_sides(local) if facets else 0
        turned = 0.0
        for g in range(group):
            _write_line(local, apex, (apex + 1 + g) % 3, scale, lines[group * i + g])
            y = lines[group * i + g]
            turned += y[0] * way[0] + y[1] * way[1] + y[2] * way[2]
            sizes[i, 0] = max(sizes[i, 0], abs(y[0]) + abs(y[1]) + abs(y[2]))
        if turned < 0.0:
            for g in range(group):
                for k in range(6):
                    lines[group * i + g, k] = -lines[group * i + g, k]
        if facets:
            sizes[i, 2] = _write_plane(local, way, scale, planes[i])
    return lines, boxes, sizes, planes


@uncounted
def _corner_between_longer_sides(x):
    best, apex = np.inf, 0
    for c in range(3):
        i, j = (c + 1) % 3, (c + 2) % 3
        length = abs(x[i, 0] - x[j, 0]) + abs(x[i, 1] - x[j, 1]) + abs(x[i, 2] - x[j, 2])
        if length < best:
            best, apex = length, c
    return apex


@uncounted
def _write_line(x, i, j, scale, out):
    for k in range(3):
        out[k] = x[j, k] - x[i, k]
    for k in range(3):
        p, q = (k + 1) % 3, (k + 2) % 3
        out[3 + k] = (x[i, p] * out[q] - x[i, q] * out[p]) / scale


@uncounted
def _write_plane(x, way, scale, out):
    """Write (n; -n.a / scale) with |n| = 1 in its largest entry; returns S / |n|, inf where there is no plane."""
    size = 0.0
    for k in range(3):
        p, q = (k + 1) % 3, (k + 2) % 3
        e, f = x[1, p] - x[0, p], x[1, q] - x[0, q]
        g, h = x[2, p] - x[0, p], x[2, q] - x[0, q]
        out[k] = e * h - f * g
        size = max(size, abs(e) + abs(f), abs(g) + abs(h))
    largest = max(abs(out[0]), abs(out[1]), abs(out[2]))
    if not largest > 1e-280:
        for k in range(4):
            out[k] = 0.0
        return np.inf
    turn = out[0] * way[0] + out[1] * way[1] + out[2] * way[2]
    s = (-1.0 if turn < 0.0 else 1.0) / largest
    for k in range(3):
        out[k] *= s
    out[3] = -(out[0] * x[0, 0] + out[1] * x[0, 1] + out[2] * x[0, 2]) / scale
    return 1.5 * size / largest  # |e|, |f| in 1-norm
