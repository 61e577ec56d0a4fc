"""A pin and a plunger above a counterbored hole, as a scene: names, and contacts by samples of the touching circle."""

from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.solid.carriers import doubles
from firstcontact.cli import run
from firstcontact.scene.load import load_scene

SCENE = Path(__file__).parent / "data" / "pin_in_plate.toml"


@pytest.fixture(scope="module")
def scene():
    return load_scene(SCENE)


def test_bodies_and_names(scene):
    assert [(check.a, check.b) for check in scene.checks] == [("pin", "plate"), ("plunger", "plate")]
    bodies = scene.bodies
    assert {face.name for face in bodies["pin"].body.faces} == {
        "pin.shaft.side", "pin.shaft.top", "pin.chamfer.side", "pin.chamfer.bottom",
    }  # fmt: skip
    assert {edge.name for edge in bodies["plate"].edges} > {"plate.counterbore.rim.top", "plate.bore.rim.top"}
    assert type(bodies["pin"].motion).__name__ == "Screw"
    assert type(bodies["plunger"].motion).__name__ == "RationalMotion"


def inside_at(scene, who, t, points):
    """Which of the points of the resting plate lie in the moving body at time t; and all in the body's frame."""
    m = scene.bodies[who].motion(t)
    local = (points - m[:3, 3]) @ np.linalg.inv(m[:3, :3]).T
    return scene.bodies[who].body.contains(local), local


@pytest.mark.parametrize(
    ("who", "circle", "time"),
    [("pin", (12, 5), 0.67871408997), ("plunger", (8, 2), 0.78761542757)],
)
def test_a_rim_of_the_plate_is_touched_first(scene, who, circle, time):
    radius, height = circle
    angles = np.linspace(0, 2 * np.pi, 20_001)
    rim = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), height)])
    before, _ = inside_at(scene, who, time - 1e-6, rim)
    after, local = inside_at(scene, who, time + 1e-6, rim)
    assert not before.any() and after.any()
    at = local[after].mean(axis=0)
    surface = next(f for f in scene.bodies[who].body.faces if f.name in ("pin.chamfer.side", "plunger.nose.surface"))
    x = np.array([*at, 1.0])
    form = np.array(doubles(surface.carrier.form))
    assert abs(x @ form @ x) < 1e-4 * np.abs(form).max() * (x @ x)


@pytest.mark.share(3)
@pytest.mark.parametrize(("who", "time"), [("pin", 0.67871408997), ("plunger", 0.78761542757)])
def test_nothing_else_is_met_before(scene, who, time):
    plate, body = scene.bodies["plate"], scene.bodies[who]
    points, others = body.body.to_mesh(0.05).vertices, plate.to_mesh(0.05).vertices
    for t in np.linspace(0, time - 1e-3, 40).tolist():
        m = body.motion(t)
        assert not plate.contains(points @ m[:3, :3].T + m[:3, 3]).any()
        assert not inside_at(scene, who, t, others)[0].any()


def test_the_plunger_touches_the_rim_of_the_bore(scene):
    hit = fc.first_contact(scene.bodies["plunger"], scene.bodies["plate"])
    assert hit.time == pytest.approx(0.78761542757, abs=1e-10)
    assert (hit.element_a.label, hit.element_b.label) == ("plunger.nose.surface", "plate.bore.rim.top")
    assert hit.contact_set == "point" and hit.time_interval[1] - hit.time_interval[0] <= 1e-12
    exact = fc.first_contact(scene.bodies["plunger"], scene.bodies["plate"], method="algebraic")
    assert hit.time == pytest.approx(exact.time, abs=1e-15) and exact.time_interval[0] >= hit.free_until


@pytest.mark.thorough
def test_the_command_line_answers_and_draws_the_page(tmp_path, capfd):
    page = tmp_path / "page.html"
    assert run(["check", str(SCENE), "--html", str(page)]) == 1
    lines = capfd.readouterr().out.splitlines()
    assert lines[0].startswith("pin and plate: CONTACT at time 0.67871408997")
    assert lines[1].startswith("  pin.chamfer.side face 2 meets plate.counterbore.rim.top edge 13")
    assert lines[2].startswith("  pin has turned 122.169 of 180 degrees, -20.3614 of -30 ahead")
    assert lines[3].startswith("plunger and plate: CONTACT at time 0.78761542757")
    assert page.stat().st_size > 100_000
