"""Polyhedra of any shape against curved models: by triangles and parity, beside models made of convex parts."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from contact_places import assert_place
from firstcontact.contact.mesh_model.first import first
from firstcontact.motion.span import common_span
from firstcontact.work import Query

CORNERS = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
UP = fc.Translation((0, 0, 1))
BALL = fc.sphere("1/4")


def ell() -> fc.Polyhedron:
    """A prism over an L, its inner corner at (1, 1)."""
    rings = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]]
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    return fc.Polyhedron([(x, y, z) for z in (0, 1) for x, y in CORNERS], rings + sides, name="ell")


ELL = ell()
ELL_OF_BOXES = fc.box((2, 1, 1)).translated((1, 0.5, 0.5)) | fc.box((1, 2, 1)).translated((0.5, 1, 0.5))


def by_triangles(a, b) -> fc.FirstContact:
    return first(Query(a, b, *common_span(a, b, None)))


def random_model(rng) -> fc.CompositeQuadric:
    s = rng.uniform(0.2, 0.8, 3)
    makers = (
        lambda: fc.sphere(s[0]), lambda: fc.ellipsoid(s), lambda: fc.cylinder(s[0], s[1]), lambda: fc.cone(s[0], s[1]),
        lambda: fc.box(s), lambda: fc.box(s) | fc.sphere(s.min() * 0.6),
    )  # fmt: skip
    return makers[rng.integers(len(makers))]().rotated(rng.normal(size=3), degrees=float(rng.uniform(0, 180)))


def random_motion(rng, toward) -> object:
    """A motion that carries bodies about along `toward`."""
    kind = rng.integers(5)
    if kind == 0:
        return fc.Translation(toward + rng.normal(size=3) * 0.3)
    if kind == 1:
        return fc.Screw(toward, rng.normal(size=3), degrees=float(rng.uniform(-200, 200)), advance=2.5)
    if kind == 2:
        return fc.Rotation(rng.normal(size=3), -toward, degrees=float(rng.uniform(-300, 300)))
    if kind == 3:
        return fc.Sequence([fc.Translation(toward * 0.4), fc.Rotation((0, 0, 1), degrees=90), fc.Translation(toward)])
    pose = fc.Rotation(rng.normal(size=3), degrees=80)(1.0)
    pose[:3, 3] = toward
    return fc.RationalMotion.between(np.eye(4), pose)


def assert_same(found, expected) -> None:
    assert found.status is expected.status
    assert found.initial == expected.initial
    for hit in (found, expected):
        assert_place(hit, hit.a, hit.b)
    if expected.status is fc.Status.CONTACT:
        lo, hi = found.time_interval
        assert lo <= found.time <= hi and hi - lo <= 1.0001e-12 * (found.span[1] - found.span[0])
        assert abs(found.time - expected.time) <= 2e-12
        np.testing.assert_allclose(found.point, expected.point, atol=1e-6)
        np.testing.assert_allclose(found.normal, expected.normal, atol=1e-5)


@pytest.mark.thorough
def test_a_mesh_and_its_decomposition_agree_under_every_motion():
    rng = np.random.default_rng(27)
    seen = {status: 0 for status in fc.Status}
    for k in range(40):
        place = rng.normal(size=3) * 1.5 + (0.8, 0.8, 0.5)
        model = random_model(rng).translated(place)
        mover = random_motion(rng, np.array([0.8, 0.8, 0.5]) - place)
        other = random_motion(rng, rng.normal(size=3) * 0.3) if k % 3 == 0 else fc.Translation((0, 0, 0))
        pairs = [(x.moving(other), model.moving(mover)) for x in (ELL, ELL_OF_BOXES)]
        if k % 2:
            pairs = [(b, a) for a, b in pairs]
        found, expected = (fc.first_contact(*pair) for pair in pairs)
        seen[expected.status] += 1
        if expected.status is not fc.Status.UNDECIDED:
            assert_same(found, expected)
    assert min(seen[s] for s in (fc.Status.FREE, fc.Status.CONTACT, fc.Status.INITIAL_CONTACT)) >= 5


def test_triangles_and_features_of_a_convex_polyhedron_agree():
    rng = np.random.default_rng(5)
    contacts = 0
    for _ in range(14):
        block = fc.examples.box(rng.uniform(0.3, 1.2, 3)).rotated(rng.normal(size=3), degrees=float(rng.uniform(0, 90)))
        place = rng.normal(size=3) * 1.2
        pair = block, random_model(rng).translated(place).moving(random_motion(rng, -place))
        found, expected = by_triangles(*pair), fc.first_contact(*pair)
        if expected.status is not fc.Status.UNDECIDED:
            assert_same(found, expected)
        if expected.status is fc.Status.CONTACT:
            contacts += 1
            assert (found.element_a, found.element_b) == (expected.element_a, expected.element_b)
    assert contacts >= 3


@pytest.mark.share(2)
@pytest.mark.parametrize(
    ("place", "ball", "kind"),
    [
        (("1/2", "1/2", "5/4"), BALL, "touching"),
        (("5/4", "5/4", "1/2"), BALL, "touching"),  # both walls of the inner corner
        (("1/2", "1/2", "1"), BALL, "overlapping"),
        (("1/2", "1/2", "1/4"), BALL, "overlapping"),  # inside, and touching the floor
        (("1/2", "1/2", "1/2"), BALL, "containment"),
        ((1, 1, 0), fc.sphere(9), "containment"),
        ((1, 1, 0), fc.box((8, 8, 8)) | fc.sphere(5), "containment"),
        (("1/2", "1/2", 0), fc.cylinder("1/10", 9), "overlapping"),  # through two faces, all vertices outside
        ((-1, -2, 3), fc.sphere(3), "touching"),  # a vertex
        (("1/2", "1/3", "3/2"), fc.cylinder("1/4", 1), "touching"),  # face on face
    ],
)
def test_starts_in_contact_are_told_apart(place, ball, kind):
    hit = fc.first_contact(ball.translated(place).moving(UP), ELL)
    assert hit.status is fc.Status.INITIAL_CONTACT
    assert hit.initial == kind and hit.time == 0.0 and hit.normal is None
    assert fc.first_contact(ELL, ball.translated(place).moving(UP)).initial == kind


def test_outside_in_the_hollow_is_free():
    assert fc.first_contact(BALL.translated((1.6, 1.6, 0.5)).moving(UP), ELL).status is fc.Status.FREE


def test_a_start_in_contact_under_a_screw():
    hit = fc.first_contact(BALL.translated(("1/2", "1/2", "5/4")).moving(fc.Screw((0, 0, 1), turns=1, advance=1)), ELL)
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "touching"
    assert str(hit.element_b) == "ell face 1"


def test_exact_times_and_names():
    ball = BALL.translated(("8/5", "8/5", "1/2"))
    hit = fc.first_contact(ball.moving(fc.Translation((-1, -1, 0))), ELL, exact=True)
    assert hit.time_exact == Fraction(7, 20) and hit.multiplicity == 2
    assert {str(hit.element_b), str(hit.others[0].element_b)} == {"ell face 4", "ell face 5"}
    over = BALL.translated(("1/2", "1/2", "5/4")).moving(fc.Translation((0, 3, 0)))
    graze = fc.first_contact(BALL.translated(("1/2", -2, "5/4")).moving(fc.Translation((0, 3, 0))), ELL)
    assert graze.time == 2 / 3 and graze.element_b.kind == "edge"
    assert ELL.edges[graze.element_b.index].tolist() == [6, 7]
    assert fc.first_contact(over, ELL).initial == "touching"


def test_the_tip_of_a_cone_and_an_edge_of_the_mesh_are_named():
    cone = fc.cone("1/4", "1/2").rotated((1, 0, 0), degrees=180).translated(("1/2", "1/3", 3)).named("pick")
    hit = fc.first_contact(cone.moving(fc.Translation((0, 0, -2))), ELL)
    assert abs(hit.time - 0.75) < 1e-12 and hit.element_a.kind == "apex" and str(hit.element_b) == "ell face 1"
    np.testing.assert_allclose(hit.point, (0.5, 1 / 3, 1), atol=1e-12)
    hit = fc.first_contact(BALL.translated((1, -2, "11/10")).moving(fc.Translation((0, 2, 0))), ELL)
    assert ELL.edges[hit.element_b.index].tolist() == [6, 7] and hit.element_b.kind == "edge"
    assert abs(2 * hit.time - (2 - np.sqrt(0.25**2 - 0.1**2))) < 1e-12


def test_common_motions_and_scales_change_nothing():
    ball = fc.sphere("1/5").translated((1.7, 1.8, 0.4))
    mover = fc.Translation((-1, -0.9, 0.1))
    expected = fc.first_contact(ball.moving(mover), ELL)
    assert expected.status is fc.Status.CONTACT
    for factor in (2.0**-30, 2.0**20):
        scale = np.diag([factor, factor, factor, 1.0])
        moved = ball.transformed(scale).moving(fc.Translation(np.array([-1, -0.9, 0.1]) * factor))
        found = fc.first_contact(moved, ELL.transformed(scale))
        assert abs(found.time - expected.time) <= 1e-12
        assert (found.element_a, found.element_b) == (expected.element_a, expected.element_b)
    far = np.array((300, -200, 100))
    found = fc.first_contact(ball.translated(far).moving(mover), ELL.translated(far))
    assert abs(found.time - expected.time) <= 2e-12


def test_gears_and_noisy_meshes_are_free_before_and_in_contact_after():
    """Vertices and points on the model's surface tell, independently of the search."""
    rng = np.random.default_rng(3)
    contacts = 0
    for make in (fc.examples.spur_gear, fc.examples.torus, fc.examples.noisy_sphere):
        mesh = make(500)
        for model in (fc.sphere("1/5"), fc.cylinder("1/10", "1/2"), fc.cone("1/5", "1/3")):
            model = model.translated((1.6, 0.1, 0.05))
            motion = fc.Screw((-1, *rng.normal(size=2) * 0.2), (1, 0.2, 0), degrees=90, advance=1)
            hit = fc.first_contact(model.moving(motion), mesh)
            skin = model.to_mesh(0.05).vertices[::3]
            for t in np.linspace(0, 1.0 if hit.time is None else hit.time - 1e-9, 6):
                pose = motion(t)
                assert not model.contains((mesh.vertices - pose[:3, 3]) @ pose[:3, :3]).any()
                assert not inside(mesh, skin @ pose[:3, :3].T + pose[:3, 3]).any()
            assert_place(hit, hit.a, hit.b)
            if hit.status is fc.Status.CONTACT:
                contacts += 1
                pose = motion(hit.time)
                beside = [pose[:3, :3].T @ (hit.point + s * hit.normal - pose[:3, 3]) for s in (1e-6, -1e-6)]
                assert model.contains(beside).tolist() == [True, False]
                assert np.abs(distance_to(mesh, hit.point)) < 1e-9
    assert contacts >= 5


