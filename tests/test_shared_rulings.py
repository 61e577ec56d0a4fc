"""Rulings on one line, of pieces that are trimmed or cut by a box: what they share, against sampled membership."""

import math
import random
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpq_mat, fmpz_poly

import firstcontact as fc
from amount import amount
from firstcontact.exact.curves.line_sets import not_negative
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import real_roots
from firstcontact.pairs import apex_rulings, ruled_ruled

SADDLE = "(u, 0, 0)", "(u, 1, u)"
CIRCLE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"


def saddle(trim=(), bend="0", **bounds):
    """The saddle, bent by a polynomial at whose zeros it has the rulings of the saddle."""
    first, second = SADDLE
    return fc.RuledSurface(first, f"(u, 1, u + {bend})", **{"u": (-2, 2), **bounds}, trim=list(trim))


def pipe(trim=(), lo="0", hi="1", u=(-1, 1)):
    return fc.RuledSurface(CIRCLE.format(lo), CIRCLE.format(hi), u=u, trim=list(trim))


def parts(found):
    """((x, y0, y1), ...) of overlap lines along y, ascending."""
    return sorted((a[0], *sorted((a[1], b[1]))) for a, b in found.overlap_lines)


def test_where_polynomials_over_a_field_are_not_negative():
    """x^2 (x - r) (x - 3) <= 0 and x <= 5/2 with r = sqrt 2: [r, 5/2], and the double zero 0 is a point."""
    (root,) = real_roots(fmpz_poly([-2, 0, 1]), fmpq(1), fmpq(2))
    field = NumberField(root)
    r, zero = field.generator(), field(0)
    f = [zero, zero, -3 * r, r + 3, field(-1)]
    found = not_negative(field, [f, [field(fmpq(5, 2)), field(-1)], [field(7)]], 128)
    (a, b), (c, d) = found
    assert a is b and a.contains(0) and c.contains(root.enclosure(200)) and d.contains(fmpq(5, 2)) and c is not d
    assert not_negative(field, [[field(-1)]], 64) == []
    assert not_negative(field, [], 64) == [(None, None)]
    ((start, end),) = not_negative(field, [[-r, field(1)]], 64)
    assert start.contains(root.enclosure(200)) and end is None


def test_trimming_cuts_a_common_ruling():
    """At u = -r and r, r = sqrt 2, z = x y and z = (x + x^2 - 2) y share their rulings; u s <= 1/2 and s >= u/8."""
    found = fc.intersection_curve(saddle(["u*s <= 1/2"]), saddle(["s >= u/8"], "u**2 - 2"))
    r = math.sqrt(2)
    assert np.array(parts(found)) == pytest.approx(np.array([(-r, 0, 1), (r, r / 8, r / 4)]), rel=1e-15)


def test_trimming_may_leave_two_segments_and_a_point():
    other = fc.RuledSurface("(u, 0, -u)", "(u, 1, -2*u)", u=(-1, 1))
    two = fc.intersection_curve(saddle(["(s-1/4)*(s-3/4) >= 0"]), other)
    assert parts(two) == [(0, 0, 0.25), (0, 0.75, 1)]
    one = fc.intersection_curve(saddle(["(s-1/4)**2*(s-3/4) >= 0"]), other, box=((-1, "1/8", -1), (1, "7/8", 1)))
    assert parts(one) == [(0, 0.75, 0.875)] and one.isolated_points.tolist() == [[0, 0.25, 0]]


def test_a_box_cuts_whole_common_rulings():
    p, q = (saddle(bend=b, u=None, s=None) for b in ("0", "u**2 - 2"))
    found = fc.intersection_curve(p, q, box=((-2, -2, -2), (2, 2, 2)))
    r = math.sqrt(2)
    assert np.array(parts(found)) == pytest.approx(np.array([(-r, -r, r), (r, -r, r)]), rel=1e-15)


def test_a_trimmed_common_ruling_without_end_is_cut_far_away():
    found = fc.intersection_curve(saddle(["s >= 1/4"], s=None), saddle(bend="u**2 - 2", s=None))
    r = math.sqrt(2)
    assert len(found.overlap_lines) == 2
    for (start, end), x in zip(found.overlap_lines, (-r, r), strict=True):
        assert start == pytest.approx((x, 0.25, x / 4), rel=1e-15)
        assert (end - start) / np.linalg.norm(end - start) == pytest.approx(np.array((0, 1, x)) / math.sqrt(3))
        assert np.linalg.norm(end) > 50


