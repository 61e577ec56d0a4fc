"""Closed surfaces that become one at an instant: nothing bounds their faces, so no rim tells that they touch.

Truths are radii: of homothetic surfaces about one centre, those that grow by a factor g(t) meet when g(t) does.
"""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Status
from firstcontact.contact.models import algorithm
from firstcontact.pairs.carriers import quadric_quadric

EYE = np.eye(4, dtype=int).tolist()


def scaling(rate, power=1):
    """By the factor 1 + rate t^power about the origin."""
    grown = [[rate if i == j < 3 else 0 for j in range(4)] for i in range(4)]
    return fc.RationalMotion([EYE, *[[[0] * 4] * 4] * (power - 1), grown])


def shrinking_by(rate):
    """By the factor 1 / (1 + rate t), a projective form of an affine motion."""
    return fc.RationalMotion([EYE, [[rate if i == j == 3 else 0 for j in range(4)] for i in range(4)]])


BALL, SHELL, BLOCK = fc.sphere(1), fc.sphere(3) - fc.sphere(2), fc.box((30, 30, 30))
EGG = fc.ellipsoid((1, 2, 3)).rotated((1, 2, 2), degrees=180).translated((1, 0, 2))
NEST = BLOCK - fc.ellipsoid((2, 4, 6)).rotated((1, 2, 2), degrees=180).translated((1, 0, 2))
TWO = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -2]])  # a ball with the square of its radius 2
ABOUT = fc.RationalMotion(
    [EYE, [[2, 0, 0, -2], [0, 2, 0, 0], [0, 0, 2, -4], [0, 0, 0, 0]]]
)  # by 1 + 2 t about (1, 0, 2)
SCENES = {
    "shell that reaches a ball at the end": (SHELL.moving(scaling(F(-1, 2))), BALL, F(1)),
    "shell that reaches it just before": (SHELL.moving(scaling(F(-1001, 2000))), BALL, F(1000, 1001)),
    "shell that shrinks around a ball": (SHELL.moving(scaling(F(-3, 5))), BALL, F(5, 6)),
    "the same by a weight": (SHELL.moving(shrinking_by(3)), BALL, F(1, 3)),
    "ball that fills its cavity at the end": (BALL.moving(scaling(1)), BLOCK - fc.sphere(2), F(1)),
    "ball that outgrows its cavity": (BALL.moving(scaling(2)), BLOCK - fc.sphere(2), F(1, 2)),
    "egg in a nest": (EGG.moving(ABOUT), NEST, F(1, 2)),
    "box with a cavity that shrinks": ((BLOCK - fc.sphere(2)).moving(scaling(F(-3, 5))), BALL, F(5, 6)),
    "shell in a cavity": ((fc.sphere(2) - BALL).moving(scaling(2)), BLOCK - fc.sphere(3), F(1, 4)),
    "a radius that is no rational number": (BALL.moving(scaling(1, 2)), BLOCK - TWO, (2**0.5 - 1) ** 0.5),
}  # fmt: skip


@pytest.mark.share(11)
@pytest.mark.parametrize("swapped", [False, True], ids=["", "swapped"])
@pytest.mark.parametrize("name", SCENES)
def test_the_instant_is_told_by_all_ways(name, swapped):
    a, b, when = SCENES[name]
    a, b = (b, a) if swapped else (a, b)
    for way in ({}, {"exact": True}, {"method": "algebraic"}):
        hit = fc.first_contact(a, b, **way)
        assert hit.status is Status.CONTACT, way
        assert hit.time_interval[0] <= float(when) <= hit.time_interval[1]
        assert hit.contact_set == "patch"
        window = fc.contact_intervals(a, b, **({} if "method" in way else way))
        assert [(x.start, x.end) for x in window] == [(pytest.approx(float(when), abs=1e-15), 1.0)]


@pytest.mark.share(8)
@pytest.mark.parametrize("name", [name for name in SCENES if "end" not in name])
def test_certified_ways_never_miss_it(name):
    a, b, when = SCENES[name]
    hit = fc.first_contact(a, b, method="certified")
    assert hit.status is not Status.FREE
    assert hit.free_until <= float(when)
    window = fc.contact_intervals(a, b, method="certified")
    assert window.status is not Status.FREE
    assert window.free_until <= float(when)


def test_just_not_reached():
    """By 2^-40 of the factor: free, with all ways."""
    a, b = BALL.moving(scaling(1 - F(1, 2**40))), BLOCK - fc.sphere(2)
    for way in ({}, {"exact": True}):
        assert fc.first_contact(a, b, **way).status is Status.FREE
        assert fc.contact_intervals(a, b, **way).status is Status.FREE


ENDS = [(BALL.moving(scaling(2)), BLOCK - fc.sphere(2)), (SHELL.moving(scaling(F(-3, 5))), BALL)]


@pytest.mark.parametrize("pair", ENDS, ids=["ball", "shell"])
def test_surfaces_without_sections_are_left_open(pair, monkeypatch):
    """As those without a centre: that they become one is no proof that they share nothing."""
    monkeypatch.setattr(quadric_quadric, "central_sections", lambda *_: [])
    hit = fc.first_contact(*pair, exact=True)
    assert hit.status is Status.UNDECIDED
    assert hit.reason == "precision"


@pytest.mark.parametrize("pair", ENDS, ids=["ball", "shell"])
def test_a_candidate_that_is_wrongly_rejected_shows_at_the_end(pair, monkeypatch):
    """Both verbs look once after the last candidate: bodies that overlap there are not free."""
    monkeypatch.setattr(algorithm, "_validated", lambda candidate: ([], "forged"))
    assert fc.first_contact(*pair, exact=True).status is Status.UNDECIDED
    with pytest.raises(fc.UnsupportedPair, match="no candidate is a contact"):
        fc.contact_intervals(*pair, exact=True)
