"""Answers to a part of the questions, in this process."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from firstcontact import query
from firstcontact.batch.questions import Questions
from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.each_translation import EachTranslation, Met, is_moderate
from firstcontact.errors import FirstContactError
from firstcontact.result_table import KINDS, STATUSES, Rows, fill_row
from firstcontact.search.trees.walk_each import FREE, OPEN

FEWEST = 8
"""Motions of one pair from which on they are walked together."""
_KNOWN = Kept[tuple[Any, EachTranslation | None]]()


@dataclass(frozen=True)
class Asking:
    """How `first_contact` is asked: its arguments beside the bodies and the span."""

    arguments: dict[str, Any] = field(default_factory=dict)

    @property
    def budget(self) -> int | None:
        found: int | None = self.arguments.get("budget")
        return found

    def one(self, questions: Questions, row: int) -> Any:
        """The answer to one question."""
        a, b, span = questions[row]
        return query.first_contact(a, b, span, **self.arguments)


def answers(questions: Questions, asking: Asking) -> Rows:
    """All answers."""
    rows = Rows(len(questions))
    left = np.ones(len(questions), bool)
    left[walk_together(questions, asking, rows)] = False
    for row in np.flatnonzero(left).tolist():
        answer(questions, asking, row, rows)
    return rows


def answer(questions: Questions, asking: Asking, row: int, rows: Rows) -> None:
    """The answer to one question, or the error that it raises, into its row."""
    try:
        fill_row(rows.array[row], asking.one(questions, row))
    except FirstContactError as error:
        rows.refuse(row, str(error))
    except Exception as error:  # a fault of one question is no end of the others
        rows.refuse(row, f"{type(error).__name__}: {error}")


def walk_together(questions: Questions, asking: Asking, rows: Rows) -> np.ndarray:
    """Answers what is about pairs of polyhedra under translations, in compiled walks; gives the rows that it did."""
    if asking.arguments.get("engine", "auto") not in ("auto", "boxes"):
        return np.empty(0, np.int64)
    able, vectors, ends = questions.translations()
    moderate = is_moderate(vectors)
    able, vectors, ends = able[moderate], vectors[moderate], ends[moderate]
    pairs = questions.a[able].astype(np.int64) * len(questions.bodies) + questions.b[able]
    order = np.argsort(pairs, kind="stable")
    cuts = np.flatnonzero(np.diff(pairs[order])) + 1
    done = [np.empty(0, np.int64)]
    for some in np.split(order, cuts):
        if len(some) < FEWEST:
            continue
        row = able[some[0]]
        each = _each(questions.bodies[questions.a[row]], questions.bodies[questions.b[row]])
        if each is not None:
            done.append(_walked(each, able[some], vectors[some], ends[some], asking.budget, rows))
    return np.concatenate(done)


def _each(a: Any, b: Any) -> EachTranslation | None:
    """The search for the pair; None where it is not for it.  The last one is kept on a."""
    if not (isinstance(a, Polyhedron) and isinstance(b, Polyhedron)) or a._pose is not None or b._pose is not None:
        return None
    known = _KNOWN.get(a)
    if known is None or known[0] is not b:
        each = EachTranslation(a, b)
        known = _KNOWN.put(a, (b, each if each.is_apart() else None))
    return known[1]


def _walked(
    each: EachTranslation, where: np.ndarray, vectors: np.ndarray, ends: np.ndarray, budget: int | None, rows: Rows
) -> np.ndarray:
    """Fills the rows `where` with what walks tell; gives those that they do."""
    told, work, met = each.walked(vectors, ends)
    done = told != OPEN if budget is None else (told != OPEN) & (work < budget)
    array, free = rows.array, done & (told == FREE)
    array["status"][where[free]] = STATUSES.index("FREE")
    array["free_until"][where[free]] = ends[free]
    array["work"][where[done]] = work[done]
    found = [x for x in met if done[x.motion]]
    if found:
        at = where[[x.motion for x in found]]
        times = [each.time(x) for x in found]
        array["status"][at] = STATUSES.index("CONTACT")
        array["time"][at] = [t for t, _ in times]
        for name, side in (("lo", 0), ("hi", 1), ("free_until", 0)):
            array[name][at] = [interval[side] for _, interval in times]
        rows.later.append(partial(_place, each, at.tolist(), vectors, found, array))
    return where[done]


def _place(each: EachTranslation, at: list[int], vectors: np.ndarray, found: list[Met], array: np.ndarray) -> None:
    for row, met in zip(at, found, strict=True):
        pair, count, point, normal = each.place(vectors[met.motion].tolist(), met)
        record = array[row]
        for side, element in (("a", pair.element_a), ("b", pair.element_b)):
            record[f"kind_{side}"], record[f"index_{side}"] = KINDS.index(element.kind), element.index
        record["multiplicity"], record["point"] = count, point
        if normal is not None:
            record["normal"] = normal
