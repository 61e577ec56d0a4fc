"""Questions that were found slow, or that did not end: what was measured before, a bar, and how the question is made.

A maker makes bodies anew and returns the question, so that nothing is kept from the one before but compiled kernels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction as F  # noqa: N817
from typing import Any, Literal

import numpy as np
import trimesh

import firstcontact as fc

Question = Callable[[], Any]
Maker = Callable[[], Question]


@dataclass(frozen=True)
class Row:
    before: str
    bar: float | tuple[float, str] | None
    """Seconds, or how many times what another row takes."""
    of: Literal["all", "first", "later"]
    """What the bar is of: bodies and first answer, the first answer, a later one of the same bodies."""
    make: Maker


ROWS: dict[str, Row] = {}


def row(
    name: str, before: str, bar: float | tuple[float, str] | None, of: Literal["all", "first", "later"] = "first"
) -> Callable[[Maker], Maker]:
    def add(make: Maker) -> Maker:
        assert name not in ROWS, name
        ROWS[name] = Row(before, bar, of, make)
        return make

    return add


def first(a: Any, b: Any, **options: Any) -> Question:
    return lambda: fc.first_contact(a, b, **options)


def intervals(a: Any, b: Any, **options: Any) -> Question:
    return lambda: fc.contact_intervals(a, b, **options)


# -- meshes ---------------------------------------------------------------------------------------------------


@row("sweep under a rotation that spun in a kernel", "did not end", 1)
def _sweep() -> Question:
    a = fc.Polyhedron([(-3, 3, -4), (-1, 1, -4), (-1, 3, -6)], [(0, 1, 2)])
    corners = [
        (3, -3, 1), (-3, -3, 1), (-3, 3, 1), (3, 3, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1), (1, 1, 1), (3, -3, -1),
        (-3, -3, -1), (-3, 3, -1), (3, 3, -1), (1, -1, -1), (-1, -1, -1), (-1, 1, -1), (1, 1, -1),
    ]  # fmt: skip
    faces = [(9, 10, 14), (9, 14, 13), (2, 3, 11), (2, 11, 10), (6, 15, 7), (6, 14, 15), (2, 3, 7), (2, 7, 6)]
    return first(a.moving(fc.Rotation((1, 1, 1), radians=1)), fc.Polyhedron(corners, faces), engine="sweep")


def _stretching() -> tuple[Any, Any]:
    long = [[1, 0, 0, 4], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]]
    one = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    way = fc.Sequence([fc.Rotation((0, 0, 1), degrees=30), fc.RationalMotion([one, long])])
    return _box().moving(way), _box().translated((3, 1, 0))


row("stretching motion after an irrational pose", "ValueError, 200 s", 30)(lambda: first(*_stretching()))
row("stretching motion after an irrational pose, intervals", "ValueError, 200 s", 30)(lambda: intervals(*_stretching()))


def _sliding(parts: str) -> Question:
    corners = [(3, 0, 0), (2, 1, 0), (1, -1, 0), (2, 0, 1.5)]
    part = fc.Polyhedron(corners, [(2, 1, 0), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    if parts == "angle":
        ring = [(1, -1), (3, -1), (3, 0), (2, 0), (2, 1), (1, 1)]
        sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
        part = fc.Polyhedron([(*p, z) for z in (0, 1) for p in ring], [[5, 4, 3, 2, 1, 0], [*range(6, 12)], *sides])
    table = fc.examples.box((6, 6, 1)).translated((0, 0, -0.5)).moving(fc.Rotation((0, 0, 1), degrees=100))
    return intervals(part.moving(fc.Rotation((0, 0, 1), point=(5, 0, 0), degrees=170)), table)


row("a tetrahedron on a table, both turn about parallel axes, intervals", "9 s", 1)(lambda: _sliding("tetrahedron"))
row("an angle on a table, both turn about parallel axes, intervals", "14 s, UNDECIDED", 1)(lambda: _sliding("angle"))


def _box(size: float = 1) -> Any:
    return fc.examples.box((size, size, size))


def _ways() -> dict[str, Any]:
    """Each moves 3 along x and turns by some 40 degrees about it, the rotation goes as far about a distant axis."""
    return {
        "rotation": fc.Rotation((0, 0, 1), point=(1.5, -4, 0), degrees=-42),
        "screw": fc.Screw((1, 0, 0), degrees=40, advance=3),
        "between": fc.RationalMotion.between((0, 0, 0), (3, 0, 0), quat_wxyz=((1, 0, 0, 0), (3, 1, 0, 0))),
        "quaternions": fc.Trajectory(
            (0, 1), [_pose(0, (0, 0, 0)), _pose(40, (3, 0, 0))], interpolation="linear-quaternion"
        ),
    }


def _pose(degrees: float, at: tuple[float, float, float]) -> Any:
    """Turned about the x axis, then shifted."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[1, 0, 0, at[0]], [0, c, -s, at[1]], [0, s, c, at[2]], [0, 0, 0, 1]])


