"""Contact intervals under motions without rational pose: against exact arithmetic, sampling, and their own mirrors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.solid import primitives
from firstcontact.body.solid.csg import inside
from firstcontact.contact.models.first import _models
from firstcontact.contact.models.intervals import certified_intervals
from firstcontact.contact.models.standing import prisms_on_common_plane
from firstcontact.kernels.poses import pose_at
from firstcontact.kernels.workspace import HERE_A, workspace
from firstcontact.motion.relative.stretches import windows
from firstcontact.scene.load import load_scene
from firstcontact.timeline.sweep import TimeSweep, reversed_in_time
from firstcontact.work import Query, Work

BALL, SMALL = primitives.sphere(1), primitives.sphere("1/2")
EGG = primitives.ellipsoid((1, 2, "1/2"))
RING = primitives.cylinder(3, 2) - primitives.cylinder("3/2", 4)
SCREW = fc.Screw((0, 0, 1), degrees=360, advance="1/10")


def about(axis, degrees=360):
    return fc.Rotation(axis, degrees=degrees)


SCENES = {
    "balls": (BALL.translated((3, 0, 0)).moving(fc.Translation((-6, "1/3", 0))), BALL),
    "egg": (BALL.translated((3, 0, 0)).moving(about((0, 0, 1))), EGG.translated((0, 3, 0))),
    "frustum": (
        primitives.frustum(2, 1, 1).translated((4, 0, 0)).moving(fc.Rotation((0, 0, 1), (0, 1, 0), degrees=360)),
        EGG.translated((0, 4, 0)),
    ),
    "from the start": (BALL.translated((1, 0, 0)).moving(fc.Translation((-6, "1/3", 0))), BALL),
    "through a ring": (SMALL.translated((5, 0, 0)).moving(fc.Translation((-10, "1/10", 0))), RING),
    "past a ring": (SMALL.translated((5, 0, 0)).moving(fc.Rotation((0, 1, 0), (0, 0, 3), degrees=300)), RING),
}


def forced(a, b):
    found = certified_intervals(_models(Query(a, b, fmpq(0), fmpq(1))), fmpq(0), fmpq(1), 1e-12, Work(), lambda: None)
    assert found.reason is None and found.until == 1
    return found.intervals


def overlap(x, y) -> bool:
    return x[0] <= y[1] and y[0] <= x[1]


@pytest.mark.share(6)
@pytest.mark.parametrize("name", SCENES)
def test_as_exact_arithmetic_tells(name):
    proved, known = forced(*SCENES[name]), fc.contact_intervals(*SCENES[name])
    assert len(proved) == len(known)
    for x, y in zip(proved, known, strict=True):
        assert overlap(x.start, y.start_interval) and overlap(x.end, y.end_interval)
        assert max(x.start[1] - x.start[0], x.end[1] - x.end[0]) <= 1e-12


def share_points(a, b, t, grid) -> bool:
    """Whether a point of the grid in the box of b, which rests, is inside both at t."""
    pose = np.linalg.inv(a.motion(t))
    held = []
    for model, x in ((a.body, grid @ pose[:3, :3].T + pose[:3, 3]), (b, grid)):
        x = np.column_stack([x, np.ones(len(x))])
        held.append(inside(model.tree, list(np.einsum("ni,sij,nj->sn", x, model.forms, x, optimize=True) < 0)))
    return bool(np.any(held[0] & held[1]))


@pytest.mark.share(2)
@pytest.mark.parametrize("b", [EGG.translated((0, 3, 0)), RING.translated((1, 1, 0))], ids=["egg", "ring"])
def test_a_screw_against_samples(b):
    a = SMALL.translated((3, 0, 0)).moving(SCREW)
    found = fc.contact_intervals(a, b)
    assert found.status in (fc.Status.CONTACT, fc.Status.INITIAL_CONTACT) and found.reason is None
    lo, hi = b.bounds()
    grid = lo + np.random.default_rng(1).uniform(size=(20_000, 3)) * (hi - lo)
    for t in np.linspace(0.001, 0.999, 60):
        held = any(x.start <= t <= x.end for x in found)
        near = any(abs(t - end) < 0.02 for x in found for end in (x.start, x.end))
        assert share_points(a, b, t, grid) == held or near, t


@pytest.mark.thorough
def test_backwards_and_in_parts():
    a, b = SMALL.translated((3, 0, 0)), EGG.translated((0, 3, 0))
    whole = fc.contact_intervals(a.moving(SCREW), b)
    (x,) = whole
    assert fc.first_contact(a.moving(SCREW), b).time == pytest.approx(x.start, abs=1e-11)
    end = a.transformed(np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.1], [0, 0, 0, 1]]))
    (y,) = fc.contact_intervals(end.moving(fc.Screw((0, 0, 1), degrees=-360, advance="-1/10")), b)
    assert (1 - y.end, 1 - y.start) == pytest.approx((x.start, x.end), abs=1e-11)
    middle = 0.5 * (x.start + x.end)
    (p,), (q,) = (fc.contact_intervals(a.moving(SCREW), b, span=s) for s in ((0, middle), (middle, 1)))
    assert overlap(p.start_interval, x.start_interval) and overlap(q.end_interval, x.end_interval)
    assert p.end_interval == (middle, middle) == q.start_interval


def test_after_an_irrational_step_contact_goes_on():
    steps = [fc.Rotation((0, 0, 1), degrees=80), fc.Rotation((0, 0, 1), degrees=100)]
    a, b = BALL.translated((3, 0, 0)), EGG.translated((0, 3, 0))
    (x,) = fc.contact_intervals(a.moving(fc.Sequence(steps, [80, 100])), b)
    (y,) = fc.contact_intervals(a.moving(about((0, 0, 1), 180)), b)
    assert (x.start, x.end) == pytest.approx((180 * y.start, 180 * y.end), abs=1e-9)


def test_the_pin_stays_in_the_plate():
    bodies = load_scene(Path(__file__).parent / "data" / "pin_in_plate.toml").bodies
    found = fc.contact_intervals(bodies["pin"], bodies["plate"])
    (x,) = found
    assert found.status is fc.Status.CONTACT and x.start == pytest.approx(0.67871408997, abs=1e-11)
    assert x.end_interval == (1.0, 1.0)


def test_a_budget_and_exact_ends():
    a, b = BALL.translated((3, 0, 0)).moving(SCREW), EGG.translated((0, 3, 0))
    seen = []
    found = fc.contact_intervals(a, b, budget=10, progress=lambda t, done: seen.append(done))
    assert found.status is fc.Status.UNDECIDED and found.reason == "budget" and seen == list(range(1, 11))
    assert found.free_until < 1 and all(x.end_interval[1] == 1.0 for x in found)
    with pytest.raises(fc.UnsupportedPair):
        fc.contact_intervals(a, b, exact=True)


@pytest.mark.parametrize("motion", [SCREW, fc.Translation((1, 2, 3))])
def test_windows_reversed_in_time(motion):
    (window,) = windows(BALL.moving(motion), BALL, fmpq(0), fmpq(1))
    mirror, w = reversed_in_time(window), workspace()[0]
    for t in (0.0, 0.3, 1.0):
        pose_at(window.a, t, w, HERE_A)
        there = w[HERE_A].copy()
        pose_at(mirror.a, -t, w, HERE_A)
        assert np.array_equal(there, w[HERE_A])


@pytest.mark.thorough
def test_the_number_of_contacts_is_not_limited(monkeypatch):
    """Stretches are counted within one contact: the limit once was for all of them."""
    monkeypatch.setattr(TimeSweep, "most_turns", 3)
    post = primitives.cylinder("1/4", 4).translated((2, 0, 0))
    ball = SMALL.translated((-2, 0, 0)).moving(fc.Screw((0, 0, 1), degrees=360 * 5, advance="1/10"))
    found = fc.contact_intervals(ball, post)
    assert found.status is fc.Status.CONTACT and len(found) == 5


def test_a_span_that_ends_beside_its_double():
    """ZeroDivisionError: the double 0.3 is below 3/10, and contact was followed to the next one."""
    box = primitives.box((1, 1, 1)).moving(fc.Screw((0, 0, 1), degrees=30, advance=1))
    (x,) = fc.contact_intervals(box, primitives.box((1, 1, 4)), span=(0, "3/10"), method="certified")
    assert (x.start, x.end) == (0.0, 0.3)


def test_boxes_that_are_flush_in_the_last_instant_of_a_screw():
    """Finer arithmetic proved less than a double's step of time again and again, for ever."""
    box = primitives.box((2, 2, 2))
    found = fc.contact_intervals(box.translated((0, 0, 5)).moving(fc.Screw((0, 0, 1), degrees=90, advance=-3)), box)
    assert found.status is fc.Status.CONTACT
    (one,) = found.intervals
    assert 1 - 1e-12 < one.start_interval[0] and one.start_interval[1] == one.start == one.end == 1


