"""The curve of two ruled surfaces by exact elimination.

intersection   the pipeline
clipping       which parts of Delta = 0 belong to both pieces; overlaps of common rulings
coincident     Delta = 0 everywhere: surfaces that share an area, cones with one apex, parallel cylinders
apex_rulings   rulings through an apex, along which Delta is zero but there is no curve
shared_families, shared_rulings, piece_borders   what is common beside curves
branches, cusps, spots   parts of the answer
tracing        polylines along the edges of the topology graph
answer         the result out of them
"""
