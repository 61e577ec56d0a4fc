"""Events of two models in ball arithmetic: what rounding errors hide from the search in doubles.

Boxes that survive a slab of time hold all its events.  Each is a zero of a square system in its place and the time; all
zeros in the boxes are isolated, and those that are not on both models dropped.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, arb_mat, fmpq

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import outcomes
from firstcontact.body.solid.features import Edge, Face, Vertex, enclosure
from firstcontact.exact.numbers import ball, dyadic, exact_value, precision
from firstcontact.exact.systems.isolation import isolated
from firstcontact.exact.systems.square_systems import Equations, FormEquations, Rows
from firstcontact.kernels.events.event_search import (
    AT_U,
    AT_V,
    BEGIN,
    BODY,
    CHART,
    END,
    END_PAIR,
    FIRST_PAIR,
    FORM,
    HALF_U,
    HALF_V,
    OTHER_FORM,
    OWN_FORM,
    PAIR,
)
from firstcontact.kernels.events.feature_boxes import ERROR, NOISE
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.events.event_tables import Tables, crossing_surfaces
from firstcontact.search.events.pose_jets import PoseJet, relative_jet

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

BITS, TOLD = 192, 128
"""Of the balls, and of the zeros found with them."""
MOST = 100
"""Boxes looked at in balls for one box of the search."""
MOST_BOXES = 64
"""Boxes of the search that are looked at, with a pair of features each."""
MOST_OPEN = 10
"""Signs that balls leave open at a place, all patterns of which are looked at."""

Feature = Face | Edge | Vertex


def earliest_event(
    bodies: tuple[Body, Body], tables: Tables, window: Window, boxes: np.ndarray, first: fmpq, last: fmpq, fine: fmpq,
    most: int,
) -> tuple[bool, fmpq | None, int]:  # fmt: skip
    """(whether balls tell; a time after `first` before which the boxes hold no event, None where they hold none up to
    `last`, that included; how many boxes were looked at in balls, at most so many).

    fine: how well the time is to be known.
    """
    pairs = [(box, pair) for box in boxes for pair in _pairs_of(tables, box)]
    if len(pairs) > MOST_BOXES:
        return False, None, 0
    found: fmpq | None = None
    left = most
    with precision(BITS):
        jets = PoseJet(bodies[0], window), PoseJet(bodies[1], window)
        for box, pair in pairs:
            place = EventPlace(bodies, tables, jets, int(box[CHART]), pair)
            times, looked = place.times(box, fine, min(left, MOST))
            left -= looked
            for time in times:
                if time <= first + fine:
                    return False, None, most - left
                if time <= (last if found is None else found):
                    found = time
    return True, found, most - left


def _pairs_of(tables: Tables, box: np.ndarray) -> Sequence[int]:
    if box[PAIR] >= 0:
        return (int(box[PAIR]),)
    return range(*(int(tables.info[int(box[CHART]), k]) for k in (FIRST_PAIR, END_PAIR)))


class EventPlace:
    """Where and when a pair of features may begin to touch."""

    def __init__(
        self, bodies: tuple[Body, Body], tables: Tables, jets: tuple[PoseJet, PoseJet], chart: int, pair: int
    ) -> None:
        self.tables, self.chart = tables, chart
        self.side = int(tables.info[chart, BODY])
        self.own: CompositeQuadric = shape_of(bodies[self.side])
        self.other: CompositeQuadric = shape_of(bodies[1 - self.side])
        self.jets = jets if self.side == 0 else (jets[1], jets[0])
        self.feature: Feature = tables.features[chart]
        self.row = tables.pairs[pair]
        self.theirs = [int(self.row[k]) for k in (FORM, OTHER_FORM) if self.row[k] >= 0]

    def times(self, box: np.ndarray, fine: fmpq, most: int) -> tuple[list[fmpq], int]:
        """(times before each of the events that the box may hold, within that of them where balls tell as well; how
        many boxes were looked at for it, at most so many)."""
        # the chart of an edge of degree 4 is of all that two surfaces share, whichever edge gives it its name
        if self.row[OWN_FORM] >= 0 and len(self.feature.surfaces) != 2:
            return [exact_value(float(box[BEGIN]))], 0
        start = self._start(box)
        if not all(c.is_finite() for c in start):
            return [exact_value(float(box[BEGIN]))], 0
        found: list[fmpq] = []

        def is_told(z: Sequence[arb]) -> bool:
            if self._is_elsewhere(z):
                return True
            if z[-1].rad() > fine:
                return False
            found.append(_lower(z))
            return True

        isolation = isolated(self._system(start), [start], most, is_told)
        places = [*(zero.balls(TOLD) for zero in isolation.zeros), *isolation.left]
        return found + [_lower(z) for z in places if not self._is_elsewhere(z)], isolation.looked

    def _start(self, box: np.ndarray) -> list[arb]:
        """The unknowns over all of the box: place, unless that is a vertex, and time."""
        begin, end = (exact_value(float(box[k])) for k in (BEGIN, END))
        time = arb((begin + end) / 2, (end - begin) / 2)
        return [time] if isinstance(self.feature, Vertex) else [*self._points(box), time]

    def _points(self, box: np.ndarray) -> list[arb]:
        """All points of the box of the chart, in the own model's frame."""
        u, v = (
            arb(exact_value(float(box[k])), exact_value(float(box[h]))) for k, h in ((AT_U, HALF_U), (AT_V, HALF_V))
        )
        powers = [arb(1), u, v, u * u, u * v, v * v]
        sizes = [float(abs(x).upper()) for x in powers]
        table = self.tables.charts[self.chart, :24].reshape(6, 4)
        off = arb(0, exact_value(NOISE * float((np.array(sizes) @ np.abs(table)).max())))
        x = [sum((arb(float(c)) * p for c, p in zip(column, powers, strict=True)), off) for column in table.T]
        return self._in_own_frame([c / x[3] for c in x[:3]])

    def _in_own_frame(self, x: Sequence[arb]) -> list[arb]:
        *centre, half = (arb(float(c)) for c in self.tables.units[self.side])
        return [m + half * c for m, c in zip(centre, x, strict=True)]

    def _system(self, start: Sequence[arb]) -> Equations:
        theirs = [_scaled(self.other, k) for k in self.theirs]
        if isinstance(self.feature, Vertex):
            return VertexEvent(self._vertex(), theirs[0], self.jets)
        crossing = crossing_surfaces(self.own, self.feature) if isinstance(self.feature, Edge) else None
        mine = [_scaled(self.own, k) for k in crossing or self.feature.surfaces[:1]]
        return PlacedEvent(mine, theirs, self.jets, start)

    def _vertex(self) -> list[arb]:
        """Its place, and those beside it that belong to it."""
        assert isinstance(self.feature, Vertex)
        off = exact_value(float(self.tables.charts[self.chart, ERROR])) * exact_value(self.tables.units[self.side, 3])
        return [ball(c) + arb(0, off) for c in enclosure(self.feature.carrier)]

    def _is_elsewhere(self, z: Sequence[arb]) -> bool:
        """Whether no such place and time is proved to be on both closed models."""
        x = [*(z[:3] if len(z) > 1 else self._vertex()), arb(1)]
        m, _ = relative_jet(self.jets, z[-1])
        there = (m * arb_mat([[c] for c in x])).entries()
        return _is_off(self.other, self.theirs, there) or _is_off(self.own, self.feature.surfaces, x)


