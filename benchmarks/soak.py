"""Random and degenerate scenes of all families against oracles and laws, for as long as wanted.

    python benchmarks/soak.py --minutes 60 --seed 1 --workers 2 --report benchmarks/SOAK.md
    python benchmarks/soak.py --seed 1 --only meshes/landings --index 17

A scene depends on the seed, its kind's name and its index alone, so the second form runs one again.  Every finding
prints as a program that runs.  The exit code is 1 where anything was found.
"""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
import re
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from multiprocessing.connection import Connection, wait
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from numba.core.compiler_lock import global_compiler_lock

sys.path.insert(0, str(Path(__file__).parent))
from soaks import laws  # noqa: E402
from soaks.scene import Kind, Scene  # noqa: E402

FAMILIES = ("meshes", "solids", "mixed", "ruled", "curves")
SLOW = 20.0
"""Seconds of the processor after which a question is stopped; asked once more, because the first may have compiled."""
HANG = 180.0
"""Seconds of the clock without a word after which a worker is taken for lost in a loop and ended."""
LONGEST = 10
"""Questions that the end of a run names for the time they took."""
GRACE = 60.0
"""Seconds of the clock after the last minute that a scene may still take; its worker is ended then, and named."""
SHOWN = 3
"""Findings of one sort that are printed in full."""
HEADER = "from fractions import Fraction as F\n\nimport numpy as np\n\nimport firstcontact as fc\n\n"


class Stopped(BaseException):
    """The time of a question is over.  No Exception, so that nothing below catches it."""


@dataclass(frozen=True, slots=True)
class Record:
    """What became of one question.

    outcome  name of the status ("CONTACT", ...), "untold" (a start in contact whose kind is not proved), "answered"
             (an answer without status), "refused" (InputError or UnsupportedPair), "slow", or "raised".
    wrong    what is wrong with the answer, None where nothing is.
    """

    kind: str
    index: int
    motion: str
    source: str
    call: str
    outcome: str
    seconds: float = 0.0
    answer: str = ""
    wrong: str | None = None
    law: str | None = None

    def snippet(self, seed: int) -> str:
        """The finding as a program."""
        law = f"  law: {self.law}" if self.law else ""
        lines = [f"# --seed {seed} --only '{self.kind}' --index {self.index}{law}"]
        lines += [f"# {line}" for line in (self.wrong or self.outcome).splitlines()]
        shown = "\n".join(f"print({call})" for call in self.call.split("\n"))
        answers = "\n".join(f"# {line}" for line in self.answer.splitlines())
        return "\n".join(lines) + "\n" + HEADER + self.source.strip() + "\n" + shown + "\n" + answers + "\n"


def load(families: list[str]) -> dict[str, Kind]:
    """All kinds of the families that are there, by name."""
    kinds: dict[str, Kind] = {}
    for family in families:
        if not (Path(__file__).parent / "soaks" / f"{family}.py").exists():
            continue
        for kind in importlib.import_module(f"soaks.{family}").KINDS:
            kinds[kind.name] = kind
    return kinds


def _stop(*_: Any) -> None:
    if global_compiler_lock.is_locked():  # a compilation that is broken off leaves kernels that cannot be called
        signal.setitimer(signal.ITIMER_PROF, 1.0)
        return
    raise Stopped


def _timed(work: Any) -> tuple[Any, float]:
    """work() and its seconds of the processor; Stopped after SLOW of them."""
    begin = time.process_time()
    signal.signal(signal.SIGPROF, _stop)
    signal.setitimer(signal.ITIMER_PROF, SLOW)
    try:
        return work(), time.process_time() - begin
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _answered(calls: tuple[str, ...], names: dict[str, Any], judge: Any) -> tuple[str, float, str, str | None]:
    """(outcome, seconds, answers as text, what is wrong) of calls that are judged together."""
    import firstcontact as fc

    seconds = 0.0
    for attempt in (0, 1):
        answers: list[Any] = []
        try:
            for call in calls:
                answer, spent = _timed(lambda call=call: eval(call, names))
                answers.append(answer)
                seconds += spent
            shown = ""
            wrong, _ = _timed(lambda answers=answers: judge(*answers))
            if wrong is not None:
                shown = "\n".join(_text(answer) for answer in answers)
            return _outcome(answers[-1]), seconds, shown, wrong
        except Stopped:
            if attempt:
                return "slow", SLOW, "", None
        except (fc.InputError, fc.UnsupportedPair) as error:
            return "refused", seconds, f"{type(error).__name__}: {str(error).splitlines()[0]}", None
        except Exception as error:
            trace = traceback.format_exc().splitlines()[-8:]
            return "raised", seconds, "\n".join(trace), f"raised {type(error).__name__}: {str(error)[:200]}"
    raise AssertionError


