"""Names, placements and motions: what all bodies have in common."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Any, ClassVar, Self, overload

from firstcontact.body.kept import Kept
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational
from firstcontact.exact.rigid import Matrix, determinant, near_rotation, shift
from firstcontact.motion.moving import Moving
from firstcontact.motion.translation import vector3
from firstcontact.result import SCHEMA, Written

if TYPE_CHECKING:
    from flint import fmpq

    from firstcontact.exact.numbers import Given
    from firstcontact.exact.ring import VectorOf
    from firstcontact.motion.arrays import Motions, MovingEach
    from firstcontact.motion.kinds import AnyMotion
    from firstcontact.result import Table

_HASH = Kept[int]()


class Placing(Written):
    """A body at rest that makes placed copies of itself by `_mapped` (exact affine maps) and `_with` (attributes).

    Bodies are values: equal where names, elements and exact coordinates are.  Searches never compare them, but keep
    what they work out on the body itself.
    """

    name: str | None
    _search: dict[Any, Any]
    kind: ClassVar[str]
    """The family of the body: what the table of pairs knows it by."""

    def is_round(self, axis: VectorOf[fmpq], point: VectorOf[fmpq]) -> bool:
        """Whether every turn about the line through the point along the axis is proved to leave the body as it is."""
        return False

    def _mapped(self, matrix: Matrix) -> Self:
        raise NotImplementedError

    def _with(self, **changes: object) -> Self:
        raise NotImplementedError

    def _facts(self) -> tuple[Hashable, ...]:
        """What makes the body what it is, but for its name; hashable."""
        raise NotImplementedError

    def _table(self) -> Table:
        """The body as a table of a scene file, but for its name."""
        raise NotImplementedError

    def told(self) -> list[str]:
        """What it is made of, line by line, for readers."""
        raise NotImplementedError

    def to_dict(self) -> Table:
        """The body's table in a scene file; exact numbers that no double holds are texts such as "1/3"."""
        name = {} if self.name is None else {"name": self.name}
        return {"schema": SCHEMA, **self._table(), **name}

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        same: Any = other
        return self.name == same.name and hash(self) == hash(other) and self._facts() == same._facts()

    def __hash__(self) -> int:
        return _HASH.of(self, lambda: hash(self._facts()))

    def named(self, name: str | None) -> Self:
        if name is not None and not isinstance(name, str):
            raise InputError(f"name is {shown(name)}; give a text")
        return self._with(name=name)

    def translated(self, v: Iterable[Given]) -> Self:
        """The body shifted by v, exactly."""
        return self._mapped(shift(vector3(v, "translation")))

    def rotated(self, axis: Iterable[Given], *, degrees: Given, point: Iterable[Given] = (0, 0, 0)) -> Self:
        """The body turned about an axis, right-hand rule.

        The rotation used is rational and within 2^-60 of the angle (exact for half turns, and for quarter
        turns about axes of rational length).
        """
        h = vector3(axis, "rotation axis")
        if not any(h):
            raise InputError("rotation axis is zero; give a direction such as (0, 0, 1)")
        turns = rational(degrees, "rotation degrees") / 360
        return self._mapped(near_rotation(h, vector3(point, "rotation point"), turns))

    def transformed(self, matrix4: Iterable[Iterable[Given]]) -> Self:
        """The body under a (4, 4) affine map, exactly; maps may mirror and scale, but not be singular."""
        try:
            rows = [list(row) for row in matrix4]
        except TypeError:
            rows = []
        if len(rows) != 4 or any(len(row) != 4 for row in rows):
            raise InputError("transformed() needs a 4x4 matrix; give four rows of four numbers")
        m = [[rational(x, f"matrix[{i}][{j}]") for j, x in enumerate(row)] for i, row in enumerate(rows)]
        if m[3] != [0, 0, 0, 1]:
            raise InputError("the last row of the matrix is not (0, 0, 0, 1); give an affine map")
        matrix: Matrix = (tuple(m[0]), tuple(m[1]), tuple(m[2]))  # type: ignore[assignment]
        if determinant(matrix) == 0:
            raise InputError("the matrix is singular; give an invertible affine map")
        return self._mapped(matrix)

    @overload
    def moving(self, motion: Motions) -> MovingEach: ...
    @overload
    def moving(self, motion: AnyMotion) -> Moving: ...
    def moving(self, motion: AnyMotion | Motions) -> Moving | MovingEach:
        """This body under a motion; under each one of an array of motions, for `first_contacts`."""
        return motion.of(self) if hasattr(motion, "of") else Moving(self, motion)

    def at(self, t: float) -> Self:
        """Itself: a body at rest is in the same pose at all times."""
        return self
