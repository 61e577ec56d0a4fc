"""Composite quadric models: solids bounded by planes and quadrics, combined by Boolean operations."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body import told
from firstcontact.body.kept import Kept
from firstcontact.body.placing import Placing
from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Box,
    Plane,
    Quadric,
    Rows,
    Surface,
    Vector,
    doubles,
    inverse,
    upright,
)
from firstcontact.body.solid.csg import (
    And,
    Leaf,
    Not,
    Or,
    Tree,
    inside,
    outcomes,
    pattern,
    possible,
    renumbered,
    surfaces_of,
)
from firstcontact.body.solid.feature_names import LabelledPart, Names
from firstcontact.body.solid.features import Edge, Face, Features, NotDerived, Vertex, derive
from firstcontact.body.solid.neighbourhood import patterns
from firstcontact.body.solid.recipe import Recipe, combined
from firstcontact.body.solid.regions import Regions, SurfaceReach, grows_with_leaves, reaches_of, simplified
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import Undecidable, exact_value, to_double
from firstcontact.exact.rigid import Matrix, apply, is_shift, shift
from firstcontact.motion.translation import LARGEST, vector3

if TYPE_CHECKING:

    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.exact.ring import VectorOf
    from firstcontact.result import Table

FEW = 16
"""Surfaces of operands that are looked at in cells for a close box."""
SINGULAR = 2.0**-40
"""Part of the size of its terms below which a gradient counts as 0."""


class NoSolid(InputError):
    """A combination without interior points, or one of all of space."""

_REGIONS = Kept[Regions]()

# Least length of a solid: squares of coefficients of its surfaces, one over squares of lengths, are still doubles.
LEAST = 1 / LARGEST


class CompositeQuadric(Placing):
    """A solid of planes and quadrics at rest, closed and regularised (no dangling faces); immutable.

    Made by the builders (`fc.box`, `fc.cylinder`, ...) and combined with ``|`` (union), ``&`` (intersection) and
    ``-`` (difference).  All numbers are exact: doubles are the binary rationals they are, "1/3" and Fraction stay
    exact.  Raises InputError when the combination holds no interior point, or all of space.

    >>> from firstcontact.body.solid.primitives import box, cylinder
    >>> plate = (box((4, 4, 1)) - cylinder(1, 2).named("hole")).named("plate")
    >>> plate
    <CompositeQuadric 'plate': 7 faces, 14 edges, 8 vertices>
    >>> plate.faces[6].name, plate.contains([(0, 0, 0), (1, 0, 0)]).tolist()
    ('plate.hole.side', [False, True])
    """

    kind = "CompositeQuadric"
    regular = True
    """Whether it is the closure of its inner points."""

    def __init__(
        self,
        surfaces: Sequence[Surface],
        tree: Tree,
        parts: Sequence[LabelledPart] = (),
        *,
        box: Box | None = None,
        reaches: Sequence[SurfaceReach] | None = None,
        witness: Vector | None = None,
        name: str | None = None,
        forms: np.ndarray | None = None,
    ) -> None:
        """surfaces: different ones; tree: leaf i is where surface i's form is <= 0; forms: theirs, if known.

        box: exact corners of a box that holds the solid, if known.  reaches: where the surfaces may bound it.
        witness: a point likely in the interior.
        """
        self.name = name
        self.surfaces = tuple(surfaces)
        """The complete surfaces, as `Plane` and `Quadric`; features refer to them by number."""
        self.tree = tree
        self.parts = tuple(parts)
        self._box = box
        self._reaches = tuple(reaches) if reaches is not None else reaches_of(tree, len(self.surfaces), box)
        self.forms = np.array([doubles(s.matrix()) for s in self.surfaces]) if forms is None else forms
        self._witness = witness
        self._search: dict[Any, Any] = {}
        """What was worked out of this body: it follows from its geometry and its name, so no copy inherits it."""
        self.whole: CompositeQuadric | None = None
        """The unbounded model of which this one is the part that matters, if it is."""
        self.source: Any = None
        """The polyhedron this model stands for, if it does."""
        self.recipe: Recipe | None = None
        """How it was made, where that is known: not of the models that searches make."""
        self.translate_of: tuple[CompositeQuadric, Vector] | None = None
        """A model of the same names that is this one but for a translation, and that, where there is one."""
        self._validate()

    # -- features -------------------------------------------------------------------------------------------

    @property
    def faces(self) -> tuple[Face, ...]:
        return self._features().faces

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The sharp edges, convex and reentrant."""
        return self._features().edges

    @property
    def seams(self) -> tuple[Edge, ...]:
        """Curves where two faces meet smoothly."""
        return self._features().seams

    @property
    def vertices(self) -> tuple[Vertex, ...]:
        """End points and crossings of edges, and tips of cones."""
        return self._features().vertices

    def know(self, features: Features) -> None:
        """What a builder has worked out already is not derived again."""
        self._search["features"] = features

    def _features(self) -> Features:
        known: Features | None = self._search.get("features")
        if known is None:
            known = self._search["features"] = self._of_origin() or self._derived()
        return known

    def _derived(self) -> Features:
        names = Names(self.name, self.parts, self.surfaces)
        try:
            return derive(self.tree, self.surfaces, names, self._rough_box, self._reaches)
        except Undecidable as reason:
            raise NotDerived(f"{self._who}: its edges come too close to each other to be told apart") from reason

    def _of_origin(self) -> Features | None:
        """Those of the model that this one is a translate of, which are worked out once for all of these."""
        if self.translate_of is None:
            return None
        from firstcontact.body.solid.translates import translated

        origin, (x, y, z) = self.translate_of
        matrix = (*shift((x, y, z)), (ZERO, ZERO, ZERO, ONE))
        return translated(origin._features(), (x, y, z), matrix, self.surfaces)

    def near(self, box: Box) -> CompositeQuadric | None:
        """What is the same set as this one in the box, of the surfaces alone that pass there; None where none do."""
        lo, hi = (np.array([to_double(x) for x in corner]) for corner in box)
        tree = self._tree_in(lo, hi)
        if isinstance(tree, bool):
            return None
        kept = sorted(surfaces_of(tree))
        leaves: list[Tree] = [Leaf(kept.index(k)) if k in kept else Leaf(-1) for k in range(len(self.surfaces))]
        return self._with(
            surfaces=tuple(self.surfaces[k] for k in kept), tree=renumbered(tree, leaves), forms=self.forms[kept],
            parts=(), _box=None, _reaches=tuple(self._reaches[k] for k in kept), recipe=None,
        )  # fmt: skip

    def passing(self, lo: np.ndarray, hi: np.ndarray) -> list[Surface]:
        """The surfaces that tell what is in the solid, of all points in a box."""
        tree = self._tree_in(lo, hi)
        return [] if isinstance(tree, bool) else [self.surfaces[k] for k in surfaces_of(tree)]

    def _tree_in(self, lo: np.ndarray, hi: np.ndarray) -> Tree | bool:
        """The tree without what is known of all points in a box."""
        regions = _REGIONS.of(self, lambda: Regions(self.surfaces, self._reaches))
        return simplified(self.tree, regions.signs((lo, hi)))

    def united(self) -> list[CompositeQuadric]:
        """The solids whose union this is, as it was put together; this one alone where it is none."""
        waiting, found = [self.tree], []
        while waiting:
            tree = waiting.pop()
            if isinstance(tree, Or):
                waiting += [tree.second, tree.first]
            else:
                found.append(tree)
        return [self] if len(found) == 1 else [self._of(tree) for tree in found]

    def _of(self, tree: Tree) -> CompositeQuadric:
        """The part of this solid that a part of its tree describes."""
        kept = sorted(surfaces_of(tree))
        leaves: list[Tree] = [Leaf(kept.index(k)) if k in kept else Leaf(-1) for k in range(len(self.surfaces))]
        return self._with(
            surfaces=tuple(self.surfaces[k] for k in kept), tree=renumbered(tree, leaves), forms=self.forms[kept],
            parts=(), _reaches=tuple(self._reaches[k] for k in kept), recipe=None,
        )  # fmt: skip

    def of_whole(self, feature: Face | Edge | Vertex) -> Face | Edge | Vertex:
        """Of a cut model's feature that of the whole one: on the same surfaces, of one kind, the nearest."""
        whole = self.whole
        assert whole is not None
        carriers = {self.surfaces[k] for k in feature.surfaces}

        def unlike(other: Face | Edge | Vertex) -> float:
            if isinstance(feature, Vertex) and isinstance(other, Vertex):
                return max(abs(p - q) for p, q in zip(feature.position, other.position, strict=True))
            if isinstance(feature, Face) and isinstance(other, Face):
                return float(feature.carrier != other.carrier)
            return float(getattr(feature, "convexity", None) != getattr(other, "convexity", None))

        known: dict[type, Sequence[Face | Edge | Vertex]] = {
            Face: whole.faces, Edge: whole.edges, Vertex: whole.vertices,
        }  # fmt: skip
        same = (f for f in known[type(feature)] if carriers <= {whole.surfaces[k] for k in f.surfaces})
        return min(same, key=unlike)

    # -- combining ------------------------------------------------------------------------------------------

    def __or__(self, other: CompositeQuadric) -> CompositeQuadric:
        return self._combined(other, "|", Or)

    def __and__(self, other: CompositeQuadric) -> CompositeQuadric:
        return self._combined(other, "&", And)

    def __sub__(self, other: CompositeQuadric) -> CompositeQuadric:
        return self._combined(other, "-", lambda a, b: And(a, Not(b)), subtract=True)

    def _combined(
        self, other: CompositeQuadric, sign: str, operation: Callable[[Tree, Tree], Tree], *, subtract: bool = False
    ) -> CompositeQuadric:
        if not isinstance(other, CompositeQuadric):
            refused: CompositeQuadric = NotImplemented
            return refused
        numbers, places, added = _places(self._numbers(), self.surfaces, other)
        surfaces = (*self.surfaces, *(other.surfaces[k] for k in added))
        tree = renumbered(other.tree, [Leaf(i) if side > 0 else Not(Leaf(i)) for i, side in places])
        parts = [*self._inner_parts(), *other._inner_parts(places, flipped=subtract)]
        clip_own = None if operation is Or or subtract else other._box
        clip_other = None if operation is Or else other._part_in(self._box)
        reaches = list(self._reaches)
        if clip_own is not None:
            reaches = [SurfaceReach(_overlap(reach.box, clip_own), reach.outside) for reach in reaches]
        for (k, side), reach in zip(places, other._reaches, strict=True):
            clipped = SurfaceReach(_overlap(reach.box, clip_other), side * reach.outside)
            if k < len(reaches):
                known = reaches[k]
                same = known.outside == clipped.outside
                clipped = SurfaceReach(_hull(known.box, clipped.box), known.outside if same else 0)
                reaches[k] = clipped
            else:
                reaches.append(clipped)
        if subtract:
            box, tree = self._box, And(self.tree, tree.inner if isinstance(tree, Not) else Not(tree))
        else:
            tree = operation(self.tree, tree)
            box = _hull(self._box, other._box) if operation is Or else _overlap(self._box, other._box)
        witness = self._witness or other._witness
        forms = np.concatenate([self.forms, other.forms[added]])
        made = CompositeQuadric(surfaces, tree, parts, box=box, reaches=reaches, witness=witness, forms=forms)
        made._search["numbers"] = numbers
        made.recipe = combined(sign, self, other)
        return made

    def _part_in(self, box: Box | None) -> Box | None:
        """A box that holds what is of the solid in a box; close to it where that is soon found.

        Of solids made by subtraction it is not close: in it, what was cut off may be left out (`regions`).
        """
        from firstcontact.body.solid.extent import hull_of_cells

        both = _overlap(self._box, box)
        if both is None or both == self._box or len(self.surfaces) > FEW or not grows_with_leaves(self.tree):
            return both
        lo, hi = (tuple(exact_value(x) for x in corner.tolist()) for corner in hull_of_cells(self, both, 8))
        return _overlap(both, (lo, hi))

    def _numbers(self) -> dict[Vector, int]:
        """The number of each surface, in order, by what its form has in common with its multiples."""
        if "numbers" not in self._search:
            self._search["numbers"] = {_key(surface): i for i, surface in enumerate(self.surfaces)}
        known: dict[Vector, int] = self._search["numbers"]
        return known

    def _inner_parts(
        self, place: Sequence[tuple[int, int]] | None = None, *, flipped: bool = False
    ) -> list[LabelledPart]:
        """The parts with this solid's name in front, for surfaces numbered and turned as `place` tells."""
        if self.name is None and place is None:
            return list(self.parts)
        parts = []
        for part in self.parts:
            path = ".".join(p for p in (self.name, part.path) if p)
            labels = part.labels
            if place is not None:
                labels = tuple(
                    (place[i][0], side * place[i][1] * (-1 if flipped else 1), label) for i, side, label in labels
                )
            parts.append(LabelledPart(path, labels, part.edges, part.cuts + flipped))
        return parts

    # -- placing --------------------------------------------------------------------------------------------

    def _with(self, **changes: object) -> CompositeQuadric:
        other = object.__new__(CompositeQuadric)
        other.__dict__.update(self.__dict__)
        other.__dict__.update(_search={}, whole=None, source=None, translate_of=None)
        other.__dict__.update(changes)
        return other

    def _mapped(self, matrix: Matrix) -> CompositeQuadric:
        if any(max(abs(row[k]) for row in matrix) < LEAST for k in range(3)):
            raise InputError(f"{self._who}: this map makes it smaller by more than 2^-150; give a larger scale")
        back = inverse((*matrix, (ZERO, ZERO, ZERO, ONE)))
        surfaces = tuple(s.placed(back) for s in self.surfaces)
        box = None if self._box is None else _mapped_box(matrix, self._box)
        if box is not None and any(abs(x) >= LARGEST for corner in box for x in corner):
            raise InputError(f"{self._who}: coordinates leave the range 2^150 under this map")
        boxes = {box: None if box is None else _mapped_box(matrix, box) for box in {r.box for r in self._reaches}}
        witness = None if self._witness is None else apply(matrix, self._witness)  # type: ignore[arg-type]
        return self._with(
            surfaces=surfaces,
            forms=np.array([doubles(s.matrix()) for s in surfaces]),
            _box=box,
            _reaches=tuple(SurfaceReach(boxes[reach.box], reach.outside) for reach in self._reaches),
            _witness=witness,
            recipe=None if self.recipe is None else self.recipe.moved(matrix),
            translate_of=self._origin_of(matrix),
        )

    def _origin_of(self, matrix: Matrix) -> tuple[CompositeQuadric, Vector] | None:
        """As `translate_of` of the image under a map."""
        if not is_shift(matrix) or self.source is not None:  # those of a polyhedron have its numbers
            return None
        origin, before = self.translate_of or (self, (ZERO, ZERO, ZERO))
        x, y, z = (x + row[3] for x, row in zip(before, matrix, strict=True))
        return origin, (x, y, z)

    # -- looking --------------------------------------------------------------------------------------------

    def contains(self, points: Any) -> np.ndarray:
        """(n,) bools: whether each of the (n, 3) points is in the closed solid; one bool for one (3,) point.

        Exact for the coordinates given: floats decide only where their error bound lets them.
        """
        try:
            p = np.asarray(points, float)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"points are {shown(points)}; give an (n, 3) array of numbers") from error
        single = p.ndim == 1
        rows = [points] if single else points
        p = np.atleast_2d(p)
        if p.ndim != 2 or p.shape[1] != 3:
            raise InputError(f"points have shape {np.shape(points)}; give an (n, 3) array")
        if not np.all(np.isfinite(p)):
            raise InputError("points hold a value that is not finite")
        may_in, may_out = self._possible(p)
        answer: np.ndarray = may_in & ~may_out
        for k in np.flatnonzero(may_in & may_out):
            answer[k] = self.contains_exactly(vector3(rows[k], f"point {k}"))
        told: np.ndarray = answer[0] if single else answer
        return told

    def contains_exactly(self, point: Vector) -> bool:
        """Whether the rational point (x, y, z) is in the closed solid."""
        return True in self._around(point)

    def holds_inside(self, point: Vector) -> bool:
        """Whether the rational point (x, y, z) is proved to be an inner point of the solid."""
        return self._around(point) == {True} and not self.is_tip(point)  # next to tips `patterns` may miss some

    def is_next_to_outside(self, point: Vector) -> bool:
        """Whether the rational point (x, y, z) is proved to be outside, or on the surface, of the solid."""
        return False in self._around(point)

    def is_tip(self, point: Vector) -> bool:
        """Whether a surface has no tangent plane at the rational point."""
        x = (*point, ONE)
        return any(s.value(x) == 0 and not any(s.gradient(x)) for s in self.surfaces)

    def _around(self, point: Vector) -> set[bool]:
        """Which of inside and outside there is arbitrarily near the point."""
        x = (*point, ONE)
        signs = self.signs(x)
        values = outcomes(self.tree, signs)
        if len(values) == 1:
            return values
        on = [i for i, sign in enumerate(signs) if sign == 0]
        return {inside(self.tree, pattern(signs, on, p)) for p in patterns(x, self.surfaces, on)}

    def signs(self, x: Vector) -> list[int]:
        """Exact sign of every surface's form at the homogeneous point x, w > 0."""
        signs = [0] * len(self.surfaces)
        if len(signs) > FEW:  # doubles settle nearly all
            values, error = self._values(np.array([[to_double(c / x[3]) for c in x[:3]]]))
            signs = [int(k) for k in (values > error).astype(int)[:, 0] - (values < -error)[:, 0]]
        exactly = {k: self.surfaces[k].value(x) for k, sign in enumerate(signs) if sign == 0}
        for k, value in exactly.items():
            signs[k] = (value > 0) - (value < 0)
        return signs

    def _possible(self, p: np.ndarray, slack: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """(may be inside, may be outside), (n,) bools each, at (n, 3) float64 points.

        Forms smaller than their rounding error may have either sign, and those that vanish within `slack` times the
        largest coordinate of any of the points: of any, since next to the origin all terms are small together.
        """
        values, error = self._values(p)
        if slack:
            x = np.abs(np.column_stack([p, np.ones(len(p))]))
            reach = x + [*[slack * np.abs(p).max(initial=0.0)] * 3, 0.0]
            error = error + (self._sizes(reach) * (1 + 2.0**-45) - self._sizes(x))
        return possible(self.tree, list(values < error), list(values > -error))

    def _values(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(surfaces, n) values of the forms at (n, 3) float64 points, and bounds on their errors."""
        x = np.column_stack([p, np.ones(len(p))])
        values = np.einsum("snj,nj->sn", x @ self.forms, x)
        # coefficients, products and sums of sixteen terms: fewer than 32 roundings of relative size 2^-53;
        # input numbers that are no doubles add one more per coordinate
        return values, self._sizes(np.abs(x)) * (40 * 2.0**-53) + 1e-290

    def _sizes(self, x: np.ndarray) -> np.ndarray:
        """(surfaces, n): the sizes of the forms' terms at (n, 4) points that are not negative."""
        sizes: np.ndarray = np.einsum("snj,nj->sn", x @ np.abs(self.forms), x)
        return sizes

    def gradient(self, surface: int, x: np.ndarray) -> np.ndarray:
        """(3,): unit, of the form of a surface at (3,) x on it; 0 where it vanishes, as at the tip of a cone."""
        terms = self.forms[surface][:3] * np.append(x, 1.0)
        g = terms.sum(axis=1)
        length = float(np.linalg.norm(g))
        unit: np.ndarray = g / length if length > SINGULAR * np.abs(terms).max() else np.zeros(3)
        return unit

    def is_round(self, axis: VectorOf[fmpq], point: VectorOf[fmpq]) -> bool:
        from firstcontact.body.solid.revolution import is_same

        line = ("round", *((int(x.p), int(x.q)) for x in (*axis, *point)))
        if line not in self._search:
            self._search[line] = all(is_same(surface, axis, point) for surface in self.surfaces)
        known: bool = self._search[line]
        return known

    @property
    def bounded(self) -> bool:
        """True proves that the solid is bounded; False where no bound was found."""
        return self._finite_box() is not None

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the body; infinite where no bound is known."""
        from firstcontact.body.solid.extent import tight_box

        box = self._finite_box()
        if box is None:
            return np.full(3, -np.inf), np.full(3, np.inf)
        if "box" not in self._search:
            self._search["box"] = tight_box(self, box)
        lo, hi = self._search["box"]
        return lo.copy(), hi.copy()

    def _rough_box(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Float corners of a box that holds the solid, found without its edges."""
        from firstcontact.body.solid.extent import hull_of_cells

        box = self._finite_box()
        return None if box is None else hull_of_cells(self, box)

    def _finite_box(self) -> Box | None:
        if self._box is None and "unbounded" not in self._search:
            from firstcontact.body.solid.extent import proved_box

            self._box = proved_box(self.tree, self.surfaces)
            if self._box is None:
                self._search["unbounded"] = True
        return self._box

    def to_mesh(self, tolerance: float) -> Polyhedron:
        """A Polyhedron of triangles with all vertices on the surfaces, at most `tolerance` from the solid's faces."""
        from firstcontact.body.solid_mesh.quadric_mesh import mesh

        return mesh(self, tolerance)

    def skin(self, tolerance: float, lo: np.ndarray, hi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Its faces as triangles (n, 3, 3) that look outwards, each one's face (n,), and normals (n, 3, 3) of corners.

        Of a body without end the part near the box with corners lo, hi.
        """
        from firstcontact.body.solid_mesh.skin import skin

        return skin(self, tolerance, lo, hi)

    def told(self) -> list[str]:
        return told.solid(self)

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        try:
            counts = [(len(self.faces), "face"), (len(self.edges), "edge"), (len(self.vertices), "vertex")]
        except NotDerived:
            counts = [(len(self.surfaces), "surface")]
        return f"<CompositeQuadric{name}: {', '.join(_count(n, what) for n, what in counts)}>"

    def _facts(self) -> tuple[Hashable, ...]:
        return self.surfaces, self.tree, self.parts

    def _table(self) -> Table:
        if self.recipe is None:
            raise InputError(f"{self._who} was made by a search, not by builders; write the body it came from")
        return self.recipe.written()

    # -- inside ---------------------------------------------------------------------------------------------

    @property
    def inner_point(self) -> Vector | None:
        """A rational point of the interior, if one was met; solids are proved to have some without it too."""
        return self._witness

    def is_strict(self, x: Vector, wanted: bool) -> bool:
        """Whether no form vanishes at the rational point (x, y, z), and the Boolean value there is the one wanted."""
        signs = self.signs((*x, ONE))
        return 0 not in signs and inside(self.tree, [s < 0 for s in signs]) == wanted

    @property
    def _who(self) -> str:
        return self.name or "solid"

    def _validate(self) -> None:
        """An interior and an exterior point: looked for at random first, then decided by the faces."""
        if not np.isfinite(self.forms).all():
            raise InputError(f"{self._who}: a coefficient is beyond the range of doubles")
        self._witness = self._strict_point(True)
        if self._witness is not None and (self._box is not None or self._strict_point(False) is not None):
            return
        if not self.faces:
            values = outcomes(self.tree, [-1] * len(self.surfaces)) if not self.surfaces else None
            sample = self._anywhere()
            full = values == {True} or (sample is not None and sample)
            what = "fills all of space" if full else "is empty: its conditions contradict each other"
            raise NoSolid(f"{self._who} {what}; check the operands")

    def _strict_point(self, wanted: bool) -> Vector | None:
        """A rational point with no form zero, whose Boolean value is the one wanted; None when none was met."""
        if wanted and self._witness is not None and self.is_strict(self._witness, True):
            return self._witness
        for p in self._samples():
            may_in, may_out = self._possible(p)
            good = may_in & ~may_out if wanted else may_out & ~may_in
            for k in np.flatnonzero(good)[:3]:
                x = tuple(fmpq(*float(c).as_integer_ratio()) for c in p[k])
                if self.is_strict(x, wanted):
                    return x
        return None

    def _samples(self) -> Iterator[np.ndarray]:
        """(n, 3) random points each: in the box, in a closer one, or at ever larger distances where no box is known."""
        from firstcontact.body.solid.extent import hull_of_cells

        rng = np.random.default_rng(0)
        if self._box is None:
            yield from (rng.normal(0, scale, (1000, 3)) for scale in (1.0, 30.0, 1000.0))
            return
        lo, hi = (np.array([to_double(x) for x in corner]) for corner in self._box)
        yield rng.uniform(lo, hi, (1000, 3))
        lo, hi = hull_of_cells(self, self._box)
        yield rng.uniform(lo, hi, (2000, 3))

    def _anywhere(self) -> bool | None:
        """The Boolean value at some point where no form vanishes; for solids without faces it is the same all over."""
        for k in range(100):
            signs = self.signs((fmpq(k, 97), fmpq(k * k, 89), fmpq(1, 83), ONE))
            if 0 not in signs:
                return bool(inside(self.tree, [s < 0 for s in signs]))
        return None

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_search": {}, "translate_of": None}


def _count(n: int, what: str) -> str:
    plural = "vertices" if what == "vertex" else what + "s"
    return f"{n} {what if n == 1 else plural}"


# -- surfaces of operands -----------------------------------------------------------------------------------


def _key(surface: Surface) -> Vector:
    """The same for a form and all its multiples."""
    flat = surface.normal if isinstance(surface, Plane) else tuple(x for row in surface.form for x in row)
    return upright(flat)


def _places(
    numbers: dict[Vector, int], surfaces: Sequence[Surface], other: CompositeQuadric
) -> tuple[dict[Vector, int], list[tuple[int, int]], list[int]]:
    """(numbers of all surfaces by their keys, places, added) where another solid's surfaces join those of one.

    places: (number, +-1) of each of the other's surfaces, -1 where the form known has the other sign; added: those
    that were not there.
    """
    numbers, places, added = dict(numbers), [], list[int]()
    for k, (surface, key) in enumerate(zip(other.surfaces, other._numbers(), strict=True)):
        i = numbers.setdefault(key, len(numbers))
        if i == len(surfaces) + len(added):
            added.append(k)
        places.append((i, 1 if i >= len(surfaces) or surfaces[i] == surface else -1))
    return numbers, places, added


def joined(first: Sequence[Surface], second: Sequence[Surface], tree: Tree) -> tuple[list[Surface], Tree]:
    """All surfaces, equal ones once; and the second solid's tree in the new numbers.

    Half-spaces on the two sides of one surface become one leaf and its negation: so solids that touch along a
    surface leave no wall there.
    """
    surfaces = list(first)
    keys = {_key(s): i for i, s in enumerate(surfaces)}
    leaves: list[Tree] = []
    for surface in second:
        i = keys.setdefault(_key(surface), len(surfaces))
        if i == len(surfaces):
            surfaces.append(surface)
        leaves.append(Leaf(i) if surfaces[i] == surface else Not(Leaf(i)))
    return surfaces, renumbered(tree, leaves)


def _hull(first: Box | None, second: Box | None) -> Box | None:
    if first is None or second is None:
        return None
    return tuple(map(min, first[0], second[0])), tuple(map(max, first[1], second[1]))


def _mapped_box(matrix: Matrix, box: Box) -> Box:
    """A box around the image of a box."""
    corners = [apply(matrix, corner) for corner in product(*zip(*box, strict=True))]  # type: ignore[arg-type]
    return tuple(min(c) for c in zip(*corners, strict=True)), tuple(max(c) for c in zip(*corners, strict=True))


def _overlap(first: Box | None, second: Box | None) -> Box | None:
    if first is None or second is None:
        return first or second
    lo, hi = tuple(map(max, first[0], second[0])), tuple(map(min, first[1], second[1]))
    return lo, tuple(map(max, lo, hi))


# -- intersections of half-spaces --------------------------------------------------------------------------


def solid(
    leaves: Sequence[tuple[str, Surface]], edges: Sequence[tuple[str, str, str]] = (), *,
    box: Box | None = None, witness: Vector | None = None, name: str | None = None,
) -> CompositeQuadric:  # fmt: skip
    """The intersection of named half-spaces."""
    from firstcontact.body.solid.csg import conjunction

    surfaces: list[Surface] = []
    trees: list[Tree] = []
    labels = []
    for label, surface in leaves:
        surfaces, tree = joined(surfaces, [surface], Leaf(0))
        trees.append(tree)
        number = tree.inner if isinstance(tree, Not) else tree
        assert isinstance(number, Leaf)
        labels.append((number.surface, -1 if isinstance(tree, Not) else 1, label))
    parts = [LabelledPart("", tuple(labels), tuple(edges))]
    return CompositeQuadric(surfaces, conjunction(trees), parts, box=box, witness=witness, name=name)


def form_of(rows: Rows) -> Quadric:
    from firstcontact.body.solid.carriers import primitive_rows

    return Quadric(primitive_rows(rows))
