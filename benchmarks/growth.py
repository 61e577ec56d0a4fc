"""Growth of the work with the number of rods or facets on adversarial scenes.

Writes GROWTH.md, growth.csv, pictures, and the exponents into README.md and docs/growth.md.

    python benchmarks/growth.py [--sizes 100,300,1e3,3e3,1e4,3e4,1e5] [--limit 5] [--only FAMILIES] [--tools TOOLS]
                                [--add] [--redraw]

Every series has a process of its own that is stopped when a run takes --limit seconds; its larger sizes are left out
then, and sizes that would certainly take longer.  --only and --tools are regular expressions; --add keeps the other
rows of growth.csv; --redraw makes table and pictures anew from it.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import re
import sys
from dataclasses import dataclass, fields
from math import log
from pathlib import Path
from time import perf_counter
from typing import Any

from firstcontact import Status, first_contact
from firstcontact.query import ENGINES
from growth_report import draw, read_csv, write_csv, write_exponents, write_markdown
from growth_scenes import CUTS, FAMILIES, Family, cut, peer_scene

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PICTURES = ROOT / "docs"
PEERS = ("coal", "ipctk")
WARM = 24
"""Rods of an untimed run that compiles whatever a series needs."""
REPEATS, ENOUGH = 3, 1.0
"""Timed queries, fewer when they have taken so many seconds; the least counts.  After a first one that took longer
there is none: its own time, less the making of the bodies, stands for it."""
CERTAINLY = 1.5
"""A run expected to take so many times the limit is not begun."""


@dataclass
class Run:
    """One family, motion, tool and n.  query_s: trees ready; one_shot_s: from arrays to the answer; seconds."""

    family: str
    motion: str
    tool: str
    n: int
    node_visits: int = 0
    pair_tests: int = 0
    exact_evaluations: int = 0
    query_s: float = 0.0
    one_shot_s: float = 0.0
    status: str = ""
    time: float = float("nan")
    note: str = ""

    @property
    def work(self) -> int:
        return self.node_visits + self.pair_tests


def main() -> None:
    options = _options()
    table = options.out / "growth.csv"
    runs = read_csv(table, Run) if options.redraw or options.add else []
    if not options.redraw:
        for family in FAMILIES:
            label = f"{family.name}, {family.motion}"
            if re.search(options.only, label):
                new = [run for tool in tools_for(family, options) for run in series(family, tool, options)]
                redone = {(run.family, run.motion, run.tool) for run in new}
                runs = [run for run in runs if (run.family, run.motion, run.tool) not in redone] + new
                write_csv(runs, table, [f.name for f in fields(Run)])
    write_markdown(runs, options.out / "GROWTH.md")
    if options.out == HERE:
        for page in (ROOT / "README.md", PICTURES / "growth.md"):
            write_exponents(runs, page)
    draw(runs, options.pictures)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="100,300,1e3,3e3,1e4,3e4,1e5", help="rods or facets a body")
    parser.add_argument("--limit", type=float, default=5.0, help="seconds for a run")
    parser.add_argument("--only", default="", help='regular expression; families as in "woven rods, rotation"')
    parser.add_argument("--tools", default="", help="regular expression; engines, cut boxes, other tools")
    parser.add_argument("--add", action="store_true", help="keep the other rows of growth.csv")
    parser.add_argument("--redraw", action="store_true", help="only table and pictures, from growth.csv")
    parser.add_argument("--out", type=Path, default=HERE, help="folder for GROWTH.md and growth.csv")
    parser.add_argument("--pictures", type=Path, default=PICTURES, help="folder for the pictures")
    options = parser.parse_args()
    options.sizes = [int(float(size)) for size in options.sizes.split(",")]
    return options


def tools_for(family: Family, options: argparse.Namespace) -> list[str]:
    """Engines; for rods also boxes over cut rods; for solids the other tools."""
    found = list(ENGINES)
    if family.kind == "rods":
        found.remove("sweep")  # it is for vertices against facets
    if family.kind == "rods":
        found += [f"boxes, cut in {k}" for k in CUTS if k > 1]
    if family.kind == "solids":
        found += PEERS
    return [tool for tool in found if re.search(options.tools, tool)]


def series(family: Family, tool: str, options: argparse.Namespace) -> list[Run]:
    """Runs at rising n, up to the first that is stopped or fails."""
    runs: list[Run] = []
    limited = Limited(family, tool)
    try:
        for n in options.sizes:
            run = Run(family.name, family.motion, tool, n)
            seconds = expected(runs, n)
            if seconds > CERTAINLY * options.limit:
                run.note = f"left out, about {seconds:.2g} s expected"
            else:
                for key, value in limited.run(n, options.limit).items():
                    setattr(run, key, value)
            runs.append(run)
            print(_line(run), file=sys.stderr, flush=True)
            if run.note:
                break
    finally:
        limited.close()
    return runs


def expected(runs: list[Run], n: int) -> float:
    """Seconds that a run at n will take if the series goes on growing as it did last, and at least with n."""
    if not runs:
        return 0.0
    last, grows = runs[-1], 1.0
    if len(runs) > 1:
        before = runs[-2]
        grows = max(1.0, log(last.one_shot_s / before.one_shot_s) / log(last.n / before.n))
    return last.one_shot_s * (n / last.n) ** min(grows, 2.0)


def _line(run: Run) -> str:
    said = run.note or f"{run.node_visits} visits, {run.pair_tests} pairs, {run.query_s:.3g} s, {run.one_shot_s:.3g} s"
    return f"{run.family}, {run.motion}, {run.tool}, n = {run.n}: {run.status} {said}"


class Limited:
    """A process that runs one series and is stopped when a run takes too long."""

    def __init__(self, family: Family, tool: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(FAMILIES.index(family), tool, theirs), daemon=True)
        self._process.start()
        theirs.close()
        self._ready: dict[str, Any] = self._receive(300.0)  # compiles

    def run(self, n: int, limit: float) -> dict[str, Any]:
        """Fields of a Run; a note tells that it was stopped or failed."""
        if "note" in self._ready:
            return self._ready
        self._pipe.send(n)
        self._receive(60.0 + limit)  # the encounter is made: untimed
        return self._receive(limit)

    def close(self) -> None:
        self._process.kill()
        self._process.join()

    def _receive(self, limit: float) -> dict[str, Any]:
        if not self._pipe.poll(limit):
            self._process.kill()
            return {"note": f"> {limit:g} s"}
        try:
            return self._pipe.recv()
        except EOFError:
            return {"note": "crashed"}


def _serve(family: int, tool: str, pipe: Any) -> None:
    ask = _asker(FAMILIES[family], tool)
    try:
        for warmed in ("boxes", "lifted") if tool == "auto" else () if tool in PEERS else (tool,):
            _asker(FAMILIES[family], warmed)(FAMILIES[family].make(WARM), lambda: None)
        pipe.send({})
    except Exception as error:  # said in the table
        pipe.send({"note": f"{type(error).__name__}: {error}"})
    while True:
        try:
            n = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(ask(FAMILIES[family].make(n), lambda: pipe.send({})))
        except Exception as error:
            pipe.send({"note": f"{type(error).__name__}: {error}"})


def _asker(family: Family, tool: str) -> Any:
    if tool in PEERS:
        return lambda encounter, ready: _peer(family, tool, encounter, ready)
    pieces = re.match(r"boxes, cut in (\d+)", tool)
    if pieces:
        return lambda encounter, ready: _engine("boxes", cut(encounter, int(pieces[1])), ready)
    return lambda encounter, ready: _engine(tool, encounter, ready)


def _engine(engine: str, encounter: Any, ready: Any) -> dict[str, Any]:
    """One first contact from arrays, then queries of the same bodies, whose trees are ready."""
    arrays = [(body.vertices.copy(), body.triangles.copy(), body.edges.copy()) for body in (encounter.a, encounter.b)]
    solid = encounter.a.solid, encounter.b.solid
    ready()
    gc.disable()
    start = perf_counter()
    a, b = (_body(*array, owns) for array, owns in zip(arrays, solid, strict=True))
    moving = a.moving(encounter.motion)
    hit = first_contact(moving, b, engine=engine)
    one_shot = perf_counter() - start
    queries = [hit.stats.seconds]
    while len(queries) <= REPEATS and sum(queries) < ENOUGH:
        start = perf_counter()
        first_contact(moving, b, engine=engine)
        queries.append(perf_counter() - start)
    gc.enable()
    stats = hit.stats
    return {
        "node_visits": int(stats.node_visits),
        "pair_tests": int(stats.pair_tests),
        "exact_evaluations": int(stats.exact_evaluations),
        "query_s": min(queries),
        "one_shot_s": one_shot,
        "status": hit.status.name,
        "time": float("nan") if hit.time is None else hit.time,
        "note": f"undecided: {hit.reason}" if hit.status is Status.UNDECIDED else "",
    }


def _body(vertices: Any, triangles: Any, edges: Any, solid: bool) -> Any:
    from firstcontact import Polyhedron

    return Polyhedron(vertices, triangles, edges=edges if len(triangles) == 0 and len(edges) else None, solid=solid)


def _peer(family: Family, tool: str, encounter: Any, ready: Any) -> dict[str, Any]:
    from peers import make_adapter

    adapter, scene = make_adapter(tool), peer_scene(family, encounter)
    ready()
    start = perf_counter()
    state = adapter.prepare(scene)
    prepared = perf_counter()
    answer = adapter.query(state, scene)
    end = perf_counter()
    time = float("nan") if answer.time is None else float(answer.time)
    return {"query_s": end - prepared, "one_shot_s": end - start, "status": answer.status, "time": time}


if __name__ == "__main__":
    main()
