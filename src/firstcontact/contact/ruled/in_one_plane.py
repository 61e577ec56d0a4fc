"""Flat ruled pieces that move in one plane: the border of one meets the other, or one holds the other.

What they share first they share with borders, and all that lies in one plane is in no general position in space.  So
each border of one is made a wall across the plane, which meets the other piece exactly where the border does.  Before,
between and after these times one point of every piece tells whether the other body holds it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import count, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import fmpq, fmpz_poly

from firstcontact.body.kept import Kept
from firstcontact.body.ruled.rational_curve import RationalCurve, derivative
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.heights.meeting import ascents_along
from firstcontact.contact.later import waiting
from firstcontact.contact.leading import leads
from firstcontact.contact.named import element
from firstcontact.contact.ways import Passed
from firstcontact.exact.fields.roots import roots_in
from firstcontact.exact.numbers import exact_value, rational
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled, sub, whole
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactInterval, ContactIntervals, Element, ElementPair, FirstContact, Stats, Status
from firstcontact.timeline.answers import all_told, lasting, union
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.exact.rigid import Matrix

First = Callable[[Query], FirstContact]
Intervals = Callable[[Query], ContactIntervals]
Named = tuple[str, int]

MOST_WALLS = 40
"""Of a body whose borders are taken."""
BOXES = 200_000
"""That doubles look at for a wall; general questions take some dozens."""
_NORMAL = Kept["Vector | tuple[()]"]()
_WALLS = Kept["tuple[Wall, ...]"]()


class Wall(NamedTuple):
    """A border of a piece, as far as 1 across its plane to either side.

    number: of the piece; name: of the border; ends: of the elements where it begins and ends.
    """

    shape: RuledSurface
    number: int
    name: Named
    ends: tuple[Named, Named]

    def element(self, body: Body, which: str, met: Element) -> Element:
        """That of the piece, of one of the wall."""
        kind, index = self.ends[met.index] if met.kind == "end_ruling" else self.name
        return element(body, kind, index, self.number, which)


@dataclass(frozen=True)
class InOnePlane:
    """Two bodies in one plane.

    which: the one of them whose borders are walls.  normal: of the other one, in its frame.
    """

    query: Query
    which: int
    walls: tuple[Wall, ...]
    normal: Vector

    def first(self, ask: First) -> FirstContact | Passed:
        """The first contact; ask: tells it of others."""
        query = self.query
        if self._is_held(query.first, ask) is not False:
            return Passed("they may share points at the start")
        met: list[tuple[Wall, FirstContact]] = []
        stats, last = Stats(), query.end
        for wall in self.walls:
            found = ask(self._of_wall(wall, last))
            stats = stats + found.stats
            if found.status in (Status.UNDECIDED, Status.INITIAL_CONTACT):
                return Passed(found.reason or "they share points at the start")
            if found.time_interval is not None:
                met.append((wall, found))
                last = min(last, exact_value(found.time_interval[1]))
        stats = replace(stats, ways=(), seconds=query.stats().seconds)
        met = [x for x in met if exact_value(_times(x[1])[0]) <= last]
        return self._earliest(met, stats) if met else FirstContact.free(stats, **query.shared)

    def _earliest(self, met: list[tuple[Wall, FirstContact]], stats: Stats) -> FirstContact:
        """Of those that may be first."""
        wall, found = min(met, key=lambda x: _times(x[1]))
        lo, hi = _times(found)[0], min(_times(x)[1] for _, x in met)

        def places() -> dict[str, object]:
            pairs = [self._pair(x, y) for x, y in met]
            others = tuple(self._renamed(wall, x) for x in found.others)
            alone = all(pair == pairs[0] for pair in pairs)
            return {
                "element_a": self._pair(wall, found).element_a, "element_b": self._pair(wall, found).element_b,
                "others": others, "contact_set": found.contact_set if alone else None,
            }  # fmt: skip

        until = min(lo, *(x.free_until for _, x in met if x.free_until is not None))
        return waiting(
            found, places, time_interval=(lo, hi), free_until=until, stats=stats, time_exact=None, **self.query.shared
        )

    def _pair(self, wall: Wall, found: FirstContact) -> ElementPair:
        assert found.element_a is not None and found.element_b is not None
        return self._renamed(wall, ElementPair(found.element_a, found.element_b))

    def _renamed(self, wall: Wall, pair: ElementPair) -> ElementPair:
        """The pair of the bodies, of one of a wall and the other body."""
        body, which = self.query.bodies[self.which], "ab"[self.which]
        if self.which == 0:
            return ElementPair(wall.element(body, which, pair.element_a), pair.element_b)
        return ElementPair(pair.element_a, wall.element(body, which, pair.element_b))

    def intervals(self, ask: Intervals, ask_first: First) -> ContactIntervals | Passed:
        """All contacts; ask: tells them of others."""
        query, told = self.query, list[ContactInterval]()
        for wall in self.walls:
            found = ask(self._of_wall(wall, query.end))
            if found.status is Status.UNDECIDED:
                return Passed(str(found.reason))
            told += found
        met = union(told)
        times = [exact_value(t) for x in met for t in (x.start_interval[0], x.end_interval[1])]
        ends = [query.first, *times, query.end]
        for start, end in zip(ends[::2], ends[1::2], strict=True):
            if start < end:  # no border meets the other body between
                held = self._is_held((start + end) / 2, ask_first)
                if held is None:
                    return Passed("doubles do not tell whether one holds the other")
                told += [lasting(start, end)] if held else []
        return all_told(query, told)

    def _is_held(self, time: fmpq, ask: First) -> bool | None:
        """Whether the body with walls holds a piece of the other one, of which none meets a wall then; None: in doubt.
        """
        held = False
        for piece in shape_of(self.query.bodies[1 - self.which]).pieces:
            found = ask(self._with(1 - self.which, _of_ruling(piece, _inner_ruling(piece), self.normal), time, time))
            if found.status is Status.UNDECIDED:
                return None
            held |= found.status is not Status.FREE
        return held

    def _of_wall(self, wall: Wall, last: fmpq) -> Query:
        return self._with(self.which, wall.shape, self.query.first, last)

    def _with(self, which: int, shape: RuledSurface, first: fmpq, last: fmpq) -> Query:
        """About one of the bodies and what moves in the place of the other."""
        body = self.query.bodies[which]
        other: Any = Moving(shape, body.motion) if isinstance(body, Moving) else shape
        own = replace(self.query, a=other) if which == 0 else replace(self.query, b=other)
        return replace(own.part(first, last), budget=BOXES, progress=None)


def _times(found: FirstContact) -> tuple[float, float]:
    assert found.time_interval is not None
    return found.time_interval


# -- which bodies are taken -----------------------------------------------------------------------------------


def in_one_plane(query: Query) -> InOnePlane | None:
    """None of bodies that are not flat, or do not stay in one plane all the time; of exact times, and of budgets."""
    if query.is_algebraic or query.budget is not None or query.last is None or query.first == query.last:
        return None
    shapes = [shape_of(body) for body in query.bodies]
    if any(not hasattr(shape, "pieces") for shape in shapes):
        return None
    normals: list[Any] = [_NORMAL.of(shape, partial(_normal_of, shape)) for shape in shapes]
    if not all(normals):
        return None
    ascents = ascents_along(query, normals[0])
    if ascents is None or any(low < high for low, high in ascents.ranges):
        return None
    if ascents.meetings() != [(query.first, query.end)]:
        return None
    known = [_WALLS.of(shape, partial(_walls_of, shape, n)) for shape, n in zip(shapes, normals, strict=True)]
    order = sorted((1, 0) if leads(*query.bodies) else (0, 1), key=lambda k: len(known[k]))
    which = next((k for k in order if 0 < len(known[k]) <= MOST_WALLS), None)
    return None if which is None else InOnePlane(query, which, known[which], normals[1 - which])


def _normal_of(shape: Any) -> Vector | tuple[()]:
    """Across the plane of a body that lies in one and has borders, about as long as that; () of others."""
    pieces = shape.pieces
    if any(piece.deforming or piece.trim or piece.s is None for piece in pieces):
        return ()
    ends = pieces[0].u or (0, 1)
    places = (ends[0], (ends[0] + ends[1]) / 2, ends[1])
    start, *others = (side.place(rational(u, "u")) for side in pieces[0].sides for u in places)
    ways = [sub(p, start) for p in others]
    found = max((cross(p, q) for p, q in pairwise([*ways, ways[0]])), key=lambda n: dot(n, n))
    if not any(found):
        return ()
    normal = scaled(max(abs(c) for way in ways for c in way) / max(map(abs, found)), found)
    heights = [side.height(normal) for piece in pieces for side in piece.sides]
    return normal if None not in heights and all(h == heights[0] for h in heights) else ()


def _walls_of(shape: Any, normal: Vector) -> tuple[Wall, ...]:
    """All borders; none where a piece is folded: its folds are borders, too."""
    if any(not _is_unfolded(piece, normal) for piece in shape.pieces):
        return ()
    return tuple(wall for number, piece in enumerate(shape.pieces) for wall in _of_piece(number, piece, normal))


def _of_piece(number: int, piece: RuledSurface, normal: Vector) -> Iterator[Wall]:
    for k, side in enumerate(piece.sides):
        if not side.is_constant:
            first, second = (side.mapped(_shift(scaled(fmpq(h), normal))) for h in (-1, 1))
            ends = ("vertex", k), ("vertex", 2 + k)
            yield Wall(RuledSurface(first, second, u=piece.u), number, ("directrix", k), ends)
        elif piece.u is None:  # else where rulings at the ends of u begin
            apex, other = ("directrix", k), ("directrix", 1 - k)
            ends = (other, apex) if k else (apex, other)
            yield Wall(_of_ruling(piece, _inner_ruling(piece), normal), number, ("face", 0), ends)
    for i, u in enumerate(piece.u or ()):
        if _is_ruling(piece, end := rational(u, "u")):
            ends = ("vertex", 2 * i), ("vertex", 2 * i + 1)
            yield Wall(_of_ruling(piece, end, normal), number, ("end_ruling", i), ends)


def _of_ruling(piece: RuledSurface, u: fmpq, normal: Vector) -> RuledSurface:
    """The wall of one ruling."""
    p, q = (side.place(u) for side in piece.sides)
    ways = (scaled(fmpq(h), normal) for h in (-1, 1))
    return RuledSurface(*(RationalCurve.segment(add(p, way), add(q, way)) for way in ways))


def _is_ruling(piece: RuledSurface, u: fmpq) -> bool:
    """Whether it has two ends."""
    p, q = (side.place(u) for side in piece.sides)
    return p != q


def _inner_ruling(piece: RuledSurface) -> fmpq:
    lo, hi = (rational(u, "u") for u in piece.u or (-1, 1))
    return next(u for k in count(2) if _is_ruling(piece, u := lo + (hi - lo) / k))


def _shift(way: Vector) -> Matrix:
    """The map that shifts."""
    x, y, z = (tuple((*(fmpq(int(i == k)) for k in range(3)), way[i])) for i in range(3))
    return x, y, z


def _is_unfolded(piece: RuledSurface, normal: Vector) -> bool:
    """Whether no inner place maps to the border but those of the piece's own borders.

    That is so where P_u x P_s, which is linear in s, keeps its side of the plane, and vanishes along rulings at most.
    """
    x, y = (side.components for side in piece.sides)
    ruling = tuple(q * x[3] - p * y[3] for p, q in zip(x[:3], y[:3], strict=True))
    _, (across,) = whole(normal)
    signs = []
    for c in (x, y):
        way = tuple(derivative(p) * c[3] - p * derivative(c[3]) for p in c[:3])
        signs.append(_sign_of(dot(across, cross(way, ruling)), piece))
    return None not in signs and {*signs} in ({1}, {-1}, {0, 1}, {0, -1})


def _sign_of(p: fmpz_poly, piece: RuledSurface) -> int | None:
    """That which a polynomial keeps over the parameters of a piece; 0: it vanishes; None: it changes."""
    ends = None if piece.u is None else (rational(piece.u[0], "u"), rational(piece.u[1], "u"))
    if p.is_zero():
        return 0
    inner = [x for x in roots_in(p, ends) if ends is None or (x.compare(ends[0]) > 0 and x.compare(ends[1]) < 0)]
    if any(x.multiplicity % 2 for x in inner) or (ends is None and p.degree() % 2):
        return None
    lo, hi = ends or (fmpq(0), fmpq(1))
    values = (p(lo + (hi - lo) * fmpq(k, p.degree() + 2)) for k in range(1, p.degree() + 2))
    return next(1 if value > 0 else -1 for value in values if value != 0)
