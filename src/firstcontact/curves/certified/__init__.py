"""The curve of two ruled surfaces in doubles with proofs.

certified_curve  the pipeline
arcs           all arcs of delta = 0 that two surfaces share, by the kernels
open_places    what the kernels leave open
settled        pairs of pieces that are decided exactly where doubles leave places open
cut_out        surfaces in pieces about such places
reach          how far out curves of whole rulings are looked for
edge_cusps, standstill_cusps   cusps on curves found in doubles
joined         arcs joined to branches and their graph
chains         strips as chains of parts in Bernstein form
cover          cells of a piece: which facets may meet it
"""
