"""The text of contact conditions says what `holds` says: thin contacts, instants, signs that need help, bad bodies."""

from __future__ import annotations

import random
from fractions import Fraction as F

import pytest
from flint import fmpq, fmpz_poly

import firstcontact as fc
from firstcontact.contact.signs.fibres import count
from firstcontact.contact.signs.times import roots_of
from firstcontact.exact.fields.roots import roots_in

CROSS = fc.RuledSurface("(-1, u, 0)", "(1, u, 0)", u=(-1, 1))
FLOOR = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1))


def says(condition, u, t):
    """The printed text as Python."""
    first, *rest = str(condition).replace("^", "**").splitlines()
    values = {"u": F(u), "T": F(t), "always": True, "never": False}
    for line in rest:
        if " = " in line and line.startswith("  R"):
            name, text = line.strip().split(" = ", 1)
            values[name] = eval(text, {}, values)
    return bool(eval(first.replace(" = ", " == "), {}, values))


def agree(condition, places):
    truth = {place: condition.holds(*place) for place in places}
    assert not [place for place in places if says(condition, *place) is not truth[place]]
    assert set(truth.values()) == {True, False}


def grid(u, t, n=8):
    return [(F(u) * i / n, F(t) * j / n) for i in range(-n, n + 1) for j in range(-n, n + 1)]


def test_parallel_rulings_that_meet_on_one_border_alone():
    """The text said "never": the border came from one pair of polynomials only."""
    bent = fc.RuledSurface("(0, u, u**2 + T)", "(1, u, u**2 + T)", u=(-2, 2))
    slope = fc.RuledSurface("(0, u, u)", "(1, u, u)", u=(-1, 1))
    condition = fc.contact_condition(bent, slope)
    places = [(u, t) for u, _ in grid(2, 1) for t in (u - u * u, u - u * u + F(1, 9))]
    assert all(condition.holds(u, t) is (t == u - u * u and abs(u) <= 1) for u, t in places)
    agree(condition, places)


@pytest.mark.share(2)
@pytest.mark.parametrize("length", ["2", "2/(5 - u)"])
def test_parallel_rulings_are_few_cells(length):
    """Every pair of brackets and coordinates made borders: tens of thousands of cells, half a minute."""
    low = "5*u + 3*(u**2 + T)", "2*u**2 + 2*T - u", "u - u**2 - T"
    bent = fc.RuledSurface(f"({', '.join(low)})", f"({low[0]} + 3, {low[1]} + 1, {low[2]} - 2)", u=(-2, 2))
    flat = fc.RuledSurface("(5*u, -u, u)", f"(5*u + 3*{length}, -u + {length}, u - 2*{length})", u=(-1, 2))
    condition = fc.contact_condition(bent, flat)
    assert len(condition.cells) < 1000
    places = [(u, t) for u, _ in grid(2, 1) for t in (-u * u, F(1, 3) - u * u)]
    assert all(condition.holds(u, t) is (t == -u * u and -1 <= u) for u, t in places)


def test_an_instant_far_from_all_other_times():
    flat = fc.RuledSurface("(u, -1, T - 1000)", "(u, 1, T - 1000)", u=(-1, 1))
    condition = fc.contact_condition(flat, CROSS)
    assert str(condition) == "R1 = 0\n  R1 = T - 1000\nfor some u: T = 1000"
    assert condition.intervals == ((1000, 1000),)
    assert condition.holds(0, 1000) and not condition.holds(0, 0)


def test_an_irrational_instant_is_printed():
    flat = fc.RuledSurface("(u, -1, 3*T**2 - 1)", "(u, 1, 3*T**2 - 1)", u=(-1, 1))
    lines = str(fc.contact_condition(flat, CROSS)).splitlines()
    assert lines[:2] == ["R1 = 0", "  R1 = 3*T^2 - 1"] and "does not decide" in lines[2]


def test_contact_on_a_curve_alone():
    rising = fc.RuledSurface("(u, -1, u**2 + T)", "(u, 1, u**2 + T)", u=(-2, 2))
    condition = fc.contact_condition(rising, FLOOR)
    assert str(condition).splitlines() == [
        "R1 >= 0 and R2 <= 0 and R3 = 0", "  R1 = u + 1", "  R2 = u - 1", "  R3 = u^2 + T", "for some u: -1 <= T <= 0"
    ]  # fmt: skip
    agree(condition, [*grid(1, 1), ("3/2", "-9/4"), (1, -1), ("-1/2", "-1/4")])


def test_one_ruling_at_all_times():
    tilted = fc.RuledSurface("(u - T, -1, u)", "(u + T, 1, u)", u=(-1, 1))
    condition = fc.contact_condition(tilted, FLOOR)
    agree(condition, grid(1, 2))


