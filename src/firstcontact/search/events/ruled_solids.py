"""First contact of a ruled surface and a composite quadric model under any motion: the first event, with a proof.

`search.events.events` proves all times before the first slab that may hold an event free.  A point of the ruled surface
that lies inside the model shortly after, by signs of all surfaces in ball arithmetic, closes the interval from above;
it is
found from the event: its place and time by Newton's method, then a step along the surface that leaves the event's
surfaces of the model equally far behind.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import inside
from firstcontact.body.solid.features import Edge, Face, Vertex, enclosure
from firstcontact.exact.numbers import below, dyadic, exact_value, precision, to_double
from firstcontact.exact.rigid import Matrix, compose, inverse_map
from firstcontact.kernels.events.event_search import (
    CHART,
    COUNT,
    CUTS,
    FREE,
    OTHER,
    OTHER_BEGIN,
    OTHER_END,
    OTHER_FORM,
    OWN,
    OWN_FORM,
    PAIR,
    SECOND_CUT,
    SPENT,
    VISITS,
)
from firstcontact.kernels.events.feature_boxes import (
    HERE,
    INSIDE,
    OUTSIDE,
    PLAIN,
    REST,
    SLOPE_T,
    SLOPE_U,
    THERE,
    VALUE,
    membership,
    model,
    place_box,
)
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.convex.advance import Advance
from firstcontact.search.events.event_tables import Tables, crossing_surfaces
from firstcontact.search.events.events import REACH, SPREAD, STAGES, EventSearch
from firstcontact.search.events.instants import PlacedForms
from firstcontact.search.events.pose_jets import PoseJet
from firstcontact.search.events.ruled_certificate import Certificate
from firstcontact.search.events.ruled_charts import ChartSheet, Mixed, RuledFeature, crossing_at
from firstcontact.search.events.shared_points import BITS, RANKS, ball_pose, mapped, middles
from firstcontact.work import WORTH

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

STEP = fmpq(1, 2**80)
"""Of differences in place of derivatives."""
REGULAR = 1e12
"""Condition of an event beyond which its place is left as the search knows it."""
SMOOTH = 1e-6
"""Slope of a surface, over that at the model's size from a tip, below which a place counts as one."""
ROUNDS = 4
TRIED = 24
"""Pairs of features that survive the search at a contact, for which it is made precise."""
SEEDS = 4
NEAR = 1e-5
"""Parts of the sizes of bodies and of ranges within which features count as near a place."""
KINDS = "vertex", "directrix", "end_ruling", "face"
MOST_HALVED = 3000
"""Boxes of the surface looked at to prove that it lies inside at the start."""
START_GRID = 12
"""Points of a sheet in either direction among which one inside the model is sought at the start."""


@dataclass(frozen=True)
class RuledSolidContact:
    """What was proved, as `search.convex.advance.Advance`; of a contact also the features and whether it is isolated.

    cut: the inequality at whose border the contact is.  boxes: (n, 8), what survives at `free_until` of an open search.
    """

    found: Advance
    feature: RuledFeature | None = None
    cut: int | None = None
    other: Face | Edge | Vertex | None = None
    isolated: bool = False
    boxes: np.ndarray | None = None


