"""Ruled surfaces of all sizes: lengths times a power of two change no time and no element, and scale every place."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

CONE = "(0, 0, 0)", "((1 - u**2)/(1 + u**2), 2*u/(1 + u**2), 2)"
DOWN = (F(1, 8), F(1, 16), -4)
TILTED = [[1, 0, 0, 0], [0, F(3, 5), F(4, 5), 0], [0, F(-4, 5), F(3, 5), 0], [0, 0, 0, 1]]
MIRRORED = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
SADDLE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)").translated((F(-1, 3), F(-1, 5), 0))
BOWL = fc.RuledSurface("(-1, u, u**2)", "(1, u, u**2)", u=(-1, 1))
TIP = fc.RuledSurface(*CONE, u=None)
FLOOR = fc.Polyhedron([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [[0, 1, 2, 3]])

# An upper body that goes down, and a lower one; lower ones reach up to z = 0 or a little beyond.
SCENES = {
    "tip on ball": (TIP, fc.sphere(3).translated((0, 0, -3))),
    "tip on box": (TIP, fc.box((5, 4, 2)).translated((0, 0, -1))),
    "bowl on ball": (BOWL, fc.sphere(3).translated((0, 0, -3))),
    "bowl on cylinder": (BOWL, fc.cylinder(2, 4).transformed(TILTED).translated((0, 0, -3))),
    "saddle on ball": (SADDLE, fc.ellipsoid((2, 3, 1)).translated((0, 0, -1))),
    "saddle on a rim": (SADDLE, fc.cone(1, 2).translated((0, 0, -2))),
    "bowl on saddle": (BOWL.transformed(TILTED), SADDLE.transformed(MIRRORED)),
    "tip on mesh": (TIP, FLOOR),
    "saddle on mesh": (SADDLE.transformed(TILTED), FLOOR.transformed(TILTED)),
}  # fmt: skip


def motion(how, k):
    if how == "translation":
        return fc.Translation([k * x for x in DOWN])
    if how == "screw":
        return fc.Screw((0, 0, 1), (k / 3, 0, 0), degrees=20, advance=-4 * k)
    return fc.Sequence([fc.Rotation((0, 0, 1), (k, 0, 0), degrees=30), fc.Translation([k * x for x in DOWN])], [1, 1])


def moving(name, how, k):
    upper, lower = SCENES[name]
    grown = [[k, 0, 0, 0], [0, k, 0, 0], [0, 0, k, 0], [0, 0, 0, 1]]
    upper = upper.translated((0, 0, 2))
    return upper.transformed(grown).moving(motion(how, k)), lower.transformed(grown)


@pytest.mark.share(12)
@pytest.mark.parametrize("how", ["translation", "screw", "sequence"])
@pytest.mark.parametrize("name", SCENES)
def test_lengths_times_a_power_of_two(name, how):
    known = fc.first_contact(*moving(name, how, F(1)))
    for power in (-100, 120):
        k = F(2) ** power
        hit = fc.first_contact(*moving(name, how, k))
        assert (hit.status, hit.reason) == (known.status, known.reason)
        if known.status is not fc.Status.CONTACT:
            continue
        assert abs(hit.time - known.time) < 1e-12
        assert [(x and x.kind, x and x.index) for x in (hit.element_a, hit.element_b)] == [
            (x and x.kind, x and x.index) for x in (known.element_a, known.element_b)
        ]
        assert np.abs(hit.point / float(k) - known.point).max() < 1e-9
        assert (hit.normal is None) == (known.normal is None)
        assert known.normal is None or np.abs(hit.normal - known.normal).max() < 1e-6
        assert hit.contact_set == known.contact_set


def test_a_small_piece_and_a_ball_of_large_size():
    """An array of nothing stood for what rulings beside the ball leave."""
    k = F(2) ** 120
    placed = [[0, 0, 1, -2097152], [1, 0, 0, -1048576], [0, 1, 0, 1048576], [0, 0, 0, 1]]
    grown = [[k, 0, 0, 0], [0, k, 0, 0], [0, 0, k, 0], [0, 0, 0, 1]]
    slopes = ("-3/2", "1/2", 0), ("-1/2", "3/2", -1)
    sides = ([[c, w] for c, w in zip(("-16/15", "-5/3", "-119/30"), way, strict=True)] for way in slopes)
    a = fc.RuledSurface(*(fc.RationalCurve(side, [1]) for side in sides), u=(-3, -1)).transformed(placed)
    b = fc.sphere(1).transformed(placed)
    known = fc.first_contact(a.moving(fc.Translation((4, 1, 4))), b)
    hit = fc.first_contact(a.transformed(grown).moving(fc.Translation((4 * k, k, 4 * k))), b.transformed(grown))
    assert hit.status is known.status is fc.Status.CONTACT
    assert abs(hit.time - known.time) < 1e-12
    assert np.abs(hit.point / float(k) - known.point).max() < 1e-9
