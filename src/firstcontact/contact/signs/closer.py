"""A closer look at boxes that may hold contacts at one instant, where doubles over all ranges tell no more.

Each group of boxes that touch gets nets of its own: Bernstein coefficients on its hull, in balls, then as doubles in
parts of the largest of them.  Doubles so tell what is 2^-38 of a polynomial's size there, not of its size in all of
the ranges, and again where a group shrinks.  Nearly all instants are told free at which pieces pass each other by a
hair, as beside an apex that both share; elimination in fields of high degree is left to contacts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb, arb_mat, fmpz_mpoly

from firstcontact.contact.signs.conditions import SignConditions
from firstcontact.contact.signs.exclusion import (
    ParameterBox,
    boxes_of,
    clusters,
    search,
    to_bernstein_exactly,
)
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision, to_double
from firstcontact.exact.polynomials.trivariate import degree, terms

BITS, TOLD = 512, 2**60
"""Of balls, and to which part of the largest one they must tell the coefficients of a polynomial lest it count as
zero, which excludes nothing.  The margin of all nets holds that and the roundings of DEPTH halvings."""
TURNS, SHRUNK = 3, 1 / 64
"""Looks at most, and the part of the area to which groups must shrink for another one."""
WORTH = 3
"""Degree of an instant from which a look, which takes 5 to 20 ms, is less than elimination in its field."""
VISITS, DEPTH = 600, 45


def closer(c: SignConditions, t: AlgebraicRoot, boxes: Sequence[ParameterBox]) -> list[ParameterBox]:
    """The parts of the boxes that may hold contacts at the instant t, or all; none proves that there is none."""
    if t.polynomial.degree() < WORTH:
        return list(boxes)
    for _ in range(TURNS):
        before = _area(boxes)
        boxes = [
            part
            for inverse, chart in c.charts.items()
            if (own := [box for box in boxes if box.inverse == inverse])
            for u, v in clusters(own)
            for part in _parts(chart, t, ParameterBox(inverse, u, v, own[0].t))
        ]
        if not 0 < _area(boxes) < SHRUNK * before:
            break
    return list(boxes)


def _area(boxes: Sequence[ParameterBox]) -> float:
    return float(sum((to_double((box.u[1] - box.u[0]) * (box.v[1] - box.v[0])) for box in boxes), 0.0))


def _parts(c: SignConditions, t: AlgebraicRoot, group: ParameterBox) -> list[ParameterBox]:
    """Those of one group, in its chart."""
    now = t.enclosure(BITS)
    m, n = (max(degree(f, k) for f in c.polynomials) for k in (0, 1))
    with precision(BITS):
        of_u, of_v = arb_mat(to_bernstein_exactly(m, *group.u)), arb_mat(to_bernstein_exactly(n, *group.v)).transpose()
        nets = [_scaled(of_u * _powers(f, m, n, now) * of_v) for f in c.polynomials]
    index, halved = search(np.array(nets)[None, ..., None], c.excludes, VISITS, DEPTH)
    return boxes_of(index, halved, [group.inverse], (group.u, group.v, group.t))


def _powers(f: fmpz_mpoly, m: int, n: int, t: arb) -> arb_mat:
    """(m + 1, n + 1) coefficients of u^i v^j at the time t."""
    found = [[arb(0)] * (n + 1) for _ in range(m + 1)]
    for (i, j, k), x in terms(f):
        found[i][j] += x * t**k
    return arb_mat(found)


def _scaled(net: arb_mat) -> np.ndarray:
    """In parts of the largest one; zeros where balls do not tell them."""
    entries = net.entries()
    largest = max(abs(x.mid()) for x in entries)
    if any(x.rad() * TOLD > largest for x in entries) or largest == 0:
        return np.zeros((net.nrows(), net.ncols()))
    return np.array([float((x / largest).mid()) for x in entries]).reshape(net.nrows(), net.ncols())
