"""Compiled kernels on disk, named by what they are made of.

Numba's own cache names a kernel by path and time of its file and does not see edits of what it calls.  Here the name of
a compiled kernel holds a digest of its bytecode, of the constants that it reads and, in turn, of all kernels that it
calls, beside the signature and the processor: it is found from any checkout, an edit compiles what it touches alone,
and a folder of compiled kernels can be moved to another place or machine.

A wheel brings such a folder, compiled for every processor of its kind (`hatch_build.py`); what is not in it is looked
for in the user's own, compiled for the processor at hand.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import types
import uuid
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.dispatcher import Dispatcher
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps

from firstcontact.kernels.notices import announce
from firstcontact.kernels.parts import KernelPart, pieces_of, rebuilt, set_environments, within_another

if TYPE_CHECKING:
    from numba.core.compiler import CompileResult
    from numba.core.cpu import CPUContext
    from numba.core.types import Type

_OWN = __name__.partition(".")[0] + "."


def user_folder() -> Path:
    if override := os.environ.get("FIRSTCONTACT_CACHE"):
        return Path(override)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home())
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "firstcontact"


_READERS = (numba, llvmlite)
VERSIONS = "-".join((str(sys.implementation.cache_tag), *(f"{m.__name__}{m.__version__}" for m in _READERS)))
"""What reads compiled kernels must be what wrote them.  NumPy does not: they see arrays as Numba's own struct."""
FOLDER = user_folder() / VERSIONS
_ALL_SHIPPED = Path(__file__).with_name("compiled")
SHIPPED = _ALL_SHIPPED / VERSIONS
WHOLE, PART = ".nbc", ".part"
"""Files of kernels that Python calls, and of those that are there for other kernels to be compiled with."""
WRITING = 2
"""To be raised where files are laid out, or code is generated, in another way: those of before are not found then."""
PORTABLE = "generic", ""
"""Name and features of a processor that every one of its kind is."""


def foreign() -> str:
    """What the shipped kernels are for, where there are some and they are not for this interpreter, else nothing."""
    if SHIPPED.is_dir() or not _ALL_SHIPPED.is_dir():
        return ""
    return " or ".join(sorted(folder.name for folder in _ALL_SHIPPED.iterdir()))


LOADED: list[str] = []
COMPILED: list[str] = []
"""Names of the files that this process has read, and of those for which it had to compile."""


class KernelCache(_Cache):  # type: ignore[misc]
    """What Numba asks for compiled code of one kernel, and hands it to."""

    def __init__(self, kernel: Dispatcher) -> None:
        self._kernel = kernel
        self._name = f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}".replace("<", "").replace(">", "")
        self._enabled = True

    @property
    def cache_path(self) -> str:
        return str(FOLDER)

    def load_overload(self, sig: Sequence[Type], target_context: CPUContext) -> CompileResult | None:
        """Without `target_context.refresh()`: what code is made with is loaded where it is made, which takes as long as
        ten kernels from files."""
        rtsys.initialize(target_context)
        if not self._enabled:
            return None
        triple, *native = target_context.codegen().magic_tuple()
        suffixes = (WHOLE, PART) if within_another() else (WHOLE,)
        for folder, processor in ((SHIPPED, PORTABLE), (FOLDER, native)):
            file = self._file(folder, sig, triple, processor)
            for named in map(file.with_suffix, suffixes):
                try:
                    kept = named.read_bytes()
                except OSError:
                    continue
                LOADED.append(named.name)
                return rebuilt(target_context, pickle.loads(kept))
        announce(self._name, VERSIONS, foreign())
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        whole = not isinstance(data.library, KernelPart)
        if whole:
            set_environments(data)
        if not self._enabled:
            return
        if data.lifted or data.library.has_dynamic_globals:
            raise TypeError(f"kernel {self._name} cannot be kept: it holds lifted loops or addresses")
        triple, *native = data.codegen.magic_tuple()
        file = self._file(FOLDER, sig, triple, native).with_suffix(WHOLE if whole else PART)
        COMPILED.append(file.name)
        begun = file.with_name(f"{file.name}.{uuid.uuid4().hex[:16]}")
        try:
            FOLDER.mkdir(parents=True, exist_ok=True)
            begun.write_bytes(dumps(pieces_of(data)))
            os.replace(begun, file)  # whole or not at all
        except OSError:  # a folder that cannot be written to: compiled again in the next process
            begun.unlink(missing_ok=True)

    def _file(self, folder: Path, sig: Sequence[Type], triple: str, processor: Sequence[str]) -> Path:
        arguments = dict(zip(self._kernel.py_func.__code__.co_varnames, sig, strict=False))
        system = triple.rstrip("0123456789.")  # without the release that macOS adds
        kernel = fingerprint(self._kernel, getattr(arguments.get("motion"), "ndim", 0))
        made_of = WRITING, kernel, str(sig), system, *processor
        return folder / f"{self._name}-{hashlib.sha256(repr(made_of).encode()).hexdigest()[:24]}{WHOLE}"

    def enable(self) -> None:
        self._enabled = True

    def disable(self) -> None:
        self._enabled = False

    def flush(self) -> None:
        for file in FOLDER.glob(f"{self._name}-*"):
            file.unlink(missing_ok=True)


