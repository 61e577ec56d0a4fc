"""Rows to results.csv and RESULTS.md; the bars stand here."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from measure import Row

SIZES = (1_000, 10_000, 100_000)
BARS = {
    # scene: how many times faster than coal at 1e-9, for n = 1e3, 1e4, 1e5: as built, and turned.
    "translation spheres": {"built": (5, 25, 30), "turned": (3, 10, 10)},
    "translation tori": {"built": (5, 25, 30), "turned": (3, 10, 10)},
    "translation gears": {"built": (12, 20, 40), "turned": (5, 1.5, 2)},
    "rotation lid": {"built": (30, 60, 35), "turned": (25, 35, 10)},
    "rotation arm": {"built": (20, 20, 15), "turned": (15, 12, 6)},
    "rotation arm past posts": {"built": (20, 20, 15), "turned": (15, 12, 6)},
    "rotation gears": {"built": (8, 25, 15), "turned": (8, 5, 2.5)},
}
WIDTH_BAR = 1e-12
"""Of the span: the widest enclosure that counts as certified."""
ONE_SHOT_BAR = 0.35
MEMORY_BAR = 500.0
START_BARS = {"first process (compiles)": 20.0, "later processes": 1.5, "--help": 0.3}
FIRST, COAL, LEAPING = "firstcontact", "coal", "coal leaping"


@dataclass
class Results:
    """Everything one run found; a text stands where a number could not be had.

    one_shot: scene name -> tool -> seconds.  memory: scene name -> MB.  start: command -> seconds.
    """

    rows: list[Row] = field(default_factory=list)
    one_shot: dict[str, dict[str, float | str]] = field(default_factory=dict)
    memory: dict[str, float | str] = field(default_factory=dict)
    start: dict[str, float | str] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    command: str = ""


def write_csv(results: Results, path: Path) -> None:
    """One line per scene, pose, size and tool."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(Row.__dataclass_fields__))
        writer.writeheader()
        for row in results.rows:
            writer.writerow({**asdict(row), "counts": json.dumps(row.counts)})


def write_markdown(results: Results, path: Path) -> None:
    """The tables, the failures first."""
    sections = [_head(results), _verdict(results), _bars(results), _others(results), _peers(results)]
    sections += [_work(results), _coal_loop(results), _process(results)]
    path.write_text("\n\n".join(section for section in sections if section) + "\n")


def bar_lines(results: Results) -> list[tuple[Row, Row, Row | None, float, str]]:
    """(firstcontact, coal, leaping coal, bar, what fails) for every barred scene of the run."""
    lines = []
    for (scene, pose, n), tools in _grouped(results.rows).items():
        if scene in BARS and n in SIZES and FIRST in tools and COAL in tools:
            bar = float(BARS[scene][pose][SIZES.index(n)])
            first, coal = tools[FIRST], tools[COAL]
            lines.append((first, coal, tools.get(LEAPING), bar, _fault(first, coal, bar)))
    return lines


def _fault(first: Row, coal: Row, bar: float) -> str:
    """Why the bar is not met; empty when it is."""
    if first.note or not first.repeats:
        return first.note or "no answer"
    if first.agree < first.repeats:
        return f"status {first.status}"
    if first.counts.get("width", 0.0) > WIDTH_BAR or (first.error or 0.0) > WIDTH_BAR:
        return "not within 1e-12"
    if coal.ratio is None:
        return f"coal: {coal.note}"
    return "" if coal.ratio >= bar else "slower than the bar"


def _grouped(rows: Iterable[Row]) -> dict[tuple[str, str, int], dict[str, Row]]:
    groups: dict[tuple[str, str, int], dict[str, Row]] = {}
    for row in rows:
        groups.setdefault((row.scene, row.pose, row.n), {})[row.tool] = row
    return groups


