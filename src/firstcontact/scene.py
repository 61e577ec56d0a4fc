"""Scene files: TOML in, bodies, motions and checks out.

Keys are the constructors' argument names.  A bare TOML float is the double it denotes; a quoted number
("1/3", "0.1") is exact.  Every fault is one InputError that names the file, the key and the cure.
"""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictInt,
    StrictStr,
    ValidationError,
    model_validator,
)

from firstcontact.body.polyhedron import Polyhedron
from firstcontact.errors import FirstContactError, InputError
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import Translation

# Digits "1/3", "-0.1", "2.5e-3".  The short exponent keeps a typing error from asking for gigabytes.
_EXACT = re.compile(r"[+-]?(\d+(\s*/\s*\d+)?|(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?)")


def parse_number(value: Any) -> float | int | Fraction:
    """A finite number: floats and integers as they are, strings exactly; ValueError says what is wrong."""
    number = _exact(value) if isinstance(value, str) else value
    if isinstance(number, bool) or not isinstance(number, int | float | Fraction):
        raise ValueError(f"{value!r} is not a number; write 0.5, or \"1/3\" for an exact one")
    try:
        finite = math.isfinite(float(number))
    except OverflowError:
        finite = False
    if not finite:
        raise ValueError(f"{value!r} is not a finite double; give a finite number")
    return number


def parse_time(value: Any) -> float | int | Fraction:
    """An end of a span: a number, or an infinity ("inf" and "-inf" too)."""
    if isinstance(value, float) and math.isinf(value):
        return value
    if isinstance(value, str) and re.fullmatch(r"[+-]?inf", value.strip()):
        return float(value)
    return parse_number(value)


def _exact(text: str) -> Fraction:
    text = text.strip()
    if not _EXACT.fullmatch(text):
        raise ValueError(f"{text!r} is not a number; write 0.5, \"1/3\" or \"0.1\"")
    try:
        return Fraction(re.sub(r"\s", "", text))
    except ZeroDivisionError as error:
        raise ValueError(f"{text!r} divides by zero; give a finite number") from error


def _list_of(count: int, what: str) -> BeforeValidator:
    """Check a list's length first: pydantic would report every missing item by itself."""

    def check(value: Any) -> Any:
        if not isinstance(value, list) or len(value) != count:
            raise ValueError(f"{value!r} is not {what}")
        return tuple(value)

    return BeforeValidator(check)


def _matrix(value: Any) -> Any:
    """Four rows of four numbers."""
    if not isinstance(value, list) or len(value) != 4 or any(not isinstance(r, list) or len(r) != 4 for r in value):
        raise ValueError(f"{value!r} is not a 4x4 matrix; write four rows [a, b, c, d]")
    return [[parse_number(x) for x in row] for row in value]


def _pose(value: Any) -> Any:
    """A 4x4 matrix, or a vector whose rotation stands in quat_xyzw or quat_wxyz."""
    if isinstance(value, list) and len(value) == 3 and not any(isinstance(x, list) for x in value):
        return [parse_number(x) for x in value]
    try:
        return _matrix(value)
    except ValueError as error:
        raise ValueError(f"{error}, or a vector [x, y, z] with quat_xyzw or quat_wxyz") from error


def _face(value: Any) -> Any:
    """A ring of vertex numbers, or a list of such rings (the outer one, then its holes)."""
    rings = value if isinstance(value, list) and value and isinstance(value[0], list) else [value]
    for ring in rings:
        if not isinstance(ring, list) or not all(type(i) is int for i in ring):
            raise ValueError(f"{value!r} is not a face; write [0, 1, 2], or [[...], [...]] with holes")
    return value


Number = Annotated[Any, BeforeValidator(parse_number)]
Time = Annotated[Any, BeforeValidator(parse_time)]
Vector = Annotated[tuple[Number, Number, Number], _list_of(3, "three numbers; write [x, y, z]")]
Pair = Annotated[tuple[StrictStr, StrictStr], _list_of(2, "two body names; write [\"a\", \"b\"]")]
Span = Annotated[tuple[Time, Time], _list_of(2, "two times; write [start, end]")]
Quaternion = Annotated[tuple[Number, Number, Number, Number], _list_of(4, "four numbers; write [a, b, c, d]")]
Matrix = Annotated[Any, BeforeValidator(_matrix)]
Pose = Annotated[Any, BeforeValidator(_pose)]
Index = Annotated[StrictInt, Field(ge=0)]
Edge = Annotated[tuple[Index, Index], _list_of(2, "two vertex numbers; write [i, j]")]
Face = Annotated[Any, BeforeValidator(_face)]


