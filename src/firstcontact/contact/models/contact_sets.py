"""What of a contact set of two whole carriers lies in both models: points, segments of lines, arcs of conics.

Where a set is more than a point its ends and a sample point inside are found in doubles; the sample point is then
placed exactly and decides.  Ends of segments and arcs lie on edges, so pieces that doubles miss are seen there.
Points in doubles are homogeneous, in lengths of `Pair.unit`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.csg import Tree, possible
from firstcontact.contact.models.membership import On, Vector, in_both
from firstcontact.contact.models.moving_pair import MovingPair, form_at, is_plane
from firstcontact.exact.fields.number_field import QuadraticElement, ball, sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import exact_value, precision
from firstcontact.pairs.carriers.contact import Contact

if TYPE_CHECKING:
    from firstcontact.exact.systems.square_systems import EnclosedRoot
    pass

SAMPLES = 720
"""Points of a conic looked at in doubles."""
FINER = 61
"""Points looked at around one that is held alone, the odd one in the middle."""

NOUGHT = 1e-3
"""Of a point's size: coordinates that are smaller count as that large.  One that is 0 but for rounding, of a point on
a plane through the origin, has no size of its own to measure that rounding by."""


@dataclass(frozen=True)
class Shared:
    """A connected part of a contact set in both models.

    kind: "point", "segment" or "conic arc"; at: one of its points, exact, homogeneous, in the frame of b;
    points: (n, 3) float64, the point, the two ends, or points along the arc; closed: a whole ellipse.
    """

    kind: str
    at: Vector
    points: np.ndarray
    closed: bool = False


def shared_part(
    pair: MovingPair, contact: Contact, root: AlgebraicRoot | EnclosedRoot, on_a: On, on_b: On
) -> tuple[list[Shared], str]:
    """The parts of the contact set that both models hold, or the reason why there is none."""
    if contact.kind == "point":
        (x,) = contact.span
        reason = in_both(pair, x, root, on_a, on_b)
        return ([], reason) if reason else ([Shared("point", x, cartesian(x)[None])], "")
    trim = TrimForms(pair, root, on_a, on_b)
    parts = _segments(contact, trim) if contact.kind == "line" else _arcs(contact, trim)
    found = [part for part in parts if not in_both(pair, part.at, root, on_a, on_b)]
    return found, "" if found else "outside the faces"


def cartesian(x: Vector) -> np.ndarray:
    """(3,) doubles nearest the point, or nearly."""
    values = [ball(c, 128) for c in x]
    with precision(128):
        return np.array([float((c / values[3]).mid()) for c in values[:3]])


class TrimForms:
    """The forms of both models in doubles at the root, and where points lie in both."""

    def __init__(self, pair: MovingPair, root: AlgebraicRoot | EnclosedRoot | EnclosedRoot, on_a: On, on_b: On) -> None:
        u = root.enclosure(128)
        self.unit = pair.unit
        self.models = []
        for body, forms, on in ((pair.a, pair.forms_a, on_a), (pair.b, pair.forms_b, on_b)):
            with precision(128):
                matrices = np.array([_matrix(form_at(form, u), is_plane(form), pair.unit) for form in forms])
            self.models.append((body.tree, matrices, np.isin(np.arange(len(forms)), list(on.surfaces)), on))

    def breaks(self, origin: np.ndarray, direction: np.ndarray) -> Iterator[float]:
        """Parameters s at which origin + s direction crosses a surface of either model."""
        for _, matrices, holds, _ in self.models:
            for form in matrices[~holds]:
                coefficients = direction @ form @ direction, 2 * origin @ form @ direction, origin @ form @ origin
                if not np.any(coefficients[:2]):
                    continue
                a, b, c = coefficients
                if a and abs(b * b - 4 * a * c) <= 1e-13 * (b * b + abs(4 * a * c)):  # double, as rounding hides
                    yield -b / (2 * a)
                    continue
                yield from (s.real for s in np.roots(coefficients) if abs(s.imag) < 1e-9 * (1 + abs(s)))

    def inside(self, points: np.ndarray) -> np.ndarray:
        """(n,) bools for (n, 4) points: in both closed models and on the faces asked for, as far as doubles tell."""
        answer = np.ones(len(points), bool)
        sizes = np.abs(points)
        sizes += NOUGHT * sizes.max(axis=1, initial=0.0, keepdims=True)
        for tree, matrices, holds, on in self.models:
            values = np.einsum("ni,sij,nj->sn", points, matrices, points)
            slack = 1e-10 * np.einsum("ni,sij,nj->sn", sizes, abs(matrices), sizes)
            slack[holds] = np.inf
            below, above = values < slack, values > -slack
            answer &= possible(tree, below, above)[0]
            if on.faces:
                answer &= _on_faces(tree, below, above, on)
        return answer


def _on_faces(tree: Tree, below: np.ndarray, above: np.ndarray, on: On) -> np.ndarray:
    """(n,) bools: the faces asked for may be there, where form i may be negative (below) or positive (above)."""
    there = {k: np.zeros(below.shape[1], bool) for k, _ in on.faces}
    for k, side in on.faces:
        free = [i for i in on.surfaces if i != k]
        for choice in product((True, False), repeat=len(free)):
            low, high = below.copy(), above.copy()
            for i, negative in zip(free, choice, strict=True):
                low[i], high[i] = negative, not negative
            sides = []
            for negative in (side > 0, side < 0):
                low[k], high[k] = negative, not negative
                sides.append(possible(tree, list(low.copy()), list(high.copy())))
            there[k] |= sides[0][0] & sides[1][1]
    enough: np.ndarray = np.sum(list(there.values()), axis=0) >= on.fewest
    return enough


def _matrix(form: Any, plane: bool, unit: float) -> np.ndarray:
    if not plane:
        rows = [list(row) for row in form]
    else:
        rows = [[arb(0)] * 4 for _ in range(4)]
        rows[3] = [x / 2 for x in form]
        for k in range(4):
            rows[k][3] = rows[3][k]
        rows[3][3] = form[3]
    units = 1.0, 1.0, 1.0, unit
    rows = [[x / u / v for x, v in zip(row, units, strict=True)] for row, u in zip(rows, units, strict=True)]
    largest = max(abs(x.mid()) for row in rows for x in row)
    return np.array([[float((x / largest).mid()) for x in row] for row in rows])


def _segments(contact: Contact, trim: TrimForms) -> Iterator[Shared]:
    first, second = contact.span
    if sign(first[3]) == 0:
        first, second = second, first
    # X(s) = first + s second, first finite: a scale near 1 for doubles, any for the exact point
    (direction, size), (origin, own_size) = scaled(second, trim.unit), scaled(first, trim.unit)
    weight = origin[3]
    origin = origin / weight
    ends = sorted(set(trim.breaks(origin, direction)))
    for lo, hi in zip(ends, ends[1:], strict=False):
        middle = 0.5 * (lo + hi)
        x = origin + middle * direction
        if hi - lo > 1e-9 * (1 + abs(middle)) and trim.inside(x[None])[0] and abs(x[3]) > 1e-12:
            r = exact_value(middle * weight) * own_size / size
            at = tuple(a + b * r for a, b in zip(first, second, strict=True))
            points = np.array([(origin + s * direction)[:3] / (origin + s * direction)[3] for s in (lo, hi)])
            yield Shared("segment", at, trim.unit * points)


def scaled(x: Vector, unit: float) -> tuple[np.ndarray, fmpq]:
    """(the homogeneous point in lengths of `unit`, in doubles about 1; the power of two that it was divided by)"""
    values = [ball(c, 64) for c in x]
    with precision(64):
        values[3] = values[3] * unit
        mantissa, exponent = arb(max(abs(v.mid()) for v in values).mid()).man_exp()
        size = fmpq(2) ** int(exponent + mantissa.bit_length())
        return np.array([float((v / arb(size)).mid()) for v in values]), size


def _arcs(contact: Contact, trim: TrimForms) -> Iterator[Shared]:
    span, form, sizes = _balanced(contact, trim.unit)
    values, vectors = np.linalg.eigh(form)
    if values[1] > 0:  # signs (-, +, +): the odd one last
        values, vectors = values[::-1], vectors[:, ::-1]
    if not values[2] * values[1] < 0 < values[0] * values[1]:
        return  # no proper real conic: the lines of a pair are other pairs' contacts
    axes = vectors / np.sqrt(np.abs(values))
    angles = np.linspace(0, 2 * np.pi, SAMPLES, endpoint=False)
    x, good = _sampled(span @ axes, angles, trim)
    for run in runs(good):
        kind, held, angle = "conic arc", x[run], angles[run[len(run) // 2]]
        if len(run) == 1:  # a point that both touch, unless more is held between it and its neighbours
            finer, good = _sampled(span @ axes, angle + np.linspace(-1, 1, FINER) * 2 * np.pi / SAMPLES, trim)
            held = finer[good]
            kind = "conic arc" if len(held) > 1 else "point"
        near = axes @ (round(math.cos(angle), 15), round(math.sin(angle), 15), 1.0)
        at = _on_conic(contact, axes[:, 2], near, sizes)
        yield Shared(kind, at, trim.unit * held[:, :3] / held[:, 3:], closed=len(run) == SAMPLES)


def _balanced(contact: Contact, unit: float) -> tuple[np.ndarray, np.ndarray, list[fmpq]]:
    """(basis of the plane, columns about 1 in lengths of `unit`; the conic in it; what takes its y to the contact's)

    Without it small values of the form drown in the rounding of large ones, where models are large or small.
    """
    rows = [scaled(x, unit) for x in contact.span]
    form = contact.form
    assert form is not None
    sizes = [size for _, size in rows]
    with precision(64):
        balls = [[ball(form[i][j], 64) / arb(sizes[i]) / arb(sizes[j]) for j in range(3)] for i in range(3)]
        largest = max(abs(x.mid()) for row in balls for x in row)
        values = np.array([[float((x / largest).mid()) for x in row] for row in balls])
    return np.array([row for row, _ in rows]).T, values, [1 / size for size in sizes]


def _sampled(frame: np.ndarray, angles: np.ndarray, trim: TrimForms) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 4) of the conic that the frame makes of the unit circle, and whether both models hold them."""
    x = (frame @ np.stack([np.cos(angles), np.sin(angles), np.ones(len(angles))])).T
    return x, trim.inside(x) & (np.abs(x[:, 3]) > 1e-9 * np.abs(x).max())


def runs(good: np.ndarray) -> list[np.ndarray]:
    """The runs of True around the circle, as indices."""
    if good.all():
        return [np.arange(len(good))]
    if not good.any():
        return []
    start = int(np.flatnonzero(~good)[0])
    order = (np.arange(len(good)) + start) % len(good)
    cuts = np.flatnonzero(np.diff(good[order].astype(int))) + 1
    return [run for run in np.split(order, cuts) if good[run[0]]]


def _on_conic(contact: Contact, inner: np.ndarray, near: np.ndarray, sizes: Sequence[fmpq]) -> Vector:
    """The exact point of the conic near y = `near`, on the line from the rational point `inner` within it.

    Both in the basis that `_balanced` gives; sizes: what makes them the y of the contact.
    """
    c = [exact_value(v) * size for v, size in zip(inner, sizes, strict=True)]
    d = [exact_value(v) * size - w for v, w, size in zip(near, c, sizes, strict=True)]
    form = contact.form
    assert form is not None

    def bilinear(p: list[fmpq], q: list[fmpq]) -> arb:
        total: arb = sum((form[i][j] * (p[i] * q[j]) for i in range(3) for j in range(3)), form[0][0] * 0)
        return total

    a, b, k = bilinear(d, d), bilinear(c, d), bilinear(c, c)
    root = b * b - a * k
    inverse = 1 / a
    way = 1 if sign(a) > 0 else -1  # the larger root, near 1: k and the value at d have different signs
    t = QuadraticElement(-b * inverse, inverse * way, root)
    y = [t * w + v for v, w in zip(c, d, strict=True)]
    x = [sum((y[j] * column[k] for j, column in enumerate(contact.span)), t * 0) for k in range(4)]
    return tuple(x)
