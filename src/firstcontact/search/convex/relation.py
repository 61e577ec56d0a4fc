"""How two solids at rest lie to each other."""

from __future__ import annotations

from enum import Enum


class Relation(Enum):
    """APART: no common point; NEAR: not proved to share an inner point or to be apart, and what depth or distance there
    is would be less than balls tell; OVERLAPPING: a common inner point.  The first and the last one are proved.
    """

    APART = "apart"
    NEAR = "near"
    OVERLAPPING = "overlapping"
