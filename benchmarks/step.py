"""Parts of STEP files: how long they load, whether they are what the file has, and queries beside OpenCASCADE.

python benchmarks/step.py [FOLDER WITH FURTHER .stp FILES]      writes benchmarks/STEP.md

Times are of the processor.  OpenCASCADE has no first contact: it is asked for the distance of the two shapes in a loop
that goes on by the distance over the speed, until the distance is below 1e-6 of the size.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

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

POINTS, CLOSE, MOST_STEPS = 100_000, 1e-6, 200


def loaded(path):
    begin = time.process_time()
    root = fc.load_step(path)
    body = root.body
    return root, body, time.process_time() - begin


def wrong_points(root, body, rng):
    """Of points in its box those on which the body and OpenCASCADE differ, beyond the deviation, and all asked."""
    asked = BRepClass3d_SolidClassifier(root._shape.shape)
    lo, hi = body.bounds()
    points = rng.uniform(lo, hi, (POINTS, 3))
    ours = body.contains(points)
    theirs = np.zeros(len(points), bool)
    for k, p in enumerate(points.tolist()):
        asked.Perform(gp_Pnt(*p), 1e-9)
        theirs[k] = asked.State() == TopAbs_State.TopAbs_IN
    shell = TopExp_Explorer(root._shape.shape, TopAbs_ShapeEnum.TopAbs_SHELL).Current()
    far = 0
    for k in np.flatnonzero(ours != theirs):
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*points[k].tolist())).Vertex()
        far += BRepExtrema_DistShapeShape(vertex, shell).Value() > body.deviation + 1e-7
    return far


def placed(shape, vector):
    trsf = gp_Trsf()
    trsf.SetTranslation(gp_Vec(*vector))
    return shape.Moved(TopLoc_Location(trsf))


def conservative(a, b, start, vector, size):
    """(time or None, distances asked) of a that moves along the vector."""
    t, speed = 0.0, float(np.linalg.norm(vector))
    for step in range(1, MOST_STEPS + 1):
        gap = BRepExtrema_DistShapeShape(placed(a, start + t * vector), b).Value()
        if gap < CLOSE * size:
            return t, step
        t += gap / speed
        if t > 1.0:
            return None, step
    return t, MOST_STEPS


def pointed(radius, length):
    """A pin with a point at the origin."""
    tip = BRepPrimAPI_MakeCone(0.0, radius, 2 * radius).Shape()
    return BRepAlgoAPI_Fuse(tip, placed(BRepPrimAPI_MakeCylinder(radius, length).Shape(), (0, 0, 2 * radius))).Shape()


def pairs(name, root, body, rng, count=9):
    """A row: a pointed pin comes to the part from several sides."""
    lo, hi = body.bounds()
    size = float((hi - lo).max())
    middle = 0.5 * (lo + hi)
    shape = root._shape.shape
    pin = pointed(0.03 * size, 0.3 * size)
    ours = fc.from_shape(pin, name="pin", unit=root.unit)
    ours_each, theirs_each, off, steps = [], [], 0.0, []
    for _ in range(count):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        start = middle + 2.0 * size * direction + rng.uniform(-0.2, 0.2, 3) * size
        vector = -2.5 * size * direction
        moving = ours.translated(start.tolist()).moving(fc.Translation(vector.tolist()))
        fc.first_contact(moving, body)  # what is worked out once for a body
        begin = time.process_time()
        hit = fc.first_contact(moving, body)
        ours_each.append(time.process_time() - begin)
        begin = time.process_time()
        when, asked = conservative(pin, shape, start, vector, size)
        theirs_each.append(time.process_time() - begin)
        steps.append(asked)
        if hit.time is not None:
            before, after = (
                BRepExtrema_DistShapeShape(placed(pin, start + t * vector), shape).Value()
                for t in (hit.time - 1e-6, hit.time + 1e-6)
            )
            off = max(off, after, 0.0 if before > 0.0 else np.inf)
        else:
            off = max(off, 0.0 if when is None else np.inf)
    ratio = np.array(theirs_each) / np.array(ours_each)
    return [name, f"{1e3 * np.median(ours_each):.1f}", f"{1e3 * np.median(theirs_each):.0f}", int(np.median(steps)),
            f"{np.median(ratio):.0f}", f"{off / size:.1e}"]  # fmt: skip


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in lines)


def main():
    folder = Path(tempfile.mkdtemp())
    paths = step_parts.write(folder)
    if len(sys.argv) > 1:
        paths += sorted(x for x in Path(sys.argv[1]).iterdir() if x.suffix.lower() in (".stp", ".step"))
    loads, queries = [], []
    rng = np.random.default_rng(0)
    for path in paths:
        root, body, seconds = loaded(path)
        faces = sum(len(made.solid.faces) for part in root.parts for made in part.built())
        triangles = sum(len(getattr(piece.body, "triangles", ())) for piece in body.pieces)
        kind = f"exact, {len(body.pieces)} pieces" if root.exact else f"{triangles:,} triangles"
        single = root._shape is not None
        wrong = wrong_points(root, body, rng) if single and root.exact else ""
        loads.append([path.stem, len(root.parts), faces, f"{seconds:.1f}", kind, f"{body.deviation:.1e}", wrong])
        print(*loads[-1], flush=True)
        if single:
            queries.append(pairs(path.stem, root, body, rng))
            print(*queries[-1], flush=True)
    text = f"""# STEP files

Written by `python benchmarks/step.py`; the first three parts are made by `step_parts.py`.  Loading is from the file to
the body; wrong: of {POINTS:,} points in the box of an exact part those that OpenCASCADE has on the other side, beyond
the deviation.

{table(["file", "parts", "faces", "s to load", "body", "deviation", "wrong"], loads)}

A pointed pin comes to the part from nine sides.  The loop: OpenCASCADE's distance, over the speed.  The last column is
the distance that OpenCASCADE finds 1e-6 of the motion after our contact, as a part of the size (infinite where it finds
none before, or where we find none and it does).  Medians; a first query, which works out trees and charts, is left out.

{table(["part", "ms", "ms of the loop", "its steps", "ratio", "off"], queries)}
"""
    (Path(__file__).parent / "STEP.md").write_text(text)


if __name__ == "__main__":
    main()
