"""One piece of curved relative motion: the walk over cells of time, and what is read from an instant of contact.

Answers for pairs of elements are exact (`rational_problem`) or enclosed (`enclosed_problem`).  The bodies stay in their
own frames; the working frame is that of body b.  The local clock is the time since the start.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.problems.by_trees import ByTrees
from firstcontact.exact.numbers import PRECISIONS, ball, to_double
from firstcontact.exact.rigid import Matrix, apply
from firstcontact.exact.times.instants import Instant
from firstcontact.exact.vectors import Vector, add, cross, dot, sub
from firstcontact.motion.relative.cells import cells_of, most_stretch
from firstcontact.motion.relative.curved import CurvedPiece, inverse, terms
from firstcontact.search.trees import (
    curve,  # noqa: F401 - the walks under this motion
    curve_windows,  # noqa: F401 - the walks under this motion
)
from firstcontact.search.trees.containment import decide
from firstcontact.search.trees.elements import EDGE, FACE, VERTEX, Feature, Primitive, corners_of
from firstcontact.search.trees.frame import tree_of
from firstcontact.search.trees.state import CURVED_SLICE, VISITS, WalkState
from firstcontact.search.trees.touch import Touch, doubles, spanning, unit_against
from firstcontact.search.trees.tree import Tree
from firstcontact.search.trees.windows import VISITS as COLLECTED

At = TypeVar("At", bound=Instant)
# Two elements by their exact corners: one, two or three of each.
Corners = tuple[list[Vector], list[Vector]]
# Names of the sides and corners of a primitive, and its own.
Ids = tuple[list[Hashable], list[Hashable], Hashable]


class CurvedProblem(ByTrees, Generic[At]):
    """Body a moves by the piece's pose, body b rests; both in the frames they are given in."""

    begin = 0.0, 0.0
    looks = 0
    most_looks: int | None = None

    def __init__(self, a: Polyhedron, b: Polyhedron, piece: CurvedPiece) -> None:
        self.a, self.b, self.piece = a, b, piece
        self.is_exact = a.irrational_pose is None and b.irrational_pose is None
        self.tree_a, self.tree_b = tree_of(a), tree_of(b)
        self.boxes_a, self.boxes_b = self.tree_a.boxes, self.tree_b.boxes
        self.error_a, self.error_b = self.tree_a.error, self.tree_b.error
        sizes = [float(np.abs(tree.boxes[0]).max()) for tree in (self.tree_a, self.tree_b)]
        self.motion = cells_of(piece, *sizes)
        self.length = piece.end - piece.start
        errors = self.error_a + self.error_b
        self.pad = 4.0 * (1.0 + most_stretch(self.motion)) * errors if errors else 0.0

    def window(self) -> tuple[float, float]:
        """(last, sure last): outward and inward doubles around the end of the window."""
        last = to_double(self.length)
        if fmpq(*last.as_integer_ratio()) == self.length:
            return last, last
        return math.nextafter(last, math.inf), math.nextafter(last, -math.inf)

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back.  The start is another problem's (`problem`)."""
        return self.advance_boxes(state, min(limit, int(state.integers[VISITS]) + CURVED_SLICE), False, all_sides)

    def contact(self, element_a: Feature, element_b: Feature) -> At | None:
        """The earliest time of the window at which the two elements share a point."""
        raise NotImplementedError

    def contact_within(self, element_a: Feature, element_b: Feature, lo: float, hi: float) -> At | None:
        """The same, of two elements of which floats have proved that they meet in [lo, hi]."""
        return self.contact(element_a, element_b)

    def meets_by(self, element_a: Feature, element_b: Feature, after: float) -> float | None:
        """A time soon after that one by which the bodies certainly share a point; None where none is known."""
        return None

    # -- all windows ----------------------------------------------------------------------------------------

    def collect(
        self, limit: int, integers: np.ndarray, stack: np.ndarray, cover: np.ndarray, times: np.ndarray,
        parts: np.ndarray,
    ) -> int:  # fmt: skip
        """Go on collecting windows, less far at a time than others (`windows.collect`)."""
        limit = min(limit, int(integers[COLLECTED]) + CURVED_SLICE)
        return super().collect(limit, integers, stack, cover, times, parts)

    def windows_of(self, primitive_a: int, primitive_b: int) -> list[tuple[At, At]]:
        """The windows of contact of two primitives: between two consecutive events nothing changes."""
        a, b = Primitive(self.a, self.tree_a, primitive_a), Primitive(self.b, self.tree_b, primitive_b)
        windows: list[tuple[At, At]] = []
        begin, end = self.start_instant(), self.end_instant()
        pairs = list(element_pairs(a, ids_of(self.tree_a, primitive_a), b, ids_of(self.tree_b, primitive_b)))
        events = [(begin, False), *self.events(a, b, pairs), (end, False)]
        open_since: At | None = None
        for (left, touching), (right, _) in pairwise(events):
            if self.order(left, right) < 0 and self.meet_between(a, b, left, right):
                open_since = left if open_since is None else open_since
                continue
            if open_since is not None:
                windows.append((open_since, left))
            elif touching:
                windows.append((left, left))
            open_since = None
        return windows if open_since is None else [*windows, (open_since, end)]

    def events(
        self, a: Primitive, b: Primitive, pairs: list[tuple[Hashable, Corners]]
    ) -> list[tuple[At, bool]]:
        """The instants within the piece at which contact may begin or end, ascending, and whether they are contacts."""
        raise NotImplementedError

    def meet_between(self, a: Primitive, b: Primitive, left: At, right: At) -> bool:
        """Whether two primitives share a point at a time between two instants."""
        pose = self.pose_between(left, right)
        return bool(decide(lambda: a.moved(pose).meets(b)))

    def pose_between(self, x: At, y: At) -> Matrix:
        raise NotImplementedError

    # -- answers --------------------------------------------------------------------------------------------

    def world_time(self, local: float) -> float:
        """A double not later than the local time, in the motions' clock."""
        t = to_double(self.piece.start)
        return local if t == 0.0 else math.nextafter(t + local, -math.inf)

    def is_end(self, at: At, turn: int) -> bool:
        """Whether the instant is the end of the piece."""
        return self.order(at, self.end_instant()) == 0

    def order(self, x: At, y: At) -> int:
        """-1, 0, 1: x before, at, after y."""
        return x.compare(y)

    def start_instant(self) -> At:
        raise NotImplementedError

    def end_instant(self) -> At:
        raise NotImplementedError

    def repeated(self, windows: list[tuple[At, At]]) -> list[tuple[At, int, At, int]]:
        """The windows as (start, turn, end, turn): there are no turns."""
        return [(start, 0, end, 0) for start, end in windows]

    def touch(self, element_a: Feature, element_b: Feature, at: At) -> Touch:
        """(point, unit normal or None) of the two elements at the instant, working frame."""
        corners_a, corners_b = corners_of(self.a, element_a), corners_of(self.b, element_b)
        for bits in PRECISIONS:
            with terms(2, bits):
                pose = self.piece.series(at.local() + self.piece.start)
                now: Any = [tuple(x[0] for x in row) for row in pose]
                speed = [tuple(x[1] for x in row) for row in pose]
                moved = [apply(now, _balls(p)) for p in corners_a]
                rest = [_balls(p) for p in corners_b]
                point = _shared_point(element_a, moved, element_b, rest)
                back = inverse(pose, self.piece.is_rigid)
                own = apply([tuple(x[0] for x in row) for row in back], point)  # type: ignore[arg-type]
                velocity = apply(speed, own)  # type: ignore[arg-type]
                normal = unit_against(cross(*spanning(moved), *spanning(rest)), velocity)
            if normal is not None:
                break
        return doubles(point), normal


