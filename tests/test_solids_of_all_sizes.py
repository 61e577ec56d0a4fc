"""Exact contacts do not depend on the unit of length: the same kinds and times, places in proportion."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

DOWN = (0, 0, -64)


def pin_on_a_rim(s):  # all around it, a ring as wide as a thousandth of it
    plate = fc.box((64 * s, 64 * s, 8 * s)) - fc.cylinder(8 * s, 16 * s)
    return fc.cylinder(8 * s * (1 + F(1, 1000)), 32 * s).translated((0, 0, 30 * s)), plate, F(5, 32), "patch"


def can_on_a_box(s):  # lands on its side
    can = fc.cylinder(3 * s, 10 * s).rotated((1, 0, 0), degrees=90).translated((s, 0, 19 * s))
    return can, fc.box((20 * s, 20 * s, 8 * s)), F(12, 64), "segment"


def box_on_a_can(s):
    box = fc.box((4 * s, 2 * s, 4 * s)).translated((s, s, 18 * s))
    return box, fc.cylinder(5 * s, 16 * s), F(8, 64), "patch"


def tilted_can(s):  # the rim comes down first
    turn = [[F(3, 5), 0, F(4, 5), 0], [0, 1, 0, 0], [F(-4, 5), 0, F(3, 5), 0], [0, 0, 0, 1]]
    can = fc.cylinder(3 * s, 8 * s).transformed(turn)
    return can.translated((0, 0, 16 * s)), fc.box((40 * s, 40 * s, 2 * s)), F(51, 5) / 64, "point"


@pytest.mark.share(16)
@pytest.mark.parametrize("scene", [pin_on_a_rim, can_on_a_box, box_on_a_can, tilted_can])
@pytest.mark.parametrize("power", [-100, -40, -30, 28, 36, 60, 100])
def test_scaled_scene(scene, power):
    s = F(2) ** power
    a, b, time, kind = scene(s)
    plain = fc.first_contact(*_falling(*scene(F(1))[:2], F(1)), exact=True)
    hit = fc.first_contact(*_falling(a, b, s), exact=True)
    assert (hit.time_exact, hit.contact_set) == (time, kind)
    assert (plain.time_exact, plain.contact_set) == (time, kind)
    assert [e.label for e in (hit.element_a, hit.element_b)] == [e.label for e in (plain.element_a, plain.element_b)]
    assert hit.multiplicity == plain.multiplicity
    assert np.allclose(np.asarray(hit.contact_set.points) / float(s), plain.contact_set.points, rtol=0, atol=1e-9)
    assert fc.first_contact(*_falling(a, b, s)).time == pytest.approx(float(time), rel=1e-11)
    if scene is can_on_a_box:
        assert np.allclose(sorted(plain.contact_set.points.tolist()), [[1, -5, 4], [1, 5, 4]])


def _falling(a, b, s):
    return a.moving(fc.Translation([c * s for c in DOWN])), b
