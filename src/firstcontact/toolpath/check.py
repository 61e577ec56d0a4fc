"""Blocks of a program against bodies at rest: what is apart by hulls first, the rest by exact solids."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.batch.verb import first_contacts
from firstcontact.batch.workers import cores
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import above, below, exact_value, to_double
from firstcontact.kernels.workspace import workspace
from firstcontact.motion.moving import Moving
from firstcontact.search.trees.frame import tree_of
from firstcontact.toolpath.blocks import Block
from firstcontact.toolpath.moves import Stretch
from firstcontact.toolpath.rules import CUTTING, MOVES, Allowed
from firstcontact.toolpath.tool import Segment, Tool
from firstcontact.toolpath.walk import APART, OPEN, begun_inside, told_of_rows

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape

CHUNK = 1024
"""Blocks that are looked at together."""
FINE = 0.02
"""Part of the tool's largest radius by which hulls of arcs and swings may be off: what is nearer is asked exactly."""
FEWEST_ROWS = 256
"""Rows for each thread."""


@dataclass(frozen=True)
class Finding:
    """What a block brings together.

    part, kind: the segment of the tool, "cutter" or "holder".  move: "rapid", "feed" or "back".
    status: CONTACT, INITIAL_CONTACT (from the start of this way on), UNDECIDED.
    fraction: of the block's way at which they first touch; nan where it is not known.  lo, hi: an enclosure.
    point: the place, None where it is not told (from the start on).  tip: where the tip is then, or at the start.
    deviation: how far the way may be off the one that was programmed.
    """

    part: str
    kind: str
    body: str
    move: str
    status: str
    fraction: float
    lo: float
    hi: float
    point: tuple[float, ...] | None
    tip: tuple[float, ...]
    deviation: float = 0.0
    reason: str = ""


@dataclass(frozen=True)
class Verdict:
    """Of one block: FREE where there are no findings and nothing is unknown."""

    block: Block
    findings: tuple[Finding, ...]

    @property
    def status(self) -> str:
        """FREE, CONTACT, UNDECIDED or UNKNOWN, of a block that the program does not tell enough of."""
        if self.block.unknown:
            return "UNKNOWN"
        found = {finding.status for finding in self.findings}
        return "FREE" if not found else "UNDECIDED" if found == {"UNDECIDED"} else "CONTACT"


