"""The curve of a ruled surface with a solid or a polyhedron.

solid_verbs    one curve for every piece (and facet), joined
solid_curve    of a piece with a solid of planes and quadrics
facet_curve    of a piece with a facet of a polyhedron of any shape
"""
