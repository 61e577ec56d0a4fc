"""The known answers of `data/quadric_vectors.json` as bodies and motions.

Times and points come from distance search and 50-digit Newton iterations or from closed forms, not from
discriminants; misses were sampled.  All numbers are exact rationals in strings.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction as F
from pathlib import Path

import firstcontact as fc

DATA = Path(__file__).parent / "data" / "quadric_vectors.json"


@dataclass(frozen=True)
class Vector:
    name: str
    case: str
    a: fc.CompositeQuadric
    b: fc.CompositeQuadric
    motion_a: object
    motion_b: object
    contact: bool
    time: F | None
    points: list[list[float]]
    grazing: bool
    kind: str

    @property
    def bodies(self):
        return self.a.moving(self.motion_a), self.b.moving(self.motion_b)

    @property
    def is_rational(self) -> bool:
        return all(isinstance(m, fc.RationalMotion) for m in (self.motion_a, self.motion_b))


def quaternion_matrix(q) -> list[list[F]]:
    w, x, y, z = map(F, q)
    n = w * w + x * x + y * y + z * z
    return [
        [(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
        [2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n],
        [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n],
    ]


def _cylinder(v):
    z0, z1 = map(F, v["z"])
    return fc.cylinder([F(x) for x in v["radii"]], z1 - z0).translated((0, 0, (z0 + z1) / 2))


def _frustum(v):
    r0, r1, h = F(v["r0"]), F(v["r1"]), F(v["h"])
    return fc.frustum(r0, r1, h) if r1 else fc.cone(r0, h)


def _polytope(v):
    first, *rest = (fc.half_space([F(x) for x in n[:3]], F(n[3])) for n in v["faces"])
    for half_space in rest:
        first &= half_space
    return first


def _quadric(v):
    def entry(key: str) -> F:
        return F(v.get(key, 0)) / (1 if key in ("xx", "yy", "zz", "1") else 2)

    keys = [["xx", "xy", "xz", "x"], ["xy", "yy", "yz", "y"], ["xz", "yz", "zz", "z"], ["x", "y", "z", "1"]]
    return fc.quadric([[entry(key) for key in row] for row in keys])


SHAPES = {
    "box": lambda v: fc.box([2 * F(x) for x in v["half"]]),
    "sphere": lambda v: fc.sphere(F(v["r"])),
    "ellipsoid": lambda v: fc.ellipsoid([F(x) for x in v["radii"]]),
    "cylinder": _cylinder,
    "frustum": _frustum,
    "paraboloid": lambda v: fc.paraboloid([F(v["a"]), F(v["b"])], F(v["h"])),
    "hyperboloid2": lambda v: fc.hyperboloid([F(v["a"]), F(v["b"]), F(v["c"])], F(v["h"]), sheets=2),
    "poly": _polytope,
    "quadric": _quadric,
    "plane": lambda v: fc.half_space([F(x) for x in v[:3]], -F(v[3])),
}


def solid(raw) -> fc.CompositeQuadric:
    (key,) = (k for k in raw if k != "at")
    value = raw[key]
    if key in SHAPES:
        made = SHAPES[key](value)
    else:
        made, *others = map(solid, value)
        for other in others:
            made = made | other if key == "union" else made & other if key == "and" else made - other
    if "at" not in raw:
        return made
    rows = quaternion_matrix(raw["at"]["quat"])
    return made.transformed([[*row, F(t)] for row, t in zip(rows, raw["at"]["trans"], strict=True)] + [[0, 0, 0, 1]])


def motion(raw):
    if "poly" in raw:
        entries = raw["poly"]
        degree = max(len(e) for row in entries for e in row)
        return fc.RationalMotion(
            [[[F(e[k]) if k < len(e) else F(0) for e in row] for row in entries] for k in range(degree)]
        )
    return raw["screw"]


def load() -> list[Vector]:
    return [
        Vector(
            c["name"], c["case"], solid(c["a"]).named("a"), solid(c["b"]).named("b"),
            motion(c["motion_a"]), motion(c["motion_b"]), c["expect"]["contact"],
            F(c["expect"]["t"]) if c["expect"].get("t") is not None else None,
            [[float(x) for x in p] for p in c["expect"].get("points", [])],
            c["expect"].get("grazing", False), c["expect"].get("kind", ""),
        )
        for c in json.loads(DATA.read_text())["cases"]
    ]  # fmt: skip


VECTORS = load()
RATIONAL = [v for v in VECTORS if v.is_rational]
