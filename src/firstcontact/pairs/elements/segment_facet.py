"""Edge against facet at one instant: is there a shared point, and do they cross?

For the segment pq and the triangle ABC with normal n: op = n.(p - A), oq = n.(q - A); the line meets the closed
triangle iff its side products with the three sides have no two opposite signs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from firstcontact.exact.numbers import Undecidable, sign
from firstcontact.exact.vectors import Vector, along, cross, dot, sub
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.verdict import CERTAIN, DET_EPS, NONE, TINY, UNSURE, cross_size, slack3
from firstcontact.kernels.verdict import cross as cross_f
from firstcontact.pairs.elements.line_line import contact_point, segments_meet
from firstcontact.pairs.elements.point_plane import in_triangle

if TYPE_CHECKING:
    from firstcontact.exact.ring import Scalar

APART, TOUCHING, CROSSING = 0, 1, 2


@uncounted
def _det(x0, x1, x2, y0, y1, y2, z0, z1, z2, dx, dy, dz):
    """det [x, y, z] and its error bound; dx, dy, dz bound the 1-norm errors of the vectors."""
    g0, g1, g2 = cross_f(y0, y1, y2, z0, z1, z2)
    s0, s1, s2 = cross_size(y0, y1, y2, z0, z1, z2)
    err = DET_EPS * (abs(x0) * s0 + abs(x1) * s1 + abs(x2) * s2) + TINY
    if dx + dy + dz > 0.0:
        err += slack3(
            abs(x0) + abs(x1) + abs(x2), abs(y0) + abs(y1) + abs(y2), abs(z0) + abs(z1) + abs(z2), dx, dy, dz
        )
    return x0 * g0 + x1 * g1 + x2 * g2, err


@uncounted
def crossing_filter(p0, p1, p2, q0, q1, q2, a0, a1, a2, b0, b1, b2, c0, c1, c2, err_e, err_f):
    """NONE: no shared point; CERTAIN: the segment crosses the facet transversally; UNSURE otherwise."""
    e0, e1, e2 = b0 - a0, b1 - a1, b2 - a2
    f0, f1, f2 = c0 - a0, c1 - a1, c2 - a2
    de, dp = 6.0 * err_f, 3.0 * (err_e + err_f)
    op, op_err = _det(p0 - a0, p1 - a1, p2 - a2, e0, e1, e2, f0, f1, f2, dp, de, de)
    oq, oq_err = _det(q0 - a0, q1 - a1, q2 - a2, e0, e1, e2, f0, f1, f2, dp, de, de)
    if (op > op_err and oq > oq_err) or (op < -op_err and oq < -oq_err):
        return NONE
    d0, d1, d2 = q0 - p0, q1 - p1, q2 - p2
    dd = 6.0 * err_e
    x0, x1, x2 = a0 - p0, a1 - p1, a2 - p2
    y0, y1, y2 = b0 - p0, b1 - p1, b2 - p2
    z0, z1, z2 = c0 - p0, c1 - p1, c2 - p2
    ab, ab_err = _det(d0, d1, d2, x0, x1, x2, y0, y1, y2, dd, dp, dp)
    bc, bc_err = _det(d0, d1, d2, y0, y1, y2, z0, z1, z2, dd, dp, dp)
    ca, ca_err = _det(d0, d1, d2, z0, z1, z2, x0, x1, x2, dd, dp, dp)
    plus = ab > ab_err or bc > bc_err or ca > ca_err
    minus = ab < -ab_err or bc < -bc_err or ca < -ca_err
    if plus and minus:
        return NONE
    sure = abs(ab) > ab_err and abs(bc) > bc_err and abs(ca) > ca_err
    if sure and abs(op) > op_err and abs(oq) > oq_err:
        return CERTAIN
    return UNSURE


def relation(p: Vector, q: Vector, a: Vector, b: Vector, c: Vector) -> int:
    """APART, TOUCHING or CROSSING (interior of the segment through the interior of the facet); exact."""
    n = cross(sub(b, a), sub(c, a))
    sides = ((a, b), (b, c), (c, a))
    if _is_zero(n):
        return TOUCHING if any(segments_meet(p, q, *side) for side in sides) else APART
    op, oq = _told(dot(n, sub(p, a))), _told(dot(n, sub(q, a)))
    if op and op == oq:
        return APART
    if op == oq == 0:
        inside = in_triangle(p, a, b, c, n) or in_triangle(q, a, b, c, n)
        return TOUCHING if inside or any(segments_meet(p, q, *side) for side in sides) else APART
    direction = sub(q, p)
    signs = [_told(dot(direction, cross(sub(r, p), sub(s, p)))) for r, s in sides]
    if 1 in signs and -1 in signs:
        return APART
    if op is None or oq is None or None in signs:
        raise Undecidable
    return CROSSING if op * oq < 0 and 0 not in signs else TOUCHING


def _told(x: Scalar) -> int | None:
    """The sign; None where balls leave it open, for others may tell."""
    try:
        return sign(x)
    except Undecidable:
        return None


def _is_zero(n: Vector) -> bool:
    """Whether a vector is; one entry that is not tells.  Raises Undecidable."""
    signs = [_told(x) for x in n]
    if any(signs):
        return False
    if None in signs:
        raise Undecidable
    return True


def start_point(x: Sequence[Vector], y: Sequence[Vector]) -> Vector:
    """A shared point of two elements given by their corners (one, two or three each), one known to exist."""
    if len(x) > len(y):
        x, y = y, x
    if len(x) == 1:
        return x[0]
    p, q = x
    if len(y) == 2:
        return contact_point(p, q, y[0], y[1], (0, 0, 0), 0)
    n = cross(sub(y[1], y[0]), sub(y[2], y[0]))
    op, oq = dot(n, sub(p, y[0])), dot(n, sub(q, y[0]))
    if sign(op - oq) != 0:
        return along(p, op / (op - oq), sub(q, p))
    for end in (p, q):
        if not _is_zero(n) and in_triangle(end, y[0], y[1], y[2], n):
            return end
    sides = ((y[0], y[1]), (y[1], y[2]), (y[2], y[0]))
    side = next(side for side in sides if segments_meet(p, q, *side))
    return contact_point(p, q, side[0], side[1], (0, 0, 0), 0)
