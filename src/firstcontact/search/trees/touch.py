"""Where two elements touch at the exact instant, and the unit normal there, in the working frame.

Points are rounded from exact numbers.  Normals are computed in doubles; where the doubles leave their direction or
sign in doubt, balls decide, and what they cannot tell from zero is undefined (grazing, parallel edges).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq, fmpz

from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.numbers import PRECISIONS, Undecidable, ball, nearest_double, precision, sign, to_double
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, add, along, cross, dot, scaled, sub
from firstcontact.pairs.elements import line_line
from firstcontact.pairs.elements.point_line_rotation import Place
from firstcontact.search.trees.elements import VERTEX, Feature, Scale

if TYPE_CHECKING:
    from firstcontact.exact.ring import Scalar
    from firstcontact.exact.times.instants import TurnInstant

Touch = tuple[np.ndarray, np.ndarray | None]
Floats = tuple[float, float, float]

# Relative size below which a double may be rounding only: normals and speeds then go to the balls.
DOUBTFUL = 1e-3


def translation_touch(
    element_a: Feature,
    a: list[Vector],
    element_b: Feature,
    b: list[Vector],
    v: Vector,
    scale: Scale,
    at: RationalInstant,
) -> Touch:
    """(point, unit normal from b towards a or None); `scale` times the exact corners at time 0 and the velocity."""
    place: Place
    if element_a[0] == VERTEX:
        t = at.value
        over, steps = (t.q, t.p) if type(t) is fmpq else (1, t)
        place = *along(scaled(over, a[0]), steps, v), over
    elif element_b[0] == VERTEX:
        place = *b[0], fmpz(1)
    else:
        place = line_line.contact_place(*a, *b, v, at.value)  # type: ignore[call-arg]
    x, y = spanning(a) + spanning(b)
    return np.array(place_doubles((*place[:3], place[3] * scale))), unit_against(cross(x, y), v)


def carried_normal(pose: np.ndarray, n: np.ndarray) -> np.ndarray:
    """The unit normal n of a plane in the frame that the (4, 4) pose brings to the world, there.

    By the inverse transpose: so affine poses keep it across what lies in the plane, and on its side when they mirror.
    """
    turned = n @ np.linalg.inv(pose[:3, :3])
    turned = turned / np.abs(turned).max()
    return turned / np.linalg.norm(turned)


def spanning(corners: list[Vector]) -> list[Vector]:
    """The directions that an element spans: none, one or two; of a pair of elements that meet two together."""
    return [sub(p, corners[0]) for p in corners[1:]]


def unit_against(n: Vector, velocity: Vector) -> np.ndarray | None:
    """The unit vector along n against the velocity; None where they are orthogonal or n is zero."""
    try:
        towards = sign(dot(n, velocity))
    except Undecidable:
        return None
    return None if towards == 0 else np.array(_unit(directions(n), -towards))


def _unit(n: Floats, factor: float) -> Floats:
    largest = max(abs(n[0]), abs(n[1]), abs(n[2]))
    x, y, z = n[0] / largest, n[1] / largest, n[2] / largest
    k = factor / math.sqrt(x * x + y * y + z * z)
    return k * x, k * y, k * z


def directions(v: Vector) -> Floats:
    """Doubles along an exact vector; of whole numbers, which may be beyond them, none above 1."""
    if type(v[0]) is not fmpz:
        return tuple(doubles(v).tolist())
    x, y, z = map(int, v)
    over = 1 << max(x.bit_length(), y.bit_length(), z.bit_length())
    return x / over, y / over, z / over


def doubles(v: Vector) -> np.ndarray:
    """The doubles nearest exact coordinates; the middles of balls."""
    return np.array([_double(x) for x in v])


def _double(x: arb | fmpq) -> float:
    return to_double(x) if type(x) is fmpq else place_doubles((x, x, x, 1))[0]


def place_doubles(place: Place) -> list[float]:
    """The doubles nearest the coordinates of a place; the middles of balls."""
    if all([type(x) is fmpz for x in place]):
        x, y, z, w = map(int, place)
        if w < 0:
            x, y, z, w = -x, -y, -z, -w  # no zero with a sign
        return [x / w, y / w, z / w]  # Python's integer division rounds correctly
    for bits in PRECISIONS:
        with precision(bits):
            values = place_ball(place)
            near = [nearest_double(x) for x in values]
        if None not in near:
            break
    # some are half way between two doubles, or known as balls only
    return [float(x.mid()) if t is None else t for x, t in zip(values, near, strict=True)]


def place_ball(place: Place) -> Vector:
    """An enclosure of a place at the present precision."""
    x, y, z, w = map(as_ball, place)
    return x / w, y / w, z / w


def rotation_normal(
    corners_a: list[Vector], corners_b: list[Vector], axis: Axis, place: Place, where: Sequence[float], at: TurnInstant
) -> np.ndarray | None:
    """The unit normal from b towards a; exact corners at angle 0, all about a point of the axis, in any unit.

    where: the doubles nearest the place.
    """
    h = directions(axis.h)
    moving, resting = spanning(corners_a), spanning(corners_b)
    with precision(PRECISIONS[0]):
        angle = float(at.local().mid())  # its bounds may be those of the floats, which are wide far from the axis
    turned = _turned_doubles(h, [directions(x) for x in moving], angle)
    x, y = turned + [directions(x) for x in resting]
    n, velocity = cross(x, y), cross(h, where)
    n_size, v_size, speed = _norm(n), _norm(velocity), dot(n, velocity)
    clear = n_size > DOUBTFUL * _norm(x) * _norm(y) and v_size > DOUBTFUL * _norm(h) * _norm(where)
    if clear and abs(speed) > DOUBTFUL * n_size * v_size:
        return np.array(_unit(n, -1.0 if speed > 0 else 1.0))
    for bits in PRECISIONS:
        with precision(bits):
            x, y = _turned(axis, moving, at) + [as_balls(x) for x in resting]
            normal = unit_against(cross(x, y), cross(axis.h, place_ball(place)))
        if normal is not None:
            return normal
    return None


def _turned_doubles(h: Floats, vectors: list[Floats], angle: float) -> list[Floats]:
    """The vectors turned about h."""
    k = dot(h, h)
    cosine, sine = math.cos(angle), math.sin(angle) / math.sqrt(k)
    out = []
    for v in vectors:
        s = (1.0 - cosine) * dot(h, v) / k
        out.append(along(along(scaled(cosine, v), sine, cross(h, v)), s, h))
    return out


def _norm(v: Sequence[float]) -> float:
    return math.hypot(v[0], v[1], v[2])


def as_ball(x: Scalar | Surd | int) -> arb:
    """An enclosure of a Surd, fmpq or ball at the present precision."""
    return x.ball() if isinstance(x, Surd) else ball(x)


def as_balls(p: Vector) -> Vector:
    return as_ball(p[0]), as_ball(p[1]), as_ball(p[2])


def _turned(axis: Axis, vectors: list[Vector], at: Any) -> list[Vector]:
    """Vectors turned to the instant, as balls."""
    c, s = (x.ball() for x in at.cosine_sine())
    h, k = as_balls(axis.h), ball(axis.K)
    out = []
    for v in vectors:
        x = as_balls(v)
        share: arb = dot(h, x) / k
        foot = (share * h[0], share * h[1], share * h[2])
        out.append(add(along(foot, c, sub(x, foot)), tuple(s * w for w in cross(h, x))))
    return out