def _head(results: Results) -> str:
    text = (
        "# Results\n\n"
        f"Written by `{results.command}` on a machine with {os.cpu_count()} cores.  Times are medians in\n"
        "milliseconds after preparation; ratios are medians of ratios within one repeat, in which every\n"
        "tool in turn answers the same motion.  [README.md](README.md) tells what the scenes are, what each\n"
        "tool is asked, and what counts as an error."
    )
    if results.missing:
        text += f"\n\nNot installed, hence not measured: {', '.join(results.missing)}."
    return text


def _verdict(results: Results) -> str:
    lines = bar_lines(results)
    failed = [line for line in lines if line[4]]
    mine = [row for row in results.rows if row.tool == FIRST]
    asked = sum(row.repeats for row in mine)
    wrong = sum(row.repeats - row.agree for row in mine if row.repeats)
    decided = [row for row in mine if row.exact_status and row.expect != "unknown"]
    surprising = [row for row in decided if row.exact_status != _expected(row.expect)]
    undecided = sum("undecided" in row.status for row in mine)
    leaping = sum(bool(line[2] and (line[2].ratio or 0.0) >= line[3]) for line in lines)
    text = [
        "## Verdict",
        "",
        f"* Bars met: {len(lines) - len(failed)} of {len(lines)} (against coal's conservative loop; its "
        f"leaping loop, which proves nothing, is beaten by as much in {leaping} of {len(lines)}).",
        f"* firstcontact: {asked} queries, {wrong} with a status other than the exact one; scenes with an "
        f"undecided answer: {undecided}; scenes whose exact status is not the one they were built for: "
        f"{len(surprising)}.",
    ]
    text += [
        f"* Not met: {first.scene}, {first.pose}, n = {first.n}: {fault} "
        f"(ratio {_number(coal.ratio)}, bar {bar:g})"
        for first, coal, _, bar, fault in failed
    ]
    return "\n".join(text)


def _expected(expect: str) -> str:
    return "free" if expect == "near miss" else expect


def _bars(results: Results) -> str:
    body = []
    for first, coal, leaping, bar, fault in bar_lines(results):
        against = leaping.ratio if leaping else None
        body.append(
            [first.scene, first.pose, first.n, first.query_ms, coal.query_ms, coal.ratio, f"{bar:g}",
             fault or "met", leaping.query_ms if leaping else None, against]
        )  # fmt: skip
    head = ["scene", "pose", "n", "firstcontact", "coal", "ratio", "bar", "", "coal leaping", "ratio"]
    return "## Against coal\n\n" + _table(head, body) if body else ""


def _others(results: Results) -> str:
    body = []
    for (scene, pose, n), tools in _grouped(results.rows).items():
        if scene in BARS or FIRST not in tools:
            continue
        first, coal, leaping = tools[FIRST], tools.get(COAL), tools.get(LEAPING)
        body.append(
            [scene, pose, n, first.status or first.note, first.query_ms, coal and coal.query_ms,
             coal and coal.ratio, leaping and leaping.query_ms, leaping and leaping.ratio]
        )  # fmt: skip
    head = ["scene", "pose", "n", "answer", "firstcontact", "coal", "ratio", "coal leaping", "ratio"]
    return "## Scenes without a bar\n\n" + _table(head, body) if body else ""


def _peers(results: Results) -> str:
    tools = list(dict.fromkeys(row.tool for row in results.rows))
    body = [
        [scene, pose, n, *(_cell(found.get(tool)) for tool in tools)]
        for (scene, pose, n), found in _grouped(results.rows).items()
    ]
    text = (
        "## Every tool\n\nQuery (preparation) in ms, then the largest error of the time, as a part of the "
        "span; **bold**: a status that differs from the exact one.\n\n"
    )
    return text + _table(["scene", "pose", "n", *tools], body)


def _cell(row: Row | None) -> str:
    if row is None:
        return "-"
    if row.query_ms is None:
        return row.note or "-"
    text = f"{_number(row.query_ms)} ({_number(row.prepare_ms)})"
    if row.error is not None:
        text += f", {row.error:.0e}"
    if row.agree < row.repeats and row.exact_status:
        text += f", **{row.status}**"
    return text + (f", then {row.note}" if row.note else "")


