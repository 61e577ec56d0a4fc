"""First contacts of one pair of polyhedra under each of many translations."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from flint import fmpq, fmpz

from firstcontact.body.kept import KeptOfTwo
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.each import FirstContacts, Place, Walked, Walks, piece_of, placed
from firstcontact.contact.polyhedra.earliest import Pair
from firstcontact.contact.polyhedra.problems.translation_problem import TranslationProblem, rows_of
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.exact.vectors import Vector, whole, whole_doubles
from firstcontact.motion.translation import Translation
from firstcontact.pairs.elements import coplanar
from firstcontact.search.trees.elements import FACE, VERTEX
from firstcontact.search.trees.translate import LEAST_FRAMED
from firstcontact.search.trees.tree import Tree
from firstcontact.search.trees.walk_each import OPEN, TIMED

ONE = fmpz(1)
_WHOLE = KeptOfTwo["_WholeVertices"]()


class EachTranslation:
    """Body a moves by t v over [0, last], for each of many v; body b rests."""

    def __init__(self, a: Polyhedron, b: Polyhedron, vectors: np.ndarray, lasts: np.ndarray) -> None:
        """vectors (n, 3): velocities, moderate ones (`is_moderate`).  lasts (n,): ends of the windows."""
        self.vectors, self.lasts = vectors, lasts
        problem = self.problem = TranslationProblem(a, b, piece_of(a.moving(Translation((1, 0, 0))), b, 1.0))
        x, y = problem.tree_a, problem.tree_b
        self.walks = Walks(
            problem.boxes_a, x, problem.boxes_b, y, problem.error, problem.error_a, problem.error_b,
            problem.most_tests(), self._whole.rests(x, y),
        )  # fmt: skip

    def told(self) -> tuple[np.ndarray, np.ndarray, FirstContacts]:
        """FREE, MET, TIMED or OPEN, node visits and pair tests, of each motion; the contacts."""
        frame = rows_of(self.problem.frame)
        return self._contacts(self.walks.walked(np.empty(9), self.vectors, frame, self.lasts, self.lasts))

    def _contacts(self, walked: Walked) -> tuple[np.ndarray, np.ndarray, FirstContacts]:
        """What is told, work, and the contacts.

        The first of all candidates by the exact equation of each, where pairs of doubles have not told it.
        """
        timed = walked.told[walked.motions] == TIMED
        alone, others = np.flatnonzero(timed), np.flatnonzero(~timed)
        gaps, speeds = self._equations(walked, others)
        first, end = _earliest(walked, others, gaps, speeds)
        chosen = first[end[:-1]]
        times = (gaps[chosen] / speeds[chosen]).astype(float)  # Python's division of whole numbers rounds correctly
        near, rests = walked.times[alone].T

        def instant(k: int) -> RationalInstant:
            if k >= len(alone):
                return RationalInstant(fmpq(gaps[chosen[k - len(alone)]], speeds[chosen[k - len(alone)]]))
            (gap,), (speed,) = self._equations(walked, alone[k : k + 1])
            return RationalInstant(fmpq(gap, speed))

        def pairs(k: int) -> list[Pair]:
            if k < len(alone):
                return walked.named(alone[k : k + 1])
            k -= len(alone)
            return sorted(walked.named(others[np.sort(first[end[k] : end[k + 1]])]))

        return walked.told, walked.work, FirstContacts(
            np.append(walked.motions[alone], walked.motions[others[chosen]]),
            np.append(near, times),
            np.concatenate([_towards(near, rests), _around(times, gaps[chosen], speeds[chosen])]),
            instant, pairs,
        )  # fmt: skip

    def _equations(self, walked: Walked, some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whole numbers gap and speed > 0 of some candidates, the time being gap / speed; a speed of 0 tells none."""
        whole, pairs = self._whole, walked.pairs(some)
        kinds = pairs[:, 0]
        velocity, up, down = _whole_velocities(self.vectors[walked.motions[some]])
        gaps, speeds = np.empty(len(kinds), object), np.empty(len(kinds), object)
        for kind in np.unique(kinds).tolist():
            of = np.flatnonzero(kinds == kind)
            corners = whole.corners(pairs[of])
            gaps[of], speeds[of] = coplanar.translation_equation(*corners, tuple(velocity[of].T))
        signs = np.where(speeds < 0, -1, 1)
        return signs * gaps * up, signs * speeds * whole.scale * down

    @cached_property
    def _whole(self) -> _WholeVertices:
        """Kept on a while b is the same."""
        a, b = self.problem.a, self.problem.b
        return _WHOLE.of(a, b, lambda: _WholeVertices(a, b))

    def place(self, contacts: FirstContacts, k: int) -> Place:
        """Elements, point and normal of a contact."""
        motion = int(contacts.motions[k])
        a, b = self.problem.a, self.problem.b
        moving = a.moving(Translation(self.vectors[motion].tolist()))
        problem = TranslationProblem(a, b, piece_of(moving, b, float(self.lasts[motion])))
        return placed(problem, contacts, k, moving, b)


