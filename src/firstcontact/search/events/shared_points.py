"""Proof that two models share a point at a time: one inside both, by signs of all surfaces in ball arithmetic.

The point is found from an event: Newton's method makes time and place of the event precise, and a step of the size of
the overlap shortly after leads inside both models.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import inside
from firstcontact.body.solid.features import Edge, Face, Vertex, enclosure
from firstcontact.exact.numbers import ball, dyadic, exact_value, precision, to_double
from firstcontact.exact.rigid import Matrix, compose, inverse_map
from firstcontact.exact.vectors import cross, det
from firstcontact.kernels.events.event_search import CHART, FORM, OTHER_FORM, PAIR
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.stretches import known_steps, step_near
from firstcontact.motion.steps import REST
from firstcontact.search.convex.advance import Advance, Feature
from firstcontact.search.convex.convex import covering_pieces
from firstcontact.search.events.event_tables import Tables, crossing_surfaces
from firstcontact.search.events.instants import NEAR, PlacedForms

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.solid.carriers import Plane, Quadric

BITS = 256
TRIED = 8
"""Pairs of features that survive the search at a contact, for which it is made precise."""
RANKS = {Vertex: 0, Edge: 1, Face: 2}


@dataclass(frozen=True)
class SharedContact:
    """time: of the event, rounded; proved_at: a time at which a common point is proved; point, normal: in the world.

    frames: as `search.convex.advance.Advance` has them.
    """

    time: float
    proved_at: float
    point: np.ndarray
    normal: np.ndarray | None
    features_a: tuple[Feature, ...]
    features_b: tuple[Feature, ...]
    frames: list[list[float]]


def ball_pose(body: Body, t: fmpq) -> Matrix:
    """The pose at t as (3, 4) balls, at the present precision; the first and the last step go on beyond the motion."""
    motion = body.motion if isinstance(body, Moving) else REST
    rows = step_near(known_steps(motion), t).pose(t).matrix()
    return tuple(tuple(ball(x) for x in row) for row in rows)  # type: ignore[return-value]


def shared_point(
    bodies: tuple[Body, Body], instant: PlacedForms, boxes: np.ndarray, lo: float, hi: float, width: float, last: fmpq
) -> SharedContact | None:
    """A common point at a time within `width` after lo and not after `last`, from boxes that survive [lo, hi]."""
    latest = lo + 0.98 * width
    for in_doubles in (True, False):
        with precision(BITS):
            for event in _all_events(bodies, instant, boxes, lo, latest, in_doubles):
                for at in _times(max(event.time, lo), hi, width, latest, in_doubles):
                    if not lo <= at <= latest or exact_value(at) > last:
                        continue
                    if _shares(instant, event, at) if in_doubles else _proved(event, at):
                        return event.answer(instant, at)
    return None


def proved_at(
    bodies: tuple[Body, Body], instant: PlacedForms, covers: Advance, times: Sequence[float], last: fmpq
) -> float | None:
    """The first of the times, none after `last`, at which a contact of pieces that cover the models is proved theirs.

    A point near it is proved common, and no surface passes there but those of the features that it names.
    """
    models: list[Any] = [shape_of(x) for x in bodies]
    units = instant.tables.units[0]
    named = [
        {k for kind, index in features for k in _feature(model, kind, index).surfaces}
        for model, features in zip(models, (covers.features_a, covers.features_b), strict=True)
    ]
    for at in times:
        if exact_value(at) > last or not instant.place(at, at):
            continue
        forms = instant.forms_at(0, (_local(instant.poses()[0], np.asarray(covers.point)) - units[:3]) / units[3])
        if list(forms.near()) != named:
            return None
        if instant.shares_point_near(forms, (models[0].tree, models[1].tree)):
            return at
    return None


def without_corners(model: CompositeQuadric, features: tuple[Feature, ...]) -> tuple[Feature, ...]:
    """The features with vertices of the model, if any, for corners of pieces that cover it: those nearest."""
    found = []
    for kind, index in features:
        if kind == "corner":
            if not model.vertices:
                continue
            where = covering_pieces(model).array[index, :3]
            kind = "vertex"
            index = min(model.vertices, key=lambda v: float(np.abs(np.array(v.position) - where).max())).index
        found.append((kind, index))
    return tuple(found)


def _feature(model: CompositeQuadric, kind: str, index: int) -> Face | Edge | Vertex:
    features: Any = {"face": model.faces, "edge": model.edges}.get(kind, model.vertices)
    return next(x for x in features if x.index == index)


def _times(event: float, hi: float, width: float, latest: float, in_doubles: bool) -> list[float]:
    """When to look for a common point: balls prove one at once, doubles where it is deeper than their errors."""
    if in_doubles:
        return [min(event + 0.1 * width, latest), latest]
    soon = math.nextafter(math.nextafter(event, math.inf), math.inf)
    return [soon, min(max(soon, hi) + 0.05 * width, latest), latest]


def _shares(instant: PlacedForms, event: SharedEvent, at: float) -> bool:
    own, other = event.models()
    if not instant.place(at, at):
        return False
    return instant.shares_point_near(instant.forms_at(event.side, event.local), (own.tree, other.tree))


@dataclass
class SharedEvent:
    """own: the body whose feature is parametrised; x: the event's place in its frame, local: in its units."""

    bodies: tuple[Body, Body]
    side: int
    own: Face | Edge | Vertex
    other: Face | Edge | Vertex
    x: list[fmpq]
    local: np.ndarray
    time: float

    def models(self) -> tuple[CompositeQuadric, CompositeQuadric]:
        """The own one, the other one."""
        both: list[Any] = [shape_of(x) for x in self.bodies]
        return both[self.side], both[1 - self.side]

    def relative(self, t: fmpq) -> Matrix:
        """From the own model's frame to the other one's."""
        own, other = self.bodies[self.side], self.bodies[1 - self.side]
        if not isinstance(other, Moving):
            return ball_pose(own, t)
        back = inverse_map(ball_pose(other, t))
        return compose(back, ball_pose(own, t)) if isinstance(own, Moving) else back

    def answer(self, instant: PlacedForms, at: float) -> SharedContact:
        instant.place(self.time, self.time)
        poses = instant.poses()
        rows = poses[self.side]
        frames = [[*pose[:, :3].ravel().tolist(), *pose[:, 3].tolist()] for pose in poses]
        inverses = [[*np.linalg.inv(pose[:, :3]).ravel().tolist(), 0.0, 0.0, 0.0] for pose in poses]
        where = rows[:, :3] @ np.array([to_double(c) for c in self.x]) + rows[:, 3]
        where[np.abs(where) < 2.0**-50 * np.abs(where).max()] = 0.0  # what rounding leaves of a zero
        own, other = (_named(self.own),), (_named(self.other),)
        return SharedContact(
            min(self.time, at), at, where, self._normal(where, rows, poses[1 - self.side]),
            *((own, other) if self.side == 0 else (other, own)), [*frames, [], [], *inverses],
        )  # fmt: skip

    def _normal(self, where: np.ndarray, mine: np.ndarray, theirs: np.ndarray) -> np.ndarray | None:
        """Unit, in the world, from b towards a; poses of the own and the other model."""
        outward = [
            [n @ np.linalg.inv(pose[:, :3]) for n in _outward(model, feature, _local(pose, where))]
            for model, feature, pose in zip(self.models(), (self.own, self.other), (mine, theirs), strict=True)
        ]
        if isinstance(self.other, Face):
            n = outward[1][0]
        elif len(outward[0]) < 2 or len(outward[1]) < 2:
            return None
        else:
            n = np.array(cross(*(cross(first.tolist(), second.tolist()) for first, second, *_ in outward)))
            n = n * np.sign(float(n @ (outward[1][0] + outward[1][1] - outward[0][0] - outward[0][1])))
        length = float(np.linalg.norm(n)) * (1 if self.side == 0 else -1)
        return n / length if length else None


