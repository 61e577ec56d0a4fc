"""Faces, edges and vertices of a composite quadric model, derived exactly from its surfaces and its Boolean tree.

Every curve common to two surfaces is cut at all the others; a sample point of each arc decides what the whole arc is
(Choi et al. 2014, section 2.2; `trimming`, `neighbourhood`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from flint import arb, fmpq, fmpq_mat, fmpq_poly

from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    AlgebraicPoint,
    Conic,
    EnclosedPoint,
    Line,
    Plane,
    Point,
    Quadric,
    QuarticCurve,
    Rows,
    Surface,
    Vector,
    columns,
    diagonalised,
    dot,
    doubles,
    inertia,
    null_space,
    scaled_axes,
    transposed,
)
from firstcontact.body.solid.csg import Tree, inside, outcomes, pattern
from firstcontact.body.solid.intersections import common_curves, line
from firstcontact.body.solid.neighbourhood import Profile, around_curve, nearly_tangent, patterns
from firstcontact.body.solid.regions import Region, Regions, SurfaceReach, holds, holds_ball, hull, simplified
from firstcontact.body.solid.trimming import BITS, INFINITY, Arc, Break, Loop, Trimmed, largest, trim
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import dyadic, precision, to_double

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from firstcontact.body.solid.carriers import Curve
    from firstcontact.body.solid.feature_names import Names

EDGE_KINDS = ("convex", "reentrant", "smooth")


class NotDerived(UnsupportedPair):
    """No method here tells the edges of this solid; the text says which, and what would help."""


@dataclass(frozen=True, eq=False)
class Face:
    """The part of one surface that bounds the body on one side; carrier: its form, negative on the body's side."""

    index: int
    name: str
    carrier: Surface
    surfaces: tuple[int, ...]
    orientation: int
    """+1 where the body is on the negative side of the model's surface, -1 on the other."""


@dataclass(frozen=True, eq=False)
class EdgePiece:
    """A part of an edge, lo <= parameter <= hi of `Edge.points`; start, end: vertex numbers, None at infinity and on
    closed curves."""

    lo: float
    hi: float
    start: int | None
    end: int | None


@dataclass(frozen=True, eq=False)
class Edge:
    """A curve where faces meet, with the pieces of it that bound the body.

    convexity: "convex" (the body fills less than half of the space around the edge), "reentrant" or "smooth".
    surfaces: every surface of the model that holds the curve.
    """

    index: int
    name: str
    carrier: Line | Conic | QuarticCurve
    surfaces: tuple[int, ...]
    convexity: str
    pieces: tuple[EdgePiece, ...]
    faces: tuple[int, ...]
    frame: Any
    """(4, 2) float64: X(s) = frame (s, 1), s a length; (4, 3): X(t) = frame (1, cos t, sin t).
    Quartics: (n, 3) points, the parameter counts along them."""

    def points(self, parameters: ArrayLike) -> np.ndarray:
        """(n, 3) float64 points of the curve at the (n,) parameters."""
        t = np.asarray(parameters, float)
        if isinstance(self.carrier, QuarticCurve):
            from firstcontact.body.solid.quartic_edges import PairF

            steps = np.arange(len(self.frame))
            chord = np.stack([np.interp(t, steps, self.frame[:, k]) for k in range(3)], axis=-1)
            return PairF(self.carrier.first, self.carrier.second).pulled(chord)
        if self.frame.shape[1] == 2:
            on_line: np.ndarray = self.frame @ np.stack([t, np.ones_like(t)])
            return on_line[:3].T
        x: np.ndarray = self.frame @ np.stack([np.ones_like(t), np.cos(t), np.sin(t)])
        found: np.ndarray = x[:3] / x[3]
        return found.T


class EdgeFields(TypedDict, total=False):
    """Those of Edge but its index; the name comes last."""

    name: str
    carrier: Curve
    surfaces: tuple[int, ...]
    convexity: str
    pieces: tuple[EdgePiece, ...]
    faces: tuple[int, ...]
    frame: np.ndarray


