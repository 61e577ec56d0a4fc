"""Motions as polynomial matrices: pieces of time in which the pose is a rational function of one parameter u.

Straight and rational motions have u = t.  A rotation has u = tan(half the angle) over the length of its axis vector,
measured from the nearest whole number of half turns after its start, because those poses are rational for every axis;
so it is cut at its odd quarter turns, and sqrt(K) u stays between tan(-45 deg) and tan(45 deg).
Two rotations whose speeds are as small whole numbers m, n both are powers of one turn, at 1/m and 1/n of their speeds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from flint import arb, fmpq, fmpq_poly, fmpz

from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import dyadic, fraction, precision
from firstcontact.exact.rigid import IDENTITY, rational_sqrt
from firstcontact.exact.rigid import Matrix as Fixed
from firstcontact.exact.vectors import Vector, dot, scaled
from firstcontact.motion.moving import Moving
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.clocks import AngleClock, Root, StraightClock
from firstcontact.motion.relative.projective import Matrix
from firstcontact.motion.rotation import Rotation, angle_ball, sense_about
from firstcontact.motion.span import limits
from firstcontact.motion.steps import REST, steps_of
from firstcontact.motion.translation import Translation
from firstcontact.result import ExactTime

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion, Single

_0, _1 = fmpq(0), fmpq(1)
MOST_POWERS = 8
"""Of one turn: the degree of the pose is twice that."""


@dataclass(frozen=True, slots=True)
class PolynomialPiece:
    """The pose from `start` to `end` (None: without end), in the query's clock.

    pose      (4, 4) integer polynomials in u, without common factor, weight positive on [u_lo, u_hi].
    u_lo/u_hi rational bounds of u; u grows with the time.  They are exact under a straight clock, else outward:
              a root of theirs belongs to the piece when `contains` says so.  Poses beyond them are poses of the
              same motion at other times.
    clock     from u to the time.
    exact     False: the step starts in a pose that is irrational, and stands in a rational one within 2^-60 radians
              for each rotation that led to it.
    of        the motion and its body, as error texts name them.
    frame     relative pieces only: the pose of b in the same u; it carries the points of `pose` to the world.  None
              for bodies that turn about one line at different speeds.
    """

    start: fmpq
    end: fmpq | None
    pose: Matrix
    u_lo: fmpq
    u_hi: fmpq | None
    clock: StraightClock | AngleClock
    exact: bool
    of: str
    frame: Matrix | None = None

    @property
    def is_constant(self) -> bool:
        """Whether the pose is the same at all times."""
        return projective.degree(self.pose) <= 0

    def time_of(self, u: fmpq | arb) -> arb:
        """An enclosure of the time at u (a ball or fmpq), at the present precision."""
        return self.clock.time(u)

    def exact_time(self, root: Root) -> ExactTime | None:
        """The time of a root in u: Fraction, AlgebraicNumber, or ExactAngle where it is neither.

        None for roots that are known by enclosures only.
        """
        if root.polynomial is None:
            return None
        if isinstance(self.clock, AngleClock):
            for time in (self.start, self.end):
                if time is not None and self.clock.compare(root, time) == 0:
                    return fraction(time)
        return self.clock.exact_time(root)

    def contains(self, root: Root) -> bool:
        """Whether the root's time lies in the closed [start, end]; exact."""
        if self.clock.compare(root, self.start) < 0:
            return False
        return self.end is None or self.clock.compare(root, self.end) <= 0


