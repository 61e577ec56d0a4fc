"""The surface of a polyhedron against convex pieces, both under any motion: certified first contact by its triangles.

Every triangle is a flat convex piece (`kernels.convex.flat`); the polyhedron's tree finds the few that matter
(`kernels.convex.mesh_walk`).  Interiors are not looked at: whether one body holds the other is a question to the start
alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.kernels.convex.advancement import (
    BY_FORMS,
    BY_VERTEX_A,
    BY_VERTEX_B,
    CONTACT,
    INITIAL,
    directed,
)
from firstcontact.kernels.convex.candidate import witness
from firstcontact.kernels.convex.flat import CORNERS, ROWS, SIDES, write_triangle
from firstcontact.kernels.convex.mesh_walk import (
    COUNT,
    FULL,
    OUTCOME,
    PART,
    PIECE,
    SLICE,
    TRIANGLE,
    VISITS,
    point_inside,
    walk,
)
from firstcontact.kernels.workspace import (
    ACTIVE,
    FREE_UNTIL,
    GAPS,
    HI,
    INVERSE_B,
    LO,
    MODE,
    NORMAL,
    OF_A,
    POINT,
    POSE_A,
    POSE_B,
    RESULTS,
    STEPS,
    TIME,
    VERTEX,
    workspace,
)
from firstcontact.kernels.workspace import COUNT as FORMS_COUNT
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.convex.advance import Feature, named
from firstcontact.search.convex.convex import ConvexPieces
from firstcontact.search.trees.frame import tree_of
from firstcontact.work import Progress, may_grow

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

STRIDES = 10_000
"""For one triangle at most."""
BACK = 1e-5
"""Part of a window by which searches in a box start before the time to which it is proved free."""
SLICE_VISITS = 20_000
BESIDE = 1e-9
"""Of the size of its terms: forms smaller than that count as 0 at a point of contact."""


@dataclass(frozen=True, slots=True)
class Touch:
    """A proved contact of a triangle with a piece: no common point before lo, one at or before hi.

    primitive: its number in the tree; corner, sides: which of its corners (-1: none) or sides (0 to 2) touch, neither
    for the face; features: (kind, index) of the touching features of the model, as `search.convex.advance` tells;
    frame: pose of the model near the time and the inverse of its linear part, twelve numbers each; point, normal: (3,),
    world frame, the normal from the polyhedron to the model; alone: whether no contact elsewhere is known to be as
    early.
    """

    lo: float
    hi: float
    time: float
    point: np.ndarray
    normal: np.ndarray | None
    primitive: int
    corner: int = -1
    sides: tuple[int, ...] = ()
    features: tuple[Feature, ...] = ()
    frame: tuple[list[float], list[float]] = ([], [])
    alone: bool = True


@dataclass(frozen=True, slots=True)
class Open:
    """A triangle and a piece that doubles do not settle: apart until `free_until` (the start: they may touch there)."""

    primitive: int
    piece: int
    free_until: float


def first_of_each(left: Iterable[Open]) -> list[Open]:
    """Of each triangle, which may be open before several pieces, what may touch first; early ones first."""
    found: dict[int, Open] = {}
    for x in sorted(left, key=lambda x: (x.free_until, x.primitive)):
        found.setdefault(x.primitive, x)
    return list(found.values())


@dataclass(slots=True)
class Swept:
    """What was proved.

    status: "free"; "contact" (`touch`); "initial": a point of the triangle `touch` lies inside a piece at the start;
    "open": `reason` "precision" (`open` may touch first) or "budget" (or memory).  free_until: no
    common point before it.
    """

    status: str
    free_until: float
    touch: Touch | None = None
    open: list[Open] = field(default_factory=list)
    reason: str | None = None
    visits: int = 0
    tests: int = 0
    gaps: int = 0


class MeshSearch:
    """The surface of `mesh` against `pieces` in windows of time; mesh_is_a: whose motion is which in them.

    budget: visits and strides of all windows together.
    """

    pieces_are_model = True
    """Whether the pieces make up the model, or only cover it."""

    def __init__(
        self,
        mesh: Polyhedron,
        pieces: ConvexPieces,
        mesh_is_a: bool,
        budget: int | None,
        progress: Progress | None = None,
    ) -> None:
        self.tree = tree_of(mesh)
        self.pieces = pieces
        self.mesh_is_a = mesh_is_a
        self.budget = math.inf if budget is None else budget
        self.progress = progress
        self.rows = np.zeros((int(ROWS), 14))
        self.workspace, self.counters = workspace()
        self.state = np.zeros(5, np.int64)
        self.keys, self.pairs = np.empty(1024), np.empty((1024, 2), np.int64)
        self.tests = 0

    def at_start(self, window: Window) -> Swept:
        """ "free" proves that the surface and the pieces share no point at the start of the window."""
        first = window.first
        return self.run(Window(first, first, first, window.a, window.b), 0.0)

    def candidates(self, window: Window, until: float) -> list[Open] | None:
        """All triangles that doubles do not prove free up to `until`; None where the budget ends before."""
        found = self.run(Window(window.first, until, window.first, window.a, window.b), 0.0)
        return None if found.reason == "budget" else found.open

    def near(self, window: Window) -> Swept:
        """ "open" with all triangles that doubles do not prove apart from the pieces all over the window, or "free"."""
        return self._run(window._replace(inner=window.first), 0.0, None, True)

    def points_of_model(self, window: Window) -> list[tuple[float, float, float] | None]:
        """In every part of the model a point, in the frame of the mesh at the start of the window, that lies on the
        same side of the mesh's surface as all of the part if that meets no part; None where none could be placed."""
        return [self.point_of_piece(j, window) for j in range(self.pieces.count)]

    def point_of_piece(self, j: int, window: Window) -> tuple[float, float, float] | None:
        """A point in the frame of the mesh proved to lie inside piece j at the start of the window."""
        mesh, model = self._motions(window)
        proved, *x = point_inside(self.rows, mesh, self.pieces.array, j, model, window.first, self.workspace)
        return tuple(x) if proved else None

    def nearest(self, x: Open, window: Window) -> np.ndarray:
        """(3,) about where in the world an open triangle is nearest to its piece when it is last proved free."""
        mesh, model = self._motions(window)
        found, least = np.zeros(3), math.inf
        for part in np.flatnonzero(self.tree.ids[:, 0] == x.primitive):
            write_triangle(self.rows, self.tree.xyz[part], self.tree.error)
            distance, *_, count, _ = directed(
                self.rows, 0, mesh, self.pieces.array, x.piece, model, x.free_until, 1.0, 0.0, 0.0,
                self.workspace, self.counters,
            )  # fmt: skip
            if distance < least:
                found, least = np.array(witness(self.workspace, count, OF_A)), distance
        return found

    def oriented(self, n: np.ndarray, window: Window, t: float, place: np.ndarray) -> np.ndarray | None:
        """A unit normal (3,) of both bodies where they touch, in the world, as it points from the mesh to the model.

        None where pieces at the place lie on both sides, or none is known to be there.
        """
        now, ways = Window(t, t, t, window.a, window.b), []
        inner = [(j, x) for j in range(self.pieces.count) if (x := self.point_of_piece(j, now)) is not None]
        if not inner:
            return None
        mesh, model = self.workspace[POSE_A], self.workspace[POSE_B]
        local = np.linalg.solve(model[:9].reshape(3, 3), place - model[9:12])
        for j, x in inner:
            off = mesh[:9].reshape(3, 3) @ x + mesh[9:12] - place
            if self.pieces.inside(j, local[None], -BESIDE, float(np.abs(off).max()))[0]:
                ways.append(float(n @ off))
        if ways and min(ways) > 0.0:
            return n
        return -n if ways and max(ways) < 0.0 else None

    def _motions(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        return (window.a, window.b) if self.mesh_is_a else (window.b, window.a)

    def run(self, window: Window, width: float, back: float | None = None) -> Swept:
        """The first contact in one window; width: of its interval at most; back: BACK of it or of a longer one."""
        return self._run(window, width, back, False)

    def _run(self, window: Window, width: float, back: float | None, inside_too: bool) -> Swept:
        """inside_too: triangles inside pieces at the start are open like others, and do not end the search."""
        mesh, model = self._motions(window)
        self._push_roots(window.first)
        # what is proved free beyond the end is proved free at it: so the end itself is looked at
        limit = math.nextafter(window.last, math.inf)
        hint = np.zeros(3)
        back = BACK * (window.last - window.first) if back is None else back
        best: Touch | None = None
        left: list[Open] = []
        while True:
            stop = min(self.state[VISITS] + SLICE_VISITS, self.budget - self.counters[STEPS])
            reason = walk(
                self.tree.boxes, self.tree.links, self.tree.error, self.tree.xyz, self.rows, mesh,
                self.pieces.array, model, limit, back, window.inner, width, STRIDES, int(max(stop, 0)),
                hint, self.keys, self.pairs, self.state, self.workspace, self.counters,
            )  # fmt: skip
            if reason == FULL:
                if not may_grow(self.keys, self.pairs):
                    return self._stopped(best, left)
                self._grow()
            elif reason == SLICE:
                work = int(self.state[VISITS] + self.counters[STEPS])
                if work >= self.budget:
                    return self._stopped(best, left)
                if self.progress is not None:
                    self.progress(float(self.keys[0]), work)
            elif reason == TRIANGLE:
                self.tests += 1
                outcome = int(self.state[OUTCOME])
                if outcome == INITIAL and not inside_too and self.workspace[RESULTS, TIME] == window.first:
                    return self._answer("initial", window.first, touch=self._inside())
                if outcome == CONTACT:
                    best = self._earlier(best)
                    limit = min(limit, best.lo)
                    hint = self.workspace[RESULTS, NORMAL : NORMAL + 3].copy()
                else:
                    left.append(self._open())
            else:
                return self._settled(window, best, left, width)

    def _push_roots(self, first: float) -> None:
        n = self.pieces.count
        while n > len(self.keys):
            self._grow()
        self.keys[:n], self.pairs[:n, 0], self.pairs[:n, 1] = first, 0, np.arange(n)
        self.state[COUNT] = n

    def _grow(self) -> None:
        self.keys = np.concatenate([self.keys, np.empty_like(self.keys)])
        self.pairs = np.concatenate([self.pairs, np.empty_like(self.pairs)])

    def _settled(self, window: Window, best: Touch | None, left: list[Open], width: float) -> Swept:
        """The answer of a window: what doubles left open matters only before the contact, by more than its width."""
        left = [x for x in left if best is None or x.free_until < best.lo]
        if best is None and not left:
            return self._answer("free", window.last)
        until = min((x.free_until for x in left), default=math.inf)
        if best is None or best.hi - min(until, best.lo) > width:
            return self._answer("open", until, open=left, touch=best, reason="precision")
        lo = min(best.lo, until)
        return self._answer("contact", lo, touch=replace(best, lo=lo))

    def _stopped(self, best: Touch | None, left: list[Open]) -> Swept:
        bounds = [float(self.keys[0]), *(x.free_until for x in left)]
        return self._answer("open", min(bounds if best is None else [*bounds, best.lo]), reason="budget")

    def _primitive(self) -> int:
        return int(self.tree.ids[self.state[PART], 0])

    def _open(self) -> Open:
        return Open(self._primitive(), int(self.state[PIECE]), float(self.workspace[RESULTS, FREE_UNTIL]))

    def _inside(self) -> Touch:
        r = self.workspace[RESULTS]
        time = float(r[TIME])
        return Touch(time, time, time, r[POINT : POINT + 3].copy(), None, self._primitive())

    def _earlier(self, best: Touch | None) -> Touch:
        """The contact just found, which begins before the best one so far."""
        r = self.workspace[RESULTS]
        lo, hi = float(r[LO]), float(r[HI])
        hi = hi if best is None else min(hi, best.hi)
        return Touch(
            lo, hi, min(float(r[TIME]), hi), r[POINT : POINT + 3].copy(), r[NORMAL : NORMAL + 3].copy(),
            self._primitive(), *self._features(),
            (self.workspace[POSE_B, :12].tolist(), self.workspace[INVERSE_B, :12].tolist()),
        )  # fmt: skip

    def _features(self) -> tuple[int, tuple[int, ...], tuple[Feature, ...]]:
        c = self.counters
        mode = c[MODE]
        if mode == BY_VERTEX_A:
            return int(c[VERTEX] - CORNERS), (), named(self.pieces, [int(c[ACTIVE])])
        n = int(c[FORMS_COUNT]) if mode == BY_FORMS else 1
        sides = tuple(sorted(int(k - SIDES) for k in c[ACTIVE : ACTIVE + n].tolist() if SIDES <= k < SIDES + 3))
        if mode == BY_VERTEX_B:
            return -1, sides, (("corner", int(c[VERTEX])),)
        m = int(c[FORMS_COUNT + 1])
        return -1, sides, named(self.pieces, c[ACTIVE + n : ACTIVE + n + m].tolist())

    def _answer(self, status: str, free_until: float, **fields: Any) -> Swept:
        return Swept(
            status, free_until,
            visits=int(self.state[VISITS]), tests=self.tests, gaps=int(self.counters[GAPS]), **fields,
        )  # fmt: skip