def _local(pose: np.ndarray, where: np.ndarray) -> np.ndarray:
    return np.linalg.solve(pose[:, :3], where - pose[:, 3])


def _named(feature: Face | Edge | Vertex) -> Feature:
    return type(feature).__name__.lower(), feature.index


def _outward(body: CompositeQuadric, feature: Face | Edge | Vertex, x: np.ndarray) -> list[np.ndarray]:
    """Outward unit normals at x of the feature, or of the faces beside it."""
    faces = [feature] if isinstance(feature, Face) else [body.faces[k] for k in getattr(feature, "faces", ())]
    return [face.orientation * body.gradient(face.surfaces[0], x) for face in faces]


# -- the event, precise -------------------------------------------------------------------------------------


def events_in(
    bodies: tuple[Body, Body], instant: PlacedForms, boxes: np.ndarray, earliest: float, latest: float
) -> list[SharedEvent]:
    """The events in boxes that survive the search, precise in doubles where they can be, the earliest first."""
    with precision(BITS):
        return _all_events(bodies, instant, boxes, earliest, latest, True)


def _all_events(
    bodies: tuple[Body, Body], instant: PlacedForms, boxes: np.ndarray, earliest: float, latest: float, in_doubles: bool
) -> list[SharedEvent]:
    """The events in the boxes, the earliest first, those at one time by their features; they may be that much later
    than the boxes."""
    tables = instant.tables
    found: list[SharedEvent] = []
    seen: dict[tuple[int, int], np.ndarray] = {}
    for box in boxes:
        if box[PAIR] >= 0:
            seen.setdefault((int(tables.info[int(box[CHART]), 0]), int(box[PAIR])), box)
    ordered = sorted(seen.values(), key=lambda box: _rank(tables, box))
    same = 0.03 * (latest - earliest)  # times that close are one as far as doubles tell
    for box in ordered[:TRIED]:
        event = _event(bodies, tables, box)
        precise = instant.refined(box) if in_doubles else None
        if precise is not None and earliest <= precise[2] <= latest:
            event = _event(bodies, tables, np.insert(box[:2], 2, precise[[0, 0, 1, 1, 2, 2]]))
            if event.time <= earliest + same:  # none of those that follow comes before it
                found.append(event)
                break
        elif not _refine(event, tables, box) or not earliest <= event.time <= latest:
            event = _event(bodies, tables, box)
        found.append(event)
    first = min((event.time for event in found), default=0.0)
    return sorted(found, key=lambda event: event.time if event.time > first + same else first)


