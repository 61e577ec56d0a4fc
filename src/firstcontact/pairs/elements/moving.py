"""Vertices, edges and facets in any motion that is a rational function of one parameter u: exact conditions.

Elements of the moving body are homogeneous points x(u) = (x, y, z, w), polynomials in u with w > 0, times a common
scale; those of the other body rest and are whole numbers of the same scale.  Vertex against facet and edge against
edge are one determinant in u each (Schoemer & Thiel 1995, section 2); where it vanishes for all u (coplanar sliding,
parallel edges), contacts begin and end with events of lower dimension.  The formulas run on power series in u too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flint import arb_series, fmpz, fmpz_poly

from firstcontact.exact.fields.conditions import ParameterConditions
from firstcontact.exact.vectors import Vector, cross, dot, scaled, sub

if TYPE_CHECKING:
    from firstcontact.exact.ring import MatrixOf, Number

# A moving point: three polynomials and the weight.
Point = tuple[Vector, fmpz_poly]


def _seen(x: Point, p: Vector) -> Vector:
    """w (x - p)."""
    return sub(x[0], scaled(x[1], p))


def vertex_vertex(x: Point, p: Vector) -> list[ParameterConditions]:
    """When the moving point is at p."""
    return [ParameterConditions(_seen(x, p))]


def vertex_edge(x: Point, c: Vector, d: Vector) -> list[ParameterConditions]:
    """When the moving point is on the closed segment cd."""
    f = sub(d, c)
    if not any(f):
        return vertex_vertex(x, c)
    along = dot(_seen(x, c), f)
    return [ParameterConditions(cross(_seen(x, c), f), (along, x[1] * dot(f, f) - along))]


def vertex_facet(x: Point, a: Vector, b: Vector, c: Vector) -> list[ParameterConditions]:
    """When the moving point is in the closed triangle abc."""
    n = cross(sub(b, a), sub(c, a))
    if not any(n):
        return [*vertex_edge(x, a, b), *vertex_edge(x, b, c), *vertex_edge(x, c, a)]
    inside = tuple(dot(cross(n, sub(q, p)), _seen(x, p)) for p, q in ((a, b), (b, c), (c, a)))
    return [ParameterConditions((dot(n, _seen(x, a)),), inside)]


def edge_edge_crossing(x: Point, e: Vector, c: Vector, d: Vector) -> ParameterConditions:
    """When the moving segment from x to x + e/w meets the segment cd and is not parallel to it.

    With n = e x f and r = c - x the lines meet where r.n = 0, at lam = (r x f).n / n.n and mu = (r x e).n / n.n.
    """
    f, r = sub(d, c), scaled(-1, _seen(x, c))
    n = cross(e, f)
    square = dot(n, n)
    lam, mu = dot(cross(r, f), n), dot(cross(r, e), n)
    return ParameterConditions((dot(r, n),), (lam, square - lam, mu, square * x[1] - mu), (square,))


def above_facet(x: Point, a: Vector, b: Vector, c: Vector) -> arb_series:
    """The equation of `vertex_facet`: zero when the moving point is in the plane of abc."""
    return dot(cross(sub(b, a), sub(c, a)), _seen(x, a))


def above_line(x: Point, e: Vector, c: Vector, d: Vector) -> arb_series:
    """The equation of `edge_edge_crossing`, but for its sign."""
    return dot(_seen(x, c), cross(e, sub(d, c)))



def times(rows: MatrixOf[fmpz_poly], p: Vector, scale: fmpz | int) -> Point:
    """A pose (4x4 polynomials) applied to the point p / scale, times scale."""
    x, y, z = (row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3] * scale for row in rows[:3])
    return (x, y, z), rows[3][3]


def turned(rows: MatrixOf[Number], e: Vector) -> Vector:
    """The linear part of a pose applied to the vector e."""
    x, y, z = (row[0] * e[0] + row[1] * e[1] + row[2] * e[2] for row in rows[:3])
    return x, y, z
