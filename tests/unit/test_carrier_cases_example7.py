"""Example 7 of Choi et al. 2014: two capped elliptic cylinders, all 17 subproblems with times and multiplicities.

x^2/25 + y^2/100 <= 1, |z| <= 5.  A is translated, B rotates about y and is translated.  Faces FA1 (lateral), FA2
(z = -5), FA3 (z = 5); edges EA1 (z = -5), EA2 (z = 5); the same for B.
"""

from __future__ import annotations

from math import sqrt

import pytest
from flint import fmpz_poly

from carriers_by_hand import SPAN, candidates, diagonal, level, moved_plane, moved_quadric, points, pose
from firstcontact.exact.fields.roots import real_roots
from firstcontact.pairs.carriers import conic_conic, conic_plane, conic_quadric, quadric_quadric

M_A = pose((1, 0, 0, [30, -60]), (0, 1, 0, 20), (0, 0, 1, 0), (0, 0, 0, 1))
M_B = pose(
    ([0, 2, -2], 0, [1, -2], [30, -120, 180, -120]),
    (0, [1, -2, 2], 0, [-50, 180, -260, 160]),
    ([-1, 2], 0, [0, 2, -2], 0),
    (0, 0, 0, [1, -2, 2]),
)
CYLINDER = diagonal("1/25", "1/100", 0, -1)
ELLIPSE = diagonal("1/25", "1/100", -1)
F, E = {}, {}
for body, m in (("A", M_A), ("B", M_B)):
    F[f"F{body}1"] = moved_quadric(m, CYLINDER)
    F[f"F{body}2"], F[f"F{body}3"] = moved_plane(m, (0, 0, -1, -5)), moved_plane(m, (0, 0, 1, -5))
    E[f"E{body}1"], E[f"E{body}2"] = level(m, -5), level(m, 5)

RIM = 0.63411687034328004228
FIRST, LAST = 0.8 - sqrt(11) / 20, 0.8 + sqrt(11) / 20
RIM_TIMES = [(0, 2), (RIM, 1), (1, 4)]
CAP, FLAT = [(0, 1), (0.5, 2), (1, 1)], [(0, 1), (1, 1)]
TABLE = {
    ("FA1", "FB1"): [(0.5, 4), (0.625, 1), (0.875, 2)],
    ("FA1", "EB1"): RIM_TIMES,
    ("FA1", "EB2"): RIM_TIMES,
    ("FB1", "EA1"): RIM_TIMES,
    ("FB1", "EA2"): RIM_TIMES,
    ("FA2", "EB1"): CAP,
    ("FA3", "EB2"): CAP,
    ("FB2", "EA1"): CAP,
    ("FB3", "EA2"): CAP,
    ("FA2", "EB2"): FLAT,
    ("FA3", "EB1"): FLAT,
    ("FB2", "EA2"): FLAT,
    ("FB3", "EA1"): FLAT,
    ("EA1", "EB1"): [(0.5, 12), (FIRST, 1), (0.875, 2), (LAST, 1)],
    ("EA2", "EB2"): [(0.5, 12), (FIRST, 1), (0.875, 2), (LAST, 1)],
    ("EA1", "EB2"): [(0.5, 10), (0.875, 2)],
    ("EA2", "EB1"): [(0.5, 10), (0.875, 2)],
}


def solver(first: str, second: str):
    """(equation, contacts of a root) of one subproblem."""
    if first[0] == "E":
        sides = (E[first], ELLIPSE), (E[second], ELLIPSE)
        return conic_conic.equation(*sides), lambda root: conic_conic.contacts(*sides, root)
    if second[0] == "F":
        return quadric_quadric.equation(F[first], F[second]), lambda r: quadric_quadric.contacts(F[first], F[second], r)
    file = conic_quadric if first[2] == "1" else conic_plane
    carriers = E[second], ELLIPSE, F[first]
    return file.equation(*carriers), lambda root: file.contacts(*carriers, root)


def contacts_at(pair, t):
    equation, contacts = solver(*pair)
    (root,) = (r for r in real_roots(equation.candidates, *SPAN) if abs(float(r) - t) < 1e-12)
    return contacts(root)


