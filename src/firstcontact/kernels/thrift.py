"""What Numba does in vain while it compiles, left out.  It is left out for the whole process: for those of our own.

Every name of Numba's used here is of 0.68, which the package is pinned to.
"""

from __future__ import annotations

import gc
from typing import Any

from llvmlite.binding import create_new_function_pass_manager
from numba.core import event, ir, postproc, types
from numba.core.codegen import CPUCodeLibrary
from numba.core.targetconfig import TargetConfig
from numba.core.transforms import canonicalize_cfg
from numba.core.types.functions import BaseFunction
from numba.core.typing.templates import _OverloadFunctionTemplate

from firstcontact.kernels.parts import for_callers

_after: Any = postproc.PostProcessor.run
_typed: Any = BaseFunction.get_call_type
_decorator: Any = _OverloadFunctionTemplate._get_jit_decorator


def apply() -> None:
    gc.disable()
    config: Any = TargetConfig
    library: Any = CPUCodeLibrary
    overloads: Any = _OverloadFunctionTemplate
    function: Any = BaseFunction
    after: Any = postproc.PostProcessor
    statement: Any = ir.Inst
    config.__eq__, config.__hash__ = _equal_options, _hash_of_options
    library._optimize_functions = _tidy
    overloads._get_jit_decorator = _decorator_of_overloads
    function.get_call_type = _call_type
    after.run = _run_after
    statement._rec_list_vars = _variables
    told: Any = event
    told.start_event = told.end_event = _tell_nobody


def _tell_nobody(*_: Any, **__: Any) -> None:
    """Of locks taken and given back, whenever LLVM is called."""


def _equal_options(one: Any, other: Any) -> Any:
    """Options are compared whenever an operator is looked up: by those that are set."""
    if type(one) is not type(other):
        return NotImplemented
    mine, its = one._values, other._values
    return mine == its or all(getattr(one, name) == getattr(other, name) for name in mine.keys() | its.keys())


def _hash_of_options(one: Any) -> int:
    """Numba's is of their names alone."""
    return hash(type(one))


def _tidy(library: Any, module: Any) -> None:
    """Functions before they are linked: they are optimized together, in what Python calls."""
    module.data_layout = library._codegen._data_layout
    builder = library._codegen._pass_builder()
    passes = create_new_function_pass_manager()
    passes.add_sroa_pass()
    passes.add_simplify_cfg_pass()
    passes.add_aggressive_dce_pass()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


def _decorator_of_overloads(template: Any) -> Any:
    """What a kernel calls of Numba's own is linked into it, as are kernels."""
    return for_callers(_decorator(template))


def _call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
    """What an operator makes of numbers is looked up among dozens of others once."""
    if kws or not all(isinstance(kind, _NUMBERS) for kind in args):
        return _typed(function, context, args, kws)
    known = vars(function).setdefault("_known", {})
    if (signature := known.get(args)) is None:
        signature = _typed(function, context, args, kws)
        if signature is not None and function._impl_keys[signature.args] == function.typing_key:  # made by no compiler
            known[args] = signature
    return signature


_NUMBERS = types.Number, types.Boolean, types.Literal


def _run_after(processor: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
    """How long variables live is asked once, before a function gets its code, not after each step."""
    code = processor.func_ir
    if emit_dels or code.is_generator:
        _after(processor, emit_dels, extend_lifetimes)
        return
    code.blocks = canonicalize_cfg(code.blocks)
    code.variable_lifetime = postproc.VariableLifetime(code.blocks)
    code.generator_info = None


def _variables(statement: Any, value: Any) -> list[Any]:
    """Those of a statement's parts: most are words and places in files."""
    found: list[Any] = []
    kind = type(value)
    if kind is dict:
        value = value.values()
    elif kind is not list and kind is not tuple:
        value = (value,)
    for part in value:
        kind = type(part)
        if kind in _PLAIN:
            continue
        if kind is ir.Var:
            found.append(part)
        elif isinstance(part, ir.Inst):
            found += part.list_vars()
        elif isinstance(part, (list, tuple, dict)):
            found += _variables(statement, part)
    return found


_PLAIN = {str, int, bool, float, type(None), ir.Loc}
