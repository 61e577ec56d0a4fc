"""What becomes of a solid: the file's own planes, quadrics and tori, else triangles."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.compound.compound import CompoundPiece
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.errors import InputError
from firstcontact.step import cells, planar
from firstcontact.step.carriers import NotExact
from firstcontact.step.reader import Shape
from firstcontact.step.solids import StepSolid, explored
from firstcontact.step.triangles import TriangleNet, triangulated

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

DEVIATION = 1e-4
"""Of the size of a part: how far triangles are from its faces at most, unless it is said."""
MOST_PIECES = 80
"""That are made of one solid, those that are mended counted anew, where nobody asks for more: about five seconds."""


@dataclass(frozen=True)
class Wanted:
    """How parts are built.

    deviation: at most, in the unit of the file, or None.  surfaces: whether curved solids become pieces with the file's
    own surfaces, where checks bear them out; None: where that takes seconds.
    """

    deviation: float | None = None
    surfaces: bool | None = None


@dataclass(frozen=True)
class Built:
    """pieces: bodies in the part's own frame; deviation: of their faces from the file's, a bound; solid: what they were
    made of; shown: makes polyhedra for pictures, None: the pieces; why: they do not lie on the very surfaces; cut:
    makes triangles instead, None of polyhedra."""

    pieces: tuple[CompoundPiece, ...]
    deviation: float
    solid: StepSolid
    shown: Callable[[], tuple[CompoundPiece, ...]] | None = None
    why: str | None = None
    cut: Callable[[], Built] | None = None

    def as_triangles(self) -> Built:
        """The same, if it is of polyhedra."""
        return self if self.cut is None else self.cut()

    @property
    def exact(self) -> bool:
        """Whether its faces lie on the very surfaces of the file."""
        return self.why is None

    def drawn(self) -> tuple[CompoundPiece, ...]:
        return self.pieces if self.shown is None else self.shown()


def solids_of(part: Shape) -> list[StepSolid]:
    """The solids of a part.  InputError for surfaces that bound none: to leave them out would be to lose them."""
    if "solids" not in part.made:
        from OCP.TopAbs import TopAbs_ShapeEnum as Kind

        found = [StepSolid(shape, part) for shape in explored(part.shape, Kind.TopAbs_SOLID)]
        loose = len(list(explored(part.shape, Kind.TopAbs_FACE))) - sum(len(solid.faces) for solid in found)
        if loose:
            StepSolid(part.shape, part).check_borders()  # tells where it is open
            raise InputError(
                f"{part.name}: {loose} of its faces bound no solid, and surfaces have no inside; export it as a solid"
            )
        part.made["solids"] = found
    known: list[StepSolid] = part.made["solids"]
    return known


def built(part: Shape, wanted: Wanted) -> tuple[Built, ...]:
    """The bodies of a part, each solid by itself, kept on it."""
    if wanted not in part.made:
        part.made[wanted] = tuple(_built(solid, wanted) for solid in solids_of(part))
    known: tuple[Built, ...] = part.made[wanted]
    return known


def _built(solid: StepSolid, wanted: Wanted) -> Built:
    try:
        return _of_solid(solid, wanted)
    except Exception as error:
        if not type(error).__module__.startswith("OCP."):
            raise
        raise InputError(f"{solid.who}: OpenCASCADE gives up ({error}); export the model again, nearer the origin "
                         "or in a larger unit if its numbers are large") from error  # fmt: skip


def _of_solid(solid: StepSolid, wanted: Wanted) -> Built:
    solid.check()
    flat = planar.polyhedron_of(solid)
    if flat is not None:
        _check_volume(solid, flat.polyhedron.vertices[flat.polyhedron.triangles], flat.moved)
        piece = CompoundPiece(flat.polyhedron, _names_of_polygons(solid, flat.polyhedron))
        return Built((piece,), flat.moved, solid)
    why = "asked for"
    if wanted.surfaces is not False:
        try:
            return _by_surfaces(solid, wanted)
        except (NotExact, InputError) as reason:  # of a broken solid no triangles are made either
            why = str(reason)
    return _by_triangles(solid, wanted, why)


def _by_triangles(solid: StepSolid, wanted: Wanted, why: str) -> Built:
    net = triangulated(solid, DEVIATION * solid.size if wanted.deviation is None else wanted.deviation)
    _check_volume(solid, net.points[net.triangles], net.deviation)
    piece = _mesh_piece(solid, net)
    return Built((piece,), net.deviation, solid, why=why)


def _by_surfaces(solid: StepSolid, wanted: Wanted) -> Built:
    """Raises NotExact where the file's surfaces are of other kinds, or checks do not bear the pieces out."""
    found = cells.cells_of(solid, None if wanted.surfaces else MOST_PIECES)
    if wanted.deviation is not None and found.off > wanted.deviation:
        raise NotExact(f"its edges are up to {found.off:.2g} off the surfaces that meet there")
    exact = [
        *(CompoundPiece(x.body, CellNames.of_cell(solid, x), corners=np.array(list(product(*zip(*x.box, strict=True)))))
          for x in found.cells),
        *(CompoundPiece(x.sector, RoundNames(x.walls, solid.labels)) for x in found.rounds),
    ]  # fmt: skip
    _check_volume(solid, found.rough.corners, found.rough.deviation + found.off)
    shown = cache(lambda: (_mesh_piece(solid, triangulated(solid, cells.ROUGH * solid.size)),))
    return Built(tuple(exact), found.off, solid, shown, cut=cache(lambda: _by_triangles(solid, wanted, "asked for")))


