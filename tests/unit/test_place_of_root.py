"""Signs of forms at points: those of exact arithmetic, however close a point is to a surface."""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.shared.membership import PlaceOfRoot
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.motion.relative.polynomial import relative_pieces

SIZES = [fmpq(1), fmpq(2) ** 80, fmpq(1, 2**80)]


def exactly(surface, x):
    """The sign of a surface's matrix at a homogeneous point: w N.X of a plane, times w, and X^T Q X."""
    form = surface.matrix()
    value = sum(x[i] * form[i][j] * x[j] for i in range(4) for j in range(4))
    return (value > 0) - (value < 0)


@pytest.mark.parametrize("size", SIZES, ids=["1", "large", "small"])
def test_signs_are_true(size):
    rng, seen = np.random.default_rng(28), set()
    number = float(int(size.p)) / float(int(size.q))
    solid = (fc.box((2, 3, 4)) | fc.cylinder(1, 5) | fc.sphere(2)) - fc.frustum(1, "1/2", 2)
    solid = solid.transformed(np.diag([number, number, number, 1.0]))
    (piece,) = relative_pieces(solid, solid, fmpq(0), fmpq(1))
    pair, root = MovingPair(solid, solid, piece), AlgebraicRoot.of(fmpq(1, 3))
    for _ in range(amount(400)):
        p = [size * fmpq(int(c), 1024) for c in rng.integers(-4096, 4097, 3)]
        kind, k = rng.integers(4), int(rng.integers(len(solid.surfaces)))
        if kind == 3:
            p[0] = size  # on a side of the box
        elif kind:  # beside a surface, by some roundings of the place
            lo, hi = (fmpq(0), fmpq(0), fmpq(0)), tuple(p)
            if exactly(solid.surfaces[k], (*lo, fmpq(1))) * exactly(solid.surfaces[k], (*hi, fmpq(1))) < 0:
                for _ in range(int(rng.integers(40, 70))):
                    middle = tuple((a + b) / 2 for a, b in zip(lo, hi, strict=True))
                    same = exactly(solid.surfaces[k], (*middle, fmpq(1))) == exactly(solid.surfaces[k], (*lo, fmpq(1)))
                    lo, hi = (middle, hi) if same else (lo, middle)
                p = list(lo)
        w = fmpq(int(rng.choice([1, -3, 7])), 5)
        x = (*(c * w for c in p), w)
        there = PlaceOfRoot(x, root)
        signs = [there.sign(form) for form in pair.forms_b]
        assert signs == [exactly(surface, x) for surface in solid.surfaces], p
        seen |= set(signs)
    assert seen == {-1, 0, 1}
