"""Motions in scene files: rational, between, screw, trajectory."""

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.scene.load import load_scene

BODY = """[body.a]
shape = "polyhedron"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
faces = [[0, 1, 2]]
[body.a.motion]
"""
UNIT = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"
QUARTER = "[[0, -1, 0, '1/3'], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"


@pytest.fixture
def motion_of(tmp_path):
    def load(text):
        path = tmp_path / "scene.toml"
        path.write_text(BODY + text)
        return load_scene(path).bodies["a"].motion

    return load


def test_a_screw(motion_of):
    motion = motion_of('type = "screw"\naxis = [0, 0, 2]\npoint = [1, 0, 0]\ndegrees = 90\nadvance = "1/3"\n')
    assert isinstance(motion, fc.Screw)
    assert repr(motion) == repr(fc.Screw((0, 0, 2), (1, 0, 0), degrees=90, advance="1/3"))


def test_a_rational_motion(motion_of):
    slope = "[[0, 0, 0, '1/3'], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]"
    motion = motion_of(f'type = "rational"\ncoefficients = [{UNIT}, {slope}]\n')
    assert motion.coefficients[1][0][3] * 3 == 1 and motion.rigid


@pytest.mark.parametrize("keys", [
    f"pose0 = {UNIT}\npose1 = {QUARTER}",
    "pose0 = [0, 0, 0]\npose1 = ['1/3', 0, 0]\nquat_xyzw = [[0, 0, 0, 1], [0, 0, 1, 1]]",
    "pose0 = [0, 0, 0]\npose1 = ['1/3', 0, 0]\nquat_wxyz = [[1, 0, 0, 0], [1, 0, 0, 1]]",
])  # fmt: skip
def test_between(motion_of, keys):
    motion = motion_of(f'type = "between"\n{keys}\n')
    turn = [[0, -1, 0, "1/3"], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert motion.pose == fc.RationalMotion.between(np.eye(4), turn).pose


def test_a_trajectory(motion_of):
    poses = f"times = [1, '3/2']\nposes = [{UNIT}, {QUARTER}]\n"
    motion = motion_of(f'type = "trajectory"\n{poses}')
    assert motion.span == (1.0, 1.5) and motion.interpolation == "linear-quaternion"
    screw = motion_of(f'type = "trajectory"\ninterpolation = "screw"\n{poses}')
    assert screw.interpolation == "screw"
    vectors = "times = [0, 1]\nposes = [[0, 0, 0], [0, 0, 5]]\nquat_wxyz = [[1, 0, 0, 0], [1, 0, 0, 1]]\n"
    assert motion_of(f'type = "trajectory"\n{vectors}')(1.0)[:3, 3].tolist() == [0, 0, 5]


def test_steps_of_a_sequence(motion_of):
    steps = "".join(
        f"[[body.a.motion.steps]]\n{step}\n"
        for step in (
            'type = "screw"\naxis = [0, 0, 1]\nturns = 1\nadvance = 2',
            f'type = "between"\npose0 = {UNIT}\npose1 = {QUARTER}',
            f'type = "rational"\ncoefficients = [{UNIT}]',
        )
    )
    motion = motion_of(f'type = "sequence"\n{steps}')
    assert [type(s) for s in motion.steps] == [fc.Screw, fc.RationalMotion, fc.RationalMotion]
    assert np.allclose(motion(1.0)[:3, 3], [1 / 3, 0, 2])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('type = "screw"\naxis = [0, 0, 1]', ["body.a.motion: Screw needs exactly one of"]),
        ('type = "screw"\naxis = [0, 0, 1]\nturns = 1\npitch = 3', ["unknown key 'pitch'", "advance"]),
        ('type = "rational"\ncoefficients = [[1, 2]]', ["body.a.motion.coefficients[0]", "not a 4x4 matrix"]),
        ('type = "rational"\ncoefficients = []', ["no coefficients"]),
        (f'type = "rational"\ncoefficients = [{UNIT.replace("1, 0]", "nan, 0]")}]', ["coefficients[0]", "nan"]),
        ('type = "rational"\ncoefficients = [[[0,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]]', ["singular at all times"]),
        (f'type = "between"\npose0 = {UNIT}', ["body.a.motion.pose1: missing"]),
        (f'type = "between"\npose0 = {UNIT}\npose1 = [1, 2]', ["body.a.motion.pose1", "4x4 matrix", "quat_xyzw"]),
        (f'type = "between"\npose0 = {UNIT}\npose1 = [1, 2, 3]', ["pose1 is a vector; add quat_xyzw"]),
        (f'type = "between"\npose0 = {UNIT}\npose1 = {UNIT}\nquat_wxyz = [[1,0,0,0],[1,0,0,0]]', ["pose0 is a matrix"]),
        ('type = "between"\npose0 = [0,0,0]\npose1 = [0,0,0]\nquat_wxyz = [[1,0,0],[1,0,0,0]]', ["quat_wxyz[0]"]),
        ('type = "between"\npose0 = [0,0,0]\npose1 = [0,0,0]\nquat_wxyz = [[1,0,0,0],[0,0,0,1]]', ["half a turn"]),
        (f'type = "trajectory"\ntimes = [0, 0]\nposes = [{UNIT}, {UNIT}]', ["times[1] does not lie after"]),
        (f'type = "trajectory"\ntimes = [0, 1]\nposes = [{UNIT}]', ["2 times but 1 poses"]),
        (f'type = "trajectory"\ntimes = [0, 1]\nposes = [{UNIT}, [1, 2, 3]]', ["poses[1] is a vector"]),
        ('type = "trajectory"\ntimes = [0]\nposes = []\ninterpolation = "x"', ["interpolation", "'x'", "screw"]),
    ],
)  # fmt: skip
def test_faults_are_one_line_with_key_and_cure(motion_of, tmp_path, text, says):
    with pytest.raises(fc.InputError) as error:
        motion_of(text)
    message = str(error.value)
    assert message.startswith(f"{tmp_path / 'scene.toml'}: ") and "\n" not in message
    for words in says:
        assert words in message, message
