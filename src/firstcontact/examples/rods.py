"""Encounters of n moving and n resting rods in which trees of boxes test all n^2 pairs of edges.

Wire baskets, heat sinks, brushes and lattice infill look like this: long edges whose boxes all overlap, while
few of them, or none, touch.  Every function takes ``closed`` (solid prisms instead of bare edges, which are their
ridges) and ``seed``, those made for a move along +z also ``turning`` (a turn about the z axis instead).  Rods of one
body may cross each other in the woven families.

>>> layered_reguli(100).moving
<Polyhedron 'moving rods': edge set, 200 vertices, 100 edges, 0 faces> moving by Translation((0.0, 0.0, 0.016))
"""

from __future__ import annotations

from math import pi

import numpy as np

from firstcontact.examples.encounter import (
    Encounter,
    FloatArray,
    closed_rods,
    edge_set,
    motion_over,
    placed,
    rounded,
)
from firstcontact.motion.rotation import Rotation

REACH = 1.25
"""Rods over the square |x|, |y| <= 1 end at this coordinate, well past the last crossing."""
DEPTH = 20.0
"""How far a planted rod stands out, in deltas; see `_planted`."""


def layered_reguli(
    n: int,
    *,
    delta: float = 1e-3,
    tilted: bool = False,
    planted: bool = False,
    turning: bool = False,
    closed: bool = False,
    seed: int = 0,
) -> Encounter:
    """Rods along the two families of lines on the saddle z = xy, all n^2 pairs a few ``delta`` apart, none passed.

    tilted: rods turned a little, so that they lie on no common surface.  planted: one rod of each body stands out
    and the two meet first.
    """
    rows = _Rows(n, delta, tilted, np.random.default_rng(seed))
    above, first = (14.5 if tilted else 2.5) * delta, None
    if planted:
        above, first = _planted(rows)
    return rows.encounter(True, above, (64.0 if planted else 32.0 if tilted else 16.0) * delta, turning, closed, first)


def near_miss_combs(
    n: int,
    *,
    delta: float = 1e-3,
    planted: bool = False,
    turning: bool = False,
    closed: bool = False,
    seed: int = 0,
) -> Encounter:
    """Two flat combs with crossed teeth: as `layered_reguli`, on the plane z = (x + y) / 2 instead of the saddle."""
    rows = _Rows(n, delta, False, np.random.default_rng(seed))
    above, first = _planted(rows) if planted else (2.5 * delta, None)
    return rows.encounter(False, above, (64.0 if planted else 16.0) * delta, turning, closed, first)


def woven_reguli(
    n: int, *, delta: float = 1e-3, turning: bool = False, closed: bool = False, seed: int = 0
) -> Encounter:
    """The tilted rods of `layered_reguli` woven: of the n^2 pairs, many have already passed at the start."""
    rows = _Rows(n, delta, True, np.random.default_rng(seed))
    return rows.encounter(True, 2.5 * delta, 32.0 * delta, turning, closed, None, woven=True)


def woven_rods(n: int, *, turning: bool = False, closed: bool = False, seed: int = 0) -> Encounter:
    """Generic long rods, one body roughly along y, the other roughly along x; seen along z all n^2 pairs cross."""
    random = np.random.default_rng(seed)

    def rods(along_y: bool) -> FloatArray:
        place, height, rise = random.uniform(-1.0, 1.0, (3, n, 1))
        lean = random.uniform(-0.3, 0.3, (n, 1))
        way = np.broadcast_to([-2.25, 2.25], (n, 2))
        across, z = place + lean * way, height + rise * way
        return rounded(np.stack([across, way, z] if along_y else [way, across, z], axis=-1))

    moving, resting = rods(True), rods(False)
    return _encounter(moving, resting, 1.0, turning, closed, _woven_width(n), None)


def nested_hyperboloids(
    n: int, *, gap: float = 1e-3, turns: float = 1.0, planted: bool = True, closed: bool = False, seed: int = 0
) -> Encounter:
    """Rods on two hyperboloids of one sheet about the z axis, one turning inside the other at a constant gap.

    x^2 + y^2 = 1 + z^2, |z| <= 1, and the same widened by ``gap``; the rods of the two bodies lean opposite ways.
    All pairs slide past each other and none touches but, planted, two rods: one leans out above, the other in
    below, so that their radii agree somewhere and one turn makes them meet.  Ends are not on a grid.
    """
    random = np.random.default_rng(seed)
    inner = _rulings(n, +1.0, random)
    outer = _rulings(n, -1.0, random)
    scale_a, scale_b = np.ones((n, 2)), np.full((n, 2), 1.0 + gap)
    first = None
    if planted:
        first = int(random.integers(n)), int(random.integers(n))
        scale_a[first[0], 1], scale_b[first[1], 1] = 1.0 + 0.7 * gap, 1.0 + 0.3 * gap
    inner[..., :2] *= scale_a[..., None]
    outer[..., :2] *= scale_b[..., None]
    motion = Rotation((0, 0, 1), turns=float(turns))
    if not closed:
        return Encounter(edge_set(inner, "moving rods"), edge_set(outer, "resting rods"), motion, first)
    width = 0.1 / n
    a = closed_rods(inner, -_outward(inner), width, "moving rods")
    b = closed_rods(outer, _outward(outer), width, "resting rods")
    return Encounter(a, b, motion, first)


