"""The generated solids are closed, oriented outward, of the wanted size, and the same for the same seed."""

import numpy as np
import pytest

from firstcontact import examples

GENERATORS = {
    "noisy_sphere": examples.noisy_sphere,
    "torus": examples.torus,
    "spur_gear": examples.spur_gear,
    "spur_gear with backlash": lambda n: examples.spur_gear(n, backlash=0.3),
    "spur_gear in layers": lambda n: examples.spur_gear(n, teeth=8, layers=3),
    "box_with_knob": examples.box_with_knob,
    "lid": examples.lid,
    "arm": examples.arm,
    "post": examples.post,
}
SEEDED = ["noisy_sphere", "torus", "arm", "post"]


def directed_edges(faces):
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)


def signed_volume(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


@pytest.fixture(params=[(name, n) for name in GENERATORS for n in (1_000, 10_000)], ids=str)
def mesh(request):
    name, n = request.param
    body = GENERATORS[name](n)
    return body.vertices, body.triangles, n


def test_every_directed_edge_stands_once_beside_its_reverse(mesh):
    vertices, faces, _ = mesh
    edges = directed_edges(faces)
    key = edges[:, 0] * len(vertices) + edges[:, 1]
    reverse = edges[:, 1] * len(vertices) + edges[:, 0]
    assert len(np.unique(key)) == len(key)
    assert np.array_equal(np.sort(key), np.sort(reverse))


def test_faces_look_outward_and_have_an_area(mesh):
    vertices, faces, _ = mesh
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert signed_volume(vertices, faces) > 0
    assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).all()


def test_size_and_types(mesh):
    vertices, faces, n = mesh
    assert 0.8 * n <= len(faces) <= 1.2 * n
    assert vertices.dtype == np.float64 and vertices.shape[1] == 3
    assert faces.dtype == np.int32 and faces.shape[1] == 3
    assert np.array_equal(np.unique(faces), np.arange(len(vertices)))


def test_large_meshes_have_the_wanted_size():
    for make in GENERATORS.values():
        assert 0.95 <= len(make(20_000).triangles) / 20_000 <= 1.05


@pytest.mark.parametrize("name", SEEDED)
def test_a_seed_names_one_mesh(name):
    make = GENERATORS[name]
    first, again, other = make(1000, seed=3), make(1000, seed=3), make(1000, seed=4)
    assert np.array_equal(first.vertices, again.vertices)
    assert not np.array_equal(first.vertices, other.vertices)


def test_gear_web_is_not_folded():
    """Seen from above, all triangles of the cap turn the same way."""
    gear = examples.spur_gear(4000, backlash=0.2)
    vertices, faces = gear.vertices, gear.triangles
    top = (vertices[faces][:, :, 2] > 0.199).all(axis=1)
    a, b, c = (vertices[faces[top]][:, k, :2] for k in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (doubled > 0).all()


def test_box_is_centred_and_divided():
    body = examples.box((1.0, 2.0, 3.0), (2, 3, 4))
    assert len(body.triangles) == 4 * (2 * 3 + 3 * 4 + 4 * 2)
    assert signed_volume(body.vertices, body.triangles) == pytest.approx(6.0, rel=1e-14)
    assert np.array_equal(body.vertices.max(axis=0), [0.5, 1.0, 1.5])
    assert np.array_equal(body.vertices.min(axis=0), [-0.5, -1.0, -1.5])


def test_bodies_are_solids_named_after_their_shape():
    for name in examples.solids.__all__:
        body = getattr(examples, name)()
        assert body.solid and body.closed and body.name == name
