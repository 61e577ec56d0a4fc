"""What judges answers about robots: coal's distances in conservative steps, and its collisions at many times.

The steps take poses and speed bounds that the library works out; the samples take poses by yourdfpy, from joint values
by NumPy, so that they share nothing with it.
"""

from __future__ import annotations

import itertools
import math
import time
from pathlib import Path
from typing import Any

import numpy as np

import firstcontact as fc
from firstcontact.exact.numbers import to_double
from firstcontact.motion.relative.reach import line_of, places

TOLERANCE = 1e-9
STEPS = 1e-6, 1e-5, 1e-4
"""Before and after a contact, in the unit of time, that bodies are looked at: waypoints are 0.1 apart."""


class ByDistances:
    """coal's distance in conservative steps, and the speed bounds that these need, which the library works out."""

    def __init__(self, pairs: list[tuple[Any, Any]]) -> None:
        self.shapes = {body.name: shape(resting(body)) for pair in pairs for body in pair}
        self.speeds = {body.name: _speeds(body) for pair in pairs for body in pair}
        self.asked, self.inside = 0, 0.0

    def first(self, a: Any, b: Any) -> float | None:
        """The time of the first contact within the tolerance."""
        import coal

        motion = a.motion if hasattr(a, "motion") else b.motion
        times = [to_double(t) for t in motion.times]
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        for k, (t, last) in enumerate(itertools.pairwise(times)):
            speed = self.speeds[a.name][k] + self.speeds[b.name][k]
            while t <= last:
                places = [coal.Transform3s(p[:3, :3], p[:3, 3]) for p in (_pose(a, k, t), _pose(b, k, t))]
                result.clear()
                begin = time.process_time()
                gap = coal.distance(self.shapes[a.name], places[0], self.shapes[b.name], places[1], request, result)
                self.inside += time.process_time() - begin
                self.asked += 1
                if gap <= TOLERANCE:
                    return t
                t += gap / speed if speed else np.inf
        return None


def _pose(body: Any, k: int, t: float) -> np.ndarray:
    """In doubles, for coal's loop: the library's own rounds an enclosure."""
    pose = np.eye(4)
    if not hasattr(body, "motion"):
        return pose
    start, end = (to_double(x) for x in body.motion.times[k : k + 2])
    for drive in body.motion.drives:
        (c0, c1, _, _), step = drive.doubles[k], drive.motion
        if isinstance(step, fc.Rotation):
            turn = _turn(drive, c0 + c1 * (t - start) / (end - start))
        else:
            turn = step(c0 + c1 * (t - start) / (end - start))
        pose = pose @ turn
    return pose


def _turn(drive: Any, radians: float) -> np.ndarray:
    axis, point, rate, _ = line_of(drive.motion)
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    pose = np.eye(4)
    pose[:3, :3] += math.sin(rate * radians) * cross + (1 - math.cos(rate * radians)) * (cross @ cross)
    pose[:3, 3] = point - pose[:3, :3] @ point
    return pose


def _speeds(body: Any) -> np.ndarray:
    """A bound of the speed of all points of the body in each stretch of the clock."""
    if not hasattr(body, "motion"):
        return np.zeros(100_000)
    lo, hi = body.body.bounds()
    corners = np.array(list(itertools.product(*zip(lo, hi, strict=True))))
    _, far = places(body.motion, corners)
    length = np.diff([to_double(t) for t in body.motion.times])
    return 2.0 * far.max(axis=1) / length


def shape(body: Any) -> Any:
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(body.triangles), len(body.vertices))
    model.addVertices(np.asarray(body.vertices, float))
    for triangle in body.triangles.tolist():
        model.addTriangle(*(body.vertices[i] for i in triangle))
    model.endModel()
    return model


def resting(x: Any) -> Any:
    """The body without its motion."""
    return x.body if hasattr(x, "motion") else x


class Samples:
    """Whether coal finds bodies of a robot in collision at some times."""

    def __init__(self, urdf: Path, times: np.ndarray, values: dict[str, Any], links: dict[str, list[Any]]) -> None:
        import yourdfpy

        self.model = yourdfpy.URDF.load(str(urdf), load_meshes=False)
        self.times, self.values = times, values
        self.link_of = {body.name: link for link, own in links.items() for body in own}
        self.home = self._links(dict.fromkeys(values, 0.0))
        self.known: dict[float, dict[str, np.ndarray]] = {}
        self.shapes: dict[str, Any] = {}

    def _links(self, joints: dict[str, float]) -> dict[str, np.ndarray]:
        self.model.update_cfg({name: x + 0.01 for name, x in joints.items()})  # what is within 1e-8 is the same to it
        self.model.update_cfg(joints)
        return {link: self.model.get_transform(link) for link in self.link_of.values()}

    def pose(self, body: Any, t: float) -> np.ndarray:
        link = self.link_of.get(body.name)
        if link is None:
            return np.eye(4)
        if t not in self.known:
            joints = {name: float(np.interp(t, self.times, x)) for name, x in self.values.items()}
            self.known[t] = {name: pose @ np.linalg.inv(self.home[name]) for name, pose in self._links(joints).items()}
        return self.known[t][link]

    def collide(self, a: Any, b: Any, t: float) -> bool:
        import coal

        for body in (a, b):
            if body.name not in self.shapes:
                self.shapes[body.name] = shape(_mesh(resting(body)))
        at = [coal.Transform3s(p[:3, :3], p[:3, 3]) for p in (self.pose(a, t), self.pose(b, t))]
        pair = self.shapes[a.name], at[0], self.shapes[b.name], at[1]
        if not coal.collide(*pair, coal.CollisionRequest(), coal.CollisionResult()):
            return False  # else they may be a millionth apart
        return bool(coal.distance(*pair, coal.DistanceRequest(), coal.DistanceResult()) <= TOLERANCE)

    def judge(self, hit: fc.FirstContact, count: int) -> str | None:
        """What refutes an answer: FREE by so many samples, a contact just before and just after; None: nothing does."""
        first, last = hit.span
        if hit.status is fc.Status.FREE:
            met = [t for t in np.linspace(first, last, count).tolist() if self.collide(hit.a, hit.b, t)]
            return f"{hit}: coal finds them in collision at {met[0]}" if met else None
        if hit.time is None or hit.time_interval is None:
            return f"{hit}: no answer"
        lo, hi = hit.time_interval
        early = [t for t in (lo - step for step in STEPS) if t >= first and self.collide(hit.a, hit.b, t)]
        late = [t for t in (hi + step for step in STEPS) if t <= last and self.collide(hit.a, hit.b, t)]
        if early and hit.status is fc.Status.CONTACT:
            return f"{hit}: coal finds them in collision before, at {early[0]}"
        return None if late else f"{hit}: coal finds them in no collision after it"


def _mesh(body: Any) -> Any:
    """Boxes are meshes exactly."""
    return body if isinstance(body, fc.Polyhedron) else body.to_mesh(1e-4)
