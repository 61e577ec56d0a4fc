"""Surfaces in pieces, cut about the places that doubles leave open: exact arithmetic is asked for little more.

What certified arcs and exact ones share then are crossings of the cuts, far from all that is singular.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from firstcontact.body.ruled.strip import RuledStrip

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled
    from firstcontact.body.ruled.surface import RuledSurface

# Left on both sides of a place, in parts of the range of u, or of the half turn atan(u) of the projective line.
ROOM = 2.0**-5
# Cuts are multiples of one over it, in parts of the range: a prime, for hand-made surfaces have nothing special there.
GRID = 10007
# More places than this stay in one piece.
MOST_PLACES = 16

Range = tuple[float, float]


def cut_about(surface: RuledSurface, places: Sequence[Range]) -> Ruled:
    """The strip of pieces of a RuledSurface some of which hold the places, ranges of u; itself where they fill it.

    They fill a range of u whose ends are one double.
    """
    if surface.u is not None and float(surface.u[0]) == float(surface.u[1]):
        return surface
    low, high = (-0.5, 0.5) if surface.u is None else (0.0, 1.0)
    rooms = list(_rooms([tuple(_share(surface, u) for u in place) for place in places]))  # type: ignore[misc]
    if len(rooms) > MOST_PLACES or (surface.u is None and (rooms[0][0] <= low or rooms[-1][1] >= high)):
        return surface
    cuts = list(dict.fromkeys(_parameter(surface, x) for room in rooms for x in room if low < x < high))
    if surface.u is not None:
        first, last = surface.u
        cuts = [first, *(u for u in cuts if first < u < last), last]  # one next to an end may be rounded to it
        pieces = [surface._with(u=u, joined=surface.joined | {"u0", "u1"}) for u in pairwise(cuts)]
        for k, end in ((0, "u0"), (-1, "u1")):
            if end not in surface.joined:
                pieces[k] = pieces[k]._with(joined=pieces[k].joined - {end})
    else:
        pieces = [surface._with(u=u, joined=frozenset({"u0", "u1"})) for u in pairwise([*cuts, cuts[0]])]
    return RuledStrip(pieces) if len(pieces) > 1 else surface


def _rooms(places: Sequence[Range]) -> Iterator[Range]:
    """The places with room about them, ascending; those that overlap are one."""
    room: list[float] = []
    for lo, hi in sorted(places):
        if room and lo - ROOM <= room[1] + ROOM:
            room[1] = max(room[1], hi + ROOM)
            continue
        if room:
            yield room[0], room[1]
        room = [lo - ROOM, hi + ROOM]
    yield room[0], room[1]


def _share(surface: RuledSurface, u: float) -> float:
    if surface.u is None:
        return math.atan(u) / math.pi
    low, high = (float(x) for x in surface.u)
    return (u - low) / (high - low)


def _parameter(surface: RuledSurface, share: float) -> Fraction:
    """A rational u next to a share of the range."""
    if surface.u is None:
        return Fraction(round(math.tan(math.pi * share) * GRID), GRID)
    low, high = surface.u
    return low + (high - low) * Fraction(round(share * GRID), GRID)
