"""What a family of scenes gives to the soak: scenes as source text, questions, and judges of the answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

Judge = Callable[[Any], str | None]
"""What is wrong with an answer, in one line; None where nothing is.  UNDECIDED is counted by the soak, not judged."""


@dataclass(frozen=True, slots=True)
class Question:
    """One call of the library.

    call   an expression over what the scene's source defines, as "fc.first_contact(a, b, span)".
    judge  compares the answer with what the scene's oracle knows.
    """

    call: str
    judge: Judge


@dataclass(frozen=True, slots=True)
class Scene:
    """Two bodies in motion, as the text of a program.

    source     defines a, b and span (None: that of the motions) by `fc`, `F` (fractions.Fraction) and `np` alone, so
               that a finding prints as a program that runs.
    motion     kind of the relative motion, for the table: "translation", "rotation", "screw", "rest", ...
    questions  the calls with their judges; first contacts first.
    """

    source: str
    motion: str
    questions: tuple[Question, ...]


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of scene.

    name     "FAMILY/what", as "meshes/landing on a half turn"; bodies: "mesh, mesh", for the table.
    make     a scene from random numbers; the same numbers make the same scene.
    reveals  which mistakes such scenes can reveal; blind: which they cannot.
    laws     whether the laws (swap, split span, common placement, scale, reversal, exact) are tried on it, too.
    """

    name: str
    bodies: str
    make: Callable[[Random], Scene]
    reveals: str
    blind: str
    laws: bool = True
