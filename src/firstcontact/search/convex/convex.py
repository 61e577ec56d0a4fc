"""Composite quadric models as convex pieces in flat arrays, for the kernels; every number with its proved error."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from flint import arb, fmpq, fmpq_mat

from firstcontact.body.kept import Kept
from firstcontact.body.solid.carriers import (
    ONE,
    Conic,
    Plane,
    Quadric,
    QuarticCurve,
    Rows,
    Surface,
    diagonalised,
    dot,
    doubles,
    inertia,
    inverse,
    null_space,
)
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.body.solid.csg import Leaf, Not, Or, Tree, conjunction
from firstcontact.body.solid.extent import hull_of_cells, outward
from firstcontact.body.solid.features import Edge, Face
from firstcontact.body.solid.primitives import box
from firstcontact.exact.numbers import precision, to_double
from firstcontact.kernels.convex.support import BALL, BOWL, BOX, FORMS, SHEET, support

U = 2.0**-53
WIDTH = 14
BITS = 192
# Conjunctions tried before a combination counts as too involved for the fast path.
MOST_PIECES = 64
# Those of a cover: what the others would cut off is left in it.
MOST_COVERING = 8
# Arcs reach this far (radians) beyond their ends: the highest point of the whole conic is then too high by its square.
ARC_SLACK = 1e-8
# Along each axis, in which it is looked where a piece ends.
CELLS = 8
# In which the extreme points of a union are looked at.
DIRECTIONS = [np.array(n) + 0.1 * np.array([n[1], n[2], -n[0]]) for n in product((-1.0, 0.0, 1.0), repeat=3) if any(n)]


Clause = frozenset[tuple[int, bool]]
"""Where the solid lies on the given side of every surface: (number, inside)."""


HalfSpaces = tuple[list[Surface], Sequence[fmpq] | None]
"""Those whose intersection a piece is, and a point inside it."""


class NotConvex(Exception):
    """The model is not a union of bounded convex pieces that the kernels describe; the text says why."""


@dataclass(frozen=True, eq=False)
class ConvexPieces:
    """array: as `kernels.convex.support` tells, `count` pieces.

    labels: (kind, index) of the body's features by surfaces.
    union: the row of all pieces as one, where several make a convex body; else None.
    solids: of each piece its half-spaces, exact and in the order of the rows of its forms, and an interior point.
    """

    array: np.ndarray
    count: int
    labels: dict[frozenset[int], tuple[str, int]]
    union: int | None = None
    solids: tuple[HalfSpaces, ...] = ()
    named: dict[tuple[int, ...], tuple[tuple[str, int], ...]] = field(default_factory=dict)
    """Features by the rows of forms, as asked for so far."""

    @property
    def fewest(self) -> Sequence[int]:
        """The rows of the fewest convex pieces that make up the body."""
        return range(self.count) if self.union is None else (self.union,)

    def inside(self, j: int, x: np.ndarray, slack: float, reach: float = 0.0) -> np.ndarray:
        """(n,) bools: points (n, 3) inside piece j by this part of the size of its forms' terms.

        A negative slack: or outside by less.  reach: added to coordinates for that size, which is 0 at the origin.
        """
        head = self.array[j]
        forms = self.array[int(head[FORMS]) : int(head[FORMS + 1]), :10]
        found: np.ndarray = np.all(_terms(x) @ forms.T < -slack * (_terms(np.abs(x) + reach) @ np.abs(forms).T), axis=1)
        return found


def _terms(x: np.ndarray) -> np.ndarray:
    """(n, 10), in the order of the forms' coefficients."""
    return np.column_stack([x * x, x[:, 0] * x[:, 1], x[:, 0] * x[:, 2], x[:, 1] * x[:, 2], x, np.ones(len(x))])


_CONVEX = Kept[ConvexPieces]()
_COVERING = Kept[ConvexPieces]()


def convex_pieces(body: CompositeQuadric) -> ConvexPieces:
    """The pieces of a body, kept on it.  Raises NotConvex."""
    return _CONVEX.of_or_refusal(body, lambda: _own_pieces(body), NotConvex)


