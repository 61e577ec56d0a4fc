"""Scene files: what they build, and the one line each fault gives."""

from fractions import Fraction

import numpy as np
import pytest

from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction
from firstcontact.io.meshes import write_mesh
from firstcontact.scene import load_scene, parse_number, parse_time

TETRAHEDRON = """
shape = "polyhedron"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
"""


@pytest.fixture
def scene_of(tmp_path):
    def load(text):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return load_scene(path)

    return load


def bodies(a="", b=""):
    return f"[body.a]{TETRAHEDRON}{a}\n[body.b]{TETRAHEDRON}{b}\n"


def test_every_pair_is_checked_by_default(scene_of):
    scene = scene_of(bodies() + f"[body.c]{TETRAHEDRON}")
    assert [(c.a, c.b) for c in scene.checks] == [("a", "b"), ("a", "c"), ("b", "c")]
    assert scene.checks[0].arguments() == {"span": None, "exact": False, "tolerance": 1e-12, "budget": None}


def test_a_check_carries_its_arguments(scene_of):
    check = 'pair = ["b", "a"]\nspan = [0.25, "1/3"]\nexact = true\ntolerance = 1e-9\nbudget = 100\n'
    (check,) = scene_of(CHECK + check).checks
    assert (check.a, check.b) == ("b", "a")
    expected = {"span": (0.25, Fraction(1, 3)), "exact": True, "tolerance": 1e-9, "budget": 100}
    assert check.arguments() == expected


def test_bare_floats_are_doubles_and_quoted_numbers_exact(scene_of):
    motion = '[body.a.motion]\ntype = "translation"\nvector = [0.1, "0.1", 3]'
    x, y, z = map(fraction, scene_of(bodies(motion)).bodies["a"].motion.vector)
    assert (x, y, z) == (Fraction(0.1), Fraction(1, 10), 3) and x != y


def test_rotate_comes_before_at(scene_of):
    body = scene_of(bodies("at = [10, 0, 0]\nrotate = { axis = [0, 0, 1], degrees = 90 }")).bodies["a"]
    assert np.allclose(body.vertices, [[10, 0, 0], [10, 1, 0], [9, 0, 0], [10, 0, 1]])


def test_rotation_and_its_units(scene_of):
    motion = '[body.a.motion]\ntype = "rotation"\naxis = [0, 0, 2]\npoint = [1, 0, 0]\n'
    for angle in ("degrees = 90", 'turns = "1/4"', "radians = 1.5707963267948966"):
        pose = scene_of(bodies(motion + angle)).bodies["a"].motion(1.0)
        assert np.allclose(pose @ [0, 0, 0, 1], [1, -1, 0, 1])


def test_sequences_have_steps_and_durations(scene_of):
    motion = """[body.a.motion]
type = "sequence"
durations = [1, "1/2"]
[[body.a.motion.steps]]
type = "translation"
vector = [1, 0, 0]
[[body.a.motion.steps]]
type = "rotation"
axis = [0, 0, 1]
degrees = 180
"""
    motion = scene_of(bodies(motion)).bodies["a"].motion
    assert motion.span == (0.0, 1.5)
    assert np.allclose(motion(1.5) @ [0, 0, 0, 1], [-1, 0, 0, 1])


