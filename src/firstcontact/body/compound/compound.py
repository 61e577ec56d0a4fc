"""Several bodies as one, whose elements have names of their own: parts and assemblies of CAD files."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import product
from typing import TYPE_CHECKING, Any, Protocol, TypedDict

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.placing import Placing
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.polyhedron.taken_in import taken_in
from firstcontact.body.told import count, point
from firstcontact.errors import InputError
from firstcontact.exact.numbers import above, rational, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix, compose
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.value import numbers
from firstcontact.result import Element

if TYPE_CHECKING:

    from firstcontact.body.kinds import Body
    from firstcontact.exact.numbers import Given
    from firstcontact.result import Json, Table


_TAKEN_IN = Kept["Compound"]()


class PieceNames(Protocol):
    """What elements of a piece are called."""

    def of(self, kind: str, index: int, body: Body) -> tuple[str, int, str] | None:
        """(kind, index, label) of the file's own element, for one of the body; None of what is none of the file's, as a
        wall between pieces."""


@dataclass(frozen=True, eq=False)
class CompoundPiece:
    """A body, and how its elements are called; path: of the part that it belongs to, "" for the compound itself."""

    body: Any
    names: PieceNames
    path: str = ""
    corners: np.ndarray | None = None
    """(n, 3) points whose hull holds the body, where that is sooner had than from the body."""

    def element(self, element: Element, name: str) -> Element | None:
        """The element of the compound called `name`."""
        own = self.names.of(element.kind, element.index, self.body)
        if own is None:
            return None
        kind, index, label = own
        return Element(kind, name, index, " ".join(x for x in (self.path or name, label) if x))

    def mapped(self, matrix: Matrix) -> CompoundPiece:
        """The piece under an exact affine map."""
        return replace(self, body=self.body._mapped(matrix), corners=_moved(self.corners, matrix))


@dataclass(frozen=True, eq=False)
class _TakenInNames:
    """Of a mesh that was taken in: its elements are those of the mesh as it was."""

    names: PieceNames
    mesh: Polyhedron

    @cached_property
    def edges(self) -> dict[tuple[int, int], int]:
        return {(min(i, j), max(i, j)): k for k, (i, j) in enumerate(self.mesh.edges.tolist())}

    def of(self, kind: str, index: int, body: Any) -> tuple[str, int, str] | None:
        """As `PieceNames`; sides of triangles within a polygon are the polygon."""
        if kind == "edge":
            i, j = body.edges[index].tolist()
            if (known := self.edges.get((min(i, j), max(i, j)))) is not None:
                return self.names.of(kind, known, self.mesh)
            kind, index = "face", int(((body.triangles == i) | (body.triangles == j)).sum(axis=1).argmax())
        return self.names.of(kind, int(self.mesh.triangle_face[index]) if kind == "face" else index, self.mesh)


class Compound(Placing):
    """Several bodies as one: it meets what one of its pieces meets, and owns what one of them owns; immutable.

    `firstcontact.load_step` makes them.  deviation: bound of how far any point of the body's boundary is from that of
    the model that it was made of, and the other way round; 0 where they are the same.  unit: of its lengths, if known.
    """

    kind = "Compound"

    def __init__(
        self,
        pieces: Iterable[CompoundPiece],
        *,
        deviation: float = 0.0,
        unit: str | None = None,
        source: dict[str, Json] | None = None,
        shown: Callable[[], Iterable[CompoundPiece]] | None = None,
        cut: Callable[[], Compound] | None = None,
        name: str | None = None,
    ) -> None:
        """source: the table of a scene that makes the same body, where a file does.  shown: makes the polyhedra
        that pictures have instead of pieces.  cut: makes the same body of polyhedra, where it is not of such."""
        self.pieces = tuple(pieces)
        self._shown, self._cut = shown, cut
        self.deviation, self.unit, self.name = deviation, unit, name
        self._source, self._matrix = source, IDENTITY
        self._search: dict[Any, Any] = {}
        if not self.pieces:
            raise InputError(f"{name or 'compound'}: no pieces; give at least one body")
        for k, piece in enumerate(self.pieces):
            if not isinstance(piece, CompoundPiece):
                raise InputError(
                    f"{name or 'compound'}: piece {k} is {piece!r}, which has no names of a file; compounds are what "
                    "load_step makes: join solids by |, put the components of a mesh in one Polyhedron, or ask about "
                    "each body of a scene"
                )

    @cached_property
    def shown(self) -> tuple[CompoundPiece, ...]:
        """What pictures have of it: polyhedra, made when one is drawn."""
        return self.pieces if self._shown is None else tuple(self._shown())

    @property
    def is_shown_as_it_is(self) -> bool:
        """Whether pictures have its very pieces."""
        return self._shown is None

    @property
    def bounded(self) -> bool:
        return all(getattr(piece.body, "bounded", True) for piece in self.pieces)

    @property
    def exact(self) -> bool:
        """Whether no point of it is off the file's surfaces, not even by rounding."""
        return self.deviation == 0.0

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds all pieces."""
        boxes = [
            piece.body.bounds() if piece.corners is None else (piece.corners.min(axis=0), piece.corners.max(axis=0))
            for piece in self.pieces
        ]
        return np.min([lo for lo, _ in boxes], axis=0), np.max([hi for _, hi in boxes], axis=0)

    def as_triangles(self) -> Compound:
        """The body with triangles for its curved surfaces, made when it is first asked for; itself without such."""
        return self if self._cut is None else self._cut().named(self.name)

    def taken_in(self) -> Compound | None:
        """What is left where its polyhedra are taken in by its deviation; None where it has none, or rounding as much.

        Every point of a solid that is farther from the solid's surface than the deviation is in it.
        """
        def made() -> Compound:
            inner = [taken_in(x.body, self.deviation) if isinstance(x.body, Polyhedron) else None for x in self.pieces]
            if all(mesh is None for mesh in inner):
                return self
            pieces = tuple(
                x if mesh is None else replace(x, body=mesh, names=_TakenInNames(x.names, x.body), corners=None)
                for x, mesh in zip(self.pieces, inner, strict=True)
            )
            return self._with(pieces=pieces, _shown=None, _cut=None, deviation=2.0 * self.deviation, _search={})

        found = _TAKEN_IN.of(self, made)
        return None if found is self else found

    def contains(self, points: np.ndarray | Sequence[Sequence[Given]]) -> np.ndarray:
        """(n,) bools: whether the (n, 3) points are in the closed body.  InputError where a piece is a polyhedron."""
        if not all(hasattr(piece.body, "contains") for piece in self.pieces):
            who = self.name or "compound"
            raise InputError(
                f"{who}: pieces that are polyhedra do not tell what is in them; ask first_contact with a point, "
                "fc.Polyhedron([point], [])"
            )
        found = [piece.body.contains(points) for piece in self.pieces]
        told: np.ndarray = np.any(found, axis=0)
        return told

    def _with(self, **changes: object) -> Compound:
        other = object.__new__(Compound)
        other.__dict__.update(self.__dict__)
        other.__dict__.update(changes)
        return other

    def _mapped(self, matrix: Matrix) -> Compound:
        pieces = tuple(piece.mapped(matrix) for piece in self.pieces)
        shown = None if self._shown is None else lambda: (piece.mapped(matrix) for piece in self.shown)
        cut = None if self._cut is None else cache(lambda: self.as_triangles()._mapped(matrix))
        deviation = self.deviation * _stretch(matrix) if self.deviation else 0.0
        total = compose(matrix, self._matrix)
        mapped = self._with(pieces=pieces, _shown=shown, _cut=cut, deviation=deviation, _matrix=total, _search={})
        mapped.__dict__.pop("shown", None)
        return mapped

    def told(self) -> list[str]:
        """Pieces, deviation and bounds."""
        lo, hi = self.bounds()
        unit = "" if self.unit is None else f" {self.unit}"
        of = "with the file's own surfaces" if self.exact else f"within {self.deviation:.2g}{unit} of the file's"
        return [
            f"{count(len(self.pieces), 'piece')} of a STEP file, {of}",
            f"from ({point(lo)}) to ({point(hi)}){unit}",
        ]

    def _facts(self) -> tuple[Hashable, ...]:
        return (*((piece.path, piece.body._facts()) for piece in self.pieces), self.deviation, self.unit)

    def _table(self) -> Table:
        if self._source is None:
            raise InputError(f"{self.name or 'compound'} came from no file; load it from a STEP file to write it")
        made = dict(self._source)
        if self._matrix != IDENTITY:
            made["transform"] = [*numbers(self._matrix), [0, 0, 0, 1]]
        return made

    def __getstate__(self) -> dict[str, object]:
        shown = None if self._shown is None else partial(tuple, self.shown)
        cut = None if self._cut is None else partial(_itself, self.as_triangles())
        return {**self.__dict__, "_search": {}, "_matrix": numbers(self._matrix), "_shown": shown, "_cut": cut}

    def __setstate__(self, state: dict[str, Any]) -> None:
        rows = tuple(tuple(rational(x, "matrix") for x in row) for row in state["_matrix"])
        self.__dict__.update(state, _matrix=rows)

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        count = len(self.pieces)
        return f"<Compound{name}: {count} piece{'' if count == 1 else 's'}>"


def _moved(corners: np.ndarray | None, matrix: Matrix) -> np.ndarray | None:
    """The corners of a box around the image of theirs, which has room for all rounding errors."""
    if corners is None:
        return None
    m = np.array([[to_double(x) for x in row] for row in matrix])
    moved = corners @ m[:, :3].T + m[:, 3]
    room = 1e-12 * (np.abs(corners).max() * np.abs(m[:, :3]).sum(axis=1).max() + np.abs(m[:, 3]).max())
    lo, hi = moved.min(axis=0) - room, moved.max(axis=0) + room
    return np.array(list(product(*zip(lo.tolist(), hi.tolist(), strict=True))))


def _stretch(matrix: Matrix) -> float:
    """A bound of how much longer a map makes a length: its Frobenius norm, or 1 of a rotation."""
    columns = [[row[k] for row in matrix] for k in range(3)]
    dots = [sum(x * y for x, y in zip(columns[i], columns[j], strict=True)) for i in range(3) for j in range(i, 3)]
    if dots[1] == dots[2] == dots[4] == 0 and dots[0] == dots[3] == dots[5]:
        square = dots[0]
    else:
        square = dots[0] + dots[3] + dots[5]
    return 1.0 if square == 1 else float(np.nextafter(np.sqrt(above(square)), np.inf))


def _itself(body: Compound) -> Compound:
    return body


def both_taken_in(a: Body, b: Body, *, cut: bool = False) -> tuple[Body, Body] | None:
    """Two bodies, at rest or moving, as `Compound.taken_in` leaves them, where they are compounds; None where none is.

    Where these have no point in common, every common point of a and b is as near to the surface of one of their solids
    as that body deviates from its file's.  cut: they become triangles first: then as near as twice what these deviate.
    """
    inner = [_taken_in(x, cut) for x in (a, b)]
    if inner[0] is None and inner[1] is None:
        return None
    return (a if inner[0] is None else inner[0]), (b if inner[1] is None else inner[1])


def as_triangles(body: Body) -> Body:
    """A body, at rest or moving, with triangles for the curved surfaces of a file's; itself where it has none."""
    shape = shape_of(body)
    cut = shape.as_triangles() if isinstance(shape, Compound) else shape
    if cut is shape:
        return body
    return cut.moving(body.motion) if isinstance(body, Moving) else cut


def _taken_in(body: Body, cut: bool) -> Body | None:
    shape = shape_of(as_triangles(body) if cut else body)
    inner = shape.taken_in() if isinstance(shape, Compound) else None
    return inner.moving(body.motion) if isinstance(body, Moving) and inner is not None else inner


def deviation_of(body: Body) -> float | None:
    """Of a body at rest or moving; None of one that stands for itself."""
    shape = shape_of(body)
    return shape.deviation if isinstance(shape, Compound) else None


class AboutModels(TypedDict):
    """What an answer says of the models that its bodies were made of."""

    model_deviation: float | None
    unit: str | None


def about_models(a: Body, b: Body) -> AboutModels:
    known = [x for x in map(deviation_of, (a, b)) if x is not None]
    units = [unit for body in (a, b) if (unit := getattr(shape_of(body), "unit", None)) is not None]
    return {"model_deviation": sum(known) if known else None, "unit": units[0] if units else None}
