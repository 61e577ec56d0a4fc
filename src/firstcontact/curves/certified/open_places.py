"""Places of a curve that doubles leave open: boxes of parameters, in groups, and the pairs of pieces they touch."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np

from firstcontact.curves.certified.arcs import SearchedChains, Solved, lines_of
from firstcontact.curves.certified.settled import PiecePair, Settled
from firstcontact.kernels.curves import points as columns
from firstcontact.result_curve import OpenPlace

# Open boxes are one place where they are this near each other, in parameters of parts; of more boxes than this none is
# looked at closer.
SAME_PLACE, MOST_BOXES = 1e-5, 4000
# Points this near, in parameters of parts, are one.
SAME_POINT = 1e-9
# Of the square of a length that is divided by: rulings may be points.
LEAST = 1e-300
_END_COLUMNS = [columns.X, columns.Y, columns.PART_U, columns.PART_V, columns.KIND]


def open_boxes(found: SearchedChains | Solved, stray: list[int], at_bounds: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Parts (n, 2) and ranges (n, 4) of boxes left open.

    stray: places of branches that are points, or at which branches end without reason.  at_bounds: ends there; a
    point that is left open at one of them is on the branch.
    """
    points = [int(arc[columns.END]) for arc in found.arcs[found.arcs[:, columns.START] == -2]]
    beside = _crossings_side_by_side(found)
    if len(found.opened) > MOST_BOXES or not (len(found.opened) or points or stray or beside):
        return found.opened[:, :2], found.opened[:, 2:]
    spots = found.places[np.array([*points, *stray, *beside], int)]
    parts = np.concatenate((found.opened[:, :2], spots[:, [columns.PART_U, columns.PART_V]]))
    x, y = spots[:, columns.X], spots[:, columns.Y]
    ranges = np.concatenate((found.opened[:, 2:], np.column_stack((x, x, y, y))))
    known = found.places[np.array(at_bounds, int)]
    known = known[:, [columns.PART_U, columns.PART_V]] + known[:, [columns.X, columns.Y]]
    at = parts + ranges[:, [0, 2]]
    here = (ranges[:, [0, 2]] == ranges[:, [1, 3]]).all(1)
    here[here] = [bool((np.abs(known - x).max(1) <= SAME_POINT).any()) for x in at[here]]
    here[len(here) - len(beside) :] = False
    thin = ((ranges[:, 0] == ranges[:, 1]) | (ranges[:, 2] == ranges[:, 3])) & ~here
    here[thin] = _clearly_beyond(found, parts[thin], ranges[thin])
    return parts[~here], ranges[~here]


def _crossings_side_by_side(found: SearchedChains | Solved) -> list[int]:
    """Places on one bound of u or v that are the same: a branch may touch the bound there, and go on or not."""
    kinds = found.places[:, columns.KIND]
    which = np.flatnonzero((kinds > 0) & (kinds < columns.CUT))
    rows = found.places[which][:, _END_COLUMNS].tolist() if len(which) > 1 else []
    along = sorted(
        (kind, j + y if kind < 3.0 else i + x, k)
        for k, (x, y, i, j, kind) in zip(which.tolist(), rows, strict=False)
    )  # fmt: skip
    beside = [(a[2], b[2]) for a, b in pairwise(along) if a[0] == b[0] and b[1] - a[1] <= SAME_PLACE]
    return sorted({k for pair in beside for k in pair})


