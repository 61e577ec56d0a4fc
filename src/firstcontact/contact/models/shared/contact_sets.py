"""What of a contact set of two whole carriers lies in both models: points, segments of lines, arcs of conics.

Where a set is more than a point its ends and a point inside are found in doubles; the point is then placed exactly and
decides.  Ends of segments lie on edges, so pieces that doubles miss are seen there.  Of conics all stretches between
surfaces are told with proof, where spots that doubles leave open are looked at in the same way; where no point of one
is held, exact counts of zeros tell whether surfaces cross the conic there at all.
Points in doubles are homogeneous, in lengths of `Pair.unit`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.csg import possible
from firstcontact.contact.models.moving_pair import Form, MovingPair, form_at, is_plane
from firstcontact.contact.models.shared.held_parts import TURN, ConicPart, HeldParts, ModelForms, on_faces
from firstcontact.contact.models.shared.membership import On, Vector, in_both
from firstcontact.exact.fields.number_field import NumberField, QuadraticElement, ball, sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import exact_value, precision
from firstcontact.exact.pencils.conic_pencils import ConicMeeting, conic_contacts
from firstcontact.exact.pencils.pencils import characteristic, discriminant
from firstcontact.exact.polynomials.inertia import dot, times, value
from firstcontact.exact.vectors import cross
from firstcontact.pairs.carriers import planar_conics
from firstcontact.pairs.carriers.contact import Contact, vector_at, zero

if TYPE_CHECKING:
    from firstcontact.exact.polynomials.inertia import Rows
    from firstcontact.exact.systems.square_systems import EnclosedRoot

ARC_POINTS = 720
"""Points along a whole conic."""
FEWEST = 9
"""Points along a part of one, however short: which side of it both models hold is looked for from its middle."""
OPEN = "it is not told whether they share a point of a curve"
OUTSIDE = "outside the faces"
AT_INFINITY = 1e-12
"""The weight of a point beyond which it is at infinity, in parts of its coordinates."""
NOUGHT = 1e-3
"""Of a point's size: coordinates that are smaller count as that large.  One that is 0 but for rounding, of a point on
a plane through the origin, has no size of its own to measure that rounding by."""


@dataclass(frozen=True)
class Shared:
    """A connected part of a contact set in both models.

    kind: "point", "segment" or "conic arc"; at: one of its points, exact, homogeneous, in the frame of b;
    points: (n, 3) float64, the point, the two ends, or points along the arc; closed: a whole ellipse.
    """

    kind: str
    at: Vector
    points: np.ndarray
    closed: bool = False


def shared_part(
    pair: MovingPair, contact: Contact, root: AlgebraicRoot | EnclosedRoot, on_a: On, on_b: On
) -> tuple[list[Shared], str]:
    """The parts of the contact set that both models hold, or the reason why there is none."""
    if contact.kind == "point":
        (x,) = contact.span
        reason = in_both(pair, x, root, on_a, on_b)
        return ([], reason) if reason else ([Shared("point", x, cartesian(x)[None])], "")
    trim = TrimForms(pair, root, on_a, on_b)
    if contact.kind == "conic":
        return _conic_parts(contact, trim, pair, root, on_a, on_b)
    parts = _segments(contact, trim)
    found = [part for part in parts if not in_both(pair, part.at, root, on_a, on_b)]
    return found, "" if found else OUTSIDE


def _conic_parts(
    contact: Contact, trim: TrimForms, pair: MovingPair, root: AlgebraicRoot | EnclosedRoot, on_a: On, on_b: On
) -> tuple[list[Shared], str]:
    """What both models hold of a conic, with proof; or that this is open."""
    curve = _Conic(contact, pair.unit)
    if curve.frame is None:
        return [], OUTSIDE
    parts = HeldParts(curve.frame, trim.models, NOUGHT)
    stretches = parts.found()
    spots = [s for s in stretches if s.inner is None]
    places = [(s, s.inner) for s in stretches if s.inner is not None]
    for tried in (places, [(None, t) for spot in spots for t in parts.places(spot)]):
        held = (curve.part(stretch, t, trim.unit) for stretch, t in tried)
        found = [part for part in held if part is not None and not in_both(pair, part.at, root, on_a, on_b)]
        if found:
            return found, ""
    if not isinstance(root, AlgebraicRoot):
        return [], OPEN
    field = NumberField(root)

    def exact(m: int, k: int) -> Form:
        form = (pair.forms_a, pair.forms_b)[m][k]
        return vector_at(field, form) if is_plane(form) else field.matrix(form)

    steady = not places or all(curve.keeps_side(exact(m, k)) for m, k in parts.along)
    told = steady and all(not parts.may_hold(spot) or _is_empty(spot, parts, curve, exact) for spot in spots)
    return [], OUTSIDE if told else OPEN


def _is_empty(spot: ConicPart, parts: HeldParts, curve: _Conic, exact: Callable[[int, int], Form]) -> bool:
    """Whether all zeros on the conic of the forms that may vanish in a spot are outside it, by their exact number."""
    for m, k in parts.open_forms(spot):
        form = exact(m, k)
        count = curve.zeros(form)
        line = parts.frame.T @ (2.0 * parts.trims[m].forms[k][3] * [1.0, 1.0, 1.0, 0.5]) if is_plane(form) else None
        if count is None or count > parts.changes(m, k, spot, line):
            return False
    return True


def cartesian(x: Vector) -> np.ndarray:
    """(3,) doubles nearest the point, or nearly."""
    values = [ball(c, 128) for c in x]
    with precision(128):
        return np.array([float((c / values[3]).mid()) for c in values[:3]])


class TrimForms:
    """The forms of both models in doubles at the root, and where points lie in both."""

    def __init__(self, pair: MovingPair, root: AlgebraicRoot | EnclosedRoot | EnclosedRoot, on_a: On, on_b: On) -> None:
        u = root.enclosure(128)
        self.unit = pair.unit
        self.models: list[ModelForms] = []
        for body, forms, on in ((pair.a, pair.forms_a, on_a), (pair.b, pair.forms_b, on_b)):
            with precision(128):
                matrices = np.array([_matrix(form_at(form, u), is_plane(form), pair.unit) for form in forms])
            self.models.append(ModelForms(body.tree, matrices, np.isin(np.arange(len(forms)), list(on.surfaces)), on))

    def breaks(self, origin: np.ndarray, direction: np.ndarray) -> Iterator[float]:
        """Parameters s at which origin + s direction crosses a surface of either model."""
        for _, matrices, holds, _ in self.models:
            for form in matrices[~holds]:
                coefficients = direction @ form @ direction, 2 * origin @ form @ direction, origin @ form @ origin
                if not np.any(coefficients[:2]):
                    continue
                a, b, c = coefficients
                if a and abs(b * b - 4 * a * c) <= 1e-13 * (b * b + abs(4 * a * c)):  # double, as rounding hides
                    yield -b / (2 * a)
                    continue
                yield from (s.real for s in np.roots(coefficients) if abs(s.imag) < 1e-9 * (1 + abs(s)))

    def inside(self, points: np.ndarray) -> np.ndarray:
        """(n,) bools for (n, 4) points: in both closed models and on the faces asked for, as far as doubles tell."""
        answer = np.ones(len(points), bool)
        sizes = np.abs(points)
        sizes += NOUGHT * sizes.max(axis=1, initial=0.0, keepdims=True)
        for tree, matrices, holds, on in self.models:
            values = np.einsum("ni,sij,nj->sn", points, matrices, points)
            slack = 1e-10 * np.einsum("ni,sij,nj->sn", sizes, abs(matrices), sizes)
            slack[holds] = np.inf
            below, above = values < slack, values > -slack
            answer &= possible(tree, below, above)[0]
            if on.faces:
                answer &= on_faces(tree, below, above, on)
        return answer


def _matrix(form: Any, plane: bool, unit: float) -> np.ndarray:
    if not plane:
        rows = [list(row) for row in form]
    else:
        rows = [[arb(0)] * 4 for _ in range(4)]
        rows[3] = [x / 2 for x in form]
        for k in range(4):
            rows[k][3] = rows[3][k]
        rows[3][3] = form[3]
    units = 1.0, 1.0, 1.0, unit
    rows = [[x / u / v for x, v in zip(row, units, strict=True)] for row, u in zip(rows, units, strict=True)]
    largest = max(abs(x.mid()) for row in rows for x in row)
    return np.array([[float((x / largest).mid()) for x in row] for row in rows])


def _segments(contact: Contact, trim: TrimForms) -> Iterator[Shared]:
    first, second = contact.span
    if sign(first[3]) == 0:
        first, second = second, first
    # X(s) = first + s second, first finite: a scale near 1 for doubles, any for the exact point
    (direction, size), (origin, own_size) = scaled(second, trim.unit), scaled(first, trim.unit)
    weight = origin[3]
    origin = origin / weight
    ends = sorted(set(trim.breaks(origin, direction)))
    for lo, hi in zip(ends, ends[1:], strict=False):
        middle = 0.5 * (lo + hi)
        x = origin + middle * direction
        if hi - lo > 1e-9 * (1 + abs(middle)) and trim.inside(x[None])[0] and abs(x[3]) > 1e-12:
            r = exact_value(middle * weight) * own_size / size
            at = tuple(a + b * r for a, b in zip(first, second, strict=True))
            points = np.array([(origin + s * direction)[:3] / (origin + s * direction)[3] for s in (lo, hi)])
            yield Shared("segment", at, trim.unit * points)


def scaled(x: Vector, unit: float) -> tuple[np.ndarray, fmpq]:
    """(the homogeneous point in lengths of `unit`, in doubles about 1; the power of two that it was divided by)"""
    values = [ball(c, 64) for c in x]
    with precision(64):
        values[3] = values[3] * unit
        mantissa, exponent = arb(max(abs(v.mid()) for v in values).mid()).man_exp()
        size = fmpq(2) ** int(exponent + mantissa.bit_length())
        return np.array([float((v / arb(size)).mid()) for v in values]), size


class _Conic:
    """axes (cos t, sin t, 1), t from 0 to TURN, in the plane of a conic; frame None where it has no real points."""

    def __init__(self, contact: Contact, unit: float) -> None:
        self.contact = contact
        span, form, self.sizes = _balanced(contact, unit)
        values, vectors = np.linalg.eigh(form)
        if values[1] > 0:  # signs (-, +, +): the odd one last
            values, vectors = values[::-1], vectors[:, ::-1]
        # lines of a pair are other pairs' contacts
        proper = values[2] * values[1] < 0 < values[0] * values[1]
        self.axes = vectors / np.sqrt(np.abs(values)) if proper else vectors
        self.frame: np.ndarray | None = span @ self.axes if proper else None

    def part(self, stretch: ConicPart | None, t: float, unit: float) -> Shared | None:
        """What is held about t; None where that is at infinity."""
        near = self.axes @ (round(math.cos(t), 15), round(math.sin(t), 15), 1.0)
        at = _on_conic(self.contact, self.axes[:, 2], near, self.sizes)
        if stretch is None:
            return _shared("point", at, self.frame, [t], unit)
        length = stretch.hi - stretch.lo
        angles = np.linspace(stretch.lo, stretch.hi, max(FEWEST, 2 + round(ARC_POINTS * length / TURN)))
        closed = length >= TURN * (1.0 - 1e-12)
        return _shared("conic arc", at, self.frame, angles[:-1] if closed else angles, unit, closed)

    def keeps_side(self, form: Form) -> bool:
        """Whether a plane or quadric over the field vanishes all along it, or nowhere."""
        conic, other = self._within(form)
        along = zero(other) if is_plane(form) else _touches_as(ConicMeeting.SAME, conic, other)
        return along or self.zeros(form) == 0

    def _within(self, form: Any) -> tuple[Any, Any]:
        """The conic's form and that of a plane or quadric, in the basis of the conic's plane."""
        span = self.contact.span
        if is_plane(form):
            return self.contact.form, [dot(form, x) for x in span]
        return self.contact.form, tuple(tuple(dot(x, times(form, y)) for y in span) for x in span)

    def zeros(self, form: Form) -> int | None:
        """How many real zeros a plane or quadric over the field has on it; None where two are one."""
        conic, other = self._within(form)
        if is_plane(form):
            adjoint = [cross(conic[(i + 1) % 3], conic[(i + 2) % 3]) for i in range(3)]
            side = sign(value(adjoint, other))
            return None if side == 0 else 2 if side < 0 else 0
        side = sign(discriminant(characteristic(conic, other)))
        if side == 0:
            return 0 if _touches_as(ConicMeeting.IMAGINARY, conic, other) else None
        return 2 if side < 0 else 4 if planar_conics.cross(conic, other) else 0


def _touches_as(meeting: ConicMeeting, first: Rows, second: Rows) -> bool:
    """Whether two conics of one plane do."""
    return any(found.meeting is meeting for found in conic_contacts(first, second).tangencies)


def _shared(
    kind: str, at: Vector, frame: np.ndarray | None, t: Sequence[float] | np.ndarray, unit: float, closed: bool = False
) -> Shared | None:
    """A part with its points at the parameters t; None where one is at infinity."""
    assert frame is not None
    x = (frame @ np.stack([np.cos(t), np.sin(t), np.ones(len(t))])).T
    if (np.abs(x[:, 3]) <= AT_INFINITY * np.abs(x).max()).any():
        return None
    return Shared(kind, at, unit * x[:, :3] / x[:, 3:], closed)


def _balanced(contact: Contact, unit: float) -> tuple[np.ndarray, np.ndarray, list[fmpq]]:
    """(basis of the plane, columns about 1 in lengths of `unit`; the conic in it; what takes its y to the contact's)

    Without it small values of the form drown in the rounding of large ones, where models are large or small.
    """
    rows = [scaled(x, unit) for x in contact.span]
    form = contact.form
    assert form is not None
    sizes = [size for _, size in rows]
    with precision(64):
        balls = [[ball(form[i][j], 64) / arb(sizes[i]) / arb(sizes[j]) for j in range(3)] for i in range(3)]
        largest = max(abs(x.mid()) for row in balls for x in row)
        values = np.array([[float((x / largest).mid()) for x in row] for row in balls])
    return np.array([row for row, _ in rows]).T, values, [1 / size for size in sizes]


def _on_conic(contact: Contact, inner: np.ndarray, near: np.ndarray, sizes: Sequence[fmpq]) -> Vector:
    """The exact point of the conic near y = `near`, on the line from the rational point `inner` within it.

    Both in the basis that `_balanced` gives; sizes: what makes them the y of the contact.
    """
    c = [exact_value(v) * size for v, size in zip(inner, sizes, strict=True)]
    d = [exact_value(v) * size - w for v, w, size in zip(near, c, sizes, strict=True)]
    form = contact.form
    assert form is not None

    def bilinear(p: list[fmpq], q: list[fmpq]) -> arb:
        total: arb = sum((form[i][j] * (p[i] * q[j]) for i in range(3) for j in range(3)), form[0][0] * 0)
        return total

    a, b, k = bilinear(d, d), bilinear(c, d), bilinear(c, c)
    root = b * b - a * k
    inverse = 1 / a
    way = 1 if sign(a) > 0 else -1  # the larger root, near 1: k and the value at d have different signs
    t = QuadraticElement(-b * inverse, inverse * way, root)
    y = [t * w + v for v, w in zip(c, d, strict=True)]
    x = [sum((y[j] * column[k] for j, column in enumerate(contact.span)), t * 0) for k in range(4)]
    return tuple(x)
