"""Two ruled surfaces.

first        `first`, the first contact, and `intervals`, all of them: the ways to both
certified    the search in doubles with proofs; `intervals` has all contacts by it
posed        surfaces in irrational poses
crossing     pieces ruled the other way, where rulings would lie on one line
triangles    polyhedra as ruled surfaces, triangle by triangle
contact_condition   the verb: the condition on u and T alone; `implicants` shortens it
"""
