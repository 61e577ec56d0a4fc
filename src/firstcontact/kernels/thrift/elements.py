"""Elements of arrays read and written by the few instructions that they take.

Numba stores an array's record on the stack for each access and loads all lengths and strides twice.  LLVM sees through
that; what it ends with is the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numba
from llvmlite.ir import Constant, IRBuilder, Value
from llvmlite.ir.instructions import InsertValue
from numba.core import types
from numba.core.base import BaseContext
from numba.core.cgutils import _StructProxy
from numba.core.datamodel import default_manager
from numba.extending import overload
from numba.np import arrayobj

from firstcontact.kernels.thrift.replaced import put

_struct_of: Any = arrayobj.make_array
_view: Any = arrayobj.basic_indexing
_FIELDS = {"meminfo": 0, "parent": 1, "nitems": 2, "itemsize": 3, "data": 4, "shape": 5, "strides": 6}
"""Of `numba.core.datamodel.models.ArrayModel`."""


def apply() -> None:
    model: Any = default_manager[types.Array(types.float64, 1, "C")]
    if model._fields != tuple(_FIELDS):
        raise AttributeError(f"arrays of Numba {numba.__version__} have the fields {model._fields}")
    put(arrayobj, make_array=_make_array, basic_indexing=_basic_indexing, raise_with_shape_context=_shapes_differ)


def _shapes_differ(src_shapes: tuple[int, ...], index_shape: tuple[int, ...]) -> None:
    """What an array cannot be assigned from: no kernel comes here, and a text with numbers takes all strings' code."""
    raise NotImplementedError


@overload(_shapes_differ)
def _overload_shapes_differ(src_shapes: object, index_shape: object) -> Callable[[object, object], None]:
    def differ(src_shapes: object, index_shape: object) -> None:
        raise ValueError("an array is assigned from one of another shape")

    return differ


def _make_array(kind: types.Array) -> type[_StructProxy] | Callable[..., _StructProxy | _Known]:
    """`numba.np.arrayobj.make_array`: the record of an array, of which it is told whether it is there already."""
    made = _struct_of(kind)
    if type(kind) is not types.Array:
        return made

    def record(
        context: BaseContext, builder: IRBuilder, value: Value | None = None, ref: Value | None = None
    ) -> _StructProxy | _Known:
        if value is None or ref is not None:
            return made(context, builder, value=value, ref=ref)
        return _Known(made, context, builder, value)

    return record


class _Known:
    """An array's record that is read; on the stack only if more is asked of it than its fields."""

    def __init__(self, made: type[_StructProxy], context: BaseContext, builder: IRBuilder, value: Value) -> None:
        self.__dict__.update(_how=(made, context, builder), _value=value, _stored=None)

    def __getattr__(self, name: str) -> Any:
        if self._stored is None and name in _FIELDS:
            return part(self._how[2], self._value, _FIELDS[name])
        return getattr(self._on_stack(), name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self._on_stack(), name, value)

    def _getvalue(self) -> Value:
        return self._value if self._stored is None else self._stored._getvalue()

    def _on_stack(self) -> _StructProxy:
        if self._stored is None:
            made, context, builder = self._how
            self.__dict__["_stored"] = made(context, builder, value=self._value)
        return self._stored


def part(builder: IRBuilder, whole: Value, index: int) -> Value:
    """A field of a record, as it was put in where that can be seen."""
    while isinstance(whole, InsertValue):
        (at,) = whole.indices
        if at == index:
            return whole.value
        whole = whole.aggregate
    return builder.extract_value(whole, index)


def _basic_indexing(
    context: BaseContext, builder: IRBuilder, kind: types.Array, array: _StructProxy | _Known,
    index_types: Sequence[types.Type], indices: Sequence[Value], boundscheck: bool | None = None,
) -> tuple[Value, Sequence[Value], Sequence[Value]]:
    """Where an element lies, of an array in C's order by whole numbers; anything else as Numba does it."""
    element = 0 < len(indices) == kind.ndim and all(isinstance(of, types.Integer) for of in index_types)
    if boundscheck or kind.layout != "C" or not element:
        return _view(context, builder, kind, array, index_types, indices, boundscheck=boundscheck)
    shape, place = array.shape, None
    lengths = [part(builder, shape, axis) for axis in range(kind.ndim)]
    for axis, (of, index) in enumerate(zip(index_types, indices, strict=True)):
        if isinstance(index, Constant) and isinstance(index.constant, int) and index.constant >= 0:
            step = lengths[axis].type(index.constant)
        else:
            step = arrayobj.fix_integer_index(context, builder, of, index, lengths[axis])
        for length in lengths[axis + 1 :]:
            step = builder.mul(step, length)
        place = step if place is None else builder.add(place, step)
    return builder.gep(array.data, [place]), [], []
