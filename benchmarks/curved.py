"""Curved solids: first contact beside coal, python-fcl, mujoco and OpenCASCADE in the conservative loop, beside meshes
of the same solids in coal, and the worked examples of Choi et al. 2014; writes CURVED.md.

    python benchmarks/curved.py [--repeats 5] [--motions 12] [--quick] [--out DIR]
    python benchmarks/curved.py --primitives            # only those, beside coal; prints and writes nothing

The other tools measure distances only; `curved_peers.advance` makes first contacts of them, to 1e-9 of the span.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path as File
from statistics import median
from time import perf_counter

import numpy as np

import firstcontact as fc
from curved_peers import PEERS, Found, advance, installed
from curved_peers.parts import SCENES, Ours
from curved_peers.paths import Path
from firstcontact.examples.choi import example_7, example_8

SEED = 2014
CLOSE = 1e-6
"""Of the span: an answer farther from ours than this counts as early or late."""
SLOW_MOTIONS = 3
"""Motions OpenCASCADE is asked, once each."""
LIMIT = 20.0
"""Seconds for one query of another tool."""
SIZES = (1_000, 10_000, 100_000)


def capsule():
    ends = [fc.sphere("1/2").translated((0, 0, z)) for z in ("-3/4", "3/4")]
    return fc.cylinder("1/2", "3/2") | ends[0] | ends[1]


SHAPES = {
    "sphere": (lambda: fc.sphere(1), (1.0,), 1.0),
    "ellipsoid": (lambda: fc.ellipsoid((1, "3/4", "1/2")), (1.0, 0.75, 0.5), 1.0),
    "cylinder": (lambda: fc.cylinder("3/4", 2), (0.75, 2.0), 1.25),
    "cone": (lambda: fc.cone("3/4", 2), (0.75, 2.0), 2.0),
    "box": (lambda: fc.box((1, 2, "3/2")), (1.0, 2.0, 1.5), math.sqrt(1.8125)),
    "capsule": (capsule, (0.5, 1.5), 1.25),
}
"""name: our solid, the numbers of the others' shape of that name, the farthest point from our origin."""
PAIRS = (
    ("sphere", "box"), ("ellipsoid", "ellipsoid"), ("cylinder", "cylinder"), ("cylinder", "cone"), ("cone", "cone"),
    ("ellipsoid", "box"), ("box", "box"), ("capsule", "cylinder"), ("capsule", "box"),
)  # fmt: skip


@dataclass
class Record:
    """What one tool answered: seconds of its queries, paired with ours, and how its times compare with ours.

    missed: no contact where there is one; invented: a contact where there is none; early, late: the farthest of the
    others from our enclosure; wrong: answers early or late by more than CLOSE; negative: how many of these ended with
    a gap below zero.
    """

    seconds: list[float] = field(default_factory=list)
    ours: list[float] = field(default_factory=list)
    queries: int = 0
    missed: int = 0
    invented: int = 0
    early: float = 0.0
    late: float = 0.0
    wrong: int = 0
    negative: int = 0
    troubles: dict[str, int] = field(default_factory=dict)

    def note(self, found: Found, hit: fc.FirstContact) -> None:
        self.queries += 1
        if found.trouble:
            self.troubles[found.trouble] = self.troubles.get(found.trouble, 0) + 1
        elif hit.status is fc.Status.FREE:
            self.invented += found.time is not None
        elif found.time is None:
            self.missed += 1
        else:
            lo, hi = hit.time_interval
            self.early, self.late = max(self.early, lo - found.time), max(self.late, found.time - hi)
            off = max(lo - found.time, found.time - hi) > CLOSE
            self.wrong, self.negative = self.wrong + off, self.negative + (off and found.negative)

    def cell(self, bar: float | None = None) -> str:
        """ms, and how many times our time that is; marked where the bar is not met."""
        if not self.seconds:
            return "-"
        ratio = median(self.seconds) / median(self.ours)
        return f"{ms(median(self.seconds))} ({ratio:.3g}{' !' if bar and ratio < bar else ''})"


def ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3f}"


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)] + [""]


def timed(a, b) -> tuple[fc.FirstContact, float]:
    start = perf_counter()
    hit = fc.first_contact(a, b)
    return hit, perf_counter() - start


def correctness(records: dict[str, Record]) -> list[str]:
    rows = []
    for name, r in records.items():
        trouble = ", ".join(f"{n} {what}" for what, n in r.troubles.items()) or "-"
        counts = r.queries, r.missed, r.invented, r.wrong, r.negative
        rows.append([name, *map(str, counts), f"{r.early:.1e}", f"{r.late:.1e}", trouble])
    head = ["tool", "queries", "missed", "invented", f"off by > {CLOSE:g}", "of these below 0", "early", "late"]
    head.append("no answer")
    return table(head, rows)


# -- convex primitives --------------------------------------------------------------------------------------------


def motions(kind: str, count: int) -> list[tuple[Path, np.ndarray]]:
    """Screws or translations of the first body that mostly end in contact, and where the second one rests."""
    rng, found = np.random.default_rng(SEED), []
    for _ in range(count):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        point, degrees = rng.uniform(-0.3, 0.3, 3), float(rng.uniform(-90, 90))
        path = Path(direction, point, degrees if kind == "screw" else 0.0, 6.0)
        found.append((path, 4.0 * direction + rng.uniform(-0.4, 0.4, 3)))
    return found


def primitives(kind: str, count: int, repeats: int, peers: list) -> list[str]:
    totals = {peer.name: Record() for peer in peers}
    rows = []
    for names in PAIRS:
        (make_a, numbers_a, reach), (make_b, numbers_b, _) = (SHAPES[name] for name in names)
        a, b = make_a(), make_b()
        gaps = {}
        for peer in peers:
            shapes = peer.shape(names[0], numbers_a), peer.shape(names[1], numbers_b)
            if all(shape is not None for shape in shapes):
                gaps[peer.name] = peer.distance(*shapes)
        records = {peer.name: Record() for peer in peers}
        own: list[float] = []
        for number, (path, place) in enumerate(motions(kind, count)):
            moving, resting = a.moving(path.ours), b.translated(place.tolist())
            fc.first_contact(moving, resting)
            for repeat in range(repeats):
                hit, seconds = timed(moving, resting)
                own.append(seconds)
                for name, gap in gaps.items():
                    slow = name == "OpenCASCADE"
                    if slow and (repeat or number >= SLOW_MOTIONS):
                        continue
                    found = between(gap, path, place, path.speed(reach), LIMIT)
                    records[name].seconds.append(found.seconds)
                    records[name].ours.append(seconds)
                    if repeat == 0:
                        records[name].note(found, hit)
                        totals[name].note(found, hit)
        cells = [records[peer.name].cell(2 / 3 if peer.name == "coal" else None) for peer in peers]
        rows.append([" / ".join(names), ms(median(own)), *cells])
    return table(["pair", "firstcontact", *totals], rows) + correctness(totals)


def between(gap, path: Path, place, speed: float, limit: float) -> Found:
    rest = np.eye(3), np.asarray(place, float)
    return advance(lambda t: gap(path.pose(t), rest), speed, limit)


# -- parts with holes ---------------------------------------------------------------------------------------------