def relative(a: PolynomialPiece, b: PolynomialPiece) -> PolynomialPiece:
    """The motion of a as seen from b in the time that both pieces share; they must share some.

    The pose is M_b^-1 M_a, with the transpose for the inverse where b's linear part is a scaled rotation (degrees
    2 r + s instead of those of the adjugate), common factors divided out.  Both must be rational in one u: two straight
    clocks, two rotations that have the same angle at all times, or one of them at rest; else UnsupportedPair.
    """
    start = max(a.start, b.start)
    ends = [x.end for x in (a, b) if x.end is not None]
    end = min(ends) if ends else None
    pose_a, pose_b, clock = _common(a, b)
    u_lo, u_hi = clock.parameters(start, end)
    exact, of = a.exact and b.exact, f"{a.of} as seen from {b.of}"
    if pose_b == projective.IDENTITY:
        return PolynomialPiece(start, end, pose_a, u_lo, u_hi, clock, exact, of, pose_b)
    pose = projective.reduced(projective.product(projective.inverse(pose_b, u_lo), pose_a), u_lo)
    return PolynomialPiece(start, end, pose, u_lo, u_hi, clock, exact, of, projective.reduced(pose_b, u_lo))


def relative_pieces(a: Body, b: Body, first: fmpq, last: fmpq | None) -> Iterator[PolynomialPiece]:
    """The pieces of the motion of body a as seen from body b over [first, last], in time order.

    As `relative`; besides, two rotations about one line are one rotation by the difference of their angles.  The frame
    of such a piece is None: it is no rational function of u.
    """
    windows_a, windows_b = steps_within(a, first, last), steps_within(b, first, last)
    x, y = next(windows_a, None), next(windows_b, None)
    # x and y are the steps at the time reached; the one that ends first is followed by its successor.
    while x is not None and y is not None:
        (step_a, start_a, end_a, of_a), (step_b, start_b, end_b, of_b) = x, y
        begin = max(start_a, start_b)
        end = end_b if end_a is None else end_a if end_b is None else min(end_a, end_b)
        if end is None or begin < end or first == last:
            turn = _difference(step_a, step_b)
            if turn is not None:
                yield from step_pieces(turn, begin, end, f"{of_a} as seen from {of_b}")
            else:
                powers = _powers(step_a, step_b)
                own, other = replace(step_a, power=powers[0]), replace(step_b, power=powers[1])
                pieces_a, pieces_b = step_pieces(own, begin, end, of_a), step_pieces(other, begin, end, of_b)
                yield from _overlaps(pieces_a, pieces_b, first == last)
        if end_b is None or (end_a is not None and end_a <= end_b):
            x = next(windows_a, None)
        else:
            y = next(windows_b, None)


def _overlaps(
    pieces_a: Iterator[PolynomialPiece], pieces_b: Iterator[PolynomialPiece], instant: bool
) -> Iterator[PolynomialPiece]:
    """The relative pieces of two runs of pieces over the same time."""
    x, y = next(pieces_a, None), next(pieces_b, None)
    while x is not None and y is not None:
        ends = [z.end for z in (x, y) if z.end is not None]
        if instant or not ends or max(x.start, y.start) < min(ends):
            yield relative(x, y)
        if y.end is None or (x.end is not None and x.end <= y.end):
            x = next(pieces_a, None)
        else:
            y = next(pieces_b, None)


def _common(a: PolynomialPiece, b: PolynomialPiece) -> tuple[Matrix, Matrix, StraightClock | AngleClock]:
    """Both poses in one parameter, and its clock."""
    if b.is_constant or a.is_constant:
        return a.pose, b.pose, a.clock if b.is_constant else b.clock
    if isinstance(a.clock, StraightClock) and isinstance(b.clock, StraightClock):
        return a.pose, b.pose, a.clock
    if isinstance(a.clock, AngleClock) and isinstance(b.clock, AngleClock) and a.clock.matches(b.clock):
        factor = rational_sqrt(a.clock.square / b.clock.square) or _1
        return a.pose, projective.substituted(b.pose, fmpq_poly([_0, factor])), a.clock
    raise UnsupportedPair(
        f"{a.of} with {b.of}: their relative motion is no rational function of one parameter; supported are two "
        "straight or rational motions, two rotations about one line or in phase at speeds like small whole numbers, "
        "and one moving body"
    )


# ------------------------------------------------------------------------------------------------------- steps


