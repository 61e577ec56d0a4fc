"""Features of solids of many surfaces: sought among near surfaces alone, they are those sought among all."""

import random
import time as clock
from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.body.solid import features, regions
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import And, Leaf, Not, Or
from firstcontact.body.solid.regions import Regions, grows_with_leaves, leaves_of, simplified
from firstcontact.contact.models import certified
from firstcontact.errors import InputError


def tool(kind: str) -> CompositeQuadric:
    """Holes of radius 2 from above into z > -2, wider ones at z = 2."""
    if kind == "sunk":
        return fc.cylinder(2, 8) | fc.frustum(0, 6, 6).translated((0, 0, -2))
    if kind == "drill":
        return fc.cylinder(2, 4).translated((0, 0, 2)) | fc.frustum(0, 2, "3/2").translated((0, 0, "-3/2"))
    if kind == "bore":
        return fc.cylinder(2, 8) | fc.cylinder(3, 4).translated((0, 0, 2))
    ends = [fc.cylinder("3/2", 8).translated((x, 0, 0)) for x in (2, -2)]
    return fc.box((4, 3, 8)) | ends[0] | ends[1]


def plate(kind: str, rows: int, columns: int) -> CompositeQuadric:
    body = fc.box((10 * columns, 10 * rows, 4))
    for r in range(rows):
        for c in range(columns):
            body -= tool(kind).translated((10 * c - 5 * (columns - 1), 10 * r - 5 * (rows - 1), 0))
    return body


def described(body: CompositeQuadric) -> list[tuple[object, ...]]:
    """All features, by what they are: surfaces that only pass a vertex, and the steps along curves, may differ."""
    found: list[tuple[object, ...]] = [("face", *f.surfaces, f.orientation, f.name) for f in body.faces]
    for kind, edges in (("edge", body.edges), ("seam", body.seams)):
        for e in edges:
            ends = [x for p in e.pieces for x in (p.start, p.end)]
            at = sorted(tuple(np.round(body.vertices[v].position, 9)) for v in ends if v is not None)
            found.append((kind, *e.surfaces, e.convexity, len(e.pieces), *at))
    return found + [("vertex", *np.round(v.position, 9).tolist(), v.is_apex) for v in body.vertices]


def same(body: CompositeQuadric, whole: CompositeQuadric) -> bool:
    """But for tips of cones that other surfaces hide: where all are looked at, they are told too."""
    found, known = (sorted(map(str, described(x))) for x in (body, whole))
    extra = [x for x in known if x not in found]
    return all(x in known for x in found) and all(x.startswith("('vertex'") and x.endswith("True)") for x in extra)


def looked_at_whole(body: CompositeQuadric) -> CompositeQuadric:
    """The same solid, of whose surfaces nothing is known."""
    return CompositeQuadric(body.surfaces, body.tree, body.parts, box=body._box, name=body.name)


@pytest.mark.share(4)
@pytest.mark.parametrize("kind", ["sunk", "drill", "bore", "slot"])
def test_a_row_of_holes(kind):
    body = plate(kind, 1, 3)
    assert same(body, looked_at_whole(body))


def random_solid(rng: random.Random, depth: int) -> CompositeQuadric:
    if depth == 0:
        r, h = rng.choice([1, 2, "3/2"]), rng.choice([2, 3])
        made = rng.choice([
            lambda: fc.box((2, rng.choice([1, 2]), h)), lambda: fc.cylinder(r, h), lambda: fc.cone(r, h),
            lambda: fc.frustum(1, rng.choice([0, 2]), h), lambda: fc.sphere(r),
            lambda: fc.cone(2, 2) | fc.frustum(0, 2, 2).translated((0, 0, 2)),
        ])()  # fmt: skip
        return made.translated([rng.choice([-2, -1, 0, 1, "1/2", 2, 3]) for _ in range(3)])
    first, second = random_solid(rng, depth - 1), random_solid(rng, rng.randrange(depth))
    way = rng.randrange(4)
    return first | second if way == 0 else first & second if way == 1 else first - second


