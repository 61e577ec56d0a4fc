"""The questions of `paired.py`: table, cell, and what makes `ask(repeat)` of a cell, in the words of any commit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

import firstcontact as fc
from curved import PAIRS, SHAPES, motions
from curved_peers.parts import SCENES, Ours
from firstcontact.examples.choi import example_7, example_8
from growth_scenes import FAMILIES, Family
from ruled import scenes as curves
from ruled_examples import QUERIES
from scenes import scenes as of_meshes

Ask = Callable[[int], Any]
Cell = tuple[str, str, Callable[[], Ask]]
SIZES = 1_000, 10_000
GROWN = 1_000
JITTER = 1e-3


def cells() -> Iterator[Cell]:
    yield from _meshes()
    yield from _solids()
    yield from _ruled()
    for family in FAMILIES:
        yield "growth", f"{family.name}, {family.motion}, {GROWN}", partial(_grown, family)


def _meshes() -> Iterator[Cell]:
    for n in SIZES:
        for turned in (False, True):
            for name in of_meshes(n, turned):
                yield "meshes", f"{name}, {n}{', turned' if turned else ''}", partial(_mesh, n, turned, name)


def _mesh(n: int, turned: bool, name: str) -> Ask:
    scene = of_meshes(n, turned)[name]
    a, b = fc.Polyhedron(scene.va, scene.fa), fc.Polyhedron(scene.vb, scene.fb)

    def ask(repeat: int) -> Any:
        moved = scene.jittered(repeat)
        if scene.kind == "translation":
            return fc.first_contact(a.moving(fc.Translation(moved.vector)), b)
        return fc.first_contact(a.moving(fc.Rotation(moved.axis, moved.point, radians=moved.radians)), b)

    return ask


def _solids() -> Iterator[Cell]:
    for kind in ("translation", "screw"):
        for pair in PAIRS:
            yield "solids", f"{' and '.join(pair)}, {kind}", partial(_primitives, pair, kind)
    for row in SCENES:
        yield "solids", row[0], partial(_parts, row)
    for name, make in (("Example 7", example_7), ("Example 8", example_8)):
        for method in ("auto", "algebraic"):
            yield "solids", f"{name}, {method}", partial(_example, make, method)


def _primitives(pair: tuple[str, str], kind: str) -> Ask:
    a, b = (SHAPES[name][0]() for name in pair)
    ways = motions(kind, 8)

    def ask(repeat: int) -> Any:
        path, place = ways[repeat % len(ways)]
        return fc.first_contact(a.moving(path.ours), b.translated(place.tolist()))

    return ask


def _parts(row: tuple[Any, ...]) -> Ask:
    _, make_a, make_b, path, start = row
    moving, resting = make_a(Ours()).moving(path.ours), make_b(Ours()).translated((-np.array(start, float)).tolist())
    return lambda repeat: fc.first_contact(moving, resting)


def _example(make: Callable[[], tuple[Any, Any]], method: str) -> Ask:
    a, b = make()
    return lambda repeat: fc.first_contact(a, b, method=method)


def _ruled() -> Iterator[Cell]:
    for name, make, question, _ in QUERIES:
        yield "ruled surfaces", name, lambda make=make, question=question: lambda repeat: question(*make())
    for scene in curves(quick=True):
        yield "ruled surfaces", f"curve, {scene.name}", partial(_curve, scene)


def _curve(scene: Any) -> Ask:
    return lambda repeat: fc.intersection_curve(*scene.make(), method=scene.method)


def _grown(family: Family) -> Ask:
    encounter = family.make(GROWN)
    return lambda repeat: fc.first_contact(encounter.a.moving(encounter.motion), encounter.b)
