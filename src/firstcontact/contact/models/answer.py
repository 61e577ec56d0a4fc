"""From meetings of features to the result users read: elements, points, contact sets, times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.leading import leads
from firstcontact.contact.models.algorithm import Candidate, CandidateSearch, Meeting, Root
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.normals import normal_at
from firstcontact.contact.models.shared.contact_sets import cartesian
from firstcontact.contact.models.shared.largest_set import largest_set
from firstcontact.contact.reduce import face_at
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.polynomial_matrix import Matrix
from firstcontact.exact.times.instants import enclose
from firstcontact.motion.moving import Moving
from firstcontact.result import (
    MOST_OTHERS,
    CandidateTime,
    ContactSet,
    Element,
    ElementPair,
    FirstContact,
    Status,
    Subproblem,
)
from firstcontact.search.trees.touch import carried_normal

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Model
    from firstcontact.work import QuestionFields

_ORDER = {"vertex": 0, "apex": 0, "edge": 1, "face": 2}
BITS = 128


def contact_of(
    search: CandidateSearch, meetings: Sequence[Meeting], exact: bool, shared: QuestionFields
) -> FirstContact:
    """The CONTACT result, the lowest (kind, index) of the simultaneous pairs first."""
    pair, root = search.pair, meetings[0].candidate.root
    named = ranked(pair, meetings, (shared["a"], shared["b"]))
    (lowest, meeting), *rest = named
    time, interval = world_time(pair, root)
    if (open_from := search.open_from()) is not None:  # narrower than any tolerance, but not decided
        interval = world_time(pair, AlgebraicRoot.of(open_from))[1][0], interval[1]
    where = cartesian(meeting.shared.at)
    return FirstContact(
        Status.CONTACT, time, interval,
        pair.piece.exact_time(root) if exact else None,
        to_world(pair, root, where[None], shared["b"], time)[0],
        _turned(pair, root, normal_at(pair, root, where, [m for _, m in named[:MOST_OTHERS]]), shared["b"], time),
        lowest.element_a, lowest.element_b,
        tuple(p for p, _ in rest[:MOST_OTHERS]), len(named),
        _contact_set(pair, root, meetings, shared["b"], time),
        free_until=interval[0],
        **shared,
    )  # fmt: skip


def _contact_set(pair: MovingPair, root: Root, meetings: Sequence[Meeting], b: Body, time: float) -> ContactSet:
    kind, points = largest_set(pair, root, meetings)
    return ContactSet(kind, to_world(pair, root, points, b, time))


def ranked(
    pair: MovingPair, meetings: Sequence[Meeting], bodies: tuple[Body, Body]
) -> list[tuple[ElementPair, Meeting]]:
    """Each pair of elements once, lowest first, by those of the body of the question that leads."""
    seen: dict[ElementPair, Meeting] = {}
    for meeting in meetings:
        task, where = meeting.candidate.subproblem, meeting.shared.points[0]
        in_a = _pose(pair.piece.pose, meeting.candidate.root)
        seen.setdefault(
            ElementPair(
                element(pair.a, task.a, "a", np.linalg.solve(in_a[:3, :3], where - in_a[:3, 3])),
                element(pair.b, task.b, "b", where),
            ),
            meeting,
        )
    a_leads = len(seen) < 2 or leads(*bodies)

    def order(item: tuple[ElementPair, Meeting]) -> tuple[int, ...]:
        ranks = rank(item[0].element_a), rank(item[0].element_b)
        return (*ranks[0], *ranks[1]) if a_leads else (*ranks[1], *ranks[0])

    return sorted(seen.items(), key=order)


def rank(x: Element) -> tuple[int, int]:
    """Vertices before edges before faces."""
    return _ORDER[x.kind], x.index


def element(
    body: CompositeQuadric, feature: Face | Edge | Vertex, which: str, where: np.ndarray | None = None
) -> Element:
    """The feature as users see it; of coplanar faces of a polyhedron the one that holds `where`, in its own frame.

    Of a cut model, that of the whole one.
    """
    if body.whole is not None:
        return element(body.whole, body.of_whole(feature), which, where)
    if body.source is not None:
        index = feature.index
        if isinstance(feature, Face) and where is not None:
            index = face_at(body.source, index, where)
        name = body.name or which
        return Element(type(feature).__name__.lower(), name, index, name)
    kind = "face" if isinstance(feature, Face) else "edge" if isinstance(feature, Edge) else "vertex"
    if isinstance(feature, Vertex) and feature.is_apex:
        kind = "apex"
    return Element(kind, body.name or which, feature.index, feature.name)


# -- times and frames -----------------------------------------------------------------------------------------


def world_time(pair: MovingPair, root: Root) -> tuple[float, tuple[float, float]]:
    """(nearest double, enclosure) of a root's time."""
    value = root.rational

    def number() -> arb:
        u = root.enclosure(ctx.prec) if value is None else arb(value)
        return pair.piece.time_of(u)

    if value is not None and type(pair.piece.clock).__name__ == "StraightClock":
        return enclose(lambda: value)
    return enclose(number)


