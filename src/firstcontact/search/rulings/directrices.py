"""Two ruled surfaces over the pieces of their relative motion: directrices as polynomials in u and its parameter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.body.ruled.rational_curve import RING, RationalCurve, lifted
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import rational
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.clocks import StraightClock
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.motion.relative.projective import IDENTITY, Matrix

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Sides = tuple[RationalCurve, RationalCurve]


@dataclass(frozen=True, slots=True)
class DirectrixPiece:
    """Both surfaces in the frame of q over one piece of their relative motion.

    motion  from `motion.start` to `motion.end`; its parameter runs from u_lo to u_hi, and `motion.clock` and
            `motion.contains` tell the times.  `motion.frame` carries points to the world.
    p, q    the sides of the two surfaces (`RuledSurface.sides`).  T in their components stands for the parameter of
            the motion: the time, or under constant-speed rotations a multiple of the tangent of half the angle.
            Weights are positive where no pole lies; those of bounded surfaces that do not deform have none.
    """

    motion: PolynomialPiece
    p: Sides
    q: Sides


def directrix_pieces(a: Body, b: Body, first: fmpq, last: fmpq | None) -> Iterator[DirectrixPiece]:
    """The pieces of two ruled surfaces, at rest or moving, over the closed [first, last], in time order.

    Both must be of one piece each (`RuledSurface.pieces`).  UnsupportedPair where the relative motion is no rational
    function of one parameter, or a surface deforms while the parameter is not the time.
    """
    p, q = (_shape(body) for body in (a, b))
    for motion in relative_pieces(a, b, first, last):
        for surface in (p, q):
            _check_clock(surface, motion)
        yield DirectrixPiece(motion, sides_from(p, motion), signed(q.sides, q, _middle(motion)))


def sides_from(surface: RuledSurface, motion: PolynomialPiece) -> Sides:
    """The sides of a surface as seen from the body whose frame the motion is in."""
    _check_clock(surface, motion)
    moved = surface.sides
    if motion.pose != IDENTITY:
        moved = _moved(moved[0], motion.pose), _moved(moved[1], motion.pose)
    return signed(moved, surface, _middle(motion))


def _check_clock(surface: RuledSurface, motion: PolynomialPiece) -> None:
    if surface.deforming and not isinstance(motion.clock, StraightClock):
        raise UnsupportedPair(
            f"{motion.of}: {surface.name or 'a ruled surface'} deforms with the time, which is no rational "
            "function of the turn; give a RationalMotion, or let one body deform and the other rest"
        )


def _middle(motion: PolynomialPiece) -> fmpq:
    return motion.u_lo if motion.u_hi is None else (motion.u_lo + motion.u_hi) / 2


def _shape(body: Body) -> RuledSurface:
    shape = shape_of(body)
    if not isinstance(shape, RuledSurface):
        raise TypeError(f"{shape!r} is no ruled surface")
    return shape


def signed(sides: Sides, surface: RuledSurface, t: fmpq) -> Sides:
    """The sides with weights that are positive at the time, in the middle of the range."""
    u = fmpq(0) if surface.u is None else rational(sum(surface.u) / 2, "u")
    return sides[0].positive_at(u, t), sides[1].positive_at(u, t)


def _moved(curve: RationalCurve, pose: Matrix) -> RationalCurve:
    """The curve in a pose whose entries are polynomials in T."""
    x = lifted(curve.components)
    rows = [[_in_time(entry) for entry in row] for row in pose]
    return RationalCurve.of([sum((m * c for m, c in zip(row, x, strict=True)), RING.constant(0)) for row in rows])


def _in_time(p: fmpz_poly) -> fmpz_mpoly:
    return RING.from_dict({(0, j): c for j, c in enumerate(p.coeffs()) if c})
