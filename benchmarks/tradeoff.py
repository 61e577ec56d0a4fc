"""The on-line problem of Schoemer & Thiel 1995: work of one query, against edges at rest and against storage.

    python benchmarks/tradeoff.py [--sizes 500,1e3,2e3,4e3,8e3,16e3] [--n 4096] [--cells 1,2,4,..,256]

Woven rods; a query asks the levels of engine "composed" whether one moving rod meets any of n resting ones during a
short motion.  Theorem 3 promises n / m^(1/d) for storage m from n on, in d = 5 dimensions (4 under translation, Theorem
6).  Here storage is bought by replicating the upper levels: the space of queries is cut into cells, each the hull of
queries that lie together, with levels of its own over the edges for which no conjunct fails in all of the cell.
Writes TRADEOFF.md and docs/tradeoff.png.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact import examples
from firstcontact.contact.polyhedra.problems.composed_problem import (
    Composed,
    Frame,
    rotation_groups,
    translation_groups,
)
from firstcontact.search.lifted.lifted_elements import Elements, edges_of
from firstcontact.search.trees.frame import frame_of, view_in
from firstcontact.search.trees.state import BEST, CANDIDATES, DONE, STACK, TESTS, VISITS, WalkState
from firstcontact.search.trees.tree import SIDE

HERE = Path(__file__).resolve().parent
QUERIES, HULL_QUERIES = 512, 4096
"""Queries whose mean is told; those that span the cells of the trade-off, where their mean is told."""
SHORT = 1.0
"""A query lasts so many times 1 / n: it is met by about as many rods, whatever n is."""


class Scene:
    """n resting and so many moving rods."""

    def __init__(self, n: int, turning: bool, queries: int) -> None:
        scene = examples.woven_rods(max(n, queries), turning=turning)
        frame = frame_of((0.0, 0.0, 1.0))
        self.a, self.b = view_in(scene.a, frame), view_in(scene.b, frame)
        self.moving, self.resting = _first(edges_of(self.a), queries), _first(edges_of(self.b), n)
        self.turning, self.last = turning, SHORT / n
        origin = np.zeros(3) if turning else self.b.xyz.reshape(-1, 3).mean(axis=0)
        self.frame = Frame(origin, 4.0, 0.0, 0.0)
        v = np.array([0.0, 0.0, 1.0])
        self.motion = np.array([*v, np.inf, np.inf, 1.0, *v])

    def groups(self, moving: Elements, resting: Elements) -> list[Any]:
        if self.turning:
            return rotation_groups(moving, resting, self.frame, lambda arc: self.last / 2.0)
        return translation_groups(moving, resting, self.frame, self.motion[6:9], lambda: self.last)

    def work(self, moving: Elements, resting: Elements) -> tuple[int, int]:
        """(node visits and pair tests of all queries, edges stored by all levels)."""
        state = WalkState()
        state.start(0.0, 0.0, self.last, self.last, want_all=True)
        # pair tests are those of a translation either way: how many there are does not depend on what they say
        search = Composed(
            self.groups(moving, resting), (self.motion, self.a.xyz, self.b.xyz, 0.0, 0.0, 1 << SIDE)
        )
        state.integers[STACK] = 1
        while search.advance(state, 0, 1 << 60) != DONE:
            state.integers[CANDIDATES] = 0
        assert state.floats[BEST] == self.last
        stored = sum(int(group.resting.levels.counts[1]) for group in search.groups)
        return int(state.integers[VISITS] + state.integers[TESTS]), stored


def _first(elements: Elements, count: int) -> Elements:
    return Elements(elements.parts[:count], elements.corners[:count])


def _chosen(elements: Elements, rows: np.ndarray) -> Elements:
    return Elements(elements.parts[rows], elements.corners[rows])


def growth(sizes: list[int]) -> list[tuple[str, int, float, int]]:
    """(motion, n, work of a query, edges stored)."""
    rows = []
    for turning in (False, True):
        for n in sizes:
            scene = Scene(n, turning, QUERIES)
            work, stored = scene.work(scene.moving, scene.resting)
            rows.append(("rotation" if turning else "translation", n, work / QUERIES, stored))
            print(*rows[-1], flush=True)
    return rows


def storage(n: int, counts: list[int]) -> list[tuple[int, int, float]]:
    """(cells, storage m, work of a query) under translation; m counts the edges of all cells."""
    scene = Scene(n, False, HULL_QUERIES)
    (group,) = scene.groups(scene.moving, scene.resting)
    conjunctions = group.conjunctions(slice(0, HULL_QUERIES), 0)
    group.resting.begin(conjunctions)
    forms = group.resting.questions(conjunctions, group.parts).forms
    rows = []
    for cells in counts:
        m, work = 0, 0
        for queries in _cells(forms, cells):
            open_ = np.flatnonzero(_left_open(forms[queries], group.resting, conjunctions))
            m += len(open_)
            if len(open_):
                work += scene.work(_chosen(scene.moving, queries), _chosen(scene.resting, open_))[0]
        rows.append((cells, m, work / HULL_QUERIES + np.log2(cells)))
        print(*rows[-1], flush=True)
    return rows


def _cells(forms: np.ndarray, count: int) -> list[np.ndarray]:
    """The queries in so many cells, halved across the direction in which their forms vary most."""
    flat = forms.reshape(len(forms), -1)
    cells = [np.arange(len(forms))]
    while len(cells) < count:
        halves = []
        for cell in cells:
            centred = flat[cell] - flat[cell].mean(axis=0)
            along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
            order = cell[np.argsort(along)]
            halves += [order[: len(order) // 2], order[len(order) // 2 :]]
        cells = halves
    return cells


def _left_open(forms: np.ndarray, resting: Any, conjunctions: Any) -> np.ndarray:
    """Which edges may satisfy a conjunction of some query of the hull: conjunct by conjunct, at its corners."""
    number: dict[int, int] = {}
    for conjunction in conjunctions:
        for conjunct in conjunction:
            number.setdefault(id(conjunct.form), len(number))
    found = np.zeros(resting.count, bool)
    for conjunction in conjunctions:
        holds = np.ones(resting.count, bool)
        for form, way, _ in conjunction:
            j, vectors = number[id(form)], resting.vectors[resting.names.index(form.feature)]
            holds &= (way * (forms[:, j] @ vectors.T)).max(axis=0) >= -1e-9
        found |= holds
    return found


def slope(x: Any, y: Any) -> float:
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="500,1e3,2e3,4e3,8e3,16e3")
    parser.add_argument("--n", default="4096", help="resting rods of the trade-off")
    parser.add_argument("--cells", default="1,2,4,8,16,32,64,128,256", help="powers of two, HULL_QUERIES / 8 at most")
    options = parser.parse_args()
    online = growth([int(float(x)) for x in options.sizes.split(",")])
    traded = storage(int(float(options.n)), [int(x) for x in options.cells.split(",")])
    write(online, traded, int(float(options.n)))
    draw(online, traded, int(float(options.n)))


def write(online: Any, traded: Any, n: int) -> None:
    lines = ["# One query of the on-line problem", "", "Made by `python benchmarks/tradeoff.py`.  Woven rods.", ""]
    lines += ["| motion | n | node visits and pair tests of a query | edges stored by all levels |"]
    lines += ["|---|---|---|---|"]
    lines += [f"| {motion} | {m} | {work:.0f} | {stored} |" for motion, m, work, stored in online]
    lines += ["", f"Storage against work, n = {n}, translation:", "", "| cells | storage m | work of a query |"]
    lines += ["|---|---|---|", *(f"| {cells} | {m} | {work:.0f} |" for cells, m, work in traded), ""]
    (HERE / "TRADEOFF.md").write_text("\n".join(lines))


def draw(online: Any, traded: Any, n: int) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 4.2))
    for motion in ("translation", "rotation"):
        x, y = zip(*((m, work) for of, m, work, _ in online if of == motion), strict=True)
        left.loglog(x, y, "o-", label=f"{motion}, slope {slope(x, y):.2f}")
    left.set(xlabel="resting edges n", ylabel="node visits and pair tests of a query", title="one query")
    x, y = zip(*((m, work) for _, m, work in traded), strict=True)
    right.loglog(x, y, "o-", label=f"measured, slope {slope(x, y):.2f}")
    for d in (4, 5):
        right.loglog(x, y[0] * (np.array(x) / x[0]) ** (-1.0 / d), "--", label=f"m^(-1/{d})")
    right.set(xlabel="storage m (edges)", title=f"storage against work, n = {n}, translation")
    for axes in (left, right):
        axes.legend()
        axes.grid(True, which="both", alpha=0.3)
    figure.tight_layout()
    figure.savefig(HERE.parent / "docs" / "tradeoff.png", dpi=110)


if __name__ == "__main__":
    main()
