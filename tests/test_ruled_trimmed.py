"""Times of contact of trimmed pieces: known ones, the same pieces without trimming, samples, laws."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.contact.signs.trimmed import inner_places
from firstcontact.errors import UnsupportedPair
from firstcontact.view.ruled import bounded_parts, element_corners

DISC = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s-1)**2 <= 1"], name="disc")
RING = fc.RuledSurface(
    "(u, -2, 0)", "(u, 2, 0)", u=(-2, 2), trim=["u**2 + (4*s-2)**2 <= 2", "u**2 + (4*s-2)**2 >= 1"], name="ring"
)


def wall(x: str, y: str, name: str = "wall") -> fc.RuledSurface:
    return fc.RuledSurface(f"({x}, {y}, -1)", f"({x}, {y}, 1)", u=(-2, 5), name=name)


def test_a_disc_meets_walls():
    """A disc of radius 1 reaches x = 3 after 2, x + y = 3 after 3 - sqrt 2; another element begins to touch there."""
    push = fc.Translation((4, 0, 0))
    hit = fc.first_contact(DISC.moving(push), wall("3 - u", "u"), exact=True)
    assert float(hit.time_exact) == (3 - 2**0.5) / 4
    assert (hit.element_a.kind, hit.element_a.index, hit.element_b.kind) == ("edge", 0, "face")
    root = 0.5**0.5
    assert np.allclose(hit.point, (3 - root, root, 0)) and np.allclose(hit.normal, (-root, -root, 0))
    (straight,) = fc.contact_intervals(wall("3", "u"), DISC.moving(fc.Translation((8, 1, 0))), exact=True)
    assert (straight.start_exact, straight.end_exact) == (Fraction(1, 4), Fraction(1, 2))


def test_pages_draw_the_border(tmp_path):
    hit = fc.first_contact(DISC.moving(fc.Translation((4, 0, 0))), wall("3 - u", "u"))
    assert hit.show(str(tmp_path / "disc.html")) is not None
    drawn = element_corners(RING, bounded_parts(RING, 0.1), fc.result.Element("edge", "ring", 1, "ring"))
    assert np.allclose(np.linalg.norm(drawn, axis=1), 1, atol=1e-3)
    assert set(np.sign(drawn[:, 0])) >= {-1, 1} and set(np.sign(drawn[:, 1])) >= {-1, 1}


def test_rulings_on_one_line_are_not_decided():
    """A piece that meets itself, moved: all its rulings come to lie on one line each, at half the time."""
    leaf = fc.RuledSurface("(u, -1, 0)", "(u, 1, u*u)", u=(-1, 1), trim=["s <= 1/2 + u/4"], name="leaf")
    same = fc.RuledSurface("(u, -1, 0)", "(u, 1, u*u)", u=(-1, 1)).translated((0, 0, -1))
    with pytest.raises(UnsupportedPair, match="leaf.*one line"):
        fc.first_contact(leaf, same.moving(fc.Translation((0, 0, 2))), exact=True)
    found = fc.first_contact(leaf, same.moving(fc.Translation((0, 0, 2))))
    assert found.status is fc.Status.UNDECIDED and 0.499 < found.free_until <= 0.5


def test_a_post_passes_through_a_ring():
    """The ring 1 <= |x|^2 <= 2 meets a thin line at x = -3 + 6 T twice."""
    post = fc.RuledSurface("(u/8, 0, -1)", "(u/8, 0, 1)", u=(-1, 1), name="post").translated((-3, 0, 0))
    found = fc.contact_intervals(post.moving(fc.Translation((6, 0, 0))), RING)
    known = [(3 - 2**0.5 - 0.125) / 6, (3 - 1 + 0.125) / 6, (3 + 1 - 0.125) / 6, (3 + 2**0.5 + 0.125) / 6]
    assert np.allclose([t for x in found for t in (x.start, x.end)], known, atol=1e-15)
    through = post.translated((3, 0, 3)).moving(fc.Translation((0, 0, -6)))
    assert fc.first_contact(through, RING).status is fc.Status.FREE


TOPS = ["1/4 + u/2", "u**2", "1 - u/2", "1/2 + u*(1-u)"]


@pytest.mark.parametrize("seed", range(amount(12)))
def test_a_trimmed_piece_is_a_shorter_piece(seed):
    """What s <= c(u) leaves of first + s (second - first) is ruled by its rulings up to c(u)."""
    rng = np.random.default_rng(seed)
    first, gap = (["({})/2 + ({})/2*u".format(*rng.integers(-3, 4, 2)) for _ in range(3)] for _ in range(2))
    top = TOPS[seed % 4]
    ends = ["({})".format(", ".join(c)) for c in (first, [f"{p} + {d} + 1/5" for p, d in zip(first, gap, strict=True)])]
    upper = "({})".format(", ".join(f"{p} + ({top})*({d} + 1/5)" for p, d in zip(first, gap, strict=True)))
    cut = fc.RuledSurface(*ends, trim=[f"s <= {top}"], name="cut")
    short = fc.RuledSurface(ends[0], upper, name="short")
    motion = fc.Translation(rng.integers(3, 9, 3).tolist())
    target = fc.RuledSurface("(u, 0, u/3)", "(u/2, 3, 1)", u=(-1, 2)).translated(rng.integers(0, 5, 3))
    if seed % 3 == 2:
        target = fc.examples.box((1, 2, 1)).translated(rng.integers(1, 5, 3))
    known = fc.contact_intervals(short.moving(motion), target)
    found = fc.contact_intervals(cut.moving(motion), target)
    swapped = fc.contact_intervals(target, cut.moving(motion))
    other = fc.contact_intervals(cut, target.moving(fc.Translation([-float(c) for c in motion.vector])))
    for result in (found, swapped, other):
        assert result.status is known.status
        ends = [(x.start, x.end) for x in result]
        assert np.allclose(ends, [(x.start, x.end) for x in known], atol=1e-12)


def test_a_deforming_trimmed_piece():
    """A disc whose plane rises reaches a bar at z = 1/2 over the place x = 3/5 at T = 1/2, when it is wide enough."""
    rising = fc.RuledSurface("(u, -1, T)", "(u, 1, T)", u=(-1, 1), trim=["u**2 + (2*s-1)**2 <= 1/4"])
    bar = fc.RuledSurface("(3/5, -1 + 2*u, 2/5)", "(2/5, -1 + 2*u, 3/5)", name="bar")
    (interval,) = fc.contact_intervals(rising, bar, exact=True)
    # on the bar x = 1 - z, which the disc reaches where x <= 1/2
    assert (interval.start_exact, interval.end_exact) == (Fraction(1, 2), Fraction(3, 5))


@pytest.mark.parametrize("solid", [fc.examples.box((2, 2, 2)), fc.examples.box((20, 20, 20))])
def test_solids_hold_trimmed_pieces(solid):
    """Of the disc from x = -8 to 0: its rim comes to the box, or all of it is inside at all times."""
    way = fc.Translation((8, 0.5, 0))
    (interval,) = fc.contact_intervals(DISC.translated((-8, 0, 0)).moving(way), solid, exact=True)
    assert (interval.start_exact, interval.end_exact) == (Fraction(3, 4) if solid.vertices.max() < 5 else 0, 1)


def test_what_is_trimmed_away_overlaps_nothing():
    """A ball that touches the rim of the disc holds the corner of the square that the disc is cut from."""
    hit = fc.first_contact(DISC, fc.sphere(1).translated(("6/5", "8/5", 0)), exact=True)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "touching")


def test_every_part_of_a_piece_has_a_place():
    parts = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", trim=["(4*u-1)*(4*u-2)*(4*u-3) >= 0", "9*s**2 - 9*s + 2 >= 0"])
    places = inner_places(parts)
    for lo, hi in ((0.25, 0.5), (0.75, 1)):
        for low, high in ((0, 1 / 3), (2 / 3, 1)):
            assert any(lo <= float(u) <= hi and low <= float(s) <= high for u, s in places)
    assert all((4 * u - 1) * (4 * u - 2) * (4 * u - 3) >= 0 and 9 * s**2 - 9 * s + 2 >= 0 for u, s in places)
    assert len(inner_places(DISC)) >= 1  # the disc touches the borders of its square from inside


@pytest.mark.share(9)
@pytest.mark.parametrize(
    "trim",
    [
        ["-(2*u-1)**2 >= 0"], ["u**2 + s**2 <= 0"], ["(2*u-1)**2 + (2*s-1)**2 <= 0"], ["2*s <= 1", "2*s >= 1"],
        ["s <= -(2*u-1)**2"], ["(u-1/3)**2*(u-1/4) >= s**2"], ["4*s <= 2 - (2*u-1)**2", "4*s >= 2 + (2*u-1)**2"],
    ],
)  # fmt: skip
def test_solids_refuse_what_has_no_area(trim):
    thread = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", trim=trim, name="thread").translated((-8, 0, 0))
    with pytest.raises(UnsupportedPair, match="thread.*without area"):
        fc.contact_intervals(thread.moving(fc.Translation((8, 0.5, 0))), fc.examples.box((2, 2, 2)), exact=True)


@pytest.mark.parametrize(("trim", "known"), [(["-(2*u-1)**2 >= 0"], 0.625), (["2*s <= 1", "2*s >= 1"], 0.5)])
def test_arcs_meet_surfaces(trim, known):
    """The middle line of a square that comes from x = -4 (u = 1/2 at x = -3.5) with 8 T to a wall at x = 1.5, or 0."""
    square = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", trim=trim).translated((-4, 0, 0))
    target = wall("3/2" if known == 0.625 else "1", "u")
    found = fc.contact_intervals(square.moving(fc.Translation((8, 0, 0))), target)
    assert found[0].start == known
    assert found[0].end == (known if known == 0.625 else 0.625)


# -- what doubles take, and what refusals say ---------------------------------------------------------------


def roof(trim):
    """Its highest point, at (1, 1, 3/2), is a corner that the inequality keeps."""
    return fc.RuledSurface("(u, 0, u)", "(u, 1, u+1/2)", trim=[trim], name="roof")


CEILING = fc.RuledSurface("(u, -9, 3)", "(u, 9, 3)", u=(-9, 9), name="ceiling")
BLOCK = fc.examples.box((9, 9, 2)).translated((0, 0, 4))


@pytest.mark.share(2)
@pytest.mark.parametrize("method", ["auto", "certified"])
def test_steep_inequalities_meet_convex_polyhedra_by_their_triangles(method):
    """The search against solids takes squares of s; it was the only one that was asked."""
    rising = roof("s**3<=u+1/4").moving(fc.Screw((0, 0, 1), degrees=90, advance=4))
    for pair in ((rising, BLOCK), (BLOCK, rising)):
        found = fc.first_contact(*pair, method=method)
        assert found.status is fc.Status.CONTACT and found.time_interval[0] <= 3 / 8 <= found.time_interval[1]


@pytest.mark.share(2)
@pytest.mark.parametrize("target", [CEILING, BLOCK])
def test_intervals_without_exact_equations_tell_the_first_start(target):
    """They were refused; what the first contact proves is told, with the end left open."""
    for trim in ("s**3<=u+1/4", "u**2+s**2<=3"):
        rising = roof(trim).moving(fc.Screw((0, 0, 1), degrees=90, advance=4))
        found = fc.contact_intervals(rising, target)
        assert len(found) == 1 and found[0].start_interval[0] <= 3 / 8 <= found[0].start_interval[1]
        assert found.reason == (None if found.status is fc.Status.CONTACT else "precision")
        assert found[0].start_interval[1] - found[0].start_interval[0] < 1e-9
    away = roof("s**3<=u+1/4").moving(fc.Screw((0, 0, 1), degrees=90, advance=-4))
    assert fc.contact_intervals(away, target).status is fc.Status.FREE


HARD = (
    roof("s**3<=u+1/4").moving(fc.RationalMotion.between((0, 0, 0), (1, 5, 6), quat_wxyz=((1, 0, 0, 0), (1, 0, 0, 1)))),
    fc.RuledSurface("(u**3, 1, u)", "(1, u**4, u**2)").moving(
        fc.RationalMotion.between((9, 9, 9), (9, 1, 9), quat_wxyz=((1, 0, 0, 0), (2, 1, 1, 0)))
    ),
)


@pytest.mark.thorough
@pytest.mark.parametrize("verb", [fc.first_contact, fc.contact_intervals])
def test_a_refusal_names_the_option_that_was_given(verb):
    for option, named in (({"exact": True}, "exact=True"), ({"method": "algebraic"}, "method='algebraic'")):
        with pytest.raises(fc.UnsupportedPair, match=f"too large .*; without {named} there may be enclosures$"):
            verb(*HARD, **option)
    assert verb(*HARD).status in fc.Status


@pytest.mark.parametrize("verb", [fc.first_contact, fc.contact_intervals])
def test_a_refusal_says_each_reason_once_and_promises_nothing(verb):
    """Whole rulings are beyond doubles, a screw is beyond exact equations: s is what has to change."""
    whole = fc.RuledSurface("(u, 0, u)", "(u, 1, u+1/2)", s=None, trim=["s**3<=u"], name="whole")
    pair = whole.moving(fc.Screw((0, 0, 1), degrees=90, advance=4)), CEILING
    with pytest.raises(fc.UnsupportedPair) as told:
        verb(*pair)
    assert str(told.value).count("bound s") == 1 and "exact=True" not in str(told.value)
    with pytest.raises(fc.UnsupportedPair) as told:
        verb(*pair, exact=True)
    assert "no rational pose" in str(told.value) and "without" not in str(told.value)


COIN = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)", u=(-1, 1), s=(-1, 1), trim=["u**2 + s**2 <= 1"])
BOARD = fc.RuledSurface("(u, -2, 0)", "(u, 2, 0)", u=(-2, 2))


@pytest.mark.share(5)
@pytest.mark.parametrize("at, way, time", [
    ((0, 0, 1), (0, 0, -2), Fraction(1, 2)),  # flat
    ((-4, 0, 0), (4, 0, 0), Fraction(1, 4)),  # in the plane, across the rulings and along them
    ((0, -4, 0), (0, 4, 0), Fraction(1, 4)),
    ((Fraction(13, 5), Fraction(14, 5), 1), (0, 0, -2), Fraction(1, 2)),  # the corner at (2, 2) on the rim
    ((Fraction(14, 5), Fraction(14, 5), 1), (0, 0, -2), None),
])  # fmt: skip
def test_a_coin_whose_rulings_lie_along_those_of_a_board(at, way, time):
    """UNDECIDED, and refused exactly: rulings on one line; the board is ruled the other way."""
    coin = COIN.translated(at).moving(fc.Translation(way))
    for pair in ((coin, BOARD), (BOARD, coin)):
        found = fc.first_contact(*pair, exact=True)
        assert found.time_exact == time and (time is not None or found.status is fc.Status.FREE)
        assert fc.first_contact(*pair).status is found.status
    assert [(x.start_exact, x.end_exact) for x in fc.contact_intervals(coin, BOARD, exact=True)][:1] == (
        [] if time is None else [(time, time if way[2] else 1)]
    )


def test_elements_of_a_board_that_is_ruled_the_other_way():
    across, along = (
        fc.first_contact(COIN.translated(at).moving(fc.Translation(way)), BOARD, exact=True).element_b
        for at, way in (((-4, 0, 0), (4, 0, 0)), ((0, -4, 0), (0, 4, 0)))
    )
    assert (across.kind, across.index) == ("end_ruling", 0) and (along.kind, along.index) == ("directrix", 0)


@pytest.mark.share(4)
@pytest.mark.parametrize("side", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_corners_of_a_board_that_is_ruled_the_other_way(side):
    """As the board itself has them, which a box meets at the same corner."""
    x, y = side
    down = fc.Translation((0, 0, -2))
    coin = COIN.translated((x * Fraction(13, 5), y * Fraction(14, 5), 1)).moving(down)
    box = fc.examples.box((0.5, 0.5, 0.5)).translated((2.25 * x, 2.25 * y, 2)).moving(down)
    named = fc.first_contact(coin, BOARD, exact=True).element_b
    assert named == fc.first_contact(box, BOARD).element_b and named.kind == "vertex"


def test_a_piece_ruled_the_other_way_has_the_same_points():
    piece = fc.RuledSurface("(u, 1, u)", "(2 - u, u, 3*u)", u=(-1, 2), s=(-1, 3), trim=["u <= s"])
    other = piece.crossed()
    assert np.allclose(piece.points(0.25, 1.75), other.points(1.75, 0.25)) and (other.u, other.s) == (piece.s, piece.u)
    assert str(other.trim[0]) == str(fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)", trim=["s <= u"]).trim[0])
    assert fc.RuledSurface("(u, 0, 0)", "(u**2, 1, 0)").crossed() is None
