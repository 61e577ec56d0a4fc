"""Poses of moving bodies at a time, with proved errors; their velocities; enclosures of their accelerations.

A motion is x -> R x + T.  An array m (14, n) describes it on one stretch of time by s = (t - middle) / half: row 0 is
its head, rows 1 to 12 are the entries of R (by rows) and T, row 13 is the weight.  Kind RATIONAL: entries are
polynomials in s over the weight; kind TURNING: they are linear in 1, sin(omega s), 1 - cos(omega s), s.
"""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import MIDDLE, RADIUS, SPEED, SPREAD

U = 2.0**-53
RATIONAL, TURNING = 0.0, 1.0
# Slots of the head: kind, middle and 1 / half of the stretch, omega, proved errors of the entries of R and T (of
# numerators, for rational motions), error of the weight, 1 where the weight is the constant 1, degree.
KIND, CENTRE, PER_HALF, OMEGA, ERROR_R, ERROR_T, ERROR_W, STRAIGHT, DEGREE = range(9)
# A pose is a row of the workspace: nine entries of R, three of T, bounds of the errors of either.

HALF_PI = 1.5707963267948966
# |computed - true| of sin and cos of a double below 2^10, see test_sine_bound: the series are cut below 3e-17, the
# reduced angle is good to U, and Horner's rule rounds few times.  Smaller: contacts could be lost.
SINE_EPS = 5e-16


@uncounted
def sine_cosine(x):
    """(sin x, cos x) within SINE_EPS for |x| < 1024."""
    k = round(x / HALF_PI)
    # pi / 2 in two parts, the first of 33 bits: its product with k is exact
    d = (x - k * 1.5707963267341256) - k * 6.077100506506192e-11
    y = d * d
    s = 2.8114572543455206e-15
    s = s * y - 7.647163731819816e-13
    s = s * y + 1.6059043836821613e-10
    s = s * y - 2.505210838544172e-08
    s = s * y + 2.7557319223985893e-06
    s = s * y - 0.0001984126984126984
    s = s * y + 0.008333333333333333
    s = s * y - 0.16666666666666666
    s = d + d * y * s
    c = 4.779477332387385e-14
    c = c * y - 1.1470745597729725e-11
    c = c * y + 2.08767569878681e-09
    c = c * y - 2.755731922398589e-07
    c = c * y + 2.48015873015873e-05
    c = c * y - 0.001388888888888889
    c = c * y + 0.041666666666666664
    c = c * y - 0.5
    c = 1.0 + y * c
    quarter = int(k) & 3
    if quarter == 1:
        return c, -s
    if quarter == 2:
        return -s, -c
    if quarter == 3:
        return -c, s
    return s, c


@uncounted
def pose_at(m, t, w, row):
    """The pose at time t of the stretch, into a row."""
    s = (t - m[0, CENTRE]) * m[0, PER_HALF]
    largest_r, largest_t = 0.0, 0.0
    if m[0, KIND] == TURNING:
        sine, cosine = sine_cosine(m[0, OMEGA] * s)
        for e in range(12):
            w[row, e] = m[1 + e, 0] + (sine * m[1 + e, 1] + (1.0 - cosine) * m[1 + e, 2] + s * m[1 + e, 3])
            if e < 9:
                largest_r = max(largest_r, abs(w[row, e]))
            else:
                largest_t = max(largest_t, abs(w[row, e]))
        w[row, 12], w[row, 13] = m[0, ERROR_R] + 4.0 * U * largest_r, m[0, ERROR_T] + 4.0 * U * largest_t
        return
    top = int(m[0, DEGREE])
    weight = 1.0
    if m[0, STRAIGHT] == 0.0:
        weight = m[13, top]
        for k in range(top - 1, -1, -1):
            weight = weight * s + m[13, k]
    for e in range(12):
        value = m[1 + e, top]
        for k in range(top - 1, -1, -1):
            value = value * s + m[1 + e, k]
        w[row, e] = value / weight
        if e < 9:
            largest_r = max(largest_r, abs(w[row, e]))
        else:
            largest_t = max(largest_t, abs(w[row, e]))
    below = weight - m[0, ERROR_W]
    if below <= 0.0:
        w[row, 12], w[row, 13] = 1e300, 1e300
        return
    w[row, 12] = (m[0, ERROR_R] + largest_r * m[0, ERROR_W]) / below * 1.0001 + 6.0 * U * largest_r
    w[row, 13] = (m[0, ERROR_T] + largest_t * m[0, ERROR_W]) / below * 1.0001 + 6.0 * U * largest_t


