"""Whether points of contact sets lie in the closed models: signs of all surfaces at points of a number field."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import product
from typing import Any, NamedTuple

from flint import arb

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import borders, outcomes
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.moving_pair import Form, MovingPair, form_at, is_plane
from firstcontact.contact.models.shared.dangling import is_dangling
from firstcontact.exact.fields.number_field import NumberField, ball, sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import Undecidable, precision
from firstcontact.exact.polynomials.inertia import dot, value
from firstcontact.exact.systems.square_systems import EnclosedNumber, EnclosedRoot

Vector = tuple[Any, ...]
Root = AlgebraicRoot | EnclosedRoot
BITS = (96, 384)
"""Precisions of the balls that decide before the field does: zeros apart, nearly all signs show at the first."""


class On(NamedTuple):
    """Surfaces known to hold a set, and the faces (surface, orientation) in which its points are asked to be: of a face
    itself, of an edge two on different surfaces.  None of a vertex, or where all of the model counts."""

    surfaces: Collection[int]
    faces: Collection[tuple[int, int]] = ()

    @property
    def fewest(self) -> int:
        """How many surfaces must have one of their faces there."""
        return min(len({k for k, _ in self.faces}), 2)


def extent(body: CompositeQuadric, feature: Face | Edge | Vertex, surfaces: Collection[int]) -> On:
    """Of the sets of one feature's carrier: beyond the feature they are not its contacts."""
    if isinstance(feature, Vertex):
        return On(surfaces)
    faces = [feature] if isinstance(feature, Face) else [body.faces[k] for k in feature.faces]
    return On(surfaces, [(face.surfaces[0], face.orientation) for face in faces])


def in_both(pair: MovingPair, x: Vector, root: Root, on_a: On, on_b: On) -> str:
    """"" when x lies in both closed models, on the faces asked for, else why not: which it is outside of,
    or beyond the feature of.

    A point on several surfaces counts as in the model when some pattern of their signs does that may occur near it:
    exact where their gradients are independent, or sums of the forms rule out the others.  Undecidable where enclosures
    leave signs open that matter.
    """
    there = PlaceOfRoot(x, root)
    for body, forms, on, who in ((pair.a, pair.forms_a, on_a, "a"), (pair.b, pair.forms_b, on_b, "b")):
        signs = [0 if k in on.surfaces else there.sign(form) for k, form in enumerate(forms)]
        unknown = [k for k, found in enumerate(signs) if found is None]
        inside = {True in outcomes(body.tree, _with(signs, unknown, s)) for s in product((-1, 1), repeat=len(unknown))}
        if len(inside) == 2:
            raise Undecidable(f"precision: whether the point lies in {body.name or who}")
        if not any(inside) or _is_dangling(body, forms, signs, x, root):
            return f"outside {body.name or who}"
        choices = product((-1, 1), repeat=len(unknown))
        if on.faces and not any(_on_faces(body, _with(signs, unknown, s), on) for s in choices):
            return f"beyond the feature of {body.name or who}"
    return ""


def _is_dangling(
    body: CompositeQuadric, forms: Sequence[Form], signs: Sequence[int | None], x: Vector, root: Root
) -> bool:
    exact = [s for s in signs if s is not None]
    if not body.regular or len(exact) < len(signs):
        return False
    if not isinstance(root, AlgebraicRoot) or any(isinstance(c, EnclosedNumber) for c in x):
        return False
    return is_dangling(body.tree, forms, exact, x, NumberField(root))


def _on_faces(body: CompositeQuadric, signs: Sequence[int], on: On) -> bool:
    return len({k for k, side in on.faces if borders(body.tree, signs, k, side)}) >= on.fewest


def _with(signs: Sequence[int | None], unknown: Sequence[int], chosen: Sequence[int]) -> list[int]:
    replaced = dict(zip(unknown, chosen, strict=True))
    return [replaced.get(k, 0) if s is None else s for k, s in enumerate(signs)]


class PlaceOfRoot:
    """A homogeneous point over the field of a root: the signs of forms there.

    Balls of the point and of the root are made once for all forms.
    """

    def __init__(self, x: Vector, root: Root) -> None:
        self.x, self.root = x, root
        self._balls: dict[int, tuple[arb, list[arb]]] = {}

    def sign(self, form: Form) -> int | None:
        """Exact sign of N.X (times the sign of w) or X^T Q X.  None for enclosed points whose balls do not show it."""
        for bits in BITS:
            u, balls = self._at(bits)
            with precision(bits):
                found = form_value(form_at(form, u), balls)
                if is_plane(form):
                    found = found * balls[3]
            if found > 0 or found < 0:
                return 1 if found > 0 else -1
        if any(isinstance(c, EnclosedNumber) for c in self.x):
            return None
        assert isinstance(self.root, AlgebraicRoot)
        field = NumberField(self.root)
        if is_plane(form):
            return sign(dot([field(c) for c in form], self.x)) * sign(self.x[3])
        return sign(value(field.matrix(form), self.x))

    def _at(self, bits: int) -> tuple[arb, list[arb]]:
        if bits not in self._balls:
            self._balls[bits] = self.root.enclosure(bits), [ball(c, bits) for c in self.x]
        return self._balls[bits]


def form_value(form: Any, x: Sequence[arb]) -> Any:
    """N.X or X^T Q X in any numbers."""
    return dot(form, x) if is_plane(form) else value(form, x)
