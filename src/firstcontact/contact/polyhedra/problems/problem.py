"""From a piece of relative motion to the search problem it poses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.earliest import Problem, Searched
from firstcontact.contact.polyhedra.problems.translation_problem import TranslationProblem
from firstcontact.exact.numbers import below
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.balls_apart import Ball, are_apart, turn_apart
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import MotionPiece, by_motions, in_few_turns
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.contact.polyhedra.problems.rotation_problem import RotationProblem

Body = Polyhedron | Moving

_BALL = Kept[Ball]()


def problem_of(a: Body, b: Body, piece: MotionPiece | CurvedPiece, engine: str = "boxes", threads: int = 1) -> Problem:
    """The search problem of the piece, both bodies placed at its reference time."""
    if isinstance(piece, CurvedPiece):
        from firstcontact.contact.polyhedra.problems.enclosed_problem import EnclosedProblem
        from firstcontact.contact.polyhedra.problems.rational_problem import RationalProblem

        body_a, body_b = (shape_of(body) for body in (a, b))
        if piece.is_rational:
            return RationalProblem(body_a, body_b, piece)
        return EnclosedProblem(body_a, body_b, piece)
    body_a, body_b = _placed(a, b, piece)
    if piece.velocity is not None:
        problem: TranslationProblem | RotationProblem = TranslationProblem(body_a, body_b, piece)
    else:
        from firstcontact.contact.polyhedra.problems.rotation_problem import RotationProblem

        problem = RotationProblem(body_a, body_b, piece)
    problem.engine, problem.threads = engine, threads
    return problem


def problems_in_order(
    a: Body, b: Body, parts: Sequence[MotionPiece | CurvedPiece], engine: str = "boxes", threads: int = 1,
    work: Work | None = None,
) -> Iterator[tuple[Searched, bool]]:
    """The problems to search one after the other, and whether the bodies may share points from its beginning on.

    That is so in the first one, in which both bodies stand as the span starts, and after a jump.  Raises Spent.
    """
    piece = parts[0]
    if len(parts) == 1 and isinstance(piece, MotionPiece) and piece.reference == piece.start:
        if piece.velocity is not None or not _may_be_skipped(a, b, piece):  # a translation is searched as quickly
            whole: Any = problem_of(a, b, piece, engine, threads)
            yield whole, True
        return
    before: MotionPiece | CurvedPiece | None = None
    for piece in stretches(a, b, parts, work or Work()):
        if _may_be_skipped(a, b, piece):
            before = piece
            continue
        if isinstance(piece, CurvedPiece):
            if not piece.continues(before):
                start = piece_at_start(piece)
                bodies = _placed(a, b, start)
                if not _boxes_apart(*bodies):
                    yield TranslationProblem(*bodies, start), True
                if piece.start == piece.end and all(body.irrational_pose is None for body in bodies):
                    continue  # one instant, all told
            curved: Any = problem_of(a, b, piece, engine)
            yield curved, False
        else:
            problem = problem_of(a, b, piece, engine, threads)
            yield from _simple_problems(a, b, problem, before is None or isinstance(before, CurvedPiece))
        before = piece


def stretches(
    a: Body, b: Body, parts: Sequence[MotionPiece | CurvedPiece], work: Work
) -> Iterator[MotionPiece | CurvedPiece]:
    """The pieces, curved ones of many turns cut; what is cut off counts as work, however little there is to search.

    Raises Spent.
    """
    for part in parts:
        if not isinstance(part, CurvedPiece):
            yield part
            continue
        cut = in_few_turns(part)
        first = next(cut)
        if first is not part and far_apart(a, b, part):
            yield part
            continue
        for piece in chain([first], cut):
            if piece.start != part.start:
                work.free_until = below(piece.start)
                work.step()
            yield piece


def _may_be_skipped(a: Body, b: Body, piece: MotionPiece | CurvedPiece) -> bool:
    """True proves that the bodies share no point during the piece, told by the motions themselves."""
    if isinstance(piece, MotionPiece) and (angle := piece.turn_from_rest()) is not None:
        assert piece.axis is not None and piece.point is not None
        return turn_apart(piece.axis, piece.point, angle, _ball_of(shape_of(a)), _ball_of(shape_of(b)))
    curved = piece if isinstance(piece, CurvedPiece) else by_motions(a, b, piece)
    return curved is not None and far_apart(a, b, curved)


def far_apart(a: Body, b: Body, piece: CurvedPiece) -> bool:
    """True proves that the bodies share no point during the piece; False tells nothing."""
    return are_apart(piece, _ball_of(shape_of(a)), _ball_of(shape_of(b)))


def _ball_of(body: Polyhedron) -> Ball:
    """Kept on the body."""
    return _BALL.of(body, lambda: Ball.of(*body.bounds()))


def _simple_problems(a: Body, b: Body, problem: Any, with_start: bool) -> Iterator[tuple[Searched, bool]]:
    """The problems of a translation or rotation."""
    piece: MotionPiece = problem.piece
    if piece.reference == piece.start:
        yield problem, with_start
        return
    if with_start:
        from firstcontact.contact.polyhedra.standstill import Standstill

        start = piece.at_start()
        yield Standstill(*_placed(a, b, start), start, problem), True
    for part in problem.parts():
        yield part, False


def piece_at_start(piece: CurvedPiece) -> MotionPiece:
    """The instant in which a curved piece starts, both bodies as they stand in the world then."""
    zero = fmpq(0), fmpq(0), fmpq(0)
    rate = fmpq(0), fmpq(0)
    return MotionPiece(piece.start, piece.start, piece.start, *piece.placed_at_start(), zero, None, None, rate)


def _boxes_apart(a: Polyhedron, b: Polyhedron) -> bool:
    """Whether two bodies at rest certainly share no point, by their boxes."""
    (lo_a, hi_a), (lo_b, hi_b) = a.bounds(), b.bounds()
    size = max(float(np.abs(x).max()) for x in (lo_a, hi_a, lo_b, hi_b))
    pad = 1e-15 * size  # each bound rounds once
    return bool(np.any(lo_a > hi_b + pad) or np.any(lo_b > hi_a + pad))


def _placed(a: Body, b: Body, piece: MotionPiece) -> tuple[Polyhedron, Polyhedron]:
    return piece.place_a.place(shape_of(a)), piece.place_b.place(shape_of(b))
