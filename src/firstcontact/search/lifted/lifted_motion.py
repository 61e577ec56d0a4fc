"""Queries of cells of edges or facets under the two motions: what an edge or corner of either body sweeps.

A translation is one arc; a rotation is searched arc by arc.  Both are of one type (`swept_cell.turns`): what searches
by lines and planes, much code of which little depends on the motion, is compiled once.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.angle import ANGLE_EPS
from firstcontact.kernels.jit import inlined, uncounted
from firstcontact.kernels.lifted.query import write_segment, write_swept_edge, write_turned_edge, write_turned_point
from firstcontact.kernels.lifted.swept_cell import axis_of, turns
from firstcontact.search.trees.rotate import turning_events
from firstcontact.search.trees.state import BEST, FIRST, KEY
from firstcontact.search.trees.translate import shifting_events

# An arc turns by 2 atan(1/5): its cosine and sine are rational.  Sixteen make more than a full turn.
ARC_ANGLE, ARC_TANGENT = 0.3947911196997615, 0.2
ARCS = 16
# Slots of where a stands (`place_at`).
PLACE = 8


def _arc_starts() -> np.ndarray:
    """Cosine and sine where each arc starts, rounded once."""
    x, y, whole, rows = 1, 0, 1, []
    for _ in range(ARCS + 1):
        rows.append((x / whole, y / whole))
        x, y, whole = 12 * x - 5 * y, 5 * x + 12 * y, 13 * whole
    return np.array(rows)


ARC_STARTS = _arc_starts()


def arc_of(motion: np.ndarray, floats: np.ndarray, arc: int) -> tuple[bool, bool]:
    """(whether there is such an arc before the best time, whether it ends before the window begins)."""
    if len(motion) == 1:
        return arc == 0, False
    # products of whole numbers and the arc's angle round once; times are within ANGLE_EPS
    start = arc * ARC_ANGLE - 4.0 * ANGLE_EPS
    over = (arc + 1) * ARC_ANGLE + 4.0 * ANGLE_EPS < floats[FIRST]
    exists = arc < ARCS and start <= floats[BEST]
    if exists and not over:
        floats[KEY] = max(floats[KEY], start)
    return exists, over


@inlined
def test_pair(motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates):
    """`test_events` of `search.trees.walk`."""
    if turns(motion):
        turning_events(motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates)
    else:
        shifting_events(
            motion[0], pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
        )


test_pair.__test__ = False  # no test, whatever its name says to collectors


@uncounted
def lay_edge(motion, arc, x, y, sense, reach, floats, origin, scale, query, work):
    """Write the query for the edge from x to y of a (sense 1), or of b (sense -1: it moves the other way past a)."""
    if turns(motion):
        _lay_turned_edge(motion, arc, x, y, sense, floats, origin, scale, query, work)
    else:
        _shifts(motion[0], sense, reach, floats, work)
        write_swept_edge(query, x, y, work[0], work[1], origin, scale)


@uncounted
def lay_corner(motion, arc, x, sense, reach, floats, origin, scale, query, work):
    """The same for a corner x."""
    if turns(motion):
        _lay_turned_corner(motion, arc, x, sense, floats, origin, scale, query, work)
    else:
        _shifts(motion[0], sense, reach, floats, work)
        write_segment(query, x, work[0], work[1], origin, scale)


@uncounted
def lay_path(motion, arc, x, sense, reach, floats, work):
    """Write points whose hull holds the path of the corner x into rows of work, the last one its end; how many."""
    if turns(motion):
        return _lay_arc(motion, arc, x, sense, floats, work)
    _shifts(motion[0], sense, reach, floats, work)
    for k in range(3):
        work[0, k] += x[k]
        work[1, k] += work[0, k]
    return 2


@uncounted
def times_of(motion, arc, reach, floats):
    """The times of the arc, from the key to the best time."""
    if not turns(motion):
        return floats[KEY], max(floats[KEY], min(floats[BEST], reach))
    first, last = arc * ARC_ANGLE - 4.0 * ANGLE_EPS, (arc + 1) * ARC_ANGLE + 4.0 * ANGLE_EPS
    return first, max(first, min(floats[BEST], last))


@uncounted
def place_at(motion, t, place):
    """Write where a stands at a time: whether turned, cosine, sine, axis x and y, shift (3)."""
    place[0], place[1], place[2] = 0.0, 1.0, 0.0
    place[3], place[4] = axis_of(motion)
    if turns(motion):
        place[0], place[1], place[2] = 1.0, np.cos(t), np.sin(t)
        place[5], place[6], place[7] = 0.0, 0.0, 0.0
    else:
        for k in range(3):
            place[5 + k] = t * motion[0, 6 + k]


@uncounted
def drift(motion, box, duration, way):
    """Write the least and largest displacement (3 each) of a point of a that is in the box at one of two times, from

    one to the other; returns the largest.
    """
    if turns(motion):
        # no farther than the chord, which is shorter than the arc and than the diameter
        cx, cy = axis_of(motion)
        x, y = max(abs(box[0] - cx), abs(box[3] - cx)), max(abs(box[1] - cy), abs(box[4] - cy))
        d = min(duration, 2.0) * np.sqrt(x * x + y * y) * (1.0 + 1e-14)
        way[0], way[1], way[2], way[3], way[4], way[5] = -d, -d, 0.0, d, d, 0.0
        return d
    for k in range(3):
        d = duration * motion[0, 6 + k]
        way[k], way[k + 3] = min(d, 0.0), max(d, 0.0)
    return max(max(way[3], way[4], way[5]), -min(way[0], way[1], way[2]))


@uncounted
def _shifts(motion, sense, reach, floats, work):
    """Write how far a moves until the window begins, and from there to its end."""
    lo = floats[KEY]
    hi = max(lo, min(floats[BEST], reach))
    for k in range(3):
        work[0, k], work[1, k] = sense * lo * motion[6 + k], sense * (hi - lo) * motion[6 + k]


# ------------------------------------------------------------------------------------------------- rotation


@uncounted
def arc_tangent(arc, floats):
    """tan of half the angle from the start of the arc to its end or the best time: not less, at most 0.2 or so.

    For x <= 0.2, x (1 + x^2/3 + 2 x^4/15 + 17 x^6/315 + 62 x^8/2835 + 0.0091 x^10) is beyond tan x.
    """
    x = 0.5 * (floats[BEST] - arc * ARC_ANGLE) + 8.0 * ANGLE_EPS
    if not x < 0.5 * ARC_ANGLE:
        return ARC_TANGENT * (1.0 + 1e-12)
    x = max(x, 8.0 * ANGLE_EPS)
    s = x * x
    p = 1.0 + s * (1.0 / 3.0 + s * (2.0 / 15.0 + s * (17.0 / 315.0 + s * (62.0 / 2835.0 + s * 0.0091))))
    return x * p * (1.0 + 1e-13)


@uncounted
def _turned(x, c, s, cx, cy, place, out):
    """Write the point x, turned about (cx, cy), into row `place` of out, and its velocity there into the next."""
    p, q = x[0] - cx, x[1] - cy
    out[place, 0], out[place, 1], out[place, 2] = cx + (c * p - s * q), cy + (s * p + c * q), x[2]
    out[place + 1, 0], out[place + 1, 1], out[place + 1, 2] = -(s * p + c * q), c * p - s * q, 0.0


@uncounted
def _turns(motion, arc, sense, floats):
    """cx, cy of the axis; cosine and sine of the turn to the start of the arc; those of the turn from there; tan."""
    cx, cy = axis_of(motion)
    tc = arc_tangent(arc, floats)
    w = 1.0 / (1.0 + tc * tc)
    c, s = ARC_STARTS[arc, 0], sense * ARC_STARTS[arc, 1]
    return cx, cy, c, s, (1.0 - tc * tc) * w, sense * 2.0 * tc * w, tc


@uncounted
def _lay_turned_edge(motion, arc, x, y, sense, floats, origin, scale, query, work):
    cx, cy, c, s, dc, ds, tc = _turns(motion, arc, sense, floats)
    _turned(x, c, s, cx, cy, 0, work)
    _turned(y, c, s, cx, cy, 2, work)
    _turned(work[0], dc, ds, cx, cy, 4, work)
    _turned(work[2], dc, ds, cx, cy, 6, work)
    for k in range(2):
        work[1, k], work[3, k] = sense * work[1, k], sense * work[3, k]
    write_turned_edge(query, work[0], work[2], work[1], work[3], work[4], work[6], tc, origin, scale)


@uncounted
def _lay_turned_corner(motion, arc, x, sense, floats, origin, scale, query, work):
    cx, cy, c, s, dc, ds, tc = _turns(motion, arc, sense, floats)
    _turned(x, c, s, cx, cy, 0, work)
    _turned(work[0], dc, ds, cx, cy, 2, work)
    for k in range(2):
        work[1, k] *= sense
    write_turned_point(query, work[0], work[1], work[2], tc, origin, scale)


@uncounted
def _lay_arc(motion, arc, x, sense, floats, work):
    # an arc lies in the triangle of its ends and the point where its tangents there meet
    cx, cy, c, s, dc, ds, tc = _turns(motion, arc, sense, floats)
    _turned(x, c, s, cx, cy, 0, work)
    _turned(work[0], dc, ds, cx, cy, 2, work)
    for k in range(3):
        work[1, k] = work[0, k] + tc * sense * work[1, k]
    return 3
