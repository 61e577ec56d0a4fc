"""All zeros of a square system within a box and within both solids: branch and prune with linear Taylor models.

Over a box every form is c + g.d + [-r, r], d the offset from the middle, with all rounding in r; so boxes without a
zero are dropped with proof, and g^-1 narrows the others (Hansen and Sengupta's step, with the remainder of the model in
place of an interval Jacobian).  What is left small is proved to hold one zero by Krawczyk's test, or stays open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from flint import fmpq, fmpq_poly

from firstcontact.body.solid.csg import Tree, possible
from firstcontact.exact.numbers import exact_value, simplest, to_double
from firstcontact.exact.polynomials.polynomial_matrix import Matrix
from firstcontact.exact.systems.square_systems import SquareSystem, Zero, certified

T = TypeVar("T", float, fmpq)
Vector = tuple[fmpq, ...]

EPSILON = 4e-16
"""Twice the unit roundoff, and a little."""
SMALL = 1e-5
"""Half-width, in units of the whole box, from which on Krawczyk's test is tried."""
LEAST = 1e-9
"""Half-width at which a box stays open."""
MOST_BOXES = 60_000
"""Boxes looked at in one slab before what is left stays open."""
OVERLAP = 1.02
"""Halves are larger than half by this, so that a zero at their border lies inside one."""
TRIES = 40
"""Boxes of one slab that stay small without a sure zero, for which Krawczyk's test is tried all the same."""
CHUNK = 20_000
MOST_STANDING, WIDER = 50_000, fmpq(9, 8)
"""Boxes looked at for zeros at one u; how much wider than a box the place is where fractions are tried."""
CLOSE, DEEPEST = 1e-4, 3
"""How wide the place of what is left may be, beside the share of u, where the search goes on there in a frame of its
own; how often that is done."""
REGULAR = 1e-6
"""Least determinant of normals that are far enough from dependent to be solved with."""
THREE = [0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]
OPEN_ENOUGH = 4000
"""Open boxes of one slab after which the rest stays open too: zeros are not isolated there."""


@dataclass(frozen=True)
class SearchedSolid:
    """A model as the search sees it: its tree, and its surfaces as symmetric 4x4 matrices over fmpz_poly."""

    tree: Tree
    forms: Sequence[Matrix]
    on: frozenset[int]
    """Surfaces that hold the zeros by the equations."""


@dataclass
class FoundZeros:
    """zeros: proved; open: (u_lo, u_hi) of stretches where some box could not be decided."""

    zeros: list[Zero] = field(default_factory=list)
    open: list[tuple[fmpq, fmpq]] = field(default_factory=list)
    boxes: int = 0


def zeros_within(
    system: SquareSystem,
    solids: Sequence[SearchedSolid],
    box: tuple[Sequence[fmpq], Sequence[fmpq]],
    span: tuple[fmpq, fmpq],
    slabs: int,
) -> FoundZeros:
    """All zeros in the box (corners x, y, z) with u in the span, whose points both solids may hold.

    The span is cut into slabs; polynomials are taken afresh in each, so that high degrees lose no digits.
    """
    found = FoundZeros()
    lo, hi = span
    for k in range(slabs):
        ends = lo + (hi - lo) * fmpq(k, slabs), lo + (hi - lo) * fmpq(k + 1, slabs)
        slab, known = _Slab(system, solids, box, ends), len(found.open)
        slab.search(found)
        found.open[known:] = _stretches(found.open[known:], slab.frame.reach * exact_value(LEAST))
    return found


@dataclass(frozen=True)
class StandingZeros:
    """Zeros of a system at one u.  points: (x, y, z) of rational ones; is_open: whether there may be others."""

    points: Sequence[Vector] = ()
    is_open: bool = False


