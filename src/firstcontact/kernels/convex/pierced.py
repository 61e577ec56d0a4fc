"""Proof that a vertex of a convex piece has passed through a triangle."""

from __future__ import annotations

import math

from firstcontact.kernels.convex.flat import CORNERS, PLANE, SIDES, middle_of
from firstcontact.kernels.convex.shared_point import FORM_EPS, across, is_inside
from firstcontact.kernels.convex.support import form_value
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import SIDE_B


@uncounted
def pierces(a, b, j, vertex, w):
    """True proves that triangle 0 of a meets the way from a vertex of piece j of b to its middle, in the frames.

    Near the tip of a cone nothing else works: its form falls with the square of the depth there.
    """
    c0, c1, c2 = middle_of(b, j)
    if not is_inside(b, j, c0, c1, c2, 0.0):
        return False
    p0, p1, p2, off_p = across(w, SIDE_B, b[vertex, 0], b[vertex, 1], b[vertex, 2], b[vertex, 3])
    q0, q1, q2, off_q = across(w, SIDE_B, c0, c1, c2, 0.0)
    if off_p < 0.0 or off_q < 0.0:
        return False
    # the triangle is within `slack` of the plane of its form, and its sides of those of theirs
    slack = 2.0 * max(off_p, off_q) + 3.0 * max(a[CORNERS, 3], a[CORNERS + 1, 3], a[CORNERS + 2, 3])
    worst = 0.0
    for k in range(4):
        for r in range(3):
            value, size = form_value(a, PLANE + k, a[CORNERS + r, 0], a[CORNERS + r, 1], a[CORNERS + r, 2])
            slack = max(slack, FORM_EPS * size)
            if k == 0 or r != (k + 1) % 3:  # not the corner opposite the side
                worst = max(worst, abs(value))
        slack = max(slack, FORM_EPS * form_value(a, PLANE + k, p0, p1, p2)[1])
        slack = max(slack, FORM_EPS * form_value(a, PLANE + k, q0, q1, q2)[1])
    slack = 2.0 * slack + worst
    here, there = form_value(a, PLANE, p0, p1, p2)[0], form_value(a, PLANE, q0, q1, q2)[0]
    if here * there >= 0.0 or min(abs(here), abs(there)) <= slack:
        return False
    s, spread = here / (here - there), 2.0 * slack / abs(here - there)
    for k in range(3):
        first, last = form_value(a, SIDES + k, p0, p1, p2)[0], form_value(a, SIDES + k, q0, q1, q2)[0]
        if not first + s * (last - first) + spread * abs(last - first) < -2.0 * slack:
            return False
    return math.isfinite(slack)
