"""Bodies and motions of the soak of ruled surfaces: their text, points and poses, by definitions of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction as F
from random import Random

import numpy as np

from .exact_numbers import (
    Matrix,
    Polynomial,
    Vector,
    add,
    dot,
    image,
    inverse,
    polynomial_sum,
    power,
    product,
    scaled,
    sub,
    times,
    turn,
    value,
    vector,
)

ONE: Matrix = ((F(1), F(0), F(0)), (F(0), F(1), F(0)), (F(0), F(0), F(1)))


def number(x: F) -> str:
    """A fraction as text of a program."""
    x = F(x)
    if x.denominator == 1:
        return str(x.numerator)
    if F(float(x)) == x:
        return repr(float(x))
    return f"F({x.numerator}, {x.denominator})"


def tuple_text(x: Sequence[F]) -> str:
    return "(" + ", ".join(number(c) for c in x) + ")"


def polynomial_text(p: Sequence[F], letter: str = "u") -> str:
    """As a directrix string has it: no decimal points."""
    terms = []
    for i, c in enumerate(p):
        if c:
            by = f"{c.numerator}" if c.denominator == 1 else f"{c.numerator}/{c.denominator}"
            terms.append(f"({by})" + ("" if i == 0 else f"*{letter}" if i == 1 else f"*{letter}**{i}"))
    return " + ".join(terms) or "0"


@dataclass(frozen=True)
class Frame:
    """x -> linear x + offset; scale where it is a turn times a number, else None."""

    linear: Matrix = ONE
    offset: Vector = (F(0), F(0), F(0))
    scale: F | None = F(1)

    def point(self, x: Vector) -> Vector:
        return add(image(self.linear, x), self.offset)

    def direction(self, x: Vector) -> Vector:
        return image(self.linear, x)

    @property
    def matrix4(self) -> list[list[F]]:
        return [[*row, c] for row, c in zip(self.linear, self.offset, strict=True)] + [[F(0), F(0), F(0), F(1)]]


def random_frame(rng: Random, similar: bool = True, wild: bool = True) -> Frame:
    """A turned, scaled and shifted frame; sheared too unless it must be similar."""
    if rng.random() < 0.3:
        return Frame()
    linear = rng.choice((ONE, turn(1, 1, 0, 0), turn(1, 1, 1, 1), turn(2, 1, 0, 0), turn(*_quaternion(rng))))
    scale = F(1)
    if wild and rng.random() < 0.3:
        scale = F(2) ** rng.choice((-40, -20, -7, 3, 20, 40))
    elif rng.random() < 0.3:
        scale = rng.choice((F(3), F(1, 3), F(10), F(7, 5)))
    if not similar and rng.random() < 0.4:
        shear = [[F(rng.randint(-2, 2)) for _ in range(3)] for _ in range(3)]
        for i in range(3):
            shear[i][i] = F(7)
        linear, similar = product(linear, tuple(map(tuple, shear))), False  # type: ignore[arg-type]
        kept = None
    else:
        kept = scale
    offset = vector([rng.randint(-3, 3) for _ in range(3)])
    if wild and rng.random() < 0.15:
        offset = scaled(offset, 2**20)
    return Frame(tuple(scaled(row, scale) for row in linear), scaled(offset, scale), kept)  # type: ignore[arg-type]


def _quaternion(rng: Random) -> tuple[int, int, int, int]:
    while True:
        q = tuple(rng.randint(-3, 3) for _ in range(4))
        if any(q):
            return q  # type: ignore[return-value]


# ---------------------------------------------------------------------------------------------------- directrices


@dataclass(frozen=True)
class Curve:
    """u -> (X, Y, Z)(u) / W(u), and `lift` times a polynomial of the time T besides."""

    x: tuple[Polynomial, Polynomial, Polynomial]
    w: Polynomial = field(default_factory=lambda: [F(1)])

    @property
    def degree(self) -> int:
        return max(len(p) for p in (*self.x, self.w)) - 1

    def at(self, u: F) -> Vector:
        w = value(self.w, u)
        return tuple(value(p, u) / w for p in self.x)  # type: ignore[return-value]

    def mapped(self, frame: Frame) -> Curve:
        rows = []
        for row, c in zip(frame.linear, frame.offset, strict=True):
            total = [c * k for k in self.w]
            for a, p in zip(row, self.x, strict=True):
                total = polynomial_sum(total, [a * k for k in p])
            rows.append(total)
        return Curve((rows[0], rows[1], rows[2]), self.w)

    def along(self, top: Polynomial, bottom: Polynomial) -> Curve:
        """The same curve with top(u) / bottom(u) put for u."""
        n = self.degree
        def put(p: Polynomial) -> Polynomial:
            out = [F(0)]
            for i, c in enumerate(p):
                out = polynomial_sum(out, [c * k for k in times(power(top, i), power(bottom, n - i))])
            return out
        return Curve((put(self.x[0]), put(self.x[1]), put(self.x[2])), put(self.w))

    def text(self, as_lists: bool, lift: tuple[Vector, Polynomial] | None = None) -> str:
        if lift is None and as_lists:
            rows = ", ".join("[" + ", ".join(number(c) for c in p) + "]" for p in self.x)
            return f"fc.RationalCurve([{rows}], [{', '.join(number(c) for c in self.w)}])"
        parts = []
        for i, p in enumerate(self.x):
            part = polynomial_text(p)
            if len(self.w) > 1 or self.w[0] != 1:
                part = f"({part})/({polynomial_text(self.w)})"
            if lift is not None and lift[0][i]:
                part += f" + ({polynomial_text([lift[0][i]])})*({polynomial_text(lift[1], 'T')})"
            parts.append(part)
        return '"(' + ", ".join(parts) + ')"'

    def floats(self, u: np.ndarray) -> np.ndarray:
        """(n, 3) points at parameters u, which may be infinite."""
        big = np.abs(u) > 1
        v = np.where(big, 1 / np.where(u == 0, 1, u), u)
        n = self.degree
        values = []
        for p in (*self.x, self.w):
            c = np.array([float(k) for k in p] + [0.0] * (n + 1 - len(p)))
            low, high = np.zeros_like(v), np.zeros_like(v)
            for k in range(n, -1, -1):
                low = low * v + c[k]
                high = high * v + c[n - k]
            values.append(np.where(big, high, low))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.stack(values[:3], -1) / values[3][..., None]


def straight(p: Vector, q: Vector) -> Curve:
    """p at u = 0, q at u = 1."""
    d = sub(q, p)
    return Curve(([p[0], d[0]], [p[1], d[1]], [p[2], d[2]]))


PASSAGES: tuple[tuple[Polynomial, Polynomial], ...] = (  # of [0, 1] onto itself, rising
    ([F(0), F(1)], [F(1)]),
    ([F(0), F(1)], [F(1)]),
    ([F(0), F(2)], [F(1), F(1)]),
    ([F(0), F(1)], [F(3), F(-2)]),
    ([F(0), F(1, 2), F(1, 2)], [F(1)]),
    ([F(0), F(0), F(1)], [F(1)]),
    ([F(0), F(2)], [F(1), F(0), F(1)]),
    ([F(0), F(0), F(3), F(-2)], [F(1)]),
)


def passage(rng: Random, u: tuple[F, F], most: int = 3) -> tuple[Polynomial, Polynomial]:
    """A rising passage of the range u onto [0, 1], mostly of low degree."""
    most = most if rng.random() < 0.3 else 1
    while True:
        top, bottom = rng.choice(PASSAGES)
        if max(len(top), len(bottom)) - 1 <= most:
            break
    inner = [-u[0] / (u[1] - u[0]), 1 / (u[1] - u[0])]
    def put(p: Polynomial) -> Polynomial:
        out = [F(0)]
        for i, c in enumerate(p):
            out = polynomial_sum(out, [c * k for k in power(inner, i)])
        return out
    return put(top), put(bottom)


# --------------------------------------------------------------------------------------------------------- bodies


class Body:
    """A body in its frame: `text` is an expression, `off` the distance of a point from it (0 within a solid)."""

    def text(self) -> str:
        raise NotImplementedError

    def off(self, x: np.ndarray) -> float:
        raise NotImplementedError

    def mapped(self, frame: Frame) -> Body:
        raise NotImplementedError

    @property
    def size(self) -> float:
        raise NotImplementedError


@dataclass(frozen=True)
class Piece(Body):
    """A piece of a ruled surface; `lift` is a vector times a polynomial of the time that all of it is shifted by."""

    first: Curve
    second: Curve
    u: tuple[F, F] | None = (F(0), F(1))
    s: tuple[F, F] | None = (F(0), F(1))
    trim: tuple[str, ...] = ()
    lift: tuple[Vector, Polynomial] | None = None
    as_lists: bool = False
    placed: Frame | None = None
    name: str | None = None

    def text(self) -> str:
        options = ""
        if self.u != (0, 1):
            options += ", u=" + ("None" if self.u is None else tuple_text(self.u))
        if self.s != (0, 1):
            options += ", s=" + ("None" if self.s is None else tuple_text(self.s))
        if self.trim:
            options += f", trim={list(self.trim)!r}"
        if self.name:
            options += f", name={self.name!r}"
        lists = self.as_lists and self.lift is None
        text = f"fc.RuledSurface({self.first.text(lists, self.lift)}, {self.second.text(lists, self.lift)}{options})"
        return text + (placement(self.placed) if self.placed else "")

    def mapped(self, frame: Frame) -> Piece:
        if self.as_lists and self.placed is None:  # leave the placing to the library for half of them
            return replace(self, placed=frame, lift=self.lift)
        lift = None if self.lift is None else (frame.direction(self.lift[0]), self.lift[1])
        return replace(self, first=self.first.mapped(frame), second=self.second.mapped(frame), lift=lift)

    def shift(self, t: float) -> np.ndarray:
        """Where a piece that deforms by a shift stands at time t."""
        if self.lift is None:
            return np.zeros(3)
        d = self.placed.direction(self.lift[0]) if self.placed else self.lift[0]
        return np.array([float(c * value(self.lift[1], F(t))) for c in d])

    def ends(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a, b = self.first.floats(u), self.second.floats(u)
        if self.placed:
            m = np.array([[float(c) for c in row] for row in self.placed.linear])
            o = np.array([float(c) for c in self.placed.offset])
            a, b = a @ m.T + o, b @ m.T + o
        return a, b

    def points(self, u: np.ndarray, s: np.ndarray) -> np.ndarray:
        a, b = self.ends(u)
        return a * (1 - s)[..., None] + b * s[..., None]

    def exact_point(self, u: F, s: F) -> Vector:
        p = add(scaled(self.first.at(u), 1 - s), scaled(self.second.at(u), s))
        return self.placed.point(p) if self.placed else p

    def parameters(self, n: int) -> np.ndarray:
        """n values of u over the range; those of whole projective lines as tangents."""
        if self.u is None:
            return np.tan((np.arange(n) + 0.37) * np.pi / n)
        return np.linspace(float(self.u[0]), float(self.u[1]), n)

    def tables(self) -> tuple[np.ndarray, np.ndarray]:
        """(degree + 1, 4) float coefficients of both directrices in place."""
        out = []
        for curve in (self.first, self.second):
            curve = curve.mapped(self.placed) if self.placed else curve
            n = curve.degree + 1
            out.append(np.array([[float(c) for c in p] + [0.0] * (n - len(p)) for p in (*curve.x, curve.w)]).T)
        return out[0], out[1]

    def off(self, x: np.ndarray) -> float:
        """By search along u from the nearest of 400 rulings."""
        tables = self.tables()
        top = max(len(t) for t in tables)
        bounds = None if self.s is None else (float(self.s[0]), float(self.s[1]))
        scale = max(float(np.abs(t).max()) for t in tables)
        tables = tuple(np.vstack([t, np.zeros((top - len(t), 4))]) / scale if self.u is not None else t / scale
                       for t in tables)  # type: ignore[assignment]

        def gap(angle: np.ndarray) -> np.ndarray:
            ends = []
            for t in tables:
                n = len(t)
                if self.u is None:
                    up, across = np.sin(angle), np.cos(angle)
                    basis = np.stack([up**k * across ** (n - 1 - k) for k in range(n)], -1)
                else:
                    basis = angle[:, None] ** np.arange(n)
                h = basis @ t
                ends.append(h[:, :3] / h[:, 3:])
            d = ends[1] - ends[0]
            s = ((x - ends[0]) * d).sum(-1) / np.maximum((d * d).sum(-1), 1e-300)
            if bounds is not None:
                s = np.clip(s, *bounds)
            return np.sqrt(((ends[0] + s[:, None] * d - x) ** 2).sum(-1))  # type: ignore[no-any-return]

        if self.u is None:
            grid = (np.arange(400) + 0.37) * np.pi / 400
            lo, hi = grid - np.pi / 400, grid + np.pi / 400
        else:
            grid = self.parameters(400)
            step = grid[1] - grid[0]
            lo, hi = np.maximum(grid - step, grid[0]), np.minimum(grid + step, grid[-1])
        with np.errstate(divide="ignore", invalid="ignore"):
            gaps = np.nan_to_num(gap(grid), nan=np.inf)
            least = np.argsort(gaps)[:6]
            lo, hi = lo[least], hi[least]
            k = (5**0.5 - 1) / 2
            for _ in range(70):
                c, d = hi - k * (hi - lo), lo + k * (hi - lo)
                both = gap(np.concatenate([c, d]))
                left = both[: len(c)] < both[len(c) :]
                lo, hi = np.where(left, lo, c), np.where(left, d, hi)
            return float(np.nanmin([gaps.min(), *gap(lo), *gap(hi), *gap((lo + hi) / 2)]))

    @property
    def size(self) -> float:
        a, b = self.ends(self.parameters(40))
        s0, s1 = (-1.0, 2.0) if self.s is None else (float(self.s[0]), float(self.s[1]))
        p = np.concatenate([a * (1 - s0) + b * s0, a * (1 - s1) + b * s1])
        p = p[np.isfinite(p).all(-1)]
        return float(np.abs(p).max() + (p.max(0) - p.min(0)).max())


def placement(frame: Frame) -> str:
    if frame.linear == ONE:
        return "" if not any(frame.offset) else f".translated({tuple_text(frame.offset)})"
    rows = ", ".join("[" + ", ".join(number(c) for c in row) + "]" for row in frame.matrix4)
    return f".transformed([{rows}])"


@dataclass(frozen=True)
class Mesh(Body):
    """A polyhedron; convex closed ones own their inside."""

    vertices: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...]
    closed: bool = False

    def text(self) -> str:
        corners = ", ".join(tuple_text(v) for v in self.vertices)
        return f"fc.Polyhedron([{corners}], {[list(f) for f in self.faces]})"

    def mapped(self, frame: Frame) -> Mesh:
        return replace(self, vertices=tuple(frame.point(v) for v in self.vertices))

    def off(self, x: np.ndarray) -> float:
        p = np.array([[float(c) for c in v] for v in self.vertices])
        triangles = [(p[f[0]], p[f[i]], p[f[i + 1]]) for f in self.faces for i in range(1, len(f) - 1)]
        if self.closed and abs(sum(_solid_angle(x, *t) for t in triangles)) > 2 * np.pi:
            return 0.0
        return min(_triangle_gap(x, *t) for t in triangles)

    @property
    def size(self) -> float:
        p = np.array([[float(c) for c in v] for v in self.vertices])
        return float(np.abs(p).max() + (p.max(0) - p.min(0)).max())


def _solid_angle(x: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    a, b, c = a - x, b - x, c - x
    la, lb, lc = (float(np.linalg.norm(v)) for v in (a, b, c))
    below = la * lb * lc + a @ b * lc + b @ c * la + c @ a * lb
    return 2 * float(np.arctan2(a @ np.cross(b, c), below))


def _triangle_gap(x: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    n = np.cross(b - a, c - a)
    n = n / np.linalg.norm(n)
    p = x - n * (n @ (x - a))
    if all(np.cross(q - o, p - o) @ n >= 0 for o, q in ((a, b), (b, c), (c, a))):
        return abs(float(n @ (x - a)))
    best = np.inf
    for o, q in ((a, b), (b, c), (c, a)):
        d = q - o
        k = np.clip((x - o) @ d / (d @ d), 0, 1)
        best = min(best, float(np.linalg.norm(o + k * d - x)))
    return best


@dataclass(frozen=True)
class Solid(Body):
    """A solid of the library by its text in a frame of its own, and `depth`: how far out a point is there, about."""

    expression: str
    outside: Callable[[np.ndarray], float]
    extent: float
    frame: Frame = field(default_factory=Frame)

    def text(self) -> str:
        return self.expression + placement(self.frame)

    def mapped(self, frame: Frame) -> Solid:
        return replace(self, frame=Frame(
            product(frame.linear, self.frame.linear), frame.point(self.frame.offset), None))

    def off(self, x: np.ndarray) -> float:
        back = np.array([[float(c) for c in row] for row in inverse(self.frame.linear)])
        y = back @ (x - np.array([float(c) for c in self.frame.offset]))
        return max(self.outside(y), 0.0) / float(np.linalg.norm(back, 2))

    @property
    def size(self) -> float:
        m = np.array([[float(c) for c in row] for row in self.frame.linear])
        return self.extent * float(np.linalg.norm(m, 2)) + max(abs(float(c)) for c in self.frame.offset)


# -------------------------------------------------------------------------------------------------------- motions


class Motion:
    """A motion of the library by its text, and its 4x4 poses by the definition."""

    kind = "rest"
    beyond = True

    def text(self) -> str:
        raise NotImplementedError

    def pose(self, t: float) -> np.ndarray:
        raise NotImplementedError

    def mapped(self, frame: Frame) -> Motion:
        raise NotImplementedError


@dataclass(frozen=True)
class Shift(Motion):
    vector: Vector
    kind = "translation"

    def text(self) -> str:
        return f"fc.Translation({tuple_text(self.vector)})"

    def pose(self, t: float) -> np.ndarray:
        m = np.eye(4)
        m[:3, 3] = [float(c * F(t)) for c in self.vector]
        return m

    def mapped(self, frame: Frame) -> Shift:
        return Shift(frame.direction(self.vector))


@dataclass(frozen=True)
class Turn(Motion):
    """A turn by degrees about the line through `point`, and an advance along it."""

    axis: Vector
    point: Vector
    degrees: F
    advance: F = F(0)

    @property
    def kind(self) -> str:  # type: ignore[override]
        return "screw" if self.advance else "rotation"

    def text(self) -> str:
        name = "Screw" if self.advance else "Rotation"
        more = f", advance={number(self.advance)}" if self.advance else ""
        return f"fc.{name}({tuple_text(self.axis)}, {tuple_text(self.point)}, degrees={number(self.degrees)}{more})"

    def pose(self, t: float) -> np.ndarray:
        n = np.array([float(c) for c in self.axis])
        n = n / np.linalg.norm(n)
        whole = self.degrees * F(t)
        quarter = round(whole / 90)
        angle = float(whole - 90 * quarter) * np.pi / 180
        c, s = np.cos(angle), np.sin(angle)
        for _ in range(quarter % 4):
            c, s = -s, c
        k = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
        m = np.eye(4)
        m[:3, :3] = np.outer(n, n) + c * (np.eye(3) - np.outer(n, n)) + s * k
        p = np.array([float(x) for x in self.point])
        m[:3, 3] = p - m[:3, :3] @ p + n * float(self.advance * F(t))
        return m

    def mapped(self, frame: Frame) -> Turn:
        assert frame.scale is not None
        return Turn(image(frame.linear, self.axis), frame.point(self.point), self.degrees, self.advance * frame.scale)


@dataclass(frozen=True)
class Rational(Motion):
    """4x4 matrices as coefficients of 1, t, t^2, ...; the entry [3][3] is the weight."""

    coefficients: tuple[tuple[tuple[F, ...], ...], ...]
    kind = "rational"
    beyond = False

    def text(self) -> str:
        return "fc.RationalMotion([" + ", ".join(
            "[" + ", ".join("[" + ", ".join(number(c) for c in row) + "]" for row in m) + "]"
            for m in self.coefficients) + "])"

    def pose(self, t: float) -> np.ndarray:
        x = F(t)
        rows = [[sum((m[i][j] * x**k for k, m in enumerate(self.coefficients)), F(0)) for j in range(4)]
                for i in range(4)]
        return np.array([[float(c / rows[3][3]) for c in row] for row in rows])

    def mapped(self, frame: Frame) -> Rational:
        there = frame.matrix4
        back = inverse(frame.linear)
        offset = scaled(image(back, frame.offset), -1)
        home = [[*row, c] for row, c in zip(back, offset, strict=True)] + [[F(0), F(0), F(0), F(1)]]
        return Rational(tuple(_product4(_product4(there, m), home) for m in self.coefficients))

    def after(self, other: Rational) -> Rational:
        """self(t) other(t)."""
        out = [[[F(0)] * 4 for _ in range(4)] for _ in range(len(self.coefficients) + len(other.coefficients) - 1)]
        for i, m in enumerate(self.coefficients):
            for j, n in enumerate(other.coefficients):
                p = _product4(m, n)
                for r in range(4):
                    for c in range(4):
                        out[i + j][r][c] += p[r][c]
        return Rational(tuple(tuple(tuple(row) for row in m) for m in out))


def _product4(a: Sequence[Sequence[F]], b: Sequence[Sequence[F]]) -> tuple[tuple[F, ...], ...]:
    return tuple(tuple(sum((a[i][k] * b[k][j] for k in range(4)), F(0)) for j in range(4)) for i in range(4))


def polynomial_shift(direction: Vector, p: Sequence[F]) -> Rational:
    """The shift by direction times p(t)."""
    out = []
    for k, c in enumerate(p):
        d = F(1) if k == 0 else F(0)
        out.append(tuple(
            tuple([d if i == j else F(0) for j in range(3)] + [direction[i] * c]) for i in range(3)
        ) + ((F(0), F(0), F(0), d),))
    return Rational(tuple(out))


def tangent_turn(axis: Vector, point: Vector, rate: F) -> Rational:
    """The turn about an axis of length 1 whose half angle has the tangent rate * t."""
    n = axis
    cross_ = ((F(0), -n[2], n[1]), (n[2], F(0), -n[0]), (-n[1], n[0], F(0)))
    out = []
    for k in range(3):
        linear = []
        for i in range(3):
            row = []
            for j in range(3):
                e = F(1) if i == j else F(0)
                row.append((e, 2 * rate * cross_[i][j], rate * rate * (2 * n[i] * n[j] - e))[k])
            linear.append(row)
        weight = (F(1), F(0), rate * rate)[k]
        shift = [weight * point[i] - dot(tuple(linear[i]), point) for i in range(3)]  # type: ignore[arg-type]
        out.append(tuple(tuple([*linear[i], shift[i]]) for i in range(3)) + ((F(0), F(0), F(0), weight),))
    return Rational(tuple(out))


@dataclass(frozen=True)
class Steps(Motion):
    steps: tuple[Motion, ...]
    durations: tuple[F, ...]
    kind = "sequence"
    beyond = False

    def text(self) -> str:
        return (f"fc.Sequence([{', '.join(m.text() for m in self.steps)}], "
                f"[{', '.join(number(d) for d in self.durations)}])")

    def pose(self, t: float) -> np.ndarray:
        m, start = np.eye(4), F(0)
        for step, length in zip(self.steps, self.durations, strict=True):
            part = (F(t) - start) / length
            if part <= 1:
                return step.pose(max(part, F(0))) @ m  # type: ignore[arg-type]
            m = step.pose(F(1)) @ m  # type: ignore[arg-type]
            start += length
        return m

    def mapped(self, frame: Frame) -> Steps:
        return Steps(tuple(m.mapped(frame) for m in self.steps), self.durations)


def moved(body: Body, motion: Motion | None) -> str:
    return body.text() + ("" if motion is None else f".moving({motion.text()})")

