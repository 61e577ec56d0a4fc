"""The surfaces of one body as seen from another over a short time: forms linear in time, with proved remainders.

Over a slab of time every number is value + slope s + [-rest, rest], -1 <= s <= 1 (a Taylor model of first order).
Points are homogeneous and in units of their body (see `search.events.event_tables`); forms are symmetric 4x4 matrices,
of planes the four coefficients.
"""

from __future__ import annotations

from firstcontact.kernels.events.feature_boxes import ABOUT, SUM_OF_SIZES
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.poses import accelerations, pose_at
from firstcontact.kernels.workspace import HERE_A, MIDDLE, RADIUS, SPEED, SPREAD, rows

U = 2.0**-53
# Of one product of two models: four roundings, and those of the sum that it enters.
ROUNDING = 8.0 * U
# Slots of a body's row of units: centre, half-size.
SIZE = 3
# Rows of the scratch array of models (3, n): entries of the poses of either body, adjugate of the second one's linear
# part, offset between the two, relative map (three rows of four, then its weight), product of a form with it, one sum.
FIRST, SECOND, ADJUGATE, OFFSET, MAP, WEIGHT, IMAGE, SUM = rows(0, 12, 24, 33, 36, 48, 49, 65)
MODELS = 66


@uncounted
def add_product(x, i, y, j, factor, out, k):
    """Add factor x[i] y[j] to the model out[k]."""
    v1, s1, r1 = x[0, i], x[1, i], x[2, i]
    v2, s2, r2 = y[0, j], y[1, j], y[2, j]
    bend = s1 * s2  # times s^2, between 0 and 1
    m1, m2 = abs(v1) + abs(s1), abs(v2) + abs(s2)
    size = abs(factor)
    out[0, k] += factor * (v1 * v2 + 0.5 * bend)
    out[1, k] += factor * (v1 * s2 + s1 * v2)
    out[2, k] += size * (0.5 * abs(bend) + m1 * r2 + r1 * (m2 + r2) + ROUNDING * (m1 + r1) * (m2 + r2))


@uncounted
def add_multiple(x, i, factor, out, k):
    """Add factor x[i] to the model out[k]; the factor itself may be off by its rounding."""
    size = abs(factor)
    out[0, k] += factor * x[0, i]
    out[1, k] += factor * x[1, i]
    out[2, k] += size * (x[2, i] + ROUNDING * (abs(x[0, i]) + abs(x[1, i]) + x[2, i]))


@uncounted
def _clear(out, first, end):
    for k in range(first, end):
        out[0, k] = out[1, k] = out[2, k] = 0.0


@uncounted
def pose_models(m, middle, half, w, out, first):
    """Models of the twelve entries of a pose over middle +- half, from `first` on."""
    pose_at(m, middle, w, HERE_A)
    accelerations(m, middle, middle, w)
    for e in range(12):
        error = w[HERE_A, 12] if e < 9 else w[HERE_A, 13]
        out[0, first + e], out[1, first + e] = w[HERE_A, e], half * w[SPEED, e]
        out[2, first + e] = error + half * w[SPREAD, e]
    accelerations(m, middle - half, middle + half, w)
    for e in range(12):
        bend = 0.5 * half * half * w[MIDDLE, e]
        out[0, first + e] += 0.5 * bend
        size = abs(out[0, first + e]) + abs(out[1, first + e])
        out[2, first + e] += 0.5 * abs(bend) + 0.5 * half * half * w[RADIUS, e] + 4.0 * U * size
        out[2, first + e] *= 1.0 + 1e-12


@uncounted
def relative_map(out, first, second, units, x, y):
    """The map from body x (row of `units`, pose at `first`) to body y, times a positive number; False if singular.

    adj(S) (R p + t - s) with weight det S, for the poses p -> R p + t and p -> S p + s.
    """
    _clear(out, ADJUGATE, IMAGE)
    for r in range(3):
        for c in range(3):
            p, q, u, v = (c + 1) % 3, (c + 2) % 3, (r + 1) % 3, (r + 2) % 3
            add_product(out, second + 3 * p + u, out, second + 3 * q + v, 1.0, out, ADJUGATE + 3 * r + c)
            add_product(out, second + 3 * p + v, out, second + 3 * q + u, -1.0, out, ADJUGATE + 3 * r + c)
    for k in range(3):  # the determinant
        add_product(out, second + k, out, ADJUGATE + 3 * k, 1.0, out, WEIGHT)
    for r in range(3):
        for k in range(3):
            add_multiple(out, first + 3 * r + k, units[x, k], out, OFFSET + r)
        add_multiple(out, first + 9 + r, 1.0, out, OFFSET + r)
        add_multiple(out, second + 9 + r, -1.0, out, OFFSET + r)
    det = out[0, WEIGHT]
    if not abs(det) > abs(out[1, WEIGHT]) + out[2, WEIGHT]:  # nor where they are infinite
        return False
    scale = 1.0 / (det * units[y, SIZE])
    for r in range(3):
        for c in range(3):
            for k in range(3):
                factor = scale * units[x, SIZE]
                add_product(out, ADJUGATE + 3 * r + k, out, first + 3 * k + c, factor, out, MAP + 4 * r + c)
        for k in range(3):
            add_product(out, ADJUGATE + 3 * r + k, out, OFFSET + k, scale, out, MAP + 4 * r + 3)
        add_multiple(out, WEIGHT, -scale * units[y, r], out, MAP + 4 * r + 3)
    for k in range(2):
        out[k, WEIGHT] *= scale * units[y, SIZE]
    out[2, WEIGHT] = out[2, WEIGHT] * abs(scale * units[y, SIZE]) * (1.0 + 1e-12) + ROUNDING
    return True


@uncounted
def _add_sizes(table, row, columns):
    """The sum of all sizes into the fourth part."""
    total = 0.0
    for part in range(3):
        for c in range(columns):
            total += abs(table[row, part, c])
    table[row, ABOUT, SUM_OF_SIZES] = total


@uncounted
def pull_back(raw, kinds, first, count, out, table, target):
    """Forms first.. of the other body under the relative map, as rows target.. of the table (n, 4, 16)."""
    for k in range(count):
        f, row = first + k, target + k
        if kinds[f] == 0:
            for c in range(4):
                table[row, 0, c] = table[row, 1, c] = table[row, 2, c] = 0.0
                _clear(out, IMAGE, IMAGE + 1)
                for r in range(3):
                    add_multiple(out, MAP + 4 * r + c, raw[f, r], out, IMAGE)
                if c == 3:
                    add_multiple(out, WEIGHT, raw[f, 3], out, IMAGE)
                for part in range(3):
                    table[row, part, c] = out[part, IMAGE]
            _add_sizes(table, row, 4)
            continue
        _clear(out, IMAGE, IMAGE + 16)
        for i in range(4):
            for j in range(4):
                for m in range(3):
                    add_multiple(out, MAP + 4 * m + j, raw[f, 4 * i + m], out, IMAGE + 4 * i + j)
            add_multiple(out, WEIGHT, raw[f, 4 * i + 3], out, IMAGE + 4 * i + 3)
        for i in range(4):
            for j in range(i + 1):
                _clear(out, SUM, SUM + 1)
                for m in range(3):
                    add_product(out, MAP + 4 * m + i, out, IMAGE + 4 * m + j, 1.0, out, SUM)
                if i == 3:
                    add_product(out, WEIGHT, out, IMAGE + 12 + j, 1.0, out, SUM)
                for part in range(3):
                    table[row, part, 4 * i + j] = table[row, part, 4 * j + i] = out[part, SUM]
        _add_sizes(table, row, 16)
