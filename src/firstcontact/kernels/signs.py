"""Signs of determinants of differences of points: by doubles with an error bound, where it fails by exact sums.

A point is `high + low`, rows of two arrays (n, 3).  `room` says what that is worth: with at least one element the
points are those sums exactly, and so is every sign (expansions, Shewchuk 1997); empty, `low` is not looked at, a
coordinate may be off by `err`, and a sign that is not certain is UNSURE.
Exact sums must not leave the range of doubles: `are_in_range`.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.double_double import two_product, two_sum
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.verdict import DET_EPS, TINY, cross, cross_size, slack3

UNSURE = 2
# A determinant has 6 products of three differences of two points of two parts: 6 * 4^3 products of three doubles,
# of four components each.
ROOM = 2048

_LEAST, _LARGEST = 2.0**-250, 2.0**200


def are_in_range(parts: np.ndarray) -> bool:
    """Whether products of three of these doubles, or of differences of them, have all their bits."""
    sizes = np.abs(parts)
    return bool(np.all((sizes < _LARGEST) & ((sizes > _LEAST) | (sizes == 0.0))))


@kernel
def _add(room, n, x):
    """The expansion of n components and x, exactly: the number of its components, none of which is zero."""
    m = 0
    for i in range(n):
        x, rest = two_sum(x, room[i])
        if rest != 0.0:
            room[m] = rest
            m += 1
    if x != 0.0:
        room[m] = x
        m += 1
    return m


@kernel
def _add_product(room, n, x, y):
    p, e = two_product(x, y)
    if e != 0.0:
        n = _add(room, n, e)
    return _add(room, n, p)


@kernel
def _difference(high, low, p, q, k, parts, i):
    """Coordinate k of p - q as parts[i, :n] (6, 4); returns n."""
    n = _add(parts[i], 0, high[p, k])
    n = _add(parts[i], n, -high[q, k])
    if low[p, k] != 0.0:
        n = _add(parts[i], n, low[p, k])
    if low[q, k] != 0.0:
        n = _add(parts[i], n, -low[q, k])
    return n


@kernel
def _sign(room, n):
    return 0 if n == 0 else 1 if room[n - 1] > 0.0 else -1


@kernel
def det_sign(high, low, err, room, p0, p1, q0, q1, r0, r1):
    """Sign of det [p0 - p1, q0 - q1, r0 - r1]; -1, 0, 1 or UNSURE."""
    x0, x1, x2 = high[p0, 0] - high[p1, 0], high[p0, 1] - high[p1, 1], high[p0, 2] - high[p1, 2]
    y0, y1, y2 = high[q0, 0] - high[q1, 0], high[q0, 1] - high[q1, 1], high[q0, 2] - high[q1, 2]
    z0, z1, z2 = high[r0, 0] - high[r1, 0], high[r0, 1] - high[r1, 1], high[r0, 2] - high[r1, 2]
    g0, g1, g2 = cross(y0, y1, y2, z0, z1, z2)
    s0, s1, s2 = cross_size(y0, y1, y2, z0, z1, z2)
    bound = DET_EPS * (abs(x0) * s0 + abs(x1) * s1 + abs(x2) * s2) + TINY
    if err > 0.0:
        d = 6.0 * err
        bound += slack3(
            abs(x0) + abs(x1) + abs(x2), abs(y0) + abs(y1) + abs(y2), abs(z0) + abs(z1) + abs(z2), d, d, d
        )
    det = x0 * g0 + x1 * g1 + x2 * g2
    if abs(det) > bound:
        return 1 if det > 0.0 else -1
    if room.shape[0] == 0:
        return UNSURE
    return _exact_det_sign(high, low, room, p0, p1, q0, q1, r0, r1)


@kernel
def _exact_det_sign(high, low, room, p0, p1, q0, q1, r0, r1):
    parts, counts = room[ROOM : ROOM + 36].reshape(9, 4), room[ROOM + 36 :]
    for k in range(3):
        counts[k] = _difference(high, low, p0, p1, k, parts, k)
        counts[3 + k] = _difference(high, low, q0, q1, k, parts, 3 + k)
        counts[6 + k] = _difference(high, low, r0, r1, k, parts, 6 + k)
    n = 0
    for k in range(3):
        for turn in range(2):
            y, z = 3 + (k + 1 + turn) % 3, 6 + (k + 2 - turn) % 3
            for i in range(int(counts[k])):
                for j in range(int(counts[y])):
                    p, e = two_product(parts[k, i], parts[y, j])
                    if turn == 1:
                        p, e = -p, -e
                    for m in range(int(counts[z])):
                        if e != 0.0:
                            n = _add_product(room, n, e, parts[z, m])
                        n = _add_product(room, n, p, parts[z, m])
    return _sign(room, n)


@kernel
def cross_sign(high, low, err, room, k, p0, p1, q0, q1):
    """Sign of coordinate k of (p0 - p1) x (q0 - q1); -1, 0, 1 or UNSURE."""
    i, j = (k + 1) % 3, (k + 2) % 3
    x0, x1 = high[p0, i] - high[p1, i], high[p0, j] - high[p1, j]
    y0, y1 = high[q0, i] - high[q1, i], high[q0, j] - high[q1, j]
    left, right = x0 * y1, x1 * y0
    bound = DET_EPS * (abs(left) + abs(right)) + TINY
    if err > 0.0:
        d = 4.0 * err
        bound += 1.000001 * d * (abs(x0) + abs(x1) + abs(y0) + abs(y1) + d)
    if abs(left - right) > bound:
        return 1 if left > right else -1
    if room.shape[0] == 0:
        return UNSURE
    parts = room[ROOM : ROOM + 36].reshape(9, 4)
    a, b = _difference(high, low, p0, p1, i, parts, 0), _difference(high, low, p0, p1, j, parts, 1)
    c, d = _difference(high, low, q0, q1, i, parts, 2), _difference(high, low, q0, q1, j, parts, 3)
    n = 0
    for x in range(a):
        for y in range(d):
            n = _add_product(room, n, parts[0, x], parts[3, y])
    for x in range(b):
        for y in range(c):
            n = _add_product(room, n, -parts[1, x], parts[2, y])
    return _sign(room, n)


@kernel
def order(high, low, err, room, k, p, q):
    """Sign of coordinate k of p - q; -1, 0, 1 or UNSURE."""
    d = high[p, k] - high[q, k]  # rounded once, and of the right sign
    if abs(d) > 2.000001 * err:
        return 1 if d > 0.0 else -1
    if room.shape[0] == 0:
        return UNSURE
    return _sign(room, _difference(high, low, p, q, k, room[:ROOM].reshape(1, ROOM), 0))


def work_room(exact: bool) -> np.ndarray:
    """What the signs above are worked out in: none where they are not exact."""
    return np.empty(ROOM + 45 if exact else 0)
