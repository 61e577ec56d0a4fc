"""Polylines along the edges of the topology graph, in doubles; the ends come from exact nodes.

A point is a pair (x, y) in the chart of its edge, moved onto f = 0 by Newton steps along the gradient, so that turning
points need no care.  It is kept where the rounding of f is small against the squared slope over the second derivatives:
by Kantorovich's theorem there is one zero next to it then, far nearer than any other.  On an open edge f_y has one
sign, and neighbouring branches have opposite ones: that is checked at every point.  A point that fails one of both is
taken from the exact root: beside nodes and cusps, in thin necks, on loops that are hardly more than a point.  The
meeting point is projected onto the ruling of P, so rounding leaves it on that ruling, also where the two rulings are
nearly one line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.errors import InputError
from firstcontact.exact.numbers import to_double

if TYPE_CHECKING:
    from firstcontact.curves.exactly.piece_borders import BorderCurve
    from firstcontact.curves.with_solids.solid_curve import _Sheet

# Parts of an edge before any refinement.
FIRST = 8
# A chord is kept where the curve leaves it by at most this part of the tolerance and turns less than this (radians).
KEEP = 0.7
LARGEST_TURN = np.radians(20.0)
# How far a chord may be from bending evenly where it is cut in two or in four unseen, in parts of its largest offset:
# by a term of third order that makes the farthest of the parts leave its chord by 1 / KEEP of what even ones do.
EVEN_HALVES, EVEN_QUARTERS = 0.1, 0.07
# Part of the way along a chord that may be between two of its points and stay unseen.  Beside a tip of a cone the curve
# in u, v turns sharply into a ruling along which all points are next to the tip.
LEAP = 0.75
# Parts into which one chord may fall in one round, and rounds: a guard, 4 are usual.
MOST_PARTS = 128
MOST_ROUNDS = 24
MOST_CHORDS = 2_000_000
# A Newton step this short is the last: the next would be shorter than rounding.
SETTLED = 1e-9
STEPS = 8
# Steps that are not this short in the end do not converge.
SHORT = 1e-6
# f_y in units of the gradient below which its sign is not compared.
FLAT = 1e-6
# Rounding of f times its second derivatives, in parts of the squared slope, up to which doubles tell a zero; 1/2 would
# do for there to be one, its root is how far it may be in parts of the way to the next.
CLEAR = 1e-4
ROUND = 2.0**-53
# Zeros of a polynomial in one variable this near each other, or a pair of conjugate ones, may have been moved together
# or apart by rounding: about its fourth root, so that even three in one are.
CLOSE = 1e-5
# Of coefficients that are divided by.
SMALLEST = 1e-300
# Farther than this from a chord, in parts of the way to the next strand with the same sign of f_y, points may be on it.
FAR = 0.25
# Strands over a shorter range of x, in parts of x, have too few doubles there.
FINE = 2.0**-40


ALL_AROUND = np.array([-1.0, 0.0, 1.0, -0.5, 0.5, 0.0]), np.repeat([False, True], 3)
"""Some parameters of a closed family, as `Powers` takes them."""
Chord = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""From one point to another: differences of x and of y, both x."""


