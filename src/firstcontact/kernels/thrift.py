"""What Numba does in vain while it compiles, left out.  It is left out for the whole process: for those of our own."""

from __future__ import annotations

from typing import Any

from numba.core.codegen import CPUCodeLibrary
from numba.core.targetconfig import TargetConfig

_equal: Any = TargetConfig.__eq__


def apply() -> None:
    config: Any = TargetConfig
    library: Any = CPUCodeLibrary
    config.__eq__, config.__hash__ = _equal_options, _hash_of_options
    library._optimize_functions = _optimize_functions


def _equal_options(one: Any, other: Any) -> Any:
    """Options are compared whenever an operator is looked up: by those that are set, where these agree."""
    return (isinstance(other, TargetConfig) and one._values == other._values) or _equal(one, other)


def _hash_of_options(one: Any) -> int:
    """Numba's is of their names alone."""
    return hash(type(one))


def _optimize_functions(library: Any, module: Any) -> None:
    """Those that are there: Numba prepares as much for each that is only declared."""
    module.data_layout = library._codegen._data_layout
    for function in module.functions:
        if not function.is_declaration:
            passes, builder = library._codegen._function_pass_manager()
            passes.run(function, builder)
