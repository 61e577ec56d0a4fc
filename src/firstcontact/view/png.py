"""A still picture of one result as PNG, through pyvista (extra `view`), without a window."""

from __future__ import annotations

import ctypes.util
import os
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.errors import InputError
from firstcontact.result import ContactIntervals, Element, FirstContact
from firstcontact.view.drawing import Drawing, contact_curve, drawings
from firstcontact.view.pair import PairView, is_moving, pairs_of, pose

if TYPE_CHECKING:
    from types import ModuleType

    from pyvista import Actor, Plotter, PolyData

    from firstcontact.body.kinds import Body

BODY_COLOURS = "#6f9cc2", "#e3b87c"
LINE_COLOURS = "#1f3e5a", "#7c5217"
ACCENT = "#d02f42"
PAPER = "#fbfaf7"
PATH_POINTS = 240
SAMPLES = 2
"""Samples across a pixel, each way: drawn large and averaged, as off-screen drivers differ in smoothing."""
VIEW_ANGLE = 24.0
"""Degrees from the bottom to the top of the picture."""


def write_png(
    path: str | Path, result: FirstContact | ContactIntervals, size: tuple[int, int] = (1200, 900)
) -> Path:
    """Draw the bodies at the contact time (at the start when there is none) and return the file's path.

    size: width and height in pixels.  Raises InputError saying what to install when drawing is impossible.
    """
    (pair,) = pairs_of([result])
    if pair.curve is not None:
        raise InputError("a PNG shows a contact; an intersection curve goes on a page: curve.show(path)")
    _require_drawing()
    if sys.platform.startswith("linux") and "DISPLAY" not in os.environ:
        # without this VTK looks for an X server first, and warns on stderr
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    from PIL import Image

    width, height = size
    plotter = _pyvista().Plotter(off_screen=True, window_size=[SAMPLES * width, SAMPLES * height])
    try:
        plotter.set_background(PAPER)
        _draw(plotter, pair)
        pixels = plotter.screenshot(return_img=True)
    finally:
        plotter.close()
    fine = np.asarray(pixels, float).reshape(height, SAMPLES, width, SAMPLES, 3)
    Image.fromarray(fine.mean(axis=(1, 3)).round().astype(np.uint8)).save(path, format="PNG")
    return Path(path)


def _require_drawing() -> None:
    """Fail with one line instead of a missing module, or of VTK ending the process without a libGL."""
    if find_spec("pyvista") is None:
        raise InputError("drawing a PNG needs pyvista: pip install 'firstcontact[view]', or '.[view]' in a checkout")
    if sys.platform.startswith("linux"):
        missing = [name for name in ("EGL", "GL") if ctypes.util.find_library(name) is None]
        if missing:
            names = " and ".join(f"lib{name}" for name in missing)
            raise InputError(f"drawing a PNG needs {names}: apt-get install libegl1 libgl1")


def _pyvista() -> ModuleType:
    """The module, imported when a picture is drawn: it takes a second."""
    return import_module("pyvista")


def _draw(plotter: Plotter, pair: PairView) -> None:
    t = pair.window[0] if pair.contact_time is None else pair.contact_time
    drawn = drawings(pair)
    posed = []
    for which, (body, drawing) in enumerate(zip((pair.a, pair.b), drawn, strict=True)):
        posed.append(_surface(drawing, pose(body, t)))
        _draw_body(plotter, drawing, posed[-1], which)
        if is_moving(body):
            _draw_motion(plotter, pair, body, drawing, which, t)
        for k, element in enumerate(pair.elements[which]):
            _draw_element(plotter, drawing, element, pose(body, t), strong=k == 0)
    point, normal = (None, None) if pair.first is None else (pair.first.point, pair.first.normal)
    radius = _aim(plotter, pair, drawn, posed, point, normal)
    if point is not None:
        _draw_contact(plotter, np.asarray(point, float), normal, contact_curve(pair), 0.17 * radius)


