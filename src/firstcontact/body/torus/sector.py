"""Sectors of tori, as rounds and fillets of parts are: between two tubes about the same circle, up to walls.

In its own frame a sector is where, with rho the distance from the axis and s from the circle of radius `major`,
    near <= s / minor <= far,
the direction (rho - major, z) is within `around` and (x, y) within `along`.  The face of the part is where s = minor:
a round has far = 1, it is what the tube holds; a fillet has near = 1, it is what is left of a corner.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.solid.csg import And, Leaf, Or, Tree, conjunction, inside
from firstcontact.body.torus.torus import ROUNDED, Face, Torus, Wall
from firstcontact.errors import InputError
from firstcontact.exact.numbers import rational, sign, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix, apply
from firstcontact.motion.value import number, numbers
from firstcontact.result import Table

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.ring import VectorOf

Direction = tuple[fmpq, fmpq]
ZERO = fmpq(0)


@dataclass(frozen=True)
class AngleRange:
    """Directions of a plane from `first` counter-clockwise to `last`, of any length; less than a whole turn."""

    first: Direction
    last: Direction

    @classmethod
    def between(cls, first: float, last: float) -> AngleRange:
        """From one angle to another one in radians, each rounded to a direction in doubles."""
        return cls(*((rational(math.cos(x), "angle"), rational(math.sin(x), "angle")) for x in (first, last)))

    @property
    def is_wide(self) -> bool:
        """Whether it is more than half a turn."""
        (a, b), (c, d) = self.first, self.last
        return bool(a * d - b * c < 0)

    @property
    def angles(self) -> tuple[float, float]:
        """First and last angle in radians, rounded; the first in (-pi, pi]."""
        first, last = (math.atan2(to_double(y), to_double(x)) for x, y in (self.first, self.last))
        return first, last if last > first else last + 2.0 * math.pi

    @property
    def ends(self) -> tuple[tuple[int, Direction], tuple[int, Direction]]:
        """Each end's direction d, and the sign with which d x p is negative for p within, as that end tells it."""
        return (-1, self.first), (1, self.last)

    def rough(self) -> np.ndarray:
        """Angles at which coordinates of directions within are largest and least, rounded."""
        first, last = self.angles
        turns = np.arange(math.ceil(first / (0.5 * math.pi)), math.floor(last / (0.5 * math.pi)) + 1) * 0.5 * math.pi
        return np.array([first, last, *turns])


