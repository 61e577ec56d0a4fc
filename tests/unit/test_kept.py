"""What is made of a body once."""

from __future__ import annotations

import pytest

import firstcontact as fc
from firstcontact.body.kept import Kept


class Refused(Exception):
    pass


def test_it_is_made_once():
    body, made, place = fc.sphere(1), [], Kept[str]()
    for _ in range(2):
        assert place.of(body, lambda: made.append(1) or "thing") == "thing"
        assert place.of_or_refusal(body, lambda: made.append(1) or "thing", Refused) == "thing"
    assert len(made) == 1 and place.get(body) == "thing" and place.get(fc.sphere(1)) is None


def test_a_refusal_is_kept_and_raised_again():
    body, asked, place = fc.sphere(1), [], Kept[str]()

    def refuse():
        asked.append(1)
        raise Refused("why")

    for _ in range(2):
        with pytest.raises(Refused, match="why"):
            place.of_or_refusal(body, refuse, Refused)
    assert len(asked) == 1


def test_what_is_no_refusal_is_not_kept():
    body, place = fc.sphere(1), Kept[int]()
    with pytest.raises(ZeroDivisionError):
        place.of_or_refusal(body, lambda: 1 // 0, Refused)
    assert place.of_or_refusal(body, lambda: 2, Refused) == 2
