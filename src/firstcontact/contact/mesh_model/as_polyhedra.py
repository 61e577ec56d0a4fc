"""A polyhedron of any shape and a solid of planes: two polyhedra, whose search is exact and many times as quick.

Two solids of planes are so where what is made for curved ones does not decide them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.later import waiting
from firstcontact.contact.mesh_model.planar_solid import planar
from firstcontact.contact.models.answer import element as named
from firstcontact.contact.polyhedra import first as polyhedra
from firstcontact.contact.ways import Passed, decided
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, ContactSet, Element, ElementPair, FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

def are_taken(a: Body, b: Body) -> bool:
    """Whether one of two bodies is a mesh, bare edges and points apart, and the other one a solid of planes."""
    return any(isinstance(shape_of(x), Polyhedron) for x in (a, b)) and are_of_planes(a, b)


def are_of_planes(a: Body, b: Body) -> bool:
    """Whether both are solids of planes, or one of them and the other one a mesh, bare edges and points apart."""
    shapes = shape_of(a), shape_of(b)
    return not all(isinstance(x, Polyhedron) for x in shapes) and all(
        len(x.triangles) > 0 if isinstance(x, Polyhedron) else isinstance(x, CompositeQuadric) and planar(x) is not None
        for x in shapes
    )


def first(query: Query, _: object = None) -> FirstContact | Passed:
    """The first contact of the two as polyhedra."""
    found = polyhedra.first(_asked(query))
    if found.status in (Status.CONTACT, Status.INITIAL_CONTACT):
        return in_own_elements(found, *query.bodies)
    return decided(replace(found, **query.shared), query)


def intervals(query: Query, _: object = None) -> ContactIntervals | Passed:
    """All times of contact of the two as polyhedra."""
    return decided(replace(polyhedra.intervals(_asked(query)), **query.shared), query)


def _asked(query: Query) -> Query:
    return replace(query, a=as_polyhedron(query.a), b=as_polyhedron(query.b))


def as_polyhedron(body: Body) -> Body:
    """A solid of planes as a polyhedron, at rest or moving as it does; others as they are."""
    shape = shape_of(body)
    solid = None if isinstance(shape, Polyhedron) else planar(shape)
    if solid is None:
        return body
    return Moving(solid.polyhedron, body.motion) if isinstance(body, Moving) else solid.polyhedron


def in_own_elements(found: FirstContact, a: Body, b: Body) -> FirstContact:
    """The answer about both as polyhedra as one about the bodies themselves; its place waits until it is asked for."""
    return waiting(found, partial(_place, found, a, b), a=a, b=b)


def _place(found: FirstContact, a: Body, b: Body) -> dict[str, object]:
    """Each pair of elements once, of which the polyhedron may have several."""
    if found.element_a is None or found.element_b is None:
        return {}

    def own(element: Element, body: Body, which: str) -> Element:
        solid = None if isinstance(shape_of(body), Polyhedron) else planar(shape_of(body))
        return element if solid is None else named(solid.model, solid.own(element), which)

    pairs = [ElementPair(found.element_a, found.element_b), *found.others]
    lowest, *rest = dict.fromkeys(ElementPair(own(x.element_a, a, "a"), own(x.element_b, b, "b")) for x in pairs)
    known: dict[str, object] = {
        "element_a": lowest.element_a, "element_b": lowest.element_b, "others": tuple(rest),
        "multiplicity": found.multiplicity - (len(pairs) - 1 - len(rest)),
    }  # fmt: skip
    if found.contact_set is not None and found.point is not None:
        known["contact_set"] = ContactSet("point", found.point[None])
    return known