def parts(repeats: int, peers: list) -> list[str]:
    kernel = next((peer for peer in peers if peer.name == "OpenCASCADE"), None)
    total = Record()
    rows = []
    for name, make_a, make_b, path, start in SCENES:
        a, b = make_a(Ours()), make_b(Ours())
        place = -np.array(start, float)  # a starts at the origin of its own frame: b is shifted instead
        moving, resting = a.moving(path.ours), b.translated(place.tolist())
        try:
            fc.first_contact(moving, resting)
            answers = [timed(moving, resting) for _ in range(repeats)]
        except fc.UnsupportedPair:
            answers = []
        own = median(seconds for _, seconds in answers) if answers else None
        found = None
        if kernel:
            gap = kernel.distance(make_a(kernel), make_b(kernel))
            reach = float(np.linalg.norm(np.abs(a.bounds()).max(axis=0)))
            found = between(gap, path, place, path.speed(reach), LIMIT)
        rows.append([name, *part_cells(own, answers[0][0] if answers else None, found)])
        if found and answers:
            total.note(found, answers[0][0])
    head = ["scene", "firstcontact", "OpenCASCADE", "times ours", "bar 20", "our time", "its time"]
    return table(head, rows) + (correctness({"OpenCASCADE": total}) if kernel else [])


def part_cells(own: float | None, hit: fc.FirstContact | None, found: Found | None) -> list[str]:
    ratio = found.seconds / own if found and own else None
    return [
        "unsupported" if own is None else ms(own),
        "-" if found is None else ms(found.seconds) + (f" ({found.trouble})" if found.trouble else ""),
        "-" if ratio is None else f"{ratio:.0f}",
        "-" if ratio is None else "met" if ratio >= 20 else "not met",
        "-" if hit is None else repr(hit.time),
        "-" if found is None or found.trouble else repr(found.time),
    ]


# -- triangle meshes of the same solids -----------------------------------------------------------------------------


def meshes(repeats: int, peers: list, sizes: tuple[int, ...]) -> list[str]:
    coal = next((peer for peer in peers if peer.name == "coal"), None)
    if coal is None:
        return ["coal is not installed.", ""]
    rows = []
    for names in (("ellipsoid", "ellipsoid"), ("cylinder", "cylinder")):
        (make_a, _, reach), (make_b, _, _) = (SHAPES[name] for name in names)
        a, b = make_a(), make_b()
        path, place = motions("screw", 1)[0]
        moving, resting = a.moving(path.ours), b.translated(place.tolist())
        fc.first_contact(moving, resting)
        answers = [timed(moving, resting) for _ in range(repeats)]
        hit, own = answers[0][0], median(seconds for _, seconds in answers)
        rows.append([" / ".join(names), "exact", ms(own), "", "", f"{hit.time_interval[1] - hit.time_interval[0]:.1e}"])
        for size in sizes:
            tolerances = [tolerance_for(solid, size) for solid in (a, b)]
            start = perf_counter()
            solids = [solid.to_mesh(tolerance) for solid, tolerance in zip((a, b), tolerances, strict=True)]
            gap = coal.distance(*(coal.mesh(m.vertices, m.triangles) for m in solids))
            built = perf_counter() - start
            found = [between(gap, path, place, path.speed(reach), LIMIT) for _ in range(repeats)]
            took = median(f.seconds for f in found)
            error = "missed" if found[0].time is None else f"{found[0].time - hit.time:+.1e}"
            count = " + ".join(str(len(m.triangles)) for m in solids)
            rows.append(["", f"{count} triangles", ms(took), f"{took / own:.3g}", f"{built:.1f}", error])
    head = ["pair", "model", "query ms", "times ours", "to build, s", "error of the time (exact: enclosure)"]
    return table(head, rows)


def tolerance_for(solid, triangles: int) -> float:
    """A tolerance whose mesh has about so many triangles: the last of ever smaller ones before there are far more."""
    tolerance = best = 1e-2
    while True:
        try:
            count = len(solid.to_mesh(tolerance).triangles)
        except fc.InputError:  # more than any mesh may have
            return best
        if count > 2 * triangles:
            return best
        best = tolerance
        if count > triangles / 1.5:
            return best
        tolerance /= 2


# -- the worked examples, memory and start-up -----------------------------------------------------------------------


