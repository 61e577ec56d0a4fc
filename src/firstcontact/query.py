"""The verbs."""

from __future__ import annotations

import math
import time as clock
from functools import cache
from numbers import Real
from typing import TYPE_CHECKING, Any

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.answers import (
    JoinedInterval,
    contact_of,
    contained_at_start,
    element_pairs,
    initial_contact,
    interval_of,
    join,
)
from firstcontact.contact.polyhedra.earliest import Found, Pair, all_pairs, earliest
from firstcontact.contact.polyhedra.intervals import contact_windows
from firstcontact.contact.polyhedra.overlap import initial_kind
from firstcontact.contact.polyhedra.problem import problem_of, problems_in_order
from firstcontact.errors import FirstContactError, InputError, UnsupportedPair
from firstcontact.exact.numbers import Undecidable, to_double
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import pieces
from firstcontact.motion.span import common_span
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact, Stats, Status
from firstcontact.work import Progress

NO_WORK = Stats()

if TYPE_CHECKING:
    from firstcontact.result_curve import IntersectionCurve


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
    threads: int = 1,
) -> FirstContact:
    """FirstContact at the earliest time in the closed span at which a and b share a point.

    a, b: Polyhedron (at rest) or ``body.moving(motion)``.  span: (first, last) in the motions' clock, default
    the motions' own; ``inf`` as last for translations.  Contact is between closed sets: grazing counts, solids own
    their interior.  Status.FREE proves that they share no point at any time of the span.

    engine: of polyhedra, which trees are asked; the answer is the same.  "boxes"; "lifted", for scenes in which nearly
    everything passes nearly everything; "auto" begins with boxes and changes over to "lifted" when boxes have had
    enough pair tests; "composed" is the paper's structure among edges and "sweep" its plane sweep among vertices and
    facets, for reading and measuring.  All but boxes are for translations and rotations only.  `stats.engine` tells
    which one answered.
    exact: add `time_exact`.  tolerance: largest width of `time_interval`, relative to the span (enclosures
    come out a few units in the last place wide, whatever is asked).
    budget: node visits plus pair tests (curved models: strides, subproblems and candidates) after which to answer
    UNDECIDED.  progress: called with (free until, work) now and then.
    threads: how many share the queries of "composed" and the groups of "sweep"; other engines take one.  The answer is
    the same, bit for bit.

    Raises UnsupportedPair with exact=True where times have no exact form, as under screws (docs/motions.md).

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((2, 2, 2))
    >>> hit = fc.first_contact(cube.moving(fc.Translation((0, 0, 6))), cube.translated((0.5, 0.5, 5)))
    >>> hit.time, hit.point.tolist()
    (0.5, [1.0, 1.0, 4.0])
    """
    begin = clock.perf_counter()
    bodies = _check(a, b, method, engine, tolerance, budget)
    if not isinstance(threads, int) or threads < 1:
        raise InputError(f"threads is {threads!r}; give a whole number from 1 on")
    if bodies != "polyhedra" and engine != "auto":
        raise UnsupportedPair(f"engine {engine!r} searches trees of polyhedra; curved models take 'auto'")
    if bodies != "polyhedra":
        search = _of_curved(bodies).first_contact
        if not _is_endless(a, b, span):
            return search(a, b, span, exact, method, tolerance, budget, progress)

        def ask(within: Any, narrow: float) -> FirstContact:
            return search(a, b, within, exact, method, narrow, budget, progress)

        from firstcontact.contact import endless

        return endless.first_contact(ask, a, b, span, tolerance)
    parts, first, last = pieces(a, b, span)
    if exact:
        _refuse_inexact(parts)
    if engine not in ("auto", "boxes") and any(isinstance(piece, CurvedPiece) for piece in parts):
        raise UnsupportedPair(f"engine {engine!r} searches translations and rotations; other motions take 'auto'")
    stats = NO_WORK
    window = (to_double(first), math.inf if last is None else to_double(last))
    shared = {"a": a, "b": b, "span": window}
    for k, (problem, with_start) in enumerate(problems_in_order(a, b, parts, engine, threads)):
        left = None if budget is None else max(0, budget - int(stats.node_visits + stats.pair_tests))
        found = earliest(problem, left, progress, with_start=with_start)
        stats = _added(stats, found)
        if found.open is not None:
            return _undecided(found.open, problem.world_time(found.free_until), stats, begin, shared)
        if found.start or (k == 0 and _starts_at_once(found)):
            try:
                kind = initial_kind(problem, found) if k == 0 else None
            except Undecidable:
                kind = None
            return initial_contact(problem, found, kind, exact, _timed(stats, begin), shared, jump=k > 0)
        if with_start:
            try:
                inside = problem.is_contained()
            except Undecidable:
                return _undecided("precision", window[0], stats, begin, shared)
            if inside:
                return contained_at_start(problem, exact, _timed(stats, begin), shared, jump=k > 0)
        if found.instant is not None:
            return contact_of(problem, found, exact, _timed(stats, begin), shared)
    return FirstContact(Status.FREE, free_until=window[1], stats=_timed(stats, begin), **shared)


