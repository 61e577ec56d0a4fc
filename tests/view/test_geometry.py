"""Which lines are drawn, and where elements are."""

import numpy as np

from firstcontact import examples
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.result import Element
from firstcontact.view.geometry import element_vertices, face_outline, sharp_edges
from view import scenes


def test_a_cube_shows_its_twelve_edges():
    body = scenes.cube("box")
    drawn = {tuple(sorted(edge)) for edge in sharp_edges(body).tolist()}
    assert drawn == {tuple(sorted(edge)) for edge in body.edges.tolist()}
    assert len(drawn) == 12


def test_a_smooth_sphere_shows_none():
    assert len(sharp_edges(examples.noisy_sphere(5000, noise=0.0))) == 0


def test_borders_and_bare_edges_are_shown():
    square = Polyhedron([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    assert sorted(map(tuple, sharp_edges(square).tolist())) == [(0, 1), (0, 3), (1, 2), (2, 3)]
    wire = Polyhedron([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [], edges=[[0, 1], [1, 2]])
    assert sharp_edges(wire).tolist() == [[0, 1], [1, 2]]
    assert len(sharp_edges(Polyhedron([[0, 0, 0]], []))) == 0


def test_elements_are_where_the_body_has_them():
    body = scenes.cube("box")
    vertex = element_vertices(body, Element("vertex", "b", 6, "box"))
    assert np.array_equal(vertex, [[0.5, 0.5, 0.5]])
    edge = element_vertices(body, Element("edge", "b", 3, "box"))
    assert np.array_equal(edge, body.vertices[body.edges[3]])
    face = element_vertices(body, Element("face", "b", scenes.TOP, "box"))
    assert face.shape == (6, 3) and np.all(face[:, 2] == 0.5)


def test_the_outline_of_a_face_leaves_out_its_diagonal():
    outline = face_outline(scenes.cube("box"), scenes.TOP).reshape(-1, 2, 3)
    lengths = np.linalg.norm(outline[:, 0] - outline[:, 1], axis=1)
    assert lengths.tolist() == [1.0] * 4
