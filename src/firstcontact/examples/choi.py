"""Examples 7 and 8 of Choi et al. 2014, each as (a, b) under rational motions.

>>> a, b = example_7()
>>> a.body
<CompositeQuadric: 3 faces, 2 edges, 0 vertices>
"""

from __future__ import annotations

from fractions import Fraction
from math import cos, pi, sin
from typing import TYPE_CHECKING

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.primitives import cylinder, frustum, half_space
from firstcontact.motion.moving import Moving
from firstcontact.motion.rational import RationalMotion

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given

Point = tuple[int, int, int]


def example_7() -> tuple[Moving, Moving]:
    """Two capped elliptic cylinders; one translates, one turns and translates.  They touch at 5/8."""
    drum = cylinder((5, 10), 10)
    a = [[[1, 0, 0, 30], [0, 1, 0, 20], [0, 0, 1, 0], [0, 0, 0, 1]], [[0, 0, 0, -60], [0] * 4, [0] * 4, [0] * 4]]
    b = [
        [[0, 0, 1, 30], [0, 1, 0, -50], [-1, 0, 0, 0], [0, 0, 0, 1]],
        [[2, 0, -2, -120], [0, -2, 0, 180], [2, 0, 2, 0], [0, 0, 0, -2]],
        [[-2, 0, 0, 180], [0, 2, 0, -260], [0, 0, -2, 0], [0, 0, 0, 2]],
        [[0, 0, 0, -120], [0, 0, 0, 160], [0] * 4, [0] * 4],
    ]
    return drum.moving(RationalMotion(a)), drum.moving(RationalMotion(b))


def example_8() -> tuple[Moving, Moving]:
    """A latch and a stepped pin with as many features of every kind as the models of the paper's Example 8.

    a: 4 cylinders, 9 planes, 10 circles, 14 lines, 8 vertices.  b: 3 cylinders, 1 cone, 3 planes, 6 circles.
    The paper gives the dimensions of one pair of features only, a rim of a and the cone of b; they are these, so are
    the motions, and the rest keeps out of that pair's way: they touch first, at 0.31324460346078811 (the sine and
    cosine of pi/8 are rounded to doubles).
    """
    turn = ((sin(pi / 8), 0, 0, -cos(pi / 8)), (1, -1, 0, 0))
    a = RationalMotion.between((15, 15, 0), (-30, -10, 0), quat_wxyz=((1, 0, 0, 0), (1, 0, 0, 0)))
    b = RationalMotion.between((-30, -1, 10), (30, -10, -10), quat_wxyz=turn)
    return _latch().moving(a), _stepped_pin().moving(b)


def _latch() -> CompositeQuadric:
    """A wedge along x with a rib across its top, flush with the back; a rod through it, three dowels at the back.

    All ends of the rod and of the dowels at the back are in one plane.
    """
    left, right = [(-5, 3, -6), (-2, 3, -6)], [(-5, 3, 6), (-2, 3, 6)]
    keel = [(-5, -6, 0), (-2, -6, 0)]
    top, foot, peak = (left[0], right[1]), (-2, 3, -2), (-2, 5, 1)
    latch = _wedge(left, right, keel).named("wedge") | _tetrahedron(*top, foot, peak).named("rib")
    latch = latch | _along_x(2, -6, -1).named("rod")
    for k, place in enumerate([(0, 2, -4), (0, 2, 4), (0, -4, 0)], 1):
        latch = latch | _along_x(Fraction(1, 2), -2, -1).translated(place).named(f"dowel {k}")
    return latch.translated((0, -10, 0)).named("latch")


def _stepped_pin() -> CompositeQuadric:
    """A pin along y: radii 3, 2 and 1, with a cone x^2 + z^2 = (8 - y)^2 between the last two."""
    pin = cylinder(3, 2).translated((0, 0, 1)).named("head") | cylinder(2, 6).translated((0, 0, 3)).named("shank")
    pin = pin | frustum(2, 1, 1).translated((0, 0, 6)).named("taper")
    pin = pin | cylinder(1, Fraction(1, 4)).translated((0, 0, Fraction(57, 8))).named("tip")
    return pin.rotated((1, 0, 0), degrees=-90).named("pin")


def _along_x(radius: Given | tuple[Given, Given], start: int, end: int) -> CompositeQuadric:
    rod = cylinder(radius, end - start).rotated((0, 1, 0), degrees=90)
    return rod.translated((Fraction(start + end, 2), 0, 0))


def _wedge(*edges: list[Point]) -> CompositeQuadric:
    """The prism with these three parallel edges."""
    (a0, a1), (b0, b1), (c0, c1) = edges
    ends = _behind(a0, b0, c0, a1) & _behind(a1, b1, c1, a0)
    return ends & _behind(a0, a1, b0, c0) & _behind(b0, b1, c0, a0) & _behind(c0, c1, a0, b0)


def _tetrahedron(a: Point, b: Point, c: Point, d: Point) -> CompositeQuadric:
    return _behind(a, b, c, d) & _behind(a, b, d, c) & _behind(a, c, d, b) & _behind(b, c, d, a)


def _behind(a: Point, b: Point, c: Point, inner: Point) -> CompositeQuadric:
    """The half-space bounded by the plane through a, b and c, on the side of `inner`."""
    u, v = ([q - p for p, q in zip(a, other, strict=True)] for other in (b, c))
    normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    offset, level = (sum(n * x for n, x in zip(normal, p, strict=True)) for p in (a, inner))
    return half_space(normal, offset) if level < offset else half_space([-n for n in normal], -offset)
