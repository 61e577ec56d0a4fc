"""All zeros of a square system in boxes, in ball arithmetic: for what doubles leave open.

A box is dropped where an equation has no zero on it or Krawczyk's image of it lies beside it.  Where the image lies
inside it, the box holds exactly one zero.  Others are narrowed to the image, by every equation alone too, or halved.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

from flint import arb, arb_mat

from firstcontact.exact.numbers import precision
from firstcontact.exact.systems.square_systems import Equations, Zero, krawczyk_image

Box = list[arb]
BITS = 192
ENOUGH = 0.5
"""Part of its widest side to which an image must narrow a box lest it be halved."""
LEAST = 2.0**-120
"""Part of its first width below which a side is not halved, nor narrowed below half of that: next to a zero at 0 sides
shrink by squares, and their exponents would fill the memory."""
RANK = 1e-7
"""Pivots of a matrix with rows of about 1 that count as none."""


class Isolation(NamedTuple):
    """zeros: simple ones, each once; left: boxes that may hold others; looked: how many were looked at."""

    zeros: list[Zero]
    left: list[Box]
    looked: int = 0


def isolated(
    system: Equations, boxes: Sequence[Sequence[arb]], most: int = 200, drops: Callable[[Box], bool] | None = None
) -> Isolation:
    """All zeros in the boxes; most: boxes looked at, after which the rest is left.

    drops: tells boxes whose zeros are not asked for, of which none need be found.
    """
    found, rest = Isolation([], []), most
    with precision(BITS):
        for box in boxes:
            rest = _search(system, list(box), found, rest, drops)
    return found._replace(looked=most - rest)


def _search(
    system: Equations, first: Box, found: Isolation, most: int, drops: Callable[[Box], bool] | None
) -> int:
    """Add what the box holds; the number of boxes that may still be looked at."""
    widths = [c.rad() for c in first]
    queue = deque([first])
    while queue:
        box = queue.popleft()  # the largest first, so that what is left in the end is small
        if any(_holds(zero, box) for zero in found.zeros):
            continue
        if most <= 0:
            found.left.append(box)
            continue
        most -= 1
        left = _narrowed(system, box)
        if isinstance(left, Zero):
            if not any(left.is_same(zero) for zero in found.zeros):
                found.zeros.append(left)
            continue
        if left is None:
            continue
        left = [_not_narrower(c, 0.5 * LEAST * w) for c, w in zip(left, widths, strict=True)]
        shares = [_share(c, w) for c, w in zip(left, widths, strict=True)]
        widest = max(range(len(box)), key=shares.__getitem__)
        if shares[widest] <= ENOUGH * max(_share(c, w) for c, w in zip(box, widths, strict=True)):
            queue.append(left)
        elif shares[widest] < LEAST:
            found.left.append(left)
        elif drops is None or not drops(left):
            queue += reversed(_halves(left, widest))  # lower halves first: what is left over comes late
    return most


def _not_narrower(side: arb, least: arb) -> arb:
    return side if side.rad() >= least else arb(side.mid(), least)


def _share(side: arb, width: arb) -> float:
    return float((side.rad() / width).mid()) if width > 0 else 0.0


def _holds(zero: Zero, box: Box) -> bool:
    """Whether all of the box is where this zero is the only one."""
    return all(arb(m, r).contains(c) for m, r, c in zip(zero.centre, zero.reach, box, strict=True))


def _halves(box: Box, k: int) -> list[Box]:
    """Both, which may overlap by roundings."""
    quarter = box[k].rad() / 2
    middles = box[k].mid() - quarter, box[k].mid() + quarter
    return [[*box[:k], arb(m, quarter), *box[k + 1 :]] for m in middles]


def _narrowed(system: Equations, box: Box) -> Box | Zero | None:
    """The part that may hold zeros, or its only zero; None where there is none."""
    centre = [arb(c.mid()) for c in box]
    offset = [arb(0, c.rad()) for c in box]
    values, slopes = system.values(centre), arb_mat(system.jacobian(box))
    column = arb_mat(len(box), 1, offset)
    if not all((v + d).contains(0) for v, d in zip(values, (slopes * column).entries(), strict=True)):
        return None
    box = _narrowed_by_each(values, slopes.tolist(), centre, offset, box)
    part = _partial_inverse(slopes, offset)
    for y in (None,) if part is None else (None, part):
        moved = krawczyk_image(values, slopes, offset, y)
        if moved is None:
            continue
        image = [c + i for c, i in zip(centre, moved, strict=True)]
        if all(d.contains_interior(i) for d, i in zip(offset, moved, strict=True)):
            return Zero(system, centre, [d.rad() for d in offset], image)
        if not all(x.overlaps(c) for x, c in zip(image, box, strict=True)):
            return None
        box = [x.intersection(c) if x.is_finite() else c for x, c in zip(image, box, strict=True)]
    return box


def _partial_inverse(slopes: arb_mat, offset: Box) -> arb_mat | None:
    """The inverse of the largest regular part of a matrix that is singular as far as doubles tell, in units of the box;
    None of another one.

    Zeros in curves (two parallel cylinders touch along a line) are so narrowed in all directions but one.
    """
    rows = slopes.tolist()
    pivots = _pivots([[float((x * d.rad()).mid()) for x, d in zip(row, offset, strict=True)] for row in rows])
    if not 0 < len(pivots) < len(offset):
        return None
    part = arb_mat([[slopes[i, j].mid() for _, j in pivots] for i, _ in pivots])
    try:
        inverse = part.inv().mid()
    except ZeroDivisionError:
        return None
    whole = arb_mat(len(offset), len(offset))
    for p, (_, j) in enumerate(pivots):
        for q, (i, _) in enumerate(pivots):
            whole[j, i] = inverse[p, q]
    return whole


def _pivots(rows: list[list[float]]) -> list[tuple[int, int]]:
    """Rows and columns that elimination with full pivoting takes before what is left counts as none."""
    largest = [max(map(abs, row)) for row in rows]
    rows = [[x / size if size > RANK * max(largest) else 0.0 for x in row]
            for row, size in zip(rows, largest, strict=True)]  # fmt: skip
    found: list[tuple[int, int]] = []
    free, columns = set(range(len(rows))), set(range(len(rows)))
    while free:
        i, j = max(((i, j) for i in free for j in columns), key=lambda at: abs(rows[at[0]][at[1]]))
        if not abs(rows[i][j]) > RANK:
            break
        found.append((i, j))
        free.remove(i)
        columns.remove(j)
        for k in free:
            factor = rows[k][j] / rows[i][j]
            rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i], strict=True)]
    return found


def _narrowed_by_each(values: list[arb], slopes: list[list[arb]], centre: Box, offset: Box, box: Box) -> Box:
    """The box without what single equations rule out of single unknowns; that tells of zeros that are not simple, too,
    such as those of a line that lands on a plane."""
    found = list(box)
    for value, row in zip(values, slopes, strict=True):
        for k, slope in enumerate(row):
            if not slope.contains(0):
                rest = sum((c * d for j, (c, d) in enumerate(zip(row, offset, strict=True)) if j != k), value)
                image = centre[k] - rest / slope
                if image.overlaps(found[k]):
                    found[k] = image.intersection(found[k])
    return found
