"""Edges of degree 4: common curves of two quadrics that no rational planes hold.

`exact.curves.quadric_curve` finds every branch, the signs of all other surfaces on it, and how branches go on; what a
branch is, is decided at one of its points, taken to 400 bits.  Where a surface changes its sign, edges are cut; such
points are proved by Krawczyk's test.  So no edge and no crossing is missed, however short.  The points of an edge are
doubles a 200th of the box apart at most; they are for looking at and for searches to begin from.

Not proved here: that the ends of branches which come together beside an event meet there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat

from firstcontact.body.solid.carriers import EnclosedPoint, Point, Quadric, QuarticCurve, Surface, columns, doubles
from firstcontact.body.solid.csg import Tree, outcomes
from firstcontact.body.solid.features import EDGE_KINDS, EdgePiece, NotDerived, enclosure
from firstcontact.body.solid.neighbourhood import Profile, around_curve, nearly_tangent
from firstcontact.body.solid.regions import Region, Regions, holds_ball, hull
from firstcontact.body.solid.trimming import BITS
from firstcontact.exact.curves.quadric_curve import BranchSweep, Degenerate, QuadricBranch, QuadricEnd, swept
from firstcontact.exact.numbers import Undecidable, dyadic, exact_value, precision, simplest
from firstcontact.exact.vectors import cross

if TYPE_CHECKING:
    from firstcontact.body.solid.features import EdgeFields, _Corner, _Corners

"""Corners, (3,) float64 each."""

STEPS = 200
FEWEST = 16
"""Points inside the shortest branch."""
MOST_ROUNDS = 12
"""How often steps that are too long are halved."""
SAME = 2.0**-50
"""Points nearer than this, in units of the model's coordinates, to where branches meet are the same."""
STILL = 2.0**-51
"""A step so small beside the point goes nowhere."""


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Consecutive points between corners; start, end: corners, None on closed curves."""

    points: np.ndarray
    profile: Profile
    start: Any
    end: Any


@dataclass(frozen=True, eq=False)
class QuarticEdge:
    """One quartic curve's edges, before vertices are numbered."""

    carrier: QuarticCurve
    surfaces: tuple[int, ...]
    stretches: tuple[_Stretch, ...]

    def finished(self, numbers: dict[tuple[int, int], int]) -> list[EdgeFields]:
        """Keyword arguments of Edge but index and name, one for each convexity that occurs."""
        found: list[EdgeFields] = []
        for kind in EDGE_KINDS:
            own = _joined([s for s in self.stretches if s.profile.kind == kind])
            if not own:
                continue
            frame = np.concatenate([s.points for s in own])
            last = np.cumsum([len(s.points) for s in own])
            pieces = tuple(
                EdgePiece(float(end - len(s.points)), float(end - 1), _number(s.start), _number(s.end))
                for s, end in zip(own, last, strict=True)
            )
            sides = sorted({numbers[side] for s in own for side in s.profile.faces})
            found.append(
                dict(
                    carrier=self.carrier,
                    surfaces=self.surfaces,
                    convexity=kind,
                    pieces=pieces,
                    faces=tuple(sides),
                    frame=frame,
                )
            )
        return found


def _joined(stretches: list[_Stretch]) -> list[_Stretch]:
    """Stretches that follow each other made one where no vertex parts them."""
    joined: list[_Stretch] = []
    for stretch in stretches:
        last = joined[-1] if joined else None
        if last is not None and _follows(last, stretch):
            points = np.concatenate([last.points, stretch.points[1:]])
            joined[-1] = _Stretch(points, last.profile, last.start, stretch.end)
        else:
            joined.append(stretch)
    return joined


def _follows(first: _Stretch, second: _Stretch) -> bool:
    corner = first.end
    same = corner is not None and corner is second.start and first.profile.faces == second.profile.faces
    return same and not corner.is_vertex


def _number(corner: _Corner) -> int | None:
    return None if corner is None or corner.index < 0 else corner.index


