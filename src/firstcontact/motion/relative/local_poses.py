"""The legs of a curved piece in doubles with bounds of their errors: what cells of time and boxes are made of."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpq_poly, fmpz_poly

from firstcontact.exact.numbers import ball, precision, to_double
from firstcontact.exact.vectors import dot
from firstcontact.kernels.pose_series import KEPT, LocalPose
from firstcontact.motion.placement import HERE
from firstcontact.motion.product import Product, Value
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.curved import CurvedPiece, Leg, turning
from firstcontact.motion.relative.turns import SLIGHT, TurningRows, turning_rows
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.motion.kinds import Single

_U = 2.0**-53
_BITS = 128
_ONE, _EXACT = np.ones(1), np.zeros(1)
_STILL = np.zeros((1, 3))


def local_pose(leg: Leg, piece: CurvedPiece) -> LocalPose:
    """The pose of one body during the piece, the time running from 0 to 1."""
    found = own_pose(leg.motion, *leg.part(piece.start, piece.end))
    return _after(found, leg.before.doubles()) if leg.before.factors else found


@lru_cache(maxsize=1024)
def own_pose(motion: Single, p: int, q: int, m: int, n: int) -> LocalPose:
    """The pose of the motion itself from its own time p / q on, for the time m / n."""
    begin, share = fmpq(p, q), fmpq(m, n)
    if isinstance(motion, RationalMotion):
        return _rational(motion, begin, share)
    if isinstance(motion, Rotation | Screw) and abs(motion.radians) * to_double(share) <= SLIGHT:
        found = turning_rows(motion, begin, share, HERE)
        if found.is_slight:
            return _slightly(found)
    if not isinstance(motion, Product):
        return _turning(motion, (begin, share))
    parts = [_turning(f.motion, f.within(begin, share)) for f in motion.factors]
    angle, ahead = (np.concatenate([getattr(part, key) for part in parts]) for key in ("angle", "ahead"))
    terms, errors = (np.concatenate([getattr(part, key) for part in parts]) for key in ("terms", "errors"))
    return LocalPose(True, angle, ahead, terms, errors, _ONE, _EXACT)


def _rational(motion: RationalMotion, begin: fmpq, share: fmpq) -> LocalPose:
    local = fmpq_poly([begin, share])
    rows = [[_fractions(x, local) for x in row] for row in motion.pose]
    weight = rows[3][3]
    scale = max(abs(c) for c in weight)
    count = max(len(x) for row in rows for x in row)
    out = np.zeros((count, 4, 4))
    for i, row in enumerate(rows):
        for j, coefficients in enumerate(row):
            out[: len(coefficients), i, j] = [to_double(c / scale) for c in coefficients]
    errors = np.abs(out) * _U
    entries, weights = (out[:, :3].copy(), errors[:, :3].copy()), (out[:, 3, 3].copy(), errors[:, 3, 3].copy())
    return LocalPose(False, _STILL, _STILL, *entries, *weights)


def _slightly(turning: TurningRows) -> LocalPose:
    """What polynomials leave out, 10 times the next coefficient at most, is an error of the last coefficient.

    All f^(n) / n!, n up to KEPT, have coefficient k as often as k is over n: that of KEPT + 1 at most 9 times as often
    as that of KEPT, and those behind it are far smaller.
    """
    table, left_out = turning.polynomials(KEPT)
    errors = np.abs(table) * (3.0 * np.arange(table.shape[1]) + 3.0) * _U
    errors[:, -1] += 10.0 * left_out
    terms, errors = (np.dstack([x[:9].T.reshape(-1, 3, 3), x[9:].T]) for x in (table, errors))
    weight = np.zeros(len(terms))
    weight[0] = 1.0
    return LocalPose(False, _STILL, _STILL, terms, errors, weight, np.zeros(len(terms)))


def _fractions(x: fmpz_poly, local: fmpq_poly) -> list[fmpq]:
    return list(fmpq_poly(x)(local).coeffs()) if x else []


def _turning(motion: Translation | Rotation | Screw, value: Value) -> LocalPose:
    """The pose of a simple motion at its own time `value`, a polynomial of the time that runs from 0 to 1.

    R(angle) = P + (1 - P) cos(angle) + N sin(angle), P the projection on the axis n and N the product with it.
    """
    terms = np.zeros((4, 3, 4))
    begin, ways = value[0] if value else fmpq(0), value[1:]
    unit = ways[0] if len(ways) == 1 else fmpq(1)
    ahead = np.zeros((1, 3))
    ahead[0, : len(ways)] = [to_double(x / unit) for x in ways] if unit else 0.0
    if isinstance(motion, Translation):
        v = motion.vector
        terms[0, :, :3] = np.eye(3)
        terms[0, :, 3] = [to_double(begin * x) for x in v]
        terms[3, :, 3] = [to_double(unit * x) for x in v]
        errors = np.abs(terms) * _U
        return LocalPose(True, _STILL, ahead, terms, errors, _ONE, _EXACT)
    n, maps = _axis(motion)
    with precision(_BITS):
        before = angle_ball(motion.angle * begin, motion.unit)
        sine, cosine = float(before.sin()), float(before.cos())
        angle = np.zeros((1, 3))
        angle[0, : len(ways)] = [float(angle_ball(motion.angle * x, motion.unit)) for x in ways]
    terms[0], swing, across = maps
    errors = np.abs(terms) * _U
    if isinstance(motion, Screw):
        for k, part in ((0, begin), (3, unit)):
            way = to_double(motion.advance * part) * n
            terms[k, :, 3] += way
            errors[k, :, 3] += 4.0 * _U * (np.abs(way) + np.abs(terms[k, :, 3]))
    terms[1], terms[2] = cosine * swing + sine * across, cosine * across - sine * swing
    errors[1] = errors[2] = 4.0 * _U * (abs(cosine) + abs(sine)) * (np.abs(swing) + np.abs(across))
    return LocalPose(True, angle, ahead, terms, errors, _ONE, _EXACT)


@lru_cache(maxsize=1024)
def _axis(motion: Rotation | Screw) -> tuple[np.ndarray, np.ndarray]:
    """The unit vector n (3,), the maps P, 1 - P and N about the axis (3, 3, 4): every entry rounded once."""
    *maps, _ = turning(motion, 2 * _BITS)
    with precision(2 * _BITS):
        length = ball(dot(motion.axis, motion.axis)).sqrt()
        n = [float(ball(x) / length) for x in motion.axis]
    return np.array(n), np.array([[[float(x) for x in row] for row in m] for m in maps])


def _after(pose: LocalPose, first: np.ndarray) -> LocalPose:
    """The pose applied after a fixed map (4, 4), rounded to doubles."""
    terms, size = pose.terms @ first, np.abs(first)
    errors = pose.errors @ size + 8.0 * _U * (np.abs(pose.terms) @ size)
    return pose._replace(terms=terms, errors=errors)
