"""Two convex pieces in poses: directions that separate them, the proved gap along a direction, and how fast it bends."""

from __future__ import annotations

import math

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.poses import accelerations
from firstcontact.kernels.simplex import nearest
from firstcontact.kernels.support import support

U = 2.0**-53
# The search for the nearest points ends when the gap along its direction is this part of the distance: directions
# need not be the best ones, every one is judged by its own proved gap.
CLOSE = 0.9
MOST_ROUNDS = 40


@kernel
def local_direction(pose, n0, n1, n2):
    """R^T n."""
    return (
        pose[0] * n0 + pose[3] * n1 + pose[6] * n2,
        pose[1] * n0 + pose[4] * n1 + pose[7] * n2,
        pose[2] * n0 + pose[5] * n1 + pose[8] * n2,
    )


@kernel
def placed(pose, x, y, z):
    """R x + T."""
    return (
        pose[0] * x + pose[1] * y + pose[2] * z + pose[9],
        pose[3] * x + pose[4] * y + pose[5] * z + pose[10],
        pose[6] * x + pose[7] * y + pose[8] * z + pose[11],
    )


@kernel
def _reach(p, i):
    """Bound of |x| + |y| + |z| over the piece."""
    return (
        abs(p.boxes[i, 0]) + p.boxes[i, 3] + abs(p.boxes[i, 1]) + p.boxes[i, 4] + abs(p.boxes[i, 2]) + p.boxes[i, 5]
    )


@kernel
def gap(a, i, pose_a, b, j, pose_b, n0, n1, n2):
    """A proved lower bound of min n.(y - x) over x in piece i of a, y in piece j of b, in these poses.

    Positive: the plane with normal n parts them.
    """
    m0, m1, m2 = local_direction(pose_a, n0, n1, n2)
    high_a = support(a, i, m0, m1, m2)[0]
    m0, m1, m2 = local_direction(pose_b, n0, n1, n2)
    high_b = support(b, j, -m0, -m1, -m2)[0]
    shift, size = 0.0, abs(high_a) + abs(high_b)
    shift += n0 * (pose_b[9] - pose_a[9]) + n1 * (pose_b[10] - pose_a[10]) + n2 * (pose_b[11] - pose_a[11])
    size += abs(n0) * (abs(pose_a[9]) + abs(pose_b[9])) + abs(n1) * (abs(pose_a[10]) + abs(pose_b[10]))
    size += abs(n2) * (abs(pose_a[11]) + abs(pose_b[11]))
    length = abs(n0) + abs(n1) + abs(n2)
    error = 6.0 * U * size + length * (
        _reach(a, i) * pose_a[12] + pose_a[13] + _reach(b, j) * pose_b[12] + pose_b[13]
    )
    return shift - high_a - high_b - error * 1.001


@kernel
def separating_direction(a, i, pose_a, b, j, pose_b, n0, n1, n2, rows, weights):
    """(distance, n, number of rows): a unit direction from a to b, near that of the shortest distance.

    n0, n1, n2: where to start.  rows (4, 9), weights (4,): the simplex of the nearest points found, for reading.
    Distance 0: none was found, the origin is in the simplex.  Not proved (Gilbert, Johnson, Keerthi 1988).
    """
    x, y, z = -n0, -n1, -n2  # the point of a - b nearest the origin, as far as known
    n, square, best = 0, 1e300, -1.0
    for _ in range(MOST_ROUNDS):
        m0, m1, m2 = local_direction(pose_a, x, y, z)
        _, p0, p1, p2, _, _ = support(a, i, -m0, -m1, -m2)
        a0, a1, a2 = placed(pose_a, p0, p1, p2)
        m0, m1, m2 = local_direction(pose_b, x, y, z)
        _, p0, p1, p2, _, _ = support(b, j, m0, m1, m2)
        b0, b1, b2 = placed(pose_b, p0, p1, p2)
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
            for k in range(n):
                known = known or (rows[k, 0] == w0 and rows[k, 1] == w1 and rows[k, 2] == w2)
            if known:
                break
        rows[n, 0], rows[n, 1], rows[n, 2] = w0, w1, w2
        rows[n, 3], rows[n, 4], rows[n, 5] = a0, a1, a2
        rows[n, 6], rows[n, 7], rows[n, 8] = b0, b1, b2
        n, x, y, z = nearest(rows, n + 1, weights)
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


@kernel
def _bend(p, i, middle, radius, n0, n1, n2):
    """Upper bound of n.x'' over the points of a piece, with the enclosures of its accelerations."""
    total, size = 0.0, 0.0
    for k in range(3):
        m = n0 * middle[k] + n1 * middle[3 + k] + n2 * middle[6 + k]
        r = abs(n0) * radius[k] + abs(n1) * radius[3 + k] + abs(n2) * radius[6 + k]
        c, h = p.boxes[i, k], p.boxes[i, 3 + k]
        total += m * c + abs(m) * h + r * (abs(c) + h)
        size += abs(m) * (abs(c) + h)
    total += n0 * middle[9] + n1 * middle[10] + n2 * middle[11]
    size += abs(n0 * middle[9]) + abs(n1 * middle[10]) + abs(n2 * middle[11])
    total += abs(n0) * radius[9] + abs(n1) * radius[10] + abs(n2) * radius[11]
    return total + 20.0 * U * size


@kernel
def bending(a, i, head_a, coef_a, b, j, head_b, coef_b, t0, t1, n0, n1, n2, middle, radius):
    """Upper bound, at least 0, of the second derivative by time of n.(y - x) for all points x of a, y of b.

    A function with this bound stays above its chord less bound * s (1 - s) (t1 - t0)^2 / 2, 0 <= s <= 1.
    middle, radius: scratch (12,).
    """
    accelerations(head_a, coef_a, t0, t1, middle, radius)
    total = _bend(a, i, middle, radius, -n0, -n1, -n2)
    accelerations(head_b, coef_b, t0, t1, middle, radius)
    total += _bend(b, j, middle, radius, n0, n1, n2)
    return max(total, 0.0) * (1.0 + 1e-12)
