"""Boolean combinations of half-spaces, and what they make of the signs of their surfaces.

A leaf is the half-space where its surface's form is <= 0.  Where no form vanishes at a point the Boolean value alone
tells inside from outside.  Where some vanish, the sign patterns around the point decide (regularised sets, Choi et
al. 2014, section 2; the rule for dependent gradients is re-derived): inside and outside both occur on the boundary.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import numpy as np

Truth = TypeVar("Truth", bool, "np.ndarray")


@dataclass(frozen=True, slots=True)
class Leaf:
    """Where the form of surface `surface` is negative."""

    surface: int


@dataclass(frozen=True, slots=True)
class And:
    first: Tree
    second: Tree


@dataclass(frozen=True, slots=True)
class Or:
    first: Tree
    second: Tree


@dataclass(frozen=True, slots=True)
class Not:
    inner: Tree


Tree = Leaf | And | Or | Not


def inside(tree: Tree, negative: Sequence[Truth]) -> Truth:
    """The raw Boolean value; negative[i]: whether form i is negative, as bools or as arrays of bools."""
    if isinstance(tree, Leaf):
        return negative[tree.surface]
    value: Truth
    if isinstance(tree, Not):
        inner = inside(tree.inner, negative)
        value = not inner if isinstance(inner, bool) else ~inner
    else:
        first, second = inside(tree.first, negative), inside(tree.second, negative)
        value = first & second if isinstance(tree, And) else first | second
    return value


def possible(tree: Tree, below: Sequence[Truth], above: Sequence[Truth]) -> tuple[Truth, Truth]:
    """(may be inside, may be outside), bools or arrays, where form i may be negative (below) or positive (above)."""
    if isinstance(tree, Leaf):
        return below[tree.surface], above[tree.surface]
    if isinstance(tree, Not):
        in_, out = possible(tree.inner, below, above)
        return out, in_
    (in_a, out_a), (in_b, out_b) = possible(tree.first, below, above), possible(tree.second, below, above)
    return (in_a & in_b, out_a | out_b) if isinstance(tree, And) else (in_a | in_b, out_a & out_b)


def outcomes(tree: Tree, signs: Sequence[int]) -> set[bool]:
    """The Boolean values of all patterns that agree with `signs` (-1, 0, 1), a 0 standing for either sign.

    {True, False}: a point with these signs is on the regularised boundary if the vanishing forms have independent
    gradients there.  {False}: it is outside, {True}: inside, whatever the gradients.
    """
    return _values(tree, signs, None)


def _values(tree: Tree, signs: Sequence[int], often: Sequence[int] | None) -> set[bool]:
    """`outcomes`; often: the vanishing surfaces that several leaves name, None where they are not told yet.

    What parts of the tree may be tells exactly what their union or intersection may be where they share no vanishing
    surface; where they do, it tells too much at most, and the shared surfaces take either sign in turn.
    """
    inside_, outside = possible(tree, [x <= 0 for x in signs], [x >= 0 for x in signs])
    if not (inside_ and outside):
        return {inside_}
    often = _often(tree, signs) if often is None else often
    if not often:
        return {True, False}
    found = set[bool]()
    for sign in (-1, 1):
        found |= _values(tree, [*signs[: often[0]], sign, *signs[often[0] + 1 :]], often[1:])
        if len(found) == 2:
            break
    return found


def _often(tree: Tree, signs: Sequence[int]) -> list[int]:
    """The vanishing surfaces that several leaves name."""
    count = Counter(_leaves(tree))
    return [i for i, sign in enumerate(signs) if sign == 0 and count[i] > 1]


def borders(tree: Tree, signs: Sequence[int], surface: int, orientation: int) -> bool:
    """Whether some pattern that agrees with `signs` is inside on that side of the surface and outside on the other.

    orientation: as of `features.Face`.  Necessary for a point with these signs to be on that face, and enough where the
    vanishing forms have independent gradients.
    """
    return _borders(tree, signs, surface, orientation > 0, None)


def _borders(tree: Tree, signs: Sequence[int], surface: int, side: bool, often: Sequence[int] | None) -> bool:
    """`borders`, by the signs of surfaces that several leaves name in turn, as `_values`."""
    if (True, False) not in _sides(tree, signs, surface, side):
        return False
    often = [i for i in _often(tree, signs) if i != surface] if often is None else often
    if not often:
        return True
    k, rest = often[0], often[1:]
    return any(_borders(tree, [*signs[:k], sign, *signs[k + 1 :]], surface, side, rest) for sign in (-1, 1))


def _sides(tree: Tree, signs: Sequence[int], surface: int, side: bool) -> set[tuple[bool, bool]]:
    """The Boolean values, on that side of the surface and on the other, that patterns may have."""
    if isinstance(tree, Leaf):
        if tree.surface == surface:
            return {(side, not side)}
        sign = signs[tree.surface]
        return {(value, value) for value, may in ((True, sign <= 0), (False, sign >= 0)) if may}
    if isinstance(tree, Not):
        return {(not x, not y) for x, y in _sides(tree.inner, signs, surface, side)}
    pairs = product(*(_sides(part, signs, surface, side) for part in (tree.first, tree.second)))
    if isinstance(tree, And):
        return {(x and u, y and v) for (x, y), (u, v) in pairs}
    return {(x or u, y or v) for (x, y), (u, v) in pairs}


def pattern(signs: Sequence[int], on: Iterable[int], negative: Iterable[bool]) -> list[bool]:
    """`signs` as booleans, with those of the surfaces `on` replaced."""
    values = [sign < 0 for sign in signs]
    for i, value in zip(on, negative, strict=True):
        values[i] = value
    return values


def renumbered(tree: Tree, leaves: Sequence[Tree]) -> Tree:
    """The tree with leaf i replaced by leaves[i]."""
    if isinstance(tree, Leaf):
        return leaves[tree.surface]
    if isinstance(tree, Not):
        inner = renumbered(tree.inner, leaves)
        return inner.inner if isinstance(inner, Not) else Not(inner)
    return type(tree)(renumbered(tree.first, leaves), renumbered(tree.second, leaves))


def surfaces_of(tree: Tree) -> set[int]:
    return set(_leaves(tree))


def _leaves(tree: Tree) -> Iterator[int]:
    """The surface of each leaf."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Leaf):
            yield node.surface
        else:
            waiting += [node.inner] if isinstance(node, Not) else [node.first, node.second]


def conjunction(trees: Sequence[Tree]) -> Tree:
    """The intersection of all, nested evenly so that depth grows with the logarithm."""
    if len(trees) == 1:
        return trees[0]
    half = len(trees) // 2
    return And(conjunction(trees[:half]), conjunction(trees[half:]))
