"""How far out curves of whole rulings are looked for in doubles."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.contact.signs.whole_rulings import segments
from firstcontact.curves.exactly.tracing import Powers, Surfaces
from firstcontact.errors import UnsupportedPair

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled
    from firstcontact.curves.fields import CurveFields

# In sizes of the directrices.  The number of points that prove a tolerance grows with its square, as the ends of
# segments move away from the curve.
REACH = 10.0
# Points that are told in two ways differ by less, in parts of their size.
CLOSE = 1e-9
# Ranges of s that are longer are cut to what may meet the other surface, where that leaves a quarter at most: the
# number of points that prove a tolerance grows with the length of rulings, on the curve or not.
LONG = 16


class Reached(NamedTuple):
    """Two surfaces with bounded rulings.

    given   the surfaces as they were
    bounds  names of the bounds that are theirs alone: beyond them the given surfaces go on
    box     (2, 3) what lies in it is on them; None: all that both given surfaces share is
    """

    p: Any
    q: Any
    given: tuple[Any, Any]
    bounds: frozenset[str] = frozenset()
    box: np.ndarray | None = None

    def sharpen(self, points: np.ndarray, parameters: np.ndarray) -> None:
        """Set points (n, 3), and s, t of parameters (n, 4), from u and v on the given surfaces, if they were cut.

        Ends of long segments are far from them, and known to their own size.
        """
        if not self.bounds or any(len(x.pieces) > 1 for x in self.given):
            return
        p, q = (RulingPiece.of(x.pieces[0]) for x in self.given)
        u, v = (_powers(x) for x in parameters.T[:2])
        own, positions = Surfaces(p, q).points(u, v)
        # next to common rulings they are not told better by u and v
        near = np.abs(own - points).max(1) <= CLOSE * np.abs(points).max(1).clip(1.0)
        points[near] = own[near]
        parameters[near, 2:] = np.stack([p.user_s(positions[near, 0]), q.user_s(positions[near, 1])], axis=1)

    def beyond(self, fields: CurveFields) -> CurveFields:
        """Those of IntersectionCurve, for the given surfaces: branches that end at the bounds go on."""
        fields = fields | {"box": self.box}
        cut = {id(end): replace(end, kind="infinity", on=()) for branch in fields["branches"] for end in branch.ends
               if end.kind == "boundary" and not self.bounds.isdisjoint(end.on)}  # fmt: skip
        if not cut:
            return fields
        branches = tuple(replace(x, ends=tuple(cut.get(id(end), end) for end in x.ends)) for x in fields["branches"])
        points = {end.point.tobytes() for end in cut.values()}
        graph: Any = fields["graph"]
        nodes = tuple(replace(node, point=None, kind="infinity")
                      if node.kind == "boundary" and node.point.tobytes() in points else node
                      for node in graph.nodes)  # fmt: skip
        return fields | {"branches": branches, "graph": replace(graph, nodes=nodes)}


def reached(p: Ruled, q: Ruled) -> Reached:
    """Both surfaces with segments for whole rulings: as far as the other one, or REACH times their size if both are."""
    whole = [any(piece.s is None for piece in x.pieces) for x in (p, q)]
    if not any(whole):
        return Reached(_shortened(p, q), _shortened(q, p), (p, q))
    box = None
    if all(whole):
        size = REACH * max(Surfaces(RulingPiece.of(a), RulingPiece.of(b)).size() for a in p.pieces for b in q.pieces)
        box = np.array([[-size] * 3, [size] * 3])
    low, high = box if box is not None else (q if whole[0] else p).bounds()
    ball = _ball(low, high)
    (cut_p, of_p), (cut_q, of_q) = (_cut(x, *ball, names) for x, names in ((p, "us"), (q, "vt")))
    return Reached(cut_p, cut_q, (p, q), of_p | of_q, box)


def _shortened(surface: Ruled, other: Ruled) -> Ruled:
    """A single piece without the ends of long rulings: no point of the other surface is as far out."""
    if len(surface.pieces) > 1:
        return surface
    (piece,) = surface.pieces
    assert piece.s is not None
    if piece.s[1] - piece.s[0] <= LONG:
        return surface
    found = segments(piece, *_ball(*other.bounds()))
    if found is None or len(found) > 1 or found[0].u != piece.u:
        return surface
    near = found[0].s
    assert near is not None
    low, high = max(piece.s[0], near[0]), min(piece.s[1], near[1])
    return piece._with(s=(low, high)) if 0 < 4 * (high - low) <= piece.s[1] - piece.s[0] else surface


def _ball(low: np.ndarray, high: np.ndarray) -> tuple[list[float], float]:
    """Centre and radius of a ball that holds a box."""
    return (0.5 * (low + high)).tolist(), float(np.linalg.norm(high - low)) * 0.5 * (1 + 1e-9)


def _powers(x: np.ndarray) -> Powers:
    """Of parameters, of their reciprocals where these are smaller."""
    far = np.abs(x) > 1.0
    return Powers(np.divide(1.0, x, out=x.copy(), where=far), far)


def _cut(surface: Ruled, centre: list[float], reach: float, names: str) -> tuple[Ruled, frozenset[str]]:
    """The surface with segments, and the names of its new bounds."""
    pieces: list[RuledSurface] = []
    bounds: set[str] = set()
    for piece in surface.pieces:
        if piece.s is not None:
            pieces.append(piece)
            continue
        found = segments(piece, centre, reach)
        if found is None:
            raise UnsupportedPair(
                f"{surface!r} has whole rulings whose directrices meet, or go to infinity; bound s, or shorten u, "
                'or try method="algebraic"'
            )
        for x in found:
            bounds |= {f"{names[1]}={end}" for end in x.s or ()}
            bounds |= {f"{names[0]}={end}" for end in x.u or () if end not in (piece.u or ())}
        pieces += found
    return pieces[0] if len(pieces) == 1 else RuledStrip(pieces, name=surface.name), frozenset(bounds)
