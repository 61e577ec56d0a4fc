"""The certified fast path: first contact of composite quadric models by advancement over their convex pieces.

Every interval passed is proved free, a reported contact is enclosed by a proved free time and a time with a proved
common point; what neither settles is "open" (see `kernels.convex.advancement`).  No tessellation, any motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import above, below, to_double
from firstcontact.kernels.convex.advancement import (
    BY_FORMS,
    BY_VERTEX_A,
    CONTACT,
    FREE,
    INITIAL,
    SPENT,
    advance_pieces,
)
from firstcontact.kernels.convex.along import inner_point, place_of_touch
from firstcontact.kernels.convex.support import FORMS
from firstcontact.kernels.poses import pose_at
from firstcontact.kernels.workspace import (
    ACTIVE,
    COUNT,
    FREE_UNTIL,
    GAP,
    GAPS,
    HI,
    LO,
    MODE,
    NEWTON,
    NORMAL,
    PART,
    POINT,
    POSE_A,
    POSE_B,
    RESULTS,
    STEPS,
    TIME,
    UNKNOWN,
    VERTEX,
    workspace,
)
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.curved import CurvedPiece, step_at
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.motion.relative.stretches import Untold, Window, windows_in_turn
from firstcontact.search.convex.close_up import CloseUp, Passage
from firstcontact.search.convex.common_point import PieceMeeting
from firstcontact.search.convex.convex import ConvexPieces, NotConvex, convex_pieces, covering_pieces
from firstcontact.search.convex.separation import NoFunction

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

REASONS = {SPENT: "budget"}
# Parts of the workspace, by Python's own numbers: those index faster.
IN_RESULTS, FRAMES = int(RESULTS), slice(int(POSE_A), int(POSE_A) + 6)
Feature = tuple[str, int]
NEAR = 1e-9
"""Of the size of its coordinates: points nearer to each other than that are one."""
SOON = (2.0**-6, 2.0**-3, 1.0)
"""Of the width of the answer: how long after a touch its place is looked at."""
MOST_LOOKS = 12
"""Times at which one pair of pieces is followed in balls."""


class WorkDone(TypedDict):
    """What an answer says of the steps taken."""

    gap: float
    steps: int
    newton: int
    gaps: int
    spent: int


@dataclass(slots=True)
class Advance:
    """What the fast path proved; not changed any more (frozen ones take twice as long to make).

    status         "free": no common point in the span; "contact"; "initial": a common point at the start; "open".
    free_until     no common point at any time before it (for "open" it may be the start), in the query's clock.
    time           the contact time, rounded; time_interval (lo, hi): no common point before lo, one at or before hi.
    point, normal  (3,) world frame, normal unit, from b towards a; None where there are none.
    features_a/_b  (kind, index) of the touching features of either body; "corner": the row of a corner of a piece.
    frames         of a contact: (6, n) numbers, the rows of the workspace from POSE_A on, near its time.
    gap            proved distance along the last direction at `free_until`, of the pair of pieces last advanced.
    reason         of "open": "precision", "budget", or what of the model or motion is beyond this path.
    spread         whether what may touch at the contact is more than one point.
    also           features_a and _b of other pairs of pieces that touch at the same time; None: not known.
    elsewhere      whether some of these seem to do so at another place.
    one_event      whether the features are those of one of the events at the contact.
    complete       whether no surface passes through the point but those of the features.
    graze          of "open": times between which alone the bodies may touch first, and only at one instant.
    beyond         whether a model is no union of convex pieces, so that nothing was tried.
    spent          what it took of the budget.
    """

    status: str
    free_until: float
    time: float | None = None
    time_interval: tuple[float, float] | None = None
    point: np.ndarray | None = None
    normal: np.ndarray | None = None
    features_a: tuple[Feature, ...] = ()
    features_b: tuple[Feature, ...] = ()
    frames: list[list[float]] = field(default_factory=list)
    gap: float = 0.0
    reason: str | None = None
    spread: bool = False
    also: tuple[tuple[tuple[Feature, ...], tuple[Feature, ...]], ...] | None = None
    elsewhere: bool = False
    one_event: bool = False
    complete: bool = False
    graze: tuple[fmpq, fmpq] | None = None
    beyond: bool = False
    steps: int = 0
    newton: int = 0
    gaps: int = 0
    spent: int = 0


def advance(
    a: Body, b: Body, first: fmpq, last: fmpq, tolerance: float = 1e-12, budget: int = 10_000, covering: bool = False,
    enough: fmpq | None = None, close_up: bool = True,
) -> Advance:  # fmt: skip
    """The first common point of two bodies (CompositeQuadric, or Moving ones) over the closed [first, last].

    first, last: finite fmpq or numbers; tolerance: width of `time_interval` over the span; budget: strides at most.
    covering: of pieces that cover the bodies.  enough: as `work.Query` has it.  close_up: whether what strides leave
    open is looked at in balls.
    """
    begin, end = _exact(first), _exact(last)
    try:
        pieces_of = covering_pieces if covering else convex_pieces
        pieces_a, pieces_b = pieces_of(shape_of(a)), pieces_of(shape_of(b))
        stretches = windows_in_turn(a, b, begin, end)
        search = PieceSearch(pieces_a, pieces_b, stretches, tolerance, budget, (stretches.first, stretches.last))
        if close_up:
            search.motions = lambda: curved_pieces(a, b, begin, end)
        search.enough = math.inf if enough is None else above(enough)
        return search.run()
    except (NotConvex, Untold) as reason:
        return Advance("open", below(begin), reason=str(reason), beyond=isinstance(reason, NotConvex))


def _exact(t: float | fmpq) -> fmpq:
    return t if isinstance(t, fmpq) else fmpq(*float(t).as_integer_ratio())


class PieceSearch:
    """One query: windows in time order, in each all pairs of pieces, clipped at the earliest contact so far."""

    def __init__(
        self, a: ConvexPieces, b: ConvexPieces, stretches: Sequence[Window], tolerance: float, budget: int,
        span: tuple[float, float] | None = None,
    ) -> None:  # fmt: skip
        """span: of all stretches, where these are made in turn."""
        self.a, self.b = a, b
        self.windows = stretches
        first, self.last = span or (stretches[0].first, stretches[-1].last)
        self.width = tolerance * (self.last - first)
        self.budget = budget
        self.workspace, self.counters = workspace()
        self.results = self.workspace[IN_RESULTS]
        self.motions: Callable[[], list[CurvedPiece]] | None = None
        """Gives the steps of the motion, exact; None where what doubles leave open stays so."""
        self.enough = math.inf

    def run(self) -> Advance:
        for k, window in enumerate(self.windows):
            found = self._window(window)
            if found is None:
                continue
            if k > 0 and found.status == "initial":
                return self._at_seam(window, found)
            return found
        return self._answer("free", self.last)

    def _at_seam(self, window: Window, found: Advance) -> Advance:
        """A common point at the start of a later window: all before it was proved free."""
        return self._answer(
            "contact", window.first, time=window.first, time_interval=(window.first, window.first), point=found.point
        )

    def _window(self, window: Window) -> Advance | None:
        """The answer if there is one in this window; None proves it free."""
        found = self._among(window, [(i, j) for i in self.a.fewest for j in self.b.fewest])
        if found is not None and found.status == "open" and (self.a.union is not None or self.b.union is not None):
            return self._among(window, list(product(range(self.a.count), range(self.b.count))))
        return found

    def _among(self, window: Window, pairs: list[tuple[int, int]]) -> Advance | None:
        """The same for these pairs of pieces."""
        best: Advance | None = None
        stuck: Advance | None = None
        contacts: list[Advance] = []
        limit = window.last
        for i, j in pairs:
            outcome, seen = self._followed(window, i, j, limit)
            if seen is not None:
                if seen.status == "contact":
                    contacts.append(seen)
                    best = self._earlier(best, seen)
                    assert best.time_interval is not None
                    limit = min(limit, best.time_interval[1])
                elif stuck is None or seen.free_until < stuck.free_until:
                    stuck = seen
                continue
            if outcome == FREE:
                continue
            if outcome == INITIAL:
                return self._answer(
                    "initial", window.first, time=window.first, time_interval=(window.first, window.first),
                    point=self.results[POINT : POINT + 3].copy(),
                )  # fmt: skip
            if outcome == CONTACT:
                contacts.append(self._contact())
                best = self._earlier(best, contacts[-1])
                assert best.time_interval is not None
                limit = min(limit, best.time_interval[1])
            elif stuck is None or self.results[FREE_UNTIL] < stuck.free_until:
                stuck = self._open(REASONS.get(outcome, "precision"))
        if stuck is None and best is not None:
            best.also = _besides(best, contacts) if len(contacts) > 1 else ()
            best.elsewhere = bool(best.also) and _is_elsewhere(best, contacts)
            return best
        if stuck is None or (best is not None and best.time_interval and best.time_interval[0] <= stuck.free_until):
            return best
        return stuck

    def _followed(self, window: Window, i: int, j: int, limit: float) -> tuple[int, Advance | None]:
        """The outcome of advancing these pieces up to the limit; where balls end it, what they prove."""
        t, close, looks = window.first, None, 0
        while True:
            outcome = self._outcome(window, i, j, t, limit)
            if outcome in (FREE, INITIAL, CONTACT) or outcome in REASONS or looks == MOST_LOOKS:
                return outcome, None
            reached = float(self.results[FREE_UNTIL])
            if reached >= min(window.last, self.enough):
                return outcome, None
            looks += 1
            if looks == 1 and self._lands(window, i, j, reached):
                return CONTACT, None
            close = close or self._close_up(window, i, j)
            if close is None:
                return outcome, None
            begin, last = max(_exact(reached), close.motion.start), min(_exact(limit), close.motion.end)
            passage = close.passage(begin, last, _exact(self.width), True)
            if passage is None:
                return outcome, None
            if passage.state is not None and passage.until == close.motion.start:  # contact before any free time
                self.results[POINT : POINT + 3] = close.place(passage.state)[0]
                return INITIAL, None
            if passage.state is not None:
                return outcome, self._touched(window, close, passage, i, j)
            if passage.graze is not None:
                found = self._answer("open", below(passage.until), reason="precision", graze=passage.graze)
                return outcome, found
            t = below(passage.until)
            if passage.until == last:
                return FREE, None
            if t <= reached:
                return outcome, None

    def not_apart(self, t: float) -> tuple[list[tuple[int, int]], bool]:
        """(pairs of pieces that doubles do not prove apart at t; whether the last one is proved to share inner points)

        The search ends with that one.  Of pieces that are solids, not flat.
        """
        (window,), near = self.windows, []
        for i, j in product(range(self.a.count), range(self.b.count)):
            outcome = self._outcome(window, i, j, t, t)
            if outcome != FREE:
                near.append((i, j))
            if outcome == INITIAL:
                return near, True
        return near, False

    def is_apart(self, i: int, j: int, t: float) -> bool:
        """Whether doubles prove two pieces apart at t."""
        (window,) = self.windows
        return bool(self._outcome(window, i, j, t, t) == FREE)

    def passage(self, t: float) -> tuple[Passage, np.ndarray | None] | None:
        """What balls prove of the only window from t on, and a common point at the end if there is contact then.

        None where nothing is, or where more than one pair of pieces comes near at once.
        """
        (window,) = self.windows
        near = [(window.last, -1, -1)]  # the earliest and the next times from which a pair is not proved apart
        for i, j in product(range(self.a.count), range(self.b.count)):
            outcome = self._outcome(window, i, j, t, window.last)
            if outcome != FREE:
                near.append((t if outcome == INITIAL else float(self.results[FREE_UNTIL]), i, j))
        near.sort()
        begin, i, j = near[0]
        close = self._close_up(window, i, j) if len(near) > 1 and near[1][0] > begin else None
        if close is None:
            return None
        limit = min(_exact(near[1][0]), close.motion.end)
        passage = close.passage(_exact(begin), limit, _exact(self.width), False)
        return None if passage is None else (passage, close.point_at_end(passage))

    def _outcome(self, window: Window, i: int, j: int, t: float, limit: float) -> int:
        return advance_pieces(
            self.a.array, i, window.a, self.b.array, j, window.b,
            t, limit, window.inner, self.width, self.budget, self.workspace, self.counters,
        )  # fmt: skip

    def _earlier(self, best: Advance | None, found: Advance) -> Advance:
        """The earlier contact, with an interval that holds for both pairs."""
        if best is None:
            return found
        assert best.time_interval and found.time_interval and best.time is not None and found.time is not None
        first, other = (best, found) if best.time <= found.time else (found, best)
        lo = min(best.time_interval[0], found.time_interval[0])
        hi = min(best.time_interval[1], found.time_interval[1])
        time = min(max(first.time, lo), hi)  # type: ignore[type-var]
        return replace(first, time=time, time_interval=(lo, hi), free_until=lo, **self._work())

    def _contact(self) -> Advance:
        r, c = self.results.tolist(), self.counters.tolist()
        return Advance(
            "contact", r[LO], r[TIME], (r[LO], r[HI]),
            self.results[POINT : POINT + 3].copy(), -self.results[NORMAL : NORMAL + 3], *self._features(c),
            self.workspace[FRAMES].tolist(), **self._work(),
        )  # fmt: skip

    def _lands(self, window: Window, i: int, j: int, reached: float) -> bool:
        """Whether pieces, free until `reached`, are proved to share a point soon after: results as of CONTACT."""
        rate = 0.0 if self.motions is None else place_of_touch(
            self.a.array, i, window.a, self.b.array, j, window.b, window.first, window.last, reached, self.width,
            self.workspace, self.counters,
        )  # fmt: skip
        return self._judged(window, reached, rate)

    def _judged(self, window: Window, reached: float, rate: float) -> bool:
        """Whether pieces that are free until `reached` share a point at the place of a guess: results as of CONTACT.

        The place is found in doubles and judged exactly: where forms are large beside what they tell apart, doubles
        never see it inside.
        """
        a, b, w, c = self.a.array, self.b.array, self.workspace, self.counters
        latest = min(window.inner, reached + 0.98 * self.width)
        if not rate or latest < reached:
            return False
        meeting = PieceMeeting(self._motion(window), self.a.solids[int(c[PART])], self.b.solids[int(c[PART + 1])])
        time = min(max(float(self.results[TIME]), reached), latest)
        _, *point = inner_point(a, window.a, b, window.b, time, w, c)
        time = min(max(time + meeting.correction(time, point, self._active(), rate), reached), latest)
        for share in SOON:
            at = min(time + share * self.width, latest)
            regular, *point = inner_point(a, window.a, b, window.b, at, w, c)
            if regular and meeting.is_at(at, point):
                self.results[TIME], self.results[LO], self.results[HI] = time, reached, at
                _, *point = inner_point(a, window.a, b, window.b, time, w, c)  # and the frames then
                place, pose = meeting.nearer(time, point, self._active()), w[POSE_B]
                self.results[POINT : POINT + 3] = pose[:9].reshape(3, 3) @ place + pose[9:12]
                return True
        return False

    def _active(self) -> list[tuple[int, int, float, list[float]]]:
        """Of the active forms (side, number in their piece, multiplier, row)."""
        c, found = self.counters.tolist(), []
        for k in range(c[COUNT] + c[COUNT + 1]):
            side = 0 if k < c[COUNT] else 1
            pieces, row = (self.a, self.b)[side], c[ACTIVE + k]
            first = int(pieces.array[c[PART + side], FORMS])
            found.append((side, row - first, float(self.workspace[UNKNOWN, 4 + k]), pieces.array[row, :10].tolist()))
        return found

    def _motion(self, window: Window) -> CurvedPiece:
        """The step of the motion in a window, exact."""
        assert self.motions is not None
        return step_at(self.motions(), (_exact(window.first) + _exact(window.last)) / 2)

    def _close_up(self, window: Window, i: int, j: int) -> CloseUp | None:
        """None where balls do not follow these pieces: the union of all has no forms of its own."""
        if self.motions is None or i >= len(self.a.solids) or j >= len(self.b.solids):
            return None
        try:
            return CloseUp(self._motion(window), self.a, i, self.b, j)
        except NoFunction:
            return None

    def _touched(self, window: Window, close: CloseUp, passage: Passage, i: int, j: int) -> Advance:
        """The contact that balls prove."""
        state = passage.state
        assert state is not None and passage.event is not None
        interval = below(passage.stretches[0].hi), above(passage.until)
        point, normal = close.place(state)
        rows = [
            [int(pieces.array[piece, FORMS]) + k for s, k in close.separation.active if s == side]
            for side, (pieces, piece) in enumerate(((self.a, i), (self.b, j)))
        ]
        time = min(max(to_double(passage.event), interval[0]), interval[1])
        for row, motion in ((POSE_A, window.a), (POSE_A + 1, window.b)):
            pose_at(motion, time, self.workspace, row)
            self.workspace[row + 4, :9] = np.linalg.inv(self.workspace[row, :9].reshape(3, 3)).ravel()
        return self._answer(
            "contact", interval[0], time=time, time_interval=interval, point=point, normal=normal,
            features_a=named(self.a, rows[0]), features_b=named(self.b, rows[1]),
            frames=self.workspace[POSE_A : POSE_A + 6, :12].tolist(),
        )  # fmt: skip

    def _features(self, c: list[int]) -> tuple[tuple[Feature, ...], tuple[Feature, ...]]:
        """From the integers of the workspace."""
        if c[MODE] == BY_FORMS:
            middle, end = ACTIVE + c[COUNT], ACTIVE + c[COUNT] + c[COUNT + 1]
            return named(self.a, c[ACTIVE:middle]), named(self.b, c[middle:end])
        form, vertex = [c[ACTIVE]], c[VERTEX]
        if c[MODE] == BY_VERTEX_A:
            return _at_vertex(self.a, vertex), named(self.b, form)
        return named(self.a, form), _at_vertex(self.b, vertex)

    def _open(self, reason: str) -> Advance:
        return self._answer("open", float(self.results[FREE_UNTIL]), reason=reason)

    def _answer(self, status: str, free_until: float, **fields: Any) -> Advance:
        return Advance(status, free_until, **self._work(), **fields)

    def _work(self) -> WorkDone:
        c = self.counters.tolist()
        steps: int = c[STEPS]
        return {
            "gap": float(self.results[GAP]), "steps": steps, "newton": c[NEWTON], "gaps": c[GAPS], "spent": steps,
        }  # fmt: skip


def _besides(
    best: Advance, contacts: list[Advance]
) -> tuple[tuple[tuple[tuple[str, int], ...], tuple[tuple[str, int], ...]], ...]:
    assert best.time_interval is not None
    hi = best.time_interval[1]
    return tuple((x.features_a, x.features_b) for x in contacts if x.point is not best.point and x.free_until <= hi)


def _is_elsewhere(best: Advance, contacts: list[Advance]) -> bool:
    assert best.time_interval is not None and best.point is not None
    others = [x.point for x in contacts if x.point is not None and x.free_until <= best.time_interval[1]]
    size = float(np.abs(best.point).max())
    return any(float(np.abs(p - best.point).max()) > NEAR * size for p in others)


def named(pieces: ConvexPieces, forms: list[int]) -> tuple[Feature, ...]:
    """The feature of the body on all these forms; their faces where pieces meet inside the body."""
    key = tuple(forms)
    known = pieces.named.get(key)
    if known is None:
        surfaces = [int(pieces.array[k, 10]) for k in forms]
        labels, on = pieces.labels, frozenset(surfaces)
        holding = [label for around, label in labels.items() if on < around] if len(on) > 1 else []
        if on in labels:
            known = (labels[on],)
        elif len(holding) == 1:  # a vertex in which more faces meet
            known = (holding[0],)
        else:
            known = tuple(labels[frozenset([s])] for s in surfaces if frozenset([s]) in labels)
        pieces.named[key] = known
    return known


def _at_vertex(pieces: ConvexPieces, row: int) -> tuple[Feature, ...]:
    return (("corner", row),)
