"""First contacts of one pair of polyhedra under each of many translations: one compiled walk, exact winners.

What it tells is what `first` tells of each, bit for bit: the trees, boxes and bounds are those of `TranslationProblem`,
and so are the exact times.  Motions that it leaves open are for `first`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flint import fmpq, fmpz

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.answers import element_pairs
from firstcontact.contact.polyhedra.earliest import Pair
from firstcontact.contact.polyhedra.engines import tests_of_boxes
from firstcontact.contact.polyhedra.translation_problem import (
    LEAST_FRAMED,
    TranslationProblem,
    framed_pad,
    framed_velocity,
)
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.exact.vectors import Vector, whole, whole_doubles
from firstcontact.motion.relative.pieces import Piece, pieces
from firstcontact.motion.translation import Translation
from firstcontact.pairs.elements import coplanar
from firstcontact.result import ElementPair
from firstcontact.search.trees.elements import KINDS, feature, vertices_of, whole_corners
from firstcontact.search.trees.state import CERTAIN_KIND, SLICE, borrow_state, return_state
from firstcontact.search.trees.touch import translation_touch
from firstcontact.search.trees.walk_each import OPEN, walk_each

ONE = fmpz(1)
ROOM = 4096
"""Contacts that the walk tells at once."""


@dataclass(frozen=True, slots=True)
class Met:
    """A first contact: which motion, when, and all pairs of elements that meet then."""

    motion: int
    instant: RationalInstant
    pairs: list[Pair]


class EachTranslation:
    """Body a moves by t v over [0, last], for each of many v; body b rests."""

    def __init__(self, a: Polyhedron, b: Polyhedron) -> None:
        """a, b: in rational poses, so that contacts have exact times."""
        self.bodies = a.moving(Translation((1, 0, 0))), b
        piece = pieces(*self.bodies, fmpq(0), fmpq(1))[0]
        assert isinstance(piece, Piece)
        self.problem = TranslationProblem(a, b, piece)
        self.most_tests = tests_of_boxes(self.problem.tree_a, self.problem.tree_b)
        """Pair tests after which `first` asks another engine."""

    def is_apart(self) -> bool:
        """Whether no body lies inside the other one at the start; whether their surfaces meet, each walk looks at."""
        return not self.problem.is_contained()

    def walked(self, vectors: np.ndarray, lasts: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[Met]]:
        """(FREE, MET or OPEN, node visits and pair tests) of each motion, and the contacts, in order.

        vectors (n, 3): velocities, moderate ones (`is_moderate`).  lasts (n,): ends of the windows.
        """
        told, work = np.full(len(vectors), OPEN, np.int64), np.zeros(len(vectors), np.int64)
        met: list[Met] = []
        for rows, times in self._contacts(vectors, lasts, told, work):
            for first, end in _runs(rows[:, 0]):
                motion = int(rows[first, 0])
                found = self._winner(vectors[motion].tolist(), times[first:end].tolist(), rows[first:end, 1:].tolist())
                if found is None:
                    told[motion] = OPEN
                else:
                    met.append(Met(motion, *found))
        return told, work, met

    def _contacts(
        self, vectors: np.ndarray, lasts: np.ndarray, told: np.ndarray, work: np.ndarray
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Walks, and gives the contacts that may be first by and by: (motion and candidate, enclosure) of each."""
        problem = self.problem
        a, b, frame = problem.tree_a, problem.tree_b, problem.frame
        coordinates = list(vectors.T)
        framed = vectors
        if frame is not None:
            framed = np.stack(framed_velocity(frame, coordinates), axis=1)
            framed = np.where(np.abs(framed) >= LEAST_FRAMED, framed, 0.0)
        with np.errstate(divide="ignore"):
            motions = np.concatenate([framed, 1.0 / np.where(framed == 0.0, 0.0, framed), vectors], axis=1)
        pads = np.broadcast_to(framed_pad(problem.error, frame, coordinates, lasts), lasts.shape)
        ends = np.stack([lasts, lasts], axis=1)
        times, rows = np.empty((ROOM, 2)), np.empty((ROOM, 6), np.int64)
        state, begin = borrow_state(), 0
        try:
            while begin < len(vectors):
                begin, count = walk_each(
                    problem.boxes_a, a.links, a.xyz, a.ids, problem.boxes_b, b.links, b.xyz, b.ids,
                    motions, ends, np.ascontiguousarray(pads), a.error, b.error, self.most_tests, begin, SLICE,
                    state.floats, state.integers, state.keys, state.pairs, state.stack, state.times, state.candidates,
                    told, work, times, rows,
                )  # fmt: skip
                yield rows[:count], times[:count]
        finally:
            return_state(state)

    def _winner(
        self, v: list[float], times: list[list[float]], rows: list[list[int]]
    ) -> tuple[RationalInstant, list[Pair]] | None:
        """The first of contacts that certainly are, exact, and all pairs that share it, as `earliest` finds them.

        None where one equation does not tell the time, or the bodies touch at the start.
        """
        per, (velocity,) = whole_doubles([v], ONE, int)
        best: RationalInstant | None = None
        until = math.inf
        tied: list[Pair] = []
        for (lo, _), row in sorted(zip(times, rows, strict=True)):
            if lo > until:
                break
            pair = self._pair(row)
            if pair in tied:
                continue
            corners_a, corners_b = self._whole.corners(pair)
            value = coplanar.translation_instant(corners_a, corners_b, velocity)
            if value is None:
                return None
            instant = RationalInstant(value * per / self._whole.scale)
            order = -1 if best is None else instant.compare(best)
            if order < 0:
                best, tied, until = instant, [pair], min(until, instant.bounds()[1])
            elif order == 0:
                tied.append(pair)
        return None if best is None or best.is_zero() else (best, sorted(tied))

    def _pair(self, row: list[int]) -> Pair:
        kind, part_a, local_a, part_b, local_b = row
        kind_a, kind_b = KINDS[kind - CERTAIN_KIND]
        tree_a, tree_b = self.problem.tree_a, self.problem.tree_b
        return kind - CERTAIN_KIND, feature(tree_a, kind_a, part_a, local_a), feature(tree_b, kind_b, part_b, local_b)

    @cached_property
    def _whole(self) -> _WholeVertices:
        return _WholeVertices(self.problem.a, self.problem.b)

    def time(self, met: Met) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of a contact."""
        return self.problem.world_instant(met.instant)

    def place(self, v: list[float], met: Met) -> tuple[ElementPair, int, np.ndarray, np.ndarray | None]:
        """(the lowest pair, how many there are, point, unit normal or None) of a contact of the motion by t v."""
        named = element_pairs(*self.bodies, met.pairs)
        lowest, pair = named[0]
        per, (velocity,) = whole_doubles([v], ONE)
        scale, corners_a, corners_b, velocity = whole_corners(
            self.problem.a, pair[1], self.problem.b, pair[2], per, velocity
        )
        touch = translation_touch(pair[1], corners_a, pair[2], corners_b, velocity, scale, met.instant)
        return lowest, len(named), *touch


class _WholeVertices:
    """The vertices of two bodies times one scale: whole numbers."""

    def __init__(self, a: Polyhedron, b: Polyhedron) -> None:
        self.bodies = a, b
        if a.error == 0.0 and b.error == 0.0:
            points = np.concatenate([a.vertices, b.vertices]).tolist()
            self.scale, whole_points = whole_doubles(points, ONE, int)
        else:
            exact = [x.exact_vertex(k) for x in (a, b) for k in range(len(x.vertices))]
            self.scale, points = whole(*exact)
            whole_points = [(int(x), int(y), int(z)) for x, y, z in points]
        self.points = whole_points[: len(a.vertices)], whole_points[len(a.vertices) :]

    def corners(self, pair: Pair) -> tuple[list[Vector], list[Vector]]:
        """Those of both elements."""
        a, b = ([points[k] for k in vertices_of(body, element)]
                for points, body, element in zip(self.points, self.bodies, pair[1:], strict=True))  # fmt: skip
        return a, b


def is_moderate(vectors: np.ndarray) -> np.ndarray:
    """Which velocities are looked at as they are, none of their coordinates (but zeros) huge or tiny."""
    sizes = np.abs(vectors)
    largest = sizes.max(axis=1, initial=0.0)
    told: np.ndarray = (largest > 1e-30) & (largest < 1e30) & ((sizes == 0.0) | (sizes >= LEAST_FRAMED)).all(axis=1)
    return told


def _runs(motions: np.ndarray) -> Iterator[tuple[int, int]]:
    """Where each motion's rows begin and end."""
    cuts = [0, *(np.flatnonzero(np.diff(motions)) + 1).tolist(), len(motions)]
    return ((first, end) for first, end in zip(cuts, cuts[1:], strict=False) if first < end)
