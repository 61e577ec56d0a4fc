"""Edges, closedness and components of a triangle mesh, in linear time."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted


@kernel
def derive_edges(triangles, n_vertices):
    """Unique edges of the triangles' sides and what lies along them.

    triangles: (m, 3) int32.  Returns
    edges      (k, 2) int32, i < j, sorted;
    side_edge  (m, 3) int32, edge of the side (corner s, corner s+1), -1 where both corners coincide;
    count      (k,) int32, number of sides along each edge;
    balance    (k,) int32, sides running i -> j minus sides running j -> i;
    """
    m = triangles.shape[0]
    start = np.zeros(n_vertices + 1, np.int64)
    for t in range(m):
        for s in range(3):
            i, j = triangles[t, s], triangles[t, (s + 1) % 3]
            if i != j:
                start[min(i, j) + 1] += 1
    for v in range(n_vertices):
        start[v + 1] += start[v]
    fill = start[:-1].copy()
    far = np.empty(start[n_vertices], np.int32)
    side = np.empty(start[n_vertices], np.int64)
    for t in range(m):
        for s in range(3):
            i, j = triangles[t, s], triangles[t, (s + 1) % 3]
            if i == j:
                continue
            lo = min(i, j)
            far[fill[lo]], side[fill[lo]] = max(i, j), 3 * t + s
            fill[lo] += 1
    for v in range(n_vertices):
        _sort_bucket(far, side, start[v], start[v + 1])
    side_edge = np.full((m, 3), -1, np.int32)
    edges = np.empty((far.size, 2), np.int32)
    count = np.zeros(far.size, np.int32)
    balance = np.zeros(far.size, np.int32)
    n_edges = 0
    for v in range(n_vertices):
        for k in range(start[v], start[v + 1]):
            if k == start[v] or far[k] != far[k - 1]:
                edges[n_edges, 0], edges[n_edges, 1] = v, far[k]
                n_edges += 1
            t, s = side[k] // 3, side[k] % 3
            side_edge[t, s] = n_edges - 1
            count[n_edges - 1] += 1
            balance[n_edges - 1] += 1 if triangles[t, s] == v else -1
    return edges[:n_edges].copy(), side_edge, count[:n_edges].copy(), balance[:n_edges].copy()


@uncounted
def _sort_bucket(far, side, first, last):
    """Sort far[first:last] ascending and carry `side` along (Shell 1959): most buckets hold a few, some thousands."""
    gap = 1
    while gap < (last - first) // 9:
        gap = 3 * gap + 1
    while gap > 0:
        for k in range(first + gap, last):
            f, s = far[k], side[k]
            j = k
            while j >= first + gap and far[j - gap] > f:
                far[j], side[j] = far[j - gap], side[j - gap]
                j -= gap
            far[j], side[j] = f, s
        gap //= 3


@kernel
def component_of_vertices(segments, n_vertices):
    """(n,) int32: smallest vertex of the connected component of every vertex.

    segments: (k, 2) int32 pairs of vertices that belong together.
    """
    parent = np.arange(n_vertices).astype(np.int32)
    for k in range(segments.shape[0]):
        i, j = segments[k, 0], segments[k, 1]
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        while parent[j] != j:
            parent[j] = parent[parent[j]]
            j = parent[j]
        if i < j:
            parent[j] = i
        else:
            parent[i] = j
    for v in range(n_vertices):
        i = v
        while parent[i] != i:
            i = parent[i]
        parent[v] = i
    return parent


def weld(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merge vertices with equal coordinates; (n, 3) float64 and (m, 3) indices, first occurrence kept."""
    plus_zero = np.ascontiguousarray(vertices + 0.0)  # -0.0 equals 0.0
    keys = plus_zero.view(np.dtype((np.void, 24))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(order.size)
    return vertices[first[order]], rank[inverse.ravel()][faces]
