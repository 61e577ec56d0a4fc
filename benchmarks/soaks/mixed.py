"""Solids of planes and quadrics that meet polyhedra: bare points, edges, triangles, convex and other meshes."""

from __future__ import annotations

from .crossing import crossing, drilled_landing
from .landing import landing
from .piercing import pierced
from .rounds import circling, pinned, straight
from .scene import Kind
from .solid_shapes import CREASED, MESHES, SOLIDS, any_half_space
from .stairs import stairs_and_pin
from .starts import graze, known_start, nested, shallow

PARTNERS = (*SOLIDS, any_half_space)
THICK = MESHES[3:]

KINDS: tuple[Kind, ...] = (
    Kind("mixed/landing", "mesh, solid", lambda rng: landing(rng, (*MESHES, *CREASED), PARTNERS),
         "late, early, missed first contacts of convex bodies, wrong points and normals, false FREE at ends of spans",
         "contacts of solids with holes and waists; what comes after the first contact"),
    Kind("mixed/drilled landing", "mesh, csg", lambda rng: drilled_landing(rng, MESHES, SOLIDS),
         "the same on models with holes, at edges of degree 4 and on the walls of unions", "contacts within holes"),
    Kind("mixed/crossing", "mesh, solid", lambda rng: crossing(rng, MESHES, SOLIDS),
         "false FREE and late contacts where bodies overlap well, early ones, planes of contact that cut into bodies",
         "exact times; thin overlaps and short contacts"),
    Kind("mixed/shallow start", "mesh, solid", lambda rng: shallow(rng, MESHES, SOLIDS),
         "overlaps and gaps of 1e-1 to 1e-18 of the size taken for each other or for contact later; wrong `initial`",
         "starts in contact at several places"),
    Kind("mixed/graze", "mesh, solid", lambda rng: graze(rng, MESHES, SOLIDS),
         "contact of one instant that is missed, or told where bodies pass", "near misses"),
    Kind("mixed/mesh in solid", "mesh, solid", lambda rng: nested(rng, MESHES, SOLIDS),
         "containment that is missed", "when the inner body comes out"),
    Kind("mixed/solid in mesh", "mesh, solid", lambda rng: nested(rng, SOLIDS, THICK),
         "containment that is missed", "when the inner body comes out"),
    Kind("mixed/tangent start", "mesh, solid", lambda rng: known_start(rng, True),
         "`initial` where bodies fit or touch along lines and surfaces, from inside and outside",
         "what comes after the start"),
    Kind("mixed/piercing", "point, solid", pierced,
         "wrong times, intervals and points of a bare point through solids of all kinds, with holes, tips and edges of "
         "degree 4; grazes along tangents", "contacts that are not at a vertex"),
    Kind("mixed/straight ball", "box mesh, ball", lambda rng: straight(rng, True),
         "wrong times and intervals at faces, edges and corners", "grazes"),
    Kind("mixed/circling point", "point, solid", lambda rng: circling(rng, True),
         "wrong times and intervals under rotations and screws, over several turns, in spans that start in mid-turn",
         "grazes and touching at the ends of spans"),
    Kind("mixed/pin in a bore", "pin mesh, csg", lambda rng: pinned(rng, True),
         "false contacts at clearances down to 1e-12, missed ones where the pin fits exactly or not at all",
         "pins that tilt"),
    Kind("mixed/stairs and a pin", "pin, mesh", stairs_and_pin,
         "late first contacts among many triangles, wrong or undecided intervals at tips, rims and edges, far off too",
         "contact of depths below 1e-8, times nearer to an end than 1e-5 of what lies between two"),
)
