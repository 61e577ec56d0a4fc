"""Bare points and edges against solids with holes: where a point goes is a quadratic of the time for each surface."""

from __future__ import annotations

from fractions import Fraction as F
from itertools import pairwise

import numpy as np
import pytest

import firstcontact as fc


def tube(r):
    return np.diag([1.0, 1.0, 0.0, -r * r])


def ball(r):
    return np.diag([1.0, 1.0, 1.0, -r * r])


def aside(x):
    """The tube of radius 1 about a line through (x, 0, 0)."""
    form = tube(1.0)
    form[0, 3] = form[3, 0] = -x
    form[3, 3] += x * x
    return form


def slab(axis, h):
    form = np.zeros((4, 4))
    form[axis, axis], form[3, 3] = 1.0, -h * h
    return form


# (solid, forms of what it is in, forms of what is taken out), negative inside
SOLIDS = {
    "ring": (fc.cylinder(2, 12) - fc.cylinder(1, 20), [tube(2), slab(2, 6)], [tube(1)]),
    "block": (fc.box((5, 5, 5)) - fc.cylinder(1, 20), [slab(0, 2.5), slab(1, 2.5), slab(2, 2.5)], [tube(1)]),
    "bead": (fc.sphere(5) - fc.cylinder(1, 20), [ball(5)], [tube(1)]),
    "pierced aside": (fc.sphere(5) - fc.cylinder(1, 20).translated((1, 0, 0)), [ball(5)], [aside(1.0)]),
    "shell": (fc.sphere(4) - fc.sphere(3), [ball(4)], [ball(3)]),
    "bowl": (fc.box((8, 8, 6)) - fc.sphere("5/2"), [slab(0, 4), slab(1, 4), slab(2, 3)], [ball(2.5)]),
}  # fmt: skip


def first_time(p, v, within, out):
    """When p + t v, 0 <= t <= 1, is first in all of `within` and not inside all of `out`; None if never."""
    x, w = np.append(p, 1.0), np.append(v, 0.0)
    cuts = [0.0, 1.0]
    for m in (*within, *out):
        roots = np.roots([w @ m @ w, 2 * (w @ m @ x), x @ m @ x])
        cuts += [float(t.real) for t in roots if abs(t.imag) < 1e-14 and 0 < t.real < 1]
    for lo, hi in pairwise(sorted(cuts)):
        y = x + 0.5 * (lo + hi) * w
        if all(y @ m @ y < 0 for m in within) and not all(y @ m @ y < 0 for m in out):
            return lo
    return None


def eighths(rng, size):
    return rng.integers(-8 * size, 8 * size + 1, 3) / 8


@pytest.mark.share(4)
@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("seed", range(6))
def test_points(name, seed):
    rng = np.random.default_rng([seed, len(name)])
    solid, within, out = SOLIDS[name]
    p, v = eighths(rng, 7 if seed % 2 else 1), eighths(rng, 12)
    point = fc.Polyhedron([tuple(p)], [])
    expected = first_time(p, v, within, out)
    exact = seed == 0
    hits = [fc.first_contact(point.moving(fc.Translation(tuple(v))), solid, exact=exact),
            fc.first_contact(solid.moving(fc.Translation(tuple(-v))), point, exact=exact)]  # fmt: skip
    for k, hit in enumerate(hits):
        if expected is None:
            assert hit.status is fc.Status.FREE
        elif expected == 0.0:
            assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "containment"
        else:
            assert hit.status is fc.Status.CONTACT and abs(hit.time - expected) < 1e-9
            assert np.allclose(hit.point, p + hit.time * v if k == 0 else p, atol=1e-8)
            assert (hit.element_a, hit.element_b)[k].kind == "vertex"


