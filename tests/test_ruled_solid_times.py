"""Exact times of ruled surfaces and solids of planes and quadrics: deforming and trimmed pieces, grazes, starts."""

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.signs.sheets import FARTHEST, QUICK, Sheet, TooLarge
from firstcontact.exact.polynomials.trivariate import RING

SADDLE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", name="saddle")
DISC = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s-1)**2 <= 1"], name="disc")
CUP = fc.box((2, 2, 1)) - fc.sphere("3/4")


def minimal(time):
    return time if isinstance(time, Fraction) else time.polynomial


@pytest.mark.share(2)
@pytest.mark.parametrize(
    ("surface", "solid", "ends"),
    [
        (SADDLE.translated((-5, 0, 0)).moving(fc.Translation((10, 0, 0))), fc.sphere(1), ["3/10", "3/5"]),
        # |(10 t - 5, t)| = 2
        (DISC.translated((-5, 0, 0)).moving(fc.Translation((10, 1, 0))), fc.sphere(1), [(21, -100, 101)] * 2),
        # the corner (1, 1, T + T^2 - 3/2) comes to the floor of the cup
        (fc.RuledSurface("(u, 0, T-1)", "(u, 1, u*T**2 + T - 1)").translated((0, 0, "-1/2")), CUP, [(-1, 1, 1), "1"]),
        # the first side sinks through the ball of radius 1 about the origin, from above
        (fc.RuledSurface("(u, 0, 2 - 4*T)", "(u, 1, 2 - 4*T)", u=(-1, 1)), fc.sphere(1), ["1/4", "3/4"]),
    ],
)
def test_exact_ends(surface, solid, ends):
    (interval,) = fc.contact_intervals(surface, solid, (0, 1), exact=True)
    known = [Fraction(x) if isinstance(x, str) else x for x in ends]
    assert [minimal(x) for x in (interval.start_exact, interval.end_exact)] == known
    hit = fc.first_contact(solid, surface, (0, 1), exact=True)
    assert hit.time_exact == interval.start_exact
    assert hit.element_b.body == (getattr(surface, "name", None) or "b")


def test_what_meets():
    hit = fc.first_contact(DISC.translated((-3, -4, 0)).moving(fc.Translation((3, 4, 0))), fc.sphere(2).named("ball"))
    assert (hit.time, hit.element_a.kind, hit.element_b.kind) == (pytest.approx(0.4, abs=1e-12), "edge", "face")
    assert hit.point == pytest.approx([-1.2, -1.6, 0]) and hit.normal == pytest.approx([-0.6, -0.8, 0])
    bent = fc.RuledSurface("(-1, u, 3 - 3*T)", "(1, u, 3 - 3*T + T*u*(1-u))", name="bent")
    lower = fc.first_contact(fc.box((4, 4, 2)).named("table"), bent, (0, 1))
    assert (lower.time, lower.element_a.label) == (pytest.approx(2 / 3, abs=1e-15), "table.z+")
    assert lower.normal == pytest.approx([0, 0, -1])


@pytest.mark.parametrize("place", ["1/10", "21/50"])
def test_free_by_less_than_doubles_tell(place):
    """In doubles a place seems to lie inside the half space, where it would stay."""
    parts = (f"(u - {place})**2 + {k}/2**80" for k in (1, 2))
    low, high = (f"(u, {k}, {height})" for k, height in enumerate(parts))
    moving = fc.RuledSurface(low, high, u=(0, 1)).moving(fc.Translation((0, 1, 0)))
    assert len(fc.contact_intervals(moving, fc.half_space((0, 0, 1), 0), (0, 1), exact=True)) == 0


@pytest.mark.share(2)
@pytest.mark.parametrize(
    ("box", "way"), [(fc.box((1, 1, 1)), -1), (fc.box((1, 1, 1)), 1), (fc.examples.box((1, 1, 1)), 1)]
)
def test_touching_at_the_start(box, way):
    above = SADDLE.translated((0, 0, "1/2")).moving(fc.Translation((0, 0, way)))
    hit = fc.first_contact(box, above, exact=True)
    assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "touching")
    (interval,) = fc.contact_intervals(above, box, exact=True)
    assert (interval.start, interval.end) == ((0.0, 0.0) if way > 0 else (0.0, 1.0))


@pytest.mark.share(3)
@pytest.mark.parametrize(
    ("surface", "solid", "times"),
    [
        # a corner touches the ball and passes on
        (SADDLE.translated((-5, -2, 0)).moving(fc.Translation((10, 0, 0))), fc.sphere(1), (0.5, 0.5)),
        # a tip comes down on a tip and goes back
        (
            fc.RuledSurface("(0, 0, 4*(T-1/2)**2)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1 + 4*(T-1/2)**2)", u=None),
            fc.cone(1, 2).translated((0, 0, -2)),
            (0.5, 0.5),
        ),
        # at the end of the span alone
        (SADDLE.translated((-5, 0, 0)).moving(fc.Translation((3, 0, 0))), fc.half_space((-1, 0, 0), 1), (1.0, 1.0)),
    ],
)
def test_grazes(surface, solid, times):
    (interval,) = fc.contact_intervals(surface, solid, (0, 1), exact=True)
    assert (interval.start, interval.end) == pytest.approx(times, abs=1e-15)
    hit = fc.first_contact(surface, solid, (0, 1))
    assert (hit.status, hit.time) == (fc.Status.CONTACT, pytest.approx(times[0], abs=1e-12))


