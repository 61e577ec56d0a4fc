"""Two convex pieces in poses: directions that separate them, the proved gap along one, and how fast it bends."""

from __future__ import annotations

import math

from firstcontact.kernels.convex.simplex import nearest
from firstcontact.kernels.convex.support import BOX, support
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.poses import accelerations
from firstcontact.kernels.workspace import HERE_A, HERE_B, MIDDLE, RADIUS, SIMPLEX, SPEED, SPREAD

U = 2.0**-53
# The search for the nearest points ends when the gap along its direction is this part of the distance: directions
# need not be the best ones, every one is judged by its own proved gap.
CLOSE = 0.98
MOST_ROUNDS = 40


@uncounted
def local_direction(w, row, n0, n1, n2):
    """R^T n."""
    return (
        w[row, 0] * n0 + w[row, 3] * n1 + w[row, 6] * n2,
        w[row, 1] * n0 + w[row, 4] * n1 + w[row, 7] * n2,
        w[row, 2] * n0 + w[row, 5] * n1 + w[row, 8] * n2,
    )


@uncounted
def placed(w, row, x, y, z):
    """R x + T."""
    return (
        w[row, 0] * x + w[row, 1] * y + w[row, 2] * z + w[row, 9],
        w[row, 3] * x + w[row, 4] * y + w[row, 5] * z + w[row, 10],
        w[row, 6] * x + w[row, 7] * y + w[row, 8] * z + w[row, 11],
    )


@uncounted
def _reach(p, i):
    """Bound of |x| + |y| + |z| over the piece."""
    return (
        abs(p[i, BOX]) + p[i, BOX + 3] + abs(p[i, BOX + 1]) + p[i, BOX + 4] + abs(p[i, BOX + 2]) + p[i, BOX + 5]
    )


@uncounted
def gap(a, i, b, j, n0, n1, n2, w):
    """A proved lower bound of min n.(y - x) over x in piece i of a, y in piece j of b.

    Poses: rows HERE_A, HERE_B.  Positive: the plane with normal n parts them.
    """
    row_a, row_b = HERE_A, HERE_B
    m0, m1, m2 = local_direction(w, row_a, n0, n1, n2)
    high_a = support(a, i, m0, m1, m2)[0]
    m0, m1, m2 = local_direction(w, row_b, n0, n1, n2)
    high_b = support(b, j, -m0, -m1, -m2)[0]
    shift, size = 0.0, abs(high_a) + abs(high_b)
    shift += n0 * (w[row_b, 9] - w[row_a, 9]) + n1 * (w[row_b, 10] - w[row_a, 10]) + n2 * (w[row_b, 11] - w[row_a, 11])
    size += abs(n0) * (abs(w[row_a, 9]) + abs(w[row_b, 9])) + abs(n1) * (abs(w[row_a, 10]) + abs(w[row_b, 10]))
    size += abs(n2) * (abs(w[row_a, 11]) + abs(w[row_b, 11]))
    length = abs(n0) + abs(n1) + abs(n2)
    error = 6.0 * U * size + length * (
        _reach(a, i) * w[row_a, 12] + w[row_a, 13] + _reach(b, j) * w[row_b, 12] + w[row_b, 13]
    )
    return shift - high_a - high_b - error * 1.001


