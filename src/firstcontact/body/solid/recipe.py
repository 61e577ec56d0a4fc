"""How a solid was made: builders, maps and combinations, as scene files have them."""

from __future__ import annotations

import inspect
import keyword
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np

from firstcontact.exact.numbers import rational
from firstcontact.exact.rigid import IDENTITY, Matrix, compose
from firstcontact.motion.value import numbers

if TYPE_CHECKING:
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.result import Json, Table

Arguments = ParamSpec("Arguments")
# What binds first, as in Python: a chain of operations is written without parentheses while none binds more than the
# one before it.
BINDING = {"-": 3, "&": 2, "|": 1}


@dataclass(frozen=True, slots=True)
class Recipe:
    """A builder's table, or a chain of operations, then a map.

    chain: (operator, name, recipe) of each operand in turn; the operator of the first one means nothing.
    """

    table: dict[str, Any] | None = None
    chain: tuple[tuple[str, str | None, Recipe], ...] = ()
    matrix: Matrix = IDENTITY

    def moved(self, matrix: Matrix) -> Recipe:
        return Recipe(self.table, self.chain, compose(matrix, self.matrix))

    def written(self) -> Table:
        """The table of a scene file, but for the name."""
        made = dict(self.table) if self.table is not None else _chain_table(self.chain)
        if self.matrix != IDENTITY:
            made["transform"] = [*numbers(self.matrix), [0, 0, 0, 1]]
        return made


def combined(operator: str, a: CompositeQuadric, b: CompositeQuadric) -> Recipe | None:
    """None where how an operand was made is not known."""
    if a.recipe is None or b.recipe is None:
        return None
    own = a.recipe
    goes_on = own.chain and a.name is None and own.matrix == IDENTITY and BINDING[own.chain[-1][0]] >= BINDING[operator]
    start = own.chain if goes_on else (("", a.name, own),)
    return Recipe(chain=(*start, (operator, b.name, b.recipe)))


def recorded(builder: Callable[Arguments, CompositeQuadric]) -> Callable[Arguments, CompositeQuadric]:
    """The builder, whose solids know by what they were made."""
    signature = inspect.signature(builder)

    @wraps(builder)
    def build(*args: Arguments.args, **keywords: Arguments.kwargs) -> CompositeQuadric:
        given: Any = [tuple(x) if isinstance(x, Iterator) else x for x in args]
        named: Any = {key: tuple(x) if isinstance(x, Iterator) else x for key, x in keywords.items()}
        solid = builder(*given, **named)
        arguments = signature.bind(*given, **named).arguments
        table = {key: _plain(x) for key, x in arguments.items() if key != "name" and x is not None}
        solid.recipe = Recipe({"shape": builder.__name__, **table})
        return solid

    return build


def _plain(value: Any) -> Any:
    """Numbers of any kind as scene files have them."""
    if not isinstance(value, str) and np.iterable(value):
        return [_plain(x) for x in value]
    return numbers(rational(value, "argument"))


def _chain_table(chain: tuple[tuple[str, str | None, Recipe], ...]) -> Table:
    """An expression over parts that are called as the operands are, where that is possible."""
    parts: dict[str, Json] = {}
    words = []
    for k, (operator, name, recipe) in enumerate(chain):
        usable = name is not None and name.isidentifier() and not keyword.iskeyword(name) and name not in parts
        key = name if name is not None and usable else _new_key(parts, [other for _, other, _ in chain])
        parts[key] = {**recipe.written(), **({} if key == name else {"name": name or ""})}
        words += [operator, key] if k else [key]
    return {"shape": "csg", "expression": " ".join(words), "part": parts}


def _new_key(parts: dict[str, Json], names: list[str | None]) -> str:
    k = len(parts) + 1
    while f"part{k}" in parts or f"part{k}" in names:
        k += 1
    return f"part{k}"
