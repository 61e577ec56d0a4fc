"""Few samples with screws between them are the motion, to far less than a pixel."""

import numpy as np
import pytest

from firstcontact.motion.rotation import Rotation
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.translation import Translation
from firstcontact.view.poses import TOLERANCE, _twist, sample_poses, screw_between

MOTIONS = {
    "translation": Translation((3, -1, 2)),
    "lid": Rotation((0, 1, 0), point=(0, 0, 4), degrees=-110),
    "half turn": Rotation((1, 1, 1), point=(1, 0, 0), degrees=180),
    "whole turns": Rotation((0, 0, 1), point=(1, 2, 0), turns=8),
    "very many": Rotation((1, 2, 3), turns=200),
    "far away": Rotation((0, 0, 1), point=(1e6, 0, 0), degrees="1/100"),
    "still": Rotation((0, 0, 1), degrees=0),
    "steps": Sequence(
        [Translation((1, 0, 0)), Rotation((0, 0, 1), degrees=200), Translation((0, 0, 1))], [1, "1/3", 2]
    ),
}


def interpolated(times, poses, t):
    k = min(max(int(np.searchsorted(times, t, side="right")) - 1, 0), len(times) - 2)
    part = (t - times[k]) / (times[k + 1] - times[k])
    return screw_between(poses[k], *_twist(poses[k], poses[k + 1]), part)


@pytest.mark.share(3)
@pytest.mark.parametrize("name", MOTIONS)
def test_interpolation_is_the_motion(name):
    motion = MOTIONS[name]
    lo, hi = motion.span
    times, poses = sample_poses(motion, [lo, hi], size=1.0)
    scale = max(1.0, np.abs(poses).max() * 1e-7)  # what a float32 of the page keeps anyway
    for t in np.random.default_rng(1).uniform(lo, hi, 400):
        error = np.abs(interpolated(times, poses, t) - motion(float(t))).max()
        # inside the one step that holds a corner of the path the check at two places is all there is
        assert error < 10 * TOLERANCE * scale


def test_samples_are_exact_and_few():
    motion = MOTIONS["lid"]
    asked = [0.0, 0.3764801, 1.0]
    times, poses = sample_poses(motion, asked, size=1.0)
    for t in asked:
        (k,) = np.flatnonzero(times == t)
        assert np.array_equal(poses[k], motion(t))
    assert len(times) < 8
    assert len(sample_poses(MOTIONS["translation"], [0.0, 1.0], 1.0)[0]) == 2


def test_a_time_alone_is_one_sample():
    times, poses = sample_poses(MOTIONS["lid"], [0.25], 1.0)
    assert times.tolist() == [0.25] and poses.shape == (1, 4, 4)