@uncounted
def velocity_at(m, t, w, row):
    """Derivatives by time of the twelve entries of R and T, into a row; not proved."""
    s = (t - m[0, CENTRE]) * m[0, PER_HALF]
    if m[0, KIND] == TURNING:
        sine, cosine = sine_cosine(m[0, OMEGA] * s)
        for e in range(12):
            turned = m[0, OMEGA] * (cosine * m[1 + e, 1] + sine * m[1 + e, 2])
            w[row, e] = (turned + m[1 + e, 3]) * m[0, PER_HALF]
        return
    top = int(m[0, DEGREE])
    weight, slope = 1.0, 0.0
    if m[0, STRAIGHT] == 0.0:
        weight = m[13, top]
        for k in range(top - 1, -1, -1):
            slope = slope * s + weight
            weight = weight * s + m[13, k]
    for e in range(12):
        p, dp = m[1 + e, top], 0.0
        for k in range(top - 1, -1, -1):
            dp = dp * s + p
            p = p * s + m[1 + e, k]
        w[row, e] = (dp - p / weight * slope) / weight * m[0, PER_HALF]


@uncounted
def _taylor(m, row, x, reach):
    """Value, first and second derivative of a row's polynomial at x; bounds of the first three for |s| <= reach."""
    p, d1, d2, b0, b1, b2, b3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(int(m[0, DEGREE]), -1, -1):
        c = m[row, k]
        d2 = d2 * x + d1
        d1 = d1 * x + p
        p = p * x + c
        b3 = b3 * reach + b2
        b2 = b2 * reach + b1
        b1 = b1 * reach + b0
        b0 = b0 * reach + abs(c)
    return p, d1, 2.0 * d2, b1, 2.0 * b2, 6.0 * b3


@uncounted
def accelerations(m, t0, t1, w):
    """Enclosures w[MIDDLE] +- w[RADIUS] of the second derivatives by time of the entries of R and T over [t0, t1].

    And w[SPEED] +- w[SPREAD] of the first ones.  Proved; roundings are covered by the last factor and term.
    """
    x = (0.5 * (t0 + t1) - m[0, CENTRE]) * m[0, PER_HALF]
    r = 0.5 * (t1 - t0) * m[0, PER_HALF] * (1.0 + 1e-12) + 1e-15
    square = m[0, PER_HALF] * m[0, PER_HALF]
    if m[0, KIND] == TURNING:
        omega = m[0, OMEGA]
        sine, cosine = sine_cosine(omega * x)
        for e in range(12):
            a, b = m[1 + e, 1], m[1 + e, 2]
            w[MIDDLE, e] = omega * omega * (b * cosine - a * sine) * square
            size = omega * omega * (abs(a) + abs(b)) * square
            w[RADIUS, e] = size * (min(abs(omega) * r, 2.0) * (1.0 + 1e-12) + 1e-13)
            w[SPEED, e] = (omega * (a * cosine + b * sine) + m[1 + e, 3]) * m[0, PER_HALF]
            size = abs(omega) * (abs(a) + abs(b)) * m[0, PER_HALF]
            w[SPREAD, e] = size * (min(abs(omega) * r, 2.0) * (1.0 + 1e-12) + 1e-13) + 1e-14 * abs(w[SPEED, e])
        return
    reach = abs(x) + r
    w0, w1, w2, wr0, wr1, wr2 = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # row 13 first: the entries are divided by it
    for row in range(13, 0, -1):
        p0, p1, p2, b1, b2, b3 = _taylor(m, row, x, reach)
        pr0, pr1, pr2 = r * b1 + 1e-14 * abs(p0), r * b2 + 1e-14 * b1, r * b3 + 1e-14 * b2
        if row == 13:
            if m[0, STRAIGHT] == 0.0:
                w0, w1, w2, wr0, wr1, wr2 = p0, p1, p2, pr0 + m[0, ERROR_W], pr1, pr2
            continue
        below = w0 - wr0
        if below <= 0.0:
            w[MIDDLE, row - 1], w[RADIUS, row - 1], w[SPEED, row - 1], w[SPREAD, row - 1] = 0.0, 1e300, 0.0, 1e300
            continue
        # y = P / w, y' = (P' - y w') / w, y'' = (P'' - 2 y' w' - y w'') / w, as balls
        y0 = p0 / w0
        yr0 = (pr0 + abs(y0) * wr0) / below
        y1 = (p1 - y0 * w1) / w0
        yr1 = (pr1 + abs(y0) * wr1 + yr0 * (abs(w1) + wr1) + abs(y1) * wr0) / below
        y2 = (p2 - 2.0 * y1 * w1 - y0 * w2) / w0
        yr2 = pr2 + 2.0 * (abs(y1) * wr1 + yr1 * (abs(w1) + wr1)) + abs(y0) * wr2 + yr0 * (abs(w2) + wr2)
        yr2 = (yr2 + abs(y2) * wr0) / below
        size = (abs(p2) + 2.0 * abs(y1 * w1) + abs(y0 * w2)) / w0
        w[MIDDLE, row - 1], w[RADIUS, row - 1] = y2 * square, (yr2 + 1e-13 * size) * square * (1.0 + 1e-12)
        size = (abs(p1) + abs(y0 * w1)) / w0
        w[SPEED, row - 1] = y1 * m[0, PER_HALF]
        w[SPREAD, row - 1] = (yr1 + 1e-13 * size) * m[0, PER_HALF] * (1.0 + 1e-12)
