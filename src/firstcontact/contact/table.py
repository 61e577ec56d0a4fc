"""Who answers: the kinds of bodies, the room for each pair of them, and what it proves.

`python -m firstcontact.contact.table` prints the table of the docs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache, partial
from importlib import import_module
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeVar, overload

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact import at_once, centred, common_shift, jumps, one_motion, plain
from firstcontact.contact.runs import along, linked, one_joint, turns
from firstcontact.errors import UnsupportedPair
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.span import refuse_late
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.value import Motion
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact, Status
from firstcontact.timeline.answers import as_far_as_decided
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import AnyBody


class Kind(Enum):
    """Kinds of bodies, the simpler one first."""

    __hash__ = object.__hash__  # enumerations hash their names, in Python

    MESH = "Polyhedron"
    MODEL = "CompositeQuadric"
    RULED = "RuledSurface"
    TORUS = "Torus"
    PART = "Compound"


EXACT, CERTIFIED, NOT = "exact; else certified", "certified", "no"
"""What a verb proves of a pair: exact times where the relative pose is a rational function of one parameter, certified
ones under all other motions; certified ones under all; nothing."""
CONVEX = "exact; else certified, of solids not convex up to the first contact"
PIECES = "as of its pieces"
VERBS = "first_contact", "contact_intervals", "contact_pairs", "intersection_curve"


@dataclass(frozen=True)
class Pair:
    """Two kinds of bodies: the room that answers, and what it proves, by `VERBS`.  Curves are of bodies at rest."""

    room: str
    proves: tuple[str, str, str, str]


PAIRS = {
    (Kind.MESH, Kind.MESH): Pair("polyhedra", (EXACT, EXACT, EXACT, NOT)),
    (Kind.MESH, Kind.MODEL): Pair("mesh_model", (EXACT, EXACT, NOT, NOT)),
    (Kind.MESH, Kind.RULED): Pair("ruled", (EXACT, CONVEX, NOT, "exact")),
    (Kind.MODEL, Kind.MODEL): Pair("models", (EXACT, EXACT, NOT, NOT)),
    (Kind.MODEL, Kind.RULED): Pair("ruled_solid", (EXACT, EXACT, NOT, "exact")),
    (Kind.RULED, Kind.RULED): Pair("ruled", (EXACT, EXACT, NOT, "exact")),
    (Kind.MESH, Kind.TORUS): Pair("torus", (CERTIFIED, CERTIFIED, NOT, NOT)),
    (Kind.MODEL, Kind.TORUS): Pair("torus", (CERTIFIED, CERTIFIED, NOT, NOT)),
    (Kind.RULED, Kind.TORUS): Pair("torus", (CERTIFIED, CERTIFIED, NOT, NOT)),
    (Kind.TORUS, Kind.TORUS): Pair("torus", (CERTIFIED, CERTIFIED, NOT, NOT)),
    (Kind.MESH, Kind.PART): Pair("compound", (PIECES, PIECES, NOT, NOT)),
    (Kind.MODEL, Kind.PART): Pair("compound", (PIECES, PIECES, NOT, NOT)),
    (Kind.RULED, Kind.PART): Pair("compound", (PIECES, PIECES, NOT, NOT)),
    (Kind.TORUS, Kind.PART): Pair("compound", (CERTIFIED, CERTIFIED, NOT, NOT)),
    (Kind.PART, Kind.PART): Pair("compound", (PIECES, PIECES, NOT, NOT)),
}
"""Rooms are loaded when they are asked: meshes need not load curved models."""
INSTEAD = {
    "contact_pairs": "first_contact(..., method='algebraic') lists the features of solids",
    "intersection_curve": "the boundaries of solids meet in the edges of a & b",
}
"""What to ask of pairs that a verb does not take."""
_OF_STEPS = Sequence, Trajectory
MESHES = Kind.MESH, Kind.MESH
_KINDS = {kind.value: kind for kind in Kind}
_SORTED = {pair: (x, y) for x, y in combinations_with_replacement(Kind, 2) for pair in ((x, y), (y, x))}

R = TypeVar("R", FirstContact, ContactIntervals)


def as_body(body: AnyBody) -> Any:
    """A mesh of trimesh as a Polyhedron, a shape of build123d or CadQuery as a Compound; what is a body as it is."""
    if hasattr(body, "wrapped") and not hasattr(body, "moving"):
        from firstcontact import from_shape

        return from_shape(body)
    if hasattr(body, "as_body"):  # a part or an assembly of a STEP file
        return body.as_body()
    is_mesh = not hasattr(body, "moving") and not isinstance(body, Moving) and hasattr(body, "faces")
    return Polyhedron.from_trimesh(body) if is_mesh else body


def kind_of(body: AnyBody) -> Kind:
    """UnsupportedPair for what is no body."""
    kind = _KINDS.get(str(getattr(shape_of(body), "kind", None)))
    if kind is None:
        kinds = ", ".join(kind.value for kind in Kind)
        raise UnsupportedPair(f"{body!r} is no body; give one of {kinds}, at rest or moving")
    return kind


def kinds_of(a: AnyBody, b: AnyBody) -> tuple[Kind, Kind]:
    """Of both bodies, the simpler one first."""
    return _SORTED[kind_of(a), kind_of(b)]


def proves(verb: str, a: AnyBody, b: AnyBody) -> str:
    """What a verb proves of two bodies.  UnsupportedPair, which tells what would do instead, where it takes no such."""
    told = PAIRS[kinds_of(a, b)].proves[VERBS.index(verb)]
    if told == NOT:
        taken = ", ".join(
            f"{x.value} with {y.value}" for (x, y), pair in PAIRS.items() if pair.proves[VERBS.index(verb)] != NOT
        )
        raise UnsupportedPair(f"{verb} is for {taken}, not for {a!r} with {b!r}; {INSTEAD[verb]}")
    return told


def matrix() -> str:
    """The table as docs/motions.md has it."""
    rows = [("bodies", *(f"`{verb}`" for verb in VERBS)), ("---",) * (1 + len(VERBS))]
    rows += [(f"`{x.value}`, `{y.value}`", *pair.proves) for (x, y), pair in PAIRS.items()]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def first_contact(query: Query) -> FirstContact:
    """The answer of the room for the bodies."""
    if _is_of_one_step(query):
        return _answer("first", query, one_step=True)
    whole = partial(along.first, partial(plain.asked, _first))
    return linked.first(partial(one_joint.first, whole), query)


def contact_intervals(query: Query) -> ContactIntervals:
    """The answer of the room for the bodies."""
    if _is_of_one_step(query):
        return as_far_as_decided(_answer("intervals", query, one_step=True))
    whole = partial(along.intervals, partial(plain.asked, _intervals))
    return as_far_as_decided(linked.intervals(partial(one_joint.intervals, whole), query))


def contact_pairs(query: Query) -> ContactPairs:
    """The answer of the room for the bodies."""
    proves("contact_pairs", *query.bodies)
    return linked.pairs(_room(PAIRS[kinds_of(*query.bodies)].room).pairs, query)


def _is_of_one_step(query: Query) -> bool:
    """Whether one body at most moves, in one step: most questions, of whose motions nothing is taken apart or joined.

    What is a plainer motion, such as a screw that only turns, is asked about as that instead.
    """
    a, b = query.a, query.b
    if plain.deforms(a) or plain.deforms(b):  # one may be a body that shifts
        return False
    if not isinstance(a, Moving):
        a, b = b, a
    if not isinstance(a, Moving):
        return True
    return not isinstance(b, Moving) and isinstance(a.motion, Motion) and a.motion.is_one_step


def _turns(query: Query) -> bool:
    """Whether a body turns about a line all the time, and may come round."""
    return any(isinstance(x, Moving) and isinstance(x.motion, Rotation) for x in query.bodies)


def _first(query: Query) -> FirstContact:
    return one_motion.asked(lambda own: _answer("first", own), query)


def _intervals(query: Query) -> ContactIntervals:
    return one_motion.asked(lambda own: _answer("intervals", own), query)


class _Room(Protocol):
    """What answers for a pair of kinds: the module `first` of its folder; `pairs` is that of polyhedra."""

    def first(self, query: Query) -> FirstContact: ...
    def intervals(self, query: Query) -> ContactIntervals: ...
    def pairs(self, query: Query) -> ContactPairs: ...


@overload
def _answer(verb: Literal["first"], query: Query, one_step: bool = False) -> FirstContact: ...
@overload
def _answer(verb: Literal["intervals"], query: Query, one_step: bool = False) -> ContactIntervals: ...
def _answer(verb: str, query: Query, one_step: bool = False) -> Any:
    """What the room for the bodies says; where that leaves it open, what the heights of the bodies tell, or of a first
    contact all contacts.

    one_step: known to be so; of bodies that move in several steps heights are asked first.
    """
    known = _by_heights(verb, query, None) if not one_step and _is_of_steps(query) and _has_heights(query) else None
    if known is not None:
        return known
    found = _of_room(verb, query)
    if found.status is not Status.UNDECIDED or not _has_heights(query):
        return found
    more = _by_heights(verb, query, found)
    if more is None and verb == "first" and query.first < query.end and Kind.RULED not in kinds_of(*query.bodies):
        from firstcontact.contact import by_all_contacts  # few questions need it

        more = by_all_contacts.first(query, found, lambda own: _answer("intervals", own))
    return found if more is None else more


def _has_heights(query: Query) -> bool:
    """Whether heights may answer."""
    return query.is_auto and query.budget is None and query.last is not None


def _by_heights(verb: str, query: Query, found: Any) -> Any:
    """What the heights of the bodies tell, of what is found or not asked yet; None where they do not."""
    from firstcontact.contact.heights import told  # few questions need it

    return getattr(told, verb)(query, found, _of_room)


def _is_of_steps(query: Query) -> bool:
    """Whether a body moves in several steps."""
    return any(isinstance(x, Moving) and isinstance(x.motion, _OF_STEPS) for x in query.bodies)


def _of_room(verb: str, query: Query) -> Any:
    """The same of curved bodies about bounded spans near the origin."""
    kinds = kinds_of(*query.bodies)
    if kinds == MESHES or Kind.PART in kinds:
        return _asked(_room(PAIRS[kinds].room), verb)(query)
    if query.engine != "auto":
        raise UnsupportedPair(f"engine {query.engine!r} searches trees of polyhedra; curved models take 'auto'")
    refuse_late((query.first, query.last))
    near: Callable[[Query], Any] = partial(getattr(centred, verb), _asked(_curved(kinds, query), verb))
    if not _is_of_one_step(query):
        near = partial(getattr(jumps, verb), partial(common_shift.asked, near))
    if query.last is not None and not _turns(query):
        return _said(near(query), query)
    from firstcontact.contact import endless

    if query.last is None:
        return _said(getattr(endless, verb)(near, query), query)
    if verb == "intervals":
        return _said(turns.intervals(near, query), query)
    return _said(endless.in_one_turn(near, query), query)


def _asked(room: _Room, verb: str) -> Callable[[Query], Any]:
    """What the room tells; of one instant, whether there is contact."""
    return partial(at_once.first if verb == "first" else at_once.intervals, room)


def _said(answer: R, query: Query) -> R:
    """The answer, which names no budget but the caller's: one of a search's own is a limit to what it can tell."""
    own = answer.reason == "budget" and not query.is_spent(answer.reason)
    return replace(answer, reason="precision") if own else answer


def _curved(kinds: tuple[Kind, Kind], query: Query) -> _Room:
    """The room of a pair that is not two polyhedra; a small convex polyhedron is a model beside a model."""
    if kinds == (Kind.MESH, Kind.MODEL):
        from firstcontact.contact.reduce import is_small_and_convex

        mesh = next(shape_of(x) for x in query.bodies if kind_of(x) is Kind.MESH)
        if is_small_and_convex(mesh):
            return _room("models")
    return _room(PAIRS[kinds].room)


@cache
def _room(name: str) -> _Room:
    room: Any = import_module(f"firstcontact.contact.{name}.first")
    found: _Room = room
    return found


if __name__ == "__main__":
    print(matrix())
