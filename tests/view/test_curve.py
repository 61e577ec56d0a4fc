"""What pages show of intersection curves: components, layers, the part in sight, and overlaps with an area."""

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.view.curve import clipped, components, layers, sight
from firstcontact.view.drawing import drawings
from firstcontact.view.overlap import distances
from firstcontact.view.pair import pairs_of
from firstcontact.view.png import write_png
from view import scenes


def layers_of(curve):
    (pair,) = pairs_of([curve])
    return {layer["name"]: layer for layer in layers(curve, drawings(pair))}


def test_branches_that_meet_are_one_component():
    crossing = scenes.crossing_pipes()
    assert components(crossing) == [0, 0, 0, 0]
    found = layers_of(crossing)
    assert list(found) == ["component 1, 4 branches", "nodes"]
    p = found["component 1, 4 branches"]["points"]
    assert len(p) % 2 == 0 and np.abs(np.hypot(p[:, 0], p[:, 1]) - 1).max() < 1e-9
    assert sorted(found["nodes"]["points"].round(12).tolist()) == [[0, -1, 0], [0, 1, 0]]


def test_kinds_of_layers():
    found = layers_of(scenes.cone_and_pipe())
    kinds = {name: layer["kind"] for name, layer in found.items()}
    assert kinds == {"common rulings": "thick line", "component 1, closed": "line", "isolated points": "isolated"}
    ruling = found["common rulings"]["points"]
    assert np.allclose(ruling[:, 1], ruling[:, 2]) and np.linalg.norm(ruling[1] - ruling[0]) > 10
    assert found["isolated points"]["points"].tolist() == [[0, 0, 0]]


def test_sight_leaves_out_what_runs_to_infinity():
    plane = RuledSurface("(u, 0, 1)", "(u, 1, 1)", u=None, s=None)
    hyperbola = fc.intersection_curve(RuledSurface("(u, 0, 0)", "(u, 1, u)", u=None, s=None), plane)
    assert max(np.abs(branch.points).max() for branch in hyperbola.branches) > 50
    lo, hi = sight(hyperbola)
    assert np.all(lo < [-0.9, -0.9, 0.9]) and np.all(hi > [0.9, 0.9, 1]) and np.linalg.norm(hi - lo) < 10
    apart = fc.intersection_curve(plane, RuledSurface("(u, 0, 2)", "(u, 1, 2)", u=None, s=None))
    assert apart.empty and layers_of(apart) == {}
    assert np.all(sight(apart)[0][2] < 1) and np.all(sight(apart)[1][2] > 2)


def test_segments_are_cut_at_a_cube():
    through, beside = [[-5, 0, 0], [5, 0, 0]], [[0, 3, 0], [1, 3, 0]]
    far, across = [[0.5, 0, 0], [0.5, 0, 9e30]], [[3, 0, 0], [0, 3, 0]]
    assert clipped(np.array([through, beside, far, across]), np.zeros(3), 2.0).tolist() == [
        [[-2, 0, 0], [2, 0, 0]], [[0.5, 0, 0], [0.5, 0, 2]], [[2, 1, 0], [1, 2, 0]]
    ]  # fmt: skip


def area(corners):
    p = corners.reshape(-1, 3, 3)
    return np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2


def test_the_common_part_of_two_pieces_of_a_plane():
    found = layers_of(scenes.flat_pieces())
    assert list(found) == ["overlap"] and found["overlap"]["kind"] == "fill"
    p = found["overlap"]["points"]
    assert area(p) == pytest.approx(0.25, rel=1e-3)
    assert p[:, :2].min() > 0.5 - 1e-5 and p[:, :2].max() < 1 + 1e-9


def test_two_families_of_rulings_of_one_hyperboloid():
    circle, turned = "((1-u**2)/(1+u**2), 2*u/(1+u**2), -1)", "({}2*u/(1+u**2), {}(1-u**2)/(1+u**2), 1)"
    left, right = (RuledSurface(circle, turned.format(*signs), u=None, s=None) for signs in (("-", ""), ("", "-")))
    curve = fc.intersection_curve(left, right)
    found = layers_of(curve)
    assert list(found) == ["overlap"]
    x, y, z = found["overlap"]["points"].T
    assert np.allclose(x * x + y * y, (1 + z * z) / 2, rtol=1e-9)
    drawing, _ = drawings(pairs_of([curve])[0])
    assert area(found["overlap"]["points"]) == pytest.approx(area(drawing.vertices[drawing.triangles]))  # all of it


def test_a_curve_has_a_page_and_no_png(tmp_path):
    assert scenes.flat_pieces().show(tmp_path / "page.html").read_text(encoding="utf-8").count('"status": "CURVE"') == 1
    with pytest.raises(fc.InputError, match="goes on a page"):
        write_png(tmp_path / "x.png", scenes.flat_pieces())


def test_distances_to_a_piece():
    quarter = RuledSurface(scenes.CIRCLE.format(0), scenes.CIRCLE.format(1), trim="s <= 1/2")
    points = np.array([[0.6, 0.8, 0.25], [1.2, 1.6, 0.25], [0.6, 0.8, 2.0], [1, -3, 0.25]])
    assert distances(quarter, points) == pytest.approx([0, 1, np.inf, 3], abs=1e-7)
