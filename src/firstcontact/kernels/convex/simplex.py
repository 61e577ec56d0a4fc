"""The point of a simplex nearest the origin (Gilbert, Johnson, Keerthi 1988; regions as in Ericson 2005, 5.1).

A simplex is up to four rows of the workspace from SIMPLEX on: a point of the difference a - b, that of a, that of b.
Nothing here is proved: the directions found are judged by `support`.
"""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import SIMPLEX, WEIGHTS


@uncounted
def _on_segment(w, i, j):
    """Weights of rows i and j at the point nearest the origin."""
    length, along = 0.0, 0.0
    for c in range(3):
        length += (w[j, c] - w[i, c]) ** 2
        along -= w[i, c] * (w[j, c] - w[i, c])
    s = along / length if length > 0.0 else 0.0
    s = min(max(s, 0.0), 1.0)
    return 1.0 - s, s


@uncounted
def _on_triangle(w, i, j, k):
    """Weights of rows i, j, k at the point nearest the origin."""
    abx, aby, abz = w[j, 0] - w[i, 0], w[j, 1] - w[i, 1], w[j, 2] - w[i, 2]
    acx, acy, acz = w[k, 0] - w[i, 0], w[k, 1] - w[i, 1], w[k, 2] - w[i, 2]
    d1 = -(abx * w[i, 0] + aby * w[i, 1] + abz * w[i, 2])
    d2 = -(acx * w[i, 0] + acy * w[i, 1] + acz * w[i, 2])
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0
    d3 = -(abx * w[j, 0] + aby * w[j, 1] + abz * w[j, 2])
    d4 = -(acx * w[j, 0] + acy * w[j, 1] + acz * w[j, 2])
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        s = d1 / (d1 - d3)
        return 1.0 - s, s, 0.0
    d5 = -(abx * w[k, 0] + aby * w[k, 1] + abz * w[k, 2])
    d6 = -(acx * w[k, 0] + acy * w[k, 1] + acz * w[k, 2])
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 0.0, 1.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0 and d2 > d6:
        s = d2 / (d2 - d6)
        return 1.0 - s, 0.0, s
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0 and (d4 - d3) + (d5 - d6) > 0.0:
        s = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 0.0, 1.0 - s, s
    total = va + vb + vc
    if total <= 0.0:
        s, r = _on_segment(w, i, j)
        return s, r, 0.0
    return va / total, vb / total, vc / total


@uncounted
def _faces_origin(w, i, j, k, other):
    """Whether the plane of rows i, j, k parts the origin from row `other` (or that one lies in the plane)."""
    abx, aby, abz = w[j, 0] - w[i, 0], w[j, 1] - w[i, 1], w[j, 2] - w[i, 2]
    acx, acy, acz = w[k, 0] - w[i, 0], w[k, 1] - w[i, 1], w[k, 2] - w[i, 2]
    nx, ny, nz = aby * acz - abz * acy, abz * acx - abx * acz, abx * acy - aby * acx
    origin = -(nx * w[i, 0] + ny * w[i, 1] + nz * w[i, 2])
    dx, dy, dz = w[other, 0] - w[i, 0], w[other, 1] - w[i, 1], w[other, 2] - w[i, 2]
    return origin * (nx * dx + ny * dy + nz * dz) <= 0.0


@uncounted
def nearest(w, n):
    """Reduce the simplex of n rows to the part that holds the point nearest the origin; (rows left, x, y, z of it).

    Fills w[WEIGHTS].  Four rows are left only when the origin is inside.
    """
    w[WEIGHTS, 0], w[WEIGHTS, 1], w[WEIGHTS, 2], w[WEIGHTS, 3] = 1.0, 0.0, 0.0, 0.0
    first = SIMPLEX
    if n == 2:
        w[WEIGHTS, 0], w[WEIGHTS, 1] = _on_segment(w, first, first + 1)
    elif n >= 3:
        # a triangle, or the faces of a tetrahedron that part its fourth corner from the origin
        best, inside = 1e300, n == 4
        for face in range(4 if n == 4 else 1):
            i, j, k, other = face, (face + 1) & 3, (face + 2) & 3, (face + 3) & 3
            if n == 4 and not _faces_origin(w, first + i, first + j, first + k, first + other):
                continue
            inside = False
            p, q, r = _on_triangle(w, first + i, first + j, first + k)
            square = 0.0
            for c in range(3):
                x = p * w[first + i, c] + q * w[first + j, c] + r * w[first + k, c]
                square += x * x
            if square < best:
                best = square
                w[WEIGHTS, i], w[WEIGHTS, j], w[WEIGHTS, k], w[WEIGHTS, other] = p, q, r, 0.0
        if inside:
            for c in range(4):
                w[WEIGHTS, c] = 0.25
            return 4, 0.0, 0.0, 0.0
    kept = 0
    x, y, z = 0.0, 0.0, 0.0
    for i in range(n):
        share = w[WEIGHTS, i]
        if share > 0.0:
            w[WEIGHTS, kept] = share
            for c in range(9):
                w[first + kept, c] = w[first + i, c]
            x += share * w[first + kept, 0]
            y += share * w[first + kept, 1]
            z += share * w[first + kept, 2]
            kept += 1
    return kept, x, y, z
