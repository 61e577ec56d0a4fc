"""A real arm along a course of many waypoints, against obstacles and itself: `python -m benchmarks.mechanisms`.

The arm is that of the package example-robot-data (meshes of the Panda), which is installed beside and never committed.
coal is asked for distances in a loop of conservative steps along the same joint path: a step ends where the distance,
less a tolerance of 1e-9, may be used up by the speed bound of the two links.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import firstcontact as fc
from firstcontact.exact.numbers import to_double
from firstcontact.motion.relative.reach import line_of, places

TOLERANCE = 1e-9
FINGERS = "panda_finger_joint1"
SEED = 7
# Metres between the middles of obstacles and where hand and elbow pass.
GAP = 0.17


def arm_files() -> tuple[Path, Path]:
    """URDF and SRDF of the arm."""
    for root in map(Path, sys.path):
        folder = root / "cmeel.prefix/share/example-robot-data/robots/panda_description"
        if folder.is_dir():
            return folder / "urdf/panda.urdf", folder / "srdf/panda.srdf"
    raise SystemExit("example-robot-data is not installed: python -m pip install example-robot-data")


def scene(waypoints: int, obstacles: int) -> tuple[Any, list[Any]]:
    """The course, and obstacles about it."""
    urdf, srdf = arm_files()
    robot = fc.Robot.load(urdf, srdf=srdf)
    rng = np.random.default_rng(SEED)
    via = rng.uniform(-1.0, 1.0, (max(2, waypoints // 25), 7)) * (1.2, 0.7, 0.8, 0.5, 0.8, 0.6, 1.0)
    via += (0.0, 0.1, 0.0, -1.8, 0.0, 1.8, 0.8)
    shares = np.linspace(0, len(via) - 1, waypoints)
    values = {f"panda_joint{k + 1}": np.interp(shares, np.arange(len(via)), via[:, k]) for k in range(7)}
    course = robot.course(np.arange(waypoints) * 0.1, {**values, FINGERS: 0.02})
    return course, near(course, rng, obstacles)


def near(course: Any, rng: np.random.Generator, count: int) -> list[Any]:
    """Obstacles a hand's breadth from where the arm passes: many of its stretches have to be looked into."""
    hand = course.motion("panda_hand")
    first, last = hand.span
    path = np.array([hand(t) @ (0.088, 0.0, 0.8, 1.0) for t in np.linspace(first, last, 400)])[:, :3]
    elbow = course.motion("panda_link4")
    path = np.vstack([path, [(elbow(t) @ (0.0825, 0.0, 0.649, 1.0))[:3] for t in np.linspace(first, last, 200)]])
    things: list[Any] = []
    while len(things) < count:
        place = path[rng.integers(len(path))] + rng.normal(size=3) * 0.2
        if GAP < np.linalg.norm(path - place, axis=1).min() < GAP + 0.1 and np.linalg.norm(place[:2]) > 0.35:
            thing = fc.examples.noisy_sphere(300) if len(things) % 2 else fc.examples.box((2, 2, 2))
            things.append(fc.Polyhedron(thing.vertices * 0.05 + place, thing.triangles, name=f"thing{len(things)}"))
    return things


def ask(pairs: list[tuple[Any, Any]]) -> tuple[float, float, list[Any]]:
    """Seconds by the clock and of the processor, and the answers."""
    begin, busy = time.perf_counter(), time.process_time()
    found = [fc.first_contact(a, b) for a, b in pairs]
    return time.perf_counter() - begin, time.process_time() - busy, found


class ByDistances:
    """coal's distance in conservative steps, and the speed bounds that these need, which the library works out."""

    def __init__(self, pairs: list[tuple[Any, Any]]) -> None:
        self.shapes = {body.name: _shape(_body(body)) for pair in pairs for body in pair}
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


def _shape(body: Any) -> Any:
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(body.triangles), len(body.vertices))
    model.addVertices(np.asarray(body.vertices, float))
    for triangle in body.triangles.tolist():
        model.addTriangle(*(body.vertices[i] for i in triangle))
    model.endModel()
    return model


