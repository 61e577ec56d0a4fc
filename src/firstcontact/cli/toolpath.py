"""`firstcontact toolpath`: a tool along a program, against fixtures and stock."""

from __future__ import annotations

import csv
import json
from collections import Counter
from contextlib import ExitStack
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

import click

from firstcontact.cli import common
from firstcontact.cli.outputs import Outputs, Put, Writing
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.scene.load import Scene
    from firstcontact.toolpath.check import Verdict
    from firstcontact.toolpath.rules import Allowed

COLUMNS = (
    "line", "block", "status", "move", "part", "kind", "body", "contact", "fraction", "lo", "hi", "x", "y", "z",
    "tip_x", "tip_y", "tip_z", "deviation", "reason",
)  # fmt: skip
MOST_UNKNOWN = 3
"""Lines that the summary names."""


@click.command()
@click.argument("program")
@click.option("--scene", required=True, metavar="F", help="A scene with the tool, fixtures and stock.")
@click.option("--from", "start", metavar='"X Y Z"', help="Where the tip is before the program begins.")
@click.option("--allow", multiple=True, metavar="PART:MOVE:BODY",
              help="What may touch, instead of cutter:feed:stock* and cutter:back:stock*.")  # fmt: skip
@click.option("--strict", is_flag=True, help="Nothing may touch: no default.")
@click.option("--all", "every", is_flag=True, help="Tell of blocks that are free, too.")
@click.option("--csv", "table", metavar="F|-", help="Write what is found as CSV, row by row.")
@click.option("--jsonl", metavar="F|-", help="Write the blocks as JSON lines, as they are done.")
@click.option("--resume", metavar="F", help="Keep what is done in this file, and go on from there.")
@click.option("--workers", type=click.IntRange(1, 1024), metavar="N", help="Cores that take part (default: all).")
@click.option("--progress/--no-progress", default=None, help="Progress on stderr (default: on a tty)")
def toolpath(
    program: str, scene: str, start: str | None, allow: tuple[str, ...], strict: bool, every: bool, table: str | None,
    jsonl: str | None, resume: str | None, workers: int | None, progress: bool | None,
) -> int:  # fmt: skip
    """Find what a tool meets along a program of G-code or APT / CL.

    PROGRAM is a file of G-code (.nc, .ngc, .tap ...) or APT (.apt, .cl ...); the tool is a [tool.NAME] of the scene.
    A block is named by its line; MOVE is rapid, feed, or back: out over a way just cut.
    """
    from firstcontact.cli.progress import RowsProgress
    from firstcontact.scene.load import load_scene
    from firstcontact.toolpath.program import ToolPath
    from firstcontact.toolpath.rules import CUTTING, Allowed

    if strict and allow:
        raise click.UsageError("--strict and --allow: choose one.")
    out = Outputs({"--csv": table, "--jsonl": jsonl, "--resume": resume}, [program, scene])
    loaded = load_scene(scene)
    out.refuse_read(loaded.files)
    if not loaded.tools:
        raise InputError(f"{loaded.path}: no tool; add a [tool.NAME] with segments")
    path = ToolPath(program, start=None if start is None else _numbers(start), unit=loaded.unit)
    rules = () if strict else tuple(map(Allowed.read, allow)) or CUTTING
    for text, rule in zip(allow, rules, strict=False):
        _check_rule(text, rule, loaded)
    counts: Counter[str] = Counter()
    unknown: list[int] = []
    with ExitStack() as stack:
        stack.enter_context(out)
        targets = ("--csv", table, _rows), ("--jsonl", jsonl, _lines)
        puts = [stack.enter_context(out.rows(option, make)) for option, x, make in targets if x is not None]
        shown = stack.enter_context(RowsProgress(progress, program, out.say))
        if not out.silent:
            puts.append(lambda verdict: shown.say(_told(verdict)))
        asked = path.verdicts(
            loaded.tools.values(), loaded.bodies, allow=rules, workers=workers, resume=resume, progress=shown.rows
        )
        for verdict in asked:
            counts[verdict.status] += 1
            if verdict.status == "UNKNOWN":
                unknown.append(verdict.block.line)
            if every or verdict.status not in ("FREE", "UNKNOWN"):
                for put in puts:
                    put(verdict)
        if not counts:
            raise InputError(f"{program}: nothing in it moves the tool; give the whole program")
        shown.say(_summary(counts, unknown))
    return common.exit_code("UNDECIDED" if x == "UNKNOWN" else x for x in counts)


