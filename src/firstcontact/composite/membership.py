"""Whether points of contact sets lie in the closed models: signs of all surfaces at points of a number field."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import product
from typing import Any

from flint import arb

from firstcontact.body.csg import outcomes
from firstcontact.composite.moving_pair import Form, Pair
from firstcontact.exact.inertia import dot, value
from firstcontact.exact.number_field import NumberField, ball, sign
from firstcontact.exact.numbers import Undecidable, precision
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.exact.square_systems import EnclosedRoot

Vector = tuple[Any, ...]
Root = AlgebraicRoot | EnclosedRoot
BITS = (96, 384)
"""Precisions of the balls that decide before the field does: zeros apart, nearly all signs show at the first."""


def in_both(pair: Pair, x: Vector, root: Root, on_a: Collection[int], on_b: Collection[int]) -> str:
    """"" when x lies in both closed models, else "outside a" or "outside b" (by their names).

    on_a, on_b: surfaces known to hold x.  A point on several surfaces counts as in the model when some pattern of
    their signs does: exact where their gradients are independent.  Undecidable where enclosures leave signs open
    that matter.
    """
    for body, forms, on, who in ((pair.a, pair.forms_a, on_a, "a"), (pair.b, pair.forms_b, on_b, "b")):
        signs = [0 if k in on else sign_at(form, x, root) for k, form in enumerate(forms)]
        unknown = [k for k, found in enumerate(signs) if found is None]
        inside = {True in outcomes(body.tree, _with(signs, unknown, s)) for s in product((-1, 1), repeat=len(unknown))}
        if len(inside) == 2:
            raise Undecidable(f"precision: whether the point lies in {body.name or who}")
        if not any(inside):
            return f"outside {body.name or who}"
    return ""


def _with(signs: Sequence[int | None], unknown: Sequence[int], chosen: Sequence[int]) -> list[int]:
    replaced = dict(zip(unknown, chosen, strict=True))
    return [replaced.get(k, 0) if s is None else s for k, s in enumerate(signs)]


def sign_at(form: Form, x: Vector, root: Root) -> int | None:
    """Exact sign of N.X (times the sign of w) or X^T Q X at the homogeneous point x over the field of the root.

    None for enclosed points whose balls do not show it.
    """
    for bits in BITS:
        u = root.enclosure(bits)
        balls = [ball(c, bits) for c in x]
        with precision(bits):
            found = form_value(form_at(form, u), balls)
            if is_plane(form):
                found = found * balls[3]
        if found > 0 or found < 0:
            return 1 if found > 0 else -1
    if isinstance(root, EnclosedRoot):
        return None
    field = NumberField(root)
    if is_plane(form):
        return sign(dot([field(c) for c in form], x)) * sign(x[3])
    return sign(value(field.matrix(form), x))


def is_plane(form: Form) -> bool:
    return not isinstance(form[0], tuple)


def form_at(form: Form, u: arb) -> Any:
    """The form at an enclosure of u."""
    return [c(u) for c in form] if is_plane(form) else [[c(u) for c in row] for row in form]


def form_value(form: Any, x: Sequence[Any]) -> Any:
    """N.X or X^T Q X in any numbers."""
    return value(form, x) if isinstance(form[0], list | tuple) else dot(form, x)
