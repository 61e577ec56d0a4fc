"""The walk by lines and planes: edges against edges, then vertices against facets, arc by arc, all by halving.

At the start edges are put to facets.  The pair tests, their bounds and what is noted are those of the walk over boxes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel
from firstcontact.search.lifted.facet_halving import FacetTables, Paths, halve_facets
from firstcontact.search.lifted.halving import Edges, Room, halve
from firstcontact.search.lifted.lifted_motion import arc_of
from firstcontact.search.trees.state import ARC, BEST, DONE, KEY, LIFTED, PHASE, QUERY, STACK

if TYPE_CHECKING:
    from firstcontact.search.trees.state import WalkState

# Phases: edges against facets at the start, then within each arc the three kinds of contact.
EDGES_AT_START, FACETS_AT_START, EDGES, CORNERS, FACETS, PHASES = range(6)
# Here edges or vertices of b are put to facets of a.
_OF_B = FACETS_AT_START, FACETS


class LiftedBody(NamedTuple):
    """What the walk needs of one body; xyz: its tree's parts.  still: its edges as they stand."""

    edges: Edges
    still: Paths
    corners: Paths
    facets: FacetTables
    xyz: np.ndarray


def lifted_walk(
    a: LiftedBody, b: LiftedBody, frame: tuple[np.ndarray, float], room: Room, motion: np.ndarray, reach: float,
    errors: tuple[float, float], limit: int, state: WalkState,
    searches: Mapping[int, Callable[[int], int]] = MappingProxyType({}),
) -> int:  # fmt: skip
    """Go on with the walk until one of the reasons of `state` to come back; returns it.

    frame: origin and scale of lines and planes.  reach: a time after which certainly nothing meets (translations).
    errors: of the parts of a and of b.  searches: what to ask instead, by phase and with the number of the arc.
    """
    floats, integers = state.floats, state.integers
    search = a.xyz, b.xyz, *errors, limit, floats, integers, state.times, state.candidates
    if integers[PHASE] == EDGES_AT_START and integers[LIFTED] == 2:
        integers[PHASE] = EDGES
    while True:
        phase, arc = int(integers[PHASE]), int(integers[ARC])
        if phase >= EDGES:
            exists, over = arc_of(motion, floats, arc)
            if not exists:
                floats[KEY] = floats[BEST]
                return DONE
            if over:
                integers[ARC] += 1
                continue
        if phase in searches:
            reason = searches[phase](arc)
        else:
            asker, asked = (b, a) if phase in _OF_B else (a, b)
            paths = asker.still if phase < EDGES else asker.corners
            reason = _halve(phase, a.edges, b.edges, paths, asked.facets, *frame, room, motion, arc, reach, *search)
        if reason != DONE:
            return reason
        integers[STACK], integers[QUERY] = 1, 0
        integers[PHASE] = phase + 1
        if phase + 1 == PHASES:
            integers[PHASE] = EDGES
            integers[ARC] += 1


@kernel
def _halve(phase, edges_a, edges_b, paths, facets, origin, scale, room, motion, arc, reach, xyz_a, xyz_b, err_a, err_b,
           limit, floats, integers, times, candidates):  # fmt: skip
    """Go on with the phase; returns why it stopped.  One kernel of both kinds: most of what they call is shared."""
    if phase == EDGES:
        return halve(edges_a, edges_b, origin, scale, room, motion, arc, reach, xyz_a, xyz_b, err_a, err_b, limit,
                     floats, integers, times, candidates)  # fmt: skip
    return halve_facets(
        paths, facets, origin, scale, room, phase < EDGES, phase in _OF_B, motion, arc, reach, xyz_a, xyz_b,
        err_a, err_b, limit, floats, integers, times, candidates,
    )  # fmt: skip
