"""The tree of boxes over one body: built once in the frame that suits it, refitted where a query needs another.

Leaves hold one part each: a triangle, the part of a long triangle inside a cell (early split clipping, Ernst
& Greiner 2007), a bare edge (a, b, b) or a bare point (p, p, p).  Every edge and vertex is owned by one of
the primitives that hold it, so that a walk over two trees meets every pair of elements once (split triangles:
at least once).  The split is the binned surface-area heuristic (Wald 2007).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.polyhedron.polyhedron import LEAST
from firstcontact.exact.rigid import compose
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.boxes import CLIP_EPS, clip_to_box, segment_meets_box
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

# Bits of a part's mask: which of its three sides and corners it owns here, and what it is.
SIDE, CORNER, FLAT_SIDE = 0, 3, 6  # bit of side 0, corner 0, flat side 0
FACET, BARE, POINT, SPLIT = 1 << 9, 1 << 10, 1 << 11, 1 << 12

# Boxes of long oblique triangles overlap everything, so triangles whose box is wide (by the area of its largest
# side) are cut into parts: at most MAX_PARTS each and PARTS_BUDGET times the triangles in all, and none whose box
# is no wider than WIDE times the average.  Purely a matter of speed.
MAX_PARTS = 64
PARTS_BUDGET = 1.6
WIDE = 16.0

_BINS = 16


@dataclass(slots=True)
class Tree:
    """boxes (q, 6) lo, hi; links (q, 2): inner (left, right), leaf (part, -1); parts xyz (m, 9), ids (m, 2):
    primitive, mask.  Primitives: corners (k, 3) vertex and sides (k, 3) segment indices, -1 for none.

    `error` bounds |true coordinate - coordinate| over boxes and parts.
    """

    boxes: np.ndarray
    links: np.ndarray
    xyz: np.ndarray
    ids: np.ndarray
    corners: np.ndarray
    sides: np.ndarray
    error: float


def build(body: Polyhedron, vertices: np.ndarray, error: float) -> Tree:
    """The tree over the vertices (n, 3) of the body in some frame, each within `error` of its true place there."""
    corners, sides, kind = _primitives(body)
    masks = _masks(body, corners, sides, kind)
    corner_xyz = vertices[corners].reshape(len(corners), 9)
    part_box, part_ids = _parts(corner_xyz, masks, WIDE, PARTS_BUDGET, MAX_PARTS)
    boxes, links, order = _split(part_box)
    ids = part_ids[order]
    return Tree(boxes, links, corner_xyz[ids[:, 0]], ids, corners, sides, error)


def _primitives(body: Polyhedron) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles, then segments on no triangle, then vertices on neither; with the kind bits of each."""
    triangles, side_edge, segments = body.triangles, body.side_edge, body.segments
    bare = body.bare_edges().astype(np.int32)
    lonely = np.ones(len(body.vertices), bool)
    lonely[triangles.ravel()] = False
    lonely[segments[bare].ravel()] = False
    # a mesh file may carry vertices that nothing uses; only a pure point set means its points
    points = np.flatnonzero(lonely).astype(np.int32) if not len(triangles) and not len(segments) else bare[:0]
    none = np.full_like(bare, -1)
    corners = np.concatenate([
        triangles,
        np.stack([segments[bare, 0], segments[bare, 1], segments[bare, 1]], axis=1),
        np.stack([points] * 3, axis=1),
    ])  # fmt: skip
    sides = np.concatenate([
        side_edge,
        np.stack([bare, none, none], axis=1),
        np.stack([len(segments) + points, np.full_like(points, -1), np.full_like(points, -1)], axis=1),
    ])  # fmt: skip
    kind = np.repeat(
        np.array([FACET, BARE, BARE | POINT], np.int32), [len(triangles), len(bare), len(points)]
    )
    return np.ascontiguousarray(corners, np.int32), np.ascontiguousarray(sides, np.int32), kind


def _masks(body: Polyhedron, corners: np.ndarray, sides: np.ndarray, kind: np.ndarray) -> np.ndarray:
    """Masks (k,) int32 of the primitives, decided on the exact coordinates.

    Those of the body as it was given, where they are doubles or fractions: a map keeps planes, and sides of lines.
    """
    axes, is_exact = _axes_kept(body), body.fractions is None
    masks, doubtful = _owners(
        corners, sides, kind, body.base, axes, is_exact, len(body.segments), body.given_edges
    )
    for p, s, other in doubtful.tolist():
        if _exactly_coplanar(body, corners, axes, p, s, other):
            masks[p] ^= (1 << (SIDE + s)) | (1 << (FLAT_SIDE + s))
    return masks


