"""The proof that cells of one body stay out of another one for a time.

Over a stretch of time a cell is the hull of a few places that go on at their rates, up to a bound; a height, linear up
to a bound, is least over it at one of them, at the start or at the end.  A cell stays out where the heights of enough
surfaces are positive all over it; or, next to edges and corners, a mixture of those of two or three surfaces that a
point of the other body would have to be behind, all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np

from firstcontact.body.solid.csg import And, Leaf, Not, Tree
from firstcontact.body.solid.regions import simplified
from firstcontact.contact.torus.between import Between, Places
from firstcontact.contact.torus.cells import Cells
from firstcontact.contact.torus.heights import Heights

MOST_CELLS = 1500
"""Of those that are halved in one stretch of time, where a body has not more of them from the start."""
MOST_TERMS, MOST_FACTORS = 64, 8
"""Of a model's tree next to a cell, as a union of intersections."""
AT_ONCE = 20_000
NEXT = 0.5
"""By how much cells are enlarged about their middles: up to there it tells where heights are equal."""
LEAST_SIZE = 0.1
"""Of cells that are halved, as a part of their way meanwhile."""

Literal = tuple[int, int]
"""A surface, and 0 for where its height is negative, 1 for where it is positive."""


class Slopes(NamedTuple):
    """Of cells and heights, for h and -h: values (2, n, f) less all errors, and least parts that vary.

    over: (n, f, k) what h gains from the middle of the cell to its points; by: (n, f, k) what it gains there in time.
    unsure: (n, f) about by how much values of points of the hull are off those of the cell.
    """

    values: np.ndarray
    over: np.ndarray
    by: np.ndarray
    unsure: np.ndarray


def kept(
    cells: Cells, between: Between, heights: Heights, stretch: tuple[float, float], rows: np.ndarray,
    step: Callable[[int], None], rounds: int, most: int,
) -> np.ndarray:  # fmt: skip
    """Cells, or parts of them, that are not proved to stay out over the stretch of time.

    They are halved where that alone may prove it, so often at most, and while they are not more than that many; where
    the time is too long for that, they are not.
    """
    left: list[np.ndarray] = []
    if not len(rows):
        return rows
    with np.errstate(all="ignore"):  # bounds may be infinite; what is no number proves nothing
        behind = _behind(cells, between, heights, stretch)
        for k in range(rounds + 1):
            step(len(rows))
            parts = [
                _apart(cells, some, between.places(*stretch, cells.points(some)), heights, behind)
                for some in (rows[i : i + AT_ONCE] for i in range(0, len(rows), AT_ONCE))
            ]
            sure, clear = (np.concatenate(x) for x in zip(*parts, strict=True))
            left.append(rows[~sure & ~clear])
            rows = rows[~sure & clear]
            if not len(rows) or len(rows) > most or k == rounds:
                break
            rows = cells.halves(rows)
            if not len(rows):  # inequalities of the surface have cut off all
                break
    return np.concatenate([*left, rows])