def _lower(z: Sequence[arb]) -> fmpq:
    return dyadic(arb(z[-1].lower()))


def _is_off(model: CompositeQuadric, on: Sequence[int], x: Sequence[arb]) -> bool:
    """Whether the ball x, on those surfaces, is proved to hold no point of the closed model."""
    signs = []
    for k, surface in enumerate(model.surfaces):
        value = surface.value(x)
        signs.append(0 if k in on else int(value > 0) - int(value < 0))
    return signs.count(0) <= MOST_OPEN and True not in outcomes(model.tree, signs)


def _scaled(model: CompositeQuadric, k: int) -> Rows:
    """The form of a surface as balls, its largest entry 1."""
    rows = model.surfaces[k].matrix()
    largest = max(abs(c) for row in rows for c in row)
    return [[arb(c / largest) for c in row] for row in rows]


class VertexEvent(Equations):
    """A vertex comes to a surface; unknown: the time."""

    def __init__(self, place: Sequence[arb], form: Rows, jets: tuple[PoseJet, PoseJet]) -> None:
        self.place, self.form, self.jets = arb_mat([[*place, 1]]).transpose(), arb_mat(form), jets

    def values(self, z: Sequence[arb]) -> list[arb]:
        return self._image(z)[0]

    def jacobian(self, z: Sequence[arb]) -> list[list[arb]]:
        return [self._image(z)[1]]

    def _image(self, z: Sequence[arb]) -> tuple[list[arb], list[arb]]:
        m, by_t = relative_jet(self.jets, z[0])
        there = m * self.place
        image = self.form * there
        return (there.transpose() * image).entries(), (2 * (by_t * self.place).transpose() * image).entries()


class PlacedEvent(FormEquations):
    """Two features touch; unknowns: the place in the own model's frame, and the time.

    Where an edge touches a face, all three gradients are in one plane; of two faces they are parallel, and so in one
    plane with any vector.
    """

    def __init__(
        self, mine: list[Rows], theirs: list[Rows], jets: tuple[PoseJet, PoseJet], start: Sequence[arb]
    ) -> None:
        self.mine, self.theirs, self.jets = mine, [arb_mat(rows) for rows in theirs], jets
        if len(mine) + len(theirs) == 2:
            self.across = _across(mine[0], start)

    def at(self, u: arb) -> tuple[list[Rows], list[Rows]]:
        m, by_t = relative_jet(self.jets, u)
        back, still = m.transpose(), [[arb(0)] * 4 for _ in range(4)]
        forms, slopes = list(self.mine), [still] * len(self.mine)
        for form in self.theirs:
            half = by_t.transpose() * form * m
            forms.append((back * form * m).tolist())
            slopes.append((half + half.transpose()).tolist())
        return forms, slopes


def _across(form: Rows, start: Sequence[arb]) -> list[list[arb]]:
    """Two axes that with the gradient of the form there span space, as far as doubles tell."""
    point = [*start[:3], arb(1)]
    gradient = [abs(float(sum((c * x for c, x in zip(row, point, strict=True)), arb(0)).mid())) for row in form[:3]]
    steepest = int(np.argmax(gradient))
    return [[arb(int(j == k)) for j in range(3)] for k in range(3) if k != steepest]
