"""Products of motions as polynomials for the kernels of curved bodies: within the errors that they tell."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from firstcontact.exact.numbers import exact_value
from firstcontact.kernels.poses import CENTRE, DEGREE, ERROR_R, ERROR_T, PER_HALF
from firstcontact.motion.linkage import Drive, Linkage
from firstcontact.motion.relative.curved import own_series, terms
from firstcontact.motion.relative.stretches import LEFT_OUT, TERMS, windows

KINDS = [fc.Rotation((0, 0, 1), degrees=1), fc.Rotation((1, 2, 2), (1, 0, 0), degrees=1),
         fc.Screw((0, 1, 0), (2, 0, 1), degrees=1, advance="1/90")]  # fmt: skip
VALUES = {
    "linear": [(0, 70), (20, -140), (5, 10)],
    "bent": [(0, 0, 0, 60), (3, 0, 59), (1, 2, 3, 4)],
    "long": [(0, 700), (5, 30, -200, 90), (0, 0, 0, -800)],
}


@pytest.mark.share(3)
@pytest.mark.parametrize("name", VALUES)
def test_poses_are_within_their_errors(name):
    rows = [tuple(map(fmpq, value)) for value in VALUES[name]]
    drives = [Drive(str(k), "deg", m, [v]) for k, (m, v) in enumerate(zip(KINDS, rows, strict=True))]
    motion = Linkage([fmpq(0), fmpq(1)], drives)
    found = windows(fc.sphere(1).moving(motion), fc.sphere(1), fmpq(0), fmpq(1))
    assert found[0].first <= 0 and found[-1].last >= 1
    rng = np.random.default_rng(3)
    product = motion.part(0)[2]
    for window in found[:: max(1, len(found) // 7)]:
        head, table = window.a[0], window.a[1:13]
        assert max(head[ERROR_R], head[ERROR_T]) < 1e-13
        for t in (window.first, window.inner, *rng.uniform(window.first, window.last, 4)):
            time = fmpq(*float(min(max(t, 0.0), 1.0)).as_integer_ratio())
            s = (time - fmpq(*float(head[CENTRE]).as_integer_ratio())) * fmpq(*float(head[PER_HALF]).as_integer_ratio())
            with terms(1, 192):
                truth = own_series(product, arb(time), fmpq(1))
                for e in range(12):
                    entry = truth[e // 3][e % 3] if e < 9 else truth[e - 9][3]
                    powers = [fmpq(*float(c).as_integer_ratio()) * s**k for k, c in enumerate(table[e])]
                    assert len(powers) == head[DEGREE] + 1
                    error = head[ERROR_R] if e < 9 else head[ERROR_T]
                    assert abs(entry[0] - sum(powers, fmpq(0))) <= arb(float(error))


@pytest.mark.parametrize("turns, most", [(fmpq(1, 6), 6), (fmpq(1), 14), (fmpq(60), 400)])
def test_windows_are_no_more_than_bent_values_ask_for(turns, most):
    """A joint that made 200 turns along a cubic had 36,000 of them, which took 20 s, eight times as many as needed."""
    value = (fmpq(0), turns / 3, -turns / 6, turns / 9)
    motion = Linkage([fmpq(0), fmpq(1)], [Drive("q", "turn", fc.Rotation((0, 0, 1), turns=1), [value])])
    found = windows(fc.sphere(1).moving(motion), fc.sphere(1), fmpq(0), fmpq(1))
    assert len(found) <= most
    for window in found[:: max(1, len(found) // 5)]:
        middle, half = (exact_value(window.last) + exact_value(window.first)) / 2, (window.last - window.first) / 2
        with terms(TERMS + 1, 192):
            cosine = own_series(motion.part(0)[2], arb(middle), fmpq(1))[0][0]
            assert abs(cosine[TERMS]) * arb(half) ** TERMS < LEFT_OUT
