"""Whole rulings cut to segments that hold all within a distance R of a point c.

Their ends at s = -S and s = S are farther than R from c, and the foot of the perpendicular from c lies between them:
signs of polynomials prove that over the range of u.  Where directrices go to infinity, u is first cut to where rulings
come within R of c at all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpz_poly

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.signs.pieces import range_of
from firstcontact.contact.signs.sheets import between, samples
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot, roots_in
from firstcontact.exact.numbers import exact_value, fraction
from firstcontact.exact.polynomials.inertia import dot
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rational import RationalMotion
from firstcontact.pairs.ruled_ruled import Rulings

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.ruled.rational_curve import RationalCurve

UNIT = fmpq(-1), fmpq(1)
# The largest S that is tried; powers of 2.
MOST = 2**40
Range = tuple[fmpq, fmpq] | None


def cut_to(ruled: Body, solid: Body, span: tuple[float, float]) -> Any:
    """The ruled body with segments in place of whole rulings, which hold all that the solid may meet in the span.

    Itself where no rulings are whole.  Raises UnsupportedPair.
    """
    shape = shape_of(ruled)
    if all(piece.s is not None or piece.deforming or piece.trim for piece in shape.pieces):
        return ruled
    (piece,) = shape.pieces
    who = piece.name or "the ruled surface"
    if isinstance(ruled, Moving) and isinstance(ruled.motion, RationalMotion):
        raise UnsupportedPair(f"{who} has whole rulings and moves by {ruled.motion!r}; bound s, or move the solid")
    centre = _centre(piece)
    reach = _farthest(Polyhedron([centre], [], name=who), ruled, solid, span)
    if not reach < 2.0**100:
        raise UnsupportedPair(f"{who} has whole rulings and the solid is unbounded; bound s of {who}")
    found = segments(piece, centre, reach)
    if found is None or len(found) > 1:
        raise UnsupportedPair(
            f"{who} has whole rulings whose directrices meet, or go to infinity; bound s, or shorten u of {who}"
        )
    return Moving(found[0], ruled.motion) if isinstance(ruled, Moving) else found[0]


_SEGMENTS = Kept[dict[tuple[tuple[float, ...], float], list[RuledSurface] | None]]()


def segments(piece: RuledSurface, centre: Sequence[float], reach: float) -> list[RuledSurface] | None:
    """Surfaces with bounded rulings that hold all of this one within the reach of the centre, or farther out: never [].

    None where directrices meet or have poles on the way, or where u would have to pass through infinity.
    """
    known, key = _SEGMENTS.of(piece, dict), (tuple(centre), reach)
    if key not in known:
        c, far = [exact_value(float(x)) for x in centre], exact_value(float(reach))
        known[key] = _over(piece, [range_of(piece.u)], c, far)
        if known[key] is None:
            while (ranges := _ranges_near(piece, c, far)) is not None and not ranges:
                far *= 2
            known[key] = None if ranges is None else _over(piece, ranges, c, far)
    return known[key]


def _over(piece: RuledSurface, ranges: Sequence[Range], c: Sequence[fmpq], reach: fmpq) -> list[RuledSurface] | None:
    """The surfaces over these ranges of u; None where one has no S."""
    found = []
    for ends in ranges:
        last = _last(piece, ends, c, reach)
        if last is None:
            return None
        u = None if ends is None else tuple(fraction(x) for x in ends)
        found.append(RuledSurface(piece.first, piece.second, u=u, s=(-last, last), name=piece.name))
    return found


def _centre(piece: RuledSurface) -> list[float]:
    lo, hi = (-1.0, 1.0) if piece.u is None else (float(x) for x in piece.u)
    point = piece.first.points(np.array([0.5 * (lo + hi)]))[0]
    return [float(c) if math.isfinite(c) else 0.0 for c in point]


def _farthest(mark: Polyhedron, ruled: Body, solid: Body, span: tuple[float, float]) -> float:
    """How far points of the solid may be from a point of the ruled body's frame: motions keep lengths."""
    moved = Moving(mark, ruled.motion) if isinstance(ruled, Moving) else mark
    (lo, hi), (low, high) = (x.bounds(span) if isinstance(x, Moving) else x.bounds() for x in (moved, solid))
    gap = np.maximum(np.abs(np.subtract(high, lo)), np.abs(np.subtract(hi, low)))
    return float(np.linalg.norm(gap) * (1 + 1e-9))


