"""Intersection curves of ruled surfaces beside OpenCASCADE: `python benchmarks/ruled.py` writes RULED.md.

Tools take turns on every scene.  A scene's surfaces are made anew for each repeat of firstcontact, so nothing it keeps
on them is reused.  What is measured of the curves is computed apart from both tools: points are put into exact
equations, and branches that may be missing are looked for on a grid of the parameters.
"""

from __future__ import annotations

import argparse
import json
import platform
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import firstcontact as fc

TOLERANCE = 1e-6


class Scene(NamedTuple):
    """make: the two surfaces, anew; grids: control points, knots and weights of both for OpenCASCADE, or None."""

    name: str
    make: Callable[[], tuple[Any, Any]]
    other: tuple[Any, Any] | None
    method: str


# -- surfaces for both tools --------------------------------------------------------------------------------


class Spline(NamedTuple):
    """A ruled B-spline: (n, 2, 3) control points, distinct knots, their multiplicities, degree, (n, 2) weights."""

    points: np.ndarray
    knots: list[float]
    repeats: list[int]
    degree: int
    weights: np.ndarray | None = None

    def ours(self) -> Any:
        flat = [k for k, m in zip(self.knots, self.repeats, strict=True) for _ in range(m)]
        weights = None if self.weights is None else self.weights.tolist()
        return fc.RuledSurface.from_nurbs(self.points.tolist(), flat, weights)

    def theirs(self) -> Any:
        import OCP
        from OCP.Geom import Geom_BSplineSurface
        from OCP.gp import gp_Pnt

        arrays = OCP.OCP.collections
        poles = arrays.Array2_gp_Pnt(1, len(self.points), 1, 2)
        weights = arrays.Array2_double(1, len(self.points), 1, 2)
        for i, row in enumerate(self.points):
            for j, p in enumerate(row):
                poles.SetValue(i + 1, j + 1, gp_Pnt(*map(float, p)))
                weights.SetValue(i + 1, j + 1, 1.0 if self.weights is None else float(self.weights[i, j]))
        knots = []
        for values, counts in ((self.knots, self.repeats), ([0.0, 1.0], [2, 2])):
            at, many = arrays.Array1_double(1, len(values)), arrays.Array1_int(1, len(values))
            for i, (k, m) in enumerate(zip(values, counts, strict=True)):
                at.SetValue(i + 1, float(k))
                many.SetValue(i + 1, int(m))
            knots.append((at, many))
        (u, mu), (v, mv) = knots
        return Geom_BSplineSurface(poles, weights, u, v, mu, mv, self.degree, 1)


def strip(rng: np.random.Generator, n: int, along: int) -> Spline:
    """n poles one apart along x or y, heights at random, cubic."""
    points = np.empty((n, 2, 3))
    points[:, :, along] = np.arange(n)[:, None]
    points[:, :, 1 - along] = [-1.0, float(n)]
    points[:, :, 2] = rng.uniform(-0.5, 0.5, (n, 2))
    return Spline(points, [float(k) for k in range(n - 2)], [4, *[1] * (n - 4), 4], 3)


def graze(depth: float) -> tuple[Spline, Spline]:
    """z = 1 - y^2 / 2 and z = 1 - depth + x^2 / 2, moved off the middle: a loop of radius sqrt(2 depth)."""
    a = np.array([[[-1, y + 0.15, z], [1, y + 0.15, z]] for y, z in ((-1, 0.5), (0, 1.5), (1, 0.5))], float)
    b = np.array([[[x - 0.1, -1, z], [x - 0.1, 1, z]] for x, z in ((-1, 0.5), (0, -0.5), (1, 0.5))], float)
    b[:, :, 2] += 1 - depth
    return Spline(a, [-1.0, 1.0], [3, 3], 2), Spline(b, [-1.0, 1.0], [3, 3], 2)


CIRCLE = ("(1-u**2)/(1+u**2)", "2*u/(1+u**2)")