def _balls(p: Vector) -> Vector:
    return ball(p[0]), ball(p[1]), ball(p[2])


def _shared_point(element_a: Feature, a: list[Vector], element_b: Feature, b: list[Vector]) -> Vector:
    """A point of both elements, given that they share one, in balls."""
    if element_a[0] == VERTEX:
        return a[0]
    if element_b[0] == VERTEX:
        return b[0]
    (p, q), (r, s) = a, b
    e, f, w = sub(q, p), sub(s, r), sub(r, p)
    n = cross(e, f)
    square = dot(n, n)
    if not square.contains(0):
        mu = dot(cross(w, e), n) / square
        return add(r, (mu * f[0], mu * f[1], mu * f[2]))
    return min(((p, r, s), (q, r, s), (r, p, q), (s, p, q)), key=lambda found: _distance(*found))[0]


def _distance(x: Vector, c: Vector, d: Vector) -> float:
    """About the distance of x from the segment cd."""
    p, q, r = (np.array([float(v.mid()) for v in point]) for point in (x, c, d))
    f = r - q
    length = float(f @ f)
    share = min(max(float((p - q) @ f) / length, 0.0), 1.0) if length > 0 else 0.0
    return float(np.linalg.norm(p - q - share * f))


def element_pairs(a: Primitive, ids_a: Ids, b: Primitive, ids_b: Ids) -> Iterator[tuple[Hashable, Corners]]:
    """The pairs of elements, named, of two primitives whose contacts are the events of theirs.

    ids: what names the sides, the corners and the whole of a primitive.
    """
    for s, x in enumerate(a.sides):
        yield from (((ids_a[0][s], ids_b[0][r]), ([*x], [*y])) for r, y in enumerate(b.sides))
    if b.is_facet:
        yield from (((ids_a[1][s], ids_b[2]), ([p], [*b.corners])) for s, p in enumerate(a.corners))
    if a.is_facet:
        yield from (((ids_a[2], ids_b[1][s]), ([*a.corners], [q])) for s, q in enumerate(b.corners))


def ids_of(tree: Tree, index: int) -> Ids:
    """The names of a primitive's elements: elements that primitives share have one name."""
    sides: list[Hashable] = [(EDGE, int(e)) if e >= 0 else (index, s) for s, e in enumerate(tree.sides[index])]
    return sides, [(VERTEX, int(v)) for v in tree.corners[index]], (FACE, index)
