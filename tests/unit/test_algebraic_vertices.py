"""Vertices without rational coordinates: numbers of two algebraic numbers, contact equations by norms, apexes."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpz_poly

import firstcontact as fc
from firstcontact.body.solid.carriers import AlgebraicPoint
from firstcontact.contact.models.algorithm import CandidateSearch
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.exact.fields.field_towers import TowerElement
from firstcontact.exact.fields.number_field import NumberField, ball, is_zero, sign
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.motion.relative.polynomial import relative_pieces


def root(coefficients, lo, hi) -> AlgebraicRoot:
    (found,) = real_roots(fmpz_poly(coefficients), fmpq(lo), fmpq(hi))
    return found


def search(a, b) -> CandidateSearch:
    """Over [0, 1]; the motions have one piece."""
    bodies = [getattr(x, "body", x) for x in (a, b)]
    (piece,) = relative_pieces(a, b, fmpq(0), fmpq(1))
    return CandidateSearch(MovingPair(*bodies, piece))


SQRT2 = NumberField(root([-2, 0, 1], 0, 2))
S = root([-8, 0, 1], 0, 4)  # 2 sqrt 2, of degree 1 over the field


def tower(*coefficients) -> TowerElement:
    return TowerElement(SQRT2, S, [SQRT2(fmpz_poly(c)) for c in coefficients])


def test_zeros_are_seen_where_the_minimal_polynomial_splits():
    assert is_zero(tower([0, -2], [1])) and sign(tower([0, 2], [1])) == 1
    x = tower([0, -2], [1], [3]) - 24
    assert sign(x) == 0 and sign(x + fmpq(1, 10**40)) == 1 and sign(-x - fmpq(1, 10**40)) == -1
    assert float(ball(tower([1], [0, 1]), 64).mid()) == pytest.approx(5)


def test_arithmetic_follows_both_roots():
    r, s = math.sqrt(2), math.sqrt(8)
    x, y = tower([1, 3], [2]), tower([-5], [0, 1], [1, 1])
    for found, expected in (
        (x + y, 1 + 3 * r + 2 * s - 5 + r * s + (1 + r) * 8),
        (x - y, 1 + 3 * r + 2 * s + 5 - r * s - (1 + r) * 8),
        (x * y, (1 + 3 * r + 2 * s) * (-5 + r * s + (1 + r) * 8)),
        (2 - x * SQRT2.generator(), 2 - (1 + 3 * r + 2 * s) * r),
    ):
        assert float(ball(found, 64).mid()) == pytest.approx(expected, rel=1e-14)


def test_elements_of_different_towers_do_not_mix():
    other = TowerElement(SQRT2, root([-8, 0, 1], -4, 0), [SQRT2(0), SQRT2(1)])
    with pytest.raises(TypeError):
        other + tower([1])


def half_disc():
    """The part x >= 1/3 of a cylinder of radius 1: its corners have y = +-sqrt(8) / 3."""
    return (fc.cylinder(1, 2) & fc.box((1, 4, 4)).translated((Fraction(5, 6), 0, 0))).named("half")


def test_only_the_vertex_that_meets_the_plane_is_a_contact():
    a = half_disc()
    assert all(isinstance(v.carrier, AlgebraicPoint) for v in a.vertices)
    b = fc.box((1, 9, 9)).rotated((0, 0, 1), degrees=30).rotated((1, 0, 0), degrees=20).translated((-2, 0, 0))
    found = search(a.moving(fc.Translation((-3, 0, 0))), b)
    (meeting,) = found.first()
    # N.(V - 3 t e) = 0 for the face's plane and the vertex at (1/3, -sqrt(8)/3, -1)
    face = meeting.candidate.subproblem.b
    n = np.array([float(c) for c in face.carrier.normal])
    v = np.array([1 / 3, -math.sqrt(8) / 3, -1])
    t = (n[:3] @ v + n[3]) / (3 * n[0])
    assert float(meeting.candidate.root) == pytest.approx(t, abs=1e-14)
    assert np.allclose(meeting.shared.points, [v - [3 * t, 0, 0]], atol=1e-14)
    reasons = [found.verdict(c)[1] for c in found.candidates]
    assert "another conjugate of the vertex" in reasons


def test_a_vertex_meets_a_sphere_at_the_root_of_the_norm():
    a, b = half_disc(), fc.sphere(Fraction(1, 2)).translated((Fraction(-1, 5), 1, Fraction(11, 10)))
    (meeting,) = search(a.moving(fc.Translation((Fraction(-1, 2), 0, 0))), b).first()
    x = -0.2 + math.sqrt(0.25 - (1 - math.sqrt(8) / 3) ** 2 - 0.01)
    assert float(meeting.candidate.root) == pytest.approx((1 / 3 - x) / 0.5, abs=1e-14)
    assert meeting.candidate.root.polynomial.degree() == 4


def test_a_form_that_is_rational_at_the_vertex_is_met_by_all_conjugates():
    b = fc.box((1, 9, 9)).translated((-2, 0, 0))
    meetings = search(half_disc().moving(fc.Translation((-3, 0, 0))), b).first()
    assert {float(m.candidate.root) for m in meetings} == {float(Fraction(11, 18))}
    assert len({m.candidate.subproblem.a.index for m in meetings}) == 4


def test_cones_that_share_a_generator_meet_at_their_apexes():
    a = fc.cone(1, 1)
    b = fc.cone(1, 1).rotated((1, 0, 0), degrees=180).translated((-2, 0, 4))
    meetings = search(a, b.moving(fc.Translation((2, 0, -2)))).first()
    assert {float(m.candidate.root) for m in meetings} == {1.0}
    assert np.allclose([m.shared.points[0] for m in meetings], b.vertices[0].position)
