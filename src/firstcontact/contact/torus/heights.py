"""How far points are from what is to be avoided: a torus, or the surfaces of a model, in its own frame.

A height h is negative inside its half-space; its gradient at a point c and a bound of how it bends tell it around c:
h(x) >= h(c) + grad . (x - c) - bend |x - c|^2 / 2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.body.solid.carriers import Quadric
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import And, Leaf, Not, Tree
from firstcontact.body.torus.torus import Torus
from firstcontact.contact.torus.cells import square, support
from firstcontact.exact.numbers import to_double
from firstcontact.exact.rigid import to_origin

U = 2.0**-53
ROUNDINGS = 64.0


class Around(NamedTuple):
    """At points (n, 3): values (n, f) of f heights, their errors, gradients (n, f, 3); bends (2, n, f) of h and of -h.

    least: (2, n, f) what h and -h are at least within the distances asked for, by other means; -inf: not known.
    """

    values: np.ndarray
    errors: np.ndarray
    gradients: np.ndarray
    bends: np.ndarray
    least: np.ndarray


class Heights:
    tree: Tree
    """What is to be avoided: where this is true of the signs of the heights."""

    count = 1
    """Of heights."""

    pose: np.ndarray
    """(4, 4): from the frame in which they are told to the body's."""

    def around(self, c: np.ndarray, reach: np.ndarray) -> Around:
        """At points c (n, 3), up to the distances reach (n,)."""
        raise NotImplementedError

    def beyond_flat(self, normals: np.ndarray) -> np.ndarray | None:
        """(n,) how far all of it reaches in unit directions (n, 3), where that is known."""
        return None

    def planes(self) -> np.ndarray | None:
        """(f, 4) the heights that are linear: normals and offsets; rows of zeros for others; None: there are none."""
        return None


class Ring(Heights):
    """The distance from a torus, negative inside; of a sector those from both tubes, then those from its walls."""

    def __init__(self, torus: Torus) -> None:
        (self.major, minor), self.pose, self.tree = torus.radii, square(torus.pose), torus.tree
        near, far = torus.shares
        self.radii = [far * minor, near * minor] if near > 0.0 else [far * minor]
        self.walls = np.array([[to_double(x) for x in wall] for wall in torus.walls]).reshape(-1, 5)
        """Rows p, n, c: p rho + n . x + c is negative behind the wall."""
        self.count = len(self.radii) + len(self.walls)

    @np.errstate(divide="ignore", invalid="ignore")  # on the axis and in the middle of the tube no direction is told
    def around(self, c: np.ndarray, reach: np.ndarray) -> Around:
        rho = np.hypot(c[:, 0], c[:, 1])
        across = rho - self.major
        away = np.hypot(across, c[:, 2])
        turn = across / (away * rho)
        gradient = np.column_stack([turn * c[:, 0], turn * c[:, 1], c[:, 2] / away])
        nearest, axis = away - reach, rho - reach
        clear = (nearest > 0.0) & (axis > 0.0)
        bend = np.where(clear, np.maximum(0.0, reach - across) / (nearest * axis), np.inf)
        counter = np.where(clear, np.maximum(1.0, np.maximum(0.0, across + reach) / axis) / nearest, np.inf)
        gradient = np.where(np.isfinite(gradient).all(axis=1)[:, None], gradient, 0.0)
        error = 16.0 * U * (rho + np.abs(c[:, 2]) + self.major + reach)
        told = []
        for sign, radius in zip((1.0, -1.0), self.radii, strict=False):
            value = sign * (away - radius)
            least = np.stack([value - reach - error, -value - reach - error])
            told.append(Around(value, error, sign * gradient, np.stack([bend, counter][:: int(sign)]), least))
        told += [self._beyond_wall(wall, c, rho, reach, error) for wall in self.walls]
        values, errors, gradients, bends, leasts = zip(*told, strict=True)
        return Around(
            np.stack(values, 1), np.stack(errors, 1), np.stack(gradients, 1), np.stack(bends, 2), np.stack(leasts, 2)
        )

    def _beyond_wall(
        self, wall: np.ndarray, c: np.ndarray, rho: np.ndarray, reach: np.ndarray, error: np.ndarray
    ) -> Around:
        """rho is convex, and bends by its inverse at most."""
        value = wall[0] * rho + c @ wall[1:4] + wall[4]
        out = np.column_stack([c[:, 0], c[:, 1], np.zeros(len(c))]) / np.where(rho > 0.0, rho, 1.0)[:, None]
        clear = rho > reach
        bend = np.where(clear, 1.0 / np.where(clear, rho - reach, 1.0), np.inf)
        bends = np.stack([abs(wall[0]) * bend if sign * wall[0] > 0.0 else 0.0 * rho for sign in (-1.0, 1.0)])
        steep = (abs(wall[0]) + float(np.linalg.norm(wall[1:4]))) * (1.0 + 1e-14) * reach
        error = error * (1.0 + float(np.abs(wall[:4]).max()))  # that of c is at most the radius, times these
        least = np.stack([value - steep - error, -value - steep - error])
        return Around(value, error, wall[0] * out + wall[1:4], bends, least)

    def beyond_flat(self, normals: np.ndarray) -> np.ndarray:
        return support(self.major, self.radii[0], normals) * (1 + 1e-14)

    def planes(self) -> np.ndarray | None:
        if not len(self.walls):
            return None
        flat = np.where(self.walls[:, :1] == 0.0, self.walls[:, 1:], 0.0)
        return np.vstack([np.zeros((len(self.radii), 4)), flat])


