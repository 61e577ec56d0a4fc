"""Where two elements touch at the exact instant, and the unit normal there, in the working frame.

Points are rounded from exact numbers.  Normals are computed in doubles; where the doubles leave their direction or
sign in doubt, balls decide, and what they cannot tell from zero is undefined (grazing, parallel edges).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from flint import arb, fmpq

from firstcontact.exact.instants import RationalInstant
from firstcontact.exact.numbers import PRECISIONS, Undecidable, ball, nearest_double, precision, sign, to_double
from firstcontact.exact.surd import Surd
from firstcontact.exact.turning import Axis
from firstcontact.exact.vectors import Vector, add, along, cross, dot, sub
from firstcontact.pairs import line_line
from firstcontact.pairs.point_line_rotation import Place
from firstcontact.search.elements import VERTEX, Feature

Touch = tuple[np.ndarray, np.ndarray | None]
Floats = tuple[float, float, float]

# Relative size below which a double may be rounding only: normals and speeds then go to the balls.
DOUBTFUL = 1e-3


def translation_touch(
    element_a: Feature, corners_a: Any, element_b: Feature, corners_b: Any,
    v: Vector, at: RationalInstant,
) -> Touch:  # fmt: skip
    """(point, unit normal from b towards a or None); exact corners at time 0."""
    if element_a[0] == VERTEX:
        point, n = along(corners_a[0], at.value, v), _facet_normal(corners_b)
    elif element_b[0] == VERTEX:
        point, n = corners_b[0], _facet_normal(corners_a)
    else:
        point = line_line.contact_point(*corners_a, *corners_b, v, at.value)  # type: ignore[call-arg]
        n = line_line.normal(*corners_a, *corners_b)
    return doubles(point), unit_against(n, v)


def _facet_normal(corners: list[Vector]) -> Vector:
    a, b, c = corners
    return cross(sub(b, a), sub(c, a))


def unit_against(n: Vector, velocity: Vector) -> np.ndarray | None:
    """The unit vector along n against the velocity; None where they are orthogonal or n is zero."""
    try:
        towards = sign(dot(n, velocity))
    except Undecidable:
        return None
    return None if towards == 0 else _unit(doubles(n).tolist(), -towards)


def _unit(n: Any, factor: float) -> np.ndarray:
    largest = max(abs(n[0]), abs(n[1]), abs(n[2]))
    x, y, z = n[0] / largest, n[1] / largest, n[2] / largest
    k = factor / math.sqrt(x * x + y * y + z * z)
    return np.array((k * x, k * y, k * z))


def doubles(v: Vector) -> np.ndarray:
    """The doubles nearest exact coordinates; the middles of balls."""
    return np.array(_floats(v))


def _floats(v: Vector) -> Any:
    return [to_double(x) if type(x) is fmpq else _double(x) for x in v]


def _double(x: Any, w: Any = 1) -> float:
    """The double nearest x / w."""
    for bits in PRECISIONS:
        with precision(bits):
            value = as_ball(x) / as_ball(w)
            near = nearest_double(value)
        if near is not None:
            return near
    return float(value.mid())  # half way between two doubles, or known as a ball only


def place_doubles(place: Place) -> list[float]:
    """The doubles nearest the coordinates of a place."""
    x, y, z, w = place
    return [_double(x, w), _double(y, w), _double(z, w)]


def place_ball(place: Place) -> Vector:
    """An enclosure of a place at the present precision."""
    x, y, z, w = map(as_ball, place)
    return x / w, y / w, z / w


def rotation_normal(
    element_a: Feature, corners_a: list[Vector], element_b: Feature, corners_b: list[Vector],
    axis: Axis, place: Place, where: Any, at: Any,
) -> np.ndarray | None:  # fmt: skip
    """The unit normal from b towards a; exact corners at angle 0, all about a point of the axis.

    where: the doubles nearest the place.
    """
    h: Any = [to_double(x) for x in axis.h]
    angle = at.bounds()[0]
    cosine, sine = math.cos(angle), math.sin(angle) / math.sqrt(dot(h, h))
    velocity = cross(h, where)
    moving, resting = [_floats(p) for p in corners_a], [_floats(p) for p in corners_b]
    n, size = _float_normal(element_a, moving, element_b, resting, h, cosine, sine)
    speed = dot(n, velocity)
    n_size, v_size = _norm(n), _norm(velocity)
    scale = max(map(_norm, (*moving, *resting)))
    clear = n_size > DOUBTFUL * size and v_size > DOUBTFUL * _norm(h) * scale
    if clear and abs(speed) > DOUBTFUL * n_size * v_size:
        return _unit(n, -1.0 if speed > 0 else 1.0)
    for bits in PRECISIONS:
        with precision(bits):
            moved = _turned(axis, corners_a, at)
            direction = _normal(element_a, moved, element_b, [as_balls(p) for p in corners_b])
            normal = unit_against(direction, cross(axis.h, place_ball(place)))
        if normal is not None:
            return normal
    return None


def _normal(element_a: Feature, a: list[Any], element_b: Feature, b: list[Any]) -> Vector:
    if element_a[0] == VERTEX:
        return _facet_normal(b)
    if element_b[0] == VERTEX:
        return _facet_normal(a)
    return cross(sub(a[1], a[0]), sub(b[1], b[0]))


def _float_normal(
    element_a: Feature, corners_a: list[Any], element_b: Feature, rest: list[Any],
    h: Any, cosine: float, sine: float,
) -> tuple[Floats, float]:  # fmt: skip
    """The normal in doubles and the product of the lengths it is made of."""
    k = h[0] * h[0] + h[1] * h[1] + h[2] * h[2]
    moved = []
    for x in corners_a:
        s = dot(h, x) / k
        moved.append(
            tuple(s * f + cosine * (c - s * f) + sine * w for f, c, w in zip(h, x, cross(h, x), strict=True))
        )
    n = _normal(element_a, moved, element_b, rest)
    x, y = (rest, rest) if element_a[0] == VERTEX else (moved, moved) if element_b[0] == VERTEX else (moved, rest)
    other = 2 if x is y else 1
    return n, _norm(sub(x[1], x[0])) * _norm(sub(y[other], y[0]))


def _norm(v: Any) -> float:
    return math.hypot(v[0], v[1], v[2])


def as_ball(x: Any) -> arb:
    """An enclosure of a Surd, fmpq or ball at the present precision."""
    return x.ball() if isinstance(x, Surd) else ball(x)


def as_balls(p: Vector) -> Vector:
    return as_ball(p[0]), as_ball(p[1]), as_ball(p[2])


def _turned(axis: Axis, corners: list[Vector], at: Any) -> list[Vector]:
    """Corners turned to the instant, as balls."""
    c, s = (x.ball() for x in at.cosine_sine())
    h, k = as_balls(axis.h), ball(axis.K)
    out = []
    for p in corners:
        x = as_balls(p)
        share: arb = dot(h, x) / k
        foot = (share * h[0], share * h[1], share * h[2])
        out.append(add(along(foot, c, sub(x, foot)), tuple(s * w for w in cross(h, x))))
    return out
