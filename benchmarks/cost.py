"""Time, memory and Ctrl-C of questions that were found slow: writes COST.md.

    python benchmarks/cost.py [--limit 120] [--only PATTERN]

Each question has a process of its own: asked once, so that kernels are compiled; then of bodies made anew, and of the
same bodies again, quick ones many times; then over and over until an interrupt arrives, after about a second.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import signal
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from cost_scenes import ROWS

TARGET = Path(__file__).parent / "COST.md"
WAIT = 1.0
HEAD = """# Cost

What was found slow, before and now, in seconds of a processor on one machine; `python benchmarks/cost.py` writes this
table. Kernels are compiled, bodies are made anew. "before" is what was measured when it was found. Bars are of what
stands in bold. Ctrl-C: how long after the signal a question ended that is asked over and over (the worst of {tries};
where it takes long, of one). Memory is that of the whole process, of which the library with its kernels takes about
0.25 GB.

| question | before | bodies | first answer | later ones | bar | answer | Ctrl-C | memory |
|---|---|---|---|---|---|---|---|---|
"""
TRIES = 3
LATER, MANY, QUICK = 3, 200, 0.01
"""How often a question is asked again, of which the least time counts; how often where it takes less seconds."""
LONG = 5.0
"""Seconds from which on a question is not asked so often."""


class Measured(NamedTuple):
    bodies: float
    first: float
    later: float
    answer: str
    memory: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limit", type=float, default=120.0, help="seconds for one question")
    parser.add_argument("--only", default="", help="questions whose name holds this; then nothing is written")
    options = parser.parse_args()
    lines, seconds = [], dict[str, float]()
    for name in ROWS:
        if options.only in name:
            lines.append(line(name, options.limit, seconds))
            print(lines[-1], flush=True)
    if not options.only:
        TARGET.write_text(HEAD.format(tries=TRIES) + "\n".join(lines) + "\n")


def line(name: str, limit: float, seconds: dict[str, float]) -> str:
    """A row of the table; seconds: what was measured of the rows before, to which this one is added."""
    row = ROWS[name]
    found: Measured | None = in_process(ask, name, limit)
    if found is None:
        return f"| {name} | {row.before} | - | over {limit:.0f} s | - | - | - | - | - |"
    tries = TRIES if found.first < LONG else 1
    late = max(in_process(ask_until_interrupted, name, limit, interrupt=True) or limit for _ in range(tries))
    told = {"bodies": duration(found.bodies), "first": duration(found.first), "later": duration(found.later)}
    bar = row.bar if not isinstance(row.bar, tuple) else row.bar[0] * seconds[row.bar[1]]
    seconds[name] = {"all": found.bodies + found.first, "first": found.first, "later": found.later}[row.of]
    mark = "" if bar is None or seconds[name] <= bar else ", missed"
    for part in ("bodies", "first") if row.of == "all" else (row.of,):
        told[part] = f"**{told[part]}**"
    return (
        f"| {name} | {row.before} | {' | '.join(told.values())} | {duration(bar)}{mark} | {found.answer} | "
        f"{duration(late)} | {found.memory:.1f} GB |"
    )


def duration(seconds: float | None) -> str:
    if seconds is None:
        return "-"
    return f"{seconds:.2g} s" if seconds >= 0.1 else f"{1e3 * seconds:.2g} ms"


def in_process(task: Any, name: str, limit: float, interrupt: bool = False) -> Any:
    """What the task sends; with interrupt, seconds from the signal to its end.  None where it takes too long."""
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(False)
    process = context.Process(target=task, args=(name, sender))
    process.start()
    sender.close()
    try:
        if not receiver.poll(2 * limit):
            return None
        found = receiver.recv()
        if interrupt:
            time.sleep(WAIT * (1.0 + os.getpid() % 7 / 10))
            sent = time.perf_counter()
            os.kill(process.pid or 0, signal.SIGINT)
            found = time.perf_counter() - sent if receiver.poll(limit) else None
        return found
    except EOFError as error:
        raise RuntimeError(f"{name}: the question raised, see above") from error
    finally:
        process.kill()
        process.join()


def ask(name: str, sender: Connection) -> None:
    make = ROWS[name].make
    make()()
    begin = time.process_time()
    question = make()
    bodies = time.process_time() - begin
    answer = question()
    first = time.process_time() - begin - bodies
    later = min(timed(question) for _ in range(1 if first >= LONG else LATER))
    if later < QUICK:
        later = min(timed(question) for _ in range(MANY))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    told = str(getattr(answer, "status", answer)).split(".")[-1].split("\n")[0]
    sender.send(Measured(bodies, first, later, told, peak))


def timed(question: Any) -> float:
    begin = time.process_time()
    question()
    return time.process_time() - begin


def ask_until_interrupted(name: str, sender: Connection) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in what shells start in the background
    question = ROWS[name].make()
    question()
    sender.send("ready")
    try:
        while True:
            question()
    except KeyboardInterrupt:
        sender.send("interrupted")


if __name__ == "__main__":
    main()
