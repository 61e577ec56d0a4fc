"""Ruled surfaces against solids of planes and quadrics: known times, both ways of building one shape, laws, samples."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.errors import UnsupportedPair
from firstcontact.kernels.events.feature_boxes import (
    ABOUT,
    BEND,
    BEND_U,
    BEND_V,
    CURVED,
    DEGREE,
    INSIDE,
    MIDDLE_TIME,
    OUTSIDE,
    PER_HALF,
    POWERS,
    REST,
    ROWS,
    SLOPE_T,
    SLOPE_U,
    SLOPE_V,
    STACK,
    SUM_OF_SIZES,
    THERE,
    TIMES,
    VALUE,
    WIDE,
    WIDTH,
    ZEROTH,
    model,
    place_box,
    sign,
)

SADDLE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", name="saddle")
PIPE = fc.RuledSurface(
    "((1-u**2)/(1+u**2), 2*u/(1+u**2), -1)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", u=None, name="pipe"
)
TUBE = (fc.cylinder("3/2", 3) - fc.cylinder(1, 4)).rotated((1, 2, 0), degrees=40).translated((4, "1/5", 0))
TUBE = TUBE.named("tube")
SCREW = fc.Screw((1, 0.2, 0.1), degrees=400, advance=9)
MOTIONS = [fc.Translation((9, 0.5, 1)), fc.Rotation((0, 1, 5), point=(2.5, -0.5, 0), degrees=170), SCREW]


@pytest.mark.parametrize("seed", range(amount(12)))
@pytest.mark.parametrize("times", [0, 3])
def test_models_of_forms_hold_all_sampled_values(times, seed):
    """Value, and half the derivatives, at sampled places and times of a box lie within value + slopes +- rest."""
    rng = np.random.default_rng(seed)
    n, quadric = int(rng.integers(1, 7)), seed % 2
    wide = 8 * (n + 1)
    coefficients = rng.normal(size=(times + 1, n + 1, 2, 4))
    coefficients[0, 0, 0, 3] = 40.0
    charts = np.zeros((1, POWERS + coefficients.size))
    charts[0, [DEGREE, TIMES, WIDE, MIDDLE_TIME, PER_HALF]] = n, times, wide, 5.0, 0.5
    charts[0, POWERS:] = coefficients.ravel()
    bends = np.arange(times + 1) * (np.arange(times + 1) - 1.0)
    both = np.einsum("q,qjki->ji", bends, abs(coefficients))
    charts[0, BEND : BEND + 4], charts[0, BEND_U : BEND_U + 4] = both.sum(axis=0), np.arange(n + 1) @ both
    charts[0, BEND_V : BEND_V + 4] = np.einsum("q,qji->i", bends, abs(coefficients[:, :, 1]))
    u, v, hu, hv = *rng.uniform(-0.8, 0.8, 2), *(10.0 ** rng.uniform(-4, -0.5, 2))
    table = np.zeros((1, 4, 16))
    table[0, ABOUT, CURVED] = quadric
    forms = rng.normal(size=(2, 4, 4))
    forms = forms + forms.transpose(0, 2, 1)
    if quadric:
        table[0, :2] = forms.reshape(2, 16)
    else:
        table[0, :2, :4] = forms[:, 0]
    s, hs, at, half = 0.2, 0.1, 5.2, 10.0 ** rng.uniform(-4, -0.5)
    z = np.zeros((ROWS, WIDTH))
    e = z[ZEROTH:]
    assert place_box(charts, 0, u, hu, v, hv, at, half, z)
    model(table, 0, s, hs, z, np.int64(2), ZEROTH)

    def point(a, b, t):
        powers = (u + hu * a) ** np.arange(n + 1)
        c = np.tensordot((0.5 * (at + half * t - 5.0)) ** np.arange(times + 1), coefficients, 1)
        return powers @ (c[:, 0] + (v + hv * b) * c[:, 1])

    def value(a, b, t):
        form, p = forms[0] + (s + hs * t) * forms[1], point(a, b, t)
        return p @ form @ p if quadric else form[0] @ p

    rests = []
    for a, b, t in [*rng.uniform(-1, 1, (40, 3)), *np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T]:
        h, part = 1e-6, 0.5 if quadric else 1.0
        seen = [
            value(a, b, t), part * (value(a + h, b, t) - value(a - h, b, t)) / (2 * h),
            part * (value(a, b + h, t) - value(a, b - h, t)) / (2 * h),
        ]  # fmt: skip
        for row, found in enumerate(seen):
            linear = e[row, VALUE] + a * e[row, SLOPE_U] + b * e[row, SLOPE_V] + t * e[row, SLOPE_T]
            rests.append(abs(found - linear) / e[row, REST])
            assert abs(found - linear) <= e[row, REST] + 1e-8 * abs(e[row]).max()
    assert max(rests) > 1e-3


@pytest.mark.parametrize(("shift", "signs"), [(0.12, INSIDE | OUTSIDE), (0.126, OUTSIDE), (-0.12, INSIDE | OUTSIDE)])
def test_signs_of_forms_see_what_is_beyond_second_order(shift, signs):
    """Of x + shift on (u^3, 0, 0) with |u| <= 1/2, whose first and second order parts vanish."""
    charts = np.zeros((1, POWERS + 8 * 4))
    charts[0, [DEGREE, POWERS + 3, POWERS + 8 * 3]] = 3.0, 1.0, 1.0
    table = np.zeros((1, 4, 16))
    table[0, 0, [3, 12, 15]] = 0.5, 0.5, shift
    table[0, ABOUT, [SUM_OF_SIZES, CURVED]] = 1.0 + abs(shift), 1.0
    z = np.zeros((ROWS, WIDTH))
    assert place_box(charts, 0, 0.0, 0.5, 0.5, 0.5, 0.0, 0.0, z)
    assert sign(table, 0, 0, 0.0, 0.0, z, THERE, np.zeros(STACK, np.int64)) == signs


def test_a_saddle_falls_on_a_plane():
    """The lowest corner of a bilinear patch comes first."""
    floor = fc.half_space((1, 2, 4), -20).named("floor")
    hit = fc.first_contact(SADDLE.rotated((1, 0, 0), degrees=180).moving(fc.Translation((0, 0, -10))), floor)
    assert hit.time == pytest.approx((20 - 5) / 40, abs=1e-15)
    assert (hit.element_a.kind, hit.element_a.index, hit.element_b.kind) == ("vertex", 3, "face")
    assert np.allclose(hit.normal, np.array([1, 2, 4]) / 21**0.5)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("other", [fc.sphere("5/4").translated((4, "1/3", "1/7")), TUBE])
def test_a_pipe_is_the_side_of_a_cylinder(motion, other):
    solid = fc.first_contact(fc.cylinder(1, 2).moving(motion), other)
    pipe = fc.first_contact(PIPE.moving(motion), other)
    assert (solid.status, pipe.status) == (fc.Status.CONTACT, fc.Status.CONTACT)
    lo, hi = pipe.time_interval
    if solid.element_a.kind == "face" and not solid.element_a.label.endswith("side"):
        assert solid.time <= hi  # a cap, which the pipe does not have
    else:
        assert lo - 1e-13 <= solid.time <= hi + 1e-13
        assert np.allclose(pipe.point, solid.point, atol=1e-9) and np.allclose(pipe.normal, solid.normal, atol=1e-7)


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", range(amount(12)))
def test_doubles_agree_with_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    box = fc.examples.box(rng.integers(2, 9, 3) / 4).translated(rng.integers(8, 17, 3) / 8)
    way = fc.Translation(rng.integers(8, 41, 3) / 8)
    body = SADDLE.translated(-rng.integers(4, 13, 3) / 8)
    exact = fc.first_contact(body.moving(way), box, method="algebraic")
    proved = fc.first_contact(box, body.moving(way), method="certified")
    if proved.status is not fc.Status.UNDECIDED:
        assert proved.status is exact.status
    if proved.status is fc.Status.CONTACT:
        assert proved.time_interval[0] <= exact.time <= proved.time_interval[1]


def deepest(surface, motion, solid, t):
    """The lowest (and 0 for none) share of sampled points of the surface inside the solid at t."""
    u, s = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 40))
    pose = motion(t)
    return solid.contains(surface.points(u, s).reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3])


@pytest.mark.thorough
@pytest.mark.parametrize("motion", MOTIONS[-amount(3) :])
def test_intervals_hold_all_sampled_contacts(motion):
    found = fc.contact_intervals(SADDLE.moving(motion), TUBE)
    hit = fc.first_contact(SADDLE.moving(motion), TUBE)
    assert hit.time_interval[0] <= found[0].start_interval[1] and found[0].start_interval[0] <= hit.time_interval[1]
    until = 1.0 if found.status is not fc.Status.UNDECIDED else found.free_until
    for t in np.linspace(0, until, 60):
        inside = any(i.start <= t <= i.end for i in found)
        assert inside or not deepest(SADDLE, motion, TUBE, t).any()
    assert deepest(SADDLE, motion, TUBE, hit.time + 0.01).any()


def test_laws():
    hit = fc.first_contact(SADDLE.moving(SCREW), TUBE)
    swapped = fc.first_contact(TUBE, SADDLE.moving(SCREW))
    assert swapped.time == hit.time and swapped.element_a == hit.element_b
    assert np.allclose(swapped.normal, -hit.normal) and np.array_equal(swapped.point, hit.point)
    shift = fc.Translation((3, -2, 5))
    together = fc.first_contact(
        SADDLE.moving(MOTIONS[0]), TUBE.moving(fc.Translation(np.negative(MOTIONS[0].vector).tolist()))
    )
    apart = fc.first_contact(SADDLE.moving(fc.Translation([2 * c for c in MOTIONS[0].vector])), TUBE)
    assert together.time == pytest.approx(apart.time, abs=1e-12)
    common = fc.first_contact(SADDLE.moving(shift), TUBE.moving(shift))
    assert common.status is fc.Status.FREE


def test_starts():
    hall = fc.sphere(4)
    inside = fc.first_contact(SADDLE, hall.moving(fc.Translation((9, 0, 0))))
    assert (inside.status, inside.initial, inside.time) == (fc.Status.INITIAL_CONTACT, "containment", 0.0)
    across = fc.first_contact(SADDLE.translated((3.5, 0, 0)), hall.moving(fc.Translation((9, 0, 0))))
    assert (across.status, across.initial) == (fc.Status.INITIAL_CONTACT, "overlapping")
    (interval,) = fc.contact_intervals(SADDLE, hall.moving(fc.Translation((9, 0, 0))))
    # the corner (0, 1, 0) or an end of it leaves last: |x - 9 t| = 4
    assert interval.start == 0.0 and interval.end == pytest.approx((1 + 16**0.5) / 9, abs=1e-11)


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        (fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", trim=["u <= s**3"], name="leaf"), "leaf has an ineq"),
        (fc.RuledSurface("(u, 0, 0)", "(1-u, 0, u-1/2)", s=None, name="bow"), "bow has whole rulings whose"),
    ],
)
def test_refusals(surface, message):
    with pytest.raises(UnsupportedPair, match=message):
        fc.first_contact(surface, TUBE.moving(SCREW))


WING = fc.RuledSurface("(u, 0, -2*T**2)", "(u, 1 + T, u - T - 2*T**2)", name="wing")
TURNED = fc.Rotation((0, 0, 1), point=("1/3", 2, 0), degrees=200)


@pytest.mark.share(3)
@pytest.mark.parametrize(
    "motion",
    [TURNED, fc.Sequence([TURNED, fc.Rotation((0, 0, 3), degrees=33)]), fc.Screw((0, 0, 1), degrees=90, advance=1)],
)
def test_deforming_surfaces_turn(motion):
    """About the z axis, so that only their own change, and the advance, tells when they leave or reach a floor."""
    floor = fc.half_space((0, 0, 1), "-7/4").named("floor")
    hit = fc.first_contact(WING.moving(motion), floor)
    ahead = 1.0 if isinstance(motion, fc.Screw) else 0.0  # the corner at u = 0, s = 1: -t - 2 t^2 + ahead t = -7/4
    known = 14**0.5 / 4 if ahead else (15**0.5 - 1) / 4
    assert hit.time_interval[0] <= known <= hit.time_interval[1] and hit.time_interval[1] - hit.time_interval[0] < 1e-12
    corners = ("vertex", "end_ruling") if ahead else ("vertex",)
    assert hit.element_a.kind in corners and np.allclose(hit.normal, (0, 0, 1))
    if motion is TURNED:
        (interval,) = fc.contact_intervals(floor, WING.moving(motion), (0.7, 0.72))
        assert interval.start_interval[0] <= known <= interval.start_interval[1] and interval.end == 0.72


@pytest.mark.parametrize("seed", range(amount(9)))
def test_deforming_surfaces_agree_with_exact_arithmetic(seed):
    """Times in doubles hold the exact ones; with time reversed, intervals are mirrored."""
    rng = np.random.default_rng(seed)
    first, second = (
        "(" + ", ".join("{} + {}*u + {}*T + {}*u*T**2".format(*rng.integers(-2, 3, 4)) for _ in range(3)) + ")"
        for _ in range(2)
    )
    solid = (fc.sphere(1), fc.box((1, 2, 1)), TUBE)[seed % 3].translated(rng.integers(-2, 3, 3).tolist())
    surface = fc.RuledSurface(first, second)
    proved = fc.first_contact(surface, solid, (-1, 1), method="certified")
    exact = fc.first_contact(surface, solid, (-1, 1), method="algebraic")
    assert proved.status in (exact.status, fc.Status.UNDECIDED)
    if proved.status is fc.Status.CONTACT:
        assert proved.time_interval[0] <= exact.time <= proved.time_interval[1]


def test_no_exact_times_under_screws():
    with pytest.raises(UnsupportedPair, match="no rational pose"):
        fc.first_contact(SADDLE.moving(SCREW), TUBE, exact=True)


CIRCLE = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"


@pytest.mark.parametrize(
    ("ends", "solid", "known"),
    [
        # a cylinder of radius 1 and a ball of radius 1/4 far along it; a cone of slope 1; z = x y under a ball
        ((f"({CIRCLE}, -1)", f"({CIRCLE}, 1)"), fc.sphere("1/4").translated((4, 0, 50)), 2.75 / 8),
        (("(0, 0, 0)", f"({CIRCLE}, 1)"), fc.sphere(1).translated((10, 0, 0)), (10 - 2**0.5) / 8),
        (("(1, u, u)", "(-1, u, -u)"), fc.sphere("1/2").translated((4, 0, 0)), None),
    ],
)
def test_whole_rulings(ends, solid, known):
    """Against the same surface with long rulings, and known times of the way 8 T along x."""
    whole, cut = (
        fc.RuledSurface(*ends, u=None if known else (-4, 4), s=s, name="whole") for s in (None, (-64, 64))
    )
    way = fc.Translation((8, 0, 0)) if known else fc.Rotation((0, 1, 0), point=(3, 0, 0), degrees=180)
    if not known:
        solid = solid.translated((0, 0, 3))
    span = (0, 2 if known else 1)
    hit, same = fc.first_contact(whole.moving(way), solid, span), fc.first_contact(solid, cut.moving(way), span)
    assert hit.status is same.status is fc.Status.CONTACT and abs(hit.time - same.time) < 1e-12
    assert known is None or hit.time_interval[0] <= known * (1 + 1e-15) and known <= hit.time_interval[1] * (1 + 1e-15)


@pytest.mark.share(2)
@pytest.mark.parametrize(
    "ends",
    [("(u, 0, 100/(1+{0}))", "(u, 0, 100/(1+{0}) - 1)"), ("(u, 0, 5)", "(u, 0, 4 + (49/50)/(1+{0}))")],
    ids=["far away", "close together"],
)
def test_directrices_that_samples_do_not_show(ends):
    """Near u = 1/3 the way along the ruling to the ball is long, in units of the two points that span it."""
    spike = fc.RuledSurface(*(end.format("1000000*(u-1/3)**2") for end in ends), u=(0, 1), s=None, name="spike")
    ball = fc.sphere("1/1000").translated(("1/3", 1, 0)).moving(fc.Translation((0, -2, 0)))
    hit = fc.first_contact(spike, ball)
    assert hit.time_interval[0] <= 0.4995 <= hit.time_interval[1]
    assert hit.time_interval[1] - hit.time_interval[0] < 1e-9


def test_whole_rulings_whose_directrices_go_to_infinity():
    """Of the parabolic cylinder z = x^2, 99 / 100 under a point of a ball of radius 1/100."""
    trough = fc.RuledSurface("(u, 0, u**2)", "(u, 1, u**2)", u=None, s=None, name="trough")
    ball = fc.sphere("1/100").translated((0, 7, 1)).moving(fc.Translation((0, 0, -2)))
    hit = fc.first_contact(trough, ball)
    assert hit.time_interval[0] <= 0.495 <= hit.time_interval[1] and hit.time_interval[1] - hit.time_interval[0] < 1e-9


def test_whole_rulings_meet_bounded_solids_only():
    regulus = fc.RuledSurface("(1, u, u)", "(-1, u, -u)", s=None, name="regulus")
    with pytest.raises(UnsupportedPair, match="bound s of regulus"):
        fc.first_contact(regulus.moving(SCREW), fc.half_space((0, 0, 1), -9))


DISC = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s-1)**2 <= 1"], name="disc")
LEAF = fc.RuledSurface("(u, -1, T**2)", "(u, 1, u/2 + T**2)", u=(-1, 1), trim=["u + s <= 3/2", "s >= u/2"], name="leaf")


def test_a_disc_turns_onto_a_floor():
    """By 30 degrees until its rim is 1/2 low; one that is cut at y = 3/5 besides has corners there."""
    screw, floor = fc.Screw((0, 1, 0), degrees=90, advance=2), fc.half_space((0, 0, 1), "-1/2").named("floor")
    hit = fc.first_contact(DISC.moving(screw), floor)
    assert hit.time_interval[0] <= 1 / 3 <= hit.time_interval[1] and hit.time_interval[1] - hit.time_interval[0] < 1e-12
    assert (str(hit.element_a), str(hit.element_b)) == ("disc edge 0", "floor.plane face 0")
    assert np.allclose(hit.point, (0.75**0.5, 2 / 3, -0.5)) and np.allclose(hit.normal, (0, 0, 1))
    (interval,) = fc.contact_intervals(DISC.moving(screw), floor, (0.3, 0.34))
    assert interval.start_interval[0] <= 1 / 3 <= interval.start_interval[1] and interval.end == 0.34
    band = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s-1)**2 <= 1", "2*s-1 >= 3/5"])
    hit = fc.first_contact(floor, band.moving(screw))  # corners at x = 4/5
    known = 2 / np.pi * np.arcsin(5 / 8)
    assert abs(hit.time - known) < 1e-12 and hit.element_b.kind == "edge" and abs(hit.point[1] - 0.6 - 2 * known) < 1e-9


@pytest.mark.parametrize("seed", range(amount(9)))
def test_trimmed_surfaces_agree_with_exact_arithmetic(seed):
    """Places at rest and in motion, deforming too: elements, times and normals of both ways."""
    rng = np.random.default_rng(seed)
    surface = (DISC, LEAF)[seed % 2].rotated((1, 2, 2), degrees=int(rng.integers(0, 4)) * 90)
    body = surface.translated(rng.integers(-2, 3, 3).tolist())
    solid = (fc.sphere(1), fc.box((1, 2, 1)))[seed // 2 % 2].translated((5, *rng.integers(-1, 2, 2).tolist()))
    way = fc.Translation((8, *rng.integers(-1, 2, 2).tolist()))
    proved = fc.first_contact(body.moving(way), solid, method="certified")
    exact = fc.first_contact(body.moving(way), solid, method="algebraic")
    assert proved.status is exact.status
    if proved.status is fc.Status.CONTACT:
        assert proved.time_interval[0] <= exact.time <= proved.time_interval[1]
        assert exact.multiplicity > 1 or proved.element_a == exact.element_a


def test_a_rim_lands_slowly_where_it_touches_the_range():
    """At u = 1, after nearly a quarter turn: the ruling there lies along the floor, and rounding blurs the time."""
    screw, floor = fc.Screw((0, 1, 0), degrees=180, advance=3), fc.half_space((0, 0, 1), "-999/1000")
    hit = fc.first_contact(DISC.moving(screw), floor)
    known = np.arcsin(0.999) / np.pi
    assert hit.status is fc.Status.CONTACT and abs(hit.time - known) < 1e-14 and hit.element_a.kind == "edge"
