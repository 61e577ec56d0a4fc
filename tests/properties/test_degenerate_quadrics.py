"""Curved solids in special positions: coaxial, parallel, concentric, of equal radii, tangent at the start.

Both paths have to give the same answer, and where the first contact has a closed form, that one.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import firstcontact as fc
from amount import amount
from curved import rational_turn

Status = fc.Status
step, radius = st.integers(-4, 4), st.sampled_from([1, 2])
vector = st.tuples(step, step, step)


def both_paths(a, b):
    """The answer of the certified path (or of what it falls back to), checked against the algebraic one."""
    hit, other = fc.first_contact(a, b), fc.first_contact(a, b, method="algebraic")
    assert (hit.status, hit.initial) == (other.status, other.initial)
    if hit.status is Status.CONTACT:
        (lo, hi), (other_lo, other_hi) = hit.time_interval, other.time_interval
        assert lo <= other_hi and other_lo <= hi and hi - lo <= 1e-12
    return hit


def near(start, speed, reach) -> tuple[Fraction, Fraction] | None:
    """Both ends of {t in [0, 1]: |start + speed t| <= reach}; None if empty.  Exact but for one square root."""
    a, b = sum(v * v for v in speed), sum(s * v for s, v in zip(start, speed, strict=True))
    c = sum(s * s for s in start) - reach * reach
    if a == 0:
        return (Fraction(0), Fraction(1)) if c <= 0 else None
    if b * b < a * c:
        return None
    root = Fraction(isqrt((b * b - a * c) << 200), 1 << 100)
    first, last = max(Fraction(0), (-b - root) / a), min(Fraction(1), (-b + root) / a)
    return (first, last) if first <= last else None


def expect(hit, spans, overlapping: bool):
    """spans: the bodies touch when t is in all of them; overlapping: whether their interiors do at the start."""
    first = max((s[0] for s in spans if s), default=None)
    if not all(spans) or first > min(s[1] for s in spans):
        assert hit.status is Status.FREE
    elif first == 0:
        assert hit.status is Status.INITIAL_CONTACT and hit.time == 0
        assert (hit.initial == "touching") != overlapping
    else:
        assert hit.status is Status.CONTACT and hit.time == pytest.approx(float(first), abs=1e-12)


@settings(max_examples=amount(60))
@given(radius, radius, vector, vector)
def test_balls(r, s, start, v):
    a, b = fc.sphere(r).translated(start), fc.sphere(s)
    inside = sum(x * x for x in start) < (r + s) ** 2
    expect(both_paths(a.moving(fc.Translation(v)), b), [near(start, v, r + s)], inside)


@settings(max_examples=amount(60))
@given(radius, radius, vector, vector)
def test_upright_cylinders(r, s, start, v):
    """Coaxial and parallel ones, side to side, end to end and rim to rim; they touch when near both ways."""
    a, b = fc.cylinder(r, 2).translated(start), fc.cylinder(s, 2)
    inside = start[0] ** 2 + start[1] ** 2 < (r + s) ** 2 and abs(start[2]) < 2
    spans = [near(start[:2], v[:2], r + s), near(start[2:], v[2:], 2)]
    expect(both_paths(a.moving(fc.Translation(v)), b), spans, inside)


BALL = fc.sphere(1).translated((2, 0, 0))
CROSSED = fc.cylinder(1, 6).rotated((1, 0, 0), degrees=90).translated((2, 0, 0))
REST, UP = fc.Translation((0, 0, 0)), fc.Translation((0, 0, 1))


@pytest.mark.share(9)
@pytest.mark.parametrize(
    ("a", "b"),
    [
        (BALL.moving(REST), fc.sphere(1)),
        (BALL.moving(UP), fc.sphere(1).moving(UP)),
        (BALL.moving(rational_turn((0, 0, 1))), fc.sphere(1)),
        (BALL.moving(fc.Rotation((0, 0, 1), degrees=90)), fc.sphere(1)),
        (BALL.moving(REST), fc.ellipsoid((1, 2, 3))),
        (BALL.moving(UP), fc.cylinder(1, 6)),
        (CROSSED.moving(UP), fc.cylinder(1, 6)),
    ],
    ids=["at rest", "alike", "around", "around, at constant speed", "ellipsoid", "on a cylinder", "crossed cylinders"],
)
def test_contact_that_lasts_is_contact(a, b):
    """No root of a contact equation tells of it."""
    hit = both_paths(a, b)
    assert hit.initial == "touching"
    (always,) = fc.contact_intervals(a, b)
    assert (always.start, always.end) == (0, 1)


SOLIDS = st.sampled_from([
    fc.sphere(1), fc.cylinder(1, 2), fc.cylinder((1, 2), 2), fc.cone(1, 2), fc.ellipsoid((1, 1, 2)), fc.box((2, 2, 2)),
])  # fmt: skip


@settings(max_examples=amount(40))
@given(SOLIDS, SOLIDS, vector, vector)
def test_solids_on_a_lattice(a, b, start, v):
    both_paths(a.translated(start).moving(fc.Translation(v)), b)


@settings(max_examples=amount(30))
@given(SOLIDS, SOLIDS, vector, st.sampled_from([(0, 0, 1), (1, 0, 0), (0, 1, 1)]), st.tuples(step, step, st.just(0)))
def test_solids_that_turn(a, b, start, axis, point):
    both_paths(a.translated(start).moving(rational_turn(axis, point)), b)
