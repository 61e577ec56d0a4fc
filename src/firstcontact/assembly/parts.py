"""The first new contact of solids of planes and quadrics, or one and a mesh, that touch at the start, by their parts.

A solid is the union of intersections of half-spaces and their likes.  Two such parts that a surface separates, which
the motion keeps or off which they part, never overlap, and share points of that surface alone: old contacts, if some
parts on these sides of it touch at the start.  All others are asked for their first contact, or, where they part at
once, for their next one.  The parts of a mesh are, of each plane near the solid, the triangles on its side that meet
it, and all others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from firstcontact.assembly.faces import Mesh, MeshPart
from firstcontact.assembly.kept import generators, parting, standing
from firstcontact.assembly.lifts import Hull, Reach, lift_of, lifted_until, planes_between_balls
from firstcontact.assembly.new_contact import (
    LASTING,
    Lasts,
    NewContactQuery,
    after_start,
    earliest,
    of_meshes,
    renamed,
)
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import Plane, Rows, Surface, doubles, inertia
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, conjunction, renumbered, surfaces_of
from firstcontact.contact.mesh_model import as_polyhedra
from firstcontact.contact.models.answer import element as named
from firstcontact.exact.numbers import fraction
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import Element, FirstContact, Status

if TYPE_CHECKING:
    from flint import fmpq

    from firstcontact.body.kinds import Body, Shape

MOST_PARTS = 200
"""Of a solid; pairs of them are asked about one by one."""
MOST_TRIANGLES = 20_000
"""Of a mesh whose planes are looked at."""
MOST_PLANES = 50
"""Of a mesh near a solid."""


@dataclass(frozen=True)
class StartPart:
    """An intersection, or a mesh, which moves as its body does; sides: its surfaces at the start, negative inside.

    stands: its shape there.
    """

    body: Any
    stands: Any
    sides: frozenset[Surface]
    whole: CompositeQuadric | None = None
    """The solid; None of a mesh."""
    triangles: MeshPart | None = None
    """Of a mesh, those that the part is; None: all."""

    def reach(self) -> Reach:
        """Where it lies at the start."""
        if isinstance(self.stands, Polyhedron):
            return [self.stands.exact_vertex(k) for k in range(len(self.stands.vertices))]
        return Hull(self.stands.bounds(), self.sides)

    def element(self, element: Element) -> Element:
        """What users call an element of the part: the solid's own on the same surfaces, or a face on one of them."""
        if self.whole is None:
            return element if self.triangles is None else self.triangles.element(element)
        part: CompositeQuadric = shape_of(self.body)._with(whole=self.whole)
        own: dict[str, Any] = {"face": part.faces, "edge": part.edges, "vertex": part.vertices, "apex": part.vertices}
        feature = own[element.kind][element.index]
        carriers = {part.surfaces[k] for k in feature.surfaces}
        faces = [x for x in self.whole.faces if carriers & {self.whole.surfaces[k] for k in x.surfaces}]
        try:
            feature = part.of_whole(feature)
        except ValueError:  # where parts meet it is none of the solid's
            feature = faces[0] if faces else feature
        return named(self.whole, feature, element.body)


def by_parts(a: Body, b: Body, asking: NewContactQuery) -> FirstContact | None:
    """None for other bodies and motions, and where there are too many parts.  Raises Lasts."""
    by = generators(a, b, asking.first, asking.last)
    stands = standing(a, asking.first), standing(b, asking.first)
    if by is None or stands[0] is None or stands[1] is None:
        return None
    shapes, lift = (stands[0], stands[1]), lift_of(a, b, asking.first)

    def tells(plane: Plane) -> bool:
        return parting(plane, by) is not None or (lift is not None and lift.is_along(plane))

    own, other = (
        _parts(x, shape) if isinstance(shape, CompositeQuadric) else _of_mesh(x, shape, beside, tells, asking)
        for x, shape, beside in zip((a, b), shapes, reversed(shapes), strict=True)
    )
    if own is None or other is None or not any(x.sides for x in (*own, *other)):
        return None
    pairs = []
    for x, y in product(own, other):
        touch = asking.at_start(x.body, y.body).status is Status.INITIAL_CONTACT
        pairs.append((x, y, touch, set(_seams(x, y, by)) if touch else set()))
    seams = {side for *_, between in pairs for side in between}
    found = []
    for x, y, touch, between in pairs:
        if between or touch and any(_separates(side, x, y) for side in seams):
            continue
        told = _after_start(x, y, asking) if touch else asking.first_contact(x.body, y.body)
        if told.status is Status.FREE or not any(_separates(side, x, y) for side in seams):
            found.append(renamed(told, x.element, y.element))
        if asking.is_open(told):  # whatever the others are
            break
    return earliest(found, asking)


