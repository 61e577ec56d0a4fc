"""First contacts of one pair of polyhedra under each of many motions: what translations and rotations have in common.

What is told here is what `first` tells of each motion, bit for bit: trees, boxes and bounds are those of the problem,
and exact arithmetic finds the winners.  Motions that are left open are for `first`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.answers import element_pairs, place_met
from firstcontact.contact.polyhedra.earliest import FoundFirst, Pair, Problem
from firstcontact.exact.numbers import Undecidable, exact_value
from firstcontact.motion.moving import Moving
from firstcontact.motion.relative.pieces import MotionPiece, pieces
from firstcontact.result import Element
from firstcontact.search.trees.elements import FACE, KINDS, VERTEX
from firstcontact.search.trees.state import CERTAIN_KIND, SLICE, borrow_state, return_state
from firstcontact.search.trees.tree import Tree
from firstcontact.search.trees.walk_each import OPEN, walk_each

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

ROOM = 4096
"""Contacts that the walk tells at once."""


@dataclass(frozen=True)
class Walked:
    """What walks tell: FREE, MET, TIMED or OPEN, and node visits and pair tests, of each motion.

    Of those that are MET, all contacts that may be first, by motion: number of the motion, enclosures of the times (k,
    2), candidates (k, 5) as parts of the trees have them.  Of those that are TIMED the first contact, its time in two
    doubles.
    """

    told: np.ndarray
    work: np.ndarray
    motions: np.ndarray
    times: np.ndarray
    candidates: np.ndarray
    trees: tuple[Tree, Tree]

    def pairs(self, some: np.ndarray | slice) -> np.ndarray:
        """Kinds and elements (n, 5) of some candidates, as `feature` tells them."""
        rows = self.candidates[some]
        kinds, pairs = rows[:, 0] - CERTAIN_KIND, np.empty((len(rows), 5), np.int64)
        pairs[:, 0] = kinds
        for side, tree in enumerate(self.trees):
            local, primitive = rows[:, 2 + 2 * side], tree.ids[rows[:, 1 + 2 * side], 0]
            kind = np.array([KINDS[k][side] for k in range(len(KINDS))])[kinds]
            found = np.where(kind == VERTEX, tree.corners[primitive, local], tree.sides[primitive, local])
            pairs[:, 1 + 2 * side] = kind
            pairs[:, 2 + 2 * side] = np.where(kind == FACE, primitive, found)
        return pairs

    def named(self, some: np.ndarray | slice) -> list[Pair]:
        return [(kind, (i, j), (k, m)) for kind, i, j, k, m in self.pairs(some).tolist()]

    def groups(self) -> list[slice]:
        """The contacts of each motion."""
        cuts = [0, *(np.flatnonzero(np.diff(self.motions)) + 1).tolist(), len(self.motions)]
        return [slice(first, end) for first, end in zip(cuts, cuts[1:], strict=False) if first < end]


@dataclass(frozen=True)
class FirstContacts:
    """First contacts: numbers of the motions, doubles nearest the times, (m, 2) enclosures; `instant` and `pairs` of

    each: when it is, exact, and the pairs of elements that meet then.
    """

    motions: np.ndarray
    times: np.ndarray
    intervals: np.ndarray
    instant: Callable[[int], Any]
    pairs: Callable[[int], list[Pair]]


Place = tuple[tuple[Element, Element], int, np.ndarray, np.ndarray | None]
"""The lowest pair of elements, how many there are, the point, the unit normal or None."""


def piece_of(moving: Moving, b: Polyhedron, last: float) -> MotionPiece:
    """The one piece of a translation or rotation before a body at rest, from 0 to `last`."""
    (piece,) = pieces(moving, b, fmpq(0), exact_value(last))
    assert isinstance(piece, MotionPiece)
    return piece


def placed(problem: Problem, contacts: FirstContacts, k: int, moving: Moving, b: Polyhedron) -> Place:
    """What a CONTACT result says of the place of a contact; the problem is that of its motion."""
    found = FoundFirst(contacts.instant(k), contacts.pairs(k))
    named = element_pairs(moving, b, found.pairs)
    place = place_met(problem, found, float(contacts.times[k]), (moving, b), [pair for _, pair in named])
    return (named[0][0].element_a, named[0][0].element_b), len(named), *place


@dataclass(frozen=True)
class Walks:
    """What all walks share.

    boxes and trees of both bodies, how far coordinates of both boxes together and those of parts may be off, the pair
    tests after which `first` asks another engine, and by what each coordinate of the parts is off, where that is known.
    """

    boxes_a: np.ndarray
    tree_a: Tree
    boxes_b: np.ndarray
    tree_b: Tree
    error: float
    error_a: float
    error_b: float
    most_tests: int
    rests: tuple[np.ndarray, np.ndarray] = (np.empty((0, 9)), np.empty((0, 9)))

    def walked(
        self, motion: np.ndarray, vectors: np.ndarray, frame: np.ndarray, ends: np.ndarray, sure_ends: np.ndarray
    ) -> Walked:
        """motion, vectors, frame, ends, sure_ends: as `walk_each` has them."""
        a, b = self.tree_a, self.tree_b
        told, work = np.full(len(ends), OPEN, np.int64), np.zeros(len(ends), np.int64)
        all_times, all_rows = [np.empty((0, 2))], [np.empty((0, 6), np.int64)]
        state, begin = borrow_state(), 0
        try:
            while begin < len(ends):
                times, rows = np.empty((ROOM, 2)), np.empty((ROOM, 6), np.int64)
                begin, count = walk_each(
                    self.boxes_a, a.links, a.xyz, a.ids, self.boxes_b, b.links, b.xyz, b.ids,
                    motion, vectors, frame, ends, sure_ends, self.error, self.error_a, self.error_b, self.most_tests,
                    begin, SLICE,
                    state.floats, state.integers, state.keys, state.pairs, state.stack, state.times, state.candidates,
                    *self.rests, told, work, times, rows,
                )  # fmt: skip
                all_times.append(times[:count])
                all_rows.append(rows[:count])
        finally:
            return_state(state)
        rows = np.concatenate(all_rows)
        return Walked(told, work, rows[:, 0], np.concatenate(all_times), rows[:, 1:], (a, b))


Exactly = Callable[[Pair, float, float], Any]
"""The exact time of two elements that certainly meet within the two doubles; None where that is for others to tell."""


def first_of(candidates: Sequence[tuple[float, float, Pair]], exactly: Exactly) -> tuple[Any, list[Pair]] | None:
    """The first of contacts that certainly are, and all pairs that share it, as `earliest` finds them.

    None where it is not told, or lies at the start.
    """
    best: Any = None
    until = math.inf
    tied: list[Pair] = []
    try:
        for lo, hi, pair in sorted(candidates):
            if lo > until:
                break
            if pair in tied:
                continue
            instant = exactly(pair, lo, hi)
            if instant is None:
                return None
            order = -1 if best is None else instant.compare(best)
            if order < 0:
                best, tied, until = instant, [pair], min(until, instant.bounds()[1])
            elif order == 0:
                tied.append(pair)
        return None if best is None or best.is_zero() else (best, sorted(tied))
    except Undecidable:
        return None


def is_taken(a: Body, b: Body) -> bool:
    """Whether both are polyhedra at rest in rational poses, so that contacts have exact times."""
    return all(isinstance(x, Polyhedron) and x.irrational_pose is None for x in (a, b))