_fingerprints: dict[tuple[Dispatcher, int], str] = {}
_begun: list[Dispatcher] = []
IMPLEMENTATIONS: dict[tuple[Any, int], tuple[Callable[..., Any], dict[str, Any]]] = {}
"""What `jit.implements` names: of a function that the type of its `motion` chooses, that for arrays of n dimensions.

With its options.
"""


def fingerprint(kernel: Dispatcher, dimensions: int) -> str:
    """A digest of all that the kernel is made of: code, options, constants, kernels called.

    dimensions: of its argument `motion`, 0 without one.
    """
    if (known := _fingerprints.get((kernel, dimensions))) is not None:
        return known
    if kernel in _begun:
        if kernel is not _begun[-1]:
            raise TypeError(f"kernels that call each other in a ring have no digest: {_begun}")
        return "itself"
    _begun.append(kernel)
    try:
        digest = hashlib.sha256(repr(sorted(kernel.targetoptions.items())).encode())
        for part in _parts(kernel.py_func, dimensions):
            digest.update(part.encode())
    finally:
        _begun.pop()
    return _fingerprints.setdefault((kernel, dimensions), digest.hexdigest())


def _parts(function: Callable[..., object], dimensions: int) -> Iterator[str]:
    yield repr((function.__defaults__, function.__kwdefaults__))
    for cell in function.__closure__ or ():
        yield _told(cell.cell_contents, (), dimensions)
    for code in _codes(function.__code__):
        plain = [c for c in code.co_consts if not isinstance(c, types.CodeType) and c != function.__doc__]
        yield repr((code.co_code.hex(), code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, plain))
        for name in code.co_names:
            if name in function.__globals__:
                yield f"{name}={_told(function.__globals__[name], code.co_names, dimensions)};"


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _told(value: object, names: tuple[str, ...], dimensions: int) -> str:
    """A value that a kernel reads, as text; names: those that it may ask of a module."""

    def told(item: object) -> str:
        return _told(item, names, dimensions)

    if isinstance(value, Dispatcher):
        return fingerprint(value, dimensions)
    if isinstance(value, types.FunctionType) and value.__module__.startswith(_OWN):  # compiled into its callers
        chosen, options = IMPLEMENTATIONS.get((value, dimensions), (value, {}))
        return f"{value.__qualname__}({options}{','.join(_parts(chosen, dimensions))})"
    if isinstance(value, np.ndarray):
        return f"{value.dtype.descr} {value.shape} {value.tobytes().hex()}"
    if type(value) is tuple:
        return f"({','.join(map(told, value))})"
    if isinstance(value, types.ModuleType):
        if not value.__name__.startswith(_OWN):
            return value.__name__
        asked = {name: vars(value)[name] for name in names if name in vars(value)}
        return f"{value.__name__}({','.join(f'{name}={told(item)}' for name, item in asked.items())})"
    if isinstance(value, PLAIN):
        return repr(value)
    return f"{type(value).__name__} {getattr(value, '__qualname__', '')} {getattr(value, '_fields', '')}"


PLAIN = (int, float, complex, str, bytes, bool, np.generic, np.dtype, numba.types.Type, types.NoneType)
"""What is its text."""
