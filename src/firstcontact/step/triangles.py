"""Solids as triangles, with a proof of how far these are from the file's surfaces.

OpenCASCADE chooses the triangles in the parameters of each face; how far they are from it is proved here (`bounds`).
A face's points lie over its triangles, or between a side of these and the curve that bounds the face, where they are
as far from the side as the curve is in parameters.  Each point of the triangles lies likewise over the face.  Faces
meet in common corners, so that the triangles are closed where the solid is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from firstcontact.errors import InputError
from firstcontact.step.bounds import SAFE, CurveBounds, NotBounded, SurfaceBounds, chart_of
from firstcontact.step.charts import Elementary, elementary
from firstcontact.step.poles import spread
from firstcontact.step.sagitta import LONGER, drift, is_round, sagitta
from firstcontact.step.solids import StepSolid, Use, forward

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface
    from OCP.Geom2d import Geom2d_Curve
    from OCP.Poly import Poly_Triangulation
    from OCP.TopLoc import TopLoc_Location

COARSE = (0.8, 0.6), (0.8, 0.15), (0.4, 0.6), (0.1, 0.6), (0.02, 0.6)
"""What OpenCASCADE is asked for: a part of the deviation, and the angle between sides that follow each other; the next
one where triangles fold over each other or could not be made finer."""
LEAST = 2e-7
"""Of lengths that it takes; finer triangles are halves of these."""
OVER, BESIDE, ALONE = 0.5, 0.45, 0.95
"""Parts of the deviation for what lies over triangles, and for what lies beside them at a face's border; of either
where the other is nothing."""
PARTS = 4
"""Equal parts of a triangle's sides, and of a curve's, in which bounds that are too rough are looked at again."""
REST = 0.4
"""Of what lies over triangles of round faces: what may be off at borders, and of triangles across the surface."""
ROUNDS = 200
"""Around the tip of a cone triangles that lie across it are halved one after the other."""
MOST_TRIANGLES = 1_000_000
MOST_FLIPS = 20
"""Sides that a corner may be beyond."""

Made = TypeVar("Made")
Node = tuple[str, int, int]
"""What a corner is: ("vertex", number, 0), ("edge", number, k) or ("face", number, k)."""


@dataclass
class TriangleNet:
    """points: (n, 3); nodes: what each is; triangles: (m, 3) outward; face_of: (m,) numbers of their faces; sides: of
    pairs of corners i < j the edge that they are on; deviation: proved."""

    points: np.ndarray
    nodes: list[Node]
    triangles: np.ndarray
    face_of: np.ndarray
    sides: dict[tuple[int, int], int]
    deviation: float


def triangulated(solid: StepSolid, deviation: float) -> TriangleNet:
    """Triangles within the deviation of the solid's faces.  InputError names a face that cannot be had so."""
    from OCP.BRep import BRep_Tool

    def refuse_above(reached: float) -> None:
        if reached > deviation:
            raise InputError(
                f"{solid.who}: the file's own edges and corners are off by more than deviation= {deviation:.3g} "
                f"(reached {reached:.3g}); give a larger deviation="
            )

    refuse_above(max((BRep_Tool.Tolerance_s(edge) for edge in solid.edges), default=0.0))
    net = cut_by(solid, deviation, lambda: _Builder(solid, deviation).net())
    refuse_above(net.deviation)
    return net


