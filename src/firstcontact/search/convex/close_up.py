"""Two convex pieces that nearly touch, followed in balls where doubles cannot tell contact from a miss.

Around the time where their separation s (`search.convex.separation`) has an extremum all is proved: no contact, a short
one, a short gap, or, where s may be zero there, no contact but at most at that time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb, fmpq

from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.kernels.convex.support import BOX
from firstcontact.motion.relative.curved import CurvedPiece, terms
from firstcontact.search.convex.convex import ConvexPieces
from firstcontact.search.convex.separation import BITS, LEAST, STATIC, ZERO, Convex, NoFunction, Separation, State

NEAR = fmpq(1, 20)
"""Of the step of the motion: how far off an extremum may be."""
SURE = fmpq(1, 2 ** (BITS // 2 + 32))
"""Of the size: a separation at an extremum that is less counts as zero until it is proved."""
ROUNDED = fmpq(1, 2 ** (BITS - 56))
"""Of the size: a separation at a given time that is less counts as zero; a graze has more at the ends of its CORE."""
CORE = fmpq(1, 2**80)
"""Of the step of the motion: the time around such an extremum in which nothing is proved."""
PAST = 1e-8
"""Of the size: the separation from which on doubles go on."""
MOST_PROOFS = 60


@dataclass(frozen=True)
class Stretch:
    """Proved over the closed [lo, hi]: contact, or none."""

    contact: bool
    lo: fmpq
    hi: fmpq


@dataclass(frozen=True)
class Passage:
    """What is proved from a time on; between two stretches one event lies in less than the width asked for.

    graze: where s may be zero at its extremum, the time of which lies between the two.
    event, state: when contact begins, unrounded but not exact; solved at the first time with a proved common point.
    """

    stretches: list[Stretch]
    graze: tuple[fmpq, fmpq] | None = None
    event: fmpq | None = None
    state: State | None = None

    @property
    def until(self) -> fmpq:
        return self.stretches[-1].hi


class CloseUp:
    """One pair of convex pieces over one step of the motion."""

    def __init__(self, motion: CurvedPiece, a: ConvexPieces, i: int, b: ConvexPieces, j: int) -> None:
        box = b.array[j, BOX : BOX + 6]
        self.motion = motion
        self.separation = Separation(
            motion, _functions(a, i), _functions(b, j), box[:3].copy(), 1.01 * float(np.linalg.norm(box[3:]))
        )
        self.proofs = 0

    def passage(self, t: fmpq, limit: fmpq, width: fmpq, first: bool) -> Passage | None:
        """From t on, up to `limit` at most; None where nothing is proved.  first: only up to the first common point."""
        system = self.separation
        guess = system.guess(t) if t < limit else None
        start = None if guess is None else system.solve(guess, STATIC)
        if start is None:
            return None
        if limit - t <= width and self._touch(limit, [start]):  # all that is left is the last instant
            return None
        self.proofs = 0
        span = self.motion.end - self.motion.start
        extremum = system.solve(start, LEAST)
        if extremum is not None and abs(extremum.time - t) > NEAR * span:
            extremum = None
        hints, cuts, graze, end = [start], [], None, limit
        bend = None if extremum is None else self._bend(extremum)
        if extremum is None or bend is None:  # where centres meet s has no slope at its extremum
            crossing = system.solve(start, ZERO)
            if crossing is None:
                return self._parting(start, limit)
            if crossing.time == t or start.s == 0:
                return None
            away = crossing.time - t
            if away > 0:
                hints.append(crossing)
                cuts = [crossing.time]
            # where they part, or were deeper before: up to where s is PAST, about, if it goes on as from the crossing
            ahead = exact_value(PAST * system.size * abs(to_double(away / start.s)))
            end = min(limit, t + max(away, fmpq(0)) + max(away, ahead))
        else:
            hints.append(extremum)
            gap = extremum.s if abs(extremum.s) > SURE * exact_value(system.size) else fmpq(0)
            if gap * bend < 0:
                root = exact_value((-to_double(gap / bend)) ** 0.5)
                for guessed in (extremum.time - root, extremum.time + root):
                    near = system.solve(State(guessed, extremum.x, fmpq(0), extremum.weights), STATIC)
                    crossing = None if near is None else system.solve(near, ZERO)
                    if crossing is not None:  # else too near the extremum to be solved for: the guess is good, then
                        hints.append(crossing)
                    cuts.append(guessed if crossing is None else crossing.time)
            elif gap == 0:
                graze = extremum.time - CORE * span, extremum.time + CORE * span
            ahead = exact_value((PAST * system.size / abs(to_double(bend))) ** 0.5)
            end = min(limit, max([extremum.time, *cuts]) + max(ahead, 4 * abs(extremum.time - t)))
        return self._proved(t, end, sorted(cuts), graze, start.s < 0, hints, width, first)

    def _parting(self, start: State, limit: fmpq) -> Passage | None:
        """Free time from a state on while the plane that is between the pieces then keeps them apart.

        That is proved of faces that were parallel and lean away from each other, which no solved state follows.
        """
        system, still = self.separation, [[x, fmpq(0), fmpq(0)] for x in (*start.x, *start.weights)]
        bound = system.apart(start, still, CORE) if start.s > 0 else None
        if bound is None or not bound.c1[1] > 0:
            return None
        ahead = exact_value(PAST * system.size / float(bound.c1[1].mid()))
        end, bound = min(limit, start.time + ahead), system.apart(start, still, ahead)
        if bound is None or not bound.is_positive(start.time, end):
            return None
        return Passage([Stretch(False, start.time, end)])

    def _bend(self, state: State) -> fmpq | None:
        """Half the second derivative of s, about."""
        paths = self.separation.paths(state)
        bound = None if paths is None else self.separation.apart(state, paths, CORE)
        if bound is None or not (bound.c2 > 0 or bound.c2 < 0):
            return None
        return exact_value(float(bound.c2.mid()))

    def _proved(
        self, t: fmpq, end: fmpq, cuts: list[fmpq], graze: tuple[fmpq, fmpq] | None, contact: bool, hints: list[State],
        width: fmpq, first: bool,
    ) -> Passage | None:
        """The stretches from t to end, cut where s changes its sign; those that are proved, in order."""
        cuts = [x for x in cuts if t < x < end]
        if graze is not None and t < graze[0] < end:
            bounds = [(t, graze[0]), (graze[1], end)] if graze[1] < end else [(t, graze[0])]
            kinds = [contact] * len(bounds)
        else:
            graze = None
            edges = [t, *cuts, end]
            room = [min(width, y - x) / 4 for x, y in zip(edges, edges[1:], strict=False)]
            bounds = [
                (x + (r if k else 0), y - (r if k < len(cuts) else 0))
                for k, (x, y, r) in enumerate(zip(edges, edges[1:], room, strict=False))
            ]
            kinds = [contact ^ bool(k % 2) for k in range(len(bounds))]
        found: list[Stretch] = []
        for (lo, hi), kind in zip(bounds, kinds, strict=True):
            if kind and first:
                state = self._common(lo, hints)
                if state is not None:
                    return Passage([*found, Stretch(True, lo, lo)], None, cuts[0] if cuts else lo, state)
                break
            if not self._holds(lo, hi, kind, hints):
                break
            found.append(Stretch(kind, lo, hi))
            if graze is not None and first:
                break
        if not found:
            return None
        return Passage(found, graze)

    def _state_at(self, t: fmpq, hints: list[State]) -> State | None:
        near = min(hints, key=lambda h: abs(h.time - t))
        return self.separation.solve(State(t, near.x, near.s, near.weights), STATIC)

    def _common(self, t: fmpq, hints: list[State]) -> State | None:
        """The state at t, with x in both pieces."""
        state = self._state_at(t, hints)
        return state if state is not None and self.separation.shares(t, state.x) else None

    def _touch(self, t: fmpq, hints: list[State]) -> bool:
        """Whether s counts as zero at t, so that neither contact nor none is proved there."""
        state = self._state_at(t, hints)
        return state is not None and abs(state.s) <= ROUNDED * exact_value(self.separation.size)

    def _holds(self, lo: fmpq, hi: fmpq, contact: bool, hints: list[State]) -> bool:
        """Whether contact, or none, is proved over [lo, hi]: in halves, where it is not at once."""
        self.proofs += 1
        if self._holds_at_once(lo, hi, contact, hints):
            return True
        if self._touch(lo, hints) or self._touch(hi, hints):
            return False
        middle = (lo + hi) / 2
        pending = [(middle, hi), (lo, middle)]
        while pending:
            lo, hi = pending.pop()
            self.proofs += 1
            if self.proofs > MOST_PROOFS:
                return False
            if not self._holds_at_once(lo, hi, contact, hints):
                middle = (lo + hi) / 2
                pending += [(middle, hi), (lo, middle)]
        return True

    def _holds_at_once(self, lo: fmpq, hi: fmpq, contact: bool, hints: list[State]) -> bool:
        system, middle = self.separation, (lo + hi) / 2
        state = min(hints, key=lambda h: abs(h.time - middle))
        if abs(state.time - middle) > hi - lo:
            solved = system.solve(State(middle, state.x, state.s, state.weights), STATIC)
            if solved is None:
                return False
            state = solved
        paths = system.paths(state)
        if paths is None:
            return False
        width = max(abs(hi - state.time), abs(lo - state.time), CORE)
        if contact:
            bounds = system.shared(state, paths, width)
            return bool(bounds) and all(bound.is_positive(lo, hi) for bound in bounds)
        bound = system.apart(state, paths, width)
        return bound is not None and bound.is_positive(lo, hi)

    def point_at_end(self, passage: Passage) -> np.ndarray | None:
        """A point about the deepest common one at the end, in the world; None where there is no contact then."""
        if not passage.stretches[-1].contact:
            return None
        guess = self.separation.guess(passage.until)
        return None if guess is None else self.place(guess)[0]

    def place(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """(point, normal) of a state in the world, in doubles; the normal is unit and points from b towards a."""
        system, leg = self.separation, self.motion.leg_b
        with terms(1, BITS):
            pose = np.array([[float(x[0].mid()) for x in row] for row in leg.series(arb(state.time))])
            normal = np.array([float(x.mid()) for x in system.outward(state)])
        x = np.array([to_double(c) for c in state.x])
        normal = normal @ np.linalg.inv(pose[:, :3])
        return pose[:, :3] @ x + pose[:, 3], normal / float(np.linalg.norm(normal))


def _functions(pieces: ConvexPieces, k: int) -> list[Convex]:
    forms, witness = pieces.solids[k]
    size = float(np.linalg.norm(pieces.array[k, BOX + 3 : BOX + 6]))
    if witness is None:
        raise NoFunction("no interior point is known")
    return [Convex(form, witness, size) for form in forms]
