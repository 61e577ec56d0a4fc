"""When two bodies may be near each other: balls that cover them, over all stretches of their motions at once.

A stretch is what lies between two values of a joint, or two poses: there it is proved how far points pass from where
they are in the middle.  Bodies of which no such thing is known are taken to be wherever their box comes in all of the
span.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.exact.numbers import above, below
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative import chords, reach
from firstcontact.motion.trajectory import Trajectory
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape

# Balls that cover a body's box: doublings, halving its longest sides.
_HALVINGS = 4
_AT_ONCE = 4096
"""Stretches that are looked at together."""
Run: TypeAlias = tuple[fmpq, fmpq]
ByStretches: TypeAlias = Linkage | Trajectory


class BallCover(NamedTuple):
    """Balls that hold a body in its own frame: centres (k, 3), and the radius of each of them."""

    centres: tuple[tuple[float, ...], ...]
    radius: float


_COVERS = Kept[tuple[BallCover, BallCover] | None]()


def runs(query: Query) -> Iterator[Run]:
    """The times of the query, stretches of the clock joined, outside of which the bodies are proved to be apart."""
    motions = _motions(query)
    covers = [_cover_of(body, query) for body in query.bodies]
    if not motions or any(x.times != motions[0].times for x in motions) or any(cover is None for cover in covers):
        yield query.first, query.end
        return
    lo, hi = motions[0].stretch(query.first), motions[0].stretch(query.end) + 1
    near = [_near(query, covers, np.arange(k, min(k + _AT_ONCE, hi))) for k in range(lo, hi, _AT_ONCE)]
    yield from _joined(np.concatenate(near).tolist(), motions[0].times, query.first, query.end)


def during(query: Query, run: Run) -> Query:
    """The question about one run, of motions that are no longer than it is."""
    a, b = (_cut(body, run) for body in query.bodies)
    return replace(query.part(*run), a=a, b=b)


def _cut(body: Body, run: Run) -> Body:
    if not isinstance(body, Moving) or not isinstance(body.motion, Linkage | Trajectory):
        return body
    return Moving(body.body, body.motion.during(*run))


def _motions(query: Query) -> list[ByStretches]:
    """Those of many stretches."""
    return [x.motion for x in query.bodies if isinstance(x, Moving) and isinstance(x.motion, Linkage | Trajectory)]


def _near(query: Query, covers: list[tuple[BallCover, BallCover] | None], asked: np.ndarray) -> np.ndarray:
    """Those of the stretches in which the bodies may meet."""
    for fineness in range(2):
        both = zip(query.bodies, covers, strict=True)
        sides = [_balls(body, cover[fineness], asked) for body, cover in both if cover]
        asked = asked[_may_meet(*sides)]
    return asked


def _balls(body: Body, cover: BallCover, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, k, 3) and radii (n, k) of balls that hold the body in all of each stretch."""
    if not isinstance(body, Moving) or not isinstance(body.motion, Linkage | Trajectory):
        return np.array(cover.centres)[None], np.full((1, len(cover.centres)), cover.radius)
    middles, far = _paths(body.motion, cover.centres)
    return middles[asked], far[asked] + cover.radius


@lru_cache(maxsize=16)
def _paths(motion: ByStretches, centres: tuple[tuple[float, ...], ...]) -> tuple[np.ndarray, np.ndarray]:
    """Over all stretches of the clock: the same for all bodies that a body is asked about with."""
    places = reach.places if isinstance(motion, Linkage) else chords.places
    return places(motion, np.array(centres))  # type: ignore[arg-type]  # each is given its own


def _may_meet(a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(n,) whether some ball of a may meet one of b in each stretch."""
    between = a[0][:, :, None] - b[0][:, None]
    square = np.einsum("nijk,nijk->nij", between, between)
    reach = (a[1][:, :, None] + b[1][:, None]) * (1.0 + 1e-12)
    near: np.ndarray = ~(square > reach * reach).all(axis=(1, 2))  # what is no number proves nothing
    return near


def _joined(stretches: list[int], times: tuple[fmpq, ...], first: fmpq, last: fmpq) -> Iterator[Run]:
    begin = 0
    for k in range(1, len(stretches) + 1):
        if k == len(stretches) or stretches[k] != stretches[k - 1] + 1:
            yield max(first, times[stretches[begin]]), min(last, times[stretches[k - 1] + 1])
            begin = k


def _cover_of(body: Body, query: Query) -> tuple[BallCover, BallCover] | None:
    """Of a body in its own frame, or all places of one whose motion has no stretches; None where none is known."""
    if isinstance(body, Moving) and not isinstance(body.motion, Linkage | Trajectory):
        return None if query.last is None else _covered(*body.bounds((below(query.first), above(query.last))))
    return _covers(shape_of(body))


def _covers(body: Shape) -> tuple[BallCover, BallCover] | None:
    """One ball around the body, and several around parts of its box; None of a body that has no box of its own."""
    def made() -> tuple[BallCover, BallCover] | None:
        return _covered(*body.bounds())

    return None if getattr(body, "deforming", False) else _COVERS.of(body, made)


def _covered(lo: np.ndarray, hi: np.ndarray) -> tuple[BallCover, BallCover] | None:
    return (_cover(lo, hi, 0), _cover(lo, hi, _HALVINGS)) if np.isfinite([lo, hi]).all() else None


def _cover(lo: np.ndarray, hi: np.ndarray, halvings: int) -> BallCover:
    counts, sides = np.ones(3, int), hi - lo
    for _ in range(halvings):
        longest = int(np.argmax(sides))
        counts[longest] *= 2
        sides[longest] *= 0.5
    grid = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    radius = 0.5 * float(np.linalg.norm(sides)) * (1 + 1e-14) + 1e-14 * float(np.abs([lo, hi]).max())
    return BallCover(tuple(map(tuple, (lo + grid * sides).tolist())), radius)
