"""Ruled surfaces in scene files, in `firstcontact info`, and as they are drawn."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import firstcontact as fc
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.cli.info import info
from firstcontact.result import Element, FirstContact, Status
from firstcontact.scene.load import load_scene
from firstcontact.view.drawing import drawings
from firstcontact.view.html import page_text
from firstcontact.view.pair import PairView

PIPE = '''
[body.pipe]
shape = "ruled"
first = "((1-u**2)/(1+u**2), 2*u/(1+u**2), 0)"
second = { numerators = [[1, 0, -1], [0, 2], ["1/3", 0, "1/3"]], denominator = [1, 0, 1] }
u = "all"
'''
ROOF = '''
[body.roof]
shape = "ruled"
first = "(u, 0, T)"
second = "(u, 1, u*T)"
u = [-1, "1/2"]
s = [0, 2]
trim = ["u*s <= 1/2"]
at = [0, 0, 5]
'''


def test_a_scene_of_ruled_surfaces(scene):
    motion = '[body.pipe.motion]\ntype = "translation"\nvector = [0, 0, 1]\n'
    loaded = load_scene(scene(PIPE + motion + ROOF + '[body.flat]\nshape = "ruled"\nfirst = "(u, 0, 0)"\n'
                                  'second = "(u, 1, 0)"\ns = "all"\n'))  # fmt: skip
    pipe, roof, flat = (loaded.bodies[name] for name in ("pipe", "roof", "flat"))
    circle = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"
    assert pipe.body.second == fc.RationalCurve.parse(circle.format("1/3")) and pipe.body.u is None
    assert roof.first == fc.RationalCurve.parse("(u, 0, 5 + T)") and roof.s == (0, 2) and len(roof.trim) == 1
    assert flat.s is None and flat.u == (0, 1) and flat.name == "flat"


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('u = "all"', 'u = "some"', "body.pipe.u: 'some' is no range; write [lo, hi], or \"all\""),
        ('u = "all"', "u = [1, 0]", "pipe: u is the empty range (1, 0)"),
        ('u = "all"', "u = [0]", "body.pipe.u: [0] is no range"),
        ("2*u/(1+u**2), 0)", "2*v/(1+u**2), 0)", "unknown name 'v'"),
        ('"((1-u**2)/(1+u**2), 2*u/(1+u**2), 0)"', "3", "body.pipe.first: 3 is no curve"),
        ("denominator = [1, 0, 1]", "denominators = [1, 0, 1]", "is no curve"),
        ("denominator = [1, 0, 1]", "denominator = [0]", "body.pipe.second: RationalCurve denominator is 0"),
        ("denominator = [1, 0, 1]", 'denominator = ["x"]', "body.pipe.second: 'x' is not a number"),
        ("[0, 2], ", "", "body.pipe.second: RationalCurve numerators are"),
        ('shape = "ruled"', 'shape = "ruled"\ntrims = []', "unknown key 'trims', perhaps 'trim'; keys"),
    ],
)
def test_faults_of_a_scene_name_the_key(scene, old, new, text):
    assert old in PIPE
    with pytest.raises(fc.InputError) as error:
        load_scene(scene(PIPE.replace(old, new)))
    assert text in str(error.value) and "\n" not in str(error.value)


SHEET = '''
[body.sheet]
shape = "ruled"
points = [[[0, 0, 0], [0, 4, 0]], [[1, 0, 1], [1, 4, 2]], [[2, 0, 1], [2, 4, 2]], [[3, 0, 0], [3, 4, 0]]]
knots = [0, 0, 0, "1/2", 2, 2, 2]
weights = [[1, 1], [1, "2/3"], [1, 1], [1, 1]]
degree = 2
'''


def test_a_nurbs_surface_in_a_scene(scene):
    motion = '[body.sheet.motion]\ntype = "translation"\nvector = [0, 0, 1]\n'
    sheet = load_scene(scene(SHEET + motion)).bodies["sheet"]
    grid = [[(0, 0, 0), (0, 4, 0)], [(1, 0, 1), (1, 4, 2)], [(2, 0, 1), (2, 4, 2)], [(3, 0, 0), (3, 4, 0)]]
    same = RuledSurface.from_nurbs(grid, [0, 0, 0, "1/2", 2, 2, 2], [[1, 1], [1, "2/3"], [1, 1], [1, 1]])
    assert [piece.u for piece in sheet.body.pieces] == [piece.u for piece in same.pieces]
    assert [piece.second for piece in sheet.body.pieces] == [piece.second for piece in same.pieces]
    assert sheet.name == "sheet" and sheet.motion.vector[2] == 1


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("degree = 2", "u = [0, 1]", "body.sheet: u does not go with points; leave it out"),
        ("points = [[[0", 'first = "(u, 0, 0)"\npoints = [[[0', "body.sheet: first does not go with points"),
        ("points =", "second =", "body.sheet.second: "),
        ('"1/2"', '"half"', "body.sheet.knots: 'half' is not a number"),
        ("[0, 4, 0]", "[0, 4]", "body.sheet.points[0][1]: "),
        ("degree = 2", "degree = 3", "body.sheet: sheet: degree is 3"),
    ],
)
def test_faults_of_a_nurbs_surface_name_the_key(scene, old, new, text):
    assert old in SHEET
    with pytest.raises(fc.InputError) as error:
        load_scene(scene(SHEET.replace(old, new)))
    assert text in str(error.value) and "\n" not in str(error.value)


def test_a_ruled_surface_needs_its_curves_or_points(scene):
    with pytest.raises(fc.InputError, match="body.a: give first and second, or points"):
        load_scene(scene('[body.a]\nshape = "ruled"\nfirst = "(u, 0, 0)"\n'))


def test_info_tells_directrices_and_ranges(scene):
    twice = '[body.twice]\nshape = "ruled"\nfirst = "(u**2, 0, 0)"\nsecond = "(u**2, 1, 0)"\ns = "all"\n'
    result = CliRunner().invoke(info, [str(scene(PIPE + ROOF + twice))], standalone_mode=False)
    assert result.exception is None
    lines = result.output.splitlines()
    assert lines[1:6] == [
        "body pipe: at rest",
        "  a ruled surface, all u, s from 0 to 1",
        "  first: ((-u**2 + 1)/(u**2 + 1), 2*u/(u**2 + 1), 0)",
        "  second: ((-u**2 + 1)/(u**2 + 1), 2*u/(u**2 + 1), 1/3)",
        lines[5],
    ]
    assert lines[5].startswith("  from (-1") and "  trimmed by -2*u*s + 1 >= 0" in lines
    assert "  deforms with the time T" in lines and any(x.endswith("in the time from 0 to 1") for x in lines)
    assert lines[-4:-2] == ["  every ruling belongs to 2 values of u", "  unbounded"]


# -- drawing ------------------------------------------------------------------------------------------------

CIRCLE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"


def drawn(a, b):
    return drawings(PairView(a, b, (0.0, 1.0), FirstContact(Status.FREE, a=a, b=b, span=(0.0, 1.0))))


def test_a_piece_is_drawn_with_its_borders_and_rulings():
    pipe = RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, name="pipe")
    strip = RuledSurface.from_nurbs([[(k, 0, k * k), (k, 2, 0)] for k in range(5)], [0, 0, 0, 1, 2, 3, 3, 3])
    first, second = drawn(pipe, strip)
    corners = first.vertices[first.triangles]
    assert np.abs(np.hypot(corners[..., 0], corners[..., 1]) - 1).max() < 1e-15
    ends = first.vertices[first.lines]
    upright = np.abs(ends[:, 0, 2] - ends[:, 1, 2]) == 1
    assert 16 <= upright.sum() <= 17 and (~upright).sum() > 60  # rulings, and the two circles
    assert set(second.triangle_face.tolist()) == {0, 1, 2}
    face = second.corners(Element("face", "b", 2, "b"))
    assert len(face) % 3 == 0 and face[:, 0].min() > 2
    edge = second.corners(Element("directrix", "b", 3, "b"))
    assert np.all(edge[:, 1] == 2) and len(edge) % 2 == 0
    assert np.allclose(second.corners(Element("end_ruling", "b", 5, "b")), [[4, 0, 16], [4, 2, 0]], rtol=1e-14)
    assert second.corners(Element("vertex", "b", 1, "b")).tolist() == [[0, 2, 0]]
    with pytest.raises(ValueError, match="no picture"):
        second.corners(Element("edge", "b", 1, "b"))


def test_whole_rulings_are_drawn_where_the_other_body_is():
    saddle = RuledSurface("(u, 0, 0)", "(u, 1, u)", u=None, s=None, name="saddle")
    pipe = RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, name="pipe").translated((10, 0, 0))
    drawing, _ = drawn(saddle, pipe)
    p = drawing.vertices
    assert np.abs(p[:, 2] - p[:, 0] * p[:, 1]).max() < 1e-9 * np.abs(p).max() ** 2
    assert len(drawing.triangles) and np.linalg.norm(p - (10, 0, 0), axis=1).max() < 40


def test_trimmed_rulings_stop_at_the_border():
    body = RuledSurface("(u, 0, 0)", "(u, 1, 0)", trim="u**2 + s**2 <= 1", name="quarter")
    drawing, _ = drawn(body, RuledSurface("(u, 0, 1)", "(u, 1, 1)"))
    ends = drawing.vertices[drawing.lines]
    assert np.all(np.hypot(ends[..., 0], ends[..., 1]) <= 1 + 1e-12)
    assert len(ends) > 200


def test_a_page_holds_the_surfaces():
    pipe = RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, name="pipe")
    other = RuledSurface("(u, 0, 0)", "(u, 1, u)", name="saddle").moving(fc.Translation((0, 0, 1)))
    text = page_text([FirstContact(Status.FREE, a=pipe, b=other, span=(0.0, 1.0), free_until=1.0)])
    assert "pipe" in text and "saddle" in text
    assert json.dumps(text)


def test_a_surface_that_deforms_is_drawn_at_many_times():
    pipe = RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, name="pipe")
    wave = RuledSurface("(u, T, u**2)", "(u, T + 1, 1/T)", u=(-1, 1), trim="u + s <= 1", name="wave")
    drawing, _ = drawn(wave, pipe)
    times, frames = drawing.frames
    assert len(times) == 64 and times[0] > 0 and times[-1] == 1  # not at 0, where it has a pole
    x, y, z = np.moveaxis(frames, 2, 0)
    s = y - times[:, None]
    assert np.allclose(z, (1 - s) * x**2 + s / times[:, None], rtol=1e-12)
    assert (x + s).max() == pytest.approx(1, abs=1e-12) and np.array_equal(drawing.vertices, frames[0])
    with pytest.raises(fc.InputError, match="cannot draw wave while its whole rulings deform"):
        drawn(RuledSurface("(u, T, 0)", "(u, 1, 0)", s=None, name="wave"), pipe)
    with pytest.raises(fc.InputError, match="pole at every time"):
        drawn(RuledSurface("(1/(u*(1+T)), T, 0)", "(u, 1, 0)", name="wave"), pipe)


def test_a_deforming_surface_shows_what_touches_when_it_touches():
    door = RuledSurface("(0, 0, 0)", "((1-T**2)/(1+T**2), 2*T/(1+T**2), u)", name="door")
    hit = fc.first_contact(door, RuledSurface("(3/5, 4/5, u)", "(2, 2, u)", name="post"))
    drawing, _ = drawings(PairView(door, hit.b, hit.span, hit))
    assert hit.time == 0.5 and hit.element_a.kind in ("directrix", "end_ruling", "vertex", "face")
    assert drawing.frames[0][np.abs(drawing.frames[0] - 0.5).argmin()] == 0.5
    assert np.allclose(drawing.vertices[:, 1] * 3, drawing.vertices[:, 0] * 4)
    assert np.isfinite(drawing.corners(hit.element_a)).all()
