"""Boxes of rational curves, and of the surfaces between them, rounded outward: hulls of exact Bernstein nets."""

from __future__ import annotations

import math

import numpy as np
from flint import fmpq

from firstcontact.body.ruled.rational_curve import RationalCurve, terms
from firstcontact.errors import InputError
from firstcontact.exact.numbers import above, below, to_double
from firstcontact.exact.polynomials import bernstein

Range = tuple[fmpq, fmpq]
Box = tuple[np.ndarray, np.ndarray]

# Equal parts of the parameter, and of the time of a deforming curve, whose nets are taken: fewer give wider boxes.
PARTS_U, PARTS_T = 4, 4
# Halvings after which a weight that is not proved positive counts as zero somewhere: 2^-40 of the range.
MOST_HALVINGS = 40


def curve_box(curve: RationalCurve, u: Range, span: Range) -> Box:
    """Lower and upper corner, (3,) float64 each, of a box that holds the curve over u, at all times of the span.

    InputError where it is not proved that its weight has no zero there: deforming curves may have poles at times.
    """
    # a zero of the weight at this point would be a pole, and found below
    curve = curve.positive_at(_within(u), _within(span))
    degrees = [max(key[k] for x in curve.components for key in terms(x)) for k in (0, 1)]
    times = _parts(span, PARTS_T) if curve.deforming else [(span[0], span[0])]
    waiting = [(x, y, 0) for x in _parts(u, PARTS_U) for y in times]
    lo, hi = [math.inf] * 3, [-math.inf] * 3
    # Boxes waiting or done cover the range; each turn finishes one, or halves it where its weights are not positive.
    while waiting:
        x, y, halvings = waiting.pop()
        nets = [
            [c for row in bernstein.grid(terms(p), x, y, (degrees[0], degrees[1])) for c in row]
            for p in curve.components
        ]
        if min(nets[3]) <= 0:
            if halvings == MOST_HALVINGS:
                raise InputError(_pole(x, y, curve.deforming))
            in_time = curve.deforming and (y[1] - y[0]) * (u[1] - u[0]) > (x[1] - x[0]) * (span[1] - span[0])
            halves = [(x, part) for part in _parts(y, 2)] if in_time else [(part, y) for part in _parts(x, 2)]
            waiting += [(*half, halvings + 1) for half in halves]
            continue
        for k in range(3):
            values = [c / w for c, w in zip(nets[k], nets[3], strict=True)]
            lo[k], hi[k] = min(lo[k], below(min(values))), max(hi[k], above(max(values)))
    return np.array(lo), np.array(hi)


def hull(boxes: list[Box]) -> Box:
    """The box of boxes."""
    return np.min([lo for lo, _ in boxes], axis=0), np.max([hi for _, hi in boxes], axis=0)


def _within(ends: Range) -> fmpq:
    return ends[0] + (ends[1] - ends[0]) * fmpq(3, 7)


def _parts(ends: Range, n: int) -> list[Range]:
    lo, width = ends[0], (ends[1] - ends[0]) / n
    return [(lo + k * width, lo + (k + 1) * width) for k in range(n)]


def _pole(u: Range, t: Range, deforming: bool) -> str:
    when = f", T = {to_double(t[0]):.6g}" if deforming else ""
    return f"a directrix has a pole near u = {to_double(u[0]):.6g}{when}; give a range or span without it"