def _axes_kept(body: Polyhedron) -> np.ndarray:
    """(3,) bools: which axes of the body as it was given a coordinate axis of its pose depends on alone."""
    matrix = body.matrix if body.irrational_pose is None else compose(body.irrational_pose.matrix(), body.matrix)
    axes = np.zeros(3, bool)
    for row in matrix:
        used = [k for k in range(3) if not row[k] == 0]  # an entry that is a ball is zero only where that is certain
        if len(used) == 1:
            axes[used] = True
    return axes


@kernel
def _owners(corners, sides, kind, vertices, axes, is_exact, n_segments, n_given):
    """Masks (k,) int32: the first primitive that holds an edge or vertex owns it; and sides in doubt (j, 3).

    A side is flat when it lies between exactly two triangles in one axis-parallel plane: contacts there are
    contacts of the true edges or of the face as well, so a search for the first contact may pass over it.
    The first n_given segments are edges because the user said so, and never flat.  In doubt, and taken for edges, are
    those that doubles do not decide: primitive, side, and that of the other triangle.
    """
    n = corners.shape[0]
    masks = kind.copy()
    doubtful, n_doubtful = np.empty((16, 3), np.int64), 0
    first = np.full(n_segments, -1, np.int64)
    second = np.full(n_segments, -1, np.int64)  # -2: more than two
    vertex_taken = np.zeros(vertices.shape[0], np.bool_)
    for p in range(n):
        if kind[p] & FACET:
            for s in range(3):
                e = sides[p, s]
                if e >= 0:
                    if first[e] < 0:
                        first[e] = 3 * p + s
                    else:
                        second[e] = 3 * p + s if second[e] == -1 else -2
    for p in range(n):
        for s in range(3):
            e, v = sides[p, s], corners[p, s]
            if not vertex_taken[v] and not (kind[p] & BARE and s == 2):
                vertex_taken[v] = True
                masks[p] |= 1 << (CORNER + s)
            if e < 0:
                continue
            if kind[p] & BARE:
                masks[p] |= 1 << SIDE
            elif first[e] == 3 * p + s:
                verdict = NONE
                if e >= n_given and second[e] >= 0:
                    verdict = _coplanar(vertices, corners, axes, is_exact, p, s, second[e])
                masks[p] |= 1 << ((FLAT_SIDE if verdict == CERTAIN else SIDE) + s)
                if verdict == UNSURE:
                    if n_doubtful == doubtful.shape[0]:
                        more = np.empty((2 * n_doubtful, 3), np.int64)
                        for k in range(n_doubtful):
                            for j in range(3):
                                more[k, j] = doubtful[k, j]
                        doubtful = more
                    doubtful[n_doubtful, 0], doubtful[n_doubtful, 1], doubtful[n_doubtful, 2] = p, s, second[e]
                    n_doubtful += 1
    return masks, doubtful[:n_doubtful].copy()


