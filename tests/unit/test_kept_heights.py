"""Heights along an axis about which both bodies turn: against poses written down by hand, at many times."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.exact.numbers import exact_value, precision
from firstcontact.motion.relative.kept_heights import heights_in, times_level
from firstcontact.motion.relative.pieces import curved_pieces
from poses_by_hand import shift, turn

AXIS = 1, 2, 2
UNIT = np.array(AXIS) / 3
TIMES = np.linspace(0.0, 1.0, 41)


def motion_of(r):
    """(motion, its pose): steps that all turn about the axis, or shift."""
    p, q = r.integers(-3, 4, (2, 3)).tolist()
    v, advance = r.integers(-3, 4, 3).tolist(), float(r.choice([-1.5, 0.25, 2.0]))
    degrees = float(r.choice([-200.0, 37.0, 90.0]))
    steps = [fc.Rotation(AXIS, p, degrees=degrees), fc.Screw(AXIS, q, degrees=degrees, advance=advance)]
    angle = np.radians(degrees)
    poses = [lambda s: turn(AXIS, p, s * angle), lambda s: shift(s * advance * UNIT) @ turn(AXIS, q, s * angle)]
    if r.integers(2):
        steps.insert(1, fc.Translation(v))
        poses.insert(1, lambda s: shift(s * np.array(v)))
    n = len(steps)

    def pose(t):
        m = np.eye(4)
        for k, step in enumerate(poses):
            m = step(min(max(n * t - k, 0.0), 1.0)) @ m
        return m

    return fc.Sequence(steps), pose


def scene(seed):
    r = np.random.default_rng(seed)
    (first, pose_a), (second, pose_b) = motion_of(r), motion_of(r)
    points = r.integers(-1, 2, (2, 3, 3))
    a, b = (fc.Polyhedron(x.tolist(), [[0, 1, 2]]).moving(m) for x, m in zip(points, (first, second), strict=True))
    pieces = list(curved_pieces(a, b, fmpq(0), fmpq(1)))
    return pieces, points, pose_a, pose_b


def kept(seed):
    """(piece, its heights, points, poses, times in it) where heights are kept: not where both bodies shift alone."""
    pieces, points, *poses = scene(seed)
    for piece in pieces:
        with precision(128):
            heights = heights_in(piece)
        if heights is not None:
            yield piece, heights, points, poses, TIMES[(float(piece.start) <= TIMES) & (float(piece.end) >= TIMES)]


@pytest.mark.parametrize("seed", range(6))
def test_heights_are_those_of_the_poses(seed):
    for piece, heights, points, poses, times in kept(seed):
        for h, x, pose in zip(heights, points, poses, strict=True):
            for t in times:
                m = pose(t)
                truth = (x @ m[:3, :3].T + m[:3, 3]) @ UNIT
                row, local = np.array([float(c) for c in h.row]), t - float(piece.start)
                own = x @ row + float(h.offset) + float(h.rate) * local
                assert own / np.linalg.norm(row) == pytest.approx(truth, abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_no_height_is_shared_at_other_times(seed):
    for piece, heights, points, poses, times in kept(seed):
        corners = [[tuple(map(fmpq, p)) for p in x.tolist()] for x in points]
        with precision(128):
            level = times_level(heights, corners, fmpq(0), piece.end - piece.start)
        for t in times:
            local = exact_value(float(t)) - piece.start
            placed = [(x, pose(t)) for x, pose in zip(points, poses, strict=True)]
            p, q = ((x @ m[:3, :3].T + m[:3, 3]) @ UNIT for x, m in placed)
            gap = max(q.min() - p.max(), p.min() - q.max())
            if level is None or not level[0] <= local <= level[1]:
                assert gap > -1e-9
            else:
                assert gap < 1e-9


def test_other_motions_keep_no_height():
    box = fc.examples.box((1, 1, 1))
    screw = fc.Screw((0, 0, 1), degrees=40, advance=1)
    for other in (fc.Rotation((1, 0, 0), degrees=10), fc.Sequence([fc.Rotation((1, 0, 0), degrees=10), screw])):
        pieces = list(curved_pieces(box.moving(screw), box.moving(other), fmpq(0), fmpq(1)))
        assert any(heights_in(piece) is None for piece in pieces)


def wire_on_a_plate(lift):
    """A tetrahedron without breadth that hovers 2^-40 above a wide plate, comes down on it in two turns, and leaves.

    lift: of one of its corners, in normals of the plate of length 9.
    """
    down = fc.Screw((4, 8, -1), (F(-74, 9), F(-71, 18), F(68, 9)), turns=F(3, 8), advance=F(1, 2**40) - 3)
    turns = fc.Screw((4, 8, -1), (F(-23, 3), F(-10, 3), F(17, 3)), turns=-2, advance=-F(1, 2**40))
    away = fc.Translation((F(8, 3), F(-2, 3), F(5, 6)))
    corners = [(F(-20, 3), F(-1, 3), F(20, 3)), (F(-130, 9), F(37, 9), F(100, 9)), (F(-95, 9), F(17, 9), F(80, 9)),
               tuple(F(x, 27) + y * lift for x, y in zip((-250, 31, 220), (4, 8, -1), strict=True))]  # fmt: skip
    wire = fc.Polyhedron(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    plate = fc.Polyhedron(
        [(F(56, 3), F(-89, 3), F(-299, 3)), (F(-952, 9), F(373, 9), F(-257, 9)), (F(-104, 3), F(71, 3), F(341, 3)),
         (F(808, 9), F(-427, 9), F(383, 9))], [[0, 1, 2], [0, 2, 3]],
    )  # fmt: skip
    return wire.moving(fc.Sequence([down, turns, away])), plate


@pytest.mark.share(3)
@pytest.mark.parametrize(("lift", "corners"), [(0, 4), (F(1, 2**60), 3), (-F(1, 2**50), 1)])
def test_what_hovers_a_hair_above_a_plate_and_turns_lands_in_time(lift, corners):
    """Edges there lie in one plane with those of the plate, but for 2^-40, for two turns: it took more than 80 s."""
    start = F(2, 3) + min(9 * lift, 0) * 2**40 / 3
    wire, plate = wire_on_a_plate(lift)
    for a, b in ((wire, plate), (plate, wire)):
        hit = fc.first_contact(a, b)
        assert hit.status is fc.Status.CONTACT
        assert hit.time == float(start)
        assert hit.multiplicity >= corners
        found = fc.contact_intervals(a, b, (0, F(2, 3)))
        assert [(x.start, x.end) for x in found] == [(float(start), 2 / 3)]


def test_the_start_of_a_contact_is_told_by_the_double_nearest_to_it():
    """Two corners reach a plate at 1.5 / (1.5 + 2^-50): balls knew it to 38 digits, and it was rounded on the way."""
    tetrahedron = fc.Polyhedron(
        [(F(-4, 3), F(-5, 3), F(3, 2)), (F(-4, 3), F(4, 3), F(-5, 2)), (F(-13, 3), F(-8, 3), F(-5, 2)),
         (F(-1, 3), F(-11, 3), F(-3, 2))], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    )  # fmt: skip
    advance = F(3, 2) + F(1, 2**50)
    screw = fc.Screw((0, 0, -1), (F(-1, 3), F(-8, 3), -4), radians=F(-3, 2), advance=advance)
    plate = fc.examples.box((220, 220, 1)).translated((0, 0, F(-9, 2)))
    (found,) = fc.contact_intervals(tetrahedron.moving(screw), plate)
    assert found.start == float(F(3, 2) / advance)
    assert found.end == 1.0
