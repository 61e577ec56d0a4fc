"""The forms of a model's surfaces in plain Python numbers.

A query judges one or two points, for which arrays of three numbers cost more than the arithmetic on them.
"""

from __future__ import annotations

from firstcontact.body.kept import Kept
from firstcontact.body.solid.composite_quadric import CompositeQuadric

Form = tuple[float, ...]
"""xx, yy, zz, 2 xy, 2 xz, 2 yz, 2 x, 2 y, 2 z, 1 of a surface, negative inside."""


_FORMS = Kept[list[Form]]()


def forms_of(model: CompositeQuadric) -> list[Form]:
    """Those of all surfaces, kept on the model."""
    return _FORMS.of(model, lambda: [_form(m) for m in model.forms.tolist()])


def _form(m: list[list[float]]) -> Form:
    twice = [2.0 * x for x in (m[0][1], m[0][2], m[1][2], m[0][3], m[1][3], m[2][3])]
    return (m[0][0], m[1][1], m[2][2], *twice, m[3][3])


def value(f: Form, x: float, y: float, z: float) -> tuple[float, float]:
    """(value at a point, sum of the sizes of its terms)."""
    a, b, c, d, e, g, p, q, r, s = f
    p, q, r = p * x, q * y, r * z
    if not (a or b or c or d or e or g):
        return p + q + r + s, abs(p) + abs(q) + abs(r) + abs(s)
    a, b, c = a * x * x, b * y * y, c * z * z
    d, e, g = d * x * y, e * x * z, g * y * z
    size = abs(a) + abs(b) + abs(c) + abs(d) + abs(e) + abs(g) + abs(p) + abs(q) + abs(r) + abs(s)
    return a + b + c + d + e + g + p + q + r + s, size


def height(f: Form, x: float, y: float, z: float) -> float:
    """The value alone, in half the time."""
    a, b, c, d, e, g, p, q, r, s = f
    return (a * x + d * y + e * z + p) * x + (b * y + g * z + q) * y + (c * z + r) * z + s


def gradient(f: Form, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (
        2.0 * f[0] * x + f[3] * y + f[4] * z + f[6],
        f[3] * x + 2.0 * f[1] * y + f[5] * z + f[7],
        f[4] * x + f[5] * y + 2.0 * f[2] * z + f[8],
    )
