"""Scene files: what they build, and the one line each fault gives."""

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction
from firstcontact.io.meshes import write_mesh
from firstcontact.scene.load import load_scene, parse_number, parse_time
from firstcontact.scene.solids import combined

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


SHAPES = {
    "box": ("size = [1, 2, '1/3']", lambda: fc.box((1, 2, "1/3"))),
    "sphere": ("radius = '0.1'", lambda: fc.sphere("0.1")),
    "ellipsoid": ("radii = [1, 2, 3]", lambda: fc.ellipsoid((1, 2, 3))),
    "cylinder": ("radii = [5, 10]\nheight = 10", lambda: fc.cylinder(radii=(5, 10), height=10)),
    "cone": ("radius = 1\nheight = 2", lambda: fc.cone(1, 2)),
    "frustum": ("bottom = 2\ntop = 1\nheight = 1", lambda: fc.frustum(2, 1, 1)),
    "paraboloid": ("radii = 1\nheight = 4", lambda: fc.paraboloid(1, 4)),
    "hyperboloid": ("radii = [1, 1, 1]\nheight = 2\nsheets = 2", lambda: fc.hyperboloid((1, 1, 1), 2, sheets=2)),
    "half_space": ("normal = [1, 2, 2]\noffset = 3", lambda: fc.half_space((1, 2, 2), 3)),
    "quadric": (
        "matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, '-1/3']]",
        lambda: fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, "-1/3"]]),
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_every_builder_is_a_shape(scene_of, shape):
    keys, make = SHAPES[shape]
    placing = "\nat = ['1/3', 0, 1]\nrotate = { axis = [0, 1, 0], degrees = 90 }\n"
    body = scene_of(f"[body.a]\nshape = '{shape}'\n{keys}{placing}{SHIFT}vector = [1, 0, 0]\n").bodies["a"]
    expected = make().rotated((0, 1, 0), degrees=90).translated(("1/3", 0, 1))
    assert body.body.surfaces == expected.surfaces and body.name == "a"
    assert body.motion.span == (0.0, 1.0)


PLATE = """[body.plate]
shape = "csg"
expression = "slab - (bore | counterbore)"
[body.plate.part.slab]
shape = "box"
size = [4, 4, 1]
[body.plate.part.bore]
shape = "cylinder"
radius = "1/2"
height = 2
[body.plate.part.counterbore]
shape = "cylinder"
radius = 1
height = "1/2"
at = [0, 0, "1/2"]
"""


def test_csg_names_its_parts(scene_of):
    plate = scene_of(PLATE).bodies["plate"]
    faces = {face.name for face in plate.faces}
    assert {"plate.slab.z+", "plate.bore.side", "plate.counterbore.bottom"} < faces
    assert {edge.name for edge in plate.edges} > {
        "plate.counterbore.rim.top", "plate.bore.rim.top", "plate.bore.rim.bottom",
    }  # fmt: skip
    assert plate.contains([(0, 0, 0), (0.75, 0, 0), (0.75, 0, 0.375)]).tolist() == [False, True, False]


def test_a_part_may_be_a_csg_and_a_body_may_have_another_name(scene_of):
    text = PLATE.replace("[body.plate", "[body.stack.part.plate").replace("[body.stack.part.plate]", "", 1)
    stack = "[body.stack]\nshape = 'csg'\nexpression = 'plate'\nname = 'pile'\n[body.stack.part.plate]\n"
    ball = "[body.stack.part.ball]\nshape = 'sphere'\nradius = 1\nat = [0, 0, 2]\n"
    text = stack.replace("'plate'", "'plate | ball'") + text + ball
    faces = [face.name for face in scene_of(text).bodies["stack"].faces]
    assert "pile.plate.bore.side" in faces and "pile.ball.surface" in faces


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("a | b & c - d", lambda a, b, c, d: a | b & c - d),
        ("(a | b) & c - d", lambda a, b, c, d: (a | b) & c - d),
        ("a - b - c | d", lambda a, b, c, d: a - b - c | d),
        ("a -\n  (b - (c & d))", lambda a, b, c, d: a - (b - (c & d))),
    ],
)
def test_expressions_have_the_precedence_of_python(expression, expected):
    solids = {name: fc.box((4, 4, 4)).translated((k, k % 2, k / 2)) for k, name in enumerate("abcd")}
    found, wanted = combined(expression, solids), expected(*solids.values())
    points = np.random.default_rng(3).uniform(-4, 6, (4000, 3))
    assert np.array_equal(found.contains(points), wanted.contains(points))
    assert 0 < np.sum(found.contains(points)) < 2000


SHIFT = '[body.a.motion]\ntype = "translation"\n'
TURN = '[body.a.motion]\ntype = "rotation"\n'
CHECK = bodies() + "[[check]]\n"
CYLINDER = '[body.a]\nshape = "cylinder"\n'


