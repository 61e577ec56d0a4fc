"""When a place of a ruled piece lies in a solid of planes and quadrics: signs of polynomials in u, s and T.

In the solid's frame the piece is X = (1 - s) first + s second, homogeneous with positive weight, and each surface of
the solid a polynomial X^T Q X (of planes N.X).  The solid's tree tells from their signs whether it holds the place;
zeros count as either sign, for the solid is closed.  There is no equation: what stands for Delta is zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from flint import fmpq, fmpz, fmpz_mpoly

from firstcontact.body.ruled.rational_curve import lifted
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.carriers import Plane
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import outcomes, possible
from firstcontact.contact.signs.conditions import (
    Range,
    Sides,
    Trims,
    bound_once,
    check_weight,
    is_definite,
    local_trims,
    polynomials,
    reversed_trims,
    without_factors,
)
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import rational
from firstcontact.exact.polynomials.trivariate import RING, at, irreducible

if TYPE_CHECKING:
    from firstcontact.body.solid.carriers import Quadric

UNIT = fmpq(0), fmpq(1)
_HELD = {"solid": ({True}, {True, False}), "boundary": ({True, False},)}


@dataclass(frozen=True)
class SolidConditions:
    """Of one piece and one piece of its motion, as `contact.signs.conditions.Conditions` for two pieces.

    forms   those of the solid's surfaces, zero or of their signs
    kept    trimming polynomials, not negative on the piece
    sides   the directrices in the solid's frame
    part    which places count: those in the "solid" or on its "boundary"
    active  numbers of the polynomials that may vanish where places count; None for all of them
    """

    forms: tuple[fmpz_mpoly, ...]
    kept: tuple[fmpz_mpoly, ...]
    u: Range
    sides: Sides
    trims: Trims
    solid: CompositeQuadric
    part: str = "solid"
    active: frozenset[int] | None = None
    moment: fmpq | None = None
    known: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    v: ClassVar[Range] = UNIT
    delta: ClassVar[fmpz_mpoly] = RING.constant(0)

    @classmethod
    def of(
        cls, surface: RuledSurface, sides: Sides, solid: CompositeQuadric, span: tuple[fmpq, fmpq]
    ) -> SolidConditions:
        """sides: those of the surface in the solid's frame over the span of the motion's parameter."""
        if surface.s is None:
            raise UnsupportedPair(f"{surface!r}: whole rulings that are trimmed or deform meet no solids; bound s")
        for side in sides:
            check_weight(surface, side, span)
        ends = None if surface.u is None else (rational(surface.u[0], "u"), rational(surface.u[1], "u"))
        return cls._over(ends, sides, local_trims(surface), solid)

    @classmethod
    def _over(cls, u: Range, sides: Sides, trims: Trims, solid: CompositeQuadric) -> SolidConditions:
        first, second = (lifted(curve.components, RING, "u") for curve in sides)
        s = RING.gen(1)
        x = [(1 - s) * a * second[3] + s * b * first[3] for a, b in zip(first[:3], second[:3], strict=True)]
        x.append(first[3] * second[3])
        forms = tuple(_without_definite(_form(surface, x)) for surface in solid.surfaces)
        return cls(forms, tuple(polynomials(trims)), u, sides, trims, solid)

    @property
    def polynomials(self) -> list[fmpz_mpoly]:
        return [self.delta, *self.forms, *self.kept]

    @property
    def walls(self) -> list[fmpz_mpoly]:
        every = self.polynomials
        return every if self.active is None else [every[k] for k in sorted(self.active)]

    @cached_property
    def may_be_thin(self) -> bool:
        """False proves that no trimming inequality leaves parts of the piece without area."""
        return bool(self.trims) and not bound_once(self.trims, self.u, True)

    def holds(self, sign: Callable[[fmpz_mpoly], int], on_delta: bool = False) -> bool:
        """Whether a place of the piece counts, from the signs there."""
        if any(sign(f) < 0 for f in self.kept):
            return False
        return outcomes(self.solid.tree, [sign(f) for f in self.forms]) in _HELD[self.part]

    def excludes(self, above: np.ndarray, below: np.ndarray) -> np.ndarray:
        """As that of two pieces."""
        first, last = 1, 1 + len(self.forms)
        held, free = possible(self.solid.tree, list(~above[:, first:last].T), list(~below[:, first:last].T))
        counts = held & free if self.part == "boundary" else held
        out: np.ndarray = ~counts | below[:, last:].any(axis=1)
        return out

    def at(self, t: fmpq) -> SolidConditions:
        """The conditions at one time."""
        return replace(self, forms=tuple(at(f, 2, t) for f in self.forms), moment=t, known={})

    def only(self, part: str) -> SolidConditions:
        return replace(self, part=part, known={})

    @cached_property
    def charts(self) -> dict[tuple[bool, bool], SolidConditions]:
        """Over finite ranges, by whether they are conditions on 1/u; on 1/s there is none."""
        if self.u is not None:
            return {(False, False): self}
        unit = fmpq(-1), fmpq(1)
        turned = self.sides[0].reversed(), self.sides[1].reversed()
        found = {}
        for inverse, sides, trims in ((False, self.sides, self.trims), (True, turned, reversed_trims(self.trims))):
            chart = replace(self._over(unit, sides, trims, self.solid), part=self.part, active=self.active)
            found[inverse, False] = chart if self.moment is None else chart.at(self.moment)
        return found


def _form(surface: Plane | Quadric, x: list[fmpz_mpoly]) -> fmpz_mpoly:
    """A positive multiple of the surface's form at X."""
    if isinstance(surface, Plane):
        terms = list(zip(surface.normal, x, strict=True))
    else:
        terms = [(surface.form[i][j], x[i] * x[j]) for i in range(4) for j in range(4)]
    below = reduce(fmpz.lcm, (c.q for c, _ in terms), fmpz(1))
    return sum(((c * below).p * y for c, y in terms if c), RING.constant(0))


def _without_definite(f: fmpz_mpoly) -> fmpz_mpoly:
    """f without its factors that are positive everywhere."""
    if f.is_zero():
        return f
    return without_factors(f, [g for g in irreducible(f) if is_definite(g)])
