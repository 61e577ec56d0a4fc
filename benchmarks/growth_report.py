"""Table, fits and pictures of `growth.py`."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Sequence
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np

CUT = "boxes, cut in "
BEST_CUT = "boxes, best cut"
FIT_FROM = 1000
"""Smallest n of a fit, where there are three sizes from there on; else all sizes count."""
BEGIN, END = "<!-- exponents -->", "<!-- end of exponents -->"
MEASURES = {"node_visits": "node visits", "pair_tests": "pair tests", "query_s": "query, s"}
PICTURES = {"node_visits": "growth-visits.png", "pair_tests": "growth-pairs.png", "query_s": "growth-time.png"}
COLOURS = {
    "auto": "black",
    "boxes": "tab:red",
    BEST_CUT: "tab:orange",
    "lifted": "tab:blue",
    "composed": "tab:purple",
    "sweep": "tab:green",
    "coal": "tab:brown",
    "ipctk": "tab:pink",
}


def write_csv(runs: Sequence[Any], path: Path, columns: list[str]) -> None:
    with path.open("w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(columns)
        for run in runs:
            rows.writerow([_short(getattr(run, column)) for column in columns])


def _short(value: Any) -> Any:
    return f"{value:.12g}" if isinstance(value, float) else value


def read_csv(path: Path, make: Any) -> list[Any]:
    """Rows as ``make(**fields)``; numbers by the types of its defaults."""
    types = {name: type(getattr(make("", "", "", 0), name)) for name in make.__dataclass_fields__}
    with path.open() as file:
        return [make(**{key: types[key](value) for key, value in row.items()}) for row in csv.DictReader(file)]


def with_best_cut(runs: Sequence[Any]) -> dict[tuple[str, str], dict[str, list[Any]]]:
    """Finished runs by (family, motion) and tool; of the cuts, whole rods included, for each n that of least work."""
    found: dict[tuple[str, str], dict[str, list[Any]]] = defaultdict(lambda: defaultdict(list))
    for run in runs:
        if not run.note:
            found[run.family, run.motion][run.tool].append(run)
    for tools in found.values():
        cuts = [tool for tool in tools if tool.startswith(CUT)]
        if cuts:
            pool = [run for tool in [*cuts, "boxes"] for run in tools[tool]]
            sizes = sorted({run.n for run in pool})
            best = [min((run for run in pool if run.n == n), key=lambda run: run.work) for n in sizes]
            for tool in cuts:
                del tools[tool]
            tools[BEST_CUT] = best
    return found


def exponent(runs: Sequence[Any], measure: str) -> tuple[float, int, int] | None:
    """(slope of log measure over log n, first n, last n) by least squares; None for fewer than three sizes."""
    points = [(run.n, getattr(run, measure)) for run in runs if getattr(run, measure) > 0]
    if len(points) < 3:
        return None
    large = [point for point in points if point[0] >= FIT_FROM]
    points = large if len(large) >= 3 else points
    x, y = np.log(np.array(points, float)).T
    return float(np.polyfit(x, y, 1)[0]), points[0][0], points[-1][0]


def _fit(runs: Sequence[Any], measure: str) -> str:
    found = exponent(runs, measure)
    return "" if found is None else f"{found[0]:.2f}"


def write_markdown(runs: Sequence[Any], path: Path) -> None:
    lines = [
        "# Growth on adversarial scenes",
        "",
        "Written by `python benchmarks/growth.py`; the pictures are in [docs](../docs/growth.md).  n moving and n",
        "resting rods or facets; exponents are slopes of log-log fits over the sizes named, at least three of them.",
        "Counts are exact; times are of one machine with other work on it.  A visit is a look at two boxes, or at an",
        "edge, path or facet and a cell; a pair test is one at two elements; work is both together.  *best cut*: of",
        "the box trees over rods cut in 1, 4, 16, 64 or 256 pieces the one with the least work, for each n.",
        "",
        "| family | motion | tool | fit over n | visits | pairs | work | query | one shot | largest n: visits | pairs "
        "| query, s | one shot, s | ended by |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    ended = {(run.family, run.motion, run.tool): f"n = {run.n}: {run.note}" for run in runs if run.note}
    for (family, motion), tools in with_best_cut(runs).items():
        for tool, done in tools.items():
            if not done:
                continue
            last, range_ = done[-1], exponent(done, "query_s")
            counts = [f"{last.node_visits:.3g}", f"{last.pair_tests:.3g}"] if last.node_visits else ["", ""]
            cells = [
                family,
                motion,
                tool,
                "" if range_ is None else f"{range_[1]:g} .. {range_[2]:g}",
                *(_fit(done, key) for key in ("node_visits", "pair_tests", "work", "query_s", "one_shot_s")),
                f"{last.n}: {counts[0]}",
                counts[1],
                f"{last.query_s:.3g}",
                f"{last.one_shot_s:.3g}",
                ended.get((family, motion, tool), ""),
            ]
            lines.append("| " + " | ".join(cells) + " |")
    lines += ["", *_disagreements(runs)]
    path.write_text("\n".join(lines) + "\n")


def _disagreements(runs: Sequence[Any]) -> list[str]:
    """Runs whose time is not that of the box tree on whole rods, beyond 1e-9 of the span."""
    truth = {(run.family, run.motion, run.n): run for run in runs if run.tool == "boxes" and not run.note}
    said = []
    for run in runs:
        known = truth.get((run.family, run.motion, run.n))
        if known is None or run.note:
            continue
        same_kind = run.status.lower() == known.status.lower()
        off = abs(run.time - known.time) if not isnan(run.time) and not isnan(known.time) else 0.0
        if not same_kind or off > 1e-9:
            what = f"{run.status.lower()} at {run.time:.9g}, boxes {known.status.lower()} at {known.time:.9g}"
            said.append(f"* {run.family}, {run.motion}, {run.tool}, n = {run.n}: {what}")
    return ["Answers that differ from those of the box tree by more than 1e-9 of the span:", "", *(said or ["* none"])]


def write_exponents(runs: Sequence[Any], page: Path) -> None:
    """Fill the place between two comments of the page with the exponents of `auto` and of the boxes."""
    text = page.read_text(encoding="utf-8")
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    table = "\n".join(_exponents(runs))
    page.write_text(f"{text[:begin]}\n\n{table}\n\n{text[end:]}", encoding="utf-8")


def _exponents(runs: Sequence[Any]) -> list[str]:
    lines = ["| encounter | motion | `auto`: n | exponent of work | of time | s at the largest n | boxes: of work |"]
    lines.append("|---|---|---|---|---|---|---|")
    for (family, motion), tools in with_best_cut(runs).items():
        auto = tools.get("auto", [])
        found = exponent(auto, "work")
        if found is None:
            continue
        boxes = exponent(tools.get("boxes", []), "work")
        cells = [
            family, motion, f"{found[1]:g} to {found[2]:g}", f"{found[0]:.2f}", _fit(auto, "query_s"),
            f"{auto[-1].query_s:.2g}", "" if boxes is None else f"{boxes[0]:.2f} ({boxes[1]:g} to {boxes[2]:g})",
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def draw(runs: Sequence[Any], folder: Path) -> None:
    """One picture for each measure, one panel for each family and motion."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    groups = with_best_cut(runs)
    across = 4
    for measure, name in PICTURES.items():
        down = -(-len(groups) // across)
        figure, panels = pyplot.subplots(down, across, figsize=(3.3 * across, 2.7 * down), squeeze=False)
        for panel in panels.flat[len(groups) :]:
            panel.axis("off")
        for panel, ((family, motion), tools) in zip(panels.flat, groups.items(), strict=False):
            _panel(panel, f"{family}, {motion}", tools, measure)
        figure.tight_layout()
        figure.savefig(folder / name, dpi=80)
        pyplot.close(figure)


def _panel(panel: Any, title: str, tools: dict[str, list[Any]], measure: str) -> None:
    from matplotlib.ticker import NullFormatter

    for tool, runs in tools.items():
        points = [(run.n, getattr(run, measure)) for run in runs if getattr(run, measure) > 0]
        if not points:
            continue
        found = exponent(runs, measure)
        label = tool if found is None else f"{tool}: {found[0]:.2f}"
        n, value = zip(*points, strict=True)
        style = {"linestyle": "--", "marker": "x"} if tool == "auto" else {"marker": "o"}
        panel.loglog(n, value, label=label, color=COLOURS.get(tool), markersize=3, linewidth=1, **style)
    panel.set_title(title, fontsize=8)
    panel.set_xlim(60, 2e5)
    panel.xaxis.set_minor_formatter(NullFormatter())
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.set_ylabel(MEASURES[measure], fontsize=7)
    panel.tick_params(labelsize=6)
    if panel.get_legend_handles_labels()[1]:
        panel.legend(fontsize=6)