def is_of_pieces(body: CompositeQuadric) -> bool:
    """Whether the body is a union of convex pieces."""
    try:
        return convex_pieces(body).count > 0
    except NotConvex:
        return False


def covering_pieces(body: CompositeQuadric) -> ConvexPieces:
    """Convex pieces that cover the body, kept on it: its own, without what is not convex in them (holes are filled).

    At worst its box, of which no form is a surface of the body (no labels).  Raises NotConvex for a body without end.
    """
    return _COVERING.of_or_refusal(body, lambda: _covering(body), NotConvex)


def _covering(body: CompositeQuadric) -> ConvexPieces:
    for pieces_of in (convex_pieces, _filled_pieces):
        with suppress(NotConvex):
            return pieces_of(body)
    return _boxed(body)


def _boxed(body: CompositeQuadric) -> ConvexPieces:
    if not body.bounded:
        raise NotConvex("not bounded")
    lo, hi = body.bounds()
    wide = (hi - lo) * (1.0 + 2.0**-40) + 2.0**-40 * np.abs([lo, hi]).max()
    return replace(convex_pieces(box(wide.tolist()).translated((0.5 * (lo + hi)).tolist())), labels={})


def _filled_pieces(body: CompositeQuadric) -> ConvexPieces:
    """They may reach beyond the body's box, but not far: NotConvex else."""
    return _of_parts(body, ((clause, _with_room(solid)) for clause, solid in _solids(body, _filled(body))))


def _with_room(part: CompositeQuadric) -> CompositeQuadric:
    """All of a convex piece of which a part in a box is known: it is connected, so what meets no side of a larger box
    ends in that."""
    if part._box is None:
        raise NotConvex("not bounded")
    corners = list(zip(*part._box, strict=True))
    wide = tuple(2 * c - d for c, d in corners), tuple(2 * d - c for c, d in corners)
    (lo, hi), (first, last) = hull_of_cells(part, wide, CELLS), outward(wide)
    if not (np.all(lo > first) and np.all(hi < last)):
        raise NotConvex("not bounded")
    return CompositeQuadric(part.surfaces, part.tree, box=wide, witness=part.inner_point)


def _filled(body: CompositeQuadric) -> list[Clause]:
    """The clauses of the tree that hold points, without their half-spaces that are not convex.

    Raises NotConvex where that leaves all of space.
    """
    filled = {_convex_part(body, clause) for clause in _covering_clauses(body, body.tree, True)}
    if frozenset() in filled:
        raise NotConvex("no convex half-space bounds it")
    return _largest({clause for clause in filled if clause is not None})


def _convex_part(body: CompositeQuadric, clause: Clause) -> Clause | None:
    """The half-spaces of a clause that are convex in its company; None where it holds no point."""
    solid = _solid(body, clause) if clause else body
    return None if solid is None else frozenset(x for x in clause if _bounds_convexly(body, x, clause, solid))


def _covering_clauses(body: CompositeQuadric, tree: Tree, wanted: bool) -> list[Clause]:
    """As `_clauses`, without half-spaces that are not convex in any company, and few: what would make more is left out.

    So a hole with one curved wall is filled at once, however many there are of them.
    """
    if isinstance(tree, Not):
        return _covering_clauses(body, tree.inner, not wanted)
    if isinstance(tree, Leaf):
        leaf = tree.surface, wanted
        return [frozenset([leaf] if _may_be_convex(_half_space(body, leaf)) else [])]
    first, second = (_covering_clauses(body, x, wanted) for x in (tree.first, tree.second))
    if isinstance(tree, Or) == wanted:
        return _largest({*first, *second})
    if len(first) * len(second) > MOST_COVERING:
        return min(first, second, key=lambda clauses: (frozenset() in clauses, len(clauses)))
    joined = {x | y for x, y in product(first, second)}
    return _largest({c for c in joined if not any((s, not side) in c for s, side in c)})


def _largest(clauses: set[Clause]) -> list[Clause]:
    """Those that lie in no other one."""
    return sorted((c for c in clauses if not any(d < c for d in clauses)), key=sorted)


def _own_pieces(body: CompositeQuadric) -> ConvexPieces:
    clauses = _clauses(body.tree, True)
    if len(clauses) > MOST_PIECES:
        raise NotConvex("too many pieces")
    if len(clauses) == 1:
        return _of_parts(body, [(clauses[0], body)])
    return _of_parts(body, _solids(body, clauses))


