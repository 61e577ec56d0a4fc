"""Solids of planes and quadrics that meet each other."""

from __future__ import annotations

from benchmarks.soaks.landing import landing
from benchmarks.soaks.scene import Kind
from benchmarks.soaks.shapes import SOLIDS
from benchmarks.soaks.starts import graze, known_start, nested, shallow

KINDS: tuple[Kind, ...] = (
    Kind("solids/landing", "solid, solid", lambda rng: landing(rng, SOLIDS, SOLIDS),
         "late, early and missed first contacts of convex solids, wrong points and normals, false FREE at the ends of spans",
         "contacts of solids with holes and waists; what comes after the first contact"),
    Kind("solids/shallow start", "solid, solid", lambda rng: shallow(rng, SOLIDS, SOLIDS),
         "overlaps and gaps of 1e-1 to 1e-18 of the size taken for each other or for contact later; wrong `initial`",
         "starts in contact at several places"),
    Kind("solids/graze", "solid, solid", lambda rng: graze(rng, SOLIDS, SOLIDS),
         "contact of one instant that is missed, or told where bodies pass", "near misses"),
    Kind("solids/nested start", "solid, solid", lambda rng: nested(rng, SOLIDS, SOLIDS),
         "containment that is missed", "when the inner body comes out"),
    Kind("solids/tangent start", "solid, solid", lambda rng: known_start(rng),
         "`initial` where bodies are equal, fit, or touch along lines, circles and surfaces, from inside and outside",
         "what comes after the start"),
)
