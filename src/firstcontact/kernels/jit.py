"""The one decorator that compiles kernels."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from typing import Any, TypeVar, cast

from numba import njit
from numba.core.compiler_lock import global_compiler_lock
from numba.core.sigutils import normalize_signature
from numba.core.types import Type, unliteral
from numba.extending import overload

from firstcontact.kernels.cache import FOLDER, IMPLEMENTATIONS, KernelCache
from firstcontact.kernels.parts import KernelPart, PartOrWhole, compiling, keep_parts, within_another
from firstcontact.kernels.roomy import roomy

try:
    import fcntl
except ImportError:  # Windows: processes that start together may compile the same kernel twice
    fcntl = None  # type: ignore[assignment]

_held: set[str] = set()
"""Kernels that this process compiles at this moment."""


def kernel(function: Callable[..., Any], allocates: bool = True, inlined: bool = False) -> Any:
    """Compile `function` on its first call, cached on disk.  No fastmath: it would undo the error bounds.

    No entry is made for C, which would add to the time that compiling takes.
    """
    compiled: Any = njit  # its stubs know no _nrt
    dispatcher = compiled(  # _nrt is always said: kernels called would take it over from their callers
        nogil=True, error_model="numpy", _nrt=allocates, no_cfunc_wrapper=True, pipeline_class=PartOrWhole,
        forceinline=inlined,
    )(function)  # fmt: skip
    dispatcher._cache = KernelCache(dispatcher)
    name = f"{function.__module__}.{function.__qualname__}"
    compile_or_load, template, known = dispatcher.compile, dispatcher.get_call_template, dispatcher.overloads

    def alone(signature: object) -> object:
        # the lock of threads first: none of them waits for a file that another one of its process holds, and
        # processes wait for each other along calls only, which make no ring
        with global_compiler_lock, _no_other_process(name), compiling(dispatcher):
            arguments = normalize_signature(signature)[0]
            if not within_another() and arguments in known and isinstance(known[arguments].library, KernelPart):
                del known[arguments]
            return compile_or_load(signature) if within_another() else roomy(compile_or_load, signature)

    def of_numbers(arguments: Iterable[Type], named: Mapping[str, Type]) -> tuple[object, ...]:
        """Once for all numbers that callers write out, not once for each."""
        return template(tuple(map(unliteral, arguments)), {name: unliteral(kind) for name, kind in named.items()})

    dispatcher.compile, dispatcher.get_call_template = alone, of_numbers
    return keep_parts(dispatcher)


@contextmanager
def _no_other_process(kernel: str) -> Iterator[None]:
    """Processes that start together compile a kernel once: the others wait, and find it in the cache."""
    if fcntl is None or kernel in _held:
        yield
        return
    try:
        FOLDER.mkdir(parents=True, exist_ok=True)
        file = os.open(FOLDER / f"{kernel}.lock", os.O_RDWR | os.O_CREAT, 0o666)
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


def inlined(function: Callable[..., Any]) -> Any:
    """`uncounted` for a few lines that the inner loop of a walk calls with arrays: pushing these takes longer."""
    return kernel(function, allocates=False, inlined=True)


F = TypeVar("F", bound=Callable[..., object])


def with_signals(verb: F) -> F:
    """A verb that raises what a signal's handler raised as it was: while Numba hands over results, it becomes a
    SystemError."""
    @wraps(verb)
    def asked(*arguments: object, **named: object) -> object:
        try:
            return verb(*arguments, **named)
        except SystemError as error:
            cause: BaseException | None = error
            while isinstance(cause, SystemError):
                cause = cause.__cause__ or cause.__context__
            if cause is None:
                raise
            raise cause from None

    return cast("F", asked)


def implements(
    function: Callable[..., object], *dimensions: int, inlined: bool = False
) -> Callable[[Callable[..., object]], Callable[..., object]]:
    """`numba.extending.overload` for what the type of an argument `motion` chooses: arrays of so many dimensions.

    A kernel that comes to such a function has a `motion` of its own, which is the one handed down.  inlined: as the
    decorator of this name.
    """
    options: Any = {"forceinline": True} if inlined else {}

    def register(choice: Callable[..., object]) -> Callable[..., object]:
        for n in dimensions:
            IMPLEMENTATIONS[function, n] = choice, options
        return cast("Callable[..., object]", overload(function, jit_options=options)(choice))

    return register