def _outcome(answer: Any) -> str:
    if not hasattr(answer, "status"):
        return "answered"
    name: str = answer.status.name
    return "untold" if name == "INITIAL_CONTACT" and getattr(answer, "initial", "told") is None else name


def _text(answer: Any) -> str:
    parts = [str(answer)]
    for name in ("time_interval", "initial", "free_until", "reason", "multiplicity"):
        if getattr(answer, name, None) is not None:
            parts.append(f"{name} = {getattr(answer, name)!r}")
    for name in ("point", "normal"):
        try:
            value = getattr(answer, name, None)
        except Exception as error:
            value = f"raises {error!r}"
        if value is not None:
            parts.append(f"{name} = {value!r}")
    return "\n".join(parts)


def try_scene(kind: Kind, seed: int, index: int, share: float = 0.25, say: Any = lambda *_: None) -> Iterator[Record]:
    """The records of one scene: its questions, then laws for a `share` of the scenes.

    say(motion, source, call) is told what is about to be asked.
    """
    import firstcontact as fc

    say("", "(making the scene)", "")
    scene: Scene = kind.make(Random(f"{seed}/{kind.name}/{index}"))
    names: dict[str, Any] = {"fc": fc, "F": Fraction, "np": np}
    say(scene.motion, scene.source, "")
    try:
        exec(scene.source, names)
    except (fc.InputError, fc.UnsupportedPair) as error:
        line = f"{type(error).__name__}: {str(error).splitlines()[0]}"
        yield Record(kind.name, index, scene.motion, scene.source, "None", "refused", answer=line)
        return
    except Exception as error:
        trace = "\n".join(traceback.format_exc().splitlines()[-8:])
        wrong = f"the scene's source raised {type(error).__name__}: {str(error)[:200]}"
        yield Record(kind.name, index, scene.motion, scene.source, "None", "raised", 0.0, trace, wrong)
        return
    for question in scene.questions:
        say(scene.motion, scene.source, question.call)
        outcome, seconds, answer, wrong = _answered((question.call,), names, question.judge)
        yield Record(kind.name, index, scene.motion, scene.source, question.call, outcome, seconds, answer, wrong)
    rng = Random(f"{seed}/{kind.name}/{index}/laws")
    if not kind.laws or rng.random() >= share:
        return
    for trial in laws.trials(scene, names, rng):
        source = scene.source.rstrip() + "\n" + trial.source
        own = dict(names)
        say(scene.motion, source, "\n".join(trial.calls))
        try:
            exec(trial.source, own)
        except (fc.InputError, fc.UnsupportedPair):
            continue
        outcome, seconds, answer, wrong = _answered(trial.calls, own, trial.judge)
        calls = "\n".join(trial.calls)
        yield Record(kind.name, index, scene.motion, source, calls, outcome, seconds, answer, wrong, trial.law)


def _work(connection: Connection, families: list[str], seed: int, share: float) -> None:
    kinds = load(families)
    while True:
        job = connection.recv()
        if job is None:
            return
        name, index = job
        try:
            for record in try_scene(kinds[name], seed, index, share, lambda *at: connection.send(("at", at))):
                connection.send(("record", record))
        except (Stopped, Exception):
            connection.send(("broken", traceback.format_exc()))
        connection.send(("done", None))


