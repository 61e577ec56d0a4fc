"""`first_contact` and `contact_intervals` of a polyhedron of any shape and a solid of planes and quadrics."""

from __future__ import annotations

from firstcontact.contact.mesh_model import as_polyhedra, by_triangles, mesh_intervals
from firstcontact.contact.ways import Way, answered
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query


def first(query: Query) -> FirstContact:
    """The first contact of a Polyhedron and a CompositeQuadric, in either order, at rest or moving.

    Raises UnsupportedPair.
    """
    if not as_polyhedra.are_taken(*query.bodies):
        return by_triangles.first(query)
    ways = [Way("as polyhedra", as_polyhedra.first), Way("by triangles", lambda query, _: by_triangles.first(query))]
    return answered(ways, query)


def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact of the two, certified; exact of solids of planes.  Raises UnsupportedPair."""
    if not as_polyhedra.are_taken(*query.bodies):
        return mesh_intervals.intervals(query)
    ways = [
        Way("as polyhedra", as_polyhedra.intervals),
        Way("by triangles", lambda query, _: mesh_intervals.intervals(query)),
    ]
    return answered(ways, query)
