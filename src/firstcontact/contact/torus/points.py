"""Points of a body that meet a torus while nothing else of it does: exact, where doubles end.

A point v that a body owns is in the torus where a polynomial in the motion's parameter is <= 0.  Next to v, the tip of
a cone or a vertex of a polyhedron, the body lies in v + K, K the cone, or what edges, or triangles, span there.  Let
h be the distance from the torus, g its gradient at v, and g.d >= c |d| for all d in K.  Where h bends by b at most,
    h(y) >= h(v) + g.(y - v) - b |y - v|^2 / 2 >= h(v) + |y - v| (c - b r / 2)    for y in v + K, |y - v| <= r.
So for b r < 2 c a point of the body that near to v is in the torus only if v is.  What is farther away is told by
cells.  Over a time in which both hold, the bodies are in contact just when the polynomial is <= 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from flint import arb, fmpq, fmpq_poly, fmpz_poly

from firstcontact.body.solid import carriers
from firstcontact.body.solid.carriers import Plane, Surface
from firstcontact.body.torus.torus import Torus, quartic
from firstcontact.contact.torus.between import Places
from firstcontact.contact.ways import Passed, tried
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import dyadic, precision, sign, to_double
from firstcontact.exact.vectors import Vector, cross, dot, scaled, sub
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.search.convex.convex import NotConvex, convex_pieces
from firstcontact.search.convex.tips import Tip, tips_of

if TYPE_CHECKING:
    from firstcontact.body import kinds
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.body.solid.composite_quadric import CompositeQuadric

BITS = 256
HALVINGS = 24
"""Of distances and slopes that are tried."""


class TrackedPoint(NamedTuple):
    """place: in its body's frame, exact; K is the cone of the tip, else spanned by the ways."""

    place: Vector
    tip: Tip | None
    ways: list[Vector]

    @property
    def in_doubles(self) -> np.ndarray:
        return np.array([to_double(x) for x in self.place])

    def slope(self, n: list[arb]) -> arb | None:
        """A proved c > 0 with n.d >= c |d| for all d of K; None where none is found."""
        if self.tip is None:
            ways = [[arb(x) for x in way] for way in self.ways]
            found = [_lower(dot(n, way) / dot(way, way).sqrt()) for way in ways]
            return min(found, default=arb(1)) if all(x > 0 for x in found) else None
        length, inward = _upper(dot(n, n).sqrt()), [arb(x) for x in self.tip.inward]
        dual = [[arb(x) for x in row] for row in self.tip.dual]
        for k in range(1, HALVINGS):  # K is on one side of all planes whose normals are that near to n
            c = length * arb(2) ** -k
            m = [-x + c * arb(0, 1) for x in n]
            if dot(m, inward) < 0 and dot(m, [dot(row, m) for row in dual]) < 0:  # as `Tip.is_behind`
                return c
        return None


class Event(NamedTuple):
    """When a point is on the torus: an enclosure, the time itself where it is rational; whether it is in the torus just
    before and after, None: at an end of the motion."""

    lo: fmpq
    hi: fmpq
    exact: fmpq | None
    before: bool | None
    after: bool | None


def points_of(model: CompositeQuadric) -> list[TrackedPoint]:
    """Tips of a convex model, and corners of its planes."""
    try:
        solids = convex_pieces(model).solids
    except NotConvex:
        return []
    if len(solids) != 1:
        return []
    tips = [TrackedPoint(_vector(tip.point), tip, []) for tip in tips_of(solids[0])]
    places = (x.carrier for x in model.vertices if not x.is_apex)
    corners = (_corner(solids[0][0], [row[0] for row in x.basis]) for x in places if isinstance(x, carriers.Point))
    return [*tips, *(x for x in corners if x is not None)]


def vertex_of(mesh: Polyhedron, corners: np.ndarray, k: int) -> TrackedPoint | None:
    """Vertex k of a polyhedron, K what its triangles span there: where a polygon is reflex, edges do not.

    corners: (n, 3) of triangles, bare edges and points.  None in an irrational pose.
    """
    near = {int(i) for row in corners[np.any(corners == k, axis=1)] for i in row} - {k}
    place, *others = (mesh.exact_vertex(i) for i in (k, *sorted(near)))
    if not all(isinstance(x, fmpq) for x in place):
        return None
    return TrackedPoint(place, None, [way for x in others if any(way := sub(x, place))])


def _corner(forms: Sequence[Surface], x: Sequence[fmpq]) -> TrackedPoint | None:
    """Of half-spaces, at the homogeneous point x in them all: ways are where two planes meet; None beside a quadric."""
    on = [form for form in forms if form.value(x) == 0]
    if not all(isinstance(form, Plane) for form in on):
        return None
    normals = [_vector(form.gradient(x)) for form in on]
    lines = (cross(p, q) for p, q in combinations(normals, 2))
    ways = [way for line in lines for way in (line, scaled(fmpq(-1), line)) if any(way)]
    within = [d for d in ways if all(dot(n, d) <= 0 for n in normals)]
    return TrackedPoint(_vector([c / x[3] for c in x[:3]]), None, within)