@uncounted
def _coplanar(vertices, corners, axes, is_exact, p, s, other):
    """Whether the triangles on both sides of a side lie in one plane across one of the axes, opposite each other.

    NONE where they certainly do not, or have an area that is certainly zero.  Equal numbers are equal as doubles, so
    those that differ as doubles differ.
    """
    a, b = corners[p, s], corners[p, (s + 1) % 3]
    c, d = corners[p, (s + 2) % 3], corners[other // 3, (other % 3 + 2) % 3]
    for k in range(3):
        h = vertices[a, k]
        if axes[k] and vertices[b, k] == h and vertices[c, k] == h and vertices[d, k] == h:
            if not is_exact:
                return UNSURE
            i, j = (k + 1) % 3, (k + 2) % 3
            ex, ey = vertices[b, i] - vertices[a, i], vertices[b, j] - vertices[a, j]
            left = ex * (vertices[c, j] - vertices[a, j]) - ey * (vertices[c, i] - vertices[a, i])
            right = ex * (vertices[d, j] - vertices[a, j]) - ey * (vertices[d, i] - vertices[a, i])
            size = abs(ex) + abs(ey)
            reach = max(
                max(abs(vertices[c, i] - vertices[a, i]), abs(vertices[c, j] - vertices[a, j])),
                max(abs(vertices[d, i] - vertices[a, i]), abs(vertices[d, j] - vertices[a, j])),
            )
            bound = 1e-15 * size * reach + 1e-290  # 4 roundings per product, one difference
            if (left > bound and right < -bound) or (left < -bound and right > bound):
                return CERTAIN
            return NONE if min(abs(left), abs(right)) > bound else UNSURE
    return NONE


def _exactly_coplanar(body: Polyhedron, corners: np.ndarray, axes: np.ndarray, p: int, s: int, other: int) -> bool:
    """`_coplanar`, in numbers without rounding."""
    places = corners[p, s], corners[p, (s + 1) % 3], corners[p, (s + 2) % 3], corners[other // 3, (other % 3 + 2) % 3]
    a, b, c, d = (_given(body, int(v)) for v in places)
    for k in np.flatnonzero(axes).tolist():
        if a[k] == b[k] == c[k] == d[k]:
            i, j = (k + 1) % 3, (k + 2) % 3
            left, right = ((b[i] - a[i]) * (x[j] - a[j]) - (b[j] - a[j]) * (x[i] - a[i]) for x in (c, d))
            if left * right < 0:
                return True
    return False


def _given(body: Polyhedron, i: int) -> tuple[Fraction, ...]:
    """Vertex i of the body as it was given."""
    return tuple(map(Fraction, body.base[i].tolist())) if body.fractions is None else body.fractions[i]


@kernel
def _parts(xyz, masks, wide, budget, max_parts):
    """Boxes (m, 6) and (primitive, mask) (m, 2) int32 of the parts; wide triangles give several."""
    n = xyz.shape[0]
    width = np.empty(n)
    whole = np.empty((n, 6))
    largest = flat_area = 0.0
    for p in range(n):
        for k in range(3):
            lo = min(xyz[p, k], xyz[p, k + 3], xyz[p, k + 6])
            hi = max(xyz[p, k], xyz[p, k + 3], xyz[p, k + 6])
            whole[p, k], whole[p, k + 3] = lo, hi
            largest = max(largest, abs(lo), abs(hi))
        x, y, z = whole[p, 3] - whole[p, 0], whole[p, 4] - whole[p, 1], whole[p, 5] - whole[p, 2]
        width[p] = max(x * y, y * z, z * x) if masks[p] & FACET else 0.0
        flat_area += _twice_area(xyz, p) if masks[p] & FACET else 0.0
    limit = wide * flat_area / max(n, 1)
    while _count_parts(width, limit, max_parts) > budget * n + 256:
        limit *= 2.0
    pad = CLIP_EPS * largest + LEAST
    box = np.empty((n, 6))
    ids = np.empty((n, 2), np.int32)
    stack, cell = np.empty((64, 6)), np.empty(6)
    polygon, scratch = np.empty((12, 3)), np.empty((12, 3))
    m = 0
    for p in range(n):
        for k in range(6):
            stack[0, k] = whole[p, k]
        depth, emitted = 1, 0
        splitting = width[p] > limit and limit > 0.0
        while depth > 0:
            depth -= 1
            for k in range(6):
                cell[k] = stack[depth, k]
            axis = 0
            for k in range(1, 3):
                if cell[k + 3] - cell[k] > cell[axis + 3] - cell[axis]:
                    axis = k
            x, y, z = cell[3] - cell[0], cell[4] - cell[1], cell[5] - cell[2]
            if splitting and max(x * y, y * z, z * x) > limit and emitted + depth + 2 <= max_parts:
                middle = 0.5 * (cell[axis] + cell[axis + 3])
                for upper in range(2):
                    child = stack[depth]
                    for k in range(6):
                        child[k] = cell[k]
                    child[axis + 3 * (1 - upper)] = middle
                    count = clip_to_box(xyz[p], child, polygon, scratch)
                    if count > 0:
                        _shrink(child, polygon, count, pad)
                        depth += 1
                continue
            if m == box.shape[0]:
                box, ids = _grown(box, ids)
            for k in range(6):
                box[m, k] = cell[k]
            ids[m, 0], ids[m, 1] = p, masks[p]
            if splitting:
                ids[m, 1] = _clipped_mask(masks[p], xyz[p], cell, pad) | SPLIT
            m += 1
            emitted += 1
    return box[:m].copy(), ids[:m].copy()


@uncounted
def _twice_area(xyz, p):
    e0, e1, e2 = xyz[p, 3] - xyz[p, 0], xyz[p, 4] - xyz[p, 1], xyz[p, 5] - xyz[p, 2]
    f0, f1, f2 = xyz[p, 6] - xyz[p, 0], xyz[p, 7] - xyz[p, 1], xyz[p, 8] - xyz[p, 2]
    x, y, z = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    return np.sqrt(x * x + y * y + z * z)


@uncounted
def _count_parts(width, limit, max_parts):
    """About how many parts boxes of those widths give: cutting into k divides the width by k squared or less."""
    total = 0.0
    for p in range(width.shape[0]):
        total += min(np.sqrt(width[p] / limit) + 1.0, max_parts) if width[p] > limit > 0.0 else 1.0
    return total


@uncounted
def _shrink(cell, polygon, count, pad):
    """Shrink the cell to the polygon's corners, `pad` wider."""
    for k in range(3):
        lo, hi = polygon[0, k], polygon[0, k]
        for j in range(1, count):
            lo, hi = min(lo, polygon[j, k]), max(hi, polygon[j, k])
        cell[k] = max(cell[k], lo - pad)
        cell[k + 3] = min(cell[k + 3], hi + pad)


@uncounted
def _clipped_mask(mask, xyz, cell, pad):
    """The mask without sides and corners that certainly miss the cell."""
    for s in range(3):
        p, q = xyz[3 * s : 3 * s + 3], xyz[3 * ((s + 1) % 3) : 3 * ((s + 1) % 3) + 3]
        side = (1 << (SIDE + s)) | (1 << (FLAT_SIDE + s))
        if mask & side and not segment_meets_box(p, q, cell, pad):
            mask &= ~side
        for k in range(3):
            if p[k] < cell[k] - pad or p[k] > cell[k + 3] + pad:
                mask &= ~(1 << (CORNER + s))
    return mask


@kernel
def _grown(box, ids):
    # by loops: one assignment of slices takes Numba 2 s to compile, most of it for the text of its error
    n = box.shape[0]
    new_box, new_ids = np.empty((2 * n + 64, 6)), np.empty((2 * n + 64, 2), np.int32)
    for p in range(n):
        for k in range(6):
            new_box[p, k] = box[p, k]
        new_ids[p, 0], new_ids[p, 1] = ids[p, 0], ids[p, 1]
    return new_box, new_ids


@kernel
def _split(part_box):
    """Top-down binned SAH.  Returns boxes (2m - 1, 6), links (2m - 1, 2) int32 and the order of the parts.

    Sorts the rows of `part_box` into that order, so that every pass reads on.  Children follow their parent, so one
    backward sweep refits all boxes.
    """
    m = part_box.shape[0]
    order = np.arange(m)
    boxes = np.empty((2 * m - 1, 6))
    links = np.empty((2 * m - 1, 2), np.int32)
    stack = np.empty((128, 3), np.int64)
    centres = np.empty((128, 6))  # ranges of lo + hi
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, m
    _bound(part_box, 0, m, boxes[0], centres[0])
    depth, used = 1, 1
    count, bins = np.empty((3, _BINS), np.int64), np.empty((3, _BINS, 6))
    area_right, sweep = np.empty(_BINS), np.empty(6)
    while depth > 0:
        depth -= 1
        node, first, last = stack[depth]
        if last - first == 1:
            links[node, 0], links[node, 1] = first, -1
            continue
        middle, c = first, centres[depth]
        if last - first > 4:
            axis, limit = _best_bin(part_box, first, last, c, count, bins, area_right, sweep)
            if axis >= 0:
                middle = _partition(part_box, order, first, last, axis, limit)
        if middle == first or middle == last or (depth > 60 and last - first > 4):
            middle = (first + last) // 2  # few parts: halves by the widest axis; coincident centres: any halves
            axis = 0
            if c[4] - c[1] > c[3] - c[0]:
                axis = 1
            if c[5] - c[2] > max(c[3] - c[0], c[4] - c[1]):
                axis = 2
            if last - first <= 4:
                _insertion(part_box, order, first, last, axis)
        links[node, 0], links[node, 1] = used, used + 1
        for k in range(2):
            start, end = (middle, last) if k else (first, middle)
            # the smaller half last: it is taken first, which keeps the stack logarithmic
            slot = depth + k if middle - first >= last - middle else depth + 1 - k
            stack[slot, 0], stack[slot, 1], stack[slot, 2] = used + k, start, end
            _bound(part_box, start, end, boxes[used + k], centres[slot])
        depth += 2
        used += 2
    return boxes, links, order


@uncounted
def _bound(part_box, first, last, box, centres):
    """The box of the parts, and the range of their lo + hi."""
    lo0 = lo1 = lo2 = c_lo0 = c_lo1 = c_lo2 = np.inf
    hi0 = hi1 = hi2 = c_hi0 = c_hi1 = c_hi2 = -np.inf
    for i in range(first, last):
        b = part_box[i]
        lo0, lo1, lo2 = min(lo0, b[0]), min(lo1, b[1]), min(lo2, b[2])
        hi0, hi1, hi2 = max(hi0, b[3]), max(hi1, b[4]), max(hi2, b[5])
        c0, c1, c2 = b[0] + b[3], b[1] + b[4], b[2] + b[5]
        c_lo0, c_lo1, c_lo2 = min(c_lo0, c0), min(c_lo1, c1), min(c_lo2, c2)
        c_hi0, c_hi1, c_hi2 = max(c_hi0, c0), max(c_hi1, c1), max(c_hi2, c2)
    box[0], box[1], box[2], box[3], box[4], box[5] = lo0, lo1, lo2, hi0, hi1, hi2
    centres[0], centres[1], centres[2] = c_lo0, c_lo1, c_lo2
    centres[3], centres[4], centres[5] = c_hi0, c_hi1, c_hi2


@uncounted
def _best_bin(part_box, first, last, centres, count, bins, area_right, sweep):
    """(axis, limit on lo + hi) of the cheapest split by surface area; axis -1 when nothing separates."""
    n_bins = _BINS if last - first > _BINS else _BINS // 2
    for axis in range(3):
        for b in range(n_bins):
            count[axis, b] = 0
            for k in range(3):
                bins[axis, b, k], bins[axis, b, k + 3] = np.inf, -np.inf
    scales = _scale(centres, 0, n_bins), _scale(centres, 1, n_bins), _scale(centres, 2, n_bins)
    for i in range(first, last):
        box = part_box[i]
        for axis in range(3):
            b = int((box[axis] + box[axis + 3] - centres[axis]) * scales[axis])
            count[axis, b] += 1
            _widen(bins[axis, b], box)
    best, best_axis, best_limit = np.inf, -1, 0.0
    for axis in range(3):
        if scales[axis] == 0.0:
            continue
        _empty(sweep)
        n = 0
        for b in range(n_bins - 1, 0, -1):
            _widen(sweep, bins[axis, b])
            n += count[axis, b]
            area_right[b] = n * _area(sweep)
        _empty(sweep)
        n = 0
        for b in range(n_bins - 1):
            _widen(sweep, bins[axis, b])
            n += count[axis, b]
            if n == 0 or n == last - first:
                continue
            cost = n * _area(sweep) + area_right[b + 1]
            if cost < best:
                best, best_axis, best_limit = cost, axis, centres[axis] + (b + 1) / scales[axis]
    return best_axis, best_limit


@uncounted
def _scale(centres, axis, n_bins):
    """Bins per length; 0 where the centres have one place in the axis, or nearly so."""
    width = centres[axis + 3] - centres[axis]
    scale = n_bins * (1.0 - 1e-9) / width if width > 0.0 else 0.0
    return scale if scale < np.inf else 0.0


@uncounted
def _empty(box):
    for k in range(3):
        box[k], box[k + 3] = np.inf, -np.inf


@uncounted
def _widen(box, other):
    """Make the box hold the other one too."""
    for k in range(3):
        box[k], box[k + 3] = min(box[k], other[k]), max(box[k + 3], other[k + 3])


@uncounted
def _area(box):
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x if x >= 0.0 else 0.0


@uncounted
def _partition(part_box, order, first, last, axis, limit):
    i, j = first, last - 1
    while True:
        while i <= j and part_box[i, axis] + part_box[i, axis + 3] < limit:
            i += 1
        while i <= j and not part_box[j, axis] + part_box[j, axis + 3] < limit:
            j -= 1
        if i >= j:
            return i
        _swap(part_box, order, i, j)


@uncounted
def _insertion(part_box, order, first, last, axis):
    for i in range(first + 1, last):
        j = i
        while j > first:
            if part_box[j, axis] + part_box[j, axis + 3] >= part_box[j - 1, axis] + part_box[j - 1, axis + 3]:
                break
            _swap(part_box, order, j, j - 1)
            j -= 1


@uncounted
def _swap(part_box, order, i, j):
    order[i], order[j] = order[j], order[i]
    for k in range(6):
        part_box[i, k], part_box[j, k] = part_box[j, k], part_box[i, k]