@dataclass
class Worker:
    """A process that takes one scene at a time, and what it was last heard to do."""

    families: list[str]
    seed: int
    share: float
    job: tuple[str, int] | None = None
    at: tuple[str, str, str] = ("", "", "")
    heard: float = 0.0
    process: Any = None
    connection: Any = None

    def start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        arguments = (theirs, self.families, self.seed, self.share)
        self.process = context.Process(target=_work, args=arguments, daemon=True)
        self.process.start()
        theirs.close()

    def give(self, job: tuple[str, int]) -> None:
        self.job, self.at, self.heard = job, ("", "", ""), time.monotonic()
        self.connection.send(job)

    def end(self) -> None:
        self.process.kill()
        self.process.join()
        self.connection.close()


@dataclass
class Tally:
    """What all records add up to."""

    kinds: dict[str, Kind]
    seed: int
    questions: Counter[tuple[str, str]] = field(default_factory=Counter)
    outcomes: dict[tuple[str, str], Counter[str]] = field(default_factory=dict)
    scenes: dict[str, set[int]] = field(default_factory=dict)
    refusals: dict[str, Counter[str]] = field(default_factory=dict)
    found: dict[tuple[str, str], list[Record]] = field(default_factory=dict)
    count: Counter[tuple[str, str]] = field(default_factory=Counter)
    slow: list[Record] = field(default_factory=list)
    laws: Counter[str] = field(default_factory=Counter)
    queries: int = 0
    seconds: float = 0.0
    longest: list[Record] = field(default_factory=list)

    def add(self, record: Record) -> bool:
        """Whether this is the first finding of its sort."""
        key = (record.kind, record.motion)
        outcomes = self.outcomes.setdefault(key, Counter())
        self.scenes.setdefault(record.kind, set()).add(record.index)
        self.seconds += record.seconds
        self.queries += record.call.count("\n") + 1
        self.longest = sorted([*self.longest, record], key=lambda one: -one.seconds)[:LONGEST]
        if record.law is None:
            self.questions[key] += 1
            outcomes[record.outcome] += 1
        else:
            self.laws[record.law] += 1
            outcomes["laws"] += 1
        if record.outcome == "refused":
            self.refusals.setdefault(record.kind, Counter())[_sort(record.answer)] += 1
        if record.outcome == "slow":
            outcomes["slow in a law" if record.law else "slow"] += bool(record.law)
            self.slow.append(record)
        if record.wrong is None:
            return False
        outcomes["wrong"] += 1
        sort = (record.kind, f"{record.law or record.call.split('(')[0]}: {_sort(record.wrong)}")
        self.count[sort] += 1
        kept = self.found.setdefault(sort, [])
        if len(kept) < SHOWN:
            kept.append(record)
        return self.count[sort] == 1

    def findings(self) -> str:
        """Every sort of finding with its first few programs, then what was slow."""
        parts = []
        for sort in sorted(self.found):
            parts.append(f"{'=' * 100}\n{sort[0]}, {self.count[sort]} times: {sort[1]}\n")
            parts += [record.snippet(self.seed) + "\n" for record in self.found[sort]]
        for record in self.slow[:50]:
            parts.append(f"{'=' * 100}\nslow\n" + record.snippet(self.seed) + "\n")
        return "\n".join(parts)


def _sort(text: str) -> str:
    """The first line without its numbers and names in quotes: findings that agree in it are of one sort."""
    first = re.sub(r"-?\d[\d.]*(e[-+]?\d+)?", "#", text.splitlines()[0] if text else "")
    return re.sub(r"'[^']*'", "'..'", first)[:160]


class Turns:
    """Which scene is next: the kind that took the least time so far has the next turn, so that a kind whose scenes take
    long has as much of the run as the others, not more."""

    def __init__(self, kinds: Iterable[str], indices: Iterable[int]) -> None:
        self.left = {name: iter(indices) for name in kinds}
        self.spent = dict.fromkeys(self.left, 0.0)
        self.begun: dict[tuple[str, int], float] = {}

    def take(self) -> tuple[str, int] | None:
        """(kind, index); None where all are done."""
        while self.left:
            name = min(self.left, key=lambda name: self.spent[name])
            index = next(self.left[name], None)
            if index is not None:
                self.begun[name, index] = time.monotonic()
                return name, index
            del self.left[name]
        return None

    def done(self, name: str, index: int) -> None:
        self.spent[name] += time.monotonic() - self.begun.pop((name, index))


