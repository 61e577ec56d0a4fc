"""Parts of STEP files: how long they load, whether they are what the file has, and queries beside OpenCASCADE.

python benchmarks/step.py [FOLDER WITH FURTHER .stp FILES]      writes benchmarks/STEP.md

Times are of the processor, of children too; loads and commands are processes of their own, so that imports and kernels
count.  OpenCASCADE has no first contact: it is asked for the distance of the two shapes in a loop that goes on by the
distance over the speed, until the distance is below 1e-6 of the size.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_State
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location

import firstcontact as fc
import step_parts
from firstcontact.step.written.text import checked
from step_scenes import assembly_scene, many_bodies

POINTS, CLOSE, MOST_STEPS, ROUNDING = 100_000, 1e-6, 200, 1e-7
SIDES, JUST = 25, 1e-6
LOAD_BAR, RATIO_BAR, SCENE_BAR, MANY_BAR, SCREEN = 5.0, 20.0, 10.0, 5.0, 50
LOAD = "import sys, firstcontact as fc; fc.load_step(sys.argv[1], surfaces=None if sys.argv[2] == '1' else False).body"
TOPOLOGY = {"face": "ADVANCED_FACE", "edge": "EDGE_CURVE", "vertex": "VERTEX_POINT"}


def cpu() -> float:
    """Seconds of the processor, of children that have ended too."""
    return sum(os.times()[:4])


def ran(*command: str, codes: tuple[int, ...] = (0,)) -> tuple[float, str]:
    """(seconds of the processor, text) of a process."""
    begin = cpu()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in codes:
        raise RuntimeError(f"{command}: {done.stderr}")
    return cpu() - begin, done.stdout


@dataclass
class Part:
    """A file's part as it is measured; off: the points on which the two differ beyond the deviation."""

    path: Path
    root: Any
    meshed: float
    own: float
    off: int | None = None
    queries: list[Query] = field(default_factory=list)

    @property
    def kind(self) -> str:
        pieces = self.root.body.pieces
        triangles = sum(len(getattr(piece.body, "triangles", ())) for piece in pieces)
        return f"exact, {len(pieces)} pieces" if self.root.exact else f"{triangles:,} triangles"


@dataclass(frozen=True)
class Query:
    """ours, theirs: seconds; before, after: OpenCASCADE's distances 1e-6 of the motion before and after our contact;
    late: how far our contact is behind that of the loop, along the normal; named: whether the face is where we met."""

    ours: float
    theirs: float
    steps: int
    before: float | None
    after: float | None
    late: float
    named: bool


def distance(a: Any, b: Any) -> float:
    return float(BRepExtrema_DistShapeShape(a, b).Value())


def vertex(point: Any) -> Any:
    return BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, point))).Vertex()


def wrong_points(root: Any, rng: np.random.Generator) -> int:
    """Of points in its box those on which the body and OpenCASCADE differ, beyond the deviation."""
    shape, body = root._shape.shape, root.body
    asked = BRepClass3d_SolidClassifier(shape)
    lo, hi = body.bounds()
    points = rng.uniform(lo, hi, (POINTS, 3))
    theirs = np.zeros(len(points), bool)
    for k, p in enumerate(points.tolist()):
        asked.Perform(gp_Pnt(*p), 1e-9)
        theirs[k] = asked.State() == TopAbs_State.TopAbs_IN
    shell = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SHELL).Current()
    differ = points[body.contains(points) != theirs]
    return sum(distance(vertex(p), shell) > body.deviation + ROUNDING for p in differ)


def placed(shape: Any, vector: Any) -> Any:
    trsf = gp_Trsf()
    trsf.SetTranslation(gp_Vec(*map(float, vector)))
    return shape.Moved(TopLoc_Location(trsf))


def conservative(a: Any, b: Any, start: np.ndarray, vector: np.ndarray, size: float) -> tuple[float | None, int]:
    """(time or None, distances asked) of a that moves along the vector."""
    t, speed = 0.0, float(np.linalg.norm(vector))
    for step in range(1, MOST_STEPS + 1):
        gap = distance(placed(a, start + t * vector), b)
        if gap < CLOSE * size:
            return t, step
        t += gap / speed
        if t > 1.0:
            return None, step
    return t, MOST_STEPS


def pointed(radius: float, length: float) -> Any:
    """A pin with a point at the origin."""
    tip = BRepPrimAPI_MakeCone(0.0, radius, 2 * radius).Shape()
    return BRepAlgoAPI_Fuse(tip, placed(BRepPrimAPI_MakeCylinder(radius, length).Shape(), (0, 0, 2 * radius))).Shape()


