"""The times over which a query runs."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import exact_value, rational, to_double
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation, turns_of
from firstcontact.motion.screw import Screw
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import LARGEST, Translation

if TYPE_CHECKING:
    from firstcontact.body.kinds import AnyBody
    from firstcontact.exact.numbers import Given
    from firstcontact.motion.kinds import AnyMotion

UNIT = fmpq(0), fmpq(1)
# Latest time of a query, as of all numbers of motions, but for slow shifts, which go so far at most: squares of longer
# ways are no longer doubles.
LATEST, FARTHEST = LARGEST, 2 * LARGEST
# Of slow shifts of curved bodies: where doubles end.
LAST_DOUBLE = fmpq(2) ** 1023
NEARER = "give a time below 2^150, or inf as the end of a translation"
# Full turns that are searched one by one, and whose contacts are listed: seconds; many more fill the memory.
MOST_TURNS = 10_000
_FEW_TURNS = Translation, Trajectory


def limits(motion: AnyMotion) -> tuple[fmpq, fmpq] | None:
    """`exact_span`; None of motions that are none of ours, which are refused later."""
    ends: tuple[fmpq, fmpq] | None = getattr(motion, "exact_span", None)
    return ends


def common_span(a: AnyBody, b: AnyBody, span: Iterable[Given] | None) -> tuple[fmpq, fmpq | None]:
    """The exact span (None: without end) of a query; by default the intersection of the motions' spans, which warns
    where these are not the same.

    InputError where a motion has no poses in all of it, where it is malformed, or where the motions share no time.
    """
    motions = [m.motion for m in (a, b) if isinstance(m, Moving)]
    if span is None and len(motions) < 2:
        return limits(motions[0]) or UNIT if motions else UNIT
    own = [limits(m) for m in motions]
    if span is None:
        spans = [limit or UNIT for limit in own]
        first, end = max(s[0] for s in spans), min(s[1] for s in spans)
        if end < first:
            raise InputError(f"the spans {' and '.join(str(m.span) for m in motions)} of the motions share no time")
        if spans[0] != spans[1]:
            given = " and ".join(str(m.span) for m in motions)
            common = to_double(first), to_double(end)
            warnings.warn(
                f"the motions have the spans {given}; the answer is about {common} only: give span=(first, last)",
                stacklevel=3,
            )
        return first, end
    try:
        if isinstance(span, str | set | frozenset | dict):  # of letters, or of no order
            raise TypeError
        lo, hi = span
    except (TypeError, ValueError) as error:
        raise InputError(f"span is {shown(span)}; give two times (first, last)") from error
    first = rational(lo, "span start")
    endless = isinstance(hi, float) and hi == float("inf")
    last = None if endless else rational(hi, "span end")
    if last is not None and last < first:
        raise InputError(f"span is ({lo}, {hi}); its end lies before its start")
    for what, given, time in (("start", lo, first), ("end", hi, last)):  # type: ignore[assignment]  # as it was given
        if time is not None and any(_is_far(motion, time) for motion in motions):
            raise InputError(f"span {what} is {shown(given)}; {NEARER}")
    for motion, limit in zip(motions, own, strict=True):
        if limit is not None and (first < limit[0] or last is None or last > limit[1]):
            ends = to_double(limit[0]), to_double(limit[1])
            raise InputError(
                f"span ({shown(lo)}, {shown(hi)}) leaves the span {ends} of the {type(motion).__name__}; ask within it"
            )
    return first, last


def refuse_late(times: tuple[fmpq, fmpq | None]) -> None:
    """InputError for a span beyond the doubles, which only slow shifts of polyhedra take."""
    for what, time in zip(("start", "end"), times, strict=True):
        if time is not None and abs(time) >= LAST_DOUBLE:
            raise InputError(f"span {what} lies beyond 2^1023; give a time below, or inf as the end of a translation")


def _is_far(motion: AnyMotion, time: fmpq) -> bool:
    """Whether the motion is not followed to that time."""
    if isinstance(motion, Translation):
        return bool(max(abs(v) for v in motion.vector) * abs(time) > FARTHEST)
    return bool(abs(time) >= LATEST)


def refuse_many_turns(
    a: AnyBody, b: AnyBody, first: fmpq, last: fmpq | None,
    kinds: tuple[type[Rotation | Screw | Linkage], ...] = (Rotation, Screw, Linkage),
) -> None:  # fmt: skip
    """InputError for a body that turns more than MOST_TURNS times in the span by a motion of these kinds."""
    for body in (a, b):
        if not isinstance(body, Moving) or isinstance(body.motion, _FEW_TURNS):
            continue  # between two poses it is half a turn at most
        motion = body.motion
        for step in [motion] if isinstance(motion, Linkage) else getattr(motion, "steps", [motion]):
            if isinstance(step, kinds):
                share = 1 if last is None or not getattr(motion, "extends", False) else last - first
                turns = exact_value(step.turns) if isinstance(step, Linkage) else turns_of(step) * share
                if turns > MOST_TURNS:
                    who = body.name or "a body"
                    raise InputError(
                        f"{who}: {step!r} makes {to_double(turns):.3g} full turns during the span, each of which is "
                        f"searched; ask about {MOST_TURNS} at a time by a shorter span="
                    )
