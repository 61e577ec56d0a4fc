"""The library and the slow reference asked the same question."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

import firstcontact as fc
import naive
from generators import Scene, is_closed, lattice_scene
from vectors import Body


def polyhedron(body: Body, solid: bool = False, name: str | None = None) -> fc.Polyhedron:
    return fc.Polyhedron(body.v, body.f, edges=body.e if body.e else None, solid=solid, name=name)


def library_motion(scene: Scene):
    if scene.translation is not None:
        return fc.Translation(scene.translation)
    assert scene.rotation is not None
    return fc.Rotation(**scene.rotation)


def reference_motion(scene: Scene):
    if scene.translation is not None:
        return naive.Shift(scene.translation)
    assert scene.rotation is not None
    return naive.Turn(**scene.rotation)


def library_span(scene: Scene) -> tuple:
    if scene.until is None:
        return (0, math.inf) if scene.translation is not None else (0, 1)
    return (0, scene.until)


def question(scene: Scene) -> tuple:
    """Arguments of a library verb."""
    owns = [scene.solid and bool(body.f) for body in (scene.a, scene.b)]
    a, b = polyhedron(scene.a, owns[0], "a"), polyhedron(scene.b, owns[1], "b")
    return a.moving(library_motion(scene)), b, library_span(scene)


def reference(verb, scene: Scene):
    a, b = scene.a, scene.b
    owns = [scene.solid and bool(body.f) for body in (a, b)]
    return verb(a.v, a.e, a.f, b.v, b.e, b.f, reference_motion(scene), scene.until, *owns)


def assert_same_first_contact(scene: Scene, exact: bool = False, engine: str = "auto") -> str:
    """Status and the correctly rounded time are those of the reference; returns the status' name."""
    status, time, nearest = reference(naive.first_contact, scene)
    hit = fc.first_contact(*question(scene), exact=exact, engine=engine)
    assert hit.status.name == status, f"{hit.status.name}, reference {status} at {nearest}: {scene}"
    if status == naive.FREE:
        assert hit.time is None and hit.free_until == float(library_span(scene)[1]), scene
        return status
    assert hit.time == nearest, f"time {hit.time!r}, reference {nearest!r}: {scene}"
    lo, hi = hit.time_interval
    assert reference_motion(scene).enclosed(time, lo, hi), f"{lo!r}, {hi!r} exclude {nearest!r}: {scene}"
    assert hi - lo <= 1e-12 * width_scale(scene, nearest), f"[{lo!r}, {hi!r}] is wide: {scene}"
    if exact:
        assert_same_exact_time(hit.time_exact, time, nearest, scene)
    if hit.point is not None:
        assert_point_and_normal(hit, scene)
    else:
        assert hit.initial == "containment", scene
    return status


def assert_point_and_normal(hit: fc.FirstContact, scene: Scene) -> None:
    """The point is on both surfaces at that time; the normal is unit and against the motion of a."""
    pose = library_motion(scene)(hit.time)
    points_a = [pose[:3, :3] @ np.array(p, float) + pose[:3, 3] for p in scene.a.v]
    points_b = [np.array(p, float) for p in scene.b.v]
    size = float(np.abs(points_a + points_b).max()) or 1.0
    for points, body in ((points_a, scene.a), (points_b, scene.b)):
        assert distance(hit.point / size, [p / size for p in points], body) <= 1e-9, f"{hit.point}: {scene}"
    if hit.normal is not None:
        assert abs(np.linalg.norm(hit.normal) - 1) <= 1e-12, scene
        speed = max(map(abs, map(float, scene.translation or scene.rotation["axis"])))
        rounding = 1e-13 * speed * (size if scene.translation is None else 1.0)
        assert hit.normal @ velocity(scene, hit.point) < rounding, scene


def velocity(scene: Scene, point) -> np.ndarray:
    if scene.translation is not None:
        return np.array(scene.translation, float)
    assert scene.rotation is not None
    arm = point - np.array(scene.rotation.get("point", (0, 0, 0)), float)
    forward = scene.rotation.get("turns", scene.rotation.get("radians")) > 0
    return np.cross(np.array(scene.rotation["axis"], float), arm) * (1 if forward else -1)


def distance(x, points: list, body: Body) -> float:
    """Distance from x to the nearest point, edge or face of the body whose vertices are at `points`."""
    sides = body.e + [[f[k], f[k - 1]] for f in body.f for k in range(3)] or [
        [i, i] for i in range(len(points))
    ]
    to_sides = [_to_segment(x, points[i], points[j]) for i, j in sides]
    to_faces = [_to_plane_inside(x, *(points[i] for i in f)) for f in body.f]
    return float(min(to_sides + to_faces))


def _to_segment(x, c, d) -> float:
    f = d - c
    mu = np.clip((x - c) @ f / (f @ f), 0, 1) if f.any() else 0.0
    return float(np.linalg.norm(x - c - mu * f))


def _to_plane_inside(x, a, b, c) -> float:
    """Distance to the plane of the triangle for x above its inside, else infinity."""
    n = np.cross(b - a, c - a)
    if not n.any() or any(n @ np.cross(q - p, x - p) < 0 for p, q in ((a, b), (b, c), (c, a))):
        return math.inf
    return float(abs(n @ (x - a)) / np.linalg.norm(n))


def width_scale(scene: Scene, time: float) -> float:
    end = library_span(scene)[1]
    return float(end) if end != math.inf else max(1.0, abs(time))


def assert_same_exact_time(found, time, nearest: float, scene: Scene) -> None:
    if scene.translation is not None:
        assert isinstance(found, Fraction), scene
        assert found == Fraction(int(time.numer()), int(time.denom())), scene
    else:
        assert float(found) == nearest, f"{found!r}, reference {nearest!r}: {scene}"


def same_answer(x: fc.FirstContact, y: fc.FirstContact) -> bool:
    found = ("status", "time", "time_interval", "element_a", "element_b", "others", "multiplicity")
    return all(getattr(x, name) == getattr(y, name) for name in found)


def shaken(scene: Scene, seed: int) -> Scene:
    """The scene in general position, about an oblique axis."""
    rng = np.random.default_rng(seed)
    a, b = (replace(x, v=(np.array(x.v) + rng.normal(size=(len(x.v), 3)) / 4).tolist()) for x in (scene.a, scene.b))
    if scene.rotation is None:
        return replace(scene, a=a, b=b)
    return replace(scene, a=a, b=b, rotation={**scene.rotation, "axis": rng.normal(size=3).tolist()})


def small_scenes(first: int, count: int, rotating: bool) -> Iterator[Scene]:
    """Scenes on a lattice by their seeds, every third one shaken; every other one of solids where both are closed."""
    for seed in range(first, first + count):
        scene = lattice_scene(seed, rotating)
        if seed % 3 == 1:
            scene = shaken(scene, seed)
        closed = seed % 2 == 1 and is_closed(scene.a) and is_closed(scene.b)
        yield replace(scene, solid=closed)
