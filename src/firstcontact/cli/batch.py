"""`firstcontact batch`: queries from a file, answers to a file."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

import click

from firstcontact.cli import common
from firstcontact.cli.outputs import Outputs
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from firstcontact.batch.cluster import Cluster
    from firstcontact.batch.files import Summary
    from firstcontact.body.kinds import Body

REACHED_WITHIN = 15
"""Seconds in which a scheduler has to answer."""


@click.command()
@click.argument("queries")
@click.option("--bodies", metavar="SCENE", required=True,
              help="A scene file, whose bodies are asked about by their keys.")  # fmt: skip
@click.option("--out", metavar="F", required=True, help="Answers, one row for each query: .parquet, .csv or .jsonl.")
@click.option("--workers", type=click.IntRange(1, 1024), metavar="N", help="Cores that take part (default: all).")
@click.option("--scheduler", metavar="ADDRESS", help="A cluster of dask.distributed: tcp://host:8786.")
@click.option("--exact", is_flag=True, help="Decide in exact arithmetic.")
@click.option("--budget", type=click.IntRange(1), metavar="N", help="Node visits and pair tests of one query.")
@click.option("--progress/--no-progress", default=None, help="Progress on stderr (default: on a tty)")
def batch(
    queries: str,
    bodies: str,
    out: str,
    workers: int | None,
    scheduler: str | None,
    exact: bool,
    budget: int | None,
    progress: bool | None,
) -> int:
    """Answer a file of queries: .parquet, .csv or .jsonl.

    A row names two bodies, a and b, and if body a is to move, how: vx, vy, vz; or ax, ay, az with degrees (radians,
    turns) and px, py, pz; or pose0, pose1.  t0, t1 are its span; other columns are carried along.  What is finished is
    kept in OUT.parts: after an interrupt, or a crash, the same command goes on from there.
    """
    from firstcontact.batch.arrow import pyarrow
    from firstcontact.batch.files import answer_file
    from firstcontact.cli.progress import RowsProgress
    from firstcontact.scene.load import load_scene

    written = Outputs({"--out": out}, [queries, bodies])
    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers and --scheduler: choose one; a cluster has its own workers.")
    pyarrow()
    scene = load_scene(bodies)
    written.refuse_read(scene.files)
    begun = time.monotonic()
    with ExitStack() as stack:
        executor = None if scheduler is None else _cluster(scheduler, stack)
        stack.enter_context(written)
        shown = RowsProgress(progress, queries, written.say)
        stack.enter_context(shown)
        if scheduler is not None:
            stack.enter_context(_while_it_is_there(scheduler))
        summary = answer_file(
            queries, scene.bodies, out, arguments={"exact": exact, "budget": budget},
            workers=workers, executor=executor, progress=shown.rows,
        )  # fmt: skip
        written.say(_told(summary, time.monotonic() - begun))
    return common.exit_code(["UNDECIDED" if status == "error" else status for status in summary.counts])


def _cluster(address: str, stack: ExitStack) -> Callable[[tuple[Body, ...]], Cluster]:
    """What makes the cluster's workers ready for bodies."""
    from firstcontact.batch import arrow

    arrow.module("distributed")
    from distributed import Client

    from firstcontact.batch.cluster import Cluster

    for name in ("distributed", "distributed.client"):  # what there is to tell is told in one line
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = stack.enter_context(Client(address, timeout=REACHED_WITHIN, set_as_default=False))
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {address}: no answer within {REACHED_WITHIN} s; is it running?") from error
    return lambda bodies: Cluster(client, bodies)


@contextmanager
def _while_it_is_there(address: str) -> Iterator[None]:
    """A scheduler that is lost ends the job; what is finished is kept."""
    from firstcontact.batch.cluster import LOST

    lost: tuple[type[Exception], ...] = (OSError, *LOST)
    try:
        yield
    except lost as error:
        raise InputError(f"--scheduler {address}: lost; start it again, and the same command goes on") from error


def _told(summary: Summary, seconds: float) -> str:
    """Counts, the rows with most work, those that are undecided, and errors."""
    counts = ", ".join(f"{n:,} {status}" for status, n in summary.counts.most_common())
    lines = [f"{summary.path}: {summary.rows:,} queries in {seconds:.1f} s: {counts}"]
    most = ", ".join(f"row {row} ({work:,} steps)" for work, row in summary.work if work)
    if most:
        lines.append(f"  most work: {most}")
    n = summary.counts["UNDECIDED"]
    if n:
        rows = ", ".join(map(str, summary.undecided))
        lines.append(f"  undecided: row{'s' * (n > 1)} {rows}{' ...' * (n > len(summary.undecided))}")
    lines += [f"  error: row {row}: {text}" for row, text in summary.errors]
    return "\n".join(lines)
