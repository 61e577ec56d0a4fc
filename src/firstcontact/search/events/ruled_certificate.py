"""Events of a ruled surface and a model in ball arithmetic: what rounding errors hide from the search in doubles.

Boxes that survive a slab of time hold all its events.  Each event is a zero of a square system in the free parameters
of the ruled surface's feature and the time; all zeros in the boxes are isolated, and those outside the model dropped.
Points are homogeneous: with S = M^T Q M, for the relative pose M, a surface of the model is f = X^T S X.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, arb_mat, fmpq

from firstcontact.body.solid.csg import outcomes
from firstcontact.body.solid.features import Edge, Face
from firstcontact.exact.numbers import dyadic, exact_value, precision
from firstcontact.exact.systems.isolation import isolated
from firstcontact.exact.systems.square_systems import Equations, Zero
from firstcontact.search.events.event_tables import crossing_surfaces
from firstcontact.search.events.pose_jets import PoseJet, relative_jet

if TYPE_CHECKING:
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.search.events.ruled_solids import RuledSolidEvent

MOST = 400
"""Boxes looked at in balls for one slab."""
PAD = 1e-15
"""Added to the sides of boxes of doubles."""


class EventSystem(Equations):
    """An event's equations; unknowns: its free ones of x and s, in this order, and the time.

    Equations and order as `search.events.ruled_charts` has them.
    """

    def __init__(self, event: RuledSolidEvent, poses: tuple[PoseJet, PoseJet]) -> None:
        self.own, self.other, self.free = event.own, event.other, event.free
        self.forms = [arb_mat(rows) for rows in event.surfaces]
        self.poses, self.cuts = poses, event.cuts
        self.way = poses[0].way

    def everywhere(self, z: Sequence[arb]) -> tuple[arb, arb, arb]:
        """x, s and the time."""
        free = iter(z)
        x, s = (next(free) if c is None else arb(c) for c in (self.own.x, self.own.s))
        return x, s, z[-1]

    def relative(self, t: arb) -> tuple[arb_mat, arb_mat]:
        """From the ruled surface's frame to the model's, and its derivative."""
        return relative_jet(self.poses, t)

    def there(self, z: Sequence[arb]) -> list[arb]:
        """The point in the model's frame, with weight 1."""
        x, s, t = self.everywhere(z)
        m, _ = self.relative(t)
        *xyz, w = (m * _column(self.own.sheet.at(self.way * t).point(x, s))).entries()
        return [*(c / w for c in xyz), arb(1)]

    def values(self, z: Sequence[arb]) -> list[arb]:
        return [row[0] for row in self._rows(z, False)]

    def jacobian(self, z: Sequence[arb]) -> list[list[arb]]:
        return [row[1:] for row in self._rows(z, True)]

    def _rows(self, z: Sequence[arb], deep: bool) -> list[list[arb]]:
        """Every equation: its value and, if deep, derivatives by the unknowns."""
        x, s, t = self.everywhere(z)
        sheet, rate, free = self.own.sheet.at(self.way * t), self.own.sheet.rate(self.way * t), self.free
        point = _column(sheet.point(x, s))
        first = {0: _column(sheet.by_x(x, s)), 1: _column(sheet.by_s(x))}
        second = {(0, 0): _column(sheet.by_xx(x, s)), (0, 1): _column(sheet.by_xs(x))}
        second |= {(1, 0): second[0, 1], (1, 1): arb_mat(4, 1)}
        m, by_t = self.relative(t)
        speed, speeds = arb_mat(4, 1), {0: arb_mat(4, 1), 1: arb_mat(4, 1)}
        if rate is not None:
            speed = _column(rate.point(x, s)) * self.way
            speeds = {0: _column(rate.by_x(x, s)) * self.way, 1: _column(rate.by_s(x)) * self.way}
        jets = []
        for q in self.forms:
            form = m.transpose() * q * m
            half = by_t.transpose() * q * m
            moved = half + half.transpose()
            image, drift = form * point, moved * point
            drift += form * speed  # half of the derivative of 2 form X by the time
            value, late = _dot(point, image), _dot(point, moved * point) + 2 * _dot(speed, image)
            slopes = [2 * _dot(first[k], image) for k in free]
            bends = [
                [2 * (_dot(second[j, k], image) + _dot(first[j], form * first[k])) for k in free]
                + [2 * (_dot(first[j], drift) + _dot(speeds[j], image))]
                for j in (free if deep else ())
            ]
            jets.append((value, slopes, late, bends))
        values = [[value, *slopes, late] for value, slopes, late, _ in jets]
        if self.cuts:
            return self._on_cuts(values, jets, self._cut_jets(x, s), deep)
        if isinstance(self.other, Face):
            ((_, slopes, _, bends),) = jets
            return values + [[f, *(bends[k] if deep else ())] for k, f in enumerate(slopes)]
        if isinstance(self.other, Edge) and len(free) == 2:
            return [*values, _parallel(jets[0], jets[1], deep)]
        return values

    def _cut_jets(self, x: arb, s: arb) -> list[Jet]:
        """As those of surfaces; the time is no part of inequalities."""
        found = []
        for cut in self.cuts:
            slopes, bends = cut.slopes(x, s), cut.bends(x, s)
            rows = [[*(bends[j, k] for k in self.free), arb(0)] for j in self.free]
            found.append((cut.value(x, s), [slopes[k] for k in self.free], arb(0), rows))
        return found

    def _on_cuts(self, values: list[list[arb]], jets: list[Jet], held: list[Jet], deep: bool) -> list[list[arb]]:
        values = values + [[value, *slopes, late] for value, slopes, late, _ in held]
        if isinstance(self.other, Face) and len(held) < len(self.free):
            values.append(_parallel(jets[0], held[0], deep))
        return values


