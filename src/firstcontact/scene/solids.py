"""Solids of planes and quadrics in scene files: every builder as a shape, and CSG expressions over named parts."""

from __future__ import annotations

import ast
import keyword
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import BeforeValidator, Field, StrictInt, StrictStr

from firstcontact.errors import InputError
from firstcontact.scene.values import Matrix, Number, Placed, Vector, at_key, list_of, parse_number, placed

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.result import Json


def _radii(value: Json) -> float | Fraction | tuple[float | Fraction, ...]:
    """One number, or two."""
    if not isinstance(value, list):
        return parse_number(value)
    if len(value) != 2:
        raise ValueError(f"{value!r} is not one number or two; write r or [a, b]")
    return tuple(parse_number(x) for x in value)


Radii = Annotated[Any, BeforeValidator(_radii)]
ThreeRadii = Annotated[tuple[Number, Number, Number], list_of(3, "three numbers; write [a, b, c]")]


class Solid(Placed):
    """A shape that the builder of the same name makes; the other keys are its arguments."""

    shape: str
    name: StrictStr | None = None
    """By default its key; of a part "" for none."""

    def solid(self) -> CompositeQuadric:
        """The solid before `rotate` and `at`."""
        import firstcontact

        table = next(table for table in type(self).__mro__ if Solid in table.__bases__)
        keys = [key for key in table.__annotations__ if key != "shape" and getattr(self, key) is not None]
        made: CompositeQuadric = getattr(firstcontact, self.shape)(**{key: getattr(self, key) for key in keys})
        return made


class Box(Solid):
    shape: Literal["box"]
    size: Vector


class Sphere(Solid):
    shape: Literal["sphere"]
    radius: Number


class Ellipsoid(Solid):
    shape: Literal["ellipsoid"]
    radii: ThreeRadii


class Cylinder(Solid):
    shape: Literal["cylinder"]
    radius: Radii = None
    radii: Radii = None
    height: Number


class Cone(Solid):
    shape: Literal["cone"]
    radius: Number
    height: Number


class Frustum(Solid):
    shape: Literal["frustum"]
    bottom: Number
    top: Number
    height: Number


class Paraboloid(Solid):
    shape: Literal["paraboloid"]
    radii: Radii
    height: Number


class Hyperboloid(Solid):
    shape: Literal["hyperboloid"]
    radii: ThreeRadii
    height: Number
    sheets: StrictInt | None = None


class HalfSpace(Solid):
    shape: Literal["half_space"]
    normal: Vector
    offset: Number


class Quadric(Solid):
    shape: Literal["quadric"]
    matrix: Matrix


class Torus(Solid):
    shape: Literal["torus"]
    major: Number
    minor: Number


class Csg(Solid):
    """Parts combined by an expression such as "slab - (hole | slot)"; a part may be a "csg" itself."""

    shape: Literal["csg"]
    expression: StrictStr
    part: dict[str, Part] = {}

    def solid(self) -> CompositeQuadric:
        parts = {}
        for name, table in self.part.items():
            with at_key(f"part.{name}"):
                if not name.isidentifier() or keyword.iskeyword(name):
                    raise InputError(f"{name!r} cannot stand in an expression; use letters, digits and _")
                own = name if table.name is None else table.name
                parts[name] = placed(table.solid(), table).named(own or None)
        with at_key("expression"):
            return combined(self.expression, parts)


COMBINED = Box, Sphere, Ellipsoid, Cylinder, Cone, Frustum, Paraboloid, Hyperboloid, HalfSpace, Quadric, Csg
SOLIDS: tuple[type[Solid], ...] = (*COMBINED, Torus)
"""Also those that are no parts of models."""
if TYPE_CHECKING:
    Part = Any
else:
    Part = Annotated[Union[COMBINED], Field(discriminator="shape")]  # noqa: UP007
Csg.model_rebuild()


def combined(expression: str, parts: dict[str, CompositeQuadric]) -> CompositeQuadric:
    """The solid of a CSG expression with Python's precedence: - binds before &, & before |.

    Raises InputError for anything but part names, these three operators and parentheses.

    >>> from firstcontact.body.solid.primitives import box, sphere
    >>> combined("(a | b) - b", {"a": box((4, 4, 4)), "b": sphere(1)})
    <CompositeQuadric: 7 faces, 12 edges, 8 vertices>
    """
    text = " ".join(expression.split())
    if "#" in text:
        raise _syntax(text, text.index("#"))
    try:
        tree = ast.parse(text, mode="eval").body
    except SyntaxError as error:
        raise _syntax(text, (error.offset or len(text)) - 1) from error
    except (ValueError, RecursionError, MemoryError) as error:  # null characters, thousands of parentheses
        raise InputError(f"the expression cannot be read ({error}); use part names, -, &, | and parentheses") from error
    return _evaluated(tree, text, parts)


def _evaluated(node: ast.expr, text: str, parts: dict[str, CompositeQuadric]) -> CompositeQuadric:
    chain = []
    while isinstance(node, ast.BinOp):  # "a - b - c - ..." leans to the left: walked, not recursed
        chain.append((node.op, node.right))
        node = node.left
    if not isinstance(node, ast.Name):
        raise _syntax(text, node.col_offset)
    if node.id not in parts:
        known = ", ".join(map(repr, parts)) or "none: add [body.NAME.part.PART]"
        raise InputError(f"no part {node.id!r}; the parts are {known}")
    solid = parts[node.id]
    for operator, right in reversed(chain):
        operand = _evaluated(right, text, parts)
        match operator:
            case ast.Sub():
                solid = solid - operand
            case ast.BitAnd():
                solid = solid & operand
            case ast.BitOr():
                solid = solid | operand
            case _:
                raise _syntax(text, _operator_before(text, right.col_offset))
    return solid


def _operator_before(text: str, column: int) -> int:
    """Where the operator before an operand begins."""
    before = text[:column].rstrip(" (")
    return len(before.rstrip("+*/%@^<>"))


def _syntax(text: str, column: int) -> InputError:
    column = min(max(column, 0), max(len(text) - 1, 0))
    found = f"{text[column]!r} in column {column + 1}" if text else "nothing"
    shown = text if len(text) <= 80 else text[:77] + "..."
    return InputError(f"{shown!r} is no expression ({found}); combine part names by -, &, | and parentheses")
