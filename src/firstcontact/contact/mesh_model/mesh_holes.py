"""The surface of a polyhedron against a curved model that is no union of convex parts: one with holes, or a waist.

Convex pieces that cover the model leave few triangles; these go in groups, each as a flat model, through the search for
events (`search.events.events`).  A flat model has no inside: what closes an interval from above is a point of the
polyhedron that the model is proved to hold soon after.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import QuarticCurve, doubles
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.mesh_model.lasting_mesh import LastingOfMesh
from firstcontact.contact.mesh_model.patches import Patch, has_area, longest_side, patch, triangles_at_edge
from firstcontact.contact.models.shared.same_point import near_surfaces
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import to_double
from firstcontact.kernels.convex.advancement import CONTACT, advance_pieces
from firstcontact.kernels.convex.flat import ONLY, write_triangle
from firstcontact.kernels.convex.mesh_walk import PART
from firstcontact.kernels.events.event_search import FREE, GOING, SPENT
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.convex.convex import NotConvex, convex_pieces, covering_pieces
from firstcontact.search.convex.mesh_advance import STRIDES, MeshSearch, Open, Swept, Touch, first_of_each
from firstcontact.search.events import events
from firstcontact.search.events.charts import NotCharted, charts_of
from firstcontact.search.events.event_tables import crossing_surfaces, tables_of
from firstcontact.search.events.instants import PlacedForms
from firstcontact.search.events.shared_points import SharedEvent, events_in
from firstcontact.timeline.lasting import LastingSolid, linear
from firstcontact.work import Progress

MOST_TRIANGLES = 10
"""In a group: its planes and those of the sides are told apart by bits of one word."""
MOST_BOXES = 200_000
"""Boxes looked at for one group before it counts as open."""
RESOLVED = 1e-12
"""Part of a window: to what times candidates are told apart."""
SHARES = 0.25, 0.9
"""Of the width of the answer: how long after the last free time a common point is sought."""
NEAR = 1e-5
"""Part of a triangle's size within which places of contact count as one."""
BESIDE = 1e-7
"""Weight of a corner below which a place may be on the border of an edge or a triangle that does without it."""
MOMENT = 1e-6
"""Part of a window over which velocities are taken."""
GRAZING = 1e-6
"""Sine of the angle below which the sense of an approach is not told."""
OFF, OFF_QUARTIC = 1e-9, 1e-6
"""Part of a model's size within which doubles have points of its curves."""


def search_of(
    mesh: Polyhedron, model: CompositeQuadric, mesh_is_a: bool, budget: int | None, progress: Progress | None = None
) -> MeshSearch:
    """By convex parts where the model is a union of such, else by events.  Raises UnsupportedPair."""
    try:
        return MeshSearch(mesh, convex_pieces(model), mesh_is_a, budget, progress)
    except NotConvex:
        return HoledSearch(mesh, model, mesh_is_a, budget, progress)


class _Kind(Enum):
    """Of what is near the model: SIDE is a triangle without area, a side of another one."""

    TRIANGLE, SIDE, BARE = range(3)


@dataclass(frozen=True)
class _Stop:
    """A slab of time, the first one that may hold an event of a group; boxes: those that survive there."""

    lo: float
    boxes: np.ndarray
    search: events.EventSearch
    spent: bool


