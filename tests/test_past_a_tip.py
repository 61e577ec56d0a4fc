"""Curves that pass the tip of a cone closely stay within the tolerance of their polyline, between its points too."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from polylines import distance

CONE = fc.RuledSurface("(0, 0, 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", u=None, s=(0, 3))


@pytest.mark.share(12)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize("bend", [F(1), F(1, 3), F(-5, 2)])
@pytest.mark.parametrize("off", [F(0), F(1, 10**4), F(1, 10**7), F(-1, 10**8), F(1, 10**11)])
def test_a_bent_wall_past_a_tip(off, bend, tolerance):
    """The wall y = x/2 + bend x^2 + off meets the cone z^2 = x^2 + y^2 over every x."""
    side = "(u - {0}, (u - {0})/2 + {1}*(u - {0})**2 + {2}, {3})"
    wall = fc.RuledSurface(*(side.format("3/7", bend, off, z) for z in (-1, 4)))
    curve = fc.intersection_curve(wall, CONE, tolerance=tolerance)
    x = np.concatenate([np.linspace(-3 / 7, 4 / 7, 801), *(np.geomspace(1e-9, 0.4, 200) * s for s in (-1, 1))])
    y = x / 2 + float(bend) * x**2 + float(off)
    truth = np.stack((x, y, np.hypot(x, y)), axis=1)
    assert distance(truth, curve.branches) <= tolerance