@pytest.mark.share(6)
@pytest.mark.parametrize("seed", range(amount(40, 4)))
def test_random_solids(seed):
    """Reaches leave nothing out, whatever was cut from what."""
    rng = random.Random(seed)
    try:
        body = random_solid(rng, rng.choice([1, 2, 3]))
        whole = looked_at_whole(body)
    except InputError:  # an empty combination
        return
    assert same(body, whole)
    rows = np.random.default_rng(seed).uniform(-5, 5, (4000, 3))
    lo, hi = (tuple(fmpq(x) for x in corner) for corner in ((-1, 0, -2), (2, 3, 1)))
    inside = rows[((rows > (-1, 0, -2)) & (rows < (2, 3, 1))).all(axis=1)]
    near = body.near((lo, hi))
    held = body.contains(inside)
    if near is None:  # one value all over the box
        assert held.all() or not held.any()
    else:
        assert np.array_equal(near.contains(inside), held)


def test_a_nappe_that_is_cut_off_stays_cut_off():
    """Beyond what is left of it, a solid made by subtraction is not taken for what it was cut from."""
    both = fc.cone(2, 2) | fc.frustum(0, 2, 2).translated((0, 0, 2))
    lower = both - fc.box((6, 6, 3)).translated((0, 0, "7/2"))
    block = fc.box((20, 20, 20)) - lower
    at = [(0, 0, 3), (0.5, 0, 3.5), (0, 0, 1), (0.2, 0.1, 1.5)]
    assert block.contains(at).tolist() == [True, True, False, False]
    near = block.near(((fmpq(-1),) * 3, (fmpq(4),) * 3))
    assert near is not None and near.contains(at).tolist() == [True, True, False, False]


def test_trees():
    tree = And(And(Leaf(0), Not(Leaf(1))), Not(Or(Leaf(2), And(Leaf(3), Leaf(4)))))
    assert leaves_of(tree.first) == {0: 1, 1: -1} and leaves_of(tree) == {}
    assert grows_with_leaves(tree.first) and not grows_with_leaves(tree)
    assert simplified(tree, (0, 0, 1, 1, 0)) == tree.first
    assert simplified(tree, (0, 0, -1, 0, 0)) is False and simplified(tree, (-1, 1, 1, 1, 0)) is True
    assert simplified(tree, (0, 1, 0, -1, 1)) == And(Leaf(0), Not(Leaf(2)))


def test_regions_of_a_box():
    box = fc.box((2, 2, 2))
    regions = Regions(box.surfaces, box._reaches)
    assert len(list(regions.pairs(box.tree))) == 12  # opposite sides do not meet
    signs = regions.signs((np.array([0.5, -3, -3]), np.array([3.0, 3, 3])))
    assert signs.count(0) == 5 and sorted(signs)[0] == -1


@pytest.mark.share(3)
@pytest.mark.parametrize("kind", ["sunk", "drill", "slot"])
def test_where_the_boundary_passes_is_where_surfaces_are_looked_at(kind, monkeypatch):
    """Pairs that do not meet on the boundary are left out, and nothing else."""
    body = plate(kind, 1, 2)
    assert len(body.surfaces) in regions._MANY
    few = [(i, j) for i, j, _ in Regions(body.surfaces, body._reaches).pairs(body.tree)]
    found = described(body)
    monkeypatch.setattr(regions, "_MANY", ())
    known = [(i, j) for i, j, _ in Regions(body.surfaces, body._reaches).pairs(body.tree)]
    assert set(few) < set(known) if kind == "sunk" else set(few) <= set(known)
    assert sorted(map(str, described(body._with()))) == sorted(map(str, found))


def test_surfaces_that_make_no_difference_are_told():
    same = Or(And(Leaf(0), Leaf(1)), And(Not(Leaf(0)), Leaf(1)))  # leaf 0 decides nothing
    assert regions.deciding(same) == {1} and regions.deciding(And(same, Leaf(2))) == {1, 2}
    assert regions.deciding(Or(Leaf(0), Not(Leaf(0)))) == set() == regions.deciding(True)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", ["sunk", "drill", "bore", "slot"])
def test_a_hundred_holes(kind):
    """Built and asked within seconds, again within milliseconds."""
    begin = clock.perf_counter()
    body = plate(kind, 10, 10)
    ball = fc.sphere(1).translated((5, 5, 20)).moving(fc.Translation((0, 0, -20)))
    pin = fc.cylinder(1, 2).translated((0, 0, 20)).moving(fc.Screw((0, 0, 1), degrees=90, advance=-34))
    ends = fc.first_contact(ball, body)
    landed = fc.first_contact(pin, body)
    assert clock.perf_counter() - begin < 30  # a second or five on a machine that does nothing else
    assert ends.status is fc.Status.FREE  # in a hole, also where it ends in a tip: 1.2 away from the middle
    assert landed.time_interval[0] <= 0.5 <= landed.time_interval[1] and landed.element_b.label == "z+"
    begin = clock.perf_counter()
    for _ in range(5):
        fc.first_contact(ball, body)
    assert clock.perf_counter() - begin < 5 * 0.3