def _after_start(x: StartPart, y: StartPart, asking: NewContactQuery) -> FirstContact:
    """New contacts of two parts that touch, as on a hinge.  Raises Lasts."""
    a, b = x.body, y.body
    off = _lifted_until(x, y, asking)
    if off is not None:
        return asking.first_contact(a, b, fraction(off))
    try:
        return after_start(a, b, asking)
    except Lasts:
        if not as_polyhedra.are_of_planes(a, b):
            raise
    found = of_meshes(a, b, asking)
    if found.reason == LASTING:
        raise Lasts
    return found


def _lifted_until(x: StartPart, y: StartPart, asking: NewContactQuery) -> fmpq | None:
    """A time until which the parts are off each other, as one turns off a plane of theirs, or one between balls."""
    sides = [*_sides_of(x, y), *planes_between_balls(x.sides, y.sides)]
    return lifted_until(
        (x.body, y.body), (x.reach, y.reach), sides, lambda plane: _separates(plane, x, y), asking.first, asking.last
    )


def _seams(x: StartPart, y: StartPart, by: Sequence[Rows]) -> Iterator[Surface]:
    """Surfaces of theirs that the motion keeps, or off which they part, with x on the negative side, y on the other."""
    for side in _sides_of(x, y):
        if parting(side, by) in (0, -1) and _separates(side, x, y):
            yield side


def _sides_of(x: StartPart, y: StartPart) -> Iterable[Surface]:
    """Surfaces of theirs, each once, negative on the side of x."""
    return dict.fromkeys([*x.sides, *(side.negated() for side in y.sides)])


def _separates(side: Surface, x: StartPart, y: StartPart) -> bool:
    """Whether x lies where the surface's form is not positive, and y where it is not negative."""
    return (side in x.sides or _is_beyond(x.stands, side.negated())) and (
        side.negated() in y.sides or _is_beyond(y.stands, side)
    )


def _is_beyond(shape: Polyhedron | CompositeQuadric, side: Surface) -> bool:
    """Whether all of it lies where the surface's form is not negative."""
    if isinstance(shape, Polyhedron):
        points = (shape.exact_vertex(k) for k in range(len(shape.vertices)))
        return _is_convex_beyond(side) and all(side.value((*p, 1)) >= 0 for p in points)
    try:
        shape & CompositeQuadric([side], Leaf(0))
    except NoSolid:
        return True
    return False


def _of_mesh(
    body: Body, stands: Shape, beside: Shape, tells: Callable[[Plane], bool], asking: NewContactQuery
) -> list[StartPart] | None:  # fmt: skip
    """The triangles by the planes that tell how bodies on both sides move; None of other bodies."""
    if not isinstance(stands, Polyhedron):
        return None
    whole = [StartPart(body, stands, frozenset())]
    if not (isinstance(beside, CompositeQuadric) and asking.is_apart and 0 < len(stands.triangles) <= MOST_TRIANGLES):
        return whole
    mesh = Mesh(body, stands)
    corners = list(product(*zip(*beside.bounds(), strict=True)))
    planes = [x for x in mesh.all_planes() if tells(x) and _meets(x, corners)]
    if len(planes) > MOST_PLANES:
        return whole
    parts, left = [], set(range(len(mesh.triangles)))
    for plane in planes:
        for side in {inner for _, inner in mesh.facets(plane)} - {0}:
            star = mesh.star(plane, side)
            left -= star
            parts.append(_sheet(mesh, star, {plane if side < 0 else plane.negated()}, asking))
    return [*parts, *([_sheet(mesh, left, set(), asking)] if left else [])] if parts else whole


