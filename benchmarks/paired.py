"""This commit beside an older one, question by question, each asked of both in turn.

    git worktree add /tmp/older COMMIT
    python benchmarks/paired.py --before /tmp/older/src      # about ten minutes; writes benchmarks/PAIRED.md
    python benchmarks/paired.py --before /tmp/older/src --only solids

Both run in processes of their own, in one environment; seconds are of the processor.  A cell's ratio is the median of
the ratios of single repeats.  What a body works out once is left out: each process answers twice before it is measured.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import redirect_stdout
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
LEAST, MOST = 0.02, 2000
"""Seconds that a sample takes at least, if fewer than so many queries do."""
REPEATS = 7
MOVED = {"firstcontact.examples.choi": "firstcontact.worked_examples"}
"""What scenes import, and where older commits have it."""
MEAN_BAR, CELL_BAR = 1.03, 1.10
NEW, OLD = "now", "before"
TEXT = """# Beside an older commit

Written by `python benchmarks/paired.py --before OLDER/src` on {machine}: ratios of the time of a query now to that of
commit {commit}, both asked in turn. Bars: geometric mean of a table at most {mean}, no cell over {cell}.

{tables}
## Start-up

| what | before | now | ratio |
|---|--:|--:|--:|
{start}

## Cells

{rows}"""


# -- one side -----------------------------------------------------------------------------------------------


def serve() -> None:
    """Lines of JSON in, lines out: what a sample takes, or which cells there are."""
    for new, old in MOVED.items():
        if find_spec(old) is not None:
            sys.modules[new] = import_module(old)
    import paired_scenes

    known = {(table, name): make for table, name, make in paired_scenes.cells()}
    made: dict[tuple[str, str], Callable[[int], Any]] = {}
    out = sys.stdout
    with redirect_stdout(sys.stderr):
        for line in sys.stdin:
            order = json.loads(line)
            if order == "cells":
                print(json.dumps(list(known)), file=out, flush=True)
                continue
            key, repeat = tuple(order[:2]), order[2]
            try:
                found = _sample(made, known, key, repeat)
            except Exception as error:  # told as what it is, in the table
                found = {"failed": f"{type(error).__name__}: {error}"[:100]}
            print(json.dumps(found), file=out, flush=True)


def _sample(made: dict[Any, Any], known: dict[Any, Any], key: tuple[str, str], repeat: int) -> dict[str, Any]:
    if key not in made:
        made.clear()
        made[key] = known[key]()
        for _ in range(2):
            made[key](0)
    ask, count = made[key], 0
    begin = time.process_time()
    while count == 0 or (time.process_time() - begin < LEAST and count < MOST):
        answer = ask(repeat)
        count += 1
    seconds = (time.process_time() - begin) / count
    status = getattr(answer, "status", None)
    return {"seconds": seconds, "answer": str(status), "memory": _memory()}


def _memory() -> float:
    """MB that the process took at most."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


# -- both ---------------------------------------------------------------------------------------------------


class Side:
    def __init__(self, source: Path, cache: Path) -> None:
        self.environment = {
            **os.environ, "PYTHONPATH": f"{source}{os.pathsep}{HERE}", "FIRSTCONTACT_CACHE": str(cache),
            "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "",  # compiled once, as installed modules are
        }  # fmt: skip
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / "paired.py"), "--serve"], env=self.environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def ask(self, order: Any) -> Any:
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps(order) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"the process of {self.environment['PYTHONPATH']} ended")
        return json.loads(line)

    def seconds(self, *arguments: str) -> float:
        """Of the processor, of a command of its own, the least of five."""
        found = []
        for _ in range(5):
            begin = os.times()
            subprocess.run([sys.executable, *arguments], env=self.environment, capture_output=True, check=False)
            end = os.times()
            found.append(end.children_user + end.children_system - begin.children_user - begin.children_system)
        return min(found)


def measured(sides: dict[str, Side], cell: list[str], repeats: int) -> dict[str, Any]:
    samples: dict[str, list[dict[str, Any]]] = {side: [] for side in sides}
    for repeat in range(1, repeats + 1):
        for side in (NEW, OLD) if repeat % 2 else (OLD, NEW):
            samples[side].append(sides[side].ask([*cell, repeat]))
    failed = {side: x["failed"] for side, found in samples.items() for x in found if "failed" in x}
    row: dict[str, Any] = {"table": cell[0], "cell": cell[1], "failed": failed}
    if not failed:
        pairs = list(zip(samples[NEW], samples[OLD], strict=True))
        row |= {side: statistics.median(x["seconds"] for x in samples[side]) for side in sides}
        row["ratio"] = statistics.median(x["seconds"] / y["seconds"] for x, y in pairs)
        row["memory"] = [samples[side][-1]["memory"] for side in (NEW, OLD)]
        row["same"] = all(x["answer"] == y["answer"] for x, y in pairs)
    return row