def test_mesh_files_are_relative_to_the_scene_and_labels_default_to_keys(scene_of, tmp_path, monkeypatch):
    (tmp_path / "parts").mkdir()
    write_mesh(tmp_path / "parts" / "t.ply", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    monkeypatch.chdir("/")
    text = '[body.fin]\nshape = "mesh"\nfile = "parts/t.ply"\n'
    built = scene_of(text + text.replace("fin]", "fan]") + 'name = "sheet"\n').bodies
    assert (built["fin"].name, built["fan"].name) == ("fin", "sheet")
    assert not built["fin"].solid


def test_polygons_may_have_holes(scene_of):
    text = """[body.frame]
shape = "polyhedron"
vertices = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [1, 1, 0], [3, 1, 0], [3, 3, 0], [1, 3, 0]]
faces = [[[0, 1, 2, 3], [4, 7, 6, 5]]]
"""
    frame = scene_of(text).bodies["frame"]
    assert frame.n_faces == 1 and len(frame.edges) == 8


SHIFT = '[body.a.motion]\ntype = "translation"\n'
TURN = '[body.a.motion]\ntype = "rotation"\n'
CHECK = bodies() + "[[check]]\n"
FAULTS = {
    "syntax": ("[body.a\n", ["not valid TOML", "line 1"]),
    "duplicate key": ("[body.a]\nshape = 'mesh'\nshape = 'mesh'\n", ["not valid TOML", "line 3"]),
    "nothing": ("", ["body: missing"]),
    "unknown table": (bodies() + "[bodies]\n", ["unknown key 'bodies'", "body, check"]),
    "unknown key": (bodies("sold = true"), ["body.a: unknown key 'sold'", "solid"]),
    "later shape": ('[body.a]\nshape = "cylinder"\n', ["body.a: shape 'cylinder'", "'mesh', 'polyhedron'"]),
    "shape type": ("[body.a]\nshape = ['mesh']\n", ["body.a", "'mesh', 'polyhedron'"]),
    "no shape": ("[body.a]\nfile = 'a.stl'\n", ["body.a", "'shape' is missing"]),
    "not a table": ("body = 3\n", ["body"]),
    "no file": ('[body.a]\nshape = "mesh"\n', ["body.a.file: missing"]),
    "missing file": ('[body.a]\nshape = "mesh"\nfile = "no.stl"\n', ["body.a", "no.stl", "no such file"]),
    "file type": ('[body.a]\nshape = "mesh"\nfile = 3\n', ["body.a.file", "3"]),
    "open solid": (
        bodies() + f"[body.c]{TETRAHEDRON}solid = true\n".replace(", [0, 3, 2]]", "]"),
        ["body.c", "open", "solid=False"],
    ),
    "solid type": (bodies('solid = "yes"'), ["body.a.solid", "'yes'", "boolean"]),
    "vertex type": (bodies().replace("[1, 0, 0]", '["x", 0, 0]', 1), ["body.a.vertices[1][0]", "'x'"]),
    "vertex length": (bodies().replace("[1, 0, 0]", "[1, 0]", 1), ["body.a.vertices[1]", "three numbers"]),
    "nan": (bodies("at = [nan, 0, 0]"), ["body.a.at[0]", "nan"]),
    "infinite": (bodies("at = [0, 0, -inf]"), ["body.a.at[2]", "-inf"]),
    "huge": (bodies("at = ['1e999', 0, 0]"), ["body.a.at[0]", "1e999"]),
    "endless": (bodies("at = ['1e999999999', 0, 0]"), ["body.a.at[0]", "1e999999999"]),
    "zero denominator": (bodies("at = ['1/0', 0, 0]"), ["body.a.at[0]", "divides by zero"]),
    "boolean number": (bodies("at = [true, 0, 0]"), ["body.a.at[0]", "True"]),
    "face index": (bodies().replace("[0, 2, 1]", "[0, 2, 9]", 1), ["body.a", "face 0", "4 vertices"]),
    "face type": (bodies().replace("[0, 2, 1]", "[0, 2.5, 1]", 1), ["body.a.faces[0]", "not a face"]),
    "edge length": (bodies("edges = [[0, 1, 2]]"), ["body.a.edges[0]", "two vertex numbers"]),
    "zero axis": (bodies(TURN + "axis = [0, 0, 0]\ndegrees = 3"), ["body.a.motion", "axis is zero"]),
    "zero rotate": (bodies("rotate = {axis = [0, 0, 0], degrees = 3}"), ["body.a.rotate", "axis is zero"]),
    "no angle": (bodies(TURN + "axis = [0, 0, 1]"), ["body.a.motion", "exactly one of"]),
    "two angles": (bodies(TURN + "axis = [0, 0, 1]\nturns = 1\ndegrees = 3"), ["body.a.motion", "exactly"]),
    "motion key": (bodies(SHIFT + "vectr = [1, 0, 0]"), ["body.a.motion: unknown key 'vectr'", "vector"]),
    "later motion": (bodies('[body.a.motion]\ntype = "spline"'), ["body.a.motion", "'spline'", "'trajectory'"]),
    "no type": (bodies("[body.a.motion]\nvector = [1, 0, 0]"), ["body.a.motion", "'type' is missing"]),
    "no vector": (bodies(SHIFT), ["body.a.motion.vector: missing"]),
    "no steps": (bodies("motion = {type = 'sequence', steps = []}"), ["body.a.motion", "no steps"]),
    "nested sequence": (
        bodies("motion = {type = 'sequence', steps = [{type = 'sequence', steps = []}]}"),
        ["body.a.motion.steps[0]", "'sequence'"],
    ),
    "durations": (
        bodies("motion = {type='sequence', durations=[1, 2],steps=[{type='translation', vector=[1, 0, 0]}]}"),
        ["body.a.motion", "1 steps but 2 durations"],
    ),
    "unknown body": (CHECK + 'pair = ["a", "z"]\n', ["check[0].pair", "'z'", "'a', 'b'"]),
    "same body": (CHECK + 'pair = ["a", "a"]\n', ["check[0].pair", "itself"]),
    "three bodies": (CHECK + 'pair = ["a", "b", "a"]\n', ["check[0].pair", "two body names"]),
    "no pair": (CHECK + "exact = true\n", ["check[0].pair: missing"]),
    "span type": (CHECK + 'pair = ["a", "b"]\nspan = [0, "one"]\n', ["check[0].span[1]", "'one'"]),
    "span nan": (CHECK + 'pair = ["a", "b"]\nspan = [nan, 1]\n', ["check[0].span[0]", "nan"]),
    "tolerance": (CHECK + 'pair = ["a", "b"]\ntolerance = 0\n', ["check[0].tolerance", "greater than 0"]),
    "budget": (CHECK + 'pair = ["a", "b"]\nbudget = 1.5\n', ["check[0].budget", "1.5", "integer"]),
    "two faults": (bodies("at = [1, 2]\nrotate = 3"), ["body.a.at", "(and 1 more)"]),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_one_line_with_file_key_and_cure(scene_of, tmp_path, fault):
    text, says = FAULTS[fault]
    with pytest.raises(InputError) as error:
        scene_of(text)
    message = str(error.value)
    assert message.startswith(f"{tmp_path / 'scene.toml'}: ") and "\n" not in message
    for words in says:
        assert words in message, message


def test_a_missing_scene_and_a_binary_one(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: no such file"):
        load_scene(tmp_path / "none.toml")
    (tmp_path / "b.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not text"):
        load_scene(tmp_path / "b.toml")


def test_a_body_may_be_named_like_a_shape_or_a_motion(scene_of):
    text = bodies("at = [nan, 0, 0]").replace("body.a", "body.polyhedron")
    with pytest.raises(InputError, match=r"body\.polyhedron\.at\[0\]: "):
        scene_of(text)


def test_numbers_are_kept_exact():
    assert parse_number("1/3") == Fraction(1, 3)
    assert parse_number(" -2.5e-3 ") == Fraction(-1, 400)
    assert parse_number(0.1) == 0.1 and parse_number(7) == 7
    assert parse_time("inf") == float("inf") and parse_time("-inf") == -float("inf")
    for bad in ("", "1/3/4", "0x10", "nan", "1_000", "1//2", None, [], True):
        with pytest.raises(ValueError, match="not a number"):
            parse_number(bad)
