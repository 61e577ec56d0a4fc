"""Start-up of a wheel in a fresh environment: installation, first question of each family, import; writes STARTUP.md.

    python benchmarks/startup.py [--out DIR]

Wall seconds, and those of the processor beside them: a busy machine makes the former alone much longer.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

ROOT = Path(__file__).resolve().parent.parent
FIRST = ("check", "examples/lid.toml")
FAMILIES = {
    "meshes, exact numbers": ("check", "examples/cubes.toml"),
    "meshes, a sequence": ("check", "examples/lift.toml"),
    "curved solids": ("check", "examples/plunger.toml"),
    "curved solids, intervals": ("intervals", "examples/plunger.toml"),
    "ruled surfaces": ("check", "examples/roof.toml"),
    "ruled surfaces, intervals": ("intervals", "examples/roller.toml"),
    "intersection curve": ("curve", "examples/cone.toml"),
    "intersection curve of NURBS": ("curve", "examples/roof.toml"),
}
IMPORT = "from time import perf_counter as t; b = t(); import firstcontact; print(t() - b)"
MEGABYTE = 1e6
Row = tuple[str, str, str]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks")
    out = parser.parse_args().out
    with tempfile.TemporaryDirectory() as folder:
        rows = list(_rows(Path(folder)))
    table = ["| what | measured | bar |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    machine = f"{os.cpu_count()} processors, {platform.system()} {platform.machine()}"
    where = f"on {machine}, Python {platform.python_version()}; no kernel was compiled before"
    head = f"# Start-up\n\nBy `python benchmarks/startup.py`, {where}.\n\n"
    (out / "STARTUP.md").write_text(head + "\n".join(table) + "\n", encoding="utf-8")


def _rows(folder: Path):
    """The table's rows, in the order in which they are measured."""
    subprocess.run([sys.executable, "-m", "venv", folder / "checkout"], check=True)
    subprocess.run([sys.executable, "-m", "venv", folder / "wheel"], check=True)
    wall, cpu = _timed(folder / "checkout/bin/python", "-m", "pip", "install", "-q", ".")
    first, first_cpu = _asked(folder, "checkout", FIRST)
    yield "`pip install .` and its first `check`", _both(wall + first, cpu + first_cpu), "60 s on two idle processors"
    _timed(folder / "checkout/bin/python", "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder / "dist", ".")
    (built,) = (folder / "dist").glob("*.whl")
    yield "size of the wheel", f"{built.stat().st_size / MEGABYTE:.1f} MB", "15 MB"
    wall, cpu = _timed(folder / "wheel/bin/python", "-m", "pip", "install", "-q", built)
    yield "installation of the wheel", _both(wall, cpu), ""
    yield "its first `check`", _both(*_asked(folder, "wheel", FIRST)), "2 s"
    again = [_asked(folder, "wheel", FIRST) for _ in range(5)]
    yield "the same, again", _both(*(median(times) for times in zip(*again, strict=True))), "1.2 s"
    for name, question in FAMILIES.items():
        yield f"first question, {name}", _both(*_asked(folder, "wheel", question)), "2 s"
    imports = [subprocess.check_output([folder / "wheel/bin/python", "-c", IMPORT], text=True) for _ in range(9)]
    yield "`import firstcontact`", f"{1000 * median(map(float, imports)):.1f} ms", "20 ms"
    yield "kernels compiled for all this", str(len(list(_cache(folder).rglob("*.nbc")))), "0"


def _asked(folder: Path, environment: str, question: tuple[str, str]) -> tuple[float, float]:
    return _timed(folder / environment / "bin/firstcontact", *question, FIRSTCONTACT_CACHE=str(_cache(folder)))


def _cache(folder: Path) -> Path:
    return folder / "cache"


def _timed(*command: str | Path, **more: str) -> tuple[float, float]:
    """Wall and processor's seconds of a command; exit codes 0 and 1 (free, contact) are answers."""
    begun, before = perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=ROOT, env=os.environ | more, stdout=subprocess.DEVNULL)
    wall, after = perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(map(str, command))} ended with {done.returncode}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _both(wall: float, cpu: float) -> str:
    return f"{wall:.1f} s ({cpu:.1f} s of the processor)"


if __name__ == "__main__":
    main()
