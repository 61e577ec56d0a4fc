"""What an answer tells of the place of contact, worked out when it is first read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from firstcontact.contact.ways import R
from firstcontact.result import ContactIntervals, FirstContact

LATER = (
    "point", "normal", "element_a", "element_b", "others", "multiplicity", "contact_set", "initial", "subproblems",
)  # fmt: skip
"""The fields that may wait."""


LAST = "within_deviation"
"""Asked for last: it costs another question."""


def waiting(found: FirstContact, places: Callable[[], dict[str, object]], **changes: object) -> FirstContact:
    """The answer with these changes; `places` tells what else is different of the fields of LATER, when one is read."""
    asked = (*LATER, LAST)
    known = {name: getattr(found, name) for name in FirstContact.__dataclass_fields__ if name not in asked}

    def rest() -> dict[str, object]:
        told = {name: getattr(found, name) for name in LATER} | places() | changes
        return told | {"_rest": lambda: {LAST: getattr(found, LAST)}}

    return FirstContact.deferring({**known, **changes}, rest, LAST)


def told_later(found: FirstContact, ask: Callable[[], FirstContact | None]) -> FirstContact:
    """A contact: what touches, and how where that is not known, is what `ask` tells when it is read; as found where it
    has None."""
    def places() -> dict[str, object]:
        told = ask()
        return {} if told is None else {name: getattr(told, name) for name in LATER}

    return waiting(found, places, **({} if found.initial is None else {"initial": found.initial}))


def changed(found: R, **changes: Any) -> R:
    """The answer with these changes; what it tells of the place of contact goes on waiting."""
    return replace(found, **changes) if isinstance(found, ContactIntervals) else waiting(found, dict, **changes)
