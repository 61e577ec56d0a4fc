"""Solids of planes and quadrics that meet polyhedra: bare points, edges, triangles, convex and other meshes."""

from __future__ import annotations

from benchmarks.soaks.landing import landing
from benchmarks.soaks.piercing import pierced
from benchmarks.soaks.scene import Kind
from benchmarks.soaks.shapes import MESHES, SOLIDS
from benchmarks.soaks.starts import graze, known_start, nested, shallow

KINDS: tuple[Kind, ...] = (
    Kind("mixed/landing", "mesh, solid", lambda rng: landing(rng, MESHES, SOLIDS),
         "late, early and missed first contacts of convex bodies, wrong points and normals, false FREE at the ends of spans",
         "contacts of solids with holes and waists; what comes after the first contact"),
    Kind("mixed/shallow start", "mesh, solid", lambda rng: shallow(rng, MESHES, SOLIDS),
         "overlaps and gaps of 1e-1 to 1e-18 of the size taken for each other or for contact later; wrong `initial`",
         "starts in contact at several places"),
    Kind("mixed/graze", "mesh, solid", lambda rng: graze(rng, MESHES, SOLIDS),
         "contact of one instant that is missed, or told where bodies pass", "near misses"),
    Kind("mixed/mesh in solid", "mesh, solid", lambda rng: nested(rng, MESHES, SOLIDS),
         "containment that is missed", "when the inner body comes out"),
    Kind("mixed/solid in mesh", "mesh, solid", lambda rng: nested(rng, SOLIDS, MESHES[3:]),
         "containment that is missed", "when the inner body comes out"),
    Kind("mixed/piercing", "point, solid", pierced,
         "wrong times, intervals and points of a bare point through solids of all kinds, with holes, tips and edges of "
         "degree 4; grazes along tangents", "contacts that are not at a vertex"),
    Kind("mixed/tangent start", "mesh, solid", lambda rng: known_start(rng, True),
         "`initial` where bodies fit or touch along lines and surfaces, from inside and outside",
         "what comes after the start"),
)
