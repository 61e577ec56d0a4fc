"""The known answers of `data/ruled_vectors.json` as surfaces and numbers.

Points, curves and times come from closed forms put into implicit equations, from multi-start Newton iterations and
from distance minimisation, not from brackets.  All numbers are strings: rationals, decimals or closed forms.

A case holds the two surfaces `P` and `Q`, each by homogeneous directrices `A` and `B` (matrices c[i][j] of u^i T^j, or
v^i T^j), parameter ranges (None: all reals) and what is `expected`:

static_full  whole rulings, projective parameters: Delta up to constants and factors without real roots, S1 (pairs of
             parameters of common rulings), overlap_lines, curves, points, singular_points, cusps, infinite_factors.
static_box   s and t in [0, 1]: arcs, arc_ends, touch_points, overlap_segments, boundary_points, interior_points.
moving       collision_T (decimals) with closed forms in `exact`, events, distance_samples [T, distance].
"""

from __future__ import annotations

import ast
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flint import arb, ctx

import firstcontact as fc

DATA = Path(__file__).parent / "data" / "ruled_vectors.json"
BITS = 256


def cases(*kinds: str) -> list[dict]:
    """The cases of these kinds ("segments", "static_full", "static_box", "moving"), all without kinds."""
    found = json.loads(DATA.read_text())["cases"]
    return [case for case in found if not kinds or case["kind"] in kinds]


@dataclass(frozen=True)
class Vector:
    """One case; of a moving one p or q deforms with T.  The parameters of q are called v and t in `expected`."""

    name: str
    kind: str
    p: fc.RuledSurface
    q: fc.RuledSurface
    span: tuple[str, str] | None
    expected: dict
    implicit: tuple[str | None, str | None]
    """Polynomials in x, y, z that vanish on p and on q, where known."""

    def __repr__(self) -> str:
        return self.name


def vectors(*kinds: str) -> list[Vector]:
    """The cases of surfaces ("static_full", "static_box", "moving"; all without kinds)."""
    return [vector(case) for case in cases(*kinds or ("static_full", "static_box", "moving"))]


def vector(case: dict) -> Vector:
    s = None if case["kind"] == "static_full" else (0, 1)
    p, q = (
        fc.RuledSurface(curve(case[key]["A"]), curve(case[key]["B"]), u=case[f"{x}_range"], s=s, name=key)
        for key, x in (("P", "u"), ("Q", "v"))
    )
    span = tuple(case["T_range"]) if "T_range" in case else None
    implicit = case.get("implicit_P"), case.get("implicit_Q")
    return Vector(case["id"], case["kind"], p, q, span, case["expected"], implicit)


def curve(components: list) -> fc.RationalCurve:
    return fc.RationalCurve(components[:3], components[3])


# -- closed forms -------------------------------------------------------------------------------------------

FUNCTIONS: dict[str, Callable[[arb], arb]] = {"sqrt": arb.sqrt, "cos": arb.cos, "sin": arb.sin}


def value(text: Any, bits: int = BITS, **variables: Any) -> arb:
    """An enclosure of a closed form ("2-sqrt(3)", "cos(2*pi/9)", "1/2", "0.25"), variables given as numbers.

    "oo" is infinity.  Decimals count as exact.

    >>> value("2*cos(pi/9)").str(12)
    '[1.87938524157 +/- 1.82e-12]'
    >>> float(value("-2*k**3", k=0.5))
    -0.25
    """
    before, ctx.prec = ctx.prec, bits
    try:
        return _value(ast.parse(str(text), mode="eval").body, {k: arb(x) for k, x in variables.items()})
    finally:
        ctx.prec = before


def _value(node: ast.expr, known: dict[str, arb]) -> arb:
    match node:
        case ast.Constant(value=int(x)):
            return arb(x)
        case ast.Constant():
            return arb(ast.unparse(node))
        case ast.Name(id="oo"):
            return arb("inf")
        case ast.Name(id="pi"):
            return arb.pi()
        case ast.Name(id=name):
            return known[name]
        case ast.UnaryOp(op=ast.USub(), operand=x):
            return -_value(x, known)
        case ast.BinOp(left=x, op=ast.Pow(), right=ast.Constant(value=int(n))):
            return _value(x, known) ** n
        case ast.BinOp(left=x, op=op, right=y):
            left, right = _value(x, known), _value(y, known)
            match op:
                case ast.Add():
                    return left + right
                case ast.Sub():
                    return left - right
                case ast.Mult():
                    return left * right
                case ast.Div():
                    return left / right
        case ast.Call(func=ast.Name(id=name), args=[x]):
            return FUNCTIONS[name](_value(x, known))
    raise ValueError(f"no closed form: {ast.unparse(node)}")


def numbers(texts: Any, **variables: Any) -> list[float]:
    """Doubles near a list of closed forms."""
    return [float(value(x, **variables)) for x in texts]


def polynomial(text: str) -> dict[tuple[int, int], int]:
    """The coefficients of u^i v^j of an expected polynomial, by (i, j).

    >>> polynomial("(u-1)*(v-1)")
    {(1, 1): 1, (1, 0): -1, (0, 1): -1, (0, 0): 1}
    """
    from firstcontact.exact.expressions import read_tuple

    (ratio,) = read_tuple(text, ("u", "v"), "vector")
    return {key: int(c) for key, c in ratio.numerator.to_dict().items()}