class HoledSearch(MeshSearch):
    """As `MeshSearch`, whose pieces cover the model only."""

    pieces_are_model = False

    def __init__(
        self, mesh: Polyhedron, model: CompositeQuadric, mesh_is_a: bool, budget: int | None, progress: Progress | None
    ) -> None:
        who = model.name or "a model"
        if not model.bounded:  # at rest it is cut around the other's path
            raise UnsupportedPair(f"{who} has no end and moves; let it rest, and the mesh move the other way")
        try:
            charts_of(model)
        except NotCharted as reason:
            told = f"{who} meets small convex polyhedra that are solid only: {reason}"
            raise UnsupportedPair(f"{told}; give it as triangles, a STEP part by surfaces=False") from reason
        super().__init__(mesh, covering_pieces(model), mesh_is_a, budget, progress)
        self.mesh, self.model = mesh, model
        self.lasting = LastingOfMesh(mesh, LastingSolid(model), mesh_is_a)
        self.groups: dict[tuple[int, ...], _Group] = {}
        self.kinds: dict[int, _Kind] = {}

    # -- the searches ----------------------------------------------------------------------------------------

    def run(self, window: Window, width: float, back: float | None = None) -> Swept:
        near = self.near(window)
        if near.reason == "budget" or near.status == "free":
            return near
        grouped, left = self._told_apart(near.open)
        groups, inside = self._grouped(grouped), []
        for group, free_until in groups:
            if free_until > window.first:
                continue
            if self._apart(group, window):
                continue
            if (place := self.lasting.on(group.triangles).deepest(window, window.first, [])) is not None:
                t = window.first
                return self._answer("initial", t, touch=Touch(t, t, t, place, None, group.triangles[0]))
            inside.append(group)
            left += group.opened(window.first)
        best: Touch | None = None
        if window.last > window.first:
            rest = [(group, t) for group, t in groups if group not in inside]
            best, left = self._first_of_bare(left, window, width)
            best, spent = self._first_of(rest, left, window, width, best)
            if spent is not None:
                return self._answer("open", min([spent, *(x.free_until for x in left)]), reason="budget")
        return self._settled(window, best, left, width)

    def candidates(self, window: Window, until: float) -> list[Open] | None:
        width = RESOLVED * (window.last - window.first)
        near = self.near(window._replace(last=until, inner=window.first))
        if near.reason == "budget":
            return None
        grouped, left = self._told_apart(near.open)
        for group, free_until in self._grouped(grouped):
            if free_until <= window.first and not self._apart(group, window):
                left += group.opened(window.first)
            elif (stop := self._stop(group, window, max(free_until, window.first), until, width)) is not None:
                left += group.opened(stop.lo)
                if stop.spent:
                    return None
        return left

    def points_of_model(self, window: Window) -> list[tuple[float, float, float] | None]:
        own, other = self._motions(window)
        p, q = (self.lasting.pose(m, window.first) for m in (own, other))
        points, off = _anchors(self.model)
        size = float(np.abs(points).max() + np.abs(p[9:12]).max() + np.abs(q[9:12]).max())
        x = np.linalg.solve(linear(p), (points @ linear(q).T + q[9:12] - p[9:12]).T).T
        off = 2.0 * off * float(np.abs(np.linalg.solve(linear(p), linear(q))).sum(axis=1).max()) + 1e-13 * size
        room = off + 2.0 * self.mesh.error
        lo, hi = self.mesh.bounds()
        far = (np.maximum(lo - x, x - hi).max(axis=1) > room).tolist()
        return [
            tuple(c) if apart or _least_distance(self.mesh, c) > r else None
            for c, r, apart in zip(x, room.tolist(), far, strict=True)
        ]

    def approach(self, window: Window, t: float, place: np.ndarray) -> np.ndarray:
        """(3,) velocity of the polyhedron as the model sees it, at a point, all in the world."""
        h = MOMENT * (window.last - window.first)
        times = max(t - h, window.first), min(t + h, window.inner)
        rates = []
        for m in self._motions(window):
            here = self.lasting.pose(m, t)
            x = np.linalg.solve(linear(here), place - here[9:12])
            before, after = (linear(p) @ x + p[9:12] for p in (self.lasting.pose(m, s) for s in times))
            rates.append((after - before) / max(times[1] - times[0], 1e-300))
        seen: np.ndarray = rates[0] - rates[1]
        return seen

    # -- groups ----------------------------------------------------------------------------------------------

    def _told_apart(self, near: Sequence[Open]) -> tuple[list[Open], list[Open]]:
        """(triangles, which go into groups; bare edges and points, which doubles leave open).

        Triangles without area are such edges and points, but for those that are a side of another one.
        """
        kinds = {x.primitive: self._kind(x.primitive) for x in near}
        of_kind = [[x for x in near if kinds[x.primitive] == kind] for kind in (_Kind.TRIANGLE, _Kind.BARE)]
        return of_kind[0], of_kind[1]

    def _kind(self, k: int) -> _Kind:
        if k >= len(self.mesh.triangles):
            return _Kind.BARE
        if k not in self.kinds:
            self.kinds[k] = _Kind.TRIANGLE
            if not has_area(self.mesh, k):
                side = longest_side(self.mesh, k)
                around = [] if side is None or side < 0 else triangles_at_edge(self.mesh, side).tolist()
                self.kinds[k] = _Kind.SIDE if any(has_area(self.mesh, j) for j in around) else _Kind.BARE
        return self.kinds[k]

    def _grouped(self, near: Iterable[Open]) -> list[tuple[_Group, float]]:
        """Neighbours, with the time to which the pieces that cover the model leave them free, early ones first."""
        free = {x.primitive: x for x in first_of_each(near)}
        around = defaultdict(list)
        for k in free:
            for v in self.mesh.triangles[k].tolist():
                around[v].append(k)
        found, taken = [], set()
        for k in free:
            if k in taken:
                continue
            group = [k]
            taken.add(k)
            for member in group:
                for v in self.mesh.triangles[member].tolist():
                    for n in around[v]:
                        if n not in taken and len(group) < MOST_TRIANGLES:
                            taken.add(n)
                            group.append(n)
            found.append((self._group(tuple(sorted(group)), free[k].piece), free[k].free_until))
        return found

    def _group(self, triangles: tuple[int, ...], piece: int) -> _Group:
        known = self.groups.get(triangles)
        if known is None:
            known = self.groups[triangles] = _Group(triangles, piece, patch(self.mesh, triangles, (0.0, 0.0, 0.0)))
        return known

    def _search(self, group: _Group, window: Window, width: float) -> events.EventSearch:
        bodies: tuple[Any, Any] = (group.patch, self.model) if self.mesh_is_a else (self.model, group.patch)
        budget = int(min(MOST_BOXES, max(self.budget - self.tests - int(self.state[0]), 0)))
        if group.tables is None:
            group.tables = tables_of(*bodies)
        search = events.EventSearch(*bodies, group.tables, [window], 1.0, budget)
        search.width = width
        return search

    def _apart(self, group: _Group, window: Window) -> bool:
        """Whether the triangles are proved apart from the model at the start of the window."""
        search = self._search(group, window, 0.0)
        budget = min(search.budget, events.MOST_STILL)
        apart = search.searched(True, window, window.first, window.first, budget) == FREE
        self.tests += search.done
        return apart

    def _stop(self, group: _Group, window: Window, begin: float, last: float, width: float) -> _Stop | None:
        """The first slab that may hold an event of the group, which is apart at `begin`; None: none up to `last`."""
        search = self._search(group, window, width)
        outcome = search.first(window._replace(last=last), begin)
        self.tests += search.done
        if outcome == FREE:
            return None
        lo, _, count, start = search.result[:GOING].tolist()
        boxes = search.pool[int(start) : int(start + count)] if outcome != SPENT else search.pool[:0]
        return _Stop(max(lo, begin), boxes, search, search.is_spent and search.budget < MOST_BOXES)

    # -- contact ---------------------------------------------------------------------------------------------

    def _first_of_bare(self, left: list[Open], window: Window, width: float) -> tuple[Touch | None, list[Open]]:
        """(the first proved contact of bare edges and points with what covers the model, of which they are proved to
        hold a point then; what is still open)"""
        best: Touch | None = None
        open_: list[Open] = []
        for x in left:
            touch = self._with_cover(x, window, width) if x.free_until > window.first else None
            if touch is None:
                open_.append(x)
            else:
                best = touch if best is None else _first(best, touch)
        return best, open_

    def _with_cover(self, x: Open, window: Window, width: float) -> Touch | None:
        """The contact of a bare edge or point with a piece of the cover, where the model itself is there too."""
        if self._kind(x.primitive) is not _Kind.BARE:
            return None
        mesh, model = self._motions(window)
        (part,) = np.flatnonzero(self.tree.ids[:, 0] == x.primitive)
        write_triangle(self.rows, self.tree.xyz[part], self.tree.error)
        outcome = advance_pieces(
            self.rows, ONLY, mesh, self.pieces.array, x.piece, model,
            window.first, window.last, window.inner, width, STRIDES, self.workspace, self.counters,
        )  # fmt: skip
        self.tests += 1
        if outcome != CONTACT:
            return None
        self.state[PART] = part
        touch = self._earlier(None)
        if not self.lasting.on([x.primitive]).is_held_near(window, touch.hi, touch.point, NEAR):
            return None
        corner = any(kind == "corner" for kind, _ in touch.features)  # of the cover
        return replace(touch, features=() if corner else touch.features, alone=False)

    def _first_of(
        self, groups: Sequence[tuple[_Group, float]], left: list[Open], window: Window, width: float,
        best: Touch | None = None,
    ) -> tuple[Touch | None, float | None]:  # fmt: skip
        """(the first proved contact, a time until which all is free where the budget ended); what is open is added.

        best: what is proved of others."""
        for group, free_until in groups:
            limit = window.last if best is None else best.hi
            begin = max(free_until, window.first)
            if begin > limit:
                break
            if self.progress is not None:
                self.progress(begin, int(self.state[0]) + self.tests)
            stop = self._stop(group, window, begin, limit, width)
            if stop is None:
                continue
            if stop.spent:
                return best, begin if best is None else min(begin, best.lo)
            touch = self._touch(group, stop, window, width)
            if touch is None:
                left += group.opened(stop.lo)
            else:
                best = touch if best is None else _first(best, touch)
        return best, None

    def _touch(self, group: _Group, stop: _Stop, window: Window, width: float) -> Touch | None:
        """The contact in a slab, if one of the triangles is proved to hold a point of the model soon after."""
        instant = PlacedForms(group.tables, window, stop.search.scratch)
        found = events_in(stop.search.bodies, instant, stop.boxes, stop.lo, stop.lo + 0.98 * width)
        lasting = self.lasting.on(group.triangles)
        for event in found:
            where = _place(instant, event)
            for share in SHARES:
                at = min(stop.lo + share * width, window.inner)
                if at >= stop.lo and lasting.is_held_near(window, at, where, NEAR):
                    return self._named(group, instant, stop, window, at, event, where)
        return None

    def _named(
        self, group: _Group, instant: PlacedForms, stop: _Stop, window: Window, at: float,
        event: SharedEvent, where: np.ndarray,
    ) -> Touch:  # fmt: skip
        """The contact proved at `at` near an event."""
        time = min(max(event.time, stop.lo), at)
        instant.place(time, time)
        poses = instant.poses()
        pose = poses[1 if self.mesh_is_a else 0]
        inverse = np.linalg.inv(pose[:, :3])
        frame = [*pose[:, :3].ravel().tolist(), *pose[:, 3].tolist()], [*inverse.ravel().tolist(), 0.0, 0.0, 0.0]
        mine, theirs = (event.own, event.other) if (event.side == 0) == self.mesh_is_a else (event.other, event.own)
        primitive, corner, sides = group.primitive(self.mesh, mine)
        ours = poses if self.mesh_is_a else poses[::-1]
        alone = not stop.search._is_spread(stop.boxes) and self._is_clear(
            self.mesh.vertices[self._corners(mine, primitive)], theirs, where, ours
        )
        n = self._normal(mine, theirs, where, ours)
        if n is not None:
            n = self._toward_model(n, self.approach(window, time, where))
        kind = type(theirs).__name__.lower(), theirs.index
        return Touch(stop.lo, at, time, where, n, primitive, corner, sides, (kind,), frame, alone)

    def _corners(self, feature: Face | Edge | Vertex, triangle: int) -> Sequence[int] | np.ndarray:
        """The vertices of a vertex, an edge, or a face that is this triangle."""
        if isinstance(feature, Vertex):
            return [feature.index]
        rows = self.mesh.segments if isinstance(feature, Edge) else self.mesh.triangles
        corners: np.ndarray = rows[feature.index if isinstance(feature, Edge) else triangle]
        return corners

    def _is_clear(
        self, corners: np.ndarray, theirs: Face | Edge | Vertex, where: np.ndarray, poses: Sequence[np.ndarray]
    ) -> bool:
        """Whether the place is clear of what borders the two features, so that no other event may be there.

        corners: of the polyhedron's feature; poses: of the polyhedron and of the model.
        """
        x, y = (np.linalg.solve(pose[:, :3], where - pose[:, 3]) for pose in poses)
        if len(near_surfaces(self.model, tuple(y.tolist()))) > len(theirs.surfaces):
            return False
        weights, *_ = np.linalg.lstsq(np.vstack([corners.T, np.ones(len(corners))]), np.append(x, 1.0), rcond=None)
        return bool(weights.min() > BESIDE)

    def oriented(self, n: np.ndarray, window: Window, t: float, place: np.ndarray) -> np.ndarray | None:
        """The normal as it points from the polyhedron to the model; None where the bodies move across it."""
        return self._toward_model(n, self.approach(window, t, place))

    @staticmethod
    def _toward_model(n: np.ndarray, v: np.ndarray) -> np.ndarray | None:
        way = float(n @ v)
        return None if abs(way) <= GRAZING * float(np.linalg.norm(v)) else n * np.sign(way)

    def _normal(
        self, mine: Face | Edge | Vertex, theirs: Face | Edge | Vertex, where: np.ndarray, poses: Sequence[np.ndarray]
    ) -> np.ndarray | None:
        """Unit, in the world, either way; poses: of the polyhedron and of the model."""
        turn, back = poses[0][:, :3], np.linalg.inv(poses[1][:, :3])
        local = back @ (where - poses[1][:, 3])
        n: np.ndarray
        if isinstance(theirs, Face):
            n = self.model.gradient(theirs.surfaces[0], local) @ back
        elif isinstance(mine, Face):
            n = np.array(doubles((mine.carrier.matrix()[3],))[0][:3]) @ np.linalg.inv(turn)
        elif isinstance(mine, Edge) and isinstance(theirs, Edge):
            first, second = (self.model.gradient(k, local) @ back for k in crossing_surfaces(self.model, theirs))
            n = np.cross(turn @ mine.frame[:3, 0], np.cross(first, second))
        else:
            return None
        length = float(np.linalg.norm(n))
        return n / length if length > 0.0 else None