def _solids(body: CompositeQuadric, clauses: list[Clause]) -> Iterator[tuple[Clause, CompositeQuadric]]:
    """Of the clauses that hold points."""
    for clause in clauses:
        solid = _solid(body, clause)
        if solid is not None:
            yield clause, solid


def _of_parts(body: CompositeQuadric, clauses: Iterable[tuple[Clause, CompositeQuadric]]) -> ConvexPieces:
    """Of the pieces, each also as a solid of its own; their features are derived when all are known to be convex."""
    convex = []
    for clause, solid in clauses:
        forms = [_half_space(body, x) for x in sorted(clause)]
        for form in forms:
            _require_convex(form, forms, solid)
        convex.append((solid, forms, [number for number, _ in sorted(clause)]))
    parts = [_piece(*piece) for piece in convex]
    solids = [(forms, solid.inner_point) for solid, forms, _ in convex]
    pieces = ConvexPieces(_tables(parts), len(parts), _labels(body), solids=tuple(solids))
    is_round = all(len(forms) == 1 for _, _, smooth, forms in parts if smooth)
    if len(parts) > 1 and is_round and all(edge.convexity == "convex" for edge in body.edges):
        together = [[row for part in parts for row in part[k]] for k in range(3)]
        with_union = _tables([*parts, [*together, []]])
        if _seems_convex(body, with_union, len(parts)):
            return replace(pieces, array=with_union, union=len(parts))
    return pieces


def _tables(parts: Sequence[Sequence[Sequence[Sequence[float]]]]) -> np.ndarray:
    """The rows of the pieces first, then those of their parts."""
    rows: list[list[float]] = []
    heads = np.zeros((len(parts), WIDTH))
    for head, tables in zip(heads, parts, strict=True):
        for k, table in enumerate(tables):
            head[2 * k] = len(parts) + len(rows)
            rows += [[*row, *[0.0] * (WIDTH - len(row))] for row in table]
            head[2 * k + 1] = len(parts) + len(rows)
    arrays = np.vstack([heads, np.array(rows, float).reshape(-1, WIDTH)])
    for i in range(len(parts)):
        _fill_box(arrays, i)
    return arrays


def _seems_convex(body: CompositeQuadric, array: np.ndarray, union: int) -> bool:
    """Whether the middles between extreme points lie in the body.

    It is then one connected piece; without reentrant edges that makes it convex (Tietze, Nakajima), but for vertices
    at which it falls apart.  Nothing wrong is proved of a body that only seems convex: what its union is apart from it
    is apart from too, and points are proved to be in single pieces.
    """
    points = np.array([support(array, union, *n)[1:] for n in DIRECTIONS])
    middles = 0.5 * (points[:, None] + points).reshape(-1, 3)
    return bool(np.all(body._possible(middles, 1e-9)[0]))


# -- convex pieces of the tree ------------------------------------------------------------------------------


def _clauses(tree: Tree, wanted: bool) -> list[Clause]:
    """The tree (or its complement) as a union of intersections of (surface, inside) half-spaces."""
    if isinstance(tree, Not):
        return _clauses(tree.inner, not wanted)
    if isinstance(tree, Leaf):
        return [frozenset([(tree.surface, wanted)])]
    first, second = _clauses(tree.first, wanted), _clauses(tree.second, wanted)
    if isinstance(tree, Or) == wanted:
        return first + second
    if len(first) * len(second) > 16 * MOST_PIECES:
        raise NotConvex("too many pieces")
    joined = {x | y for x, y in product(first, second)}
    return _largest({c for c in joined if not any((s, not side) in c for s, side in c)})


def half_spaces(body: CompositeQuadric) -> list[Surface]:
    """Those whose intersection the body is, one convex piece.  Raises NotConvex."""
    clauses = _clauses(body.tree, True)
    if len(clauses) != 1 or convex_pieces(body).count != 1:
        raise NotConvex("several pieces")
    return [_half_space(body, x) for x in sorted(clauses[0])]


