"""Whether a vector is in the cone of others: against scipy's solver of the same least squares."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from amount import amount
from firstcontact.contact.models.normals import is_in_cone


def test_vectors_in_cones_and_beside_them():
    rng, inside = np.random.default_rng(281128), 0
    for _ in range(amount(5000, 10)):
        ends = rng.integers(-3, 4, (rng.integers(1, 40), 3)).astype(float)
        ends = ends[ends.any(axis=1)]
        if rng.random() < 0.5:
            ends[:, 2] = np.abs(ends[:, 2])  # within a half-space
        shares = rng.uniform(0, 1, len(ends)) * (rng.random(len(ends)) < 0.2)
        n = rng.normal(size=3) if rng.random() < 0.5 else shares @ ends
        if not len(ends) or np.linalg.norm(n) < 1e-9:
            continue
        n, ends = n / np.linalg.norm(n), ends / np.linalg.norm(ends, axis=1, keepdims=True)
        assert is_in_cone(n, ends) == (nnls(ends.T, n)[1] <= 1e-6)
        inside += is_in_cone(n, ends)
    assert inside > 100
    assert not is_in_cone(np.array([0.0, 0.0, 1.0]), np.zeros((0, 3)))
