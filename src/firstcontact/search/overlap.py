"""What a start in contact is: touching or overlapping."""

from __future__ import annotations

from typing import Any

from firstcontact.search.earliest import Found


def initial_kind(problem: Any, found: Found) -> str:
    """ "touching" or "overlapping", for bodies whose surfaces share a point at the start."""
    if not (problem.a.solid or problem.b.solid):
        return "touching"  # without an interior nothing can be shared but the surface itself
    if any(crossing for _, crossing in found.start):
        return "overlapping"
    return "touching"
