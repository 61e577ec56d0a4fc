"""STEP files as trees of named parts, which become bodies when they are asked for."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.compound.compound import Compound
from firstcontact.body.solid.feature_names import unique
from firstcontact.errors import InputError
from firstcontact.exact.numbers import positive_double, rational, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix, compose
from firstcontact.step import bodies, reader
from firstcontact.step.reader import Shape, TreeNode
from firstcontact.step.written import units

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

    from firstcontact.body.kinds import CadShape
    from firstcontact.exact.numbers import Given
    from firstcontact.motion.kinds import AnyMotion
    from firstcontact.motion.moving import Moving

MOST_LISTED = 8


@dataclass(frozen=True, eq=False)
class Assembly:
    """A part of a STEP file, or an assembly of parts, in its place; `load_step` gives the root.

    name     as the file has it; of several alike in one assembly the second is "bolt.2"
    path     names from the root down, "as1/rod-assembly/nut"; the root's own name is its path
    product  the name of the product that stands there, as often as the file has it
    colour   (red, green, blue) from 0 to 1, None where the file tells none
    unit     of lengths: the file's own, unless another was asked for
    children parts and assemblies in it

    It stands wherever a body does: `.body` is all of it as one body, made when it is first asked for.

    >>> import firstcontact as fc
    >>> fc.load_step("examples/door.stp").unit                                                     # doctest: +SKIP
    'mm'
    """

    name: str
    path: str
    product: str
    colour: tuple[float, float, float] | None
    unit: str
    children: tuple[Assembly, ...]
    wanted: bodies.Wanted
    _placement: Matrix
    _shape: Shape | None
    _source: dict[str, Any] | None
    _scale: fmpq

    # -- the tree ---------------------------------------------------------------------------------------------

    @property
    def parts(self) -> tuple[Assembly, ...]:
        """All parts in it, in the order of the file; of a part itself."""
        return (self,) if self._shape is not None else tuple(part for child in self.children for part in child.parts)

    def walk(self) -> Iterator[Assembly]:
        """Itself and all below, from the root down."""
        yield self
        for child in self.children:
            yield from child.walk()

    def __getitem__(self, name: str) -> Assembly:
        """The part or assembly of that name or path (or end of a path); a product's name where it stands once."""
        if not isinstance(name, str):
            raise InputError(f"{name!r} is no name; give the name or path of a part as text")
        nodes = list(self.walk())
        for found in (
            [node for node in nodes if node.path == name],
            [node for node in nodes if f"/{node.path}".endswith(f"/{name}")],
            [node for node in nodes if node.product == name],
        ):
            if len(found) == 1:
                return found[0]
            if found:
                raise InputError(f"{self.path}: {len(found)} parts are called {name!r}; give one of {_listed(found)}")
        raise InputError(f"{self.path}: no part {name!r}; there are {_listed(nodes[1:] or nodes)}")

    # -- as a body --------------------------------------------------------------------------------------------

    @property
    def body(self) -> Compound:
        """All of it as one body."""
        return _body_of(self)

    def as_body(self) -> Compound:
        """What verbs take it for."""
        return self.body

    @property
    def exact(self) -> bool:
        """Whether all its faces are the very surfaces of the file."""
        return all(made.exact for part in self.parts for made in part.built())

    @property
    def deviation(self) -> float:
        """Proved bound of how far the faces of the body are from those of the file, in its unit."""
        return self.body.deviation

    def built(self) -> tuple[bodies.Built, ...]:
        """What a part is made of, solid by solid, in its own frame and the file's unit."""
        assert self._shape is not None
        wanted = self.wanted
        if wanted.deviation is not None:
            wanted = replace(wanted, deviation=wanted.deviation / to_double(self._scale))
        return bodies.built(self._shape, wanted)

    def named(self, name: str | None) -> Compound:
        return self.body.named(name)

    def moving(self, motion: AnyMotion) -> Moving:
        return self.body.moving(motion)

    def translated(self, v: Iterable[Given]) -> Compound:
        return self.body.translated(v)

    def rotated(self, axis: Iterable[Given], *, degrees: Given, point: Iterable[Given] = (0, 0, 0)) -> Compound:
        return self.body.rotated(axis, degrees=degrees, point=point)

    def transformed(self, matrix4: Iterable[Iterable[Given]]) -> Compound:
        return self.body.transformed(matrix4)

    def at(self, t: float) -> Compound:
        return self.body

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        return self.body.bounds(span)

    def __str__(self) -> str:
        return "\n".join(_tree(self))

    def __repr__(self) -> str:
        count = len(self.parts)
        kind = "part" if self._shape is not None else f"assembly of {count} part{'' if count == 1 else 's'}"
        return f"<Assembly {self.path!r}: {kind}, in {self.unit}>"


