"""Two solids at one instant: a point inside both, or a proof that they share none, however thin overlap or gap are.

Unions of convex pieces are told pair by pair of pieces: by doubles with proofs first, else by the point that is deepest
in both, in balls; a rational point near it has exact signs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.solid.carriers import ONE, ZERO, inverse
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.exact.numbers import exact_value, fraction
from firstcontact.exact.rigid import Matrix, apply
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.motion.relative.stretches import windows
from firstcontact.search.convex.advance import PieceSearch
from firstcontact.search.convex.close_up import CloseUp
from firstcontact.search.convex.convex import ConvexPieces, NotConvex, convex_pieces, covering_pieces
from firstcontact.search.convex.relation import Relation
from firstcontact.search.convex.separation import NoFunction, Separation
from firstcontact.search.convex.tips import Solid, at_tips, is_inside, tip_inside

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

NOTHING = fmpq(1, 2**180)
"""Of the size: a depth or a distance that balls do not tell from none."""
START = fmpq(0)


def relation(a: CompositeQuadric, b: CompositeQuadric, pose: Matrix) -> Relation | None:
    """How the bounded solids, a in the pose, lie to each other; None where it is not told, as for most not convex."""
    there = _there(a, pose)
    try:
        return _of_pieces(there, b, pose)
    except NotConvex:
        pass
    try:
        covers = PieceSearch(covering_pieces(a), covering_pieces(b), windows(there, b, START, START), 1.0, 1)
    except NotConvex:
        return None
    return None if covers.not_apart(0.0)[0] else Relation.APART


def relation_in_doubles(a: CompositeQuadric, b: CompositeQuadric, pose: Matrix) -> Relation | None:
    """What doubles with proofs tell of it, at little cost; None where that is nothing."""
    there = _there(a, pose)
    try:
        own, other, exactly = convex_pieces(a), convex_pieces(b), True
    except NotConvex:
        try:
            own, other, exactly = covering_pieces(a), covering_pieces(b), False
        except NotConvex:
            return None
    pairs, overlap = PieceSearch(own, other, windows(there, b, START, START), 1.0, 1).not_apart(0.0)
    if overlap and exactly:
        return Relation.OVERLAPPING
    return None if pairs or overlap else Relation.APART


def _there(a: CompositeQuadric, pose: Matrix) -> Moving:
    return a.moving(RationalMotion([[*([fraction(x) for x in row] for row in pose), [0, 0, 0, 1]]]))


def is_one_piece(body: CompositeQuadric) -> bool:
    """Whether the solid is one convex piece."""
    try:
        return convex_pieces(body).count == 1
    except NotConvex:
        return False


@dataclass(frozen=True)
class Place:
    """How two convex pieces lie to each other; None where it is not told.

    point: inside both where they overlap; outside: whether it is proved that neither has inner points in the other.
    """

    relation: Relation | None
    point: Sequence[fmpq] | None = None
    outside: bool = False


def places(a: Body, b: Body, t: fmpq) -> list[Place]:
    """How solid a, one convex piece, lies at time t to every convex piece that b is made of, or covered by.

    a, b: at rest or moving; points are in the frame of b's shape.  Raises NotConvex.
    """
    own, other = convex_pieces(shape_of(a)), pieces_of(shape_of(b))
    doubles = PieceSearch(own, other, windows(a, b, t, t), 1.0, 1)
    (motion,) = curved_pieces(a, b, t, t)
    rest = not (isinstance(a, Moving) or isinstance(b, Moving))
    start = doubles.windows[0].first  # rounded, where t is no double
    found = []
    for j in range(other.count):
        if exact_value(start) == t and doubles.is_apart(0, j, start):
            found.append(Place(Relation.APART))
            continue
        try:
            system = CloseUp(motion, own, 0, other, j).separation
        except NoFunction:
            found.append(Place(None))
            continue
        found.append(_of_pair(system, own.solids[0], other.solids[j]) if rest else _at(system, t))
    return found


def pieces_of(body: CompositeQuadric) -> ConvexPieces:
    """The convex pieces that make up a body, else those that cover it.  Raises NotConvex."""
    try:
        return convex_pieces(body)
    except NotConvex:
        return covering_pieces(body)


def _of_pieces(a: Moving, b: CompositeQuadric, pose: Matrix) -> Relation | None:
    own, other = convex_pieces(shape_of(a)), convex_pieces(b)
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
        seen = _of_pair(system, _placed(own.solids[i], pose), other.solids[j]).relation
        if seen is Relation.OVERLAPPING:
            return seen
        if seen is None or found is Relation.APART:
            found = seen
    return found


def _placed(solid: Solid, pose: Matrix) -> Solid:
    back = inverse((*pose, (ZERO, ZERO, ZERO, ONE)))
    forms, inner = solid
    moved = None if inner is None else apply(pose, (inner[0], inner[1], inner[2]))
    return [form.placed(back) for form in forms], moved


def _of_pair(system: Separation, own: Solid, other: Solid) -> Place:
    """Of two convex pieces at rest."""
    forms = [*own[0], *other[0]]
    guess = system.guess(START)
    rough = guess or system.roughly(START)
    if rough is not None and is_inside(forms, rough.x):
        return Place(Relation.OVERLAPPING, rough.x)
    state = None if guess is None else system.least(guess)
    if state is None:
        return _by_tips(own, other)
    if is_inside(forms, state.x):
        return Place(Relation.OVERLAPPING, state.x)
    if system.is_apart(state):
        return Place(Relation.APART)
    near = abs(state.s) <= NOTHING * exact_value(system.size)
    return Place(Relation.NEAR) if near else _by_tips(own, other)


def _by_tips(own: Solid, other: Solid) -> Place:
    return Place(at_tips(own, other), tip_inside(own, other))


def _at(system: Separation, t: fmpq) -> Place:
    """Of two convex pieces at a time, by balls alone."""
    guess = system.guess(t)
    rough = guess or system.roughly(t)
    if rough is not None and rough.s < 0 and system.shares(t, rough.x):
        return Place(Relation.OVERLAPPING, rough.x)
    state = None if guess is None else system.least(guess)
    if state is None:
        return Place(None)
    if abs(state.s) <= NOTHING * exact_value(system.size):
        return Place(Relation.NEAR)
    if state.s < 0 and system.shares(t, state.x):
        return Place(Relation.OVERLAPPING, state.x)
    return Place(Relation.APART if system.is_apart(state) else None)
