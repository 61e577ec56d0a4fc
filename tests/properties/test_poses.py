"""`motion(t)` is the pose that every search uses, at all times: motions of all classes, of a, of b, of both."""

from __future__ import annotations

from bisect import bisect_right
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from amount import amount
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import precision, to_double
from firstcontact.kernels.poses import pose_at
from firstcontact.kernels.workspace import HERE_A, workspace
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.curved import CurvedPiece, terms
from firstcontact.motion.relative.pieces import curved_pieces, pieces, placement_at
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.relative.stretches import windows
from firstcontact.motion.relative.sweep import swept_box, swept_boxes
from firstcontact.search.events.pose_jets import PoseJet
from firstcontact.search.events.shared_points import ball_pose
from firstcontact.search.rulings.posed_pieces import pose_windows
from firstcontact.view.poses import _twist as twist
from firstcontact.view.poses import sample_poses, screw_between
from poses_by_hand import KINDS, angle_of, axis_of, shift, turn, vector

CUBE = fc.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
POINTS = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
BORDERS = 1e-6  # times nearer to a change of steps tell nothing: at a jump, either pose will do


def made(kind, seed):
    """(body, its pose by hand)."""
    motion, pose = KINDS[kind](np.random.default_rng([seed, sorted(KINDS).index(kind)]))
    return CUBE if motion is None else CUBE.moving(motion), pose


def times(seed, *bodies, count=34):
    rng, ends = np.random.default_rng(seed), [0.0, 1.0]
    for body in bodies:
        ends += [to_double(e) for e in getattr(getattr(body, "motion", None), "ends", ())]
    return [t for t in rng.uniform(0, 1, count) if min(abs(t - e) for e in ends) > BORDERS]


def rows(matrix):
    return np.array([*([float(arb(x).mid()) for x in row] for row in matrix[:3]), [0, 0, 0, 1]])


def same(got, true):
    return np.abs(got - true).max() <= 2e-12 * max(1.0, np.abs(true).max()) ** 2


def of(pieces, t):
    """The one in charge at t."""
    return pieces[max(0, bisect_right(pieces, t, key=lambda p: float(to_double(p.start))) - 1)]


def number(t):
    return fmpq(*t.as_integer_ratio())


# ------------------------------------------------------------------------------------------------ one body


@pytest.mark.share(12)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(amount(30, 10)))
def test_one_body(kind, seed):
    body, truth = made(kind, seed)
    motion = getattr(body, "motion", None)
    work, zero, one = workspace()[0], fmpq(0), fmpq(1)
    stretches = windows(body, CUBE, zero, one)
    for t in times(seed, body):
        true, exact = truth(t), number(t)
        found = {"placement": rows(placement_at(body, exact).matrix())}
        if motion is not None:
            found["motion"] = motion(t)
        with precision(128):
            found["balls"] = rows(ball_pose(body, exact))
        window = next(w for w in stretches if w.first <= t <= w.last)
        pose_at(window.a, t, work, HERE_A)
        entries = work[HERE_A]
        found["stretch"] = np.vstack([np.column_stack([entries[:9].reshape(3, 3), entries[9:12]]), [0, 0, 0, 1]])
        with precision(128):
            value, slope = PoseJet(body, window).at(arb(t))
        found["jet"] = rows([[value[i, j] for j in range(4)] for i in range(3)])
        for name, pose in found.items():
            assert same(pose, true), (name, t)
        h = 1e-7
        rate = (truth(t + h) - truth(t - h)) / (2 * h)
        drift = np.array([[float(slope[i, j].mid()) for j in range(4)] for i in range(4)])
        assert np.allclose(drift, rate, atol=1e-5 * max(1, np.abs(rate).max())), t
        if motion is not None:
            placed = CUBE.translated((1, 2, 3)).rotated((1, 1, 0), degrees=40).moving(motion)
            by_hand = POINTS @ turn((1, 1, 0), (0, 0, 0), np.radians(40))[:3, :3].T
            by_hand += turn((1, 1, 0), (0, 0, 0), np.radians(40))[:3, :3] @ (1, 2, 3)
            by_hand = by_hand @ true[:3, :3].T + true[:3, 3]
            assert np.allclose(placed.at(t).vertices, by_hand, atol=1e-11 * max(1, np.abs(true).max()))
            lo, hi = swept_box(motion, t, t, by_hand[:1], 0.0)
            at = true[:3, :3] @ by_hand[0] + true[:3, 3]
            assert (lo <= at + 1e-12).all() and (at - 1e-12 <= hi).all()
            assert (hi - lo).max() < 1e-9 * (1 + abs(at).max())


# ---------------------------------------------------------------------------------------------- two bodies


