"""Polyhedra: closed solids, open surfaces, bare edge sets and bare point sets."""

from __future__ import annotations

import warnings
from collections.abc import Hashable, Iterable, Sequence
from fractions import Fraction
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body import told
from firstcontact.body.kept import Kept
from firstcontact.body.placing import Placing
from firstcontact.body.polyhedron.triangulate import shapes, triangulate
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import exact_value, fraction, rational, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix, apply, compose, is_shift
from firstcontact.exact.vectors import cross, dot, sub
from firstcontact.interrupts import interrupted_after
from firstcontact.motion.value import numbers

if TYPE_CHECKING:
    import trimesh

    from firstcontact.exact.numbers import Given
    from firstcontact.exact.ring import VectorOf
    from firstcontact.motion.placement import Placement
    from firstcontact.result import Table

_BOX = Kept[tuple[np.ndarray, np.ndarray]]()

# Largest coordinate: error bounds multiply three of them and a time, far from overflow.
LARGEST = 2.0**150
# Triangles that tell most meshes to be in no plane; and how thick these are, of their coordinates, where doubles tell.
FEW, FLATTEST = 64, 1e-9
# Beyond what products and sums lose below the range of doubles.
LEAST = 2.0**-1060


class Polyhedron(Placing):
    """A polyhedral body at rest: closed vertices, edges and faces; immutable.

    vertices: (n, 3) numbers, world frame.  Doubles are taken as the exact binary rationals they are;
        Fractions and strings ("1/3") stay exact.
    faces: (m, 3) indices, or a list of polygons (planar, also non-convex; a polygon with holes is a list of
        rings, the outer one first).  ``[]`` with ``edges`` is a bare edge set, without edges a point set.
    edges: (k, 2) indices that come first in the numbering, missing face edges are appended; by default the
        sorted unique pairs i < j of face sides.
    solid: whether the body owns its interior; by default when every edge borders an even number of faces,
        unless all lie in one plane, or every face is listed an even number of times (a warning: nothing lies inside).

    Raises InputError naming the vertex, face or edge.

    >>> tetrahedron = Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    ...                          [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> tetrahedron.solid, len(tetrahedron.edges)
    (True, 6)
    """

    kind = "Polyhedron"

    def __init__(
        self,
        vertices: Iterable[Iterable[Given]],
        faces: np.ndarray | Sequence[Sequence[int] | Sequence[Sequence[int]]],
        *,
        edges: Iterable[Iterable[int]] | None = None,
        solid: bool | None = None,
        name: str | None = None,
    ) -> None:
        self.name = name
        who = name or "polyhedron"
        self.base, self.fractions = _read_vertices(vertices, who)
        self.matrix: Matrix = IDENTITY
        self.irrational_pose: Any = None
        self.vertices = self.base
        self.error = _rounding_error(self.fractions, self.base)
        """Bound on |true coordinate - vertices[i, k]|; 0 when the doubles are exact."""
        _read_faces(self, faces, who)
        _derive(self, _read_edges(edges, len(self.vertices), who), solid, who)

    # -- making ---------------------------------------------------------------------------------------------

    @classmethod
    def load(cls, path: str | Path, solid: bool | None = None, name: str | None = None) -> Polyhedron:
        """The mesh in a file (STL, OBJ, PLY, OFF, glTF); coordinates untouched, polygons as the class takes them.

        Vertices with equal coordinates are welded, nothing else is merged.  `name` defaults to the file's.
        """
        from firstcontact.io.meshes import read_mesh

        vertices, faces = read_mesh(path)
        return cls(vertices, faces, solid=solid, name=str(path)).named(name or Path(path).stem)  # errors name the file

    @classmethod
    def from_trimesh(cls, mesh: Any, solid: bool | None = None, name: str | None = None) -> Polyhedron:
        if not (hasattr(mesh, "vertices") and hasattr(mesh, "faces")):
            raise InputError(f"{name or 'from_trimesh'}: {mesh!r} is no mesh; give a trimesh.Trimesh")
        return cls(np.asarray(mesh.vertices), np.asarray(mesh.faces), solid=solid, name=name)

    def to_trimesh(self) -> trimesh.Trimesh:
        with interrupted_after():
            import trimesh

        return trimesh.Trimesh(self.vertices, self.triangles, process=False)

    # -- looking --------------------------------------------------------------------------------------------

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the body."""
        lo, hi = _BOX.of(
            self, lambda: (self.vertices.min(axis=0) - self.error, self.vertices.max(axis=0) + self.error)
        )
        return lo.copy(), hi.copy()

    def exact_vertex(self, i: int) -> VectorOf[fmpq]:
        """The true coordinates of vertex i: fmpq, or balls in an irrational pose."""
        if self.fractions is not None:
            x, y, z = (rational(c, "vertex") for c in self.fractions[i])
        else:
            x, y, z = self.base[i].tolist()
            x, y, z = fmpq(*x.as_integer_ratio()), fmpq(*y.as_integer_ratio()), fmpq(*z.as_integer_ratio())
            if self.matrix is IDENTITY and self.irrational_pose is None:
                return x, y, z
        if self.irrational_pose is not None:
            x, y, z = apply(self.irrational_pose.matrix(), apply(self.matrix, (x, y, z)))
            return x, y, z
        return (x, y, z) if self.matrix is IDENTITY else apply(self.matrix, (x, y, z))

    @property
    def closed(self) -> bool:
        """Whether every edge borders an even number of faces."""
        return self._closed

    def told(self) -> list[str]:
        return told.polyhedron(self)

    def __repr__(self) -> str:
        kind = "solid" if self.solid else "surface" if len(self.triangles) else "edge set"
        name = f" {self.name!r}" if self.name else ""
        return (
            f"<Polyhedron{name}: {kind}, {len(self.vertices)} vertices, "
            f"{len(self.edges)} edges, {self.n_faces} faces>"
        )

    def _facts(self) -> tuple[Hashable, ...]:
        if self._rings is None:
            faces: tuple[bytes, ...] = (self.triangles.tobytes(),)
        else:  # whatever triangles they were cut into
            faces = *(x.tobytes() for x in self._rings), np.asarray(self._sides).tobytes()
        return self.solid, self._places(), faces, self.edges.tobytes()

    def _places(self) -> Hashable:
        """The exact coordinates of the vertices, hashable: as doubles where all are, however the body came to be."""
        if self.irrational_pose is not None:
            return self.irrational_pose, self.matrix, self.base.tobytes(), repr(self.fractions)
        if self.error != 0.0:
            exact = tuple(self.exact_vertex(i) for i in range(len(self.vertices)))
            if any(exact_value(x) != c for p, q in zip(self.vertices.tolist(), exact, strict=True)
                   for x, c in zip(p, q, strict=True)):  # fmt: skip
                return exact
        return (self.vertices + 0.0).tobytes()  # without -0.0

    def _table(self) -> Table:
        if self.irrational_pose is not None:
            raise InputError(f"{self!r} stands in an irrational pose, which no numbers tell; write it before it moves")
        edges, places = self.segments[: self.given_edges].tolist(), self._places()
        return {
            "shape": "polyhedron",
            "vertices": self.vertices.tolist() if isinstance(places, bytes) else numbers(places),
            "faces": self.triangles.tolist() if self._rings is None else _polygons(self._rings, self._sides),
            **({"edges": edges} if edges else {}),
            "solid": self.solid,
        }

    # -- inside ---------------------------------------------------------------------------------------------

    def bare_edges(self) -> np.ndarray:
        """Numbers of the segments that are on no triangle."""
        bare = np.ones(len(self.segments), bool)
        bare[self.side_edge[self.side_edge >= 0]] = False
        return np.flatnonzero(bare)

    def _with(self, **changes: object) -> Polyhedron:
        """A copy with some attributes replaced; search structures are shared when geometry is."""
        other = object.__new__(Polyhedron)
        other.__dict__.update(self.__dict__)
        other.__dict__.update(changes)
        return other

    def _mapped(self, matrix: Matrix) -> Polyhedron:
        total = compose(matrix, self.matrix)
        m = np.array([[to_double(x) for x in row] for row in total])
        vertices = self.base @ m[:, :3].T + m[:, 3]
        if not np.all(np.abs(vertices) < LARGEST):
            raise InputError(f"{self.name or 'polyhedron'}: coordinates leave the range 2^150 under this map")
        error = 0.0
        if not _is_exact_map(m, total, self.base, vertices) or self.fractions is not None:
            size = np.abs(self.base).max(axis=0, initial=0.0) @ np.abs(m[:, :3]).T + np.abs(m[:, 3])
            # entries, products and sums round: at most 8 roundings each of relative size 2^-53
            base_error = _rounding_error(self.fractions, self.base)
            error = float(size.max() * 8 * 2.0**-53 + 3 * base_error * np.abs(m[:, :3]).max() * 1.01 + LEAST)
        vertices.flags.writeable = False
        translate_of = self.translate_of or self if is_shift(matrix) else None
        mapped = self._with(vertices=vertices, error=error, matrix=total, translate_of=translate_of, _search={})
        if error == 0.0:
            mapped.base, mapped.matrix = vertices, IDENTITY
        return mapped

    def _placed(self, pose: Placement, doubles: list[list[float]]) -> Polyhedron:
        """The body in an irrational pose: vertices rounded, `error` carries the rounding."""
        m = np.array(doubles)
        vertices = self.vertices @ m[:, :3].T + m[:, 3]
        size = np.abs(self.vertices).max(axis=0) @ np.abs(m[:, :3]).T + np.abs(m[:, 3])
        # an entry, a product and three sums round: at most 8 roundings of relative size 2^-53
        error = float(size.max() * 8 * 2.0**-53 + 3 * self.error * np.abs(m[:, :3]).max() * 1.01 + LEAST)
        vertices.flags.writeable = False
        return self._with(vertices=vertices, error=error, irrational_pose=pose, translate_of=None, _search={})

    def __getstate__(self) -> dict[str, object]:
        state = dict(self.__dict__)
        state["_search"], state["translate_of"] = {}, None
        state["matrix"] = tuple(tuple(fraction(x) for x in row) for row in self.matrix)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        matrix = tuple(tuple(rational(x, "matrix") for x in row) for row in state["matrix"])
        self.matrix = IDENTITY if matrix == IDENTITY else matrix  # type: ignore[assignment]

    n_faces: int
    triangles: np.ndarray
    triangle_face: np.ndarray
    edges: np.ndarray
    solid: bool
    _closed: bool
    _sides: np.ndarray | None
    _rings: tuple[np.ndarray, np.ndarray] | None
    """Of polygons: how many rings each has, and how many sides each ring; `_sides` lists these in order."""
    side_edge: np.ndarray
    segments: np.ndarray
    given_edges: int
    translate_of: Polyhedron | None = None
    """One that differs by a translation, and is no such copy itself: trees of both are alike."""
    _search: dict[Any, Any]


def _read_vertices(
    vertices: Iterable[Iterable[Given]], who: str
) -> tuple[np.ndarray, list[tuple[Fraction, ...]] | None]:
    """The coordinates as doubles, and exactly where a double does not hold them."""
    if isinstance(vertices, np.ndarray) and vertices.dtype.kind == "f" and vertices.dtype.itemsize <= 8:
        _check_shape(vertices.shape, who)
        floats, exact = np.array(vertices, np.float64, order="C"), None
    else:
        rows = [tuple(row) if np.iterable(row) else (row,) for row in vertices] if np.iterable(vertices) else []
        widths = {len(row) for row in rows} - {3}
        _check_shape((len(rows), widths.pop() if widths else 3), who)
        if all(type(x) is float for row in rows for x in row):
            floats, exact = np.array(rows), None
        else:
            floats, exact = _read_exact(rows, who)
    bad = ~(np.abs(floats) < LARGEST)
    if bad.any():
        i, k = np.argwhere(bad)[0]
        raise InputError(f"{who}: vertex {i}, coordinate {k} is {floats[i, k]}; give finite coordinates below 2^150")
    floats.flags.writeable = False
    return floats, exact


def _check_shape(shape: tuple[int, ...], who: str) -> None:
    if shape and shape[0] == 0:
        raise InputError(f"{who}: no vertices; give an (n, 3) array")
    if len(shape) != 2 or shape[1] != 3:
        raise InputError(f"{who}: vertices have shape {shape}; give an (n, 3) array")


def _read_exact(rows: Sequence[Iterable[Given]], who: str) -> tuple[np.ndarray, list[tuple[Fraction, ...]] | None]:
    """Doubles of numbers of any kind, each taken for what it is, and the numbers where doubles do not hold them."""
    exact = [
        tuple(fraction(rational(x, f"{who}: vertex {i}, coordinate {k}")) for k, x in enumerate(row))
        for i, row in enumerate(rows)
    ]
    floats = np.array([[_double(x) for x in row] for row in exact])
    pairs = zip(floats.ravel().tolist(), (x for row in exact for x in row), strict=True)
    held = all(abs(f) < LARGEST and Fraction(f) == x for f, x in pairs)
    return floats, None if held else exact


def _double(x: Fraction) -> float:
    try:
        return float(x)
    except OverflowError:
        return float("inf")


def _rounding_error(exact: list[tuple[Fraction, ...]] | None, floats: np.ndarray) -> float:
    return 0.0 if exact is None else float(np.abs(floats).max()) * 2.0**-53 + LEAST


def _read_faces(
    body: Polyhedron, faces: np.ndarray | Sequence[Sequence[int] | Sequence[Sequence[int]]], who: str
) -> None:
    """Set triangles (m, 3), triangle_face (m,), n_faces and the polygon sides `_sides` (None: triangles)."""
    n = len(body.vertices)
    if not hasattr(faces, "__len__"):
        raise InputError(f"{who}: faces is {faces!r}; give index triples, polygons or []")
    array: Any = faces if isinstance(faces, np.ndarray) else None
    if array is None and all(_is_triangle(face) for face in faces):
        array = np.array(faces).reshape(-1, 3) if len(faces) else np.empty((0, 3), np.int32)
    if array is not None and array.ndim == 2 and array.shape[1] == 3:
        if array.dtype.kind not in "iu":
            raise InputError(f"{who}: faces hold {array.dtype} values; give integer vertex indices")
        _check_indices(array, n, who, "face")
        body.triangles = np.ascontiguousarray(array, np.int32)
        body.triangle_face = np.arange(len(array), dtype=np.int32)
        body.n_faces = len(array)
        body._sides = body._rings = None
    else:
        triangles: list[tuple[int, int, int]] = []
        owner: list[int] = []
        sides: list[tuple[int, int]] = []
        polygons = [_rings(face, n, f"{who}: face {f}") for f, face in enumerate(faces)]
        fans = _fans(body.vertices, polygons)
        for f, rings in enumerate(polygons):
            if f in fans:
                new = [(rings[0][0], b, c) for b, c in zip(rings[0][1:], rings[0][2:], strict=False)]
            else:
                new = triangulate(body.vertices, rings, f"{who}: face {f}")
            triangles += new
            owner += [f] * len(new)
            sides += [side for ring in rings for side in zip(ring, ring[1:] + ring[:1], strict=True)]
        body.triangles = np.array(triangles, np.int32).reshape(-1, 3)
        body.triangle_face = np.array(owner, np.int32)
        body.n_faces = len(faces)
        body._sides = np.array(sides, np.int32).reshape(-1, 2)
        sizes = [len(ring) for rings in polygons for ring in rings]
        body._rings = np.array([len(rings) for rings in polygons], np.int32), np.array(sizes, np.int32)
    body.triangles.flags.writeable = False


def _polygons(rings: tuple[np.ndarray, np.ndarray], sides: Any) -> list[list[int] | list[list[int]]]:
    """The faces as they were given: a ring of vertices, or a list of rings where there are holes."""
    counts, sizes = rings
    parts = [ring.tolist() for ring in np.split(sides[:, 0], np.cumsum(sizes)[:-1])] if len(sizes) else []
    ends = np.cumsum(counts).tolist()
    faces = [parts[end - count : end] for count, end in zip(counts.tolist(), ends, strict=True)]
    return [face[0] if len(face) == 1 else face for face in faces]


def _fans(vertices: np.ndarray, polygons: list[list[list[int]]]) -> set[int]:
    """The polygons that are proved convex, by number: those need no care to be cut."""
    numbers: dict[int, list[int]] = {}
    for f, rings in enumerate(polygons):
        if len(rings) == 1 and len(rings[0]) > 3:
            numbers.setdefault(len(rings[0]), []).append(f)
    return {
        int(f)
        for alike in numbers.values()
        for f in np.array(alike)[shapes(vertices, np.array([polygons[f][0] for f in alike]))[1]]
    }


def _is_triangle(face: Sequence[int] | Sequence[Sequence[int]]) -> bool:
    try:
        return len(face) == 3 and all(np.ndim(i) == 0 for i in face)
    except TypeError:
        return False


def _rings(face: Any, n: int, who: str) -> list[list[int]]:
    """The rings of a polygon given flat or as [outer, hole, ...]."""
    try:
        nested = len(face) > 0 and np.ndim(face[0]) == 1
        rings = [[index(i) for i in ring] for ring in face] if nested else [[index(i) for i in face]]
    except (TypeError, ValueError) as error:
        raise InputError(f"{who} is {face!r}; give vertex indices or a list of rings") from error
    for ring in rings:
        if len(ring) < 3:
            raise InputError(f"{who} has a ring of {len(ring)} vertices; give at least three")
        for i in ring:
            if not 0 <= i < n:
                raise InputError(f"{who} names vertex {i}, but there are {n} vertices")
    return rings


def _read_edges(edges: Iterable[Iterable[int]] | None, n: int, who: str) -> np.ndarray | None:
    if edges is None:
        return None
    try:
        array = np.asarray(edges)
    except (ValueError, OverflowError) as error:  # rows of different lengths
        raise InputError(f"{who}: edges are {shown(edges)}; give pairs of vertex indices") from error
    if array.size == 0:
        return np.empty((0, 2), np.int32)
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise InputError(f"{who}: edges have shape {array.shape}; give a (k, 2) array of vertex indices")
    _check_indices(array, n, who, "edge")
    return np.ascontiguousarray(array, np.int32)


def _check_indices(array: np.ndarray, n: int, who: str, what: str) -> None:
    if array.size and (int(array.min()) < 0 or int(array.max()) >= n):
        row = int(np.argwhere((array < 0) | (array >= n))[0][0])
        raise InputError(f"{who}: {what} {row} is {array[row].tolist()}, but there are {n} vertices")


def _derive(body: Polyhedron, given: np.ndarray | None, solid: bool | None, who: str) -> None:
    """Edges, their numbering, closedness; everything that follows from the faces.

    `segments` (k, 2) lists all edges that take part in contacts: `edges` and behind them the diagonals of
    polygons; `_side_edge` (m, 3) is the segment along each triangle side (-1: no side).
    """
    from firstcontact.body.polyhedron.topology import derive_edges

    n = len(body.vertices)
    if len(body.triangles):
        segments, side_edge, count, _ = derive_edges(body.triangles, n)
    else:
        segments, side_edge = np.empty((0, 2), np.int32), np.empty((0, 3), np.int32)
        count = np.empty(0, np.int32)
    body._closed = bool(len(count)) and not np.any(count & 1)
    n_edges = len(segments)
    if given is not None or body._sides is not None:
        segments, n_edges, side_edge = _renumber(body, segments, side_edge, given, n)
    body.given_edges = 0 if given is None else len(given)
    body.segments = segments
    body.side_edge = side_edge
    body.edges = segments[:n_edges]
    body.edges.flags.writeable = False
    if solid and not body._closed:
        where = ""
        odd = np.flatnonzero(count & 1)
        if odd.size:
            where = f" (first open edge: vertices {derive_edges(body.triangles, n)[0][odd[0]].tolist()})"
        raise InputError(f"{who}: solid=True, but the mesh is open{where}; close it or pass solid=False")
    cancelled = body._closed and _cancels(body.triangles)
    if cancelled:
        text = f"{who}: every face is listed an even number of times, so by parity nothing lies inside"
        if solid:
            raise InputError(f"{text}, but solid=True; list each face once")
        warnings.warn(f"{text}: it is taken as a surface; list each face once", stacklevel=4)
    # what lies in one plane is a solid where that is asked for
    body.solid = body._closed and not cancelled and not _is_flat(body) if solid is None else bool(solid)
    body._search = {}


def _is_flat(body: Polyhedron) -> bool:
    """Whether all triangles lie in one plane, or on a line: by the doubles of a few, then of all, then exactly."""
    for triangles in (body.triangles[:FEW], body.triangles):
        used = np.unique(triangles)
        if _has_depth(body.vertices[used]):
            return False
    origin, *points = map(body.exact_vertex, used.tolist())
    ways = [sub(p, origin) for p in points]
    first = next((w for w in ways if any(w)), None)
    normal = None if first is None else next((n for w in ways if any(n := cross(first, w))), None)
    return normal is None or all(dot(normal, w) == 0 for w in ways)


def _has_depth(places: np.ndarray) -> bool:
    """Whether doubles tell that points are in no plane."""
    scaled = places / (float(np.abs(places).max()) or 1.0)
    return len(places) > 3 and bool(np.linalg.svd(scaled - scaled[0], compute_uv=False)[-1] > FLATTEST)


def _cancels(triangles: np.ndarray) -> bool:
    """Whether every triangle, whichever way round, is there an even number of times."""
    if len(triangles) % 2:
        return False
    corners = np.sort(triangles, axis=1)
    ordered = corners[np.lexsort(corners.T)]
    return bool(np.all(ordered[::2] == ordered[1::2]))


def _renumber(
    body: Polyhedron, segments: np.ndarray, side_edge: np.ndarray, given: np.ndarray | None, n: int
) -> tuple[np.ndarray, int, np.ndarray]:
    """Number the segments: given edges, then missing polygon sides (sorted), then polygon diagonals."""
    key = segments[:, 0].astype(np.int64) * n + segments[:, 1]  # sorted, by construction
    if body._sides is None:
        is_side = np.ones(len(segments), bool)
    else:
        ends = np.sort(body._sides, axis=1).astype(np.int64)
        is_side = np.isin(key, ends[:, 0] * n + ends[:, 1])
    first = np.empty((0, 2), np.int32) if given is None else given
    number = np.full(len(segments), -1, np.int64)
    if len(first):
        ends = np.sort(first, axis=1).astype(np.int64)
        given_key = ends[:, 0] * n + ends[:, 1]
        place = np.searchsorted(key, given_key)
        known = place < len(key)
        known[known] = key[place[known]] == given_key[known]
        for row in np.flatnonzero(known)[::-1]:
            number[place[row]] = row
    new_sides = np.flatnonzero((number < 0) & is_side)
    number[new_sides] = len(first) + np.arange(len(new_sides))
    diagonals = np.flatnonzero(number < 0)
    n_edges = len(first) + len(new_sides)
    number[diagonals] = n_edges + np.arange(len(diagonals))
    renumbered = np.where(side_edge >= 0, number[np.maximum(side_edge, 0)] if len(number) else -1, -1)
    return (
        np.concatenate([first, segments[new_sides], segments[diagonals]]),
        n_edges,
        renumbered.astype(np.int32),
    )


def _is_exact_map(m: np.ndarray, total: Matrix, before: np.ndarray, after: np.ndarray) -> bool:
    """Whether `after` is the exact image: signed permutation times powers of two, plus exact sums."""
    linear = m[:, :3]
    if np.any((linear != 0).sum(axis=1) != 1) or np.any(np.abs(np.frexp(linear[linear != 0])[0]) != 0.5):
        return False
    if any(fmpq(*to_double(x).as_integer_ratio()) != x for row in total for x in row):
        return False
    moved, rows = before @ linear.T, np.arange(3)
    used = (linear != 0).argmax(axis=1)
    if np.any(moved / linear[rows, used] != before[:, used]):  # below the range of doubles
        return False
    b = after - moved  # two_sum: the rounding of moved + shift, zero where the sum is exact
    return bool(np.all((moved - (after - b)) + (m[:, 3] - b) == 0))
