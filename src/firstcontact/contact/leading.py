"""Which of two bodies leads: its elements are compared first where several pairs meet at once.

So bodies given the other way round have the same pairs in the same order.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.motion.moving import Moving, shape_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import AnyBody


def leads(a: AnyBody, b: AnyBody) -> bool:
    """Whether a leads: the one that moves, else the first one by name and shape."""
    moves = isinstance(a, Moving), isinstance(b, Moving)
    return moves[0] if moves[0] != moves[1] else _signature(a) <= _signature(b)


def _signature(body: AnyBody) -> tuple[Hashable, ...]:
    shape = shape_of(body)
    motion = repr(body.motion.to_dict()) if isinstance(body, Moving) else ""
    return shape.name or "", shape.kind, *_numbers(shape), motion


def _numbers(shape: Any) -> tuple[int, bytes]:
    """How many parts a shape has, and what they are."""
    if hasattr(shape, "pieces"):
        return len(shape.pieces), repr(shape.to_dict()).encode()
    numbers = shape.vertices if isinstance(shape, Polyhedron) else shape.forms
    return len(numbers), numbers.tobytes()