def to_world(pair: MovingPair, root: Root, points: np.ndarray, b: Body, time: float) -> np.ndarray:
    """(n, 3) points of the frame of b in the world at the root."""
    pose = _pose_of_b(pair, root, b, time)
    moved: np.ndarray = points @ pose[:3, :3].T + pose[:3, 3]
    return moved


def _turned(pair: MovingPair, root: Root, n: np.ndarray | None, b: Body, time: float) -> np.ndarray | None:
    """A normal of the frame of b in the world."""
    return None if n is None else carried_normal(_pose_of_b(pair, root, b, time), n)


def _pose_of_b(pair: MovingPair, root: Root, b: Body, time: float) -> np.ndarray:
    frame = pair.piece.frame
    if frame is None:  # bodies that turn about one line at different speeds
        assert isinstance(b, Moving)
        pose: np.ndarray = b.motion(time)
        return pose
    return _pose(frame, root)


def _pose(matrix: Matrix, root: Root) -> np.ndarray:
    """(4, 4) doubles of a polynomial pose at the root."""
    u = root.enclosure(BITS)
    with precision(BITS):
        rows = [[x(u) for x in row] for row in matrix]
        return np.array([[float((x / rows[3][3]).mid()) for x in row] for row in rows])


# -- the list of subproblems ----------------------------------------------------------------------------------


def listed(searches: Sequence[CandidateSearch], b: Model) -> tuple[Subproblem, ...]:
    """Every pair of features with its candidate times over all pieces, judged."""
    rows: dict[tuple[Element, Element, str], list[CandidateTime]] = {}
    reasons: dict[tuple[Element, Element, str], str] = {}
    for search in searches:
        by_task: dict[int, list[Candidate]] = {}
        for candidate in search.candidates:
            by_task.setdefault(id(candidate.subproblem), []).append(candidate)
        for task in search.tasks:
            key = element(search.pair.a, task.a, "a"), element(search.pair.b, task.b, "b"), task.case
            reasons[key] = task.equation.reason if task.equation.candidates is None else ""
            rows.setdefault(key, []).extend(_judged(search, c, b) for c in by_task.get(id(task), []))
    return tuple(Subproblem(*key, tuple(found), reasons[key]) for key, found in rows.items())


def _judged(search: CandidateSearch, candidate: Candidate, b: Model) -> CandidateTime:
    meetings, reason = search.verdict(candidate)
    time, _ = world_time(search.pair, candidate.root)
    point = None
    if meetings:
        where = cartesian(meetings[0].shared.at)
        point = to_world(search.pair, candidate.root, where[None], b, time)[0]
    verdict = "contact" if meetings else "no contact"
    return CandidateTime(time, candidate.root.multiplicity, point, verdict, reason)
