"""Candidates and proofs; no verbs.

trees     boxes swept in time, and the walks over two trees of them
convex    separation and advancement of convex pieces
events    events of features of solids and ruled surfaces
rulings   events of two ruled surfaces
levels    motions in levels: composed motions, linearised
lifted    the sub-quadratic engine in lifted space (Schömer & Thiel 1995)
sweep     the sweep of a plane over time
"""