def of_fixed_piece(piece, t):
    """World poses of both bodies by a piece that is one translation or one turn."""
    local = t - to_double(piece.reference)
    if piece.velocity is not None:
        moved = shift([to_double(x) * local for x in piece.velocity])
    else:
        radians, turns = map(to_double, piece.rate)
        axis, point = ([to_double(x) for x in v] for v in (piece.axis, piece.point))
        moved = turn(axis, point, (radians + 2 * np.pi * turns) * local)
    carry = piece.carry(t)
    carry = np.eye(4) if carry is None else carry
    with precision(128):
        a, b = rows(piece.place_a.matrix()), rows(piece.place_b.matrix())
    return carry @ moved @ a, carry @ b


def of_curved_piece(piece, t):
    """(a seen from b, b) by power series."""
    with terms(2, 128):
        seen = rows([[entry[0] for entry in row] for row in piece.series(arb(t))])
    carry = piece.carry(t)
    return seen, np.eye(4) if carry is None else carry


def of_polynomial(piece, t):
    """(a seen from b, b) by polynomials."""
    lo, hi = piece.clock.parameters(number(t), number(t))
    u = (lo + hi) / 2
    frame = None if piece.frame is None else rows(projective.value(piece.frame, u))
    return rows(projective.value(piece.pose, u)), frame


PAIRS = [
    *((kind, "rest") for kind in KINDS if kind != "rest"),
    *(("rest", kind) for kind in KINDS if kind != "rest"),
    *((kind, other) for kind, other in zip(KINDS, [*list(KINDS)[5:], *list(KINDS)[:5]], strict=True)),
    ("screw first", "screw first"), ("sequence", "sequence"), ("rotation", "rotation"), ("translation", "sequence"),
]  # fmt: skip


@pytest.mark.share(22)
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("seed", range(amount(20, 10)))
def test_two_bodies(pair, seed):
    (a, pose_a), (b, pose_b) = made(pair[0], seed), made(pair[1], seed + 1000)
    zero, one = fmpq(0), fmpq(1)
    meshes, curved = pieces(a, b, zero, one), curved_pieces(a, b, zero, one)
    try:
        polynomial = list(relative_pieces(a, b, zero, one))
    except UnsupportedPair:
        polynomial = []
    for t in times(seed, a, b, count=34):
        true_a, true_b = pose_a(t), pose_b(t)
        seen = np.linalg.inv(true_b) @ true_a
        slack = max(1.0, np.abs(seen).max(), np.linalg.cond(true_b))
        piece = of(meshes, t)
        if isinstance(piece, CurvedPiece):
            found, carry = of_curved_piece(piece, t)
            if piece.polynomial is not None:
                assert np.allclose(of_polynomial(piece.polynomial, t)[0], seen, atol=1e-11 * slack), (pair, t)
        else:
            own, carry = of_fixed_piece(piece, t)
            assert same(own, true_a) and same(carry, true_b), (pair, t)
        found, carry = of_curved_piece(of(curved, t), t)
        assert np.allclose(found, seen, atol=1e-11 * slack) and same(carry, true_b), (pair, t)
        if polynomial:
            found, frame = of_polynomial(of(polynomial, t), t)
            assert np.allclose(found, seen, atol=1e-11 * slack) and (frame is None or same(frame, true_b)), (pair, t)
    if polynomial == [] and seed == 0:
        check_windows(curved, pose_a, pose_b)


def check_windows(curved, pose_a, pose_b):
    """The polynomials and series of short times in place of poses."""
    for piece in curved:
        for window in pose_windows(piece, piece.start, piece.end):
            x = Fraction(1, 3)
            t = to_double(window.clock(fmpq(1, 3)))
            seen = np.linalg.inv(pose_b(t)) @ pose_a(t)
            slack = max(1.0, np.abs(seen).max(), np.linalg.cond(pose_b(t)))
            by_rows = rows([[p(fmpq(1, 3)) for p in row] for row in window.rows])
            with precision(128):
                value, _ = window.at(arb(fmpq(x.numerator, x.denominator)))
            assert np.allclose(by_rows, seen, atol=1e-11 * slack) and np.allclose(rows(value), seen, atol=1e-11 * slack)


RIGID = ["translation", "rotation", "screw", "between", "quaternions", "screws", "screw first", "screws only"]


@pytest.mark.share(6)
@pytest.mark.parametrize("kind", RIGID)
def test_pictures(kind):
    body, truth = made(kind, 7)
    known, poses = sample_poses(body.motion, [0.0, 1.0], 1.0)
    for t in times(7, body, count=20):
        k = int(np.searchsorted(known, t)) - 1
        part = (t - known[k]) / (known[k + 1] - known[k])
        drawn = screw_between(poses[k], *twist(poses[k], poses[k + 1]), part)
        assert np.abs(drawn - truth(t)).max() < 1e-4 * max(1, np.abs(truth(t)).max()), t


# ------------------------------------------------------------------------------------------- end to end


