"""The builders of composite quadric models; all numbers exact (Choi et al. 2014, section 2.1, names the family)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Plane,
    Quadric,
    Rows,
    Surface,
    Vector,
    diagonalised,
    inertia,
    primitive,
)
from firstcontact.body.solid.composite_quadric import LEAST, CompositeQuadric, form_of, solid
from firstcontact.body.solid.csg import And, Leaf, Not, Or
from firstcontact.body.solid.feature_names import LabelledPart
from firstcontact.body.solid.intersections import linear_factors
from firstcontact.body.solid.recipe import recorded
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational
from firstcontact.motion.translation import LARGEST, vector3

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given

ORIGIN = (ZERO, ZERO, ZERO)


@recorded
def box(size: Iterable[Given], *, name: str | None = None) -> CompositeQuadric:
    """The box centred on the origin with edges `size` = (x, y, z) long; faces "x-", "x+", "y-", ...

    >>> box((1, 2, 3))
    <CompositeQuadric: 6 faces, 12 edges, 8 vertices>
    """
    half = tuple(x / 2 for x in _positive3(size, "box size"))
    leaves: list[tuple[str, Surface]] = []
    for k in range(3):
        for sign, mark in ((-1, "-"), (1, "+")):
            normal = tuple(fmpq(sign if i == k else 0) for i in range(3))
            leaves.append(("xyz"[k] + mark, plane(normal, half[k])))
    return solid(leaves, box=(tuple(-x for x in half), half), witness=ORIGIN, name=name)


@recorded
def sphere(radius: Given, *, name: str | None = None) -> CompositeQuadric:
    """The ball about the origin; its face is "surface"."""
    return _ellipsoid((_positive(radius, "sphere radius"),) * 3, name)


@recorded
def ellipsoid(radii: Iterable[Given], *, name: str | None = None) -> CompositeQuadric:
    """x^2/a^2 + y^2/b^2 + z^2/c^2 <= 1 for radii = (a, b, c); its face is "surface"."""
    return _ellipsoid(_positive3(radii, "ellipsoid radii"), name)


def _ellipsoid(radii: Vector, name: str | None) -> CompositeQuadric:
    a, b, c = radii
    surface = diagonal(1 / a**2, 1 / b**2, 1 / c**2, -ONE)
    return solid([("surface", surface)], box=(tuple(-r for r in radii), radii), witness=ORIGIN, name=name)


@recorded
def cylinder(
    radius: Given | Iterable[Given] = None,
    height: Given = None,
    *,
    radii: Given | Iterable[Given] = None,
    name: str | None = None,
) -> CompositeQuadric:
    """The cylinder about z with |z| <= height/2; radius or radii: one number, or (a, b) for an elliptic one.

    Faces "side", "top", "bottom", edges "rim.top", "rim.bottom".

    >>> cylinder(1, 2)
    <CompositeQuadric: 3 faces, 2 edges, 0 vertices>
    """
    if (radius is None) == (radii is None):
        raise InputError("cylinder needs exactly one of radius and radii; give radius=r or radii=(a, b)")
    if height is None:
        raise InputError("cylinder height is missing; give a positive number")
    a, b = _radii(radius, "cylinder radius") if radii is None else _radii(radii, "cylinder radii")
    h = _positive(height, "cylinder height") / 2
    side: Surface = diagonal(1 / a**2, 1 / b**2, ZERO, -ONE)
    leaves = [("side", side), ("top", up(h)), ("bottom", down(-h))]
    return solid(leaves, RIMS, box=((-a, -b, -h), (a, b, h)), witness=ORIGIN, name=name)


@recorded
def cone(radius: Given, height: Given, *, name: str | None = None) -> CompositeQuadric:
    """The cone about z with its base at z = 0 and its tip at z = height.

    Faces "side", "bottom", edge "rim.bottom", vertex "apex".
    """
    return _frustum(_positive(radius, "cone radius"), ZERO, _positive(height, "cone height"), name)


@recorded
def frustum(bottom: Given, top: Given, height: Given, *, name: str | None = None) -> CompositeQuadric:
    """The truncated cone about z: radius `bottom` at z = 0 and `top` at z = height; one of them may be 0."""
    r0, r1 = _not_negative(bottom, "frustum bottom"), _not_negative(top, "frustum top")
    if r0 == r1 == 0:
        raise InputError("frustum bottom and top are both 0; give at least one positive radius")
    return _frustum(r0, r1, _positive(height, "frustum height"), name)


def _frustum(r0: fmpq, r1: fmpq, h: fmpq, name: str | None) -> CompositeQuadric:
    k = (r0 - r1) / h  # the radius at height z is r0 - k z
    side = form_of(
        ((ONE, ZERO, ZERO, ZERO), (ZERO, ONE, ZERO, ZERO), (ZERO, ZERO, -k * k, r0 * k), (ZERO, ZERO, r0 * k, -r0 * r0))
    )
    r = max(r0, r1)
    leaves: list[tuple[str, Surface]] = [("side", side), ("top", up(h)), ("bottom", down(ZERO))]
    return solid(leaves, RIMS, box=((-r, -r, ZERO), (r, r, h)), witness=(ZERO, ZERO, h / 2), name=name)


@recorded
def paraboloid(radii: Given | Iterable[Given], height: Given, *, name: str | None = None) -> CompositeQuadric:
    """x^2/a^2 + y^2/b^2 <= z <= height; radii: one number or (a, b).  Faces "side", "top", edge "rim.top"."""
    a, b = _radii(radii, "paraboloid radii")
    h = _positive(height, "paraboloid height")
    half = fmpq(-1, 2)
    side = form_of(
        ((1 / a**2, ZERO, ZERO, ZERO), (ZERO, 1 / b**2, ZERO, ZERO), (ZERO, ZERO, ZERO, half), (ZERO, ZERO, half, ZERO))
    )
    # sqrt(h) <= (h + 1) / 2 bounds the rim without a square root
    root = (h + 1) / 2
    return solid(
        [("side", side), ("top", up(h))],
        RIMS,
        box=((-a * root, -b * root, ZERO), (a * root, b * root, h)),
        witness=(ZERO, ZERO, h / 2),
        name=name,
    )


@recorded
def hyperboloid(radii: Iterable[Given], height: Given, sheets: int = 1, *, name: str | None = None) -> CompositeQuadric:
    """x^2/a^2 + y^2/b^2 - z^2/c^2 <= 1 and |z| <= height/2 for radii = (a, b, c).

    sheets=2: the cap z^2/c^2 - x^2/a^2 - y^2/b^2 >= 1, 0 <= z <= height; height must exceed c.
    Faces "side", "top", "bottom", edges "rim.top", "rim.bottom".
    """
    a, b, c = _positive3(radii, "hyperboloid radii")
    h = _positive(height, "hyperboloid height")
    if sheets not in (1, 2):
        raise InputError(f"hyperboloid sheets is {sheets!r}; give 1 or 2")
    lo, hi = (-h / 2, h / 2) if sheets == 1 else (ZERO, h)
    if sheets == 2 and h <= c:
        raise InputError("hyperboloid height does not exceed the third radius: the cap is empty; give a larger height")
    side = diagonal(1 / a**2, 1 / b**2, -1 / c**2, fmpq(-1 if sheets == 1 else 1))
    reach = 1 + hi / c  # sqrt(1 + (h/c)^2) <= 1 + h/c
    box_ = ((-a * reach, -b * reach, lo), (a * reach, b * reach, hi))
    witness = ORIGIN if sheets == 1 else (ZERO, ZERO, (c + h) / 2)
    return solid([("side", side), ("top", up(hi)), ("bottom", down(lo))], RIMS, box=box_, witness=witness, name=name)


@recorded
def half_space(normal: Iterable[Given], offset: Given, *, name: str | None = None) -> CompositeQuadric:
    """normal . x <= offset; its face is "plane"."""
    n = vector3(normal, "half_space normal")
    if not any(n):
        raise InputError("half_space normal is zero; give a direction such as (0, 0, 1)")
    return solid([("plane", plane(n, rational(offset, "half_space offset")))], name=name)


@recorded
def quadric(matrix: Iterable[Iterable[Given]], *, name: str | None = None) -> CompositeQuadric:
    """X^T Q X <= 0 for X = (x, y, z, 1) and a symmetric 4x4 matrix Q; its face is "surface".

    A product of two rational planes is taken apart into them ("plane 1", "plane 2"), so they meet in an edge.
    """
    rows = [list(row) if np.iterable(row) else [] for row in matrix] if np.iterable(matrix) else []
    if len(rows) != 4 or any(len(row) != 4 for row in rows):
        raise InputError("quadric needs a symmetric 4x4 matrix")
    form: Rows = tuple(
        tuple(rational(x, f"quadric matrix[{i}][{j}]") for j, x in enumerate(row)) for i, row in enumerate(rows)
    )
    for i in range(4):
        for j in range(i):
            if form[i][j] != form[j][i]:
                raise InputError(f"quadric matrix is not symmetric: entries [{i}][{j}] and [{j}][{i}] differ")
    sizes = [abs(x) for row in form for x in row if x]
    if sizes and max(sizes) * LEAST**2 > min(sizes):
        raise InputError("quadric matrix has entries whose sizes differ by more than 2^300; give more even ones")
    positive, negative = inertia(form)
    if positive == 0 or negative == 0:
        if positive:
            raise InputError("quadric: the form is never negative, so the solid has no interior; check its signs")
        raise InputError("quadric: the form is nowhere positive, so the solid is all of space; check its signs")
    if positive + negative > 2:
        return solid([("surface", form_of(form))], name=name)
    return _plane_pair(form, name)


def _plane_pair(form: Rows, name: str | None) -> CompositeQuadric:
    """The solid where a form of rank 2 is negative: on opposite sides of its two planes."""
    factors = linear_factors(form)
    if factors is None:
        raise InputError("quadric of rank 2: its two planes are not rational; give them as half_spaces")
    (value, vector), *_ = (part for part in diagonalised(form) if part[0])
    product = 1
    for factor in factors:
        along = sum((f * x for f, x in zip(factor, vector, strict=True)), ZERO)
        product *= 1 if along > 0 else -1
    same_sign = product * value > 0  # the form is a positive multiple of the product of the factors, or a negative one
    planes = [Plane(primitive(factor)) for factor in factors]
    finite = [p for p in planes if any(p.normal[:3])]
    if len(finite) == 1:
        infinite = next(p for p in planes if not any(p.normal[:3]))
        inner = (infinite.normal[3] > 0) == same_sign
        return solid([("plane", finite[0] if inner else finite[0].negated())], name=name)
    first, second = Leaf(0), Leaf(1)
    apart = Or(And(first, Not(second)), And(Not(first), second))
    labels = ((0, 1, "plane 1"), (0, -1, "plane 1"), (1, 1, "plane 2"), (1, -1, "plane 2"))
    return CompositeQuadric(finite, apart if same_sign else Not(apart), [LabelledPart("", labels)], name=name)


# -- half-spaces --------------------------------------------------------------------------------------------

RIMS = (("side", "top", "rim.top"), ("side", "bottom", "rim.bottom"))


def plane(normal: Sequence[fmpq], offset: fmpq) -> Plane:
    """normal . x <= offset."""
    return Plane(primitive((*normal, -offset)))


def up(z: fmpq) -> Plane:
    """Everything below the height z: the plane looks up."""
    return plane((ZERO, ZERO, ONE), z)


def down(z: fmpq) -> Plane:
    """Everything above the height z."""
    return plane((ZERO, ZERO, -ONE), -z)


def diagonal(*values: fmpq) -> Quadric:
    return form_of(tuple(tuple(v if i == j else ZERO for j in range(4)) for i, v in enumerate(values)))


# -- arguments ----------------------------------------------------------------------------------------------


def _positive(x: Given, what: str) -> fmpq:
    value = _not_negative(x, what)
    if value == 0:
        raise InputError(f"{what} is 0; give a positive number")
    if value < LEAST:
        raise InputError(f"{what} is {shown(x)}; give a number of 2^-150 at least")
    return value


def _not_negative(x: Given, what: str) -> fmpq:
    value = rational(x, what)
    if value < 0:
        raise InputError(f"{what} is {shown(x)}; give a positive number")
    if value >= LARGEST:
        raise InputError(f"{what} is {shown(x)}; give a number below 2^150")
    return value


def _positive3(values: Iterable[Given], what: str) -> Vector:
    if isinstance(values, str) or not np.iterable(values):
        raise InputError(f"{what} is {values!r}; give three numbers")
    numbers = tuple(values)
    if len(numbers) != 3:
        raise InputError(f"{what} is {numbers!r}; give three numbers")
    return tuple(_positive(x, f"{what}[{k}]") for k, x in enumerate(numbers))


def _radii(values: Given | Iterable[Given], what: str) -> tuple[fmpq, fmpq]:
    """(a, b) from two numbers or one."""
    if isinstance(values, str) or not np.iterable(values):
        r = _positive(values, what)
        return r, r
    numbers = tuple(values)
    if len(numbers) != 2:
        raise InputError(f"{what} is {numbers!r}; give one number or two")
    a, b = (_positive(x, f"{what}[{k}]") for k, x in enumerate(numbers))
    return a, b
