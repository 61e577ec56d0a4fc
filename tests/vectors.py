"""The known answers of `data/polyhedra_vectors.json` as records.

Per case: bodies `a` (moving) and `b` (at rest) with v(ertices), e(dges), f(aces); one motion; the answer.
Coordinates are ints, doubles or fractions.  All bodies are surfaces: no interior counts.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

DATA = Path(__file__).parent / "data" / "polyhedra_vectors.json"


@dataclass(frozen=True)
class Body:
    v: list  # vertices, exact
    e: list  # edges
    f: list  # triangles


@dataclass(frozen=True)
class Vector:
    id: str
    a: Body
    b: Body
    translation: dict | None  # {"v": ..., "T": end of the span, else unbounded}
    rotation: dict | None  # {"point", "axis", "angle": "full" or a Fraction of radians}
    expected: dict

    @property
    def exact_in_floats(self) -> bool:
        return all(Fraction(float(x)) == x for body in (self.a, self.b) for p in body.v for x in p)

    def total_angle(self) -> dict:
        """Keyword of the rotation: one turn, or so many radians."""
        assert self.rotation is not None
        angle = self.rotation["angle"]
        return {"turns": 1} if angle == "full" else {"radians": Fraction(angle)}


def number(x) -> int | float | Fraction:
    return Fraction(x) if isinstance(x, str) else x


def _body(raw: dict) -> Body:
    return Body([[number(x) for x in p] for p in raw["v"]], raw["e"], raw["f"])


def load() -> list[Vector]:
    cases = json.loads(DATA.read_text())["cases"]
    return [
        Vector(c["id"], _body(c["a"]), _body(c["b"]), c.get("translation"), c.get("rotation"), c["expected"])
        for c in cases
    ]


VECTORS = load()