def _apart(
    cells: Cells, rows: np.ndarray, places: Places, heights: Heights, behind: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) whether cells are proved to stay out; whether halves of them may be, for the same time."""
    centre = places.points.mean(axis=1)
    steps = places.points - centre[:, None]
    size = np.sqrt((steps * steps).sum(axis=2)).max(axis=1)
    way = places.half * np.sqrt((places.rates**2).sum(axis=2)).max(axis=1) + places.blur
    reach = size + way
    at = heights.around(centre, reach)
    length = np.sqrt((at.gradients**2).sum(axis=2))
    lost = at.errors + length * places.blur[:, None] + 0.5 * at.bends * (reach * reach)[:, None]
    lost = np.where(np.isnan(lost), np.inf, lost)
    over = np.einsum("nfi,nki->nfk", at.gradients, steps)
    by = places.half * np.einsum("nfi,nki->nfk", at.gradients, places.rates)
    away = length * cells.away(rows)[:, None]
    slopes = Slopes(np.stack([at.values, -at.values]) - lost, over, by, away + lost.max(axis=0))
    least = np.maximum(at.least, _least(slopes))
    least[0] = np.maximum(least[0], behind)
    if cells.flat:
        least[0] = np.maximum(least[0], _beyond(places, heights)[:, None])
    sure = lower(heights.tree, least) > 0.0
    middle = np.abs(by.mean(axis=2)) + at.errors + length * places.blur[:, None] - away
    clear = (size > LEAST_SIZE * way) & (lower(heights.tree, np.stack([at.values, -at.values]) - middle) > 0.0)
    some = np.flatnonzero(~sure & clear)
    if len(some) and not isinstance(heights.tree, Leaf):
        sure[some], clear[some] = _by_mixtures(heights.tree, slopes, least, some)
    return sure, clear


def _behind(cells: Cells, between: Between, heights: Heights, stretch: tuple[float, float]) -> np.ndarray:
    """(f,) how far all of the body is beyond planes, at least; -inf for other surfaces, and where that is not known."""
    planes = heights.planes()
    if planes is None or cells.reach is None:
        return np.array(-np.inf)
    frame = between.places(*stretch, cells.reach * np.vstack([np.zeros(3), np.eye(3)])[None])
    (x,), (v,), blur = frame.points, frame.half * frame.rates, float(frame.blur[0])
    least = np.full(len(planes), np.inf)
    for y in (x - v, x + v):
        across = planes[:, :3] @ (y[1:] - y[0]).T / cells.reach
        least = np.minimum(least, planes[:, :3] @ y[0] + planes[:, 3] - cells.support(across))
    lost = np.linalg.norm(planes[:, :3], axis=1) * (blur + 1e-14 * (cells.reach + float(np.abs(x[0]).max())))
    found: np.ndarray = np.where(planes[:, :3].any(axis=1), least - lost - 1e-14 * np.abs(planes[:, 3]), -np.inf)
    return found


def lower(tree: Tree, least: np.ndarray, negated: bool = False) -> np.ndarray:
    """(n,) positive only where the tree is proved false (negated: true); least: (2, n, f) of h and of -h."""
    found: np.ndarray
    if isinstance(tree, Leaf):
        found = least[int(negated), :, tree.surface]
    elif isinstance(tree, Not):
        found = lower(tree.inner, least, not negated)
    else:
        both = lower(tree.first, least, negated), lower(tree.second, least, negated)
        found = np.maximum(*both) if isinstance(tree, And) != negated else np.minimum(*both)
    return found


def _least(x: Slopes) -> np.ndarray:
    """(2, n, f) what h and -h are at least."""
    swing = np.abs(x.by)
    found: np.ndarray = x.values + np.stack([(x.over - swing).min(axis=2), (-x.over - swing).min(axis=2)])
    return found


def _beyond(places: Places, heights: Heights) -> np.ndarray:
    """(n,) how far flat cells are, at least, from a parallel plane that all of the other body is behind."""
    x = places.points
    normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    lengths = np.sqrt((normals**2).sum(axis=1))
    normals = normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    normals = np.where((normals * x.mean(axis=1)).sum(axis=1) < 0.0, -1.0, 1.0)[:, None] * normals
    reach = heights.beyond_flat(normals)
    if reach is None:
        return np.full(len(x), -np.inf)
    there = np.einsum("nki,ni->nk", x, normals) - places.half * np.abs(np.einsum("nki,ni->nk", places.rates, normals))
    found: np.ndarray = np.where(lengths > 0.0, there.min(axis=1) - reach - places.blur, -np.inf)
    return found


# -- edges and corners --------------------------------------------------------------------------------------


def _by_mixtures(
    tree: Tree, slopes: Slopes, least: np.ndarray, some: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) of the cells `some` as `_apart` tells, by mixtures of heights."""
    signs = np.where(least[0, some] > 0.0, 1, np.where(least[1, some] > 0.0, -1, 0))
    patterns, which = np.unique(signs, axis=0, return_inverse=True)
    sure, hope = np.zeros(len(some), bool), np.ones(len(some), bool)
    for k, pattern in enumerate(patterns.tolist()):
        here = simplified(tree, pattern)
        mine = np.flatnonzero(which.ravel() == k)
        if isinstance(here, bool):
            sure[mine] = not here
            continue
        terms = unions(here)
        if terms is not None and all(len(term) <= MOST_FACTORS for term in terms):
            told = [_mixed(sorted(term), slopes, some[mine]) for term in terms]
            sure[mine], hope[mine] = (np.all(x, axis=0) for x in zip(*told, strict=True))
    return sure, hope


