"""Motions as stretches of time in the form that the kernels of `kernels.poses` read, with proved errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, overload

import numpy as np
from flint import arb, fmpq, fmpq_poly

from firstcontact.exact.numbers import above, below, dyadic, precision, to_double
from firstcontact.exact.rigid import Matrix
from firstcontact.kernels.poses import (
    CENTRE,
    DEGREE,
    ERROR_R,
    ERROR_T,
    ERROR_W,
    KIND,
    OMEGA,
    PER_HALF,
    RATIONAL,
    SINE_EPS,
    STRAIGHT,
    TURNING,
)
from firstcontact.motion.moving import Moving
from firstcontact.motion.placement import Placement
from firstcontact.motion.product import Product
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.curved import own_series, terms
from firstcontact.motion.relative.polynomial import own_pose
from firstcontact.motion.relative.turns import BITS, middle, turning_rows
from firstcontact.motion.rotation import Rotation, turns_of
from firstcontact.motion.screw import Screw
from firstcontact.motion.steps import REST, Step, steps_of
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion

U = 2.0**-53
# Largest half angle (radians) of one stretch: `sine_cosine` reduces arguments below 2^10.
MOST_RADIANS = 1000.0
# Of a window, which is two halves long.
MOST_TURNS = 300
# A product of motions turns a sixth of a turn in one window, less where the values of joints bend there, and is a
# polynomial of TERMS coefficients.  What is left out is enclosed.  It is below LEFT_OUT of the sizes, and so are its
# first derivatives but for powers of TERMS: far below the roundings of coefficients, which the kernels allow for.
TURNS, TERMS, LEFT_OUT = fmpq(1, 6), 20, 2.0**-79


class Untold(Exception):
    """A motion that the kernels cannot follow; the text says why."""


class Window(NamedTuple):
    """Both motions as (14, n) arrays over [first, last], exact times rounded outward; inner: `last` rounded inward."""

    first: float
    last: float
    inner: float
    a: np.ndarray
    b: np.ndarray


class WindowsInTurn(Sequence[Window]):
    """The windows of time in which two bodies follow one step each, in order, made as they are asked for: those of many
    turns take milliseconds each.

    first, last: doubles around all of them.
    """

    def __init__(self, motions: tuple[AnyMotion, AnyMotion], first: fmpq, last: fmpq) -> None:
        self.motions = motions
        self.steps = [known_steps(m) for m in motions]
        cuts = {first, last}
        for own in self.steps:
            for step in own:
                if step.end is not None:
                    cuts |= {t for t in (step.start, *_inner_cuts(step), step.end) if first < t < last}
                cuts.update(_between_turns(step, first, last))
        times = sorted(cuts)
        self.times = list(zip(times, times[1:] or times, strict=False))
        self.first, self.last = below(first), above(last)
        self.made: dict[int, Window] = {}

    def __len__(self) -> int:
        return len(self.times)

    @overload
    def __getitem__(self, k: int) -> Window: ...

    @overload
    def __getitem__(self, k: slice) -> list[Window]: ...

    def __getitem__(self, k: int | slice) -> Window | list[Window]:
        """Raises Untold."""
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        k = range(len(self))[k]
        if k not in self.made:
            begin, end = self.times[k]
            of_both = zip(self.motions, self.steps, strict=True)
            pair = [_stretch(m, step_index(own, begin, end), begin, end) for m, own in of_both]
            self.made[k] = Window(*_rounded(begin, end), *pair)
        return self.made[k]


def windows(a: Body, b: Body, first: fmpq, last: fmpq) -> list[Window]:
    """All windows.  Raises Untold."""
    return list(windows_in_turn(a, b, first, last))


def windows_in_turn(a: Body, b: Body, first: fmpq, last: fmpq) -> WindowsInTurn:
    """The windows, each made when its turn comes."""
    motion_a = a.motion if isinstance(a, Moving) else REST
    motion_b = b.motion if isinstance(b, Moving) else REST
    return _windows_of(motion_a, motion_b, int(first.p), int(first.q), int(last.p), int(last.q))


@lru_cache(maxsize=128)
def _windows_of(motion_a: AnyMotion, motion_b: AnyMotion, p: int, q: int, r: int, s: int) -> WindowsInTurn:
    """Over [p / q, r / s]: whole numbers, since rationals take a microsecond to hash."""
    return WindowsInTurn((motion_a, motion_b), fmpq(p, q), fmpq(r, s))


def _inner_cuts(step: Step) -> list[fmpq]:
    """Where a product of motions is cut."""
    if not isinstance(step.motion, Product):
        return []
    turns, degree = step.motion.turns, max(len(f.value) for f in step.motion.factors) - 1
    count = max(1, int((turns / TURNS).ceil()))
    while degree > 1 and _left_out(2.0 * math.pi * to_double(turns), degree, count) > LEFT_OUT:
        count += 1 + count // 16
    return [step.start + step.unit * k / count for k in range(1, count)]


def _between_turns(step: Step, first: fmpq, last: fmpq) -> list[fmpq]:
    """Where a rotation or screw of many turns is cut, for its angles to be told closely enough."""
    if not isinstance(step.motion, Rotation | Screw):
        return []
    begin, end = (first, last) if step.end is None else (max(first, step.start), min(last, step.end))
    count = int((turns_of(step.motion) * (end - begin) / (step.unit * MOST_TURNS)).ceil()) if begin < end else 1
    return [begin + (end - begin) * k / count for k in range(1, count)]


def _left_out(angle: float, degree: int, count: int) -> float:
    """A bound of the coefficient of s^TERMS in exp(i angle(s)), |s| <= 1 over one of `count` equal windows.

    angle: that of the way of the values, polynomials p of that degree in a time from 0 to 1.  For their p^(k) / k! are
    at most 1 / k of the binomial (degree - 1, k - 1) times it, and exp(x_1 s + ...) has n e_n = sum k x_k e_(n-k).
    """
    x = [angle * math.comb(degree - 1, k - 1) / k * (0.5 / count) ** k for k in range(1, degree + 1)]
    e = [1.0]
    for n in range(1, TERMS + 1):
        e.append(sum(k * c * e[n - k] for k, c in enumerate(x[:n], 1)) / n)
    return e[TERMS]


@lru_cache(maxsize=128)
def _rounded(begin: fmpq, end: fmpq) -> tuple[float, float, float]:
    return below(begin), above(end), below(end)


@lru_cache(maxsize=128)
def known_steps(motion: AnyMotion) -> tuple[Step, ...]:
    return tuple(steps_of(motion))


def step_index(steps: tuple[Step, ...], begin: fmpq, end: fmpq) -> int:
    """The step in charge of [begin, end]; of one instant that which begins then, as the body may jump."""
    for k in reversed(range(len(steps))):
        if steps[k].covers(begin, end):
            return k
    raise Untold("no pose")


def step_near(steps: tuple[Step, ...], time: fmpq) -> Step:
    """The step in charge at a time.

    Roundings and Newton's method lead a little beyond the motion, where its first or its last step goes on.
    """
    return next((step for step in steps if step.end is None or time <= step.end), steps[-1])


@lru_cache(maxsize=256)
def _stretch(motion: AnyMotion, index: int, begin: fmpq, end: fmpq) -> np.ndarray:
    step = known_steps(motion)[index]
    centred = to_double((begin + end) / 2)
    half = max(to_double(end - begin) / 2 * (1 + 1e-9), 1e-300)
    if end == begin:
        half = 1.0
    head = np.zeros(9)
    head[CENTRE], head[PER_HALF] = centred, 1.0 / half
    # the exact scale that the kernel uses is that of the double 1 / half
    centre, scale = fmpq(*centred.as_integer_ratio()), 1 / fmpq(*float(head[PER_HALF]).as_integer_ratio())
    turns = isinstance(step.motion, Rotation | Screw)
    form = _turning if turns else _product if isinstance(step.motion, Product) else _rational
    coefficients = form(step, centre, scale, head)
    table = np.zeros((14, max(len(head), coefficients.shape[1])))
    table[0, : len(head)], table[1:, : coefficients.shape[1]] = head, coefficients
    if not np.all(np.isfinite(table)):
        raise Untold("numbers beyond the range of doubles")
    return table


def _rational(step: Step, centre: fmpq, scale: fmpq, head: np.ndarray) -> np.ndarray:
    """Polynomials in s = (t - centre) / scale."""
    head[KIND] = RATIONAL
    if isinstance(step.motion, Translation) and not step.before.factors:
        return _straight(step, centre, scale, head)
    before, (off_r, off_t) = _rounded_pose(step.before)
    local = fmpq_poly([step.share(centre), scale / step.unit])
    own = projective.substituted(own_pose(step.motion, "a body"), local)
    held = projective.fixed(before)
    pose = projective.product(own, held)
    rows = [[fmpq_poly(x) for x in row] for row in pose]
    weight = rows[3][3]
    largest = max(abs(x) for x in weight.coeffs())
    straight = weight.degree() == 0
    factor = (1 if not straight or weight[0] > 0 else -1) / largest
    entries = [rows[i][j] for i in range(3) for j in range(3)] + [rows[i][3] for i in range(3)] + [weight]
    n = 1 + max(x.degree() for x in entries)
    table = np.zeros((13, n))
    for e, p in enumerate(entries):
        for k, x in enumerate(p.coeffs()):
            table[e, k] = to_double(x * factor)
    if not straight and table[12] @ np.array([0.0**k for k in range(n)]) < 0:
        table = -table
    head[STRAIGHT] = float(straight)
    # coefficients rounded once; two roundings per step of Horner's rule; s itself within 4 U
    sums = np.abs(table) @ (8.0 * np.arange(n) + 3.0) * U
    head[ERROR_R], head[ERROR_T] = sums[:9].max(), sums[9:12].max()
    if off_r or off_t:  # the sum over the linear entries of `own`, each times one of `before`
        unit = factor * fmpq(held[3][3][0])
        turn = 2 * sum(abs(to_double(fmpq(c) * unit)) for row in own[:3] for x in row[:3] for c in x.coeffs())
        head[ERROR_R], head[ERROR_T] = head[ERROR_R] + turn * off_r, head[ERROR_T] + turn * off_t
    head[ERROR_W] = 0.0 if straight else sums[12]
    head[DEGREE] = n - 1
    return table


def _product(step: Step, centre: fmpq, scale: fmpq, head: np.ndarray) -> np.ndarray:
    """Polynomials in s = (t - centre) / scale by Taylor; what they leave out is the next term at some |s| <= 1, or a
    hair more (Lagrange)."""
    head[KIND], head[STRAIGHT], head[DEGREE] = RATIONAL, 1.0, TERMS - 1
    speed = scale / step.unit
    ends = [arb(step.share(centre + way * scale)) for way in (-1, 1)]
    with terms(TERMS + 1, BITS):
        sharp = own_series(step.motion, arb(step.share(centre)), speed)
        blurred = own_series(step.motion, ends[0].union(ends[1]), speed)
    rows = [(sharp[i][j], blurred[i][j]) for i in range(3) for j in range(3)]
    rows += [(sharp[i][3], blurred[i][3]) for i in range(3)]
    table, off = np.zeros((13, TERMS)), np.zeros(12)
    table[12, 0] = 1.0
    for e, (p, q) in enumerate(rows):
        balls = [p[k] for k in range(TERMS)]
        table[e] = [middle(c) for c in balls]
        off[e] = sum(float(c.rad()) for c in balls) + 1.0001 * float(q[TERMS].abs_upper())
    off += np.abs(table[:12]) @ (8.0 * np.arange(TERMS) + 3.0) * U  # as `_rational`
    head[ERROR_R], head[ERROR_T] = off[:9].max(), off[9:].max()
    return table


def _rounded_pose(before: Placement) -> tuple[Matrix, tuple[float, float]]:
    """A rational matrix, and how far its linear entries and its shift are from the pose's at most."""
    if before.is_exact:
        return before.matrix(), (0.0, 0.0)
    with precision(BITS):
        balls = before.matrix()
        off = [[above(dyadic(arb(x).rad())) for x in row] for row in balls]
        rows = tuple(tuple(dyadic(arb(x).mid()) for x in row) for row in balls)
        return rows, (max(max(row[:3]) for row in off), max(row[3] for row in off))  # type: ignore[return-value]


