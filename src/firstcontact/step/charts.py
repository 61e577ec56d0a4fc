"""Many points of a surface by their parameters at once, and back: of planes, cylinders, cones, spheres and tori."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface


def bare(surface: Geom_Surface) -> Geom_Surface:
    """The surface without its trimming."""
    while surface.DynamicType().Name() == "Geom_RectangularTrimmedSurface":
        surface = surface.BasisSurface()
    return surface


class Elementary:
    """Parameters are those of OpenCASCADE."""

    def __init__(self, surface: Geom_Surface) -> None:
        self.surface = bare(surface)
        self.kind = self.surface.DynamicType().Name().removeprefix("Geom_").removesuffix("Surface")
        place = self.surface.Position()
        p = place.Location()
        self.origin = np.array([p.X(), p.Y(), p.Z()])
        axes = place.XDirection(), place.YDirection(), place.Direction()
        self.axes = np.array([[d.X(), d.Y(), d.Z()] for d in axes])

    def at(self, uv: np.ndarray) -> np.ndarray:
        """(n, 3) points at (n, 2) parameters."""
        u, v = uv.T
        if self.kind == "Plane":
            local = np.stack([u, v, np.zeros_like(u)])
        else:
            r, z = self._profile(v)
            local = np.stack([r * np.cos(u), r * np.sin(u), z])
        found: np.ndarray = self.origin + local.T @ self.axes
        return found

    def _profile(self, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances from the axis, negative on the other nappe of a cone, and heights."""
        surface = self.surface
        if self.kind == "Cylindrical":
            return np.full_like(v, surface.Radius()), v
        if self.kind == "Conical":
            return surface.RefRadius() + v * np.sin(surface.SemiAngle()), v * np.cos(surface.SemiAngle())
        if self.kind == "Spherical":
            return surface.Radius() * np.cos(v), surface.Radius() * np.sin(v)
        return surface.MajorRadius() + surface.MinorRadius() * np.cos(v), surface.MinorRadius() * np.sin(v)

    def parameters(self, points: np.ndarray, least: float) -> np.ndarray:
        """(n, 2) parameters of points (n, 3) of the surface; an angle is from `least` to a turn beyond, one
        around the circle of a torus from 0."""
        x, y, z = self.axes @ (points - self.origin).T
        if self.kind == "Plane":
            return np.column_stack([x, y])
        v = z
        if self.kind == "Spherical":
            v = np.arctan2(z, np.hypot(x, y))
        if self.kind == "Toroidal":
            v = np.arctan2(z, np.hypot(x, y) - self.surface.MajorRadius()) % (2.0 * np.pi)
        if self.kind == "Conical":
            v = z / np.cos(self.surface.SemiAngle())
            other = self._profile(v)[0] < 0.0
            x, y = np.where(other, -x, x), np.where(other, -y, y)
        return np.column_stack([least + (np.arctan2(y, x) - least) % (2.0 * np.pi), v])


def elementary(surface: Geom_Surface) -> Elementary | None:
    kinds = ("Plane", "CylindricalSurface", "ConicalSurface", "SphericalSurface", "ToroidalSurface")
    known = bare(surface).DynamicType().Name() in {f"Geom_{kind}" for kind in kinds}
    return Elementary(surface) if known else None
