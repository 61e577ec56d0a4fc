"""The one decorator that compiles kernels.

Numba's disk cache does not notice edits in another file that a cached function calls, so all kernels of the
library share a cache folder named by a digest of the sources of all kernels, of the constants that they use, and of
the numba and numpy versions.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import njit
from numba.core.compiler_lock import global_compiler_lock

try:
    import fcntl
except ImportError:  # Windows: processes that start together may compile the same kernel twice
    fcntl = None  # type: ignore[assignment]

_PACKAGE = Path(__file__).resolve().parent.parent
_PARTS = (
    "body/polyhedron", "kernels", "motion/relative/cells.py", "pairs/elements", "search/levels",
    "search/lifted", "search/sweep", "search/trees",
)  # fmt: skip


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


def sources() -> list[Path]:
    """Files that hold kernels, or constants that kernels use."""
    parts = [_PACKAGE / part for part in _PARTS]
    return sorted(file for part in parts for file in ([part] if part.suffix else part.rglob("*.py")))


def _digest() -> str:
    h = hashlib.sha256(f"{numba.__version__} {np.__version__}".encode())
    for file in sources():
        h.update(file.read_bytes())
    return h.hexdigest()[:24]


CACHE = _user_cache() / _digest()
_held: set[str] = set()
"""Kernels that this process compiles at this moment."""


def kernel(function: Callable[..., Any], allocates: bool = True, entry: bool = True) -> Any:
    """Compile `function` on its first call, cached on disk.  No fastmath: it would undo the error bounds.

    entry: for Python to call it; None is made for C, which would add to the time that compiling takes.
    """
    config: Any = numba.config
    compiled: Any = njit
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(CACHE)
    try:  # _nrt is always said: kernels called would take it over from their callers
        dispatcher = compiled(
            cache=True, nogil=True, error_model="numpy", _nrt=allocates,
            no_cfunc_wrapper=True, no_cpython_wrapper=not entry,
        )(function)  # fmt: skip
    finally:
        config.CACHE_DIR = previous
    compile_or_load, name = dispatcher.compile, f"{function.__module__}.{function.__qualname__}"

    def alone(signature: Any) -> Any:
        # the lock of threads first: none of them waits for a file that another one of its process holds, and
        # processes wait for each other along calls only, which make no ring
        with global_compiler_lock, _no_other_process(name):
            return compile_or_load(signature)

    dispatcher.compile = alone
    return dispatcher


@contextmanager
def _no_other_process(kernel: str) -> Iterator[None]:
    """Processes that start together compile a kernel once: the others wait, and find it in the cache."""
    if fcntl is None or kernel in _held:
        yield
        return
    try:
        CACHE.mkdir(parents=True, exist_ok=True)
        file = os.open(CACHE / f"{kernel}.lock", os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:  # a cache that cannot be written to is none that anybody waits for
        yield
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX)
        _held.add(kernel)
        yield
    finally:
        _held.discard(kernel)
        fcntl.flock(file, fcntl.LOCK_UN)  # said, as a process forked meanwhile has the file open too
        os.close(file)


def uncounted(function: Callable[..., Any]) -> Any:
    """`kernel` for what allocates nothing (Numba sees to it): no counts of references to arrays, half a walk's time."""
    return kernel(function, allocates=False)


def inner(function: Callable[..., Any]) -> Any:
    """`uncounted`, for kernels alone to call: without the entry for Python, a sixth of what compiling takes.

    Called from Python it crashes the interpreter.
    """
    return kernel(function, allocates=False, entry=False)


def is_compiled(module: str = "") -> bool:
    """Whether the cache folder of this version holds anything yet; module: of this one, as "curves/cells"."""
    folder, _, name = module.rpartition("/")  # Numba puts the kernels of a folder in one of that name and a digest
    return CACHE.is_dir() and any(CACHE.glob(f"{folder}*/{name}*.nbi"))
