"""Distance tools beside `firstcontact` on curved solids, all in the same loop.

A peer offers ``name``, ``shape(kind, numbers)`` (what it builds once; None where it has no such shape) and
``distance(a, b)`` for two shapes, which returns a function of two poses (R, v).  Making a peer imports its tool.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from time import perf_counter
from typing import Any

TOLERANCE = 1e-9
"""Of the span: the loop ends in contact when the proved step is no longer."""
MAX_STEPS = 2000

PEERS = {
    "coal": "convex_tools.Coal",
    "python-fcl": "convex_tools.PythonFcl",
    "mujoco": "convex_tools.Mujoco",
    "OpenCASCADE": "open_cascade.OpenCascade",
}


@dataclass
class Found:
    """time: of contact, None without one; trouble: why there is no answer, "" if there is; negative: whether the last
    gap was below zero."""

    time: float | None
    seconds: float
    steps: int
    trouble: str = ""
    negative: bool = False


def installed(names: list[str]) -> tuple[list[Any], list[str]]:
    """The peers of these names, and the names of those whose tool is not installed."""
    found, missing = [], []
    for name in names:
        module, cls = PEERS[name].split(".")
        try:
            found.append(getattr(import_module(f"curved_peers.{module}"), cls)())
        except ImportError:
            missing.append(name)
    return found, missing


def advance(gap: Callable[[float], float], speed: float, limit: float) -> Found:
    """Conservative advancement over [0, 1].

    gap: distance at a time; speed: no point of one body is faster relative to the other; limit: seconds.
    A gap that is not positive ends the loop like any contact: whether it was one is the comparison's business.
    """
    start, t = perf_counter(), 0.0
    for steps in range(1, MAX_STEPS + 1):
        step = gap(t) / speed
        elapsed = perf_counter() - start
        if step != step:
            return Found(None, elapsed, steps, "no number")
        if step <= TOLERANCE:
            return Found(t, elapsed, steps, negative=step < 0.0)
        t += step
        if t > 1.0:
            return Found(None, elapsed, steps)
        if elapsed > limit:
            return Found(None, elapsed, steps, "too slow")
    return Found(None, perf_counter() - start, MAX_STEPS, "stuck")
