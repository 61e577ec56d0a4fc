"""The first new contact of bodies of several pieces, as parts of STEP files are, that touch at the start.

What two such bodies share is what a piece of one shares with a piece of the other, and the surfaces in which pieces
touch at the start are some of those in which the bodies do: the first new contact is the earliest of the pieces'.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from firstcontact.assembly.new_contact import Name, NewContactQuery, Way, earliest, renamed
from firstcontact.body.compound.compound import Compound
from firstcontact.body.kinds import Body
from firstcontact.contact.compound.windows import CompoundSide, overlapping, side_of
from firstcontact.motion.moving import shape_of
from firstcontact.result import Element, FirstContact, Status

MOST_TOUCHING = 50
"""Pairs of pieces that touch at the start; each is looked at by itself."""


def by_pieces(a: Body, b: Body, asking: NewContactQuery, at_once: Way) -> FirstContact | None:
    """None of bodies without pieces, and where too many touch; at_once: answers of two pieces that touch."""
    if not any(isinstance(shape_of(x), Compound) for x in (a, b)):
        return None
    sides = side_of(a), side_of(b)
    span = [(asking.start, float(asking.span[1]))]
    found, touching = [], 0
    for i, j in overlapping(*(side.boxes(np.arange(len(side.bodies)), span) for side in sides)).tolist():
        x, y = sides[0].bodies[i], sides[1].bodies[j]
        then = asking.at_start(x, y)
        touching += then.status is Status.INITIAL_CONTACT
        if touching > MOST_TOUCHING:
            return None
        if then.status is Status.INITIAL_CONTACT:
            told = at_once(x, y, replace(asking, is_apart=then.initial == "touching"))
            assert told is not None
        else:
            told = asking.first_contact(x, y)
        found.append(renamed(told, _called(sides[0], i, "a"), _called(sides[1], j, "b")))
    return earliest(found, asking)


def _called(side: CompoundSide, k: int, which: str) -> Name:
    piece, name = side.pieces[k], side.name or which

    def called(element: Element) -> Element:
        own = None if piece is None else piece.element(element, name)
        return own or (element if piece is None else Element("face", name, -1, name))  # a wall between pieces

    return called