def trace_quartics(
    tree: Tree,
    surfaces: Sequence[Surface],
    pairs: Sequence[tuple[int, int, Region]],
    corners: _Corners,
    box: Region | None,
    regions: Regions,
) -> tuple[list[QuarticEdge], set[tuple[int, int]]]:
    """All degree-4 edges inside the box, and the sides of surfaces that they bound.

    pairs: of surfaces, with the region in which both may bound the solid.
    """
    where: dict[tuple[int, ...], Region] = {}
    for i, j, region in pairs:
        on = tuple(k for k in range(len(surfaces)) if _in_pencil(surfaces[i], surfaces[j], surfaces[k]))
        where[on] = hull(where[on], region) if on in where else region
    curves: dict[tuple[int, ...], _Curve] = {}
    for on, region in where.items():
        if box is None:
            raise NotDerived(
                f"surfaces {on[0]} and {on[1]} meet in a curve of degree 4, and no bound of the solid is known; "
                "intersect it with a box"
            )
        region = np.maximum(region[0], box[0]), np.minimum(region[1], box[1])
        near, signs = regions.seen_in(tree, region)
        if (region[0] < region[1]).all() and not isinstance(near, bool):
            curves[on] = _Curve(near, surfaces, on, corners, region, signs)
    for curve in curves.values():
        curve.visit(corners)
    edges: list[QuarticEdge] = []
    sides: set[tuple[int, int]] = set()
    for on, curve in curves.items():
        stretches = curve.stretches()
        sides |= {side for s in stretches for side in s.profile.faces}
        edges.append(QuarticEdge(curve.carrier, on, tuple(stretches)))
    return edges, sides


def _in_pencil(first: Surface, second: Surface, other: Surface) -> bool:
    """Whether the third form is a combination of the first two: then it holds their common curve."""
    if not isinstance(other, Quadric):
        return False
    flat = [[x for row in s.form for x in row] for s in (first, second, other) if isinstance(s, Quadric)]
    return bool(fmpq_mat(flat).rank() == 2)


class PairF:
    """Both forms in doubles."""

    def __init__(self, first: Surface, second: Surface) -> None:
        forms = [np.array(doubles(s.matrix())) for s in (first, second)]
        self.forms = np.array([f / np.linalg.norm(f) for f in forms])

    def pulled(self, p: np.ndarray) -> np.ndarray:
        """(n, 3) points taken onto the curve."""
        return pulled(np.broadcast_to(self.forms, (len(p), 2, 4, 4)), p)


def pulled(forms: np.ndarray, p: np.ndarray, steps: int = 6) -> np.ndarray:
    """(n, 3) points, each taken onto the common points of its forms (n, k, 4, 4) by Newton steps of least length."""
    p, left = p.copy(), np.arange(len(p))
    for _ in range(steps):
        own = forms if len(left) == len(p) else forms[left]
        step = _least_step(*value_and_slope(own, p[left]))
        p[left] -= step
        left = left[np.abs(step).max(axis=1) > STILL * np.abs(p[left]).max(axis=1)]
        if not len(left):
            break
    return p


