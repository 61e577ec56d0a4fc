"""Mesh files, coordinates untouched: STL, OBJ, PLY and OFF with their polygons, glTF through trimesh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.body.polyhedron.triangulate import shapes, triangulate
from firstcontact.errors import InputError
from firstcontact.interrupts import interrupted_after
from firstcontact.io.polygon_files import Faces, read_obj, read_off, read_ply
from firstcontact.io.stl_files import read_stl

FORMATS = (".stl", ".obj", ".ply", ".off", ".gltf", ".glb")
READERS: dict[str, Callable[[Path], tuple[np.ndarray, np.ndarray | Faces]]] = {
    ".stl": read_stl, ".obj": read_obj, ".ply": read_ply, ".off": read_off,
}  # fmt: skip


def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray | Faces]:
    """Vertices (n, 3) float64 and faces of a mesh file, in the file's order.

    Faces are an (m, 3) int64 array, or a list of polygons where one has more than three corners.  Polygons that are
    not planar come as triangles, numbered in their place.
    The coordinates are those of the file; only vertices with equal coordinates become one (the first).
    Several geometries in one file become one mesh, each in its place.
    """
    if not isinstance(path, str | Path):
        raise InputError(f"{path!r} is no path; give the path of a mesh file as text")
    path = Path(path)
    vertices, faces = _load(path)
    if not len(faces):
        raise InputError(f"{path}: holds no faces; export the model as a mesh with faces")
    sizes = [len(face) for face in faces]
    if min(sizes) < 3:
        at = int(np.argmin(sizes))
        raise InputError(f"{path}: face {at} has {sizes[at]} corners; give at least three")
    corners = np.concatenate(faces)
    outside = np.flatnonzero((corners < 0) | (corners >= len(vertices)))
    if outside.size:
        face = int(np.searchsorted(np.cumsum(sizes), outside[0], side="right"))
        raise InputError(f"{path}: face {face} names a vertex that is not there; export the file again")
    bad = ~np.isfinite(vertices).all(axis=1)
    if bad.any():
        raise InputError(f"{path}: vertex {int(np.argmax(bad))} is not finite; repair the file")
    if max(sizes) > 3:
        faces = _unwarped(vertices, list(faces), path)
    return weld(vertices, np.array(faces, np.int64) if max(map(len, faces)) == 3 else faces)


def _unwarped(vertices: np.ndarray, faces: Faces, path: Path) -> Faces:
    """The faces with those that are not planar cut into triangles, whose common sides are true edges."""
    kept: Faces = []
    planar = np.ones(len(faces), bool)
    sizes = np.array([len(face) for face in faces])
    for size in np.unique(sizes[sizes > 3]):
        alike = np.flatnonzero(sizes == size)
        planar[alike] = shapes(vertices, np.array([faces[f] for f in alike]))[0]
    for f, face in enumerate(faces):
        cut = [face] if planar[f] else triangulate(vertices, [face], f"{path}: face {f}", warped=True)
        kept += [list(corners) for corners in cut]
    return kept


def write_mesh(path: str | Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Write vertices (n, 3) and triangles (m, 3); the suffix chooses the format (STL is binary float32)."""
    with interrupted_after():
        import trimesh

    path = Path(path)
    _check_format(path)
    mesh = trimesh.Trimesh(np.asarray(vertices, np.float64), np.asarray(triangles), process=False)
    try:
        mesh.export(path)
    except OSError as error:
        raise InputError(f"{path}: {_reason(error)}; choose a place that can be written") from error


def weld(vertices: np.ndarray, faces: np.ndarray | Faces) -> tuple[np.ndarray, np.ndarray | Faces]:
    """The same mesh with one vertex per distinct coordinate triple, numbered by first appearance.

    vertices: (n, 3) float64, finite.  faces: (m, 3) integer, or polygons.  Equality is that of numbers: -0.0 is 0.0.
    """
    order = np.lexsort(vertices.T)  # stable, so each run of equal rows begins with its lowest number
    ordered = vertices[order]
    starts = np.ones(len(order), dtype=bool)
    starts[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    first = np.empty(len(order), dtype=np.int64)
    first[order] = order[starts][np.cumsum(starts) - 1]
    kept = first == np.arange(len(first))
    number = (np.cumsum(kept) - 1)[first]
    return vertices[kept], number[faces] if isinstance(faces, np.ndarray) else [number[face].tolist() for face in faces]


def _load(path: Path) -> tuple[np.ndarray, np.ndarray | Faces]:
    _check_format(path)
    try:
        if not path.is_file():
            what = "is a folder" if path.is_dir() else "no such file"
            raise InputError(f"{path}: {what}; give the path of a mesh file ({_list(FORMATS)})")
        return READERS.get(path.suffix.lower(), _through_trimesh)(path)
    except InputError:
        raise
    except Exception as error:  # readers of damaged files raise anything, from KeyError to struct.error
        if isinstance(error, OSError) and error.errno is not None:
            raise InputError(f"{path}: {_reason(error)}; check that the file can be read") from error
        cure = f"not readable as {path.suffix[1:].upper()}; export the file again or convert it to STL"
        ours = isinstance(error, ValueError) and path.suffix.lower() in READERS
        reason = str(error) if ours else f"reader: {type(error).__name__}: {error}"
        raise InputError(f"{path}: {cure} ({reason})") from error


def _through_trimesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    with interrupted_after():
        import trimesh

    mesh: Any = trimesh.load(str(path), force="mesh", process=False, maintain_order=True)
    faces = np.asarray(getattr(mesh, "faces", ()), dtype=np.int64)
    return np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3), faces.reshape(-1, 3)


def _check_format(path: Path) -> None:
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: unknown mesh format {path.suffix!r}; use one of {_list(FORMATS)}")


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _list(names: Sequence[str]) -> str:
    return ", ".join(names)
