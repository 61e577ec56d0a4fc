"""Two solids of planes and quadrics, by the algebra of Choi et al. 2014 and by certified search.

first           `first`, the first contact, and `intervals`, all of them: the ways to both
algorithm, subproblems, square_subproblems, system_search   contact equations of pairs of carriers and their roots
membership, contact_sets, largest_set, same_point, touched, flat_contacts   what is shared at a root, and on which faces
moving_pair, forms, kept_directions, idle_turns, advancing   two models as one moves beside the other
at_rest, last_instant   how they lie at one instant; standing: convex bodies that stay on one another
certified, intervals   the search with proofs in doubles and balls
answer, normals   results out of what was found
"""
