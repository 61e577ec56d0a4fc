"""Algebraic carriers under any rational motion: contact equations and the contact set at one root (Choi et al. 2014).

`cases` is their table, `contact` what they share.

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
"""