def _clearly_beyond(found: SearchedChains | Solved, parts: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """Whether rulings of short parts of lines cross well beyond an end of one; the cells beside them are decided."""
    length = np.maximum(ranges[:, 1] - ranges[:, 0], ranges[:, 3] - ranges[:, 2])
    beyond = length <= SAME_PLACE
    p, q = _middle_rulings(found, parts[beyond], ranges[beyond])
    along, other, gap = p[:, 1] - p[:, 0], q[:, 1] - q[:, 0], q[:, 0] - p[:, 0]
    normal = np.cross(along, other)
    size = (normal**2).sum(1)
    with np.errstate(all="ignore"):
        s, t = ((np.cross(gap, x) * normal).sum(1) / size for x in (other, along))
        off = np.max([-s, s - 1, -t, t - 1], axis=0) > np.where(length[beyond] > 0.0, 1e-2, 1e-6)
    beyond[beyond] = off & (size > 1e-6 * (along**2).sum(1) * (other**2).sum(1))
    return beyond


def touching(parts: np.ndarray, ranges: np.ndarray) -> list[np.ndarray]:
    """Indices of boxes, in groups between which gaps run along u or along v."""
    low = parts + ranges[:, [0, 2]] - SAME_PLACE
    high = parts + ranges[:, [1, 3]] + SAME_PLACE
    waiting, groups = [np.arange(len(parts))] if len(parts) else [], []
    while waiting:
        group = waiting.pop()
        for axis in (0, 1):
            order = group[np.argsort(low[group, axis])]
            gaps = np.flatnonzero(low[order[1:], axis] > np.maximum.accumulate(high[order, axis])[:-1])
            if len(gaps):
                waiting += np.split(order, gaps + 1)
                break
        else:
            groups.append(group)
    return groups


def open_places(found: SearchedChains) -> list[OpenPlace]:
    """Those that are seen before arcs are joined."""
    if not (len(found.opened) or (found.arcs[:, columns.START] == -2).any()):
        return []
    kinds = found.places[:, columns.KIND].tolist()
    ends = {int(k) for pair in found.arcs[:, [columns.START, columns.END]].tolist() if pair[0] >= 0 for k in pair}
    parts, ranges = open_boxes(found, [], [k for k in ends if kinds[k] > 0])
    return [open_place(found, parts[group], ranges[group]) for group in touching(parts, ranges)]


def open_place(found: SearchedChains | Solved, parts: np.ndarray, ranges: np.ndarray) -> OpenPlace:
    own = []
    for side, chain in enumerate((found.p, found.q)):
        which = parts[:, side].astype(int)
        u = np.concatenate([chain.parameter(which, ranges[:, 2 * side + end]) for end in (0, 1)])
        own.append((float(u.min()), float(u.max())))
    middle = slice(len(parts) // 2, len(parts) // 2 + 1)
    ends = (own[0] for own in _middle_rulings(found, parts[middle], ranges[middle]))
    return OpenPlace(_nearest_point(*ends), own[0], own[1], 0)


def _middle_rulings(
    found: SearchedChains | Solved, parts: np.ndarray, ranges: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2, 3) the ends of those of both chains in the middle of boxes."""
    p, q = (chain.rulings(parts[:, k].astype(int), ranges[:, 2 * k : 2 * k + 2].mean(axis=1))
            for k, chain in enumerate((found.p, found.q)))  # fmt: skip
    return p, q


def _nearest_point(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The middle of the shortest way between two segments, (2, 3) each."""
    along, other = p[1] - p[0], q[1] - q[0]
    s = 0.5
    for _ in range(8):  # a point near it will do
        t = float(np.clip((p[0] + s * along - q[0]) @ other / max(other @ other, LEAST), 0, 1))
        s = float(np.clip((q[0] + t * other - p[0]) @ along / max(along @ along, LEAST), 0, 1))
    return 0.5 * (p[0] + s * along + q[0] + t * other)


def touched(solved: Solved, parts: np.ndarray, ranges: np.ndarray) -> set[PiecePair]:
    """The pairs of pieces that boxes touch, also by a side."""
    return {pair for side in np.unique(_sides_touched(parts, ranges)).tolist() for pair in _pairs(solved, side)}


def _sides_touched(parts: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """(n,): numbers that tell the parts of boxes, and by four bits whether they reach the start and end of x, of y."""
    i, j = parts.astype(int).T
    bits = ((ranges <= 0.0) & [True, False, True, False]) | ((ranges >= 1.0) & [False, True, False, True])
    return (i << 34) + (j << 4) + bits @ np.array([1, 2, 4, 8])


def _pairs(solved: Solved, side: int) -> set[PiecePair]:
    """Those touched by boxes with such a number of _sides_touched."""
    i, j = side >> 34, (side >> 4) & (2**30 - 1)
    low_u, high_u, low_v, high_v = (bool(side & bit) for bit in (1, 2, 4, 8))
    return set(product(solved.p.neighbours(i, low_u, high_u), solved.q.neighbours(j, low_v, high_v)))


def without(solved: Solved, settled: Settled) -> Solved:
    """What is not in pairs of pieces that are decided exactly."""
    arcs, opened = solved.arcs.copy(), solved.opened
    i, j = arcs[:, columns.ARC_U].astype(int), arcs[:, columns.ARC_V].astype(int)
    arcs[settled.mask()[solved.p.piece_of[i], solved.q.piece_of[j]], columns.START] = -1
    sides, row_of = np.unique(_sides_touched(opened[:, :2], opened[:, 2:]), return_inverse=True)
    kept = np.array([not _pairs(solved, side) <= settled.known.keys() for side in sides.tolist()], bool)
    places = solved.places.copy()
    for k in _crossings_side_by_side(solved):
        if touched(solved, *_box_of(places[k])) <= settled.known.keys():
            places[k, columns.KIND] = 0
    lines = lines_of(arcs, places[:, columns.KIND].astype(int))
    return solved._replace(arcs=arcs, places=places, lines=lines, opened=opened[kept[row_of]])


def _box_of(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A place as a box: its parts and ranges, one row each."""
    x, y = place[columns.X], place[columns.Y]
    return place[None, [columns.PART_U, columns.PART_V]], np.array([[x, x, y, y]])
