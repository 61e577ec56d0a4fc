"""Edges of meshes within flat faces, by doubles and exactly."""

import numpy as np

import firstcontact as fc
from firstcontact.contact.mesh_model import patches


def test_doubles_tell_no_edge_of_a_flat_face_for_a_bent_one():
    """Two triangles hinged on an edge, bent by anything from nothing to a thousandth, far from and near the origin."""
    rng = np.random.default_rng(5)
    told = 0
    for k in range(300):
        a, b, c = rng.integers(-9, 10, (3, 3)) * 2.0 ** rng.integers(-30, 30) + rng.integers(0, 2) * 1e3
        off = rng.integers(-1, 2) * 10.0 ** rng.uniform(-19, -3) * np.cross(b - a, c - a)
        mesh = fc.Polyhedron([a, b, c, b + c - a + off], [[0, 1, 2], [1, 3, 2]])
        bent = patches._bent(mesh)
        for e in range(len(mesh.edges)):
            around = patches.triangles_at_edge(mesh, e)
            flat = patches._in_one_plane(mesh, around)
            assert not (flat and bent[e]), k
            told += bool(bent[e])
            assert patches.is_sharp_edge(mesh, e) is not flat
    assert told > 50
    assert not patches._bent(fc.Polyhedron([[0, 0, 0], [1, 0, 0]], [], edges=[[0, 1]])).any()
