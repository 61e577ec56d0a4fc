"""Contact of pieces of ruled surfaces by signs of polynomials: exact, by elimination.

pieces         bounded pieces: parameter ranges, s in [0, 1], trimming
conditions     when two rulings share a point, by signs of polynomials in u, v and T
forced         the equation that takes Delta's place where all rulings are parallel
sheets         elimination: the times at which contact may change
times          all times of contact of two pieces, cell by cell
exclusion      proofs of no contact in doubles
shared_points  exact contacts at one instant
touches        points and elements of contacts
starts         the start of a span, where the motions have no exact times
trimmed        a place in every component of a trimmed piece
fibres         how many rulings of one surface meet a ruling of the other
whole_rulings  whole rulings cut to segments that hold all within some reach
"""
