"""Poses of moving bodies at a time, with proved errors; their velocities; enclosures of their accelerations.

A motion is x -> R x + T.  `head` and `coefficients` describe it on one stretch of time by s = (t - middle) / half:
kind RATIONAL: entries are polynomials in s over a common weight; kind TURNING: entries are linear in
1, sin(omega s), 1 - cos(omega s), s.
"""

from __future__ import annotations

from firstcontact.kernels.jit import kernel

U = 2.0**-53
RATIONAL, TURNING = 0.0, 1.0
# Slots of the head: kind, middle and 1 / half of the stretch, omega, proved errors of the entries of R and T (of
# numerators, for rational motions), error of the weight, 1 where the weight is the constant 1, bound of the norm of R^-1.
KIND, MIDDLE, PER_HALF, OMEGA, ERROR_R, ERROR_T, ERROR_W, STRAIGHT, INVERSE = range(9)
# Slots of a pose: nine of R by rows, three of T, bounds of the errors of their entries.
ROOM = 14

HALF_PI_HI = 1.5707963267948966
HALF_PI_LO = 6.123233995736766e-17
# |computed - true| of sin and cos of a double below 2^10, see test_sine_bound: the series are cut below 3e-17, the
# reduced angle is good to U, and Horner's rule rounds few times.  Smaller: contacts could be lost.
SINE_EPS = 5e-16


@kernel
def sine_cosine(x):
    """(sin x, cos x) within SINE_EPS for |x| < 1024."""
    k = round(x / HALF_PI_HI)
    # k < 2^10 has ten bits: the product's low half is recovered by splitting pi / 2
    hi = 1.5707963267341256  # the first 33 bits of pi / 2: k * hi is exact
    lo = 6.077100506506192e-11  # the rest
    d = (x - k * hi) - k * lo
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


@kernel
def pose_at(head, coefficients, t, out):
    """The pose at time t of the stretch, into out (ROOM,)."""
    s = (t - head[MIDDLE]) * head[PER_HALF]
    largest_r, largest_t = 0.0, 0.0
    if head[KIND] == TURNING:
        sine, cosine = sine_cosine(head[OMEGA] * s)
        for e in range(12):
            c = coefficients
            out[e] = c[e, 0] + (sine * c[e, 1] + (1.0 - cosine) * c[e, 2] + s * c[e, 3])
            if e < 9:
                largest_r = max(largest_r, abs(out[e]))
            else:
                largest_t = max(largest_t, abs(out[e]))
        out[12], out[13] = head[ERROR_R] + 4.0 * U * largest_r, head[ERROR_T] + 4.0 * U * largest_t
        return
    top = coefficients.shape[1] - 1
    weight = 1.0
    if head[STRAIGHT] == 0.0:
        weight = coefficients[12, top]
        for k in range(top - 1, -1, -1):
            weight = weight * s + coefficients[12, k]
    for e in range(12):
        value = coefficients[e, top]
        for k in range(top - 1, -1, -1):
            value = value * s + coefficients[e, k]
        out[e] = value / weight
        if e < 9:
            largest_r = max(largest_r, abs(out[e]))
        else:
            largest_t = max(largest_t, abs(out[e]))
    below = weight - head[ERROR_W]
    if below <= 0.0:
        out[12], out[13] = 1e300, 1e300
        return
    out[12] = (head[ERROR_R] + largest_r * head[ERROR_W]) / below * 1.0001 + 6.0 * U * largest_r
    out[13] = (head[ERROR_T] + largest_t * head[ERROR_W]) / below * 1.0001 + 6.0 * U * largest_t


@kernel
def velocity_at(head, coefficients, t, out):
    """Derivatives by time of the twelve entries of R and T, into out (12,); not proved."""
    s = (t - head[MIDDLE]) * head[PER_HALF]
    if head[KIND] == TURNING:
        sine, cosine = sine_cosine(head[OMEGA] * s)
        for e in range(12):
            turned = head[OMEGA] * (cosine * coefficients[e, 1] + sine * coefficients[e, 2])
            out[e] = (turned + coefficients[e, 3]) * head[PER_HALF]
        return
    top = coefficients.shape[1] - 1
    w, dw = 1.0, 0.0
    if head[STRAIGHT] == 0.0:
        w = coefficients[12, top]
        for k in range(top - 1, -1, -1):
            dw = dw * s + w
            w = w * s + coefficients[12, k]
    for e in range(12):
        p, dp = coefficients[e, top], 0.0
        for k in range(top - 1, -1, -1):
            dp = dp * s + p
            p = p * s + coefficients[e, k]
        out[e] = (dp - p / w * dw) / w * head[PER_HALF]


