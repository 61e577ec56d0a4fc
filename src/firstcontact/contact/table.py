"""Who answers: the kinds of bodies, and the room for each pair of them."""

from __future__ import annotations

from enum import Enum
from functools import cache, partial
from importlib import import_module
from typing import Any

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact import centred
from firstcontact.errors import UnsupportedPair
from firstcontact.motion.moving import shape_of
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact
from firstcontact.work import Query


class Kind(Enum):
    """Kinds of bodies, the simpler one first."""

    MESH = "Polyhedron"
    MODEL = "CompositeQuadric"
    RULED = "RuledSurface"


ROOMS = {
    (Kind.MESH, Kind.MESH): "polyhedra",
    (Kind.MESH, Kind.MODEL): "mesh_model",
    (Kind.MESH, Kind.RULED): "ruled",
    (Kind.MODEL, Kind.MODEL): "models",
    (Kind.MODEL, Kind.RULED): "ruled_solid",
    (Kind.RULED, Kind.RULED): "ruled",
}
"""Loaded when they are asked: meshes need not load curved models."""
MESHES = Kind.MESH, Kind.MESH
_KINDS = {"CompositeQuadric": Kind.MODEL, "RuledSurface": Kind.RULED, "RuledStrip": Kind.RULED}
_ORDER = list(Kind)


def kind_of(body: Any) -> Kind:
    """UnsupportedPair for what is no body."""
    shape: Any = shape_of(body)
    kind = Kind.MESH if isinstance(shape, Polyhedron) else _KINDS.get(type(shape).__name__)
    if kind is None:
        raise UnsupportedPair(
            f"{body!r} is no body; give a Polyhedron, a CompositeQuadric or a RuledSurface, at rest or moving"
        )
    return kind


def kinds_of(a: Any, b: Any) -> tuple[Kind, Kind]:
    """Of both bodies, the simpler one first."""
    one, other = kind_of(a), kind_of(b)
    return (one, other) if _ORDER.index(one) <= _ORDER.index(other) else (other, one)


def first_contact(query: Query) -> FirstContact:
    """The answer of the room for the bodies."""
    kinds = kinds_of(*query.bodies)
    if kinds == MESHES:
        found: FirstContact = _room("polyhedra").first_contact(query)
        return found
    if query.engine != "auto":
        raise UnsupportedPair(f"engine {query.engine!r} searches trees of polyhedra; curved models take 'auto'")
    room = _curved(kinds, query)
    if query.last is None:
        from firstcontact.contact import endless

        return endless.first_contact(partial(centred.first_contact, room.first_contact), query)
    return centred.first_contact(room.first_contact, query)


def contact_intervals(query: Query) -> ContactIntervals:
    """The answer of the room for the bodies."""
    kinds = kinds_of(*query.bodies)
    if kinds == MESHES:
        found: ContactIntervals = _room("polyhedra").contact_intervals(query)
        return found
    room = _curved(kinds, query)
    if query.last is None:
        from firstcontact.contact import endless

        return endless.contact_intervals(partial(centred.contact_intervals, room.contact_intervals), query)
    return centred.contact_intervals(room.contact_intervals, query)


def contact_pairs(query: Query) -> ContactPairs:
    """Of two polyhedra."""
    if kinds_of(*query.bodies) != MESHES:
        raise UnsupportedPair("contact_pairs is for polyhedra; first_contact(..., method='algebraic') lists features")
    found: ContactPairs = _room("polyhedra").contact_pairs(query)
    return found


def _curved(kinds: tuple[Kind, Kind], query: Query) -> Any:
    """The room of a pair that is not two polyhedra; a small convex polyhedron is a model beside a model."""
    if kinds == (Kind.MESH, Kind.MODEL):
        from firstcontact.contact.reduce import is_small_and_convex

        meshes = (shape_of(x) for x in query.bodies)
        if all(is_small_and_convex(x) for x in meshes if isinstance(x, Polyhedron)):
            return _room("models")
    return _room(ROOMS[kinds])


@cache
def _room(name: str) -> Any:
    return import_module(f"firstcontact.contact.{name}.first")
