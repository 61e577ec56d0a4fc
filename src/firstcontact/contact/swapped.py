"""Answers for the bodies in the other order."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from firstcontact.result import Element, ElementPair, FirstContact

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body


def swapped(found: FirstContact) -> FirstContact:
    """The first contact of b and a."""
    first, second = partial(_called, found.b, "b", "a"), partial(_called, found.a, "a", "b")
    return replace(
        found, a=found.b, b=found.a, element_a=first(found.element_b), element_b=second(found.element_a),
        normal=None if found.normal is None else 0.0 - found.normal,
        others=tuple(ElementPair(first(x.element_b), second(x.element_a)) for x in found.others),
    )  # fmt: skip


def _called(body: Body, before: str, after: str, element: Element | None) -> Any:
    """The element of a body that goes by this letter where it has no name."""
    if element is None or getattr(body, "name", None):
        return element
    return replace(element, body=after, label=after if element.label == before else element.label)
