"""Ruled surfaces: intersection curves at rest, times of contact in motion.

resized        scenes far smaller or larger than 1, brought to that size for the search
intersection   the verb's pipeline
pieces         bounded pieces: parameter ranges, s in [0, 1], trimming
clipping       which parts of Delta = 0 belong to both pieces; overlaps of common rulings
coincident     Delta = 0 everywhere: surfaces that share an area, cones with one apex, parallel cylinders
tracing        polylines along the edges of the topology graph
certified_curve  curves of strips and high degrees in doubles with proofs
arcs           all arcs of delta = 0 that two surfaces share, by the kernels
open_places    what the kernels leave open
reach          how far out curves of whole rulings are looked for there
apex_rulings   rulings through an apex, along which Delta is zero but there is no curve
settled        pairs of pieces that are decided exactly where doubles leave places open
cut_out        surfaces in pieces about such places
edge_cusps, standstill_cusps   cusps on curves found in doubles
joined         both joined to branches and their graph
solid_verbs    the verb with solids and polyhedra: one curve for every piece (and facet), joined
solid_curve    the curve of a piece with a solid of planes and quadrics
facet_curve    the curve of a piece with a facet of a polyhedron of any shape
cover          cells of a piece: which facets may meet it
chains         strips as chains of parts in Bernstein form

moving         `first_contact` and `contact_intervals`: pieces of motion, results
conditions     when two rulings share a point, by signs of polynomials in u, v and T
sheets         elimination: the times at which contact may change
times          all times of contact of two pieces, cell by cell
exclusion      proofs of no contact in doubles
shared_points  exact contacts at one instant
touches        points and elements of contacts
solid_answers  which way answers for a surface and a solid of planes and quadrics
solid_conditions  what a solid holds of a piece, by signs of polynomials in u, s and T
solid_times    all times of contact of a piece and a solid
solid_touches  points and elements of contacts of a piece and a solid, and how they lie
trimmed        a place in every component of a trimmed piece
whole_rulings  whole rulings cut to segments that hold all within some reach
contact_condition   the verb: the condition on u and T alone
certified      answers of the certified search where elimination leads too far
"""
