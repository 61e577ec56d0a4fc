"""Curves certified in doubles, with exact arithmetic only where these leave places open, against the exact path."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.curves.certified.cut_out import ROOM, cut_about
from polylines import distance, told_twice
from ruled_vectors import vectors

TOLERANCE = 1e-3
CIRCLE = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"
# Of the conoid, whose rulings turn round at u = infinity, whole rulings are refused.
REFUSED = "s07_plucker_conoid_plane"
STATIC = [x for x in vectors("static_full", "static_box") if x.name != REFUSED]
# Pairs of pieces that exact arithmetic may be asked for; of others none.
ASKED = {"s01": 1, "s02": 1, "s05": 1, "s06": 1, "s09": 1, "s10": 2, "s12": 1, "s16": 1, "b01": 1, "b03": 1,
         "b04": 1, "b06": 1, "b08": 1}  # fmt: skip


def within(points: np.ndarray, box: np.ndarray | None) -> np.ndarray:
    return points if box is None else points[(np.abs(points) <= 0.5 * box[1]).all(1)]


def sorted_points(points) -> np.ndarray:
    return np.array(sorted(np.round(x, 9).tolist() for x in points)).reshape(-1, 3)


@pytest.mark.share(6)
@pytest.mark.parametrize("case", STATIC, ids=str)
def test_both_paths_give_the_vectors(case):
    """All that the exact path finds, within the box in which curves of whole rulings are looked for."""
    found = fc.intersection_curve(case.p, case.q, tolerance=TOLERANCE, method="certified")
    known = fc.intersection_curve(case.p, case.q, tolerance=TOLERANCE, method="algebraic")
    assert not found.open_places and found.two_dimensional == known.two_dimensional
    assert not told_twice(found) and not told_twice(known)
    assert found.stats.exact_evaluations == ASKED.get(case.name[:3], 0)
    assert not found.stats.exact_evaluations or found.stats.node_visits > 0
    assert (found.box is None) == (case.kind == "static_box")
    near = [b for b in known.branches if len(within(b.points, found.box))]
    assert sorted(b.closed for b in found.branches) == sorted(b.closed for b in near)
    for branches, others in ((found.branches, known.branches), (near, found.branches)):
        for branch in branches:
            points = within(branch.points, found.box)
            assert distance(points[:: max(1, len(points) // 40)], others) <= 2.5 * TOLERANCE
    assert sorted_points(found.isolated_points) == pytest.approx(sorted_points(known.isolated_points), abs=1e-9)
    for kind in ("node", "cusp"):
        points = (sorted_points([x.point for x in c.singular_points if x.kind == kind]) for c in (found, known))
        assert next(points) == pytest.approx(next(points), abs=1e-9)
    assert len(found.overlap_lines) == len(known.overlap_lines)
    for line in known.overlap_lines:
        assert min(abs(np.cross(x[1] - x[0], y - x[0])).max() for x in found.overlap_lines for y in line) < 1e-9


def test_both_paths_give_example_4():
    """The first and the last instant at which the roller of the vector m01 and the pipe touch are -+ sqrt(1/2)."""
    (case,) = (x for x in vectors("moving") if x.name.startswith("m01"))
    hits = [fc.first_contact(case.p, case.q, (-2, 2), method=method) for method in ("certified", "algebraic")]
    proved, exact = (hit.time_interval for hit in hits)
    assert proved[0] <= exact[1] and exact[0] <= proved[1] and proved[1] - proved[0] < 1e-9
    assert proved[0] <= -(0.5**0.5) + 1e-15 and -(0.5**0.5) - 1e-15 <= proved[1]


def test_curves_of_whole_rulings_end_at_infinity_and_tell_their_box():
    """x y = 1/2 at the height 1/2: both branches go on in both directions."""
    saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", u=None, s=None)
    level = fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)", u=None, s=None)
    found = fc.intersection_curve(saddle, level, tolerance=TOLERANCE, method="certified")
    assert found.box.tolist() == [[-10] * 3, [10] * 3] and "box" in found.to_dict()
    for branch in found.branches:
        x, y, z = branch.points.T
        assert np.abs(x * y - 0.5).max() < 1e-13 and np.abs(z - 0.5).max() < 1e-14
        assert [(end.kind, end.on) for end in branch.ends] == [("infinity", ())] * 2
        assert all(np.abs(end.point).max() > 10 for end in branch.ends)
    assert [node.point for node in found.graph.nodes if node.kind == "infinity"] == [None] * 4


def test_a_bounded_piece_tells_how_far_whole_rulings_are_looked_at():
    """Nothing is left out then: x y = 1/2 in a square far from the directrices of the saddle."""
    saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", u=None, s=None)
    square = fc.RuledSurface("(u, -2000, 1/2)", "(u, -1000, 1/2)", u=(-1, 1))
    (branch,) = fc.intersection_curve(square, saddle, tolerance=TOLERANCE, method="certified").branches
    assert sorted(end.on for end in branch.ends) == [("s=0",), ("s=1",)]
    assert sorted(end.point[0] for end in branch.ends) == pytest.approx([-1 / 2000, -1 / 4000], rel=1e-9)


@pytest.mark.parametrize("ends", [("(u, u**2, 0)", "(u, u**2, 1)"), ("(u, u**2, 1/u**2)", "(u, u**2, -1)")])
def test_whole_rulings_come_near_twice(ends):
    """y = x^2 near (0, 50, 0) has two parts; between them rulings, one with a pole, are far away."""
    wall = fc.RuledSurface(*ends, u=(-9, 9), s=None)
    square = fc.RuledSurface("(u, 45, u/99)", "(u, 55, u/99)", u=(-9, 9))
    found = fc.intersection_curve(wall, square, tolerance=TOLERANCE, method="certified")
    assert sorted(np.sign(b.points[0, 0]) for b in found.branches) == [-1, 1] and found.box is None
    for branch in found.branches:
        assert sorted(abs(end.point[0]) for end in branch.ends) == pytest.approx([45**0.5, 55**0.5])


def test_both_halves_of_a_ruling_are_kept():
    """The ruling u = 0 lies on both surfaces, and the rest of the curve meets it twice; infinity is in one half."""
    below = "u**2 + u + 1"
    first = f"((2*u**2 - 2*u - 1)/({below}), (u - u**2)/({below}), (u - 2*u**2 - 2)/({below}))"
    p = fc.RuledSurface(first, "(1/(2*u**2 + 1), (2*u**2 + 2)/(2*u**2 + 1), -u/(2*u**2 + 1))", u=None, s=None)
    below = "u**2 + 1"
    q = fc.RuledSurface(f"(2/({below}), (u - 1)**2/({below}), (1 - u**2)/({below}))",
                        f"((1 - u**2)/({below}), (2*u**2 - 2*u + 2)/({below}), -2*u**2/({below}))",
                        u=None, s=None)  # fmt: skip
    curves = [fc.intersection_curve(p, q, tolerance=TOLERANCE, method=m) for m in ("algebraic", "certified")]
    along = [[x.length for x in c.branches if np.ptp(x.parameters[:, 0]) < 1e-9] for c in curves]
    assert len(along[0]) == 2 and sorted(along[1]) == pytest.approx(sorted(along[0]))
    assert [len(c.branches) for c in curves] == [4, 4]


@pytest.mark.parametrize("start", ["u", "(u-1)/(u+1)"], ids=["at 0 and infinity", "at -1 and 1"])
def test_equal_pipes_cross_in_two_points(start):
    """One of them may be the ruling at infinity: then the surfaces are not cut there."""
    x, y = (c.replace("u", f"({start})") for c in CIRCLE.split(", "))
    upright = fc.RuledSurface(f"({x}, {y}, -2)", f"({x}, {y}, 2)", u=None)
    lying = fc.RuledSurface(f"({x}, -2, {y})", f"({x}, 2, {y})", u=None)
    found = fc.intersection_curve(upright, lying, tolerance=TOLERANCE, method="certified")
    assert sorted_points([x.point for x in found.singular_points]).tolist() == [[-1, 0, 0], [1, 0, 0]]
    assert len(found.branches) == 4 and not found.open_places
    assert {end.kind for branch in found.branches for end in branch.ends} == {"node"}
    assert found.stats.exact_evaluations == (1 if start == "u" else 2)


def test_surfaces_are_cut_about_places():
    """The places lie inside of pieces, with room; the rest of a closed surface runs through infinity."""
    piece = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", u=(2, 4))
    ends = [x.u for x in cut_about(piece, [(2.5, 2.5), (2.51, 2.52), (2.0, 2.0)]).pieces]
    assert ends[0][0] == 2 and ends[-1][1] == 4 and all(a[1] == b[0] for a, b in zip(ends, ends[1:], strict=False))
    assert [(round(float(a), 2), round(float(b), 2)) for a, b in ends] == [
        (2, 2 + 2 * ROOM // 0.01 / 100), (2.06, 2.44), (2.44, 2.58), (2.58, 4)]  # fmt: skip
    closed = fc.RuledSurface(f"({CIRCLE}, 0)", f"({CIRCLE}, 1)", u=None)
    (inner, rest) = (x.u for x in cut_about(closed, [(1.0, 1.0)]).pieces)
    assert inner[0] < 1 < inner[1] and rest == inner[::-1]
    assert cut_about(closed, [(-1e9, -1e9)]) is closed


def test_no_piece_of_a_cut_surface_is_a_ruling():
    """A cut next to an end was rounded to it, and the piece between them taken for one that passes infinity."""
    piece = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", u=(0, Fraction(1, 3)))
    for place in ((0.010416666666666666, 0.32291666666666663), (1 / 96, 0.1), (0.1, 0.3)):
        ends = [x.u for x in cut_about(piece, [place]).pieces]
        assert ends[0][0] == 0 and ends[-1][1] == Fraction(1, 3) and all(lo < hi for lo, hi in ends)
