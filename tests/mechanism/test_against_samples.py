"""Arms of several joints against poses by SciPy and distances by coal, which share nothing with the library."""

from __future__ import annotations

import math

import numpy as np
import pytest

import firstcontact as fc
from mechanism import oracle

pytest.importorskip("coal")
AXES = [(0, 0, 1), (0, 1, 0), (1, 2, 2), (0, 1, 1)]
LIMBS = ("upper", "fore", "hand")


def arm(rng, obstacles=3):
    """A mechanism of three limbs, (axis, point) of its joints, and all bodies by their names."""
    points = [(0, 0, 0), (1, 0, 0), (1.75, 0, 0)]
    axes = [AXES[k] for k in rng.permutation(len(AXES))[:3]]
    limbs = [
        fc.examples.box((0.875, 0.1875, 0.25)).translated((x + 0.5, 0, 0)).named(n)
        for x, n in zip((0, 1, 1.75), LIMBS, strict=True)
    ]
    things = []
    for k in range(obstacles):
        place = rng.uniform(-1, 1, 3) * (0.7, 1.2, 0.9) + (1.5, 0, 0)
        place[1] += 0.4 * np.sign(place[1])
        things.append(fc.examples.box(rng.uniform(0.1, 0.5, 3)).translated(place.round(3)).named(f"thing{k}"))
    links = {"world": things, **{name: limb for name, limb in zip(LIMBS, limbs, strict=True)}}
    parents = ("world", *LIMBS[:2])
    joints = [
        fc.Joint(f"q{k}", "revolute", parents[k], LIMBS[k], axis=axes[k], point=points[k], limits=(-180, 180))
        for k in range(3)
    ]
    bodies = {x.name: x for x in [*things, *limbs]}
    lines = list(zip(axes, points, strict=True))
    return fc.Mechanism(links, joints, skip=[("upper", "fore"), ("fore", "hand")]), lines, bodies


def poses(lines, angles):
    """Of each body at joint values in degrees."""
    found, pose = {}, np.eye(4)
    for name, line, angle in zip(LIMBS, lines, angles, strict=True):
        pose = pose @ oracle.turn(*line, angle)
        found[name] = pose
    return found


class Truth:
    def __init__(self, lines, bodies):
        self.lines, self.shapes = lines, {name: oracle.coal_mesh(body) for name, body in bodies.items()}

    def distance(self, a, b, angles):
        placed = poses(self.lines, angles)
        return oracle.distance(
            self.shapes[a], placed.get(a, np.eye(4)), self.shapes[b], placed.get(b, np.eye(4))
        )


