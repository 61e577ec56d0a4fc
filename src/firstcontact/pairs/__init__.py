"""One file per pair of carriers; each holds the float face and the exact face of its formulas.

point_plane     vertex against facet
line_line       edge against edge
segment_facet   edge against facet at one instant

Algebraic carriers under any rational motion, each with its contact equation and the contact set at one root
(`carrier_cases` is their table, `carrier_contact` what they share):

point_carriers       vertex against plane or quadric              VI
algebraic_points     vertex with algebraic coordinates            VI
line_line_carriers   line against line                            XI
line_conic           line against conic, in space or in a plane   IX, X
line_quadric         line against quadric                         V
conic_conic          two conics in space, or in one plane         VII, VIII (planar_conics)
conic_plane          conic against plane                          IV
conic_quadric        conic against quadric                        III
plane_quadric        plane against quadric                        II
quadric_quadric      two quadrics                                 I

Two ruled surfaces at rest: `ruled_ruled`, where two of their rulings meet, and where they are one line.
"""
