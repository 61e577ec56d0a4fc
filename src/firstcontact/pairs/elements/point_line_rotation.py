"""A point turning about an axis against an edge at rest, exactly: the degenerate events of rotations.

Axis through the origin along h.  The point p meets the point q = c + mu f when heights and radii agree.
"""

from __future__ import annotations

from typing import Any

from firstcontact.exact.fields.surd import Surd, quadratic_roots, sign_of
from firstcontact.exact.numbers import sign
from firstcontact.exact.times.instants import AngleInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, along, divisible, sub


def angle_between(axis: Axis, p: Vector, q: Vector) -> AngleInstant:
    """The instant at which p has turned to q: equal heights and radii.  On the axis: at once."""
    x, y, r = axis.perp(p, q), axis.turn(p, q), axis.perp(q, q)
    if sign_of(r) == 0:
        return AngleInstant(1, 0, 1, axis.K)
    return AngleInstant(x, y, r, axis.K)


# The shared point of the body at rest, about the axis' point: numerators (Surds or plain numbers) and denominator.
Place = tuple[Any, Any, Any, Any]
# An instant of contact and the shared point then.
Contact = tuple[AngleInstant, Place]


def rotation_contacts(axis: Axis, p: Vector, c: Vector, d: Vector) -> list[Contact]:
    """All contacts of p, turning, with the closed segment cd."""
    p, c, d = divisible(p, c, d)
    f = sub(d, c)
    fz, rise = axis.height(f), axis.height(sub(p, c))
    radius = axis.perp(p, p)
    if sign(fz) != 0:
        mu = rise / fz
        if sign(mu) < 0 or sign(1 - mu) < 0:
            return []
        q = along(c, mu, f)
        return [(angle_between(axis, p, q), (*q, 1))] if sign(axis.perp(q, q) - radius) == 0 else []
    if sign(rise) != 0:
        return []
    roots = quadratic_roots(axis.perp(f, f), axis.perp(c, f), axis.perp(c, c) - radius)
    if roots is None:  # f = 0 on the circle of p
        roots = [Surd(radius * 0)]
    points = [along(c, mu, f) for mu in roots if mu.sign() >= 0 and (1 - mu).sign() >= 0]
    return [(angle_between(axis, p, q), (*q, 1)) for q in points]