def _vector(x: Sequence[fmpq]) -> Vector:
    p, q, r = x[:3]
    return p, q, r


class PointCourse:
    """A point's way through a torus: `bodies`, its own first, over `span`."""

    def __init__(
        self, point: TrackedPoint, bodies: tuple[kinds.Body, kinds.Body], torus: Torus, span: tuple[fmpq, fmpq]
    ) -> None:
        self.point, self.torus, self.span = point, torus, span
        self.events: list[Event] = []
        """In the order of time."""
        self.inside: bool | None = None
        """Whether it is in the torus where there are none; None where nothing is known of its way."""
        pieces = tried(lambda: list(relative_pieces(*bodies, *span)))
        if isinstance(pieces, Passed):  # no rational function of any parameter
            return
        if all(piece.exact for piece in pieces):
            for piece in pieces:
                self._pass(piece)

    def _pass(self, piece: PolynomialPiece) -> None:
        form = self._form(piece)
        if form.is_zero() or piece.u_hi is None:
            self.events, self.inside = [], None
            return
        roots = [x for x in real_roots(form, piece.u_lo, piece.u_hi) if piece.contains(x)]
        ends = [piece.u_lo, *(_middle(x) for x in roots), piece.u_hi]
        states = [sign(form((u + v) / 2)) < 0 if u < v else None for u, v in zip(ends, ends[1:], strict=False)]
        for root, before, after in zip(roots, states, states[1:], strict=False):
            event = _event(piece, root, before, after)
            if self.events and event.lo <= self.events[-1].hi:  # where two pieces meet
                event = event._replace(before=self.events.pop().before)
            self.events.append(event)
        self.inside = states[-1] if self.inside is None else self.inside

    def _form(self, piece: PolynomialPiece) -> fmpz_poly:
        """<= 0 where the point is in the torus."""
        place = (*self.point.place, fmpq(1))
        x, y, z, w = (
            sum((fmpq_poly(p) * c for p, c in zip(row, place, strict=True)), fmpq_poly([0])) for row in piece.pose
        )
        p, q, r = (row[0] * x + row[1] * y + row[2] * z + row[3] * w for row in self.torus.back)
        form: Any = quartic(w * self.torus.major, w * self.torus.minor, p, q, r)
        return fmpq_poly(form).numer()

    def state_at(self, t: fmpq) -> bool | None:
        """Whether the point is inside at t, where no event is."""
        later = next((x.before for x in self.events if x.hi >= t), None)
        earlier = next((x.after for x in reversed(self.events) if x.lo <= t), None)
        return later if later is not None else earlier if earlier is not None else self.inside


def _event(piece: PolynomialPiece, root: AlgebraicRoot, before: bool | None, after: bool | None) -> Event:
    time = piece.exact_time(root)
    if isinstance(time, Fraction):
        t = fmpq(time.numerator, time.denominator)
        return Event(t, t, t, before, after)
    with precision(BITS):
        ball = piece.time_of(root.enclosure(BITS))
        return Event(dyadic(ball.lower()), dyadic(ball.upper()), None, before, after)


def _middle(root: AlgebraicRoot) -> fmpq:
    value = root.rational
    return dyadic(root.enclosure(BITS).mid()) if value is None else value


def reach_of(point: TrackedPoint, places: Places, torus: Torus) -> tuple[float, float] | None:
    """Up to which distance from the point, in its body's frame and in that of the torus, the body is in the torus only
    where the point is, over a time; None where none is proved.

    places: of the point and of those a unit along each axis from it, as the torus's frame has them.
    """
    with precision(BITS):
        off = (places.half * np.abs(places.rates[0]) + places.blur[0]).tolist()
        rows = zip(places.points[0].tolist(), off, strict=True)
        at = [[arb(c, e) for c, e in zip(*row, strict=True)] for row in rows]
        x, y, z = at[0]
        linear = [[at[1 + j][i] - at[0][i] for j in range(3)] for i in range(3)]
        rho = (x * x + y * y).sqrt()
        across = rho - torus.major
        away = (across * across + z * z).sqrt()
        if not (rho > 0 and away > 0):
            return None
        out = [across / (away * rho) * x, across / (away * rho) * y, z / away]
        size = _upper(sum((c * c for row in linear for c in row), arb(0)).sqrt())
        slope = point.slope([sum((row[j] * g for row, g in zip(linear, out, strict=True)), arb(0)) for j in range(3)])
        for k in range(1, HALVINGS):
            reach = arb(torus.minor) * arb(2) ** -k
            if slope is None or not (away > reach and rho > reach):
                continue
            bend = _upper(abs(reach - across)) / ((away - reach) * (rho - reach))
            if bend * reach < 2 * slope / size:
                return float((reach / size).lower()) * (1 - 1e-15), float(reach) - 2.0 * max(off[0])
        return None


def _lower(x: arb) -> arb:
    return arb(x.lower())


def _upper(x: arb) -> arb:
    return arb(x.upper())