def standing(
    system: SquareSystem, solids: Sequence[SearchedSolid], box: tuple[Sequence[fmpq], Sequence[fmpq]], u: fmpq
) -> StandingZeros:
    """The zeros in the box at u whose points both solids may hold: of four equations for three unknowns.

    They stay small boxes, in which the shortest fractions are tried.
    """
    slab = _Slab(system, solids, box, (u, u))
    middle, half = np.zeros((1, 4)), (slab.start * (1 + 1e-9) + 1e-15) * [1.0, 1.0, 1.0, 0.0]
    looked = 0
    while len(half) and half.max() >= LEAST:
        looked += len(half)
        if looked > MOST_STANDING:
            return StandingZeros(is_open=True)
        middle, half, steep, _ = slab.pruned(middle, half)
        half[:, 3], steep[:, 3] = 0.0, 0.0
        if len(half) and half.max() >= LEAST:
            middle, half = _halves(middle, half, steep)
    points: dict[Vector, None] = {}
    for m, h in zip(middle, half, strict=True):
        x = tuple(simplest(*slab.side(k, m, h)) for k in range(3))
        if system.vanishes_at(x, u):
            points.setdefault(x)
    return StandingZeros(list(points), bool(len(half)))


@dataclass(frozen=True)
class _Model:
    """(n,) values, (n, 4) slopes and (n,) remainders over n boxes."""

    value: np.ndarray
    slope: np.ndarray
    rest: np.ndarray

    def size(self, half: np.ndarray) -> np.ndarray:
        """Bound of the part beyond the value."""
        size: np.ndarray = np.einsum("ni,ni->n", np.abs(self.slope), half) + self.rest
        return size