def start_up(sides: dict[str, Side]) -> str:
    example = str(HERE.parent / "examples" / "lid.toml")
    orders = {
        "`import firstcontact`": ("-c", "import firstcontact"),
        "second start of `check`": ("-m", "firstcontact", "check", example),
    }
    rows = []
    for what, arguments in orders.items():
        old, new = (sides[side].seconds(*arguments) for side in (OLD, NEW))
        rows.append(f"| {what} | {1e3 * old:.0f} ms | {1e3 * new:.0f} ms | {new / old:.2f} |")
    return "\n".join(rows)


def tables(rows: list[dict[str, Any]]) -> str:
    by_table = defaultdict(list)
    for row in rows:
        by_table[row["table"]].append(row)
    lines = ["| table | cells | geometric mean | bar | slowest cell | bar | memory, MB before / now |",
             "|---|--:|--:|---|--:|---|--:|"]  # fmt: skip
    for name, every in by_table.items():
        known = [row for row in every if "ratio" in row]
        mean = math.exp(statistics.fmean(math.log(row["ratio"]) for row in known))
        worst = max(row["ratio"] for row in known)
        new, old = (max(row["memory"][k] for row in known) for k in (0, 1))
        told = ["met" if value <= bar else "**missed**" for value, bar in ((mean, MEAN_BAR), (worst, CELL_BAR))]
        lines.append(
            f"| {name} | {len(known)} | {mean:.2f} | {told[0]} | {worst:.2f} | {told[1]} | {old:.0f} / {new:.0f} |"
        )
    return "\n".join(lines) + "\n"


def listed(rows: list[dict[str, Any]]) -> str:
    lines = ["| table | cell | before, ms | now, ms | ratio | |", "|---|---|--:|--:|--:|---|"]
    for row in sorted(rows, key=lambda row: -row.get("ratio", math.inf)):
        if row["failed"]:
            told = "; ".join(f"{side}: {why}" for side, why in row["failed"].items())
            lines.append(f"| {row['table']} | {row['cell']} | - | - | - | {told} |")
            continue
        told = "" if row["same"] else "another status"
        times = f"{1e3 * row[OLD]:.3g} | {1e3 * row[NEW]:.3g} | {row['ratio']:.2f}"
        lines.append(f"| {row['table']} | {row['cell']} | {times} | {told} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, help="src of the older checkout")
    parser.add_argument("--only", default="", help="cells whose table or name holds this text")
    parser.add_argument("--repeats", type=int, default=REPEATS)
    parser.add_argument("--report", type=Path, default=HERE / "PAIRED.md")
    parser.add_argument("--caches", type=Path, help="where compiled kernels of both are kept; default: nowhere")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        serve()
        return
    if arguments.before is None or not (arguments.before / "firstcontact").is_dir():
        parser.error("--before: give the src folder of a checkout of the older commit")
    with tempfile.TemporaryDirectory() as folder:
        caches = arguments.caches or Path(folder)
        sources = {NEW: HERE.parent / "src", OLD: arguments.before.resolve()}
        sides = {side: Side(source, caches / side) for side, source in sources.items()}
        known = sides[OLD].ask("cells")
        rows = []
        for cell in sides[NEW].ask("cells"):
            if cell in known and arguments.only in " ".join(cell):
                rows.append(measured(sides, cell, arguments.repeats))
                print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
        start = start_up(sides)
    commit = subprocess.run(["git", "-C", str(arguments.before), "rev-parse", "--short", "HEAD"],
                            capture_output=True, text=True, check=False).stdout.strip()  # fmt: skip
    machine = f"{os.cpu_count()} processors, Python {sys.version.split()[0]}"
    text = TEXT.format(machine=machine, commit=commit, mean=MEAN_BAR, cell=CELL_BAR, tables=tables(rows), start=start,
                       rows=listed(rows))  # fmt: skip
    if not arguments.only:
        arguments.report.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
