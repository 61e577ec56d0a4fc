"""Where pieces of ruled surfaces go on into each other: borders that are no borders of the whole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from firstcontact.exact.numbers import rational

if TYPE_CHECKING:
    from firstcontact.body.ruled.surface import RuledSurface


def share_ruling(a: RuledSurface, end_a: int, b: RuledSurface, end_b: int) -> bool:
    """Whether an end ruling of one piece is one of the other's, both with ranges of u, at rest: equal ends."""
    assert a.u is not None and b.u is not None
    u, v = rational(a.u[end_a], "u"), rational(b.u[end_b], "u")
    for x, y in zip(a.sides, b.sides, strict=True):
        p, q = [c(u) for c in x.components], [c(v) for c in y.components]
        if any(p[k] * q[3] != q[k] * p[3] for k in range(3)):
            return False
    return True


def proved_joints(pieces: Sequence[RuledSurface]) -> list[frozenset[str]]:
    """Of each piece, at rest and not trimmed, the borders that it shares with the opposite border of a piece."""
    plain = [not (piece.deforming or piece.trim) for piece in pieces]
    return [
        frozenset(
            f"{way}{end}"
            for way in "us" for end in (0, 1)
            if is_plain and any(ok and _meet(way, piece, end, other) for ok, other in zip(plain, pieces, strict=True))
        )
        for is_plain, piece in zip(plain, pieces, strict=True)
    ]  # fmt: skip


def _meet(way: str, piece: RuledSurface, end: int, other: RuledSurface) -> bool:
    """Whether the piece's border at that end of u or s is the other's border at the other end."""
    if way == "u":
        return piece.u is not None and other.u is not None and share_ruling(piece, end, other, 1 - end)
    if piece.s is None or other.s is None or piece.u != other.u:
        return False
    same: bool = piece.sides[end] == other.sides[1 - end]
    return same
