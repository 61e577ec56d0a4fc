"""Rational expressions in text, such as "(1 - u**2)/(1 + u**2)": read as exact fractions of integer polynomials.

Digits mean the number they write: "0.1" is one tenth.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpz_mpoly, fmpz_mpoly_ctx

from firstcontact.errors import InputError

# Largest degree in a variable, exponent, and bits of a number: far beyond any surface, far below what exhausts memory.
MOST_DEGREE, MOST_BITS = 200, 20_000
_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?")


@dataclass(frozen=True, slots=True)
class Ratio:
    """numerator / denominator, without common factor; the leading coefficient of the denominator is positive."""

    numerator: fmpz_mpoly
    denominator: fmpz_mpoly

    def __add__(self, other: Ratio) -> Ratio:
        above = self.numerator * other.denominator + other.numerator * self.denominator
        return _reduced(above, self.denominator * other.denominator)

    def __neg__(self) -> Ratio:
        return Ratio(-self.numerator, self.denominator)

    def __sub__(self, other: Ratio) -> Ratio:
        return self + -other

    def __mul__(self, other: Ratio) -> Ratio:
        return _reduced(self.numerator * other.numerator, self.denominator * other.denominator)

    def inverse(self) -> Ratio:
        """Of a nonzero ratio."""
        return _reduced(self.denominator, self.numerator)


def context(variables: tuple[str, ...]) -> fmpz_mpoly_ctx:
    """The one ring of integer polynomials in these variables."""
    return fmpz_mpoly_ctx.get(variables, "lex")


def read_tuple(text: str, variables: tuple[str, ...], what: str) -> list[Ratio]:
    """The entries of "(a, b, ...)"; one without parentheses and commas is a tuple of one.

    InputError, with `what` in front, for anything but numbers, the variables, + - * / and whole powers.

    >>> [str(x.numerator) for x in read_tuple("((1-u**2)/(1+u**2), 0.5*u)", ("u",), "directrix")]
    ['-u^2 + 1', 'u']
    """
    text, tree = _parsed(text, what)
    nodes = tree.elts if isinstance(tree, ast.Tuple | ast.List) else [tree]
    reader = _Parser(text, variables, what)
    return [reader.read(node) for node in nodes]


def read_inequalities(text: str, variables: tuple[str, ...], what: str) -> list[fmpz_mpoly]:
    """Polynomials that are >= 0 exactly where the text, "a <= b" or a chain "a <= b <= c", holds.

    >>> [str(g) for g in read_inequalities("0 <= u*s <= 1/2", ("u", "s"), "trim")]
    ['u*s', '-2*u*s + 1']
    """
    text, tree = _parsed(text, what)
    if not isinstance(tree, ast.Compare):
        raise InputError(f"{what} {_shown(text)} is no inequality; write one such as \"u*s <= 1/2\"")
    reader = _Parser(text, variables, what)
    sides = [reader.read(node) for node in (tree.left, *tree.comparators)]
    found = []
    for less, operator, greater in zip(sides, tree.ops, sides[1:], strict=False):
        if not isinstance(operator, ast.LtE | ast.GtE):
            raise InputError(f"{what} {_shown(text)}: pieces are closed; compare by <= or >=")
        difference = greater - less if isinstance(operator, ast.LtE) else less - greater
        if not difference.denominator.is_constant():
            raise InputError(f"{what} {_shown(text)}: both sides must be polynomials; multiply the denominator out")
        found.append(difference.numerator)
    return found


class _Parser:
    """Walks a syntax tree; `text` is what it was parsed from, for the digits of its numbers."""

    def __init__(self, text: str, variables: tuple[str, ...], what: str) -> None:
        self.text, self.what, self.variables = text, what, variables
        self.ring = context(variables)

    def read(self, node: ast.expr) -> Ratio:
        try:
            return self.ratio(node)
        except RecursionError as error:
            raise InputError(f"{self.what} {_shown(self.text)} is nested too deeply; give a simpler one") from error

    def ratio(self, node: ast.expr) -> Ratio:
        match node:
            case ast.Constant():
                return self._number(node)
            case ast.Name(id=name) if name in self.variables:
                return Ratio(self.ring.gen(self.variables.index(name)), self.ring.constant(1))
            case ast.Name(id=name):
                known = " and ".join(self.variables)
                raise InputError(f"{self.what} {_shown(self.text)}: unknown name {name!r}; the variables are {known}")
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return -self.ratio(inner)
            case ast.UnaryOp(op=ast.UAdd(), operand=inner):
                return self.ratio(inner)
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(self.ratio(left), right)
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as operator, right=right):
                return self._checked(self._combined(self.ratio(left), operator, self.ratio(right), right))
            case ast.BinOp(op=ast.BitXor()):
                raise self._fault(node, "write powers as **")
            case _:
                raise self._fault(node, "use numbers, variables, + - * / ** and parentheses")

    def _combined(self, x: Ratio, operator: ast.operator, y: Ratio, node: ast.expr) -> Ratio:
        match operator:
            case ast.Add():
                return x + y
            case ast.Sub():
                return x - y
            case ast.Mult():
                return x * y
            case _:
                if y.numerator.is_zero():
                    raise self._fault(node, "this is zero, and nothing can be divided by it")
                return x * y.inverse()

    def _number(self, node: ast.Constant) -> Ratio:
        digits = self._source(node)
        if not _NUMBER.fullmatch(digits):
            raise self._fault(node, "write numbers as 2, 0.5 or 1e-3")
        value = Fraction(digits)
        return Ratio(self.ring.constant(value.numerator), self.ring.constant(value.denominator))

    def _power(self, base: Ratio, node: ast.expr) -> Ratio:
        exponent = self.ratio(node)
        whole = exponent.numerator.is_constant() and exponent.denominator.is_one()
        n = int(exponent.numerator.to_dict().get((0,) * len(self.variables), 0)) if whole else MOST_DEGREE + 1
        if abs(n) > MOST_DEGREE:
            raise self._fault(node, f"exponents are whole numbers up to {MOST_DEGREE}")
        if n < 0:
            if base.numerator.is_zero():
                raise self._fault(node, "zero has no negative power")
            base, n = base.inverse(), -n
        if n * max(_size(base)) > MOST_DEGREE or n * _bits(base) > MOST_BITS:
            raise self._fault(node, f"the degree grows beyond {MOST_DEGREE}, or the numbers beyond {MOST_BITS} bits")
        return Ratio(base.numerator**n, base.denominator**n)

    def _checked(self, x: Ratio) -> Ratio:
        if max(_size(x)) > MOST_DEGREE or _bits(x) > MOST_BITS:
            limits = f"degree {MOST_DEGREE} or {MOST_BITS} bits"
            raise InputError(f"{self.what} {_shown(self.text)} is larger than {limits}; give a simpler expression")
        return x

    def _fault(self, node: ast.expr, cure: str) -> InputError:
        return InputError(f"{self.what} {_shown(self.text)}: cannot take {_shown(self._source(node))}; {cure}")

    def _source(self, node: ast.expr) -> str:
        """What a node was parsed from: the text is one line, of ASCII."""
        return self.text[node.col_offset : node.end_col_offset]


def _parsed(text: str, what: str) -> tuple[str, ast.expr]:
    if not isinstance(text, str):
        raise InputError(f"{what} is {text!r}; give a text")
    text = " ".join(text.split())
    cure = "use numbers, variables, + - * / ** and parentheses"
    if "#" in text or not text.isascii():
        raise InputError(f"{what} {_shown(text)} cannot be read; {cure}")
    try:
        return text, ast.parse(text, mode="eval").body
    except SyntaxError as error:
        column = min(max((error.offset or 1), 1), max(len(text), 1))
        raise InputError(f"{what} {_shown(text)} cannot be read near column {column}; {cure}") from error
    except (ValueError, RecursionError, MemoryError) as error:  # null characters, thousands of parentheses
        raise InputError(f"{what} {_shown(text)} cannot be read; {cure}") from error


def _reduced(above: fmpz_mpoly, below: fmpz_mpoly) -> Ratio:
    common = above.gcd(below)
    if below.leading_coefficient() < 0:
        common = -common
    return Ratio(above // common, below // common)


def _size(x: Ratio) -> tuple[int, ...]:
    return (*x.numerator.degrees(), *x.denominator.degrees())


def _bits(x: Ratio) -> int:
    """The size of the largest power of x's numbers, per power: bits of the sums of its coefficients."""
    return max(sum(abs(int(c)) for c in p.coeffs()).bit_length() - 1 for p in (x.numerator, x.denominator))


def _shown(text: str) -> str:
    return repr(text if len(text) <= 80 else text[:77] + "...")
