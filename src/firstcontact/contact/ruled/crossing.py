"""Flat pieces whose rulings lie along those of a trimmed one, ruled the other way.

Where rulings of a trimmed piece lie on one line with others, signs at a place (u, v) do not tell how far both of them
reach.  A parallelogram has other rulings, across, and a triangle those from another corner; no line of one piece is one
of the other then.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.exact.vectors import Vector, cross, dot, sub
from firstcontact.motion.moving import Moving, shape_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import RuledBody

Named = tuple[str, int]
Renamed = Callable[[Named], Named]
"""From an element of a piece that is ruled the other way to one of the piece itself."""
ACROSS = {"directrix": "end_ruling", "end_ruling": "directrix"}
CORNERS = (("vertex", 0), ("vertex", 1), ("vertex", 3))
SIDES = (("end_ruling", 0), ("directrix", 1), ("end_ruling", 1))
"""Of a triangle, ruled from its first corner: each side from that corner to the next."""


def across(x: RuledBody, y: RuledBody) -> tuple[RuledBody, RuledBody, tuple[Renamed, Renamed]]:
    """Both pieces, one of them ruled the other way where that tells more; and what their elements are called."""
    bodies, shapes = [x, y], [shape_of(x), shape_of(y)]
    names: list[Renamed] = [_as_it_is, _as_it_is]
    if any(j for shape in shapes for trim in shape.trim for _, j in trim.polynomial.to_dict()):
        ways = [_way(shape) for shape in shapes]
        for k in sorted((0, 1), key=lambda k: len(shapes[k].trim)):
            found = _ruled_otherwise(shapes[k], ways[k], ways[1 - k])
            if found is not None:
                body = bodies[k]
                bodies[k] = Moving(found[0], body.motion) if isinstance(body, Moving) else found[0]
                names[k] = found[1]
                break
    return bodies[0], bodies[1], (names[0], names[1])


def _ruled_otherwise(
    piece: RuledSurface, own: Vector | None, other: Vector | None
) -> tuple[RuledSurface, Renamed] | None:
    """The piece, a parallelogram or a triangle, with no ruling along the other's way; None where it has none now, or
    where it is neither."""
    if other is None:
        return None
    if own is not None:
        crossed = None if any(cross(own, other)) else piece.crossed()
        return None if crossed is None else (crossed, _of_crossed)
    corners = piece.corners()
    k = None if corners is None else _outermost(corners, other)
    return None if not k else (piece.ruled_from(k), partial(_of_turned, k))


def _way(piece: RuledSurface) -> Vector | None:
    """The way of a piece's rulings; None where they are not all parallel, or may not be at all times."""
    if piece.deforming:
        return None
    p, q = piece.first.components, piece.second.components
    ways = [q[k] * p[3] - p[k] * q[3] for k in range(3)]
    some = next(k for k, w in enumerate(ways) if w != 0)
    place = next(u for u in range(ways[some].degree() + 1) if ways[some](u) != 0)
    x, y, z = (fmpq(w(place)) for w in ways)
    return (x, y, z) if not any(cross(ways, [x.p, y.p, z.p])) else None


def _outermost(corners: list[Vector], way: Vector) -> int | None:
    """The first corner from which no line along the way runs into the triangle or on its border; None: its plane is
    across the way, or has the other one's rulings nowhere."""
    normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))
    if dot(normal, way) != 0:
        return None
    aside = [dot(cross(normal, way), corner) for corner in corners]
    return next(k for k, x in enumerate(aside) if aside.count(x) == 1 and x in (min(aside), max(aside)))


# -- names ----------------------------------------------------------------------------------------------------


def _as_it_is(known: Named) -> Named:
    return known


def _of_crossed(known: Named) -> Named:
    kind, index = known
    return (kind, index // 2 + 2 * (index % 2)) if kind == "vertex" else (ACROSS.get(kind, kind), index)


def _of_turned(k: int, known: Named) -> Named:
    """k: the corner from which the triangle is ruled."""
    kind, index = known
    if kind == "vertex" or known == ("directrix", 0):  # the first directrix is the corner
        corner = 0 if kind == "directrix" else (0, 1, 0, 2)[index]
        return CORNERS[(corner + k) % 3]
    return SIDES[(SIDES.index(known) + k) % 3] if known in SIDES else known