Jet = tuple[arb, list[arb], arb, list[list[arb]]]
"""Of an equation: value, derivatives by the free parameters and by the time; those of the former, row by row."""


def _parallel(f: Jet, g: Jet, deep: bool) -> list[arb]:
    """The determinant of both derivatives, and its own derivatives."""
    (_, (a, b), _, of_f), (_, (c, d), _, of_g) = f, g
    row = [a * d - b * c]
    if deep:
        row += [of_f[0][k] * d + a * of_g[1][k] - of_f[1][k] * c - b * of_g[0][k] for k in range(3)]
    return row


def _column(entries: Sequence[arb]) -> arb_mat:
    return arb_mat([[c] for c in entries])


def _dot(x: arb_mat, y: arb_mat) -> arb:
    return (x.transpose() * y)[0, 0]


class Certificate:
    """What the boxes of one slab of time hold.

    events   those that are proved zeros of their systems and perhaps on both bodies, with enclosures of their times,
             the earliest first
    open     the earliest time of what is left undecided; None where nothing is
    most     boxes that may still be looked at
    """

    def __init__(
        self, model: CompositeQuadric, poses: tuple[PoseJet, PoseJet], begin: fmpq, end: fmpq, most: int
    ) -> None:
        self.model, self.poses, self.begin, self.end, self.most = model, poses, begin, end, most
        self.events: list[tuple[RuledSolidEvent, arb]] = []
        self.open: fmpq | None = None

    def add(self, event: RuledSolidEvent, boxes: Sequence[np.ndarray]) -> None:
        """The events of one pair of features in boxes of its chart."""
        system = EventSystem(event, self.poses)
        starts = [_ball_box(event, box) for box in boxes]
        found = isolated(system, starts, min(MOST, self.most), lambda box: self._is_outside(event, system, box))
        self.most -= found.looked
        with precision(256):
            for zero in found.zeros:
                self._add_zero(event, system, zero)
            for box in found.left:
                if not self._is_outside(event, system, box):
                    time = dyadic(arb(box[-1].lower()))
                    self.open = time if self.open is None else min(self.open, time)

    def _add_zero(self, event: RuledSolidEvent, system: EventSystem, zero: Zero) -> None:
        z = zero.balls(160)
        x, s, t = system.everywhere(z)
        if t > arb(self.end) or t < arb(self.begin) or x > 1 or x < -1 or s > 1 or s < 0:
            return
        if not self._is_outside(event, system, z):
            self.events.append((event.placed([dyadic(arb(c.mid())) for c in z]), t))
            self.events.sort(key=lambda e: float(e[1].mid()))

    def _is_outside(self, event: RuledSolidEvent, system: EventSystem, z: Sequence[arb]) -> bool:
        """Whether the point is proved not to belong to the closed model, or to be cut off the surface."""
        x, s, _ = system.everywhere(z)
        if any(cut.value(x, s) < 0 for k, cut in enumerate(event.own.sheet.cuts) if k not in event.numbers):
            return True
        there = system.there(z)
        if not all(c.is_finite() for c in there):
            return False
        on = set(_vanishing(event))
        signs = []
        for k, surface in enumerate(self.model.surfaces):
            value = surface.value(there)
            signs.append(0 if k in on else int(value > 0) - int(value < 0))
        return True not in outcomes(self.model.tree, signs)


def _vanishing(event: RuledSolidEvent) -> Iterator[int]:
    """Numbers of the model's surfaces that pass through the event."""
    if isinstance(event.other, Face):
        yield event.other.surfaces[0]
    elif isinstance(event.other, Edge):
        yield from crossing_surfaces(event.model, event.other)
    else:
        yield from event.other.surfaces


def _ball_box(event: RuledSolidEvent, box: np.ndarray) -> list[arb]:
    """The box of a chart's parameters and times, in the unknowns of the system."""
    sides = [(box[2], box[3]), (box[4], box[5])][: len(event.free)]
    sides.append((0.5 * (box[6] + box[7]), 0.5 * (box[7] - box[6])))
    return [
        arb(exact_value(float(m)), arb(exact_value(float(h)) + exact_value(PAD * (1.0 + abs(m))))) for m, h in sides
    ]
