"""Motions for our query and, in plain doubles, for the other tools' loops."""

from __future__ import annotations

import math

import numpy as np

import firstcontact as fc


class Path:
    """Turn about the axis through a point, and advance along a vector meanwhile, over [0, 1].

    ours: the same as a motion of firstcontact; pose(t): (R, v).
    """

    def __init__(self, axis, point, degrees: float, advance: float) -> None:
        axis, point = np.array(axis, float), np.array(point, float)
        unit = axis / np.linalg.norm(axis)
        self.angle, self.forward = math.radians(degrees), advance * unit
        if not degrees:
            self.ours = fc.Translation(self.forward)
        elif not advance:
            self.ours = fc.Rotation(axis, point=point, degrees=degrees)
        else:
            self.ours = fc.Screw(axis, point=point, degrees=degrees, advance=advance)
        self.across = np.cross(np.eye(3), unit)
        self.square = self.across @ self.across
        self.centre = point
        self.off_axis = float(np.linalg.norm(np.cross(unit, point)))

    def pose(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        if not self.angle:
            return np.eye(3), t * self.forward
        angle = t * self.angle
        rotation = np.eye(3) + math.sin(angle) * self.across + (1 - math.cos(angle)) * self.square
        return rotation, self.centre - rotation @ self.centre + t * self.forward

    def speed(self, reach: float) -> float:
        """No point of a body is faster that lies within `reach` of the origin at the start."""
        return math.hypot(np.linalg.norm(self.forward), self.angle * (reach + self.off_axis))