@lru_cache(maxsize=1024)
def unions(tree: Tree, negated: bool = False) -> frozenset[frozenset[Literal]] | None:
    """The tree as a union of intersections of half-spaces; None where these are too many."""
    if isinstance(tree, Leaf):
        return frozenset({frozenset({(tree.surface, int(negated))})})
    if isinstance(tree, Not):
        return unions(tree.inner, not negated)
    first, second = unions(tree.first, negated), unions(tree.second, negated)
    if first is None or second is None:
        return None
    found = first | second
    if isinstance(tree, And) != negated:
        if len(first) * len(second) > MOST_TERMS:
            return None
        found = frozenset(x | y for x in first for y in second)
    return found if len(found) <= MOST_TERMS else None


def _mixed(term: list[Literal], x: Slopes, some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m,) whether a mixture of up to three heights of the intersection is positive all over the cell; else whether
    halves may tell more: not where no height is large enough at a point of the cell, as far as it is known."""
    side = [1.0 - 2.0 * negated for _, negated in term]
    value = np.stack([x.values[negated, some, k] for k, negated in term], axis=1)
    over, by = (
        np.stack([s * y[some, k] for s, (k, _) in zip(side, term, strict=True)], axis=1) for y in (x.over, x.by)
    )
    size = np.abs(over).max(axis=2) + np.abs(by).max(axis=2)
    size = np.where(size > 0.0, size, 1.0)  # heights are told in units of their own
    value, over, by = value / size, over / size[:, :, None], by / size[:, :, None]
    unsure = (np.stack([x.unsure[some, k] for k, _ in term], axis=1) / size).max(axis=1)
    known = np.isfinite(value).all(axis=1)
    sure, hope = np.zeros(len(some), bool), np.ones(len(some), bool)
    for count in (1, 2, 3):
        for chosen in map(list, combinations(range(len(term)), count)):
            left = np.flatnonzero(~sure & known)
            parts = [y[left][:, chosen] for y in (value, over, by)]
            weights, level = _weights(parts[1], parts[0])
            v, p, s = (np.einsum("nc,nc...->n...", weights, y) for y in parts)
            sure[left] = v + (p - np.abs(s)).min(axis=1) > 0.0
            there = (value[left] + np.einsum("nck,nk->nc", over[left], level)).max(axis=1)
            hope[left] &= (there + 4.0 * unsure[left] > np.abs(s.mean(axis=1))) | _is_beyond(level)
    return sure, hope


def _is_beyond(level: np.ndarray) -> np.ndarray:
    """(n,) whether points, moved to from the middles of cells as (n, k) tell, are beyond their enlarged hulls."""
    beyond: np.ndarray = level.min(axis=1) - level.mean(axis=1) < -(1.0 + NEXT) / level.shape[1]
    return beyond


def _weights(over: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of heights (n, c) that vary by (n, c, k) over cells: weights (n, c) >= 0 of sum 1 whose mixture varies
    little; and (n, k) by how much of each point of a cell to move to where the heights are equal."""
    count = over.shape[1]
    gram = np.einsum("nik,njk->nij", over, over)
    gram = gram + 1e-14 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(count) + 1e-300 * np.eye(count)
    even, own = np.moveaxis(np.linalg.solve(gram, np.stack([np.ones_like(value), value], axis=2)), 2, 0)
    level = own - even * (own.sum(axis=1) / even.sum(axis=1))[:, None]
    weights = np.maximum(even, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), 1.0 / count)
    return weights, -np.einsum("nc,nck->nk", level, over)