@uncounted
def separating_direction(a, i, b, j, n0, n1, n2, w):
    """(distance, n, number of rows): a unit direction from a to b, near that of the shortest distance.

    n0, n1, n2: where to start.  Poses: rows HERE_A, HERE_B.  The simplex of the nearest points stays in the workspace.
    Distance 0: none was found, the origin is in the simplex.  Not proved (Gilbert, Johnson, Keerthi 1988).
    """
    row_a, row_b = HERE_A, HERE_B
    x, y, z = -n0, -n1, -n2  # the point of a - b nearest the origin, as far as known
    n, square, best = 0, 1e300, -1.0
    for _ in range(MOST_ROUNDS):
        m0, m1, m2 = local_direction(w, row_a, x, y, z)
        _, p0, p1, p2 = support(a, i, -m0, -m1, -m2)
        a0, a1, a2 = placed(w, row_a, p0, p1, p2)
        m0, m1, m2 = local_direction(w, row_b, x, y, z)
        _, p0, p1, p2 = support(b, j, m0, m1, m2)
        b0, b1, b2 = placed(w, row_b, p0, p1, p2)
        w0, w1, w2 = a0 - b0, a1 - b1, a2 - b2
        along = x * w0 + y * w1 + z * w2
        length = math.sqrt(x * x + y * y + z * z)
        if n > 0:
            if along > best * length:
                best = along / length
                n0, n1, n2 = -x / length, -y / length, -z / length
            if along >= CLOSE * square:
                break
            known = False
            for k in range(SIMPLEX, SIMPLEX + n):
                known = known or (w[k, 0] == w0 and w[k, 1] == w1 and w[k, 2] == w2)
            if known:
                break
        w[SIMPLEX + n, 0], w[SIMPLEX + n, 1], w[SIMPLEX + n, 2] = w0, w1, w2
        w[SIMPLEX + n, 3], w[SIMPLEX + n, 4], w[SIMPLEX + n, 5] = a0, a1, a2
        w[SIMPLEX + n, 6], w[SIMPLEX + n, 7], w[SIMPLEX + n, 8] = b0, b1, b2
        n, x, y, z = nearest(w, n + 1)
        smaller = x * x + y * y + z * z
        if n == 4 or smaller == 0.0:
            return 0.0, n0, n1, n2, n
        if smaller >= square:
            break
        square = smaller
    length = math.sqrt(square)
    if best <= 0.0:
        n0, n1, n2 = -x / length, -y / length, -z / length
    return length, n0, n1, n2, n


@uncounted
def _highest(p, i, middle, radius, n0, n1, n2, w):
    """Upper bound of n.(R x + T) over a piece for R, T in the enclosure of rows `middle` and `radius`."""
    total, size = 0.0, 0.0
    for k in range(3):
        m = n0 * w[middle, k] + n1 * w[middle, 3 + k] + n2 * w[middle, 6 + k]
        r = abs(n0) * w[radius, k] + abs(n1) * w[radius, 3 + k] + abs(n2) * w[radius, 6 + k]
        c, h = p[i, BOX + k], p[i, BOX + 3 + k]
        total += m * c + abs(m) * h + r * (abs(c) + h)
        size += (abs(n0 * w[middle, k]) + abs(n1 * w[middle, 3 + k]) + abs(n2 * w[middle, 6 + k])) * (abs(c) + h)
    total += n0 * w[middle, 9] + n1 * w[middle, 10] + n2 * w[middle, 11]
    size += abs(n0 * w[middle, 9]) + abs(n1 * w[middle, 10]) + abs(n2 * w[middle, 11])
    total += abs(n0) * w[radius, 9] + abs(n1) * w[radius, 10] + abs(n2) * w[radius, 11]
    return total + 20.0 * U * size


@uncounted
def bending(a, i, ma, b, j, mb, t0, t1, n0, n1, n2, e0, e1, e2, w):
    """Upper bound, at least 0, of f''(t) over [t0, t1] for all points x of a, y of b, f = n(t).(y - x).

    n(t) runs straight from n at t0 to e at t1: f'' = n(t).(y - x)'' + 2 n'.(y - x)'.
    """
    d0, d1, d2 = (e0 - n0) / (t1 - t0), (e1 - n1) / (t1 - t0), (e2 - n2) / (t1 - t0)
    at_n, at_e, turning = 0.0, 0.0, 0.0
    for side in range(2):
        p, k, s = (a, i, -1.0) if side == 0 else (b, j, 1.0)
        accelerations(ma if side == 0 else mb, t0, t1, w)
        at_n += _highest(p, k, MIDDLE, RADIUS, s * n0, s * n1, s * n2, w)
        at_e += _highest(p, k, MIDDLE, RADIUS, s * e0, s * e1, s * e2, w)
        turning += _highest(p, k, SPEED, SPREAD, s * d0, s * d1, s * d2, w)
    # directions between n and e: their bounds lie between; differences of doubles have errors of U, covered here
    slack = 4.0 * U * (abs(d0) + abs(d1) + abs(d2)) * (abs(turning) + 1.0)
    return max(max(at_n, at_e) + 2.0 * turning + slack, 0.0) * (1.0 + 1e-12)
