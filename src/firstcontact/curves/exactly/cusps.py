"""Where an intersection curve may turn back: it stands still only at singular points of one of the surfaces.

Moving along the curve, dI = P_u du + P_s ds = Q_v dv + Q_t dt.  Where it vanishes with du != 0, P_u and P_s are
parallel there.  A ruling l has such a point only if <l', l'> = 0 (it is torsal), and then only one, where l meets l',
or l' is parallel to l and the family stands still.  So the candidates are zeros of polynomials in one parameter, for
developables the points of the edge of regression (re-derived; the common zeros of the derivatives of I, which give the
same points, have three times the degree).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce

from flint import fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.exact.polynomials import bivariate
from firstcontact.exact.polynomials.bivariate import in_u, in_v
from firstcontact.exact.polynomials.inertia import dot
from firstcontact.pairs.ruled_ruled import Rulings, planes_through, points_on, rulings_through

# Weights that make one point, one equation of four; any will do that do not give zero: a bad choice only adds
# candidates.  Of points, all four are in no plane.
_POINTS = ((1, 3, -2, 5), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))
_EQUATIONS = ((2, -7, 3, 11), (5, 1, -4, 9), (-3, 8, 13, 1))
# Product of the degrees up to which it pays to find out whether a singular point is on the curve at all.
ELIMINATED = 12


def candidates(p: Rulings, q: Rulings, factors: Sequence[fmpz_mpoly]) -> list[fmpz_mpoly]:
    """Polynomials whose common zeros with the factors hold all points where a curve stands still."""
    still = _proper([in_u(stationary_rulings(p)), in_v(stationary_rulings(q))])
    return still + _of_side(p, q, factors, "u", in_u, in_v) + _of_side(q, p, factors, "v", in_v, in_u)


def _of_side(
    own: Rulings,
    other: Rulings,
    factors: Sequence[fmpz_mpoly],
    name: str,
    here: Callable[[fmpz_poly], fmpz_mpoly],
    there: Callable[[fmpz_poly], fmpz_mpoly],
) -> list[fmpz_mpoly]:
    if own.apex is not None:
        return _proper([there(rulings_through(other, own.apex))])
    torsal = torsal_rulings(own)
    if torsal.degree() == 0:
        return []
    if torsal != 0 and own.degree * other.degree > ELIMINATED:
        return [here(torsal)]
    equations = _equations(own, other, here, there)
    eliminated = "v" if name == "u" else "u"
    if torsal == 0:
        return _proper([here(_shared(f, equations, eliminated)) for f in factors])
    return _proper([here(torsal.gcd(_through(equations, eliminated)))])


def _equations(
    own: Rulings, other: Rulings, here: Callable[[fmpz_poly], fmpz_mpoly], there: Callable[[fmpz_poly], fmpz_mpoly]
) -> list[fmpz_mpoly]:
    """Three that hold where a ruling of the other surface holds the singular point of one of this."""
    point = [here(x) for x in singular_points(own)]
    planes = planes_through([there(x) for x in other.line])
    return [dot(weights, [dot(row, point) for row in planes]) for weights in _EQUATIONS]


def _through(equations: Sequence[fmpz_mpoly], eliminated: str) -> fmpz_poly:
    """Its zeros hold all parameters at which three equations hold for one value of the other parameter."""
    first, second, third = equations
    return bivariate.resultant(first, second, eliminated).gcd(bivariate.resultant(first, third, eliminated))


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


def special_at_infinity(lines: Rulings, other: Rulings) -> bool:
    """Whether infinity may be a zero of one of the candidates' polynomials in the parameter of `lines`."""
    at_infinity = lines.reversed()
    if stationary_rulings(at_infinity)[0] == 0:
        return True
    torsal = torsal_rulings(at_infinity)
    if torsal != 0:
        return bool(torsal[0] == 0)
    if lines.apex is not None or not _is_on(other, [x[0] for x in singular_points(at_infinity)]):
        return False
    return bool(_through(_equations(lines, other, in_u, in_v), "v") != 0)  # else the whole edge is on the other surface


def _is_on(lines: Rulings, point: Sequence[fmpz]) -> bool:
    """Whether a ruling holds the point; one of complex parameter counts too."""
    return any(rulings_through(x, point).degree() != 0 for x in (lines, lines.reversed()))


def torsal_rulings(lines: Rulings) -> fmpz_poly:
    """<l', l'>: its zeros are the rulings along which neighbours meet; 0 for developables."""
    a, b, c, d, e, f = (x.derivative() for x in lines.line)
    return a * f - b * e + c * d


def singular_points(lines: Rulings) -> list[fmpz_poly]:
    """The point in which a torsal ruling meets its neighbour, a primitive polynomial vector."""
    planes = planes_through([x.derivative() for x in lines.line])
    for weights in _POINTS:
        plane = [dot(row, [fmpz_poly([w]) for w in weights]) for row in planes]
        point = [dot(row, plane) for row in points_on(lines.line)]
        common = reduce(fmpz_poly.gcd, point, fmpz_poly([0]))
        if common != 0:  # the plane does not hold the ruling
            return [x // common for x in point]
    raise ArithmeticError("four points that are in no plane, in one plane")
