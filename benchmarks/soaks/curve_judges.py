"""Judges of intersection curves: what must be on them, and what they tell against what the surfaces are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np

from .exact_numbers import Vector
from .ruled_bodies import Body, Piece

Judge = Callable[[Any], str | None]


@dataclass(frozen=True)
class Facts:
    """What is known of a curve beforehand; None where it is not.

    holds  points that both bodies share.       empty, area  whether they share nothing, or a part with an area.
    isolated, nodes, cusps  all of these points.     loops, arcs  how many branches are closed, and how many are not.
    """

    holds: tuple[Vector, ...] = ()
    empty: bool | None = None
    area: bool | None = None
    isolated: tuple[Vector, ...] | None = None
    nodes: tuple[Vector, ...] | None = None
    cusps: tuple[Vector, ...] | None = None
    loops: int | None = None
    arcs: int | None = None

    def mapped(self, point: Callable[[Vector], Vector]) -> Facts:
        def all_of(points: tuple[Vector, ...] | None) -> tuple[Vector, ...] | None:
            return None if points is None else tuple(point(x) for x in points)
        return Facts(all_of(self.holds) or (), self.empty, self.area, all_of(self.isolated), all_of(self.nodes),
                     all_of(self.cusps), self.loops, self.arcs)


def floats(points: Sequence[Vector]) -> np.ndarray:
    return np.array([[float(c) for c in x] for x in points]).reshape(-1, 3)


def drawn(curve: Any, isolated: bool = True) -> np.ndarray:
    """(n, 2, 3) segments of branches, common rulings and, as segments of no length, isolated points."""
    parts = [np.stack([b.points[:-1], b.points[1:]], 1) for b in curve.branches if len(b.points)]
    parts.append(np.asarray(curve.overlap_lines).reshape(-1, 2, 3))
    if isolated:
        points = np.asarray(curve.isolated_points).reshape(-1, 3)
        parts.append(np.stack([points, points], 1))
    return np.concatenate(parts)


def gap(segments: np.ndarray, x: np.ndarray) -> float:
    if not len(segments):
        return float("inf")
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    k = ((x - a) * d).sum(-1) / np.maximum((d * d).sum(-1), 1e-300)
    return float(np.sqrt(((a + np.clip(k, 0, 1)[:, None] * d - x) ** 2).sum(-1)).min())


def same_points(found: np.ndarray, expected: np.ndarray, near: float) -> bool:
    found, expected = found.reshape(-1, 3), expected.reshape(-1, 3)
    if len(found) != len(expected):
        return False
    return all(np.linalg.norm(found - x, axis=1).min() <= near for x in expected)


def against_facts(
    curve: Any, facts: Facts, tolerance: float, size: float, told_besides: Callable[[np.ndarray], bool] | None = None
) -> str | None:
    """told_besides: whether an isolated point that is none of the facts is one that answers may tell."""
    near = 1e-9 * size
    if curve.open_places:
        return None
    if facts.area is not None and curve.two_dimensional != facts.area:
        return f"two_dimensional is {curve.two_dimensional}"
    if facts.empty is not None and curve.empty != facts.empty:
        return f"empty is {curve.empty}"
    if not curve.two_dimensional:
        segments = drawn(curve)
        for x in floats(facts.holds):
            if not gap(segments, x) <= tolerance + near:
                return f"{x.tolist()} is on both, but {gap(segments, x):.3g} off the curve"
    if facts.isolated is not None:
        isolated = np.asarray(curve.isolated_points).reshape(-1, 3)
        if told_besides is not None:
            isolated = isolated[[not told_besides(x) for x in isolated]]
        if not same_points(isolated, floats(facts.isolated), near):
            return f"isolated points {isolated.tolist()}, not {floats(facts.isolated).tolist()}"
    for kind, points in (("node", facts.nodes), ("cusp", facts.cusps)):
        if points is not None:
            found = np.array([s.point for s in curve.singular_points if s.kind == kind])
            if not same_points(found, floats(points), near):
                return f"{kind}s {found.tolist()}, not {floats(points).tolist()}"
    loops, arcs = (sum(b.closed == closed for b in curve.branches) for closed in (True, False))
    if facts.loops is not None and loops != facts.loops:
        return f"{loops} closed branches, not {facts.loops}"
    if facts.arcs is not None and arcs != facts.arcs:
        return f"{arcs} open branches, not {facts.arcs}"
    return None


def on_piece(piece: Piece, points: np.ndarray, u: np.ndarray, s: np.ndarray, size: float, name: str) -> str | None:
    told = ~(np.isnan(u) | np.isnan(s)) & (np.abs(u) < 1e6) & (np.abs(s) < 1e6)
    if not told.any():
        return None
    for values, bounds, letter in ((u[told], piece.u, "u"), (s[told], piece.s, "s")):
        if bounds is not None:
            lo, hi = float(bounds[0]), float(bounds[1])
            slack = 1e-9 * (hi - lo)
            if values.min() < lo - slack or values.max() > hi + slack:
                return f"{letter} of {name} runs over [{values.min()!r}, {values.max()!r}], outside of [{lo}, {hi}]"
    off = np.linalg.norm(piece.points(u[told], s[told]) - points[told], axis=-1)
    room = 1e-9 * np.maximum(size, np.abs(points[told]).max(-1)) * np.maximum(1, np.abs(s[told]))
    if not (off <= room).all():
        k = int(np.argmax(off / room))
        return f"branch point {points[told][k].tolist()} is {off[k]:.3g} off {name} at its parameters"
    return None


def of_pieces(p: Piece, q: Piece, facts: Facts, tolerance: float, seed: int) -> Judge:
    size = max(p.size, q.size)

    def judge(curve: Any) -> str | None:
        rng = Random(seed)
        for branch in curve.branches:
            x, par = np.asarray(branch.points), np.asarray(branch.parameters)
            wrong = (on_piece(p, x, par[:, 0], par[:, 2], size, "the first surface")
                     or on_piece(q, x, par[:, 1], par[:, 3], size, "the second surface"))
            if wrong:
                return wrong
            if branch.closed and np.linalg.norm(x[0] - x[-1]) > 1e-9 * size:
                return "a closed branch whose ends are apart"
        arcs = drawn(curve, isolated=False)
        for x in np.asarray(curve.isolated_points).reshape(-1, 3):
            for name, piece in (("first", p), ("second", q)):
                if piece.off(x) > 1e-9 * size:
                    return f"isolated point {x.tolist()} is {piece.off(x):.3g} off the {name} surface"
        branches = [np.stack([b.points[:-1], b.points[1:]], 1) for b in curve.branches]
        if branches and not curve.open_places:
            joined = np.concatenate(branches)
            for x in np.asarray(curve.isolated_points).reshape(-1, 3):
                if gap(joined, x) <= 1e-12 * size and not is_apex(p, x, size) and not is_apex(q, x, size):
                    return f"isolated point {x.tolist()} is on a branch"
        if len(arcs):
            for _ in range(3):
                a, b = rng.choice(arcs)
                middle = (a + b) / 2
                if np.abs(middle).max() > 5 * size:
                    continue
                for name, piece in (("first", p), ("second", q)):
                    off = piece.off(middle)
                    if off > tolerance * 1.001 + 1e-9 * size:
                        return f"middle {middle.tolist()} of a chord is {off:.3g} off the {name} surface"
        lines = np.asarray(curve.overlap_lines).reshape(-1, 2, 3)

        def apex_on_a_line(x: np.ndarray) -> bool:
            """By IntersectionCurve: isolated points are on no overlap line, "but for apexes on the other surface"."""
            return gap(lines, x) <= 1e-9 * size and (is_apex(p, x, size) or is_apex(q, x, size))

        wrong = against_facts(curve, facts, tolerance, size, apex_on_a_line)
        if wrong or curve.two_dimensional or curve.open_places:
            return wrong
        segments = drawn(curve)
        for first, second in ((p, q), (q, p)):
            for u in parameters(rng, first, 6):
                for x in crossings(first, second, u, size):
                    if np.abs(x).max() <= 3 * size and gap(segments, x) > 1.5 * tolerance + 1e-7 * size:
                        return f"{x.tolist()} is on both surfaces, but {gap(segments, x):.3g} off the curve"
        return None

    return judge


def is_apex(piece: Piece, x: np.ndarray, size: float) -> bool:
    """Whether rulings meet in x, or one is no more than x: such points are told even where a branch passes."""
    a, b = piece.ends(np.append(piece.parameters(7), [] if piece.u is None else [float(c) for c in piece.u]))
    d = b - a
    dd = (d * d).sum(-1)
    short = dd <= (1e-9 * size) ** 2
    off = np.linalg.norm(np.cross(x - a, d), axis=-1) / np.sqrt(np.where(short, 1, dd))
    at = np.linalg.norm(a - x, axis=-1) <= 1e-9 * size
    return bool((short & at).any() or (~short & (off <= 1e-9 * size)).sum() > 3)


def parameters(rng: Random, piece: Piece, n: int) -> list[float]:
    if piece.u is None:
        return [float(np.tan((rng.random() - 0.5) * 3.1)) for _ in range(n)]
    lo, hi = float(piece.u[0]), float(piece.u[1])
    return [lo + (hi - lo) * (k + rng.random()) / n for k in range(n)]


def crossings(p: Piece, q: Piece, u: float, size: float) -> list[np.ndarray]:
    """Points well inside of q, and of the ruling u of p, where that ruling meets q: roots of a polynomial in v."""
    a, b = (x[0] for x in p.ends(np.array([u])))
    d = b - a
    if not np.isfinite(d).all() or np.linalg.norm(d) < 1e-6 * size:
        return []
    origin = a
    first, second = (t.copy() for t in q.tables())
    for t in (first, second):
        t[:, :3] -= t[:, 3:] * origin
    n = len(first) + len(second) - 1
    total = np.zeros(n)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # d . (first x second)
        total += d[i] * (np.convolve(first[:, j], second[:, k]) - np.convolve(first[:, k], second[:, j]))
    biggest = np.abs(total).max()
    if biggest < 1e-12 * max(np.abs(first).max() * np.abs(second).max() * np.linalg.norm(d), 1e-300):
        return []
    roots = np.roots(np.trim_zeros(np.where(np.abs(total) < 1e-15 * biggest, 0, total)[::-1], "f"))
    out = []
    for root in roots:
        v = float(root.real)
        if abs(root.imag) > 1e-7 * (1 + abs(v)):
            continue
        if q.u is not None:
            room = 1e-5 * float(q.u[1] - q.u[0])
            if not float(q.u[0]) + room < v < float(q.u[1]) - room:
                continue
        elif abs(v) > 1e4:
            continue
        c, e = (x[0] for x in q.ends(np.array([v])))
        e = e - c
        if np.linalg.norm(np.cross(d, e)) < 1e-5 * np.linalg.norm(d) * np.linalg.norm(e):
            continue
        (s, t), *_ = np.linalg.lstsq(np.stack([d, -e], 1), c - a, rcond=None)
        if np.linalg.norm(a + s * d - c - t * e) > 1e-9 * size:
            continue
        if all(r is None or float(r[0]) + 1e-5 * float(r[1] - r[0]) < k < float(r[1]) - 1e-5 * float(r[1] - r[0])
               for r, k in ((p.s, s), (q.s, t))):
            out.append(a + s * d)
    return out


def of_solid(p: Piece, solid: Body, level: Callable[[np.ndarray], float], facts: Facts, tolerance: float,
             seed: int, first: bool) -> Judge:
    """level: below 0 inside of the solid, above outside, in the length unit of the scene at least near the boundary."""
    size = max(p.size, solid.size)
    u_column, s_column = (0, 2) if first else (1, 3)

    def judge(curve: Any) -> str | None:
        rng = Random(seed)
        for branch in curve.branches:
            x, par = np.asarray(branch.points), np.asarray(branch.parameters)
            wrong = on_piece(p, x, par[:, u_column], par[:, s_column], size, "the surface")
            if wrong:
                return wrong
            for k in {0, len(x) - 1, rng.randrange(len(x)), rng.randrange(len(x))}:
                if abs(level(x[k])) > 1e-9 * size:
                    return f"branch point {x[k].tolist()} is {level(x[k]):.3g} off the boundary of the solid"
        for x in np.asarray(curve.isolated_points).reshape(-1, 3):
            if p.off(x) > 1e-9 * size or abs(level(x)) > 1e-9 * size:
                return f"isolated point {x.tolist()} is {p.off(x):.3g} off the surface, {level(x):.3g} off the solid"
        wrong = against_facts(curve, facts, tolerance, size)
        if wrong or curve.two_dimensional or curve.open_places:
            return wrong
        segments = drawn(curve)
        for u in parameters(rng, p, 8):
            for x in passages(p, level, u):
                if gap(segments, x) > 1.5 * tolerance + 1e-7 * size:
                    return f"{x.tolist()} is on both, but {gap(segments, x):.3g} off the curve"
        return None

    return judge


def passages(p: Piece, level: Callable[[np.ndarray], float], u: float) -> list[np.ndarray]:
    """Points of the ruling u at which it passes the boundary of a solid."""
    assert p.s is not None
    a, b = (x[0] for x in p.ends(np.array([u])))
    grid = np.linspace(float(p.s[0]), float(p.s[1]), 60)
    signs = [level(a + s * (b - a)) > 0 for s in grid]
    out = []
    for k in range(len(grid) - 1):
        if signs[k] != signs[k + 1]:
            lo, hi = grid[k], grid[k + 1]
            for _ in range(45):
                m = (lo + hi) / 2
                lo, hi = (m, hi) if (level(a + m * (b - a)) > 0) == signs[k] else (lo, m)
            out.append(a + lo * (b - a))
    return out


def agreeing(size: float, what: Sequence[str]) -> Judge:
    """Curves told in several ways must have the same parts."""

    def judge(curves: Any) -> str | None:
        curves = list(curves)
        if any(c.open_places for c in curves):
            return None
        for other, name in zip(curves[1:], what[1:], strict=True):
            one = curves[0]
            if one.two_dimensional != other.two_dimensional:
                return f"two_dimensional: {what[0]} {one.two_dimensional}, {name} {other.two_dimensional}"
            if one.two_dimensional:
                continue
            counts = [[sum(b.closed for b in c.branches), sum(not b.closed for b in c.branches), len(c.overlap_lines)]
                      for c in (one, other)]
            if counts[0] != counts[1]:
                return f"closed branches, open ones, common lines: {what[0]} {counts[0]}, {name} {counts[1]}"
            pairs = [(np.asarray(one.isolated_points), np.asarray(other.isolated_points), "isolated points")]
            for kind in ("node", "cusp"):
                pairs.append((*(np.array([s.point for s in c.singular_points if s.kind == kind])
                                for c in (one, other)), f"{kind}s"))  # type: ignore[arg-type]
            for x, y, told in pairs:
                if not same_points(x, y, 1e-7 * size):
                    return f"{told}: {what[0]} {x.tolist()}, {name} {y.tolist()}"
        return None

    return judge
