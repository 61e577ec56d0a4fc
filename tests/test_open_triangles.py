"""What doubles leave open of a mesh before a solid: exact arithmetic looks first at the triangles that may be first."""

from fractions import Fraction as F

import pytest

import firstcontact as fc
from firstcontact.search.convex.mesh_advance import MeshSearch, Open, Swept

WALLS = 6
"""Triangles across the way of a ball of radius 1, in x = 1, 2, ...; its centre starts in x = -5 at a speed of 30."""
MEETS = [F(k + 5, 30) for k in range(WALLS)]


def walls():
    corners = [(k + 1, y, z) for k in range(WALLS) for y, z in ((-9, -9), (9, -9), (0, 9))]
    return fc.Polyhedron(corners, [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(WALLS)])


@pytest.mark.parametrize("order", [range(WALLS), reversed(range(WALLS)), (3, 5, 0, 4, 1, 2)], ids=["", "back", "mixed"])
def test_the_first_of_the_triangles_that_are_open_is_told(monkeypatch, order):
    """The triangle that another piece may meet last of all was looked at first, and what is free beyond its contact
    ended the search: all others were left out as later ones, those before it too."""
    left = [Open(k, 0, float(MEETS[k]) - 0.03) for k in order] + [Open(3, 1, 0.95)]
    until = min(x.free_until for x in left)
    monkeypatch.setattr(MeshSearch, "run", lambda *_: Swept("open", until, open=left, reason="precision"))
    hit = fc.first_contact(fc.sphere(1).translated((-5, 0, 0)).moving(fc.Translation((30, 0, 0))), walls())
    assert hit.status is fc.Status.CONTACT and hit.element_b.index == 0
    assert hit.time_interval[0] <= MEETS[0] <= hit.time_interval[1]
