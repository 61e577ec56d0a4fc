"""Free time of a torus and another body, as `timeline.sweep` asks for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.torus.torus import Torus
from firstcontact.contact.models.idle_turns import keeps_along
from firstcontact.contact.torus.apart import MOST_CELLS, kept, lower
from firstcontact.contact.torus.between import Between, PosedBody, pose_of
from firstcontact.contact.torus.cells import Cells, Triangles, Wedges
from firstcontact.contact.torus.heights import FormHeights, Heights, Outside, Ring
from firstcontact.contact.torus.nets import Nets
from firstcontact.contact.torus.passages import Passages
from firstcontact.contact.torus.touching import contact_near
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import Window
from firstcontact.motion.rotation import Rotation
from firstcontact.search.trees.containment import contains
from firstcontact.search.trees.frame import tree_of
from firstcontact.timeline.sweep import Pass
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body import kinds

FINE = 0.1
"""Of the width of enclosures: stretches of time that are not halved."""
MOST_LOOKS = 1500
"""Stretches of time looked at one by one, far more than questions that end need, before they are not cut further:
bodies that stay so close would be followed in steps too small for minutes."""
ROUNDS, MOST_ROUNDS = 4, 120
"""How often cells are halved in a stretch of time that is halved then, and in one that is not."""
SEEDS = 4
MESH, MODEL, RULED = "Polyhedron", "CompositeQuadric", "RuledSurface"


@dataclass(frozen=True)
class Roles:
    """Of two bodies, one of which is a torus, `side` (0 or 1) goes by cells, which stay out of the other one.

    surface: its cells; all: those of all that it owns, where the other one may lie within it.
    """

    side: int
    surface: Cells
    all: Cells
    heights: Heights
    mesh: Any = None
    """The solid polyhedron that may hold the torus."""


def roles_of(bodies: tuple[kinds.Body, kinds.Body]) -> Roles:
    shapes = [shape_of(x) for x in bodies]
    mesh = next((k for k, shape in enumerate(shapes) if shape.kind == MESH), None)
    if mesh is not None:
        triangles = Triangles(shapes[mesh])
        return Roles(mesh, triangles, triangles, Ring(shapes[1 - mesh]), shapes[mesh] if shapes[mesh].solid else None)
    ruled = next((k for k, shape in enumerate(shapes) if shape.kind == RULED), None)
    if ruled is not None:
        nets = Nets(shapes[ruled])
        return Roles(ruled, nets, nets, Ring(shapes[1 - ruled]))
    side = next(k for k, shape in enumerate(shapes) if shape.kind == "Torus")
    torus, other = shapes[side], shapes[1 - side]
    half = is_round_pair(bodies, torus)
    heights = FormHeights(other) if other.kind == MODEL else Ring(other)
    return Roles(side, Wedges(torus, True, half), Wedges(torus, False, half), heights)


def is_round_pair(bodies: tuple[kinds.Body, kinds.Body], torus: Torus) -> bool:
    """Whether both are round about the torus's axis at all times, so that one half-plane about it tells of all."""
    _, _, axis, centre = zip(*torus.matrix, strict=True)
    turn = Rotation(axis, centre, turns=1)
    return all(keeps_along(body, turn) for body in bodies)


