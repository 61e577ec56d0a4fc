"""Polygon faces of OBJ, PLY and OFF files: the solid is that of the same polygons given as arrays."""

import struct

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.polyhedron.triangulate import shapes
from firstcontact.errors import InputError
from firstcontact.io.meshes import read_mesh

# An L, from a corner that does not see (0, 2) and (1, 2): a fan from there covers the notch.
L = [(2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 0)]
VERTICES = [(x, y, z) for z in (0, 1) for x, y in L]
FACES = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]] + [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]


def obj(vertices, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["vt 0 0", "vn 0 0 1", "g prism  # one object"]
    styles = ("{}", "{}/1", "{}/1/1", "{}//1")
    for k, face in enumerate(faces):
        numbers = [i + 1 if k % 2 else i - len(vertices) for i in face]
        lines.append("f " + " ".join(styles[k % 4].format(i) for i in numbers))
    return "\n".join(lines).replace(" 0 1\n", " 0 \\\n 1\n").encode()


def off(vertices, faces):
    lines = ["OFF  # a prism", f"{len(vertices)} {len(faces)} 0", ""]
    lines += [f"{x} {y} {z}" for x, y, z in vertices]
    return "\n".join(lines + [f"{len(f)} {' '.join(map(str, f))} 255 0 0" for f in faces]).encode()


def off_with_counts_in_the_header(vertices, faces):
    return off(vertices, faces).replace(b"OFF  # a prism\n", b"OFF ")


def ply_header(encoding, n, m):
    return (
        f"ply\nformat {encoding} 1.0\ncomment a prism\nelement camera 1\nproperty list uchar float place\n"
        f"element vertex {n}\nproperty double z\nproperty uchar red\nproperty double x\nproperty double y\n"
        f"element face {m}\nproperty list uchar short weights\nproperty list uchar int vertex_indices\n"
        "property uchar red\nend_header\n"
    ).encode()


def ply(vertices, faces):
    lines = ["2 0.5 0.5"] + [f"{z} 7 {x} {y}" for x, y, z in vertices]
    lines += [f"1 -5 {len(f)} {' '.join(map(str, f))} 9" for f in faces]
    return ply_header("ascii", len(vertices), len(faces)) + "\n".join(lines).encode()


def binary_ply(vertices, faces, order="<", encoding="binary_little_endian"):
    data = struct.pack(f"{order}B2f", 2, 0.5, 0.5)
    data += b"".join(struct.pack(f"{order}dBdd", z, 7, x, y) for x, y, z in vertices)
    data += b"".join(struct.pack(f"{order}BhB{len(f)}iB", 1, -5, len(f), *f, 9) for f in faces)
    return ply_header(encoding, len(vertices), len(faces)) + data


def big_endian_ply(vertices, faces):
    return binary_ply(vertices, faces, ">", "binary_big_endian")


WRITERS = [obj, off, off_with_counts_in_the_header, ply, binary_ply, big_endian_ply]


def written(tmp_path, writer, vertices=VERTICES, faces=FACES):
    suffix = next(s for s in ("obj", "off", "ply") if s in writer.__name__)
    path = tmp_path / f"prism.{suffix}"
    path.write_bytes(writer(vertices, faces))
    return path


@pytest.mark.parametrize("writer", WRITERS)
def test_a_prism_from_a_file_is_the_prism_from_arrays(tmp_path, writer):
    prism = fc.Polyhedron.load(written(tmp_path, writer))
    given = fc.Polyhedron(VERTICES, FACES)
    assert prism.solid and prism.n_faces == 8 and len(prism.edges) == 18
    for name in ("vertices", "triangles", "triangle_face", "edges"):
        assert np.array_equal(getattr(prism, name), getattr(given, name)), name
    assert np.linalg.det(prism.vertices[prism.triangles]).sum() == pytest.approx(6 * 3)


@pytest.mark.parametrize("writer", [obj, off, ply])
def test_a_mark_before_the_text_is_no_part_of_it(tmp_path, writer):
    """Editors on Windows write one: an OBJ file lost its first vertex, and its faces named the ones after theirs."""
    last = [*VERTICES, (9, 9, 9)]  # so that all numbers are still of vertices
    plain = read_mesh(written(tmp_path, writer, last))
    path = tmp_path / f"marked.{writer.__name__}"
    path.write_bytes(b"\xef\xbb\xbf" + writer(last, FACES))
    vertices, faces = read_mesh(path)
    assert np.array_equal(vertices, plain[0]) and list(map(list, faces)) == list(map(list, plain[1]))


@pytest.mark.parametrize("writer", [obj, off, ply, binary_ply])
def test_the_notch_is_free(tmp_path, writer):
    prism = fc.Polyhedron.load(written(tmp_path, writer))
    peg = fc.Polyhedron([[1.25, 1.25, 3], [1.75, 1.25, 3], [1.25, 1.75, 3], [1.25, 1.25, 2]], [[0, 1, 2], [0, 1, 3]])
    assert fc.first_contact(peg.moving(fc.Translation((0, 0, -5))), prism).status is fc.Status.FREE


@pytest.mark.parametrize("writer", [obj, off, binary_ply])
def test_warped_polygons_are_cut_into_triangles_that_keep_the_notch_free(tmp_path, writer):
    bent = [(x, y, z + 0.25 * z * x * y) for x, y, z in VERTICES]
    prism = fc.Polyhedron.load(written(tmp_path, writer, bent))
    assert prism.solid and prism.n_faces == 7 + 4
    assert len(prism.edges) == 18 + 3
    peg = fc.Polyhedron([[1.25, 1.25, 3], [1.75, 1.25, 3], [1.25, 1.75, 3], [1.25, 1.25, 2]], [[0, 1, 2], [0, 1, 3]])
    assert fc.first_contact(peg.moving(fc.Translation((0, 0, -5))), prism).status is fc.Status.FREE
    with pytest.raises(InputError, match="face 1 is not a planar polygon; split it into triangles"):
        fc.Polyhedron(bent, FACES)


def test_convex_polygons_need_no_care(tmp_path):
    """Fans of proved convex polygons fill the same area as clipped ears; stars and dents are no fans."""
    turn = 2 * np.pi * np.arange(5) / 5
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(5)])
    orders = (([0, 1, 2, 3, 4], True), ([4, 3, 2, 1, 0], True), ([0, 2, 4, 1, 3], False), ([0, 1, 2, 4, 3], False))
    for order, fan in orders:
        assert shapes(ring, np.array([order])) == (np.array([True]), np.array([fan])), order
    dented = ring * [[1], [1], [0.1], [1], [1]]
    for start in range(5):
        assert not shapes(dented, np.array([np.roll(np.arange(5), start)]))[1]
    bent = ring + [[0, 0, 1e-3], *np.zeros((4, 3))]
    assert shapes(bent, np.array([[0, 1, 2, 3, 4]])) == (np.array([False]), np.array([False]))


