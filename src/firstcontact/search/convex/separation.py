"""How far two moving convex pieces are apart, in balls of any precision: s(t), the least of max f_k(x) over all x.

The f_k are convex functions, each zero or less in one half-space (plane or quadric) of one of the pieces.  So s > 0
where the pieces share no point.  At the least, the active functions are equal and some weights, none negative, make a
convex combination of gradients vanish; that is a square system in x, s, the weights and, if asked for, the time.

Proof of separation: for any x0 and any such weights, a common point x has
0 >= sum w_k f_k(x) >= sum w_k f_k(x0) + (x - x0) . sum w_k grad f_k(x0), as the functions are convex.  With x0 and the
weights as polynomials of the time, that is one power series with a remainder over a stretch of time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from flint import arb, arb_series, fmpq, fmpq_mat

from firstcontact.body.solid.carriers import Plane, Surface, dot, inertia
from firstcontact.exact.numbers import dyadic, exact_value, to_double
from firstcontact.motion.relative.curved import CurvedPiece, inverse, terms

BITS = 256
"""Of the balls in which the system is solved and proofs are made."""
TERMS = 4
"""Of the power series of a proof; the last one bounds the remainder."""
STEPS = 40
"""Of Newton's method, in all."""
JACOBIANS = 10
STUCK = 3
"""Jacobians in a row that do not halve the residual: more functions are active there than have a solution."""
STEP = fmpq(1, 2**72)
"""Of difference quotients, in units of the unknowns."""
ROUNDS, SHARPER = 6, 40.0
"""Of the barrier method, and by how much it is steeper in each."""
WEIGHT = 1e-5
"""Below which functions count as not active."""
CHANGES = 6
"""Of the active functions, before the least at a time is given up."""

BLUR = 1e-4
"""Of the size: how far doubles round off a cone's kinks, at its tip and on its axis, for Newton's method."""
ASIDE = np.array([0.03, 0.025, 0.02])
"""Of the size: from the middle of a piece, which may be on the axis of a cone, where its function has a kink."""
WAYS = np.vstack([np.eye(3), -np.eye(3)]) + 0.1
"""In which gradients are looked at for their usual length."""

STATIC, LEAST, ZERO = "static", "least", "zero"
"""What is solved for: the least at a time; where s has an extremum in time; where s is zero."""


class NoFunction(Exception):
    """A half-space that doubles do not tell a convex function of."""


class Unclear(Exception):
    """A function may be at the vertex of its cone, where it has no gradient, or the pose have no weight."""


