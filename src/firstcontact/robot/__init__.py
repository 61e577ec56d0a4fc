"""Robots: mechanisms read from URDF and SRDF (extra `robot`).

checked     what a description must say
packages    where the files are that a description names
urdf        links with their shapes, joints
srdf        pairs of links that are not asked about
robot       the mechanism of a description
"""
