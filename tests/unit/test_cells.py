"""The polynomials of a curved motion for the kernels: their errors, and what boxes and elements make of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb, fmpq
from scipy.spatial.transform import Rotation

import firstcontact as fc
from amount import amount
from curved import pose, random_body, rational_turn
from firstcontact.contact.polyhedra.problems.enclosed_problem import corners_as_doubles
from firstcontact.contact.polyhedra.problems.problem import problem_of
from firstcontact.kernels.verdict import CERTAIN, NONE
from firstcontact.motion.linkage import Drive, Linkage
from firstcontact.motion.relative import cells
from firstcontact.motion.relative.balls_apart import Ball, are_apart, turn_apart
from firstcontact.motion.relative.curved import terms
from firstcontact.motion.relative.pieces import pieces
from firstcontact.motion.span import common_span
from firstcontact.search.trees import curve

BODY = fc.examples.box((1, 1, 1))


def linkage(values):
    """Joints of three kinds, one after the other, by polynomials of the time."""
    kinds = [fc.Rotation((0, 0, 1), degrees=1), fc.Rotation((1, 2, 2), (1, 0, 0), degrees=1),
             fc.Screw((0, 1, 0), (2, 0, 1), degrees=1, advance="1/90")]  # fmt: skip
    rows = [tuple(map(fmpq, value)) for value in values]
    drives = [Drive("", "deg", m, [v]) for m, v in zip(kinds[: len(rows)], rows, strict=True)]
    return Linkage([fmpq(0), fmpq(1)], drives)


MOTIONS = {
    "screw": (fc.Screw((1, 2, -1), (3, 0, 1), degrees=700, advance=4), None),
    "rational": (fc.RationalMotion.between(pose(), pose((0, 1, 2), (1, 2, 3))), None),
    "stretch": (fc.RationalMotion([np.eye(4), np.diag([1.0, 0.5, 0, 1])]), None),
    "both": (fc.Screw((0, 0, 1), turns=1, advance=1), fc.RationalMotion.between(pose(), pose((0, 1, 2), (1, 2, 3)))),
    "long": (rational_turn((3, 4, 12), (1, 0, 0)), None),
    "half": (fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=((1, 0, 0, 0), ("1/1000", 1, 0, 0))), None),
    "after": (fc.Sequence([fc.Rotation((1, 2, 2), radians=1), fc.Screw((0, 3, 1), (1, 0, 0), radians=-2, advance=1)]),
              None),
    "steps": (fc.Sequence([fc.Rotation((1, 2, 2), radians=1), fc.RationalMotion.between(pose(), pose((1, 0, 1)))]),
              fc.Rotation((1, 0, 1), (0, 2, 0), turns=3)),
    "deforming": (fc.Translation((1, 2, 3)), fc.RationalMotion([np.eye(4), np.diag([1.0, 0.5, -0.25, 1])])),
    "mirror": (fc.RationalMotion([np.diag([-1.0, 1, 1, 1]), np.diag([0.5, 0.5, 0, 0])]),
               fc.Screw((0, 0, 1), degrees=50)),
    "slight": (fc.Screw((1, 2, -1), (3e15, 0, 1), radians=2.0**-49, advance=4), None),
    "both slight": (fc.Screw((1, 2, -1), (300, 0, 1), radians=2.0**-7, advance=4),
                    fc.Sequence([fc.Rotation((1, 2, 2), radians=1), fc.Rotation((0, 0, 1), (0, 1e6, 0), turns=1e-6)])),
    "distant": (fc.Screw((1, 2, -1), (3e9, 0, 1), degrees=7, advance=4), None),
    "many turns": (fc.Screw((1, 2, -1), (1, 0, 1), turns=300, advance=4), None),
    "links": (linkage([(0, 70), (20, -140), (5, 30, -200, 90)]), None),
    "two links": (linkage([(10, 30), (0, -50), (0, 0, 3)]), linkage([(0, -45), (7, 7, 0, -20)])),
}


def piece_of(name: str):
    """The last piece of the motion."""
    motion, other = MOTIONS[name]
    a, b = BODY.moving(motion), BODY if other is None else BODY.moving(other)
    return pieces(a, b, *common_span(a, b, None))[-1]


@pytest.mark.share(2)
@pytest.mark.parametrize("name", MOTIONS)
def test_every_row_is_within_its_error(name):
    piece = piece_of(name)
    array = cells.cells_of(piece, 1.0, 1.0)
    levels = int(array[0, cells.ERRORS, cells.LEVELS])
    rng = np.random.default_rng(0)
    for index in (0, 2, 2**levels - 1, 2 ** (levels + 1) - 2):
        if index > 2 ** (levels + 1) - 2 or not np.isfinite(array[index, cells.ERRORS]).all():
            continue
        level = int(math.log2(index + 1))
        for share in (0.0, 1.0, *rng.uniform(0, 1, 3)):
            s = fmpq(*float(share).as_integer_ratio())
            t = piece.start + (piece.end - piece.start) * (index + 1 - 2**level + s) / 2**level
            with terms(1, 200):
                truth = [f[0] for f in cells._functions(piece, arb(t))]
                for row, value in enumerate(truth):
                    basis = [math.comb(7, k) * s**k * (1 - s) ** (7 - k) for k in range(8)]
                    numbers = [fmpq(*float(c).as_integer_ratio()) for c in array[index, row]]
                    found = sum((b * c for b, c in zip(basis, numbers, strict=True)), fmpq(0))
                    group = max(k for k, (first, _) in enumerate(cells._GROUPS) if first <= row)
                    assert abs(value - found) <= arb(float(array[index, cells.ERRORS, group])), (index, row)
                    assert abs(value) <= arb(float(array[index, cells.ERRORS + 1, group]))


def test_doubles_write_the_cells_but_where_their_rounding_is_too_much():
    wrote = {name for name in MOTIONS if cells._in_doubles(piece_of(name), 1.0, 1.0) is not None}
    assert wrote == set(MOTIONS) - {"many turns"}


@pytest.mark.share(3)
@pytest.mark.parametrize("name", MOTIONS)
def test_balls_that_are_apart(name):
    """Sampled centres stay in their boxes, so that balls told apart are so at all sampled times."""
    piece = piece_of(name)
    rng = np.random.default_rng(4)
    told = 0
    times = [piece.start + (piece.end - piece.start) * k / 40 for k in range(41)]
    poses = []
    for leg in (piece.leg_a, piece.leg_b):
        with terms(1, 200):
            poses.append([np.array([[float(x[0]) for x in row] for row in leg.series(arb(t))]) for t in times])
    for k in range(60):
        centres, radii = rng.normal(size=(2, 3)) * 10.0 ** rng.integers(-1, 3), rng.uniform(0, 1, 2)
        pair = [Ball(tuple(c), r) for c, r in zip(centres, radii, strict=True)]
        if not are_apart(piece, *pair):
            continue
        told += 1
        rim = rng.normal(size=(8, 3))
        rim /= np.linalg.norm(rim, axis=1)[:, None]
        for m, n in zip(*poses, strict=True):
            x, y = ((np.array(c) + r * rim) @ q[:, :3].T + q[:, 3] for (c, r), q in zip(pair, (m, n), strict=True))
            lo_x, hi_x, lo_y, hi_y = x.min(axis=0), x.max(axis=0), y.min(axis=0), y.max(axis=0)
            assert (lo_x > hi_y).any() or (lo_y > hi_x).any(), k
    assert told or name in ("distant", "many turns", "half", "links", "two links")


def test_balls_are_apart_through_a_turn_just_where_sampled_places_are():
    """By SciPy's rotations: the gap over a turn is that of the nearest of many places, and of no other motion."""
    rng = np.random.default_rng(5)
    told = {True: 0, False: 0}
    for k in range(300):
        axis, point = rng.integers(-3, 4, 3), rng.integers(-5, 6, 3)
        if not axis.any():
            continue
        centres = rng.normal(size=(2, 3)) * 10.0 ** rng.integers(-1, 2)
        if k % 10 == 0:
            centres[1] = centres[0] * (-1.0) ** k  # from where it starts
        radians, turns = fmpq(int(rng.integers(-9, 10)), 4), fmpq(int(rng.integers(-3, 4)), 7 if k % 3 else 2)
        angles = (float(radians) + 2 * np.pi * float(turns)) * np.linspace(0, 1, 20001)
        turned = Rotation.from_rotvec(angles[:, None] * (axis / np.linalg.norm(axis)))
        gap = np.linalg.norm(turned.apply(centres[0] - point) + point - centres[1], axis=1).min()
        if gap < 5.0 * abs(angles[1]) * np.linalg.norm(centres[0] - point):
            continue  # too near to tell from places so far from each other
        for share in (0.4, 0.49, 0.50001, 0.6):
            a, b = (Ball(tuple(c.tolist()), share * gap) for c in centres)
            exact = [tuple(fmpq(int(x)) for x in v) for v in (axis, point)]
            found = turn_apart(*exact, (radians, turns), a, b)
            assert found == (share < 0.5), (k, share)
            told[found] += 1
    assert min(told.values()) > 400


