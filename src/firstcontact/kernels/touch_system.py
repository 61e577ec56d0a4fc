"""Newton's method on the contact system of active surfaces, for first guesses that are proved elsewhere.

With active forms a_i of one piece and b_j of the other, at a contact (X, t):
a_i(X, t) = 0, b_j(X, t) = 0, sum l_i grad a_i + sum m_j grad b_j = 0, sum l_i + sum m_j = 1
(the Fritz John conditions; re-derived, they serve every case of Choi et al. 2014, table 1, but vertices of more
than three surfaces).
"""

from __future__ import annotations

import math

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.poses import pose_at, velocity_at
from firstcontact.kernels.support import form_gradient, form_value


@kernel
def solve(matrix, right, n, columns):
    """Solve in place by elimination with full pivoting; unknowns that nothing fixes get 0.  right becomes the answer.

    columns (n,) int64: scratch.  Returns the number of unknowns fixed.
    """
    for k in range(n):
        columns[k] = k
    first, rank = 0.0, n
    for k in range(n):
        best, p, q = -1.0, k, k
        for r in range(k, n):
            for c in range(k, n):
                if abs(matrix[r, c]) > best:
                    best, p, q = abs(matrix[r, c]), r, c
        if k == 0:
            first = best
        if not best > 1e-11 * first:
            rank = k
            break
        for c in range(n):
            matrix[k, c], matrix[p, c] = matrix[p, c], matrix[k, c]
        right[k], right[p] = right[p], right[k]
        for r in range(n):
            matrix[r, k], matrix[r, q] = matrix[r, q], matrix[r, k]
        columns[k], columns[q] = columns[q], columns[k]
        for r in range(k + 1, n):
            f = matrix[r, k] / matrix[k, k]
            if f != 0.0:
                for c in range(k + 1, n):
                    matrix[r, c] -= f * matrix[k, c]
                right[r] -= f * right[k]
    for k in range(rank, n):
        right[k] = 0.0
    for k in range(rank - 1, -1, -1):
        for c in range(k + 1, rank):
            right[k] -= matrix[k, c] * right[c]
        right[k] /= matrix[k, k]
    for k in range(n):  # matrix row 0 as scratch for the order of the unknowns
        matrix[0, columns[k]] = right[k]
    for k in range(n):
        right[k] = matrix[0, k]
    return rank


@kernel
def invert(pose, out):
    """R^-1 by the adjugate into out (9,); False where R is singular."""
    a, b, c, d, e, f, g, h, k = pose[0], pose[1], pose[2], pose[3], pose[4], pose[5], pose[6], pose[7], pose[8]
    out[0], out[1], out[2] = e * k - f * h, c * h - b * k, b * f - c * e
    out[3], out[4], out[5] = f * g - d * k, a * k - c * g, c * d - a * f
    out[6], out[7], out[8] = d * h - e * g, b * g - a * h, a * e - b * d
    determinant = a * out[0] + b * out[3] + c * out[6]
    if determinant == 0.0:
        return False
    for n in range(9):
        out[n] /= determinant
    return True


@kernel
def local_point(pose, inverse, x, y, z):
    x, y, z = x - pose[9], y - pose[10], z - pose[11]
    return (
        inverse[0] * x + inverse[1] * y + inverse[2] * z,
        inverse[3] * x + inverse[4] * y + inverse[5] * z,
        inverse[6] * x + inverse[7] * y + inverse[8] * z,
    )


@kernel
def _back(inverse, x, y, z):
    """R^-T (x, y, z)."""
    return (
        inverse[0] * x + inverse[3] * y + inverse[6] * z,
        inverse[1] * x + inverse[4] * y + inverse[7] * z,
        inverse[2] * x + inverse[5] * y + inverse[8] * z,
    )


