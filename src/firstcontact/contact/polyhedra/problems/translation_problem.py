"""One piece of relative translation: the walk over two trees, and exact answers for pairs of elements."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.engines import ByEngine
from firstcontact.contact.polyhedra.problems.shared_plane import in_its_plane
from firstcontact.exact.numbers import Undecidable, below, dyadic, exact_value, fraction, sign, to_double
from firstcontact.exact.rigid import Matrix, shift
from firstcontact.exact.times.instants import RationalInstant, enclose
from firstcontact.exact.times.windows import ALWAYS, Window, clip, hull
from firstcontact.exact.vectors import Vector, scaled
from firstcontact.motion.relative.pieces import MotionPiece
from firstcontact.pairs.elements import coplanar, line_line, point_plane, segment_facet
from firstcontact.pairs.elements.separated import apart_in_doubles, are_apart
from firstcontact.search.trees import translate
from firstcontact.search.trees.containment import contained
from firstcontact.search.trees.elements import EDGE, VERTEX, Corners, Feature, Primitive, corners_of, places
from firstcontact.search.trees.frame import Frame, shared_frame, tree_of, view_in
from firstcontact.search.trees.touch import Touch, translation_touch

if TYPE_CHECKING:
    from firstcontact.contact.polyhedra.earliest import Pair

ZERO = fmpq(0)


# Coordinates of velocities above it are as good as any; those below, but not zero, may leave the range of doubles.
LEAST_SPEED = 2.0**-1000


class TranslationProblem(ByEngine):
    """Body a moves by t v over the local times [0, last] (last None: for ever), body b rests.

    The local clock is that of the motions from the piece's start on; where their velocities are huge or tiny, `pace`
    times as quick.
    """

    begin = 0.0, 0.0

    def __init__(self, a: Polyhedron, b: Polyhedron, piece: MotionPiece) -> None:
        assert piece.velocity is not None
        self.a, self.b, self.piece = a, b, piece
        self.v, self._doubles = piece.velocity, [to_double(x) for x in piece.velocity]
        self.pace = _pace(self.v, self._doubles)
        if self.pace is not None:
            self.v = scaled(1 / self.pace, self.v)
            self._doubles = [to_double(x) for x in self.v]
        self._corners = Corners(a, b, self.v)
        self.is_exact = a.irrational_pose is None and b.irrational_pose is None
        self.last = None if piece.end is None else piece.end - piece.start
        if self.last is not None and self.pace is not None:
            self.last *= self.pace
        self._window = _doubles_around(self.last)
        self._prepare()

    def _prepare(self) -> None:
        """Boxes and their velocity in the frame that suits the bodies; parts and their velocity as they are."""
        v = self._doubles
        self.tree_a, self.tree_b = tree_a, tree_b = tree_of(self.a), tree_of(self.b)
        self.error_a, self.error_b = tree_a.error, tree_b.error
        self.frame = frame = None if self.last is None else shared_frame(self.a, self.b)
        if frame is not None:
            tree_a, tree_b = view_in(self.a, frame), view_in(self.b, frame)
        self.boxes_a, self.boxes_b, self.error = tree_a.boxes, tree_b.boxes, tree_a.error + tree_b.error
        self.motion = np.empty(9)
        off = translate.lay_motion(np.array(v), rows_of(frame), self.motion)
        self.pad = 2.0 * (self.error + off * self._window[0]) if off else 2.0 * self.error
        if any(abs(y) < LEAST_SPEED and x != 0 for x, y in zip(self.v, v, strict=True)):
            self.pad += 2.0**-800  # so slowly nothing comes that far before the bodies have passed each other

    def window(self) -> tuple[float, float]:
        """(last, sure last): outward and inward doubles around the end of the window."""
        return self._window

    def contact(self, element_a: Feature, element_b: Feature) -> RationalInstant | None:
        """The earliest time of the window at which the two elements share a point; exact."""
        _, corners_a, corners_b, v = self._corners.whole.of(element_a, element_b)
        elements = element_a, corners_a, element_b, corners_b, v
        clipped = clip(self._unless_apart(lambda: _window(*elements), corners_a, corners_b, v), (ZERO, self.last))
        return None if clipped is None else RationalInstant(clipped[0])

    def apart(self, rows: np.ndarray) -> np.ndarray:
        """(n,) bools: True proves that the elements of a candidate share no point in the window."""
        last = self._window[0]
        if last == math.inf:
            return super().apart(rows)
        a, b = places(self.tree_a, self.tree_b, rows)
        shift = np.array(self._doubles) * last
        error = self.tree_a.error + self.tree_b.error + 2.0**-51 * float(np.abs(shift).max())
        return apart_in_doubles(a, b, shift, error)

    def _unless_apart(
        self, windows: Callable[[], Window | None], a: Sequence[Vector], b: Sequence[Vector], v: Vector
    ) -> Window | None:
        """The windows of convex elements; none where balls do not tell them, but a plane is between all the time."""
        try:
            return windows()
        except Undecidable:
            if self.last is None or not are_apart(a, b, v, self.last):
                raise
            return None

    def contact_within(self, element_a: Feature, element_b: Feature, lo: float, hi: float) -> RationalInstant | None:
        """The first contact of the two elements, of which floats have proved that it is in [lo, hi]; exact."""
        if self.is_exact:
            _, a, b, v = self._corners.ints.of(element_a, element_b)
            time = coplanar.translation_instant(a, b, v)
            if time is not None:
                return RationalInstant(time)
        return self.contact(element_a, element_b)

    def tied_with(self, pair: Pair, instant: RationalInstant, others: Sequence[Pair]) -> Sequence[Pair]:
        """Those in one plane with the pair then.  Their equations have one root: floats are certain of pairs only where
        the speed certainly is not 0.
        """
        if not self.is_exact or not isinstance(instant.value, fmpq):
            return ()
        return in_its_plane(self.a, self.b, self.v, pair, instant.value, others)

    def possible(self, element_a: Feature, element_b: Feature) -> float:
        """A time before which the two elements, which no precision could decide, certainly do not meet."""
        return 0.0

    # -- all windows ----------------------------------------------------------------------------------------

    def windows_of(self, primitive_a: int, primitive_b: int) -> list[tuple[RationalInstant, RationalInstant | None]]:
        """The windows of contact of two primitives, exact: at most one, both are convex."""
        a, b = Primitive(self.a, self.tree_a, primitive_a), Primitive(self.b, self.tree_b, primitive_b)
        back = (-self.v[0], -self.v[1], -self.v[2])
        if not any(sign(x) for x in self.v):
            found: Window | None = ALWAYS if a.meets(b) else None
        else:
            found = self._unless_apart(lambda: hull(
                [_edge_window(x, y, self.v) for x in a.sides for y in b.sides]
                + [_vertex_window(x, b.corners, self.v) for x in a.corners if b.is_facet]
                + [_vertex_window(y, a.corners, back) for y in b.corners if a.is_facet]
            ), a.corners, b.corners, self.v)  # fmt: skip
        clipped = clip(found, (ZERO, self.last))
        if clipped is None:
            return []
        return [(RationalInstant(clipped[0]), None if clipped[1] is None else RationalInstant(clipped[1]))]

    def float_window(self, lo: float, hi: float) -> tuple[RationalInstant, RationalInstant | None]:
        """A certain window given by doubles, clipped to the piece."""
        first = fmpq(*max(lo, 0.0).as_integer_ratio())
        if math.isinf(hi):
            return RationalInstant(first), self.end_instant()
        end = fmpq(*hi.as_integer_ratio())
        return RationalInstant(first), RationalInstant(end if self.last is None or end < self.last else self.last)

    def start_instant(self) -> RationalInstant:
        return RationalInstant(ZERO)

    def end_instant(self) -> RationalInstant | None:
        """The end of the piece; None: never."""
        return None if self.last is None else RationalInstant(self.last)

    def order(self, x: RationalInstant | None, y: RationalInstant | None) -> int:
        """-1, 0, 1: x before, at, after y (None: never)."""
        if x is None or y is None:
            return (x is None) - (y is None)
        return x.compare(y)

    def pose_between(self, x: RationalInstant, y: RationalInstant | None) -> Matrix:
        """The pose of a at a time strictly between x and y (at x when they are equal); exact."""
        time = x.value + 1 if y is None else (x.value + y.value) / 2
        if isinstance(time, arb):
            time = dyadic(time.mid())
        return shift((time * self.v[0], time * self.v[1], time * self.v[2]))

    # -- answers --------------------------------------------------------------------------------------------

    def start_relation(self, element_a: Feature, element_b: Feature) -> int:
        """How an edge and a facet relate at the start of the window (`segment_facet.relation`); exact."""
        _, corners_a, corners_b, _ = self._corners.ints.of(element_a, element_b)
        segment, facet = (corners_a, corners_b) if element_a[0] == EDGE else (corners_b, corners_a)
        return segment_facet.relation(*segment, *facet)

    def start_point(self, element_a: Feature, element_b: Feature) -> Vector:
        """A shared point of the two elements at the start, given that there is one; exact."""
        corners_a, corners_b = corners_of(self.a, element_a), corners_of(self.b, element_b)
        return segment_facet.start_point(corners_a, corners_b)

    def is_contained(self) -> bool:
        """Whether a body lies inside the other one at the start; their surfaces share no point."""
        return contained(self.a, self.b) is not None

    def world_instant(self, at: RationalInstant | None, turn: int = 0) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant in the motions' clock."""
        if at is None:
            return math.inf, (math.inf, math.inf)
        return enclose(lambda: self._world(at.value))

    def _world(self, local: Any) -> Any:
        """The local time in the motions' clock."""
        return self.piece.start + (local if self.pace is None else local / self.pace)

    def is_end(self, at: RationalInstant | None, turn: int) -> bool:
        """Whether the instant is the end of the piece."""
        return self.order(at, self.end_instant()) == 0

    def repeated(
        self, windows: list[tuple[RationalInstant, RationalInstant | None]]
    ) -> list[tuple[RationalInstant, int, RationalInstant | None, int]]:
        """The windows as (start, turn, end, turn): a translation has no turns."""
        return [(start, 0, end, 0) for start, end in windows]

    def world_exact(self, at: RationalInstant | None, turn: int = 0) -> Fraction | None:
        if at is None:
            return None
        value = self._world(at.value)
        return fraction(value) if isinstance(value, fmpq) else None

    def world_time(self, local: float) -> float:
        """A double not later than the local time, in the motions' clock."""
        if math.isinf(local):
            return local
        if self.pace is not None:
            return below(self._world(exact_value(local)))
        t = to_double(self.piece.start)
        return local if t == 0.0 else math.nextafter(t + local, -math.inf)

    def touch(self, element_a: Feature, element_b: Feature, at: RationalInstant) -> Touch:
        """(point, unit normal or None) of the two elements at the instant, working frame."""
        scale, corners_a, corners_b, v = self._corners.whole.of(element_a, element_b)
        return translation_touch(element_a, corners_a, element_b, corners_b, v, scale, at)