def two_ways(rng):
    """A last step that leads far away, after one screw, and after its turn and its advance one by one."""
    axis, point = axis_of(rng), vector(rng)
    key, value, radians = angle_of(rng)
    length = int(rng.integers(2, 9))
    way = [int(rng.integers(30, 50)), *vector(rng)[:2]]
    exact = {(0, 0, 1): 1, (1, 0, 0): 1, (-1, 0, 0): 1, (2, -1, 2): 3, (0, -3, 4): 5}
    axis = axis if axis in exact else (0, 0, 1)
    along = [Fraction(length * x, exact[axis]) for x in axis]
    last = fc.Translation(way)
    once = fc.Sequence([fc.Screw(axis, point, **{key: value}, advance=length), last])
    parts = [fc.Rotation(axis, point, **{key: value}), fc.Translation(along), last]
    split = fc.Sequence(parts, ["1/4", "1/4", "1/2"])
    end = shift([float(x) for x in along]) @ turn(axis, point, radians)
    return once, split, end, np.array(way)


BODIES = {
    "mesh": fc.examples.box((1, 2, 3)),
    "solid": fc.cylinder(1, 2),
    "ball": fc.sphere(1),
}


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("seed", range(amount(12, 6)))
def test_a_screw_ends_as_its_turn_and_advance_do(kind, seed):
    rng = np.random.default_rng([seed, 5])
    once, split, end, way = two_ways(rng)
    share = rng.uniform(0.3, 0.6)
    centre = end[:3, 3] + share * way
    for other in ("mesh", "ball"):
        target = BODIES[other].translated(centre.tolist())
        found = [fc.first_contact(BODIES[kind].moving(m), target, (0.5, 1)) for m in (once, split)]
        assert found[0].status == found[1].status, (kind, other)
        if found[0].time is not None:
            assert found[0].time == pytest.approx(found[1].time, abs=1e-9)


@pytest.mark.parametrize("height, status", [(10, fc.Status.CONTACT), (0, fc.Status.FREE)])
def test_the_advance_of_a_screw_holds_in_the_next_step(height, status):
    m = fc.Sequence([fc.Screw((0, 0, 1), turns="1/4", advance=10), fc.Translation((1, 0, 0))])
    hit = fc.first_contact(fc.sphere(1).moving(m), fc.sphere(1).translated(("5/2", 0, height)))
    assert hit.status == status
    assert hit.time == (0.75 if height else None)


def test_a_pose_that_balls_do_not_tell_over_long_times():
    """The weight in balls over all of the span holds zero; upright edges meet an upright sheet: a plane problem."""
    r = fc.RuledSurface("(0, 2*u-1, 1)", "(0, 2*u-1, -1)")
    m = fc.RationalMotion.between((0, 0, 0), (4, 0, 0), quat_xyzw=[(0, 0, 0, 1), (0, 0, 1, 0.2)])
    screw = fc.Screw((0, 0, 1), (3, 0, 0), degrees=70, advance=1)
    hit = fc.first_contact(r.moving(m), r.translated((3, 0, 0)).moving(screw))
    t = np.linspace(0, hit.time, 20001)
    corners = np.array([gap_of_corner(m, screw, x) for x in t[::100]])
    assert hit.status == fc.Status.CONTACT
    assert (corners[:-1] * corners[0] > 0).all() and abs(gap_of_corner(m, screw, hit.time)) < 1e-12


def gap_of_corner(m, screw, t):
    """How far the corner (0, -1) of the sheet of a is off the plane of b's, on the side where it starts."""
    corner = np.linalg.inv(screw(t)) @ m(t) @ (0, -1, 0, 1)
    return corner[0] - 3


@pytest.mark.parametrize("kind", ["shift", "turn", "screw", "between", "sequence"])
def test_boxes_of_many_groups_are_those_of_each(kind):
    motions = {
        "shift": fc.Translation((1, 2, 3)),
        "turn": fc.Rotation((1, 2, 2), (3, 0, 1), degrees=500),
        "screw": fc.Screw((1, 2, 3), (1, 0, 0), radians=2, advance=5),
        "between": fc.RationalMotion.between((1, 0, 0), (0, 5, 0), quat_wxyz=((1, 0, 0, 0), (1, 2, 0, 1))),
        "sequence": fc.Sequence([fc.Translation((1, 0, 0)), fc.Rotation((0, 0, 1), (9, 0, 0), radians=2)]),
    }
    groups = np.random.default_rng(7).uniform(-2, 2, (40, 5, 3))
    lo, hi = swept_boxes(motions[kind], 0.125, 0.875, groups, 1e-3)
    for points, low, high in zip(groups, lo, hi, strict=True):
        alone = swept_box(motions[kind], 0.125, 0.875, points, 1e-3)
        size = 1e-9 + 0.01 * (kind in ("turn", "screw", "sequence"))  # chords are the longest of all groups
        np.testing.assert_allclose((low, high), alone, atol=size)
        for t in np.linspace(0.125, 0.875, 23):
            pose = motions[kind](t)
            moved = points @ pose[:3, :3].T + pose[:3, 3]
            assert np.all(low <= moved) and np.all(moved <= high)