def _add_motions() -> None:
    bodies: dict[str, Callable[[], Any]] = {
        "boxes": lambda: _box().rotated((1, 2, 3), degrees=25),
        "meshes of 10,000 triangles": lambda: fc.examples.noisy_sphere(10_000),
    }
    before = {"rotation": "0.2 ms", "screw": "10 ms", "between": "57 ms", "quaternions": "-"}
    for kind, make in bodies.items():
        for motion in ("rotation", "screw", "between", "quaternions"):
            bar = None if motion == "rotation" else (5.0, f"{kind} that meet, rotation")
            told = before[motion] if kind == "boxes" else "-"

            def meet(make: Any = make, motion: str = motion) -> Question:
                return first(make().moving(_ways()[motion]), make().translated((3, 0.2, 0.1)))

            def far(make: Any = make, motion: str = motion) -> Question:
                return first(make().moving(_ways()[motion]), make().translated((30, 40, 50)))

            row(f"{kind} that meet, {motion}", told, bar, "later")(meet)
            row(f"{kind} far apart, {motion}", "11 ms" if motion == "rotation" else "-", 1e-4, "later")(far)


_add_motions()


@row("boxes that land flat, rotation", "-", None, "later")
def _flat_turn() -> Question:
    way = fc.Rotation((0, 0, 1), point=(1.5, -1.5, 0), degrees=-100)
    return first(_box().moving(way), _box().translated((3, -1, 0.2)))


def _add_flat() -> None:
    for motion, before in (("screw", "10 ms"), ("between", "57 ms"), ("quaternions", "-")):

        def land(motion: str = motion) -> Question:
            return first(_box().moving(_ways()[motion]), _box().translated((3, 0.2, 0.1)))

        row(f"boxes that land flat, {motion}", before, (5.0, "boxes that land flat, rotation"), "later")(land)


_add_flat()


@row("between near half a turn, far spheres of 1,280 triangles", "54 s", 1)
def _half_turn() -> Question:
    way = fc.RationalMotion.between((0, 0, 0), (0, 0, 1), quat_wxyz=((1, 0, 0, 0), (0.01, 0, 0, 1)))
    ball = fc.examples.noisy_sphere(1280)
    return first(ball.moving(way), ball.translated((5, 0, 0)))


