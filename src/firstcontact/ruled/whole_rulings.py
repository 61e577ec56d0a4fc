"""Whole rulings that meet bounded solids, cut to segments that reach beyond them.

Where the directrices P1 and P2 are finite and apart over the range of u, |P1 - c| <= A and |P2 - P1| >= m there, a
point of a ruling with |s| m > R + A is farther than R from c.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from flint import fmpq, fmpz_poly

from firstcontact.body.moving import Moving, shape_of
from firstcontact.body.polyhedron import Polyhedron
from firstcontact.body.ruled_surface import RuledSurface
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import exact_value, rational
from firstcontact.exact.roots import roots_in
from firstcontact.motion.rational import RationalMotion

SAMPLES = 65
SHARES = 0.9, 0.5, 0.1
"""Of the least sampled distance of the directrices, tried for m; A is the largest sampled one over them."""
UNIT = fmpq(-1), fmpq(1)


def cut_to(ruled: Any, solid: Any, span: tuple[float, float]) -> Any:
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
    last = _last(piece, centre, exact_value(reach))
    if last is None:
        raise UnsupportedPair(
            f"{who} has whole rulings whose directrices meet, or go to infinity; bound s, or shorten u of {who}"
        )
    size = 2 ** max(0, math.ceil(math.log2(float(last))) + 1)
    key = "cut rulings", size
    if key not in piece._search:
        piece._search[key] = RuledSurface(piece.first, piece.second, u=piece.u, s=(-size, size), name=piece.name)
    return Moving(piece._search[key], ruled.motion) if isinstance(ruled, Moving) else piece._search[key]


def _centre(piece: RuledSurface) -> list[float]:
    lo, hi = (-1.0, 1.0) if piece.u is None else (float(x) for x in piece.u)
    point = piece.first.points(np.array([0.5 * (lo + hi)]))[0]
    return [float(c) if math.isfinite(c) else 0.0 for c in point]


def _farthest(mark: Polyhedron, ruled: Any, solid: Any, span: tuple[float, float]) -> float:
    """How far points of the solid may be from a point of the ruled body's frame: motions keep lengths."""
    moved = Moving(mark, ruled.motion) if isinstance(ruled, Moving) else mark
    (lo, hi), (low, high) = (x.bounds(span) if isinstance(x, Moving) else x.bounds() for x in (moved, solid))
    gap = np.maximum(np.abs(np.subtract(high, lo)), np.abs(np.subtract(hi, low)))
    return float(np.linalg.norm(gap) * (1 + 1e-9))


def _last(piece: RuledSurface, centre: Sequence[float], reach: fmpq) -> fmpq | None:
    """An s beyond which, and below whose opposite, no ruling comes within the reach of the centre."""
    c = [exact_value(x) for x in centre]
    lo, hi = (-1.0, 1.0) if piece.u is None else (float(x) for x in piece.u)
    u = np.linspace(lo, hi, SAMPLES)
    if piece.u is None:
        u = np.concatenate([u, 1 / u[u != 0]])
    p, q = piece.first.points(u), piece.second.points(u)
    near, far = np.linalg.norm(q - p, axis=1).min(), np.linalg.norm(p - np.array(centre), axis=1).max()
    if not (near > 0.0 and math.isfinite(far)):
        return None
    for share in SHARES:
        least, most = exact_value(float(near * share)), exact_value(float((far + near) / share))
        if all(_keeps(*chart, c, least, most) for chart in _charts(piece)):
            return (reach + most) / least
    return None


def _charts(piece: RuledSurface) -> Iterator[tuple[Any, Any, tuple[fmpq, fmpq]]]:
    first, second = piece.first, piece.second
    if piece.u is not None:
        yield first, second, (rational(piece.u[0], "u"), rational(piece.u[1], "u"))
        return
    yield first, second, UNIT
    yield first.reversed(), second.reversed(), UNIT


def _keeps(first: Any, second: Any, ends: tuple[fmpq, fmpq], c: Sequence[fmpq], least: fmpq, most: fmpq) -> bool:
    """Whether the first curve is proved within `most` of c, and the second farther than `least` from the first."""
    *p, w = first.components
    *q, v = second.components
    scale = least.q * most.q
    for x in c:
        scale = scale * x.q
    offset = [scale * a - w * (scale * x).p for a, x in zip(p, c, strict=True)]
    within = w * w * ((scale * most).p ** 2) - sum((a * a for a in offset), fmpz_poly([0]))
    gap = sum(((b * w - a * v) * (b * w - a * v) for a, b in zip(p, q, strict=True)), fmpz_poly([0]))
    apart = gap * least.q**2 - w * w * v * v * least.p**2
    return all(_is_positive(f, ends) for f in (w * w, v * v, within, apart))


def _is_positive(f: fmpz_poly, ends: tuple[fmpq, fmpq]) -> bool:
    return f(ends[0]) > 0 and not roots_in(f, ends)
