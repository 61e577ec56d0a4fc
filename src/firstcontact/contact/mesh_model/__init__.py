"""A polyhedron and a solid of planes and quadrics.

first            `first`, the first contact, and `intervals`, all of them: the ways to both
by_triangles     the first contact
mesh_intervals   all contacts, patch by patch
mesh_starts      how they lie at the start
mesh_holes       the mesh against solids with holes or waists
patches          triangles, edges and points of a mesh as a model without inside
lasting_mesh     contacts that last
"""
