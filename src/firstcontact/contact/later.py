"""What an answer tells of the place of contact, worked out when it is first read."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact.result import FirstContact

LATER = (
    "point", "normal", "element_a", "element_b", "others", "multiplicity", "contact_set", "initial", "subproblems",
)  # fmt: skip
"""The fields that may wait."""


def waiting(found: FirstContact, places: Callable[[], dict[str, object]], **changes: object) -> FirstContact:
    """The answer with these changes; `places` tells what else is different of the fields of LATER, when one is read."""
    known = {name: getattr(found, name) for name in FirstContact.__dataclass_fields__ if name not in LATER}

    def rest() -> dict[str, object]:
        return {name: getattr(found, name) for name in LATER} | places() | changes

    return FirstContact.deferring({**known, **changes}, rest)
