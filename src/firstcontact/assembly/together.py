"""All pairs of an assembly: what is asked of them, and their answers in order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from firstcontact.assembly.allowed import Rule, let_pass, rule_for
from firstcontact.batch.results import Question, in_order, told_by_boxes
from firstcontact.result import FirstContact
from firstcontact.work import Progress

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.contact.ways import Answer
    from firstcontact.work import CheckArguments


@dataclass(frozen=True)
class PairQuestion:
    """A question about two bodies of an assembly, and the rule that lets them touch, if any."""

    question: Question
    rule: Rule | None

    @classmethod
    def of(
        cls, verb: str, bodies: Mapping[str, Body], a: str, b: str, arguments: CheckArguments, rules: Sequence[Rule]
    ) -> PairQuestion:
        rule = rule_for(rules, a, b) if verb == "first_contact" else None
        if rule is None:
            return cls(Question(verb, bodies[a], bodies[b], arguments), None)
        module = "firstcontact.assembly.new_contact"
        return cls(Question("first_new_contact", bodies[a], bodies[b], arguments, module), rule)


def answers(
    asked: Sequence[PairQuestion], begin: Callable[[int], None], report: Progress | None, workers: int
) -> Iterator[Any]:
    """The answers in order, by swept boxes, here, or by processes; begin: told of questions that boxes leave open."""
    questions = [x.question for x in asked]
    known = told_by_boxes(questions)

    def here(k: int) -> Answer:
        begin(k)
        return questions[k].asked(questions[k].a, questions[k].b, progress=report)

    for x, found in zip(asked, in_order(questions, known, here, begin, workers), strict=True):
        yield let_pass(found, x.rule) if isinstance(found, FirstContact) else found


def verdict(found: Any) -> str:
    """How a pair counts: "FREE", "CONTACT" (at the start too), "UNDECIDED", or "ALLOWED" without a proof."""
    if isinstance(found, FirstContact):
        if found.status.name == "INITIAL_CONTACT":
            return "CONTACT" if found.allowed is None else "ALLOWED"
        return found.status.name
    return "CONTACT" if len(found) else str(found.status.name)