def _posed(points: np.ndarray, m: np.ndarray) -> np.ndarray:
    return points @ m[:3, :3].T + m[:3, 3]


def _surface(drawing: Drawing, m: np.ndarray) -> PolyData:
    """The body in pose m (4, 4); smooth where the drawing has normals."""
    vertices = _posed(drawing.vertices, m)
    if not len(drawing.triangles):
        return _pyvista().PolyData(vertices)
    surface = _pyvista().PolyData.from_regular_faces(vertices, drawing.triangles)
    if drawing.normals is not None:
        normals = drawing.normals @ np.linalg.inv(m[:3, :3])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        surface.point_data.active_normals = normals / np.where(length > 0, length, 1.0)
    return surface


def _segments(points: np.ndarray, ends: np.ndarray) -> PolyData:
    """Lines between points (n, 3); ends: (k, 2) indices."""
    lines = np.column_stack([np.full(len(ends), 2), ends]).ravel()
    return _pyvista().PolyData(points, lines=lines)


def _draw_body(plotter: Plotter, drawing: Drawing, surface: PolyData, which: int) -> None:
    actor = plotter.add_mesh(
        surface,
        color=BODY_COLOURS[which],
        ambient=0.3,
        diffuse=0.75,
        point_size=8 * SAMPLES,
        render_points_as_spheres=not len(drawing.triangles),
    )
    if drawing.normals is not None:
        actor.prop.interpolation = "Phong"
    if len(drawing.lines):
        lines = _segments(surface.points, drawing.lines)
        plotter.add_mesh(lines, color=LINE_COLOURS[which], opacity=0.6, line_width=1.5 * SAMPLES)


def _draw_motion(plotter: Plotter, pair: PairView, body: Body, drawing: Drawing, which: int, t: float) -> None:
    """The start pose, faint, and the path of the touching point (of the centre when there is none)."""
    lo, hi = pair.window
    if t > lo:
        ghost = _surface(drawing, pose(body, lo))
        plotter.add_mesh(ghost, color=BODY_COLOURS[which], opacity=0.15, lighting=False)
    if pair.first is not None and pair.first.point is not None:
        m = pose(body, t)
        carried = m[:3, :3].T @ (np.asarray(pair.first.point, float) - m[:3, 3])
    else:
        carried, _ = drawing.frame
    times = np.linspace(lo, hi, PATH_POINTS + 1)
    path = np.array([_posed(carried, pose(body, float(s))) for s in times])
    ends = np.column_stack([np.arange(PATH_POINTS), np.arange(1, PATH_POINTS + 1)])
    plotter.add_mesh(_segments(path, ends), color=LINE_COLOURS[which], line_width=2.5 * SAMPLES, opacity=0.7)


def _draw_element(plotter: Plotter, drawing: Drawing, element: Element, m: np.ndarray, strong: bool) -> None:
    """A touched element; of faces beside the reported one only the outline."""
    corners = _posed(drawing.corners(element), m)
    if element.kind == "face":
        if strong and len(corners):
            triangles = np.arange(len(corners)).reshape(-1, 3)
            fill = _pyvista().PolyData.from_regular_faces(corners, triangles)
            _in_front(plotter.add_mesh(fill, color=ACCENT, opacity=0.6, lighting=False), -2)
        corners = _posed(drawing.outline(element.index), m)
    if len(corners) > 1:
        ends = np.arange(len(corners)).reshape(-1, 2)
        lines = _segments(corners, ends)
        _in_front(plotter.add_mesh(lines, color=ACCENT, line_width=(4 if strong else 2) * SAMPLES), -4)


def _in_front(actor: Actor, units: float) -> None:
    """Draw an actor as if it were a little nearer, so that it wins over the surface it lies in."""
    mapper = actor.mapper
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-1, units)
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, units)
    mapper.SetRelativeCoincidentTopologyPointOffsetParameter(units)


