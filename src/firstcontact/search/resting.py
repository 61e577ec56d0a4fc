"""Two solids at rest: an exact point inside both, or a proof that they share no point, however thin overlap or gap are.

Unions of convex pieces are told pair by pair of pieces: by doubles with proofs first, else by the point that is deepest
in both, in balls; a rational point near it has exact signs.
"""

from __future__ import annotations

from flint import fmpq

from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.relative import curved_pieces
from firstcontact.search.advance import PieceSearch
from firstcontact.search.close_up import CloseUp
from firstcontact.search.convex import ConvexPieces, NotConvex, convex_pieces, covering_pieces
from firstcontact.search.relation import Relation
from firstcontact.search.separation import NoFunction, Separation
from firstcontact.search.stretches import windows
from firstcontact.search.tips import Solid, at_tips, is_inside

NOTHING = fmpq(1, 2**180)
"""Of the size: a depth or a distance that balls do not tell from none."""
START = fmpq(0)


def relation(a: CompositeQuadric, b: CompositeQuadric) -> Relation | None:
    """How the bounded solids lie to each other; None where it is not told, as for most that are not convex."""
    try:
        return _of_pieces(a, b, convex_pieces(a), convex_pieces(b))
    except NotConvex:
        pass
    try:
        covers = PieceSearch(covering_pieces(a), covering_pieces(b), windows(a, b, START, START), 1.0, 1)
    except NotConvex:
        return None
    return None if covers.not_apart(0.0)[0] else Relation.APART


def is_one_piece(body: CompositeQuadric) -> bool:
    """Whether the solid is one convex piece."""
    try:
        return convex_pieces(body).count == 1
    except NotConvex:
        return False


def _of_pieces(a: CompositeQuadric, b: CompositeQuadric, own: ConvexPieces, other: ConvexPieces) -> Relation | None:
    pairs, overlap = PieceSearch(own, other, windows(a, b, START, START), 1.0, 1).not_apart(0.0)
    if overlap:
        return Relation.OVERLAPPING
    found: Relation | None = Relation.APART
    (rest,) = curved_pieces(a, b, START, START + 1)
    for i, j in pairs:
        try:
            system = CloseUp(rest, own, i, other, j).separation
        except NoFunction:
            found = None
            continue
        seen = _of_pair(system, own.solids[i], other.solids[j])
        if seen is Relation.OVERLAPPING:
            return seen
        if seen is None or found is Relation.APART:
            found = seen
    return found


def _of_pair(system: Separation, own: Solid, other: Solid) -> Relation | None:
    """Of two convex pieces."""
    forms = [*own[0], *other[0]]
    guess = system.guess(START)
    rough = guess or system.roughly(START)
    if rough is not None and is_inside(forms, rough.x):
        return Relation.OVERLAPPING
    state = None if guess is None else system.least(guess)
    if state is None:
        return at_tips(own, other)
    if is_inside(forms, state.x):
        return Relation.OVERLAPPING
    if system.is_apart(state):
        return Relation.APART
    return Relation.NEAR if abs(state.s) <= NOTHING * exact_value(system.size) else at_tips(own, other)
