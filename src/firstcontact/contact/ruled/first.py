"""`first_contact` and `contact_intervals` of two ruled surfaces, or of one and a polyhedron: which way answers.

Elimination is asked first where degrees are small, else a search in doubles with proofs; a polyhedron goes by its
triangles, and as a solid of planes where it is convex and small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.named import element
from firstcontact.contact.reduce import is_small_and_convex
from firstcontact.contact.ruled import certified, posed
from firstcontact.contact.ruled.triangles import MOST_PAIRS, Interior, near_pairs, parts_of
from firstcontact.contact.ruled_solid import certified as by_search
from firstcontact.contact.ruled_solid import first as with_solid
from firstcontact.contact.signs import exactly
from firstcontact.contact.signs.conditions import conditions
from firstcontact.contact.signs.exactly import PiecePair, span_of
from firstcontact.contact.signs.sheets import MOST_DEGREE, QUICK_DEGREE, TooLarge
from firstcontact.contact.signs.starts import with_start
from firstcontact.contact.signs.times import Times
from firstcontact.contact.signs.touches import touch
from firstcontact.contact.ways import Passed, Way, answered, is_proved, tried
from firstcontact.exact.numbers import below, exact_value
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.search.rulings.directrices import DirectrixPiece, directrix_pieces
from firstcontact.work import Query, Work

MESH_BOXES = 5_000
"""Boxes for a piece and a triangle after which elimination is asked instead."""
NEARBY = fmpq(1, 2**30)
"""Part of the span around a time proved in doubles in which it is decided exactly."""


def intervals(query: Query) -> ContactIntervals:
    """All closed times at which the bodies share a point; in doubles, with proofs, where elimination goes too far.

    tolerance: as part of the span, of the certified path only.
    """
    if not query.exact and _is_with_convex(query):
        return with_solid.in_turn(query, partial(_all_exactly, query))
    work = query.work()
    quick = None if query.exact else certified.pieces_of(query)

    def in_doubles(query: Query, _: None) -> ContactIntervals | Passed:
        if quick is None:
            return posed.intervals(query, work)
        proved = certified.intervals(quick, query, work)
        return proved if proved.reason != "precision" else Passed("precision", proved)

    first_degree = MOST_DEGREE if quick is None else QUICK_DEGREE
    return answered([
        Way("exactly", lambda query, _: _all_exactly(query, work, first_degree)),
        Way("in doubles", in_doubles, lambda query, _: not query.exact),
        Way("exactly, all degrees", lambda query, _: _all_exactly(query, work, MOST_DEGREE), is_proved),
    ], query)  # fmt: skip


def first(query: Query) -> FirstContact:
    """The first shared point: exactly; in doubles, with proofs, on request and where elimination leads far."""
    return with_start(query, _first_contact)


def _first_contact(query: Query) -> FirstContact:
    quick = None if query.is_algebraic else certified.pieces_of(query)
    first_degree = MOST_DEGREE if quick is None else QUICK_DEGREE

    def in_doubles(query: Query, _: None) -> FirstContact | Passed:
        if quick is None:
            return posed.first(query, query.work())
        proved = certified.first(quick, query)
        is_told = query.method == "certified" or proved.status is not Status.UNDECIDED or query.is_spent(proved.reason)
        return proved if is_told else Passed("precision", proved)

    return answered([
        Way("as a solid", _on_convex, lambda query, _: not query.is_algebraic and _is_with_convex(query)),
        Way("by triangles", _on_mesh, _is_for_triangles),
        Way("exactly", lambda query, _: _exactly(query, first_degree), _is_for_elimination),
        Way("in doubles", in_doubles, lambda query, proved: proved is None and not query.is_algebraic),
        Way("exactly, all degrees", lambda query, _: _exactly(query, MOST_DEGREE), is_proved),
    ], query)  # fmt: skip


def _is_for_triangles(query: Query, proved: Any) -> bool:
    return proved is None and query.method == "auto" and not query.exact and _is_with_mesh(query)


def _is_for_elimination(query: Query, proved: Any) -> bool:
    return proved is None and (query.exact or query.method != "certified")


def _is_with_mesh(query: Query) -> bool:
    return any(isinstance(shape_of(x), Polyhedron) for x in query.bodies)


def _is_with_convex(query: Query) -> bool:
    """Whether one of the bodies is a polyhedron that is a solid of planes, too."""
    shapes: list[Any] = [shape_of(x) for x in query.bodies]
    return any(isinstance(shape, Polyhedron) and is_small_and_convex(shape) for shape in shapes)


def _on_convex(query: Query, _: None) -> FirstContact | Passed:
    """In doubles, for exact arithmetic to go on unless method is "certified"."""
    proved = by_search.first(query)
    if query.method == "certified" or _is_settled(proved) or query.is_spent(proved.reason):
        return proved
    return Passed(proved.reason or "it is not told what touches", proved)


def _on_mesh(query: Query, _: None) -> FirstContact | Passed:
    """In doubles, and what meets exactly, around the time proved, where equations are small.

    Elimination over all the span takes every triangle that the surface comes near.
    """
    proved = posed.first(query, query.work(), MESH_BOXES)
    if proved.status is Status.UNDECIDED and not query.is_spent(proved.reason):
        return Passed(proved.reason or "")
    if proved.time_interval is None or proved.initial == "containment":
        return proved
    room = NEARBY * (query.end - query.first)
    lo, hi = (exact_value(t) for t in proved.time_interval)
    near = replace(query, first=max(query.first, lo - room), last=min(query.end, hi + room), exact=False)
    found = tried(lambda: _exactly(near, QUICK_DEGREE))
    if isinstance(found, Passed) or found.status is not proved.status:
        return proved
    return replace(found, span=query.span)


def _is_settled(proved: FirstContact) -> bool:
    """Whether exact arithmetic has nothing to add: the bodies are free or one point touches."""
    if proved.status is Status.CONTACT:
        return proved.contact_set is not None
    return proved.status is Status.FREE


# -- in exact arithmetic --------------------------------------------------------------------------------------


def _exactly(query: Query, most_degree: int) -> FirstContact:
    """Raises TooLarge beyond the degree."""
    work = query.work()
    return exactly.first(query, _pieces(query, work, most_degree), Interior.of(*query.bodies), work)


def _all_exactly(query: Query, work: Work, most_degree: int) -> ContactIntervals:
    """Raises TooLarge beyond the degree."""
    stretches = _pieces(query, work, most_degree)
    return exactly.as_intervals(*exactly.all_windows(stretches, Interior.of(*query.bodies)), query, work)


def _pieces(query: Query, work: Work, most_degree: int) -> Iterator[tuple[PolynomialPiece, list[PiecePair]]]:
    """The pieces of the relative motion in time order, with the pairs of pieces of the surfaces that may meet."""
    a, b, first, last = query.a, query.b, query.first, query.end
    parts_a, parts_b = parts_of(a), parts_of(b)
    numbers = [(i, j) for i in range(len(parts_a)) for j in range(len(parts_b))]
    if _is_with_mesh(query):
        numbers = near_pairs(parts_a, parts_b, first, last)
        if len(numbers) > MOST_PAIRS:
            raise TooLarge(
                f"{a!r} and {b!r}: {len(numbers)} pairs of a piece and a triangle come near each other, too many for "
                "exact arithmetic"
            )
    if not numbers:
        yield from ((motion, []) for motion in relative_pieces(a, b, first, last))
        return
    combined = [(i, j, parts_a[i], parts_b[j]) for i, j in numbers]
    for steps in zip(*(directrix_pieces(x, y, first, last) for _, _, x, y in combined), strict=True):
        work.free_until = below(steps[0].motion.start)
        found = [_pair(query, pair, step, work, most_degree) for pair, step in zip(combined, steps, strict=True)]
        yield steps[0].motion, found


def _pair(
    query: Query, pair: tuple[int, int, Any, Any], step: DirectrixPiece, work: Work, most_degree: int
) -> PiecePair:
    i, j, x, y = pair
    span = span_of(step.motion)
    joined = shape_of(x).joined, shape_of(y).joined
    times = Times(conditions(x, y, step, span), span, work, most_degree)
    of = {"a": (query.a, i), "b": (query.b, j)}
    return PiecePair(
        step.motion, times, lambda contact: touch(contact, joined),
        lambda known, which: element(of[which][0], *known, of[which][1], which),
    )  # fmt: skip
