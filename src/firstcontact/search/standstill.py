"""The instant in which the window of a turn starts: two bodies at rest, one of them in an irrational pose.

Balls decide what is generic.  What they leave open, such as contact that lasts while the body turns, the turn
decides exactly: it knows all windows of contact of two elements from the rational pose in which it began.
"""

from __future__ import annotations

from typing import Any

from flint import fmpq

from firstcontact.exact.instants import RationalInstant
from firstcontact.exact.numbers import Undecidable
from firstcontact.motion.relative import Piece
from firstcontact.pairs.segment_facet import APART, TOUCHING
from firstcontact.search.containment import contained_at, decide
from firstcontact.search.earliest import earliest
from firstcontact.search.elements import Feature
from firstcontact.search.rotation_problem import RotationProblem
from firstcontact.search.translation_problem import TranslationProblem


class Standstill(TranslationProblem):
    """Bodies a and b at rest, as they stand at the opening of the turn."""

    def __init__(self, a: Any, b: Any, piece: Piece, turn: RotationProblem) -> None:
        super().__init__(a, b, piece)
        self.turn = turn

    def contact(self, element_a: Feature, element_b: Feature) -> RationalInstant | None:
        try:
            return decide(lambda: super(Standstill, self).contact(element_a, element_b))
        except Undecidable:
            return RationalInstant(fmpq(0)) if self.turn.meet_at_opening(element_a, element_b) else None

    def start_relation(self, element_a: Feature, element_b: Feature) -> int:
        try:
            return decide(lambda: super(Standstill, self).start_relation(element_a, element_b))
        except Undecidable:  # elements that cross are no such case: what decides it is not zero
            return TOUCHING if self.turn.meet_at_opening(element_a, element_b) else APART

    def is_contained(self) -> bool:
        """Nothing changes until the turn brings the surfaces together: any pose before that tells."""
        try:
            return super().is_contained()
        except Undecidable:
            turn = self.turn.after_opening()
            until = earliest(turn, with_start=False).instant or turn.end_instant()
            return contained_at(turn, turn.start_instant(), until)
