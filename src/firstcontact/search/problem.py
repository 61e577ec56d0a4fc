"""From a piece of relative motion to the search problem it poses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from firstcontact.body.moving import Moving
from firstcontact.motion.relative import Piece
from firstcontact.search.translation_problem import TranslationProblem


def problem_of(a: Any, b: Any, piece: Piece) -> Any:
    """The search problem of the piece, both bodies placed at its reference time."""
    body_a, body_b = _placed(a, b, piece)
    if piece.velocity is not None:
        return TranslationProblem(body_a, body_b, piece)
    from firstcontact.search.rotation_problem import RotationProblem

    return RotationProblem(body_a, body_b, piece)


def problems_in_order(a: Any, b: Any, parts: Iterable[Piece]) -> Iterator[Any]:
    """The problems to search one after the other; in the first one both bodies stand as the span starts."""
    for k, piece in enumerate(parts):
        problem = problem_of(a, b, piece)
        if piece.reference == piece.start:
            yield problem
            continue
        if k == 0:
            from firstcontact.search.standstill import Standstill

            start = piece.at_start()
            yield Standstill(*_placed(a, b, start), start, problem)
        yield from problem.parts()


def _placed(a: Any, b: Any, piece: Piece) -> tuple[Any, Any]:
    body_a, body_b = (body.body if isinstance(body, Moving) else body for body in (a, b))
    return piece.place_a.place(body_a), piece.place_b.place(body_b)
