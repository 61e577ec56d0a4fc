"""Placements in the text of a STEP file that OpenCASCADE reads otherwise than the file has them.

What takes a frame T1 of a part to a frame T2 of the assembly is T2 T1^-1 (ISO 10303-43: `item_defined_transformation`,
`mapped_item`).  OpenCASCADE makes T1^-1 T2 of it, which is the same where one of them is the world's own frame, as in
most files; others are written anew with T1 the world's.  It takes nothing at all from a
`cartesian_transformation_operator_3d` among the former, and neither scale nor mirror from one among the latter: rigid
ones are written anew as frames, others are refused.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from firstcontact.errors import InputError
from firstcontact.step.written.text import bared

_ENTITY = re.compile(
    rb"#(\d+)\s*=\s*(AXIS2_PLACEMENT_3D|CARTESIAN_POINT|DIRECTION|ITEM_DEFINED_TRANSFORMATION|MAPPED_ITEM|"
    rb"REPRESENTATION_MAP|[A-Z_]*SHAPE_REPRESENTATION|REPRESENTATION)\s*\(([^;]*)\)\s*;"
)
_OPERATOR = re.compile(rb"#(\d+)\s*=\s*(\(?[^;=]*CARTESIAN_TRANSFORMATION_OPERATOR_3D[^;]*);")
_RELATED = re.compile(rb"\bREPRESENTATION_RELATIONSHIP\s*\(([^;()]*)\)[^;]*_WITH_TRANSFORMATION\s*\(([^;()]*)\)[^;]*;")
_DATA = re.compile(rb"\bDATA\b.*?\b(?=ENDSEC\b)", re.S)
NEARLY_ALONG = 1e-9
"""Of the length of an axis: what is left of it across the others if it has a direction of its own."""
SAME = 1e-12
"""Of the numbers of two placements: nearer ones are one."""

Change = tuple[int, np.ndarray]
"""Which argument of an entity is the frame to be replaced, and what it has to be."""


def mended(path: Path) -> tuple[bytes, list[int]] | None:
    """The text with the placements that OpenCASCADE would read otherwise written so that it reads them as they are, and
    the numbers of the entities added to it; None where there are none.  InputError names one with a scale or a mirror.
    """
    text = path.read_bytes()
    if not any(kind in text for kind in (b"ITEM_DEFINED_", b"REPRESENTATION_MAP", b"TRANSFORMATION_OPERATOR_3D")):
        return None
    frames = _Frames(bared(text))
    for found in _OPERATOR.finditer(frames.bare):
        frames.operators[int(found[1])] = frames.operator(path, found)
    changes = frames.changes()
    return frames.written_anew(text, changes) if changes else None


class _Frames:
    """What the text says of frames; numbers: of entities; spans: where their arguments are in the text."""

    def __init__(self, bare: bytes) -> None:
        self.bare = bare
        self.kinds: dict[int, str] = {}
        self.operators: dict[int, np.ndarray] = {}
        self.spans: dict[int, tuple[int, int]] = {}
        for found in _ENTITY.finditer(bare):
            self.kinds[int(found[1])], self.spans[int(found[1])] = found[2].decode(), found.span(3)

    def arguments(self, number: int) -> list[bytes]:
        begin, end = self.spans.get(number, (0, 0))
        return _arguments(self.bare[begin:end])

    # -- what is read otherwise -------------------------------------------------------------------------------

    def changes(self) -> dict[int, Change]:
        swapped = set(self._swapped())
        found = {
            number: change for number, kind in self.kinds.items()
            if kind in ("ITEM_DEFINED_TRANSFORMATION", "MAPPED_ITEM")
            and (change := self._change(number, number in swapped)) is not None
        }  # fmt: skip
        maps = {self._map_of(number) for number in found if self.kinds[number] == "MAPPED_ITEM"}
        for number, kind in self.kinds.items():  # all items of one map, as its frame becomes the world's
            if kind == "MAPPED_ITEM" and number not in found and self._map_of(number) in maps:
                change = self._change(number, False, always=True)
                if change is not None:
                    found[number] = change
        return found

    def _change(self, number: int, swapped: bool, always: bool = False) -> Change | None:
        """Of an entity that takes one frame to another; None where it is read as it is."""
        given = self.arguments(number)
        if self.kinds[number] == "MAPPED_ITEM":
            first, second, at = self.arguments(self._map_of(number))[0], given[2], 2
        else:
            first, second, at = given[2], given[3], 3
        if swapped:
            first, second = second, first
        always = always or _number(first) in self.operators or _number(second) in self.operators
        origin, target = self.frame(first), self.frame(second)
        if origin is None or target is None:
            return None
        back = np.linalg.inv(origin)
        true, read = target @ back, back @ target
        size = max(1.0, float(np.abs(true).max()), float(np.abs(read).max()))
        return (at, true) if always or np.abs(true - read).max() > SAME * size else None

    def _map_of(self, item: int) -> int:
        return _number(self.arguments(item)[1])

    def _swapped(self) -> list[int]:
        """The transformations whose first frame is one of the second representation, and the other way round."""
        found = []
        for relation in _RELATED.finditer(self.bare):
            number, related = _number(relation[2]), _arguments(relation[1])
            if self.kinds.get(number) != "ITEM_DEFINED_TRANSFORMATION" or len(related) != 4:
                continue
            items = [self._items(_number(x)) for x in related[2:]]
            frames = [_number(x) for x in self.arguments(number)[2:]]
            if frames[0] in items[1] - items[0] and frames[1] in items[0] - items[1]:
                found.append(number)
        return found

    def _items(self, representation: int) -> set[int]:
        given = self.arguments(representation)
        return {int(x) for x in re.findall(rb"#(\d+)", given[1])} if len(given) > 1 else set()

    # -- what the text says -----------------------------------------------------------------------------------

    def frame(self, reference: bytes) -> np.ndarray | None:
        """(4, 4) of an axis placement or an operator; None for anything else."""
        number = _number(reference)
        given = self.arguments(number)
        if number in self.operators:
            return self.operators[number]
        if self.kinds.get(number) != "AXIS2_PLACEMENT_3D" or len(given) != 4:
            return None
        origin = self.vector(given[1])
        z, x = self.vector(given[2], (0.0, 0.0, 1.0)), self.vector(given[3], (1.0, 0.0, 0.0))
        if origin is None or z is None or x is None or not z.any():
            return None
        z = _unit(z)
        x = x - (x @ z) * z
        if not np.linalg.norm(x) > NEARLY_ALONG:
            return None
        x = _unit(x)
        pose = np.eye(4)
        pose[:3] = np.column_stack([x, np.cross(z, x), z, origin])
        return pose

    def vector(self, reference: bytes, default: tuple[float, float, float] | None = None) -> np.ndarray | None:
        """Of a point or a direction."""
        if reference == b"$":
            return None if default is None else np.array(default)
        number = _number(reference)
        if self.kinds.get(number) not in ("CARTESIAN_POINT", "DIRECTION"):
            return None
        try:
            found = [float(x) for x in self.arguments(number)[-1].strip(b"() \r\n").split(b",")]
        except ValueError:
            return None
        return np.array(found) if len(found) == 3 else None

    def operator(self, path: Path, found: re.Match[bytes]) -> np.ndarray:
        """(4, 4) of a cartesian_transformation_operator_3d (ISO 10303-42: `base_axis`).  InputError names one with a
        scale or a mirror."""
        number, body = int(found[1]), found[2]
        simple = re.match(rb"CARTESIAN_TRANSFORMATION_OPERATOR_3D\s*\((.*)\)\s*$", body, re.S)
        general = re.search(rb"CARTESIAN_TRANSFORMATION_OPERATOR\s*\(([^()]*)\)", body)
        own = re.search(rb"CARTESIAN_TRANSFORMATION_OPERATOR_3D\s*\(([^()]*)\)", body)
        who = f"{path}: entity #{number} (CARTESIAN_TRANSFORMATION_OPERATOR_3D)"
        given = _arguments(simple[1]) if simple else []
        if general and own:
            given = [b"", b"", b"", *_arguments(general[1]), *_arguments(own[1])]
        if len(given) != 8:
            raise InputError(f"{who} has not the attributes that it needs; export the model again")
        first, second, at, scale, third = given[3:]
        hint = "export the model with that part in its size and shape, placed by a rotation and a shift"
        if scale != b"$" and float(scale) != 1.0:
            raise InputError(f"{who} scales what it places by {float(scale):g}; {hint}")
        origin, z = self.vector(at), self.vector(third, (0.0, 0.0, 1.0))
        x, y = self.vector(first, (1.0, 0.0, 0.0)), self.vector(second, (0.0, 1.0, 0.0))
        if origin is None or x is None or y is None or z is None:
            raise InputError(f"{who} has not the attributes that it needs; export the model again")
        if first == b"$" and not z[1:].any():
            x = np.array((0.0, 1.0, 0.0))
        axes: list[np.ndarray] = []
        for axis in (z, x, y):
            across = axis - sum(((axis @ other) * other for other in axes), np.zeros(3))
            if not np.linalg.norm(across) > NEARLY_ALONG * np.linalg.norm(axis):
                raise InputError(f"{who} has two axes in one direction; export the model again")
            axes.append(_unit(across))
        z, x, y = axes
        if np.cross(z, x) @ y < 0.0:
            raise InputError(f"{who} mirrors what it places; {hint}")
        pose = np.eye(4)
        pose[:3] = np.column_stack([x, y, z, origin])
        return pose

    # -- as it is read ----------------------------------------------------------------------------------------

    def written_anew(self, text: bytes, changes: dict[int, Change]) -> tuple[bytes, list[int]]:
        """The text with new frames at the end of its data, and their numbers."""
        last = max(int(x) for x in re.findall(rb"#(\d+)\s*=", self.bare))
        added: list[bytes] = []

        def frame(pose: np.ndarray) -> bytes:
            n = last + len(added) + 1
            for kind, column in ((b"CARTESIAN_POINT", 3), (b"DIRECTION", 2), (b"DIRECTION", 0)):
                numbers = b",".join(f"{x:.17E}".encode() for x in pose[:3, column].tolist())
                added.append(b"#%d=%s('',(%s));" % (last + len(added) + 1, kind, numbers))
            added.append(b"#%d=AXIS2_PLACEMENT_3D('',#%d,#%d,#%d);" % (n + 3, n, n + 1, n + 2))
            return b"#%d" % (n + 3)

        world = frame(np.eye(4))
        parts: dict[tuple[int, int], bytes] = {}
        for number, (at, pose) in changes.items():
            parts[self._place(number, at)] = frame(pose)
            first = (self._map_of(number), 0) if self.kinds[number] == "MAPPED_ITEM" else (number, 2)
            parts[self._place(*first)] = world
        data = _DATA.search(self.bare)
        end = len(text) if data is None else data.end()
        parts[end, end] = b"\n".join(added) + b"\n"
        for (begin, end), new in sorted(parts.items(), reverse=True):
            text = text[:begin] + new + text[end:]
        return text, [last + k + 1 for k in range(len(added))]

    def _place(self, number: int, at: int) -> tuple[int, int]:
        """Where an argument of an entity is in the text."""
        begin, end = self.spans[number]
        lo, hi = _places(self.bare[begin:end])[at]
        return begin + lo, begin + hi


def _unit(vector: np.ndarray) -> np.ndarray:
    """That of its direction, however short or long it is."""
    scaled = vector / np.abs(vector).max()
    unit: np.ndarray = scaled / np.linalg.norm(scaled)
    return unit


def _number(reference: bytes) -> int:
    """Of an entity that is referred to; -1 where it is no reference."""
    found = re.fullmatch(rb"\s*#(\d+)\s*", reference)
    return int(found[1]) if found else -1


def _places(arguments: bytes) -> list[tuple[int, int]]:
    """Where each argument begins and ends."""
    depth, begin, found = 0, 0, []
    for k, letter in enumerate(arguments):
        depth += (letter == ord("(")) - (letter == ord(")"))
        if letter == ord(",") and depth == 0:
            found.append((begin, k))
            begin = k + 1
    return [*found, (begin, len(arguments))]


def _arguments(text: bytes) -> list[bytes]:
    return [text[lo:hi].strip() for lo, hi in _places(text)]