class TorusFree:
    """Time in which the surfaces are apart.  Raises Spent."""

    def __init__(
        self, bodies: tuple[kinds.Body, kinds.Body], width: float, work: Work, span: tuple[fmpq, fmpq]
    ) -> None:
        self.roles, self.width, self.work = roles_of(bodies), width, work
        self.shapes = [shape_of(x) for x in bodies]
        self.most = max(MOST_CELLS, len(self.roles.surface.all()))
        side = next((k for k, shape in enumerate(self.shapes) if shape.kind in (MESH, MODEL)), None)
        whole = side is not None and self.shapes[1 - side].is_whole
        self.passages = Passages(self, bodies, side, span) if side is not None and whole else None

    def at(self, window: Window, t: float) -> bool:
        every = self.roles.all
        if len(self._left(window, every, (t, t), every.all(), MOST_ROUNDS)):
            return False
        return not self.holds_torus(window, t)

    def lies(self, window: Window, t: float) -> str | None:
        """How bodies lie that share inner points; None where that is not proved."""
        roles, cells = self.roles, self.roles.surface
        x = cells.samples()[:, None]
        at = roles.heights.around(self._between(window, cells.off).places(t, t, x).points[:, 0], np.zeros(len(x)))
        told = np.stack([at.values, -at.values]) - 1e3 * at.errors
        if all(np.any(lower(roles.heights.tree, told, negated) > 0.0) for negated in (False, True)):
            return "overlapping"  # points of the surface are in the other body and outside of it
        for heights in (roles.heights, Outside(roles.heights)):
            if not len(self._left(window, cells, (t, t), cells.all(), MOST_ROUNDS, heights)):
                return "containment"
        return None

    def until(self, window: Window, t: float, end: float) -> tuple[float, list[np.ndarray]]:
        cells = self.roles.surface
        waiting, looks = [(t, end, cells.all())], 0
        while waiting:
            lo, hi, rows = waiting.pop()
            middle, looks = lo + 0.5 * (hi - lo), looks + 1
            is_last = hi - lo <= FINE * self.width or not lo < middle < hi or looks > MOST_LOOKS
            rows = self._left(window, cells, (lo, hi), rows, MOST_ROUNDS if is_last else ROUNDS)
            if not len(rows):
                continue
            if is_last:
                return lo, self._places(window, lo, rows)
            waiting += [(middle, hi, rows), (lo, middle, rows)]
        return end, []

    def near_start(self, window: Window) -> list[np.ndarray]:
        return []

    def passage(self, window: Window, t: float) -> Pass | None:
        return None if self.passages is None else self.passages.passage(window, t)

    def touching_at(self, window: Window, t: float) -> np.ndarray:
        """The point of a passage, in the world."""
        assert self.passages is not None
        return self.passages.nearest_place(window, t)

    def touched_at_start(self, window: Window) -> tuple[np.ndarray, bool] | None:
        """See `Passages`."""
        return None if self.passages is None else self.passages.touched_at_start(window)

    def meet_over(self, window: Window, stretch: tuple[float, float], heights: Heights) -> bool:
        """Whether the bodies may meet at some time of the stretch where these heights tell of the one."""
        every = self.roles.all
        return len(self._left(window, every, stretch, every.all(), MOST_ROUNDS, heights)) > 0

    def tables(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        """The motion of the body that goes by cells, and of the other one."""
        return (window.a, window.b) if self.roles.side == 0 else (window.b, window.a)

    def _left(
        self, window: Window, cells: Cells, stretch: tuple[float, float], rows: np.ndarray, rounds: int,
        heights: Heights | None = None,
    ) -> np.ndarray:  # fmt: skip
        between = self._between(window, cells.off)
        return kept(cells, between, heights or self.roles.heights, stretch, rows, self.work.step, rounds, self.most)

    def _between(self, window: Window, off: float) -> Between:
        own, other = self.tables(window)
        return Between(PosedBody(own, self.roles.surface.pose, off), PosedBody(other, self.roles.heights.pose, 0.0))

    def _places(self, window: Window, t: float, rows: np.ndarray) -> list[np.ndarray]:
        """Points as contact is followed at them: where some of the cells come nearest, if that is known; in them."""
        some = rows[:: max(1, len(rows) // SEEDS)][:SEEDS]
        poses = [pose_of(table, t) for table in (window.a, window.b)]
        seeds = self.roles.surface.seeds(some, poses[self.roles.side] @ self.roles.surface.pose)
        if isinstance(self.roles.surface, Nets):
            return seeds
        return [*(contact_near(self.shapes, poses, seed).point for seed in seeds), *seeds]

    def holds_torus(self, window: Window, t: float) -> bool:
        """Whether a polyhedron holds a point of the torus, deep inside it."""
        if self.roles.mesh is None:
            return False
        own, other = (pose_of(table, t) for table in self.tables(window))
        place = np.linalg.solve(own, other @ np.append(self.shapes[1 - self.roles.side].middle, 1.0))
        x, y, z = (exact_value(c) for c in place[:3].tolist())
        return bool(contains(self.roles.mesh, tree_of(self.roles.mesh), (x, y, z)))
