"""From a piece of relative motion to the search problem it poses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.answers import Body
from firstcontact.contact.polyhedra.earliest import Problem, Searched
from firstcontact.contact.polyhedra.translation_problem import TranslationProblem
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.balls_apart import Ball, are_apart
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import Piece, curved_pieces

if TYPE_CHECKING:
    from firstcontact.contact.polyhedra.rotation_problem import RotationProblem


def problem_of(a: Body, b: Body, piece: Piece | CurvedPiece, engine: str = "boxes", threads: int = 1) -> Problem:
    """The search problem of the piece, both bodies placed at its reference time."""
    if isinstance(piece, CurvedPiece):
        from firstcontact.contact.polyhedra.enclosed_problem import EnclosedProblem
        from firstcontact.contact.polyhedra.rational_problem import RationalProblem

        body_a, body_b = (shape_of(body) for body in (a, b))
        if piece.is_rational:
            return RationalProblem(body_a, body_b, piece)
        return EnclosedProblem(body_a, body_b, piece)
    body_a, body_b = _placed(a, b, piece)
    if piece.velocity is not None:
        problem: TranslationProblem | RotationProblem = TranslationProblem(body_a, body_b, piece)
    else:
        from firstcontact.contact.polyhedra.rotation_problem import RotationProblem

        problem = RotationProblem(body_a, body_b, piece)
    problem.engine, problem.threads = engine, threads
    return problem


def problems_in_order(
    a: Body, b: Body, parts: Iterable[Piece | CurvedPiece], engine: str = "boxes", threads: int = 1
) -> Iterator[tuple[Searched, bool]]:
    """The problems to search one after the other, and whether the bodies may share points from its beginning on.

    That is so in the first one, in which both bodies stand as the span starts, and after a jump.
    """
    parts = list(parts)
    before: Piece | CurvedPiece | None = None
    for k, (piece, legs) in enumerate(zip(parts, _legs(a, b, parts), strict=True)):
        if legs is not None and are_apart(legs, _ball_of(shape_of(a)), _ball_of(shape_of(b))):
            before = piece
            continue
        if isinstance(piece, CurvedPiece):
            if k == 0 or not piece.continues(before):
                start = piece_at_start(piece)
                bodies = _placed(a, b, start)
                if k == 0 or not _boxes_apart(*bodies):
                    yield TranslationProblem(*bodies, start), True
            curved: Any = problem_of(a, b, piece, engine)
            yield curved, False
        else:
            problem = problem_of(a, b, piece, engine, threads)
            yield from _simple_problems(a, b, problem, k == 0 or isinstance(before, CurvedPiece))
        before = piece


def _legs(a: Body, b: Body, parts: list[Piece | CurvedPiece]) -> list[CurvedPiece | None]:
    """The pieces by the motions themselves; None for a single translation or rotation, whose search is as quick."""
    if len(parts) == 1:
        return [part if isinstance(part, CurvedPiece) else None for part in parts]
    last = parts[-1].end
    assert last is not None  # sequences have bounded spans
    return [*curved_pieces(a, b, parts[0].start, last)]


def _ball_of(body: Polyhedron) -> Ball:
    """Kept on the body."""
    ball: Ball | None = body._search.get("ball")
    if ball is None:
        ball = body._search["ball"] = Ball.of(*body.bounds())
    return ball


def _simple_problems(a: Body, b: Body, problem: Any, with_start: bool) -> Iterator[tuple[Searched, bool]]:
    """The problems of a translation or rotation."""
    piece: Piece = problem.piece
    if piece.reference == piece.start:
        yield problem, with_start
        return
    if with_start:
        from firstcontact.contact.polyhedra.standstill import Standstill

        start = piece.at_start()
        yield Standstill(*_placed(a, b, start), start, problem), True
    for part in problem.parts():
        yield part, False


def piece_at_start(piece: CurvedPiece) -> Piece:
    """The instant in which a curved piece starts, both bodies as they stand in the world then."""
    zero = fmpq(0), fmpq(0), fmpq(0)
    rate = fmpq(0), fmpq(0)
    return Piece(piece.start, piece.start, piece.start, *piece.placed_at_start(), zero, None, None, rate)


def _boxes_apart(a: Polyhedron, b: Polyhedron) -> bool:
    """Whether two bodies at rest certainly share no point, by their boxes."""
    (lo_a, hi_a), (lo_b, hi_b) = a.bounds(), b.bounds()
    size = max(float(np.abs(x).max()) for x in (lo_a, hi_a, lo_b, hi_b))
    pad = 1e-15 * size  # each bound rounds once
    return bool(np.any(lo_a > hi_b + pad) or np.any(lo_b > hi_a + pad))


def _placed(a: Body, b: Body, piece: Piece) -> tuple[Polyhedron, Polyhedron]:
    body_a, body_b = (shape_of(body) for body in (a, b))
    return piece.place_a.place(body_a), piece.place_b.place(body_b)
