"""The point that is told of bodies in contact at the start is one that both have."""

from fractions import Fraction as F

import pytest

import firstcontact as fc

LO, HI = (F(-15337, 14460), F(-166009, 57840), F(-4433, 1446)), (F(42503, 14460), F(7511, 57840), F(1351, 1446))


@pytest.mark.parametrize("method", ["auto", "certified"])
def test_a_piece_that_elimination_does_not_follow_starts_in_a_box(method):
    """Doubles know a place near both bodies: it was told as a point, 0.0004 outside the box."""
    corners = [(x, y, z) for x in (LO[0], HI[0]) for y in (LO[1], HI[1]) for z in (LO[2], HI[2])]
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    p = fc.RationalCurve([[-2, 4, 0], [0, 6, -6], [-2, 2, 0]], [1])
    q = fc.RationalCurve([[-3, 2], [1, -3], [-3, 1]], [4, -1, 1])
    motion = fc.RationalMotion([
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        [[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 0, 6], [0, 0, 0, 0]],
        [[-0.25, 0, 0, -5], [0, -0.25, 0, 0], [0, 0, 0.25, -6], [0, 0, 0, 0.25]],
        [[0, 0, 0, 1.25], [0, 0, 0, 0], [0, 0, 0, 1.5], [0, 0, 0, 0]],
        [[0, 0, 0, -1.25], [0, 0, 0, 0], [0, 0, 0, -1.5], [0, 0, 0, 0]],
    ])  # fmt: skip
    hit = fc.first_contact(fc.Polyhedron(corners, sides), fc.RuledSurface(p, q).moving(motion), method=method)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "overlapping")
    if method == "certified":
        assert hit.point is None
        return
    assert all(float(lo) - 1e-9 <= x <= float(hi) + 1e-9 for lo, x, hi in zip(LO, hit.point, HI, strict=True))