class RuledSearch(EventSearch):
    """The first common point of bodies a and b; `side` is the ruled one.

    way: -1 where the windows hold the motions backwards, at times -t.
    """

    def __init__(
        self, a: Body, b: Body, tables: Tables, stretches: list[Window], tolerance: float, budget: int, side: int
    ) -> None:
        super().__init__(a, b, tables, stretches, tolerance, budget)
        self.side = side
        self.way = 1
        self.event: RuledSolidEvent | None = None
        self.left: np.ndarray | None = None

    def contact(self, first: fmpq, last: fmpq) -> RuledSolidContact:
        found = self.run(below(first), last)
        if found.status == "open" and found.free_until <= self.windows[0].first and found.reason == "precision":
            point = self._sampled(first, True)
            if point is not None:
                found = replace(found, status="initial", point=point)
        if self.event is None:
            return RuledSolidContact(found, boxes=self.left)
        cut = min(self.event.numbers, default=None)
        with precision(BITS):
            isolated = self.event.regular and not found.spread and self.event.is_clear()
        return RuledSolidContact(found, self.event.own, cut, self.event.other, isolated)

    def is_away_from_boundary(self) -> bool:
        """True proves that no point of the surface lies on the model's boundary at the start."""
        start, t = self.windows[0], self.tables
        if not PlacedForms(t, start, self.scratch).place(start.first, start.first):
            return False
        table, z, stack = self.scratch.table, self.scratch.boxes, self.scratch.stack
        begin, end, base = t.layout[self.side, [OTHER_BEGIN, OTHER_END, OTHER]]
        boxes = [row[2:6].copy() for row in t.still]
        charts = [int(row[CHART]) for row in t.still]
        for _ in range(MOST_HALVED):
            if not boxes:
                return True
            k, box = charts.pop(), boxes.pop()
            if self._is_cut_off(k, box):
                continue
            if place_box(t.charts, k, *box, start.first, 0.0, z):
                found = membership(
                    t.program, begin, end, PLAIN, PLAIN, PLAIN, base, table, 0.0, 0.0, z, THERE, stack
                )
                if found != INSIDE | OUTSIDE:
                    continue
            wide = 0 if box[1] >= 2.0 * box[3] else 2
            for sign in (-1.0, 1.0):
                half = box.copy()
                half[wide] += sign * 0.5 * box[wide + 1]
                half[wide + 1] = 0.5 * box[wide + 1] * (1.0 + 1e-15) + 2.0**-50
                boxes.append(half)
                charts.append(k)
        return False

    def _is_cut_off(self, chart: int, box: np.ndarray) -> bool:
        """Whether an inequality is proved to hold nowhere in a box of a resting chart."""
        t, z, table = self.tables, self.scratch.boxes, self.scratch.table
        for k in range(t.info[chart, CUTS]):
            if place_box(t.charts, chart + 1 + k, *box, 0.0, 0.0, z):
                model(table, t.layout[self.side, OWN] + k, 0.0, 0.0, z, PLAIN, HERE)
                if z[HERE, VALUE] > np.abs(z[HERE, SLOPE_U : SLOPE_T + 1]).sum() * (1 + 1e-14) + z[HERE, REST]:
                    return True
        return False

    def has_points_outside(self, t: fmpq) -> bool:
        """True proves that a point of the surface lies outside the model at t."""
        return self._sampled(t, False) is not None

    def _sampled(self, t: fmpq, within: bool) -> np.ndarray | None:
        """A point of the surface proved inside (or outside) the model at t, in the world; the first of a grid."""
        features: Any = self.tables.features
        sheets = list({id(feature.sheet): feature.sheet for feature in features}.values())
        return _sampled(self.bodies, self.side, sheets, t, within)

    def _contact(self, window: Window, last: fmpq) -> Advance:
        lo, hi = float(self.result[0]), float(self.result[1])
        count, start = int(self.result[2]), int(self.result[3])
        boxes = self.pool[start : start + count].copy()
        with precision(BITS):
            for event in self._events(boxes, lo):
                latest = lo + 0.98 * self.width
                soon = math.nextafter(math.nextafter(max(event.time, lo), math.inf), math.inf)
                for at in (soon, min(max(soon, hi) + 0.05 * self.width, latest), latest):
                    if lo <= at <= latest and exact_value(at) <= last and event.leads_inside(at):
                        self.event = event
                        point, normal = event.geometry()
                        return self._answer(
                            "contact", lo, time=min(max(event.time, lo), at), time_interval=(lo, at), point=point,
                            normal=normal, spread=self._is_spread(boxes),
                        )  # fmt: skip
        self.left = boxes
        return self._answer("open", lo, reason="precision")

    # -- in balls -------------------------------------------------------------------------------------------

    def _first_event(self, window: Window, t: float, last: fmpq) -> Advance | None:
        """From t on; None where there is none.  Where rounding errors hide it, balls take over for a while."""
        for stage in range(STAGES):
            found = self._in_doubles(window, t, last)
            if found is None or found.status != "open" or found.reason != "precision":
                return found
            ahead = self.in_balls(window, found.free_until, stage)
            if ahead is None:
                return found
            t, known = ahead
            if known is not None:
                told = self._certified(known, t, last)
                return replace(told, reason="budget") if told.status == "open" and self.is_spent else told
            if t >= window.last:
                return None
        return self._answer("open", t, reason="precision")

    def in_balls(self, window: Window, lo: float, stage: int) -> tuple[float, Certificate | None] | None:
        """(a time from lo on before which all is free, what may happen then); None where that is not told.

        stage: how often balls have told before; they look ahead four times as far each time.
        """
        end = min(lo + REACH * 4.0**stage * self.width, window.last)
        outcome = self.covered(window, lo, end)
        if outcome == FREE:
            return end, None
        if outcome == SPENT:
            return None
        with precision(BITS):
            own, other = (PoseJet(self.bodies[k], window, self.way) for k in (self.side, 1 - self.side))
            known = self._certificate((own, other), lo, end)
            if known.open is None and not known.events:
                return end, None
            starts = [known.open] if known.open is not None else []
            if known.events:
                starts.append(dyadic(arb(known.events[0][1].lower())))
            return max(lo, below(min(starts))), known

    def _certificate(self, poses: tuple[PoseJet, PoseJet], lo: float, end: float) -> Certificate:
        """Of the boxes that are left in the pool."""
        count, start = int(self.result[2]), int(self.result[3])
        pairs: dict[tuple[int, int], list[np.ndarray]] = {}
        for box in self.pool[start : start + count].copy():
            chart, pair = int(box[CHART]), int(box[PAIR])
            for k in range(*self.tables.info[chart, 3:5]) if pair < 0 else (pair,):
                pairs.setdefault((chart, k), []).append(box)
        model: CompositeQuadric = shape_of(self.bodies[1 - self.side])
        most = max(self.budget - self.done, 0) // WORTH
        known = Certificate(model, poses, exact_value(lo), exact_value(end), most)
        for (chart, pair), boxes in sorted(pairs.items(), key=lambda item: self._rank((item[0], None))):
            known.add(RuledSolidEvent(self.bodies, self.side, self.tables, chart, pair, boxes[0]), boxes)
        self.counters[VISITS] += WORTH * (most - known.most)
        self.is_spent = self.is_spent or known.most == 0
        return known

    def _certified(self, known: Certificate, lo: float, last: fmpq) -> Advance:
        """The answer where all events in a slab are known, all before lo being free."""
        with precision(BITS):
            return self._proved(known, lo, last)

    def _proved(self, known: Certificate, lo: float, last: fmpq) -> Advance:
        for event, time in known.events:
            soon = math.nextafter(float(time.upper()), math.inf)
            for at in (soon, soon + 0.01 * self.width, lo + 0.98 * self.width):
                if not (lo <= at <= lo + self.width and exact_value(at) <= last and event.leads_inside(at)):
                    continue
                self.event = event
                point, normal = event.geometry()
                others = [e.geometry()[0] for e, t in known.events if t.overlaps(time)]
                spread = bool(np.ptp(others, axis=0).max() > SPREAD * float(self.tables.units[self.side, 3]))
                return self._answer(
                    "contact", lo, time=min(max(event.time, lo), at), time_interval=(lo, at), point=point,
                    normal=normal, spread=spread,
                )  # fmt: skip
        return self._answer("open", lo, reason="precision")

    def _events(self, boxes: np.ndarray, earliest: float) -> Iterator[RuledSolidEvent]:
        """Events in the boxes: those that Newton's method fixes, the earliest first, then those of lower features; then
        those of other features near the boxes (a tip, for a cone that looks tangent there); then all the others."""
        here: dict[tuple[int, int], np.ndarray] = {}
        for box in boxes:
            if box[PAIR] >= 0:
                here.setdefault((int(box[CHART]), int(box[PAIR])), box)
        regular, others = self._refined(here, earliest)
        yield from regular
        beside = {key: box for box in boxes[:SEEDS] for key in self._near(box) if key not in here}
        yield from self._refined(beside, earliest)[0]
        yield from others

    def _refined(
        self, pairs: dict[tuple[int, int], np.ndarray], earliest: float
    ) -> tuple[list[RuledSolidEvent], list[RuledSolidEvent]]:
        """(events that are fixed within the width after that time, those that are not)."""
        regular, others = [], []
        for (chart, pair), box in sorted(pairs.items(), key=self._rank)[:TRIED]:
            event = RuledSolidEvent(self.bodies, self.side, self.tables, chart, pair, box)
            if event.refine() and event.regular and earliest <= event.time <= earliest + self.width:
                regular.append(event)
            else:
                others.append(RuledSolidEvent(self.bodies, self.side, self.tables, chart, pair, box))
        return sorted(regular, key=lambda event: event.time), others  # stable: the lowest features first

    def _near(self, box: np.ndarray) -> Iterator[tuple[int, int]]:
        """Numbers of charts and pairs whose features pass near the middle of a box."""
        features: Any = self.tables.features
        feature = features[int(box[CHART])]
        place = feature.place(float(box[2]), float(box[4]))
        shape = self.bodies[1 - self.side]
        model: CompositeQuadric = shape_of(shape)
        t = exact_value(float(0.5 * (box[6] + box[7])))
        m = compose(inverse_map(ball_pose(self.bodies[1 - self.side], t)), ball_pose(self.bodies[self.side], t))
        there = middles(m) @ [*_in_doubles(feature.sheet.at(t), *place), 1.0]
        size = NEAR * float(self.tables.units[1 - self.side, 3])
        on = _surfaces_near(model, there, float(self.tables.units[1 - self.side, 3]))
        for chart, own in enumerate(features):
            if own.sheet is not feature.sheet or not own.is_near(place, NEAR):
                continue
            for pair in range(*self.tables.info[chart, 3:5]):
                other = self.tables.others[pair]
                if isinstance(other, Vertex):
                    near = bool(np.abs(np.subtract(other.position, there)).max() < size)
                else:
                    near = all(on[k] for k in (other.surfaces[:1] if isinstance(other, Face) else other.surfaces))
                cuts = [own.sheet.cuts[k] for k in cuts_of(self.tables, self.side, pair)]
                x, s = (exact_value(c) for c in place)
                if near and all(abs(cut.value(x, s)) < exact_value(NEAR) * cut.size for cut in cuts):
                    yield chart, pair

    def _rank(self, item: tuple[tuple[int, int], np.ndarray | None]) -> tuple[int, ...]:
        (chart, pair), _ = item
        own: Any = self.tables.features[chart]
        other = self.tables.others[pair]
        cuts = () if pair < 0 or own.kind != "face" else cuts_of(self.tables, self.side, pair)
        mine = (1, min(cuts)) if cuts else (KINDS.index(own.kind), own.index)
        ranks = mine, (RANKS[type(other)], other.index)
        first, second = ranks if self.side == 0 else ranks[::-1]
        return *first, *second

    def _is_spread(self, boxes: np.ndarray) -> bool:
        """Whether the boxes are more than the surroundings of one point of the surface."""
        places = []
        for box in boxes:
            feature: Any = self.tables.features[int(box[CHART])]
            u, hu, v, hv, *times = box[2:8].tolist()
            sheet = feature.sheet.at(exact_value(0.5 * sum(times)))
            for p, q in product((u - hu, u + hu), (v - hv, v + hv)):
                places.append(_in_doubles(sheet, *feature.place(p, q)))
        size = float(self.tables.units[self.side, 3])
        return float(np.ptp(places, axis=0).max()) > SPREAD * size


