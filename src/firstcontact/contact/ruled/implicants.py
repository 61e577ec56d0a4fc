"""Which signs tell accepted places from rejected ones: a short disjunction of conjunctions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Signs = tuple[int, ...]
Term = dict[int, int]
"""The sign of the polynomial with this number, which zero satisfies too; 0: it is zero."""


def implicants(inside: Iterable[Signs], outside: Iterable[Signs]) -> list[Term] | None:
    """Terms one of which every sign vector inside satisfies, and none outside; None where some are both.

    No polynomial is used that the others make up for (the first ones stay), no term has a sign too many, and none is
    left that the others cover.
    """
    inside, outside = set(inside), set(outside)
    if inside & outside:
        return None
    keep = list(range(len(next(iter(inside | outside), ()))))
    for k in reversed(keep):
        rest = [i for i in keep if i != k]
        if not {part(x, rest) for x in inside} & {part(x, rest) for x in outside}:
            keep = rest
    wanted, refused = ({part(x, keep) for x in some} for some in (inside, outside))
    found: list[Term] = []
    for signs in sorted(wanted):
        term = dict(enumerate(signs))
        for k in reversed(range(len(keep))):
            shorter = {i: s for i, s in term.items() if i != k}
            if not any(_satisfies(x, shorter) for x in refused):
                term = shorter
        if term not in found:
            found.append(term)
    for term in found[::-1]:
        others = [x for x in found if x is not term]
        if all(any(_satisfies(signs, x) for x in others) for signs in wanted):
            found = others
    return [{keep[k]: s for k, s in term.items()} for term in found]


def part(signs: Signs, indices: Sequence[int]) -> Signs:
    return tuple(signs[k] for k in indices)


def _satisfies(signs: Signs, term: Term) -> bool:
    return all(signs[k] == s for k, s in term.items())
