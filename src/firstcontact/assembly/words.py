"""Answers in the terms of the motions: lengths, angles and steps instead of a parameter."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable
from typing import TYPE_CHECKING

from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import SPAN, Translation
from firstcontact.result import ContactIntervals, FirstContact

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion


def reading(bodies: Iterable[Body]) -> str:
    """What `time` counts in these motions."""
    motions = [x.motion for x in bodies if isinstance(x, Moving)]
    spans = {motion.span for motion in motions}
    if any(isinstance(motion, Trajectory) for motion in motions):
        return "time is that of the trajectory"
    if any(isinstance(motion, Linkage) for motion in motions):
        return "time is that of the joints' course"
    if spans <= {SPAN}:
        return "time is the share of the motion that is done, from 0 to 1"
    lo, hi = min(x[0] for x in spans), max(x[1] for x in spans)
    return f"time is that of the steps' durations, from {lo:g} to {hi:g}"


def progress(result: FirstContact | ContactIntervals, unit: str = "") -> str:
    """How far the bodies have moved at the first contact, or where the proof ends; "" where that says nothing."""
    if isinstance(result, FirstContact):
        time = result.free_until if result.time is None else result.time
    else:
        time = result[0].start if len(result) else result.free_until
    if time is None or not math.isfinite(time):
        return ""
    told = (_told(x, time, unit or result.unit or "") for x in (result.a, result.b) if isinstance(x, Moving))
    return "; ".join(x for x in told if x)


def _told(body: Moving, time: float, unit: str) -> str:
    how = _done(body.motion, time, unit)
    return f"{body.name or 'it'} {how}" if how else ""


def _done(motion: AnyMotion, time: float, unit: str) -> str:
    if isinstance(motion, Translation):
        length = math.hypot(*map(to_double, motion.vector))
        return f"has moved {_number(time * length)} of {_number(length)}{unit and ' ' + unit}"
    if isinstance(motion, Rotation | Screw):
        degrees, ahead = math.degrees(motion.radians), to_double(motion.advance)
        shift = f", {_number(time * ahead)} of {_number(ahead)}{unit and ' ' + unit} ahead" if ahead else ""
        return f"has turned {_number(time * degrees)} of {_number(degrees)} degrees{shift}"
    if isinstance(motion, Sequence):
        k = min(bisect_left([to_double(end) for end in motion.ends], time), len(motion.steps) - 1)
        start, end = to_double(motion.starts[k]), to_double(motion.ends[k])
        step = _done(motion.steps[k], (time - start) / (end - start), unit)
        return f"in step {k + 1} of {len(motion.steps)} {step}"
    if isinstance(motion, Linkage):
        k = motion.stretch(exact_value(time))
        return f"is between waypoints {k} and {k + 1}, counted from 0"
    if isinstance(motion, Trajectory):
        times = [to_double(t) for t in motion.times]
        k = max(1, min(bisect_left(times, time), len(times) - 1))
        return f"is between poses {k} and {k + 1} of {len(times)}"
    return f"has done {_number(100 * time)} % of its motion"


def _number(x: float) -> str:
    return f"{x + 0.0:.6g}"