def csg(expression, more=""):
    return PLATE.replace("slab - (bore | counterbore)", expression) + more


FAULTS = {
    "solid key": (CYLINDER + "radus = 1\nheight = 1", ["body.a: unknown key 'radus'", "radii, height"]),
    "solid length": (CYLINDER + "radii = [1, 2, 3]\nheight = 1", ["body.a.radii", "one number or two"]),
    "radius and radii": (CYLINDER + "radius = 1\nradii = 1\nheight = 1", ["body.a: cylinder", "exactly one"]),
    "no radius": (CYLINDER + "height = 1", ["body.a: cylinder needs exactly one of radius and radii"]),
    "no height": (CYLINDER + "radius = 1", ["body.a.height: missing"]),
    "negative radius": (CYLINDER + "radius = '-1/2'\nheight = 1", ["body.a: cylinder radius is -1/2", "positive"]),
    "solid of a solid": (CYLINDER + "radius = 1\nheight = 1\nsolid = true", ["body.a: unknown key 'solid'"]),
    "skew matrix": (
        "[body.a]\nshape = 'quadric'\nmatrix = [[1,1,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,-1]]", ["body.a", "symmetric"]
    ),
    "unknown part": (csg("slab - hole"), ["body.plate.expression: no part 'hole'", "'slab', 'bore', 'counterbore'"]),
    "no expression": (csg("x").replace('expression = "x"', ""), ["body.plate.expression: missing"]),
    "no parts": ("[body.a]\nshape = 'csg'\nexpression = 'b'", ["body.a.expression: no part 'b'", "body.NAME.part"]),
    "empty expression": (csg(" "), ["body.plate.expression: ''", "combine part names"]),
    "unfinished": (csg("slab - "), ["body.plate.expression: 'slab -'", "column 6"]),
    "open bracket": (csg("(slab - bore"), ["body.plate.expression", "'(' in column 1"]),
    "two operators": (csg("slab - - bore"), ["body.plate.expression", "'-' in column 8"]),
    "other operator": (csg("slab - (bore + counterbore)"), ["body.plate.expression", "'+' in column 14"]),
    "and": (csg("slab and bore"), ["body.plate.expression", "column 1", "-, &, |"]),
    "call": (csg("slab - open('f')"), ["body.plate.expression", "'o' in column 8"]),
    "attribute": (csg("slab.tree"), ["body.plate.expression", "'s' in column 1"]),
    "number": (csg("slab - 3"), ["body.plate.expression", "'3' in column 8"]),
    "comment": (csg("slab # - bore"), ["body.plate.expression", "'#' in column 6"]),
    "null": (csg("slab\\u0000"), ["body.plate.expression"]),
    "endless brackets": (csg("(" * 5000 + "slab" + ")" * 5000), ["body.plate.expression"]),
    "empty solid": (csg("bore - slab - bore"), ["body.plate.expression", "is empty", "check the operands"]),
    "part key": (csg("slab", "hight = 3"), ["body.plate.part.counterbore: unknown key 'hight'", "height"]),
    "moving part": (csg("slab", "motion = {}"), ["body.plate.part.counterbore: unknown key 'motion'"]),
    "part value": (csg("slab", "rotate = {axis = [0, 0, 0], degrees = 1}"), ["counterbore.rotate", "axis is zero"]),
    "part radius": (csg("slab").replace('"1/2"', "0"), ["body.plate.part.bore: cylinder radius is 0"]),
    "part shape": (csg("slab").replace('"box"', '"mesh"'), ["body.plate.part.slab", "'mesh' is not supp", "'csg'"]),
    "part name": (csg("slab").replace("part.bore", "part.bore-1"), ["body.plate.part.bore-1", "letters, digits"]),
    "keyword": (csg("slab").replace("part.bore", "part.in"), ["body.plate.part.in", "cannot stand"]),
    "syntax": ("[body.a\n", ["not valid TOML", "line 1"]),
    "duplicate key": ("[body.a]\nshape = 'mesh'\nshape = 'mesh'\n", ["not valid TOML", "line 3"]),
    "nothing": ("", ["body: missing"]),
    "unknown table": (bodies() + "[bodies]\n", ["unknown key 'bodies'", "body, check"]),
    "unknown key": (bodies("sold = true"), ["body.a: unknown key 'sold'", "solid"]),
    "later shape": ('[body.a]\nshape = "spline"\n', ["body.a: shape 'spline'", "'mesh', 'polyhedron', 'box'"]),
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
    "one check": (bodies() + '[check]\npair = ["a", "b"]\n', ["check: [check]", "write [[check]]"]),
    "one curve": (CHECK + 'pair = ["a", "b"]\n[curve]\npair = ["a", "b"]\n', ["curve: [curve]", "write [[curve]]"]),
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