def _meets(plane: Plane, corners: Sequence[Sequence[float]]) -> bool:
    """Whether a box has points within a millionth of its size of the plane."""
    (normal,) = doubles((plane.normal,))
    heights = [math.fsum([n * x for n, x in zip(normal, (*p, 1.0), strict=True)]) for p in corners]
    return min(heights) <= 1e-6 * (max(heights) - min(heights)) and max(heights) >= 0.0


def _sheet(mesh: Mesh, triangles: Iterable[int], sides: set[Surface], asking: NewContactQuery) -> StartPart:
    part = mesh.part(triangles)
    return StartPart(part.body, standing(part.body, asking.first), frozenset(sides), None, part)


def _is_convex_beyond(side: Surface) -> bool:
    """Whether what lies where the form is not negative is convex: its squares are all negative, or there are none."""
    if isinstance(side, Plane):
        return True
    positive, _ = inertia(tuple(row[:3] for row in side.form[:3]))
    return positive == 0


def _parts(body: Body, stands: CompositeQuadric) -> list[StartPart] | None:
    """Those of a solid; None where there are too many; stands: its shape at the start."""
    model: CompositeQuadric = shape_of(body)
    known: list[tuple[list[Tree], Any]] = [([], None)]
    for factor in _factors(model.tree, False):
        grown: list[tuple[list[Tree], Any]] = []
        for literals, _ in known:
            for more in _terms(factor):
                try:
                    grown.append(([*literals, *more], _intersection(model, [*literals, *more])))
                except NoSolid:
                    continue
        if len(grown) > MOST_PARTS:
            return None
        known = grown
    return [
        StartPart(
            Moving(part, body.motion) if isinstance(body, Moving) else part,
            part if stands is model else _intersection(stands, literals),
            frozenset(_sides(stands, literals)), model,
        )
        for literals, part in known
    ]  # fmt: skip


def _factors(tree: Tree, turned: bool) -> list[tuple[Tree, bool]]:
    """Trees, turned inside out or not, whose intersection it is: the smaller ones first."""
    if isinstance(tree, Not):
        return _factors(tree.inner, not turned)
    if isinstance(tree, Or if turned else And):
        both = [*_factors(tree.first, turned), *_factors(tree.second, turned)]
        return sorted(both, key=lambda x: not isinstance(x[0], Leaf))
    return [(tree, turned)]


def _terms(factor: tuple[Tree, bool]) -> Iterator[list[Tree]]:
    """Lists of leaves, turned or not, of which the factor is the union of intersections."""
    tree, turned = factor
    if isinstance(tree, Leaf):
        yield [Not(tree) if turned else tree]
        return
    if isinstance(tree, Not):
        yield from _terms((tree.inner, not turned))
    elif isinstance(tree, And if turned else Or):
        yield from _terms((tree.first, turned))
        yield from _terms((tree.second, turned))
    else:
        for first in _terms((tree.first, turned)):
            for second in _terms((tree.second, turned)):
                yield [*first, *second]


def _intersection(model: CompositeQuadric, literals: Sequence[Tree]) -> CompositeQuadric:
    """Raises NoSolid where it has no inside in the model's box."""
    trees = list(dict.fromkeys(literals))
    used = sorted({k for x in trees for k in surfaces_of(x)})
    leaves: list[Tree] = [Leaf(used.index(k) if k in used else -1) for k in range(len(model.surfaces))]
    tree = renumbered(conjunction(trees), leaves)
    surfaces = [model.surfaces[k] for k in used]
    return CompositeQuadric(surfaces, tree, box=model._box, name=model.name, forms=model.forms[used])


def _sides(model: CompositeQuadric, literals: Sequence[Tree]) -> Iterator[Surface]:
    for x in literals:
        if isinstance(x, Not):
            assert isinstance(x.inner, Leaf)
            yield model.surfaces[x.inner.surface].negated()
        elif isinstance(x, Leaf):
            yield model.surfaces[x.surface]