def compare(pairs: list[tuple[Any, Any]], found: list[Any], wall: float, every: int) -> None:
    """The same pairs by distances, in the same run; answers have to agree."""
    chosen = [k for k, pair in enumerate(pairs) if all(isinstance(_body(x), fc.Polyhedron) for x in pair)][::every]
    by_distances = ByDistances([pairs[k] for k in chosen])
    begin = time.process_time()
    times = {k: by_distances.first(*pairs[k]) for k in chosen}
    other = time.process_time() - begin
    _, mine, _ = ask([pairs[k] for k in chosen])
    for k, t in times.items():
        assert (t is None) == (found[k].time is None), (found[k], t)
        assert t is None or abs(t - found[k].time) < 1e-5, (found[k], t)
    inside = by_distances.inside
    print(f"{len(chosen)} pairs of meshes: by {by_distances.asked} distances {other:.2f} s, {inside:.2f} s of them in "
          f"coal; here {mine:.3f} s: {other / mine:.0f} and {inside / mine:.0f} times")  # fmt: skip


def per_stretch(count: int = 50) -> None:
    """Stretches of a course near a body, by one joint, two and seven, beside plain rotations of the same meshes."""
    link = fc.examples.noisy_sphere(2000).translated((2, 0, 0)).named("link")
    other = fc.examples.torus(2000).translated((2, 0, 0.9)).named("other")
    far = fc.examples.box((0.1, 0.1, 0.1)).translated((0, 0, -9))
    axes = [(0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0)]
    plain = [(link.moving(fc.Rotation((0, 0, 1), degrees=0.25 * (1 + k % 3))), other) for k in range(count)]
    costs = {"a plain rotation": _cost(plain)}
    for joints in (1, 2, 7):
        names = [f"q{k}" for k in range(joints)]
        links = {"ground": other, **{f"l{k}": far for k in range(joints - 1)}, f"l{joints - 1}": link}
        chain = ["ground", *(f"l{k}" for k in range(joints))]
        made = [
            fc.Joint(name, "revolute", chain[k], chain[k + 1], axis=axes[k], point=(0.25 * k, 0, 0))
            for k, name in enumerate(names)
        ]
        mechanism = fc.Mechanism(links, made)
        rng = np.random.default_rng(SEED)
        swing = 0.02 * rng.normal(size=(joints, count + 1)).cumsum(axis=1)
        course = mechanism.course(range(count + 1), dict(zip(names, swing - swing[:, :1], strict=True)))
        costs[f"{joints} joints"] = _cost([(course.bodies[f"l{joints - 1}"][0], other)]) / count
    first = costs["a plain rotation"] / count
    costs["a plain rotation"] = first
    print("one stretch:", ", ".join(f"{name} {1e6 * x:.0f} us ({x / first:.1f})" for name, x in costs.items()))


def _cost(pairs: list[tuple[Any, Any]]) -> float:
    """Seconds of the processor, the least of five."""
    found = ask(pairs)[2]
    assert {x.status for x in found} == {fc.Status.FREE}, found
    return min(ask(pairs)[1] for _ in range(5))


def _body(x: Any) -> Any:
    return x.body if hasattr(x, "motion") else x


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--waypoints", type=int, default=500)
    parser.add_argument("--obstacles", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--coal", type=int, default=0, metavar="N", help="ask coal about every Nth pair of meshes")
    options = parser.parse_args()
    per_stretch()
    course, things = scene(options.waypoints, options.obstacles)
    pairs = list(course.pairs(things))
    ask(pairs)  # kernels and trees
    rounds = []
    for _ in range(options.rounds):
        again, things = scene(options.waypoints, options.obstacles)  # nothing of the motions is kept
        rounds.append(ask(list(again.pairs(things))))
    found = rounds[-1][2]
    told = {status.name: sum(x.status is status for x in found) for status in fc.Status}
    wall, busy = (statistics.median(r[k] for r in rounds) for k in range(2))
    if options.coal:
        compare(pairs, found, wall, options.coal)
    print(f"{len(pairs)} pairs, {options.waypoints} waypoints: {wall:.2f} s ({busy:.2f} s of the processor); {told}")


if __name__ == "__main__":
    main()