class TorusSector(Torus):
    """A piece of a part; see the module.  None for `along`, `around`: a whole turn.  Its faces: "surface",
    then the other tube, if there is one, both walls about the circle and both about the axis, if they are there.

    The tube may reach the axis, as at the rounded end of a pin, but no point of the sector is beyond it.
    """

    is_whole = False

    def __init__(
        self, major: fmpq, minor: fmpq, shares: tuple[fmpq, fmpq], around: AngleRange | None, along: AngleRange | None,
        matrix: Matrix = IDENTITY, name: str | None = None,
    ) -> None:  # fmt: skip
        self.exact_shares, self.around, self.along = shares, around, along
        if not (minor > 0 and 0 <= shares[0] < shares[1] and 1 in shares):
            raise InputError(f"{name or 'sector of a torus'}: shares {numbers(shares)} of the tube; one is 1")
        self.major = major
        along_, around_ = (sweep.angles if sweep else (0.0, 2.0 * math.pi) for sweep in (along, around))
        self.angles, self.tree, self.walls = (along_, around_), self._tree(), self._walls()
        super().__init__(major, minor, matrix, name)

    @property
    def faces(self) -> tuple[Face, ...]:
        named = (f"{self.name}.wall {k}" if self.name else f"wall {k}" for k in range(1, 6))
        return (*super().faces, *(Face(k, name) for k, name in enumerate(named, 1)))

    def _tree(self) -> Tree:
        """Of its conditions: those of the tubes, the walls about the circle, and the walls about the axis."""
        count = 1 + (self.exact_shares[0] > 0)
        terms: list[Tree] = [Leaf(k) for k in range(count)]
        for sweep in (self.around, self.along):
            if sweep is not None:
                ends = Leaf(count), Leaf(count + 1)
                terms.append(Or(*ends) if sweep.is_wide else And(*ends))
                count += 2
        return conjunction(terms)

    def _walls(self) -> list[Wall]:
        found: list[Wall] = []
        for turned, (c, s) in self.around.ends if self.around else ():
            found.append((-turned * s, ZERO, ZERO, turned * c, turned * s * self.major))
        for turned, (c, s) in self.along.ends if self.along else ():
            found.append((ZERO, -turned * s, turned * c, ZERO, ZERO))
        return found

    def _holds(self, place: list[fmpq]) -> bool:
        x, y, z = apply(self.back, (place[0], place[1], place[2]))
        square, twice = x * x + y * y, 2 * self.major
        near, far = ((share * self.minor) ** 2 for share in self.exact_shares)
        away = square + z * z + self.major * self.major  # s^2 = away - twice rho
        tubes: list[tuple[fmpq, fmpq]] = [(-twice, away - far)]
        if near:
            tubes.append((twice, near - away))
        walls = ((p, a * x + b * y + c * z + d) for p, a, b, c, d in self.walls)
        return bool(inside(self.tree, [_sign(p, square, w) <= 0 for p, w in (*tubes, *walls)]))

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the body."""
        (major, minor), (near, far), pose = self.radii, self.shares, self.pose
        v = self.around.rough() if self.around else np.arange(4) * 0.5 * math.pi
        u = self.along.rough() if self.along else np.arange(4) * 0.5 * math.pi
        s = minor * np.array([[near], [far]])
        rho, z = np.maximum(major + s * np.cos(v), 0.0), s * np.sin(v)
        out = np.array([[rho.min()], [rho.max()]])
        ends = [(x.min(), x.max()) for x in (out * np.cos(u), out * np.sin(u), z)]
        middle, half = (np.array([0.5 * (hi + sign * lo) for lo, hi in ends]) for sign in (1.0, -1.0))
        centre, reach = pose[:, :3] @ middle + pose[:, 3], np.abs(pose[:, :3]) @ half
        room = ROUNDED * (np.abs(pose[:, :3]).sum(axis=1) * (major + far * minor) + np.abs(pose[:, 3]))
        return centre - reach - room, centre + reach + room

    def is_round(self, axis: VectorOf[fmpq], point: VectorOf[fmpq]) -> bool:
        return self.along is None and super().is_round(axis, point)

    def _grid(self, tolerance: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        raise InputError(f"{self.name or 'sector of a torus'} is a piece of a part; draw, or mesh, the part")

    # -- the body as a value ----------------------------------------------------------------------------------

    def _with(self, **changes: object) -> TorusSector:
        own: dict[str, Any] = {
            "major": self.major, "minor": self.minor, "shares": self.exact_shares, "around": self.around,
            "along": self.along, "matrix": self.matrix, "name": self.name,
        }  # fmt: skip
        return TorusSector(**own | changes)

    def _facts(self) -> tuple[Hashable, ...]:
        return self.major, self.minor, self.exact_shares, self.around, self.along, self.matrix

    def _table(self) -> Table:
        raise InputError(f"{self.name or 'sector of a torus'} is a piece of a part; write the part")

    def __getstate__(self) -> dict[str, object]:
        sweeps = [sweep and numbers((sweep.first, sweep.last)) for sweep in (self.around, self.along)]
        own = [number(self.major), number(self.minor), numbers(self.exact_shares), *sweeps, numbers(self.matrix)]
        return {"own": own, "name": self.name}

    def __setstate__(self, state: dict[str, Any]) -> None:
        major, minor, shares, around, along, matrix = state["own"]
        sweeps = (x and AngleRange(*((rational(a, "x"), rational(b, "y")) for a, b in x)) for x in (around, along))
        rows: Any = tuple(tuple(_exact(row)) for row in matrix)
        self.__init__(  # type: ignore[misc]
            *_exact((major, minor)), tuple(_exact(shares)), *sweeps, rows, state["name"]
        )

    def _radii_told(self) -> str:
        return f"{super()._radii_told()}, a sector"


def _exact(given: Iterable[Given]) -> list[fmpq]:
    return [rational(x, "number") for x in given]


def _sign(p: fmpq, q: fmpq, w: fmpq) -> int:
    """Of p sqrt(q) + w."""
    of_p, of_w = sign(p) if q else 0, sign(w)
    if of_p * of_w >= 0:
        return of_p or of_w
    return of_p * sign(p * p * q - w * w)
