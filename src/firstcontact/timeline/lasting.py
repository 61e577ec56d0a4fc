"""Proof that contact lasts: a point fixed in one of two moving bodies stays inside both over a stretch of time.

The point is sought in doubles, deep inside both bodies.  Let x, y be its places in its own model and in the other one
at a time t, A, B their poses, R the linear part of B.  At a time s it has moved by R(s)^-1 (A'(r) x - B'(r) y) (s - t)
in the other body, each row at some r between (mean values).  Ball arithmetic over enclosures of poses and speeds puts
all these places inside the other body, or proves nothing.  The time passed, s - t, stays one number from 0 on in this:
a form that falls along the way is known to fall, however far that leads, until what bends the way or the surface is
more than that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, product
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.carriers import Quadric
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import And, Leaf, Not, Tree, possible
from firstcontact.exact.numbers import precision, to_double
from firstcontact.exact.rigid import inverse_map, to_origin
from firstcontact.exact.vectors import dot
from firstcontact.kernels.poses import accelerations, pose_at
from firstcontact.kernels.workspace import HERE_A, SPEED, SPREAD, workspace
from firstcontact.motion.relative.stretches import Window

if TYPE_CHECKING:
    from firstcontact.exact.vectors import Vector

BITS = 128
ROUNDS = 20
"""Of the search for a deeper point."""
SAMPLES = 2000
"""Points of either model's box among which a common one is sought where nothing is known."""
MOST_STEPS = 300
"""Of one proof of lasting contact."""
SIGNS = np.array([x for x in product((-1.0, 0.0, 1.0), repeat=3) if any(x)])
GROWTH, SHRINKAGE = 2.0, 0.25
TIP, TIP_DEPTHS = 1e-3, 20
"""Parts of its coordinates as near as which a point is about an apex, and how often a quarter of that is tried."""
INSIDE = 1e-9
"""Of its coordinates: an apex that doubles take for one that is no farther outside a body is asked for exactly."""


P = TypeVar("P")
Pose = tuple[np.ndarray, np.ndarray]
"""Linear part (3, 3) and shift (3,)."""


class LastingTip(NamedTuple):
    """The apex of a model's cone, exact, and the unit way along its axis; owned: whether the model holds it."""

    point: Vector
    way: np.ndarray
    owned: bool

    @property
    def place(self) -> np.ndarray:
        return np.array([to_double(x) for x in self.point])


class OwnTip(NamedTuple):
    """As a common point: an apex that body `side` holds at all times, so that only the other one has to be asked."""

    side: int
    tip: LastingTip


class Drift(NamedTuple):
    """Where a point of one body comes to in the frame of the other one, from a point x near it: by offset + passed
    rate, where the time passed goes from 0 to the length of a stretch.
    """

    offset: list[arb]
    rate: list[arb]
    length: arb

    @property
    def moved(self) -> list[arb]:
        passed = arb(0).union(self.length)
        return [v + passed * w for v, w in zip(self.offset, self.rate, strict=True)]

    def on_form(self, m: Sequence[Sequence[arb]], image: Sequence[arb], value: arb) -> tuple[arb, arb, arb]:
        """A quadratic form there, by powers of the time passed; image, value: M x and x^T M x."""
        off, rate = ([dot(row, x) for row in m[:3]] for x in (self.offset, self.rate))
        constant = value + 2 * dot(image, self.offset) + dot(self.offset, off)
        return constant, 2 * (dot(image, self.rate) + dot(self.rate, off)), dot(self.rate, rate)


