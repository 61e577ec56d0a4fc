"""Tool paths over a mesh of 1e5 triangles: `python -m benchmarks.toolpath` writes TOOLPATH.md.

The part is a relief; a cutter with its holder goes over it in 2000 G1 blocks, and in 2000 GOTOs with an axis that turns
on.  Most of the way is a tenth of a millimetre above the surface; here and there the program is too low, or the holder
meets a post.  Beside it, in the same run, coal is asked for distances in a loop of conservative steps along some of
the blocks.  Answers are checked by sampled collisions of coal, by tools that lie inside and about the exact one.
"""

from __future__ import annotations

import argparse
import math
import platform
import statistics
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import firstcontact as fc
from firstcontact.toolpath.check import Finding, Setup, Verdict

SIDES = 256
"""Of the polyhedra that stand for segments of the tool in coal."""
TOLERANCE = 1e-6
BEFORE = 1e-3
"""Millimetres of way before and after a contact at which coal is asked."""
SEED = 11
REPORT = Path(__file__).with_name("TOOLPATH.md")
SEGMENTS = [
    ("flutes", "cutter", 6, 18), ("shank", "holder", 6, 12), ("collet", "holder", (16, 28), 25),
    ("spindle", "holder", 50, 60),
]  # fmt: skip


def height(x: Any, y: Any) -> Any:
    return 4.0 * np.sin(x / 9.0) * np.cos(y / 7.0) + 1.5 * np.sin(x / 3.0 + y / 5.0)


def relief(n: int = 223) -> fc.Polyhedron:
    """A block of about 2 n^2 triangles, 100 x 100, with that height above it, and posts on it."""
    xs = np.linspace(-50, 50, n + 1)
    x, y = np.meshgrid(xs, xs, indexing="ij")
    z = height(x, y)
    for cx, cy in ((-22.0, 14.0), (25.0, -30.0), (8.0, 36.0)):
        z[np.hypot(x - cx, y - cy) < 1.5] = 40.0
    top = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b, c, d = (((i + u) * (n + 1) + j + v).ravel() for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)))
    up = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    side = np.arange(n + 1)
    ring = np.concatenate([side * (n + 1), n * (n + 1) + side[1:], side[::-1][1:] * (n + 1) + n, side[::-1][1:-1]])
    under = len(top) + np.arange(len(ring))
    middle = len(top) + len(ring)
    after = np.roll(np.arange(len(ring)), -1)
    walls = np.concatenate([np.column_stack([ring, ring[after], under]),
                            np.column_stack([ring[after], under[after], under])])[:, ::-1]  # fmt: skip
    floor = np.column_stack([under[after], under, np.full(len(ring), middle)])[:, ::-1]
    low = top[ring] * (1, 1, 0) + (0, 0, -20)
    vertices = np.concatenate([top, low, [[0, 0, -20]]])
    return fc.Polyhedron(vertices, np.concatenate([up, walls, floor]), name="part")


