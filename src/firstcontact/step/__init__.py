"""STEP files: their trees of parts, and bodies made of these with proved deviations.

assembly    `load_step`, `from_shape` and what they give
reader      the tree of a file, by OpenCASCADE; text looks at the file itself first: its numbers, its occurrences
solids      faces, edges and vertices of a solid with their entities; what makes it no solid
bodies      what becomes of a solid: a polyhedron with the file's planes, exact pieces, or triangles
planar      solids of planes as polyhedra
cells       exact pieces, from what is left when rounds, the faces on tori, are cut off
triangles   all others as triangles; bounds proves how far these are from the file's surfaces, sagitta of round ones
"""
