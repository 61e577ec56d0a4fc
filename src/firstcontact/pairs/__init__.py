"""One file per pair of carriers; each holds the float face and the exact face of its formulas.

point_plane     vertex against facet
line_line       edge against edge
segment_facet   edge against facet at one instant
"""