def inside(mesh, points) -> np.ndarray:
    """(n,) bools by winding numbers: sums of solid angles."""
    x = mesh.vertices[mesh.triangles]
    found = []
    for p in points:
        a, b, c = (x[:, k] - p for k in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        low = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        found.append(abs(np.arctan2(top, low).sum()) > np.pi)
    return np.array(found)


def distance_to(mesh, point) -> float:
    """From a point to the nearest plane of a triangle whose sides it is inside of, up to a little."""
    x = mesh.vertices[mesh.triangles]
    n = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    n /= np.linalg.norm(n, axis=1)[:, None]
    near = np.full(len(x), True)
    for s in range(3):
        side = np.cross(x[:, (s + 1) % 3] - x[:, s], n)
        near &= ((point - x[:, s]) * side).sum(1) <= 1e-9 * np.linalg.norm(side, axis=1)
    return float(np.abs(((point - x[:, 0]) * n).sum(1))[near].min())


def test_surfaces_edges_and_points_without_inside():
    ball = BALL.translated(("1/2", "1/2", "1/2"))
    lid = fc.Polyhedron(ELL.vertices, ELL.triangles[4:8], name="lid")
    hit = fc.first_contact(ball.moving(UP), lid)
    assert abs(hit.time - 0.25) < 1e-12 and hit.element_b.label == "lid"
    bars = fc.Polyhedron(ELL.vertices, [], edges=ELL.edges)
    hit = fc.first_contact(ball.translated((0, -0.5, 0.1)).moving(fc.Translation((2, 0, 0))), bars)
    assert hit.element_b.kind == "edge" and bars.edges[hit.element_b.index].tolist() == [1, 7]
    points = fc.Polyhedron([[3, 0.5, 0.5], [9, 9, 9]], [])
    hit = fc.first_contact(ball.moving(fc.Translation((3, 0, 0))), points)
    assert abs(hit.time - 0.75) < 1e-12 and (hit.element_b.kind, hit.element_b.index) == ("vertex", 0)


def test_floors_budgets_and_single_instants():
    floor = fc.half_space((0, 0, 1), -3)
    hit = fc.first_contact(floor, ELL.moving(fc.Translation((0, 0, -5))))
    assert abs(hit.time - 0.6) < 1e-12 and hit.contact_set is None  # it lands on a whole face
    lifted = BALL.translated(("1/2", "1/2", "5/4")).moving(UP)
    assert fc.first_contact(lifted, ELL, span=(0, 0)).initial == "touching"
    assert fc.first_contact(lifted, ELL, span=(0.5, 0.5)).status is fc.Status.FREE
    stopped = fc.first_contact(BALL.translated((1.7, 1.6, 0.5)).moving(fc.Translation((-1, -1, 0))), ELL, budget=2)
    assert stopped.status is fc.Status.UNDECIDED and stopped.reason == "budget" and stopped.free_until < 0.35


def test_a_jump_into_the_mesh_is_a_contact_at_that_time():
    apart, within = np.eye(4), np.eye(4)
    apart[:3, 3], within[:3, 3] = (0, 0, 5), (0.5, 0.5, -4.5)  # the second step is made where the first one ended
    steps = [fc.RationalMotion([apart]), fc.RationalMotion([within])]
    hit = fc.first_contact(BALL.moving(fc.Sequence(steps)), ELL)
    assert hit.status is fc.Status.CONTACT and hit.time == 0.5