def _doubles_around(last: fmpq | None) -> tuple[float, float]:
    """Outward and inward doubles around the end of a window; None: it has none."""
    if last is None:
        return math.inf, math.inf
    near = to_double(last)
    if math.isinf(near):
        return near, sys.float_info.max
    if fmpq(*near.as_integer_ratio()) == last:
        return near, near
    return math.nextafter(near, math.inf), math.nextafter(near, -math.inf)


@lru_cache(maxsize=64)
def rows_of(frame: Frame | None) -> np.ndarray:
    """(3, 3), or (0, 3) without a frame: as `lay_motion` has it."""
    return np.empty((0, 3)) if frame is None else np.array(frame)


def _pace(v: Vector, doubles: list[float]) -> fmpq | None:
    """The power of two near the largest coordinate of a velocity; None where doubles do without."""
    if 1e-30 < max(map(abs, doubles)) < 1e30 or not any(v):
        return None
    largest = max(map(abs, v))
    return fmpq(2) ** (int(largest.p).bit_length() - int(largest.q).bit_length())


def _window(
    element_a: Feature, a: Sequence[Vector], element_b: Feature, b: Sequence[Vector], v: Vector
) -> Window | None:
    """The times at which two elements with those corners meet, the first moving by v per unit of time."""
    if element_a[0] == VERTEX:
        return _vertex_window(a[0], b, v)
    if element_b[0] == VERTEX:
        return _vertex_window(b[0], a, (-v[0], -v[1], -v[2]))
    return _edge_window(a, b, v)


def _vertex_window(p: Vector, facet: Sequence[Vector], v: Vector) -> Window | None:
    a, b, c = facet
    return point_plane.translation_window(p, a, b, c, v)


def _edge_window(x: Sequence[Vector], y: Sequence[Vector], v: Vector) -> Window | None:
    (a, b), (c, d) = x, y
    return line_line.translation_window(a, b, c, d, v)
