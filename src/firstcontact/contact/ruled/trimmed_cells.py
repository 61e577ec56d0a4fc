"""Trimmed pieces as cells without trimming, for the search in doubles: some lie in the piece, others on its borders.

What all cells are free of, the piece is free of; a point of a cell that is sure is one of the piece.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from flint import fmpq, fmpz

from firstcontact.body.ruled.rational_curve import terms
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import fraction, rational
from firstcontact.exact.polynomials import bernstein

MOST_DEPTH = 12
"""Halvings of both ranges: a contact nearer to the border than this part of them is left to exact arithmetic."""
Range = tuple[fmpq, fmpq]


@dataclass(frozen=True, eq=False)
class PieceCell:
    """piece: the given one; number: its own in the body; u, s: ranges, None where the piece is not trimmed."""

    piece: RuledSurface
    number: int
    u: Range | None = None
    s: Range | None = None
    depth: int = 0

    @classmethod
    def of(cls, piece: RuledSurface, number: int) -> PieceCell:
        """The whole piece, its rulings bounded."""
        if not piece.trim:
            return cls(piece, number)
        if piece.u is None or piece.s is None:
            ends = piece.without_end
            raise UnsupportedPair(f"{piece!r} is trimmed, with no ends of {ends}, which doubles do not take; give them")
        u, s = ((rational(lo, "range"), rational(hi, "range")) for lo, hi in (piece.u, piece.s))
        return cls(piece, number, u, s)

    @cached_property
    def surface(self) -> RuledSurface:
        """Untrimmed; the borders that are none of the piece's are `joined` ones."""
        if self.u is None or self.s is None:
            return self.piece
        u, s = ((fraction(lo), fraction(hi)) for lo, hi in (self.u, self.s))
        return self.piece.part(u, s)

    @cached_property
    def is_sure(self) -> bool:
        """Whether it lies in the piece."""
        return all(least >= 0 for least, _ in self._values)

    @cached_property
    def is_out(self) -> bool:
        """Whether no point of it lies in the piece."""
        return any(most < 0 for _, most in self._values)

    @cached_property
    def _values(self) -> list[Range]:
        """Bounds of the polynomials that trim, over the cell."""
        if self.u is None or self.s is None:
            return []
        return [_range(terms(trim.polynomial), self.u, self.s) for trim in self.piece.trim]

    @cached_property
    def quarters(self) -> list[PieceCell]:
        """Those that may hold points of the piece."""
        if self.u is None or self.s is None or self.depth == MOST_DEPTH:
            return []
        halves = [(u, s) for u in _halves(self.u) for s in _halves(self.s)]
        cells = (PieceCell(self.piece, self.number, u, s, self.depth + 1) for u, s in halves)
        return [cell for cell in cells if not cell.is_out]


def _range(table: dict[tuple[int, int], fmpz], u: Range, s: Range) -> Range:
    """Bounds of a polynomial over the box."""
    size = max(i for i, _ in table), max(j for _, j in table)
    values = [c for row in bernstein.grid(table, u, s, size) for c in row]
    return min(values), max(values)


def _halves(x: Range) -> tuple[Range, Range]:
    middle = (x[0] + x[1]) / 2
    return (x[0], middle), (middle, x[1])
