"""Brackets: known segments, and degenerate configurations against a test that uses no brackets."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq, fmpz, fmpz_poly

import firstcontact as fc
from firstcontact import brackets
from firstcontact.exact import brackets as exact
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import real_roots
from ruled_vectors import cases

ORDERS = [(0, 1, 2, 3), (1, 0, 2, 3), (0, 1, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0)]
N = 100_000


# -- vectors ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", cases("segments"), ids=lambda c: c["id"])
@pytest.mark.parametrize("order", ORDERS, ids=str)
def test_known_segments(case, order):
    points = [(case["p1"], case["p2"], case["q1"], case["q2"])[k] for k in order]
    expected = case["expected"]
    assert brackets.lines_relation(*points).kind == expected["lines"]
    found = brackets.segments_relation(*points)
    assert found.kind == expected["segments"]
    if found.kind == "overlap":
        wanted = sorted(tuple(map(F, end)) for end in expected["result"])
        assert sorted(found.segment) == wanted
        assert sign_of(found.segment[1], found.segment[0], points[0], points[1]) > 0
        ends = list(zip(found.segment, found.s, found.t, strict=True))
    elif expected["result"] is None:
        assert found.point is None and found.s is None
        return
    else:
        assert found.point == tuple(map(F, expected["result"]))
        ends = [(found.point, found.s, found.t)]
    for x, s, t in ends:
        assert x == between(points[0], points[1], s) == between(points[2], points[3], t)


def sign_of(a, b, p1, p2):
    return sum((x - y) * (q - p) for x, y, p, q in zip(a, b, p1, p2, strict=True))


def between(a, b, t):
    return tuple(F(x) + t * (F(y) - F(x)) for x, y in zip(a, b, strict=True))


def test_arrays_of_the_known_segments():
    rows = [np.array([case[key] for case in cases("segments")]) for key in ("p1", "p2", "q1", "q2")]
    segments, lines = brackets.segments_relations(*rows), brackets.lines_relations(*rows)
    assert segments.kinds.tolist() == [case["expected"]["segments"] for case in cases("segments")]
    assert lines.kinds.tolist() == [case["expected"]["lines"] for case in cases("segments")]
    assert segments.exact_evaluations == lines.exact_evaluations == 0
    assert lines.parallel.tolist() == [
        brackets.lines_relation(*(case[key] for key in ("p1", "p2", "q1", "q2"))).parallel
        for case in cases("segments")
    ]


# -- points for segments, numbers of all kinds --------------------------------------------------------------


@pytest.mark.parametrize(
    ("p1", "p2", "q1", "q2", "kind", "s", "t"),
    [
        ((1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 1, 1), "point", 0, 0),
        ((1, 1, 1), (1, 1, 1), (1, 1, 2), (1, 1, 2), "separate", None, None),
        ((1, 1, 1), (1, 1, 1), (0, 0, 0), (4, 4, 4), "point", 0, F(1, 4)),
        ((0, 0, 0), (4, 4, 4), (3, 3, 3), (3, 3, 3), "point", F(3, 4), 0),
        ((5, 5, 5), (5, 5, 5), (0, 0, 0), (4, 4, 4), "separate", None, None),
        ((1, 1, 0), (1, 1, 0), (0, 0, 0), (4, 4, 4), "separate", None, None),
        ((4, 4, 4), (4, 4, 4), (0, 0, 0), (4, 4, 4), "point", 0, 1),
    ],
)
def test_a_segment_may_be_a_point(p1, p2, q1, q2, kind, s, t):
    found = brackets.segments_relation(p1, p2, q1, q2)
    assert (found.kind, found.s, found.t) == (kind, s, t)
    fast = brackets.segments_relations(p1, p2, q1, q2)
    assert fast.kinds.tolist() == [kind] and fast.exact_evaluations == 0
    assert kind == "separate" or (fast.s[0], fast.t[0]) == (s, t)
    slow = brackets.segments_relations(*(np.array(x) / 3 for x in (p1, p2, q1, q2)))
    assert slow.kinds.tolist() == [kind]


def test_points_with_algebraic_coordinates():
    """Diagonals of a rectangle 1 by sqrt(2), whose crossing is no rational point."""
    (root,) = real_roots(fmpz_poly([-2, 0, 1]), fmpq(0), fmpq(2))
    field = NumberField(root)
    r = field.generator()
    corners = ((r * 0, r * 0, r * 0), (r * 0 + 1, r, r * 0), (r * 0 + 1, r * 0, r * 0), (r * 0, r, r * 0))
    met = exact.segments_relation(*corners)
    assert met.kind == "point" and met.s == fmpq(1, 2) and met.point[1] * 2 == r
    assert exact.segments_relation(corners[0], corners[1], corners[1], (r + 1, r * r, r * 0)).kind == "point"
    twice = tuple(x * r for x in corners[1])
    assert exact.segments_relation(corners[0], corners[1], corners[1], twice).kind == "overlap_point"
    assert exact.lines_relation(corners[0], corners[1], corners[2], (r * 0 + 2, r, r * 0)).parallel
    assert brackets.bracket3(*corners[:3], 2) == -r


def test_signs_and_their_conventions():
    corners = (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)
    assert brackets.bracket4(*corners) == -1
    assert brackets.bracket4(*(corners[k] for k in (1, 0, 2, 3))) == 1
    assert brackets.bracket3(*corners[:3], 2) == 1 and brackets.bracket3(*corners[:3], 0) == 0
    assert brackets.bracket2((2, 2, 2), (1, 1, 1), (1, 1, 1)) == 3
    assert brackets.projection((0, 0, 0), (1, 1, 1), (2, 2, 2), (5, 5, 5)) is None
    assert brackets.bracket4(("1/3", 0.5, F(1, 7)), *corners[1:]) == F(1, 3) + F(1, 2) + F(1, 7) - 1


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: brackets.lines_relation((0, 0, 0), (0, 0, 0), (1, 0, 0), (2, 0, 0)), "p1 and p2 are equal"),
        (lambda: brackets.segments_relation((0, 0), (0, 0, 0), (1, 0, 0), (2, 0, 0)), "p1 is (0, 0)"),
        (lambda: brackets.bracket4((0, 0, 0), (0, 0, float("nan")), (1, 0, 0), (2, 0, 0)), r"b[2] is nan"),
        (lambda: brackets.bracket3((0, 0, 0), (0, 1, 0), (1, 0, 0), 3), "dropped is 3"),
        (lambda: brackets.lines_relations([[0, 0, 0]] * 2, [1, 0, 0], [[1, 0, 0], [2, 2, 2]], [2, 2, 2]), "of row 1"),
        (lambda: brackets.segments_relations([[0, 0]], [1, 0, 0], [1, 0, 0], [2, 2, 2]), "p1 has shape (1, 2)"),
        (lambda: brackets.segments_relations([[0, 0, 2**60]], [1, 0, 0], [1, 0, 0], [2, 2, 2]), "beyond 2^53"),
        (lambda: brackets.segments_relations([[0, 0, 2**53 + 1]], [1, 0, 0], [1, 0, 0], [2, 2, 2]), "beyond 2^53"),
        (lambda: brackets.segments_relations([[0, 0, np.inf]], [1, 0, 0], [1, 0, 0], [2, 2, 2]), "not finite"),
        (lambda: brackets.segments_relations([[0, 0, 2.0**150]], [1, 0, 0], [1, 0, 0], [2, 2, 2]), "below 2^150"),
        (lambda: brackets.segments_relations([[0, 0, 1], [1]], [1, 0, 0], [1, 0, 0], [2, 2, 2]), "different lengths"),
        (lambda: brackets.bracket4("123", (0, 0, 1), (1, 0, 0), (2, 0, 0)), "a is '123'"),
        (lambda: brackets.bracket4(("1e999999999", 0, 0), (0, 0, 1), (1, 0, 0), (2, 0, 0)), "exponent below 10000"),
        (lambda: brackets.bracket4((Decimal("snan"), 0, 0), (0, 0, 1), (1, 0, 0), (2, 0, 0)), "a[0] is 'sNaN'"),
        (lambda: brackets.bracket3((0, 0, 0), (0, 1, 0), (1, 0, 0), 1.0), "dropped is 1.0"),
        (lambda: brackets.segments_relations([[0, 0, 1]] * 3, [[1, 0, 0]] * 2, [1, 0, 0], [2, 2, 2]), "rows"),
    ],
)
def test_bad_input(call, text):
    with pytest.raises(fc.InputError) as error:
        call()
    assert text in str(error.value) and "\n" not in str(error.value)


# -- degenerate configurations ------------------------------------------------------------------------------


def configurations(seed: int = 20110731, n: int = N) -> np.ndarray:
    """(n, 4, 3) int64 points p1, p2, q1, q2: random, coplanar, on one line, sharing an end; a quarter each.

    A quarter of the lines run along (1, -1, 0); a few segments are points.
    """
    rng = np.random.default_rng(seed)
    m = n // 4
    free = rng.integers(-6, 7, (m, 4, 3))
    origin, u, v = (rng.integers(-3, 4, (m, 1, 3)) for _ in range(3))
    i, j, k = (rng.integers(-3, 4, (m, 4, 1)) for _ in range(3))
    flat = origin + i * u + j * v
    u[: m // 4] = (1, -1, 0)
    line = origin + k * u
    shared = rng.integers(-6, 7, (n - 3 * m, 4, 3))
    shared[:, 2] = shared[:, 0]
    half = len(shared) // 2
    shared[:half, 3] = shared[:half, 0] + rng.integers(-2, 3, (half, 1)) * (shared[:half, 1] - shared[:half, 0])
    return np.concatenate([free, flat, line, shared])


def dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", x, y)


def truth(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(kind, s_num, t_num, denominator) of segments by nearest points of their lines; all integers, no brackets.

    For directions d, e and w = p1 - q1 the nearest points have s D = b (e.w) - c (d.w), t D = a (e.w) - b (d.w) with
    a = d.d, b = d.e, c = e.e, D = a c - b^2; they coincide when D w + s D d - t D e = 0.
    """
    p1, p2, q1, q2 = points.transpose(1, 0, 2)
    d, e, w = p2 - p1, q2 - q1, p1 - q1
    a, b, c, dw, ew = dot(d, d), dot(d, e), dot(e, e), dot(d, w), dot(e, w)
    den, s, t = a * c - b * b, b * ew - c * dw, a * ew - b * dw
    meet = ~np.any(den[:, None] * w + s[:, None] * d - t[:, None] * e, axis=1) & (den > 0)
    inside = (0 <= s) & (s <= den) & (0 <= t) & (t <= den)
    kind = np.where(meet & inside, "point", "separate").astype("<U13")
    # parallel: on one line where w is a multiple of the direction; then intervals along d
    one = (den == 0) & (a > 0) & (c > 0) & (a * dot(w, w) == dw * dw)
    lo = np.maximum(0, np.minimum(-dw, dot(q2 - p1, d)))
    hi = np.minimum(a, np.maximum(-dw, dot(q2 - p1, d)))
    kind[one & (lo < hi)] = "overlap"
    kind[one & (lo == hi)] = "overlap_point"
    for point, (x, y), length in ((p1, (q1, q2), a), (q1, (p1, p2), c)):
        f = y - x
        on = (dot(f, f) * dot(point - x, point - x) == dot(f, point - x) ** 2) & (dot(point - x, point - y) <= 0)
        kind[(length == 0) & on] = "point"
        kind[(length == 0) & ~on] = "separate"
    return kind, s, t, den


