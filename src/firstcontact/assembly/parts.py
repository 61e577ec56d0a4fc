"""The first new contact of solids of planes and quadrics, or one and a mesh, that touch at the start, by their parts.

A solid is the union of intersections of half-spaces and their likes.  Two such parts that a surface separates, which
the motion keeps or off which they part, never overlap, and share points of that surface alone: old contacts, if some
parts on these sides of it touch at the start.  All others are asked for their first contact, or, where they part at
once, for their next one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from firstcontact.assembly.kept import generators, parting, standing
from firstcontact.assembly.new_contact import NewContactQuery, after_start, earliest, renamed
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import Plane, Rows, Surface
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, conjunction, renumbered, surfaces_of
from firstcontact.contact.models.answer import element as named
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import Element, FirstContact, Status

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

MOST_PARTS = 200
"""Of a solid; pairs of them are asked about one by one."""


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

    def element(self, element: Element) -> Element:
        """What users call an element of the part: the solid's own on the same surfaces, or a face on one of them."""
        if self.whole is None:
            return element
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
    stands = [standing(x, asking.first) for x in (a, b)]
    if by is None or stands[0] is None or stands[1] is None:
        return None
    own, other = (_parts(x, shape) for x, shape in zip((a, b), stands, strict=True))
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
        told = after_start(x.body, y.body, asking) if touch else asking.first_contact(x.body, y.body)
        if told.status is Status.FREE or not any(_separates(side, x, y) for side in seams):
            found.append(renamed(told, x.element, y.element))
    return earliest(found, asking)


def _seams(x: StartPart, y: StartPart, by: Sequence[Rows]) -> Iterator[Surface]:
    """Surfaces of theirs that the motion keeps, or off which they part, with x on the negative side, y on the other."""
    for side in dict.fromkeys([*x.sides, *(side.negated() for side in y.sides)]):
        if parting(side, by) in (0, -1) and _separates(side, x, y):
            yield side


def _separates(side: Surface, x: StartPart, y: StartPart) -> bool:
    """Whether x lies where the surface's form is not positive, and y where it is not negative."""
    return (side in x.sides or _is_beyond(x.stands, side.negated())) and (
        side.negated() in y.sides or _is_beyond(y.stands, side)
    )


def _is_beyond(shape: Polyhedron | CompositeQuadric, side: Surface) -> bool:
    """Whether all of it lies where the surface's form is not negative."""
    if isinstance(shape, Polyhedron):
        points = (shape.exact_vertex(k) for k in range(len(shape.vertices)))
        return isinstance(side, Plane) and all(side.value((*p, 1)) >= 0 for p in points)
    try:
        shape & CompositeQuadric([side], Leaf(0))
    except NoSolid:
        return True
    return False


def _parts(body: Any, stands: Any) -> list[StartPart] | None:
    """None of other bodies, and where there are too many; stands: its shape at the start."""
    model: Any = shape_of(body)
    if isinstance(model, Polyhedron):
        return [StartPart(body, stands, frozenset())]
    if not isinstance(model, CompositeQuadric):
        return None
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
