"""Faces on tori: sectors of tori are cut off a solid, so that quadrics bound the rest of it.

In a half-plane through its axis a face is an arc.  A round is cut off along chords, within what its tube holds.  A
fillet is cut off along tangents: where it ends smoothly, these are on the faces next to it; where one of those is not
straight there, it is cut off between walls across its ends and chords behind it.  The sector is thicker than what is
cut off: it reaches into the rest, so that nothing lies between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.body.solid.carriers import Surface, doubles
from firstcontact.body.torus.sector import AngleRange, TorusSector
from firstcontact.body.torus.torus import Torus
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix
from firstcontact.step.carriers import Carrier, NotExact, plane, revolved
from firstcontact.step.charts import Elementary
from firstcontact.step.solids import StepSolid, forward

if TYPE_CHECKING:
    from firstcontact.step.asking import Asking

TURN = 2.0 * math.pi
CLOSE = 1e-7
"""In radians: how near to its end an angle is one; also a whole turn."""
EVEN = 1e-9
"""In radians: angles that near to quarter turns are such."""
WIDEST, SHARPEST = 0.5 * math.pi + CLOSE, 0.6 * math.pi
"""Arcs that one chord cuts off; and what is a corner of two faces yet."""
DEEPER = 15.0 / 16.0
"""How far sectors reach into the rest, as a part of the way to the circle, or the other way."""
BEHIND = 1.1
"""Of the tube's radius: how far behind a fillet chords are."""
THINNER = 4
"""How often chords are halved where a sector is not in the part."""
ALONG, ACROSS, PROBES = 0.04, 6, 600
"""Of the solid's size: between samples along; how many there are across; points of a sector that are asked about."""
STRAIGHT = 1e-7
"""Of the solid's size: how far from tangents of an arc straight faces are."""
INSET = 5e-6
"""In radians, of the ends of sectors at edges."""
TANGENT = 1e-3
"""Sine of the angle below which two surfaces count as tangent."""
SHALLOW = 0.03
"""Of the tube's radius: up to there both sides of a sheet are as they are next to it."""


@dataclass(frozen=True)
class RoundSheet:
    """What bounds the rest instead of the face, in a half-plane: from `first` to `last`, (rho, z); out: unit, away
    from the rest; beside: a face of the file whose carrier it is on, or None."""

    first: np.ndarray
    last: np.ndarray
    out: np.ndarray
    beside: int | None = None


