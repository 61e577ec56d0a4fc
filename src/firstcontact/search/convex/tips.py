"""Two convex pieces at a cone's tip, where its function has no gradient: exact, by planes through the tip.

A plane n.(y - v) = 0 through the tip v has the cone behind it where n is in the polar cone.  Another piece lies in
front of it where f(v) >= 0 for one of its convex functions and n is against the gradient: f(y) is at least
f(v) - n.(y - v), which is positive in front of it only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from flint import fmpq

from firstcontact.body.solid.carriers import ONE, Plane, Quadric, Rows, Surface, Vector, dot, inertia, inverse
from firstcontact.search.convex.relation import Relation

Solid = tuple[list[Surface], Sequence[fmpq] | None]
"""Half-spaces of a convex piece and a point inside."""


def at_tips(own: Solid, other: Solid) -> Relation | None:
    """What the tips of either piece tell; None where that is nothing."""
    if tip_inside(own, other) is not None:
        return Relation.OVERLAPPING
    tips = list(tips_of(own)), list(tips_of(other))
    known = [_beyond(tip, form) for mine, theirs in ((tips[0], other[0]), (tips[1], own[0]))
             for tip in mine for form in theirs]  # fmt: skip
    known += [_face_to_face(tip, far) for tip in tips[0] for far in tips[1]]
    for answer in (Relation.APART, Relation.NEAR):
        if answer in known:
            return answer
    return None


def tip_inside(own: Solid, other: Solid) -> Vector | None:
    """The tip of one piece that lies inside the other."""
    known = ((tip.point, theirs[0]) for mine, theirs in ((own, other), (other, own)) for tip in tips_of(mine))
    return next((point for point, forms in known if is_inside(forms, point)), None)


def is_inside(forms: Sequence[Surface], x: Sequence[fmpq]) -> bool:
    """Whether the point is strictly inside all half-spaces; exact."""
    return all(form.value((*x, ONE)) < 0 for form in forms)


class Tip:
    """The tip of a cone that a piece has: point; dual: inverse of the cone's second-order part; witness: a point inside
    the piece; inward: to it; normal: one in the polar cone.
    """

    def __init__(self, block: Rows, point: Vector, witness: Sequence[fmpq]) -> None:
        self.point, self.dual, self.witness = point, inverse(block), witness
        self.inward = [w - p for w, p in zip(witness, point, strict=True)]
        self.normal = [dot(row, self.inward) for row in block]

    def is_behind(self, n: Sequence[fmpq]) -> bool:
        """Whether n.(y - point) <= 0 for all y of the cone."""
        return dot(n, self.inward) < 0 and dot(n, [dot(row, n) for row in self.dual]) <= 0


def tips_of(solid: Solid) -> Iterator[Tip]:
    """Of the cones of a convex piece that end within it."""
    forms, witness = solid
    for form in forms:
        if not isinstance(form, Quadric) or (point := form.apex) is None or witness is None:
            continue
        block = tuple(tuple(row[:3]) for row in form.form[:3])
        if inertia(block) == (2, 1) and all(other.value(point) <= 0 for other in forms):
            yield Tip(block, point[:3], witness)


def _beyond(tip: Tip, form: Surface) -> Relation | None:
    """Whether the plane along the form's gradient at the tip parts the cone from the half-space."""
    if not isinstance(form, Plane) and inertia(tuple(tuple(row[:3]) for row in form.form[:3]))[1] > 0:
        return None
    x = (*tip.point, ONE)
    return _parted(form.value(x)) if tip.is_behind([-c for c in form.gradient(x)[:3]]) else None


def _face_to_face(tip: Tip, far: Tip) -> Relation | None:
    """The same of two tips."""
    between = [q - p for p, q in zip(tip.point, far.point, strict=True)]
    for n in (tip.normal, [-c for c in far.normal], between):
        if tip.is_behind(n) and far.is_behind([-c for c in n]) and dot(n, between) >= 0:
            return _parted(dot(n, between))
    return None


def _parted(distance: fmpq) -> Relation | None:
    return None if distance < 0 else Relation.APART if distance > 0 else Relation.NEAR
