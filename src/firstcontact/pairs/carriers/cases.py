"""The table of pairs: which of the eleven cases of Choi et al. 2014 serves two carriers, and which pairs need none.

Kinds are "point", "line", "conic", "plane" and "quadric"; a pair is looked up with the simpler kind first, and its file
takes the carriers in that order.  Exempt pairs see no first contact of two bounded solids that no other pair sees.
"""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("point", "line", "conic", "plane", "quadric")


@dataclass(frozen=True)
class Case:
    """`number` of the case ("I" to "XI") and `file`, the module here with its equation and contact points.

    planar: the case that takes over where both carriers lie in one plane.
    """

    number: str
    file: str
    planar: str = ""


@dataclass(frozen=True)
class Exempt:
    reason: str


PAIRS: dict[tuple[str, str], Case | Exempt] = {
    ("quadric", "quadric"): Case("I", "quadric_quadric"),
    ("plane", "quadric"): Case("II", "plane_quadric"),
    ("conic", "quadric"): Case("III", "conic_quadric"),
    ("conic", "plane"): Case("IV", "conic_plane"),
    ("line", "quadric"): Case("V", "line_quadric"),
    ("point", "quadric"): Case("VI", "point_carriers"),
    ("point", "plane"): Case("VI", "point_carriers"),
    ("conic", "conic"): Case("VII", "conic_conic", planar="VIII"),
    ("line", "conic"): Case("IX", "line_conic", planar="X"),
    ("line", "line"): Case("XI", "line_line_carriers"),
    ("plane", "plane"): Exempt("a flat contact contains a boundary point of one of the faces"),
    ("line", "plane"): Exempt("an edge that touches a plane face has an end or crosses an edge of the face there"),
    ("point", "line"): Exempt("a vertex on an edge lies on both faces of that edge"),
    ("point", "conic"): Exempt("a vertex on an edge lies on both faces of that edge"),
    ("point", "point"): Exempt("a vertex lies on the faces around it"),
}

POINTS = ("algebraic point", "enclosed point")
"""Vertices without rational coordinates: the pairs of "point", in other files."""


def case_of(kind_a: str, kind_b: str) -> Case | Exempt:
    """The entry of `PAIRS` for two kinds in either order."""
    kinds = ("point" if kind in POINTS else kind for kind in (kind_a, kind_b))
    first, second = sorted(kinds, key=KINDS.index)
    return PAIRS[first, second]
