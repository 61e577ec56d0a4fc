"""Two models over one piece of their relative motion: all carriers in the frame of b, as polynomials in u."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, fmpq, fmpz_poly

from firstcontact.body.solid.carriers import AlgebraicPoint, Conic, Line, Plane, Point, Quadric, Rows
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, congruent, constant, product
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.polynomial import PolynomialPiece

Form = tuple[Any, ...]
"""A plane as its 4-vector, a quadric as its symmetric 4x4 matrix."""


def is_plane(form: Form) -> bool:
    return not isinstance(form[0], list | tuple)


def form_at(form: Form, u: arb) -> Any:
    """The form at an enclosure of u."""
    return [c(u) for c in form] if is_plane(form) else [[c(u) for c in row] for row in form]


@dataclass(frozen=True)
class MovingPair:
    """Model a moves by piece.pose as seen from model b, which rests."""

    a: CompositeQuadric
    b: CompositeQuadric
    piece: PolynomialPiece

    @cached_property
    def forms_a(self) -> list[Form]:
        """The surfaces of a in the frame of b, negative inside."""
        inverse = projective.inverse(self.piece.pose, self.piece.u_lo)
        return [_moved_form(surface, inverse) for surface in self.a.surfaces]

    @cached_property
    def forms_b(self) -> list[Form]:
        return [_form(surface) for surface in self.b.surfaces]

    @cached_property
    def unit(self) -> float:
        """A power of two: the length in which doubles look at points of the frame of b, whatever the size of models."""
        for body in (self.b, self.a):
            reach = max(float(np.abs(corner).max()) for corner in body.bounds())
            if 0.0 < reach < math.inf:
                return math.ldexp(1.0, math.frexp(reach)[1])
        return 1.0

    def basis(self, carrier: Line | Conic | Point | AlgebraicPoint, moving: bool) -> Matrix:
        """The parameter matrix of a curve or point in the frame of b; an algebraic point's are the powers of its s."""
        basis = constant(_powers(carrier) if isinstance(carrier, AlgebraicPoint) else carrier.basis)
        return without_factor(product(self.piece.pose, basis), self.piece.u_lo) if moving else basis


def _powers(point: AlgebraicPoint) -> Rows:
    """4xn: the point is this times (1, s, ..., s^(n-1))."""
    n = max(len(row) for row in point.coordinates)
    rows = (*point.coordinates, (fmpq(1),))
    return tuple((*row, *(fmpq(0),) * (n - len(row))) for row in rows)


def _form(surface: Plane | Quadric) -> Form:
    if isinstance(surface, Plane):
        return constant([surface.normal])[0]
    return constant(surface.form)


def _moved_form(surface: Plane | Quadric, inverse: Matrix) -> Form:
    """N^T M^-1 or M^-T Q M^-1 up to a positive factor, for the given positive multiple of M^-1."""
    form = _form(surface)
    if isinstance(surface, Plane):
        return product((form,), inverse)[0]
    return congruent(inverse, form)


def without_factor(m: Matrix, u: fmpq) -> Matrix:
    """m over the common factor of its entries, with its sign at u."""
    common = fmpz_poly([0])
    for row in m:
        for x in row:
            common = common.gcd(x)
            if common.is_one():
                return m
    if common.is_zero():
        return m
    if common(u) < 0:
        common = -common
    return tuple(tuple(x // common for x in row) for row in m)