@dataclass(frozen=True, slots=True)
class PolynomialStep:
    """`motion`, after the rational pose `before` and followed by the fixed map `after`, over [start, end].

    start, end None: it goes on.  Its own time is (t - origin) / unit.  power: of the turn that u tells, for rotations.
    """

    motion: Any
    start: fmpq | None
    end: fmpq | None
    before: Fixed
    exact: bool
    origin: fmpq = _0
    unit: fmpq = _1
    after: Matrix | None = None
    power: int = 1


def steps_within(body: Body, first: fmpq, last: fmpq | None) -> Iterator[tuple[PolynomialStep, fmpq, fmpq | None, str]]:
    """(step, begin, end, name) of the steps of a body or motion in [first, last]; for an instant, one of them."""
    motion = body.motion if isinstance(body, Moving) else body if callable(body) else REST
    who = repr(name) if (name := getattr(body, "name", None)) else "a body"
    own = limits(motion)
    if own is not None and (first < own[0] or last is None or last > own[1]):
        raise InputError(f"{type(motion).__name__} of {who} has no poses outside its span {motion.span}")
    found = False
    for step in _rational_steps(motion):
        begin = first if step.start is None else max(first, step.start)
        end = last if step.end is None else step.end if last is None else min(last, step.end)
        if end is not None and (end < begin or (end == begin and (found or first != last))):
            continue
        found = True
        yield step, begin, end, f"{type(step.motion).__name__} of {who}"


def _rational_steps(motion: AnyMotion) -> Iterator[PolynomialStep]:
    for step in steps_of(motion):
        start = None if step.end is None else step.start
        yield PolynomialStep(
            step.motion, start, step.end, step.before.near(), step.before.is_exact, step.origin, step.unit
        )


def _difference(a: PolynomialStep, b: PolynomialStep) -> PolynomialStep | None:
    """The rotation of a as seen from b where both turn about one line at different speeds, else None.

    Turns about one line commute: with angles p (t - s) and q (t - r) it is the turn by (p - q) (t - o), between a's
    pose before it and the inverse of b's, with o = (p s - q r) / (p - q).
    """
    x, y = a.motion, b.motion
    if not _both_turn(x, y):
        return None
    p, q = x.angle / a.unit, y.angle / b.unit * sense_about(x, y)
    if q == 0 or p == q:
        return None
    turn = Rotation(x.axis, x.point, **{x.unit: p - q})
    after = projective.inverse(projective.fixed(b.before), _0)
    origin = (p * a.origin - q * b.origin) / (p - q)
    return PolynomialStep(turn, None, None, a.before, a.exact and b.exact, origin, _1, after)


def _powers(a: PolynomialStep, b: PolynomialStep) -> tuple[int, int]:
    """The whole numbers that the speeds of two rotations are in proportion to; (1, 1) where none are small."""
    x, y = a.motion, b.motion
    if _both_turn(x, y):
        ratio = abs(x.angle / a.unit / (y.angle / b.unit))
        if max(ratio.p, ratio.q) <= MOST_POWERS:
            return int(ratio.p), int(ratio.q)
    return 1, 1


def _both_turn(x: Single, y: Single) -> bool:
    """Whether both are rotations, by angles in one unit."""
    return isinstance(x, Rotation) and isinstance(y, Rotation) and x.angle != 0 and y.angle != 0 and x.unit == y.unit


def step_pieces(step: PolynomialStep, first: fmpq, last: fmpq | None, of: str) -> Iterator[PolynomialPiece]:
    """The pieces of one step over [first, last].

    last None: without end, for translations and rotations.  UnsupportedPair where the pose is no rational function
    of anything: a screw that turns and advances.
    """
    motion = step.motion
    if isinstance(motion, Rotation) and motion.angle != 0:
        yield from _turn_pieces(step, motion, first, last, of)
        return
    pose = projective.IDENTITY if step.before is IDENTITY else projective.fixed(step.before)
    own = projective.IDENTITY if isinstance(motion, Rotation) else own_pose(motion, of)
    if own != projective.IDENTITY:
        local = fmpq_poly([-step.origin / step.unit, 1 / step.unit])
        pose = projective.product(projective.substituted(own, local), pose)
    yield PolynomialPiece(first, last, projective.reduced(pose, first), first, last, StraightClock(), step.exact, of)


