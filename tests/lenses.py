"""Two solids that touch in one point, pushed into each other or apart by a known depth along the common normal.

The surfaces are built from a point and a unit normal with rational coordinates, so that nothing is rounded; what
is known of them (where the lens is, that its middle lies inside both) is decided by their equations as given here.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction as F
from itertools import product
from random import Random

import firstcontact as fc


@dataclass
class Touching:
    """A solid with a point of its curved face; normal: outward, of length one; value: its form there and elsewhere."""

    solid: fc.CompositeQuadric
    point: tuple
    normal: tuple
    value: object
    convex: bool = True


@dataclass
class Pair:
    """Both solids placed; middle: between the two points; inside: the forms of both at the middle, negative inside."""

    a: fc.CompositeQuadric
    b: fc.CompositeQuadric
    middle: tuple
    inside: tuple


def unit(r: Random, n: int) -> tuple:
    """A rational point of the unit circle or sphere, no coordinate zero or tiny."""
    while True:
        t = [F(r.randint(-9, 9), r.randint(2, 7)) for _ in range(n - 1)]
        s = sum(x * x for x in t)
        p = (*(2 * x / (1 + s) for x in t), (s - 1) / (1 + s))
        if min(map(abs, p)) > F(1, 8):
            return p


def same_signs(p: tuple, q: tuple) -> tuple:
    return tuple(abs(x) if y > 0 else -abs(x) for x, y in zip(p, q, strict=True))


def sphere(r):
    k, n = F(r.randint(1, 40), 2), unit(r, 3)
    return Touching(fc.sphere(k), scaled(k, n), n, lambda p: sum(x * x for x in p) - k * k)


def ellipsoid(r):
    n = unit(r, 3)
    s = same_signs(unit(r, 3), n)
    radii = [x / y for x, y in zip(s, n, strict=True)]
    point = tuple(a * x for a, x in zip(radii, s, strict=True))
    form = lambda p: sum((x / a) ** 2 for x, a in zip(p, radii, strict=True)) - 1  # noqa: E731
    return Touching(fc.ellipsoid(radii), point, n, form)


def cylinder(r):
    k, n = F(r.randint(1, 20), 2), unit(r, 2)
    return Touching(fc.cylinder(k, 8), (*scaled(k, n), F(1)), (*n, F(0)), lambda p: p[0] ** 2 + p[1] ** 2 - k * k)


def elliptic_cylinder(r):
    n = unit(r, 2)
    s = same_signs(unit(r, 2), n)
    a, b = (x / y for x, y in zip(s, n, strict=True))
    form = lambda p: (p[0] / a) ** 2 + (p[1] / b) ** 2 - 1  # noqa: E731
    return Touching(fc.cylinder(radii=(a, b), height=8), (a * s[0], b * s[1], F(-1)), (*n, F(0)), form)


def cone(r):
    return _cone(r, F(1))


def frustum(r):
    return _cone(r, F(3, 4))


def _cone(r, share):
    """Of slope 3/4 or 5/12, cut at that share of its height h."""
    radius, h, slant = r.choice([(F(3), F(4), 5), (F(5), F(12), 13)])
    n = unit(r, 2)
    z = h / 2
    here = radius * (1 - z / h)
    normal = (n[0] * h / slant, n[1] * h / slant, radius / slant)
    body = fc.cone(radius, h) if share == 1 else fc.frustum(radius, radius * (1 - share), h * share)
    form = lambda p: p[0] ** 2 + p[1] ** 2 - (radius * (1 - p[2] / h)) ** 2  # noqa: E731
    return Touching(body, (*scaled(here, n), z), normal, form)


def paraboloid(r):
    n = unit(r, 3)
    n = (*n[:2], -abs(n[2]))
    s = same_signs(scaled(F(3, 2), unit(r, 2)), n[:2])
    a, b = (-2 * x * n[2] / y for x, y in zip(s, n[:2], strict=True))  # gradient (2 x/a^2, 2 y/b^2, -1)
    a, b = abs(a), abs(b)
    form = lambda p: (p[0] / a) ** 2 + (p[1] / b) ** 2 - p[2]  # noqa: E731
    height = s[0] ** 2 + s[1] ** 2
    return Touching(fc.paraboloid((a, b), 2 * height), (a * s[0], b * s[1], height), n, form)


def one_sheet(r):
    return _hyperboloid(r, 1)


def two_sheets(r):
    return _hyperboloid(r, 2)


def _hyperboloid(r, sheets):
    """s on the hyperboloid with radii 1; the radii make its normal the unit vector n."""
    n = unit(r, 3)
    n = (*n[:2], -abs(n[2]))
    c, d = unit(r, 2)
    t = F(r.randint(1, 3), 4)
    rise, reach = 2 * t / (1 - t * t), (1 + t * t) / (1 - t * t)  # reach^2 - rise^2 = 1
    s = (reach * c, reach * d, rise) if sheets == 1 else (rise * c, rise * d, reach)
    s = (*same_signs(s[:2], n[:2]), s[2])
    radii = (s[0] / n[0], s[1] / n[1], -s[2] / n[2])
    sign = 1 if sheets == 1 else -1
    form = lambda p: sum(k * (x / a) ** 2 for k, x, a in zip((1, 1, -1), p, radii, strict=True)) - sign  # noqa: E731
    point = tuple(a * x for a, x in zip(radii, s, strict=True))
    height = 4 * point[2] if sheets == 1 else 2 * point[2]
    return Touching(fc.hyperboloid(radii, height, sheets), point, n, form, convex=sheets == 2)


KINDS = (sphere, ellipsoid, cylinder, elliptic_cylinder, cone, frustum, paraboloid, one_sheet, two_sheets)
PAIRS = [(p, q) for p, q in product(KINDS, repeat=2) if KINDS.index(p) <= KINDS.index(q) and p is not one_sheet
         and (q is not one_sheet or p is sphere)]  # fmt: skip
"""A hyperboloid of one sheet is no convex solid: it meets small balls only."""


def pushed(kinds, depth: F, r: Random) -> Pair:
    """Two solids of these kinds whose points overlap by the depth, turned and shifted together."""
    a, b = (kind(r) for kind in kinds)
    if not b.convex:
        k = F(1, 50)
        a = Touching(fc.sphere(k), scaled(k, a.normal), a.normal, lambda p: sum(x * x for x in p) - k * k)
    onto = turning(b.normal, scaled(-1, a.normal), r)
    moved = apply(onto, b.point)
    shift = [p - q - depth * n for p, q, n in zip(a.point, moved, a.normal, strict=True)]
    middle = tuple(p - depth / 2 * n for p, n in zip(a.point, a.normal, strict=True))
    back = apply(transposed(onto), [x - s for x, s in zip(middle, shift, strict=True)])
    around, place = turning(unit(r, 3), unit(r, 3), r), [F(r.randint(-9, 9), 3) for _ in range(3)]
    first = a.solid.transformed(affine(around, place))
    second = b.solid.transformed(affine(onto, shift)).transformed(affine(around, place))
    at = tuple(x + s for x, s in zip(apply(around, middle), place, strict=True))
    return Pair(first, second, at, (a.value(middle), b.value(back)))


# -- rational vectors and turns -------------------------------------------------------------------------------------


def scaled(k, v):
    return tuple(k * x for x in v)


def apply(m, v):
    return tuple(sum(x * y for x, y in zip(row, v, strict=True)) for row in m)


def transposed(m):
    return tuple(zip(*m, strict=True))


def affine(m, shift):
    return [[*row, s] for row, s in zip(m, shift, strict=True)] + [[0, 0, 0, 1]]


def mirror(v):
    """The reflection that takes v to -v."""
    square = sum(x * x for x in v)
    return tuple(tuple(F(i == j) - 2 * v[i] * v[j] / square for j in range(3)) for i in range(3))


def turning(start, end, r: Random):
    """A rational rotation that takes one unit vector to the other: two reflections."""
    (a, b, c), (d, e, f) = end, unit(r, 3)
    across = (b * f - c * e, c * d - a * f, a * e - b * d)
    first = mirror([x - y for x, y in zip(start, end, strict=True)]) if start != end else mirror(across)
    second = mirror(across)
    return tuple(apply(transposed(first), row) for row in second)
