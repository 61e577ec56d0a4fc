"""First contact of two composite quadric models by Algorithm 1 of Choi et al. 2014.

All subproblems give candidate times; the earliest candidate at which both trimmed models hold a point of the contact
set is the first contact.  Between two candidates nothing changes, so one look shortly after the start tells whether
the models overlapped all along.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import cached_property, cmp_to_key

import numpy as np
from flint import fmpq

from firstcontact.body.solid.carriers import Vector
from firstcontact.contact.models.at_rest import (
    coincide,
    is_inner,
    overlap_given,
    pose_in_doubles,
    relation_at,
    soon_told,
    whole_faces,
)
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.shared.contact_sets import OPEN, Shared, shared_part
from firstcontact.contact.models.shared.membership import extent
from firstcontact.contact.models.square_subproblems import SquareSubproblem
from firstcontact.contact.models.subproblems import Subproblem, subproblems
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import Undecidable, dyadic, exact_value, precision, to_double
from firstcontact.exact.systems.square_systems import EnclosedRoot, OpenRoot
from firstcontact.pairs.carriers.quadric_quadric import COINCIDE
from firstcontact.search.convex.relation import Relation
from firstcontact.timeline.lasting import LastingOfModels, LastingSolid
from firstcontact.work import Work

LATEST = 4
"""Of the inner points those that are tried at other times."""
NARROW = fmpq(1, 10**12)
"""Of the span of a piece: what an enclosure of a time of contact may be wide."""

Root = AlgebraicRoot | EnclosedRoot | OpenRoot
"""When a candidate is: an algebraic number, a proved enclosure, or a stretch where nothing was decided.

All have `compare`, `enclosure(bits)`, `sign_of`, `rational` (None where it is not), `multiplicity` and `float()`.
"""


@dataclass(frozen=True)
class Candidate:
    """A root of a subproblem's contact equation or system."""

    subproblem: Subproblem | SquareSubproblem
    root: Root


@dataclass(frozen=True)
class Meeting:
    """A candidate whose contact set is shared by both models."""

    candidate: Candidate
    shared: Shared
    multiplier: int


