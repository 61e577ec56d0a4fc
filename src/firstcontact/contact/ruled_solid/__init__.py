"""A ruled surface and a solid of planes and quadrics.

first             which way answers
certified         the search in doubles with proofs
solid_conditions  what a solid holds of a piece, by signs of polynomials in u, s and T
solid_times       all times of contact of a piece and a solid
solid_touches     points and elements of contacts of a piece and a solid, and how they lie
lasting           contacts that last
level_pieces      flat pieces that stay level on a screw, of the room `ruled` too
"""