def _draw_contact(
    plotter: Plotter, point: np.ndarray, normal: np.ndarray | None, curve: np.ndarray, length: float
) -> None:
    """The contact point, its normal and the shared curve (n, 3) on layers of their own, which nothing hides."""
    from vtkmodules.vtkRenderingCore import vtkRenderer

    top, halo = [(_pyvista().Sphere(radius=0.06 * length, center=point), ACCENT)], []
    halo.append((_pyvista().Sphere(radius=0.085 * length, center=point), "white"))
    if normal is not None:
        shape = {"tip_length": 0.24, "tip_radius": 0.075, "shaft_radius": 0.02}
        top.append((_pyvista().Arrow(start=point, direction=normal, scale=length, **shape), ACCENT))
    if len(curve):
        line = _pyvista().MultipleLines(curve)
        top.append((line.tube(radius=0.03 * length), ACCENT))
        halo.append((line.tube(radius=0.045 * length), "white"))
    plotter.render_window.SetNumberOfLayers(3)
    for layer, meshes in ((1, halo), (2, top)):
        overlay = vtkRenderer()
        overlay.SetLayer(layer)
        overlay.SetActiveCamera(plotter.camera)
        for mesh, colour in meshes:
            actor = _pyvista().Actor(mapper=_pyvista().DataSetMapper(mesh))
            actor.prop.color, actor.prop.lighting = colour, False
            overlay.AddActor(actor)
        plotter.render_window.AddRenderer(overlay)


def _aim(
    plotter: Plotter, pair: PairView, drawn: tuple[Drawing, Drawing], posed: list[PolyData],
    point: np.ndarray | None, normal: np.ndarray | None,
) -> float:  # fmt: skip
    """Look at both bodies, from where the contact point is in sight; the radius of what is looked at."""
    corners = [mesh.bounds for mesh in posed]
    for body, drawing in zip((pair.a, pair.b), drawn, strict=True):
        corners.append(_surface(drawing, pose(body, pair.window[0])).bounds)
    boxes = np.array([[[b[0], b[2], b[4]], [b[1], b[3], b[5]]] for b in corners])
    everything, touching = (
        (part[:, 0].min(axis=0), part[:, 1].max(axis=0)) for part in (boxes, boxes[:2])
    )
    if pair.contact_time is not None and _diagonal(*everything) > 3 * _diagonal(*touching):
        everything = touching
    centre, radius = sum(everything) / 2, _diagonal(*everything) / 2 or 1.0
    surfaces = [mesh for mesh, drawing in zip(posed, drawn, strict=True) if len(drawing.triangles)]
    direction = _view_direction(surfaces, point, normal, radius)
    distance = radius / np.sin(np.radians(VIEW_ANGLE / 2)) * 0.92
    plotter.camera.focal_point = centre
    plotter.camera.position = centre + distance * direction
    plotter.camera.up = (0, 0, 1)
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.reset_camera_clipping_range()
    return radius


def _diagonal(lower: np.ndarray, upper: np.ndarray) -> float:
    return float(np.linalg.norm(upper - lower))


def _view_direction(
    solid: list[PolyData], point: np.ndarray | None, normal: np.ndarray | None, radius: float
) -> np.ndarray:
    """Unit vector to the eye: near the usual one, across the normal, the contact in sight if possible."""
    usual = np.array([0.5, -0.75, 0.45]) / np.linalg.norm([0.5, -0.75, 0.45])
    if point is None:
        return usual
    grid = np.meshgrid((np.arange(16) + 0.5) * np.pi / 8, [0.04, 0.15, 0.32, 0.55, -0.15])
    azimuth, elevation = (g.ravel() for g in grid)
    flat = np.cos(elevation)
    choices = np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
    along = np.zeros(len(choices)) if normal is None else np.abs(choices @ np.asarray(normal))
    score = 1.5 * choices @ usual - np.maximum(along - 0.4, 0)
    ranked = choices[np.argsort(-score)]
    for direction in ranked:
        start, end = point + 0.004 * radius * direction, point + 10 * radius * direction
        if all(not len(mesh.ray_trace(start, end, first_point=True)[0]) for mesh in solid):
            return direction
    return ranked[0]
