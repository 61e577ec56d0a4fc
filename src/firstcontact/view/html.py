"""One self-contained offline HTML page that shows results: both bodies, their motion, and the contact."""

from __future__ import annotations

import base64
import html
import json
import sys
import tempfile
import webbrowser
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.errors import InputError
from firstcontact.result import Absent, Element, FirstContact, Status
from firstcontact.result_curve import IntersectionCurve
from firstcontact.view.assembly import SceneView, drawn, shown
from firstcontact.view.curve import layers
from firstcontact.view.drawing import Drawing, contact_curve, drawings
from firstcontact.view.joints import PageJoints, linkage_of
from firstcontact.view.pair import PairView, Result, at_rest, is_moving, pairs_of, pose
from firstcontact.view.picture import HEIGHT, WIDTH, picture
from firstcontact.view.poses import sample_poses

if TYPE_CHECKING:
    from numpy.typing import DTypeLike

    from firstcontact.body.kinds import Body
    from firstcontact.result import Json

# Most contact intervals written out as text; the timeline shows them all.
MOST_LISTED = 6


def write_page(path: str | Path | None, results: Iterable[Result], assembly: SceneView | None = None) -> Path:
    """Write the page and return its path; without a path: a temporary file, opened in the browser.

    Several results about the same two bodies share one view; the page lets the reader choose among pairs.
    assembly: all of whose bodies are shown with each pair.
    """
    text = page_text(results, assembly)
    if path is not None:
        try:
            target = Path(path)
            target.write_text(text, encoding="utf-8")
        except (OSError, TypeError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(f"{path}: {reason.lower()}; give a file in a folder that exists") from error
        return target
    with tempfile.NamedTemporaryFile(
        "w", prefix="firstcontact-", suffix=".html", delete=False, encoding="utf-8"
    ) as file:
        file.write(text)
    target = Path(file.name)
    webbrowser.open(target.as_uri())
    return target


@dataclass(frozen=True)
class NotebookFrame:
    """A page within a notebook's cell; it refers to nothing outside itself."""

    page: str

    def _repr_html_(self) -> str:
        style = "width: 100%; height: 600px; border: 0"
        return f'<iframe srcdoc="{html.escape(self.page)}" style="{style}"></iframe>'


def show_page(
    path: str | Path | None, results: Iterable[Result], assembly: SceneView | None = None
) -> Path | NotebookFrame:
    """As `write_page`; in a notebook, without a path, the page as its cell shows it."""
    if path is None and _in_notebook():
        return NotebookFrame(page_text(results, assembly))
    return write_page(path, results, assembly)


def _in_notebook() -> bool:
    """Whether IPython runs, and runs for a notebook: its shell then has a kernel."""
    interactive = sys.modules.get("IPython")
    shell = None if interactive is None else interactive.get_ipython()
    return getattr(shell, "kernel", None) is not None


def cell(result: Any) -> str:
    """A result in a notebook: a small picture of it, where its bodies can be drawn, and its text."""
    text = f"<pre>{html.escape(str(result))}</pre>"
    if any(getattr(result, side, None) is None or isinstance(getattr(result, side), Absent) for side in "ab"):
        return text
    try:
        drawn = base64.b64encode(picture(pairs_of([result])[0])).decode("ascii")
    except InputError as error:  # bodies without end
        return f"{text}<p>no picture: {html.escape(str(error))}</p>"
    names = html.escape(f"{result.a.name or 'a'} and {result.b.name or 'b'}")
    return f'<img alt="{names}" width="{WIDTH}" height="{HEIGHT}" src="data:image/png;base64,{drawn}"/>{text}'


def page_text(results: Iterable[Result], assembly: SceneView | None = None) -> str:
    """The page as one string; it refers to nothing outside itself."""
    pairs = pairs_of(results if assembly is None else shown(results))
    meshes, joints = _Meshes(), PageJoints(partial(_base64, dtype=np.float64))
    written = [_pair(pair, meshes, joints) for pair in pairs]
    title = " and ".join(pairs[0].names)
    content: dict[str, Any] = {"meshes": meshes.written, "shapes": meshes.shapes, "pairs": written}
    if assembly is not None:
        content |= {"unit": assembly.unit, "assembly": _whole(assembly, pairs, meshes, joints)}
    content |= joints.written()
    data = json.dumps(content, allow_nan=False)
    parts = {
        "title": html.escape(title + ("" if len(written) == 1 else f" and {len(written) - 1} more")),
        "style": _asset("page.css"),
        "licence": html.escape(_asset("three.LICENSE.txt")),
        "three": _asset("three.js"),
        # "<" could close the script element from inside a body's name.
        "data": data.replace("<", "\\u003c"),
        "script": _asset("page.js"),
    }
    text = _asset("page.html")
    pieces = text.split("@@")  # literal text and part names take turns
    return "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))


def _asset(name: str) -> str:
    return (files("firstcontact.view") / "page" / name).read_text(encoding="utf-8")


class _Meshes:
    """The meshes of a page, and corners and borders of what of them touches in their coordinates, each written once
    however many pairs name it."""

    def __init__(self) -> None:
        self.written: list[dict[str, Json]] = []
        self.shapes: list[dict[str, Json]] = []
        self._shapes: dict[tuple[bytes, bytes], int] = {}
        self.known: dict[int, Drawing] = {}  # of bodies by their ids, which it keeps alive
        self._index: dict[int, int] = {}
        self._alike: dict[str, int] = {}
        self._drawings: list[Drawing] = []  # keeps the ids above alive

    def index(self, drawing: Drawing) -> int:
        if id(drawing) not in self._index:
            mesh = _mesh(drawing)
            self._drawings.append(drawing)
            self._index[id(drawing)] = self._alike.setdefault(str(mesh), len(self.written))
            if self._index[id(drawing)] == len(self.written):
                self.written.append(mesh)
        return self._index[id(drawing)]

    def shape(self, drawing: Drawing, element: Element) -> int:
        """The number of an element's shape; those that float32 does not tell apart are one, as meshes are."""
        centre, size = drawing.frame
        outline = drawing.outline(element.index) - centre if element.kind == "face" else np.empty((0, 3))
        parts = (drawing.corners(element) - centre) / size, outline / size
        vertices, border = (x.astype(np.float32).tobytes() for x in parts)
        number = self._shapes.setdefault((vertices, border), len(self.shapes))
        if number == len(self.shapes):
            self.shapes.append(dict(zip(("vertices", "outline"), (x.ravel().tolist() for x in parts), strict=True)))
        return number


def _mesh(drawing: Drawing) -> dict[str, Json]:
    """Vertices about the body's centre in units of its size: float32 keeps what is small beside it."""
    centre, size = drawing.frame
    wide = len(drawing.vertices) > 65535  # index 65535 means "restart" to WebGL
    index_type = np.uint32 if wide else np.uint16
    mesh: dict[str, Json] = {
        "vertices": _base64((drawing.vertices - centre) / size, np.float32),
        "triangles": _base64(drawing.triangles, index_type),
        "lines": _base64(drawing.lines, index_type),
        "wide": wide,
    }
    if drawing.normals is not None:
        mesh["normals"] = _base64(drawing.normals, np.float32)
    if drawing.frames is not None:
        times, frames = drawing.frames
        mesh["frameTimes"] = _base64(times, np.float64)
        mesh["frames"] = _base64((frames - centre) / size, np.float32)
    return mesh


def _base64(array: np.ndarray, dtype: DTypeLike) -> str:
    return base64.b64encode(array.astype(np.dtype(dtype).newbyteorder("<")).tobytes()).decode("ascii")


@dataclass(frozen=True)
class _View:
    """The coordinates of the page: (world - origin) / unit, so that float32 is sharp near the contact."""

    origin: np.ndarray
    unit: float

    @classmethod
    def of(cls, pair: PairView, drawn: tuple[Drawing, Drawing]) -> _View:
        (_, size_a), (centre, size_b) = (drawing.frame for drawing in drawn)
        if pair.first is not None and pair.first.point is not None:
            origin = np.asarray(pair.first.point, float)
        else:
            start = pose(pair.b, pair.window[0])
            origin = start[:3, :3] @ centre + start[:3, 3]
        return cls(origin, max(size_a, size_b))

    def motion(self, body: Body, drawing: Drawing, times: Iterable[float], joints: PageJoints) -> dict[str, Json]:
        """How a body moves: by its joints, and where it is when all are 0; or by poses, at these times and more."""
        centre, size = drawing.frame
        linkage = linkage_of(body)
        if linkage is not None:
            return {"joints": joints.chain(linkage), "home": ((centre - self.origin) / self.unit).tolist()}
        samples, poses = sample_poses(partial(self.pose, body, centre), sorted(set(times)), size / self.unit)
        return {"times": _base64(samples, np.float64), "poses": _base64(poses[:, :3, :], np.float64)}

    def pose(self, body: Body, centre: np.ndarray, t: float) -> np.ndarray:
        """(4, 4) from the frame at the body's centre to the page's frame, lengths in `unit` on both sides."""
        m = pose(body, t)
        m[:3, 3] = (m[:3, 3] + m[:3, :3] @ centre - self.origin) / self.unit
        return m


def _pair(pair: PairView, meshes: _Meshes, joints: PageJoints) -> dict[str, Json]:
    """Everything the page needs about one pair."""
    first = pair.first
    drawn = drawings(pair, meshes.known)
    view = _View.of(pair, drawn)
    point = None if first is None or first.point is None else np.zeros(3)  # it is the origin
    bodies = [
        _body(pair, body, drawing, elements, view, meshes, joints)
        for body, drawing, elements in zip((pair.a, pair.b), drawn, pair.elements, strict=True)
    ]
    return {
        "title": " and ".join(pair.names),
        "names": pair.names,
        "status": _status(pair),
        "text": str(pair.curve or (pair.intervals if first is None else first)),
        "rows": _rows(pair),
        "layers": [] if pair.curve is None else _layers(pair.curve, drawn, view),
        "window": pair.window,
        "span": [_number(t) for t in pair.span],
        "contact": pair.contact_time,
        "point": None if point is None else point.tolist(),
        "normal": None if first is None or first.normal is None else [float(x) for x in first.normal],
        "shared": ((contact_curve(pair) - view.origin) / view.unit).ravel().tolist(),
        "timeline": pair.timeline,
        "bodies": bodies,
        "origin": view.origin.tolist(),
        "unit": view.unit,
    }


def _whole(assembly: SceneView, pairs: list[PairView], meshes: _Meshes, joints: PageJoints) -> dict[str, Json]:
    """Every body that can be drawn alone, in a frame of all; which of them each pair is about, by their numbers."""
    in_pairs = {id(at_rest(x)) for pair in pairs for x in (pair.a, pair.b)}
    found = drawn(assembly, in_pairs, meshes.known)
    centres = np.array([drawing.frame[0] for drawing in found.values()] or [np.zeros(3)])
    spread = float(np.abs(centres - centres.mean(axis=0)).max())
    size = max([spread, *(drawing.frame[1] for drawing in found.values())], default=1.0)
    view = _View(centres.mean(axis=0), size)
    window = min(pair.window[0] for pair in pairs), max(pair.window[1] for pair in pairs)
    bodies = []
    for name, drawing in found.items():
        body = assembly.bodies[name]
        lo, hi = _within(body, window)
        bodies.append({
            "name": name, "mesh": meshes.index(drawing), "size": drawing.frame[1] / view.unit,
            **view.motion(body, drawing, (lo, hi) if is_moving(body) else (lo,), joints),
        })  # fmt: skip
    numbers = {id(assembly.bodies[name]): k for k, name in enumerate(found)}
    members = [[numbers.get(id(x), -1) for x in (pair.a, pair.b)] for pair in pairs]
    return {"bodies": bodies, "members": members, "origin": view.origin.tolist(), "unit": view.unit}


def _within(body: Body, window: tuple[float, float]) -> tuple[float, float]:
    """The part of the window in which the body has poses."""
    if not is_moving(body) or body.motion.extends:
        return window
    lo, hi = body.motion.span
    return max(lo, window[0]), min(hi, window[1])


def _status(pair: PairView) -> str:
    if pair.curve is None:
        return pair.status.name
    return "APART" if pair.curve.empty else "CURVE"


def _layers(curve: IntersectionCurve, drawn: tuple[Drawing, Drawing], view: _View) -> list[dict[str, Json]]:
    """What lies on both surfaces, in the page's frame; what each of its items is says `firstcontact.view.curve`."""
    return [
        {
            "name": layer["name"], "colour": layer["colour"], "kind": layer["kind"],
            "points": ((layer["points"] - view.origin) / view.unit).ravel().tolist(),
        }
        for layer in layers(curve, drawn)
    ]


def _body(
    pair: PairView, body: Body, drawing: Drawing, elements: list[Element], view: _View,
    meshes: _Meshes, joints: PageJoints,
) -> dict[str, Json]:  # fmt: skip
    centre, size = drawing.frame
    lo, hi = pair.window
    times = (lo, hi, *(t for t in pair.moments if lo <= t <= hi)) if is_moving(body) else (lo,)
    return {
        "mesh": meshes.index(drawing),
        "moving": is_moving(body),
        "size": size / view.unit,
        **view.motion(body, drawing, times, joints),
        "carried": _carried_point(pair, body, centre, view).tolist(),
        "elements": [_element(meshes.shape(drawing, x), x, pair.names) for x in elements],
    }


def _carried_point(pair: PairView, body: Body, centre: np.ndarray, view: _View) -> np.ndarray:
    """The point of the body whose path is drawn, in its own frame: where it touches, or its centre."""
    if pair.first is None or pair.first.point is None or pair.contact_time is None:
        return np.zeros(3)
    m = view.pose(body, centre, pair.contact_time)
    return -m[:3, :3].T @ m[:3, 3]


def _element(shape: int, element: Element, names: tuple[str, str]) -> dict[str, Json]:
    """shape: its number in the page."""
    return {
        "kind": element.kind,
        "index": element.index,
        "name": str(element),
        "label": "" if element.label in names else element.label,
        "shape": shape,
    }


def _rows(pair: PairView) -> list[tuple[str, str]]:
    """Label and text of the facts beside the picture."""
    rows: list[tuple[str, str]] = []
    first, intervals = pair.first, pair.intervals
    if pair.curve is not None:
        closed = sum(branch.closed for branch in pair.curve.branches)
        return [("closed", str(closed)), ("open", str(len(pair.curve.branches) - closed)), ("path", pair.curve.method)]
    if first is not None:
        rows += _rows_of_first(first)
    if intervals is not None:
        listed = [str(interval) for interval in intervals[:MOST_LISTED]]
        if len(intervals) > MOST_LISTED:
            listed.append(f"and {len(intervals) - MOST_LISTED} more")
        rows.append(("in contact", "\n".join(listed) or "never"))
        if intervals.status is Status.UNDECIDED and first is None:
            rows += [("decided until", repr(intervals.free_until)), ("reason", str(intervals.reason))]
    return rows


def _rows_of_first(first: FirstContact) -> list[tuple[str, str]]:
    if first.status is Status.FREE:
        return [("proved", f"no shared point at any time of [{first.span[0]:g}, {first.span[1]:g}]")]
    if first.status is Status.UNDECIDED:
        return [("free until", f"{first.free_until!r}"), ("reason", str(first.reason))]
    rows = [("time", repr(first.time))]
    if first.time_interval is not None and first.status is Status.CONTACT:
        rows.append(("enclosed in", "[{!r}, {!r}]".format(*first.time_interval)))
    if first.time_exact is not None:
        rows.append(("exactly", str(first.time_exact)))
    if first.initial is not None:
        rows.append(("at the start", first.initial))
    if first.point is not None:
        rows.append(("point", _vector(first.point)))
    if first.normal is not None:
        rows.append(("normal", _vector(first.normal)))
    if first.contact_set not in (None, "point"):
        rows.append(("they share", f"a {first.contact_set}"))
    if first.multiplicity > 1:
        rows.append(("also", f"{first.multiplicity - 1} more element pairs"))
    return rows


def _vector(values: np.ndarray) -> str:
    return "({:.6g}, {:.6g}, {:.6g})".format(*(x + 0.0 for x in values))


def _number(t: float) -> str:
    return f"{t:g}".replace("inf", "\N{INFINITY}")
