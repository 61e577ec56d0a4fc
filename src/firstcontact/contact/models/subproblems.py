"""Algorithm 1 of Choi et al. 2014: the subproblems of two models, one for every pair of features that is not exempt.

Each is one of the eleven cases (`pairs.carriers.cases`): a contact equation in the motion parameter, and at each of
its roots the real contact sets of the two whole carriers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from flint import fmpz_poly

from firstcontact.body.solid.carriers import AlgebraicPoint, Conic, Line, Plane, Point, QuarticCurve
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.square_subproblems import Near, On, SquareSubproblem, features_on, square_subproblems
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.polynomials.inertia import rank
from firstcontact.exact.polynomials.polynomial_matrix import constant
from firstcontact.pairs.carriers import (
    algebraic_points,
    conic_conic,
    conic_plane,
    conic_quadric,
    line_conic,
    line_line_carriers,
    line_quadric,
    plane_quadric,
    point_carriers,
    quadric_quadric,
)
from firstcontact.pairs.carriers.cases import Case, case_of
from firstcontact.pairs.carriers.contact import Contacts, Equation

if TYPE_CHECKING:
    from types import ModuleType

Feature = Face | Edge | Vertex


@dataclass(frozen=True)
class Subproblem:
    """Two features and their case; `a` belongs to the moving model."""

    pair: MovingPair
    a: Feature
    b: Feature
    case: str
    _equation: Callable[[], Equation]
    contacts: Callable[[Any], Contacts]
    """The real contact sets of the two carriers at a root."""

    @cached_property
    def equation(self) -> Equation:
        return self._equation()

    @property
    def on(self) -> tuple[frozenset[int], frozenset[int]]:
        """The surfaces of a and of b that hold the contact sets."""
        return frozenset(self.a.surfaces), frozenset(self.b.surfaces)

    def roots(self) -> list[AlgebraicRoot]:
        """The candidates in the piece, ascending, with their multiplicities; none where the equation vanishes."""
        polynomial, piece = self.equation.candidates, self.pair.piece
        if polynomial is None:
            return []
        assert piece.u_hi is not None
        return [root for root in real_roots(polynomial, piece.u_lo, piece.u_hi) if piece.contains(root)]


@dataclass(frozen=True)
class _Carrier:
    """A feature's carrier in the frame of b: `kind` as `pairs.carriers.cases` has it, `values` as the files take it."""

    feature: Feature
    kind: str
    values: tuple[Any, ...]
    conical: bool = field(default=False)
    """A quadric of rank 3: cone or cylinder."""


def subproblems(pair: MovingPair, near: Near | None = None) -> Iterator[Subproblem | SquareSubproblem]:
    """All of them; near: of features on these surfaces alone."""
    yield from algebraic_subproblems(pair, near)
    yield from square_subproblems(pair, near)


def algebraic_subproblems(pair: MovingPair, near: Near | None) -> Iterator[Subproblem]:
    """Those with a contact equation: faces, edges and vertices against faces, edges against edges.

    Reentrant edges need none (nothing touches one without touching a face beside it), seams neither.  A plane
    touches a cone or cylinder in a ruling, whose end lies on an edge that sees the same time (re-derived).
    """
    on_a, on_b = (None, None) if near is None else near
    faces_a, faces_b = _faces(pair, True, on_a), _faces(pair, False, on_b)
    edges_a, edges_b = _edges(pair, True, on_a), _edges(pair, False, on_b)
    corners_a, corners_b = _corners(pair, True, on_a), _corners(pair, False, on_b)
    for xs, ys in (
        (faces_a, faces_b), (faces_a, edges_b), (edges_a, faces_b), (faces_a, corners_b), (corners_a, faces_b),
        (edges_a, edges_b),
    ):  # fmt: skip
        for x in xs:
            for y in ys:
                case = case_of(x.kind, y.kind)
                if isinstance(case, Case) and not _ruling_only(x, y):
                    yield _subproblem(pair, x, y, case)


