"""Boxes along principal axes of a set of vectors, and the range of a linear form over such a box.

A box is one row: its number of axes, a remainder `rho`, the centre (d), half widths (d) and axes (d x d).  For every
vector Y of its set there are weights p with |p_j| <= half width j such that each entry of Y - centre - sum p_j axis_j
is at most rho in size.  That is checked vector by vector, roundings included, so no bound rests on the axes being
orthonormal: they may be any vectors whatever.
"""

from __future__ import annotations

import math

from firstcontact.kernels.jit import uncounted

RANK, RHO, CENTRE = 0, 1, 2
_U = 2.0**-53
# Covariances are those of so many vectors of the set: they only choose the axes.
_SAMPLE = 64
# Axes along which the set is that much thinner than it is long count to the remainder.
_FLAT = 1e-14


@uncounted
def box_columns(d):
    """Length of the row of a box of vectors with d entries."""
    return CENTRE + 2 * d + d * d


@uncounted
def fit_box(vectors, order, first, last, group, row, offset, moments, axes, weights):
    """Write the box of the vectors of the items order[first:last] into `row` from `offset` on.

    vectors (m * group, d): `group` consecutive ones belong to an item.  moments, axes (d, d), weights (3, d): scratch.
    Numbers written into a call want to be np.int64(...): Numba compiles anew for every Python number there.
    """
    d = vectors.shape[1]
    _covariance(vectors, order, first, last, group, moments, weights[0])
    _jacobi(moments, axes, d)
    centre, half, start = offset + CENTRE, offset + CENTRE + d, offset + CENTRE + 2 * d
    low, high = weights[1], weights[2]
    for j in range(d):
        low[j], high[j] = math.inf, -math.inf
        row[centre + j] = weights[0, j]
    for i in range(first, last):
        for g in range(group):
            y = vectors[group * order[i] + g]
            for j in range(d):
                p = 0.0
                for k in range(d):
                    p += axes[k, j] * (y[k] - weights[0, k])
                low[j], high[j] = min(low[j], p), max(high[j], p)
    longest = 0.0
    for j in range(d):
        longest = max(longest, high[j] - low[j])
    rank = 0
    for j in range(d):
        middle = 0.5 * (low[j] + high[j])
        for k in range(d):
            row[centre + k] += axes[k, j] * middle
        if high[j] - low[j] > _FLAT * longest:
            for k in range(d):
                row[start + d * rank + k] = axes[k, j]
            row[half + rank] = 0.0
            rank += 1
    rho, size, widest = 0.0, 0.0, 0.0
    p = low
    for i in range(first, last):
        for g in range(group):
            y = vectors[group * order[i] + g]
            for j in range(rank):
                weight = 0.0
                for k in range(d):
                    weight += row[start + d * j + k] * (y[k] - row[centre + k])
                p[j] = weight
                row[half + j] = max(row[half + j], abs(weight))
                widest = max(widest, abs(weight))
            for k in range(d):
                left = y[k] - row[centre + k]
                for j in range(rank):
                    left -= row[start + d * j + k] * p[j]
                rho = max(rho, abs(left))
                size = max(size, abs(y[k]))
    for k in range(d):
        size = max(size, abs(row[centre + k]))
    row[offset + RANK] = rank
    # each remainder takes d + 1 differences and d products of numbers of these sizes (|axis entries| < 1.1)
    row[offset + RHO] = rho + 32.0 * _U * (size + d * widest)


@uncounted
def form_range(row, offset, form, d):
    """(v, r): the form (d,) takes values in [v - r, v + r] on the set of the box, but for the rounding of this sum."""
    centre, half, start = offset + CENTRE, offset + CENTRE + d, offset + CENTRE + 2 * d
    value, size = 0.0, 0.0
    for k in range(d):
        value += row[centre + k] * form[k]
        size += abs(form[k])
    reach = row[offset + RHO] * size
    for j in range(int(row[offset + RANK])):
        s = 0.0
        for k in range(d):
            s += row[start + d * j + k] * form[k]
        reach += abs(s) * row[half + j]
    return value, reach


@uncounted
def _covariance(vectors, order, first, last, group, moments, mean):
    """Mean and matrix of second moments of a sample, evenly spaced in the order."""
    d = vectors.shape[1]
    step = max(1, (last - first) // _SAMPLE)
    n = 0
    for j in range(d):
        mean[j] = 0.0
        for k in range(d):
            moments[j, k] = 0.0
    for i in range(first, last, step):
        for g in range(group):
            y = vectors[group * order[i] + g]
            n += 1
            for j in range(d):
                mean[j] += y[j]
    for j in range(d):
        mean[j] /= n
    for i in range(first, last, step):
        for g in range(group):
            y = vectors[group * order[i] + g]
            for j in range(d):
                for k in range(j + 1):
                    moments[j, k] += (y[j] - mean[j]) * (y[k] - mean[k])
    for j in range(d):
        for k in range(j):
            moments[k, j] = moments[j, k]


@uncounted
def _jacobi(m, axes, d):
    """Eigenvectors of the symmetric matrix m (destroyed) as columns of axes, by cyclic Jacobi rotations."""
    total = 0.0
    for j in range(d):
        for k in range(d):
            axes[j, k] = 1.0 if j == k else 0.0
            total += abs(m[j, k])
    for _ in range(12):
        off = 0.0
        for j in range(d):
            for k in range(j):
                off += abs(m[j, k])
        if not off > 1e-15 * total:
            return
        for i in range(d - 1):
            for j in range(i + 1, d):
                if not abs(m[i, j]) > 1e-17 * total:
                    continue
                theta = (m[j, j] - m[i, i]) / (2.0 * m[i, j])
                t = 1.0 / (abs(theta) + math.sqrt(theta * theta + 1.0))
                t = -t if theta < 0.0 else t
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                for k in range(d):
                    x, y = m[k, i], m[k, j]
                    m[k, i], m[k, j] = c * x - s * y, s * x + c * y
                for k in range(d):
                    x, y = m[i, k], m[j, k]
                    m[i, k], m[j, k] = c * x - s * y, s * x + c * y
                    x, y = axes[k, i], axes[k, j]
                    axes[k, i], axes[k, j] = c * x - s * y, s * x + c * y
