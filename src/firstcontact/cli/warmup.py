"""`firstcontact warmup`: compile everything once."""

from __future__ import annotations

import logging
import sys
import time

import click


@click.command()
@click.option("--progress/--no-progress", default=None, help="Progress on stderr (default: on a tty)")
def warmup(progress: bool | None) -> int:
    """Compile everything once, so that later runs start at once.

    A wheel brings all kernels compiled: then this says that there is nothing to do.
    """
    logging.getLogger("firstcontact").setLevel(logging.WARNING)  # that kernels are compiled is no news here
    begun = time.perf_counter()
    compiled = _warm(sys.stderr.isatty() if progress is None else progress)
    if compiled:
        click.echo(f"ready after {time.perf_counter() - begun:.1f} s: {compiled} kernels compiled")
    else:
        click.echo("nothing to do: all kernels are compiled")
    return 0


def _warm(shows: bool) -> int:
    """How many kernels had to be compiled."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from firstcontact.warmup import cores, questions, warm_together

    columns = BarColumn(20), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}")
    with Progress(*columns, console=Console(stderr=True), transient=sys.stderr.isatty(), disable=not shows) as bar:
        task = bar.add_task("starts", total=len(questions()))
        return warm_together(cores(), lambda done: bar.update(task, advance=1, description=done))