def load_step(
    path: str | Path, *, unit: str | None = None, deviation: Given = None, surfaces: bool | None = None
) -> Assembly:
    """The tree of a STEP file: parts by name, in their places, with colours, in the file's unit.

    Solids of planes, cylinders, cones, spheres and tori become bodies with these very surfaces (`part.exact`), where
    checks of points, edges and vertices bear them out: checks, no proof.  All others become triangles, whose deviation
    from the file's faces is bounded by proof (`part.deviation`).

    unit: "mm", "cm", "m", "inch", ...: lengths are converted, exactly; default: the file's own.
    deviation: at most, in that unit; default 1e-4 of the size of each solid.
    surfaces: True: curved solids have their own surfaces however long that takes, not only where it takes seconds;
    False: all of them become triangles, whose answers come sooner.

    Raises InputError that names the entity of the file ("#123") which is broken, or says what to install: OpenCASCADE
    reads the file (python -m pip install 'firstcontact[step]').
    """
    if not isinstance(path, str | Path):
        raise InputError(f"{path!r} is no path; give the path of a STEP file as text")
    path = Path(path)
    reader.need_open_cascade()
    wanted = bodies.Wanted(_length(deviation), surfaces)
    try:
        stat = path.stat()
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(f"{path}: {reason}; give the path of a STEP file (.stp, .step)") from error
    file = path.resolve(), stat.st_mtime_ns, stat.st_size
    return _root(*file, str(path), None if unit is None else units.checked(unit), wanted)


@lru_cache(maxsize=8)
def _root(
    path: Path, changed: int, size: int, called: str, unit: str | None, wanted: bodies.Wanted
) -> Assembly:
    """The tree of a file, until it changes: scenes name one file for each of their bodies."""
    read = _read(path, changed, size)
    unit = unit or read.unit
    scale = units.MILLIMETRES[read.unit] / units.MILLIMETRES[unit]
    source: dict[str, Any] = {"shape": "step", "file": called, "unit": unit}
    source |= {} if wanted.deviation is None else {"deviation": wanted.deviation}
    source |= {} if wanted.surfaces is None else {"surfaces": wanted.surfaces}
    roots = [node for root in read.roots if (node := _solid_nodes(root)) is not None]
    if not roots:
        raise InputError(f"{called}: holds no solids, only curves or surfaces; export the model as solids")
    if len(roots) > 1:
        roots = [TreeNode(path.stem, path.stem, None, IDENTITY, None, tuple(roots))]
    start = tuple(tuple(x * scale for x in row) for row in IDENTITY)
    root = roots[0] if roots[0].name else replace(roots[0], name=path.stem)
    return _made(root, root.name, "", start, _Made(unit, wanted, source, scale))  # type: ignore[arg-type]


def from_shape(
    shape: CadShape | TopoDS_Shape, *, name: str | None = None, unit: str | None = None, deviation: Given = None,
    surfaces: bool | None = None,
) -> Compound:  # fmt: skip
    """The body of a shape of build123d or CadQuery (anything with `.wrapped`), or of OpenCASCADE itself.

    deviation, surfaces: as for `load_step`; unit: what its numbers are, default none.
    """
    reader.need_open_cascade()
    from OCP.TopoDS import TopoDS_Shape

    bare = getattr(shape, "wrapped", None)
    if bare is None and hasattr(shape, "val") and callable(shape.val):  # CadQuery's Workplane
        bare = getattr(shape.val(), "wrapped", None)
    bare = shape if bare is None else bare
    if not isinstance(bare, TopoDS_Shape) or bare.IsNull():
        raise InputError(f"{shape!r} is no shape of OpenCASCADE; give a solid of build123d, CadQuery or OCP")
    called = name or getattr(shape, "label", "") or None
    wanted = bodies.Wanted(_length(deviation), surfaces)
    part = Shape(bare, called or "shape")
    if not bodies.solids_of(part):
        raise InputError(f"{part.name}: holds no solid, only curves or surfaces; give a solid")
    own = unit if unit is None else units.checked(unit)
    return _compound(bodies.built(part, wanted), IDENTITY, "", own).named(called)


