"""Cusps on polylines found in doubles: where a branch passes the singular point of a torsal ruling.

There P_u and P_s are parallel, so Delta_u = <l', m> is zero with Delta: v and the point stand still together.  On a
ruling at which the family stands still all points are such (u = 0 and infinity of a family in u^2, the border of a
strip that lies twice in a plane).  Edges of regression, singular points of all rulings, are not looked for here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import comb
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import fmpq
from numpy.polynomial.polynomial import polyder, polyval

from firstcontact.body.kept import Kept
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.bernstein import product
from firstcontact.curves.certified.chains import Chain
from firstcontact.curves.certified.regular import chain_lines
from firstcontact.curves.exactly.cusps import singular_points, stationary_rulings, torsal_rulings
from firstcontact.curves.exactly.tracing import Powers, Surfaces, rows
from firstcontact.exact.fields.roots import AlgebraicRoot, roots_in
from firstcontact.exact.numbers import precision
from firstcontact.pairs.ruled_ruled import DUAL

if TYPE_CHECKING:
    from firstcontact.body.ruled.surface import RuledSurface
    from firstcontact.pairs.ruled_ruled import Rulings

_TORSAL = Kept[list["Special"]]()
_LIKELY = Kept[list["Likely"]]()
"""Torsal rulings of a piece, exactly, and as far as doubles tell."""
MINORS = np.triu_indices(6, 1)
UNIT = fmpq(-1), fmpq(1)
# Coefficients that are not told from zero, in parts of what they are made of; how far from the real axis and beyond a
# part doubles may put a root; degrees above which they find none; room beside the ends of rulings.
ZERO, ASIDE, MOST_DEGREE, BESIDE = 1e-11, 1e-2, 24, 1e-2
# Where rulings move less than this part of what they usually do, they may stand still; what divides at least.
STILL, LEAST = 1e-2, 1e-300
# Rows this near such a ruling are on it; how many rows about it tell the length of chords; Newton's steps.
AT_RULING, AROUND, STEPS = 1e-12, 2, 12
# How far from the polyline the point may be, in chords there; points that are one, in parts of their size, and points
# that may be one.
FARTHEST, ONE_POINT, ROUGHLY = 4.0, 1e-8, 1e-5
# Steps from the ruling, in ranges, at which directions are compared: the first at which the curve has moved that far.
AWAY, MOVED = (1e-5, 1e-4, 1e-3, 1e-2), 1e-9

Passed = tuple[int, int, np.ndarray, np.ndarray]
"""Rows before and after; the point; u, v, s, t.  Rows between are on the ruling too."""


class Special(NamedTuple):
    """A torsal ruling in the chart of u or, reverse, of 1/u; point None where the family stands still."""

    reverse: bool
    x: float
    point: np.ndarray | None


class Likely(NamedTuple):
    """The same in doubles, u None where they tell no place."""

    u: float | None
    point: np.ndarray | None


def turned_back(
    own: Chain, other: Chain, points: np.ndarray, parameters: np.ndarray, tolerance: float
) -> list[Passed]:
    """Where a polyline, given by its points and u, v, s, t, turns back at a ruling of the first chain; not at ends."""
    found: dict[int, Passed] = {}
    if any(_LIKELY.get(piece) is None for piece in own.pieces):
        _look_for(own)
    u = parameters[:, 0].copy()
    low, high = u.min(), u.max()
    for piece in own.pieces:
        near = (x for x in _LIKELY.get(piece) or () if x.u is None or low <= x.u <= high)
        if any(_may_pass(x, points, u, tolerance) for x in near):
            for special in _torsal(piece):
                for cusp in _at_ruling(piece, other.pieces, special, points, parameters, tolerance):
                    found[cusp[0]] = cusp
    return list(found.values())


# -- rulings ------------------------------------------------------------------------------------------------


def _torsal(piece: RuledSurface) -> list[Special]:
    """Those of a closed surface in the charts of u and of 1/u; both may have 1 and -1."""
    return _TORSAL.of(piece, lambda: list(_torsal_rulings(RulingPiece.of(piece))))


def _torsal_rulings(piece: RulingPiece) -> Iterator[Special]:
    charts = [(False, piece.rulings, piece.u or UNIT)]
    if piece.u is None:
        charts.append((True, piece.rulings.reversed(), UNIT))
    for reverse, lines, ends in charts:
        still, torsal = stationary_rulings(lines), torsal_rulings(lines)
        for root in roots_in(still if torsal == 0 else torsal, ends):
            at = None if root.sign_of(still) == 0 else _singular_point(lines, root)
            yield Special(reverse, float(root), at)


def _singular_point(lines: Rulings, root: AlgebraicRoot) -> np.ndarray:
    """The point in which a torsal ruling meets its neighbours; not finite where that is at infinity."""
    at = root.enclosure(128)
    with precision(128):
        *point, weight = (c(at) for c in singular_points(lines))
        return np.array([float((x / weight).mid()) for x in point])


def _look_for(chain: Chain) -> None:
    """Tell all pieces of a chain what torsal rulings they may have, with points between their ends, on the way."""
    if not len(irregular := chain.irregular):
        for piece in chain.pieces:
            _LIKELY.put(piece, [])
        return
    lines = chain_lines(chain)[irregular]
    slopes = np.diff(lines, axis=2)
    torsal = product(slopes[:, :3], slopes[:, :2:-1])
    torsal = torsal[:, 0] - torsal[:, 1] + torsal[:, 2]
    near = ZERO * np.abs(slopes).max(2).max(1) ** 2
    flat = np.abs(torsal).max(1) <= near
    mixed = (torsal.min(1) <= near) & (torsal.max(1) >= -near) & ~flat
    if flat.any():
        flat[flat] = _may_stand_still(lines[flat], slopes[flat])
    likely: list[list[Likely]] = [[] for _ in chain.pieces]
    for n in np.flatnonzero(flat | mixed).tolist():
        part = int(irregular[n])
        k = int(chain.piece_of[part])
        if flat[n] or chain.pieces[k].u is None or torsal.shape[1] > MOST_DEGREE:
            likely[k].append(Likely(None, None))
        else:
            likely[k] += _likely(chain, part, torsal[n])
    for piece, own in zip(chain.pieces, likely, strict=True):
        _LIKELY.put(piece, own)


def _may_stand_still(lines: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """(parts,): False where a minor of l and l' has one sign."""
    products = product(lines[:, :, None], slopes[:, None])
    minors = (products - products.swapaxes(1, 2))[:, *MINORS]
    near = ZERO * (np.abs(lines).max(2).max(1) * np.abs(slopes).max(2).max(1))[:, None]
    return ((minors.min(2) <= near) & (minors.max(2) >= -near)).all(1)  # type: ignore[no-any-return]


