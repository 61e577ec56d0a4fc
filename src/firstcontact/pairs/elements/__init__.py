"""Vertices, edges and facets.

point_plane, point_plane_rotation   vertex against facet
line_line, line_line_rotation       edge against edge
point_line, point_line_rotation     vertex against edge
segment_facet   edge against facet at one instant
coplanar        facets and edges in one plane
moving          any of them under a curved motion
"""