def examples(repeats: int) -> list[str]:
    rows = []
    for name, make, bars in (
        ("Example 7", example_7, {"auto": 1.0, "algebraic": 60.0}),
        ("Example 8", example_8, {"auto": 20.0, "algebraic": None}),
    ):
        a, b = make()
        for method, bar in bars.items():
            fc.first_contact(a, b, method=method)
            times = []
            for _ in range(repeats):
                start = perf_counter()
                hit = fc.first_contact(a, b, method=method)
                times.append(perf_counter() - start)
            took = median(times)
            verdict = "" if bar is None else "met" if 1e3 * took <= bar else "not met"
            rows.append([name, method, ms(took), str(bar or "-"), verdict, repr(hit.time)])
    return table(["scene", "path", "ms", "bar", "", "time"], rows)


ALONE = """
import re
import firstcontact as fc
from firstcontact.examples.choi import example_7, example_8
for a, b in (example_7(), example_8()):
    for method in METHODS:
        fc.first_contact(a, b, method=method)
print(re.search(r"VmHWM:\\s*(\\d+) kB", open("/proc/self/status").read())[1])  # getrusage tells the parent's, too
"""


def alone() -> list[str]:
    """Peak memory of processes that answer Examples 7 and 8 and load no other tool, and how long they take."""
    if not File("/proc/self/status").exists():
        return ["Peak memory is read from /proc, which is not here.", ""]
    rows = []
    with tempfile.TemporaryDirectory() as cache:
        for what, methods in (
            ("certified, first process (compiles)", ("auto",)),
            ("certified", ("auto",)),
            ("certified and algebraic", ("auto", "algebraic")),
        ):
            start = perf_counter()
            done = subprocess.run(
                [sys.executable, "-c", f"METHODS = {methods!r}\n{ALONE}"],
                env={**os.environ, "FIRSTCONTACT_CACHE": cache}, capture_output=True, text=True, check=True,
            )  # fmt: skip
            seconds, peak = perf_counter() - start, float(done.stdout) / 1e3
            bar = "" if "compiles" in what else "met" if peak <= 400 else "not met"
            rows.append([what, f"{seconds:.2f}", f"{peak:.0f}", bar])
    return table(["fresh process: Examples 7 and 8", "s", "peak MB", "bar 400"], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--motions", type=int, default=12)
    parser.add_argument("--quick", action="store_true", help="1 repeat, 3 motions, meshes up to 1e4")
    parser.add_argument("--primitives", action="store_true", help="convex primitives beside coal only, not written")
    parser.add_argument("--out", type=File, default=File(__file__).parent)
    options = parser.parse_args()
    repeats, count, sizes = options.repeats, options.motions, SIZES
    if options.quick:
        repeats, count, sizes = 1, 3, SIZES[:2]
    if options.primitives:
        for kind in ("screw", "translation"):
            print(f"## Convex primitives: {kind}s\n")
            print("\n".join(primitives(kind, count, repeats, installed(["coal"])[0])))
        return
    peers, missing = installed(list(PEERS))
    lines = ["# Curved solids", "", f"Medians in ms of {repeats} repeats over {count} motions a pair"]
    lines += [f"({SLOW_MOTIONS} motions, once each, for OpenCASCADE). In brackets: how many times our time; `!`: we"]
    lines += ["take more than 1.5 times as long as coal. README.md tells what is asked.", ""]
    lines += [f"Not installed: {', '.join(missing)}.", ""] if missing else []
    lines += ["## Worked examples", "", *examples(repeats), *alone()]
    for kind in ("screw", "translation"):
        print(f"primitives, {kind}s", file=sys.stderr, flush=True)
        lines += [f"## Convex primitives: {kind}s", "", *primitives(kind, count, repeats, peers)]
    print("parts", file=sys.stderr, flush=True)
    lines += ["## Parts with holes", "", *parts(repeats, peers)]
    print("meshes", file=sys.stderr, flush=True)
    lines += ["## Triangle meshes of the same solids, in coal: a screw", "", *meshes(repeats, peers, sizes)]
    (options.out / "CURVED.md").write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
