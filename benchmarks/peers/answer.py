"""What every tool is asked to say."""

from dataclasses import dataclass, field


@dataclass
class Answer:
    """status: "contact", "free", "overlap" (at the start), "undecided" or "failed"; time in the span (0, 1).

    counts: whatever the tool or its loop can count, by name.
    """

    status: str
    time: float | None = None
    counts: dict[str, float] = field(default_factory=dict)
