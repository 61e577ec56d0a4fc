"""From meetings of features to the result users read: elements, points, normals, contact sets, times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

from firstcontact.body.solid.carriers import Plane
from firstcontact.body.solid.composite_quadric import SINGULAR, CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.leading import leads
from firstcontact.contact.models.algorithm import Candidate, CandidateSearch, Meeting, Root
from firstcontact.contact.models.moving_pair import Form, MovingPair, form_at, is_plane
from firstcontact.contact.models.shared.contact_sets import cartesian
from firstcontact.contact.models.shared.largest_set import NEAR, largest_set
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
ALONG = 1e-6
"""Sine of the angle below which edges touch along each other: where they do, places are known to half the digits."""


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
        _turned(pair, root, _normal_at(pair, root, where, [m for _, m in named[:MOST_OTHERS]]), shared["b"], time),
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


# -- normals --------------------------------------------------------------------------------------------------


def _normal_at(pair: MovingPair, root: Root, where: np.ndarray, meetings: Sequence[Meeting]) -> np.ndarray | None:
    """The normal of the first meeting there: along curves it changes from point to point.

    Where the first has none, that of another one that meets at the same point, or is in a plane through it.  A normal
    that parts the bodies there is taken before others, one that they do not move along before what is left.
    """
    near = NEAR * (pair.unit + float(np.abs(where).max()))
    here: list[tuple[np.ndarray, Meeting]] = []
    for k, meeting in enumerate(meetings):
        own = where if k == 0 else cartesian(meeting.shared.at)
        n = _normal(meeting, own)
        if n is None:
            continue
        if np.abs(where - own).max() <= near or (_is_flat(meeting) and abs(float(n @ (where - own))) <= near):
            here.append((n, meeting))
    normals = _different([n for n, _ in here])
    if len(normals) < 2:
        return normals[0] if normals else None
    way, cones = _way(pair, root, where), _cones(root, where, [meeting for _, meeting in here])
    facing = [n for n in normals if float(n @ way) <= NEAR * float(np.linalg.norm(way))]
    parting = (n for n in facing if _is_in_cone(-n, cones[0]) and _is_in_cone(n, cones[1]))
    return next(parting, facing[0] if facing else normals[0])


def _different(vectors: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Unit vectors, each once, in their order."""
    found: list[np.ndarray] = []
    for n in vectors:
        if n.any() and all(np.abs(n - other).max() > ALONG for other in found):
            found.append(n)
    return found


