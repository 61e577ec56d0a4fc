"""Subproblems without a single contact equation: edges of degree 4, and vertices where three quadrics meet.

Their candidates are the zeros of direct square systems (re-derived; Choi et al. 2014 leave them out).  Edge {A, B}
against a surface C: A = B = C = 0 and det(grad A, grad B, grad C) = 0; against the edge {C, D}: A = B = C = D = 0;
vertex {A, B, C} against a surface D: A = B = C = D = 0.  Unknowns are the point and the motion parameter u.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from flint import fmpq, fmpq_mat, fmpz_poly

from firstcontact.body.solid.carriers import EnclosedPoint, Plane, QuarticCurve, doubles, upright
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.common_box import Box, common_box
from firstcontact.contact.models.moving_pair import Form, MovingPair, without_factor
from firstcontact.contact.models.system_search import FoundZeros, SearchedSolid, StandingZeros, standing, zeros_within
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import exact_value, precision, simplest_in
from firstcontact.exact.polynomials.inertia import dot
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, congruent, constant
from firstcontact.exact.systems.square_systems import (
    EnclosedNumber,
    EnclosedRoot,
    OpenRoot,
    SquareSystem,
    Zero,
    certified,
)
from firstcontact.motion.moving import shape_of
from firstcontact.pairs.carriers.contact import Contacts, Equation, Vector, finite, gather, nothing

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Feature = Face | Edge | Vertex
F = TypeVar("F", Face, Edge, Vertex)
On = Collection[int] | None
"""Surfaces of a model: only features on these are looked at; None: all."""
Near = tuple[Collection[int], Collection[int]]
"""The same of both."""

EDGE_SURFACE = "A = B = C = det(grad A, grad B, grad C) = 0"
CROSSING = "A = B = C = D = 0"
NO_ZERO = "no zero of the system"
RATIONAL_BITS = 192
"""Of balls in which short fractions are looked for."""


@dataclass(frozen=True)
class View:
    """One model of a pair at rest, the other as seen from it."""

    pair: MovingPair
    moving: bool
    """Whether the model at rest is the one that moves in the pair."""

    @property
    def own(self) -> CompositeQuadric:
        return self.pair.a if self.moving else self.pair.b

    @property
    def other(self) -> CompositeQuadric:
        return self.pair.b if self.moving else self.pair.a

    @cached_property
    def own_forms(self) -> list[Matrix]:
        return [constant(surface.matrix()) for surface in self.own.surfaces]

    @cached_property
    def other_forms(self) -> list[Matrix]:
        if not self.moving:
            return [_matrix(form) for form in self.pair.forms_a]
        pose, lo = self.pair.piece.pose, self.pair.piece.u_lo
        return [without_factor(congruent(pose, _matrix(form)), lo) for form in self.pair.forms_b]

    def rational_in_frame_of_b(self, x: Vector, u: fmpq) -> Vector:
        """A point (x, y, z) of the model at rest, homogeneous."""
        if not self.moving:
            return (*x, fmpq(1))
        return tuple(dot([c(u) for c in row], (*x, 1)) for row in self.pair.piece.pose)

    def solids(self, own: frozenset[int], other: frozenset[int]) -> list[SearchedSolid]:
        """Both, with the surfaces that hold the zeros."""
        sides = (self.own, self.own_forms, own), (self.other, self.other_forms, other)
        return [SearchedSolid(model.tree, forms, near) for model, forms, near in sides]

    def in_frame_of_b(self, zero: Zero) -> Vector:
        """The point of a zero, homogeneous."""
        if not self.moving:
            return (*(EnclosedNumber(zero, lambda x, k=k: x[k]) for k in range(3)), 1)
        return tuple(
            EnclosedNumber(zero, lambda x, r=row: sum((r[k](x[3]) * x[k] for k in range(3)), r[3](x[3])))
            for row in self.pair.piece.pose
        )


def _rank_at(rows: Sequence[Sequence[fmpz_poly]], u: fmpq) -> int:
    return int(fmpq_mat([[fmpq(p(u)) for p in row] for row in rows]).rank())


def _rank(rows: Sequence[Sequence[fmpz_poly]]) -> int:
    """The rank over Q(u): the largest at more values of u than a minor has roots."""
    degree = sum(max(int(p.degree()) for p in row) for row in rows)
    return max(_rank_at(rows, fmpq(u)) for u in range(degree + 1))


def _samples(edge: Edge) -> np.ndarray:
    """(n, 3) points inside the pieces."""
    parts = [np.linspace(piece.lo, piece.hi, 9)[1:-1] for piece in edge.pieces]
    return edge.points(np.concatenate(parts))


def _across(body: CompositeQuadric, edge: Edge, p: np.ndarray) -> Matrix:
    """The plane through p across the edge."""
    x = (*map(exact_value, p), fmpq(1))
    a, b = (np.array(doubles((body.surfaces[k].gradient(x),))[0]) for k in edge.surfaces[:2])
    normal = np.cross(a, b)
    normal /= np.abs(normal).max() or 1.0
    return constant(Plane((*map(exact_value, normal), -exact_value(float(normal @ p)))).matrix())


def _instant(u: fmpq) -> Matrix:
    """The form with the value (u' - u) q at every point, q the denominator of u."""
    nil = fmpz_poly([0])
    return ((nil,) * 4, (nil,) * 4, (nil,) * 4, (nil, nil, nil, fmpz_poly([-u.p, u.q])))


def _entries(form: Matrix) -> tuple[fmpz_poly, ...]:
    return tuple(form[i][j] for i in range(4) for j in range(i + 1))


def _matrix(form: Form) -> Matrix:
    """A plane's N.X w, twice, as a symmetric matrix; a quadric's own."""
    if isinstance(form[0], tuple):
        return form
    a, b, c, d = form
    nil = fmpz_poly([0])
    return ((nil, nil, nil, a), (nil, nil, nil, b), (nil, nil, nil, c), (a, b, c, 2 * d))


@dataclass(frozen=True)
class SquareSubproblem:
    """Two features and their system; as `Subproblem`, but its roots are enclosed, and `OpenRoot` what stays open."""

    pair: MovingPair
    a: Feature
    b: Feature
    case: str
    view: View
    system: SquareSystem
    system_text: str
    box: Box

    @cached_property
    def equation(self) -> Equation:
        if self.slides:
            return Equation(None, f"identically dependent: {self.system_text}")
        return Equation(None, f"a square system: {self.system_text}")

    @cached_property
    def slides(self) -> bool:
        """Whether the forms are dependent for all u: a feature slides in a surface, and faces beside it see events."""
        *rest, last = self.system.forms
        return self._is_dependent(rest, last)

    @cached_property
    def on(self) -> tuple[frozenset[int], frozenset[int]]:
        """The surfaces of a and of b that hold the zeros: their forms are combinations of the system's for all u."""
        own, other = (
            frozenset(k for k, form in enumerate(forms) if self._is_dependent(self.system.forms, form))
            for forms in (self.view.own_forms, self.view.other_forms)
        )
        return (own, other) if self.view.moving else (other, own)

    def _is_dependent(self, forms: Sequence[Matrix], form: Matrix) -> bool:
        """Whether the form is a combination of the others over Q(u)."""
        rows = [_entries(f) for f in (*forms, form)]
        u = self.pair.piece.u_lo + fmpq(355, 113 * 1024)  # at one u first: ranks fall at few
        if _rank_at(rows, u) == len(rows):
            return False
        return _rank(rows) == _rank(rows[:-1])

    @cached_property
    def _is_still(self) -> bool:
        """Whether there is one u only at which to look."""
        piece = self.pair.piece
        return piece.is_constant or piece.u_hi is None or piece.u_hi <= piece.u_lo

    @cached_property
    def _solids(self) -> list[SearchedSolid]:
        return self.view.solids(*(self.on if self.view.moving else self.on[::-1]))

    @cached_property
    def _found(self) -> FoundZeros:
        """The zeros of a motion."""
        piece = self.pair.piece
        assert piece.u_hi is not None
        slabs = max(1, self.system.degree // 4)
        return zeros_within(self.system, self._solids, self.box, (piece.u_lo, piece.u_hi), slabs)

    @cached_property
    def _standing(self) -> StandingZeros:
        """Where the features touch at the only u."""
        return standing(self.system, self._solids, self.box, self.pair.piece.u_lo)

    @cached_property
    def _rational(self) -> list[tuple[fmpq, ...] | None]:
        """x, y, z, u of each zero that is found; None where they are not the short fractions next to it."""
        return [self._rational_at(zero) for zero in self._found.zeros]

    def _rational_at(self, zero: Zero) -> tuple[fmpq, ...] | None:
        with precision(RATIONAL_BITS):
            *x, u = map(simplest_in, zero.balls(RATIONAL_BITS))
        return (*x, u) if self.system.vanishes_at(x, u) else None

    def _candidates(self) -> list[EnclosedRoot | AlgebraicRoot | OpenRoot]:
        piece = self.pair.piece
        if self.slides:
            return []
        if self._is_still:
            some = self._standing.points or self._standing.is_open
            return [AlgebraicRoot.of(piece.u_lo)] if some else []
        assert piece.u_hi is not None
        reason = f"precision: {self.a.name} with {self.b.name}, {self.system_text}"
        zeros = zip(self._found.zeros, self._rational, strict=True)
        roots = [EnclosedRoot(zero) if known is None else AlgebraicRoot.of(known[3]) for zero, known in zeros]
        return roots + [OpenRoot(max(lo, piece.u_lo), min(hi, piece.u_hi), reason) for lo, hi in self._found.open]

    def roots(self) -> list[EnclosedRoot | AlgebraicRoot | OpenRoot]:
        """The candidates in the piece whose points both closed models may hold."""
        return [root for root in self._candidates() if isinstance(root, OpenRoot) or self.pair.piece.contains(root)]

    def contacts(self, root: EnclosedRoot | AlgebraicRoot) -> Contacts:
        """The points of the system's zeros; at a rational u, points of a feature that slides in a surface."""
        if isinstance(root, EnclosedRoot):
            return finite((self.view.in_frame_of_b(root.zero),))
        u = root.rational
        if u is None:
            return nothing(NO_ZERO)
        if not self.slides:
            return self._at_rational(u)
        if isinstance(self.a, Edge) and isinstance(self.b, Edge):
            return nothing("the faces beside the edges see where they meet")
        zeros = self._sliding_points(u)
        return gather([finite((self.view.in_frame_of_b(zero),)) for zero in zeros], "no point proved")

    def _at_rational(self, u: fmpq) -> Contacts:
        """The rational zeros at u."""
        if self._is_still:
            points = self._standing.points
        else:
            points = [x[:3] for x in self._rational if x is not None and x[3] == u]
        sets = gather([finite((self.view.rational_in_frame_of_b(x, u),)) for x in points], NO_ZERO)
        return replace(sets, complete=not (self._is_still and self._standing.is_open))

    def _sliding_points(self, u: fmpq) -> Iterator[Zero]:
        """Points of the feature of degree 4 or of three quadrics at u, proved."""
        own = self.a if self.view.moving else self.b
        if isinstance(own, Vertex):
            guides: list[tuple[np.ndarray, tuple[Matrix, ...]]] = [(np.array(own.position), ())]
        else:
            assert isinstance(own, Edge)
            guides = [(p, (_across(self.view.own, own, p),)) for p in _samples(own)]
        for p, planes in guides:
            fixed = self.system.forms[: 3 - len(planes)]
            system = SquareSystem([*fixed, *planes, _instant(u)])
            zero = certified(system, [*map(exact_value, p), u], [fmpq(1, 10**8)] * 4)
            if zero is not None:
                yield zero


def square_subproblems(pair: MovingPair, near: Near | None) -> Iterator[SquareSubproblem]:
    """Edges of degree 4 against faces and edges, enclosed vertices against faces."""
    for moving in (True, False):
        view = View(pair, moving)
        own, other = (None, None) if near is None else near if moving else near[::-1]
        for edge in features_on(quartic_edges(view.own), own):
            yield from _of_edge(view, edge, other, quartics_too=moving)
        for vertex in features_on(view.own.vertices, own):
            if isinstance(vertex.carrier, EnclosedPoint):
                yield from _of_vertex(view, vertex, vertex.carrier, other)


def needs_systems(body: Body) -> bool:
    """Whether the model, at rest or moving, has features without a single contact equation."""
    model = shape_of(body)
    return bool(quartic_edges(model)) or any(isinstance(x.carrier, EnclosedPoint) for x in model.vertices)


def quartic_edges(body: CompositeQuadric) -> list[Edge]:
    return [e for e in body.edges if isinstance(e.carrier, QuarticCurve) and e.convexity != "reentrant"]


def features_on(features: Sequence[F], surfaces: On) -> Sequence[F]:
    """Those that lie on none but these surfaces, all where these are None."""
    if surfaces is None:
        return features
    return [x for x in features if all(k in surfaces for k in x.surfaces)]


def _of_edge(view: View, edge: Edge, near: On, quartics_too: bool) -> Iterator[SquareSubproblem]:
    box = common_box(view.pair, view.moving)
    if box is None:
        raise UnsupportedPair(f"{edge.name}: no bound of its body is known; intersect it with a box")
    first = [view.own_forms[k] for k in edge.surfaces[:2]]
    for face in features_on(view.other.faces, near):
        forms = [*first, view.other_forms[face.surfaces[0]]]
        yield _task(view, edge, face, forms, EDGE_SURFACE, box)
    for other in features_on(view.other.edges, near):
        if other.convexity == "reentrant" or (isinstance(other.carrier, QuarticCurve) and not quartics_too):
            continue
        forms = [*first, *(view.other_forms[k] for k in _two_surfaces(view.other, other))]
        yield _task(view, edge, other, forms, CROSSING, box)


def _of_vertex(view: View, vertex: Vertex, point: EnclosedPoint, near: On) -> Iterator[SquareSubproblem]:
    forms = [view.own_forms[k] for k in _three_surfaces(view.own, vertex)]
    radius = point.radius + fmpq(1, 2**40) * (1 + max(abs(c) for c in point.centre))
    box = tuple(c - radius for c in point.centre[:3]), tuple(c + radius for c in point.centre[:3])
    for face in features_on(view.other.faces, near):
        yield _task(view, vertex, face, [*forms, view.other_forms[face.surfaces[0]]], CROSSING, box)


def _task(
    view: View, own: Feature, other: Feature, forms: list[Matrix], text: str, box: Box
) -> SquareSubproblem:
    a, b = (own, other) if view.moving else (other, own)
    return SquareSubproblem(view.pair, a, b, "degree 4", view, SquareSystem(forms), text, box)


def _two_surfaces(body: CompositeQuadric, edge: Edge) -> list[int]:
    """Of the surfaces that hold the edge, two that cross there: those of its faces where it has two."""
    if isinstance(edge.carrier, QuarticCurve):
        return list(edge.surfaces[:2])
    numbers = dict.fromkeys(body.faces[k].surfaces[0] for k in edge.faces)
    ordered = sorted(numbers, key=lambda k: not isinstance(body.surfaces[k], Plane))
    different: dict[Any, int] = {}
    for k in (*ordered, *edge.surfaces):  # rims of open meshes and bare edges have planes from both sides
        different.setdefault(upright(tuple(x for row in body.surfaces[k].matrix() for x in row)), k)
    return list(different.values())[:2]


def _three_surfaces(body: CompositeQuadric, vertex: Vertex) -> tuple[int, ...]:
    """Of the surfaces through the vertex, the three whose normals there are farthest from dependent."""
    x = [fmpq(*float(c).as_integer_ratio()) for c in vertex.position]

    def volume(chosen: tuple[int, ...]) -> float:
        rows = np.array([doubles((body.surfaces[k].gradient((*x, fmpq(1))),))[0] for k in chosen])
        return float(abs(np.linalg.det(rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300))))

    return max(combinations(vertex.surfaces, 3), key=volume)