@pytest.mark.share(16)
@pytest.mark.parametrize("name", MOTIONS)
def test_boxes_are_apart_until_they_are_said_to_meet(name):
    piece = piece_of(name)
    array = cells.cells_of(piece, 3.0, 3.0)
    length = float(piece.end - piece.start)
    rng = np.random.default_rng(1)
    corners = np.array([[x, y, z] for x in (0, 3) for y in (1, 4) for z in (2, 5)])
    waits = 0
    for _ in range(amount(100, 2)):
        middles, halves = rng.normal(size=(2, 3)), rng.uniform(0, 0.5, (2, 3))
        box_a, box_b = (np.concatenate([c - h, c + h])[None] for c, h in zip(middles, halves, strict=True))
        time, cell = curve.next_meeting(array, box_a, 0, box_b, 0, 0.0, 0.0, length)
        waits += 0 < time < length
        for t in np.linspace(0, min(time, length), 30, endpoint=cell < 0) if time > 0 else ():
            with terms(1, 64):
                m = np.array([[float(x[0]) for x in row] for row in piece.series(arb(piece.start) + float(t))])
            points = rng.uniform(size=(64, 3)) * (box_a[0, 3:] - box_a[0, :3]) + box_a[0, :3]
            points = np.vstack([points, np.array([box_a[0][c] for c in corners])]) @ m[:, :3].T + m[:, 3]
            assert not np.any(np.all((points > box_b[0, :3] + 1e-9) & (points < box_b[0, 3:] - 1e-9), axis=1))
    assert waits or name in ("distant", "many turns")