class Convex:
    """A half-space as a convex function of local coordinates, <= 0 in it and with gradients of about 1 near it.

    A plane or a quadric that is convex itself is its own function.  Any other is P - l^2 with P >= 0 of no negative
    curvature and l linear, and its nappe with l > 0 is where sqrt(P) - l <= 0.
    """

    def __init__(self, form: Surface, witness: Sequence[fmpq], size: float) -> None:
        largest = max(abs(x) for row in form.matrix() for x in row)
        rows = [[x / largest for x in row] for row in form.matrix()]
        self.linear: list[fmpq] | None = None
        self.square = fmpq(1)
        block = tuple(tuple(row[:3]) for row in rows[:3])
        if not isinstance(form, Plane) and inertia(block)[1] > 0:
            e = _downward(rows)
            depth = -dot(e, [dot(row[:3], e) for row in rows[:3]])
            if depth <= 0:
                raise NoFunction("a cone too wide or too narrow")
            line = [dot(row[:3], e) for row in rows[:3]]
            centre = _centre_of(rows)
            line.append(-dot(line, centre))
            if dot(line, (*witness, fmpq(1))) < 0:
                line = [-x for x in line]
            rows = [[rows[i][j] + line[i] * line[j] / depth for j in range(4)] for i in range(4)]
            self.linear, self.square = line, 1 / depth
        self.rows = rows
        self.scale = fmpq(1)
        point = np.array([to_double(x) for x in witness])
        slopes = sorted(float(np.linalg.norm(self.at((point + size * way).tolist())[1])) for way in WAYS)
        if (middle := slopes[len(slopes) // 2]) > 0:
            self.scale = fmpq(2) ** -round(math.log2(middle))

    def at(self, y: Sequence[Any]) -> tuple[Any, list[Any]]:
        """(value, gradient) at y, numbers or power series of any kind; y without its 1."""
        number = _reader(y[0])
        image = [
            number(row[0]) * y[0] + number(row[1]) * y[1] + number(row[2]) * y[2] + number(row[3]) for row in self.rows
        ]
        value = image[0] * y[0] + image[1] * y[1] + image[2] * y[2] + image[3]
        scale = number(self.scale)
        if self.linear is None:
            return value * scale, [g * (2 * scale) for g in image[:3]]
        unit = _root(number(self.square))
        line = [number(x) * unit for x in self.linear]
        root = _root(value)
        if isinstance(root, arb_series) and not root[0] > 0:
            raise Unclear
        height = line[0] * y[0] + line[1] * y[1] + line[2] * y[2] + line[3]
        return (root - height) * scale, [(g / root - x) * scale for g, x in zip(image[:3], line, strict=False)]

    def doubles(self) -> tuple[np.ndarray, np.ndarray]:
        """(form (4, 4), line (4,)): the function is that of the form, or sqrt of it less the line if there is one."""
        rows, scale = np.array([[to_double(x) for x in row] for row in self.rows]), to_double(self.scale)
        if self.linear is None:
            return rows * scale, np.zeros(4)
        line = np.array([to_double(x) for x in self.linear]) * math.sqrt(to_double(self.square))
        return rows * scale * scale, line * scale


def _downward(rows: list[list[fmpq]]) -> list[fmpq]:
    """A rational direction near that of the most negative curvature."""
    block = np.array([[to_double(x) for x in row[:3]] for row in rows[:3]])
    values, vectors = np.linalg.eigh(block)
    e = vectors[:, int(np.argmin(values))]
    return [exact_value(x) for x in e]


def _centre_of(rows: list[list[fmpq]]) -> list[fmpq]:
    block = fmpq_mat([row[:3] for row in rows[:3]])
    return [x[0] for x in block.solve(fmpq_mat([[-row[3]] for row in rows[:3]])).tolist()]


def _reader(x: float | arb_series) -> Callable[[fmpq], float | arb]:
    if isinstance(x, float):
        return to_double
    return arb


def _root(x: Any) -> Any:
    return math.sqrt(max(x, 1e-300)) if isinstance(x, float) else x.sqrt()


class _Barrier:
    """sharp s - sum log(s - f_k(x)) over (x, s), in doubles; forms, lines: as `Convex.doubles` has them."""

    def __init__(self, forms: np.ndarray, lines: np.ndarray, blur: float) -> None:
        self.forms, self.lines, self.rooted = forms, lines, lines.any(axis=1)
        self.blur = blur * blur

    def values(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(n,) values, (n, 4) images of (x, 1) under the forms, (n,) roots, 1 where there is none."""
        point = np.append(x, 1.0)
        image = self.forms @ point
        value = image @ point
        root = np.where(self.rooted, np.sqrt(np.maximum(value, 0.0) + self.blur), 1.0)
        return np.where(self.rooted, root - self.lines @ point, value), image, root

    def height(self, x: np.ndarray, sharp: float) -> float:
        gaps = x[3] - self.values(x[:3])[0]
        return math.inf if not np.all(gaps > 0) else sharp * float(x[3]) - float(np.log(gaps).sum())

    def least(self, x: np.ndarray, sharp: float) -> np.ndarray | None:
        """By Newton's method from x, (4,)."""
        for _ in range(30):
            values, image, root = self.values(x[:3])
            gaps = x[3] - values
            if not np.all(gaps > 0.0):
                return None
            w = 1.0 / gaps
            factor = np.where(self.rooted, 1.0, 2.0) / root
            v = np.column_stack([image[:, :3] * factor[:, None] - self.lines[:, :3], -np.ones(len(w))])
            bent = self.forms[:, :3, :3] * factor[:, None, None]
            turned = np.where(self.rooted, root**-1.5, 0.0)[:, None] * image[:, :3]
            bent = bent - turned[:, :, None] * turned[:, None, :]
            curve = np.einsum("k,ki,kj->ij", w * w, v, v)
            curve[:3, :3] += np.einsum("k,kij->ij", w, bent)
            curve += 1e-14 * np.trace(curve) * np.eye(4)
            slope = w @ v
            slope[3] += sharp
            if not np.all(np.isfinite(curve)):
                return None
            step = -np.linalg.lstsq(curve, slope, rcond=None)[0]
            gain = -float(slope @ step)
            if gain < 1e-9:
                break
            length, here = 1.0, self.height(x, sharp)
            while length > 1e-10 and self.height(x + length * step, sharp) > here - 0.1 * length * gain:
                length *= 0.5
            if length <= 1e-10:
                break
            x = x + length * step
        return x


@dataclass(frozen=True)
class State:
    """x (3), s and the weights of the active functions at a time; exact numbers near the solution of the system."""

    time: fmpq
    x: list[fmpq]
    s: fmpq
    weights: list[fmpq]


@dataclass(frozen=True)
class Bound:
    """A function of the time is at least c0 + c1 |r| + c2 r^2 at time + r, |r| <= width; c1: for r < 0, for r > 0."""

    time: fmpq
    width: fmpq
    c0: arb
    c1: tuple[arb, arb]
    c2: arb

    @classmethod
    def of(cls, time: fmpq, width: fmpq, series: Sequence[arb], slack: Sequence[arb]) -> Bound:
        """Of the function with these coefficients, the last one of the remainder; slack: how much less each may be."""
        rest = arb(abs(series[3]).upper()) + slack[3]
        rates = -series[1] - slack[1], series[1] - slack[1]
        return cls(time, width, series[0] - slack[0], rates, series[2] - slack[2] - rest * arb(width))

    def is_positive(self, lo: fmpq, hi: fmpq) -> bool:
        """Whether the function is proved positive over [lo, hi], a part of the stretch."""
        lo, hi = lo - self.time, hi - self.time
        assert -self.width <= lo <= hi <= self.width
        with terms(1, BITS):
            before = lo >= 0 or self._positive(self.c1[0], max(-hi, fmpq(0)), -lo)
            return before and (hi < 0 or self._positive(self.c1[1], max(lo, fmpq(0)), hi))

    def _positive(self, c1: arb, p: fmpq, q: fmpq) -> bool:
        if not all(self.c0 + c1 * r + self.c2 * r * r > 0 for r in (arb(p), arb(q))):
            return False
        if not self.c2 > 0:
            return bool(self.c2 <= 0)  # concave
        foot = -c1 / (2 * self.c2)
        return bool(foot < arb(p) or foot > arb(q) or self.c0 - c1 * c1 / (4 * self.c2) > 0)


class Separation:
    """Two pieces over one piece of the motion of a as seen from b.

    own, other: the functions of either piece, in its own frame; reach: beyond any distance of a point of b's piece
    from one that is not farther than its size from it.
    """

    def __init__(self, motion: CurvedPiece, own: list[Convex], other: list[Convex], centre: np.ndarray, reach: float):
        self.motion, self.own, self.other = motion, own, other
        self.centre, self.size = centre, reach
        self.active: list[tuple[int, int]] = []
        self.span = motion.end - motion.start

    # -- in doubles ---------------------------------------------------------------------------------------------

    def guess(self, t: fmpq) -> State | None:
        """The least at time t in doubles; None where functions of one piece alone are active there."""
        state = self.roughly(t)
        return state if state is not None and {side for side, _ in self.active} == {0, 1} else None

    def roughly(self, t: fmpq) -> State | None:
        """The least at time t in doubles, by steps of a barrier method; it also says which functions are active."""
        with terms(1, 128):
            back = inverse(self.motion.series(arb(t)), self.motion.is_rigid)
            pose = np.array([[float(x[0].mid()) for x in row] for row in back] + [[0.0, 0.0, 0.0, 1.0]])
        forms, lines = (np.array([f.doubles()[k] for f in (*self.own, *self.other)]) for k in (0, 1))
        own = len(self.own)
        forms[:own], lines[:own] = pose.T @ forms[:own] @ pose, lines[:own] @ pose
        barrier = _Barrier(forms, lines, BLUR * self.size)
        x = np.append(self.centre + self.size * ASIDE, 0.0)
        x[3] = float(barrier.values(x[:3])[0].max()) + 0.1 * self.size
        sharp = 10.0 / self.size
        for _ in range(ROUNDS):
            moved = barrier.least(x, sharp)
            if moved is None:
                return None
            x, sharp = moved, SHARPER * sharp
        values = barrier.values(x[:3])[0]
        weights = 1.0 / np.maximum(x[3] - values, 1e-300)
        weights /= weights.sum()
        chosen = np.flatnonzero(weights > WEIGHT).tolist()
        self.active = [(0, k) if k < own else (1, k - own) for k in chosen]
        weights = [exact_value(weights[k]) for k in chosen]
        return State(t, [exact_value(c) for c in x[:3]], exact_value(values[chosen].max()), weights)

    # -- the system, in balls -----------------------------------------------------------------------------------

    def solve(self, state: State, what: str) -> State | None:
        """The solution near the state, to about BITS bits; None where the steps do not converge."""
        with terms(2, BITS):
            try:
                return self._solved(state, what)
            except Unclear:
                return None

    def least(self, guess: State) -> State | None:
        """The least at the time of the guess, to about BITS bits, with the functions active that are so there; None
        where it is not found, or at the vertex of a cone."""
        state: State | None = guess
        for _ in range(CHANGES):
            state = self.solve(state, STATIC)  # type: ignore[arg-type]
            if state is None:
                return None
            try:
                changed = self._revised(state)
            except Unclear:
                return None
            if changed is None:
                return state
            state = changed
        return None

    def _revised(self, state: State) -> State | None:
        """With a function less that would pull, or one more that is larger than s; None where the active ones fit."""
        lowest = min(state.weights)
        if lowest < 0 and -lowest > fmpq(1, 2**40):
            k = state.weights.index(lowest)
            if len([side for side, _ in self.active if side == self.active[k][0]]) == 1:
                return None
            del self.active[k]
            return replace(state, weights=[w for n, w in enumerate(state.weights) if n != k])
        others = [f for f in self._every() if f not in self.active]
        with terms(1, BITS):
            values = self._at(arb(state.time), [arb_series([arb(c)]) for c in state.x], others)[0]
            over = [(dyadic((v[0] - arb(state.s)).mid()), f) for v, f in zip(values, others, strict=True)]
        worst, function = max(over, default=(fmpq(0), (0, 0)))
        if worst <= exact_value(self.size) / 2**160:
            return None
        self.active.append(function)
        return replace(state, weights=[*state.weights, fmpq(0)])

    def _every(self) -> list[tuple[int, int]]:
        return [(0, k) for k in range(len(self.own))] + [(1, k) for k in range(len(self.other))]

    def _solved(self, state: State, what: str) -> State | None:
        scales = [self.size] * 4 + [1.0] * len(state.weights) + [to_double(self.span)]
        fixed = {STATIC: len(scales) - 1, ZERO: 3, LEAST: None}[what]
        free = [k for k in range(len(scales)) if k != fixed]
        z = [*state.x, state.s if what != ZERO else fmpq(0), *state.weights, state.time]
        best, back, made, stuck = math.inf, None, 0, 0
        for _ in range(STEPS):
            rest = self._residual(z, what)
            size = max(abs(float(r)) for r in rest)
            if not math.isfinite(size):
                return None
            if size < 2.0 ** (-0.75 * BITS):
                return State(z[-1], z[:3], z[3], z[4:-1])
            if back is None or size > 1e-5 * best:
                stuck = stuck + 1 if size > best / 2 else 0
                if made == JACOBIANS or stuck == STUCK:
                    return None
                back, made = self._inverse(z, what, free, scales), made + 1
            best = size
            step = back @ np.array([float(r) / size for r in rest])
            for k, d in zip(free, step, strict=True):
                z[k] = dyadic((arb(z[k]) - arb(float(d) * scales[k]) * arb(size)).mid())
        return None

    def _inverse(self, z: list[fmpq], what: str, free: list[int], scales: list[float]) -> np.ndarray:
        """A pseudo-inverse of the derivatives of the residuals by the free unknowns over their scales."""
        base, columns = self._residual(z, what), []
        for k in free:
            moved = list(z)
            step = STEP * exact_value(scales[k])
            moved[k] += step
            columns.append([float((r - q) / STEP) for r, q in zip(self._residual(moved, what), base, strict=True)])
        return np.linalg.pinv(np.array(columns).T, rcond=1e-11)

    def _residual(self, z: list[fmpq], what: str) -> list[arb]:
        """Of: f_k = s; weighted sum of gradients = 0; sum of weights = 1; for LEAST: weighted sum of rates = 0."""
        x, s, weights, t = [arb_series([arb(c)]) for c in z[:3]], arb(z[3]), [arb(w) for w in z[4:-1]], z[-1]
        values, gradients = self._at(arb(t), x, self.active)
        rest = [(v[0] - s).mid() * (1 / self.size) for v in values]
        rest += [sum((w * g[i][0] for w, g in zip(weights, gradients, strict=True)), arb(0)).mid() for i in range(3)]
        rest.append((sum(weights, arb(0)) - 1).mid())
        if what == LEAST:
            rate = sum((w * v[1] for w, v in zip(weights, values, strict=True)), arb(0))
            rest.append((rate * (to_double(self.span) / self.size)).mid())
        return rest

    def _at(
        self, t: arb, x: list[arb_series], functions: list[tuple[int, int]]
    ) -> tuple[list[arb_series], list[list[arb_series]]]:
        """Values and gradients of functions around the time, power series; x as those."""
        try:
            back = inverse(self.motion.series(t), self.motion.is_rigid)
        except ValueError as error:  # division by what may be zero, in so wide a ball of times
            raise Unclear from error
        y = [row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3] for row in back]
        values, gradients = [], []
        for side, k in functions:
            if side == 0:
                value, g = self.own[k].at(y)
                gradient = [back[0][j] * g[0] + back[1][j] * g[1] + back[2][j] * g[2] for j in range(3)]
            else:
                value, gradient = self.other[k].at(x)
            values.append(value)
            gradients.append([arb_series([c]) if isinstance(c, arb) else c for c in gradient])
        return values, gradients

    # -- proofs -------------------------------------------------------------------------------------------------

    def paths(self, state: State) -> list[list[fmpq]] | None:
        """x and the weights around the time of a solved state: value, slope and half the second derivative each."""
        h = self.span * fmpq(1, 2**56)
        beside = [self.solve(State(state.time + d, state.x, state.s, state.weights), STATIC) for d in (-h, h)]
        if beside[0] is None or beside[1] is None:
            return None
        before, after = ([*b.x, *b.weights] for b in beside)  # type: ignore[union-attr]
        here = [*state.x, *state.weights]
        return [
            [m, (q - p) / (2 * h), (p + q - 2 * m) / (2 * h * h)] for p, m, q in zip(before, here, after, strict=True)
        ]

    def apart(self, state: State, paths: list[list[fmpq]], width: fmpq) -> Bound | None:
        """A bound of s around the time of a solved state; None where the weights may be negative."""
        with terms(TERMS, BITS):
            ball, still, moved = self._around(paths, width)
            if not all(w[0] >= 0 for w in moved[3:]):
                return None
            try:
                near = self._weighted(arb(state.time), still)
                far = self._weighted(arb(state.time) + ball, moved)
            except Unclear:
                return None
            centre = [arb(exact_value(c)) for c in self.centre]
            reach = _length([m[0] - c for m, c in zip(moved, centre, strict=False)]) + arb(self.size)
            slack = [reach * _length([g[k] for g in (near, near, near, far)[k][1]]) for k in range(TERMS)]
            return Bound.of(state.time, width, _series(near[0], far[0]), slack)

    def is_apart(self, state: State) -> bool:
        """Whether the pieces are proved to share no point at the time of a solved state."""
        with terms(1, BITS):
            x, weights = [[arb(c)] for c in state.x], [[arb(max(w, fmpq(0)))] for w in state.weights]
            try:
                value, slopes = self._weighted(arb(state.time), [*x, *weights])
            except Unclear:
                return False
            centre = [arb(exact_value(c)) for c in self.centre]
            reach = _length([p[0] - c for p, c in zip(x, centre, strict=True)]) + arb(self.size)
            return bool(value[0] - reach * _length([g[0] for g in slopes]) > 0)

    def shared(self, state: State, paths: list[list[fmpq]], width: fmpq) -> list[Bound]:
        """Bounds of how deep the path of x is in either piece around the time of a solved state."""
        every = self._every()
        none = [arb(0)] * TERMS
        with terms(TERMS, BITS):
            ball, still, moved = self._around(paths[:3], width)
            try:
                near = self._at(arb(state.time), [arb_series(p) for p in still], every)[0]
                far = self._at(arb(state.time) + ball, [arb_series(p) for p in moved], every)[0]
            except Unclear:
                return []
            return [Bound.of(state.time, width, _series(-p, -q), none) for p, q in zip(near, far, strict=True)]

    def _around(self, paths: list[list[fmpq]], width: fmpq) -> tuple[arb, list[list[arb]], list[list[arb]]]:
        """The ball of times, and the paths in powers of the time from its middle and from each of its points."""
        ball = arb(0, width)
        moved = [[arb(c) + b * ball + a * ball * ball, arb(b) + 2 * a * ball, arb(a)] for c, b, a in paths]
        return ball, [[arb(c) for c in p] for p in paths], moved

    def _weighted(self, t: arb, paths: list[list[arb]]) -> tuple[arb_series, list[arb_series]]:
        """The weighted sums of values and of gradients, power series."""
        x, weights = [arb_series(p) for p in paths[:3]], [arb_series(p) for p in paths[3:]]
        values, gradients = self._at(t, x, self.active)
        total = sum((w * v for w, v in zip(weights, values, strict=True)), arb_series([0]))
        slopes = [sum((w * g[i] for w, g in zip(weights, gradients, strict=True)), arb_series([0])) for i in range(3)]
        return total, slopes

    def outward(self, state: State) -> list[arb]:
        """The weighted gradients of b's functions at a state: the direction from b towards a, in b's frame."""
        x = [arb_series([arb(c)]) for c in state.x]
        gradients = self._at(arb(state.time), x, self.active)[1]
        own = [(arb(w), g) for w, g, (side, _) in zip(state.weights, gradients, self.active, strict=True) if side == 1]
        return [sum((w * g[i][0] for w, g in own), arb(0)) for i in range(3)]

    def shares(self, t: fmpq, x: Sequence[fmpq]) -> bool:
        """Whether x is proved to be in both pieces at time t."""
        with terms(1, BITS):
            back = inverse(self.motion.series(arb(t)), self.motion.is_rigid)
            place = [arb(c) for c in x]
            y = [row[0][0] * place[0] + row[1][0] * place[1] + row[2][0] * place[2] + row[3][0] for row in back]
            return all(f.at(y)[0] <= 0 for f in self.own) and all(f.at(place)[0] <= 0 for f in self.other)


def _series(near: arb_series, far: arb_series) -> list[arb]:
    """The coefficients at the middle, and the last one over the whole stretch."""
    return [near[0], near[1], near[2], far[3]]


def _length(x: Sequence[arb]) -> arb:
    """At least the length of all vectors in the balls."""
    return arb(sum((arb(abs(c).upper()) ** 2 for c in x), arb(0)).sqrt().upper())