def cut_by(solid: StepSolid, deviation: float, made: Callable[[], Made]) -> Made:
    """What is made of the triangles that OpenCASCADE cuts the faces into, of finer ones where faces fold over."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools

    folded = ""
    for share, angle in COARSE:
        BRepTools.Clean_s(solid.shape)
        BRepMesh_IncrementalMesh(solid.shape, max(share * deviation, LEAST), False, angle, False)
        try:
            return made()
        except Folded as reason:
            folded = str(reason)
        except NotBounded as reason:
            raise InputError(f"{solid.who}: {reason}; export the model with another kind of surface there") from reason
        finally:
            BRepTools.Clean_s(solid.shape)
    raise InputError(f"{solid.who}: {folded}; mend the face and export it again")


class Folded(Exception):
    """The triangles of a face lie over each other; the text says which."""


@dataclass(frozen=True)
class CutFace:
    """A face as OpenCASCADE cut it: uv: parameters of corners; triangles: of these, in their order; flipped: whether
    the solid is on the other side."""

    net: Poly_Triangulation
    location: TopLoc_Location
    surface: Geom_Surface
    flipped: bool
    uv: list[tuple[float, float]]
    triangles: list[tuple[int, int, int]]


def triangles_of(solid: StepSolid, number: int) -> CutFace:
    """The triangulation that a face has.  InputError where it has none."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location

    shape, location = solid.faces[number], TopLoc_Location()
    net = BRep_Tool.Triangulation_s(shape, location)
    if net is None or net.NbTriangles() == 0 or not net.HasUVNodes():
        raise InputError(
            f"{solid.who}: {solid.named('face', number)} has no area that can be cut into triangles; its edges cross "
            "or do not close: mend the face and export it again"
        )
    uv = [(p.X(), p.Y()) for p in map(net.UVNode, range(1, net.NbNodes() + 1))]
    found = [(i - 1, j - 1, k - 1) for i, j, k in (net.Triangle(n).Get() for n in range(1, net.NbTriangles() + 1))]
    flipped = shape.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return CutFace(net, location, BRep_Tool.Surface_s(shape), flipped, uv, found)


Segment = tuple[int, int]
"""Two corners of a face, by their numbers in the face, the smaller one first."""
Triangle = tuple[int, int, int]


@dataclass
class _Border:
    """A side of a face's triangles on an edge: the edge, its curve in the face's parameters, and the stretch."""

    edge: int
    curve: Any
    bends: CurveBounds
    t0: float
    t1: float
    first: int
    """The corner at t0."""
    beside: float | None = None
    """Bound of how far what is between the curve and its chord is from the chord, where it is known."""


@dataclass
class _TriangleFace:
    """uv, ids: of each corner its parameters and its number in the whole; triangles: by corners, in the order of the
    parameters; over: of each triangle the bound of how far the surface is from it, None where that is not known yet;
    """

    number: int
    surface: Any
    chart: SurfaceBounds
    flipped: bool
    uv: list[tuple[float, float]]
    ids: list[int]
    triangles: list[tuple[int, int, int]]
    over: list[float | None]
    borders: dict[Segment, _Border] = field(default_factory=dict)
    poles: set[Segment] = field(default_factory=set)
    """Sides that are one point, as at the tip of a cone."""
    off: float = 0.0
    """What the file's edges are off, and corners are off the surface."""
    flat: bool = False
    apart: float = 0.0
    """What corners are off the curves, in parameters, as a length."""
    known: Elementary | None = None
    """The chart, where it is a simple one."""
    round: bool = False
    """Whether bounds are those of `sagitta`; `over` is not used then."""
    over_most: float = OVER
    beside_most: float = BESIDE
    """Parts of the deviation."""

    around: _Around | None = None
    """What was found of it last, until it is cut again."""

    def __post_init__(self) -> None:
        self.low, self.high = np.min(self.uv, axis=0), np.max(self.uv, axis=0)
        """Of all parameters of corners."""

    def places(self, uv: np.ndarray) -> np.ndarray:
        """(n, 3) points of the surface at the (n, 2) parameters."""
        if self.known is not None:
            return self.known.at(uv)
        return np.array([_at(self.surface, u, v) for u, v in uv.tolist()]).reshape(-1, 3)


