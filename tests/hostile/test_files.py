"""Damaged files: each is read, or refused in one line that names it and says what is wrong; none takes long or much.

A fuzz makes seeded mutations of good files: a thousand of each format in a thorough run, a share by default.
"""

import random
import resource
import struct
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.cli import run
from firstcontact.io.meshes import write_mesh
from firstcontact.scene.load import load_scene

MOST_SECONDS, MOST_KILOBYTES = 10, 1 << 20  # of CPU for one file; of memory beyond what was used before
TET = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def binary_stl(count, triangles):
    return bytes(80) + struct.pack("<I", count) + bytes(50) * triangles


TEXT_STL = b"solid a\n" + b"".join(
    b" facet normal 0 0 0\n  outer loop\n"
    + b"".join(b"   vertex %d %d %d\n" % tuple(TET[v]) for v in face)
    + b"  endloop\n endfacet\n"
    for face in FACES
) + b"endsolid a\n"  # fmt: skip
OBJ = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1 # top\nf 1/1 4/2 3/3 2/4\nf 1 2 5\nf 2 3 5\nf -2 -1 -3\nf 4 1 5\n"
OFF = b"OFF\n5 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 3 2 1\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n"
PLY_HEAD = (
    b"ply\nformat %b 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 4\nproperty list uchar int vertex_indices\nend_header\n"
)
PLY = PLY_HEAD % b"ascii" + b"0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
BINARY_PLY = (
    PLY_HEAD % b"binary_little_endian"
    + TET.astype("<f4").tobytes()
    + b"".join(struct.pack("<B3i", 3, *map(int, face)) for face in FACES)
)
STEP = b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n"
TOML = b"""
[body.pin]
shape = "csg"
expression = "rod - (hole | slot)"
at = [0, "1/3", 2.5]
[body.pin.part.rod]
shape = "cylinder"
radii = [1, "3/2"]
height = 4
[body.pin.part.hole]
shape = "sphere"
radius = 0.5
[body.pin.part.slot]
shape = "box"
size = [1, 1, 9]
[body.pin.motion]
type = "sequence"
durations = [1, 2]
steps = [ { type = "translation", vector = [0, 0, -1] }, { type = "rotation", axis = [0, 0, 1], degrees = 90 } ]
[body.lid]
shape = "polyhedron"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
[body.roof]
shape = "ruled"
first = "(u, 0, u**2)"
second = "(u, 1, T*u)"
u = [0, 1]
trim = ["u*s <= 1/2"]
[[check]]
pair = ["pin", "lid"]
span = [0, 1]
tolerance = 1e-9
budget = 1000
"""