BLOCK = primitives.box((1, 1, 1)).translated((0, 0, "1/2"))
TABLE = primitives.cylinder(3, 1).translated((0, 0, "-1/2"))
TURNING = fc.Rotation((0, 0, 1), ("1/4", 0, 0), degrees=100)


def test_contact_is_followed_through_any_number_of_steps():
    """What lasted longer than 20 steps was left open, and exact arithmetic looked at every step for a minute."""
    steps = fc.Sequence([fc.Translation(("1/10", 0, 0)) for _ in range(60)])
    found = fc.contact_intervals(BALL.translated(("-61/20", 0, 0)).moving(steps), BALL, method="certified")
    assert found.status is fc.Status.CONTACT
    (one,) = found.intervals
    assert overlap(one.start_interval, (21 / 120, 21 / 120)) and overlap(one.end_interval, (101 / 120, 101 / 120))


def test_a_block_slides_off_a_round_table_that_turns():
    """They share no inner point: their faces do, as long as the middle of the table is less than 3 from the block's."""
    way = fc.Translation((4, "1/10", 0))
    found = fc.contact_intervals(BLOCK.moving(way), TABLE.moving(TURNING), span=(0.75, 1))
    assert found.status is fc.Status.INITIAL_CONTACT and len(found) == 1 and found[0].start == 0.75
    end = found[0].end
    gap = np.maximum(np.abs(TURNING(end)[:2, 3] - way(end)[:2, 3]) - 0.5, 0)
    assert np.hypot(*gap) == pytest.approx(3, abs=1e-10) and found[0].end_interval[1] - end < 1e-10


def test_what_does_not_stand_on_a_face_is_left_as_it_is():
    way, along = fc.Translation((4, "1/10", 0)), TABLE.moving(TURNING)
    assert prisms_on_common_plane(BLOCK.moving(way), along) is not None
    assert prisms_on_common_plane(BLOCK.moving(way), TABLE) is None  # algebra's
    for other in (
        BLOCK.moving(fc.Translation((4, 0, "1/10"))), BLOCK.moving(SCREW), BLOCK.translated((0, 0, -1)).moving(way),
        BALL.translated((0, 0, 1)).moving(way), BLOCK.rotated((1, 0, 0), degrees=45).translated((0, 0, 1)).moving(way),
        RING.translated((0, 0, 1)).moving(way), BLOCK.moving(fc.Rotation((1, 0, 0), degrees=10)),
    ):  # fmt: skip
        assert prisms_on_common_plane(other, along) is None