@dataclass(frozen=True, eq=False)
class Vertex:
    """A point where edges end or meet, or the apex of a cone; position: doubles, each within `error` of the truth."""

    index: int
    name: str
    carrier: Point | AlgebraicPoint | EnclosedPoint
    surfaces: tuple[int, ...]
    position: tuple[float, float, float]
    error: float
    is_apex: bool = False
    """Whether it is the tip of a cone."""


@dataclass(frozen=True, eq=False)
class Features:
    faces: tuple[Face, ...]
    edges: tuple[Edge, ...]
    seams: tuple[Edge, ...]
    vertices: tuple[Vertex, ...]


@dataclass(frozen=True, eq=False)
class _Run:
    """Consecutive arcs of one kind; start is end is None: the whole loop."""

    kind: str
    start: Break | None
    end: Break | None
    sample: Arc
    faces: frozenset[tuple[int, int]]


@dataclass(frozen=True, eq=False)
class _Traced:
    """A trimmed loop with what each of its arcs is."""

    curve: Line | Conic
    trimmed: Trimmed
    profiles: tuple[Profile, ...]


def derive(
    tree: Tree, surfaces: Sequence[Surface], names: Names, box: Callable[[], Region | None],
    reaches: Sequence[SurfaceReach],
) -> Features:  # fmt: skip
    """All features.

    names tells how to call them, box finds a box that holds the solid (asked only if needed), reaches tell where each
    surface may bound it.
    """
    regions = Regions(surfaces, reaches)
    traced, quartics = _traced_curves(tree, surfaces, regions)
    sides = {side for t in traced for profile in t.profiles for side in profile.faces}
    corners = _Corners(surfaces, regions)
    for t in traced:
        corners.collect(t)
    quartic_edges: list[Any] = []
    if quartics:
        from firstcontact.body.solid.quartic_edges import trace_quartics

        quartic_edges, new_sides = trace_quartics(tree, surfaces, quartics, corners, box(), regions)
        sides |= new_sides
    met = {i for t in traced for i in t.trimmed.surfaces} - {i for i, j, _ in quartics for i in (i, j)}
    sides |= _sides_of_whole_surfaces(tree, surfaces, sides, met, regions)
    faces = _faces(sides, surfaces, names)
    numbers = {(f.surfaces[0], f.orientation): f.index for f in faces}
    corners.add_apexes(tree)
    vertices = corners.numbered(names)
    found = [e for t in traced for e in _edges_of(t, corners, numbers)]
    found += [e for edge in quartic_edges for e in edge.finished(numbers)]
    found = [{"name": name, **e} for name, e in zip(names.edges(found, faces), found, strict=True)]
    edges = [e for e in found if e["convexity"] != "smooth"]
    seams = [e for e in found if e["convexity"] == "smooth"]
    return Features(
        faces,
        tuple(Edge(index=i, **e) for i, e in enumerate(edges)),
        tuple(Edge(index=i, **e) for i, e in enumerate(seams)),
        vertices,
    )


# -- curves -------------------------------------------------------------------------------------------------


def _traced_curves(
    tree: Tree, surfaces: Sequence[Surface], regions: Regions
) -> tuple[list[_Traced], list[tuple[int, int, Region]]]:
    """The lines and conics of all pairs, each once; and the pairs whose curve is of degree 4."""
    curves: dict[Line | Conic, Region] = {}
    quartics = []
    for i, j, region in regions.pairs(tree):
        for curve in common_curves(surfaces[i], surfaces[j]):
            if isinstance(curve, QuarticCurve):
                quartics.append((i, j, region))
            else:
                curves[curve] = hull(curves[curve], region) if curve in curves else region
    traced = []
    for curve, region in curves.items():
        near, signs = regions.seen_in(tree, region)
        if isinstance(near, bool):
            continue
        for trimmed in trim(curve, surfaces, signs):
            profiles = [_profile(tree, surfaces, trimmed.loop, arc, region, regions) for arc in trimmed.arcs]
            traced.append(_Traced(curve, trimmed, tuple(profiles)))
    return traced, quartics


