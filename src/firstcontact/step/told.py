"""What `firstcontact info` tells of a STEP file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

from firstcontact.step.assembly import Assembly, load_step

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face

KINDS = {
    "Plane": ("plane", "planes"), "CylindricalSurface": ("cylinder", "cylinders"),
    "ConicalSurface": ("cone", "cones"), "SphericalSurface": ("sphere", "spheres"),
    "ToroidalSurface": ("torus", "tori"), "BSplineSurface": ("B-spline", "B-splines"),
    "BezierSurface": ("Bezier surface", "Bezier surfaces"), "OffsetSurface": ("offset surface", "offset surfaces"),
    "SurfaceOfRevolution": ("surface of revolution", "surfaces of revolution"),
    "SurfaceOfLinearExtrusion": ("extruded surface", "extruded surfaces"),
}  # fmt: skip


def lines(file: str, surfaces: bool | None = None) -> Iterator[str]:
    """The tree with a line for each part: faces by kind, size, and how exact it is, or why it is not."""
    root = load_step(file, surfaces=surfaces)
    parts = root.parts
    products = len({id(part._shape) for part in parts})
    of = "" if products == len(parts) else f" of {products} kinds"
    count = f"{len(parts)} part{'' if len(parts) == 1 else 's'}"
    yield f"{file}: {count}{of}, lengths in {root.unit}"
    told: dict[int, str] = {}
    for node, depth in _below(root, 0):
        name = node.name + (f" ({node.product})" if node.product not in ("", node.name) else "")
        yield "  " * (depth + 1) + name + ("" if node.children else f": {_part(node, told)}")


def _below(node: Assembly, depth: int) -> Iterator[tuple[Assembly, int]]:
    yield node, depth
    for child in node.children:
        yield from _below(child, depth + 1)


def _part(part: Assembly, told: dict[int, str]) -> str:
    key = id(part._shape)
    if key not in told:
        told[key] = _told(part)
    return told[key]


def _told(part: Assembly) -> str:
    made = part.built()
    kinds = Counter(_kind(face) for x in made for face in x.solid.faces)
    count = sum(kinds.values())
    faces = ", ".join(f"{n} {KINDS.get(kind, (kind, kind))[n > 1]}" for kind, n in kinds.most_common())
    solids = "" if len(made) == 1 else f"{len(made)} solids, "
    lo = [min(x.solid.box[0][k] for x in made) for k in range(3)]
    hi = [max(x.solid.box[1][k] for x in made) for k in range(3)]
    size = " x ".join(f"{b - a:.6g}" for a, b in zip(lo, hi, strict=True))
    deviation = max(x.deviation for x in made)
    if not all(x.exact for x in made):
        reasons = " and ".join(dict.fromkeys(x.why for x in made if x.why is not None))
        kind = f"triangles, within {deviation:.2g} of its faces: {reasons}"
    elif deviation == 0.0:
        kind = "exact"
    else:
        kind = f"exact surfaces, corners and edges within {deviation:.2g} of the file's"
    return f"{solids}{count} face{'' if count == 1 else 's'} ({faces}), size {size}; {kind}"


def _kind(face: TopoDS_Face) -> str:
    from OCP.BRep import BRep_Tool

    surface = BRep_Tool.Surface_s(face)
    while surface.DynamicType().Name() == "Geom_RectangularTrimmedSurface":
        surface = surface.BasisSurface()
    return str(surface.DynamicType().Name().removeprefix("Geom_"))
