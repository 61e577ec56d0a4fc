"""Random machined parts, made by OpenCASCADE, as exact pieces beside its own classifier.

python benchmarks/step_random.py [COUNT [FIRST SEED]]      one line for each part, and those that differ
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_State
from OCP.TopExp import TopExp_Explorer

import firstcontact as fc
from firstcontact.step.cells import NotExact, cells_of
from firstcontact.step.reader import Shape
from firstcontact.step.solids import StepSolid

POINTS, ROUNDING = 2000, 1e-7
SIZE = np.array([40.0, 30.0, 12.0])


def upright(x: float, y: float, z: float) -> Any:
    return gp_Ax2(gp_Pnt(x, y, z), gp_Dir(0, 0, 1))


def drilled(shape: Any, x: float, y: float, rng: np.random.Generator) -> Any:
    return BRepAlgoAPI_Cut(shape, BRepPrimAPI_MakeCylinder(upright(x, y, -1), rng.uniform(1, 2.5), 14).Shape()).Shape()


def countersunk(shape: Any, x: float, y: float, rng: np.random.Generator) -> Any:
    r = rng.uniform(1, 2)
    sink = BRepPrimAPI_MakeCone(upright(x, y, 9), r, r + 3, 3).Shape()
    through = BRepPrimAPI_MakeCylinder(upright(x, y, -1), r, 14).Shape()
    return BRepAlgoAPI_Cut(BRepAlgoAPI_Cut(shape, through).Shape(), sink).Shape()


def slotted(shape: Any, x: float, y: float, rng: np.random.Generator) -> Any:
    w, h, deep = rng.uniform(1, 3), rng.uniform(2, 4), rng.uniform(2, 11)
    tool = BRepPrimAPI_MakeBox(gp_Pnt(x - w, y - h, 12 - deep), 2 * w, 2 * h, 20).Shape()
    return BRepAlgoAPI_Cut(shape, tool).Shape()


def stepped(shape: Any, x: float, y: float, rng: np.random.Generator) -> Any:
    low, r = rng.uniform(1, 4), rng.uniform(1.5, 3)
    boss = BRepPrimAPI_MakeCylinder(upright(x, y, 6), r + 1, 6 + low).Shape()
    hole = BRepPrimAPI_MakeCylinder(upright(x, y, 8), r, 20).Shape()
    return BRepAlgoAPI_Cut(BRepAlgoAPI_Fuse(shape, boss).Shape(), hole).Shape()


FEATURES: tuple[Callable[..., Any], ...] = (drilled, countersunk, slotted, stepped)


def part(seed: int) -> Any:
    """A block with two to six features, which do not meet."""
    rng = np.random.default_rng(seed)
    shape = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), *SIZE.tolist()).Shape()
    places = [(x, y) for x in (7.0, 20.0, 33.0) for y in (8.0, 22.0)]
    for k in rng.permutation(len(places))[: rng.integers(2, 7)].tolist():
        x, y = np.array(places[k]) + rng.uniform(-0.7, 0.7, 2)
        shape = FEATURES[rng.integers(0, len(FEATURES))](shape, float(x), float(y), rng)
    return shape


def differing(shape: Any, body: Any, points: np.ndarray) -> list[list[float]]:
    """The points on which the body and OpenCASCADE differ, farther than the deviation from the faces."""
    asked = BRepClass3d_SolidClassifier(shape)
    shell = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SHELL).Current()
    found = []
    for p, ours in zip(points.tolist(), body.contains(points).tolist(), strict=True):
        asked.Perform(gp_Pnt(*p), 1e-9)
        if ours != (asked.State() == TopAbs_State.TopAbs_IN):
            vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex()
            if BRepExtrema_DistShapeShape(vertex, shell).Value() > body.deviation + ROUNDING:
                found.append(p)
    return found


def why_not_exact(shape: Any) -> str:
    try:
        cells_of(StepSolid(shape, Shape(shape, "part")))
    except NotExact as reason:
        return str(reason)
    return "of planes"


def asked_points(body: Any, seed: int, count: int = POINTS) -> np.ndarray:
    """Half of them anywhere in the box, half of them near to the faces."""
    rng = np.random.default_rng(seed)
    lo, hi = body.bounds()
    mesh = body.shown[0].body
    corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), count // 2)]]
    near = np.einsum("nk,nkj->nj", rng.dirichlet((1, 1, 1), count // 2), corners)
    near += 10.0 ** rng.uniform(-4, -1, (len(near), 1)) * rng.normal(size=near.shape)
    return np.concatenate([rng.uniform(lo, hi, (count // 2, 3)), near])


def main() -> None:
    count, first = (int(x) for x in (sys.argv[1:] + ["30", "0"][len(sys.argv) - 1 :])[:2])
    wrong = flat = 0
    for seed in range(first, first + count):
        shape = part(seed)
        body = fc.from_shape(shape, name=f"part {seed}", surfaces=True)
        exact = sum(isinstance(piece.body, fc.CompositeQuadric) for piece in body.pieces)
        found = differing(shape, body, asked_points(body, seed)) if exact else []
        wrong += bool(found)
        flat += not exact
        kind = f"{exact} exact pieces" if exact else f"none exact ({why_not_exact(shape)})"
        print(f"seed {seed}: {kind}, deviation {body.deviation:.1e}, {len(found)} differ {found[:2]}", flush=True)
    print(f"{wrong} of {count} parts differ, {flat} have no exact pieces")


if __name__ == "__main__":
    main()
