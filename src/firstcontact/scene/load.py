"""Scene files: TOML in, bodies, motions and checks out.

Keys are the constructors' argument names.  A bare TOML float is the double it denotes; a quoted number
("1/3", "0.1") is exact.  Every fault is one InputError that names the file, the key and the cure.
"""

from __future__ import annotations

import fnmatch
import itertools
import re
import tomllib
from collections.abc import Iterable, Iterator, Sized
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypedDict, Union

from pydantic import (
    Field,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    ValidationError,
    ValidationInfo,
    create_model,
    field_validator,
)

from firstcontact.assembly.allowed import Rule
from firstcontact.assembly.resting import pairs_that_move
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import MOST_DIGITS, positive_double
from firstcontact.mechanism.values import read_times
from firstcontact.motion import rational
from firstcontact.motion.linkage import Drive, Linkage, drive
from firstcontact.motion.poses import SNAP
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import Translation
from firstcontact.result import FirstContact
from firstcontact.scene import solids, surfaces
from firstcontact.scene.mechanisms import CourseTable, JointTable, Linked, LinkTable
from firstcontact.scene.tools import ToolTable
from firstcontact.scene.values import (
    Corners,
    Edge,
    Face,
    KeyFault,
    Matrix,
    Number,
    Pair,
    Placed,
    Pose,
    Quaternion,
    Span,
    Table,
    Vector,
    at_key,
    parse_number,
    parse_time,
    placed,
)
from firstcontact.toolpath.tool import Tool
from firstcontact.work import MOST_BUDGET

# Tables and lists within each other: far more than a scene needs, far fewer than exhaust the stack that walks them.
MOST_NESTED = 100
# Bodies that an error names.
MOST_NAMES = 20

__all__ = ["Check", "CurveQuestion", "Scene", "load_scene", "parse_number", "parse_time"]


class TranslationTable(Table):
    type: Literal["translation"]
    vector: Vector

    def build(self) -> Translation:
        return Translation(self.vector)


class _TurnTable(Table):
    axis: Vector
    point: Vector = (0, 0, 0)
    radians: Number = None
    degrees: Number = None
    turns: Number = None

    def _angle(self) -> dict[str, Given]:
        return {"radians": self.radians, "degrees": self.degrees, "turns": self.turns}


class RotationTable(_TurnTable):
    type: Literal["rotation"]

    def build(self) -> Rotation:
        return Rotation(self.axis, self.point, **self._angle())


class ScrewTable(_TurnTable):
    type: Literal["screw"]
    advance: Number = 0

    def build(self) -> Screw:
        return Screw(self.axis, self.point, **self._angle(), advance=self.advance)


Off = Annotated[StrictFloat, Field(ge=0)]
"""By how much matrices that were given are off the rotations that they stand for, at most: see `correction`."""


class RationalTable(Table):
    type: Literal["rational"]
    coefficients: list[Matrix]
    correction: Off = 0.0

    def build(self) -> RationalMotion:
        return rational.rebuilt(self.coefficients, self.correction)


class Turns(TypedDict):
    """How poses are read, as `RationalMotion.between` and `Trajectory` take it."""

    quat_xyzw: list[Quaternion] | None
    quat_wxyz: list[Quaternion] | None
    snap: Number


class _Quaternions(Table):
    quat_xyzw: list[Quaternion] | None = None
    quat_wxyz: list[Quaternion] | None = None
    snap: Number = SNAP

    def _check(self, **poses: Sized) -> Turns:
        """The quaternions, after a look whether the poses are of the kind that goes with them."""
        given = self.quat_xyzw is not None or self.quat_wxyz is not None
        for key, pose in poses.items():
            if given and len(pose) != 3:
                raise InputError(f"{key} is a matrix, but quaternions are given too; write a vector [x, y, z]")
            if not given and len(pose) == 3:
                raise InputError(f"{key} is a vector; add quat_xyzw or quat_wxyz, or write a 4x4 matrix")
        return {"quat_xyzw": self.quat_xyzw, "quat_wxyz": self.quat_wxyz, "snap": self.snap}


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
    correction: Off | None = None

    def build(self) -> Trajectory:
        quaternions = self._check(**{f"poses[{k}]": pose for k, pose in enumerate(self.poses)})
        made = Trajectory(self.times, self.poses, self.interpolation, **quaternions)
        if self.correction is not None:
            made.correction = self.correction
        return made


