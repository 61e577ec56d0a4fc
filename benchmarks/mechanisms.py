"""A real arm along a course of many waypoints, against obstacles and itself: `python -m benchmarks.mechanisms`.

The arm is that of the package example-robot-data (meshes of the Panda), which is installed beside and never committed.
coal is asked for distances in a loop of conservative steps along the same joint path: a step ends where the distance,
less a tolerance of 1e-9, may be used up by the speed bound of the two links.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import firstcontact as fc
from firstcontact.motion.linkage import Linkage

TOLERANCE = 1e-9
FINGERS = "panda_finger_joint1"
SEED = 7


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
    things = []
    while len(things) < obstacles:
        place = rng.uniform(-1, 1, 3) * (0.9, 0.9, 0.6) + (0, 0, 0.5)
        if np.linalg.norm(place[:2]) > 0.65:
            thing = fc.examples.noisy_sphere(300) if len(things) % 2 else fc.examples.box((2, 2, 2))
            vertices = thing.vertices * 0.06 + place
            things.append(fc.Polyhedron(vertices, thing.triangles, name=f"thing{len(things)}"))
    return course, things


def ask(pairs: list[tuple[Any, Any]]) -> tuple[float, float, list[Any]]:
    """Seconds by the clock and of the processor, and the answers."""
    begin, busy = time.perf_counter(), time.process_time()
    found = [fc.first_contact(a, b) for a, b in pairs]
    return time.perf_counter() - begin, time.process_time() - busy, found


class ByDistances:
    """coal's distance in conservative steps."""

    def __init__(self, bodies: list[Any]) -> None:
        self.shapes = {body.name: _shape(body) for body in bodies}

    def first(self, a: Any, b: Any, rates: dict[str, Any]) -> tuple[float | None, int]:
        """The time of the first contact within the tolerance, and how many distances were asked."""
        import coal

        request, result = coal.DistanceRequest(), coal.DistanceResult()
        first, last = (a.motion if hasattr(a, "motion") else b.motion).span
        t, asked = first, 0
        while t <= last:
            k = min(int(round((t - first) / 0.1 - 0.5)), len(rates[a.name]) - 1)
            places = [coal.Transform3s(p[:3, :3], p[:3, 3]) for p in (_pose(a, t), _pose(b, t))]
            result.clear()
            gap = coal.distance(self.shapes[a.name], places[0], self.shapes[b.name], places[1], request, result)
            asked += 1
            if gap <= TOLERANCE:
                return t, asked
            speed = rates[a.name][k] + rates[b.name][k]
            t = min(t + gap / max(speed, 1e-12), first + (k + 1) * 0.1 + 1e-12)
        return None, asked


def _pose(body: Any, t: float) -> np.ndarray:
    return quick_pose(body.motion, t) if hasattr(body, "motion") else np.eye(4)


def quick_pose(motion: Linkage, t: float) -> np.ndarray:
    """The pose in doubles, for coal's loop: the library's own rounds an enclosure."""
    k = min(int(t / 0.1), len(motion.times) - 2)
    share = t / 0.1 - k
    pose = np.eye(4)
    for drive in motion.drives:
        pose = pose @ drive.motion(drive.doubles[k, 0] + share * drive.doubles[k, 1])
    return pose


def _shape(body: Any) -> Any:
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(body.triangles), len(body.vertices))
    model.addVertices(np.asarray(body.vertices, float))
    for triangle in body.triangles.tolist():
        model.addTriangle(*(body.vertices[i] for i in triangle))
    model.endModel()
    return model


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--waypoints", type=int, default=500)
    parser.add_argument("--obstacles", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
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
    print(f"{len(pairs)} pairs, {options.waypoints} waypoints: {wall:.2f} s ({busy:.2f} s of the processor); {told}")


if __name__ == "__main__":
    main()