def _profile(
    tree: Tree, surfaces: Sequence[Surface], loop: Loop, arc: Arc, region: Region, regions: Regions
) -> Profile:
    with precision(BITS):
        x = loop.point(arb(arc.m), arc.sheet)
        at = [float(c / x[3]) for c in x[:3]]
    if not holds(region, at):  # an edge lies in it all along
        return Profile("outside", frozenset())
    own = simplified(regions.next_to(tree, at), arc.signs)  # of the surfaces alone that hold the curve
    values = {own} if isinstance(own, bool) else outcomes(own, arc.signs)
    if isinstance(own, bool) or len(values) == 1:
        return Profile("inside" if True in values else "outside", frozenset())
    with precision(BITS):
        on = [i for i, sign in enumerate(arc.signs) if sign == 0]
        tangent = nearly_tangent(surfaces, on, x)
    with precision(4 * BITS if tangent else BITS):
        m = arb(arc.m)
        return around_curve(own, surfaces, arc.signs, loop.point(m, arc.sheet), loop.tangent(m, arc.sheet))


def _sides_of_whole_surfaces(
    tree: Tree, surfaces: Sequence[Surface], known: set[tuple[int, int]], met: set[int], regions: Regions
) -> set[tuple[int, int]]:
    """Sides seen by lines through the middle of each surface: finds the faces that no curve bounds.

    Such a face is a whole component of its surface.  On connected surfaces with a curve of their own (`met`) it
    would hold that curve and be known from it; but curves are followed in regions only, where all of one may be beside
    what is looked at, so surfaces of which nothing is known yet are asked too.
    """
    found: set[tuple[int, int]] = set()
    seen = {i for i, _ in known}
    for i, surface in enumerate(surfaces):
        if {(i, 1), (i, -1)} <= known | found or (i in met and i in seen and _is_connected(surface)):
            continue
        region = regions.bounding(tree, i)
        if region is None:
            continue
        near, signs = regions.seen_in(tree, region)
        if not isinstance(near, bool):
            for probe in _probes(surface):
                found |= sides_along(near, surfaces, probe, region, signs)
    return found


def _is_connected(surface: Surface) -> bool:
    """Whether the regular points of the surface are one piece: told by signatures; False for cones, two nappes."""
    if isinstance(surface, Plane):
        return True
    whole, block = inertia(surface.form), inertia(tuple(row[:3] for row in surface.form[:3]))
    match sum(block):
        case 3:
            return 0 in block or whole == (2, 2)  # ellipsoid, hyperboloid of one sheet
        case 2:
            return sum(whole) == 4 or (sum(whole) == 3 and 0 in block)  # paraboloids, elliptic cylinder
        case _:
            return sum(block) == 1 and sum(whole) == 3  # parabolic cylinder


def sides_along(
    tree: Tree, surfaces: Sequence[Surface], probe: Line, region: Region, signs: Sequence[int]
) -> set[tuple[int, int]]:
    """(surface, orientation) wherever the line passes through exactly one surface and that is a boundary there.

    Within the region; signs: those of forms that have one all over it, else 0.
    """
    found = set()
    for trimmed in trim(probe, surfaces, signs):
        for arc in trimmed.arcs:
            crossing = arc.end
            if crossing is None or len(crossing.surfaces) != 1 or not crossing.finite:
                continue
            with precision(BITS):
                if not holds_ball(region, trimmed.loop.point(crossing.root.ball, crossing.sheet)):
                    continue
            i = crossing.surfaces[0]
            values = [inside(tree, pattern(arc.signs, [i], [negative])) for negative in (True, False)]
            if values[0] != values[1] and not trimmed.surfaces:
                found.add((i, 1 if values[0] else -1))
    return found


# Slopes of the probing lines: no special position relative to the usual axes and planes.
_SLOPES: tuple[Vector, ...] = (
    (ONE, fmpq(1, 97), fmpq(1, 89)),
    (fmpq(1, 83), ONE, fmpq(1, 79)),
    (fmpq(1, 73), fmpq(1, 71), ONE),
)


def _probes(surface: Surface) -> list[Line]:
    if isinstance(surface, Plane):
        normal, foot = surface.normal[:3], tuple(column[2] for column in surface.basis[:3])
        return [line(tuple(n + s * fmpq(1, 9) for n, s in zip(normal, slope, strict=True)), foot) for slope in _SLOPES]
    centre = middle(surface)
    block = tuple(row[:3] for row in surface.form[:3])
    frame = scaled_axes(block)
    lines = []
    for slope in _SLOPES:
        direction = tuple(dot(row, slope) for row in frame)
        lines.append(line(direction, centre))
    return lines


