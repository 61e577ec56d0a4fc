"""Chords of certified curves: bounds on how fast an arc bends, and how far it leaves its polyline."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.curves.certified import arcs
from firstcontact.curves.certified.chains import chains
from firstcontact.curves.certified.settled import Settled
from firstcontact.kernels.curves import bends as curve_bends
from firstcontact.kernels.curves import points as columns


def waves(seed: int, weighted: bool):
    rng, surfaces = np.random.default_rng(seed), []
    for along in (0, 1):
        grid = np.zeros((6, 2, 3))
        grid[:, :, along] = np.arange(6)[:, None]
        grid[:, :, 1 - along] = [-1, 6]
        grid[:, :, 2] = rng.uniform(-0.5, 0.5, (6, 2))
        weights = rng.integers(2, 5, (6, 2)).tolist() if weighted else None
        surfaces.append(fc.RuledSurface.from_nurbs(grid.tolist(), [0] * 4 + [1, 2] + [3] * 4, weights))
    return surfaces


class Arcs:
    """The arcs of a curve, with the arrays that kernels take."""

    def __init__(self, p, q, tolerance: float) -> None:
        a, b = chains(p)[0], chains(q)[0]
        self.solved = arcs.traced(arcs.searched(a, b, Settled(a, b, tolerance)), tolerance)
        low, high = np.maximum(a.box[0], b.box[0]), np.minimum(a.box[1], b.box[1])
        self.forms = [arcs.begun(x, 0.5 * (low + high), 4)[1] for x in (a, b)]
        self.bends = [np.empty((len(x), curve_bends.BOUNDS)) for x in self.forms]
        for form, bend in zip(self.forms, self.bends, strict=True):
            curve_bends.derivative_bounds(form, bend)
        self.scratch, self.row = np.empty((columns.SCRATCH_ROWS, 16)), np.empty(columns.COLUMNS)
        self.kept = [k for k, arc in enumerate(self.solved.arcs) if arc[columns.START] >= 0]

    def ends(self, k: int):
        """The side the arc runs over, and both ends."""
        arc, rows = self.solved.arcs[k], np.empty((2, columns.COLUMNS))
        for at, row in zip((columns.START, columns.END), rows, strict=True):
            columns.enter(arc, self.solved.places[int(arc[at])], row)
        return int(arc[columns.OVER]), rows

    def at(self, k: int, run: float, guess: float) -> np.ndarray:
        columns.on_arc(*self.forms, self.solved.arcs[k], run, guess, self.scratch, self.row)
        return self.row.copy()

    def bound(self, k: int, run: float, guess: float, reach: float) -> float:
        """On the fourth derivative."""
        over, arc, here = int(self.solved.arcs[k][columns.OVER]), self.solved.arcs[k], self.at(k, run, guess)
        sides = [(self.forms[i], int(arc[(columns.ARC_U, columns.ARC_V)[i]])) for i in (over, 1 - over)]
        bends = [self.bends[i][part] for i, (_, part) in zip((over, 1 - over), sides, strict=True)]
        f, m = np.int64(over), np.int64(1 - over)
        columns.evaluate(*sides[0], run, f, columns.YES, self.scratch)
        positions = here[[columns.T, columns.S] if over else [columns.S, columns.T]]
        return curve_bends.fourth_derivative(
            *sides[0], run, *sides[1], here[columns.X if over else columns.Y], f, m, *bends, reach, *positions,
            self.scratch,
        )  # fmt: skip


@pytest.mark.share(2)
@pytest.mark.parametrize("weighted", [False, True])
def test_the_fourth_derivative_is_below_its_bound(weighted):
    """Fourth differences of points are means of the fourth derivative."""
    rng, seen, close = np.random.default_rng(1), 0, 0
    for seed in range(amount(40, 6)):
        arcs = Arcs(*waves(seed, weighted), 1e-3)
        for k in arcs.kept:
            over, (start, end) = arcs.ends(k)
            run, other = (columns.Y, columns.X) if over else (columns.X, columns.Y)
            low, high = sorted((start[run], end[run]))
            reach = min(0.02, 0.4 * (high - low))
            if reach < 0.002:
                continue
            middle, guess = rng.uniform(low + reach, high - reach), 0.5 * (start[other] + end[other])
            bound = arcs.bound(k, middle, guess, reach)
            points = [arcs.at(k, middle + 0.5 * reach * i, guess)[columns.POINT : columns.GAP] for i in range(-2, 3)]
            difference = np.array([1, -4, 6, -4, 1]) @ points
            found = np.linalg.norm(difference) / (0.5 * reach) ** 4
            assert found <= bound + 1e-13 / (0.5 * reach) ** 4
            seen += np.isfinite(bound)
            close += bound < 1e4 * found
    assert seen > amount(40, 6) and close > seen // 4


@pytest.mark.share(2)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
@pytest.mark.parametrize("weighted", [False, True])
def test_arcs_stay_within_the_tolerance_of_their_chords(weighted, tolerance):
    worst = 0.0
    for seed in range(amount(30, 6)):
        arcs = Arcs(*waves(seed, weighted), tolerance)
        solved, rng = arcs.solved, np.random.default_rng(seed)
        for k in arcs.kept:
            over, (start, end) = arcs.ends(k)
            run, other = (columns.Y, columns.X) if over else (columns.X, columns.Y)
            own = slice(*solved.rows[k])
            points, chain, sign = solved.points[own], (solved.p, solved.q)[over], -1 if solved.turned[k] else 1
            points, ends = points[::sign], solved.parameters[own, over][::sign]
            part = int(solved.arcs[k][columns.ARC_V if over else columns.ARC_U])
            first, last = chain.parameter(np.array([part] * 2), np.array([0.0, 1.0]))
            assert chain.ranges[part, 0, 1] == chain.ranges[part, 1, 1]  # x is linear in the parameter
            x = (ends - first) / (last - first)
            assert x[[0, -1]] == pytest.approx([start[run], end[run]], abs=1e-9)
            for n in rng.integers(0, len(points) - 1, 12):
                for share in (0.2, 0.45, 0.55, 0.8):
                    at = x[n] + share * (x[n + 1] - x[n])
                    point = arcs.at(k, at, 0.5 * (start[other] + end[other]))[columns.POINT : columns.GAP]
                    point = point + (points[0] - start_point(arcs, k))
                    along = points[n + 1] - points[n]
                    t = np.clip((point - points[n]) @ along / max(along @ along, 1e-300), 0, 1)
                    worst = max(worst, np.linalg.norm(points[n] + t * along - point))
    assert 0.3 * tolerance < worst <= tolerance


def test_branches_keep_no_rows_but_their_own():
    curve = fc.intersection_curve(*waves(0, False), method="certified")
    shown = sum(len(branch.points) for branch in curve.branches)
    assert shown > 100
    for branch in curve.branches:
        for table in (branch.points, branch.parameters):
            assert len(table if table.base is None else table.base) <= shown + len(curve.branches)


def start_point(arcs: Arcs, k: int) -> np.ndarray:
    """Of an arc, about the kernels' centre."""
    return arcs.ends(k)[1][0][columns.POINT : columns.GAP]