@dataclass(eq=False)
class _Group:
    triangles: tuple[int, ...]
    piece: int
    patch: Patch
    tables: Any = None

    def opened(self, free_until: float) -> list[Open]:
        return [Open(k, self.piece, free_until) for k in self.triangles]

    def primitive(self, mesh: Polyhedron, feature: Face | Edge | Vertex) -> tuple[int, int, tuple[int, ...]]:
        """(a triangle at the feature, the corner or -1, the sides) of it."""
        rows = list(self.triangles)
        if isinstance(feature, Face):
            return rows[self.patch.faces.index(feature)], -1, ()
        numbers = mesh.triangles if isinstance(feature, Vertex) else mesh.side_edge
        i, k = (int(x[0]) for x in np.nonzero(numbers[rows] == feature.index))
        return (rows[i], k, ()) if isinstance(feature, Vertex) else (rows[i], -1, (k,))


def _first(x: Touch, y: Touch) -> Touch:
    """The earlier one of two contacts."""
    first = min(x, y, key=lambda touch: touch.lo)
    hi = min(x.hi, y.hi)
    together = float(np.abs(x.point - y.point).max()) <= NEAR * float(np.abs(x.point).max())
    return replace(first, hi=hi, time=min(first.time, hi), alone=x.alone and y.alone and together)