class _Form:
    """One form with u = middle + reach v, |v| <= 1, and x = origin + scale xi; in doubles with error bounds."""

    def __init__(self, form: Matrix, frame: _Frame) -> None:
        polynomials = _composed(form, frame)
        largest = max((abs(c) for row in polynomials for p in row for c in p.coeffs()), default=fmpq(1))
        n = max(1, *(len(p.coeffs()) for row in polynomials for p in row))
        self.powers = np.zeros((n, 4, 4))
        for i, row in enumerate(polynomials):
            for j, p in enumerate(row):
                for k, c in enumerate(p.coeffs()):
                    self.powers[k, i, j] = to_double(c / largest)
        power = np.arange(n)[:, None, None]
        sizes = np.abs(self.powers)
        self.rounding = (n + 8) * EPSILON * ((1 + power) * sizes).sum(axis=0)
        self.bend = (power * (power - 1) * sizes).sum(axis=0) * (1 + 1e-6)

    def at(self, v: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(n, 4, 4) values, derivatives by v, and remainders of the entries over v +- half."""
        n = len(self.powers)
        value = np.broadcast_to(self.powers[n - 1], (len(v), 4, 4))
        slope = np.zeros((len(v), 4, 4))
        t = v[:, None, None]
        for k in range(n - 2, -1, -1):
            slope = slope * t + value
            value = value * t + self.powers[k]
        rest = self.bend * (0.5 * half * half)[:, None, None] + self.rounding
        return value, slope, rest


@dataclass(frozen=True)
class _Frame:
    """x = origin + scale xi, u = middle + reach v."""

    origin: tuple[fmpq, ...]
    scale: fmpq
    middle: fmpq
    reach: fmpq


def _composed(form: Matrix, frame: _Frame) -> list[list[fmpq_poly]]:
    argument = fmpq_poly([frame.middle, frame.reach])
    q = [[fmpq_poly(p)(argument) for p in row] for row in form]
    t = [[frame.scale if i == j else fmpq(0) for j in range(3)] + [frame.origin[i]] for i in range(3)]
    t.append([fmpq(0)] * 3 + [fmpq(1)])
    half = [[sum((q[i][k] * t[k][j] for k in range(4)), fmpq_poly(0)) for j in range(4)] for i in range(4)]
    return [[sum((half[k][j] * t[k][i] for k in range(4)), fmpq_poly(0)) for j in range(4)] for i in range(4)]


@dataclass(frozen=True)
class _FormParts:
    """What value and gradient of one form need over n boxes."""

    x: np.ndarray
    h: np.ndarray
    image: np.ndarray
    moved: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    rest: np.ndarray


def _parts(form: _Form, middle: np.ndarray, half: np.ndarray) -> _FormParts:
    x = np.column_stack([middle[:, :3], np.ones(len(middle))])
    h = np.column_stack([half[:, :3], np.zeros(len(half))])
    value, slope, rest = form.at(middle[:, 3], half[:, 3])
    return _FormParts(
        x, h, np.einsum("nij,nj->ni", value, x), np.einsum("nij,nj->ni", slope, x), value, slope, rest
    )


def _value(p: _FormParts, half: np.ndarray) -> _Model:
    """X^T Q X."""
    value = np.einsum("ni,ni->n", p.x, p.image)
    slope = np.column_stack([2 * p.image[:, :3], np.einsum("ni,ni->n", p.x, p.moved)])
    hv = half[:, 3]
    reach = np.abs(p.x) + p.h
    curved = np.einsum("ni,nij,nj->n", p.h, np.abs(p.value), p.h)
    mixed = 2 * np.einsum("ni,ni->n", np.abs(p.moved), p.h) + np.einsum("ni,nij,nj->n", p.h, np.abs(p.slope), p.h)
    size = np.einsum("ni,nij,nj->n", reach, np.abs(p.value) + hv[:, None, None] * np.abs(p.slope), reach)
    rest = curved + hv * mixed + np.einsum("ni,nij,nj->n", reach, p.rest, reach)
    return _Model(value, slope, rest * (1 + 1e-12) + 64 * EPSILON * size)


def _gradient(p: _FormParts, half: np.ndarray) -> list[_Model]:
    """The first three entries of Q X."""
    hv = half[:, 3]
    reach = np.abs(p.x) + p.h
    found = []
    for i in range(3):
        slope = np.column_stack([p.value[:, i, :3], p.moved[:, i]])
        curved = hv * np.einsum("nj,nj->n", np.abs(p.slope[:, i]), p.h)
        size = np.einsum("nj,nj->n", np.abs(p.value[:, i]) + hv[:, None] * np.abs(p.slope[:, i]), reach)
        rest = curved + np.einsum("nj,nj->n", p.rest[:, i], reach)
        found.append(_Model(p.image[:, i], slope, rest * (1 + 1e-12) + 32 * EPSILON * size))
    return found


def _times(x: _Model, y: _Model, half: np.ndarray) -> _Model:
    a, b = x.size(half), y.size(half)
    value, slope = x.value * y.value, x.value[:, None] * y.slope + y.value[:, None] * x.slope
    rest = np.abs(x.value) * y.rest + np.abs(y.value) * x.rest + a * b
    size = (np.abs(x.value) + a) * (np.abs(y.value) + b)
    return _Model(value, slope, rest * (1 + 1e-12) + 32 * EPSILON * size)


def _minus(x: _Model, y: _Model) -> _Model:
    size = np.abs(x.value) + np.abs(y.value) + np.abs(x.slope).sum(axis=1) + np.abs(y.slope).sum(axis=1)
    return _Model(x.value - y.value, x.slope - y.slope, (x.rest + y.rest) * (1 + 1e-12) + 4 * EPSILON * size)


def _negated(x: _Model) -> _Model:
    return _Model(-x.value, -x.slope, x.rest)


def _tangency(rows: list[list[_Model]], half: np.ndarray) -> _Model:
    """Determinant of three gradients."""
    total: _Model | None = None
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        minor = _minus(_times(rows[1][j], rows[2][k], half), _times(rows[1][k], rows[2][j], half))
        term = _times(rows[0][i], minor, half)
        total = term if total is None else _minus(total, _negated(term))
    assert total is not None
    return total


class _Slab:
    def __init__(
        self,
        system: SquareSystem,
        solids: Sequence[SearchedSolid],
        box: tuple[Sequence[fmpq], Sequence[fmpq]],
        ends: tuple[fmpq, fmpq],
        depth: int = 0,
    ) -> None:
        lo, hi = box
        self.depth = depth
        scale = max((b - a) / 2 for a, b in zip(lo, hi, strict=True))
        origin = tuple((a + b) / 2 for a, b in zip(lo, hi, strict=True))
        self.frame = _Frame(origin, scale, (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2)
        self.system, self.given = system, solids
        self.forms = [_Form(form, self.frame) for form in system.forms]
        self.solids = [(s.tree, s.on, [None if k in s.on else _Form(f, self.frame) for k, f in enumerate(s.forms)])
                       for s in solids]  # fmt: skip
        self.start = np.array([[*(to_double((b - a) / 2 / scale) for a, b in zip(lo, hi, strict=True)), 1.0]])

    def search(self, found: FoundZeros) -> None:
        middle, half = np.zeros((1, 4)), self.start * (1 + 1e-9) + 1e-15
        pending = [(middle, half)]
        owned: list[Zero] = []
        given_up: list[tuple[np.ndarray, np.ndarray]] = []
        looked = tries = 0
        while pending:
            middle, half = pending.pop()
            if len(middle) > CHUNK:
                pending.append((middle[CHUNK:], half[CHUNK:]))
                middle, half = middle[:CHUNK], half[:CHUNK]
            looked += len(middle)
            if looked > MOST_BOXES or len(given_up) > OPEN_ENOUGH:
                given_up += list(zip(middle, half, strict=True))
                continue
            middle, half, steep, inner = self.pruned(middle, half)
            size = np.max(half, axis=1, initial=0)
            least = size < LEAST
            for k in np.flatnonzero(((size < SMALL) & inner) | least):
                tries += least[k] and not inner[k]
                if (inner[k] or tries < TRIES) and self._settled(middle[k], half[k], owned):
                    size[k] = 0.0
                elif least[k]:
                    given_up.append((middle[k], half[k]))
            rest = size >= LEAST
            hull = self._one_place(middle[rest], half[rest]) if rest.any() and not pending else None
            if hull is None and rest.any():
                pending.append(_halves(middle[rest], half[rest], steep[rest]))
            elif hull is not None and not self._settled(*hull, owned):
                self._closer(*hull).search(found)
        found.boxes += looked
        for zero in owned:
            if not any(zero.is_same(other) for other in found.zeros):
                found.zeros.append(zero)
        for lo, hi in _stretches([(m[3] - h[3], m[3] + h[3]) for m, h in given_up], LEAST):
            found.open.append((self._u(lo), self._u(hi)))

    def _one_place(self, middle: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """The box (middle, half) around those that are left, where they are at one place but at many u."""
        lo, hi = (middle - half).min(axis=0), (middle + half).max(axis=0)
        size = hi - lo
        if self.depth == DEEPEST or size[:3].max() > CLOSE * size[3]:
            return None
        return 0.5 * (lo + hi), 0.5 * size * (1 + 1e-9) + EPSILON

    def _closer(self, middle: np.ndarray, half: np.ndarray) -> _Slab:
        """The search of a box in a frame of its own: there equations have the digits that tell u, however short the
        motion."""
        f, (lo, hi) = self.frame, ((middle - half).tolist(), (middle + half).tolist())
        first, last = (
            tuple(o + f.scale * fmpq(*c.as_integer_ratio()) for o, c in zip(f.origin, corner[:3], strict=True))
            for corner in (lo, hi)
        )
        return _Slab(self.system, self.given, (first, last), (self._u(lo[3]), self._u(hi[3])), self.depth + 1)

    def side(self, k: int, middle: np.ndarray, half: np.ndarray) -> tuple[fmpq, fmpq]:
        """The ends of a box along x, y or z."""
        f, at, size = self.frame, exact_value(float(middle[k])), exact_value(float(half[k])) * WIDER
        return f.origin[k] + f.scale * (at - size), f.origin[k] + f.scale * (at + size)

    def _u(self, v: float) -> fmpq:
        return self.frame.middle + self.frame.reach * fmpq(*float(v).as_integer_ratio())

    def _models(self, middle: np.ndarray, half: np.ndarray) -> list[_Model]:
        parts = [_parts(form, middle, half) for form in self.forms]
        models = [_value(p, half) for p in parts]
        if len(models) == 3:
            models.append(_tangency([_gradient(p, half) for p in parts], half))
        return models

    def pruned(self, middle: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The boxes that may hold zeros, narrowed; by how much each side matters; and which hold a zero."""
        for _ in range(3):
            models = self._models(middle, half)
            keep = np.ones(len(middle), bool)
            for model in models:
                keep &= np.abs(model.value) <= model.size(half)
            keep[keep] &= self._in_both(middle[keep], half[keep])
            middle, half = middle[keep], half[keep]
            models = [_Model(m.value[keep], m.slope[keep], m.rest[keep]) for m in models]
            before = half
            middle, half, keep, steep, inner = _narrowed(models, middle, half)
            middle, half, before = middle[keep], half[keep], before[keep]
            steep, inner = steep[keep], inner[keep]
            if not len(half) or np.mean(np.max(half / np.maximum(before, 1e-300), axis=1) < 0.6) < 0.3:
                break
        return middle, half, steep, inner

    def _in_both(self, middle: np.ndarray, half: np.ndarray) -> np.ndarray:
        """False proves that a box has no point of one of the solids."""
        keep = np.ones(len(middle), bool)
        for tree, on, forms in self.solids:
            below, above = [], []
            for k, form in enumerate(forms):
                if k in on or form is None:
                    below.append(np.ones(len(middle), bool))
                    above.append(below[-1])
                    continue
                model = _value(_parts(form, middle, half), half)
                size = model.size(half)
                below.append(model.value - size <= 0)
                above.append(model.value + size >= 0)
            keep &= possible(tree, below, above)[0]
        return keep

    def _settled(self, middle: np.ndarray, half: np.ndarray, owned: list[Zero]) -> bool:
        """Whether the zero of the box is known, or proved now."""
        f = self.frame
        centre = [o + f.scale * fmpq(*float(c).as_integer_ratio()) for o, c in zip(f.origin, middle[:3], strict=True)]
        centre.append(f.middle + f.reach * fmpq(*float(middle[3]).as_integer_ratio()))
        sizes = (f.scale, f.scale, f.scale, f.reach)
        radii = [s * fmpq(*float(h).as_integer_ratio()) for s, h in zip(sizes, half, strict=True)]
        if any(zero.owns(centre, radii) for zero in owned):
            return True
        zero = certified(self.system, centre, radii)
        if zero is not None:
            owned.append(zero)
        return zero is not None


def _stretches(intervals: list[tuple[T, T]], gap: T) -> list[tuple[T, T]]:
    """Their union, overlapping ones (and those less than the gap apart) as one."""
    joined: list[tuple[T, T]] = []
    for lo, hi in sorted(intervals):
        if joined and lo <= joined[-1][1] + gap:
            joined[-1] = joined[-1][0], max(hi, joined[-1][1])
        else:
            joined.append((lo, hi))
    return joined


def _halves(middle: np.ndarray, half: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both halves of every box across its weightiest side."""
    rows = np.arange(len(middle))
    side = np.argmax(weight, axis=1)
    half = half.copy()
    half[rows, side] *= 0.5
    shift = np.zeros_like(half)
    shift[rows, side] = half[rows, side]
    half[rows, side] *= OVERLAP
    return np.concatenate([middle - shift, middle + shift]), np.concatenate([half, half])


def _narrowed(
    models: list[_Model], middle: np.ndarray, half: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Boxes cut to what the linear parts leave; which are not empty; each side's weight for splitting; which hold a
    zero by Brouwer's theorem, since what is left lies inside.
    """
    c = np.stack([m.value for m in models], axis=1)
    g = np.stack([m.slope for m in models], axis=1)
    r = np.stack([m.rest for m in models], axis=1)
    smear = np.abs(g) * half[:, None, :]
    weight = (smear / (1e-300 + smear.sum(axis=2))[:, :, None]).sum(axis=1)
    weight = weight * 0.25 + half / np.maximum(half.max(axis=1, initial=0), 1e-300)[:, None]
    scaled = g * half[:, None, :]
    norms = np.linalg.norm(scaled, axis=2, keepdims=True)
    scaled = scaled / np.maximum(norms, 1e-300)
    regular = np.abs(np.linalg.det(scaled)) > REGULAR if len(g) else np.zeros(0, bool)
    inner = np.zeros(len(middle), bool)
    half, middle, keep = half.copy(), middle.copy(), np.ones(len(middle), bool)
    if regular.any():
        at, spread = _solved(g[regular], c[regular], r[regular], half[regular])
        inner[regular] = np.all(np.abs(at) + spread < half[regular], axis=1)
        keep[regular], middle[regular], half[regular] = _cut(at, spread, middle[regular], half[regular])
    flat = np.flatnonzero(~regular)
    if len(flat):
        _narrow_places(flat, (g, c, r), middle, half, keep)
    return middle, half, keep, weight, inner


def _narrow_places(
    flat: np.ndarray, models: tuple[np.ndarray, np.ndarray, np.ndarray], middle: np.ndarray, half: np.ndarray,
    keep: np.ndarray,
) -> None:  # fmt: skip
    """Cut boxes `flat` in x, y and z alone, by three of the equations for all u of each.

    So it is where the motion is too short for the equations to change much: u is told last, when the place is.
    """
    g, c, r = (m[flat] for m in models)
    scaled = g[:, :, :3] * half[flat, None, :3]
    scaled /= np.maximum(np.linalg.norm(scaled, axis=2, keepdims=True), 1e-300)
    volumes = np.stack([np.abs(np.linalg.det(scaled[:, rows])) for rows in THREE], axis=1)
    best = np.argmax(volumes, axis=1)
    sharp = volumes[np.arange(len(flat)), best] > REGULAR
    if not sharp.any():
        return
    rows, some, which = np.array(THREE)[best[sharp]], np.flatnonzero(sharp)[:, None], flat[sharp]
    g, c, r = g[some, rows], c[some, rows], r[some, rows]
    at, spread = _solved(g[:, :, :3], c, r + np.abs(g[:, :, 3]) * half[which, None, 3], half[which, :3])
    keep[which], middle[which, :3], half[which, :3] = _cut(at, spread, middle[which, :3], half[which, :3])


def _solved(g: np.ndarray, c: np.ndarray, r: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m, s): every d within half with |g d + c| <= r lies in m +- s, for d = Y (-c - r) + (1 - Y g) d for any Y."""
    y = np.linalg.inv(g)
    at = -np.einsum("nij,nj->ni", y, c)
    size = np.abs(y)
    off = np.abs(np.eye(g.shape[1]) - y @ g) + 16 * EPSILON * (size @ np.abs(g))
    spread = np.einsum("nij,nj->ni", size, r + 16 * EPSILON * np.abs(c))
    return at, (spread + np.einsum("nij,nj->ni", off, half)) * (1 + 1e-12)


def _cut(
    at: np.ndarray, spread: np.ndarray, middle: np.ndarray, half: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Boxes cut with at +- spread about their middles: which are not empty, their middles and halves."""
    lo, hi = np.maximum(at - spread, -half), np.minimum(at + spread, half)
    keep = np.all(lo <= hi, axis=1)
    lo, hi = np.minimum(lo, hi), np.maximum(lo, hi)
    new = middle + (lo + hi) / 2
    return keep, new, (hi - lo) / 2 * (1 + 1e-12) + 4 * EPSILON * (1 + np.abs(new))