class _Builder:
    def __init__(self, solid: StepSolid, wanted: float) -> None:
        self.solid, self.wanted = solid, wanted
        self.numbers: dict[Node, int] = {}
        self.nodes: list[Node] = []
        self.points: list[np.ndarray] = []
        self.counts: dict[int, int] = {}
        self.middles: dict[tuple[int, int, int], int] = {}
        """Of (edge, corner, corner) the corner between them."""

    def net(self) -> TriangleNet:
        faces = [self._face(number) for number in range(len(self.solid.faces))]
        for _ in range(ROUNDS):
            marked = [self._too_far(face) for face in faces]
            if not any(marked):
                break
            self._share(faces, marked)
            for face, sides in zip(faces, marked, strict=True):
                self._split(face, sides)
            if sum(len(face.triangles) for face in faces) > MOST_TRIANGLES:
                raise InputError(f"{self.solid.who}: more than {MOST_TRIANGLES:,} triangles for deviation= "
                                 f"{self.wanted:.3g}; give a larger one")  # fmt: skip
        else:
            raise Folded("its triangles do not come near to its faces, however often they are halved")
        return self._joined(faces)

    def _joined(self, faces: list[_TriangleFace]) -> TriangleNet:
        triangles, owners, worst, sides = [], [], 0.0, {}
        for number, face in enumerate(faces):
            check_tiling(self.solid, number, np.array(face.uv), np.array(face.triangles))
            worst = max(worst, self._deviation(face))
            ids = np.array(face.ids)
            corners = ids[np.array(face.triangles)]
            corners = corners[:, ::-1] if face.flipped else corners
            real = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
            triangles.append(corners[real])
            owners.append(np.full(int(real.sum()), number))
            for (i, j), border in face.borders.items():
                sides[min(ids[i], ids[j]), max(ids[i], ids[j])] = border.edge
        joined = np.concatenate(triangles)
        _check_closed(joined, self.solid)
        return TriangleNet(np.array(self.points), self.nodes, joined, np.concatenate(owners), sides, worst)

    # -- what OpenCASCADE cut -----------------------------------------------------------------------------------

    def _face(self, number: int) -> _TriangleFace:
        """The triangulation of a face, with numbers of its corners in the whole."""
        cut = triangles_of(self.solid, number)
        uv, surface = cut.uv, cut.surface
        low, high = np.min(uv, axis=0), np.max(uv, axis=0)
        room = 1e-3 * (high - low)
        try:
            chart = chart_of(surface, (low[0] - room[0], high[0] + room[0], low[1] - room[1], high[1] + room[1]))
        except NotBounded as reason:
            raise NotBounded(
                f"{self.solid.named('face', number)} is of kind {reason}, whose triangles have no proved bound"
            ) from reason
        unknown: list[float | None] = [None] * len(cut.triangles)
        face = _TriangleFace(number, surface, chart, cut.flipped, uv, [-1] * len(uv), cut.triangles, unknown)
        face.known = elementary(surface)
        face.flat = surface.DynamicType().Name() == "Geom_Plane"
        face.round = face.known is not None and is_round(face.known)
        for use in self.solid.uses[number]:
            self._weld(number, face, use, cut)
        for k, id_ in enumerate(face.ids):
            if id_ < 0:
                face.ids[k] = self._number(("face", number, k), surface, *uv[k])
        face.triangles, face.poles = spread(face.uv, face.ids, face.triangles, face.poles)
        face.over = [None] * len(face.triangles)
        places = face.places(np.array(uv))
        off = np.linalg.norm(np.array([self.points[k] for k in face.ids]) - places, axis=1)
        face.off += float(off.max())
        if face.flat:
            face.beside_most = ALONE
        elif all(border.bends.is_straight for border in face.borders.values()):
            face.over_most = ALONE
        return face

    def _number(self, node: Node, surface: Geom_Surface, u: float, v: float) -> int:
        """Of a corner in the whole; where it is new, it is at the parameters, or in the file's vertex."""
        if node not in self.numbers:
            self.numbers[node] = len(self.nodes)
            self.nodes.append(node)
            self.points.append(self.solid.points[node[1]] if node[0] == "vertex" else _at(surface, u, v))
        return self.numbers[node]

    def _weld(self, number: int, face: _TriangleFace, use: Use, cut: CutFace) -> None:
        """The corners of the face along one of its edges."""
        from OCP.BRep import BRep_Tool
        from OCP.TopExp import TopExp

        who = f"{self.solid.who}: {self.solid.named('edge', use.number)}"
        polygon = BRep_Tool.PolygonOnTriangulation_s(use.edge, cut.net, cut.location)
        if polygon is None or not polygon.HasParameters():
            raise InputError(f"{who} is not on {self.solid.named('face', number)}; mend the face and export it again")
        local = np.array([polygon.Node(k) for k in range(1, polygon.NbNodes() + 1)]) - 1
        times = np.array([polygon.Parameter(k) for k in range(1, polygon.NbNodes() + 1)])
        order = np.argsort(times, kind="stable")
        local, times = local[order], times[order]
        first = self.solid.vertex_number(TopExp.FirstVertex_s(use.edge, False))
        last = self.solid.vertex_number(TopExp.LastVertex_s(use.edge, False))
        degenerate = self.solid.is_degenerate(use.number)
        if self.counts.setdefault(use.number, len(local)) != len(local) and not degenerate:
            raise InputError(f"{who} is cut otherwise by its two faces; mend the model and export it again")
        nodes: list[Node] = [("vertex", first, 0) if degenerate else ("edge", use.number, k) for k in range(len(local))]
        nodes[0], nodes[-1] = ("vertex", first, 0), ("vertex", last, 0)
        for node, k in zip(nodes, local.tolist(), strict=True):
            face.ids[k] = self._number(node, face.surface, *face.uv[k])
        if degenerate:
            face.poles |= {(min(i, j), max(i, j)) for i, j in zip(local.tolist(), local.tolist()[1:], strict=False)}
        else:
            self._note_borders(number, face, use, local.tolist(), times.tolist())

    def _note_borders(self, number: int, face: _TriangleFace, use: Use, local: list[int], times: list[float]) -> None:
        from OCP.BRep import BRep_Tool
        from OCP.TopoDS import TopoDS

        who = self.solid.named("edge", use.number)
        corners = np.array([face.uv[k] for k in local])

        def off_by(curve: Geom2d_Curve) -> np.ndarray:
            at = np.array([(p.X(), p.Y()) for p in map(curve.Value, times)])
            away: np.ndarray = np.abs(at - corners).max(axis=0)
            return away

        plain = forward(self.solid.faces[number])
        curves = [BRep_Tool.CurveOnSurface_s(TopoDS.Edge(x), plain, 0.0, 0.0) for x in (use.edge, use.edge.Reversed())]
        # a seam has one on either side
        known = [(float((off := off_by(x)).sum()), k, x, off) for k, x in enumerate(curves) if x is not None]
        if not known:
            raise InputError(f"{self.solid.who}: {who} has no curve on {self.solid.named('face', number)}; mend the "
                             "face and export it again")  # fmt: skip
        *_, curve, off = min(known)
        try:
            bends = CurveBounds(curve, times[0], times[-1])
        except NotBounded as reason:
            raise NotBounded(f"{who} is a curve of kind {reason}, whose chords have no proved bound") from reason
        for i, j, t0, t1 in zip(local, local[1:], times, times[1:], strict=False):
            face.borders[min(i, j), max(i, j)] = _Border(use.number, curve, bends, t0, t1, i)
        face.apart = max(face.apart, self._length(face, off))
        face.off = max(face.off, BRep_Tool.Tolerance_s(use.edge))

    def _beside(self, face: _TriangleFace, border: _Border) -> float:
        """How far the surface between a border's curve and its chord is from the chord at most."""
        if border.beside is None and border.bends.is_straight:
            border.beside = 0.0
        elif border.beside is None:
            away, whole = _chord(border)
            border.beside = whole if face.flat else self._length(face, away)
        return border.beside

    def _length(self, face: _TriangleFace, off: np.ndarray) -> float:
        """How long a step in parameters is at most."""
        if not off.any():
            return 0.0
        (u0, v0), (u1, v1) = face.low - off, face.high + off
        most = face.chart.over(np.array([[u0, u1, v0, v1]]))[0]
        return float(most[0] * off[0] + most[1] * off[1])

    # -- finer --------------------------------------------------------------------------------------------------

    def _too_far(self, face: _TriangleFace) -> set[Segment]:
        """The sides to be halved: of triangles that are too far from the surface, and along curved borders."""
        marked = self._far_from_round(face) if face.round else self._far_from_others(face)
        most = face.beside_most * self.wanted
        return marked | {side for side, border in face.borders.items() if self._beside(face, border) > most}

    def _far_from_round(self, face: _TriangleFace) -> set[Segment]:
        """What is off at borders may be REST of all; the triangles the remainder."""
        all_, most = _around(face), face.over_most * self.wanted
        far = np.where(all_.along, all_.away > most - min(all_.rest, REST * most), all_.loose > REST * most)
        corners = np.array(face.triangles)
        marked: set[Segment] = set()
        for k, side in zip(np.flatnonzero(far).tolist(), all_.longest[far].tolist(), strict=True):
            i, j = corners[k, side].item(), corners[k, (side + 1) % 3].item()
            marked.add((min(i, j), max(i, j)))
        return marked | {side for side, x in zip(face.borders, all_.drift.tolist(), strict=True) if x > REST * most}

    def _far_from_others(self, face: _TriangleFace) -> set[Segment]:
        marked: set[Segment] = set()
        unknown = [k for k, over in enumerate(face.over) if over is None]
        if unknown:
            for k, (over, side) in zip(unknown, self._bounds(face, unknown), strict=True):
                face.over[k] = over
                if over > face.over_most * self.wanted:
                    marked.add(side)
        return marked

    def _bounds(self, face: _TriangleFace, which: list[int]) -> list[tuple[float, Segment]]:
        """Of triangles the bound of how far the surface is from them, and the side that adds most to it."""
        uv = np.array(face.uv)
        corners = np.array([face.triangles[k] for k in which])
        p = uv[corners]
        over, sides = _parametric(face, p)
        ends = [(0, 1), (1, 2), (2, 0)]
        rough = over > face.over_most * self.wanted
        if rough.any():
            over[rough] = np.minimum(over[rough], over[rough] / PARTS**2 + _seen(face, p[rough]))
        longest = [ends[k] for k in sides.argmax(axis=1).tolist()]
        found = []
        for corner, (i, j), bound in zip(corners.tolist(), longest, over.tolist(), strict=True):
            found.append((bound, (min(corner[i], corner[j]), max(corner[i], corner[j]))))
        return found

    def _share(self, faces: list[_TriangleFace], marked: list[set[Segment]]) -> None:
        """What is halved on an edge is so by both of its faces."""
        halved = {
            (face.borders[side].edge, *sorted((face.ids[side[0]], face.ids[side[1]])))
            for face, sides in zip(faces, marked, strict=True) for side in sides if side in face.borders
        }  # fmt: skip
        for face, sides in zip(faces, marked, strict=True):
            for (i, j), border in face.borders.items():
                if (border.edge, *sorted((face.ids[i], face.ids[j]))) in halved:
                    sides.add((i, j))

    def _split(self, face: _TriangleFace, sides: set[Segment]) -> None:
        """Halve these sides, and cut the triangles that have them."""
        if not sides:
            return
        face.around = None
        middle = {side: self._middle(face, side) for side in sorted(sides)}
        corners, n = np.array(face.triangles), len(face.uv)
        ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
        is_cut = np.zeros(len(corners), bool)
        is_cut[np.nonzero(np.isin(ends[..., 0] * n + ends[..., 1], [i * n + j for i, j in middle]))[0]] = True
        triangles: list[tuple[int, int, int]] = []
        over: list[float | None] = []
        for triangle, known, cut in zip(face.triangles, face.over, is_cut.tolist(), strict=True):
            parts = _cut(triangle, middle) if cut else [triangle]
            triangles += parts
            over += [None] * len(parts) if cut else [known]
        face.triangles, face.over = unfolded(np.array(face.uv), triangles, over)

    def _middle(self, face: _TriangleFace, side: Segment) -> int:
        """A new corner in the middle of a side: on the edge, of a border."""
        i, j = side
        number = len(face.uv)
        border = face.borders.pop(side, None)
        if border is None:
            u, v = (0.5 * (a + b) for a, b in zip(face.uv[i], face.uv[j], strict=True))
            face.uv.append((u, v))
            if side in face.poles:
                face.ids.append(face.ids[i])
                face.poles |= {(i, number), (j, number)}
                return number
            face.ids.append(self._number(("face", face.number, number), face.surface, u, v))
            return number
        t = 0.5 * (border.t0 + border.t1)
        p = border.curve.Value(t)
        face.uv.append((p.X(), p.Y()))
        face.low, face.high = np.minimum(face.low, face.uv[-1]), np.maximum(face.high, face.uv[-1])
        key = border.edge, min(face.ids[i], face.ids[j]), max(face.ids[i], face.ids[j])
        if key not in self.middles:
            self.middles[key] = self._number(("edge", border.edge, len(self.nodes) + MOST_TRIANGLES),
                                             face.surface, p.X(), p.Y())  # fmt: skip
        face.ids.append(self.middles[key])
        place = _at(face.surface, p.X(), p.Y())
        face.off = max(face.off, float(np.linalg.norm(self.points[face.ids[-1]] - place)))
        last = j if border.first == i else i
        for a, b, t0, t1 in ((border.first, number, border.t0, t), (number, last, t, border.t1)):
            face.borders[min(a, b), max(a, b)] = _Border(border.edge, border.curve, border.bends, t0, t1, a)
        return number

    def _deviation(self, face: _TriangleFace) -> float:
        """Proved bound for one face."""
        if face.round:
            all_ = _around(face)
            over = float(all_.away[all_.along].max(initial=0.0)) + all_.rest
        else:
            over = max(x for x in face.over if x is not None)
        beside = max((self._beside(face, border) for border in face.borders.values()), default=0.0)
        return (over + beside + face.apart + face.off) * SAFE


