"""Intersection curves: of two ruled surfaces, of one with a solid or a polyhedron.

Surfaces are built to share chosen points, rulings and curves, or such that the topology of what they share is known.
Beside that, rulings are put into the other surface by root finding of the soak's own: what they meet must be on
the curve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction as F
from random import Random

import numpy as np

from . import ruled_shapes as shapes
from .curve_judges import Facts, agreeing, of_pieces, of_solid
from .exact_numbers import (
    Vector,
    add,
    cross,
    dot,
    inverse,
    polynomial_sum,
    power,
    scaled,
    sub,
    times,
    turn,
    value,
    vector,
)
from .ruled import random_curve, random_piece, random_place, surface_points
from .ruled_bodies import Body, Curve, Frame, Piece, random_frame, straight
from .scene import Kind, Question, Scene


def plain(p: Piece) -> Piece:
    return p if p.placed is None else replace(
        p, first=p.first.mapped(p.placed), second=p.second.mapped(p.placed), placed=None)


def stretch(frame: Frame) -> float:
    return float(np.linalg.norm([[float(c) for c in row] for row in frame.linear], 2))


def scene_of_pieces(rng: Random, p: Piece, q: Piece, facts: Facts) -> Scene:
    frame = random_frame(rng, False)
    p, q = p.mapped(frame), q.mapped(frame)
    if rng.random() < 0.5:
        p, q = q, p
    facts = facts.mapped(frame.point)
    tolerance = float(rng.choice((1e-2, 1e-3, 1e-3, 1e-4))) * stretch(frame)
    seed = rng.randrange(2**30)
    source = f"a = {p.text()}\nb = {q.text()}\nspan = None\n"
    checked = of_pieces(p, q, facts, tolerance, seed)
    option = f"tolerance={tolerance!r}"
    methods = rng.choice((("",), ("",), (', method="certified"',), (', method="algebraic"',)))
    questions = [Question(f"fc.intersection_curve(a, b, {option}{m})", checked) for m in methods]
    size = max(p.size, q.size)
    if rng.random() < 0.6:
        how = rng.randrange(3)
        if how == 0:
            questions.append(Question(
                f'[fc.intersection_curve(a, b, {option}, method=m) for m in ("algebraic", "certified")]',
                agreeing(size, ("algebraic", "certified"))))
        elif how == 1:
            questions.append(Question(f"[fc.intersection_curve(*x, {option}) for x in ((a, b), (b, a))]",
                                      agreeing(size, ("in order", "swapped"))))
        else:
            questions.append(Question(
                f"[fc.intersection_curve(a, b, tolerance=x*{tolerance!r}) for x in (1, 0.1, 0.001)]",
                agreeing(size, ("at one tolerance", "at a tenth of it", "at a thousandth"))))
    return Scene(source, "rest", tuple(questions))


# ---------------------------------------------------------------------------------------------------------- flat pieces


def line_part(corners: Sequence[Vector], normal: Vector, offset: F) -> list[Vector]:
    """The points, two at most but for repeated ones, between which a convex polygon meets a plane."""
    out = []
    for i, x in enumerate(corners):
        y = corners[i - 1]
        a, b = dot(normal, x) - offset, dot(normal, y) - offset
        if a == 0:
            out.append(x)
        elif a * b < 0:
            out.append(add(scaled(x, -b / (a - b)), scaled(y, a / (a - b))))
    return out


def shared_part(first: Sequence[Vector], second: Sequence[Vector]) -> tuple[str, list[Vector]]:
    """What two convex flat polygons share: "nothing", "point", "segment" or "area"; and its ends."""
    n = cross(sub(first[1], first[0]), sub(first[2], first[0]))
    m = cross(sub(second[1], second[0]), sub(second[2], second[0]))
    direction = cross(n, m)
    if any(direction):
        parts = line_part(first, m, dot(m, second[0])), line_part(second, n, dot(n, first[0]))
        if not all(parts):
            return "nothing", []
        along = [sorted(part, key=lambda x: dot(x, direction)) for part in parts]
        lo = max((part[0] for part in along), key=lambda x: dot(x, direction))
        hi = min((part[-1] for part in along), key=lambda x: dot(x, direction))
        k = dot(sub(hi, lo), direction)
        return ("nothing", []) if k < 0 else ("point", [lo]) if k == 0 else ("segment", [lo, hi])
    if dot(m, sub(first[0], second[0])):
        return "nothing", []
    part = list(first)
    for i, x in enumerate(second):
        side = cross(m, sub(x, second[i - 1]))
        kept = []
        for j, y in enumerate(part):
            z = part[j - 1]
            a, b = dot(side, sub(y, x)), dot(side, sub(z, x))
            if a * b < 0:
                kept.append(add(scaled(y, -b / (a - b)), scaled(z, a / (a - b))))
            if a >= 0:
                kept.append(y)
        part = kept
    distinct = list(dict.fromkeys(part))
    if not distinct:
        return "nothing", []
    if len(distinct) == 1:
        return "point", distinct
    if any(any(cross(sub(x, distinct[0]), sub(y, distinct[0]))) for x in distinct for y in distinct):
        return "area", distinct
    return "segment", [min(distinct), max(distinct)]


def flat(rng: Random) -> Scene:
    """Two flat pieces on a small lattice; or one and an open mesh of one facet."""
    while True:
        corners = [shapes.flat_corners(rng), shapes.flat_corners(rng)]
        if rng.random() < 0.3:
            corners = [tuple((x, y, F(0)) for x, y, _ in c) for c in corners]  # type: ignore[misc]
        if rng.random() < 0.6:  # a place of one on a place of the other
            a, b = (add(scaled(shapes.blended(c[0], c[1], u), 1 - s), scaled(shapes.blended(c[2], c[3], u), s))
                    for c in corners for u, s in [random_place(rng)])
            corners[1] = tuple(add(c, sub(a, b)) for c in corners[1])  # type: ignore[assignment]
        rings = []
        for p00, p10, p01, p11 in corners:
            ring = [p00, p10, p11, p01]
            rings.append([x for i, x in enumerate(ring) if x != ring[i - 1]])
        if all(len(r) > 2 and any(cross(sub(r[1], r[0]), sub(r[2], r[0]))) for r in rings):
            break
    kind, ends = shared_part(rings[0], rings[1])
    facts = Facts(holds=tuple(ends), empty=kind == "nothing", area=kind == "area",
                  isolated=tuple(ends) if kind == "point" else () if kind in ("segment", "nothing") else None)
    if kind == "segment":
        facts = replace(facts, holds=(*ends, shapes.blended(ends[0], ends[1], F(1, 3))), loops=0)
    p, q = (shapes.four_corners(rng, *c) for c in corners)
    return scene_of_pieces(rng, p, q, facts)


# ------------------------------------------------------------------------------------------------ curves of known shape


def level_sets(rng: Random) -> Scene:
    """Graphs whose difference is f(x) + g(y): loops however small, isolated points, nodes, cusps, borders touched."""
    k, m = (rng.choice((F(1), F(1), F(2), F(1, 3), F(1, 4))) for _ in range(2))
    x0, y0 = rng.choice((F(0), F(1, 3), F(1, 2))), rng.choice((F(0), F(-1, 3)))
    x, y = (F(-2), F(2)), (F(-2), F(2))
    at = (x0, y0)
    what = rng.choice(("loop", "loop", "point", "empty", "node", "arcs", "cusp", "tacnode", "border", "corner",
                       "through corner", "folium", "fourth", "double line"))
    X, Y = [-x0, F(1)], [-y0, F(1)]
    f, g = [k * c for c in power(X, 2)], [m * c for c in power(Y, 2)]
    facts = Facts(area=False)
    small = F(1, 10 ** rng.randint(1, 14))
    if what == "loop":
        r = rng.choice((small, F(1), F(1, 2), F(1, 9)))
        f = polynomial_sum(f, [-r * r * min(k, m)])
        facts = Facts(area=False, loops=1, arcs=0, isolated=(), nodes=(), cusps=())
    elif what in ("point", "fourth"):
        if what == "fourth":
            f = [k * c for c in power(X, 4)]
        facts = Facts(area=False, loops=0, arcs=0, isolated=(at + (F(0),),))
    elif what == "empty":
        f = polynomial_sum(f, [small])
        facts = Facts(area=False, empty=True)
    elif what == "node":
        g = [-k * c for c in power(Y, 2)]
        x, y = (x0 - 1, x0 + 1), (y0 - 1, y0 + rng.choice((1, 2)))
        facts = Facts(area=False, loops=0, arcs=4, isolated=(), nodes=(at + (F(0),),))
    elif what == "arcs":
        g = [-k * c for c in power(Y, 2)]
        f = polynomial_sum(f, [small])
        x, y = (x0 - 1, x0 + 1), (y0 - 1, y0 + 1)
        facts = Facts(area=False, loops=0, arcs=2, isolated=(), nodes=())
    elif what == "cusp":
        g = [-m * c for c in power(Y, 3)]
        facts = Facts(area=False, loops=0, isolated=(), nodes=(), cusps=(at + (F(0),),), holds=(at + (F(0),),))
    elif what == "tacnode":
        g = [-m * c for c in power(Y, 4)]
        facts = Facts(area=False, loops=0, isolated=(), nodes=(at + (F(0),),))
    elif what == "border":
        f = [k * c for c in X]
        x = (x0, x0 + 2)
        facts = Facts(area=False, loops=0, arcs=0, isolated=(at + (F(0),),))
    elif what == "corner":
        f, g = [k * c for c in X], [m * c for c in Y]
        x, y = (x0, x0 + 2), (y0, y0 + 3)
        facts = Facts(area=False, loops=0, arcs=0, isolated=(at + (F(0),),))
    elif what == "through corner":
        f, g = [k * c for c in X], [-m * c for c in power(Y, rng.choice((1, 2)))]
        x, y = (x0, x0 + 2), (y0, y0 + 1)
        facts = Facts(area=False, loops=0, arcs=1, isolated=(), holds=(at + (F(0),),))
    elif what == "folium":  # y^2 = x^2 (x + 1)
        f = [-c for c in times(power(X, 2), polynomial_sum(X, [F(1)]))]
        g = power(Y, 2)
        x, y = (x0 - 2, x0 + 1), (y0 - 2, y0 + 2)
        facts = Facts(area=False, isolated=(), nodes=(at + (F(0),),))
    elif what == "double line":
        g = [F(0)]
        facts = Facts(area=False, isolated=(), holds=((x0, y[0], F(0)), (x0, F(0), F(0)), (x0, y[1], F(0))))
    base = [F(rng.randint(-2, 2)) for _ in range(4)] if rng.random() < 0.5 else [F(0)] * 4

    def raised(point: Vector) -> Vector:
        px, py, _ = point
        return px, py, base[0] + base[1] * px + base[2] * py + base[3] * px * py + value(f, px)

    wide = (y[0] - rng.choice((0, 0, 1)), y[1] + rng.choice((0, 1)))
    p = shapes.graph(rng, "y", x, wide if what not in ("corner", "through corner") else y, base, (f, [F(1)]))
    q = shapes.graph(rng, "x", x, y, base, ([-c for c in g], [F(1)]))
    return scene_of_pieces(rng, p, q, facts.mapped(raised))


# ---------------------------------------------------------------------------------------------- shared points and lines


def shared_features(rng: Random) -> Scene:
    """Any two pieces that share a chosen point, a ruling, or a directrix."""
    what = rng.choice(("point", "point", "point", "ruling", "directrix", "tangent", "end rulings"))
    p = replace(random_piece(rng, easy=True), as_lists=False)
    if what == "point":
        q = replace(random_piece(rng, easy=True), as_lists=False)
        x, y = p.exact_point(*random_place(rng)), q.exact_point(*random_place(rng))
        q = q.mapped(Frame(offset=sub(x, y)))
        return scene_of_pieces(rng, p, q, Facts(holds=(x,)))
    u0 = rng.choice((F(0), F(1), F(1, 2), F(1, 3)))
    a, b = p.first.at(u0), p.second.at(u0)
    if what == "directrix":
        q = Piece(p.first, random_curve(rng))
        if rng.random() < 0.5:
            q = Piece(q.second, q.first)
        points = [p.first.at(u) for u in (F(0), F(1, 2), F(1))]
        spread = [sub(c.at(F(k, 3)), points[0]) for c in (q.first, q.second) for k in range(4)]
        if not any(any(cross(c, d)) for c in spread for d in spread):
            return shared_features(rng)
        return scene_of_pieces(rng, p, q, Facts(holds=tuple(points)))
    if a == b:
        return shared_features(rng)
    ends = (a, b)
    if rng.random() < 0.5:  # more or less of the same line
        ends = shapes.blended(a, b, rng.choice((F(-1), F(1, 2), F(0)))), shapes.blended(a, b, rng.choice((F(2), F(1))))
    v0 = F(0) if what == "end rulings" else rng.choice((F(0), F(1, 2), F(1)))

    def through(x: Vector, lean: Vector | None) -> Curve:
        """x at v0, on a parabola or line of any direction."""
        d = lean or vector([rng.randint(-3, 3) for _ in range(3)])
        e = vector([rng.randint(-2, 2) for _ in range(3)]) if rng.random() < 0.5 else vector([0, 0, 0])
        rows = [polynomial_sum([x[i]], polynomial_sum([d[i] * c for c in (-v0, F(1))],
                                                      [e[i] * c for c in power([-v0, F(1)], 2)])) for i in range(3)]
        return Curve((rows[0], rows[1], rows[2]))

    lean = None
    if what == "tangent":  # along the first surface at the first end
        step = F(1, 1000)
        lean = scaled(sub(p.first.at(u0 + step), p.first.at(u0 - step)), F(1, 2) / step)
        lean = vector([c.limit_denominator(10) for c in lean])
    q = Piece(through(ends[0], lean), through(ends[1], None))
    points = [c.at(F(k, 3)) for c in (q.first, q.second) for k in range(4)]
    spread = [sub(x, points[0]) for x in points]
    if ends[0] == ends[1] or not any(any(cross(c, d)) for c in spread for d in spread):
        return shared_features(rng)
    d = sub(b, a)
    k0, k1 = sorted(dot(sub(x, a), d) / dot(d, d) for x in ends)
    k0, k1 = max(k0, F(0)), min(k1, F(1))
    holds = tuple(shapes.blended(a, b, k) for k in (k0, (k0 + k1) / 2, k1)) if k0 <= k1 else ()
    return scene_of_pieces(rng, p, q, Facts(holds=holds))


# ---------------------------------------------------------------------------------------------------------------- cones


def cones(rng: Random) -> Scene:
    """Cones and pipes with whole circles: an apex on the other surface, near it, or common; pipes that cross."""
    o = vector([0, 0, 0])
    n = [F(rng.randint(1, 3)) for _ in range(4)]
    rim = shapes.circle(vector([rng.choice((0, 0, 1)), 0, n[0]]), vector([n[1], 0, 0]), vector([0, n[2], 0]))
    cone = Piece(straight(o, o), rim, None, rng.choice(((F(0), F(1)), (F(-1), F(1)), (F(0), F(2)))))
    what = rng.choice(("apex on piece", "near", "common apex", "pipes", "two cones", "tangent plane", "coaxial"))
    if what in ("apex on piece", "near"):
        q = replace(random_piece(rng, easy=True), as_lists=False)
        y = q.exact_point(*random_place(rng))
        gap_ = vector([0, 0, 0]) if what == "apex on piece" else vector([0, F(1, 10 ** rng.randint(3, 12)), 0])
        q = q.mapped(Frame(offset=sub(gap_, y)))
        return scene_of_pieces(rng, cone, q, Facts(holds=(gap_,) if what == "apex on piece" else ()))
    frame = Frame(rng.choice((turn(1, 1, 0, 0), turn(2, 1, 0, 0), turn(1, 1, 1, 0), turn(3, 0, 1, 0))))
    if what == "common apex":
        return scene_of_pieces(rng, cone, plain(cone.mapped(frame)), Facts(holds=(o,)))
    if what == "coaxial":
        shift = Frame(offset=vector([0, 0, rng.choice((F(1), F(1, 1000), F(-2)))]))
        other = plain(replace(cone, s=(F(0), F(1))).mapped(shift))
        if rng.random() < 0.5:
            other = plain(other.mapped(Frame(((F(1), F(0), F(0)), (F(0), F(1), F(0)), (F(0), F(0), F(-1))), o, None)))
        return scene_of_pieces(rng, replace(cone, s=(F(0), F(1))), other, Facts())
    if what == "pipes":
        r = n[0]
        pipes = []
        for radius in (r, rng.choice((r, r, r + 1))):
            rings = [shapes.circle(vector([0, 0, z]), vector([radius, 0, 0]), vector([0, radius, 0])) for z in (-3, 3)]
            pipes.append(Piece(rings[0], rings[1], None))
        move = Frame(frame.linear, rng.choice((o, o, vector([0, 0, 1]), vector([1, 0, 0]), vector([2 * r, 0, 0]))))
        return scene_of_pieces(rng, pipes[0], plain(pipes[1].mapped(move)), Facts())
    if what == "two cones":  # the apex of one on a ruling of the other
        u = rng.choice((F(0), F(1), F(-1, 2)))
        place = scaled(rim.at(u), rng.choice((F(1), F(1, 2))))
        other = plain(cone.mapped(Frame(frame.linear, place)))
        return scene_of_pieces(rng, cone, other, Facts(holds=(place,)))
    u = rng.choice((F(0), F(1), F(1, 3)))  # a plane that touches along a ruling, or nearly
    a = rim.at(u)
    w = 1 + u * u
    tangent = (n[1] * (-4 * u) / (w * w), n[2] * (2 * (1 - u * u)) / (w * w), F(0))
    q = shapes.four_corners(rng, *(add(scaled(a, k), scaled(tangent, m)) for k in (F(-1), F(2)) for m in (F(-2), F(2))))
    return scene_of_pieces(rng, replace(cone, s=(F(0), F(1))), q, Facts(holds=(o, a, scaled(a, F(1, 2))), area=False))


# --------------------------------------------------------------------------------------------------------------- solids


def with_solids(rng: Random) -> Scene:
    """A piece and the boundary of a solid or convex mesh that share a chosen point, or not."""
    p = replace(random_piece(rng, easy=True), as_lists=False)
    if rng.random() < 0.3:
        p = shapes.four_corners(rng, *shapes.flat_corners(rng), most=1)
        p = plain(replace(p, as_lists=False))
        if p.s is not None and p.s[1] - p.s[0] > 10:
            return with_solids(rng)
    level: Callable[[np.ndarray], float]
    body: Body
    if rng.random() < 0.7:
        solid, y = surface_points(rng)
        level, body = solid.outside, solid
    else:
        convex, mesh = shapes.convex_solid(rng)
        corners = floats_of(convex.corners)
        normals = floats_of(convex.normals)
        sides = []
        for n in (*normals, *-normals):
            n = n / np.linalg.norm(n)
            top = (corners @ n).max()
            if sum(abs(corners @ n - top) < 1e-9) >= 3:
                sides.append((n, top))
        level = lambda x: max(float(n @ x - top) for n, top in sides)  # noqa: E731
        y = scaled(add(rng.choice(convex.corners), convex.corners[0]), F(1, 2))
        body = mesh
        if level(np.array([float(c) for c in y])) < -1e-9:
            y = convex.corners[0]
    where = (F(1, 2), F(1, 3))
    u, s = random_place(rng)
    if p.u != (0, 1) or p.s != (0, 1):
        assert p.u is not None and p.s is not None
        u = p.u[0] + (p.u[1] - p.u[0]) * where[0]
        s = p.s[0] + (p.s[1] - p.s[0]) * where[1]
    x = p.exact_point(u, s)
    holds: tuple[Vector, ...] = (y,)
    offset = sub(y, x)
    if rng.random() < 0.2:
        offset, holds = add(offset, vector([0, F(1, 7), F(1, 3)])), ()
    p = plain(p.mapped(Frame(offset=offset)))
    frame = random_frame(rng, True, wild=False)
    back = inverse(frame.linear)
    there = np.array([[float(c) for c in row] for row in back])
    home = np.array([float(c) for c in frame.offset])
    size = stretch(frame)
    first = rng.random() < 0.5
    p_, body_ = p.mapped(frame), body.mapped(frame)
    tolerance = rng.choice((1e-2, 1e-3)) * size
    judge = of_solid(p_, body_, lambda z: level(there @ (z - home)) * size, Facts(holds=holds).mapped(frame.point),
                     tolerance, rng.randrange(2**30), first)
    texts = (p_.text(), body_.text()) if first else (body_.text(), p_.text())
    source = f"a = {texts[0]}\nb = {texts[1]}\nspan = None\n"
    return Scene(source, "rest", (Question(f"fc.intersection_curve(a, b, tolerance={tolerance!r})", judge),))


def floats_of(points: Sequence[Vector]) -> np.ndarray:
    return np.array([[float(c) for c in x] for x in points])


KINDS: tuple[Kind, ...] = (
    Kind("curves/flat pieces", "ruled, ruled", flat,
         "points, segments, areas and nothing, exactly: corners on borders, apexes, common rulings, one plane",
         "curved branches", laws=False),
    Kind("curves/level sets", "ruled, ruled", level_sets,
         "loops down to 1e-14, isolated points inside, on borders and corners, nodes, cusps, double curves",
         "whole rulings", laws=False),
    Kind("curves/shared features", "ruled, ruled", shared_features,
         "missing points, rulings and directrices that pieces share, tangent or not; false parts; methods that differ",
         "missing parts that no sampled ruling meets", laws=False),
    Kind("curves/cones and pipes", "ruled, ruled", cones,
         "apexes on, near and off the other surface, common apexes, pipes that touch or cross with nodes",
         "missing parts that no sampled ruling meets", laws=False),
    Kind("curves/solids", "ruled, solid or polyhedron", with_solids,
         "missing and false parts of the boundary of a solid on a piece", "parts within the tolerance of others",
         laws=False),
)