@pytest.fixture(scope="module")
def known():
    points = configurations()
    return points, truth(points)


def rows(points: np.ndarray, scale: float = 1.0, shift: float = 0.0) -> list[np.ndarray]:
    return [np.ascontiguousarray(x) * scale + shift for x in points.transpose(1, 0, 2)]


def test_a_hundred_thousand_degenerate_segments(known):
    points, (kind, s, t, den) = known
    found = brackets.segments_relations(*rows(points))
    wrong = np.flatnonzero(found.kinds != kind)
    assert len(wrong) == 0, (points[wrong[0]], found.kinds[wrong[0]], kind[wrong[0]])
    assert found.exact_evaluations == 0
    counts = dict(zip(*np.unique(kind, return_counts=True), strict=True))
    assert min(counts.values()) > 5000 and len(counts) == 4
    crossing = (kind == "point") & (den > 0)
    assert np.array_equal(found.s[crossing], s[crossing] / den[crossing])
    assert np.array_equal(found.t[crossing], t[crossing] / den[crossing])
    met = kind != "separate"
    p1, p2, q1, q2 = points[met].transpose(1, 0, 2)
    for a, b, x in ((p1, p2, found.s[met]), (q1, q2, found.t[met])):
        assert np.abs(a + x[:, None] * (b - a) - found.points[met]).max() < 1e-14


