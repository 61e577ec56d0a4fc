"""A small picture of two bodies at the moment of their contact, drawn with NumPy alone: for notebooks."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.view.drawing import Drawing, drawings
from firstcontact.view.pair import PairView, pose

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

WIDTH, HEIGHT = 300, 210
# Pixels of the drawing across one of the picture, and its empty border.
FINE, MARGIN = 2, 12
# Right, up and towards the eye: rows, orthogonal up to rounding.
EYE = np.array([[0.788, 0.616, 0.0], [-0.284, 0.363, 0.888], [0.547, -0.700, 0.461]])
LIGHT = np.array([-0.3, 0.5, 0.81])
COLOURS = np.array([[70, 130, 200], [205, 165, 95]], float)
LINE, POINT = np.array([40, 45, 55], float), np.array([215, 35, 35], float)


class _Canvas:
    """A picture with depths: what is nearer the eye covers the rest."""

    def __init__(self, lo: np.ndarray, hi: np.ndarray) -> None:
        room = np.array([WIDTH, HEIGHT]) * FINE - 2 * MARGIN * FINE
        size = float(np.linalg.norm(hi - lo)) or 1.0
        self.scale = float(np.min(room / np.maximum((hi - lo)[:2], 1e-9 * size)))
        self.middle = (lo + hi) / 2
        self.depth = np.full((HEIGHT * FINE, WIDTH * FINE), -np.inf)
        self.colour = np.zeros((HEIGHT * FINE, WIDTH * FINE, 4))

    def places(self, seen: np.ndarray) -> np.ndarray:
        """(n, 3): column, row and depth in pixels of points (n, 3) as the eye sees them."""
        x = (seen - self.middle) * self.scale
        return np.column_stack([x[:, 0] + WIDTH * FINE / 2, HEIGHT * FINE / 2 - x[:, 1], x[:, 2]])

    def put(self, columns: np.ndarray, rows: np.ndarray, depths: np.ndarray, colour: np.ndarray) -> None:
        """Points, where they lie in the picture and nothing is nearer."""
        inside = (columns >= 0) & (columns < WIDTH * FINE) & (rows >= 0) & (rows < HEIGHT * FINE)
        columns, rows, depths = columns[inside], rows[inside], depths[inside]
        order = np.argsort(depths, kind="stable")  # of points in one pixel the nearest is written last
        columns, rows, depths = columns[order], rows[order], depths[order]
        near = depths >= self.depth[rows, columns]
        columns, rows = columns[near], rows[near]
        self.depth[rows, columns] = depths[near]
        self.colour[rows, columns] = [*colour, 255.0]

    def triangle(self, corners: np.ndarray, colour: np.ndarray) -> None:
        """Of places (3, 3): the pixels whose centres it holds; of one smaller than a pixel, its corners."""
        lo = np.maximum(np.floor(corners[:, :2].min(axis=0)), 0).astype(int)
        hi = np.minimum(np.ceil(corners[:, :2].max(axis=0)), [WIDTH * FINE, HEIGHT * FINE]).astype(int)
        (ax, ay, _), (bx, by, _), (cx, cy, _) = corners
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if abs(area) < 1.0:
            whole = np.floor(corners[:, :2]).astype(int)
            self.put(whole[:, 0], whole[:, 1], corners[:, 2], colour)
            return
        x, y = np.meshgrid(np.arange(lo[0], hi[0]) + 0.5, np.arange(lo[1], hi[1]) + 0.5)
        second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
        third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
        held = (second >= 0) & (third >= 0) & (second + third <= 1)
        depths = (1 - second - third) * corners[0, 2] + second * corners[1, 2] + third * corners[2, 2]
        self.put((x[held] - 0.5).astype(int), (y[held] - 0.5).astype(int), depths[held], colour)

    def lines(self, ends: np.ndarray) -> None:
        """Segments between places (k, 2, 3), a little in front of the triangles that they border."""
        for start, end in ends:
            count = int(min(np.abs(end - start)[:2].max() * 1.5, 4 * WIDTH * FINE)) + 2
            points = start + np.linspace(0, 1, count)[:, None] * (end - start)
            whole = np.floor(points[:, :2]).astype(int)
            self.put(whole[:, 0], whole[:, 1], points[:, 2] + 1.5, LINE)

    def dot(self, place: np.ndarray) -> None:
        """The place of contact, in front of everything."""
        r = 3 * FINE
        x, y = np.meshgrid(np.arange(-r, r + 1), np.arange(-r, r + 1))
        disc = x**2 + y**2 <= r**2
        column, row = np.floor(place[:2]).astype(int)
        self.put(column + x[disc], row + y[disc], np.full(int(disc.sum()), np.inf), POINT)

    def png(self) -> bytes:
        """The picture, fine pixels blended, with a background that lets the page shine through."""
        fine = self.colour.reshape(HEIGHT, FINE, WIDTH, FINE, 4)
        cover = fine[..., 3].sum(axis=(1, 3))
        blended = (fine[..., :3] * fine[..., 3:]).sum(axis=(1, 3)) / np.maximum(cover, 1)[..., None]
        pixels = np.concatenate([blended, cover[..., None] / FINE**2], axis=2).round().astype(np.uint8)
        rows = np.concatenate([np.zeros((HEIGHT, 1), np.uint8), pixels.reshape(HEIGHT, -1)], axis=1)
        head = struct.pack(">2I5B", WIDTH, HEIGHT, 8, 6, 0, 0, 0)
        chunks = (b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in chunks
        )


def picture(pair: PairView) -> bytes:
    """The two bodies as a PNG: when they first touch, or at the start of what is shown."""
    time = pair.window[0] if pair.contact_time is None else pair.contact_time
    drawn = drawings(pair)
    seen = [_seen(body, drawing, time) for body, drawing in zip((pair.a, pair.b), drawn, strict=True)]
    points = np.concatenate(seen)
    canvas = _Canvas(points.min(axis=0), points.max(axis=0))
    for drawing, own, colour in zip(drawn, seen, COLOURS, strict=True):
        _draw(canvas, drawing, own, colour)
    if pair.first is not None and pair.first.point is not None:
        canvas.dot(canvas.places((EYE @ pair.first.point)[None])[0])
    return canvas.png()


def _seen(body: Body, drawing: Drawing, time: float) -> np.ndarray:
    """(n, 3) vertices as the eye sees them at that time."""
    m = pose(body, time)
    seen: np.ndarray = (drawing.vertices @ m[:3, :3].T + m[:3, 3]) @ EYE.T
    return seen


def _draw(canvas: _Canvas, drawing: Drawing, seen: np.ndarray, colour: np.ndarray) -> None:
    places = canvas.places(seen)
    corners = seen[drawing.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    bright = 0.45 + 0.55 * np.abs(normals @ LIGHT) / np.where(length > 0, length, 1.0)
    for triangle, light in zip(places[drawing.triangles], bright, strict=True):
        canvas.triangle(triangle, light * colour)
    canvas.lines(places[drawing.lines])
