"""Poses as float32 and as printed digits: the nearest rotation is taken, and the answer tells how far that is.

The truth is the polar factor by NumPy's singular values.
"""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.scene.load import load_scene

DIGITS = {"float32": np.float32, "seven digits": lambda m: np.round(m, 7), "nine digits": lambda m: np.round(m, 9)}


def turns(n: int) -> list[np.ndarray]:
    """Poses that turn by up to a radian, at places on a grid."""
    rng = np.random.default_rng(711)
    poses = []
    for k in range(n):
        axis, angle = rng.normal(size=3), rng.uniform(0.2, 1.0)
        x, y, z = axis / np.linalg.norm(axis)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        pose = np.eye(4)
        pose[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        pose[:3, 3] = k, 0, 0
        poses.append(pose)
    return poses


def nearest(m: np.ndarray) -> np.ndarray:
    u, _, v = np.linalg.svd(np.asarray(m, float)[:3, :3])
    return u @ v


@pytest.mark.parametrize("rounded", DIGITS.values(), ids=DIGITS)
@pytest.mark.parametrize("interpolation", ["linear-quaternion", "screw"])
def test_the_nearest_rotation_is_taken(rounded, interpolation):
    given = [rounded(pose) for pose in turns(6)]
    path = fc.Trajectory(range(6), given, interpolation)
    for k, pose in enumerate(given):
        assert np.allclose(path(float(k))[:3, :3], nearest(pose), rtol=0, atol=1e-14)
    off = max(np.abs(nearest(pose) - np.asarray(pose, float)[:3, :3]).max() for pose in given)
    assert 1e-11 < off and path.correction == pytest.approx(off, rel=1e-4)
    assert pickle.loads(pickle.dumps(path)).correction == path.correction


def test_answers_tell_a_correction_that_counts():
    box, goal = fc.examples.box((1, 1, 1)), fc.sphere(1, name="ball").translated((9, 0, 0))
    start, end = np.eye(4), turns(2)[1].astype(np.float32)
    end[:3, 3] = 9, 0, 0
    motion = fc.RationalMotion.between(start, end)
    assert 1e-9 < motion.correction < 1e-7
    for body in (box, fc.cylinder(1, 1)):
        moving = body.moving(motion)
        for ask in (fc.first_contact, fc.contact_intervals):
            for answer in (ask(moving, goal), ask(goal, moving)):
                assert f"the nearest ones were taken, entries off by up to {motion.correction:.1g}" in str(answer)
                assert str(answer).count("no exact rotations") == 1
    both = fc.Sequence([fc.Translation((1, 0, 0)), motion])
    assert both.correction == motion.correction and pickle.loads(pickle.dumps(motion)).correction == motion.correction


def test_exact_and_double_poses_are_not_talked_about():
    quarter = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 9], [0, 0, 0, 1]])
    exact, double = fc.RationalMotion.between(np.eye(4), quarter), fc.RationalMotion.between(np.eye(4), turns(1)[0])
    assert exact.correction == 0.0 < double.correction < 1e-15
    assert "rotations" not in str(fc.first_contact(fc.sphere(1).moving(double), fc.sphere(1).translated((9, 0, 0))))


def test_snap_is_the_callers():
    coarse = np.round(turns(1)[0], 4)
    with pytest.raises(fc.InputError, match=r"poses\[1\]: the linear .* misses one by .*, more than snap = 1e-06"):
        fc.Trajectory([0, 1], [np.eye(4), coarse])
    path = fc.Trajectory([0, 1], [np.eye(4), coarse], snap=1e-3)
    assert np.allclose(path(1.0)[:3, :3], nearest(coarse), rtol=0, atol=1e-14)


def test_scenes_take_snap(tmp_path):
    rows = [[float(x) for x in row] for row in np.round(turns(1)[0], 4)]
    text = (
        "[body.a]\nshape = 'sphere'\nradius = 1\n[body.a.motion]\ntype = 'between'\n"
        f"pose0 = {np.eye(4).tolist()}\npose1 = {rows}\n{{snap}}\n"
        "[body.b]\nshape = 'sphere'\nradius = 1\nat = [5, 0, 0]\n[[check]]\npair = ['a', 'b']\n"
    )
    path = tmp_path / "rounded.toml"
    path.write_text(text.format(snap="snap = 1e-3"))
    assert load_scene(path).bodies["a"].motion.correction > 1e-6
    path.write_text(text.format(snap=""))
    with pytest.raises(fc.InputError, match="snap"):
        load_scene(path)
