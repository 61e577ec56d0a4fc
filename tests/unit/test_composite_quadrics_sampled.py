"""Composite quadric models against brute force: random combinations, sampled boundaries and volumes."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount


def quarter(rng):
    return fmpq(rng.randint(1, 8), 4)


def primitive(rng):
    body = rng.choice(
        [
            lambda: fc.box((quarter(rng), quarter(rng), quarter(rng))),
            lambda: fc.sphere(quarter(rng)),
            lambda: fc.cylinder(quarter(rng), quarter(rng)),
            lambda: fc.cone(quarter(rng), quarter(rng)),
            lambda: fc.ellipsoid((quarter(rng), quarter(rng), quarter(rng))),
            lambda: fc.paraboloid(quarter(rng), quarter(rng)),
        ]
    )()
    if rng.random() < 0.5:
        body = body.rotated(rng.choice([(1, 0, 0), (0, 1, 0), (0, 0, 1)]), degrees=90 * rng.randint(1, 3))
    if rng.random() < 0.2:
        body = body.rotated((1, 2, 2), degrees=37)
    return body.translated(tuple(fmpq(rng.randint(-4, 4), 4) for _ in range(3)))


def combination(seed):
    rng = random.Random(seed)
    body = primitive(rng)
    for _ in range(rng.randint(1, 3)):
        operation, other = rng.choice("|&--"), primitive(rng)
        body = {"|": lambda a, b: a | b, "&": lambda a, b: a & b, "-": lambda a, b: a - b}[operation](body, other)
    return body


def combinations(seeds):
    for seed in seeds:
        try:
            yield combination(seed)
        except fc.InputError as error:
            assert "empty" in str(error)


def volume(mesh):
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6)


@pytest.mark.thorough
def test_edges_lie_on_the_boundary_and_end_in_vertices():
    seen = 0
    for body in combinations(range(amount(40))):
        ends = {v.index: 0 for v in body.vertices}
        for edge in body.edges:
            for piece in edge.pieces:
                inner = edge.points(np.linspace(piece.lo, piece.hi, 9)[1:-1])
                may_in, may_out = body._possible(inner, slack=1e-7)
                assert np.all(may_in & may_out), (body, edge.name)
                for parameter, vertex in ((piece.lo, piece.start), (piece.hi, piece.end)):
                    if vertex is not None:
                        ends[vertex] += 1
                        gap = edge.points([parameter])[0] - body.vertices[vertex].position
                        assert np.linalg.norm(gap) < 1e-7
                seen += 1
        for vertex in body.vertices:
            assert ends[vertex.index] >= 2 or vertex.name.endswith("apex"), (body, vertex.name)
    assert seen > amount(150)


@pytest.mark.thorough
def test_sides_of_surfaces_are_faces():
    """A step across a surface that leaves the solid is a step across a face."""
    for body in combinations(range(amount(40))):
        lo, hi = body.bounds()
        rng = np.random.default_rng(0)
        p, q = rng.uniform(lo, hi, (2, 1500, 3))
        sides = {(f.surfaces[0], f.orientation) for f in body.faces}
        s = np.linspace(0, 1, 40)[:, None, None]
        x = np.concatenate([p + s * (q - p), np.ones((40, 1500, 1))], axis=2)
        signs = np.einsum("kni,sij,knj->skn", x, body.forms, x, optimize=True) > 0
        may_in, may_out = body._possible(x[..., :3].reshape(-1, 3))
        inside = (may_in & ~may_out).reshape(40, 1500)
        changed = signs[:, 1:] != signs[:, :-1]
        left = (inside[1:] != inside[:-1]) & (changed.sum(axis=0) == 1)
        for k, n in np.argwhere(left)[:400]:
            surface = int(np.flatnonzero(changed[:, k, n])[0])
            body_side_positive = bool(signs[surface, k if inside[k, n] else k + 1, n])
            assert (surface, -1 if body_side_positive else 1) in sides, body


MESHES = [
    (fc.box((1, 2, 3)), 6),
    (fc.sphere(1), 4 / 3 * math.pi),
    (fc.ellipsoid((1, 2, "1/2")), 4 / 3 * math.pi),
    (fc.cylinder((1, 2), 3).rotated((1, 2, 3), degrees=20), 6 * math.pi),
    (fc.cone(1, 2), 2 * math.pi / 3),
    (fc.frustum(2, 1, 1), 7 * math.pi / 3),
    (fc.paraboloid(1, 1), math.pi / 2),
    (fc.hyperboloid((1, 1, 1), 2), 8 * math.pi / 3),
    (fc.hyperboloid((1, 1, 1), 2, sheets=2), 4 * math.pi / 3),
    (fc.cylinder(1, 6) & fc.cylinder(1, 6).rotated((1, 0, 0), degrees=90), 16 / 3),
    (fc.box((4, 4, 4)) - fc.sphere(1), 64 - 4 / 3 * math.pi),
    (fc.quadric([[1, 0, 0, 0], [0, 0, 0, "-1/2"], [0, 0, 0, 0], [0, "-1/2", 0, 0]]) & fc.box((2, 2, 2)), 8 / 3),
    (fc.quadric([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, "-1/2"], [0, 0, "-1/2", 0]]) & fc.box((2, 2, 4)), 8),
    (fc.quadric([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 0], [0, 0, 0, "-1/4"]]) & fc.box((2, 2, 2)), None),
]


def test_mesh_of_planar_faces_needs_their_outlines_only():
    assert len(fc.box((1, "2/3", 5)).to_mesh(1).triangles) == 12
    assert len(fc.cylinder(1, 100).to_mesh(1).vertices) == 16


@pytest.mark.share(2)
@pytest.mark.parametrize("body", [fc.cylinder(1, 2), fc.cone(1, 2)])
def test_fine_mesh_of_rulings_needs_no_triangles_but_those_at_its_chords(body):
    """Sides along rulings are no distance off, however long: flips have to find them all."""
    chords = 512  # the least power of two times 8 that keeps arcs within 7e-5 of their chords
    assert len(body.to_mesh(1e-4).triangles) <= 4.2 * chords


@pytest.mark.share(8)
@pytest.mark.parametrize(("body", "expected"), MESHES)
def test_mesh_has_the_volume_and_lies_on_the_surfaces(body, expected):
    mesh = body.to_mesh(0.005)
    sides = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    once = set(map(tuple, sides.tolist()))
    assert mesh.solid and len(once) == len(sides) and once == {(b, a) for a, b in once}
    if expected is None:  # |x| <= sqrt(1/4 + y^2)
        y = np.linspace(-1, 1, 20001)
        expected = 2 * np.trapezoid(np.minimum(2 * np.sqrt(0.25 + y * y), 2), y)
    area = np.linalg.norm(
        np.cross(*(mesh.vertices[mesh.triangles[:, k]] - mesh.vertices[mesh.triangles[:, 0]] for k in (1, 2))), axis=1
    ).sum()
    assert abs(volume(mesh) - expected) < 0.005 * area
    may_in, may_out = body._possible(mesh.vertices, slack=1e-8)
    assert np.all(may_in & may_out)