def is_named(part: Part, hit: Any, kinds: dict[int, str]) -> bool:
    """Whether the file's face, edge or vertex that the answer names is where the bodies met."""
    element, (made,) = hit.element_b, part.root.built()
    solid = made.solid
    shape = {"face": solid.faces, "edge": solid.edges, "vertex": solid.vertices}[element.kind][element.index]
    entities = [kinds[int(x)] for x in re.findall(r"#(\d+)", element.label)]
    told = all(kind == TOPOLOGY[element.kind] for kind in entities) and bool(entities)
    return told and distance(vertex(hit.point), shape) <= hit.model_deviation + ROUNDING


def pairs(part: Part, rng: np.random.Generator) -> list[Query]:
    """A pointed pin comes to the part from several sides."""
    root, body = part.root, part.root.body
    lo, hi = body.bounds()
    size = float((hi - lo).max())
    middle = 0.5 * (lo + hi)
    shape, kinds = root._shape.shape, checked(part.path)
    pin = pointed(0.03 * size, 0.3 * size)
    ours = fc.from_shape(pin, name="pin", unit=root.unit)
    found = []
    for _ in range(SIDES):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        start = middle + 2.0 * size * direction + rng.uniform(-0.2, 0.2, 3) * size
        vector = -2.5 * size * direction
        moving = ours.translated(start.tolist()).moving(fc.Translation(vector.tolist()))
        fc.first_contact(moving, body)  # what is worked out once for a body
        begin = time.process_time()
        for _ in range(10):
            hit = fc.first_contact(moving, body)
        one = (time.process_time() - begin) / 10
        begin = time.process_time()
        when, asked = conservative(pin, shape, start, vector, size)
        other = time.process_time() - begin
        if hit.time is None or when is None:
            late = 0.0 if hit.status is fc.Status.FREE and when is None else np.inf
            found.append(Query(one, other, asked, None, None, late, True))
            continue
        sides = [distance(placed(pin, start + (hit.time + x) * vector), shape) for x in (-JUST, JUST)]
        along = abs(float(hit.normal @ vector)) if hit.normal is not None else 2.5 * size
        found.append(Query(one, other, asked, *sides, (hit.time - when) * along, is_named(part, hit, kinds)))
    return found


def row_of_queries(part: Part) -> tuple[list[str], bool, bool]:
    """(the row, whether the bar of speed holds, and those of the answers)."""
    queries, body = part.queries, part.root.body
    ratio = float(np.median([q.theirs / q.ours for q in queries]))
    before = min((q.before for q in queries if q.before is not None), default=0.0)
    after = max((q.after for q in queries if q.after is not None), default=0.0)
    late = max(q.late for q in queries)
    lo, hi = body.bounds()
    size = float((hi - lo).max())
    room = 2.0 * body.deviation + 3.0 * CLOSE * size
    right = late <= room and after <= room and (before > 0.0 or not part.root.exact) and all(q.named for q in queries)
    row = [
        part.path.stem, part.kind, f"{1e3 * np.median([q.ours for q in queries]):.1f}",
        f"{1e3 * np.median([q.theirs for q in queries]):.0f}", str(int(np.median([q.steps for q in queries]))),
        f"{ratio:.0f}", f"{before:.1e}", f"{after:.1e}", f"{late:.1e}", f"{room:.1e}",
        f"{sum(q.named for q in queries)} of {len(queries)}",
    ]  # fmt: skip
    return row, ratio >= RATIO_BAR, right


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


def measured(path: Path) -> Part:
    """Points and directions are drawn for each part from a seed of its own, whatever else is measured."""
    rng = np.random.default_rng(list(path.stem.encode()))
    meshed, own = (ran(sys.executable, "-c", LOAD, str(path), surfaces)[0] for surfaces in "01")
    part = Part(path, fc.load_step(path), meshed, own)
    if part.root._shape is not None:
        part.queries = pairs(part, rng)
        part.off = wrong_points(part.root, rng) if part.root.exact else None
    return part


def told(holds: bool) -> str:
    return "met" if holds else "**missed**"


