"""From a piece of relative motion to the search problem it poses."""

from __future__ import annotations

from typing import Any

from firstcontact.body.moving import Moving
from firstcontact.motion.relative import Piece
from firstcontact.search.translation_problem import TranslationProblem


def problem_of(a: Any, b: Any, piece: Piece) -> Any:
    """The search problem of the piece, both bodies placed at its start."""
    body_a = piece.place_a.place(a.body if isinstance(a, Moving) else a)
    body_b = piece.place_b.place(b.body if isinstance(b, Moving) else b)
    if piece.velocity is not None:
        return TranslationProblem(body_a, body_b, piece)
    from firstcontact.search.rotation_problem import RotationProblem

    return RotationProblem(body_a, body_b, piece)
