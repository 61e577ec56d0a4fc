"""Points where the closed forms of a solid meet though none of its inner points is near: the solid is regularised.

Let forms Q_i vanish at p, with gradients g_i there of which no fewer are dependent than all, sum c_i g_i = 0.  Then
K = sum c_i Q_i is a quadratic form in x - p, without any other terms.  Where all c_i Q_i < 0, so is K, and all are less
than |K|.  In coordinates (t, h) along and across the space T that all g_i are normal to, h = O(|K|) + O(|x - p|^2), the
second term being that of quadrics only.  Such points do not come near p if K is

*   positive definite on T: K(t, h) = K(t, 0) + O(|h| |x - p|),
*   nowhere negative on T, and at most one of the forms is no plane's: h = O(|K|) then, as planes tell it,
*   or nowhere negative.

Nor do those where all c_i Q_i > 0, with the signs of K the other way.  Patterns of signs that are ruled out so, by
Gordan's theorem of the alternative for forms of degree 2, do not occur: of two surfaces that touch from outside, of
three planes whose half-spaces share a line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

from firstcontact.body.solid.csg import Tree, inside, pattern
from firstcontact.contact.models.moving_pair import Form, form_at, is_plane
from firstcontact.exact.fields.number_field import NumberField, ball, is_zero, sign
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.inertia import Rows, dot, inertia, null_space
from firstcontact.exact.vectors import cross

if TYPE_CHECKING:
    from flint import arb

MOST = 8
"""Forms that vanish in one point, of whose patterns all are looked at."""
BITS = 96
DIRECTIONS = [(a * x, b * y, c * z) for x, y, z in ((2, 3, 7), (7, 2, 3), (3, 7, 2))
              for a, b, c in product((1, -1), repeat=3)]  # fmt: skip
"""In which inner points are looked for; aligned with nothing."""

_NONE = ((0,) * 3,) * 3

Numbers = Sequence[Any]
"""Of any kind: of a field, or balls."""
Pattern = dict[int, bool]
"""Of some forms, whether they are negative."""


def is_dangling(tree: Tree, forms: Sequence[Form], signs: Sequence[int], x: Numbers, field: NumberField) -> bool:
    """Whether it is proved that no inner point of the solid is near the point x (homogeneous, over the field).

    signs: of all forms there, exact.
    """
    on = [k for k, found in enumerate(signs) if found == 0]
    if not 2 <= len(on) <= MOST or _is_seen_inside(tree, forms, signs, on, x, field):
        return False
    exact = [_over(forms[k], field) for k in on]
    gradients = [_gradient(form, x) for form in exact]
    seconds = [_NONE if is_plane(form) else [row[:3] for row in form[:3]] for form in exact]
    barred = list(_barred(gradients, seconds))
    return bool(barred) and not any(
        inside(tree, pattern(signs, on, chosen))
        for chosen in product((True, False), repeat=len(on))
        if not any(all(chosen[i] is negative for i, negative in one.items()) for one in barred)
    )


def _is_seen_inside(
    tree: Tree, forms: Sequence[Form], signs: Sequence[int], on: Sequence[int], x: Numbers, field: NumberField
) -> bool:
    """Whether balls show inner points near: in a direction, or as gradients are independent and all patterns occur."""
    with precision(BITS):
        u, at = field.root.enclosure(BITS), [ball(c, BITS) for c in x]
        gradients = [_gradient(form_at(forms[k], u), at) for k in on]
        if len(on) <= 3:
            n = cross(*gradients[:2])
            found = [dot(n, gradients[2])] if len(on) == 3 else n
            if any(_told(value) is not None for value in found):
                return True
        for towards in DIRECTIONS:
            told = [_told(dot(g, towards)) for g in gradients]
            chosen = [x for x in told if x is not None]
            if len(chosen) == len(on) and inside(tree, pattern(signs, on, chosen)):
                return True
    return False


def _told(value: arb) -> bool | None:
    """Whether the ball is negative; None where it may be zero."""
    return True if value < 0 else False if value > 0 else None


def _over(form: Form, field: NumberField) -> Form:
    """The form at the root of the field."""
    return tuple(map(field, form)) if is_plane(form) else field.matrix(form)


def _gradient(form: Form, x: Numbers) -> Numbers:
    """x[3] times that of the form; numbers of any kind."""
    return [c * x[3] for c in form[:3]] if is_plane(form) else [2 * dot(row, x) for row in form[:3]]


def _barred(gradients: Rows, seconds: Sequence[Rows]) -> Iterator[Pattern]:
    """Patterns that do not occur, of forms by their gradients and their parts of degree 2."""
    for count in range(1, 5):
        for chosen in combinations(range(len(gradients)), count):
            relations = null_space([[gradients[i][k] for i in chosen] for k in range(3)])
            if len(relations) != 1 or any(is_zero(c) for c in relations[0]):
                continue  # they are independent, or fewer of them are dependent already
            (c,) = relations
            total = [[dot(c, [seconds[i][r][s] for i in chosen]) for s in range(3)] for r in range(3)]
            curved = sum(seconds[i] is not _NONE for i in chosen)
            for side in (1, -1):
                if _is_kept_off(total, [gradients[i] for i in chosen], side, curved):
                    yield {i: side * sign(value) > 0 for i, value in zip(chosen, c, strict=True)}


def _is_kept_off(total: Rows, gradients: Rows, side: int, curved: int) -> bool:
    """Whether no points near have side c_i Q_i < 0 for all i; total: of K; curved: how many forms are quadrics."""
    along = null_space(gradients)
    on_t = inertia([[dot(v, [dot(row, w) for row in total]) for w in along] for v in along])
    positive, negative = on_t[:2] if side > 0 else on_t[1::-1]
    if positive == len(along) or (negative == 0 and curved <= 1):
        return True
    return inertia(total)[1 if side > 0 else 0] == 0
