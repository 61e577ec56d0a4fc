"""Ruled surfaces in scene files: two directrices, several such pieces, or a NURBS grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from pydantic import StrictStr, model_validator

from firstcontact.body.ruled.joints import proved_joints
from firstcontact.body.ruled.rational_curve import RationalCurve
from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import InputError
from firstcontact.scene.values import Directrix, Numbers, Placed, Range, Table, Vector, at_key

CURVES = {"first", "second", "u", "s", "trim", "joined"}
GRID = {"points", "knots", "weights", "degree"}


class Piece(Table):
    """Directrices as strings or as tables of coefficients; "all": every u, or whole rulings."""

    first: Directrix = None
    second: Directrix = None
    u: Range = (0, 1)
    s: Range = (0, 1)
    trim: list[StrictStr] = []
    joined: list[Literal["u0", "u1", "s0", "s1"]] = []
    """Borders at which the surface goes on, in this piece or another one."""

    def surface(self, name: str | None) -> RuledSurface:
        """The piece, on its own."""
        curves = []
        for key in ("first", "second"):
            given = getattr(self, key)
            if given is None:
                raise InputError(f"{key} is missing; give first and second")
            with at_key(key):
                curves.append(given if isinstance(given, str) else RationalCurve(**given))
        return RuledSurface(*curves, u=self.u, s=self.s, trim=self.trim, name=name)


class Ruled(Piece, Placed):
    """One piece, `pieces`, or a NURBS grid."""

    shape: Literal["ruled"]
    pieces: list[Piece] | None = None
    points: list[list[Vector]] | None = None
    knots: Numbers = None
    weights: Numbers = None
    degree: Any = None

    @model_validator(mode="after")
    def _one_kind(self) -> Ruled:
        given = self.model_fields_set
        kind = next((key for key in ("points", "pieces") if key in given), None)
        if kind is None and not {"first", "second"} <= given:
            raise ValueError("give first and second, or points; for a NURBS surface points, knots and weights")
        own = {"points": GRID, "pieces": {"pieces"}, None: CURVES}[kind]
        wrong = sorted(given & (CURVES | GRID | {"pieces"}) - own)
        if wrong:
            raise ValueError(f"{wrong[0]} does not go with {kind or 'first and second'}; leave it out")
        return self

    def build_surface(self, name: str | None) -> RuledSurface | RuledStrip:
        if self.points is not None:
            return RuledSurface.from_nurbs(self.points, self.knots, self.weights, degree=self.degree, name=name)
        if self.pieces is None:
            return _joined([self.surface(name)], [self])[0]
        surfaces = []
        for k, piece in enumerate(self.pieces):
            with at_key(f"pieces[{k}]"):
                surfaces.append(piece.surface(name))
        return RuledStrip(_joined(surfaces, self.pieces), name=name)


def _joined(surfaces: list[RuledSurface], tables: Sequence[Piece]) -> list[RuledSurface]:
    """The pieces with the joints that were given, after a look whether they are there: a search skips joints."""
    if not any(table.joined for table in tables):
        return surfaces
    for k, (table, proved) in enumerate(zip(tables, proved_joints(surfaces), strict=True)):
        for border in table.joined:
            if border not in proved:
                raise InputError(f"joined: no piece goes on at {border} of piece {k}; leave it out")
    joints = (frozenset(str(border) for border in table.joined) for table in tables)
    return [surface._with(joined=joined) for surface, joined in zip(surfaces, joints, strict=True)]
