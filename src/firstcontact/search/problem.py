"""From a piece of relative motion to the search problem it poses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from flint import fmpq

from firstcontact.body.moving import Moving
from firstcontact.motion.curved import CurvedPiece
from firstcontact.motion.relative import Piece
from firstcontact.search.translation_problem import TranslationProblem


def problem_of(a: Any, b: Any, piece: Any) -> Any:
    """The search problem of the piece, both bodies placed at its reference time."""
    if isinstance(piece, CurvedPiece):
        from firstcontact.search.enclosed_problem import EnclosedProblem
        from firstcontact.search.rational_problem import RationalProblem

        body_a, body_b = (body.body if isinstance(body, Moving) else body for body in (a, b))
        return (RationalProblem if piece.polynomial else EnclosedProblem)(body_a, body_b, piece)
    body_a, body_b = _placed(a, b, piece)
    if piece.velocity is not None:
        return TranslationProblem(body_a, body_b, piece)
    from firstcontact.search.rotation_problem import RotationProblem

    return RotationProblem(body_a, body_b, piece)


def problems_in_order(a: Any, b: Any, parts: Iterable[Any]) -> Iterator[tuple[Any, bool]]:
    """The problems to search one after the other, and whether the bodies may share points from its beginning on.

    That is so in the first one, in which both bodies stand as the span starts, and after a jump.
    """
    before = None
    for k, piece in enumerate(parts):
        if isinstance(piece, CurvedPiece):
            if k == 0 or not piece.continues(before):
                yield standing(a, b, piece), True
            yield problem_of(a, b, piece), False
        else:
            yield from _simple_problems(a, b, piece, k == 0 or isinstance(before, CurvedPiece))
        before = piece


def _simple_problems(a: Any, b: Any, piece: Piece, with_start: bool) -> Iterator[tuple[Any, bool]]:
    """The problems of a translation or rotation."""
    problem = problem_of(a, b, piece)
    if piece.reference == piece.start:
        yield problem, with_start
        return
    if with_start:
        from firstcontact.search.standstill import Standstill

        start = piece.at_start()
        yield Standstill(*_placed(a, b, start), start, problem), True
    for part in problem.parts():
        yield part, False


def standing(a: Any, b: Any, piece: CurvedPiece) -> TranslationProblem:
    """Both bodies at rest in the world as they stand at the start of the piece."""
    zero = fmpq(0), fmpq(0), fmpq(0)
    start = Piece(
        piece.start, piece.start, piece.start, *piece.placed_at_start(), zero, None, None, (fmpq(0), fmpq(0))
    )
    return TranslationProblem(*_placed(a, b, start), start)


def _placed(a: Any, b: Any, piece: Piece) -> tuple[Any, Any]:
    body_a, body_b = (body.body if isinstance(body, Moving) else body for body in (a, b))
    return piece.place_a.place(body_a), piece.place_b.place(body_b)
