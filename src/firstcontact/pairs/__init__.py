"""Pairs of elements and of carriers: when they meet, one file per pair with both faces of its formulas.

elements    vertices, edges and facets of polyhedra
carriers    points, lines, conics, planes and quadrics under any rational motion

ruled_ruled   two ruled surfaces at rest: where two of their rulings meet
"""