class _WholeVertices:
    """The vertices of two bodies times one scale: arrays (n, 3) of whole numbers."""

    _rests: tuple[np.ndarray, np.ndarray] | None = None

    def __init__(self, a: Polyhedron, b: Polyhedron) -> None:
        self.bodies = a, b
        if a.error == 0.0 and b.error == 0.0:
            self.scale, points = whole_doubles(np.concatenate([a.vertices, b.vertices]).tolist(), ONE, int)
        else:
            exact = [x.exact_vertex(k) for x in (a, b) for k in range(len(x.vertices))]
            scale, numbers = whole(*exact)
            self.scale, points = int(scale), [(int(x), int(y), int(z)) for x, y, z in numbers]
        array: np.ndarray = np.array(points, object)
        self.points = array[: len(a.vertices)], array[len(a.vertices) :]

    def rests(self, *trees: Tree) -> tuple[np.ndarray, np.ndarray]:
        """What coordinates of the parts of their trees are off by, (m, 9) each."""
        if self._rests is None:
            a, b = (
                self._rest(body, points)[tree.corners[tree.ids[:, 0]]].reshape(-1, 9)
                for body, points, tree in zip(self.bodies, self.points, trees, strict=True)
            )
            self._rests = a, b
        return self._rests

    def _rest(self, body: Polyhedron, points: np.ndarray) -> np.ndarray:
        """(n, 3): of vertices."""
        if body.error == 0.0:
            return np.zeros(points.shape)
        ratios = [x.as_integer_ratio() for x in body.vertices.ravel().tolist()]
        off = [(x * q - p * self.scale) / (q * self.scale) for x, (p, q) in zip(points.flat, ratios, strict=True)]
        return np.array(off).reshape(points.shape)

    def corners(self, pairs: np.ndarray) -> tuple[list[Vector], list[Vector]]:
        """Those of both elements of pairs of one kind, each a vector of arrays."""
        a, b = (
            [tuple(points[corner].T) for corner in _vertices(body, *pairs[:, 1 + 2 * side : 3 + 2 * side].T)]
            for side, (points, body) in enumerate(zip(self.points, self.bodies, strict=True))
        )
        return a, b


def _vertices(body: Polyhedron, kind: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Corners (1, 2 or 3; n) of elements of one kind, as `vertices_of` has them."""
    if kind[0] == VERTEX:
        return index[None]
    if kind[0] == FACE:
        corners: np.ndarray = body.triangles[index].T
        return corners
    points = index - len(body.segments)
    ends: np.ndarray = np.where(points >= 0, points, body.segments[np.minimum(index, len(body.segments) - 1)].T)
    return ends


def _whole_velocities(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whole numbers (n, 3), and (n,) powers of two: vectors are these over the first, times the second."""
    fractions, exponents = np.frexp(vectors)
    exponents = np.where(fractions == 0.0, 2000, exponents)
    least = exponents.min(axis=1)
    numbers = (fractions * 2.0**53).astype(np.int64).astype(object)
    shifts = np.where(fractions == 0.0, 0, exponents - least[:, None]).astype(object)
    least = least - 53
    one = np.full(len(vectors), 1, object)
    return numbers << shifts, one << np.maximum(-least, 0).astype(object), one << np.maximum(least, 0).astype(object)


def _earliest(
    walked: Walked, some: np.ndarray, gaps: np.ndarray, speeds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(of some candidates the first of each motion, all that share the time; where those of each begin, and an end).

    Motions without one are OPEN: those whose times equations do not tell, or round to the start.
    """
    times = np.full(len(gaps), np.inf)
    solvable = speeds != 0
    times[solvable] = gaps[solvable] / speeds[solvable]
    motions = walked.motions[some]
    begin = np.flatnonzero(np.diff(motions, prepend=-1))
    if not len(begin):
        return np.empty(0, np.int64), np.zeros(1, np.int64)
    least = np.minimum.reduceat(times, begin)
    good = np.logical_and.reduceat(solvable, begin) & (least > 0.0)
    walked.told[motions[begin[~good]]] = OPEN
    group = np.repeat(np.arange(len(begin)), np.diff(begin, append=len(gaps)))
    first = np.flatnonzero((times == least[group]) & good[group])
    cuts = np.append(np.flatnonzero(np.diff(group[first], prepend=-1)), len(first))
    kept = np.ones(len(first), bool)
    for k in np.flatnonzero(np.diff(cuts) > 1).tolist():  # times that round to one double may differ
        some = first[cuts[k] : cuts[k + 1]]
        kept[cuts[k] : cuts[k + 1]] = np.isin(some, _exactly_first(some, gaps, speeds))
    first = first[kept]
    return first, np.append(np.flatnonzero(np.diff(group[first], prepend=-1)), len(first))


def _exactly_first(some: np.ndarray, gaps: np.ndarray, speeds: np.ndarray) -> list[int]:
    """Which of some candidates are first."""
    found: list[int] = []
    for k in some.tolist():
        later = 0 if not found else gaps[k] * speeds[found[0]] - gaps[found[0]] * speeds[k]
        if later < 0:
            found = []
        if later <= 0:
            found.append(k)
    return found


def _around(times: np.ndarray, gaps: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """(n, 2): enclosures of gap / speed by neighbouring doubles, one of which is its rounding."""
    ratios = [t.as_integer_ratio() for t in times.tolist()]
    sides = [(g * q > s * p) - (g * q < s * p) for g, s, (p, q) in zip(gaps, speeds, ratios, strict=True)]
    return _towards(times, np.array(sides, float))


def _towards(times: np.ndarray, side: np.ndarray) -> np.ndarray:
    """(n, 2): from each of the times to the next double on the side that is told by a sign."""
    towards = np.where(side == 0.0, times, np.where(side > 0.0, np.inf, -np.inf))
    return np.sort(np.stack([times, np.nextafter(times, towards)], axis=1), axis=1)


def is_moderate(vectors: np.ndarray) -> np.ndarray:
    """Which velocities are looked at as they are, none of their coordinates (but zeros) huge or tiny."""
    x, y, z = sizes = np.abs(vectors).T
    if sizes.size and 1e-30 < sizes.min() and sizes.max() < 1e30:  # as mostly, and at once
        return np.ones(len(vectors), bool)
    largest = np.maximum(np.maximum(x, y), z)
    told: np.ndarray = (largest > 1e-30) & (largest < 1e30)
    for size in (x, y, z):
        told &= (size == 0.0) | (size >= LEAST_FRAMED)
    return told
