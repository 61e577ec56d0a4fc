"""`firstcontact info`: what is in a file."""

import numpy as np

from firstcontact.io.meshes import write_mesh

VERTICES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def test_a_closed_mesh(command, tmp_path):
    path = tmp_path / "tetrahedron.stl"
    write_mesh(path, VERTICES, TRIANGLES)
    code, out, _ = command("info", path)
    assert code == 0
    assert out.splitlines() == [
        str(path),
        "  4 vertices, 6 edges, 4 faces, 1 component",
        "  closed, a solid",
        "  from (0, 0, 0) to (1, 2, 3)",
    ]


def test_an_open_mesh_in_two_pieces(command, tmp_path):
    path = tmp_path / "pieces.ply"
    vertices = np.concatenate([VERTICES, VERTICES + 9])
    write_mesh(path, vertices, np.array([[0, 1, 2], [4, 5, 6]]))
    code, out, _ = command("info", path)
    assert code == 0 and "2 faces, 2 components" in out and "open, a surface" in out


def test_a_scene_lists_bodies_and_checks(command, cubes):
    check = '[[check]]\npair = ["left", "right"]\nspan = [0, "1/3"]\nexact = true\n'
    code, out, _ = command("info", cubes("1.1", check))
    assert code == 0
    lines = out.splitlines()
    assert lines[0].endswith("scene.toml: 2 bodies, 1 check")
    assert lines[1] == "body left: Translation((0.3, 0.0, 0.0))"
    assert lines[2] == "  8 vertices, 12 edges, 6 faces, 1 component"
    assert "body right: at rest" in lines
    assert lines[-1] == "check left / right, span 0 to 1/3, exact"


def test_a_solid_is_listed_by_its_features(command, scene):
    text = """[body.tip]
shape = "cone"
radius = 1
height = 2
[body.floor]
shape = "half_space"
normal = [0, 0, 1]
offset = -1
[body.shaft]
shape = "csg"
expression = "bar - flat"
[body.shaft.part.bar]
shape = "cylinder"
radius = 1
height = 2
[body.shaft.part.flat]
shape = "half_space"
normal = [-1, 0, 0]
offset = "-1/2"
"""
    code, out, _ = command("info", scene(text))
    assert code == 0
    lines = out.splitlines()
    assert lines[0].endswith("scene.toml: 3 bodies, 3 checks")
    tip = lines.index("body tip: at rest")
    assert lines[tip + 1 : tip + 3] == ["  2 faces, 1 edge, 1 vertex", "  a solid of planes and quadrics"]
    assert lines[tip + 4 : tip + 8] == [
        "  face 0: tip.side, quadric",
        "  face 1: tip.bottom, plane",
        "  edge 0: tip.rim.bottom, conic, convex",
        "  vertex 0: tip.apex, at (0, 0, 2)",
    ]
    assert "  unbounded" in lines and "  face 0: floor.plane, plane" in lines
    assert sum(line.startswith("  edge") and ": shaft.flat.rim.side" in line for line in lines) == 2
    assert "  edge 2: shaft.flat.rim.side, line, convex" in lines


def test_a_missing_file_is_named(command, tmp_path):
    code, out, err = command("info", tmp_path / "none.stl")
    assert code == 3 and out == "" and err.count("\n") == 1 and "none.stl: no such file" in err