Step = Annotated[
    TranslationTable | RotationTable | ScrewTable | RationalTable | BetweenTable, Field(discriminator="type")
]


class SequenceTable(Table):
    type: Literal["sequence"]
    steps: list[Step]
    durations: list[Number] | None = None

    def build(self) -> Sequence:
        return Sequence([step.build() for step in self.steps], durations=self.durations)


class DriveTable(Table):
    name: StrictStr
    unit: StrictStr
    motion: Annotated[TranslationTable | RotationTable | ScrewTable, Field(discriminator="type")]
    values: list[list[Number]]
    limits: tuple[Number, Number] | None = None
    mimic: tuple[StrictStr, Number, Number] | None = None

    def build(self) -> Drive:
        return drive(self.name, self.unit, self.motion.build(), self.values, self.limits, self.mimic)


class LinkageTable(Table):
    """As a link of a mechanism writes its motion; scenes have [joint.NAME] tables."""

    type: Literal["linkage"]
    times: list[Number]
    drives: list[DriveTable]

    def build(self) -> Linkage:
        times = read_times(self.times)
        for k, row in enumerate(self.drives):
            if len(row.values) != len(times) - 1:
                raise InputError(f"drives[{k}].values: {len(row.values)} for {len(times) - 1} stretches of time")
        return Linkage(times, [row.build() for row in self.drives])


Motion = Annotated[
    TranslationTable
    | RotationTable
    | ScrewTable
    | RationalTable
    | BetweenTable
    | SequenceTable
    | TrajectoryTable
    | LinkageTable,
    Field(discriminator="type"),
]


class _BodyTable(Placed):
    name: StrictStr | None = None
    motion: Motion | None = None


class MeshBody(_BodyTable):
    shape: Literal["mesh"]
    file: StrictStr
    solid: StrictBool | None = None

    def build(self, key: str | None, folder: Path) -> Polyhedron:
        return Polyhedron.load(folder / self.file, solid=self.solid, name=self.name or key)


class StepBody(_BodyTable):
    shape: Literal["step"]
    file: StrictStr
    part: StrictStr | None = None
    unit: StrictStr | None = None
    deviation: Annotated[Number, Field(gt=0)] = None
    surfaces: StrictBool | None = None

    def build(self, key: str | None, folder: Path) -> Shape:
        from firstcontact.step.assembly import load_step

        root = load_step(folder / self.file, unit=self.unit, deviation=self.deviation, surfaces=self.surfaces)
        return (root if self.part is None else root[self.part]).named(self.name or key)


class PolyhedronBody(_BodyTable):
    shape: Literal["polyhedron"]
    vertices: list[Vector]
    faces: list[Face] = []
    edges: list[Edge] | None = None
    solid: StrictBool | None = None

    def build(self, key: str | None, folder: Path) -> Polyhedron:
        name = self.name or key
        return Polyhedron(self.vertices, self.faces, edges=self.edges, solid=self.solid, name=name)


class _SolidBody(_BodyTable, solids.Solid):
    def build(self, key: str | None, folder: Path) -> Shape:
        return self.solid().named(self.name or key)


class RuledBody(surfaces.Ruled, _BodyTable):
    def build(self, key: str | None, folder: Path) -> RuledSurface | RuledStrip:
        return self.build_surface(self.name or key)


def _solid_body(table: type[solids.Solid]) -> type[_BodyTable]:
    return create_model(f"{table.__name__}Body", __base__=(table, _SolidBody))  # type: ignore[arg-type]


if TYPE_CHECKING:
    from collections.abc import Sequence as Listing
    from fractions import Fraction

    from pydantic_core import ErrorDetails

    from firstcontact.body.kinds import Shape
    from firstcontact.exact.numbers import Given
    from firstcontact.result import Json
    from firstcontact.view.html import NotebookFrame
    from firstcontact.work import CheckArguments
    Body = Any
else:
    BODIES = MeshBody, PolyhedronBody, *map(_solid_body, solids.SOLIDS), RuledBody, StepBody
    Body = Annotated[Union[BODIES], Field(discriminator="shape")]  # noqa: UP007


class CheckTable(Table):
    pair: Pair
    span: Span | None = None
    exact: StrictBool = False
    tolerance: Annotated[Number, Field(gt=0)] = 1e-12
    budget: Annotated[StrictInt, Field(gt=0, le=MOST_BUDGET)] | None = None


