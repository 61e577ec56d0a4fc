"""Surfaces of revolution.

A surface is the same after every turn about a line if its form does not change at first order: K^T Q + Q K = 0 for the
generator K of the turns.
"""

from __future__ import annotations

from flint import fmpq, fmpq_mat

from firstcontact.body.solid.carriers import Plane, Surface
from firstcontact.exact.vectors import cross


def is_same(surface: Surface, axis: tuple[fmpq, ...], point: tuple[fmpq, ...]) -> bool:
    """Whether the surface is one of revolution about the line."""
    if isinstance(surface, Plane):
        return not any(cross(surface.normal[:3], axis))
    x, y, z = axis
    nil = fmpq(0)
    p, q, r = cross(point, axis)
    generator = fmpq_mat([[nil, -z, y, p], [z, nil, -x, q], [-y, x, nil, r], [nil] * 4])
    form = fmpq_mat([list(row) for row in surface.form])
    change = generator.transpose() * form + form * generator
    return not any(change.entries())