@pytest.mark.parametrize(
    ("trim", "other", "box", "area"),
    [
        (["s <= u"], ["s <= 1/2"], None, True),
        (["s <= 1/4"], ["s >= 3/4"], None, False),
        (["(s-1/2)**2 + u**2 <= 1/16"], ["(s-1/2)**2 + (u-1/3)**2 <= 1/16"], None, True),
        (["(s-1/2)**2 + u**2 <= 1/16"], ["(s-1/2)**2 + (u-2/3)**2 <= 1/16"], None, False),
        ([], [], ((0, 0, "1/2"), (2, 2, 2)), True),
        ([], [], ((2, 0, "1/2"), (3, 2, 2)), False),
    ],
)
def test_patches_of_one_cylinder(trim, other, box, area):
    found = fc.intersection_curve(pipe(trim), pipe(other), box=box)
    assert found.two_dimensional is area and not found.branches and not len(found.overlap_lines)
    assert not len(found.isolated_points)


def test_patches_of_one_cylinder_that_touch():
    """Discs touch in a point; parts on both sides of s = u in that helix; a box in a generator."""
    disc = ["(s-1/2)**2 + u**2 <= 1/16"], ["(s-1/2)**2 + (u-1/2)**2 <= 1/16"]
    found = fc.intersection_curve(*map(pipe, disc))
    assert found.isolated_points == pytest.approx(np.array([[15 / 17, 8 / 17, 0.5]]), rel=1e-15)
    (branch,) = fc.intersection_curve(pipe(["s <= u"]), pipe(["s >= u"])).branches
    u, v, s, t = branch.parameters.T
    assert (u == v).all() and abs(s - u).max() < 1e-15 and abs(t - u).max() < 1e-15
    assert abs(branch.points - pipe().points(u, u)).max() < 1e-15
    assert [end.on for end in branch.ends] == [("s=0", "trim", "t=0"), ("u=1", "v=1", "s=1", "trim", "t=1")]
    found = fc.intersection_curve(pipe(), pipe(), box=((1, -1, "1/2"), (3, 2, 2)))
    assert found.overlap_lines.tolist() == [[[1, 0, 0.5], [1, 0, 1]]]


def test_a_trimmed_patch_that_touches_the_end_of_another():
    (branch,) = fc.intersection_curve(pipe(["s <= 1/2"]), pipe(lo="1/2", hi="5", u=None)).branches
    assert not branch.closed
    assert abs(branch.points[:, 2] - 0.5).max() < 1e-15 and abs(branch.parameters[:, 3]).max() < 1e-15


def test_a_bound_that_changes_sign_at_infinity():
    """u >= -1 leaves three quarters of the rim, up to the ruling at infinity."""
    (branch,) = fc.intersection_curve(pipe(["u >= -1"], u=None), pipe(lo="1", hi="5", u=None)).branches
    assert np.linalg.norm(np.diff(branch.points, axis=0), axis=1).sum() == pytest.approx(1.5 * math.pi, rel=1e-5)
    assert sorted(end.parameters[0] for end in branch.ends) == [-1, math.inf]


@pytest.mark.parametrize("top", ["1", "2"])
def test_a_cone_with_another_parameter(top):
    """Ends that rulings share all along, as at the tip, do not make infinity special in every parameter."""
    turned = CIRCLE.format(1).replace("u", "((u+1)/(u-2))")
    found = fc.intersection_curve(
        fc.RuledSurface("(0, 0, 0)", CIRCLE.format(1), u=None), fc.RuledSurface("(0, 0, 0)", turned, u=None, s=(0, top))
    )
    assert found.two_dimensional


@pytest.mark.parametrize(("trim", "points"), [("s <= 1/2", [[0, 0, 0]]), ("s >= 1/2", []), ("u*s >= 0", [[0, 0, 0]])])
def test_trimmed_cones_with_one_apex(trim, points):
    narrow = fc.RuledSurface("(0, 0, 0)", CIRCLE.format(1), u=None, trim=[trim])
    wide = fc.RuledSurface("(0, 0, 0)", "(2*(1-u**2)/(1+u**2), 6*u/(1+u**2), 1)", u=None)
    assert fc.intersection_curve(narrow, wide).isolated_points.tolist() == points


def through(points, scales):
    """(degree + 1, 3) coefficients of the directions that are scale times point at u = 0, 1, 2, ..."""
    n = len(points)
    powers = fmpq_mat(n, n, [fmpq(k) ** j for k in range(n) for j in range(n)])
    rows = fmpq_mat([[fmpq(x * scale) for x in p] for p, scale in zip(points, scales, strict=True)])
    return powers.solve(rows).tolist()


def cone(table):
    columns = [" + ".join(f"({row[k]})*u**{j}" for j, row in enumerate(table)) for k in range(3)]
    return fc.RuledSurface("(0, 0, 0)", f"({', '.join(columns)})", u=None, s=None)