def _work(results: Results) -> str:
    keys = ("node_visits", "pair_tests", "undecided", "exact_evaluations")
    body = []
    for row in results.rows:
        if row.tool == FIRST and row.counts:
            width = row.counts.get("width")
            counts = [f"{row.counts.get(key, 0.0):.0f}" for key in keys]
            rate = row.counts.get("exact_evaluations", 0.0) / max(1.0, row.counts.get("pair_tests", 0.0))
            shown = None if width is None else f"{width:.0e}"
            body.append([row.scene, row.pose, row.n, *counts, f"{rate:.1%}", shown])
    head = ["scene", "pose", "n", "node visits", "pair tests", "undecided pairs", "exact evaluations"]
    head += ["exact per test", "enclosure"]
    return "## Work of firstcontact\n\n" + _table(head, body) if body else ""


def _coal_loop(results: Results) -> str:
    body = []
    for (scene, pose, n), tools in _grouped(results.rows).items():
        cells: list[object] = []
        for tool in (COAL, LEAPING):
            row = tools.get(tool)
            if row is None or not row.query_ms:
                cells += [None, None]
                continue
            share = 1e3 * row.counts.get("distance seconds", 0.0) / row.query_ms
            cells += [f"{row.counts.get('distance queries', 0.0):.0f}", f"{min(1.0, share):.0%}"]
        body.append([scene, pose, n, *cells])
    head = ["scene", "pose", "n", "queries", "their share of the time", "queries (leaping)", "their share"]
    return "## coal's loop: distance queries\n\n" + _table(head, body) if any(b[3] for b in body) else ""


def _process(results: Results) -> str:
    parts = []
    if results.one_shot:
        tools = list(dict.fromkeys(tool for found in results.one_shot.values() for tool in found))
        body = [
            [scene, *(found.get(tool) for tool in tools), _verdict_cell(found.get(FIRST), ONE_SHOT_BAR)]
            for scene, found in results.one_shot.items()
        ]
        parts.append(
            f"## One shot\n\nSeconds from arrays to the answer, compiled, n = 1e5; bar {ONE_SHOT_BAR} s for "
            "firstcontact.\n\n" + _table(["scene", *tools, ""], body)
        )
    if results.memory:
        body = [[scene, value, _verdict_cell(value, MEMORY_BAR)] for scene, value in results.memory.items()]
        parts.append(
            f"## Memory\n\nPeak MB of a warm process that prepares the scene and answers, n = 1e5; bar "
            f"{MEMORY_BAR:g} MB.\n\n" + _table(["scene", "MB", ""], body)
        )
    if results.start:
        body = [
            [name, value, f"{START_BARS[name]:g}", _verdict_cell(value, START_BARS[name])]
            for name, value in results.start.items()
        ]
        parts.append(
            "## Start-up\n\nWall seconds of `firstcontact check examples/lid.toml`, and of `--help`.\n\n"
            + _table(["", "s", "bar", ""], body)
        )
    return "\n\n".join(parts)


def _verdict_cell(value: float | str | None, bar: float) -> str:
    if not isinstance(value, float):
        return "not measured"
    return "met" if value <= bar else "not met"


def _number(value: float | None) -> str:
    """Three significant digits without an exponent."""
    if value is None:
        return "-"
    if abs(value) >= 100:
        return f"{value:.0f}"
    return f"{value:#.3g}".rstrip(".")


def _table(head: Sequence[str], body: Iterable[Sequence[object]]) -> str:
    def text(cell: object) -> str:
        if cell is None:
            return "-"
        return _number(cell) if isinstance(cell, float) else str(cell)

    lines = [head, ["---"] * len(head), *([text(cell) for cell in row] for row in body)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
