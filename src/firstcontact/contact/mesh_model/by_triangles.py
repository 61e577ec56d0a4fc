"""First contact of a polyhedron of any shape with a curved model.

The polyhedron goes by its triangles (`search.convex.mesh_advance`, or `mesh_holes` for models that are no unions of
convex parts) and by parity: at the start, and wherever a motion may jump, a point of each part of the model tells
whether the polyhedron holds it.  Exact arithmetic takes the few triangles that doubles do not settle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid import primitives
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.mesh_model.mesh_holes import search_of
from firstcontact.contact.mesh_model.mesh_starts import Standing
from firstcontact.contact.mesh_model.patches import (
    Patch,
    bare_primitive,
    has_area,
    is_sharp_edge,
    is_sharp_vertex,
    patch,
    prisms,
    triangles_at_edge,
    triangles_at_vertex,
)
from firstcontact.contact.models.algorithm import CandidateSearch, Meeting
from firstcontact.contact.models.answer import contact_of
from firstcontact.contact.models.at_rest import overlap
from firstcontact.contact.models.certified import Directions, bounded, may_share_more, on_model
from firstcontact.contact.models.idle_turns import ignoring_idle_turns
from firstcontact.contact.models.last_instant import is_kept, near_pose
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.shared.touched import ACROSS
from firstcontact.contact.ways import Passed, Way, answered, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import above, exact_value, fraction
from firstcontact.exact.rigid import IDENTITY, apply
from firstcontact.kernels.convex.mesh_walk import VISITS
from firstcontact.motion.moving import Moving, pose_of, shape_of
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.relative.stretches import Untold, Window, windows
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.result import ContactSet, Element, FirstContact, Stats, Status
from firstcontact.search.convex.mesh_advance import MeshSearch, Open, Swept, Touch, first_of_each
from firstcontact.search.convex.relation import Relation
from firstcontact.search.trees.containment import component_labels, contains
from firstcontact.search.trees.frame import tree_of
from firstcontact.work import Query, Spent

if TYPE_CHECKING:
    from typing import Unpack

    from firstcontact.body.kinds import Body
    from firstcontact.motion.relative.polynomial import PolynomialPiece
    from firstcontact.result import ContactFields

MOST_PRISMS = 16
"""Triangles looked at one by one to tell touching from overlapping."""


@ignoring_idle_turns
def first(query: Query) -> FirstContact:
    """The first contact of a Polyhedron and a CompositeQuadric, in either order, at rest or moving.

    exact, or method "algebraic": the time is recomputed exactly among the triangles that doubles leave.  Visits and
    strides count as work, and the steps of exact searches.  Raises UnsupportedPair.
    """
    return answered([Way("by triangles", lambda query, _: _Answer(query).answer())], query)


@ignoring_idle_turns
def first_in_doubles(query: Query) -> FirstContact:
    """As `first`, UNDECIDED where exact arithmetic would be asked."""
    return _Answer(query, in_doubles=True).answer()


def lands(query: Query) -> bool:
    """Whether bodies that are free up to the last instant are proved to touch then, whatever their poses."""
    answer = _Answer(query)
    answer.answer()
    return answer.lands


def windows_of(a: Body, b: Body, first: fmpq, last: fmpq) -> list[Window]:
    try:
        return windows(a, b, first, last)
    except Untold as reason:
        raise UnsupportedPair(f"this motion is not followed: {reason}") from reason


def holds_model(search: MeshSearch, mesh: Polyhedron, window: Window) -> bool | None:
    """Whether the solid polyhedron holds a point of the model at the window's start, where no surfaces meet.

    None where points of some parts of the model could not be placed.
    """
    if not mesh.solid:
        return False
    placed = search.points_of_model(window)
    for x in placed:
        if x is not None:
            p, q, r = (exact_value(c) for c in x)
            if contains(mesh, search.tree, (p, q, r)):
                return True
    return None if None in placed else False


class _Answer:
    """The way to an answer: what all its steps read."""

    def __init__(self, query: Query, in_doubles: bool = False) -> None:
        self.query, self.exact, self.work, self.in_doubles = query, query.is_algebraic, query.work(), in_doubles
        self.a, self.b, self.first, self.last = query.a, query.b, query.first, query.end
        self.span, self.shared = query.span, query.shared
        self.mesh_is_a = isinstance(shape_of(self.a), Polyhedron)
        moving_mesh, moving_model = (self.a, self.b) if self.mesh_is_a else (self.b, self.a)
        self.moving_mesh = moving_mesh
        self.mesh: Polyhedron = shape_of(moving_mesh)
        self.moving_model = bounded(moving_model, moving_mesh, self.span)
        self.model: CompositeQuadric = shape_of(self.moving_model)
        self.windows = windows_of(self.a, self.b, self.first, self.last)
        self.search = search_of(self.mesh, self.model, self.mesh_is_a, query.budget, query.progress)
        self.width = query.tolerance * (self.windows[-1].last - self.windows[0].first)
        self.is_placed = True
        """Whether it is known at the start which parts of the model the mesh holds."""
        self.lands = False
        """Whether the answer is a contact of the last instant alone."""

    def answer(self) -> FirstContact:
        for k, window in enumerate(self.windows):
            found = self._in_window(window, k == 0)
            if found is not None:
                return found
        return self._result(Status.FREE, free_until=self.span[1])

    def _in_window(self, window: Window, at_start: bool) -> FirstContact | None:
        """The answer if there is one in this window; None proves it free."""
        held = holds_model(self.search, self.mesh, window)
        swept = Swept("initial", window.first) if held else self.search.run(window, self.width)
        if swept.status == "initial":
            return self._initial(window) if at_start else self._jump(window)
        if held is None:
            return self._unless_placed(window, swept, at_start)
        if swept.reason == "budget":
            return self._undecided(swept.free_until, "budget")
        if swept.status == "contact" and not self.exact:
            return self._contact(swept)
        if swept.status == "free":
            return None
        if self.in_doubles:
            return self._undecided(swept.free_until, "precision")
        try:
            found = tried(lambda: self._decided(window, swept, at_start))
            landed = tried(lambda: self._landed(window, swept)) if isinstance(found, Passed) else None
        except Spent:
            return self._undecided(swept.free_until, "budget")
        if not isinstance(found, Passed):
            return found
        if self.exact:
            raise UnsupportedPair(found.reason)
        if isinstance(landed, FirstContact):
            return landed
        return self._undecided(swept.free_until, "precision")

    def _unless_placed(self, window: Window, swept: Swept, at_start: bool) -> FirstContact:
        """The answer where doubles do not tell whether the mesh holds all of a part of the model.

        What they share at the start may be told then, if not in what manner; nothing later.
        """
        self.is_placed = False
        near = [x for x in swept.open if x.free_until <= window.first]
        if at_start and near and not self.in_doubles:
            found = tried(lambda: self._start(near, window))
            if isinstance(found, FirstContact) and found.status is Status.INITIAL_CONTACT:
                return found
        return self._undecided(window.first, "precision")

    def _result(self, status: Status, **fields: Unpack[ContactFields]) -> FirstContact:
        return FirstContact(status, stats=self._stats(), **fields, **self.shared)

    def _stats(self) -> Stats:
        return self.query.stats(int(self.search.state[VISITS]), self.search.tests, self.work.done)

    def _undecided(self, free_until: float, reason: str | None) -> FirstContact:
        return self._result(Status.UNDECIDED, free_until=max(free_until, self.span[0]), reason=reason)

    # -- interiors ------------------------------------------------------------------------------------------

    def _jump(self, window: Window) -> FirstContact:
        """The bodies share a point right at the start of a later step, and none before."""
        t = window.first
        hi = self.windows[self.windows.index(window) - 1].last  # the same time, rounded up
        return self._result(Status.CONTACT, time=t, time_interval=(t, hi), free_until=t)

    def _initial(self, window: Window) -> FirstContact:
        """A start in which interiors overlap."""
        start = self.search.at_start(window)
        fields: ContactFields = {} if start.touch is None else {"point": start.touch.point}
        return self._at_start(self._kind(start, window), **fields)

    def _at_start(self, kind: str | None, **fields: Any) -> FirstContact:
        t = self.span[0]
        return self._result(
            Status.INITIAL_CONTACT, time=t, time_interval=(t, t), initial=kind, free_until=t,
            time_exact=fraction(self.first) if self.exact else None, **fields
        )

    def _kind(self, start: Swept, window: Window) -> str | None:
        """ "containment" or "overlapping" for bodies whose interiors share a point; None where neither is proved."""
        if start.status == "free":
            return "containment"
        if start.touch is None:  # surfaces may touch, and no more
            return "overlapping" if self._touching(start.open, window) is not None else None
        k = start.touch.primitive
        if k >= len(self.mesh.triangles) and bare_primitive(self.mesh, k)[0] is None:
            return "containment"  # a point
        # a point of this triangle lies inside the model: so does its component, or it crosses the surface
        component = component_labels(self.mesh)
        ours = component == component[self._corner(start.touch)]
        x, slack = self._vertices_at(window)
        for some in (x[ours][::64], x[ours]):  # most starts are settled by a few of the vertices
            if not np.all(self.model._possible(some, slack)[0]):
                return "overlapping"
        if self.search.pieces_are_model:
            pieces = self.search.pieces
            inside = np.array([pieces.inside(j, x, slack) for j in range(pieces.count)])
            bare = self.mesh.segments[self.mesh.bare_edges()]
            groups = [x[ours[x[:, 0]]] for x in (self.mesh.triangles, bare)]
            # each with all corners in one part
            if any(map(len, groups)) and all(np.all(np.any(np.all(inside[:, x], axis=2), axis=0)) for x in groups):
                return "containment"
            ours = ours & ~np.any(inside, axis=0)
        return "overlapping" if self._reaches_surface(ours) else self._kind_by_surroundings(window)

    def _reaches_surface(self, ours: np.ndarray) -> bool:
        """Whether one of some of these vertices is outside of the model, or on its surface; True is proved."""
        standing = Standing(self.moving_mesh, self.moving_model, self.first)
        if standing.relative is None:
            return False
        some = np.flatnonzero(ours)[:MOST_PRISMS].tolist()
        return any(self.model.is_next_to_outside(apply(standing.relative, self.mesh.exact_vertex(v))) for v in some)

    def _kind_by_surroundings(self, window: Window) -> str | None:
        """As `_kind`, where the polyhedron's surface meets the material: what it shares with all around that tells."""
        lo, hi = self.model.bounds()
        room = primitives.box(((hi - lo) * 2).tolist()).translated(((lo + hi) / 2).tolist())
        around = tried(
            lambda: search_of(self.mesh, room - self.model, self.mesh_is_a, self.query.budget, self.query.progress)
        )
        if isinstance(around, Passed):
            return None
        start = around.at_start(window)
        if start.status == "free":  # what the polyhedron holds of it then is a cavity in the material
            held = holds_model(around, self.mesh, window)
            return None if held is None else "overlapping" if held else "containment"
        return None if start.touch is None else "overlapping"

    def _corner(self, touch: Touch) -> int:
        return int(tree_of(self.mesh).corners[touch.primitive, 0])

    def _vertices_at(self, window: Window) -> tuple[np.ndarray, float]:
        """(n, 3) vertices in the frame of the model at the start of the window; their error as a part of sizes."""
        t = window.first
        bodies = (self.a, self.b) if self.mesh_is_a else (self.b, self.a)
        mesh_pose, model_pose = (pose_of(x, t) for x in bodies)
        pose = np.linalg.solve(model_pose, mesh_pose)
        x = self.mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        size = float(np.abs(self.mesh.vertices).max() * np.abs(pose[:3, :3]).max() + np.abs(pose[:3, 3]).max())
        error = 4.0 * self.mesh.error + 1e-13 * (size + float(np.abs(model_pose[:3, 3]).max()))
        return x, 1e-12 + 64.0 * error / (float(np.abs(x).max()) + 1e-300)

    # -- contacts that doubles prove ------------------------------------------------------------------------

    def _contact(self, swept: Swept) -> FirstContact:
        touch = swept.touch
        assert touch is not None
        if touch.normal is None:
            return self._result(
                Status.CONTACT, time=touch.time, time_interval=(touch.lo, touch.hi), point=touch.point,
                free_until=touch.lo,
            )  # fmt: skip
        normal = -touch.normal if self.mesh_is_a else touch.normal
        mesh_element, mesh_flats = self._on_mesh(touch, "a" if self.mesh_is_a else "b")
        elements: list[Element | None] = [mesh_element, None]
        contact_set = None
        if touch.features:
            place, which = (touch.point, normal), "b" if self.mesh_is_a else "a"
            elements[1], flats = on_model(self.moving_model, touch.features, place, touch.frame, which)
            if touch.alone and not may_share_more(mesh_flats, flats):
                contact_set = ContactSet("point", touch.point[None])
        first, second = elements if self.mesh_is_a else elements[::-1]
        return self._result(
            Status.CONTACT, time=touch.time, time_interval=(touch.lo, touch.hi), point=touch.point, normal=normal,
            element_a=first, element_b=second, multiplicity=1, contact_set=contact_set, free_until=touch.lo,
        )  # fmt: skip

    def _on_mesh(self, touch: Touch, which: str) -> tuple[Element, Directions]:
        """The touching element of the polyhedron, and what is flat there."""
        mesh, tree = self.mesh, tree_of(self.mesh)
        name = mesh.name or which
        corner, sides = self._sharp_corner(touch), tree.sides[touch.primitive]
        if corner is not None:
            around = triangles_at_vertex(mesh, corner)
            at = [int(e) for e in np.unique(mesh.side_edge[around]) if corner in mesh.segments[e]]
            return Element("vertex", name, corner, name), self._flats(around.tolist(), at, touch)
        bare = touch.primitive >= len(mesh.triangles)
        for s in (0,) if bare else touch.sides:
            e = int(sides[s])
            if is_sharp_edge(mesh, e):
                around = triangles_at_edge(mesh, e)
                return Element("edge", name, e, name), self._flats(around.tolist(), [e], touch)
        polygon = int(mesh.triangle_face[touch.primitive])
        return Element("face", name, polygon, name), self._flats([touch.primitive], [], touch)

    def _sharp_corner(self, touch: Touch) -> int | None:
        """The vertex that touches, if one does and its triangles do not lie in one plane."""
        corners, sides = tree_of(self.mesh).corners[touch.primitive], tree_of(self.mesh).sides[touch.primitive]
        if sides[0] >= len(self.mesh.segments):  # a bare point
            return int(corners[0])
        k = touch.corner
        if k < 0 and len(touch.sides) == 2 and touch.primitive < len(self.mesh.triangles):
            k = {(0, 1): 1, (1, 2): 2, (0, 2): 0}[touch.sides]
        return int(corners[k]) if k >= 0 and is_sharp_vertex(self.mesh, int(corners[k])) else None

    def _flats(self, triangles: list[int], edges: list[int], touch: Touch) -> Directions:
        """Planes of triangles and edges across the normal."""
        mover = self.a if self.mesh_is_a else self.b
        turn = pose_of(mover, touch.time)[:3, :3]
        n = touch.normal
        found: list[tuple[None, Any]] = []
        for k in triangles:
            x = self.mesh.vertices[self.mesh.triangles[k]] @ turn.T
            sides = np.array([x[1] - x[0], x[2] - x[1]])
            if np.all(np.abs(sides @ n) <= ACROSS * np.linalg.norm(sides, axis=1)):
                found.append((None, None))
                break
        for e in edges:
            i, j = self.mesh.segments[e]
            d = turn @ (self.mesh.vertices[j] - self.mesh.vertices[i])
            if abs(d @ n) <= ACROSS * np.linalg.norm(d):
                found.append((None, tuple(d.tolist())))
        return found

    # -- what exact arithmetic decides ----------------------------------------------------------------------

    def _decided(self, window: Window, swept: Swept, at_start: bool) -> FirstContact | None:
        """The answer where doubles leave triangles open, or where the exact time is wanted; None proves it free."""
        left = swept.open
        if self.exact:
            found_left = self.search.candidates(window, window.last if swept.touch is None else swept.touch.hi)
            if found_left is None:
                raise Spent
            left = found_left
        if at_start and any(x.free_until <= window.first for x in left):
            start = self._start(left, window)
            if start is not None:
                return start
        if self.exact:
            left = self._earliest(left, window)
        all_found: list[FirstContact] = []
        for group in self._groups(left):
            if self._is_later(group, all_found):
                break
            for search in self._searches(group, window):
                meetings = search.first()
                if meetings:
                    all_found.append(contact_of(search, meetings, self.exact, self.shared))
                    break
                if search.stop() is not None:
                    return self._undecided(swept.free_until, "precision")
        touch, nearest = swept.touch, min(all_found, key=_time, default=None)
        if nearest is not None and any(_is_elsewhere(x, nearest) for x in all_found):
            nearest = replace(nearest, contact_set=None)
        if nearest is not None and (touch is None or _time(nearest) <= touch.hi):
            return replace(self._oriented(nearest, window), stats=self._stats())
        if touch is None:
            return None
        if self.exact:  # doubles prove a contact that exact arithmetic does not see
            return self._undecided(swept.free_until, "precision")
        return self._contact(replace(swept, free_until=touch.lo))

    def _landed(self, window: Window, swept: Swept) -> FirstContact | None:
        """CONTACT where all is free up to the last instant, and a triangle is proved to touch in the poses of then."""
        if window is not self.windows[-1] or self.span[1] - swept.free_until > self.width or self.first == self.last:
            return None
        standing = [_standing(x, self.last) for x in (self.a, self.b)]
        motions = [x[1] for x in standing if x is not None and x[1] is not None]
        if standing[0] is None or standing[1] is None or len(motions) > 1:
            return None
        a, b = standing[0][0], standing[1][0]
        for group in self._groups(swept.open):
            thin: Any = self._patch(group, window)
            for piece in relative_pieces(a, b, fmpq(0), fmpq(0)):
                pair = MovingPair(thin, self.model, piece) if self.mesh_is_a else MovingPair(self.model, thin, piece)
                search = CandidateSearch(pair, self.work)
                touching = search.at_start() or ()
                if meetings := [m for m in touching if all(is_kept(pair, m, motion) for motion in motions)]:
                    seen = contact_of(search, meetings, False, {**self.shared, "a": a, "b": b})
                    until, self.lands = swept.free_until, True
                    seen = replace(
                        seen, time=self.span[1], time_interval=(until, above(self.last)), free_until=until,
                        stats=self._stats(), **self.shared,
                    )  # fmt: skip
                    return self._oriented(seen, window)
        return None

    def _is_later(self, group: list[Open], found: list[FirstContact]) -> bool:
        """Whether all of the group is free beyond the first contact found."""
        first = min((x.time_interval[1] for x in found if x.time_interval is not None), default=math.inf)
        return min(x.free_until for x in group) > first

    def _oriented(self, found: FirstContact, window: Window) -> FirstContact:
        """With the normal towards a: a triangle does not tell on which side of it the model lies, and that changes."""
        n, place, t = found.normal, found.point, found.time
        if n is None or place is None or t is None:
            return found
        n = self.search.oriented(n, window, t, place)
        return replace(found, normal=None if n is None else -n if self.mesh_is_a else n)

    def _groups(self, left: list[Open]) -> list[list[Open]]:
        """What is decided together: all for a complete answer, else triangle by triangle, early ones first."""
        if self.exact:
            return [sorted(left, key=lambda x: x.free_until)] if left else []
        return [[x] for x in first_of_each(left)]

    def _earliest(self, left: list[Open], window: Window) -> list[Open]:
        """The triangles that touch first, each looked at alone, and those that exact arithmetic leaves open."""
        seen: list[tuple[float, float, Open]] = []
        for x in left:
            for search in self._searches([x], window):
                if meetings := search.first():
                    seen.append((*contact_of(search, meetings, False, self.shared).time_interval, x))  # type: ignore[misc]
                    break
                if search.stop() is not None:
                    seen.append((-math.inf, math.inf, x))
                    break
        first = min((hi for _, hi, _ in seen), default=math.inf)
        return [x for lo, _, x in seen if lo <= first]

    def _searches(self, group: list[Open], window: Window, only_start: bool = False) -> Iterator[CandidateSearch]:
        """The exact searches over the pieces of the relative motion in the window."""
        thin: Any = self._patch(group, window)
        first = max(self.first, fmpq(*window.first.as_integer_ratio()))
        last = first if only_start else min(self.last, fmpq(*window.last.as_integer_ratio()))
        bodies: tuple[Body, Body] = (self.a, self.b)
        if only_start:  # poses may be rational where equations, as of screws, are not
            standing = [x[0] for x in (_standing(x, self.first) for x in bodies) if x is not None and x[1] is None]
            if len(standing) == 2:
                bodies, first, last = (standing[0], standing[1]), fmpq(0), fmpq(0)
        for piece in relative_pieces(*bodies, first, last):
            if not piece.exact:
                raise UnsupportedPair(f"{piece.of}: the pose before this step is irrational")
            first_model, second_model = (thin, self.model) if self.mesh_is_a else (self.model, thin)
            yield CandidateSearch(MovingPair(first_model, second_model, piece), self.work)

    def _patch(self, group: list[Open], window: Window) -> Patch:
        primitives = {x.primitive for x in group}
        outward = (0.0, 0.0, 0.0)
        if min(primitives) < len(self.mesh.triangles):
            outward = self._side_of_model(group[0], window)
        return patch(self.mesh, primitives, outward)

    def _side_of_model(self, x: Open, window: Window) -> tuple[float, float, float]:
        """A point in the frame of the polyhedron near the middle of the part of the model, at the window's start."""
        placed = self.search.point_of_piece(x.piece, window)
        if placed is None:
            raise UnsupportedPair("a part of the model is too small for doubles")
        return placed

    def _touching(self, left: list[Open], window: Window) -> tuple[CandidateSearch, list[Meeting]] | None:
        """The first of the triangles found to touch the model at the start, exactly."""
        for x in left:
            if x.free_until <= window.first:
                for search in self._searches([x], window, only_start=True):
                    if meetings := search.at_start():
                        return search, meetings
        return None

    def _start(self, left: list[Open], window: Window) -> FirstContact | None:
        """The answer where doubles leave open what is shared at the start; None proves that nothing is."""
        found = tried(lambda: self._touching(left, window))
        if isinstance(found, Passed):
            crossed = self._crossed(left, window)
            if crossed is None or crossed.status is Status.UNDECIDED:
                raise UnsupportedPair(found.reason)
            return crossed
        return self._crossed(left, window) if found is None else self._touching_result(*found, left)

    def _crossed(self, left: list[Open], window: Window) -> FirstContact | None:
        """The answer where a triangle that is not known to touch at the start may hold points of the model."""
        standing = Standing(self.moving_mesh, self.moving_model, self.first)
        t = window.first
        seen = {k: standing.primitive(k) for k in sorted({x.primitive for x in left if x.free_until <= t})}
        for k, place in seen.items():
            if place.relation is Relation.OVERLAPPING and place.point is not None:
                touch = Touch(t, t, t, standing.world(place.point), None, k)
                return self._at_start(self._kind(Swept("initial", t, touch), window), point=touch.point)
        for place in seen.values():
            if place.point is not None:  # shared
                kind = "touching" if self.is_placed and all(place.outside for place in seen.values()) else None
                return self._at_start(kind, point=standing.world(place.point))
        apart = all(place.relation is Relation.APART for place in seen.values())
        return None if apart else self._undecided(self.span[0], "precision")

    def _touching_result(self, search: CandidateSearch, meetings: list[Meeting], left: list[Open]) -> FirstContact:
        near = [x for x in left if x.free_until <= self.windows[0].first]
        seen = contact_of(search, meetings, False, self.shared)
        return self._at_start(
            "touching" if self.is_placed and self._interiors_apart(search, near) else None,
            point=seen.point, element_a=seen.element_a, element_b=seen.element_b, others=seen.others,
            multiplicity=seen.multiplicity, contact_set=seen.contact_set,
        )  # fmt: skip

    def _interiors_apart(self, search: CandidateSearch, near: list[Open]) -> bool:
        """Whether nothing that may touch at the start holds a point inside the model; True is proved.

        A plane that parts a triangle from a convex part has the triangle's prism on one of its two sides behind it.
        """
        seen = {x.primitive: x for x in near}
        if not search.starts_rational or len(seen) > MOST_PRISMS:
            return False
        bare = [k for k in seen if k >= len(self.mesh.triangles) or not has_area(self.mesh, k)]
        standing = Standing(self.moving_mesh, self.moving_model, self.first)
        return all(standing.primitive(k).outside for k in bare) and all(
            self._apart_on_a_side(x, search.pair.piece) for k, x in seen.items() if k not in bare
        )

    def _apart_on_a_side(self, x: Open, piece: PolynomialPiece) -> bool:
        points = [self.mesh.exact_vertex(i) for i in self.mesh.triangles[x.primitive].tolist()]
        pairs = ((solid, self.model) if self.mesh_is_a else (self.model, solid) for solid in prisms(points))
        return any(not overlap(MovingPair(*pair, piece), piece.u_lo) for pair in pairs)


def _standing(body: Body, t: fmpq) -> tuple[Moving, Rotation | Screw | None] | None:
    """(the body under a motion that keeps it in its pose at time t, None), or in one nearby, with its motion.

    None where neither is rational.
    """
    near = near_pose(body, t)
    if near is None:
        return None
    pose, motion = near
    standing: Moving = shape_of(body).moving(RationalMotion([[*(IDENTITY if pose is None else pose), (0, 0, 0, 1)]]))
    return standing, motion


def _time(found: FirstContact) -> float:
    assert found.time is not None
    return found.time


def _is_elsewhere(x: FirstContact, nearest: FirstContact) -> bool:
    """Whether another triangle touches at the same time in another place, as far as doubles tell."""
    assert nearest.time_interval is not None and x.point is not None and nearest.point is not None
    lo, hi = nearest.time_interval
    apart = float(np.abs(x.point - nearest.point).max()) > 1e-9 * (1e-300 + float(np.abs(x.point).max()))
    return apart and _time(x) <= hi + (hi - lo)
