"""Flat pieces whose rulings lie along those of a trimmed one, ruled the other way.

Where rulings of a trimmed piece lie on one line with others, signs at a place (u, v) do not tell how far both of them
reach.  A parallelogram has other rulings, across; no line of one piece is one of the other then.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.exact.vectors import cross
from firstcontact.motion.moving import Moving, shape_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import RuledBody

ACROSS = {"directrix": "end_ruling", "end_ruling": "directrix"}


def across(x: RuledBody, y: RuledBody) -> tuple[RuledBody, RuledBody, tuple[bool, bool]]:
    """Both pieces, one of them ruled the other way where that tells more; and which one is."""
    bodies, shapes = [x, y], [shape_of(x), shape_of(y)]
    turned = [False, False]
    if any(j for shape in shapes for trim in shape.trim for _, j in trim.polynomial.to_dict()):
        ways = [_way(shape) for shape in shapes]
        if ways[0] is not None and ways[1] is not None and not any(cross(ways[0], ways[1])):
            for k in sorted((0, 1), key=lambda k: len(shapes[k].trim)):
                other = shapes[k].crossed()
                if other is not None:
                    body = bodies[k]
                    bodies[k] = Moving(other, body.motion) if isinstance(body, Moving) else other
                    turned[k] = True
                    break
    return bodies[0], bodies[1], (turned[0], turned[1])


def _way(piece: RuledSurface) -> tuple[fmpq, ...] | None:
    """The way of a piece's rulings; None where they are not all parallel, or may not be at all times."""
    if piece.deforming:
        return None
    p, q = piece.first.components, piece.second.components
    ways = [q[k] * p[3] - p[k] * q[3] for k in range(3)]
    some = next(k for k, w in enumerate(ways) if w != 0)
    place = next(u for u in range(ways[some].degree() + 1) if ways[some](u) != 0)
    way = tuple(fmpq(w(place)) for w in ways)
    return way if not any(cross(ways, [w.p for w in way])) else None


def named_as_before(kind: str, index: int) -> tuple[str, int]:
    """An element of a piece that is ruled the other way, as one of the piece itself."""
    return (kind, index // 2 + 2 * (index % 2)) if kind == "vertex" else (ACROSS.get(kind, kind), index)
