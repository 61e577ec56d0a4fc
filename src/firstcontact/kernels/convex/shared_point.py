"""Proof that two convex pieces in poses share a point: one at which every form is below its rounding error."""

from __future__ import annotations

import math

from firstcontact.kernels.convex.separation import placed
from firstcontact.kernels.convex.support import FLAT, FORMS, form_gradient, form_value
from firstcontact.kernels.convex.touch_system import local_point, moving_form, solve
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import (
    ACTIVE,
    COUNT,
    FORM,
    GRADIENTS,
    INVERSE_A,
    MATRIX,
    POSE_A,
    POSE_B,
    RIGHT,
    SIDE_A,
    SIDE_B,
    UNKNOWN,
)

U = 2.0**-53
# Relative rounding error of a form: three of each coefficient, twelve of the sum; see test_form_bound.
FORM_EPS = 20.0 * U


@uncounted
def is_inside(p, i, y0, y1, y2, off):
    """Whether all points within `off` (per coordinate) of a local point are certainly inner ones of piece i.

    At the origin, on a surface that passes it, nothing is rounded: value and margin are 0, and the point is none.
    """
    for k in range(int(p[i, FORMS]), int(p[i, FORMS + 1])):
        if p[k, FLAT] != 0.0:
            return False
        value, size = form_value(p, k, y0, y1, y2)
        margin = FORM_EPS * size
        if off > 0.0:
            g0, g1, g2 = form_gradient(p, k, y0, y1, y2)
            bend = 0.0
            for c in range(6):
                bend += abs(p[k, c])
            margin += 1.0001 * ((abs(g0) + abs(g1) + abs(g2)) * off + bend * off * off) + FORM_EPS * size
        if value + margin >= 0.0:
            return False
    return True


@uncounted
def _inverse_bound(w, side):
    """Bound of the largest row sum of |R^-1|, -1 where the computed inverse proves none."""
    norm, defect = 0.0, 0.0
    pose, inverse = POSE_A + side, INVERSE_A + side
    for r in range(3):
        row, off = 0.0, 0.0
        for c in range(3):
            row += abs(w[inverse, 3 * r + c])
            e = -1.0 if r == c else 0.0
            for k in range(3):
                e += w[inverse, 3 * r + k] * w[pose, 3 * k + c]
            off += abs(e)
        norm, defect = max(norm, row), max(defect, off)
    defect += norm * 3.0 * w[pose, 12] + 1e-14
    return norm / (1.0 - defect) if defect < 0.5 else -1.0


@uncounted
def across(w, side, y0, y1, y2, off):
    """(z, radius): where the points within `off` of a local point of a side are in the other one's coordinates.

    Within `radius` of z, per coordinate; -1 where none is proved.
    """
    pose, far = POSE_A + side, POSE_B - side
    x, y, z = placed(w, pose, y0, y1, y2)
    z0, z1, z2 = local_point(w, 1 - side, x, y, z)
    u0, u1, u2 = placed(w, far, z0, z1, z2)
    rows, shifts = 0.0, 0.0
    for r in range(3):
        rows = max(rows, abs(w[pose, 3 * r]) + abs(w[pose, 3 * r + 1]) + abs(w[pose, 3 * r + 2]))
        rows = max(rows, abs(w[far, 3 * r]) + abs(w[far, 3 * r + 1]) + abs(w[far, 3 * r + 2]))
        shifts += abs(w[pose, 9 + r]) + abs(w[far, 9 + r])
    size, size_far = abs(y0) + abs(y1) + abs(y2), abs(z0) + abs(z1) + abs(z2)
    rounding = 8.0 * U * (rows * (size + size_far) + shifts)
    rounding += w[pose, 12] * size + w[pose, 13] + w[far, 12] * size_far + w[far, 13] + rows * off
    away = max(abs(x - u0), abs(y - u1), abs(z - u2)) + rounding * 1.001
    bound = _inverse_bound(w, 1 - side)
    return z0, z1, z2, bound * away if bound > 0.0 else -1.0


@uncounted
def proves_shared(a, i, b, j, w, side, vertex, x, y, z):
    """True proves that the pieces share a point, near (x, y, z), in the poses of the frames.

    The point is fixed in the body of `side`; vertex: its row there when it is a vertex (x, y, z do not count then,
    and it is in its piece by itself), else -1.
    """
    p, q = (a, b) if side == 0 else (b, a)
    i, j = (i, j) if side == 0 else (j, i)
    # the point is exactly R y + T for the doubles y, or the true vertex near them
    off = 0.0
    if vertex >= 0:
        y0, y1, y2, off = p[vertex, 0], p[vertex, 1], p[vertex, 2], p[vertex, 3]
    else:
        y0, y1, y2 = local_point(w, side, x, y, z)
        if not is_inside(p, i, y0, y1, y2, off):
            return False
    z0, z1, z2, radius = across(w, side, y0, y1, y2, off)
    return radius >= 0.0 and is_inside(q, j, z0, z1, z2, radius)


@uncounted
def deepen(a, b, w, c):
    """The world point near the solution that lies equally deep behind all active forms, to first order.

    Solves g_k.d + depth |g_k| = -value_k for d in the span of the gradients; the multipliers give the depth.  Forms of
    flat pieces are met, not passed: depth 0.
    """
    p, n = c[COUNT], c[COUNT] + c[COUNT + 1]
    x, y, z = w[UNKNOWN, 0], w[UNKNOWN, 1], w[UNKNOWN, 2]
    above, below = 0.0, 0.0
    for k in range(n):
        forms = a if k < p else b
        moving_form(forms, c[ACTIVE + k], w, SIDE_A if k < p else SIDE_B, x, y, z)
        length = math.sqrt(w[FORM, 1] ** 2 + w[FORM, 2] ** 2 + w[FORM, 3] ** 2)
        if forms[c[ACTIVE + k], FLAT] != 0.0:
            length = 0.0
        for r in range(3):
            w[GRADIENTS + k, r] = w[FORM, 1 + r]
        w[GRADIENTS + k, 3] = length
        w[RIGHT, k] = -w[FORM, 0]
        above -= w[UNKNOWN, 4 + k] * w[FORM, 0]
        below += w[UNKNOWN, 4 + k] * length
    depth = above / below if below != 0.0 else 0.0
    for k in range(n):
        w[RIGHT, k] -= depth * w[GRADIENTS + k, 3]
        for r in range(n):
            w[MATRIX + k, r] = 0.0
            for col in range(3):
                w[MATRIX + k, r] += w[GRADIENTS + k, col] * w[GRADIENTS + r, col]
    solve(w, c, n)
    for k in range(n):
        x += w[RIGHT, k] * w[GRADIENTS + k, 0]
        y += w[RIGHT, k] * w[GRADIENTS + k, 1]
        z += w[RIGHT, k] * w[GRADIENTS + k, 2]
    return x, y, z
