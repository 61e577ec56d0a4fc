"""Frames: that of a rotation axis, the one natural to a body, and the views of a tree in them.

A frame is a matrix with orthonormal rows, the last one along the axis.  Axes along coordinate axes give signed
permutations, which are exact; others are rounded, and the rounding is part of the view's error.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import LEAST
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.lifted.boxes import CLIP_EPS, clip_to_box
from firstcontact.search.trees.tree import SPLIT, Tree, build

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

Frame = tuple[tuple[float, float, float], ...]

_ALONG = {
    (1, 0, 0): ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    (0, 1, 0): ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    (0, 0, 1): ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    (-1, 0, 0): ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    (0, -1, 0): ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    (0, 0, -1): ((0, 1, 0), (1, 0, 0), (0, 0, -1)),
}

_WORLD: Frame = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

# |entry of the rounded frame - entry of an exact frame with the same axis| <= FRAME_EPS: a handful of roundings
# of numbers at most 1, starting from an axis rounded once.  See test_frame_is_orthonormal.
FRAME_EPS = 1e-15


@lru_cache(maxsize=64)
def frame_of(axis: tuple[float, float, float]) -> Frame:
    """The frame of an axis given by doubles, right-handed."""
    direction = tuple((x > 0) - (x < 0) for x in axis)
    if direction in _ALONG and sum(map(abs, direction)) == 1:
        return _ALONG[direction]  # type: ignore[index]
    h = np.array(axis)
    h = h / np.abs(h).max()
    h /= np.linalg.norm(h)
    seed = np.zeros(3)
    seed[int(np.argmin(np.abs(h)))] = 1.0
    u = np.cross(seed, h)
    u /= np.linalg.norm(u)
    v = np.cross(h, u)
    return tuple(map(tuple, np.array([u, v, h]).tolist()))  # type: ignore[return-value]


# A direction counts as natural to a body when faces across it make up this share of the area.
NATURAL_SHARE = 0.1
_SAMPLE = 4096
_NATURAL = Kept[tuple[float, Frame | None]]()
_TREE = Kept[Tree]()
_VIEW = Kept[tuple[Frame, Tree]]()
_STRUCTURE = Kept[tuple[Frame | None, Tree]]()


def shared_frame(a: Polyhedron, b: Polyhedron) -> Frame | None:
    """The frame natural to the body with the larger flat faces; None where the world's axes do as well."""
    (share_a, frame_a), (share_b, frame_b) = natural_frame(a), natural_frame(b)
    return frame_a if share_a > share_b else frame_b


def natural_frame(body: Polyhedron) -> tuple[float, Frame | None]:
    """(share of the area across the main direction, frame with that direction last); kept on the body.

    Boxes along the faces of a body are flat; in another frame they are fat.  Looks at some thousand triangles.
    """
    if body.translate_of is not None:
        return natural_frame(body.translate_of)
    return _NATURAL.of(body, lambda: _find_natural_frame(body))


def _find_natural_frame(body: Polyhedron) -> tuple[float, Frame | None]:
    normals, areas, weights = _sample(twice_area_vectors(body.vertices, body.triangles))
    if len(areas) == 0:
        return 0.0, None
    units = normals / areas[:, None]
    areas = areas * weights
    share, main = _main_direction(units, areas)
    if share < NATURAL_SHARE:
        return 0.0, None
    across = np.abs(units @ main) < 0.05
    second = np.zeros(3)
    if areas[across].sum() > 0:
        share_2, direction = _main_direction(units[across], areas[across])
        if share_2 > NATURAL_SHARE:
            second = direction
    if np.abs(main).max() > 1 - 1e-12 and (not second.any() or np.abs(second).max() > 1 - 1e-12):
        return share, None
    if not second.any():
        second[int(np.argmin(np.abs(main)))] = 1.0
    u = second - (second @ main) * main
    u /= np.linalg.norm(u)
    return share, tuple(map(tuple, np.array([u, np.cross(main, u), main]).tolist()))  # type: ignore[return-value]


