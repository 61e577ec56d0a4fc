"""Boxes that hold a composite quadric model: a proof that it is bounded, and a box close around it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.carriers import Box, Plane, Quadric, QuarticCurve, Surface, doubles, inertia, inverse
from firstcontact.body.solid.csg import Tree, possible
from firstcontact.exact.numbers import precision, to_double

if TYPE_CHECKING:
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.body.solid.features import Edge

# Half-widths tried for the first box, in the units of the model; a solid that reaches further counts as unbounded.
REACHES = (8.0, 2.0**10, 2.0**24, 2.0**45, 2.0**80)
# Cells looked at before the search for a bound gives up; each is a few hundred nanoseconds.
MOST_CELLS = 400_000
BITS = 256


def proved_box(tree: Tree, surfaces: Sequence[Surface]) -> Box | None:
    """A cube around the origin outside of which the solid has no point; None when none of REACHES could be proved.

    The largest one is tried first, which tells solids without end, then no smaller ones than the surfaces are likely to
    reach.
    """
    if not _nothing_beyond(tree, surfaces, 1 / REACHES[-1]):
        return None
    likely = min(filter(None, map(_size, surfaces)), default=0.0)
    reach = next((r for r in REACHES if r >= likely and _nothing_beyond(tree, surfaces, 1 / r)), REACHES[-1])
    half = fmpq(int(reach))
    return (-half,) * 3, (half,) * 3


def _size(surface: Surface) -> float:
    """About how far from the origin a surface comes nearest to it or bends: 0 of one through it that does not tell."""
    form = _form_f(surface)
    if form.ndim == 1:
        return float(abs(form[3]) / np.abs(form[:3]).max())
    second = float(np.abs(form[:3, :3]).max())
    return max(float(np.abs(form[:3, 3]).max()) / second, math.sqrt(abs(float(form[3, 3])) / second))


def _nothing_beyond(tree: Tree, surfaces: Sequence[Surface], w: float) -> bool:
    """Whether all homogeneous points (d, v) with max |d| = 1 and 0 <= v <= w are outside.

    The surface of the cube of directions d is cut into squares; v keeps its range.
    """
    forms, signs = [_form_f(s) for s in surfaces], [_sign_at_infinity(s) for s in surfaces]
    steps = np.linspace(-1, 1, 17)[:-1] + 1 / 16
    u, v = (g.ravel() for g in np.meshgrid(steps, steps))
    cells = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            centre = np.empty((len(u), 3))
            centre[:, axis], centre[:, axis - 2], centre[:, axis - 1] = side, u, v
            cells.append(centre)
    centre, axes = np.concatenate(cells), np.repeat(np.arange(3), 2 * len(u))
    half = 1 / 16
    while len(centre) and len(centre) < MOST_CELLS:
        x = np.column_stack([centre, np.full(len(centre), w / 2)])
        h = np.full_like(x, half * 1.0000001)
        h[np.arange(len(x)), axes] = 0.0
        h[:, 3] = w / 2 * 1.0000001
        keep = _may_be_inside(tree, forms, x, h, signs)
        centre, axes, half = centre[keep], axes[keep], half / 2
        centre = np.concatenate([_moved(centre, axes, half, s, t) for s in (-1, 1) for t in (-1, 1)])
        axes = np.tile(axes, 4)
    return len(centre) == 0


def _moved(centre: np.ndarray, axes: np.ndarray, half: float, s: int, t: int) -> np.ndarray:
    moved = centre.copy()
    rows = np.arange(len(centre))
    moved[rows, axes - 2] += s * half
    moved[rows, axes - 1] += t * half
    return moved


def _form_f(surface: Surface) -> np.ndarray:
    """(4,) for a plane, (4, 4) for a quadric, float64."""
    if isinstance(surface, Plane):
        return np.array(doubles((surface.normal,))[0])
    return np.array(doubles(surface.form))


def _sign_at_infinity(surface: Surface) -> int:
    """1 of a form that is nowhere negative there, -1 of one nowhere positive, else 0."""
    if isinstance(surface, Plane):
        return 0
    positive, negative = inertia(tuple(row[:3] for row in surface.form[:3]))
    return int(negative == 0) - int(positive == 0)


def _may_be_inside(
    tree: Tree, forms: list[np.ndarray], x: np.ndarray, h: np.ndarray, signs: Sequence[int] | None = None
) -> np.ndarray:
    """(n,) bools: False proves that the box x +- h, rows (4,) homogeneous with w >= 0, holds no point of space inside.

    signs: of the forms at infinity.  A form of sign 1 is w (2 b d + c w) and what is not negative, so positive where
    w and the bracket are: that tells of the open end of a paraboloid, where the form itself comes down to 0.
    """
    below: list[np.ndarray] = []
    above: list[np.ndarray] = []
    reach = np.abs(x) + h
    for k, form in enumerate(forms):
        if form.ndim == 1:
            value, spread = x @ form, h @ np.abs(form)
            size = reach @ np.abs(form)
        else:
            image = x @ form
            value = np.sum(image * x, axis=1)
            spread = 2 * np.sum(np.abs(image) * h, axis=1) + np.sum((h @ np.abs(form)) * h, axis=1)
            size = np.sum((reach @ np.abs(form)) * reach, axis=1)
        spread = spread + size * 2.0**-45  # far more than the roundings above
        below.append(value < spread)
        above.append(value > -spread)
        if signs is not None and signs[k]:
            row = signs[k] * np.append(2 * form[:3, 3], form[3, 3])
            rising = x @ row > h @ np.abs(row) + (reach @ np.abs(row)) * 2.0**-45
            (below if signs[k] > 0 else above)[-1] &= ~rising
    return possible(tree, below, above)[0]


def tight_box(body: CompositeQuadric, box: Box) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner, (3,) float64, of a box around the bounded solid.

    A coordinate is largest at a vertex, on an edge or where a face's tangent plane is level; on cones and cylinders
    such points form rulings, which end on edges.  Where edges are of degree 4, cells that may be inside are used.
    """
    lo, hi = outward(box)
    curves = [*body.edges, *body.seams]
    if any(isinstance(e.carrier, QuarticCurve) for e in curves):
        new_lo, new_hi = hull_of_cells(body, box)
    else:
        points = [np.array([v.position for v in body.vertices]).reshape(-1, 3)]
        points += [_extremes_on_edge(edge) for edge in curves]
        level = [_level_points(face.carrier) for face in body.faces if isinstance(face.carrier, Quadric)]
        p = _of_the_solid(body, np.concatenate(points), np.concatenate([np.empty((0, 3)), *level]))
        pad = 1e-9 * (np.ptp(p, axis=0).max() + np.abs(p).max())
        new_lo, new_hi = p.min(axis=0) - pad, p.max(axis=0) + pad
    return np.maximum(lo, new_lo), np.minimum(hi, new_hi)