def test_signs_of_the_borders_alone_do_not_tell():
    """A region between the branches of a border; derivatives or lines part it from its like."""
    strip = fc.RuledSurface("(1 - 2*u, T - 2, u + 2)", "(1 - 2*u, T - 3, u)", s=("-1/2", "1/2"))
    fan = fc.RuledSurface("(2, -2, -1)", "((1 - u**2)/(1 + u**2), 2*u/(1 + u**2), 1)", u=(-2, 2), s=None)
    condition = fc.contact_condition(strip, fan)
    assert "see cells" not in str(condition)
    agree(condition, [(F(i, 4), F(j, 2)) for i in range(5) for j in range(2, 15)])


def test_whole_rulings_that_are_lost_at_an_instant():
    """At T = -1 both directrices have the same point at infinity: all other rulings lie in the plane x = 1."""
    piece = fc.RuledSurface("(0, T + 2, T + 1)", "(u*T - u, 1 - u, 2 - u)", u=("1/2", 2))
    lines = fc.RuledSurface("(1, 2 - u, 2 - 2*u)", "(u*T + u + T + 2, u - 2, 2*u - 2*T**2 + 2)", u=None, s=None)
    assert not fc.contact_condition(piece, lines).holds(1, -1)


@pytest.mark.parametrize(
    ("p", "q", "error", "text"),
    [
        (fc.sphere(1), CROSS, fc.UnsupportedPair, "two ruled surfaces, not for <CompositeQuadric"),
        (CROSS, None, fc.UnsupportedPair, "not for None"),
        (fc.RuledSurface("(u, -1, T)", "(u, 1, T)", trim="u <= s"), CROSS, fc.UnsupportedPair, "without trim"),
        (fc.RuledSurface("(u, 0, 0)", "(u, 1/(T - 5), T)", name="p"), CROSS, fc.InputError, "'p'"),
        (
            fc.RuledSurface("(u**2 + T*u, u, T)", "(u*T, u**2 - T, 1)", name="p"),
            fc.RuledSurface("(u**2, u*T, u)", "(1, u**2 + T**2, u*T)"), fc.UnsupportedPair, "lower their degrees",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(p, q, error, text):
    with pytest.raises(error) as caught:
        fc.contact_condition(p, q)
    assert text in str(caught.value) and "\n" not in str(caught.value)


def test_whole_rulings_through_infinity():
    """The lines x T + z = 1 over every y: at T = 0 one directrix is at infinity."""
    lines = fc.RuledSurface("(1/T, u, 0)", "(0, u, 1)", u=(-1, 1), s=None)
    piece = fc.RuledSurface("(u, 1/2, -2)", "(u, 1/3, 3)", u=(-1, 1))
    condition = fc.contact_condition(piece, lines)
    for u, t in grid(1, 8, 3):
        assert condition.holds(u, t) is (-2 <= 1 - u * t <= 3)
    assert fc.contact_intervals(piece, lines, (-1, 1), exact=True)[0].start_exact == -1


def test_roots_of_walls_are_those_of_their_product():
    """Each once, though walls share factors; a product of degree 208 took 600 times as long to factor as its walls."""
    rng = random.Random(7)
    for ends in (None, (fmpq(-1), fmpq(2))):
        for _ in range(40):
            shared = [fmpz_poly([rng.randint(-9, 9) for _ in range(rng.randint(1, 4))] + [rng.randint(1, 5)])
                      for _ in range(4)]  # fmt: skip
            walls = [rng.choice(shared) * rng.choice(shared) for _ in range(5)] + [fmpz_poly([3]), fmpz_poly([0])]
            product = walls[0] * walls[1] * walls[2] * walls[3] * walls[4]
            expected, found = roots_in(product, ends), roots_of(walls, ends)
            assert len(found) == len(expected)
            assert all(x.compare(y) == 0 for x, y in zip(found, expected, strict=True))
    assert roots_of([], None) == []


def test_thin_places_are_counted_where_rulings_may_meet_alone():
    """A cusp under a skew matrix, whose text took many seconds: doubles exclude most places on borders, and rightly."""
    skew = [[1, 1, 0, -1], [1, -1, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]]
    p = fc.RuledSurface("(u, 2*T-u, 0)", "(u, 2*T-u, 1)", u=(-1, 1))
    q = fc.RuledSurface("(u**2, u**3, T-2)", "(u**2, u**3, T-1)", u=(-1, F(1, 3)))
    condition = fc.contact_condition(p.transformed(skew), q.transformed(skew))
    places = [place for some in condition._doubtful_places(list(condition._text[0])).values() for place in some]
    left_out = [place for place in places if not condition._may_meet(*place)]
    assert len(left_out) > len(places) / 2
    assert all(count(condition._conditions, *place) == 0 for place in left_out[::61])
    assert str(condition) == "never\nfor some u: never"
