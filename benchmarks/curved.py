"""Curved solids: first contact of convex primitives against coal's primitives in a conservative loop, and the worked
examples of Choi et al. 2014 on both paths.

    python benchmarks/curved.py [--repeats 7] [--out DIR]

writes CURVED.md.  coal proves nothing near the contact: its loop ends when the pair is within 1e-9 of the span.
"""

from __future__ import annotations

import argparse
import math
import resource
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import firstcontact as fc
from firstcontact.worked_examples import example_7, example_8

TOLERANCE = 1e-9
SEED = 2014
MOTIONS = 12


def ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3f}"


# -- convex primitives --------------------------------------------------------------------------------------------

SHAPES = {
    "sphere": (lambda: fc.sphere(1), lambda coal: coal.Sphere(1.0), 0.0, 1.0),
    "ellipsoid": (lambda: fc.ellipsoid((1, "3/4", "1/2")), lambda coal: coal.Ellipsoid(1.0, 0.75, 0.5), 0.0, 1.0),
    "cylinder": (lambda: fc.cylinder("3/4", 2), lambda coal: coal.Cylinder(0.75, 2.0), 0.0, 1.25),
    "cone": (lambda: fc.cone("3/4", 2), lambda coal: coal.Cone(0.75, 2.0), 1.0, 2.0),
    "box": (lambda: fc.box((1, 2, "3/2")), lambda coal: coal.Box(1.0, 2.0, 1.5), 0.0, math.sqrt(1.8125)),
}
PAIRS = (
    ("sphere", "box"),
    ("ellipsoid", "ellipsoid"),
    ("cylinder", "cylinder"),
    ("cylinder", "cone"),
    ("cone", "cone"),
    ("ellipsoid", "box"),
    ("box", "box"),
)
"""name: our solid, coal's, the height of coal's centre above our origin, the farthest point from our origin."""


def motions(rng, kind: str) -> list[tuple[fc.Screw | fc.Translation, np.ndarray]]:
    """Screws or translations of the first body that mostly end in contact, and where the second one rests."""
    found = []
    for _ in range(MOTIONS):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        screw = fc.Screw(direction, point=rng.uniform(-0.3, 0.3, 3), degrees=float(rng.uniform(-90, 90)), advance=6.0)
        place = 4.0 * direction + rng.uniform(-0.4, 0.4, 3)
        found.append((screw if kind == "screw" else fc.Translation(6.0 * direction), place))
    return found


def top_speed(motion, reach: float) -> float:
    """No point of the first body is faster: the advance, and the angle times the distance to the axis."""
    if isinstance(motion, fc.Translation):
        return 6.0
    axis = np.array([float(x) for x in motion.axis])
    point = np.array([float(x) for x in motion.point])
    off = point - axis * (point @ axis) / (axis @ axis)
    return 6.0 + abs(motion.radians) * (reach + np.linalg.norm(off))


def coal_time(coal, shapes, motion, place, lifts, reach) -> float | None:
    """Conservative advancement."""
    speed = top_speed(motion, reach)
    rest = coal.Transform3s(np.eye(3), np.array(place) + [0.0, 0.0, lifts[1]])
    request = coal.DistanceRequest()
    request.enable_signed_distance = False
    t = 0.0
    while t <= 1.0:
        pose = motion(t)
        moved = coal.Transform3s(pose[:3, :3], pose[:3, :3] @ [0.0, 0.0, lifts[0]] + pose[:3, 3])
        result = coal.DistanceResult()
        step = coal.distance(shapes[0], moved, shapes[1], rest, request, result) / speed
        if step <= TOLERANCE:
            return t
        t += step
    return None


def primitives(repeats: int, kind: str) -> list[str]:
    import coal

    rows = ["| pair | firstcontact ms | coal ms | ratio | bar 1.5 | largest difference of the times |",
            "|---|---|---|---|---|---|"]  # fmt: skip
    for names in PAIRS:
        (make_a, coal_a, lift_a, reach), (make_b, coal_b, lift_b, _) = (SHAPES[name] for name in names)
        a, b = make_a(), make_b()
        shapes = coal_a(coal), coal_b(coal)
        ours, theirs, differences = [], [], []
        for motion, place in motions(np.random.default_rng(SEED), kind):
            moving, resting = a.moving(motion), b.translated(place.tolist())
            hit = fc.first_contact(moving, resting)
            for _ in range(repeats):
                start = perf_counter()
                hit = fc.first_contact(moving, resting)
                middle = perf_counter()
                other = coal_time(coal, shapes, motion, place, (lift_a, lift_b), reach)
                ours.append(middle - start)
                theirs.append(perf_counter() - middle)
            if (hit.time is None) != (other is None):
                differences.append(math.inf)
            elif hit.time is not None and hit.status is fc.Status.CONTACT:
                differences.append(abs(hit.time - other))
        ratio = median(ours) / median(theirs)
        verdict = "met" if ratio <= 1.5 else "slower than the bar"
        cells = ms(median(ours)), ms(median(theirs)), f"{ratio:.2f}", verdict, f"{max(differences, default=0.0):.1e}"
        rows.append(f"| {names[0]} / {names[1]} | {' | '.join(cells)} |")
    return rows


# -- the worked examples ------------------------------------------------------------------------------------------


def examples(repeats: int) -> list[str]:
    rows = ["| scene | path | ms | bar | | time |", "|---|---|---|---|---|---|"]
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
            verdict = "" if bar is None else "met" if 1e3 * took <= bar else "slower than the bar"
            rows.append(f"| {name} | {method} | {ms(took)} | {bar or '-'} | {verdict} | {hit.time!r} |")
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent)
    options = parser.parse_args()
    lines = ["# Curved solids", "", f"Medians of {options.repeats} repeats over {MOTIONS} motions a pair.", ""]
    lines += ["## Worked examples", "", *examples(options.repeats), ""]
    for kind in ("screw", "translation"):
        lines += [f"## Convex primitives against coal: {kind}s", "", *primitives(options.repeats, kind), ""]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    lines += [f"Peak memory of this process, coal included: {peak:.0f} MB (bar 400).", ""]
    (options.out / "CURVED.md").write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