class CurveTable(Table):
    pair: Pair
    at: Number = None
    tolerance: Annotated[Number, Field(gt=0)] = 1e-6
    box: Corners | None = None
    method: StrictStr = "auto"


class AllowTable(Table):
    pair: Pair | None = None
    body: StrictStr | None = None
    touching: StrictBool = False
    why: StrictStr = ""


class SceneTable(Table):
    body: dict[str, Body]
    check: list[CheckTable] = []
    curve: list[CurveTable] = []
    allow: list[AllowTable] = []
    rest: StrictBool = False
    unit: StrictStr = ""
    joint: dict[str, JointTable] = {}
    link: dict[str, LinkTable] = {}
    course: CourseTable | None = None
    tool: dict[str, ToolTable] = {}

    @field_validator("check", "curve", "allow", mode="before")
    @classmethod
    def _is_list(cls, value: Json, info: ValidationInfo) -> Json:
        if isinstance(value, dict):
            name = info.field_name
            raise ValueError(f"[{name}] is one table of a list; write [[{name}]]")
        return value


@dataclass(frozen=True)
class Check:
    """One question of a scene: the keys of two bodies and the verb's keyword arguments."""

    a: str
    b: str
    span: tuple[float | Fraction, float | Fraction] | None = None
    exact: bool = False
    tolerance: float = 1e-12
    budget: int | None = None

    def arguments(self) -> CheckArguments:
        return {"span": self.span, "exact": self.exact, "tolerance": self.tolerance, "budget": self.budget}


class CurveArguments(TypedDict):
    """What `intersection_curve` takes beside the surfaces."""

    tolerance: float
    box: Listing[Listing[Given]] | None
    method: str


@dataclass(frozen=True)
class CurveQuestion:
    """A question of `firstcontact curve`: the keys of two bodies, the time at which they rest, the verb's arguments."""

    a: str
    b: str
    at: Any = None
    tolerance: float = 1e-6
    box: Any = None
    method: str = "auto"

    def arguments(self) -> CurveArguments:
        return {"tolerance": self.tolerance, "box": self.box, "method": self.method}


@dataclass(frozen=True)
class Scene:
    """Bodies by key, at rest or Moving, the checks to run on them, and the intersection curves to find.

    allow: what may touch.  unit: of lengths, "" where none is told.  resting: how many pairs are left out, for they are
    at rest with each other.
    """

    path: Path
    bodies: dict[str, Any]
    checks: tuple[Check, ...]
    curves: tuple[CurveQuestion, ...] = ()
    allow: tuple[Rule, ...] = ()
    unit: str = ""
    resting: int = 0
    linked: Linked | None = None
    """The mechanism that the joints make of the bodies."""
    tools: dict[str, Tool] = field(default_factory=dict)
    """What `firstcontact toolpath` moves."""
    files: tuple[Path, ...] = ()
    """What was read: the scene, and the files that it names."""

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """The scene of a TOML file; mesh files are looked for relative to it."""
        return load_scene(path)

    def first_contacts(self, *, exact: bool = False, workers: int | None = None) -> list[FirstContact]:
        """What `firstcontact check` tells of the scene: the first contact of each pair of `checks`, in their order.

        exact: decide all in exact arithmetic.  workers: how many cores take part, default None: all of them.

        >>> import firstcontact as fc
        >>> hits = fc.Scene.load("examples/drawer.toml").first_contacts()
        >>> [(hit.a.name, hit.b.name, hit.status.name, hit.time) for hit in hits if hit.time is not None]
        [('drawer', 'stop', 'CONTACT', 0.75)]
        """
        from firstcontact.assembly.together import PairQuestion, answers  # loads all that answers
        from firstcontact.batch.workers import cores

        asked = [
            PairQuestion.of(
                "first_contact", self.bodies, x.a, x.b, {**x.arguments(), "exact": x.exact or exact}, self.allow
            )
            for x in self.checks
        ]
        return list(answers(asked, lambda k: None, None, workers or cores()))

    def show(self, hits: Iterable[FirstContact], path: str | Path | None = None) -> Path | NotebookFrame:
        """Write the page that shows all bodies, and the contacts one after the other; without a path open it."""
        from firstcontact.view.assembly import SceneView
        from firstcontact.view.html import show_page

        return show_page(path, hits, SceneView(self.bodies, self.unit))


