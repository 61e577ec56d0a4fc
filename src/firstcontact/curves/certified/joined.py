"""Polylines joined to branches where they meet, and their graph: by their places (u, v) and their points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.curves.certified.chains import Chain
from firstcontact.curves.exactly.answer import Collected, same
from firstcontact.result import Stats
from firstcontact.result_curve import Branch, BranchEnd, ExactParameters, GraphNode, OpenPlace, SingularPoint

if TYPE_CHECKING:
    from firstcontact.curves.fields import CurveFields

# Places this near each other, in pieces, are one: exact ones agree to rounding, certified ones to that of a simple
# crossing.  So are points, in parts of their size.
ONE_PLACE = 1e-8


@dataclass(frozen=True, eq=False)
class Stop:
    """An end of a strand.

    place     (2,) positions along both chains; None where it is known that nothing else ends
    at_knot   whether it is an end of the curve only if nothing goes on there, and a bound of the chains is next to it
    """

    end: BranchEnd
    place: np.ndarray | None = None
    at_knot: bool = False


@dataclass(frozen=True, eq=False)
class JoinedStrand:
    """A polyline; `stops` is empty for a loop.  places: (n, 2) positions of an exact one along both chains."""

    points: np.ndarray
    parameters: np.ndarray
    stops: tuple[Stop, ...]
    multiplicity: int = 1
    places: np.ndarray | None = None


def knot(p: Chain, q: Chain, place: np.ndarray, point: np.ndarray, parameters: np.ndarray) -> Stop:
    """An end on a knot's ruling."""
    u, v, s, t = *(float(x) for x in place), *(float(x) for x in parameters[2:])
    on = (*p.borders("us", u, s, ONE_PLACE), *q.borders("vt", v, t, ONE_PLACE))
    return Stop(BranchEnd("boundary", on, point, parameters), place, at_knot=True)


class FoundChains(Collected):
    """What is known of the curve of two chains.

    Besides, places left open, how many cells were looked at and pairs decided exactly, and fields with apexes, which
    `add_isolated` takes.
    """

    def __init__(self) -> None:
        super().__init__()
        self.open_places: list[OpenPlace] = []
        self.seen = self.settled = 0
        self.apexes: list[CurveFields] = []
        self.cusps: list[np.ndarray] = []

    def fields(self) -> CurveFields:
        return self.collected() | {
            "method": "certified",
            "open_places": tuple(self.open_places),
            "stats": Stats(
                node_visits=self.seen, undecided=len(self.open_places), exact_evaluations=self.settled
            ),
        }

    def add(self, strands: list[JoinedStrand], places: list[OpenPlace], chains: tuple[Chain, ...] | None,
            exact: Sequence[CurveFields]) -> None:  # fmt: skip
        """What two chains share: strands, places left open, and the fields of their pairs of pieces decided exactly.

        chains: None where no pair is.
        """
        for fields in exact:
            self._add_points(fields)
        groups: list[list[Stop]] = []
        if chains is not None:
            near = Near(chains)
            strands = _cut(strands, near)
            groups = near.groups([stop for strand in strands for stop in strand.stops])
        alone = [group[0] for group in groups if len(group) == 1 and group[0].at_knot and not group[0].end.on]
        places = places + [_lonely(stop) for stop in alone]
        first = len(self.nodes)
        for place in places:
            self._node(place.point, [sum(place.u) / 2, sum(place.v) / 2], "undecided")
        ends_at = [0] * len(places)
        through = {id(stop): group for group in groups if len(group) == 2 for stop in group}
        numbers: dict[int, int] = {}
        for group in groups:
            if len(group) > 2:
                stop = group[0]
                number = self._node(stop.end.point, stop.end.parameters, "node", stop.end.exact)
                numbers.update({id(stop): number for stop in group})
                if not any(x.kind == "node" and same(stop.end.point, x.point) for x in self.singular):
                    self.singular.append(SingularPoint(stop.end.point, "node"))
        for strand, stops in _chains(strands, through):
            ends, own = [], []
            for stop in stops:
                end = stop.end
                if id(stop) in numbers:
                    end, number = replace(end, kind="node"), numbers[id(stop)]
                elif end.kind == "undecided" or stop in alone:
                    end = replace(end, kind="undecided")
                    n = int(np.argmin([np.abs(place.point - end.point).max() for place in places]))
                    ends_at[n] += 1
                    number = first + n
                else:
                    number = self._node(end.point, end.parameters, end.kind, end.exact)
                ends.append(end)
                own.append(number)
            closed = not ends
            self.branches.append(
                Branch(strand.points, strand.parameters, closed, tuple(ends), strand.multiplicity)  # type: ignore[arg-type]
            )
            self._add_edges(strand, own)
        self.open_places += [replace(place, ends=n) for place, n in zip(places, ends_at, strict=True)]

    def _add_points(self, fields: CurveFields) -> None:
        """What is no branch."""
        self.two_dimensional |= fields["two_dimensional"]
        for x in fields["singular_points"]:
            if not any(x.kind == other.kind and same(x.point, other.point) for other in self.singular):
                self.singular.append(x)
        for segment in fields["overlap_lines"]:
            if not any(same(segment[k], x[0]) and same(segment[1 - k], x[1]) for k in (0, 1) for x in self.segments):
                self.segments.append(segment)

    def add_cusps(self, points: Sequence[np.ndarray]) -> None:
        """Points of polylines; of several at one place, one is a singular point."""
        self.cusps += points
        for point in points:
            if not any(x.kind == "cusp" and same(point, x.point) for x in self.singular):
                self.singular.append(SingularPoint(point, "cusp"))

    def add_isolated(
        self, exact: Sequence[CurveFields], is_on_more: Callable[[np.ndarray], bool] | None = None
    ) -> None:
        """Points that are on nothing else, once all else is there; is_on_more: by default whether a branch has it."""
        for fields in exact:
            nodes = {node.point.tobytes(): node for node in fields["graph"].nodes if node.kind == "isolated"}  # type: ignore[union-attr]
            for point in fields["isolated_points"]:
                if not (any(same(point, x) for x in self.isolated) or (is_on_more or self._is_told)(point)):
                    self.isolated.append(point)
                    self.nodes.append(nodes[point.tobytes()])

    def _is_told(self, point: np.ndarray) -> bool:
        """Whether it is one of the points of a branch."""
        near = ONE_PLACE * max(1.0, np.abs(point).max())
        return any((np.abs(branch.points - point).max(1) <= near).any() for branch in self.branches)

    def _add_edges(self, strand: JoinedStrand, ends: list[int]) -> None:
        """Those between the ends and cusps; a loop without cusps has a regular node."""
        cusps = [*self.cusps, *(x.point for x in self.singular if x.kind == "cusp")]
        stops = sorted({int(k) for x in cusps for k in np.flatnonzero((strand.points == x).all(1))})
        last = len(strand.points) - 1
        stops = [k for k in stops if k < last and (k > 0 or not ends)]
        numbers = [self._node(strand.points[k], strand.parameters[k], "cusp") for k in stops]
        if not ends:
            numbers = numbers or [self._node(strand.points[0], strand.parameters[0], "regular")]
            ends = [numbers[0], numbers.pop(0)]
        self.edges += pairwise([ends[0], *numbers, ends[1]])

    def _node(
        self, point: np.ndarray, where: np.ndarray | Sequence[float], kind: str, exact: ExactParameters | None = None
    ) -> int:
        u, v = float(where[0]), float(where[1])
        self.nodes.append(GraphNode(point, kind, exact or ExactParameters(lambda: (u, v))))
        return len(self.nodes) - 1