def _check_rule(text: str, rule: Allowed, scene: Scene) -> None:
    """Refuse a rule that is about nothing, which would be a mistake."""
    if not any(fnmatchcase(body, rule.body) for body in scene.bodies):
        raise InputError(f"--allow {text}: no body {rule.body!r}; the bodies are {', '.join(scene.bodies)}")
    segments = [segment for tool in scene.tools.values() for segment in tool.segments]
    if not any(rule.names(segment) for segment in segments):
        names = ", ".join(dict.fromkeys(x for segment in segments for x in (segment.kind, segment.name)))
        raise InputError(f"--allow {text}: no part {rule.part!r}; the parts are {names}")


def _numbers(text: str) -> list[float | int | Fraction]:
    from firstcontact.scene.values import parse_number

    try:
        numbers = [parse_number(word) for word in text.replace(",", " ").split()]
    except ValueError as error:
        raise InputError(f"--from: {error}") from error
    if len(numbers) != 3:
        raise InputError(f"--from {text!r}: {len(numbers)} numbers; give x, y and z")
    return numbers


def _told(verdict: Verdict) -> str:
    """The block, and a line for each pair that meets in it."""
    block = verdict.block
    lines = [f"line {block.line}: {block.text}: {verdict.status}{block.unknown and f' ({block.unknown})'}"]
    for x in verdict.findings:
        where = f"at {_place(x.point)}" if x.point is not None else f"with the tip at {_place(x.tip)}"
        when = "undecided" if x.status == "UNDECIDED" else "meets"
        share = "" if x.fraction != x.fraction else f" after {x.fraction:.9g} of the block"
        if x.status == "INITIAL_CONTACT":
            when, share = "in contact", f" from {x.fraction:.9g} of the block on,"
        off = f", within {x.deviation:.2g} of the programmed arc" if x.deviation > 1e-9 else ""
        why = f" ({x.reason})" if x.reason else ""
        lines.append(f"  {x.part} ({x.kind}, {x.move}) / {x.body}: {when}{share} {where}{off}{why}")
    return "\n".join(lines)


def _place(x: tuple[float, ...]) -> str:
    return "({:.6g}, {:.6g}, {:.6g})".format(*x)


def _summary(counts: Counter[str], unknown: list[int]) -> str:
    words = {"CONTACT": "in contact", "UNDECIDED": "undecided", "UNKNOWN": "not looked at", "FREE": "free"}
    told = ", ".join(f"{counts[key]:,} {word}" for key, word in words.items() if counts[key])
    lines = [f"{sum(counts.values()):,} blocks that move the tool: {told or 'none'}"]
    if unknown:
        some = ", ".join(map(str, unknown[:MOST_UNKNOWN])) + ", ..." * (len(unknown) > MOST_UNKNOWN)
        lines.append(f"  not looked at, for the program does not tell where they begin or end: line {some} (--from)")
    return "\n".join(lines)


def _lines(file: Writing) -> Put:
    """One object a line for each block."""
    from dataclasses import asdict

    from firstcontact.result import finite

    def put(verdict: Verdict) -> None:
        block = verdict.block
        table = {"line": block.line, "block": block.text, "status": verdict.status}
        if block.unknown:
            table["reason"] = block.unknown
        found = [finite(asdict(x)) for x in verdict.findings]
        file.write(json.dumps({**table, "findings": found}) + "\n")
        file.flush()

    return put


def _rows(file: Writing) -> Put:
    """A head of columns, then one row for each pair that meets, or one for the block."""
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)

    def put(verdict: Verdict) -> None:
        block = verdict.block
        head = [block.line, block.text, verdict.status]
        if not verdict.findings:
            writer.writerow([*head, *[None] * (len(COLUMNS) - 4), block.unknown])
        for x in verdict.findings:
            times = [None if t != t else t for t in (x.fraction, x.lo, x.hi)]
            place = x.point or (None, None, None)
            writer.writerow([
                *head, x.move, x.part, x.kind, x.body, x.status, *times, *place, *x.tip, x.deviation or None,
                x.reason or None,
            ])  # fmt: skip
        file.flush()

    return put
