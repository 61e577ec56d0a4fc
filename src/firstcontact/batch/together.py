"""Questions about one pair of polyhedra under many motions, answered in compiled walks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from firstcontact.batch.part import VerbCall
from firstcontact.batch.questions import Questions
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.each import Place, is_taken
from firstcontact.contact.polyhedra.each_rotation import EachRotation
from firstcontact.contact.polyhedra.each_translation import EachTranslation, is_moderate
from firstcontact.motion.arrays import Rotations, Translations
from firstcontact.result_table import STATUSES, Rows, fill_place
from firstcontact.search.trees.containment import contained
from firstcontact.search.trees.walk_each import FREE, MET, OPEN, TIMED

Some = np.ndarray | slice
FEWEST = 8
"""Motions of one pair from which on they are walked together."""
_STATUS = np.zeros(4, np.uint8)
"""By what walks tell; 0 of what they leave open."""
_STATUS[[FREE, MET, TIMED]] = [STATUSES.index(status) for status in ("FREE", "CONTACT", "CONTACT")]


def walk_together(questions: Questions, asking: VerbCall, rows: Rows) -> np.ndarray:
    """Answers what is about pairs of polyhedra under translations or rotations, in compiled walks.

    Tells of each row whether it did.
    """
    done = np.zeros(len(questions), bool)
    for where, motions, ends in questions.walkable():
        for some in _groups(questions, where, motions):
            some_rows = where[some]
            a, b = (questions.bodies[side[some_rows[0]]] for side in (questions.a, questions.b))
            if len(some_rows) >= FEWEST and is_taken(a, b) and contained(a, b) is None:
                each = _each(a, b, motions[some], ends[some])
                _walk(each, some_rows, ends[some], asking.budget, rows, done)
    return done


def _groups(questions: Questions, where: np.ndarray, motions: Translations | Rotations) -> list[Some]:
    """Numbers of motions that are walked together, some of them at a time, about one pair of bodies."""
    run = _run(where)
    keys = [questions.a[run], questions.b[run]]
    if isinstance(motions, Translations):
        able = is_moderate(motions.vectors)
    else:
        sense = np.sign(motions.angles)
        keys += [*motions.axes.T, *motions.points.T, sense]
        able = sense != 0
    if all((key == key[:1]).all() for key in keys):  # as mostly, and at once
        return [_run(np.flatnonzero(able))] if able.any() else []
    _, group = np.unique(np.column_stack(keys)[able], axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    cuts = np.flatnonzero(np.diff(group[order])) + 1
    return [some for some in np.split(np.flatnonzero(able)[order], cuts) if len(some)]


def _run(numbers: np.ndarray) -> Some:
    """Ascending numbers, as a slice where none is left out: NumPy goes through slices many times as fast."""
    whole = len(numbers) > 0 and int(numbers[-1]) - int(numbers[0]) + 1 == len(numbers)
    return slice(int(numbers[0]), int(numbers[-1]) + 1) if whole else numbers


def _each(
    a: Polyhedron, b: Polyhedron, motions: Translations | Rotations, ends: np.ndarray
) -> EachTranslation | EachRotation:
    if isinstance(motions, Translations):
        return EachTranslation(a, b, motions.vectors, ends)
    return EachRotation(a, b, motions, ends)


def _walk(
    each: EachTranslation | EachRotation,
    where: np.ndarray,
    ends: np.ndarray,
    budget: int | None,
    rows: Rows,
    done: np.ndarray,
) -> None:
    """Fills the rows `where`, of which nothing is known, with what walks tell, and notes which they do."""
    told, work, contacts = each.told()
    if budget is not None:
        told[work >= budget] = OPEN
    array, run, known = rows.array, _run(where), told != OPEN
    done[run] = known
    array["status"][run] = _STATUS[told]
    array["free_until"][run] = np.where(told == FREE, ends, np.nan)
    array["work"][run] = work * known
    found = np.flatnonzero(known[contacts.motions])
    at = where[contacts.motions[found]]
    array["time"][at] = contacts.times[found]
    for name, side in (("lo", 0), ("hi", 1), ("free_until", 0)):
        array[name][at] = contacts.intervals[found, side]
    if len(found):
        rows.later.append(partial(_place, partial(each.place, contacts), at.tolist(), found.tolist(), array))


def _place(place: Callable[[int], Place], at: list[int], found: list[int], array: np.ndarray) -> None:
    """Fills in elements, points and normals of contacts."""
    for row, k in zip(at, found, strict=True):
        fill_place(array[row], *place(k))
