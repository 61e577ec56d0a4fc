"""The first new contact of bodies that touch at the start, against closed forms and an arithmetic of boxes."""

import functools
import itertools
import operator
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Rotation, Screw, Status, Translation
from firstcontact.assembly.allowed import Rule, let_pass

HINGE = (0, 1, 0), (0, 0, 0)


def block(lo, hi, name=None, solid=False):
    """The box between two corners, as a mesh of triangles or as a solid."""
    size = [Fraction(q) - Fraction(p) for p, q in zip(lo, hi, strict=True)]
    middle = [(Fraction(p) + Fraction(q)) / 2 for p, q in zip(lo, hi, strict=True)]
    made = fc.box(size) if solid else _triangles(fc.examples.box([float(x) for x in size]))
    return made.translated(middle).named(name)


def _triangles(box):
    return fc.Polyhedron(box.vertices, box.triangles)


def turning(degrees, axis=HINGE):
    return Rotation(*axis, degrees=degrees)


def steps(*vectors):
    return fc.Sequence([Translation(v) for v in vectors])


FRAME = block((0, 0, -2), (2, 2, 0), "frame")
LID = block((0, 0, 0), (2, 2, 0.5), "lid")  # shut, its hinge along an edge of both
OPEN = block((-0.5, 0, 0), (0, 2, 2), "lid")  # upright, on its lower edge
TABLE = block((-3, -3, -1), (3, 3, 0), "table")
FLOOR = block((-0.5, -1, -1), (1.5, 2, 0), "floor")
CUBE = block((0, 0, 0), (1, 1, 1), "cube")
RAILS = [  # a drawer between two rails and a floor, which ends at a wall
    block((-1, -1, -1), (9, 2, 0)),
    block((-1, -1, 0), (9, 0, 2)),
    block((-1, 1, 0), (9, 2, 2)),
    block((7, 0, 0), (9, 1, 1)),
]
QUARTER = Rotation((0, 0, 1), degrees=90)
OUT_AND_IN = fc.Sequence([Translation((4, 0, 0)), Rotation((0, 0, 1), turns=1), Translation((-4, 0, 0))])
CASES = {
    "shut lid, all the way round": (LID.moving(turning(-360)), FRAME, 0.5),
    "upright lid that shuts": (OPEN.moving(turning(120)), FRAME, 0.75),
    "upright lid that shuts as the motion ends": (OPEN.moving(turning(90)), FRAME, 1.0),
    "upright lid that stays open": (OPEN.moving(turning(89)), FRAME, None),
    "lid that is hinged in the middle of a table": (OPEN.moving(turning(120)), TABLE, 0.75),
    "frame that turns under the lid": (FRAME, OPEN.moving(turning(120)), 0.75),
    "cube that slides off": (CUBE.moving(Translation((4, 0, 0))), FLOOR, None),
    "cube that is lifted": (CUBE.moving(Translation((0, 0, 1))), FLOOR, None),
    "cube that is lifted off beside a wall": (CUBE.moving(Translation((0, 0, 1))), block((1, 0, -1), (2, 1, 3)), None),
    "cube that turns on the spot": (CUBE.moving(Rotation((0, 0, 1), degrees=720)), FLOOR, None),
    "cube that is pressed down": (CUBE.moving(Translation((0, 0, -1))), FLOOR, 0.0),
    "cube that tilts into the floor": (CUBE.moving(Rotation((0, 1, 0), ("1/2", 0, 0), degrees=10)), FLOOR, 0.0),
    "cube that is pushed into its neighbour on the floor": (
        CUBE.moving(Translation((2, 0, 0))), block((1, 0, 0), (2, 1, 1), "neighbour"), 0.0,
    ),
    "out and in again": (CUBE.moving(OUT_AND_IN), FLOOR, None),
    "along the floor, then down": (CUBE.moving(steps((1, 0, 0), (0, 0, -1))), FLOOR, 0.5),
    "along, up, back and down again": (CUBE.moving(steps((1, 0, 0), (0, 0, 1), (-1, 0, 0), (0, 0, -1))), FLOOR, 1.0),
    "turned, then down": (CUBE.moving(fc.Sequence([QUARTER, Translation((0, 0, -1))])), FLOOR, 0.5),
    "along the floor, then up": (CUBE.moving(steps((1, 0, 0), (0, 0, 1))), FLOOR, None),
}  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize("case", CASES)
def test_meshes(case):
    a, b, time = CASES[case]
    hit = fc.first_new_contact(a, b)
    assert hit.allowed == "touching at the start"
    if time is None:
        assert hit.status is Status.FREE and hit.time is None
    else:
        lo, hi = hit.time_interval
        assert hit.status is Status.CONTACT and lo <= time <= hi and hi - lo <= 1e-12


