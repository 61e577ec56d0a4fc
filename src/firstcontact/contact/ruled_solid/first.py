"""`first_contact` and `contact_intervals` of a ruled surface and a solid of planes and quadrics: which way answers.

First contacts are certified in doubles at first, in a few ms, and decided exactly where that leaves something open;
intervals the other way round, as elimination is the shorter way to them where degrees are small.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.models.first import proved_intervals
from firstcontact.contact.ruled import first as moving
from firstcontact.contact.ruled_solid import certified as solids
from firstcontact.contact.signs.sheets import MOST_DEGREE
from firstcontact.contact.signs.whole_rulings import cut_to
from firstcontact.errors import UnsupportedPair
from firstcontact.motion.moving import shape_of
from firstcontact.result import ContactIntervals, Element, ElementPair, FirstContact, Status
from firstcontact.work import Progress, Work

SMALL_DEGREE = 150
"""Of equations for times that elimination may lead to before doubles are asked for intervals."""
QUICK_BUDGET = 50_000
"""Boxes that the search in doubles looks at before exact arithmetic is asked for a first contact."""


def first_contact(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, method: str, tolerance: float, budget: int | None,
    progress: Progress | None, shared: dict[str, Any], begin: float,
) -> FirstContact:
    """The first shared point; in doubles, and exactly what they leave open or do not take, as the method allows."""
    proved, refused = None, ""
    if method != "algebraic" and not exact:
        quick = QUICK_BUDGET if budget is None and method == "auto" else budget
        try:
            proved = solids.first_contact(a, b, first, last, tolerance, quick)
        except UnsupportedPair as reason:
            if method == "certified":
                raise
            refused = str(reason)
        if proved is not None and (method == "certified" or _is_told(proved, budget)):
            return proved
    known = proved is not None and proved.status is Status.CONTACT
    try:
        ordered, is_turned = _solid_last(a, b, shared)
        degree = moving.QUICK_DEGREE if known else MOST_DEGREE
        found = moving.decided(
            ordered["a"], ordered["b"], first, last, exact, degree, budget, progress, ordered, begin
        )
    except UnsupportedPair as reason:
        if proved is None:
            raise _also_refused(reason, refused) from None
        if proved.reason == "budget" and budget is None:
            return solids.first_contact(a, b, first, last, tolerance, None)
        return proved
    return replace(_turned(found) if is_turned else found, a=a, b=b)


def _is_told(proved: FirstContact, budget: int | None) -> bool:
    """Whether exact arithmetic has nothing to add to what was proved about a surface and a solid."""
    if proved.status is Status.INITIAL_CONTACT:
        return proved.initial is not None
    if proved.status is Status.CONTACT:
        return proved.element_a is not None
    return proved.status is Status.FREE or budget is not None and proved.reason == "budget"


def _solid_last(a: Any, b: Any, shared: dict[str, Any]) -> tuple[dict[str, Any], bool]:
    """The bodies and the span with the solid as b, its whole rulings cut, and whether they changed places.

    With a polyhedron they stay as they are.
    """
    if any(isinstance(shape_of(x), Polyhedron) for x in (a, b)):
        return shared, False
    is_turned = isinstance(shape_of(a), CompositeQuadric)
    ruled, solid = (b, a) if is_turned else (a, b)
    return {"a": cut_to(ruled, solid, shared["span"]), "b": solid, "span": shared["span"]}, is_turned


def _turned(found: FirstContact) -> FirstContact:
    """The result for the bodies in the other order."""
    first, second = partial(_called, found.b, "b", "a"), partial(_called, found.a, "a", "b")
    return replace(
        found, a=found.b, b=found.a, element_a=first(found.element_b), element_b=second(found.element_a),
        normal=None if found.normal is None else 0.0 - found.normal,
        others=tuple(ElementPair(first(x.element_b), second(x.element_a)) for x in found.others),
    )  # fmt: skip


def _called(body: Any, before: str, after: str, element: Element | None) -> Any:
    """The element of a body that goes by this letter where it has no name."""
    if element is None or getattr(body, "name", None):
        return element
    return replace(element, body=after, label=after if element.label == before else element.label)


def contact_intervals(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, tolerance: float, work: Work, begin: float,
    shared: dict[str, Any],
) -> ContactIntervals:
    """All closed times of contact; the solid may be a convex polyhedron."""
    proved, refused = None, ""
    if not exact:
        try:
            return _exactly(a, b, first, last, exact, SMALL_DEGREE, work, begin, shared)
        except UnsupportedPair:
            pass
        try:
            proved = in_doubles(a, b, first, last, tolerance, work, begin, shared)
        except UnsupportedPair as reason:
            refused = str(reason)
        else:
            if proved.status is not Status.UNDECIDED or (work.budget is not None and proved.reason == "budget"):
                return proved
    try:
        return _exactly(a, b, first, last, exact, MOST_DEGREE, work, begin, shared)
    except UnsupportedPair as reason:
        if proved is None:
            raise _also_refused(reason, refused) from None
        return proved


def _exactly(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, most_degree: int, work: Work, begin: float,
    shared: dict[str, Any],
) -> ContactIntervals:
    ordered, _ = _solid_last(a, b, shared)
    windows, reason = moving.all_windows(ordered["a"], ordered["b"], first, last, work, most_degree)
    return moving.as_intervals(windows, reason, first, last, exact, work, begin, shared)


def _also_refused(reason: UnsupportedPair, in_doubles: str) -> UnsupportedPair:
    """Why neither way is open."""
    return UnsupportedPair(f"{in_doubles}; exactly: {reason}") if in_doubles else reason


def in_doubles(
    a: Any, b: Any, first: fmpq, last: fmpq, tolerance: float, work: Work, begin: float, shared: dict[str, Any]
) -> ContactIntervals:
    """The intervals as far as doubles prove them."""
    return proved_intervals(solids.contact_intervals(a, b, first, last, tolerance, work), work, begin, shared)
