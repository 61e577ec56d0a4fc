"""Two charted models at one instant, in doubles with proved errors: events made precise, common points proved.

All surfaces are read from the table that the search for events keeps for a slab of time; here the slab is an instant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from firstcontact.body.solid.csg import Tree, inside
from firstcontact.kernels.events.event_search import (
    AT_U,
    BEGIN,
    CHART,
    COUNT,
    DEEP,
    END,
    EQUATIONS,
    FORM,
    HALF,
    OTHER,
    OTHER_BEGIN,
    OTHER_END,
    OTHER_FORM,
    OWN,
    OWN_BEGIN,
    OWN_END,
    OWN_FORM,
    PAIR,
    place_slab,
)
from firstcontact.kernels.events.feature_boxes import (
    ABOUT,
    CURVED,
    HERE,
    INSIDE,
    PLAIN,
    ROWS,
    SLAB,
    SLOPE_T,
    SLOPE_U,
    STACK,
    VALUE,
    WIDTH,
    ZEROTH,
    membership,
    model,
    place_box,
)
from firstcontact.kernels.events.moving_forms import FIRST, MODELS, SECOND
from firstcontact.kernels.workspace import workspace
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.events.event_tables import Tables

TINY = 2.0**-30
"""Half-width of the boxes whose linear models stand for derivatives: their squares are below rounding errors."""
NEAR = 1e-6
"""Part of the body's size within which surfaces count as passing through the contact."""
MOST_NEAR = 9
"""Surfaces through a contact, all sign patterns of which are looked at."""
RANK = 1e-7
"""Singular values of unit gradients below this are rounding errors."""
WORST = 1e9
"""Entries of an inverse from which on it counts as singular."""
STEPS = 4
"""Newton's steps at most; from a box of the search two suffice."""


class EventScratch(NamedTuple):
    """The arrays that `kernels.events.event_search.search` works in, in its order."""

    workspace: np.ndarray
    models: np.ndarray
    table: np.ndarray
    boxes: np.ndarray
    stack: np.ndarray


def scratch_for(tables: Tables) -> EventScratch:
    boxes, stack = np.zeros((ROWS, WIDTH)), np.zeros(STACK, np.int64)
    return EventScratch(workspace()[0], np.zeros((3, MODELS)), tables.table.copy(), boxes, stack)