def test_a_drawer_meets_the_wall_at_the_end_of_its_rails():
    """The drawer touches floor and rails all along; its front is 6 from the wall, which is a piece of the rails."""
    drawer = block((0, 0, 0), (1, 1, 1), "drawer")
    times = [fc.first_new_contact(drawer.moving(Translation((8, 0, 0))), rail).time for rail in RAILS]
    assert times == [None, None, None, 0.75]
    solid = [block(*np.array(rail.bounds()).tolist(), solid=True) for rail in RAILS]
    rails = (solid[0] | solid[1] | solid[2] | solid[3]).named("rails")
    hit = fc.first_new_contact(block((0, 0, 0), (1, 1, 1), "drawer", solid=True).moving(Translation((8, 0, 0))), rails)
    assert hit.status is Status.CONTACT and hit.time == 0.75 and hit.element_b.body == "rails"
    assert hit.element_b.label in [x.name for x in (*rails.faces, *rails.edges, *rails.vertices)]


PLATE = (fc.box((20, 20, 4)) - fc.cylinder(3, 10).named("hole")).named("plate")
BOLT = (fc.cylinder(3, 10).translated((0, 0, -1)) | fc.cylinder(5, 2).translated((0, 0, 5))).named("bolt")
SEATED = BOLT.translated((0, 0, -2))
FLAT = fc.box((20, 20, 4)).named("flat")
BALL = fc.sphere(3).translated((0, 0, 5)).named("ball")
SOLIDS = {
    "bolt that goes in, its head 2 above": (BOLT, Translation((0, 0, -4)), PLATE, 0.5),
    "bolt that is drawn": (BOLT, Translation((0, 0, 40)), PLATE, None),
    "bolt that turns": (BOLT, Rotation((0, 0, 1), turns=3), PLATE, None),
    "bolt that is screwed in": (BOLT, Screw((0, 0, 1), turns=3, advance=-4), PLATE, 0.5),
    "bolt that is moved sideways": (BOLT, Translation((1, 0, 0)), PLATE, 0.0),
    "seated bolt that turns": (SEATED, Rotation((0, 0, 1), degrees=90), PLATE, None),
    "seated bolt that is drawn": (SEATED, Translation((0, 0, 40)), PLATE, None),
    "seated bolt that is pressed": (SEATED, Translation((0, 0, -1)), PLATE, 0.0),
    "ball that slides": (BALL, Translation((5, 0, 0)), FLAT, None),
    "bolt that turns, then goes in": (
        BOLT, fc.Sequence([Rotation((0, 0, 1), degrees=90), Translation((0, 0, -4))]), PLATE, 0.75
    ),
    "bolt that goes in and then sideways": (BOLT, steps((0, 0, -1), (1, 0, 0)), PLATE, 0.5),
    "ball that is lifted": (BALL, Translation((0, 0, 5)), FLAT, None),
    "mesh that slides on a solid to its stop": (
        block((0, 0, 2), (1, 1, 3)), Translation((0, 4, 0)), FLAT | fc.box((20, 1, 4)).translated((0, 3, 2)), 0.375
    ),
}  # fmt: skip


@pytest.mark.share(13)
@pytest.mark.parametrize("case", SOLIDS)
def test_solids(case):
    body, motion, other, time = SOLIDS[case]
    hit = fc.first_new_contact(body.moving(motion), other)
    assert hit.allowed == "touching at the start"
    if time is None:
        assert hit.status is Status.FREE
    else:
        assert hit.status is Status.CONTACT and hit.time_interval[0] <= time <= hit.time_interval[1]
        assert hit.element_a is not None and hit.element_b is not None


def test_what_no_proof_tells_is_undecided():
    """The ball slides along the floor, ever faster, and stays in contact at one point."""
    along = fc.RationalMotion([np.eye(4), np.zeros((4, 4)), [[0, 0, 0, 1], [0] * 4, [0] * 4, [0] * 4]])
    hit = fc.first_new_contact(BALL.moving(along), FLAT)
    assert hit.status is Status.UNDECIDED and hit.reason == "contact" and hit.free_until == 0.0


@pytest.mark.share(4)
@pytest.mark.parametrize("solid", (False, True))
@pytest.mark.parametrize("degrees, time", ((80, None), (180, 0.5)))
def test_blocks_that_share_their_hinge_alone(degrees, time, solid):
    """Solids of planes were left open, where the same meshes were decided."""
    turned = block((-2, -1, -2), (0, 1, 0), "a", solid).moving(turning(degrees))
    hit = fc.first_new_contact(turned, block((0, -1, 0), (2, 1, 2), "b", solid))
    assert (hit.time, hit.status) == (time, Status.FREE if time is None else Status.CONTACT)
    if time is not None:
        assert {hit.element_a.body, hit.element_b.body} == {"a", "b"}