def middle(quadric: Quadric) -> Vector:
    """The centre where there is one, a point of the axis otherwise (the gradient is along the axis there)."""
    block = [list(row[:3]) for row in quadric.form[:3]]
    kernel = null_space(tuple(tuple(row) for row in block))
    if not kernel:
        right = fmpq_mat([[-row[3]] for row in quadric.form[:3]])
        return tuple(row[0] for row in fmpq_mat(block).solve(right).tolist())
    # least squares with the kernel pinned: block x = -b up to the kernel, x across the kernel
    system = [[*row, *(k[i] for k in kernel)] for i, row in enumerate(block)]
    system += [[*k, *(ZERO for _ in kernel)] for k in kernel]
    right = fmpq_mat([*([-row[3]] for row in quadric.form[:3]), *([ZERO] for _ in kernel)])
    return tuple(row[0] for row in fmpq_mat(system).solve(right).tolist()[:3])


def _faces(sides: set[tuple[int, int]], surfaces: Sequence[Surface], names: Names) -> tuple[Face, ...]:
    faces = []
    ordered = sorted(sides, key=lambda s: (s[0], -s[1]))
    for index, ((i, side), name) in enumerate(zip(ordered, names.faces(ordered), strict=True)):
        carrier = surfaces[i] if side > 0 else surfaces[i].negated()
        faces.append(Face(index, name, carrier, (i,), side))
    return tuple(faces)


# -- vertices -----------------------------------------------------------------------------------------------


@dataclass(eq=False)
class _Corner:
    """A point where surfaces cross curves; `ends`: what the edges through it do there."""

    surfaces: frozenset[int]
    carrier: Point | AlgebraicPoint | EnclosedPoint
    position: tuple[float, float, float]
    error: float
    ends: bool = False
    loops: int = 0
    apex: bool = False
    index: int = -1

    @property
    def is_vertex(self) -> bool:
        return self.ends or self.loops > 1 or self.apex


class _Corners:
    """All candidate vertices, each once: same surfaces and overlapping enclosures are the same point."""

    def __init__(self, surfaces: Sequence[Surface], regions: Regions) -> None:
        self.surfaces, self.regions = surfaces, regions
        self.by_surfaces: dict[frozenset[int], list[_Corner]] = {}
        self.at_break: dict[int, _Corner] = {}

    def all(self) -> list[_Corner]:
        return [corner for corners in self.by_surfaces.values() for corner in corners]

    def collect(self, traced: _Traced) -> None:
        """Note the breaks next to edges, and whether edges end there."""
        arcs, profiles = traced.trimmed.arcs, traced.profiles
        here: dict[int, _Corner] = {}
        for k, arc in enumerate(arcs):
            crossing = arc.start
            before, after = (_edge_kind(profiles[j]) for j in (k - 1, k))
            if crossing is None or not crossing.finite or not (before or after):
                continue
            corner = self.add(crossing, traced.trimmed)
            corner.ends |= before != after
            here[id(corner)] = corner
        for corner in here.values():
            corner.loops += 1

    def add(self, crossing: Break, trimmed: Trimmed) -> _Corner:
        surfaces = frozenset(trimmed.surfaces) | frozenset(crossing.surfaces)
        carrier = _break_point(crossing, trimmed.loop, self.surfaces)
        corner = self.merged(surfaces, carrier)
        self.at_break[id(crossing)] = corner
        return corner

    def merged(self, surfaces: frozenset[int], carrier: Point | AlgebraicPoint | EnclosedPoint) -> _Corner:
        position, error = rounded(carrier)
        surfaces = self.regions.around(position, surfaces)  # all that pass there are met on some curves alone
        known = self.by_surfaces.setdefault(surfaces, [])
        for corner in known:
            if _same_point(corner, carrier, position):
                return corner
        known.append(_Corner(surfaces, carrier, position, error))
        return known[-1]

    def add_apexes(self, tree: Tree) -> None:
        """Tips of cones on the boundary."""
        for number, surface in enumerate(self.surfaces):
            tip = surface.apex if isinstance(surface, Quadric) else None
            region = self.regions.of(number)
            if tip is None or not holds(region, [to_double(x / tip[3]) for x in tip[:3]]):
                continue
            near, known = self.regions.seen_in(tree, region)
            signs = [sign or _sign(s.value(tip)) for s, sign in zip(self.surfaces, known, strict=True)]
            on = [k for k, sign in enumerate(signs) if sign == 0]
            if isinstance(near, bool) or len(outcomes(near, signs)) == 1:
                continue
            if len({inside(near, pattern(signs, on, p)) for p in patterns(tip, self.surfaces, on)}) == 2:
                corner = self.merged(frozenset(on), Point(columns(tip)))
                corner.apex = True

    def numbered(self, names: Names) -> tuple[Vertex, ...]:
        # by their surfaces, not as the loops pass them: in a turned copy only those on the same ones may change places
        corners = sorted((c for c in self.all() if c.is_vertex), key=lambda c: sorted(c.surfaces))
        surfaces = [tuple(sorted(corner.surfaces)) for corner in corners]
        called = names.vertices([(on, corner.apex) for on, corner in zip(surfaces, corners, strict=True)])
        vertices = []
        for index, (corner, on, name) in enumerate(zip(corners, surfaces, called, strict=True)):
            corner.index = index
            vertices.append(Vertex(index, name, corner.carrier, on, corner.position, corner.error, corner.apex))
        return tuple(vertices)

    def vertex_at(self, crossing: Break | None) -> int | None:
        corner = self.at_break.get(id(crossing))
        return corner.index if corner is not None and corner.is_vertex else None