def _straight(step: Step, centre: fmpq, scale: fmpq, head: np.ndarray) -> np.ndarray:
    """As `_rational`, for a translation from the identity, and faster."""
    table = np.zeros((13, 2))
    table[[0, 4, 8, 12], 0] = 1.0
    here, rate = step.share(centre), scale / step.unit
    for k, x in enumerate(step.motion.vector):
        if x:
            table[9 + k] = to_double(x * here), to_double(x * rate)
    head[STRAIGHT], head[DEGREE] = 1.0, 1.0
    head[ERROR_T] = float((np.abs(table[9:12]) @ (3 * U, 11 * U)).max())
    return table


def _turning(step: Step, centre: fmpq, scale: fmpq, head: np.ndarray) -> np.ndarray:
    """Linear in 1, sin, 1 - cos of the angle turned since `centre`, and s = (t - centre) / scale; polynomials in s
    where these tell it better."""
    found = turning_rows(step.motion, step.share(centre), scale / step.unit, step.before)
    table, head[OMEGA] = found.rows, found.omega
    if found.is_slight:
        table, _ = found.polynomials(found.degree)
        # coefficients as told; two roundings per step of Horner's rule; s itself within 4 U; the rest below one of U
        errors = np.abs(table) @ (9.0 * np.arange(table.shape[1]) + 3.0) * U
        head[KIND], head[STRAIGHT], head[DEGREE] = RATIONAL, 1.0, table.shape[1] - 1
    else:
        head[KIND] = TURNING
        if abs(found.omega) > MOST_RADIANS:
            raise Untold("too many turns")
        # entries and omega rounded once, the sum of four terms, s within 4 U, the sine within SINE_EPS
        off = np.array([8 * U, 8 * U, 16 * U, 12 * U])
        wobble = SINE_EPS + 8 * U * abs(found.omega)
        errors = np.abs(table) @ off + (np.abs(table[:, 1]) + np.abs(table[:, 2])) * wobble
    head[ERROR_R], head[ERROR_T] = errors[:9].max(), errors[9:].max()
    weight = np.zeros(table.shape[1])
    weight[0] = float(found.is_slight)
    return np.vstack([table, weight])
