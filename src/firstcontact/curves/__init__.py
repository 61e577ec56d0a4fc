"""Intersection curves of surfaces at rest.

ruled        the verb, with two ruled surfaces
exactly      by the topology of Delta = 0 (Chen, Shen, Yuan 2011)
certified    in doubles with proofs, for strips and high degrees
with_solids  of a ruled surface with solids and polyhedra
placed      scenes far smaller or larger than 1, brought to that size for the search
lone_points  whether a point that was found alone lies on a branch
"""
