"""Newton's method on the contact system of active surfaces, for first guesses that are proved elsewhere.

With active forms a_i of one piece and b_j of the other, at a contact (X, t):
a_i(X, t) = 0, b_j(X, t) = 0, sum l_i grad a_i + sum m_j grad b_j = 0, sum l_i + sum m_j = 1
(the Fritz John conditions; re-derived, they serve every case of Choi et al. 2014, table 1, but vertices of more
than three surfaces).
"""

from __future__ import annotations

import math

from firstcontact.kernels.convex.separation import local_direction
from firstcontact.kernels.convex.support import form_gradient, form_value
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.poses import pose_at, velocity_at
from firstcontact.kernels.workspace import (
    ACTIVE,
    AWAY,
    COUNT,
    FORM,
    INVERSE_A,
    MATRIX,
    NORMAL,
    ORDER,
    POSE_A,
    RATES_A,
    RESULTS,
    RIGHT,
    SIDE_A,
    SIDE_B,
    UNKNOWN,
)


@uncounted
def solve(w, c, n):
    """Solve w[MATRIX] x = w[RIGHT] by elimination with full pivoting, n unknowns, those that nothing fixes get 0.

    The answer replaces w[RIGHT], the matrix is lost.
    """
    for k in range(n):
        c[ORDER + k] = k
    first, rank = 0.0, n
    for k in range(n):
        best, p, q = -1.0, k, k
        for row in range(k, n):
            for col in range(k, n):
                if abs(w[MATRIX + row, col]) > best:
                    best, p, q = abs(w[MATRIX + row, col]), row, col
        if k == 0:
            first = best
        if not best > 1e-11 * first:
            rank = k
            break
        for col in range(n):
            w[MATRIX + k, col], w[MATRIX + p, col] = w[MATRIX + p, col], w[MATRIX + k, col]
        w[RIGHT, k], w[RIGHT, p] = w[RIGHT, p], w[RIGHT, k]
        for row in range(n):
            w[MATRIX + row, k], w[MATRIX + row, q] = w[MATRIX + row, q], w[MATRIX + row, k]
        c[ORDER + k], c[ORDER + q] = c[ORDER + q], c[ORDER + k]
        for row in range(k + 1, n):
            f = w[MATRIX + row, k] / w[MATRIX + k, k]
            if f != 0.0:
                for col in range(k + 1, n):
                    w[MATRIX + row, col] -= f * w[MATRIX + k, col]
                w[RIGHT, row] -= f * w[RIGHT, k]
    for k in range(rank - 1, -1, -1):
        for col in range(k + 1, rank):
            w[RIGHT, k] -= w[MATRIX + k, col] * w[RIGHT, col]
        w[RIGHT, k] /= w[MATRIX + k, k]
    for k in range(n):  # the first row of the matrix is free by now
        w[MATRIX, c[ORDER + k]] = w[RIGHT, k] if k < rank else 0.0
    for k in range(n):
        w[RIGHT, k] = w[MATRIX, k]


@uncounted
def invert(w, side):
    """R^-1 of a side's pose by the adjugate; False where R is singular."""
    row, out = POSE_A + side, INVERSE_A + side
    for r in range(3):
        for c in range(3):
            # cofactors with cyclic indices carry their signs
            p, q, u, v = (c + 1) % 3, (c + 2) % 3, (r + 1) % 3, (r + 2) % 3
            w[out, 3 * r + c] = w[row, 3 * p + u] * w[row, 3 * q + v] - w[row, 3 * p + v] * w[row, 3 * q + u]
    determinant = w[row, 0] * w[out, 0] + w[row, 1] * w[out, 3] + w[row, 2] * w[out, 6]
    if determinant == 0.0:
        return False
    for k in range(9):
        w[out, k] /= determinant
    return True


@uncounted
def local_point(w, side, x, y, z):
    """R^-1 ((x, y, z) - T) of a side."""
    row, inverse = POSE_A + side, INVERSE_A + side
    x, y, z = x - w[row, 9], y - w[row, 10], z - w[row, 11]
    return (
        w[inverse, 0] * x + w[inverse, 1] * y + w[inverse, 2] * z,
        w[inverse, 3] * x + w[inverse, 4] * y + w[inverse, 5] * z,
        w[inverse, 6] * x + w[inverse, 7] * y + w[inverse, 8] * z,
    )


