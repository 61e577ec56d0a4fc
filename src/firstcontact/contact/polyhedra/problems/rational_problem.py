"""One piece of rational motion: every answer for a pair of elements is exact."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from functools import cached_property
from typing import Any

from flint import ctx, fmpz, fmpz_poly

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.problems.curved_problem import Corners, CurvedProblem
from firstcontact.exact.fields.conditions import ParameterConditions, between, distinct
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import exact_value
from firstcontact.exact.rigid import Matrix
from firstcontact.exact.times.instants import enclose
from firstcontact.exact.times.root_instants import RootInstant
from firstcontact.exact.vectors import Vector, sub, whole
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.polynomial import PolynomialPiece
from firstcontact.pairs.elements import moving
from firstcontact.result import ExactTime
from firstcontact.search.trees.elements import Feature, Primitive, corners_of


class RationalProblem(CurvedProblem[RootInstant]):
    """A piece whose pose is a rational function of the time: every answer is exact."""

    def __init__(self, a: Polyhedron, b: Polyhedron, piece: CurvedPiece) -> None:
        super().__init__(a, b, piece)
        self.lo, self.hi = piece.start, piece.end

    @cached_property
    def path(self) -> PolynomialPiece:
        """The relative motion; most searches end without it."""
        assert self.piece.polynomial is not None
        return self.piece.polynomial

    @cached_property
    def back(self) -> projective.Matrix:
        """The pose of b seen from a."""
        return projective.inverse(self.path.pose, self.lo)

    def conditions(self, pair: Corners) -> list[ParameterConditions]:
        """When the two elements share a point: when one of these holds."""
        scale, corners = whole(*pair[0], *pair[1])
        x, y = corners[: len(pair[0])], corners[len(pair[0]) :]
        if len(x) == 1:
            found = moving.vertex_facet(moving.times(self.path.pose, x[0], scale), *y)
        elif len(y) == 1:
            found = moving.vertex_facet(moving.times(self.back, y[0], scale), *x)
        else:
            found = self._edges(x, y, scale)
        return [replace(c, zero=tuple(map(self._over_weight, c.zero))) for c in found]

    def _over_weight(self, p: fmpz_poly) -> fmpz_poly:
        """The polynomial over what it has in common with the weight, which has no zero in the piece.

        What is left is mostly irreducible, which is soon seen; products of large factors are slow to take apart.
        """
        weight = self.path.pose[3][3]
        return p // p.gcd(weight) if weight.degree() > 0 and p else p

    def _edges(self, x: list[Vector], y: list[Vector], scale: fmpz) -> list[ParameterConditions]:
        """Edges that cross, and where that is not all, ends of one on the other."""
        pose = self.path.pose
        start = moving.times(pose, x[0], scale)
        crossing = moving.edge_edge_crossing(start, moving.turned(pose, sub(x[1], x[0])), *y)
        if not crossing.lasting and not self._parallel_at_events(crossing):
            return [crossing]
        found = [crossing]
        for p in x:
            found += moving.vertex_edge(moving.times(pose, p, scale), *y)
        for p in y:
            found += moving.vertex_edge(moving.times(self.back, p, scale), *x)
        return found

    def _parallel_at_events(self, crossing: ParameterConditions) -> bool:
        common = crossing.zero[0].gcd(crossing.more[0])
        return common.degree() > 0 and bool(real_roots(common, self.lo, self.hi))

    def contact(self, element_a: Feature, element_b: Feature) -> RootInstant | None:
        """The earliest time of the window at which the two elements share a point; exact."""
        pair = corners_of(self.a, element_a), corners_of(self.b, element_b)
        found = [c.earliest(self.lo, self.hi) for c in self.conditions(pair)]
        roots = distinct(r for r in found if r is not None)
        return RootInstant(roots[0], self.lo) if roots else None

    def contact_within(self, element_a: Feature, element_b: Feature, lo: float, hi: float) -> RootInstant | None:
        """The same, of two elements of which floats have proved that they meet in [lo, hi], and not before lo.

        Elements that meet lie in a plane: where they do so once in that time, it is then.
        """
        equation = self._coplanar(corners_of(self.a, element_a), corners_of(self.b, element_b))
        if lo > 0.0 and equation:
            roots = real_roots(self._over_weight(equation), self.lo + exact_value(lo), self.lo + exact_value(hi))
            if len(roots) == 1 and roots[0].compare(self.hi) <= 0:
                return RootInstant(roots[0], self.lo)
        return self.contact(element_a, element_b)

    def _coplanar(self, corners_a: list[Vector], corners_b: list[Vector]) -> Any:
        """What vanishes where the two elements lie in a plane."""
        scale, corners = whole(*corners_a, *corners_b)
        x, y = corners[: len(corners_a)], corners[len(corners_a) :]
        if len(x) == 1:
            return moving.above_facet(moving.times(self.path.pose, x[0], scale), *y)
        if len(y) == 1:
            return moving.above_facet(moving.times(self.back, y[0], scale), *x)
        edge = moving.turned(self.path.pose, sub(x[1], x[0]))
        return moving.above_line(moving.times(self.path.pose, x[0], scale), edge, *y)

    def events(
        self, a: Primitive, b: Primitive, pairs: list[tuple[Hashable, Corners]]
    ) -> list[tuple[RootInstant, bool]]:
        """The instants at which contact may begin or end, both ends of the piece too where there is contact."""
        found: list[AlgebraicRoot] = []
        touching: list[AlgebraicRoot] = []
        for _, pair in pairs:
            for c in self.conditions(pair):
                events = c.events(self.lo, self.hi)
                held = [root for root in events if c.hold(root)]
                found += events if c.lasting else held
                touching += held
        contacts = distinct(touching)
        out = [
            (RootInstant(root, self.lo), any(root.compare(other) == 0 for other in contacts))
            for root in distinct(found)
        ]
        return out

    def pose_between(self, x: RootInstant, y: RootInstant) -> Matrix:
        """The pose of a at a time between x and y (at x when they are equal); exact."""
        time = x.root.rational if x.root.compare(y.root) == 0 else between(x.root, y.root)
        assert time is not None
        rows = projective.value(self.path.pose, time)
        return tuple(rows[0]), tuple(rows[1]), tuple(rows[2])

    def float_window(self, lo: float, hi: float) -> tuple[RootInstant, RootInstant]:
        """A certain window given by doubles, clipped to the piece."""
        first = min(max(self.lo + exact_value(lo), self.lo), self.hi)
        last = min(max(self.lo + exact_value(hi), self.lo), self.hi)
        return RootInstant.at(first, self.lo), RootInstant.at(last, self.lo)

    # -- answers --------------------------------------------------------------------------------------------

    def start_instant(self) -> RootInstant:
        return RootInstant.at(self.lo, self.lo)

    def end_instant(self) -> RootInstant:
        return RootInstant.at(self.hi, self.lo)

    def world_instant(self, at: RootInstant, turn: int = 0) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant in the motions' clock."""
        value = at.root.rational
        return enclose(lambda: at.root.enclosure(ctx.prec) if value is None else value)

    def world_exact(self, at: RootInstant, turn: int = 0) -> ExactTime:
        return at.root.number()
