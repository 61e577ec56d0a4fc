"""The normal of a contact of two models: of the pairs that meet at the point, of one that parts the bodies there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb

from firstcontact.body.solid.carriers import Plane
from firstcontact.body.solid.composite_quadric import SINGULAR
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.algorithm import Meeting, Root
from firstcontact.contact.models.moving_pair import Form, MovingPair, form_at, is_plane
from firstcontact.contact.models.shared.contact_sets import cartesian
from firstcontact.contact.models.shared.largest_set import NEAR
from firstcontact.exact.numbers import precision

BITS = 128
ALONG = 1e-6
"""Sine of the angle below which edges touch along each other: where they do, places are known to half the digits."""


def normal_at(pair: MovingPair, root: Root, where: np.ndarray, meetings: Sequence[Meeting]) -> np.ndarray | None:
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
    parting = (n for n in facing if is_in_cone(-n, cones[0]) and is_in_cone(n, cones[1]))
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


def is_in_cone(n: np.ndarray, ends: np.ndarray) -> bool:
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
