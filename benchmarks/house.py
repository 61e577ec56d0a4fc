"""What the house is like to live in: files that one question passes, and counts over the sources.

    python benchmarks/house.py                  one column, of the package that Python imports
    python benchmarks/house.py --json before.json
    python benchmarks/house.py --before before.json --report benchmarks/HOUSE.md

A question is asked twice, of bodies that are made before; the files of the package whose functions the second one calls
are counted.  Run it with PYTHONPATH set to the src of an older checkout for the column of that commit.
"""

from __future__ import annotations

import argparse
import ast
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import firstcontact as fc

ROOT = Path(fc.__file__).parent
LONG = 60
VERBS = "first_contact", "contact_intervals", "contact_pairs", "intersection_curve"
BODIES = {"Polyhedron", "CompositeQuadric", "RuledSurface", "RuledStrip", "Torus"}
MOTIONS = {"Translation", "Rotation", "Screw", "RationalMotion", "Sequence", "Trajectory"}
HEADER = """# The house, measured

`python benchmarks/house.py --before BEFORE.json --report benchmarks/HOUSE.md` writes this page. Files: those of the
package whose functions the second of two equal questions calls, the bodies being made before.

"""


# -- files that a question passes ---------------------------------------------------------------------------


def questions() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Names and first contacts of bodies that meet."""
    above, saddle = (0.3, 0.2, 5), fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
    box, can = fc.examples.box((2, 2, 2)), fc.cylinder(1, 2)
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
    sides = [[k, j, j + 6, k + 6] for k in range(6) for j in [(k + 1) % 6]]
    angle = fc.Polyhedron(corners, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides])
    pairs = {
        "meshes": (box, box), "models": (fc.sphere(1), can), "mesh, model": (angle, can), "ruled": (saddle, saddle),
        "ruled, mesh": (saddle, box), "ruled, model": (saddle, can),
    }  # fmt: skip
    motions = {
        "translation": fc.Translation((0.1, 0, -10)),
        "rotation": fc.Rotation((1, 0, 0), (0, 4, 2), degrees=90),
        "screw": fc.Screw((0, 0, -1), degrees=50, advance=8),
    }
    for pair, (a, b) in pairs.items():
        for motion, m in motions.items():
            moving = a.translated(above).moving(m)
            yield f"{pair}, {motion}", lambda moving=moving, b=b: fc.first_contact(moving, b)  # type: ignore[misc]


def files_passed(ask: Callable[[], Any]) -> list[str]:
    ask()
    seen: dict[str, None] = {}

    def look(frame: Any, event: str, _: Any) -> None:
        name = frame.f_code.co_filename
        if event == "call" and name.startswith(str(ROOT)):
            seen.setdefault(str(Path(name).relative_to(ROOT)))

    sys.setprofile(look)
    try:
        ask()
    finally:
        sys.setprofile(None)
    return list(seen)


# -- counts over the sources --------------------------------------------------------------------------------


def counts() -> dict[str, int]:
    found: Counter[str] = Counter()
    catching = set()
    for path in sorted(ROOT.rglob("*.py")):
        text = path.read_text()
        tree = ast.parse(text)
        found["files"] += 1
        found["lines"] += text.count("\n")
        in_body = "body" in path.relative_to(ROOT).parts[:1]
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                found["functions"] += 1
                found[f"functions over {LONG} lines"] += (node.end_lineno or 0) - node.lineno >= LONG
                found["signatures with Any"] += _says_any(node)
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
                named = {n.id for n in ast.walk(node.args[1]) if isinstance(n, ast.Name)}
                found["isinstance on bodies"] += bool(named & BODIES)
                found["isinstance on motions"] += bool(named & MOTIONS)
            elif isinstance(node, ast.Attribute) and not in_body and _is_private(node):
                found["foreign private reads"] += 1
            elif isinstance(node, ast.ExceptHandler) and node.type is not None:
                if any(isinstance(n, ast.Name) and n.id == "UnsupportedPair" for n in ast.walk(node.type)):
                    catching.add(path)
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and node.name in VERBS:
                found[f"definitions of {node.name}"] += 1
    found["files that catch UnsupportedPair"] = len(catching)
    found["class names used twice"] = len(names_used_twice())
    return dict(found)


def names_used_twice() -> set[str]:
    """Those of classes."""
    trees = (ast.parse(path.read_text()) for path in ROOT.rglob("*.py"))
    names = Counter(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    return {name for name, n in names.items() if n > 1}


def _says_any(node: ast.FunctionDef) -> bool:
    a = node.args
    every = [*a.posonlyargs, *a.args, *a.kwonlyargs, *(x for x in (a.vararg, a.kwarg) if x is not None)]
    said = [x.annotation for x in every if x.annotation is not None] + ([node.returns] if node.returns else [])
    return any(isinstance(n, ast.Name) and n.id == "Any" for x in said for n in ast.walk(x))


def _is_private(node: ast.Attribute) -> bool:
    """Of another object than self and cls; `_replace` is how named tuples call it."""
    if not node.attr.startswith("_") or node.attr.startswith("__") or node.attr == "_replace":
        return False
    return not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls"))


# -- the page -----------------------------------------------------------------------------------------------


def report(now: dict[str, int], before: dict[str, int]) -> str:
    head = "| what | before | now |\n|---|--:|--:|\n" if before else "| what | now |\n|---|--:|\n"
    rows = []
    for what, value in now.items():
        cells = [what, *([str(before.get(what, ""))] if before else []), str(value)]
        rows.append("| " + " | ".join(cells) + " |")
    return HEADER + head + "\n".join(rows) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--before", type=Path)
    parser.add_argument("--report", type=Path)
    parser.add_argument("--names", action="store_true", help="tell the files")
    arguments = parser.parse_args()
    now = {}
    for name, ask in questions():
        files = files_passed(ask)
        now[f"files: {name}"] = len(files)
        if arguments.names:
            print(name, *files, sep="\n  ")
    now |= counts()
    if arguments.json:
        arguments.json.write_text(json.dumps(now, indent=1))
    before = json.loads(arguments.before.read_text()) if arguments.before else {}
    text = report(now, before)
    if arguments.report:
        arguments.report.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
