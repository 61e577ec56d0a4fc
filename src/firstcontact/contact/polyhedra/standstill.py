"""The instant in which the window of a turn starts: two bodies at rest, one of them in an irrational pose.

Balls decide what is generic.  What they leave open, such as contact that lasts while the body turns, the turn
decides exactly: it knows all windows of contact of two elements from the rational pose in which it began.
Between two events nothing changes: neither which elements meet, nor whether the bodies overlap.
"""

from __future__ import annotations

from typing import Any

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.earliest import earliest
from firstcontact.contact.polyhedra.problems.rotation_problem import RotationProblem
from firstcontact.contact.polyhedra.problems.translation_problem import TranslationProblem
from firstcontact.exact.numbers import Undecidable
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.motion.relative.pieces import MotionPiece
from firstcontact.pairs.elements.segment_facet import APART, TOUCHING
from firstcontact.search.trees.containment import decide
from firstcontact.search.trees.elements import Feature


class Standstill(TranslationProblem):
    """Bodies a and b at rest, as they stand at the opening of the turn."""

    def __init__(self, a: Polyhedron, b: Polyhedron, piece: MotionPiece, turn: RotationProblem) -> None:
        super().__init__(a, b, piece)
        self.turn = turn

    def contact(self, element_a: Feature, element_b: Feature) -> RationalInstant | None:
        try:
            found: RationalInstant | None = decide(lambda: super(Standstill, self).contact(element_a, element_b))
            return found
        except Undecidable:
            return RationalInstant(fmpq(0)) if self.turn.meet_at_opening(element_a, element_b) else None

    def start_relation(self, element_a: Feature, element_b: Feature) -> int:
        try:
            relation: int = decide(lambda: super(Standstill, self).start_relation(element_a, element_b))
            return relation
        except Undecidable:  # elements that cross are no such case: what decides it is not zero
            return TOUCHING if self.turn.meet_at_opening(element_a, element_b) else APART

    def is_contained(self) -> bool:
        try:
            return super().is_contained()
        except Undecidable:
            return self.soon().is_contained()

    def soon(self) -> TranslationProblem:
        """The bodies in a rational pose soon after, before anything changes: the turn's next event.

        Raises Undecidable where the instant itself is an event.
        """
        turn = self.turn.after_opening()
        begin = turn.start_instant()
        event: Any = earliest(turn, with_start=False).instant or turn.end_instant()
        if turn.order(begin, event) == 0:
            raise Undecidable
        return TranslationProblem(turn.a._mapped(turn.pose_between(begin, event)), turn.b, self.piece)
