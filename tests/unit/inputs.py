"""Inputs for the float filters: random with planted contacts, lattice-degenerate, and the lattice shaken.

"shaken" moves lattice points by some 2^-45, "hair" by last digits, "scaled" stretches each axis of the
lattice by its own power of two.
"""

from __future__ import annotations

import math

import numpy as np
from flint import fmpq

from amount import amount

SHAKE = {"lattice": 0.0, "shaken": 2.0**-45, "hair": 2.0**-52, "scaled": 2.0**-50}
FAMILIES = ("random", *SHAKE)


def count(family: str) -> int:
    """How many inputs of the family a test takes."""
    return amount(20_000, 2) if family in ("random", "lattice", "shaken") else amount(3000, 2)


def points(family: str, rng, n: int, k: int) -> np.ndarray:
    """(n, k, 3) float64."""
    if family == "random":
        return rng.uniform(-1, 1, (n, k, 3))
    shaken = rng.integers(-2, 3, (n, k, 3)) + SHAKE[family] * rng.integers(-2, 3, (n, k, 3))
    return shaken * scales(n) if family == "scaled" else shaken


def scales(n: int) -> np.ndarray:
    """(n, 1, 3) powers of two, the same for all points of a scene, whichever call asks."""
    return np.exp2(np.random.default_rng(n).integers(-140, 140, (n, 1, 3)))


def weights(rng, n: int, k: int) -> np.ndarray:
    """(n, k) affine weights, mostly inside the element, sometimes a little outside."""
    w = rng.dirichlet(np.ones(k), n)
    return w + (rng.random((n, 1)) < 0.4) * (w - 1 / k) * rng.uniform(0, 1.5, (n, 1))


def translations(family: str, rng, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n, 3) velocities; in the random family most of them lead from an inner point of a to one of b."""
    n = len(a)
    if family != "random":
        v = rng.integers(-2, 3, (n, 3)) + SHAKE[family] * rng.integers(-1, 2, (n, 3))
        return v * scales(n)[:, 0] if family == "scaled" else v
    p = np.einsum("nk,nkj->nj", weights(rng, n, a.shape[1]), a)
    q = np.einsum("nk,nkj->nj", weights(rng, n, b.shape[1]), b)
    planted = (q - p) / rng.uniform(0.05, 1.3, (n, 1))
    return np.where(rng.random((n, 1)) < 0.8, planted, rng.uniform(-1, 1, (n, 3)))


def turned_onto(family: str, rng, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """b, in the random family shifted so that a, turned about z, mostly meets it; (n, k, 3)."""
    if family != "random":
        return b
    n = len(a)
    p = np.einsum("nk,nkj->nj", weights(rng, n, a.shape[1]), a)
    q = np.einsum("nk,nkj->nj", weights(rng, n, b.shape[1]), b)
    phi = rng.uniform(0, 2 * math.pi, n)
    c, s = np.cos(phi), np.sin(phi)
    target = np.stack([c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1], p[:, 2]], axis=1)
    return np.where(rng.random((n, 1, 1)) < 0.8, b + (target - q)[:, None], b)


def exact(corner) -> tuple[fmpq, fmpq, fmpq]:
    """The corner of doubles as rationals."""
    x, y, z = corner
    return fmpq(*x.as_integer_ratio()), fmpq(*y.as_integer_ratio()), fmpq(*z.as_integer_ratio())


def errors(rng) -> float:
    return float(rng.choice([0.0, 2.0**-52, 2.0**-40, 1e-9, 1e-3]))


def disturbed(corner, err: float, rng) -> tuple[fmpq, ...]:
    """A true corner behind rounded coordinates: off by up to `err` in each, often by all of it."""
    e = fmpq(*err.as_integer_ratio())
    return tuple(x + e * fmpq(int(rng.choice([-8, 8, rng.integers(-8, 9)])), 8) for x in exact(corner))


def below(x: float, y: fmpq) -> bool:
    """x <= y."""
    return x == -math.inf or (x != math.inf and fmpq(*x.as_integer_ratio()) <= y)


def above(x: float, y: fmpq) -> bool:
    """x >= y."""
    return x == math.inf or (x != -math.inf and fmpq(*x.as_integer_ratio()) >= y)