def scene(seed):
    rng = np.random.default_rng(seed)

    def curve(deforms):
        parts = [f"{a} + ({b})*u + ({c if deforms else 0})*T" for a, b, c in rng.integers(-2, 3, (3, 3)).tolist()]
        return f"({', '.join(parts)})"

    deforms, trims = seed % 3 == 1, seed % 3 == 2
    trim = ["u**2 + s**2 <= 1"] if trims else []
    while True:
        try:
            surface = fc.RuledSurface(curve(deforms), curve(deforms), u=(-1, 1), trim=trim)
            break
        except fc.InputError:
            continue
    shift = rng.integers(-3, 4, 3)
    solids = fc.sphere(1), fc.box((2, 2, 2)), fc.cone(1, 2), CUP, fc.half_space((0, 0, 1), -1)
    solid = solids[int(rng.integers(0, len(solids)))]
    body = surface.translated(shift.tolist())
    if not deforms:
        turn = fc.Rotation((0, 0, 1), point=rng.integers(-1, 2, 3).tolist(), degrees=90)
        body = body.moving(turn if rng.integers(0, 2) else fc.Translation((-2 * shift).tolist()))
    return surface, shift, body, solid


@pytest.mark.share(3)
@pytest.mark.parametrize("seed", range(amount(30, 10)))
def test_random_scenes(seed):
    """All contacts of samples of the surface are in the intervals, and both ways agree where both answer."""
    surface, shift, body, solid = scene(seed)
    found = fc.contact_intervals(body, solid, (0, 1), exact=True)
    u, s = (x.ravel() for x in np.meshgrid(np.linspace(-1, 1, 41), np.linspace(0, 1, 21)))
    kept = u**2 + s**2 <= 1 if surface.trim else np.ones(len(u), bool)
    for t in np.linspace(0, 1, 17):
        points = (surface.at(t) if surface.deforming else surface).points(u[kept], s[kept]) + shift
        if not surface.deforming:
            pose = body.motion(t)
            points = points @ pose[:3, :3].T + pose[:3, 3]
        if solid.contains(points).any():
            assert any(x.start - 1e-9 <= t <= x.end + 1e-9 for x in found)
    doubles = fc.contact_intervals(body, solid, (0, 1))
    assert [(x.start, x.end) for x in doubles] == [pytest.approx((x.start, x.end), abs=1e-9) for x in found]
    hit = fc.first_contact(solid, body, (0, 1), exact=True)
    assert hit.status is found.status
    if len(found):
        assert hit.time == pytest.approx(found[0].start, abs=1e-12)


def test_coefficients_beyond_the_range_of_doubles():
    """Poses of doubles have rational entries of hundreds of digits; where contact is near an instant they are sized."""
    poses = [fc.Rotation((1, 2, 3), radians=0.3)(1.0), fc.Rotation((1, 0, 2), radians=1.5)(1.0)]
    poses[1][:3, 3] = 6, 1, 0
    flap = fc.RuledSurface("(u, 0, T/2)", "(u, 1, u*T + T**2/2)")
    moved = flap.moving(fc.RationalMotion.between(*poses))
    hit = fc.first_contact(moved, fc.sphere(1).translated((5, 0, 0)), method="algebraic")
    proved = fc.first_contact(moved, fc.sphere(1).translated((5, 0, 0)), method="certified")
    assert hit.status is fc.Status.CONTACT and proved.time_interval[0] <= hit.time <= proved.time_interval[1]
    assert np.allclose(hit.point, proved.point, atol=1e-9)


def test_long_coefficients_are_eliminated_only_where_doubles_do_not_answer():
    """As under poses of doubles, when resultants of small degrees take minutes."""
    f, g = (RING.from_dict({(2, 1, 3): 10**800 + k, (1, 0, 1): 3, (0, 1, k): 1}) for k in (1, 2))
    unit = fmpq(0), fmpq(1)
    quick, all_the_way = (Sheet(None, (f, g), None, False, unit, unit, reach) for reach in (QUICK, FARTHEST))
    with pytest.raises(TooLarge):
        quick.times.sort()
    assert all(p.degree() > 0 for p in all_the_way.times)


@pytest.mark.thorough
def test_many_stretches_of_contact_throughout():
    """Found by the soak: an AssertionError where more stretches were found than are taken one by one."""
    first = fc.RationalCurve([[5.5, -2], [5.5, -5], [1.5, 1.5]], [2, -1])
    second = fc.RationalCurve([[2, -2.5], [11.5, -8], [-5, 4]], [2, -1])
    pose = [[1, 0, 0, 0], [0, 0, -1, -1], [0, 1, 0, 2], [0, 0, 0, 1]]
    piece = fc.RuledSurface(first, second, u=(-1, 1), s=(1, 2)).transformed(pose)
    box = fc.box((1, 2, 2)).transformed(pose).moving(fc.Translation(("8/5", "24/5", "32/5")))
    hit = fc.first_contact(piece, box, (0.625, 1.4375))
    assert (hit.status.name, hit.initial, hit.point.tolist()) == ("INITIAL_CONTACT", "touching", [0.5, 1, 7])
    # by hand: the box is [1/2, 3/2] x [1, 3] x [5, 7] then; s from 1 to 2 goes on beyond the second directrix
    u, s = np.meshgrid(np.linspace(-1, 1, 201), np.linspace(1, 2, 101))
    ends = []
    for rows in ([[5.5, -2], [5.5, -5], [1.5, 1.5]], [[2, -2.5], [11.5, -8], [-5, 4]]):
        x, y, z = ((c[0] + c[1] * u) / (2 - u) for c in rows)
        ends.append(np.array([x, -z - 1, y + 2]))
    places = ends[0] * (1 - s) + ends[1] * s
    low, high = np.array([0.5, 1, 5]), np.array([1.5, 3, 7])
    inside = np.all((places > low[:, None, None] + 1e-9) & (places < high[:, None, None] - 1e-9), axis=0)
    assert not inside.any()