def _lonely(stop: Stop) -> OpenPlace:
    """At a knot beyond which nothing goes on: two curves there are nearer each other than doubles tell."""
    u, v = (float(x) for x in stop.end.parameters[:2])
    return OpenPlace(stop.end.point, (u, u), (v, v), 0)


class Near:
    """Which stops are at one place."""

    def __init__(self, chains: tuple[Chain, ...]) -> None:
        self.chains = chains

    def __call__(self, a: Stop, b: Stop) -> bool:
        if a.place is None or b.place is None:
            return False
        apart = np.abs(a.place - b.place)
        for side, chain in enumerate(self.chains):
            if chain.closed:
                apart[side] = min(apart[side], abs(len(chain.pieces) - apart[side]))
        size = max(1.0, float(np.abs(a.end.point).max()))
        return bool(apart.max() <= ONE_PLACE and np.abs(a.end.point - b.end.point).max() <= ONE_PLACE * size)

    def same_ends(self, a: JoinedStrand, b: JoinedStrand) -> bool:
        return any(all(self(x, y) for x, y in zip(a.stops, order, strict=True)) for order in (b.stops, b.stops[::-1]))

    def groups(self, stops: Sequence[Stop]) -> list[list[Stop]]:
        """Those that may have company."""
        groups: list[list[Stop]] = []
        for stop in stops:
            if stop.place is None:
                continue
            own = next((group for group in groups if self(group[0], stop)), None)
            if own is None:
                groups.append([stop])
            else:
                own.append(stop)
        return groups