def _likely(chain: Chain, part: int, torsal: np.ndarray) -> Iterator[Likely]:
    control = chain.points[part].reshape(2, 4, -1)
    usual = np.abs(np.diff(control[:, :3] / control[:, 3:])).max() * (control.shape[2] - 1)
    for root in np.roots((torsal @ _powers_of(len(torsal) - 1))[::-1]):
        if abs(root.imag) > ASIDE or not -ASIDE <= root.real <= 1.0 + ASIDE:
            continue
        x = min(max(float(root.real), 0.0), 1.0)
        (first, second), (slope, other) = _ends(control, x)
        along = second - first
        moved, turn = _cross(slope, along), _cross(other - slope, along)
        u = float(chain.parameter(np.array([part]), np.array([x]))[0])
        if max(np.abs(moved).max(), np.abs(moved + turn).max()) <= STILL * usual * np.abs(along).max():
            yield Likely(u, None)
            continue
        s = -float(moved @ turn) / max(float(turn @ turn), LEAST)
        if -BESIDE <= s <= 1.0 + BESIDE:
            yield Likely(u, first + s * along)


@lru_cache(maxsize=64)
def _powers_of(n: int) -> np.ndarray:
    """(n + 1, n + 1): Bernstein polynomials of degree n in powers, a row each."""
    return np.array([[(-1) ** (j - i) * comb(n, j) * comb(j, i) if j >= i else 0 for j in range(n + 1)]
                     for i in range(n + 1)], float)  # fmt: skip


def _ends(control: np.ndarray, x: float) -> tuple[np.ndarray, np.ndarray]:
    """(2, 3) both ends of the ruling at x, and how they move there."""
    n = control.shape[2] - 1
    while control.shape[2] > 2:
        control = (1.0 - x) * control[:, :, :-1] + x * control[:, :, 1:]
    value, slope = (1.0 - x) * control[:, :, 0] + x * control[:, :, 1], n * (control[:, :, 1] - control[:, :, 0])
    point = value[:, :3] / value[:, 3:]
    return point, (slope[:, :3] - point * slope[:, 3:]) / value[:, 3:]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of two vectors; faster than np.cross."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


# -- polylines ----------------------------------------------------------------------------------------------


def _room(point: np.ndarray, tolerance: float) -> float:
    """How far a polyline may be from a point that the curve passes."""
    return 2.0 * tolerance + ROUGHLY * max(1.0, float(np.abs(point).max()))


