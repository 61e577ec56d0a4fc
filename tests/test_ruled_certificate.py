"""Events of ruled surfaces in ball arithmetic: their systems, and answers that doubles alone leave open."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.ruled_solid.certified import RuledAndSolid
from firstcontact.exact.numbers import precision
from firstcontact.exact.systems.isolation import isolated
from firstcontact.exact.systems.square_systems import Equations
from firstcontact.search.events.pose_jets import PoseJet
from firstcontact.search.events.ruled_certificate import EventSystem
from firstcontact.search.events.ruled_solids import RuledSolidEvent
from firstcontact.work import Query

WING = fc.RuledSurface(
    "(u/4 - u**4, (u - 2*u**3)/(1 + u**2), -u**2)", "(u**3/2, 3*u - u**4/4, 1)", u=(0, 3), name="wing"
)
SOLIDS = [
    fc.sphere(1), fc.box((1, 2, 1)), fc.cone(1, 2), fc.cylinder(1, 2) - fc.cylinder("1/2", 3),
    fc.hyperboloid((1, 1, 1), 2),
]  # fmt: skip


class Circle(Equations):
    """x^2 + y^2 = 2 and x y = c: four points, or for c = 1 two double ones."""

    def __init__(self, c: fmpq) -> None:
        self.c = c

    def values(self, z):
        return [z[0] ** 2 + z[1] ** 2 - 2, z[0] * z[1] - arb(self.c)]

    def jacobian(self, z):
        return [[2 * z[0], 2 * z[1]], [z[1], z[0]]]


def test_all_zeros_are_isolated():
    found = isolated(Circle(fmpq(1, 2)), [[arb(0, 2), arb("0.01", 2)]])
    places = sorted(tuple(float(c) for c in zero.balls(64)) for zero in found.zeros)
    x, y = (3**0.5 + 1) / 2, (3**0.5 - 1) / 2
    assert np.allclose(places, [(-x, -y), (-y, -x), (y, x), (x, y)], atol=1e-15) and not found.left


def test_double_zeros_are_left():
    found = isolated(Circle(fmpq(1)), [[arb(0, 2), arb("0.01", 2)]])
    assert not found.zeros
    for point in ((1, 1), (-1, -1)):
        assert any(all(side.contains(c) for side, c in zip(box, point, strict=True)) for box in found.left)
    assert not isolated(Circle(fmpq(3, 2)), [[arb(0, 2), arb("0.01", 2)]]).zeros


class TwiceTheSame(Equations):
    """t = 0, whatever u is, by both equations."""

    def values(self, z):
        u, t = z
        return [t + t**2 * (2 + u), t - t**2 * (1 + u)]

    def jacobian(self, z):
        u, t = z
        return [[t**2, 1 + 2 * t * (2 + u)], [-(t**2), 1 - 2 * t * (1 + u)]]


def test_sides_next_to_a_zero_at_0_do_not_shrink_for_ever():
    """They did by squares, while the other side was halved: as rationals their bounds filled the memory."""
    found = isolated(TwiceTheSame(), [[arb("0.1", 0.5), arb("0.01", 0.1)]], 200)
    assert not found.zeros and found.left
    for _, t in found.left:
        assert t.rad() > arb(2) ** -130 and t.contains(0)


@pytest.mark.share(2)
@pytest.mark.parametrize(
    "motion",
    [
        fc.Screw((1, 2, 0), point=(1, 0, 3), degrees=100, advance=3),
        fc.RationalMotion.between(np.eye(4), fc.Rotation((0, 1, 2), point=(0, 0, 1), degrees=70)(1.0)),
    ],
)
@pytest.mark.parametrize("way", [1, -1])
def test_derivatives_of_event_systems(motion, way):
    pair = RuledAndSolid(Query(WING, SOLIDS[3].moving(motion), fmpq(0), fmpq(1)))
    window = pair.windows[0]
    step, kinds = fmpq(1, 2**90), set()
    with precision(400):
        poses = tuple(PoseJet(pair.bodies[k], window, way) for k in (0, 1))
        for chart, (feature, row) in enumerate(zip(pair.tables.features, pair.tables.info, strict=True)):
            for k in range(row[3], row[4]):
                box = np.array([chart, k, 0.1, 0, 0.3, 0, 0.2, 0.2])
                event = RuledSolidEvent(pair.bodies, 0, pair.tables, chart, k, box)
                system = EventSystem(event, poses)
                kinds.add((feature.kind, type(event.other).__name__))
                z = [arb(fmpq(j + 2, 7)) for j in range(len(event.free))] + [arb(way * fmpq(3, 8))]
                slopes, here = system.jacobian(z), system.values(z)
                assert len(here) == len(z)
                for j in range(len(z)):
                    ahead = system.values([c + arb(step) if i == j else c for i, c in enumerate(z)])
                    for slope, p, q in zip((row_of[j] for row_of in slopes), ahead, here, strict=True):
                        assert abs((p - q) / arb(step) - slope).mid() < 1e-16 * (1 + abs(slope)).mid()
    assert kinds >= {("face", x) for x in ("Face", "Edge")} | {("directrix", x) for x in ("Face", "Edge")}


def scene(seed):
    """A wing many times larger than the solid, whose contact rounding blurs over more than 1e-12 of the span."""
    rng = np.random.default_rng(seed)
    solid = SOLIDS[seed % 5].rotated(rng.integers(1, 5, 3), degrees=int(rng.integers(0, 180)))
    solid = solid.translated(rng.integers(-6, 7, 3) / 2 + np.array([5, 0, 0]))
    motions = [
        lambda: fc.Translation(rng.integers(-3, 4, 3) + np.array([8, 0, 0])),
        lambda: fc.Rotation(rng.integers(1, 4, 3), point=rng.integers(-3, 4, 3), degrees=int(rng.integers(60, 300))),
        lambda: fc.Screw(rng.integers(1, 4, 3), degrees=200, advance=float(rng.integers(4, 12))),
    ]
    return WING.translated(rng.integers(-4, 5, 3)), motions[seed % 3](), solid


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [16, 14, 1, *range(20, 20 + amount(40, 40))])
def test_large_surfaces_and_small_solids(seed):
    """Contact is decided to 1e-12; an independent truth: sampled points before and after."""
    wing, motion, solid = scene(seed)
    hit = fc.first_contact(wing.moving(motion), solid)
    assert hit.status is not fc.Status.UNDECIDED
    u, s = np.meshgrid(np.linspace(0, 3, 200), np.linspace(0, 1, 60))
    points = wing.points(u, s).reshape(-1, 3)

    def shares(t):
        pose = motion(t)
        return solid.contains(points @ pose[:3, :3].T + pose[:3, 3]).any()

    if hit.status is fc.Status.INITIAL_CONTACT:
        return
    assert not any(shares(t) for t in np.linspace(0.0, hit.free_until, 40)[:-1])
    found = fc.contact_intervals(wing.moving(motion), solid)
    assert found.status is hit.status
    if hit.status is fc.Status.CONTACT:
        lo, hi = hit.time_interval
        assert hi - lo <= 1e-12 and lo <= hit.time <= hi
        assert found[0].start_interval[0] <= hi and lo <= found[0].start_interval[1]
        for t in np.linspace(0.0, 1.0, 40):
            assert any(x.start <= t <= x.end for x in found) or not shares(t)


def test_laws():
    wing, motion, solid = scene(14)
    solid = solid.named("solid")
    hit = fc.first_contact(wing.moving(motion), solid)
    swapped = fc.first_contact(solid, wing.moving(motion))
    assert hit.status is fc.Status.CONTACT and swapped.time == hit.time and swapped.element_a == hit.element_b
    before, after = (0, hit.time - 0.01), (hit.time - 0.01, 1)
    assert fc.first_contact(wing.moving(motion), solid, before).status is fc.Status.FREE
    again = fc.first_contact(wing.moving(motion), solid, after)
    assert again.time == pytest.approx(hit.time, abs=2e-16)


def test_two_surfaces():
    """A cylinder of degree 4 and radius 2^20 falls on a saddle's corner: rounding is 1e-10 of the span."""
    far = 2**20
    drum = fc.RuledSurface(
        f"({far}*2*u/(1+u**2), -1, {far}*(1-u**2)/(1+u**2) - {far})",
        f"({far}*2*u/(1+u**2), 2, {far}*(1-u**2)/(1+u**2) - {far})", u=(-1, 1), name="drum",
    )  # fmt: skip
    saddle = fc.RuledSurface("(u/3, 0, u)", "(u/3, 1, 1 + u**2)", name="saddle").translated((0, 0, "1/7"))
    fall = fc.Translation((0, 0, -1))
    hit = fc.first_contact(saddle.moving(fall), drum, method="certified")
    exact = fc.first_contact(saddle.moving(fall), drum, method="algebraic")
    assert hit.status is fc.Status.CONTACT
    assert hit.time_interval[0] <= exact.time <= hit.time_interval[1] <= hit.time_interval[0] + 1e-12