def _rank(tables: Tables, box: np.ndarray) -> tuple[int, ...]:
    own, other = tables.features[int(box[CHART])], tables.others[int(box[PAIR])]
    first, second = (own, other) if tables.info[int(box[CHART]), 0] == 0 else (other, own)
    return RANKS[type(first)], first.index, RANKS[type(second)], second.index


def _event(bodies: tuple[Body, Body], tables: Tables, box: np.ndarray) -> SharedEvent:
    chart = int(box[CHART])
    side = int(tables.info[chart, 0])
    u, v = box[2], box[4]
    x = np.array([1.0, u, v, u * u, u * v, v * v]) @ tables.charts[chart, :24].reshape(6, 4)
    own = tables.features[chart]
    local = x[:3] / x[3]
    place = tables.units[side, :3] + tables.units[side, 3] * local
    where = [exact_value(c) for c in place]
    if isinstance(own, Vertex):
        where = [dyadic(arb(c.mid())) for c in enclosure(own.carrier)]
    return SharedEvent(bodies, side, own, tables.others[int(box[PAIR])], where, local, float(0.5 * (box[6] + box[7])))


def _refine(event: SharedEvent, tables: Tables, box: np.ndarray) -> bool:
    """Newton's steps with one approximate Jacobian, residuals in balls; nothing is proved here."""
    own, other = event.models()
    pair = tables.pairs[int(box[PAIR])]
    theirs = [int(pair[k]) for k in (FORM, OTHER_FORM) if pair[k] >= 0]
    if isinstance(event.own, Vertex):
        mine = []
    elif isinstance(event.own, Edge):
        mine = crossing_surfaces(own, event.own)
    else:
        mine = [event.own.surfaces[0]]
    system = _System([_scaled(own.surfaces[k]) for k in mine], [_scaled(other.surfaces[k]) for k in theirs])
    t, x = exact_value(event.time), event.x
    step = fmpq(1, 2**40)
    before, after = (event.relative(t + s) for s in (-step, step))
    m = middles(event.relative(t))
    rates = middles([[(y - x) / (2 * step) for x, y in zip(*rows, strict=True)]
                      for rows in zip(before, after, strict=True)])  # fmt: skip
    z = np.array([to_double(c) for c in x])
    system.across = _across(system, z)
    count = 0 if isinstance(event.own, Vertex) else 3
    size = to_double(exact_value(float(tables.units[event.side, 3]))) * 1e-4
    moves = [size * e for e in np.eye(3)[:count]]
    columns = [(system.values(z + d, m) - system.values(z - d, m)) / (2 * size) for d in moves]
    span = size / max(float(np.abs(rates).max()), 1e-300)
    columns.append((system.values(z, m + span * rates) - system.values(z, m - span * rates)) / (2 * span))
    jacobian = np.array(columns, float).T
    scale = np.abs(jacobian).max(axis=1, keepdims=True)
    if jacobian.shape[0] != jacobian.shape[1] or not np.all(scale > 0) or not np.all(np.isfinite(jacobian)):
        return False
    if not np.linalg.cond(jacobian / scale, 1) <= 1e12:  # in this norm it takes no singular values
        return False
    for _ in range(3):
        residual = system.values([arb(c) for c in x], event.relative(t))
        largest = max(float(abs(r).upper()) for r in residual) or 1.0
        shift = np.linalg.solve(jacobian, [float((r / largest).mid()) for r in residual])
        moved = [dyadic((arb(exact_value(d)) * arb(largest)).mid()) for d in shift]
        x = [c - d for c, d in zip(x, moved[:count], strict=True)] if count else x
        t = t - moved[-1]
        if not math.isfinite(largest) or abs(to_double(t) - event.time) > 1e-6 * (1 + abs(event.time)):
            return False
    event.x, event.time = [_shortened(c) for c in x], to_double(t)
    return True


