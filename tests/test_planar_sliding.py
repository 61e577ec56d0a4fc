"""Parts that turn and shift on one table: faces slide in one plane all the time, and walls tell when they touch."""

from __future__ import annotations

import time

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.polyhedra.planar import has_walls
from firstcontact.contact.polyhedra.problems.problem import problem_of
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.search.trees.windows import DONE, STACK

UP = (0, 0, 1)
NORMAL = fmpq(0), fmpq(0), fmpq(1)


def prism(rng, high: float) -> fc.Polyhedron:
    """Over a star-shaped polygon, from z = 0."""
    n = int(rng.integers(3, 8))
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(0.4, 1.2, n)[:, None]
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (0.0, high)])
    k = np.arange(n)
    walls = np.column_stack([k, (k + 1) % n, (k + 1) % n + n, k + n]).tolist()
    return fc.Polyhedron(points, [k[::-1].tolist(), (k + n).tolist(), *walls])


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", range(amount(18)))
def test_parts_on_one_table_touch_as_parts_at_two_heights(seed):
    rng = np.random.default_rng(seed)
    a, b = prism(rng, 1.0), prism(rng, 1.0 if seed % 2 else 2.0)
    way = fc.Translation((-4, float(rng.uniform(-1, 1)), 0))
    turn = fc.Rotation(UP, (0.25, 0, 0), degrees=float(rng.uniform(30, 300)))
    start = a.translated((3, float(rng.uniform(-1, 1)), 0)).moving(way)
    hit, apart = (fc.first_contact(start, x.moving(turn)) for x in (b, b.translated((0, 0, 0.25))))
    assert hit.status is apart.status and hit.status is not fc.Status.UNDECIDED
    if hit.status is fc.Status.CONTACT:
        assert hit.time == pytest.approx(apart.time, abs=1e-14)


def test_on_a_slanting_table():
    """Both bodies turn, about parallel axes."""
    tilt = [["2/3", "-1/3", "2/3", 0], ["2/3", "2/3", "-1/3", 0], ["-1/3", "2/3", "2/3", 0], [0, 0, 0, 1]]
    hits = []
    for axis, point, place in ((UP, (10, 20, 0), np.eye(4)), ((2, -1, 2), (0, 20, 10), tilt)):
        a = fc.examples.box((2, 2, 2)).translated((4, 0.1, 0)).transformed(place)
        b = fc.examples.box((3, 4, 2)).transformed(place)
        first, second = fc.Rotation(axis, point, degrees=-10), fc.Rotation(axis, degrees=-100)
        hits.append(fc.first_contact(a.moving(first), b.moving(second)))
    assert hits[0].status is fc.Status.CONTACT and hits[1].time == pytest.approx(hits[0].time, abs=1e-12)


def test_the_corner_of_a_sheet_meets_another_one_in_its_plane():
    """Sheets have no walls.  The corner (1, -1) comes round to x = sqrt(2) cos(50 t - 45), the side to x = 3 - 4 t."""
    sheet = fc.Polyhedron([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])
    way, turn = fc.Translation((-4, 0.1, 0)), fc.Rotation(UP, degrees=50)
    hit = fc.first_contact(sheet.translated((4, 0, 0)).moving(way), sheet.moving(turn))
    assert hit.status is fc.Status.CONTACT
    lo, hi = hit.time_interval
    ahead = [3 - 4 * t - np.sqrt(2) * np.cos(np.radians(50 * t - 45)) for t in (lo - 1e-12, hi + 1e-12)]
    assert ahead[0] > 0 > ahead[1]


def test_which_have_walls():
    box = fc.examples.box((1, 2, 3))
    assert has_walls(box, NORMAL) and has_walls(box.rotated((1, 2, 3), degrees=20), NORMAL)
    with pytest.warns(UserWarning, match="taken as a surface"):
        folded = fc.Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]])
    assert not folded.solid and not has_walls(folded, NORMAL)