def _mesh_piece(solid: StepSolid, net: TriangleNet) -> CompoundPiece:
    mesh = Polyhedron(net.points, net.triangles.astype(np.int32), solid=True)
    return CompoundPiece(mesh, _names_of_triangles(solid, mesh, net))


def _check_volume(solid: StepSolid, corners: np.ndarray, deviation: float) -> None:
    """That nothing is lost: triangles with corners (n, 3, 3) within the deviation of the solid's boundary enclose the
    same but for a layer of that depth."""
    p, q, r = np.moveaxis(corners - solid.box[0], 1, 0)
    volume = float(np.einsum("ij,ij->i", p, np.cross(q, r)).sum()) / 6
    wanted, area = solid.volume_and_area
    if wanted <= 0.0:
        raise InputError(
            f"{solid.who}: OpenCASCADE finds the volume {wanted:.3g} in it: its faces look inward, or it is too far "
            "from the origin for its size; export it again, near the origin"
        )
    if abs(volume - wanted) > 2.0 * area * deviation + 1e-5 * wanted:
        raise InputError(
            f"{solid.who}: its faces do not enclose what they bound (volume {volume:.6g}, by OpenCASCADE "
            f"{wanted:.6g}); they cross each other: mend the model and export it again"
        )


@dataclass(frozen=True, eq=False)
class MeshNames:
    """Of polygons or triangles that stand for faces: what each vertex, edge and face of the mesh is of the solid's, as
    (kind, number); labels: what the file calls these, by kind."""

    own: dict[str, list[tuple[str, int]]]
    labels: dict[str, list[str]]

    def of(self, kind: str, index: int, body: Body) -> tuple[str, int, str] | None:
        """As `Names`: an element within a face is the face, one within an edge the edge."""
        kind, number = self.own[kind][index]
        return kind, number, self.labels[kind][number]


def _names_of_polygons(solid: StepSolid, mesh: Polyhedron) -> MeshNames:
    from OCP.TopExp import TopExp

    ends = {}
    for number, edge in enumerate(solid.edges):
        i, j = (solid.vertex_number(x) for x in (TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)))
        ends[min(i, j), max(i, j)] = number
    own = {
        "vertex": [("vertex", k) for k in range(len(mesh.vertices))],
        "edge": [("edge", ends[min(i, j), max(i, j)]) for i, j in mesh.edges.tolist()],
        "face": [("face", k) for k in range(mesh.n_faces)],
    }
    return MeshNames(own, solid.labels)


