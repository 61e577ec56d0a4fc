"""Mesh files: coordinates as the file has them, and one clear line for everything that cannot be read."""

import math

import numpy as np
import pytest
import trimesh

from firstcontact.errors import InputError
from firstcontact.io.meshes import read_mesh, weld, write_mesh

VERTICES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def corner_sets(vertices, triangles):
    return sorted(tuple(map(tuple, vertices[t])) for t in triangles)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off", "glb", "gltf"])
def test_written_meshes_come_back(tmp_path, suffix):
    path = tmp_path / f"tetrahedron.{suffix}"
    write_mesh(path, VERTICES, TRIANGLES)
    vertices, triangles = read_mesh(path)
    assert vertices.dtype == np.float64 and len(vertices) == 4
    assert corner_sets(vertices, triangles) == corner_sets(VERTICES, TRIANGLES)


def test_text_coordinates_are_the_doubles_of_their_digits(tmp_path):
    path = tmp_path / "digits.obj"
    path.write_text("v 0.1 1e-9 -0.3333333333333333\nv 1 0 0\nv 0 1e6 0\nf 1 2 3\n")
    vertices, _ = read_mesh(path)
    assert vertices[0].tolist() == [0.1, 1e-9, -0.3333333333333333]


def test_only_equal_vertices_are_welded(tmp_path):
    near = math.nextafter(1.0, 2.0)
    path = tmp_path / "near.obj"
    corners = ["0 0 0", "1 0 0", "0 1 0", "-0.0 0 0", f"{near!r} 0 0", "0 0 1"]
    path.write_text("\n".join(f"v {c}" for c in corners) + "\nf 1 2 3\nf 4 5 6\n")
    vertices, triangles = read_mesh(path)
    assert vertices[:, 0].tolist() == [0.0, 1.0, 0.0, near, 0.0]
    assert triangles.tolist() == [[0, 1, 2], [0, 3, 4]]


def test_weld_numbers_by_first_appearance():
    rng = np.random.default_rng(7)
    points = rng.integers(0, 3, (60, 3)).astype(float)
    triangles = rng.integers(0, 60, (40, 3))
    vertices, welded = weld(points, triangles)
    seen = list(dict.fromkeys(map(tuple, points)))
    assert list(map(tuple, vertices)) == seen
    assert np.array_equal(vertices[welded], points[triangles])


def test_geometries_of_one_file_are_joined_in_place(tmp_path):
    scene = trimesh.Scene()
    shift = np.eye(4)
    shift[:3, 3] = (5, 0, 0)
    scene.add_geometry(trimesh.Trimesh(VERTICES, TRIANGLES, process=False))
    scene.add_geometry(trimesh.Trimesh(VERTICES, TRIANGLES, process=False), transform=shift)
    path = tmp_path / "two.glb"
    scene.export(path)
    vertices, triangles = read_mesh(path)
    assert len(vertices) == 8 and len(triangles) == 8
    assert vertices.max(axis=0).tolist() == [6, 1, 1]


POINTS = """ply
format ascii 1.0
element vertex 1
property float x
property float y
property float z
end_header
0 0 0
"""
BAD = {
    "short.off": ("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "2 faces announced"),
    "damaged.off": ("damaged", "not readable as OFF"),
    "strips.ply": (POINTS.replace("element", "element tristrips 0\nproperty list int int a\nelement", 1), "no faces"),
    "points.ply": (POINTS, "no faces"),
    "empty.stl": ("", "84 bytes of header expected, 0 found"),
    "damaged.stl": (b"\xff\xfe\x00solid\x93" * 30, "not readable as STL; export the file again"),
    "damaged.ply": ("damaged", "not readable as PLY"),
    "damaged.glb": ("damaged", "not readable as GLB"),
    "beyond.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "export the file again"),
    "nan.obj": ("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 1 is not finite"),
    "model.blend": ("", "use one of .stl, .obj"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_named_with_its_cure_in_one_line(tmp_path, name):
    text, says = BAD[name]
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as error:
        read_mesh(path)
    assert str(error.value).startswith(f"{path}: ") and says in str(error.value)
    assert "\n" not in str(error.value) and "No module" not in str(error.value)


def test_missing_files_and_folders_are_told_apart(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_mesh(tmp_path / "none.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        read_mesh(tmp_path / "folder.stl")


def test_writing_where_nothing_can_be_written(tmp_path):
    with pytest.raises(InputError, match="choose a place"):
        write_mesh(tmp_path / "none" / "mesh.stl", VERTICES, TRIANGLES)