def _half_space(body: CompositeQuadric, x: tuple[int, bool]) -> Surface:
    return body.surfaces[x[0]] if x[1] else body.surfaces[x[0]].negated()


def _bounds_convexly(body: CompositeQuadric, x: tuple[int, bool], clause: Clause, solid: CompositeQuadric) -> bool:
    try:
        _require_convex(_half_space(body, x), [_half_space(body, y) for y in clause], solid)
    except NotConvex:
        return False
    return True


def _solid(body: CompositeQuadric, clause: Clause) -> CompositeQuadric | None:
    """What the piece holds of the body's box, as a solid of its own; None where that is nothing."""
    surfaces = [_half_space(body, x) for x in sorted(clause)]
    tree = conjunction([Leaf(k) for k in range(len(surfaces))])
    try:
        return CompositeQuadric(surfaces, tree, box=body._finite_box())
    except NoSolid:
        return None


def _piece(solid: CompositeQuadric, forms: Sequence[Surface], numbers: Sequence[int]) -> list[list[list[float]]]:
    """Rows of vertices, arcs, curved faces and forms of one piece; numbers: those of the forms' surfaces."""
    if not solid.bounded:
        raise NotConvex("not bounded")
    vertices = [[*v.position, 3.0 * v.error + 8 * U * sum(map(abs, v.position))] for v in solid.vertices]
    arcs = [row for edge in (*solid.edges, *solid.seams) for row in _arcs(edge)]
    smooth = [row for face in solid.faces for row in _smooth(face, solid)]
    if not (vertices or arcs or smooth):
        raise NotConvex("no features")
    points = [np.array(row[:3]) for row in (*vertices, *arcs, *smooth)]
    size = max(float(np.abs(row[:12]).max()) for row in (*vertices, *arcs, *smooth)) or 1.0
    leaves = [_leaf(form, number, points, size) for form, number in zip(forms, numbers, strict=True)]
    return [vertices, arcs, smooth, leaves]


def _labels(body: CompositeQuadric) -> dict[frozenset[int], tuple[str, int]]:
    found: dict[frozenset[int], tuple[str, int]] = {}
    for kind, features in (("face", body.faces), ("edge", body.edges), ("vertex", body.vertices)):
        for feature in features:  # type: ignore[attr-defined]
            found.setdefault(frozenset(feature.surfaces), (kind, feature.index))
    return found


def _may_be_convex(form: Surface) -> bool:
    """Whether the half-space is convex in some company."""
    if isinstance(form, Plane):
        return True
    positive, negative = inertia(tuple(row[:3] for row in form.form[:3]))
    return negative == 0 or ((positive, negative) == (2, 1) and inertia(form.form) in ((2, 1), (3, 1)))


def _require_convex(form: Surface, forms: Sequence[Surface], solid: CompositeQuadric) -> None:
    """NotConvex unless the half-space, in the company of the other ones, is convex."""
    if isinstance(form, Plane):
        return
    block = tuple(row[:3] for row in form.form[:3])
    positive, negative = inertia(block)
    if negative == 0:
        return
    # the inside of a cone or of both sheets of a hyperboloid: convex with a plane that leaves one half of it
    if (positive, negative) != (2, 1) or inertia(form.form) not in ((2, 1), (3, 1)):
        raise NotConvex("not convex")
    centre = _centre(form)
    witness = solid.inner_point
    if witness is None or not any(
        isinstance(plane, Plane) and _leaves_one_nappe(plane, block, centre, witness) for plane in forms
    ):
        raise NotConvex("not convex")


def _leaves_one_nappe(plane: Plane, block: Rows, centre: Sequence[fmpq], witness: Sequence[fmpq]) -> bool:
    """Whether the half-space holds no interior point of the nappe beyond the centre, seen from the witness.

    Points c - v of that nappe, v^T A v <= 0, have N(c) - n.v >= 0 when N(c) >= 0 and n is in the polar cone of v.
    """
    n = plane.normal[:3]
    if plane.value((*centre, ONE)) < 0:
        return False
    dual = inverse(block)
    if sum(n[i] * dual[i][j] * n[j] for i in range(3) for j in range(3)) > 0:
        return False
    return dot(n, [w - c for w, c in zip(witness, centre, strict=True)]) < 0


