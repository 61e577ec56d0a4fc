"""Rank, null space and inertia of small matrices over any field with exact zero tests and signs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from firstcontact.exact.fields.number_field import is_zero, sign

if TYPE_CHECKING:
    from firstcontact.exact.ring import D, N, Number

Rows = Sequence[Sequence[Any]]


def inertia(m: Rows) -> tuple[int, int, int]:
    """(positive, negative, zero) squares of the symmetric m, by Lagrange's reduction (Sylvester's law)."""
    positive = negative = 0
    rows = [list(row) for row in m]
    while rows:
        k = next((i for i, row in enumerate(rows) if not is_zero(row[i])), None)
        if k is None:
            pair = next(((i, j) for i, row in enumerate(rows) for j in range(i) if not is_zero(row[j])), None)
            if pair is None:
                break
            # no square left: with x_i = y_i + y_j, x_j = y_i - y_j the term 2 m_ij x_i x_j is one of each sign
            positive, negative = positive + 1, negative + 1
            rows = _without_pair(rows, *pair)
            continue
        pivot = rows[k][k]
        if sign(pivot) > 0:
            positive += 1
        else:
            negative += 1
        rows = _without(rows, k, pivot)
    return positive, negative, len(m) - positive - negative


def _without(rows: list[list[D]], k: int, pivot: D) -> list[list[D]]:
    """The Schur complement of the diagonal entry k."""
    rest = [i for i in range(len(rows)) if i != k]
    head = rows[k]
    factor = {i: head[i] / pivot for i in rest if not is_zero(head[i])}
    return [[rows[i][j] - factor[i] * head[j] if i in factor else rows[i][j] for j in rest] for i in rest]


def _without_pair(rows: list[list[D]], i: int, j: int) -> list[list[D]]:
    """The Schur complement of the block (0, c; c, 0) at i, j."""
    c = rows[i][j]
    rest = [k for k in range(len(rows)) if k not in (i, j)]
    return [[rows[k][n] - (rows[k][i] * rows[j][n] + rows[k][j] * rows[i][n]) / c for n in rest] for k in rest]


def null_space(m: Rows) -> list[tuple[Number, ...]]:
    """A basis of the vectors x with m x = 0, by Gauss-Jordan elimination."""
    rows, width = [list(row) for row in m], len(m[0])
    pivots: list[int] = []
    for column in range(width):
        r = len(pivots)
        k = next((i for i in range(r, len(rows)) if not is_zero(rows[i][column])), None)
        if k is None:
            continue
        rows[r], rows[k] = rows[k], rows[r]
        inverse = 1 / rows[r][column]  # once: in a field of high degree the rest is cheap beside it
        rows[r] = [x * inverse for x in rows[r]]
        for i, row in enumerate(rows):
            if i != r and not is_zero(row[column]):
                factor = row[column]
                rows[i] = [x - factor * y for x, y in zip(row, rows[r], strict=True)]
        pivots.append(column)
    zero = m[0][0] * 0
    basis = []
    for free in (c for c in range(width) if c not in pivots):
        x = [zero] * width
        x[free] = zero + 1
        for row, column in zip(rows, pivots, strict=False):
            x[column] = -row[free]
        basis.append(tuple(x))
    return basis


def rank(m: Rows) -> int:
    return len(m[0]) - len(null_space(m))


def times(m: Rows, x: Sequence[N]) -> tuple[N, ...]:
    """m x."""
    return tuple(dot(row, x) for row in m)


def dot(x: Sequence[N], y: Sequence[N]) -> N:
    total = x[0] * y[0]
    for a, b in zip(x[1:], y[1:], strict=True):
        total = total + a * b
    return total


def value(m: Rows, x: Sequence[N]) -> N:
    """x^T m x."""
    return dot(x, times(m, x))