def test_no_window_is_told_of_parts_on_one_table_that_miss_each_other():
    """No bound tells when faces that slide in one plane share points, but the walls never touch."""
    cube = fc.examples.box((1, 1, 1))
    passing = cube.translated((-2, 0, 0)).moving(fc.Translation((3, 0, 0)))
    found = fc.contact_intervals(passing, cube.translated((2, 0, 0)).moving(fc.Rotation(UP, (1.5, 1, 0), degrees=50)))
    assert found.status is fc.Status.FREE and found.free_until == 1 and len(found) == 0


def squares_apart(one, other):
    """The largest gap of two squares (4, 2) in a plane, across a side of either: positive where they are apart."""
    gaps = []
    for x in (one, other):
        for side in (x[1] - x[0], x[2] - x[1]):
            across = np.array([-side[1], side[0]]) / np.linalg.norm(side)
            p, q = one @ across, other @ across
            gaps.append(max(p.min() - q.max(), q.min() - p.max()))
    return max(gaps)


def test_a_box_slides_off_a_table_and_both_turn_about_vertical_axes():
    """Trees left all of it open: all that touches lies in one plane."""
    box = fc.examples.box((1, 1, 1)).translated((2, 0, 0.5))
    table = fc.examples.box((6, 6, 1)).translated((0, 0, -0.5))
    ways = fc.Rotation((0, 0, 1), point=(5, 0, 0), degrees=170), fc.Rotation((0, 0, 1), degrees=100)
    found = fc.contact_intervals(box.moving(ways[0]), table.moving(ways[1]), span=(0.3, 0.31))
    assert found.status is fc.Status.INITIAL_CONTACT
    (one,) = found.intervals
    corners = [np.unique(x.vertices[:, :2], axis=0)[[0, 1, 3, 2]] for x in (box, table)]

    def gap(t):
        poses = [way(t) for way in ways]
        return squares_apart(*(x @ m[:2, :2].T + m[:2, 3] for x, m in zip(corners, poses, strict=True)))

    assert one.start == 0.3 and gap(one.end - 1e-9) < 0 < gap(one.end + 1e-9)
    assert one.end_interval[1] - one.end_interval[0] < 1e-12


TETRAHEDRON = fc.Polyhedron(
    [(3, 0, 0), (2, 1, 0), (1, -1, 0), (2, 0, 1.5)], [(2, 1, 0), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
)
PYRAMID = fc.Polyhedron(
    [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0), (0.5, 0, -2)],
    [(0, 1, 2, 3), (1, 0, 4), (2, 1, 4), (3, 2, 4), (0, 3, 4)],
)


SLIDING = TETRAHEDRON.moving(fc.Rotation(UP, (5, 0, 0), degrees=170)), PYRAMID.moving(fc.Rotation(UP, degrees=100))


def test_solids_that_are_no_prisms_slide_on_each_other():
    """Trees took 9 s, more than half of it in one compiled call, before doubles of solids told it in one."""
    found = fc.contact_intervals(*SLIDING)
    assert [x.way for x in found.stats.ways] == ["in the plane"]
    (one,) = found.intervals
    corners = TETRAHEDRON.vertices[:3, :2], PYRAMID.vertices[:4, :2]

    def meet(t):
        poses = [body.motion(t) for body in SLIDING]
        return polygons_meet(*(x @ m[:2, :2].T + m[:2, 3] for x, m in zip(corners, poses, strict=True)))

    assert one.start == 0 and all(meet(t) == (t < one.end) for t in np.linspace(0.001, 1, 400))
    assert meet(one.end - 1e-9) and not meet(one.end + 1e-9)


@pytest.mark.thorough
def test_a_corner_lies_on_an_edge_at_the_start_and_goes_inwards():
    """The end of that contact, which is a ball, was compared with itself: precision."""
    found = fc.contact_intervals(*SLIDING[::-1], span=(0, 0.1))
    assert [x.way for x in found.stats.ways] == ["in the plane"]
    assert [(x.start, x.end) for x in found] == [(0, 0.1)]


