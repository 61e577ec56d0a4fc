"""Steps of Numba's own that change nothing, left out or taken once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import BuiltinFunctionType
from typing import Any

from llvmlite.binding import FunctionPassManager, ModuleRef, PassBuilder, create_new_function_pass_manager
from numba.core import base, compiler_machinery, config, errors, event, interpreter, ir, postproc, ssa
from numba.core.codegen import CPUCodegen, CPUCodeLibrary
from numba.core.compiler import StateDict
from numba.core.compiler_machinery import CompilerPass, PassManager
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.transforms import canonicalize_cfg
from numba.core.types.functions import BaseFunction
from numba.core.typing import context
from numba.core.typing.templates import _OverloadFunctionTemplate

from firstcontact.kernels.parts import for_callers
from firstcontact.kernels.thrift.replaced import no_context, nothing, put

_after: Any = postproc.PostProcessor.run
_typed: Any = BaseFunction.get_call_type
_mend: Any = interpreter.Interpreter.post_process
_typed_value: Any = context.BaseContext.resolve_value_type
_assign_once: Any = ssa._run_ssa
_decorator: Any = _OverloadFunctionTemplate._get_jit_decorator


def apply() -> None:
    put(TargetConfig, __eq__=_equal_options, __hash__=_hash_of_options)
    put(CPUCodeLibrary, _optimize_functions=_tidy)
    put(PassManager, _runPass=_take_step)
    put(config, reload_config=nothing)  # of the environment, for each function
    put(interpreter.Interpreter, post_process=_mend_some)
    put(context.BaseContext, resolve_value_type=_type_of_value)
    put(ssa, _run_ssa=_assigned_once, _run_block_rewrite=_rewritten)
    put(_OverloadFunctionTemplate, _get_jit_decorator=_decorator_of_overloads)
    put(BaseFunction, get_call_type=_call_type)
    put(postproc.PostProcessor, run=_run_after)
    put(ir.Inst, _rec_list_vars=_variables)
    put(base, _has_loc=cache(base._has_loc))
    put(vars(errors)["WarningsFixer"], catch_warnings=no_context)
    put(event, start_event=nothing, end_event=nothing)  # of locks, whenever LLVM is called
    put(compiler_machinery, enforce_no_dels=nothing)  # a check of Numba's own steps, after each of them


def _equal_options(one: TargetConfig, other: object) -> bool:
    """Options are compared whenever an operator is looked up: by those that are set."""
    if type(one) is not type(other):
        return NotImplemented
    mine, its = one._values, other._values
    if mine == its:
        return True
    known = type(one).options
    return all(mine.get(n, known[n].default) == its.get(n, known[n].default) for n in mine.keys() | its.keys())


def _hash_of_options(one: TargetConfig) -> int:
    """Numba's is of their names alone.  Options that are equal are set by the same names, but for defaults."""
    known = type(one).options
    return hash(frozenset(n for n, value in one._values.items() if value is True and known[n].default is not True))


def _tidy(library: CPUCodeLibrary, module: ModuleRef) -> None:
    """Functions before they are linked: they are optimized together, in what Python calls."""
    module.data_layout = library._codegen._data_layout
    passes, builder = _tidying(library._codegen)
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


@cache
def _tidying(codegen: CPUCodegen) -> tuple[FunctionPassManager, PassBuilder]:
    passes = create_new_function_pass_manager()
    passes.add_sroa_pass()
    passes.add_simplify_cfg_pass()
    passes.add_aggressive_dce_pass()
    return passes, codegen._pass_builder()


def _take_step(manager: PassManager, _: int, step: CompilerPass, state: StateDict) -> None:
    """A step of a compilation, without a description of it for those who listen, and without a look at a clock."""
    step.analysis = manager._analysis
    changed = [step.run_initialization(state), step.run_pass(state), step.run_finalizer(state)]
    if any(changed) and compiler_machinery._pass_registry.get(type(step)).mutates_CFG:
        postproc.PostProcessor(state.func_ir).run()


def _mend_some(reader: interpreter.Interpreter, steps: Sequence[object], code: ir.FunctionIR) -> ir.FunctionIR:
    """What is left of `with` is removed where there is any."""
    left = any(name.startswith("$setup_with_exitfn") for name in code._definitions)
    mended: ir.FunctionIR = _mend(
        reader, [step for step in steps if left or step is not interpreter.peep_hole_delete_with_exit], code
    )
    return mended


def _assigned_once(blocks: dict[int, ir.Block]) -> dict[int, ir.Block]:
    """Each assignment to a variable gets a name of its own, one variable after the other."""
    for block in blocks.values():
        names = {variable.name for statement in block.body for variable in statement.list_vars()}
        vars(block)["_names"] = names
    done: dict[int, ir.Block] = _assign_once(blocks)
    for block in done.values():
        del vars(block)["_names"]
    return done


def _rewritten(blocks: dict[int, ir.Block], states: dict[str, Any], handler: object) -> dict[int, ir.Block]:
    """Of these, blocks are made anew for the variables that occur there; the new names are not asked for again."""
    made = {}
    for label, block in blocks.items():
        made[label] = block
        if states["varname"] in vars(block)["_names"]:
            states["label"], states["block"] = label, block
            made[label] = ir.Block(scope=block.scope, loc=block.loc)
            made[label].body = list(ssa._run_ssa_block_pass(states, block, handler))
            vars(made[label])["_names"] = vars(block)["_names"]
    return made


def _decorator_of_overloads(template: Any) -> Any:
    """What a kernel calls of Numba's own is linked into it, as are kernels."""
    return for_callers(_decorator(template))


def _type_of_value(typing: context.BaseContext, value: object) -> object:
    """Operators are looked up in two places: they are in the second."""
    if type(value) is BuiltinFunctionType and (kind := typing._lookup_global(value)) is not None:
        return kind
    return _typed_value(typing, value)


def _call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
    """What an operator is for given types is looked up once, among dozens of others."""
    if kws:
        return _typed(function, context, args, kws)
    known, asked = vars(function).setdefault("_known", {}), (tuple(args), ConfigStack.top_or_none())
    if (signature := known.get(asked)) is None:
        signature = _typed(function, context, args, kws)
        if function._impl_keys[signature.args] == function.typing_key:  # else it is compiled, which is remembered there
            known[asked] = signature
    return signature


def _run_after(processor: postproc.PostProcessor, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
    """How long variables live is asked once, before a function gets its code, not after each step."""
    code = processor.func_ir
    if emit_dels or code.is_generator:
        _after(processor, emit_dels, extend_lifetimes)
        return
    code.blocks = canonicalize_cfg(code.blocks)
    code.variable_lifetime = postproc.VariableLifetime(code.blocks)
    code.generator_info = None


def _variables(statement: ir.Inst, value: Any) -> list[ir.Var]:
    """Those of a statement's parts: most are words and places in files."""
    found: list[ir.Var] = []
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