def judged(answer, truth, angles_at, samples=1000):
    """Check an answer; returns its status."""
    a, b = answer.a.name, answer.b.name
    first, last = answer.span
    if answer.status is fc.Status.FREE:
        times = np.linspace(first, last, samples)
    else:
        assert answer.status in (fc.Status.CONTACT, fc.Status.INITIAL_CONTACT), answer
        assert truth.distance(a, b, angles_at(answer.time)) < 1e-6
        times = np.linspace(first, answer.time_interval[0], samples // 4, endpoint=False) if answer.time > first else []
        if answer.status is fc.Status.CONTACT:
            distances = [truth.distance(a, b, angles_at(answer.time - step)) for step in (1e-4, 1e-7)]
            assert min(distances) > -1e-9
    for t in times:
        assert truth.distance(a, b, angles_at(t)) > -1e-9, (answer, t)
    return answer.status


@pytest.mark.share(6)
@pytest.mark.parametrize("seed", range(6))
def test_first_contacts_of_an_arm(seed):
    rng = np.random.default_rng(seed)
    mechanism, lines, bodies = arm(rng)
    truth = Truth(lines, bodies)
    times = np.array([0.0, 1.0, 2.0, 3.0])
    values = rng.uniform(-60, 60, (4, 3)).round(2)
    values[0] = 0
    course = mechanism.course(times, {f"q{k}": values[:, k] for k in range(3)})
    statuses = [
        judged(x, truth, lambda t: [np.interp(t, times, v) for v in values.T], 200)
        for x in course.first_contacts()
    ]
    assert len(statuses) == 10


def test_both_answers_are_met():
    """So that the test above judges contacts and misses."""
    met = set()
    for seed in range(3):
        rng = np.random.default_rng(seed)
        mechanism, _, _ = arm(rng)
        values = rng.uniform(-60, 60, (4, 3)).round(2)
        values[0] = 0
        course = mechanism.course(range(4), {f"q{k}": values[:, k] for k in range(3)})
        met |= {x.status for x in course.first_contacts()}
    assert {fc.Status.FREE, fc.Status.CONTACT} <= met


def test_cubic_values_and_many_waypoints():
    """The natural spline is that of SciPy, to rounding; few of 200 stretches are looked into."""
    from scipy.interpolate import CubicSpline

    rng = np.random.default_rng(5)
    mechanism, lines, bodies = arm(rng)
    truth = Truth(lines, bodies)
    times = np.linspace(0, 10, 41)
    values = np.cumsum(rng.normal(size=(41, 3)) * 6, axis=0)
    values[0] = 0
    course = mechanism.course(times, {f"q{k}": values[:, k] for k in range(3)}, interpolation="cubic")
    splines = [CubicSpline(times, v, bc_type="natural") for v in values.T]
    for t in (0.1, 3.3, 9.9):
        pose = course.motion("hand")(t)
        assert pose == pytest.approx(poses(lines, [s(t) for s in splines])["hand"], abs=1e-11)
    for answer in course.first_contacts():
        judged(answer, truth, lambda t: [s(t) for s in splines], 300)


def test_sweeps_tell_all_intervals():
    rng = np.random.default_rng(3)
    mechanism, lines, bodies = arm(rng)
    truth = Truth(lines, bodies)
    rest = {"q0": 20.5, "q1": -30.25}
    (sweep,) = mechanism.sweep("q2", at=rest)
    met = 0
    for pair in sweep.found:
        met += len(pair)
        assert pair.status is not fc.Status.UNDECIDED
        for angle in np.linspace(-180, 180, 721):
            inside = [x.start_interval[0] <= angle <= x.end_interval[1] for x in pair]
            gap = truth.distance(pair.a.name, pair.b.name, [20.5, -30.25, angle])
            assert any(inside) == (gap <= 0) or abs(gap) < 1e-6, (pair, angle, gap)
    assert {frozenset((x.a.name, x.b.name)) for x in sweep.found} == {
        frozenset((name, "hand")) for name in ("thing0", "thing1", "thing2", "upper")
    }
    assert met


def test_links_on_a_moving_base_are_exact_beside_each_other():
    """What both hang on is dropped: one turn is left, whose time has an exact form, and the point is in the world."""
    base = fc.examples.box((2, 2, 0.25))
    post = fc.examples.box((0.25, 0.25, 1)).translated((0, 1.5, 0.625))
    lever = fc.examples.box((1, 0.25, 0.25)).translated((1.5, 0, 0.625))
    mechanism = fc.Mechanism(
        {"world": fc.examples.box((1, 1, 1)).translated((0, 0, -5)), "base": base, "post": post, "lever": lever},
        [
            fc.Joint("table", "revolute", "world", "base", axis=(0, 0, 1)),
            fc.Joint("weld", "fixed", "base", "post"),
            fc.Joint("lever", "revolute", "base", "lever", axis=(0, 0, 1)),
        ],
    )
    course = mechanism.course([0, 1], {"table": [0, 75], "lever": [0, 90]})
    hit = fc.first_contact(course.bodies["lever"][0], course.bodies["post"][0], exact=True)
    # the lever's upper side y = 1/8 reaches the post's corner (1/8, 11/8)
    angle = math.degrees(math.atan2(1.375, 0.125) - math.asin(0.125 / math.hypot(1.375, 0.125)))
    assert hit.status is fc.Status.CONTACT and hit.time_exact is not None
    assert hit.joints[-1].name == "lever" and hit.joints[-1].value == pytest.approx(angle, rel=1e-13)
    table = oracle.turn((0, 0, 1), (0, 0, 0), 75 * hit.time)
    x, y, z, _ = np.linalg.inv(table) @ [*hit.point, 1]
    assert (x, y) == pytest.approx((0.125, 1.375), abs=1e-12) and 0.5 - 1e-12 <= z <= 0.75 + 1e-12
    back = table[:3, :3].T @ hit.normal
    turned = math.radians(angle)
    assert back == pytest.approx((math.sin(turned), -math.cos(turned), 0), abs=1e-9)


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_curved_links_meet_where_the_closed_form_says(kind):
    """A ball or a roller at the end of two links of length 1 comes down on a floor."""
    tip = fc.sphere("1/4") if kind == "sphere" else fc.cylinder("1/4", 1).rotated((1, 0, 0), degrees=90)
    floor = fc.box((9, 9, 1)).translated((0, 0, -2))
    mechanism = fc.Mechanism(
        {"floor": floor, "upper": fc.box((1, "1/8", "1/8")).translated((0.5, 0, 0)), "tip": tip.translated((2, 0, 0))},
        [
            fc.Joint("shoulder", "revolute", "floor", "upper", axis=(0, 1, 0)),
            fc.Joint("elbow", "revolute", "upper", "tip", axis=(0, 1, 0), point=(1, 0, 0)),
        ],
    )
    hits = mechanism.course([0, 1], {"shoulder": [0, 60], "elbow": [0, 30]}).first_contacts()
    (hit,) = [x for x in hits if {x.a.name, x.b.name} == {"floor", "tip"}]
    # sin(60 t) + sin(90 t) = 5/4
    t = 0.5
    for _ in range(50):
        p, q = math.radians(60), math.radians(90)
        t -= (math.sin(p * t) + math.sin(q * t) - 1.25) / (p * math.cos(p * t) + q * math.cos(q * t))
    assert hit.status is fc.Status.CONTACT
    assert hit.time == pytest.approx(t, rel=1e-12)
    assert hit.time_interval[0] <= t + 1e-15 and t - 1e-15 <= hit.time_interval[1]
    assert hit.point[2] == pytest.approx(-1.5, abs=1e-12)


def test_the_tolerance_is_a_share_of_the_whole_course():
    """Red before: a small solid late on a long clock was asked for more digits than its time has."""
    tip = fc.box((0.022, 0.008, 0.004)).translated((0.9, 0, 0.02)).named("tip")
    thing = fc.examples.noisy_sphere(300)
    thing = fc.Polyhedron(thing.vertices * 0.05 + (-0.6, 0.62, 0.0), thing.triangles, name="thing")
    links = {"world": thing, "upper": fc.box((0.5, 0.02, 0.02)).translated((0.25, 0, -3)), "tip": tip}
    joints = [
        fc.Joint("q0", "revolute", "world", "upper", axis=(0, 0, 1), unit="rad"),
        fc.Joint("q1", "revolute", "upper", "tip", axis=(1, 2, 9), point=(0.5, 0, 0), unit="rad"),
    ]
    times = 100_000 + np.arange(2000) * 0.1
    values = {"q0": np.linspace(0, 2.5, 2000), "q1": 0.01 * np.sin(times)}
    hits = fc.Mechanism(links, joints).course(times, values).first_contacts()
    (hit,) = [x for x in hits if {x.a.name, x.b.name} == {"thing", "tip"}]
    assert hit.status is fc.Status.CONTACT and hit.time > 100_100
    assert hit.time_interval[1] - hit.time_interval[0] <= 1e-9


@pytest.mark.share(3)
@pytest.mark.parametrize("seed", range(3))
def test_dwells_reversals_and_turns_of_single_joints(seed):
    """Joints that start, stop and turn back: plain turns, products and rest follow each other on one clock."""
    rng = np.random.default_rng(40 + seed)
    mechanism, lines, bodies = arm(rng, 2)
    truth = Truth(lines, bodies)
    times = np.arange(9.0)
    values = np.zeros((9, 3))
    values[1:] = np.cumsum(rng.integers(-1, 2, (8, 3)) * rng.uniform(10, 40, (8, 3)), axis=0).round(1)
    values[4] = values[3]
    course = mechanism.course(times, {f"q{k}": values[:, k] for k in range(3)})
    for answer in course.first_contacts():
        judged(answer, truth, lambda t: [np.interp(t, times, v) for v in values.T], 300)
    for found in course.contact_intervals():
        assert found.status is not fc.Status.UNDECIDED
        for t in np.linspace(0, 8, 401):
            inside = any(x.start_interval[0] <= t <= x.end_interval[1] for x in found)
            gap = truth.distance(found.a.name, found.b.name, [np.interp(t, times, v) for v in values.T])
            assert inside == (gap <= 0) or abs(gap) < 1e-6, (found, t, gap)


def test_solids_and_meshes_of_one_shape_answer_alike():
    """The limbs as solids of planes and as meshes, with dwells at angles that no rational pose has."""
    rng = np.random.default_rng(1)
    mechanism, lines, _ = arm(rng)
    times = np.arange(5.0)
    values = rng.uniform(-50, 50, (5, 3)).round(1)
    values[0], values[3] = 0, values[2]

    def solid(mesh):
        lo, hi = mesh.bounds()
        return fc.box((hi - lo).tolist()).translated((0.5 * (lo + hi)).tolist()).named(mesh.name)

    links = {name: [solid(x) for x in own] for name, own in mechanism.links.items()}
    solids = fc.Mechanism(links, mechanism.joints.values(), skip=mechanism.skip)
    given = {f"q{k}": values[:, k] for k in range(3)}
    pairs = list(zip(mechanism.course(times, given).first_contacts(), solids.course(times, given).first_contacts(),
                     strict=True))  # fmt: skip
    for x, y in pairs:
        assert x.status is y.status and (x.time is None or x.time == pytest.approx(y.time, abs=1e-10))
    assert any(x.status is fc.Status.CONTACT for x, _ in pairs)


@pytest.mark.parametrize("place", [(1.5, 1.5, -0.6), (0.6, 2.2, 0.0)])
def test_ruled_links(place):
    """A twisted sheet on two joints, beside many of its points."""
    sheet = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)").translated((1, 0, 0)).named("sheet")
    links = {"world": fc.box((0.5, 0.5, 0.5)).translated(place), "beam": fc.box((1, 0.1, 0.1)).translated((0.5, 0, -5))}
    joints = [
        fc.Joint("a", "revolute", "world", "beam", axis=(0, 0, 1)),
        fc.Joint("b", "revolute", "beam", "sheet", axis=(0, 1, 0), point=(1, 0, 0)),
    ]
    course = fc.Mechanism({**links, "sheet": sheet}, joints).course([0, 1, 2], {"a": [0, 30, 60], "b": [0, 20, 50]})
    hit = fc.first_contact(course.bodies["sheet"][0], course.bodies["world"][0])
    u, s = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    points = np.stack([1 + u, s, u * s], axis=-1).reshape(-1, 3)

    def gap(t):
        a, b = (np.interp(t, [0, 1, 2], values) for values in ((0, 30, 60), (0, 20, 50)))
        pose = oracle.turn((0, 0, 1), (0, 0, 0), a) @ oracle.turn((0, 1, 0), (1, 0, 0), b)
        beyond = np.abs(points @ pose[:3, :3].T + pose[:3, 3] - place) - 0.25
        return np.linalg.norm(np.maximum(beyond, 0), axis=1).min()

    assert hit.status is fc.Status.CONTACT
    assert gap(hit.time) < 0.01 and min(gap(t) for t in np.linspace(0, hit.time - 0.02, 100)) > 0
    assert gap(hit.time + 0.02) == 0