def cuts_of(tables: Tables, side: int, pair: int) -> tuple[int, ...]:
    """Numbers of the inequalities at whose borders a pair of features is."""
    own, other = int(tables.pairs[pair, OWN_FORM]), int(tables.pairs[pair, OTHER_FORM])
    first = (own,) if 0 <= own < tables.layout[side, COUNT] else ()
    return (*first, other - SECOND_CUT) if other >= SECOND_CUT else first


class RuledSolidEvent:
    """A feature of the ruled surface that begins to touch one of the model, at a rational place and time.

    Call within `precision(BITS)`.
    """

    def __init__(
        self, bodies: tuple[Body, Body], side: int, tables: Tables, chart: int, pair: int, box: np.ndarray
    ) -> None:
        self.bodies, self.side = bodies, side
        self.own: RuledFeature = tables.features[chart]  # type: ignore[assignment]
        self.numbers = cuts_of(tables, side, pair)
        self.cuts = [self.own.sheet.cuts[k] for k in self.numbers]
        self.other: Any = tables.others[pair]
        shape = bodies[1 - side]
        self.model: CompositeQuadric = shape_of(shape)
        x, s = tables.features[int(box[CHART])].place(float(box[2]), float(box[4]))  # type: ignore[union-attr]
        x, s = (x if self.own.x is None else self.own.x), (s if self.own.s is None else self.own.s)
        place = min(max(x, -1.0), 1.0), min(max(s, 0.0), 1.0)
        self.sizes = float(tables.units[side, 3]), float(tables.units[1 - side, 3])
        """Of the ruled surface and of the model."""
        self.free = [k for k, fixed in enumerate((self.own.x, self.own.s)) if fixed is None]
        self.place = [exact_value(c) for c in place]
        self.moment = exact_value(float(0.5 * (box[6] + box[7])))
        self.regular = False
        self.surfaces = self._surfaces()

    @property
    def time(self) -> float:
        return to_double(self.moment)

    def _surfaces(self) -> list[list[list[arb]]]:
        """The forms of the model's feature as balls."""
        if isinstance(self.other, Face):
            numbers: Sequence[int] = self.other.surfaces[:1]
        elif isinstance(self.other, Edge):
            numbers = crossing_surfaces(self.model, self.other)
        else:
            crossing = crossing_at(self.model, self.other)
            if crossing is None:
                planes = [_plane(k, c) for k, c in enumerate(enclosure(self.other.carrier))]
                return planes[: len(self.free) + 1 - len(self.cuts)]
            numbers = crossing
        return [_scaled(self.model.surfaces[k].matrix()) for k in numbers]

    def relative(self, t: fmpq) -> Matrix:
        """From the ruled surface's frame to the model's."""
        return compose(inverse_map(ball_pose(self.bodies[1 - self.side], t)), ball_pose(self.bodies[self.side], t))

    # -- where and when -------------------------------------------------------------------------------------

    def _values(self, place: Sequence[fmpq], t: fmpq) -> tuple[list[arb], list[list[arb]], list[list[arb]]]:
        """Of all surfaces: values, derivatives by the free parameters, gradients in the model's frame."""
        m = self.relative(t)
        x, s = (arb(c) for c in place)
        sheet = self.own.sheet.at(t)
        point = sheet.point(x, s)
        w = point[3]
        here = [c / w for c in point[:3]]
        ways = []
        for k in self.free:
            d = sheet.by_x(x, s) if k == 0 else sheet.by_s(x)
            ways.append([(c - p * d[3]) / w for c, p in zip(d[:3], here, strict=True)])
        there = [*mapped(m, here), arb(1)]
        turned = [[row[0] * d[0] + row[1] * d[1] + row[2] * d[2] for row in m] for d in ways]
        values, slopes, gradients = [], [], []
        for form in self.surfaces:
            image = [sum((c * p for c, p in zip(row, there, strict=True)), arb(0)) for row in form]
            values.append(sum((c * p for c, p in zip(image, there, strict=True)), arb(0)))
            gradients.append([2 * c for c in image[:3]])
            slopes.append([2 * (image[0] * d[0] + image[1] * d[1] + image[2] * d[2]) for d in turned])
        return values, slopes, gradients

    def _held(self, place: Sequence[fmpq]) -> tuple[list[arb], list[list[arb]]]:
        """Of its inequalities: values, derivatives by the free parameters."""
        x, s = (arb(c) for c in place)
        slopes = [cut.slopes(x, s) for cut in self.cuts]
        return [cut.value(x, s) for cut in self.cuts], [[both[k] for k in self.free] for both in slopes]

    def _equations(self, z: Sequence[fmpq]) -> list[arb]:
        place = list(self.place)
        for k, x in zip(self.free, z, strict=False):
            place[k] = x
        values, slopes, _ = self._values(place, z[-1])
        held, ways = self._held(place)
        if isinstance(self.other, Face):
            if not self.cuts:
                return values + slopes[0]
            if len(self.cuts) < len(self.free):
                (a, b), (c, d) = slopes[0], ways[0]
                return [*values, *held, a * d - b * c]
        if self.cuts:
            return values + held
        if isinstance(self.other, Edge) and len(self.free) == 2:
            (a, b), (c, d) = slopes
            return [*values, a * d - b * c]
        return values

    def refine(self) -> bool:
        """Newton's steps with one Jacobian of differences, residuals in balls; nothing is proved here."""
        z = [*(self.place[k] for k in self.free), self.moment]
        start = list(z)
        columns = []
        for k in range(len(z)):
            ahead, back = list(z), list(z)
            ahead[k], back[k] = z[k] + STEP, z[k] - STEP
            p, q = self._equations(ahead), self._equations(back)
            columns.append([float(((x - y) / (2 * STEP)).mid()) for x, y in zip(p, q, strict=True)])
        jacobian = np.array(columns).T
        scale = np.abs(jacobian).max(axis=1, keepdims=True)
        if jacobian.shape[0] != jacobian.shape[1] or not (np.all(scale > 0) and np.all(np.isfinite(jacobian))):
            return False
        if np.linalg.cond(jacobian / scale) > REGULAR:
            return False
        for _ in range(ROUNDS):
            residual = self._equations(z)
            largest = max(float(abs(r).upper()) for r in residual) or 1.0
            if not math.isfinite(largest):
                return False
            shift = np.linalg.solve(jacobian, [float((r / largest).mid()) for r in residual])
            z = [c - dyadic((arb(exact_value(d)) * arb(largest)).mid()) for c, d in zip(z, shift, strict=True)]
            z = [fmpq((c * 2**200).floor()) / 2**200 for c in z]
            if any(abs(to_double(c - d)) > 1e-5 * (1 + abs(to_double(d))) for c, d in zip(z, start, strict=True)):
                return False
        for k, c in zip(self.free, z, strict=False):
            self.place[k] = c
        self.moment = z[-1]
        x, s = self.place
        _, _, gradients = self._values(self.place, self.moment)
        smooth = all(
            max(abs(float(c.mid())) for c in g) > SMOOTH * self.sizes[1] * max(float(abs(c).mid()) for row in form[:3]
                                                                               for c in row[:3])
            for g, form in zip(gradients, self.surfaces, strict=True)
        )  # fmt: skip
        self.regular = bool(-1 <= x <= 1 and 0 <= s <= 1 and smooth)
        return True

    def placed(self, z: Sequence[fmpq]) -> RuledSolidEvent:
        """The same event at these free parameters and this time, which are its own."""
        event = copy(self)
        event.place = list(self.place)
        for k, c in zip(self.free, z, strict=False):
            event.place[k] = c
        event.moment, event.regular = z[-1], True
        return event

    # -- the proof ------------------------------------------------------------------------------------------

    def leads_inside(self, at: float) -> bool:
        """Whether a point of the surface near the event is proved inside the model at that time."""
        t = exact_value(at)
        m, sheet = self.relative(t), self.own.sheet.at(t)
        return any(
            is_inside(self.model, mapped(m, _exact_point(sheet, place))) is True
            for place in self._steps(t) if self.own.sheet.keeps(*place)
        )  # fmt: skip

    def _steps(self, t: fmpq) -> Iterator[list[fmpq]]:
        """Places near the event: itself, and with all its surfaces equally far away, on any sides, and borders of its
        inequalities, which hold there."""
        place = [min(max(c, fmpq(lo)), fmpq(1)) for c, lo in zip(self.place, (-1, 0), strict=True)]
        yield place
        if not self.free or len(self.surfaces) + len(self.cuts) < 2:
            return
        values, slopes, gradients = self._values(place, t)
        held, ways = self._held(place)
        f = np.array([float(c.mid()) for c in (*values, *(-c for c in held))])
        rows = np.array([[float(c.mid()) for c in row] for row in (*slopes, *([-c for c in row] for row in ways))])
        lengths = np.array([math.sqrt(sum(float(c.mid()) ** 2 for c in g)) for g in (*gradients, *ways)])
        if not (np.all(np.isfinite(rows)) and np.all(lengths > 0)):
            return
        for sides in product(*[(1.0, -1.0)] * len(values), *[(1.0,)] * len(held)):
            system = np.column_stack([rows, lengths * np.array(sides)])
            # surfaces with equations that hold each other: the least step
            step = np.linalg.lstsq(system / lengths[:, None], -f / lengths, rcond=1e-9)[0]
            if step[-1] <= 0.0:
                continue
            moved = list(place)
            for k, d in zip(self.free, step, strict=False):
                moved[k] = min(max(place[k] + exact_value(float(d)), fmpq(-1 if k == 0 else 0)), fmpq(1))
            yield moved

    # -- the answer -----------------------------------------------------------------------------------------

    def is_clear(self) -> bool:
        """Whether the place is well within its features: clear of their borders, so that no lower ones may be there."""
        x, s = self.place
        borders = [1 - abs(x)] if 0 in self.free else []
        borders += [s, 1 - s] if 1 in self.free else []
        if any(to_double(c) < NEAR for c in borders):
            return False
        cuts = self.own.sheet.cuts
        if any(abs(c.value(x, s)) < exact_value(NEAR) * c.size for c in cuts if c not in self.cuts):
            return False
        m = self.relative(self.moment)
        there = np.array([float(c.mid()) for c in mapped(m, _exact_point(self._sheet, self.place))])
        return bool(_surfaces_near(self.model, there, self.sizes[1]).sum() <= len(self.other.surfaces))

    def geometry(self) -> tuple[np.ndarray, np.ndarray | None]:
        """Point, and unit normal from b towards a where there is one; in the world."""
        pose = middles(ball_pose(self.bodies[self.side], self.moment))
        here = np.array([float(c.mid()) for c in _exact_point(self._sheet, self.place)])
        point = pose[:, :3] @ here + pose[:, 3]
        point[np.abs(point) < 2.0**-120 * np.abs(point).max()] = 0.0
        normal = self._normal()
        if normal is None:
            return point, None
        back = middles(ball_pose(self.bodies[1 - self.side], self.moment))[:, :3]
        turned = np.linalg.solve(back.T, normal) * (1.0 if self.side == 0 else -1.0)
        return point, turned / np.linalg.norm(turned)

    def _normal(self) -> np.ndarray | None:
        """Out of the model, in its frame."""
        place = [min(max(c, fmpq(lo)), fmpq(1)) for c, lo in zip(self.place, (-1, 0), strict=True)]
        _, _, gradients = self._values(place, self.moment)
        units = [np.array([float(c.mid()) for c in g]) for g in gradients]
        # of a polyhedron's features the numbers are its own
        faces = [self.other] if isinstance(self.other, Face) else [self.model.faces[k] for k in self._beside()]
        m = self.relative(self.moment)
        there = np.array([float(c.mid()) for c in mapped(m, _exact_point(self._sheet, place))])
        outward = np.zeros(3)
        for face in faces:
            outward += face.orientation * self.model.gradient(face.surfaces[0], there)
        if isinstance(self.other, Face):
            n = outward
        else:
            turn = middles(m)[:, :3]
            ways = self._ways(place)
            if len(ways) == 2:
                n = np.cross(turn @ ways[0], turn @ ways[1])
            elif len(ways) == 1 and len(units) == 2:
                n = np.cross(turn @ ways[0], np.cross(units[0], units[1]))
            else:
                return None
            if not np.any(outward):
                return None
            n = n * np.sign(n @ outward)
        length = float(np.linalg.norm(n))
        return n / length if length > 0.0 and math.isfinite(length) else None

    def _beside(self) -> Sequence[int]:
        """Places of the faces at an edge."""
        return self.other.faces if isinstance(self.other, Edge) else ()

    @property
    def _sheet(self) -> ChartSheet | Mixed:
        return self.own.sheet.at(self.moment)

    def _ways(self, place: Sequence[fmpq]) -> list[np.ndarray]:
        """Unit tangents along the free parameters, in the own frame; none where one vanishes."""
        x, s = (arb(c) for c in place)
        sheet = self._sheet
        point = sheet.point(x, s)
        if len(self.cuts) > 1 or self.cuts and len(self.free) == 1:
            return []
        found = []
        for k in self.free:
            d = sheet.by_x(x, s) if k == 0 else sheet.by_s(x)
            way = np.array([float(((c * point[3] - p * d[3])).mid()) for c, p in zip(d[:3], point[:3], strict=True)])
            found.append(way)
        if self.cuts:
            by_x, by_s = (float(c.mid()) for c in self.cuts[0].slopes(x, s))
            found = [found[0] * by_s - found[1] * by_x]
        lengths = [float(np.linalg.norm(way)) for way in found]
        least = 1e-30 * self.sizes[0] * float(abs(arb(point[3])).mid()) ** 2
        if not all(length > least for length in lengths):
            return []
        return [way / length for way, length in zip(found, lengths, strict=True)]


