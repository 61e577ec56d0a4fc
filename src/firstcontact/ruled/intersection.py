"""`intersection_curve` by the exact path: from two pieces at rest to branches, overlaps, points and their graph."""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np
from flint import fmpq, fmpz_mpoly

from firstcontact.exact.bivariate import in_u, in_v
from firstcontact.pairs.ruled_ruled import FactorKind, common_rulings, delta, factors
from firstcontact.ruled.answer import Found, Pair
from firstcontact.ruled.branches import add_apex, add_curves
from firstcontact.ruled.clipping import clipped, in_range, overlap
from firstcontact.ruled.coincident import all_meet, along_correspondence
from firstcontact.ruled.common_lines import shared
from firstcontact.ruled.pieces import Piece
from firstcontact.ruled.spots import Box


def intersection(
    p: Piece, q: Piece, tolerance: float, box: Box | None, inside: bool = False
) -> dict[str, Any]:
    """The fields of IntersectionCurve; inside: common rulings outside the pieces are not looked for."""
    ranges = (p.u, q.u) if inside else (None, None)
    whole, in_given = delta(p.rulings, q.rulings), common_rulings(p.rulings, q.rulings, *ranges)
    found = Found(p, q, tolerance, box)
    common, d = in_given, whole
    if not whole.is_zero() and (moved := _away_from_infinity(found)) is not found:
        found = moved
        a, b = found.p.rulings, found.q.rulings
        common, d = common_rulings(a, b, *((found.p.u, found.q.u) if inside else ranges)), delta(a, b)
    if d.is_zero():
        all_meet(found)
    else:
        _curves(found, d, common.correspondence)
    if not common.correspondence.is_constant():
        along_correspondence(found, common.correspondence)
    for u, v in common.pairs:
        _overlap(found, u, v)
    return found.fields(whole, in_given)


def _away_from_infinity(found: Found) -> Found:
    """The same pieces in parameters in which infinity is nothing special: no bound holds on all of that ruling."""
    for side in (0, 1):
        for shift in count():
            if not found.clip.special_at_infinity(found.pieces[side].u, side):
                break
            moved = list(found.pieces)
            moved[side] = found.given[side].away_from_infinity(shift)
            found = Found(moved[0], moved[1], found.tolerance, found.box, found.given)
    return found


def _curves(found: Found, d: fmpz_mpoly, correspondence: fmpz_mpoly) -> None:
    """Branches and isolated points: the factors of Delta that are curves, special rulings, and apexes."""
    curves, special = factors(found.p.rulings, found.q.rulings, d, found.clip.points, correspondence)
    wanted = [(f.polynomial, f.multiplicity) for f in curves if f.kind is FactorKind.CURVE]
    apexes = []
    for s in special:
        if s.parameter is None or not in_range((found.p, found.q)[s.side], s.parameter):
            continue
        line = (in_u, in_v)[s.side](s.parameter.polynomial)
        if s.kind is FactorKind.RULING:
            wanted += [(line, s.multiplicity)] if all(line != f for f, _ in wanted) else []
        elif s.kind is FactorKind.POINT:
            assert s.point is not None
            apexes.append((line, np.array([float(fmpq(x, s.point[3])) for x in s.point[:3]]), s.side, s.parameter))
    if wanted:
        add_curves(found, wanted)
    for apex in apexes:
        add_apex(found, *apex)


def _overlap(found: Found, u: Any, v: Any) -> None:
    """What the pieces share of a common ruling: segments, points, or the line."""
    p, q = found.p, found.q
    if p.trim or q.trim:
        for part in shared(p, q, found.box, u, v):
            found.add_common(part, Pair(u, v))
        return
    segment = overlap(p, q, u, v)
    if segment is not None and found.box is not None:
        low, high = (np.array([float(x) for x in corner]) for corner in found.box)
        segment = clipped(segment, low, high, whole=not (p.bounded or q.bounded))
    if segment is not None:
        found.add_common(segment, Pair(u, v))
