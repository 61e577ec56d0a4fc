"""Motions of many stretches: asked about only while bodies may be near each other, or once for all alike.

`near` tells when that is, `linked` asks about links of mechanisms, `along` about long trajectories, `turns` about one
of many full turns; `seams` makes one answer of the intervals of all parts.
"""
