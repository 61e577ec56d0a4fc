"""What a picture of one pair of bodies needs, gathered from the results about that pair."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from firstcontact.errors import InputError
from firstcontact.motion.moving import Moving
from firstcontact.result import Absent, ContactIntervals, Element, FirstContact, Status
from firstcontact.result_curve import IntersectionCurve

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape

# What a stretch of the timeline says about the two bodies.
FREE, CONTACT, UNDECIDED, NOT_ASKED = "free", "contact", "undecided", "not asked"

Result = FirstContact | ContactIntervals | IntersectionCurve


@dataclass(frozen=True)
class PairView:
    """Two bodies and what is known about them: a first contact, the contact intervals, or both; or their curve."""

    a: Body
    b: Body
    span: tuple[float, float]
    first: FirstContact | None = None
    intervals: ContactIntervals | None = None
    curve: IntersectionCurve | None = None
    """Of bodies at rest: the span is (0, 0), and there is no timeline."""

    @property
    def names(self) -> tuple[str, str]:
        return self.a.name or "a", self.b.name or "b"

    @property
    def status(self) -> Status:
        result = self.intervals if self.first is None else self.first
        assert result is not None
        return result.status

    @property
    def contact_time(self) -> float | None:
        """The first time at which the bodies share a point, where it is known."""
        if self.first is not None and self.first.time is not None:
            return self.first.time
        if self.intervals is not None and len(self.intervals):
            return self.intervals[0].start
        return None

    @property
    def elements(self) -> tuple[list[Element], list[Element]]:
        """The elements that touch at the contact time: of a, and of b; the reported pair comes first."""
        if self.first is None or self.first.element_a is None or self.first.element_b is None:
            return [], []
        on_a = [self.first.element_a, *(pair.element_a for pair in self.first.others)]
        on_b = [self.first.element_b, *(pair.element_b for pair in self.first.others)]
        return list(dict.fromkeys(on_a)), list(dict.fromkeys(on_b))

    @property
    def moments(self) -> list[float]:
        """The finite times at which something happens, ascending: contact time and ends of intervals."""
        times = [] if self.contact_time is None else [self.contact_time]
        if self.intervals is not None:
            times += [t for interval in self.intervals for t in (interval.start, interval.end)]
        if self.first is not None and self.first.free_until is not None:
            times.append(self.first.free_until)
        return sorted({float(t) for t in times if math.isfinite(t)})

    @property
    def window(self) -> tuple[float, float]:
        """The finite stretch of the span that the picture shows: all of it, or all moments and some more."""
        lo, hi = self.span
        known = [t for t in (lo, hi) if math.isfinite(t)] + self.moments or [0.0]
        margin = max(1.0, 0.5 * (max(known) - min(known)))
        return (
            lo if math.isfinite(lo) else min(known) - margin,
            hi if math.isfinite(hi) else max(known) + margin,
        )

    @property
    def timeline(self) -> list[tuple[float, float, str]]:
        """Stretches (start, end, kind) that cover the window, ascending."""
        lo, hi = self.window
        if self.curve is not None:
            return []
        if self.intervals is not None:
            return _timeline_of_intervals(self.intervals, lo, hi)
        first = self.first
        assert first is not None
        if first.status is Status.FREE:
            return [(lo, hi, FREE)]
        if first.status is Status.INITIAL_CONTACT:
            return [(lo, hi, NOT_ASKED)]
        known = first.time if first.status is Status.CONTACT else first.free_until
        known = lo if known is None else min(max(known, lo), hi)
        after = NOT_ASKED if first.status is Status.CONTACT else UNDECIDED
        return [(lo, known, FREE), (known, hi, after)]


def _timeline_of_intervals(
    intervals: ContactIntervals, lo: float, hi: float
) -> list[tuple[float, float, str]]:
    known = hi
    if intervals.status is Status.UNDECIDED:
        known = lo if intervals.free_until is None else min(max(intervals.free_until, lo), hi)
    stretches, t = [], lo
    for interval in intervals:
        start, end = max(interval.start, lo), min(interval.end, hi)
        stretches += [(t, start, FREE), (start, end, CONTACT)]
        t = end
    known = max(known, t)
    stretches += [(t, known, FREE), (known, hi, UNDECIDED)]
    # Contact at a single time stays in; an empty stretch of anything else says nothing.
    return [s for s in stretches if s[0] < s[1] or s[2] == CONTACT]


def pairs_of(results: Iterable[Result]) -> list[PairView]:
    """One Pair for every two bodies, in the order of the results; both kinds of result in time share it."""
    pairs: list[PairView] = []
    for result in results:
        if not isinstance(result, Result):
            verbs = "first_contact, contact_intervals or intersection_curve"
            raise InputError(f"cannot draw {result!r}; give results of {verbs}")
        if result.a is None or result.b is None:
            raise InputError("cannot draw a result without its two bodies (fields a and b)")
        if isinstance(result.a, Absent) or isinstance(result.b, Absent):
            raise InputError("cannot draw a result that came without its bodies; pickle result.with_bodies() instead")
        if isinstance(result, IntersectionCurve):
            pairs.append(PairView(result.a, result.b, (0.0, 0.0), curve=result))
            continue
        kind = "first" if isinstance(result, FirstContact) else "intervals"
        added: dict[str, Any] = {kind: result}
        for k, pair in enumerate(pairs):
            same = pair.a is result.a and pair.b is result.b and pair.span == result.span and pair.curve is None
            if same and getattr(pair, kind) is None:
                pairs[k] = replace(pair, **added)
                break
        else:
            pairs.append(PairView(result.a, result.b, result.span, **added))
    if not pairs:
        raise InputError("nothing to draw: the list of results is empty")
    return pairs


def at_rest(body: Body) -> Shape:
    """The body itself, without its motion."""
    rest: Shape = body.body if isinstance(body, Moving) else body
    return rest


def is_moving(body: Body) -> TypeGuard[Moving]:
    return hasattr(body, "motion")


def pose(body: Body, t: float) -> np.ndarray:
    """The (4, 4) float64 pose of a body at time t, resting or moving."""
    return np.asarray(body.motion(t), float) if is_moving(body) else np.eye(4)