@kernel
def moving_form(leaves, k, pose, rates, inverse, x, y, z, out):
    """Of form k at the world point x, y, z: value, gradient (3), rate by time, rate of the gradient (3); out (8,)."""
    y0, y1, y2 = local_point(pose, inverse, x, y, z)
    value, _ = form_value(leaves, k, y0, y1, y2)
    g0, g1, g2 = form_gradient(leaves, k, y0, y1, y2)
    G0, G1, G2 = _back(inverse, g0, g1, g2)
    u0 = rates[0] * y0 + rates[1] * y1 + rates[2] * y2 + rates[9]
    u1 = rates[3] * y0 + rates[4] * y1 + rates[5] * y2 + rates[10]
    u2 = rates[6] * y0 + rates[7] * y1 + rates[8] * y2 + rates[11]
    # the local point runs back by R^-1 u
    v0 = -(inverse[0] * u0 + inverse[1] * u1 + inverse[2] * u2)
    v1 = -(inverse[3] * u0 + inverse[4] * u1 + inverse[5] * u2)
    v2 = -(inverse[6] * u0 + inverse[7] * u1 + inverse[8] * u2)
    h0 = 2.0 * leaves[k, 0] * v0 + leaves[k, 3] * v1 + leaves[k, 4] * v2
    h1 = leaves[k, 3] * v0 + 2.0 * leaves[k, 1] * v1 + leaves[k, 5] * v2
    h2 = leaves[k, 4] * v0 + leaves[k, 5] * v1 + 2.0 * leaves[k, 2] * v2
    h0 -= rates[0] * G0 + rates[3] * G1 + rates[6] * G2
    h1 -= rates[1] * G0 + rates[4] * G1 + rates[7] * G2
    h2 -= rates[2] * G0 + rates[5] * G1 + rates[8] * G2
    H0, H1, H2 = _back(inverse, h0, h1, h2)
    out[0], out[1], out[2], out[3], out[4] = value, G0, G1, G2, -(G0 * u0 + G1 * u1 + G2 * u2)
    out[5], out[6], out[7] = H0, H1, H2


@kernel
def add_hessian(leaves, k, inverse, factor, matrix, row):
    """Add factor R^-T (second derivatives of form k) R^-1 to the 3x3 block at (row, 0)."""
    for c in range(3):
        i0, i1, i2 = inverse[c], inverse[3 + c], inverse[6 + c]
        h0 = 2.0 * leaves[k, 0] * i0 + leaves[k, 3] * i1 + leaves[k, 4] * i2
        h1 = leaves[k, 3] * i0 + 2.0 * leaves[k, 1] * i1 + leaves[k, 5] * i2
        h2 = leaves[k, 4] * i0 + leaves[k, 5] * i1 + 2.0 * leaves[k, 2] * i2
        H0, H1, H2 = _back(inverse, h0, h1, h2)
        matrix[row, c] += factor * H0
        matrix[row + 1, c] += factor * H1
        matrix[row + 2, c] += factor * H2


@kernel
def newton_step(a, b, active, counts, frames, unknown, forms, matrix, right, columns, span):
    """One step of Newton's method; the size of the step relative to the last unknowns, -1 where it is singular.

    active (8,) int64: form numbers, a's first; counts (2,): how many of each; frames (6, 14): poses, rates and
    inverses of a and b; unknown: X, t, multipliers.  Columns of t are scaled by `span`.
    """
    p, q = counts[0], counts[1]
    n = 4 + p + q
    for r in range(n):
        right[r] = 0.0
        for c in range(n):
            matrix[r, c] = 0.0
    total = 0.0
    for k in range(p + q):
        side = 0 if k < p else 1
        leaves = a.leaves if k < p else b.leaves
        moving_form(
            leaves, active[k], frames[side], frames[2 + side], frames[4 + side], unknown[0], unknown[1], unknown[2], forms
        )
        m = unknown[4 + k]
        matrix[k, 0], matrix[k, 1], matrix[k, 2], matrix[k, 3] = forms[1], forms[2], forms[3], forms[4] * span
        right[k] = -forms[0]
        for c in range(3):
            matrix[p + q + c, 4 + k] = forms[1 + c]
            matrix[p + q + c, 3] += m * forms[5 + c] * span
            right[p + q + c] -= m * forms[1 + c]
        add_hessian(leaves, active[k], frames[4 + side], m, matrix, p + q)
        matrix[n - 1, 4 + k] = 1.0
        total += m
    right[n - 1] = 1.0 - total
    solve(matrix, right, n, columns)
    for k in range(n):
        if not math.isfinite(right[k]):
            return -1.0
        unknown[k] += right[k] * (span if k == 3 else 1.0)
    return abs(right[0]) + abs(right[1]) + abs(right[2]) + abs(right[3])


@kernel
def place_frames(head_a, coef_a, head_b, coef_b, t, frames):
    """Poses, rates and inverses of both bodies at t; False where one is singular."""
    pose_at(head_a, coef_a, t, frames[0])
    pose_at(head_b, coef_b, t, frames[1])
    velocity_at(head_a, coef_a, t, frames[2])
    velocity_at(head_b, coef_b, t, frames[3])
    return invert(frames[0], frames[4]) and invert(frames[1], frames[5])
