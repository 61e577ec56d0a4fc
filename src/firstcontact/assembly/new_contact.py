"""`first_new_contact`: bodies that touch at the start, and what they touch after that.

A point at which the bodies touch later is an old contact where it lies in a plane or surface in which they touched at
the start and along which they slide, or on the axis about which they turn; any other shared point, inside a solid
too, is a new one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from firstcontact import query
from firstcontact.assembly.kept import step_ends
from firstcontact.body.compound.compound import both_taken_in
from firstcontact.contact.plain import plainly
from firstcontact.contact.ways import tried
from firstcontact.exact.numbers import above, exact_value, fraction, to_double
from firstcontact.motion.moving import shape_of
from firstcontact.motion.span import common_span
from firstcontact.result import (
    WITHIN,
    ContactInterval,
    ContactIntervals,
    ContactPairs,
    Element,
    ElementPair,
    FirstContact,
    Stats,
    Status,
)
from firstcontact.work import Progress

if TYPE_CHECKING:
    from collections.abc import Sequence
    from fractions import Fraction

    from flint import fmpq

    from firstcontact.body.kinds import AnyBody, Body
    from firstcontact.exact.numbers import Given
    from firstcontact.work import Arguments

R = TypeVar("R", FirstContact, ContactIntervals, ContactPairs)

TOUCHING = "touching at the start"
WITHIN_TRIANGLES = "no deeper than twice what their triangles deviate from the file's"
MOST_STEPS = 100
"""Of motions that are looked at step by step."""
LASTING = "contact"
"""Why an answer is open: contact lasts from the start on, and nothing tells which of it is new."""


@dataclass(frozen=True)
class NewContactQuery:
    """The verbs' arguments for every question about two bodies, or parts of them, from `first` to `last` (or None).

    is_apart: whether it is known that their interiors do not meet at the start.  done: the work of all that was asked.
    """

    first: fmpq
    last: fmpq | None
    arguments: Arguments
    is_apart: bool = True
    done: list[Stats] = field(default_factory=list)

    @property
    def start(self) -> float:
        return to_double(self.first)

    @property
    def span(self) -> tuple[Fraction, Fraction | float]:
        return fraction(self.first), float("inf") if self.last is None else fraction(self.last)

    def first_contact(self, a: Body, b: Body, since: Fraction | None = None) -> FirstContact:
        """Over the span, or from a later time on."""
        first, last = self.span
        return self._noted(query.first_contact(a, b, (first if since is None else since, last), **self.arguments))

    def intervals(self, a: Body, b: Body, exact: bool = False) -> ContactIntervals:
        arguments = self.arguments | {"exact": True} if exact else self.arguments
        return self._noted(query.contact_intervals(a, b, self.span, **arguments))

    def at_start(self, a: Body, b: Body) -> FirstContact:
        return self.at(a, b, self.span[0])

    def at(self, a: Body, b: Body, time: Fraction | float) -> FirstContact:
        return self._noted(query.first_contact(a, b, (time, time)))

    def pairs_at_start(self, a: Body, b: Body) -> ContactPairs:
        first, _ = self.span
        return self._noted(query.contact_pairs(a, b, (first, first)))

    def _noted(self, answer: R) -> R:
        self.done.append(answer.stats)
        return answer

    def is_open(self, found: FirstContact) -> bool:
        """Whether it tells nothing of any time after the start."""
        return found.status is Status.UNDECIDED and (found.free_until or 0.0) <= self.start

    def undecided(self, reason: str | None, until: float | None = None) -> FirstContact:
        return FirstContact(Status.UNDECIDED, free_until=self.start if until is None else until, reason=reason)


class Lasts(Exception):
    """Contact lasts from the start on."""


Way: TypeAlias = "Callable[[Body, Body, NewContactQuery], FirstContact | None]"
"""The first new contact of bodies that touch at the start; None where this way does not tell."""


def first_new_contact(
    a: AnyBody,
    b: AnyBody,
    span: Sequence[Given] | None = None,
    *,
    exact: bool = False,
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Progress | None = None,
) -> FirstContact:
    """FirstContact as `first_contact` finds it, but of bodies that touch at the start the first new contact.

    Old contacts are those in a plane or surface in which the bodies touched at the start and along which they slide,
    and on the axis about which they turn; every other shared point is new, inside solids too.  Then `allowed` says
    "touching at the start", Status.FREE proves that there is no new contact at any time of the span, and what is not
    decided is UNDECIDED: reason "contact" where contact lasts and no proof tells old from new.  Bodies that overlap at
    the start, or of which neither is proved (`initial` None), are in INITIAL_CONTACT as ever, but for parts of files
    that overlap no deeper than they deviate from these, or than twice what they would as triangles: of them the first
    contact deeper than that is told, by the parts as they are when each is taken in by what it deviates; FREE proves
    that there is none.  So it is of parts that touch so that nothing else tells, as all along the end of a round.

    Arguments as in `first_contact`; the budget is that of each question asked on the way.

    >>> import firstcontact as fc
    >>> drawer = fc.box((1, 1, 1)).translated((0, 0, "1/2"))
    >>> rail = (fc.box((6, 1, 1)) | fc.box((1, 1, 3)).translated((3, 0, 0))).translated((0, 0, "-1/2"))
    >>> hit = fc.first_new_contact(drawer.moving(fc.Translation((4, 0, 0))), rail)
    >>> hit.status.name, hit.time, hit.allowed
    ('CONTACT', 0.5, 'touching at the start')
    """
    arguments: Arguments = {"exact": exact, "tolerance": tolerance, "budget": budget, "progress": progress}
    first = query.first_contact(a, b, span, **arguments)
    if first.status is not Status.INITIAL_CONTACT:
        return first
    if first.initial == "touching":
        found = _after_touch(first, span, arguments)
        if found.status is not Status.UNDECIDED or found.reason == "budget":
            return found
        deeper = _deeper(first, span, arguments)  # as next to rounds, where nothing tells what touches along a curve
        return found if deeper is None or deeper.status is Status.UNDECIDED else deeper
    deeper = _deeper(first, span, arguments)
    return _after_touch(first, span, arguments) if deeper is None else deeper


def _deeper(first: FirstContact, span: Sequence[Given] | None, arguments: Arguments) -> FirstContact | None:
    """Of parts of files the first contact deeper than they deviate, or than twice what they would as triangles; None
    where they are in contact so deep at the start, or deviate by nothing."""
    known: list[Any] = []
    open_: FirstContact | None = None
    for cut, depth in ((False, WITHIN), (True, WITHIN_TRIANGLES)):
        inner = both_taken_in(first.a, first.b, cut=cut)
        if inner is None or (known and all(shape_of(x) is y for x, y in zip(inner, known, strict=True))):
            continue
        known = [shape_of(x) for x in inner]
        found = _after_touch(query.first_contact(*inner, span, **arguments), span, arguments)
        if found.status is not Status.INITIAL_CONTACT:
            how = f"{first.initial or 'in contact'} at the start, {depth}"
            told = f"{how}; of {'these' if cut else 'the parts'} taken in by that"
            open_ = replace(found, a=first.a, b=first.b, stats=first.stats + found.stats, allowed=told)
            if found.status is not Status.UNDECIDED:
                return open_
    return open_


def _after_touch(first: FirstContact, span: Sequence[Given] | None, arguments: Arguments) -> FirstContact:
    """The first new contact, from the first contact on; that one where the bodies do not touch at the start."""
    if first.status is not Status.INITIAL_CONTACT or first.initial not in ("touching", None):
        return first
    asking = NewContactQuery(*common_span(first.a, first.b, span), arguments, first.initial is not None)
    found = _of_bodies(first.a, first.b, asking)
    if found.reason == LASTING:
        a, b = (plainly(body, asking.first, asking.last) for body in (first.a, first.b))
        if a is not first.a or b is not first.b:
            found = _of_bodies(a, b, asking)
    work = replace(sum(asking.done, first.stats), ways=first.stats.ways + found.stats.ways)
    if first.initial is None and found.status is Status.UNDECIDED:  # they may as well overlap
        return replace(first, stats=work)
    return replace(
        found, a=first.a, b=first.b, span=first.span, stats=work, allowed=TOUCHING, unit=first.unit,
        model_deviation=first.model_deviation,
    )  # fmt: skip


def _of_bodies(a: Body, b: Body, asking: NewContactQuery) -> FirstContact:
    """Solids of planes as meshes, which are told sooner, then as what they are."""
    from firstcontact.contact.mesh_model import as_polyhedra  # loads what solids need

    found = of_meshes(a, b, asking) if as_polyhedra.are_of_planes(a, b) else None
    if found is None or (found.reason == LASTING and not as_polyhedra.are_taken(a, b)):
        found = _new_contact(a, b, asking)
    return found


def of_meshes(a: Body, b: Body, asking: NewContactQuery) -> FirstContact:
    """Solids of planes as meshes."""
    from firstcontact.contact.mesh_model import as_polyhedra

    meshes = as_polyhedra.as_polyhedron(a), as_polyhedra.as_polyhedron(b)
    return as_polyhedra.in_own_elements(_new_contact(*meshes, asking), a, b)


def _new_contact(a: Body, b: Body, asking: NewContactQuery) -> FirstContact:
    """All at once, or step by step: what touches as a step begins is old, where there was no new contact before."""
    found = _at_once(a, b, asking)
    ends = step_ends((a, b), asking.first, asking.last)
    if found.reason != LASTING or not 0 < len(ends) <= MOST_STEPS:
        return found
    for end in [*ends, asking.last]:
        found = _at_once(a, b, replace(asking, last=end))
        if found.status is not Status.FREE or end is None or end is asking.last:
            return found
        asking = replace(asking, first=end)
        then = asking.at_start(a, b)
        if then.status is Status.FREE:
            return asking.first_contact(a, b)
        if then.initial not in ("touching", None):
            return asking.undecided("precision")
        asking = replace(asking, is_apart=then.initial is not None)
    return found


def _at_once(a: Body, b: Body, asking: NewContactQuery) -> FirstContact:
    from firstcontact.assembly.faces import by_faces
    from firstcontact.assembly.parts import by_parts
    from firstcontact.assembly.pieces import by_pieces

    def of_pieces(a: Body, b: Body, asking: NewContactQuery) -> FirstContact | None:
        return by_pieces(a, b, asking, _at_once)

    ways: list[Way] = [of_pieces, by_parts, after_start]
    if asking.is_apart:
        ways.insert(1, by_faces)  # which looks at surfaces alone, the others at all points
    for way in ways:
        try:
            found = tried(partial(way, a, b, asking))
        except Lasts:
            found = asking.undecided(LASTING)
        if isinstance(found, FirstContact):  # a refusal is of a question asked on the way: the pair itself is one
            pressed = _pressed_in(a, b, asking) if asking.is_open(found) and found.reason != "budget" else None
            return found if pressed is None else pressed
    return asking.undecided(LASTING)


def after_start(a: Body, b: Body, asking: NewContactQuery) -> FirstContact:
    """The first contact of bodies whose contact at the start, if any, ends at once.  Raises Lasts where it does not."""
    found, k, begin = asking.intervals(a, b), 0, asking.start
    if len(found) and found[0].start_interval[0] <= begin:
        if not _ends_at_once(found[0], a, b, asking):
            raise Lasts
        k = 1
    if len(found) <= k:
        return FirstContact(
            found.status if found.status is Status.UNDECIDED else Status.FREE,
            free_until=found.free_until if found.status is Status.UNDECIDED else found.span[1], reason=found.reason,
        )  # fmt: skip
    if k == 0:
        return asking.first_contact(a, b)
    free = (exact_value(begin) + exact_value(found[k].start_interval[0])) / 2
    if not asking.first < free:
        return asking.undecided("precision")
    return asking.first_contact(a, b, fraction(free))


def _ends_at_once(contact: ContactInterval, a: Body, b: Body, asking: NewContactQuery) -> bool:
    """Whether contact is of the start alone: where doubles leave that open, exact ends tell."""
    if contact.end_interval == (asking.start, asking.start):
        return True
    if contact.end_interval[0] > above(asking.first):
        return False
    told = tried(lambda: asking.intervals(a, b, exact=True))
    return isinstance(told, ContactIntervals) and len(told) > 0 and told[0].end_exact == fraction(asking.first)


def _pressed_in(a: Body, b: Body, asking: NewContactQuery) -> FirstContact | None:
    """A new contact at once, where the bodies overlap soon after the start; else None."""
    length = exact_value(1.0) if asking.last is None else asking.last - asking.first
    soon = to_double(asking.first + length * exact_value(min(asking.arguments["tolerance"], 1e-12)))
    if not asking.start < soon or not asking.is_apart:  # the span is one instant, or nearly
        return None
    then = asking.at(a, b, soon)
    if then.initial not in ("overlapping", "containment"):
        return None
    told = then if then.element_a is not None else asking.at_start(a, b)
    return FirstContact(
        Status.CONTACT, time=asking.start, time_interval=(asking.start, soon), free_until=asking.start,
        point=told.point, element_a=told.element_a, element_b=told.element_b, multiplicity=told.multiplicity,
    )  # fmt: skip


Name = Callable[[Element], Element]


def renamed(found: FirstContact, name_a: Name, name_b: Name) -> FirstContact:
    """An answer about parts with elements as users call them; what else the bodies share then was not looked for."""
    if found.element_a is None or found.element_b is None:
        return found
    first = ElementPair(name_a(found.element_a), name_b(found.element_b))
    more = (ElementPair(name_a(pair.element_a), name_b(pair.element_b)) for pair in found.others)
    _, *others = dict.fromkeys((first, *more))
    return replace(
        found, element_a=first.element_a, element_b=first.element_b, others=tuple(others),
        multiplicity=1 + len(others), contact_set=None,
    )  # fmt: skip


def earliest(found: list[FirstContact], asking: NewContactQuery) -> FirstContact:
    """Of answers about parts that together are the bodies, the one for all of them."""
    contacts = [x for x in found if x.time_interval is not None]
    open_ones = [x for x in found if x.status is Status.UNDECIDED]
    best = min(contacts, key=lambda x: (x.time_interval, x.time), default=None)
    until = min((x.free_until for x in open_ones if x.free_until is not None), default=float("inf"))
    if open_ones and (best is None or best.time_interval is None or until < best.time_interval[1]):
        return replace(min(open_ones, key=lambda x: x.free_until or 0.0), free_until=max(until, asking.start))
    if best is not None:
        return best
    return FirstContact(Status.FREE, free_until=float("inf") if asking.last is None else to_double(asking.last))
