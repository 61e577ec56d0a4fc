"""Mesh files through trimesh, coordinates untouched."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.errors import InputError

FORMATS = (".stl", ".obj", ".ply", ".off", ".gltf", ".glb")


def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64 and triangles (m, 3) int64 of a mesh file, in the file's order.

    The coordinates are those of the file; only vertices with equal coordinates become one (the first).
    Several geometries in one file become one mesh, each in its place.  Polygons arrive
    as triangles, cut into fans from their first corner: triangulate a file with non-convex ones beforehand.
    """
    path = Path(path)
    mesh = _load(path)
    vertices = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    triangles = np.asarray(getattr(mesh, "faces", ()), dtype=np.int64).reshape(-1, 3)
    if not len(triangles):
        raise InputError(f"{path}: holds no faces; export the model as a triangle mesh")
    outside = (triangles < 0) | (triangles >= len(vertices))
    if outside.any():
        face = int(np.argmax(outside.any(axis=1)))
        raise InputError(f"{path}: face {face} names a vertex that is not there; export the file again")
    bad = ~np.isfinite(vertices).all(axis=1)
    if bad.any():
        raise InputError(f"{path}: vertex {int(np.argmax(bad))} is not finite; repair the file")
    return weld(vertices, triangles)


def write_mesh(path: str | Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Write vertices (n, 3) and triangles (m, 3); the suffix chooses the format (STL is binary float32)."""
    import trimesh

    path = Path(path)
    _check_format(path)
    mesh = trimesh.Trimesh(np.asarray(vertices, np.float64), np.asarray(triangles), process=False)
    try:
        mesh.export(path)
    except OSError as error:
        raise InputError(f"{path}: {_reason(error)}; choose a place that can be written") from error


def weld(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same mesh with one vertex per distinct coordinate triple, numbered by first appearance.

    vertices: (n, 3) float64, finite.  triangles: (m, 3) integer.  Equality is that of numbers: -0.0 is 0.0.
    """
    order = np.lexsort(vertices.T)  # stable, so each run of equal rows begins with its lowest number
    ordered = vertices[order]
    starts = np.ones(len(order), dtype=bool)
    starts[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    first = np.empty(len(order), dtype=np.int64)
    first[order] = order[starts][np.cumsum(starts) - 1]
    kept = first == np.arange(len(first))
    number = np.cumsum(kept) - 1
    return vertices[kept], number[first][triangles]


def _load(path: Path) -> Any:
    _check_format(path)
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "no such file"
        raise InputError(f"{path}: {what}; give the path of a mesh file ({_list(FORMATS)})")
    import trimesh

    try:
        return trimesh.load(str(path), force="mesh", process=False, maintain_order=True)
    except OSError as error:
        raise InputError(f"{path}: {_reason(error)}; check that the file can be read") from error
    except Exception as error:  # readers of damaged files raise anything, from KeyError to struct.error
        raise InputError(f"{path}: {_cure(path)} (reader: {type(error).__name__}: {error})") from error


def _check_format(path: Path) -> None:
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: unknown mesh format {path.suffix!r}; use one of {_list(FORMATS)}")


def _cure(path: Path) -> str:
    if path.suffix.lower() == ".off":
        return "not readable as OFF; OFF files may hold triangles only: triangulate it or export OBJ or PLY"
    return f"not readable as {path.suffix[1:].upper()}; export the file again or convert it to PLY"


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _list(names: Sequence[str]) -> str:
    return ", ".join(names)
