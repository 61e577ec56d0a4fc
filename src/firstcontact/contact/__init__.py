"""Whether, when and where two moving bodies meet: a room for each pair of kinds of bodies.

polyhedra     two polyhedra
models        two solids of planes and quadrics
mesh_model    a polyhedron and a solid
ruled         two ruled surfaces
ruled_solid   a ruled surface and a solid
signs         what both of them share: contact by signs of polynomials in u, v, s and the time

table     who answers, and what is proved
ways      the ways to an answer, asked in order; rooms list theirs in `first`
reduce    polyhedra as solids of planes, where these are quicker
endless   spans without an end
centred   small bodies far from the origin
advancing   when heights meet of bodies that advance along the axis about which they turn
later     what answers tell of the place of contact when it is read
carried   answers for a question that was put elsewhere
named     elements of ruled surfaces by name
"""