def _sign(x: fmpq) -> int:
    return (x > 0) - (x < 0)


def _edge_kind(profile: Profile) -> str | None:
    return profile.kind if profile.kind in ("convex", "reentrant") else None


def _break_point(crossing: Break, loop: Loop, surfaces: Sequence[Surface]) -> Point | AlgebraicPoint:
    """The coordinates over Q(root): the crossing says that sheet sqrt(N) is -U / V there."""
    polynomial = fmpq_poly(crossing.root.polynomial)
    x = [fmpq_poly([a, b]) for a, b in zip(loop.a, loop.b, strict=True)]
    if len(loop.sheets) > 1:
        i = crossing.surfaces[0]
        u, v = loop.restricted(None if i == INFINITY else surfaces[i])
        other = [fmpq_poly([c, e]) for c, e in zip(loop.c, loop.e, strict=True)]
        if not (v % polynomial).is_zero():
            x = [v * p - u * q for p, q in zip(x, other, strict=True)]
    x = [c % polynomial for c in x]
    _, inverse, _ = x[3].xgcd(polynomial)
    affine = [(c * inverse) % polynomial / (x[3] * inverse % polynomial)[0] for c in x[:3]]
    if polynomial.degree() == 1:
        return Point(columns((*(c[0] for c in affine), ONE)))
    with precision(BITS):
        ball = crossing.root.ball
        lo, hi = dyadic(arb(ball.lower())), dyadic(arb(ball.upper()))
    coefficients = tuple(fmpq(c) for c in crossing.root.polynomial.coeffs())
    return AlgebraicPoint(coefficients, lo, hi, tuple(tuple(c.coeffs()) for c in affine))


def enclosure(carrier: Point | AlgebraicPoint | EnclosedPoint) -> list[arb]:
    """x, y, z as balls; call within `precision`."""
    if isinstance(carrier, Point):
        return [arb(row[0] / carrier.basis[3][0]) for row in carrier.basis[:3]]
    if isinstance(carrier, EnclosedPoint):
        return [arb(c, carrier.radius) for c in carrier.centre[:3]]
    root = arb(carrier.lo).union(arb(carrier.hi))
    values = []
    for coefficients in carrier.coordinates:
        value = arb(0)
        for c in reversed(coefficients):
            value = value * root + c
        values.append(value)
    return values


def rounded(carrier: Point | AlgebraicPoint | EnclosedPoint) -> tuple[tuple[float, float, float], float]:
    """Doubles nearest the coordinates, and a bound on how far they are off."""
    with precision(BITS):
        balls = enclosure(carrier)
        x, y, z = (float(b.mid()) for b in balls)
        off = [float(abs(b - arb(f)).upper()) for b, f in zip(balls, (x, y, z), strict=True)]
    return (x, y, z), math.nextafter(max(off), math.inf) if max(off) else 0.0