def test_solids_that_part_in_a_turn():
    """A face moves away from another one, at speeds of 1 to 3 over its length."""
    a = block((Fraction(3, 2), 0, -1), (Fraction(5, 2), 2, 0), solid=True)
    turn = Rotation((0, 0, 1), (-2, -1, 0), degrees=-90)
    hit = fc.first_new_contact(a.moving(turn), block((0.5, 1, -3), (1.5, 3, -1), solid=True))
    assert hit.status is Status.FREE


def test_a_start_later_than_the_motion_s_own():
    drawn = CUBE.moving(Translation((4, 0, 0)))
    assert fc.first_new_contact(drawn, FLOOR, ("1/8", 1)).status is Status.FREE
    down = CUBE.moving(steps((1, 0, 0), (0, 0, -1)))
    assert fc.first_new_contact(down, FLOOR, ("1/4", 1)).time == 0.5


def test_other_starts_are_as_first_contact_has_them():
    apart = CUBE.translated((0, 0, 1)).moving(Translation((0, 0, -2)))
    assert fc.first_new_contact(apart, FLOOR) == fc.first_contact(apart, FLOOR)
    inside = CUBE.translated((0, 0, "-1/2")).moving(Translation((0, 0, 2)))
    hit = fc.first_new_contact(inside, FLOOR)
    assert hit.status is Status.INITIAL_CONTACT and hit.initial == "overlapping" and hit.allowed is None


def test_elements_are_the_body_s_own():
    hit = fc.first_new_contact(OPEN.moving(turning(120)), FRAME)
    where = np.asarray(OPEN.vertices)[hit.element_a.index]
    assert hit.element_a.kind == "vertex" and where[0] == 0.0 and where[2] == 2.0
    assert hit.element_b.kind == "face"
    corners = FRAME.vertices[FRAME.triangles[hit.element_b.index]]
    assert np.all(corners.min(axis=0) <= hit.point) and np.all(hit.point <= corners.max(axis=0))


# -- boxes along the axes, by arithmetic ----------------------------------------------------------------------------


def _overlap_time(pieces_a, pieces_b, vector):
    """When, of t >= 0, the insides of two unions of boxes first meet; inf for never."""
    best = np.inf
    for (p, q), (r, s) in itertools.product(pieces_a, pieces_b):
        lo, hi = -np.inf, np.inf
        for k, v in enumerate(vector):
            if v == 0:
                if not (p[k] < s[k] and r[k] < q[k]):
                    lo = np.inf
            else:
                ends = sorted(((r[k] - q[k]) / v, (s[k] - p[k]) / v))
                lo, hi = max(lo, ends[0]), min(hi, ends[1])
        if lo < hi and hi > 0:
            best = min(best, max(lo, 0.0))
    return best


def _strikes(pieces_a, pieces_b, vector, time):
    """Whether at that time a box meets one across the motion."""
    axis = next(k for k in range(3) if vector[k])
    for (p, q), (r, s) in itertools.product(pieces_a, pieces_b):
        p, q = np.array(p) + time * np.array(vector), np.array(q) + time * np.array(vector)
        ahead = q[axis] == r[axis] if vector[axis] > 0 else p[axis] == s[axis]
        if ahead and np.all(p <= s) and np.all(r <= q):
            return True
    return False


@pytest.mark.share(3)
@pytest.mark.parametrize("seed", range(3))
def test_boxes_never_overlap_before_a_new_contact(seed):
    """Boxes of whole numbers, so that many touch; as solids, and one by one as meshes."""
    rng = np.random.default_rng(seed)

    def boxes(n, lo, hi):
        corners = rng.integers(lo, hi, (n, 3))
        return [(p.tolist(), (p + rng.integers(1, 4, 3)).tolist()) for p in corners]

    vector = [0, 0, 0]
    vector[rng.integers(3)] = int(rng.choice([-8, 8]))
    pieces_a, pieces_b = boxes(2, 0, 3), boxes(2, -3, 6)
    a, b = (block(*pieces[0], solid=True) | block(*pieces[1], solid=True) for pieces in (pieces_a, pieces_b))
    questions = [(a, b, pieces_a, pieces_b)]
    questions += [(block(*x), block(*y), [x], [y]) for x, y in itertools.product(pieces_a, pieces_b)]
    for x, y, of_x, of_y in questions:
        hit = fc.first_new_contact(x.moving(Translation(vector)), y)
        overlap = _overlap_time(of_x, of_y, vector)
        if hit.status is Status.INITIAL_CONTACT:
            assert hit.initial in ("overlapping", "containment") and overlap == 0.0
            continue
        assert hit.status is not Status.UNDECIDED
        until = 1.0 if hit.status is Status.FREE else hit.time
        assert overlap >= until
        if hit.status is Status.CONTACT:
            assert _strikes(of_x, of_y, vector, hit.time)