def _centre(form: Quadric) -> list[fmpq]:
    """Where the gradient vanishes, for an invertible second-order part."""
    block = fmpq_mat([list(row[:3]) for row in form.form[:3]])
    return [row[0] for row in block.solve(fmpq_mat([[-row[3]] for row in form.form[:3]])).tolist()]


# -- rows of the tables -------------------------------------------------------------------------------------


def _arcs(edge: Edge) -> list[list[float]]:
    """The arcs of an ellipse; none for lines, whose ends are vertices."""
    if isinstance(edge.carrier, QuarticCurve):
        raise NotConvex("an edge of degree 4")
    if any(math.isinf(x) for piece in edge.pieces for x in (piece.lo, piece.hi)):
        raise NotConvex("not bounded")
    if not isinstance(edge.carrier, Conic) or edge.frame.shape[1] == 2:
        return []
    centre, first, second, error = _ellipse(edge.carrier)
    rows = []
    for piece in edge.pieces:
        half = 0.5 * (piece.hi - piece.lo)
        middle = edge.points([0.5 * (piece.lo + piece.hi)])[0]
        c, s = np.linalg.lstsq(np.column_stack([first, second]), middle - centre, rcond=None)[0]
        length = math.hypot(c, s)
        if not length > 0.0:
            raise NotConvex("an edge too small for doubles")
        cosine = -2.0 if half + ARC_SLACK >= math.pi - 1e-9 else math.cos(half + ARC_SLACK)
        rows.append([*centre, *first, *second, c / length, s / length, cosine, error])
    return rows