class Setup:
    """Tools and bodies at rest, made ready.

    tools: one tool, or several, which programs call by their numbers.  bodies: by name.  allow: what may touch,
    default `CUTTING`.  workers: how many cores take part, default None: all of them.
    """

    def __init__(
        self, tools: Tool | Iterable[Tool], bodies: Mapping[str, Body], allow: Sequence[Allowed] = CUTTING,
        workers: int | None = None,
    ) -> None:  # fmt: skip
        self.tools = [tools] if isinstance(tools, Tool) else list(tools) if isinstance(tools, Iterable) else []
        if not self.tools or not all(isinstance(tool, Tool) for tool in self.tools):
            raise InputError(f"tools are {shown(tools)}; give an fc.Tool, or several")
        if not isinstance(bodies, Mapping):
            raise InputError(f"bodies are {shown(bodies)}; give a dict of bodies by their names")
        self.allow, self.workers = tuple(allow), workers or cores()
        self.targets = [_target(name, body) for name, body in bodies.items()]
        if not self.targets:
            raise InputError("no bodies; give fixtures or stock to ask about")

    def verdicts(self, blocks: Iterable[Block], chunk: int = CHUNK) -> Iterator[Verdict]:
        """Of the blocks in their order, as they come: a chunk of them is held at a time."""
        waiting = iter(blocks)
        while some := list(islice(waiting, chunk)):
            yield from self.of_chunk(some)

    def check(self, block: Block) -> None:
        """InputError where a block cannot be asked about."""
        if block.stretches:
            self.tool_of(block)

    def tool_of(self, block: Block) -> Tool:
        """The tool that a block moves: the one that was called, or the only one, unless it has another number."""
        only = self.tools[0] if len(self.tools) == 1 else None
        if only is not None and (None in (only.number, block.tool) or only.number == block.tool):
            return only
        tool = next((x for x in self.tools if x.number is not None and x.number == block.tool), None)
        if tool is None:
            called = "no tool is called before" if block.tool is None else f"T{block.tool}: there is no such tool"
            told = ", ".join(f"{x.name or 'tool'} (number {x.number})" for x in self.tools)
            raise InputError(f"line {block.line}: {called}; the tools are {told}")
        return tool

    def of_chunk(self, blocks: list[Block]) -> list[Verdict]:
        """Of some blocks."""
        asked: list[_Asked] = []
        groups: dict[int, tuple[Tool, list[int]]] = {}
        for k, block in enumerate(blocks):
            if block.stretches:
                tool = self.tool_of(block)
                groups.setdefault(id(tool), (tool, []))[1].append(k)
        for tool, some in groups.values():
            rows = _ToolRows(tool, [(k, stretch) for k in some for stretch in blocks[k].stretches])
            for target in self.targets:
                for segment in tool.segments:
                    asked += self._open(rows, segment, target)
        queries = [(x.stretch.moving(x.segment.solid), x.target.body) for x in asked if x.begun is None]
        answers = _answers(queries, self.workers)
        found: dict[int, dict[tuple[str, str], Finding]] = {}
        for x in asked:
            answer = _WayAnswer("INITIAL_CONTACT", 0.0, 0.0, 0.0, x.begun) if x.begun is not None else next(answers)
            if answer.status != "FREE":
                _keep(found.setdefault(x.block, {}), _finding(x, blocks[x.block], answer))
        return [Verdict(block, tuple(found.get(k, {}).values())) for k, block in enumerate(blocks)]

    def _open(self, rows: _ToolRows, segment: Segment, target: _Target) -> list[_Asked]:
        """Ways of the segment that are not proved apart from the body by hulls."""
        counted = [not any(x.holds(segment, move, target.name) for x in self.allow) for move in MOVES]
        chosen = np.flatnonzero(np.array(counted)[rows.moves])
        told = rows.told(chosen, segment, target, self.workers)
        left = np.unique(rows.stretch[chosen[told != APART]])
        begun = rows.begun(left, segment, target)
        made = zip((rows.asked[k] for k in left.tolist()), begun, strict=True)
        return [_Asked(block, stretch, segment, target, point) for (block, stretch), point in made]


@dataclass(frozen=True)
class _Target:
    """A body, and a mesh that holds it."""

    name: str
    body: Any
    mesh: Polyhedron | None


@dataclass(frozen=True)
class _Asked:
    """A way of a segment before a body; begun: a point that they share at its start, where one is known."""

    block: int
    stretch: Stretch
    segment: Segment
    target: _Target
    begun: tuple[float, ...] | None = None


@dataclass(frozen=True)
class _WayAnswer:
    """To a way: times are of the way; nan and None where there is none."""

    status: str
    time: float
    lo: float
    hi: float
    point: tuple[float, ...] | None
    reason: str = ""


def _answers(queries: list[tuple[Moving, Shape]], workers: int) -> Iterator[_WayAnswer]:
    """The first contacts of exact solids, in order."""
    if not queries:
        return
    table = first_contacts(queries, workers=workers)
    columns = map(table.column, ("status", "time", "lo", "hi", "point", "reason", "error"))
    for status, time, lo, hi, point, reason, error in zip(*columns, strict=True):
        if error is not None:
            yield _WayAnswer("UNDECIDED", np.nan, np.nan, np.nan, None, error)
        else:
            place = None if np.isnan(point).any() else tuple(point.tolist())
            yield _WayAnswer(str(status), float(time), float(lo), float(hi), place, str(reason))


def _target(name: str, body: Body) -> _Target:
    if isinstance(body, Moving):
        raise InputError(f"body {name!r} moves; tool paths are asked about bodies at rest")
    if isinstance(body, Polyhedron):
        return _Target(name, body, body)
    lo, hi = (np.asarray(x, float) for x in body.bounds())
    if not np.isfinite(lo).all() or not np.isfinite(hi).all():
        return _Target(name, body, None)
    pad = 1e-15 * float(np.abs([lo, hi]).max()) + 1e-300  # bounds round once
    return _Target(name, body, _box(lo - pad, hi + pad))


