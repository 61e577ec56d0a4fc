"""Directrices under the motions of the library: the polynomials stand for the posed surfaces, at all times."""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.exact.numbers import precision
from firstcontact.search.rulings.directrices import directrix_pieces

CIRCLE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"
STRIP = fc.RuledSurface("(u, 0, 0)", "(u**2, 1, u)", s=("-1/2", 2), name="strip")
TUBE = fc.RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, name="tube").translated((0, "1/3", 0))
WAVE = fc.RuledSurface("(u, T, u**2)", "(u, 1, T*u/(1 + T**2))", name="wave")
TURN = {"axis": (1, 2, 2), "point": (0, "1/2", 0)}
BETWEEN = fc.RationalMotion.between((0, 0, 0), (1, 2, 3), quat_xyzw=[(0, 0, 0, 1), (1, 0, 1, 1)])

PAIRS = {
    "at rest": (STRIP, TUBE),
    "translation": (STRIP.moving(fc.Translation((1, "1/3", 0))), TUBE),
    "rotation of the other": (STRIP, TUBE.moving(fc.Rotation((1, 1, 0), turns=1))),
    "one axis, two speeds": (
        STRIP.moving(fc.Rotation(**TURN, turns="3/4")), TUBE.moving(fc.Rotation(**TURN, turns="-1/4"))
    ),
    "rational": (TUBE.moving(BETWEEN), STRIP.moving(fc.Translation((0, 0, 1)))),
    "sequence": (STRIP.moving(fc.Sequence([fc.Translation((0, 0, 1)), fc.Rotation((0, 0, 1), degrees=200)])), TUBE),
    "deforming": (WAVE, TUBE),
    "deforming, and moving": (WAVE.moving(BETWEEN), STRIP.moving(fc.Translation((0, 5, 0)))),
    "deforming seen from what moves": (TUBE.moving(fc.Translation((0, 5, 0))), WAVE),
}  # fmt: skip


def sides_at(surface, t):
    """(2, 7, 3) points of the sides of a moving or resting surface in the world, from its pose in doubles."""
    u = np.linspace(0, 1, 7)
    shape = getattr(surface, "body", surface).at(t)
    points = np.array([side.points(u) for side in shape.sides])
    if not hasattr(surface, "motion"):
        return points
    m = surface.motion(t)
    return points @ m[:3, :3].T + m[:3, 3]


def distances(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2)


@pytest.mark.parametrize("name", PAIRS)
def test_polynomials_stand_for_the_posed_surfaces(name):
    a, b = PAIRS[name]
    pieces = list(directrix_pieces(a, b, fmpq(0), fmpq(1)))
    assert pieces[0].motion.start == 0 and pieces[-1].motion.end == 1
    u = np.linspace(0, 1, 7)
    for piece in pieces:
        lo, hi = piece.motion.u_lo, piece.motion.u_hi
        for k in range(5):
            x = lo + (hi - lo) * k / 4
            with precision(128):
                t = min(max(float(piece.motion.time_of(x).mid()), 0.0), 1.0)
            local = np.array([side.at(x).points(u) for side in (*piece.p, *piece.q)])
            world = np.concatenate([sides_at(a, t), sides_at(b, t)])
            # one frame for both: all distances between points of either agree with those in the world
            assert np.abs(distances(local.reshape(-1, 3)) - distances(world.reshape(-1, 3))).max() < 1e-12
            if piece.motion.frame is not None:
                frame = np.array([[float(y(x) / piece.motion.frame[3][3](x)) for y in row]
                                  for row in piece.motion.frame[:3]])  # fmt: skip
                assert np.abs(local @ frame[:, :3].T + frame[:, 3] - world).max() < 1e-12
            for side in (*piece.p, *piece.q):
                w = side.at(x).components[3]
                assert side.at(x).points(u).shape == (7, 3) and not any(w(fmpq(i, 9)) == 0 for i in range(10))


def test_degrees_and_weights():
    (piece,) = directrix_pieces(STRIP.moving(fc.Translation((1, 0, 0))), TUBE, fmpq(0), fmpq(1))
    assert [max(len(m[0]) for m in curve.coefficients) for curve in piece.p] == [2, 2]
    assert not any(curve.deforming for curve in piece.q)
    pieces = list(directrix_pieces(STRIP.moving(fc.Rotation((0, 0, 1), turns=1)), TUBE, fmpq(0), fmpq(1)))
    assert len(pieces) == 3 and all(len(curve.coefficients[0][0]) == 3 for x in pieces for curve in x.p)
    for x in pieces:
        for curve in x.p:
            assert curve.components[3](1, 0) > 0


def test_what_has_no_polynomials_is_refused():
    turning = fc.Rotation((0, 0, 1), turns=1)
    with pytest.raises(fc.UnsupportedPair, match="wave deforms with the time"):
        list(directrix_pieces(WAVE.moving(turning), TUBE, fmpq(0), fmpq(1)))
    with pytest.raises(fc.UnsupportedPair, match="no rational pose"):
        list(directrix_pieces(STRIP.moving(fc.Screw((0, 0, 1), turns=1, advance=1)), TUBE, fmpq(0), fmpq(1)))
    with pytest.raises(fc.UnsupportedPair, match="no rational function of one parameter"):
        list(directrix_pieces(STRIP.moving(turning), TUBE.moving(fc.Translation((1, 0, 0))), fmpq(0), fmpq(1)))
    with pytest.raises(TypeError):
        list(directrix_pieces(fc.sphere(1), TUBE, fmpq(0), fmpq(1)))