def turned(radii: tuple[str, str], heights: tuple[str, str], at: tuple[str, str, str], axis: int) -> Any:
    """A full cone or cylinder about an axis parallel to x or z, exact."""
    curves = []
    for r, h in zip(radii, heights, strict=True):
        row = [f"{r}*{c}" for c in CIRCLE]
        row.insert(axis, h)
        curves.append("(" + ", ".join(f"{x} + {p}" for x, p in zip(row, at, strict=True)) + ")")
    return fc.RuledSurface(*curves, u=None)


def occ_turned(radii: tuple[str, str], heights: tuple[str, str], at: tuple[str, str, str], axis: int) -> Any:
    """The same as a trimmed elementary surface."""
    from math import atan, cos, pi

    from OCP.Geom import Geom_ConicalSurface, Geom_CylindricalSurface, Geom_RectangularTrimmedSurface
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

    r, h, place = ([float(Fraction(x)) for x in xs] for xs in (radii, heights, at))
    place[axis] += h[0]
    frame = gp_Ax3(gp_Pnt(*place), gp_Dir(*(float(k == axis) for k in range(3))))
    length = h[1] - h[0]
    if r[0] == r[1]:
        return Geom_RectangularTrimmedSurface(Geom_CylindricalSurface(frame, r[0]), 0, 2 * pi, 0, length)
    angle = atan((r[1] - r[0]) / length)
    return Geom_RectangularTrimmedSurface(Geom_ConicalSurface(frame, angle, r[0]), 0, 2 * pi, 0, length / cos(angle))


QUADRICS: dict[str, tuple[Any, Any]] = {
    "cone / cylinder": ((("0", "2"), ("-1", "1"), ("0", "0", "0"), 2),
                        (("1/2", "1/2"), ("-3", "3"), ("0", "1/5", "0"), 0)),
    "equal cylinders": ((("1", "1"), ("-2", "2"), ("0", "0", "0"), 2), (("1", "1"), ("-2", "2"), ("0", "0", "0"), 0)),
    "tangent cylinders": ((("1", "1"), ("-2", "2"), ("0", "0", "0"), 2),
                          (("1/2", "1/2"), ("-3", "3"), ("0", "1/2", "0"), 0)),
    "cone / cone": ((("0", "2"), ("-1", "1"), ("0", "0", "0"), 2), (("0", "2"), ("-2", "2"), ("0", "1/5", "0"), 0)),
}  # fmt: skip


def hyperboloids() -> tuple[Spline, Spline]:
    """Halves of two hyperboloids of one sheet whose axes cross, as rational quadratic strips."""
    circle = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0]], float)
    weights = np.array([1, 0.5**0.5, 1, 0.5**0.5, 1])
    low, high = circle, np.roll(circle, 1, axis=1) * [-1, 1]
    a = np.stack([np.column_stack((low, np.full(5, -1.0))), np.column_stack((high, np.full(5, 1.0)))], axis=1)
    b = a[:, :, [2, 1, 0]] * 0.8 + [0.1, 0.05, 0.2]
    both = np.column_stack((weights, weights))
    return Spline(a, [0.0, 1.0, 2.0], [3, 2, 3], 2, both), Spline(b, [0.0, 1.0, 2.0], [3, 2, 3], 2, both)


def scenes(quick: bool) -> list[Scene]:
    found = []
    for name, pair in QUADRICS.items():
        for method in ("algebraic", "certified"):
            found.append(Scene(f"{name} ({method})", lambda pair=pair: tuple(turned(*x) for x in pair),
                               tuple(occ_turned(*x) for x in pair), method))  # fmt: skip
    splines = {"hyperboloids": hyperboloids()}
    for n in (4, 8, 16, 30):
        for seed in range(1, 2 if quick else 4):
            rng = np.random.default_rng(seed)
            splines[f"strips of {n} poles, seed {seed}"] = strip(rng, n, 0), strip(rng, n, 1)
    for depth in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        splines[f"loop of depth {depth:g}"] = graze(depth)
    splines["miss by 1e-6"] = graze(-1e-6)
    for name, pair in splines.items():
        found.append(Scene(name, lambda pair=pair: tuple(x.ours() for x in pair),
                           tuple(x.theirs() for x in pair), "certified"))  # fmt: skip
    return found