def _ruling_only(x: _Carrier, y: _Carrier) -> bool:
    return {x.kind, y.kind} == {"plane", "quadric"} and (x.conical or y.conical)


def _subproblem(pair: MovingPair, x: _Carrier, y: _Carrier, case: Case) -> Subproblem:
    first, second = (x, y) if (x.kind, y.kind) in SOLVERS else (y, x)
    equation, contacts = SOLVERS[first.kind, second.kind]
    return Subproblem(
        pair, x.feature, y.feature, case.number,
        lambda: equation(*first.values, *second.values),
        lambda root: contacts(*first.values, *second.values, root),
    )  # fmt: skip


def _conics(solver: ModuleType) -> tuple[Callable[..., Equation], Callable[..., Contacts]]:
    """Case VII takes the two matrices of each conic together."""
    return (
        lambda p, c, q, d: solver.equation((p, c), (q, d)),
        lambda p, c, q, d, root: solver.contacts((p, c), (q, d), root),
    )


SOLVERS: dict[tuple[str, str], tuple[Callable[..., Equation], Callable[..., Contacts]]] = {
    ("quadric", "quadric"): (quadric_quadric.equation, quadric_quadric.contacts),
    ("plane", "quadric"): (plane_quadric.equation, plane_quadric.contacts),
    ("conic", "quadric"): (conic_quadric.equation, conic_quadric.contacts),
    ("conic", "plane"): (conic_plane.equation, conic_plane.contacts),
    ("line", "quadric"): (line_quadric.equation, line_quadric.contacts),
    ("point", "quadric"): (point_carriers.quadric_equation, point_carriers.quadric_contacts),
    ("point", "plane"): (point_carriers.plane_equation, point_carriers.plane_contacts),
    ("algebraic point", "quadric"): (algebraic_points.quadric_equation, algebraic_points.quadric_contacts),
    ("algebraic point", "plane"): (algebraic_points.plane_equation, algebraic_points.plane_contacts),
    ("conic", "conic"): _conics(conic_conic),
    ("line", "conic"): (line_conic.equation, line_conic.contacts),
    ("line", "line"): (line_line_carriers.equation, line_line_carriers.contacts),
}


def _faces(pair: MovingPair, moving: bool, on: On) -> list[_Carrier]:
    body, forms = (pair.a, pair.forms_a) if moving else (pair.b, pair.forms_b)
    found = []
    for face in features_on(body.faces, on):
        form = forms[face.surfaces[0]]
        if isinstance(face.carrier, Plane):
            found.append(_Carrier(face, "plane", (form,)))
        else:
            found.append(_Carrier(face, "quadric", (form,), rank(face.carrier.form) == 3))
    return found


def _edges(pair: MovingPair, moving: bool, on: On) -> list[_Carrier]:
    found = []
    for edge in features_on((pair.a if moving else pair.b).edges, on):
        if edge.convexity == "reentrant":
            continue
        if isinstance(edge.carrier, QuarticCurve):
            continue  # `square_subproblems`
        basis = pair.basis(edge.carrier, moving)
        if isinstance(edge.carrier, Conic):
            found.append(_Carrier(edge, "conic", (basis, constant(edge.carrier.form))))
        else:
            assert isinstance(edge.carrier, Line)
            found.append(_Carrier(edge, "line", (basis,)))
    return found


def _corners(pair: MovingPair, moving: bool, on: On) -> list[_Carrier]:
    found = []
    for vertex in features_on((pair.a if moving else pair.b).vertices, on):
        point = vertex.carrier
        if isinstance(point, AlgebraicPoint):
            number = AlgebraicRoot(fmpz_poly([c.p for c in point.polynomial]), point.lo, point.hi)
            found.append(_Carrier(vertex, "algebraic point", (pair.basis(point, moving), number)))
        elif isinstance(point, Point):
            found.append(_Carrier(vertex, "point", (pair.basis(point, moving),)))
    return found
