"""Known first contacts, through doubles by every engine and through exact arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import firstcontact as fc
import naive
from agreement import polyhedron
from firstcontact import query
from vectors import VECTORS, Vector

ENGINES = [engine for engine in query.ENGINES if engine != "auto"]
KIND = {"v": "vertex", "e": "edge", "f": "face"}


def ask(case: Vector, exact: bool, engine: str) -> fc.FirstContact:
    a, b = polyhedron(case.a, name="moving"), polyhedron(case.b, name="resting")
    if case.translation is not None:
        span = (0, case.translation.get("T", math.inf))
        return fc.first_contact(a.moving(fc.Translation(case.translation["v"])), b, span, exact=exact, engine=engine)
    assert case.rotation is not None
    motion = fc.Rotation(case.rotation["axis"], point=case.rotation["point"], **case.total_angle())
    return fc.first_contact(a.moving(motion), b, exact=exact, engine=engine)


def expected_time(case: Vector) -> float:
    """The nearest double of the motion's parameter; for a rotation out of the 40 digits of the angle."""
    if case.translation is not None:
        return case.expected["t_float"]
    digits = case.expected["t_dec"]
    if float(digits) == 0:
        return 0.0
    ((unit, total),) = case.total_angle().items()

    def parameter():
        whole = 2 * arb.pi() * total if unit == "turns" else arb(naive.rational(total))
        return arb(digits, 1e-38) / whole

    return naive.nearest_double(parameter)


@pytest.mark.share(6)
@pytest.mark.parametrize(
    ("exact", "engine"), [(True, "boxes"), *((False, engine) for engine in ENGINES)], ids=["exact", *ENGINES]
)
@pytest.mark.parametrize("case", VECTORS, ids=lambda c: c.id)
def test_known_first_contact(case, exact, engine):
    hit, expected = ask(case, exact, engine), case.expected
    if not expected["hit"]:
        assert hit.status is fc.Status.FREE
        return
    assert hit.status is (fc.Status.CONTACT if expected_time(case) > 0 else fc.Status.INITIAL_CONTACT)
    assert hit.time == expected_time(case)
    lo, hi = hit.time_interval
    assert lo <= hit.time <= hi
    if exact and case.translation is not None:
        assert hit.time_exact == Fraction(expected["t"])
    if expected.get("point_unique", True):
        point = np.array([float(x) for x in expected["point"]])
        assert np.allclose(hit.point, point, rtol=1e-12, atol=1e-12)
    if hit.status is fc.Status.CONTACT and expected["multiplicity"] == 1:
        assert_feature(hit, expected)


def assert_feature(hit: fc.FirstContact, expected: dict) -> None:
    kinds, i, j = expected["feature"]
    assert (hit.element_a.kind, hit.element_a.index) == (KIND[kinds[0]], i)
    assert (hit.element_b.kind, hit.element_b.index) == (KIND[kinds[1]], j)
    assert hit.multiplicity == 1
    if expected["normal"] is None:
        assert hit.normal is None
    else:
        normal = np.array([float(x) for x in expected["normal"]])
        assert np.allclose(hit.normal, normal, rtol=0, atol=1e-12)


def test_the_cases_are_all_here():
    assert len(VECTORS) == len({c.id for c in VECTORS}) == 85
    assert sum(not c.exact_in_floats for c in VECTORS) > 0