def _may_pass(likely: Likely, points: np.ndarray, u: np.ndarray, tolerance: float) -> bool:
    """Whether a polyline passes such a ruling near its point."""
    if likely.u is None:
        return True
    side = u >= likely.u
    crossing = np.flatnonzero(side[1:] != side[:-1]).tolist()
    if likely.point is None:
        return bool(crossing)
    return any(_is_near(likely.point, points[k : k + 2], tolerance) for k in crossing)


def _is_near(point: np.ndarray, line: np.ndarray, tolerance: float) -> bool:
    """Whether the curve may pass through the point along these chords."""
    along = np.diff(line, axis=0)
    share = ((point - line[:-1]) * along).sum(1) / np.maximum((along * along).sum(1), LEAST)
    off = np.abs(line[:-1] + share.clip(0.0, 1.0)[:, None] * along - point).max(1)
    return bool(off.min() <= _room(point, tolerance))


def _chord(points: np.ndarray, i: int, j: int) -> float:
    """The longest one next to these rows."""
    return float(np.abs(np.diff(points[max(i - AROUND, 0) : j + AROUND + 1], axis=0)).max())


def _at_ruling(
    piece: RuledSurface,
    others: Sequence[RuledSurface],
    special: Special,
    points: np.ndarray,
    parameters: np.ndarray,
    tolerance: float,
) -> Iterator[Passed]:
    with np.errstate(divide="ignore"):
        x = 1.0 / parameters[:, 0] if special.reverse else parameters[:, 0]
    low, high = (-2.0, 2.0) if piece.u is None else (float(u) for u in piece.u)
    inside = (x >= low - AT_RULING) & (x <= high + AT_RULING)
    side = np.where(np.abs(x - special.x) <= AT_RULING, 0.0, np.sign(x - special.x))
    off = np.flatnonzero(side)
    for n in np.flatnonzero(side[off[1:]] * side[off[:-1]] < 0.0):
        i, j = int(off[n]), int(off[n + 1])
        if not (inside[i] and inside[j]):
            continue
        if special.point is not None and not _is_near(special.point, points[i : j + 1], tolerance):
            continue
        if (over := _Over.of(piece, others, special.reverse, parameters[i, 1])) is not None:
            point, known = over.at(special.x)
            size = ONE_POINT * max(1.0, float(np.abs(point).max()))
            here = special.point is None or bool(np.abs(point - special.point).max() <= size)
            near = np.abs(point - points[i]).max() <= FARTHEST * _chord(points, i, j)
            if here and near and over.turns(special.x, high - low):
                yield i, j, point, known


class _Over:
    """The curve over u, in the chart of u or 1/u, near a value of v."""

    def __init__(self, own: RuledSurface, other: RuledSurface, reverse: bool, start: float) -> None:
        self.p, self.q = RulingPiece.of(own), RulingPiece.of(other)
        self.reverse, self.far = reverse, bool(abs(start) > 1.0)
        self.start = 1.0 / start if self.far else start
        self.line = rows(self.p.reversed_rulings(reverse).line).T
        lines = rows(self.q.reversed_rulings(self.far).line)
        self.lines = np.array([sign * lines[j] for j, sign in DUAL])
        self.surfaces = Surfaces(self.p, self.q)

    @classmethod
    def of(cls, own: RuledSurface, others: Sequence[RuledSurface], reverse: bool, v: float) -> _Over | None:
        other = next((p for p in others if p.u is None or float(p.u[0]) <= v <= float(p.u[1])), None)
        return None if other is None else cls(own, other, reverse, float(v))

    def at(self, x: float) -> tuple[np.ndarray, np.ndarray]:
        """The point over x, and u, v, s, t; Newton."""
        delta = polyval(x, self.line) @ self.lines
        slope, y = polyder(delta), self.start
        for _ in range(STEPS):
            change = polyval(y, slope)
            if change == 0.0:
                break
            y -= polyval(y, delta) / change
        charts = (x, self.reverse), (y, self.far)
        powers = (Powers(np.array([z]), np.array([turned])) for z, turned in charts)
        points, positions = self.surfaces.points(*powers)
        u, v = (1.0 / z if turned and z else np.inf if turned else z for z, turned in charts)
        return points[0], np.array([u, v, self.p.user_s(positions[0, 0]), self.q.user_s(positions[0, 1])])

    def turns(self, x: float, width: float) -> bool:
        """Whether the curve leaves the point over x to the side from which it comes there."""
        centre = self.at(x)[0]
        for step in AWAY:
            before, after = (self.at(x + way * step * width)[0] - centre for way in (-1, 1))
            if min(np.abs(before).max(), np.abs(after).max()) > MOVED * max(1.0, float(np.abs(centre).max())):
                return bool(before @ after > 0.0)
        return False
