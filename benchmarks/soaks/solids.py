"""Solids of planes and quadrics that meet each other."""

from __future__ import annotations

from .crossing import crossing, drilled_landing
from .landing import landing
from .rounds import circling, pinned, seated, straight, straight_balls
from .scene import Kind
from .solid_shapes import SOLIDS, any_half_space
from .starts import graze, known_start, nested, shallow

PARTNERS = (*SOLIDS, any_half_space)

KINDS: tuple[Kind, ...] = (
    Kind("solids/landing", "solid, solid", lambda rng: landing(rng, SOLIDS, PARTNERS),
         "late, early, missed first contacts of convex solids, wrong points and normals, false FREE at ends of spans",
         "contacts of solids with holes and waists; what comes after the first contact"),
    Kind("solids/drilled landing", "solid, csg", lambda rng: drilled_landing(rng, SOLIDS, SOLIDS),
         "the same on models with holes, at edges of degree 4 and on the walls of unions", "contacts within holes"),
    Kind("solids/crossing", "solid, solid", lambda rng: crossing(rng, SOLIDS, SOLIDS),
         "false FREE and late contacts where bodies overlap well, early ones, planes of contact that cut into bodies",
         "exact times; thin overlaps and short contacts"),
    Kind("solids/shallow start", "solid, solid", lambda rng: shallow(rng, SOLIDS, SOLIDS),
         "overlaps and gaps of 1e-1 to 1e-18 of the size taken for each other or for contact later; wrong `initial`",
         "starts in contact at several places"),
    Kind("solids/graze", "solid, solid", lambda rng: graze(rng, SOLIDS, SOLIDS),
         "contact of one instant that is missed, or told where bodies pass", "near misses"),
    Kind("solids/nested start", "solid, solid", lambda rng: nested(rng, SOLIDS, SOLIDS),
         "containment that is missed", "when the inner body comes out"),
    Kind("solids/tangent start", "solid, solid", known_start,
         "`initial` where bodies are equal, fit, or touch along lines, circles and surfaces, from inside and outside",
         "what comes after the start"),
    Kind("solids/straight ball", "ball, box or cylinder", straight,
         "wrong times and intervals at faces, edges, corners, sides and rims", "grazes"),
    Kind("solids/two balls", "ball, ball or half-space", straight_balls,
         "wrong times and intervals, exact grazes, leaving one another", "anything but balls"),
    Kind("solids/circling ball", "ball, solid", circling,
         "wrong times and intervals under rotations and screws, over several turns, in spans that start in mid-turn",
         "grazes and touching at the ends of spans"),
    Kind("solids/seated ball", "ball, csg", seated,
         "contacts along circles: on rims, in seats and bowls; at waists, in tubes", "several turns and other motions"),
    Kind("solids/pin in a bore", "pin, csg", pinned,
         "false contacts at clearances down to 1e-12, missed ones where the pin fits exactly or not at all",
         "pins that tilt"),
)
