"""Motions as values: equal where they hold the same numbers, and written as scene files have them."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Any

from flint import fmpq

from firstcontact.exact.numbers import to_double
from firstcontact.result import SCHEMA, Written

if TYPE_CHECKING:
    from firstcontact.exact.vectors import Vector
    from firstcontact.result import Table

# Whole numbers up to there are JSON numbers for every reader; larger ones are texts.
LARGEST_WHOLE = 2**53


class Motion(Written):
    """Equal to motions of its class with the same exact numbers.  The hash is kept: searches look motions up by it."""

    __slots__ = ("_hash",)
    _hash: int

    def _facts(self) -> tuple[Hashable, ...]:
        """The numbers that make the motion what it is, hashable."""
        raise NotImplementedError

    def _quick(self) -> Iterable[fmpq]:
        """Some of these numbers, enough to tell most motions apart."""
        raise NotImplementedError

    def _table(self) -> Table:
        """The motion as a table of a scene file."""
        raise NotImplementedError

    @property
    def exact_span(self) -> tuple[fmpq, fmpq] | None:
        """The exact first and last time at which it has a pose; None where it goes on beyond its span."""
        return None

    @property
    def rests(self) -> bool:
        """Whether it is known to leave bodies where they are at all times."""
        return False

    @property
    def is_rigid(self) -> bool:
        """Whether its poses are rotations and shifts."""
        return True

    @property
    def is_rational(self) -> bool:
        """Whether its pose is known to be a rational function of the time."""
        return False

    @property
    def is_one_step(self) -> bool:
        """Whether it is known to go on in one way all the time, and to be none of a plainer kind."""
        return False

    @property
    def axes(self) -> tuple[Vector, ...] | None:
        """The directions of the axes about which it turns, by whatever angles; None where they are not told."""
        return None

    @property
    def generators(self) -> tuple[tuple[Vector, Vector], ...] | None:
        """(w, v) of the turn and the shift that it is made of at all times: points x have the velocity w x x + v, those
        of the turn up to a factor.  None of other motions."""
        return None

    def is_across(self, normal: Vector) -> bool:
        """Whether it is known to be made of shifts across the normal and turns about it alone."""
        return False

    def to_dict(self) -> Table:
        """The motion's table in a scene file; exact numbers that no double holds are texts such as "1/3"."""
        return {"schema": SCHEMA, **self._table()}

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Motion) or type(self) is not type(other):
            return NotImplemented
        return self._facts() == other._facts()

    def __hash__(self) -> int:
        try:
            return self._hash
        except AttributeError:
            self._hash = hash(tuple([x.p for x in self._quick()]))  # a rational number takes microseconds to hash
            return self._hash


def number(x: fmpq) -> int | float | str:
    """An exact number as scene files and JSON have it: a double where one holds it, else a text.

    >>> number(fmpq(3)), number(fmpq(1, 2)), number(fmpq(1, 10)), number(fmpq(2) ** 60)
    (3, 0.5, '1/10', '1152921504606846976')
    """
    if x.q == 1:
        return int(x.p) if abs(x.p) <= LARGEST_WHOLE else str(x)
    near = to_double(x)
    return near if fmpq(*near.as_integer_ratio()) == x else str(x)


def numbers(values: Any) -> Any:
    """`number` of exact numbers in tuples or lists of any depth."""
    return number(values) if isinstance(values, fmpq) else [numbers(x) for x in values]