def _joined(*boxes, solid, name=None):
    """One body of boxes (lo, hi) that are apart."""
    parts = [block(lo, hi, solid=solid) for lo, hi in boxes]
    if solid:
        return functools.reduce(operator.or_, parts).named(name or "body")
    faces = [(part.triangles + 8 * k).tolist() for k, part in enumerate(parts)]
    return fc.Polyhedron(np.concatenate([part.vertices for part in parts]), sum(faces, []), name=name)


@pytest.mark.share(2)
@pytest.mark.parametrize("solid", [False, True])
def test_sliding_on_to_the_next_board_in_one_plane_is_no_new_contact(solid):
    """In the plane x = 0 all that either body holds is on its own side at all times."""
    make = functools.partial(_joined, solid=solid)
    boards = make(([-1, 0, 0], [0, 1, 1]), ([-1, 3, 0], [0, 4, 1]))
    cube = make(([0, 0, 0], [1, 1, 1]))
    assert fc.first_new_contact(cube.moving(Translation((0, 8, 0))), boards).status is Status.FREE
    assert fc.first_new_contact(boards.moving(Translation((0, -8, 0))), cube).status is Status.FREE
    plank = make(([0, 0, 0], [1, 4, 1]))  # never off the boards, over a slot
    assert fc.first_new_contact(plank.moving(Translation((0, -2, 0))), boards).status is Status.FREE
    higher = make(([-1, 0, 0], [0, 1, 1]), ([-1, 3, 0], ["1/2", 4, 1]))
    assert fc.first_new_contact(cube.moving(Translation((0, 8, 0))), higher).time == 0.25
    shelf = make(([-1, 0, 0], [0, 1, 1]), ([0, 3, 0], [1, 4, 1]))  # in that plane too, but beyond it
    assert fc.first_new_contact(cube.moving(Translation((0, 8, 0))), shelf).time == 0.25
    hook = make(([0, 0, 0], [1, 1, 1]), ([-1, -3, 5], [0, -2, 6]))  # its second block on the other side of the plane
    hung = make(([-1, 0, 0], [0, 1, 1]), ([0, 0, 5], [1, 1, 6]))  # where the second one of this is, too
    assert fc.first_new_contact(hook.moving(Translation((0, 5, 0))), hung).time == 0.4


def _of_cells(*boxes):
    """The boundary of unit cells, a square for each side: corners of whole numbers (lo, hi) of boxes of them."""
    cells = {cell for lo, hi in boxes for cell in itertools.product(*map(range, lo, hi))}
    corners, faces = {}, []
    for cell, axis, side in itertools.product(sorted(cells), range(3), (0, 1)):
        x, y, z = np.eye(3, dtype=int)[[axis, (axis + 1) % 3, (axis + 2) % 3]]
        if tuple(np.add(cell, x if side else -x).tolist()) not in cells:
            square = [tuple((cell + side * x + p).tolist()) for p in (0 * y, y, y + z, z)]
            faces.append([corners.setdefault(p, len(corners)) for p in (square if side else square[::-1])])
    return fc.Polyhedron(list(corners), faces)


@pytest.mark.thorough
def test_what_may_overlap_at_the_start_is_open_where_only_a_touch_is_allowed():
    """A can on a mesh that reaches beyond the plane in which they touch, far away: nothing tells how they lie."""
    ground = _of_cells(([0, 0, 0], [3, 1, 2]), ([2, 4, 0], [6, 8, 1]))
    along = Translation((0, 4, 0))
    hit = fc.first_new_contact(fc.cylinder(2, 3).translated((4, 6, "5/2")).moving(along), ground)
    assert (hit.status, hit.initial, hit.allowed) == (Status.INITIAL_CONTACT, None, None)
    by_touch, by_name = let_pass(hit, Rule(touching=True)), let_pass(hit, Rule("a", "b"))
    assert (by_touch.status, by_touch.reason, by_touch.free_until) == (Status.UNDECIDED, "contact", 0.0)
    assert by_name.status is Status.INITIAL_CONTACT and by_name.allowed.startswith("in contact at the start")
    for box in (_of_cells(([2, 4, 1], [6, 8, 2])), fc.box((4, 4, 1)).translated((4, 6, "3/2"))):
        flat = fc.first_new_contact(box.moving(along), ground)
        assert flat.status is Status.FREE and flat.allowed == "touching at the start"