def _surfaces_near(model: CompositeQuadric, x: np.ndarray, size: float) -> np.ndarray:
    """(n,) bools: the surfaces of a model of this size that pass near a point (3,) of its frame."""
    far, point = np.append(np.full(3, size + np.abs(x).max()), 1.0), np.append(x, 1.0)
    sizes = np.abs(model.forms * far * far[:, None]).max(axis=(1, 2))
    near: np.ndarray = np.abs(point @ model.forms @ point) < NEAR * sizes
    return near


def _sampled(
    bodies: tuple[Body, Body], side: int, sheets: Sequence[ChartSheet], t: fmpq, within: bool
) -> np.ndarray | None:
    shapes: list[Any] = [shape_of(x) for x in bodies]
    model = shapes[1 - side]
    with precision(BITS):
        pose = ball_pose(bodies[side], t)
        m = compose(inverse_map(ball_pose(bodies[1 - side], t)), pose)
        rough = middles(m)
        for whole in sheets:
            sheet = whole.at(t)
            grid = [(fmpq(2 * i - START_GRID, START_GRID), fmpq(j, START_GRID))
                    for i in range(START_GRID + 1) for j in range(START_GRID + 1)]  # fmt: skip
            grid = [place for place in grid if whole.keeps(*place)]
            if not grid:
                continue
            points = np.array([_in_doubles(sheet, float(x), float(s)) for x, s in grid])
            near = model.contains(points @ rough[:, :3].T + rough[:, 3])
            for k in np.flatnonzero(near == within):
                here = _exact_point(sheet, grid[k])
                if is_inside(model, mapped(m, here)) is within:
                    return np.array([float(c.mid()) for c in mapped(pose, here)])
    return None


