"""Programs of G-code, beside lists of ways written by hand."""

import math
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.exact.numbers import to_double
from firstcontact.toolpath.moves import ArcMove, Bow, StraightMove


def blocks_of(tmp_path, text, start=(0, 0, 50), unit="mm"):
    file = tmp_path / "job.nc"
    file.write_text(text, encoding="utf-8")
    return list(fc.ToolPath(file, start=start, unit=unit))


def ways(blocks):
    """(line, kind, end) of each straight way."""
    return [(x.line, way.kind, tuple(map(to_double, way.end))) for x in blocks for way in x.stretches]


PROGRAMS = {
    "modal words and comments": (
        "%\nO7 (a program)\nN10 G21 G90 (mm) G0 X1. Y2 ; to the place\nZ10\n(nothing)\nN30G1Z-1.5F200\nx3\n\nG0Z5\n%",
        [(3, "rapid", (1, 2, 50)), (4, "rapid", (1, 2, 10)), (6, "feed", (1, 2, -1.5)), (7, "feed", (3, 2, -1.5)),
         (9, "back", (3, 2, 5))],
    ),
    "incremental": (
        "G91 G0 X5\nG1 X-2 Z-10\nX-2\nG90 X0",
        [(1, "rapid", (5, 0, 50)), (2, "feed", (3, 0, 40)), (3, "feed", (1, 0, 40)), (4, "feed", (0, 0, 40))],
    ),
    "inches": ("G20 G0 X1 Y-.5\nG21 X1", [(1, "rapid", (25.4, -12.7, 50)), (2, "rapid", (1, -12.7, 50))]),
    "dwell and words that move nothing": (
        "G0 X1\nG4 P1.5\nG54 G40 G43 H2 G64 M8 S9000 T3\nM6\nX2",
        [(1, "rapid", (1, 0, 50)), (5, "rapid", (2, 0, 50))],
    ),
    "G81 with G98 and G99": (
        "G0 Z12\nG99 G81 X1 Y1 Z-3 R2\nX4\nG98 X7\nG80 G0 X0",
        [(1, "rapid", (0, 0, 12)),
         (2, "rapid", (1, 1, 12)), (2, "rapid", (1, 1, 2)), (2, "feed", (1, 1, -3)), (2, "back", (1, 1, 2)),
         (3, "rapid", (4, 1, 2)), (3, "feed", (4, 1, -3)), (3, "back", (4, 1, 2)),
         (4, "rapid", (7, 1, 2)), (4, "feed", (7, 1, -3)), (4, "back", (7, 1, 12)),
         (5, "rapid", (0, 1, 12))],
    ),
    "G82 below R, incremental": (
        "G0 Z10\nG91 G82 X2 R-6 Z-5 P0.2 F50\nX3",
        [(1, "rapid", (0, 0, 10)),
         (2, "rapid", (2, 0, 10)), (2, "rapid", (2, 0, 4)), (2, "feed", (2, 0, -1)), (2, "back", (2, 0, 10)),
         (3, "rapid", (5, 0, 10)), (3, "rapid", (5, 0, 4)), (3, "feed", (5, 0, -1)), (3, "back", (5, 0, 10))],
    ),
    "G83": (
        "G0 Z5\nG83 X1 Z-5 R1 Q2.5",
        [(1, "rapid", (0, 0, 5)),
         (2, "rapid", (1, 0, 5)), (2, "rapid", (1, 0, 1)),
         (2, "feed", (1, 0, -1.5)), (2, "back", (1, 0, 1)), (2, "back", (1, 0, -1.5)),
         (2, "feed", (1, 0, -4)), (2, "back", (1, 0, 1)), (2, "back", (1, 0, -4)),
         (2, "feed", (1, 0, -5)), (2, "back", (1, 0, 5))],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "wanted"), PROGRAMS.values(), ids=PROGRAMS)
def test_ways_are_those_written_by_hand(tmp_path, text, wanted):
    found = ways(blocks_of(tmp_path, text))
    assert [(x[0], x[1]) for x in found] == [(x[0], x[1]) for x in wanted]
    for (_, _, end), (_, _, place) in zip(found, wanted, strict=True):
        assert end == pytest.approx(place, abs=1e-13)


def test_ways_join(tmp_path):
    for text, _ in PROGRAMS.values():
        at = None
        for block in blocks_of(tmp_path, text):
            for way in block.stretches:
                assert isinstance(way, StraightMove) and at in (None, way.start)
                at = way.end


