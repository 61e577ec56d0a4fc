"""A torus as it is followed in contact: see `timeline.lasting.LastingSolid`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb

from firstcontact.body.torus.torus import Torus
from firstcontact.contact.torus.cells import square
from firstcontact.exact.numbers import precision
from firstcontact.exact.rigid import apply
from firstcontact.timeline.lasting import BITS, LastingSolid

SAMPLES = 12
"""Points along either circle at which its tube is looked at."""


class SolidTorus(LastingSolid):
    def __init__(self, torus: Torus) -> None:
        self.torus, self.tips = torus, []
        with precision(BITS):
            self.back = tuple(tuple(arb(x) for x in row) for row in torus.back)
            self.radii = arb(torus.major), arb(torus.minor)
        self.own = np.linalg.inv(square(torus.pose))
        self.unit = abs(float(np.linalg.det(torus.pose[:, :3]))) ** (1 / 3)
        """The unit of its own frame; heights are compared with those of the other body, in the world's."""

    def holds(self, x: Sequence[arb], moved: Sequence[arb] | None = None) -> bool:
        p, q, r = x if moved is None else (a + b for a, b in zip(x, moved, strict=True))
        u, v, w = apply(self.back, (p, q, r))  # type: ignore[arg-type]
        across = (u * u + v * v).sqrt() - self.radii[0]
        return bool(across * across + w * w <= self.radii[1] * self.radii[1])

    def placed(self, linear: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """The map to its own frame from that one in which a point x of the torus is at linear x + shift."""
        back = np.eye(4)
        back[:3, :3] = np.linalg.inv(linear)
        back[:3, 3] = -back[:3, :3] @ shift
        placed: np.ndarray = self.own @ back
        return placed

    def height(self, back: np.ndarray, centre: np.ndarray, steps: np.ndarray) -> np.ndarray:
        return self._distance((centre + steps) @ back[:3, :3].T + back[:3, 3])[0]

    def slopes(self, back: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distance, gradient = self._distance((back[:3, :3] @ point + back[:3, 3])[None])
        return distance, gradient @ back[:3, :3]

    def values(self, back: np.ndarray, points: np.ndarray) -> np.ndarray:
        return self._distance(points @ back[:3].T)[0][None]

    def samples(self) -> np.ndarray:
        u, v = (x.ravel() for x in np.meshgrid(*[np.arange(SAMPLES) * (2.0 * np.pi / SAMPLES)] * 2))
        major, minor = self.torus.radii
        parts = [0.0, 0.5, 0.97]
        x = [np.column_stack([(major + s * minor * np.cos(v)) * np.cos(u), (major + s * minor * np.cos(v)) * np.sin(u),
                              s * minor * np.sin(v)]) for s in parts]  # fmt: skip
        pose = self.torus.pose
        found: np.ndarray = np.concatenate(x) @ pose[:, :3].T + pose[:, 3]
        return found

    def _distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) distances from the torus of points (n, 3) of its own frame, negative inside; their gradients (n, 3); in
        the world's unit."""
        major, minor = self.torus.radii
        rho = np.maximum(np.hypot(x[:, 0], x[:, 1]), 1e-300)
        away = np.maximum(np.hypot(rho - major, x[:, 2]), 1e-300)
        turn = (rho - major) / (rho * away)
        slopes = np.column_stack([turn * x[:, 0], turn * x[:, 1], x[:, 2] / away])
        return (away - minor) * self.unit, slopes * self.unit