def _cut(strands: list[JoinedStrand], near: Near) -> list[JoinedStrand]:
    """The strands in parts, where they pass through a place at a knot at which others end or pass too.

    What runs along a knot's ruling is known from both sides: it stays once.
    """
    passing = [(n, k, _inner(near.chains, strand, k))
               for n, strand in enumerate(strands) for k in _at_knots(near.chains, strand)]  # fmt: skip
    ending = [stop for strand in strands for stop in strand.stops]
    meeting = [group for group in near.groups([*(stop for _, _, stop in passing), *ending]) if len(group) > 1]
    shared = {id(stop) for group in meeting for stop in group}
    cuts: dict[int, list[int]] = {}
    for n, k, stop in passing:
        if id(stop) in shared:
            cuts.setdefault(n, []).append(k)
    found: list[JoinedStrand] = []
    for n, strand in enumerate(strands):
        for part in _parts(near.chains, strand, cuts[n]) if n in cuts else [strand]:
            if not any(near.same_ends(part, x) for x in found if _run_along_knots(near.chains, part, x)):
                found.append(part)
    return found


def _at_knots(chains: tuple[Chain, ...], strand: JoinedStrand) -> list[int]:
    """Points of a strand, none of its ends, that may be on a knot's ruling."""
    if strand.places is None:
        return []
    on = _on_knots(chains, strand.places)
    whole = np.asarray(on.any(1))
    if whole.all():
        whole[1:-1] = on[1:-1].all(1)
    whole[-1] = False
    whole[0] = whole[0] and not strand.stops
    return [int(k) for k in np.flatnonzero(whole)]


def _on_knots(chains: tuple[Chain, ...], places: np.ndarray) -> np.ndarray:
    """(n, 2): whether places are on a knot's ruling of either chain."""
    nearest = np.round(places)
    lengths = np.array([len(chain.pieces) for chain in chains])
    inner = np.array([chain.closed for chain in chains]) | ((nearest > 0) & (nearest < lengths))
    return (np.abs(places - nearest) <= ONE_PLACE) & inner & np.array([chain.has_knots for chain in chains])


def _run_along_knots(chains: tuple[Chain, ...], *strands: JoinedStrand) -> bool:
    return all(x.places is not None and _on_knots(chains, x.places).any(1).all() for x in strands)


def _parts(chains: tuple[Chain, ...], strand: JoinedStrand, cuts: list[int]) -> list[JoinedStrand]:
    """The strand cut at these of its points."""
    assert strand.places is not None
    last = len(strand.points) - 1
    if strand.stops:
        limits = [0, *cuts, last]
        rows = [np.arange(a, b + 1) for a, b in pairwise(limits)]
    else:
        limits = [*cuts, cuts[0] + last]
        rows = [np.arange(a, b + 1) % last for a, b in pairwise(limits)]
    stops = [_inner(chains, strand, k % last if not strand.stops else k) for k in limits]
    if strand.stops:
        stops[0], stops[-1] = strand.stops
    return [
        replace(strand, points=strand.points[row], parameters=strand.parameters[row], stops=ends,
                places=strand.places[row])
        for row, ends in zip(rows, pairwise(stops), strict=True)
    ]  # fmt: skip


def _inner(chains: tuple[Chain, ...], strand: JoinedStrand, k: int) -> Stop:
    assert strand.places is not None
    p, q = chains
    return knot(p, q, strand.places[k], strand.points[k], strand.parameters[k])


def _chains(strands: list[JoinedStrand], through: dict[int, list[Stop]]) -> list[tuple[JoinedStrand, tuple[Stop, ...]]]:
    """Strands joined where two stops are one place, each with its ends; those of loops are ()."""
    own = {id(stop): strand for strand in strands for stop in strand.stops}
    left = {id(strand): strand for strand in strands}
    found: list[tuple[JoinedStrand, tuple[Stop, ...]]] = []

    def follow(strand: JoinedStrand, begin: int) -> None:
        """From stop `begin` of the strand on."""
        start, parts = strand.stops[begin], []
        while True:
            del left[id(strand)]
            parts.append((strand, begin))
            stop = strand.stops[1 - begin]
            pair = through.get(id(stop))
            if pair is None:
                break
            further = pair[1] if pair[0] is stop else pair[0]
            strand = own[id(further)]
            if id(strand) not in left:
                break
            begin = 0 if strand.stops[0] is further else 1
        closed = through.get(id(stop)) is not None
        if len(parts) == 1 and begin == 0 and not closed:
            found.append((strand, (start, stop)))
            return
        points, parameters = (
            np.concatenate([(getattr(x, name)[::-1] if turned else getattr(x, name))[1 if i else 0 :]
                            for i, (x, turned) in enumerate(parts)])
            for name in ("points", "parameters")
        )  # fmt: skip
        if closed:
            points[-1] = points[0]
        multiplicity = min(x.multiplicity for x, _ in parts)
        found.append((JoinedStrand(points, parameters, (), multiplicity), () if closed else (start, stop)))

    for strand in strands:
        for begin, stop in enumerate(strand.stops):
            if id(strand) in left and id(stop) not in through:
                follow(strand, begin)
    for strand in strands:
        if id(strand) in left:
            if strand.stops:
                follow(strand, 0)
            else:
                found.append((strand, ()))
    return found