@kernel
def _taylor(coefficients, e, m, reach):
    """Value, first and second derivative of polynomial e at m, and bounds of the first three for |s| <= reach."""
    p, d1, d2, b0, b1, b2, b3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(coefficients.shape[1] - 1, -1, -1):
        c = coefficients[e, k]
        d2 = d2 * m + d1
        d1 = d1 * m + p
        p = p * m + c
        b3 = b3 * reach + b2
        b2 = b2 * reach + b1
        b1 = b1 * reach + b0
        b0 = b0 * reach + abs(c)
    return p, d1, 2.0 * d2, b1, 2.0 * b2, 6.0 * b3


@kernel
def accelerations(head, coefficients, t0, t1, middle, radius):
    """Enclosures middle +- radius (12,) of the second derivatives by time of the entries of R and T over [t0, t1].

    Proved; roundings are covered by the last factor and term.
    """
    m = (0.5 * (t0 + t1) - head[MIDDLE]) * head[PER_HALF]
    r = 0.5 * (t1 - t0) * head[PER_HALF] * (1.0 + 1e-12) + 1e-15
    square = head[PER_HALF] * head[PER_HALF]
    if head[KIND] == TURNING:
        omega = head[OMEGA]
        sine, cosine = sine_cosine(omega * m)
        for e in range(12):
            a, b = coefficients[e, 1], coefficients[e, 2]
            middle[e] = omega * omega * (b * cosine - a * sine) * square
            size = omega * omega * (abs(a) + abs(b)) * square
            radius[e] = size * (min(abs(omega) * r, 2.0) * (1.0 + 1e-12) + 1e-13)
        return
    reach = abs(m) + r
    w0, w1, w2, wr0, wr1, wr2 = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if head[STRAIGHT] == 0.0:
        w0, w1, w2, b1, b2, b3 = _taylor(coefficients, 12, m, reach)
        wr0, wr1, wr2 = r * b1 + 1e-14 * abs(w0) + head[ERROR_W], r * b2 + 1e-14 * b1, r * b3 + 1e-14 * b2
    below = w0 - wr0
    for e in range(12):
        p0, p1, p2, b1, b2, b3 = _taylor(coefficients, e, m, reach)
        pr0, pr1, pr2 = r * b1 + 1e-14 * abs(p0), r * b2 + 1e-14 * b1, r * b3 + 1e-14 * b2
        if head[STRAIGHT] != 0.0:
            middle[e], radius[e] = p2 * square, pr2 * square * (1.0 + 1e-12)
            continue
        if below <= 0.0:
            middle[e], radius[e] = 0.0, 1e300
            continue
        # x = P / w, x' = (P' - x w') / w, x'' = (P'' - 2 x' w' - x w'') / w, as balls
        x0 = p0 / w0
        xr0 = (pr0 + abs(x0) * wr0) / below
        n = p1 - x0 * w1
        x1 = n / w0
        xr1 = (pr1 + abs(x0) * wr1 + xr0 * (abs(w1) + wr1) + abs(x1) * wr0) / below
        n = p2 - 2.0 * x1 * w1 - x0 * w2
        x2 = n / w0
        xr2 = pr2 + 2.0 * (abs(x1) * wr1 + xr1 * (abs(w1) + wr1)) + abs(x0) * wr2 + xr0 * (abs(w2) + wr2)
        xr2 = (xr2 + abs(x2) * wr0) / below
        size = (abs(p2) + 2.0 * abs(x1 * w1) + abs(x0 * w2)) / w0
        middle[e], radius[e] = x2 * square, (xr2 + 1e-13 * size) * square * (1.0 + 1e-12)