def _ellipse(conic: Conic) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Centre, two conjugate half diameters, and the error of the support function per unit of n."""
    (a, b), (_, c) = conic.form[0][:2], conic.form[1][:2]
    if a * c <= b * b:
        raise NotConvex("an edge on a parabola or hyperbola")
    block = fmpq_mat([[a, b], [b, c]])
    (x,), (y,) = block.solve(fmpq_mat([[-row[2]] for row in conic.form[:2]])).tolist()
    depth = -dot(conic.form[2], (x, y, ONE))
    shape = (block.inv() * depth).tolist()  # (y - centre)^T shape^-1 (y - centre) = 1
    weight = conic.basis[3][2]
    with precision(BITS):
        l00 = arb(shape[0][0]).sqrt()
        l10 = arb(shape[1][0]) / l00
        l11 = (arb(shape[1][1]) - l10 * l10).sqrt()
        p = [[arb(entry / weight) for entry in row] for row in conic.basis[:3]]
        exact = [
            [row[0] * arb(x) + row[1] * arb(y) + row[2] for row in p],
            [row[0] * l00 + row[1] * l10 for row in p],
            [row[1] * l11 for row in p],
        ]
        vectors = [np.array([float(v.mid()) for v in vector]) for vector in exact]
    # one rounding of every entry, and eight in the kernel's sums, square root included
    error = 12 * U * sum(float(np.abs(v).sum()) for v in vectors)
    return vectors[0], vectors[1], vectors[2], error


def _smooth(face: Face, solid: CompositeQuadric) -> list[list[float]]:
    """The row of a face on an ellipsoid, on a sheet of a hyperboloid or on an elliptic paraboloid."""
    if isinstance(face.carrier, Plane) or sum(inertia(face.carrier.form)) < 4:
        return []
    form = face.carrier.form
    block = tuple(row[:3] for row in form[:3])
    parts = sorted(diagonalised(block), key=lambda part: -part[0])  # the negative or zero one last
    witness = solid.inner_point
    if witness is None:
        raise NotConvex("no inner point is known")
    squares: list[fmpq]
    if parts[2][0] == 0:
        lo, hi = solid.bounds()
        kind, centre, squares, axes = _bowl(form, parts, float(np.linalg.norm(hi - lo)))
    else:
        centre = _centre(face.carrier)
        k = dot(form[3], (*centre, ONE))  # the form is sum of value c^2, plus k
        kind = BALL if parts[2][0] > 0 else SHEET
        squares = [abs(k / value) for value, _ in parts]
        axes = [vector for _, vector in parts]
        if kind == SHEET:
            side = dot([w - c for w, c in zip(witness, centre, strict=True)], _product(block, axes[2]))
            if side * parts[2][0] < 0:
                axes[2] = tuple(-x for x in axes[2])
    with precision(BITS):
        roots = [arb(s).sqrt() if kind != BOWL or i < 2 else arb(s) for i, s in enumerate(squares)]
        columns = [[float((root * arb(x)).mid()) for x in axis] for root, axis in zip(roots, axes, strict=True)]
    c = [to_double(x) for x in centre]
    error = 24 * U * (sum(map(abs, c)) + sum(abs(x) for column in columns for x in column))
    return [[*c, *(column[i] for i in range(3) for column in columns), kind, error]]


def _product(block: Rows, vector: Sequence[fmpq]) -> list[fmpq]:
    return [dot(row, vector) for row in block]


def _bowl(
    form: Rows, parts: Sequence[tuple[fmpq, Sequence[fmpq]]], size: float
) -> tuple[float, list[fmpq], list[fmpq], list[Sequence[fmpq]]]:
    """Vertex and axes of a paraboloid {vertex + sum L_i u_i: u_2 >= u_0^2 + u_1^2}.

    In the axes v0, v1 (conjugate) and z (the kernel) the form is d0 c0^2 + d1 c1^2 + 2 beta c2.  L_2 is about `size`
    long, so that no point of the piece has large u.
    """
    (d0, v0), (d1, v1), _ = parts
    (z,) = null_space(tuple(row[:3] for row in form[:3]))
    b = [row[3] for row in form[:3]]
    beta = dot(b, z)
    foot = [-dot(v0, b) / d0 * x - dot(v1, b) / d1 * y for x, y in zip(v0, v1, strict=True)]
    value = dot((*foot, ONE), [dot(row, (*foot, ONE)) for row in form])
    centre = [f - value / (2 * beta) * x for f, x in zip(foot, z, strict=True)]
    sign = -1 if beta > 0 else 1
    far = max(abs(x) for x in z) / abs(2 * beta)
    scale = far / fmpq(*size.as_integer_ratio())
    squares = [1 / d0 / scale, 1 / d1 / scale, 1 / abs(2 * beta) / scale]
    return BOWL, centre, squares, [v0, v1, tuple(sign * x for x in z)]


def _leaf(form: Surface, number: int, points: Sequence[np.ndarray], size: float) -> list[float]:
    """Coefficients of the form, scaled to gradients of about 1 on the piece."""
    m = np.array(doubles(form.matrix()))
    if isinstance(form, Plane):
        gradients = [np.linalg.norm(2 * m[:3, 3])]
    else:
        probes = [*points, *(p + size * d for p in points for d in (*np.eye(3), *-np.eye(3)))]
        gradients = [np.linalg.norm(2 * (m[:3, :3] @ p + m[:3, 3])) for p in probes]
    m = m / (float(np.median(gradients)) or float(max(gradients)))
    x, y, z, w = range(4)
    return [
        m[x, x], m[y, y], m[z, z], 2 * m[x, y], 2 * m[x, z], 2 * m[y, z],
        2 * m[x, w], 2 * m[y, w], 2 * m[z, w], m[w, w], float(number),
    ]  # fmt: skip


def _fill_box(array: np.ndarray, i: int) -> None:
    """The box from the support function along the axes; a big one first, since that reads the piece's size."""
    bounds = (int(array[i, k]) for k in range(6))
    parts = [array[lo:hi, :n] for (lo, hi), n in zip(zip(bounds, bounds, strict=True), (3, 9, 12), strict=True)]
    array[i, BOX + 3 :] = max(float(np.abs(p).max()) for p in parts if p.size)
    lo, hi = np.empty(3), np.empty(3)
    for k, axis in enumerate(np.eye(3)):
        hi[k] = support(array, i, *axis)[0]
        lo[k] = -support(array, i, *-axis)[0]
    if not np.all(np.isfinite(hi - lo)):
        raise NotConvex("not bounded")
    middle = 0.5 * (lo + hi)
    array[i, BOX:] = *middle, *(np.maximum(hi - middle, middle - lo) * (1 + 1e-15) + 1e-300)