class PlacedForms:
    """Reads and fills the table of forms for times that it is placed at."""

    def __init__(self, tables: Tables, window: Window, scratch: EventScratch) -> None:
        self.tables, self.window, self.scratch = tables, window, scratch

    def place(self, first: float, last: float) -> bool:
        """Fill the table for the times between; False where a pose is singular."""
        t, s = self.tables, self.scratch
        return bool(place_slab(
            first, last, self.window.a, self.window.b, t.raw, t.kinds, t.units, t.layout, s.workspace, s.models,
            s.table, s.boxes,
        ))  # fmt: skip

    def poses(self) -> list[np.ndarray]:
        """Both (3, 4) poses at the placed time."""
        rows = (self.scratch.models[0, k : k + 12] for k in (int(FIRST), int(SECOND)))
        return [np.column_stack([row[:9].reshape(3, 3), row[9:]]) for row in rows]

    # -- the event, precise ----------------------------------------------------------------------------------

    def refined(self, box: np.ndarray) -> np.ndarray | None:
        """(3,) u, v and time of the event in the box by Newton's method; None where it does not settle there."""
        t, s = self.tables, self.scratch
        chart = int(box[CHART])
        params, pair = int(t.info[chart, 1]), t.pairs[int(box[PAIR])]
        if pair[OWN_FORM] >= 0 or pair[EQUATIONS] != params + 1:
            return None
        z = np.array([box[AT_U], box[AT_U + 2], 0.5 * (box[BEGIN] + box[END])])
        start, columns = z.copy(), [*range(params), 2]
        half = TINY * max(abs(self.window.first), abs(self.window.last))
        for _ in range(STEPS):
            if not self.place(z[2] - half, z[2] + half):
                return None
            if not place_box(t.charts, chart, z[0], TINY, z[1], TINY, z[2], half, s.boxes):
                return None
            values, slopes = self._equations(t.info[chart, 0], pair)
            slopes = slopes[:, columns] / np.array([TINY, TINY, s.boxes[SLAB, HALF]])[columns]
            back = _inverse(slopes)
            if back is None:
                return None
            step = back @ values
            z[columns] -= step
            if np.abs(z - start).max() > NEAR:
                return None
            if np.abs(step).max() <= 2.0**-50 * np.abs(z).max():
                break
        return z

    def _equations(self, side: int, pair: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        t, s = self.tables, self.scratch
        base, end = t.layout[side, OTHER], ZEROTH + pair[EQUATIONS]
        for form, deep, row in ((pair[FORM], pair[DEEP], ZEROTH), (pair[OTHER_FORM], PLAIN, end - 1)):
            if form >= 0:
                model(s.table, base + form, 0.0, 1.0, s.boxes, deep, row)
        found = s.boxes[ZEROTH:end]
        return found[:, VALUE].copy(), found[:, SLOPE_U : SLOPE_T + 1].copy()

    # -- a common point --------------------------------------------------------------------------------------

    def forms_at(self, side: int, x: np.ndarray) -> Forms:
        """All forms at x, in units of the body of that side, now."""
        t = self.tables
        own, other = (int(t.layout[side, k]) for k in (OWN, OTHER))
        n, m = int(t.layout[side, COUNT]), int(t.layout[1 - side, COUNT])
        table = np.concatenate([self.scratch.table[own : own + n], self.scratch.table[other : other + m]])
        flat, forms = table[:, ABOUT, CURVED] == 0.0, table[:, 0].reshape(-1, 4, 4)
        point = np.append(x, 1.0)
        images = forms @ point
        values, gradients = images @ point, 2.0 * images[:, :3]
        bends = np.abs(forms[:, :3, :3]).max(axis=(1, 2))
        values[flat], gradients[flat], bends[flat] = table[flat, 0, :4] @ point, table[flat, 0, :3], 0.0
        return Forms(side, x, values, gradients, bends, n)

    def shares_point_near(self, forms: Forms, trees: tuple[Tree, Tree]) -> bool:
        """Whether a point nearby is proved inside both models; trees: of the own model and of the other one."""
        step = forms.inward(trees)
        return step is not None and self._is_inside(forms.side, forms.x + step)

    def _is_inside(self, side: int, x: np.ndarray) -> bool:
        t, s = self.tables, self.scratch
        chart = np.zeros((1, 25))
        chart[0, :3], chart[0, 3] = x, 1.0
        if not place_box(chart, PLAIN, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, s.boxes):
            return False
        own, other = (OWN_BEGIN, OWN_END, OWN), (OTHER_BEGIN, OTHER_END, OTHER)
        for begin, end, base in (own, other):
            rows = t.layout[side]
            found = membership(
                t.program, rows[begin], rows[end], PLAIN, PLAIN, PLAIN, rows[base], s.table, 0.0, 1.0, s.boxes, HERE,
                s.stack,
            )  # fmt: skip
            if found != INSIDE:
                return False
        return True


def _inverse(matrix: np.ndarray) -> np.ndarray | None:
    """None where rounding errors may be more than a part of it."""
    sizes = np.abs(matrix).max(axis=1)
    if not sizes.min() > 0.0:
        return None
    try:
        found = np.linalg.inv(matrix / sizes[:, None])
    except np.linalg.LinAlgError:
        return None
    return found / sizes if np.abs(found).max() < WORST else None


@lru_cache(maxsize=MOST_NEAR + 1)
def _patterns(n: int) -> np.ndarray:
    return np.array(list(product((-1.0, 1.0), repeat=n))).reshape(-1, n)


@dataclass(frozen=True)
class Forms:
    """x: a point in units of the body of that side.  values (n,), gradients (n, 3), bends (n,): of all forms there, and
    sizes of their second derivatives; the first `count` are of the own model."""

    side: int
    x: np.ndarray
    values: np.ndarray
    gradients: np.ndarray
    bends: np.ndarray
    count: int

    @cached_property
    def lengths(self) -> np.ndarray:
        return np.sqrt((self.gradients**2).sum(axis=1))

    @cached_property
    def on(self) -> np.ndarray:
        """Those that pass near the point."""
        return np.flatnonzero(np.abs(self.values) < NEAR * (self.lengths + NEAR * self.bends))

    def near(self) -> tuple[set[int], set[int]]:
        """Those of the own model and of the other one, by their numbers."""
        on = self.on.tolist()
        return {k for k in on if k < self.count}, {k - self.count for k in on if k >= self.count}

    def inward(self, trees: tuple[Tree, Tree]) -> np.ndarray | None:
        """The step that leads deepest into both models, to first order; None where none does.

        Surfaces pass through the point in some pattern of sides that lies inside both; a step d behind all of them at
        one depth solves value_k + gradient_k d = side_k depth |gradient_k|.
        """
        on, count = self.on, self.count
        lengths = self.lengths[on]
        if len(on) > MOST_NEAR or np.any(lengths <= NEAR * self.bends[on]):
            return None
        sides = _patterns(len(on))
        negative: list[Any] = list(self.values < 0.0)
        for k, side in zip(on.tolist(), sides.T, strict=True):
            negative[k] = side < 0.0
        held = inside(trees[0], negative[:count]) & inside(trees[1], negative[count:])
        sides = sides[np.broadcast_to(held, len(sides))]
        if not len(sides) or not len(on):
            return np.zeros(3) if len(sides) else None
        normals, distances = self.gradients[on] / lengths[:, None], self.values[on] / lengths
        system = np.concatenate([np.broadcast_to(normals, (len(sides), *normals.shape)), -sides[:, :, None]], axis=2)
        steps = -(np.linalg.pinv(system, rcond=RANK) @ distances)[:, :3]
        depths = (sides * (distances + steps @ normals.T)).min(axis=1)
        best = int(np.argmax(depths))
        return steps[best] if depths[best] > 0.0 else None
