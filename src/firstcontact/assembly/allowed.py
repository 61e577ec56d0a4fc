"""What a scene lets touch: rules, and what they make of an answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

from firstcontact.result import FirstContact, Status


@dataclass(frozen=True)
class Rule:
    """Pairs of bodies by patterns of their names, such as "bolt*"; touching: only what touches at the start."""

    a: str = "*"
    b: str = "*"
    touching: bool = False
    why: str = ""

    def takes(self, x: str, y: str) -> bool:
        return any(fnmatchcase(p, self.a) and fnmatchcase(q, self.b) for p, q in ((x, y), (y, x)))

    def __str__(self) -> str:
        rule = "touching = true" if self.touching else f"{self.a} / {self.b}"
        return f"{rule}: {self.why}" if self.why else rule


def rule_for(rules: Sequence[Rule], x: str, y: str) -> Rule | None:
    """The first rule that takes the pair, those that name it before others."""
    if not rules:
        return None
    return next((rule for rule in sorted(rules, key=lambda r: r.touching) if rule.takes(x, y)), None)


def let_pass(found: FirstContact, rule: Rule | None) -> FirstContact:
    """The answer with what was let pass and why; a start in contact that is no touch only where a rule names the pair.

    Of such a pair nothing else is proved.  Where it is not known whether the bodies touch or overlap, a rule for what
    touches leaves the pair open.
    """
    if rule is None:
        return found
    if found.allowed is not None:
        return replace(found, allowed=f"{found.allowed} ({rule})")
    if found.status is not Status.INITIAL_CONTACT or rule.touching and found.initial is not None:
        return found
    if rule.touching:
        return FirstContact(
            Status.UNDECIDED, free_until=found.free_until, reason="contact", stats=found.stats, a=found.a, b=found.b,
            span=found.span, model_deviation=found.model_deviation, unit=found.unit,
        )  # fmt: skip
    return replace(found, allowed=f"{found.initial or 'in contact'} at the start, so not looked at further ({rule})")
