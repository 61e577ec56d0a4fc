"""A torus as it is followed in contact: see `timeline.lasting.LastingSolid`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb

from firstcontact.body.solid.csg import inside
from firstcontact.body.torus.torus import Torus
from firstcontact.contact.torus.cells import square
from firstcontact.contact.torus.heights import Around, Ring
from firstcontact.exact.numbers import precision
from firstcontact.exact.rigid import apply
from firstcontact.timeline.lasting import BITS, Drift, LastingSolid, tree_height

SAMPLES = 12
"""Points along either circle at which its tube is looked at."""
LAYERS = 0.0, 0.5, 0.97
"""Shares of the way from the inside of the tube outwards."""


class SolidTorus(LastingSolid):
    """Of a sector too."""

    def __init__(self, torus: Torus) -> None:
        self.torus, self.tips, self.ring = torus, [], Ring(torus)
        with precision(BITS):
            self.back = tuple(tuple(arb(x) for x in row) for row in torus.back)
            self.major = arb(torus.major)
            self.walls = [tuple(arb(x) for x in wall) for wall in torus.walls]
            self.tubes = [(arb(torus.minor) * arb(share)) ** 2 for share in torus.exact_shares]
        self.own = np.linalg.inv(square(torus.pose))
        self.unit = abs(float(np.linalg.det(torus.pose[:, :3]))) ** (1 / 3)
        """The unit of its own frame; heights are compared with those of the other body, in the world's."""

    def holds(self, x: Sequence[arb], drift: Drift | None = None) -> bool:
        place = tuple(x) if drift is None else tuple(a + b for a, b in zip(x, drift.moved, strict=True))
        u, v, w = apply(self.back, place)  # type: ignore[arg-type]
        rho = (u * u + v * v).sqrt()
        across = rho - self.major
        away, (near, far) = across * across + w * w, self.tubes
        told = [away <= far, *([away >= near] if near > 0 else []), *(
            p * rho + a * u + b * v + c * w + d <= 0 for p, a, b, c, d in self.walls
        )]  # fmt: skip
        return bool(inside(self.torus.tree, told))

    def placed(self, linear: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """The map to its own frame from that one in which a point x of the torus is at linear x + shift."""
        back = np.eye(4)
        back[:3, :3] = np.linalg.inv(linear)
        back[:3, 3] = -back[:3, :3] @ shift
        placed: np.ndarray = self.own @ back
        return placed

    def height(self, back: np.ndarray, centre: np.ndarray, steps: np.ndarray) -> np.ndarray:
        told = self._told((centre + steps) @ back[:3, :3].T + back[:3, 3])
        found: np.ndarray = tree_height(self.torus.tree, told.values.T) * self.unit
        return found

    def slopes(self, back: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        told = self._told((back[:3, :3] @ point + back[:3, 3])[None])
        return told.values[0] * self.unit, told.gradients[0] @ back[:3, :3] * self.unit

    def values(self, back: np.ndarray, points: np.ndarray) -> np.ndarray:
        found: np.ndarray = self._told(points @ back[:3].T).values.T * self.unit
        return found

    def samples(self) -> np.ndarray:
        (major, minor), (near, far), pose = self.torus.radii, self.torus.shares, self.torus.pose
        parts = [first + (last - first) * (np.arange(SAMPLES) + 0.5) / SAMPLES for first, last in self.torus.angles]
        u, v = (x.ravel() for x in np.meshgrid(*parts))
        x = [np.column_stack([(major + s * minor * np.cos(v)) * np.cos(u), (major + s * minor * np.cos(v)) * np.sin(u),
                              s * minor * np.sin(v)]) for s in near + np.array(LAYERS) * (far - near)]  # fmt: skip
        found: np.ndarray = np.concatenate(x) @ pose[:, :3].T + pose[:, 3]
        return found

    def _told(self, x: np.ndarray) -> Around:
        """The heights at points (n, 3) of its own frame."""
        with np.errstate(all="ignore"):
            return self.ring.around(x, np.zeros(len(x)))