def _same_point(
    corner: _Corner, carrier: Point | AlgebraicPoint | EnclosedPoint, position: tuple[float, float, float]
) -> bool:
    if isinstance(carrier, Point) and isinstance(corner.carrier, Point):
        return carrier == corner.carrier
    size = 1e-9 * (1 + max(map(abs, position)))
    if any(abs(p - q) > size for p, q in zip(corner.position, position, strict=True)):
        return False
    with precision(BITS):
        return all(p.overlaps(q) for p, q in zip(enclosure(corner.carrier), enclosure(carrier), strict=True))


# -- edges --------------------------------------------------------------------------------------------------


def _edges_of(traced: _Traced, corners: _Corners, numbers: dict[tuple[int, int], int]) -> list[EdgeFields]:
    """The edges on one loop, one for each convexity that occurs: keyword arguments of Edge but index and name."""
    trimmed = traced.trimmed
    runs = _runs(traced, corners)
    found: list[EdgeFields] = []
    for kind in EDGE_KINDS:
        own = [run for run in runs if run.kind == kind]
        if not own:
            continue
        frame = curve_frame(traced.curve, trimmed.loop, own[0].sample)
        sides = sorted({numbers[side] for run in own for side in run.faces})
        found.append(
            dict(
                carrier=traced.curve,
                surfaces=trimmed.surfaces,
                convexity=kind,
                pieces=tuple(_piece(run, trimmed.loop, frame, corners) for run in own),
                faces=tuple(sides),
                frame=frame,
            )
        )
    return found


def _runs(traced: _Traced, corners: _Corners) -> list[_Run]:
    """Neighbouring arcs of the same kind joined where no vertex and no infinity parts them."""
    arcs, profiles = traced.trimmed.arcs, traced.profiles
    n = len(arcs)

    def parted(k: int) -> bool:
        """Whether a run starts at the start of arc k."""
        crossing = arcs[k].start
        if crossing is None:
            return False
        same = profiles[k].kind == profiles[k - 1].kind and profiles[k].faces == profiles[k - 1].faces
        return not same or not crossing.finite or corners.vertex_at(crossing) is not None

    starts = [k for k in range(n) if parted(k)]
    if not starts:
        return [_Run(profiles[0].kind, None, None, arcs[0], profiles[0].faces)]
    runs = []
    for k, after in zip(starts, [*starts[1:], starts[0] + n], strict=True):
        runs.append(_Run(profiles[k].kind, arcs[k].start, arcs[(after - 1) % n].end, arcs[k], profiles[k].faces))
    return runs


def curve_frame(curve: Line | Conic, loop: Loop, sample: Arc) -> np.ndarray:
    """(4, 2) or (4, 3) float64, as in `Edge.frame`; a pair of lines gives the one the sample is on."""
    if isinstance(curve, Line):
        direction, foot = transposed(curve.basis)
        unit = np.array(doubles((direction,))[0])
        return np.column_stack([unit / np.linalg.norm(unit), [to_double(x) for x in foot]])
    # directions of the basis to length about one, exactly
    scales = [max(abs(x) for x in column) for column in transposed(curve.basis)[:2]] + [ONE]
    basis = np.array([[to_double(x / s) for x, s in zip(row, scales, strict=True)] for row in curve.basis])
    form = tuple(
        tuple(x / (s * t) for x, t in zip(row, scales, strict=True))
        for row, s in zip(curve.form, scales, strict=True)
    )
    parts = sorted(diagonalised(form), key=lambda part: part[0])
    if not all(value for value, _ in parts):
        return _line_frame(loop, sample)
    if form[0][0] * form[1][1] > form[0][1] ** 2:
        return _ellipse_frame(form, basis)
    sizes = [max(abs(x) for x in vector) for _, vector in parts]
    columns_f = [np.array([to_double(x / s) for x in v]) for (_, v), s in zip(parts, sizes, strict=True)]
    k, p, q = (value / s**2 for (value, _), s in zip(parts, sizes, strict=True))
    lengths = [1.0, math.sqrt(to_double(-k / p)), math.sqrt(to_double(-k / q))]
    return basis @ np.column_stack([s * c for s, c in zip(lengths, columns_f, strict=True)])


