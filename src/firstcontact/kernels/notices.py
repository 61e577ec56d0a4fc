"""A word before kernels are compiled, in the log of the package: which, why and for how long."""

from __future__ import annotations

import logging

LOG = logging.getLogger("firstcontact")

FAMILIES = {
    "kernels.curves.": ("intersection curves", 20),
    "kernels.events.": ("curved and ruled bodies", 20),
    "kernels.convex.": ("convex curved bodies", 20),
    "body.polyhedron.": ("meshes", 20),
    "search.": ("meshes", 20),
    "kernels.lifted.": ("meshes", 20),
}
"""By the modules that Python calls first: what their kernels are for, and seconds that compiling all of them takes."""

_announced: set[str] = set()


def announce(kernel: str, versions: str, foreign: str) -> None:
    """Say, once for each family and process, that `kernel` and its like are compiled now.

    foreign: what the kernels that came with the package are for, where that is not `versions`.  This one is a warning,
    which shows wherever nobody asked for silence; the first run from a checkout is a piece of information.
    """
    module = kernel.removeprefix("firstcontact.")
    family, seconds = next((told for start, told in FAMILIES.items() if module.startswith(start)), ("", 0))
    if not family or family in _announced:
        return
    why = f"the kernels shipped are for {foreign}, this is {versions}: " if foreign and not _announced else ""
    _announced.add(family)
    LOG.log(
        logging.WARNING if why else logging.INFO,
        "%scompiling the kernels for %s, about %d s, once on this machine", why, family, seconds,
    )  # fmt: skip