def load_scene(path: str | Path) -> Scene:
    """The scene of a TOML file; mesh files are looked for relative to it."""
    if not isinstance(path, str | Path):
        raise InputError(f"{path!r} is no path; give the path of a scene file (TOML) as text")
    path = Path(path)
    tables = _read(path)
    try:
        scene = SceneTable.model_validate(tables)
    except ValidationError as error:
        raise InputError(f"{path}: {first_fault(error, tables)}") from error
    _check_names(path, scene)
    bodies = {key: _build(path, key, body) for key, body in scene.body.items()}
    linked = _linked(path, scene, bodies)
    checks, resting = _checks(path, scene, bodies, linked)
    curves, rules = tuple(_curves(path, scene)), tuple(_rules(path, scene))
    tools = {key: _tool(path, key, table) for key, table in scene.tool.items()}
    files = (path, *_files(path.parent, tables))
    return Scene(path, bodies, tuple(checks), curves, rules, scene.unit, resting, linked, tools, files)


def _files(folder: Path, tables: Json) -> Iterator[Path]:
    """The files that the tables name."""
    waiting = [tables]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            if isinstance(file := value.get("file"), str):
                yield folder / file
            waiting += value.values()


def _tool(path: Path, key: str, table: ToolTable) -> Tool:
    try:
        with at_key(f"tool.{key}"):
            return table.build(key)
    except KeyFault as error:
        raise InputError(f"{path}: {error}") from error


def _linked(path: Path, scene: SceneTable, bodies: dict[str, Body]) -> Linked | None:
    """The mechanism, where there are joints; its bodies are set in motion."""
    try:
        if not scene.joint:
            for key, given in (("link", scene.link), ("course", scene.course)):
                if given:
                    raise KeyFault(key, "goes with joints; add a [joint.NAME]")
            return None
        linked = Linked(scene.joint, scene.link, bodies)
        if scene.course is not None:
            with at_key("course"):
                bodies |= linked.moving(scene.course.build(linked.mechanism, path.parent))
    except KeyFault as error:
        raise InputError(f"{path}: {error}") from error
    return linked


def _read(path: Path) -> dict[str, Json]:
    text = ""
    try:
        text = path.read_text(encoding="utf-8-sig")
        tables = tomllib.loads(text)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path}: {reason}; give the path of a scene file (TOML)") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not text; give a scene file (TOML, UTF-8)") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}; mend it there") from error
    except RecursionError as error:
        raise _too_deep(path, text) from error
    except ValueError as error:  # a path with a null character, or digits that Python does not read
        raise InputError(f"{path}: {_unread(text) or error}") from error
    if any(len(key) > MOST_NESTED for key in _places(tables)):
        raise _too_deep(path, text)
    return tables


def _places(tables: Json) -> Iterator[tuple[str | int, ...]]:
    """The keys and numbers that lead to each table and list, down to just beyond MOST_NESTED."""
    waiting: list[tuple[tuple[Any, ...], Any]] = [((), tables)]
    while waiting:
        place, value = waiting.pop()
        yield place
        if len(place) <= MOST_NESTED and isinstance(value, dict | list):
            inner = value.items() if isinstance(value, dict) else enumerate(value)
            waiting += [((*place, key), x) for key, x in inner if isinstance(x, dict | list)]


def _too_deep(path: Path, text: str) -> InputError:
    """Names the line with the most brackets or dots."""
    number, _ = max(enumerate(text.splitlines(), 1), key=lambda line: max(map(line[1].count, "[{.")))
    where = f"perhaps in line {number}"
    return InputError(f"{path}: tables or lists nested more than {MOST_NESTED} deep, {where}; give flatter ones")


def _unread(text: str) -> str | None:
    """What is wrong with the first line that has a number of too many digits."""
    for number, line in enumerate(text.splitlines(), 1):
        if any(len(digits.replace("_", "")) > MOST_DIGITS for digits in re.findall(r"[\d_]+", line)):
            return f"line {number}: a number of more than {MOST_DIGITS} digits; give fewer"
    return None


def _check_names(path: Path, scene: SceneTable) -> None:
    """Answers tell bodies apart by their names, in one line."""
    known: dict[str, str] = {}
    for key, table in scene.body.items():
        name = key if table.name is None else table.name
        if not name.strip() or not name.isprintable():
            raise InputError(f"{path}: body.{shown(key)}: no name to tell is {shown(name)}; give letters on one line")
        if name in known:
            raise InputError(
                f"{path}: body.{key}: its name {name!r} is that of body.{known[name]}, too; give it one of its own"
            )
        known[name] = key


