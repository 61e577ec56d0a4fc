"""The largest connected set that two touching models share: an arc, a patch of a plane, a segment, or a point.

What is shared beyond points lies in carriers that lie in one another: planes that are one, straight lines of one model
in surfaces of the other.  Those are told exactly; doubles then find where to look, and a point placed exactly in the
common plane or line decides.  So the ends may live in fields that have nothing in common.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.solid.carriers import Conic, Line, Plane
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.algorithm import Meeting, Root
from firstcontact.contact.models.moving_pair import Form, MovingPair, is_plane
from firstcontact.contact.models.shared.contact_sets import Shared, TrimForms, scaled, shared_part
from firstcontact.contact.models.shared.membership import On, Vector, in_both
from firstcontact.contact.models.shared.patches import along_surface, beside, border
from firstcontact.exact.fields.number_field import NumberField, is_zero
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import exact_value
from firstcontact.exact.pencils.pencils import binary_zeros, combination
from firstcontact.exact.polynomials.inertia import dot, null_space, rank
from firstcontact.exact.polynomials.polynomial_matrix import congruent, constant, minors, transpose
from firstcontact.pairs.carriers.contact import Contact, columns, vector_at, zero

if TYPE_CHECKING:
    from firstcontact.body.solid.carriers import Quadric
    from firstcontact.exact.fields.number_field import FieldElement
    from firstcontact.exact.ring import MatrixOf

NEAR = 1e-9
"""Of the size of the coordinates: points nearer to each other than that are one."""
NEAREST = 1e-14
"""The same of corners, exact points rounded: a patch may be as thin as that."""
MOST_CORNERS = 12
"""Corners of a patch that are looked at."""

Feature = Face | Edge | Vertex
Span = tuple[Vector, Vector]
Set = tuple[str, np.ndarray]


def largest_set(pair: MovingPair, root: Root, meetings: Sequence[Meeting]) -> Set:
    """(kind, (n, 3) points in the frame of b) as in `ContactSet`."""
    arcs = [m.shared.points for m in meetings if m.shared.kind == "conic arc"]
    if arcs:
        touching = _Touching(pair, root, meetings) if isinstance(root, AlgebraicRoot) else None
        patch = None if touching is None else touching.patch(arcs)
        if touching is not None and patch is None and touching.has_curved_patch(arcs):
            patch = np.concatenate(arcs)
        return ("conic arc", arcs[0]) if patch is None else ("patch", patch)
    segments = [m.shared for m in meetings if m.shared.kind == "segment"]
    # the corners of a patch and the ends of a segment are all on edges, and so among the meetings
    if isinstance(root, AlgebraicRoot) and len(_distinct(meetings, pair.unit)) > 1:
        touching = _Touching(pair, root, meetings)
        patch = touching.patch()
        if patch is not None:
            return "patch", patch
        segments += touching.segments()
    if segments:
        return "segment", max((s.points for s in segments), key=lambda ends: np.linalg.norm(ends[1] - ends[0]))
    return "point", meetings[0].shared.points


def _distinct(meetings: Sequence[Meeting], unit: float, near: float = NEAR) -> list[Meeting]:
    """One meeting for each point."""
    found: list[Meeting] = []
    for meeting in meetings:
        where = meeting.shared.points[0]
        size = unit + np.abs(where).max()
        if all(np.abs(where - other.shared.points[0]).max() > near * size for other in found):
            found.append(meeting)
    return found


class _Touching:
    """The surfaces and edges that meet at an algebraic time."""

    def __init__(self, pair: MovingPair, root: AlgebraicRoot, meetings: Sequence[Meeting]) -> None:
        self.pair, self.root, self.field = pair, root, NumberField(root)
        self.meetings = meetings
        tasks = [m.candidate.subproblem for m in meetings]
        self.surfaces = {
            pair_ for t in tasks for pair_ in product(_with_seams(pair.a, t.a), _with_seams(pair.b, t.b))
        }
        self.edges = {(side, e.index): e for t in tasks for side, e in _edges(pair, t.a, t.b)}

    # -- planes -----------------------------------------------------------------------------------------------

    def patch(self, arcs: Sequence[np.ndarray] = ()) -> np.ndarray | None:
        """The corners and arcs in a common plane, if both models hold a point there between or beside them."""
        for i, j in sorted(self.surfaces):
            form_a, form_b = self.pair.forms_a[i], self.pair.forms_b[j]
            if is_plane(form_a) and is_plane(form_b):
                plane = vector_at(self.field, form_b)
                if zero(minors((vector_at(self.field, form_a), plane), 2)):
                    corners = self._corners(plane)
                    flat = [arc for arc in arcs if self._is_in(plane, arc)]
                    if self._is_patch(corners, flat, plane, i, j):
                        return border(flat, corners)
        return None

    def _corners(self, plane: Vector) -> list[np.ndarray]:
        distinct = _distinct([m for m in self.meetings if m.shared.kind != "conic arc"], self.pair.unit, NEAREST)
        return [m.shared.points[0] for m in distinct if is_zero(dot(plane, m.shared.at))]

    def _is_in(self, plane: Vector, points: np.ndarray) -> bool:
        """Whether points lie in a plane, by doubles."""
        form = scaled(plane, 1.0)[0]
        terms = np.column_stack([points * form[:3], np.full(len(points), form[3])])
        return bool(np.all(np.abs(terms.sum(axis=1)) <= NEAR * np.abs(terms).sum(axis=1)))

    def _is_patch(self, corners: list[np.ndarray], arcs: list[np.ndarray], plane: Vector, i: int, j: int) -> bool:
        trim = TrimForms(self.pair, self.root, On({i}), On({j}))
        for place in (*_between(corners), *(p for arc in arcs for p in beside(arc))):
            middle = np.append(place / self.pair.unit, 1.0)
            if trim.inside(middle[None])[0]:
                if not in_both(self.pair, _in_plane(plane, middle, self.pair.unit), self.root, On({i}), On({j})):
                    return True
        return False

    # -- curved surfaces --------------------------------------------------------------------------------------

    def has_curved_patch(self, arcs: Sequence[np.ndarray]) -> bool:
        """Whether two surfaces are one and both models hold a part of it beside one of the arcs, as doubles tell."""
        for i, j in sorted(self.surfaces):
            form_a, form_b = self.pair.forms_a[i], self.pair.forms_b[j]
            if is_plane(form_a) or is_plane(form_b):
                continue
            rows = [[x for row in self.field.matrix(form) for x in row] for form in (form_a, form_b)]
            if zero(minors(rows, 2)):
                trim = TrimForms(self.pair, self.root, On({i}), On({j}))
                form = trim.models[1][1][j]
                places = np.array([p for arc in arcs for p in along_surface(form, arc / self.pair.unit)])
                if trim.inside(places).any():
                    return True
        return False

    # -- lines ------------------------------------------------------------------------------------------------

    def segments(self) -> Iterator[Shared]:
        """What both models hold of their straight edges, and of the rulings that planes touch."""
        for line in (*self._rulings(), *self._straight()):
            on_a, on_b = (
                On([k for k, form in enumerate(forms) if self._contains(form, line)])
                for forms in (self.pair.forms_a, self.pair.forms_b)
            )
            parts, _ = shared_part(self.pair, Contact("line", line), self.root, on_a, on_b)
            yield from _joined([part for part in parts if part.kind == "segment"], self.pair.unit)

    def _contains(self, form: Form, line: Span) -> bool:
        if is_plane(form):
            plane = vector_at(self.field, form)
            return all(is_zero(dot(plane, x)) for x in line)
        on_line = congruent(transpose(line), self.field.matrix(form))
        return zero(on_line[0]) and zero(on_line[1])

    def _rulings(self) -> Iterator[Span]:
        a, b = self.pair.a, self.pair.b
        for i, j in sorted(self.surfaces):
            x, y = self.pair.forms_a[i], self.pair.forms_b[j]
            if is_plane(x) and _is_conical(b.surfaces[j]):
                yield from self._ruling(x, y)
            elif is_plane(y) and _is_conical(a.surfaces[i]):
                yield from self._ruling(y, x)

    def _ruling(self, plane: Form, quadric: Form) -> Iterator[Span]:
        """The double line in which a tangent plane cuts a cone or cylinder."""
        basis = _kernel(vector_at(self.field, plane))
        section = congruent(transpose(basis), self.field.matrix(quadric))
        row = next((r for r in section if not zero(r)), None)
        if row is not None and zero(minors(section, 2)):
            p, q = (combination(basis, y) for y in _kernel(row))
            yield p, q

    def _straight(self) -> Iterator[Span]:
        for (moving, _), edge in sorted(self.edges.items()):
            carrier = edge.carrier
            if isinstance(carrier, Line):
                p, q = columns(self.field.matrix(self.pair.basis(carrier, moving)))
                yield p, q
            elif isinstance(carrier, Conic):
                yield from _lines_of(
                    columns(self.field.matrix(self.pair.basis(carrier, moving))),
                    self.field.matrix(constant(carrier.form)),
                )


def _between(corners: list[np.ndarray]) -> Iterator[np.ndarray]:
    """The middle of every three of the corners that are in no line."""
    for x, y, z in combinations(corners[:MOST_CORNERS], 3):
        area = np.linalg.norm(np.cross(y - x, z - x))
        far = max(np.linalg.norm(y - x), np.linalg.norm(z - x))
        if area > NEAREST * far * far:
            yield (x + y + z) / 3


def _with_seams(body: CompositeQuadric, feature: Feature) -> set[int]:
    """The surfaces of a feature, and those that join a face smoothly: no edge tells of them where they touch."""
    if not isinstance(feature, Face):
        return set(feature.surfaces)
    return {s for seam in body.seams if feature.index in seam.faces for s in seam.surfaces} | set(feature.surfaces)


def _edges(pair: MovingPair, a: Feature, b: Feature) -> Iterator[tuple[bool, Edge]]:
    """The edges of the features, and those that end in them: (of the moving model, edge)."""
    for moving, body, feature in ((True, pair.a, a), (False, pair.b, b)):
        if not isinstance(feature, Face):
            yield from ((moving, e) for e in body.edges if set(e.surfaces) <= set(feature.surfaces))


def _is_conical(carrier: Plane | Quadric) -> bool:
    return not isinstance(carrier, Plane) and rank(carrier.form) == 3


def _lines_of(basis: Sequence[Vector], form: MatrixOf[FieldElement]) -> Iterator[Span]:
    """The two lines of a conic of rank 2: edges that are straight, but not rational."""
    null = null_space(form)
    if len(null) != 1:
        return
    (double,) = null
    k = next(i for i in range(3) if not is_zero(double[i]))
    i, j = (n for n in range(3) if n != k)
    for y in binary_zeros(((form[i][i], form[i][j]), (form[i][j], form[j][j]))):
        yield combination(basis, double), combination((basis[i], basis[j]), y)


def _kernel(form: Vector) -> list[Vector]:
    """A basis of the zeros of a linear form that is not 0, without divisions."""
    k = next(i for i, x in enumerate(form) if not is_zero(x))
    zero_ = form[k] * 0
    return [
        tuple(form[k] if n == i else -form[i] if n == k else zero_ for n in range(len(form)))
        for i in range(len(form)) if i != k
    ]  # fmt: skip


def _joined(parts: Sequence[Shared], unit: float) -> list[Shared]:
    """Segments of one line, those that continue each other as one."""
    joined: list[Shared] = []
    for part in parts:
        last = joined[-1].points if joined else None
        if last is not None and np.abs(last[1] - part.points[0]).max() <= NEAR * (unit + np.abs(last).max()):
            joined[-1] = Shared("segment", part.at, np.array([last[0], part.points[1]]))
        else:
            joined.append(part)
    return joined


def _in_plane(plane: Vector, near: np.ndarray, unit: float) -> Vector:
    """The exact point of the plane near a point given in doubles: a rational combination of points that span it."""
    basis = _kernel(plane)
    known = [scaled(x, unit) for x in basis]
    weights = np.linalg.lstsq(np.array([double for double, _ in known]).T, near, rcond=None)[0]
    return combination(basis, [exact_value(w) / size for w, (_, size) in zip(weights, known, strict=True)])
