"""A start in contact: do the bodies touch, or do they share interior points?  Exact.

An edge that passes through the inside of a facet settles it.  Otherwise the bodies overlap iff a whole component
of one lies inside the other, or at some vertex of the shared set the two tangent cones have a common interior
direction.
"""

from __future__ import annotations

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.earliest import FoundFirst, Searched, earliest, pairs_at_start
from firstcontact.exact.numbers import Undecidable
from firstcontact.search.trees.cones import cones_overlap
from firstcontact.search.trees.containment import component_labels, component_vertices, contains
from firstcontact.search.trees.elements import Feature, vertices_of
from firstcontact.search.trees.frame import tree_of
from firstcontact.search.trees.shared_points import RestingVertices, shared_points


def initial_kind(problem: Searched, found: FoundFirst) -> str:
    """ "touching" or "overlapping", for bodies whose surfaces share a point at the start.

    Overlapping: some point of one lies in the interior of the other, which is a solid.
    Raises Undecidable in irrational poses.
    """
    a, b = problem.a, problem.b
    if not (a.solid or b.solid):
        return "touching"
    if any(crossing for _, crossing in found.start):
        return "overlapping"
    if a.irrational_pose is None and b.irrational_pose is None:
        return "overlapping" if _overlap(a, b) else "touching"
    if any(crossing for _, crossing in pairs_at_start(problem)):
        return "overlapping"
    # what follows asks whether numbers are equal: no question for balls
    from firstcontact.contact.polyhedra.standstill import Standstill  # loads the walk of rotations

    if not isinstance(problem, Standstill):
        raise Undecidable
    nearby = problem.soon()
    return initial_kind(nearby, earliest(nearby))


def _overlap(a: Polyhedron, b: Polyhedron) -> bool:
    """Whether bodies whose surfaces meet share interior points."""
    resting = RestingVertices(a, b)
    shared = shared_points(resting)
    return (
        shared is None
        or _component_inside(a, b, [x for x, _ in shared])
        or _component_inside(b, a, [y for _, y in shared])
        or any(cones_overlap(resting, pair) for pair in shared)
    )


def _component_inside(inner: Polyhedron, outer: Polyhedron, touching: list[Feature]) -> bool:
    """Whether a component of `inner` that touches nothing lies inside `outer`."""
    vertices = component_vertices(inner)
    if not outer.solid or len(vertices) == 1:
        return False
    label = component_labels(inner)
    touched = {int(label[vertices_of(inner, element)[0]]) for element in touching}
    tree = tree_of(outer)
    free = [v for v in vertices if int(label[v]) not in touched]
    return any(contains(outer, tree, inner.exact_vertex(v)) for v in free)