def _ellipse_frame(form: Rows, basis: np.ndarray) -> np.ndarray:
    """Centre and semi-axes."""
    block = [list(row[:2]) for row in form[:2]]
    (x,), (y,) = fmpq_mat(block).solve(fmpq_mat([[-row[2]] for row in form[:2]])).tolist()
    depth = -dot(form[2], (x, y, ONE))
    lengths = np.linalg.norm(basis[:3, :2], axis=0)  # the directions are orthogonal
    scaled = np.array([[to_double(c / depth) for c in row] for row in block]) / np.outer(lengths, lengths)
    values, vectors = np.linalg.eigh(scaled)
    # of an ellipse a hundred million times longer than wide doubles do not tell the smaller value from zero
    determinant = (block[0][0] * block[1][1] - block[0][1] * block[1][0]) / depth**2
    values[0] = to_double(determinant) / float(np.prod(lengths)) ** 2 / values[1]
    axes = vectors / lengths[:, None] / np.sqrt(values)
    return np.column_stack([basis @ [to_double(x), to_double(y), 1.0], basis[:, :2] @ axes])


def _line_frame(loop: Loop, sample: Arc) -> np.ndarray:
    with precision(BITS):
        m = arb(sample.m)
        x, dx = loop.point(m, sample.sheet), loop.tangent(m, sample.sheet)
        p = [float(c / x[3]) for c in x[:3]]
        along = [a * x[3] - b * dx[3] for a, b in zip(dx[:3], x[:3], strict=True)]
        size = largest(along)
        d = np.array([float(c / size) for c in along])
    d /= np.linalg.norm(d)
    foot = np.array(p) - d * (d @ p)
    return np.array([[*d, 0.0], [*foot, 1.0]]).T


def _piece(run: _Run, loop: Loop, frame: np.ndarray, corners: _Corners) -> EdgePiece:
    is_line = frame.shape[1] == 2
    if run.start is None:
        return EdgePiece(0.0, 2 * math.pi, None, None)
    assert run.end is not None
    ends = [parameter(_homogeneous(loop, b.root.ball, b.sheet), frame) for b in (run.start, run.end)]
    at = parameter(_homogeneous(loop, run.sample.m, run.sample.sheet), frame)
    numbers = [corners.vertex_at(b) for b in (run.start, run.end)]
    if is_line:
        return _line_piece(ends, [b.finite for b in (run.start, run.end)], at, numbers)
    lo, hi = ends
    if run.start is run.end:
        return EdgePiece(lo, lo + 2 * math.pi, numbers[0], numbers[0])
    if (at - lo) % (2 * math.pi) > (hi - lo) % (2 * math.pi):
        lo, hi, numbers = hi, lo, numbers[::-1]
    return EdgePiece(lo, lo + (hi - lo) % (2 * math.pi), *numbers)


def _line_piece(ends: list[float], finite: list[bool], at: float, numbers: list[int | None]) -> EdgePiece:
    if not any(finite):
        return EdgePiece(-math.inf, math.inf, None, None)
    if all(finite):
        order = (0, 1) if ends[0] <= ends[1] else (1, 0)
        return EdgePiece(ends[order[0]], ends[order[1]], numbers[order[0]], numbers[order[1]])
    k = finite.index(True)
    if at < ends[k]:
        return EdgePiece(-math.inf, ends[k], None, numbers[k])
    return EdgePiece(ends[k], math.inf, numbers[k], None)


def _homogeneous(loop: Loop, m: fmpq | arb, sheet: int) -> np.ndarray:
    with precision(BITS):
        x = loop.point(arb(m), sheet)
        size = largest(x)
        return np.array([float(c / size) for c in x])


def parameter(x: np.ndarray, frame: np.ndarray) -> float:
    """The parameter of the homogeneous point on the curve."""
    y = np.linalg.lstsq(frame, x, rcond=None)[0]
    if frame.shape[1] == 2:
        return float(y[0] / y[1]) if y[1] else math.inf
    scale = y[0] or 1.0  # 0: it is far out on a curve that doubles hardly tell from a line
    return math.atan2(y[2] / scale, y[1] / scale)
