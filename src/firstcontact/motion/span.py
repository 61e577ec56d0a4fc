"""The times over which a query runs."""

from __future__ import annotations

import warnings
from typing import Any

from flint import fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import rational, to_double
from firstcontact.motion.moving import Moving
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.trajectory import Trajectory

UNIT = fmpq(0), fmpq(1)


def limits(motion: Any) -> tuple[fmpq, fmpq] | None:
    """The exact first and last time at which the motion has a pose; None when it goes on beyond its span."""
    if isinstance(motion, Sequence):
        return fmpq(0), motion.ends[-1]
    if isinstance(motion, Trajectory):
        return motion.times[0], motion.times[-1]
    return UNIT if isinstance(motion, RationalMotion) else None


def common_span(a: Any, b: Any, span: Any) -> tuple[fmpq, fmpq | None]:
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
        raise InputError(f"span is {span!r}; give two times (first, last)") from error
    first = rational(lo, "span start")
    endless = isinstance(hi, float) and hi == float("inf")
    last = None if endless else rational(hi, "span end")
    if last is not None and last < first:
        raise InputError(f"span is ({lo}, {hi}); its end lies before its start")
    for motion, limit in zip(motions, own, strict=True):
        if limit is not None and (first < limit[0] or last is None or last > limit[1]):
            ends = to_double(limit[0]), to_double(limit[1])
            raise InputError(f"span {span!r} leaves the span {ends} of the {type(motion).__name__}")
    return first, last