def of_cells(cells, low, high):
    """The prism over unit squares of a grid, by the corners at which they begin."""
    squares = [[(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)] for x, y in cells]
    corners = sorted({p for square in squares for p in square})
    n, number = len(corners), {p: k for k, p in enumerate(corners)}
    quads = [[number[p] for p in square] for square in squares]
    sides = {(q[k - 1], q[k]) for q in quads for k in range(4)}
    walls = [[i, j, j + n, i + n] for i, j in sides if (j, i) not in sides]
    points = [(x, y, z) for z in (low, high) for x, y in corners]
    return fc.Polyhedron(points, [*(q[::-1] for q in quads), *([v + n for v in q] for q in quads), *walls])


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", range(amount(16)))
def test_angles_that_slide_on_each_other(seed):
    """Against the squares they are made of; trees left all of it open after 14 s."""
    rng = np.random.default_rng(seed)
    shapes = [(0, 0), (1, 0), (0, 1)], [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1)], [(0, 0), (0, 1), (0, 2), (1, 1)]
    one, other = (shapes[k] for k in rng.integers(0, 3, 2))
    low, high = ((0, 2), (-1, 0), (1, 3))[seed % 3]
    points = rng.integers(-8, 9, (2, 2)) / 4
    ways = [fc.Rotation(UP, (*p, 0), degrees=float(d)) for p, d in zip(points, rng.integers(20, 200, 2), strict=True)]
    found = fc.contact_intervals(of_cells(one, 0, 1).moving(ways[0]), of_cells(other, low, high).moving(ways[1]))
    assert found.status is not fc.Status.UNDECIDED and [x.way for x in found.stats.ways] == ["in the plane"]

    def meet(t):
        corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        a, b = ([(corners + c) @ m[:2, :2].T + m[:2, 3] for c in cells]
                for cells, m in zip((one, other), (way(t) for way in ways), strict=True))  # fmt: skip
        return any(polygons_meet(p, q) for p in a for q in b)

    for t in np.linspace(0, 1, 101):
        if all(min(abs(t - x.start), abs(t - x.end)) > 1e-9 for x in found):
            assert meet(t) == any(x.start < t < x.end for x in found), t


def polygons_meet(one, other):
    """Whether convex polygons (n, 2) share a point: no side of either has them on both sides of it."""
    def apart(x, y):
        (a, b), (c, d) = x[1] - x[0], x[2] - x[0]
        for p, q in zip(x, np.roll(x, -1, axis=0), strict=True):
            across = np.array([q[1] - p[1], p[0] - q[0]]) * (1 if a * d > b * c else -1)
            if (y @ across).min() > p @ across:
                return True
        return False

    return not (apart(one, other) or apart(other, one))


def test_one_look_at_faces_that_slide_in_one_plane_does_not_halve_time_without_end():
    """One pair of them took half a second in a compiled call, during which no interrupt was answered."""
    angle = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    shape = fc.Polyhedron(angle + [(x, y, 1) for x, y, _ in angle], [[5, 4, 3, 2, 1, 0], [*range(6, 12)], *sides])
    moving = shape.translated((1, -1, 0)).moving(fc.Rotation(UP, point=(5, 0, 0), degrees=170))
    table = fc.examples.box((6, 6, 1)).translated((0, 0, -0.5)).moving(fc.Rotation(UP, degrees=100))
    (piece,) = curved_pieces(moving, table, fmpq(0), fmpq(1))
    problem = problem_of(moving, table, piece)
    integers, room = np.zeros(5, np.int64), (np.empty((64, 2)), np.empty((4096, 4)), np.empty((4096, 2), np.int32))
    seconds = []
    for _ in range(2):  # the first one compiles
        integers[:] = 0
        integers[STACK] = 1
        begin = time.process_time()
        assert problem.collect(10**9, integers, np.zeros((1024, 2), np.int32), *room) == DONE
        seconds.append(time.process_time() - begin)
    assert min(seconds) < 0.5  # 0.02 now, 5 s before