def _shortened(x: fmpq) -> fmpq:
    return fmpq((x * 2**200).floor()) / 2**200


def middles(m: Sequence[Sequence[arb]]) -> np.ndarray:
    return np.array([[float(c.mid()) for c in row] for row in m])


class _System:
    """The equations of an event in any numbers: forms of the own model, and of the other one, which is under a map."""

    def __init__(self, mine: list[list[list[fmpq]]], theirs: list[list[list[fmpq]]]) -> None:
        self.mine, self.theirs = mine, theirs
        self.doubles = [[_doubles(m) for m in forms] for forms in (mine, theirs)]
        self.balls = [[[[arb(c) for c in row] for row in m] for m in forms] for forms in (mine, theirs)]
        self.across: np.ndarray | None = None

    def values(self, x: Any, m: Any) -> Any:
        exact = not isinstance(x, np.ndarray)
        mine, theirs = self.balls if exact else self.doubles
        y = mapped(m, x)
        found, gradients = [], []
        for forms, at in ((mine, x), (theirs, y)):
            a, b, c = at
            for form in forms:
                p, q, r, s = mapped(form, at)
                found.append(a * p + b * q + c * r + s)
                g = [p, q, r]
                if forms is theirs:
                    g = [m[0][j] * p + m[1][j] * q + m[2][j] * r for j in range(3)]
                gradients.append(g)
        if len(mine) == 2 and len(theirs) == 1:
            found.append(det(*gradients))
        elif len(mine) == 1:
            assert self.across is not None
            found += [det([float(c) for c in row] if not exact else [arb(float(c)) for c in row], *gradients)
                      for row in self.across]  # fmt: skip
        return found if exact else np.array(found)


def _across(system: _System, x: np.ndarray) -> np.ndarray | None:
    """Two directions across the gradient of a face's surface."""
    if len(system.mine) != 1:
        return None
    n = (system.doubles[0][0] @ np.append(x, 1.0))[:3]
    k = int(np.argmin(np.abs(n)))
    first = np.cross(n, np.eye(3)[k])
    first /= np.linalg.norm(first)
    second = np.cross(n, first)
    return np.array([first, second / np.linalg.norm(second)])


def _scaled(surface: Plane | Quadric) -> list[list[fmpq]]:
    """The form, its largest entry 1."""
    largest = max(abs(c) for row in surface.matrix() for c in row)
    return [[c / largest for c in row] for row in surface.matrix()]


