"""The pictures of how-it-works.md: `python docs/draw.py` writes house.png and way.png beside it.

The house comes from the layers in pyproject.toml: what is drawn is what import-linter holds.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PACKAGE = HERE.parent / "src" / "firstcontact"
INK, PALE, EDGE = "#1b2a38", "#eef3f7", "#7d93a6"
SHADES = {"asked": "#dfeaf5", "answers": "#fbe9d7", "finds": "#e4f2e1", "knows": "#f3e6f1", "ground": "#ececec"}
FLOORS = {
    "asked": (
        "__main__", "cli", "view", "warmup", "scene", "assembly", "toolpath", "batch", "robot", "mechanism", "query",
        "examples", "io", "step",
    ),
    "answers": ("curves", "contact", "timeline"),
    "finds": ("search",),
    "knows": ("pairs", "body", "motion", "brackets", "kernels", "exact"),
    "ground": ("work", "result_curve", "result_table", "result", "errors", "interrupts"),
}
SAYS = {
    "__main__": "python -m firstcontact", "cli": "the commands", "view": "pages and pictures",
    "warmup": "compiles ahead",
    "scene": "TOML scenes", "assembly": "what may touch; new contacts",
    "batch": "many questions: cores, clusters, files",
    "toolpath": "G-code, APT: tools along programs",
    "robot": "URDF, SRDF", "mechanism": "links and joints: courses, sweeps",
    "query": "the verbs: checks, one Query", "curves": "intersection curves",
    "contact": "a room for each pair of kinds of bodies; table, ways", "timeline": "all contacts in time",
    "search": "candidates and proofs", "examples": "bodies to try", "io": "mesh files",
    "step": "STEP files", "pairs": "formulas of features",
    "body": "meshes, solids, ruled surfaces", "motion": "motions, relative motion", "brackets": "segments in brackets",
    "work": "Query, budget", "kernels": "compiled code", "exact": "numbers, polynomials, roots",
    "result_curve": "answers: curves", "result_table": "answers: tables", "result": "answers: contacts",
    "errors": "InputError, UnsupportedPair", "interrupts": "Ctrl-C while others load",
}  # fmt: skip


def layers() -> list[list[str]]:
    """The rooms from top to bottom, those side by side together."""
    contracts = tomllib.loads((HERE.parent / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    rooms = next(c for c in contracts if c["containers"] == ["firstcontact"])
    return [[room.strip() for room in layer.split("|")] for layer in rooms["layers"]]


def subrooms(room: str) -> list[str]:
    folder = PACKAGE / room
    return sorted(x.name for x in folder.iterdir() if (x / "__init__.py").exists()) if folder.is_dir() else []


def files(room: str) -> int:
    folder = PACKAGE / room
    return len(list(folder.rglob("*.py"))) if folder.is_dir() else 1


def draw_house(path: Path) -> None:
    pyplot = _pyplot()
    rows = layers()
    figure, axes = pyplot.subplots(figsize=(10, 0.62 * len(rows)))
    for k, rooms in enumerate(rows):
        width = 10.0 / len(rooms)
        for i, room in enumerate(rooms):
            floor = next(name for name, own in FLOORS.items() if room in own)
            _box(axes, i * width + 0.04, -k, width - 0.08, 0.86, SHADES[floor])
            inner = ", ".join(subrooms(room))
            axes.text(i * width + 0.2, -k + 0.43, room, va="center", fontsize=10, weight="bold", color=INK)
            text = f"{SAYS[room]}{': ' + inner if inner else ''}"
            text = _wrapped(text, int(16 * (width - 2.3)))
            axes.text(i * width + 1.6, -k + 0.43, text, va="center", fontsize=7, color=INK)
            right = (i + 1) * width - 0.2
            axes.text(right, -k + 0.43, f"{files(room)}", va="center", ha="right", fontsize=8, color=EDGE)
    axes.text(10, 1.05, "files", ha="right", va="bottom", fontsize=8, color=EDGE)
    axes.text(0, 1.05, "each room imports from those below it only", va="bottom", fontsize=9, color=INK)
    _finish(figure, axes, (-0.05, 10.05), (-len(rows) + 0.95, 1.45), path)


WAY = (
    ("query.py", "checks a question and writes it down once, as a Query", "asked"),
    ("contact/table.py", "kinds of the bodies: the room, and what it proves", "answers"),
    (
        "contact/endless, centred, reduce",
        "the question in a better place: an end for the span,\nsmall bodies near the origin, small meshes as solids",
        "answers",
    ),
    ("contact/<room>/first.py", "the ways to an answer, in order (contact/ways.py)", "answers"),
)
WAYS = (
    ("in doubles", "kernels with error bounds\nsearch/, kernels/", "finds"),
    ("exactly", "polynomials and their roots\npairs/, exact/", "knows"),
    ("what doubles proved", "the rest: UNDECIDED from\na proved time on", "answers"),
)
ANSWER = (
    "FirstContact, ContactIntervals",
    "status, time_interval, free_until, elements, point, normal;\n"
    "stats.ways: which ways were asked, what each told, how long",
    "ground",
)


def draw_way(path: Path) -> None:
    pyplot = _pyplot()
    figure, axes = pyplot.subplots(figsize=(9, 5.2))
    for k, (name, says, floor) in enumerate(WAY):
        _station(axes, -1.15 * k, name, says, floor)
        _arrow(axes, (4.4, -1.15 * k), (4.4, -1.15 * k - 0.33))
    base = -1.15 * len(WAY) - 0.35
    for i, (name, says, floor) in enumerate(WAYS):
        _box(axes, 3.1 * i, base, 2.6, 1.0, SHADES[floor])
        axes.text(3.1 * i + 1.3, base + 0.76, name, ha="center", va="center", fontsize=9, weight="bold", color=INK)
        axes.text(3.1 * i + 1.3, base + 0.33, says, ha="center", va="center", fontsize=7.5, color=INK)
        if i:
            _arrow(axes, (3.1 * i - 0.47, base + 0.5), (3.1 * i - 0.03, base + 0.5))
            axes.text(3.1 * i - 0.25, base + 0.62, "passed", ha="center", fontsize=6.5, color=INK)
        _arrow(axes, (3.1 * i + 1.3, base), (3.1 * i + 1.3, base - 0.36))
    _station(axes, base - 1.2, *ANSWER)
    _finish(figure, axes, (-0.1, 8.95), (base - 1.3, 1.0), path)


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def _station(axes: Any, y: float, name: str, says: str, floor: str) -> None:
    _box(axes, 0, y, 8.8, 0.8, SHADES[floor])
    axes.text(0.2, y + 0.4, name, va="center", fontsize=9, weight="bold", family="monospace", color=INK)
    axes.text(4.3, y + 0.4, says, va="center", fontsize=7.5, color=INK)


def _box(axes: Any, x: float, y: float, width: float, height: float, colour: str) -> None:
    from matplotlib.patches import FancyBboxPatch

    shape = "round,pad=0,rounding_size=0.08"
    box = FancyBboxPatch((x, y), width, height, boxstyle=shape, facecolor=colour, edgecolor=EDGE, linewidth=0.8)
    axes.add_patch(box)


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 0.9})


def _wrapped(text: str, width: int) -> str:
    import textwrap

    return "\n".join(textwrap.wrap(text, max(width, 12))[:3])


def _finish(figure: Any, axes: Any, x: tuple[float, float], y: tuple[float, float], path: Path) -> None:
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    axes.axis("off")
    figure.savefig(path, dpi=130, bbox_inches="tight", metadata={"Software": None})


if __name__ == "__main__":
    draw_house(HERE / "house.png")
    draw_way(HERE / "way.png")
