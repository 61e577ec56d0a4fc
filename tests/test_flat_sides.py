"""Which sides of triangles lie within a flat face: told on the exact coordinates, whatever the doubles look like."""

from __future__ import annotations

from fractions import Fraction as F
from itertools import permutations

import numpy as np
import pytest

import firstcontact as fc
import naive

E = F(1, 2**60)
ROOF_FACES = [(0, 1, 2), (0, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)]
ENGINES = ("auto", "boxes", "lifted", "composed", "sweep")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("z", [0, 2**60, F(1, 3)])
def test_a_ridge_lower_than_doubles_tell(z, engine):
    roof = fc.Polyhedron(
        [(-1, -1, 1 + z), (1, -1, 1 + z - E), (1, 1, 1 + z), (-1, 1, 1 + z - E), (0, 0, z - 1)], ROOF_FACES
    )
    rod = fc.Polyhedron([(F(1, 2), F(-1, 2), 2 + z), (F(-1, 2), F(1, 2), 2 + z)], [], edges=[(0, 1)])
    hit = fc.first_contact(rod.moving(fc.Translation((0, 0, -1))), roof, engine=engine, exact=True)
    assert hit.status is fc.Status.CONTACT and hit.time_exact == 1
    back = fc.first_contact(roof.moving(fc.Translation((0, 0, 1))), rod, engine=engine, exact=True)
    assert back.time_exact == 1


def test_a_ridge_of_ten_units_far_from_the_origin():
    """At 2^60 doubles lie 256 apart."""
    z = 2**60
    roof = fc.Polyhedron(
        [(-40, -40, z + 10), (40, -40, z), (40, 40, z + 10), (-40, 40, z), (0, 0, z - 80)], ROOF_FACES
    )
    rod = fc.Polyhedron([(20, -20, z + 30), (-20, 20, z + 30)], [], edges=[(0, 1)])
    hit = fc.first_contact(rod.moving(fc.Translation((0, 0, -40))), roof, exact=True)
    assert hit.time_exact == F(1, 2) and hit.contact_set == "point"


def roof_and_rod(rng, error):
    """A plate of two triangles, turned into any axis, whose corners stand out by 0 or `error`; and a rod above it."""
    order = list(permutations(range(3)))[rng.integers(6)]
    far = F(2) ** int(rng.choice([-40, 0, 30, 60])) * int(rng.integers(-3, 4))

    def placed(x, y, z):
        p = x, y, z + far
        return tuple(p[k] for k in order)

    up = [error * int(k) for k in rng.integers(-1, 2, 4)]
    plate = [placed(-3, -3, up[0]), placed(3, -3, up[1]), placed(3, 3, up[2]), placed(-3, 3, up[3]), placed(0, 0, -9)]
    x, y = (F(int(k), 4) for k in rng.integers(-3, 4, 2))
    dx, dy = (F(int(k), 4) for k in rng.integers(-4, 5, 2))
    height = F(int(rng.integers(1, 4)))
    rod = [placed(x - dx, y - dy, height), placed(x + dx, y + dy, height)]
    way = placed(0, 0, -2 * height - far)
    return plate, rod, way


@pytest.mark.share(4)
@pytest.mark.parametrize("error", [E, F(1, 3 * 2**70), F(1, 2**1100), F(7)])
def test_plates_that_are_flat_but_for_rounding(error):
    """Against the slow reference; every engine in turn, both orders."""
    sharp = 0
    for seed in range(24):
        rng = np.random.default_rng(seed)
        plate, rod, way = roof_and_rod(rng, error)
        status, time, _ = naive.first_contact(
            rod, [(0, 1)], [], plate, [], ROOF_FACES, naive.Shift(way), F(1), False, False
        )
        a, b = fc.Polyhedron(rod, [], edges=[(0, 1)]), fc.Polyhedron(plate, ROOF_FACES, solid=False)
        engine = ENGINES[seed % len(ENGINES)]
        back = tuple(-x for x in way)
        for hit in (
            fc.first_contact(a.moving(fc.Translation(way)), b, engine=engine, exact=True),
            fc.first_contact(b.moving(fc.Translation(back)), a, engine=engine, exact=True),
        ):
            assert hit.status.name == status, (seed, engine)
            if status == naive.CONTACT:
                assert hit.time_exact == F(int(time.numer()), int(time.denom())), (seed, engine)
        sharp += hit.element_a is not None and hit.element_a.kind == "edge"
    assert sharp > 2


@pytest.mark.parametrize("move", [
    lambda body: body,
    lambda body: body.translated(("1/3", "0.1", 7)),
    lambda body: body.rotated((0, 0, 1), degrees=30).rotated((0, 0, 1), degrees=-30),
    lambda body: body.transformed([["1/3", 0, 0, 1], [0, 0, "-2/7", 0], [0, 5, 0, "1/9"], [0, 0, 0, 1]]),
    lambda body: body.transformed([[F(1, 2**600), 0, 0, 0], [0, F(1, 2**600), 0, 0], [0, 0, F(1, 2**600), 0],
                                   [0, 0, 0, 1]]),
], ids=["as made", "shifted", "turned", "mapped", "tiny"])  # fmt: skip
def test_diagonals_of_a_box_stay_flat_where_it_is_placed(move):
    """A grain sinks onto its top, where a diagonal is: that of the top is no edge, wherever maps have put the box."""
    box = move(fc.examples.box((2, 2, 2)))
    top = [box.exact_vertex(i) for i in range(8)]
    corners = sorted(tuple(F(int(x.p), int(x.q)) for x in p) for p in top)
    middle = tuple(sum(p[k] for p in corners) / 8 for k in range(3))
    high = max(p[2] for p in corners)
    start = middle[0], middle[1], high + 1
    rod = fc.Polyhedron([start, (start[0], start[1], start[2] + 1)], [], edges=[(0, 1)])
    hit = fc.first_contact(rod.moving(fc.Translation((0, 0, -2))), box, exact=True)
    assert hit.time_exact == F(1, 2)
    met = [hit.element_b, *(pair.element_b for pair in hit.others)]
    assert {element.kind for element in met} == {"face"}, met