class FormHeights(Heights):
    """Those of the surfaces of a model; negative where its tree takes a surface for passed."""

    def __init__(self, model: CompositeQuadric) -> None:
        self.pose = np.eye(4)
        if model.bounded:  # about its middle, where little cancels
            lo, hi = model.bounds()
            by = to_origin((0.5 * (lo + hi)).tolist(), float((hi - lo).max()))
            model, self.pose[:3, 3] = model.translated(by), [-to_double(c) for c in by]
        self.tree, self.forms, self.count = model.tree, model.forms, len(model.forms)
        self.sizes = np.abs(self.forms)
        turns = np.linalg.eigvalsh(2.0 * self.forms[:, :3, :3])
        slack = 1e-14 * np.abs(turns).max(axis=1)
        self.bends = np.stack([np.maximum(0.0, slack - turns[:, 0]), np.maximum(0.0, slack + turns[:, 2])])
        self.bends[:, np.abs(self.forms[:, :3, :3]).max(axis=(1, 2)) == 0.0] = 0.0
        self.apexes = [
            (k, np.array([to_double(c) for c in surface.apex[:3]]))
            for k, surface in enumerate(model.surfaces) if isinstance(surface, Quadric) and surface.apex is not None
        ]  # fmt: skip

    def around(self, c: np.ndarray, reach: np.ndarray) -> Around:
        x = np.column_stack([c, np.ones(len(c))])
        image = np.einsum("sij,nj->nsi", self.forms, x)
        values = np.einsum("nsi,ni->ns", image, x)
        most = np.abs(x) + reach[:, None]
        errors = ROUNDINGS * U * np.einsum("ni,sij,nj->ns", most, self.sizes, most, optimize=True)
        gradients = 2.0 * image[:, :, :3]
        for k, apex in self.apexes:
            self._about(k, c - apex, 2.0 * U * np.abs(apex), reach, values, errors, gradients)
        least = np.full((2, *values.shape), -np.inf)
        bends = np.repeat(self.bends[:, None], len(c), axis=1)
        return Around(values, errors, gradients, bends, least)

    def _about(
        self, k: int, d: np.ndarray, off: np.ndarray, reach: np.ndarray, values: np.ndarray, errors: np.ndarray,
        gradients: np.ndarray,
    ) -> None:  # fmt: skip
        """Puts in what cone k is at places d from its apex, rounded by `off` at most: there nothing cancels."""
        form, size = self.forms[k, :3, :3], self.sizes[k, :3, :3]
        most = np.abs(d) + reach[:, None]
        values[:, k], gradients[:, k] = ((d @ form) * d).sum(axis=1), 2.0 * d @ form
        errors[:, k] = ROUNDINGS * U * ((most @ size) * most).sum(axis=1) + (2.0 * most + off) @ size @ off

    def planes(self) -> np.ndarray:
        flat: np.ndarray = np.abs(self.forms[:, :3, :3]).max(axis=(1, 2)) == 0.0
        return np.where(flat[:, None], np.column_stack([2.0 * self.forms[:, :3, 3], self.forms[:, 3, 3]]), 0.0)


class Outside(Heights):
    """All but what heights tell of."""

    def __init__(self, heights: Heights) -> None:
        self.tree, self.heights, self.pose = Not(heights.tree), heights, heights.pose

    def around(self, c: np.ndarray, reach: np.ndarray) -> Around:
        return self.heights.around(c, reach)


class Beyond(Heights):
    """What heights tell of, but for a ball."""

    def __init__(self, heights: Heights, centre: np.ndarray, radius: float) -> None:
        self.heights, self.centre, self.radius, self.pose = heights, centre, radius, heights.pose
        self.tree, self.count = And(heights.tree, Not(Leaf(heights.count))), heights.count + 1

    def around(self, c: np.ndarray, reach: np.ndarray) -> Around:
        """The distance from the ball bends by one over that from its centre at most, and never the other way."""
        told, way = self.heights.around(c, reach), c - self.centre
        away = np.sqrt((way * way).sum(axis=1))
        error = 16.0 * U * (away + self.radius + np.abs(c).max(axis=1) + float(np.abs(self.centre).max()))
        clear = away > reach
        bend = np.where(clear, 1.0 / np.where(clear, away - reach, 1.0), np.inf)
        gradient = way / np.maximum(away, 1e-300)[:, None]
        value = away - self.radius
        least = np.stack([value - reach - error, -value - reach - error])
        return Around(
            np.column_stack([told.values, value]), np.column_stack([told.errors, error]),
            np.concatenate([told.gradients, gradient[:, None]], axis=1),
            np.concatenate([told.bends, np.stack([np.zeros(len(c)), bend])[:, :, None]], axis=2),
            np.concatenate([told.least, least[:, :, None]], axis=2),
        )  # fmt: skip

    def beyond_flat(self, normals: np.ndarray) -> np.ndarray | None:
        return self.heights.beyond_flat(normals)

    def planes(self) -> np.ndarray | None:
        planes = self.heights.planes()
        return None if planes is None else np.vstack([planes, np.zeros((1, 4))])
