"""Square systems of short motions, and boxes of what two models may share: against points that are known or drawn."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import arb, fmpq, fmpz_poly

import firstcontact as fc
from firstcontact.body.solid.csg import Leaf
from firstcontact.contact.models.common_box import box_of, common_box
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.system_search import SearchedSolid, zeros_within
from firstcontact.exact.numbers import exact_value, precision
from firstcontact.exact.systems.square_systems import EnclosedRoot, SquareSystem
from firstcontact.motion.relative.polynomial import relative_pieces


def pair_of(a, b, first, last):
    (piece,) = relative_pieces(a, b, first, last)
    return MovingPair(*(getattr(x, "body", x) for x in (a, b)), piece)


def form(rows):
    """A symmetric matrix of polynomials in u, from rows of coefficients or of lists of these."""
    return tuple(tuple(fmpz_poly(x if isinstance(x, list) else [x]) for x in row) for row in rows)


P, U = (fmpq(1, 3), fmpq(2, 3), fmpq(2, 3)), fmpq(7, 10)
"""A point of the three surfaces below, and when the fourth one passes through it."""
SYSTEM = SquareSystem([
    form([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]]),
    form([[9, 0, 0, 0], [0, 9, 0, 0], [0, 0, 0, 0], [0, 0, 0, -5]]),
    form([[0, 0, 0, 3], [0, 0, 0, 3], [0, 0, 0, 0], [3, 3, 0, -6]]),
    form([[0, 0, 0, [2, 1]], [0, 0, 0, 0], [0, 0, 0, 3], [[2, 1], 0, 3, [-3, -4]]]),
])  # fmt: skip


GRAZE = SquareSystem([
    form([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]]),
    form([[0, 0, 0, 2], [0, 0, 0, 1], [0, 0, 0, -2], [2, 1, -2, 0]]),
    form([[0, 0, 0, 150], [0, 0, 0, 210], [0, 0, 0, 120], [150, 210, 120, [-498, -60]]]),
])  # fmt: skip
"""A plane that touches the circle of the two other surfaces in the same point at the same time."""


@pytest.mark.parametrize("system", [SYSTEM, GRAZE], ids=["crossing", "graze"])
@pytest.mark.parametrize("short", [fmpq(1), fmpq(1, 10**6), fmpq(1, 10**9), fmpq(1, 10**13), fmpq(1, 10**16)])
def test_a_zero_is_isolated_however_short_the_motion_is(short, system):
    """Of 1e-13 of the span it took 700,000 boxes, none of which told the time; a graze stayed open."""
    x = [*P, fmpq(1)]
    for some in system.forms:
        assert sum(some[i][j](U) * x[i] * x[j] for i in range(4) for j in range(4)) == 0
    anywhere = [SearchedSolid(Leaf(0), [SYSTEM.forms[0]], frozenset({0}))]
    cube = (fmpq(-2),) * 3, (fmpq(2),) * 3
    found = zeros_within(system, anywhere, cube, (U - short * fmpq(3, 11), U + short * fmpq(1, 2)), 1)
    near = [z for z in found.zeros if abs(float(EnclosedRoot(z)) - float(U)) < 1e-12]
    assert len(near) == 1 and not found.open and found.boxes < 5000
    with precision(128):
        assert all(abs(ball - c) < arb("1e-20") for ball, c in zip(near[0].balls(128), (*P, U), strict=True))


@pytest.mark.parametrize("seed", range(4))
def test_what_models_share_is_in_their_common_box(seed):
    r = np.random.default_rng(seed)
    wide = fc.paraboloid(1, F(1, 50)).rotated((1, 2, 2), degrees=90)
    small = fc.sphere(F(1, 2)).translated([F(int(x), 20) for x in r.integers(-12, 12, 3)])
    turn, slide = fc.Rotation((2, 1, 2), (0, F(1, 3), 0), degrees=90), fc.Translation((F(1, 4), 0, F(-1, 3)))
    motion = turn if seed % 2 else slide
    a, b = (wide.moving(motion), small) if seed < 2 else (small.moving(motion), wide)
    pair = pair_of(a, b, fmpq(1, 8), fmpq(1, 4))
    in_b, in_a = common_box(pair, False), common_box(pair, True)
    lo, hi = (np.array([float(x) for x in c]) for c in box_of(pair.a))
    least, most = (np.array([float(x) for x in c]) for c in box_of(pair.b))
    shared = 0
    for u in np.linspace(float(pair.piece.u_lo), float(pair.piece.u_hi), 9):
        pose = np.array([[float(p(exact_value(u))) for p in row] for row in pair.piece.pose])
        x = r.uniform(lo, hi, (4000, 3))
        y = x @ pose[:3, :3].T + pose[:3, 3]
        y /= pose[3, 3]
        both = np.all((least <= y) & (y <= most), axis=1)
        shared += int(both.sum())
        for points, box in ((x[both], in_a), (y[both], in_b)):
            first, last = (np.array([float(c) for c in corner]) for corner in box)
            assert np.all(points >= first - 1e-12) and np.all(points <= last + 1e-12)
    assert shared


def test_a_corner_lands_on_a_cut_bowl_far_smaller_than_its_equation():
    """Both are some 1e-9 in size, features of the bowl's equation are 3e-5: it took more than 80 s."""
    corners = [
        (-1902, 93, 642), (-1966, -707, 322), (-1874, -367, 620), (-1994, -247, 344), (-1134, -243, 162),
        (-2734, -371, 802),
    ]  # fmt: skip
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    body = fc.Polyhedron([[F(x, 27 * 2**34) for x in p] for p in corners], faces)
    tilt = [[F(-47932, 82017), F(46816, 82017), F(47303, 82017), F(-109726847, 50725487911108608)],
            [F(915743, 1394289), F(1045924, 1394289), F(-6308, 82017), F(-6778573, 12681371977777152)],
            [F(-664444, 1394289), F(465481, 1394289), F(-66704, 82017), F(-1046257, 3170342994444288)],
            [0, 0, 0, 1]]  # fmt: skip
    bowl = fc.paraboloid(2.0**-15, 11 * 2.0**-34).transformed(tilt)
    drill = fc.sphere(5 * 2.0**-34).translated((-31 * 2.0**-34, -6 * 2.0**-34, -6 * 2.0**-34))
    hit = fc.first_contact(body.moving(fc.Translation((2.0**-31, 2.0**-32, -(2.0**-30)))), bowl - drill)
    assert hit.status is fc.Status.CONTACT
    assert hit.time == 0.75
    assert (hit.element_a.kind, hit.element_a.index) == ("vertex", 4)
    assert hit.multiplicity == 6  # the corner with the two faces beside the rim, its four edges with the rim
    seen = {x.way: x.seconds for x in hit.stats.ways}
    assert "exactly" not in seen  # what doubles proved is enough
