"""A point against an edge, exactly: the degenerate events of edge/edge and vertex/facet pairs.

Schoemer and Thiel leave these to the tests with closed facets; bare edge sets need them by themselves.
"""

from __future__ import annotations

from firstcontact.exact.numbers import sign
from firstcontact.exact.times.windows import ALWAYS, Window
from firstcontact.exact.vectors import Vector, cross, dot, ratio, sub


def translation_window(p: Vector, v: Vector, c: Vector, d: Vector) -> Window | None:
    """The times t at which p + t v lies on the closed segment cd."""
    f, w = sub(d, c), sub(c, p)
    n = cross(v, f)
    nn = dot(n, n)
    if sign(nn) != 0:
        if sign(dot(w, n)) != 0:
            return None
        mu = dot(cross(w, v), n)
        if sign(mu) < 0 or sign(nn - mu) < 0:
            return None
        t = ratio(dot(cross(w, f), n), nn)
        return t, t
    vv = dot(v, v)
    if sign(vv) == 0:
        return ALWAYS if on_segment(p, c, d) else None
    if any(sign(x) != 0 for x in cross(w, v)):
        return None
    t0, t1 = ratio(dot(w, v), vv), ratio(dot(sub(d, p), v), vv)
    return (t0, t1) if sign(t1 - t0) >= 0 else (t1, t0)


def on_segment(p: Vector, c: Vector, d: Vector) -> bool:
    """Whether p lies on the closed segment cd."""
    f, w = sub(d, c), sub(p, c)
    if any(sign(x) != 0 for x in cross(w, f)):
        return False
    s, ff = dot(w, f), dot(f, f)
    if sign(ff) == 0:
        return all(sign(x) == 0 for x in w)
    return sign(s) >= 0 and sign(ff - s) >= 0
