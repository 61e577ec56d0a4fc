"""A real arm along a course of many waypoints, against obstacles and itself: `python -m benchmarks.mechanisms`.

The arm is that of the package example-robot-data (meshes of the Panda), which is installed beside and never committed.
coal is asked for distances in a loop of conservative steps along the same joint path: a step ends where the distance,
less a tolerance of 1e-9, may be used up by the speed bound of the two links.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from benchmarks.mechanism_forms import FORMS, error
from benchmarks.mechanism_judges import ByDistances, Samples, resting

import firstcontact as fc

TARGET = Path(__file__).with_name("MECHANISMS.md")
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


def scene(waypoints: int, obstacles: int) -> tuple[Any, list[Any], dict[str, Any]]:
    """The course, obstacles about it, and the joints' values at its waypoints, which are 0.1 apart."""
    urdf, srdf = arm_files()
    robot = fc.Robot.load(urdf, srdf=srdf)
    rng = np.random.default_rng(SEED)
    via = rng.uniform(-1.0, 1.0, (max(2, waypoints // 25), 7)) * (1.2, 0.7, 0.8, 0.5, 0.8, 0.6, 1.0)
    via += (0.0, 0.1, 0.0, -1.8, 0.0, 1.8, 0.8)
    shares = np.linspace(0, len(via) - 1, waypoints)
    values = {f"panda_joint{k + 1}": np.interp(shares, np.arange(len(via)), via[:, k]) for k in range(7)}
    values[FINGERS] = np.full(waypoints, 0.02)
    course = robot.course(np.arange(waypoints) * 0.1, {**values, FINGERS: 0.02})
    return course, near(course, rng, obstacles), values


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


class Arm(NamedTuple):
    """The arm along so many waypoints: medians of seconds, by the clock and of the processor, and the answers."""

    waypoints: int
    wall: float
    busy: float
    found: list[Any]

    @property
    def told(self) -> str:
        counts = {status: sum(x.status is status for x in self.found) for status in fc.Status}
        return ", ".join(f"{n} {status.name}" for status, n in counts.items() if n)


def arm(waypoints: int, obstacles: int, rounds: int) -> Arm:
    """Every pair, asked in rounds that keep nothing of the motions and bodies of each other."""
    asked = []
    for _ in range(rounds):
        course, things, _ = scene(waypoints, obstacles)
        asked.append(ask(list(course.pairs(things))))
    wall, busy = (statistics.median(x[k] for x in asked) for k in range(2))
    return Arm(waypoints, wall, busy, asked[-1][2])


def judged(waypoints: int, obstacles: int, found: list[Any], samples: int) -> str:
    """Stops at the first answer that coal's collisions refute."""
    course, _, values = scene(waypoints, obstacles)
    times = np.arange(waypoints) * 0.1
    truth = Samples(arm_files()[0], times, values, course.mechanism.links)
    wrong = [x for hit in found if (x := truth.judge(hit, samples)) is not None]
    assert not wrong, wrong[0]
    free = sum(x.status is fc.Status.FREE for x in found)
    return f"{free} FREE by {samples} samples each, {len(found) - free} contacts just before and just after"


class Steps(NamedTuple):
    """The pairs of meshes by coal's distances: how many, seconds of the processor in all, within coal, and here."""

    pairs: int
    distances: int
    other: float
    inside: float
    mine: float


def by_distances(waypoints: int, obstacles: int, every: int) -> Steps:
    """The same question by conservative steps, in the same run; answers have to agree."""
    course, things, _ = scene(waypoints, obstacles)
    meshes = [x for x in course.pairs(things) if all(isinstance(resting(y), fc.Polyhedron) for y in x)]
    pairs = meshes[::every]
    _, mine, found = ask(pairs)
    tool = ByDistances(pairs)
    begin = time.process_time()
    times = [tool.first(*pair) for pair in pairs]
    other = time.process_time() - begin
    for t, hit in zip(times, found, strict=True):
        assert (t is None) == (hit.time is None), (hit, t)
        assert t is None or abs(t - hit.time) < 1e-5, (hit, t)
    return Steps(len(pairs), tool.asked, other, tool.inside, mine)


def per_stretch(count: int = 50) -> list[tuple[str, float, float]]:
    """Stretches of a course near a body, by one joint, two and seven, beside plain rotations of the same meshes.

    (What, how many times a plain rotation, microseconds.)
    """
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
        costs[f"{joints} joint{'s' * (joints > 1)}"] = _cost([(course.bodies[f"l{joints - 1}"][0], other)]) / count
    first = costs.pop("a plain rotation") / count
    return [("a plain rotation", 1.0, 1e6 * first), *((name, x / first, 1e6 * x) for name, x in costs.items())]


def _cost(pairs: list[tuple[Any, Any]]) -> float:
    """Seconds of the processor, the least of five."""
    found = ask(pairs)[2]
    assert {x.status for x in found} == {fc.Status.FREE}, found
    return min(ask(pairs)[1] for _ in range(5))


HEAD = """# Mechanisms

By `python -m benchmarks.mechanisms`, {cores} processors with a load of {load:.1f} before the run; seconds are those of
the processor, those of the clock in brackets. The arm is the Panda of example-robot-data with its meshes (200 to 300
triangles a link, fingers that are boxes), against {obstacles} obstacles a hand's breadth from where hand and elbow
pass, and against itself: {pairs} pairs, the first contact of each, nothing of motions and bodies kept between rounds.

| what | measured | bar |
|---|---|---|
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--waypoints", type=int, default=500)
    parser.add_argument("--obstacles", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--samples", type=int, default=1000, metavar="N", help="times at which FREE is looked at")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="ask coal about every Nth pair of meshes")
    options = parser.parse_args()
    n, obstacles = options.waypoints, options.obstacles
    load = os.getloadavg()[0]
    off = "off its closed form, enclosure included"
    rows = [_row(form.name, error(form), "{:.1e}", 1e-12, off) for form in (make() for make in FORMS)]
    arm(n, obstacles, 1)  # kernels
    short = arm(n, obstacles, options.rounds)
    rows.append(_row(f"{n} waypoints: {short.told}", short.busy, "{:.2f}", 2.0, f"s ({short.wall:.2f} s)"))
    steps = by_distances(n, obstacles, options.every)
    name = f"{steps.pairs} pairs of meshes by {steps.distances} distances of coal to 1e-9, "
    ratio = steps.other / steps.mine
    missed = "" if ratio >= 10 else ", missed"
    rows.append(f"| {name}{steps.other:.2f} s, here {steps.mine:.2f} s | {ratio:.0f} times | 10{missed} |")
    rows.append(f"| the same, within coal alone {steps.inside:.2f} s | {steps.inside / steps.mine:.0f} times | |")
    long = arm(10 * n, obstacles, options.rounds)
    rows.append(_row(f"{10 * n} waypoints: {long.told}", long.busy / short.busy, "{:.1f}", 12.0,
                     f"times {n} waypoints: {long.busy:.2f} s ({long.wall:.2f} s)"))  # fmt: skip
    for name, times, microseconds in per_stretch():
        rows.append(_row(f"a stretch near a mesh, both of 2000 triangles: {name}", times, "{:.1f}", 5.0,
                         f"times a plain rotation: {microseconds:.0f} us"))  # fmt: skip
    text = HEAD.format(cores=os.cpu_count(), load=load, obstacles=obstacles, pairs=len(short.found)) + "\n".join(rows)
    told = [judged(x.waypoints, obstacles, x.found, options.samples) for x in (short, long)]
    text += f"\n\nNo answer is refuted by coal, poses by yourdfpy: of {n} waypoints {told[0]}; of {10 * n} {told[1]}.\n"
    print(text)
    TARGET.write_text(text)


def _row(what: str, value: float, form: str, most: float, unit: str) -> str:
    return f"| {what} | {form.format(value)} {unit} | {most:g}{'' if value <= most else ', missed'} |"


if __name__ == "__main__":
    main()
