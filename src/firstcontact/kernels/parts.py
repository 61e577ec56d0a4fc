"""Kernels that kernels call: compiled to be linked into their callers, without machine code of their own.

Numba makes an entry for Python and machine code of whatever it compiles, and all that a kernel calls is compiled into
it: without this, code n calls deep is made n times over.  What Python calls is compiled as ever, what a kernel comes to
while it is compiled is a part, which Python's first call of it makes whole.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from types import CodeType
from typing import TYPE_CHECKING, Any

from llvmlite import binding
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.environment import lookup_environment
from numba.core.typed_passes import NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes

if TYPE_CHECKING:
    from numba.core.codegen import CPUCodegen
    from numba.core.compiler_machinery import PassManager
    from numba.core.cpu import CPUContext
    from numba.core.environment import Environment

_begun: list[Dispatcher] = []
"""Kernels being compiled, each called by the one before it; under Numba's lock."""


@contextmanager
def compiling(kernel: Dispatcher) -> Iterator[None]:
    """Garbage is collected afterwards: to look for it among all that a compiler makes takes a tenth of its time."""
    collecting = gc.isenabled()
    gc.disable()
    _begun.append(kernel)
    try:
        yield
    finally:
        _begun.pop()
        if collecting:
            gc.enable()


def within_another() -> bool:
    """Is what is compiled now called by a kernel, rather than by Python?"""
    return len(_begun) > 1


class KernelPart(JITCodeLibrary):  # type: ignore[misc]
    """Code for callers to link; nothing has an address."""

    of_kernel = True

    def __init__(self, codegen: CPUCodegen, name: str) -> None:
        super().__init__(codegen, name)
        self.needs: list[KernelPart] = []
        """All that is called, by what is called too, to be linked into a whole beside this: not into each caller."""

    def finalize(self) -> None:
        """Leaves alone are linked; all is optimized once, in what Python calls."""
        libraries = list(dict.fromkeys(self._linking_libraries))
        if any(isinstance(library, KernelPart) and library.of_kernel for library in libraries):
            self.needs = [library for library in libraries if isinstance(library, KernelPart)]
            self._linking_libraries = [library for library in libraries if not isinstance(library, KernelPart)]
        super().finalize()

    def _optimize_final_module(self) -> None:
        complete(self)

    def _finalize_final_module(self) -> None:
        """As Numba's `_get_module_for_linking` says it, without a copy."""
        self._finalize_dynamic_globals()
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = "linkonce_odr"
        self._shared_module = self._final_module
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> tuple[str, str, list[bytes]]:
        return self.name, "bitcode", [part.bitcode for part in (self, *self.needs)]

    @cached_property
    def bitcode(self) -> bytes:
        code: bytes = self._get_module_for_linking().as_bitcode()
        return code

    @property
    def environments(self) -> list[Environment]:
        """Where its code looks for what it raises."""
        names = (variable.name for variable in self._get_module_for_linking().global_variables)
        found = (lookup_environment(name) for name in names if name.startswith("_ZN08NumbaEnv"))
        return [environment for environment in found if environment is not None and environment.can_cache()]


_link: Any = CPUCodeLibrary.add_linking_library


def _link_all(library: CPUCodeLibrary, other: CPUCodeLibrary) -> None:
    _link(library, other)
    if isinstance(other, KernelPart):
        library._linking_libraries += other.needs


def complete(library: CPUCodeLibrary) -> None:
    """Links again what holds functions that are declared only, until none is left that a linked library holds.

    LLVM leaves out what may be left out where nothing linked so far calls it, and callers may come later: in which
    order parts are linked depends on which of them were read from files.
    """
    tried: set[str] = set()
    while missing := {f.name for f in library._final_module.functions if f.is_declaration} - tried:
        tried |= missing
        for other in dict.fromkeys(library._linking_libraries):
            module = other._get_module_for_linking()
            if any(not f.is_declaration and f.name in missing for f in module.functions):
                library._final_module.link_in(module, preserve=True)


_optimize: Any = CPUCodeLibrary._optimize_final_module


def _optimize_complete(library: CPUCodeLibrary) -> None:
    complete(library)
    _optimize(library)


setattr(CPUCodeLibrary, "add_linking_library", _link_all)  # noqa: B010 (to mypy, methods are not assigned to)
setattr(CPUCodeLibrary, "_optimize_final_module", _optimize_complete)  # noqa: B010