class LastingSolid:
    """A model as the proof reads it: its forms exact, and in doubles.

    centres: (n, 3) the points about which the latter are told, where little cancels: apexes of cones, else its middle.
    """

    own = np.eye(4)
    """Where it stands, as `placed` tells it."""

    def __init__(self, model: CompositeQuadric) -> None:
        self.model = model
        with precision(BITS):
            self.exact = [[[arb(c) for c in row] for row in s.matrix()] for s in model.surfaces]
        self.centres, self.forms = _about_centres(model)
        self.bends = np.linalg.norm(self.forms[:, :3, :3], axis=(1, 2))
        cones = [x for x in model.surfaces if isinstance(x, Quadric) and x.apex is not None]
        self.tips = [_tip(x, model) for x in cones]

    def holds(self, x: Sequence[arb], drift: Drift | None = None) -> bool:
        """Whether the model holds x (in its frame), and all points to which that drifts."""
        below, above = [], []
        for m in self.exact:
            image = [row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3] for row in m]
            value = x[0] * image[0] + x[1] * image[1] + x[2] * image[2] + image[3]
            if drift is None:
                below.append(not value > 0)
                above.append(not value < 0)
            else:
                c, b, a = drift.on_form(m, image, value)
                below.append(not is_negative(-c, -b, -a, drift.length))
                above.append(not is_negative(c, b, a, drift.length))
        return not possible(self.model.tree, below, above)[1]

    def placed(self, linear: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """The map (4, 4) to its own frame from that in which a point x of the model is at linear x + shift."""
        back = np.eye(4)
        back[:3, :3] = np.linalg.inv(linear)
        back[:3, 3] = -back[:3, :3] @ shift
        return back

    def height(self, back: np.ndarray, centre: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """(n,) about how far the points centre + steps (n, 3) are from inside, negative inside; back: as placed."""
        turned = steps @ back[:3, :3].T
        value, slopes = self._at(back, centre)
        turns = turned @ self.forms[:, :3, :3]
        values = value[:, None] + 2.0 * slopes @ turned.T + np.einsum("sni,ni->sn", turns, turned)
        return tree_height(self.model.tree, values / self._scale(values, slopes[:, None] + turns))

    def slopes(self, back: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) about how far the point is from each surface, and (n, 3) directions in which that grows."""
        value, slopes = self._at(back, point)
        scale = self._scale(value[:, None], slopes[:, None])
        return value / scale[:, 0], slopes / scale @ back[:3, :3]

    def values(self, back: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(n, m) of each surface at m homogeneous points, about how far they are from it."""
        x = np.ones((len(self.forms), len(points), 4))
        x[:, :, :3] = (points @ back.T)[:, :3] - self.centres[:, None]
        image = x @ self.forms
        values = (image * x).sum(axis=2)
        found: np.ndarray = values / self._scale(values, image[:, :, :3])
        return found

    def _at(self, back: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of each surface, in the model's frame: value and half the gradient at a point."""
        x = back[:3, :3] @ point + back[:3, 3] - self.centres
        slopes = np.einsum("sij,sj->si", self.forms[:, :3, :3], x) + self.forms[:, :3, 3]
        value: np.ndarray = ((slopes + self.forms[:, :3, 3]) * x).sum(axis=1) + self.forms[:, 3, 3]
        return value, slopes

    def _scale(self, values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """(n, m) what values of forms are over distances: v = 2 g d + a d^2 for half the gradient g and the bend a,
        which holds next to tips too, where g is next to nothing."""
        square = (slopes * slopes).sum(axis=2)
        found: np.ndarray = np.sqrt(square) + np.sqrt(square + self.bends[:, None] * np.abs(values)) + 1e-300
        return found

    def samples(self) -> np.ndarray:
        """(n, 3) points of its box, none where that is unbounded."""
        lo, hi = self.model.bounds()
        if not np.all(np.isfinite([lo, hi])):
            return np.zeros((0, 3))
        return lo + np.random.default_rng(0).uniform(size=(SAMPLES, 3)) * (hi - lo)


class Lasting(Generic[P]):
    """How contact of two bodies is followed; all points are in world coordinates, all times are those of a window.

    P: a point that is proved to be in both bodies at a time, and so that it can be followed.
    """

    worth: ClassVar[int] = 1
    """What following a point for a step takes, in cells that other searches look at meanwhile."""

    def __init__(self) -> None:
        self.scratch = workspace()[0]

    def held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> P | None:
        """A point proved inside both bodies at t, about as deep as can be near one of the seeds."""
        raise NotImplementedError

    def each_held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> Iterator[P]:
        """Such points, of which another one may be followed farther than the first."""
        found = self.held(window, t, seeds)
        if found is not None:
            yield found

    def at_hand(self, window: Window, t: float, place: np.ndarray) -> Iterator[P]:
        """The point at that place as it is, if that can be followed: no search for a deeper one, which takes longer."""
        return iter(())

    def follow(self, window: Window, t: float, end: float, point: P) -> np.ndarray | None:
        """Where the point comes to, if it is proved to be in both bodies over [t, end]."""
        raise NotImplementedError

    def place(self, window: Window, t: float, point: P) -> np.ndarray:
        raise NotImplementedError

    def anywhere(self, window: Window, t: float) -> np.ndarray | None:
        """A point proved inside both bodies at t, where none is known."""
        raise NotImplementedError

    def in_world(self, window: Window, t: float, point: np.ndarray) -> np.ndarray:
        """Where a point that `deepest` or `anywhere` tells is, rounded."""
        return point

    def deepest(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> np.ndarray | None:
        """The place of the point that `held` finds."""
        found = self.held(window, t, seeds)
        return None if found is None else self.place(window, t, found)

    def kept(self, window: Window, t: float, place: np.ndarray) -> np.ndarray | None:
        """The place itself where that can be followed, else as `deepest`."""
        if next(self.at_hand(window, t, place), None) is not None:
            return place
        return self.deepest(window, t, [place])

    def until(
        self, window: Window, t: float, end: float, point: np.ndarray, least: float, step: Callable[[], None]
    ) -> tuple[float, np.ndarray]:
        """(a time up to `end` with proved contact from t on, t itself where none is proved; a common point near then).

        point: a common point at t, or near one.  least: part of the longest proved step below which it gives up.
        step: called before every step.
        """
        length, longest = end - t, 0.0
        for _ in range(MOST_STEPS):
            if t >= end:
                break
            step()
            known: list[P] = []
            more = chain(self.at_hand(window, t, point), self.each_held(window, t, [point]))
            length = min(length, end - t)
            while True:
                shortest = max(least * longest, 4.0 * (np.nextafter(abs(t), np.inf) - abs(t)))
                if known and length < shortest and length < end - t:
                    return t, self.place(window, t, known[0])
                later = end if length >= end - t else t + length
                followed = (self.follow(window, t, later, x) for x in _all(known, more))
                there = next((x for x in followed if x is not None), None)
                if there is not None:
                    break
                if not known:
                    return t, point
                if longest == 0.0 and length < 1e-18 * (end - t):
                    return t, self.place(window, t, known[0])
                length *= SHRINKAGE
            point = there
            longest, t, length = max(longest, later - t), later, GROWTH * length
        return t, point

    def drift(
        self, own: np.ndarray, other: np.ndarray, t: float, end: float, x: Sequence[arb], y: np.ndarray
    ) -> Drift:
        """How far from y a point x fixed in its own body is over [t, end], both in their bodies' frames."""
        p, q = self.pose(own, t), self.pose(other, t)
        p_speed, p_spread = self._speeds(own, t, end)
        q_speed, q_spread = self._speeds(other, t, end)
        z = [arb(c) for c in y.tolist()]
        length = arb(end) - arb(t)
        passed = arb(0).union(length)
        offset, rate = [], []
        for i in range(3):
            offset.append(_image(p, p[12], p[13], i, x) - _image(q, q[12], q[13], i, z))
            rate.append(_image(p_speed, p_spread, None, i, x) - _image(q_speed, q_spread, None, i, z))
        turned = [
            [arb(q[3 * i + j], q[12]) + passed * arb(q_speed[3 * i + j], q_spread[3 * i + j]) for j in range(3)]
            for i in range(3)
        ]
        back = inverse_map(tuple((*row, arb(0)) for row in turned))  # type: ignore[arg-type]
        return Drift([dot(row, offset) for row in back], [dot(row, rate) for row in back], length)

    def pose(self, m: np.ndarray, t: float) -> np.ndarray:
        """The fourteen numbers of a pose: linear part, shift, and their errors."""
        pose_at(m, t, self.scratch, HERE_A)
        return self.scratch[HERE_A].copy()

    def _speeds(self, m: np.ndarray, t: float, end: float) -> tuple[np.ndarray, np.ndarray]:
        accelerations(m, t, end, self.scratch)
        return self.scratch[SPEED].copy(), self.scratch[SPREAD].copy()


class LastingOfModels(Lasting["np.ndarray | OwnTip"]):
    """Two models: a world point, fixed in either of them, or the tip of a cone.

    Doubles tell little of points next to tips: there a cone's form falls with the square of the distance, below what
    rounding leaves of it.  The tip itself is exact and its body holds it, however sharp; of the other body it is a
    point like any.
    """

    def __init__(self, a: LastingSolid, b: LastingSolid) -> None:
        super().__init__()
        self.solids = a, b
        directions = np.random.default_rng(0).normal(size=(30, 3))
        self.directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)

    # -- the proof ------------------------------------------------------------------------------------------

    def follow(self, window: Window, t: float, end: float, point: np.ndarray | OwnTip) -> np.ndarray | None:
        if isinstance(point, OwnTip):
            return self.place(window, end, point) if self._tip_stays(window, t, end, point) else None
        for side in (0, 1):
            if self.stays(window, t, end, side, point):
                m = (window.a, window.b)[side]
                p, q = self.pose(m, t), self.pose(m, end)
                return linear(q) @ np.linalg.solve(linear(p), point - p[9:12]) + q[9:12]
        return None

    def at_hand(self, window: Window, t: float, place: np.ndarray) -> Iterator[np.ndarray | OwnTip]:
        if self.is_shared(window, t, place):
            yield place

    def place(self, window: Window, t: float, point: np.ndarray | OwnTip) -> np.ndarray:
        if not isinstance(point, OwnTip):
            return point
        p = self.pose((window.a, window.b)[point.side], t)
        place: np.ndarray = linear(p) @ point.tip.place + p[9:12]
        return place

    def is_shared(self, window: Window, t: float, point: np.ndarray) -> bool:
        """Whether the point is proved to be in both models at t: fixed in either, whichever loses less by rounding."""
        return any(self.stays(window, t, t, side, point) for side in (0, 1))

    def stays(self, window: Window, t: float, end: float, side: int, point: np.ndarray) -> bool:
        """Whether the point, fixed in model `side`, is proved to be in both models over [t, end]."""
        p = self.pose((window.a, window.b)[side], t)
        with precision(BITS):
            x = [arb(c) for c in np.linalg.solve(linear(p), point - p[9:12]).tolist()]
            return self.solids[side].holds(x) and self._other_holds(window, t, end, side, x)

    def _tip_stays(self, window: Window, t: float, end: float, point: OwnTip) -> bool:
        with precision(BITS):
            return self._other_holds(window, t, end, point.side, [arb(c) for c in point.tip.point])

    def _other_holds(self, window: Window, t: float, end: float, side: int, x: list[arb]) -> bool:
        """Whether the point x of model `side`, in its frame, is proved to be in the other one over [t, end]."""
        own, other = (window.a, window.b) if side == 0 else (window.b, window.a)
        p, q = self.pose(own, t), self.pose(other, t)
        place = linear(p) @ [float(c) for c in x] + p[9:12]
        y = np.linalg.solve(linear(q), place - q[9:12])
        return self.solids[1 - side].holds([arb(c) for c in y.tolist()], self.drift(own, other, t, end, x, y))

    # -- points ---------------------------------------------------------------------------------------------

    def anywhere(self, window: Window, t: float) -> np.ndarray | None:
        """From samples of their boxes."""
        return self.deepest(window, t, self._samples(self._poses(window, t)))

    def held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> np.ndarray | OwnTip | None:
        return next(self.each_held(window, t, seeds), None)

    def each_held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> Iterator[np.ndarray | OwnTip]:
        poses = self._poses(window, t)
        found = self._deep(self._placed(poses), seeds)
        deep = next((point for point in found if self.is_shared(window, t, point)), None)
        if deep is not None:
            yield deep
        yield from (tip for tip in self._tips(poses) if self._tip_stays(window, t, t, tip))
        yield from self._below_tips(window, t, seeds)

    def _tips(self, poses: list[Pose]) -> Iterator[OwnTip]:
        """Those that doubles do not take for outside the other model."""
        for side, (turned, shift) in enumerate(poses):
            owned = [tip for tip in self.solids[side].tips if tip.owned]
            if not owned:
                continue
            x = np.array([turned @ tip.place + shift for tip in owned])
            other = self.solids[1 - side]
            heights = other.height(other.placed(*poses[1 - side]), np.zeros(3), x)
            near = heights <= INSIDE * np.abs(x).max(axis=1)
            yield from (OwnTip(side, tip) for tip, here in zip(owned, near, strict=True) if here)

    def _below_tips(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
        """Points on axes of cones, half as far from their apexes as common points go: there doubles tell no depth."""
        for solid, (turned, shift) in zip(self.solids, self._poses(window, t), strict=True):
            for apex in solid.tips:
                tip, along = turned @ apex.place + shift, turned @ apex.way
                near = TIP * float(np.abs(tip).max() + np.linalg.norm(along))
                if min((float(np.abs(x - tip).max()) for x in seeds), default=np.inf) > near:
                    continue
                places = (tip + sign * near * 0.25**k * along for k in range(TIP_DEPTHS) for sign in (1.0, -1.0))
                deep = next((x for x in places if self.is_shared(window, t, x)), None)
                if deep is not None:
                    yield tip + 0.5 * (deep - tip)

    def rough(self, poses: Sequence[Pose], seeds: Sequence[np.ndarray]) -> np.ndarray | None:
        """A point that doubles take for one inside both models in these poses: below the best of seeds and samples."""
        maps = self._placed(poses)
        points = np.array([*seeds, *self._samples(poses)])
        if not len(points):
            return None
        best = int(np.argmin(self._height(maps, np.zeros(3), points)))
        return next(self._deep(maps, [points[best]]), None)

    def _samples(self, poses: Sequence[Pose]) -> list[np.ndarray]:
        """Points of the models' boxes in these poses, where both are deepest."""
        x = np.concatenate([
            solid.samples() @ turned.T + shift for solid, (turned, shift) in zip(self.solids, poses, strict=True)
        ])  # fmt: skip
        return list(x[np.argsort(self._height(self._placed(poses), np.zeros(3), x))[:4]])

    def _deep(self, maps: list[np.ndarray], seeds: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
        """Points that seem to be inside both models, deep below the seeds."""
        for seed in seeds:
            point, depth = descended(
                lambda x, steps: self._height(maps, x, steps), lambda x: self._directions(maps, x),
                np.asarray(seed, float),
            )  # fmt: skip
            if depth < 0.0:
                yield point

    def _directions(self, maps: list[np.ndarray], point: np.ndarray) -> np.ndarray:
        """(n, 3) unit: fixed ones, and across and away from the nearest surfaces."""
        told = [solid.slopes(back, point) for solid, back in zip(self.solids, maps, strict=True)]
        values, rows = (np.concatenate(parts) for parts in zip(*told, strict=True))
        near = np.argsort(np.abs(values))[:3]
        lengths = np.linalg.norm(rows[near], axis=1, keepdims=True)
        mixed = SIGNS[:, : len(near)] @ (rows[near] / np.maximum(lengths, 1e-300))
        even = SIGNS[:, : len(near)] @ np.linalg.pinv(rows[near], rcond=1e-9).T  # all alike: thin corners
        mixed = np.concatenate([mixed, even])
        lengths = np.linalg.norm(mixed, axis=1, keepdims=True)
        return np.concatenate([self.directions, mixed / np.maximum(lengths, 1e-300)])

    def _poses(self, window: Window, t: float) -> list[Pose]:
        poses = [self.pose(m, t) for m in (window.a, window.b)]
        return [(linear(pose), pose[9:12]) for pose in poses]

    def _placed(self, poses: Sequence[Pose]) -> list[np.ndarray]:
        """The maps to both models' frames in these poses."""
        return [s.placed(*pose) for s, pose in zip(self.solids, poses, strict=True)]

    def _height(self, maps: list[np.ndarray], centre: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """(n,) about how far the points centre + steps are from inside both models, negative inside."""
        return np.maximum(*(s.height(back, centre, steps) for s, back in zip(self.solids, maps, strict=True)))


def _all(known: list[P], more: Iterator[P]) -> Iterator[P]:
    """What is known, then what is to come, which is known then."""
    yield from tuple(known)
    for x in more:
        known.append(x)
        yield x


def descended(
    height_of: Callable[[np.ndarray, np.ndarray], np.ndarray], directions: Callable[[np.ndarray], np.ndarray],
    point: np.ndarray,
) -> tuple[np.ndarray, float]:
    """The point moved downhill by tries around it, and the height there.

    height_of: of (point, steps (n, k)) the heights (n,) at point + steps; directions: (m, k) steps worth a try.
    """
    height = float(height_of(point, np.zeros((1, len(point))))[0])
    size = abs(height) + float(np.abs(point).max()) + 1e-300
    around = directions(point)
    steps = size * np.concatenate([r * around for r in 0.5 ** np.arange(1.0, 54.0, 2.0)])
    heights = height_of(point, steps)
    best = int(np.argmin(heights))
    radius = 2.0 * abs(height)
    if heights[best] < height:
        radius = 2.0 * float(np.linalg.norm(steps[best]))
        point, height = point + steps[best], float(heights[best])
    for _ in range(ROUNDS):
        around = directions(point)
        steps = radius * np.concatenate([r * around for r in (0.1, 0.3, 0.6, 1.0)])
        heights = height_of(point, steps)
        best = int(np.argmin(heights))
        gain = height - float(heights[best])
        if gain > 0.0:
            point, height = point + steps[best], float(heights[best])
        radius *= 2.0 if gain > 0.03 * radius else 0.5
        if height < 0.0 and radius < -0.2 * height:
            break
    return point, height


def is_negative(constant: arb, first: arb, second: arb, length: arb) -> bool:
    """Whether constant + first s + second s^2 is proved negative for all s in [0, length], and all that may depend on
    s within these balls."""
    c, b, a = constant.upper(), first.upper(), second.upper()  # s is not negative: the form of these is above all
    if not (c < 0 and c + length * (b + length * a) < 0):
        return False
    if a >= 0 or b <= 0 or b + 2 * length * a >= 0:  # it is highest at an end
        return True
    return bool(b * b < 4 * a * c)


def linear(pose: np.ndarray) -> np.ndarray:
    return pose[:9].reshape(3, 3)


def _image(
    rows: np.ndarray, error: Any, shift_error: float | np.ndarray | None, i: int, x: Sequence[arb]
) -> arb:
    """Row i of R x + T; error: of all entries of R (shift_error: of T), or of each of the twelve."""
    if shift_error is None:
        r, e = [float(error[3 * i + j]) for j in range(3)], float(error[9 + i])
    else:
        r, e = [float(error)] * 3, float(shift_error)
    total = arb(float(rows[9 + i]), e)
    for j in range(3):
        total += arb(float(rows[3 * i + j]), r[j]) * x[j]
    return total


def tree_height(tree: Tree, values: np.ndarray) -> np.ndarray:
    if isinstance(tree, Leaf):
        return values[tree.surface]
    if isinstance(tree, Not):
        return -tree_height(tree.inner, values)
    first, second = tree_height(tree.first, values), tree_height(tree.second, values)
    return np.maximum(first, second) if isinstance(tree, And) else np.minimum(first, second)


def _tip(cone: Quadric, model: CompositeQuadric) -> LastingTip:
    """Its apex, and the unit way along which it goes deepest into the cone."""
    assert cone.apex is not None
    x, y, z = cone.apex[:3]
    form = np.array([[to_double(x) for x in row[:3]] for row in cone.form[:3]])
    return LastingTip((x, y, z), np.linalg.eigh(form)[1][:, 0], model.contains_exactly((x, y, z)))


def _about_centres(model: CompositeQuadric) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3), and forms (n, 4, 4) of the way from them."""
    by = (fmpq(0),) * 3
    if model.bounded:
        lo, hi = model.bounds()
        by = to_origin((0.5 * (lo + hi)).tolist(), float((hi - lo).max()))
    moved = model.translated(by) if any(by) else model
    forms, centres = moved.forms.copy(), np.tile([-to_double(x) for x in by], (len(moved.forms), 1))
    for k, surface in enumerate(model.surfaces):
        if isinstance(surface, Quadric) and surface.apex is not None:
            centres[k] = [to_double(x) for x in surface.apex[:3]]
            forms[k, 3] = forms[k, :, 3] = 0.0
    return centres, forms