def contact_intervals(
    a: Any,
    b: Any,
    span: Any = None,
    *,
    exact: bool = False,
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Progress | None = None,
) -> ContactIntervals:
    """All closed times of the span at which a and b share a point, as disjoint intervals; exact ends.

    Arguments as in `first_contact`.  The cost grows with the number of element pairs that meet near the ends of
    the intervals.  Status.FREE proves that there are none.

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((1, 1, 1))
    >>> print(fc.contact_intervals(cube.moving(fc.Translation((8, 0, 0))), cube.translated((3, 0, 0))))
    box and box: CONTACT
      [0.25, 0.5]
    """
    begin = clock.perf_counter()
    kind = _check(a, b, "auto", "auto", tolerance, budget)
    if kind != "polyhedra":
        search = _of_curved(kind).contact_intervals

        def ask(within: Any, narrow: float) -> ContactIntervals:
            return search(a, b, within, exact, budget, progress, narrow)

        if _is_endless(a, b, span):
            from firstcontact.contact import endless

            return endless.contact_intervals(ask, a, b, span, tolerance)
        return ask(span, tolerance)
    parts, first, last = pieces(a, b, span)
    if exact:
        _refuse_inexact(parts)
    stats = NO_WORK
    window = (to_double(first), math.inf if last is None else to_double(last))
    shared = {"a": a, "b": b, "span": window}
    ends: list[JoinedInterval] = []
    for piece in parts:
        problem = problem_of(a, b, piece)
        left = None if budget is None else max(0, budget - int(stats.node_visits + stats.pair_tests))
        found = contact_windows(problem, left, progress)
        stats = _added(stats, found)
        if found.open is not None:
            until = to_double(piece.start)
            if found.open == "precision":  # where a first contact is easier to tell than all windows
                rest = first_contact(a, b, (piece.start, math.inf if last is None else last), progress=progress)
                if rest.status is Status.FREE:
                    break
                until = max(until, rest.free_until or until)
            intervals = tuple(interval_of(e, exact) for e in ends)
            return ContactIntervals(
                intervals, Status.UNDECIDED, until, found.open, _timed(stats, begin), **shared
            )
        ends = join(ends, problem, found.windows)
    intervals = tuple(interval_of(e, exact) for e in ends)
    status = Status.FREE if not ends else Status.INITIAL_CONTACT if ends[0].at_start(parts[0]) else Status.CONTACT
    until = window[1] if not ends else intervals[0].start
    return ContactIntervals(intervals, status, until, None, _timed(stats, begin), **shared)


def contact_pairs(a: Any, b: Any, span: Any = None) -> ContactPairs:
    """All element pairs (vertex/face, edge/edge, face/vertex) that meet during the span.

    Arguments as in `first_contact`; diagonals inside polygons count as their faces.  Where many pairs pass each other
    and few meet, those that do are reported by the paper's range searching instead of tested one by one.

    >>> import firstcontact as fc
    >>> rod = fc.Polyhedron([[-1, 0, 0], [1, 0, 0]], [], edges=[[0, 1]])
    >>> print(fc.contact_pairs(rod.moving(fc.Translation((0, 0, 2))), rod.rotated((0, 0, 1), degrees=90)))
    1 element pairs meet, 0 pierced at the start
    """
    begin = clock.perf_counter()
    if _check(a, b, "auto", "auto", 1.0, None) != "polyhedra":
        raise UnsupportedPair("contact_pairs is for polyhedra; first_contact(..., method='algebraic') lists features")
    parts, _, _ = pieces(a, b, span)
    stats = NO_WORK
    met: list[Pair] = []
    pierced: list[Pair] = []
    for problem, with_start in problems_in_order(a, b, parts, "auto"):
        found = all_pairs(problem, with_start=with_start)
        if found.open is not None:
            raise FirstContactError("a pair of elements cannot be decided in this irrational pose")
        stats = _added(stats, found)
        met += found.pairs
        pierced += [pair for pair, _ in found.start]
    return ContactPairs(
        tuple(p for p, _ in element_pairs(a, b, met)),
        tuple(p for p, _ in element_pairs(a, b, pierced)),
        _timed(stats, begin),
    )