# -- what the curves are worth ------------------------------------------------------------------------------


def off_surfaces(curve: Any, most: int = 60) -> float:
    """The largest distance of some of its points from P(u, s) and Q(v, t), both evaluated exactly."""
    worst = 0.0
    for branch in curve.branches:
        step = max(1, len(branch.points) * len(curve.branches) // most)
        for point, (u, v, s, t) in zip(branch.points[::step], branch.parameters[::step], strict=True):
            for surface, x, r in ((curve.a, u, s), (curve.b, v, t)):
                worst = max(worst, float(np.abs(exact_point(surface, x, r) - point).max()))
    return worst


def exact_point(surface: Any, u: float, r: float) -> np.ndarray:
    """P(u, s) in rational arithmetic."""
    piece = next(p for p in surface.pieces if p.u is None or p.u[0] <= Fraction(u) <= p.u[1])
    ends = []
    for curve in (piece.first, piece.second):
        x, y, z, w = (sum(Fraction(int(c)) * Fraction(u) ** k for k, c in enumerate(p.coeffs()))
                      for p in curve.components)  # fmt: skip
        ends.append([x / w, y / w, z / w])
    return np.array([float((1 - Fraction(r)) * a + Fraction(r) * b) for a, b in zip(*ends, strict=True)])


def missed(curve: Any, rng: np.random.Generator, rulings: int = 40, cuts: int = 2000) -> tuple[int, int]:
    """(seen, not on the curve): meetings of random rulings with the other surface, found by sign changes."""
    seen = absent = 0
    for mine, other in ((curve.a, curve.b), (curve.b, curve.a)):
        pieces = other.pieces
        for _ in range(rulings):
            piece = mine.pieces[rng.integers(len(mine.pieces))]
            lo, hi = (-4.0, 4.0) if piece.u is None else map(float, piece.u)
            ends = piece.points(rng.uniform(lo, hi), [0.0, 1.0])
            for q in pieces:
                v = np.linspace(*((-4.0, 4.0) if q.u is None else map(float, q.u)), max(50, cuts // len(pieces)))
                a, b = q.points(v, 0.0), q.points(v, 1.0)
                along, across = ends[1] - ends[0], b - a
                volume = np.einsum("ij,ij->i", a - ends[0], np.cross(along, across))
                for k in np.flatnonzero(volume[:-1] * volume[1:] < 0):
                    w = volume[k] / (volume[k] - volume[k + 1])
                    p, d = a[k] + w * (a[k + 1] - a[k]), across[k] + w * (across[k + 1] - across[k])
                    n = np.cross(along, d)
                    s, t = (np.linalg.det([p - ends[0], x, n]) / (n @ n) for x in (d, along))
                    if not (0.001 < s < 0.999 and 0.001 < t < 0.999):
                        continue
                    seen += 1
                    point, near = ends[0] + s * along, 2e-2
                    absent += all(np.abs(x.points - point).max(1).min() > near for x in curve.branches)
    return seen, absent


def occ_off(lines: list[Any], surfaces: tuple[Any, Any], most: int = 60) -> float:
    """The largest distance of some points of OpenCASCADE's curves from its surfaces, by its own projection."""
    from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf

    worst = 0.0
    for line in lines:
        for t in np.linspace(line.FirstParameter(), line.LastParameter(), max(3, most // len(lines))):
            point = line.Value(float(t))
            for surface in surfaces:
                found = GeomAPI_ProjectPointOnSurf(point, surface)
                if found.NbPoints():
                    worst = max(worst, found.LowerDistance())
    return worst


# -- measuring ----------------------------------------------------------------------------------------------


def measure(scene: Scene, repeats: int, tolerance: float) -> dict[str, Any]:
    from OCP.GeomAPI import GeomAPI_IntSS

    ours, theirs = [], []
    fc.intersection_curve(*scene.make(), method=scene.method, tolerance=tolerance)  # compiled before
    for _ in range(repeats):
        pair = scene.make()
        begin = time.perf_counter()
        curve = fc.intersection_curve(*pair, method=scene.method, tolerance=tolerance)
        ours.append(time.perf_counter() - begin)
        begin = time.perf_counter()
        other = GeomAPI_IntSS(*scene.other, tolerance)
        theirs.append(time.perf_counter() - begin)
    lines = [other.Line(k + 1) for k in range(other.NbLines())]
    seen, absent = missed(curve, np.random.default_rng(5))
    return {
        "name": scene.name, "ours": statistics.median(ours), "theirs": statistics.median(theirs),
        "ratio": statistics.median(b / a for a, b in zip(ours, theirs, strict=True)),
        "branches": len(curve.branches), "open": len(curve.open_places), "lines": len(lines),
        "points": sum(len(b.points) for b in curve.branches), "off": off_surfaces(curve),
        "occ_off": occ_off(lines, scene.other), "seen": seen, "absent": absent,
    }  # fmt: skip


HEAD = """# Intersection curves of ruled surfaces

`python benchmarks/ruled.py` on {machine}, Python {python}; medians of {repeats} paired repeats, in ms.
OpenCASCADE is `GeomAPI_IntSS`; both are asked for a tolerance of {tolerance:g}. The time of firstcontact has the
preparation of fresh surfaces in it.
*off*: largest distance of curve points from the surfaces, for firstcontact against exact arithmetic.
*missed*: of that many meetings of random rulings with the other surface, found by sign changes, those off the curve.
Largest memory of the whole run, OpenCASCADE and the checks in it: {memory:.0f} MB.

| scene | firstcontact | OpenCASCADE | ratio | branches | undecided | its curves | points | off | its off | missed |
|---|---|---|---|---|---|---|---|---|---|---|
"""

EXAMPLES_HEAD = """
## The examples of Chen, Shen & Yuan 2011

In a process of their own ([ruled_examples](ruled_examples.py)), medians in ms of fresh surfaces each time. Its largest
memory, all imports counted: {memory:.0f} MB (bar 400).

| query | time | bar | | answer |
|---|---|---|---|---|
"""


def met(row: dict[str, Any]) -> str:
    return "" if row["bar"] is None else "met" if row["ms"] <= row["bar"] else "missed"


def examples() -> str:
    """The table of the paper's examples."""
    script = Path(__file__).with_name("ruled_examples.py")
    found = json.loads(subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout)
    rows = [
        f"| {row['name']} | {row['ms']:.1f} | {row['bar'] or ''} | {met(row)} | {row['answer']} |"
        for row in found["rows"]
    ]
    return EXAMPLES_HEAD.format(memory=found["memory"]) + "\n".join(rows) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repeats and strips")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "RULED.md")
    given = parser.parse_args()
    repeats = 3 if given.quick else 9
    table = examples()  # first: a child's largest memory starts with its parent's
    rows = []
    for scene in scenes(given.quick):
        row = measure(scene, repeats, given.tolerance)
        rows.append(
            "| {name} | {a:.2f} | {b:.1f} | {ratio:.1f} | {branches} | {open} | {lines} | {points} | {off:.0e} "
            "| {occ_off:.0e} | {absent} of {seen} |".format(a=1e3 * row["ours"], b=1e3 * row["theirs"], **row)
        )
        print(rows[-1], flush=True)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    head = HEAD.format(machine=platform.machine(), python=platform.python_version(), repeats=repeats,
                       tolerance=given.tolerance, memory=memory)  # fmt: skip
    given.output.write_text(head + "\n".join(rows) + "\n" + table)


if __name__ == "__main__":
    main()
