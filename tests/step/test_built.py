"""How curved parts of STEP files are built: by their own surfaces, or as triangles, and what tells why."""

import re

import numpy as np
import pytest

pytest.importorskip("OCP")

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402
from firstcontact.cli import run  # noqa: E402
from firstcontact.step import bodies, cells  # noqa: E402


@pytest.fixture(scope="module")
def bored(tmp_path_factory):
    """A block with a bore of radius 1 along z, about (3, 2)."""
    made = shapes.cut(shapes.box((6, 4, 2)), shapes.cylinder(1, 9, (3, 2, -1)))
    return shapes.write(tmp_path_factory.mktemp("step") / "bored.stp", made)


@pytest.fixture(scope="module")
def pin(tmp_path_factory):
    """Of radius 1/2, upright above (3, 2), its foot at z = 5."""
    return shapes.write(tmp_path_factory.mktemp("step") / "pin.stp", shapes.cylinder(0.5, 3, (3, 2, 5)))


def is_exact(body):
    return all(isinstance(piece.body, fc.CompositeQuadric) for piece in body.pieces)


def test_curved_parts_have_their_own_surfaces_unless_triangles_are_asked_for(bored):
    own, cut = fc.load_step(bored), fc.load_step(bored, surfaces=False)
    assert own.exact and is_exact(own.body) and own.deviation < 1e-12
    assert not cut.exact and not is_exact(cut.body) and 1e-6 < cut.deviation <= 6e-4
    assert [made.why for made in own.built() + cut.built()] == [None, "asked for"]
    # a ball comes to the bore's wall from within: sqrt(3)/4 before the wall, where triangles are up to the deviation in
    ball = fc.sphere("1/4").translated((3, 2, 1)).moving(fc.Translation((1, "1/2", 0)))
    hit, flat = fc.first_contact(ball, own), fc.first_contact(ball, cut)
    assert hit.time == pytest.approx(0.75 / np.sqrt(1.25), abs=1e-12)
    assert 0 <= hit.time - flat.time <= 1.01 * (cut.deviation + own.deviation) / np.sqrt(1.25)
    assert hit.model_deviation == own.deviation and flat.model_deviation == cut.deviation


def test_a_part_of_too_many_pieces_becomes_triangles_unless_its_surfaces_are_asked_for(bored, monkeypatch):
    monkeypatch.setattr(bodies, "MOST_PIECES", 0)
    shape = fc.load_step(bored).built()[0].solid.shape  # kept on the file; the same shape is asked for anew
    assert not is_exact(fc.from_shape(shape)) and is_exact(fc.from_shape(shape, surfaces=True))


def test_pieces_farther_from_the_file_than_is_asked_for_are_not_taken(bored, monkeypatch):
    shape = fc.load_step(bored).built()[0].solid.shape
    monkeypatch.setattr(cells, "_off_at_edges", lambda problem: 5e-5)
    assert is_exact(fc.from_shape(shape)) and fc.from_shape(shape).deviation == 5e-5
    cut = fc.from_shape(shape, deviation=4e-5)
    assert not is_exact(cut) and cut.deviation <= 4e-5


def test_scenes_say_which_and_write_it(bored, tmp_path):
    scene = tmp_path / "scene.toml"
    table = f'[body.x]\nshape = "step"\nfile = "{bored}"\n'
    for key, exact in (("", True), ("surfaces = false\n", False), ("surfaces = true\n", True)):
        scene.write_text(table + key)
        body = fc.Scene.load(scene).bodies["x"]
        assert is_exact(body) is exact and body.to_dict().get("surfaces") is (exact if key else None)
        assert fc.from_dict(body.to_dict()) == body


def test_info_tells_why_parts_are_triangles(bored, tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(bodies, "DEVIATION", 1e-2)
    assert run(["info", str(bored)]) == 0
    assert "7 faces (6 planes, 1 cylinder), size 6 x 4 x 2; exact surfaces, corners and" in capfd.readouterr().out
    assert run(["info", "--triangles", str(bored)]) == 0
    assert "of its faces: asked for" in capfd.readouterr().out
    wave = shapes.write(tmp_path / "wave.stp", shapes.wave())
    assert run(["info", str(wave)]) == 0
    assert re.search(r"of its faces: face #\d+ is on no plane, cylinder, sphere, torus or", capfd.readouterr().out)


def test_the_command_takes_step_files_without_a_scene(bored, pin, capfd):
    assert run(["check", str(pin), str(bored), "--move", "0.8 0 -5"]) == 1
    told = capfd.readouterr().out
    # the foot reaches z = 2 at 3/5 of the way, 0.48 off the bore's middle, and does not fit in as of 1/2
    assert "pin and bored: CONTACT at time 0.62" in told and "pin has moved 3.16" in told and "mm: time is" in told
    assert run(["check", str(pin), str(bored), "--move", "0.8 0 -5", "--triangles"]) == 1
    assert "CONTACT at time 0.62" in capfd.readouterr().out
    assert run(["check", str(pin), str(bored), "--move", "0 0 -5"]) == 0
    assert run(["check", str(pin)]) == 3 and "is one STEP file" in capfd.readouterr().err
    assert run(["info", str(pin.with_suffix(".stl")), "--triangles"]) == 3
    assert "--triangles is for STEP files" in capfd.readouterr().err