def test_coordinates_are_the_decimals_of_the_text(tmp_path):
    (block,) = blocks_of(tmp_path, "G1 X0.1 Y-12.30 Z+.7 F1")
    assert tuple(Fraction(int(c.p), int(c.q)) for c in block.stretches[0].end) == (
        Fraction(1, 10), Fraction(-123, 10), Fraction(7, 10),
    )  # fmt: skip


def test_a_scene_in_inches(tmp_path):
    (block,) = blocks_of(tmp_path, "G21 G0 X25.4", unit="inch")
    assert block.stretches[0].end[0] == 1


ARCS = {
    "ccw quarter by I J": ("G3 X0 Y5 I-5 J0", (0, 0), 5, 90, 0),
    "cw three quarters by I J": ("G2 X0 Y5 I-5 J0", (0, 0), 5, -270, 0),
    "ccw quarter by R": ("G3 X0 Y5 R5", (0, 0), 5, 90, 0),
    "ccw large by R": ("G3 X0 Y5 R-5", (5, 5), 5, 270, 0),
    "cw quarter by R": ("G2 X0 Y5 R5", (5, 5), 5, -90, 0),
    "cw large by R": ("G2 X0 Y5 R-5", (0, 0), 5, -270, 0),
    "half by R": ("G3 X-5 Y0 R5", (0, 0), 5, 180, 0),
    "absolute centre": ("G90.1 G3 X0 Y5 I0 J0", (0, 0), 5, 90, 0),
    "helix": ("G2 X0 Y-5 Z-2 I-5", (0, 0), 5, -90, -2),
}


@pytest.mark.parametrize(("text", "centre", "radius", "degrees", "advance"), ARCS.values(), ids=ARCS)
def test_arcs(tmp_path, text, centre, radius, degrees, advance):
    (block,) = blocks_of(tmp_path, text, start=(5, 0, 0))
    (arc,) = block.stretches
    assert isinstance(arc, ArcMove) and arc.kind == "feed"
    assert [to_double(x) for x in arc.centre[:2]] == pytest.approx(centre, abs=1e-15)
    assert (arc.radius, math.degrees(arc.angle)) == pytest.approx((radius, degrees))
    assert arc.tip(0.0) == pytest.approx((5, 0, 0)) and arc.deviation < 1e-14
    whole = math.radians(degrees)
    for t in (0.0, 0.3, 0.7, 1.0):
        x, y = 5 - centre[0], -centre[1]
        c, s = math.cos(whole * t), math.sin(whole * t)
        wanted = centre[0] + c * x - s * y, centre[1] + s * x + c * y, advance * t
        assert arc.tip(t) == pytest.approx(wanted, abs=1e-12)


def test_a_full_circle_is_one_turn(tmp_path):
    (block,) = blocks_of(tmp_path, "G2 I-5", start=(5, 0, 0))
    assert block.stretches[0].turns == -1 and block.stretches[0].length == pytest.approx(10 * math.pi)


@pytest.mark.parametrize(("plane", "text", "normal"), [
    ("G18", "G3 X5 Z5 I5 K0", (0, 1, 0)), ("G18", "G2 X5 Z5 I5 K0", (0, -1, 0)),
    ("G19", "G3 Y5 Z5 J5 K0", (1, 0, 0)), ("G19", "G2 Y5 Z-5 J5 K0 X1", (-1, 0, 0)),
])  # fmt: skip
def test_arcs_in_planes_that_hold_the_axis(tmp_path, plane, text, normal):
    """From the origin about (5 along the first axis): points keep their distance, and the sense is right-handed."""
    (block,) = blocks_of(tmp_path, f"{plane} {text}", start=(0, 0, 0))
    centre = [0.0, 0.0, 0.0]
    centre[0 if plane == "G18" else 1] = 5.0
    across = [k for k in range(3) if not normal[k]]
    ends = {word[0]: float(word[1:]) for word in text.split()[1:] if word[0] in "XYZ"}
    assert all(isinstance(way, Bow) for way in block.stretches)
    before = None
    for way in block.stretches:
        assert before is None or before == way.start
        before = way.end
        for t in (0.0, 0.4, 1.0):
            out = [way.tip(t)[k] - centre[k] for k in across]
            assert math.hypot(*out) == pytest.approx(5.0, abs=1e-12)
    first = block.stretches[0]
    out = [a - b for a, b in zip(first.tip(0.0), centre, strict=True)]
    step = [a - b for a, b in zip(first.tip(0.01), first.tip(0.0), strict=True)]
    assert np.cross(out, step) @ normal > 0
    wanted = [ends.get(x, 0.0) for x in "XYZ"]
    assert block.stretches[-1].tip(1.0) == pytest.approx(wanted, abs=1e-12)


