"""Measure firstcontact beside coal, ipctk, rapier3d and python-fcl; writes RESULTS.md and results.csv.

    python benchmarks/run.py [--sizes 1e3,1e4,1e5] [--meshes DIR] [--repeats 7] [--quick] [--only PATTERN]
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

from measure import PAIRED, ROOT, measure_scene, one_shots, peak_memory, start_up
from meshes import mesh_scenes
from peers import ADAPTERS
from report import BARS, Results, write_csv, write_markdown
from scenes import Scene, scenes
from worker import Worker

HERE = Path(__file__).resolve().parent
ONE_SHOT_TOOLS = ["firstcontact", "coal", "python-fcl"]


def main() -> None:
    options = _options()
    results = Results(command=_shown_command())
    # in a process of its own: compiling is no part of a preparation, nor of memory
    subprocess.run([sys.executable, "-c", "from firstcontact.warmup import warm; warm()"], check=True)
    workers = {tool: Worker(tool, options.limit) for tool in options.tools}
    try:
        for scene, pose, n in _chosen(options):
            print(f"{scene.name}, {pose}, n = {n}", file=sys.stderr, flush=True)
            skip = _too_slow(results, scene.name, pose, n)
            results.rows += measure_scene(scene, pose, n, workers, options.repeats, skip)
    finally:
        for worker in workers.values():
            worker.close()
    results.missing = [tool for tool in options.tools if tool not in workers]
    if 100_000 in options.sizes and not options.scenes_only:
        _at_full_size(results, options)
    if not options.scenes_only:
        results.start = start_up(ROOT / "examples" / "lid.toml")
    options.out.mkdir(parents=True, exist_ok=True)
    write_csv(results, options.out / "results.csv")
    write_markdown(results, options.out / "RESULTS.md")
    print(f"wrote {options.out / 'RESULTS.md'} and results.csv", file=sys.stderr)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="1e3,1e4,1e5", help="triangles per body, comma-separated")
    parser.add_argument("--meshes", type=Path, help="folder of mesh files to run into one another as well")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--quick", action="store_true", help="up to 1e4 triangles, 3 repeats, 5 s a query")
    parser.add_argument("--only", default="", help="regular expression; scenes whose name it is found in")
    known = ",".join(ADAPTERS)
    parser.add_argument("--tools", default=known, help=f"comma-separated, of: {known}")
    parser.add_argument("--limit", type=float, default=20.0, help="seconds for one query or preparation")
    parser.add_argument("--scenes-only", action="store_true", help="leave out one-shot, memory and start-up")
    parser.add_argument("--out", type=Path, default=HERE, help="folder for RESULTS.md and results.csv")
    options = parser.parse_args()
    options.sizes = [int(float(size)) for size in options.sizes.split(",")]
    options.tools = options.tools.split(",")
    unknown = sorted(set(options.tools) - set(ADAPTERS))
    if unknown:
        parser.error(f"unknown tool {unknown[0]!r}; there are {', '.join(ADAPTERS)}")
    if options.quick:
        options.sizes = [n for n in options.sizes if n <= 10_000]
        options.repeats, options.limit = min(3, options.repeats), min(5.0, options.limit)
    return options


def _chosen(options: argparse.Namespace) -> list[tuple[Scene, str, int]]:
    """(scene, pose, n) in the order of measurement."""
    found = []
    for n in options.sizes:
        for pose in ("built", "turned"):
            made = scenes(n, turned=pose == "turned").values()
            found += [(scene, pose, n) for scene in made if re.search(options.only, scene.name)]
    if options.meshes:
        made_from_files = [s for s in mesh_scenes(options.meshes) if re.search(options.only, s.name)]
        found += [(scene, "built", (len(scene.fa) + len(scene.fb)) // 2) for scene in made_from_files]
    return found


def _too_slow(results: Results, name: str, pose: str, n: int) -> set[str]:
    """Tools stopped at the limit in the same scene with fewer triangles."""
    smaller = [row for row in results.rows if (row.scene, row.pose) == (name, pose) and row.n < n]
    return {row.tool for row in smaller if row.note.startswith((">", "too slow")) and row.tool not in PAIRED}


def _at_full_size(results: Results, options: argparse.Namespace) -> None:
    """One-shot times and memory of the barred scenes at 1e5."""
    for name, scene in scenes(100_000).items():
        if name in BARS and re.search(options.only, name):
            print(f"one shot and memory: {name}", file=sys.stderr, flush=True)
            tools = [tool for tool in ONE_SHOT_TOOLS if tool in options.tools and tool not in results.missing]
            results.one_shot[name] = one_shots(scene, tools, options.limit)
            results.memory[name] = peak_memory(scene, options.limit)


def _shown_command() -> str:
    """The command without folders, which say nothing elsewhere."""
    shown, arguments = ["python", "benchmarks/run.py"], iter(sys.argv[1:])
    for argument in arguments:
        if argument.split("=")[0] in ("--meshes", "--out"):
            shown.append(argument.split("=")[0] + " DIR")
            if "=" not in argument:
                next(arguments, None)
        else:
            shown.append(argument)
    return " ".join(shown)


if __name__ == "__main__":
    main()