@pytest.mark.parametrize("seed", range(3))
def test_dense_cones_with_one_apex_share_the_rulings_that_they_are_given(seed, monkeypatch):
    """Of degree 5: six are common by construction, at u = 0, ..., 5 and v = 5 - u; others are of degree 19 and were
    told by algebra over their fields, in half a minute."""
    monkeypatch.setattr(ruled_ruled, "_partners", lambda *_: pytest.fail("algebra over the field of a root"))
    rng = random.Random(seed)
    points = [[rng.randint(-9, 9) or 1 for _ in range(3)] for _ in range(6)]
    tables = [through(some, [rng.randint(1, 9) for _ in some]) for some in (points, points[::-1])]
    found = [
        (float(u), float(v)) for u, v in fc.intersection_curve(*map(cone, tables)).common_rulings
        if math.inf not in (u, v)
    ]  # fmt: skip
    assert {(k, 5 - k) for k in range(6)} <= set(found)
    for pair in found:
        x, y = (np.array(t, float).T @ np.array([c**j for j in range(6)]) for t, c in zip(tables, pair, strict=True))
        assert np.abs(np.cross(x, y)).max() <= 1e-9 * np.linalg.norm(x) * np.linalg.norm(y)


@pytest.mark.share(4)
@pytest.mark.parametrize("seed", range(20))
def test_rulings_through_one_apex_as_algebra_pairs_them(seed, monkeypatch):
    rng = random.Random(seed)
    p, q = (cone([[rng.randint(-3, 3) for _ in range(3)] for _ in range(n)]) for n in (3, rng.choice([3, 4])))

    def told():
        rulings = fc.intersection_curve(p, q).common_rulings
        return [(getattr(x, "polynomial", None), float(x)) for pair in rulings for x in pair]

    found = told()
    monkeypatch.setattr(apex_rulings, "partners", lambda *_: None)
    assert told() == found


def test_an_inequality_without_content_cuts_nothing():
    found = fc.intersection_curve(saddle(["0*s >= 0"]), fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)"))
    assert len(found.branches) == 1


def inequality(rng):
    a, b, c = (Fraction(rng.randint(-4, 4), rng.choice([1, 2, 4])) for _ in range(3))
    return rng.choice([
        (f"{a}*u + {b}*s >= {c}", lambda u, s: a * u + b * s - c),
        (f"u*s <= {c}", lambda u, s: c - u * s),
        (f"(s-1/2)**2 + (u-{a}/4)**2 <= 1/8", lambda u, s: 0.125 - (s - 0.5) ** 2 - (u - a / 4) ** 2),
        (f"(s-{a})*(s-{b}) >= 0", lambda u, s: (s - a) * (s - b)),
        (f"s**2 <= {b}*u + {c}", lambda u, s: b * u + c - s * s),
    ])  # fmt: skip


@pytest.mark.parametrize("seed", range(amount(60)))
def test_common_rulings_of_trimmed_saddles_against_samples(seed):
    """At u = +-1/2 the rulings coincide, y = s for one and y = 1 - 2 t for the other one."""
    rng = random.Random(seed)
    rules = [[inequality(rng) for _ in range(rng.randint(0, 2))] for _ in range(2)]
    (p_trim, p_rules), (q_trim, q_rules) = (([t for t, _ in own], [f for _, f in own]) for own in rules)
    other = "(u, 1, u + u**2 - 1/4)", "(u, -1, -u - u**2 + 1/4)"
    try:
        p, q = saddle(p_trim, u=(-1, 1)), fc.RuledSurface(*other, u=(-1, 1), trim=q_trim)
        found = fc.intersection_curve(p, q)
    except fc.InputError as error:
        assert "leaves nothing of the piece" in str(error)
        return
    for x in (-0.5, 0.5):
        for y in np.linspace(0.0007, 0.9993, 60):
            values = [f(x, y) for f in p_rules] + [f(x, (1 - y) / 2) for f in q_rules]
            on = any(abs(a[0] - x) < 1e-12 and min(a[1], b[1]) <= y <= max(a[1], b[1]) for a, b in found.overlap_lines)
            assert on == (min(values, default=1) >= 0), f"seed {seed}: y = {y} at x = {x}"


@pytest.mark.parametrize("method", ["algebraic", "certified"])
def test_a_point_of_a_common_ruling_is_one_however_it_rounds(method):
    """Rulings of one line that touch end to end in (6, 2, -2), told by u = 1/9 and by v = 0."""
    p = fc.RuledSurface(
        "((7/2 + 69/2*u)/(1 + 3*u), (-1/2 + 45/2*u)/(1 + 3*u), (-3 + 3*u)/(1 + 3*u))",
        "((9/2 + 63/2*u)/(1 + 3*u), (1/2 + 39/2*u)/(1 + 3*u), (-3 + 3*u)/(1 + 3*u))", u=(0, "1/3"), s=(1, 2),
    )  # fmt: skip
    q = fc.RuledSurface(
        "(9/2, 1/2 + 1/2*u, -2 - 3/2*u)", "(9003/2000, 1003/2000 + 999/2000*u, -2 - 2997/2000*u)", s=(-1000, 1000)
    )
    for pair in ((p, q), (q, p)):
        found = fc.intersection_curve(*pair, method=method)
        assert not len(found.overlap_lines) and not found.branches
        assert found.isolated_points.tolist() == [[6, 2, -2]]
