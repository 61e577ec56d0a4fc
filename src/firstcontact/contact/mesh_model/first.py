"""`first_contact` and `contact_intervals` of a polyhedron of any shape and a solid of planes and quadrics."""

from __future__ import annotations

from firstcontact.contact import upright_parts
from firstcontact.contact.centred import first_anew
from firstcontact.contact.mesh_model import as_polyhedra, by_triangles, mesh_intervals
from firstcontact.contact.ways import Passed, Way, answered, decided, tried
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query


def first(query: Query) -> FirstContact:
    """The first contact of a Polyhedron and a CompositeQuadric, in either order, at rest or moving.

    Raises UnsupportedPair.
    """
    ways = [
        Way("as polyhedra", as_polyhedra.first, lambda query, _: as_polyhedra.are_taken(*query.bodies)),
        Way("by triangles in doubles", _in_doubles, _may_be_in_doubles),
        Way("near the origin", _near_origin, _may_be_in_doubles),
        Way("by triangles", lambda query, _: decided(by_triangles.first(query), query)),
        Way("by points", lambda query, _: mesh_intervals.first_by_points(query), _may_be_in_doubles),
    ]
    return answered(ways, query)


def _may_be_in_doubles(query: Query, _: FirstContact | None) -> bool:
    """Whether doubles are asked before exact arithmetic is: it takes all that a caller's budget allows."""
    return not query.is_algebraic and query.budget is None


def _in_doubles(query: Query, _: FirstContact | None) -> FirstContact | Passed:
    return decided(by_triangles.first_in_doubles(query), query)


def _near_origin(query: Query, _: FirstContact | None) -> FirstContact | Passed:
    """Of bodies away from it what doubles left open, told from more digits."""
    found = first_anew(by_triangles.first_in_doubles, query)
    return Passed("they are at the origin") if found is None else decided(found, query)


def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact of the two, certified; exact of solids of planes.  Raises UnsupportedPair."""
    if upright_parts.may_be_asked(query, None):
        by_parts = tried(lambda: upright_parts.intervals(query, None, intervals))
        if not isinstance(by_parts, Passed):
            return by_parts
    if not as_polyhedra.are_taken(*query.bodies):
        return mesh_intervals.intervals(query)
    ways = [
        Way("as polyhedra", as_polyhedra.intervals),
        Way("by triangles", lambda query, _: mesh_intervals.intervals(query)),
    ]
    return answered(ways, query)