def _at(surface: Geom_Surface, u: float, v: float) -> np.ndarray:
    p = surface.Value(u, v)
    return np.array([p.X(), p.Y(), p.Z()])


def _bend(most: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Bounds of second differences over steps (n, 2) in parameters."""
    du, dv = steps[:, 0], steps[:, 1]
    found: np.ndarray = most[:, 2] * du**2 + 2 * most[:, 3] * du * dv + most[:, 4] * dv**2
    return found


def _parametric(face: _TriangleFace, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) bounds of how far the surface at parameters in triangles (n, 3, 2) is from their points there, and of each
    side what it adds, (n, 3)."""
    low, high = p.min(axis=1), p.max(axis=1)
    most = face.chart.over(np.column_stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]]))
    sides = np.column_stack([_bend(most, np.abs(p[:, i] - p[:, j])) for i, j in ((0, 1), (1, 2), (2, 0))])
    return _bend(most, high - low) / 8, sides


@dataclass(frozen=True)
class _Around:
    """Of a round face: of each triangle the bound where it lies along the surface, the other one where it does not, and
    its side that bends most; of each border side the drift; and the most that these and loose triangles add to all."""

    away: np.ndarray
    along: np.ndarray
    loose: np.ndarray
    longest: np.ndarray
    drift: np.ndarray
    rest: float


