"""A box, in the frame of one model of a pair, of all points that the two may share during the piece of motion."""

from __future__ import annotations

import numpy as np
from flint import arb, fmpq, fmpq_poly, fmpz_poly

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.exact.numbers import dyadic, exact_value, precision
from firstcontact.exact.polynomials.polynomial_matrix import Matrix
from firstcontact.motion.relative import projective

Box = tuple[tuple[fmpq, ...], tuple[fmpq, ...]]
"""Its least and its greatest corner."""
BITS = 128


def common_box(pair: MovingPair, of_a: bool) -> Box | None:
    """In the frame of a, or of b; None where no bound of that model is known.

    That is the model's own box, cut with one of all places that the other one's box takes as seen from it: features of
    a thin and wide model are searched near a small one alone.
    """
    own, other = (pair.a, pair.b) if of_a else (pair.b, pair.a)
    box, seen = box_of(own), box_of(other)
    piece = pair.piece
    if box is None or seen is None or piece.u_hi is None:
        return box
    there = projective.inverse(piece.pose, piece.u_lo) if of_a else piece.pose
    with precision(BITS):
        swept = _image(there, seen, piece.u_lo, piece.u_hi)
    if swept is None:
        return box
    lo = tuple(max(x, y) for x, y in zip(box[0], swept[0], strict=True))
    hi = tuple(min(x, y) for x, y in zip(box[1], swept[1], strict=True))
    return (lo, hi) if all(x < y for x, y in zip(lo, hi, strict=True)) else box


def box_of(body: CompositeQuadric) -> Box | None:
    """A box that holds the body, with a little room; None where no bound is known."""
    lo, hi = body.bounds()
    if not np.all(np.isfinite([lo, hi])):
        return None
    room = 1e-6 * float(np.max(hi - lo))
    return tuple(exact_value(x - room) for x in lo), tuple(exact_value(x + room) for x in hi)


def _image(m: Matrix, box: Box, u_lo: fmpq, u_hi: fmpq) -> Box | None:
    """A box of the images of a box under a map for all u of an interval; None where balls bound none."""
    u = arb(u_lo).union(arb(u_hi))
    x = [arb(lo).union(arb(hi)) for lo, hi in zip(*box, strict=True)]
    rows = [[_over(p, u) for p in row] for row in m]
    images = [sum((c * y for c, y in zip(row, x, strict=False)), row[3]) for row in rows]
    if images[3].contains(0):
        return None
    points = [image / images[3] for image in images[:3]]
    if not all(p.is_finite() for p in points):
        return None
    return tuple(dyadic(p.lower()) for p in points), tuple(dyadic(p.upper()) for p in points)


def _over(p: fmpz_poly, u: arb) -> arb:
    """The values of a polynomial over a ball, by its Taylor series about the middle: short ones lose little."""
    middle = dyadic(u.mid())
    offset = u - arb(middle)
    around = fmpq_poly(p)(fmpq_poly([middle, 1]))
    value = arb(0)
    for c in reversed(around.coeffs()):
        value = value * offset + arb(c)
    return value