def _extremes_on_edge(edge: Edge) -> np.ndarray:
    """(n, 3): ends of the pieces, and where a coordinate is level along them."""
    found = []
    for piece in edge.pieces:
        parameters = [piece.lo, piece.hi]
        if edge.frame.shape[1] == 3:
            for k in range(3):
                parameters += [t for t in _level_parameters(edge.frame, k, piece.lo) if t <= piece.hi]
        found.append(edge.points(parameters))
    return np.concatenate(found)


def _level_parameters(frame: np.ndarray, k: int, start: float) -> list[float]:
    """Where coordinate k of the curve has derivative 0: A cos t + B sin t + D = 0; in [start, start + 2 pi)."""
    (a0, a1, a2), (b0, b1, b2) = frame[k], frame[3]
    a, b, d = a2 * b0 - a0 * b2, a0 * b1 - a1 * b0, a2 * b1 - a1 * b2
    length = math.hypot(a, b)
    if length == 0.0 or abs(d) > length:
        return []
    return [start + (math.atan2(b, a) + s * math.acos(-d / length) - start) % (2 * math.pi) for s in (1, -1)]


def _level_points(surface: Quadric) -> np.ndarray:
    """(n, 3): points of the surface where its tangent plane x_k = c is level.

    With D = Q^-1, the planes x_k = c tangent to the surface satisfy (e_k, -c) D (e_k, -c)^T = 0; it touches in
    D (e_k, -c)^T.  Worked out in balls from exact numbers: doubles lose the points of small or large surfaces.
    """
    try:
        dual = inverse(surface.form)
    except ZeroDivisionError:
        return np.empty((0, 3))
    found = []
    with precision(BITS):
        for k in range(3):
            for c, w in _level_planes(dual[3][3], dual[k][3], dual[k][k]):
                found.append([float((arb(row[k]) - c * arb(row[3])) / w) for row in dual[:3]])
    return np.array(found).reshape(-1, 3)


def _of_the_solid(body: CompositeQuadric, sure: np.ndarray, level: np.ndarray) -> np.ndarray:
    """The sure points, and the level ones at which the solid may have points."""
    points = np.concatenate([sure, level])
    may_be = body._possible(points, slack=1e-7)[0]
    may_be[: len(sure)] = True
    possibly: np.ndarray = points[may_be]
    return possibly


def _level_planes(a: fmpq, b: fmpq, c: fmpq) -> list[tuple[arb, arb]]:
    """(t, b - a t) for the real roots of a t^2 - 2 b t + c = 0 at which b - a t is not zero."""
    if a == 0:
        return [(arb(c / (2 * b)), arb(b))] if b != 0 else []
    square = b * b - a * c
    if square <= 0:
        return []
    root = arb(square).sqrt()
    return [((arb(b) - w) / arb(a), w) for w in (root, -root)]


def outward(box: Box) -> tuple[np.ndarray, np.ndarray]:
    """The corners as doubles that hold the box."""
    lo = np.array([math.nextafter(to_double(x), -math.inf) for x in box[0]])
    return lo, np.array([math.nextafter(to_double(x), math.inf) for x in box[1]])


def hull_of_cells(body: CompositeQuadric, box: Box, n: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """The hull of the cells of ever finer grids, n along a side, that may hold points of the solid: (3,) corners."""
    lo, hi = outward(box)
    forms = [_form_f(s) for s in body.surfaces]
    for _ in range(3):
        centre, half = cells_of(lo, hi, n)
        x = np.column_stack([centre, np.ones(len(centre))])
        h = np.column_stack([np.tile(half * 1.0000001, (len(x), 1)), np.zeros(len(x))])
        kept: Any = centre[_may_be_inside(body.tree, forms, x, h)]
        if not len(kept):  # proved empty
            return lo, lo
        lo, hi = np.maximum(lo, kept.min(axis=0) - 1.000001 * half), np.minimum(hi, kept.max(axis=0) + 1.000001 * half)
    return lo, hi


def cells_of(lo: np.ndarray, hi: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n^3, 3) and half-widths (3,) of the cells of a grid over a box."""
    half = (hi - lo) / (2 * n)
    steps = [lo[k] + half[k] * (2 * np.arange(n) + 1) for k in range(3)]
    return np.stack([g.ravel() for g in np.meshgrid(*steps, indexing="ij")], axis=-1), half