@pytest.mark.parametrize("generic", [False, True], ids=["degenerate", "random"])
def test_elements_seen_by_floats_and_exactly(generic):
    """NONE: the exact face finds none; CERTAIN: its first contact lies in the interval; UNSURE: not before it."""
    verdicts = {0: 0, 1: 0, 2: 0}
    for seed in range(amount(40, 3)):
        rng = np.random.default_rng([3, seed])
        a, b = random_body(rng, generic), random_body(rng, generic)
        motion = rational_turn(*[((0, 0, 1), (1, 0, 0)), ((1, 2, 2), (0, 0.5, 0))][seed % 2])
        moving = a.moving(motion)
        problem = problem_of(moving, b, pieces(moving, b, *common_span(moving, b, None))[0])
        for _ in range(40):
            pair = _random_pair(rng, a, b)
            if pair is None:
                continue
            kind, x, y = pair
            exact = problem.contact(x, y)
            nine = [corners_as_doubles(body, e) for body, e in ((a, x), (b, y))]
            verdict, lo, hi = curve.pair_window(problem.motion, kind, *nine, 0.0, 0.0, 0.0, 1.0)
            verdicts[verdict] += 1
            if verdict == NONE:
                assert exact is None, (seed, pair)
            elif exact is not None:
                t = exact.bounds()
                assert lo <= t[1] and (verdict != CERTAIN or t[0] <= hi), (seed, pair)
            else:
                assert verdict != CERTAIN, (seed, pair)
    assert verdicts[NONE] and (verdicts[CERTAIN] if generic else verdicts[2])


def _random_pair(rng, a, b):
    kind = int(rng.integers(3))
    counts_a = len(a.vertices), len(a.edges), len(a.triangles)
    counts_b = len(b.triangles), len(b.edges), len(b.vertices)
    sizes = counts_a[kind], counts_b[kind]
    if 0 in sizes:
        return None
    kinds = [(0, 2), (1, 1), (2, 0)][kind]
    return kind, (kinds[0], int(rng.integers(sizes[0]))), (kinds[1], int(rng.integers(sizes[1])))
