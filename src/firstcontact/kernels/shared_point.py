"""Proof that two convex pieces in poses share a point: one at which every form is below its rounding error."""

from __future__ import annotations

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.separation import placed
from firstcontact.kernels.support import form_gradient, form_value
from firstcontact.kernels.touch_system import local_point, moving_form, solve

U = 2.0**-53
# Relative rounding error of a form: three of each coefficient, twelve of the sum; see test_form_bound.
FORM_EPS = 20.0 * U


@kernel
def _inside(p, i, y0, y1, y2, off):
    """Whether all points within `off` (per coordinate) of a local point are certainly inside piece i."""
    for k in range(p.ranges[i, 6], p.ranges[i, 7]):
        value, size = form_value(p.leaves, k, y0, y1, y2)
        margin = FORM_EPS * size
        if off > 0.0:
            g0, g1, g2 = form_gradient(p.leaves, k, y0, y1, y2)
            bend = 0.0
            for c in range(6):
                bend += abs(p.leaves[k, c])
            margin += 1.0001 * ((abs(g0) + abs(g1) + abs(g2)) * off + bend * off * off) + FORM_EPS * size
        if value + margin > 0.0:
            return False
    return True


@kernel
def _inverse_bound(pose, inverse):
    """Bound of the largest row sum of |R^-1|, -1 where the computed inverse proves none."""
    norm, defect = 0.0, 0.0
    for r in range(3):
        row, off = 0.0, 0.0
        for c in range(3):
            row += abs(inverse[3 * r + c])
            e = inverse[3 * r] * pose[c] + inverse[3 * r + 1] * pose[3 + c] + inverse[3 * r + 2] * pose[6 + c]
            off += abs(e - (1.0 if r == c else 0.0))
        norm, defect = max(norm, row), max(defect, off)
    defect += norm * 3.0 * pose[12] + 1e-14
    return norm / (1.0 - defect) if defect < 0.5 else -1.0


@kernel
def proves_shared(a, i, b, j, frames, x, y, z, vertex_a, vertex_b):
    """True proves that the pieces share a point, near (x, y, z), in the poses of `frames`.

    vertex_a, vertex_b: number of a vertex that is the point, -1 for none; it is in its piece by itself.
    """
    first, second = (a, b) if vertex_b < 0 else (b, a)
    i, j = (i, j) if vertex_b < 0 else (j, i)
    own, other = (0, 1) if vertex_b < 0 else (1, 0)
    number = max(vertex_a, vertex_b)
    pose, far = frames[own], frames[other]
    # the point is exactly R y + T of the first body, for the doubles y or the true vertex near them
    off = 0.0
    if number >= 0:
        y0, y1, y2 = first.vertices[number, 0], first.vertices[number, 1], first.vertices[number, 2]
        off = first.vertices[number, 3]
    else:
        y0, y1, y2 = local_point(pose, frames[4 + own], x, y, z)
        if not _inside(first, i, y0, y1, y2, 0.0):
            return False
    x, y, z = placed(pose, y0, y1, y2)
    z0, z1, z2 = local_point(far, frames[4 + other], x, y, z)
    u, v, w = placed(far, z0, z1, z2)
    rows = 0.0
    for r in range(3):
        rows = max(rows, abs(pose[3 * r]) + abs(pose[3 * r + 1]) + abs(pose[3 * r + 2]))
    size = abs(y0) + abs(y1) + abs(y2)
    size_far = abs(z0) + abs(z1) + abs(z2)
    shifts = abs(pose[9]) + abs(pose[10]) + abs(pose[11]) + abs(far[9]) + abs(far[10]) + abs(far[11])
    rounding = 8.0 * U * (rows * (size + size_far) + shifts + abs(x) + abs(y) + abs(z))
    rounding += pose[12] * size + pose[13] + far[12] * size_far + far[13] + rows * off
    away = max(abs(x - u), abs(y - v), abs(z - w)) + rounding
    bound = _inverse_bound(far, frames[4 + other])
    return bound > 0.0 and _inside(second, j, z0, z1, z2, bound * away)


@kernel
def deepen(a, b, active, counts, frames, unknown, forms, matrix, right, columns, gradients):
    """The world point near unknown[0:3] that lies equally deep behind all active forms, to first order.

    Solves g_k.d + depth |g_k| = -value_k for d in the span of the gradients; the multipliers give the depth.
    """
    p, n = counts[0], counts[0] + counts[1]
    above, below = 0.0, 0.0
    for k in range(n):
        side = 0 if k < p else 1
        leaves = a.leaves if k < p else b.leaves
        x, y, z = unknown[0], unknown[1], unknown[2]
        moving_form(leaves, active[k], frames[side], frames[2 + side], frames[4 + side], x, y, z, forms)
        length = (forms[1] * forms[1] + forms[2] * forms[2] + forms[3] * forms[3]) ** 0.5
        gradients[k, 0], gradients[k, 1], gradients[k, 2], gradients[k, 3] = forms[1], forms[2], forms[3], length
        right[k] = -forms[0]
        above -= unknown[4 + k] * forms[0]
        below += unknown[4 + k] * length
    depth = above / below if below != 0.0 else 0.0
    for k in range(n):
        right[k] -= depth * gradients[k, 3]
        for r in range(n):
            matrix[k, r] = 0.0
            for c in range(3):
                matrix[k, r] += gradients[k, c] * gradients[r, c]
    solve(matrix, right, n, columns)
    x, y, z = unknown[0], unknown[1], unknown[2]
    for k in range(n):
        x += right[k] * gradients[k, 0]
        y += right[k] * gradients[k, 1]
        z += right[k] * gradients[k, 2]
    return x, y, z
