"""Pointed pins before slanted stairs of long triangles: tips that dip into faces, near the origin and far off.

A triangle meets the pin where the greatest of four convex functions is not above 0 somewhere on it: golden sections
along the one side and, for each point, across it find the least of these to a billionth.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np

from .scene import Question, Scene

GOLDEN, ROUNDS = (5**0.5 - 1) / 2, 48
SURE = 2e-8
"""Heights of which the sign is taken for certain."""
SHARES = 1e-5, 0.3, 0.7
"""Of the time between two ends: where its first and last times are looked at."""
Function = Callable[[np.ndarray], np.ndarray]
Place = Callable[[float], np.ndarray]


def stairs_and_pin(rng: Random) -> Scene:
    """A cone on a cylinder, its tip below, that falls, swings or screws into the stairs."""
    random = np.random.default_rng(rng.getrandbits(32))
    corners, faces = stairs(random)
    away = random.integers(-9, 10, 3) * int(random.choice([0, 1, 30]))
    radius, tip = (int(x) for x in random.integers(5, 30, 2))
    start = (random.uniform(-1.5, 1.5, 3) + [0, 0, 2.5]).round(4)
    goal = (random.uniform(-1, 1, 3) * [1, 1, 0.3] - [0, 0, 0.6]).round(4)
    kind, motion, place = _motion(random, start, goal, away)
    source = f"""
slope = F({radius}, {tip}) ** 2
cone = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -slope, 0], [0, 0, 0, 0]])
pin = cone & fc.half_space((0, 0, -1), 0) & fc.half_space((0, 0, 1), 1) & fc.cylinder(F({radius}, 100), 4)
a = pin.translated({(start + away).tolist()}).moving({motion})
b = fc.Polyhedron({corners.tolist()}, {faces}).translated({away.tolist()})
span = None
"""
    triangles = corners[np.array(faces)]

    def height(t: float) -> float:
        """Of the lowest point of the stairs over the pin's surface, at most 0 where they meet; at most 1/20."""
        pose = place(t)
        return _height((triangles - pose[:3, 3]) @ pose[:3, :3] - start, radius / 100, tip / 100)

    def first(hit: Any) -> str | None:
        end = 1.0 if hit.status.name == "FREE" else hit.free_until
        return _wrong_signs(height, [(0.0, end, False)])

    def all_times(found: Any) -> str | None:
        until = found.free_until if found.reason is not None else 1.0
        ends = [0.0, *(t for x in found for t in (x.start, x.end)), until]
        return _wrong_signs(height, [(s, t, k % 2 == 1) for k, (s, t) in enumerate(zip(ends, ends[1:], strict=False))])

    calls = ("fc.first_contact(a, b, span)", first), ("fc.contact_intervals(a, b, span)", all_times)
    return Scene(source, kind, tuple(Question(*call) for call in calls))


def stairs(random: np.random.Generator) -> tuple[np.ndarray, list[tuple[int, int, int]]]:
    """Vertices (2 n, 3) and triangles: n steps, turned somehow."""
    n = int(random.integers(10, 40))
    x, z = np.sort(random.uniform(-1, 1, n)), np.cumsum(random.choice([0.0, 0.1, -0.1], n))
    corners = np.array([(x[k], y, z[k]) for k in range(n) for y in (-3, 3)])
    turn = np.linalg.qr(random.normal(size=(3, 3)) * [1, 1, 0.3] + 2 * np.eye(3))[0]
    faces = [t for k in range(0, 2 * n - 2, 2) for t in ((k, k + 1, k + 2), (k + 1, k + 3, k + 2))]
    return (corners @ turn.T).round(4), faces


def _motion(
    random: np.random.Generator, start: np.ndarray, goal: np.ndarray, away: np.ndarray
) -> tuple[str, str, Place]:
    """(kind, text, pose (4, 4) at a time without the shift of all) of one that brings the tip near the goal."""
    kind = str(random.choice(["translation", "rotation", "screw"]))
    pose = np.eye(4)
    if kind == "translation":
        way = goal - start

        def shifted(t: float) -> np.ndarray:
            return np.block([[np.eye(3), (t * way)[:, None]], [pose[3:]]])

        return kind, f"fc.Translation({way.tolist()})", shifted
    axis = np.cross(goal - start, random.normal(size=3)).round(2)
    point = ((start + goal) / 2 + np.cross(axis, goal - start) * random.uniform(-0.3, 0.3)).round(2)
    degrees = int(random.choice([120, 180, 200, -150]))
    advance = round(float(random.uniform(-0.5, 0.5)), 2) if kind == "screw" else 0.0
    n = axis / np.linalg.norm(axis)
    across = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])

    def turned(t: float) -> np.ndarray:
        angle = np.radians(degrees * t)
        turn = np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across
        return np.block([[turn, (point - turn @ point + advance * t * n)[:, None]], [pose[3:]]])

    ahead = f", advance={advance}" if kind == "screw" else ""
    name = "fc.Screw" if kind == "screw" else "fc.Rotation"
    return kind, f"{name}({axis.tolist()}, {(point + away).tolist()}, degrees={degrees}{ahead})", turned


def _wrong_signs(height: Callable[[float], float], times: list[tuple[float, float, bool]]) -> str | None:
    for lo, hi, contact in times:
        for share in (SHARES[0], *SHARES[1:], 1 - SHARES[0]):
            t = lo + share * (hi - lo)
            there = height(t)
            if hi > lo and abs(there) > SURE and (there < 0) is not contact:
                return f"{'apart' if contact else 'in contact'} at {t}, by a height of {there}"
    return None


def _height(triangles: np.ndarray, radius: float, tip: float) -> float:
    lo, hi = triangles.min(axis=1), triangles.max(axis=1)
    room = np.array([radius, radius, 0.5]) + 0.05
    near = triangles[np.all((lo < [0, 0, 0.5] + room) & (hi > [0, 0, 0.5] - room), axis=1)]
    if not len(near):
        return 0.05
    p, u, v = near[:, 0], near[:, 1] - near[:, 0], near[:, 2] - near[:, 0]

    def over(x: np.ndarray) -> np.ndarray:
        out, z = np.hypot(x[:, 0], x[:, 1]), x[:, 2]
        return np.max([out - radius / tip * z, out - radius, z - 1, -z], axis=0)

    def least_across(s: np.ndarray) -> np.ndarray:
        return _least(lambda t: over(p + s[:, None] * u + t[:, None] * v), 1 - s)

    return min(0.05, float(_least(least_across, np.ones(len(p))).min()))


def _least(f: Function, hi: np.ndarray) -> np.ndarray:
    """(n,) least values of n convex functions between 0 and each of `hi`, by golden sections."""
    lo = np.zeros_like(hi)
    x, y = hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo)
    fx, fy = f(x), f(y)
    for _ in range(ROUNDS):
        left = fx < fy
        lo, hi = np.where(left, lo, x), np.where(left, y, hi)
        new = np.where(left, hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo))
        at = f(new)
        x, y, fx, fy = np.where(left, new, y), np.where(left, x, new), np.where(left, at, fy), np.where(left, fx, at)
    least: np.ndarray = np.minimum(fx, fy)
    return least
