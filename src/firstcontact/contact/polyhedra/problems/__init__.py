"""What every kind of motion gives to a search of two polyhedra, and to the ways to search.

problem                chooses; the others are one for each kind of motion
by_trees               walks over trees of boxes, which all of them are asked by
composed_problem, lifted_problem, sweep_problem   translations and rotations by these engines
"""
