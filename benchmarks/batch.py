"""How much quicker many questions are answered at once: writes BATCH.md.

    python benchmarks/batch.py [--rows 100000] [--assembly 300]

Translations of one body before another, `first_contacts` against a loop of `first_contact` and one of coal's
conservative advancement at 1e-9 (peers/coal_adapter.py), in one process, bodies made anew for each; seconds of one
core, but for the row of all cores, which is of the clock.  Statuses, times and elements of the loop are compared with
those of the table.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
import firstcontact as fc  # noqa: E402

TARGET = HERE / "BATCH.md"
SEED = 20
LOOP, PEER = 3000, 300
"""Questions that are asked one after the other, of us and of coal."""
ROUNDS = 25
"""Of one core and of all by turns: the best of each counts, as a tenth of a second of either is soon disturbed."""
BARS = {12: 30.0, 1000: 10.0, 10000: 3.0}
PEER_BAR, CORES_BAR, MEMORY_BAR, ASSEMBLY_BAR = 10.0, 1.8, 1000.0, 5.0
HEAD = """# Many questions at once

By `python benchmarks/batch.py`: {rows} translations of one body before another, {cores} cores, seed {seed}. Vectors are
normal, of twice the bodies' size in each coordinate; the bodies are three sizes apart. Microseconds of one core for a
question; of a loop of single calls, of the table, of coal advancing conservatively to 1e-9.

| triangles | contacts | loop | at once | times | bar | coal | times | bar | cores, times | bar | bytes a row | bar |
|---|---|---|---|---|---|---|---|---|---|---|---|---|
"""


def pair(n: int) -> tuple[Any, Any]:
    if n == 12:
        return fc.examples.box((1, 1, 1)), fc.examples.box((1, 1, 1)).rotated((1, 2, 3), degrees=20).translated(
            (3, 0, 0)
        )
    ball = fc.examples.noisy_sphere(n)
    size = float(np.ptp(ball.vertices[:, 0])) / 2
    return ball, fc.examples.noisy_sphere(n).translated((3 * size, 0, 0))


def seconds(work: Callable[[], Any], clock: Callable[[], float]) -> tuple[float, Any]:
    begin = clock()
    found = work()
    return clock() - begin, found


def measured(n: int, rows: int) -> str:
    rng = np.random.default_rng(SEED)
    a, b = pair(n)
    vectors = rng.normal(size=(rows, 3)) * 2.0 * float(np.ptp(a.vertices[:, 0])) / (2 if n > 12 else 1)
    moving = a.moving(fc.Translations(vectors))
    fc.first_contacts((a.moving(fc.Translations(vectors[:2000])), b))  # loads, and what bodies keep

    some = vectors[:LOOP]
    loop, answers = seconds(
        lambda: [fc.first_contact(a.moving(fc.Translation(v)), b) for v in some.tolist()], time.process_time
    )
    once, table = seconds(lambda: fc.first_contacts((moving, b), workers=1), time.process_time)
    ask = [partial(fc.first_contacts, (moving, b), workers=n) for n in (1, None)]
    by_turns = [[seconds(work, time.perf_counter)[0] for work in ask] for _ in range(ROUNDS if n == 12 else 5)]
    alone, shared = np.min(by_turns, axis=0)
    compare(answers, table)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    kept = fc.first_contacts((moving, b), workers=1)
    peak = (tracemalloc.get_traced_memory()[1] - before) / len(kept)
    tracemalloc.stop()

    loop, once = 1e6 * loop / LOOP, 1e6 * once / rows
    told = [
        str(n),
        f"{(table.status == 'CONTACT').mean():.0%}",
        f"{loop:.0f}",
        f"{once:.1f}",
        *bar(loop / once, BARS[n]),
    ]
    coal = peer(a, b, vectors[:PEER])
    told += ["-", "-", "-"] if coal is None else [f"{coal:.0f}", *bar(coal / once, PEER_BAR)]
    told += [
        *bar(alone / shared, CORES_BAR),
        f"{peak:.0f}",
        f"{MEMORY_BAR:.0f}{'' if peak <= MEMORY_BAR else ', missed'}",
    ]
    return f"| {' | '.join(told)} |"


def bar(ratio: float, least: float) -> list[str]:
    return [f"{ratio:.1f}", f"{least:g}{'' if ratio >= least else ', missed'}"]


def compare(answers: list[Any], table: Any) -> None:
    """Stops where the table says another thing than single calls."""
    for k, hit in enumerate(answers):
        assert table.status[k] == hit.status.name, k
        assert hit.time is None or (table.time[k], table.lo[k], table.hi[k]) == (hit.time, *hit.time_interval), k
        assert hit.element_a is None or table.index_a[k] == hit.element_a.index, k


def peer(a: Any, b: Any, vectors: np.ndarray) -> float | None:
    """Microseconds that coal takes for a question."""
    try:
        from peers.coal_adapter import Conservative
    except ImportError:
        return None
    tool = Conservative()
    scene = SimpleNamespace(
        kind="translation", va=a.vertices, fa=a.triangles, vb=b.vertices, fb=b.triangles, vector=vectors[0]
    )
    state = tool.prepare(scene)

    def loop() -> None:
        for vector in vectors:
            scene.vector = vector
            scene.pose = lambda t, v=vector: (np.eye(3), t * v)
            tool.query(state, scene)

    return 1e6 * seconds(loop, time.process_time)[0] / len(vectors)


def assembly(n: int) -> str:
    """All pairs of so many bodies, of which a tenth moves, from a list of bodies to the table."""
    rng = np.random.default_rng(SEED)
    bodies = []
    for k in range(n):
        shape = fc.examples.noisy_sphere(320) if k % 2 else fc.examples.box((1, 1, 1))
        body = shape.translated((3 * (k % 10), 3 * (k // 10 % 10), 3 * (k // 100)))
        bodies.append(body.moving(fc.Translation(3 * rng.normal(size=3))) if k % 10 == 0 else body)
    pairs = np.array(list(itertools.combinations(range(n), 2)))
    taken, table = seconds(lambda: fc.first_contacts(fc.columns(bodies, pairs)), time.perf_counter)
    missed = "" if taken <= ASSEMBLY_BAR else ", missed"
    return (
        f"\nAn assembly of {n} bodies, {len(pairs)} pairs, a tenth of the bodies moving: {taken:.2f} s "
        f"(bar {ASSEMBLY_BAR:g} s{missed}): {table.counts}; {int((table.work == 0).sum())} pairs told by boxes.\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--assembly", type=int, default=300)
    options = parser.parse_args()
    from firstcontact.batch.workers import cores

    text = HEAD.format(rows=options.rows, cores=cores(), seed=SEED)
    for n in BARS:
        text += measured(n, options.rows) + "\n"
        print(text.splitlines()[-1], flush=True)
    text += assembly(options.assembly)
    print(text.splitlines()[-1])
    TARGET.write_text(text)


if __name__ == "__main__":
    main()