def intersection_curve(
    p: Any, q: Any, *, tolerance: float = 1e-6, method: str = "auto", box: Any = None
) -> IntersectionCurve:
    """IntersectionCurve: all points that two ruled surfaces at rest share, or one of them and a solid's boundary.

    Branches with their topology, common rulings, isolated and singular points; what is not listed is proved not to be
    there, but for `open_places` (docs/ruled-surfaces.md says what the coordinates rest on).  Deforming or moving
    surfaces: give p.at(t).

    tolerance: greatest distance between a branch and its polyline.  box: two corners ((x, y, z), (x, y, z)); only what
    lies in it is reported.  Without one, unbounded branches are cut about 100 times the size of the directrices away
    from the origin, and beyond that the tolerance grows.  method: "algebraic" is exact; "certified" takes pieces of any
    degree and strips, in doubles with proofs, and exactly where doubles leave something open and degrees are small; of
    two surfaces with whole rulings it tells what lies in the result's `box`; "auto" chooses.

    Solids are half-spaces, quadrics and all models made of them, and polyhedra of any shape, open ones too; their
    columns of the parameters are nan (null in JSON), their exact parameters None.

    Raises UnsupportedPair for other bodies, and for the cases that docs/ruled-surfaces.md lists.

    >>> import firstcontact as fc
    >>> saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
    >>> plane = fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
    >>> curve = fc.intersection_curve(saddle, plane)
    >>> [end.point.tolist() for end in curve.branches[0].ends]
    [[0.5, 1.0, 0.5], [1.0, 0.5, 0.5]]
    """
    from firstcontact.curves import ruled as verbs
    from firstcontact.curves.with_solids import solid_verbs
    from firstcontact.exact.curves.fibres import PrecisionExhausted

    kinds = {_kind(body) for body in (p, q)}
    if not (isinstance(tolerance, Real) and tolerance > 0):
        raise InputError(f"tolerance is {tolerance!r}; give a positive length")
    search = solid_verbs if "ruled" in kinds and len(kinds) > 1 else verbs
    try:
        return search.intersection_curve(p, q, tolerance, method, box)
    except PrecisionExhausted as error:
        raise UnsupportedPair(
            f"the curve of {p!r} and {q!r} asks for too many digits ({error}); move a body a little, or scale both"
        ) from error


@cache
def _of_curved(kind: str) -> Any:
    """The module with the verbs of curved bodies."""
    if kind == "ruled":
        from firstcontact.contact.ruled import first as moving

        return moving
    from firstcontact.contact.models import first as verbs

    return verbs


def _is_endless(a: Any, b: Any, span: Any) -> bool:
    return span is not None and common_span(a, b, span)[1] is None


def _kind(body: Any) -> str:
    """"polyhedra", "models" or "ruled"; UnsupportedPair for what is no body."""
    shape: Any = shape_of(body)
    if isinstance(shape, Polyhedron):
        return "polyhedra"
    name = type(shape).__name__  # asked by name: meshes need not load curved models
    if name == "CompositeQuadric":
        return "models"
    if name in ("RuledSurface", "RuledStrip"):
        return "ruled"
    raise UnsupportedPair(
        f"{body!r} is no body; give a Polyhedron, a CompositeQuadric or a RuledSurface, at rest or moving"
    )


def _starts_at_once(found: Found) -> bool:
    return found.instant is not None and found.instant.is_zero()


def _undecided(reason: str, free_until: float, stats: Stats, begin: float, shared: dict[str, Any]) -> FirstContact:
    return FirstContact(
        Status.UNDECIDED, free_until=free_until, reason=reason, stats=_timed(stats, begin), **shared
    )


def _added(stats: Stats, found: Any) -> Stats:
    """The work so far with that of one more search."""
    return Stats(
        stats.node_visits + found.visits,
        stats.pair_tests + found.tests,
        stats.undecided + found.unsure,
        stats.exact_evaluations + found.exact,
        engine=found.engine or stats.engine,
    )


def _timed(stats: Stats, begin: float) -> Stats:
    """The work of a search, and the time since `begin`."""
    done = stats.node_visits, stats.pair_tests, stats.undecided, stats.exact_evaluations
    return Stats(*done, clock.perf_counter() - begin, stats.engine)


def _refuse_inexact(parts: list[Any]) -> None:
    """UnsupportedPair where the times of contact of a piece have no exact form."""
    for piece in parts:
        if isinstance(piece, CurvedPiece) and piece.polynomial is None:
            raise UnsupportedPair(piece.why_inexact())


METHODS = ("auto", "certified", "algebraic")
ENGINES = ("auto", "boxes", "lifted", "composed", "sweep")


def _check(a: Any, b: Any, method: str, engine: str, tolerance: float, budget: int | None) -> str:
    """Which bodies these are, see `_kind`; raises for arguments that no search takes."""
    kinds = _kind(a), _kind(b)
    if method not in METHODS:
        raise UnsupportedPair(f"method {method!r} is unknown; choose one of {', '.join(METHODS)}")
    if engine not in ENGINES:
        raise UnsupportedPair(f"engine {engine!r} is unknown; choose one of {', '.join(ENGINES)}")
    if not (isinstance(tolerance, Real) and tolerance > 0):
        raise InputError(f"tolerance is {tolerance!r}; give a positive number")
    if budget is not None and (not isinstance(budget, int) or budget < 0):
        raise InputError(f"budget is {budget!r}; give a whole number of node visits and pair tests")
    return "ruled" if "ruled" in kinds else "models" if "models" in kinds else "polyhedra"
