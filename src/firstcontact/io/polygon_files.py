"""OBJ, PLY and OFF files with the polygons they hold; trimesh would cut those into fans, wrongly where not convex."""

from __future__ import annotations

import re
import struct
from codecs import BOM_UTF8
from pathlib import Path

import numpy as np

Faces = list[list[int]]
Element = tuple[str, int, list[tuple[str, str | None, str]]]
"""Name, count, and per property its name, the type of its length (None: no list) and its type."""


def read_obj(path: Path) -> tuple[np.ndarray, Faces]:
    """Vertices (n, 3) float64 and the corners of every face, 0-based; objects, groups and materials are not told apart.

    Like the other readers here it raises ValueError, or what an index or a conversion raises, on a damaged file.
    """
    vertices: list[list[str]] = []
    faces: Faces = []
    for line in _text(path).replace("\\\n", " ").split("\n"):
        words = line.partition("#")[0].split()
        if words and words[0] == "v":
            vertices.append(words[1:4])
        elif words and words[0] == "f":
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            faces.append([i - 1 if i >= 0 else len(vertices) + i for i in numbers])  # negative: back from the latest
    return _coordinates(vertices), faces


def read_off(path: Path) -> tuple[np.ndarray, Faces]:
    """Vertices (n, 3) float64 and the corners of every face; colours, normals and texture coordinates are skipped."""
    lines = [words for line in _text(path).split("\n") if (words := line.partition("#")[0].split())]
    if not lines or not re.fullmatch("(ST)?C?N?OFF", lines[0][0]) or lines[0][1:2] == ["BINARY"]:
        raise ValueError("no text OFF header")
    lines = lines if len(lines[0]) > 1 else lines[1:]  # the counts may stand in the header line
    n, m = (int(word) for word in [word for word in lines[0] if not word.endswith("OFF")][:2])
    if len(lines) < 1 + n + m:
        raise ValueError(f"{n} vertices and {m} faces announced, {len(lines) - 1} lines there")
    faces = []
    for words in lines[1 + n : 1 + n + m]:
        size = int(words[0])
        faces.append([int(word) for word in words[1 : 1 + size]])
        if len(faces[-1]) != size:
            raise ValueError(f"face {len(faces) - 1} announces {size} corners and has {len(faces[-1])}")
    return _coordinates([words[:3] for words in lines[1 : 1 + n]]), faces


PLY_TYPES = {
    "char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d",
    "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f", "float64": "d",
}  # fmt: skip


def read_ply(path: Path) -> tuple[np.ndarray, Faces]:
    """Vertices (n, 3) float64 and the corners of every face of a PLY file, and of every triangle of its strips; other
    elements are skipped."""
    data = path.read_bytes().removeprefix(BOM_UTF8)
    encoding, elements, start = _ply_header(data)
    source = _PlyText(data[start:]) if encoding == "ascii" else _PlyBinary(data, start, encoding)
    vertices = np.empty((0, 3))
    faces: Faces = []
    for name, count, properties in elements:
        names = [label for label, _, _ in properties]
        if all(size is None for _, size, _ in properties):
            table = source.table([kind for _, _, kind in properties], count)
            if name == "vertex":
                vertices = table[:, [names.index(axis) for axis in "xyz"]]
            continue
        at = next((k for k, label in enumerate(names) if label in ("vertex_indices", "vertex_index")), None)
        for _ in range(count):
            row = [source.take(kind, 1 if size is None else source.take(size, 1)[0]) for _, size, kind in properties]
            if name in ("face", "tristrips"):
                corners = list(row[names.index("vertex_indices") if at is None else at])
                faces += [corners] if name == "face" else _of_strips(corners)
    return vertices, faces


def _of_strips(corners: list[int]) -> Faces:
    """The triangles of strips that -1 parts: every other one is turned; those with a corner twice only lead on."""
    faces: Faces = []
    begin = 0
    for end in [k for k, corner in enumerate(corners) if corner == -1] + [len(corners)]:
        strip = corners[begin:end]
        for k, (p, q, r) in enumerate(zip(strip, strip[1:], strip[2:], strict=False)):
            if len({p, q, r}) == 3:
                faces.append([q, p, r] if k % 2 else [p, q, r])
        begin = end + 1
    return faces


def _ply_header(data: bytes) -> tuple[str, list[Element], int]:
    """The encoding, the elements, and where the data begin."""
    head, _, _ = data.partition(b"end_header")
    lines = [line.split() for line in head.decode("ascii", "replace").splitlines()]
    if lines[:1] != [["ply"]] or len(head) == len(data):
        raise ValueError("no PLY header")
    encoding = ""
    elements: list[Element] = []
    for words in lines:
        if words[:1] == ["format"]:
            encoding = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            elements[-1][2].append((words[4], PLY_TYPES[words[2]], PLY_TYPES[words[3]]))
        elif words[:1] == ["property"]:
            elements[-1][2].append((words[2], None, PLY_TYPES[words[1]]))
    for name, count, properties in elements:
        if count < 0:
            raise ValueError(f"{count} elements {name!r} announced")
        if any(size is not None and (size in "fd" or label.startswith("vertex_ind") and kind in "fd")
               for label, size, kind in properties):  # fmt: skip
            raise ValueError(f"element {name!r} has numbers of corners, or corners, that are no whole numbers")
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"unknown encoding {encoding!r}")
    return encoding, elements, data.index(b"\n", len(head)) + 1


class _PlyText:
    """The numbers of a text PLY file, in order."""

    def __init__(self, data: bytes) -> None:
        self.words = data.split()
        self.at = 0

    def table(self, kinds: list[str], count: int) -> np.ndarray:
        words = self._next(count * len(kinds))
        return np.array([float(word) for word in words]).reshape(count, len(kinds))

    def take(self, kind: str, count: int) -> list:
        return [float(word) if kind in "fd" else int(word) for word in self._next(count)]

    def _next(self, count: int) -> list[bytes]:
        words = self.words[self.at : self.at + count]
        if count < 0 or len(words) != count:
            raise ValueError("the data end early")
        self.at += count
        return words


class _PlyBinary:
    """The numbers of a binary PLY file, in order."""

    def __init__(self, data: bytes, start: int, encoding: str) -> None:
        self.data, self.at = data, start
        self.order = "<" if encoding == "binary_little_endian" else ">"

    def table(self, kinds: list[str], count: int) -> np.ndarray:
        row = np.dtype([(str(k), self.order + kind) for k, kind in enumerate(kinds)])
        values = np.frombuffer(self.data, row, count, self.at)
        self.at += values.nbytes
        return np.stack([values[name].astype(np.float64) for name in row.names or ()], axis=1)

    def take(self, kind: str, count: int) -> tuple:
        form = f"{self.order}{count}{kind}"
        values = struct.unpack_from(form, self.data, self.at)
        self.at += struct.calcsize(form)
        return values


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8-sig", errors="replace")


def _coordinates(rows: list[list[str]]) -> np.ndarray:
    if bad := [k for k, row in enumerate(rows) if len(row) != 3]:
        raise ValueError(f"vertex {bad[0]} has {len(rows[bad[0]])} coordinates")
    return np.array(rows, np.float64).reshape(-1, 3)