def _sample(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(normals, areas, how many triangles each stands for): the largest triangles, and some of all others."""
    areas = np.linalg.norm(normals, axis=1)
    if len(areas) <= _SAMPLE:
        chosen = np.flatnonzero(areas)
        return normals[chosen], areas[chosen], np.ones(len(chosen))
    half = _SAMPLE // 2
    order = np.argpartition(areas, len(areas) - half)
    rest = np.random.default_rng(0).choice(order[:-half], half)
    chosen = np.concatenate([order[-half:], rest])
    weights = np.repeat([1.0, (len(areas) - half) / half], half)
    positive = areas[chosen] > 0
    chosen = chosen[positive]
    return normals[chosen], areas[chosen], weights[positive]


@kernel
def twice_area_vectors(vertices, triangles):
    """Normals (m, 3) of the triangles, as long as twice their areas."""
    out = np.empty((triangles.shape[0], 3))
    for p in range(triangles.shape[0]):
        a, b, c = triangles[p]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            e, f = vertices[b, i] - vertices[a, i], vertices[b, j] - vertices[a, j]
            g, h = vertices[c, i] - vertices[a, i], vertices[c, j] - vertices[a, j]
            out[p, k] = e * h - f * g
    return out


def _main_direction(units: np.ndarray, areas: np.ndarray) -> tuple[float, np.ndarray]:
    """(share of the area, unit direction) of the most common normal, up to sign and about a degree."""
    largest = np.take_along_axis(units, np.abs(units).argmax(axis=1)[:, None], axis=1)
    units = units * np.sign(largest)
    _, group = np.unique(np.rint(units * 64).astype(np.int64) @ (1, 1000, 1000000), return_inverse=True)
    weights = np.bincount(group, areas)
    best = group == weights.argmax()
    direction = (units[best] * areas[best, None]).sum(axis=0)
    return float(weights.max() / areas.sum()), direction / np.linalg.norm(direction)


def tree_of(body: Polyhedron) -> Tree:
    """The tree in the world's axes, its parts the doubles of the body; made on first use and kept on the body."""
    known = _TREE.get(body)
    if known is not None:
        return known
    frame, built = _structure(body)
    return _TREE.put(body, built if frame is None else _refit_tree(body, _WORLD))


def view_in(body: Polyhedron, frame: Frame) -> Tree:
    """The body's tree with boxes and coordinates in the frame; kept on the body for the next query."""
    if frame == _WORLD:
        return tree_of(body)
    natural, built = _structure(body)
    if frame == natural:
        return built
    cached = _VIEW.get(body)
    if cached is None or cached[0] != frame:
        cached = _VIEW.put(body, (frame, _refit_tree(body, frame)))
    return cached[1]


def _structure(body: Polyhedron) -> tuple[Frame | None, Tree]:
    """The tree as it is built, in the body's natural frame (None: the world's axes): all views share its links."""
    known = _STRUCTURE.get(body)
    if known is not None:
        return known
    frame = natural_frame(body)[1]
    vertices, error = body.vertices, body.error
    if frame is not None:
        vertices, error = vertices @ np.array(frame).T, _framed_error(body, frame)
    if body.translate_of is not None:
        built = _translated(_structure(body.translate_of)[1], vertices, error)
    else:
        built = build(body, np.ascontiguousarray(vertices), error)
    return _STRUCTURE.put(body, (frame, built))


def _translated(built: Tree, vertices: np.ndarray, error: float) -> Tree:
    """The tree over the vertices (n, 3) of a translate, in the frame of a tree that is built: its links, its parts."""
    xyz = vertices[built.corners[built.ids[:, 0]]].reshape(len(built.ids), 9)
    size = max(float(np.abs(xyz).max()), float(np.abs(built.xyz).max()))
    slack = 2.0 * (error + built.error) + 1e-15 * size  # cells that parts are cut by move with them, up to roundings
    shift = np.tile(xyz[0, :3] - built.xyz[0, :3], 2)
    cells = built.boxes + shift + np.repeat([-slack, slack], 3)
    boxes, xyz = refit(cells, built.links, xyz, xyz, built.ids, np.eye(3), np.eye(3), slack)
    return replace(built, boxes=boxes, xyz=xyz, error=error)


def _framed_error(body: Polyhedron, frame: Frame) -> float:
    """Bound on the error of the body's coordinates in the frame.

    Three products and two sums, 1-norm of a row at most sqrt(3), entries off by FRAME_EPS.
    """
    if all(x in (0, 1, -1) for row in frame for x in row):
        return body.error
    size = float(np.abs(body.vertices).max())
    return 1.8 * body.error + 3.0 * size * (FRAME_EPS + 4.0 * 2.0**-53) + LEAST


def _refit_tree(body: Polyhedron, frame: Frame) -> Tree:
    natural, built = _structure(body)
    matrix = np.array(frame, float)
    xyz = body.vertices[built.corners[built.ids[:, 0]]].reshape(len(built.ids), 9)
    cells = matrix @ np.array(natural or _WORLD).T
    # places in cells come from coordinates of the natural frame and through the product of two frames: each
    # entry of both off by FRAME_EPS and its roundings, 5e-14 of the size in all
    slack = 0.0 if natural is None else 1e-13 * float(np.abs(body.vertices).max())
    boxes, xyz = refit(built.boxes, built.links, built.xyz, xyz, built.ids, cells, matrix, slack)
    return replace(built, boxes=boxes, xyz=xyz, error=_framed_error(body, frame))


@kernel
def refit(boxes, links, cut, xyz, ids, cells, frame, slack):
    """Boxes (q, 6) and parts (m, 9) in the frame (3, 3).

    boxes, cut: boxes and parts as built, `cells` (3, 3) takes them to the frame; xyz (m, 9): parts in world axes.
    """
    new_boxes, new_xyz = np.empty_like(boxes), np.empty_like(xyz)
    polygon, scratch = np.empty((12, 3)), np.empty((12, 3))
    largest = 0.0
    for k in range(6):
        largest = max(largest, abs(boxes[0, k]))
    pad = CLIP_EPS * largest * 3.0 + slack + LEAST
    for node in range(boxes.shape[0] - 1, -1, -1):
        box = new_boxes[node]
        if links[node, 1] >= 0:
            left, right = new_boxes[links[node, 0]], new_boxes[links[node, 1]]
            for k in range(3):
                box[k], box[k + 3] = min(left[k], right[k]), max(left[k + 3], right[k + 3])
            continue
        part = links[node, 0]
        x, y = xyz[part], new_xyz[part]
        for c in range(3):
            for k in range(3):
                y[3 * c + k] = (
                    frame[k, 0] * x[3 * c] + frame[k, 1] * x[3 * c + 1] + frame[k, 2] * x[3 * c + 2]
                )
        split = ids[part, 1] & SPLIT
        count = clip_to_box(cut[part], boxes[node], polygon, scratch) if split else 0
        for k in range(3):
            if count == 0:
                box[k], box[k + 3] = min(y[k], y[k + 3], y[k + 6]), max(y[k], y[k + 3], y[k + 6])
                continue
            lo, hi = np.inf, -np.inf
            for c in range(count):
                v = cells[k, 0] * polygon[c, 0] + cells[k, 1] * polygon[c, 1] + cells[k, 2] * polygon[c, 2]
                lo, hi = min(lo, v), max(hi, v)
            box[k], box[k + 3] = lo - pad, hi + pad
    return new_boxes, new_xyz
