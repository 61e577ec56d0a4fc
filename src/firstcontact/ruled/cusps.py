"""Where an intersection curve may turn back: it stands still only at singular points of one of the surfaces.

Moving along the curve, dI = P_u du + P_s ds = Q_v dv + Q_t dt.  Where it vanishes with du != 0, P_u and P_s are
parallel there.  A ruling l has such a point only if <l', l'> = 0 (it is torsal), and then only one, where l meets l',
or l' is parallel to l and the family stands still.  So the candidates are zeros of polynomials in one parameter, for
developables the points of the edge of regression (re-derived; the common zeros of the derivatives of I, which give the
same points, have three times the degree).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

from flint import fmpz_mpoly, fmpz_poly

from firstcontact.exact import bivariate
from firstcontact.exact.bivariate import CONTEXT, in_u, in_v
from firstcontact.exact.inertia import dot
from firstcontact.pairs.ruled_ruled import Rulings, planes_through, points_on

# Weights that make one point, one equation of four; any will do: a bad choice only adds candidates.
_ONE_POINT = (1, 3, -2, 5)
_EQUATIONS = ((2, -7, 3, 11), (5, 1, -4, 9), (-3, 8, 13, 1))
# Product of the degrees up to which it pays to find out whether a singular point is on the curve at all.
ELIMINATED = 12


def candidates(p: Rulings, q: Rulings, factors: Sequence[fmpz_mpoly]) -> list[fmpz_mpoly]:
    """Polynomials whose common zeros with the factors hold all points where a curve stands still."""
    still = _proper([in_u(stationary_rulings(p)), in_v(stationary_rulings(q))])
    return still + _of_side(p, q, factors, "u", in_u, in_v) + _of_side(q, p, factors, "v", in_v, in_u)


def _of_side(
    own: Rulings, other: Rulings, factors: Sequence[fmpz_mpoly], name: str, here: Any, there: Any
) -> list[fmpz_mpoly]:
    planes = planes_through([there(x) for x in other.line])
    if own.apex is not None:
        through = [dot(row, [CONTEXT.constant(x) for x in own.apex]) for row in planes]
        return _proper([reduce(lambda x, y: x.gcd(y), through)])
    torsal = torsal_rulings(own)
    if torsal.degree() == 0:
        return []
    if torsal != 0 and own.degree * other.degree > ELIMINATED:
        return [here(torsal)]
    point = [here(x) for x in singular_points(own)]
    equations = [dot(weights, [dot(row, point) for row in planes]) for weights in _EQUATIONS]
    eliminated = "v" if name == "u" else "u"
    if torsal == 0:
        return _proper([here(_shared(f, equations, eliminated)) for f in factors])
    between = bivariate.resultant(equations[0], equations[1], eliminated)
    between = between.gcd(bivariate.resultant(equations[0], equations[2], eliminated))
    return _proper([here(torsal.gcd(between))])


def _shared(f: fmpz_mpoly, equations: Sequence[fmpz_mpoly], eliminated: str) -> fmpz_poly:
    total = fmpz_poly([0])
    for e in equations:
        total = total.gcd(bivariate.resultant(f, e, eliminated))
    return total


def _proper(found: list[fmpz_mpoly]) -> list[fmpz_mpoly]:
    return [x for x in found if not x.is_constant()]


def stationary_rulings(lines: Rulings) -> fmpz_poly:
    """Its zeros are the rulings at which l stands still: the family turns back there, or has a cusp."""
    x, slopes = lines.line, [c.derivative() for c in lines.line]
    minors = (x[i] * slopes[j] - x[j] * slopes[i] for i in range(6) for j in range(i))
    return reduce(fmpz_poly.gcd, minors, fmpz_poly([0]))


def special_at_infinity(lines: Rulings) -> bool:
    """Whether infinity is a zero of one of these polynomials."""
    at_infinity = lines.reversed()
    torsal = torsal_rulings(at_infinity)
    return stationary_rulings(at_infinity)[0] == 0 or (torsal != 0 and torsal[0] == 0)


def torsal_rulings(lines: Rulings) -> fmpz_poly:
    """<l', l'>: its zeros are the rulings along which neighbours meet; 0 for developables."""
    a, b, c, d, e, f = (x.derivative() for x in lines.line)
    return a * f - b * e + c * d


def singular_points(lines: Rulings) -> list[fmpz_poly]:
    """The point in which a torsal ruling meets its neighbour, a primitive polynomial vector."""
    planes = planes_through([x.derivative() for x in lines.line])
    plane = [dot(row, [fmpz_poly([w]) for w in _ONE_POINT]) for row in planes]
    point = [dot(row, plane) for row in points_on(lines.line)]
    common = reduce(fmpz_poly.gcd, point, fmpz_poly([0]))
    return point if common == 0 else [x // common for x in point]
