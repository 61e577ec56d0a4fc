"""STL files, binary or text: three vertices of its own for every triangle."""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from pathlib import Path

import numpy as np

# Of a binary file: letters of no meaning and the number of triangles; a triangle's normal, corners and colour.
HEADER, TRIANGLE = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
_CORNER = re.compile(rb"^[ \t]*vertex[ \t]+(.*?)[ \t\r]*$", re.MULTILINE | re.IGNORECASE)


def read_stl(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (3 m, 3) float64 and triangles (m, 3), in the file's order; solids of a text file follow each other.

    ValueError says what is wrong with a damaged file.
    """
    data = path.read_bytes().removeprefix(BOM_UTF8)
    corners = _text_corners(data.replace(b"\r", b"\n")) if _is_text(data) else _binary_corners(data)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def _is_text(data: bytes) -> bool:
    """Whether the file is text: headers of binary files may begin with the word "solid" too."""
    if not data[:512].lstrip()[:5].lower() == b"solid":
        return False
    return b"\0" not in data[:HEADER] and len(data) != _announced(data)


def _announced(data: bytes) -> int:
    """The bytes of a binary file with as many triangles as its header says."""
    return HEADER + int.from_bytes(data[HEADER - 4 : HEADER], "little") * TRIANGLE.itemsize


def _binary_corners(data: bytes) -> np.ndarray:
    if len(data) < HEADER:
        raise ValueError(f"{HEADER} bytes of header expected, {len(data)} found")
    count = int.from_bytes(data[HEADER - 4 : HEADER], "little")
    if len(data) < _announced(data):  # looked at before anything of that size is made
        raise ValueError(f"{count} triangles announced: {_announced(data)} bytes expected, {len(data)} found")
    return np.frombuffer(data, TRIANGLE, count, HEADER)["corners"].astype(np.float64).reshape(-1, 3)


def _text_corners(data: bytes) -> np.ndarray:
    rows = [words.split() for words in _CORNER.findall(data)]
    for k, words in enumerate(rows):
        if len(words) != 3:
            raise ValueError(f"vertex {k} has {len(words)} coordinates")
    facets = len(re.findall(rb"^[ \t]*facet\b", data, re.MULTILINE | re.IGNORECASE))
    if len(rows) != 3 * facets:
        raise ValueError(f"{facets} facets need {3 * facets} vertices, {len(rows)} found")
    if not data.rstrip().splitlines()[-1].strip().lower().startswith(b"endsolid"):
        raise ValueError(f"no endsolid after {facets} facets, the text is cut short")
    return np.array([[float(word) for word in words] for words in rows]).reshape(-1, 3)
