"""Times of contact of ruled surfaces, with each other, with polyhedra and with solids of planes and quadrics.

Each kind builds the answer first: the time, the place and the features that meet there.  Then the scene is turned,
scaled and shifted exactly, either body or both move, and spans begin before, in and after the contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction as F
from random import Random

import numpy as np

from . import ruled_shapes as shapes
from .exact_numbers import (
    Near,
    Polynomial,
    Vector,
    add,
    common,
    cross,
    dot,
    image,
    merged,
    polynomial_sum,
    root_of_square,
    roots,
    scaled,
    sub,
    times,
    turn,
    value,
    vector,
    windows_below,
)
from .ruled_bodies import (
    Body,
    Curve,
    Frame,
    Mesh,
    Motion,
    Piece,
    Rational,
    Shift,
    Solid,
    Steps,
    Turn,
    moved,
    number,
    polynomial_shift,
    random_frame,
    straight,
    tangent_turn,
)
from .ruled_judges import Moved, Truth, Window, judge_first, judge_intervals
from .scene import Kind, Question, Scene

MOMENTS = (F(1, 2), F(1, 4), F(3, 4), F(1, 3), F(2, 3), F(5, 8), F(0), F(1), F(1, 10))


def both(x: F) -> Near:
    return F(x), F(x)


# ------------------------------------------------------------------------------------------------ putting together


def shared(rng: Random, motion: Motion | None) -> tuple[Motion | None, Motion | None]:
    """Motions of the two bodies whose relative motion is the one given, of the first as seen from the second."""
    roll = rng.random()
    if roll < 0.5 or motion is None:
        return motion, None
    if isinstance(motion, Shift):
        if roll < 0.75:
            return None, Shift(scaled(motion.vector, -1))
        g = vector([F(rng.randint(-4, 4), rng.choice((1, 3))) for _ in range(3)])
        return Shift(add(motion.vector, g)), Shift(g)
    if isinstance(motion, Turn):
        if roll < 0.75 or motion.advance:
            return None, replace(motion, degrees=-motion.degrees, advance=-motion.advance)
        more = F(rng.choice((30, -50, 90, 17)))
        return replace(motion, degrees=motion.degrees + more), replace(motion, degrees=more)
    if isinstance(motion, Rational):
        axis = rng.choice((vector([0, 0, 1]), vector([F(1, 3), F(2, 3), F(2, 3)]), vector([0, F(3, 5), F(4, 5)])))
        g = tangent_turn(axis, vector([rng.randint(-2, 2) for _ in range(3)]), F(rng.randint(1, 3), 2))
        if rng.random() < 0.5:
            g = polynomial_shift(vector([rng.randint(-2, 2) for _ in range(3)]), [F(0), F(1)])
        return g.after(motion), g
    return motion, None


def dyadic(x: F) -> bool:
    return x.denominator & (x.denominator - 1) == 0


def some_span(rng: Random, truth: Truth, beyond: bool, needed: bool, own: F) -> tuple[F, F] | None:
    """A span within what is known; None for that of the motions."""
    lo, hi = truth.domain
    if not beyond:
        lo, hi = max(lo, F(0)), hi
    if not needed and rng.random() < 0.5 and lo <= 0 and hi >= own:
        return None
    lo, hi = F(lo), F(float(hi)) if F(float(hi)) <= hi else F(float(hi) - 2**-50)
    marks = [lo, hi, F(0), F(1), F(float(lo + (hi - lo) * F(rng.randint(1, 15), 16)))]
    for (a, b), (c, d) in truth.windows:
        marks += [x[0] for x in ((a, b), (c, d)) if x[0] == x[1] and dyadic(x[0])]
        marks += [F(float((a + d) / 2)), F(float(a - F(1, 8))), F(float(d + F(1, 16)))]
    marks = sorted({x for x in marks if lo <= x <= hi})
    for _ in range(20):
        first, last = sorted(rng.sample(marks, 2)) if len(marks) > 1 else (lo, hi)
        if truth.whole or truth.witness or not truth.windows or first <= truth.windows[0][0][0]:
            return first, last
    return lo, hi


def assembled(
    rng: Random, p: Body, q: Body, motion: Motion | None, truth: Truth, *,
    similar: bool = True, kind: str | None = None, exact: bool = True, intervals: float = 0.35, swap: bool = True,
    wild: bool = True,
) -> Scene:
    """The scene of p, moving by `motion` as seen from q."""
    frame = random_frame(rng, similar, wild)
    if motion is None:
        common_shift = vector([rng.randint(-3, 3) for _ in range(3)])
        moves: tuple[Motion | None, Motion | None] = (None, None)
        if rng.random() < 0.3:
            moves = Shift(common_shift), Shift(common_shift)
    else:
        moves = shared(rng, motion)
    bodies = [Moved(body.mapped(frame), None if move is None else move.mapped(frame))
              for body, move in zip((p, q), moves, strict=True)]
    if swap and rng.random() < 0.5:
        bodies.reverse()
    a, b = bodies
    beyond = all(m.motion is None or m.motion.beyond for m in bodies)
    still = all(m.motion is None for m in bodies)
    own = sum(motion.durations, F(0)) if isinstance(motion, Steps) else F(1)
    span = some_span(rng, truth, beyond, still, own)
    asked = span or (F(0), own)
    span_text = "None" if span is None else f"({number(span[0])}, {number(span[1])})"
    source = f"a = {moved(a.body, a.motion)}\nb = {moved(b.body, b.motion)}\nspan = {span_text}\n"
    first = judge_first(truth, asked, a, b)
    questions = [Question("fc.first_contact(a, b, span)", first)]
    if exact and rng.random() < 0.2:
        questions.append(Question("fc.first_contact(a, b, span, exact=True)", first))
    if rng.random() < intervals:
        option = ", exact=True" if exact and rng.random() < 0.3 else ""
        questions.append(Question(f"fc.contact_intervals(a, b, span{option})", judge_intervals(truth, asked)))
    return Scene(source, kind or (motion.kind if motion is not None else "rest"), tuple(questions))


def moment(rng: Random) -> F:
    return rng.choice(MOMENTS)


# ------------------------------------------------------------------------------------- flat pieces, separating axes


def place_on(rng: Random, corners: Sequence[Vector]) -> Vector:
    """A corner, a place on a side, or one inside of a convex quadrangle p00, p10, p01, p11."""
    p00, p10, p01, p11 = corners
    u, s = (rng.choice((F(0), F(0), F(1), F(1), F(1, 2), F(1, 3))) for _ in range(2))
    return add(scaled(shapes.blended(p00, p10, u), 1 - s), scaled(shapes.blended(p01, p11, u), s))


def velocity_for(rng: Random, p: Vector, q: Vector, at: F) -> Vector:
    return vector([rng.randint(-4, 4) for _ in range(3)]) if at == 0 else scaled(sub(q, p), 1 / at)


def flat_flat(rng: Random) -> Scene:
    """Two flat pieces or one and a flat facet; also sliding in one plane."""
    first, second = shapes.flat_corners(rng), shapes.flat_corners(rng)
    if rng.random() < 0.2:  # in one plane, or in parallel ones
        first, second = (tuple((x, y, F(0)) for x, y, _ in c) for c in (first, second))
        if not all(any(n) for c in (first, second) for n in (_area(c),)):
            first, second = ((vector([0, 0, 0]), vector([2, 0, 0]), vector([0, 1, 0]), vector([2, 1, 0])),
                             (vector([0, 0, 0]), vector([1, 1, 0]), vector([-1, 1, 0]), vector([0, 2, 0])))
    at = moment(rng)
    a, b = place_on(rng, first), place_on(rng, second)
    apart = vector([rng.randint(-5, 5), rng.randint(-5, 5), rng.choice((0, 0, 3))])
    second = tuple(add(c, add(sub(a, b), apart)) for c in second)  # its place is at a + apart
    velocity = velocity_for(rng, a, add(a, apart), at) if any(apart) else vector([rng.randint(-3, 3) for _ in range(3)])
    ring = (second[0], second[1], second[3], second[2])
    distinct = tuple(c for i, c in enumerate(ring) if c != ring[i - 1])
    other: Body = (shapes.four_corners(rng, *second) if rng.random() < 0.7
                   else Mesh(distinct, (tuple(range(len(distinct))),)))
    domain = (F(-1), F(2))
    window = shapes.meeting(shapes.flat_convex(first), shapes.flat_convex(second), velocity, domain)
    truth = Truth(() if window is None else ((both(window[0]), both(window[1])),), domain)
    return assembled(rng, shapes.four_corners(rng, *first), other, Shift(velocity), truth, similar=False)


def _area(c: Sequence[Vector]) -> Vector:
    return add(cross(sub(c[1], c[0]), sub(c[3], c[0])), cross(sub(c[3], c[0]), sub(c[2], c[0])))


def flat_solid(rng: Random) -> Scene:
    """A flat piece and a convex solid of planes."""
    corners = shapes.flat_corners(rng)
    convex, solid = shapes.convex_solid(rng)
    at = moment(rng)
    a = place_on(rng, corners)
    b = rng.choice(convex.corners)
    if rng.random() < 0.5:
        b = scaled(add(b, rng.choice(convex.corners)), F(1, 2))
    apart = vector([rng.randint(-6, 6) for _ in range(3)])
    start = add(sub(b, a), apart)
    corners = tuple(add(c, start) for c in corners)
    velocity = scaled(apart, -1 / at) if at and any(apart) else vector([rng.randint(-3, 3) for _ in range(3)])
    domain = (F(-1), F(2))
    flat = shapes.flat_convex(corners)
    window = shapes.meeting(flat, convex, velocity, domain)
    truth = Truth(() if window is None else ((both(window[0]), both(window[1])),), domain,
                  initial=lambda t: shapes.initial_of_convex(flat, convex, scaled(velocity, t)))
    return assembled(rng, shapes.four_corners(rng, *corners), solid, Shift(velocity), truth, similar=False)


# --------------------------------------------------------------------------------------------- graphs over rectangles


def height(rng: Random, degree: int) -> Polynomial:
    """A polynomial of the time with chosen roots, often double ones."""
    speed = F(rng.choice((1, 2, -1, 3, F(1, 8))))
    out = [speed]
    again: F | None = None
    for _ in range(degree):
        again = again if again is not None and rng.random() < 0.4 else moment(rng)
        out = times(out, [-again, F(1)])
    if rng.random() < 0.15:
        out = polynomial_sum(out, [rng.choice((1, -1)) * F(1, 10 ** rng.randint(3, 14))])
    return out


def overlapping(rng: Random) -> tuple[tuple[F, F], tuple[F, F], F]:
    """Two ranges that share some, or one point, and a place in both."""
    how = rng.randrange(4)
    if how == 0:  # end on end
        return (F(-2), F(0)), (F(0), F(rng.randint(1, 3))), F(0)
    if how == 1:  # one in the other
        return (F(-1), F(1)), (F(-3), F(2)), rng.choice((F(0), F(1), F(-1), F(1, 3)))
    if how == 2:  # the same
        return (F(0), F(2)), (F(0), F(2)), rng.choice((F(0), F(1), F(2), F(2, 3)))
    return (F(-1), F(2)), (F(0), F(3)), rng.choice((F(0), F(2), F(1)))


def two_graphs(rng: Random) -> tuple[Piece, Piece, F]:
    """P over Q, rulings along either side; they touch somewhere and P lies above; and their greatest distance."""
    (px, qx, cx), (py, qy, cy) = overlapping(rng), overlapping(rng)
    base = [F(rng.randint(-2, 2)) for _ in range(4)] if rng.random() < 0.6 else [F(0)] * 4
    along = [rng.choice("xy"), rng.choice("xy")]
    over = [(max(px[0], qx[0]), min(px[1], qx[1])), (max(py[0], qy[0]), min(py[1], qy[1]))]
    curved = [k for k in (0, 1) if any(a != "xy"[k] for a in along)]  # coordinates in which a piece may be curved
    bumps: dict[int, tuple[Polynomial, Polynomial, F]] = {}
    for k, c in ((0, cx), (1, cy)):
        bumps[k] = shapes.bump(rng, c, over[k], k in curved)
    bodies = []
    free = {0, 1}
    for which, (x, y) in enumerate(((px, py), (qx, qy))):
        sign = 1 if which == 0 else -1
        own = 0 if along[which] == "y" else 1  # the coordinate in which it may be curved
        mine, straight_ = ([F(0)], [F(1)]), list(base)
        other_may = along[1 - which] != along[which]
        if own in free:
            top, bottom, _ = bumps[own]
            mine = ([sign * c for c in top], bottom)
            free.discard(own)
        cross_ = 1 - own
        if cross_ in free and not other_may:  # then it is straight
            top = bumps[cross_][0]
            straight_[0] += sign * top[0]
            if len(top) > 1:
                straight_[1 + cross_] += sign * top[1]
            free.discard(cross_)
        whole = rng.random() < 0.15 and which == 1
        whole = whole and _covers(along[1], (px, py), (qx, qy))
        bodies.append(shapes.graph(rng, along[which], x, y, straight_, mine, whole))
    return bodies[0], bodies[1], bumps[0][2] + bumps[1][2]


def _covers(along: str, p: tuple[tuple[F, F], ...], q: tuple[tuple[F, F], ...]) -> bool:
    """Whether Q covers P along its rulings, so that they may go on without end."""
    k = 0 if along == "x" else 1
    return q[k][0] <= p[k][0] and p[k][1] <= q[k][1]


def windows_of_height(h: Polynomial, most: F, domain: tuple[F, F]) -> tuple[Window, ...]:
    below = windows_below(h, *domain)
    above = windows_below([-c for c in h], *domain, bound=most)
    return tuple(merged(common(below, above)))


UP: Vector = (F(0), F(0), F(1))


def graphs(rng: Random, deforming: bool = False) -> Scene:
    """Graphs that come down on each other: grazes, corners, borders, common rulings, lasting contact."""
    p, q, most = two_graphs(rng)
    how = "deforming" if deforming else rng.choice(("translation", "rational", "sequence"))
    if how == "translation":
        domain = (F(-1), F(2))
        h = height(rng, 1)
        motion: Motion | None = Shift((F(0), F(0), h[1]))
        p = p.mapped(Frame(offset=(F(0), F(0), h[0]))) if not p.as_lists else replace(p, placed=None).mapped(
            Frame(offset=(F(0), F(0), h[0])))
        return assembled(rng, _plain(p), q, motion, Truth(windows_of_height(h, most, domain), domain), similar=False)
    if how == "sequence":
        return _bouncing(rng, p, q, most)
    domain = (F(0), F(1))
    h = height(rng, rng.choice((1, 2, 2, 3)))
    truth = Truth(windows_of_height(h, most, domain), domain)
    if how == "rational":
        return assembled(rng, p, q, polynomial_shift(UP, h), truth, similar=False)
    if rng.random() < 0.5:
        return assembled(rng, replace(p, lift=(UP, h), as_lists=False), q, None, truth, similar=False, kind="deforming")
    q = replace(q, lift=(UP, [-c for c in h]), as_lists=False)
    return assembled(rng, p, q, None, truth, similar=False, kind="deforming")


def _plain(p: Piece) -> Piece:
    """The same piece, its placing worked out."""
    if p.placed is None:
        return p
    frame = p.placed
    return replace(p, first=p.first.mapped(frame), second=p.second.mapped(frame), placed=None)


def _bouncing(rng: Random, p: Piece, q: Piece, most: F) -> Scene:
    """Steps up and down, so that contact begins and ends within steps and between them."""
    at = rng.choice((F(1), F(2), F(1, 2)))
    p = _plain(replace(p, as_lists=False).mapped(Frame(offset=(F(0), F(0), at))))
    steps, durations, windows = [], [], []
    start = F(0)
    for _ in range(rng.randint(2, 4)):
        change = rng.choice((-at, -at, -2 * at, at, F(1), F(-3), F(0)))
        length = rng.choice((F(1), F(1, 2), F(2), F(1, 3)))
        if rng.random() < 0.3:
            steps.append(polynomial_shift(UP, [F(0), F(0), change]))
            h = [at, F(0), change]
        else:
            steps.append(Shift((F(0), F(0), change)))
            h = [at, change]
        for (a, b), (c, d) in windows_of_height(h, most, (F(0), F(1))):
            windows.append(((start + a * length, start + b * length), (start + c * length, start + d * length)))
        at += change
        start += length
        durations.append(length)
    motion = Steps(tuple(steps), tuple(durations))
    return assembled(rng, p, q, motion, Truth(tuple(merged(windows)), (F(0), start)), similar=True)


# ------------------------------------------------------------------------------------------------------- tips on tops


def tips(rng: Random, solid: bool, deforming: bool = False) -> Scene:
    """What points down meets what points up: apexes, corners, edges, ridges; with a turn about the vertical."""
    p = shapes.pointing_down(rng)
    q: Body
    if solid:
        q = shapes.top_solid(rng)
    else:
        q = _plain(replace(shapes.pointing_down(rng), as_lists=False).mapped(shapes.MIRRORED))
    if rng.random() < 0.4:
        q = q.mapped(Frame(rng.choice((shapes.QUARTER.linear, turn(2, 0, 0, 1), turn(3, 0, 0, -1)))))
        q = _plain(q) if isinstance(q, Piece) else q
    unbounded = isinstance(q, Solid) and "half_space" in q.expression
    how = "deforming" if deforming else rng.choice(("translation", "screw", "rational", "turning", "sequence"))
    sharp = p.mapped(Frame(offset=(F(0), F(0), F(1))))
    o = vector([0, 0, 0])
    if how in ("translation", "screw", "sequence"):
        at = moment(rng) or F(1, 2)
        up = F(rng.choice((1, 2, 3)))
        miss = rng.random() < 0.15
        speed = -up / at * (1 - F(1, 10 ** rng.randint(3, 15))) if miss else -up / at
        sharp = _plain(replace(p, as_lists=False).mapped(Frame(offset=(F(0), F(0), up))))
        domain = (F(0), F(1)) if not miss else (F(0), at)
        truth = Truth(() if miss else ((both(at), both(at)),), domain, whole=miss)
        if how == "translation":
            sideways = vector([rng.randint(-2, 2), rng.randint(-2, 2), 0]) if unbounded else o
            return assembled(rng, sharp, q, Shift(add(sideways, (F(0), F(0), speed))), truth, similar=False)
        degrees = F(rng.choice((90, -30, 360, 45, 1000)))
        if how == "screw":
            return assembled(rng, sharp, q, Turn(UP, o, degrees, speed), truth, exact=False, intervals=0.05)
        half = Turn(UP, o, degrees)
        parts = (F(1), F(1, 2)) if rng.random() < 0.5 else (F(1, 2), F(2))
        motion = Steps((half, Shift((F(0), F(0), speed))), parts)
        when = parts[0] + parts[1] * at
        end = parts[0] + parts[1] * (at if miss else 1)
        return assembled(rng, sharp, q, motion,
                         Truth(() if miss else ((both(when), both(when)),), (F(0), end), whole=miss), exact=False)
    if how == "turning":  # above, or on it all the time
        gap = rng.choice((F(0), F(0), F(1, 10**6), F(1, 10**12)))
        sharp = _plain(replace(p, as_lists=False).mapped(Frame(offset=(F(0), F(0), gap))))
        domain = (F(-1), F(2))
        truth = Truth(((both(F(-1)), both(F(2))),) if gap == 0 else (), domain)
        return assembled(rng, sharp, q, Turn(UP, o, F(rng.choice((90, 200, -360)))), truth, exact=False, intervals=0.1)
    h = height(rng, rng.choice((1, 2)))
    if rng.random() < 0.5:
        h = times(h, h)
    domain = (F(0), F(1))
    zeros = roots(h, *domain)
    never_below = not any(a[0] != b[0] or a[1] != b[1] for a, b in windows_below(h, *domain))
    below = windows_below(h, *domain)
    if not never_below and value(h, F(0)) < 0:
        h = [-c for c in h]
        zeros, below = roots(h, *domain), windows_below(h, *domain)
        if value(h, F(0)) == 0 or not below:
            return tips(rng, solid, deforming)
    if never_below or not below:
        truth = Truth(tuple((z, z) for z in zeros), domain)
    elif below[0][0][1] <= 0:
        return tips(rng, solid, deforming)
    else:
        truth = Truth((below[0],), domain, whole=False)
    if how == "rational":
        motion = polynomial_shift(UP, h)
        if rng.random() < 0.5:
            motion = motion.after(tangent_turn(UP, o, F(rng.choice((1, 2, -1)))))
        return assembled(rng, p, q, motion, truth, similar=True)
    return assembled(rng, replace(p, lift=(UP, h), as_lists=False), q, None, truth, similar=False, kind="deforming")


# --------------------------------------------------------------------------------------------------- landing by turning


def landing(rng: Random) -> Scene:
    """A piece that turns about a horizontal axis until its lowest corners meet what lies below, at a known angle."""
    while True:
        nets = []
        for _ in range(2):
            degree = rng.choice((0, 1, 1, 2, 3))
            nets.append([vector([rng.randint(0, 3), rng.randint(-2, 2), rng.choice((0, 0, 1, 2))])
                         for _ in range(degree + 1)])
        points = nets[0] + nets[1]
        spread = [sub(x, points[0]) for x in points]
        if not any(any(cross(x, y)) for x in spread for y in spread):
            continue
        if any(x[0] == 0 and x[2] == 0 for x in points):
            continue
        at_angle = rng.choice(("quarter", "rational", "rational"))
        if at_angle == "quarter":
            c, s = F(0), F(1)
        else:
            tau = rng.choice((F(1, 2), F(1, 3), F(1), F(2, 3)))
            c, s = (1 - tau**2) / (1 + tau**2), 2 * tau / (1 + tau**2)
        low = [x[0] * s - x[2] * c for x in points]
        corners = [net[k] for net in nets for k in (0, -1)]
        depth = max(low)
        lowest = [x for x in corners if x[0] * s - x[2] * c == depth]
        if lowest:
            break
    try_piece = Piece(shapes.bezier(nets[0]), shapes.bezier(nets[1]), as_lists=rng.random() < 0.4)
    corner = rng.choice(lowest)
    place = (corner[0] * c + corner[2] * s, corner[1], -depth)
    up = F(0)
    y = vector([0, 1, 0])
    advance = F(0)
    motion: Motion
    if at_angle == "quarter":
        when = rng.choice((F(1), F(1, 2), F(3, 4), F(9, 10), F(1, 4)))
        if rng.random() < 0.4:
            advance = F(rng.choice((1, -2, 3)))
        motion = Turn(y, vector([0, 0, 0]), F(90) / when, advance)
    else:
        when = rng.choice((F(1), F(1, 2), F(2, 3), F(3, 5)))
        motion = tangent_turn(y, vector([0, 0, 0]), tau / when)
    place = add(place, (F(0), advance * when, F(0)))
    end = F(1)
    if rng.random() < 0.25:
        up = F(rng.randint(1, 2))
        parts = (F(1), F(2))
        motion = Steps((Shift((F(0), F(0), -up)), motion), parts)
        when = parts[0] + parts[1] * when
        end = F(3)
    wide = rng.randrange(4)
    q: Body
    if wide == 0:
        q = Solid("fc.half_space((0, 0, 1), 0)", lambda x: float(x[2]), 1.0)
    elif wide == 1:
        q = shapes.four_corners(rng, *(vector([a, b, 0]) for b in (-20, 20) for a in (-20, 20)))
        place = (F(0), F(0), place[2])
    elif wide == 2:
        q = shapes.top_solid(rng)
    else:
        q = _plain(replace(shapes.pointing_down(rng), as_lists=False).mapped(shapes.MIRRORED))
    q = q.mapped(Frame(offset=place))
    if isinstance(q, Piece):
        q = _plain(q)
    p = try_piece.mapped(Frame(offset=(F(0), F(0), up)))
    truth = Truth(((both(when), both(when)),), (F(0), end), whole=False)
    return assembled(rng, _plain(p), q, motion, truth, exact=advance == 0)


# --------------------------------------------------------------------------------------------- upright, seen from above


def _square(x: Sequence[Polynomial]) -> Polynomial:
    return polynomial_sum(times(x[0], x[0]), times(x[1], x[1]))


def pipes(rng: Random, solid: bool) -> Scene:
    """Upright cylinders, strips and tubes under a translation: circles and segments in the plane."""
    domain = (F(-1), F(2))
    r = F(rng.choice((1, 2, 5, F(3, 2))))
    inner = r / 2
    what = rng.choice(("solid", "tube")) if solid else "circle"
    at = moment(rng)
    velocity = vector([rng.randint(-4, 4), rng.randint(-4, 4), rng.choice((0, 0, 1, -2))])
    touch = scaled(rng.choice((vector([1, 0, 0]), vector([F(3, 5), F(4, 5), 0]), vector([0, -1, 0]),
                               vector([F(-5, 13), F(12, 13), 0]))), rng.choice((r, r, r, inner)))
    heights = (F(rng.choice((-2, -1, 0))), F(rng.choice((1, 2, 0)) or 3))
    heights = (heights[0] - at * velocity[2] * rng.choice((0, 1)), heights[1] - at * velocity[2] * rng.choice((0, 1)))
    heights = (min(heights), max(heights) + (min(heights) == max(heights)))
    tall = F(rng.choice((2, 4, 1)))

    def disc(p: Sequence[Polynomial], r2: F) -> list[Window]:
        return windows_below(_square(p), *domain, bound=r2)

    def beyond(p: Sequence[Polynomial], r2: F) -> list[Window]:
        return windows_below([-c for c in _square(p)], *domain, bound=-r2)

    def track(x: Vector) -> list[Polynomial]:
        return [[x[i], velocity[i]] for i in (0, 1)]

    levels = common(windows_below([heights[0], velocity[2]], *domain, bound=tall / 2),
                    windows_below([-heights[1], -velocity[2]], *domain, bound=tall / 2))
    second_circle = not solid and rng.random() < 0.5 or solid and rng.random() < 0.3
    if second_circle:
        r2 = rng.choice((r, r / 3, 2 * r, F(1)))
        sign = rng.choice((1, 1, -1))  # outside or inside
        centre = scaled(touch, (r + sign * r2) / r)
        centre = sub(centre, scaled(velocity, at))
        centre = (centre[0], centre[1], F(0))
        d = track(centre)
        ring = [shapes.circle((centre[0], centre[1], z), vector([r2, 0, 0]), vector([0, r2, 0])) for z in heights]
        p = Piece(ring[0], ring[1], None, as_lists=rng.random() < 0.3)
        far, near = (r + r2), abs(r - r2)
        if what == "circle":
            flat = common(disc(d, far**2), beyond(d, near**2))
        elif what == "solid":  # circle within the disc too
            flat = disc(d, far**2)
            if r2 > r:
                flat = common(flat, beyond(d, (r2 - r) ** 2))
        else:
            flat = disc(d, far**2)
            if r2 > r:
                flat = common(flat, beyond(d, (r2 - r) ** 2))
            if r2 < inner:
                flat = common(flat, beyond(d, (inner - r2) ** 2))
    else:
        along = rng.choice((vector([-touch[1], touch[0], 0]), vector([1, 2, 0]), touch,
                            vector([rng.randint(1, 3), -1, 0])))
        k0, k1 = rng.choice(((F(0), F(1)), (F(-1), F(1)), (F(-1), F(0)), (F(-1, 3), F(2))))
        start = sub(touch, scaled(velocity, at))
        e0, e1 = ((x[0], x[1], F(0)) for x in (add(start, scaled(along, k0)), add(start, scaled(along, k1))))
        p = shapes.four_corners(rng, *((x[0], x[1], z) for z in heights for x in (e0, e1)))
        if rng.random() < 0.5:  # rulings upright
            p = shapes.four_corners(rng, *((x[0], x[1], z) for x in (e0, e1) for z in heights))
        a, b = track(e0), track(e1)
        dx = sub(e1, e0)
        dd = dot(dx, dx)
        side = [-(e0[0] * dx[1] - e0[1] * dx[0]), -(velocity[0] * dx[1] - velocity[1] * dx[0])]
        foot = [-dot(e0, dx), -dot((velocity[0], velocity[1], F(0)), dx)]
        beside = common(windows_below([-c for c in foot], *domain), windows_below(foot, *domain, bound=dd))

        def nearer(r2: F) -> list[Window]:
            return merged(disc(a, r2) + disc(b, r2)
                          + common(windows_below(times(side, side), *domain, bound=r2 * dd), beside))

        flat = nearer(r * r)
        least = {"circle": r, "solid": F(0), "tube": inner}[what]
        if least:
            flat = common(flat, merged(beyond(a, least**2) + beyond(b, least**2)))
    windows = tuple(merged(common(merged(flat), levels)))
    truth = Truth(windows, domain, initial=lambda t: None if solid else "touching")
    q: Body
    if what == "circle":
        ring = [shapes.circle((F(0), F(0), z), vector([r, 0, 0]), vector([0, r, 0])) for z in (-tall / 2, tall / 2)]
        q = Piece(ring[0], ring[1], None, as_lists=rng.random() < 0.3)
    else:
        text = f"fc.cylinder({number(r)}, {number(tall)})"
        hole = float(inner) if what == "tube" else 0.0
        if what == "tube":
            text = f"({text} - fc.cylinder({number(inner)}, {number(2 * tall)}))"
        q = Solid(text, lambda x: max(float(np.hypot(x[0], x[1])) - float(r), hole - float(np.hypot(x[0], x[1])),
                                      abs(float(x[2])) - float(tall) / 2), float(max(r, tall)) * 2)
    return assembled(rng, p, q, Shift(velocity), truth, similar=True)


# ------------------------------------------------------------------------------------------------ balls and flat pieces


def nearest(around: Sequence[Vector], normal: Vector) -> F:
    """The square of the distance of a convex polygon from the origin."""
    squares = []
    within = True
    for i, x in enumerate(around):
        d = sub(around[i - 1], x)
        k = min(max(-dot(x, d) / dot(d, d), F(0)), F(1))
        foot = add(x, scaled(d, k))
        squares.append(dot(foot, foot))
        side = cross(normal, d)
        within &= dot(side, x) * dot(side, sub(around[i - 2], x)) <= 0
    return dot(around[0], normal) ** 2 / dot(normal, normal) if within else min(squares)


def balls(rng: Random) -> Scene:
    """A flat piece and a ball under a translation."""
    domain = (F(-1), F(2))
    r = F(rng.choice((1, 3, 9, F(3, 2))))
    unit = rng.choice((vector([0, 0, 1]), vector([F(1, 3), F(2, 3), F(2, 3)]), vector([F(3, 5), 0, F(-4, 5)]),
                       vector([F(2, 7), F(3, 7), F(6, 7)])))
    at = moment(rng)
    while True:
        corners = shapes.flat_corners(rng)
        if rng.random() < 0.4:  # flat on the ball
            frame = rng.choice((turn(1, 0, 0, 0), turn(1, 1, 0, 0)))
            e = image(frame, cross(unit, vector([1, 2, -1])))
            e = sub(e, scaled(unit, dot(e, unit)))
            if not any(e):
                continue
            f = cross(unit, e)
            corners = tuple(add(scaled(e, F(i)), scaled(f, F(j))) for j in (-1, 1) for i in (-1, 1))
        break
    place = place_on(rng, corners)
    if rng.random() < 0.4:
        place = add(scaled(corners[0], F(1, 4)), scaled(add(corners[1], add(corners[2], corners[3])), F(1, 4)))
    velocity = vector([rng.randint(-4, 4) for _ in range(3)])
    if rng.random() < 0.3:
        velocity = cross(unit, velocity)  # along the ball: a graze
    velocity = velocity if any(velocity) else vector([1, 1, 0])
    start = sub(scaled(unit, r), add(place, scaled(velocity, at)))
    corners = tuple(add(c, start) for c in corners)
    p00, p10, p01, p11 = corners
    ring = [p00, p10, p11, p01]
    around = [p for i, p in enumerate(ring) if p != ring[i - 1]]
    windows: list[Window] = []

    def track(x: Vector) -> list[Polynomial]:
        return [[x[i], velocity[i]] for i in range(3)]

    def along(x: Vector, n: Vector) -> Polynomial:
        return [dot(x, n), dot(velocity, n)]

    normal = shapes.flat_convex(corners).normals[0]
    within = windows_below(times(along(p00, normal), along(p00, normal)), *domain, bound=r * r * dot(normal, normal))
    for i, x in enumerate(around):
        y = around[i - 1]
        d = sub(y, x)
        dd = dot(d, d)
        position = track(x)
        square = polynomial_sum(_square(position), times(position[2], position[2]))
        windows += windows_below(square, *domain, bound=r * r)
        foot = [-c for c in along(x, d)]
        across = polynomial_sum([dd * c for c in square], [-c for c in times(foot, foot)])
        windows += common(windows_below(across, *domain, bound=r * r * dd),
                          common(windows_below([-c for c in foot], *domain), windows_below(foot, *domain, bound=dd)))
        side = cross(normal, d)
        if dot(side, sub(around[i - 2], x)) < 0:
            side = scaled(side, -1)
        within = common(within, windows_below(along(x, side), *domain))  # the centre is on the inner side
    found = merged(windows + within)

    def initial(t: F) -> str | None:
        square = nearest([add(c, scaled(velocity, t)) for c in around], normal)
        if square >= r * r:
            return "touching"
        far = max(dot(x, x) for x in (add(c, scaled(velocity, t)) for c in corners))
        return "containment" if far < r * r else "overlapping"

    ball = Solid(f"fc.sphere({number(r)})", lambda x: float(np.linalg.norm(x)) - float(r), 2 * float(r))
    return assembled(rng, shapes.four_corners(rng, *corners), ball, Shift(velocity),
                     Truth(tuple(found), domain, initial=initial), similar=True)


# ----------------------------------------------------------------------------------------------------- trimmed discs


def discs(rng: Random) -> Scene:
    """A disc, a square with an inequality, and a wide wall: closed form."""
    domain = (F(-1), F(2))
    normal = rng.choice((vector([3, 4, 0]), vector([1, 0, 0]), vector([1, 1, 1]), vector([2, 1, 2]), vector([0, 1, 0])))
    along = cross(normal, vector([1, 2, -3]))
    along, wide = (scaled(d, F(30) / max(map(abs, d))) for d in (along, cross(normal, along)))
    at = moment(rng)
    reach = root_of_square(normal[0] ** 2 + normal[1] ** 2)  # of the unit disc along the normal
    velocity = vector([rng.randint(-3, 3) for _ in range(3)])
    speed = dot(velocity, normal)
    deep = reach[0] if reach[0] == reach[1] else F(1)
    offset = -speed * at - rng.choice((deep, F(0), deep))  # normal . centre at time 0
    wall = shapes.four_corners(rng, *(add(scaled(along, i), scaled(wide, j)) for j in (-1, 1) for i in (-1, 1)))
    centre = scaled(normal, offset / dot(normal, normal))
    disc = Piece(straight(vector([-1, -1, 0]), vector([0, -1, 0])), straight(vector([-1, 1, 0]), vector([0, 1, 0])),
                 (F(0), F(2)), trim=("(u-1)**2 + (2*s-1)**2 <= 1",))
    disc = _plain(disc.mapped(Frame(offset=centre)))
    if speed == 0:
        windows: tuple[Window, ...] = ()
        if abs(offset) <= reach[0]:
            windows = ((both(domain[0]), both(domain[1])),)
    else:
        ends: list[Near] = []
        for sign in (1, -1):
            x = sorted((sign * e - offset) / speed for e in reach)
            ends.append((x[0], x[1]))
        ends.sort()
        windows = ((ends[0], ends[1]),)
    cut = tuple((max(w[0], both(domain[0])), min(w[1], both(domain[1]))) for w in windows
                if w[1][1] >= domain[0] and w[0][0] <= domain[1])
    if any(max(abs(c) for c in add(centre, scaled(velocity, t))) > 12 for t in domain):
        return discs(rng)
    return assembled(rng, disc, wall, Shift(velocity), Truth(cut, domain), similar=False)


# ------------------------------------------------------------------------------------------------- witnesses of contact


def random_curve(rng: Random) -> Curve:
    degree = rng.choice((1, 1, 2, 2, 3))
    curve = shapes.bezier([vector([rng.randint(-3, 3) for _ in range(3)]) for _ in range(degree + 1)])
    if rng.random() < 0.3:
        weight = rng.choice(([F(1), F(0), F(1)], [F(2), F(1)], [F(4), F(-1), F(1)]))
        return Curve(curve.x, weight)
    return curve


def random_piece(rng: Random, easy: bool = False) -> Piece:
    """Any piece of degree 1 to 3, u in [0, 1]."""
    while True:
        first = random_curve(rng)
        second = Curve(random_curve(rng).x, first.w) if rng.random() < 0.5 else random_curve(rng)
        if easy and max(first.degree, second.degree) > 2:
            continue
        points = [c.at(F(k, 3)) for c in (first, second) for k in range(4)]
        spread = [sub(x, points[0]) for x in points]
        if any(any(cross(x, y)) for x in spread for y in spread):
            return Piece(first, second, as_lists=rng.random() < 0.3)


def random_place(rng: Random) -> tuple[F, F]:
    return tuple(rng.choice((F(0), F(1), F(0), F(1), F(1, 2), F(1, 3), F(3, 8))) for _ in range(2))  # type: ignore[return-value]


def surface_points(rng: Random) -> tuple[Solid, Vector]:
    """A solid and a point of its boundary."""
    n = [F(rng.randint(1, 3)) for _ in range(3)]
    direction = rng.choice((vector([F(3, 5), F(4, 5), 0]), vector([0, -1, 0]), vector([F(-5, 13), F(12, 13), 0])))
    what = rng.randrange(4)
    if what == 0:
        unit = rng.choice((vector([F(1, 3), F(2, 3), F(-2, 3)]), vector([0, 0, 1]), direction))
        r = float(n[0])
        return Solid(f"fc.sphere({n[0]})", lambda x: float(np.linalg.norm(x)) - r, 2 * r), scaled(unit, n[0])
    if what == 1:
        r, h = float(n[0]), float(n[1]) / 2
        k = rng.choice((F(1), F(1), F(1, 2)))
        z = n[1] / 2 * (rng.choice((F(0), F(1), F(-1, 3))) if k == 1 else 1)
        return (Solid(f"fc.cylinder({n[0]}, {n[1]})",
                      lambda x: max(float(np.hypot(x[0], x[1])) - r, abs(float(x[2])) - h), 2 * max(r, h)),
                add(scaled(direction, n[0] * k), (F(0), F(0), z)))
    if what == 2:
        r, h = float(n[0]), float(n[1])
        k = rng.choice((F(0), F(1), F(1, 2), F(1, 3)))
        return (Solid(f"fc.cone({n[0]}, {n[1]})",
                      lambda x: max(float(np.hypot(x[0], x[1])) - r * (1 - float(x[2]) / h), -float(x[2])),
                      2 * max(r, h)),
                add(scaled(direction, n[0] * k), (F(0), F(0), n[1] * (1 - k))))
    h3 = np.array([float(c) / 2 for c in n])
    place = vector([n[0] / 2, n[1] / 2 * rng.choice((1, F(1, 3))), n[2] / 2 * rng.choice((-1, F(1, 2)))])
    return (Solid(f"fc.box(({n[0]}, {n[1]}, {n[2]}))", lambda x: float(np.max(np.abs(x) - h3)), float(max(n))), place)


def quarter_image(axis: int, quarters: int, x: Vector) -> Vector:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = list(x)
    for _ in range(quarters % 4):
        out[i], out[j] = -out[j], out[i]
    return out[0], out[1], out[2]


def witnesses(rng: Random, other: str, deforming: bool = False) -> Scene:
    """Any two bodies under any motion that certainly meet at a chosen time; how much earlier is not known."""
    p = random_piece(rng, easy=True)
    x = p.exact_point(*random_place(rng))
    q: Body
    if other == "piece":
        q = random_piece(rng, easy=True)
        y = q.exact_point(*random_place(rng))
    elif other == "solid":
        q, y = surface_points(rng)
    else:
        convex, mesh = shapes.convex_solid(rng)
        while not isinstance(mesh, Mesh):
            convex, mesh = shapes.convex_solid(rng)
        face = rng.choice(mesh.faces)
        i, j = rng.choice(face), rng.choice(face)
        y = scaled(add(mesh.vertices[i], mesh.vertices[j]), F(1, 2))
        q = mesh
        if rng.random() < 0.3:
            q = Mesh(mesh.vertices, tuple(f for f in mesh.faces if f == face or rng.random() < 0.6))
    at = rng.choice((F(1), F(1, 2), F(3, 4), F(1, 4)))
    how = "deforming" if deforming else rng.choice(
        ("translation", "rotation", "rotation", "screw", "rational", "rational", "sequence"))
    motion: Motion | None = None
    o = vector([rng.randint(-2, 2) for _ in range(3)])
    away = vector([rng.randint(-6, 6) for _ in range(3)])
    end = F(1)
    exact = how in ("translation", "rational", "deforming")
    if how == "translation":
        motion = Shift(away if any(away) else UP)
        there = add(x, scaled(motion.vector, at))
    elif how in ("rotation", "screw", "sequence"):
        axis, quarters = rng.randrange(3), rng.choice((1, -1, 2, 3, 4))
        unit = vector([1 if k == axis else 0 for k in range(3)])
        advance = F(rng.randint(1, 6)) if how == "screw" else F(0)
        motion = Turn(unit, o, quarters * 90 / at, advance)
        there = add(add(o, quarter_image(axis, quarters, sub(x, o))), scaled(unit, advance * at))
        if how == "sequence":
            steps: tuple[Motion, ...] = (motion, Shift(away))
            if at != 1:
                steps = (Shift(away), motion)
                there = add(o, quarter_image(axis, quarters, sub(add(x, away), o)))
                at = 1 + at
            else:
                there = add(there, scaled(away, F(1, 2)))
                at = F(3, 2)
            motion = Steps(steps, (F(1), F(1)))
            end = F(2)
    elif how == "rational":
        unit = rng.choice((vector([0, 0, 1]), vector([F(2, 3), F(-1, 3), F(2, 3)]), vector([F(3, 5), 0, F(4, 5)])))
        rate = F(rng.choice((1, 2, -1, F(1, 2))))
        spin = tangent_turn(unit, o, rate)
        drift = polynomial_shift(away, [F(0), F(1)] if rng.random() < 0.7 else [F(0), F(1), F(-1)])
        motion = drift.after(spin)
        m = [[sum((c[i][j] * at**k for k, c in enumerate(motion.coefficients)), F(0)) for j in range(4)]
             for i in range(4)]
        there = tuple((dot(tuple(m[i][:3]), x) + m[i][3]) / m[3][3] for i in range(3))  # type: ignore[arg-type,assignment]
    else:
        lift = (away if any(away) else UP, [F(0), F(1)])
        p = replace(_plain(p), lift=lift, as_lists=False)
        there = add(x, scaled(lift[0], at))
    q = q.mapped(Frame(offset=sub(there, y)))
    if isinstance(q, Piece):
        q = _plain(q)
    truth = Truth(((both(at), both(at)),), (F(0), end), whole=False, witness=True, initial=lambda t: None)
    return assembled(rng, p, q, motion, truth, exact=exact, intervals=0.15 if other != "mesh" else 0.05,
                     kind=how if motion is None else None)


# ------------------------------------------------------------------------------------------- conditions without v


def conditions(rng: Random) -> Scene:
    """contact_condition of two graphs, one rising with T: whether one ruling meets the other piece is a closed form."""
    (px, qx, cx), (py, qy, cy) = overlapping(rng), overlapping(rng)
    p_along, q_along = rng.choice(("y", "y", "x")), rng.choice("xy")
    swap_names = p_along == "x"
    if swap_names:  # told for rulings of P along y
        p_along, q_along = "y", "yx"["xy".index(q_along)]
    over = (max(py[0], qy[0]), min(py[1], qy[1]))
    top, bottom, _ = shapes.bump(rng, cx, px)
    side_top, side_bottom, side_most = shapes.bump(rng, cy, over, q_along == "x")
    h = height(rng, rng.choice((1, 2)))
    plain = [F(0)] * 4
    if q_along == "x":
        p = shapes.graph(rng, "y", px, py, plain, (top, bottom))
        q = shapes.graph(rng, "x", qx, qy, plain, ([-c for c in side_top], side_bottom))
    else:
        low = [side_top[0], F(0), side_top[1] if len(side_top) > 1 else F(0), F(0)]
        p = shapes.graph(rng, "y", px, py, low, (top, bottom))
        q = shapes.graph(rng, "y", qx, qy, plain, ([F(0)], [F(1)]))
    p = replace(p, lift=(UP, h), as_lists=False)
    if p.u is None:
        return conditions(rng)
    places, truths = [], []
    for _ in range(6):
        u = p.u[0] + (p.u[1] - p.u[0]) * rng.choice((F(0), F(1), F(1, 2), F(1, 3), F(rng.randint(0, 8), 8)))
        t = rng.choice((*MOMENTS, F(rng.randint(-8, 8), 4)))
        x = p.exact_point(u, F(0))[0]
        gap = value(top, x) / value(bottom, x) + value(h, t)
        truths.append(qx[0] <= x <= qx[1] and -side_most <= gap <= 0)
        places.append(f"({_quoted(u)}, {_quoted(t)})")
    frame = random_frame(rng, False, wild=False)
    source = (f"a = {p.mapped(frame).text()}\nb = {_plain(q).mapped(frame).text()}\nspan = (-1, 2)\n")

    def judge(answer: object) -> str | None:
        told = list(answer)  # type: ignore[call-overload]
        return None if told == truths else f"holds at {', '.join(places)}: {told}, not {truths}"

    call = f"[c.holds(*x) for c in [fc.contact_condition(a, b)] for x in [{', '.join(places)}]]"
    return Scene(source, "deforming", (Question(call, judge),))


def _quoted(x: F) -> str:
    return f'"{x}"'


KINDS: tuple[Kind, ...] = (
    Kind("ruled/flat pieces", "ruled, ruled or facet", flat_flat,
         "times and intervals of corners on corners, sides on sides, sliding in one plane, any speed of the parameters",
         "curved pieces; motions that are no translations"),
    Kind("ruled/flat piece on a convex solid", "ruled, polyhedron or box", flat_solid,
         "times, intervals and `initial` on corners and edges of solids, inside them, at the start",
         "curved pieces; motions that are no translations"),
    Kind("ruled/graphs", "ruled, ruled", graphs,
         "grazes at a point or along a ruling, isolated instants, lasting contact, borders over borders, ranges",
         "relative turns"),
    Kind("ruled/tips", "ruled, ruled", lambda rng: tips(rng, False),
         "apexes, corners, ridges and edges that meet at one point, under screws and turns too; near misses",
         "contact that begins elsewhere than at the lowest point"),
    Kind("ruled/tips on solids", "ruled, solid", lambda rng: tips(rng, True),
         "the same on poles, rims, apexes, edges and corners of solids and meshes", "as above"),
    Kind("ruled/landing", "ruled, any", landing,
         "the time at which a turn or screw, alone or in steps, brings corners down", "what happens after it"),
    Kind("ruled/pipes", "ruled, ruled", lambda rng: pipes(rng, False),
         "whole circles (u = None) that touch from outside and inside, and flat strips", "curves of other degrees"),
    Kind("ruled/pipes and solids", "ruled, cylinder or tube", lambda rng: pipes(rng, True),
         "rims, sides, bores, starts inside", "surfaces that are not upright"),
    Kind("ruled/balls", "ruled, sphere", balls,
         "faces, sides and corners of flat pieces on a ball, grazes, `initial`", "curved pieces"),
    Kind("ruled/trimmed disc", "ruled, ruled", discs, "the rim of a trimmed piece", "inequalities of other degrees"),
    Kind("ruled/witness", "ruled, ruled", lambda rng: witnesses(rng, "piece"),
         "late and missing contacts of any pieces under any motion, and points off the bodies",
         "contacts told too late that a later witness covers"),
    Kind("ruled/witness on solids", "ruled, solid", lambda rng: witnesses(rng, "solid"), "the same", "the same"),
    Kind("ruled/witness on meshes", "ruled, polyhedron", lambda rng: witnesses(rng, "mesh"), "the same", "the same"),
    *(Kind(f"ruled/{name}, deforming", bodies, make, "the same for surfaces that deform with the time",
           "deforming other than by a shift; the laws of motions", laws=False)
      for name, bodies, make in (
          ("graphs", "ruled, ruled", lambda rng: graphs(rng, True)),
          ("tips", "ruled, ruled", lambda rng: tips(rng, False, True)),
          ("tips on solids", "ruled, solid", lambda rng: tips(rng, True, True)),
          ("witness", "ruled, ruled", lambda rng: witnesses(rng, rng.choice(("piece", "solid", "mesh")), True)))),
    Kind("ruled/condition", "ruled, ruled", conditions, "`contact_condition(...).holds` on borders and beyond ranges",
         "the text of the condition", laws=False),
)