def _least_step(value: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """(n, 3) what is to be taken off points at which forms have these values (n, k) and slopes (n, k, 3)."""
    if value.shape[1] == 2:
        u, v = value.T
        s, t = slope[:, 0], slope[:, 1]
        a, b, c = (np.einsum("ni,ni->n", x, y) for x, y in ((s, s), (s, t), (t, t)))
        more = 1e-14 * (a + c)
        a, c = a + more, c + more
        whole = np.maximum(a * c - b * b, 1e-300)
        one: np.ndarray = ((c * u - b * v) / whole)[:, None] * s + ((a * v - b * u) / whole)[:, None] * t
        return one
    gram = np.einsum("nik,njk->nij", slope, slope)
    gram += 1e-14 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(value.shape[1])
    step: np.ndarray = np.einsum("nik,ni->nk", slope, np.linalg.solve(gram, value[..., None])[..., 0])
    return step


def value_and_slope(forms: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, k) values of the forms (n, k, 4, 4) at (n, 3) points, and (n, k, 3) gradients."""
    x = np.column_stack([p, np.ones(len(p))])
    image = np.einsum("nsij,nj->nsi", forms, x)
    return np.einsum("nsi,ni->ns", image, x), 2 * image[..., :3]


# -- branches -----------------------------------------------------------------------------------------------


Way = tuple[QuadricBranch, bool]
"""Along a branch; True: towards larger u."""


@dataclass(eq=False)
class _Link:
    """Where two ends of branches meet: the point (x, y, z), and the corner there, if any."""

    ends: tuple[QuadricEnd, QuadricEnd]
    point: list[arb]
    corner: Any = None


@dataclass(eq=False)
class _Curve:
    """The branches of one common curve that bound the solid, and how they are joined; corners where they are cut."""

    tree: Tree
    surfaces: Sequence[Surface]
    on: tuple[int, ...]
    corners: _Corners
    box: Region
    known: Sequence[int]
    """Signs of forms that have one all over the box."""
    sweep: BranchSweep = field(init=False)
    profiles: dict[QuadricBranch, Profile] = field(default_factory=dict)
    links: dict[Way, _Link] = field(default_factory=dict)
    planes: dict[int, dict[float, np.ndarray]] = field(default_factory=dict)
    """Of every cell the planes looked at, by the angle that the planes at its ends have 0 and pi of: (k, 3) points."""

    def __post_init__(self) -> None:
        first, second = (self.surfaces[k] for k in self.on[:2])
        assert isinstance(first, Quadric) and isinstance(second, Quadric)
        self.carrier = QuarticCurve(first, second)
        self.rest = [k for k, sign in enumerate(self.known) if sign == 0 and k not in self.on]
        others = [self.surfaces[k].matrix() for k in self.rest]
        lo, hi = ([exact_value(c) for c in corner] for corner in self.box)
        try:
            self.sweep = swept(first.form, second.form, others, (lo, hi))
        except Degenerate as reason:
            raise NotDerived(
                f"surfaces {self.on[0]} and {self.on[1]} touch along a line, or a third one holds a part of their curve"
            ) from reason
        for branch in (b for cell in self.sweep.cells for b in cell):
            profile = self._profile(branch)
            if profile.kind in EDGE_KINDS:
                self.profiles[branch] = profile
        for event in sorted({b.cell + s for b in self.profiles for s in (-1, 0)}):
            self._join(event)

    def _profile(self, branch: QuadricBranch) -> Profile:
        signs = list(self.known)
        for k in self.on:
            signs[k] = 0
        for k, sign in zip(self.rest, branch.signs, strict=True):
            signs[k] = sign
        values = outcomes(self.tree, signs)
        if len(values) == 1:
            return Profile("inside" if True in values else "outside", frozenset())
        with precision(BITS):
            if not holds_ball(self.box, self.sweep.point(branch, 2 * BITS)):  # an edge lies in it
                return Profile("outside", frozenset())
        for bits in (BITS, 4 * BITS):
            with precision(bits):
                x = [arb(c.mid()) for c in self.sweep.point(branch, 2 * bits)]
                if not nearly_tangent(self.surfaces, self.on[:2], x):
                    a, b = (self.surfaces[k].gradient(x) for k in self.on[:2])
                    return around_curve(self.tree, self.surfaces, signs, x, [*cross(a, b), arb(0)])
        raise Undecidable

    def _join(self, event: int) -> None:
        """Links at one event.  More than two ends meet in singular points of the curve: they go on straightest."""
        for group in self.sweep.meeting(event):
            if not any(end.branch in self.profiles for end in group):
                continue
            for pair in _straight(group):
                with precision(BITS):
                    link = _Link(pair, _middle(pair))
                for end in pair:
                    self.links[end.branch, end.upper] = link
                if self._changes(pair):
                    link.corner = self._corner(pair, link.point)

    def _changes(self, pair: tuple[QuadricEnd, QuadricEnd]) -> bool:
        """Whether another surface is crossed, or the solid looks different on the two sides."""
        first, second = (end.branch for end in pair)
        a, b = (self.profiles.get(branch) for branch in (first, second))
        same = a is b or (a is not None and b is not None and (a.kind, a.faces) == (b.kind, b.faces))
        return first.signs != second.signs or not same

    def _corner(self, pair: tuple[QuadricEnd, QuadricEnd], point: list[arb]) -> _Corner:
        """The corner where the curve crosses another surface; or a singular point of the curve, not proved."""
        signs = (end.branch.signs for end in pair)
        changed = [k for k, s, t in zip(self.rest, *signs, strict=True) if s != t]
        if changed:
            found = enclosed([self.surfaces[k] for k in (*self.on[:2], changed[0])], point)
        else:
            found = EnclosedPoint(tuple(dyadic(c) for c in point), fmpq(1, 2 ** (BITS // 8)), False)
        on = frozenset((*self._all_on(found), *changed))
        return self.corners.merged(on, _rational(found, [self.surfaces[k] for k in on]) or found)

    def _all_on(self, point: EnclosedPoint) -> frozenset[int]:
        """The surfaces whose forms cannot be told from zero at the point."""
        with precision(BITS):
            x = [arb(c, point.radius) for c in point.centre]
            values = {k: self.surfaces[k].value([*x, arb(1)]) for k in self.rest}
            return frozenset(self.on) | {k for k, value in values.items() if not (value > 0 or value < 0)}

    def visit(self, corners: _Corners) -> None:
        """Put corners known from other curves where this one passes them without crossing a surface."""
        size = max(1.0, *(float(np.abs(c).max()) for c in self.box))
        mine = {id(link): link for link in self.links.values()}.values()
        here = {id(link.corner) for link in mine}
        for corner in corners.all():
            if set(self.on) <= corner.surfaces and id(corner) not in here:
                with precision(BITS):
                    at = enclosure(corner.carrier)
                    for link in mine:
                        if link.corner is None and _distance(at, link.point) < SAME * size:
                            link.corner = corner

    # -- stretches ------------------------------------------------------------------------------------------

    def stretches(self) -> list[_Stretch]:
        """The parts between corners, those that follow each other in order; tells the corners where edges end."""
        for link in self.links.values():
            kinds = {self._kind(end.branch) for end in link.ends}
            if link.corner is not None and len(kinds) > 1:
                link.corner.ends = True
        found: list[_Stretch] = []
        left = dict.fromkeys(self.profiles)
        while left:
            way: Way | None = self._back(next(iter(left)))
            while way is not None and way[0] in left:
                steps, way = self._until_corner(way)
                for branch, _ in steps:
                    left.pop(branch, None)
                found.append(self._stretch(steps))
        return found

    def _kind(self, branch: QuadricBranch) -> str | None:
        return self.profiles[branch].kind if branch in self.profiles else None

    def _next(self, way: Way) -> tuple[_Link, Way]:
        """The link at the end of the branch, and the way on beyond it."""
        link = self.links[way]
        other = link.ends[(link.ends[0].branch, link.ends[0].upper) == way]
        return link, (other.branch, not other.upper)

    def _back(self, branch: QuadricBranch) -> Way:
        """The way along the edge that the branch is on, from its beginning or, where it is closed, from a corner."""
        way: Way = (branch, False)
        corner = None
        while True:
            link, after = self._next(way)
            if link.corner is not None:
                corner = (way[0], not way[1])
            if after[0] not in self.profiles:
                return way[0], not way[1]
            way = after
            if way == (branch, False):
                return corner or (branch, True)

    def _until_corner(self, way: Way) -> tuple[list[Way], Way | None]:
        """The ways up to the next corner, and the one beyond it."""
        steps = [way]
        while True:
            link, after = self._next(steps[-1])
            if link.corner is not None or after == steps[0]:
                return steps, after if after[0] in self.profiles else None
            steps.append(after)

    def _stretch(self, steps: list[Way]) -> _Stretch:
        first, last = self.links[steps[0][0], not steps[0][1]], self.links[steps[-1]]
        parts = [np.array([[float(c) for c in first.point]])]
        for branch, upper in steps:
            inner = self._points(branch)
            parts += [inner if upper else inner[::-1], np.array([[float(c) for c in self.links[branch, upper].point]])]
        return _Stretch(np.concatenate(parts), self.profiles[steps[0][0]], first.corner, last.corner)

    def _points(self, branch: QuadricBranch) -> np.ndarray:
        """(n, 3) float64 points inside the branch, neighbours at most a step apart, towards larger u."""
        planes = self.planes.setdefault(branch.cell, {})
        angles = [(k + 0.5) * np.pi / FEWEST for k in range(FEWEST)]
        low, high = ([float(c) for c in self.links[branch, upper].point] for upper in (False, True))
        step = float(np.linalg.norm(self.box[1] - self.box[0])) / STEPS
        for _ in range(MOST_ROUNDS):
            for angle in angles:
                if angle not in planes:
                    points = self.sweep.across(branch.cell, 0.5 - 0.5 * float(np.cos(angle)))
                    planes[angle] = np.array([[float(c) for c in p[:3]] for p in points])
            angles = sorted(planes)
            inner = np.array([planes[angle][branch.order] for angle in angles])
            steps = np.linalg.norm(np.diff(np.concatenate([[low], inner, [high]]), axis=0), axis=1)
            ends = [0.0, *angles, np.pi]
            angles = [(ends[k] + ends[k + 1]) / 2 for k in np.flatnonzero(steps > step)]
            if not angles:
                break
        return inner


def _straight(ends: list[QuadricEnd]) -> list[tuple[QuadricEnd, QuadricEnd]]:
    """The ends that meet in one point, two by two, such that branches turn least."""
    if len(ends) == 2:
        return [(ends[0], ends[1])]
    if len(ends) % 2:
        raise Undecidable
    with precision(BITS):
        centre = _middle(ends)
        size = max(_distance(end.point, centre) for end in ends)
        offs = {}
        for branch, upper, point in ends:
            offs[branch, upper] = np.array([float((p - c) / size) for p, c in zip(point, centre, strict=True)])

    def bend(matching: list[tuple[QuadricEnd, QuadricEnd]]) -> float:
        return sum(float(np.linalg.norm(offs[a.branch, a.upper] + offs[b.branch, b.upper])) for a, b in matching)

    return min(_matchings(ends), key=bend)


def _matchings(ends: list[QuadricEnd]) -> Iterator[list[tuple[QuadricEnd, QuadricEnd]]]:
    if not ends:
        yield []
    for k in range(1, len(ends)):
        for rest in _matchings(ends[1:k] + ends[k + 1 :]):
            yield [(ends[0], ends[k]), *rest]


def _middle(ends: Sequence[QuadricEnd]) -> list[arb]:
    return [arb((sum(c, arb(0)) / len(ends)).mid()) for c in zip(*(end.point for end in ends), strict=True)]


def _distance(p: Sequence[arb], q: Sequence[arb]) -> arb:
    return sum(((a - b) ** 2 for a, b in zip(p, q, strict=True)), arb(0)).sqrt()


# -- common points of three surfaces ------------------------------------------------------------------------


def enclosed(system: Sequence[Surface], start: Sequence[arb]) -> EnclosedPoint:
    """The common point of three surfaces near `start`, by Newton's method at 400 bits and Krawczyk's test."""
    with precision(BITS):
        p = [arb(c.mid()) for c in start]
        step = [arb(1)] * 3
        for _ in range(60):
            value = arb_mat([[s.value([*p, arb(1)])] for s in system])
            try:
                step = [row[0] for row in _jacobian(system, p).solve(value).tolist()]
            except ZeroDivisionError:
                break
            p = [arb((x - d).mid()) for x, d in zip(p, step, strict=True)]
            if max(float(abs(d).upper()) for d in step) < 2.0 ** (-BITS // 2):
                break
        radius = max(dyadic(arb(abs(d).upper())) for d in step) + fmpq(1, 2 ** (BITS // 2))
        return EnclosedPoint(tuple(dyadic(x) for x in p), radius, _krawczyk(system, p, radius))


def _rational(point: EnclosedPoint, on: Sequence[Surface]) -> Point | None:
    """The rational point in which all these surfaces meet, if the shortest fractions of the enclosure tell one."""
    x = (*(simplest(c - point.radius, c + point.radius) for c in point.centre), fmpq(1))
    return Point(columns(x)) if all(surface.value(x) == 0 for surface in on) else None


def _jacobian(system: Sequence[Surface], p: list[arb]) -> arb_mat:
    return arb_mat([list(s.gradient([*p, arb(1)])) for s in system])


def _krawczyk(system: Sequence[Surface], p: list[arb], radius: fmpq) -> bool:
    """Whether p - Y f(p) + (1 - Y J(X)) (X - p) lies inside X, the box of that half-width about p."""
    try:
        y = _jacobian(system, p).inv()
    except ZeroDivisionError:
        return False
    offset = arb_mat([[arb(0, radius)] for _ in p])
    box = [x + d for (d,), x in zip(offset.tolist(), p, strict=True)]
    value = arb_mat([[s.value([*x, arb(1)])] for s in system for x in (p,)])
    rest = arb_mat(3, 3, [int(i == j) for i in range(3) for j in range(3)]) - y * _jacobian(system, box)
    image = rest * offset - y * value
    return all(arb(0, radius).contains_interior(row[0]) for row in image.tolist())
