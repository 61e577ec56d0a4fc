"""What Numba does in vain while it compiles, left out.  It is left out for the whole process: for those of our own.

Every name of Numba's used here is of 0.68, which the package is pinned to.
"""

from __future__ import annotations

import gc

from firstcontact.kernels.thrift import code, effort, elements, steps


def apply() -> None:
    gc.disable()
    for part in (steps, effort, code, elements):
        part.apply()