def _around(face: _TriangleFace) -> _Around:
    if face.around is None:
        face.around = _looked_around(face)
    return face.around


def _looked_around(face: _TriangleFace) -> _Around:
    assert face.known is not None
    uv = np.array(face.uv)
    p = uv[np.array(face.triangles)]
    parametric, sides = _parametric(face, p)
    found = sagitta(face.known, p, parametric)
    ends = uv[np.array(list(face.borders), int).reshape(-1, 2)]
    off = drift(face.known, ends, _parametric(face, ends[:, [0, 1, 1]])[0])
    loose = np.where(found.along, 0.0, LONGER * parametric)
    longest = np.where(found.along, found.of_sides.argmax(axis=1), sides.argmax(axis=1))
    return _Around(found.away, found.along, loose, longest, off, float(max(off.max(initial=0.0), loose.max())))


def _cut(triangle: tuple[int, int, int], middle: dict[Segment, int]) -> list[tuple[int, int, int]]:
    """The triangle, cut at the middles of its sides that have one."""
    a, b, c = triangle
    at = [middle.get((min(i, j), max(i, j))) for i, j in ((a, b), (b, c), (c, a))]
    count = sum(x is not None for x in at)
    if count == 0:
        return [triangle]
    while at[0] is None or (count == 2 and at[2] is not None):  # one: at a b; two: at a b and b c
        a, b, c, at = b, c, a, [at[1], at[2], at[0]]
    d, e, f = at
    assert d is not None
    if count == 1:
        return [(a, d, c), (d, b, c)]
    assert e is not None
    if count == 2:
        return [(a, d, c), (d, b, e), (d, e, c)]
    assert f is not None
    return [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]