@pytest.mark.parametrize("pair", TABLE)
def test_candidate_times_and_multiplicities(pair):
    found = candidates(solver(*pair)[0])
    assert [m for _, m in found] == [m for _, m in TABLE[pair]]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in TABLE[pair]], abs=1e-15)


def test_the_polynomial_of_the_lateral_faces():
    expected = fmpz_poly([1])
    for factor, power in (([-1, 2], 4), ([-9, 8], 1), ([-7, 8], 2), ([-5, 8], 1), ([1, -2, 2], 4)):
        expected *= fmpz_poly(factor) ** power
    found = solver("FA1", "FB1")[0].polynomial
    assert found.degree() == 16
    assert found * expected.leading_coefficient() == expected * found.leading_coefficient()


@pytest.mark.parametrize(
    ("pair", "t", "expected"),
    [
        (("FA1", "FB1"), 0.625, [(-7.5, 10, 0)]),
        (("FA1", "EB1"), RIM, [(-6.6230438022776, 10.414111633525, -4.952136929156)]),
        (("FA1", "EB2"), RIM, [(-9.470980638916, 10.414111633525, 4.952136929156)]),
        (("FB1", "EA1"), RIM, [(-6.8014817225836, 10.315237993937, -5)]),
        (("FB1", "EA2"), RIM, [(-9.29254271861, 10.315237993937, 5)]),
        (("FA1", "EB1"), 1, [(-25, 20, 0)]),
        (("FA1", "EB2"), 1, [(-35, 20, 0)]),
        (("EA1", "EB1"), FIRST, [(-6.70843802, 10.36675042, -5)]),
        (("EA2", "EB2"), FIRST, [(-9.39181323, 10.36675042, 5)]),
        (("FA3", "EB1"), 0, [(25, -50, 5)]),
        (("FA3", "EB1"), 1, [(-25, 30, 5)]),
    ],
)
def test_contact_points(pair, t, expected):
    """Rims on lateral faces: 40-digit Newton on a parametrised rim, G = dG/dtheta = 0 (a tangency; values printed to
    8 digits from a residual alone are 4e-5 off)."""
    found = points(contacts_at(pair, t))
    assert len(found) == len(expected)
    for x, y in zip(found, expected, strict=True):
        assert x == pytest.approx(y, abs=1e-9 if pair[0][0] == "F" else 6e-9)


def test_sides():
    assert [c.multiplier for c in contacts_at(("FA1", "FB1"), 0.625).found] == [-1]
    assert [c.multiplier for c in contacts_at(("FA1", "EB1"), RIM).found] == [-1]


@pytest.mark.parametrize(
    ("pair", "t", "reason"),
    [
        (("FA1", "FB1"), 0.5, "parallel axes: no common tangency"),
        (("FA1", "FB1"), 0.875, "crossing tangency"),
        (("FA1", "EB1"), 0, "imaginary"),
        (("FB1", "EA2"), 0, "imaginary"),
        (("EA1", "EB2"), 0.5, "planes parallel"),
        (("EA1", "EB2"), 0.875, "imaginary"),
        (("EA1", "EB1"), 0.5, "coplanar: no common point"),
    ],
)
def test_roots_without_contact(pair, t, reason):
    found = contacts_at(pair, t)
    assert (found.found, found.reason) == ((), reason)


def test_rims_that_cross_in_two_points():
    t = 0.875
    found = points(contacts_at(("EA1", "EB1"), t))
    assert len(found) == 2 and found[0] != found[1]
    w = 2 * t * t - 2 * t + 1
    c, s = 2 * t * (1 - t) / w, (1 - 2 * t) / w
    for x, y, z in found:
        x -= 30 - 60 * t
        assert z == pytest.approx(-5, abs=1e-12)
        assert x * x / 25 + (y - 20) ** 2 / 100 == pytest.approx(1, abs=1e-12)
        local = c * x - s * z
        assert s * x + c * z == pytest.approx(-5, abs=1e-12)
        assert local * local / 25 + (y - 80 * t + 50) ** 2 / 100 == pytest.approx(1, abs=1e-12)


def test_a_rim_in_the_plane_of_a_cap():
    (contact,) = contacts_at(("FA2", "EB1"), 0.5).found
    assert (contact.kind, contact.note) == ("conic", "coplanar")