class _Table(BaseModel):
    """A TOML table: unknown keys are refused with the known ones listed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, table: Any) -> Any:
        if not isinstance(table, dict):
            raise ValueError(f"{table!r} is not a table; use one with keys {', '.join(cls.model_fields)}")
        for key in table:
            if key not in cls.model_fields:
                raise ValueError(f"unknown key {key!r}; keys here are {', '.join(cls.model_fields)}")
        return table


class RotateTable(_Table):
    axis: Vector
    degrees: Number
    point: Vector = (0, 0, 0)


class TranslationTable(_Table):
    type: Literal["translation"]
    vector: Vector

    def build(self) -> Translation:
        return Translation(self.vector)


class _Turn(_Table):
    axis: Vector
    point: Vector = (0, 0, 0)
    radians: Number = None
    degrees: Number = None
    turns: Number = None

    def _angle(self) -> dict[str, Any]:
        return {"radians": self.radians, "degrees": self.degrees, "turns": self.turns}


class RotationTable(_Turn):
    type: Literal["rotation"]

    def build(self) -> Rotation:
        return Rotation(self.axis, self.point, **self._angle())


class ScrewTable(_Turn):
    type: Literal["screw"]
    advance: Number = 0

    def build(self) -> Screw:
        return Screw(self.axis, self.point, **self._angle(), advance=self.advance)


class RationalTable(_Table):
    type: Literal["rational"]
    coefficients: list[Matrix]

    def build(self) -> RationalMotion:
        return RationalMotion(self.coefficients)


class _Quaternions(_Table):
    quat_xyzw: list[Quaternion] | None = None
    quat_wxyz: list[Quaternion] | None = None

    def _check(self, **poses: Any) -> dict[str, Any]:
        """The quaternions, after a look whether the poses are of the kind that goes with them."""
        given = self.quat_xyzw is not None or self.quat_wxyz is not None
        for key, pose in poses.items():
            if given and len(pose) != 3:
                raise InputError(f"{key} is a matrix, but quaternions are given too; write a vector [x, y, z]")
            if not given and len(pose) == 3:
                raise InputError(f"{key} is a vector; add quat_xyzw or quat_wxyz, or write a 4x4 matrix")
        return {"quat_xyzw": self.quat_xyzw, "quat_wxyz": self.quat_wxyz}


class BetweenTable(_Quaternions):
    type: Literal["between"]
    pose0: Pose
    pose1: Pose

    def build(self) -> RationalMotion:
        quaternions = self._check(pose0=self.pose0, pose1=self.pose1)
        return RationalMotion.between(self.pose0, self.pose1, **quaternions)


class TrajectoryTable(_Quaternions):
    type: Literal["trajectory"]
    times: list[Number]
    poses: list[Pose]
    interpolation: Literal["linear-quaternion", "screw"] = "linear-quaternion"

    def build(self) -> Trajectory:
        quaternions = self._check(**{f"poses[{k}]": pose for k, pose in enumerate(self.poses)})
        return Trajectory(self.times, self.poses, self.interpolation, **quaternions)


Step = Annotated[
    TranslationTable | RotationTable | ScrewTable | RationalTable | BetweenTable, Field(discriminator="type")
]


class SequenceTable(_Table):
    type: Literal["sequence"]
    steps: list[Step]
    durations: list[Number] | None = None

    def build(self) -> Sequence:
        return Sequence([step.build() for step in self.steps], durations=self.durations)


Motion = Annotated[
    TranslationTable | RotationTable | ScrewTable | RationalTable | BetweenTable | SequenceTable | TrajectoryTable,
    Field(discriminator="type"),
]


class _Body(_Table):
    name: StrictStr | None = None
    solid: StrictBool | None = None
    at: Vector | None = None
    rotate: RotateTable | None = None
    motion: Motion | None = None


class MeshBody(_Body):
    shape: Literal["mesh"]
    file: StrictStr

    def build(self, key: str, folder: Path) -> Polyhedron:
        return Polyhedron.load(folder / self.file, solid=self.solid, name=self.name or key)


class PolyhedronBody(_Body):
    shape: Literal["polyhedron"]
    vertices: list[Vector]
    faces: list[Face] = []
    edges: list[Edge] | None = None

    def build(self, key: str, folder: Path) -> Polyhedron:
        name = self.name or key
        return Polyhedron(self.vertices, self.faces, edges=self.edges, solid=self.solid, name=name)


class CheckTable(_Table):
    pair: Pair
    span: Span | None = None
    exact: StrictBool = False
    tolerance: Annotated[Number, Field(gt=0)] = 1e-12
    budget: Annotated[StrictInt, Field(gt=0)] | None = None


class SceneTable(_Table):
    body: dict[str, Annotated[MeshBody | PolyhedronBody, Field(discriminator="shape")]]
    check: list[CheckTable] = []


@dataclass(frozen=True)
class Check:
    """One question of a scene: the keys of two bodies and the verb's keyword arguments."""

    a: str
    b: str
    span: tuple[Any, Any] | None = None
    exact: bool = False
    tolerance: float = 1e-12
    budget: int | None = None

    def arguments(self) -> dict[str, Any]:
        keys = ("span", "exact", "tolerance", "budget")
        return {key: getattr(self, key) for key in keys}