@uncounted
def moving_form(p, k, w, side, x, y, z):
    """Of form k at the world point x, y, z: value, gradient (3), rate by time, rate of the gradient (3).

    Into w[FORM], from the frames of a side.
    """
    rates, inverse = RATES_A + side, INVERSE_A + side
    y0, y1, y2 = local_point(w, side, x, y, z)
    value, _ = form_value(p, k, y0, y1, y2)
    g0, g1, g2 = form_gradient(p, k, y0, y1, y2)
    G0, G1, G2 = local_direction(w, inverse, g0, g1, g2)
    u0 = w[rates, 0] * y0 + w[rates, 1] * y1 + w[rates, 2] * y2 + w[rates, 9]
    u1 = w[rates, 3] * y0 + w[rates, 4] * y1 + w[rates, 5] * y2 + w[rates, 10]
    u2 = w[rates, 6] * y0 + w[rates, 7] * y1 + w[rates, 8] * y2 + w[rates, 11]
    # the local point runs back by R^-1 u
    v0 = -(w[inverse, 0] * u0 + w[inverse, 1] * u1 + w[inverse, 2] * u2)
    v1 = -(w[inverse, 3] * u0 + w[inverse, 4] * u1 + w[inverse, 5] * u2)
    v2 = -(w[inverse, 6] * u0 + w[inverse, 7] * u1 + w[inverse, 8] * u2)
    h0 = 2.0 * p[k, 0] * v0 + p[k, 3] * v1 + p[k, 4] * v2
    h1 = p[k, 3] * v0 + 2.0 * p[k, 1] * v1 + p[k, 5] * v2
    h2 = p[k, 4] * v0 + p[k, 5] * v1 + 2.0 * p[k, 2] * v2
    h0 -= w[rates, 0] * G0 + w[rates, 3] * G1 + w[rates, 6] * G2
    h1 -= w[rates, 1] * G0 + w[rates, 4] * G1 + w[rates, 7] * G2
    h2 -= w[rates, 2] * G0 + w[rates, 5] * G1 + w[rates, 8] * G2
    H0, H1, H2 = local_direction(w, inverse, h0, h1, h2)
    w[FORM, 0], w[FORM, 1], w[FORM, 2], w[FORM, 3], w[FORM, 4] = value, G0, G1, G2, -(G0 * u0 + G1 * u1 + G2 * u2)
    w[FORM, 5], w[FORM, 6], w[FORM, 7] = H0, H1, H2


@uncounted
def add_hessian(p, k, w, side, factor, row):
    """Add factor R^-T (second derivatives of form k) R^-1 to the 3x3 block of the matrix at (row, 0)."""
    inverse = INVERSE_A + side
    for c in range(3):
        i0, i1, i2 = w[inverse, c], w[inverse, 3 + c], w[inverse, 6 + c]
        h0 = 2.0 * p[k, 0] * i0 + p[k, 3] * i1 + p[k, 4] * i2
        h1 = p[k, 3] * i0 + 2.0 * p[k, 1] * i1 + p[k, 5] * i2
        h2 = p[k, 4] * i0 + p[k, 5] * i1 + 2.0 * p[k, 2] * i2
        H0, H1, H2 = local_direction(w, inverse, h0, h1, h2)
        w[MATRIX + row, c] += factor * H0
        w[MATRIX + row + 1, c] += factor * H1
        w[MATRIX + row + 2, c] += factor * H2


@uncounted
def newton_step(a, b, w, c, span, size, in_time):
    """One step of Newton's method on X, t and the multipliers; how far it was off and moved, -1 where not finite.

    The frames are those at t; steps in t count as parts of `span`.  in_time 0: t stays, X is on
    a and X + d n on b, for the n kept in w[RESULTS, NORMAL] and d in w[UNKNOWN, AWAY]: the nearest points at that time.
    """
    p, q = c[COUNT], c[COUNT + 1]
    n = 4 + p + q
    for r in range(n):
        w[RIGHT, r] = 0.0
        for col in range(n):
            w[MATRIX + r, col] = 0.0
    total = 0.0
    for k in range(p + q):
        side = SIDE_A if k < p else SIDE_B
        forms = a if k < p else b
        d = 0.0 if in_time or k < p else w[UNKNOWN, AWAY]
        n0, n1, n2 = w[RESULTS, NORMAL], w[RESULTS, NORMAL + 1], w[RESULTS, NORMAL + 2]
        x, y, z = w[UNKNOWN, 0] + d * n0, w[UNKNOWN, 1] + d * n1, w[UNKNOWN, 2] + d * n2
        moving_form(forms, c[ACTIVE + k], w, side, x, y, z)
        m = w[UNKNOWN, 4 + k]
        if in_time:
            w[MATRIX + k, 3] = w[FORM, 4] * span
        elif k >= p:  # the bend of the form along n is left out: d is small, and a few steps make up for it
            w[MATRIX + k, 3] = w[FORM, 1] * n0 + w[FORM, 2] * n1 + w[FORM, 3] * n2
        w[RIGHT, k] = -w[FORM, 0]
        for r in range(3):
            w[MATRIX + k, r] = w[FORM, 1 + r]
            w[MATRIX + p + q + r, 4 + k] = w[FORM, 1 + r]
            w[MATRIX + p + q + r, 3] += m * w[FORM, 5 + r] * span if in_time else 0.0
            w[RIGHT, p + q + r] -= m * w[FORM, 1 + r]
        add_hessian(forms, c[ACTIVE + k], w, side, m, p + q)
        w[MATRIX + n - 1, 4 + k] = 1.0
        total += m
    w[RIGHT, n - 1] = 1.0 - total
    off = 0.0
    for k in range(n):  # values of the forms are lengths, sums of unit normals are made so by the size
        off += abs(w[RIGHT, k]) * (1.0 if k < p + q else size)
    solve(w, c, n)
    for k in range(n):
        if not math.isfinite(w[RIGHT, k]):
            return -1.0
        if k == 3 and not in_time:
            w[UNKNOWN, AWAY] += w[RIGHT, k]
        else:
            w[UNKNOWN, k] += w[RIGHT, k] * (span if k == 3 else 1.0)
    return off + abs(w[RIGHT, 0]) + abs(w[RIGHT, 1]) + abs(w[RIGHT, 2]) + abs(w[RIGHT, 3])


@uncounted
def place_frames(ma, mb, t, w):
    """Poses, rates and inverses of both bodies at t; False where one is singular."""
    for side in range(2):
        m = ma if side == 0 else mb
        pose_at(m, t, w, POSE_A + side)
        velocity_at(m, t, w, RATES_A + side)
        if not invert(w, side):
            return False
    return True