@pytest.mark.parametrize("writer", WRITERS)
def test_missing_vertices_and_corners_are_named(tmp_path, writer):
    with pytest.raises(InputError, match="face 8 names a vertex that is not there"):
        read_mesh(written(tmp_path, writer, faces=[*FACES, [0, 1, 2, 99]]))
    with pytest.raises(InputError, match="face 8 has 2 corners; give at least three"):
        read_mesh(written(tmp_path, writer, faces=[*FACES, [0, 1]]))


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("share", [0.1, 0.4, 0.8])
def test_files_cut_short_say_so_in_one_line(tmp_path, writer, share):
    whole = written(tmp_path, writer)
    path = whole.with_name(f"short{whole.suffix}")
    data = whole.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError) as error:
        read_mesh(path)
    assert str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)


def test_welded_corners_of_polygons(tmp_path):
    """A seam between faces written apart closes, and triangles among polygons stay what they are."""
    apart = [VERTICES[i] for face in FACES for i in face]
    ends = np.cumsum([0] + [len(face) for face in FACES])
    numbered = [list(range(*pair)) for pair in zip(ends[:-1], ends[1:], strict=True)]
    prism = fc.Polyhedron.load(written(tmp_path, obj, apart, numbered))
    assert prism.solid and len(prism.vertices) == 12 and prism.n_faces == 8


STRIPS = """ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
0 2 0
1 2 5
"""


def test_strips_of_triangles(tmp_path):
    """Every other triangle of a strip is turned round, -1 begins a new strip, a corner twice only leads on."""
    path = tmp_path / "strips.ply"
    path.write_text(STRIPS + "11 0 1 2 3 4 -1 2 3 3 4 5\n")
    vertices, faces = read_mesh(path)
    assert np.asarray(faces).tolist() == [[0, 1, 2], [2, 1, 3], [2, 3, 4], [3, 4, 5]] and len(vertices) == 6
    x, y, z = np.moveaxis(vertices[np.asarray(faces)[:3]], 1, 0)
    assert (np.cross(y - x, z - x)[:, 2] > 0).all()  # all the same way up