@dataclass(frozen=True)
class Scene:
    """Bodies by key (a Polyhedron at rest, or a Moving one) and the checks to run on them."""

    path: Path
    bodies: dict[str, Any]
    checks: tuple[Check, ...]


def load_scene(path: str | Path) -> Scene:
    """The scene of a TOML file; mesh files are looked for relative to it."""
    path = Path(path)
    tables = _read(path)
    try:
        scene = SceneTable.model_validate(tables)
    except ValidationError as error:
        raise InputError(f"{path}: {_first_fault(error, tables)}") from error
    bodies = {key: _build(path, key, body) for key, body in scene.body.items()}
    return Scene(path, bodies, tuple(_checks(path, scene)))


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path}: {reason}; give the path of a scene file (TOML)") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not text; give a scene file (TOML, UTF-8)") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}; mend it there") from error


def _build(path: Path, key: str, table: MeshBody | PolyhedronBody) -> Any:
    """The body in its place: turned by `rotate`, then moved by `at`, then given its motion."""
    where = f"body.{key}"
    try:
        body = table.build(key, path.parent)
        if table.rotate is not None:
            where = f"body.{key}.rotate"
            turn = table.rotate
            body = body.rotated(turn.axis, degrees=turn.degrees, point=turn.point)
        if table.at is not None:
            where = f"body.{key}.at"
            body = body.translated(table.at)
        if table.motion is None:
            return body
        where = f"body.{key}.motion"
        return body.moving(table.motion.build())
    except FirstContactError as error:
        raise type(error)(f"{path}: {where}: {error}") from error


def _checks(path: Path, scene: SceneTable) -> list[Check]:
    if not scene.check:
        return [Check(a, b) for a, b in itertools.combinations(scene.body, 2)]
    checks = []
    for k, table in enumerate(scene.check):
        a, b = table.pair
        for name in (a, b):
            if name not in scene.body:
                known = ", ".join(map(repr, scene.body))
                raise InputError(f"{path}: check[{k}].pair: no body {name!r}; the bodies are {known}")
        if a == b:
            raise InputError(f"{path}: check[{k}].pair: {a!r} against itself; name two bodies")
        checks.append(Check(a, b, table.span, table.exact, float(table.tolerance), table.budget))
    return checks


def _first_fault(error: ValidationError, tables: dict[str, Any]) -> str:
    """The first of pydantic's faults as "key: what is wrong; what to do"."""
    faults = error.errors(include_url=False)
    fault = faults[0]
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    key = _key(fault["loc"], tables)
    return f"{key + ': ' if key else ''}{_message(fault)}{more}"


def _message(fault: Any) -> str:
    context = fault.get("ctx", {})
    match fault["type"]:
        case "value_error":
            return str(context["error"])
        case "missing":
            return "missing; add this key"
        case "union_tag_not_found":
            return f"key {context['discriminator']} is missing; add it"
        case "union_tag_invalid":
            key = context["discriminator"].strip("'")
            return f"{key} {context['tag']!r} is not supported; use one of {context['expected_tags']}"
        case _:
            message = fault["msg"].replace("Input should", "should").replace("dictionary", "table")
            return f"{fault['input']!r} is wrong: it {message}"


def _key(location: tuple[int | str, ...], tables: Any) -> str:
    """`body.lid.motion.axis` of pydantic's location, which also names the variant of each tagged table."""
    key = ""
    for part in location:
        table = tables if isinstance(tables, dict) else {}
        if isinstance(part, int):
            key += f"[{part}]"
            tables = tables[part] if isinstance(tables, list) and part < len(tables) else None
        elif part in table or part not in (table.get("shape"), table.get("type")):
            key += f".{part}"
            tables = table.get(part)
    return key.removeprefix(".")
