"""The verbs."""

from __future__ import annotations

import time as clock
from typing import Any

import numpy as np

from firstcontact.body.moving import Moving
from firstcontact.body.polyhedron import Polyhedron
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import Undecidable, rational, to_double
from firstcontact.motion.relative import Piece, pieces
from firstcontact.report import contact_of, initial_contact
from firstcontact.result import FirstContact, Stats, Status
from firstcontact.search.containment import contained
from firstcontact.search.earliest import Found, Progress, earliest
from firstcontact.search.problem import problem_of


def first_contact(
    a: Any,
    b: Any,
    span: Any = None,
    *,
    exact: bool = False,
    method: str = "auto",
    engine: str = "auto",
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Progress | None = None,
) -> FirstContact:
    """FirstContact at the earliest time in the closed span at which a and b share a point.

    a, b: Polyhedron (at rest) or ``body.moving(motion)``.  span: (first, last) in the motions' clock, default
    the motions' own; ``inf`` as last for translations.  Contact is between closed sets: grazing counts, solids own
    their interior.  Status.FREE proves that they share no point at any time of the span.

    exact: add `time_exact`.  tolerance: largest width of `time_interval`, relative to the span.
    budget: node visits plus pair tests after which to answer UNDECIDED.  progress: called with
    (free until, work) now and then.

    Raises UnsupportedPair where the relative motion is neither translations nor rotations about fixed axes.

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((2, 2, 2))
    >>> hit = fc.first_contact(cube.moving(fc.Translation((0, 0, 6))), cube.translated((0.5, 0.5, 5)))
    >>> hit.time, hit.point.tolist()
    (0.5, [-0.5, -0.5, 4.0])
    """
    begin = clock.perf_counter()
    _check(a, b, method, engine, tolerance, budget)
    parts, first, last = pieces(a, b, span)
    stats = Stats()
    window = (to_double(first), float("inf") if last is None else to_double(last))
    shared = {"a": a, "b": b, "span": window}
    for k, piece in enumerate(parts):
        problem = problem_of(a, b, piece)
        left = None if budget is None else max(0, budget - int(stats.node_visits + stats.pair_tests))
        found = earliest(problem, left, progress, with_start=k == 0)
        stats += Stats(found.visits, found.tests, found.unsure, found.exact)
        if found.open is not None:
            return _undecided(found.open, problem.world_time(found.free_until), stats, begin, shared)
        at_start = k == 0 and (found.start or _starts_at_once(found))
        if at_start:
            return initial_contact(problem, found, _timed(stats, begin), shared)
        if k == 0:
            try:
                inner = contained(problem.a, problem.b)
            except Undecidable:
                return _undecided("precision", window[0], stats, begin, shared)
            if inner is not None:
                return FirstContact(
                    Status.INITIAL_CONTACT, window[0], (window[0], window[0]), initial="containment",
                    stats=_timed(stats, begin), **shared,
                )  # fmt: skip
        if found.instant is not None:
            return contact_of(problem, found, exact, _timed(stats, begin), shared)
    return FirstContact(Status.FREE, free_until=window[1], stats=_timed(stats, begin), **shared)


def _starts_at_once(found: Found) -> bool:
    return found.instant is not None and found.instant.is_zero()


def _undecided(reason: str, free_until: float, stats: Stats, begin: float, shared: dict[str, Any]) -> FirstContact:
    return FirstContact(
        Status.UNDECIDED, free_until=free_until, reason=reason, stats=_timed(stats, begin), **shared
    )


def _timed(stats: Stats, begin: float) -> Stats:
    return stats + Stats(seconds=clock.perf_counter() - begin)


METHODS = ("auto", "certified", "algebraic")
ENGINES = ("auto", "boxes")


def _check(a: Any, b: Any, method: str, engine: str, tolerance: float, budget: int | None) -> None:
    for body in (a, b):
        if not isinstance(body.body if isinstance(body, Moving) else body, Polyhedron):
            raise UnsupportedPair(f"{body!r} is no Polyhedron; only polyhedra are supported")
    if method not in METHODS:
        raise UnsupportedPair(f"method {method!r} is unknown; choose one of {', '.join(METHODS)}")
    if engine not in ENGINES:
        raise UnsupportedPair(f"engine {engine!r} is unknown; choose one of {', '.join(ENGINES)}")
    if not tolerance > 0:
        raise InputError(f"tolerance is {tolerance}; give a positive number")
    if budget is not None and (not isinstance(budget, int) or budget < 0):
        raise InputError(f"budget is {budget!r}; give a whole number of node visits and pair tests")
