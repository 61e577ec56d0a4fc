"""Tools along programs: G-code in three axes, APT / CL in five.

tool        a stack of cylinders and cones
moves       straight ways, arcs, swings of the axis: exact motions, and places in doubles with bounds
blocks      what readers tell: a line and its ways
gcode, cycles, cl   the readers
program     a file of either kind
rules       what may touch
walk        hulls of a segment's places before a mesh, compiled
check       blocks against bodies: hulls first, exact solids for the rest
"""
