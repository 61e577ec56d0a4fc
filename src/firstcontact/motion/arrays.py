"""Many motions as arrays, one for each question of a batch."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.body.placing import Placing
    from firstcontact.exact.numbers import Given, Nested
    from firstcontact.motion.kinds import Single
    from firstcontact.motion.moving import Moving


class Motions:
    """n motions; `body.moving(motions)` is that body under each of them, for `first_contacts`.

    `motions[i]` is motion i, as every other verb takes it; a slice or an array of rows gives several.
    """

    def __len__(self) -> int:
        raise NotImplementedError

    def one(self, row: int) -> Single:
        """Motion `row`."""
        raise NotImplementedError

    def taken(self, rows: slice | np.ndarray) -> Self:
        """Those of a slice or of an array of rows."""
        raise NotImplementedError

    def _facts(self) -> tuple[object, ...]:
        """What they are made of: arrays with a row for each motion first."""
        raise NotImplementedError

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Motions) or type(self) is not type(other):
            return NotImplemented
        pairs = zip(self._facts(), other._facts(), strict=True)
        return all(np.array_equal(np.asarray(x), np.asarray(y)) for x, y in pairs)

    def __hash__(self) -> int:
        return hash((type(self), len(self)))

    def of(self, body: Placing) -> MovingEach:
        """The body under each of them."""
        return MovingEach(body, self)

    @overload
    def __getitem__(self, rows: int | np.integer) -> Single: ...
    @overload
    def __getitem__(self, rows: slice | np.ndarray) -> Self: ...
    def __getitem__(self, rows: int | np.integer | slice | np.ndarray) -> Single | Self:
        if not isinstance(rows, int | np.integer):
            return self.taken(rows)
        if not -len(self) <= rows < len(self):
            raise IndexError(f"motion {rows} of {len(self)}")
        return self.one(int(rows) % len(self))

    def __iter__(self) -> Iterator[Single]:
        return (self.one(k) for k in range(len(self)))

    def __repr__(self) -> str:
        return f"<{len(self)} {type(self).__name__}>"


class Translations(Motions):
    """Motions by ``t * vectors[i]``.

    vectors: (n, 3) doubles, taken as the exact binary rationals that they are.

    >>> Translations([(1, 0, 0), (0, 2, 0)])[1]
    Translation((0.0, 2.0, 0.0))
    """

    def __init__(self, vectors: Nested) -> None:
        self.vectors = _doubles(vectors, (3,), "Translations: vectors")

    def __len__(self) -> int:
        return len(self.vectors)

    def _facts(self) -> tuple[object, ...]:
        return (self.vectors,)

    def one(self, row: int) -> Translation:
        return Translation(self.vectors[row].tolist())

    def taken(self, rows: slice | np.ndarray) -> Translations:
        some = copy(self)
        some.vectors = self.vectors[rows]
        return some


class Rotations(Motions):
    """Turns about the lines through points along axes, right-hand rule, by angles over the span (0, 1).

    axes, points: (n, 3) doubles, or one axis, one point for all.  Exactly one of radians, degrees, turns: (n,) doubles
    or one number.

    >>> Rotations((0, 0, 1), degrees=[30, 60])[1]
    Rotation((0.0, 0.0, 1.0), point=(0.0, 0.0, 0.0), turns=0.16666666666666666)
    """

    def __init__(
        self,
        axes: Nested,
        points: Nested = (0, 0, 0),
        *,
        radians: Nested | Given = None,
        degrees: Nested | Given = None,
        turns: Nested | Given = None,
    ) -> None:
        given = {"radians": radians, "degrees": degrees, "turns": turns}
        named = [unit for unit, angles in given.items() if angles is not None]
        if len(named) != 1:
            raise InputError("Rotations needs exactly one of radians=, degrees=, turns=")
        self.unit = named[0]
        columns = [
            _doubles(np.atleast_2d(np.asarray(axes, object)), (3,), "Rotations: axes"),
            _doubles(np.atleast_2d(np.asarray(points, object)), (3,), "Rotations: points"),
            _doubles(np.atleast_1d(np.asarray(given[self.unit], object)), (), f"Rotations: {self.unit}"),
        ]
        counts = {len(x) for x in columns} - {1}
        if len(counts) > 1:
            raise InputError(f"Rotations: {sorted(counts)} axes, points and angles; give as many of each, or one")
        n = counts.pop() if counts else 1
        self.axes, self.points, self.angles = (np.broadcast_to(x, (n, *x.shape[1:])) for x in columns)
        still = np.flatnonzero(~self.axes.any(axis=1))
        if len(still):
            raise InputError(f"Rotations: axes[{still[0]}] is zero; give a direction such as (0, 0, 1)")

    def __len__(self) -> int:
        return len(self.angles)

    def _facts(self) -> tuple[object, ...]:
        return self.axes, self.points, self.angles, self.unit

    def one(self, row: int) -> Rotation:
        angle: dict[str, Any] = {self.unit: float(self.angles[row])}
        return Rotation(self.axes[row].tolist(), self.points[row].tolist(), **angle)

    def taken(self, rows: slice | np.ndarray) -> Rotations:
        angles: dict[str, Any] = {self.unit: self.angles[rows]}
        return Rotations(self.axes[rows], self.points[rows], **angles)

    def angle(self, row: int) -> tuple[fmpq, fmpq]:
        """(radians, turns) of motion `row`, exact; one of them is 0."""
        x = exact_value(self.angles[row])
        if self.unit == "radians":
            return x, fmpq(0)
        return fmpq(0), x / 360 if self.unit == "degrees" else x


class Poses(Motions):
    """Motions from one pose to another by `RationalMotion.between`.

    poses: (n, 2, 4, 4) doubles, rigid; snap: as `between` has it.

    >>> Poses([[np.eye(4), np.eye(4)]])[0](0.5)[0]
    array([1., 0., 0., 0.])
    """

    def __init__(self, poses: Nested, snap: Given = None) -> None:
        self.poses = _doubles(poses, (2, 4, 4), "Poses: poses")
        self.snap = snap

    def __len__(self) -> int:
        return len(self.poses)

    def _facts(self) -> tuple[object, ...]:
        return self.poses, self.snap

    def one(self, row: int) -> RationalMotion:
        options: dict[str, Any] = {} if self.snap is None else {"snap": self.snap}
        return RationalMotion.between(*self.poses[row], **options)

    def taken(self, rows: slice | np.ndarray) -> Poses:
        return Poses(self.poses[rows], self.snap)


class MovingEach:
    """A body under many motions, each for a question of its own; `moving[i]` is the body under motion i."""

    __slots__ = ("body", "motions")

    body: Any
    """At rest."""
    motions: Motions

    def __init__(self, body: Placing, motions: Motions) -> None:
        self.body, self.motions = body, motions

    @property
    def name(self) -> str | None:
        name: str | None = self.body.name
        return name

    def __len__(self) -> int:
        return len(self.motions)

    def __getitem__(self, row: int) -> Moving:
        moving: Moving = self.body.moving(self.motions[row])
        return moving

    def __repr__(self) -> str:
        return f"{self.body!r} moving by {self.motions!r}"


def _doubles(values: Nested, shape: tuple[int, ...], what: str) -> np.ndarray:
    """The values as an array of doubles (n, *shape) of its own; InputError names the first one that is none."""
    wanted = f"({', '.join(map(str, ('n', *shape)))}{',' if not shape else ''})"
    if isinstance(values, np.ndarray) and np.iscomplexobj(values):
        raise InputError(f"{what} are complex; {wanted} doubles are wanted")
    try:
        array = np.array(values, float)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{what}{_place(values)} {wanted} doubles are wanted") from error
    if array.shape[1:] != shape or array.ndim != 1 + len(shape):
        raise InputError(f"{what} have the shape {array.shape}; give {wanted} doubles")
    if not np.isfinite(array).all():
        place = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        raise InputError(f"{what}{''.join(f'[{k}]' for k in place)} is {array[place]}; give a finite number")
    return array


def _place(values: Nested) -> str:
    """Which of nested lists of numbers is no number."""
    try:
        array = np.asarray(values, object)
        for place, x in np.ndenumerate(array):
            try:
                float(x)
            except (TypeError, ValueError, OverflowError):
                return f"{''.join(f'[{k}]' for k in place)} is {x!r};"
    except ValueError:
        pass
    return " are not all of one shape;"