def _cones(root: Root, where: np.ndarray, meetings: Sequence[Meeting]) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) outward normals of a, and of b, of all faces beside the features that meet there."""
    tasks = [meeting.candidate.subproblem for meeting in meetings]
    of_a = [n for x in tasks for n in _outward(x.pair, x.a, True, root, where)]
    of_b = [n for x in tasks for n in _outward(x.pair, x.b, False, root, where)]
    return np.array(_different(of_a)).reshape(-1, 3), np.array(_different(of_b)).reshape(-1, 3)


def _is_in_cone(n: np.ndarray, ends: np.ndarray) -> bool:
    """Whether a unit vector is a sum of non-negative multiples of unit vectors ends (k, 3).

    C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, algorithm NNLS.
    """
    shares, used = np.zeros(len(ends)), np.zeros(len(ends), bool)
    for _ in range(3 * len(ends)):
        away = n - shares @ ends
        slopes = np.where(used, 0.0, ends @ away)
        if slopes.max() <= ALONG:
            break
        used[int(np.argmax(slopes))] = True
        while True:
            wanted = np.zeros(len(ends))
            wanted[used] = np.linalg.lstsq(ends[used].T, n, rcond=None)[0]
            below = used & (wanted <= 0.0)
            if not below.any():
                shares = wanted
                break
            part = float((shares[below] / np.maximum(shares[below] - wanted[below], 1e-300)).min())
            shares = shares + part * (wanted - shares)
            used &= shares > 1e-15
    return len(ends) > 0 and float(np.linalg.norm(n - shares @ ends)) <= ALONG


def _way(pair: MovingPair, root: Root, where: np.ndarray) -> np.ndarray:
    """Along which the point of a that is there moves, in the frame of b, of any length."""
    u = root.enclosure(BITS)
    with precision(BITS):
        pose, slope = (
            np.array([[float(arb(x(u)).mid()) for x in row] for row in m])
            for m in (pair.piece.pose, [[x.derivative() for x in row] for row in pair.piece.pose])
        )
    point = np.linalg.solve(pose, np.append(where, 1.0))
    at, rate = pose @ point, slope @ point
    way: np.ndarray = at[3] * rate[:3] - rate[3] * at[:3]
    return way


def _is_flat(meeting: Meeting) -> bool:
    task = meeting.candidate.subproblem
    return any(isinstance(x, Face) and isinstance(x.carrier, Plane) for x in (task.a, task.b))


def _normal(meeting: Meeting, where: np.ndarray) -> np.ndarray | None:
    """Unit normal from b towards a in the frame of b, in doubles; None where no plane separates the features.

    A face decides by its gradient; two edges by their tangents, on the side of the faces beside them; edges that touch
    along each other by the normals that both have.
    """
    task, root = meeting.candidate.subproblem, meeting.candidate.root
    outward_a = _outward(task.pair, task.a, True, root, where)
    outward_b = _outward(task.pair, task.b, False, root, where)
    if isinstance(task.b, Face):
        return _unit(outward_b[0])
    if isinstance(task.a, Face):
        return _unit(-outward_a[0])
    if not (isinstance(task.a, Edge) and isinstance(task.b, Edge)):
        return None
    along_a = _tangent(task.pair.forms_a, task.a, outward_a, root, where)
    along_b = _tangent(task.pair.forms_b, task.b, outward_b, root, where)
    if along_a is None or along_b is None:
        return None
    n = np.cross(along_a, along_b)
    if np.linalg.norm(n) <= ALONG * np.linalg.norm(along_a) * np.linalg.norm(along_b):
        return _in_both_cones(outward_b, [-x for x in outward_a])
    n = n / np.linalg.norm(n)
    way = float(n @ (sum(outward_b, np.zeros(3)) - sum(outward_a, np.zeros(3))))
    return None if abs(way) < 1e-9 else n * np.sign(way)


def _in_both_cones(of_b: list[np.ndarray], of_a: list[np.ndarray]) -> np.ndarray | None:
    """The middle of what two plane cones, each between two unit vectors, have in common; None where that is nothing."""
    if len(of_b) != 2 or len(of_a) != 2:
        return None
    ends: list[np.ndarray] = []
    for cone, other in ((of_b, of_a), (of_a, of_b)):
        for n in cone:
            shares, *_ = np.linalg.lstsq(np.column_stack(other), n, rcond=None)
            if np.all(shares >= -ALONG) and all(np.abs(n - end).max() > ALONG for end in ends):
                ends.append(n)
    return _unit(sum(ends, np.zeros(3)))


def _tangent(
    forms: Sequence[Form], edge: Edge, outward: list[np.ndarray], root: Root, where: np.ndarray
) -> np.ndarray | None:
    """A tangent of an edge, by two surfaces that hold it; None for the rim of a surface without inside."""
    if len(outward) >= 2:
        one, other = outward[:2]
    elif not outward:  # a bare edge: both sides of one plane, then both of another one
        one, other = (_gradient(forms[k], root, where) for k in edge.surfaces[::2])
    else:
        return None
    return np.cross(one, other)


def _outward(
    pair: MovingPair, feature: Face | Edge | Vertex, moving: bool, root: Root, where: np.ndarray
) -> list[np.ndarray]:
    """Outward unit normals of the faces that hold the feature, at a point of it."""
    body, forms = (pair.a, pair.forms_a) if moving else (pair.b, pair.forms_b)
    faces = [feature] if isinstance(feature, Face) else [body.faces[k] for k in getattr(feature, "faces", ())]
    found = []
    for face in faces:
        unit = _unit(_gradient(forms[face.surfaces[0]], root, where) * face.orientation)
        found.append(np.zeros(3) if unit is None else unit)
    return found


def _gradient(form: Form, root: Root, where: np.ndarray) -> np.ndarray:
    """Of the surface where it stands at the root, at a point of it, to a positive factor; 0 at a cone's tip."""
    u, x = root.enclosure(BITS), np.append(where, 1.0)
    with precision(BITS):
        at = form_at(form, u)
        if is_plane(form):
            return np.array([float(c.mid()) for c in at[:3]])
        terms = [[r * arb(c) for r, c in zip(row, x, strict=True)] for row in at[:3]]
        found = np.array([float(sum(row, arb(0)).mid()) for row in terms])
        size = max(float(abs(c).mid()) for row in terms for c in row)
    return found if np.abs(found).max() > SINGULAR * size else np.zeros(3)


def _unit(v: np.ndarray) -> np.ndarray | None:
    largest = np.abs(v).max()
    if not largest > 0:
        return None
    v = v / largest
    unit: np.ndarray = v / np.linalg.norm(v)
    return unit


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