class _Rows:
    """What is random about two rows of n rods over the square |x|, |y| <= 1.

    place, slope, height, lean: (2, n), moving then resting.  Rod i of the moving body runs in y at x = place; its
    slope is added to that of the surface, and it hangs ``height`` below it; resting rods run in x and stand above.
    """

    def __init__(self, n: int, delta: float, tilted: bool, random: np.random.Generator) -> None:
        self.delta = delta
        self.place = (2.0 * np.arange(n) + 1.0) / n - 1.0 + random.uniform(-0.2, 0.2, (2, n)) / n
        self.slope = delta * random.uniform(-1.0, 1.0, (2, n))
        self.height = delta * random.uniform(0.0, 1.0, (2, n))
        self.lean = delta * random.uniform(-1.0, 1.0, (2, n)) if tilted else np.zeros((2, n))
        self.random = random

    def segments(self, saddle: bool, above: float) -> list[FloatArray]:
        """Ends (n, 2, 3) of the moving and of the resting rods, the latter ``above`` higher.

        On the saddle z = xy, or on the plane z = (x + y) / 2.
        """
        way = np.broadcast_to([-REACH, REACH], (self.place.shape[1], 2))
        found = []
        for k, up in ((0, -self.height[0]), (1, self.height[1] + above)):
            across = self.place[k][:, None] + self.lean[k][:, None] * way
            surface = self.place[k][:, None] * way if saddle else (across + way) / 2.0
            z = surface + self.slope[k][:, None] * way + up[:, None]
            found.append(rounded(np.stack([across, way, z] if k == 0 else [way, across, z], axis=-1)))
        return found

    def encounter(
        self,
        saddle: bool,
        above: float,
        length: float,
        turning: bool,
        closed: bool,
        first: tuple[int, int] | None,
        woven: bool = False,
    ) -> Encounter:
        n = self.place.shape[1]
        a, b = self.segments(saddle, above)
        width = self.delta * _woven_width(n) if woven else 0.2 / n
        return _encounter(a, b, length, turning, closed, width, first)


def _planted(rows: _Rows) -> tuple[float, tuple[int, int]]:
    """Let one rod of each body stand out by DEPTH deltas; (how far apart the bodies are, the two rods).

    With heights 0 for these two, their gap is 6 delta give or take 4.1 (slopes 2, leaning 2.1), that of any
    other pair at least (DEPTH + 6 - 4.1) delta.  A turn meets a gap g at an angle between g / 4 and g / 2: still
    in this order, since (6 + 4.1) / 2 < (DEPTH + 1.9) / 4.
    """
    n = rows.place.shape[1]
    first = int(rows.random.integers(n)), int(rows.random.integers(n))
    rows.height[0, first[0]] = rows.height[1, first[1]] = -DEPTH * rows.delta
    return (2.0 * DEPTH + 6.0) * rows.delta, first


def _encounter(
    moving: FloatArray,
    resting: FloatArray,
    length: float,
    turning: bool,
    closed: bool,
    width: float,
    first: tuple[int, int] | None,
) -> Encounter:
    """The bodies of rods with these ends, made for a move along +z."""
    motion = motion_over(length, turning)
    moving, resting = placed(moving, turning), placed(resting, turning)
    if not closed:
        return Encounter(edge_set(moving, "moving rods"), edge_set(resting, "resting rods"), motion, first)
    up = np.array([0.0, 1.0, 0.0] if turning else [0.0, 0.0, 1.0])
    a = closed_rods(moving, -up, width, "moving rods")
    b = closed_rods(resting, up, width, "resting rods")
    return Encounter(a, b, motion, first)


def _woven_width(n: int) -> float:
    """Width of closed woven rods: the n^2 gaps of both signs leave no more room than this, mostly."""
    return 2.0**-7 / n**2


def _rulings(n: int, sense: float, random: np.random.Generator) -> FloatArray:
    """n lines (n, 2, 3) on x^2 + y^2 = 1 + z^2, |z| <= 1, evenly about the axis but for a little noise."""
    angle = (np.arange(n) + random.uniform(-0.2, 0.2, n)) * (2.0 * pi / n)
    waist = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=-1)
    along = np.stack([-sense * np.sin(angle), sense * np.cos(angle), np.ones(n)], axis=-1)
    return np.stack([waist - along, waist + along], axis=1)


def _outward(segments: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) from the z axis to the middles of the segments."""
    middle = segments.mean(axis=1) * [1.0, 1.0, 0.0]
    return middle / np.linalg.norm(middle, axis=1, keepdims=True)
