"""Ruled pieces under motions that no rational function describes, such as screws, over short times.

There every pose is a polynomial in the local time but for a small proved rest (Taylor's theorem in balls).  The search
in doubles takes the polynomials and counts the rest; events are refined with the poses themselves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, ctx, fmpq, fmpq_poly

from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import above, below, dyadic, exact_value, precision, to_double
from firstcontact.exact.systems.ruled_systems import Curve, Jet
from firstcontact.motion.relative.curved import CurvedPiece, terms
from firstcontact.search.rulings.ruled_pieces import Coefficients, Directrix, RuledPiece

TERMS, BITS = 14, 128
"""Of the power series that stand for poses."""
MOST_OFF = 2.0**-52
"""Of the size of a pose: the rest of its polynomial at most."""
LEAST_PART = fmpq(1, 2**30)
"""Of a piece of motion: the shortest time tried."""
MOST_CELLS = 256
"""Into which the range of a part is cut to enclose its size."""

Rows = list[list[fmpq_poly]]


@dataclass(frozen=True)
class PoseWindow:
    """The pose of a seen from b at the times middle + half x, x in [-1, 1]; backwards: at middle - half x.

    rows    (3, 4) polynomials in x
    off     how far entries of the linear part, and of the shift, are from them at most
    """

    motion: CurvedPiece
    start: fmpq
    end: fmpq
    rows: Rows
    off: tuple[float, float]
    backwards: bool = False

    @property
    def middle(self) -> fmpq:
        return (self.start + self.end) / 2

    @property
    def half(self) -> fmpq:
        return (self.end - self.start) / 2

    @property
    def clock(self) -> fmpq_poly:
        """The time as a function of x."""
        return fmpq_poly([self.middle, -self.half if self.backwards else self.half])

    def true_time(self, x: float) -> float:
        """The time at a local one, the nearest double."""
        return to_double(self.clock(exact_value(x)))

    def true_times(self, lo: float, hi: float) -> tuple[float, float]:
        """Doubles around the times from one local one to another, within the window."""
        start, end = (self.clock(exact_value(min(max(x, -1.0), 1.0))) for x in (lo, hi))
        return below(start), above(end)

    def at(self, x: arb) -> tuple[list[list[arb]], list[list[arb]]]:
        """(3, 4) balls: the pose and its derivative by x."""
        middle, half = self.clock.coeffs() if self.half else (self.middle, fmpq(0))
        with terms(2, ctx.prec):
            series = self.motion.series(arb(middle) + x * arb(half))
            return [[c[0] for c in row] for row in series], [[c[1] * arb(half) for c in row] for row in series]

    def reversed(self) -> PoseWindow:
        rows = [[p(fmpq_poly([0, -1])) for p in row] for row in self.rows]
        return PoseWindow(self.motion, self.start, self.end, rows, self.off, not self.backwards)


def pose_windows(motion: CurvedPiece, first: fmpq, last: fmpq) -> Iterator[PoseWindow]:
    """Windows that cover [first, last], in order."""
    waiting = [(first, last)]
    while waiting:
        start, end = waiting.pop()
        window = _window(motion, start, end)
        if window is not None:
            yield window
        elif end - start < LEAST_PART * (motion.end - motion.start):
            raise UnsupportedPair(f"{motion.leg_a.of} with {motion.leg_b.of}: a pose that no short polynomial follows")
        else:
            cut = start + (end - start) * fmpq(15, 31)  # no power of two: events like those
            waiting += [(cut, end), (start, cut)]


def _window(motion: CurvedPiece, start: fmpq, end: fmpq) -> PoseWindow | None:
    """None where the polynomials would be too far off."""
    middle, half = (start + end) / 2, (end - start) / 2
    with terms(TERMS, BITS):
        near = motion.series(arb(middle))
        far = motion.series(arb(middle, arb(half)))
        entries = [[_polynomial(c, d, half) for c, d in zip(x, y, strict=True)] for x, y in zip(near, far, strict=True)]
    rows = [[p for p, _ in row] for row in entries]
    off = max(x for row in entries for _, x in row[:3]), max(row[3][1] for row in entries)
    sizes = [sum(abs(c) for c in p.coeffs()) for row in rows for p in row]
    if off[0] > MOST_OFF or off[1] > MOST_OFF * float(max(*sizes, 1)):
        return None
    return PoseWindow(motion, start, end, rows, off)


def _polynomial(near: Sequence[arb], far: Sequence[arb], half: fmpq) -> tuple[fmpq_poly, float]:
    """An entry in x, and what it leaves out: radii, and the last term over the whole time (Lagrange)."""
    found, off, power = [], arb(0), arb(1)
    for k in range(TERMS - 1):
        c = near[k] * power
        found.append(dyadic(arb(c.mid())))
        off += c.rad()
        power *= arb(half)
    off += abs(far[TERMS - 1]) * power
    return fmpq_poly(found), above(dyadic(arb(off.upper()))) if off.is_finite() else float("inf")


@dataclass(frozen=True)
class PosedPiece(RuledPiece):
    """A piece in the frame of the other body, polynomials for the motion; times are the window's local ones.

    still   the piece in its own frame, in local time
    """

    still: RuledPiece
    window: PoseWindow

    @classmethod
    def posed(cls, piece: RuledPiece, window: PoseWindow) -> PosedPiece:
        """piece: in its own frame, in true time."""
        still = in_local_time(piece, window)
        first, second = (_moved(d, window.rows) for d in (still.first, still.second))
        return cls(first, second, piece.u, still, window)

    def curves(self, part: int) -> tuple[Curve, Curve]:
        """The directrices over a part, with the pose itself."""
        first, second = self.still.curves(part)
        return PosedCurve(first, self.window), PosedCurve(second, self.window)

    @cached_property
    def off(self) -> tuple[float, float]:
        linear, shift = self.window.off
        place, slope = _sizes(self.still)
        gap = 1.01 * (linear * place + shift)
        return gap, max(1.01 * linear * slope, 2.02 * gap)

    def reversed(self) -> PosedPiece:
        back, still, window = super().reversed(), self.still.reversed(), self.window.reversed()
        return PosedPiece(back.first, back.second, self.u, still, window)


class PosedCurve(Curve):
    """A curve under the pose of a window."""

    def __init__(self, still: Curve, window: PoseWindow) -> None:
        self.still, self.window = still, window

    def jet(self, x: arb, time: arb, order: int) -> Jet:
        own = self.still.jet(x, time, order)
        pose, moved = self.window.at(time)
        point = _plus(_turned(pose, own.point), [row[3] for row in pose])
        if order == 0:
            return Jet(point, [], [], [], [])
        drift = _plus(_turned(moved, own.point), [row[3] for row in moved])
        by_x, by_t = _turned(pose, own.x), _plus(_turned(pose, own.t), drift)
        if order == 1:
            return Jet(point, by_x, by_t, [], [])
        mixed = _plus(_turned(pose, own.xt), _turned(moved, own.x))
        return Jet(point, by_x, by_t, _turned(pose, own.xx), mixed)


def in_local_time(piece: RuledPiece, window: PoseWindow) -> RuledPiece:
    """The piece with the local time of the window in place of T."""
    first, second = (tuple(_substituted(c, window.clock) for c in d) for d in (piece.first, piece.second))
    return RuledPiece(first, second, piece.u)


def _substituted(c: Coefficients, clock: fmpq_poly) -> Coefficients:
    return [fmpq_poly(list(row))(clock).coeffs() or [fmpq(0)] for row in c]


def _moved(directrix: Directrix, rows: Rows) -> Directrix:
    """X, Y, Z, W under the pose."""
    parts = [[fmpq_poly(list(row)) for row in c] for c in directrix]
    size = max(map(len, parts))
    parts = [[*c, *[fmpq_poly([])] * (size - len(c))] for c in parts]
    columns = list(zip(*parts, strict=True))
    moved = [[sum((m * c for m, c in zip(row, x, strict=True)), fmpq_poly([])) for x in columns] for row in rows]
    return [[p.coeffs() or [fmpq(0)] for p in c] for c in (*moved, parts[3])]


def _sizes(piece: RuledPiece) -> tuple[float, float]:
    """Bounds, over all of the window: of the sums of a point's coordinates, in size, and of its derivative by x."""
    largest = [0.0, 0.0]
    with precision(64):
        for k, part in enumerate(piece.parts):
            for curve in piece.curves(k):
                cells, done = [(part.lowest, part.highest)], 0
                while cells:
                    lo, hi = cells.pop()
                    jet = curve.jet(arb((lo + hi) / 2, arb((hi - lo) / 2)), arb(0, 1), 1)
                    found = [sum(map(abs, v), arb(0)).upper() for v in (jet.point, jet.x)]
                    if all(x.is_finite() for x in found):
                        largest = [max(a, float(x) * 1.01) for a, x in zip(largest, found, strict=True)]
                        continue
                    done += 1
                    if done > MOST_CELLS:
                        raise UnsupportedPair("a ruled surface with a pole, or near to one")
                    cells += [(lo, (lo + hi) / 2), ((lo + hi) / 2, hi)]
    return largest[0], largest[1]


def _turned(pose: list[list[arb]], v: Sequence[arb]) -> list[arb]:
    return [row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in pose]


def _plus(v: Sequence[arb], w: Sequence[arb]) -> list[arb]:
    return [x + y for x, y in zip(v, w, strict=True)]