def _place(instant: PlacedForms, event: SharedEvent) -> np.ndarray:
    """(3,) where the event is, in the world."""
    instant.place(event.time, event.time)
    pose = instant.poses()[event.side]
    place: np.ndarray = pose[:, :3] @ [to_double(c) for c in event.x] + pose[:, 3]
    return place


# -- points of every part of a model -------------------------------------------------------------------------


_ANCHORS = Kept[tuple[np.ndarray, np.ndarray]]()


def _anchors(model: CompositeQuadric) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) points, at least one on every connected part of the boundary, and (n,) how far off they may be.

    A part of the boundary has an edge or a seam, or is a whole ellipsoid.
    """
    return _ANCHORS.of(model, lambda: _find_anchors(model))


def _find_anchors(model: CompositeQuadric) -> tuple[np.ndarray, np.ndarray]:
    lo, hi = model.bounds()
    size = float(np.abs([lo, hi]).max())
    found = [(np.array(v.position), v.error + OFF * size) for v in model.vertices]
    curves = [*model.edges, *model.seams]
    for edge in curves:
        off = OFF_QUARTIC if isinstance(edge.carrier, QuarticCurve) else OFF
        closed = [p.lo for p in edge.pieces if p.start is None or p.end is None]
        found += [(x, off * size) for x in edge.points(closed)] if closed else []
    on_curves = {k for edge in curves for k in edge.surfaces}
    for face in model.faces:
        if not on_curves & set(face.surfaces):
            found.append((_on_ellipsoid(model.forms[face.surfaces[0]]), OFF * size))
    return np.array([x for x, _ in found]).reshape(-1, 3), np.array([r for _, r in found])


def _on_ellipsoid(form: np.ndarray) -> np.ndarray:
    centre = -np.linalg.solve(form[:3, :3], form[:3, 3])
    depth = form[3, 3] + form[3, :3] @ centre
    point: np.ndarray = centre + [np.sqrt(max(-depth / form[0, 0], 0.0)), 0.0, 0.0]
    return point


_FRAMES = Kept[tuple[np.ndarray, np.ndarray, np.ndarray]]()
"""Of a polyhedron's triangles corners (n, 3, 3), unit normals (n, 3) and unit vectors out across sides (n, 3, 3)."""


def _least_distance(mesh: Polyhedron, x: np.ndarray) -> float:
    """At most the distance from a point to the triangles: of their planes, and across their sides."""
    if not len(mesh.triangles):
        return np.inf
    corners, normals, outward = _FRAMES.of(mesh, lambda: _frames(mesh.vertices[mesh.triangles]))
    away = x - corners
    far = np.abs(np.einsum("nd,nd->n", normals, away[:, 0]))
    beyond = np.einsum("nsd,nsd->ns", outward, away)
    return float(np.maximum(far, beyond.max(axis=1)).min())


def _frames(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    sides = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(sides[:, 0], sides[:, 1])
    outward = np.cross(sides, normals[:, None])
    return corners, normals / _lengths(normals), outward / _lengths(outward)


def _lengths(x: np.ndarray) -> np.ndarray:
    lengths: np.ndarray = np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), 1e-300)
    return lengths