def _names_of_triangles(solid: StepSolid, mesh: Polyhedron, net: TriangleNet) -> MeshNames:
    corners, n = mesh.triangles.astype(np.int64), len(net.nodes)
    faces_at = np.zeros(n, int)
    faces_at[corners] = net.face_of[:, None]
    at = faces_at.tolist()
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
    codes, first = np.unique(ends.min(axis=2) * n + ends.max(axis=2), return_index=True)
    edges = np.sort(mesh.edges.astype(np.int64), axis=1)
    faces = net.face_of[first[np.searchsorted(codes, edges[:, 0] * n + edges[:, 1])] // 3]
    sides = zip(map(tuple, edges.tolist()), faces.tolist(), strict=True)
    own = {
        "vertex": [(kind, at[k] if kind == "face" else number) for k, (kind, number, _) in enumerate(net.nodes)],
        "edge": [("edge", net.sides[side]) if side in net.sides else ("face", face) for side, face in sides],
        "face": [("face", face) for face in net.face_of.tolist()],
    }
    return MeshNames(own, solid.labels)


@dataclass(frozen=True, eq=False)
class CellNames:
    """Of a piece with the file's own surfaces: own: of each of its surfaces the faces on it, none of walls and cuts;
    beside: of each edge of the solid its faces; around: of each vertex."""

    own: tuple[tuple[int, ...], ...]
    beside: tuple[frozenset[int], ...]
    around: tuple[frozenset[int], ...]
    labels: dict[str, list[str]]
    known: dict[tuple[Hashable, bool], tuple[str, int, str] | None] = field(default_factory=dict)
    """As asked for so far, by the surfaces that meet there and whether it is the tip of a cone."""

    @classmethod
    def of_cell(cls, solid: StepSolid, cell: cells.SolidCell) -> CellNames:
        return cls(tuple(cell.own), *solid.incidence, solid.labels)

    def of(self, kind: str, index: int, body: Any) -> tuple[str, int, str] | None:
        """As `Names`: faces whose surfaces meet there tell which edge or vertex it is; one face alone is that face."""
        feature = {"face": body.faces, "edge": body.edges}.get(kind, body.vertices)[index]
        key = feature.surfaces, kind not in ("face", "edge") and feature.is_apex
        if key not in self.known:
            self.known[key] = self._where(*key)
        return self.known[key]

    def _where(self, surfaces: Iterable[int], is_apex: bool) -> tuple[str, int, str] | None:
        groups = [self.own[k] for k in surfaces if self.own[k]]
        if not groups:
            return None
        if is_apex and (found := [k for k, faces in enumerate(self.around) if faces <= set(groups[0])]):
            return self._told("vertex", found)
        if len(groups) > 2 and (found := _meeting(self.around, groups)):
            return self._told("vertex", found)
        if len(groups) > 1 and (found := _meeting(self.beside, groups)):
            return self._told("edge", found)
        return self._told("face", list(groups[0]))

    def _told(self, kind: str, numbers: list[int]) -> tuple[str, int, str]:
        return told(kind, numbers, self.labels)


@dataclass(frozen=True, eq=False)
class RoundNames:
    """Of a sector of a torus: own: of its faces those that are some of the file's."""

    own: dict[int, tuple[int, ...]]
    labels: dict[str, list[str]]

    def of(self, kind: str, index: int, body: object) -> tuple[str, int, str] | None:
        """As `PieceNames`."""
        numbers = self.own.get(index)
        return None if not numbers else told("face", numbers, self.labels)


def told(kind: str, numbers: Sequence[int], labels: dict[str, list[str]]) -> tuple[str, int, str]:
    """Of several, which have their surfaces in common, all are told."""
    return kind, numbers[0], " or ".join(labels[kind][k] or str(k) for k in numbers[:4])


def _meeting(sets: tuple[frozenset[int], ...], groups: list[tuple[int, ...]]) -> list[int]:
    """Those of the sets that have a face of every group."""
    return [k for k, own in enumerate(sets) if all(own & set(group) for group in groups)]
