"""The tree of a STEP file, read by OpenCASCADE: names, colours, placements, units, and the shapes of its parts.

OpenCASCADE (extra "step") is loaded when a file is read, not before.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firstcontact.errors import InputError
from firstcontact.exact.numbers import rational, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix
from firstcontact.motion.poses import SNAP, read_pose
from firstcontact.step.written import frames, text
from firstcontact.step.written.units import MILLIMETRES, unit_of

if TYPE_CHECKING:
    from OCP.gp import gp_Trsf
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Standard import Standard_Transient
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopoDS import TopoDS_Shape, TopoDS_TShape

MISSING = "STEP files and CAD shapes need OpenCASCADE; python -m pip install 'firstcontact[step]'"


def need_open_cascade() -> None:
    """InputError that says what to install where OpenCASCADE is not there."""
    try:
        import OCP.STEPCAFControl
        import OCP.TopoDS  # noqa: F401
    except ImportError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # Ctrl-C while its library was loaded
            raise KeyboardInterrupt from error
        raise InputError(MISSING) from error


@dataclass(eq=False)
class Shape:
    """What a part is made of, in its own frame: a shape of OpenCASCADE, once for all places where it stands.

    entity: the number of the file's entity of a face, edge, vertex, shell or solid, None where that is not known.
    """

    shape: TopoDS_Shape
    name: str
    entity: Callable[[TopoDS_Shape], int | None] = lambda shape: None
    made: dict[Any, Any] = field(default_factory=dict)
    """What was built of it, by how it was asked for."""


@dataclass(frozen=True, eq=False)
class TreeNode:
    """A part (`shape`) or an assembly (`children`) in its place within the one that holds it."""

    name: str
    product: str
    colour: tuple[float, float, float] | None
    placement: Matrix
    shape: Shape | None
    children: tuple[TreeNode, ...]


@dataclass(frozen=True, eq=False)
class Read:
    """A file: its roots, and the unit in which its numbers are."""

    roots: tuple[TreeNode, ...]
    unit: str


def read(path: Path) -> Read:
    """The tree of the file, all numbers those of the file in its own unit.  InputError says what is broken."""
    need_open_cascade()
    kinds = text.checked(path)
    with _readable(path, kinds) as file:
        try_apart(lambda: _transferred(path, file), path)
        document, reader, unit = _transferred(path, file)
    tree = _Tree(document, reader, kinds)
    if (number := tree.entities.left_out()) is not None:
        entity = f"entity #{number} ({kinds[number]})"
        raise InputError(f"{path}: OpenCASCADE makes nothing of {entity}; export the model again")
    roots = tree.roots()
    if not roots:
        raise InputError(f"{path}: holds no shapes; export the model as solids (AP214 or AP242)")
    return Read(roots, unit)


@contextmanager
def _readable(path: Path, kinds: text.Entities) -> Iterator[Path]:
    """The file, or one that says the same so that OpenCASCADE understands it; kinds: takes the entities added."""
    changed = frames.mended(path)
    if changed is None:
        yield path
        return
    text_, added = changed
    kinds |= dict.fromkeys(added, "")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / path.name
        file.write_bytes(text_)
        yield file


def try_apart(work: Callable[[], object], path: Path) -> None:
    """Does it in a child process first: what is damaged may end OpenCASCADE, and the process with it."""
    if not hasattr(os, "fork"):
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of other threads, which the child has no use for
        child = os.fork()
    if child == 0:
        try:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, 1)
            os.dup2(nowhere, 2)
            faulthandler.disable()
            work()
        finally:
            os._exit(0)  # errors are raised where the work is done again
    try:
        _, status = os.waitpid(child, 0)
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    if os.WIFSIGNALED(status):
        raise InputError(f"{path}: OpenCASCADE breaks down over its entities; the file is damaged: export it again")


def _transferred(path: Path, file: Path) -> tuple[TDocStd_Document, STEPControl_Reader, str]:
    """(the document, the reader of entities, the unit); file: what is read for `path`."""
    from OCP.Message import Message
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    printers = Message.DefaultMessenger_s()
    printers.ChangePrinters().Clear()
    document = TDocStd_Document(TCollection_ExtendedString("firstcontact"))
    reader = STEPCAFControl_Reader()
    for set_mode in (reader.SetNameMode, reader.SetColorMode):
        set_mode(True)
    if not _is_done(reader.ReadFile(str(file))):
        raise InputError(f"{path}: not readable as STEP (OpenCASCADE refuses its entities); export it again")
    inner = reader.ChangeReader()
    unit = _unit(inner, path)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, to_double(MILLIMETRES[unit]) / 1000.0)
    if not reader.Transfer(document):
        raise InputError(f"{path}: holds no shapes that can be read; export the model as solids (AP214 or AP242)")
    return document, inner, unit


def _is_done(status: IFSelect_ReturnStatus) -> bool:
    from OCP.IFSelect import IFSelect_ReturnStatus

    return bool(status == IFSelect_ReturnStatus.IFSelect_RetDone)


def _unit(reader: STEPControl_Reader, path: Path) -> str:
    """The unit of the first of the file's representations; those in others are converted."""
    from OCP.collections import Sequence_TCollection_AsciiString

    lengths, angles, solid_angles = (Sequence_TCollection_AsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    names = [lengths.Value(k).ToCString() for k in range(1, lengths.Length() + 1)]
    for name in names:
        unit = unit_of(name)
        if unit is None:
            raise InputError(f"{path}: its unit of length is {name!r}; export it in one of {', '.join(MILLIMETRES)}")
        return unit
    return "mm"


class _Tree:
    def __init__(self, document: TDocStd_Document, reader: STEPControl_Reader, kinds: text.Entities) -> None:
        from OCP.XCAFDoc import XCAFDoc_DocumentTool

        self.tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self.colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        self.entities = _Entities(reader, kinds)
        self.shapes: dict[str, Shape] = {}

    def roots(self) -> tuple[TreeNode, ...]:
        from OCP.collections import Sequence_TDF_Label

        labels = Sequence_TDF_Label()
        self.tool.GetFreeShapes(labels)
        return tuple(self._node(labels.Value(k), None) for k in range(1, labels.Length() + 1))

    def _node(self, label: TDF_Label, instance: TDF_Label | None) -> TreeNode:
        """label: of a product; instance: of its place in an assembly, None of a root."""
        name = self._name(label)
        own = name if instance is None else self._name(instance) or name
        colour = self._colour(instance) or self._colour(label)
        is_assembly = self.tool.IsAssembly_s(label)
        placement = IDENTITY
        if instance is not None or is_assembly:  # the shape of a root that is a part is in its place
            location = self.tool.GetLocation_s(label if instance is None else instance)
            placement = IDENTITY if location.IsIdentity() else _matrix(location.Transformation())
        if is_assembly:
            return TreeNode(own or "assembly", name, colour, placement, None, self._children(label))
        return TreeNode(own or "part", name, colour, placement, self._shape(label, name or own or "part"), ())

    def _children(self, label: TDF_Label) -> tuple[TreeNode, ...]:
        from OCP.collections import Sequence_TDF_Label
        from OCP.TDF import TDF_Label

        components = Sequence_TDF_Label()
        self.tool.GetComponents_s(label, components, False)
        found = []
        for k in range(1, components.Length() + 1):
            instance, product = components.Value(k), TDF_Label()
            if self.tool.GetReferredShape_s(instance, product):
                found.append(self._node(product, instance))
        return tuple(found)

    def _shape(self, label: TDF_Label, name: str) -> Shape:
        from OCP.TCollection import TCollection_AsciiString
        from OCP.TDF import TDF_Tool

        entry = TCollection_AsciiString()
        TDF_Tool.Entry_s(label, entry)
        key = entry.ToCString()
        if key not in self.shapes:
            shape = self.tool.GetShape_s(label)
            self.shapes[key] = Shape(shape, name, self.entities)
        return self.shapes[key]

    def _name(self, label: TDF_Label) -> str:
        from OCP.TDataStd import TDataStd_Name

        name = TDataStd_Name()
        if not label.FindAttribute(TDataStd_Name.GetID_s(), name):
            return ""
        given = str(name.Get().ToExtString()).strip()
        return "" if given.startswith("=>[") or given in ("SOLID", "COMPOUND", "SHELL") else given  # of OpenCASCADE

    def _colour(self, label: TDF_Label | None) -> tuple[float, float, float] | None:
        from OCP.Quantity import Quantity_Color
        from OCP.XCAFDoc import XCAFDoc_ColorType

        if label is None:
            return None
        colour = Quantity_Color()
        for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
            if self.colours.GetColor_s(label, kind, colour):
                return colour.Red(), colour.Green(), colour.Blue()
        return None


class _Entities:
    """The number of the entity that a shape was made of.  The model has the entities in the order of the file."""

    def __init__(self, reader: STEPControl_Reader, kinds: text.Entities) -> None:
        self.reader, self.kinds = reader, kinds
        self.numbers: dict[TopoDS_TShape, int] | None = None

    def __call__(self, shape: TopoDS_Shape) -> int | None:
        if self.numbers is None:
            self.numbers = self._all()
        return self.numbers.get(shape.TShape())

    def left_out(self) -> int | None:
        """A solid that represents a part, or a face of one, of which there is no shape; None where there is none."""
        numbers = {entity: number for number, entity in self._topology}
        for entity, number in numbers.items():
            if number not in self.kinds.shown or not hasattr(entity, "Outer"):
                continue
            if self._shape(entity) is None:
                return number
            shells = [entity.Outer()]
            if hasattr(entity, "VoidsValue"):
                shells += [entity.VoidsValue(k + 1) for k in range(entity.NbVoids())]
            faces = (shell.CfsFacesValue(k + 1) for shell in shells for k in range(shell.NbCfsFaces()))
            lost = next((face for face in faces if self._shape(face) is None), None)
            if lost is not None:
                return numbers.get(lost, number)
        return None

    def _all(self) -> dict[TopoDS_TShape, int]:
        shapes = ((number, self._shape(entity)) for number, entity in self._topology)
        return {shape.TShape(): number for number, shape in shapes if shape is not None}

    @cached_property
    def _topology(self) -> list[tuple[int, Standard_Transient]]:
        """The entities of topology with their numbers; none where the model is not as the text."""
        model = self.reader.StepModel()
        if model.NbEntities() != len(self.kinds):
            return []
        found = [(n, kind, model.Value(k)) for k, (n, kind) in enumerate(self.kinds.items(), 1) if kind in TOPOLOGY]
        if any(entity.DynamicType().Name() != TOPOLOGY[kind] for _, kind, entity in found):
            return []
        return [(number, entity) for number, _, entity in found]

    def _shape(self, entity: Standard_Transient) -> TopoDS_Shape | None:
        from OCP.STEPConstruct import STEPConstruct

        process = self.reader.WS().TransferReader().TransientProcess()
        shape = STEPConstruct.FindShape_s(process, entity)
        return None if shape is None or shape.IsNull() else shape


TOPOLOGY = {
    "ADVANCED_FACE": "StepShape_AdvancedFace", "FACE_SURFACE": "StepShape_FaceSurface",
    "EDGE_CURVE": "StepShape_EdgeCurve", "VERTEX_POINT": "StepShape_VertexPoint",
    "CLOSED_SHELL": "StepShape_ClosedShell", "OPEN_SHELL": "StepShape_OpenShell",
    "MANIFOLD_SOLID_BREP": "StepShape_ManifoldSolidBrep", "BREP_WITH_VOIDS": "StepShape_BrepWithVoids",
}  # fmt: skip
"""Entities of topology, as files and OpenCASCADE call them."""


def _matrix(trsf: gp_Trsf) -> Matrix:
    """A placement as the nearest rational rotation, exact where it is one, and its shift; mirrors stay as they are."""
    rows = [[trsf.Value(i, j) for j in range(1, 5)] for i in range(1, 4)]
    try:
        return read_pose([*rows, [0, 0, 0, 1]], "placement", rational(SNAP, "snap")).matrix()
    except InputError:  # scaled or mirrored
        return tuple(tuple(rational(x, "placement") for x in row) for row in rows)  # type: ignore[return-value]