def _doubles(form: Sequence[Sequence[fmpq]]) -> np.ndarray:
    return np.array([[to_double(c) for c in row] for row in form])


# -- the proof ----------------------------------------------------------------------------------------------


def _proved(event: SharedEvent, at: float) -> bool:
    """Whether a point near the event is proved inside both models at that time."""
    m = event.relative(exact_value(at))
    own, other = event.models()
    values, gradients, forms = _second_order(own, other, event.x, m)
    size = NEAR * float(np.abs(np.diff(own.bounds(), axis=0)).max())
    lengths, bends = np.linalg.norm(gradients, axis=1), np.abs(forms).max(axis=(1, 2))
    near = np.abs(values) < size * (lengths + size * bends)
    if not near.any():
        return _is_inside(own, other, event.x, m)
    regular = near & (lengths > size * bends)
    scale = max(float(np.abs(values[regular] / lengths[regular]).max(initial=0.0)), 1e-40)
    steps = scale * _directions(gradients[regular] / lengths[regular, None])
    bent = ((steps @ forms[near]) * steps).sum(axis=2).T
    moved = values[near] + steps @ gradients[near].T + bent
    negative: list[Any] = list(np.repeat(values[:, None] < 0, len(steps), axis=1))
    for k, column in zip(np.flatnonzero(near), moved.T, strict=True):
        negative[k] = column < 0
    n = len(own.surfaces)
    held = inside(own.tree, negative[:n]) & inside(other.tree, negative[n:])
    if not np.any(held):
        return False
    far = np.linalg.norm(steps, axis=1)[:, None]
    slopes = far * (lengths[near] + far * bends[near]) + 1e-300
    depth = np.where(held, (np.abs(moved) / slopes).min(axis=1), -1.0)
    best = steps[int(np.argmax(depth))]
    return _is_inside(own, other, [c + exact_value(d) for c, d in zip(event.x, best, strict=True)], m)


def _directions(units: np.ndarray) -> np.ndarray:
    """(n, 3) steps in the unit of the overlap: fixed ones of many directions and lengths, and against the surfaces."""
    rng = np.random.default_rng(0)
    d = rng.normal(size=(500, 3))
    signs = rng.choice([-1.0, 0.0, 1.0], size=(100, len(units)))
    d = np.concatenate([d, signs @ units])
    lengths = np.linalg.norm(d, axis=1, keepdims=True)
    d = (d / np.maximum(lengths, 1e-300))[lengths[:, 0] > 1e-9]  # none that stays: its signs would be rounding errors
    return np.concatenate([r * d for r in (0.1, 0.3, 0.5, 0.8, 1.5, 4.0)])


def _second_order(
    own: CompositeQuadric, other: CompositeQuadric, x: list[fmpq], m: Matrix
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values (n,), gradients (n, 3) and second derivatives (n, 3, 3), halved, of all surfaces, in the own frame."""
    values, gradients, forms = [], [], []
    point = [*(arb(c) for c in x), arb(1)]
    there = [*mapped(m, point), arb(1)]
    turn = middles(m)[:, :3]
    for model, at, back in ((own, point, np.eye(3)), (other, there, turn)):
        for surface, form in zip(model.surfaces, model.forms, strict=True):
            largest = arb(max(abs(c) for row in surface.matrix() for c in row))
            values.append(float((surface.value(at) / largest).mid()))
            gradients.append(back.T @ [float((arb(c) / largest).mid()) for c in surface.gradient(at)])
            forms.append(back.T @ form[:3, :3] @ back)
    return np.array(values), np.array(gradients), np.array(forms)


def mapped(m: Any, x: Sequence[Any]) -> list[Any]:
    return [row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3] for row in m]


def _is_inside(own: CompositeQuadric, other: CompositeQuadric, x: list[fmpq], m: Matrix) -> bool:
    """Whether all signs are certain and put the point inside both."""
    point = [*(arb(c) for c in x), arb(1)]
    for model, at in ((own, point), (other, [*mapped(m, point), arb(1)])):
        negative = []
        for surface in model.surfaces:
            value = surface.value(at)
            if not (value > 0 or value < 0):
                return False
            negative.append(bool(value < 0))
        if not inside(model.tree, negative):
            return False
    return True