@dataclass
class CandidateSearch:
    """One piece of the motion: its subproblems, candidates in order of time, and the verdicts given so far.

    near: surfaces of either model; only features on these are looked at.
    undecided: candidates (by id) whose verdict is open, and why.
    relations, overlaps: what `relation_at` and `overlap_given` told, by u.
    inner: points that were inside both models at some u.
    Raises `work.Spent` when the work's budget is.
    """

    pair: MovingPair
    work: Work = field(default_factory=Work)
    tasks: list[Subproblem | SquareSubproblem] = field(default_factory=list)
    candidates: list[Candidate] = field(default_factory=list)
    verdicts: dict[int, tuple[list[Meeting], str]] = field(default_factory=dict)
    undecided: dict[int, str] = field(default_factory=dict)
    relations: dict[fmpq, Relation | None] = field(default_factory=dict)
    overlaps: dict[fmpq, bool | None] = field(default_factory=dict)
    inner: list[Vector] = field(default_factory=list)
    near: tuple[frozenset[int], frozenset[int]] | None = None

    def __post_init__(self) -> None:
        self.tasks = list(subproblems(self.pair, self.near))
        for task in self.tasks:
            self.work.step()
            self.candidates += [Candidate(task, root) for root in task.roots()]
        self.candidates.sort(key=cmp_to_key(lambda x, y: x.root.compare(y.root)))

    def verdict(self, candidate: Candidate) -> tuple[list[Meeting], str]:
        """The shared parts of the candidate's contact sets, or why there are none."""
        key = id(candidate)
        if key not in self.verdicts:
            self.work.step()
            try:
                self.verdicts[key] = _validated(candidate)
            except Undecidable as error:
                self.undecided[key] = str(error)
                self.verdicts[key] = [], str(error)
        return self.verdicts[key]

    def groups(self) -> Iterator[list[Candidate]]:
        """The candidates, those of one time together, ascending."""
        group: list[Candidate] = []
        for candidate in self.candidates:
            if group and candidate.root.compare(group[0].root) != 0:
                yield group
                group = []
            group.append(candidate)
        if group:
            yield group

    def meetings(self, group: list[Candidate]) -> list[Meeting]:
        """All contacts at one time."""
        return [meeting for candidate in group for meeting in self.verdict(candidate)[0]]

    def doubt(self, group: list[Candidate]) -> str:
        """Why candidates of one time are open; "" where it is proved of all whether they are contacts."""
        self.meetings(group)
        return next((self.undecided[id(x)] for x in group if id(x) in self.undecided), "")

    def are_no_contacts(self, group: list[Candidate]) -> bool:
        """Whether it is proved of all candidates of one time."""
        return not self.meetings(group) and not self.doubt(group)

    def first(self) -> list[Meeting]:
        """The contacts at the earliest time that has any; none where an undecided candidate comes before (`stop`)."""
        return self._outcome[0]

    def stop(self) -> tuple[Candidate, str] | None:
        """The candidate before the first contact that could not be decided, and why."""
        candidate = self._outcome[1]
        if candidate is None or self._outcome[0]:
            return None
        return candidate, self.undecided[id(candidate)]

    def open_from(self) -> fmpq | None:
        """Where the first contact is known to be in [open_from, its root] only: a stretch narrower than NARROW."""
        found, candidate = self._outcome
        return candidate.root.lo if found and candidate is not None else None

    @cached_property
    def _outcome(self) -> tuple[list[Meeting], Candidate | None]:
        """The first contacts, and the first undecided candidate before them."""
        open_: Candidate | None = None
        for group in self.groups():
            if open_ is not None and group[0].root.compare(open_.root.hi) > 0:
                return [], open_
            found = self.meetings(group)
            if found:
                return found, open_
            for candidate in group:
                if open_ is None and id(candidate) in self.undecided:
                    open_ = candidate
                    if not self._is_narrow(candidate.root):
                        return [], open_
        return [], open_

    def _is_narrow(self, root: Root) -> bool:
        piece = self.pair.piece
        assert piece.u_hi is not None
        return root.hi - root.lo < NARROW * (piece.u_hi - piece.u_lo)

    def at_start(self) -> list[Meeting] | None:
        """The contacts at the start: candidates there, and features that may be in contact all the time.

        None where none is known and one is open.
        """
        there = [c for c in self.candidates if self.is_at_start(c.root)]
        found = [m for c in there for m in self.verdict(c)[0]]
        lasting: list[Meeting] | None = []
        if self.starts_rational:
            lasting = self.lasting(self.pair.piece.u_lo, known={id(c.subproblem) for c in there})
        found += lasting or []
        return None if not found and (lasting is None or self.doubt(there)) else found

    def lasting(self, u: fmpq, known: Collection[int] = ()) -> list[Meeting] | None:
        """The contacts at a rational u of features that may be in contact at all times, which no root tells: they
        slide in one another, or stay tangent.  known: subproblems (by id) to leave out.

        None where none is known and one is open.
        """
        told = list(self._each_lasting(u, known))
        found = [meeting for meetings in told for meeting in meetings or ()]
        return None if None in told and not found else found

    def are_lasting(self, u: fmpq) -> bool | None:
        """Whether there are such contacts; None where one is open."""
        is_open = False
        for found in self._each_lasting(u):
            if found:
                return True
            is_open |= found is None
        return None if is_open else False

    def _each_lasting(self, u: fmpq, known: Collection[int] = ()) -> Iterator[list[Meeting] | None]:
        """The same of each subproblem; None of one that is open."""
        at = AlgebraicRoot.of(u)
        for task in self.tasks:
            if task.equation.may_hold_always and id(task) not in known:
                try:
                    yield _validated(Candidate(task, at))[0]
                except Undecidable:
                    yield None

    def share_a_point(self, u: fmpq, passed: list[Candidate] | None = None) -> bool | None:
        """Whether the models share a point at a rational u that is no candidate; None where it is not proved that they
        share none.

        passed: the candidates next before u, if the models shared a point before these: they do still unless one is a
        contact.
        """
        if any(is_inner(x, self.pair, u) for x in self.inner[: -1 - LATEST : -1]):
            return True
        seen = soon_told(self.pair, u)
        if seen is not None:
            return seen is Relation.OVERLAPPING
        if self._meet_in_doubles(u) or (passed is not None and self.are_no_contacts(passed)):
            return True
        if self._relation(u) is Relation.APART:
            return False
        overlapping = self._overlap(u)  # far sooner told than what slides in one another, where they do
        if overlapping:
            return True
        lasting = self.are_lasting(u)
        if lasting or coincide(self.pair, u):
            return True
        return None if lasting is None else overlapping

    def _meet_in_doubles(self, u: fmpq) -> bool:
        """Whether a point that doubles find is inside both models at u; it is one of the inner ones then."""
        seeds = [np.array([to_double(c) for c in x]) for x in self.inner[-1:]]
        point = self._depths.rough([pose_in_doubles(self.pair, u), (np.eye(3), np.zeros(3))], seeds)
        if point is None:
            return False
        x = tuple(exact_value(c) for c in point.tolist())
        if not is_inner(x, self.pair, u):
            return False
        self.inner.append(x)
        return True

    @cached_property
    def _depths(self) -> LastingOfModels:
        return LastingOfModels(LastingSolid(self.pair.a), LastingSolid(self.pair.b))

    def _relation(self, u: fmpq) -> Relation | None:
        if u not in self.relations:
            self.relations[u] = relation_at(self.pair, u)
        return self.relations[u]

    def _overlap(self, u: fmpq) -> bool | None:
        if u not in self.overlaps:
            self.overlaps[u] = overlap_given(self._relation(u), self.pair, u, self.inner)
        return self.overlaps[u]

    def may_share_a_point_at_end(self) -> bool:
        """Whether they may share one after the last candidate: a check of a search that found no contact."""
        piece = self.pair.piece
        assert piece.u_hi is not None
        lo = self.beyond(self.candidates[-1].root) if self.candidates else piece.u_lo
        return lo < piece.u_hi and self.share_a_point((lo + piece.u_hi) / 2) is not False

    def is_at_start(self, root: Root) -> bool:
        return self.pair.piece.clock.compare(root, self.pair.piece.start) == 0

    @property
    def starts_rational(self) -> bool:
        """Whether the parameter bound u_lo is the start itself."""
        return self.is_at_start(AlgebraicRoot.of(self.pair.piece.u_lo))

    def overlaps_after_start(self) -> bool:
        """Whether the interiors overlap at the times between the start and the next candidate."""
        return self._overlap(self.moment_after_start()) is True

    def coincides_at_start(self) -> bool:
        """Whether whole surfaces of the models coincide at the start."""
        return self.starts_rational and coincide(self.pair, self.pair.piece.u_lo)

    def may_share_a_point_after_start(self) -> bool:
        """Whether it is not proved that they share none then."""
        return self.share_a_point(self.moment_after_start()) is not False

    def moment_after_start(self) -> fmpq:
        """A rational u after the start of the piece and before every later candidate."""
        piece = self.pair.piece
        for group in self.groups():
            if not self.is_at_start(group[0].root):
                return between(piece.u_lo, group[0].root)
        assert piece.u_hi is not None
        return (piece.u_lo + piece.u_hi) / 2

    def beyond(self, root: Root) -> fmpq:
        """A rational u not before the root, and before every later candidate."""
        if root.rational is not None:
            return root.rational
        later = next((c.root for c in self.candidates if c.root.compare(root) > 0), None)
        bits = 64
        while True:
            with precision(bits):
                above = dyadic(root.enclosure(bits).upper())
            if later is None or later.compare(above) > 0:
                return above
            bits *= 2


