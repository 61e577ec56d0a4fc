"""Unevaluated sums of two doubles: numbers of some 106 bits, for what doubles nearly tell.

x = (x, r): x the double nearest to the sum.  With u = 2^-53, a sum is within 3.01 u^2 of the true one (Joldes, Muller,
Popescu, "Tight and rigorous error bounds for basic building blocks of double-word arithmetic", 2017, algorithm 6), a
product within 7 u^2 (algorithm 10, with Dekker's product), relative, as long as nothing leaves the range of doubles.
"""

from __future__ import annotations

from firstcontact.kernels.jit import kernel

SPLITTER = 2.0**27 + 1.0


@kernel
def two_sum(a, b):
    """a + b, exact."""
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@kernel
def joined(x, r):
    """x + r, exact; r is not above x."""
    s = x + r
    return s, r - (s - x)


@kernel
def two_product(a, b):
    """a b, exact (Dekker 1971); |a|, |b| < 2^990."""
    p = a * b
    t = SPLITTER * a
    a1 = t - (t - a)
    a2 = a - a1
    t = SPLITTER * b
    b1 = t - (t - b)
    b2 = b - b1
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


@kernel
def add(x, r, y, s):
    h, l = two_sum(x, y)  # noqa: E741
    t, e = two_sum(r, s)
    h, l = joined(h, l + t)  # noqa: E741
    return joined(h, l + e)


@kernel
def multiply(x, r, y, s):
    p, e = two_product(x, y)
    return joined(p, e + (x * s + r * y))


@kernel
def divide(x, r, y, s):
    """Within 2^-100 of the quotient, relative: two steps of long division."""
    q = x / y
    p, e = multiply(q, 0.0, y, s)
    rest, _ = add(x, r, -p, -e)
    return joined(q, rest / y)


@kernel
def minor(x0, r0, x1, r1, y0, s0, y1, s1):
    """x0 y1 - x1 y0."""
    p, e = multiply(x0, r0, y1, s1)
    q, f = multiply(x1, r1, y0, s0)
    return add(p, e, -q, -f)
