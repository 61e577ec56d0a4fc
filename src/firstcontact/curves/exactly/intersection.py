"""`intersection_curve` by the exact path: from two pieces at rest to branches, overlaps, points and their graph."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpz_mpoly

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.exactly.answer import FoundCurve, RulingPair
from firstcontact.curves.exactly.branches import add_apex, add_curves
from firstcontact.curves.exactly.clipping import in_range
from firstcontact.curves.exactly.coincident import all_meet
from firstcontact.curves.exactly.shared_families import along_correspondence, special_at_infinity
from firstcontact.curves.exactly.shared_rulings import add_shared
from firstcontact.curves.exactly.spots import Box
from firstcontact.exact.polynomials.bivariate import in_u, in_v
from firstcontact.pairs.ruled_ruled import FactorKind, common_rulings, delta, factors

if TYPE_CHECKING:
    from firstcontact.curves.fields import CurveFields


def intersection(
    p: RulingPiece, q: RulingPiece, tolerance: float, box: Box | None, inside: bool = False
) -> CurveFields:
    """The fields of IntersectionCurve; inside: common rulings outside the pieces are not looked for."""
    ranges = (p.u, q.u) if inside else (None, None)
    whole, in_given = delta(p.rulings, q.rulings), common_rulings(p.rulings, q.rulings, *ranges)
    found = FoundCurve(p, q, tolerance, box)
    common, d = in_given, whole
    if (moved := _away_from_infinity(found, not common.correspondence.is_constant())) is not found:
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
        add_shared(found, RulingPair(u, v))
    return found.fields(whole, in_given)


def _away_from_infinity(found: FoundCurve, family: bool) -> FoundCurve:
    """The same pieces in parameters in which infinity is nothing special: no bound holds on all of that ruling.

    family: there is a curve of common rulings.
    """
    for side in (0, 1):
        for shift in count():
            if not (
                found.clip.special_at_infinity(found.pieces[side].u, side)
                or (family and special_at_infinity(found.p, found.q, found.box, side))
            ):
                break
            moved = list(found.pieces)
            moved[side] = found.given[side].away_from_infinity(shift)
            found = FoundCurve(moved[0], moved[1], found.tolerance, found.box, found.given)
    return found


def _curves(found: FoundCurve, d: fmpz_mpoly, correspondence: fmpz_mpoly) -> None:
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
