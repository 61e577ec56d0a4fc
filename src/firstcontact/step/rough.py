"""Triangles of a solid as OpenCASCADE cuts them, to take points from and to look at its volume: how far they are from
its faces is measured, not proved (`triangles` does that)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firstcontact.step.charts import Elementary
from firstcontact.step.solids import StepSolid
from firstcontact.step.triangles import check_tiling, cut_by, triangles_of


@dataclass(frozen=True)
class Rough:
    """corners: (n, 3, 3) on the faces, outward; face_of: (n,) their numbers; deviation: of middles of triangles and of
    their sides from the surfaces, at most."""

    corners: np.ndarray
    face_of: np.ndarray
    deviation: float


def rough(solid: StepSolid, deviation: float) -> Rough:
    """Of a solid of planes, cylinders, cones, spheres and tori.  InputError names a face that cannot be cut."""
    return cut_by(solid, deviation, lambda: _all(solid))


_MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [1 / 3, 1 / 3, 1 / 3]])


def _all(solid: StepSolid) -> Rough:
    corners, owners, off = [], [], 0.0
    for number in range(len(solid.faces)):
        found = triangles_of(solid, number)
        uv, which = np.array(found.uv), np.array(found.triangles)
        check_tiling(solid, number, uv, which)
        chart = Elementary(found.surface)
        places = chart.at(uv)
        middles = (_MIDDLES @ places[which]).reshape(-1, 3)
        away = chart.at(chart.parameters(middles, 0.0)) - middles
        off = max(off, float(np.linalg.norm(away, axis=1).max()))
        corners.append(places[which[:, ::-1] if found.flipped else which])
        owners.append(np.full(len(which), number))
    return Rough(np.concatenate(corners), np.concatenate(owners), off)