def test_degenerate_lines(known):
    points, (_, s, t, den) = known
    proper = np.any(points[:, 0] != points[:, 1], axis=1) & np.any(points[:, 2] != points[:, 3], axis=1)
    points, s, t, den = points[proper], s[proper], t[proper], den[proper]
    found = brackets.lines_relations(*rows(points))
    d, e, w = points[:, 1] - points[:, 0], points[:, 3] - points[:, 2], points[:, 0] - points[:, 2]
    meet = ~np.any(den[:, None] * w + s[:, None] * d - t[:, None] * e, axis=1) & (den > 0)
    one = (den == 0) & (dot(d, d) * dot(w, w) == dot(d, w) ** 2)
    assert np.array_equal(found.kinds, np.where(meet, "point", np.where(one, "overlap", "separate")))
    assert np.array_equal(found.parallel, den == 0)
    assert np.array_equal(found.s[meet], s[meet] / den[meet])


def test_off_the_grid_the_exact_face_decides_alike(known):
    """The same configurations where differences of coordinates round: the filter passes, exact arithmetic decides."""
    points, (kind, *_) = known
    points, kind = points[:: N // 1500], kind[:: N // 1500]
    found = brackets.segments_relations(*rows(points, 2.0**-40, 2.0**10))
    assert np.array_equal(found.kinds, kind)
    assert 0 < found.exact_evaluations < len(points)
    overlap = kind == "overlap"
    reference = brackets.segments_relations(*rows(points))
    assert np.array_equal(found.ends[overlap], reference.ends[overlap] * 2.0**-40 + 2.0**10)
    assert np.array_equal(found.s, reference.s, equal_nan=True)


def test_signs_of_four_points_hold_beside_exact_ones(known):
    """Coplanar points disturbed by few units in the last place, where a plain determinant says anything."""
    points = known[0][N // 4 : N // 2 : 50]
    rng = np.random.default_rng(5)
    a, b, c, d = rows(points, 0.1, 0.7)
    d = d + rng.integers(-2, 3, d.shape) * 2.0**-52
    signs, exact_evaluations = brackets.bracket4_signs(a, b, c, d)
    wanted = [brackets.bracket4(*x) for x in zip(a.tolist(), b.tolist(), c.tolist(), d.tolist(), strict=True)]
    assert signs.tolist() == [(x > 0) - (x < 0) for x in wanted]
    assert 0 < exact_evaluations and len(set(signs.tolist())) == 3
    small, none = brackets.bracket4_signs(*rows(points))
    assert none == 0 and not small.any()


@pytest.mark.parametrize("exponent", [-320, -310, -290, 0, 100])
def test_grids_of_any_size(exponent, known):
    points, (kind, *_) = known
    found = brackets.segments_relations(*rows(points[::500], 2.0**exponent))
    assert np.array_equal(found.kinds, kind[::500])
    assert (found.exact_evaluations == 0) == (exponent >= -290)


def test_a_coordinate_of_the_least_size_beside_large_ones():
    """Scaled to a grid it would underflow to zero, and the skew lines would pass for coplanar."""
    skew = np.array([(-6, 0, 0), (-9, -4, 4), (-5, 2, -2), (-2, 0, 0)]) * 2.0**42
    skew[0, 2] = 5e-324
    wanted = brackets.bracket4(*skew)
    assert brackets.bracket4_signs(*skew)[0].tolist() == [(wanted > 0) - (wanted < 0)] != [0]
    assert brackets.lines_relations(*skew).kinds.tolist() == ["separate"]
    apart = np.array([(-7, -1, 9), (-7, 0, -1), (-7, 0, -1), (-9, 0, 7)]) * 2.0**46
    assert brackets.segments_relations(*apart).kinds.tolist() == ["point"]
    apart[1, 1] = 5e-324
    assert brackets.segments_relations(*apart).kinds.tolist() == ["separate"]


def test_numbers_of_flint_and_decimals():
    assert brackets.bracket4((fmpz(3), fmpq(1, 2), Decimal("0.1")), (0, 0, 0), (1, 0, 0), (0, 1, 0)) == F(1, 10)


def test_table_1_with_absolute_values(known):
    """[Chen11] table 1: rows that hold give the overlap; with signed brackets its first two are identities."""
    points, (kind, *_) = known
    chosen = (kind == "overlap") | (kind == "overlap_point")
    p1, p2, q1, q2 = points[chosen].transpose(1, 0, 2)
    e = p2 - p1
    found = brackets.segments_relations(*rows(points[chosen]))
    ends = np.where(np.isnan(found.ends), found.points, found.ends)

    def g(x, y):
        return np.abs(dot(x - y, e))

    table = [
        ((q1, q2), (g(p1, q1) + g(q1, q2) + g(q2, p2) == g(p1, p2)) | (g(p1, q2) + g(q2, q1) + g(q1, p2) == g(p1, p2))),
        ((p1, p2), (g(q1, p1) + g(p1, p2) + g(p2, q2) == g(q1, q2)) | (g(q1, p2) + g(p2, p1) + g(p1, q2) == g(q1, q2))),
        ((p1, q1), g(p2, q1) + g(q1, p1) + g(p1, q2) == g(p2, q2)),
        ((p1, q2), g(p2, q2) + g(q2, p1) + g(p1, q1) == g(p2, q1)),
        ((p2, q1), g(p1, q1) + g(q1, p2) + g(p2, q2) == g(p1, q2)),
        ((p2, q2), g(p1, q2) + g(q2, p2) + g(p2, q1) == g(p1, q1)),
    ]
    assert np.all(np.any([holds for _, holds in table], axis=0))
    for (x, y), holds in table:
        forward = np.all((x == found.points) & (y == ends), axis=1)
        backward = np.all((y == found.points) & (x == ends), axis=1)
        assert np.all((forward | backward)[holds]) and holds.any()
