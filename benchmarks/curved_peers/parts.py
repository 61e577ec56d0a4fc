"""Parts with holes, described once and built by firstcontact and by OpenCASCADE; their motions."""

from __future__ import annotations

from functools import reduce

import firstcontact as fc
from curved_peers.paths import Path


class Ours:
    """The builders of firstcontact, in the words that `OpenCascade` has too."""

    def box(self, size, at):
        return fc.box(size).translated(at)

    def cylinder(self, radius, height, at, axis="z"):
        made = fc.cylinder(radius, height)
        return (made if axis == "z" else made.rotated((0, 1, 0), degrees=90)).translated(at)

    def frustum(self, bottom, top, height, at):
        return fc.frustum(bottom, top, height).translated(at)

    def cut(self, a, b):
        return a - b

    def fuse(self, a, b):
        return a | b


def chamfered_pin(k):
    return k.fuse(k.cylinder(0.875, 4.0, (0, 0, 2)), k.frustum(0.625, 0.875, 0.25, (0, 0, -0.25)))


def counterbored_plate(k):
    drilled = k.cut(k.box((8.0, 8.0, 2.0), (0, 0, 0)), k.cylinder(1.0, 4.0, (0, 0, 0)))
    return k.cut(drilled, k.cylinder(1.5, 2.0, (0, 0, 1)))


def drilled_bracket(k):
    """A foot with two holes, a wall with one."""
    angle = k.fuse(k.box((6.0, 4.0, 1.0), (0, 0, 0)), k.box((1.0, 4.0, 4.0), (2.5, 0, 1.5)))
    holes = [k.cylinder(0.5, 3.0, (x, 0, 0)) for x in (-2, 0)] + [k.cylinder(0.75, 3.0, (2.5, 0, 2), axis="x")]
    return reduce(k.cut, holes, angle)


def tube(k):
    return k.cut(k.cylinder(1.5, 3.0, (0, 0, 0)), k.cylinder(1.125, 4.0, (0, 0, 0)))


Z, X = (0, 0, 1), (1, 0, 0)
SCENES = (
    ("pin into a counterbored hole, straight", chamfered_pin, counterbored_plate, Path((0.3, 0.1, -3), Z, 0, 6.0),
     (-0.4, 0, 4.5)),
    ("pin into a counterbored hole, turning", chamfered_pin, counterbored_plate, Path(X, (0, 9, 5), 40, 0),
     (0.2, 0, 5)),
    ("pin into a counterbored hole, screw", chamfered_pin, counterbored_plate, Path(Z, (0.3, 0, 0), 60, -6.0),
     (0.25, 0, 5)),
    ("pin through the hole, no contact", chamfered_pin, counterbored_plate, Path((0, 0, -1), Z, 0, 6.0),
     (0.0625, 0, 5)),
    ("drilled brackets, straight", drilled_bracket, drilled_bracket, Path((-0.4, 0.2, -1), Z, 0, 6.0),
     (1, 0.5, 5)),
    ("drilled brackets, turning", drilled_bracket, drilled_bracket, Path((0.2, 1, 0.1), (-6, 0, 2), 50, 0),
     (1, 0.5, 5)),
    ("tube over a pin, screw", tube, chamfered_pin, Path(Z, (0.5, 0, 0), 90, -6.0), (0.25, 0, 9)),
)  # fmt: skip
"""name, moving part, resting part, path, where the moving part starts."""
