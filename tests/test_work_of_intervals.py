"""All times of contact of small solids: told right, and by few questions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import firstcontact as fc

Z = (0, 0, 1)
DRILLED = fc.box((8, 8, 2)) - fc.cylinder(2, 4)
SMALL = fc.box((4, 4, 1)) - fc.cylinder(1, 2)
BALL = fc.sphere("3/2")
ANGLE = (fc.box((4, 2, 1)) | fc.box((2, 4, 1)).translated((1, 1, 0))) - fc.cylinder("1/2", 2).translated((1, 0, 0))
POST = fc.box((4, 1, 1)) | fc.cylinder("1/2", 4).translated((2, 0, 2))
TWICE = fc.box((6, 5, 1)) - fc.cylinder(1, 2).translated((1, 0, 0)) - fc.cylinder("1/2", 2).translated((-2, 1, 0))
SUNK = fc.box((6, 6, 2)) - fc.frustum(1, 2, 2).translated((0, 0, -1))
PIERCED = fc.ellipsoid((1, 2, "3/2")) - fc.cylinder("1/2", 6)

SCENES = {
    "ball through a hole": (
        BALL.translated((1, 0, 6)).moving(fc.Translation((0, 0, -12))), DRILLED,
        [((5 - 5**0.5 / 2) / 12, (7 + 5**0.5 / 2) / 12)],
    ),
    "two drilled plates": (
        SMALL.translated(("1/2", 0, 5)).moving(fc.Translation((0, 1, -10))), DRILLED, [(0.35, 0.65)],
    ),
    "a drilled plate that turns up and comes back to stay": (
        SMALL.translated((7, 0, 0)).moving(fc.Rotation((0, 1, 0), point=(0, 0, 4), degrees=90)), DRILLED, None,
    ),
    "a post along an angle": (
        POST.translated((-8, 0, 0)).moving(fc.Translation((12, 0, 0))), ANGLE, [(3.5 / 12, 1)],
    ),
    "a plate with two holes across a countersunk one": (
        TWICE.translated(("25/4", -5, "-13/8")).moving(fc.Translation(("-105/8", "21/2", "5/2"))), SUNK,
        [(0.05, 14 / 15)],
    ),
    "an angle that turns into a plate": (
        ANGLE.translated((6, 0, 0)).moving(fc.Rotation(Z, degrees=120)), DRILLED.translated((0, 6, "1/2")), None,
    ),
    "a plate under a screw": (
        SMALL.translated((1, 0, 5)).moving(fc.Screw(Z, degrees=120, advance=-6)), DRILLED, [(3.5 / 6, 1)],
    ),
    "an ellipsoid with edges of degree 4, inside": (
        PIERCED.moving(fc.Rotation(Z, degrees=90)), PIERCED.translated(("1/8", "1/4", "1/2")), [(0, 1)],
    ),
}  # fmt: skip


@pytest.mark.share(8)
@pytest.mark.parametrize("scene", SCENES)
def test_all_times_of_contact_are_told(scene):
    a, b, expected = SCENES[scene]
    hit = fc.first_contact(a, b)
    told = fc.contact_intervals(a, b)
    if expected is not None:
        assert [x for y in told for x in (y.start, y.end)] == pytest.approx([x for y in expected for x in y], abs=1e-9)
    assert told[0].start == pytest.approx(hit.time, abs=1e-11)
    assert told.status is hit.status


def test_few_questions_are_asked_of_what_slides_in_one_another(monkeypatch):
    """Plates that slide along each other at 90 instants of interest overlap in between: no line is put to a line."""
    from firstcontact.contact.models.algorithm import CandidateSearch

    asked = []
    lasting = CandidateSearch.lasting
    seen = lambda self, u, known=(): asked.append(u) or lasting(self, u, known)  # noqa: E731
    monkeypatch.setattr(CandidateSearch, "lasting", seen)
    a, b, expected = SCENES["a plate with two holes across a countersunk one"]
    (told,) = fc.contact_intervals(a, b)
    assert (told.start, told.end) == pytest.approx(expected[0])
    assert len(asked) < 10  # 89 before


@pytest.mark.share(3)
@pytest.mark.parametrize("scene, way", [
    ("a drilled plate that turns up and comes back to stay", "soon exactly"),  # doubles cannot tell that it lands
    ("an ellipsoid with edges of degree 4, inside", "in doubles"),  # systems of equations take fifty times longer
])  # fmt: skip
def test_the_quicker_way_is_asked_first(scene, way):
    told = fc.contact_intervals(*SCENES[scene][:2])
    assert [x.way for x in told.stats.ways] == ["in doubles, if free", way]


def test_a_ball_on_forty_turns_of_a_screw_beside_a_box():
    """The truth: the distance of the ball's middle from the box, in closed form.  26 contacts, of 20 steps each."""
    ball, box = fc.sphere("1/2").translated((2, 0, 0)), fc.box((1, 1, 1)).translated((0, 2, 2))

    def gap(t):
        turn = 80 * np.pi * t
        away = np.array([2 * np.cos(turn), 2 * np.sin(turn) - 2, 3 * t - 2])
        return np.linalg.norm(np.maximum(np.abs(away) - 0.5, 0.0)) - 0.5

    times = np.linspace(0, 1, 40001)
    gaps = np.array([gap(t) for t in times])
    events = [brentq(gap, *times[k : k + 2], xtol=1e-15) for k in np.flatnonzero(gaps[1:] * gaps[:-1] < 0)]
    told = fc.contact_intervals(ball.moving(fc.Screw(Z, turns=40, advance=3)), box)
    assert [x for y in told for x in (y.start, y.end)] == pytest.approx(events, abs=1e-12)
    assert len(told) == 26
    assert told.stats.node_visits < 800  # 2,000 before