@pytest.mark.thorough
@pytest.mark.parametrize("moving", ["ball", "plate"])
def test_a_part_of_a_model_answers_as_the_whole(monkeypatch, moving):
    body = plate("bore", 3, 4).named("plate")
    ball = fc.sphere("3/2").translated(("11/2", "1/4", 20)).named("ball")
    way = fc.Translation((0, 0, -20)) if moving == "ball" else fc.Translation((0, 0, 20))
    pair = (ball.moving(way), body) if moving == "ball" else (ball, body.moving(way))
    part = fc.first_contact(*pair)
    monkeypatch.setattr(certified, "MANY", 10_000)
    whole = fc.first_contact(ball.moving(way) if moving == "ball" else ball,
                             looked_at_whole(body).moving(way) if moving == "plate" else looked_at_whole(body))
    assert part.status is whole.status is fc.Status.CONTACT
    assert (part.element_a, part.element_b) == (whole.element_a, whole.element_b)
    assert abs(part.time - whole.time) < 1e-11 and np.allclose(part.point, whole.point, atol=1e-9)


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", ["sunk", "bore"])
def test_work_grows_as_the_number_of_holes(kind, monkeypatch):
    """Of the Boolean tree: four times as many holes take less than seven times the steps, not sixteen times."""
    steps = [0]

    def counted(tree, signs):
        steps[0] += 1
        return simplified(tree, signs)

    monkeypatch.setattr(regions, "simplified", counted)
    monkeypatch.setattr(features, "simplified", counted)
    found = []
    for n in (3, 6):
        steps[0] = 0
        assert len(plate(kind, n, n).faces) > n * n
        found.append(steps[0])
    assert found[1] < 7 * found[0]


def test_a_surface_of_both_operands_is_one_surface():
    """Whatever the factor of its form, and on which side of it either is."""
    upper, lower = fc.box((2, 2, 2)).translated((0, 0, 1)), fc.box((2, 2, 2)).translated((0, 0, -1))
    both = upper | lower
    assert len(both.surfaces) == 7 and len(both.faces) == 6
    assert (upper - lower).contains([(0, 0, 0.5), (0, 0, -0.5)]).tolist() == [True, False]
    bored = both - fc.cylinder("1/2", 8) - fc.cylinder("1/2", 8) - fc.cylinder("1/2", 2).translated((0, 0, 5))
    assert len(bored.surfaces) == 7 + 1 + 3 and len(bored.faces) == 7  # one side, three levels of ends


def test_signs_of_many_surfaces_are_exact():
    body = plate("bore", 2, 3)
    third = fmpq(1, 3)
    for point in ((third, third, fmpq(2)), (third, third, 2 - fmpq(1, 10**40)), (third, fmpq(-10), fmpq(0))):
        known = [s.value((*point, fmpq(1))) for s in body.surfaces]
        assert body.signs((*point, fmpq(1))) == [(v > 0) - (v < 0) for v in known]


def test_a_box_beside_a_ball_takes_nothing_away():
    """A plane of the box cuts the ball where the box is not: the ball's face was taken for known from that circle."""
    ball = fc.sphere(2).transformed([[1, F(1, 4), 0, -3], [F(-1, 4), 0, -1, 0], [F(1, 4), 1, 0, -1], [0, 0, 0, 1]])
    box = fc.box((F(7, 8), 1, F(5, 2))).transformed([
        [F(58, 111), F(91, 111), F(26, 111), F(-61, 888)], [F(91, 111), F(-62, 111), F(14, 111), F(-467, 1776)],
        [F(26, 111), F(14, 111), F(-107, 111), F(-1367, 888)], [0, 0, 0, 1],
    ])  # fmt: skip
    for solid in (ball - box, ball.translated((1, 0, 0)) - box.translated((1, 0, 0))):
        assert [(face.surfaces[0], face.orientation) for face in solid.faces] == [(0, 1)] and not solid.edges
    hit = fc.first_contact(fc.sphere(1).translated((-9, 0, -1)).moving(fc.Translation((6, 0, 0))), ball - box)
    other = fc.first_contact(fc.sphere(1).translated((-9, 0, -1)).moving(fc.Translation((6, 0, 0))), ball)
    assert hit.status is other.status is fc.Status.CONTACT and hit.time == pytest.approx(other.time, abs=1e-12)
