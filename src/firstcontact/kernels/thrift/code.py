"""Code as Numba writes it down for LLVM: what says the same in fewer words, or in less time."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from llvmlite.ir import Constant, Type
from llvmlite.ir._utils import NameScope
from llvmlite.ir.instructions import Instruction
from llvmlite.ir.types import IdentifiedStructType, VoidType
from llvmlite.ir.values import Block, NamedValue, Value
from numba.core import base, byteflow, codegen, ir, lowering, ssa, typeinfer, types
from numba.core.datamodel.manager import DataModelManager
from numba.core.types.abstract import _TypeMetaclass
from numba.core.typing import context

from firstcontact.kernels.thrift.replaced import no_context, nothing, put

Context = base.BaseContext | context.BaseContext

_refresh: Any = base.BaseContext.refresh
_refresh_types: Any = context.BaseContext.refresh
_bytes_of: Any = base.BaseContext.get_abi_sizeof
_increase: Any = lowering.Lower.incref
_decrease: Any = lowering.Lower.decref
_delete: Any = lowering.Lower.delvar
_register: Any = NameScope.register


def apply() -> None:
    put(NameScope, register=_name)
    put(NamedValue, _to_string=_line)
    put(Instruction, __init__=_begin)
    put(Block, descr=_lines)
    put(Type, __call__=_constant)
    put(base.BaseContext, refresh=_refresh_changed, get_abi_sizeof=_size)
    put(context.BaseContext, refresh=_refresh_changed_types)
    put(codegen.CPUCodegen, _check_llvm_bugs=nothing)  # with each library
    put(lowering, new_error_context=no_context)
    put(typeinfer, new_error_context=no_context)
    put(lowering.Lower, incref=_counted_up, decref=_counted_down, delvar=_forget)
    put(ir.Assign, __str__=_unsaid)  # as each is compiled, for a log that nobody asked for
    for module in ssa, byteflow:
        put(module, _logger=_Silent())
    # asked a million times; what kinds of types there are is not registered otherwise
    _TypeMetaclass.__instancecheck__ = type.__instancecheck__  # type: ignore[method-assign]


class _Silent:
    debug = staticmethod(nothing)


def _unsaid(_: object) -> str:
    return "an assignment"


def _name(scope: NameScope, name: str, deduplicate: bool = False) -> str:
    """Most values have no name of their own; no other name begins with a point and a digit."""
    if name or not deduplicate:
        told: str = _register(scope, name, deduplicate)
        return told
    number = scope._basenamemap[""] = scope._basenamemap[""] + 1
    return f".{number}"


def _begin(
    instruction: Instruction, parent: Block, kind: Type, opname: str, operands: Sequence[Value], name: str = "",
    flags: Sequence[str] = (),
) -> None:
    instruction.parent, instruction.type = parent, kind
    instruction._name = parent.scope.register(name, True)
    instruction.opname, instruction.operands = opname, operands
    instruction.flags, instruction.metadata = list(flags), {}


def _line(value: NamedValue) -> str:
    said: list[str] = []
    value.descr(said)
    line = "".join(said).rstrip()
    return line if type(value.type) is VoidType else f"{value.get_reference()} = {line}"


def _lines(block: Block, said: list[str]) -> None:
    said.append(f"{block._format_name()}:\n")
    said += [f"  {instruction._to_string()}\n" for instruction in block.instructions]


def _constant(kind: Type, value: object) -> Constant:
    return Constant(kind, value)


def _size(context: Any, kind: Type) -> int:
    """Bytes of a value, for which LLVM reads a module each time."""
    library: Any = context.codegen()
    known: dict[str, int] = vars(library).setdefault("_sizes", {})
    size: int | None
    if isinstance(kind, IdentifiedStructType):
        size = _bytes_of(context, kind)
        return size
    if (size := known.get(told := str(kind))) is None:
        size = known[told] = _bytes_of(context, kind)
    return size


def _registered(context: Context) -> tuple[int, int]:
    """How much there is that kernels may call: more where modules are imported and overloads declared."""
    lists = (item for registry in context._registries for item in vars(registry).values())
    return len(sys.modules), sum(map(len, lists))


def _refresh_changed(context: Context) -> None:
    _once(context, _refresh)


def _refresh_changed_types(context: Context) -> None:
    _once(context, _refresh_types)


_seen: dict[int, tuple[int, int]] = {}
"""By what the copies of a context share."""


def _once(context: Context, refresh: Callable[[Context], None]) -> None:
    if _seen.get(id(context._registries)) != _registered(context):
        refresh(context)
        _seen[id(context._registries)] = _registered(context)


@cache
def _counted(kind: types.Type, models: DataModelManager) -> bool:
    return bool(models[kind].contains_nrt_meminfo())


def _counted_up(lower: lowering.Lower, kind: types.Type, value: Value) -> None:
    if lower.context.enable_nrt and _counted(kind, lower.context.data_model_manager):
        _increase(lower, kind, value)


def _counted_down(lower: lowering.Lower, kind: types.Type, value: Value) -> None:
    if lower.context.enable_nrt and _counted(kind, lower.context.data_model_manager):
        _decrease(lower, kind, value)


def _forget(lower: lowering.Lower, name: str) -> None:
    """A variable that is not used any more: nothing to do for what holds no array that is counted."""
    if lower.context.enable_nrt and _counted(lower.typeof(name), lower.context.data_model_manager):
        _delete(lower, name)
        return
    if name not in lower._blk_local_varmap:
        lower._singly_assigned_vars.discard(name)
        lower._alloca_var(name, lower.typeof(name))
