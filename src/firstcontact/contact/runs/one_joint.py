"""Links of which one joint alone moves, faster and slower: asked about on the clock of its value.

While the value only grows, or only falls, the poses are those of a plain turn or screw, in the same order, and more is
proved of these: of faces that slide on each other across a hinge's axis, of what closes flush.  The value's turning
points cut the span; around irrational ones short pieces are left, of which the range of the value tells enough.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

from flint import fmpq, fmpq_poly

from firstcontact.contact.later import changed, waiting
from firstcontact.contact.plain import place_key, placed
from firstcontact.contact.runs import seams
from firstcontact.contact.ways import Passed, R, tried
from firstcontact.exact.numbers import above, below, exact_value, fraction
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.placement import HERE, Placement
from firstcontact.motion.poses import sqrt_near
from firstcontact.motion.product import JointFactor, Value, at, way
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


class SoleJoint(NamedTuple):
    """What moves in a stretch of time: its value is a polynomial of the query's time.

    of: which of the bodies it moves.  places: where both stand before it does.
    """

    factor: JointFactor
    of: int
    places: tuple[Placement, Placement]


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


Answer = Callable[[Query], R]
OnClock = Callable[[Answer[R], R, ValueCourse], R | None]
"""What the answer on the clock of the value tells of the part; None where it does not tell it as closely as asked."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    return _in_parts(seams.first, _first_on_clock, answer, query)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    return _in_parts(seams.intervals, _intervals_on_clock, answer, query)


def _in_parts(
    whole: Callable[[Answer[R], Query, Iterable[Query]], R], on_clock: OnClock[R], answer: Answer[R], query: Query
) -> R:
    joints: dict[fmpq, SoleJoint | None] = _joints(query)
    if not any(joints.values()):
        return answer(query)

    def told(part: Query) -> R:
        joint = joints[part.first]
        return answer(part) if joint is None else _of_part(answer, on_clock, part, joint)

    return whole(told, query, (query.part(*times) for times in pairwise([*joints, query.end])))


def _of_part(answer: Answer[R], on_clock: OnClock[R], part: Query, joint: SoleJoint) -> R:
    """Of a part in which the joint moves: on the clock of its value, where that tells it."""
    course = _course(part, joint)
    found = answer(course.own)
    if found.status is Status.FREE:
        return changed(found, **part.shared)
    told = None if found.status is Status.UNDECIDED else on_clock(answer, found, course)
    if told is None:
        told = answer(replace(part, budget=part.budget_after(found.stats)))
        told = changed(told, stats=found.stats + told.stats)
    return told


def _first_on_clock(
    answer: Callable[[Query], FirstContact], found: FirstContact, course: ValueCourse
) -> FirstContact | None:
    part = course.part
    if course.turns:
        return None
    if found.status is Status.INITIAL_CONTACT:
        start = part.span[0]
        return waiting(found, dict, time=start, time_interval=(start, start), free_until=start, **part.shared)
    found, values = _at_end(answer, found, course)
    times = course.moments(values)
    if not course.is_close(times):
        return None
    return waiting(found, dict, time=likely_time(times), time_interval=times, free_until=times[0], **part.shared)


def _at_end(
    answer: Callable[[Query], FirstContact], found: FirstContact, course: ValueCourse
) -> tuple[FirstContact, Interval]:
    """A contact, and what encloses its value.  Of the end of the part an exact answer tells whether they touch then and
    not before: the joint may come to rest there, so that a rounding of its value takes long."""
    own, values = course.own, found.time_interval
    assert values is not None
    if own.span[1] not in values:
        return found, values
    exactly = tried(lambda: answer(replace(own, exact=True, progress=None, budget=own.budget_after(found.stats))))
    if isinstance(exactly, Passed):
        return found, values
    at_end = exactly.time_exact == fraction(own.end)
    return changed(found, stats=found.stats + exactly.stats), (above(own.end),) * 2 if at_end else values


def _intervals_on_clock(
    answer: Callable[[Query], ContactIntervals], found: ContactIntervals, course: ValueCourse
) -> ContactIntervals | None:
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


def _joints(query: Query) -> dict[fmpq, SoleJoint | None]:
    """By times from which on it does so, to the next of them: the joint that alone moves, at a pace that changes,
    without a turning point; None where the question stays as it is."""
    motions = [x.motion for x in query.bodies if isinstance(x, Moving)]
    links = [x for x in motions if isinstance(x, Linkage)]
    deforms = any(getattr(shape_of(x), "deforming", False) for x in query.bodies)  # by the time, not by the value
    if query.is_algebraic or not links or len(links) < len(motions) or deforms:
        return {}
    knots = sorted({t for x in links for t in x.times if query.first < t < query.end})
    found: dict[fmpq, SoleJoint | None] = {}
    for start, end in pairwise([query.first, *knots, query.end]):
        joint = _joint(query, start, end)
        turning = [] if joint is None else _turning_points(joint.factor.value, start, end)
        found |= dict.fromkeys([start, *turning], joint)
    return found


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
    return SoleJoint(factor._replace(value=value), of, (places[0], places[1])) if len(value) > 2 else None


def _course(part: Query, joint: SoleJoint) -> ValueCourse:
    """The question about a part on the clock of the value."""
    motion, value = joint.factor
    first, end = at(value, part.first), at(value, part.end)
    turns = _turns(value, part.first, part.end)
    if turns:
        local = joint.factor.within(part.first, part.end - part.first)
        first, end = local[0] - 2 * way(local), local[0] + 2 * way(local)  # on either side, and not close to any value
    elif end < first:
        value, motion, first, end = tuple(-c for c in value), motion.paced(fmpq(-1)), -first, -end
    poses = [place.matrix() for place in joint.places]
    bodies = [placed(shape_of(x), pose, place_key(pose)) for x, pose in zip(part.bodies, poses, strict=True)]
    bodies[joint.of] = Moving(bodies[joint.of], motion)
    own = replace(
        part, a=bodies[0], b=bodies[1], first=first, last=end, tolerance=CLOSER * part.tolerance,
        progress=_at_its_start(part), enough=None,
    )  # fmt: skip
    return ValueCourse(part, own, value, turns)


def _at_its_start(part: Query) -> Progress | None:
    """Progress told as that of the part's start: what is proved within it is on another clock."""
    told = part.progress
    return None if told is None else lambda _, done: told(below(part.first), done)


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
        return [-slope[0] / slope[1]]
    middle = -slope[1] / (2 * slope[2])
    square, room = middle * middle - slope[0] / slope[2], SHORT * (last - first)
    half, beside = rational_sqrt(square), [fmpq(0)]
    if half is None:
        parts = square / room**2
        bits = max(int(parts.p).bit_length() - int(parts.q).bit_length(), 0) + 4  # within room / 4
        half, beside = sqrt_near(square, bits), [-room, room]
    roots = [middle + side * half + x for side in (-1, 1) for x in beside]
    return [x for x in roots if first < x < last]
