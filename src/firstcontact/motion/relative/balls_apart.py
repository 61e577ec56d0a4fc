"""Are two moving balls apart all along?  Boxes of their paths in the world, in doubles, rounded outward.

That is far quicker than a search, and most pairs of a scene are far apart.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from firstcontact.exact.numbers import to_double
from firstcontact.kernels.pose_series import LocalPose
from firstcontact.motion.product import Product
from firstcontact.motion.relative.curved import CurvedPiece, Leg
from firstcontact.motion.relative.local_poses import local_pose, own_pose

if TYPE_CHECKING:
    from flint import fmpq

    from firstcontact.exact.vectors import Vector
    from firstcontact.motion.kinds import Single

# Of the sizes met: far more than some dozen roundings.
_SLACK = 1e-12
# Below it products of lengths leave the range of doubles.
_LOST = 2.0**-450
# Radians up to which a path is told by its ends and its bend.
_SHORT = 2.0

Corner = tuple[float, float, float]
_UNKNOWN: tuple[Corner, Corner] = (math.nan,) * 3, (math.nan,) * 3


class Ball(NamedTuple):
    """That holds a body, in its own frame."""

    centre: Corner
    radius: float

    @classmethod
    def of(cls, lo: np.ndarray, hi: np.ndarray) -> Ball:
        """That holds the box between two corners (3,)."""
        return cls(tuple((0.5 * (lo + hi)).tolist()), 0.5 * math.hypot(*(hi - lo).tolist()) * (1.0 + 1e-14))


def are_apart(piece: CurvedPiece, a: Ball, b: Ball) -> bool:
    """True proves that the bodies in the balls share no point during the piece; False tells nothing."""
    (lo_a, hi_a), (lo_b, hi_b) = _swept(piece.leg_a, piece, a), _swept(piece.leg_b, piece, b)
    return (
        lo_a[0] > hi_b[0] or lo_a[1] > hi_b[1] or lo_a[2] > hi_b[2]
        or lo_b[0] > hi_a[0] or lo_b[1] > hi_a[1] or lo_b[2] > hi_a[2]
    )  # fmt: skip


def turn_apart(axis: Vector, point: Vector, angle: tuple[fmpq, fmpq], a: Ball, b: Ball) -> bool:
    """The same where a turns about a line by (radians, turns) and b rests: how near the arc of a's centre comes to b's.
    """
    if math.dist(a.centre, b.centre) < a.radius + b.radius:
        return False
    (p0, p1, p2), (u0, u1, u2) = map(to_double, point), map(to_double, axis)
    length = math.hypot(u0, u1, u2)
    u0, u1, u2 = u0 / length, u1 / length, u2 / length
    (x, y, z), (r, s, t) = a.centre, b.centre
    x, y, z, r, s, t = x - p0, y - p1, z - p2, r - p0, s - p1, t - p2
    size = math.hypot(x, y, z, r, s, t, p0, p1, p2)
    enough = (a.radius + b.radius) * (1.0 + _SLACK) + _SLACK * size + _LOST
    up_a, up_b = x * u0 + y * u1 + z * u2, r * u0 + s * u1 + t * u2
    x, y, z, r, s, t = x - up_a * u0, y - up_a * u1, z - up_a * u2, r - up_b * u0, s - up_b * u1, t - up_b * u2
    out_a, out_b = math.hypot(x, y, z), math.hypot(r, s, t)
    if math.hypot(up_a - up_b, out_a - out_b) > enough:
        return True
    turned = to_double(angle[0]) + 2.0 * math.pi * to_double(angle[1])
    if not (out_a > 0.0 and out_b > 0.0):
        return False  # then the nearest place is at all angles
    x, y, z, r, s, t = x / out_a, y / out_a, z / out_a, r / out_b, s / out_b, t / out_b
    across = (y * t - z * s) * u0 + (z * r - x * t) * u1 + (x * s - y * r) * u2
    ahead = math.atan2(across if turned > 0.0 else -across, x * r + y * s + z * t) % (2.0 * math.pi)
    if not abs(turned) < ahead:
        return False
    beside = min(ahead - abs(turned), 2.0 * math.pi - ahead)
    chord = 2.0 * math.sqrt(out_a * out_b) * math.sin(0.5 * beside)
    return math.hypot(up_a - up_b, out_a - out_b, chord) > enough


def _swept(leg: Leg, piece: CurvedPiece, ball: Ball) -> tuple[Corner, Corner]:
    """Corners of a box of all places of the ball; nan where none is known."""
    if isinstance(leg.motion, Product):
        return _UNKNOWN  # `contact.runs` looks at all stretches of a link at once, by the speeds of its joints
    if leg.before.factors:
        return _box(local_pose(leg, piece), ball, leg.is_rigid)
    return _own_box(leg.motion, leg.part(piece.start, piece.end), ball)


@lru_cache(maxsize=4096)
def _own_box(motion: Single, part: tuple[int, int, int, int], ball: Ball) -> tuple[Corner, Corner]:
    """The same of a part of the motion itself: a body that moves is asked about with many others."""
    return _box(own_pose(motion, *part), ball, motion.is_rigid)


def _box(pose: LocalPose, ball: Ball, rigid: bool) -> tuple[Corner, Corner]:
    path = _turned if pose.turns else _bent
    lo, hi, stretch, size = path(pose, np.array(ball.centre))
    reach = (1.0 if rigid else stretch) * ball.radius
    pad = reach + _SLACK * (size + reach)
    return tuple((lo - pad).tolist()), tuple((hi + pad).tolist())


def _turned(pose: LocalPose, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Box of the path, a bound of what lengths are multiplied by, the largest number met."""
    fixed, cosine, sine, ahead = pose.terms[:, :, :3] @ centre + pose.terms[:, :, 3]
    rate = pose.angle[0, 0]
    swing = np.hypot(cosine, sine)
    largest = 1.0 + _SHORT + float(np.abs(centre).max())
    size = float(np.abs(pose.terms).sum(axis=0).max()) * largest
    stretch = float(np.linalg.norm(pose.terms[0, :, :3] + pose.terms[1, :, :3]))  # the same at all times
    if abs(rate) > _SHORT:
        return fixed + np.minimum(ahead, 0.0) - swing, fixed + np.maximum(ahead, 0.0) + swing, stretch, size
    first = fixed + cosine
    last = fixed + ahead + math.cos(rate) * cosine + math.sin(rate) * sine
    bend = swing * (rate * rate / 8.0)
    return np.minimum(first, last) - bend, np.maximum(first, last) + bend, stretch, size


def _bent(pose: LocalPose, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """The same, from the hull of control points."""
    bernstein = _bernstein(len(pose.weight))
    controls = (bernstein @ pose.terms.reshape(len(bernstein), -1)).reshape(pose.terms.shape)
    weights = bernstein @ pose.weight
    sizes = np.abs(pose.terms).sum(axis=0)
    if not weights.min() > _SLACK * float(np.abs(pose.weight).sum()):
        unknown = np.full(3, np.nan)
        return unknown, unknown, 1.0, 1.0
    controls /= weights[:, None, None]
    points = controls[:, :, :3] @ centre + controls[:, :, 3]
    size = float(sizes.max()) / float(weights.min()) * (1.0 + float(np.abs(centre).max()))
    stretch = float(np.sqrt((controls[:, :, :3] ** 2).sum(axis=(1, 2)).max()))
    return points.min(axis=0), points.max(axis=0), stretch, size


@lru_cache(maxsize=64)
def _bernstein(count: int) -> np.ndarray:
    """(count, count): Bernstein coefficients over [0, 1] of the powers; entries in [0, 1]."""
    return np.array([[math.comb(i, k) / math.comb(count - 1, k) for k in range(count)] for i in range(count)])