def _chord(border: _Border) -> tuple[np.ndarray, float]:
    """How far the curve comes from its chord at most, in each parameter and in all: at the ends of equal parts, and
    between."""
    t0, t1 = border.t0, border.t1
    away: np.ndarray = border.bends.bends(t0, t1) * (t1 - t0) ** 2 / 8
    whole = float(border.bends.over(np.array([[t0, t1]]))[1][0]) * (t1 - t0) ** 2 / 8
    if border.bends.nets is None:
        return away, whole
    shares = np.linspace(0.0, 1.0, PARTS + 1)
    at = np.array([(p.X(), p.Y()) for p in (border.curve.Value(float(t0 + (t1 - t0) * s)) for s in shares)])
    off = at - (at[0] + shares[:, None] * (at[-1] - at[0]))
    length = float(np.linalg.norm(off, axis=1).max())
    return np.minimum(away, away / PARTS**2 + np.abs(off).max(axis=0)), min(whole, whole / PARTS**2 + length)


_SHARES = np.array([(i, j, PARTS - i - j) for i in range(PARTS + 1) for j in range(PARTS + 1 - i)]) / PARTS


def _seen(face: _TriangleFace, uv: np.ndarray) -> np.ndarray:
    """How far each of the triangles (n, 3, 2) is from the surface at the corners of its equal parts."""
    at = face.places((_SHARES @ uv).reshape(-1, 2)).reshape(len(uv), -1, 3)
    corners = face.places(uv.reshape(-1, 2)).reshape(-1, 3, 3)
    found: np.ndarray = np.linalg.norm(at - _SHARES @ corners, axis=2).max(axis=1, initial=0.0)
    return found