def ways(blocks: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Tips (n, 3) and axes (n, 3), row by row over the part; one in a hundred blocks too low."""
    rows = 40
    per_row = blocks // rows + 1
    x = np.concatenate([np.linspace(-46, 46, per_row) * (1 if k % 2 == 0 else -1) for k in range(rows)])[: blocks + 1]
    y = np.repeat(np.linspace(-46, 46, rows), per_row)[: blocks + 1]
    around = np.stack([height(x + 3.4 * s * math.cos(a), y + 3.4 * s * math.sin(a))
                       for s in np.linspace(0, 1, 6) for a in np.linspace(0, 2 * math.pi, 24)])  # fmt: skip
    tops = around.max(axis=0)
    tops = np.maximum(tops, np.maximum(np.roll(tops, 1), np.roll(tops, -1)))
    z = tops + 0.1 - 0.6 * (rng.random(blocks + 1) < 0.01)
    tilt = 0.15 * np.sin(np.arange(blocks + 1) / 6.0)
    turn = np.arange(blocks + 1) / 15.0
    axes = np.column_stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    return np.column_stack([x, y, z]), axes


def write_programs(folder: Path, blocks: int) -> tuple[Path, Path]:
    rng = np.random.default_rng(SEED)
    tips, axes = ways(blocks, rng)
    three, five = folder / "relief.nc", folder / "relief.apt"
    lines = ["G21 G90 G17", "G0 X{:.4f} Y{:.4f} Z60".format(*tips[0][:2])]
    three.write_text("\n".join([*lines, *("G1 X{:.4f} Y{:.4f} Z{:.4f} F900".format(*p) for p in tips)]) + "\n")
    lifted = tips + np.array([0, 0, 0.6])  # a tilted end mill reaches deeper at its rim
    rows = ("GOTO/{:.4f},{:.4f},{:.4f},{:.7f},{:.7f},{:.7f}".format(*p, *u) for p, u in zip(lifted, axes, strict=True))
    five.write_text("\n".join(["UNITS/MM", "MULTAX/ON", *rows]) + "\n")
    return three, five


@dataclass
class Run:
    """One program: seconds by the clock and of the processor, the verdicts."""

    name: str
    bar: float
    walls: list[float]
    busy: list[float]
    told: list[Verdict]


def measured(name: str, program: Path, bar: float, tool: fc.Tool, part: fc.Polyhedron, rounds: int) -> Run:
    """Reading the file and all verdicts; kernels are warm, and the mesh's tree is made."""
    run = Run(name, bar, [], [], [])
    for _ in range(rounds + 1):
        begin, busy = time.perf_counter(), time.process_time()
        run.told = list(fc.ToolPath(program).verdicts(tool, {"part": part}, workers=1))
        run.walls.append(time.perf_counter() - begin)
        run.busy.append(time.process_time() - busy)
    run.walls, run.busy = run.walls[1:], run.busy[1:]  # the first one loads kernels
    return run


class Coal:
    """Segments as polyhedra, inside the exact ones or about them, before the mesh."""

    def __init__(self, tool: fc.Tool, part: fc.Polyhedron) -> None:
        import coal

        self.coal = coal
        self.part = self._model(part.vertices, part.triangles)
        self.inner = {x.name: self._round(x, 1.0) for x in tool.segments}
        outer = 1.0 / math.cos(math.pi / SIDES)
        self.outer = {x.name: self._round(x, outer) for x in tool.segments}
        self.segments = {x.name: x for x in tool.segments}
        self.rest = coal.Transform3s()
        self.asked = 0

    def _round(self, segment: Any, grown: float) -> Any:
        low, bottom, high, top = segment.doubles
        angles = 2 * math.pi * np.arange(SIDES) / SIDES
        ring = np.column_stack([np.cos(angles), np.sin(angles)]) * grown
        rings = [np.column_stack([ring * r, np.full(SIDES, z)]) for z, r in ((low, bottom), (high, top))]
        points = np.concatenate([*rings, [[0, 0, low], [0, 0, high]]])
        k = np.arange(SIDES)
        j = (k + 1) % SIDES
        faces = [(k, j, SIDES + j), (k, SIDES + j, SIDES + k), (j, k, 0 * k + 2 * SIDES),
                 (SIDES + k, SIDES + j, 0 * k + 2 * SIDES + 1)]  # fmt: skip
        return self._model(points, np.concatenate([np.column_stack(f) for f in faces]))

    def _model(self, vertices: np.ndarray, triangles: np.ndarray) -> Any:
        model = self.coal.BVHModelOBBRSS()
        model.beginModel(len(triangles), len(vertices))
        model.addVertices(np.asarray(vertices, float))
        for a, b, c in triangles.tolist():
            model.addTriangle(vertices[a], vertices[b], vertices[c])
        model.endModel()
        return model

    def collides(self, shape: Any, pose: np.ndarray) -> bool:
        request, result = self.coal.CollisionRequest(), self.coal.CollisionResult()
        return bool(self.coal.collide(shape, self._place(pose), self.part, self.rest, request, result))

    def _place(self, pose: np.ndarray) -> Any:
        return self.coal.Transform3s(pose[:3, :3], pose[:3, 3])

    def first(self, name: str, stretch: Any, speed: float) -> float | None:
        """The time of the first contact within the tolerance, by conservative steps."""
        request, result, t = self.coal.DistanceRequest(), self.coal.DistanceResult(), 0.0
        while t <= 1.0:
            result.clear()
            place = self._place(pose_of(stretch, t))
            gap = self.coal.distance(self.inner[name], place, self.part, self.rest, request, result)
            self.asked += 1
            if gap <= TOLERANCE:
                return t
            t += gap / speed
        return None


def pose_of(stretch: Any, t: float) -> np.ndarray:
    """Of the tool, in doubles: by the axis between two places, whatever the library's motion is."""
    pose = np.eye(4)
    pose[:3, 3] = stretch.tip(t)
    if hasattr(stretch, "axis0"):
        u, v = (np.array([float(str(c.p)) / float(str(c.q)) for c in x]) for x in (stretch.axis0, stretch.axis1))
        u, v = u / np.linalg.norm(u), v / np.linalg.norm(v)
        first = turn(np.array([0.0, 0.0, 1.0]), u, 1.0)
        pose[:3, :3] = turn(u, v, t) @ first
    return pose


def turn(u: np.ndarray, v: np.ndarray, t: float) -> np.ndarray:
    """The rotation of the straight line of unit quaternions from 1 to the one that takes u to v, at t."""
    whole = np.array([1.0 + u @ v, *np.cross(u, v)])
    whole /= np.linalg.norm(whole)
    w, x, y, z = (1 - t) * np.array([1.0, 0, 0, 0]) + t * whole
    n = w * w + x * x + y * y + z * z
    return np.eye(3) + 2.0 / n * np.array([
        [-(y * y + z * z), x * y - w * z, x * z + w * y],
        [x * y + w * z, -(x * x + z * z), y * z - w * x],
        [x * z - w * y, y * z + w * x, -(x * x + y * y)],
    ])  # fmt: skip


def speed_of(stretch: Any, reach: float) -> float:
    """A bound of how far a point of the tool goes in the block."""
    if not hasattr(stretch, "axis0"):
        return float(stretch.length)
    u, v = (np.array([float(str(c.p)) / float(str(c.q)) for c in x]) for x in (stretch.axis0, stretch.axis1))
    angle = math.atan2(float(np.linalg.norm(np.cross(u, v))), float(u @ v))
    return float(stretch.length) + 1.01 * angle * reach


@dataclass
class Checked:
    contacts: int = 0
    early: int = 0
    late: int = 0
    free: int = 0
    wrong: int = 0


def checked(run: Run, coal: Coal, samples: int, share: int) -> Checked:
    """Every contact just before and just after; one in `share` of the free blocks at so many times."""
    told, names = Checked(), list(coal.segments)
    free = [x for x in run.told if x.block.stretches]
    for x in free:
        for found in x.findings:
            told.contacts += 1
            early, late = _around(x, found, coal)
            told.early += early
            told.late += late
    for x in free[::share]:
        met = {found.part for found in x.findings}
        (stretch,) = x.block.stretches
        for name in names:
            if name not in met:
                told.free += 1
                for t in np.linspace(0.0, 1.0, samples):
                    if coal.collides(coal.inner[name], pose_of(stretch, float(t))):
                        told.wrong += 1
                        break
    return told


def _around(x: Verdict, found: Finding, coal: Coal) -> tuple[bool, bool]:
    """Whether coal sees a contact of the inner polyhedron before, and none of the outer one after: both are wrong."""
    (stretch,) = x.block.stretches
    off = BEFORE / max(stretch.length, 1e-9)
    shape = coal.inner[found.part], coal.outer[found.part]
    before, after = max(found.fraction - off, 0.0), min(found.fraction + off, 1.0)
    early = found.fraction > off and coal.collides(shape[0], pose_of(stretch, before))
    return early, not coal.collides(shape[1], pose_of(stretch, after))


def beside(run: Run, coal: Coal, setup: Setup, every: int) -> tuple[int, float, float, int]:
    """(blocks, seconds here, seconds of coal's loop, contacts that differ) of one in `every` blocks."""
    blocks = [x.block for x in run.told if x.block.stretches][::every]
    begin = time.process_time()
    told = list(setup.verdicts(blocks))
    mine = time.process_time() - begin
    begin, differ, coal.asked = time.process_time(), 0, 0
    for x in told:
        (stretch,) = x.block.stretches
        for name, segment in coal.segments.items():
            t = coal.first(name, stretch, speed_of(stretch, segment.reach))
            found = next((y for y in x.findings if y.part == name), None)
            # the inner polyhedron meets a little later, or misses a contact that only grazes
            differ += (t is not None) and (found is None or t < found.fraction - 1e-6)
    return len(blocks), mine, time.process_time() - begin, differ


def lines_of(
    runs: list[Run], checks: list[Checked], peers: list[tuple[int, float, float, int]], triangles: int, samples: int
) -> Iterator[str]:
    yield "# Tool paths"
    yield ""
    yield f"`python -m benchmarks.toolpath`, {platform.machine()}, one core, Python {platform.python_version()}."
    yield f"A relief of {triangles:,} triangles, with posts; a tool of {len(SEGMENTS)} segments, cutter and holder."
    yield ""
    yield "Seconds contain reading the file (twice) and all verdicts with their places; the mesh's tree is made before,"
    yield "and kernels are loaded. Contacts are pairs of a block and a segment; of these `at the start` of their block."
    yield "`early`: coal sees a polyhedron of 256 sides inside the segment overlap a micrometre of way before what is"
    yield "told; `late`: it does not see one about the segment overlap a micrometre after it; `wrong`: it does in"
    yield f"a way told FREE, at {samples} samples."
    yield ""
    yield (
        "| program | blocks | s (clock) | s (processor) | bar | contacts | at the start | early | late "
        "| FREE ways sampled | wrong |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for run, check in zip(runs, checks, strict=True):
        wall, busy = statistics.median(run.walls), statistics.median(run.busy)
        blocks = sum(bool(x.block.stretches) for x in run.told)
        begun = sum(y.status == "INITIAL_CONTACT" for x in run.told for y in x.findings)
        yield (
            f"| {run.name} | {blocks} | {wall:.2f} | {busy:.2f} | {run.bar:g} | {check.contacts} | {begun} "
            f"| {check.early} | {check.late} | {check.free} | {check.wrong} |"
        )
    yield ""
    yield "Beside coal's distances in conservative steps to 1e-6 (polyhedra of 256 sides for the segments), one run:"
    yield ""
    yield "| program | blocks | here, s | coal, s | ratio | told FREE or later, but met by coal |"
    yield "|---|---|---|---|---|---|"
    for run, (n, mine, other, differ) in zip(runs, peers, strict=True):
        yield f"| {run.name} | {n} | {mine:.3f} | {other:.2f} | {other / mine:.0f} | {differ} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=2000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--samples", type=int, default=1000)
    parser.add_argument("--share", type=int, default=40, metavar="N", help="sample one in N of the blocks")
    parser.add_argument("--every", type=int, default=40, metavar="N", help="ask coal about one in N blocks")
    options = parser.parse_args()
    part, tool = relief(), fc.Tool(SEGMENTS)
    setup = Setup(tool, {"part": part}, workers=1)
    coal = Coal(tool, part)
    with tempfile.TemporaryDirectory() as folder:
        programs = write_programs(Path(folder), options.blocks)
        names = f"{options.blocks} G1, three axes", f"{options.blocks} GOTO, five axes"
        bars = 1.0, 3.0
        runs = [measured(*x, tool, part, options.rounds) for x in zip(names, programs, bars, strict=True)]
        for run in runs:
            print(run.name, "clock", [f"{x:.2f}" for x in run.walls], "processor", [f"{x:.2f}" for x in run.busy])
        peers = [beside(run, coal, setup, options.every) for run in runs]
        print(peers)
        checks = [checked(run, coal, options.samples, options.share) for run in runs]
    text = "\n".join(lines_of(runs, checks, peers, len(part.triangles), options.samples)) + "\n"
    print(text)
    REPORT.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
