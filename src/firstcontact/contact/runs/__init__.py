"""Motions of many stretches: asked about only while bodies may be near each other.

`near` tells when that is, `linked` asks about links of mechanisms, `along` about long trajectories.
"""
