"""Bodies above the plane z = 0 that touch it at the origin, with their insides right above."""

from __future__ import annotations

from fractions import Fraction as F

import firstcontact as fc

LYING = [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
UPSIDE_DOWN = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]

# Bodies above z = 0 that touch it at the origin.
STANDING = {
    "ball": fc.sphere(20).translated((0, 0, 20)),
    "small ball": fc.sphere("1/7").translated((0, 0, "1/7")),
    "ellipsoid": fc.ellipsoid((1, 2, 3)).translated((0, 0, 3)),
    "flat ellipsoid": fc.ellipsoid((30, 2, "1/3")).translated((0, 0, "1/3")),
    "cylinder": fc.cylinder(5, 10).translated((1, 1, 5)),
    "cylinder on its side": fc.cylinder(5, 10).transformed(LYING).translated((1, 0, 5)),
    "rim": fc.cylinder(2, 6).transformed([["3/5", 0, "4/5", 0], [0, 1, 0, 0], ["-4/5", 0, "3/5", 0], [0, 0, 0, 1]])
    .translated(("6/5", 0, "17/5")),
    "cone": fc.cone(3, 4),
    "tip": fc.cone(1, 2).transformed(UPSIDE_DOWN).translated((0, 0, 2)),
    "frustum": fc.frustum(1, 2, 3),
    "bowl": fc.paraboloid((1, 2), 3),
    "box": fc.box((2, 3, 4)).translated((0, 0, 2)),
}  # fmt: skip


def half_turn(n):
    """By 180 degrees about n, as a rational matrix."""
    size = sum(x * x for x in n)
    return [[F(2 * n[i] * n[j], size) - (i == j) for j in range(3)] + [0] for i in range(3)] + [[0, 0, 0, 1]]