def own_pose(motion: AnyMotion, of: str) -> Matrix:
    """The pose of a straight or rational motion in its own time."""
    if isinstance(motion, RationalMotion):
        return motion.pose
    if not isinstance(motion, Translation):
        raise UnsupportedPair(
            f"{of}: {motion!r} has no rational pose in any parameter, so it has no exact contact equations"
        )
    if not any(motion.vector):
        return projective.IDENTITY
    return projective.integral([
        *([fmpq_poly([int(i == j)]) for j in range(3)] + [fmpq_poly([0, x])] for i, x in enumerate(motion.vector)),
        [fmpq_poly([int(j == 3)]) for j in range(4)],
    ])  # fmt: skip


def _turn_pieces(
    step: PolynomialStep, motion: Rotation, first: fmpq, last: fmpq | None, of: str
) -> Iterator[PolynomialPiece]:
    """The pieces of a rotation, cut where it has turned an odd number of quarter turns since its start."""
    axis = _primitive(motion.axis if motion.angle > 0 else scaled(-1, motion.axis))
    rate = abs(motion.angle) / step.unit / step.power
    clock = AngleClock(step.origin, rate, motion.unit, dot(axis, axis), 0)
    clock = replace(clock, halves=_half_turns(clock, first))
    while clock.cut() <= first and clock.cut() != last:
        clock = replace(clock, halves=clock.halves + 1)
    before = projective.fixed(step.before)
    # Invariant: all before `first` is covered, and `first` lies within a quarter turn of the clock's reference.
    while True:
        end = clock.cut() if last is None else min(clock.cut(), last)
        pose = projective.product(_turn_pose(clock, axis, motion.point, step.power), before)
        if step.after is not None:
            pose = projective.product(step.after, pose)
        u_lo, u_hi = clock.parameters(first, end)
        yield PolynomialPiece(first, end, projective.reduced(pose, u_lo), u_lo, u_hi, clock, step.exact, of)
        if end == last:
            return
        first, clock = end, replace(clock, halves=clock.halves + 1)


def _half_turns(clock: AngleClock, time: fmpq) -> int:
    """The number of half turns made by that time, rounded down: a reference at or before it."""
    with precision(256):
        made = 2 * angle_ball(clock.rate * (time - clock.origin), clock.unit) / (2 * arb.pi())
        mid = dyadic(made.mid())
    return int(mid.p // mid.q)


def _turn_pose(clock: AngleClock, axis: Vector, point: Vector, power: int) -> Matrix:
    """A power of the turn by 2 atan(sqrt(K) u) beyond the reference: of the quaternion 1 + u h, times h after odd
    half turns."""
    once = fmpq_poly([1]), fmpq_poly([0, 1])
    if clock.halves % 2:
        once = fmpq_poly([0, -clock.square]), fmpq_poly([1])
    scalar, along = once
    for _ in range(power - 1):
        scalar, along = scalar * once[0] - clock.square * along * once[1], scalar * once[1] + along * once[0]
    nil = fmpq_poly([0])
    rows = projective.of_quaternion((scalar, *(along * h for h in axis)), (nil, nil, nil))
    weight = rows[3][3]
    for k, row in enumerate(rows[:3]):
        row[3] = weight * point[k] - sum((x * c for x, c in zip(row[:3], point, strict=True)), nil)
    return projective.integral(rows)


def _primitive(axis: Vector) -> Vector:
    """The coprime integers in the direction of the axis."""
    below, content = fmpz(1), fmpz(0)
    for x in axis:
        below = below.lcm(x.q)
    for x in axis:
        content = content.gcd((x * below).p)
    return scaled(fmpq(below) / fmpq(content), axis)