def _length(deviation: Given) -> float | None:
    if deviation is None:
        return None
    return positive_double(to_double(rational(deviation, "deviation")), "deviation", "length")


@lru_cache(maxsize=8)
def _read(path: Path, changed: int, size: int) -> reader.Read:
    """The file as it was last read, whatever unit and deviation are asked for."""
    return reader.read(path)


@dataclass(frozen=True)
class _Made:
    unit: str
    wanted: bodies.Wanted
    source: dict[str, Any]
    scale: fmpq


def _solid_nodes(node: TreeNode) -> TreeNode | None:
    """The tree without what holds no faces, as curves and points that are drawn beside the solids; an assembly of one
    part that has no name of its own is that part."""
    if node.shape is not None:
        return node if _has_faces(node.shape) else None
    children = tuple(kept for child in node.children if (kept := _solid_nodes(child)) is not None)
    if not children:
        return None
    only = children[0]
    if len(children) == 1 and not _is_called(only):
        return replace(
            only, name=node.name, product=node.product, placement=compose(node.placement, only.placement),
            colour=only.colour or node.colour,
        )  # fmt: skip
    return replace(node, children=children)


def _is_called(node: TreeNode) -> bool:
    return node.name not in ("part", "assembly") or bool(node.product)


def _has_faces(shape: Shape) -> bool:
    from OCP.TopAbs import TopAbs_ShapeEnum

    from firstcontact.step.solids import explored

    return next(explored(shape.shape, TopAbs_ShapeEnum.TopAbs_FACE), None) is not None


def _made(node: TreeNode, name: str, above: str, before: Matrix, made: _Made) -> Assembly:
    path = f"{above}/{name}" if above else name
    placement = compose(before, node.placement)
    names = unique(child.name for child in node.children)
    children = tuple(
        _made(child, called, path, placement, made) for child, called in zip(node.children, names, strict=True)
    )
    source = made.source if not above else {**made.source, "part": path}
    return Assembly(
        name, path, node.product, node.colour, made.unit, children, made.wanted, placement, node.shape, source,
        made.scale,
    )  # fmt: skip


@lru_cache(maxsize=256)
def _body_of(node: Assembly) -> Compound:
    return _joined(node, [part.built() for part in node.parts])


def _joined(node: Assembly, made: list[tuple[bodies.Built, ...]]) -> Compound:
    """The body of what its parts are made of."""
    bodies_ = [
        _compound(own, part._placement, "" if part is node else part.path.removeprefix(node.path + "/"), None)
        for part, own in zip(node.parts, made, strict=True)
    ]
    pieces = itertools.chain.from_iterable(body.pieces for body in bodies_)
    shown = None
    if not all(body.is_shown_as_it_is for body in bodies_):
        shown = lambda: (piece for body in bodies_ for piece in body.shown)  # noqa: E731
    cut = None
    if any(x.cut is not None for own in made for x in own):
        cut = cache(lambda: _joined(node, [tuple(x.as_triangles() for x in own) for own in made]))
    deviation = max(body.deviation for body in bodies_)
    return Compound(
        pieces, deviation=deviation, unit=node.unit, source=node._source, shown=shown, cut=cut, name=node.name
    )


def _compound(made: tuple[bodies.Built, ...], placement: Matrix, path: str, unit: str | None) -> Compound:
    pieces = [replace(piece, path=path) for x in made for piece in x.pieces]
    shown = None
    if any(x.shown is not None for x in made):
        shown = lambda: (replace(piece, path=path) for x in made for piece in x.drawn())  # noqa: E731
    cut = None
    if any(x.cut is not None for x in made):
        cut = cache(lambda: _compound(tuple(x.as_triangles() for x in made), IDENTITY, path, unit))
    whole = Compound(pieces, shown=shown, cut=cut, deviation=max(x.deviation for x in made), unit=unit)
    return whole if placement == IDENTITY else whole._mapped(placement)


def _listed(nodes: list[Assembly]) -> str:
    paths = [repr(node.path) for node in nodes]
    more = f" and {len(paths) - MOST_LISTED} more" if len(paths) > MOST_LISTED else ""
    return ", ".join(paths[:MOST_LISTED]) + more


def _tree(node: Assembly, depth: int = 0) -> Iterator[str]:
    yield "  " * depth + node.name + (f" ({node.product})" if node.product not in ("", node.name) else "")
    for child in node.children:
        yield from _tree(child, depth + 1)
