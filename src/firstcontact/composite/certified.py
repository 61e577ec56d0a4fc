"""First contact of convex models, and of unions of them, in doubles with proofs: the answer of `search.advance`.

What it cannot settle (grazes, contact at the start, models with holes) is left to exact arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from flint import fmpq

from firstcontact.body import primitives
from firstcontact.body.carriers import Line, Plane, Quadric
from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.body.features import Edge, Face, Vertex
from firstcontact.body.moving import Moving
from firstcontact.composite.answer import element, rank
from firstcontact.exact.numbers import to_double
from firstcontact.result import ContactSet, Element, FirstContact, Stats, Status
from firstcontact.search.advance import Advance, advance

LARGEST = 2.0**60
"""Coordinates up to which an unbounded model is cut."""
ACROSS = 1e-6
"""Sine of the angle below which directions count as parallel: what is flat there may be shared in more than a point,
which exact arithmetic then decides."""


def settle(
    models: tuple[Any, Any], first: fmpq, last: fmpq, tolerance: float, budget: int | None, shared: dict[str, Any]
) -> tuple[FirstContact | None, Advance]:
    """(the answer, None where it is left to exact arithmetic; what was proved).

    models: both, at rest or moving.  Among features that touch at the same time the answer names one pair.
    """
    models = _bounded(models[0], models[1], shared["span"]), _bounded(models[1], models[0], shared["span"])
    found = advance(*models, first, last, tolerance, 10_000 if budget is None else budget)
    stats = Stats(found.steps, found.gaps, 0, 0)
    if found.status == "free":
        return FirstContact(Status.FREE, free_until=shared["span"][1], stats=stats, **shared), found
    if found.status != "contact" or found.normal is None:
        return None, found
    answer = contact(models, found, stats, shared)
    return (None if answer is None or answer.contact_set is None else answer), found


def _bounded(body: Any, other: Any, span: tuple[float, float]) -> Any:
    """A resting unbounded model cut to a cube around the other body's whole path: nothing is touched beyond.

    The cube comes in powers of two, so that other motions find the cut model again.
    """
    if isinstance(body, Moving) or body.bounded:
        return body
    lo, hi = other.bounds(span)
    reach = float(max(np.abs(lo).max(), np.abs(hi).max()))
    if not reach < LARGEST:
        return body
    size = math.frexp(reach)[1] + 1
    cut = body._search.setdefault("cut", {})
    if size not in cut:
        cube = primitives.box((2 ** (size + 1),) * 3) if size > 0 else primitives.box((4, 4, 4))
        cut[size] = body & cube
        cut[size].whole = body
    return cut[size]


def contact(models: tuple[Any, Any], found: Advance, stats: Stats, shared: dict[str, Any]) -> FirstContact | None:
    """The CONTACT result; contact_set None where flat features may share more than a point."""
    assert found.time is not None and found.time_interval is not None and found.point is not None
    side_a = _touched(models[0], found.features_a, found, "a")
    side_b = _touched(models[1], found.features_b, found, "b")
    if side_a is None or side_b is None:
        return None
    (element_a, flat_a), (element_b, flat_b) = side_a, side_b
    return FirstContact(
        Status.CONTACT, found.time, found.time_interval,
        point=found.point, normal=found.normal, element_a=element_a, element_b=element_b, multiplicity=1,
        contact_set=None if _may_share_more(flat_a, flat_b) else ContactSet("point", found.point[None]),
        free_until=found.time_interval[0], stats=stats, **shared,
    )  # fmt: skip


Flat = np.ndarray | str
"""The direction of a line in a body's surface at the contact, across the normal; "plane" for a plane face."""


def _touched(body: Any, features: Any, found: Advance, which: str) -> tuple[Element, list[Flat]] | None:
    """The lowest of the touched features, and what is flat around the contact."""
    model: Any = body.body if isinstance(body, Moving) else body
    pose = body.motion(found.time) if isinstance(body, Moving) else np.eye(4)
    assert found.point is not None and found.normal is not None
    where, n = np.linalg.solve(pose[:3, :3], found.point - pose[:3, 3]), pose[:3, :3].T @ found.normal
    touched = [_feature(model, kind, index, where) for kind, index in features]
    model = model.whole or model
    if not touched:
        return None
    flats = [pose[:3, :3] @ f if isinstance(f, np.ndarray) else f for x in touched for f in _flats(model, x, where, n)]
    return min((element(model, x, which, where) for x in touched), key=rank), flats


def _feature(model: CompositeQuadric, kind: str, index: int, where: np.ndarray) -> Face | Edge | Vertex:
    """The feature of that number; of a cut model, the feature of the whole one on the same surfaces."""
    found = _numbered(model, kind, index, where)
    if model.whole is None:
        return found
    carriers = {model.surfaces[k] for k in found.surfaces}
    of_kind: Any = {"face": model.whole.faces, "edge": model.whole.edges, "vertex": model.whole.vertices}[kind]
    return next(f for f in of_kind if carriers <= {model.whole.surfaces[k] for k in f.surfaces})


def _numbered(model: CompositeQuadric, kind: str, index: int, where: np.ndarray) -> Face | Edge | Vertex:
    if kind == "vertex":  # the nearest: the fast path numbers corners of pieces, not of the model
        return min(model.vertices, key=lambda v: float(np.abs(np.array(v.position) - where).max()))
    of_kind: Any = model.faces if kind == "face" else model.edges
    return next(f for f in of_kind if f.index == index)


def _flats(model: CompositeQuadric, feature: Face | Edge | Vertex, where: np.ndarray, n: np.ndarray) -> Iterator[Flat]:
    """Lines and planes across the normal in the faces and edges that meet in the feature."""
    around = set(feature.surfaces)
    for face in model.faces if not isinstance(feature, Face) else (feature,):
        if not around & set(face.surfaces):
            continue
        form = _form(face.carrier)
        gradient = form @ np.append(where, 1.0)
        if np.linalg.norm(np.cross(gradient[:3], n)) > ACROSS * np.linalg.norm(gradient[:3]) * np.linalg.norm(n):
            continue
        if isinstance(face.carrier, Plane):
            yield "plane"
        elif (ruling := _ruling(form, where)) is not None:
            yield ruling
    for edge in model.edges if not isinstance(feature, Face) else ():
        if set(edge.surfaces) <= around and isinstance(edge.carrier, Line):
            direction = edge.frame[:3, 0]
            if abs(direction @ n) <= ACROSS * np.linalg.norm(direction) * np.linalg.norm(n):
                yield direction


def _form(carrier: Plane | Quadric) -> np.ndarray:
    """The symmetric matrix of a surface, its largest entry 1."""
    rows = carrier.matrix()
    largest = max(abs(x) for row in rows for x in row)
    return np.array([[to_double(x / largest) for x in row] for row in rows])


def _ruling(form: np.ndarray, where: np.ndarray) -> np.ndarray | None:
    """The direction of the line of a cone or cylinder through the point; None for other quadrics."""
    values, vectors = np.linalg.eigh(form)
    k = int(np.argmin(np.abs(values)))
    if abs(values[k]) > 1e-12 * np.abs(values).max():
        return None
    apex = vectors[:, k]
    return apex[:3] - where * apex[3]


def _may_share_more(a: list[Flat], b: list[Flat]) -> bool:
    return any(
        isinstance(x, str) or isinstance(y, str)
        or np.linalg.norm(np.cross(x, y)) <= ACROSS * np.linalg.norm(x) * np.linalg.norm(y)
        for x in a for y in b
    )  # fmt: skip
