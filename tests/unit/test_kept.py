"""What is made of a body once."""

from __future__ import annotations

import pytest

import firstcontact as fc
from firstcontact.search.trees.kept import kept


class Refused(Exception):
    pass


def test_it_is_made_once():
    body, made = fc.sphere(1), []
    for _ in range(2):
        assert kept(body, "name", lambda: made.append(1) or "thing", Refused) == "thing"
    assert len(made) == 1


def test_a_refusal_is_kept_and_raised_again():
    body, asked = fc.sphere(1), []

    def refuse():
        asked.append(1)
        raise Refused("why")

    for _ in range(2):
        with pytest.raises(Refused, match="why"):
            kept(body, "name", refuse, Refused)
    assert len(asked) == 1


def test_what_is_no_refusal_is_not_kept():
    body = fc.sphere(1)
    with pytest.raises(ZeroDivisionError):
        kept(body, "name", lambda: 1 / 0, Refused)
    assert kept(body, "name", lambda: 2, Refused) == 2