def bars(parts: list[Part], scene: tuple[float, str], many: tuple[float, str]) -> str:
    exact = [part for part in parts if part.off is not None]
    queried = [(part, *row_of_queries(part)[1:]) for part in parts if part.queries]
    slow = [part.path.stem for part in parts if max(part.meshed, part.own) > LOAD_BAR]
    lines = many[1].count("\n")
    asked = [q for part in parts for q in part.queries]
    rows = [
        ["each part loads in under 5 s", f"{max(max(p.meshed, p.own) for p in parts):.1f} s at most", told(not slow)],
        ["exact parts agree with OpenCASCADE on 1e5 points", f"{sum(p.off or 0 for p in exact)} of "
         f"{POINTS * len(exact):,} differ beyond the deviation", told(not any(p.off for p in exact))],
        ["faces of the answers are the file's, where the bodies met", f"{sum(q.named for q in asked)} of {len(asked)}",
         told(all(q.named for q in asked))],
        ["20 times as fast as a loop over distances", ", ".join(f"{p.path.stem} {row_of_queries(p)[0][5]}" for p, *_ in
         queried), told(all(fast for _, fast, _ in queried))],
        ["its distance just before and after bears the answers out", ", ".join(p.path.stem for p, _, right in queried if
         not right) or "all", told(all(right for *_, right in queried))],
        ["as1, from file to table, under 10 s", f"{scene[0]:.1f} s", told(scene[0] < SCENE_BAR)],
        ["300 bodies, 44,850 pairs, under 5 s", f"{many[0]:.1f} s", told(many[0] < MANY_BAR)],
        ["and one screen of text", f"{lines} lines", told(lines <= SCREEN)],
    ]  # fmt: skip
    return table(["bar", "measured", ""], rows)


TEXT = """# STEP files

Written by `python benchmarks/step.py`; plate, gear and bracket are made by `step_parts.py`, the scenes by
`step_scenes.py`. Seconds are of the processor, in processes of their own, imports and kernels included.

{bars}

## Loading

From the file to the body, as triangles (`surfaces=False`) and as exact pieces where it can be had so; wrong: of
{points:,} points in the box of an exact part those that OpenCASCADE has on the other side, beyond the deviation.

{loads}

## Pairs

A pointed pin comes to the part from {sides} sides. The loop: OpenCASCADE's distance, over the speed. Before, after: the
least and the largest distance that OpenCASCADE finds 1e-6 of the motion before and after our contact (triangles are met
later than what they stand for: before may be 0). Late: how far our contact is behind the loop's at most, along the
normal (OpenCASCADE finds distances from afar that are too large, so that its loop may pass a contact; what comes before
it is judged by "after"). All of them in the unit of the file, and within "room": twice the deviation and three times
what the loop is off. Named: whether the entity of the file that the answer names is where the bodies met. Medians; a
first query, which works out trees and charts, is left out.

{queries}

## Scenes

All of as1: its three bolts go up 40 mm out of the first bracket, the rod turns; what touches at the start may.

```
{scene}```

300 nuts of as1 in a grid, of which every tenth moves, all pairs asked:

```
{many}```
"""


def main() -> None:
    folder = Path(tempfile.mkdtemp())
    paths = step_parts.write(folder)
    if len(sys.argv) > 1:
        paths += sorted(x for x in Path(sys.argv[1]).iterdir() if x.suffix.lower() in (".stp", ".step"))
    parts = []
    for path in paths:
        part = measured(path)
        parts.append(part)
        print(path.stem, f"{part.meshed:.1f} {part.own:.1f}", part.kind, part.off, flush=True)
        if part.queries:
            print(*row_of_queries(part), flush=True)
    whole = next(path for path in paths if path.stem.startswith("as1"))
    check = sys.executable, "-m", "firstcontact", "check"
    scene = ran(*check, str(assembly_scene(whole, folder)), codes=(0, 1, 2))
    many = ran(*check, str(many_bodies(whole, folder)), codes=(0, 1, 2))
    loads = [
        [p.path.stem, str(len(p.root.parts)), str(sum(len(x.solid.faces) for y in p.root.parts for x in y.built())),
         f"{p.meshed:.1f}", f"{p.own:.1f}", p.kind, f"{p.root.deviation:.1e}", "" if p.off is None else str(p.off)]
        for p in parts
    ]  # fmt: skip
    text = TEXT.format(
        bars=bars(parts, scene, many), points=POINTS, sides=SIDES, scene=scene[1], many=many[1],
        loads=table(["file", "parts", "faces", "s, triangles", "s, exact", "body", "deviation", "wrong"], loads),
        queries=table(
            ["part", "body", "ms", "ms of the loop", "its steps", "ratio", "before", "after", "late", "room", "named"],
            [row_of_queries(part)[0] for part in parts if part.queries],
        ),
    )  # fmt: skip
    (Path(__file__).parent / "STEP.md").write_text(text)


if __name__ == "__main__":
    main()
