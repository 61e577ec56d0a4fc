"""The families of `growth.py`: encounters of size n, and the ways to ask a tool about them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from firstcontact import Polyhedron, Translation, examples
from firstcontact.examples import Encounter
from scenes import Scene

CUTS = (1, 4, 16, 64, 256)
"""Pieces per rod that the box tree is tried with."""


@dataclass(frozen=True)
class Family:
    """n rods or facets a body.  kind: "rods" (bare edges), "facets" (points against facets) or "solids"."""

    name: str
    motion: str
    kind: str
    make: Callable[[int], Encounter]


def _families() -> list[Family]:
    found = []
    for motion in ("translation", "rotation"):
        turning = motion == "rotation"
        for name, make in {
            "layered reguli": examples.layered_reguli,
            "tilted reguli": lambda n, **how: examples.layered_reguli(n, tilted=True, **how),
            "near-miss combs": examples.near_miss_combs,
            "woven reguli": examples.woven_reguli,
            "woven rods": examples.woven_rods,
        }.items():
            found.append(Family(name, motion, "rods", lambda n, make=make, t=turning: make(n, turning=t)))
        if turning:
            found.append(Family("nested hyperboloids", motion, "rods", examples.nested_hyperboloids))
        found.append(
            Family("slats over points", motion, "facets", lambda n, t=turning: examples.slats_over_points(n, turning=t))
        )
        found.append(
            Family("tangent plates", motion, "facets", lambda n, t=turning: examples.tangent_plates(n, turning=t))
        )
        if turning:
            found.append(Family("nested shells", motion, "facets", examples.nested_shells))
            found.append(Family("two convex bodies", motion, "solids", examples.convex_pair))
        found.append(
            Family(
                "closed layered reguli",
                motion,
                "solids",
                lambda n, t=turning: examples.layered_reguli(n, closed=True, turning=t),
            )
        )
    found.append(
        Family(
            "closed hyperboloids", "rotation", "solids", lambda n: examples.nested_hyperboloids(n, closed=True)
        )
    )
    return found


FAMILIES = _families()


def cut(encounter: Encounter, pieces: int) -> Encounter:
    """The rods as chains of that many edges; inner ends are rounded, which moves the contact by as much."""
    return replace(encounter, a=_cut(encounter.a, pieces), b=_cut(encounter.b, pieces))


def _cut(rods: Polyhedron, pieces: int) -> Polyhedron:
    ends = rods.vertices[rods.edges]
    step = np.linspace(0.0, 1.0, pieces + 1)[None, :, None]
    points = ends[:, :1] * (1.0 - step) + ends[:, 1:] * step
    first = np.arange(len(ends))[:, None] * (pieces + 1) + np.arange(pieces)
    return Polyhedron(points.reshape(-1, 3), [], edges=np.stack([first, first + 1], axis=-1).reshape(-1, 2))


def peer_scene(family: Family, encounter: Encounter) -> Scene:
    """The solids as the adapters of the other tools take them."""
    a, b, motion = encounter.a, encounter.b, encounter.motion
    meshes = (np.array(a.vertices), np.array(a.triangles), np.array(b.vertices), np.array(b.triangles))
    if isinstance(motion, Translation):
        vector = np.array([float(x) for x in motion.vector])
        return Scene(family.name, *meshes, kind="translation", expect="contact", vector=vector)
    turn = 2.0 * np.pi if motion.unit == "turns" else 1.0
    return Scene(family.name, *meshes, kind="rotation", expect="contact", radians=turn * float(motion.angle))