def run(kinds: dict[str, Kind], families: list[str], options: argparse.Namespace) -> Tally:
    """Scenes of all kinds until the minutes are over."""
    tally = Tally(kinds, options.seed)
    end = time.monotonic() + 60 * options.minutes
    last = sys.maxsize if options.scenes is None else options.scenes
    turns = Turns(kinds, range(last) if options.index is None else [options.index])

    def tell(record: Record) -> None:
        if tally.add(record):
            print(record.snippet(options.seed), flush=True)

    workers = [Worker(families, options.seed, options.laws) for _ in range(options.workers)]

    def next_job(worker: Worker) -> None:
        if worker.job is not None:
            turns.done(*worker.job)
        job = turns.take() if time.monotonic() < end else None
        if job is None:
            worker.end()
            workers.remove(worker)
        else:
            worker.give(job)

    def lost(worker: Worker, why: str, wrong: str | None) -> None:
        assert worker.job is not None
        motion, source, call = worker.at
        tell(Record(*worker.job, motion, source, call, why, wrong=wrong))
        worker.end()
        worker.start()
        next_job(worker)

    for worker in list(workers):
        worker.start()
        next_job(worker)
    told = time.monotonic()
    while workers:
        ready = wait([worker.connection for worker in workers], timeout=5)
        for worker in [worker for worker in workers if worker.connection in ready]:
            try:
                what, value = worker.connection.recv()
            except (EOFError, ConnectionResetError):
                lost(worker, "raised", "the process died")
                continue
            worker.heard = time.monotonic()
            if what == "at":
                worker.at = value
            elif what == "record":
                tell(value)
            elif what == "broken":
                motion, source, call = worker.at
                wrong = f"the soak itself failed: {value.splitlines()[-1]}"
                tell(Record(*worker.job, motion, source, call, "raised", 0.0, value, wrong))
            else:
                next_job(worker)
        for worker in list(workers):
            if time.monotonic() - worker.heard > HANG:
                lost(worker, "slow", None)
        if time.monotonic() > end + GRACE:
            for worker in workers:
                _, _, call = worker.at
                print(f"# not finished: {worker.job}: {call}", file=sys.stderr)
                worker.end()
            workers.clear()
        if time.monotonic() - told > 60:
            told = time.monotonic()
            asked, wrong = sum(tally.questions.values()), sum(tally.count.values())
            print(f"# {(told - end) / 60 + options.minutes:.0f} min: {asked} questions, {wrong} wrong", file=sys.stderr)
    return tally


def table(tally: Tally) -> str:
    """Markdown: a line per kind of scene and kind of motion."""
    lines = ["| kind | motion | scenes | questions | free | contact | initial | other answers | undecided | refused "
             "| untold | slow | laws | wrong |", "|---|---|" + "--:|" * 12]
    for kind, motion in sorted(tally.outcomes):
        counts = tally.outcomes[kind, motion]
        asked = tally.questions[kind, motion]
        rate = f"{counts['UNDECIDED']} ({counts['UNDECIDED'] / asked:.1%})" if asked and counts["UNDECIDED"] else "0"
        cells = [kind, motion, len(tally.scenes[kind]), asked, counts["FREE"], counts["CONTACT"],
                 counts["INITIAL_CONTACT"], counts["answered"], rate, counts["refused"],
                 counts["untold"], counts["slow"] + counts["slow in a law"], counts["laws"], counts["wrong"]]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    return "\n".join(lines)


def rates(tally: Tally) -> str:
    """Markdown: the rate of UNDECIDED by the kinds of bodies and of motion."""
    asked: Counter[tuple[str, str]] = Counter()
    open_: Counter[tuple[str, str]] = Counter()
    for (kind, motion), counts in tally.outcomes.items():
        key = (tally.kinds[kind].bodies, motion)
        asked[key] += tally.questions[kind, motion]
        open_[key] += counts["UNDECIDED"]
    lines = ["| bodies | motion | questions | undecided |", "|---|---|--:|--:|"]
    for key in sorted(asked):
        rate = f"{open_[key] / asked[key]:.2%}" if asked[key] else ""
        lines.append(f"| {key[0]} | {key[1]} | {asked[key]} | {rate} |")
    return "\n".join(lines)