class Powers:
    """Homogeneous powers of parameters: x^i where x is the parameter, x^(n-i) where it is its reciprocal."""

    def __init__(self, x: np.ndarray, reverse: np.ndarray) -> None:
        self.x, self.reverse = x, reverse
        self._tables: dict[int, np.ndarray] = {}

    def table(self, degree: int) -> np.ndarray:
        """(degree + 1, n)"""
        if degree not in self._tables:
            table = np.empty((degree + 1, len(self.x)))
            table[0] = 1.0
            for i in range(1, degree + 1):
                np.multiply(table[i - 1], self.x, out=table[i])
            self._tables[degree] = self._turned(table)
        return self._tables[degree]

    def slopes(self, degree: int) -> np.ndarray:
        """Derivatives of the table by x."""
        table = np.zeros((degree + 1, len(self.x)))
        plain = np.ones(len(self.x))
        for i in range(1, degree + 1):
            np.multiply(plain, i, out=table[i])
            plain = plain * self.x
        return self._turned(table)

    def bends(self, degree: int) -> np.ndarray:
        """Second derivatives of the table by x."""
        table = np.zeros((degree + 1, len(self.x)))
        plain = np.ones(len(self.x))
        for i in range(2, degree + 1):
            np.multiply(plain, i * (i - 1), out=table[i])
            plain = plain * self.x
        return self._turned(table)

    def _turned(self, table: np.ndarray) -> np.ndarray:
        return np.where(self.reverse, table[::-1], table) if self.reverse.any() else table


def matrix(f: fmpz_mpoly) -> np.ndarray:
    """The coefficients c[i, j] of u^i v^j as doubles, scaled by the largest."""
    terms, degrees = f.to_dict(), f.degrees()
    largest = max(abs(int(c)) for c in terms.values())
    found = np.zeros((degrees[0] + 1, degrees[1] + 1))
    for (i, j), c in terms.items():
        found[i, j] = int(c) / largest
    return found


def rows(curve: Sequence[fmpz_poly]) -> np.ndarray:
    """(k, degree + 1) doubles, scaled by the largest coefficient."""
    found = [[int(x) for x in c.coeffs()] for c in curve]
    largest, width = max(abs(x) for row in found for x in row), max(map(len, found))
    return np.array([[x / largest for x in row] + [0.0] * (width - len(row)) for row in found])


def sizes(curves: Sequence[np.ndarray], at: Powers) -> np.ndarray:
    """The largest coordinates, in size, of points of curves (as by `rows`); of those that are not at infinity."""
    with np.errstate(all="ignore"):
        points = [c @ at.table(c.shape[1] - 1) for c in curves]
        found = np.concatenate([np.abs(c[:3] / c[3]).max(0) for c in points])
    return found[np.isfinite(found)]


class Surfaces:
    """Both families in doubles: directrices and primitive lines."""

    def __init__(self, p: RulingPiece, q: RulingPiece) -> None:
        self.ends = tuple(tuple(rows(c) for c in (x.rulings.first, x.rulings.second)) for x in (p, q))
        self.lines = tuple(rows(x.rulings.line) for x in (p, q))

    def points(self, u: Powers, v: Powers) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) meeting points and (n, 2) positions s, t on the rulings; infinite or nan where there are none."""
        with np.errstate(all="ignore"):
            (foot, along), (other_foot, other) = (
                _foot(line @ x.table(line.shape[1] - 1)) for line, x in zip(self.lines, (u, v), strict=True)
            )
            normal = _cross(along, other)
            far = (_cross(other_foot - foot, other) * normal).sum(0) / (normal * normal).sum(0)
            point = foot + far * along
            positions = [position(ends, x, point) for ends, x in zip(self.ends, (u, v), strict=True)]
        return point.T, np.stack(positions, axis=1)

    def size(self) -> float:
        """The median of the coordinates, in size, of some points of the directrices."""
        found = sizes([c for ends in self.ends for c in ends], Powers(*ALL_AROUND))
        return float(np.median(found)) if len(found) else 1.0


def _foot(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3, n) the points of the lines next to the origin, and their directions X2 - X1."""
    along, moment = -line[[2, 4, 5]], np.stack((line[3], -line[1], line[0]))
    return _cross(along, moment) / (along * along).sum(0), along


def position(ends: Sequence[np.ndarray], x: Powers, point: np.ndarray) -> np.ndarray:
    first, second = (c @ x.table(c.shape[1] - 1) for c in ends)
    first, second = first[:3] / first[3], second[:3] / second[3]
    along = second - first
    return ((point - first) * along).sum(0) / (along * along).sum(0)


