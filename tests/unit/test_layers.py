"""Who may import whom, and that every kernel compiles for one set of types only."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import firstcontact

PACKAGE = Path(firstcontact.__file__).parent
ABOVE_EXACT = (
    "body",
    "motion",
    "search",
    "pairs",
    "view",
    "cli",
    "io",
    "query",
    "scene",
    "scene_solids",
    "scene_values",
    "kernels",
    "report",
)


def module_of(file: Path) -> str:
    parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imports(file: Path, *, lazy: bool) -> set[str]:
    """Modules the file imports: anywhere (lazy), or when it is imported itself; never TYPE_CHECKING."""
    found: set[str] = set()

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            return
        if not lazy and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            return
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            found.add(node.module or "")
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
        if isinstance(node, ast.stmt | ast.Module | ast.ExceptHandler | ast.match_case):  # no expression imports
            for child in ast.iter_child_nodes(node):
                visit(child)

    visit(parsed(file))
    return found


@cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text())


def offenders(folder: str, forbidden: tuple[str, ...], *, lazy: bool = True) -> list[str]:
    files = sorted((PACKAGE / folder).rglob("*.py")) if (PACKAGE / folder).is_dir() else [PACKAGE / folder]
    assert files and all(f.exists() for f in files)
    return [
        f"{module_of(file)} imports {name}"
        for file in files
        for name in sorted(imports(file, lazy=lazy))
        if any(name == f or name.startswith(f + ".") for f in forbidden)
    ]


def inside(*names: str) -> tuple[str, ...]:
    return tuple(f"firstcontact.{name}" for name in names)


def test_exact_knows_no_arrays_and_nothing_above():
    assert not offenders("exact", ("numpy", "numba", "scipy", *inside(*ABOVE_EXACT)))


def test_exact_uses_of_the_results_only_its_numbers():
    used = {n for f in (PACKAGE / "exact").rglob("*.py") for n in imports(f, lazy=True) if ".result." in n}
    assert used <= {"firstcontact.result.AlgebraicNumber"}


def test_kernels_know_nothing_exact_and_nothing_above():
    above = inside("body", "motion", "search", "pairs", "view", "cli", "io", "exact", "query", "result", "scene")
    assert not offenders("kernels", ("flint", "fractions", *above))


@pytest.mark.parametrize("file", ["result.py", "errors.py"])
def test_records_and_errors_stand_alone(file):
    assert not offenders(file, ("firstcontact",), lazy=False)


def test_pairs_do_not_know_bodies_trees_or_motions():
    assert not offenders("pairs", inside("body", "motion", "search", "view", "cli", "query", "result", "scene"))


def test_nobody_imports_pages_or_commands_when_imported():
    for file in sorted(PACKAGE.rglob("*.py")):
        own = file.relative_to(PACKAGE).parts[0]
        if own == "__main__.py":  # runs the command, and is imported by nobody
            continue
        banned = [f"firstcontact.{n}" for n in ("view", "cli") if n != own and not (own == "cli" and n == "view")]
        late = imports(file, lazy=False)
        assert not [n for n in late if any(n == b or n.startswith(b + ".") for b in banned)], file


def test_importing_the_package_loads_nothing_heavy():
    heavy = ("numpy", "numba", "flint", "trimesh")
    assert fresh_python(f"import sys, firstcontact; print([m for m in {heavy} if m in sys.modules])") == "[]"


def fresh_python(code: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


QUERIES = """
import importlib, json, pkgutil
import numpy as np
import firstcontact as fc
from numba.core.dispatcher import Dispatcher
from numba.core.types import unliteral

rng = np.random.default_rng(1)
def soup(n, at):
    p = rng.uniform(-1, 1, (n, 3, 3)) + np.array(at, float)
    return fc.Polyhedron(p.reshape(-1, 3), np.arange(3 * n).reshape(n, 3), solid=False)
a, b = soup(20, (0, 0, 0)), soup(20, (4, 0, 0))
box, ball = fc.examples.box((1, 1, 1)), fc.examples.box((3, 3, 3))
for x, y, motion in (
    (a, b, fc.Translation((5, 0, 0))),
    (a, b, fc.Rotation((0, 0, 1), point=(2, 0, 0), turns=1)),
    (a, b, fc.Rotation((1, 2, 3), point=(2, 0, 0), turns=1)),
    (box, ball, fc.Translation((1, 0, 0))),
    (box.translated((5, 0, 0)), ball, fc.Rotation((0, 1, 1), turns="1/3")),
    (a, b, fc.Screw((1, 2, 3), turns=1, advance=5)),
    (a, b, fc.RationalMotion([np.eye(4), [[0, 0, 0, 5], [0] * 4, [0] * 4, [0] * 4]])),
):
    fc.first_contact(x.moving(motion), y)
    fc.contact_intervals(x.moving(motion), y)
found = {}
for info in pkgutil.walk_packages(fc.__path__, "firstcontact."):
    if info.name.split(".")[1] in ("kernels", "pairs", "search", "body"):
        for name, value in vars(importlib.import_module(info.name)).items():
            if isinstance(value, Dispatcher) and value.py_func.__module__ == info.name:
                found[f"{info.name}.{name}"] = len({tuple(map(unliteral, s)) for s in value.signatures})
print(json.dumps(found))
"""


def test_every_kernel_has_one_signature():
    """Three for the walks, whose motion argument has a type of its own for each kind of motion."""
    found = json.loads(fresh_python(QUERIES).splitlines()[-1])
    walks = {"firstcontact.search.trees.walk.walk", "firstcontact.search.trees.windows.collect"}
    assert len(found) > 40
    assert {name: found[name] for name in walks} == dict.fromkeys(walks, 3)
    assert {name: n for name, n in found.items() if n > 1 and name not in walks} == {}
    trees = ("tree._split", "tree._parts", "frame.refit")
    called = ("body.polyhedron.topology.derive_edges", *(f"search.trees.{name}" for name in trees))
    assert [found[f"firstcontact.{name}"] for name in called] == [1, 1, 1, 1]
