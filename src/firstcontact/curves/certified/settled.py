"""Pairs of pieces decided exactly inside a curve that is certified in doubles.

Where doubles leave places open, the pairs of pieces that these touch are asked from the exact path.  At knots what it
finds goes on in the neighbouring pairs (`joined`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.chains import Chain
from firstcontact.curves.certified.joined import ONE_PLACE, JoinedStrand, Stop, knot
from firstcontact.curves.exactly.intersection import intersection
from firstcontact.result_curve import Branch, BranchEnd

if TYPE_CHECKING:

    from firstcontact.body.ruled.surface import RuledSurface
    from firstcontact.curves.fields import CurveFields

# Largest product of the degrees of Delta that is asked of one pair of pieces, and of all pairs together.
BEARABLE, MOST = 64, 4096

PiecePair = tuple[int, int]
"""Numbers of the pieces in both chains."""


class Settled:
    """What the exact path tells of pairs of pieces of two chains."""

    def __init__(self, p: Chain, q: Chain, tolerance: float) -> None:
        self.chains, self.tolerance = (p, q), tolerance
        self.known: dict[PiecePair, CurveFields | None] = {}
        """None where the boxes of the pieces share no point."""
        self._pieces: dict[tuple[int, int], RulingPiece] = {}
        self._spent = 0

    def settle(self, pairs: Collection[PiecePair]) -> bool:
        """Ask for these pairs; False, and nothing is asked, where that would take long or a piece passes infinity."""
        fresh = [pair for pair in pairs if pair not in self.known and self._may_meet(pair)]
        if any(_passes_infinity(chain.pieces[k]) for pair in fresh for chain, k in zip(self.chains, pair, strict=True)):
            return False
        sizes = [self._piece(0, i).rulings.degree * self._piece(1, j).rulings.degree for i, j in fresh]
        if max(sizes, default=0) > BEARABLE or self._spent + sum(sizes) > MOST:
            return False
        self._spent += sum(sizes)
        self.known.update({pair: None for pair in pairs if pair not in self.known})
        for i, j in fresh:
            self.known[i, j] = intersection(self._piece(0, i), self._piece(1, j), self.tolerance, None, inside=True)
        return True

    def mask(self) -> np.ndarray:
        """Bools (pieces of p, pieces of q): which pairs were asked for."""
        mask = np.zeros([len(chain.pieces) for chain in self.chains], bool)
        for pair in self.known:
            mask[pair] = True
        return mask

    def found(self) -> list[CurveFields]:
        """The fields of the pairs that were asked for; common rulings that border an area of another pair left out."""
        areas = [(pair, fields["correspondence"]) for pair, fields in self.known.items()
                 if fields is not None and fields["two_dimensional"] and fields["correspondence"]]  # fmt: skip
        found: list[CurveFields] = []
        for pair, fields in self.known.items():
            if fields is None:
                continue
            lines = fields["overlap_lines"]
            knots = product(*(chain.knots(k) for chain, k in zip(self.chains, pair, strict=True)))
            for u, v in knots if len(lines) and areas else ():
                if any(self._is_on(area, other, u, v) for other, area in areas if other != pair):
                    lines = lines[[not _is_along(line, self.chains[0].pieces[pair[0]], u) for line in lines]]
            found.append({**fields, "overlap_lines": lines})
        return found

    def _is_on(self, correspondence: Mapping[tuple[int, int], int], pair: PiecePair, u: Fraction, v: Fraction) -> bool:
        """Whether rulings at a knot of both chains are on the correspondence of a pair of pieces."""
        bounds = (chain.pieces[k].u for chain, k in zip(self.chains, pair, strict=True))
        if not all(ends is None or ends[0] <= x <= ends[1] for x, ends in zip((u, v), bounds, strict=True)):
            return False
        return sum(c * u**i * v**j for (i, j), c in correspondence.items()) == 0

    def strands(self) -> list[JoinedStrand]:
        return [self._strand(pair, branch) for pair, fields in self.known.items() if fields is not None
                for branch in fields["branches"]]  # fmt: skip

    def _piece(self, side: int, k: int) -> RulingPiece:
        if (side, k) not in self._pieces:
            self._pieces[side, k] = RulingPiece.of(self.chains[side].pieces[k])
        return self._pieces[side, k]

    def _may_meet(self, pair: PiecePair) -> bool:
        (low, high), (low_q, high_q) = (chain.piece_box(k) for chain, k in zip(self.chains, pair, strict=True))
        return not ((low > high_q).any() or (low_q > high).any())

    def _strand(self, pair: PiecePair, branch: Branch) -> JoinedStrand:
        places = np.column_stack(
            [chain.position(k, x) for chain, k, x in zip(self.chains, pair, branch.parameters.T[:2], strict=True)]
        )
        stops = tuple(self._stop(pair, end, places[at]) for at, end in zip((0, -1), branch.ends, strict=False))
        return JoinedStrand(branch.points, branch.parameters, stops, branch.multiplicity, places)

    def _stop(self, pair: PiecePair, end: BranchEnd, place: np.ndarray) -> Stop:
        """Bounds at which a piece goes on in its neighbour are none of the curve's; nothing else ends at others."""
        inner = {f"{name}={u}" for name, chain, k in zip("uv", self.chains, pair, strict=True) for u in chain.knots(k)}
        on = tuple(name for name in end.on if name not in inner)
        if end.kind == "boundary" and not on:
            return knot(*self.chains, place, end.point, end.parameters)
        if end.kind == "boundary" and len(on) == len(end.on):
            return Stop(end)
        return Stop(replace(end, on=on) if len(on) < len(end.on) else end, place)


def _passes_infinity(piece: RuledSurface) -> bool:
    """Whether it is the part of a closed surface that was left when others were cut out of it."""
    return piece.u is not None and piece.u[0] > piece.u[1]


def _is_along(line: np.ndarray, piece: RuledSurface, u: Fraction) -> bool:
    """Whether a segment lies on the ruling at u of a piece."""
    ends = piece.points(float(u), [0.0, 1.0])
    along = ends[1] - ends[0]
    off = np.linalg.norm(np.cross(line - ends[0], along), axis=1) / np.linalg.norm(along)
    return bool((off <= ONE_PLACE * max(1.0, np.abs(ends).max())).all())