class TorusRound:
    """A face of a solid, on a torus, with what is cut off along it; numbers: of all faces that it is made of.

    bore: of a tube all around, the one within it about the same circle.
    """

    bore: TorusRound | None

    def __init__(self, solid: StepSolid, number: int) -> None:
        from OCP.BRep import BRep_Tool
        from OCP.BRepTools import BRepTools

        self.solid, self.bore = solid, None
        self.numbers: tuple[int, ...] = (number,)
        self.chart = Elementary(BRep_Tool.Surface_s(solid.faces[number]))
        self.radii: tuple[float, float] = self.chart.surface.MajorRadius(), self.chart.surface.MinorRadius()
        told = BRepTools.UVBounds_s(solid.faces[number])
        u0, u1, v0, v1 = map(_even, told)
        self.moved: float = max(abs(x - y) for x, y in zip(told, (u0, u1, v0, v1), strict=True))
        """Angles as the file's numbers round them are quarter turns."""
        self._reach((u0, u1), (v0, v1))
        self.beside: tuple[int | None, int | None] = (None, None)
        """Of a fillet, at either end: the face that goes on straight along the tangent there."""
        self.has_walls = False
        """Whether a fillet is cut off between walls, as a face goes on along a tangent, but not straight."""

    def _reach(self, *ends: tuple[float, float]) -> None:
        """From where to where, along and around."""
        self.ends = ends
        self.along, self.around = (None if last - first > TURN - CLOSE else (first, last) for first, last in ends)
        self.parts = 1 if self.around is None else math.ceil((ends[1][1] - ends[1][0]) / WIDEST)

    @property
    def who(self) -> str:
        return self.solid.named("face", self.numbers[0])

    def joins(self, other: TorusRound) -> bool:
        """Whether another face goes on where this one ends, on the same torus; then this one is both."""
        if not (self._is_about(other) and self.radii == other.radii and self.is_hollow == other.is_hollow):
            return False
        for k in (0, 1):
            (first, last), (start, end) = self.ends[k], other.ends[k]
            alike = max(abs(_off(x, y)) for x, y in zip(self.ends[1 - k], other.ends[1 - k], strict=True)) < CLOSE
            if alike and abs(_off(start, last)) < CLOSE and self.is_rectangle and other.is_rectangle:
                joined, rest = (first, last + end - start), self.ends[1 - k]
                self._reach(*((joined, rest) if k == 0 else (rest, joined)))
                self.numbers, self.moved = self.numbers + other.numbers, max(self.moved, other.moved)
                return True
        return False

    def is_bore_of(self, other: TorusRound) -> bool:
        same = self._is_about(other) and self.radii[0] == other.radii[0] and self.is_hollow and not other.is_hollow
        ends = zip(self.ends[0], other.ends[0], strict=True)
        all_around = self.around is None and other.around is None and self.is_rectangle
        return same and all_around and max(abs(_off(x, y)) for x, y in ends) < CLOSE

    def _is_about(self, other: TorusRound) -> bool:
        own, others = ([*x.chart.axes.tolist(), x.chart.origin.tolist()] for x in (self, other))
        return own == others

    @cached_property
    def is_rectangle(self) -> bool:
        """Whether its edges run along and across it, from end to end."""
        from OCP.BRep import BRep_Tool
        from OCP.BRepAdaptor import BRepAdaptor_Curve2d

        (number,) = self.numbers
        face = forward(self.solid.faces[number])
        for use in self.solid.uses[number]:
            if BRep_Tool.Degenerated_s(use.edge):
                continue
            curve = BRepAdaptor_Curve2d(use.edge, face)
            times = np.linspace(curve.FirstParameter(), curve.LastParameter(), 5).tolist()
            points = np.array([(p.X(), p.Y()) for p in map(curve.Value, times)])
            off = min(float(np.abs(points[:, k] - end).max()) for k in (0, 1) for end in self.ends[k])
            if off > CLOSE:
                return False
            self.moved = max(self.moved, off)
        return True

    @cached_property
    def is_hollow(self) -> bool:
        """Whether the solid is outside of the tube."""
        from OCP.GeomLProp import GeomLProp_SLProps
        from OCP.TopAbs import TopAbs_Orientation

        u, v = (0.5 * (first + last) for first, last in self.ends)
        at = GeomLProp_SLProps(self.chart.surface, u, v, 1, 1e-9)
        normal, place = at.Normal(), at.Value()
        point = np.array([[place.X(), place.Y(), place.Z()]])
        out = self.directions(point)[0] @ [normal.X(), normal.Y(), normal.Z()]
        is_turned = self.solid.faces[self.numbers[0]].Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        return bool((out > 0) == is_turned)

    # -- places -------------------------------------------------------------------------------------------------

    def polar(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angles along and around, each within half a turn of the middle, and s in units of the tube's radius."""
        x, y, z = self.chart.axes @ (points - self.chart.origin).T
        across = np.hypot(x, y) - self.radii[0]
        s = np.hypot(across, z) / self.radii[1]
        u, v = (
            0.5 * sum(ends) + (angle - 0.5 * sum(ends) + math.pi) % TURN - math.pi
            for ends, angle in zip(self.ends, (np.arctan2(y, x), np.arctan2(z, across)), strict=True)
        )
        return u, v, s

    def directions(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) away from the circle."""
        x, y, z = self.chart.axes @ (points - self.chart.origin).T
        rho = np.hypot(x, y)
        away = np.stack([x * (1.0 - self.radii[0] / rho), y * (1.0 - self.radii[0] / rho), z])
        found: np.ndarray = (away / np.linalg.norm(away, axis=0)).T @ self.chart.axes
        return found

    def distances(self, points: np.ndarray) -> np.ndarray:
        """(n,) from the torus."""
        found: np.ndarray = np.abs(self.polar(points)[2] - 1.0) * self.radii[1]
        return found

    def holds(self, points: np.ndarray) -> np.ndarray:
        """(n,) whether points are in the sector, but for rounding."""
        near, far = self.shares
        return self._between(points, to_double(near), to_double(far), 1e-6)

    def removed(self, points: np.ndarray) -> np.ndarray:
        """(n,) whether points of the solid are cut off."""
        _, v, s = self.polar(points)
        cut = np.zeros(len(points), bool)
        for first, last in self.arcs:
            here, middle, half = (first <= v) & (v <= last), 0.5 * (first + last), 0.5 * (last - first)
            if not self.is_hollow:
                cut |= here & (s * np.cos(v - middle) > math.cos(half))
            elif self.has_walls:
                cut |= here & (s * np.cos(v - middle) < BEHIND)
            else:
                cut |= here & (s * np.cos(v - first) < 1.0) & (s * np.cos(v - last) < 1.0)
        near, far = (1.0, math.inf) if self.is_hollow else (0.0, 1.0)  # a bore is not of the solid
        return self._between(points, near, far, 0.0) & (cut | (self.around is None))

    def _between(self, points: np.ndarray, near: float, far: float, room: float) -> np.ndarray:
        u, v, s = self.polar(points)
        found: np.ndarray = (s >= near - room) & (s <= far + room)
        for x, ends in ((u, self.along), (v, self.around)):
            if ends is not None:
                found &= (x >= ends[0] - room) & (x <= ends[1] + room)
        return found

    # -- what is cut off ----------------------------------------------------------------------------------------

    @property
    def arcs(self) -> list[tuple[float, float]]:
        """Those that chords cut off."""
        if self.around is None:
            return []
        ends = np.linspace(*self.around, self.parts + 1).tolist()
        return list(zip(ends, ends[1:], strict=False))

    @property
    def shares(self) -> tuple[fmpq, fmpq]:
        """Of the sector, as parts of the tube's radius."""
        if self.around is None:
            return (exact_value(self.bore.radii[1] / self.radii[1]) if self.bore else fmpq(0)), fmpq(1)
        half = 0.5 * (self.around[1] - self.around[0]) / self.parts
        if not self.is_hollow:
            return exact_value(DEEPER * math.cos(half)), fmpq(1)
        return fmpq(1), exact_value((BEHIND if self.has_walls else 1.0) / math.cos(half) / DEEPER)

    @property
    def sector(self) -> Torus:
        """In the part's frame."""
        major, minor = (exact_value(x) for x in self.radii)
        if self.along is None and self.around is None and self.bore is None:
            return Torus(major, minor, self.matrix)
        first, last = self.insets
        arc = None if self.around is None else (self.around[0] + first, self.around[1] - last)
        around, along = (None if ends is None else AngleRange.between(*ends) for ends in (arc, self.along))
        return TorusSector(major, minor, self.shares, around, along, self.matrix)

    @property
    def insets(self) -> tuple[float, float]:
        """How much sooner the sector ends, where a fillet ends at an edge: its wall would be along a face of the file,
        and what touches that face along a line would touch the wall as well.  The rest is all but as far there."""
        if not self.is_hollow or self.has_walls or self.around is None:
            return 0.0, 0.0
        first, last = (INSET if face is None else 0.0 for face in self.beside)
        return first, last

    @cached_property
    def matrix(self) -> Matrix:
        """From the torus's frame; of what the file has, rounded as OpenCASCADE does."""
        columns = [*self.chart.axes.tolist(), self.chart.origin.tolist()]
        rows = tuple(tuple(exact_value(column[k]) for column in columns) for k in range(3))
        return IDENTITY if rows == IDENTITY else rows  # type: ignore[return-value]

    @property
    def askew(self) -> float:
        """How far the sector may be from the file's torus, as its axes are not quite of length 1, and at right angles;
        and from what is cut off, by rounding."""
        columns = list(zip(*(row[:3] for row in self.matrix), strict=True))
        off = sum(
            abs(sum((x * y for x, y in zip(p, q, strict=True)), fmpq(0)) - int(i == j))
            for i, p in enumerate(columns) for j, q in enumerate(columns)
        )  # fmt: skip
        if self.around is None and self.along is None and self.bore is None:
            return to_double(off) * sum(self.radii)
        reach = sum(self.radii) + float(np.abs(self.chart.origin).max())
        return (to_double(off) + float(self.moved) + 1e-15) * reach + max(self.insets) ** 2 * self.radii[1]

    def sheets(self) -> Iterator[RoundSheet]:
        major, minor = self.radii

        def at(s: float, v: float) -> np.ndarray:
            return np.array([major + s * minor * math.cos(v), s * minor * math.sin(v)])

        def unit(v: float) -> np.ndarray:
            return np.array([math.cos(v), math.sin(v)])

        half = 0.5 * (self.arcs[0][1] - self.arcs[0][0]) if self.arcs else 0.0
        behind, (v0, v1) = BEHIND / math.cos(half), self.ends[1]
        if not self.is_hollow:
            yield from (RoundSheet(at(1.0, v), at(1.0, w), unit(0.5 * (v + w))) for v, w in self.arcs)
        elif self.has_walls:
            yield from (RoundSheet(at(behind, v), at(behind, w), -unit(0.5 * (v + w))) for v, w in self.arcs)
            yield RoundSheet(at(1.0, v0), at(behind, v0), unit(v0 + 0.25 * TURN))
            yield RoundSheet(at(1.0, v1), at(behind, v1), unit(v1 - 0.25 * TURN))
        else:
            tops = [at(1.0 / math.cos(half), 0.5 * (v + w)) for v, w in self.arcs]
            corners = [at(1.0, v0), *tops, at(1.0, v1)]
            faces = [self.beside[0], *[None] * (self.parts - 1), self.beside[1]]
            ways = [*(v for v, _ in self.arcs), v1]
            for first, last, v, face in zip(corners, corners[1:], ways, faces, strict=False):
                yield RoundSheet(first, last, -unit(v), face)

    def carrier(self, sheet: RoundSheet) -> Carrier:
        """Of all points, turned about the axis, on a line in the half-plane."""
        place, axis = ([exact_value(x) for x in row.tolist()] for row in (self.chart.origin, self.chart.axes[2]))
        (a, b), c = sheet.out.tolist(), float(sheet.out @ sheet.first)
        return revolved((place[0], place[1], place[2]), (axis[0], axis[1], axis[2]), a, b, c)

    def samples(self, sheet: RoundSheet) -> tuple[np.ndarray, np.ndarray]:
        """Points of a sheet, and unit normals away from the rest."""
        (u0, u1), size = self.ends[0], max(sheet.first[0], sheet.last[0])
        count = max(ACROSS, math.ceil((u1 - u0) * size / (ALONG * self.solid.size)))
        u, t = (
            x.ravel() for x in np.meshgrid(
                u0 + (u1 - u0) * (np.arange(count) + 0.5) / count, (np.arange(ACROSS) + 0.5) / ACROSS
            )
        )  # fmt: skip
        rho, z = sheet.first[:, None] + (sheet.last - sheet.first)[:, None] * t
        x, n = (
            np.stack([r * np.cos(u), r * np.sin(u), h + 0.0 * u], axis=1) @ self.chart.axes
            for r, h in ((rho, z), sheet.out)
        )
        return self.chart.origin + x, n

    def caps(self, asking: AskingRest) -> Iterator[tuple[Carrier, np.ndarray, np.ndarray]]:
        """Of a tube all around, where the rest begins at its ends: the plane, points, and normals as in `samples`."""
        near, _ = self.shares
        v, s = (x.ravel() for x in np.meshgrid(
            np.arange(4 * ACROSS) * TURN / (4 * ACROSS),
            to_double(near) + (1.0 - to_double(near)) * (np.arange(ACROSS) + 0.5) / ACROSS,
        ))  # fmt: skip
        rho, z = self.radii[0] + s * self.radii[1] * np.cos(v), s * self.radii[1] * np.sin(v)
        for u, out in self.ways_out():
            points = self.chart.origin + np.stack([rho * math.cos(u), rho * math.sin(u), z], 1) @ self.chart.axes
            goes_on = asking.inside(points + self.depth * out)
            if goes_on.any():
                yield plane(out, self.chart.origin), points[goes_on], np.tile(-out, (int(goes_on.sum()), 1))

    def ways_out(self) -> Iterator[tuple[float, np.ndarray]]:
        """Where it ends along its way: the angle, and the unit normal of the plane there, away from it."""
        for sign, u in zip((-1.0, 1.0), self.along or (), strict=self.along is not None):
            yield u, sign * np.array([-math.sin(u), math.cos(u), 0.0]) @ self.chart.axes

    @property
    def walls(self) -> dict[int, tuple[int, ...]]:
        """Of the sector's faces those that are some of the file's."""
        found: dict[int, tuple[int, ...]] = {0: self.numbers}
        if self.around is None and self.along is not None:
            found |= {k: tuple(self._beside(end, 0)) for k, end in enumerate(self.along, 1 + (self.bore is not None))}
        if self.bore is not None:
            found[1] = self.bore.numbers
        return found

    # -- checking -----------------------------------------------------------------------------------------------

    def fit(self, asking: Asking, rng: np.random.Generator, surfaces: Mapping[int, Surface]) -> None:
        """Finds how to cut it off, so that its sector is in the part; surfaces: of faces.  Raises NotExact."""
        if not self.is_rectangle:
            raise NotExact(f"{self.who}, on a torus, does not go from one angle to another one: other faces cut it")
        if self.around is None and self.is_hollow:
            raise NotExact(f"{self.who}, on a torus, is a bent bore in what is no bent tube")
        if self.is_hollow:
            self.parts = math.ceil((self.ends[1][1] - self.ends[1][0]) / SHARPEST)
            self._look_beside(surfaces)
        for _ in range(THINNER):
            if not self.crosses_axis and asking.inside(self.probes(rng)).all():
                return
            self.parts *= 2
        raise NotExact(f"next to {self.who}, on a torus, the part is too thin")

    def _look_beside(self, surfaces: Mapping[int, Surface]) -> None:
        """How the faces at both ends go on."""
        sheets = list(self.sheets())
        found: list[int | None] = [None, None]
        for k, (end, sheet) in enumerate(zip(self.ends[1], (sheets[0], sheets[-1]), strict=True)):
            faces = self._beside(end)
            if not self._is_tangent(end, faces):
                continue
            on = {surfaces.get(face) for face in faces}
            surface = on.pop()
            if on or surface is None or not self._is_on(self.samples(sheet)[0], surface):
                self.has_walls = True
                return
            found[k] = faces[0]
        self.beside = found[0], found[1]

    def _is_tangent(self, end: float, faces: Sequence[int]) -> bool:
        """Whether one of the faces has the same normal somewhere along the edge."""
        from OCP.BRep import BRep_Tool
        from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
        from OCP.GeomLProp import GeomLProp_SLProps
        from OCP.gp import gp_Pnt

        u = np.linspace(*self.ends[0], ACROSS)
        rho, z = (self.radii[1] * x for x in (math.cos(end), math.sin(end)))
        rho += self.radii[0]
        points = self.chart.origin + np.stack([rho * np.cos(u), rho * np.sin(u), z + 0 * u], 1) @ self.chart.axes
        for face in faces:
            surface = BRep_Tool.Surface_s(self.solid.faces[face])
            for point, out in zip(points.tolist(), self.directions(points), strict=True):
                near = GeomAPI_ProjectPointOnSurf(gp_Pnt(*point), surface)
                if near.NbPoints() == 0 or near.LowerDistance() > STRAIGHT * self.solid.size:
                    continue
                n = GeomLProp_SLProps(surface, *near.LowerDistanceParameters(), 1, 1e-9).Normal()
                if np.linalg.norm(np.cross(out, [n.X(), n.Y(), n.Z()])) < TANGENT:
                    return True
        return False

    def _beside(self, end: float, which: int = 1) -> list[int]:
        """The faces across the edges at one end of the arc, or of the way along it (0)."""
        from OCP.BRepAdaptor import BRepAdaptor_Curve

        found: list[int] = []
        for number in {use.number for face in self.numbers for use in self.solid.uses[face]}:
            curve = BRepAdaptor_Curve(self.solid.edges[number])
            p = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
            if abs(_off(self.polar(np.array([[p.X(), p.Y(), p.Z()]]))[which][0], end)) < CLOSE:
                found += self.solid.incidence[0][number] - set(self.numbers)
        return found

    def _is_on(self, points: np.ndarray, surface: Surface) -> bool:
        form, x = np.array(doubles(surface.matrix())), np.column_stack([points, np.ones(len(points))])
        image = x @ form
        off = np.abs((image * x).sum(axis=1)) / np.maximum(2.0 * np.linalg.norm(image[:, :3], axis=1), 1e-300)
        return bool(off.max() < STRAIGHT * self.solid.size)

    def probes(self, rng: np.random.Generator) -> np.ndarray:
        """(n, 3) points of the sector, not too near to the face."""
        near, far = (to_double(x) for x in self.shares)
        low, high = (near, 1.0 - 1e-5) if far == 1.0 else (1.0 + 1e-5, far)
        u, v, s = (
            first + (last - first) * rng.beta(0.5, 0.5, PROBES) for first, last in (*self.ends, (low, high))
        )
        rho, z = self.radii[0] + s * self.radii[1] * np.cos(v), s * self.radii[1] * np.sin(v)
        found: np.ndarray = self.chart.origin + np.stack([rho * np.cos(u), rho * np.sin(u), z], 1) @ self.chart.axes
        return found

    @property
    def crosses_axis(self) -> bool:
        v = np.linspace(*self.ends[1], 65)
        rho = self.radii[0] + to_double(self.shares[1]) * self.radii[1] * np.cos(v)
        return bool(rho.min() < -1e-9 * sum(self.radii))

    @property
    def depth(self) -> float:
        """How far from a sheet its sides are as they are next to it, in lengths."""
        return SHALLOW * self.radii[1]


def joined(rounds: Iterable[TorusRound]) -> list[TorusRound]:
    """Those that are parts of one torus as one, and bores within their tubes."""
    found: list[TorusRound] = []
    for each in rounds:
        while (other := next((x for x in found if x.joins(each) or each.joins(x)), None)) is not None:
            found.remove(other)
            each = max(other, each, key=lambda x: len(x.numbers))
        found.append(each)
    for each in [x for x in found if x.is_hollow]:
        tube = next((x for x in found if each.is_bore_of(x)), None)
        if tube is not None:
            tube.bore = each
            found.remove(each)
    return found


def _off(x: float, y: float) -> float:
    """From one angle to another one, the shorter way."""
    return (x - y + math.pi) % TURN - math.pi


def _even(angle: float) -> float:
    quarters = round(angle / (0.25 * TURN))
    return quarters * 0.25 * TURN if abs(angle - quarters * 0.25 * TURN) < EVEN else angle


class AskingRest:
    """As `Asking`, of what is left when sectors are cut off."""

    def __init__(self, asking: Asking, rounds: Sequence[TorusRound]) -> None:
        self.asking, self.rounds = asking, rounds

    def inside(self, points: np.ndarray) -> np.ndarray:
        found = self.asking.inside(points)
        for each in self.rounds:
            found &= ~each.removed(points)
        return found

    def off_faces(self, point: Sequence[float], surely: float) -> float:
        """Within sectors edges of the rest are no matter."""
        if any(each.holds(np.array([point]))[0] for each in self.rounds):
            return 0.0
        return self.asking.off_faces(point, surely)