@pytest.mark.share(8)
@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("seed", range(3))
def test_edges_and_open_triangles(name, seed):
    """Not later than any of many points of an edge, and where told both bodies are."""
    rng = np.random.default_rng([seed, len(name), 1])
    solid, within, out = SOLIDS[name]
    p, v = eighths(rng, 7 if seed % 2 else 1), eighths(rng, 12)
    q = p + eighths(rng, 1)
    edge = fc.Polyhedron([tuple(p), tuple(q)], [], edges=[[0, 1]])
    hit = fc.first_contact(edge.moving(fc.Translation(tuple(v))), solid)
    times = [first_time(p + s * (q - p), v, within, out) for s in np.linspace(0, 1, 401)]
    known = [t for t in times if t is not None]
    open_mesh = fc.Polyhedron([tuple(p), tuple(q), tuple(p + 0.25 * v[[1, 2, 0]])], [[0, 1, 2]])
    swept = fc.first_contact(open_mesh.moving(fc.Translation(tuple(v))), solid)
    assert hit.status is not fc.Status.UNDECIDED and swept.status is not fc.Status.UNDECIDED
    assert swept.free_until <= hit.free_until + 1e-9
    if known:
        assert hit.status is not fc.Status.FREE and hit.time <= min(known) + 1e-9
    if hit.status is fc.Status.CONTACT:
        y = hit.point - hit.time * v - p
        s = y @ (q - p) / ((q - p) @ (q - p))
        assert -1e-9 <= s <= 1 + 1e-9 and np.allclose(y, s * (q - p), atol=1e-8)
        assert max(abs(first_time(y + p, v, within, out) - hit.time), 0) < 1e-6
        assert hit.time > min(known) - 0.05


def test_the_places_reported():
    ring = fc.cylinder(2, 12) - fc.cylinder(1, 20)
    for solid, p, v, time in (
        (ring, (1, -5, 1), (1, 7, 1), 0.53033370452904),
        (ring, (0.25, 0.125, 5), (0.7, 3, -1), 0.259062547),
        (fc.box((5, 5, 5)) - fc.cylinder(1, 20), (1, -5, 1), (1, 7, 1), 5 / 14),
        (fc.sphere(5) - fc.cylinder(1, 20), (1, -8, 1), (1, 7, 1), 0.495631113),
    ):
        hit = fc.first_contact(fc.Polyhedron([p], []).moving(fc.Translation(v)), solid)
        assert hit.status is fc.Status.CONTACT and abs(hit.time - time) < 1e-6


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", ["point", "edge"])
def test_grazes_and_misses_by_next_to_nothing(kind):
    """Past the outside of the ring along a tangent, and past its top; far below doubles."""
    tiny = F(1, 10**25)
    ring = fc.cylinder(2, 12) - fc.cylinder(1, 20)

    def ask(p):
        corners, edges = ([p], None) if kind == "point" else ([p, (p[0], p[1], p[2] + 1)], [[0, 1]])
        return fc.first_contact(fc.Polyhedron(corners, [], edges=edges).moving(fc.Translation((0, 6, 0))), ring)

    for gap in (F(0), tiny, -tiny):
        side, top = ask((2 + gap, -3, 0)), ask((F(3, 2), -3, 6 + gap))
        assert (side.status is fc.Status.FREE) == (top.status is fc.Status.FREE) == (gap > 0)
        if gap <= 0:
            assert abs(side.time - 0.5) < 1e-9 and abs(top.time - (3 - np.sqrt(1.75)) / 6) < 1e-9


@pytest.mark.share(3)
@pytest.mark.parametrize("tilt", [F(0), F(1, 2**53), F(-1, 2**40)])
def test_a_rod_with_a_bore_that_is_across_but_for_rounding(tilt):
    """As files have bores: the square of the tilt is all that the form says along the axis."""
    k = tilt
    bore = fc.quadric([[1 + k * k, 0, 0, 0], [0, k * k, -k, 0], [0, -k, 1, 0], [0, 0, 0, -1 - k * k]])
    rod = fc.cylinder(F(3, 2), 6) - (bore & fc.half_space((0, 1, 0), 4) & fc.half_space((0, -1, 0), 4))
    for probe in (
        fc.Polyhedron([(5, 0, 0)], []), fc.Polyhedron([(5, 0, 0), (5, 1, 0), (5, 0, 1)], [[0, 1, 2]]),
        fc.box((2, 2, 2)).translated((6, 0, 0)), fc.sphere(1).translated((6, 0, 0)),
    ):  # fmt: skip
        hit = fc.first_contact(probe.moving(fc.Translation((-4, 0, 0))), rod)
        assert hit.status is fc.Status.CONTACT and abs(hit.time - 7 / 8) < 1e-9
    along = fc.Polyhedron([(0, 5, 0)], [])
    assert fc.first_contact(along.moving(fc.Translation((0, -10, 0))), rod).status is fc.Status.FREE