def is_inside(model: CompositeQuadric, there: list[arb]) -> bool | None:
    """Whether the model holds the point, balls in its frame; None where a sign is not certain."""
    point = [*there, arb(1)]
    negative = []
    for surface in model.surfaces:
        value = surface.value(point)
        if not (value > 0 or value < 0):
            return None
        negative.append(bool(value < 0))
    return bool(inside(model.tree, negative))


def _exact_point(sheet: ChartSheet | Mixed, place: Sequence[fmpq]) -> list[arb]:
    point = sheet.point(*place)
    return [arb(c / point[3]) for c in point[:3]]


def _in_doubles(sheet: ChartSheet | Mixed, x: float, s: float) -> np.ndarray:
    point = sheet.point(exact_value(x), exact_value(s))
    return np.array([to_double(c / point[3]) for c in point[:3]])


def _scaled(rows: Sequence[Sequence[fmpq]]) -> list[list[arb]]:
    """The form as balls, its largest entry 1."""
    largest = max(abs(c) for row in rows for c in row)
    return [[arb(c / largest) for c in row] for row in rows]


def _plane(k: int, c: arb) -> list[list[arb]]:
    """The form of the plane x_k = c."""
    rows = [[arb(0)] * 4 for _ in range(4)]
    rows[k][3] = rows[3][k] = arb(1) / 2
    rows[3][3] = -c
    return rows
