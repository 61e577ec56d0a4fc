"""Parts that touch in the file and overlap as built, within what they deviate: what is proved of their depth."""

import pickle

import numpy as np
import pytest
import trimesh

pytest.importorskip("OCP")

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402
from firstcontact.body.polyhedron.taken_in import taken_in  # noqa: E402


def winding(mesh, points):
    """(n,) how often the surface winds around points, by solid angles (van Oosterom and Strackee)."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] - points[:, None] for k in range(3))
    x, y, z = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    volume = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    dot = lambda p, q: np.einsum("ijk,ijk->ij", p, q)  # noqa: E731
    rest = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y
    return np.arctan2(volume, rest).sum(axis=1) / (2 * np.pi)


def depth(mesh, points):
    """(n,) distances from the surface."""
    corners = mesh.vertices[mesh.triangles]
    near = (trimesh.triangles.closest_point(corners, np.tile(p, (len(corners), 1))) for p in points)
    return np.array([np.linalg.norm(x - p, axis=1).min() for x, p in zip(near, points, strict=True)])


def test_what_is_deeper_is_in_what_is_taken_in():
    mesh, rng = fc.Polyhedron.load("examples/box.stl"), np.random.default_rng(3)
    lo, hi = mesh.bounds()
    points = rng.uniform(lo, hi, (300, 3))
    points = points[winding(mesh, points) > 0.5][:40]
    far = float(np.quantile(depth(mesh, points), 0.5))
    inner = taken_in(mesh, far)
    moved = np.linalg.norm(inner.vertices - mesh.vertices, axis=1)
    assert moved.max() <= far and np.median(moved) > 0.99 * far
    deep = points[depth(mesh, points) > far]
    assert len(deep) == 20 and (np.abs(winding(inner, deep) - 1.0) < 1e-6).all()
    assert taken_in(mesh, 1e-17) is None  # rounding is more


@pytest.fixture(scope="module")
def block():
    """With a bore of radius 1 along z, as triangles."""
    return fc.from_shape(
        shapes.cut(shapes.box((6, 6, 2), (-3, -3, 0)), shapes.cylinder(1, 9, (0, 0, -1))), name="block", surfaces=False,
        deviation=0.02,
    )


def pin(radius=1.0):
    return fc.from_shape(shapes.cylinder(radius, 4, (0, 0, -1)), name="pin", surfaces=False, deviation=0.02)


def test_a_pin_that_fits_its_bore_overlaps_it_within_the_deviation(block):
    hit = fc.first_contact(pin(), block)
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "overlapping" and hit.within_deviation is True
    assert "no deeper than the parts deviate from the file's: whether the file's overlap is not told" in str(hit)
    assert fc.from_dict(hit.to_dict()) == hit and fc.from_dict(hit.to_dict()).within_deviation is True
    tight = fc.first_contact(pin(1.0 + 3 * hit.model_deviation), block)
    assert tight.initial == "overlapping" and tight.within_deviation is False and "no deeper" not in str(tight)
    ball = fc.sphere("1/2").translated((2, 0, 1))
    assert fc.first_contact(ball, block).within_deviation is False
    assert fc.first_contact(ball, fc.sphere(2)).within_deviation is None


def test_the_pin_goes_out_and_what_is_deeper_is_told(block):
    out = fc.first_new_contact(pin().moving(fc.Translation((0, 0, 9))), block)
    assert out.status is fc.Status.FREE and "no deeper" in out.allowed and out.within_deviation is None
    turned = fc.first_new_contact(pin().moving(fc.Rotation((0, 0, 1), degrees=90)), block)
    assert turned.status is fc.Status.FREE
    aside = fc.first_new_contact(pin().moving(fc.Translation((1, 0, 0))), block)
    assert aside.status is fc.Status.CONTACT
    # the file's cylinders overlap at once, by as much as the pin has moved
    assert 0 < aside.time <= aside.model_deviation
    assert aside.model_deviation == pytest.approx(2 * fc.first_contact(pin(), block).model_deviation)
    assert {aside.element_a.label, aside.element_b.label} == {"pin", "block"}
    tight = fc.first_new_contact(pin(1.2).moving(fc.Translation((0, 0, 9))), block)
    assert tight.status is fc.Status.INITIAL_CONTACT and tight.allowed is None


def test_polygons_that_are_taken_in_keep_their_names():
    """Of a planar part in an odd place, whose corners are off the file's by rounding."""
    turn = ((1, 2, 3), 0.7)
    part = fc.from_shape(shapes.moved(shapes.box((2, 3, 4)), (0, 0, 0), turn), name="part")
    inner = part._with(deviation=0.01, _search={}).taken_in()
    (piece,), (whole,) = inner.pieces, part.pieces
    assert inner.deviation == 0.02 and piece.body.n_faces == 12 and whole.body.n_faces == 6
    named = [piece.names.of("face", k, piece.body) for k in range(12)]
    assert {x[:2] for x in named} == {("face", k) for k in range(6)}
    edges = [piece.names.of("edge", k, piece.body)[0] for k in range(18)]
    assert edges.count("edge") == 12 and edges.count("face") == 6


@pytest.mark.thorough
def test_exact_parts_that_roundings_put_into_each_other_are_let_pass_by_their_triangles():
    """A pin in its bore, tilted: one by OpenCASCADE, the other by the doubles of the same turn."""
    axis, at = (1, 2, 3), (1, 2, 3)
    bored = shapes.cut(shapes.box((6, 6, 2), (-3, -3, 0)), shapes.cylinder(1, 9, (0, 0, -1)))
    block = fc.from_shape(shapes.moved(bored, at, (axis, 0.7)), name="block", deviation=0.01)
    pose = fc.Rotation(axis, radians=0.7)(1)
    pose[:3, 3] = at
    bolt = fc.from_shape(shapes.cylinder(1, 4, (0, 0, -1)), name="pin", deviation=0.01).transformed(pose)
    bolt = pickle.loads(pickle.dumps(bolt))
    up = pose[:3, 2]
    assert bolt.deviation + block.deviation < 1e-12
    hit = fc.first_new_contact(bolt.moving(fc.Rotation(up, at, degrees=90)), block)
    assert hit.status is fc.Status.FREE and "no deeper than twice what their triangles deviate" in hit.allowed
    assert 0.02 < hit.model_deviation <= 0.04
    hit = fc.first_new_contact(bolt.moving(fc.Translation(pose[:3, 0])), block)
    assert hit.status is fc.Status.CONTACT and 0 < hit.time <= hit.model_deviation


@pytest.mark.thorough
def test_a_pin_that_sits_in_its_bore_up_to_its_round_is_told_by_triangles():
    """Pieces of tori that touch along a circle at the start end UNDECIDED."""
    round_ = shapes.filleted(shapes.cylinder(3, 5), 1, shapes.circle_at((3, 0, 5)))
    bored = shapes.cut(shapes.box((12, 12, 6), (-6, -6, -2)), shapes.cylinder(3, 9))
    pin, block = (fc.from_shape(x, name=name, deviation=0.02) for x, name in ((round_, "pin"), (bored, "block")))
    assert pin.deviation + block.deviation < 1e-12
    hit = fc.first_new_contact(pin.moving(fc.Translation((0, 0, 8))), block)
    assert hit.status is fc.Status.FREE and hit.allowed.startswith("touching at the start, no deeper than twice")
