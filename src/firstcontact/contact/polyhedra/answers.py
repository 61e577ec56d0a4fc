"""From what the search proved to the result users read: elements, points, normals, times in the world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact.leading import leads
from firstcontact.contact.polyhedra.earliest import FoundFirst, Pair, Problem, Searched, Window, pairs_at_start
from firstcontact.contact.polyhedra.facing import NEAR, best_apart
from firstcontact.exact.numbers import PRECISIONS, Undecidable, precision
from firstcontact.exact.times.instants import Instant
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import MotionPiece
from firstcontact.result import MOST_OTHERS, ContactInterval, Element, ElementPair, FirstContact, Stats, Status
from firstcontact.search.trees.elements import EDGE, FACE, VERTEX, Feature
from firstcontact.search.trees.touch import carried_normal, doubles
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.work import QuestionFields

# Pairs at a contact whose normals are looked at.
MOST_NORMALS = 64
_NAMES = {VERTEX: "vertex", EDGE: "edge", FACE: "face"}


def _users(body: Body, found: Feature) -> Feature:
    """The element as users count: polygons instead of triangles, points instead of their stand-ins."""
    mesh: Polyhedron = shape_of(body)
    kind, index = found
    if kind == FACE:
        return FACE, int(mesh.triangle_face[index])
    if kind == EDGE and index >= len(mesh.segments):
        return VERTEX, index - len(mesh.segments)
    if kind == EDGE and index >= len(mesh.edges):  # a diagonal of a polygon belongs to its face
        triangle = int(np.argwhere(mesh.side_edge == index)[0, 0])
        return FACE, int(mesh.triangle_face[triangle])
    return found


def element_pairs(a: Body, b: Body, pairs: list[Pair]) -> list[tuple[ElementPair, Pair]]:
    """The pairs in users' terms with the search's own behind each, each once, lowest first.

    Of two triangles of one polygon the pair that comes first stands for it.  By the elements of the body that leads,
    then of the other one: so bodies given the other way round have the same pairs in the same order.
    """
    first, second = a.name or "a", b.name or "b"
    a_leads = len(pairs) < 2 or leads(a, b)

    def order(pair: Pair) -> tuple[Feature, Feature]:
        return (pair[1], pair[2]) if a_leads else (pair[2], pair[1])

    seen: dict[tuple[Feature, Feature], Pair] = {}
    for pair in sorted(pairs, key=order):
        seen.setdefault((_users(a, pair[1]), _users(b, pair[2])), pair)
    named = sorted(seen, key=lambda users: users if a_leads else users[::-1])
    return [(ElementPair(_named(first, x), _named(second, y)), seen[x, y]) for x, y in named]


def _named(name: str, element: Feature) -> Element:
    return Element(_NAMES[element[0]], name, element[1], name)


def contact_of(problem: Problem, found: FoundFirst, exact: bool, stats: Stats, shared: QuestionFields) -> FirstContact:
    """The CONTACT result of a search that found one; where and of what it is waits until it is asked for."""
    time, interval = problem.world_instant(found.instant)
    known = {
        "status": Status.CONTACT,
        "time": time,
        "time_interval": interval,
        "time_exact": problem.world_exact(found.instant) if exact else None,
        "initial": None,
        "free_until": interval[0],
        "reason": None,
        "stats": stats,
        "subproblems": (),
        **shared,
    }
    bodies = shared["a"], shared["b"]
    return FirstContact.deferring(known, lambda: _elements_met(problem, found, time, bodies))


def _elements_met(problem: Problem, found: FoundFirst, time: float, bodies: tuple[Body, Body]) -> dict[str, object]:
    """What a CONTACT result says of the elements; the place waits longer, many callers never ask."""
    named = element_pairs(*bodies, found.pairs)

    def place() -> dict[str, object]:
        point, normal = place_met(problem, found, time, bodies, [pair for _, pair in named])
        contact_set = "point" if len(named) == 1 and normal is not None else None
        return {"point": point, "normal": normal, "contact_set": contact_set}

    return {
        "element_a": named[0][0].element_a,
        "element_b": named[0][0].element_b,
        "others": tuple(p for p, _ in named[1 : 1 + MOST_OTHERS]),
        "multiplicity": len(named),
        "_rest": place,
    }


def place_met(
    problem: Problem, found: FoundFirst, time: float, bodies: tuple[Body, Body], pairs: list[Pair]
) -> tuple[np.ndarray, np.ndarray | None]:
    """Point and normal of a contact of those pairs, the one that is named first."""
    point, normal = _place(problem, pairs[0], found.instant, time)
    if len(pairs) > 1 and normal is not None and problem.is_exact:
        met = pairs[:MOST_NORMALS]
        normals = _normals_at(problem, point, normal, met[1:], found.instant, time)
        normal = best_apart(*bodies, time, met, point, normals)
    return point, normal


def _normals_at(
    problem: Problem, point: np.ndarray, normal: np.ndarray, others: list[Pair], instant: Instant | None, time: float
) -> Iterator[np.ndarray]:
    """The normal at a place, then those of other pairs that meet there."""
    yield normal
    for pair in others:
        place, n = _place(problem, pair, instant, time)
        if n is not None and np.allclose(place, point, NEAR, NEAR * float(np.abs(point).max())):
            yield n


def contained_at_start(
    problem: Problem, exact: bool, stats: Stats, shared: QuestionFields, jump: bool = False
) -> FirstContact:
    """The result for bodies one of which lies inside the other at the start; `jump`: that of a later step."""
    start, interval = problem.world_instant(problem.start_instant())
    return FirstContact(
        Status.CONTACT if jump else Status.INITIAL_CONTACT,
        start,
        interval if jump else (start, start),
        problem.world_exact(problem.start_instant()) if exact else None,
        initial=None if jump else "containment",
        free_until=interval[0] if jump else start,
        stats=stats,
        **shared,
    )


def initial_contact(
    problem: Searched,
    found: FoundFirst,
    kind: str | None,
    exact: bool,
    stats: Stats,
    shared: QuestionFields,
    jump: bool = False,
) -> FirstContact:
    """The INITIAL_CONTACT result: the surfaces share a point at the start of the span.

    jump: they do when the body jumps to the start of a later step, which is a CONTACT at that time.
    """
    start, interval = problem.world_instant(problem.start_instant())
    if not jump:
        start = shared["span"][0]
        interval = start, start
    known = {
        "status": Status.CONTACT if jump else Status.INITIAL_CONTACT,
        "time": start,
        "time_interval": interval,
        "time_exact": problem.world_exact(problem.start_instant()) if exact else None,
        "initial": kind,
        "free_until": interval[0],
        "reason": None,
        "stats": stats,
        "subproblems": (),
        **shared,
    }
    return FirstContact.deferring(known, lambda: _where_at_start(problem, found, shared))


def _where_at_start(problem: Searched, found: FoundFirst, shared: QuestionFields) -> dict[str, object]:
    """What a result says of the elements that meet at the start: all of them, which the search has not looked for."""
    pairs = _pairs_at_start(problem) or [pair for pair, _ in found.start] or found.pairs
    named = element_pairs(shared["a"], shared["b"], pairs)
    lowest, pair = named[0]
    return {
        "point": _start_point(problem, pair),
        "normal": None,
        "element_a": lowest.element_a,
        "element_b": lowest.element_b,
        "others": tuple(p for p, _ in named[1 : 1 + MOST_OTHERS]),
        "multiplicity": len(named),
        "contact_set": None,
    }


def _pairs_at_start(problem: Searched) -> list[Pair]:
    """All pairs of an edge and a face that share a point at the start; none where some are left open."""
    try:
        return [pair for pair, _ in pairs_at_start(problem)]
    except Undecidable:
        return []


@dataclass(frozen=True, slots=True)
class JoinedInterval:
    """A window of contact, its ends each in the clock of the piece that holds it: (problem, instant, turn)."""

    start: tuple[Problem, Instant, int]
    end: tuple[Problem, Instant | None, int]

    def at_start(self, piece: MotionPiece | CurvedPiece) -> bool:
        """Whether it begins with that piece."""
        problem, instant, turn = self.start
        return problem.piece is piece and turn == 0 and instant.is_zero()


def join(out: list[JoinedInterval], problem: Problem, windows: list[Window], work: Work) -> None:
    """Append the next piece's windows to the intervals; contact at the joint of two pieces goes on.

    Raises Spent: what a rotation meets again in further turns counts as work.
    """
    for start, turn, end, last in problem.repeated(windows):
        if turn:
            if work.left == 0:
                work.free_until = problem.world_instant(start, turn)[1][0]
            work.step()
        if out and turn == 0 and start.is_zero() and _ends_before(out[-1], problem):
            out[-1] = JoinedInterval(out[-1].start, (problem, end, last))
        else:
            out.append(JoinedInterval((problem, start, turn), (problem, end, last)))


def _ends_before(interval: JoinedInterval, following: Problem) -> bool:
    """Whether it ends with its piece, and the piece of the following problem is the next one."""
    problem, instant, turn = interval.end
    return problem.is_end(instant, turn) and problem.piece.end == following.piece.start


def interval_of(joined: JoinedInterval, exact: bool) -> ContactInterval:
    (problem, start, turn), (problem_end, end, turn_end) = joined.start, joined.end
    t0, lo = problem.world_instant(start, turn)
    t1, hi = problem_end.world_instant(end, turn_end)
    return ContactInterval(
        t0,
        t1,
        lo,
        hi,
        problem.world_exact(start, turn) if exact else None,
        problem_end.world_exact(end, turn_end) if exact else None,
    )


def _start_point(problem: Searched, pair: Pair) -> np.ndarray | None:
    with precision(PRECISIONS[0]):
        try:
            return doubles(problem.start_point(pair[1], pair[2]))
        except Undecidable:
            return None


def _place(problem: Problem, pair: Pair, instant: Instant | None, time: float) -> tuple[np.ndarray, np.ndarray | None]:
    """Contact point and unit normal (from b towards a) in the world."""
    point, normal = problem.touch(pair[1], pair[2], instant)
    pose = problem.piece.carry(time)
    if pose is not None:
        point = pose[:3, :3] @ point + pose[:3, 3]
        normal = None if normal is None else carried_normal(pose, normal)
    return point, normal
