"""Whether a default query is about as quick as the quicker of its paths.

    python benchmarks/paths.py --scenes 2 --seed 1 --only ruled

Both verbs are asked of every scene by each method: known vectors of ruled surfaces, the examples, random scenes of all
families.  A question is asked in a process of its own, twice, of bodies made anew, and the second time counts: seconds
of the processor, nothing to load or to compile.  Rows over the bar are marked; the exit code is 1 where there are any.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]
import firstcontact as fc  # noqa: E402
import soak  # noqa: E402
from firstcontact.scene.load import load_scene  # noqa: E402
from ruled_vectors import vectors  # noqa: E402

METHODS = ("auto", "certified", "algebraic")
VERBS = (fc.first_contact, fc.contact_intervals)
FAMILIES = ("ruled", "solids", "mixed")
LIMIT = 30
"""Seconds of the processor, after which a question is ended."""
FACTOR, LEAST = 3.0, 0.05
"""The bar: times the quicker path that has an answer; seconds below which nothing is slow."""
Make = Callable[[], tuple[Any, Any, Any]]
"""Both bodies, anew, and the span."""


def scenes(options: argparse.Namespace) -> Iterator[tuple[str, Make]]:
    """All by name."""
    for v in vectors("moving"):
        yield f"vectors/{v.name}", lambda v=v: next((x.p, x.q, x.span) for x in vectors("moving") if x.name == v.name)
    for path in sorted((HERE.parent / "examples").glob("*.toml")):
        for k, check in enumerate(load_scene(path).checks):
            yield f"examples/{path.stem} {check.a}, {check.b}", lambda path=path, k=k: of_example(path, k)
    for kind in soak.load(list(FAMILIES)).values():
        for index in range(options.scenes):
            source = kind.make(Random(f"{options.seed}/{kind.name}/{index}")).source
            yield f"{kind.name} {index}", lambda source=source: of_source(source)


def of_example(path: Path, k: int) -> tuple[Any, Any, Any]:
    scene = load_scene(path)
    check = scene.checks[k]
    return scene.bodies[check.a], scene.bodies[check.b], check.span


def of_source(source: str) -> tuple[Any, Any, Any]:
    names: dict[str, Any] = {"fc": fc, "F": Fraction, "np": np}
    exec(source, names)
    return names["a"], names["b"], names["span"]


def asked(verb: Any, make: Make, method: str) -> tuple[float, str]:
    """(seconds, outcome) in a process of its own."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (2 * LIMIT, 2 * LIMIT))
        os.write(writer, json.dumps(answered(verb, make, method)).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    seconds, outcome = json.loads(text) if text else (float(LIMIT), "too long")
    return (seconds, outcome) if seconds < LIMIT else (float(LIMIT), "too long")


def answered(verb: Any, make: Make, method: str) -> tuple[float, str]:
    for _ in range(2):
        a, b, span = make()
        begin = time.process_time()
        try:
            outcome = verb(a, b, span, method=method).status.name
        except fc.FirstContactError:
            outcome = "refused"
        seconds = time.process_time() - begin
    return seconds, outcome


def is_slow(found: dict[str, tuple[float, str]]) -> bool:
    """Whether a path alone would have had the answer much sooner; one that is left open is none."""
    told = [seconds for seconds, outcome in found.values() if outcome not in ("refused", "UNDECIDED", "too long")]
    return bool(told) and found["auto"][0] > max(LEAST, FACTOR * min(told))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=1, help="random ones of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="scenes whose name begins so")
    options = parser.parse_args()
    count = 0
    print(f"| scene | verb | {' | '.join(METHODS)} | |\n|---|---|{'--:|' * len(METHODS)}---|")
    for name, make in scenes(options):
        for verb in VERBS if name.startswith(options.only) else ():
            found = {method: asked(verb, make, method) for method in METHODS}
            count += is_slow(found)
            cells = [f"{seconds:.3f} {outcome}" for seconds, outcome in found.values()]
            mark = "slow" if is_slow(found) else ""
            print(f"| {name} | {verb.__name__} | {' | '.join(cells)} | {mark} |", flush=True)
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
