"""The tree: nothing of a body lies outside its boxes, and every edge and vertex is owned."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import firstcontact as fc
import generators as g
from firstcontact.exact.numbers import precision
from firstcontact.search.trees.frame import frame_of, natural_frame, tree_of, view_in
from firstcontact.search.trees.tree import BARE, CORNER, FACET, FLAT_SIDE, SIDE, SPLIT
from unit.test_constants import exact_frame


def polyhedron(body) -> fc.Polyhedron:
    return fc.Polyhedron(body.v, body.f, edges=body.e or None)


def needles(seed: int, n: int = 150) -> fc.Polyhedron:
    """Small triangles and a few long oblique slivers, which are split."""
    rng = np.random.default_rng(seed)
    p = rng.uniform(-1, 1, (n, 1, 3)) + 0.05 * rng.uniform(-1, 1, (n, 3, 3))
    long = p[::25]
    long[:, 0] = rng.uniform(-8, -4, (len(long), 3))
    long[:, 1] = rng.uniform(4, 8, (len(long), 3))
    long[:, 2] = long[:, 0] + rng.uniform(-0.1, 0.1, (len(long), 3))
    long[1, :, 2] = 0.3  # flat in a coordinate plane
    long[2, :, 1] = long[2, :, 0]  # upright in a diagonal plane
    long[3] = np.round(long[3])
    return fc.Polyhedron(p.reshape(-1, 3), np.arange(3 * n).reshape(n, 3), solid=False)


def mixed_edges() -> fc.Polyhedron:
    """Two triangles, a bare edge and vertices of nothing."""
    rng = np.random.default_rng(9)
    return fc.Polyhedron(rng.uniform(-1, 1, (8, 3)), [[0, 1, 2], [2, 1, 3]], edges=[[4, 5], [0, 1], [5, 6]])


def slabs() -> fc.Polyhedron:
    """A fine strip of triangles and some long slivers beside it, all in two directions: natural axes, and splits."""
    strip = [[[k, 0, 0], [k + 1, 0, 0], [k, 1, 0]] for k in range(200)]
    slivers = [[[-40, 5 + k / 8, 3], [300, 90 + k / 8, 3], [-40, 5.1 + k / 8, 3]] for k in range(6)]
    walls = [[[0, k, 7], [0, k + 1, 7], [0, k, 9]] for k in range(40)]
    triangles = np.array(strip + slivers + walls, float)
    return fc.Polyhedron(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), solid=False)


BODIES = {
    "box": lambda: fc.examples.box((1, 2, 3)),
    "turned slabs": lambda: slabs().rotated((1, 2, 3), degrees=50),
    "one triangle": lambda: fc.Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "sphere": lambda: polyhedron(g.icosphere(2, 1.0, 0.05, 1)),
    "torus": lambda: polyhedron(g.torus(12, 7, 0.1, 2)),
    "needles": lambda: needles(1),
    "more needles": lambda: needles(2, 400),
    "edges": lambda: polyhedron(g.woven(30, 3)[0]),
    "mixed": mixed_edges,
    "points": lambda: fc.Polyhedron(np.random.default_rng(4).uniform(-1, 1, (20, 3)), []),
    "one point": lambda: fc.Polyhedron([[1, 2, 3]], []),
    "coincident": lambda: fc.Polyhedron([[1, 2, 3]] * 12, [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(4)]),
    "polygons": lambda: fc.Polyhedron([[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0]], [[0, 1, 2, 3, 4]]),
    "soup": lambda: fc.Polyhedron(
        np.random.default_rng(6).uniform(-1, 1, (30, 3)),
        np.random.default_rng(7).integers(0, 30, (60, 3)),
        solid=False,
    ),
    "fractions": lambda: fc.Polyhedron(
        [[Fraction(k * k + 1, 3 + j) for j in range(3)] for k in range(9)], [[0, 1, 2], [3, 4, 5], [6, 7, 8]]
    ),
    # translates, whose trees are those of what they are made of
    "needles elsewhere": lambda: needles(3).translated((Fraction(1000, 3), "1/7", -5)),
    "needles far away": lambda: needles(4).translated((2**30, -1, Fraction(1, 3))),
    "turned slabs elsewhere": lambda: slabs().rotated((1, 2, 3), degrees=50).translated(("1/3", 77, 1e-9)),
}
NAMES = pytest.mark.parametrize("name", BODIES)


def parents(tree) -> np.ndarray:
    up = np.full(len(tree.links), -1)
    for node, (left, right) in enumerate(tree.links):
        if right >= 0:
            assert left > node and right > node  # children follow their parent: one backward sweep refits
            assert up[left] == up[right] == -1
            up[left] = up[right] = node
    return up


def leaf_of_part(tree) -> dict[int, int]:
    leaves = {int(left): node for node, (left, right) in enumerate(tree.links) if right < 0}
    assert sorted(leaves) == list(range(len(tree.ids)))
    return leaves


def samples(corners: np.ndarray, rng, n: int) -> list[list[Fraction]]:
    """Exact points of the triangle, its corners and sides included."""
    out = []
    for k in range(n):
        w = [int(x) for x in rng.integers(0, 50, 3)]
        if k < 3:
            w = [int(j == k) for j in range(3)]
        elif k < 9:
            w[k % 3] = 0
        total = sum(w) or 1
        w = w if sum(w) else [1, 0, 0]
        out.append([sum(Fraction(wi, total) * Fraction(c) for wi, c in zip(w, axis, strict=True))
                    for axis in corners.reshape(3, 3).T.tolist()])  # fmt: skip
    return out


def holds(box, point) -> bool:
    return all(Fraction(box[k]) <= x <= Fraction(box[k + 3]) for k, x in enumerate(point))


def test_a_translate_has_the_tree_of_its_origin_by_its_own_coordinates():
    body = needles(5).translated((1, 0, 0))
    moved = body.translated(("1/3", 5, 0))
    one, other = tree_of(body), tree_of(moved)
    assert one.links is other.links and one.ids is other.ids
    assert np.array_equal(other.xyz, moved.vertices[other.corners[other.ids[:, 0]]].reshape(-1, 9))
    whole = (other.ids[:, 1] & SPLIT) == 0
    boxes = other.boxes[[leaf_of_part(other)[p] for p in np.flatnonzero(whole)]]
    points = other.xyz[whole].reshape(-1, 3, 3)
    assert np.array_equal(boxes, np.hstack([points.min(axis=1), points.max(axis=1)]))


@pytest.mark.share(9)
@NAMES
def test_boxes_hold_their_triangles(name):
    tree = tree_of(BODIES[name]())
    up, leaf = parents(tree), leaf_of_part(tree)
    for node in range(1, len(tree.links)):
        box, above = tree.boxes[node], tree.boxes[up[node]]
        assert np.all(above[:3] <= box[:3]) and np.all(box[3:] <= above[3:])
    by_primitive: dict[int, list[int]] = {}
    for part, (primitive, _) in enumerate(tree.ids.tolist()):
        by_primitive.setdefault(primitive, []).append(part)
    assert sorted(by_primitive) == list(range(len(tree.corners)))
    rng = np.random.default_rng(81)
    for parts in by_primitive.values():
        assert (len(parts) == 1) == (not tree.ids[parts[0], 1] & SPLIT) or len(parts) > 1
        for point in samples(tree.xyz[parts[0]], rng, 60 if len(parts) > 1 else 12):
            assert any(holds(tree.boxes[leaf[p]], point) for p in parts), (name, parts)


def owners(tree) -> tuple[Counter, Counter, Counter]:
    """How many parts own each segment (as a side, as a flat side) and each vertex."""
    edges, flat, vertices = Counter(), Counter(), Counter()
    for primitive, mask in tree.ids.tolist():
        for s in range(3):
            if mask & (1 << (SIDE + s)):
                edges[int(tree.sides[primitive, s])] += 1
            if mask & (1 << (FLAT_SIDE + s)):
                flat[int(tree.sides[primitive, s])] += 1
            if mask & (1 << (CORNER + s)):
                vertices[int(tree.corners[primitive, s])] += 1
    return edges, flat, vertices


@NAMES
def test_every_edge_and_vertex_is_owned(name):
    body = BODIES[name]()
    tree = tree_of(body)
    edges, flat, vertices = owners(tree)
    split = bool(np.any(tree.ids[:, 1] & SPLIT))
    used = set(body.segments.ravel().tolist()) | set(body.triangles.ravel().tolist())
    assert set(vertices) == (used or set(range(len(body.vertices))))
    bare_points = {len(body.segments) + v for v in range(len(body.vertices))} if not used else set()
    assert set(edges) | set(flat) == {e for e, (i, j) in enumerate(body.segments) if i != j} | bare_points
    assert not set(edges) & set(flat)
    if not split:
        assert set([*edges.values(), *flat.values(), *vertices.values()]) == {1}


def test_the_diagonals_of_a_box_are_its_flat_sides():
    body = fc.Polyhedron(*(lambda b: (b.v, b.f))(g.box((1, 2, 3))))
    _, flat, _ = owners(tree_of(body))
    lengths = sorted(float(np.sum(np.diff(body.vertices[body.segments[e]], axis=0) ** 2)) for e in flat)
    assert lengths == [5, 5, 10, 10, 13, 13]


@pytest.mark.parametrize("name", ["needles", "more needles"])
def test_split_parts_own_their_edges_where_they_run(name):
    """Every point of an owned side lies in the box of a part that owns it; corners likewise."""
    tree = tree_of(BODIES[name]())
    leaf = leaf_of_part(tree)
    parts_of: dict[int, list[int]] = {}
    for part, (primitive, _) in enumerate(tree.ids.tolist()):
        parts_of.setdefault(primitive, []).append(part)
    long = [p for p, parts in parts_of.items() if len(parts) > 1]
    assert len(long) >= 4
    for primitive in long:
        parts = parts_of[primitive]
        corner = [[Fraction(x) for x in c] for c in tree.xyz[parts[0]].reshape(3, 3).tolist()]
        for s in range(3):
            own = [p for p in parts if tree.ids[p, 1] & ((1 << (SIDE + s)) | (1 << (FLAT_SIDE + s)))]
            p, q = corner[s], corner[(s + 1) % 3]
            for k in range(21):
                point = [x + Fraction(k, 20) * (y - x) for x, y in zip(p, q, strict=True)]
                assert any(holds(tree.boxes[leaf[i]], point) for i in own)
            assert any(tree.ids[i, 1] & (1 << (CORNER + s)) and holds(tree.boxes[leaf[i]], p) for i in parts)


def test_splitting_makes_the_boxes_smaller():
    tree = tree_of(BODIES["needles"]())
    leaf = leaf_of_part(tree)
    split = [p for p in range(len(tree.ids)) if tree.ids[p, 1] & SPLIT]
    assert len(split) > 20
    for part in split:
        corners = tree.xyz[part].reshape(3, 3)
        whole = corners.max(axis=0) - corners.min(axis=0)
        box = tree.boxes[leaf[part]]
        assert np.max(box[3:] - box[:3]) < 0.75 * whole.max()


@pytest.mark.share(10)
@NAMES
@pytest.mark.parametrize("axis", [(1.0, 2.0, 3.0), (-0.3, 1e-9, 0.7), (0.0, 1.0, 0.0)])
def test_refitted_boxes_hold_the_turned_body(name, axis):
    """In an exact frame with the same axis each point lies in a box of its triangle, but for the error."""
    body = BODIES[name]()
    tree, frame = tree_of(body), frame_of(axis)
    view = view_in(body, frame)
    up, leaf = parents(view), leaf_of_part(view)
    for node in range(1, len(view.links)):
        box, above = view.boxes[node], view.boxes[up[node]]
        assert np.all(above[:3] <= box[:3]) and np.all(box[3:] <= above[3:])
    parts_of: dict[int, list[int]] = {}
    for part, (primitive, _) in enumerate(tree.ids.tolist()):
        parts_of.setdefault(primitive, []).append(part)
    rng = np.random.default_rng(82)
    with precision(160):
        rows = [[arb(x) for x in row] for row in frame] if 1.0 in axis[1:2] else exact_frame(axis, frame)
        for parts in list(parts_of.values())[:60]:
            for point in samples(tree.xyz[parts[0]], rng, 30 if len(parts) > 1 else 9):
                x = [arb(p.numerator) / p.denominator for p in point]
                turned = [sum((m * c for m, c in zip(row, x, strict=True)), arb(0)) for row in rows]
                assert any(
                    all(
                        not (t < arb(box[k]) - arb(view.error)) and not (t > arb(box[k + 3]) + arb(view.error))
                        for k, t in enumerate(turned)
                    )
                    for box in (view.boxes[leaf[p]] for p in parts)
                ), (name, axis)


def test_masks_say_what_a_part_is():
    kinds = Counter(int(m) & (FACET | BARE) for m in tree_of(mixed_edges()).ids[:, 1])
    assert kinds == {FACET: 2, BARE: 2}


def test_edges_that_the_user_gave_are_never_flat():
    body = g.box((1, 2, 3))
    diagonals = owners(tree_of(fc.Polyhedron(body.v, body.f)))[1]
    segments = fc.Polyhedron(body.v, body.f).segments
    given = [segments[e].tolist() for e in diagonals]
    edges, flat, _ = owners(tree_of(fc.Polyhedron(body.v, body.f, edges=given[:4])))
    assert len(flat) == 2 and {0, 1, 2, 3} <= set(edges)


def test_turned_bodies_are_built_in_their_own_axes():
    body = BODIES["turned slabs"]()
    assert natural_frame(body)[1] is not None
    assert np.any(tree_of(body).ids[:, 1] & SPLIT)
    tree = tree_of(body)
    assert np.array_equal(tree.xyz, body.vertices[tree.corners[tree.ids[:, 0]]].reshape(-1, 9))
