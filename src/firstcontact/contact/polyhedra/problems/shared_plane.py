"""Pairs that meet at one time under a translation, because all their corners lie in one plane then.

Where bodies meet flat, hundreds of pairs do: the plane is put to each of their corners once, in whole numbers, instead
of an equation of its own to each pair.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from flint import fmpq, fmpz

from firstcontact.exact.vectors import Vector, along, cross, dot, sub, whole, whole_doubles
from firstcontact.search.trees.elements import corners_of, vertices_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.contact.polyhedra.earliest import Pair

ZERO, ONE = fmpq(0), fmpz(1)


def in_its_plane(
    a: Polyhedron, b: Polyhedron, v: Vector, pair: Pair, t: fmpq, others: Sequence[Pair]
) -> list[Pair]:
    """Those of the others whose corners lie in the plane of the pair at the time t, when a has moved by t v; exact.

    t is a root of their equations then (`pairs.elements.coplanar`).  None where the pair has no plane.
    """
    if a.fractions is not None or b.fractions is not None:
        return []
    way = t * v[0], t * v[1], t * v[2]
    x, y = [along(p, t, v) for p in corners_of(a, pair[1])], corners_of(b, pair[2])
    e, f = [sub(p, x[0]) for p in x[1:]] + [sub(p, y[0]) for p in y[1:]]
    n = cross(e, f)
    if not any(n):
        return []
    of_a, of_b = [vertices_of(a, x) for _, x, _ in others], [vertices_of(b, y) for _, _, y in others]
    offset = dot(n, y[0])
    on_a = _on_plane(a, n, offset - dot(n, way), of_a)
    on_b = _on_plane(b, n, offset, of_b)
    return [
        other for other, p, q in zip(others, of_a, of_b, strict=True) if on_a.issuperset(p) and on_b.issuperset(q)
    ]


def _on_plane(body: Polyhedron, n: Vector, offset: fmpq, of: Iterable[list[int]]) -> set[int]:
    """Those of the vertices that lie in the plane n.x = offset."""
    asked = list({vertex for some in of for vertex in some})
    x, y, z, shift = zip(*body.matrix, strict=True)  # columns
    _, ((g0, g1, g2), (h, _, _)) = whole((dot(n, x), dot(n, y), dot(n, z)), (offset - dot(n, shift), ZERO, ZERO))
    scale, places = whole_doubles(body.base[asked].tolist(), ONE, int)
    i, j, k, end = int(g0), int(g1), int(g2), int(h) * scale
    return {vertex for vertex, (x, y, z) in zip(asked, places, strict=True) if i * x + j * y + k * z == end}
