"""A long course, asked part by part: what is found is told as it comes, and no more than a part is held at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from flint import fmpq

from firstcontact import query
from firstcontact.exact.numbers import to_double
from firstcontact.mechanism.course import Course
from firstcontact.motion.span import common_span
from firstcontact.result import FirstContact, Stats, Status

if TYPE_CHECKING:
    from typing import Unpack

    from firstcontact.body.kinds import Body
    from firstcontact.work import FirstArguments

STRETCHES = 512
"""Of a part: always as many, so that answers do not tell how fast the machine is."""


class MetPair(NamedTuple):
    """What a pair meets first; pair: its number among those of the course."""

    pair: int
    hit: FirstContact


class CoursePart(NamedTuple):
    """What was found from one waypoint to another, earliest first."""

    begin: int
    end: int
    found: list[MetPair]


@dataclass
class OpenPair:
    """A pair that has met nothing yet: its bodies along the whole course, the times that are asked about."""

    a: Body
    b: Body
    first: fmpq
    last: fmpq
    stats: Stats
    free: FirstContact | None = None

    def within(self, begin: fmpq, end: fmpq) -> tuple[fmpq, fmpq] | None:
        """The times of a part; None where there are none, or but one that the part before has asked about."""
        first, last = max(begin, self.first), min(end, self.last)
        return (first, last) if first < last or first == last == self.first else None

    def told(self, hit: FirstContact) -> FirstContact:
        """The answer of a part as one about the whole course."""
        whole = (to_double(self.first), to_double(self.last))
        self.stats = self.stats + replace(hit.stats, ways=())
        ways = hit.stats.ways
        return replace(hit, a=self.a, b=self.b, span=whole, stats=replace(self.stats, ways=ways))


class CourseSearch:
    """The first contacts of a course, part by part: those of `Course.first_contacts`, in the order of their times.

    against: other bodies.  begin: the waypoint from which on to ask.  settled: numbers of the pairs that need not be
    asked any more.  arguments: of `first_contact`.
    """

    def __init__(
        self, course: Course, against: Iterable[Body] = (), *, begin: int = 0, settled: Iterable[int] = (),
        **arguments: Unpack[FirstArguments],
    ) -> None:  # fmt: skip
        self.course, self.against, self.begin, self.arguments = course, list(against), begin, arguments
        self._open = {k: _asked(a, b) for k, (a, b) in enumerate(self.pairs())}
        self.count = len(self._open)
        for k in settled:
            del self._open[k]

    def pairs(self) -> Iterator[tuple[Body, Body]]:
        """All pairs along the whole course."""
        return self.course.pairs(self.against)

    def parts(self, progress: Callable[[int], None] | None = None) -> Iterator[CoursePart]:
        """progress: called with the number of stretches that are behind."""
        last = len(self.course.times) - 1
        while self.begin < last:
            begin, end = self.begin, min(self.begin + STRETCHES, last)
            part = CoursePart(begin, end, self._met(begin, end, progress))
            self.begin = end
            yield part
        if progress is not None:
            progress(last)

    def free(self) -> Iterator[MetPair]:
        """What has met nothing until the end, when all parts have been asked."""
        for k, pair in self._open.items():
            hit = pair.free
            if hit is None:  # it has been asked about by a run that was interrupted
                hit = query.first_contact(pair.a, pair.b, (pair.last, pair.last), **self.arguments)
            yield MetPair(k, replace(pair.told(hit), free_until=to_double(pair.last)))

    def _met(self, begin: int, end: int, progress: Callable[[int], None] | None) -> list[MetPair]:
        part = self.course.during(begin, end)
        times = part.times[0], part.times[-1]
        found, waiting = [], len(self._open)
        pairs = ((k, *pair) for k, pair in enumerate(part.pairs(self.against)) if k in self._open)
        for done, (k, a, b) in enumerate(pairs):
            if progress is not None:
                progress(begin + (end - begin) * done // waiting)
            pair = self._open[k]
            span = pair.within(*times)
            if span is None:
                continue
            hit = query.first_contact(a, b, span, **self.arguments)
            if hit.status is Status.FREE:
                pair.stats, pair.free = pair.stats + replace(hit.stats, ways=()), replace(hit, stats=Stats())
            else:
                found.append(MetPair(k, pair.told(hit)))
        for k, _ in found:
            del self._open[k]
        return sorted(found, key=lambda x: (_when(x.hit), x.pair))


def _when(hit: FirstContact) -> float:
    """When a pair met, or until when it is proved not to."""
    known = hit.free_until if hit.time is None else hit.time
    return float("-inf") if known is None else known


def _asked(a: Body, b: Body) -> OpenPair:
    first, last = common_span(a, b, None)
    assert last is not None  # a course ends
    return OpenPair(a, b, first, last, Stats())