def between(lo: fmpq, root: Root) -> fmpq:
    """A rational number strictly between lo and the root, lo < root."""
    if root.rational is not None:
        return (lo + root.rational) / 2
    bits = 64
    while True:
        with precision(bits):
            below = root.enclosure(bits).lower()
        if dyadic(below) > lo:
            return (lo + dyadic(below)) / 2
        bits *= 2


def _validated(candidate: Candidate) -> tuple[list[Meeting], str]:
    task, root = candidate.subproblem, candidate.root
    if isinstance(root, OpenRoot):
        raise Undecidable(root.reason)
    contacts = task.contacts(root)
    if contacts.same and not (task.a in whole_faces(task.pair.a) and task.b in whole_faces(task.pair.b)):
        return [], COINCIDE  # what bounds the faces tells
    on_a, on_b = extent(task.pair.a, task.a, task.on[0]), extent(task.pair.b, task.b, task.on[1])
    meetings, reasons = [], []
    for contact in contacts.found:
        shared, reason = shared_part(task.pair, contact, root, on_a, on_b)
        meetings += [Meeting(candidate, part, contact.multiplier) for part in shared]
        if reason:
            reasons.append(reason)
    if contacts.same and not meetings:
        raise Undecidable(f"{task.a.name} and {task.b.name} become one surface")
    if (OPEN in reasons or not contacts.complete) and not meetings:
        raise Undecidable(f"precision: {task.a.name} and {task.b.name} come too close to tell whether they touch")
    return meetings, "" if meetings else "; ".join(dict.fromkeys(reasons)) or contacts.reason