def _cross(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of columns; several times faster than np.cross on few of them."""
    return np.stack((x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]))


@dataclass(frozen=True)
class TracedStrand:
    """One edge of the graph on its way to a polyline, in its chart.

    chart        whether the coordinates x, y are 1/u and 1/v
    across       False: x runs along the edge; True: y does, u is constant
    factor       index of its polynomial
    lo, hi       (x, y) at its ends
    inside       (x, y) of a point on it
    window       least and largest y of the chart
    slabs        (k, n): over all of the slab the strand is the k-th of the n roots of its curve inside the window
    limits       the ends of the slabs, ascending
    """

    edge: Any
    chart: tuple[bool, bool]
    across: bool
    factor: int
    lo: tuple[float, float]
    hi: tuple[float, float]
    inside: tuple[float, float]
    window: tuple[float, float]
    slabs: list[tuple[int, int]]
    limits: list[float]


@dataclass(frozen=True)
class Points:
    """Points on strands: index of the strand, position on it in [0, 1], chart coordinates, and in space.

    positions   (n, 2): s, t
    """

    strand: np.ndarray
    tau: np.ndarray
    x: np.ndarray
    y: np.ndarray
    space: np.ndarray
    positions: np.ndarray

    def __getitem__(self, index: slice | np.ndarray) -> Points:
        return Points(*(getattr(self, f.name)[index] for f in fields(self)))

    def __add__(self, other: Points) -> Points:
        """Both, ordered along the strands."""
        joined = [np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)]
        order = np.lexsort((joined[1], joined[0]))
        return Points(*(x[order] for x in joined))


class Tracer:
    """Polylines of all strands of one graph at once: arrays hold one entry per point."""

    def __init__(
        self, surfaces: Surfaces | _Sheet | BorderCurve, factors: Sequence[fmpz_mpoly], strands: Sequence[TracedStrand]
    ) -> None:
        self.surfaces, self.strands = surfaces, strands
        self.coefficients = [matrix(f) for f in factors]
        self.reverse_u, self.reverse_v = (np.array([s.chart[k] for s in strands]) for k in (0, 1))
        self.factor = np.array([s.factor for s in strands])
        self.across = np.array([s.across for s in strands])
        self.lo, self.hi, inside = (np.array([getattr(s, k) for s in strands]) for k in ("lo", "hi", "inside"))
        x_ends = np.stack((self.lo[:, 0], self.hi[:, 0]))
        whole = np.array([not s.slabs for s in strands], bool)  # lines
        self.fine = whole | (np.ptp(x_ends, axis=0) > FINE * np.abs(x_ends).max(0))
        # the least distance seen to roots over the same x with the same sign of f_y
        self.gap = np.full(len(strands), np.inf)
        self._known: dict[tuple[int, fmpq], float] = {}
        every = np.arange(len(strands))
        largest = np.abs([s.window for s in strands]).max(1)
        self.noise, self.bend = self._bounds(every, np.abs(x_ends).max(0), largest)
        self.slope_sign = self._slope_signs(inside)

    def trace(self, ends: np.ndarray, tolerance: float, radius: float) -> list[Points]:
        """The polyline of every strand, its ends included.

        ends: (n, 2, 5) the points at lo and hi (x, y, z, s, t); nan for an end at infinity: the polyline then ends
        a little beyond the radius.  Farther out than that the tolerance grows with the square of the distance.
        """
        found = self._coarse()
        for at_end in (0, 1):
            here = np.flatnonzero(~np.isnan(ends[:, at_end, 0]))
            corner = (self.lo, self.hi)[at_end][here]
            tau = np.full(len(here), float(at_end))
            found += Points(here, tau, corner[:, 0], corner[:, 1], ends[here, at_end, :3], ends[here, at_end, 3:])
        found = self._cut(found, ends, radius)
        found = self._refined(found, tolerance, radius)
        starts = np.searchsorted(found.strand, np.arange(len(self.strands) + 1))
        return [found[a:b] for a, b in pairwise(starts)]

    def _coarse(self) -> Points:
        strand = np.repeat(np.arange(len(self.strands)), FIRST - 1)
        tau = np.tile(np.arange(1, FIRST) / FIRST, len(self.strands))
        along = self._along(strand, tau)
        across = self.across[strand]
        x, y = np.where(across, self.lo[strand, 0], along), along.copy()
        own = np.flatnonzero(~across)
        x[own], y[own] = self._roots(strand[own], tau[own], x[own])
        return self._at(strand, tau, x, y)

    def _roots(self, strand: np.ndarray, tau: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(x, y) of the strands over x: the root with the index the slab tells, of as many as there are.

        Where doubles find another number of them, or may have confused some, the exact root.
        """
        x, y = x.copy(), np.full(len(x), np.nan)
        slabs = {n: slab for n, i in enumerate(strand) if self.fine[i] and (slab := self._slab(int(i), x[n]))}
        for k, c in enumerate(self.coefficients):
            own = np.array([n for n in slabs if self.factor[strand[n]] == k], int)
            if len(own) == 0:
                continue
            for n, roots in zip(own, self._real_roots(c, strand[own], x[own]), strict=True):
                index, number = slabs[n]
                if roots is not None and len(roots) == number:
                    y[n] = roots[index]
                    apart = [abs(roots[j] - y[n]) for j in (index - 2, index + 2) if 0 <= j < len(roots)]
                    self.gap[strand[n]] = min([self.gap[strand[n]], *apart])
        for n in np.flatnonzero(np.isnan(y)):
            x[n], y[n] = self._exact(int(strand[n]), tau[n], x[n])
            self.gap[strand[n]] = min(self.gap[strand[n]], CLOSE)
        return x, y

    def _slab(self, strand: int, x: float) -> tuple[int, int] | None:
        """Index and number of the roots over x; None where x is not told from the end of a slab."""
        s = self.strands[strand]
        at = int(np.searchsorted(s.limits, x)) - 1
        if not 0 <= at < len(s.slabs):
            return None
        near = FINE * abs(x)
        return s.slabs[at] if s.limits[at] + near < x < s.limits[at + 1] - near else None

    def _real_roots(self, c: np.ndarray, strand: np.ndarray, x: np.ndarray) -> list[list[float] | None]:
        """The real roots of f(x, .) inside the window of the chart, ascending; None where some may be confused."""
        u = Powers(x, self.reverse_u[strand])
        rows = (c.T @ u.table(c.shape[0] - 1)).T
        rows = np.where(self.reverse_v[strand, None], rows[:, ::-1], rows)
        size = np.maximum(np.abs(rows).max(1), SMALLEST)
        lead = np.where(np.abs(rows[:, -1]) > 1e-14 * size, rows[:, -1], 1e-14 * size)
        degree = rows.shape[1] - 1
        companion = np.zeros((len(x), degree, degree))
        companion[:, np.arange(1, degree), np.arange(degree - 1)] = 1.0
        companion[:, :, -1] = -rows[:, :-1] / lead[:, None]
        values = np.linalg.eigvals(companion)
        low, high = (edge[:, None] for edge in np.array([self.strands[i].window for i in strand]).T)
        near = (values.real > low - CLOSE) & (values.real < high + CLOSE) & (np.abs(values.imag) < CLOSE)
        apart = np.abs(values[:, :, None] - values[:, None, :]) + np.where(np.eye(degree, dtype=bool), np.inf, 0.0)
        clear = ~(near & (apart.min(2, initial=np.inf) < CLOSE)).any(1)
        real = (values.imag == 0.0) & (values.real > low) & (values.real < high)
        return [sorted(row[keep].real.tolist()) if sure else None
                for row, keep, sure in zip(values, real, clear, strict=True)]  # fmt: skip

    def _cut(self, points: Points, ends: np.ndarray, radius: float) -> Points:
        """Ends beyond the radius for strands that go to infinity, instead of what is farther out."""
        for at_end in (0, 1):
            for i in np.flatnonzero(np.isnan(ends[:, at_end, 0])):
                own = np.flatnonzero(points.strand == i)
                own = own[::-1] if at_end else own
                sizes = np.abs(points.space[own]).max(1)
                limit = max(radius, 2 * sizes.min())  # a strand may be far out altogether
                near = np.flatnonzero(sizes <= limit)
                keep = np.ones(len(points.strand), bool)
                keep[own[: near[0]]] = False
                outer = float(at_end) if near[0] == 0 else points.tau[own[near[0] - 1]]
                points = points[keep] + self._beyond(points[own[near[0] : near[0] + 1]], outer, at_end, limit)
        return points

    def _beyond(self, inner: Points, outer: float, at_end: int, radius: float) -> Points:
        """A point of the strand between `inner` and tau = outer whose largest coordinate is 1 to 2 times the radius."""
        for _ in range(60):
            middle = 0.5 * (inner.tau[0] + outer)
            tried = self._between(inner, np.array([middle]), at_end)
            size = np.abs(tried.space).max()
            if radius <= size <= 2 * radius:
                return tried
            if size < radius:
                inner = tried
            else:
                outer = middle
        return inner

    def _between(self, near: Points, tau: np.ndarray, at_end: int) -> Points:
        """A point between a known one and the end of its strand."""
        strand = near.strand
        along, across = self._along(strand, tau), self.across[strand]
        if across[0]:
            return self._at(strand, tau, near.x, along)
        return self._at(strand, tau, *self._roots(strand, tau, along))

    def _refined(self, points: Points, tolerance: float, radius: float) -> Points:
        """Chords are examined at three inner points; where the curve bends evenly, these settle what follows."""
        done = Points(*(getattr(points, f.name)[:0] for f in fields(points)))
        first = np.flatnonzero(points.strand[:-1] == points.strand[1:])
        left, right = points[first], points[first + 1]
        for _ in range(MOST_ROUNDS):
            if len(left.tau) == 0:
                break
            inner = [self._inside(left, right, part) for part in (0.25, 0.5, 0.75)]
            off, bend, uneven, leap = _shape(left.space, [x.space for x in inner], right.space)
            allowed = tolerance * np.maximum(1.0, np.abs(inner[1].space).max(1) / radius) ** 2
            need = np.maximum(np.sqrt(off / (KEEP * allowed)), bend / LARGEST_TURN)
            need, uneven = np.where(leap > LEAP, np.maximum(need, 2.0), need), np.where(leap > LEAP, np.inf, uneven)
            tiny = np.linalg.norm(right.space - left.space, axis=1) + off < 0.25 * allowed
            need = np.where(tiny, 0.0, need)
            halve = (need > 1) & (need <= 2) & (uneven <= EVEN_HALVES)
            quarter = (need > 2) & (need <= 4) & (uneven <= EVEN_QUARTERS)
            split = (need > 1) & ~halve & ~quarter
            if need.sum() > MOST_CHORDS:
                raise InputError(f"this tolerance needs more than {MOST_CHORDS} points; give a larger one")
            done += inner[1][halve | quarter] + inner[0][quarter] + inner[2][quarter]
            parts = np.clip(np.ceil(need / 3.5), 2, MOST_PARTS).astype(int)
            fresh = self._parts(left[split], [x[split] for x in inner], right[split], parts[split])
            done += fresh
            left, right = _chords(left[split], fresh, right[split], parts[split])
        return points + done

    def _inside(self, left: Points, right: Points, part: float) -> Points:
        tau, x, y = (a + part * (b - a) for a, b in ((left.tau, right.tau), (left.x, right.x), (left.y, right.y)))
        return self._at(left.strand, tau, x, y, (right.x - left.x, right.y - left.y, left.x, right.x))

    def _parts(self, left: Points, inner: list[Points], right: Points, parts: np.ndarray) -> Points:
        """The inner points that cut every chord into so many parts, by interpolation through the five known."""
        which, place = _counted(parts - 1)
        place = (place + 1) / parts[which]
        weights = _lagrange(place)
        known = [left, *inner, right]
        x, y = (sum(w * getattr(a, k)[which] for w, a in zip(weights, known, strict=True)) for k in ("x", "y"))
        tau = left.tau[which] + place * (right.tau - left.tau)[which]
        chord = (right.x - left.x)[which], (right.y - left.y)[which], left.x[which], right.x[which]
        return self._at(left.strand[which], tau, np.asarray(x), np.asarray(y), chord)

    def _at(
        self, strand: np.ndarray, tau: np.ndarray, x: np.ndarray, y: np.ndarray,
        chord: Chord | None = None,
    ) -> Points:  # fmt: skip
        x, y = self._settled(strand, tau, x, y, chord)
        u, v = Powers(x, self.reverse_u[strand]), Powers(y, self.reverse_v[strand])
        return Points(strand, tau, x, y, *self.surfaces.points(u, v))

    def _along(self, strand: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """The running coordinate, quadratic in tau at both ends: simple turning points become regular."""
        axis = self.across[strand].astype(int)
        lo, hi = self.lo[strand, axis], self.hi[strand, axis]
        return lo + (hi - lo) * np.sin(0.5 * np.pi * tau) ** 2

    def _settled(
        self, strand: np.ndarray, tau: np.ndarray, x: np.ndarray, y: np.ndarray, chord: Chord | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """The points on their curve, moved across the chord, or along the gradient; those with u constant stay.

        Where that leads away from the chord, or nowhere, the root over x is taken; where doubles do not tell it from
        others, the exact one.
        """
        own = np.flatnonzero(~self.across[strand])
        which, from_x, from_y = strand[own], x[own], y[own]
        across = None if chord is None else (-chord[1][own], chord[0][own])
        (near_x, near_y), slope, still, clear = self._moved(which, from_x, from_y, across)
        way = np.hypot(near_x - from_x, near_y - from_y)
        if chord is None:
            lost = way > CLOSE
        else:
            start, end, lost = chord[2][own], chord[3][own], np.zeros(len(own), bool)
            beside = (near_x < np.minimum(start, end)) | (near_x > np.maximum(start, end))
            astray = np.flatnonzero((beside | ~still | (way > FAR * self.gap[which])) & self.fine[which])
            if len(astray):
                at = self._roots(which[astray], tau[own[astray]], from_x[astray])
                found, slope[astray], _, clear[astray] = self._moved(which[astray], *at)
                lost[astray] = np.hypot(found[0] - at[0], found[1] - at[1]) > CLOSE
                near_x[astray], near_y[astray] = found
        lost |= ~clear | ((slope * self.slope_sign[which] < 0) & (np.abs(slope) > FLAT))
        for i in np.flatnonzero(lost):
            near_x[i], near_y[i] = self._exact(int(which[i]), tau[own[i]], from_x[i])
        x, y = x.copy(), y.copy()
        x[own], y[own] = near_x, near_y
        return x, y

    def _moved(
        self, strand: np.ndarray, x: np.ndarray, y: np.ndarray, across: tuple[np.ndarray, np.ndarray] | None = None
    ) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray, np.ndarray, np.ndarray]:
        """Newton steps in a direction, by default the gradient.

        Also f_y in units of the gradient, whether the last step is short, and whether doubles tell this zero alone.
        """
        x, y, slope, still = x.copy(), y.copy(), np.zeros(len(x)), np.ones(len(x), bool)
        steep, last = np.zeros(len(x)), np.zeros(len(x))
        for k, own in self._of_factors(strand):
            at_x, at_y = x[own], y[own]
            for _ in range(STEPS + 1):
                value, fx, fy = self._values(k, strand[own], at_x, at_y)
                dx, dy = (fx, fy) if across is None else (across[0][own], across[1][own])
                rise = fx * dx + fy * dy
                move = value / np.where(rise == 0, np.inf, rise)
                move_x, move_y = move * dx, move * dy
                at_x, at_y = at_x - move_x, at_y - move_y
                last[own] = np.abs(move_x) + np.abs(move_y)
                if last[own].max() < SETTLED:
                    break
            size, length = np.hypot(fx, fy), np.hypot(dx, dy)
            x[own], y[own], slope[own] = at_x, at_y, fy / np.where(size == 0, 1.0, size)
            steep[own] = np.abs(rise) / np.where(length == 0, 1.0, length)
            still[own] = last[own] < SHORT
        return (x, y), slope, still, still & self._is_clear(strand, x, y, steep, last)

    def _of_factors(self, strand: np.ndarray) -> list[tuple[int, np.ndarray]]:
        """Indices of the points on each of the curves that have any."""
        found = ((k, np.flatnonzero(self.factor[strand] == k)) for k in range(len(self.coefficients)))
        return [(k, own) for k, own in found if len(own)]

    def _values(
        self, k: int, strand: np.ndarray, x: np.ndarray, y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """f, f_x, f_y of a curve at points of its strands."""
        c = self.coefficients[k]
        u, v = Powers(x, self.reverse_u[strand]), Powers(y, self.reverse_v[strand])
        in_u, in_v = u.table(c.shape[0] - 1), c @ v.table(c.shape[1] - 1)
        fx = (u.slopes(c.shape[0] - 1) * in_v).sum(0)
        fy = (in_u * (c @ v.slopes(c.shape[1] - 1))).sum(0)
        return (in_u * in_v).sum(0), fx, fy

    def _is_clear(
        self, strand: np.ndarray, x: np.ndarray, y: np.ndarray, steep: np.ndarray, last: np.ndarray | float
    ) -> np.ndarray:
        """Whether a slope and the last of Newton's steps tell a zero from others: first by bounds of whole strands."""

        def told(noise: np.ndarray, bend: np.ndarray, steep: np.ndarray, last: np.ndarray) -> np.ndarray:
            return (noise * bend <= CLEAR * steep**2) & (last * bend <= np.sqrt(CLEAR) * steep) & (steep > 0)

        last = np.broadcast_to(last, steep.shape)
        clear = self.fine[strand] & told(self.noise[strand], self.bend[strand], steep, last)
        closer = np.flatnonzero(~clear & self.fine[strand])
        if len(closer):
            bounds = self._bounds(strand[closer], np.abs(x[closer]), np.abs(y[closer]))
            clear[closer] = told(*bounds, steep[closer], last[closer])
        return clear

    def _bounds(self, strand: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds on the rounding of f and on its second derivatives, at points of strands up to this far from 0."""
        noise, bend = np.zeros(len(x)), np.zeros(len(x))
        for k, own in self._of_factors(strand):
            c = np.abs(self.coefficients[k])
            n, m = c.shape[0] - 1, c.shape[1] - 1
            u, v = Powers(x[own], self.reverse_u[strand[own]]), Powers(y[own], self.reverse_v[strand[own]])
            in_u, in_v = u.table(n), c @ v.table(m)
            noise[own] = (n + m + 3) * ROUND * (in_u * in_v).sum(0)
            mixed = 2.0 * u.slopes(n) * (c @ v.slopes(m))
            bend[own] = (u.bends(n) * in_v + mixed + in_u * (c @ v.bends(m))).sum(0)
        return noise, bend

    def _slope_signs(self, inside: np.ndarray) -> np.ndarray:
        """The signs of f_y on the strands, 0 where it is small at the point inside."""
        signs, every = np.zeros(len(self.strands)), np.arange(len(self.strands))
        for k, own in self._of_factors(every):
            x, y = inside[own].T
            _, fx, fy = self._values(k, own, x, y)
            signs[own] = np.where(np.abs(fy) > FLAT * np.hypot(fx, fy), np.sign(fy), 0.0)
            for i in own[~self._is_clear(own, x, y, np.abs(fy), 0.0) & ~self.across[own]]:
                signs[i] = self.strands[i].edge.slope_sign
        return signs

    def _exact(self, strand: int, tau: float, x: float) -> tuple[float, float]:
        """The point of the strand over x, or over the next double inside its ends; over tau where these are few."""
        edge = self.strands[strand].edge
        if self.fine[strand]:
            lo, hi = sorted((self.lo[strand, 0], self.hi[strand, 0]))
            at = fmpq(*float(min(max(x, np.nextafter(lo, hi)), np.nextafter(hi, lo))).as_integer_ratio())
        else:
            at = edge.between(fmpq(*float(np.sin(0.5 * np.pi * tau) ** 2).as_integer_ratio()))
        if (strand, at) not in self._known:
            self._known[strand, at] = float(edge.at(at))
        return to_double(at), self._known[strand, at]


def _shape(left: np.ndarray, inner: list[np.ndarray], right: np.ndarray) -> tuple[np.ndarray, ...]:
    """How far the inner points are off the chord, how much the curve turns, how it differs from a parabola, and the
    largest way from point to point, in parts of all."""
    chord = right - left
    length = np.linalg.norm(chord, axis=1)
    unit = chord / np.where(length > 0, length, 1.0)[:, None]
    offsets = []
    for point in inner:
        from_left = point - left
        along = np.clip((from_left * unit).sum(1), 0.0, length)
        offsets.append(np.linalg.norm(from_left - along[:, None] * unit, axis=1))
    off = np.maximum.reduce(offsets)
    start, stop = inner[0] - left, right - inner[2]
    sizes = np.linalg.norm(start, axis=1) * np.linalg.norm(stop, axis=1)
    cosine = (start * stop).sum(1) / np.where(sizes > 0, sizes, 1.0)
    bend = np.where(sizes > 0, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    uneven = np.maximum(np.abs(offsets[0] - 0.75 * off), np.abs(offsets[2] - 0.75 * off)) / np.where(off > 0, off, 1.0)
    ways = np.linalg.norm(np.diff([left, *inner, right], axis=0), axis=2)
    total = ways.sum(0)
    return off, bend, uneven, ways.max(0) / np.where(total > 0, total, 1.0)


def _lagrange(t: np.ndarray) -> list[np.ndarray]:
    """Weights of the interpolation at t from values at 0, 1/4, 1/2, 3/4, 1."""
    knots = np.linspace(0.0, 1.0, 5)
    weights = []
    for i, a in enumerate(knots):
        others = np.delete(knots, i)
        weights.append(np.prod([(t - b) / (a - b) for b in others], axis=0))
    return weights


def _chords(left: Points, fresh: Points, right: Points, parts: np.ndarray) -> tuple[Points, Points]:
    """The chords between neighbours among the ends and the fresh inner points, chord after chord."""
    which, place = _counted(parts)
    inner = np.cumsum(parts - 1)[which] - (parts[which] - 1) + place  # the fresh point behind
    before = np.where(place == 0, which, len(left.tau) + inner - 1)
    after = np.where(place == parts[which] - 1, len(fresh.tau) + which, inner)
    return _stacked(left, fresh)[before], _stacked(fresh, right)[after]


def _counted(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices 0, 0, 1, 1, 1, ... of groups of these sizes, and 0, 1, 0, 1, 2, ... within them."""
    which = np.repeat(np.arange(len(counts)), counts)
    return which, np.arange(len(which)) - (np.cumsum(counts) - counts)[which]


def _stacked(a: Points, b: Points) -> Points:
    return Points(*(np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(a)))