def test_what_lasts_from_step_to_step_is_proved_by_the_point_at_hand(monkeypatch):
    """Along many steps doubles are asked first: algebra looks at each anew, which took 27 s of 3,000 steps.  No deeper
    point is sought while the one at hand can be followed."""
    from firstcontact.timeline import lasting

    sought, descended = [], lasting.descended
    monkeypatch.setattr(lasting, "descended", lambda *given: sought.append(1) or descended(*given))
    poses = [np.array(fc.Rotation((1, 2, 2), degrees=3 * k)(1)) for k in range(31)]
    way = fc.Trajectory(range(31), poses, interpolation="linear-quaternion")
    told = fc.contact_intervals(BALL.moving(way), fc.cylinder("1/2", 3).translated((1, 0, 0)))
    assert [(x.start, x.end) for x in told] == [(0, 30)]
    assert [x.way for x in told.stats.ways][-1] == "in doubles"
    assert told.stats.node_visits < 200
    assert len(sought) < 10  # one of each step before


def test_solids_of_planes_are_asked_as_polyhedra():
    """Forty turns took 24 s.  The truth: how far apart two upright boxes are along the axes of their sides."""
    box = fc.box((1, 1, 1))
    moving = box.translated((2, 0, 0)).moving(fc.Screw(Z, turns=40, advance=3))
    told = fc.contact_intervals(moving, box.translated((0, 2, 2)))

    def gap(t):
        turn = 80 * np.pi * t
        away = np.array([2 * np.cos(turn), 2 * np.sin(turn) - 2])
        sides = np.array([[1, 0], [0, 1], [np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        reach = 0.5 * (1 + abs(np.cos(turn)) + abs(np.sin(turn)))
        return max(abs(3 * t - 2) - 1, float(np.abs(sides @ away).max()) - reach)

    times = np.linspace(1 / 3 + 1e-9, 1, 80001)  # heights meet from 1/3 on, when the boxes are within reach
    gaps = np.array([gap(t) for t in times])
    events = [brentq(gap, *times[k : k + 2], xtol=1e-15) for k in np.flatnonzero(gaps[1:] * gaps[:-1] < 0)]
    assert [x for y in told for x in (y.start, y.end)] == pytest.approx([1 / 3, *events], abs=1e-11)
    assert len(told) == 27
    assert "as polyhedra" in [x.way for x in told.stats.ways]


def test_what_slides_along_a_torus_from_the_start_ends_in_a_known_number_of_cells():
    """A box whose side is flush with the top circle: it took 26 to 58 s, in which nothing more is proved."""
    box = fc.box((2, 2, 2)).moving(fc.Translation((-8, 0, 0)))
    ring = fc.torus(4, 1).transformed([[0, -1, 0, -1], [0, 0, 1, -2], [-1, 0, 0, 3], [0, 0, 0, 1]])
    told = fc.contact_intervals(box, ring, budget=20_000)
    assert (told.status, told.reason) == (fc.Status.UNDECIDED, "budget")
    from firstcontact.contact.torus import first as torus

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(torus, "MOST", 20_000)
        own = fc.contact_intervals(box, ring)
    assert (own.status, own.reason, own.free_until) == (fc.Status.UNDECIDED, "precision", told.free_until)
