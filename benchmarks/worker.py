"""Each tool lives in a process of its own, so that a hang, a crash or its memory stays its own."""

from __future__ import annotations

import gc
import multiprocessing
import resource
import sys
from dataclasses import dataclass
from multiprocessing.connection import Connection
from time import perf_counter
from typing import Any

from peers import make_adapter
from peers.answer import Answer
from scenes import Scene

WARM_UP = 0.01
"""Seconds: untimed queries with other motions go before every timed one for this long, for every tool alike,
since the other tools have had the machine's caches in between."""
SLOW = 0.1
"""Seconds: a query this long needs no warming up."""
LONG_PREPARATION = 5.0
"""Seconds."""


class ToolMissing(Exception):
    """The tool is not installed."""


class ToolFailed(Exception):
    """The tool raised, died, or was stopped at the time limit; the text says which."""


@dataclass
class Timed:
    """Seconds of one call inside the tool's process, and its answer."""

    seconds: float
    answer: Answer


class Worker:
    """One tool in its own process; started on first use and again after it was stopped."""

    def __init__(self, tool: str, limit: float) -> None:
        """limit: seconds for one call; past it the process is killed."""
        self.tool, self.limit = tool, limit
        self._process: Any = None
        self._pipe: Any = None

    def prepare(self, scene: Scene) -> float:
        """Seconds to build, from the scene's arrays, what later queries reuse."""
        return self._call("prepare", scene)

    def query(self, repeat: int) -> Timed:
        """One query of the prepared bodies under the motion of that repeat."""
        return self._call("query", repeat)

    def exact(self, repeat: int) -> Answer:
        """The exact answer, by tools that have one."""
        return self._call("exact", repeat)

    def one_shot(self, scene: Scene) -> Timed:
        """From arrays to the answer, nothing kept."""
        return self._call("one_shot", scene)

    def peak_memory(self) -> float:
        """The largest resident size of the process so far, in MB."""
        return self._call("peak_memory", None)

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            self._process = None

    def _call(self, command: str, argument: Any) -> Any:
        if self._process is None:
            self._start()
        self._pipe.send((command, argument))
        return self._receive(self.limit)

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(self.tool, theirs), daemon=True)
        self._process.start()
        theirs.close()
        self._receive(120.0)  # imports, and compilation where there is some

    def _receive(self, limit: float) -> Any:
        if not self._pipe.poll(limit):
            self.close()
            raise ToolFailed(f"> {limit:g} s")
        try:
            kind, value = self._pipe.recv()
        except EOFError:
            self.close()
            raise ToolFailed("crashed") from None
        if kind == "missing":
            self.close()
            raise ToolMissing(value)
        if kind == "error":
            raise ToolFailed(value)
        return value


def _serve(tool: str, pipe: Connection) -> None:
    """The loop of a tool's process: one command, one reply."""
    try:
        server = _Server(make_adapter(tool))
    except ImportError as error:
        pipe.send(("missing", str(error)))
        return
    pipe.send(("ready", None))
    while True:
        try:
            command, argument = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(("value", getattr(server, command)(argument)))
        except Exception as error:  # a tool's failure is a result here; it is printed in the table
            pipe.send(("error", f"{type(error).__name__}: {error}"))


class _Server:
    """Commands of a worker, in the tool's process; collection of garbage is off while the clock runs."""

    def __init__(self, adapter: Any) -> None:
        self.adapter = adapter
        self.scene: Any = None
        self.state: Any = None
        self.last = 0.0

    def prepare(self, scene: Scene) -> float:
        """Twice, so that loading or compiling code is in no measurement; once where that is a small part."""
        self.scene, self.state, self.last = scene, None, 0.0
        seconds, self.state = _timed(self.adapter.prepare, scene)
        if seconds < LONG_PREPARATION:
            seconds, self.state = _timed(self.adapter.prepare, scene)
        gc.collect()
        return seconds

    def query(self, repeat: int) -> Timed:
        start, warm = perf_counter(), 100 * (repeat + 1)
        while self.last < SLOW and perf_counter() - start < WARM_UP:
            self.adapter.query(self.state, self.scene.jittered(warm))
            warm += 1
        self.last, answer = _timed(self.adapter.query, self.state, self.scene.jittered(repeat))
        return Timed(self.last, answer)

    def exact(self, repeat: int) -> Answer:
        return self.adapter.exact(self.state, self.scene.jittered(repeat))

    def one_shot(self, scene: Scene) -> Timed:
        return Timed(*_timed(_one_shot, self.adapter, scene))

    def peak_memory(self, _: None) -> float:
        unit = 1e6 if sys.platform == "darwin" else 1e3
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def _one_shot(adapter: Any, scene: Scene) -> Answer:
    make = getattr(adapter, "make", adapter.prepare)
    return adapter.query(make(scene), scene)


def _timed(function: Any, *arguments: Any) -> tuple[float, Any]:
    gc.disable()
    try:
        start = perf_counter()
        value = function(*arguments)
        return perf_counter() - start, value
    finally:
        gc.enable()
