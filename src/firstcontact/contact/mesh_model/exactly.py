"""All times of contact of a polyhedron of any shape and a curved model in exact arithmetic, under rational motions.

The triangles that come near the model are one thin model.  Its candidates (`contact.models.algorithm`) are all times at
which the surface of the polyhedron may begin or end to share a point with the model; between two of them it does all
the time or never, and where it does not, parity tells whether the polyhedron holds the model.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.mesh_model.by_triangles import holds_model, windows_of
from firstcontact.contact.mesh_model.mesh_holes import search_of
from firstcontact.contact.mesh_model.mesh_starts import Standing
from firstcontact.contact.mesh_model.patches import patch
from firstcontact.contact.models.algorithm import Candidate, CandidateSearch
from firstcontact.contact.models.answer import world_time
from firstcontact.contact.models.at_rest import pose_at
from firstcontact.contact.models.certified import bounded
from firstcontact.contact.models.exact_windows import decided_intervals
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import below, exact_value
from firstcontact.exact.rigid import inverse_map
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.relative.stretches import Window
from firstcontact.result import ContactIntervals
from firstcontact.search.convex.mesh_advance import MeshSearch
from firstcontact.search.convex.relation import Relation
from firstcontact.work import Query, Spent, Work

MOST = 64
"""Triangles, bare edges and points that come near the model."""
LOOK = 200
"""Candidates that take as long as a look at a triangle that doubles do not tell from the model."""


def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact of a Polyhedron and a CompositeQuadric, in either order; exact.

    Candidates and looks between them count as work.  Raises UnsupportedPair.
    """
    work = query.work()
    return decided_intervals(query, _searches(query, work), work, query.span[0])


@dataclass
class _Bodies:
    """The polyhedron, the model, the surface search that places points of the model, and the windows of the motion."""

    mesh: Polyhedron
    model: CompositeQuadric
    near: list[int]
    search: MeshSearch
    windows: list[Window]
    mesh_is_a: bool


@dataclass
class _MeshSearch(CandidateSearch):
    """Between two candidates the surfaces share a point all the time or never."""

    bodies: _Bodies | None = None

    def share_a_point(self, u: fmpq, passed: list[Candidate] | None = None) -> bool | None:
        if passed is not None and self.are_no_contacts(passed):
            return True
        assert self.bodies is not None
        near = self._near_at(u)
        lasting = near is None or (bool(near) and self.are_lasting(u))
        if lasting:
            return True
        apart = not near or self._are_apart(near, u)
        if apart is None:
            return True
        if lasting is None:
            return None
        if apart and not self.bodies.mesh.solid:
            return False
        now = self._window_at(u)
        if now is None or not (apart or self.bodies.search.at_start(now).status == "free"):
            return None
        return holds_model(self.bodies.search, self.bodies.mesh, now)

    def _near_at(self, u: fmpq) -> list[int] | None:
        """The primitives that doubles do not prove apart from the model then; None where they prove that one shares a
        point with it at a time of which the same is true."""
        assert self.bodies is not None
        lo, hi = world_time(self.pair, AlgebraicRoot.of(u))[1]
        window = next((w for w in self.bodies.windows if w.first <= lo and hi <= w.last), None)
        if window is None:
            return self.bodies.near
        seen = self.bodies.search.near(window._replace(first=lo, last=hi))
        if seen.reason == "budget":
            return self.bodies.near
        left = {x.primitive for x in seen.open}
        now = self._window_at(u) if left and self.bodies.search.pieces_are_model else None
        if now is not None and self.bodies.search.at_start(now).status in ("initial", "contact"):
            return None
        return [k for k in self.bodies.near if k in left]

    def _are_apart(self, near: list[int], u: fmpq) -> bool | None:
        """Whether all of these are proved apart from the model; None where one of them shares a point with it."""
        assert self.bodies is not None
        pose = pose_at(self.pair, u)
        standing = Standing.posed(
            self.bodies.mesh, self.bodies.model, pose if self.bodies.mesh_is_a else inverse_map(pose)
        )
        apart = True
        for k in near:
            self.work.step(LOOK)
            place = standing.primitive(k)
            if place.point is not None:
                return None
            apart &= place.relation is Relation.APART
        return apart

    def _window_at(self, u: fmpq) -> Window | None:
        """The window at the double that stands for u; None where a candidate lies between the two."""
        assert self.bodies is not None
        t = world_time(self.pair, AlgebraicRoot.of(u))[0]
        clock, time = self.pair.piece.clock, exact_value(t)
        for candidate in self.candidates:
            if (candidate.root.compare(u) > 0) is not (clock.compare(candidate.root, time) > 0):
                return None
        window = next((w for w in self.bodies.windows if w.first <= t <= w.last), None)
        return None if window is None else window._replace(first=t, last=t, inner=t)


def _searches(query: Query, work: Work) -> Iterator[CandidateSearch]:
    """One for every piece of the relative motion."""
    a, b = query.bodies
    mesh_is_a = isinstance(shape_of(a), Polyhedron)
    moving_mesh, moving_model = (a, b) if mesh_is_a else (b, a)
    mesh, model = shape_of(moving_mesh), shape_of(bounded(moving_model, moving_mesh, query.span))
    windows = windows_of(a, b, query.first, query.end)
    search = search_of(mesh, model, mesh_is_a, query.budget)
    near = _near(search, windows, query) or [0]
    if len(near) > MOST:
        raise UnsupportedPair(
            f"{a!r} and {b!r}: {len(near)} triangles come near the solid, too many for exact contact intervals; "
            "drop exact=True and method='algebraic'"
        )
    bodies = _Bodies(mesh, model, near, search, windows, mesh_is_a)
    thin: Any = patch(mesh, near, (0.0, 0.0, 0.0))
    for piece in relative_pieces(a, b, query.first, query.end):
        if not piece.exact:
            raise UnsupportedPair(f"{piece.of}: the pose before this step is irrational")
        work.free_until = below(piece.start)
        first_model, second_model = (thin, model) if mesh_is_a else (model, thin)
        yield _MeshSearch(MovingPair(first_model, second_model, piece), work, bodies=bodies)


def _near(search: MeshSearch, windows: list[Window], query: Query) -> list[int]:
    """All primitives that doubles do not prove apart from the model all the time."""
    found: set[int] = set()
    for window in windows:
        swept = search.near(window)
        if swept.reason == "budget":  # some may be missing
            raise Spent if query.budget is not None else UnsupportedPair("too many triangles come near the solid")
        found |= {x.primitive for x in swept.open}
    return sorted(found)
