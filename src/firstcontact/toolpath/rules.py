"""What may touch: which part of the tool, in which move, what body."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase

from firstcontact.errors import InputError
from firstcontact.toolpath.tool import KINDS, Segment

MOVES = "rapid", "feed", "back"


@dataclass(frozen=True)
class Allowed:
    """part: "cutter", "holder", the name of a segment or a pattern; move: "rapid", "feed", "back" or a pattern; body:
    a name or a pattern."""

    part: str
    move: str
    body: str

    @classmethod
    def read(cls, text: str) -> Allowed:
        """Of a text such as "cutter:feed:stock*"."""
        words = text.split(":", 2)
        if len(words) != 3 or not all(words):
            raise InputError(f"{text}: write PART:MOVE:BODY, such as cutter:feed:stock")
        rule = cls(*words)
        if not any(fnmatchcase(move, rule.move) for move in MOVES):
            raise InputError(f"{text}: no move {rule.move!r}; the moves are {', '.join(MOVES)}")
        return rule

    def names(self, segment: Segment) -> bool:
        """Whether it is about this part."""
        return segment.kind == self.part if self.part in KINDS else fnmatchcase(segment.name, self.part)

    def holds(self, segment: Segment, move: str, body: str) -> bool:
        """Whether it is about this part, move and body."""
        return self.names(segment) and fnmatchcase(move, self.move) and fnmatchcase(body, self.body)


CUTTING = (Allowed("cutter", "feed", "stock*"), Allowed("cutter", "back", "stock*"))
"""The cutter may be in what is to be cut, in feed and as it goes back over a way just cut."""
