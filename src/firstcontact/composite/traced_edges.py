"""A check that tracing found every edge of degree 4, by points that each piece of one must have.

A piece of an edge is closed, and then the coordinate x has extrema on it, or it ends where a third surface crosses it.
Both are zeros of square systems, so all of them in the solid are found with proof; those at which the solid depends on
both surfaces of the curve lie on sharp edges, and must be near a traced one.  Not seen: a piece within two steps of
another one of the same curve, and pieces whose zeros stay open (nodes of the curve).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product

import numpy as np
from flint import fmpq, fmpq_mat, fmpz_poly

from firstcontact.body.carriers import Quadric, QuarticCurve
from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.body.csg import Tree, inside
from firstcontact.body.intersections import common_curves
from firstcontact.body.quartic_edges import STEPS
from firstcontact.composite.system_search import Solid, zeros_within
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomial_matrix import Matrix, constant
from firstcontact.exact.square_systems import SquareSystem, Zero

_NIL = fmpz_poly([0])
_LEVEL: Matrix = (
    (_NIL, _NIL, _NIL, fmpz_poly([1])),
    (_NIL,) * 4,
    (_NIL,) * 4,
    (fmpz_poly([1]), _NIL, _NIL, fmpz_poly([0, -2])),
)
"""2 (x - u)."""
_PRESENT: Matrix = ((_NIL,) * 4, (_NIL,) * 4, (_NIL,) * 4, (_NIL, _NIL, _NIL, fmpz_poly([0, 1])))
"""u: a system for one instant."""


def untraced(body: CompositeQuadric, box: tuple[Sequence[fmpq], Sequence[fmpq]]) -> list[np.ndarray]:
    """Points of sharp edges of degree 4 in the box that holds the body, far from every traced edge."""
    known: list[np.ndarray] | None = body._search.get("untraced")
    if known is None:
        known = body._search["untraced"] = [point for point, near in _checked(body, box) if not near]
    return known


def _checked(body: CompositeQuadric, box: tuple[Sequence[fmpq], Sequence[fmpq]]) -> Iterator[tuple[np.ndarray, bool]]:
    """Every proved point of a sharp edge of degree 4, and whether a traced edge is near."""
    forms = [constant(surface.matrix()) for surface in body.surfaces]
    size = float(np.linalg.norm([float((b - a).p) / float((b - a).q) for a, b in zip(*box, strict=True)]))
    quadrics = [k for k, surface in enumerate(body.surfaces) if isinstance(surface, Quadric)]
    for i, j in combinations(quadrics, 2):
        if not any(isinstance(c, QuarticCurve) for c in common_curves(body.surfaces[i], body.surfaces[j])):
            continue
        traced = [e.frame for e in body.edges + body.seams if {i, j} <= set(e.surfaces)]
        points = np.concatenate([t for t in traced if t.shape[1] == 3] or [np.full((1, 3), np.inf)])
        for zero, on in _zeros(body, forms, (i, j), box):
            x = np.array([float(c.mid()) for c in zero.balls(96)[:3]])
            if is_sharp(body.tree, _signs(forms, zero, on), i, j):
                yield x, bool(np.linalg.norm(points - x, axis=1).min() < 2 * size / STEPS)


def _zeros(
    body: CompositeQuadric, forms: list[Matrix], pair: tuple[int, int], box: tuple[Sequence[fmpq], Sequence[fmpq]]
) -> Iterator[tuple[Zero, frozenset[int]]]:
    """Where x is extremal on the common curve, and where other surfaces cross it."""
    curve = [forms[k] for k in pair]
    systems = [(SquareSystem([*curve, _LEVEL]), frozenset(pair), (box[0][0], box[1][0]))]
    for k in range(len(forms)):
        if k not in pair and not _in_pencil(*curve, forms[k]):
            system = SquareSystem([*curve, forms[k], _PRESENT])
            systems.append((system, frozenset((*pair, k)), (fmpq(-1), fmpq(1))))
    for system, on, span in systems:
        for zero in zeros_within(system, [Solid(body.tree, forms, on)], box, span, 1).zeros:
            yield zero, on


def _in_pencil(*forms: Matrix) -> bool:
    return int(fmpq_mat([[fmpq(p(0)) for row in form for p in row] for form in forms]).rank()) < len(forms)


def _signs(forms: list[Matrix], zero: Zero, on: frozenset[int]) -> list[int]:
    """Of all forms at the zero; 0 where they vanish or balls do not tell."""
    x = zero.balls(256)
    found = []
    with precision(320):
        point = [*x[:3], x[0] * 0 + 1]
        for k, form in enumerate(forms):
            value = sum((form[i][j](x[3]) * point[i] * point[j] for i in range(4) for j in range(4)), x[0] * 0)
            found.append(0 if k in on else 1 if value > 0 else -1 if value < 0 else 0)
    return found


def is_sharp(tree: Tree, signs: Sequence[int], i: int, j: int) -> bool:
    """Whether inside and outside depend on the sides of both surfaces, for some sides of the others at the point."""
    others = [k for k, sign in enumerate(signs) if sign == 0 and k not in (i, j)]
    for sides in product((True, False), repeat=len(others)):
        negative = [sign < 0 for sign in signs]
        for k, side in zip(others, sides, strict=True):
            negative[k] = side
        value = {}
        for a, b in product((True, False), repeat=2):
            negative[i], negative[j] = a, b
            value[a, b] = inside(tree, negative)
        by_i = any(value[True, b] != value[False, b] for b in (True, False))
        by_j = any(value[a, True] != value[a, False] for a in (True, False))
        if by_i and by_j:
            return True
    return False