def _box(lo: np.ndarray, hi: np.ndarray) -> Polyhedron:
    corners = [[(lo, hi)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return Polyhedron(np.array(corners), faces)


class _ToolRows:
    """Places of a tool along many ways, as `walk` takes them: rows of neighbouring places."""

    def __init__(self, tool: Tool, asked: list[tuple[int, Stretch]]) -> None:
        self.asked = asked
        reach = max(segment.reach for segment in tool.segments)
        fine = FINE * max(max(x.doubles[1], x.doubles[3]) for x in tool.segments)
        places = [stretch.places(fine, reach) for _, stretch in asked]
        counts = [len(x.fractions) - 1 for x in places]
        self.stretch = np.repeat(np.arange(len(asked)), counts)
        first = np.arange(len(self.stretch)) + self.stretch  # each way has one place more than it has rows
        self.tips, self.axes = (
            np.stack([x[first], x[first + 1]], axis=1)
            for x in (np.concatenate([x.tips for x in places]), np.concatenate([x.axes for x in places]))
        )
        self.pads = np.repeat([x.pad for x in places], counts)
        self.swings = np.repeat([x.swing for x in places], counts)
        self.moves = np.repeat([MOVES.index(stretch.kind) for _, stretch in asked], counts)

    def begun(self, ways: np.ndarray, segment: Segment, target: _Target) -> list[tuple[float, ...] | None]:
        """Points of a mesh that lie inside the segment at the start of some ways, where `walk` finds one."""
        if target.mesh is not target.body or not len(ways):
            return [None] * len(ways)
        tree, first = tree_of(target.mesh), np.searchsorted(self.stretch, ways)
        found = np.empty((len(ways), 3))
        shape = np.array(segment.doubles)
        begun_inside(
            tree.boxes, tree.links, tree.xyz, tree.error, self.tips[first, 0].copy(), self.axes[first, 0].copy(),
            shape, found,
        )  # fmt: skip
        return [None if x[0] != x[0] else tuple(x) for x in found.tolist()]

    def told(self, chosen: np.ndarray, segment: Segment, target: _Target, workers: int) -> np.ndarray:
        """What `walk` tells of some rows."""
        out = np.full(len(chosen), OPEN, np.int64)
        if target.mesh is None or not len(chosen):
            return out
        tree, solid = tree_of(target.mesh), target.mesh.solid
        pads = self.pads[chosen] + self.swings[chosen] * segment.reach
        tips, axes, shape = self.tips[chosen], self.axes[chosen], np.array(segment.doubles)

        def walk(part: slice) -> None:
            told_of_rows(
                tree.boxes, tree.links, tree.xyz, tree.ids, tree.error, solid, tips[part], axes[part],
                pads[part], shape, workspace()[0], out[part],
            )  # fmt: skip

        count = max(1, min(workers, len(chosen) // FEWEST_ROWS))
        cuts = np.linspace(0, len(chosen), count + 1).astype(int).tolist()
        parts = [slice(x, y) for x, y in zip(cuts, cuts[1:], strict=False)]
        if count == 1:
            walk(parts[0])
        else:
            with ThreadPoolExecutor(count) as pool:
                list(pool.map(walk, parts))
        return out


def _finding(x: _Asked, block: Block, answer: _WayAnswer) -> Finding:
    """By the fraction of the whole block."""
    lengths = [stretch.length for stretch in block.stretches]
    lengths = lengths if sum(lengths) else [1.0] * len(lengths)
    k = next(k for k, stretch in enumerate(block.stretches) if stretch is x.stretch)
    before, own, whole = (exact_value(sum(x)) for x in (lengths[:k], lengths[k : k + 1], lengths))
    time, lo, hi = (
        t if np.isnan(t) else rounded((before + own * exact_value(t)) / whole)
        for t, rounded in ((answer.time, to_double), (answer.lo, below), (answer.hi, above))
    )
    tip = x.stretch.tip(0.0 if np.isnan(answer.time) else answer.time)
    return Finding(
        x.segment.name, x.segment.kind, x.target.name, x.stretch.kind, answer.status, time, lo, hi, answer.point,
        tuple(tip), x.stretch.deviation, answer.reason,
    )  # fmt: skip


def _keep(found: dict[tuple[str, str], Finding], new: Finding) -> None:
    """Of several findings of one segment and body the first contact, else the first that is undecided."""
    key = new.part, new.body
    old = found.get(key)
    if old is None or old.status == "UNDECIDED" != new.status:
        found[key] = new
