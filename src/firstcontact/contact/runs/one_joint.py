"""Links of which one joint alone moves, faster and slower: asked about on the clock of its value.

While the value only grows, or only falls, the poses are those of a plain turn or screw, in the same order, and more is
proved of these: of faces that slide on each other across a hinge's axis, of what closes flush.  The value's turning
points cut the span; around irrational ones short pieces are left, of which the range of the value tells enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

from flint import fmpq, fmpq_poly

from firstcontact.body.kept import Kept
from firstcontact.contact.later import waiting
from firstcontact.contact.runs import seams
from firstcontact.contact.ways import Passed, tried
from firstcontact.exact.numbers import above, below, exact_value, fraction
from firstcontact.exact.rigid import Matrix, rational_sqrt
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.placement import HERE, Placement
from firstcontact.motion.product import JointFactor, Simple, Value, at
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Status
from firstcontact.timeline.answers import likely_time
from firstcontact.work import Progress, Query

BITS = 80
"""Halvings of a piece, after which the time of a value is known."""
SHORT = fmpq(1, 2**16)
"""Of a stretch: what is cut out around an irrational turning point."""
CLOSER = 0.25
"""Of the tolerance, on the clock of the value: its pace changes."""
Interval = tuple[float, float]
_PLACED = Kept[tuple[Matrix, Any]]()


class ValueCourse(NamedTuple):
    """A part of a question, within which one joint moves, and the question on the clock of its value.

    value: of the time, so that it grows.  turns: whether it has a turning point within the part, and is bounded alone.
    """

    part: Query
    own: Query
    value: Value
    turns: bool

    def moments(self, values: Interval) -> Interval:
        """Doubles around the times at which the value is in an enclosure."""
        lo, hi = (self._time(exact_value(x), k == 1) for k, x in enumerate(values))
        return below(lo), above(hi)

    def _time(self, value: fmpq, after: bool) -> fmpq:
        """Close to the time of the value, and not before, or not after it."""
        lo, hi = self.part.first, self.part.end
        if value <= self.own.first:
            return lo
        if value >= self.own.end:
            return hi
        for _ in range(BITS):
            middle = (lo + hi) / 2
            reached = at(self.value, middle)
            if reached == value:
                return middle
            lo, hi = (middle, hi) if reached < value else (lo, middle)
        return hi if after else lo

    def is_close(self, times: Interval) -> bool:
        """Whether an enclosure is as narrow as it is asked to be, but for a few roundings."""
        lo, hi = times
        length = self.part.span[1] - self.part.span[0]
        return hi - lo <= max(self.part.tolerance * length, 8 * (above(exact_value(hi)) - below(exact_value(hi))))


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    times = _cuts(query)
    if times is None:
        return answer(query)
    return seams.first(lambda part: _first(answer, part), query, (query.part(*x) for x in pairwise(times)))


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    times = _cuts(query)
    if times is None:
        return answer(query)
    return seams.intervals(lambda part: _intervals(answer, part), query, (query.part(*x) for x in pairwise(times)))


def _first(answer: Callable[[Query], FirstContact], part: Query) -> FirstContact:
    """Of a part between two cuts."""
    course = _course(part)
    if course is None:
        return answer(part)
    found = answer(course.own)
    if found.status is Status.FREE:
        return replace(found, **part.shared)
    if found.status is Status.INITIAL_CONTACT and not course.turns:
        start = part.span[0]
        return waiting(found, dict, time=start, time_interval=(start, start), free_until=start, **part.shared)
    if found.status is Status.CONTACT and not course.turns:
        assert found.time_interval is not None
        times = course.moments(_at_end(answer, found, course) or found.time_interval)
        if course.is_close(times):
            near = likely_time(times)
            return waiting(found, dict, time=near, time_interval=times, free_until=times[0], **part.shared)
    told = answer(replace(part, budget=part.budget_after(found.stats)))
    return waiting(told, dict, stats=found.stats + told.stats)


def _at_end(answer: Callable[[Query], FirstContact], found: FirstContact, course: ValueCourse) -> Interval | None:
    """What encloses the value at the end of the part, where the bodies are proved to touch then and not before: the
    joint may come to rest there, so that a rounding of its value takes long."""
    assert found.time_interval is not None
    if course.own.span[1] not in found.time_interval:
        return None
    exactly = tried(lambda: answer(replace(course.own, exact=True, progress=None)))
    if isinstance(exactly, Passed) or exactly.time_exact != fraction(course.own.end):
        return None
    return (above(course.own.end),) * 2


def _intervals(answer: Callable[[Query], ContactIntervals], part: Query) -> ContactIntervals:
    """Of a part between two cuts."""
    course = _course(part)
    if course is None:
        return answer(part)
    found = answer(course.own)
    if found.status is Status.FREE:
        return replace(found, **part.shared)
    told = None if found.status is Status.UNDECIDED else _on_clock(answer, found, course)
    if told is None:
        told = answer(replace(part, budget=part.budget_after(found.stats)))
        return replace(told, stats=found.stats + told.stats)
    return told


def _on_clock(
    answer: Callable[[Query], ContactIntervals], found: ContactIntervals, course: ValueCourse
) -> ContactIntervals | None:
    """The same at their times; None where these are not told as closely as they are to be."""
    part, own = course.part, course.own
    begin, end = ((below(t), above(t)) for t in (part.first, part.end))
    if course.turns:
        whole = len(found) == 1 and found[0].start <= own.span[0] and found[0].end >= own.span[1]
        told = [ContactInterval(*part.span, begin, end)] if whole else None
    else:
        starts = [course.moments(x.start_interval) for x in found]
        ends = [course.moments(x.end_interval) for x in found]
        if found.status is Status.INITIAL_CONTACT:
            starts[0] = begin
        if found[-1].end_interval[1] >= below(own.end) and answer(own.part(own.end, own.end)).intervals:
            ends[-1] = end  # the joint may come to rest there, so that a rounding of its value takes long
        close = all(map(course.is_close, [*starts, *ends]))
        told = [
            ContactInterval(likely_time(x), likely_time(y), x, y) for x, y in zip(starts, ends, strict=True)
        ] if close else None
    return None if told is None else replace(found, intervals=tuple(told), free_until=told[0].start, **part.shared)


# -- how the joint moves ------------------------------------------------------------------------------------


class SoleJoint(NamedTuple):
    """What moves in a stretch of time: `motion` by one unit of the value, which is a polynomial of the query's time.

    of: which of the bodies it moves.  places: where both stand before it does.
    """

    motion: Simple
    value: Value
    of: int
    places: tuple[Placement, Placement]


def _cuts(query: Query) -> list[fmpq] | None:
    """The times between which one joint alone moves, without a turning point, or the question stays as it is; None
    where it does so all the time."""
    motions = [x.motion for x in query.bodies if isinstance(x, Moving)]
    links = [x for x in motions if isinstance(x, Linkage)]
    deforms = any(getattr(shape_of(x), "deforming", False) for x in query.bodies)  # by the time, not by the value
    if query.is_algebraic or not links or len(links) < len(motions) or deforms:
        return None
    knots = sorted({t for x in links for t in x.times if query.first < t < query.end})
    times, found = [query.first], False
    for start, end in pairwise([query.first, *knots, query.end]):
        joint = _joint(query, start, end)
        if joint is not None:
            found = True
            times += _turning_points(joint.value, start, end)
        times.append(end)
    return times if found else None


def _joint(query: Query, start: fmpq, end: fmpq) -> SoleJoint | None:
    """What alone moves then, at a pace that changes; the times are of one stretch of all motions."""
    motions = [x.motion if isinstance(x, Moving) else None for x in query.bodies]
    links = [(k, x, x.stretch((start + end) / 2)) for k, x in enumerate(motions) if isinstance(x, Linkage)]
    if start == end or [len(d.values[j]) > 2 for _, x, j in links for d in x.moving(j)] != [True]:
        return None  # none, or many, or one that keeps its pace
    places, found = [HERE, HERE], list[tuple[int, JointFactor, fmpq, fmpq]]()
    for k, link, stretch in links:
        places[k], factors = link.at_work(stretch)
        found += [(k, f, link.times[stretch], link.times[stretch + 1]) for f in factors]
    (of, factor, begin, until), = found
    if not all(place.is_exact for place in places):
        return None
    value = factor.within(-begin / (until - begin), 1 / (until - begin))
    return SoleJoint(factor.motion, value, of, (places[0], places[1])) if len(value) > 2 else None


def _course(part: Query) -> ValueCourse | None:
    """The question about a part on the clock of the value."""
    joint = _joint(part, part.first, part.end)
    if joint is None:
        return None
    value, motion = joint.value, joint.motion
    first, end = at(value, part.first), at(value, part.end)
    turns = _turns(value, part.first, part.end)
    if turns:
        first, end = _range(value, part)
    elif end < first:
        value, motion, first, end = tuple(-c for c in value), motion.paced(fmpq(-1)), -first, -end
    bodies = [_placed(shape_of(x), place) for x, place in zip(part.bodies, joint.places, strict=True)]
    bodies[joint.of] = Moving(bodies[joint.of], motion)
    own = replace(
        part, a=bodies[0], b=bodies[1], first=first, last=end, tolerance=CLOSER * part.tolerance,
        progress=_at_its_start(part), enough=None,
    )  # fmt: skip
    return ValueCourse(part, own, value, turns)


def _turns(value: Value, first: fmpq, last: fmpq) -> bool:
    """Whether a value, of degree 3 at most, both grows and falls between two times."""
    slope = fmpq_poly(list(value)).derivative()
    middle = -slope[1] / (2 * slope[2]) if slope[2] else first
    slopes = [slope(x) for x in (first, last, min(max(middle, first), last))]
    return min(slopes) < 0 < max(slopes)


def _turning_points(value: Value, first: fmpq, last: fmpq) -> list[fmpq]:
    """Where it turns strictly between two times: these times, or two around an irrational one, ascending."""
    if not _turns(value, first, last):
        return []
    slope = fmpq_poly(list(value)).derivative()
    if not slope[2]:
        roots = [-slope[0] / slope[1]]
    else:
        middle = -slope[1] / (2 * slope[2])
        square = middle * middle - slope[0] / slope[2]
        half, room = rational_sqrt(square), SHORT * (last - first)
        if half is None:
            near = _sqrt_below(square, room / 4)
            roots = [x + side * room for x in (middle - near, middle + near) for side in (-1, 1)]
        else:
            roots = [middle - half, middle + half]
    return [x for x in roots if first < x < last]


def _sqrt_below(square: fmpq, error: fmpq) -> fmpq:
    """A number less than `error` below the root of a positive one."""
    bits = max(int(error.q).bit_length() - int(error.p).bit_length() + 1, 0)
    return fmpq(math.isqrt(int((square * 4**bits).floor())), 2**bits)


def _range(value: Value, part: Query) -> tuple[fmpq, fmpq]:
    """Two numbers on either side of all values, and not close to any."""
    local = fmpq_poly(list(value))(fmpq_poly([part.first, part.end - part.first])).coeffs()
    swing = 2 * sum((abs(c) for c in local[1:]), fmpq(0))
    return local[0] - swing, local[0] + swing


def _at_its_start(part: Query) -> Progress | None:
    """Progress told as that of the part's start: what is proved within it is on another clock."""
    told = part.progress
    return None if told is None else lambda _, done: told(below(part.first), done)


def _placed(shape: Any, place: Placement) -> Any:
    """The shape as it stands, kept on it for the next question."""
    if place == HERE:
        return shape
    matrix = place.matrix()
    known = _PLACED.get(shape)
    if known is None or known[0] != matrix:
        known = _PLACED.put(shape, (matrix, place.place(shape)))
    return known[1]
