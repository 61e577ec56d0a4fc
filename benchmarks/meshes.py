"""Scenes from mesh files: neighbours in the sorted folder move into one another."""

from __future__ import annotations

from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np

from firstcontact import Polyhedron
from scenes import Scene

SUFFIXES = {".obj", ".ply", ".stl", ".off", ".glb"}


def mesh_scenes(folder: Path) -> list[Scene]:
    """A translation and a quarter turn for every two neighbours; the last and the first are such too."""
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    bodies = [_unit_mesh(path) for path in files]
    ring = bodies + bodies[:1] if len(bodies) > 2 else bodies
    return [scene for a, b in pairwise(ring) for scene in (_shift(a, b), _quarter_turn(a, b))]


def _unit_mesh(path: Path) -> tuple[str, np.ndarray, np.ndarray]:
    """Name, vertices and triangles; the box about it is centred and its longest edge is 1."""
    body = Polyhedron.load(path)
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    vertices = (body.vertices - (low + high) / 2.0) / np.max(high - low)
    return path.stem, vertices, np.array(body.triangles)


def _shift(a: tuple, b: tuple) -> Scene:
    """a comes from the side, obliquely, as far as b's centre."""
    start, vector = np.array([1.3, 0.1, 0.05]), np.array([-1.3, -0.1, 0.02])
    name = f"mesh translation {a[0]} into {b[0]}"
    return Scene(name, a[1] + start, a[2], b[1], b[2], "translation", "unknown", vector=vector)


def _quarter_turn(a: tuple, b: tuple) -> Scene:
    """a turns about the z axis, which passes outside both, to where b stands."""
    name = f"mesh rotation {a[0]} into {b[0]}"
    va, vb = a[1] + np.array([1.2, 0.0, 0.0]), b[1] + np.array([0.0, 1.2, 0.0])
    return Scene(name, va, a[2], vb, b[2], "rotation", "unknown", radians=pi / 2)