def _ranges_near(piece: RuledSurface, c: Sequence[fmpq], reach: fmpq) -> list[Range] | None:
    """Ranges of u that hold all rulings within the reach of c; None where one would pass through infinity.

    With the direction d and the moment m about c, the distance of a ruling is |m| / |d|.
    """
    l01, l02, l03, l12, l13, l23 = Rulings.of(piece.first.components, piece.second.components).line
    d, scale = (-l03, -l13, -l23), _denominator([*c, reach])
    x, y, z = (int((scale * a).p) for a in c)
    shift = (y * d[2] - z * d[1], z * d[0] - x * d[2], x * d[1] - y * d[0])
    m = [scale * a - b for a, b in zip((l12, -l02, l01), shift, strict=True)]
    beyond = dot(m, m) - dot(d, d) * (scale * reach).p ** 2
    ends = range_of(piece.u)
    if beyond == 0:  # type: ignore[comparison-overlap]  # a polynomial
        return None
    walls = [x for x in roots_in(beyond, ends) if ends is None or (x.compare(ends[0]) > 0 and x.compare(ends[1]) < 0)]
    inside = samples(walls, ends)
    near = [k for k, x in enumerate(inside) if beyond(x) <= 0]
    if ends is None and not {0, len(walls)}.isdisjoint(near):
        return None
    # the range of every cell, up to a little beyond its walls
    found: list[Range] = []
    for k in near:
        lo = ends[0] if ends and k == 0 else _beside(walls[k - 1], inside[k - 1])
        hi = ends[1] if ends and k == len(walls) else _beside(walls[k], inside[k + 1])
        if k - 1 in near:
            lo = found.pop()[0]  # type: ignore[index]
        found.append((lo, hi))
    return found


def _beside(root: AlgebraicRoot, x: fmpq) -> fmpq:
    """A short number between a root and x, not far from the root."""
    at = exact_value(float(root))
    step = (x - at) * min(fmpq(1), (1 + abs(at)) / (16 * abs(x - at)))
    return between(*sorted((root, AlgebraicRoot.of(at + step)), key=float))


def _last(piece: RuledSurface, ends: Range, c: Sequence[fmpq], reach: fmpq) -> int | None:
    """An S beyond which, and below whose opposite, no ruling over this range comes within the reach of c."""
    charts = [(piece.first, piece.second, ends or UNIT)]
    if ends is None:
        charts.append((piece.first.reversed(), piece.second.reversed(), UNIT))
    tests = [_Segment(*chart, c, reach) for chart in charts]
    if not all(test.finite for test in tests):
        return None
    last = 1
    while last <= MOST:
        if all(test.holds(s) for test in tests for s in (last, -last)):
            return last
        last *= 2
    return None


class _Segment:
    """Rulings over one range of a parameter; all polynomials are times positive numbers.

    finite   whether the directrices have no poles there
    """

    def __init__(
        self, first: RationalCurve, second: RationalCurve, ends: tuple[fmpq, fmpq], c: Sequence[fmpq], reach: fmpq
    ) -> None:
        *p, w = first.components
        *q, v = second.components
        scale = _denominator([*c, reach])
        self.ends, self.finite = ends, all(_is_positive(f * f, ends) for f in (w, v))
        self.start = [(scale * a - int((scale * x).p) * w) * v for a, x in zip(p, c, strict=True)]
        self.way = [scale * (b * w - a * v) for a, b in zip(p, q, strict=True)]
        self.far = (w * v * int((scale * reach).p)) ** 2

    def holds(self, s: int) -> bool:
        """Whether the points at s are beyond the reach, on the side of the foot to which s tells."""
        at = [a + s * b for a, b in zip(self.start, self.way, strict=True)]
        along = dot(at, self.way) * s
        return _is_positive(along, self.ends) and _is_positive(dot(at, at) - self.far, self.ends)


def _denominator(numbers: Sequence[fmpq]) -> int:
    return math.lcm(*(int(x.q) for x in numbers))


def _is_positive(f: fmpz_poly, ends: tuple[fmpq, fmpq]) -> bool:
    return f(ends[0]) > 0 and not roots_in(f, ends)
