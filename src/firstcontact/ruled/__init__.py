"""Intersection curves of ruled surfaces.

intersection   the verb's pipeline
pieces         bounded pieces: parameter ranges, s in [0, 1], trimming
clipping       which parts of Delta = 0 belong to both pieces; overlaps of common rulings
coincident     Delta = 0 everywhere: surfaces that share an area, cones with one apex, parallel cylinders
tracing        polylines along the edges of the topology graph
"""
