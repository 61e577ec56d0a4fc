"""Ruled surfaces of several pieces, as B-splines make them."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.placing import Placing
from firstcontact.body.ruled.bounds import hull
from firstcontact.body.ruled.joints import proved_joints
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import InputError
from firstcontact.exact.rigid import Matrix

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.vectors import Vector
    from firstcontact.result import Table


class RuledStrip(Placing):
    """Several ruled surfaces as one body: it meets what one of its `pieces` meets; immutable.

    `RuledSurface.from_nurbs` makes one; parameters, directrices and trimming are those of the pieces.  Elements count
    on from piece to piece: of piece k are face k, directrix 2 k + j, end_ruling 2 k + i and vertex 4 k + 2 i + j.
    """

    kind = "RuledSurface"
    name: str | None
    pieces: tuple[RuledSurface, ...]
    _search: dict[Any, Any]

    def __init__(self, pieces: Iterable[RuledSurface], *, name: str | None = None) -> None:
        self.name = name
        self.pieces = tuple(piece if name is None else piece.named(name) for piece in pieces)
        self._search = {}
        if not self.pieces:
            raise InputError(f"{name or 'ruled strip'}: no pieces; give at least one RuledSurface")

    @property
    def deforming(self) -> bool:
        return any(piece.deforming for piece in self.pieces)

    @property
    def velocity(self) -> Vector | None:
        """As that of RuledSurface, of all pieces."""
        ways = {piece.velocity for piece in self.pieces}
        return ways.pop() if len(ways) == 1 else None

    @property
    def bounded(self) -> bool:
        return all(piece.bounded for piece in self.pieces)

    def at(self, t: Given) -> RuledStrip:
        """The strip at rest at time t, as `RuledSurface.at`."""
        return self._of(piece.at(t) for piece in self.pieces) if self.deforming else self

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds all pieces, as `RuledSurface.bounds`."""
        return hull([piece.bounds(span) for piece in self.pieces])

    def _with(self, **changes: Any) -> RuledStrip:
        other = object.__new__(RuledStrip)
        other.__dict__.update(self.__dict__)
        other.__dict__.update(_search={})
        other.__dict__.update(changes)
        if "name" in changes:
            other.pieces = tuple(piece.named(changes["name"]) for piece in self.pieces)
        return other

    def _mapped(self, matrix: Matrix) -> RuledStrip:
        return self._of(piece._mapped(matrix) for piece in self.pieces)

    def _of(self, pieces: Iterable[RuledSurface]) -> RuledStrip:
        return self._with(pieces=tuple(pieces))

    def to_mesh(self, tolerance: float) -> Polyhedron:
        """A Polyhedron of triangles, as `RuledSurface.to_mesh`."""
        from firstcontact.body.ruled.mesh import mesh

        return mesh(self.pieces, tolerance, self.name)

    def _facts(self) -> tuple[Hashable, ...]:
        return tuple(piece._facts() for piece in self.pieces)

    def _table(self) -> Table:
        joints = proved_joints(self.pieces)
        pieces = [piece._piece(piece.joined & own) for piece, own in zip(self.pieces, joints, strict=True)]
        return {"shape": "ruled", "pieces": pieces}

    def told(self) -> list[str]:
        return [line for piece in self.pieces for line in piece.told()]

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_search": {}}

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        degrees = sorted({max(piece.first.degree, piece.second.degree) for piece in self.pieces})
        shown = str(degrees[0]) if len(degrees) == 1 else f"{degrees[0]} to {degrees[-1]}"
        return f"<RuledStrip{name}: {len(self.pieces)} pieces of degree {shown}>"
