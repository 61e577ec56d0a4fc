"""Questions answered by swept boxes alone: bodies whose boxes are apart in every part of the span share no point.

Worth it where few bodies are asked about often, as the pairs of an assembly are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from firstcontact.batch.questions import Questions
from firstcontact.motion.arrays import Motions
from firstcontact.motion.moving import Moving

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion

PARTS = 8
"""Parts of the span; each body has a box in each of them."""
ASKED = 4
"""Questions for each body from which on boxes are worth making."""
SPAN = 0.0, 1.0
ROUNDING = 1e-15
"""Relative: bounds of bodies at rest round once."""


def is_worth_boxes(bodies: int, questions: int) -> bool:
    """Whether so many bodies are asked about often enough."""
    return bodies * ASKED <= questions


def free_by_boxes(questions: Questions, worth: bool | None = None) -> np.ndarray:
    """Rows of questions about the span (0, 1) whose bodies are apart all the time, by their boxes; proved.

    worth: whether to look at all, default None: where the bodies are asked about often enough.
    """
    none = np.empty(0, np.int64)
    if questions.spans is not None or isinstance(questions.moves_a, Motions) or isinstance(questions.moves_b, Motions):
        return none
    bodies: dict[tuple[int, int], tuple[Body, AnyMotion | None]] = {}
    numbers: dict[tuple[int, int], int] = {}
    sides = []
    for shapes, moves in ((questions.a, questions.moves_a), (questions.b, questions.moves_b)):
        motions = moves if moves is not None else [None] * len(questions)
        keys = [(shape, id(motion)) for shape, motion in zip(shapes.tolist(), motions, strict=True)]
        bodies |= {key: (questions.bodies[key[0]], motion) for key, motion in zip(keys, motions, strict=True)}
        sides.append([numbers.setdefault(key, len(numbers)) for key in keys])
    if not numbers or not (is_worth_boxes(len(numbers), len(questions)) if worth is None else worth):
        return none
    boxes = np.stack([_boxes(*bodies[key]) for key in numbers], axis=1)
    return np.flatnonzero(_apart(boxes, *map(np.array, sides)))


def _boxes(shape: Body, motion: AnyMotion | None) -> np.ndarray:
    """(PARTS, 6): lower and upper corners of boxes of the body in the parts of the span, or infinite ones."""
    cuts = np.linspace(*SPAN, PARTS + 1).tolist()
    everywhere = np.array([-np.inf] * 3 + [np.inf] * 3)
    if not hasattr(shape, "bounds") or getattr(motion, "span", SPAN) != SPAN:
        return np.tile(everywhere, (PARTS, 1))
    if motion is None and not getattr(shape, "deforming", False):
        return np.tile(_padded(*shape.bounds()), (PARTS, 1))
    moving = shape if motion is None else Moving(shape, motion)
    return np.array([_padded(*moving.bounds(part)) for part in zip(cuts, cuts[1:], strict=False)])


def _padded(lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    box = np.concatenate([lo, hi])
    finite = np.abs(box[np.isfinite(box)])
    pad = ROUNDING * finite.max(initial=0.0) + 1e-300
    padded: np.ndarray = box + np.repeat([-pad, pad], 3)
    return padded


def _apart(boxes: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Which pairs have boxes apart in all parts."""
    apart = np.ones(len(a), bool)
    for part in boxes:
        x, y = part[a], part[b]
        apart &= ((x[:, :3] > y[:, 3:]) | (y[:, :3] > x[:, 3:])).any(axis=1)
    return apart