def report(tally: Tally, options: argparse.Namespace, minutes: float) -> str:
    """The whole page."""
    wrong = sum(tally.count.values())
    parts = [
        "# Soak", "",
        f"Written by `python benchmarks/soak.py --minutes {options.minutes:g} --seed {options.seed} --workers "
        f"{options.workers}`: {sum(map(len, tally.scenes.values()))} scenes, {tally.queries} queries "
        f"({sum(tally.questions.values())} questions, the others in {sum(tally.laws.values())} laws) in {minutes:.0f} "
        f"minutes; {wrong} wrong, {len(tally.slow)} slow (over {SLOW:g} s of one processor).", "",
        "Scenes are random, most of them degenerate on purpose; truths come from constructions, exact rational brute "
        "force and static tests that share no code with the library (`benchmarks/soaks/`). An UNDECIDED is counted, "
        "not called wrong, unless its `free_until` passes a contact; so is a start in contact whose kind is not told "
        "(`initial` None). Every kind of scene has as much of the time as any other.", "",
        "## Undecided", "", rates(tally), "",
        "## Answers", "", table(tally), "",
        "## Laws", "", "| law | tried |", "|---|--:|",
        *(f"| {law} | {count} |" for law, count in sorted(tally.laws.items())), "",
        "## What each kind can and cannot reveal", "", "| kind | reveals | blind to |", "|---|---|---|",
        *(f"| {kind.name} | {kind.reveals} | {kind.blind} |" for kind in tally.kinds.values()), "",
    ]
    if tally.refusals:
        parts += ["## Refused", "", "| kind | times | first line |", "|---|--:|---|"]
        for kind, lines in sorted(tally.refusals.items()):
            parts += [f"| {kind} | {count} | {line} |" for line, count in lines.most_common(5)]
        parts.append("")
    if tally.found:
        parts += ["## Wrong", "", "| kind | times | what |", "|---|--:|---|"]
        parts += [f"| {sort[0]} | {tally.count[sort]} | {sort[1]} |" for sort in sorted(tally.found)]
        parts.append("")
    return "\n".join(parts)


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--scenes", type=int, help="scenes of each kind, instead of as many as the minutes allow")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--family", action="append", choices=FAMILIES, help="may be given again; all by default")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--laws", type=float, default=0.25, help="share of the scenes on which laws are tried")
    parser.add_argument("--only", help="kinds whose name begins so")
    parser.add_argument("--index", type=int, help="this one scene of each kind")
    parser.add_argument("--report", type=Path, help="write the page here")
    parser.add_argument("--findings", type=Path, default=Path("soak-findings.txt"))
    return parser.parse_args(words)


def main() -> int:
    options = arguments()
    families = list(options.family or FAMILIES)
    for family in families:
        if not any(name.startswith(family + "/") for name in load(families)):
            print(f"no family {family!r} here", file=sys.stderr)
    kinds = {name: kind for name, kind in load(families).items() if name.startswith(options.only or "")}
    if not kinds:
        print(f"no kind of scene begins with {options.only!r}", file=sys.stderr)
        return 2
    begin = time.monotonic()
    tally = run(kinds, families, options)
    minutes = (time.monotonic() - begin) / 60
    print(table(tally))
    print(f"\n{tally.queries} queries ({sum(tally.questions.values())} questions, {sum(tally.laws.values())} laws) in "
          f"{minutes:.1f} minutes, {tally.queries / tally.seconds if tally.seconds else 0:.0f} a second of asking")
    for record in tally.longest:
        asked = record.law or record.call
        print(f"{record.seconds:6.1f} s  {record.kind} --index {record.index}  {record.motion}: {asked}")
    for sort in sorted(tally.found):
        print(f"WRONG {tally.count[sort]:6d}  {sort[0]}  {sort[1]}")
    if tally.found or tally.slow:
        options.findings.write_text(tally.findings())
        print(f"programs in {options.findings}")
    if options.report:
        options.report.write_text(report(tally, options, minutes))
    return 1 if tally.found else 0


if __name__ == "__main__":
    sys.exit(main())