@row("100 turning boxes, all pairs", "57 s", 1)
def _hundred() -> Question:
    way = fc.Rotation((0, 0, 1), degrees=90)
    bodies = [_box().translated((30 * (k % 10), 30 * (k // 10), 4 * k)).moving(way) for k in range(100)]

    def ask() -> str:
        told = {fc.first_contact(a, b).status.name for k, a in enumerate(bodies) for b in bodies[:k]}
        return ", ".join(sorted(told))

    return ask


def _circle(x: float, y: float, r: float, n: int) -> list[tuple[float, float]]:
    return [(x + r * math.cos(2 * math.pi * k / n), y + r * math.sin(2 * math.pi * k / n)) for k in range(n)]


def _plate(n: int = 128) -> Any:
    """180 by 150 by 20 with six holes of radius 5: 3,108 triangles."""
    rings = [[(0, 0), (180, 0), (180, 150), (0, 150)]]
    rings += [_circle(30 + 60 * (k % 3), 40 + 70 * (k // 3), 5, n) for k in range(6)]
    vertices: list[tuple[float, float, float]] = []
    faces: list[Any] = []
    below, above = [], []
    for ring in rings:
        first, m = len(vertices), len(ring)
        vertices += [(x, y, z) for z in (0.0, 20.0) for x, y in ring]
        below.append([first + k for k in range(m)])
        above.append([first + m + k for k in range(m)])
        for k in range(m):
            p, q = first + k, first + (k + 1) % m
            faces += [[p, q, q + m], [p, q + m, p + m]]
    body = fc.Polyhedron(vertices, [*faces, below, above])
    return fc.Polyhedron(np.array(body.vertices), np.array(body.triangles))


def _bolt(n: int = 128) -> Any:
    """Its shank fills the first hole, its head lies on the plate: 1,024 triangles."""
    rings = [[(x, y, z) for x, y in _circle(30, 40, r, n)] for r, z in ((5, -10.0), (5, 20.0), (9, 20.0), (9, 26.0))]
    vertices = np.array([*(p for ring in rings for p in ring), (30, 40, -10), (30, 40, 26)])
    faces = []
    for k in range(n):
        j = (k + 1) % n
        for a, b in ((0, n), (n, 2 * n), (2 * n, 3 * n)):
            faces += [(a + k, a + j, b + j), (a + k, b + j, b + k)]
        faces += [(j, k, 4 * n), (3 * n + k, 3 * n + j, 4 * n + 1)]
    return fc.Polyhedron(vertices, np.array(faces))


@row("start of a bolt in a plate, 800 points shared", "22 s", 0.3)
def _bolted() -> Question:
    return first(_bolt().moving(fc.Translation((0, 0, 1))), _plate())


@row("start of two equal plates, 1,500 points shared", "4.4 s", 1)
def _plates() -> Question:
    return first(_plate().translated((0, 0, 20)).moving(fc.Translation((0, 0, 1))), _plate())


# -- solids ---------------------------------------------------------------------------------------------------


def _tool(kind: str) -> Any:
    if kind == "countersunk":
        return fc.cylinder(2, 8) | fc.frustum(0, 6, 6).translated((0, 0, -2))
    if kind == "drill-tipped":
        return fc.cylinder(2, 4).translated((0, 0, 2)) | fc.frustum(0, 2, "3/2").translated((0, 0, "-3/2"))
    if kind == "counterbored":
        return fc.cylinder(2, 8) | fc.cylinder(3, 4).translated((0, 0, 2))
    ends = [fc.cylinder("3/2", 8).translated((x, 0, 0)) for x in (2, -2)]
    return fc.box((4, 3, 8)) | ends[0] | ends[1]


def _holes(kind: str, n: int = 10) -> Any:
    body = fc.box((10 * n, 10 * n, 4))
    for r in range(n):
        for c in range(n):
            body -= _tool(kind).translated((10 * c - 5 * (n - 1), 10 * r - 5 * (n - 1), 0))
    return body


def _add_plates() -> None:
    found = {"countersunk": "10: 43 s", "drill-tipped": "8: 23 s", "counterbored": "-", "slotted": "10: 9.5 s"}
    for kind, before in found.items():

        def ask(kind: str = kind) -> Question:
            ball = fc.sphere(1).translated((5, 5, 20)).moving(fc.Translation((0, 0, "-33/2")))
            return first(ball, _holes(kind))

        row(f"a plate with 100 {kind} holes, built and asked", before, 5, "all")(ask)
        row(f"a plate with 100 {kind} holes, asked again", "-", 0.05, "later")(ask)


_add_plates()


@row("ball cap 1/100 thin", "AssertionError", 5, "all")
def _cap() -> Question:
    cap = fc.sphere(100) & fc.half_space((0, 0, -1), -99)
    return first(cap.moving(fc.Translation((0, 0, -100))), fc.sphere(1))


@row("edge of degree 4 that a redundant quadric touches", "UnsupportedPair", 30, "all")
def _degree_four() -> Question:
    Q, H = fc.quadric, fc.half_space  # noqa: N806
    s = Q([[4, 0, 0, 0], [0, 4, 0, 0], [0, 0, 4, 0], [0, 0, 0, -9]])
    c = Q([[4, 0, 0, 4], [0, 4, 0, 4], [0, 0, -4, 6], [4, 4, 6, -1]]) & H((0, 0, 2), 3) & H((0, 0, -2), 1)
    k = Q([[100, 0, 0, 100], [0, -4, 0, -6], [0, 0, 100, 100], [100, -6, 100, 191]])
    k = k & H((0, -2, 0), 3) & H((0, 1, 0), 1)
    return first(((s - c) & k).translated((0, 0, 5)).moving(fc.Translation((0, 0, -5))), fc.sphere(1))


def _drilled() -> tuple[Any, Any]:
    plate = fc.box((8, 8, 2)) - fc.cylinder(2, 4)
    ring = (fc.cylinder(3, 2) - fc.cylinder(1, 4)).translated((1, 0, 6))
    return ring.moving(fc.Rotation((0, 1, 0), point=(6, 0, 3), degrees=200)), plate


row("drilled plate and ring, first contact", "0.3 to 1 s", None)(lambda: first(*_drilled()))
row("drilled plate and ring, intervals", "up to 28 s", (5.0, "drilled plate and ring, first contact"))(
    lambda: intervals(*_drilled())
)


@row("a round bolt under a screw in a plate that turns about its axis", "UNDECIDED", 5, "all")
def _fitted() -> Question:
    plate = (fc.box((8, 8, 2)) - fc.cylinder(2, 4)).moving(fc.Rotation((0, 0, 1), degrees=100))
    return first(fc.cylinder("1999/1000", 6).moving(fc.Screw((0, 0, 1), degrees=50, advance=3)), plate)


def _flush(body: Any) -> tuple[Any, Any]:
    way = fc.Screw((0, 0, 1), degrees=180, advance=1)
    return body.translated((0, -4, -1)).moving(way), fc.box((2, 2, 4)).translated((2, 0, 0))


row("solids whose sides come flush under a screw", "UNDECIDED", 5)(lambda: first(*_flush(fc.box((2, 2, 2)))))
row("solids whose sides come flush under a screw, intervals", "UNDECIDED", 5)(
    lambda: intervals(*_flush(fc.box((2, 2, 2))))
)
row("a drilled solid whose side comes flush under a screw, intervals", "UNDECIDED", 5)(
    lambda: intervals(*_flush(fc.box((2, 2, 2)) - fc.cylinder("1/2", 4)))
)


@row("tool of five curved pieces along 499 steps of five axes, intervals", "11 steps in 400 s", 30)
def _five_axes() -> Question:
    pieces = [fc.cylinder(1, 4), fc.sphere(1).translated((0, 0, -2)), fc.frustum(1, 2, 2).translated((0, 0, 2))]
    pieces += [fc.cylinder(2, 4).translated((0, 0, 6)), fc.frustum(2, 1, 1).translated((0, 0, 8))]
    tool = pieces[0] | pieces[1] | pieces[2] | pieces[3] | pieces[4]
    times = np.linspace(0, 1, 500)
    places = [(20 * t - 10, 3 * math.sin(5 * t), 6 + math.cos(7 * t)) for t in times]
    poses = [_pose(20 * math.sin(9 * t), at) for t, at in zip(times, places, strict=True)]
    way = fc.Trajectory(times, poses, interpolation="linear-quaternion")
    return intervals(tool.moving(way), fc.cylinder(3, 6) - fc.cylinder(1, 8))


# -- ruled surfaces -------------------------------------------------------------------------------------------


@row("box and blade, intervals, in the order that grew", "7 GB, did not end", 30)
def _blade() -> Question:
    blade = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
    way = fc.RationalMotion.between((0, 0, 0), (0, 0, 9), quat_wxyz=((1, 0, 0, 0), (1, 0, 0, 1)))
    return intervals(_box().translated((0, 0, 5)), blade.moving(way))


def _pair_under_screw() -> tuple[Any, Any]:
    a = fc.RuledSurface("((6*u**2+4*u+9)/2,(-6*u**2-2*u-1)/2,(4*u**2-3)/2)", "(7/2,-3/2,-1/2)")
    b = fc.RuledSurface("((3*u-2)/(u+3),1,1/(u+3))", "(-3,-2*u-3,u+3)")
    return a.moving(fc.Screw((1, 2, 2), point=(1, -3, 2), degrees=180, advance=1)), b


row("two ruled pieces under a screw", "CONTACT or UNDECIDED", 30)(lambda: first(*_pair_under_screw()))
row("two ruled pieces under a screw, in the other order", "CONTACT or UNDECIDED", 30)(
    lambda: first(*_pair_under_screw()[::-1])
)
row("two ruled pieces under a screw, intervals", "13 to 18 s, UNDECIDED", 30)(lambda: intervals(*_pair_under_screw()))


@row("contact_condition of two pieces whose rulings are all parallel", "over 25 s", 8)
def _parallel_rulings() -> Question:
    low = "5*u + 3*(u**2 + T)", "2*u**2 + 2*T - u", "u - u**2 - T"
    bent = fc.RuledSurface(f"({', '.join(low)})", f"({low[0]} + 3, {low[1]} + 1, {low[2]} - 2)", u=(-2, 2))
    flat = fc.RuledSurface("(5*u, -u, u)", "(5*u + 6, 2 - u, u - 4)", u=(-1, 2))
    return lambda: fc.contact_condition(bent, flat)


@row("trimmed pieces under a translation", "refused", 30)
def _trimmed() -> Question:
    cut = fc.RuledSurface("(u,0,0)", "(1,u**2,u)", trim=["u**2+s**2<=1"]).translated((-3, 0, 0))
    return first(cut.moving(fc.Translation((6, 0, 0))), fc.RuledSurface("(0,u,u**2)", "(u,1,1+u)"))


@row("two cones of degree 5 with one apex, curve", "over 170 s", 30)
def _cones() -> Question:
    p = fc.RuledSurface("(0, 0, 0)", "(u**5 - u, u**2 + 1, u**3)")
    q = fc.RuledSurface("(0, 0, 0)", "(u**4 + 2, u**5, u - 1)")
    return lambda: fc.intersection_curve(p, q)


@row("strip of degree 4 against itself", "46 s", 30)
def _itself() -> Question:
    strip = fc.RuledSurface("(u**4/(1+u**2), u**2, u)", "(u/(1+u**2), u**3 + 1, u**4 + u)")
    return first(strip.translated((0, 0, 4)).moving(fc.Translation((0, 0, -8))), strip)


@row("L-shaped polyhedron on a trajectory against a ruled piece", "47 s", 30)
def _angle() -> Question:
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
    sides = [[k, j, j + 6, k + 6] for k in range(6) for j in [(k + 1) % 6]]
    angle = fc.Polyhedron(corners, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides])
    poses = [_pose(d, (0, 0, z)) for d, z in ((0, 4), (20, 2), (50, -2))]
    way = fc.Trajectory((0, 1, 2), poses)
    return first(angle.moving(way), fc.RuledSurface("(u, 0, 0)", "(u, 1, u)"))


@row("two ruled pieces of degree 2 in a full turn", "29.5 s", 30)
def _full_turn() -> Question:
    a = fc.RuledSurface("(u, u**2, 0)", "(u, 1, u**2 + 1)").translated((2, 0, 0))
    return first(a.moving(fc.Rotation((0, 0, 1), turns=1)), fc.RuledSurface("(u**2, u, 0)", "(-1, u, u**2 + 1)"))


@row("apexes a hair apart that turn about one axis", "over 80 s", 30)
def _apexes() -> Question:
    turn = [fc.Rotation((F(6, 19), F(-18, 19), F(1, 19)), (-1, 3, 3), degrees=d) for d in (217, 17)]
    a = fc.RuledSurface(
        "(7500000000003/9500000000000 + 6*u/19 + 18*u**2/19, 34499999999991/9500000000000 + u/19 - 54*u**2/19,"
        " 69000000000001/19000000000000 - 18*u/19 + 3*u**2/19)",
        "(-26499999999997/9500000000000 + 6*u/19 + 18*u**2/19, 22499999999991/9500000000000 + u/19 - 54*u**2/19,"
        " 45000000000001/19000000000000 - 18*u/19 + 3*u**2/19)",
        u=(-3, 1),
    )  # fmt: skip
    b = fc.RuledSurface(
        "((-25/19 - 102*u/19 - 37*u**2/19)/(1 + u**2), (94/19 - 36*u/19 + 92*u**2/19)/(1 + u**2),"
        " (37/19 - 36*u/19 + 73*u**2/19)/(1 + u**2))",
        "(-1, 3, 3)", u=None,
    )  # fmt: skip
    return first(a.moving(turn[0]), b.moving(turn[1]))


@row("two ruled pieces of which one deforms, exact", "20 s", 30)
def _deforming() -> Question:
    a = fc.RuledSurface(
        "((188/9 - 85*u/18 - 5*u**2/18)/(4 - u + u**2), (64/9 - 5*u/18 + 59*u**2/18)/(4 - u + u**2),"
        " (77/9 + 65*u/18 - 11*u**2/18)/(4 - u + u**2))",
        "(85/18 - 2*u + 4*u**2, 77/18 - 6*u + 6*u**2, 25/18 + 4*u - 5*u**2)",
    )  # fmt: skip
    b = fc.RuledSurface(
        "(3 - 6*u + u**2 + 6*T, -2 + 2*u + 3*u**2 + 4*T, -2 + u**2 + 3*T)",
        "(2*u - 3*u**2 + 6*T, -3 + 4*u + 2*u**2 + 4*T, 3 - 4*u + 3*T)",
    )
    return first(a, b, span=(0.8125, 1), exact=True)


@row("a box that slides in the plane of a disc", "9.3 s, exact 2.5 s", 7.5)
def _in_plane() -> Question:
    disc = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), trim=["u**2 + (2*s - 1)**2 <= 1"])
    return first(fc.box((2, 4, 2)).translated((-1, 9, -1)).moving(fc.Translation((0, -21, 0))), disc)


@row("contact_condition of a cusp under a skew matrix, text", "12 s", 2)
def _cusp() -> Question:
    skew = [[1, 2, 1, -1], [2, -1, 0, 1], [1, 0, 1, 1], [0, 0, 0, 1]]
    p = fc.RuledSurface("(u, u-u**2-u**3+2*T, 0)", "(u, u-u**2-u**3+2*T, 1)", u=(-1, F(3, 2))).transformed(skew)
    q = fc.RuledSurface("(u**2, u**3, T-2)", "(u**2, u**3, T-1)", u=(-1, F(1, 3))).transformed(skew)
    return lambda: str(fc.contact_condition(p, q))


@row("quarter of a tube that turns about a quarter rod of its radius, intervals", "28 s, exact 4.6 s", 30)
def _quarter_tube() -> Question:
    cosine, sine = "(1-u**2)/(1+u**2)", "2*u/(1+u**2)"
    tube = fc.RuledSurface(f"({cosine}, {sine}, 0)", f"({cosine}, {sine}, 2)", u=(0, 1))
    rod = fc.cylinder(1, 2).translated((0, 0, 1)) & fc.box((4, 4, 8)).translated((-2, -2, 0))
    return intervals(tube.moving(fc.Rotation((0, 0, 1), degrees=360)), rod)


# -- landings -----------------------------------------------------------------------------------------------


def _lid() -> tuple[Any, Any]:
    """Set down by a turn of 3, 4, 5 on a base of its own outline, and taken up again."""
    turns = (1, 0, 2), (F(4, 5), F(3, 5), 0), (1, 0, 2)
    poses = [[[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, z], [0, 0, 0, 1]] for c, s, z in turns]
    lid, base = (fc.box((2, 3, h)).translated((1, F(3, 2), z)) for h, z in ((F(1, 4), F(1, 8)), (1, F(-1, 2))))
    return lid.moving(fc.Trajectory([0, 1, 2], poses, interpolation="screw")), base


@row("a lid set down on its base by a trajectory of screws", "7.4 s", 1)
def _set_down() -> Question:
    return first(*_lid())


@row("a lid set down on its base by a trajectory of screws, intervals", "12.5 s", 1)
def _set_down_intervals() -> Question:
    return intervals(*_lid())


# -- links --------------------------------------------------------------------------------------------------


@row("faces that slide across a hinge's axis, at a changing pace, intervals", "70 s, UNDECIDED", 5)
def _hinge() -> Question:
    sides = [[5, 3, 1], [5, 0, 3], [4, 1, 3], [4, 3, 0], [2, 0, 5], [2, 5, 1], [2, 4, 0], [2, 1, 4]]
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    still = fc.Polyhedron(corners, sides).translated((2, 3, -2)).named("still")
    outline = (-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)
    walls = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    ends = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]]
    prism = fc.Polyhedron([(x, y, z) for z in (-1, 1) for x, y in outline], [*ends, *walls]).translated((-3, 2, 2))
    joint = fc.Joint("hinge", "revolute", "still", "prism", axis=(0, 1, 0), point=(-3, -2, -3), unit="turn")
    machine = fc.Mechanism({"still": still, "prism": prism.named("prism")}, [joint])
    course = machine.course([0, 1, 2], {"hinge": [1, F(-1, 4), F(1, 2)]}, interpolation="cubic")
    return intervals(still, course.bodies["prism"][0])


@row("mesh of 320 triangles past a ruled wing, between, intervals", "39 s", 5)
def _wing() -> Question:
    ball = fc.Polyhedron.from_trimesh(trimesh.creation.icosphere(2)).translated((0.3, 0.2, 5))
    way = fc.RationalMotion.between((0, 0, 0), (0, 0, -9), quat_wxyz=((1, 0, 0, 0), (1, 0, F(1, 3), 0)))
    return intervals(ball.moving(way), fc.RuledSurface("(u, u**2, 0)", "(u, 1 + u**2, u)"))
