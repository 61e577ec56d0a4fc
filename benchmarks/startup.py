"""Start-up of a wheel in a fresh environment: installation, first question of each family, import; writes STARTUP.md.

    python benchmarks/startup.py --before CHECKOUT [--out DIR]

Wall seconds, and those of the processor beside them: a busy machine makes the former alone much longer.  Beside
them what an older checkout takes on this machine: bars were set by what that one took on another.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
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
HEAD = """# Start-up

By `python benchmarks/startup.py --before CHECKOUT`, on {machine}; no kernel was compiled before.
"before" is commit 13f751b on the same machine. The bars are of one on which that commit took 35 s from its installation
to its first answer, with one family compiled, and 54 s of a processor to compile all families: here it takes
{slower:.1f} times as long to answer.

"""
SOURCE_BAR = f"60 s where that took 35 s: {60 / 35:.2f} times"
KERNELS_BAR = f"35 s where that took 54 s: {35 / 54:.2f} of it"
ASK = "-c", f"import sys; sys.path.append({str(Path(__file__).parent)!r}); import startup; startup.ask()"
Row = tuple[str, str, str, str]
Seconds = tuple[float, float]
"""By a clock, and of the processor."""
FromSource = tuple[Seconds, Seconds, float]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks")
    parser.add_argument("--before", type=Path, required=True, help="an older checkout")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        older = _from_source(given.before, Path(folder) / "before")
        rows = list(_rows(Path(folder), given.before, older))
    table = ["| what | before | now | bar |", "|---|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    machine = f"{os.cpu_count()} processors, {platform.system()} {platform.machine()}"
    head = HEAD.format(machine=f"{machine}, Python {platform.python_version()}", slower=older[0][0] / 35)
    (given.out / "STARTUP.md").write_text(head + "\n".join(table) + "\n", encoding="utf-8")


def _rows(folder: Path, before: Path, older: FromSource) -> Iterator[Row]:
    """The table's rows, in the order in which they are measured."""
    own = _from_source(ROOT, folder / "now")
    yield "`pip install .` and its first `check`", _both(older[0]), _both(own[0]), SOURCE_BAR
    wheel = folder / "now/wheel"
    subprocess.run([sys.executable, "-m", "venv", wheel], check=True)
    _timed(folder / "now/checkout/bin/python", "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder / "dist", ".")
    (built,) = (folder / "dist").glob("*.whl")
    yield "size of the wheel", "", f"{built.stat().st_size / MEGABYTE:.1f} MB", "15 MB"
    yield "installation of the wheel", "", _both(_timed(wheel / "bin/python", "-m", "pip", "install", "-q", built)), ""
    yield "its first `check`", "", _both(_asked(wheel, FIRST)), "2 s"
    again = [_asked(wheel, FIRST) for _ in range(5)]
    yield "second start of `check`", _both(older[1]), _both(_medians(again)), "1.2 s"
    for name, question in FAMILIES.items():
        yield f"first question, {name}", "", _both(_asked(wheel, question)), "2 s"
    yield "`import firstcontact`", f"{older[2]:.1f} ms", f"{_import(wheel):.1f} ms", "20 ms"
    yield "kernels compiled for all this", "", str(len(list(_cache(wheel).rglob("*.nbc")))), "0"
    old, new = (_compiling(source / "src", folder) for source in (before, ROOT))
    yield "every kernel, of the processor", f"{old:.0f} s", f"{new:.0f} s: {new / old:.2f} of it", KERNELS_BAR


def _from_source(checkout: Path, folder: Path) -> FromSource:
    """Of `pip install .` and the first `check`, of later ones, and the milliseconds of an import."""
    environment = folder / "checkout"
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    installed = _timed(environment / "bin/python", "-m", "pip", "install", "-q", ".", at=checkout)
    first = _asked(environment, FIRST)
    again = [_asked(environment, FIRST) for _ in range(5)]
    return (installed[0] + first[0], installed[1] + first[1]), _medians(again), _import(environment)


def _medians(times: list[Seconds]) -> Seconds:
    wall, cpu = (median(x) for x in zip(*times, strict=True))
    return wall, cpu


def _import(environment: Path) -> float:
    return 1000 * median(
        float(subprocess.check_output([environment / "bin/python", "-c", IMPORT], text=True, cwd=environment))
        for _ in range(9)
    )


def _compiling(source: Path, folder: Path) -> float:
    """Of every kernel: what the processor takes the first time less what it takes once they are there."""
    with tempfile.TemporaryDirectory(dir=folder) as cache:
        places = {"PYTHONPATH": str(source.resolve()), "FIRSTCONTACT_CACHE": cache, "XDG_CACHE_HOME": cache}
        first, again = (_timed(sys.executable, "-P", *ASK, **places)[1] for _ in range(2))
    return first - again


def ask() -> None:
    """Questions of every family, by the package on the path; an older `warmup` knows meshes and curves alone."""
    import firstcontact as fc
    from firstcontact.cli import run

    run(["warmup"])
    saddle, drilled = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)"), fc.cylinder(2, 1) - fc.cylinder(1, 3)
    solids = fc.sphere(1), fc.cylinder(1, 2), drilled
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
    sides = [[k, j, j + 6, k + 6] for k in range(6) for j in [(k + 1) % 6]]
    angle = fc.Polyhedron(corners, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides])
    motions = (
        fc.Translation((0.1, 0, -10)), fc.Rotation((1, 0, 0), (0, 4, 2), degrees=90),
        fc.Screw((0, 0, -1), degrees=50, advance=8),
        fc.Sequence([fc.Translation((0, 0, -5)), fc.Rotation((1, 2, 0), (1, 0, 1), degrees=100)]),
    )  # fmt: skip
    for a, b in [(x, y) for x in (saddle, angle, *solids) for y in (saddle, angle, *solids)]:
        for motion in motions:
            moving = a.translated((0.3, 0.2, 5)).moving(motion)
            with suppress(fc.UnsupportedPair):  # the older one refuses what this one answers
                fc.first_contact(moving, b)
                if a is saddle or a is angle:
                    fc.contact_intervals(moving, b)


def _asked(environment: Path, question: tuple[str, str]) -> Seconds:
    places = dict.fromkeys(("FIRSTCONTACT_CACHE", "XDG_CACHE_HOME"), str(_cache(environment)))
    return _timed(environment / "bin/firstcontact", *question, **places)


def _cache(environment: Path) -> Path:
    return environment / "cache"


def _timed(*command: str | Path, at: Path = ROOT, **more: str) -> Seconds:
    """Wall and processor's seconds of a command; exit codes 0 and 1 (free, contact) are answers."""
    begun, before = perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=at, env=os.environ | more, stdout=subprocess.DEVNULL)
    wall, after = perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(map(str, command))} ended with {done.returncode}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _both(seconds: Seconds) -> str:
    return f"{seconds[0]:.1f} s ({seconds[1]:.1f} s of the processor)"


if __name__ == "__main__":
    main()
