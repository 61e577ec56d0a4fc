"""How hard LLVM tries: as hard as it can for walks over trees, less for all others, which run as fast for it.

Measured: contact intervals under a screw would take a tenth longer; solids, ruled surfaces, lifted walks, sweeps and
trees of two levels take as long, within the noise.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from llvmlite import binding
from llvmlite.binding import TargetMachine
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary

from firstcontact.kernels.parts import complete
from firstcontact.kernels.thrift.replaced import put

WALKS = "search.trees.walk", "search.trees.windows", "search.trees.curve", "toolpath.walk"
LESS = 1

# How Numba begins the name of what Python enters: the lengths of words before them.
HARD = tuple(
    "".join(["_ZN7cpython12firstcontact", *(f"{len(word)}{word}" for word in module.split("."))]) for module in WALKS
)
_finalize: Any = JITCodeLibrary._finalize_specific


def apply() -> None:
    put(CPUCodeLibrary, _optimize_final_module=_optimize)
    put(JITCodeLibrary, _finalize_specific=_finalize_with_less)


def _is_walk(library: CPUCodeLibrary) -> bool:
    return any(function.name.startswith(HARD) for function in library._final_module.functions)


def _optimize(library: CPUCodeLibrary) -> None:
    """Numba optimizes a little first to find counts of references that cancel: in vain where nothing is counted."""
    complete(library)
    module, codegen = library._final_module, library._codegen
    stages: list[dict[str, object]] = [{} if _is_walk(library) else {"opt": LESS}]
    if any(function.name == "NRT_incref" for function in module.functions):
        stages.insert(0, {"opt": codegen._opt_level, "slp_vectorize": False, "cost": "cheap"})
    for options in stages:
        passes, builder = codegen._module_pass_manager(**options)
        passes.run(module, builder)


def _finalize_with_less(library: JITCodeLibrary) -> None:
    """Numba's way with machine code that is there already, which it takes for code from a file, and lets go of."""
    code = None
    if library._object_caching_enabled and not library._compiled_object and not _is_walk(library):
        code = library._compiled_object = _machine(library._codegen).emit_object(library._final_module)
    _finalize(library)
    if code is not None:
        library._compiled_object = code


@cache
def _machine(codegen: Any) -> TargetMachine:
    options = {"opt": LESS}
    codegen._customize_tm_options(options)
    machine: TargetMachine = binding.Target.from_triple(binding.get_process_triple()).create_target_machine(**options)
    return machine
