"""Paired measurements of one scene by every tool, and the measurements that need a process of their own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from time import perf_counter

from peers.answer import Answer
from scenes import Scene
from worker import Timed, ToolFailed, ToolMissing, Worker

ALLOWANCE = 4.0
"""Seconds of queries after which another tool than firstcontact and coal sits out the rest of the repeats."""
PAIRED = ("firstcontact", "coal", "coal leaping")
REFERENCE = "firstcontact"
ROOT = Path(__file__).resolve().parent.parent


@dataclass
class Row:
    """What one tool did on one scene: medians over its repeats, times in ms.

    ratio: median over the repeats of this tool's time over firstcontact's.  agree: how many of the
    ``repeats`` statuses equal the exact one.  error: largest |time - exact time|.
    """

    scene: str
    pose: str
    n: int
    tool: str
    expect: str = ""
    prepare_ms: float | None = None
    query_ms: float | None = None
    ratio: float | None = None
    status: str = ""
    exact_status: str = ""
    repeats: int = 0
    agree: int = 0
    error: float | None = None
    counts: dict[str, float] = field(default_factory=dict)
    note: str = ""


def measure_scene(
    scene: Scene, pose: str, n: int, workers: dict[str, Worker], repeats: int, skip: set[str]
) -> list[Row]:
    """One row per tool; in every repeat all tools answer the same motion in turn.

    Tools that turn out not to be installed are taken out of ``workers``; those in ``skip`` are left out.
    """
    rows, ready = {}, {}
    for tool, worker in list(workers.items()):
        row = rows[tool] = Row(scene.name, pose, n, tool, scene.expect)
        if tool in skip:
            row.note = "too slow already at fewer triangles"
            continue
        try:
            row.prepare_ms = 1e3 * worker.prepare(scene)
            ready[tool] = worker
        except ToolMissing:
            print(f"  {tool}: not installed, skipped", file=sys.stderr)
            del workers[tool], rows[tool]
        except ToolFailed as failure:
            row.note = f"prepare: {failure}"
    answers = _paired(ready, rows, repeats)
    exact = _exact_answers(ready, rows, repeats)
    for tool, row in rows.items():
        _summarise(row, answers.get(tool, {}), answers.get(REFERENCE, {}), exact)
    return list(rows.values())


def _paired(ready: dict[str, Worker], rows: dict[str, Row], repeats: int) -> dict[str, dict[int, Timed]]:
    """Timed answers by tool and repeat."""
    answers: dict[str, dict[int, Timed]] = {tool: {} for tool in ready}
    for repeat in range(repeats):
        for tool, worker in ready.items():
            spent = sum(timed.seconds for timed in answers[tool].values())
            if rows[tool].note or (spent > ALLOWANCE and tool not in PAIRED):
                continue
            try:
                answers[tool][repeat] = worker.query(repeat)
            except ToolFailed as failure:
                rows[tool].note = str(failure)
    return answers


def _exact_answers(ready: dict[str, Worker], rows: dict[str, Row], repeats: int) -> dict[int, Answer]:
    """The exact answer by repeat."""
    exact: dict[int, Answer] = {}
    if REFERENCE not in ready or rows[REFERENCE].note:
        return exact
    try:
        for repeat in range(repeats):
            exact[repeat] = ready[REFERENCE].exact(repeat)
    except ToolFailed as failure:
        rows[REFERENCE].note = f"exact: {failure}"
    return exact


def _summarise(row: Row, mine: dict[int, Timed], first: dict[int, Timed], exact: dict[int, Answer]) -> None:
    if not mine:
        return
    row.repeats = len(mine)
    row.query_ms = 1e3 * median(timed.seconds for timed in mine.values())
    pairs = [timed.seconds / first[k].seconds for k, timed in mine.items() if k in first]
    row.ratio = median(pairs) if pairs else None
    row.status = "/".join(sorted({timed.answer.status for timed in mine.values()}))
    row.exact_status = "/".join(sorted({answer.status for answer in exact.values()}))
    known = {k: timed.answer for k, timed in mine.items() if k in exact}
    row.agree = sum(answer.status == exact[k].status for k, answer in known.items())
    errors = [
        abs(answer.time - other)
        for k, answer in known.items()
        if answer.time is not None and (other := exact[k].time) is not None
    ]
    row.error = max(errors) if errors else None
    keys = {key for timed in mine.values() for key in timed.answer.counts}
    row.counts = {key: median(t.answer.counts.get(key, 0.0) for t in mine.values()) for key in sorted(keys)}


def one_shots(scene: Scene, tools: list[str], limit: float, repeats: int = 3) -> dict[str, float | str]:
    """Median seconds from arrays to the answer, by tool, everything compiled; a text where there is none."""
    seconds: dict[str, float | str] = {}
    for tool in tools:
        worker = Worker(tool, limit)
        try:
            worker.one_shot(scene)
            seconds[tool] = median(worker.one_shot(scene).seconds for _ in range(repeats))
        except (ToolMissing, ToolFailed) as failure:
            seconds[tool] = str(failure)
        finally:
            worker.close()
    return seconds


def peak_memory(scene: Scene, limit: float) -> float | str:
    """Peak MB of a fresh process that loads the compiled kernels, prepares the scene and answers queries."""
    worker = Worker(REFERENCE, limit)
    try:
        worker.prepare(scene)
        worker.query(0)
        return worker.peak_memory()
    except (ToolMissing, ToolFailed) as failure:
        return str(failure)
    finally:
        worker.close()


def start_up(example: Path, repeats: int = 5) -> dict[str, float | str]:
    """Wall seconds of the command line: first process ever (empty cache), later ones (median), and --help."""
    seconds: dict[str, float | str] = {}
    with tempfile.TemporaryDirectory() as cache:
        check = ["check", str(example)]
        seconds["first process (compiles)"] = _wall(check, cache)
        seconds["later processes"] = _median_wall(check, cache, repeats)
        seconds["--help"] = _median_wall(["--help"], cache, repeats)
    return seconds


def _median_wall(arguments: list[str], cache: str, repeats: int) -> float | str:
    walls = [_wall(arguments, cache) for _ in range(repeats)]
    failures = [wall for wall in walls if isinstance(wall, str)]
    return failures[0] if failures else median(wall for wall in walls if not isinstance(wall, str))


def _wall(arguments: list[str], cache: str) -> float | str:
    """Seconds of one process; exit codes 0 and 1 (free, contact) are answers, others become a text."""
    environment = {**os.environ, "FIRSTCONTACT_CACHE": cache, "PYTHONDONTWRITEBYTECODE": ""}
    program = "import sys; from firstcontact.cli import main; main()"
    start = perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], env=environment, capture_output=True, text=True, cwd=ROOT
    )
    elapsed = perf_counter() - start
    if done.returncode in (0, 1) and not done.stderr.startswith("Traceback"):
        return elapsed
    last = done.stderr.strip().splitlines()[-1:] or [""]
    return f"exit code {done.returncode}: {last[0]}"
