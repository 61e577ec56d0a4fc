"""Arithmetic of linear Taylor models: enclosures c + g.e + [-r, r] of functions over a box, with all rounding in r.

A model is a row (c, g_1 .. g_5, r) of the workspace; e in [-1, 1]^5 is the place in the box in units of its half
widths, in the order u, s, v, t, T (Makino and Berz's models of first order).  Rows may be given twice, and the result
may replace an operand.
"""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted

VARIABLES = 5
REST = 6
"""Column of r."""
ROUND = 4e-16
"""Above three units of rounding: of a product, a sum and the bound itself."""
MORE = 1.0 + 1e-14
"""Covers the rounding of sums of remainders."""


@uncounted
def slope_size(w, a):
    """Sum of |g|."""
    return abs(w[a, 1]) + abs(w[a, 2]) + abs(w[a, 3]) + abs(w[a, 4]) + abs(w[a, 5])


@uncounted
def difference(w, out, a, b):
    """a - b."""
    rest, size = w[a, REST] + w[b, REST], 0.0
    for k in range(6):
        size += abs(w[a, k]) + abs(w[b, k])
        w[out, k] = w[a, k] - w[b, k]
    w[out, REST] = rest * MORE + ROUND * size


@uncounted
def total(w, out, a, b):
    """a + b."""
    rest, size = w[a, REST] + w[b, REST], 0.0
    for k in range(6):
        size += abs(w[a, k]) + abs(w[b, k])
        w[out, k] = w[a, k] + w[b, k]
    w[out, REST] = rest * MORE + ROUND * size


@uncounted
def product(w, out, a, b):
    """a b; the products of the linear parts go to the remainder."""
    x, y = w[a, 0], w[b, 0]
    p, q = slope_size(w, a), slope_size(w, b)
    r, s = w[a, REST], w[b, REST]
    for k in range(1, 6):
        w[out, k] = x * w[b, k] + y * w[a, k]
    w[out, 0] = x * y
    x, y = abs(x), abs(y)
    w[out, REST] = (x * s + y * r + (p + r) * (q + s)) * MORE + 4.0 * ROUND * (x + p) * (y + q)


@uncounted
def quotient(w, out, a, b):
    """a / b; False where b may vanish."""
    p, q, r, s = slope_size(w, a), slope_size(w, b), w[a, REST], w[b, REST]
    x, y = w[a, 0], w[b, 0]
    least = (abs(y) - (q + s) * MORE) * (1.0 - ROUND)
    if not least > 0.0:
        return False
    z, size = x / y, 0.0
    for k in range(1, 6):
        g = (w[a, k] - z * w[b, k]) / y
        size += abs(g)
        w[out, k] = g
    w[out, 0] = z
    z = abs(z)
    # a - (z + g.e) b, over b
    left = r + z * s + size * (q + s) + 4.0 * ROUND * (abs(x) + p + (z + size) * (abs(y) + q))
    w[out, REST] = left * MORE / least * MORE
    return True


@uncounted
def inner(w, out, a, b, scratch):
    """a . b of rows a to a + 2 and b to b + 2."""
    product(w, out, a, b)
    for k in range(1, 3):
        product(w, scratch, a + k, b + k)
        total(w, out, out, scratch)


@uncounted
def cross(w, out, a, b, scratch):
    """a x b, in rows out to out + 2, none of which is an operand."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        product(w, out + k, a + i, b + j)
        product(w, scratch, a + j, b + i)
        difference(w, out + k, out + k, scratch)
