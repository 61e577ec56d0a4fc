"""The point of a simplex nearest the origin (Gilbert, Johnson, Keerthi 1988; regions as in Ericson 2005, 5.1).

A simplex is rows (4, 9): a point w of the difference a - b, and the points a and b.  Nothing here is proved: the
directions found are judged by `support`.
"""

from __future__ import annotations

from firstcontact.kernels.jit import kernel


@kernel
def _dot(rows, i, j):
    return rows[i, 0] * rows[j, 0] + rows[i, 1] * rows[j, 1] + rows[i, 2] * rows[j, 2]


@kernel
def _on_segment(rows, i, j):
    """Weights of rows i and j at the point nearest the origin."""
    ii, ij, jj = _dot(rows, i, i), _dot(rows, i, j), _dot(rows, j, j)
    length = ii - 2.0 * ij + jj
    s = (ii - ij) / length if length > 0.0 else 0.0
    s = min(max(s, 0.0), 1.0)
    return 1.0 - s, s


@kernel
def _on_triangle(rows, i, j, k):
    """Weights of rows i, j, k at the point nearest the origin."""
    abx, aby, abz = rows[j, 0] - rows[i, 0], rows[j, 1] - rows[i, 1], rows[j, 2] - rows[i, 2]
    acx, acy, acz = rows[k, 0] - rows[i, 0], rows[k, 1] - rows[i, 1], rows[k, 2] - rows[i, 2]
    d1 = -(abx * rows[i, 0] + aby * rows[i, 1] + abz * rows[i, 2])
    d2 = -(acx * rows[i, 0] + acy * rows[i, 1] + acz * rows[i, 2])
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0
    d3 = -(abx * rows[j, 0] + aby * rows[j, 1] + abz * rows[j, 2])
    d4 = -(acx * rows[j, 0] + acy * rows[j, 1] + acz * rows[j, 2])
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        s = d1 / (d1 - d3)
        return 1.0 - s, s, 0.0
    d5 = -(abx * rows[k, 0] + aby * rows[k, 1] + abz * rows[k, 2])
    d6 = -(acx * rows[k, 0] + acy * rows[k, 1] + acz * rows[k, 2])
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
        s, r = _on_segment(rows, i, j)
        return s, r, 0.0
    return va / total, vb / total, vc / total


@kernel
def _faces_origin(rows, i, j, k, other):
    """Whether the plane of rows i, j, k parts the origin from row `other` (or that one lies in the plane)."""
    abx, aby, abz = rows[j, 0] - rows[i, 0], rows[j, 1] - rows[i, 1], rows[j, 2] - rows[i, 2]
    acx, acy, acz = rows[k, 0] - rows[i, 0], rows[k, 1] - rows[i, 1], rows[k, 2] - rows[i, 2]
    nx, ny, nz = aby * acz - abz * acy, abz * acx - abx * acz, abx * acy - aby * acx
    origin = -(nx * rows[i, 0] + ny * rows[i, 1] + nz * rows[i, 2])
    dx, dy, dz = rows[other, 0] - rows[i, 0], rows[other, 1] - rows[i, 1], rows[other, 2] - rows[i, 2]
    return origin * (nx * dx + ny * dy + nz * dz) <= 0.0


@kernel
def nearest(rows, n, weights):
    """Reduce the simplex to the part that holds the point nearest the origin; (number of rows, x, y, z of it).

    Fills weights (4,).  Four rows are left only when the origin is inside.
    """
    weights[0], weights[1], weights[2], weights[3] = 1.0, 0.0, 0.0, 0.0
    if n == 2:
        weights[0], weights[1] = _on_segment(rows, 0, 1)
    elif n == 3:
        weights[0], weights[1], weights[2] = _on_triangle(rows, 0, 1, 2)
    elif n == 4:
        best, inside = 1e300, True
        for face in range(4):
            i, j, k, other = face, (face + 1) & 3, (face + 2) & 3, (face + 3) & 3
            if not _faces_origin(rows, i, j, k, other):
                continue
            inside = False
            p, q, r = _on_triangle(rows, i, j, k)
            square = 0.0
            for c in range(3):
                x = p * rows[i, c] + q * rows[j, c] + r * rows[k, c]
                square += x * x
            if square < best:
                best = square
                weights[i], weights[j], weights[k], weights[other] = p, q, r, 0.0
        if inside:
            for c in range(4):
                weights[c] = 0.25
            return 4, 0.0, 0.0, 0.0
    kept = 0
    x, y, z = 0.0, 0.0, 0.0
    for i in range(n):
        if weights[i] > 0.0:
            weights[kept] = weights[i]
            for c in range(9):
                rows[kept, c] = rows[i, c]
            x += weights[kept] * rows[kept, 0]
            y += weights[kept] * rows[kept, 1]
            z += weights[kept] * rows[kept, 2]
            kept += 1
    return kept, x, y, z
