"""Which solids of planes and quadrics are proved to be bounded: by hand, at all scales, and against points far out."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.solid.carriers import Plane, Quadric
from firstcontact.body.solid.csg import Leaf, conjunction
from firstcontact.body.solid.extent import proved_box


def half(normal, offset):
    return fc.half_space(normal, offset)


def bowl(z, up=1):
    """up * (Z - z) >= X^2 + Y^2."""
    return fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, F(-up, 2)], [0, 0, F(-up, 2), up * z]])


def trough():
    """Z >= X^2."""
    return fc.quadric([[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, F(-1, 2)], [0, 0, F(-1, 2), 0]])


def block(size):
    sides = [half(n, size) for n in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    solid = sides[0]
    for side in sides[1:]:
        solid = solid & side
    return solid


BOUNDED = {  # and how far they reach
    "a bowl below a plane": (lambda: bowl(0) & half((0, 0, 1), 1), 1),
    "a bowl below a slanted plane": (lambda: bowl(0) & half((1, 0, 2), 1), 1),
    "a trough between planes": (lambda: trough() & half((0, 0, 1), 1) & half((0, 1, 0), 1) & half((0, -1, 0), 1), 1),
    "two bowls": (lambda: bowl(-1) & bowl(1, up=-1), 1),
    "a large block": (lambda: block(2**24), 2**24),
    "a huge block": (lambda: block(10**9), 1e9),
    "a small ball far away": (lambda: fc.sphere(1).translated((2**26, 0, 0)), 2**26 + 1),
}
UNBOUNDED = {
    "a bowl": lambda: bowl(0),
    "a bowl above a plane": lambda: bowl(0) & half((0, 0, -1), -1),
    "a trough below a plane": lambda: trough() & half((0, 0, 1), 1),
    "outside of a bowl": lambda: half((0, 0, -1), 0) - bowl(0),
    "a cone about z = 2 above a plane": lambda: fc.quadric(
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 2], [0, 0, 2, -4]]
    ) & half((0, 0, -1), 0),
}


@pytest.mark.share(3)
@pytest.mark.parametrize("name", BOUNDED)
def test_bounded(name):
    """Found from outside: bowls cut by one plane, and all that reaches 2^24, were refused as unbounded."""
    make, reach = BOUNDED[name]
    solid = make()
    lo, hi = solid.bounds()
    assert solid.bounded and np.abs([lo, hi]).max() == pytest.approx(reach, rel=0.05)
    drop = fc.Polyhedron([(lo[0], lo[1], hi[2] + 4 * reach)], [])
    assert fc.first_contact(solid.moving(fc.Translation((0, 0, 1))), drop).status is fc.Status.FREE


@pytest.mark.share(6)
@pytest.mark.parametrize("name", UNBOUNDED)
def test_unbounded(name):
    assert not UNBOUNDED[name]().bounded


@pytest.mark.thorough
def test_nothing_is_left_out():
    rng = np.random.default_rng(261126)
    directions = rng.normal(size=(4000, 3))
    directions /= np.abs(directions).max(axis=1, keepdims=True)
    directions[:6] = [*np.eye(3), *-np.eye(3)]
    told = 0
    for _ in range(14):
        root = rng.integers(-2, 3, size=(2, 3)) * rng.integers(0, 2, size=(2, 1))  # rank 2: it opens
        form = np.zeros((4, 4), int)
        form[:3, :3] = root.T @ root
        form[3] = form[:, 3] = [*rng.integers(-2, 3, size=3), rng.integers(-3, 1)]
        forms = [form] if form[:3, :3].any() else []
        for n in rng.integers(-2, 3, size=(3, 4)):
            if n[:3].any():
                forms.append(np.array([[0, 0, 0, n[0]], [0, 0, 0, n[1]], [0, 0, 0, n[2]], [*n[:3], 2 * n[3]]]))
        surfaces = [Quadric(exact(f)) if f[:3, :3].any() else Plane(exact([2 * f[3]])[0]) for f in forms]
        box = proved_box(conjunction([Leaf(k) for k in range(len(surfaces))]), surfaces)
        if box is None:
            continue
        told += 1
        for r in float(box[1][0]) * np.array([1.0001, 1.5, 10, 1e3, 1e6]):
            x = np.column_stack([directions * r, np.ones(len(directions))])
            values = np.array([np.sum(x @ f * x, axis=1) for f in forms])
            assert np.all(values.max(axis=0) > 0)
    assert told >= 2


def exact(rows):
    return tuple(tuple(fmpq(int(x)) for x in row) for row in rows)