FAULTS = {
    "G41 X1": "line 1: G41: not read",
    "G0 X1\nG1 A5": "line 2: A5: not read",
    "G0 X#1": "line 1: X#1: not read",
    "X1": "line 1: X1: no motion is chosen",
    "G0 X1 X2": "line 1: X2: a second X",
    "G0 G1 X1": "line 1: G1: beside G0",
    "G1 G90 G91 X1": "line 1: G91: beside G90 in one block; give one of them",
    "G1 G21 G20 X1": "line 1: G20: beside G21 in one block",
    "G17 G18 G1 X1": "line 1: G18: beside G17 in one block",
    "G0 X1 I2": "line 1: I2: does not go with G0",
    "G2 X1": "line 1: G2: an arc without centre",
    "G2 X1 Y0 I5 R5": "line 1: R5: beside I, J or K",
    "G2 X1 Y0 I5": "line 1: I5: the end is",
    "G2 X0 Y0 I0 J0": "line 1: I0: a circle of radius 0",
    "G2 X30 R5": "line 1: R5: the end is farther away than two radii",
    "G2 X0 Y0 R5": "line 1: R5: the arc ends where it begins",
    "G2 I5 K1": "line 1: K1: not in the plane G17",
    "G0 X1\n\nG54\nG55 X1": "line 4: G55: another zero than G54",
    "G81 X1 Z-5": "line 1: G81: R is missing",
    "G81 X1 Z5 R1": "line 1: G81: Z is above R",
    "G83 X1 Z-5 R1": "line 1: G83: Q is missing",
    "G81 X1 Z-5 R1 L3": "line 1: L3: repeated cycles",
    "M98 P100": "line 1: M98: subprograms",
    "G92 X0": "line 1: G92: not read",
    "G76 X1 Z-5": "line 1: G76: not read",
    "G1 X[1+2]": "line 1: X[1+2]: not read",
    "R5": "line 1: R5: no X, Y or Z",
    "G1 X1 M30\nG4 P1\nG1 X9": "line 3: X9: after M30, where the program ends",
    "G1 X1\nM02\n(part 2)\nY1": "line 4: Y1: after M02, where the program ends",
    "G2 X10 I5 M30\nI3": "line 2: I3: after M30",
    "%\nG1 X1\n%\nX2": "line 4: X2: after %, where the program ends",
}


@pytest.mark.parametrize("text", FAULTS, ids=FAULTS)
def test_what_is_not_read_stops_with_line_and_word(tmp_path, text):
    with pytest.raises(fc.InputError, match="job.nc: ") as error:
        blocks_of(tmp_path, text)
    assert FAULTS[text] in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(("digits", "what"), [
    ("0." + "3" * 4999, "X0.333333333333333333...: a number of 5001 digits; give at most 4000"),
    ("-1" + "0" * 400, "X-1000000000000000000...: give a number below 2^150"),
])  # fmt: skip
def test_numbers_that_are_too_long_or_too_large(tmp_path, digits, what):
    with pytest.raises(fc.InputError, match="job.nc: ") as error:
        blocks_of(tmp_path, f"G0 X1\nG0 X{digits} Y0")
    assert str(error.value).endswith(f"line 2: {what}")


def test_places_that_the_program_does_not_tell_are_unknown(tmp_path):
    blocks = blocks_of(tmp_path, "G0 X1 Y1\nZ5\nG1 X2\nG28 Z0\nX3\nZ5\nX4\nG53 G0 Z0\nG0 X0 Y0 Z50\nX1", start=None)
    assert [bool(x.unknown) for x in blocks] == [True, True, False, True, True, True, False, True, True, False]
    assert all(not x.stretches for x in blocks if x.unknown)


def test_a_cycle_from_an_unknown_height_leaves_the_tool_where_it_tells(tmp_path):
    blocks = blocks_of(tmp_path, "G99 G81 X1 Y1 Z-3 R2\nX4\nG80", start=None)
    assert [bool(x.unknown) for x in blocks] == [True, False]
    assert blocks[1].stretches[0].start == (1, 1, 2)


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(fc.InputError, match="programs end with"):
        fc.ToolPath(tmp_path / "job.docx")
    with pytest.raises(fc.InputError, match="no such file"):
        list(fc.ToolPath(tmp_path / "job.nc"))
