"""Solids are regularised: where surfaces meet without inner points of the solid near, there is nothing to touch."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq, fmpz_poly

import firstcontact as fc
from firstcontact import Status
from firstcontact.body.solid.csg import And, Leaf, Not
from firstcontact.contact.models.shared.dangling import is_dangling
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot

WALLS = fc.quadric(np.diag([1, -1, 0, 1]))
"""x^2 + 1 <= y^2: two parts, of which y >= 1 touches the plane y = 1 in the line x = 0."""
BOWLS = fc.quadric(np.diag([1, 1, -1, 1]))
"""x^2 + y^2 + 1 <= z^2: two parts, of which z >= 1 touches the plane z = 1 in a point."""
WALL = WALLS & fc.box((8, 8, 2)).translated((0, -3, 0))
BOWL = BOWLS & fc.box((8, 8, 8)).translated((0, 0, -3))
STEPS = (fc.box((2, 2, 2)) | fc.box((2, 2, 2)).translated((-3, -3, 0))) & fc.half_space((1, 1, 0), -2)
"""Of the box in the middle an edge is left, x = y = -1."""

DROP = fc.Translation((0, 0, -8))
MISSES = {
    "ball on a line": (fc.sphere("1/2").translated((0, 1, 4)).moving(DROP), WALL),
    "ball beside a line": (fc.sphere("1/2").translated((0, "3/2", 4)).moving(DROP), WALL),
    "box on a line": (fc.box((1, 1, 1)).translated((0, "5/2", 0)).moving(fc.Translation((0, -2, 0))), WALL),
    "ball on a point": (fc.sphere("1/2").translated((5, 0, 1)).moving(fc.Translation((-10, 0, 0))), BOWL),
    "box on a point": (fc.box((1, 1, 1)).translated((0, 0, 3)).moving(fc.Translation((0, 0, -2))), BOWL),
    "box on an edge": (fc.box((1, 1, 1)).translated((1, -1, 0)).moving(fc.Translation((-2, 0, 0))), STEPS),
    "triangle on a point": (
        fc.Polyhedron([(-1, -1, 3), (1, -1, 3), (0, 1, 3)], [(0, 1, 2)]).moving(fc.Translation((0, 0, -3))), BOWL
    ),
    "turning box on a point": (
        fc.box((1, 1, 1)).translated((0, 0, "3/2")).moving(fc.Rotation((0, 0, 1), degrees=180)), BOWL
    ),
}  # fmt: skip
HITS = {
    "triangle on the other bowl": (
        fc.Polyhedron([(-1, -1, 3), (1, -1, 3), (0, 1, 3)], [(0, 1, 2)]).moving(DROP), BOWL, F(1, 2)
    ),
    "ball on the other wall": (fc.sphere("1/2").translated((0, -1, 4)).moving(DROP), WALL, F(5, 16)),
    "ball through a bowl": (fc.sphere("1/2").translated((0, 0, 5)).moving(DROP), BOWL, F(11, 16)),
    "box on the other box": (
        fc.box((1, 1, 1)).translated((2, -3, 0)).moving(fc.Translation((-8, 0, 0))), STEPS, F(7, 16)
    ),
}  # fmt: skip
"""And when: the balls come down on z = 1, the triangle on z = -1, and x = -2 is a face of the box beside."""


@pytest.mark.share(10)
@pytest.mark.parametrize("exact", [False, True], ids=["default", "exact"])
@pytest.mark.parametrize("verb", [fc.first_contact, fc.contact_intervals], ids=["first", "intervals"])
@pytest.mark.parametrize("name", MISSES)
def test_nothing_touches_what_dangles(name, verb, exact):
    a, b = MISSES[name]
    for pair in ((a, b), (b, a)):
        assert verb(*pair, exact=exact).status is Status.FREE


@pytest.mark.share(4)
@pytest.mark.parametrize("name", HITS)
def test_the_rest_of_the_solid_is_touched(name):
    a, b, time = HITS[name]
    for exact in (False, True):
        hit = fc.first_contact(a, b, exact=exact)
        assert hit.status is Status.CONTACT
        assert hit.time == float(time)
        assert fc.contact_intervals(a, b, exact=exact)[0].start == float(time)


# -- patterns of signs in a point -----------------------------------------------------------------------------

RATIONALS = NumberField(AlgebraicRoot.of(fmpq(0)))
ORIGIN = tuple(RATIONALS(c) for c in (0, 0, 0, 1))


def plane(*normal):
    return tuple(constant(c) for c in (*normal, 0))


def quadric(gradient, second):
    rows = [[2 * second[i][j] for j in range(3)] + [gradient[i]] for i in range(3)]
    return tuple(tuple(map(constant, row)) for row in [*rows, [*gradient, 0]])


def constant(c):
    return fmpz_poly([int(c)])


def dangles(*forms):
    """Of the intersection of all."""
    tree = Leaf(0)
    for k in range(1, len(forms)):
        tree = And(tree, Leaf(k))
    return is_dangling(tree, forms, [0] * len(forms), ORIGIN, RATIONALS)


ROUND = np.diag([1, 1, 1]).tolist()
ALONG = np.diag([1, 0, 1]).tolist()
SADDLE = np.diag([1, -1, 0]).tolist()


@pytest.mark.share(8)
@pytest.mark.parametrize(
    ("forms", "truth"),
    [
        ([plane(0, 0, 1), plane(0, 0, -1)], True),
        ([plane(0, 0, 1), plane(0, 0, 1)], False),
        ([plane(1, 0, 0), plane(0, 1, 0), plane(-1, -1, 0)], True),
        ([plane(1, 0, 0), plane(0, 1, 0), plane(1, 1, 0)], False),
        ([plane(1, 0, 0), plane(0, 1, 0), plane(0, 0, 1), plane(-1, -1, -1)], True),
        ([plane(1, 0, 0), plane(0, 1, 0), plane(0, 0, 1), plane(-1, -1, 1)], False),
        ([plane(0, 0, 1), quadric((0, 0, -1), ROUND)], True),  # above z = 0 a ball, below nothing
        ([plane(0, 0, -1), quadric((0, 0, -1), ROUND)], False),
        ([plane(0, 0, 1), quadric((0, 0, -1), SADDLE)], False),
        ([quadric((0, 0, 1), ROUND), quadric((0, 0, -1), ROUND)], True),  # balls side by side
        ([quadric((0, 0, 1), ROUND), quadric((0, 0, -2), SADDLE)], True),  # -y^2 is below -y^2 / 2
        ([quadric((0, 0, 2), ROUND), quadric((0, 0, -1), SADDLE)], False),
        ([quadric((0, 0, 1), np.diag([1, 0, 0]).tolist()), plane(0, 0, -1)], True),  # along a line
        ([quadric((1, 0, 0), ROUND), plane(0, 1, 0), plane(-1, -1, 0)], True),
        ([quadric((0, 0, 1), ALONG), quadric((0, 0, -1), ALONG)], True),  # cylinders side by side
    ],
)  # fmt: skip
def test_patterns_of_an_intersection(forms, truth):
    assert dangles(*forms) is truth
    assert has_inner_points(forms) is not truth


def test_quadrics_that_part_at_third_order_only():
    """Of z + y^2 and x^2 + y z - z - y^2 both are negative in x = 0, z = -y^2 - y^3 / 2 for small y > 0."""
    a = quadric((0, 0, 1), np.diag([0, 1, 0]).tolist())
    b = quadric((0, 0, -1), [[1, 0, 0], [0, -1, F(1, 2)], [0, F(1, 2), 0]])
    for y in (1e-1, 1e-2, 1e-3):
        point = np.array([[0, y, -(y**2) - y**3 / 2]])
        assert valued(a, point) < 0
        assert valued(b, point) < 0
    assert not dangles(a, b)


def test_what_is_outside_of_both():
    tree = And(Not(Leaf(0)), Not(Leaf(1)))
    assert is_dangling(tree, [plane(0, 0, 1), plane(0, 0, -1)], [0, 0], ORIGIN, RATIONALS)
    hollow, ball = (quadric((0, 0, -1), (side * np.array(ROUND)).tolist()) for side in (-1, 1))
    assert is_dangling(tree, [plane(0, 0, 1), hollow], [0, 0], ORIGIN, RATIONALS)
    assert not is_dangling(tree, [plane(0, 0, 1), ball], [0, 0], ORIGIN, RATIONALS)


def has_inner_points(forms, count=400_000):
    """As far as points in doubles tell, most of them near planes in which all gradients but one vanish."""
    rng = np.random.default_rng(5)
    found = False
    for size in (1e-2, 1e-4):
        points = size * rng.uniform(-1, 1, (count, 3))
        points[::2, 2] *= size * rng.uniform(0, 1, len(points[::2]))
        found = (np.array([valued(form, points) for form in forms]) < 0).all(axis=0).any()
    return bool(found)


def number(c):
    return float(int(c[0]))


def valued(form, points):
    if not isinstance(form[0], tuple):
        return points @ [number(c) for c in form[:3]]
    m = np.array([[number(c) for c in row] for row in form])
    return np.einsum("ni,ij,nj->n", points, m[:3, :3], points) + 2 * points @ m[:3, 3]


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", range(40))
def test_what_is_ruled_out_is_never_found(seed):
    """Random forms with few gradients, and trees over them."""
    rng = np.random.default_rng(seed)
    normals = [(0, 0, 1), (0, 0, -1), (0, 1, 0), (1, 0, 0), (0, -1, 1), (0, 1, 1), (-1, -1, -1)]
    forms = []
    for _ in range(rng.integers(2, 5)):
        g = normals[rng.integers(len(normals))]
        half = rng.integers(-2, 3, (3, 3))
        forms.append(plane(*g) if rng.integers(2) else quadric(g, (half + half.T).tolist()))
    signs = rng.integers(0, 2, len(forms)).tolist()
    tree = None
    for k, sign in enumerate(signs):
        leaf = Leaf(k) if sign else Not(Leaf(k))
        tree = leaf if tree is None else And(tree, leaf)
    if not is_dangling(tree, forms, [0] * len(forms), ORIGIN, RATIONALS):
        return
    turned = [form if sign else negative(form) for form, sign in zip(forms, signs, strict=True)]
    assert not has_inner_points(turned)


def negative(form):
    return tuple(tuple(-c for c in row) if isinstance(row, tuple) else -row for row in form)
