"""Unions of upright solids on a screw along them: against rectangles, discs and heights at many times, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc

CORNER = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)]
"""An L, that of the rectangles [0, 4] x [0, 1] and [0, 1] x [0, 4], from -1 to 1."""


def bracket(at, as_mesh):
    if not as_mesh:
        long, wide = fc.box((4, 1, 2)).translated((2, 0.5, 0)), fc.box((1, 4, 2)).translated((0.5, 2, 0))
        return (long | wide).translated((*at, 0))
    walls = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    corners = [(x, y, z) for z in (-1, 1) for x, y in CORNER]
    return fc.Polyhedron(corners, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *walls]).translated((*at, 0))


def tool(at):
    """A plate of 4 by 2 by 1 with a round stud of radius 1 on it, from -1/2 to 1/2 and on to 2."""
    return (fc.box((4, 2, 1)) | fc.cylinder(1, 2).translated((0, 0, 1))).translated(at)


def clip_gap(corners, low, high):
    """How far a rectangle of these corners is from one along the axes, along normals of sides: below 0 they overlap."""
    other = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])
    normals = [np.array([-e[1], e[0]]) / np.hypot(*e) for c in (corners, other) for e in np.diff(c[:3], axis=0)]
    return max(max((other @ n).min() - (corners @ n).max(), (corners @ n).min() - (other @ n).max()) for n in normals)


def gap(at, place, degrees, advance, t):
    """Above 0 the tool and the bracket are apart, below they overlap."""
    c, s = np.cos(np.radians(degrees * t)), np.sin(np.radians(degrees * t))
    turn = np.array([[c, -s], [s, c]])
    plate = (np.array([(-2, -1), (2, -1), (2, 1), (-2, 1)]) + at[:2]) @ turn.T
    stud, z = turn @ np.array(at[:2], float), at[2] + advance * t
    gaps = []
    for low, high in (((0, 0), (4, 1)), ((0, 0), (1, 4))):
        low, high = np.add(low, place), np.add(high, place)
        gaps.append(max(clip_gap(plate, low, high), z - 0.5 - 1, -1 - z - 0.5))
        off = np.linalg.norm(stud - np.clip(stud, low, high)) - 1
        gaps.append(max(off, z - 1, -1 - z - 2))
    return min(gaps)


def check(found, gap_at, until=1.0):
    """Bodies meet inside the intervals and nowhere else, as far as that is decided."""
    for t in np.linspace(0, until, 301):
        near = any(abs(t - end) < 1e-6 for x in found for end in (x.start, x.end))
        if not near and abs(gap_at(t)) > 1e-6:
            assert any(x.start <= t <= x.end for x in found) == (gap_at(t) < 0), t


@pytest.mark.share(2)
@pytest.mark.parametrize("as_mesh", [True, False])
def test_an_edge_leaves_exactly_at_an_edge(as_mesh):
    """At atan(3/4) from the start: it took more than 100 s of a mesh, and was UNDECIDED of both."""
    at, place = (-3.5, 3.0, 0.5), (-1, -1.5)
    moving, still = tool(at).moving(fc.Screw((0, 0, 1), degrees=-90, advance=1)), bracket(place, as_mesh)
    for pair in ((moving, still), (still, moving)):
        found = fc.contact_intervals(*pair)
        assert found.status is fc.Status.CONTACT
        check(found, lambda t: gap(at, place, -90, 1, t))
        assert found[-1].end == pytest.approx(np.degrees(np.arctan2(3, 4)) / 90, abs=1e-14)


@pytest.mark.thorough
@pytest.mark.parametrize("as_mesh", [True, False])
@pytest.mark.parametrize("seed", range(2))
def test_lattices(seed, as_mesh):
    r = np.random.default_rng(seed)
    at = (*(r.integers(-8, 9, 2) / 2).tolist(), float(r.integers(-4, 5) / 2))
    place, degrees, advance = r.integers(-4, 5, 2).tolist(), int(r.choice([-90, 90, 180])), int(r.choice([-2, 1, 3]))
    screw = fc.Screw((0, 0, 1), degrees=degrees, advance=advance)
    found = fc.contact_intervals(tool(at).moving(screw), bracket(place, as_mesh))
    decided = found.status is not fc.Status.UNDECIDED
    assert decided or as_mesh  # the stud that grazes a mesh in the last instant is not told
    check(found, lambda t: gap(at, place, degrees, advance, t), 1.0 if decided else found.free_until)


def test_a_solid_as_it_was_put_together():
    parts = fc.box((1, 1, 1)), fc.sphere(1).translated((3, 0, 0)), fc.box((2, 2, 2)) - fc.cylinder(0.5, 4)
    whole = parts[0] | parts[1] | parts[2]
    points = np.random.default_rng(1).uniform(-2, 5, (2000, 3))
    for part, own in zip(whole.united(), parts, strict=True):
        assert np.array_equal(part.contains(points), own.contains(points))
        assert len(part.faces) == len(own.faces)
    assert parts[2].united() == [parts[2]]