def unfolded(
    uv: np.ndarray, triangles: list[Triangle], known: list[float | None]
) -> tuple[list[Triangle], list[float | None]]:
    """Triangles over the same parameters, each the right way round, and what is known of those that are as they were.

    A corner that comes to lie on a bent border may be beyond the side opposite to it: then it belongs into the triangle
    on the other side of that, or beyond that one.
    """
    folded = np.flatnonzero(_areas(uv, np.array(triangles)) < 0.0).tolist()
    if not folded:
        return triangles, known
    triangles, known = list(triangles), list(known)
    with_side = {side: k for k, corners in enumerate(triangles) for side in _sides(corners)}
    for _ in range(MOST_FLIPS * len(folded)):
        if not folded:
            break
        k = folded.pop()
        corners = triangles[k]
        newest = corners.index(max(corners))
        a, b, c = (corners[(newest + n) % 3] for n in (1, 2, 0))  # c is beyond the side a b
        other = with_side.get((b, a))
        if other is None:
            continue
        d = next(x for x in triangles[other] if x not in (a, b))
        halves = (a, d, c), (d, b, c)
        signs = np.sign(_areas(uv, np.array(halves)))
        if signs.max() <= 0.0:
            continue
        del with_side[a, b], with_side[b, a]
        for number, half, way in zip((k, other), halves, signs.tolist(), strict=True):
            triangles[number], known[number] = half, None
            with_side |= dict.fromkeys(_sides(half), number)
            if way < 0.0:
                folded.append(number)
    return triangles, known


def _sides(triangle: Triangle) -> list[tuple[int, int]]:
    a, b, c = triangle
    return [(a, b), (b, c), (c, a)]


def _areas(uv: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Twice the areas of triangles, (n, 3) numbers of corners, below 0 where they turn the other way."""
    p, q, r = (uv[triangles[:, k]] for k in range(3))
    found: np.ndarray = (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])
    return found


def check_tiling(solid: StepSolid, number: int, uv: np.ndarray, triangles: np.ndarray) -> None:
    """That the triangles cover what their outer sides enclose, once: all turn one way, and the sides that belong to one
    triangle alone are those of edges."""
    area = _areas(uv, triangles)
    if (area < -1e-9 * np.abs(area).max()).any():
        raise Folded(f"{solid.named('face', number)} folds over itself where it is cut into triangles; its edges cross")


def _check_closed(triangles: np.ndarray, solid: StepSolid) -> None:
    """That each side of a triangle is one of another's, backwards."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    n = int(triangles.max()) + 1
    ahead, back = np.sort(sides[:, 0] * n + sides[:, 1]), np.sort(sides[:, 1] * n + sides[:, 0])
    if len(ahead) != len(back) or not np.array_equal(ahead, back):
        raise InputError(f"{solid.who}: the triangles of its faces do not close; mend the model and export it again")
