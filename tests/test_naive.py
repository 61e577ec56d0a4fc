"""The slow reference itself: known answers, and its pieces against each other."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, ctx

import naive
from amount import amount
from generators import lattice_scene
from vectors import VECTORS, Vector


def motion_of(case: Vector):
    if case.translation is not None:
        return naive.Shift(case.translation["v"]), case.translation.get("T")
    assert case.rotation is not None
    return naive.Turn(case.rotation["axis"], case.rotation["point"], **case.total_angle()), None


@pytest.mark.share(2)
@pytest.mark.parametrize("case", VECTORS, ids=lambda c: c.id)
def test_known_answer(case):
    motion, until = motion_of(case)
    status, time, _ = naive.first_contact(
        case.a.v, case.a.e, case.a.f, case.b.v, case.b.e, case.b.f, motion, until
    )
    expected = case.expected
    assert (status is not naive.FREE) == expected["hit"]
    if not expected["hit"]:
        return
    if case.translation is not None:
        assert time == naive.rational(expected["t"])
        assert motion.nearest(time) == expected["t_float"]
    else:
        assert naive.nearest_double(lambda: motion.angle(time)) == expected["t_float"]
        with ctx.workprec(200):
            assert abs(motion.angle(time) - arb(expected["t_dec"])) < arb(10) ** -35


def test_surd_arithmetic_and_signs():
    r = naive.square_root(naive.rational(2))
    x = 3 + 2 * r
    assert naive.sign(x * (3 - 2 * r) - 1) == 0
    assert naive.sign(1 / x - (3 - 2 * r)) == 0
    assert naive.sign(r - naive.rational(Fraction(99, 70))) == -1
    assert naive.sign(r - naive.rational(Fraction(140, 99))) == 1
    assert naive.square_root(naive.rational("9/4")) == naive.rational("3/2")


def test_order_of_angles_of_two_fields():
    turn = naive.Turn((0, 0, 1), turns=1)
    angles = [
        t for n in (1, 2, 3) for t in turn.solve(naive.rational(n), naive.rational(5), naive.rational(2))
    ]
    for s in angles:
        for t in angles:
            difference = float(turn.angle(s)) - float(turn.angle(t))
            assert turn.compare(s, t) == (0 if s is t else (difference > 0) - (difference < 0))


def test_parity_counts_a_cavity_as_outside():
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    cube = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    outer = [tuple(9 * x - 4 for x in p) for p in corners]
    shell = naive.shape(outer + corners, (), cube + [tuple(i + 8 for i in reversed(f)) for f in cube], True)
    half = naive.rational("1/2")
    assert not naive.inside((half, half, half), shell)
    assert naive.inside((half, half, naive.rational(2)), shell)
    assert naive.inside((half, half, naive.rational(1)), shell)
    assert not naive.inside((half, half, naive.rational(6)), shell)
    assert len(shell.components) == 2


@pytest.mark.share(2)
@pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
def test_intervals_against_poses_at_random(rotating):
    """The reference's intervals say what a static test of the posed bodies says."""
    met = 0
    for seed in range(amount(120, 4)):
        s = lattice_scene(seed, rotating)
        a, b = naive.shape(s.a.v, s.a.e, s.a.f), naive.shape(s.b.v, s.b.e, s.b.f)
        motion, until = naive.Shift(s.translation or (0, 0, 0)), 4
        if rotating:
            keys = {k: s.rotation[k] for k in ("axis", "point")}
            motion, until = naive.Turn(**keys, turns=1), None
        intervals = naive.contact_intervals(s.a.v, s.a.e, s.a.f, s.b.v, s.b.e, s.b.f, motion, until)
        for k in range(16):
            tau = naive.rational(Fraction(k * k + 1, 7 * k - 30))
            t = motion.half_tangent(tau) if rotating else naive.rational(Fraction(k, 4))
            listed = any(
                motion.compare(lo, t) <= 0 and (hi is None or motion.compare(t, hi) <= 0)
                for lo, hi in intervals
                if lo is not None
            )
            assert naive.bodies_meet(a.moved(motion.pose(t)), b) == listed, f"seed {seed}"
            met += listed
    assert met >= amount(120, 4) // 6
