"""The one decorator that compiles kernels.

Numba's disk cache does not notice edits in another file that a cached function calls, so all kernels of the
library share a cache folder named by a digest of all kernel sources and of the numba and numpy versions.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import njit

_PACKAGE = Path(__file__).resolve().parent.parent


def _user_cache() -> Path:
    if override := os.environ.get("FIRSTCONTACT_CACHE"):
        return Path(override)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home())
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "firstcontact"


def _digest() -> str:
    h = hashlib.sha256(f"{numba.__version__} {np.__version__}".encode())
    for folder in ("body", "kernels", "pairs", "search"):
        for file in sorted((_PACKAGE / folder).glob("*.py")):
            h.update(file.read_bytes())
    return h.hexdigest()[:24]


CACHE = _user_cache() / _digest()


def kernel(function: Callable[..., Any], allocates: bool = True, entry: bool = True) -> Any:
    """Compile `function` on its first call, cached on disk.  No fastmath: it would undo the error bounds.

    entry: for Python to call it; None is made for C, which would add to the time that compiling takes.
    """
    config: Any = numba.config
    compiled: Any = njit
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(CACHE)
    try:  # _nrt is always said: kernels called would take it over from their callers
        return compiled(
            cache=True, nogil=True, error_model="numpy", _nrt=allocates,
            no_cfunc_wrapper=True, no_cpython_wrapper=not entry,
        )(function)  # fmt: skip
    finally:
        config.CACHE_DIR = previous


def uncounted(function: Callable[..., Any]) -> Any:
    """`kernel` for what allocates nothing (Numba sees to it): no counts of references to arrays, half a walk's time."""
    return kernel(function, allocates=False)


def inner(function: Callable[..., Any]) -> Any:
    """`uncounted`, for kernels alone to call: without the entry for Python, a sixth of what compiling takes.

    Called from Python it crashes the interpreter.
    """
    return kernel(function, allocates=False, entry=False)


def is_compiled(module: str = "") -> bool:
    """Whether the cache folder of this version holds anything yet, of the module where one is named."""
    return CACHE.is_dir() and any(CACHE.rglob(f"{module}*.nbi"))
