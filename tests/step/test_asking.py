"""Lines through few faces tell what OpenCASCADE's classifier tells."""

import numpy as np
import pytest

pytest.importorskip("OCP")

from OCP.BRepClass3d import BRepClass3d_SolidClassifier  # noqa: E402
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt  # noqa: E402
from OCP.TopAbs import TopAbs_State  # noqa: E402

import step_shapes as shapes  # noqa: E402
from firstcontact.step.asking import LINES, Asking  # noqa: E402
from firstcontact.step.reader import Shape  # noqa: E402
from firstcontact.step.solids import StepSolid  # noqa: E402

SHAPES = {
    "sunk hole": lambda: shapes.cut(
        shapes.cut(shapes.box((10, 8, 5)), shapes.cylinder(1, 9, (5, 4, -2))), shapes.cone(0.5, 4.5, 4, (5, 4, 1.5))
    ),
    "pipes": lambda: shapes.moved(
        shapes.fuse(shapes.cylinder(1, 6, (0, 0, -3)), shapes.cylinder(0.8, 6, (-3, 0, 0.2), (1, 0, 0))),
        (5000, 300, -70), ((1, 2, 3), 0.7),
    ),
    "hollow": lambda: shapes.cut(shapes.box((3, 3, 3)), shapes.sphere(1, (1.4, 1.5, 1.6))),
    "thin wall": lambda: shapes.cut(shapes.box((4, 3, 2)), shapes.box((3, 1, 3), (0.5, 1.999, -0.5))),
}  # fmt: skip


@pytest.mark.share(2)
@pytest.mark.parametrize("name", SHAPES)
def test_lines_tell_what_the_classifier_tells(name, monkeypatch):
    shape = SHAPES[name]()
    solid, classified = StepSolid(shape, Shape(shape, name)), classifier(shape)
    lo, hi = solid.box
    rng = np.random.default_rng(3)
    near = solid.points[rng.integers(0, len(solid.points), 100)] + rng.normal(0, 0.01 * solid.size, (100, 3))
    points = np.concatenate([rng.uniform(lo - 0.1 * solid.size, hi + 0.1 * solid.size, (200, 3)), near])
    asked: list[list[float]] = []
    monkeypatch.setattr(Asking, "_is_inside", lambda self, p: asked.append(p) or classified(p))
    told = Asking(solid).inside(points)
    assert told.tolist() == [classified(p) for p in points.tolist()]
    assert len(asked) < 0.1 * len(points) and 0.05 < told.mean() < 0.95


@pytest.mark.parametrize("name", SHAPES)
def test_lines_through_vertices_and_edges_do_not_tell(name):
    """Or tell what is so, where OpenCASCADE passes them by."""
    shape = SHAPES[name]()
    solid, classified = StepSolid(shape, Shape(shape, name)), classifier(shape)
    asking, rng, told = Asking(solid), np.random.default_rng(4), []
    ends = solid.points[rng.integers(0, len(solid.points), 60)]
    for line, end in zip(np.repeat(LINES, 20, axis=0), ends, strict=True):
        start = (end - rng.uniform(0.05, 0.5) * solid.size * line).tolist()
        found = asking._crossed(gp_Lin(gp_Pnt(*start), gp_Dir(*line.tolist())), list(range(len(solid.faces))))
        assert found is None or found == classified(start)
        told.append(found)
    assert told.count(None) > 10


def classifier(shape):
    asked = BRepClass3d_SolidClassifier(shape)

    def inside(point):
        asked.Perform(gp_Pnt(*point), 1e-9)
        return asked.State() == TopAbs_State.TopAbs_IN

    return inside


def test_points_on_faces_are_told():
    shape = SHAPES["hollow"]()
    asking = Asking(StepSolid(shape, Shape(shape, "hollow")))
    for point, there in (((1.4, 1.5, 2.6), True), ((1.4, 1.5, 2.7), False), ((3.0, 1.0, 1.0), True), ((3, 3, 3), True)):
        assert (asking.off_faces(point, 1e-6) == 0.0) is there
