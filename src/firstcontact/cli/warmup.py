"""`firstcontact warmup`: compile everything once."""

from __future__ import annotations

import time

import click


@click.command()
def warmup() -> int:
    """Compile everything once, so that later runs start at once."""
    from firstcontact import warmup as kernels

    begun = time.perf_counter()
    kernels.warm(lambda step: click.echo(f"firstcontact: {step}", err=True))
    click.echo(f"ready after {time.perf_counter() - begun:.1f} s")
    return 0