_read: dict[bytes, KernelPart] = {}
"""Parts from files, by their code: callers of the same ones share them."""


def _part_of(context: CPUContext, name: str, code: bytes) -> KernelPart:
    if (part := _read.get(code)) is None:
        part = _read[code] = KernelPart(context.codegen(), name)
        part.bitcode = code
        part._shared_module = binding.parse_bitcode(code)
        part._finalized = True
    return part


class PartOrWhole(Compiler):  # type: ignore[misc]
    """Compiles what a kernel calls to a part."""

    whole_within = 1
    """So many kernels are being compiled where this one is what Python calls."""

    def __init__(
        self, typingctx: Any, targetctx: Any, library: Any, args: Any, return_type: Any, flags: Any, locals: Any
    ) -> None:
        part = len(_begun) > self.whole_within
        if part:
            library = KernelPart(targetctx.codegen(), "part")
            library.of_kernel = self.whole_within == 1
            library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, args, return_type, flags, locals)
        if part:  # of the context, which is this compilation's own copy: what Numba knows of +, * etc. is by flags
            self.state.targetctx.create_cpython_wrapper = _no_wrapper
            self.state.targetctx.get_executable = _nothing_to_call


    def define_pipelines(self) -> list[PassManager]:
        """Numba's, without steps that change nothing in a function that has no other in it and no array expressions."""
        (steps,) = super().define_pipelines()
        if not any(isinstance(constant, CodeType) for constant in self.state.func_id.code.co_consts):
            steps.passes = [step for step in steps.passes if step[0] not in _OF_CLOSURES]
        return [steps]


class PartOfCallers(PartOrWhole):
    """Compiles what is no kernel and called by one."""

    whole_within = 0


def keep_parts(dispatcher: Any) -> Any:
    """Where kernels find them: Python looks elsewhere."""
    add, known = dispatcher.add_overload, dispatcher.overloads

    def add_overload(result: Any) -> None:
        if isinstance(result.library, KernelPart):
            known[tuple(result.signature.args)] = result
        else:
            add(result)

    dispatcher.add_overload = add_overload
    return dispatcher


def for_callers(decorator: Any) -> Any:
    """`numba.jit`, for functions that are parts where kernels call them."""

    def with_options(**options: object) -> Any:
        decorate = decorator(**options, pipeline_class=PartOfCallers)
        return lambda function: keep_parts(decorate(function))

    return with_options


_OF_CLOSURES = {InlineClosureLikes, NopythonRewrites}


def _no_wrapper(*_: object, **__: object) -> None:
    pass


def _nothing_to_call(library: KernelPart, fndesc: object, env: object) -> object:
    """What stands for the part where Numba looks up kernels by what Python calls."""
    library._ensure_finalized()
    return object()


def rebuilt(context: Any, kept: tuple[Any, ...]) -> Any:
    """What was compiled, from its pieces as `CompileResult._reduce` gives them."""
    result: Any = CompileResult  # Numba makes its fields where nobody can see them
    (name, kind, code), fndesc, environment, signature, objectmode, lifted, typeann, reload_init, environments = kept
    if kind != "bitcode":
        return result._rebuild(context, *kept)
    for again in reload_init:
        again()
    library, *needs = (_part_of(context, name, each) for each in code)
    library.needs = needs
    return result(
        typing_context=context.typing_context, target_context=context, entry_point=object(), typing_error=None,
        type_annotation=typeann, signature=signature, objectmode=objectmode, lifted=lifted, fndesc=fndesc,
        library=library, call_helper=None, environment=environment, metadata=None, reload_init=reload_init,
        referenced_envs=environments,
    )  # fmt: skip


def pieces_of(compiled: Any) -> tuple[Any, ...]:
    """What `rebuilt` takes, of what was compiled."""
    kept: tuple[Any, ...] = compiled._replace(type_annotation="")._reduce()
    if not isinstance(compiled.library, KernelPart):
        return kept
    parts = compiled.library, *compiled.library.needs
    return *kept[:-1], tuple(environment for part in parts for environment in part.environments)


def set_environments(whole: Any) -> None:
    """Where the code of parts looks for what it raises: told to each whole that they are linked into."""
    for environment in whole._find_referenced_environments():
        whole.library.codegen.set_env(environment.env_name, environment)