# Name of the file, its bytes, and what the line says beside the name.
BAD = {
    "cut.stl": (binary_stl(4, 3), "4 triangles announced: 284 bytes expected, 234 found"),
    "absurd.stl": (binary_stl(4_000_000_000, 1), "triangles announced: 200000000084 bytes expected, 134 found"),
    "short.stl": (b"\x01" * 20, "84 bytes of header expected, 20 found"),
    "empty.stl": (b"", "84 bytes of header expected, 0 found"),
    "garbage.stl": (bytes(range(256)) * 4, "bytes expected, 1024 found"),
    "none.stl": (binary_stl(0, 0), "holds no faces"),
    "cut_text.stl": (TEXT_STL[:-80], "4 facets need 12 vertices"),
    "no_end.stl": (TEXT_STL[: TEXT_STL.index(b"endsolid")], "no endsolid after 4 facets"),
    "word.stl": (TEXT_STL.replace(b"vertex 1", b"vertex one"), "could not convert"),
    "two.stl": (TEXT_STL.replace(b"vertex 1 0 0", b"vertex 1 0"), "has 2 coordinates"),
    "nan.stl": (TEXT_STL.replace(b"vertex 1", b"vertex nan"), "is not finite"),
    "absurd.off": (OFF.replace(b"5 5 0", b"5 4000000000 0"), "4000000000 faces announced"),
    "negative.off": (OFF.replace(b"5 5 0", b"-5 5 0"), "negative.off"),
    "digits.off": (OFF.replace(b"5 5 0", b"5 " + b"9" * 5000), "digits.off: not readable as OFF"),
    "absurd.ply": (PLY.replace(b"vertex 4", b"vertex 4000000000"), "the data end early"),
    "absurd_binary.ply": (BINARY_PLY.replace(b"vertex 4", b"vertex 4000000000"), "buffer is smaller"),
    "absurd_faces.ply": (BINARY_PLY.replace(b"face 4", b"face 4000000000"), "not readable as PLY"),
    "negative.ply": (BINARY_PLY.replace(b"vertex 4", b"vertex -1"), "-1 elements 'vertex' announced"),
    "float_corners.ply": (PLY.replace(b"uchar int", b"uchar float"), "no whole numbers"),
    "cut.ply": (BINARY_PLY[:-5], "not readable as PLY"),
    "huge.obj": (OBJ.replace(b"f 1 2 5", b"f 1 2 " + b"9" * 30), "names a vertex that is not there"),
    "digits.obj": (OBJ.replace(b"f 1 2 5", b"f 1 2 " + b"9" * 5000), "digits.obj: not readable as OBJ"),
    "far.obj": (OBJ.replace(b"v 1 1 0", b"v 1e300 1 0"), "give finite coordinates below 2^150"),
    "null.obj": (bytes(1000), "holds no faces"),
    "absurd.glb": (b"glTF" + struct.pack("<III4s", 2, 4_000_000_000, 4_000_000_000, b"JSON"), "not readable as GLB"),
    "nested.gltf": (b"[" * 100_000, "not readable as GLTF"),
    "part.stp": (STEP, "holds no shapes that can be read"),
    "part.step": (STEP, "holds no shapes that can be read"),
    "x" * 200 + ".stl": (b"", "bytes of header expected"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_damaged_mesh_is_named_and_what_is_wrong_with_it(tmp_path, capsys, name):
    data, says = BAD[name]
    (tmp_path / name).write_bytes(data)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert run(["info", str(tmp_path / name)]) == 3
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and name[-20:] in err and says in err
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MOST_KILOBYTES


def test_mutations_of_a_step_file_are_read_or_refused_in_one_line(tmp_path):
    """OpenCASCADE ended the process over some of them."""
    pytest.importorskip("OCP", reason='needs the extra "step"')
    data, path = (Path(__file__).parents[2] / "examples" / "door.stp").read_bytes(), tmp_path / "door.stp"
    refused, broken = 0, 0
    for seed in (7, 14, 17, 29, *range(48, 56)):
        path.write_bytes(mutated(data, random.Random(seed)))
        try:
            assert fc.load_step(path).body.pieces
        except fc.InputError as error:
            refused += 1
            broken += "breaks down" in str(error)
            assert "door" in str(error) and len(str(error).splitlines()) == 1, (seed, str(error))
    assert refused > 0 and broken > 0


SEEDS = {
    "scene.toml": TOML, "text.stl": TEXT_STL, "a.obj": OBJ, "a.off": OFF, "text.ply": PLY, "binary.ply": BINARY_PLY,
    "a.stp": STEP,
}  # fmt: skip


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Good files, by name."""
    folder = tmp_path_factory.mktemp("good")
    for name, data in SEEDS.items():
        (folder / name).write_bytes(data)
    write_mesh(folder / "binary.stl", TET, FACES)
    write_mesh(folder / "binary.glb", TET, FACES)
    return folder


NUMBERS = [b"0", b"-1", b"1e400", b"nan", b"inf", b"1e-320", b"4294967295", b"9" * 40, b"9" * 5000, b"1/0", b'"1/3"']


def mutated(data, dice):
    """The bytes with one to four things done to them."""
    for _ in range(dice.randint(1, 4)):
        i, j = sorted(dice.randrange(len(data) + 1) for _ in range(2))
        j = min(j, i + dice.choice((1, 4, 20, 200)))
        what = dice.randrange(7)
        if what == 0:
            data = data[:i] + bytes([dice.randrange(256)]) + data[i + 1 :]
        elif what == 1:
            data = data[:i] + data[j:]
        elif what == 2:
            data = data[:i] + data[i:j] * dice.choice((2, 3, 50)) + data[j:]
        elif what == 3:
            data = data[: max(i, 1)]
        elif what == 4:
            data = data[:i] + dice.choice(NUMBERS) + data[j:]
        elif what == 5:
            data = data[:i] + struct.pack("<I", dice.choice((0, 1, 2**31, 2**32 - 1))) + data[i + 4 :]
        else:
            k = dice.randrange(len(data) + 1)
            data = data[:i] + data[k : k + j - i] + data[j:]
        data = data or b"0"
    return data


def read(path):
    return load_scene(path) if path.suffix == ".toml" else fc.Polyhedron.load(path)


@pytest.mark.parametrize("name", [*SEEDS, "binary.stl", "binary.glb"])
def test_mutations_of_a_good_file_are_read_or_refused_in_one_line(good, tmp_path, name):
    data = (good / name).read_bytes()
    if not name.endswith(".stp"):
        read(good / name)
    path = tmp_path / name
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    refused = 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for seed in range(amount(1000)):
            path.write_bytes(mutated(data, random.Random(seed)))
            begin = time.process_time()
            try:
                read(path)
            except fc.InputError as error:
                refused += 1
                assert str(error).startswith(str(path)) and len(str(error).splitlines()) == 1, (seed, str(error))
            except Exception as error:
                raise AssertionError(f"{name}, seed {seed}: {type(error).__name__}: {error}") from error
            assert time.process_time() - begin < MOST_SECONDS, seed
    assert refused > 0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MOST_KILOBYTES
