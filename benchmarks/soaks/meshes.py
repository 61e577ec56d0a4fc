"""Polyhedra."""

from __future__ import annotations

from random import Random
from typing import Any

from .scene import Kind, Question, Scene


def _boxes(rng: Random) -> Scene:
    gap = rng.randint(1, 8)
    source = f"a = fc.examples.box((2, 2, 2)).moving(fc.Translation((0, 0, 8)))\nb = fc.examples.box((2, 2, 2)).translated((0, 0, {gap} + 2))\nspan = None\n"

    def judge(hit: Any) -> str | None:
        return None if hit.time == gap / 8 else f"time {hit.time} instead of {gap / 8}"

    return Scene(source, "translation", (Question("fc.first_contact(a, b, span)", judge),))


KINDS = (Kind("meshes/boxes", "mesh, mesh", _boxes, "nothing", "all"),)