def _build(path: Path, key: str, table: _BodyTable) -> Body:
    """The body of a scene."""
    try:
        with at_key(f"body.{key}"):
            return build_body(table, key, path.parent)
    except KeyFault as error:
        raise InputError(f"{path}: {error}") from error


def build_body(table: Any, key: str | None, folder: Path) -> Body:
    """The body in its place, given its motion."""
    body = placed(table.build(key, folder), table)
    if table.motion is None:
        return body
    with at_key("motion"):
        return body.moving(table.motion.build())


def _checks(
    path: Path, scene: SceneTable, bodies: dict[str, Body], linked: Linked | None
) -> tuple[list[Check], int]:
    """The checks, and how many pairs are left out, for they are at rest with each other."""
    if not scene.check:
        every = [x for x in itertools.combinations(bodies, 2) if linked is None or not linked.are_one(*x)]
        moving = set(every if scene.rest else pairs_that_move(bodies))
        checks = [Check(*pair) for pair in every if pair in moving]
        return checks, len(every) - len(checks)
    checks = []
    for k, table in enumerate(scene.check):
        a, b = _pair(path, scene, f"check[{k}]", table.pair)
        checks.append(Check(a, b, table.span, table.exact, _tolerance(path, k, table), table.budget))
    return checks, 0


def _rules(path: Path, scene: SceneTable) -> Iterator[Rule]:
    """What the scene lets touch, after a look whether each pattern is one of a body."""
    for k, table in enumerate(scene.allow):
        given = [table.pair is not None, table.body is not None, table.touching]
        if sum(given) != 1:
            one = 'pair = ["bolt*", "plate"], body = "bolt*" or touching = true'
            raise InputError(f"{path}: allow[{k}]: give one of {one}")
        patterns = table.pair or (table.body or "*", "*")
        for pattern in patterns:
            if not fnmatch.filter(scene.body, pattern):
                raise InputError(f"{path}: allow[{k}]: no body {pattern!r}; the bodies are {_names(scene)}")
        yield Rule(*patterns, table.touching, table.why)


def _names(scene: SceneTable) -> str:
    names = list(scene.body)
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(map(repr, names[:MOST_NAMES])) + more


def _curves(path: Path, scene: SceneTable) -> list[CurveQuestion]:
    """Of the pairs of [[curve]] tables; without any, of those that are checked, or of all pairs of bodies."""
    if not scene.curve:
        checked = [_pair(path, scene, f"check[{k}]", table.pair) for k, table in enumerate(scene.check)]
        return [CurveQuestion(a, b) for a, b in checked or itertools.combinations(scene.body, 2)]
    curves = []
    for k, table in enumerate(scene.curve):
        a, b = _pair(path, scene, f"curve[{k}]", table.pair)
        curves.append(CurveQuestion(a, b, table.at, _tolerance(path, k, table), table.box, table.method))
    return curves


def _tolerance(path: Path, k: int, table: CheckTable | CurveTable) -> float:
    key = "check" if isinstance(table, CheckTable) else "curve"
    return positive_double(table.tolerance, f"{path}: {key}[{k}].tolerance")


def _pair(path: Path, scene: SceneTable, key: str, pair: tuple[str, str]) -> tuple[str, str]:
    """The pair, after a look whether both bodies are there."""
    for name in pair:
        if name not in scene.body:
            raise InputError(f"{path}: {key}.pair: no body {name!r}; the bodies are {_names(scene)}")
    if pair[0] == pair[1]:
        raise InputError(f"{path}: {key}.pair: {pair[0]!r} against itself; name two bodies")
    return pair


def first_fault(error: ValidationError, tables: dict[str, Json]) -> str:
    """The first of pydantic's faults as "key: what is wrong; what to do"."""
    faults = error.errors(include_url=False)
    fault = faults[0]
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    key = _key(fault["loc"], tables)
    return f"{key + ': ' if key else ''}{_message(fault)}{more}"


def _message(fault: ErrorDetails) -> str:
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
            return f"{shown(fault['input'])} is wrong: it {message}"


def _key(location: tuple[int | str, ...], tables: Json) -> str:
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
