"""Brackets: signed volumes, areas and lengths of points, and how two lines or two segments in space meet.

After [Chen11], section 2, with its lemmas repaired: a comparison of 3-brackets needs one common normal, hence their
signs, one of 2-brackets one common direction, and the overlap test of segments on one line an absolute value.

Points are triples of numbers of any size, each taken for exactly what it is: ints, Fractions, "1/3", doubles.  Answers
are exact Fractions.  The functions in the plural take arrays of n points, (n, 3) doubles below 2^150 or integers up to
2^53, or one point (3,) for all n: floats decide where they prove their answer, exact arithmetic the rest, and the
result tells how often it was asked.  All raise InputError, naming the argument, for anything else: NaN, other shapes.

>>> segments_relation((0, 0, 0), (2, 2, 2), (0, 2, 1), (2, 0, 1)).point
(Fraction(1, 1), Fraction(1, 1), Fraction(1, 1))
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpz

from firstcontact.errors import InputError
from firstcontact.exact import brackets as exact
from firstcontact.exact.brackets import LinesRelation, SegmentsRelation
from firstcontact.exact.fields.number_field import ExactNumber, sign
from firstcontact.exact.numbers import fraction, rational, to_double
from firstcontact.exact.vectors import Vector, whole

if TYPE_CHECKING:
    from fractions import Fraction

    from numpy.typing import ArrayLike

    from firstcontact.exact.numbers import Given
    from firstcontact.exact.ring import Rational

__all__ = [
    "LinesRelation",
    "Relations",
    "SegmentsRelation",
    "bracket2",
    "bracket3",
    "bracket4",
    "bracket4_signs",
    "lines_relation",
    "lines_relations",
    "projection",
    "segments_relation",
    "segments_relations",
]

# Coordinates of arrays stay below this, as those of bodies do: the error bounds hold up to it.
LARGEST = 2.0**150
# Names of the kinds of kernels.brackets, by number.
KINDS = ("separate", "point", "overlap", "overlap_point")


def bracket4(a: Iterable[Given], b: Iterable[Given], c: Iterable[Given], d: Iterable[Given]) -> Fraction:
    """[abcd] = det (a b c d; 1 1 1 1) = -det(b - a, c - a, d - a), exactly: six times a signed volume.

    Zero where the points lie in one plane.  Its sign is opposite to that of the usual orient3d.

    >>> bracket4((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, "1/2"))
    Fraction(-1, 2)
    """
    return _shown(exact.bracket4(*_points(a=a, b=b, c=c, d=d)))


def bracket3(a: Iterable[Given], b: Iterable[Given], c: Iterable[Given], dropped: int) -> Fraction:
    """Twice the signed area of abc seen along coordinate `dropped`: det(b - a, c - a, n) for that axis n.

    For points of one plane with unit normal n it is [abc] = det(b - a, c - a, n) up to one factor, so that signs,
    ratios and equality of such brackets mean the same; `projection` gives a coordinate that may be dropped.

    >>> p1, p2, q1, q2 = (0, 0, 0), (4, 0, 0), (1, -1, 0), (1, 3, 0)
    >>> n = projection(p1, p2, q1, q2)
    >>> n, str(bracket3(p1, p2, q1, n)), str(bracket3(p1, p2, q2, n))
    (2, '-4', '12')
    """
    if not isinstance(dropped, int | np.integer) or dropped not in (0, 1, 2):
        raise InputError(f"dropped is {dropped!r}; give the number of a coordinate: 0, 1 or 2")
    p, q, r = _points(a=a, b=b, c=c)
    return _shown(exact.bracket3(p, q, r, dropped))


def bracket2(a: Iterable[Given], b: Iterable[Given], direction: Iterable[Given]) -> Fraction:
    """(a - b) . direction: [ab] up to one positive factor for all points of a line with this direction.

    >>> bracket2((3, 0, 0), (1, 0, 0), (1, 0, 0))
    Fraction(2, 1)
    """
    return _shown(exact.bracket2(*_points(a=a, b=b, direction=direction)))


def projection(p1: Iterable[Given], p2: Iterable[Given], q1: Iterable[Given], q2: Iterable[Given]) -> int | None:
    """A coordinate that four points of one plane may lose without falling onto a line; None where they are on one."""
    return exact.projection(*_points(p1=p1, p2=p2, q1=q1, q2=q2))


def lines_relation(p1: Iterable[Given], p2: Iterable[Given], q1: Iterable[Given], q2: Iterable[Given]) -> LinesRelation:
    """How the line through p1 and p2 and the line through q1 and q2 meet: `kind` is "point", "overlap" or "separate".

    With b1 = [p1 p2 q1], b2 = [p1 p2 q2], b3 = [p1 q1 q2], b4 = [p2 q1 q2]: they meet in one point when
    [p1 p2 q1 q2] = 0 and b1 != b2; then t = b1 / (b1 - b2), s = b3 / (b3 - b4), and the point is
    q1 + t (q2 - q1) = p1 + s (p2 - p1).  `parallel` tells parallel lines from skew ones.

    >>> met = lines_relation((0, 0, 0), (1, 0, 0), (2, 1, 0), (2, 3, 0))
    >>> met.kind, str(met.s), str(met.t)
    ('point', '2', '-1/2')
    >>> lines_relation((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0))
    LinesRelation(kind='separate', parallel=True, point=None, s=None, t=None)

    Raises InputError where two points that should span a line are equal.
    """
    points = _points(p1=p1, p2=p2, q1=q1, q2=q2)
    for one, other, names in ((points[0], points[1], "p1 and p2"), (points[2], points[3], "q1 and q2")):
        if all(sign(x - y) == 0 for x, y in zip(one, other, strict=True)):
            raise InputError(f"{names} are equal, so they span no line; give two different points")
    found = exact.lines_relation(*points)
    return replace(found, point=_shown(found.point), s=_shown(found.s), t=_shown(found.t))


def segments_relation(
    p1: Iterable[Given], p2: Iterable[Given], q1: Iterable[Given], q2: Iterable[Given]
) -> SegmentsRelation:
    """How the closed segments p1 p2 and q1 q2 meet; each may be a single point.

    `kind` is "point" (one common point, with `s` and `t` as in `lines_relation`), "overlap" (a common `segment`, in
    the direction from p1 to p2, `s` and `t` pairs), "overlap_point" (one common point of segments on one line) or
    "separate".

    >>> met = segments_relation((0, 0, 0), (3, 0, 0), (2, 0, 0), (1, 0, 0))
    >>> met.kind, [tuple(map(str, end)) for end in met.segment], tuple(map(str, met.t))
    ('overlap', [('1', '0', '0'), ('2', '0', '0')], ('1', '0'))
    """
    found = exact.segments_relation(*_points(p1=p1, p2=p2, q1=q1, q2=q2))
    return replace(
        found, point=_shown(found.point), segment=_shown(found.segment), s=_shown(found.s), t=_shown(found.t)
    )


@dataclass(frozen=True)
class Relations:
    """The relations of n pairs of lines or segments; kinds are exact, the other numbers doubles near the exact ones.

    kinds     (n,) str: "separate", "point", "overlap", "overlap_point".
    parallel  (n,) bool: whether two lines have parallel directions; None for segments.
    points    (n, 3) float64: the common point, or the start of the overlap; NaN where there is none.
    ends      (n, 3) float64: the end of the overlap of segments; NaN elsewhere.
    s, t      (n,) float64: parameters of `points` on p1 p2 and q1 q2; NaN elsewhere.
    exact_evaluations: how many pairs floats could not decide.
    """

    kinds: np.ndarray
    parallel: np.ndarray | None
    points: np.ndarray
    ends: np.ndarray
    s: np.ndarray
    t: np.ndarray
    exact_evaluations: int

    def __len__(self) -> int:
        return len(self.kinds)


def lines_relations(p1: ArrayLike, p2: ArrayLike, q1: ArrayLike, q2: ArrayLike) -> Relations:
    """`lines_relation` for (n, 3) arrays, row by row; (3,) stands for n equal rows.

    >>> found = lines_relations([0, 0, 0], [1, 0, 0], [[2, 1, 0], [0, 1, 1]], [[2, 3, 0], [0, 5, 2]])
    >>> found.kinds.tolist()
    ['point', 'separate']
    """
    rows = _rows(p1=p1, p2=p2, q1=q1, q2=q2)
    for one, other, names in ((rows[0], rows[1], "p1 and p2"), (rows[2], rows[3], "q1 and q2")):
        equal = np.flatnonzero((one == other).all(axis=1))
        if len(equal):
            raise InputError(f"{names} of row {equal[0]} are equal, so they span no line; give two different points")
    return _relations(rows, bounded=False)


def segments_relations(p1: ArrayLike, p2: ArrayLike, q1: ArrayLike, q2: ArrayLike) -> Relations:
    """`segments_relation` for (n, 3) arrays, row by row; (3,) stands for n equal rows.

    >>> found = segments_relations([[0, 0, 0]], [[0.3, 0, 0]], [[0.1, -1, 0]], [[0.1, 1, 0]])
    >>> found.kinds.tolist(), found.points.tolist(), found.exact_evaluations
    (['point'], [[0.1, 0.0, 0.0]], 1)
    """
    return _relations(_rows(p1=p1, p2=p2, q1=q1, q2=q2), bounded=True)


def bracket4_signs(a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike) -> tuple[np.ndarray, int]:
    """((n,) int64 exact signs of [abcd] for (n, 3) arrays, how many of them took exact arithmetic).

    >>> bracket4_signs([[0, 0, 0]], [[1, 0, 0]], [[0, 1, 0]], [[0, 0, 1], [1, 1, 0]])
    (array([-1,  0]), 0)
    """
    from firstcontact.kernels import brackets as kernels

    rows = _rows(a=a, b=b, c=c, d=d)
    signs, certain = np.empty(len(rows[0]), np.int64), np.empty(len(rows[0]), np.bool_)
    kernels.bracket4_signs(*rows, signs, certain)
    unsure = np.flatnonzero(~certain)
    for i in unsure.tolist():
        signs[i] = sign(exact.bracket4(*_whole_points(rows, i)[1]))
    return signs, len(unsure)


def _relations(rows: list[np.ndarray], bounded: bool) -> Relations:
    from firstcontact.kernels import brackets as kernels

    n = len(rows[0])
    kinds, out = np.empty(n, np.int64), np.full((n, kernels.WIDTH), np.nan)
    out[:, kernels.PARALLEL] = 0.0
    kernels.relations(*rows, bounded, kinds, out)
    unsure = np.flatnonzero(kinds == kernels.UNSURE)
    for i in unsure.tolist():
        kinds[i] = _decided(rows, i, bounded, out[i])
    parallel = None if bounded else out[:, kernels.PARALLEL] == 1.0
    return Relations(np.array(KINDS)[kinds], parallel, out[:, 2:5], out[:, 5:8], out[:, 0], out[:, 1], len(unsure))


def _decided(rows: list[np.ndarray], i: int, bounded: bool, out: np.ndarray) -> int:
    """The kind of row i in exact arithmetic; its numbers go to `out` as kernels.brackets.relation writes them."""
    scale, points = _whole_points(rows, i)
    found: Any = (exact.segments_relation if bounded else exact.lines_relation)(*points)
    if found.point is not None:
        out[:5] = [_near(x) for x in (found.s, found.t, *(x / fmpq(scale) for x in found.point))]
    elif bounded and found.segment is not None:
        out[:2] = _near(found.s[0]), _near(found.t[0])
        out[2:8] = [_near(x / fmpq(scale)) for end in found.segment for x in end]
    if not bounded:
        out[-1] = found.parallel
    return KINDS.index(found.kind)


def _near(x: Rational) -> float:
    return to_double(fmpq(x))


def _whole_points(rows: list[np.ndarray], i: int) -> tuple[fmpz, list[Vector]]:
    """(scale, the points of row i times it as whole numbers)."""
    points = [tuple(fmpq(*x.as_integer_ratio()) for x in row[i].tolist()) for row in rows]
    return whole(*points)  # type: ignore[arg-type]


def _rows(**arrays: ArrayLike) -> list[np.ndarray]:
    """The arguments as C-contiguous (n, 3) float64 arrays of equal length."""
    rows = []
    for name, values in arrays.items():
        try:
            given = np.asarray(values)
        except ValueError as error:
            raise InputError(f"{name} has rows of different lengths; give an (n, 3) array of numbers") from error
        if given.dtype.kind not in "iuf" or given.ndim not in (1, 2) or given.shape[-1] != 3:
            raise InputError(
                f"{name} has shape {given.shape}, type {given.dtype}; give an (n, 3) array of doubles or integers"
            )
        row = np.atleast_2d(given.astype(np.float64))
        if not np.all(np.abs(row) < LARGEST):
            raise InputError(f"{name} holds a value that is not finite or not below 2^150")
        whole_numbers = given.dtype.kind in "iu"
        if whole_numbers and (int(given.max(initial=0)) > 2**53 or int(given.min(initial=0)) < -(2**53)):
            raise InputError(f"{name} holds an integer beyond 2^53, which no double holds; ask for its row by itself")
        if not whole_numbers and np.any(row != given):
            raise InputError(f"{name} holds a {given.dtype} that no double holds; ask for its row by itself")
        rows.append(row)
    try:
        return [np.ascontiguousarray(x) for x in np.broadcast_arrays(*rows)]
    except ValueError as error:
        raise InputError(f"the arrays have {[len(x) for x in rows]} rows; give equally many") from error


def _points(**points: Iterable[Given]) -> list[Vector]:
    """The arguments as triples of exact numbers; numbers with a `sign()` are taken as they are."""
    return [_point(values, name) for name, values in points.items()]


def _point(values: Iterable[Given], name: str) -> Vector:
    try:
        if isinstance(values, str | bytes | dict | set | frozenset):  # of no order, or of letters
            raise TypeError
        x, y, z = values
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is {values!r}; give three numbers") from error
    return tuple(  # type: ignore[return-value]
        c if isinstance(c, ExactNumber) else rational(c, f"{name}[{k}]") for k, c in enumerate((x, y, z))
    )


def _shown(x: Any) -> Any:
    """Rational numbers as Fractions, in tuples too."""
    if isinstance(x, tuple):
        return tuple(map(_shown, x))
    if isinstance(x, int | fmpz | fmpq):
        return fraction(fmpq(x))
    return x
